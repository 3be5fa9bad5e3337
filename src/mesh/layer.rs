//! Layers: isosurfaces of values that are linear in each tetrahedron, by marching tetrahedra \[LST 4.4\].

use glam::DVec3;

use super::{TET_FACES, TetMesh, index};

/// A corner of a layer's triangle: a point of an edge of the mesh, or a vertex.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LayerPoint {
    /// The edge's vertex of lower value.
    pub(crate) from: u32,
    /// Its vertex of higher value; the same one where the layer runs through the vertex.
    pub(crate) to: u32,
    /// How far it is on the way, from 0 to 1. The same in all tetrahedra at the edge.
    pub(crate) part: f64,
}

impl LayerPoint {
    /// Where it is.
    pub(crate) fn place(&self, mesh: &TetMesh) -> DVec3 {
        mesh.vertices[self.from as usize].lerp(mesh.vertices[self.to as usize], self.part)
    }
}

/// A triangle of a layer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LayerTriangle {
    /// The tetrahedron that it lies in.
    pub(crate) tet: u32,
    /// Its corners, in no particular orientation.
    pub(crate) corners: [LayerPoint; 3],
}

/// The triangles on which the values, linear in each tetrahedron, are `level`. A face that lies on the layer as a
/// whole counts, so that the skin is a layer too; inside the mesh it comes from both its tetrahedra.
pub(crate) fn layer(mesh: &TetMesh, values: &[f64], level: f64) -> Vec<LayerTriangle> {
    let mut triangles = Vec::new();
    for (t, tet) in mesh.tets.iter().enumerate() {
        let heights = tet.map(|v| values[v as usize] - level);
        let on: Vec<usize> = (0..4).filter(|k| heights[*k] == 0.0).collect();
        let below: Vec<usize> = (0..4).filter(|k| heights[*k] < 0.0).collect();
        let above: Vec<usize> = (0..4).filter(|k| heights[*k] > 0.0).collect();
        let vertex = |k: usize| LayerPoint { from: tet[k], to: tet[k], part: 0.0 };
        let mut add = |corners| triangles.push(LayerTriangle { tet: index(t), corners });
        if below.is_empty() || above.is_empty() {
            for face in TET_FACES.iter().filter(|f| f.iter().all(|k| on.contains(k))) {
                add(face.map(vertex));
            }
            continue;
        }
        let crossing = |b: usize, a: usize| {
            let part = heights[b] / (heights[b] - heights[a]);
            LayerPoint { from: tet[b], to: tet[a], part }
        };
        // In an order that goes round.
        let mut ring: Vec<LayerPoint> = match (&below[..], &above[..]) {
            (&[b, c], &[a, d]) => vec![crossing(b, a), crossing(b, d), crossing(c, d), crossing(c, a)],
            (below, above) => {
                below.iter().flat_map(|&b| above.iter().map(move |&a| crossing(b, a))).collect()
            }
        };
        ring.extend(on.iter().map(|&k| vertex(k)));
        for k in 2..ring.len() {
            add([ring[0], ring[k - 1], ring[k]]);
        }
    }
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::{ball, grid};

    fn layer(mesh: &TetMesh, values: &[f64], level: f64) -> Vec<[DVec3; 3]> {
        super::layer(mesh, values, level).iter().map(|t| t.corners.map(|c| c.place(mesh))).collect()
    }

    fn area(triangles: &[[DVec3; 3]]) -> f64 {
        triangles.iter().map(|[a, b, c]| 0.5 * (*b - *a).cross(*c - *a).length()).sum()
    }

    #[test]
    fn a_linear_field_has_flat_layers() {
        let mesh = grid(5);
        let slope = DVec3::new(0.3, -0.2, 1.0);
        let values: Vec<f64> = mesh.vertices.iter().map(|p| slope.dot(*p)).collect();
        let triangles = layer(&mesh, &values, 0.45);
        for p in triangles.iter().flatten() {
            assert!((slope.dot(*p) - 0.45).abs() < 1e-12);
        }
        // The plane meets the cube's four sides only: its area is that of the square over cos.
        assert!((area(&triangles) - slope.length()).abs() < 1e-9, "{}", area(&triangles));
        assert!(layer(&mesh, &values, 1.5).is_empty());
    }

    #[test]
    fn layers_through_vertices_have_no_holes() {
        // Lattice planes: every vertex of the layer is one of the mesh.
        let mesh = grid(4);
        let values: Vec<f64> = mesh.vertices.iter().map(|p| (p.x * 4.0).round() / 4.0).collect();
        for level in [0.0, 1.0] {
            assert!((area(&layer(&mesh, &values, level)) - 1.0).abs() < 1e-9);
        }
        // Inside it lies between two tetrahedra and is found from both.
        let inside: Vec<f64> = mesh.vertices.iter().map(|p| (p.x * 4.0).round() / 4.0 - 0.5).collect();
        assert!(area(&layer(&mesh, &inside, 0.0)) > 0.99);
    }

    #[test]
    fn the_layers_of_a_ball_are_spheres() {
        let mesh = ball(3, 6);
        // To 12 digits, so that the skin is exactly 0.
        let depth = |p: &DVec3| ((1.0 - p.length()) * 1e12).round() / 1e12;
        let values: Vec<f64> = mesh.vertices.iter().map(depth).collect();
        let triangles = layer(&mesh, &values, 0.4);
        assert!((area(&triangles) / (4.0 * std::f64::consts::PI * 0.36) - 1.0).abs() < 0.03);
        assert!(triangles.iter().flatten().all(|p| (p.length() - 0.6).abs() < 0.02));
        let skin = layer(&mesh, &values, 0.0);
        assert!(skin.iter().flatten().all(|p| (p.length() - 1.0).abs() < 1e-9) && skin.len() >= 1280);
    }
}
