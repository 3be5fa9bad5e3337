//! No tetrahedron with all its vertices on the surface: a depth painted there would be flat in it.

use std::cmp::Reverse;

use serde::Serialize;

use super::cells::{Cells, next};
use super::improve::Improver;
use crate::exec::{Cancelled, Exec};
use crate::mesh::{NONE, TET_FACES, TetMesh, TopologyError, index};

/// How many inner edges and how many whole tetrahedra were split.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Splits {
    /// Inner edges between two vertices on the surface, split at their middles.
    #[serde(rename = "inner_edges_split")]
    pub edges: usize,
    /// Tetrahedra with their four vertices on the surface, split at their barycentres.
    #[serde(rename = "tets_split")]
    pub tets: usize,
}

/// Why tetrahedra could not be made fit for depth.
#[derive(Debug, thiserror::Error)]
pub enum SplitError {
    /// The caller asked for a stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// A tetrahedron so flat that its parts have no volume.
    #[error("split so that depth is flat in none, {0}; mesh the volume with better shapes")]
    Topology(#[from] TopologyError),
}

/// Makes tetrahedra fit for a depth that is painted on their surface, as [`super::tetrahedralise`] does with its own:
/// afterwards none has its four vertices on the boundary, and no inner edge joins two vertices of the boundary.
/// Such edges are connected anew where that makes no shape worse, and split elsewhere. Boundary faces and their
/// origins stay.
///
/// # Errors
/// [`SplitError`].
pub fn split_for_depth(mesh: &TetMesh, exec: &Exec) -> Result<(TetMesh, Splits), SplitError> {
    let mut cells = Cells {
        points: mesh.vertices.clone(),
        tets: mesh.tets.clone(),
        outer: vec![[NONE; 4]; mesh.tets.len()],
    };
    for (n, face) in mesh.boundary.iter().enumerate() {
        cells.outer[face.tet as usize][face.face as usize] = index(n);
    }
    let splits = cells.split_inner(exec)?;
    let Cells { points, tets, outer } = cells;
    let made = TetMesh::new(points, tets, |t, k| mesh.boundary[outer[t][k] as usize].origin)?;
    Ok((made, splits))
}

impl Cells {
    /// The inner edges that join two vertices on the surface, longest first.
    pub(super) fn crossing(&self, on: &[bool]) -> Vec<[u32; 2]> {
        let mut on_edges = Vec::new();
        let mut crossing = Vec::new();
        for (tet, outer) in self.tets.iter().zip(&self.outer) {
            for (k, triangle) in outer.iter().enumerate() {
                if *triangle != NONE {
                    let [a, b, c] = TET_FACES[k].map(|i| tet[i]);
                    on_edges.extend([sorted(a, b), sorted(b, c), sorted(c, a)]);
                }
            }
            for [i, j] in [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]] {
                if on[tet[i] as usize] && on[tet[j] as usize] {
                    crossing.push(sorted(tet[i], tet[j]));
                }
            }
        }
        on_edges.sort_unstable();
        crossing.sort_unstable();
        crossing.dedup();
        crossing.retain(|edge| on_edges.binary_search(edge).is_err());
        crossing.sort_by_cached_key(|[a, b]| {
            let length = self.points[*a as usize].distance(self.points[*b as usize]);
            (Reverse(length.to_bits()), [*a, *b])
        });
        crossing
    }

    /// Flips away what inner edges between two vertices on the surface can be, then splits the others at
    /// their middles, longest first, then every tetrahedron that still has its four vertices on the surface
    /// at its barycentre.
    pub(super) fn split_inner(&mut self, exec: &Exec) -> Result<Splits, Cancelled> {
        let on = self.on_surface();
        let before = self.crossing(&on);
        Improver::new(self).remove_edges(&before, exec)?;
        // Middles lie inside, so that a split makes no new such edge and changes none that waits.
        let crossing = self.crossing(&on);

        let mut around: Vec<Vec<u32>> = vec![Vec::new(); self.points.len()];
        for (t, tet) in (0..).zip(&self.tets) {
            for v in tet {
                around[*v as usize].push(t);
            }
        }
        for (i, [a, b]) in crossing.iter().enumerate() {
            if i % 1024 == 0 {
                exec.check()?;
            }
            self.split_edge(*a, *b, &mut around);
        }

        let whole: Vec<usize> = (0..self.tets.len())
            .filter(|t| self.tets[*t].iter().all(|v| on.get(*v as usize) == Some(&true)))
            .collect();
        for t in &whole {
            self.split_tet(*t);
        }
        Ok(Splits { edges: crossing.len(), tets: whole.len() })
    }

    /// Splits the tetrahedra around an edge that is not on the surface; `around` holds those at each vertex.
    fn split_edge(&mut self, a: u32, b: u32, around: &mut Vec<Vec<u32>>) {
        let middle = next(&self.points);
        self.points.push(self.points[a as usize].midpoint(self.points[b as usize]));
        around.push(Vec::new());
        let ring: Vec<u32> =
            around[a as usize].iter().copied().filter(|t| self.tets[*t as usize].contains(&b)).collect();
        for t in ring {
            let old = self.tets[t as usize];
            let outer = self.outer[t as usize];
            let new = next(&self.tets);
            // The half at `a` keeps its place. Only the faces opposite `a` and `b` can be outer ones: the
            // others hold the edge.
            self.tets[t as usize] = old.map(|v| if v == b { middle } else { v });
            self.tets.push(old.map(|v| if v == a { middle } else { v }));
            self.outer[t as usize] = std::array::from_fn(|k| if old[k] == b { outer[k] } else { NONE });
            self.outer.push(std::array::from_fn(|k| if old[k] == a { outer[k] } else { NONE }));
            for v in old {
                if v == b {
                    for other in &mut around[b as usize] {
                        if *other == t {
                            *other = new;
                        }
                    }
                } else if v != a {
                    around[v as usize].push(new);
                }
            }
            around[middle as usize].extend([t, new]);
        }
    }

