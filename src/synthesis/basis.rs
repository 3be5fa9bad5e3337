//! The principal axes of a photograph's neighbourhoods \[CW 4.3\]: a neighbourhood of 8×8 pixels has 192 numbers, of
//! which some twenty carry nearly all that differs from one to the next.

use faer::{Mat, Par};

use crate::solve::symmetric_eigen;

/// Numbers that describe a neighbourhood: three registers of eight.
pub(super) const DIMENSIONS: usize = 24;

/// A neighbourhood along the principal axes, the axis of largest variance first.
pub(super) type Descriptor = [f32; DIMENSIONS];

/// The most neighbourhoods that the axes are made from.
const MOST_SAMPLES: usize = 6000;

/// Mean and principal axes.
#[derive(Debug, Clone)]
pub(super) struct Basis {
    /// Component of each number of a neighbourhood along each axis.
    pub(super) axes: Vec<Descriptor>,
    /// What the mean neighbourhood would be described by.
    pub(super) mean: Descriptor,
}

impl Basis {
    /// The principal axes of `count` neighbourhoods of `length` numbers; `fetch` writes the nth of them.
    pub(super) fn new(length: usize, count: usize, fetch: impl Fn(usize, &mut [f32])) -> Self {
        let samples = count.clamp(1, MOST_SAMPLES);
        let mut rows = Mat::<f64>::zeros(samples, length);
        let mut values = vec![0.0; length];
        for n in 0..samples {
            fetch(n * count / samples, &mut values);
            (0..length).for_each(|k| rows[(n, k)] = f64::from(values[k]));
        }
        let mean: Vec<f64> =
            (0..length).map(|k| (0..samples).map(|n| rows[(n, k)]).sum::<f64>() / samples as f64).collect();
        for (k, mean) in mean.iter().enumerate() {
            (0..samples).for_each(|n| rows[(n, k)] -= mean);
        }
        let mut covariance = Mat::<f64>::zeros(length, length);
        // Sequential: a parallel sum would round differently from run to run.
        faer::linalg::matmul::matmul(
            covariance.as_mut(),
            faer::Accum::Replace,
            rows.transpose(),
            rows.as_ref(),
            1.0 / samples as f64,
            Par::Seq,
        );
        // It comes to an end for every matrix of finite numbers; the numbers themselves still tell neighbourhoods apart.
        let vectors = symmetric_eigen(&covariance).map_or_else(|_| Mat::identity(length, length), |(_, v)| v);
        let mut axes = vec![[0.0; DIMENSIONS]; length];
        let mut along = [0.0; DIMENSIONS];
        // Eigenvalues rise: the last vector is the first axis.
        for d in 0..DIMENSIONS.min(length) {
            let column = length - 1 - d;
            for k in 0..length {
                axes[k][d] = vectors[(k, column)] as f32;
            }
            along[d] = (0..length).map(|k| vectors[(k, column)] * mean[k]).sum::<f64>() as f32;
        }
        Self { axes, mean: along }
    }

    /// A neighbourhood along the axes.
    #[inline(always)]
    pub(super) fn describe(&self, values: &[f32]) -> Descriptor {
        let mut sum = self.mean.map(|m| -m);
        for (axes, &value) in self.axes.iter().zip(values) {
            for d in 0..DIMENSIONS {
                sum[d] += axes[d] * value;
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_survive_where_few_axes_hold_everything() {
        // Fifty numbers that follow from three.
        let make = |n: usize, out: &mut [f32]| {
            let t = n as f32;
            let [a, b, c] = [(t * 0.7).sin(), (t * 1.3).cos(), (t * 0.11).sin()];
            for (k, x) in out.iter_mut().enumerate() {
                let k = k as f32;
                *x = 3.0 + a * (k * 0.3).sin() + b * (k * 0.2).cos() + 0.2 * c * k.sqrt();
            }
        };
        let basis = Basis::new(50, 400, make);
        let [mut p, mut q] = [vec![0.0; 50], vec![0.0; 50]];
        for (m, n) in [(1, 2), (17, 300), (8, 399)] {
            make(m, &mut p);
            make(n, &mut q);
            let full: f32 = p.iter().zip(&q).map(|(a, b)| (a - b).powi(2)).sum();
            let (a, b) = (basis.describe(&p), basis.describe(&q));
            let short: f32 = (0..DIMENSIONS).map(|d| (a[d] - b[d]).powi(2)).sum();
            assert!((full - short).abs() < 1e-3 * full, "{full} {short}");
        }
        // The first axis is that of the largest variance.
        let spread = |d: usize| {
            let all: Vec<f32> = (0..400)
                .map(|n| {
                    make(n, &mut p);
                    basis.describe(&p)[d]
                })
                .collect();
            all.iter().map(|x| x * x).sum::<f32>()
        };
        let spreads: Vec<f32> = [0, 1, 2, 3].map(spread).to_vec();
        assert!(spreads[0] >= spreads[1] && spreads[1] >= spreads[2] && spreads[3] < 1e-3 * spreads[2]);
    }

    #[test]
    fn fewer_numbers_than_axes_and_no_variance_are_fine() {
        let basis = Basis::new(4, 10, |_, out| out.fill(2.0));
        assert!(basis.describe(&[2.0; 4]).iter().all(|x| x.abs() < 1e-5));
    }
}
