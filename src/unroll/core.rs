//! Where depth ends: a point, an axis, or an inner outline.

use glam::DVec2;

use super::contour;
use super::outline::{self, Outline};
use super::{CoreInput, UnrollError, axis};
use crate::exec::Exec;
use crate::photo::Photograph;

/// The least distance between core and outline, in pixels.
const LEAST_DEPTH: f64 = 4.0;

/// The innermost set, in pixels of the photograph.
pub(super) enum Core {
    /// A point.
    Point(DVec2),
    /// A segment, from its first to its second end.
    Axis([DVec2; 2]),
    /// The closed curve around a hollow, clockwise as seen.
    Curve(Vec<DVec2>),
}

/// The core of a photograph, checked to lie inside its outline.
pub(super) fn place(
    photo: &Photograph,
    outline: &Outline,
    input: CoreInput<'_>,
    smooth: f64,
    exec: &Exec,
) -> Result<Core, UnrollError> {
    let [w, h] = photo.size().map(f64::from);
    let pixel = |p: [f64; 2]| DVec2::new(p[0] * w, p[1] * h);
    let core = match input {
        CoreInput::Centroid => {
            let centre = contour::centroid(&outline.curve);
            if !contour::contains(&outline.curve, centre) {
                return Err(UnrollError::NoCore);
            }
            Core::Point(centre)
        }
        CoreInput::Point(p) => Core::Point(pixel(p)),
        CoreInput::Axis(ends) if ends[0] == ends[1] => return Err(UnrollError::PointAxis),
        CoreInput::Axis(ends) => Core::Axis(ends.map(pixel)),
        CoreInput::FoundAxis => Core::Axis(axis::find(&outline.curve)?),
        CoreInput::Mask(mask) => Core::Curve(outline::inner(photo, mask, smooth, exec)?),
    };
    let witnesses = core.witnesses();
    if let Some(p) = witnesses.iter().find(|p| !contour::contains(&outline.curve, **p)) {
        return Err(UnrollError::CoreOutside([p.x / w, p.y / h]));
    }
    let depths = witnesses.iter().map(|p| contour::distance(&outline.curve, *p));
    let depth = depths.fold(f64::INFINITY, f64::min);
    if depth < LEAST_DEPTH {
        return Err(UnrollError::Shallow(depth));
    }
    Ok(core)
}

impl Core {
    /// Points of it: where all of them lie inside an outline, so does the core.
    fn witnesses(&self) -> Vec<DVec2> {
        match self {
            Self::Point(p) => vec![*p],
            Self::Axis([a, b]) => (0..=100).map(|n| a.lerp(*b, f64::from(n) / 100.0)).collect(),
            Self::Curve(curve) => contour::resampled(curve, 200),
        }
    }

    /// The point of it that is nearest to `p`.
    pub(super) fn nearest(&self, p: DVec2) -> DVec2 {
        match self {
            Self::Point(c) => *c,
            Self::Axis([a, b]) => contour::nearest(*a, *b, p),
            Self::Curve(curve) => {
                let sides = curve.iter().zip(curve.iter().cycle().skip(1));
                let points = sides.map(|(a, b)| contour::nearest(*a, *b, p));
                points.min_by(|a, b| a.distance(p).total_cmp(&b.distance(p))).unwrap_or(p)
            }
        }
    }

    /// A point that the way around starts from, and the direction in which it starts.
    pub(super) fn start(&self) -> (DVec2, DVec2) {
        match self {
            Self::Point(c) => (*c, DVec2::NEG_Y),
            Self::Axis([a, b]) => (*a, (*a - *b).normalize()),
            Self::Curve(curve) => (contour::centroid(curve), DVec2::NEG_Y),
        }
    }

    /// The same in a report: fractions of the photograph.
    pub(super) fn report(&self, size: [u32; 2]) -> Vec<f64> {
        let points = match self {
            Self::Point(c) => vec![*c],
            Self::Axis(ends) => ends.to_vec(),
            Self::Curve(curve) => vec![contour::centroid(curve)],
        };
        points.iter().flat_map(|p| [p.x / f64::from(size[0]), p.y / f64::from(size[1])]).collect()
    }
}
