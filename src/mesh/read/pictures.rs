//! Pictures that materials wear: PNG and JPEG.

use std::collections::BTreeMap;
use std::io::Cursor;

use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use crate::mesh::{WornPicture, index};

/// The longest side of a picture.
const MAX_SIDE: u32 = 32768;
/// The most pixels of all pictures of one mesh (512 MiB).
const MAX_PIXELS: u64 = 1 << 27;

/// How the alpha of a picture is meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Alpha {
    /// As it is.
    Blend,
    /// It means nothing: everything is opaque.
    Opaque,
    /// From this value on a pixel is opaque, else clear.
    Mask(u8),
}

impl Alpha {
    pub(super) fn of(self, alpha: u8) -> u8 {
        match self {
            Self::Blend => alpha,
            Self::Opaque => 255,
            Self::Mask(cutoff) => {
                if alpha >= cutoff {
                    255
                } else {
                    0
                }
            }
        }
    }
}

/// The pictures of a mesh, each read once.
#[derive(Default)]
pub(super) struct Pictures {
    list: Vec<WornPicture>,
    pixels: u64,
    known: BTreeMap<(String, Alpha), Option<u32>>,
}

impl Pictures {
    /// The number of the picture called `name`; `bytes` gets its file. `None` where it cannot be had: the
    /// first time, `failed` is told why.
    pub(super) fn get(
        &mut self,
        name: &str,
        alpha: Alpha,
        bytes: impl FnOnce() -> Result<Vec<u8>, String>,
        failed: impl FnOnce(String),
    ) -> Option<u32> {
        let key = (name.to_owned(), alpha);
        if let Some(known) = self.known.get(&key) {
            return *known;
        }
        let read = bytes().and_then(|bytes| decode(&bytes, MAX_PIXELS - self.pixels));
        let found = match read {
            Ok(mut picture) => {
                picture.rgba.iter_mut().for_each(|c| c[3] = alpha.of(c[3]));
                self.pixels += u64::from(picture.width) * u64::from(picture.height);
                self.list.push(picture);
                Some(index(self.list.len() - 1))
            }
            Err(why) => {
                failed(why);
                None
            }
        };
        self.known.insert(key, found);
        found
    }

    pub(super) fn finish(self) -> Vec<WornPicture> {
        self.list
    }
}

/// A PNG or JPEG file of at most so many pixels.
fn decode(bytes: &[u8], most: u64) -> Result<WornPicture, String> {
    let fits = |width: u32, height: u32| {
        if width == 0 || height == 0 || width > MAX_SIDE || height > MAX_SIDE {
            return Err(format!("{width}×{height} pixels; each side must have 1 to {MAX_SIDE}"));
        }
        if u64::from(width) * u64::from(height) > most {
            return Err(format!(
                "{width}×{height} pixels; all pictures of a mesh may have {MAX_PIXELS} together: make them smaller"
            ));
        }
        Ok(())
    };
    if bytes.starts_with(b"\x89PNG") {
        png_picture(bytes, fits).map_err(|e| format!("as PNG: {e}"))
    } else if bytes.starts_with(&[0xff, 0xd8]) {
        jpeg_picture(bytes, fits).map_err(|e| format!("as JPEG: {e}"))
    } else {
        Err("neither PNG nor JPEG: save it as one of them".to_owned())
    }
}

fn png_picture(bytes: &[u8], fits: impl Fn(u32, u32) -> Result<(), String>) -> Result<WornPicture, String> {
    let text = |e: png::DecodingError| e.to_string();
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    let about = decoder.read_header_info().map_err(text)?;
    let (width, height) = (about.width, about.height);
    fits(width, height)?;
    decoder.set_transformations(png::Transformations::EXPAND | png::Transformations::STRIP_16);
    let mut reader = decoder.read_info().map_err(text)?;
    let length = reader.output_buffer_size().ok_or("it is too large")?;
    let mut samples = vec![0; length];
    let frame = reader.next_frame(&mut samples).map_err(text)?;
    // The first frame of an animation may be smaller than the picture.
    if (frame.width, frame.height) != (width, height) {
        return Err("it is an animation of parts; save it as a plain picture".to_owned());
    }
    let channels = frame.color_type.samples();
    rgba(width, height, channels, &samples[..frame.buffer_size()])
}

fn jpeg_picture(bytes: &[u8], fits: impl Fn(u32, u32) -> Result<(), String>) -> Result<WornPicture, String> {
    let side = MAX_SIDE as usize;
    let options = DecoderOptions::default()
        .set_max_width(side)
        .set_max_height(side)
        .set_strict_mode(false)
        .jpeg_set_out_colorspace(ColorSpace::RGB);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(|e| e.to_string())?;
    let (width, height) = decoder.dimensions().ok_or("it has no size")?;
    let (width, height) = (u32::try_from(width).unwrap_or(0), u32::try_from(height).unwrap_or(0));
    fits(width, height)?;
    let samples = decoder.decode().map_err(|e| e.to_string())?;
    let channels = samples.len() / (width as usize * height as usize);
    rgba(width, height, channels, &samples)
}

