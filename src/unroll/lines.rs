//! Lines from the outline to the core, and the grid that they make.

use glam::DVec2;
use rayon::prelude::*;

use super::core::Core;
use super::outline::Outline;
use super::params::{Side, UnrollParams};
use super::potential::{Potential, PotentialError};
use super::{UnrollError, contour};
use crate::exec::{Cancelled, Exec};

/// Lines all around; the sides of the polygon that stands for the outline.
const LINES: usize = 480;
/// Sides of the polygon that stands for an inner outline.
const INNER: usize = 200;
/// Stretches of each line.
pub(super) const STRETCHES: usize = 128;
/// What is left out below the outline, at the least, in pixels.
const LEAST_INSET: f64 = 1.0;
/// The most steps along a line.
const MAX_STEPS: usize = 4000;

/// Lines from the outline to the core, clockwise, and how columns are spread over them.
pub(super) struct Lines {
    /// Each line's points at equal distances along it: from the outline (less the inset) to the core.
    pub(super) lines: Vec<[DVec2; STRETCHES + 1]>,
    /// Their lengths in pixels.
    pub(super) lengths: Vec<f64>,
    /// The whole outline, or the side of it that is unrolled, in pixels.
    pub(super) outline_length: f64,
    /// For each line the share of the way around at which it stands, and 1 at the end. The first line is 0's.
    share: Vec<f64>,
}

/// Traces all lines and spreads columns over them.
pub(super) fn trace(
    outline: &Outline,
    core: &Core,
    params: &UnrollParams,
    exec: &Exec,
) -> Result<Lines, UnrollError> {
    let polygon = contour::resampled(&outline.curve, LINES);
    let core = match core {
        Core::Point(c) => Core::Point(*c),
        Core::Axis(ends) => Core::Axis(*ends),
        Core::Curve(curve) => Core::Curve(contour::resampled(curve, INNER)),
    };
    let potential = {
        let _stage = exec.stage("depth", 0);
        exec.install(|| Potential::new(&polygon, &core, exec)).map_err(|e| match e {
            PotentialError::Cancelled(e) => UnrollError::Cancelled(e),
            PotentialError::Solve(e) => UnrollError::Solve(e),
        })?
    };
    let _stage = exec.stage("lines", 0);
    let line = |n: usize| {
        exec.check()?;
        let (a, b) = (polygon[n], polygon[(n + 1) % LINES]);
        Ok(one(&potential, &core, a, b))
    };
    let mut traced: Vec<Vec<DVec2>> =
        exec.install(|| (0..LINES).into_par_iter().map(line).collect::<Result<_, Cancelled>>())?;
    if traced.iter().any(|line| astray(&polygon, line)) {
        return Err(UnrollError::Astray);
    }

    // The first line starts where the way around does.
    let (from, direction) = core.start();
    let first = facing(&traced, from, direction);
    traced.rotate_left(first);
    let whole = contour::length(&polygon);
    let mut outline_length = whole;
    if let (Core::Axis([a, b]), side) = (&core, params.side)
        && side != Side::Both
    {
        let opposite = facing(&traced, *b, (*b - *a).normalize());
        if side == Side::Right {
            traced.truncate(opposite + 1);
        } else {
            let mut left = traced.split_off(opposite);
            left.push(traced.swap_remove(0));
            left.reverse();
            traced = left;
        }
        outline_length = whole * (traced.len() - 1) as f64 / LINES as f64;
    } else {
        // The last line is the first one again.
        traced.push(traced[0].clone());
    }
    // At the outline itself every pixel has some of the background.
    let mean = traced.iter().map(|l| polyline_length(l)).sum::<f64>() / traced.len() as f64;
    let inset = (params.inset * mean).max(LEAST_INSET);
    let mut lengths = Vec::with_capacity(traced.len());
    let lines: Vec<[DVec2; STRETCHES + 1]> = traced
        .iter()
        .map(|line| {
            let (points, length) = even(line, inset);
            lengths.push(length);
            points
        })
        .collect();
    let share = shares(&lines, params.even_at);
    Ok(Lines { lines, lengths, outline_length, share })
}

