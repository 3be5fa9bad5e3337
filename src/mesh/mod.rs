//! Triangle meshes from files, and the tetrahedra that fill them.

mod read;
mod tet;
mod tri;

pub use read::{MAX_MESH_ELEMENTS, MESH_EXTENSIONS, MeshFault, MeshReadError, Place, read};
pub(crate) use tet::index;
pub use tet::{BoundaryFace, FaceOrigin, NONE, TET_FACES, TetMesh, TopologyError, gradients, signed_volume};
pub use tri::TriMesh;
