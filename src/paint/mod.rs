//! What a person paints \[LST 4\]: from faces that were picked and filled and lines that were drawn over
//! pictures to points and faces for [`field`](crate::field).
//!
//! A [`Canvas`] is the model before it is filled, whole and cut. Its three front doors, [`Canvas::depth`],
//! [`Canvas::direction`] and [`Canvas::scale`], find where each thing painted lies in space and make the field of
//! it. Everything painted has a *key*, the name that it goes by in messages, such as `depth.stroke[2]`.

mod area;
mod canvas;
mod depth;
mod direction;
mod place;
mod problem;
mod scale;
mod trace;

pub use area::{Area, AreaKind, Picks};
pub use canvas::Canvas;
pub use depth::{DepthPaint, DepthStroke, PaintedDepth};
pub use direction::{DirectionStroke, PaintedDirection};
pub use place::{Ground, Line, Place, View};
pub use problem::{PaintError, PaintProblem};
pub use scale::{PaintedScale, ScaleAt, Spot};

#[cfg(test)]
mod tests;
