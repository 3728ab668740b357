//! LBLᵀ factorisation with rook pivoting of columns of a front whose diagonal block is not positive definite.
//!
//! The columns are eliminated with 1×1 and 2×2 pivots, chosen among themselves so that the entries of L within the
//! block stay bounded. The signs of the pivots are the inertia of the matrix.
//!
//! J. R. Bunch, L. Kaufman, *Some stable methods for calculating inertia and solving symmetric linear systems*, Math.
//! Comp. 31 (1977) 163–179; C. Ashcraft, R. G. Grimes, J. G. Lewis, *Accurate symmetric indefinite linear equation
//! solvers*, SIAM J. Matrix Anal. Appl. 20 (1998) 513–561.

use std::ops::Range;

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

/// Pivots of consecutive columns of a front: `P A Pᵀ = L B Lᵀ`. The factor L is stored in place of the columns.
pub(super) struct BlockPivots {
    /// Diagonal of B.
    diagonal: Vec<f64>,
    /// Entries of B below its diagonal.
    below: Vec<f64>,
    /// Permutation P as transpositions: the place with which each place is exchanged, one after another.
    swaps: Vec<usize>,
}

impl BlockPivots {
    /// Factors the diagonal block `first`, given by its lower triangle, and the rows `second` below it:
    /// `L₂₁ = A₂₁ Pᵀ L₁₁⁻ᵀ B⁻¹`.
    ///
    /// # Errors
    /// A pivot vanished or is not a number, or there is no memory.
    pub fn new(mut first: MatMut<'_, f64>, mut second: MatMut<'_, f64>) -> Result<Self, FactorError> {
        let n = first.nrows();
        if (0..n).any(|j| first.rb().col(j).subrows(j, n - j).iter().any(|x| !x.is_finite())) {
            return Err(FactorError::Singular);
        }
        let mut parameters =
            LbltParams { pivoting: PivotingStrategy::Rook, ..<LbltParams as Auto<f64>>::auto() };
        if n <= BLOCK {
            parameters.block_size = 0;
        }
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
        let diagonal = (0..n).map(|j| first[(j, j)]).collect();
        let out = Self { diagonal, below, swaps: swaps(&order) };
        if out.inertia().zero > 0 {
            return Err(FactorError::Singular);
        }
        let rows = Mat::from_fn(second.nrows(), n, |i, j| second[(i, order[j])]);
        second.copy_from(&rows);
        solve_unit_lower_triangular_in_place(first.rb(), second.rb_mut().transpose_mut(), Par::Seq);
        out.divide_columns(second);
        Ok(out)
    }

    /// Inertia of B: the signs of its eigenvalues.
    pub fn inertia(&self) -> Inertia {
        let mut out = Inertia::default();
        self.each(|_, pivot| match pivot {
            Pivot::Single(d) if d > 0.0 => out.positive += 1,
            Pivot::Single(d) if d < 0.0 => out.negative += 1,
            // A 2×2 pivot is chosen where its off-diagonal entry dominates: it has one eigenvalue of each sign.
            Pivot::Pair([a, b, c]) if (a / b) * (c / b) < 1.0 => {
                out.positive += 1;
                out.negative += 1;
            }
            Pivot::Single(_) => out.zero += 1,
            Pivot::Pair(_) => out.zero += 2,
        });
        out
    }

    /// Pivot sizes by column: the largest absolute entry of B in the column.
    pub fn sizes(&self) -> Vec<f64> {
        let mut out: Vec<f64> = self.diagonal.iter().map(|d| d.abs()).collect();
        for (j, b) in self.below.iter().enumerate().filter(|(_, b)| **b != 0.0) {
            for size in &mut out[j..j + 2] {
                *size = size.max(b.abs());
            }
        }
        self.restore(&mut out);
        out
    }

    /// Whether every pivot is larger than the rounding errors of a matrix with these scales of its rows.
    pub fn exceed_rounding(&self, scale: &[f64]) -> bool {
        self.sizes().iter().zip(scale).all(|(size, s)| *size > f64::EPSILON * s * s)
    }

    /// Growth of the entries below the block: the most that a pivot may change one of them, from the rows of `L₂₁` and
    /// their scales. It is the largest entry of `abs(L) abs(B) abs(Lᵀ)`, or a bound of it for a 2×2 pivot.
    pub fn growth(&self, rows: MatRef<'_, f64>, scale: &[f64]) -> f64 {
        let largest = |j: usize| {
            rows.col(j)
                .iter()
                .zip(scale)
                .map(|(l, s)| (l / s).abs())
                .fold(0.0, |most, l| if l.is_finite() { l.max(most) } else { f64::INFINITY })
        };
        let mut most = 0.0_f64;
        self.each(|j, pivot| {
            let grown: f64 = match pivot {
                Pivot::Single(d) => d.abs() * largest(j).powi(2),
                Pivot::Pair([a, b, c]) => {
                    let (l, next) = (largest(j), largest(j + 1));
                    a.abs() * l * l + 2.0 * b.abs() * l * next + c.abs() * next * next
                }
            };
            most = grown.max(most);
        });
        most
    }

