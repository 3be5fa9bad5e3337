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

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use super::*;
    use crate::particles::align::section;
    use crate::particles::testing::{discs, rectangles, view};
    use crate::particles::view::View;

    /// The particle of the first profiles of three views.
    fn shape(views: [Option<&View>; 3]) -> Shape {
        Shape::new(views.map(|v| Some(section(v?, 0, 0)))).unwrap()
    }

    fn volume(shape: &Shape) -> f64 {
        let side = |n: i32| f64::from(n) + 0.5;
        let cube = (0..64i32.pow(3)).map(|n| [n % 64 - 32, n / 64 % 64 - 32, n / 4096 - 32]);
        cube.filter(|&c| shape.gauge(DVec3::from(c.map(side))) < 1.0).count() as f64
    }

    /// A photograph with a rectangle, and another that is of no interest.
    fn rectangle(width: f64, height: f64) -> View {
        view([64; 2], [false; 2], 1, rectangles([[2.0, 2.0, width, height], [50.0, 50.0, 5.0, 5.0]], [90; 3]))
    }

    #[test]
    fn discs_make_a_ball() {
        let disc = view([48; 2], [false; 2], 1, discs([[16.0, 16.0, 12.0], [38.0, 38.0, 4.0]], [90; 3]));
        for views in [[Some(&disc); 3], [Some(&disc), None, Some(&disc)], [None, Some(&disc), Some(&disc)]] {
            let ball = shape(views);
            let expected = 4.0 / 3.0 * PI * 12.0f64.powi(3);
            assert!((volume(&ball) / expected - 1.0).abs() < 0.05, "{} {expected}", volume(&ball));
            assert!((ball.reach() - 12.0).abs() < 0.6, "{}", ball.reach());
        }
    }

    #[test]
    fn rectangles_make_a_box() {
        // 12 along x, 16 along y, 21 along z.
        let (x, y, z) = (rectangle(21.0, 16.0), rectangle(12.0, 21.0), rectangle(12.0, 16.0));
        let brick = shape([Some(&x), Some(&y), Some(&z)]);
        let expected = 12.0 * 16.0 * 21.0;
        assert!((volume(&brick) / expected - 1.0).abs() < 0.05, "{} {expected}", volume(&brick));
        for (found, half) in brick.bounds().iter().zip([6.0, 8.0, 10.5]) {
            assert!(found.iter().all(|r| (r - half).abs() < 0.1 * half + 0.5), "{found:?}");
        }
        // Across the direction without a photograph it is as full as across the others.
        let without = shape([Some(&x), None, Some(&z)]);
        assert!((volume(&without) / expected - 1.0).abs() < 0.1, "{} {expected}", volume(&without));
    }

    /// Three convex outlines without any symmetry.
    fn lopsided() -> [View; 3] {
        [[9.0, 13.0, 0.3], [12.0, 8.0, 1.9], [10.0, 11.0, 4.0]].map(|[a, b, phase]| {
            view([48; 2], [false; 2], 1, |p| {
                let d = p - 20.0;
                let radius = 1.0 + 0.12 * (d.to_angle() + phase).cos();
                let small = p.distance(DVec2::splat(42.0)) < 3.0;
                (small || (d / DVec2::new(a, b)).length() < radius).then_some([90; 3])
            })
        })
    }

    #[test]
    fn in_its_plane_the_third_section_is_the_outline() {
        let [x, y, z] = lopsided();
        let made = shape([Some(&x), Some(&y), Some(&z)]);
        assert_eq!(made.axes[0], 1);
        let base = section(&y, 0, 0);
        for k in 0..90 {
            let direction = DVec2::from_angle(TAU * f64::from(k) / 90.0);
            let edge = direction * base.reach(direction);
            // Across y, x runs to the right and z down. Between the angles at which it is known the outline is straight.
            let gauge = made.gauge(DVec3::new(edge.x, 0.0, edge.y));
            assert!((gauge - 1.0).abs() < 0.03, "{k}: {gauge}");
            let seen = made.seen(DVec3::new(edge.x, 0.0, edge.y) * 0.7).unwrap();
            assert!(seen.points[1].distance(edge * 0.7) < 1e-9);
        }
    }

    #[test]
    fn meridians_lie_on_the_surface() {
        let [x, y, z] = lopsided();
        for made in [shape([Some(&x), Some(&y), Some(&z)]), shape([Some(&x), Some(&y), None])] {
            let mut farthest: f64 = 0.0;
            for k in 0..40 {
                for p in made.meridian(0.1 * f64::from(k), 20) {
                    assert!((made.gauge(p) - 1.0).abs() < 1e-6, "{k} {p}: {}", made.gauge(p));
                    assert!(made.seen(p * 0.99).is_some() && made.seen(p * 1.01).is_none());
                    farthest = farthest.max(p.length());
                    let bounds = made.bounds();
                    assert!((0..3).all(|a| -bounds[a][0] <= p[a] && p[a] <= bounds[a][1]));
                }
            }
            assert!((farthest / made.reach() - 1.0).abs() < 0.05);
        }
    }

    #[test]
    fn what_is_seen_lies_in_every_section() {
        let bean = view([64; 2], [false; 2], 1, |p| {
            let d = p - DVec2::new(24.0, 20.0);
            let bean = (d / DVec2::new(20.0, 13.0)).length() < 1.0 && d.distance(DVec2::new(0.0, 14.0)) > 8.0;
            (bean || p.distance(DVec2::splat(56.0)) < 4.0).then_some([90; 3])
        });
        assert!(bean.profiles.all[0].convexity < CONVEX);
        let disc = view([48; 2], [false; 2], 1, discs([[16.0, 16.0, 12.0], [38.0, 38.0, 4.0]], [90; 3]));
        let made = shape([Some(&disc), Some(&disc), Some(&bean)]);
        let mut inside = 0;
        for n in 0..24usize.pow(3) {
            let p = DVec3::from([n % 24, n / 24 % 24, n / 576].map(|c| 2.0 * c as f64 - 23.0));
            let Some(seen) = made.seen(p) else { continue };
            inside += 1;
            assert!(made.gauge(p) <= 1.0 + 1e-6, "{p}: {}", made.gauge(p));
            for (a, view) in [&disc, &disc, &bean].into_iter().enumerate() {
                // To within a pixel of the outline.
                let reached = (0..9).any(|k| {
                    let d = DVec2::new(f64::from(k % 3 - 1), f64::from(k / 3 - 1));
                    section(view, 0, 0).inside(seen.points[a] + d)
                });
                assert!(reached, "{p} across {a}: {}", seen.points[a]);
            }
        }
        assert!(inside > 400, "{inside}");
    }
}
