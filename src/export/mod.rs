//! Files for other programs: GLB and OBJ with a baked atlas, PLY with vertex colours, STL, VTU for ParaView.
//!
//! All but VTU show the boundary of a lapped solid, outside and cut faces alike, in the mesh's own axes, with the
//! normals that [`render`](crate::render) uses ([`Surface`](crate::render::Surface)).
//!
//! [`shapes_glb`] and [`shapes_obj`] show the particles that a volume was made of, side by side.

mod atlas;
mod bake;
mod buffer;
mod charts;
mod format;
mod glb;
mod merge;
mod obj;
mod pack;
mod ply;
mod shapes;
mod stl;
mod textured;
mod vtu;

pub use atlas::{Atlas, AtlasParams, MAX_ATLAS_SIDE};
pub use format::{ExportFormat, ExportedFile, export};
pub use glb::glb;
pub use obj::{ObjFiles, obj};
pub use ply::{MAX_PLY_FACES, PlyParams, ply};
pub use shapes::{shapes_glb, shapes_obj};
pub use stl::stl;
pub use vtu::vtu;

use crate::exec::Cancelled;

/// Why nothing was exported.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ExportError {
    /// There are no boundary faces.
    #[error("the model has no surface to export")]
    Empty,
    /// A position that single precision cannot hold.
    #[error(
        "vertex {vertex} lies at {coordinate:e}, outside what single precision holds; scale the model down"
    )]
    TooFar {
        /// The vertex.
        vertex: u32,
        /// Its greatest coordinate.
        coordinate: f64,
    },
    /// An atlas side that is no power of two, too small or too large.
    #[error(
        "an atlas of {0} texels a side: it must be a power of two from 64 to {MAX_ATLAS_SIDE}, or 0 to choose it"
    )]
    AtlasSize(u32),
    /// The surface falls into more charts than the atlas holds.
    #[error("{charts} charts do not fit into an atlas of {size}×{size} texels; ask for a larger atlas")]
    AtlasFull {
        /// Number of charts.
        charts: usize,
        /// Side of the atlas.
        size: u32,
    },
    /// Too many faces.
    #[error("{faces} faces split {subdivide} times make more than {MAX_PLY_FACES}; split fewer times")]
    TooManyFaces {
        /// Faces of the surface.
        faces: usize,
        /// Asked level.
        subdivide: u32,
    },
    /// More than the format holds.
    #[error(
        "the file would need {0} bytes, more than the format holds; make fewer tetrahedra, or cut the model"
    )]
    TooLarge(u64),
    /// A file name that an OBJ or its material cannot name.
    #[error("the name {0:?} has a control character, which an OBJ file cannot hold; choose another")]
    Name(String),
    /// The run was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// A position in single precision.
fn single(vertex: u32, p: glam::DVec3) -> Result<[f32; 3], ExportError> {
    let s = p.as_vec3();
    if s.is_finite() {
        Ok(s.to_array())
    } else {
        Err(ExportError::TooFar { vertex, coordinate: p.abs().max_element() })
    }
}
