//! The vertices of a mesh gathered in aggregates, and functions over these: the coarse problem of large meshes.

use glam::DVec3;
use rayon::prelude::*;

use super::graph::Graph;
use crate::mesh::{TetMesh, index};

/// The most aggregates: a coarse problem of some 12,000 unknowns is factored in about a second.
const AGGREGATES: usize = 4000;
/// Edges of less weight do not gather vertices.
const STRONG: f64 = 0.1;
/// Functions on an aggregate: 1, x, y, z.
pub(super) const FUNCTIONS: usize = 4;
/// Rows that one thread takes at a time.
const CHUNK: usize = 2048;

/// An aggregate and the values of its four functions.
pub(super) type Values = (u32, [f64; FUNCTIONS]);

/// Rows over the coarse functions.
pub(super) struct Rows {
    start: Vec<usize>,
    entries: Vec<Values>,
}

impl Rows {
    /// The entries of a row, by aggregate.
    pub(super) fn of(&self, v: usize) -> &[Values] {
        &self.entries[self.start[v]..self.start[v + 1]]
    }

    /// New rows, each a sum of old ones: `parts` calls its argument with each of them and its factor.
    pub(super) fn combined(
        &self,
        count: usize,
        parts: impl Fn(usize, &mut dyn FnMut(usize, f64)) + Sync,
    ) -> Self {
        let chunks: Vec<(Vec<usize>, Vec<Values>)> = (0..count.div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| {
                let (mut lengths, mut entries): (Vec<usize>, Vec<Values>) = (Vec::new(), Vec::new());
                for v in chunk * CHUNK..((chunk + 1) * CHUNK).min(count) {
                    let first = entries.len();
                    parts(v, &mut |w, factor| {
                        for (aggregate, values) in self.of(w) {
                            let mine = &mut entries[first..];
                            match mine.iter_mut().find(|(a, _)| a == aggregate) {
                                Some((_, sum)) => {
                                    for (s, x) in sum.iter_mut().zip(values) {
                                        *s += factor * x;
                                    }
                                }
                                None => entries.push((*aggregate, values.map(|x| factor * x))),
                            }
                        }
                    });
                    entries[first..].sort_unstable_by_key(|e| e.0);
                    lengths.push(entries.len() - first);
                }
                (lengths, entries)
            })
            .collect();
        let mut rows = Self { start: vec![0], entries: Vec::new() };
        let mut end = 0;
        rows.start.reserve(count);
        rows.entries.reserve(chunks.iter().map(|c| c.1.len()).sum());
        for (lengths, entries) in chunks {
            for length in lengths {
                end += length;
                rows.start.push(end);
            }
            rows.entries.extend(entries);
        }
        rows
    }
}

/// The aggregate of each vertex, and their number: vertices within some edges of one in the middle.
pub(super) fn aggregates(graph: &Graph, weights: &[f64]) -> (Vec<u32>, usize) {
    const FREE: u32 = u32::MAX;
    let n = graph.len();
    // Some 70 vertices lie within two edges; their number grows with the cube.
    let radius = (2..).find(|r: &usize| n / (9 * r * r * r) <= AGGREGATES).unwrap_or(2);
    let near = |v: usize| {
        let edges = graph.of(v).iter().zip(&weights[graph.range(v)]);
        edges.filter(|(_, w)| **w >= STRONG).map(|(&w, _)| w as usize)
    };
    let mut aggregate = vec![FREE; n];
    let mut count = 0;
    let mut ball = Vec::new();
    for v in 0..n {
        if aggregate[v] != FREE || near(v).any(|w| aggregate[w] != FREE) {
            continue;
        }
        aggregate[v] = count;
        ball.clear();
        ball.push(v);
        let mut ring = 0;
        for _ in 0..radius {
            let end = ball.len();
            for k in ring..end {
                for w in near(ball[k]) {
                    if aggregate[w] == FREE {
                        aggregate[w] = count;
                        ball.push(w);
                    }
                }
            }
            ring = end;
        }
        count += 1;
    }
    // What is left between them joins a neighbour, ring by ring; what has none is alone.
    let mut left: Vec<usize> = (0..n).filter(|&v| aggregate[v] == FREE).collect();
    while !left.is_empty() {
        let joins: Vec<(usize, u32)> = left
            .iter()
            .filter_map(|&v| Some((v, near(v).map(|w| aggregate[w]).filter(|a| *a != FREE).min()?)))
            .collect();
        if joins.is_empty() {
            aggregate[left[0]] = count;
            count += 1;
        }
        for (v, a) in joins {
            aggregate[v] = a;
        }
        left.retain(|&v| aggregate[v] == FREE);
    }
    (aggregate, count as usize)
}

/// 1, x, y and z on each aggregate, made orthonormal there, and the aggregates' centres. What is no new function
/// on a small or flat aggregate is 0.
pub(super) fn linear_functions(mesh: &TetMesh, aggregate: &[u32], count: usize) -> (Rows, Vec<DVec3>) {
    let mut members: Vec<Vec<u32>> = vec![Vec::new(); count];
    for (v, a) in aggregate.iter().enumerate() {
        members[*a as usize].push(index(v));
    }
    let mut values = vec![[0.0; FUNCTIONS]; aggregate.len()];
    let mut centres = Vec::with_capacity(count);
    for members in &members {
        let at = |v: u32| mesh.vertices[v as usize];
        let centre = members.iter().map(|v| at(*v)).sum::<DVec3>() / members.len() as f64;
        centres.push(centre);
        let mut columns: Vec<Vec<f64>> = vec![vec![1.0; members.len()]];
        columns.extend((0..3).map(|axis| members.iter().map(|v| (at(*v) - centre)[axis]).collect()));
        let size = (1..FUNCTIONS).flat_map(|c| &columns[c]).fold(0.0f64, |a, b| a.max(b.abs()));
        for c in 0..FUNCTIONS {
            let (done, rest) = columns.split_at_mut(c);
            let column = &mut rest[0];
            // Twice: rounding leaves a little after the first time.
            for _ in 0..2 {
                for other in &*done {
                    let along: f64 = other.iter().zip(&*column).map(|(a, b)| a * b).sum();
                    for (x, o) in column.iter_mut().zip(other) {
                        *x -= along * o;
                    }
                }
            }
            let length = column.iter().map(|x| x * x).sum::<f64>().sqrt();
            let least = if c == 0 { 0.0 } else { 1e-3 * size };
            let factor = if length > least { 1.0 / length } else { 0.0 };
            for x in column.iter_mut() {
                *x *= factor;
            }
        }
        for (n, v) in members.iter().enumerate() {
            values[*v as usize] = std::array::from_fn(|c| columns[c][n]);
        }
    }
    let rows = Rows {
        start: (0..=aggregate.len()).collect(),
        entries: aggregate.iter().copied().zip(values).collect(),
    };
    (rows, centres)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::laplacian::weights;
    use crate::mesh::shapes::grid;

    #[test]
    fn every_vertex_is_in_one_aggregate_and_none_is_large() {
        let graph = Graph::new(&grid(12));
        let (aggregate, count) = aggregates(&graph, &weights(&graph, None));
        let mut sizes = vec![0; count];
        for a in aggregate {
            sizes[a as usize] += 1;
        }
        assert!(sizes.iter().all(|s| (1..=200).contains(s)), "{sizes:?}");
        assert!(count > 13 * 13 * 13 / 150);
    }
}
