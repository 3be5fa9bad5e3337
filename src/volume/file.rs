//! Reading and writing solid textures and masks, by the kind of path.

use std::io;
use std::path::{Path, PathBuf};

use super::arrays::{self, ArrayError};
use super::beside::{Beside, plain_name};
use super::block::{Block, Names};
use super::mask::AlphaMask;
use super::nrrd::{self, NrrdError};
use super::sidecar::Sidecar;
use super::slices::{self, SlicesError};
use super::texture::SolidTexture;
use crate::files;

/// A file or folder that does not give a volume.
#[derive(Debug, thiserror::Error)]
pub enum VolumeReadError {
    /// It cannot be read at all.
    #[error("cannot read {path}: {error}")]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        error: io::Error,
    },
    /// Neither the name nor the content is a volume's.
    #[error(
        "{path} is no volume; give an NRRD file (.nrrd), an array of NumPy (.npy), or a folder of PNG slices along z"
    )]
    Unknown {
        /// The file.
        path: PathBuf,
    },
    /// An NRRD file that is broken, or of a kind that Lapis does not read.
    #[error("{path}: {error}")]
    Nrrd {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        error: NrrdError,
    },
    /// An NPY file that is broken, or no volume.
    #[error("{path}: {error}")]
    Array {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        error: ArrayError,
    },
    /// A folder whose slices make no volume.
    #[error("{path}: {error}")]
    Slices {
        /// The folder.
        path: PathBuf,
        /// What is wrong.
        error: SlicesError,
    },
    /// A mask that has colours.
    #[error("{path}: voxel ({}, {}, {}) is coloured; a mask is grey, white where it is opaque", .voxel[0], .voxel[1], .voxel[2])]
    Coloured {
        /// The file or folder.
        path: PathBuf,
        /// The first coloured voxel, counted from 0.
        voxel: [u32; 3],
    },
}

/// A volume that cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum VolumeWriteError {
    /// The path does not say how.
    #[error("{path} names no kind of volume; end it in .nrrd or .npy, or in / for a folder of PNG slices")]
    Unknown {
        /// Where it should have gone.
        path: PathBuf,
    },
    /// A file of labels or displacements whose name the volume cannot hold.
    #[error(
        "{path} cannot be named by the volume whose particle labels or displacement it would hold; give the volume a name of letters, \
         digits, spaces, '-', '_' and '.'"
    )]
    BesideName {
        /// Where they should have gone.
        path: PathBuf,
    },
    /// The system refuses.
    #[error("cannot write {path}: {error}")]
    Io {
        /// Where it should have gone.
        path: PathBuf,
        /// What the system says.
        error: io::Error,
    },
}

/// Reads a solid texture: an NRRD file of 8-bit voxels (grey, RGB or RGBA), an NPY file of bytes `[z, y, x, 4]`, or a
/// folder of 8-bit PNG slices along z in natural order of their names, row 0 at y = 0. Grey is spread over the three
/// colours, and without an alpha channel every voxel is opaque. A volume that does not say along which axes it tiles
/// (key `lapis_tiles` of an NRRD, `NAME.volume.json` beside `NAME.npy`, `volume.json` among slices) tiles nowhere;
/// [`SolidTexture::with_tiles`] tells better. Particle labels are read from the file of the same folder that the
/// volume names (key `lapis_labels`, or `labels` in the JSON).
///
/// # Errors
/// [`VolumeReadError`], which names the file, the place in it and what would help. Sizes are checked before
/// memory is taken.
pub fn read(path: &Path) -> Result<SolidTexture, VolumeReadError> {
    if path.is_dir() {
        return slices::read(path).map_err(|error| VolumeReadError::Slices { path: path.to_owned(), error });
    }
    let bytes =
        files::read_whole(path).map_err(|error| VolumeReadError::Io { path: path.to_owned(), error })?;
    if has_extension(path, "npy") {
        return arrays::decode(path, &bytes)
            .map_err(|error| VolumeReadError::Array { path: path.to_owned(), error });
    }
    let named = has_extension(path, "nrrd") || has_extension(path, "nhdr");
    if !named && !bytes.starts_with(b"NRRD") {
        return Err(VolumeReadError::Unknown { path: path.to_owned() });
    }
    nrrd::decode(&bytes, |name| files::read_whole(&path.with_file_name(name)))
        .map_err(|error| VolumeReadError::Nrrd { path: path.to_owned(), error })
}

