//! The search phase \[CW 4.3, 4.4.2\]: for each voxel and direction the neighbourhood of the photograph that its own
//! resembles most, where those that are used too much count as less alike.

use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::atlas::NOWHERE;
use super::axes::Axis;
use super::basis::Descriptor;
use super::histogram::Histogram;
use super::level::{Level, REPEATED, State, pick, random, short};
use super::passes::{Pass, pieces};
use super::windows::SIMILAR;
use crate::exec::{Cancelled, Exec};

/// Robustness of the energy \[CW 4.1\]: γ.
const GAMMA: f32 = 0.8;
/// γ of the weights where a coarser level has settled what lies where: neighbourhoods that fit badly have less say.
const FINE_GAMMA: f32 = 0.2;
/// Keeps weights finite: a squared distance for each pixel, small beside the 2 of two random pixels.
const TINY: f32 = 1e-3;

/// What a search did.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Searched {
    /// Σ |s − e|^γ over all that were looked at.
    pub(super) energy: f64,
    /// How many were looked at.
    pub(super) looked: usize,
}

/// The outcome for one voxel in one direction.
#[derive(Debug, Clone, Copy)]
struct Match {
    /// The neighbourhood that is best, as far as the search could see.
    place: u32,
    /// Its squared distance.
    distance: f32,
    /// That of the neighbourhood that the voxel has had.
    before: f32,
    /// How much harder each of the two is to choose because layers near by have it, too.
    repeated: [f32; 2],
}

const UNTOUCHED: Match = Match { place: NOWHERE, distance: 0.0, before: 0.0, repeated: [1.0; 2] };

/// How hard a pass searches.
#[derive(Debug, Clone, Copy)]
pub(super) struct Effort {
    /// Random neighbourhoods that are looked at beside the coherent ones.
    pub(super) drawn: usize,
    /// Whether the similarity sets of all neighbours' neighbourhoods are looked through, or only those of a voxel's
    /// own.
    pub(super) all_sets: bool,
}

/// One pass over all voxels. `histograms` has one for each direction, in the order of the axes.
pub(super) fn search(
    level: &Level,
    state: &mut State,
    histograms: &mut [Histogram; 3],
    effort: Effort,
    pass: &mut Pass<'_>,
    exec: &Exec,
) -> Result<Searched, Cancelled> {
    let [nx, ..] = level.lattice.size;
    let directions: Vec<(Axis, usize)> = level.directions().collect();
    let mut found: Vec<Match> = Vec::new();
    let mut done = Searched::default();
    let area = (level.width * level.width) as f32;
    let gamma = if level.number == 0 { GAMMA } else { FINE_GAMMA };
    let arch = pulp::Arch::new();
    for rows in pieces(&level.lattice, pass.number) {
        exec.check()?;
        let wide = directions.len() * nx;
        found.clear();
        found.resize(rows.len() * wide, UNTOUCHED);
        let seen: &State = state;
        let hist: &[Histogram; 3] = histograms;
        found.par_chunks_mut(wide).enumerate().for_each(|(n, line)| {
            let row = rows[n];
            let mut rng = random(level.seed, level.number, 16 + pass.number as u64, row);
            for (&(axis, sheet), line) in directions.iter().zip(line.chunks_exact_mut(nx)) {
                let finder = Finder {
                    level,
                    state: seen,
                    histogram: &hist[axis.index()],
                    effort,
                    axis,
                    sheet,
                    pass: pass.number,
                };
                arch.dispatch(Line { finder: &finder, row, line, rng: &mut rng });
            }
        });
        for (n, line) in found.chunks_exact(wide).enumerate() {
            for ((axis, _), line) in directions.iter().zip(line.chunks_exact(nx)) {
                let a = axis.index();
                let start = rows[n] * nx;
                for (x, m) in line.iter().enumerate() {
                    if m.place == NOWHERE {
                        continue;
                    }
                    let old = state.index[a][start + x];
                    let histogram = &mut histograms[a];
                    // Others of this piece may have taken to the same neighbourhood meanwhile: a move has to be worth
                    // it as things stand now, else all of them move to and fro together.
                    let now = m.distance * m.repeated[0] * histogram.factor(m.place);
                    let then = m.before * m.repeated[1] * histogram.own_factor(old);
                    let moves = old != m.place && now < then;
                    let distance = if moves { m.distance } else { m.before };
                    // The squared distance for each pixel; the weight is |s − e|^(γ−2).
                    let square = distance / area + TINY;
                    state.weight[a][start + x] = short(square.powf(0.5 * (gamma - 2.0)));
                    done.looked += 1;
                    done.energy += f64::from(square.powf(0.5 * GAMMA));
                    if moves {
                        histogram.remove(old);
                        histogram.add(m.place);
                        state.index[a][start + x] = m.place;
                    }
                }
            }
        }
        pass.advance(rows.len());
    }
    Ok(done)
}

