//! Particles of patches that fit into holes, made smaller where they must be.

use std::collections::{BTreeMap, HashMap};

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::direct::Direct;
use super::lifts::{Lifts, Particle};
use super::whole::{ByTet, coordinates, layer, near};
use crate::exec::{Cancelled, Exec};
use crate::lap::coverage::{LATTICE, ORDER};
use crate::lap::pasted::Pasted;
use crate::mesh::{NONE, TET_FACES, TetMesh};

/// By how much particles are made smaller along an axis to fit a hole: as a mason cuts bricks to size.
const SIZES: [f64; 4] = [1.0, 0.8, 0.6, 0.4];
/// The least part of a particle's volume that is left.
const SMALLEST: f64 = 0.15;
/// A barycentric coordinate above this is inside.
const INSIDE: f64 = -1e-9;

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

/// What is there when particles of patches are looked at.
pub(super) struct Holes<'a> {
    pub(super) mesh: &'a TetMesh,
    pub(super) direct: &'a Direct,
    pub(super) lifts: &'a Lifts<'a>,
    pub(super) broken: &'a ByTet,
    /// Particles of patches that are in already: by tetrahedron where their textures are read, and which they are.
    pub(super) taken: HashMap<u32, Vec<Taken>>,
}

/// A particle of a patch that is in, in a tetrahedron.
pub(super) struct Taken {
    particle: Particle,
    /// Where its texture is read at the corners.
    uvw: [DVec3; 4],
    middle: DVec3,
    reach: DVec3,
}

/// A patch as texture space sees it.
pub(super) struct Sheet<'a> {
    patch: &'a Pasted,
    /// Of each tetrahedron the place of corner 0, and the matrix that takes a place beside it to the other barycentric
    /// coordinates.
    inverse: Vec<(DVec3, DMat3)>,
    /// Of each tetrahedron those across its faces, where the patch goes on there without a slit.
    beside: Vec<[Option<usize>; 4]>,
}

/// A particle that is to be put into a hole: made smaller about its middle.
#[derive(Clone, Copy)]
struct Candidate {
    particle: Particle,
    /// A tetrahedron of the patch in which it lies at full size, and where.
    slot: usize,
    middle: DVec3,
    /// How far it reaches from there along the axes of the texture.
    reach: DVec3,
    size: DVec3,
}

/// Whole particles of patches, in holes that have room for them: their labels, and each as a patch of its own.
pub(super) fn fitting(
    holes: &mut Holes<'_>,
    patches: &[Pasted],
    everywhere: u32,
    exec: &Exec,
) -> Result<Vec<(u32, Pasted)>, Cancelled> {
    let sizes = sizes(holes.direct.free());
    let mut found = Vec::new();
    for patch in patches {
        exec.check()?;
        let sheet = Sheet::new(holes.mesh, patch);
        // Those that fit by themselves are found side by side; one after the other they then keep clear of each other.
        let core =
            DVec3::select(glam::BVec3::from_array(holes.direct.free()), DVec3::splat(SIZES[3]), DVec3::ONE);
        let first = |c: &Candidate| {
            // What lies in all sizes must have room first.
            holes.has_room(&sheet, Candidate { size: core, ..*c })?;
            (0..sizes.len()).find(|&n| holes.has_room(&sheet, Candidate { size: sizes[n], ..*c }).is_some())
        };
        let candidates: Vec<(Candidate, usize)> =
            holes.candidates(patch).into_par_iter().filter_map(|c| Some((c, first(&c)?))).collect();
        for (candidate, first) in candidates {
            let room = sizes[first..].iter().find_map(|&size| {
                let candidate = Candidate { size, ..candidate };
                Some((candidate, holes.has_room(&sheet, candidate)?))
            });
            let Some((candidate, slots)) = room else { continue };
            let uvw: Vec<[DVec3; 4]> = slots.iter().map(|&s| candidate.coordinates(patch, s)).collect();
            let tets: Vec<u32> = slots.iter().map(|&s| patch.tets[s]).collect();
            for (t, uvw) in tets.iter().zip(&uvw) {
                let Candidate { particle, middle, reach, .. } = candidate;
                holes.taken.entry(*t).or_default().push(Taken { particle, uvw: *uvw, middle, reach });
            }
            let pasted = layer(tets, uvw.into_iter().map(near).collect(), everywhere);
            found.push((candidate.particle.label, pasted));
        }
    }
    Ok(found)
}

