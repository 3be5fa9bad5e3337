//! The particle labels of a volume, in a file of their own that the volume's file names.

use std::io;
use std::path::{Path, PathBuf};

use super::npy::{self, NpyError};
use super::nrrd::{self, NrrdError};

/// A file of particle labels that does not fit the volume that names it.
#[derive(Debug, thiserror::Error)]
pub enum LabelsError {
    /// More than a name, so that it might lie anywhere.
    #[error(
        "the label file {name:?} must be the plain name of a file in the same folder; move the file there"
    )]
    Name {
        /// As the volume names it.
        name: String,
    },
    /// It cannot be read.
    #[error("the label file {name:?} cannot be read: {error}; it belongs beside the volume that names it")]
    Io {
        /// As the volume names it.
        name: String,
        /// Why not.
        error: io::Error,
    },
    /// An NRRD file that is broken, or not one of labels.
    #[error("the label file {name:?}: {error}")]
    Nrrd {
        /// As the volume names it.
        name: String,
        /// What is wrong.
        error: Box<NrrdError>,
    },
    /// An NPY file that is broken, or not one of labels.
    #[error("the label file {name:?}: {error}")]
    Npy {
        /// As the volume names it.
        name: String,
        /// What is wrong.
        error: NpyError,
    },
    /// Labels of another volume.
    #[error("the label file {name:?} has sides of {found:?} voxels, but the volume has {}×{}×{}; there must be a label for each voxel", .expected[0], .expected[1], .expected[2])]
    Size {
        /// As the volume names it.
        name: String,
        /// Its sides, x first.
        found: Vec<u64>,
        /// Those of the volume.
        expected: [u32; 3],
    },
}

/// Where the labels of a volume that is written to the file `path` lie: beside it, with `-labels` in the name.
#[must_use]
pub fn labels_path(path: &Path) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push("-labels");
    if let Some(extension) = path.extension() {
        name.push(".");
        name.push(extension);
    }
    path.with_file_name(name)
}

/// `name`, if it can only be a file of the folder in which it is named.
pub(super) fn plain_name(name: &str) -> Option<&str> {
    let name = name.strip_prefix("./").unwrap_or(name);
    let plain = !matches!(name, "" | "." | "..") && !name.contains(['/', '\\', ':', '\0']);
    plain.then_some(name)
}

/// The labels of a volume of `size` voxels in the file `name`; `open` reads a file of its folder.
pub(super) fn read(
    name: &str,
    size: [u32; 3],
    open: impl Fn(&str) -> io::Result<Vec<u8>>,
) -> Result<Vec<u32>, LabelsError> {
    let owned = || name.to_owned();
    let plain = plain_name(name).ok_or_else(|| LabelsError::Name { name: owned() })?;
    let bytes = open(plain).map_err(|error| LabelsError::Io { name: owned(), error })?;
    let fits = |found: &[u64]| {
        let fits = found.iter().copied().eq(size.map(u64::from));
        let error = || LabelsError::Size { name: owned(), found: found.to_vec(), expected: size };
        if fits { Ok(()) } else { Err(error()) }
    };
    if Path::new(plain).extension().is_some_and(|e| e.eq_ignore_ascii_case("npy")) {
        let array = npy::Array::parse::<u32>(&bytes);
        let array = array.map_err(|error| LabelsError::Npy { name: owned(), error })?;
        let sides: Vec<u64> = array.shape.iter().rev().copied().collect();
        fits(&sides)?;
        return Ok(array.numbers());
    }
    let wrong = |error| LabelsError::Nrrd { name: owned(), error: Box::new(error) };
    let file = nrrd::LabelFile::parse(&bytes).map_err(wrong)?;
    fits(&file.size())?;
    file.labels(open).map_err(wrong)
}
