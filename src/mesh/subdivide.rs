//! Splitting edges of a tetrahedral mesh, all tetrahedra around them at once.

use std::ops::Range;
use std::sync::LazyLock;

use glam::DVec3;
use rayon::prelude::*;

use super::{NONE, TetMesh, index, signed_volume};

/// A face inside the parent.
pub(crate) const INNER: u8 = 4;

/// Barycentric coordinates in the parent of a part's four vertices.
pub(crate) type Weights = [[f64; 4]; 4];

/// Where a new vertex lies in the mesh before any split: weights of at most four of its vertices, those of one
/// tetrahedron, each once. What is left of the four has weight 0.
#[derive(Debug, Clone, Copy)]
struct Place {
    vertices: [u32; 4],
    weights: [f64; 4],
}

/// A part of a tetrahedron.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Part {
    /// Its vertices; positive.
    pub(crate) vertices: [u32; 4],
    /// The tetrahedron that it is part of.
    pub(crate) parent: u32,
    /// The face of the parent that its face opposite each vertex lies on, or [`INNER`].
    pub(crate) faces: [u8; 4],
    /// Whether it is all of that tetrahedron.
    pub(crate) whole: bool,
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
    /// Where each new vertex lies.
    places: Vec<Place>,
    /// How many vertices the mesh has.
    own: usize,
}

/// A part under division.
#[derive(Clone, Copy)]
struct Slice {
    vertices: [u32; 4],
    faces: [u8; 4],
}

/// What a run of parts divides into: those that do, with how many slices each, all slices, and the splits that leave a
/// bad one.
type Batch = (Vec<(u32, u8)>, Vec<Slice>, Vec<u32>);

/// Parts in a run.
const BATCH: usize = 1024;

impl Subdivision {
    /// All tetrahedra whole.
    pub(crate) fn new(mesh: &TetMesh) -> Self {
        Self::of(mesh, &(0..index(mesh.tets.len())).collect::<Vec<_>>())
    }

    /// Some tetrahedra, all whole. An edge may be split only where all tetrahedra around it are among them.
    pub(crate) fn of(mesh: &TetMesh, tets: &[u32]) -> Self {
        let part =
            |&t: &u32| Part { vertices: mesh.tets[t as usize], parent: t, faces: [0, 1, 2, 3], whole: true };
        let parts = tets.iter().map(part).collect();
        let vertices = mesh.vertices.clone();
        let own = vertices.len();
        Self { vertices, splits: Vec::new(), parts, places: Vec::new(), own }
    }

    /// Corners of a part.
    pub(crate) fn corners(&self, part: &Part) -> [DVec3; 4] {
        part.vertices.map(|v| self.vertices[v as usize])
    }

    /// Barycentric coordinates of a part's vertices in its tetrahedron, which has these vertices.
    pub(crate) fn weights(&self, part: &Part, tet: [u32; 4]) -> Weights {
        part.vertices.map(|v| {
            let place = self.place(v);
            tet.map(|w| place.vertices.iter().position(|u| *u == w).map_or(0.0, |k| place.weights[k]))
        })
    }

