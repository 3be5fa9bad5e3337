//! Particles that fit into holes.
//!
//! First those that the patches have there by themselves, then others in what is left, straight ones, the larger ones first:
//! as a mason fills a gap with what is at hand, cut to size.

use std::collections::HashMap;

use glam::{BVec3, DVec3};
use rayon::prelude::*;

use super::broken::ByTet;
use super::chart::{Chart, Sheet, Straight, coordinates};
use super::direct::{Direct, is_straight};
use super::form::{FIRST, Form};
use super::lifts::{Lifts, Particle};
use super::whole::layer;
use crate::exec::{Cancelled, Exec};
use crate::lap::coverage::{LATTICE, ORDER};
use crate::lap::frames::PatchFrames;
use crate::lap::measure::{anywhere_inside, numbers};
use crate::lap::optimise::Given;
use crate::lap::pasted::{Pasted, columns};
use crate::lap::seed::mix;
use crate::mesh::{TetMesh, index};

/// By how much particles are made smaller along an axis to fit a hole.
const SIZES: [f64; 5] = [1.0, 0.8, 0.6, 0.45, 0.3];
/// The least part of a particle's volume that is left.
const SMALLEST: f64 = 0.04;
/// The least part of the volume of one that belongs to a patch: straight ones are better to look at than bent small ones.
const WORTH: f64 = 0.5;
/// Of the volume of an open tetrahedron, this many times that of a mean particle is one place to be filled.
const SPACING: f64 = 0.05;
/// The most places in a tetrahedron.
const PLACES: usize = 60;
/// How often places are looked for in what is left.
const ROUNDS: usize = 2;
/// Steps with which is looked how much room there is, in voxels.
const STEP: f64 = 2.0;
/// The particles of a patch are taken where it is stretched by at most this, either way, ...
const STRETCH: f64 = 1.8;
/// ... and the determinant of J·\[R S T\] is at least this part of the product of its columns' lengths.
const UPRIGHT: f64 = 0.5;
/// Joints are at most this part of a particle's reach.
const JOINT: f64 = 0.3;

/// What is there when particles are looked for.
pub(super) struct Holes<'a> {
    pub(super) mesh: &'a TetMesh,
    pub(super) given: Given<'a>,
    pub(super) direct: &'a Direct,
    pub(super) lifts: &'a Lifts<'a>,
    pub(super) broken: &'a ByTet,
}

/// A particle that has a place.
pub(super) struct Placed {
    pub(super) label: u32,
    /// A patch of one period about it.
    pub(super) pasted: Pasted,
}

/// A particle that is looked at: which, and where.
#[derive(Clone, Copy)]
struct Candidate<'a> {
    label: u32,
    form: &'a Form,
    /// A tetrahedron of the patch into which it reaches.
    slot: usize,
    /// Where its middle lies in the patch.
    at: DVec3,
    size: DVec3,
}

/// A particle that is in, in a tetrahedron.
struct Taken {
    /// How many were put in before.
    number: usize,
    label: u32,
    /// Where its texture is read at the corners, beside its first copy.
    uvw: [DVec3; 4],
    middle: DVec3,
    reach: DVec3,
    /// The patch to which it belongs at full size.
    patch: Option<usize>,
}