/// The search along a row, compiled for every kind of vector unit; the processor's own is chosen as it runs.
struct Line<'a> {
    finder: &'a Finder<'a>,
    row: usize,
    line: &'a mut [Match],
    rng: &'a mut ChaCha8Rng,
}

impl pulp::WithSimd for Line<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        if self.finder.level.atlas.features {
            self.finder.row::<4>(self.row, self.line, self.rng);
        } else {
            self.finder.row::<3>(self.row, self.line, self.rng);
        }
    }
}

/// The search in one direction.
struct Finder<'a> {
    level: &'a Level,
    state: &'a State,
    histogram: &'a Histogram,
    effort: Effort,
    axis: Axis,
    sheet: usize,
    pass: usize,
}

/// Neighbours whose neighbourhoods are followed, as steps to the right and down.
const AROUND: [(isize, isize); 5] = [(0, 0), (-1, 0), (1, 0), (0, -1), (0, 1)];
/// Two for each of these, one for the voxel before and one for that behind.
const BASES: usize = 2 * AROUND.len() + 2;
/// At most so many neighbourhoods are looked at: coherent ones, their similarity sets, and random ones.
const CANDIDATES: usize = BASES + (AROUND.len() + 2) * (SIMILAR - 1) + 24;

impl Finder<'_> {
    #[inline(always)]
    fn row<const C: usize>(&self, row: usize, line: &mut [Match], rng: &mut ChaCha8Rng) {
        let [nx, ny, _] = self.level.lattice.size;
        let (y, z) = (row % ny, row / ny);
        for (x, entry) in line.iter_mut().enumerate() {
            let at = [x, y, z];
            let [right, down] = [self.axis.right(), self.axis.down()];
            let phase = self.level.grid.phase(at[self.axis.index()], self.pass);
            if self.level.grid.is_centre(right, phase[0], at[right.index()])
                && self.level.grid.is_centre(down, phase[1], at[down.index()])
                && self.level.is_open(self.axis, row * nx + x)
            {
                *entry = self.voxel::<C>(row * nx + x, at, rng);
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
        let windows = &level.windows[self.sheet];
        let range = level.depths(at);
        let old = self.state.index[self.axis.index()][voxel];
        let before = windows.head_distance(old, &own) + windows.tail_distance(old, &own);
        let copied = self.copied_near(voxel, at);
        let own_repeated = self.repeated(&copied, old);
        let mut best = Match { place: old, distance: before, before, repeated: [own_repeated; 2] };
        // Equation 5: the distance is multiplied by a factor that grows with use.
        let mut cost = before * own_repeated * self.histogram.own_factor(old);
        let mut candidates = [NOWHERE; CANDIDATES];
        let count = self.candidates(voxel, at, &mut candidates, rng);
        // First the lower bounds of all costs, without a branch, then the few that may be better.
        let mut bounds = [(0.0f32, 0.0f32); CANDIDATES];
        for (bound, &place) in bounds.iter_mut().zip(&candidates[..count]) {
            *bound = (windows.head_distance(place, &own), self.histogram.factor(place));
        }
        for (&(head, factor), &place) in bounds.iter().zip(&candidates[..count]) {
            // What may not be used has an infinite factor.
            if !(head * factor < cost) || place == old {
                continue;
            }
            if let Some((from, to)) = range
                && !(from..=to).contains(&usize::from(level.atlas.depth[place as usize]))
            {
                continue;
            }
            let d = head + windows.tail_distance(place, &own);
            let repeated = self.repeated(&copied, place);
            if d * repeated * factor < cost {
                best = Match { place, distance: d, before, repeated: [repeated, own_repeated] };
                cost = d * repeated * factor;
            }
        }
        best
    }

    /// Where the voxels some layers before and behind are copied from; [`NOWHERE`] where there is none.
    #[inline(always)]
    fn copied_near(&self, voxel: usize, at: [usize; 3]) -> [u32; 2] {
        let near = self.level.lattice.beside(self.axis, voxel, at, REPEATED);
        near.map(|near| near.map_or(NOWHERE, |near| self.state.source[near]))
    }

    /// By how much it is to be made harder to choose a neighbourhood because layers near by have it, or one no further away
    /// than they are.
    #[inline(always)]
    fn repeated(&self, copied: &[u32; 2], place: u32) -> f32 {
        let stride = self.level.atlas.sheets[self.sheet].stride;
        let mut factor = 1.0;
        for &other in copied {
            // From the upper left corner of the square of pixels around that one.
            let from = place.wrapping_sub(other).wrapping_add((REPEATED * (stride + 1)) as u32) as usize;
            if from < (2 * REPEATED + 1) * stride && from % stride <= 2 * REPEATED {
                factor *= self.level.repetition[self.axis.index()];
            }
        }
        factor
    }

    /// The neighbourhoods to choose from: coherent ones with those that look like them, and random ones. How many.
    #[inline(always)]
    fn candidates(
        &self,
        voxel: usize,
        at: [usize; 3],
        list: &mut [u32; CANDIDATES],
        rng: &mut ChaCha8Rng,
    ) -> usize {
        let windows = &self.level.windows[self.sheet];
        let mut bases = [NOWHERE; BASES];
        let (count, with_sets) = self.bases(voxel, at, &mut bases);
        list[..BASES].copy_from_slice(&bases);
        let mut n = count;
        for &base in &bases[..with_sets] {
            for &other in windows.similar(base) {
                list[n] = other;
                n += usize::from(other != NOWHERE);
            }
        }
        if self.effort.drawn > 0 {
            let choice = self.level.choice(self.sheet, at);
            for _ in 0..self.effort.drawn.min(CANDIDATES - n) {
                list[n] = pick(rng, choice);
                n += 1;
            }
        }
        n
    }

    /// The neighbourhoods that follow from those of the voxels around, and from the pixels that they are copied from:
    /// what lies in the photograph where this voxel lies in the volume. Each once; how many there are.
    #[inline(always)]
    fn bases(&self, voxel: usize, at: [usize; 3], bases: &mut [u32; BASES]) -> (usize, usize) {
        let index = &self.state.index[self.axis.index()];
        let stride = self.level.atlas.sheets[self.sheet].stride as isize;
        let one = self.level.atlas.sheets.len() == 1;
        let mut all = [NOWHERE; BASES];
        let mut ask = |n: usize, near: usize, step: isize| {
            if index[near] != NOWHERE {
                all[n / 2] = index[near].wrapping_add_signed(-step as i32);
            }
            let source = self.state.source[near];
            if one || self.level.atlas.sheet_of(source) == self.sheet {
                all[AROUND.len() + 2 + n / 2] = source.wrapping_add_signed(-step as i32);
            }
        };
        let slice = self.level.lattice.slice(self.axis, at);
        for (n, (right, down)) in AROUND.into_iter().enumerate() {
            if let Some(near) = slice.at(right, down) {
                ask(2 * n, near, down * stride + right);
            }
        }
        for (n, near) in self.level.lattice.beside(self.axis, voxel, at, 1).into_iter().enumerate() {
            if let Some(near) = near
                && index[near] != NOWHERE
            {
                all[AROUND.len() + n] = index[near];
            }
        }
        // Own neighbourhood first: it is the first of the list. Sources come last, and alone.
        let sets = if self.effort.all_sets { AROUND.len() + 2 } else { 1 };
        let (mut count, mut with_sets) = (0, 0);
        for (n, base) in all.into_iter().enumerate() {
            if base != NOWHERE
                && !bases[..count].contains(&base)
                && self.histogram.factor(base) < f32::INFINITY
            {
                bases[count] = base;
                count += 1;
                if n < sets {
                    with_sets = count;
                }
            }
        }
        (count, with_sets)
    }
}
