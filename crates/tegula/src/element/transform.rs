//! Linear maps between the nodal vectors of the model and those of an element type.
//!
//! Elements share nodal vectors with a geometric meaning (positions, directors, gradients); an element type may be
//! formulated in others, such as derivatives with respect to its natural coordinates.

use super::group::Nodal;

/// `element vector a = Σ_b T[a][b] · (model vector b)`.
#[derive(Debug, Clone)]
pub struct NodalTransform<const M: usize>(pub Box<[[f64; M]; M]>);

impl<const M: usize> NodalTransform<M> {
    /// `T v`: nodal vectors of the element type from those of the model.
    pub fn apply(&self, v: &[Nodal; M]) -> [Nodal; M] {
        let mut out = [[0.0; 3]; M];
        for (out, row) in out.iter_mut().zip(self.0.iter()) {
            for (v, &t) in v.iter().zip(row).filter(|(_, t)| **t != 0.0) {
                for i in 0..3 {
                    out[i] += t * v[i];
                }
            }
        }
        out
    }

    /// `Tᵀ f`: forces on the nodal vectors of the model.
    pub fn apply_transposed(&self, f: &[Nodal; M]) -> [Nodal; M] {
        let mut out = [[0.0; 3]; M];
        for (f, row) in f.iter().zip(self.0.iter()) {
            for (out, &t) in out.iter_mut().zip(row).filter(|(_, t)| **t != 0.0) {
                for i in 0..3 {
                    out[i] += t * f[i];
                }
            }
        }
        out
    }

    /// `Tᵀ K T` for the lower blocks of a symmetric matrix.
    pub fn apply_to_blocks(&self, blocks: &mut [f64]) {
        let t = &self.0;
        let at = |a: usize, b: usize| 9 * (a * (a + 1) / 2 + b);
        let entry = |k: &[f64], a: usize, b: usize, i: usize, j: usize| {
            if a >= b { k[at(a, b) + 3 * i + j] } else { k[at(b, a) + 3 * j + i] }
        };
        // K T first, then Tᵀ of it; T has one or two entries a row.
        let mut kt = [[[0.0; 9]; M]; M];
        for (a, kt) in kt.iter_mut().enumerate() {
            for (b, row) in t.iter().enumerate() {
                for (c, &factor) in row.iter().enumerate().filter(|(_, f)| **f != 0.0) {
                    for i in 0..3 {
                        for j in 0..3 {
                            kt[c][3 * i + j] += factor * entry(blocks, a, b, i, j);
                        }
                    }
                }
            }
        }
        blocks.fill(0.0);
        for (a, row) in t.iter().enumerate() {
            for (c, &factor) in row.iter().enumerate().filter(|(_, f)| **f != 0.0) {
                for d in 0..=c {
                    for i in 0..9 {
                        blocks[at(c, d) + i] += factor * kt[a][d][i];
                    }
                }
            }
        }
    }
}
