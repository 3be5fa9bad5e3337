//! Solid textures with the labels of their particles, and the masks through which they are pasted, in memory and in
//! files; `docs/volumes.md` says what the files hold.

mod arrays;
mod beside;
mod block;
mod choice;
mod displacement;
mod file;
mod labels;
mod mask;
pub(crate) mod npy;
mod nrrd;
mod placed;
mod sidecar;
mod slices;
mod splotch;
mod texture;

pub use arrays::ArrayError;
pub use beside::{Beside, BesideError};
pub use choice::Choice;
pub use displacement::{Displacement, MAX_HEIGHT};
pub use file::{VolumeReadError, VolumeWriteError, read, read_mask, to_files, to_nrrd, write, write_mask};
pub use mask::AlphaMask;
pub use npy::NpyError;
pub use nrrd::NrrdError;
pub use placed::{Placed, Print};
pub use sidecar::SidecarError;
pub use slices::SlicesError;
pub use splotch::SplotchParams;
pub use texture::{MAX_SIDE, MAX_VOXELS, Particles, SolidTexture, VolumeError, checked_voxels};
