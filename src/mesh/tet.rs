//! Tetrahedral meshes and their topology.

use glam::DVec3;

use super::tri::bounds;

/// No neighbour: the face lies on the boundary.
pub const NONE: u32 = u32::MAX;

/// Local vertices of the face opposite local vertex k, counter-clockwise seen from outside a positive
/// tetrahedron.
pub const TET_FACES: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];

/// Where a boundary face comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum FaceOrigin {
    /// It lies on this triangle of the (cleaned) input mesh.
    Input(u32),
    /// The cut of this number opened it, counted from 0 over the model's life.
    Cut(u32),
}

/// A face on the boundary: face `face` (opposite that local vertex) of tetrahedron `tet`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BoundaryFace {
    /// The tetrahedron it belongs to.
    pub tet: u32,
    /// The local vertex (0…3) that it lies opposite to; see [`TET_FACES`].
    pub face: u8,
    /// Where it comes from.
    pub origin: FaceOrigin,
}

/// Tetrahedra that do not make a mesh.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TopologyError {
    /// A vertex index past the end.
    #[error("tetrahedron {tet} names vertex {vertex}, but there are {count}")]
    Index {
        /// The tetrahedron.
        tet: usize,
        /// The index that it names.
        vertex: u32,
        /// Number of vertices.
        count: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("vertex {0} is not finite")]
    NotFinite(usize),
    /// Zero or negative volume.
    #[error("tetrahedron {tet} has volume {volume:e}: it is flat or inside out")]
    Inverted {
        /// The tetrahedron.
        tet: usize,
        /// Its signed volume.
        volume: f64,
    },
    /// More than two tetrahedra at a face.
    #[error("the face of vertices {face:?} belongs to more than two tetrahedra")]
    CrowdedFace {
        /// Its vertices, sorted.
        face: [u32; 3],
    },
}

/// A tetrahedral mesh with its topology.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TetMesh {
    /// Positions, in the mesh's own unit.
    pub vertices: Vec<DVec3>,
    /// Vertex indices; every tetrahedron is positive: (v1−v0)·((v2−v0)×(v3−v0)) > 0.
    pub tets: Vec<[u32; 4]>,
    /// `neighbours[t][k]`: the tetrahedron across the face opposite local vertex k, or [`NONE`].
    pub neighbours: Vec<[u32; 4]>,
    /// All boundary faces, in order of (tetrahedron, face).
    pub boundary: Vec<BoundaryFace>,
}

impl TetMesh {
    /// Builds the topology. Every boundary face gets the origin that `origin` gives for (tetrahedron,
    /// local face).
    ///
    /// # Errors
    /// [`TopologyError`] where the tetrahedra are no mesh.
    pub fn new(
        vertices: Vec<DVec3>,
        tets: Vec<[u32; 4]>,
        mut origin: impl FnMut(usize, usize) -> FaceOrigin,
    ) -> Result<Self, TopologyError> {
        if let Some(v) = vertices.iter().position(|p| !p.is_finite()) {
            return Err(TopologyError::NotFinite(v));
        }
        for (t, tet) in tets.iter().enumerate() {
            for &v in tet {
                if v as usize >= vertices.len() {
                    return Err(TopologyError::Index { tet: t, vertex: v, count: vertices.len() });
                }
            }
            let volume = signed_volume(tet.map(|v| vertices[v as usize]));
            if !(volume > 0.0) {
                return Err(TopologyError::Inverted { tet: t, volume });
            }
        }
        let neighbours = neighbours(&tets)?;
        let mut boundary = Vec::new();
        for (t, sides) in neighbours.iter().enumerate() {
            for (k, &other) in sides.iter().enumerate() {
                if other == NONE {
                    boundary.push(BoundaryFace { tet: index(t), face: k as u8, origin: origin(t, k) });
                }
            }
        }
        Ok(Self { vertices, tets, neighbours, boundary })
    }

