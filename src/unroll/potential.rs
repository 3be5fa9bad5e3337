//! The potential of a charged core inside an earthed outline: harmonic between them, by the boundary element method.
//!
//! φ(x) = −Σ_j σ_j ∫ ln|x−y| dy over the panels j of the boundary, plus the core's own charge. The densities σ make φ
//! what it should be on the boundary: 0 on the outline; 1 on an axis or an inner outline. Lengths are scaled so that all
//! lies in a disk of radius below ½, where the matrix is positive definite.

use std::f64::consts::PI;

use faer::Mat;
use glam::DVec2;

use super::core::Core;
use crate::exec::{Cancelled, Exec};
use crate::solve::{SolveError, solve_dense_spd};

/// A straight piece of a boundary.
#[derive(Debug, Clone, Copy)]
struct Panel {
    from: DVec2,
    along: DVec2,
    length: f64,
}

/// A potential in a photograph's pixels.
pub(super) struct Potential {
    panels: Vec<Panel>,
    density: Vec<f64>,
    /// A core without extent, which carries a charge of 1.
    point: Option<DVec2>,
    centre: DVec2,
    scale: f64,
}

/// Panels along each axis.
const ALONG: u32 = 120;

/// Why there is no potential.
#[derive(Debug, thiserror::Error)]
pub(super) enum PotentialError {
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    #[error(transparent)]
    Solve(#[from] SolveError),
}

impl Potential {
    /// The potential between an outline, a closed polygon, and a core, both in pixels; each side of a polygon is a
    /// panel.
    pub(super) fn new(outline: &[DVec2], core: &Core, exec: &Exec) -> Result<Self, PotentialError> {
        let (low, high) = outline
            .iter()
            .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
        let centre = 0.5 * (low + high);
        let scale = 0.4 / (0.5 * low.distance(high));
        let scaled = |p: DVec2| (p - centre) * scale;
        let mut panels = polygon(outline, scaled);
        let outer = panels.len();
        let mut point = None;
        match core {
            Core::Point(c) => point = Some(scaled(*c)),
            Core::Axis([a, b]) => {
                // Shorter ones at the ends, where the charge crowds.
                let at = |n: u32| 0.5 - 0.5 * (PI * f64::from(n) / f64::from(ALONG)).cos();
                let end = |n: u32| scaled(a.lerp(*b, at(n)));
                panels.extend((0..ALONG).map(|n| Panel::new(end(n), end(n + 1))));
            }
            Core::Curve(curve) => panels.extend(polygon(curve, scaled)),
        }
        let count = panels.len();
        let middles: Vec<DVec2> = panels.iter().map(Panel::middle).collect();
        let mut matrix = Mat::<f64>::zeros(count, count);
        let mut rhs = Vec::with_capacity(count);
        // Galerkin's method with the middle of each panel for its mean, made symmetric.
        for j in 0..count {
            if j % 64 == 0 {
                exec.check()?;
            }
            for i in j..count {
                let half = panels[i].length * panels[j].log_at(middles[i])
                    + panels[j].length * panels[i].log_at(middles[j]);
                matrix[(i, j)] = -0.5 * half;
            }
            let wanted = if j < outer { 0.0 } else { 1.0 };
            rhs.push(panels[j].length * (wanted - point.map_or(0.0, |c| -middles[j].distance(c).ln())));
        }
        solve_dense_spd(matrix.as_mut(), &mut rhs)?;
        Ok(Self { panels, density: rhs, point, centre, scale })
    }

    /// The direction in which the potential rises most: to the core.
    pub(super) fn direction(&self, at: DVec2) -> DVec2 {
        let x = (at - self.centre) * self.scale;
        let mut sum = self.point.map_or(DVec2::ZERO, |c| (c - x) / x.distance_squared(c).max(1e-300));
        for (panel, density) in self.panels.iter().zip(&self.density) {
            sum -= *density * panel.log_gradient(x);
        }
        sum.normalize_or_zero()
    }
}

fn polygon(curve: &[DVec2], scaled: impl Fn(DVec2) -> DVec2) -> Vec<Panel> {
    let sides = curve.iter().zip(curve.iter().cycle().skip(1));
    sides.map(|(a, b)| Panel::new(scaled(*a), scaled(*b))).filter(|p| p.length > 0.0).collect()
}

impl Panel {
    fn new(from: DVec2, to: DVec2) -> Self {
        let length = from.distance(to);
        Self { from, along: (to - from) / length, length }
    }

