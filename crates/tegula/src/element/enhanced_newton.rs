//! Newton's method for the enhanced parameters of an element: corrections with a line search, and the factorisation of their equations.

use tegula_sparse::norm::larger;

/// Largest number of enhanced parameters.
pub const MAX_PARAMETERS: usize = 12;
/// Rate at which the energy rises at the end of a correction, over that at which it fell at its start, above which the correction is shortened, and least
/// part of it that is left then.
const OVERSHOOT: f64 = 0.5;
const LEAST_PART: f64 = 0.01;

/// Enhanced parameters of an element.
pub type Parameters = [f64; MAX_PARAMETERS];
/// Matrix of their equations, by rows.
pub type ParameterMatrix = [[f64; MAX_PARAMETERS]; MAX_PARAMETERS];

/// Correction δ of Newton's method for the enhanced parameters, of which a part has been made.
pub struct Correction {
    delta: Parameters,
    /// Rate at which the energy falls at the start of the correction.
    slope: f64,
    part: f64,
}

impl Correction {
    /// Whole correction `α ← α − δ`, along which the energy falls by `δ·r` at its start.
    pub fn whole(delta: Parameters, slope: f64) -> Self {
        Self { delta, slope, part: 1.0 }
    }

    /// Adds a multiple of `δ` to the parameters.
    pub fn add(&self, factor: f64, alpha: &mut Parameters) {
        for (x, d) in alpha.iter_mut().zip(&self.delta) {
            *x += factor * d;
        }
    }

    /// Change of the part of the correction that is made, where the energy rises again at its end, with the residual `r`, by more than half of the rate at
    /// which it fell: the energy has its minimum between both. `None` where the end is as good as a minimum, and where the tangent at the
    /// start was indefinite.
    pub fn shortened(&mut self, r: &Parameters, n: usize) -> Option<f64> {
        let end: f64 = (0..n).map(|i| self.delta[i] * r[i]).sum();
        if !(self.slope > 0.0 && end < -OVERSHOOT * self.slope) {
            return None;
        }
        let part = self.part * larger(self.slope / (self.slope - end), LEAST_PART);
        let change = self.part - part;
        self.part = part;
        Some(change)
    }
}

/// LDLᵀ factorization, in place, of the leading `n × n` part.
pub fn factor(k: &mut ParameterMatrix, n: usize) -> Option<()> {
    for j in 0..n {
        for c in 0..j {
            let l = k[j][c];
            for i in j..n {
                k[i][j] -= k[i][c] * l * k[c][c];
            }
        }
        let pivot = k[j][j];
        if pivot == 0.0 || !pivot.is_finite() {
            return None;
        }
        for row in k.iter_mut().take(n).skip(j + 1) {
            row[j] /= pivot;
        }
    }
    Some(())
}

/// Solution with the factor in place of the right-hand side.
pub fn solve(k: &ParameterMatrix, n: usize, x: &mut Parameters) {
    for i in 0..n {
        for j in 0..i {
            x[i] -= k[i][j] * x[j];
        }
    }
    for i in 0..n {
        x[i] /= k[i][i];
    }
    for i in (0..n).rev() {
        for j in i + 1..n {
            x[i] -= k[j][i] * x[j];
        }
    }
}
