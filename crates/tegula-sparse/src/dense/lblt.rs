//! LBLᵀ factorisation of a symmetric indefinite matrix with rook pivoting, `P A Pᵀ = L B Lᵀ`.
//!
//! Columns are eliminated in panels. Within a panel, a column is updated when it is considered as a pivot; the columns
//! behind the panel are updated at once by a product. The pivot is the first of these that is found:
//!
//! - a diagonal entry of at least α times the largest entry of its column,
//! - two columns each of which has its largest off-diagonal entry in the other,
//!
//! where the search moves from a column to the row of its largest entry. So the entries of L stay below
//! `1/(1 − α) ≈ 2.78` everywhere.
//!
//! C. Ashcraft, R. G. Grimes, J. G. Lewis, *Accurate symmetric indefinite linear equation solvers*, SIAM J. Matrix Anal.
//! Appl. 20 (1998) 513–561.

use nalgebra::{DMatrix, DMatrixViewMut};
use pulp::Arch;

use super::{Part, Target, piece, piece_mut, subtract_product};
use crate::FactorError;

/// Bunch–Kaufman constant `(1 + √17)/8`, which balances the growth by 1×1 and by 2×2 pivots.
const ALPHA: f64 = 0.640_388_203_202_207_6;

/// Largest number of columns of a panel.
const PANEL: usize = 64;

/// Factor B and permutation of an LBLᵀ factorisation; L has taken the place of the matrix.
pub(crate) struct Lblt {
    /// Diagonal of B.
    pub diagonal: Vec<f64>,
    /// Entries of B below its diagonal; not zero at the first column of a 2×2 pivot.
    pub below: Vec<f64>,
    /// Row of A in each place.
    pub order: Vec<usize>,
}

/// Pivot and, for two columns, the place of the second.
enum Choice {
    Single(usize),
    Pair(usize, usize),
}

/// Factors a symmetric matrix in place, given by its lower triangle. The unit lower triangle of L takes its place below
/// the diagonal, that of B the diagonal.
///
/// # Errors
/// A column vanishes, an entry is not finite, or there is no memory.
pub(crate) fn lblt(a: DMatrixViewMut<'_, f64>) -> Result<Lblt, FactorError> {
    let n = a.nrows();
    let a_view = a.as_view();
    if !(0..n).all(|j| piece(&a_view, j..n, j).iter().all(|x| x.is_finite())) {
        return Err(FactorError::Singular);
    }
    let columns = PANEL.min(n) + 1;
    let mut w = Vec::new();
    w.try_reserve_exact(n * columns).map_err(|_| FactorError::TooLarge)?;
    w.resize(n * columns, 0.0);
    let mut of = Elimination {
        arch: Arch::new(),
        a,
        w: DMatrix::from_vec(n, columns, w),
        start: 0,
        below: vec![0.0; n],
        order: (0..n).collect(),
    };
    let mut k = 0;
    while k < n {
        of.start = k;
        // A 2×2 pivot needs one column more.
        while k < n && (k - of.start + 2 <= PANEL || k == of.start) {
            k = of.eliminate(k).ok_or(FactorError::Singular)?;
        }
        of.update_behind(k);
    }
    let diagonal = (0..n).map(|j| of.a[(j, j)]).collect();
    Ok(Lblt { diagonal, below: of.below, order: of.order })
}

struct Elimination<'a> {
    arch: Arch,
    /// Columns of L, then those that are not yet eliminated, without the updates by the panel.
    a: DMatrixViewMut<'a, f64>,
    /// Columns of the product L B of the panel, then those of the pivot that is considered.
    w: DMatrix<f64>,
    /// First column of the panel.
    start: usize,
    below: Vec<f64>,
    order: Vec<usize>,
}

