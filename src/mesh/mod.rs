//! Triangle meshes from files, and the tetrahedra that fill them.

mod boxes;
mod carve;
mod cast;
mod clean;
mod defects;
mod edges;
mod exact;
mod layer;
mod locate;
mod mesher;
mod read;
mod refine;
#[cfg(test)]
pub(crate) mod shapes;
pub(crate) mod subdivide;
mod tet;
mod tet_files;
mod tetrahedralise;
mod tri;
mod wear;
mod write;

pub(crate) use boxes::{BoxTree, box_of, boxes_touch};
pub(crate) use carve::near;
pub use carve::{CarveError, Carved, carve};
pub(crate) use cast::Caster;
pub use clean::{CleanError, CleanReport, Cleaned, Provenance, WELD_TOLERANCE, clean};
pub use defects::{
    AtEdge, AtTriangle, AtVertex, Crossing, Defects, Found, Hole, MAX_CROSSINGS, PLACES, defects,
};
pub(crate) use layer::{LayerPoint, layer};
pub use locate::TetLocator;
pub(crate) use locate::closest_on_triangle;
pub use mesher::{Mesher, MesherError, MesherLimits, tetgen_helper};
pub use read::{MAX_MESH_ELEMENTS, MESH_EXTENSIONS, MeshFault, MeshFile, MeshReadError, Place, read};
pub use refine::refine;
pub(crate) use tet::index;
pub use tet::{BoundaryFace, FaceOrigin, NONE, TET_FACES, TetMesh, TopologyError, gradients, signed_volume};
pub use tet_files::{
    TET_EXTENSIONS, TetFileError, VtuField, VtuValues, read_tets, tet_file_names, write_tets, write_vtu,
};
pub use tetrahedralise::{
    MAX_TETS, Simplified, SplitError, Splits, TetError, TetParams, TetReport, split_for_depth,
    tetrahedralise, tetrahedralise_within,
};
pub use tri::TriMesh;
pub use wear::{Material, Region, RegionError, RegionKind, Wear, WornPicture, Wrap};
pub(crate) use write::Shortest;
pub use write::write_obj;
