//! What can be wrong with a mesh file.

use std::fmt;
use std::io;

use super::{MAX_MESH_ELEMENTS, MESH_EXTENSIONS};

/// Where in a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Place {
    /// This line, the first being 1.
    Line(usize),
    /// This byte, the first being 0.
    Byte(usize),
    /// This part, by its name.
    Part(String),
    /// No single place.
    Whole,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(n) => write!(f, "line {n}: "),
            Self::Byte(n) => write!(f, "byte {n}: "),
            Self::Part(name) => write!(f, "{name}: "),
            Self::Whole => Ok(()),
        }
    }
}

/// What is wrong with a mesh file.
#[derive(Debug, thiserror::Error)]
pub enum MeshFault {
    /// The system could not read it.
    #[error("{0}")]
    Io(#[from] io::Error),
    /// The extension names no format that is known.
    #[error("{}; meshes are read from {}", extension_said(.0), extensions_known())]
    Extension(String),
    /// It has no bytes.
    #[error("the file is empty")]
    Empty,
    /// It is not what its format asks for.
    #[error("{place}{what}")]
    Malformed {
        /// Where.
        place: Place,
        /// What is wrong.
        what: String,
    },
    /// It uses a part of its format that is not read.
    #[error("{what} is not supported; {help}")]
    Unsupported {
        /// The part.
        what: String,
        /// What would help.
        help: &'static str,
    },
    /// A coordinate is NaN or infinite.
    #[error("{place}vertex {vertex} (the first is {first}) has a coordinate that is not a finite number")]
    NotFinite {
        /// Where.
        place: Place,
        /// Its number, counted as the format does.
        vertex: usize,
        /// The number of the first vertex: 1 in an OBJ file, else 0.
        first: usize,
    },
    /// A face names a vertex that is not there.
    #[error(
        "{place}face {face} (the first is {first}) names vertex {index}, but the {count} vertices are numbered \
         {first} to {}", *first as i64 + *count as i64 - 1
    )]
    Index {
        /// Where.
        place: Place,
        /// Its number, counted as the format does.
        face: usize,
        /// The index as the file has it.
        index: i64,
        /// The number of the first vertex and of the first face: 1 in an OBJ file, else 0.
        first: usize,
        /// How many vertices there are.
        count: usize,
    },
    /// Nothing to fill.
    #[error("it has {vertices} vertices but no faces, and a solid needs a surface{}",
        notes.iter().map(|note| format!("; {note}")).collect::<String>())]
    NoFaces {
        /// How many vertices it has.
        vertices: usize,
        /// What was passed over.
        notes: Vec<String>,
    },
    /// More than a mesh may have.
    #[error("it has more than {MAX_MESH_ELEMENTS} {0}; simplify it first")]
    TooLarge(&'static str),
    /// A file that a glTF file names could not be read.
    #[error("its buffer {uri:?}: {source}")]
    Buffer {
        /// The file as it is named there.
        uri: String,
        /// Why not.
        source: io::Error,
    },
}

impl MeshFault {
    pub(super) fn malformed(place: Place, what: impl Into<String>) -> Self {
        Self::Malformed { place, what: what.into() }
    }
}

fn extension_said(extension: &str) -> String {
    if extension.is_empty() {
        "its name has no extension to tell the format by".to_owned()
    } else {
        let remedy = match extension {
            "fbx" | "blend" | "dae" | "3ds" | "max" | "ma" | "mb" | "c4d" | "lwo" | "x3d" | "usd"
            | "usda" | "usdc" | "usdz" | "abc" => {
                ": export it as glTF (.glb) or OBJ from the program that made it"
            }
            "step" | "stp" | "iges" | "igs" | "3mf" | "amf" | "scad" | "f3d" => {
                ": export it as STL or OBJ from the program that made it"
            }
            _ => "",
        };
        format!("the extension .{extension} is not known{remedy}")
    }
}

fn extensions_known() -> String {
    MESH_EXTENSIONS.map(|e| format!(".{e}")).join(", ")
}
