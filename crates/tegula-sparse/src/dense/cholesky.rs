//! Partial Cholesky factorisation of a dense matrix, block column by block column.

use nalgebra::DMatrixViewMut;

use super::{DiagonalBlock, Part, Target, subtract_product};
use crate::trapezoid::BLOCK;

/// Partial Cholesky factorisation of dense matrices, with its workspace.
pub struct PartialCholesky(DiagonalBlock);

impl Default for PartialCholesky {
    fn default() -> Self {
        Self(DiagonalBlock::new())
    }
}

impl PartialCholesky {
    /// Factors the first columns of a symmetric matrix in place, given by their lower triangle and the rows below it:
    /// `L₁₁ L₁₁ᵀ = A₁₁`, `L₂₁ = A₂₁ L₁₁⁻ᵀ`. What is above the diagonal is neither read nor written. Returns false if a pivot
    /// is not positive and finite; the columns are then partly factored.
    ///
    /// # Panics
    /// The matrix has fewer rows than columns.
    pub fn factor(&mut self, mut columns: DMatrixViewMut<'_, f64>) -> bool {
        let (rows, n) = columns.shape();
        assert!(rows >= n);
        for first in (0..n).step_by(BLOCK) {
            let count = BLOCK.min(n - first);
            let mut from = columns.rows_mut(first, rows - first);
            let (left, mut own) = from.columns_range_pair_mut(..first, first..first + count);
            let left = left.as_view();
            subtract_product(own.as_view_mut(), left, left.rows(0, count), Part::Lower, Target::Add);
            let (block, below) = own.rows_range_pair_mut(..count, count..);
            if !self.0.factor(block) {
                return false;
            }
            self.0.solve_rows(below);
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::norm::max_norm;
    use nalgebra::DMatrix;

    fn positive_definite(n: usize) -> DMatrix<f64> {
        let b = DMatrix::from_fn(n, n, |i, j| ((i * 7 + j * 13) % 17) as f64 / 17.0 - 0.4);
        &b * b.transpose() + DMatrix::identity(n, n)
    }

    #[test]
    fn the_factor_and_the_schur_complement_make_up_the_matrix() {
        for (n, width) in [(0, 0), (1, 1), (2, 1), (40, 0), (130, 128), (129, 129), (300, 270), (300, 300)] {
            let a = positive_definite(n);
            let mut l = DMatrix::from_fn(n, n, |i, j| if i < j { f64::NAN } else { a[(i, j)] });
            let (mut columns, mut rest) = l.columns_range_pair_mut(..width, width..);
            assert!(PartialCholesky::default().factor(columns.as_view_mut()));
            let below = columns.rows(width, n - width);
            subtract_product(rest.rows_mut(width, n - width), below, below, Part::Lower, Target::Add);
            assert!((0..n).all(|j| (0..j).all(|i| l[(i, j)].is_nan())), "what is above is not written");
            let lower = DMatrix::from_fn(n, width, |i, j| if i < j { 0.0 } else { l[(i, j)] });
            let product = &lower * lower.transpose();
            let errors = (0..n).flat_map(|j| (j..n).map(move |i| (i, j))).map(|(i, j)| {
                let rest = if j >= width { l[(i, j)] } else { 0.0 };
                product[(i, j)] + rest - a[(i, j)]
            });
            let worst = max_norm(errors.chain([0.0]));
            assert!(
                worst <= 1e-14 * (n + 1) as f64 * max_norm(a.iter().copied().chain([1.0])),
                "{n} {width}: {worst:e}"
            );
        }
    }

    #[test]
    fn a_pivot_that_is_not_positive_is_found_out() {
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            for at in [0, 127, 128, 199] {
                let mut a = positive_definite(200);
                a.row_mut(at).fill(0.0);
                a.column_mut(at).fill(0.0);
                a[(at, at)] = bad;
                assert!(!PartialCholesky::default().factor(a.as_view_mut()), "{bad} {at}");
            }
        }
    }
}
