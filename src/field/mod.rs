//! Depth, direction and scale over a tetrahedral mesh, from what a person painted \[LST 5.2.2\].
//!
//! [`depth_field`] interpolates painted depths by radial basis functions; [`direction_field`] and
//! [`scale_field`] spread strokes and local scales by Laplacian smoothing; [`FrameField`] puts them together
//! to the paper's tensor field, and [`singularities`] finds where no texture can follow it.

mod aggregate;
mod depth;
mod direction;
mod eigen;
mod frame;
mod gradient;
mod graph;
mod laplacian;
mod painted_surface;
mod periodic;
mod rbf;
mod scale;
mod singular;
mod stroke;
mod twolevel;

pub(crate) use depth::strokes_that_count;
pub use depth::{
    DepthError, DepthField, DepthPaint, DepthParams, DepthReport, DepthStroke, PaintedFace, depth_field,
};
pub use direction::{DirectionError, DirectionParams, DirectionStroke, direction_field};
pub(crate) use eigen::eigen;
pub(crate) use frame::perpendicular;
pub use frame::{Fields, FrameField};
pub use gradient::tet_gradients;
pub(crate) use gradient::{Slope, vertex_slopes};
pub use periodic::PeriodicError;
pub(crate) use periodic::{Periodic, agreed, completed, level};
pub use rbf::{Kernel, Rbf, RbfError, RbfParams, RbfReport};
pub use scale::{ScaleAt, ScaleError, scale_field};
pub use singular::{FrameAxes, Singularities, singularities, singularities_of_vertices};
pub(crate) use stroke::sample;