    /// The four corners of tetrahedron `t`.
    #[must_use]
    pub fn corners(&self, t: usize) -> [DVec3; 4] {
        self.tets[t].map(|v| self.vertices[v as usize])
    }

    /// Volume of tetrahedron `t`.
    #[must_use]
    pub fn tet_volume(&self, t: usize) -> f64 {
        signed_volume(self.corners(t))
    }

    /// Volume of all tetrahedra.
    #[must_use]
    pub fn volume(&self) -> f64 {
        (0..self.tets.len()).map(|t| self.tet_volume(t)).sum()
    }

    /// Vertex indices of a boundary face, counter-clockwise seen from outside.
    #[must_use]
    pub fn face_vertices(&self, face: &BoundaryFace) -> [u32; 3] {
        let tet = self.tets[face.tet as usize];
        TET_FACES[face.face as usize].map(|k| tet[k])
    }

    /// The smallest box around the vertices; `None` without vertices.
    #[must_use]
    pub fn bounds(&self) -> Option<(DVec3, DVec3)> {
        bounds(&self.vertices)
    }

    /// The constant gradients of the four barycentric coordinates in tetrahedron `t`; they sum to 0.
    #[must_use]
    pub fn gradients(&self, t: usize) -> [DVec3; 4] {
        gradients(self.corners(t))
    }

    /// Each undirected edge once, as (smaller, larger) vertex, sorted.
    #[must_use]
    pub fn edges(&self) -> Vec<[u32; 2]> {
        let pairs = || {
            let all = |t: &[u32; 4]| {
                [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]]
                    .map(|[a, b]: [usize; 2]| [t[a].min(t[b]), t[a].max(t[b])])
            };
            self.tets.iter().flat_map(all)
        };
        let mut larger = Buckets::new(pairs().map(|[a, b]| (a, b)));
        let mut edges = Vec::with_capacity(self.tets.len() * 5 / 4);
        for a in 0..larger.len() {
            let mut last = NONE;
            for &mut b in larger.sorted(a) {
                if b != last {
                    edges.push([index(a), b]);
                    last = b;
                }
            }
        }
        edges
    }
}

/// Things by vertex: a counting sort, because sorting all that a large mesh has takes longer the larger it is.
struct Buckets<T> {
    start: Vec<usize>,
    things: Vec<T>,
}

impl<T: Copy + Default + Ord> Buckets<T> {
    pub(crate) fn new(things: impl Iterator<Item = (u32, T)> + Clone) -> Self {
        let most = things.clone().map(|(v, _)| v as usize + 1).max().unwrap_or(0);
        let mut start = vec![0; most + 1];
        for (v, _) in things.clone() {
            start[v as usize + 1] += 1;
        }
        for v in 0..most {
            start[v + 1] += start[v];
        }
        let mut end = start.clone();
        let mut sorted = vec![T::default(); start[most]];
        for (v, thing) in things {
            let at = &mut end[v as usize];
            sorted[*at] = thing;
            *at += 1;
        }
        Self { start, things: sorted }
    }

    /// One more than the largest vertex.
    pub(crate) fn len(&self) -> usize {
        self.start.len() - 1
    }

    /// The things of vertex `v`, in order.
    pub(crate) fn sorted(&mut self, v: usize) -> &mut [T] {
        let things = &mut self.things[self.start[v]..self.start[v + 1]];
        things.sort_unstable();
        things
    }
}

/// Signed volume of a tetrahedron.
#[must_use]
pub fn signed_volume(p: [DVec3; 4]) -> f64 {
    (p[1] - p[0]).dot((p[2] - p[0]).cross(p[3] - p[0])) / 6.0
}

/// Gradients of the barycentric coordinates of a tetrahedron.
#[must_use]
pub fn gradients(p: [DVec3; 4]) -> [DVec3; 4] {
    let (a, b, c) = (p[1] - p[0], p[2] - p[0], p[3] - p[0]);
    let det = a.dot(b.cross(c));
    let g1 = b.cross(c) / det;
    let g2 = c.cross(a) / det;
    let g3 = a.cross(b) / det;
    [-(g1 + g2 + g3), g1, g2, g3]
}

