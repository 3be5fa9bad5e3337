//! As-rigid-as-possible morphs of quarters of cross-sections that are not convex \[SST 3.1\], after Alexa, Cohen-Or & Levin,
//! *As-Rigid-As-Possible Shape Interpolation*, SIGGRAPH 2000.

use std::f64::consts::FRAC_PI_2;

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use glam::{DMat2, DVec2};
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

use super::quarter_outline::outline;

/// Points on the outline, and on each of the half-axes.
const OUTER: usize = 25;
const ON_AXIS: usize = 8;
/// Steps of the morph.
const STEPS: usize = 17;
/// Angles at which each step's reach is known.
const ANGLES: usize = 33;
/// Rounds in which the triangles of the second quarter are made like those of the first.
const ROUNDS: usize = 8;

/// A morph of one quarter into another, in coordinates in which both pass through (1, 0) and (0, 1).
#[derive(Debug, Clone)]
pub(super) struct Morph {
    triangles: Vec<[usize; 3]>,
    /// Vertices at each step, those on the outline first.
    steps: Vec<Vec<DVec2>>,
    /// How far the outline reaches at each step, by angle.
    reach: Vec<[f64; ANGLES]>,
}

impl Morph {
    /// Of the quarters that `first` and `second` tell the inside of. None where either is in pieces, or where they are too
    /// different for triangles of one to become those of the other unturned.
    pub(super) fn new(first: &dyn Fn(DVec2) -> bool, second: &dyn Fn(DVec2) -> bool) -> Option<Self> {
        let [from, to] = [outline(first, OUTER)?, outline(second, OUTER)?];
        let (rest, triangles) = triangulated(&from)?;
        let system = System::new(&rest, &triangles);
        let target = system.fitted(&rest, &triangles, &to)?;
        let maps: Vec<DMat2> =
            triangles.iter().map(|t| jacobian(&target, t) * jacobian(&rest, t).inverse()).collect();
        let steps: Vec<Vec<DVec2>> = (0..STEPS)
            .map(|k| {
                let turn = k as f64 / (STEPS - 1) as f64;
                let wanted: Vec<DMat2> = maps.iter().map(|m| between(*m, turn)).collect();
                system.axes_fixed.solve(&system, &triangles, &rest, &wanted, |n| rest[n])
            })
            .collect();
        let reach = steps.iter().map(|s| reach(&s[..OUTER])).collect();
        Some(Self { triangles, steps, reach })
    }

    /// How far the outline reaches at an angle, at a step between 0 and 1.
    pub(super) fn radius(&self, turn: f64, angle: f64) -> f64 {
        let at = (angle / FRAC_PI_2).clamp(0.0, 1.0) * (ANGLES - 1) as f64;
        let n = (at as usize).min(ANGLES - 2);
        let of = |k: usize| self.reach[k][n] + (self.reach[k][n + 1] - self.reach[k][n]) * (at - n as f64);
        let (k, f) = step(turn);
        of(k) + (of(k + 1) - of(k)) * f
    }

    /// Where a point lies in the first and in the second quarter; none outside.
    pub(super) fn seen(&self, turn: f64, p: DVec2) -> Option<[DVec2; 2]> {
        let vertices = &self.steps[(turn.clamp(0.0, 1.0) * (STEPS - 1) as f64).round() as usize];
        self.triangles.iter().find_map(|t| {
            let jacobian = jacobian(vertices, t);
            let q = jacobian.inverse() * (p - vertices[t[0]]);
            let weights = [1.0 - q.x - q.y, q.x, q.y];
            weights.iter().all(|&w| w >= -1e-6).then(|| {
                [&self.steps[0], &self.steps[STEPS - 1]]
                    .map(|v| (0..3).map(|k| v[t[k]] * weights[k]).sum::<DVec2>())
            })
        })
    }

    /// A point of the outline, from (1, 0) at 0 to (0, 1) at 1.
    pub(super) fn outline(&self, turn: f64, along: f64) -> DVec2 {
        let at = along.clamp(0.0, 1.0) * (OUTER - 1) as f64;
        let n = (at as usize).min(OUTER - 2);
        let of = |k: usize| self.steps[k][n].lerp(self.steps[k][n + 1], at - n as f64);
        let (k, f) = step(turn);
        of(k).lerp(of(k + 1), f)
    }
}

fn step(turn: f64) -> (usize, f64) {
    let at = turn.clamp(0.0, 1.0) * (STEPS - 1) as f64;
    let k = (at as usize).min(STEPS - 2);
    (k, at - k as f64)
}

fn jacobian(vertices: &[DVec2], t: &[usize; 3]) -> DMat2 {
    DMat2::from_cols(vertices[t[1]] - vertices[t[0]], vertices[t[2]] - vertices[t[0]])
}

/// Rotation and stretch of a map, each a part of the way.
fn between(map: DMat2, turn: f64) -> DMat2 {
    let angle = rotation(map);
    let stretch = DMat2::from_angle(-angle) * map;
    let part = DMat2::IDENTITY * (1.0 - turn) + stretch * turn;
    DMat2::from_angle(turn * angle) * part
}

