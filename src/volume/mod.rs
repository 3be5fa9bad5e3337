//! Solid textures and the masks through which they are pasted, in memory and in files.

mod file;
mod mask;
mod nrrd;
mod slices;
mod splotch;
mod texture;

pub use file::{VolumeReadError, VolumeWriteError, read, read_mask, to_nrrd, write, write_mask};
pub use mask::AlphaMask;
pub use nrrd::NrrdError;
pub use slices::SlicesError;
pub use splotch::SplotchParams;
pub use texture::{MAX_SIDE, MAX_VOXELS, SolidTexture, VolumeError, checked_voxels};
