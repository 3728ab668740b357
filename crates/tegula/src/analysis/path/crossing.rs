//! Crossings of two paths, told from paths that nearly cross.
//!
//! At a bifurcation with a symmetric mode, a crossing path has an extremum of the load factor λ, `λ = λc + b q²` along the mode q. A small
//! imperfection separates the paths, `λ = λc + b q² − 2 b q₀³/q`: the one with q > 0 comes near and turns to the other side of λc, and the one with
//! q < 0 has its fold at q = −q₀, where λ = λc + 3 b q₀². A step that leaps from one to the other sees the fold as the extremum. But between the
//! distances q₀ and 3 q₀ from there, the path with q > 0 lies beyond its load factor; beside a crossing no equilibrium does.

use crate::norm::larger;

/// Places on either side of an extremum, each nearer to it by a factor than the one before, so that one lies between q₀ and 3 q₀.
const PLACES: i32 = 8;
const NEARER: f64 = 0.4;
/// Part of the difference of the load factor that `b q²` lets expect, and part of the load factor, up to which a difference is an error of the
/// extremum or round-off.
const ERRORS: [f64; 2] = [0.1, 3e-8];

/// Refuses an extremum of the load factor in a step that is the fold of another path. Given are the load factors at the start of the step, at the extremum and at the end
/// of the step, the distances of the extremum and of the end from the start, and the load factor of an equilibrium of the step at a distance from its start.
///
/// # Errors
/// The extremum is a fold, or there is no equilibrium at a distance; the text says so.
pub fn refuse_fold_of_other_path(
    [start, extremum, end]: [f64; 3],
    [at, length]: [f64; 2],
    mut load_at: impl FnMut(f64) -> Result<f64, String>,
) -> Result<(), String> {
    let sides = [(start - extremum, -at), (end - extremum, length - at)];
    for (part, (rise, distance)) in (1..=PLACES).flat_map(|k| sides.map(|side| (NEARER.powi(k), side))) {
        let load = load_at(at + part * distance)?;
        let beyond = (extremum - load) * rise.signum();
        let errors = larger(ERRORS[0] * rise.abs() * part * part, ERRORS[1] * extremum.abs());
        if !(beyond <= errors) {
            return Err("the path turns sharply next to a bifurcation that it does not pass".into());
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A step from q = 1 to q = −0.8 at a supercritical bifurcation at load factor 2.
    fn judge(imperfection: f64) -> Result<(), String> {
        let load = |q: f64| 2.0 + 0.3 * q * q - 0.6 * imperfection.powi(3) / q;
        let fold = load(-imperfection);
        let on_the_path = |a: f64| Ok(load(1.0 - a));
        refuse_fold_of_other_path([load(1.0), fold, load(-0.8)], [1.0 + imperfection, 1.8], on_the_path)
    }

    #[test]
    fn folds_of_paths_that_nearly_cross_are_refused() {
        for imperfection in [0.1, 0.03, 0.01, 3e-3, 1.5e-3] {
            assert!(judge(imperfection).is_err(), "{imperfection}");
        }
        assert!(judge(1e-12).is_ok());
    }

    #[test]
    fn maxima_and_round_off_are_crossings() {
        let load = |a: f64| -1.0 - 0.2 * (a - 0.5).powi(2) * (1.0 + 0.5 * (a - 0.5));
        let round_off = |a: f64| Ok(load(a) + 5e-10 * (1e3 * a).sin());
        let ends = [load(0.0), load(0.5), load(1.2)];
        assert!(refuse_fold_of_other_path(ends, [0.5, 1.2], round_off).is_ok());
        assert!(refuse_fold_of_other_path(ends, [0.5, 1.2], |_| Ok(f64::NAN)).is_err());
        assert!(refuse_fold_of_other_path(ends, [0.5, 1.2], |_| Err("none".into())).is_err());
    }
}