    fn middle(&self) -> DVec2 {
        self.from + self.along * (0.5 * self.length)
    }

    /// Coordinates along the panel from its first end, and beside it.
    fn local(&self, x: DVec2) -> (f64, f64) {
        let d = x - self.from;
        (d.dot(self.along), self.along.perp_dot(d))
    }

    /// ∫ ln|x−y| dy over the panel.
    fn log_at(&self, x: DVec2) -> f64 {
        let (u, v) = self.local(x);
        let part = |w: f64| {
            let square = w * w + v * v;
            if square == 0.0 { 0.0 } else { 0.5 * w * square.ln() - w }
        };
        // The angle under which the panel is seen.
        let angle = (v * self.length).atan2(v * v + u * (u - self.length));
        part(u) - part(u - self.length) + v * angle
    }

    /// The gradient of [`Panel::log_at`].
    fn log_gradient(&self, x: DVec2) -> DVec2 {
        let (u, v) = self.local(x);
        let w = u - self.length;
        let (near, far) = (u * u + v * v, w * w + v * v);
        if near > 100.0 * self.length * self.length {
            // From so far it is a point.
            let d = x - self.middle();
            return d * (self.length / d.length_squared());
        }
        let along = 0.5 * (near.max(1e-300) / far.max(1e-300)).ln();
        let beside = (v * self.length).atan2(v * v + u * w);
        self.along * along + self.along.perp() * beside
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn a_panels_gradient_is_the_difference_of_its_values() {
        let panel = Panel::new(DVec2::new(0.1, 0.2), DVec2::new(0.13, 0.16));
        for x in [DVec2::new(0.12, 0.19), DVec2::new(0.1, 0.1), DVec2::new(0.2, 0.3), DVec2::new(-0.1, 0.2)] {
            let h = 1e-6;
            let difference = |e: DVec2| (panel.log_at(x + e * h) - panel.log_at(x - e * h)) / (2.0 * h);
            let expected = DVec2::new(difference(DVec2::X), difference(DVec2::Y));
            assert!(panel.log_gradient(x).distance(expected) < 1e-6, "{x}");
        }
        // By brute force.
        let x = DVec2::new(0.12, 0.19);
        let n = 100_000;
        let at = |i: i32| panel.from + panel.along * (panel.length * (f64::from(i) + 0.5) / f64::from(n));
        let sum: f64 = (0..n).map(|i| x.distance(at(i)).ln()).sum::<f64>() * panel.length / f64::from(n);
        assert!((panel.log_at(x) - sum).abs() < 1e-8);
    }

    #[test]
    fn lines_in_a_disk_are_arcs_through_the_core() {
        let circle: Vec<DVec2> = (0..300)
            .map(|n| DVec2::splat(100.0) + 80.0 * DVec2::from_angle(TAU * f64::from(n) / 300.0))
            .collect();
        let core = DVec2::new(124.0, 100.0);
        let potential = Potential::new(&circle, &Core::Point(core), &Exec::default()).unwrap();
        // Green's function of the unit disk: −ln|z−c| + ln|1−c̄z|; its gradient by finite differences.
        let green = |x: DVec2| {
            let (z, c) = ((x - DVec2::splat(100.0)) / 80.0, 0.3);
            -(z - DVec2::new(c, 0.0)).length().ln() + DVec2::new(1.0 - c * z.x, -c * z.y).length().ln()
        };
        for x in [DVec2::new(60.0, 130.0), DVec2::new(100.0, 171.0), DVec2::new(150.0, 95.0)] {
            let h = 1e-4;
            let g = DVec2::new(
                green(x + DVec2::X * h) - green(x - DVec2::X * h),
                green(x + DVec2::Y * h) - green(x - DVec2::Y * h),
            );
            let found = potential.direction(x);
            assert!(found.distance(g.normalize()) < 0.01, "{x}: {found} {}", g.normalize());
        }
    }
}
