//! Amplitude check: compares the formulas of loads and motions inside a step with the straight line between their values
//! at its ends.
//!
//! All schemes take loads at the ends of a step or at its midpoint: to second order they resolve the line through the
//! values at its ends. A step is resolved where no formula in use departs from that line by more than a share of its
//! range over the whole analysis. For a sine of circular frequency ω the departure is about (ω Δt)²/16 of the range, so
//! the share scales with the tolerance to the power ⅔, as does the square of the step. Tables need no such check: steps
//! end on their kinks.

use crate::model::TransientAnalysis;
use crate::system::System;

/// Allowed departure over the range at the reference tolerance: sixteen steps to a period of a sine.
const SHARE: f64 = 0.01;
const REFERENCE_TOLERANCE: f64 = 1e-5;
/// Limits of the allowed departure, whatever the tolerance.
const SMALLEST_SHARE: f64 = 1e-6;
const LARGEST_SHARE: f64 = 0.1;
/// Departure in a constant step, over the range, above which the user is warned: five steps to a period of a sine.
const TOLD: f64 = 0.1;
/// Smallest number of samples in a step.
const SAMPLES: usize = 5;
/// Smallest number of samples over the analysis: the check may miss details of a formula shorter than this part of it.
const INSTANTS: f64 = 32_768.0;
/// Number of steps ahead that must be resolved before a step grows, so that its length does not oscillate with the
/// phase of a sine.
const AHEAD: u32 = 8;
/// Part of the analysis below which no step is cut for a formula: the formula jumps there.
const SHORTEST: f64 = 1e-7;

/// Formula in use.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Watched {
    amplitude: usize,
    /// Largest less smallest value over the analysis.
    range: f64,
    told: bool,
}

/// Formula that a step does not resolve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PassedOver {
    /// Amplitude of the formula.
    pub amplitude: usize,
    fixed: bool,
    time: f64,
    dt: f64,
    departure: f64,
}

impl PassedOver {
    /// Message without the name of the amplitude.
    pub fn message(&self) -> String {
        let Self { time, dt, departure, .. } = self;
        format!(
            "departs within the step of {dt:.3e} at {time:.6e} by {:.0} % of its range from the straight line between the \
             ends of the step, which the step does not resolve",
            100.0 * departure
        )
    }

    /// Remedy for the user.
    pub fn help(&self) -> &'static str {
        if self.fixed { "give a shorter `time_step`, or none" } else { "it jumps there" }
    }

    /// Message for the log, with the name of the amplitude.
    pub fn event(&self, system: &System) -> String {
        let name = system.amplitude_name(self.amplitude);
        format!("time {:.6e}: the amplitude \"{name}\" {}: {}", self.time, self.message(), self.help())
    }
}

/// Formulas that constant steps do not resolve, with the first such step of each.
pub fn passed_over(system: &System, options: &TransientAnalysis) -> Vec<PassedOver> {
    let Some(step) = options.time_step else { return Vec::new() };
    let mut check = AmplitudeCheck::new(system, options);
    let steps = options.end_time / step;
    // A very large number of steps is sampled.
    let stride = (steps / INSTANTS).max(1.0) * step;
    let times = (0_u32..).map(|i| f64::from(i) * stride).take_while(|t| *t < options.end_time);
    times.filter_map(|t| check.passed_over(system, t, step)).collect()
}

/// Amplitude check of a run: formulas in use and how closely steps must resolve them.
#[derive(Debug, Clone)]
pub struct AmplitudeCheck {
    watched: Vec<Watched>,
    share: f64,
    fixed: bool,
    end: f64,
}

impl AmplitudeCheck {
    /// Amplitude check for an analysis.
    pub fn new(system: &System, options: &TransientAnalysis) -> Self {
        let end = options.end_time;
        let mut used: Vec<usize> = system.amplitudes_in_use().map(|(i, _)| i).collect();
        used.sort_unstable();
        used.dedup();
        let range = |amplitude: usize| {
            let values = samples(0.0, end, INSTANTS as usize).map(|t| system.amplitudes[amplitude].value(t));
            let (low, high) = values
                .filter(|v| v.is_finite())
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
            high - low
        };
        let formulas = used.into_iter().filter(|&i| system.amplitudes[i].is_formula());
        let watched = formulas.map(|amplitude| Watched { amplitude, range: range(amplitude), told: false });
        let relative = options.tolerance / REFERENCE_TOLERANCE;
        Self {
            watched: watched.filter(|w| w.range > 0.0).collect(),
            share: (SHARE * relative.cbrt().powi(2)).clamp(SMALLEST_SHARE, LARGEST_SHARE),
            fixed: options.time_step.is_some(),
            end,
        }
    }

    /// Length of a step from `time` that resolves all formulas: `wanted` or less. A step is longer than the `last` one
    /// only if several of that length would be resolved.
    pub fn shortened(&self, system: &System, time: f64, wanted: f64, last: f64) -> f64 {
        if self.fixed || self.watched.is_empty() {
            return wanted;
        }
        let resolved = |dt: f64, steps: u32| {
            dt <= SHORTEST * self.end
                || (0..steps).all(|k| {
                    let start = time + f64::from(k) * dt;
                    start >= self.end
                        || self.watched.iter().all(|w| self.departure(system, w, start, dt) <= self.share)
                })
        };
        let mut dt = wanted;
        while !resolved(dt, if dt > last { AHEAD } else { 1 }) {
            // The last length, and with it the factor, is kept where it suffices.
            if last < dt && last > 0.5 * dt && resolved(last, 1) {
                return last;
            }
            dt *= 0.5;
        }
        dt
    }

    /// Formula that the step from `time` of length `dt` does not resolve, because its length is constant or because the
    /// formula jumps; each formula is returned once.
    pub fn passed_over(&mut self, system: &System, time: f64, dt: f64) -> Option<PassedOver> {
        if !self.fixed && dt > SHORTEST * self.end {
            return None;
        }
        let most = if self.fixed { TOLD } else { self.share };
        let found = (0..self.watched.len()).find_map(|i| {
            let w = &self.watched[i];
            let departure = if w.told { 0.0 } else { self.departure(system, w, time, dt) };
            (departure > most).then_some((i, departure))
        });
        let (i, departure) = found?;
        self.watched[i].told = true;
        Some(PassedOver { amplitude: self.watched[i].amplitude, fixed: self.fixed, time, dt, departure })
    }

    /// Largest departure of a formula from the line through its values at the ends of a step, over its range.
    fn departure(&self, system: &System, w: &Watched, time: f64, dt: f64) -> f64 {
        let f = &system.amplitudes[w.amplitude];
        let (first, last) = (f.value(time), f.value((time + dt).min(self.end)));
        let count = SAMPLES.max((INSTANTS * dt / self.end).ceil() as usize);
        let end = (time + dt).min(self.end);
        let off = |t: f64| (f.value(t) - first - (last - first) * (t - time) / (end - time)).abs();
        // Undefined values are refused elsewhere.
        let largest = samples(time, end, count).map(off).filter(|x| x.is_finite()).max_by(f64::total_cmp);
        largest.unwrap_or(0.0) / w.range
    }
}

/// Irregular times within an interval, one in each of `count` equal parts: no period hides between them.
fn samples(from: f64, to: f64, count: usize) -> impl Iterator<Item = f64> {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    (0..count).map(move |i| {
        let offset = (0.5 + GOLDEN * i as f64).fract();
        from + (to - from) * (i as f64 + offset) / count as f64
    })
}
