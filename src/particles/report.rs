//! What was made of photographs, in numbers.

use serde::Serialize;

use super::measure::{components, nearest_of_profiles, nearest_on_slices};
use super::space::Space;
use super::view::View;
use crate::synthesis::{Axis, wrap_seam};
use crate::volume::SolidTexture;

/// The part of the cross-sections that should agree with others.
const AGREE: f64 = 0.5;
/// How far the part that is particles may be from the photographs', and the logarithm of nearest distances.
const FRACTION: f64 = 0.08;
const NEAREST: f64 = 0.15;

/// What was made of the photographs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ParticleReport {
    /// Particles of the volume.
    pub particles: usize,
    /// Different ones that there were to choose from.
    pub stock: usize,
    /// Triples of profiles that there could be.
    pub triples_possible: u64,
    /// How many of them were aligned.
    pub triples_aligned: usize,
    /// How many agreed.
    pub triples_kept: usize,
    /// Voxels that two particles had at placement.
    pub overlap: usize,
    /// The part of the photographs that is particles, the mean of the directions.
    pub fraction_photographs: f64,
    /// That of the volume as particles were placed.
    pub fraction_placed: f64,
    /// That of the volume in the end.
    pub fraction: f64,
    /// For slices across x, y and z, the mean distance of nearest profiles over that in the photograph, stretched as the lattice
    /// is.
    pub nearest: [Option<f64>; 3],
    /// Connected parts of what is not matrix.
    pub components: usize,
    /// The largest of them over the largest particle.
    pub largest_component: f64,
    /// The step of colour across the wrap over that inside, the largest of the axes.
    pub wrap_seam: Option<f64>,
    /// The largest step of colour between two layers inside over the mean, along the same axis.
    pub wrap_seam_inside: Option<f64>,
    /// The part of the profiles that lie on a lattice, where particles were put on one.
    pub lattice: Option<f64>,
    /// On a lattice, particles that had to be made smaller to fit.
    pub smaller: usize,
    /// By how much photographs were stretched along x, y and z so that a lattice fits the volume.
    pub stretch: [f64; 3],
    /// By how much particles are larger than their profiles: slices do not meet them in their middles.
    pub enlargement: f64,
}

impl Default for ParticleReport {
    fn default() -> Self {
        Self {
            particles: 0,
            stock: 0,
            triples_possible: 0,
            triples_aligned: 0,
            triples_kept: 0,
            overlap: 0,
            fraction_photographs: 0.0,
            fraction_placed: 0.0,
            fraction: 0.0,
            nearest: [None; 3],
            components: 0,
            largest_component: 0.0,
            wrap_seam: None,
            wrap_seam_inside: None,
            lattice: None,
            smaller: 0,
            stretch: [1.0; 3],
            enlargement: 1.0,
        }
    }
}

impl ParticleReport {
    /// Measures particles.
    pub(super) fn measure(&mut self, space: &Space, views: [Option<&View>; 3], particles: usize) {
        self.fraction = space.fraction();
        self.nearest = Axis::ALL.map(|axis| {
            let view = views[axis.index()]?;
            // As large as slices show it, not as large as particles are made.
            let scale = 0.5 * (view.scale.x + view.scale.y) / self.enlargement;
            Some(nearest_on_slices(space, axis)? / (nearest_of_profiles(&view.profiles)? * scale))
        });
        (self.components, self.largest_component) = components(space, particles);
    }

    /// How far apart profiles are on slices, over how far in the photographs: between the directions' least and most.
    pub(super) fn nearest_off(&self) -> Option<f64> {
        let all = || self.nearest.iter().flatten().copied();
        Some((all().reduce(f64::min)? * all().reduce(f64::max)?).sqrt())
    }

    /// What a person should know who looks at the volume: where it is not as the photographs are.
    #[must_use]
    pub fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        if self.particles == 0 {
            notes.push("no particle is left: use a smaller gap, or drop fewer".to_owned());
            return notes;
        }
        let kept = self.triples_kept as f64 / self.triples_aligned.max(1) as f64;
        if kept < AGREE {
            notes.push(format!(
                "of the cross-sections that were tried with each other only {:.0} % agree: do the photographs show one material, \
                 the right way round?",
                100.0 * kept
            ));
        }
        if (self.fraction - self.fraction_photographs).abs() > FRACTION {
            notes.push(format!(
                "particles fill {:.0} % of the volume, and {:.0} % of the photographs: where they are few voxels wide, a larger \
                 volume (--size) helps, or a larger photograph to work with (--photo-size)",
                100.0 * self.fraction,
                100.0 * self.fraction_photographs
            ));
        }
        if self.nearest_off().is_some_and(|off| off.ln().abs() > NEAREST) {
            let all: Vec<String> = self.nearest.iter().flatten().map(|n| format!("{n:.2}")).collect();
            notes.push(format!(
                "particles lie {} times as far apart on slices as in the photographs: --enlarge says how large they are",
                all.join(", ")
            ));
        }
        notes
    }

    /// Measures the volume's colours.
    pub(super) fn measure_colours(&mut self, texture: &SolidTexture) {
        let largest = wrap_seam(texture).into_iter().flatten().max_by(|a, b| a.step.total_cmp(&b.step));
        self.wrap_seam = largest.map(|s| s.step);
        self.wrap_seam_inside = largest.map(|s| s.inside);
    }
}
