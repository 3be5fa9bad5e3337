//! Preconditioned conjugate gradients for several right-hand sides at once.

use rayon::prelude::*;

use super::SolveError;
use crate::exec::{Cancelled, Exec};

/// Numbers are summed within chunks of this many unknowns and the chunks in order: the same sum on any number
/// of threads.
const CHUNK: usize = 4096;
/// Steps after which it is given up.
const MOST: usize = 1000;

/// Why an iteration ended without a solution.
#[derive(Debug)]
pub(crate) enum IterationError {
    Solve(SolveError),
    Cancelled(Cancelled),
}

/// Solves A x = b for N right-hand sides side by side, each with steps of its own, until the residual of each is
/// below `tolerance` of its right-hand side, both measured by the preconditioner. `apply` writes A x;
/// `precondition` writes an approximation of A⁻¹ x that is itself symmetric and positive definite.
pub(crate) fn conjugate_gradients<const N: usize>(
    rhs: &[[f64; N]],
    tolerance: f64,
    apply: impl Fn(&[[f64; N]], &mut [[f64; N]]) + Sync,
    precondition: impl Fn(&[[f64; N]], &mut [[f64; N]]) + Sync,
    exec: &Exec,
) -> Result<Vec<[f64; N]>, IterationError> {
    let n = rhs.len();
    let mut x = vec![[0.0; N]; n];
    let mut residual = rhs.to_vec();
    let mut z = vec![[0.0; N]; n];
    precondition(&residual, &mut z);
    let mut step = z.clone();
    let mut product = vec![[0.0; N]; n];
    let mut size = dot(&residual, &z);
    let goal = size.map(|s| s * tolerance * tolerance);
    for _ in 0..MOST {
        exec.check().map_err(IterationError::Cancelled)?;
        if size.iter().zip(goal).all(|(s, goal)| *s <= goal) {
            return Ok(x);
        }
        apply(&step, &mut product);
        let curvature = dot(&step, &product);
        // A side that is done, or is 0, stays as it is.
        let length: [f64; N] = std::array::from_fn(|c| {
            if size[c] > goal[c] && curvature[c] > 0.0 { size[c] / curvature[c] } else { 0.0 }
        });
        add(&mut x, &length, &step);
        add(&mut residual, &length.map(|l| -l), &product);
        precondition(&residual, &mut z);
        let next = dot(&residual, &z);
        let keep: [f64; N] = std::array::from_fn(|c| if size[c] > 0.0 { next[c] / size[c] } else { 0.0 });
        step.par_chunks_mut(CHUNK).zip(z.par_chunks(CHUNK)).for_each(|(step, z)| {
            for (s, z) in step.iter_mut().zip(z) {
                for c in 0..N {
                    s[c] = z[c] + keep[c] * s[c];
                }
            }
        });
        size = next;
        if curvature.iter().chain(&size).any(|s| !s.is_finite() || *s < 0.0) {
            return Err(IterationError::Solve(SolveError::NotPositiveDefinite { size: n }));
        }
    }
    Err(IterationError::Solve(SolveError::NotConverged { size: n }))
}

/// The inner product of each side.
fn dot<const N: usize>(a: &[[f64; N]], b: &[[f64; N]]) -> [f64; N] {
    let sums: Vec<[f64; N]> = a
        .par_chunks(CHUNK)
        .zip(b.par_chunks(CHUNK))
        .map(|(a, b)| {
            a.iter().zip(b).fold([0.0; N], |sum, (a, b)| std::array::from_fn(|c| sum[c] + a[c] * b[c]))
        })
        .collect();
    sums.iter().fold([0.0; N], |sum, s| std::array::from_fn(|c| sum[c] + s[c]))
}

/// x ← x + factor · y, side by side.
pub(crate) fn add<const N: usize>(x: &mut [[f64; N]], factor: &[f64; N], y: &[[f64; N]]) {
    x.par_chunks_mut(CHUNK).zip(y.par_chunks(CHUNK)).for_each(|(x, y)| {
        for (x, y) in x.iter_mut().zip(y) {
            for c in 0..N {
                x[c] += factor[c] * y[c];
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Writes the second differences of x, x = 0 beyond both ends.
    fn chain(x: &[[f64; 2]], y: &mut [[f64; 2]]) {
        let n = x.len();
        for v in 0..n {
            y[v] = std::array::from_fn(|c| {
                let beside = |k: Option<usize>| k.and_then(|k| x.get(k)).map_or(0.0, |x| x[c]);
                2.0 * x[v][c] - beside(v.checked_sub(1)) - beside(Some(v + 1))
            });
        }
    }

    #[test]
    fn a_chain_is_solved_for_two_sides_of_which_one_is_zero() {
        let n = 50;
        // u″ = −2 has x(1 − x), exact at the nodes.
        let h = 1.0 / (n + 1) as f64;
        let rhs = vec![[2.0 * h * h, 0.0]; n];
        let exec = Exec::default();
        let x = conjugate_gradients(&rhs, 1e-12, chain, |r, z| z.copy_from_slice(r), &exec).unwrap();
        for (k, [u, zero]) in x.iter().enumerate() {
            let place = (k + 1) as f64 * h;
            assert!((u - place * (1.0 - place)).abs() < 1e-11 && *zero == 0.0);
        }
    }

    #[test]
    fn what_is_not_positive_is_refused_and_a_cancelled_run_stops() {
        let rhs = vec![[1.0]; 4];
        let exec = Exec::default();
        let minus = |x: &[[f64; 1]], y: &mut [[f64; 1]]| {
            for (x, y) in x.iter().zip(y) {
                y[0] = -x[0];
            }
        };
        let failed = conjugate_gradients(&rhs, 1e-9, minus, |r, z| z.copy_from_slice(r), &exec);
        assert!(matches!(failed, Err(IterationError::Solve(SolveError::NotPositiveDefinite { size: 4 }))));
        exec.cancel_token().cancel();
        let stopped = conjugate_gradients(&rhs, 1e-9, minus, |r, z| z.copy_from_slice(r), &exec);
        assert!(matches!(stopped, Err(IterationError::Cancelled(_))));
    }
}
