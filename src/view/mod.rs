//! Cameras and what is drawn on their screen. Screen points are fractions of the picture:
//! origin at the top left, x to the right, y down.

mod camera;

pub use camera::{Camera, CameraError, Projection};
