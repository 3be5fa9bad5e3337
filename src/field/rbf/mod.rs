//! Radial basis functions in space with a linear polynomial \[LST 5.2.2; Turk & O'Brien 1999\].

mod fit;
mod thin;

pub use fit::{RbfError, RbfParams, RbfReport};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// The radial function.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Kernel {
    /// |r|: the thin plate of three dimensions. Its gradient turns sharply at the centres.
    #[default]
    Biharmonic,
    /// |r|³: one order smoother; overshoots up to 5 % and flattens out around the innermost part.
    Triharmonic,
}

impl Kernel {
    /// φ(r).
    fn at(self, r: f64) -> f64 {
        match self {
            Self::Biharmonic => r,
            Self::Triharmonic => r * r * r,
        }
    }

    /// ±1, so that the kernel times it is conditionally positive definite.
    fn sign(self) -> f64 {
        match self {
            Self::Biharmonic => -1.0,
            Self::Triharmonic => 1.0,
        }
    }
}

/// Centres are summed in this many interleaved lanes, which the compiler turns into vector
/// instructions; the order of the sum is fixed.
const LANES: usize = 4;

/// f(x) = Σ wᵢ φ(|x − cᵢ|) + a + b·x.
///
/// Works in coordinates scaled to the constraints' box, so that a model of any size in any unit gives
/// the same field.
#[derive(Debug, Clone, PartialEq)]
pub struct Rbf {
    kernel: Kernel,
    origin: DVec3,
    scale: f64,
    constant: f64,
    slope: DVec3,
    /// x, y, z and weight of [`LANES`] centres each, padded with weights 0.
    centres: Vec<[[f64; LANES]; 4]>,
    count: usize,
}

impl Rbf {
    /// Number of centres.
    #[must_use]
    pub fn centres(&self) -> usize {
        self.count
    }

    /// f(x).
    #[must_use]
    pub fn value(&self, x: DVec3) -> f64 {
        let p = (x - self.origin) / self.scale;
        let mut sum = [0.0; LANES];
        match self.kernel {
            Kernel::Biharmonic => self.accumulate(&mut sum, p, f64::sqrt),
            Kernel::Triharmonic => self.accumulate(&mut sum, p, |d| d * d.sqrt()),
        }
        self.constant + self.slope.dot(p) + sum.iter().sum::<f64>()
    }

    fn accumulate(&self, sum: &mut [f64; LANES], p: DVec3, phi: impl Fn(f64) -> f64) {
        for [x, y, z, w] in &self.centres {
            for l in 0..LANES {
                let (dx, dy, dz) = (p.x - x[l], p.y - y[l], p.z - z[l]);
                sum[l] += w[l] * phi(dx * dx + dy * dy + dz * dz);
            }
        }
    }

    /// ∇f(x), analytic. At a centre of the biharmonic kernel, where that term has a kink, the term counts 0.
    #[must_use]
    pub fn gradient(&self, x: DVec3) -> DVec3 {
        let p = (x - self.origin) / self.scale;
        let mut sum = [[0.0; LANES]; 3];
        match self.kernel {
            Kernel::Biharmonic => {
                self.accumulate_gradient(&mut sum, p, |d| if d > 0.0 { 1.0 / d.sqrt() } else { 0.0 });
            }
            Kernel::Triharmonic => self.accumulate_gradient(&mut sum, p, |d| 3.0 * d.sqrt()),
        }
        (self.slope + DVec3::from_array(sum.map(|lane| lane.iter().sum()))) / self.scale
    }

