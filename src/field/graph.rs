//! The vertices of a tetrahedral mesh as a graph.

use std::collections::VecDeque;

use glam::DVec3;

use crate::mesh::{TetMesh, index};

/// Neighbours of each vertex along the edges of the mesh.
pub(crate) struct Graph {
    start: Vec<usize>,
    neighbours: Vec<u32>,
    /// Mean length of the edges; 0 without edges.
    pub(crate) mean_edge: f64,
}

impl Graph {
    pub(crate) fn new(mesh: &TetMesh) -> Self {
        let edges = mesh.edges();
        let mut start = vec![0; mesh.vertices.len() + 1];
        for v in edges.iter().flatten() {
            start[*v as usize + 1] += 1;
        }
        for v in 0..mesh.vertices.len() {
            start[v + 1] += start[v];
        }
        let mut end = start.clone();
        let mut neighbours = vec![0; 2 * edges.len()];
        let mut length = 0.0;
        for &[a, b] in &edges {
            length += mesh.vertices[a as usize].distance(mesh.vertices[b as usize]);
            for (from, to) in [(a, b), (b, a)] {
                neighbours[end[from as usize]] = to;
                end[from as usize] += 1;
            }
        }
        Self { start, neighbours, mean_edge: length / (edges.len().max(1) as f64) }
    }

    /// Number of vertices.
    pub(crate) fn len(&self) -> usize {
        self.start.len() - 1
    }

    /// Neighbours of vertex `v`.
    pub(crate) fn of(&self, v: usize) -> &[u32] {
        &self.neighbours[self.start[v]..self.start[v + 1]]
    }

    /// Where in an array along all edges the entries of vertex `v` lie.
    pub(crate) fn range(&self, v: usize) -> std::ops::Range<usize> {
        self.start[v]..self.start[v + 1]
    }

    /// The connected component of each vertex, numbered by first vertex.
    pub(crate) fn components(&self) -> Vec<u32> {
        let mut component = vec![u32::MAX; self.len()];
        let mut count = 0;
        let mut queue = VecDeque::new();
        for v in 0..self.len() {
            if component[v] != u32::MAX {
                continue;
            }
            component[v] = count;
            queue.push_back(v);
            while let Some(u) = queue.pop_front() {
                for &w in self.of(u) {
                    if component[w as usize] == u32::MAX {
                        component[w as usize] = count;
                        queue.push_back(w as usize);
                    }
                }
            }
            count += 1;
        }
        component
    }

    /// Fills the gaps of a field of unit vectors ring by ring: each missing vector becomes the mean of
    /// the known ones beside it, as `shape` makes it fit its vertex (`None`: it does not). Where the
    /// mean does not fit, the first neighbour's vector that does; where none does, or where nothing is
    /// known nearby, `any`.
    pub(crate) fn fill_gaps(
        &self,
        field: &[Option<DVec3>],
        shape: impl Fn(usize, DVec3) -> Option<DVec3>,
        any: impl Fn(usize) -> DVec3,
    ) -> Vec<DVec3> {
        let mut known = field.to_vec();
        let mut ring: Vec<u32> = (0..self.len())
            .filter(|&v| known[v].is_none() && self.of(v).iter().any(|&w| known[w as usize].is_some()))
            .map(index)
            .collect();
        while !ring.is_empty() {
            let found: Vec<DVec3> = ring
                .iter()
                .map(|&v| {
                    let beside = || self.of(v as usize).iter().filter_map(|&w| known[w as usize]);
                    let count = beside().count() as f64;
                    let mean = beside().sum::<DVec3>() / count;
                    // A mean that is short is what is left after vectors all round cancelled: noise.
                    (mean.length() > 0.1)
                        .then_some(mean)
                        .into_iter()
                        .chain(beside())
                        .find_map(|r| shape(v as usize, r))
                        .unwrap_or_else(|| any(v as usize))
                })
                .collect();
            for (&v, r) in ring.iter().zip(found) {
                known[v as usize] = Some(r);
            }
            let mut next: Vec<u32> = ring
                .iter()
                .flat_map(|&v| self.of(v as usize))
                .copied()
                .filter(|&w| known[w as usize].is_none())
                .collect();
            next.sort_unstable();
            next.dedup();
            ring = next;
        }
        known.into_iter().enumerate().map(|(v, r)| r.unwrap_or_else(|| any(v))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::{ball, both, grid, mapped};

    #[test]
    fn the_graph_knows_neighbours_and_components() {
        let one = grid(2);
        let graph = Graph::new(&one);
        assert_eq!(graph.len(), 27);
        for v in 0..27 {
            for &w in graph.of(v) {
                assert!(graph.of(w as usize).contains(&index(v)));
            }
        }
        assert!((0..27).map(|v| graph.of(v).len()).sum::<usize>() == 2 * one.edges().len());
        let two = Graph::new(&both(&one, &mapped(&ball(1, 2), |p| p * 0.1 - DVec3::ONE)));
        let components = two.components();
        assert!(components[..27].iter().all(|&c| c == 0) && components[27..].iter().all(|&c| c == 1));
    }

    #[test]
    fn gaps_take_the_mean_of_what_is_beside_them() {
        let mesh = grid(4);
        let graph = Graph::new(&mesh);
        let field: Vec<Option<DVec3>> =
            mesh.vertices.iter().map(|p| (p.x < 0.3).then_some(DVec3::Y)).collect();
        let filled = graph.fill_gaps(&field, |_, r| r.try_normalize(), |_| DVec3::Z);
        assert!(filled.iter().all(|r| (*r - DVec3::Y).length() < 1e-12));
        let nothing = graph.fill_gaps(&vec![None; graph.len()], |_, r| Some(r), |_| DVec3::Z);
        assert!(nothing.iter().all(|r| *r == DVec3::Z));
        let refused = graph.fill_gaps(&field, |_, _| None, |_| DVec3::Z);
        assert!(refused.iter().zip(&field).all(|(r, f)| *r == f.unwrap_or(DVec3::Z)));
    }
}
