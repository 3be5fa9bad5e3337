//! Why a part cannot be filled.

use std::path::PathBuf;

use super::part::{MAX_REFINE_SINGULAR, MAX_REFINED};
use crate::cut::CutError;
use crate::exec::Cancelled;
use crate::lap::{FillError, LookError, PasteError, TextureType, TooLarge};
use crate::mesh::{CarveError, CleanError, MeshReadError, SplitError, TetError, TetFileError, TopologyError};
use crate::paint::{PaintError, PaintProblem};
use crate::volume::VolumeReadError;

/// A part that cannot be filled.
#[derive(Debug, thiserror::Error)]
pub enum PartError {
    /// The texture type needs something that is not given.
    #[error("texture type {kind} needs {}: {}", inputs.join(" and "), how_to_give(inputs))]
    Needs {
        /// The type.
        kind: TextureType,
        /// What is missing: `depth`, `direction`, `scale`, `along`, `across`.
        inputs: Vec<&'static str>,
    },
    /// Something is given that the texture type does not draw on.
    #[error("texture type {kind} takes no {input}: {}", why_not(*kind, input))]
    Takes {
        /// The type.
        kind: TextureType,
        /// What is too much.
        input: &'static str,
    },
    /// A constant direction without length.
    #[error("the constant direction is zero or not finite")]
    NoDirection,
    /// A mesh file that cannot be read.
    #[error(transparent)]
    Mesh(#[from] MeshReadError),
    /// Tetrahedra that cannot be read.
    #[error(transparent)]
    TetFile(#[from] TetFileError),
    /// A volume that cannot be read.
    #[error(transparent)]
    Volume(#[from] VolumeReadError),
    /// A texture that cannot be pasted.
    #[error("cannot paste {}", path.display())]
    Stamp {
        /// The texture.
        path: PathBuf,
        /// Why.
        source: PasteError,
    },
    /// Something that cannot be pasted where it is to be.
    #[error(transparent)]
    Paste(#[from] PasteError),
    /// A surface of which nothing is left when it is cleaned.
    #[error("the mesh {} is no surface", path.display())]
    Clean {
        /// The file.
        path: PathBuf,
        /// Why.
        source: CleanError,
    },
    /// A surface that cannot be filled with tetrahedra.
    #[error("cannot fill the mesh {} with tetrahedra", path.display())]
    Tetrahedralise {
        /// The file.
        path: PathBuf,
        /// Why.
        source: TetError,
    },
    /// Tetrahedra of a file that cannot be made fit for depth.
    #[error("the tetrahedra of {} cannot take a painted depth", path.display())]
    Split {
        /// The file.
        path: PathBuf,
        /// Why.
        source: SplitError,
    },
    /// Parts that cannot be taken out of another.
    #[error("cannot take {} out of the part '{name}', which surrounds or meets them", quoted(others))]
    Carve {
        /// The part that is carved.
        name: String,
        /// The smaller ones that may reach into it.
        others: Vec<String>,
        /// Why.
        source: CarveError,
    },
    /// A part that lies against others, whose surface says not what is inside.
    #[error(
        "the surface of the part '{name}' is not closed, or crosses itself, so that nobody can say what of the other parts \
         lies inside it; repair it first (lapis info says where)"
    )]
    NoSolid {
        /// The part.
        name: String,
    },
    /// What is left of a part is hard to fill.
    #[error(
        "cannot fill with tetrahedra what is left when {} is taken out; where parts overlap by very little, or meet at a grazing \
         angle, move them apart or deeper into each other",
        quoted(others)
    )]
    Carved {
        /// What was taken out.
        others: Vec<String>,
        /// Why.
        source: TetError,
    },
    /// A part of tetrahedra from a file into which another reaches.
    #[error(
        "another part reaches into '{name}', whose tetrahedra come from {}: those are taken as they are; give its surface \
         instead",
        path.display()
    )]
    CarveTets {
        /// The part.
        name: String,
        /// Its file.
        path: PathBuf,
    },
    /// Parts that are too much for one model.
    #[error(transparent)]
    TooLarge(#[from] TooLarge),
    /// A height for a texture that has no displacement.
    #[error(
        "{} has no displacement for `height` (--height) to scale; name one in its file by the key lapis_displacement",
        .0.display()
    )]
    NoDisplacement(PathBuf),
    /// What is wrong with one part of several.
    #[error("in the part '{name}'")]
    Of {
        /// The part.
        name: String,
        /// What is wrong with it.
        source: Box<PartError>,
    },
    /// Refining at the singularities failed.
    #[error("cannot refine the tetrahedra at the frames' singularities; leave refine_singular at 0")]
    Refine(#[source] TopologyError),
    /// More levels of refinement than make sense.
    #[error(
        "refine_singular is {0}; it must be 0 to {MAX_REFINE_SINGULAR}: each level halves the edges there"
    )]
    RefineLevels(u32),
    /// Refinement of what is not there.
    #[error(
        "refine_singular (--refine-singular on the command line) would refine nothing: {0}; leave it out"
    )]
    RefineNothing(&'static str),
    /// More tetrahedra than refinement may make.
    #[error(
        "refine_singular = {asked}: level {level} would make at least {tetrahedra} tetrahedra, and refinement may make \
         {MAX_REFINED}; ask for {} levels, or for fewer tetrahedra to begin with",
        level - 1
    )]
    RefineLimit {
        /// The levels asked for.
        asked: u32,
        /// The one that is too much.
        level: u32,
        /// The tetrahedra that it would make.
        tetrahedra: usize,
    },
    /// Something painted that cannot be used.
    #[error(transparent)]
    Paint(PaintError),
    /// A cut on whose piece something is painted.
    #[error("cannot make the cut '{name}', on a piece of which something is painted")]
    Cut {
        /// Its name.
        name: String,
        /// Why.
        source: CutError,
    },
    /// The mesh has no look to keep.
    #[error(
        "keep_look (--keep-look on the command line): {} has no look to keep{notes}; leave it out, or export the \
         mesh with vertex colours or with its materials and pictures (OBJ with its MTL and PNG beside it, GLB, PLY)",
        path.display()
    )]
    Look {
        /// The mesh.
        path: PathBuf,
        /// What was said when it was read, each in brackets after a space.
        notes: String,
        /// What is missing.
        source: LookError,
    },
    /// The lapping failed.
    #[error("cannot lap the texture")]
    Fill(#[source] FillError),
    /// The caller asked it to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<PaintError> for PartError {
    fn from(error: PaintError) -> Self {
        match *error.problem {
            PaintProblem::Cancelled(c) => Self::Cancelled(c),
            _ => Self::Paint(error),
        }
    }
}

