//! Holes, and edges and vertices where the surface is no surface.

use glam::DVec3;
use rayon::prelude::*;

use super::{AtEdge, AtVertex, Defects, Hole, PLACES};
use crate::mesh::edges::{EdgeUse, Merging, edge_uses};
use crate::mesh::{TriMesh, index};

pub(super) fn look(mesh: &TriMesh, triangles: &[usize], found: &mut Defects) {
    let at = |v: u32| mesh.vertices[v as usize];
    let uses = edge_uses(&mesh.triangles, triangles.iter().copied());
    let mut boundary = Vec::new();
    for around in uses.chunk_by(|a, b| a.edge == b.edge) {
        let first = around[0];
        let here = || AtEdge {
            vertices: first.edge,
            triangles: around.len(),
            triangle: first.triangle,
            at: (at(first.edge[0]) + at(first.edge[1])) / 2.0,
        };
        match around {
            [_] => boundary.push(first),
            [a, b] if a.forward == b.forward => found.inconsistent_edges.add(here),
            [_, _] => {}
            _ => found.non_manifold_edges.add(here),
        }
    }
    found.boundary_edges = boundary.len();
    let mut holes = holes(mesh, &boundary);
    found.holes.count = holes.len();
    holes.sort_by_key(|hole| (std::cmp::Reverse(hole.edges), hole.triangle));
    holes.truncate(PLACES);
    found.holes.first = holes;
    for vertex in touching(mesh, triangles) {
        found.non_manifold_vertices.add(|| AtVertex { vertex, at: at(vertex) });
    }
}

/// Follows the boundary against the triangles' direction, from each edge that is left.
fn holes(mesh: &TriMesh, boundary: &[EdgeUse]) -> Vec<Hole> {
    // Each boundary edge as (from, to, triangle), by where it begins.
    let mut sides: Vec<[u32; 3]> = boundary
        .iter()
        .map(|side| {
            let [from, to] = side.directed();
            [to, from, side.triangle]
        })
        .collect();
    sides.sort_unstable();
    let mut used = vec![false; sides.len()];
    // For each vertex with sides, the first that may be unused: looked for from there on only.
    let mut next: Vec<usize> = (0..sides.len()).collect();
    let mut holes = Vec::new();
    for start in 0..sides.len() {
        if used[start] {
            continue;
        }
        let mut hole = Hole { edges: 0, length: 0.0, at: DVec3::ZERO, triangle: sides[start][2] };
        let mut side = start;
        loop {
            used[side] = true;
            let [from, to, triangle] = sides[side];
            let (a, b) = (mesh.vertices[from as usize], mesh.vertices[to as usize]);
            hole.edges += 1;
            hole.length += a.distance(b);
            hole.at += a;
            hole.triangle = hole.triangle.min(triangle);
            if to == sides[start][0] {
                break;
            }
            let group = sides.partition_point(|s| s[0] < to);
            if group == sides.len() {
                break;
            }
            while next[group] < sides.len() && sides[next[group]][0] == to && used[next[group]] {
                next[group] += 1;
            }
            side = next[group];
            if side >= sides.len() || sides[side][0] != to {
                break;
            }
        }
        hole.at /= hole.edges as f64;
        holes.push(hole);
    }
    holes
}

/// The vertices whose triangles do not form one fan.
fn touching(mesh: &TriMesh, triangles: &[usize]) -> Vec<u32> {
    let mut corners: Vec<[u32; 2]> =
        triangles.iter().flat_map(|&t| mesh.triangles[t].map(|v| [v, index(t)])).collect();
    corners.par_sort_unstable();
    let fans: Vec<&[[u32; 2]]> = corners.chunk_by(|a, b| a[0] == b[0]).collect();
    let touches: Vec<bool> = fans
        .par_iter()
        .with_min_len(1024)
        .map(|fan| {
            let vertex = fan[0][0];
            // Neighbours in the fan share another vertex.
            let mut others: Vec<[u32; 2]> = Vec::with_capacity(fan.len() * 2);
            for (i, [_, t]) in fan.iter().enumerate() {
                let rest = mesh.triangles[*t as usize].into_iter().filter(|&v| v != vertex);
                others.extend(rest.map(|v| [v, index(i)]));
            }
            others.sort_unstable();
            let mut parts = Merging::new(fan.len());
            for pair in others.windows(2).filter(|w| w[0][0] == w[1][0]) {
                parts.merge(pair[0][1], pair[1][1]);
            }
            (0..index(fan.len())).any(|i| parts.root(i) != 0)
        })
        .collect();
    fans.iter().zip(touches).filter(|(_, touches)| *touches).map(|(fan, _)| fan[0][0]).collect()
}
