//! Bifurcations that the number of negative eigenvalues does not tell: an eigenvalue becomes negative where another one becomes positive.
//!
//! The eigenvectors of the negative eigenvalues at both ends of a curve span spaces that share as many directions as eigenvalues stay negative.
//! Where they share fewer, the curve is halved until the count differs in between, or the eigenvalues pass through zero at one place.

use super::critical_points::{Curve, Found, bifurcations_between};
use super::state::{CriticalKind, CriticalPoint};
use crate::analysis::unstable_modes::UnstableModes;
use crate::element::Nodal;
use crate::system::System;

/// Part of the curve within which two opposite crossings need not be told apart.
const TOGETHER: f64 = 1e-5;
/// Part of the curve beside that place at which eigenvalues are compared with that at the place, and their ratio up to which it vanishes there.
const BESIDE: f64 = 1e-2;
const VANISHING: f64 = 0.05;
/// Largest number of equilibria in the curve at which modes are looked for.
const MOST_TRIALS: usize = 40;

/// Curve of equilibria with the unstable modes of their tangents.
pub trait CurveWithModes: Curve {
    /// Displacements and load factor at a parameter, negative eigenvalues of the tangent, and their eigenvectors.
    ///
    /// # Errors
    /// There is no equilibrium, its tangent has no factor, or the eigenvectors are not found; the text gives the reason.
    fn unstable(&mut self, a: f64) -> Result<Unstable, String>;
}

/// Equilibrium on a curve with its unstable modes.
pub struct Unstable {
    /// Displacements.
    pub u: Vec<Nodal>,
    /// Load factor.
    pub load: f64,
    /// Negative eigenvalues of the tangent.
    pub negative: usize,
    /// Their eigenvectors.
    pub modes: UnstableModes,
}

/// End of an interval: parameter, negative eigenvalues, and their eigenvectors.
#[derive(Clone)]
pub struct Place {
    /// Parameter of the curve.
    pub a: f64,
    /// Negative eigenvalues.
    pub negative: usize,
    /// Their eigenvectors.
    pub modes: UnstableModes,
}

/// Further bifurcations of a curve between two places, beside the `known` critical points (parameters and changes), which explain the numbers of
/// negative eigenvalues at both. The tangent that is factored afterwards is another one where `curve` was asked.
///
/// # Errors
/// As [`bifurcations_between`].
pub fn opposite_crossings(
    system: &System,
    curve: &mut dyn CurveWithModes,
    ends: [Place; 2],
    known: &[(f64, i32)],
) -> Result<Vec<Found>, String> {
    let (start, length) = (ends[0].negative, ends[1].a);
    let mut found = Vec::new();
    let mut known = known.to_vec();
    let mut open = vec![ends];
    let mut trials = 0;
    while let Some([low, high]) = open.pop() {
        let inside = known.iter().filter(|(a, _)| *a > low.a && *a <= high.a);
        let restored: i32 = inside.map(|(_, change)| (-change).max(0)).sum();
        let stay = low.negative.saturating_sub(restored as usize);
        if low.modes.shared(system, &high.modes) >= stay {
            continue;
        }
        trials += 1;
        if trials > MOST_TRIALS {
            return Err("the modes change along the whole curve".into());
        }
        let a = 0.5 * (low.a + high.a);
        let middle = curve.unstable(a)?;
        if high.a - low.a <= TOGETHER * length {
            if vanishes(curve, a, length)? {
                found.extend(pair(system, a, middle, [&low.modes, &high.modes]));
            }
            continue;
        }
        let explained: i32 = known.iter().filter(|(at, _)| *at < a).map(|(_, change)| change).sum();
        let more = middle.negative as i32 - start as i32 - explained;
        if more != 0 {
            let halves = vec![([low.a, a], [0, more]), ([a, high.a], [more, 0])];
            let told = bifurcations_between(curve, (length, start), halves, &known)?;
            known.extend(told.iter().map(|found| (found.a, found.point.change)));
            found.extend(told);
        }
        // Either half may have opposite crossings of its own.
        let middle = Place { a, negative: middle.negative, modes: middle.modes };
        open.extend([[low, middle.clone()], [middle, high]]);
    }
    Ok(found)
}

/// Whether the eigenvalue next to zero vanishes at a place of a curve. Modes change also where an eigenvalue passes through infinity, as in a dead centre of
/// a mechanism.
///
/// # Errors
/// There is no equilibrium beside the place; the text gives the reason.
fn vanishes(curve: &mut dyn CurveWithModes, a: f64, length: f64) -> Result<bool, String> {
    let beside = [a - BESIDE * length, a + BESIDE * length].map(|at| at.clamp(0.0, length));
    let mut eigenvalue = |at: f64| curve.trial(at).map(|trial| trial.softest.0.abs());
    let (here, before, behind) = (eigenvalue(a)?, eigenvalue(beside[0])?, eigenvalue(beside[1])?);
    Ok(here <= VANISHING * before.min(behind))
}

/// Bifurcations at one place, at which an unstable mode before becomes stable and another one behind unstable.
fn pair(system: &System, a: f64, at: Unstable, [before, behind]: [&UnstableModes; 2]) -> Vec<Found> {
    let modes = [before.farthest_from(system, behind), behind.farthest_from(system, before)];
    let point = |(mode, change): (Option<&[Nodal]>, i32)| {
        let mut mode = mode?.to_vec();
        system.orient(&mut mode);
        let kind = CriticalKind::Bifurcation;
        let point = CriticalPoint { kind, load: at.load, position: 0.0, change, u: at.u.clone(), mode };
        Some(Found { a, point })
    };
    modes.into_iter().zip([-1, 1]).filter_map(point).collect()
}
