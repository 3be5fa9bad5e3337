//! Lapping: filling a tetrahedral mesh with overlapping patches of solid texture \[LST 5.2\].

mod assemble;
mod clump;
mod coverage;
mod feather;
mod file;
mod fill;
mod frames;
mod hide;
mod kind;
mod mapped;
mod measure;
mod optimise;
mod params;
mod seed;
mod solid;

pub use file::{FORMAT_VERSION, METADATA_KEY, ModelFileError};
pub use fill::{Fields, FillError, FillReport, fill};
pub use kind::{Inputs, TextureType, UnknownType};
pub use measure::FillMeasures;
pub use params::FillParams;
pub use solid::{LappedSolid, Patch, interpolate};

#[cfg(test)]
mod tests;
