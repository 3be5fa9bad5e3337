//! The sliced Wasserstein distance (Rabin, Peyré, Delon & Bernot 2012), and the axes that whiten patches.

use faer::{Accum, Mat, Par, linalg::matmul::matmul};
use rayon::prelude::*;

use super::patches::Dice;
use crate::solve::{SolveError, symmetric_eigen};

/// Principal axes that are compared.
pub(super) const AXES: usize = 32;
/// Directions on which the clouds are projected.
pub(super) const DIRECTIONS: usize = 128;
/// Variance below which an axis is not blown up any more: a thousandth of the way from black to white, squared. Files
/// of 8 bits know no smaller differences.
const LEAST_VARIANCE: f64 = 1e-6;

/// Unit vectors, drawn evenly, [`DIRECTIONS`] of them: for each of `dimensions` the components of all.
pub(super) fn directions(dimensions: usize, dice: &mut Dice) -> Vec<f32> {
    let mut all = vec![0.0; DIRECTIONS * dimensions];
    for n in 0..DIRECTIONS {
        let v: Vec<f64> = (0..dimensions).map(|_| dice.normal()).collect();
        let length = v.iter().map(|x| x * x).sum::<f64>().sqrt().max(1e-300);
        v.iter().enumerate().for_each(|(k, x)| all[k * DIRECTIONS + n] = (x / length) as f32);
    }
    all
}

/// A cloud of points projected on every direction, in order.
pub(super) struct Projected(Vec<Vec<f32>>);

impl Projected {
    /// Of a cloud of points of `dimensions` numbers.
    pub(super) fn new(cloud: &[f32], dimensions: usize, directions: &[f32]) -> Self {
        // All directions of a part of the cloud at a time: they lie side by side in memory.
        let parts: Vec<Vec<[f32; DIRECTIONS]>> = cloud
            .par_chunks(dimensions * 512)
            .map(|part| {
                let project = |point: &[f32]| {
                    let mut sums = [0.0; DIRECTIONS];
                    for (x, components) in point.iter().zip(directions.as_chunks::<DIRECTIONS>().0) {
                        sums.iter_mut().zip(components).for_each(|(sum, d)| *sum += x * d);
                    }
                    sums
                };
                part.chunks_exact(dimensions).map(project).collect()
            })
            .collect();
        let sorted = |n: usize| {
            let mut all: Vec<f32> = parts.iter().flatten().map(|sums| sums[n]).collect();
            all.sort_unstable_by(f32::total_cmp);
            all
        };
        Self((0..DIRECTIONS).into_par_iter().map(sorted).collect())
    }

    /// The sliced Wasserstein distance: the mean over all directions of the distance W₁ between the clouds' projections,
    /// which is the mean distance between them in order. Both clouds have the same number of points.
    pub(super) fn distance(&self, other: &Self) -> f64 {
        let each = self.0.iter().zip(&other.0).map(|(a, b)| {
            assert_eq!(a.len(), b.len(), "clouds of different sizes");
            a.iter().zip(b).map(|(x, y)| f64::from((x - y).abs())).sum::<f64>() / a.len().max(1) as f64
        });
        each.sum::<f64>() / DIRECTIONS as f64
    }
}

/// [`Projected::distance`] of two clouds.
pub(super) fn sliced_wasserstein(a: &[f32], b: &[f32], dimensions: usize, directions: &[f32]) -> f64 {
    let project = |cloud| Projected::new(cloud, dimensions, directions);
    project(a).distance(&project(b))
}

/// The first principal axes of a cloud, each at unit variance.
pub(super) struct Whitening {
    numbers: usize,
    mean: Vec<f32>,
    /// For each of the numbers its weights along all axes.
    axes: Vec<[f32; AXES]>,
}

impl Whitening {
    /// Of a cloud of points of so many numbers.
    pub(super) fn of(cloud: &[f32], numbers: usize) -> Result<Self, SolveError> {
        let count = cloud.len() / numbers;
        let mut rows = Mat::from_fn(count, numbers, |i, j| f64::from(cloud[i * numbers + j]));
        let mean: Vec<f64> =
            (0..numbers).map(|j| (0..count).map(|i| rows[(i, j)]).sum::<f64>() / count as f64).collect();
        for (j, mean) in mean.iter().enumerate() {
            (0..count).for_each(|i| rows[(i, j)] -= mean);
        }
        let mut covariance = Mat::zeros(numbers, numbers);
        // Sequential: a parallel sum would round differently from run to run.
        matmul(
            covariance.as_mut(),
            Accum::Replace,
            rows.transpose(),
            rows.as_ref(),
            1.0 / count as f64,
            Par::Seq,
        );
        let (values, vectors) = symmetric_eigen(&covariance)?;
        let mut axes = vec![[0.0; AXES]; numbers];
        for k in 0..AXES.min(numbers) {
            // Eigenvalues rise: the last vector is the first axis.
            let n = numbers - 1 - k;
            let scale = 1.0 / values[n].max(LEAST_VARIANCE).sqrt();
            axes.iter_mut()
                .enumerate()
                .for_each(|(j, weights)| weights[k] = (scale * vectors[(j, n)]) as f32);
        }
        Ok(Self { numbers, mean: mean.iter().map(|m| *m as f32).collect(), axes })
    }

