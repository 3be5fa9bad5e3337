//! The search phase \[CW 4.3, 4.4.2\]: for each voxel and direction the neighbourhood of the photograph that its own
//! resembles most, where those that are used too much count as less alike.

use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::atlas::NOWHERE;
use super::axes::Axis;
use super::basis::Descriptor;
use super::histogram::Histogram;
use super::level::{Level, State, long, pick, random, short};
use super::optimise::Changes;
use super::passes::{Pass, chunks};
use super::similar::distance;
use crate::exec::{Cancelled, Exec};

/// Robustness of the energy \[CW 4.1\]: γ.
const GAMMA: f32 = 0.8;
/// Keeps weights finite: a squared distance for each pixel, small beside the 2 of two random pixels.
const TINY: f32 = 1e-3;

/// The weight of a neighbourhood at a squared distance, |s − e|^(γ−2).
fn weight(distance: f32, pixels: usize) -> f32 {
    (distance / pixels as f32 + TINY).powf(0.5 * (GAMMA - 2.0))
}

/// What a search did.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Searched {
    /// Neighbourhoods that are now others.
    pub(super) moved: usize,
    /// Σ |s − e|^γ over all that were looked at.
    pub(super) energy: f64,
    /// How many were looked at.
    pub(super) looked: usize,
}

/// The outcome for one voxel in one direction.
#[derive(Debug, Clone, Copy)]
struct Match {
    place: u32,
    distance: f32,
}

const UNTOUCHED: Match = Match { place: NOWHERE, distance: 0.0 };

/// One pass over all voxels. `histograms` has one for each direction, in the order of the axes; `drawn` random
/// neighbourhoods are looked at beside the coherent ones.
pub(super) fn search(
    level: &Level,
    state: &mut State,
    histograms: &mut [Histogram; 3],
    changes: &Changes,
    drawn: usize,
    pass: &mut Pass<'_>,
    exec: &Exec,
) -> Result<Searched, Cancelled> {
    let [nx, ..] = level.lattice.size;
    let directions: Vec<(Axis, usize)> = level.directions().collect();
    let mut found: Vec<Match> = Vec::new();
    let mut done = Searched::default();
    let area = level.width * level.width;
    let arch = pulp::Arch::new();
    for rows in chunks(&level.lattice, pass.number) {
        exec.check()?;
        let wide = directions.len() * nx;
        found.clear();
        found.resize(rows.len() * wide, UNTOUCHED);
        let first = rows.start;
        let seen: &State = state;
        let hist: &[Histogram; 3] = histograms;
        found.par_chunks_mut(wide).enumerate().for_each(|(n, line)| {
            let row = first + n;
            let mut rng = random(level.seed, level.number, 16 + pass.number as u64, row);
            for (&(axis, sheet), line) in directions.iter().zip(line.chunks_exact_mut(nx)) {
                let finder = Finder { level, state: seen, histogram: &hist[axis.index()], changes, axis, sheet, drawn };
                if level.atlas.features {
                    arch.dispatch(|| finder.row::<4>(row, line, &mut rng));
                } else {
                    arch.dispatch(|| finder.row::<3>(row, line, &mut rng));
                }
            }
        });
        for (n, line) in found.chunks_exact(wide).enumerate() {
            for ((axis, _), line) in directions.iter().zip(line.chunks_exact(nx)) {
                let a = axis.index();
                let start = (first + n) * nx;
                for (x, m) in line.iter().enumerate() {
                    if m.place == NOWHERE {
                        continue;
                    }
                    let weight = weight(m.distance, area);
                    state.weight[a][start + x] = short(weight);
                    done.looked += 1;
                    done.energy += f64::from(weight * (m.distance / area as f32 + TINY));
                    let old = state.index[a][start + x];
                    if old != m.place {
                        histograms[a].remove(old);
                        histograms[a].add(m.place);
                        state.index[a][start + x] = m.place;
                        done.moved += 1;
                    }
                }
            }
        }
        pass.advance(rows.len());
    }
    Ok(done)
}

/// The search in one direction.
struct Finder<'a> {
    level: &'a Level,
    state: &'a State,
    histogram: &'a Histogram,
    changes: &'a Changes,
    axis: Axis,
    sheet: usize,
    drawn: usize,
}

/// Neighbours whose neighbourhoods are followed, as steps to the right and down.
const AROUND: [(isize, isize); 4] = [(-1, 0), (1, 0), (0, -1), (0, 1)];