impl Elimination<'_> {
    /// Eliminates the next one or two columns and returns the number of eliminated columns.
    fn eliminate(&mut self, k: usize) -> Option<usize> {
        let at = k - self.start;
        let n = self.a.nrows();
        match self.choose(k)? {
            Choice::Single(pivot) => {
                self.exchange(k, pivot, at + 1);
                let pivot = self.w[(k, at)];
                let (l, w) = (piece_mut(&mut self.a, k..n, k), &self.w.column(at).data.into_slice()[k..n]);
                l[0] = pivot;
                l[1..].iter_mut().zip(&w[1..]).for_each(|(l, w)| *l = w / pivot);
                Some(k + 1)
            }
            Choice::Pair(first, second) => {
                self.exchange(k, first, at + 2);
                // The column in place k has moved to place `first`.
                self.exchange(k + 1, if second == k { first } else { second }, at + 2);
                let block = [self.w[(k, at)], self.w[(k + 1, at)], self.w[(k + 1, at + 1)]];
                self.below[k] = block[1];
                (self.a[(k, k)], self.a[(k + 1, k)], self.a[(k + 1, k + 1)]) = (block[0], 0.0, block[2]);
                for i in k + 2..n {
                    [self.a[(i, k)], self.a[(i, k + 1)]] =
                        solve_pair(block, [self.w[(i, at)], self.w[(i, at + 1)]]);
                }
                Some(k + 2)
            }
        }
    }

    /// Chooses the next pivot. Its columns, in the present order of the rows, are left in W.
    fn choose(&mut self, k: usize) -> Option<Choice> {
        let at = k - self.start;
        self.updated_column(k, k, at);
        let (mut column, mut partner, mut largest) = (k, k, 0.0);
        loop {
            let own = self.w[(column, at)].abs();
            let (row, size) = self.largest_but(k, column, at);
            if !(own < f64::INFINITY && size < f64::INFINITY) || own + size == 0.0 {
                return None;
            }
            if own >= ALPHA * size {
                return Some(Choice::Single(column));
            }
            // A search that does not find a larger entry has come back to the entry that it comes from.
            if (column != k || partner != k) && (row == partner || size <= largest) {
                self.w.swap_columns(at, at + 1);
                return Some(Choice::Pair(partner, column));
            }
            (partner, largest) = (column, size);
            self.w.swap_columns(at, at + 1);
            self.updated_column(k, row, at);
            column = row;
        }
    }

    /// Puts a column, updated by the columns of the panel before k, into a column of W.
    fn updated_column(&mut self, k: usize, column: usize, to: usize) {
        let (n, panel) = (self.a.nrows(), self.start..k);
        let (before, mut rest) = self.w.columns_range_pair_mut(..to, to..);
        let target = &mut rest.column_mut(0).data.into_slice_mut()[k..n];
        for j in k..column {
            target[j - k] = self.a[(column, j)];
        }
        let a = self.a.as_view();
        target[column - k..].copy_from_slice(piece(&a, column..n, column));
        self.arch.dispatch(|| {
            for (p, j) in panel.enumerate() {
                let factor = before[(column, p)];
                for (x, l) in target.iter_mut().zip(piece(&a, k..n, j)) {
                    *x -= l * factor;
                }
            }
        });
    }

    /// Row and absolute value of the largest entry of a column of W but its diagonal entry; NaN is the largest.
    fn largest_but(&self, k: usize, diagonal: usize, column: usize) -> (usize, f64) {
        let (mut row, mut size) = (k, 0.0_f64);
        for (i, x) in self.w.column(column).iter().enumerate().skip(k) {
            if i != diagonal && (x.abs() > size || x.is_nan()) {
                (row, size) = (i, x.abs());
            }
        }
        (row, size)
    }

    /// Exchanges two rows and columns, i ≤ j, and the rows of the first columns of W.
    fn exchange(&mut self, i: usize, j: usize, columns: usize) {
        if i == j {
            return;
        }
        let n = self.a.nrows();
        let a = &mut self.a;
        (0..i).for_each(|t| a.swap((i, t), (j, t)));
        a.swap((i, i), (j, j));
        (i + 1..j).for_each(|t| a.swap((t, i), (j, t)));
        (j + 1..n).for_each(|t| a.swap((t, i), (t, j)));
        (0..columns).for_each(|t| self.w.swap((i, t), (j, t)));
        self.order.swap(i, j);
    }

    /// Updates the columns behind the panel, whose end is k.
    fn update_behind(&mut self, k: usize) {
        let (n, start) = (self.a.nrows(), self.start);
        let mut below = self.a.rows_mut(k, n - k);
        let (panel, rest) = below.columns_range_pair_mut(start..k, k..);
        let w = self.w.view((k, 0), (n - k, k - start));
        subtract_product(rest, panel.as_view(), w, Part::Lower, Target::Add);
    }
}

/// Solution with a 2×2 pivot, `[[a, b], [b, c]]⁻¹ [x, y]`, divided by b first so that nothing overflows.
#[inline]
pub(crate) fn solve_pair([a, b, c]: [f64; 3], [x, y]: [f64; 2]) -> [f64; 2] {
    let (a, c, x, y) = (a / b, c / b, x / b, y / b);
    let determinant = a * c - 1.0;
    [(c * x - y) / determinant, (a * y - x) / determinant]
}