    /// A cloud along the axes: [`AXES`] numbers for each point, the last of them 0 where there are fewer axes.
    pub(super) fn apply(&self, cloud: &[f32]) -> Vec<f32> {
        let each: Vec<Vec<f32>> = cloud
            .par_chunks(self.numbers * 512)
            .map(|part| {
                let mut out = Vec::with_capacity(part.len() / self.numbers * AXES);
                for point in part.chunks_exact(self.numbers) {
                    let mut sums = [0.0; AXES];
                    for ((x, mean), axes) in point.iter().zip(&self.mean).zip(&self.axes) {
                        let centred = x - mean;
                        sums.iter_mut().zip(axes).for_each(|(sum, a)| *sum += centred * a);
                    }
                    out.extend_from_slice(&sums);
                }
                out
            })
            .collect();
        each.concat()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gaussian(count: usize, scale: &[f64], shift: &[f64], purpose: u64) -> Vec<f32> {
        let mut dice = Dice::new(7, purpose);
        let point =
            |_| scale.iter().zip(shift).map(|(s, m)| (s * dice.normal() + m) as f32).collect::<Vec<_>>();
        (0..count).flat_map(point).collect()
    }

    #[test]
    fn two_shifted_gaussians() {
        // W₁ of two normal distributions of one variance is the distance of their means: over all directions of
        // three dimensions, half of the shift on the mean.
        let shift = [0.6, -0.8, 0.0];
        let (a, b) = (gaussian(8000, &[1.0; 3], &[0.0; 3], 1), gaussian(8000, &[1.0; 3], &shift, 2));
        let directions = directions(3, &mut Dice::new(1, 3));
        let found = sliced_wasserstein(&a, &b, 3, &directions);
        assert!((found - 0.5).abs() < 0.05, "{found}");
        // For these directions, to the clouds' own noise.
        let along = |n: usize| {
            (0..3).map(|k| f64::from(directions[k * DIRECTIONS + n]) * shift[k]).sum::<f64>().abs()
        };
        let exact = (0..DIRECTIONS).map(along).sum::<f64>() / DIRECTIONS as f64;
        assert!((found - exact).abs() < 0.02, "{found} {exact}");
        assert_eq!(sliced_wasserstein(&a, &a, 3, &directions), 0.0);
        let mut backwards: Vec<f32> = a.chunks_exact(3).rev().flatten().copied().collect();
        assert!(sliced_wasserstein(&a, &backwards, 3, &directions) < 1e-9);
        backwards[0] += 1.0;
        assert!(sliced_wasserstein(&a, &backwards, 3, &directions) > 0.0);
    }

    #[test]
    fn one_dimension_is_the_plain_distance() {
        let d = sliced_wasserstein(&[0.0, 1.0, 5.0], &[6.0, 1.0, 1.0], 1, &[1.0; DIRECTIONS]);
        assert!((d - 2.0 / 3.0).abs() < 1e-6);
    }

    #[test]
    fn whitening_makes_all_variances_one() {
        let cloud = gaussian(20_000, &[5.0, 0.1, 1.0], &[3.0, 2.0, 1.0], 4);
        let whitening = Whitening::of(&cloud, 3).unwrap();
        let white = whitening.apply(&cloud);
        for i in 0..3 {
            for j in 0..3 {
                let moment = white.chunks_exact(AXES).map(|p| f64::from(p[i] * p[j])).sum::<f64>() / 20_000.0;
                assert!((moment - f64::from(u8::from(i == j))).abs() < 1e-3, "{i} {j}: {moment}");
            }
        }
        // Without any variance there is nothing to blow up.
        let flat = Whitening::of(&[0.5; 300], 3).unwrap();
        assert!(flat.apply(&[0.5; 3]).iter().all(|x| *x == 0.0));
    }
}