/// The line that begins at the middle of the outline's side from `a` to `b`.
fn one(potential: &Potential, core: &Core, a: DVec2, b: DVec2) -> Vec<DVec2> {
    let side = a.distance(b);
    let start = a.lerp(b, 0.5);
    // So near to a panel its own density is all that is felt: the first step goes straight inwards. The outline is
    // clockwise as seen, so its inside lies to the right.
    let inwards = (b - a).perp() / side;
    let mut at = start + inwards * (0.5 * side);
    let mut line = vec![start];
    for _ in 0..MAX_STEPS {
        let end = core.nearest(at);
        let left = at.distance(end);
        if left < 0.25 * side {
            line.push(end);
            return line;
        }
        line.push(at);
        let step = (0.2 * left).clamp(0.1 * side, if line.len() < 5 { 0.5 * side } else { 2.0 * side });
        let halfway = at + potential.direction(at) * (0.5 * step);
        let direction = potential.direction(halfway);
        if direction == DVec2::ZERO {
            break;
        }
        at += direction * step;
    }
    line.push(core.nearest(at));
    line
}

/// Whether a line leaves the outline: far from the core around a bend, the potential is nothing but rounding. Where the
/// outline is ragged, lines cut its corners; that is no harm.
fn astray(polygon: &[DVec2], line: &[DVec2]) -> bool {
    let side = polygon[0].distance(polygon[1]);
    (1..12).any(|n| {
        let p = line[n * (line.len() - 1) / 12];
        !contour::contains(polygon, p) && contour::distance(polygon, p) > 2.0 * side
    })
}

/// The line whose beginning lies most nearly in a direction from a point.
fn facing(lines: &[Vec<DVec2>], from: DVec2, direction: DVec2) -> usize {
    let off = |line: &Vec<DVec2>| 1.0 - (line[0] - from).normalize_or_zero().dot(direction);
    let all = lines.iter().enumerate();
    all.min_by(|a, b| off(a.1).total_cmp(&off(b.1))).map_or(0, |(n, _)| n)
}

fn polyline_length(line: &[DVec2]) -> f64 {
    line.windows(2).map(|w| w[0].distance(w[1])).sum()
}

/// A line's points at equal distances, less the first `inset` pixels; and the length of the rest.
fn even(line: &[DVec2], inset: f64) -> ([DVec2; STRETCHES + 1], f64) {
    let whole = polyline_length(line);
    let inset = inset.min(0.5 * whole);
    let rest = whole - inset;
    let mut points = [line[line.len() - 1]; STRETCHES + 1];
    let (mut next, mut along) = (0, 0.0);
    for w in line.windows(2) {
        let piece = w[0].distance(w[1]);
        while next < STRETCHES {
            let wanted = inset + rest * next as f64 / STRETCHES as f64;
            if wanted > along + piece {
                break;
            }
            points[next] = w[0].lerp(w[1], if piece > 0.0 { (wanted - along) / piece } else { 0.0 });
            next += 1;
        }
        along += piece;
    }
    (points, rest)
}

/// Where each line stands on the way around, measured at a depth.
fn shares(lines: &[[DVec2; STRETCHES + 1]], depth: f64) -> Vec<f64> {
    let at = depth * STRETCHES as f64;
    let (n, t) = (at.floor() as usize, at.fract());
    let points: Vec<DVec2> = lines.iter().map(|l| l[n].lerp(l[n + 1], t)).collect();
    let mut along = vec![0.0];
    for w in points.windows(2) {
        // Never nothing, so that every share is some line's.
        along.push(along[along.len() - 1] + w[0].distance(w[1]).max(1e-9));
    }
    let whole = along[along.len() - 1];
    along.iter().map(|a| a / whole).collect()
}

impl Lines {
    pub(super) fn depth_mean(&self) -> f64 {
        self.lengths.iter().sum::<f64>() / self.lengths.len() as f64
    }

    pub(super) fn depth_range(&self) -> [f64; 2] {
        let range = |r: [f64; 2], l: &f64| [r[0].min(*l), r[1].max(*l)];
        self.lengths.iter().fold([f64::INFINITY, 0.0], range)
    }

    /// Where the way around has got to at a share of it: the line before, and how far it is to the next one.
    pub(super) fn column(&self, share: f64) -> (usize, f64) {
        let share = share.clamp(0.0, 1.0);
        let n = self.share.partition_point(|s| *s <= share).clamp(1, self.share.len() - 1);
        let (a, b) = (self.share[n - 1], self.share[n]);
        (n - 1, (share - a) / (b - a))
    }

    /// The place at a column and a depth in \[0, 1\], in pixels of the photograph.
    pub(super) fn at(&self, (line, t): (usize, f64), depth: f64) -> DVec2 {
        let d = (depth * STRETCHES as f64).clamp(0.0, STRETCHES as f64);
        let n = (d.floor() as usize).min(STRETCHES - 1);
        let s = d - n as f64;
        let (a, b) = (&self.lines[line], &self.lines[line + 1]);
        a[n].lerp(a[n + 1], s).lerp(b[n].lerp(b[n + 1], s), t)
    }
}