/// The angle of the rotation nearest to a map.
fn rotation(m: DMat2) -> f64 {
    (m.x_axis.y - m.y_axis.x).atan2(m.x_axis.x + m.y_axis.y)
}

/// The farthest that an outline reaches at each angle.
fn reach(line: &[DVec2]) -> [f64; ANGLES] {
    std::array::from_fn(|n| {
        let direction = DVec2::from_angle(FRAC_PI_2 * n as f64 / (ANGLES - 1) as f64);
        let crossing = |w: &[DVec2]| {
            let [a, b] = [w[0].perp_dot(direction), w[1].perp_dot(direction)];
            (a * b <= 0.0 && a != b).then(|| w[0].lerp(w[1], a / (a - b)).dot(direction))
        };
        line.windows(2).filter_map(crossing).fold(0.05, f64::max)
    })
}

/// The points of a triangulation within an outline (its own first, then those on the half-axes from the first axis's end
/// to the second's, then those inside), and its triangles, counter-clockwise.
fn triangulated(line: &[DVec2]) -> Option<(Vec<DVec2>, Vec<[usize; 3]>)> {
    let part = |k: usize| k as f64 / ON_AXIS as f64;
    let mut points = line.to_vec();
    points.extend((0..=ON_AXIS).rev().skip(1).map(|k| DVec2::new(0.0, part(k))));
    points.extend((1..ON_AXIS).map(|k| DVec2::new(part(k), 0.0)));
    let rim = points.len();
    let spacing = 1.0 / ON_AXIS as f64;
    for n in 0..4 * ON_AXIS * ON_AXIS {
        let p = DVec2::new((n % (2 * ON_AXIS)) as f64 + 0.5, (n / (2 * ON_AXIS)) as f64 + 0.5) * spacing;
        let clear = (0..rim).all(|k| distance(p, points[k], points[(k + 1) % rim]) > 0.4 * spacing);
        if clear && within(p, &points[..rim]) {
            points.push(p);
        }
    }
    let mut mesh = ConstrainedDelaunayTriangulation::<Point2<f64>>::new();
    let mut handles = Vec::new();
    for p in &points {
        handles.push(mesh.insert(Point2::new(p.x, p.y)).ok()?);
    }
    if mesh.num_vertices() != points.len() {
        return None;
    }
    for k in 0..rim {
        let (a, b) = (handles[k], handles[(k + 1) % rim]);
        if !mesh.can_add_constraint(a, b) {
            return None;
        }
        mesh.add_constraint(a, b);
    }
    let triangles: Vec<[usize; 3]> = mesh
        .inner_faces()
        .map(|face| face.vertices().map(|v| v.index()))
        .filter(|t| within((points[t[0]] + points[t[1]] + points[t[2]]) / 3.0, &points[..rim]))
        .collect();
    let even = triangles.iter().all(|t| jacobian(&points, t).determinant() > 1e-9);
    even.then_some((points, triangles))
}

fn distance(p: DVec2, a: DVec2, b: DVec2) -> f64 {
    let t = ((p - a).dot(b - a) / (b - a).length_squared().max(1e-12)).clamp(0.0, 1.0);
    p.distance(a.lerp(b, t))
}

fn within(p: DVec2, polygon: &[DVec2]) -> bool {
    let crosses = |k: usize| {
        let (a, b) = (polygon[k], polygon[(k + 1) % polygon.len()]);
        (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)
    };
    (0..polygon.len()).filter(|&k| crosses(k)).count() % 2 == 1
}

/// Least squares Σ area |J − wanted|² over the vertices that are free; factored once.
struct Factor {
    /// For each vertex its unknown, if it is free.
    unknown: Vec<Option<usize>>,
    llt: faer::linalg::solvers::Llt<f64>,
}

/// Gradients of the triangles, and the two systems that are solved with them.
struct System {
    areas: Vec<f64>,
    /// For each triangle the gradients of its vertices' weights.
    gradients: Vec<[DVec2; 3]>,
    /// The rim is given: what lies inside is free.
    rim_fixed: Factor,
    /// The half-axes are given: the outline is free, too.
    axes_fixed: Factor,
}

impl System {
    fn new(rest: &[DVec2], triangles: &[[usize; 3]]) -> Self {
        let areas: Vec<f64> = triangles.iter().map(|t| 0.5 * jacobian(rest, t).determinant()).collect();
        let gradients: Vec<[DVec2; 3]> = triangles
            .iter()
            .map(|t| {
                let inverse = jacobian(rest, t).inverse().transpose();
                let [b, c] = [inverse.x_axis, inverse.y_axis];
                [-b - c, b, c]
            })
            .collect();
        let rim = OUTER + 2 * ON_AXIS - 1;
        let factor = |free: &dyn Fn(usize) -> bool| {
            let mut count = 0;
            let unknown: Vec<Option<usize>> = (0..rest.len())
                .map(|n| {
                    count += usize::from(free(n));
                    free(n).then(|| count - 1)
                })
                .collect();
            let mut matrix = Mat::<f64>::identity(count.max(1), count.max(1)) * faer::Scale(1e-9);
            for ((t, g), area) in triangles.iter().zip(&gradients).zip(&areas) {
                for i in 0..3 {
                    for j in 0..3 {
                        if let (Some(a), Some(b)) = (unknown[t[i]], unknown[t[j]]) {
                            matrix[(a, b)] += area * g[i].dot(g[j]);
                        }
                    }
                }
            }
            let llt = matrix.llt(Side::Lower).expect("a Laplacian with given values is positive definite");
            Factor { unknown, llt }
        };
        let rim_fixed = factor(&|n| n >= rim);
        let axes_fixed = factor(&|n| (1..OUTER - 1).contains(&n) || n >= rim);
        Self { areas, gradients, rim_fixed, axes_fixed }
    }

