//! Stops: times at which a step ends whatever its length, namely breaks of the amplitudes in use and times that the
//! user requests.

use crate::load::LoadParameter;
use crate::system::System;

/// Smallest distance of two stops over the length of the analysis. Where two points of a table are closer together (a
/// jump), the stop of the second lies this far behind the first; a break closer to the end lies this far before it.
const SMALLEST_GAP: f64 = 1e-9;
/// Distance over the length of the analysis below which two stops differ by round-off only.
const SAME: f64 = 1e-12;
/// Tolerance, over the load step, within which a load factor counts as a multiple of it.
const ON_GRID: f64 = 1e-6;

/// Departure of a formula from a straight line between two stops, over its range, where yielding materials follow loads
/// that grow differently.
const STRAIGHT: f64 = 1e-3;

/// Times (load factors) at which steps end.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Stops {
    times: Vec<f64>,
}

impl Stops {
    /// Stops of an analysis from 0 to `end`: kinks of tables and ramps, in statics also turning points of formulas, the times that
    /// the user requests, and `others`.
    pub fn of(system: &System, end: f64, others: Vec<f64>) -> Self {
        let mut used: Vec<usize> = system.amplitudes_in_use().map(|(i, _)| i).collect();
        used.sort_unstable();
        used.dedup();
        let functions = used.into_iter().filter_map(|i| system.amplitudes.get(i));
        // A sum of loads that grow differently can have its largest value where none of them has one.
        let curved = system.yields() && system.load_factors_differ();
        let breaks = functions.map(|f| {
            let mut breaks = f.kinks();
            if system.parameter() == LoadParameter::LoadFactor {
                // Yielding materials and buckling structures depend on the load history, so load reversals are stops.
                breaks.extend(f.turning_points(0.0, end));
                if curved {
                    breaks.extend(f.nearly_straight(0.0, end, STRAIGHT));
                }
            }
            breaks
        });
        let breaks = breaks
            .chain([others])
            .map(|times| times.into_iter().filter(|&t| t < end).map(|t| before_end(t, end)).collect());
        Self::merged(breaks.chain([system.wanted_times.clone()]), end)
    }

    /// Stops at given times of an analysis from 0 to `end`.
    pub fn at(times: Vec<f64>, end: f64) -> Self {
        Self::merged([times].into_iter(), end)
    }

    /// Merges the lists of several sources.
    fn merged(sources: impl Iterator<Item = Vec<f64>>, end: f64) -> Self {
        let mut all: Vec<f64> = sources.flat_map(|times| spaced(times, end)).collect();
        all.sort_unstable_by(f64::total_cmp);
        all.dedup_by(|b, a| *b - *a <= SAME * end);
        Self { times: spaced(all, end) }
    }

    /// Shortest distance, of `least` at least, between two stops, or from one to either end of an analysis from 0 to `end`.
    pub fn shortest_gap(&self, end: f64, least: f64) -> f64 {
        let ends = self.times.iter().copied().chain([end]);
        let gaps = ends.scan(0.0, |last, time| Some(time - std::mem::replace(last, time)));
        gaps.filter(|gap| *gap >= least).fold(f64::INFINITY, f64::min)
    }

    /// The first stop behind a time.
    pub fn after(&self, time: f64) -> Option<f64> {
        self.times.get(self.times.partition_point(|&t| t <= time)).copied()
    }

    /// True at a stop.
    pub fn contains(&self, time: f64) -> bool {
        self.times.binary_search_by(|t| t.total_cmp(&time)).is_ok()
    }

    /// End of a load step from `time`, at most `wanted` long: the next of `steps` equal parts of the range from 0 to 1,
    /// or a stop before it.
    pub fn load_step_end(&self, time: f64, wanted: f64, steps: u32) -> f64 {
        let target = self.bracket(time, steps).1;
        // A tiny last step would only repeat the one before.
        if time + 1.0001 * wanted >= target { target } else { time + wanted }
    }

    /// Stop or multiple of the load step that a load factor has reached or passed last, and the next one.
    pub fn bracket(&self, time: f64, steps: u32) -> (f64, f64) {
        let parts = f64::from(steps.max(1));
        let passed = (time * parts + ON_GRID).floor();
        let stop = self.times.partition_point(|&t| t <= time);
        let last = stop.checked_sub(1).and_then(|i| self.times.get(i)).copied().unwrap_or(-1.0);
        let next = self.times.get(stop).copied().unwrap_or(1.0);
        ((passed / parts).max(last).min(time), ((passed + 1.0) / parts).min(next).min(1.0))
    }
}

