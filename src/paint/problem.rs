//! What can be wrong with what is painted.

use glam::{DVec2, DVec3};

use super::Ground;
use crate::exec::Cancelled;
use crate::field::{DepthError, DirectionError, ScaleError};
use crate::lap::COARSEST;
use crate::mesh::RegionError;
use crate::number::Short;
use crate::view::CameraError;
use crate::volume::MAX_SIDE;

/// Something painted that cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("{key} cannot be painted")]
pub struct PaintError {
    /// What it is called: the table and its number, such as `depth.stroke[2]`.
    pub key: String,
    /// What is wrong with it.
    #[source]
    pub problem: Box<PaintProblem>,
}

impl PaintError {
    pub(super) fn new(key: &str, problem: impl Into<PaintProblem>) -> Self {
        Self { key: key.to_owned(), problem: Box::new(problem.into()) }
    }
}

/// What is wrong with something painted.
#[derive(Debug, thiserror::Error)]
pub enum PaintProblem {
    /// No such region, or two of one name.
    #[error(transparent)]
    Region(#[from] RegionError),
    /// A region of which the mesh has nothing left.
    #[error(
        "the region '{name}' is empty: none of its {triangles} triangles is left on the model's surface; more \
         tetrahedra (mesh.tets), or mesh.keep_surface = true, keep small regions"
    )]
    EmptyRegion {
        /// The region.
        name: String,
        /// Its triangles in the mesh file.
        triangles: usize,
    },
    /// A point that is no face's.
    #[error(
        "[{}, {}, {}] is {} away from the surface, whose edges are {} long on average; pick a point on it, in \
         the mesh's unit",
        .point.x, .point.y, .point.z, Short(*.distance), Short(*.edge)
    )]
    FarPick {
        /// The point.
        point: DVec3,
        /// Its distance from the surface.
        distance: f64,
        /// Mean length of the mesh's edges.
        edge: f64,
    },
    /// A point of a picture where nothing is seen.
    #[error("at [{}, {}] of the picture nothing of {on} is seen; {seen}", .point.x, .point.y)]
    PickMisses {
        /// The point.
        point: DVec2,
        /// What the picture shows.
        on: Ground,
        /// Where it is in the picture.
        seen: Seen,
    },
    /// A line over a picture where nothing is seen.
    #[error("the line runs past {}{on} everywhere; {seen}", of_layer(*.layer))]
    LineMisses {
        /// What the picture shows.
        on: Ground,
        /// The layer that it is drawn on.
        layer: Option<f64>,
        /// Where it is in the picture.
        seen: Seen,
    },
    /// Points far from the model.
    #[error(
        "none of its points is within the model's bounding box, ({}) to ({}); is it in the mesh's unit?",
        coordinates(*.low), coordinates(*.high)
    )]
    PointsMiss {
        /// The model's least corner.
        low: DVec3,
        /// Its greatest.
        high: DVec3,
    },
    /// A piece that the cut did not leave.
    #[error("`on` asks for '{name}', but that cut leaves {pieces} pieces")]
    NoPiece {
        /// The piece asked for.
        name: String,
        /// How many there are.
        pieces: usize,
    },
    /// The camera cannot see.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// The eye is in the material.
    #[error("the camera's eye is inside {0}; move it out, so that the picture shows it from outside")]
    CameraInside(Ground),
    /// Nothing is in front of the camera.
    #[error(
        "the camera is turned away from {0}: all of it lies behind the eye; let it look at a `target` on the \
         other side"
    )]
    TurnedAway(Ground),
    /// No such depth.
    #[error(
        "the layer of depth {layer} is empty: over {on} depth runs from {} to {}; choose a layer between them",
        Short(*.from), Short(*.to)
    )]
    EmptyLayer {
        /// The depth.
        layer: f64,
        /// Where it is looked for.
        on: Ground,
        /// The least depth there.
        from: f64,
        /// The greatest.
        to: f64,
    },
    /// A layer of a field that is not there yet.
    #[error(
        "its `layer` is one of the depth field that all else paints, and that makes none; paint two depths \
         without `layer` first, such as the skin with 0 and a stroke along the axis with 1"
    )]
    LayerFirst(#[source] DepthError),
    /// A layer where there is no depth.
    #[error("`layer` is an isosurface of depth, and this texture type has no depth; leave it out")]
    NoDepth,
    /// A direction stroke along the gradient.
    #[error(
        "it runs along the depth's gradient, within {degrees}° on average: texture x cannot run the way of texture y; \
         draw it along a layer, across the way that depth rises (`layer = D` puts it on one)"
    )]
    AlongGradient {
        /// How near is too near.
        degrees: f64,
    },
    /// Two scales at one place.
    #[error(
        "it says {} where `{other}` says {}, {}: remove one of them, or move them apart",
        .scales[1], .scales[0], apart(*.distance)
    )]
    TwoScales {
        /// The other one's key.
        other: String,
        /// How far apart they are.
        distance: f64,
        /// The other's scale and this one's.
        scales: [f64; 2],
    },
    /// Two depths at one place.
    #[error(
        "it says {} where `{other}` says {}, {}: remove one of them, or move them apart",
        .depths[1], .depths[0], apart(*.distance)
    )]
    TwoDepths {
        /// The other one's key.
        other: String,
        /// How far apart they are.
        distance: f64,
        /// The other's depth and this one's.
        depths: [f64; 2],
    },
    /// A part of the surface of which later ones leave nothing.
    #[error(
        "nothing is left of its depth {depth}: {} over all of its faces; remove one of them, or put this one behind \
         (regions are painted first, then fills, then single faces, each in the order of the file)",
        by.iter().map(|key| format!("`{key}`")).collect::<Vec<_>>().join(" and ") + if by.len() == 1 { " paints" } else { " paint" }
    )]
    PaintedOver {
        /// Its depth.
        depth: f64,
        /// The keys of what is painted over it.
        by: Vec<String>,
    },
    /// A scale past all sense.
    #[error(
        "it is {}, and the model is {} from corner to corner: of the largest solid texture ({MAX_SIDE} \
         voxels a side) not one voxel would cover it; choose a scale about as large as the model, or smaller",
        Short(*.scale), Short(*.diagonal)
    )]
    ScaleTooLarge {
        /// The scale.
        scale: f64,
        /// The diagonal of the model's bounding box.
        diagonal: f64,
    },
    /// A scale for which there can be no tetrahedra.
    #[error(
        "it is {}, and the model is {} from corner to corner: coverage can be told only where tetrahedra \
         are at most {COARSEST} units of texture long, and that many cannot be; choose a scale of {} or more",
        Short(*.scale), Short(*.diagonal), Short(*.least)
    )]
    ScaleTooSmall {
        /// The scale.
        scale: f64,
        /// The diagonal of the model's bounding box.
        diagonal: f64,
        /// The least that could be.
        least: f64,
    },
    /// A depth stroke that counts nowhere.
    #[error(
        "it lies wholly outside the mesh or on a surface painted with another depth; draw it inside, or paint \
         those faces with its depth"
    )]
    StrokeMisses,
    /// A direction stroke without length.
    #[error("it has no length: a direction needs two different points")]
    NoLength,
    /// One depth only.
    #[error(
        "everything painted has depth {0}, and a field needs two: paint the outside with one depth and a stroke inside \
         with another, such as skin = 0 and a stroke of depth 1 along the axis"
    )]
    OneDepth(f64),
    /// Nothing, or one value only, painted of texture x or z.
    #[error(
        "{}, and a field needs two values: paint one end of the model with 0 and the other with 1",
        .0.map_or("nothing is painted".to_owned(), |value| format!("everything painted has the value {value}"))
    )]
    OneValue(Option<f64>),
    /// No field comes of what is painted with depths.
    #[error("cannot make the field: {0}")]
    Depth(#[source] DepthError),
    /// No direction field comes of the strokes.
    #[error("cannot make the direction field: {0}")]
    Direction(#[source] DirectionError),
    /// No scale field comes of the scales.
    #[error("cannot make the scale field: {0}")]
    Scale(#[source] ScaleError),
    /// The caller asked it to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

fn of_layer(layer: Option<f64>) -> String {
    layer.map_or(String::new(), |d| format!("the layer of depth {d} of "))
}

fn apart(distance: f64) -> String {
    if distance == 0.0 { "at the same place".to_owned() } else { format!("only {} apart", Short(distance)) }
}

fn coordinates(p: DVec3) -> String {
    format!("{}, {}, {}", Short(p.x), Short(p.y), Short(p.z))
}

/// Where in a picture something is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// Its box's least corner, in fractions of the picture; `None` where a part of it is behind the camera.
    pub extent: Option<[DVec2; 2]>,
}

impl std::fmt::Display for Seen {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.extent {
            Some([a, b]) => {
                write!(f, "it fills the picture from [{:.3}, {:.3}] to [{:.3}, {:.3}]", a.x, a.y, b.x, b.y)
            }
            None => f.write_str("a part of it is behind the camera"),
        }
    }
}
