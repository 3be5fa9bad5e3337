//! Direction glyphs: short strokes along the texture's x axis, evenly spaced over the picture.
//!
//! Each is traced over the surface that the picture shows, so that it bends with the field and ends where
//! the surface does. Its length on the surface is the part of the direction that lies in it: a stroke that
//! dives in is short and faint, and a dot where it is seen head on.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::{Screen, Seen, maps};
use crate::exec::{Cancelled, Exec};
use crate::render::overlay::{Segment, Shape};

/// Distance of neighbouring glyphs, in pixels of a picture 1024 high.
const SPACING: f64 = 27.0;
/// Length of a glyph that lies in the surface, as a part of the spacing.
const LENGTH: f64 = 0.86;
/// Steps from a glyph's middle to its end.
const STEPS: usize = 6;
/// Half the width of a glyph, in pixels of a picture 1024 high.
const HALF_WIDTH: f64 = 1.7;
/// Shorter glyphs are dots, in pixels of a picture 1024 high.
const SHORTEST: f64 = 6.0;

/// The direction where a pixel looks.
struct There {
    /// Unit vector R.
    direction: DVec3,
    /// How far R moves on the screen for each unit of length.
    on_screen: DVec2,
    /// The length of R's part in the surface.
    in_surface: f64,
}

pub(super) fn add(
    shapes: &mut Vec<Shape>,
    screen: &Screen<'_>,
    unit: f64,
    exec: &Exec,
) -> Result<(), Cancelled> {
    let spacing = SPACING * unit;
    // Every other row is shifted, and each place a little: rows of dashes would show the grid.
    let row_height = spacing * 0.75f64.sqrt();
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // sizes of pictures
    let (columns, rows) = (
        (f64::from(screen.width) / spacing).ceil() as u32 + 1,
        (f64::from(screen.height) / row_height).ceil() as u32,
    );
    let by_row: Vec<Vec<Shape>> = (0..rows)
        .into_par_iter()
        .map(|row| {
            exec.check()?;
            let mut found = Vec::new();
            for column in 0..columns {
                let jitter = jitter(column, row) * 0.3;
                let shift = if row % 2 == 0 { 0.25 } else { 0.75 };
                let at = DVec2::new(
                    (f64::from(column) - 0.25 + shift + jitter.x) * spacing,
                    (f64::from(row) + 0.5 + jitter.y) * row_height,
                );
                found.extend(glyph(screen, at, spacing, unit).into_iter().flatten());
            }
            Ok(found)
        })
        .collect::<Result<_, Cancelled>>()?;
    shapes.extend(by_row.into_iter().flatten());
    Ok(())
}

/// A pale rim and the glyph itself; nothing where the picture shows no surface.
fn glyph(screen: &Screen<'_>, at: DVec2, spacing: f64, unit: f64) -> Option<[Shape; 2]> {
    let seen = screen.seen(at)?;
    let there = look(screen, &seen, at, None)?;
    let step = spacing * LENGTH * 0.5 / STEPS as f64 * screen.pixel() * seen.distance;
    let back = trace(screen, at, &seen, &there, -step);
    let forth = trace(screen, at, &seen, &there, step);
    let mut points: Vec<DVec2> = back.into_iter().rev().collect();
    points.push(at);
    points.extend(forth);
    let length: f64 = points.windows(2).map(|w| w[0].distance(w[1])).sum();
    let alpha = 0.55 + 0.45 * there.in_surface;
    let mut half = HALF_WIDTH * unit;
    if length < SHORTEST * unit {
        points = vec![at];
        half *= 1.35;
    }
    let line = |half, colour, alpha| {
        let mut shape = Shape::line(&points, half, colour, alpha);
        if let Shape::Lines { segments, .. } = &mut shape {
            segments.retain(|s: &Segment| s.ends[0].is_finite() && s.ends[1].is_finite());
        }
        shape
    };
    let rim = line(half + 1.1 * unit, maps::opaque([250, 248, 244]), 0.75 * alpha);
    Some([rim, line(half, maps::direction(there.direction), alpha)])
}

/// Follows the direction over the surface from `at`, in steps of `step` along it.
fn trace(screen: &Screen<'_>, at: DVec2, start: &Seen<'_>, first: &There, step: f64) -> Vec<DVec2> {
    let mut points = Vec::with_capacity(STEPS);
    let (mut at, mut before) = (at, *start);
    let (mut direction, mut on_screen) = (first.direction, first.on_screen);
    for _ in 0..STEPS {
        at += on_screen * step;
        let Some(seen) = screen.seen(at) else { break };
        let surface = &screen.scene.surfaces[seen.triangle.solid as usize];
        let same = seen.triangle.solid == start.triangle.solid
            && surface.same_kind(seen.triangle.face as usize, start.triangle.face as usize)
            && (seen.distance - before.distance).abs() < 4.0 * step.abs();
        if !same {
            break;
        }
        points.push(at);
        let Some(there) = look(screen, &seen, at, Some(direction)) else { break };
        (before, direction, on_screen) = (seen, there.direction, there.on_screen);
    }
    points
}

/// The direction at a point that a pixel sees; `like` chooses between the two signs.
fn look(screen: &Screen<'_>, seen: &Seen<'_>, at: DVec2, like: Option<DVec3>) -> Option<There> {
    let surface = &screen.scene.surfaces[seen.triangle.solid as usize];
    let face = seen.triangle.face as usize;
    let r = surface.faces[face]
        .map(|p| surface.solid.frame[surface.points[p as usize].vertex as usize][0].normalize_or_zero());
    // Fibres have no sign: the corners agree on one before they are averaged.
    let agree = |v: DVec3| if v.dot(r[0]) < 0.0 { -v } else { v };
    let sum: DVec3 = r.iter().zip(seen.weights).map(|(v, w)| agree(*v) * w).sum();
    let direction = sum.try_normalize()?;
    let direction = if like.is_some_and(|l| l.dot(direction) < 0.0) { -direction } else { direction };
    let normal = surface.flat[face];
    let along = direction - normal * normal.dot(direction);
    // A pixel's worth of it, on the screen.
    let size = f64::from(screen.width.max(screen.height));
    let place = screen.view.eye
        + screen.view.ray(at / DVec2::new(f64::from(screen.width), f64::from(screen.height))) * seen.distance;
    let small = screen.pixel() * seen.distance * (size / 1024.0).max(1.0);
    let (moved, z) = screen.project(place + along * small);
    let on_screen = (moved - at) / small;
    (z > 0.0 && on_screen.is_finite()).then(|| There { direction, on_screen, in_surface: along.length() })
}

/// Two numbers in −1…1 of a place in the grid.
fn jitter(column: u32, row: u32) -> DVec2 {
    let mut h = column.wrapping_mul(0x9e37_79b9) ^ row.wrapping_mul(0x85eb_ca6b);
    h = (h ^ h >> 15).wrapping_mul(0x2c1b_3c6d);
    h = (h ^ h >> 12).wrapping_mul(0x297a_2d39);
    h ^= h >> 15;
    DVec2::new(f64::from(h & 0xffff), f64::from(h >> 16)) / 32767.5 - 1.0
}