impl Finder<'_> {
    #[inline(always)]
    fn row<const C: usize>(&self, row: usize, line: &mut [Match], rng: &mut ChaCha8Rng) {
        let [nx, ny, _] = self.level.lattice.size;
        let (y, z) = (row % ny, row / ny);
        for (x, entry) in line.iter_mut().enumerate() {
            let (voxel, at) = (row * nx + x, [x, y, z]);
            if self.state.index[self.axis.index()][voxel] != NOWHERE && self.changes.concerns(self.axis, voxel) {
                *entry = self.voxel::<C>(voxel, at, rng);
            }
        }
    }

    /// The neighbourhood of a voxel along the principal axes.
    #[inline(always)]
    fn describe<const C: usize>(&self, at: [usize; 3]) -> Descriptor {
        let basis = &self.level.windows[self.sheet].basis;
        let slice = self.level.lattice.slice(self.axis, at);
        let half = (self.level.width / 2) as isize;
        let along = -half..self.level.width as isize - half;
        let mut sum = basis.mean.map(|m| -m);
        let mut axes = basis.axes.chunks_exact(C);
        for down in along.clone() {
            for right in along.clone() {
                let look = &self.level.atlas.look[self.state.source[slice.inside(right, down)] as usize];
                let Some(axes) = axes.next() else { return sum };
                for c in 0..C {
                    for (sum, axis) in sum.iter_mut().zip(&axes[c]) {
                        *sum += axis * look[c];
                    }
                }
            }
        }
        sum
    }

    #[inline(always)]
    fn voxel<const C: usize>(&self, voxel: usize, at: [usize; 3], rng: &mut ChaCha8Rng) -> Match {
        let level = self.level;
        let own = self.describe::<C>(at);
        let index = &self.state.index[self.axis.index()];
        let sheet = &level.atlas.sheets[self.sheet];
        let windows = &level.windows[self.sheet];
        let range = level.depths(at);
        let allowed = |place: u32| match range {
            None => true,
            Some((from, to)) => (from..=to).contains(&usize::from(level.atlas.depth[place as usize])),
        };
        let old = index[voxel];
        let d = distance(&own, windows.descriptor(old), f32::INFINITY);
        let mut best = Match { place: old, distance: d };
        // Equation 5: the distance is multiplied by a factor that grows with use.
        let mut cost = d * self.histogram.own_factor(old);
        let mut consider = |place: u32| {
            let factor = self.histogram.factor(place);
            // What may not be used has an infinite factor, and this a limit of 0.
            let limit = cost / factor;
            if limit > 0.0 && place != old && allowed(place) {
                let d = distance(&own, windows.descriptor(place), limit);
                if d < limit {
                    best = Match { place, distance: d };
                    cost = d * factor;
                }
            }
        };
        let mut tried = [NOWHERE; 16];
        let mut count = 0;
        let mut follow = |base: u32| {
            if tried[..count].contains(&base) || self.histogram.factor(base) == f32::INFINITY {
                return;
            }
            tried[count] = base;
            count += 1;
            consider(base);
            for &other in windows.similar(base) {
                if other != NOWHERE {
                    consider(other);
                }
            }
        };
        follow(old);
        let slice = level.lattice.slice(self.axis, at);
        for (right, down) in AROUND {
            if let Some(near) = slice.at(right, down) {
                let step = (down * sheet.stride as isize + right) as i32;
                if index[near] != NOWHERE {
                    follow(index[near].wrapping_add_signed(-step));
                }
                // The pixel that the neighbour is copied from leads on as well, where it is of this photograph.
                self.lead(near, step, &mut follow);
            }
        }
        self.lead(voxel, 0, &mut follow);
        for near in level.lattice.beside(self.axis, voxel, at).into_iter().flatten() {
            if index[near] != NOWHERE {
                follow(index[near]);
            }
        }
        if self.drawn > 0 {
            let choice = level.choice(self.sheet, at);
            for _ in 0..self.drawn {
                consider(pick(rng, choice));
            }
        }
        best
    }

    #[inline(always)]
    fn lead(&self, near: usize, step: i32, follow: &mut impl FnMut(u32)) {
        let source = self.state.source[near];
        if self.level.atlas.sheets.len() == 1 || self.level.atlas.sheet_of(source) == self.sheet {
            let base = source.wrapping_add_signed(-step);
            follow(base);
        }
    }
}

/// The weight that is kept of a neighbourhood.
#[inline(always)]
pub(super) fn kept_weight(state: &State, axis: Axis, voxel: usize) -> f32 {
    long(state.weight[axis.index()][voxel])
}
