//! What is seen of particles in three directions.

use glam::{DVec2, DVec3};

use super::ParticleError;
use super::profile::Profiles;
use super::regular::{Rows, rows};
use super::sites::{Courses, Misfit};
use super::view::View;
use super::volume_params::Order;
use crate::exec::{Cancelled, Exec};
use crate::photo::Photograph;
use crate::synthesis::Axis;

/// A view for each axis that has a photograph, and the lattice of each that has one.
#[derive(Debug, Clone)]
pub(super) struct Seen {
    views: [Option<View>; 3],
    rows: [Option<Rows>; 3],
}

impl Seen {
    /// `working` are the photographs at working size. The lattices are found once for each photograph.
    pub(super) fn new(
        photos: &[(&Photograph, &Profiles)],
        directions: [Option<usize>; 3],
        working: &[Photograph],
        exec: &Exec,
    ) -> Result<Self, Cancelled> {
        let first = |photo: usize| working[..photo].iter().map(|p| p.pixels().len() as u32).sum();
        let view = |photo: usize| View::new(photos[photo].1.clone(), working[photo].clone(), first(photo));
        let views = directions.map(|d| d.map(view));
        let of_photo: Vec<Option<Rows>> = (0..working.len())
            .map(|n| rows(views[directions.iter().position(|d| *d == Some(n))?].as_ref()?, exec))
            .collect();
        let rows = directions.map(|d| of_photo[d?].clone());
        exec.check()?;
        Ok(Self { views, rows })
    }

    /// How wide profiles are on the mean, in voxels, in the direction where they are narrowest.
    pub(super) fn width(&self) -> f64 {
        let width = |view: &&View| {
            let area: usize = view.profiles.all.iter().map(|p| p.area).sum();
            (area as f64 / view.profiles.all.len() as f64 * view.scale.element_product()).sqrt()
        };
        self.views().iter().flatten().map(width).fold(f64::INFINITY, f64::min)
    }

    pub(super) fn views(&self) -> [Option<&View>; 3] {
        self.views.each_ref().map(Option::as_ref)
    }

    pub(super) fn rows(&self) -> [Option<&Rows>; 3] {
        self.rows.each_ref().map(Option::as_ref)
    }

    /// Views whose voxels to a pixel are more by a factor, along each axis.
    pub(super) fn stretched(mut self, by: DVec3) -> Self {
        for (view, axis) in self.views.iter_mut().zip(Axis::ALL) {
            if let Some(view) = view {
                view.scale *= DVec2::new(by[axis.right().index()], by[axis.down().index()]);
            }
        }
        self
    }

    /// The part of the photographs that is particles, the mean of the directions.
    pub(super) fn fraction(&self) -> f64 {
        let all: Vec<f64> = self.views().iter().flatten().map(|v| v.profiles.area_fraction()).collect();
        all.iter().sum::<f64>() / all.len() as f64
    }

    /// The lattice that particles are to be put on.
    pub(super) fn courses(&self, order: Order, extent: DVec3) -> Result<Option<Courses>, ParticleError> {
        let found = match order {
            Order::Auto | Order::Lattice => Courses::new(self.views(), self.rows(), extent),
            Order::Isotropic | Order::Layered(_) => return Ok(None),
        };
        match (found, order) {
            (Ok(courses), _) => Ok(Some(courses)),
            (Err(Misfit::None(axis)), Order::Lattice) => {
                Err(ParticleError::NoLattice { axis: Axis::ALL[axis] })
            }
            (Err(Misfit::Heights(x, z)), Order::Lattice) => Err(ParticleError::Courses { x, z }),
            (Err(Misfit::Levels), Order::Lattice) => Err(ParticleError::Levels),
            (Err(_), _) => Ok(None),
        }
    }
}
