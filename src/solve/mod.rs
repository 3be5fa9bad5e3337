//! Symmetric positive definite systems, sparse and dense: assemble, factor once, solve many right-hand sides.
//!
//! A parallel sum rounds differently from run to run, and Lapis gives the same bytes at any thread count: factors
//! are sequential, and stages run many such solves side by side; iterations sum over fixed chunks in order.

mod conjugate;
mod dense;
mod dissection;
mod symmetric;

pub(crate) use conjugate::{IterationError, add, conjugate_gradients};
pub use dense::solve_dense_spd;
pub use dissection::nested_dissection;
pub(crate) use faer::c64;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::perm::PermRef;
use faer::sparse::linalg::cholesky::{
    LltRef, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMat, Triplet};
use faer::traits::ComplexField;
use faer::{Conj, MatMut, Par, Side};
pub use symmetric::symmetric_eigen;

/// Why a system could not be solved.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SolveError {
    /// The matrix has a zero or negative pivot: something is unconstrained.
    #[error("the {size}×{size} system is not positive definite")]
    NotPositiveDefinite {
        /// Number of unknowns.
        size: usize,
    },
    /// An iteration did not come near the solution.
    #[error("the iteration for the {size}×{size} system does not come to an end")]
    NotConverged {
        /// Number of unknowns.
        size: usize,
    },
    /// The factor does not fit into memory.
    #[error("the {size}×{size} system is too large for the memory at hand")]
    OutOfMemory {
        /// Number of unknowns.
        size: usize,
    },
}

/// One entry of a matrix: row, column, value. Entries at one place add up.
pub type Entry<T = f64> = Triplet<usize, usize, T>;

/// A Cholesky factor L Lᴴ of a sparse positive definite matrix, symmetric or (of complex numbers) Hermitian.
pub struct Factor<T> {
    symbolic: SymbolicCholesky<usize>,
    numeric: Vec<T>,
    size: usize,
}

/// That of a symmetric matrix.
pub type SpdFactor = Factor<f64>;
/// That of a Hermitian matrix.
pub type HermitianFactor = Factor<c64>;

impl<T: ComplexField> Factor<T> {
    /// Factors the `size`×`size` matrix whose *lower triangle* (row ≥ column) is the sum of `lower`.
    ///
    /// # Errors
    /// [`SolveError`] where the matrix is not positive definite or too large.
    ///
    /// # Panics
    /// Where an entry lies outside the matrix.
    pub fn new(size: usize, lower: &[Entry<T>]) -> Result<Self, SolveError> {
        Self::build(size, lower, SymmetricOrdering::Amd)
    }

    /// The same, eliminating the unknowns in the given order, as from [`nested_dissection`].
    ///
    /// # Errors
    /// [`SolveError`] where the matrix is not positive definite or too large.
    ///
    /// # Panics
    /// Where an entry lies outside the matrix, or `order` is no permutation.
    pub fn ordered(order: &[usize], lower: &[Entry<T>]) -> Result<Self, SolveError> {
        let mut inverse = vec![0; order.len()];
        for (place, &v) in order.iter().enumerate() {
            inverse[v] = place;
        }
        let order = PermRef::new_checked(order, &inverse, order.len());
        Self::build(inverse.len(), lower, SymmetricOrdering::Custom(order))
    }

    fn build(
        size: usize,
        lower: &[Entry<T>],
        order: SymmetricOrdering<'_, usize>,
    ) -> Result<Self, SolveError> {
        let matrix = SparseColMat::<usize, T>::try_new_from_triplets(size, size, lower)
            .map_err(|_| SolveError::OutOfMemory { size })?;
        let oom = |_| SolveError::OutOfMemory { size };
        let symbolic = factorize_symbolic_cholesky(matrix.symbolic(), Side::Lower, order, Default::default())
            .map_err(oom)?;
        let mut numeric = vec![T::zero_impl(); symbolic.len_val()];
        let scratch = symbolic.factorize_numeric_llt_scratch::<T>(Par::Seq, Default::default());
        let mut memory = MemBuffer::try_new(scratch).map_err(|_| SolveError::OutOfMemory { size })?;
        symbolic
            .factorize_numeric_llt::<T>(
                &mut numeric,
                matrix.as_ref(),
                Side::Lower,
                Default::default(),
                Par::Seq,
                MemStack::new(&mut memory),
                Default::default(),
            )
            .map_err(|_| SolveError::NotPositiveDefinite { size })?;
        Ok(Self { symbolic, numeric, size })
    }

