//! The edges at which a solid's frames are singular, seen through its faded surface \[LST 7\].

use glam::DVec2;

use super::{Screen, maps};
use crate::field::{FrameAxes, singularities_of_vertices};
use crate::lap::{LappedSolid, TextureType};
use crate::render::overlay::{Segment, Shape};

/// Half the width of an edge, in pixels of a picture 1024 high.
const HALF_WIDTH: f64 = 2.2;
/// What is left of an edge's opacity one diagonal of the solid below its surface.
const DEEPEST: f64 = 0.4;

/// What of the frames a solid's texture type fixes.
fn axes(solid: &LappedSolid) -> FrameAxes {
    let line_field = solid.settings.pointer("/direction/smooth/line_field");
    let line_field = line_field.and_then(serde_json::Value::as_bool).unwrap_or(false);
    match (solid.kind(), line_field) {
        (Some(TextureType::Type1a), true) => FrameAxes::Line,
        (Some(TextureType::Type1a), false) => FrameAxes::R,
        (Some(TextureType::Type1b), _) => FrameAxes::S,
        (_, true) => FrameAxes::Lines,
        (_, false) => FrameAxes::All,
    }
}

pub(super) fn add(shapes: &mut Vec<Shape>, screen: &Screen<'_>, unit: f64) {
    for (number, offset) in screen.scene.offsets.iter().enumerate() {
        let solid = screen.scene.surfaces[number].solid;
        let Some((min, max)) = solid.mesh.bounds() else { continue };
        let diagonal = (max - min).length().max(f64::MIN_POSITIVE);
        let alpha = |at: DVec2, distance: f64| match screen.seen(at) {
            Some(seen) if seen.triangle.solid as usize == number => {
                let below = ((distance - seen.distance) / diagonal).clamp(0.0, 1.0);
                1.0 + (DEEPEST - 1.0) * below
            }
            _ => 1.0,
        };
        let segments: Vec<Segment> = singularities_of_vertices(&solid.mesh, &solid.frame, axes(solid))
            .edges
            .iter()
            .filter_map(|edge| {
                let ends = edge.map(|v| screen.project(solid.mesh.vertices[v as usize] + *offset));
                ends.iter().all(|(at, z)| *z > 0.0 && at.is_finite()).then(|| Segment {
                    ends: ends.map(|(at, _)| at),
                    alpha: ends.map(|(at, z)| alpha(at, z)),
                })
            })
            .collect();
        if segments.is_empty() {
            continue;
        }
        let half_width = HALF_WIDTH * unit;
        let rim = maps::opaque([255, 250, 250]);
        shapes.push(Shape::Lines {
            segments: segments.clone(),
            half_width: half_width + 1.2 * unit,
            colour: rim,
        });
        shapes.push(Shape::Lines { segments, half_width, colour: maps::opaque([206, 18, 38]) });
    }
}
