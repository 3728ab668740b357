//! Compliance of a mechanism at some of its constraints: their displacements by unit forces that act in the direction of others, where all
//! other constraints hold.
//!
//! With the Schur complement `S = G K⁻¹ Gᵀ` of the last tangent, the constraints A and all others B, it is
//!
//! ```text
//! W = S_AA − S_AB S_BB⁺ S_BA.
//! ```
//!
//! A coordinate that the others lock has the compliance 0.

use super::complete_pivoting::CompletePivoting;
use super::{Constraints, product};

/// Pivot of the scaled S_BB over the largest one, below which constraints of B count as dependent.
const DEPENDENT: f64 = 1e-9;
/// Compliance over that without the other constraints that is round-off: they lock the coordinate.
const LOCKED: f64 = 1e-9;

impl Constraints {
    /// Compliance W, by rows, of coordinates that move without friction at the last tangent.
    pub fn compliance(&mut self, rows: &[usize]) -> Vec<f64> {
        let n = rows.len();
        let mut out = vec![0.0; n * n];
        let mut free = std::mem::take(&mut self.free);
        for (j, &row) in rows.iter().enumerate() {
            let size = free.len();
            free.copy_from_slice(&self.responses[row * size..][..size]);
            self.constrain(&mut free);
            rows.iter().enumerate().for_each(|(i, &row)| out[i * n + j] = product(&self.ends[row], &free));
            let alone = product(&self.ends[row], &self.responses[row * size..][..size]);
            if !(out[j * n + j] > LOCKED * alone) {
                out[j * n + j] = 0.0;
            }
        }
        self.free = free;
        out
    }

    /// Compliance W, by rows, of coordinates that are held at the last tangent.
    pub fn compliance_of_held(&self, rows: &[usize]) -> Vec<f64> {
        let (m, n) = (self.change.len(), rows.len());
        let others: Vec<usize> = (0..m).filter(|row| !rows.contains(row)).collect();
        let entry = |i: usize, j: usize| self.schur.matrix[i * m + j];
        let mut factor = CompletePivoting::new(others.len());
        let of_others: Vec<f64> =
            others.iter().flat_map(|&i| others.iter().map(move |&j| entry(i, j))).collect();
        factor.factor(&of_others);
        factor.decide_rank(DEPENDENT);
        let mut out = vec![0.0; n * n];
        for (j, &column) in rows.iter().enumerate() {
            let mut x: Vec<f64> = others.iter().map(|&i| entry(i, column)).collect();
            factor.solve(&mut x, |_| 0.0);
            for (i, &row) in rows.iter().enumerate() {
                let held: f64 = others.iter().zip(&x).map(|(&k, x)| entry(row, k) * x).sum();
                let compliance = entry(row, column) - held;
                // The matrix is scaled on both sides, to a diagonal of 1.
                let scales = self.schur.scale[row] * self.schur.scale[column];
                out[i * n + j] = if i == j && !(compliance > LOCKED) { 0.0 } else { compliance * scales };
            }
        }
        out
    }
}
