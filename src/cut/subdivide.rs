//! Splitting edges of a tetrahedral mesh, all tetrahedra around them at once.

use glam::DVec3;
use rayon::prelude::*;

use super::reach::Reach;
use crate::mesh::{TetMesh, index, signed_volume};

/// The weights of a part that is a whole tetrahedron.
pub(super) const WHOLE: u32 = u32::MAX;
/// A face inside the parent.
pub(super) const INNER: u8 = 4;

/// Barycentric coordinates in the parent of a part's four vertices.
pub(super) type Weights = [[f64; 4]; 4];

const IDENTITY: Weights =
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

/// A part of a tetrahedron.
#[derive(Debug, Clone, Copy)]
pub(super) struct Part {
    /// Its vertices; positive.
    pub(super) vertices: [u32; 4],
    /// The tetrahedron that it is part of.
    pub(super) parent: u32,
    /// The face of the parent that its face opposite each vertex lies on, or [`INNER`].
    pub(super) faces: [u8; 4],
    /// Its place in [`Subdivision::weights`], or [`WHOLE`].
    pub(super) weights: u32,
}

/// An edge and the place at which it is split.
#[derive(Debug, Clone, Copy)]
pub(super) struct Split {
    /// Its vertices, the smaller first.
    pub(super) edge: [u32; 2],
    /// The new vertex's place, from 0 at the first vertex to 1 at the second.
    pub(super) t: f64,
    /// Splits of higher rank come first.
    pub(super) rank: f64,
}

impl Split {
    /// A split of no special rank.
    pub(super) fn at(edge: [u32; 2], t: f64) -> Self {
        Self { edge, t, rank: 0.0 }
    }
}

/// A mesh whose tetrahedra are being divided. Those out of the sheet's reach stay whole, and have no parts.
#[derive(Debug)]
pub(super) struct Subdivision {
    /// Which tetrahedra may be divided.
    pub(super) reach: Reach,
    /// The mesh's vertices, then the new ones.
    pub(super) vertices: Vec<DVec3>,
    /// How each new vertex came about.
    pub(super) splits: Vec<Split>,
    /// The parts of the tetrahedra in reach; those that a split adds stand at the end.
    pub(super) parts: Vec<Part>,
    /// Weights of the parts that are no whole tetrahedra.
    pub(super) weights: Vec<Weights>,
}

/// A part under division, with its own weights.
#[derive(Clone, Copy)]
struct Slice {
    vertices: [u32; 4],
    faces: [u8; 4],
    weights: Weights,
}

/// What a run of parts divides into: how many slices each, all slices, and the parts with a bad one.
type Batch = (Vec<u8>, Vec<Slice>, Vec<u32>);

impl Subdivision {
    /// All tetrahedra whole.
    pub(super) fn new(mesh: &TetMesh, reach: Reach) -> Self {
        let part = |&t: &u32| Part {
            vertices: mesh.tets[t as usize],
            parent: t,
            faces: [0, 1, 2, 3],
            weights: WHOLE,
        };
        let parts = reach.tets.iter().map(part).collect();
        Self { reach, vertices: mesh.vertices.clone(), splits: Vec::new(), parts, weights: Vec::new() }
    }

    /// Whether an edge may be split: all tetrahedra around it are in reach.
    pub(super) fn in_reach(&self, edge: [u32; 2]) -> bool {
        edge.iter().all(|v| self.reach.passed.get(*v as usize).copied().unwrap_or(true))
    }

    /// Corners of a part.
    pub(super) fn corners(&self, part: &Part) -> [DVec3; 4] {
        part.vertices.map(|v| self.vertices[v as usize])
    }