    /// Where a vertex lies.
    fn place(&self, v: u32) -> Place {
        match (v as usize).checked_sub(self.own) {
            Some(new) => self.places[new],
            None => Place { vertices: [v, NONE, NONE, NONE], weights: [1.0, 0.0, 0.0, 0.0] },
        }
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
        let batches: Vec<Batch> = (0..this.parts.len())
            .into_par_iter()
            .step_by(BATCH)
            .map(|from| this.slice(from..this.parts.len().min(from + BATCH), &marks, &lengths, old))
            .collect();
        let mut bad: Vec<u32> = batches.iter().flat_map(|b| b.2.iter().copied()).collect();
        if !bad.is_empty() {
            self.vertices.truncate(old);
            bad.sort_unstable();
            bad.dedup();
            return Err(bad);
        }
        for s in splits {
            let [a, b] = s.edge.map(|v| self.place(v));
            self.places.push(a.towards(&b, s.t));
        }
        self.splits.extend_from_slice(splits);
        let mut changed = Vec::new();
        for (hits, slices, _) in &batches {
            let mut rest = &slices[..];
            for &(i, count) in hits {
                let (mine, after) = rest.split_at(usize::from(count));
                rest = after;
                let was = self.parts[i as usize];
                for (n, slice) in mine.iter().enumerate() {
                    let Slice { vertices, faces } = *slice;
                    let part = Part { vertices, parent: was.parent, faces, whole: false };
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

    fn slice(&self, parts: Range<usize>, marks: &Marks<'_>, lengths: &[f64], old: usize) -> Batch {
        let mut hits = Vec::with_capacity(parts.len());
        let mut slices: Vec<Slice> = Vec::with_capacity(parts.len() * 2);
        let mut bad = Vec::new();
        let ways = Ways::all();
        for (i, part) in parts.clone().zip(&self.parts[parts]) {
            let (mut list, n) = marks.of(part);
            if n == 0 {
                continue;
            }
            let list = &mut list[..n];
            let key = |s: u32| (marks.splits[s as usize].rank, lengths[s as usize]);
            list.sort_unstable_by(|&(a, _), &(b, _)| {
                let (x, y) = (key(a), key(b));
                y.0.total_cmp(&x.0).then(y.1.total_cmp(&x.1)).then(a.cmp(&b))
            });
            let [a, b, c, d] = part.vertices;
            let mut vertices = [a, b, c, d, NONE, NONE, NONE, NONE, NONE, NONE];
            for &(s, edge) in &*list {
                vertices[4 + usize::from(edge)] = index(old) + s;
            }
            let start = slices.len();
            slices.extend(ways.after(list.iter().map(|l| l.1)).iter().map(|slice| Slice {
                vertices: slice.vertices.map(|v| vertices[usize::from(v)]),
                faces: slice.faces.map(|f| if f == INNER { INNER } else { part.faces[usize::from(f)] }),
            }));
            let flat = |s: &Slice| signed_volume(s.vertices.map(|v| self.vertices[v as usize])) <= 0.0;
            if slices[start..].iter().any(flat) {
                bad.extend(list.iter().map(|l| l.0));
            }
            hits.push((index(i), (slices.len() - start) as u8));
        }
        (hits, slices, bad)
    }
}

impl Place {
    /// The place on the way to another in the same tetrahedron, from 0 here to 1 there.
    fn towards(&self, other: &Self, t: f64) -> Self {
        let weight = |place: &Self, v: u32| {
            place.vertices.iter().position(|u| *u == v).map_or(0.0, |k| place.weights[k])
        };
        let mut result = Self { vertices: self.vertices, weights: [0.0; 4] };
        for v in other.vertices {
            // One tetrahedron has four vertices: there is room.
            let free = result.vertices.iter().position(|u| *u == NONE || *u == v);
            if let Some(free) = free.filter(|_| v != NONE) {
                result.vertices[free] = v;
            }
        }
        for (v, w) in result.vertices.into_iter().zip(&mut result.weights).filter(|(v, _)| *v != NONE) {
            let (a, b) = (weight(self, v), weight(other, v));
            *w = a + (b - a) * t;
        }
        result
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

    /// The splits on a part's edges, by their places, with the edges' places among the part's, and how many they are.
    fn of(&self, part: &Part) -> ([(u32, u8); 6], usize) {
        let (mut list, mut n) = ([(0, 0); 6], 0);
        let touched = part.vertices.map(|v| self.touched[v as usize]);
        if touched.iter().filter(|t| **t).count() < 2 {
            return (list, n);
        }
        for (k, (edge, [i, j])) in edges(part.vertices).into_iter().zip(PAIRS).enumerate() {
            if touched[i] && touched[j] {
                let mut range = self.first[edge[0] as usize]..self.first[edge[0] as usize + 1];
                if let Some(at) = range.find(|&s| self.splits[s as usize].edge[1] == edge[1]) {
                    list[n] = (at, k as u8);
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

/// An edge as one number, in the order of edges: it sorts much faster.
pub(crate) fn edge_key([a, b]: [u32; 2]) -> u64 {
    u64::from(a) << 32 | u64::from(b)
}

/// The edge of a key.
pub(crate) fn keyed_edge(key: u64) -> [u32; 2] {
    [(key >> 32) as u32, key as u32]
}

/// Every way in which a tetrahedron divides when some of its edges are split one after the other: a tree with a
/// branch for each edge that may come next.
struct Ways {
    /// By edge, which way it is to split that one too; 0 where it is split already.
    next: Vec<[u16; 6]>,
    /// What each way leaves.
    slices: Vec<Vec<Local>>,
}

/// A slice of a tetrahedron: its vertices, of which 0 to 3 are the tetrahedron's and 4 + k lies on its k-th edge,
/// and the faces that they lie opposite to, or [`INNER`].
#[derive(Clone, Copy)]
struct Local {
    vertices: [u8; 4],
    faces: [u8; 4],
}

impl Ways {
    fn all() -> &'static Self {
        static ALL: LazyLock<Ways> = LazyLock::new(Ways::new);
        &ALL
    }

    fn new() -> Self {
        let whole = Local { vertices: [0, 1, 2, 3], faces: [0, 1, 2, 3] };
        let mut ways = Self { next: Vec::new(), slices: vec![vec![whole]] };
        // Which edges each way has split, by bits.
        let mut split = vec![0u8];
        while let Some(slices) = ways.slices.get(ways.next.len()) {
            let (slices, done) = (slices.clone(), split[ways.next.len()]);
            let mut next = [0; 6];
            for k in (0..6).filter(|k| done & 1 << k == 0) {
                let mut more = slices.clone();
                for n in 0..more.len() {
                    let other = more[n].bisect(k);
                    more.extend(other);
                }
                next[k] = ways.slices.len() as u16;
                ways.slices.push(more);
                split.push(done | 1 << k);
            }
            ways.next.push(next);
        }
        ways
    }

    /// What is left when these edges, each once, have been split in this order.
    fn after(&self, edges: impl Iterator<Item = u8>) -> &[Local] {
        let way = edges.fold(0, |way, edge| usize::from(self.next[way][usize::from(edge)]));
        &self.slices[way]
    }
}

impl Local {
    /// If the tetrahedron's k-th edge is one of its own, it becomes the half at the edge's first vertex, and the other
    /// half is returned.
    fn bisect(&mut self, k: usize) -> Option<Self> {
        let [a, b] = PAIRS[k].map(|v| self.vertices.iter().position(|&own| usize::from(own) == v));
        let (a, b, middle) = (a?, b?, 4 + k as u8);
        // Each half swaps one vertex; the face between the halves lies opposite the vertex that stays.
        let mut other = *self;
        self.vertices[b] = middle;
        self.faces[a] = INNER;
        other.vertices[a] = middle;
        other.faces[b] = INNER;
        Some(other)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A corner, or the middle of an edge.
    fn at(v: u8) -> DVec3 {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        match usize::from(v).checked_sub(4) {
            None => corners[usize::from(v)],
            Some(k) => PAIRS[k].map(|i| corners[i]).into_iter().sum::<DVec3>() / 2.0,
        }
    }

    #[test]
    fn every_way_to_divide_fills_the_tetrahedron() {
        let ways = Ways::all();
        // The ordered choices of up to six edges of six.
        assert_eq!(ways.slices.len(), 1 + 6 + 30 + 120 + 360 + 720 + 720);
        for slices in &ways.slices {
            let volumes = slices.iter().map(|s| signed_volume(s.vertices.map(at)));
            assert!(volumes.clone().all(|v| v > 0.0));
            assert!((volumes.sum::<f64>() - 1.0 / 6.0).abs() < 1e-12);
            for slice in slices {
                for (k, &face) in slice.faces.iter().enumerate().filter(|(_, face)| **face != INNER) {
                    // A point of the face opposite the tetrahedron's vertex n has no share of that vertex.
                    let share = |p: DVec3| match face {
                        0 => 1.0 - p.element_sum(),
                        n => p[usize::from(n) - 1],
                    };
                    let others = (0..4).filter(|j| *j != k).map(|j| at(slice.vertices[j]));
                    assert!(others.into_iter().all(|p| share(p).abs() < 1e-12));
                }
            }
        }
        // Three edges at a corner leave that corner and a prism of three.
        assert_eq!(ways.after([0, 1, 2].into_iter()).len(), 4);
        assert_eq!(ways.after([1, 2, 3, 4].into_iter()).len(), 6);
    }
}
