//! What can be wrong with a file of tetrahedra.

use std::io;
use std::path::{Path, PathBuf};

use crate::files::WriteError;
use crate::mesh::{Place, TopologyError};

/// Why tetrahedra could not be read from, or written to, a file.
#[derive(Debug, thiserror::Error)]
pub enum TetFileError {
    /// The file system refused.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the file system said.
        source: io::Error,
    },
    /// The name's ending names no format.
    #[error("{}: tetrahedra are {doing}, by the name's ending", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// The formats that exist, in words.
        doing: &'static str,
    },
    /// The file is not what its format asks for, or uses a part of it that is not read.
    #[error("{}: {place}{what}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Where.
        place: Place,
        /// What is wrong there, and what would help.
        what: String,
    },
    /// The tetrahedra are no mesh.
    #[error("{}: {source}", path.display())]
    Topology {
        /// The file that names the tetrahedra.
        path: PathBuf,
        /// What is wrong with them; tetrahedra and vertices are counted from 0.
        source: TopologyError,
    },
}

impl From<WriteError> for TetFileError {
    fn from(e: WriteError) -> Self {
        Self::Io { path: e.path, source: e.source }
    }
}

/// What is wrong, and where, in a file whose name the caller knows.
#[derive(Debug)]
pub(crate) struct Fault {
    pub(super) place: Place,
    pub(crate) what: String,
}

impl Fault {
    pub(super) fn new(place: Place, what: impl Into<String>) -> Self {
        Self { place, what: what.into() }
    }

    pub(super) fn line(line: usize, what: impl Into<String>) -> Self {
        Self::new(Place::Line(line), what)
    }

    pub(super) fn whole(what: impl Into<String>) -> Self {
        Self::new(Place::Whole, what)
    }

    pub(super) fn at(self, path: &Path) -> TetFileError {
        TetFileError::Malformed { path: path.to_owned(), place: self.place, what: self.what }
    }
}

/// The line, counted from 1, that the byte `at` lies in.
pub(super) fn line_of(bytes: &[u8], at: usize) -> usize {
    1 + bytes[..at.min(bytes.len())].iter().filter(|b| **b == b'\n').count()
}