impl Candidate {
    /// Where its texture is read at the corners of the patch's tetrahedron number `slot`.
    fn coordinates(&self, patch: &Pasted, slot: usize) -> [DVec3; 4] {
        coordinates(patch, slot).map(|w| self.middle + (w - self.middle) / self.size)
    }

    /// Whether a tetrahedron with these coordinates may reach into it.
    fn comes_near(&self, uvw: &[DVec3; 4]) -> bool {
        let low = uvw.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let high = uvw.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        (low.cmple(self.middle + self.reach) & high.cmpge(self.middle - self.reach)).all()
    }
}

impl<'a> Sheet<'a> {
    pub(super) fn new(mesh: &TetMesh, patch: &'a Pasted) -> Self {
        let slots: HashMap<u32, usize> = patch.tets.iter().enumerate().map(|(slot, t)| (*t, slot)).collect();
        let beside = (0..patch.tets.len())
            .map(|slot| {
                std::array::from_fn(|k| {
                    let t = patch.tets[slot] as usize;
                    let n = mesh.neighbours[t][k];
                    let other = *slots.get(&n)?;
                    let joined = TET_FACES[k].iter().all(|&i| {
                        let j = mesh.tets[n as usize].iter().position(|w| *w == mesh.tets[t][i]);
                        j.is_some_and(|j| patch.uvw[other][j] == patch.uvw[slot][i])
                    });
                    joined.then_some(other)
                })
            })
            .collect();
        let inverse = (0..patch.tets.len())
            .map(|slot| {
                let [a, b, c, d] = coordinates(patch, slot);
                (a, DMat3::from_cols(b - a, c - a, d - a).inverse())
            })
            .collect();
        Self { patch, inverse, beside }
    }

    fn barycentric(&self, slot: usize, place: DVec3) -> [f64; 4] {
        let (origin, inverse) = self.inverse[slot];
        let b = inverse * (place - origin);
        [1.0 - b.x - b.y - b.z, b.x, b.y, b.z]
    }

    /// Goes from a tetrahedron to the one in which a place of texture space lies. `Ok(None)` where the way leads out of
    /// the model.
    ///
    /// # Errors
    /// Where it leads to the patch's end.
    pub(super) fn walk(
        &self,
        mesh: &TetMesh,
        mut slot: usize,
        place: DVec3,
    ) -> Result<Option<(usize, [f64; 4])>, ()> {
        for _ in 0..self.inverse.len().min(200) {
            let b = self.barycentric(slot, place);
            let k = (0..4).fold(0, |least, k| if b[k] < b[least] { k } else { least });
            if b[k] >= INSIDE {
                return Ok(Some((slot, b)));
            }
            if mesh.neighbours[self.patch.tets[slot] as usize][k] == NONE {
                return Ok(None);
            }
            slot = self.beside[slot][k].ok_or(())?;
        }
        Err(())
    }
}

