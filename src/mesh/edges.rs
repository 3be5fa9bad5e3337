//! The edges of a triangle mesh and who uses them.

use rayon::prelude::*;

use super::index;

/// One side of one triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct EdgeUse {
    /// Its vertices, the smaller first.
    pub(crate) edge: [u32; 2],
    /// The triangle.
    pub(crate) triangle: u32,
    /// Whether the triangle runs along it from the smaller to the larger vertex.
    pub(crate) forward: bool,
}

impl EdgeUse {
    /// The vertices in the direction that the triangle runs.
    pub(crate) fn directed(&self) -> [u32; 2] {
        let [a, b] = self.edge;
        if self.forward { [a, b] } else { [b, a] }
    }
}

/// The three sides of each of these triangles, by edge and then by triangle: `chunk_by` edge gives each
/// edge's triangles. A side between one vertex and itself is left out.
pub(crate) fn edge_uses(triangles: &[[u32; 3]], of: impl Iterator<Item = usize>) -> Vec<EdgeUse> {
    let mut uses: Vec<EdgeUse> = of
        .flat_map(|t| {
            let [a, b, c] = triangles[t];
            [[a, b], [b, c], [c, a]].map(|[u, v]| EdgeUse {
                edge: [u.min(v), u.max(v)],
                triangle: index(t),
                forward: u < v,
            })
        })
        .filter(|u| u.edge[0] != u.edge[1])
        .collect();
    uses.par_sort_unstable();
    uses
}

/// Sets that are merged: a forest over 0…n−1 whose roots are the smallest members.
pub(crate) struct Merging(Vec<u32>);

impl Merging {
    pub(crate) fn new(n: usize) -> Self {
        Self((0..index(n)).collect())
    }

    /// The smallest member of the set of `i`.
    pub(crate) fn root(&mut self, i: u32) -> u32 {
        let mut at = i;
        while self.0[at as usize] != at {
            // Halving the path keeps it short.
            let up = self.0[self.0[at as usize] as usize];
            self.0[at as usize] = up;
            at = up;
        }
        at
    }

    pub(crate) fn merge(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}
