//! The strokes that a person painted, drawn over the surface that they lie on.

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::{Screen, Show, Subject, maps};
use crate::colour::LinearRgba;
use crate::lap::LappedSolid;
use crate::render::overlay::{Segment, Shape};

/// Something painted, where it lies in space; drawn over a picture that shows what it paints.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Mark {
    /// A stroke of depth.
    Depth(Painted),
    /// A stroke of the field `along`.
    Along(Painted),
    /// A stroke of the field `across`.
    Across(Painted),
    /// A scale at a point.
    Scale(Painted),
    /// A stroke along which the texture's x axis runs: its points, in the mesh's unit.
    Direction(Vec<DVec3>),
}

/// A line of one value.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Painted {
    /// Its points, in the mesh's unit; a single one is a dot.
    pub points: Vec<DVec3>,
    /// The value: 0 to 1, or a length.
    pub value: f64,
}

impl Mark {
    /// Where a solid's settings hold its marks.
    pub const KEY: &str = "marks";

    /// What was painted on a solid, as its settings say.
    #[must_use]
    pub fn all(solid: &LappedSolid) -> Vec<Self> {
        let Some(Value::Array(marks)) = solid.settings.get(Self::KEY) else { return Vec::new() };
        // The settings are a record; what of them makes no sense is not drawn.
        marks.iter().filter_map(|mark| serde_json::from_value(mark.clone()).ok()).collect()
    }

    /// The picture that shows it.
    fn show(&self) -> Show {
        match self {
            Self::Depth(_) => Show::Depth,
            Self::Along(_) => Show::Along,
            Self::Across(_) => Show::Across,
            Self::Scale(_) => Show::Scale,
            Self::Direction(_) => Show::Direction,
        }
    }
}

/// Half the width of a stroke, in pixels of a picture 1024 high.
const HALF_WIDTH: f64 = 3.2;
/// The rim around it.
const RIM: f64 = 1.8;
/// Length of the pieces that are tested on their own, in pixels.
const PIECE: f64 = 3.0;
/// Most pieces of one segment of a stroke.
const MOST: f64 = 4096.0;
/// A stroke is drawn in full down to this depth below what the picture shows, and not at all from
/// [`HIDDEN`] on; both as parts of the solid's diagonal.
const SHOWN: f64 = 0.02;
const HIDDEN: f64 = 0.06;

pub(super) fn add(shapes: &mut Vec<Shape>, screen: &Screen<'_>, subject: &Subject) {
    for (number, offset) in screen.scene.offsets.iter().enumerate() {
        let solid = screen.scene.surfaces[number].solid;
        let Some((min, max)) = solid.mesh.bounds() else { continue };
        let diagonal = (max - min).length();
        // What stands before an uncut solid is painted into the air; before a piece it is what was cut off.
        let before_shows = solid.cuts == 0;
        let alpha = |at: DVec2, distance: f64| -> f64 {
            match screen.seen(at) {
                None => f64::from(u8::from(before_shows)),
                Some(seen) if seen.triangle.solid as usize != number => 0.0,
                Some(seen) => {
                    let below = (distance - seen.distance) / diagonal.max(f64::MIN_POSITIVE);
                    let below = if before_shows { below } else { below.abs() };
                    ((HIDDEN - below) / (HIDDEN - SHOWN)).clamp(0.0, 1.0)
                }
            }
        };
        for mark in Mark::all(solid).iter().filter(|mark| mark.show() == subject.show) {
            let (points, colour, arrowed) = match mark {
                Mark::Direction(points) => (points, maps::opaque([38, 34, 40]), true),
                Mark::Depth(p) | Mark::Along(p) | Mark::Across(p) | Mark::Scale(p) => {
                    (&p.points, subject.colour_of(p.value), false)
                }
            };
            let moved: Vec<DVec3> = points.iter().map(|p| *p + *offset).collect();
            let mut segments = pieces(screen, &moved, &alpha);
            if arrowed {
                segments.extend(arrow(segments.last(), subject.unit));
            }
            segments.retain(|s| s.alpha[0] > 0.0 || s.alpha[1] > 0.0);
            if !segments.is_empty() {
                stroke(shapes, &segments, subject.unit, colour);
            }
        }
    }
}

/// A dark edge, a pale rim, and the stroke itself.
fn stroke(shapes: &mut Vec<Shape>, segments: &[Segment], unit: f64, colour: LinearRgba) {
    let half = HALF_WIDTH * unit;
    let dark = maps::opaque([30, 28, 34]);
    let lines = |half_width, colour| Shape::Lines { segments: segments.to_vec(), half_width, colour };
    shapes.push(lines(half + (RIM + 0.9) * unit, dark));
    shapes.push(lines(half + RIM * unit, maps::opaque([255, 255, 255])));
    shapes.push(lines(half, colour));
}

/// A stroke in short pieces on the screen, each as opaque as it is visible. What lies behind the eye is
/// left out.
fn pieces(screen: &Screen<'_>, points: &[DVec3], alpha: &impl Fn(DVec2, f64) -> f64) -> Vec<Segment> {
    let spot = |p: DVec3| {
        let (at, distance) = screen.project(p);
        (distance > 0.0 && at.is_finite()).then(|| (at, alpha(at, distance)))
    };
    let mut segments = Vec::new();
    if let [p] = points {
        segments.extend(spot(*p).map(|(at, a)| Segment { ends: [at; 2], alpha: [a; 2] }));
    }
    for ends in points.windows(2) {
        let length = match (spot(ends[0]), spot(ends[1])) {
            (Some(a), Some(b)) => a.0.distance(b.0),
            _ => f64::from(screen.width.max(screen.height)),
        };
        let count = (length / PIECE).ceil().clamp(1.0, MOST);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // at most MOST
        let steps = count as u32;
        let mut before = spot(ends[0]);
        for k in 1..=steps {
            let here = spot(ends[0].lerp(ends[1], f64::from(k) / count));
            if let (Some(a), Some(b)) = (before, here) {
                segments.push(Segment { ends: [a.0, b.0], alpha: [a.1, b.1] });
            }
            before = here;
        }
    }
    segments
}

/// The two barbs of an arrow at the end of a stroke.
fn arrow(last: Option<&Segment>, unit: f64) -> Vec<Segment> {
    let Some(last) = last else { return Vec::new() };
    let Some(along) = (last.ends[1] - last.ends[0]).try_normalize() else { return Vec::new() };
    let barb = |side: f64| {
        let back = -along * 14.0 + along.perp() * (9.0 * side);
        Segment { ends: [last.ends[1], last.ends[1] + back * unit], alpha: [last.alpha[1]; 2] }
    };
    vec![barb(1.0), barb(-1.0)]
}
