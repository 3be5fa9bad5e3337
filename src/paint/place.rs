//! Where something is painted.

use std::fmt;

use glam::{DVec2, DVec3};
use serde::Serialize;

use crate::lap::LappedSolid;
use crate::render::{Placed, frame_all, frame_all_from};
use crate::view::Camera;

/// What a stroke is drawn on.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub enum Ground {
    /// The uncut model.
    Whole,
    /// A piece that a cut leaves.
    Piece {
        /// The cut, by its number.
        cut: usize,
        /// The piece, from 1, by falling volume.
        piece: usize,
        /// What the piece is called: `CUT/N`.
        name: String,
    },
}

impl Ground {
    /// The number of cut and piece; `None` for the whole.
    #[must_use]
    pub fn piece(&self) -> Option<(usize, usize)> {
        match self {
            Self::Whole => None,
            Self::Piece { cut, piece, .. } => Some((*cut, *piece)),
        }
    }
}

impl fmt::Display for Ground {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Whole => f.write_str("the model"),
            Self::Piece { name, .. } => write!(f, "the piece '{name}'"),
        }
    }
}

/// From where a picture was taken that somebody drew over.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct View {
    /// The camera; `None`: one that frames what is drawn on.
    pub camera: Option<Camera>,
    /// Without a camera: the direction from which it is framed; `None`: as pictures are.
    pub from: Option<DVec3>,
    /// The picture's width over its height; `None`: the camera's, or 1.
    pub aspect: Option<f64>,
}

impl View {
    /// The camera, given what is drawn on.
    #[must_use]
    pub fn camera_on(&self, solid: &LappedSolid) -> Camera {
        let placed = [Placed::from(solid)];
        match (self.camera, self.from) {
            (Some(camera), _) => Camera { aspect: self.aspect.unwrap_or(camera.aspect), ..camera },
            (None, Some(from)) => frame_all_from(&placed, self.aspect.unwrap_or(1.0), from),
            (None, None) => frame_all(&placed, self.aspect.unwrap_or(1.0)),
        }
    }
}

/// A line as it was drawn.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum Line {
    /// Points in space, in the mesh's unit, joined straight.
    Points(Vec<DVec3>),
    /// Lines over a picture, in fractions of it, y down; they lie on what the camera sees there.
    Screen {
        /// Each a polyline; a single point is a dot.
        lines: Vec<Vec<DVec2>>,
        /// The picture.
        view: View,
    },
}

/// A line and what it lies on.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Place {
    /// The line.
    pub line: Line,
    /// What the picture shows.
    pub on: Ground,
    /// The depth of the layer that it lies on; `None`: points as they are, lines on the surface, cut faces
    /// included.
    pub layer: Option<f64>,
}

impl Place {
    /// Points in space, as they are.
    #[must_use]
    pub fn points(points: Vec<DVec3>) -> Self {
        Self { line: Line::Points(points), on: Ground::Whole, layer: None }
    }
}
