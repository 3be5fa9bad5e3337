//! A particle in space, swept from two of its cross-sections around the third \[SST 3.1\].

use std::f64::consts::FRAC_PI_2;

use glam::{DVec2, DVec3};

use super::morph::Morph;
use super::quarter::{Quarter, exponent_of};
use super::section::Section;
use crate::synthesis::Axis;

/// Profiles that fill less of their convex hull are morphed as rigidly as possible, the others by their radius.
const CONVEX: f64 = 0.9;
/// Meridians on which the farthest points are looked for.
const MERIDIANS: usize = 24;

/// Where a point of a particle is seen in its cross-sections.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seen {
    /// By axis that the section is perpendicular to: the point, relative to the section's centre, in voxels.
    pub(super) points: [DVec2; 3],
}

/// A particle about its centre, in voxels.
///
/// With the sweep's axis up, the base lies across it; the two upright sections are seen at the azimuths 0 and π/2 (and π,
/// 3π/2). Between them the upright section is a morph of the two, as wide as the base is there.
#[derive(Debug, Clone)]
pub(super) struct Shape {
    /// The sweep's axis, and the two others.
    axes: [usize; 3],
    /// Quarters of the base, by the signs of the two other axes.
    base: [[Quarter; 2]; 2],
    /// Quarters of the two upright sections: which, the sign of its horizontal half-axis, and that of the sweep's axis.
    upright: [[[Quarter; 2]; 2]; 2],
    /// How far the particle reaches down and up.
    height: [f64; 2],
    /// For each octant whose sections are not convex, their morph: by the three signs.
    morphs: [[[Option<Box<Morph>>; 2]; 2]; 2],
    /// The least box around it: down and up along the three axes.
    bounds: [[f64; 2]; 3],
    /// The distance of its farthest point from its centre.
    reach: f64,
}

/// Coordinates of a point within an octant in which each section's quarter passes through (1, 0) and (0, 1).
#[derive(Debug, Clone, Copy)]
struct Local {
    signs: [usize; 3],
    /// How far the azimuth is from the first upright section to the second, from 0 to 1.
    turn: f64,
    /// Outwards and upwards.
    at: DVec2,
}

fn sign(n: usize) -> f64 {
    if n == 0 { -1.0 } else { 1.0 }
}

impl Shape {
    /// The particle with these sections, by the axis that each is perpendicular to. At least two are given; the third is then
    /// a superellipse as full as they are. None where no section can be the base: none is star-shaped.
    pub(super) fn new(sections: [Option<Section<'_>>; 3]) -> Option<Self> {
        let base = match sections.iter().position(Option::is_none) {
            // What nobody has seen is the base: it has no colours.
            Some(missing) => missing,
            None => [1, 0, 2].into_iter().find(|&a| sections[a].is_some_and(|s| s.is_star_shaped()))?,
        };
        let [u, v] = [(base + 1) % 3, (base + 2) % 3];
        // The section that holds u and the sweep's axis is perpendicular to v.
        let holders = [(v, u), (u, v)];
        let uprights = holders.map(|(perpendicular, _)| sections[perpendicular]);
        let [Some(first), Some(second)] = uprights else { return None };
        let signed = |section: &Section<'_>, perpendicular: usize, along: usize| {
            [0, 1].map(|s| {
                [0, 1].map(|up| {
                    let axis = Axis::ALL[perpendicular];
                    Quarter::new(section, direction(axis, along) * sign(s), direction(axis, base) * sign(up))
                })
            })
        };
        let upright = [signed(&first, v, u), signed(&second, u, v)];
        let height = [0, 1].map(|up| 0.5 * (upright[0][0][up].extent.y + upright[1][0][up].extent.y));
        let quarters = || upright.iter().flatten().flatten();
        let exponent = exponent_of(quarters().map(Quarter::area).sum::<f64>() / 8.0);
        let base_quarters = [0, 1].map(|su| {
            [0, 1].map(|sv| match &sections[base] {
                Some(section) => {
                    let axis = Axis::ALL[base];
                    Quarter::new(section, direction(axis, u) * sign(su), direction(axis, v) * sign(sv))
                }
                None => {
                    let extent = DVec2::new(upright[0][su][0].extent.x, upright[1][sv][0].extent.x);
                    Quarter::superellipse(extent, exponent)
                }
            })
        });
        let convex = |s: &Section<'_>| s.view.profiles.all[s.profile].convexity >= CONVEX;
        let polar = convex(&first) && convex(&second);
        let morph = |su: usize, sv: usize, up: usize| {
            if polar {
                return None;
            }
            let quarter = |perpendicular: usize, along: usize, s: usize, extent: DVec2| {
                let axis = Axis::ALL[perpendicular];
                [direction(axis, along) * (sign(s) * extent.x), direction(axis, base) * (sign(up) * extent.y)]
            };
            let of_first = quarter(v, u, su, upright[0][su][up].extent);
            let of_second = quarter(u, v, sv, upright[1][sv][up].extent);
            let a = |p: DVec2| first.inside(of_first[0] * p.x + of_first[1] * p.y);
            let b = |p: DVec2| second.inside(of_second[0] * p.x + of_second[1] * p.y);
            Morph::new(&a, &b).map(Box::new)
        };
        let morphs = [0, 1].map(|su| [0, 1].map(|sv| [0, 1].map(|up| morph(su, sv, up))));
        let (bounds, reach) = ([[0.0; 2]; 3], 0.0);
        let mut shape =
            Self { axes: [base, u, v], base: base_quarters, upright, height, morphs, bounds, reach };
        let azimuth = |k: usize| 4.0 * k as f64 / MERIDIANS as f64;
        let surface: Vec<DVec3> =
            (0..MERIDIANS).flat_map(|k| shape.meridian(azimuth(k), MERIDIANS)).collect();
        for p in surface {
            shape.reach = shape.reach.max(p.length());
            for a in 0..3 {
                shape.bounds[a][0] = shape.bounds[a][0].max(-p[a]);
                shape.bounds[a][1] = shape.bounds[a][1].max(p[a]);
            }
        }
        Some(shape)
    }