/// Samples of one (grey), two (grey, alpha), three or four channels.
fn rgba(width: u32, height: u32, channels: usize, samples: &[u8]) -> Result<WornPicture, String> {
    let rgba: Vec<[u8; 4]> = match channels {
        1 => samples.iter().map(|&y| [y, y, y, 255]).collect(),
        2 => samples.as_chunks().0.iter().map(|&[y, a]| [y, y, y, a]).collect(),
        3 => samples.as_chunks().0.iter().map(|&[r, g, b]| [r, g, b, 255]).collect(),
        4 => samples.as_chunks().0.to_vec(),
        _ => return Err(format!("{channels} channels")),
    };
    if rgba.len() as u64 != u64::from(width) * u64::from(height) {
        return Err("its data end early".to_owned());
    }
    Ok(WornPicture { width, height, rgba })
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A PNG of 8-bit samples.
    pub(in super::super) fn png(width: u32, height: u32, kind: png::ColorType, samples: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, width, height);
        encoder.set_color(kind);
        encoder.write_header().unwrap().write_image_data(samples).unwrap();
        bytes
    }

    /// A JPEG of 8×8 pixels, all of one grey (baseline, one component; coded by hand after ITU T.81).
    pub(in super::super) fn grey_jpeg() -> Vec<u8> {
        let mut bytes = vec![0xff, 0xd8, 0xff, 0xdb, 0, 67, 0];
        bytes.extend([1; 64]);
        // Start of frame: 8 bits, 8×8, one component without subsampling.
        bytes.extend([0xff, 0xc0, 0, 11, 8, 0, 8, 0, 8, 1, 1, 0x11, 0]);
        // Huffman tables, DC and AC: one code of one bit each, "category 0" and "end of block".
        for class in [0x00, 0x10] {
            bytes.extend([0xff, 0xc4, 0, 20, class, 1]);
            bytes.extend([0; 15]);
            bytes.push(0);
        }
        // The scan: both codes, filled up with ones.
        bytes.extend([0xff, 0xda, 0, 8, 1, 1, 0, 0, 63, 0, 0b0011_1111, 0xff, 0xd9]);
        bytes
    }

    #[test]
    fn png_of_every_kind() {
        use png::ColorType::{Grayscale, GrayscaleAlpha, Rgb, Rgba};
        for (kind, samples, pixel) in [
            (Grayscale, &[7, 9][..], [9, 9, 9, 255]),
            (GrayscaleAlpha, &[7, 1, 9, 2], [9, 9, 9, 2]),
            (Rgb, &[1, 2, 3, 4, 5, 6], [4, 5, 6, 255]),
            (Rgba, &[1, 2, 3, 4, 5, 6, 7, 8], [5, 6, 7, 8]),
        ] {
            let picture = decode(&png(2, 1, kind, samples), 2).unwrap();
            assert_eq!((picture.width, picture.height, picture.rgba[1]), (2, 1, pixel));
        }
        let good = png(2, 1, Grayscale, &[7, 9]);
        assert!(decode(&good, 1).unwrap_err().contains("2×1"));
        for n in 0..good.len() - 12 {
            assert!(decode(&good[..n], 2).is_err(), "{n} bytes");
        }
    }

    #[test]
    fn jpeg() {
        let bytes = grey_jpeg();
        let picture = decode(&bytes, 64).unwrap();
        assert_eq!((picture.width, picture.height), (8, 8));
        assert!(picture.rgba.iter().all(|c| *c == [128, 128, 128, 255]), "{:?}", picture.rgba[0]);
        assert!(decode(&bytes, 63).unwrap_err().contains("8×8"));
        assert!(decode(&bytes[..40], 64).is_err());
        assert!(decode(b"GIF89a", 64).unwrap_err().contains("neither"));
    }

    #[test]
    fn each_is_read_once_and_failures_are_told_once() {
        let mut pictures = Pictures::default();
        let bytes = || Ok(png(1, 1, png::ColorType::Rgba, &[1, 2, 3, 4]));
        assert_eq!(pictures.get("a", Alpha::Blend, bytes, |_| panic!()), Some(0));
        assert_eq!(pictures.get("a", Alpha::Blend, || panic!(), |_| panic!()), Some(0));
        assert_eq!(pictures.get("a", Alpha::Opaque, bytes, |_| panic!()), Some(1));
        assert_eq!(pictures.get("a", Alpha::Mask(5), bytes, |_| panic!()), Some(2));
        let mut told = 0;
        for _ in 0..2 {
            assert_eq!(pictures.get("b", Alpha::Blend, || Err("gone".into()), |_| told += 1), None);
        }
        assert_eq!(told, 1);
        let alphas: Vec<u8> = pictures.finish().iter().map(|p| p.rgba[0][3]).collect();
        assert_eq!(alphas, [4, 255, 0]);
    }
}
