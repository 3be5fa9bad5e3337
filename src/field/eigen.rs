//! Eigenvectors of symmetric 3×3 matrices.

use glam::DVec3;

/// A symmetric 3×3 matrix: xx, yy, zz, xy, xz, yz.
pub(crate) type Symmetric = [f64; 6];

/// v vᵀ.
pub(crate) fn outer(v: DVec3) -> Symmetric {
    [v.x * v.x, v.y * v.y, v.z * v.z, v.x * v.y, v.x * v.z, v.y * v.z]
}

/// Eigenvalues and unit eigenvectors, the greatest value first, by cyclic Jacobi rotations.
pub(crate) fn eigen(m: Symmetric) -> [(f64, DVec3); 3] {
    let mut a = [[m[0], m[3], m[4]], [m[3], m[1], m[5]], [m[4], m[5], m[2]]];
    let mut v = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for _ in 0..16 {
        let off = a[0][1].abs() + a[0][2].abs() + a[1][2].abs();
        let size = a[0][0].abs() + a[1][1].abs() + a[2][2].abs();
        if off <= 1e-16 * size {
            break;
        }
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if a[p][q] == 0.0 {
                continue;
            }
            let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
            let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
            let c = 1.0 / (t * t + 1.0).sqrt();
            let s = t * c;
            for row in &mut a {
                (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
            }
            let (rp, rq) = (a[p], a[q]);
            a[p] = std::array::from_fn(|k| c * rp[k] - s * rq[k]);
            a[q] = std::array::from_fn(|k| s * rp[k] + c * rq[k]);
            for row in &mut v {
                (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
            }
        }
    }
    let mut pairs = [0, 1, 2].map(|k| (a[k][k], DVec3::new(v[0][k], v[1][k], v[2][k])));
    pairs.sort_by(|x, y| y.0.total_cmp(&x.0));
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenvectors_rebuild_the_matrix() {
        for m in [
            [2.0, -1.0, 0.5, 0.3, -0.7, 1.1],
            outer(DVec3::new(0.3, -0.4, 1.2)),
            [1.0, 1.0, 1.0, 0.0, 0.0, 0.0],
            [0.0; 6],
        ] {
            let pairs = eigen(m);
            assert!(pairs[0].0 >= pairs[1].0 && pairs[1].0 >= pairs[2].0);
            let mut sum = [0.0; 6];
            for (value, vector) in pairs {
                assert!((vector.length() - 1.0).abs() < 1e-14);
                for (s, o) in sum.iter_mut().zip(outer(vector)) {
                    *s += value * o;
                }
            }
            assert!(sum.iter().zip(m).all(|(s, m)| (s - m).abs() < 1e-13), "{sum:?} {m:?}");
        }
    }
}
