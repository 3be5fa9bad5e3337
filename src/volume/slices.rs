//! Volumes as a folder of PNG pictures, one for each slice along z: x to the right, y down, row 0 is y = 0.
//!
//! Written: `slice-0000.png`, `slice-0001.png` and so on (8-bit RGBA, or grey for masks), and for textures
//! `volume.json` with the axes along which the texture tiles: `{"tiles": "xz"}`. Particle labels are written to
//! `labels.nrrd` in the folder, which `volume.json` names: `{"tiles": "xz", "labels": "labels.nrrd"}`. Read: every `.png` of the
//! folder in natural order (`2` before `10`), all of one size: RGB, RGBA, grey or palette with at most 8 bits a
//! channel; without `volume.json` the texture tiles nowhere. Other files and folders are passed over. Colours
//! are taken as sRGB, whatever else a picture may say.

use std::cmp::Ordering;
use std::fs;
use std::io::{self, Cursor};
use std::path::{Path, PathBuf};

use super::beside::BesideError;
use super::block::{Block, Names, rgba};
use super::nrrd;
use super::sidecar::{Sidecar, SidecarError};
use super::texture::{MAX_SIDE, SolidTexture, VolumeError, checked_voxels};
use crate::files;

pub(super) const SIDECAR: &str = "volume.json";
const LABELS: &str = "labels.nrrd";
const DISPLACEMENT: &str = "displacement.nrrd";

