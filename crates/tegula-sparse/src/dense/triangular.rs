//! Triangular solve (TRSM) with the transpose of a lower triangle from the right, `X := X L⁻ᵀ`.

use nalgebra::{DMatrixView, DMatrixViewMut};

use super::{DiagonalBlock, Part, Target, subtract_product};
use crate::trapezoid::BLOCK;

/// Diagonal of a triangular matrix.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Diagonal {
    /// The stored one.
    Stored,
    /// Ones; the stored values are not read.
    Unit,
}

/// Triangular solve `X := X L⁻ᵀ` with the lower triangle of `l`; what is above the diagonal is not read.
///
/// # Panics
/// The sizes do not agree.
pub fn solve_lower_from_right(l: DMatrixView<'_, f64>, diagonal: Diagonal, mut x: DMatrixViewMut<'_, f64>) {
    let n = l.nrows();
    assert!(l.ncols() == n && x.ncols() == n);
    if x.nrows() == 0 {
        return;
    }
    let mut block = DiagonalBlock::new();
    for first in (0..n).step_by(BLOCK) {
        let count = BLOCK.min(n - first);
        let (left, mut own) = x.columns_range_pair_mut(..first, first..first + count);
        let rows = l.view((first, 0), (count, first));
        subtract_product(own.as_view_mut(), left.as_view(), rows, Part::All, Target::Add);
        block.load(l.view((first, first), (count, count)), diagonal);
        block.solve_rows(own);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::norm::max_norm;
    use nalgebra::DMatrix;

    #[test]
    fn the_product_with_the_triangle_is_the_right_side() {
        for n in [1, 2, 5, 31, 127, 128, 129, 300] {
            for rows in [0, 1, 9, 50] {
                for diagonal in [Diagonal::Stored, Diagonal::Unit] {
                    let entry = |i: usize, j: usize| ((i * 7 + j * 13) % 17) as f64 / 17.0 - 0.4;
                    let mut l =
                        DMatrix::from_fn(n, n, |i, j| if i < j { f64::NAN } else { entry(i, j) / n as f64 });
                    (0..n).for_each(|j| l[(j, j)] = if diagonal == Diagonal::Unit { f64::NAN } else { 1.5 });
                    let b = DMatrix::from_fn(rows, n, entry);
                    let mut x = b.clone();
                    solve_lower_from_right(l.as_view(), diagonal, x.as_view_mut());
                    let unit = diagonal == Diagonal::Unit;
                    let lower = DMatrix::from_fn(n, n, |i, j| match i.cmp(&j) {
                        std::cmp::Ordering::Less => 0.0,
                        std::cmp::Ordering::Equal if unit => 1.0,
                        _ => l[(i, j)],
                    });
                    let worst = max_norm((&x * lower.transpose() - &b).iter().copied().chain([0.0]));
                    assert!(worst <= 1e-13, "{n} {rows} {diagonal:?}: {worst:e}");
                }
            }
        }
    }
}
