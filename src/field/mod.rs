//! Depth, direction and scale over a tetrahedral mesh, from what a person painted \[LST 5.2.2\].

mod depth;
mod eigen;
mod gradient;
mod graph;
mod laplacian;
mod rbf;
mod stroke;

pub use depth::{DepthError, DepthField, DepthPaint, DepthParams, DepthReport, DepthStroke, depth_field};
pub use gradient::{tet_gradients, vertex_gradients};
pub use rbf::{Kernel, Rbf, RbfError, RbfParams, RbfReport};
