//! The map of where each voxel was copied from, as a file of NumPy.

use std::io;
use std::path::{Path, PathBuf};

use crate::files;
use crate::volume::NpyError;
use crate::volume::npy::Array;

/// A source map that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum SourceError {
    /// It cannot be read at all.
    #[error("cannot read {}: {error}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        error: io::Error,
    },
    /// It is no array of pixels' numbers.
    #[error("{} is no source map, an NPY file of 32-bit unsigned integers ('<u4'): {problem}", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        problem: NpyError,
    },
}

/// Reads an NPY file of little-endian 32-bit unsigned integers, of any shape, in C order: the number of the photographs'
/// pixel that each voxel was copied from.
///
/// # Errors
/// [`SourceError`] names the file. Sizes are checked before memory is taken.
pub fn read_source(path: &Path) -> Result<Vec<u32>, SourceError> {
    let bytes = files::read_whole(path).map_err(|error| SourceError::Io { path: path.to_owned(), error })?;
    let array = Array::parse::<u32>(&bytes);
    let array = array.map_err(|problem| SourceError::Format { path: path.to_owned(), problem })?;
    Ok(array.numbers())
}
