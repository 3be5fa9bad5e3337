//! Triangle meshes from files, and the tetrahedra that fill them.

mod locate;
mod tet;
mod tri;

pub use locate::TetLocator;
pub(crate) use tet::index;
pub use tet::{BoundaryFace, FaceOrigin, NONE, TET_FACES, TetMesh, TopologyError, gradients, signed_volume};
pub use tri::TriMesh;
