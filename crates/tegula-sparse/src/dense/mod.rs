//! Dense kernels: products (GEMM, SYRK), triangular solves (TRSM), Cholesky factorisation, LBLᵀ factorisation.
//!
//! All matrices are stored by columns; a view may have more rows between its columns. One thread runs each call. The
//! results depend on the values and sizes alone, not on where a matrix lies in memory.

mod cholesky;
mod diagonal_block;
mod lblt;
mod product;
mod triangular;

use std::ops::Range;

use nalgebra::{DMatrixView, DMatrixViewMut, Dyn, U1};

pub use cholesky::PartialCholesky;
pub(crate) use diagonal_block::DiagonalBlock;
pub(crate) use lblt::{Lblt, lblt, solve_pair};
pub use product::{Part, Target, subtract_product};
pub use triangular::{Diagonal, solve_lower_from_right};

/// Some rows of a column of a matrix.
#[inline(always)]
pub(crate) fn piece<'a>(matrix: &'a DMatrixView<'_, f64>, rows: Range<usize>, column: usize) -> &'a [f64] {
    matrix.generic_view((rows.start, column), (Dyn(rows.len()), U1)).data.into_slice()
}

/// Some rows of a column of a matrix.
#[inline(always)]
pub(crate) fn piece_mut<'a>(
    matrix: &'a mut DMatrixViewMut<'_, f64>,
    rows: Range<usize>,
    column: usize,
) -> &'a mut [f64] {
    matrix.generic_view_mut((rows.start, column), (Dyn(rows.len()), U1)).data.into_slice_mut()
}
