//! A quarter of a cross-section: its outline between two half-axes, as distances from the centre.

use std::f64::consts::FRAC_PI_2;

use glam::DVec2;

use super::section::Section;

/// Angles at which the outline is known, from one half-axis to the other.
const ANGLES: usize = 33;
/// Distances in scaled coordinates: a rectangle's corner has √2. Beyond, a notch just where a half-axis lies would be made a spike
/// of all that is beside it.
const LEAST: f64 = 0.35;
const MOST: f64 = 1.5;

/// A quarter's outline, seen in coordinates in which it passes through (1, 0) and (0, 1): as \[SST 3.1\] scales a morphed
/// section to agree with the base, so every quarter is scaled to agree with its neighbours.
#[derive(Debug, Clone)]
pub(super) struct Quarter {
    /// How far it reaches along the two half-axes, in voxels.
    pub(super) extent: DVec2,
    /// The distance of the outline from the centre, in scaled coordinates, at equal steps of the angle.
    radius: [f32; ANGLES],
}

impl Quarter {
    /// The quarter of a section towards `first` and `second`, two half-axes.
    pub(super) fn new(section: &Section<'_>, first: DVec2, second: DVec2) -> Self {
        let extent = DVec2::new(section.reach(first), section.reach(second)).max(DVec2::splat(0.5));
        let radius = std::array::from_fn(|n| {
            let (sin, cos) = angle(n).sin_cos();
            let direction = first * (cos * extent.x) + second * (sin * extent.y);
            let length = direction.length();
            (section.reach(direction / length) / length).clamp(LEAST, MOST) as f32
        });
        Self { extent, radius }
    }

    /// The quarter of a superellipse |x|ⁿ + |y|ⁿ = 1, of those extents.
    pub(super) fn superellipse(extent: DVec2, exponent: f64) -> Self {
        let radius = std::array::from_fn(|n| {
            let (sin, cos) = angle(n).sin_cos();
            (cos.powf(exponent) + sin.powf(exponent)).powf(-1.0 / exponent) as f32
        });
        Self { extent, radius }
    }

    /// The outline's distance at an angle from 0 to π/2.
    #[inline]
    pub(super) fn radius(&self, angle: f64) -> f64 {
        let at = (angle / FRAC_PI_2).clamp(0.0, 1.0) * (ANGLES - 1) as f64;
        let n = (at as usize).min(ANGLES - 2);
        let f = at - n as f64;
        f64::from(self.radius[n]) * (1.0 - f) + f64::from(self.radius[n + 1]) * f
    }

    /// Its area in scaled coordinates; π/4 for an ellipse, 1 for a rectangle.
    pub(super) fn area(&self) -> f64 {
        let wedge = |n: usize| 0.5 * f64::from(self.radius[n]) * f64::from(self.radius[n + 1]);
        (0..ANGLES - 1).map(wedge).sum::<f64>() * (FRAC_PI_2 / (ANGLES - 1) as f64).sin()
    }
}

fn angle(n: usize) -> f64 {
    FRAC_PI_2 * n as f64 / (ANGLES - 1) as f64
}

/// The exponent of the superellipse whose quarter has this area in scaled coordinates.
pub(super) fn exponent_of(area: f64) -> f64 {
    let (mut low, mut high): (f64, f64) = (1.0, 16.0);
    for _ in 0..30 {
        let middle = 0.5 * (low + high);
        if Quarter::superellipse(DVec2::ONE, middle).area() < area { low = middle } else { high = middle }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn superellipses_have_the_area_that_they_are_found_by() {
        let of = |n| Quarter::superellipse(DVec2::ONE, n).area();
        assert!((of(2.0) - std::f64::consts::FRAC_PI_4).abs() < 1e-3);
        assert!((of(1.0) - 0.5).abs() < 1e-3);
        for n in [1.3, 2.0, 5.0] {
            assert!((exponent_of(of(n)) - n).abs() < 1e-3);
        }
        assert!((Quarter::superellipse(DVec2::ONE, 2.0).radius(0.7) - 1.0).abs() < 1e-6);
    }
}
