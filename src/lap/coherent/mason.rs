//! Putting particles where there is room, in the largest size that fits.

use glam::{BVec3, DVec3};

use super::chart::Chart;
use super::form::{FIRST, Form};
use super::holes::Holes;
use super::lifts::Particle;
use super::whole::layer;
use crate::lap::coverage::{LATTICE, ORDER};
use crate::lap::optimise::INSIDE;
use crate::lap::pasted::Pasted;
use crate::mesh::NONE;

/// By how much particles are made smaller along an axis to fit a hole.
const SIZES: [f64; 5] = [1.0, 0.8, 0.6, 0.45, 0.3];
/// The least part of a particle's volume that is left.
const SMALLEST: f64 = 0.04;
/// The least part of the volume of one that belongs to a patch: straight ones are better to look at than bent small ones.
const WORTH: f64 = 0.5;
/// Steps with which is looked how much room there is, in voxels.
const STEP: f64 = 2.0;
/// Joints are at most this part of a particle's reach.
const JOINT: f64 = 0.3;

/// A particle that has a place.
pub(super) struct Placed {
    pub(super) label: u32,
    /// A patch of one period about it.
    pub(super) pasted: Pasted,
}

/// A particle that is looked at: which, and where.
#[derive(Clone, Copy)]
pub(super) struct Candidate<'a> {
    pub(super) label: u32,
    pub(super) form: &'a Form,
    /// A tetrahedron of the patch into which it reaches.
    pub(super) slot: usize,
    /// Where its middle lies in the patch.
    pub(super) at: DVec3,
    /// How large it is along the axes, 1 as in the texture.
    pub(super) size: DVec3,
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

/// Who puts particles in.
pub(super) struct Mason<'a> {
    pub(super) holes: &'a Holes<'a>,
    sizes: Vec<DVec3>,
    /// Half a joint, along each axis.
    joint: DVec3,
    everywhere: u32,
    /// What is in already, by tetrahedron, oldest first.
    full: Vec<Vec<Taken>>,
    pub(super) placed: Vec<Placed>,
}

impl<'a> Mason<'a> {
    pub(super) fn new(holes: &'a Holes<'a>, everywhere: u32) -> Self {
        Self {
            holes,
            sizes: sizes(holes.direct.free()),
            joint: 0.5 * holes.lifts.joint() * holes.free(),
            everywhere,
            full: holes.mesh.tets.iter().map(|_| Vec::new()).collect(),
            placed: Vec::new(),
        }
    }

    /// The number of the largest size for which there is room. `of` is the patch to which it belongs.
    pub(super) fn first(&self, chart: &impl Chart, of: Option<usize>, c: &Candidate<'_>) -> Option<usize> {
        self.fits(chart, of, c, 0, 0)
    }

    /// Puts a particle in, in the largest size from a first one on for which there is room; for that one there was, when
    /// `before` were in.
    pub(super) fn put(
        &mut self,
        chart: &impl Chart,
        of: Option<usize>,
        c: &Candidate<'_>,
        first: usize,
        before: usize,
    ) {
        if let Some(n) = self.fits(chart, of, c, first, before) {
            self.add(chart, of, &Candidate { size: self.sizes[n], ..at_middle(chart, *c) });
        }
    }

    /// The number of the largest size for which there is room, from a first one on, for which there was when `before` were in.
    fn fits(
        &self,
        chart: &impl Chart,
        of: Option<usize>,
        c: &Candidate<'_>,
        first: usize,
        before: usize,
    ) -> Option<usize> {
        let c = at_middle(chart, *c);
        let mut last = 0;
        let fits = |n: usize, since: usize, last: &mut usize| {
            let c = Candidate { size: self.sizes[n], ..c };
            self.has_room(chart, of, &c, since, last) && self.is_clear(chart, of, &c, since)
        };
        if fits(first, before, &mut last) {
            return Some(first);
        }
        // What lies in all other sizes, of most particles, must have room then.
        let core = DVec3::select(self.free_axes(), DVec3::splat(SIZES[SIZES.len() - 1]), DVec3::ONE);
        if !self.has_room(chart, of, &Candidate { size: core, ..c }, before, &mut last) {
            return None;
        }
        let least = if of.is_some() { WORTH } else { 0.0 };
        let mut sizes =
            (first + 1..self.sizes.len()).take_while(|&n| self.sizes[n].element_product() >= least);
        sizes.find(|&n| fits(n, 0, &mut last))
    }