/// Whole particles in the holes, one after the other.
pub(super) fn fitting(
    holes: &Holes<'_>,
    patches: &[Pasted],
    everywhere: u32,
    exec: &Exec,
) -> Result<Vec<Placed>, Cancelled> {
    let mut mason = Mason {
        sizes: sizes(holes.direct.free()),
        joint: 0.5 * holes.lifts.joint() * holes.free(),
        everywhere,
        full: holes.mesh.tets.iter().map(|_| Vec::new()).collect(),
        placed: Vec::new(),
        holes,
    };
    let open = holes.open();
    let of_patches: Vec<(Sheet<'_>, Vec<Candidate<'_>>)> = (patches.par_iter())
        .map(|patch| {
            exec.check()?;
            Ok((Sheet::new(holes.mesh, patch), holes.copies(patch, &open)))
        })
        .collect::<Result<_, Cancelled>>()?;
    for (n, (sheet, copies)) in of_patches.iter().enumerate() {
        exec.check()?;
        // Those that fit by themselves are found side by side; one after the other they then keep clear of each other.
        let fit: Vec<(usize, &Candidate<'_>)> =
            copies.par_iter().filter_map(|c| Some((mason.first(sheet, Some(n), c)?, c))).collect();
        let before = mason.placed.len();
        for (size, candidate) in fit {
            mason.put(sheet, Some(n), candidate, size, before);
        }
    }
    drop(of_patches);
    exec.check()?;
    for round in 0..ROUNDS {
        exec.check()?;
        let mut others: Vec<(usize, Straight<'_>, Candidate<'_>)> = (mason.others(round).into_par_iter())
            .filter_map(|(chart, c)| {
                let c = mason.centred(&chart, c);
                Some((mason.first(&chart, None, &c)?, chart, c))
            })
            .collect();
        others.sort_by_key(|other| other.0);
        let before = mason.placed.len();
        for (size, chart, candidate) in &others {
            exec.check()?;
            mason.put(chart, None, candidate, *size, before);
        }
    }
    Ok(mason.placed)
}

/// All sizes, the largest first; 1 along axes that are given.
fn sizes(free: [bool; 3]) -> Vec<DVec3> {
    let along = |axis: usize| if free[axis] { &SIZES[..] } else { &SIZES[..1] };
    let mut all: Vec<DVec3> = (along(0).iter())
        .flat_map(|x| along(1).iter().flat_map(move |y| along(2).iter().map(move |z| DVec3::new(*x, *y, *z))))
        .filter(|size| size.element_product() >= SMALLEST)
        .collect();
    all.sort_by(|a, b| b.element_product().total_cmp(&a.element_product()));
    all
}

/// Who puts particles in.
struct Mason<'a> {
    holes: &'a Holes<'a>,
    sizes: Vec<DVec3>,
    /// Half a joint, along each axis.
    joint: DVec3,
    everywhere: u32,
    /// What is in already, by tetrahedron, oldest first.
    full: Vec<Vec<Taken>>,
    placed: Vec<Placed>,
}

impl<'a> Mason<'a> {
    /// The number of the largest size for which there is room. `of` is the patch to which it belongs.
    fn first(&self, chart: &impl Chart, of: Option<usize>, c: &Candidate<'_>) -> Option<usize> {
        let mut last = 0;
        let mut room = |size| self.has_room(chart, of, &Candidate { size, ..*c }, 0, &mut last);
        // What lies in all sizes must have room first.
        let core = DVec3::select(self.free_axes(), DVec3::splat(SIZES[SIZES.len() - 1]), DVec3::ONE);
        room(core).then(|| self.sizes(of, 0).position(room))?
    }

    /// Puts a particle in, in the largest size from a first one on for which there is room; for that one there was, when
    /// `before` were in.
    fn put(&mut self, chart: &impl Chart, of: Option<usize>, c: &Candidate<'_>, first: usize, before: usize) {
        let mut last = 0;
        let fit = self.sizes(of, first).enumerate().find_map(|(n, size)| {
            let c = Candidate { size, ..*c };
            let since = if n == 0 { before } else { 0 };
            self.has_room(chart, of, &c, since, &mut last).then_some(c)
        });
        if let Some(c) = fit {
            self.add(chart, of, &c);
        }
    }

    /// The sizes that come into question, from a first one on.
    fn sizes(&self, of: Option<usize>, first: usize) -> impl Iterator<Item = DVec3> {
        let least = if of.is_some() { WORTH } else { 0.0 };
        self.sizes[first..].iter().copied().take_while(move |size| size.element_product() >= least)
    }

    fn free_axes(&self) -> BVec3 {
        BVec3::from_array(self.holes.direct.free())
    }

    /// Whether a particle, and half a joint around it, lies wholly in a patch and over nothing that stays: a whole particle of
    /// the model's own coordinates, or one that is in. With a `since` above 0 only those are looked at that came after as many
    /// others. `last` is the point that was in the way before: it likely is again.
    fn has_room(
        &self,
        chart: &impl Chart,
        of: Option<usize>,
        c: &Candidate<'_>,
        since: usize,
        last: &mut usize,
    ) -> bool {
        let voxel = self.holes.lifts.size().recip();
        let joint = (self.joint / c.form.reach).min(DVec3::splat(JOINT) * c.size);
        let size = c.size + joint.max(voxel / c.form.reach);
        let of = of.filter(|_| c.size == DVec3::ONE);
        let mut slot = c.slot;
        let mut is_free = |point: usize| {
            let place = c.at + (c.form.points[point] - c.form.middle) * size;
            self.is_free(chart, &mut slot, place, of, since)
        };
        if !is_free(*last) {
            return false;
        }
        // A small one has points enough if some are left out.
        let step = (size.max_element().powi(-2) as usize).max(1);
        let count = c.form.points.len();
        let in_the_way =
            (0..FIRST.min(count)).chain((FIRST..count).step_by(step)).find(|&point| !is_free(point));
        *last = in_the_way.unwrap_or(*last);
        in_the_way.is_none()
    }

