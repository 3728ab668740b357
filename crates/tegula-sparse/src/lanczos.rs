//! Block Lanczos iteration for the largest eigenvalues of an operator that is symmetric in an inner product.
//!
//! With `A = (K − σM)⁻¹ M` and the inner product of `M` (shift and invert), the largest eigenvalues θ give the
//! eigenvalues `λ = σ + 1/θ` of `Kφ = λMφ` next to the shift. The basis is fully orthogonalised, twice; blocks find
//! multiple eigenvalues (the six rigid modes of a free body) at once. R. G. Grimes, J. G. Lewis, H. D. Simon, *A
//! shifted block Lanczos algorithm for solving sparse symmetric generalized eigenproblems*, SIAM J. Matrix Anal. Appl.
//! 15 (1994) 228–272.

use nalgebra::DMatrix;

/// Operator and inner product of an eigenvalue problem.
pub trait SymmetricOperator {
    /// Number of unknowns.
    fn size(&self) -> usize;
    /// Applies the operator: `out = A x`, given `M x`.
    fn apply(&mut self, m_x: &[f64], out: &mut [f64]);
    /// Applies the matrix of the inner product: `out = M x`.
    fn inner(&self, x: &[f64], out: &mut [f64]);
    /// Projects a vector onto the space that is searched.
    fn project(&self, _x: &mut [f64]) {}
    /// Cancellation flag, asked between applications: after `true`, [`BlockLanczos`] returns at once and cannot be used
    /// any more.
    fn stopped(&self) -> bool {
        false
    }
}

/// Ritz pair: approximate eigenvalue and eigenvector of the operator.
#[derive(Debug, Clone, PartialEq)]
pub struct RitzPair {
    /// Eigenvalue θ of the operator.
    pub value: f64,
    /// Ritz vector, of length 1 in the inner product.
    pub vector: Vec<f64>,
    /// Norm of the residual `A x − θ x` in the inner product, over θ.
    pub residual: f64,
}

/// Growing Krylov space and the projection of the operator onto it.
pub struct BlockLanczos {
    basis: Vec<Vec<f64>>,
    m_basis: Vec<Vec<f64>>,
    /// Projected operator `vᵢᵀ M A vⱼ`, for the columns to which the operator was applied.
    projected: Vec<Vec<f64>>,
    /// Number of vectors in the newest block, to which the operator has not been applied yet.
    newest: usize,
    block: usize,
    /// Component of `A vⱼ` outside the basis, in terms of the newest block.
    coupling: Vec<Vec<f64>>,
    seed: u64,
}

impl BlockLanczos {
    /// Creates a space that starts with a pseudo-random block, identical in every run.
    pub fn new(operator: &mut dyn SymmetricOperator, block: usize) -> Self {
        let mut out = Self {
            basis: Vec::new(),
            m_basis: Vec::new(),
            projected: Vec::new(),
            newest: 0,
            block: block.min(operator.size()),
            coupling: Vec::new(),
            seed: 0x9e37_79b9_7f4a_7c15,
        };
        out.add_random(operator);
        out
    }

    /// Number of basis vectors.
    pub fn len(&self) -> usize {
        self.basis.len()
    }

    /// Whether the basis has no vectors, before the first block.
    pub fn is_empty(&self) -> bool {
        self.basis.is_empty()
    }

    /// Adds a block of random vectors, for eigenvectors that the first block did not contain; returns their number.
    pub fn add_random(&mut self, operator: &mut dyn SymmetricOperator) -> usize {
        let n = operator.size();
        let mut added = 0;
        for _ in 0..self.block {
            if operator.stopped() {
                return 0;
            }
            let x: Vec<f64> = (0..n).map(|_| self.random()).collect();
            let mut m_x = vec![0.0; n];
            let mut y = vec![0.0; n];
            operator.inner(&x, &mut m_x);
            operator.apply(&m_x, &mut y);
            if self.append(operator, y).is_some() {
                added += 1;
            }
        }
        self.newest += added;
        added
    }

    /// Applies the operator to the newest block. Returns the number of new vectors; 0 means that the space is
    /// invariant.
    pub fn expand(&mut self, operator: &mut dyn SymmetricOperator) -> usize {
        let n = operator.size();
        let first = self.basis.len() - self.newest;
        let mut images = Vec::with_capacity(self.newest);
        for j in first..self.basis.len() {
            if operator.stopped() {
                return 0;
            }
            let mut w = vec![0.0; n];
            operator.apply(&self.m_basis[j], &mut w);
            images.push(w);
        }
        let before = self.basis.len();
        self.coupling.clear();
        let mut rest = Vec::with_capacity(images.len());
        for mut w in images {
            if operator.stopped() {
                return 0;
            }
            let mut column = vec![0.0; before];
            for _ in 0..2 {
                for i in 0..before {
                    let c = dot(&self.m_basis[i], &w);
                    column[i] += c;
                    axpy(-c, &self.basis[i], &mut w);
                }
            }
            self.projected.push(column);
            rest.push(w);
        }
        let mut added = 0;
        let copies = rest.clone();
        for w in rest {
            if operator.stopped() {
                return 0;
            }
            if self.append(operator, w).is_some() {
                added += 1;
            }
        }
        for w in &copies {
            self.coupling.push((before..self.basis.len()).map(|i| dot(&self.m_basis[i], w)).collect());
        }
        self.newest = added;
        added
    }