    /// Splits a tetrahedron in four at its barycentre.
    fn split_tet(&mut self, t: usize) {
        let old = self.tets[t];
        let outer = self.outer[t];
        let middle = next(&self.points);
        let sum: glam::DVec3 = old.iter().map(|v| self.points[*v as usize]).sum();
        self.points.push(sum / 4.0);
        for k in 0..4 {
            let mut tet = old;
            tet[k] = middle;
            let mut sides = [NONE; 4];
            sides[k] = outer[k];
            if k == 0 {
                self.tets[t] = tet;
                self.outer[t] = sides;
            } else {
                self.tets.push(tet);
                self.outer.push(sides);
            }
        }
    }
}

fn sorted(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::FaceOrigin;
    use glam::DVec3;

    /// Builds the mesh from its table of outer faces, which must be the outer faces.
    fn mesh(cells: &Cells) -> TetMesh {
        TetMesh::new(cells.points.clone(), cells.tets.clone(), |t, k| {
            assert_ne!(cells.outer[t][k], NONE);
            FaceOrigin::Input(cells.outer[t][k])
        })
        .unwrap()
    }

    fn closed(points: Vec<DVec3>, tets: Vec<[u32; 4]>) -> Cells {
        let topology = TetMesh::new(points.clone(), tets.clone(), |_, _| FaceOrigin::Input(0)).unwrap();
        let mut outer = vec![[NONE; 4]; tets.len()];
        for (n, face) in topology.boundary.iter().enumerate() {
            outer[face.tet as usize][face.face as usize] = n as u32;
        }
        Cells { points, tets, outer }
    }

    #[test]
    fn one_tetrahedron_is_split_at_its_barycentre() {
        let mut cells = closed(vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z], vec![[0, 1, 2, 3]]);
        let splits = cells.split_inner(&Exec::default()).unwrap();
        assert_eq!(splits, Splits { edges: 0, tets: 1 });
        let mesh = mesh(&cells);
        assert_eq!((mesh.tets.len(), mesh.boundary.len()), (4, 4));
        assert!((mesh.volume() - 1.0 / 6.0).abs() < 1e-15);
    }

    #[test]
    fn an_inner_edge_is_split_and_every_outer_face_keeps_its_triangle() {
        // Five tetrahedra around an axis, whose edge joins two vertices on the surface.
        let mut points = vec![DVec3::NEG_Z, DVec3::Z];
        for i in 0..5 {
            let angle = f64::from(i) * std::f64::consts::TAU / 5.0;
            points.push(DVec3::new(angle.cos(), angle.sin(), 0.1 * f64::from(i)));
        }
        let tets: Vec<[u32; 4]> = (0..5).map(|i| [0, 1, 2 + i, 2 + (i + 1) % 5]).collect();
        let mut cells = closed(points, tets);
        let before = mesh(&cells);
        let splits = cells.split_inner(&Exec::default()).unwrap();
        assert_eq!(splits, Splits { edges: 1, tets: 0 });
        let after = mesh(&cells);
        assert_eq!((after.tets.len(), after.vertices.len()), (10, 8));
        assert!((after.volume() - before.volume()).abs() < 1e-14);
        let faces = |mesh: &TetMesh| {
            let mut faces: Vec<_> = mesh.boundary.iter().map(|f| (f.origin, mesh.face_vertices(f))).collect();
            for (_, corners) in &mut faces {
                corners.sort_unstable();
            }
            faces.sort_unstable();
            faces
        };
        assert_eq!(faces(&before), faces(&after));
    }

    #[test]
    fn no_depth_is_flat_in_tetrahedra_of_a_file() {
        // A slab one cube thick: every vertex is on the surface.
        let flat = crate::mesh::shapes::grid(1);
        let all = |mesh: &TetMesh| {
            let mut on = vec![false; mesh.vertices.len()];
            for v in mesh.boundary.iter().flat_map(|f| mesh.face_vertices(f)) {
                on[v as usize] = true;
            }
            mesh.tets.iter().filter(|t| t.iter().all(|v| on[*v as usize])).count()
        };
        assert_eq!(all(&flat), flat.tets.len());
        let (made, splits) = split_for_depth(&flat, &Exec::default()).unwrap();
        assert!(splits.edges + splits.tets > 0);
        assert_eq!(all(&made), 0);
        assert!((made.volume() - flat.volume()).abs() < 1e-14);
        let origins = |mesh: &TetMesh| {
            let mut faces: Vec<_> = mesh
                .boundary
                .iter()
                .map(|f| {
                    let mut corners =
                        mesh.face_vertices(f).map(|v| mesh.vertices[v as usize].to_array().map(f64::to_bits));
                    corners.sort_unstable();
                    (f.origin, corners)
                })
                .collect();
            faces.sort_unstable();
            faces
        };
        assert_eq!(origins(&made), origins(&flat));
        // What is fit already stays as it is.
        let (again, splits) = split_for_depth(&made, &Exec::default()).unwrap();
        assert_eq!((again, splits), (made, Splits::default()));
    }
}