    /// Vertices of the same triangles within another outline, each triangle as near to its own shape as can be; none where
    /// one turns over.
    fn fitted(&self, rest: &[DVec2], triangles: &[[usize; 3]], line: &[DVec2]) -> Option<Vec<DVec2>> {
        let given = |n: usize| if n < OUTER { line[n] } else { rest[n] };
        let mut wanted = vec![DMat2::ZERO; triangles.len()];
        let mut vertices = self.rim_fixed.solve(self, triangles, rest, &wanted, given);
        for _ in 0..ROUNDS {
            for (wanted, t) in wanted.iter_mut().zip(triangles) {
                let map = jacobian(&vertices, t) * jacobian(rest, t).inverse();
                *wanted = DMat2::from_angle(rotation(map));
            }
            vertices = self.rim_fixed.solve(self, triangles, rest, &wanted, given);
        }
        let upright = triangles.iter().all(|t| jacobian(&vertices, t).determinant() > 1e-9);
        upright.then_some(vertices)
    }
}

impl Factor {
    /// The vertices whose triangles are nearest to the maps that are wanted; `given` has those that are not free.
    fn solve(
        &self,
        system: &System,
        triangles: &[[usize; 3]],
        rest: &[DVec2],
        wanted: &[DMat2],
        given: impl Fn(usize) -> DVec2,
    ) -> Vec<DVec2> {
        let count = self.unknown.iter().flatten().count();
        let mut right = Mat::<f64>::zeros(count.max(1), 2);
        for (n, t) in triangles.iter().enumerate() {
            let (area, g) = (system.areas[n], &system.gradients[n]);
            for i in 0..3 {
                let Some(a) = self.unknown[t[i]] else { continue };
                let mut pull = wanted[n] * g[i];
                for j in (0..3).filter(|&j| self.unknown[t[j]].is_none()) {
                    pull -= given(t[j]) * g[i].dot(g[j]);
                }
                right[(a, 0)] += area * pull.x;
                right[(a, 1)] += area * pull.y;
            }
        }
        let found = self.llt.solve(&right);
        (0..rest.len())
            .map(|n| self.unknown[n].map_or_else(|| given(n), |a| DVec2::new(found[(a, 0)], found[(a, 1)])))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn disk(p: DVec2) -> bool {
        p.length() < 1.0
    }

    fn indented(p: DVec2) -> bool {
        p.max_element() < 1.0 && p.min_element() < 0.6
    }

    #[test]
    fn a_morph_begins_and_ends_with_its_quarters() {
        let morph = Morph::new(&disk, &indented).unwrap();
        for (n, inside) in [(0, disk as fn(DVec2) -> bool), (1, indented)] {
            let turn = n as f64;
            for k in 0..400 {
                let p = DVec2::new((k % 20) as f64, (k / 20) as f64) * 0.06 + 0.03;
                let seen = morph.seen(turn, p);
                if let Some(seen) = seen {
                    assert!(seen[n].distance(p) < 1e-3, "{p} {}", seen[n]);
                }
                // But for a cell along the outline.
                let steady = (0..9).all(|m| {
                    inside(p + (DVec2::new((m % 3) as f64, (m / 3) as f64) - 1.0) * 0.07) == inside(p)
                });
                if steady {
                    assert_eq!(seen.is_some(), inside(p), "{turn} {p}");
                }
            }
        }
        // Half-way it lies between the two.
        let corner = std::f64::consts::FRAC_PI_4;
        assert!(morph.radius(0.0, corner) > morph.radius(0.5, corner));
        assert!(morph.radius(0.5, corner) > morph.radius(1.0, corner));
        assert_eq!(morph.outline(0.3, 0.0), DVec2::X);
    }

    #[test]
    fn rotation_and_stretch_are_taken_apart() {
        let map = DMat2::from_angle(0.8) * DMat2::from_diagonal(DVec2::new(2.0, 1.0));
        assert!((rotation(map) - 0.8).abs() < 0.2);
        assert!((between(map, 0.0) - DMat2::IDENTITY).abs_diff_eq(DMat2::ZERO, 1e-12));
        assert!(between(map, 1.0).abs_diff_eq(map, 1e-12));
        let turned = between(DMat2::from_angle(0.8), 0.5);
        assert!(turned.abs_diff_eq(DMat2::from_angle(0.4), 1e-12));
    }
}
