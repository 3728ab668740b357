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

/// Numbers that the processor multiplies together, and to which rows are filled up.
const LANES: usize = 8;

/// Factors of a square matrix, with workspace for its solutions.
#[derive(Debug, Default)]
pub(super) struct CompletePivoting {
    /// Number of rows.
    n: usize,
    /// Length of a row of the factors: n, rounded up to whole vectors of the processor.
    stride: usize,
    /// Factors L and U in the order of the pivots, by rows; of L without the unit diagonal.
    factors: Vec<f64>,
    /// Largest absolute value of each row that remains.
    sizes: Vec<f64>,
    /// Row of the present pivot, with zeros up to the pivot.
    pivot_row: Vec<f64>,
    /// Row and column of the matrix of each pivot.
    rows: Vec<usize>,
    columns: Vec<usize>,
    rank: usize,
    /// `U₁₁⁻¹ U₁₂`, by r rows of n − r entries.
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
        let stride = n.next_multiple_of(LANES);
        Self {
            n,
            stride,
            factors: vec![0.0; n * stride],
            sizes: vec![0.0; n],
            pivot_row: vec![0.0; stride],
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
        let (n, stride) = (self.n, self.stride);
        // The solution of a matrix that is not finite must be none either.
        let finite = matrix.iter().all(|x| x.is_finite());
        for (i, (row, given)) in self.factors.chunks_exact_mut(stride).zip(matrix.chunks(n)).enumerate() {
            row[..n].copy_from_slice(given);
            if !finite {
                row[..n].fill(f64::NAN);
            }
            self.sizes[i] = largest(&row[..n]);
            (self.rows[i], self.columns[i]) = (i, i);
        }
        for k in 0..n {
            let row = place_of_largest(&self.sizes[k..]) + k;
            let column = position(&self.factors[row * stride + k..][..n - k], self.sizes[row]) + k;
            self.swap_rows(k, row);
            self.swap_columns(k, column);
            let (above, below) = self.factors.split_at_mut((k + 1) * stride);
            let pivot = above[k * stride + k];
            if pivot == 0.0 {
                break;
            }
            // Whole vectors, from that of the next column on; zeros leave the columns before it unchanged.
            let start = (k + 1) / LANES * LANES;
            self.pivot_row.copy_from_slice(&above[k * stride..]);
            self.pivot_row[..=k].fill(0.0);
            let pivot_row = &self.pivot_row[start..];
            for (row, size) in below.chunks_exact_mut(stride).zip(&mut self.sizes[k + 1..]) {
                let factor = row[k] / pivot;
                if factor != 0.0 {
                    row[k] = factor;
                    *size = subtract(&mut row[start..], factor, pivot_row, k + 1 - start);
                }
            }
        }
    }

    fn swap_rows(&mut self, a: usize, b: usize) {
        if a != b {
            let (first, second) = self.factors.split_at_mut(b * self.stride);
            first[a * self.stride..][..self.n].swap_with_slice(&mut second[..self.n]);
            self.rows.swap(a, b);
            self.sizes.swap(a, b);
        }
    }

    fn swap_columns(&mut self, a: usize, b: usize) {
        if a != b {
            self.factors.chunks_exact_mut(self.stride).for_each(|row| row.swap(a, b));
            self.columns.swap(a, b);
        }
    }

    /// Counts the pivots above a share `cut` of the first one as the rank, and prepares solutions of minimum norm.
    pub fn decide_rank(&mut self, cut: f64) {
        let pivot = |i: usize| self.factors[i * self.stride + i].abs();
        // Pivots that are no numbers count: the solution then is none either.
        let rank = (0..self.n).take_while(|&i| !(pivot(i) <= cut * pivot(0))).count();
        Arch::new().dispatch(|| self.prepare_null_space(rank));
    }

    #[inline(always)]
    fn prepare_null_space(&mut self, rank: usize) {
        let (n, stride) = (self.n, self.stride);
        self.rank = rank;
        let (r, k) = (self.rank, n - self.rank);
        self.null.clear();
        self.null.resize(r * k, 0.0);
        self.gram.clear();
        self.gram.resize(k * k, 0.0);
        if k == 0 {
            return;
        }
        for i in (0..r).rev() {
            let (before, after) = self.null.split_at_mut((i + 1) * k);
            let (row, u) = (&mut before[i * k..], &self.factors[i * stride..][..n]);
            row.copy_from_slice(&u[r..]);
            for (u, other) in u[i + 1..r].iter().zip(after.chunks_exact(k)) {
                row.iter_mut().zip(other).for_each(|(x, y)| *x -= u * y);
            }
            row.iter_mut().for_each(|x| *x /= u[i]);
            for (a, x) in row.iter().enumerate() {
                self.gram[a * k..][..=a].iter_mut().zip(&*row).for_each(|(sum, y)| *sum += x * y);
            }
        }
        (0..k).for_each(|j| self.gram[j * k + j] += 1.0);
        cholesky(&mut self.gram, k);
    }

