//! Stability of an equilibrium by divergence: inertia of the symmetric tangent (Sylvester's law, negative pivots), and
//! eigenvalues of the unsymmetric one.

use super::{Constraints, Newton, expand_free};
use crate::analysis::State;
use crate::analysis::circulatory::{CirculatoryLoads, Purpose};
use crate::analysis::modal::KnownModes;
use crate::analysis::potential::scales;
use crate::analysis::solver::TangentSolver;
use crate::analysis::statics::StaticEquation;
use crate::analysis::unstable_modes::UnstableModes;
use crate::element::Nodal;
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
    /// The symmetric part has this number of negative pivots, but no eigenvalue of the tangent has passed through zero: circulatory loads compensate
    /// them, or make pairs of them complex (vibrations).
    Undecided(usize),
}

/// Tangent of which an eigenvector is wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TangentPart {
    /// The symmetric part K; the whole tangent where all loads have a potential.
    Symmetric,
    /// The tangent K + N with the circulatory part N of follower loads.
    Whole,
    /// The transposed tangent K − N, whose eigenvectors are the left ones of K + N.
    Transposed,
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
        if self.circulatory.as_ref().is_none_or(CirculatoryLoads::is_zero) {
            return Ok(Stability::Unstable(negative_pivots));
        }
        let crossings = self.zero_crossings()?;
        // Each crossing changes the number of real negative eigenvalues by one: an odd number is never zero.
        if crossings.is_some_and(|n| (negative_pivots + n) % 2 == 1) {
            return Ok(Stability::Unstable(negative_pivots));
        }
        let nearest = self.eigenvalues_next_to_zero(system, negative_pivots)?;
        // Eigenvalues that have not crossed zero may have become complex pairs, one of which must then be found.
        let left = crossings.is_some_and(|n| n < negative_pivots);
        if nearest.real_negative || (left && !nearest.complex) {
            return Ok(Stability::Unstable(negative_pivots));
        }
        Ok(Stability::Undecided(negative_pivots))
    }

    /// Number of real eigenvalues of the tangent factored last that pass through zero while its circulatory part grows from zero:
    /// [`CirculatoryLoads::zero_crossings`].
    fn zero_crossings(&mut self) -> Result<Option<usize>, String> {
        let mut linear = self.linear_system();
        let Some(loads) = linear.circulatory.take() else { return Ok(Some(0)) };
        let frames = linear.frames;
        loads.zero_crossings(&mut |x| linear.solve_at_rest(x), frames)
    }

    /// Sign of the determinant of the tangent factored last, 1 or −1, in models whose follower loads may make it unsymmetric, and number of eigenvalues
    /// that pass through zero while its circulatory part grows: its symmetric part has the number of negative eigenvalues `negative`. 0 and `None` in other
    /// models, and where they are not found.
    ///
    /// # Errors
    /// The linear solver failed; the text gives the reason.
    pub(super) fn determinant_sign(&mut self, negative: usize) -> Result<(i8, Option<usize>), String> {
        let crossings = match &self.circulatory {
            None => return Ok((0, None)),
            // As at load factor 0.
            Some(loads) if loads.is_zero() => Some(0),
            Some(_) => self.zero_crossings()?,
        };
        let sign = crossings.map_or(0, |n| if (negative + n).is_multiple_of(2) { 1 } else { -1 });
        Ok((sign, crossings))
    }

    /// Eigenvalue next to zero of the tangent factored last, at an equilibrium, in the metric of [`System::norm`], and its eigenvector
    /// of unit norm, by inverse iteration from a fixed start.
    ///
    /// # Errors
    /// The linear solver failed.
    pub fn eigenvalue_next_to_zero(
        &mut self,
        system: &System,
        equation: &StaticEquation,
        (tangent, iterations): (TangentPart, usize),
    ) -> Result<(f64, Vec<Nodal>), String> {
        if let Some(loads) = &mut self.circulatory {
            loads.transpose(tangent == TangentPart::Transposed);
        }
        let purpose = (tangent != TangentPart::Symmetric).then_some(Purpose::Path);
        let found = self.inverse_iteration(system, equation, (purpose, iterations));
        if let Some(loads) = &mut self.circulatory {
            loads.transpose(false);
        }
        found
    }

    /// Eigenvectors of the negative eigenvalues of the symmetric tangent factored last, on the constraints of joints, whose number is given: those of an
    /// earlier equilibrium where they have stayed (true), or new ones (false). `None` where they are not found.
    pub(in crate::analysis) fn unstable_modes(
        &mut self,
        system: &System,
        negative: usize,
        before: Option<&UnstableModes>,
    ) -> Option<(UnstableModes, bool)> {
        let mut linear = self.linear_system();
        let frames = linear.frames;
        let mut solve = |x: &mut [f64]| linear.solve_at_rest(x);
        if let Some(same) = before.and_then(|modes| modes.followed(system, frames, negative, &mut solve)) {
            return Some((same, true));
        }
        Some((UnstableModes::of(system, frames, negative, &mut solve)?, false))
    }

    /// Whether no motion about the equilibrium of the tangent factored last grows, by the known modes of an equilibrium nearby.
    pub(in crate::analysis) fn exclude_growth(
        &mut self,
        system: &System,
        state: &State,
        known: &KnownModes,
    ) -> bool {
        let mut linear = self.linear_system();
        let frames = linear.frames;
        known.exclude_growth(system, state, (frames, &mut |x| linear.solve_at_rest(x)))
    }

    /// Inverse iteration with the whole tangent where it has a `purpose`, else with the symmetric part.
    fn inverse_iteration(
        &mut self,
        system: &System,
        equation: &StaticEquation,
        (purpose, iterations): (Option<Purpose>, usize),
    ) -> Result<(f64, Vec<Nodal>), String> {
        let mut mode = vec![[0.0; 3]; system.vectors()];
        self.solution.iter_mut().zip(noise()).for_each(|(x, start)| *x = start);
        expand_free(&self.frames, &self.solution, false, &mut mode);
        let mut eigenvalue = f64::NAN;
        for _ in 0..iterations {
            let size = system.norm(&mode);
            mode.as_flattened_mut().iter_mut().for_each(|x| *x /= size);
            let before = mode.clone();
            system.apply_metric(&mut mode);
            self.residual.copy_from_slice(&mode);
            self.find_response(system, (equation, equation.time), false, purpose)?;
            mode.copy_from_slice(&self.increment);
            eigenvalue = 1.0 / system.inner_product(&before, &mode);
        }
        let size = system.norm(&mode);
        mode.as_flattened_mut().iter_mut().for_each(|x| *x /= size);
        Ok((eigenvalue, mode))
    }

    /// Eigenvalues next to zero of the tangent of the equilibrium found last, with the circulatory part of follower loads: of `(K + N) x = λ M x` with the mass
    /// matrix, and with D, the metric of [`System::norm`]. An eigenvalue that has passed through zero is real and negative with any such matrix; two that have
    /// met as complex ones, and are real from then on, may be positive with one of them, or complex still.
    ///
    /// Both searches start from the sum of the `negative` unstable modes of K: from noise, the eigenvalues of many soft stable modes would be found before the
    /// negative ones. Where these modes are not found, D alone tells.
    ///
    /// # Errors
    /// The linear solver failed.
    fn eigenvalues_next_to_zero(&mut self, system: &System, negative: usize) -> Result<NextToZero, String> {
        let by_norm = |x: &[Nodal], out: &mut [Nodal]| {
            out.copy_from_slice(x);
            system.apply_metric(out);
        };
        let has_mass = system.total_mass() > 0.0;
        let modes = if has_mass { self.unstable_modes(system, negative, None) } else { None };
        let start = modes.map(|(modes, _)| modes.sum());
        let Some(start) = start.as_deref() else { return self.eigenvalues_over(system, None, by_norm) };
        let by_mass = self.eigenvalues_over(system, Some(start), |x, out| {
            out.fill([0.0; 3]);
            system.pattern.add_mass_product(1.0, x, out);
        })?;
        if by_mass.complex && !by_mass.real_negative {
            return Ok(by_mass);
        }
        let by_norm = self.eigenvalues_over(system, Some(start), by_norm)?;
        Ok(NextToZero {
            real_negative: by_mass.real_negative && by_norm.real_negative,
            complex: by_mass.complex || by_norm.complex,
        })
    }

    /// Eigenvalues next to zero of `(K + N) x = λ B x` with the product B x of a metric: Arnoldi process on `(K + N)⁻¹ B`, in vectors without unit, from a
    /// field or from noise.
    ///
    /// # Errors
    /// The linear solver failed.
    fn eigenvalues_over(
        &mut self,
        system: &System,
        start: Option<&[Nodal]>,
        mut metric: impl FnMut(&[Nodal], &mut [Nodal]),
    ) -> Result<NextToZero, String> {
        let size = system.unknowns();
        let mut arnoldi = Gmres::new(size, (MOST_ENTRIES / size.max(1)).clamp(20, MOST_VECTORS));
        let scales = scales(system, &self.frames);
        let mut first: Vec<f64> = noise().take(size).collect();
        if let Some(field) = start {
            self.frames.components(field, &mut first);
            first.iter_mut().zip(&scales).for_each(|(x, scale)| *x *= scale);
        }
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
        let [mut moved, mut force] = [vec![[0.0; 3]; system.vectors()], vec![[0.0; 3]; system.vectors()]];
        let [mut free, mut right] = [vec![0.0; size], vec![0.0; size]];
        arnoldi.ritz_values(&first, EIGENVALUE_STEPS, &mut looked, |v, out| {
            free.iter_mut().zip(v.iter().zip(&scales)).for_each(|(x, (v, scale))| *x = v / scale);
            expand_free(&self.frames, &free, false, &mut moved);
            metric(&moved, &mut force);
            self.frames.reduce(&force, &mut right);
            let linear = self.linear_system();
            linear.solve(&right, out, Some(Purpose::Eigenvalues), Constraints::constrain)?;
            out.iter_mut().zip(&scales).for_each(|(x, scale)| *x *= scale);
            Ok::<(), String>(())
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
