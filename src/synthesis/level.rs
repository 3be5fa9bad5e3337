//! One level of the pyramid: its photographs, its voxels, and what is known of each voxel.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rayon::prelude::*;

use super::atlas::{Atlas, NOWHERE};
use super::axes::Axis;
use super::grid::Grid;
use super::histogram::Histogram;
use super::lattice::Lattice;
use super::windows::{Depth, Windows};

/// What does not change while a level is worked on.
pub(super) struct Level {
    /// Its number, 0 the coarsest.
    pub(super) number: usize,
    pub(super) atlas: Atlas,
    /// The neighbourhoods of each photograph.
    pub(super) windows: Vec<Windows>,
    /// Pixels along a neighbourhood's side.
    pub(super) width: usize,
    pub(super) lattice: Lattice,
    /// Which neighbourhoods a pass looks at.
    pub(super) grid: Grid,
    /// Whether it is the last.
    pub(super) finest: bool,
    /// For slices perpendicular to each axis, by how much a neighbourhood is made harder to choose for each of the layers
    /// [`REPEATED`] before and behind that is copied from about the same pixel: see [`Level::repetition`].
    pub(super) repetition: [f32; 3],
    /// The photograph of the slices perpendicular to each axis; none where they are unconstrained.
    pub(super) photo_of: [Option<usize>; 3],
    /// The axis that is depth, and how it binds, where the texture varies.
    pub(super) depth: Option<(Axis, Depth)>,
    /// The voxels that are to be found, where some are given.
    pub(super) free: Option<Free>,
    pub(super) seed: u64,
}

/// The voxels that are to be found, where others are given.
pub(super) struct Free {
    /// For each voxel whether it is.
    pub(super) voxels: Vec<bool>,
    /// For slices perpendicular to each axis, whether a voxel's neighbourhood holds one that is.
    pub(super) windows: [Vec<bool>; 3],
}

/// What is known of each voxel.
pub(super) struct State {
    /// Where it is copied from.
    pub(super) source: Vec<u32>,
    /// For the slice perpendicular to each axis the neighbourhood that its own resembles most; [`NOWHERE`] where its
    /// own does not fit into the volume; empty where the direction is unconstrained.
    pub(super) index: [Vec<u32>; 3],
    /// The weight of each of these neighbourhoods: the upper half of an f32, which is precise enough.
    pub(super) weight: [Vec<u16>; 3],
}

/// Layers apart at which slices are not to repeat each other.
pub(super) const REPEATED: usize = 3;
/// How much harder a repetition is to choose where the photographs change as much as they ever do over so many pixels.
const REPETITION: f32 = 2.0;

/// Steps to the pixels around one.
const ASIDE: [[isize; 2]; 8] = [[-1, -1], [0, -1], [1, -1], [-1, 0], [1, 0], [-1, 1], [0, 1], [1, 1]];

/// The upper half of a positive number.
#[inline(always)]
pub(super) fn short(x: f32) -> u16 {
    (x.to_bits() >> 16) as u16
}

/// The number that has this upper half.
#[inline(always)]
pub(super) fn long(x: u16) -> f32 {
    f32::from_bits(u32::from(x) << 16)
}

/// A stream of random numbers that depends on what is drawn alone.
pub(super) fn random(seed: u64, level: usize, what: u64, row: usize) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream((level as u64) << 56 | what << 40 | row as u64);
    rng
}

/// One of a list that is not empty.
#[inline(always)]
pub(super) fn pick(rng: &mut ChaCha8Rng, list: &[u32]) -> u32 {
    list[((u64::from(rng.next_u32()) * list.len() as u64) >> 32) as usize]
}