    pub(super) fn free_axes(&self) -> BVec3 {
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
        let free = self.free_axes();
        let mut slot = c.slot;
        let mut is_free = |point: usize| {
            let place = c.at + (c.form.points[point] - c.form.middle) * size;
            // What is given ends with the model.
            let inside = place.clamp(DVec3::ZERO, DVec3::splat(f64::from(INSIDE)));
            let place = DVec3::select(free, place, inside);
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

    /// Whether a particle lies over nothing that stays in any of the tetrahedra in which it will be drawn, and shows at no
    /// face where the coordinates end, as far as a lattice of points in each shows. What has room has this, but for what is
    /// thinner than its points are apart, and for tetrahedra to which no straight way leads from its middle.
    fn is_clear(&self, chart: &impl Chart, of: Option<usize>, c: &Candidate<'_>, since: usize) -> bool {
        let of = of.filter(|_| c.size == DVec3::ONE);
        let reach = self.reach(c.form);
        let this = Particle { label: c.label, cell: [0; 3] };
        let under = chart.under(c.slot, c.at, reach * c.size);
        under.iter().any(|&slot| chart.meets(slot, c.at, reach * c.size))
            && under.into_iter().all(|slot| {
                let (t, uvw) = (chart.tet(slot), chart.coordinates(slot).map(|w| (w - c.at) / c.size));
                // Beyond such a face the coordinates are others.
                let ends: [bool; 4] = std::array::from_fn(|k| {
                    chart.mesh().neighbours[t as usize][k] != NONE && chart.beside(slot, k).is_none()
                });
                LATTICE.iter().map(|b| b.map(|e| f64::from(e) / ORDER as f64)).all(|b| {
                    let beside: DVec3 = (0..4).map(|k| uvw[k] * b[k]).sum();
                    let shows = beside.abs().cmple(reach).all()
                        && self.holes.lifts.any_near(c.form.middle + beside, |p| p == this);
                    let goes_on = (0..4).all(|k| !ends[k] || b[k] > 0.0);
                    !shows
                        || goes_on
                            && (since > 0 || !self.holes.is_own(t, &b))
                            && !self.is_full(t, &b, of, since)
                })
            })
    }

    /// How far something of a particle shows from its middle.
    fn reach(&self, form: &Form) -> DVec3 {
        form.reach + 0.5 / self.holes.lifts.size()
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
    pub(super) fn centred<'c>(&self, chart: &impl Chart, mut c: Candidate<'c>) -> Candidate<'c> {
        for axis in (0..3).filter(|&axis| self.holes.direct.free()[axis]) {
            let step = DVec3::AXES[axis] * STEP / self.holes.lifts.size();
            let reach = c.form.reach[axis];
            let far = ((reach + self.joint[axis].min(JOINT * reach)) / step[axis]).ceil() as usize;
            let room = [step, -step].map(|step| {
                let mut slot = c.slot;
                (1..=far)
                    .find(|&n| !self.is_free(chart, &mut slot, c.at + step * n as f64, None, 0))
                    .unwrap_or(far)
            });
            let at = c.at + step * 0.5 * (room[0] as f64 - room[1] as f64);
            if let Ok(Some((slot, _))) = chart.walk(c.slot, at) {
                (c.slot, c.at) = (slot, at);
            }
        }
        c
    }

    /// Whether one that is in lies at a point, which is not of the same patch and came after as many others.
    pub(super) fn is_full(&self, t: u32, b: &[f64; 4], of: Option<usize>, since: usize) -> bool {
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
        // The texture is read one period about the particle, so that no other copy of it is seen.
        let shift = (c.form.middle - 0.5) * free;
        let mut pasted = layer(Vec::new(), Vec::new(), self.everywhere + 1);
        pasted.shift = shift.as_vec3().to_array();
        for slot in chart.under(c.slot, c.at, self.reach(c.form) * c.size) {
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
}

/// A candidate in the tetrahedron in which its middle lies, if there is one: that one is under it in all sizes.
fn at_middle<'a>(chart: &impl Chart, c: Candidate<'a>) -> Candidate<'a> {
    match chart.walk(c.slot, c.at) {
        Ok(Some((slot, _))) => Candidate { slot, ..c },
        _ => c,
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_fall_and_keep_to_what_is_given() {
        let all = sizes([true, false, true]);
        assert_eq!(all[0], DVec3::ONE);
        assert!(all.iter().all(|size| size.y == 1.0 && size.element_product() >= SMALLEST));
        assert!(all.is_sorted_by(|a, b| a.element_product() >= b.element_product()));
        assert_eq!(all.len(), SIZES.len() * SIZES.len());
        assert!(sizes([true; 3]).len() > all.len());
    }
}
