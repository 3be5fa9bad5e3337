//! The nodes and edges on which periodic coordinates live: the mesh's own, slit open along seams.

use glam::DVec3;
use rayon::prelude::*;

use crate::mesh::{TET_FACES, TetMesh, index};

/// The edges of a tetrahedron, by local vertices.
pub(super) const PAIRS: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

/// Nodes and edges of a mesh. Without seams a node is a vertex.
pub(super) struct Web {
    /// The nodes of each tetrahedron.
    pub(super) tets: Vec<[u32; 4]>,
    /// Where each node lies.
    pub(super) places: Vec<DVec3>,
    /// The nodes of each edge, the smaller one first.
    pub(super) edges: Vec<[u32; 2]>,
    /// The edges of each tetrahedron, in the order of [`PAIRS`].
    pub(super) tet_edges: Vec<[u32; 6]>,
    /// What each edge counts in the least squares.
    pub(super) weights: Vec<f64>,
}

impl Web {
    pub(super) fn new(mesh: &TetMesh, seams: &[(u32, u8)]) -> Self {
        let (tets, places) =
            if seams.is_empty() { (mesh.tets.clone(), mesh.vertices.clone()) } else { slit(mesh, seams) };
        let mut pairs: Vec<(u64, u32)> = (tets.iter().enumerate())
            .flat_map(|(t, nodes)| {
                PAIRS.iter().enumerate().map(move |(n, pair)| {
                    let [a, b] = pair.map(|k| u64::from(nodes[k]));
                    (a.min(b) << 32 | a.max(b), index(6 * t + n))
                })
            })
            .collect();
        pairs.par_sort_unstable();
        let mut edges: Vec<[u32; 2]> = Vec::new();
        let mut tet_edges = vec![[0; 6]; tets.len()];
        for same in pairs.chunk_by(|a, b| a.0 == b.0) {
            for &(_, slot) in same {
                tet_edges[slot as usize / 6][slot as usize % 6] = index(edges.len());
            }
            edges.push([(same[0].0 >> 32) as u32, same[0].0 as u32]);
        }
        let mut weights = vec![0.0; edges.len()];
        for (t, own) in tet_edges.iter().enumerate() {
            let p = mesh.corners(t);
            let square = PAIRS.iter().map(|[a, b]| p[*a].distance_squared(p[*b])).sum::<f64>() / 6.0;
            // Of a regular tetrahedron the edges' squared differences then sum to its volume times the slope squared.
            let weight = mesh.tet_volume(t) / (2.0 * square);
            for e in own {
                weights[*e as usize] += weight;
            }
        }
        Self { tets, places, edges, tet_edges, weights }
    }

    /// By how much a coordinate with these covectors rises along each edge: the mean over the tetrahedra around it,
    /// weighted by volume.
    pub(super) fn steps(&self, mesh: &TetMesh, covectors: &[DVec3]) -> Vec<f64> {
        let mut sums = vec![(DVec3::ZERO, 0.0); self.edges.len()];
        for (t, (own, g)) in self.tet_edges.iter().zip(covectors).enumerate() {
            let volume = mesh.tet_volume(t);
            for e in own {
                let sum = &mut sums[*e as usize];
                sum.0 += *g * volume;
                sum.1 += volume;
            }
        }
        (self.edges.iter().zip(sums))
            .map(|(&[a, b], (g, volume))| g.dot(self.places[b as usize] - self.places[a as usize]) / volume)
            .collect()
    }

    /// A quarter of the volume around each node, over the square of how long the period is there.
    pub(super) fn masses(&self, mesh: &TetMesh, period: &[f64]) -> Vec<f64> {
        let mut masses = vec![0.0; self.places.len()];
        for (t, (nodes, period)) in self.tets.iter().zip(period).enumerate() {
            for n in nodes {
                masses[*n as usize] += mesh.tet_volume(t) / (4.0 * period * period);
            }
        }
        masses
    }
}

/// The nodes of a mesh that is slit along faces: corners of tetrahedra are one node where a way around their vertex
/// leads from one to the other without crossing a seam.
fn slit(mesh: &TetMesh, seams: &[(u32, u8)]) -> (Vec<[u32; 4]>, Vec<DVec3>) {
    let mut closed = vec![[false; 4]; mesh.tets.len()];
    for &(t, k) in seams {
        closed[t as usize][k as usize] = true;
    }
    // A union-find over all corners.
    let mut parent: Vec<u32> = (0..index(4 * mesh.tets.len())).collect();
    fn root(parent: &mut [u32], mut c: u32) -> u32 {
        while parent[c as usize] != c {
            parent[c as usize] = parent[parent[c as usize] as usize];
            c = parent[c as usize];
        }
        c
    }
    for (t, around) in mesh.neighbours.iter().enumerate() {
        for (k, &n) in around.iter().enumerate() {
            // Each face once; the boundary's number is larger than all.
            if (n as usize) >= t || closed[t][k] {
                continue;
            }
            for i in TET_FACES[k] {
                let v = mesh.tets[t][i];
                let Some(j) = mesh.tets[n as usize].iter().position(|&w| w == v) else { continue };
                let (a, b) =
                    (root(&mut parent, index(4 * t + i)), root(&mut parent, index(4 * n as usize + j)));
                parent[a.max(b) as usize] = a.min(b);
            }
        }
    }
    let mut number = vec![u32::MAX; parent.len()];
    let mut places = Vec::new();
    let tets = (0..mesh.tets.len())
        .map(|t| {
            std::array::from_fn(|k| {
                let at = root(&mut parent, index(4 * t + k)) as usize;
                if number[at] == u32::MAX {
                    number[at] = index(places.len());
                    places.push(mesh.vertices[mesh.tets[t][k] as usize]);
                }
                number[at]
            })
        })
        .collect();
    (tets, places)
}
