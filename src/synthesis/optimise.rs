//! The optimisation phase \[CW 4.2, 4.4.1\]: each voxel becomes a copy of one of the pixels that the neighbourhoods
//! around it propose.

use rayon::prelude::*;

use super::atlas::NOWHERE;
use super::axes::Axis;
use super::histogram::Histogram;
use super::level::{Level, State};
use super::passes::{Pass, chunks};
use super::search::kept_weight;
use crate::exec::{Cancelled, Exec};

/// The most proposals for a voxel: windows of 8×8 in three directions.
const MOST: usize = 3 * 64;

/// Which voxels were given another source by the last pass.
pub(super) struct Changes {
    /// Empty: all of them.
    flags: Vec<bool>,
}

impl Changes {
    /// Everything has changed.
    pub(super) fn all() -> Self {
        Self { flags: Vec::new() }
    }

    /// Whether a neighbourhood around a voxel may have changed.
    #[inline(always)]
    pub(super) fn concerns(&self, _axis: Axis, voxel: usize) -> bool {
        self.flags.is_empty() || self.flags[voxel]
    }
}

/// What a pass did.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Optimised {
    /// Voxels that are copied from elsewhere now.
    pub(super) changed: usize,
}

/// One pass over all voxels.
pub(super) fn optimise(
    level: &Level,
    state: &mut State,
    histogram: &mut Histogram,
    pass: &mut Pass<'_>,
    exec: &Exec,
) -> Result<Optimised, Cancelled> {
    let [nx, ..] = level.lattice.size;
    let mut found: Vec<u32> = Vec::new();
    let mut done = Optimised::default();
    let arch = pulp::Arch::new();
    for rows in chunks(&level.lattice, pass.number) {
        exec.check()?;
        found.clear();
        found.resize(rows.len() * nx, NOWHERE);
        let first = rows.start;
        let solver = Solver { level, state, histogram };
        found.par_chunks_mut(nx).enumerate().for_each(|(n, line)| arch.dispatch(|| solver.row(first + n, line)));
        let start = first * nx;
        for (n, &place) in found.iter().enumerate() {
            let old = std::mem::replace(&mut state.source[start + n], place);
            if old != place {
                if old != NOWHERE {
                    histogram.remove(old);
                }
                histogram.add(place);
                done.changed += 1;
            }
        }
        pass.advance(rows.len());
    }
    Ok(done)
}

struct Solver<'a> {
    level: &'a Level,
    state: &'a State,
    histogram: &'a Histogram,
}

impl Solver<'_> {
    #[inline(always)]
    fn row(&self, row: usize, line: &mut [u32]) {
        let [nx, ny, _] = self.level.lattice.size;
        let (y, z) = (row % ny, row / ny);
        for (x, entry) in line.iter_mut().enumerate() {
            *entry = self.voxel(row * nx + x, [x, y, z]);
        }
    }

    /// The cost of using a place, for a voxel that is copied from `old` so far.
    #[inline(always)]
    fn factor(&self, place: u32, old: u32) -> f32 {
        if place == old { self.histogram.own_factor(place) } else { self.histogram.factor(place) }
    }

    #[inline(always)]
    fn voxel(&self, voxel: usize, at: [usize; 3]) -> u32 {
        let level = self.level;
        let old = self.state.source[voxel];
        let half = (level.width / 2) as isize;
        let along = -half..level.width as isize - half;
        let mut proposed = [NOWHERE; MOST];
        let mut factors = [0.0f32; MOST];
        let mut count = 0;
        let mut sum = [0.0f32; 4];
        let mut square = 0.0f32;
        let mut total = 0.0f32;
        for (axis, sheet) in level.directions() {
            let index = &self.state.index[axis.index()];
            let stride = level.atlas.sheets[sheet].stride as isize;
            let slice = level.lattice.slice(axis, at);
            for down in along.clone() {
                for right in along.clone() {
                    // The neighbourhood around that neighbour has this voxel at (right, down).
                    let Some(near) = slice.at(-right, -down) else { continue };
                    if index[near] == NOWHERE {
                        continue;
                    }
                    let place = index[near].wrapping_add_signed((down * stride + right) as i32);
                    let factor = self.factor(place, old);
                    // Equation 4.
                    let weight = kept_weight(self.state, axis, near) / factor;
                    let look = &level.atlas.look[place as usize];
                    (0..4).for_each(|k| sum[k] += weight * look[k]);
                    square += weight * look.iter().map(|c| c * c).sum::<f32>();
                    total += weight;
                    proposed[count] = place;
                    factors[count] = factor;
                    count += 1;
                }
            }
        }
        if count == 0 {
            return old;
        }
        let mean = sum.map(|s| s / total);
        let spread = (square / total - mean.iter().map(|m| m * m).sum::<f32>()).max(0.0);
        // Of equation 1 as much as depends on the colour that is chosen: its distance from the mean, and what no
        // choice can change.
        let mut best = (f32::INFINITY, NOWHERE);
        for (&place, &factor) in proposed[..count].iter().zip(&factors) {
            let look = &level.atlas.look[place as usize];
            let distance: f32 = (0..4).map(|k| (look[k] - mean[k]).powi(2)).sum();
            let cost = (distance + 0.1 * spread + 1e-4) * factor;
            if cost < best.0 {
                best = (cost, place);
            }
        }
        best.1
    }
}
