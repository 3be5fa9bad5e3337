//! Every part of a surface turned the right way round.

use std::collections::VecDeque;

use glam::DVec3;
use rayon::prelude::*;

use super::{CleanReport, Provenance};
use crate::mesh::boxes::{BoxTree, box_of};
use crate::mesh::edges::{EdgeUse, edge_uses};
use crate::mesh::exact::{Above, above};
use crate::mesh::{NONE, TriMesh, index};

/// A part of the surface that hangs together over edges of two triangles.
struct Shell {
    triangles: Vec<u32>,
    /// Each of its edges has an even number of its triangles, and they could be oriented consistently.
    closed: bool,
}

/// Orients every part consistently and closed ones outwards, cavities inwards.
pub(super) fn orient(mesh: &mut TriMesh, from: &mut Provenance, report: &mut CleanReport) {
    let uses = edge_uses(&mesh.triangles, 0..mesh.triangles.len());
    let mut turned = vec![false; mesh.triangles.len()];
    let shells = shells(mesh, &uses, &mut turned);
    let closed: Vec<&Shell> = shells.iter().filter(|s| s.closed).collect();
    let depths = depths(mesh, &closed);
    report.shells = shells.len();
    report.closed_shells = closed.len();
    report.cavities = depths.iter().filter(|&d| d % 2 == 1).count();
    let mut depths = depths.into_iter();
    for shell in &shells {
        let outwards = if shell.closed {
            let volume = volume(mesh, shell, &turned);
            // Without a volume to tell by, as an open part.
            (volume != 0.0).then_some(volume > 0.0)
        } else {
            None
        };
        let cavity = shell.closed && depths.next().is_some_and(|d| d % 2 == 1);
        let turn = match outwards {
            Some(outwards) => outwards == cavity,
            None => {
                2 * shell.triangles.iter().filter(|&&t| turned[t as usize]).count() > shell.triangles.len()
            }
        };
        if turn {
            shell.triangles.iter().for_each(|&t| turned[t as usize] ^= true);
        }
    }
    for (t, _) in turned.iter().enumerate().filter(|(_, turned)| **turned) {
        mesh.triangles[t].swap(1, 2);
        from.turn(t);
        report.flipped += 1;
    }
}

/// The parts, in the order of their first triangles; `turned` becomes whether a triangle must be turned to
/// agree with its part's first.
fn shells(mesh: &TriMesh, uses: &[EdgeUse], turned: &mut [bool]) -> Vec<Shell> {
    let count = mesh.triangles.len();
    // Across each side of each triangle, in the order of its corners: the other triangle, and whether it
    // runs along the edge in the same direction.
    let mut across = vec![[(NONE, false); 3]; count];
    for pair in uses.chunk_by(|a, b| a.edge == b.edge) {
        if let [a, b] = pair {
            for (from, to) in [(a, b), (b, a)] {
                let [u, _] = from.directed();
                let corners = mesh.triangles[from.triangle as usize];
                if let Some(k) = corners.iter().position(|&v| v == u) {
                    across[from.triangle as usize][k] = (to.triangle, a.forward == b.forward);
                }
            }
        }
    }
    let mut part = vec![NONE; count];
    let mut shells: Vec<Shell> = Vec::new();
    for first in 0..count {
        if part[first] != NONE {
            continue;
        }
        let number = index(shells.len());
        let mut shell = Shell { triangles: Vec::new(), closed: true };
        let mut queue = VecDeque::from([index(first)]);
        part[first] = number;
        while let Some(t) = queue.pop_front() {
            shell.triangles.push(t);
            for &(other, same) in across[t as usize].iter().filter(|side| side.0 != NONE) {
                let should = turned[t as usize] ^ same;
                if part[other as usize] == NONE {
                    part[other as usize] = number;
                    turned[other as usize] = should;
                    queue.push_back(other);
                } else if turned[other as usize] != should {
                    // One-sided, like a Möbius strip.
                    shell.closed = false;
                }
            }
        }
        shells.push(shell);
    }
    for around in uses.chunk_by(|a, b| a.edge == b.edge).filter(|around| around.len() != 2) {
        let mut parts: Vec<u32> = around.iter().map(|u| part[u.triangle as usize]).collect();
        parts.sort_unstable();
        for same in parts.chunk_by(|a, b| a == b).filter(|same| same.len() % 2 == 1) {
            shells[same[0] as usize].closed = false;
        }
    }
    shells
}

