//! Steady-state response to harmonic inputs over a range of frequencies.
//!
//! The response of the [reduced model](super::reduced_model) is judged by the forces r that it leaves unbalanced in the whole model:
//! `√(rᴴ A⁻¹ r)` is the error in the energy norm. Where it is too large, `A⁻¹ r` joins the basis, so that the result does not depend
//! on the number of modes. With a `damping_ratio` the damping of motions above the modes is that of residual vectors, and depends a
//! little on their number.

use super::Mode;
use super::problem::go_on;
use super::reduced_model::{ReducedModel, Reduction};
use crate::analysis::Observer;
use crate::model::{FrequencyResponse, Spacing};
use crate::{Error, Result};
use nalgebra::Complex;
use std::f64::consts::TAU;
use tegula_sparse::norm::larger;

/// Largest error of the response in the energy norm, over the response.
const TOLERANCE: f64 = 1e-6;
/// Part of the lowest elastic frequency that is nearly static.
const NEARLY_STATIC: f64 = 1e-2;
/// Frequencies at which the error is looked for while the basis grows.
const SAMPLED: usize = 16;
/// Largest number of times that the basis grows.
const ROUNDS: usize = 40;
/// Part of the highest frequency found at which a range may end: the mode behind the last one may be its twin.
const BELOW: f64 = 0.99;
/// Frequencies on the flanks of a peak, in half-power bandwidths from it.
const FLANKS: [f64; 7] = [-3.0, -1.0, -0.5, 0.0, 0.5, 1.0, 3.0];
/// Amplification of an input by a resonance that counts as infinite: a damping ratio below its inverse is no damping.
const UNBOUNDED: f64 = 1e9;
/// Damping ratio above which a resonance has no peak that could be missed.
const FLAT: f64 = 0.2;

/// Frequencies of a response: those wanted, and those of the peaks between them [1/time].
///
/// # Errors
/// The range ends above the modes, or begins at 0 although the model moves freely.
pub(super) fn frequencies(
    wanted: &FrequencyResponse,
    reduced: &ReducedModel,
    (modes, all): (&[Mode], bool),
) -> Result<Vec<f64>> {
    let highest = modes.iter().map(|mode| mode.frequency_hz).fold(0.0, larger);
    if !all && !(wanted.to <= BELOW * highest) {
        return Err(Error::Singular {
            what: format!(
                "The frequency response is wanted up to {}, and the highest of the {} modes has the frequency {highest:.6e}: the range must \
                 end 1 % below it, or resonances could be missed.",
                wanted.to,
                modes.len()
            ),
            help: "Raise `modes`, or lower the end of the range, `frequency_response.to`.".into(),
        });
    }
    if wanted.from == 0.0 && modes.iter().any(|mode| mode.rigid) {
        return Err(Error::Singular {
            what: "The model moves freely: its response at the frequency 0 has no bound.".into(),
            help: "Begin the range above 0, `frequency_response.from`, or support the model.".into(),
        });
    }
    let last = f64::from(wanted.points - 1);
    let at = |i: u32| {
        let part = f64::from(i) / last;
        match (i, wanted.spacing) {
            (0, _) => wanted.from,
            (i, _) if i + 1 == wanted.points => wanted.to,
            (_, Spacing::Linear) => wanted.from + part * (wanted.to - wanted.from),
            (_, Spacing::Logarithmic) => wanted.from * (wanted.to / wanted.from).powf(part),
        }
    };
    let mut out: Vec<f64> = (0..wanted.points).map(at).collect();
    for (i, mode) in modes.iter().enumerate() {
        let ratio = reduced.damping_ratio(i);
        let has_peak = ratio > 1.0 / UNBOUNDED && ratio < FLAT;
        // The bandwidth between the half-power points is 2ζf.
        let around = FLANKS.map(|flank| mode.frequency_hz * (1.0 + 2.0 * ratio * flank));
        out.extend(around.into_iter().filter(|f| has_peak && *f > wanted.from && *f < wanted.to));
    }
    out.sort_by(f64::total_cmp);
    out.dedup();
    Ok(out)
}

/// Frequency at which the response of a state space is to be right: 0, or far below the elastic modes of a model that moves freely; `None`
/// for a model without elastic modes.
pub(super) fn nearly_static(modes: &[Mode]) -> Option<f64> {
    let lowest = modes.iter().find(|mode| !mode.rigid)?.frequency_hz;
    Some(if modes.iter().any(|mode| mode.rigid) { NEARLY_STATIC * lowest } else { 0.0 })
}