impl Level {
    /// The directions that are constrained, and the photograph of each.
    pub(super) fn directions(&self) -> impl Iterator<Item = (Axis, usize)> + '_ {
        Axis::ALL.into_iter().filter_map(|axis| self.photo_of[axis.index()].map(|photo| (axis, photo)))
    }

    /// The depths that a voxel may copy from.
    #[inline(always)]
    pub(super) fn depths(&self, at: [usize; 3]) -> Option<(usize, usize)> {
        self.depth.map(|(axis, depth)| {
            let own = at[axis.index()];
            (own.saturating_sub(depth.tolerance), (own + depth.tolerance).min(depth.rows - 1))
        })
    }

    /// The neighbourhoods of photograph `sheet` that may serve at a voxel.
    pub(super) fn choice(&self, sheet: usize, at: [usize; 3]) -> &[u32] {
        match self.depths(at) {
            Some((from, to)) => self.windows[sheet].between(from, to),
            None => &self.windows[sheet].all,
        }
    }

    /// A volume drawn out of one photograph along a diagonal has perfect slices in two directions of three, and stripes in the
    /// third: energy (1) likes it, and it grows. In it a slice goes on copying from about the same pixels layer after
    /// layer. So a neighbourhood that a slice [`REPEATED`] layers away has too is made harder to choose, as much as the
    /// photographs that show this axis change over so many pixels: along the grain of wood, where layers should be alike, hardly.
    pub(super) fn repetition(atlas: &Atlas, windows: &[Windows], photo_of: [Option<usize>; 3]) -> [f32; 3] {
        Axis::ALL.map(|axis| {
            let (mut sum, mut count) = (0.0, 0);
            for other in Axis::ALL.into_iter().filter(|&other| other != axis) {
                let Some(sheet) = photo_of[other.index()] else { continue };
                let along = if other.right() == axis { 1 } else { atlas.sheets[sheet].stride };
                let apart = (REPEATED * along) as u32;
                for &p in windows[sheet].all.iter().filter(|&&p| atlas.usable[(p + apart) as usize]) {
                    let [a, b] = [p, p + apart].map(|p| atlas.look[p as usize]);
                    sum += (0..3).map(|k| f64::from(a[k] - b[k]).powi(2)).sum::<f64>();
                    count += 1;
                }
            }
            // Two pixels picked at random have a squared distance of 2.
            1.0 + REPETITION * (sum / f64::from(count.max(1)) / 2.0).min(1.0) as f32
        })
    }

    /// The empty index histogram of a direction.
    pub(super) fn index_histogram(&self, axis: Axis, sheet: usize, matched: bool) -> Histogram {
        let windows = &self.windows[sheet];
        let at = |n: usize| self.lattice.position(n);
        let fits = |n: &usize| self.lattice.window_fits(axis, self.width, at(*n)) && self.is_open(axis, *n);
        let entries = (0..self.lattice.voxels()).into_par_iter().filter(fits).count();
        let stride = self.atlas.sheets[sheet].stride;
        let offsets = super::windows::offsets(self.width, stride);
        // A neighbourhood is wanted as often as its pixels are, on the mean.
        let share = |&place: &u32| {
            let wanted = |&o: &i32| self.atlas.wanted[place.wrapping_add_signed(o) as usize];
            (place, offsets.iter().map(wanted).sum::<f32>() / offsets.len() as f32)
        };
        let mut histogram = Histogram::new(self.atlas.usable.len());
        histogram.want(windows.all.iter().map(share), entries, matched);
        histogram
    }

    /// The empty position histogram. Where some voxels are given, the others copy only from pixels that are wanted.
    pub(super) fn position_histogram(&self, matched: bool) -> Histogram {
        let mut histogram = Histogram::new(self.atlas.usable.len());
        let places: Vec<(u32, f32)> = self.places().map(|p| (p, self.atlas.wanted[p as usize])).collect();
        let entries = match &self.free {
            Some(free) => free.voxels.iter().filter(|f| **f).count(),
            None => self.lattice.voxels(),
        };
        histogram.want(places.into_iter(), entries, matched);
        histogram
    }

    /// The places that voxels copy from.
    pub(super) fn places(&self) -> impl Iterator<Item = u32> + '_ {
        self.atlas.places().filter(|&p| self.free.is_none() || self.atlas.wanted[p as usize] > 0.0)
    }

    /// Whether a voxel's neighbourhood holds voxels that are to be found.
    #[inline(always)]
    pub(super) fn is_open(&self, axis: Axis, voxel: usize) -> bool {
        self.free.as_ref().is_none_or(|free| free.windows[axis.index()][voxel])
    }

    /// Whether a voxel is to be found.
    #[inline(always)]
    pub(super) fn is_free(&self, voxel: usize) -> bool {
        self.free.as_ref().is_none_or(|free| free.voxels[voxel])
    }

    /// A state in which every voxel is a random pixel, and every neighbourhood a random one.
    pub(super) fn random_state(&self) -> State {
        let voxels = self.lattice.voxels();
        let mut pixels: Vec<u32> = self.atlas.places().collect();
        let depth_at = |p: u32| usize::from(self.atlas.depth[p as usize]);
        if self.depth.is_some() {
            pixels.sort_by_key(|&p| (depth_at(p), p));
        }
        let nx = self.lattice.size[0];
        let mut source = vec![NOWHERE; voxels];
        source.par_chunks_mut(nx).enumerate().for_each(|(row, line)| {
            let mut rng = random(self.seed, self.number, 0, row);
            for (x, voxel) in line.iter_mut().enumerate() {
                let list = match self.depths(self.lattice.position(row * nx + x)) {
                    Some((from, to)) => {
                        // Where all is clear at a depth, the neighbourhoods above and below it will tell.
                        let from = pixels.partition_point(|&p| depth_at(p) < from);
                        let to = pixels.partition_point(|&p| depth_at(p) <= to);
                        if from < to { &pixels[from..to] } else { &pixels[..] }
                    }
                    None => &pixels[..],
                };
                *voxel = pick(&mut rng, list);
            }
        });
        let mut index = [const { Vec::new() }; 3];
        for (axis, sheet) in self.directions() {
            index[axis.index()] = self.sites(axis, |at, rng| pick(rng, self.choice(sheet, at)));
        }
        let weight = index.each_ref().map(|i| vec![short(1.0); i.len()]);
        State { source, index, weight }
    }

    /// A list with an entry for each voxel: what `find` says where the voxel's neighbourhood fits into the volume,
    /// else [`NOWHERE`].
    pub(super) fn sites(
        &self,
        axis: Axis,
        find: impl Fn([usize; 3], &mut ChaCha8Rng) -> u32 + Sync,
    ) -> Vec<u32> {
        let nx = self.lattice.size[0];
        let mut list = vec![NOWHERE; self.lattice.voxels()];
        list.par_chunks_mut(nx).enumerate().for_each(|(row, line)| {
            let mut rng = random(self.seed, self.number, 1 + axis.index() as u64, row);
            for (x, entry) in line.iter_mut().enumerate() {
                let at = self.lattice.position(row * nx + x);
                if self.lattice.window_fits(axis, self.width, at) {
                    *entry = find(at, &mut rng);
                }
            }
        });
        list
    }

    /// The state that the next coarser level hands on: each voxel's neighbourhoods are those of the voxel that it
    /// lies in, seen closer. Sources are still to be found.
    pub(super) fn refined_state(&self, coarse: &Self, state: &State) -> State {
        let mut index = [const { Vec::new() }; 3];
        let mut weight = [const { Vec::new() }; 3];
        // Where the volume wraps, the first and the last layer lie in one coarse layer: two that meet there must fit
        // no worse than others.
        let phase = self.lattice.tiles.map(usize::from);
        for (axis, sheet) in self.directions() {
            let (right, down) = (axis.right().index(), axis.down().index());
            let from = &state.index[axis.index()];
            let parent = |at: [usize; 3]| {
                let mut parent = [0, 1, 2].map(|a| (at[a] + phase[a]) / 2);
                // Beyond the last neighbourhood that fits, the nearest one goes on.
                let half = coarse.width / 2;
                for a in [right, down] {
                    if !coarse.lattice.tiles[a] {
                        parent[a] = parent[a].clamp(half, coarse.lattice.size[a] + half - coarse.width);
                    }
                }
                parent
            };
            let number = |parent: [usize; 3]| {
                let size = coarse.lattice.size;
                let [x, y, z] = [0, 1, 2].map(|a| parent[a] % size[a]);
                (z * size[1] + y) * size[0] + x
            };
            // Both layers of voxels within one coarse layer would get the same neighbourhoods, and the volume would stay
            // a pile of doubled slices. Every other layer gets those a pixel aside (as a layer it is as coherent), half of
            // them from the next coarse layer, so that it comes to lie between the two.
            let mut rng = random(self.seed, self.number, 8 + axis.index() as u64, 0);
            let layers = 0..self.lattice.size[axis.index()];
            let steps = self.alike(sheet);
            let aside: Vec<[isize; 2]> =
                layers.map(|_| steps[(rng.next_u32() % steps.len() as u32) as usize]).collect();
            let a = axis.index();
            let find = |at: [usize; 3], rng: &mut ChaCha8Rng| {
                let mut parent = parent(at);
                let between = (at[a] + phase[a]) % 2 == 1;
                let goes_on = coarse.lattice.tiles[a] || parent[a] + 1 < coarse.lattice.size[a];
                if between && goes_on && rng.next_u32().is_multiple_of(2) {
                    parent[a] += 1;
                }
                let place = from[number(parent)];
                let [px, py] = coarse.atlas.sheets[sheet].pixel(place);
                let child = |p: usize, a: usize| (2 * p + at[a] + phase[a]) as isize - 2 * parent[a] as isize;
                let [x, y] = if between { aside[at[a]] } else { [0, 0] };
                self.nearest(sheet, [child(px, right) + x, child(py, down) + y], at, rng)
            };
            index[axis.index()] = self.sites(axis, find);
            let weights = &state.weight[axis.index()];
            let weigh = |n: usize| weights[number(parent(self.lattice.position(n)))];
            weight[axis.index()] = (0..self.lattice.voxels()).into_par_iter().map(weigh).collect();
        }
        State { source: vec![NOWHERE; self.lattice.voxels()], index, weight }
    }

    /// The steps of a pixel that change a photograph least: along its grain, where it has one, and never across its
    /// depth.
    fn alike(&self, sheet: usize) -> Vec<[isize; 2]> {
        let on = &self.atlas.sheets[sheet];
        let photo_axis = Axis::ALL[self.photo_of.iter().position(|p| *p == Some(sheet)).unwrap_or(0)];
        let across = self.depth.map(|(axis, _)| usize::from(photo_axis.down() == axis));
        let change = |[x, y]: [isize; 2]| {
            let step = y * on.stride as isize + x;
            let pairs = self.windows[sheet].all.iter().filter_map(|&p| {
                let (a, b) = (p as usize, p.wrapping_add_signed(step as i32) as usize);
                self.atlas.usable[b].then(|| {
                    let [a, b] = [a, b].map(|p| self.atlas.look[p]);
                    (0..4).map(|k| f64::from(a[k] - b[k]).powi(2)).sum::<f64>()
                })
            });
            let (sum, count) = pairs.fold((0.0, 0), |(sum, count), d| (sum + d, count + 1));
            sum / f64::from(count.max(1)) / (x * x + y * y) as f64
        };
        let steps = ASIDE.into_iter().filter(|step| across.is_none_or(|k| step[k] == 0));
        let all: Vec<([isize; 2], f64)> = steps.map(|step| (step, change(step))).collect();
        let least = all.iter().map(|s| s.1).fold(f64::INFINITY, f64::min);
        all.into_iter().filter(|s| s.1 <= 1.25 * least).map(|s| s.0).collect()
    }

    /// The neighbourhood nearest to a pixel that may serve at a voxel; a random one where unusable pixels lie there.
    fn nearest(&self, sheet: usize, pixel: [isize; 2], at: [usize; 3], rng: &mut ChaCha8Rng) -> u32 {
        let on = &self.atlas.sheets[sheet];
        let half = self.width / 2;
        let mut low = [half; 2];
        let mut high = on.size.map(|n| n + half - self.width);
        if let (Some((from, to)), Some((axis, _))) = (self.depths(at), self.depth) {
            // Along depth the photograph and the volume have the same number of rows.
            let photo_axis = Axis::ALL[self.photo_of.iter().position(|p| *p == Some(sheet)).unwrap_or(0)];
            let k = usize::from(photo_axis.down() == axis);
            low[k] = low[k].max(from).min(high[k]);
            high[k] = high[k].min(to).max(low[k]);
        }
        let [x, y] = [0, 1].map(|k| (pixel[k].max(0) as usize).clamp(low[k], high[k]));
        let place = on.place(x, y);
        let choice = self.choice(sheet, at);
        let found = match self.depth {
            None => choice.binary_search(&place).is_ok(),
            Some(_) => choice
                .binary_search_by_key(&(self.atlas.depth[place as usize], place), |&p| {
                    (self.atlas.depth[p as usize], p)
                })
                .is_ok(),
        };
        if found { place } else { pick(rng, choice) }
    }
}
