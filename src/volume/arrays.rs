//! Volumes as arrays of NumPy: bytes `[z, y, x, 4]`, masks `[z, y, x]`.
//!
//! Read besides: `[z, y, x]` (grey), and 1 (grey), 2 (grey, alpha) or 3 (RGB) components on the last axis. An array
//! cannot say more than its numbers, so `NAME.volume.json` beside `NAME.npy` has the axes along which the texture
//! tiles, and the name of the array `<u4` `[z, y, x]` with its labels: `{"tiles": "xz", "labels": "NAME-labels.npy"}`.

use std::path::{Path, PathBuf};

use super::beside::BesideError;
use super::block::{Block, rgba};
use super::npy::{Array, NpyError, encode as to_npy};
use super::sidecar::{Sidecar, SidecarError};
use super::texture::{SolidTexture, VolumeError, checked_voxels};

/// An NPY file that does not give a volume.
#[derive(Debug, thiserror::Error)]
pub enum ArrayError {
    /// No array of bytes.
    #[error(transparent)]
    Npy(#[from] NpyError),
    /// An array of other axes.
    #[error("its shape is {0:?}; a volume has the shape [z, y, x, 4], or [z, y, x] where it is grey")]
    Shape(Vec<u64>),
    /// Too large, or empty.
    #[error(transparent)]
    Size(#[from] VolumeError),
    /// The file beside it is wrong.
    #[error(transparent)]
    Sidecar(#[from] SidecarError),
    /// Its labels are wrong.
    #[error(transparent)]
    Labels(#[from] BesideError),
}

/// The file beside an array that says what it cannot.
pub(super) fn sidecar_path(path: &Path) -> PathBuf {
    path.with_extension("volume.json")
}

pub(super) fn decode(path: &Path, bytes: &[u8]) -> Result<SolidTexture, ArrayError> {
    let array = Array::parse::<u8>(bytes)?;
    let (sides, components) = match array.shape[..] {
        [z, y, x] => ([x, y, z], 1),
        [z, y, x, n @ 1..=4] => ([x, y, z], n),
        _ => return Err(ArrayError::Shape(array.shape)),
    };
    checked_voxels(sides)?;
    let sidecar = Sidecar::read(&sidecar_path(path))?;
    let numbers = array.numbers::<u8>();
    let voxels = numbers.chunks_exact(usize::try_from(components).unwrap_or(4)).map(rgba).collect();
    let size = sides.map(|n| u32::try_from(n).unwrap_or(0)); // at most MAX_SIDE
    let texture = SolidTexture::new(size, voxels, [false; 3])?;
    Ok(sidecar.apply(texture, path.parent().unwrap_or(Path::new("")))?)
}

pub(super) fn encode(block: &Block<'_>) -> Vec<u8> {
    let [x, y, z] = block.size;
    let shape = [z, y, x, u32::from(block.channels)];
    to_npy(if block.channels == 1 { &shape[..3] } else { &shape }, block.data)
}

pub(super) fn encode_labels([x, y, z]: [u32; 3], labels: &[u32]) -> Vec<u8> {
    to_npy(&[z, y, x], labels)
}
