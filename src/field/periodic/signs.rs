//! Signs of R that agree from tetrahedron to tetrahedron.
//!
//! Strokes may be drawn to and fro, and lines have no sense. Coordinates need one: a sign for each tetrahedron, spread
//! from the first to its neighbours, those first that agree with it, then those that are most nearly parallel.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::DVec3;

use crate::mesh::{NONE, TetMesh, index};

/// Below this cosine frames on both sides of a face point to different sides. Frames that only turn fast are left to the
/// coordinates, which end rows there.
const AGAINST: f64 = -0.5;

/// Turns R about (and T with it) wherever it points the other way, and gives the faces across which it does so
/// nonetheless, from either side, as (tetrahedron, local face): there no choice of signs agrees.
pub(crate) fn agreed(mesh: &TetMesh, r: &mut [DVec3]) -> Vec<(u32, u8)> {
    let count = mesh.tets.len();
    let mut sign = vec![0.0; count];
    // By how nearly parallel they are, then by number: the same on every run.
    let mut next: BinaryHeap<(u64, Reverse<u32>, bool)> = BinaryHeap::new();
    for first in 0..count {
        if sign[first] != 0.0 {
            continue;
        }
        sign[first] = 1.0;
        let mut at = first;
        let mut part = vec![first];
        let mut kept = mesh.tet_volume(first);
        loop {
            for &n in mesh.neighbours[at].iter().filter(|&&n| n != NONE && sign[n as usize] == 0.0) {
                let cosine = r[at].dot(r[n as usize]);
                // Those first that have one sense already: around a pole, a field that has one everywhere keeps it.
                let nearness = match cosine {
                    c if c > 0.5 => 2.0 + c,
                    c if c < -0.5 => 1.0 - c,
                    c => c.abs(),
                };
                // Bits of numbers that are not negative are in their order.
                next.push((f64::to_bits(nearness), Reverse(n), (cosine < 0.0) != (sign[at] < 0.0)));
            }
            let found = loop {
                match next.pop() {
                    Some((_, Reverse(n), turned)) if sign[n as usize] == 0.0 => {
                        sign[n as usize] = if turned { -1.0 } else { 1.0 };
                        part.push(n as usize);
                        kept += mesh.tet_volume(n as usize) * sign[n as usize];
                        break Some(n as usize);
                    }
                    Some(_) => {}
                    None => break None,
                }
            };
            match found {
                Some(n) => at = n,
                None => break,
            }
        }
        // The sense of most is kept.
        if kept < 0.0 {
            part.into_iter().for_each(|t| sign[t] = -sign[t]);
        }
    }
    for (r, sign) in r.iter_mut().zip(sign) {
        *r *= sign;
    }
    (0..count)
        .flat_map(|t| (0..4u8).map(move |k| (t, k)))
        .filter(|&(t, k)| {
            let n = mesh.neighbours[t][k as usize];
            n != NONE && r[t].dot(r[n as usize]) < AGAINST
        })
        .map(|(t, k)| (index(t), k))
        .collect()
}
