//! What is wrong with an NRRD file.

use std::io;

use super::header::MAX_HEADER;
use crate::volume::beside::BesideError;
use crate::volume::texture::VolumeError;

/// Bytes that are not an NRRD volume of 8-bit voxels.
#[derive(Debug, thiserror::Error)]
pub enum NrrdError {
    /// The first line is another.
    #[error("it is not an NRRD file: its first line is not NRRD0001 to NRRD0005")]
    Magic,
    /// No blank line.
    #[error(
        "the header does not end: no blank line in its first {MAX_HEADER} bytes, nor a `data file` field"
    )]
    Endless,
    /// Neither field nor key nor comment.
    #[error("line {line} of the header is neither `field: value`, `key:=value` nor a # comment: {text:?}")]
    Line {
        /// Counted from 1.
        line: usize,
        /// How it begins.
        text: String,
    },
    /// A field that every file needs.
    #[error("the header has no field `{0}`")]
    Missing(&'static str),
    /// A field or key given twice.
    #[error("line {line} of the header gives `{name}` a second time")]
    Twice {
        /// Counted from 1.
        line: usize,
        /// Field or key.
        name: String,
    },
    /// A value that makes no sense, or that Lapis does not read.
    #[error("line {line} of the header, `{name}: {value}`: {problem}")]
    Value {
        /// Counted from 1.
        line: usize,
        /// Field or key.
        name: &'static str,
        /// Its value.
        value: String,
        /// What is wrong, and what would help.
        problem: String,
    },
    /// Sides that no volume can have.
    #[error("line {line} of the header, `sizes`: {error}")]
    Size {
        /// Counted from 1.
        line: usize,
        /// What is wrong with them.
        error: VolumeError,
    },
    /// Less data than the header promises.
    #[error("the header promises {expected} bytes of voxels, but only {found} are there")]
    TooLittle {
        /// Bytes promised.
        expected: u64,
        /// Bytes found.
        found: u64,
    },
    /// More data than the header promises.
    #[error("the header promises {expected} bytes of voxels, but more are there")]
    TooMuch {
        /// Bytes promised.
        expected: u64,
    },
    /// gzip data that do not unpack.
    #[error("the gzip data are damaged: {0}")]
    Gzip(io::Error),
    /// Text that is not a number from 0 to 255.
    #[error("value {index} of the text data is {text:?}; it must be a whole number from 0 to 255")]
    Text {
        /// Counted from 0.
        index: u64,
        /// What stands there.
        text: String,
    },
    /// The file that holds the voxels cannot be read.
    #[error("its data file {name:?} cannot be read: {error}")]
    DataFile {
        /// As the header names it.
        name: String,
        /// Why not.
        error: io::Error,
    },
    /// The file that holds the particle labels or the displacement does not fit.
    #[error("line {line} of the header, `{key}`: {error}")]
    Beside {
        /// Counted from 1.
        line: usize,
        /// The key that names it.
        key: &'static str,
        /// What is wrong with it.
        error: BesideError,
    },
}
