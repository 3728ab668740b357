//! LBLᵀ factorisation of the blocks on the diagonal that are not positive definite.
//!
//! The columns of such a block are eliminated with 1×1 and 2×2 pivots, chosen among themselves so that the entries of L
//! within the block stay bounded. The signs of the pivots are the inertia of the matrix.
//!
//! J. R. Bunch, L. Kaufman, *Some stable methods for calculating inertia and solving symmetric linear systems*, Math.
//! Comp. 31 (1977) 163–179; C. Ashcraft, R. G. Grimes, J. G. Lewis, *Accurate symmetric indefinite linear equation
//! solvers*, SIAM J. Matrix Anal. Appl. 20 (1998) 513–561.

use dyn_stack::{MemBuffer, MemStack};
use faer::diag::DiagMut;
use faer::linalg::cholesky::lblt::factor::{
    LbltParams, PivotingStrategy, cholesky_in_place, cholesky_in_place_scratch,
};
use faer::linalg::triangular_solve::solve_unit_lower_triangular_in_place;
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Auto, Mat, MatMut, MatRef, Par};

use super::trapezoid::BLOCK;
use super::{FactorError, Inertia};

/// Pivots of one block: `P A Pᵀ = L B Lᵀ`. L and the diagonal of B are where the block was.
pub(super) struct Pivots {
    /// Entries of B below its diagonal, by columns.
    below: Vec<f64>,
    /// Which column is eliminated at each place.
    order: Vec<usize>,
}

impl Pivots {
    /// Factors the block `first` on the diagonal, of which the lower triangle is given, and the rows `second` below it:
    /// `L₂₁ = A₂₁ Pᵀ L₁₁⁻ᵀ B⁻¹`. The same rows before they are divided by `B` are not kept.
    ///
    /// # Errors
    /// A pivot vanished or is not a number, or there is no memory.
    pub fn new(mut first: MatMut<'_, f64>, mut second: MatMut<'_, f64>) -> Result<Self, FactorError> {
        let n = first.nrows();
        if (0..n).any(|j| first.rb().col(j).subrows(j, n - j).iter().any(|x| !x.is_finite())) {
            return Err(FactorError::Singular);
        }
        let parameters = LbltParams {
            pivoting: PivotingStrategy::Rook,
            block_size: 0,
            ..<LbltParams as Auto<f64>>::auto()
        };
        let request = cholesky_in_place_scratch::<usize, f64>(n, Par::Seq, parameters.into());
        let mut memory = MemBuffer::try_new(request).map_err(|_| FactorError::TooLarge)?;
        let (mut below, mut order, mut inverse) = (vec![0.0; n], vec![0; n], vec![0; n]);
        cholesky_in_place(
            first.rb_mut(),
            DiagMut::from_slice_mut(&mut below),
            &mut order,
            &mut inverse,
            Par::Seq,
            MemStack::new(&mut memory),
            parameters.into(),
        );
        let out = Self { below, order };
        if out.inertia(first.rb()).zero > 0 {
            return Err(FactorError::Singular);
        }
        let rows = Mat::from_fn(second.nrows(), n, |i, j| second[(i, out.order[j])]);
        second.copy_from(&rows);
        solve_unit_lower_triangular_in_place(first.rb(), second.rb_mut().transpose_mut(), Par::Seq);
        out.divide_columns(first.rb(), second);
        Ok(out)
    }

    /// Signs of the eigenvalues of B.
    pub fn inertia(&self, first: MatRef<'_, f64>) -> Inertia {
        let mut out = Inertia::default();
        self.each(first, |_, pivot| match pivot {
            Pivot::Single(d) if d > 0.0 => out.positive += 1,
            Pivot::Single(d) if d < 0.0 => out.negative += 1,
            // Pairs are taken where the entry off the diagonal prevails: one eigenvalue of each sign.
            Pivot::Pair([a, b, c]) if (a / b) * (c / b) < 1.0 => {
                out.positive += 1;
                out.negative += 1;
            }
            Pivot::Single(_) => out.zero += 1,
            Pivot::Pair(_) => out.zero += 2,
        });
        out
    }

    /// `rows · B`, for rows of `L₂₁`.
    pub fn multiply(&self, first: MatRef<'_, f64>, rows: MatRef<'_, f64>) -> Mat<f64> {
        let mut out = rows.to_owned();
        self.each(first, |j, pivot| match pivot {
            Pivot::Single(d) => out.col_mut(j).iter_mut().for_each(|x| *x *= d),
            Pivot::Pair([a, b, c]) => {
                for i in 0..out.nrows() {
                    let (x, y) = (out[(i, j)], out[(i, j + 1)]);
                    (out[(i, j)], out[(i, j + 1)]) = (a * x + b * y, b * x + c * y);
                }
            }
        });
        out
    }

    /// Columns of rows below the block times `B⁻¹`.
    fn divide_columns(&self, first: MatRef<'_, f64>, mut rows: MatMut<'_, f64>) {
        self.each(first, |j, pivot| match pivot {
            Pivot::Single(d) => rows.rb_mut().col_mut(j).iter_mut().for_each(|x| *x /= d),
            Pivot::Pair(block) => {
                for i in 0..rows.nrows() {
                    [rows[(i, j)], rows[(i, j + 1)]] = solve_pair(block, [rows[(i, j)], rows[(i, j + 1)]]);
                }
            }
        });
    }

    /// `B⁻¹ x`.
    pub fn divide(&self, first: MatRef<'_, f64>, x: &mut [f64]) {
        self.each(first, |j, pivot| match pivot {
            Pivot::Single(d) => x[j] /= d,
            Pivot::Pair(block) => [x[j], x[j + 1]] = solve_pair(block, [x[j], x[j + 1]]),
        });
    }

    /// Brings the unknowns of the block into the order of the pivots.
    pub fn permute(&self, x: &mut [f64]) {
        let mut before = [0.0; BLOCK];
        before[..x.len()].copy_from_slice(x);
        for (x, &from) in x.iter_mut().zip(&self.order) {
            *x = before[from];
        }
    }

    /// Brings them back.
    pub fn restore(&self, x: &mut [f64]) {
        let mut before = [0.0; BLOCK];
        before[..x.len()].copy_from_slice(x);
        for (value, &to) in before.iter().zip(&self.order) {
            x[to] = *value;
        }
    }

    /// Calls `f` with the column of each pivot.
    #[inline]
    fn each(&self, first: MatRef<'_, f64>, mut f: impl FnMut(usize, Pivot)) {
        let (n, mut j) = (self.below.len(), 0);
        while j < n {
            let b = self.below[j];
            if b == 0.0 || j + 1 == n {
                f(j, Pivot::Single(first[(j, j)]));
                j += 1;
            } else {
                f(j, Pivot::Pair([first[(j, j)], b, first[(j + 1, j + 1)]]));
                j += 2;
            }
        }
    }
}

/// A pivot: a number, or `[[a, b], [b, c]]` by its lower triangle.
#[derive(Clone, Copy)]
enum Pivot {
    Single(f64),
    Pair([f64; 3]),
}

/// `[[a, b], [b, c]]⁻¹ [x, y]`, divided by b first so that nothing overflows.
fn solve_pair([a, b, c]: [f64; 3], [x, y]: [f64; 2]) -> [f64; 2] {
    let (a, c, x, y) = (a / b, c / b, x / b, y / b);
    let determinant = a * c - 1.0;
    [(c * x - y) / determinant, (a * y - x) / determinant]
}
