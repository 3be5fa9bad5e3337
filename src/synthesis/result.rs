//! What a synthesis makes.

use serde::Serialize;

use super::SynthesisError;
use super::axes::Axis;
use super::exemplar::resized;
use crate::photo::Photograph;
use crate::volume::SolidTexture;

/// What a synthesis did.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct SynthesisReport {
    /// Voxels made.
    pub voxels: usize,
    /// Pixels of all photographs that could be copied, at working size.
    pub pixels: usize,
    /// Levels of the pyramid.
    pub levels: usize,
    /// Entropy of how often each pixel is copied, over that of equal use; 1 is perfect.
    pub position_entropy: f64,
    /// Part of the pixels that is copied at all.
    pub position_coverage: f64,
    /// The largest seam along an axis that tiles: the mean step of colour across the wrap over that inside; 1 is none.
    pub wrap_seam: Option<f64>,
    /// What remains of the energy (equation 1 of \[CW\]) after each pass, level by level: Σ|s − e|^γ, the mean of all
    /// neighbourhoods that were looked at, for each pixel of theirs; two random neighbourhoods have about 1.3.
    pub energy: Vec<Vec<f64>>,
}

/// A solid texture, and where each of its voxels comes from.
#[derive(Debug, Clone, PartialEq)]
pub struct Synthesis {
    /// The volume: every colour is that of a pixel of a photograph at working size, with full opacity.
    pub texture: SolidTexture,
    /// For each voxel, x fastest, the pixel that it is a copy of. Pixels are counted row after row through all
    /// photographs in turn: those of the second begin where the first one's end.
    pub source: Vec<u32>,
    /// The photographs at working size.
    pub photos: Vec<Photograph>,
    /// How it went.
    pub report: SynthesisReport,
    pub(super) originals: Vec<[u32; 2]>,
}

impl Synthesis {
    /// The source map as an NPY file of 32-bit numbers \[z, y, x\], which `lapis assess` and NumPy read.
    #[must_use]
    pub fn source_npy(&self) -> Vec<u8> {
        let [x, y, z] = self.texture.size();
        let header = format!("{{'descr': '<u4', 'fortran_order': False, 'shape': ({z}, {y}, {x}), }}");
        // The header ends in a newline, and the data begin at a multiple of 64 bytes.
        let length = (10 + header.len() + 1).next_multiple_of(64) - 10;
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend_from_slice(&(length as u16).to_le_bytes());
        bytes.extend_from_slice(format!("{header:<width$}\n", width = length - 1).as_bytes());
        bytes.extend(self.source.iter().flat_map(|s| s.to_le_bytes()));
        bytes
    }

    /// Other channels, carried along: a volume in which each voxel has the value of `maps` where it is copied from.
    /// There must be one map for each photograph, of that photograph's original size: a height map, say, makes the
    /// displacement that belongs to the colours.
    ///
    /// # Errors
    /// [`SynthesisError::OtherSize`]; [`SynthesisError::Unused`] where there are more or fewer maps than photographs.
    pub fn channel(&self, maps: &[&Photograph]) -> Result<SolidTexture, SynthesisError> {
        if maps.len() != self.photos.len() {
            return Err(SynthesisError::Unused { photo: maps.len().min(self.photos.len()) });
        }
        let mut values = Vec::new();
        for (photo, map) in maps.iter().enumerate() {
            let expected = self.originals[photo];
            if map.size() != expected {
                return Err(SynthesisError::OtherSize { what: "map", photo, found: map.size(), expected });
            }
            values.extend_from_slice(resized(map, self.photos[photo].size()).pixels());
        }
        let voxels = self.source.iter().map(|&s| values[s as usize]).collect();
        Ok(SolidTexture::new(self.texture.size(), voxels, self.texture.tiles())?)
    }
}

/// The volume as it stands at the end of a level.
pub struct LevelView<'a> {
    /// The level, 1 the coarsest.
    pub level: usize,
    /// Of so many.
    pub levels: usize,
    pub(super) size: [usize; 3],
    pub(super) colour: &'a (dyn Fn(usize) -> [u8; 4] + Sync),
}

impl LevelView<'_> {
    /// Voxels along x, y and z at this level.
    #[must_use]
    pub fn size(&self) -> [usize; 3] {
        self.size
    }

    /// A slice perpendicular to `axis`, the layer `at` (counted from 0; the last one where it is larger), laid out as
    /// [`Axis::right`] says.
    #[must_use]
    pub fn slice(&self, axis: Axis, at: usize) -> Photograph {
        let [right, down] = [axis.right().index(), axis.down().index()];
        let mut place = [0; 3];
        place[axis.index()] = at.min(self.size[axis.index()] - 1);
        let mut pixels = Vec::with_capacity(self.size[right] * self.size[down]);
        for y in 0..self.size[down] {
            for x in 0..self.size[right] {
                place[right] = x;
                place[down] = y;
                pixels.push((self.colour)((place[2] * self.size[1] + place[1]) * self.size[0] + place[0]));
            }
        }
        let size = [right, down].map(|a| self.size[a] as u32);
        Photograph::new(size, pixels).expect("a slice has as many pixels as its sides say")
    }
}
