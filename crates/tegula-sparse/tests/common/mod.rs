//! Matrices for the tests of the factorisation.
#![allow(dead_code, missing_docs, clippy::unwrap_used)]

use tegula_sparse::norm::max_norm;
use tegula_sparse::{Factor, FactorError, Inertia, SparseLdlt, SymmetricPattern};

/// Random numbers between -1 and 1 (xorshift), the same on every machine.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    pub fn next(&mut self) -> f64 {
        for shift in [13, -7, 17_i32] {
            self.0 ^= if shift > 0 { self.0 << shift } else { self.0 >> -shift };
        }
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// A symmetric matrix by its lower triangle.
#[derive(Debug, Clone, Default)]
pub struct Matrix {
    pub pointers: Vec<usize>,
    pub rows: Vec<u32>,
    pub values: Vec<f64>,
}

impl Matrix {
    /// From entries (row, column, value) of the lower triangle, in any order; equal places are added.
    pub fn new(n: usize, entries: &[(usize, usize, f64)]) -> Self {
        let mut columns = vec![std::collections::BTreeMap::new(); n];
        for (j, column) in columns.iter_mut().enumerate() {
            column.insert(j, 0.0);
        }
        for &(i, j, v) in entries {
            *columns[i.min(j)].entry(i.max(j)).or_insert(0.0) += v;
        }
        let mut out = Self { pointers: vec![0], ..Self::default() };
        for column in columns {
            for (i, v) in column {
                out.rows.push(i as u32);
                out.values.push(v);
            }
            out.pointers.push(out.rows.len());
        }
        out
    }

    pub fn pattern(&self) -> SymmetricPattern {
        SymmetricPattern::new(self.pointers.clone(), self.rows.clone())
    }

    /// Number of unknowns.
    pub fn size(&self) -> usize {
        self.pointers.len() - 1
    }

    /// All entries as a dense matrix.
    pub fn dense(&self) -> nalgebra::DMatrix<f64> {
        let n = self.pointers.len() - 1;
        let mut dense = nalgebra::DMatrix::zeros(n, n);
        for j in 0..n {
            for k in self.pointers[j]..self.pointers[j + 1] {
                let i = self.rows[k] as usize;
                dense[(i, j)] = self.values[k];
                dense[(j, i)] = self.values[k];
            }
        }
        dense
    }

    /// By a dense solver.
    pub fn eigenvalues(&self) -> nalgebra::DVector<f64> {
        self.dense().symmetric_eigenvalues()
    }

    /// Inertia, and the residual of a solution over what it is made of.
    pub fn solve(&self) -> Result<(Inertia, f64), FactorError> {
        let pattern = self.pattern();
        let mut factor = SparseLdlt::new(&pattern)?;
        let inertia = factor.factor(&self.values)?;
        let n = pattern.size();
        let exact: Vec<f64> = (0..n).map(|i| (1.0 + i as f64).sin()).collect();
        let (mut b, mut size) = (vec![0.0; n], vec![0.0; n]);
        pattern.add_product(&self.values, &exact, &mut b);
        let mut x = b.clone();
        factor.solve(&mut x);
        let minus: Vec<f64> = x.iter().map(|x| -x).collect();
        pattern.add_product(&self.values, &minus, &mut b);
        let absolute: Vec<f64> = self.values.iter().map(|v| v.abs()).collect();
        let positive: Vec<f64> = x.iter().map(|x| x.abs()).collect();
        pattern.add_product(&absolute, &positive, &mut size);
        let worst = b.iter().zip(&size).map(|(r, s)| if *s == 0.0 { r.abs() } else { r / s });
        Ok((inertia, max_norm(worst)))
    }
}

/// Springs along the edges of a grid with several unknowns a node, and a weak spring to the ground at each.
pub fn grid(nx: usize, ny: usize, per_node: usize, ground: f64) -> Matrix {
    let node = |i: usize, j: usize| i * ny + j;
    let mut entries = Vec::new();
    for i in 0..nx {
        for j in 0..ny {
            for a in 0..per_node {
                let p = node(i, j) * per_node + a;
                entries.push((p, p, ground));
                for (k, l) in [(i + 1, j), (i, j + 1), (i + 1, j + 1)] {
                    if k >= nx || l >= ny {
                        continue;
                    }
                    for b in 0..per_node {
                        let q = node(k, l) * per_node + b;
                        let s = 1.0 + 0.3 * ((p * 7 + q * 3) as f64).sin();
                        entries.extend([(p, p, s), (q, q, s), (q, p, -s)]);
                    }
                }
            }
        }
    }
    Matrix::new(nx * ny * per_node, &entries)
}

/// A grid of springs with constraints `Σ c x = 0`, each over a few unknowns at random places.
pub fn constrained(n: usize, constraints: usize, ground: f64, random: &mut Random) -> Matrix {
    let springs = grid(n, n, 3, ground);
    let unknowns = springs.pointers.len() - 1;
    let mut entries = Vec::new();
    for j in 0..unknowns {
        for k in springs.pointers[j]..springs.pointers[j + 1] {
            entries.push((springs.rows[k] as usize, j, springs.values[k]));
        }
    }
    for c in 0..constraints {
        for _ in 0..2 + c % 4 {
            let at = ((0.5 + 0.5 * random.next()) * unknowns as f64) as usize;
            entries.push((unknowns + c, at.min(unknowns - 1), 1.0 + 0.5 * random.next()));
        }
    }
    Matrix::new(unknowns + constraints, &entries)
}
