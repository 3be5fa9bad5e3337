//! The map of where each voxel was copied from, as a file of NumPy.

use std::io;
use std::path::{Path, PathBuf};

use crate::files;

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
    #[error("{} is no source map: {problem}; it must be an NPY file of 32-bit unsigned integers ('<u4')", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        problem: &'static str,
    },
}

/// Reads an NPY file of little-endian 32-bit unsigned integers, of any shape, in C order: the number of the photographs'
/// pixel that each voxel was copied from.
///
/// # Errors
/// [`SourceError`] names the file. Sizes are checked before memory is taken.
pub fn read_source(path: &Path) -> Result<Vec<u32>, SourceError> {
    let bytes = files::read_whole(path).map_err(|error| SourceError::Io { path: path.to_owned(), error })?;
    decode(&bytes).map_err(|problem| SourceError::Format { path: path.to_owned(), problem })
}

fn decode(bytes: &[u8]) -> Result<Vec<u32>, &'static str> {
    let rest = bytes.strip_prefix(b"\x93NUMPY").ok_or("it does not begin as an NPY file does")?;
    let (length, rest) = match rest {
        [1, _, a, b, rest @ ..] => (usize::from(u16::from_le_bytes([*a, *b])), rest),
        [2 | 3, _, a, b, c, d, rest @ ..] => (u32::from_le_bytes([*a, *b, *c, *d]) as usize, rest),
        _ => return Err("its version is not known"),
    };
    let (header, data) = rest.split_at_checked(length).ok_or("its header ends early")?;
    let header: String = String::from_utf8_lossy(header).split_whitespace().collect();
    if !header.contains("'descr':'<u4'") {
        return Err("its numbers are of another type");
    }
    if !header.contains("'fortran_order':False") {
        return Err("it is in Fortran's order");
    }
    let shape =
        header.split_once("'shape':(").and_then(|(_, s)| s.split_once(')')).ok_or("it has no shape")?.0;
    let mut sides = shape.split(',').filter(|s| !s.is_empty()).map(str::parse::<usize>);
    let count = sides
        .try_fold(1usize, |n, side| side.ok().and_then(|side| n.checked_mul(side)))
        .ok_or("its shape is no list of sizes")?;
    if data.len() / 4 != count || !data.len().is_multiple_of(4) {
        return Err("its data have another length than its shape says");
    }
    Ok(data.as_chunks().0.iter().map(|b| u32::from_le_bytes(*b)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn npy(header: &str, data: &[u8]) -> Vec<u8> {
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.extend(data);
        bytes
    }

    #[test]
    fn arrays_of_any_shape() {
        let data: Vec<u8> = (0..6u32).flat_map(u32::to_le_bytes).collect();
        let good = npy("{'descr': '<u4', 'fortran_order': False, 'shape': (1, 2, 3), }\n", &data);
        assert_eq!(decode(&good), Ok(vec![0, 1, 2, 3, 4, 5]));
        let flat = npy("{'descr': '<u4', 'fortran_order': False, 'shape': (6,), }\n", &data);
        assert_eq!(decode(&flat), Ok(vec![0, 1, 2, 3, 4, 5]));
        for n in 0..good.len() {
            assert!(decode(&good[..n]).is_err(), "{n} bytes");
        }
        let huge = "{'descr': '<u4', 'fortran_order': False, 'shape': (99999999999, 99999999999), }";
        assert!(decode(&npy(huge, &data)).is_err());
        assert!(decode(&npy("{'descr': '<f4', 'fortran_order': False, 'shape': (6,), }", &data)).is_err());
    }
}
