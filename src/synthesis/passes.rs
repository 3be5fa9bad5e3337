//! Passes over all voxels, in fixed pieces.
//!
//! Histograms steer each pass and change with it. They are brought up to date after every piece, by one thread in
//! order; within a piece all voxels see the same. Pieces depend on the size of the volume alone, so that the result
//! does not depend on the number of threads.

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

/// Rows that lie side by side in a piece: they share what they read.
const TOGETHER: usize = 8;

/// The pieces of a pass, each a list of rows along x.
pub(super) fn pieces(lattice: &Lattice, pass: usize) -> impl Iterator<Item = Vec<usize>> {
    let [nx, ny, nz] = lattice.size;
    let rows = ny * nz;
    let voxels = (nx * rows / 64).clamp(512, 16384);
    let each = voxels.div_ceil(nx);
    let together = each.min(TOGETHER);
    let bundles = rows.div_ceil(together);
    // What comes first finds the best pixels little used. Were a piece a layer, some layers would be smoother than
    // others in every pass, and were pieces taken one after the other, structure would grow along the axes and meet itself
    // where the volume wraps. So each piece is strewn over the whole volume, and a pass begins elsewhere than the last.
    let stride = coprime(bundles);
    (0..bundles).step_by(each / together).map(move |first| {
        let part = first..(first + each / together).min(bundles);
        let bundle = |n: usize| (n * stride + pass * bundles / 3) % bundles;
        // Nor may the ends of bundles always lie in the same layers.
        let moved = |row: usize| {
            let (y, z) = (row % ny, row / ny);
            z * ny + (y + 3 * z + 5 * pass) % ny
        };
        let rows = part.map(bundle).flat_map(|b| b * together..((b + 1) * together).min(rows));
        rows.map(moved).collect()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pass_takes_every_row_once_and_each_piece_is_strewn() {
        for size in [[128, 128, 128], [7, 5, 3], [16, 13, 24], [96, 40, 31]] {
            let lattice = Lattice::new(size, [true; 3]);
            for pass in [0, 5] {
                let all: Vec<Vec<usize>> = pieces(&lattice, pass).collect();
                let mut rows = all.concat();
                rows.sort_unstable();
                assert_eq!(rows, (0..size[1] * size[2]).collect::<Vec<_>>());
                if size[2] < 128 {
                    continue;
                }
                for piece in &all {
                    let mut layers: Vec<usize> = piece.iter().map(|row| row / size[1]).collect();
                    layers.dedup();
                    layers.sort_unstable();
                    let apart = layers.windows(2).map(|w| w[1] - w[0]).max();
                    assert!(layers.len() >= 16 && apart <= Some(16), "{layers:?}");
                }
            }
        }
    }
}
