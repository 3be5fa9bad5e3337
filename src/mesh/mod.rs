//! Triangle meshes from files, and the tetrahedra that fill them.

mod mesher;
mod boxes;
mod clean;
mod defects;
mod edges;
mod exact;
mod read;
mod tet;
mod tet_files;
mod tetrahedralise;
mod tri;
mod write;

pub use mesher::{Mesher, MesherError, MesherLimits, tetgen_helper};
pub use clean::{CleanError, CleanReport, WELD_TOLERANCE, clean};
pub use defects::{AtEdge, AtTriangle, AtVertex, Crossing, Defects, Found, Hole, MAX_CROSSINGS, PLACES, defects};
pub use read::{MAX_MESH_ELEMENTS, MESH_EXTENSIONS, MeshFault, MeshReadError, Place, read};
pub(crate) use tet::index;
pub use tet::{BoundaryFace, FaceOrigin, NONE, TET_FACES, TetMesh, TopologyError, gradients, signed_volume};
pub use tet_files::{TetFileError, read_tets, write_tets};
pub use tetrahedralise::{
    MAX_TETS, Simplified, TetError, TetParams, TetReport, tetrahedralise, tetrahedralise_within,
};
pub use tri::TriMesh;

// SEAM until the checks of triangle meshes are merged.
/// Defects.
#[derive(Debug)]
pub struct Defects;
impl Defects {
    /// None.
    pub fn is_empty(&self) -> bool {
        true
    }
}
impl std::fmt::Display for Defects {
    fn fmt(&self, _: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        Ok(())
    }
}
/// Finds none.
pub fn defects(_: &TriMesh, exec: &crate::exec::Exec) -> Result<Defects, crate::exec::Cancelled> {
    exec.check()?;
    Ok(Defects)
}
pub use write::write_obj;
