//! Stability of an equilibrium by divergence: inertia of the symmetric tangent (Sylvester's law, negative pivots), and
//! eigenvalues of the unsymmetric one.

use super::{Newton, expand_free};
use crate::analysis::circulatory::Purpose;
use crate::analysis::solver::TangentSolver;
use crate::system::System;
use tegula_sparse::gmres::{Gmres, noise};

/// Arnoldi steps between two checks of the Ritz values.
const EIGENVALUE_STEPS: usize = 10;
/// Relative change from check to check up to which a real negative Ritz value counts as an eigenvalue: those of an
/// unconverged process come and go.
const SETTLED: f64 = 1e-3;
/// Number of consecutive checks without a real negative Ritz value after which there is no such eigenvalue.
const LOOKS_WITHOUT: usize = 2;
/// Imaginary part over the real one up to which an eigenvalue counts as real, and its modulus over the largest one
/// above which it is more than noise.
const REAL: f64 = 1e-3;
const NOISE: f64 = 1e-6;
/// Largest number of Krylov vectors, and of their entries (160 MB).
const MOST_VECTORS: usize = 80;
const MOST_ENTRIES: usize = 20_000_000;

/// Stability of an equilibrium by divergence, from negative pivots and circulatory loads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stability {
    /// Neither the tangent nor its symmetric part has a negative eigenvalue.
    Stable,
    /// The tangent has a negative eigenvalue, shown by this number of negative pivots of the symmetric part.
    Unstable(usize),
    /// The symmetric part has this number of negative pivots, but the tangent has no real negative eigenvalue:
    /// circulatory loads compensate them, or make pairs of them complex (vibrations).
    Undecided(usize),
}

/// Eigenvalues of an unsymmetric tangent next to zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct NextToZero {
    /// Whether one is real and negative: its motion grows without vibrating (divergence).
    real_negative: bool,
    /// Whether there are complex pairs.
    complex: bool,
}

impl<S: TangentSolver> Newton<S> {
    /// Stability by divergence of the equilibrium found last, from the negative pivots of its symmetric tangent and the
    /// circulatory part of follower loads. Valid only until another tangent is computed.
    ///
    /// # Errors
    /// The linear solver failed; the text gives the reason.
    pub fn stability(&mut self, system: &System, negative_pivots: usize) -> Result<Stability, String> {
        if negative_pivots == 0 {
            // xᵀ(K + N) x = xᵀ K x > 0: no eigenvalue has a negative real part.
            return Ok(Stability::Stable);
        }
        let Self { circulatory, solver, frames, .. } = self;
        let Some(loads) = circulatory.as_mut().filter(|loads| !loads.is_zero()) else {
            return Ok(Stability::Unstable(negative_pivots));
        };
        let crossings = loads.zero_crossings(solver, frames)?;
        // Each crossing changes the number of real negative eigenvalues by one: an odd number is never zero.
        if crossings.is_some_and(|n| (negative_pivots + n) % 2 == 1) {
            return Ok(Stability::Unstable(negative_pivots));
        }
        let nearest = self.eigenvalues_next_to_zero(system)?;
        // Eigenvalues that have not crossed zero may have become complex pairs, one of which must then be found.
        let left = crossings.is_some_and(|n| n < negative_pivots);
        if nearest.real_negative || (left && !nearest.complex) {
            return Ok(Stability::Unstable(negative_pivots));
        }
        Ok(Stability::Undecided(negative_pivots))
    }

    /// Eigenvalues next to zero of the tangent of the equilibrium found last, with the circulatory part of follower
    /// loads: Arnoldi process on `(K + N)⁻¹ D`, D the metric of [`System::norm`].
    ///
    /// # Errors
    /// The linear solver failed.
    fn eigenvalues_next_to_zero(&mut self, system: &System) -> Result<NextToZero, String> {
        let size = system.unknowns();
        let mut arnoldi = Gmres::new(size, (MOST_ENTRIES / size.max(1)).clamp(20, MOST_VECTORS));
        let start: Vec<f64> = noise().take(size).collect();
        let (mut last, mut without): (Vec<f64>, usize) = (Vec::new(), 0);
        let mut found = NextToZero { real_negative: false, complex: false };
        let mut looked = |values: &[[f64; 2]], exact: bool| {
            let (now, complex) = negative_and_complex(values);
            let settled = |a: &f64| exact || last.iter().any(|b| (a - b).abs() <= SETTLED * a.abs());
            found = NextToZero { real_negative: now.iter().any(settled), complex };
            without = if now.is_empty() { without + 1 } else { 0 };
            last = now;
            found.real_negative || without == LOOKS_WITHOUT
        };
        let Self { solver, frames, circulatory, increment, .. } = self;
        arnoldi.ritz_values(&start, EIGENVALUE_STEPS, &mut looked, |v, out| {
            expand_free(frames, v, false, increment);
            system.apply_metric(increment);
            frames.reduce(increment, out);
            solver.solve_tangent(out)?;
            match circulatory {
                Some(loads) => loads.correct(solver, frames, out, Purpose::Eigenvalues),
                None => Ok(()),
            }
        })?;
        Ok(found)
    }
}

/// Real negative eigenvalues in ascending order, and whether there are complex ones.
fn negative_and_complex(values: &[[f64; 2]]) -> (Vec<f64>, bool) {
    let largest = values.iter().map(|[re, im]| re.hypot(*im)).reduce(f64::max).unwrap_or(0.0);
    let counts = |[re, im]: &&[f64; 2]| re.hypot(*im) > NOISE * largest;
    let (real, complex): (Vec<&[f64; 2]>, Vec<_>) =
        values.iter().filter(counts).partition(|[re, im]| im.abs() <= REAL * re.abs());
    let mut negative: Vec<f64> = real.into_iter().map(|[re, _]| *re).filter(|re| *re < 0.0).collect();
    negative.sort_by(f64::total_cmp);
    (negative, !complex.is_empty())
}