    /// Number of unknowns.
    #[must_use]
    pub fn size(&self) -> usize {
        self.size
    }

    /// Solves in place for `columns` right-hand sides stored one after another.
    ///
    /// # Panics
    /// Where `rhs.len()` is not `size() * columns`.
    pub fn solve(&self, rhs: &mut [T], columns: usize) {
        assert_eq!(rhs.len(), self.size * columns, "right-hand side of another size");
        let scratch = self.symbolic.solve_in_place_scratch::<T>(columns, Par::Seq);
        let mut memory = MemBuffer::new(scratch);
        let rhs = MatMut::from_column_major_slice_mut(rhs, self.size, columns);
        LltRef::<'_, usize, T>::new(&self.symbolic, &self.numeric).solve_in_place_with_conj(
            Conj::No,
            rhs,
            Par::Seq,
            MemStack::new(&mut memory),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_the_discrete_poisson_problem() {
        // −u″ = 2 on (0, 1) with u = 0 at both ends has the solution x(1−x), exact at the nodes.
        let n = 99;
        let h = 1.0 / 100.0;
        let mut lower = Vec::new();
        for i in 0..n {
            lower.push(Entry::new(i, i, 2.0 / (h * h)));
            if i > 0 {
                lower.push(Entry::new(i, i - 1, -1.0 / (h * h)));
            }
        }
        let factor = SpdFactor::new(n, &lower).unwrap();
        let mut u = vec![2.0; 2 * n];
        u[n..].fill(4.0);
        factor.solve(&mut u, 2);
        for i in 0..n {
            #[allow(clippy::cast_precision_loss)]
            let x = (i + 1) as f64 * h;
            assert!((u[i] - x * (1.0 - x)).abs() < 1e-10);
            assert!((u[n + i] - 2.0 * x * (1.0 - x)).abs() < 1e-10);
        }
    }

    #[test]
    fn a_hermitian_system_is_solved() {
        // Around a ring, each number is the last one turned by a sixth of the circle more than fits: A = I + D with
        // D z = z − e^{iθ} (the one before), as it is for least squares of such steps.
        let (n, turn) = (12, c64::from_polar(1.0, 0.7));
        let mut lower = Vec::new();
        for i in 0..n {
            lower.push(Entry::new(i, i, c64::new(2.5, 0.0)));
            let next = (i + 1) % n;
            let (row, col, value) = if next > i { (next, i, -turn) } else { (i, next, -turn.conj()) };
            lower.push(Entry::new(row, col, value));
        }
        let x: Vec<c64> = (0..n).map(|k| c64::new(k as f64 * 0.3 - 1.0, (k as f64).sin())).collect();
        let mut rhs: Vec<c64> =
            (0..n).map(|k| x[k] * 2.5 - turn * x[(k + n - 1) % n] - turn.conj() * x[(k + 1) % n]).collect();
        HermitianFactor::new(n, &lower).unwrap().solve(&mut rhs, 1);
        assert!(x.iter().zip(&rhs).all(|(a, b)| (a - b).norm() < 1e-12));
    }

    #[test]
    fn an_indefinite_matrix_is_an_error() {
        let lower = [Entry::new(0, 0, 1.0), Entry::new(1, 1, -1.0)];
        assert_eq!(SpdFactor::new(2, &lower).err(), Some(SolveError::NotPositiveDefinite { size: 2 }));
    }
}
