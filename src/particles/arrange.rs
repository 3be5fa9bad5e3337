//! Particles put beside each other as their profiles lie in the photographs \[SST 3.2, Algorithm 1\].

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::{DVec2, DVec3};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::neighbours::{Neighbour, neighbours};
use super::quota::Quotas;
use super::space::{Placed, Space, way, wrapped};
use super::stock::Stock;
use super::view::View;
use super::volume_params::{Order, ParticleParams};
use crate::exec::{Cancelled, Exec};
use crate::synthesis::Axis;

/// So many particles with the profile that is wanted are tried before its place is given up.
const TRIES: usize = 6;
/// So many random places are tried for each particle that is missing in the end.
const TRIES_AT_RANDOM: usize = 200;

/// A place for a particle with some profile.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Candidate {
    /// The axis whose photograph shows the profile.
    axis: usize,
    profile: usize,
    /// Where the centroid of the profile is to lie, in voxels.
    at: DVec3,
    /// How far it is from the middle: the nearest come first, and among those the oldest.
    key: (u64, u64),
}

impl Eq for Candidate {}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.key.cmp(&other.key)
    }
}

/// A plane vector of a photograph as one of the volume.
pub(super) fn in_space(axis: usize, d: DVec2) -> DVec3 {
    let mut p = DVec3::ZERO;
    p[Axis::ALL[axis].right().index()] = d.x;
    p[Axis::ALL[axis].down().index()] = d.y;
    p
}

struct Arranger<'a> {
    views: [Option<&'a View>; 3],
    stock: &'a Stock,
    near: [Vec<Vec<Neighbour>>; 3],
    /// By axis and profile: itself, where particles have it, else the most similar one that they have.
    stand_in: [Vec<usize>; 3],
    order: Order,
    rng: ChaCha8Rng,
    /// Candidates that are in the layer, and the others.
    open: [BinaryHeap<Reverse<Candidate>>; 2],
    count: u64,
    quotas: Quotas,
    space: Space,
    placed: Vec<Placed>,
}

/// Puts particles into a volume until none of the candidates fits any more.
pub(super) fn arrange(
    views: [Option<&View>; 3],
    stock: &Stock,
    params: &ParticleParams,
    order: Order,
    seed: u64,
    exec: &Exec,
) -> Result<(Space, Vec<Placed>), Cancelled> {
    let near = views.map(|v| v.map_or_else(Vec::new, |v| neighbours(v, params.neighbours)));
    let stand_in =
        [0, 1, 2].map(|a| views[a].map_or_else(Vec::new, |view| stand_ins(view, &stock.with_profile[a])));
    let size = params.size.0.map(|n| n as usize);
    let quotas = Quotas::new(views, &stand_in, DVec3::from(size.map(|n| n as f64)));
    let mut arranger = Arranger {
        views,
        stock,
        near,
        stand_in,
        order,
        rng: ChaCha8Rng::seed_from_u64(seed),
        open: [BinaryHeap::new(), BinaryHeap::new()],
        count: 0,
        quotas,
        space: Space::new(size),
        placed: Vec::new(),
    };
    arranger.run(exec)?;
    Ok((arranger.space, arranger.placed))
}

