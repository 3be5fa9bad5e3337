//! The surface that a cut would open, without its pieces.

use rayon::prelude::*;

use super::{CutError, CutParams, CutSurface, Sheet};
use crate::exec::Exec;
use crate::lap::LappedSolid;
use crate::mesh::subdivide::{edge_key, edges, keyed_edge};
use crate::mesh::{NONE, TriMesh, index, signed_volume};

/// A surface through a model.
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    /// Its triangles, counter-clockwise seen from the positive side of the cut, where n·x is larger than D or, of a
    /// stroke, to its outside.
    pub mesh: TriMesh,
    /// The tetrahedron that each triangle lies in. Length as that of the triangles.
    pub tets: Vec<u32>,
    /// The edge of the model that each vertex lies on, the smaller vertex first, and how far along it, from 0 to 1.
    pub edges: Vec<([u32; 2], f64)>,
}

/// The surface that a cut would open, for a picture of it while a stroke is being drawn: many times quicker than
/// [`cut`](super::cut()), which makes the pieces.
///
/// Within a tetrahedron it is flat or a fold of two triangles, so that it cuts the corners of a stroke that
/// bends there; `cut` follows such bends to the tolerance.
///
/// # Errors
/// As [`cut`](super::cut()), but no error where the surface misses the model: then it is empty.
pub fn section(
    solid: &LappedSolid,
    surface: &CutSurface,
    params: &CutParams,
    exec: &Exec,
) -> Result<Section, CutError> {
    exec.install(|| {
        let sheet = Sheet::new(solid, surface)?;
        exec.check()?;
        Ok(section_here(solid, &sheet, params.tolerance))
    })
}

fn section_here(solid: &LappedSolid, sheet: &Sheet, tolerance: f64) -> Section {
    let mesh = &solid.mesh;
    let positive: Vec<bool> =
        mesh.vertices.par_iter().with_min_len(4096).map(|p| sheet.positive(*p)).collect();
    let side = |v: u32| positive[v as usize];
    let passed = |(_, tet): &(u32, &[u32; 4])| {
        let [a, b, c, d] = tet.map(side);
        a != b || a != c || a != d
    };
    let passed: Vec<(u32, [u32; 4])> =
        (0..).zip(&mesh.tets).filter(passed).map(|(t, tet)| (t, *tet)).collect();
    let crossed = |[a, b]: &[u32; 2]| side(*a) != side(*b);
    let mut keys: Vec<u64> =
        passed.iter().flat_map(|(_, tet)| edges(*tet).into_iter().filter(crossed).map(edge_key)).collect();
    keys.par_sort_unstable();
    keys.dedup();
    let cross = |key: &u64| {
        let edge = keyed_edge(*key);
        let [a, b] = edge.map(|v| mesh.vertices[v as usize]);
        let (t, _) = sheet.crossing(&mesh.vertices, edge, tolerance);
        (a + (b - a) * t, (edge, t))
    };
    let (vertices, edges): (Vec<_>, Vec<_>) = keys.par_iter().with_min_len(1024).map(cross).unzip();
    let mut section = Section { mesh: TriMesh { vertices, triangles: Vec::new() }, tets: Vec::new(), edges };
    for (t, tet) in passed {
        let on =
            |a: u32, b: u32| index(keys.binary_search(&edge_key([a.min(b), a.max(b)])).unwrap_or_default());
        // The vertices on the positive side first; the tetrahedron stays a positive one.
        let mut order = tet;
        order.sort_by_key(|v| !side(*v));
        let count = order.iter().filter(|v| side(**v)).count();
        if signed_volume(order.map(|v| mesh.vertices[v as usize])) < 0.0 {
            if count < 3 { order.swap(2, 3) } else { order.swap(0, 1) }
        }
        let [a, b, c, d] = order;
        let corners = match count {
            1 => [on(a, b), on(a, d), on(a, c), NONE],
            2 => [on(a, c), on(b, c), on(b, d), on(a, d)],
            _ => [on(a, d), on(c, d), on(b, d), NONE],
        };
        for [x, y] in [[1, 2], [2, 3]].into_iter().take(if count == 2 { 2 } else { 1 }) {
            section.mesh.triangles.push([corners[0], corners[x], corners[y]]);
            section.tets.push(t);
        }
    }
    section
}
