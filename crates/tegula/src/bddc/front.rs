//! Partial Cholesky factorisation of a dense front of a subdomain.

use dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::cholesky_in_place;
use faer::linalg::matmul::triangular::{BlockStructure, matmul as triangular_matmul};
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, MatMut, Par};

/// Error of a factorisation with a pivot that is not positive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct NotPositive;

/// Partial Cholesky factorisation of a front with `width` fully summed columns and `below` rows beneath them:
/// `L₁₁ L₁₁ᵀ = A₁₁`, `L₂₁ = A₂₁ L₁₁⁻ᵀ`. The contribution block in `out` is updated to `C − L₂₁ L₂₁ᵀ`.
pub(super) fn eliminate(
    (width, below): (usize, usize),
    panel: &mut [f64],
    out: &mut [f64],
    dense: &mut MemBuffer,
) -> Result<(), NotPositive> {
    let height = width + below;
    let panel = MatMut::from_column_major_slice_with_stride_mut(panel, height, width, height);
    let (mut first, mut second) = panel.split_at_row_mut(width);
    cholesky_in_place(first.rb_mut(), Default::default(), Par::Seq, MemStack::new(dense), Default::default())
        .map_err(|_| NotPositive)?;
    if below == 0 {
        return Ok(());
    }
    solve_lower_triangular_in_place(first.rb(), second.rb_mut().transpose_mut(), Par::Seq);
    let out = MatMut::from_column_major_slice_mut(out, below, below);
    triangular_matmul(
        out,
        BlockStructure::TriangularLower,
        Accum::Add,
        second.rb(),
        BlockStructure::Rectangular,
        second.rb().transpose(),
        BlockStructure::Rectangular,
        -1.0,
        Par::Seq,
    );
    Ok(())
}
