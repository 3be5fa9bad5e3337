//! Numbers at the vertices, as numbers from 0 to 1 that have colours.

use super::{Show, maps};
use crate::colour::LinearRgba;
use crate::lap::LappedSolid;
use crate::render::Surface;

/// The values of a field over all that is drawn.
pub(super) struct Values {
    /// For each solid, at its vertices, from 0 to 1.
    solids: Vec<Vec<f64>>,
    /// Of a scale: the least and the greatest; 0 is the least, 1 the greatest, equal steps are equal ratios.
    pub(super) range: Option<[f64; 2]>,
}

/// Scales whose ratio is nearer to 1 than this are one.
const ONE_SCALE: f64 = 1.0 + 1e-6;

impl Values {
    /// What a picture shows, where that is a number at each vertex.
    pub(super) fn new(show: Show, surfaces: &[Surface<'_>]) -> Option<Self> {
        let field: fn(&LappedSolid) -> Vec<f64> = match show {
            Show::Depth => |s| s.depth.clone(),
            Show::Along => |s| s.along.clone(),
            Show::Across => |s| s.across.clone(),
            Show::Scale => scales,
            _ => return None,
        };
        let mut solids: Vec<Vec<f64>> = surfaces.iter().map(|s| field(s.solid)).collect();
        let mut range = None;
        if show == Show::Scale {
            let all = || solids.iter().flatten();
            let least = all().copied().fold(f64::INFINITY, f64::min);
            let most = all().copied().fold(0.0, f64::max);
            range = Some([least, most]);
            for value in solids.iter_mut().flatten() {
                *value = part(*value, [least, most]);
            }
        }
        Some(Self { solids, range })
    }

    /// The value at a vertex, from 0 to 1.
    pub(super) fn at(&self, solid: usize, vertex: u32) -> f64 {
        self.solids[solid][vertex as usize]
    }

    /// A number of the field itself, from 0 to 1.
    pub(super) fn part(&self, value: f64) -> f64 {
        self.range.map_or(value, |range| part(value, range))
    }

    /// The number at a place from 0 to 1.
    pub(super) fn number(&self, part: f64) -> f64 {
        self.range.map_or(part, |[least, most]| least * (most / least).powf(part))
    }

    /// Whether it is one number everywhere.
    pub(super) fn is_one(&self) -> bool {
        self.range.is_some_and(|[least, most]| most <= least * ONE_SCALE)
    }

    /// The colour of a value from 0 to 1.
    pub(super) fn colour(&self, value: f64) -> LinearRgba {
        if self.range.is_some() { maps::scale(value) } else { maps::depth(value) }
    }
}

fn part(value: f64, [least, most]: [f64; 2]) -> f64 {
    if most <= least * ONE_SCALE { 0.5 } else { ((value / least).ln() / (most / least).ln()).clamp(0.0, 1.0) }
}

/// The world length of one unit of texture at each vertex, along the first axis that no field is.
fn scales(solid: &LappedSolid) -> Vec<f64> {
    let axis = solid.kind().map_or(0, |k| k.given().iter().position(|given| !given).unwrap_or(0));
    let length = |f: &[glam::DVec3; 3]| f[axis].length().clamp(f64::MIN_POSITIVE, f64::MAX);
    solid.frame.iter().map(length).collect()
}
