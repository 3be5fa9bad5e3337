//! What depths are painted on the surface, and which strokes count beside it.

use std::collections::BTreeMap;

use glam::DVec3;

use super::depth::{DepthError, DepthPaint, DepthStroke};
use super::stroke::sample;
use crate::mesh::{FaceOrigin, TetLocator, TetMesh, index};

/// The depths of what is painted of the surface.
pub(super) struct PaintedSurface<'a> {
    mesh: &'a TetMesh,
    /// Of each boundary face.
    face: Vec<Option<f64>>,
    /// Of each vertex.
    vertex: Vec<Option<f64>>,
    /// Of each edge, where more than one depth is painted.
    edge: Option<BTreeMap<[u32; 2], f64>>,
}

impl<'a> PaintedSurface<'a> {
    pub(super) fn new(mesh: &'a TetMesh, paint: &DepthPaint) -> Result<Self, DepthError> {
        let skin = paint.skin.into_iter().flat_map(|depth| {
            let input = |f: &usize| matches!(mesh.boundary[*f].origin, FaceOrigin::Input(_));
            (0..mesh.boundary.len()).filter(input).map(move |f| (f, depth))
        });
        let all = skin.chain(paint.faces.iter().map(|f| (f.face as usize, f.depth)));
        let first = paint.skin.or(paint.faces.first().map(|f| f.depth));
        let one = paint.faces.iter().all(|f| Some(f.depth) == first);
        let mut surface = Self {
            mesh,
            face: vec![None; mesh.boundary.len()],
            vertex: vec![None; mesh.vertices.len()],
            edge: (!one).then(BTreeMap::new),
        };
        for (f, depth) in all {
            surface.face[f] = Some(depth);
            let [a, b, c] = mesh.face_vertices(&mesh.boundary[f]);
            for v in [a, b, c] {
                surface.vertex[v as usize] = Some(depth);
            }
            if let Some(edges) = &mut surface.edge {
                edges.extend([[a, b], [b, c], [c, a]].map(|[u, v]| ([u.min(v), u.max(v)], depth)));
            }
        }
        if paint.skin.is_some() && surface.face.iter().all(Option::is_none) {
            return Err(DepthError::NoSkin);
        }
        Ok(surface)
    }

    pub(super) fn vertices(&self) -> Vec<(u32, f64)> {
        let painted = self.vertex.iter().enumerate();
        painted.filter_map(|(v, depth)| depth.map(|depth| (index(v), depth))).collect()
    }

    /// Points between the vertices on faces far larger than the mesh's edges.
    pub(super) fn between(&self, spacing: f64) -> Vec<(DVec3, f64)> {
        let mut points = Vec::new();
        for (face, depth) in self.mesh.boundary.iter().zip(&self.face) {
            let Some(depth) = *depth else { continue };
            let v = self.mesh.face_vertices(face);
            let [a, b, c] = v.map(|v| self.mesh.vertices[v as usize]);
            let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
            if longest < 1.6 * spacing {
                continue;
            }
            // An edge between two depths has that of the later face.
            let has = |u: u32, v: u32| match &self.edge {
                None => true,
                Some(edges) => edges.get(&[u.min(v), u.max(v)]) == Some(&depth),
            };
            let edges = [has(v[1], v[2]), has(v[2], v[0]), has(v[0], v[1])];
            let order = (longest / spacing).ceil().min(16.0) as u32;
            for i in 0..=order {
                for j in 0..=order - i {
                    let k = order - i - j;
                    let inside = [i, j, k].iter().zip(edges).all(|(n, has)| *n > 0 || has);
                    if i.max(j).max(k) < order && inside {
                        let p = (a * f64::from(i) + b * f64::from(j) + c * f64::from(k)) / f64::from(order);
                        points.push((p, depth));
                    }
                }
            }
        }
        points
    }

    /// The depth of face `k` of a tetrahedron, if it is painted.
    pub(super) fn of_side(&self, tet: usize, k: usize) -> Option<f64> {
        let at = self.mesh.boundary.binary_search_by_key(&(index(tet), k as u8), |f| (f.tet, f.face));
        at.ok().and_then(|f| self.face[f])
    }
}

/// How near to a surface a stroke runs on it, in mean lengths of the mesh's edges: a polyline drawn on a bent surface
/// runs a little below it between its points.
const ON_SURFACE: f64 = 0.05;

/// The samples of each stroke, at most `step` apart, that lie in the mesh and not on a surface painted with another
/// depth. `spacing` is the mean length of the mesh's edges.
pub(super) fn samples_that_count(
    mesh: &TetMesh,
    paint: &DepthPaint,
    surface: &PaintedSurface<'_>,
    [spacing, step]: [f64; 2],
) -> Vec<Vec<DVec3>> {
    if paint.strokes.is_empty() {
        return Vec::new();
    }
    let locator = TetLocator::new(mesh);
    let counts = |p: DVec3, depth: f64| {
        let Some((tet, b)) = locator.nearest(p) else {
            return false;
        };
        let closest: DVec3 = mesh.corners(tet).into_iter().zip(b).map(|(v, b)| v * b).sum();
        let gradients = mesh.gradients(tet);
        let near = ON_SURFACE * spacing;
        let other = |painted: Option<f64>| painted.is_some_and(|d| d != depth);
        // The distance to face k is bₖ/|∇bₖ|. A tetrahedron may touch the surface with a vertex only.
        let touches = (0..4).any(|k| {
            (b[k] < near * gradients[k].length() && other(surface.of_side(tet, k)))
                || (b[k] > 1.0 - ON_SURFACE && other(surface.vertex[mesh.tets[tet][k] as usize]))
        });
        closest.distance(p) <= spacing && !touches
    };
    let of = |s: &DepthStroke| {
        sample(&s.points, step).iter().map(|q| q.point).filter(|p| counts(*p, s.depth)).collect()
    };
    paint.strokes.iter().map(of).collect()
}
