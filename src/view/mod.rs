//! Cameras and what is drawn on their screen. Screen points are fractions of the picture:
//! origin at the top left, x to the right, y down.

mod camera;
mod file;
mod stroke;
mod svg;

pub use camera::{Camera, CameraError, Projection};
pub use file::{StrokeFile, ViewFileError, ViewFileProblem, is_svg, read_camera};
pub use stroke::{MAX_STROKE_POINTS, Stroke, StrokeError};
pub(crate) use stroke::{box_of, meeting, turn};
pub use svg::{Drawing, DrawnLine, SvgFault};
