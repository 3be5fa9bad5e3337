//! Delaunay tetrahedra of a surface's vertices and of points inside, with every triangle of the surface
//! among their faces.
//!
//! Plain Delaunay tetrahedra always exist and are quickly made; a surface of even triangles is nearly
//! always among their faces. Where it is not, points inside that are in the way are taken out, and edges of
//! the surface are split, until it is.

use glam::DVec3;
use rstar::RTree;
use rstar::primitives::GeomWithData;

use super::cells::sorted as sorted_face;
use super::surface::{Splitter, Surface, edges};
use crate::exec::{Cancelled, Exec};
use crate::mesh::mesher::{Answer, Job, MesherError};

/// Rounds after which it is left to TetGen to respect the surface.
const ROUNDS: usize = 40;

/// A round's result.
pub(super) enum Conformed {
    /// All triangles are faces; the surface may have been split.
    Yes(Answer),
    /// They did not become so.
    No,
}

/// Connects the surface's vertices and `inner` points; splits edges of the surface where need be. The first
/// `corners` vertices are those before any edge was split. `place`
/// takes the world into the box that `inner` lies in, `run` makes Delaunay tetrahedra.
pub(super) fn conform(
    surface: &mut Surface,
    corners: u32,
    inner: &mut Vec<DVec3>,
    place: impl Fn(DVec3) -> DVec3,
    mut run: impl FnMut(&Job) -> Result<Answer, MesherError>,
    exec: &Exec,
) -> Result<Conformed, MesherError> {
    // Needles need many splits; still more are a sign that there is no end to it.
    let most = surface.mesh.triangles.len() * 4 + 1000;
    for _ in 0..ROUNDS {
        let mut points: Vec<DVec3> = surface.mesh.vertices.iter().map(|p| place(*p)).collect();
        let own = points.len();
        points.extend(&*inner);
        let mut answer = run(&Job::delaunay(points))?;
        let mut missing = missing(surface, own, &answer.tets, exec)?;
        if missing.edges.is_empty() && missing.triangles.is_empty() {
            answer.faces = (0..).zip(&surface.mesh.triangles).map(|(t, c)| (*c, t)).collect();
            return Ok(Conformed::Yes(answer));
        }
        if surface.mesh.triangles.len() > most {
            break;
        }
        let mut splitter = Splitter::new(surface);
        let edges = std::mem::take(&mut missing.edges);
        missing.edges =
            edges.into_iter().filter(|edge| !splitter.flip(*edge, |face| missing.there(face))).collect();
        for edge in repair(&missing, &answer.points[..own], inner) {
            splitter.split_below(edge, corners);
        }
        // On a simplified surface this would undo the flips above.
        if splitter.surface.origin.is_some() {
            splitter.flip_all();
        }
    }
    Ok(Conformed::No)
}

/// What of a surface is not among some tetrahedra.
struct Missing {
    edges: Vec<[u32; 2]>,
    /// Triangles whose edges are all there.
    triangles: Vec<[u32; 3]>,
    /// The faces, sorted, that are there.
    faces: Vec<[u32; 3]>,
}

impl Missing {
    fn there(&self, face: [u32; 3]) -> bool {
        self.faces.binary_search(&sorted_face(face)).is_ok()
    }
}

fn missing(surface: &Surface, own: usize, tets: &[[u32; 4]], exec: &Exec) -> Result<Missing, Cancelled> {
    exec.check()?;
    let (mut there_edges, mut there_faces) = (Vec::new(), Vec::new());
    for tet in tets {
        for k in 0..4 {
            let face = [tet[(k + 1) % 4], tet[(k + 2) % 4], tet[(k + 3) % 4]];
            if face.iter().all(|v| (*v as usize) < own) {
                there_faces.push(sorted_face(face));
            }
        }
        for [i, j] in [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]] {
            if (tet[i].max(tet[j]) as usize) < own {
                there_edges.push([tet[i].min(tet[j]), tet[i].max(tet[j])]);
            }
        }
    }
    exec.check()?;
    there_edges.sort_unstable();
    there_edges.dedup();
    there_faces.sort_unstable();
    there_faces.dedup();
    let mut missing = Missing { edges: Vec::new(), triangles: Vec::new(), faces: there_faces };
    for triangle in &surface.mesh.triangles {
        let gone = edges(*triangle).into_iter().filter(|e| there_edges.binary_search(e).is_err());
        let before = missing.edges.len();
        missing.edges.extend(gone);
        if missing.edges.len() == before && !missing.there(*triangle) {
            missing.triangles.push(*triangle);
        }
    }
    missing.edges.sort_unstable();
    missing.edges.dedup();
    Ok(missing)
}

/// Takes inner points out that are in the way, and gives the edges to split where none is.
fn repair(missing: &Missing, own: &[DVec3], inner: &mut Vec<DVec3>) -> Vec<[u32; 2]> {
    let at = |v: u32| own[v as usize];
    let numbered = (0..).zip(&*inner).map(|(i, p)| GeomWithData::new(p.to_array(), i));
    let tree: RTree<GeomWithData<[f64; 3], usize>> = RTree::bulk_load(numbered.collect());
    let mut taken = vec![false; inner.len()];
    let mut split = Vec::new();
    let mut take = |centre: DVec3, radius2: f64| {
        let mut found = false;
        for p in tree.locate_within_distance(centre.to_array(), radius2) {
            taken[p.data] = true;
            found = true;
        }
        found
    };
    for [a, b] in &missing.edges {
        let centre = at(*a).midpoint(at(*b));
        if !take(centre, centre.distance_squared(at(*a))) {
            split.push([*a, *b]);
        }
    }
    for triangle in &missing.triangles {
        let [a, b, c] = triangle.map(at);
        let centre = circumcentre(a, b, c);
        if take(centre, centre.distance_squared(a)) {
            continue;
        }
        let length = |[a, b]: &[u32; 2]| at(*a).distance_squared(at(*b));
        split.extend(edges(*triangle).into_iter().max_by(|e, f| length(e).total_cmp(&length(f))));
    }
    let mut taken = taken.into_iter();
    inner.retain(|_| !taken.next().unwrap_or(false));
    split
}

/// The centre of the circle through three points.
fn circumcentre(a: DVec3, b: DVec3, c: DVec3) -> DVec3 {
    let (u, v) = (b - a, c - a);
    let n = u.cross(v);
    a + (n.cross(u) * v.length_squared() + v.cross(n) * u.length_squared()) / (2.0 * n.length_squared())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_circumcentre_is_as_far_from_each_corner() {
        let t = [DVec3::new(0.1, 0.2, 0.3), DVec3::new(2.0, 0.1, -0.3), DVec3::new(0.5, 1.7, 0.9)];
        let centre = circumcentre(t[0], t[1], t[2]);
        let r = centre.distance(t[0]);
        assert!(t.iter().all(|p| (centre.distance(*p) - r).abs() < 1e-12));
        let n = (t[1] - t[0]).cross(t[2] - t[0]);
        assert!((centre - t[0]).dot(n).abs() < 1e-12);
    }
}
