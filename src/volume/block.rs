//! Voxels on their way to a file and from one.

use super::displacement::Displacement;
use super::mask::AlphaMask;
use super::texture::SolidTexture;

/// What is written of a volume, in whatever kind of file.
pub(super) struct Block<'a> {
    pub(super) size: [u32; 3],
    /// 4: RGBA, 1: grey.
    pub(super) channels: u8,
    /// x fastest, channels side by side.
    pub(super) data: &'a [u8],
    /// Of textures, the axes along which they tile.
    pub(super) tiles: Option<[bool; 3]>,
    pub(super) labels: Option<&'a [u32]>,
    pub(super) displacement: Option<&'a Displacement>,
}

/// The names of the files beside a volume's own.
#[derive(Default)]
pub(super) struct Names {
    pub(super) labels: Option<String>,
    pub(super) displacement: Option<String>,
}

impl Block<'_> {
    /// A block of some size, without data.
    pub(super) fn plain(size: [u32; 3]) -> Self {
        Self { size, channels: 4, data: &[], tiles: None, labels: None, displacement: None }
    }
}

impl<'a> From<&'a SolidTexture> for Block<'a> {
    fn from(texture: &'a SolidTexture) -> Self {
        let (data, tiles) = (texture.voxels().as_flattened(), Some(texture.tiles()));
        Self {
            data,
            tiles,
            labels: texture.labels(),
            displacement: texture.displacement(),
            ..Self::plain(texture.size())
        }
    }
}

impl<'a> From<&'a AlphaMask> for Block<'a> {
    fn from(mask: &'a AlphaMask) -> Self {
        Self { channels: 1, data: mask.alpha(), ..Self::plain(mask.size()) }
    }
}

/// A voxel of one to four components: grey, grey and alpha, RGB, RGBA.
pub(super) fn rgba(components: &[u8]) -> [u8; 4] {
    match *components {
        [g] => [g, g, g, 255],
        [g, a] => [g, g, g, a],
        [r, g, b] => [r, g, b, 255],
        [r, g, b, a, ..] => [r, g, b, a],
        [] => [0; 4],
    }
}
