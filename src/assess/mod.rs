//! How near a solid texture comes to the photographs that it was made from.
//!
//! The measures are those that `docs/assess.md` explains: the whitened sliced Wasserstein distance of patches on slices
//! beside its floor and its controls, colour distance, gradient ratio, wrap seam, and what share of the colours are
//! copies. Entropy and coverage of the position histogram need to know where each voxel was copied from:
//! [`position_histogram`].

mod compare;
mod patches;
mod plate;
mod simple;
mod sliced;
mod slices;
mod source;

use clap::Args;
use serde::{Deserialize, Serialize};

use crate::exec::{Cancelled, Exec};
use crate::photo::Photograph;
use crate::solve::SolveError;
use crate::synthesis::{Axis, Size, SynthesisParams, working_photograph};
use crate::volume::SolidTexture;

pub use simple::position_histogram;
pub use source::{SourceError, read_source};

/// The most levels of the pyramid: the pictures themselves, at half and at quarter size.
pub const LEVELS: usize = 3;

/// What cannot be compared.
#[derive(Debug, thiserror::Error)]
pub enum AssessError {
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// A setting out of its range.
    #[error("{name} = {value}: it must be {range}")]
    Setting {
        /// The setting.
        name: &'static str,
        /// Its value.
        value: u32,
        /// What it must be.
        range: &'static str,
    },
    /// No photograph at all.
    #[error("there is no photograph to compare the volume with; give one")]
    NoPhotograph,
    /// A photograph without room for patches.
    #[error(
        "the photograph perpendicular to {axis} has {}×{} pixels; at least 7×14 opaque ones are needed: two halves that hold \
         patches of 7×7", .size[0], .size[1]
    )]
    SmallPhotograph {
        /// `x`, `y` or `z`.
        axis: char,
        /// Its width and height.
        size: [u32; 2],
    },
    /// A volume without room for patches.
    #[error("the volume has {}×{}×{} voxels; at least 7 along each axis are needed for patches of 7×7", .0[0], .0[1], .0[2])]
    SmallVolume([u32; 3]),
    /// Patches that have no principal axes.
    #[error("the principal axes of the photograph's patches cannot be found")]
    Solve(#[from] SolveError),
}

/// How a volume is assessed.
#[derive(Debug, Clone, PartialEq, Args, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct AssessParams {
    /// Patches in each set that is compared, 256 to 262144: more make distances more certain, and all of them smaller
    #[arg(long, value_name = "N", default_value_t = Self::default().samples)]
    pub samples: u32,
    /// The longer side of the photographs in pixels, as given to `lapis synthesise`; larger ones are made smaller
    /// [default: the longest side of the volume]
    #[arg(long, value_name = "PIXELS", conflicts_with = "varying")]
    pub photo_size: Option<u32>,
    /// The axis that is depth, as given to `lapis synthesise`: the photographs' depth is made as many pixels long as the
    /// volume's
    #[arg(long, value_name = "AXIS")]
    pub varying: Option<Axis>,
}

impl AssessParams {
    /// A photograph of slices perpendicular to `axis`, at the size with which a volume of this size is compared: that which
    /// it was synthesised with.
    #[must_use]
    pub fn working(&self, photo: &Photograph, axis: Axis, volume: [u32; 3]) -> Photograph {
        let params = SynthesisParams {
            size: Size(volume),
            varying: self.varying,
            photo_size: self.photo_size,
            ..SynthesisParams::default()
        };
        working_photograph(photo, axis, &params)
    }
}

impl Default for AssessParams {
    fn default() -> Self {
        Self { samples: 8192, photo_size: None, varying: None }
    }
}

/// One number for each level, finest first, for each direction of slices.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Directions {
    /// Slices perpendicular to x; none where no photograph says how they should look.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub x: Option<Vec<f64>>,
    /// Slices perpendicular to y.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub y: Option<Vec<f64>>,
    /// Slices perpendicular to z.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub z: Option<Vec<f64>>,
    /// Oblique slices, against the photograph that they are nearest to.
    pub oblique: Vec<f64>,
}

/// What the distance is for volumes that are known to be bad, on the mean over all directions that have a photograph:
/// one number for each level, finest first.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Controls {
    /// Every voxel a pixel of the photograph, drawn independently: the right colours, no structure.
    pub independent_pixels: Vec<f64>,
    /// A photograph drawn out along its axis: right in one direction, stripes in the others.
    pub extruded: Vec<f64>,
    /// The volume itself, blurred over 3×3×3 voxels.
    pub blurred: Vec<f64>,
}

/// A number for each axis that has one.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct PerAxis {
    /// Along x, or on slices perpendicular to it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub x: Option<f64>,
    /// The same of y.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub y: Option<f64>,
    /// The same of z.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub z: Option<f64>,
}

impl PerAxis {
    fn new([x, y, z]: [Option<f64>; 3]) -> Self {
        Self { x, y, z }
    }
}

/// How near a volume is to its photographs; `docs/assess.md` says how to read it.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Assessment {
    /// Whitened sliced Wasserstein distance of 7×7 patches between slices and photographs; 0 is perfect.
    pub whitened_distance: Directions,
    /// The same between one half of each photograph and the other, of the two ways to halve it the one whose halves are
    /// more alike: nearer one cannot expect to come.
    pub floor: Directions,
    /// Distance over floor.
    pub ratio: Directions,
    /// What bad volumes have.
    pub controls: Controls,
    /// Sliced Wasserstein distance between the volume's and the photographs' colours, in Oklab; 0 is perfect, 0.02 is
    /// just seen.
    pub colour_distance: f64,
    /// Mean gradient on slices over that of the photograph; below 1 is blur, above it noise.
    pub gradient_ratio: PerAxis,
    /// Mean step of colour over the seam of a tiling axis over that inside; 1 is perfect.
    pub wrap_seam: PerAxis,
    /// The part of the voxels whose colour a photograph has.
    pub copied: f64,
}

/// Assesses a volume by the photographs of its slices: `photos` are those of slices perpendicular to x, y and z, of
/// which some may be missing; one photograph may serve several directions. Results depend on `seed` a little, by the
/// patches that are drawn.
///
/// # Errors
/// [`AssessError`] says what is too small to be compared.
pub fn assess(
    texture: &SolidTexture,
    photos: [Option<&Photograph>; 3],
    params: &AssessParams,
    seed: u64,
    exec: &Exec,
) -> Result<Assessment, AssessError> {
    exec.install(|| compare::all(texture, photos, params, seed, exec))
}

#[cfg(test)]
mod tests;