/// A folder whose PNG slices do not make a volume.
#[derive(Debug, thiserror::Error)]
pub enum SlicesError {
    /// A file, or the folder itself, cannot be read.
    #[error("{name} cannot be read: {error}")]
    Io {
        /// Which.
        name: String,
        /// Why not.
        error: io::Error,
    },
    /// No slice at all.
    #[error("the folder holds no .png file; a volume is a folder of PNG slices along z")]
    Empty,
    /// Too many, too large.
    #[error(transparent)]
    Size(#[from] VolumeError),
    /// Not a PNG, or a damaged one.
    #[error("{name} is not a sound PNG: {error}")]
    Png {
        /// The slice.
        name: String,
        /// What the decoder says.
        error: png::DecodingError,
    },
    /// More than 8 bits a channel.
    #[error("{name} has 16 bits a channel; save the slices with 8 bits a channel")]
    Deep {
        /// The slice.
        name: String,
    },
    /// A slice of another size than the first one.
    #[error("{name} has {}×{} pixels, but {first} has {}×{}; all slices must be of one size", .found[0], .found[1], .expected[0], .expected[1])]
    Unequal {
        /// The slice.
        name: String,
        /// Its width and height.
        found: [u32; 2],
        /// The first slice.
        first: String,
        /// Its width and height.
        expected: [u32; 2],
    },
    /// `volume.json` does not say which axes tile.
    #[error(transparent)]
    Sidecar(#[from] SidecarError),
    /// The labels that `volume.json` names are wrong.
    #[error(transparent)]
    Labels(#[from] BesideError),
}

pub(super) fn read(folder: &Path) -> Result<SolidTexture, SlicesError> {
    let slices = slices(folder)?;
    let Some((first, _)) = slices.first() else {
        return Err(SlicesError::Empty);
    };
    let sidecar = Sidecar::read(&folder.join(SIDECAR))?;
    let mut voxels = Vec::new();
    let mut expected = [0; 2];
    for (name, path) in &slices {
        let bytes = files::read_whole(path).map_err(|error| SlicesError::Io { name: name.clone(), error })?;
        let found = append(name, &bytes, slices.len() as u64, &mut voxels)?;
        if name == first {
            expected = found;
        } else if found != expected {
            return Err(SlicesError::Unequal { name: name.clone(), found, first: first.clone(), expected });
        }
    }
    let depth = u32::try_from(slices.len()).unwrap_or(u32::MAX);
    let texture = SolidTexture::new([expected[0], expected[1], depth], voxels, [false; 3])?;
    Ok(sidecar.apply(texture, folder)?)
}

/// Name and path of each slice, in natural order of the names.
fn slices(folder: &Path) -> Result<Vec<(String, PathBuf)>, SlicesError> {
    let fail = |error| SlicesError::Io { name: "the folder".into(), error };
    let mut slices = Vec::new();
    for entry in fs::read_dir(folder).map_err(fail)? {
        let path = entry.map_err(fail)?.path();
        let is_png = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"));
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if !is_png || name.starts_with('.') {
            continue;
        }
        slices.push((name, path));
        if slices.len() > MAX_SIDE as usize {
            return Err(VolumeError::Size([1, 1, slices.len() as u64]).into());
        }
    }
    slices.sort_by(|a, b| natural(&a.0, &b.0).then_with(|| a.1.cmp(&b.1)));
    Ok(slices)
}

/// Adds the pixels of one PNG to `voxels` and gives its width and height.
fn append(name: &str, bytes: &[u8], depth: u64, voxels: &mut Vec<[u8; 4]>) -> Result<[u32; 2], SlicesError> {
    let fail = |error| SlicesError::Png { name: name.to_owned(), error };
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    let about = decoder.read_header_info().map_err(fail)?;
    let (width, height) = (about.width, about.height);
    if about.bit_depth == png::BitDepth::Sixteen {
        return Err(SlicesError::Deep { name: name.to_owned() });
    }
    checked_voxels([u64::from(width), u64::from(height), depth])?;
    // Palettes become colours, grey of fewer bits becomes 8-bit grey.
    decoder.set_transformations(png::Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(fail)?;
    let length = reader.output_buffer_size().ok_or_else(|| fail(png::DecodingError::LimitsExceeded))?;
    let mut pixels = vec![0; length];
    let frame = reader.next_frame(&mut pixels).map_err(fail)?;
    // The first frame of an animation may be smaller than the picture.
    if (frame.width, frame.height) != (width, height) {
        let (found, expected) = ([frame.width, frame.height], [width, height]);
        let first = "its own canvas".to_owned();
        return Err(SlicesError::Unequal { name: name.to_owned(), found, first, expected });
    }
    pixels.truncate(frame.buffer_size());
    let n = frame.color_type.samples();
    voxels.extend(pixels.chunks_exact(n).map(rgba));
    Ok([width, height])
}

/// Names in the order in which people count: runs of digits compare as numbers.
fn natural(a: &str, b: &str) -> Ordering {
    let (mut a, mut b) = (a.as_bytes(), b.as_bytes());
    loop {
        let (digits_a, digits_b) = (digits(a), digits(b));
        if digits_a > 0 && digits_b > 0 {
            let number = |s: &[u8], n: usize| {
                let zeros = s[..n].iter().take_while(|&&c| c == b'0').count();
                s[zeros..n].to_vec()
            };
            let (x, y) = (number(a, digits_a), number(b, digits_b));
            let order = x.len().cmp(&y.len()).then_with(|| x.cmp(&y));
            if order != Ordering::Equal {
                return order;
            }
            (a, b) = (&a[digits_a..], &b[digits_b..]);
            continue;
        }
        match (a.split_first(), b.split_first()) {
            (Some((x, rest_a)), Some((y, rest_b))) => {
                if x != y {
                    return x.cmp(y);
                }
                (a, b) = (rest_a, rest_b);
            }
            _ => return a.len().cmp(&b.len()),
        }
    }
}

/// How many digits `text` begins with.
fn digits(text: &[u8]) -> usize {
    text.iter().take_while(|c| c.is_ascii_digit()).count()
}

/// Writes slices (RGBA or grey) to `folder`, which appears whole or not at all. A folder that is there is replaced if it
/// holds nothing but a volume's slices.
pub(super) fn write(folder: &Path, block: &Block<'_>) -> io::Result<()> {
    replaceable(folder)?;
    let beside = beside(folder)?;
    let fresh = beside.path().join("new");
    fs::create_dir(&fresh)?;
    let ([width, height, _], channels) = (block.size, block.channels);
    let slice = width as usize * height as usize * channels as usize;
    for (k, pixels) in block.data.chunks_exact(slice).enumerate() {
        fs::write(fresh.join(slice_name(k as u64)), encode(width, height, channels, None, pixels)?)?;
    }
    let mut names = Names::default();
    if let Some(labels) = block.labels {
        fs::write(fresh.join(LABELS), nrrd::encode_labels(block.size, labels))?;
        names.labels = Some(LABELS.to_owned());
    }
    if let Some(displacement) = block.displacement {
        let grey = Block { channels: 1, data: &displacement.values, ..Block::plain(block.size) };
        fs::write(fresh.join(DISPLACEMENT), nrrd::encode(&grey, &Names::default()))?;
        names.displacement = Some(DISPLACEMENT.to_owned());
    }
    if block.tiles.is_some() {
        let sidecar = Sidecar::new(block, names);
        fs::write(fresh.join(SIDECAR), sidecar.to_bytes())?;
    }
    replace(folder, &fresh)
}

/// The name of slice `k`.
pub(super) fn slice_name(k: u64) -> String {
    format!("slice-{k:04}.png")
}

/// A folder for the time being, in the folder that `path` lies in.
fn beside(path: &Path) -> io::Result<tempfile::TempDir> {
    let parent = match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    };
    tempfile::Builder::new().prefix(".lapis-").tempdir_in(parent)
}

/// Whether a folder of slices stands at `folder` that may be replaced.
///
/// # Errors
/// Something else stands there.
pub(super) fn replaceable(folder: &Path) -> io::Result<bool> {
    match fs::symlink_metadata(folder) {
        Ok(about) if about.is_dir() => only_slices(folder).map(|()| true),
        Ok(_) => Err(io::Error::new(io::ErrorKind::AlreadyExists, "a file, not a folder, has that name")),
        Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(false),
        Err(e) => Err(e),
    }
}

/// Puts the folder `fresh`, which lies on the same disk, in the place of `folder`, as far as that is [`replaceable`].
pub(super) fn replace(folder: &Path, fresh: &Path) -> io::Result<()> {
    let there = replaceable(folder)?;
    let beside = beside(folder)?;
    let old = beside.path().join("old");
    if there {
        fs::rename(folder, &old)?;
    }
    let renamed = fs::rename(fresh, folder);
    if renamed.is_err() && there && fs::rename(&old, folder).is_err() {
        // What was there stays in the folder beside rather than be deleted with it.
        let _ = beside.keep();
    }
    renamed
}

/// An error if replacing the folder would lose a file that is no slice.
fn only_slices(folder: &Path) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let name = entry?.file_name().to_string_lossy().into_owned();
        let number = name.strip_prefix("slice-").and_then(|rest| rest.strip_suffix(".png"));
        let ours = number.is_some_and(|n| digits(n.as_bytes()) == n.len());
        if !ours && ![SIDECAR, LABELS, DISPLACEMENT].contains(&&*name) {
            let message =
                format!("the folder holds {name:?}, which is no slice of a volume; give a new folder");
            return Err(io::Error::new(io::ErrorKind::AlreadyExists, message));
        }
    }
    Ok(())
}

/// A slice as PNG; `metre` is how many of its pixels a metre has along x and y, where it is to be printed.
pub(super) fn encode(
    width: u32,
    height: u32,
    channels: u8,
    metre: Option<[u32; 2]>,
    pixels: &[u8],
) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_pixel_dims(metre.map(|[xppu, yppu]| png::PixelDimensions {
        xppu,
        yppu,
        unit: png::Unit::Meter,
    }));
    encoder.set_color(if channels == 1 { png::ColorType::Grayscale } else { png::ColorType::Rgba });
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header().map_err(io::Error::other)?;
    writer.write_image_data(pixels).map_err(io::Error::other)?;
    writer.finish().map_err(io::Error::other)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn png(
        width: u32,
        height: u32,
        set: impl FnOnce(&mut png::Encoder<&mut Vec<u8>>),
        data: &[u8],
    ) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, width, height);
        set(&mut encoder);
        encoder.write_header().unwrap().write_image_data(data).unwrap();
        bytes
    }

    #[test]
    fn names_are_counted() {
        let mut names = ["b1", "a10.png", "a2.png", "a", "a2b", "a02.png", "a1.png", "10", "9", "b01x"];
        names.sort_by(|a, b| natural(a, b).then_with(|| a.cmp(b)));
        assert_eq!(names, ["9", "10", "a", "a1.png", "a02.png", "a2.png", "a2b", "a10.png", "b1", "b01x"]);
    }

    #[test]
    fn what_is_written_is_read_and_rewritten() {
        let dir = tempfile::tempdir().unwrap();
        let folder = dir.path().join("kiwi");
        for count in [12u32, 3] {
            let data: Vec<u8> = (0..2 * 3 * count * 4).map(|i| i as u8).collect();
            let (size, tiles) = ([2, 3, count], Some([true, false, true]));
            write(&folder, &Block { data: &data, tiles, ..Block::plain(size) }).unwrap();
            let t = read(&folder).unwrap();
            assert_eq!((t.size(), t.tiles()), ([2, 3, count], [true, false, true]));
            assert_eq!(t.voxels().as_flattened(), data);
            assert_eq!(fs::read_dir(&folder).unwrap().count(), count as usize + 1);
            assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
        }
    }

    #[test]
    fn what_is_not_ours_stays() {
        let dir = tempfile::tempdir().unwrap();
        let folder = dir.path().join("home");
        fs::create_dir(&folder).unwrap();
        fs::write(folder.join("thesis.txt"), "years").unwrap();
        let dot = Block { channels: 1, data: &[0], ..Block::plain([1; 3]) };
        let e = write(&folder, &dot).unwrap_err();
        assert!(e.to_string().contains("thesis.txt"));
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
        assert!(write(&folder.join("thesis.txt"), &dot).is_err());
        assert!(write(&dir.path().join("no/where"), &dot).is_err());
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
    }

    #[test]
    fn foreign_pictures() {
        let dir = tempfile::tempdir().unwrap();
        let put = |name: &str, bytes: Vec<u8>| fs::write(dir.path().join(name), bytes).unwrap();
        put("z1.png", png(2, 1, |e| e.set_color(png::ColorType::Grayscale), &[10, 20]));
        put("z2.png", png(2, 1, |e| e.set_color(png::ColorType::Rgb), &[1, 2, 3, 4, 5, 6]));
        put("z3.PNG", png(2, 1, |e| e.set_color(png::ColorType::GrayscaleAlpha), &[1, 2, 3, 4]));
        fn palette(e: &mut png::Encoder<&mut Vec<u8>>) {
            e.set_color(png::ColorType::Indexed);
            e.set_palette(vec![9, 8, 7, 6, 5, 4]);
            e.set_trns(vec![255, 100]);
        }
        put("z10.png", png(2, 1, palette, &[1, 0]));
        put("z11.png", png(2, 1, |e| e.set_depth(png::BitDepth::One), &[0b0100_0000]));
        put("notes.txt", b"not a slice".to_vec());
        let t = read(dir.path()).unwrap();
        assert_eq!((t.size(), t.tiles()), ([2, 1, 5], [false; 3]));
        let expected = [
            [[10, 10, 10, 255], [20, 20, 20, 255]],
            [[1, 2, 3, 255], [4, 5, 6, 255]],
            [[1, 1, 1, 2], [3, 3, 3, 4]],
            [[6, 5, 4, 100], [9, 8, 7, 255]],
            [[0, 0, 0, 255], [255, 255, 255, 255]],
        ];
        assert_eq!(t.voxels(), expected.as_flattened());
    }

    #[test]
    fn faults_are_named() {
        let dir = tempfile::tempdir().unwrap();
        let put = |name: &str, bytes: &[u8]| fs::write(dir.path().join(name), bytes).unwrap();
        assert!(matches!(read(&dir.path().join("gone")), Err(SlicesError::Io { .. })));
        assert!(matches!(read(dir.path()), Err(SlicesError::Empty)));
        let good = png(2, 1, |_| {}, &[1, 2]);
        put("1.png", &good);
        put("2.png", &png(1, 2, |_| {}, &[1, 2]));
        let e = read(dir.path()).unwrap_err().to_string();
        assert_eq!(e, "2.png has 1×2 pixels, but 1.png has 2×1; all slices must be of one size");
        put("2.png", &good[..good.len() - 20]);
        assert!(matches!(read(dir.path()), Err(SlicesError::Png { .. })));
        put("2.png", b"");
        assert!(matches!(read(dir.path()), Err(SlicesError::Png { .. })));
        put("2.png", &png(2, 1, |e| e.set_depth(png::BitDepth::Sixteen), &[0; 4]));
        assert!(matches!(read(dir.path()), Err(SlicesError::Deep { .. })));
        put("2.png", &png(5000, 1, |_| {}, &[0; 5000]));
        assert!(matches!(read(dir.path()), Err(SlicesError::Size(_))));
        put("2.png", &good);
        for wrong in ["{\"tiles\": \"w\"}", "{}", "{\"tile\": \"x\"}", "xz"] {
            put(SIDECAR, wrong.as_bytes());
            assert!(matches!(read(dir.path()), Err(SlicesError::Sidecar(_))), "{wrong}");
        }
    }
}
