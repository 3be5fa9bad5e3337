//! Photographs: pictures that textures are taken from, in memory and from files.

mod otsu;
mod read;
mod shrink;

pub(crate) use otsu::{BINS, otsu};
pub use read::{PhotoReadError, read};

/// The longest side of a photograph, in pixels.
pub const MAX_PHOTO_SIDE: u32 = 32768;
/// The most pixels of a photograph (2²⁷, some 134 megapixels).
pub const MAX_PHOTO_PIXELS: u64 = 1 << 27;

/// Numbers that do not make a photograph.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PhotoError {
    /// No pixels, or too many.
    #[error(
        "{}×{} pixels: each side must have 1 to {MAX_PHOTO_SIDE} pixels, all together at most {MAX_PHOTO_PIXELS}; make it smaller",
        .0[0], .0[1]
    )]
    Size([u64; 2]),
    /// Data of another length than the size says.
    #[error("{found} pixels of data where the size says {expected}")]
    Length {
        /// Pixels that the size promises.
        expected: usize,
        /// Pixels that are there.
        found: usize,
    },
}

/// Checks the sides of a photograph *before* anything is allocated and gives the number of pixels.
///
/// # Errors
/// [`PhotoError::Size`].
pub fn checked_pixels(size: [u64; 2]) -> Result<usize, PhotoError> {
    let good = size.iter().all(|&s| s >= 1 && s <= u64::from(MAX_PHOTO_SIDE));
    let total = size[0].saturating_mul(size[1]);
    if !good || total > MAX_PHOTO_PIXELS {
        return Err(PhotoError::Size(size));
    }
    usize::try_from(total).map_err(|_| PhotoError::Size(size))
}

/// A photograph: RGBA, 8 bits a channel, sRGB with straight linear alpha. Rows run from top to bottom, each from
/// left to right; pixel (i, j) has its centre at (i + ½, j + ½).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Photograph {
    size: [u32; 2],
    pixels: Vec<[u8; 4]>,
}

impl Photograph {
    /// A photograph of `size` = width, height.
    ///
    /// # Errors
    /// [`PhotoError`] where size and data do not fit.
    pub fn new(size: [u32; 2], pixels: Vec<[u8; 4]>) -> Result<Self, PhotoError> {
        let expected = checked_pixels(size.map(u64::from))?;
        if pixels.len() != expected {
            return Err(PhotoError::Length { expected, found: pixels.len() });
        }
        Ok(Self { size, pixels })
    }

    /// Width and height in pixels.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The pixels, row after row.
    #[must_use]
    pub fn pixels(&self) -> &[[u8; 4]] {
        &self.pixels
    }

    /// The pixel in column `x` of row `y`.
    ///
    /// # Panics
    /// Outside the photograph.
    #[must_use]
    pub fn pixel(&self, x: u32, y: u32) -> [u8; 4] {
        assert!(x < self.size[0] && y < self.size[1], "a pixel outside the photograph");
        self.pixels[y as usize * self.size[0] as usize + x as usize]
    }

    /// Whether no pixel is even a little transparent.
    #[must_use]
    pub fn is_opaque(&self) -> bool {
        self.pixels.iter().all(|p| p[3] == 255)
    }
}