    /// Some columns of the product `L₂₁ B`, for `rows` rows of `L₂₁` whose entries `at` returns by row and column.
    pub fn multiply(&self, rows: usize, columns: Range<usize>, at: impl Fn(usize, usize) -> f64) -> Mat<f64> {
        Mat::from_fn(rows, columns.len(), |i, j| {
            let j = columns.start + j;
            let mut sum = self.diagonal[j] * at(i, j);
            if j + 1 < self.below.len() && self.below[j] != 0.0 {
                sum += self.below[j] * at(i, j + 1);
            }
            if j > 0 && self.below[j - 1] != 0.0 {
                sum += self.below[j - 1] * at(i, j - 1);
            }
            sum
        })
    }

    /// Multiplies the columns of the rows below the block by `B⁻¹` from the right.
    fn divide_columns(&self, mut rows: MatMut<'_, f64>) {
        self.each(|j, pivot| match pivot {
            Pivot::Single(d) => rows.rb_mut().col_mut(j).iter_mut().for_each(|x| *x /= d),
            Pivot::Pair(block) => {
                for i in 0..rows.nrows() {
                    [rows[(i, j)], rows[(i, j + 1)]] = solve_pair(block, [rows[(i, j)], rows[(i, j + 1)]]);
                }
            }
        });
    }

    /// Solves with the block-diagonal factor, `X := B⁻¹ X`, for K right sides side by side.
    pub fn divide<const K: usize>(&self, x: &mut [[f64; K]]) {
        self.each(|j, pivot| match pivot {
            Pivot::Single(d) => x[j].iter_mut().for_each(|x| *x /= d),
            Pivot::Pair(block) => {
                for k in 0..K {
                    [x[j][k], x[j + 1][k]] = solve_pair(block, [x[j][k], x[j + 1][k]]);
                }
            }
        });
    }

    /// Permutes the unknowns of the columns into the order of the pivots.
    pub fn permute<T>(&self, x: &mut [T]) {
        for (j, &other) in self.swaps.iter().enumerate() {
            x.swap(j, other);
        }
    }

    /// Permutes the unknowns from the order of the pivots back into the order of the columns.
    pub fn restore<T>(&self, x: &mut [T]) {
        for (j, &other) in self.swaps.iter().enumerate().rev() {
            x.swap(j, other);
        }
    }

    /// Calls `f` with each pivot and its first column.
    #[inline]
    fn each(&self, mut f: impl FnMut(usize, Pivot)) {
        let (n, mut j) = (self.below.len(), 0);
        while j < n {
            let b = self.below[j];
            if b == 0.0 || j + 1 == n {
                f(j, Pivot::Single(self.diagonal[j]));
                j += 1;
            } else {
                f(j, Pivot::Pair([self.diagonal[j], b, self.diagonal[j + 1]]));
                j += 2;
            }
        }
    }
}

/// Transpositions that bring the element at `order[j]` to place j, one place after another.
fn swaps(order: &[usize]) -> Vec<usize> {
    let n = order.len();
    // Current place of each element, and the element at each place.
    let (mut place, mut content): (Vec<usize>, Vec<usize>) = ((0..n).collect(), (0..n).collect());
    let mut out = Vec::with_capacity(n);
    for (j, &wanted) in order.iter().enumerate() {
        let from = place[wanted];
        out.push(from);
        place.swap(content[j], wanted);
        content.swap(j, from);
    }
    out
}

/// Pivot of size 1×1, or of size 2×2 as the lower triangle of `[[a, b], [b, c]]`.
#[derive(Clone, Copy)]
enum Pivot {
    Single(f64),
    Pair([f64; 3]),
}

/// Solution with a 2×2 pivot, `[[a, b], [b, c]]⁻¹ [x, y]`, divided by b first so that nothing overflows.
fn solve_pair([a, b, c]: [f64; 3], [x, y]: [f64; 2]) -> [f64; 2] {
    let (a, c, x, y) = (a / b, c / b, x / b, y / b);
    let determinant = a * c - 1.0;
    [(c * x - y) / determinant, (a * y - x) / determinant]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::norm::max_norm;

    /// Reconstructs sparse matrices with zeros on the diagonal from their factors.
    #[test]
    fn factors_make_up_the_matrix() {
        let mut state = 1_u64;
        let mut random = move || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        for n in (2..=140).chain([150, 200, 300]) {
            for density in [0.05, 0.1, 0.3, 0.6, 1.0] {
                let mut matrix = Mat::<f64>::zeros(n, n);
                for j in 0..n {
                    for i in j..n {
                        if random() < density && (i != j || random() < 0.5) {
                            matrix[(i, j)] = 2.0 * random() - 1.0;
                        }
                    }
                }
                let mut l = matrix.clone();
                let Ok(pivots) = BlockPivots::new(l.as_mut(), Mat::zeros(0, n).as_mut()) else { continue };
                for j in 0..n {
                    l[(j, j)] = 1.0;
                    (0..j).for_each(|i| l[(i, j)] = 0.0);
                }
                let lb = pivots.multiply(n, 0..n, |i, j| l[(i, j)]);
                let product = &lb * l.transpose();
                let mut order: Vec<f64> = (0..n).map(|i| i as f64).collect();
                pivots.permute(&mut order);
                let worst = (0..n).flat_map(|i| (0..n).map(move |j| (i, j))).map(|(i, j)| {
                    let (a, b) = (order[i] as usize, order[j] as usize);
                    (product[(i, j)] - matrix[(a.max(b), a.min(b))]).abs()
                });
                let worst = max_norm(worst);
                assert!(worst < 1e-11, "{n} {density}: {worst:e}");
            }
        }
    }
}