    /// Splits edges, sorted and each once, at a new vertex each, which are numbered in the same order. The
    /// parts that changed or were added are returned.
    ///
    /// Every part is bisected at its split edges one after the other, by rank, then the longest first. This order is the
    /// same for all parts, and how it divides a face depends only on the face: so parts on both sides of
    /// it agree. A bisection of a positive tetrahedron within an edge leaves two positive ones.
    ///
    /// # Errors
    /// If round-off would leave a part flat or inside out, nothing is split; the splits at fault are
    /// returned by their places, sorted, each once.
    pub(super) fn split(&mut self, splits: &[Split]) -> Result<Vec<u32>, Vec<u32>> {
        let old = self.vertices.len();
        let mut touched = vec![false; old];
        let mut lengths = Vec::with_capacity(splits.len());
        for s in splits {
            let [a, b] = s.edge.map(|v| self.vertices[v as usize]);
            for v in s.edge {
                touched[v as usize] = true;
            }
            lengths.push((b - a).length_squared());
            self.vertices.push(a + (b - a) * s.t);
        }
        let this = &*self;
        let hits: Vec<u32> = (0..index(this.parts.len()))
            .into_par_iter()
            .with_min_len(4096)
            .filter(|&i| {
                let part = &this.parts[i as usize];
                let ends = part.vertices.iter().filter(|&&v| touched[v as usize]).count();
                ends > 1 && marked(splits, part).1 > 0
            })
            .collect();
        let batches: Vec<Batch> =
            hits.par_chunks(256).map(|c| this.slice(c, splits, &lengths, old)).collect();
        let mut bad: Vec<u32> = batches.iter().flat_map(|b| b.2.iter().copied()).collect();
        if !bad.is_empty() {
            self.vertices.truncate(old);
            bad.sort_unstable();
            bad.dedup();
            return Err(bad);
        }
        self.splits.extend_from_slice(splits);
        let mut changed = Vec::new();
        for (chunk, (counts, slices, _)) in hits.chunks(256).zip(&batches) {
            let mut rest = &slices[..];
            for (&i, &count) in chunk.iter().zip(counts) {
                let (mine, after) = rest.split_at(usize::from(count));
                rest = after;
                let was = self.parts[i as usize];
                for (n, slice) in mine.iter().enumerate() {
                    let weights = if n == 0 && was.weights != WHOLE {
                        self.weights[was.weights as usize] = slice.weights;
                        was.weights
                    } else {
                        self.weights.push(slice.weights);
                        index(self.weights.len() - 1)
                    };
                    let part =
                        Part { vertices: slice.vertices, parent: was.parent, faces: slice.faces, weights };
                    if n == 0 {
                        self.parts[i as usize] = part;
                        changed.push(i);
                    } else {
                        changed.push(index(self.parts.len()));
                        self.parts.push(part);
                    }
                }
            }
        }
        Ok(changed)
    }

    fn slice(&self, hits: &[u32], splits: &[Split], lengths: &[f64], old: usize) -> Batch {
        let mut counts = Vec::with_capacity(hits.len());
        let mut slices: Vec<Slice> = Vec::with_capacity(hits.len() * 5);
        let mut bad = Vec::new();
        for &i in hits {
            let part = &self.parts[i as usize];
            let (mut list, n) = marked(splits, part);
            let list = &mut list[..n];
            let key = |s: u32| (splits[s as usize].rank, lengths[s as usize]);
            list.sort_unstable_by(|&a, &b| {
                let (x, y) = (key(a), key(b));
                y.0.total_cmp(&x.0).then(y.1.total_cmp(&x.1)).then(a.cmp(&b))
            });
            let start = slices.len();
            let weights = if part.weights == WHOLE { IDENTITY } else { self.weights[part.weights as usize] };
            slices.push(Slice { vertices: part.vertices, faces: part.faces, weights });
            for &s in &*list {
                let split = splits[s as usize];
                let middle = index(old) + s;
                for k in start..slices.len() {
                    if let Some(other) = slices[k].bisect(split, middle) {
                        slices.push(other);
                    }
                }
            }
            let flat = |s: &Slice| signed_volume(s.vertices.map(|v| self.vertices[v as usize])) <= 0.0;
            if slices[start..].iter().any(flat) {
                bad.extend_from_slice(list);
            }
            counts.push((slices.len() - start) as u8);
        }
        (counts, slices, bad)
    }
}

/// The splits on a part's edges, by their places, and how many they are.
fn marked(splits: &[Split], part: &Part) -> ([u32; 6], usize) {
    let (mut list, mut n) = ([0; 6], 0);
    for edge in edges(part.vertices) {
        if let Ok(at) = splits.binary_search_by_key(&edge, |s| s.edge) {
            list[n] = index(at);
            n += 1;
        }
    }
    (list, n)
}

/// The six edges of a tetrahedron, the smaller vertex first.
pub(super) fn edges(v: [u32; 4]) -> [[u32; 2]; 6] {
    [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]]
        .map(|[a, b]: [usize; 2]| [v[a].min(v[b]), v[a].max(v[b])])
}

impl Slice {
    /// If the edge is one of its own, it becomes the half at the edge's first vertex, and the other half is
    /// returned.
    fn bisect(&mut self, split: Split, middle: u32) -> Option<Slice> {
        let a = self.vertices.iter().position(|&v| v == split.edge[0])?;
        let b = self.vertices.iter().position(|&v| v == split.edge[1])?;
        let (wa, wb) = (self.weights[a], self.weights[b]);
        let weights = std::array::from_fn(|n| wa[n] + (wb[n] - wa[n]) * split.t);
        // Each half swaps one vertex; the face between the halves lies opposite the vertex that stays.
        let mut other = *self;
        self.vertices[b] = middle;
        self.weights[b] = weights;
        self.faces[a] = INNER;
        other.vertices[a] = middle;
        other.weights[a] = weights;
        other.faces[b] = INNER;
        Some(other)
    }
}