    /// `factor` is φ′(r)/r as a function of r².
    fn accumulate_gradient(&self, sum: &mut [[f64; LANES]; 3], p: DVec3, factor: impl Fn(f64) -> f64) {
        for [x, y, z, w] in &self.centres {
            for l in 0..LANES {
                let (dx, dy, dz) = (p.x - x[l], p.y - y[l], p.z - z[l]);
                let f = w[l] * factor(dx * dx + dy * dy + dz * dz);
                sum[0][l] += f * dx;
                sum[1][l] += f * dy;
                sum[2][l] += f * dz;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;

    use super::*;
    use crate::exec::Exec;
    use crate::mesh::shapes::unit;

    const KERNELS: [Kernel; 2] = [Kernel::Biharmonic, Kernel::Triharmonic];

    fn cloud(n: usize, f: impl Fn(DVec3) -> f64) -> Vec<(DVec3, f64)> {
        let mut random = ChaCha8Rng::seed_from_u64(7);
        (0..n)
            .map(|_| {
                let p = DVec3::from_array(std::array::from_fn(|_| 30.0 + 4.0 * unit(&mut random)));
                (p, f(p))
            })
            .collect()
    }

    fn fit(points: &[(DVec3, f64)], params: &RbfParams) -> Result<(Rbf, RbfReport), RbfError> {
        Rbf::fit(points, params, &Exec::default())
    }

    fn params(kernel: Kernel) -> RbfParams {
        RbfParams { kernel, ..RbfParams::default() }
    }

    #[test]
    fn linear_functions_are_reproduced_everywhere() {
        let slope = DVec3::new(0.3, -1.2, 0.05);
        for kernel in KERNELS {
            let (rbf, _) = fit(&cloud(60, |p| slope.dot(p) + 4.0), &params(kernel)).unwrap();
            for p in [DVec3::ZERO, DVec3::splat(31.3), DVec3::new(90.0, 3.0, -20.0)] {
                assert!((rbf.value(p) - slope.dot(p) - 4.0).abs() < 1e-8);
                assert!((rbf.gradient(p) - slope).length() < 1e-9);
            }
        }
    }

    #[test]
    fn constraints_are_met_and_the_gradient_is_that_of_the_values() {
        let points = cloud(150, |p| (p.x * 1.7).sin() + p.y * p.z * 0.01);
        for kernel in KERNELS {
            let (rbf, report) = fit(&points, &params(kernel)).unwrap();
            assert_eq!((report.constraints, report.centres), (150, 150));
            assert!(report.residual < 1e-9);
            assert!(points.iter().all(|(p, v)| (rbf.value(*p) - v).abs() < 1e-9));
            for (p, _) in cloud(20, |_| 0.0).iter().map(|(p, v)| (*p + DVec3::splat(0.1), v)) {
                let h = 1e-5;
                let difference = DVec3::from_array(std::array::from_fn(|k| {
                    let step = DVec3::AXES[k] * h;
                    (rbf.value(p + step) - rbf.value(p - step)) / (2.0 * h)
                }));
                assert!((rbf.gradient(p) - difference).length() < 1e-5);
            }
        }
    }

    #[test]
    fn the_weights_are_orthogonal_to_linear_functions() {
        let (rbf, _) = fit(&cloud(50, |p| p.x * p.y), &params(Kernel::Biharmonic)).unwrap();
        let mut moments = [0.0; 4];
        for [x, y, z, w] in &rbf.centres {
            for l in 0..LANES {
                for (m, f) in moments.iter_mut().zip([1.0, x[l], y[l], z[l]]) {
                    *m += w[l] * f;
                }
            }
        }
        assert!(moments.iter().all(|m| m.abs() < 1e-9), "{moments:?}");
    }

    #[test]
    fn flat_straight_and_single_sets_are_fitted_too() {
        let flat = |p: DVec3| DVec3::new(p.x, p.x * 2.0 - p.y, p.y);
        let line = |p: DVec3| DVec3::new(1.0, p.x, -p.x);
        for kernel in KERNELS {
            for (project, n) in [(&flat as &dyn Fn(DVec3) -> DVec3, 80), (&line, 30), (&line, 2)] {
                let points: Vec<(DVec3, f64)> =
                    cloud(n, |p| p.x).iter().map(|(p, v)| (project(*p), (v * 1.3).cos())).collect();
                let (rbf, report) = fit(&points, &params(kernel)).unwrap();
                assert!(report.residual < 1e-8, "{report:?}");
                assert!(rbf.gradient(DVec3::splat(3.0)).is_finite());
            }
        }
    }

    #[test]
    fn large_sets_are_fitted_to_the_tolerance() {
        let points = cloud(3000, |p| ((p - 32.0).length() * 0.8).cos());
        let limited = RbfParams { max_centres: 600, tolerance: 0.02, ..RbfParams::default() };
        let (rbf, report) = fit(&points, &limited).unwrap();
        assert!(report.centres <= 600 && report.residual <= 0.02, "{report:?}");
        let worst = points.iter().map(|(p, v)| (rbf.value(*p) - v).abs()).fold(0.0, f64::max);
        assert!((worst - report.residual).abs() < 1e-12);
        let (_, report) = fit(&points, &RbfParams { max_centres: 100, ..limited }).unwrap();
        assert!(report.centres == 100 && report.residual > 0.02, "{report:?}");
    }

    #[test]
    fn repeated_constraints_merge_and_contradictions_are_named() {
        let mut points = cloud(20, |p| p.x);
        points.push(points[3]);
        let (_, report) = fit(&points, &RbfParams::default()).unwrap();
        assert_eq!(report.constraints, 20);
        points.push((points[3].0, 1.0));
        let error = fit(&points, &RbfParams::default()).unwrap_err();
        assert!(matches!(error, RbfError::Contradiction { point, .. } if point == points[3].0));
        assert!(error.to_string().contains("1"), "{error}");
    }

    #[test]
    fn constraints_that_say_nothing_are_refused() {
        assert_eq!(fit(&[], &RbfParams::default()).unwrap_err(), RbfError::Empty);
        let same = cloud(9, |_| 0.25);
        assert_eq!(fit(&same, &RbfParams::default()).unwrap_err(), RbfError::OneValue(0.25));
        let bad = [(DVec3::ZERO, 0.0), (DVec3::X, f64::NAN)];
        assert_eq!(fit(&bad, &RbfParams::default()).unwrap_err(), RbfError::NotFinite(1));
        let bad = RbfParams { max_centres: 3, ..RbfParams::default() };
        assert_eq!(fit(&cloud(9, |p| p.x), &bad).unwrap_err(), RbfError::MaxCentres(3));
        let bad = RbfParams { tolerance: f64::NAN, ..RbfParams::default() };
        assert!(matches!(fit(&cloud(9, |p| p.x), &bad), Err(RbfError::Tolerance(_))));
    }
}
