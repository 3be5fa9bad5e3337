//! Files beside a volume that its own file names: what it has for each voxel besides a colour.

use std::io;
use std::path::{Path, PathBuf};

use super::npy::{self, NpyError, Number};
use super::nrrd::NrrdError;

/// What a file beside a volume holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Beside {
    /// The particle label of each voxel.
    Labels,
    /// How far each voxel stands out.
    Displacement,
}

impl Beside {
    /// `label` or `displacement`: what its file is called in messages.
    fn name(self) -> &'static str {
        match self {
            Self::Labels => "label",
            Self::Displacement => "displacement",
        }
    }

    /// What is put behind the name of the volume.
    fn suffix(self) -> &'static str {
        match self {
            Self::Labels => "-labels",
            Self::Displacement => "-displacement",
        }
    }

    /// Where it lies of a volume that is written to the file `path`: beside it, with `-labels` or `-displacement` in
    /// the name.
    #[must_use]
    pub fn path(self, path: &Path) -> PathBuf {
        let mut name = path.file_stem().unwrap_or_default().to_owned();
        name.push(self.suffix());
        if let Some(extension) = path.extension() {
            name.push(".");
            name.push(extension);
        }
        path.with_file_name(name)
    }
}

/// A file of particle labels or of displacements that does not fit the volume that names it.
#[derive(Debug, thiserror::Error)]
pub enum BesideError {
    /// More than a name, so that it might lie anywhere.
    #[error(
        "the {} file {name:?} must be the plain name of a file in the same folder; move the file there",
        of.name()
    )]
    Name {
        /// What it holds.
        of: Beside,
        /// As the volume names it.
        name: String,
    },
    /// It cannot be read.
    #[error(
        "the {} file {name:?} cannot be read: {error}; it belongs beside the volume that names it",
        of.name()
    )]
    Io {
        /// What it holds.
        of: Beside,
        /// As the volume names it.
        name: String,
        /// Why not.
        error: io::Error,
    },
    /// An NRRD file that is broken, or one of something else.
    #[error("the {} file {name:?}: {error}", of.name())]
    Nrrd {
        /// What it should hold.
        of: Beside,
        /// As the volume names it.
        name: String,
        /// What is wrong.
        error: Box<NrrdError>,
    },
    /// An NPY file that is broken, or one of something else.
    #[error("the {} file {name:?}: {error}", of.name())]
    Npy {
        /// What it should hold.
        of: Beside,
        /// As the volume names it.
        name: String,
        /// What is wrong.
        error: NpyError,
    },
    /// That of another volume.
    #[error("the {} file {name:?} has sides of {found:?} voxels, but the volume has {}×{}×{}; there must be a number for each voxel", of.name(), .expected[0], .expected[1], .expected[2])]
    Size {
        /// What it holds.
        of: Beside,
        /// As the volume names it.
        name: String,
        /// Its sides, x first.
        found: Vec<u64>,
        /// Those of the volume.
        expected: [u32; 3],
    },
}

/// `name`, if it can only be a file of the folder in which it is named.
pub(super) fn plain_name(name: &str) -> Option<&str> {
    let name = name.strip_prefix("./").unwrap_or(name);
    let plain = !matches!(name, "" | "." | "..") && !name.contains(['/', '\\', ':', '\0']);
    plain.then_some(name)
}

/// A number for each voxel of a volume of `size`, from the file `name`; `open` reads a file of the volume's folder, `nrrd`
/// understands one that is no array of NumPy: its sides, and its numbers where these are the volume's.
pub(super) fn read<T: Number>(
    of: Beside,
    name: &str,
    size: [u32; 3],
    open: impl Fn(&str) -> io::Result<Vec<u8>>,
    nrrd: impl FnOnce(&[u8], &dyn Fn([u64; 3]) -> bool) -> Result<([u64; 3], Option<Vec<T>>), NrrdError>,
) -> Result<Vec<T>, BesideError> {
    let owned = || name.to_owned();
    let plain = plain_name(name).ok_or_else(|| BesideError::Name { of, name: owned() })?;
    let bytes = open(plain).map_err(|error| BesideError::Io { of, name: owned(), error })?;
    let fits = |found: &[u64]| found.iter().copied().eq(size.map(u64::from));
    let other =
        |found: &[u64]| BesideError::Size { of, name: owned(), found: found.to_vec(), expected: size };
    if Path::new(plain).extension().is_some_and(|e| e.eq_ignore_ascii_case("npy")) {
        let array = npy::Array::parse::<T>(&bytes);
        let array = array.map_err(|error| BesideError::Npy { of, name: owned(), error })?;
        let sides: Vec<u64> = array.shape.iter().rev().copied().collect();
        return if fits(&sides) { Ok(array.numbers()) } else { Err(other(&sides)) };
    }
    let wrong = |error| BesideError::Nrrd { of, name: owned(), error: Box::new(error) };
    let (sides, numbers) = nrrd(&bytes, &|sides| fits(&sides)).map_err(wrong)?;
    numbers.ok_or_else(|| other(&sides))
}