/// Reads a mask in any form that [`read`] takes. It must be grey; the opacity is the grey value times the
/// alpha of the file, where it has one (so both white on black and white on clear are understood).
///
/// # Errors
/// [`VolumeReadError`].
pub fn read_mask(path: &Path) -> Result<AlphaMask, VolumeReadError> {
    let texture = read(path)?;
    let voxels = texture.voxels();
    if let Some(at) = voxels.iter().position(|&[r, g, b, _]| r != g || g != b) {
        let [nx, ny, _] = texture.size().map(|n| n as usize);
        #[allow(clippy::cast_possible_truncation)] // sides are at most 4096
        let voxel = [at % nx, at / nx % ny, at / (nx * ny)].map(|i| i as u32);
        return Err(VolumeReadError::Coloured { path: path.to_owned(), voxel });
    }
    #[allow(clippy::cast_possible_truncation)] // at most 255
    let alpha =
        voxels.iter().map(|&[g, _, _, a]| ((u32::from(g) * u32::from(a) + 127) / 255) as u8).collect();
    Ok(AlphaMask::new(texture.size(), alpha).expect("as many values as the texture has voxels"))
}

/// Writes a solid texture: to one file where `path` ends in `.nrrd`, to two where it ends in `.npy`, to a folder of PNG
/// slices where it ends in `/` or has no extension; particle labels go to one file more. All appear or none; a folder
/// that is there is replaced only if it holds nothing but slices.
///
/// # Errors
/// [`VolumeWriteError`].
pub fn write(path: &Path, texture: &SolidTexture) -> Result<(), VolumeWriteError> {
    write_block(path, &texture.into())
}

/// The files that a solid texture is written to where `path` ends in `.nrrd` or `.npy`, and their bytes: `path` comes
/// last, before it the files beside it that it needs, as those of its labels and its displacement, [`Beside::path`].
///
/// # Errors
/// [`VolumeWriteError::Unknown`], [`VolumeWriteError::BesideName`].
pub fn to_files(path: &Path, texture: &SolidTexture) -> Result<Vec<(PathBuf, Vec<u8>)>, VolumeWriteError> {
    block_files(path, &texture.into())
}

/// The colours of a solid texture as the bytes of an NRRD file, which [`read`] reads. Its labels are not in it:
/// [`to_files`] has them.
#[must_use]
pub fn to_nrrd(texture: &SolidTexture) -> Vec<u8> {
    nrrd::encode(&texture.into(), &Names::default())
}

/// Writes a mask, in grey, in the same ways as [`write()`].
///
/// # Errors
/// [`VolumeWriteError`].
pub fn write_mask(path: &Path, mask: &AlphaMask) -> Result<(), VolumeWriteError> {
    write_block(path, &mask.into())
}

fn write_block(path: &Path, block: &Block<'_>) -> Result<(), VolumeWriteError> {
    let folder = path.as_os_str().to_string_lossy().ends_with(std::path::is_separator);
    if folder || path.extension().is_none() {
        return slices::write(path, block)
            .map_err(|error| VolumeWriteError::Io { path: path.to_owned(), error });
    }
    let written = block_files(path, block)?;
    let written: Vec<(&Path, &[u8])> = written.iter().map(|(path, bytes)| (&**path, &**bytes)).collect();
    files::write_all(&written).map_err(|e| VolumeWriteError::Io { path: e.path, error: e.source })
}

fn block_files(path: &Path, block: &Block<'_>) -> Result<Vec<(PathBuf, Vec<u8>)>, VolumeWriteError> {
    let nrrd = has_extension(path, "nrrd");
    if !nrrd && !has_extension(path, "npy") {
        return Err(VolumeWriteError::Unknown { path: path.to_owned() });
    }
    let mut all = Vec::new();
    let labels = block.labels.map(|labels| {
        let encode = if nrrd { nrrd::encode_labels } else { arrays::encode_labels };
        (Beside::Labels, encode(block.size, labels))
    });
    let displacement = block.displacement.map(|displacement| {
        let grey = Block { channels: 1, data: &displacement.values, ..Block::plain(block.size) };
        let bytes = if nrrd { nrrd::encode(&grey, &Names::default()) } else { arrays::encode(&grey) };
        (Beside::Displacement, bytes)
    });
    let mut name = |file: Option<(Beside, Vec<u8>)>| match file {
        None => Ok(None),
        Some((of, bytes)) => {
            let beside = of.path(path);
            let name = storable_name(&beside)?;
            all.push((beside, bytes));
            Ok(Some(name))
        }
    };
    let names = Names { labels: name(labels)?, displacement: name(displacement)? };
    if nrrd {
        all.push((path.to_owned(), nrrd::encode(block, &names)));
        return Ok(all);
    }
    if block.tiles.is_some() {
        all.push((arrays::sidecar_path(path), Sidecar::new(block, names).to_bytes()));
    }
    all.push((path.to_owned(), arrays::encode(block)));
    Ok(all)
}

