//! Solid textures and the masks through which they are pasted.

mod mask;
mod splotch;
mod texture;

pub use mask::AlphaMask;
pub use splotch::SplotchParams;
pub use texture::{MAX_SIDE, MAX_VOXELS, SolidTexture, VolumeError, checked_voxels};
