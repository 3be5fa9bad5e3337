//! Solid textures and the masks through which they are pasted.

mod mask;
mod texture;

pub use mask::AlphaMask;
pub use texture::{MAX_SIDE, MAX_VOXELS, SolidTexture, VolumeError, checked_voxels};
