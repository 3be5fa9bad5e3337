//! A texture as it is pasted: opaque colours under a mask.

use std::sync::Arc;

use super::PasteError;
use crate::volume::{AlphaMask, SolidTexture, SplotchParams};

/// A texture to be pasted, and the mask through which.
#[derive(Debug, Clone)]
pub struct Stamp {
    texture: Arc<SolidTexture>,
    mask: Arc<AlphaMask>,
}

impl Stamp {
    /// A texture with transparent voxels is pasted through its own opacity: a seed, with nothing around it. One that is opaque
    /// all over is pasted through the splotch of `seed`, with a soft rim.
    ///
    /// # Errors
    /// [`PasteError::Transparent`].
    pub fn new(texture: &SolidTexture, seed: u64) -> Result<Self, PasteError> {
        let alpha: Vec<u8> = texture.voxels().iter().map(|v| v[3]).collect();
        let mask = if alpha.iter().all(|&a| a == 255) {
            AlphaMask::splotch(&SplotchParams::default(), seed)
        } else {
            AlphaMask::new(texture.size(), alpha).expect("a texture has as many voxels as its size says")
        };
        Self::through(texture, mask)
    }

    /// The texture through a mask of one's own.
    ///
    /// # Errors
    /// [`PasteError::Transparent`] where nothing of the mask, or of the texture, is opaque.
    pub fn through(texture: &SolidTexture, mask: AlphaMask) -> Result<Self, PasteError> {
        if mask.alpha().iter().all(|&a| a == 0) {
            return Err(PasteError::Transparent);
        }
        let mut voxels = texture.voxels().to_vec();
        spread(&mut voxels, texture.size().map(|n| n as usize))?;
        voxels.iter_mut().for_each(|v| v[3] = 255);
        // Pasted once, it ends at its borders.
        let mut opaque = SolidTexture::new(texture.size(), voxels, [false; 3])
            .expect("a texture has as many voxels as its size says");
        if let Some(labels) = texture.labels() {
            opaque = opaque.with_labels(labels.to_vec()).expect("labels of the same texture");
        }
        Ok(Self { texture: Arc::new(opaque), mask: Arc::new(mask) })
    }

    pub(super) fn texture(&self) -> &Arc<SolidTexture> {
        &self.texture
    }

    pub(super) fn mask(&self) -> &Arc<AlphaMask> {
        &self.mask
    }
}

/// Gives transparent voxels the colours of opaque ones beside them, from those outwards: where the rim of the mask lies, nothing
/// but the texture's own colours must shine through.
fn spread(voxels: &mut [[u8; 4]], size: [usize; 3]) -> Result<(), PasteError> {
    let mut done: Vec<bool> = voxels.iter().map(|v| v[3] > 0).collect();
    if done.iter().all(|d| !d) {
        return Err(PasteError::Transparent);
    }
    let mut rim: Vec<usize> = (0..voxels.len()).filter(|&n| done[n]).collect();
    while !rim.is_empty() {
        let mut next = Vec::new();
        for n in rim {
            let at = [n % size[0], n / size[0] % size[1], n / size[0] / size[1]];
            let strides = [1, size[0], size[0] * size[1]];
            for axis in 0..3 {
                let below = (at[axis] > 0).then(|| n - strides[axis]);
                let above = (at[axis] + 1 < size[axis]).then(|| n + strides[axis]);
                for m in below.into_iter().chain(above) {
                    if !done[m] {
                        done[m] = true;
                        voxels[m] = [voxels[n][0], voxels[n][1], voxels[n][2], voxels[m][3]];
                        next.push(m);
                    }
                }
            }
        }
        rim = next;
    }
    Ok(())
}
