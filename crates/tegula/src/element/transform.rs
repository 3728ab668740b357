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
        // T has one or two entries a row: they are searched for once, not for each block.
        let mut entries = [[(0, 0.0); M]; M];
        let mut counts = [0; M];
        for ((row, entries), count) in t.iter().zip(&mut entries).zip(&mut counts) {
            for (c, &factor) in row.iter().enumerate().filter(|(_, f)| **f != 0.0) {
                entries[*count] = (c, factor);
                *count += 1;
            }
        }
        let row = |a: usize| &entries[a][..counts[a]];
        // K T first, then Tᵀ of it.
        let mut kt = [[[0.0; 9]; M]; M];
        for (a, kt) in kt.iter_mut().enumerate() {
            for b in 0..M {
                let k: [f64; 9] = std::array::from_fn(|i| entry(blocks, a, b, i / 3, i % 3));
                for &(c, factor) in row(b) {
                    kt[c].iter_mut().zip(k).for_each(|(out, k)| *out += factor * k);
                }
            }
        }
        blocks.fill(0.0);
        for (a, kt) in kt.iter().enumerate() {
            for &(c, factor) in row(a) {
                for (d, kt) in kt[..=c].iter().enumerate() {
                    let block = &mut blocks[at(c, d)..at(c, d) + 9];
                    block.iter_mut().zip(kt).for_each(|(out, k)| *out += factor * k);
                }
            }
        }
    }
}
