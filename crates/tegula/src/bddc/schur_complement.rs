//! Dense kernels on the Schur complement `S` of a subdomain's interface: its lower triangle, and the factor of its
//! first rows in single precision.

use nalgebra::DMatrixViewMut;
use tegula_sparse::FactorError;
use tegula_sparse::dense::{Part, PartialCholesky, Target, subtract_product};

/// Number of products that are summed side by side.
const LANES: usize = 8;
/// Number of rows that are processed together.
const ROWS: usize = 4;

#[inline]
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; LANES];
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    for (a, b) in a.iter().zip(b) {
        for k in 0..LANES {
            sums[k] += a[k] * b[k];
        }
    }
    sums.iter().sum::<f64>() + a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum::<f64>()
}

/// Computes `y += a x` and returns `x · z`.
#[inline]
fn add_and_dot(a: f64, x: &[f64], y: &mut [f64], z: &[f64]) -> f64 {
    let mut sums = [0.0; LANES];
    let n = x.len();
    let (y, z) = (&mut y[..n], &z[..n]);
    let (x, x_rest) = x.as_chunks::<LANES>();
    let (y, y_rest) = y.as_chunks_mut::<LANES>();
    let (z, z_rest) = z.as_chunks::<LANES>();
    for ((x, y), z) in x.iter().zip(y).zip(z) {
        for k in 0..LANES {
            y[k] += a * x[k];
            sums[k] += x[k] * z[k];
        }
    }
    let mut rest = 0.0;
    for ((x, y), z) in x_rest.iter().zip(y_rest).zip(z_rest) {
        *y += a * x;
        rest += x * z;
    }
    sums.iter().sum::<f64>() + rest
}

/// Scalar product `a · b` with a row that is rounded to single precision, summed in full precision.
#[inline]
fn dot_rounded(a: &[f32], b: &[f64]) -> f64 {
    let mut sums = [0.0; LANES];
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    for (a, b) in a.iter().zip(b) {
        for k in 0..LANES {
            sums[k] += f64::from(a[k]) * b[k];
        }
    }
    sums.iter().sum::<f64>() + a_rest.iter().zip(b_rest).map(|(a, b)| f64::from(*a) * b).sum::<f64>()
}

/// Error of a factorisation with a pivot that is not positive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct NotPositive;

/// Eliminates the first `width` columns of a matrix, stored by columns in `panel` with `below` rows beneath them:
/// `L₁₁ L₁₁ᵀ = A₁₁`, `L₂₁ = A₂₁ L₁₁⁻ᵀ`. The remaining columns, of which `out` has the lower triangle, are updated to their
/// Schur complement `C − L₂₁ L₂₁ᵀ`.
pub(super) fn eliminate(
    cholesky: &mut PartialCholesky,
    (width, below): (usize, usize),
    panel: &mut [f64],
    out: &mut [f64],
) -> Result<(), NotPositive> {
    let mut panel = DMatrixViewMut::from_slice(panel, width + below, width);
    if !cholesky.factor(panel.as_view_mut()) {
        return Err(NotPositive);
    }
    let second = panel.rows(width, below);
    subtract_product(DMatrixViewMut::from_slice(out, below, below), second, second, Part::Lower, Target::Add);
    Ok(())
}

/// Schur complement `S` of a subdomain whose first rows, the dual ones, are factored: `S_DD = L Lᵀ`, `L_CD = S_CD L⁻ᵀ`.
#[derive(Debug, Default)]
pub(super) struct DenseSchurComplement {
    /// Lower triangle of `S`, by columns.
    matrix: Vec<f64>,
    /// Rows of `L` before the diagonal, then the rows of `L_CD`, rounded to single precision.
    factor: Vec<f32>,
    /// Reciprocals of the diagonal of `L`.
    inverse: Vec<f64>,
    /// Order of `S`.
    size: usize,
}

