//! A layer of a solid as a surface to look at \[LST 4.4\].

use std::collections::BTreeMap;

use super::fill::coordinate;
use super::solid::{LappedSolid, interpolate};
use super::vertex::AtVertex;
use crate::mesh::{BoundaryFace, FaceOrigin, LayerPoint, NONE, TetMesh, index, layer};

impl LappedSolid {
    /// The layer of one depth, in [0, 1]: the surface on which the solid has it, seen from both sides, with the texture
    /// and the fields that the solid has there. `None` where it has that depth nowhere.
    ///
    /// It is a surface to draw and no solid: each of its tetrahedra is flat, and carries the colour of one triangle's one
    /// side. It is the surface that strokes on a layer are laid onto (but for the rounding of depths to texture
    /// coordinates, f32).
    #[must_use]
    pub fn isosurface(&self, depth: f64) -> Option<Self> {
        let triangles = layer(&self.mesh, &self.depth, coordinate(depth));
        if triangles.is_empty() {
            return None;
        }
        let mut numbers: BTreeMap<(u32, u32), u32> = BTreeMap::new();
        let mut points: Vec<LayerPoint> = Vec::new();
        let mut mesh = TetMesh::default();
        let mut sheet = Self { layer_start: vec![0], ..self.without_mesh() };
        for triangle in &triangles {
            let [a, b, c] = triangle.corners.map(|p| {
                *numbers.entry((p.from, p.to)).or_insert_with(|| {
                    points.push(p);
                    index(points.len() - 1)
                })
            });
            let parent = triangle.tet as usize;
            // Where each corner is in the tetrahedron.
            let [u, v, w] = triangle.corners.map(|p| {
                let place = |vertex| self.mesh.tets[parent].iter().position(|t| *t == vertex).unwrap_or(0);
                let mut at = [0.0f32; 4];
                #[allow(clippy::cast_possible_truncation)] // in [0, 1]
                let part = p.part as f32;
                at[place(p.from)] += 1.0 - part;
                at[place(p.to)] += part;
                at
            });
            for (corners, at) in [([a, b, c], [u, v, w]), ([b, a, c], [v, u, w])] {
                // Face 0 is that of the last three vertices.
                mesh.boundary.push(BoundaryFace {
                    tet: index(mesh.tets.len()),
                    face: 0,
                    origin: FaceOrigin::Cut(self.cuts),
                });
                mesh.tets.push([corners[0], corners[0], corners[1], corners[2]]);
                mesh.neighbours.push([NONE; 4]);
                sheet.tet_origin.push(self.tet_origin[parent]);
                for l in self.layers(parent) {
                    sheet.layer_patch.push(self.layer_patch[l]);
                    let uvw = at.map(|b| interpolate(&self.layer_uvw[l], b));
                    sheet.layer_uvw.push([uvw[0], uvw[0], uvw[1], uvw[2]]);
                }
                sheet.layer_start.push(index(sheet.layer_patch.len()));
            }
        }
        mesh.vertices = points.iter().map(|p| p.place(&self.mesh)).collect();
        let fields: Vec<AtVertex> =
            points.iter().map(|p| self.at_vertex(p.from).between(&self.at_vertex(p.to), p.part)).collect();
        let fields = self.collected(&fields.into_iter());
        Some(Self {
            mesh,
            depth: vec![depth; points.len()],
            along: fields.along,
            across: fields.across,
            frame: fields.frame,
            ..sheet
        })
    }

    /// What does not belong to single vertices and tetrahedra, of a solid that has been cut once more.
    fn without_mesh(&self) -> Self {
        Self {
            patches: self.patches.clone(),
            exemplars: self.exemplars.clone(),
            masks: self.masks.clone(),
            choices: self.choices.clone(),
            cuts: self.cuts + 1,
            settings: self.settings.clone(),
            ..super::bare(TetMesh::default())
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::lap::{Fields, TextureType, unfilled};
    use crate::mesh::shapes::ball;
    use crate::render::testing;

    #[test]
    fn a_ball_has_spheres_seen_from_both_sides() {
        let mesh = ball(3, 6);
        let depth = mesh.vertices.iter().map(|p| (1.0 - p.length()).clamp(0.0, 1.0)).collect();
        let along = mesh.vertices.iter().map(|p| 0.5 + 0.5 * p.z).collect();
        let fields = Fields { depth: Some(depth), along: Some(along), ..Fields::default() };
        let solid = unfilled(mesh, TextureType::Type2c, &fields);
        let sheet = solid.isosurface(0.4).unwrap();
        let mesh = &sheet.mesh;
        assert!(mesh.vertices.iter().all(|p| (p.length() - 0.6).abs() < 0.02));
        assert!(mesh.vertices.iter().zip(&sheet.along).all(|(p, a)| (a - 0.5 - 0.5 * p.z).abs() < 1e-6));
        // Both sides: what faces outwards encloses what the other side does, and each vertex is there once.
        let normals = mesh.boundary.iter().map(|f| {
            let [a, b, c] = mesh.face_vertices(f).map(|v| mesh.vertices[v as usize]);
            (b - a).cross(c - a).dot(a)
        });
        let outwards: f64 = normals.clone().filter(|v| *v > 0.0).sum::<f64>() / 6.0;
        assert!((outwards / (4.0 / 3.0 * std::f64::consts::PI * 0.216) - 1.0).abs() < 0.05, "{outwards}");
        assert!(normals.sum::<f64>().abs() < 1e-12);
        // V − E + F = 2 on the sphere.
        assert_eq!(mesh.vertices.len() * 4, mesh.boundary.len() + 8);
    }

    #[test]
    fn it_has_the_texture_of_the_solid() {
        let mut solid = testing::ball(6);
        solid.depth = solid.mesh.vertices.iter().map(|p| 0.5 + 0.5 * p.x).collect();
        let sheet = solid.isosurface(0.6).unwrap();
        for f in sheet.mesh.boundary.iter().step_by(17) {
            let [a, b, c] = sheet.mesh.face_vertices(f).map(|v| sheet.mesh.vertices[v as usize]);
            let found = sheet.colour(f.tet as usize, [0.0, 0.5, 0.25, 0.25]);
            let expected = testing::colour_at(&solid, a * 0.5 + b * 0.25 + c * 0.25);
            assert!((0..4).all(|n| (found[n] - expected[n]).abs() < 1e-4), "{found:?} {expected:?}");
        }
        assert!(solid.isosurface(0.6).unwrap().mesh.vertices.iter().all(|p| (p.x - 0.2).abs() < 1e-6));
        assert!(testing::cube(1).isosurface(0.5).is_none());
    }
}