    /// How far it reaches along the three axes, down and up, in voxels, to within what lies between meridians.
    pub(super) fn bounds(&self) -> [[f64; 2]; 3] {
        self.bounds.map(|b| b.map(|r| r * 1.05 + 0.5))
    }

    /// How far its farthest point is from its centre, in voxels.
    pub(super) fn reach(&self) -> f64 {
        self.reach
    }

    /// Whether it may have to grow by less than `factor` to reach a point.
    #[inline]
    pub(super) fn may_reach(&self, p: DVec3, factor: f64) -> bool {
        let farthest = self.reach * 1.05 * factor;
        p.length_squared() < farthest * farthest
    }

    #[inline]
    fn local(&self, p: DVec3) -> Local {
        let [a, u, v] = self.axes.map(|k| p[k]);
        let [up, su, sv] = [a, u, v].map(|c| usize::from(c >= 0.0));
        let base = &self.base[su][sv];
        let flat = DVec2::new(u.abs(), v.abs()) / base.extent;
        let azimuth = flat.y.atan2(flat.x);
        let out = flat.length() / base.radius(azimuth);
        let at = DVec2::new(out, a.abs() / self.height[up]);
        Local { signs: [up, su, sv], turn: azimuth / FRAC_PI_2, at }
    }

    fn quarters(&self, local: &Local) -> [&Quarter; 2] {
        let [up, su, sv] = local.signs;
        [&self.upright[0][su][up], &self.upright[1][sv][up]]
    }

    /// How much the particle must grow to reach a point: less than 1 inside. Beyond 1 in what its outline hides from its centre.
    #[inline]
    pub(super) fn gauge(&self, p: DVec3) -> f64 {
        let local = self.local(p);
        let angle = local.at.y.atan2(local.at.x);
        let [up, su, sv] = local.signs;
        let radius = match &self.morphs[su][sv][up] {
            Some(morph) => morph.radius(local.turn, angle),
            None => {
                let [first, second] = self.quarters(&local).map(|q| q.radius(angle));
                first + (second - first) * local.turn
            }
        };
        local.at.length() / radius
    }

    /// Where a point is seen in the cross-sections; none outside.
    pub(super) fn seen(&self, p: DVec3) -> Option<Seen> {
        let local = self.local(p);
        let [up, su, sv] = local.signs;
        let quarters = self.quarters(&local);
        let [first, second] = match &self.morphs[su][sv][up] {
            Some(morph) => morph.seen(local.turn, local.at)?,
            None => {
                let angle = local.at.y.atan2(local.at.x);
                let [first, second] = quarters.map(|q| q.radius(angle));
                let radius = first + (second - first) * local.turn;
                if local.at.length() > radius {
                    return None;
                }
                [local.at * (first / radius), local.at * (second / radius)]
            }
        };
        let [a, u, v] = self.axes;
        let mut points = [DVec2::ZERO; 3];
        let place = |perpendicular: usize, along: usize, s: usize, q: DVec2| {
            let axis = Axis::ALL[perpendicular];
            direction(axis, along) * (sign(s) * q.x) + direction(axis, a) * (sign(up) * q.y)
        };
        points[v] = place(v, u, su, first * quarters[0].extent);
        points[u] = place(u, v, sv, second * quarters[1].extent);
        // What lies beyond the base's outline is seen on it.
        let flat = direction(Axis::ALL[a], u) * p[u] + direction(Axis::ALL[a], v) * p[v];
        points[a] = flat / local.at.x.max(1.0);
        Some(Seen { points })
    }

    /// Points of the surface at an azimuth (from 0 to 4 quarter turns), from the lower pole to the upper.
    pub(super) fn meridian(&self, azimuth: f64, steps: usize) -> Vec<DVec3> {
        let [a, u, v] = self.axes;
        let quarter = azimuth.rem_euclid(4.0);
        let (su, sv) = [(1, 1), (0, 1), (0, 0), (1, 0)][quarter as usize % 4];
        let fraction = quarter.fract();
        let turn = if su == sv { fraction } else { 1.0 - fraction };
        let base = &self.base[su][sv];
        let angle = turn * FRAC_PI_2;
        let flat =
            DVec2::new(angle.cos() * sign(su), angle.sin() * sign(sv)) * base.extent * base.radius(angle);
        let point = |k: usize| {
            let t = 2.0 * k as f64 / steps as f64 - 1.0;
            let up = usize::from(t >= 0.0);
            let angle = t.abs() * FRAC_PI_2;
            let at = match &self.morphs[su][sv][up] {
                Some(morph) => morph.outline(turn, t.abs()),
                None => {
                    let [first, second] =
                        [&self.upright[0][su][up], &self.upright[1][sv][up]].map(|q| q.radius(angle));
                    DVec2::new(angle.cos(), angle.sin()) * (first + (second - first) * turn)
                }
            };
            let mut p = DVec3::ZERO;
            (p[u], p[v], p[a]) = (flat.x * at.x, flat.y * at.x, sign(up) * at.y * self.height[up]);
            p
        };
        (0..=steps).map(point).collect()
    }
}

/// An axis of the volume as a direction in the picture of a section.
fn direction(section: Axis, along: usize) -> DVec2 {
    if section.right().index() == along { DVec2::X } else { DVec2::Y }
}
