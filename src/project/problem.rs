//! What can be wrong with a project file.

use std::path::PathBuf;

use super::part_error::PartError;
use super::unknown::Complaint;
use crate::export::ExportError;
use crate::render::RenderError;
use crate::view::{CameraError, StrokeError, ViewFileError};

/// A project file that cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("the project file {} cannot be used", path.display())]
pub struct ProjectError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong with it.
    #[source]
    pub problem: Box<ProjectProblem>,
}

/// What is wrong with a project file.
#[derive(Debug, thiserror::Error)]
pub enum ProjectProblem {
    /// It cannot be read.
    #[error("it cannot be read: {0}")]
    Io(#[from] std::io::Error),
    /// It is not text.
    #[error("it is not a text file: byte {0} is not UTF-8")]
    NotText(usize),
    /// A key or a value is wrong.
    #[error(transparent)]
    Toml(#[from] Complaint),
    /// A name that cannot be part of a file's name.
    #[error("{key} = \"{name}\": a name has letters, digits, '-' and '_' only")]
    Name {
        /// The key.
        key: String,
        /// The name.
        name: String,
    },
    /// A name that is given twice.
    #[error("two {kind}s are named '{name}'")]
    Twice {
        /// `cut`, `picture`, `part` or `export format`.
        kind: &'static str,
        /// The name.
        name: String,
    },
    /// A region of the mesh painted twice.
    #[error("{} and {} both paint the region '{name}'; keep one of them", keys[0], keys[1])]
    TwoRegions {
        /// The tables.
        keys: [String; 2],
        /// The region.
        name: String,
    },
    /// A model that nobody makes.
    #[error("{key} names '{name}', which is neither 'whole' nor {known}")]
    NoModel {
        /// The key.
        key: String,
        /// The name.
        name: String,
        /// What could be named.
        known: String,
    },
    /// A part that there is not.
    #[error("{key} names '{name}', which is no part of the project: {known}")]
    NoPart {
        /// The key.
        key: String,
        /// The name.
        name: String,
        /// What could be named.
        known: String,
    },
    /// Something wrong in one part of several.
    #[error("in the part '{name}': {problem}")]
    OfPart {
        /// The part.
        name: String,
        /// What is wrong.
        #[source]
        problem: Box<ProjectProblem>,
    },
    /// A number out of its range.
    #[error("{key} = {value}: {range}")]
    Range {
        /// The key.
        key: String,
        /// The number.
        value: f64,
        /// What it must be.
        range: &'static str,
    },
    /// Too few or too many keys of a choice.
    #[error("{key}: {choice}")]
    Choice {
        /// The table.
        key: String,
        /// What must be chosen.
        choice: &'static str,
    },
    /// A camera that cannot see.
    #[error("{key}")]
    Camera {
        /// The table.
        key: String,
        /// What is wrong with it.
        source: CameraError,
    },
    /// A stroke that cannot be used.
    #[error("{key}")]
    Stroke {
        /// The table.
        key: String,
        /// What is wrong with it.
        source: StrokeError,
    },
    /// A stroke file that cannot be used.
    #[error("{key}")]
    StrokeFile {
        /// The table.
        key: String,
        /// What is wrong with it.
        source: Box<ViewFileError>,
    },
    /// A picture's settings that cannot be.
    #[error("{key}")]
    Render {
        /// The table.
        key: String,
        /// What is wrong with it.
        source: RenderError,
    },
    /// An export's settings that cannot be.
    #[error("{key}")]
    Export {
        /// The table.
        key: String,
        /// What is wrong with it.
        source: ExportError,
    },
    /// The texture's type and the inputs do not fit together.
    #[error(transparent)]
    Part(#[from] PartError),
}
