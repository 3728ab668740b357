//! LBLᵀ factorisation with rook pivoting of columns of a front whose diagonal block is not positive definite.
//!
//! The columns are eliminated with 1×1 and 2×2 pivots, chosen among themselves so that the entries of L within the
//! block stay bounded. The signs of the pivots are the inertia of the matrix.
//!
//! J. R. Bunch, L. Kaufman, *Some stable methods for calculating inertia and solving symmetric linear systems*, Math.
//! Comp. 31 (1977) 163–179; C. Ashcraft, R. G. Grimes, J. G. Lewis, *Accurate symmetric indefinite linear equation
//! solvers*, SIAM J. Matrix Anal. Appl. 20 (1998) 513–561.

use std::ops::Range;

use nalgebra::{DMatrix, DMatrixView, DMatrixViewMut};

use super::dense::{Diagonal, Lblt, lblt, piece, piece_mut, solve_lower_from_right, solve_pair};
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
    /// A pivot vanished or an entry is not a number, or there is no memory.
    pub fn new(
        mut first: DMatrixViewMut<'_, f64>,
        mut second: DMatrixViewMut<'_, f64>,
    ) -> Result<Self, FactorError> {
        let n = first.nrows();
        let Lblt { diagonal, below, order } = lblt(first.as_view_mut())?;
        let out = Self { diagonal, below, swaps: swaps(&order) };
        if out.inertia().zero > 0 {
            return Err(FactorError::Singular);
        }
        let rows = DMatrix::from_fn(second.nrows(), n, |i, j| second[(i, order[j])]);
        second.copy_from(&rows);
        solve_lower_from_right(first.as_view(), Diagonal::Unit, second.as_view_mut());
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
    pub fn growth(&self, rows: &DMatrixView<'_, f64>, scale: &[f64]) -> f64 {
        let largest = |j: usize| {
            piece(rows, 0..rows.nrows(), j)
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
    pub fn multiply(
        &self,
        rows: usize,
        columns: Range<usize>,
        at: impl Fn(usize, usize) -> f64,
    ) -> DMatrix<f64> {
        DMatrix::from_fn(rows, columns.len(), |i, j| {
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
    fn divide_columns(&self, mut rows: DMatrixViewMut<'_, f64>) {
        let count = rows.nrows();
        self.each(|j, pivot| match pivot {
            Pivot::Single(d) => piece_mut(&mut rows, 0..count, j).iter_mut().for_each(|x| *x /= d),
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::norm::max_norm;

    fn random() -> impl FnMut() -> f64 {
        let mut state = 1_u64;
        move || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 11) as f64 / (1_u64 << 53) as f64
        }
    }

    /// Sparse lower triangle with zeros on the diagonal.
    fn sparse(n: usize, density: f64, random: &mut impl FnMut() -> f64) -> DMatrix<f64> {
        let mut matrix = DMatrix::<f64>::zeros(n, n);
        for j in 0..n {
            for i in j..n {
                if random() < density && (i != j || random() < 0.5) {
                    matrix[(i, j)] = 2.0 * random() - 1.0;
                }
            }
        }
        matrix
    }

    fn symmetric(lower: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(lower.nrows(), lower.nrows(), |i, j| lower[(i.max(j), i.min(j))])
    }

    fn factor(lower: &DMatrix<f64>) -> Result<(DMatrix<f64>, BlockPivots), FactorError> {
        let mut l = lower.clone();
        let n = l.nrows();
        let pivots = BlockPivots::new(l.as_view_mut(), DMatrix::zeros(0, n).as_view_mut())?;
        let unit = DMatrix::from_fn(n, n, |i, j| if i > j { l[(i, j)] } else { f64::from(u8::from(i == j)) });
        Ok((unit, pivots))
    }

    /// Reconstructs matrices from their factors. The entries of L are at most `1/(1 − α)`, α = (1 + √17)/8.
    #[test]
    fn factors_make_up_the_matrix() {
        let mut random = random();
        let mut factored = 0;
        for n in (0..=140).chain([150, 200, 300]) {
            for density in [0.05, 0.1, 0.3, 0.6, 1.0] {
                let matrix = sparse(n, density, &mut random);
                let Ok((l, pivots)) = factor(&matrix) else { continue };
                factored += 1;
                let lb = pivots.multiply(n, 0..n, |i, j| l[(i, j)]);
                let product = &lb * l.transpose();
                let mut order: Vec<f64> = (0..n).map(|i| i as f64).collect();
                pivots.permute(&mut order);
                let worst = (0..n).flat_map(|i| (0..n).map(move |j| (i, j))).map(|(i, j)| {
                    let (a, b) = (order[i] as usize, order[j] as usize);
                    (product[(i, j)] - matrix[(a.max(b), a.min(b))]).abs()
                });
                let worst = max_norm(worst.chain([0.0]));
                assert!(worst < 1e-11, "{n} {density}: {worst:e}");
                let largest = max_norm(l.iter().copied().chain([0.0]));
                assert!(largest <= 2.8, "{n} {density}: {largest}");
            }
        }
        assert!(factored > 500, "{factored}");
    }

    /// Sylvester's law: the pivots have the signs of the eigenvalues.
    #[test]
    fn the_inertia_is_that_of_the_eigenvalues() {
        let mut random = random();
        for n in [1, 2, 3, 10, 63, 64, 65, 130] {
            let matrix = sparse(n, 1.0, &mut random) + DMatrix::identity(n, n) * 1e-3;
            let (_, pivots) = factor(&matrix).unwrap();
            let eigenvalues = symmetric(&matrix).symmetric_eigenvalues();
            let inertia = pivots.inertia();
            assert_eq!(inertia.positive, eigenvalues.iter().filter(|e| **e > 0.0).count(), "{n}");
            assert_eq!(inertia.negative, eigenvalues.iter().filter(|e| **e < 0.0).count(), "{n}");
        }
    }

    #[test]
    fn the_rows_below_are_those_of_the_factor_of_the_whole_matrix() {
        let mut random = random();
        for (n, rows) in [(1, 1), (2, 3), (64, 10), (129, 40), (200, 5)] {
            let mut first = sparse(n, 1.0, &mut random);
            let below = DMatrix::from_fn(rows, n, |_, _| 2.0 * random() - 1.0);
            let mut second = below.clone();
            let pivots = BlockPivots::new(first.as_view_mut(), second.as_view_mut()).unwrap();
            let l = DMatrix::from_fn(
                n,
                n,
                |i, j| if i > j { first[(i, j)] } else { f64::from(u8::from(i == j)) },
            );
            let product = pivots.multiply(rows, 0..n, |i, j| second[(i, j)]) * l.transpose();
            let mut order: Vec<usize> = (0..n).collect();
            pivots.permute(&mut order);
            let errors =
                (0..rows * n).map(|k| (k / n, k % n)).map(|(i, j)| product[(i, j)] - below[(i, order[j])]);
            let worst = max_norm(errors);
            assert!(worst < 1e-11, "{n} {rows}: {worst:e}");
        }
    }

    #[test]
    fn singular_matrices_and_numbers_that_are_none_are_refused() {
        let mut random = random();
        for n in [1, 2, 5, 64, 100, 200] {
            for at in [0, n / 2, n - 1] {
                let whole = sparse(n, 1.0, &mut random);
                let mut zero = whole.clone();
                zero.row_mut(at).fill(0.0);
                zero.column_mut(at).fill(0.0);
                assert!(matches!(factor(&zero), Err(FactorError::Singular)), "{n} {at}");
                for bad in [f64::NAN, f64::INFINITY] {
                    let mut matrix = whole.clone();
                    matrix[(n - 1, at)] = bad;
                    assert!(matches!(factor(&matrix), Err(FactorError::Singular)), "{n} {at} {bad}");
                }
            }
        }
    }

    #[test]
    fn what_is_above_the_diagonal_is_neither_read_nor_written() {
        let mut random = random();
        let matrix = sparse(150, 0.5, &mut random);
        let mut marked = DMatrix::from_fn(150, 150, |i, j| if i < j { f64::NAN } else { matrix[(i, j)] });
        let mut below = DMatrix::from_fn(7, 150, |i, j| ((i + 3 * j) % 5) as f64);
        BlockPivots::new(marked.as_view_mut(), below.as_view_mut()).unwrap();
        assert!((0..150).all(|j| (0..150).all(|i| marked[(i, j)].is_nan() == (i < j))));
        assert!(below.iter().all(|x| x.is_finite()));
    }
}
