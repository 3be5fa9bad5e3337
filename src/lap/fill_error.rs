//! Why a mesh cannot be filled.

use glam::DVec3;

use super::kind::TextureType;
use crate::exec::Cancelled;
use crate::field::PeriodicError;
use crate::number::Short;
use crate::solve::SolveError;

/// Why a mesh cannot be filled.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FillError {
    /// An input that the type draws on is missing.
    #[error("texture type {kind} needs the field '{input}', and there is none")]
    Missing {
        /// The texture type.
        kind: TextureType,
        /// What is missing.
        input: &'static str,
    },
    /// An input that the type does not draw on.
    #[error("texture type {kind} does not use the field '{input}': leave it out, or choose a type that does")]
    Unused {
        /// The texture type.
        kind: TextureType,
        /// What is too much.
        input: &'static str,
    },
    /// A field of another length than the mesh's vertices.
    #[error("the {input} has {found} values for {vertices} vertices")]
    Length {
        /// Which field.
        input: &'static str,
        /// Values that there are.
        found: usize,
        /// Vertices that there are.
        vertices: usize,
    },
    /// A field with a value out of range.
    #[error("the {input} has {found} at vertex {vertex}")]
    Field {
        /// Which field.
        input: &'static str,
        /// The vertex.
        vertex: usize,
        /// What it has there.
        found: String,
    },
    /// A setting out of range.
    #[error("{key} is {value}; it must be {range}")]
    Setting {
        /// Its name.
        key: &'static str,
        /// Its value.
        value: f64,
        /// Its range.
        range: &'static str,
    },
    /// The scale is too small for the model.
    #[error(
        "about {estimate} patches would be needed, and at most {limit} are allowed (max_patches): the \
         texture's scale is very small for this model; a scale of {} would do", Short(*.remedy)
    )]
    TooManyPatches {
        /// Expected patches.
        estimate: u64,
        /// The limit.
        limit: u64,
        /// A scale that stays below it.
        remedy: f64,
    },
    /// The scale is too large for the model.
    #[error(
        "the texture's scale is very large for this model: one unit of texture covers {}, the model is {} from corner to \
         corner, and so it would show less than one voxel of a texture that has {side} along a side; a scale of {} would \
         show it once",
        Short(*.scale), Short(*.diagonal), Short(*.diagonal)
    )]
    TooLarge {
        /// The least world length of one unit of texture.
        scale: f64,
        /// The diagonal of the model's bounding box.
        diagonal: f64,
        /// Voxels along the texture's longest side.
        side: u32,
    },
    /// The tetrahedra are too large for the texture.
    #[error(
        "the tetrahedra are too large for the texture's scale: near {place} one unit of texture covers \
         {}, an edge is {} long, and coverage could not be told; ask for about {tets} tetrahedra or more, or for a \
         larger scale",
        Short(*.scale), Short(*.edge)
    )]
    TooCoarse {
        /// Where.
        place: DVec3,
        /// World length of one unit of texture there.
        scale: f64,
        /// The longest edge there.
        edge: f64,
        /// Enough tetrahedra.
        tets: u64,
    },
    /// Two fields that are to be texture coordinates rise along one line.
    #[error(
        "over {:.0} % of the model, such as near {place}, the fields 'along' and 'depth' do not cross: one of them is \
         flat there, or both rise along one line; paint them so that they rise in different directions",
        share * 100.0
    )]
    NoCrossing {
        /// The part of the model's volume.
        share: f64,
        /// A place in the middle of it.
        place: DVec3,
    },
    /// Three fields that are to be texture coordinates make no mapping.
    #[error(
        "over {:.0} % of the model, such as near {place}, the fields 'along', 'depth' and 'across' turn the texture \
         {}",
        share * 100.0,
        if *mirrored {
            "into its mirror image: exchange 0 and 1 in what is painted for one of them"
        } else {
            "inside out or flat: paint them so that they rise in three different directions everywhere"
        }
    )]
    Folded {
        /// The part of the model's volume.
        share: f64,
        /// A place in the middle of it.
        place: DVec3,
        /// Whether the mapping is good but for its sense.
        mirrored: bool,
    },
    /// Patches are to agree, and the texture has a beginning and an end.
    #[error(
        "coherent is true, but the texture does not tile along {0}: patches agree only along axes on which it goes on \
         without an end; make it so (the volume's `lapis_tiles`, or `tiles` beside it), or set coherent to false"
    )]
    NotTiling(String),
    /// There are no coordinates for patches to keep to.
    #[error("patches cannot be made to agree (coherent = false laps without)")]
    Periodic(#[source] SolveError),
    /// The mesh has no tetrahedra.
    #[error("the mesh has no tetrahedra")]
    Empty,
    /// The run was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<PeriodicError> for FillError {
    fn from(error: PeriodicError) -> Self {
        match error {
            PeriodicError::Solve(e) => Self::Periodic(e),
            PeriodicError::Cancelled(e) => Self::Cancelled(e),
        }
    }
}