    /// Orthonormalises a vector against the basis and appends it; `None` if the vector lies in the span of the basis.
    fn append(&mut self, operator: &dyn SymmetricOperator, mut w: Vec<f64>) -> Option<()> {
        let mut m_w = vec![0.0; w.len()];
        operator.inner(&w, &mut m_w);
        let before = dot(&w, &m_w).max(0.0).sqrt();
        for _ in 0..2 {
            operator.project(&mut w);
            for i in 0..self.basis.len() {
                let c = dot(&self.m_basis[i], &w);
                axpy(-c, &self.basis[i], &mut w);
            }
        }
        operator.inner(&w, &mut m_w);
        let norm = dot(&w, &m_w).max(0.0).sqrt();
        if !(norm > 1e-12 * before && norm.is_normal()) {
            return None;
        }
        w.iter_mut().for_each(|x| *x /= norm);
        m_w.iter_mut().for_each(|x| *x /= norm);
        self.basis.push(w);
        self.m_basis.push(m_w);
        Some(())
    }

    /// Ritz values, largest first, and the norms of their residuals over the values, without vectors.
    pub fn ritz_values(&self) -> Vec<(f64, f64)> {
        self.decompose().into_iter().map(|(value, residual, _)| (value, residual)).collect()
    }

    /// Ritz pairs of the `count` largest values.
    pub fn ritz_pairs(&self, count: usize) -> Vec<RitzPair> {
        self.decompose()
            .into_iter()
            .take(count)
            .map(|(value, residual, coefficients)| {
                let mut vector = vec![0.0; self.basis[0].len()];
                for (c, v) in coefficients.iter().zip(&self.basis) {
                    axpy(*c, v, &mut vector);
                }
                RitzPair { value, vector, residual }
            })
            .collect()
    }

    fn decompose(&self) -> Vec<(f64, f64, Vec<f64>)> {
        let k = self.projected.len();
        if k == 0 {
            return Vec::new();
        }
        let mut t = DMatrix::<f64>::zeros(k, k);
        for (j, column) in self.projected.iter().enumerate() {
            for i in 0..=j.min(column.len().saturating_sub(1)) {
                t[(i, j)] = column[i];
                t[(j, i)] = column[i];
            }
        }
        let eigen = t.symmetric_eigen();
        let mut order: Vec<usize> = (0..k).collect();
        order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
        let last = k - self.coupling.len();
        order
            .into_iter()
            .map(|i| {
                let y = eigen.eigenvectors.column(i);
                let value = eigen.eigenvalues[i];
                let mut residual = vec![0.0; self.newest];
                for (j, coupling) in self.coupling.iter().enumerate() {
                    axpy(y[last + j], coupling, &mut residual);
                }
                (
                    value,
                    dot(&residual, &residual).sqrt() / value.abs().max(f64::MIN_POSITIVE),
                    y.iter().copied().collect(),
                )
            })
            .collect()
    }

    fn random(&mut self) -> f64 {
        // splitmix64
        self.seed = self.seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.seed;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn axpy(factor: f64, x: &[f64], y: &mut [f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += factor * x;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Diagonal(Vec<f64>);

    impl SymmetricOperator for Diagonal {
        fn size(&self) -> usize {
            self.0.len()
        }
        fn apply(&mut self, m_x: &[f64], out: &mut [f64]) {
            for ((o, x), d) in out.iter_mut().zip(m_x).zip(&self.0) {
                *o = x * d;
            }
        }
        fn inner(&self, x: &[f64], out: &mut [f64]) {
            out.copy_from_slice(x);
        }
    }

    #[test]
    fn finds_multiple_eigenvalues() {
        let mut values = vec![7.0; 6];
        values.extend((1..200).map(|i| 1.0 / f64::from(i)));
        let mut a = Diagonal(values);
        let mut lanczos = BlockLanczos::new(&mut a, 4);
        for _ in 0..20 {
            lanczos.expand(&mut a);
        }
        let pairs = lanczos.ritz_pairs(9);
        for (pair, expected) in pairs.iter().zip([7.0, 7.0, 7.0, 7.0]) {
            approx::assert_relative_eq!(pair.value, expected, epsilon = 1e-12);
        }
        // A block of 4 contains only 4 of the 6 equal eigenvalues; a second random block adds the others.
        lanczos.add_random(&mut a);
        for _ in 0..20 {
            lanczos.expand(&mut a);
        }
        let values: Vec<f64> = lanczos.ritz_values().iter().take(8).map(|v| v.0).collect();
        for (value, expected) in values.iter().zip([7.0, 7.0, 7.0, 7.0, 7.0, 7.0, 1.0, 0.5]) {
            approx::assert_relative_eq!(*value, expected, epsilon = 1e-10);
        }
    }
}
