//! Splitting edges of a tetrahedral mesh, all tetrahedra around them at once.

use glam::DVec3;
use rayon::prelude::*;

use super::{TetMesh, index, signed_volume};

/// The weights of a part that is a whole tetrahedron.
pub(crate) const WHOLE: u32 = u32::MAX;
/// A face inside the parent.
pub(crate) const INNER: u8 = 4;

/// Barycentric coordinates in the parent of a part's four vertices.
pub(crate) type Weights = [[f64; 4]; 4];

const IDENTITY: Weights =
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

/// A part of a tetrahedron.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Part {
    /// Its vertices; positive.
    pub(crate) vertices: [u32; 4],
    /// The tetrahedron that it is part of.
    pub(crate) parent: u32,
    /// The face of the parent that its face opposite each vertex lies on, or [`INNER`].
    pub(crate) faces: [u8; 4],
    /// Its place in [`Subdivision::weights`], or [`WHOLE`].
    pub(crate) weights: u32,
}

/// An edge and the place at which it is split.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Split {
    /// Its vertices, the smaller first.
    pub(crate) edge: [u32; 2],
    /// The new vertex's place, from 0 at the first vertex to 1 at the second.
    pub(crate) t: f64,
    /// Splits of higher rank come first.
    pub(crate) rank: f64,
}

impl Split {
    /// A split of no special rank.
    pub(crate) fn at(edge: [u32; 2], t: f64) -> Self {
        Self { edge, t, rank: 0.0 }
    }
}

/// A mesh whose tetrahedra are being divided.
#[derive(Debug)]
pub(crate) struct Subdivision {
    /// The mesh's vertices, then the new ones.
    pub(crate) vertices: Vec<DVec3>,
    /// How each new vertex came about.
    pub(crate) splits: Vec<Split>,
    /// The parts; those that a split adds stand at the end.
    pub(crate) parts: Vec<Part>,
    /// Weights of the parts that are no whole tetrahedra.
    pub(crate) weights: Vec<Weights>,
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
    pub(crate) fn new(mesh: &TetMesh) -> Self {
        Self::of(mesh, &(0..index(mesh.tets.len())).collect::<Vec<_>>())
    }

    /// Some tetrahedra, all whole. An edge may be split only where all tetrahedra around it are among them.
    pub(crate) fn of(mesh: &TetMesh, tets: &[u32]) -> Self {
        let part = |&t: &u32| Part {
            vertices: mesh.tets[t as usize],
            parent: t,
            faces: [0, 1, 2, 3],
            weights: WHOLE,
        };
        let parts = tets.iter().map(part).collect();
        Self { vertices: mesh.vertices.clone(), splits: Vec::new(), parts, weights: Vec::new() }
    }

    /// Corners of a part.
    pub(crate) fn corners(&self, part: &Part) -> [DVec3; 4] {
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
    pub(crate) fn split(&mut self, splits: &[Split]) -> Result<Vec<u32>, Vec<u32>> {
        let old = self.vertices.len();
        let mut marks = Marks::new(splits, old);
        let mut lengths = Vec::with_capacity(splits.len());
        for s in splits {
            let [a, b] = s.edge.map(|v| self.vertices[v as usize]);
            for v in s.edge {
                marks.touched[v as usize] = true;
            }
            lengths.push((b - a).length_squared());
            self.vertices.push(a + (b - a) * s.t);
        }
        let this = &*self;
        let hits: Vec<u32> = (0..index(this.parts.len()))
            .into_par_iter()
            .with_min_len(4096)
            .filter(|&i| marks.of(&this.parts[i as usize]).1 > 0)
            .collect();
        let batches: Vec<Batch> =
            hits.par_chunks(256).map(|c| this.slice(c, &marks, &lengths, old)).collect();
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

    fn slice(&self, hits: &[u32], marks: &Marks<'_>, lengths: &[f64], old: usize) -> Batch {
        let mut counts = Vec::with_capacity(hits.len());
        let mut slices: Vec<Slice> = Vec::with_capacity(hits.len() * 5);
        let mut bad = Vec::new();
        for &i in hits {
            let part = &self.parts[i as usize];
            let splits = marks.splits;
            let (mut list, n) = marks.of(part);
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

/// Where the splits of a vertex's edges are found.
struct Marks<'a> {
    splits: &'a [Split],
    /// Whether each vertex is an end of a split edge.
    touched: Vec<bool>,
    /// Where the splits begin whose first vertex is this one, and the end.
    first: Vec<u32>,
}

impl<'a> Marks<'a> {
    fn new(splits: &'a [Split], vertices: usize) -> Self {
        let mut first = vec![0u32; vertices + 1];
        for s in splits {
            first[s.edge[0] as usize + 1] += 1;
        }
        for v in 0..vertices {
            first[v + 1] += first[v];
        }
        Self { splits, touched: vec![false; vertices], first }
    }

    /// The splits on a part's edges, by their places, and how many they are.
    fn of(&self, part: &Part) -> ([u32; 6], usize) {
        let (mut list, mut n) = ([0; 6], 0);
        let touched = part.vertices.map(|v| self.touched[v as usize]);
        if touched.iter().filter(|t| **t).count() < 2 {
            return (list, n);
        }
        for (edge, [i, j]) in edges(part.vertices).into_iter().zip(PAIRS) {
            if touched[i] && touched[j] {
                let mut range = self.first[edge[0] as usize]..self.first[edge[0] as usize + 1];
                if let Some(at) = range.find(|&s| self.splits[s as usize].edge[1] == edge[1]) {
                    list[n] = at;
                    n += 1;
                }
            }
        }
        (list, n)
    }
}

/// The edges of a tetrahedron by its local vertices.
const PAIRS: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

/// The six edges of a tetrahedron, the smaller vertex first.
pub(crate) fn edges(v: [u32; 4]) -> [[u32; 2]; 6] {
    PAIRS.map(|[a, b]| [v[a].min(v[b]), v[a].max(v[b])])
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
