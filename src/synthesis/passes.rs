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
    /// Its number within the level; odd ones run backward.
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
    let voxels = (nx * rows / 64).clamp(1024, 16384);
    let each = voxels.div_ceil(nx);
    let count = rows.div_ceil(each);
    (0..count).map(move |n| {
        let n = if pass.is_multiple_of(2) { n } else { count - 1 - n };
        n * each..((n + 1) * each).min(rows)
    })
}
