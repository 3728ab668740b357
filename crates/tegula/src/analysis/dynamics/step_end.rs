//! Ends of time steps: on stops, on the grid of a constant step, and at the end of the analysis.

use super::schemes::Instant;
use crate::analysis::stops::Stops;
use crate::model::TransientAnalysis;
use crate::system::{Procedure, System};

/// Tolerance, over a constant step, within which a time counts as a multiple of it: adding a million steps leaves less
/// round-off.
const ON_GRID: f64 = 1e-3;
/// Distance to the next stop over the step up to which the step ends there, and the one above which both are equal but
/// for round-off.
const REACHED: f64 = 1.000_001;
const SAME: f64 = 0.999_999_999;

/// Time step to be taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Span {
    /// Length of the step (time).
    pub dt: f64,
    /// End of the step (time).
    pub end: f64,
}

/// Ends of time steps.
#[derive(Debug, Clone, PartialEq)]
pub struct StepEnds {
    stops: Stops,
    fixed: Option<f64>,
    end: f64,
    /// Time at which the next step ends at the latest.
    limit: f64,
    /// Whether the last two steps to a stop share the remaining time.
    shares: bool,
    /// Whether the scheme takes loads of the step before.
    lags: bool,
}

impl StepEnds {
    /// Ends of the steps of an analysis.
    pub fn new(system: &System, options: &TransientAnalysis) -> Self {
        let end = options.end_time;
        let shares = options.time_step.is_none() && system.procedure != Procedure::Explicit;
        let lags = matches!(options.scheme.instant(system), Instant::Between(_));
        let limit = f64::INFINITY;
        Self {
            stops: Stops::of(system, end, system.jumps_of_acceleration()),
            fixed: options.time_step,
            end,
            limit,
            shares,
            lags,
        }
    }

    /// Shortest distance, of `least` at least, between two breaks of amplitudes or times that are asked for, or from one to either end of the analysis.
    pub fn shortest_gap(&self, least: f64) -> f64 {
        self.stops.shortest_gap(self.end, least)
    }

    /// Limits the next step, which ends at this time at the latest.
    pub fn limit(&mut self, time: f64) {
        self.limit = time;
    }

    /// Whether a step may not go beyond this time.
    pub fn is_limit(&self, time: f64) -> bool {
        time >= self.limit
    }

    /// Step from `time`, at most `wanted` long, after one of length `last`.
    ///
    /// The acceleration of HHT at the end of a step contains α of the load at its start. The next step applies that
    /// over its own length: the impulse is right where both are equally long, as they must be at a break of the load.
    pub fn next(&self, time: f64, wanted: f64, last: f64) -> Span {
        let broken = self.lags && last > 0.0 && self.stops.contains(time);
        let wanted = if broken { wanted.min(last) } else { wanted };
        let target = self.stops.after(time).unwrap_or(self.end).min(self.limit);
        let left = target - time;
        let wanted = self.fixed.map_or(wanted, |fixed| to_grid(time, fixed, wanted));
        if left <= REACHED * wanted {
            // The difference is round-off only: the length, and with it the factor of a linear model, stays.
            let dt = if left >= SAME * wanted { wanted } else { left };
            Span { dt, end: target }
        } else if (self.shares || broken) && left < 2.0 * wanted {
            // The last two steps share the remaining time, so that no tiny step remains.
            Span { dt: 0.5 * left, end: time + 0.5 * left }
        } else {
            Span { dt: wanted, end: time + wanted }
        }
    }
}

/// Length of a step that is at most `wanted` and leads back to a multiple of the constant step, if `time` is none.
fn to_grid(time: f64, fixed: f64, wanted: f64) -> f64 {
    let position = time / fixed;
    if (position - position.round()).abs() <= ON_GRID {
        return wanted;
    }
    let left = position.ceil() * fixed - time;
    if left <= REACHED * wanted {
        left
    } else if left < 2.0 * wanted {
        0.5 * left
    } else {
        wanted
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ends(stops: &[f64], fixed: Option<f64>) -> StepEnds {
        let stops = Stops::at(stops.to_vec(), 1.0);
        StepEnds { stops, fixed, end: 1.0, limit: f64::INFINITY, shares: fixed.is_none(), lags: false }
    }

    /// Ends of all steps of the wanted length.
    fn course(ends: &StepEnds, wanted: f64) -> Vec<f64> {
        let mut times = vec![0.0];
        while times[times.len() - 1] < 1.0 {
            let span = ends.next(times[times.len() - 1], wanted, 0.0);
            assert!(span.dt > 0.0 && (times[times.len() - 1] + span.dt - span.end).abs() < 1e-6 * wanted);
            times.push(span.end);
        }
        times
    }

    #[test]
    fn constant_steps_without_stops_are_sums_of_the_step() {
        let times = course(&ends(&[], Some(0.01)), 0.01);
        let mut sum = 0.0;
        for t in &times[..times.len() - 1] {
            assert_eq!(*t, sum);
            sum += 0.01;
        }
        assert!(times.len() == 101 && times[100] == 1.0);
    }

    #[test]
    fn constant_steps_meet_a_stop_and_return_to_their_grid() {
        let times = course(&ends(&[0.25, 0.33, 0.331], Some(0.1)), 0.1);
        let expected = [0.0, 0.1, 0.2, 0.25, 0.3, 0.33, 0.331, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0];
        assert_eq!(times.len(), expected.len(), "{times:?}");
        assert!(times.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{times:?}");
        assert!([0.25, 0.33, 0.331].iter().all(|t| times.contains(t)), "to the bit: {times:?}");
    }

    #[test]
    fn constant_steps_return_to_their_grid_after_a_cut() {
        let e = ends(&[], Some(0.1));
        let mut time = 0.0;
        for (wanted, end) in
            [(0.05, 0.05), (0.1, 0.1), (0.025, 0.125), (0.05, 0.1625), (0.1, 0.2), (0.1, 0.3)]
        {
            time = e.next(time, wanted, 0.0).end;
            assert!((time - end).abs() < 1e-12, "{time} for {end}");
        }
    }

    #[test]
    fn a_stop_on_the_grid_changes_no_length() {
        let e = ends(&[0.3, 0.7], Some(0.1));
        let mut time = 0.0;
        for _ in 0..10 {
            let span = e.next(time, 0.1, 0.0);
            assert_eq!(span.dt, 0.1);
            time = span.end;
        }
        assert_eq!(time, 1.0);
    }

    #[test]
    fn automatic_steps_share_what_is_left_to_a_stop() {
        let e = ends(&[0.25], None);
        assert_eq!(e.next(0.0, 0.2, 0.0), Span { dt: 0.125, end: 0.125 });
        assert_eq!(e.next(0.0, 0.3, 0.0), Span { dt: 0.25, end: 0.25 });
        assert_eq!(e.next(0.0, 0.1, 0.0), Span { dt: 0.1, end: 0.1 });
    }

    #[test]
    fn a_scheme_that_lags_repeats_the_length_of_a_step_to_a_stop() {
        let e = StepEnds { lags: true, ..ends(&[0.25], None) };
        assert_eq!(e.next(0.25, 0.1, 0.01).dt, 0.01);
        assert_eq!(e.next(0.26, 0.1, 0.01).dt, 0.1);
        assert_eq!(ends(&[0.25], None).next(0.25, 0.1, 0.01).dt, 0.1);
    }
}
