//! What a lapped solid has at its vertices, and what it has between two of them.

use glam::{DMat3, DVec3};

use super::LappedSolid;

/// The fields at one vertex.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct AtVertex {
    depth: f64,
    along: f64,
    across: f64,
    frame: [DVec3; 3],
}

/// The fields of some vertices, as [`LappedSolid`] has them.
pub(crate) struct AtVertices {
    pub(crate) depth: Vec<f64>,
    pub(crate) along: Vec<f64>,
    pub(crate) across: Vec<f64>,
    pub(crate) frame: Vec<[DVec3; 3]>,
}

impl AtVertex {
    /// The fields part way from here to there, `t` from 0 to 1. A frame's vectors are interpolated as lines, since its
    /// signs mean nothing, and made orthogonal again, S staying as it is; its lengths are interpolated.
    pub(crate) fn between(&self, other: &Self, t: f64) -> Self {
        let mix = |a: f64, b: f64| a + (b - a) * t;
        Self {
            depth: mix(self.depth, other.depth),
            along: mix(self.along, other.along),
            across: mix(self.across, other.across),
            frame: frame_between(&self.frame, &other.frame, t),
        }
    }
}

fn frame_between(a: &[DVec3; 3], b: &[DVec3; 3], t: f64) -> [DVec3; 3] {
    let length: [f64; 3] = std::array::from_fn(|n| a[n].length() * (1.0 - t) + b[n].length() * t);
    let blend = |n: usize| a[n] * (1.0 - t) + b[n] * if a[n].dot(b[n]) < 0.0 { -t } else { t };
    let s = blend(1).normalize_or_zero();
    let r = blend(0).reject_from(if s == DVec3::ZERO { DVec3::X } else { s }).normalize_or_zero();
    if s == DVec3::ZERO || r == DVec3::ZERO {
        return if t < 0.5 { *a } else { *b };
    }
    let hand = if DMat3::from_cols(a[0], a[1], a[2]).determinant() < 0.0 { -1.0 } else { 1.0 };
    [r * length[0], s * length[1], r.cross(s) * (hand * length[2])]
}

impl LappedSolid {
    /// The fields at a vertex; 0 for those that it does not have.
    pub(crate) fn at_vertex(&self, v: u32) -> AtVertex {
        let v = v as usize;
        let or_none = |field: &[f64]| field.get(v).copied().unwrap_or(0.0);
        AtVertex {
            depth: self.depth[v],
            along: or_none(&self.along),
            across: or_none(&self.across),
            frame: self.frame[v],
        }
    }

    /// The fields of other vertices, as lists: those that this solid does not have are empty.
    pub(crate) fn collected(&self, vertices: &(impl Iterator<Item = AtVertex> + Clone)) -> AtVertices {
        let kept = |field: &[f64], of: fn(AtVertex) -> f64| {
            if field.is_empty() { Vec::new() } else { vertices.clone().map(of).collect() }
        };
        AtVertices {
            depth: vertices.clone().map(|v| v.depth).collect(),
            along: kept(&self.along, |v| v.along),
            across: kept(&self.across, |v| v.across),
            frame: vertices.clone().map(|v| v.frame).collect(),
        }
    }
}
