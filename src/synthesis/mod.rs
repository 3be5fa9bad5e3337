//! Solid textures from photographs \[CW\].
//!
//! A volume is made whose slices look like a photograph, in one direction or in all. It is found from coarse to fine
//! by texture optimisation: in turn, each voxel's neighbourhoods in the slices through it are matched with the
//! photograph's (`search`), and each voxel becomes the pixel that the neighbourhoods around it agree on best
//! (`optimise`). Colours are copies of pixels, never blends, and how often each pixel and each neighbourhood serves is
//! held level by histograms, so that all of the photograph comes to appear in the volume.
//!
//! | file | noun |
//! |---|---|
//! | `exemplar`, `plate`, `distance` | photographs at working size, their pyramid, what steers them |
//! | `atlas`, `windows`, `basis`, `similar` | a level's pixels and neighbourhoods, described and compared |
//! | `lattice`, `grid`, `level` | a level's voxels, which neighbourhoods a pass looks at, what is known of them |
//! | `histogram`, `passes`, `search`, `optimise` | the two phases, in fixed pieces |
//! | `run`, `fill_in` | from coarse to fine; voxels between others that are given |

mod atlas;
mod axes;
mod basis;
mod distance;
mod exemplar;
mod fill_in;
mod grid;
mod histogram;
mod lattice;
mod level;
mod measure;
mod optimise;
mod params;
mod passes;
mod plate;
mod result;
mod run;
mod search;
mod similar;
#[cfg(test)]
mod tests;
mod windows;

pub use axes::{Axes, Axis};
pub use exemplar::{Exemplar, Exemplars, Feature, working_photograph};
pub use fill_in::fill_in;
pub use measure::{WrapSeam, wrap_seam};
pub use params::{Size, SynthesisParams};
pub use result::{LevelView, Synthesis, SynthesisReport};
pub use run::synthesise;

use crate::exec::Cancelled;
use crate::volume::VolumeError;

/// Why no volume can be made. Photographs are counted from 0 here, from 1 in messages.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SynthesisError {
    /// No slices are to look like anything.
    #[error("no photograph is given for any slice; give at least one")]
    NoPhotograph,
    /// A direction names a photograph that is not there, or a photograph is named by none.
    #[error("photograph {} is for no slices, or is not there; each of at most three must be for slices perpendicular to x, y or z", .photo + 1)]
    Unused {
        /// Which.
        photo: usize,
    },
    /// A setting out of its range.
    #[error("{key} is {value}; it must be {range}")]
    Setting {
        /// Which.
        key: &'static str,
        /// Its value.
        value: f64,
        /// What it may be.
        range: &'static str,
    },
    /// A photograph for slices that do not show depth, in a texture that varies with depth.
    #[error(
        "slices perpendicular to {axis} lie at one depth each, so that no photograph can serve all of them; give photographs that show the depth {axis}, for the other two directions"
    )]
    AcrossDepth {
        /// The depth.
        axis: Axis,
    },
    /// Photographs whose depth runs to the right for one direction and down for another.
    #[error(
        "photograph {} cannot serve two directions: the depth {axis} runs down in one and to the right in the other; give a photograph for each",
        .photo + 1
    )]
    TwoDepths {
        /// Which.
        photo: usize,
        /// The depth.
        axis: Axis,
    },
    /// A volume that tiles along its depth.
    #[error(
        "the texture varies along {axis}, so that it cannot tile along it; leave {axis} out of the axes that tile"
    )]
    TilingDepth {
        /// The depth.
        axis: Axis,
    },
    /// A photograph that is too small, or too transparent, to be compared with.
    #[error(
        "photograph {} has {}×{} pixels here and only {windows} whole neighbourhoods of {width}×{width} opaque ones; at least {needed} are needed: give a larger photograph, or one with less that is transparent, ask for a larger volume or photo size, or for fewer levels",
        .photo + 1, .size[0], .size[1]
    )]
    PhotoTooSmall {
        /// Which.
        photo: usize,
        /// Width and height in pixels, at the size that is worked with.
        size: [u32; 2],
        /// Neighbourhoods that it has.
        windows: usize,
        /// Their width in pixels.
        width: usize,
        /// How many there should be.
        needed: usize,
    },
    /// A depth at which a photograph has nothing to copy.
    #[error(
        "photograph {} has no whole opaque neighbourhood at depth {row} of {rows} (± the tolerance); fill in what is transparent there, or raise the tolerance",
        .photo + 1
    )]
    EmptyDepth {
        /// Which.
        photo: usize,
        /// The row.
        row: usize,
        /// Of so many.
        rows: usize,
    },
    /// A photograph that is too long for its depth.
    #[error("photograph {} would be {}×{} pixels large beside this volume; cut a shorter piece out of it, or ask for a smaller volume", .photo + 1, .size[0], .size[1])]
    PhotoTooLarge {
        /// Which.
        photo: usize,
        /// Width and height in pixels.
        size: [u32; 2],
    },
    /// A volume with a side that holds no neighbourhood.
    #[error("a volume of {}×{}×{} voxels has too few along {axis}, where it does not tile: at least {needed} are needed", .size[0], .size[1], .size[2])]
    VolumeTooSmall {
        /// Its size.
        size: [u32; 3],
        /// The short side.
        axis: Axis,
        /// The least number of voxels.
        needed: usize,
    },
    /// A map of another size than its photograph.
    #[error("the {what} of photograph {} has {}×{} pixels, the photograph {}×{}; they must be of one size", .photo + 1, .found[0], .found[1], .expected[0], .expected[1])]
    OtherSize {
        /// What it is for.
        what: &'static str,
        /// Whose it is.
        photo: usize,
        /// Its width and height.
        found: [u32; 2],
        /// The photograph's.
        expected: [u32; 2],
    },
    /// A mask without an outline.
    #[error("the mask of photograph {} is black or white all over at working size: it must be white on some parts only", .photo + 1)]
    OneSidedMask {
        /// Whose it is.
        photo: usize,
    },
    /// A target map that is black.
    #[error("the target map of photograph {} is black: it wants no pixel at all", .photo + 1)]
    NothingWanted {
        /// Whose it is.
        photo: usize,
    },
    /// No such volume.
    #[error(transparent)]
    Volume(#[from] VolumeError),
    /// The run was asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