/// A break before the end, moved to a place that a step can tell from it: the load of a jump there acts over the last gap, not
/// over the whole last step.
fn before_end(time: f64, end: f64) -> f64 {
    time.min(end - SMALLEST_GAP * end)
}

/// Sorted times between 0 and `end`, none closer to the one before than the smallest gap: several times within it
/// become one, at its end.
fn spaced(mut times: Vec<f64>, end: f64) -> Vec<f64> {
    let gap = SMALLEST_GAP * end;
    times.retain(|&t| t > 0.0 && t <= end - gap);
    times.sort_unstable_by(f64::total_cmp);
    let mut last = 0.0;
    times.retain_mut(|t| {
        if *t <= last {
            return false;
        }
        *t = t.max(last + gap);
        last = *t;
        true
    });
    times
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stops(sources: &[&[f64]]) -> Stops {
        Stops::merged(sources.iter().map(|s| s.to_vec()), 1.0)
    }

    #[test]
    fn stops_of_several_sources_are_one_list_within_the_analysis() {
        let s = stops(&[&[0.0, 0.3, 1.0, 2.0], &[0.1 + 0.2, 0.7], &[-1.0, 0.5]]);
        assert_eq!(s.times, [0.3, 0.5, 0.7]);
        assert_eq!([0.0, 0.3, 0.6, 0.7].map(|t| s.after(t)), [Some(0.3), Some(0.5), Some(0.7), None]);
    }

    #[test]
    fn a_jump_keeps_two_stops_that_a_step_can_tell_apart() {
        let s = stops(&[&[0.3, 0.3 + 1e-15]]);
        assert_eq!(s.times, [0.3, 0.3 + SMALLEST_GAP]);
        let dense: Vec<f64> = (0..1000).map(|i| 0.3 + 1e-13 * f64::from(i)).collect();
        assert_eq!(stops(&[&dense]).times, [0.3, 0.3 + SMALLEST_GAP]);
        assert_eq!(stops(&[&[1e-12, 1.0 - 1e-12]]).times, [SMALLEST_GAP]);
    }

    #[test]
    fn a_break_just_before_the_end_is_a_stop_of_its_own() {
        for end in [0.5, 1.0, 1000.0] {
            let last = end - SMALLEST_GAP * end;
            assert_eq!(before_end(end * (1.0 - 1e-13), end), last);
            assert_eq!(before_end(0.5 * end, end), 0.5 * end);
            assert_eq!(Stops::at(vec![last], end).times, [last]);
        }
    }

    #[test]
    fn load_steps_below_zero_end_on_multiples_too() {
        let s = stops(&[&[0.25]]);
        assert_eq!(s.bracket(-1.0, 2), (-1.0, -0.5));
        assert_eq!(s.bracket(-0.3, 2), (-0.5, 0.0));
        assert_eq!(s.bracket(-0.3, 1), (-1.0, 0.0));
        assert_eq!(s.bracket(0.0, 1), (0.0, 0.25));
    }

    #[test]
    fn load_steps_end_on_multiples_and_stops_and_return_to_them_after_a_cut() {
        let s = stops(&[&[0.25, 0.5]]);
        assert_eq!(s.load_step_end(0.0, 0.1, 10), 0.1);
        assert_eq!(s.load_step_end(0.2, 0.1, 10), 0.25);
        assert_eq!(s.load_step_end(0.25, 0.1, 10), 0.3);
        // Cut to a quarter, then twice as long after each success.
        let mut ends = vec![0.3];
        for wanted in [0.025, 0.05, 0.1, 0.1] {
            ends.push(s.load_step_end(ends[ends.len() - 1], wanted, 10));
        }
        let expected = [0.3, 0.325, 0.375, 0.4, 0.5];
        assert!(ends.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15), "{ends:?}");
        assert_eq!(s.load_step_end(0.5, 1.0, 1), 1.0);
        assert_eq!(s.bracket(0.27, 10), (0.25, 0.3));
    }

    #[test]
    fn equal_load_steps_are_exact_fractions() {
        for steps in [1, 3, 7, 10, 20, 49, 1000] {
            let (mut time, mut taken) = (0.0, 0);
            while time < 1.0 {
                time = Stops::default().load_step_end(time, 1.0 / f64::from(steps), steps);
                taken += 1;
                assert_eq!(time, f64::from(taken) / f64::from(steps));
            }
            assert_eq!(taken, steps);
        }
    }
}
