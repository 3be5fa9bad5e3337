//! Lapping: filling a tetrahedral mesh with overlapping patches of solid texture \[LST 5.2\].

mod agreement;
mod assemble;
mod choices;
mod clump;
mod coherent;
mod coverage;
mod feather;
mod file;
mod fill;
mod fill_error;
mod frames;
mod hide;
mod isosurface;
mod kind;
mod look;
mod look_file;
mod mapped;
mod measure;
mod optimise;
mod params;
mod parts;
mod paste;
mod pasted;
mod seed;
mod solid;
mod unfilled;
mod valid;
mod vertex;

pub use crate::field::Fields;
pub use file::{FORMAT_VERSION, METADATA_KEY, ModelFileError};
pub(crate) use fill::COARSEST;
pub use fill::{FillReport, fill};
pub use fill_error::FillError;
pub use kind::{Inputs, TextureType, UnknownType};
pub use look::{Look, LookError};
pub use measure::FillMeasures;
pub use params::{Coherent, FillParams, Rows};
pub use parts::{Joining, SolidPart, TooLarge, join};
pub use paste::{PasteError, PasteParams, PasteReport, Pasting, Places, ScatterParams, Stamp, paste};
pub use solid::{LappedSolid, Patch, Seen, interpolate};
pub use unfilled::{bare, unfilled};
pub(crate) use vertex::AtVertex;

#[cfg(test)]
mod tests;