impl Holes<'_> {
    /// Whether there is nothing yet at a point: no coordinates, or a particle that is left out.
    fn is_open(&self, t: u32, b: &[f64; 4]) -> bool {
        self.direct.regular(t as usize).is_none() || self.own(t, b).is_some_and(|p| self.is_broken(t, p))
    }

    /// The particle of the model's own coordinates at a point.
    fn own(&self, t: u32, b: &[f64; 4]) -> Option<Particle> {
        self.direct.regular(t as usize).and_then(|own| self.lifts.at((0..4).map(|k| own[k] * b[k]).sum()))
    }

    fn is_broken(&self, t: u32, particle: Particle) -> bool {
        self.broken.get(&t).is_some_and(|all| all.contains(&particle))
    }

    /// The particles of a patch in holes, those first that cover most of them.
    fn candidates(&self, patch: &Pasted) -> Vec<Candidate> {
        let mut found: BTreeMap<Particle, (f64, usize)> = BTreeMap::new();
        let points = LATTICE.map(|b| b.map(|e| f64::from(e) / ORDER as f64));
        for (slot, &t) in patch.tets.iter().enumerate() {
            if self.direct.regular(t as usize).is_some() && !self.broken.contains_key(&t) {
                continue;
            }
            let uvw = coordinates(patch, slot);
            for b in points.iter().filter(|b| self.is_open(t, b)) {
                if let Some(p) = self.lifts.at((0..4).map(|k| uvw[k] * b[k]).sum()) {
                    found.entry(p).or_insert((0.0, slot)).0 += self.mesh.tet_volume(t as usize);
                }
            }
        }
        let mut found: Vec<(Particle, (f64, usize))> = found.into_iter().collect();
        found.sort_by(|a, b| b.1.0.total_cmp(&a.1.0).then(a.0.cmp(&b.0)));
        (found.into_iter())
            .filter_map(|(particle, (_, slot))| {
                let form = self.lifts.form(particle)?;
                let middle = form.middle + cell(particle);
                Some(Candidate { particle, slot, middle, reach: form.reach, size: DVec3::ONE })
            })
            .collect()
    }

    /// The tetrahedra of a patch over which a particle lies. `None` where it reaches the patch's end, lies over a particle
    /// that stays (a whole one of the model's own coordinates, or one that is taken), or is nowhere.
    fn has_room(&self, sheet: &Sheet<'_>, of: Candidate) -> Option<Vec<usize>> {
        let form = self.lifts.form(of.particle)?;
        let mut slot = of.slot;
        let mut slots = Vec::new();
        for point in &form.points {
            let place = of.middle + (*point + cell(of.particle) - of.middle) * of.size;
            let Some((at, b)) = sheet.walk(self.mesh, slot, place).ok()? else { continue };
            slot = at;
            let t = sheet.patch.tets[slot];
            if self.own(t, &b).is_some_and(|p| !self.is_broken(t, p)) || self.is_taken(t, &b) {
                return None;
            }
            if !slots.contains(&slot) {
                slots.push(slot);
            }
        }
        // Corners of tetrahedra may reach in between the points.
        for n in 0..slots.len() {
            for k in 0..4 {
                if let Some(other) = sheet.beside[slots[n]][k]
                    && !slots.contains(&other)
                    && of.comes_near(&of.coordinates(sheet.patch, other))
                {
                    slots.push(other);
                }
            }
        }
        // Labels tell what is drawn: no other copy may be.
        let alone = slots.iter().all(|&slot| {
            let uvw = of.coordinates(sheet.patch, slot);
            // The next copy is a period away.
            let near = |w: &DVec3| (*w - of.middle).abs().cmplt(DVec3::ONE - of.reach).all();
            uvw.iter().all(near)
                || LATTICE.iter().all(|b| {
                    let here = self.lifts.at((0..4).map(|k| uvw[k] * f64::from(b[k]) / ORDER as f64).sum());
                    here.is_none_or(|p| p.label != of.particle.label || p == of.particle)
                })
        });
        (alone && !slots.is_empty()).then_some(slots)
    }

    fn is_taken(&self, t: u32, b: &[f64; 4]) -> bool {
        let is_there = |other: &Taken| {
            let place: DVec3 = (0..4).map(|k| other.uvw[k] * b[k]).sum();
            (place - other.middle).abs().cmple(other.reach).all()
                && self.lifts.at(place) == Some(other.particle)
        };
        self.taken.get(&t).is_some_and(|taken| taken.iter().any(is_there))
    }
}

/// The periods of a particle's cell.
fn cell(particle: Particle) -> DVec3 {
    DVec3::from_array(particle.cell.map(f64::from))
}
