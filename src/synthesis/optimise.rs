//! The optimisation phase \[CW 4.2, 4.4.1\]: each voxel becomes a copy of one of the pixels that the neighbourhoods
//! around it propose.

use rayon::prelude::*;

use super::atlas::NOWHERE;
use super::histogram::Histogram;
use super::level::{Level, State, long};
use super::passes::{Pass, chunks};
use crate::exec::{Cancelled, Exec};

/// How much of the proposals' variance is added to each one's distance from their mean: the histogram chooses between
/// proposals that differ by less.
const SPREAD: f32 = 0.1;

/// One pass over all voxels.
pub(super) fn optimise(
    level: &Level,
    state: &mut State,
    histogram: &mut Histogram,
    pass: &mut Pass<'_>,
    exec: &Exec,
) -> Result<(), Cancelled> {
    let [nx, ..] = level.lattice.size;
    let mut found: Vec<Choice> = Vec::new();
    let arch = pulp::Arch::new();
    for rows in chunks(&level.lattice, pass.number) {
        exec.check()?;
        found.clear();
        found.resize(rows.len() * nx, Choice { place: NOWHERE, cost: 0.0, before: 0.0 });
        let first = rows.start;
        let solver = Solver { level, state, histogram };
        found.par_chunks_mut(nx).enumerate().for_each(|(n, line)| {
            arch.dispatch(Line { solver: &solver, row: first + n, line });
        });
        let start = first * nx;
        for (n, choice) in found.iter().enumerate() {
            let old = state.source[start + n];
            if old == choice.place {
                continue;
            }
            if old != NOWHERE {
                // As in the search: what others of this piece did meanwhile counts.
                if choice.cost * histogram.factor(choice.place) >= choice.before * histogram.own_factor(old) {
                    continue;
                }
                histogram.remove(old);
            }
            histogram.add(choice.place);
            state.source[start + n] = choice.place;
        }
        pass.advance(rows.len());
    }
    Ok(())
}

/// What is best for a voxel.
#[derive(Debug, Clone, Copy)]
struct Choice {
    place: u32,
    /// Its cost, before the histogram's factor.
    cost: f32,
    /// That of the place that the voxel is copied from so far; infinite where nothing proposes it any more.
    before: f32,
}

struct Solver<'a> {
    level: &'a Level,
    state: &'a State,
    histogram: &'a Histogram,
}

/// A row's work, compiled for every kind of vector unit.
struct Line<'a> {
    solver: &'a Solver<'a>,
    row: usize,
    line: &'a mut [Choice],
}

impl pulp::WithSimd for Line<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        self.solver.row(self.row, self.line);
    }
}

/// A pixel that a neighbourhood proposes.
#[derive(Debug, Clone, Copy)]
struct Proposal {
    look: [f32; 4],
    factor: f32,
    place: u32,
}

impl Solver<'_> {
    #[inline(always)]
    fn row(&self, row: usize, line: &mut [Choice]) {
        let [nx, ny, _] = self.level.lattice.size;
        let (y, z) = (row % ny, row / ny);
        let most = 3 * self.level.width * self.level.width;
        let mut proposals = vec![Proposal { look: [0.0; 4], factor: 1.0, place: NOWHERE }; most];
        for (x, entry) in line.iter_mut().enumerate() {
            *entry = self.voxel(row * nx + x, [x, y, z], &mut proposals);
        }
    }

    #[inline(always)]
    fn voxel(&self, voxel: usize, at: [usize; 3], proposals: &mut [Proposal]) -> Choice {
        let level = self.level;
        let old = self.state.source[voxel];
        let own = if old == NOWHERE { 1.0 } else { self.histogram.own_factor(old) };
        let half = (level.width / 2) as isize;
        let along = -half..level.width as isize - half;
        let mut count = 0;
        let mut sum = [0.0f32; 4];
        let mut squares = [0.0f32; 4];
        let mut total = 0.0f32;
        for (axis, sheet) in level.directions() {
            let index = &self.state.index[axis.index()][..];
            let weights = &self.state.weight[axis.index()][..index.len()];
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
                    let (factor, inverse) = self.histogram.factor_and_inverse(place);
                    let (factor, inverse) = if place == old { (own, 1.0 / own) } else { (factor, inverse) };
                    // Equation 4.
                    let weight = long(weights[near]) * inverse;
                    let look = level.atlas.look[place as usize];
                    for k in 0..4 {
                        let part = weight * look[k];
                        sum[k] += part;
                        squares[k] += part * look[k];
                    }
                    total += weight;
                    if let Some(proposal) = proposals.get_mut(count) {
                        *proposal = Proposal { look, factor, place };
                        count += 1;
                    }
                }
            }
        }
        if count == 0 {
            return Choice { place: old, cost: 0.0, before: 0.0 };
        }
        let mean = sum.map(|s| s / total);
        let spread = (0..4).map(|k| squares[k] / total - mean[k] * mean[k]).sum::<f32>().max(0.0);
        // Of equation 1 as much as depends on the colour that is chosen: its distance from the mean, and a part of what
        // no choice can change.
        let base = SPREAD * spread + 1e-4;
        let mut best = Choice { place: NOWHERE, cost: f32::INFINITY, before: f32::INFINITY };
        let mut least = f32::INFINITY;
        for proposal in &proposals[..count] {
            let d = [0, 1, 2, 3].map(|k| (proposal.look[k] - mean[k]) * (proposal.look[k] - mean[k]));
            let cost = (d[0] + d[1]) + (d[2] + d[3]) + base;
            if proposal.place == old {
                best.before = cost;
            }
            if cost * proposal.factor < least {
                least = cost * proposal.factor;
                best.place = proposal.place;
                best.cost = cost;
            }
        }
        best
    }
}