impl PartError {
    /// The same, said of the part of that name; as it is where there is only one, which has none.
    pub(super) fn of(self, name: &str) -> Self {
        match self {
            Self::Cancelled(_) | Self::Carve { .. } | Self::CarveTets { .. } => self,
            _ if name.is_empty() => self,
            _ => Self::Of { name: name.to_owned(), source: Box::new(self) },
        }
    }
}

/// `'stone' and 'leaf'`
fn quoted(names: &[String]) -> String {
    names.iter().map(|name| format!("'{name}'")).collect::<Vec<_>>().join(" and ")
}

fn how_to_give(inputs: &[&str]) -> String {
    let how = inputs.iter().map(|input| match *input {
        "depth" => "paint depth ([depth] in a project file; --core on the command line)",
        "direction" => "set the direction ([direction] in a project file; --direction on the command line)",
        "scale" => {
            "set the scale, the world length of one unit of texture ([scale] in a project file; --scale on the \
             command line)"
        }
        "along" => "paint along, where the texture's x runs ([along] in a project file only)",
        _ => "paint across, where the texture's z runs ([across] in a project file only)",
    });
    how.collect::<Vec<_>>().join("; ")
}

fn why_not(kind: TextureType, input: &str) -> &'static str {
    match input {
        "scale" if kind == TextureType::Type2d => "its fields say where each point of the texture goes",
        "scale" => "its scale follows from the depth",
        "direction" if kind == TextureType::Type0 => "it looks the same from every side",
        "direction" if kind == TextureType::Type1b => "it turns freely about the depth's gradient",
        "direction" => "its directions follow from the fields",
        "along" => "its texture's x is no field",
        "across" => "its texture's z is no field",
        _ => "it does not vary with depth",
    }
}