/// A `usize` known to fit the file format's `u32`.
pub(crate) fn index(i: usize) -> u32 {
    u32::try_from(i).expect("meshes are limited to 2³² elements")
}

/// The tetrahedron across each face, or [`NONE`].
pub(super) fn neighbours(tets: &[[u32; 4]]) -> Result<Vec<[u32; 4]>, TopologyError> {
    // Of each face the smallest vertex, then the others and the face's place.
    let sides = tets.iter().enumerate().flat_map(|(t, tet)| {
        TET_FACES.iter().enumerate().map(move |(k, face)| {
            let [mut a, mut b, mut c] = face.map(|i| tet[i]);
            (a, b) = (a.min(b), a.max(b));
            (b, c) = (b.min(c), b.max(c));
            (a, b) = (a.min(b), a.max(b));
            (a, (b, c, index(t), k as u8))
        })
    });
    let mut sides = Buckets::new(sides);
    let mut result = vec![[NONE; 4]; tets.len()];
    for a in 0..sides.len() {
        for group in sides.sorted(a).chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
            match group {
                [_] => {}
                [(_, _, t0, k0), (_, _, t1, k1)] => {
                    result[*t0 as usize][*k0 as usize] = *t1;
                    result[*t1 as usize][*k1 as usize] = *t0;
                }
                _ => return Err(TopologyError::CrowdedFace { face: [index(a), group[0].0, group[0].1] }),
            }
        }
    }
    Ok(result)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn two() -> (Vec<DVec3>, Vec<[u32; 4]>) {
        let v = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, DVec3::ONE];
        (v, vec![[0, 1, 2, 3], [1, 2, 3, 4]])
    }

    #[test]
    fn faces_point_outwards_and_neighbours_agree() {
        let (v, t) = two();
        let mesh = TetMesh::new(v, t, |_, _| FaceOrigin::Input(0)).unwrap();
        assert_eq!(mesh.neighbours, vec![[1, NONE, NONE, NONE], [NONE, NONE, NONE, 0]]);
        assert_eq!(mesh.boundary.len(), 6);
        for f in &mesh.boundary {
            let [a, b, c] = mesh.face_vertices(f).map(|i| mesh.vertices[i as usize]);
            let inside = mesh.corners(f.tet as usize).iter().sum::<DVec3>() / 4.0;
            assert!((b - a).cross(c - a).dot(inside - a) < 0.0);
        }
        assert!((mesh.volume() - 0.5).abs() < 1e-15);
    }

    #[test]
    fn gradients_reproduce_linear_functions() {
        let p = [
            DVec3::new(0.1, 0.2, 0.0),
            DVec3::new(2.0, 0.1, 0.3),
            DVec3::new(0.3, 1.5, 0.2),
            DVec3::new(0.4, 0.2, 1.7),
        ];
        let slope = DVec3::new(1.0, -2.0, 0.5);
        let sum: DVec3 = gradients(p).iter().zip(p).map(|(g, v)| *g * slope.dot(v)).sum();
        assert!((sum - slope).length() < 1e-13);
    }

    #[test]
    fn bad_tetrahedra_are_refused() {
        let (v, mut t) = two();
        t[1] = [1, 3, 2, 4];
        assert!(matches!(
            TetMesh::new(v.clone(), t.clone(), |_, _| FaceOrigin::Input(0)),
            Err(TopologyError::Inverted { tet: 1, .. })
        ));
        t[1] = [1, 2, 3, 9];
        assert!(matches!(
            TetMesh::new(v, t, |_, _| FaceOrigin::Input(0)),
            Err(TopologyError::Index { tet: 1, vertex: 9, count: 5 })
        ));
    }
}
