//! Baking filled models into voxels: volumes for viewers and simulations, slices for printers that lay several materials.
//!
//! [`bake()`] writes an NRRD or NPY file or a folder of PNG slices, slab by slab in bounded memory, beside its place and
//! resumably; [`Baker`] makes any layers in memory. `docs/bake.md` is the guide.

mod baker;
mod error;
mod fingerprint;
mod grid;
mod journal;
mod mix;
mod palette;
mod params;
mod partial;
mod raster;
mod run;
mod volume_kind;

pub use baker::{Baker, Counts};
pub use error::BakeError;
pub use grid::Grid;
pub use params::{BakeParams, Dither, MAX_BAKE_SIDE, MAX_PALETTE};
pub use run::{BakeOutput, BakePlan, BakeReport, Baked, bake};
pub use volume_kind::VolumeKind;

#[cfg(test)]
mod tests;