    /// Whether nothing that stays is at a place, to which is gone from a `slot`.
    fn is_free(
        &self,
        chart: &impl Chart,
        slot: &mut usize,
        place: DVec3,
        of: Option<usize>,
        since: usize,
    ) -> bool {
        match chart.walk(*slot, place) {
            Ok(Some((at, b))) => {
                *slot = at;
                let t = chart.tet(at);
                (since > 0 || !self.holes.is_own(t, &b)) && !self.is_full(t, &b, of, since)
            }
            // What sticks out of the model is not seen.
            Ok(None) => true,
            Err(()) => false,
        }
    }

    /// The candidate moved to where there is as much room on either side of it along each free axis, as far as it reaches.
    fn centred<'c>(&self, chart: &impl Chart, mut c: Candidate<'c>) -> Candidate<'c> {
        for axis in (0..3).filter(|&axis| self.holes.direct.free()[axis]) {
            let step = DVec3::AXES[axis] * STEP / self.holes.lifts.size();
            let far = ((c.form.reach + self.joint)[axis] / step[axis]).ceil() as usize;
            let room = [step, -step].map(|step| {
                let mut slot = c.slot;
                (1..=far).find(|&n| !self.is_free(chart, &mut slot, c.at + step * n as f64, None, 0)).unwrap_or(far)
            });
            let at = c.at + step * 0.5 * (room[0] as f64 - room[1] as f64);
            if let Ok(Some((slot, _))) = chart.walk(c.slot, at) {
                (c.slot, c.at) = (slot, at);
            }
        }
        c
    }

    /// Whether one that is in lies at a point, which is not of the same patch and came after as many others.
    fn is_full(&self, t: u32, b: &[f64; 4], of: Option<usize>, since: usize) -> bool {
        let is_there = |other: &Taken| {
            let place: DVec3 = (0..4).map(|k| other.uvw[k] * b[k]).sum();
            (place - other.middle).abs().cmple(other.reach).all()
                && self.holes.lifts.at(place) == Some(Particle { label: other.label, cell: [0; 3] })
        };
        let new = self.full[t as usize].iter().rev().take_while(|other| other.number >= since);
        new.filter(|other| of.is_none() || of != other.patch).any(is_there)
    }

    fn add(&mut self, chart: &impl Chart, of: Option<usize>, c: &Candidate<'_>) {
        let free = self.holes.free();
        let reach = c.form.reach + 0.5 / self.holes.lifts.size();
        // The texture is read one period about the particle, so that no other copy of it is seen.
        let shift = (c.form.middle - 0.5) * free;
        let mut pasted = layer(Vec::new(), Vec::new(), self.everywhere + 1);
        pasted.shift = shift.as_vec3().to_array();
        for slot in chart.under(c.slot, c.at, reach * c.size) {
            let uvw = chart.coordinates(slot).map(|w| (w - c.at * free) / c.size + 0.5 * free);
            let t = chart.tet(slot);
            pasted.tets.push(t);
            pasted.uvw.push(uvw.map(|w| w.as_vec3().to_array()));
            self.full[t as usize].push(Taken {
                number: self.placed.len(),
                label: c.label,
                uvw: uvw.map(|w| w + shift),
                middle: c.form.middle,
                reach: c.form.reach,
                patch: of.filter(|_| c.size == DVec3::ONE),
            });
        }
        self.placed.push(Placed { label: c.label, pasted });
    }

    /// Particles at places of holes where nothing is yet, as straight as the frame is there.
    fn others(&self, round: usize) -> Vec<(Straight<'a>, Candidate<'a>)> {
        let (holes, free) = (self.holes, self.free_axes());
        let stock: Vec<(u32, &Form)> = holes.lifts.compact().collect();
        if stock.is_empty() {
            return Vec::new();
        }
        let volume = stock.iter().map(|(_, form)| 8.0 * form.reach.element_product()).sum::<f64>();
        let spacing = SPACING * volume / stock.len() as f64;
        let frames = PatchFrames::new(&holes.direct.asked, 0, glam::DQuat::IDENTITY);
        let in_tet = |t: u32| {
            let frame = frames.frame(t as usize);
            let volume = holes.mesh.tet_volume(t as usize) * frame.texture_from_world.determinant().abs();
            let places = ((volume / spacing).ceil() as usize).min(PLACES);
            let stock = &stock;
            (0..places).filter_map(move |n| {
                let b = anywhere_inside(&mut numbers(0x0D1E_5EED_7A6E_0051 + round as u64, t as usize * PLACES + n));
                if !holes.is_open(t, &b) || self.is_full(t, &b, None, 0) {
                    return None;
                }
                let mean = |of: [DVec3; 4]| (0..4).map(|k| of[k] * b[k]).sum::<DVec3>();
                let origin = mean(holes.mesh.corners(t as usize));
                let chart = Straight { mesh: holes.mesh, given: holes.given, origin, frame };
                let slot = t as usize;
                let place = mean(chart.coordinates(slot));
                // Along an axis that is given a particle stays where it is.
                let fits = |form: &Form| ((place - form.middle).abs().cmple(form.reach) | free).all();
                let from = mix(u64::from(t), n as u64, round as u64) as usize % stock.len();
                let (label, form) =
                    stock[from..].iter().chain(&stock[..from]).copied().find(|(_, form)| fits(form))?;
                let at = DVec3::select(free, DVec3::ZERO, form.middle);
                Some((chart, Candidate { label, form, slot, at, size: DVec3::ONE }))
            })
        };
        let tets = (0..index(holes.mesh.tets.len())).into_par_iter().filter(|&t| holes.has_hole(t));
        tets.flat_map_iter(in_tet).collect()
    }
}

