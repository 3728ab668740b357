//! Gaussian elimination with complete pivoting of a small dense matrix whose rank may fall, and solutions of minimum norm.
//!
//! With the factors `P A Q = L U` (G. Golub, C. Van Loan, *Matrix computations*, Sect. 3.4.8) the rank r is the number of pivots
//! above a share of the first one. The equations of the first r rows in the order of the pivots are solved; those of the others
//! depend on them, or are left out. Of all solutions `x = x₀ + N c`, with the null space
//!
//! ```text
//! N = Q [ −U₁₁⁻¹ U₁₂ ]
//!       [      1     ],
//! ```
//!
//! the one of minimum norm has `c = −(Nᵀ N)⁻¹ Nᵀ x₀` (Sect. 5.5).

use pulp::Arch;

/// Factors of a square matrix, with workspace for its solutions.
#[derive(Debug, Default)]
pub(super) struct CompletePivoting {
    /// Number of rows.
    n: usize,
    /// Factors L and U in the order of the pivots, by rows; of L without the unit diagonal.
    factors: Vec<f64>,
    /// Row and column of the matrix of each pivot.
    rows: Vec<usize>,
    columns: Vec<usize>,
    rank: usize,
    /// `U₁₁⁻¹ U₁₂`, by columns of length r.
    null: Vec<f64>,
    /// Cholesky factor of `Nᵀ N`, by rows.
    gram: Vec<f64>,
    /// Right side and solution in the order of the pivots.
    work: Vec<f64>,
    /// Coefficients c of the null space.
    coefficients: Vec<f64>,
}

impl CompletePivoting {
    /// Memory for matrices of n rows.
    pub fn new(n: usize) -> Self {
        Self {
            n,
            factors: vec![0.0; n * n],
            rows: (0..n).collect(),
            columns: (0..n).collect(),
            rank: n,
            // The largest of r (n − r) and of (n − r)² for all ranks.
            null: Vec::with_capacity(n * n / 4 + 1),
            gram: Vec::with_capacity(n * n),
            work: vec![0.0; n],
            coefficients: Vec::with_capacity(n),
        }
    }

    /// Factors a matrix, given by rows. Its rank is decided by [`decide_rank`](Self::decide_rank).
    pub fn factor(&mut self, matrix: &[f64]) {
        Arch::new().dispatch(|| self.eliminate(matrix));
    }

    #[inline(always)]
    fn eliminate(&mut self, matrix: &[f64]) {
        let n = self.n;
        self.factors.copy_from_slice(matrix);
        if !matrix.iter().all(|x| x.is_finite()) {
            // Pivots could not be compared: the solution must be none either.
            self.factors.fill(f64::NAN);
        }
        for (i, (row, column)) in self.rows.iter_mut().zip(&mut self.columns).enumerate() {
            (*row, *column) = (i, i);
        }
        for k in 0..n {
            let (i, j) = self.largest(k);
            self.swap_rows(k, i);
            self.swap_columns(k, j);
            let (above, below) = self.factors.split_at_mut((k + 1) * n);
            let pivot_row = &above[k * n + k..];
            let pivot = pivot_row[0];
            if pivot == 0.0 {
                break;
            }
            for row in below.chunks_exact_mut(n) {
                let factor = row[k] / pivot;
                row[k] = factor;
                if factor != 0.0 {
                    row[k + 1..].iter_mut().zip(&pivot_row[1..]).for_each(|(x, u)| *x -= factor * u);
                }
            }
        }
    }

    /// Place of the largest entry of the matrix that remains at pivot k.
    #[inline(always)]
    fn largest(&self, k: usize) -> (usize, usize) {
        let (n, mut found, mut size) = (self.n, (k, k), -1.0);
        for i in k..n {
            let row = &self.factors[i * n + k..(i + 1) * n];
            let of_row = largest(row);
            if of_row > size {
                let place = row.iter().position(|x| x.abs() == of_row).unwrap_or(0);
                (found, size) = ((i, k + place), of_row);
            }
        }
        found
    }

    fn swap_rows(&mut self, a: usize, b: usize) {
        if a != b {
            let n = self.n;
            let (first, second) = self.factors.split_at_mut(b * n);
            first[a * n..(a + 1) * n].swap_with_slice(&mut second[..n]);
            self.rows.swap(a, b);
        }
    }

    fn swap_columns(&mut self, a: usize, b: usize) {
        if a != b {
            self.factors.chunks_exact_mut(self.n).for_each(|row| row.swap(a, b));
            self.columns.swap(a, b);
        }
    }

    /// Counts the pivots above a share `cut` of the first one as the rank, and prepares solutions of minimum norm.
    pub fn decide_rank(&mut self, cut: f64) {
        let n = self.n;
        let pivot = |i: usize| self.factors[i * n + i].abs();
        // Pivots that are no numbers count: the solution then is none either.
        self.rank = (0..n).take_while(|&i| !(pivot(i) <= cut * pivot(0))).count();
        let (r, k) = (self.rank, n - self.rank);
        self.null.clear();
        for j in r..n {
            let start = self.null.len();
            self.null.extend((0..r).map(|i| self.factors[i * n + j]));
            back_substitute(&self.factors, n, &mut self.null[start..]);
        }
        self.gram.clear();
        self.gram.resize(k * k, 0.0);
        for i in 0..k {
            for j in 0..=i {
                let (a, b) = (&self.null[i * r..(i + 1) * r], &self.null[j * r..(j + 1) * r]);
                let unit = if i == j { 1.0 } else { 0.0 };
                self.gram[i * k + j] = unit + dot(a, b);
            }
        }
        cholesky(&mut self.gram, k);
    }

