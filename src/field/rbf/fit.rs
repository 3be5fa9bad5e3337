//! Fitting radial basis functions to constraints.

use std::collections::BTreeSet;

use faer::MatMut;
use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

use super::{Kernel, LANES, Rbf, thin};
use crate::exec::{Cancelled, Exec};
use crate::field::eigen::{Symmetric, eigen, outer};
use crate::solve::{SolveError, solve_dense_spd};

/// How to fit.
#[derive(Debug, Clone, PartialEq)]
pub struct RbfParams {
    /// The radial function.
    pub kernel: Kernel,
    /// Most centres: time grows with their cube, memory with their square. At least 4.
    pub max_centres: usize,
    /// With more constraints than centres: the greatest error that is left at a constraint, where the
    /// centres suffice for it.
    pub tolerance: f64,
}

impl Default for RbfParams {
    fn default() -> Self {
        Self { kernel: Kernel::Biharmonic, max_centres: 3000, tolerance: 1e-3 }
    }
}

/// How well a fit went.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct RbfReport {
    /// Constraints at different points, after thinning.
    pub constraints: usize,
    /// Centres that were needed.
    pub centres: usize,
    /// The greatest error left at a constraint.
    pub residual: f64,
}

/// Why constraints cannot be fitted.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RbfError {
    /// There is nothing to fit.
    #[error("there are no constraints")]
    Empty,
    /// A coordinate or value is NaN or infinite.
    #[error("constraint {0} is not finite")]
    NotFinite(usize),
    /// A constant field has no gradient.
    #[error("every constraint has the value {0}; at least one needs another value")]
    OneValue(f64),
    /// Two values at one point.
    #[error("the point ({:.6}, {:.6}, {:.6}) has two values, {} and {}; remove one of them",
        point.x, point.y, point.z, values[0], values[1])]
    Contradiction {
        /// Where.
        point: DVec3,
        /// The values.
        values: [f64; 2],
    },
    /// Fewer centres than a linear function needs.
    #[error("fit.max_centres (--depth-centres) is {0}; a field needs at least 4")]
    MaxCentres(usize),
    /// The tolerance is no positive number.
    #[error("fit.tolerance (--depth-tolerance) is {0}; it must be a positive number")]
    Tolerance(f64),
    /// The dense system could not be solved.
    #[error(transparent)]
    Solve(#[from] SolveError),
    /// Cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// More constraints than this many times the centres are thinned by voxel first.
const THIN_ABOVE: usize = 16;

impl Rbf {
    /// Fits the function to (point, value) constraints. Up to `max_centres` of them are met exactly; of
    /// more, centres are chosen greedily where the error is greatest until it is below the tolerance.
    ///
    /// Constraints on one plane or line are fitted with a linear part along that plane or line only.
    ///
    /// # Errors
    /// [`RbfError`].
    pub fn fit(
        points: &[(DVec3, f64)],
        params: &RbfParams,
        exec: &Exec,
    ) -> Result<(Self, RbfReport), RbfError> {
        if params.max_centres < 4 {
            return Err(RbfError::MaxCentres(params.max_centres));
        }
        if !(params.tolerance > 0.0 && params.tolerance.is_finite()) {
            return Err(RbfError::Tolerance(params.tolerance));
        }
        if let Some(i) = points.iter().position(|(p, v)| !p.is_finite() || !v.is_finite()) {
            return Err(RbfError::NotFinite(i));
        }
        let &(p0, v0) = points.first().ok_or(RbfError::Empty)?;
        let (lo, hi) = points.iter().fold((p0, p0), |(lo, hi), (p, _)| (lo.min(*p), hi.max(*p)));
        let extent = (hi - lo).max_element();
        let points = thin::merge(points, extent)?;
        if points.iter().all(|&(_, v)| v == v0) {
            return Err(RbfError::OneValue(v0));
        }
        let frame = Frame { origin: (lo + hi) / 2.0, scale: if extent > 0.0 { extent } else { 1.0 } };
        let kept = thin::spread(&points, extent, params.max_centres.saturating_mul(THIN_ABOVE));
        let points: Vec<(DVec3, f64)> = kept.into_iter().map(|i| points[i]).collect();

        let mut chosen = if points.len() <= params.max_centres {
            (0..points.len()).collect()
        } else {
            thin::spread(&points, extent, (params.max_centres / 8).clamp(4, 300))
        };
        loop {
            exec.check()?;
            let centres: Vec<(DVec3, f64)> = chosen.iter().map(|&i| points[i]).collect();
            let rbf = solve(&centres, params.kernel, frame, exec)?;
            let errors: Vec<f64> =
                exec.install(|| points.par_iter().map(|(p, v)| (rbf.value(*p) - v).abs()).collect());
            let residual = errors.iter().copied().fold(0.0, f64::max);
            let room = params.max_centres.saturating_sub(chosen.len());
            let report = RbfReport { constraints: points.len(), centres: chosen.len(), residual };
            if room == 0 || chosen.len() == points.len() || residual <= params.tolerance {
                return Ok((rbf, report));
            }
            let more = worst(&points, &errors, params.tolerance, &chosen, room, extent);
            if more.is_empty() {
                return Ok((rbf, report));
            }
            chosen.extend(more);
            chosen.sort_unstable();
        }
    }
}

/// The constraints with the greatest errors, not too near to each other: about half as many as there
/// are centres already, so that the rounds together cost little more than the last one.
fn worst(
    points: &[(DVec3, f64)],
    errors: &[f64],
    tolerance: f64,
    chosen: &[usize],
    room: usize,
    extent: f64,
) -> Vec<usize> {
    let is_centre: BTreeSet<usize> = chosen.iter().copied().collect();
    let mut candidates: Vec<usize> =
        (0..points.len()).filter(|i| errors[*i] > tolerance && !is_centre.contains(i)).collect();
    candidates.sort_by(|&a, &b| errors[b].total_cmp(&errors[a]).then(a.cmp(&b)));
    let wanted = room.min(chosen.len() / 2 + 16);
    let cell = 0.5 * extent / ((chosen.len() + wanted) as f64).sqrt();
    let mut taken = BTreeSet::new();
    candidates.retain(|&i| taken.insert(thin::voxel(points[i].0, cell)));
    candidates.truncate(wanted);
    candidates
}

/// Coordinates that the constraints fill to about ±½.
#[derive(Clone, Copy)]
struct Frame {
    origin: DVec3,
    scale: f64,
}

/// The interpolant with a centre at every constraint, by the null-space method: with Householder
/// reflections H that take the polynomial columns P to [R; 0], the lower right block of H A Hᵀ is
/// positive definite and gives the weights, its upper rows the polynomial.
fn solve(constraints: &[(DVec3, f64)], kernel: Kernel, frame: Frame, exec: &Exec) -> Result<Rbf, RbfError> {
    let n = constraints.len();
    let centres: Vec<DVec3> = constraints.iter().map(|(p, _)| (*p - frame.origin) / frame.scale).collect();
    let axes = axes(&centres);
    let m = (1 + axes.len()).min(n);

    let mut a = Vec::new();
    a.try_reserve_exact(n * n).map_err(|_| SolveError::OutOfMemory { size: n })?;
    for (i, &c) in centres.iter().enumerate() {
        if i % 256 == 0 {
            exec.check()?;
        }
        a.extend(centres.iter().map(|d| kernel.sign() * kernel.at(c.distance(*d))));
    }
    let mut p: Vec<Vec<f64>> = vec![vec![1.0; n]];
    p.extend(axes.iter().map(|axis| centres.iter().map(|c| axis.dot(*c)).collect()));
    p.truncate(m);
    let mut f: Vec<f64> = constraints.iter().map(|(_, v)| *v).collect();

    let mut reflectors = Vec::with_capacity(m);
    for k in 0..m {
        exec.check()?;
        let h = Reflector::new(&p[k], k);
        p.iter_mut().for_each(|column| h.apply(column));
        h.apply(&mut f);
        h.apply_both_sides(&mut a, n);
        reflectors.push(h);
    }

    let mut weights = vec![0.0; n];
    weights[m..].copy_from_slice(&f[m..]);
    let block = MatMut::from_column_major_slice_mut(&mut a, n, n).submatrix_mut(m, m, n - m, n - m);
    // The block's lower triangle becomes the factor; the upper rows of the whole stay as they are.
    solve_dense_spd(block, &mut weights[m..])?;
    let mut c = vec![0.0; m];
    for k in (0..m).rev() {
        let kernel_part: f64 = (m..n).map(|j| a[j * n + k] * weights[j]).sum();
        let known: f64 = (k + 1..m).map(|j| p[j][k] * c[j]).sum();
        c[k] = (f[k] - kernel_part - known) / p[k][k];
    }
    reflectors.iter().rev().for_each(|h| h.apply(&mut weights));

    let mut packed = vec![[[0.0; LANES]; 4]; n.div_ceil(LANES)];
    for (i, (c, w)) in centres.iter().zip(&weights).enumerate() {
        for (row, x) in [c.x, c.y, c.z, kernel.sign() * w].into_iter().enumerate() {
            packed[i / LANES][row][i % LANES] = x;
        }
    }
    Ok(Rbf {
        kernel,
        origin: frame.origin,
        scale: frame.scale,
        constant: c[0],
        slope: axes.iter().zip(&c[1..]).map(|(axis, c)| *axis * *c).sum(),
        centres: packed,
        count: n,
    })
}

/// The directions in which the points have an extent: three, two for a flat set, one for a straight
/// one, none for a single point.
fn axes(points: &[DVec3]) -> Vec<DVec3> {
    let mean = points.iter().sum::<DVec3>() / points.len() as f64;
    let mut scatter: Symmetric = [0.0; 6];
    for p in points {
        for (s, o) in scatter.iter_mut().zip(outer(*p - mean)) {
            *s += o;
        }
    }
    let pairs = eigen(scatter);
    // Squares: a set thinner than a millionth of its length counts as flat.
    pairs.iter().filter(|(value, _)| *value > 1e-12 * pairs[0].0).map(|(_, axis)| *axis).collect()
}

/// I − β v vᵀ, where v is 0 before `from`.
struct Reflector {
    v: Vec<f64>,
    beta: f64,
    from: usize,
}

impl Reflector {
    /// Takes `column` to a multiple of unit vector `from`, leaving the entries before it.
    fn new(column: &[f64], from: usize) -> Self {
        let mut v = column.to_vec();
        v[..from].fill(0.0);
        let norm = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        v[from] += norm.copysign(v[from]);
        let square: f64 = v.iter().map(|x| x * x).sum();
        Self { v, beta: if square > 0.0 { 2.0 / square } else { 0.0 }, from }
    }

    fn apply(&self, x: &mut [f64]) {
        let dot: f64 = self.v.iter().zip(&*x).skip(self.from).map(|(v, x)| v * x).sum();
        for (x, v) in x.iter_mut().zip(&self.v).skip(self.from) {
            *x -= self.beta * dot * v;
        }
    }

    /// A ← H A H for a symmetric A: A − v qᵀ − q vᵀ with p = β A v, q = p − (β/2)(vᵀp) v.
    fn apply_both_sides(&self, a: &mut [f64], n: usize) {
        let mut q = vec![0.0; n];
        for (column, v) in a.chunks_exact(n).zip(&self.v) {
            for (q, a) in q.iter_mut().zip(column) {
                *q += self.beta * v * a;
            }
        }
        let half = 0.5 * self.beta * self.v.iter().zip(&q).map(|(v, p)| v * p).sum::<f64>();
        for (q, v) in q.iter_mut().zip(&self.v) {
            *q -= half * v;
        }
        for (j, column) in a.chunks_exact_mut(n).enumerate() {
            let (vj, qj) = (self.v[j], q[j]);
            for ((a, v), q) in column.iter_mut().zip(&self.v).zip(&q) {
                *a -= v * qj + q * vj;
            }
        }
    }
}
