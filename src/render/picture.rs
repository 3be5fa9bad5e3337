//! A finished picture, and its PNG.

use std::io::Cursor;

use super::MAX_PICTURE_SIDE;

/// A picture: rows from top to bottom, each from left to right, 8-bit sRGB with straight alpha.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// The pixels. Length `width · height`.
    pub rgba: Vec<[u8; 4]>,
}

/// A PNG that cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// It is no PNG, or a broken one.
    #[error("the PNG cannot be read: {0}")]
    Png(#[from] png::DecodingError),
    /// It has too many pixels.
    #[error("the PNG has {width}×{height} pixels; each side may have at most {MAX_PICTURE_SIDE}")]
    Size {
        /// Its width.
        width: u32,
        /// Its height.
        height: u32,
    },
}

/// How far two pictures lie apart, over all channels of all pixels, in steps of 1/255.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// Mean absolute difference.
    pub mean: f64,
    /// Greatest absolute difference.
    pub max: u8,
}

impl Picture {
    /// The pixel in column `x` of row `y`.
    ///
    /// # Panics
    /// Outside the picture.
    #[must_use]
    pub fn pixel(&self, x: u32, y: u32) -> [u8; 4] {
        assert!(x < self.width && y < self.height, "a pixel outside the picture");
        self.rgba[y as usize * self.width as usize + x as usize]
    }

    /// The picture as a PNG marked as sRGB, without a time. Without alpha where every pixel is opaque.
    ///
    /// # Panics
    /// Where `rgba` is not `width · height` long, or the picture is empty.
    #[must_use]
    pub fn to_png(&self) -> Vec<u8> {
        self.png(true)
    }

    /// As [`Picture::to_png`]; glTF forbids colour space chunks, so the mark can be left out.
    pub(crate) fn png(&self, srgb: bool) -> Vec<u8> {
        self.png_as(srgb, self.rgba.iter().all(|p| p[3] == 255))
    }

    /// As [`Picture::png`], but without alpha only where `opaque` says so.
    pub(super) fn png_as(&self, srgb: bool, opaque: bool) -> Vec<u8> {
        assert_eq!(self.rgba.len(), self.width as usize * self.height as usize, "pixels missing");
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, self.width, self.height);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_color(if opaque { png::ColorType::Rgb } else { png::ColorType::Rgba });
        if srgb {
            encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        }
        let write = |encoder: png::Encoder<'_, &mut Vec<u8>>| {
            let mut writer = encoder.write_header()?;
            if opaque {
                let rgb: Vec<u8> = self.rgba.iter().flat_map(|p| [p[0], p[1], p[2]]).collect();
                writer.write_image_data(&rgb)?;
            } else {
                writer.write_image_data(self.rgba.as_flattened())?;
            }
            writer.finish()
        };
        write(encoder).expect("a picture with pixels, written to memory");
        file
    }

    /// Reads a PNG of any colour type; 16-bit channels are cut to 8 bits.
    ///
    /// # Errors
    /// [`PictureError`].
    pub fn from_png(bytes: &[u8]) -> Result<Self, PictureError> {
        let limit = usize::try_from(u64::from(MAX_PICTURE_SIDE) * u64::from(MAX_PICTURE_SIDE) * 8)
            .unwrap_or(usize::MAX);
        let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), png::Limits { bytes: limit });
        decoder.set_transformations(png::Transformations::ALPHA | png::Transformations::STRIP_16);
        let header = decoder.read_header_info()?;
        let (width, height) = (header.width, header.height);
        if width > MAX_PICTURE_SIDE || height > MAX_PICTURE_SIDE {
            return Err(PictureError::Size { width, height });
        }
        let mut reader = decoder.read_info()?;
        let grey = match reader.output_color_type().0 {
            png::ColorType::GrayscaleAlpha => true,
            png::ColorType::Rgba => false,
            // ALPHA expands everything to one of the two.
            other => unreachable!("colour type {other:?} after expansion"),
        };
        // The file's length bounds what is allocated up front; rows are appended as they decode.
        let mut rgba = Vec::new();
        while let Some(row) = reader.next_row()? {
            if grey {
                rgba.extend(row.data().chunks_exact(2).map(|p| [p[0], p[0], p[0], p[1]]));
            } else {
                rgba.extend(row.data().chunks_exact(4).map(|p| [p[0], p[1], p[2], p[3]]));
            }
        }
        Ok(Self { width, height, rgba })
    }

    /// How far this picture lies from another; `None` where their sizes differ.
    #[must_use]
    pub fn difference(&self, other: &Self) -> Option<Difference> {
        if (self.width, self.height) != (other.width, other.height) || self.rgba.len() != other.rgba.len() {
            return None;
        }
        let (mut sum, mut max) = (0u64, 0u8);
        for (a, b) in self.rgba.as_flattened().iter().zip(other.rgba.as_flattened()) {
            let d = a.abs_diff(*b);
            sum += u64::from(d);
            max = max.max(d);
        }
        #[allow(clippy::cast_precision_loss)] // far below 2⁵³
        let mean = sum as f64 / (self.rgba.len() * 4).max(1) as f64;
        Some(Difference { mean, max })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(width: u32, height: u32, opaque: bool) -> Picture {
        let rgba = (0..width * height)
            .map(|i| {
                let [r, g, b, a] = i.wrapping_mul(2_654_435_761).to_le_bytes();
                [r, g, b, if opaque { 255 } else { a }]
            })
            .collect();
        Picture { width, height, rgba }
    }

    #[test]
    fn a_png_brings_every_pixel_back() {
        for opaque in [true, false] {
            let picture = noise(37, 21, opaque);
            let png = picture.to_png();
            assert!(png.windows(4).any(|w| w == b"sRGB") && !png.windows(4).any(|w| w == b"tIME"));
            assert_eq!(Picture::from_png(&png).unwrap(), picture);
            assert!(!picture.png(false).windows(4).any(|w| w == b"sRGB"));
        }
    }

    #[test]
    fn broken_pngs_are_errors() {
        let png = noise(37, 21, false).to_png();
        for end in 0..png.len() - 12 {
            assert!(Picture::from_png(&png[..end]).is_err(), "{end}");
        }
        assert!(Picture::from_png(b"no picture at all").is_err());
    }

    #[test]
    fn differences_are_counted() {
        let a = noise(8, 8, true);
        let mut b = a.clone();
        b.rgba[5][1] = b.rgba[5][1].wrapping_add(0) ^ 0x10;
        let d = a.difference(&b).unwrap();
        assert_eq!(d.max, 16);
        assert!((d.mean - 16.0 / 256.0).abs() < 1e-12);
        assert_eq!(a.difference(&a), Some(Difference { mean: 0.0, max: 0 }));
        assert_eq!(a.difference(&noise(4, 16, true)), None);
    }
}