impl DenseSchurComplement {
    /// Stores the lower triangle of `S` of order `size` (by columns of a square) and that of a copy of which the first
    /// `dual` columns are factored.
    pub fn new(square: &[f64], factor: &[f64], (size, dual): (usize, usize)) -> Result<Self, FactorError> {
        let inverse: Vec<f64> = (0..dual).map(|i| 1.0 / factor[i * size + i]).collect();
        if !inverse.iter().all(|v| v.is_finite()) {
            return Err(FactorError::Singular);
        }
        let mut matrix = Vec::new();
        matrix.try_reserve_exact(size * (size + 1) / 2).map_err(|_| FactorError::TooLarge)?;
        for j in 0..size {
            matrix.extend_from_slice(&square[j * size + j..(j + 1) * size]);
        }
        let count = dual * dual.saturating_sub(1) / 2 + dual * (size - dual);
        let mut rows = Vec::new();
        rows.try_reserve_exact(count).map_err(|_| FactorError::TooLarge)?;
        for j in 0..size {
            rows.extend((0..j.min(dual)).map(|i| factor[i * size + j] as f32));
        }
        Ok(Self { matrix, factor: rows, inverse, size })
    }

    /// Diagonal of `S`.
    pub fn diagonal(&self) -> impl Iterator<Item = f64> + '_ {
        (0..self.size).map(|j| self.matrix[self.column(j)])
    }

    /// Start of a column of `S` in the stored lower triangle.
    fn column(&self, j: usize) -> usize {
        j * (2 * self.size + 1 - j) / 2
    }

    /// Adds the principal submatrix of some unknowns to the lower triangle of `out`, by columns.
    pub fn add_minor(&self, unknowns: &[u32], out: &mut [f64]) {
        let m = unknowns.len();
        for (j, &b) in unknowns.iter().enumerate() {
            for (i, &a) in unknowns.iter().enumerate().skip(j) {
                let (row, column) = (a.max(b) as usize, a.min(b) as usize);
                out[j * m + i] += self.matrix[self.column(column) + row - column];
            }
        }
    }

    /// Matrix–vector product `y = S x`.
    pub fn product(&self, x: &[f64], y: &mut [f64]) {
        y.fill(0.0);
        let mut rest = self.matrix.as_slice();
        for j in 0..self.size {
            let (column, others) = rest.split_at(self.size - j);
            let below = add_and_dot(x[j], &column[1..], &mut y[j + 1..], &x[j + 1..]);
            y[j] += column[0] * x[j] + below;
            rest = others;
        }
    }

    /// Forward substitution in place: `L y = b` for the dual rows, `−L_CD y` for the primal rows.
    pub fn forward(&self, x: &mut [f64]) {
        let dual = self.inverse.len();
        let mut rest = self.factor.as_slice();
        for j in 0..self.size {
            let (row, others) = rest.split_at(j.min(dual));
            let sum = dot_rounded(row, &x[..row.len()]);
            x[j] = if j < dual { (x[j] - sum) * self.inverse[j] } else { -sum };
            rest = others;
        }
    }

    /// Backward substitution in place: `Lᵀ x_D = y − L_CDᵀ x_C`; the primal rows hold `x_C`.
    pub fn backward(&self, x: &mut [f64]) {
        let dual = self.inverse.len();
        let mut end = self.size;
        while end > 0 {
            // Several rows are processed together, so that the entries before them are read and written once.
            let first = end.saturating_sub(ROWS);
            let before = first.min(dual);
            let mut values = [0.0; ROWS];
            let mut rows: [&[f32]; ROWS] = [&[]; ROWS];
            for j in (first..end).rev() {
                if j < dual {
                    x[j] *= self.inverse[j];
                }
                let row = self.row(j);
                for (i, r) in row.iter().enumerate().skip(before) {
                    x[i] -= x[j] * f64::from(*r);
                }
                (values[j - first], rows[j - first]) = (x[j], &row[..before]);
            }
            if end - first == ROWS {
                subtract(values, rows, &mut x[..before]);
            }
            end = first;
        }
    }

    /// Row of `L` before the diagonal, or row of `L_CD`.
    fn row(&self, j: usize) -> &[f32] {
        let dual = self.inverse.len();
        let length = j.min(dual);
        let start = length * length.saturating_sub(1) / 2 + (j - length) * dual;
        &self.factor[start..start + length]
    }
}

/// Update `x −= Σ vₖ rₖ` with several rows.
#[inline]
fn subtract(v: [f64; ROWS], rows: [&[f32]; ROWS], x: &mut [f64]) {
    let n = x.len();
    let [a, b, c, d] = rows.map(|r| &r[..n]);
    for i in 0..n {
        x[i] -=
            v[0] * f64::from(a[i]) + v[1] * f64::from(b[i]) + v[2] * f64::from(c[i]) + v[3] * f64::from(d[i]);
    }
}