    /// Pivot over the first one of the first dependent column, and the coefficients x of this column and those of the pivots for which all
    /// entries of `A x` vanish but that of the pivot: with it left out, a right null vector. `None` at full rank.
    pub fn first_null_vector(&self, x: &mut [f64]) -> Option<f64> {
        let (r, k) = (self.rank, self.n - self.rank);
        x.fill(0.0);
        x[*self.columns.get(r)?] = 1.0;
        for (row, &column) in self.null.chunks_exact(k).zip(&self.columns[..r]) {
            x[column] = -row[0];
        }
        Some(self.factors[r * self.stride + r] / self.factors[0])
    }

    /// Counts the first pivot that is left out, too.
    pub fn admit_next(&mut self) {
        let rank = (self.rank + 1).min(self.n);
        Arch::new().dispatch(|| self.prepare_null_space(rank));
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
        let (stride, r) = (self.stride, self.rank);
        let k = self.n - r;
        for (i, &row) in self.rows[..r].iter().enumerate() {
            let before = dot(&self.factors[i * stride..][..i], &self.work[..i]);
            self.work[i] = b[row] - before;
        }
        back_substitute(&self.factors, stride, &mut self.work[..r]);
        self.work[r..].fill(0.0);
        if k > 0 {
            self.work.iter_mut().zip(&self.columns).for_each(|(x, &column)| *x += old(column));
            let (basic, rest) = self.work.split_at_mut(r);
            self.coefficients.clear();
            self.coefficients.extend_from_slice(rest);
            for (row, x) in self.null.chunks_exact(k).zip(&*basic) {
                self.coefficients.iter_mut().zip(row).for_each(|(c, u)| *c -= u * x);
            }
            solve_cholesky(&self.gram, k, &mut self.coefficients);
            rest.iter_mut().zip(&self.coefficients).for_each(|(x, c)| *x -= c);
            for (row, x) in self.null.chunks_exact(k).zip(basic) {
                *x += dot(row, &self.coefficients);
            }
            self.work.iter_mut().zip(&self.columns).for_each(|(x, &column)| *x -= old(column));
        }
        for (x, &column) in self.work.iter().zip(&self.columns) {
            b[column] = *x;
        }
    }
}

/// Subtracts a multiple of the pivot's row from whole vectors of another row. Returns the largest absolute value of the result behind
/// the first `skip` entries.
#[inline(always)]
fn subtract(row: &mut [f64], factor: f64, pivot_row: &[f64], skip: usize) -> f64 {
    let mut lanes = [0.0; LANES];
    let (chunks, _) = row.as_chunks_mut::<LANES>();
    let (pivots, _) = pivot_row.as_chunks::<LANES>();
    for (at, (x, u)) in chunks.iter_mut().zip(pivots).enumerate() {
        (0..LANES).for_each(|i| x[i] -= factor * u[i]);
        let skipped = if at == 0 { skip } else { 0 };
        (0..LANES).for_each(|i| {
            let value = if i < skipped { 0.0 } else { x[i].abs() };
            lanes[i] = if value > lanes[i] { value } else { lanes[i] };
        });
    }
    lanes.into_iter().fold(0.0, |m, x| if x > m { x } else { m })
}

/// Largest absolute value.
#[inline(always)]
fn largest(row: &[f64]) -> f64 {
    row.iter().fold(0.0, |m, x| if x.abs() > m { x.abs() } else { m })
}

/// Place of the first of the largest values.
#[inline(always)]
fn place_of_largest(sizes: &[f64]) -> usize {
    sizes
        .iter()
        .enumerate()
        .fold((0, -1.0), |(at, most), (i, x)| if *x > most { (i, *x) } else { (at, most) })
        .0
}

/// Place of an absolute value in a row.
fn position(row: &[f64], size: f64) -> usize {
    row.iter().position(|x| x.abs() == size).unwrap_or(0)
}

/// Scalar product, summed in lanes.
#[inline(always)]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    let mut lanes = [0.0; LANES];
    for (a, b) in a.iter().zip(b) {
        (0..LANES).for_each(|i| lanes[i] += a[i] * b[i]);
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    lanes.iter().sum::<f64>() + rest
}

/// Solves `U x = b` in place of b with the leading upper triangle of a matrix whose rows have n entries.
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
    fn null_vectors_belong_to_the_first_dependent_column() {
        let a = matrix(9, 7);
        let mut factors = factored(&a);
        let mut x = vec![0.0; 9];
        for rank in [7, 8] {
            let pivot = factors.first_null_vector(&mut x).unwrap();
            assert!(pivot.abs() < 1e-13);
            let residual = (&a * DVector::from_column_slice(&x)).norm();
            assert!(residual < 1e-12 * a.norm() && factors.dependent().len() == 9 - rank, "{residual}");
            factors.admit_next();
        }
        assert!(factors.first_null_vector(&mut x).is_none());
        // A pivot that is left out keeps its share of the product.
        let nearly = DMatrix::from_diagonal(&DVector::from_vec(vec![4.0, 1e-6, 2.0]));
        factors = CompletePivoting::new(3);
        factors.factor(nearly.as_slice());
        factors.decide_rank(1e-4);
        assert_eq!(factors.first_null_vector(&mut x[..3]), Some(0.25e-6));
        assert_eq!(x[..3], [0.0, 1.0, 0.0]);
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