    /// Numbers of the rows that do not depend on others.
    pub fn independent(&self) -> &[usize] {
        &self.rows[..self.rank]
    }

    /// Numbers of the rows that depend on the others.
    pub fn dependent(&self) -> &[usize] {
        &self.rows[self.rank..]
    }

    /// Solves `A x = b` in place of b. Where the rank falls, `x + old` has minimum norm.
    pub fn solve(&mut self, b: &mut [f64], old: impl Fn(usize) -> f64) {
        let (n, r) = (self.n, self.rank);
        let k = n - r;
        for (i, &row) in self.rows[..r].iter().enumerate() {
            let before = dot(&self.factors[i * n..i * n + i], &self.work[..i]);
            self.work[i] = b[row] - before;
        }
        back_substitute(&self.factors, n, &mut self.work[..r]);
        self.work[r..].fill(0.0);
        if k > 0 {
            self.work.iter_mut().zip(&self.columns).for_each(|(x, &column)| *x += old(column));
            let (basic, rest) = self.work.split_at_mut(r);
            let columns = |j: usize| &self.null[j * r..(j + 1) * r];
            self.coefficients.clear();
            self.coefficients.extend(rest.iter().enumerate().map(|(j, x)| x - dot(columns(j), basic)));
            solve_cholesky(&self.gram, k, &mut self.coefficients);
            for (j, (x, c)) in rest.iter_mut().zip(&self.coefficients).enumerate() {
                *x -= c;
                basic.iter_mut().zip(columns(j)).for_each(|(x, u)| *x += c * u);
            }
            self.work.iter_mut().zip(&self.columns).for_each(|(x, &column)| *x -= old(column));
        }
        for (x, &column) in self.work.iter().zip(&self.columns) {
            b[column] = *x;
        }
    }
}

/// Largest absolute value: of eight lanes, which vectorizes.
#[inline(always)]
fn largest(row: &[f64]) -> f64 {
    let (chunks, rest) = row.as_chunks::<8>();
    let mut lanes = [0.0; 8];
    for chunk in chunks {
        lanes.iter_mut().zip(chunk).for_each(|(m, x)| *m = if x.abs() > *m { x.abs() } else { *m });
    }
    lanes.iter().chain(rest).fold(0.0, |m, x| if x.abs() > m { x.abs() } else { m })
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Solves `U x = b` in place of b with the leading upper triangle of a matrix of n columns, by rows.
fn back_substitute(u: &[f64], n: usize, x: &mut [f64]) {
    for i in (0..x.len()).rev() {
        let row = &u[i * n..];
        let after = dot(&row[i + 1..x.len()], &x[i + 1..]);
        x[i] = (x[i] - after) / row[i];
    }
}

/// Cholesky factor in place of the lower triangle of a matrix of k rows.
fn cholesky(a: &mut [f64], k: usize) {
    for i in 0..k {
        for j in 0..=i {
            let rest = a[i * k + j] - dot(&a[i * k..i * k + j], &a[j * k..j * k + j]);
            a[i * k + j] = if i == j { rest.sqrt() } else { rest / a[j * k + j] };
        }
    }
}

/// Solves with a Cholesky factor in place of x.
fn solve_cholesky(l: &[f64], k: usize, x: &mut [f64]) {
    for i in 0..k {
        let before = dot(&l[i * k..i * k + i], &x[..i]);
        x[i] = (x[i] - before) / l[i * k + i];
    }
    for i in (0..k).rev() {
        let after: f64 = (i + 1..k).map(|j| l[j * k + i] * x[j]).sum();
        x[i] = (x[i] - after) / l[i * k + i];
    }
}

#[cfg(test)]
mod tests {
    use super::CompletePivoting;
    use nalgebra::{DMatrix, DVector};

    /// A matrix of n rows and the given rank with rows and columns of unlike size.
    fn matrix(n: usize, rank: usize) -> DMatrix<f64> {
        let entry = |i: usize, j: usize, s: f64| (1.3 * ((i + 1) * (j + 2)) as f64 + s).sin();
        DMatrix::from_fn(n, rank, |i, j| entry(i, j, 0.1))
            * DMatrix::from_fn(rank, n, |i, j| entry(j, i, 0.7))
    }

    fn factored(a: &DMatrix<f64>) -> CompletePivoting {
        let mut factors = CompletePivoting::new(a.nrows());
        factors.factor(a.transpose().as_slice());
        factors.decide_rank(1e-9);
        factors
    }

    #[test]
    fn solutions_of_every_rank_are_those_of_the_pseudoinverse() {
        for (n, rank) in [(1, 1), (1, 0), (5, 5), (9, 7), (9, 1), (30, 24)] {
            let a = matrix(n, rank);
            let mut factors = factored(&a);
            assert_eq!(factors.dependent().len(), n - rank);
            let (x, old) =
                (DVector::from_fn(n, |i, _| (i as f64).cos()), DVector::from_fn(n, |i, _| 0.3 * i as f64));
            let mut solution = (&a * &x).as_slice().to_vec();
            factors.solve(&mut solution, |i| old[i]);
            let inverse = a.clone().pseudo_inverse(1e-9 * a.norm()).unwrap();
            let expected = &inverse * &a * (&x + &old) - &old;
            let difference = (DVector::from_vec(solution) - &expected).norm();
            assert!(difference <= 1e-9 * (1.0 + expected.norm()), "{n} {rank}: {difference}");
        }
    }

    #[test]
    fn a_matrix_that_is_not_finite_has_no_solution() {
        let mut a = matrix(4, 4);
        a[(2, 1)] = f64::NAN;
        let mut solution = vec![1.0; 4];
        factored(&a).solve(&mut solution, |_| 0.0);
        assert!(solution.iter().any(|x| x.is_nan()));
    }
}