impl Arranger<'_> {
    fn run(&mut self, exec: &Exec) -> Result<(), Cancelled> {
        let stage = exec.stage("arrangement of the particles", 0);
        let middle = self.space.extent() * 0.5;
        let first = (self.rng.next_u64() % self.stock.all.len() as u64) as usize;
        self.place(first, middle);
        while let Some(candidate) = self.next() {
            if self.count.is_multiple_of(256) {
                exec.check()?;
                stage.at(self.placed.len() as u64);
            }
            // As many as belong into what has been filled so far.
            if self.quotas.room(self.progress(candidate.at), self.placed.len()) {
                self.try_at(&candidate);
            }
        }
        self.rest(exec)
    }

    /// The part of the volume that comes before a point.
    fn progress(&self, at: DVec3) -> f64 {
        let extent = self.space.extent();
        let d = way(extent * 0.5, at, extent);
        match self.order {
            Order::Layered(up) => self.quotas.layers(d[up.index()].abs() * 2.0 / extent[up.index()]),
            _ => self.quotas.ball(d.length()),
        }
    }

    /// Puts what is still missing wherever it fits, the large ones first.
    fn rest(&mut self, exec: &Exec) -> Result<(), Cancelled> {
        let Some((axis, view)) = (0..3).find_map(|a| Some((a, self.views[a]?))) else { return Ok(()) };
        let mut profiles = self.stand_in[axis].clone();
        profiles.sort_by_key(|&n| (std::cmp::Reverse(view.profiles.all[n].area), n));
        profiles.dedup();
        let mut left = self.quotas.tries();
        for profile in profiles {
            exec.check()?;
            for _ in 0..self.quotas.missing(axis, profile) {
                let mut tries = TRIES_AT_RANDOM.min(left);
                while tries > 0 {
                    (tries, left) = (tries - 1, left - 1);
                    let list = &self.stock.with_profile[axis][profile];
                    if list.is_empty() {
                        break;
                    }
                    let stocked = list[(self.rng.next_u64() % list.len() as u64) as usize];
                    let voxel = self.space.size.map(|n| (self.rng.next_u64() % n as u64) as i32);
                    if self.space.is_free(voxel, &self.stock.all[stocked].stencil) {
                        self.place(stocked, DVec3::from(voxel.map(f64::from)) + 0.5);
                        break;
                    }
                }
            }
        }
        Ok(())
    }

    fn next(&mut self) -> Option<Candidate> {
        let [within, beyond] = &mut self.open;
        within.pop().or_else(|| beyond.pop()).map(|Reverse(c)| c)
    }

    fn try_at(&mut self, candidate: &Candidate) {
        let voxel = self.space.voxel_of(candidate.at);
        if self.space.labels[self.space.at(voxel, [0; 3])] != super::space::FREE {
            return;
        }
        let profile = self.stand_in[candidate.axis][candidate.profile];
        if !self.quotas.wanted(candidate.axis, profile, self.placed.len()) {
            return;
        }
        let list = &self.stock.with_profile[candidate.axis][profile];
        if list.is_empty() {
            return;
        }
        let tries = TRIES.min(list.len());
        let start = (self.rng.next_u64() % list.len() as u64) as usize;
        for k in 0..tries {
            let stocked = list[(start + k) % list.len()];
            // The centroid is where the photograph has it; the aligned centre is beside it.
            let centre = candidate.at + self.offset(candidate.axis, stocked);
            let voxel = self.space.voxel_of(centre);
            if self.space.is_free(voxel, &self.stock.all[stocked].stencil) {
                self.place(stocked, centre);
                return;
            }
        }
    }

    /// The way from the centroid of a particle's profile to its centre, in voxels.
    fn offset(&self, axis: usize, stocked: usize) -> DVec3 {
        let (Some(view), Some((profile, place))) =
            (self.views[axis], self.stock.all[stocked].triple.sections[axis])
        else {
            return DVec3::ZERO;
        };
        let section = super::align::section(view, profile, place);
        in_space(axis, (section.centre - view.profiles.all[profile].centroid) * view.scale)
    }

    fn place(&mut self, stocked: usize, centre: DVec3) {
        let extent = self.space.extent();
        let centre = wrapped(centre, extent);
        let voxel = self.space.voxel_of(centre);
        let label = self.placed.len() as u32 + 1;
        self.space.fill(voxel, &self.stock.all[stocked].stencil, label);
        // The stencil is that of a centre in a voxel's middle.
        let centre = DVec3::from(voxel.map(f64::from)) + 0.5;
        self.placed.push(Placed { stocked, centre });
        self.quotas.placed(&self.stock.all[stocked].triple);
        for axis in 0..3 {
            let (Some(view), Some((profile, _))) =
                (self.views[axis], self.stock.all[stocked].triple.sections[axis])
            else {
                continue;
            };
            let from = centre - self.offset(axis, stocked);
            for k in 0..self.near[axis][profile].len() {
                let (neighbour, d) = self.near[axis][profile][k];
                let at = wrapped(from + in_space(axis, d * view.scale), extent);
                self.add(axis, neighbour, at);
            }
        }
    }

    fn add(&mut self, axis: usize, profile: usize, at: DVec3) {
        let extent = self.space.extent();
        let d = way(extent * 0.5, at, extent);
        let (heap, distance) = match self.order {
            Order::Layered(up) => {
                let a = up.index();
                let flat = DVec3::from([0, 1, 2].map(|k| if k == a { 0.0 } else { d[k] })).length();
                // Beyond the layer the lowest come first, then those nearest to the middle of their plane.
                if axis == a { (0, flat) } else { (1, d[a].abs() * 1024.0 + flat) }
            }
            _ => (0, d.length()),
        };
        self.count += 1;
        let key = ((distance * 4096.0) as u64, self.count);
        self.open[heap].push(Reverse(Candidate { axis, profile, at, key }));
    }
}

/// What stands in for the profiles that no particle has: of those that some have, one of the same class, if there is any, and
/// of about the same area.
fn stand_ins(view: &View, with_profile: &[Vec<usize>]) -> Vec<usize> {
    let all = &view.profiles.all;
    let has: Vec<usize> = (0..all.len()).filter(|&n| !with_profile[n].is_empty()).collect();
    let nearest = |n: usize| {
        let differs = |&m: &usize| (all[m].class != all[n].class, all[m].area.abs_diff(all[n].area), m);
        has.iter().copied().min_by_key(differs).unwrap_or(n)
    };
    (0..all.len()).map(|n| if with_profile[n].is_empty() { nearest(n) } else { n }).collect()
}
