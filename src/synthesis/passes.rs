//! Passes over all voxels, in fixed pieces.
//!
//! Histograms steer each pass and change with it. They are brought up to date after every piece, by one thread in
//! order; within a piece all voxels see the same. Pieces depend on the size of the volume alone, so that the result
//! does not depend on the number of threads.

use std::ops::Range;

use super::lattice::Lattice;
use crate::exec::Stage;

/// One pass of a level.
pub(super) struct Pass<'a> {
    /// Its number within the level.
    pub(super) number: usize,
    /// What hears of its progress.
    pub(super) stage: &'a Stage<'a>,
    /// Rows that the level has done so far.
    pub(super) rows: u64,
}

impl Pass<'_> {
    /// So many rows more are done.
    pub(super) fn advance(&mut self, rows: usize) {
        self.rows += rows as u64;
        self.stage.at(self.rows);
    }
}

/// The pieces of a pass, each a range of rows along x.
pub(super) fn chunks(lattice: &Lattice, pass: usize) -> impl Iterator<Item = Range<usize>> {
    let [nx, ny, nz] = lattice.size;
    let rows = ny * nz;
    let voxels = (nx * rows / 64).clamp(512, 16384);
    let each = voxels.div_ceil(nx);
    let count = rows.div_ceil(each);
    // One after the other, pieces would let structure grow along the axes and meet itself where the volume wraps: so
    // each lies far from the one before, and a pass begins elsewhere than the last.
    let stride = coprime(count);
    (0..count).map(move |n| {
        let n = (n * stride + pass * count / 3) % count;
        n * each..((n + 1) * each).min(rows)
    })
}

/// Some golden section of a number that has no factor with it: its multiples come by all numbers below.
fn coprime(count: usize) -> usize {
    let divides = |mut a: usize, mut b: usize| {
        while b > 0 {
            (a, b) = (b, a % b);
        }
        a
    };
    (count * 5 / 8..).find(|&n| divides(n, count) == 1).unwrap_or(1)
}
