//! Kernels on the dense matrices of the interfaces: one square holds the matrix `S` on and below its diagonal, and above
//! it the transposed factor of its first rows.

use super::super::FactorError;

/// Numbers that are summed side by side.
const LANES: usize = 8;

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

/// `y += a x`.
#[inline]
fn add(a: f64, x: &[f64], y: &mut [f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += a * x;
    }
}

/// `y += a x`, and `x · z`.
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

/// A symmetric matrix `S` whose first rows, the dual ones, are factored: `S_DD = L Lᵀ`, `L_CD = S_CD L⁻ᵀ`.
#[derive(Debug, Default)]
pub(super) struct Interface {
    /// `S` on and below the diagonal; above it `Lᵀ`, and beside that `L_CDᵀ`.
    square: Vec<f64>,
    /// One over the diagonal of `L`.
    inverse: Vec<f64>,
    /// Order of `S`.
    size: usize,
}

impl Interface {
    /// From the lower triangle of `S` (by columns) and that of a copy of which the first `inverse.len()` columns are factored.
    pub fn new(mut square: Vec<f64>, factor: &[f64], dual: usize) -> Result<Self, FactorError> {
        let size = (square.len() as f64).sqrt().round() as usize;
        let inverse: Vec<f64> = (0..dual).map(|i| 1.0 / factor[i * size + i]).collect();
        if !inverse.iter().all(|v| v.is_finite()) {
            return Err(FactorError::Singular);
        }
        // In tiles, since one of the two is walked across its columns.
        const TILE: usize = 16;
        for first in (0..size).step_by(TILE) {
            for top in (0..dual.min(first + TILE)).step_by(TILE) {
                for j in first..(first + TILE).min(size) {
                    for i in top..(top + TILE).min(dual).min(j) {
                        square[j * size + i] = factor[i * size + j];
                    }
                }
            }
        }
        Ok(Self { square, inverse, size })
    }

    /// Diagonal of `S`.
    pub fn diagonal(&self) -> impl Iterator<Item = f64> + '_ {
        (0..self.size).map(|i| self.square[i * self.size + i])
    }

    /// Adds the rows and columns of some unknowns to the lower triangle of `out`, by columns.
    pub fn add_minor(&self, unknowns: &[u32], out: &mut [f64]) {
        let m = unknowns.len();
        for (j, &b) in unknowns.iter().enumerate() {
            for (i, &a) in unknowns.iter().enumerate().skip(j) {
                out[j * m + i] += self.square[(a.min(b) as usize) * self.size + a.max(b) as usize];
            }
        }
    }

    /// Numbers stored.
    pub fn entries(&self) -> usize {
        self.square.len() + self.inverse.len()
    }

    /// `y = S x`.
    pub fn product(&self, x: &[f64], y: &mut [f64]) {
        let n = self.size;
        y.fill(0.0);
        for j in 0..n {
            let column = &self.square[j * n + j..(j + 1) * n];
            let below = add_and_dot(x[j], &column[1..], &mut y[j + 1..], &x[j + 1..]);
            y[j] += column[0] * x[j] + below;
        }
    }

    /// `L y = b` for the dual rows, `−L_CD y` for the others, in place.
    pub fn forward(&self, x: &mut [f64]) {
        let (n, dual) = (self.size, self.inverse.len());
        for j in 0..n {
            let above = j.min(dual);
            let sum = dot(&self.square[j * n..j * n + above], &x[..above]);
            x[j] = if j < dual { (x[j] - sum) * self.inverse[j] } else { -sum };
        }
    }

    /// `Lᵀ x_D = y − L_CDᵀ x_C` in place; the other rows hold `x_C`.
    pub fn backward(&self, x: &mut [f64]) {
        let (n, dual) = (self.size, self.inverse.len());
        for j in (0..n).rev() {
            let above = j.min(dual);
            if j < dual {
                x[j] *= self.inverse[j];
            }
            let (before, rest) = x.split_at_mut(j);
            add(-rest[0], &self.square[j * n..j * n + above], before);
        }
    }
}
