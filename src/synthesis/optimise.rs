//! The optimisation phase \[CW 4.2, 4.4.1\]: each voxel becomes a copy of one of the pixels that the neighbourhoods
//! around it propose.

use rayon::prelude::*;

use super::atlas::NOWHERE;
use super::histogram::Histogram;
use super::level::{Level, State, long};
use super::passes::{Pass, pieces};
use crate::exec::{Cancelled, Exec};

/// How much of the proposals' variance is added to each one's distance from their mean: the histogram chooses between
/// proposals that differ by less.
const SPREAD: f32 = 0.1;
/// Steps of the mean shift at the finest level. What three slices propose is often two colours or three: their mean is
/// none of these, and a volume of means has lost its grain. So the mean moves to where most proposals are (Wexler,
/// Shechtman & Irani 2007).
const SHIFTS: usize = 4;
/// The squared distance at which a proposal loses half of its weight in that, over the proposals' variance.
const BANDWIDTH: f32 = 0.2;

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
    let shifts = if level.finest { SHIFTS } else { 0 };
    for rows in pieces(&level.lattice, pass.number) {
        exec.check()?;
        found.clear();
        found.resize(rows.len() * nx, Choice { place: NOWHERE, cost: 0.0, before: 0.0 });
        let solver = Solver { level, state, histogram, pass: pass.number, shifts };
        found.par_chunks_mut(nx).enumerate().for_each(|(n, line)| {
            arch.dispatch(Line { solver: &solver, row: rows[n], line });
        });
        for (n, choice) in found.iter().enumerate() {
            let voxel = rows[n / nx] * nx + n % nx;
            let old = state.source[voxel];
            if old == choice.place || choice.place == NOWHERE {
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
            state.source[voxel] = choice.place;
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
    pass: usize,
    /// Steps of the mean shift.
    shifts: usize,
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
        if self.solver.level.atlas.features {
            self.solver.row::<4>(self.row, self.line);
        } else {
            self.solver.row::<3>(self.row, self.line);
        }
    }
}

/// Eight pixels that neighbourhoods propose, side by side for the processor's vector unit.
#[derive(Debug, Clone, Copy)]
struct Proposals<const C: usize> {
    look: [[f32; LANES]; C],
    weight: [f32; LANES],
    factor: [f32; LANES],
    place: [u32; LANES],
}

const LANES: usize = 8;

impl<const C: usize> Proposals<C> {
    /// Nothing that weighs anything, or that could be chosen.
    const NONE: Self = Self {
        look: [[0.0; LANES]; C],
        weight: [0.0; LANES],
        factor: [f32::INFINITY; LANES],
        place: [NOWHERE; LANES],
    };

    /// The squared distance of each from a look.
    #[inline(always)]
    fn distances(&self, from: &[f32; C]) -> [f32; LANES] {
        let mut sum = [0.0; LANES];
        for (look, from) in self.look.iter().zip(from) {
            for (sum, look) in sum.iter_mut().zip(look) {
                let d = look - from;
                *sum += d * d;
            }
        }
        sum
    }
}

/// The mean of proposals, each with the weight that `weigh` gives it.
#[inline(always)]
fn mean<const C: usize>(blocks: &[Proposals<C>], weigh: impl Fn(&Proposals<C>) -> [f32; LANES]) -> [f32; C] {
    let mut total = [0.0f32; LANES];
    let mut sums = [[0.0f32; LANES]; C];
    for block in blocks {
        let weights = weigh(block);
        for (sum, look) in sums.iter_mut().zip(&block.look) {
            (0..LANES).for_each(|n| sum[n] += weights[n] * look[n]);
        }
        (0..LANES).for_each(|n| total[n] += weights[n]);
    }
    let total = total.iter().sum::<f32>();
    sums.map(|sum| sum.iter().sum::<f32>() / total)
}

impl Solver<'_> {
    #[inline(always)]
    fn row<const C: usize>(&self, row: usize, line: &mut [Choice]) {
        let [nx, ny, _] = self.level.lattice.size;
        let (y, z) = (row % ny, row / ny);
        let mut blocks = vec![Proposals::<C>::NONE; self.level.grid.most().div_ceil(LANES)];
        for (x, entry) in line.iter_mut().enumerate() {
            *entry = self.voxel(row * nx + x, [x, y, z], &mut blocks);
        }
    }

    /// What the neighbourhoods around a voxel propose, and how many do.
    #[inline(always)]
    fn gather<const C: usize>(
        &self,
        at: [usize; 3],
        old: u32,
        own: f32,
        blocks: &mut [Proposals<C>],
    ) -> usize {
        let Level { lattice, grid, atlas, .. } = self.level;
        let mut count = 0;
        for (axis, sheet) in self.level.directions() {
            let a = axis.index();
            let index = &self.state.index[a][..];
            let weights = &self.state.weight[a][..index.len()];
            let stride = atlas.sheets[sheet].stride as i32;
            let [right, down] = grid.phase(at[a], self.pass);
            let layer = lattice.layer(axis, at);
            let across = grid.over(axis.right(), right, at[axis.right().index()]);
            for row in grid.over(axis.down(), down, at[axis.down().index()]) {
                for column in across {
                    let near = layer + (row.step + column.step) as usize;
                    let place = index[near].wrapping_add_signed(row.offset * stride + column.offset);
                    let (factor, inverse) = self.histogram.factor_and_inverse(place);
                    let (factor, inverse) = if place == old { (own, 1.0 / own) } else { (factor, inverse) };
                    let (block, lane) = (&mut blocks[count / LANES], count % LANES);
                    let look = &atlas.look[place as usize];
                    (0..C).for_each(|k| block.look[k][lane] = look[k]);
                    // Equation 4.
                    block.weight[lane] = long(weights[near]) * row.say * column.say * inverse;
                    block.factor[lane] = factor;
                    block.place[lane] = place;
                    count += 1;
                }
            }
        }
        count
    }

    #[inline(always)]
    fn voxel<const C: usize>(&self, voxel: usize, at: [usize; 3], blocks: &mut [Proposals<C>]) -> Choice {
        let old = self.state.source[voxel];
        if !self.level.is_free(voxel) {
            return Choice { place: old, cost: 0.0, before: 0.0 };
        }
        let own = if old == NOWHERE { 1.0 } else { self.histogram.own_factor(old) };
        let count = self.gather(at, old, own, blocks);
        if count == 0 {
            return Choice { place: old, cost: 0.0, before: 0.0 };
        }
        let blocks = &mut blocks[..count.div_ceil(LANES)];
        if let (Some(last), from @ 1..) = (blocks.last_mut(), count % LANES) {
            last.weight[from..].fill(0.0);
            last.factor[from..].fill(f32::INFINITY);
        }
        let mut middle = mean(blocks, |block| block.weight);
        let (mut spread, mut total) = ([0.0f32; LANES], [0.0f32; LANES]);
        for block in &*blocks {
            let distances = block.distances(&middle);
            for n in 0..LANES {
                spread[n] += block.weight[n] * distances[n];
                total[n] += block.weight[n];
            }
        }
        let spread = spread.iter().sum::<f32>() / total.iter().sum::<f32>();
        let narrow = 1.0 / (BANDWIDTH * spread + 1e-6);
        for _ in 0..self.shifts {
            middle = mean(blocks, |block| {
                let mut weights = block.distances(&middle);
                (0..LANES).for_each(|n| weights[n] = block.weight[n] / (weights[n] * narrow + 1.0));
                weights
            });
        }
        // Of equation 1 as much as depends on the colour that is chosen: its distance from the mean, and a part of what
        // no choice can change.
        let base = SPREAD * spread + 1e-4;
        let mut best = Choice { place: NOWHERE, cost: f32::INFINITY, before: f32::INFINITY };
        let mut least = f32::INFINITY;
        for block in &*blocks {
            let distances = block.distances(&middle);
            for (n, distance) in distances.into_iter().enumerate() {
                let cost = distance + base;
                if cost * block.factor[n] < least {
                    least = cost * block.factor[n];
                    best.place = block.place[n];
                    best.cost = cost;
                }
                if block.place[n] == old && block.factor[n] < f32::INFINITY {
                    best.before = cost;
                }
            }
        }
        best
    }
}