/// Signed volume of a closed shell, turned as `turned` says.
fn volume(mesh: &TriMesh, shell: &Shell, turned: &[bool]) -> f64 {
    // From one of its own points, so that nothing is lost where it is far from the origin.
    let origin = mesh.corners(shell.triangles[0] as usize)[0];
    let six = |&t: &u32| {
        let [a, b, c] = mesh.corners(t as usize).map(|p| p - origin);
        let volume = a.dot(b.cross(c));
        if turned[t as usize] { -volume } else { volume }
    };
    shell.triangles.iter().map(six).sum()
}

/// In how many of the others each closed shell lies.
fn depths(mesh: &TriMesh, closed: &[&Shell]) -> Vec<usize> {
    if closed.len() < 2 {
        return vec![0; closed.len()];
    }
    let all: Vec<(u32, u32)> = closed
        .iter()
        .enumerate()
        .flat_map(|(s, shell)| shell.triangles.iter().map(move |&t| (index(s), t)))
        .collect();
    let boxes: Vec<[DVec3; 2]> = all.iter().map(|&(_, t)| box_of(mesh.corners(t as usize))).collect();
    let tree = BoxTree::new(&boxes);
    let top = boxes.iter().map(|b| b[1].z).fold(f64::NEG_INFINITY, f64::max);
    // A vertex that belongs to several shells says nothing about any.
    let mut owner = vec![NONE; mesh.vertices.len()];
    let mut shared = vec![false; mesh.vertices.len()];
    for &(s, t) in &all {
        for v in mesh.triangles[t as usize].map(|v| v as usize) {
            shared[v] |= owner[v] != NONE && owner[v] != s;
            owner[v] = s;
        }
    }
    // The shells around a point that belongs to shell `s`; whether the point lies on one of them.
    let around = |s: usize, p: DVec3| {
        let mut crossed = Vec::new();
        let mut on = false;
        tree.near([p, p.with_z(top.max(p.z))], |i| {
            let (shell, t) = all[i];
            if shell as usize != s {
                match above(mesh.corners(t as usize), p) {
                    Above::Yes => crossed.push(shell),
                    Above::Touches => on = true,
                    Above::No => {}
                }
            }
            true
        });
        crossed.sort_unstable();
        (crossed.chunk_by(|a, b| a == b).filter(|hits| hits.len() % 2 == 1).count(), on)
    };
    // A shell around another has a box around the other's box; most shells have none around them.
    let shell_boxes: Vec<[DVec3; 2]> = closed
        .iter()
        .map(|shell| {
            let corners = shell.triangles.iter().flat_map(|&t| mesh.corners(t as usize));
            corners.map(|p| [p, p]).reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]).unwrap_or_default()
        })
        .collect();
    let shell_tree = BoxTree::new(&shell_boxes);
    let boxed = |s: usize| {
        let [low, high] = shell_boxes[s];
        let mut found = false;
        shell_tree.near(shell_boxes[s], |other| {
            let [l, h] = shell_boxes[other];
            found = other != s && l.cmple(low).all() && h.cmpge(high).all();
            !found
        });
        found
    };
    (0..closed.len())
        .into_par_iter()
        .map(|s| {
            if !boxed(s) {
                return 0;
            }
            let triangles = &closed[s].triangles;
            // Where shells touch, another vertex may be free; shells that touch everywhere are defective.
            let step = triangles.len().div_ceil(32);
            let corners = triangles.iter().step_by(step).flat_map(|&t| mesh.triangles[t as usize]);
            let free = corners.filter(|&v| !shared[v as usize]);
            for v in free.take(32) {
                if let (depth, false) = around(s, mesh.vertices[v as usize]) {
                    return depth;
                }
            }
            let [a, b, c] = mesh.corners(triangles[0] as usize);
            around(s, (a + b + c) / 3.0).0
        })
        .collect()
}
