//! Depth, direction and scale over a tetrahedral mesh, from what a person painted \[LST 5.2.2\].
//!
//! [`depth_field`] interpolates painted depths by radial basis functions; [`direction_field`] and
//! [`scale_field`] spread strokes and local scales by Laplacian smoothing; [`FrameField`] puts them together
//! to the paper's tensor field.

mod aggregate;
mod depth;
mod direction;
mod eigen;
mod frame;
mod gradient;
mod graph;
mod laplacian;
mod rbf;
mod scale;
mod stroke;
mod twolevel;

pub use depth::{DepthError, DepthField, DepthPaint, DepthParams, DepthReport, DepthStroke, depth_field};
pub use direction::{DirectionError, DirectionParams, DirectionStroke, direction_field};
pub use frame::{FrameError, FrameField, FrameLength, depth_lengths};
pub use gradient::tet_gradients;
pub use rbf::{Kernel, Rbf, RbfError, RbfParams, RbfReport};
pub use scale::{ScaleAt, ScaleError, scale_field};