/// Adds vectors to the basis until the response is right at all frequencies.
///
/// # Errors
/// The response at a frequency has no bound, the basis does not suffice, or the observer has asked to stop.
pub(super) fn refine(
    reduction: &mut Reduction,
    frequencies: &[f64],
    observer: &mut dyn Observer,
) -> Result<ReducedModel> {
    let stride = frequencies.len().div_ceil(SAMPLED);
    // From the top, where modes above the range matter most.
    let sampled: Vec<f64> = frequencies.iter().rev().step_by(stride).copied().collect();
    for _ in 0..ROUNDS {
        let worst = worst_errors(reduction, &sampled, &*observer)?;
        let worst = if worst.is_empty() { worst_errors(reduction, frequencies, &*observer)? } else { worst };
        if worst.is_empty() {
            return Ok(reduction.reduced());
        }
        let mut grown = false;
        for direction in worst.into_iter().flat_map(|worst| worst.directions) {
            grown |= reduction.add(direction);
        }
        reduction.diagonalize();
        if !grown {
            break;
        }
    }
    let worst = worst_errors(reduction, frequencies, &*observer)?;
    let Some(worst) = worst.into_iter().max_by(|a, b| a.error.total_cmp(&b.error)) else {
        return Ok(reduction.reduced());
    };
    Err(Error::NotConverged {
        at: format!("the frequency {:.6e}", worst.frequency),
        reason: format!(
            "the response has an error of {:.1e} in the energy norm, above {TOLERANCE:.0e}",
            worst.error
        ),
        help: "Ask for more modes, or for a smaller range of frequencies.".into(),
    })
}

/// Response to an input with the largest error.
struct Worst {
    frequency: f64,
    error: f64,
    /// Real and imaginary part of `A⁻¹ r`.
    directions: [Vec<f64>; 2],
}

/// Of each input the response with the largest error above the tolerance.
fn worst_errors(
    reduction: &mut Reduction,
    frequencies: &[f64],
    observer: &dyn Observer,
) -> Result<Vec<Worst>> {
    let reduced = reduction.reduced();
    let mut out = Vec::new();
    for input in 0..reduced.names.len() {
        let mut worst: Option<Worst> = None;
        for &frequency in frequencies {
            go_on(observer)?;
            let found = error(reduction, &reduced, (frequency, input))?;
            // An error that is not a number counts as the largest.
            if !(found.error <= worst.as_ref().map_or(TOLERANCE, |worst| worst.error)) {
                worst = Some(found);
            }
        }
        out.extend(worst);
    }
    Ok(out)
}

/// Error of the response to an input at a frequency.
fn error(
    reduction: &mut Reduction,
    reduced: &ReducedModel,
    (frequency, input): (f64, usize),
) -> Result<Worst> {
    let omega = TAU * frequency;
    let q = reduced.response(omega, input);
    let bounded = |(j, q): (usize, &Complex<f64>)| {
        q.norm() * larger(omega * omega, reduced.lambdas[j]) <= UNBOUNDED * reduced.input.column(input).amax()
    };
    if !q.iter().enumerate().all(bounded) {
        return Err(Error::Singular {
            what: format!(
                "The response to \"{}\" at the frequency {frequency:.6e} has no bound: it is a resonance without damping.",
                reduced.names[input]
            ),
            help: "Give a `damping_ratio`, or damping of the materials or by dampers.".into(),
        });
    }
    if reduction.is_complete() {
        // What is left of the loads is carried by joints.
        return Ok(Worst { frequency, error: 0.0, directions: [Vec::new(), Vec::new()] });
    }
    let unbalanced = reduction.unbalanced(omega, input, &q);
    let directions = [0, 1].map(|i| reduction.inverse(&unbalanced[i]));
    let square: f64 =
        unbalanced.iter().zip(&directions).flat_map(|(r, e)| r.iter().zip(e)).map(|(r, e)| r * e).sum();
    let energy: f64 =
        q.iter().zip(&reduced.lambdas).map(|(q, lambda)| q.norm_sqr() * (lambda + omega * omega)).sum();
    // Where no force is left, the response is exact.
    let error = if square == 0.0 { 0.0 } else { (larger(square, 0.0) / energy).sqrt() };
    Ok(Worst { frequency, error, directions })
}