/// The name of a file beside a volume, as it will be read: the rest of a line without the spaces around it.
fn storable_name(beside: &Path) -> Result<String, VolumeWriteError> {
    let plain = beside.file_name().and_then(|name| name.to_str()).filter(|name| {
        plain_name(name) == Some(*name) && name.trim() == *name && !name.contains(char::is_control)
    });
    let name = || VolumeWriteError::BesideName { path: beside.to_owned() };
    plain.map(str::to_owned).ok_or_else(name)
}

fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension))
}

#[cfg(test)]
mod tests {
    use super::super::SplotchParams;
    use super::*;

    fn texture() -> SolidTexture {
        let voxels = (0..24u8).map(|i| [i, 2 * i, 255 - i, 200 + i]).collect();
        SolidTexture::new([2, 3, 4], voxels, [true, false, true]).unwrap()
    }

    #[test]
    fn both_kinds_of_path() {
        let dir = tempfile::tempdir().unwrap();
        for name in ["a.nrrd", "b.NRRD", "slices", "v1.2/"] {
            let path = dir.path().join(name);
            write(&path, &texture()).unwrap();
            assert_eq!(read(&path).unwrap(), texture(), "{name}");
        }
        assert!(dir.path().join("v1.2/slice-0003.png").is_file());
        assert!(matches!(
            write(&dir.path().join("a.tiff"), &texture()),
            Err(VolumeWriteError::Unknown { .. })
        ));
        assert!(matches!(write(&dir.path().join("no/a.nrrd"), &texture()), Err(VolumeWriteError::Io { .. })));
        assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 4);
    }

    #[test]
    fn masks_are_grey() {
        let dir = tempfile::tempdir().unwrap();
        let mask = AlphaMask::splotch(&SplotchParams { size: 32, ..SplotchParams::default() }, 1);
        for name in ["mask.nrrd", "mask"] {
            let path = dir.path().join(name);
            write_mask(&path, &mask).unwrap();
            assert_eq!(read_mask(&path).unwrap(), mask);
        }
        let path = dir.path().join("white-on-clear.nrrd");
        let voxels = mask.alpha().iter().map(|&a| [255, 255, 255, a]).collect();
        write(&path, &SolidTexture::new([32; 3], voxels, [false; 3]).unwrap()).unwrap();
        assert_eq!(read_mask(&path).unwrap(), mask);
        write(&path, &texture()).unwrap();
        assert!(matches!(read_mask(&path), Err(VolumeReadError::Coloured { voxel: [0, 0, 0], .. })));
    }

    #[test]
    fn faults_name_the_file() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.obj");
        assert!(matches!(read(&path), Err(VolumeReadError::Io { .. })));
        std::fs::write(&path, "v 0 0 0").unwrap();
        let e = read(&path).unwrap_err();
        assert!(e.to_string().contains("a.obj is no volume"), "{e}");
        let path = dir.path().join("a.nrrd");
        std::fs::write(&path, "").unwrap();
        assert!(matches!(read(&path), Err(VolumeReadError::Nrrd { .. })));
        assert!(matches!(read(dir.path()), Err(VolumeReadError::Slices { .. })));
        // Voxels in a file beside the header.
        std::fs::write(
            &path,
            "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1 1 2\nencoding: raw\ndata file: b\n",
        )
        .unwrap();
        assert!(matches!(read(&path), Err(VolumeReadError::Nrrd { .. })));
        std::fs::write(dir.path().join("b"), [3, 4]).unwrap();
        assert_eq!(read(&path).unwrap().voxel(0, 0, 1), [4, 4, 4, 255]);
    }
}
