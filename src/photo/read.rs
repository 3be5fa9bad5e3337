//! Photographs from files.

use std::io::{self, Cursor};
use std::path::{Path, PathBuf};

use image::{DynamicImage, ImageDecoder, ImageError, ImageReader, Limits};

use super::{MAX_PHOTO_SIDE, PhotoError, Photograph, checked_pixels};
use crate::files;

/// The most memory that a decoder may take, in bytes: a photograph of the greatest size with 16 bits a channel.
const MAX_DECODER_BYTES: u64 = super::MAX_PHOTO_PIXELS * 8;

/// A file that gives no photograph.
#[derive(Debug, thiserror::Error)]
pub enum PhotoReadError {
    /// It cannot be read at all.
    #[error("cannot read {}: {error}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        error: io::Error,
    },
    /// Its content is of no known kind, whatever its name says.
    #[error("{} is no picture that Lapis reads; save it as PNG, JPEG, TIFF, WebP or BMP", path.display())]
    Unknown {
        /// The file.
        path: PathBuf,
    },
    /// It is damaged, or of a variety that the decoder does not know.
    #[error("{}: {error}", path.display())]
    Broken {
        /// The file.
        path: PathBuf,
        /// What the decoder says.
        error: ImageError,
    },
    /// Too many pixels.
    #[error("{}: {error}", path.display())]
    Size {
        /// The file.
        path: PathBuf,
        /// How many.
        error: PhotoError,
    },
}

/// Reads a photograph: PNG, JPEG, TIFF, WebP or BMP, told apart by content. Grey is spread over the three colours,
/// 16 bits a channel are rounded to 8, and a photograph that a camera took lying on its side is stood upright. Colours
/// are taken as sRGB, whatever profile the file may name.
///
/// # Errors
/// [`PhotoReadError`], which names the file. Sizes are checked before memory is taken.
pub fn read(path: &Path) -> Result<Photograph, PhotoReadError> {
    let place = || path.to_owned();
    let bytes = files::read_whole(path).map_err(|error| PhotoReadError::Io { path: place(), error })?;
    decode(&bytes).map_err(|fault| match fault {
        Fault::Unknown => PhotoReadError::Unknown { path: place() },
        Fault::Broken(error) => PhotoReadError::Broken { path: place(), error },
        Fault::Size(error) => PhotoReadError::Size { path: place(), error },
    })
}

enum Fault {
    Unknown,
    Broken(ImageError),
    Size(PhotoError),
}

fn decode(bytes: &[u8]) -> Result<Photograph, Fault> {
    let mut reader = ImageReader::new(Cursor::new(bytes))
        .with_guessed_format()
        .map_err(|e| Fault::Broken(ImageError::IoError(e)))?;
    if reader.format().is_none() {
        return Err(Fault::Unknown);
    }
    let mut limits = Limits::default();
    limits.max_alloc = Some(MAX_DECODER_BYTES);
    reader.limits(limits);
    let mut decoder = reader.into_decoder().map_err(|e| match e {
        // Known by its first bytes, but left out of this build.
        ImageError::Unsupported(_) => Fault::Unknown,
        e => Fault::Broken(e),
    })?;
    let (width, height) = decoder.dimensions();
    checked_pixels([width.into(), height.into()]).map_err(Fault::Size)?;
    debug_assert!(width <= MAX_PHOTO_SIDE);
    let orientation = decoder.orientation().map_err(Fault::Broken)?;
    let mut picture = DynamicImage::from_decoder(decoder).map_err(Fault::Broken)?;
    picture.apply_orientation(orientation);
    let rgba = picture.into_rgba8();
    let size = [rgba.width(), rgba.height()];
    let pixels = rgba.into_raw().as_chunks().0.to_vec();
    Photograph::new(size, pixels).map_err(Fault::Size)
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{GrayImage, ImageBuffer, ImageFormat, Luma, RgbImage};

    fn bytes(picture: &DynamicImage, format: ImageFormat) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        picture.write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    }

    #[test]
    fn every_format_and_depth() {
        let rgb =
            DynamicImage::from(RgbImage::from_fn(9, 5, |x, y| image::Rgb([x as u8 * 20, y as u8 * 30, 7])));
        for format in [ImageFormat::Png, ImageFormat::Tiff, ImageFormat::WebP, ImageFormat::Bmp] {
            let photo = decode(&bytes(&rgb, format)).ok().unwrap();
            assert_eq!(
                (photo.size(), photo.pixel(3, 2), photo.is_opaque()),
                ([9, 5], [60, 60, 7, 255], true)
            );
        }
        let photo = decode(&bytes(&rgb, ImageFormat::Jpeg)).ok().unwrap();
        assert_eq!(photo.size(), [9, 5]);
        let grey = DynamicImage::from(GrayImage::from_pixel(2, 2, Luma([77])));
        assert_eq!(decode(&bytes(&grey, ImageFormat::Png)).ok().unwrap().pixel(1, 1), [77, 77, 77, 255]);
        let deep: ImageBuffer<Luma<u16>, Vec<u16>> = ImageBuffer::from_pixel(2, 2, Luma([257 * 99]));
        let deep = DynamicImage::from(deep);
        assert_eq!(decode(&bytes(&deep, ImageFormat::Png)).ok().unwrap().pixel(0, 1), [99, 99, 99, 255]);
    }

    #[test]
    fn broken_files_are_errors() {
        let rgb = DynamicImage::from(RgbImage::new(8, 8));
        let good = bytes(&rgb, ImageFormat::Png);
        for n in 0..good.len() - 12 {
            assert!(decode(&good[..n]).is_err(), "{n} bytes");
        }
        assert!(matches!(decode(b"solid cube"), Err(Fault::Unknown)));
        assert!(matches!(decode(b"GIF89a\x01\0\x01\0\0\0\0"), Err(Fault::Unknown)));
        // A header that promises more pixels than any memory has.
        let mut huge = good.clone();
        huge[16..24].copy_from_slice(&[0x7f, 0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff]);
        assert!(decode(&huge).is_err());
        let mut wide = good;
        wide[16..20].copy_from_slice(&40_000u32.to_be_bytes());
        // The checksum of the header is wrong now: it is an error of one kind or the other.
        assert!(decode(&wide).is_err());
    }
}
