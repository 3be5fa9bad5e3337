//! Dense symmetric positive definite systems.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::{factor, solve};
use faer::{Conj, MatMut, Par};

use super::SolveError;

/// Solves in place for `rhs`; of `matrix` only the lower triangle is read, and it is overwritten by the
/// factor. Sequential: the same bytes on any number of threads.
///
/// # Errors
/// [`SolveError`] where the matrix is not positive definite or there is no memory for the scratch space.
///
/// # Panics
/// Where the matrix is not square or `rhs` has another length.
pub fn solve_dense_spd(mut matrix: MatMut<'_, f64>, rhs: &mut [f64]) -> Result<(), SolveError> {
    let size = rhs.len();
    assert_eq!((matrix.nrows(), matrix.ncols()), (size, size), "matrix of another size");
    if size == 0 {
        return Ok(());
    }
    let scratch = factor::cholesky_in_place_scratch::<f64>(size, Par::Seq, Default::default())
        .or(solve::solve_in_place_scratch::<f64>(size, 1, Par::Seq));
    let mut memory = MemBuffer::try_new(scratch).map_err(|_| SolveError::OutOfMemory { size })?;
    let stack = MemStack::new(&mut memory);
    factor::cholesky_in_place(matrix.as_mut(), Default::default(), Par::Seq, stack, Default::default())
        .map_err(|_| SolveError::NotPositiveDefinite { size })?;
    let rhs = MatMut::from_column_major_slice_mut(rhs, size, 1);
    solve::solve_in_place_with_conj(matrix.as_ref(), Conj::No, rhs, Par::Seq, stack);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_a_small_system_and_refuses_an_indefinite_one() {
        // [4 2; 2 3] x = [10; 8] has x = [1.75; 1.5]. The upper triangle is never read.
        let mut a = [4.0, 2.0, f64::NAN, 3.0];
        let mut x = [10.0, 8.0];
        solve_dense_spd(MatMut::from_column_major_slice_mut(&mut a, 2, 2), &mut x).unwrap();
        assert!((x[0] - 1.75).abs() < 1e-14 && (x[1] - 1.5).abs() < 1e-14);
        let mut a = [1.0, 2.0, 2.0, 1.0];
        let refused = solve_dense_spd(MatMut::from_column_major_slice_mut(&mut a, 2, 2), &mut x);
        assert_eq!(refused, Err(SolveError::NotPositiveDefinite { size: 2 }));
    }
}
