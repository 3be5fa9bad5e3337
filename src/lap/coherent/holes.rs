//! Holes: where the model's own coordinates show nothing.

use glam::DVec3;

use super::broken::{ByTet, broken};
use super::direct::Direct;
use super::lifts::{Lifts, Particle};
use crate::exec::{Cancelled, Exec};
use crate::lap::optimise::Given;
use crate::mesh::TetMesh;

/// Where particles are left out, or have no coordinates.
pub(in crate::lap) struct Holes<'a> {
    pub(super) mesh: &'a TetMesh,
    pub(super) given: Given<'a>,
    pub(super) direct: &'a Direct,
    pub(super) lifts: Lifts<'a>,
    pub(super) broken: ByTet,
}

impl<'a> Holes<'a> {
    /// The holes of a model that is filled with the particles that `lifts` tells apart.
    pub(in crate::lap) fn new(
        mesh: &'a TetMesh,
        given: Given<'a>,
        direct: &'a Direct,
        lifts: Lifts<'a>,
        exec: &Exec,
    ) -> Result<Self, Cancelled> {
        let _stage = exec.stage("broken particles", 0);
        let broken = broken(mesh, direct, &lifts, exec)?;
        Ok(Self { mesh, given, direct, lifts, broken })
    }

    /// 1 along axes that are solved for, 0 along those that are given.
    pub(super) fn free(&self) -> DVec3 {
        DVec3::from_array(self.direct.free().map(|free| f64::from(u8::from(free))))
    }

    /// Whether there is a hole in a tetrahedron.
    pub(in crate::lap) fn has_hole(&self, t: u32) -> bool {
        self.direct.regular(t as usize).is_none() || !self.broken[t as usize].is_empty()
    }

    /// Whether nothing is at a point by the model's own coordinates: there are none, or a particle that is left out.
    pub(super) fn is_open(&self, t: u32, b: &[f64; 4]) -> bool {
        let Some(own) = self.direct.regular(t as usize) else { return true };
        self.lifts.at((0..4).map(|k| own[k] * b[k]).sum()).is_some_and(|p| self.is_broken(t, p))
    }

    /// Whether a whole particle of the model's own coordinates shows at a point.
    pub(super) fn is_own(&self, t: u32, b: &[f64; 4]) -> bool {
        self.direct.regular(t as usize).is_some_and(|own| {
            let particle = self.lifts.at((0..4).map(|k| own[k] * b[k]).sum());
            particle.is_some_and(|p| !self.is_broken(t, p))
        })
    }

    fn is_broken(&self, t: u32, particle: Particle) -> bool {
        self.broken[t as usize].contains(&particle)
    }
}