impl Holes<'_> {
    /// 1 along axes that are solved for, 0 along those that are given.
    fn free(&self) -> DVec3 {
        DVec3::from_array(self.direct.free().map(|free| f64::from(u8::from(free))))
    }

    fn has_hole(&self, t: u32) -> bool {
        self.direct.regular(t as usize).is_none() || !self.broken[t as usize].is_empty()
    }

    /// Whether nothing is at a point by the model's own coordinates: there are none, or a particle that is left out.
    fn is_open(&self, t: u32, b: &[f64; 4]) -> bool {
        let Some(own) = self.direct.regular(t as usize) else { return true };
        self.lifts.at((0..4).map(|k| own[k] * b[k]).sum()).is_some_and(|p| self.is_broken(t, p))
    }

    /// Whether a whole particle of the model's own coordinates shows at a point.
    fn is_own(&self, t: u32, b: &[f64; 4]) -> bool {
        self.direct.regular(t as usize).is_some_and(|own| {
            let particle = self.lifts.at((0..4).map(|k| own[k] * b[k]).sum());
            particle.is_some_and(|p| !self.is_broken(t, p))
        })
    }

    fn is_broken(&self, t: u32, particle: Particle) -> bool {
        self.broken[t as usize].contains(&particle)
    }

    /// The lattice points of tetrahedra at which is nothing.
    fn open(&self) -> HashMap<u32, Vec<[f64; 4]>> {
        let points = LATTICE.map(|b| b.map(|e| f64::from(e) / ORDER as f64));
        (0..index(self.mesh.tets.len()))
            .into_par_iter()
            .filter(|&t| self.has_hole(t))
            .map(|t| (t, points.into_iter().filter(|b| self.is_open(t, b)).collect()))
            .collect()
    }

    /// The particles of a patch in holes, those first that cover most of them.
    fn copies(&self, patch: &Pasted, open: &HashMap<u32, Vec<[f64; 4]>>) -> Vec<Candidate<'_>> {
        let mut found: HashMap<Particle, (f64, usize)> = HashMap::new();
        let frames = PatchFrames::new(&self.direct.asked, 0, glam::DQuat::IDENTITY);
        for (slot, t) in patch.tets.iter().enumerate() {
            let Some(open) = open.get(t) else { continue };
            let uvw = coordinates(patch, slot);
            let columns =
                columns(&frames.frame(*t as usize), &self.mesh.gradients(*t as usize), &uvw);
            if !is_straight(&columns, self.direct.free(), STRETCH, UPRIGHT) {
                continue;
            }
            for b in open {
                if let Some(p) = self.lifts.at((0..4).map(|k| uvw[k] * b[k]).sum()) {
                    found.entry(p).or_insert((0.0, slot)).0 += self.mesh.tet_volume(*t as usize);
                }
            }
        }
        let mut found: Vec<(Particle, (f64, usize))> = found.into_iter().collect();
        found.sort_by(|a, b| b.1.0.total_cmp(&a.1.0).then(a.0.cmp(&b.0)));
        (found.into_iter())
            .filter_map(|(p, (_, slot))| {
                let form = self.lifts.form(p.label).filter(|form| form.is_compact)?;
                let at = form.middle + DVec3::from_array(p.cell.map(f64::from));
                Some(Candidate { label: p.label, form, slot, at, size: DVec3::ONE })
            })
            .collect()
    }
}
