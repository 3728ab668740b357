//! Break points of amplitudes: kinks of tables, turning points (local extrema) of formulas.

use super::TimeFunction;

/// Distance from a straight line, relative to the range of the values, below which points of a table lie on it.
const ROUND_OFF: f64 = 1e-12;
/// Change of value between two turning points, relative to the range of the values, below which it is noise.
const NOISE: f64 = 1e-9;
/// Number of intervals in which the rate of a formula is checked for a change of sign.
const INTERVALS: u32 = 4096;
/// Bisection steps that locate a change of sign to the last bit.
/// Intervals that are not halved any more.
const SHORTEST: u32 = 8;
const HALVINGS: u32 = 60;

impl TimeFunction {
    /// Times at which the slope of a table or ramp changes by more than round-off; none for formulas, which are smooth.
    pub fn kinks(&self) -> Vec<f64> {
        match self {
            Self::Table(points) => corners(points),
            Self::Constant(_) | Self::Spline(_) | Self::Formula(_) | Self::Signal(_) => Vec::new(),
        }
    }

    /// Times of the local extrema of a formula between `from` and `to`; empty for tables, whose extrema are kinks.
    pub fn turning_points(&self, from: f64, to: f64) -> Vec<f64> {
        if !self.is_formula() {
            return Vec::new();
        }
        let at = |i: u32| from + (to - from) * f64::from(i) / f64::from(INTERVALS);
        let mut found = Vec::new();
        // Last time at which the rate was not zero, and the rate there.
        let mut before: Option<(f64, f64)> = None;
        for t in (0..=INTERVALS).map(at) {
            let rate = self.rate(t);
            if rate == 0.0 || !rate.is_finite() {
                continue;
            }
            if let Some((earlier, old)) = before
                && old.signum() != rate.signum()
            {
                found.push(self.change_of_sign(earlier, t, old.signum()));
            }
            before = Some((t, rate));
        }
        let values = (0..=INTERVALS).map(|i| self.value(at(i))).filter(|v| v.is_finite());
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        let mut last = self.value(from);
        found.retain(|&t| {
            let value = self.value(t);
            let turns = (value - last).abs() > NOISE * (high - low);
            if turns {
                last = value;
            }
            turns
        });
        found
    }

    /// Times between two of which the function departs from a straight line by at most a share of its range: interval
    /// after interval is halved.
    pub fn nearly_straight(&self, from: f64, to: f64, share: f64) -> Vec<f64> {
        if !self.is_formula() {
            return Vec::new();
        }
        let at = |i: u32| from + (to - from) * f64::from(i) / f64::from(INTERVALS);
        let values = (0..=INTERVALS).map(|i| self.value(at(i))).filter(|v| v.is_finite());
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        let straight = |a: u32, b: u32| {
            let slope = (self.value(at(b)) - self.value(at(a))) / f64::from(b - a);
            let off = |i: u32| (self.value(at(i)) - self.value(at(a)) - slope * f64::from(i - a)).abs();
            (a..=b).map(off).fold(0.0, crate::norm::larger) <= share * (high - low)
        };
        let mut found = Vec::new();
        let mut open = vec![(0, INTERVALS)];
        while let Some((a, b)) = open.pop() {
            if b - a > SHORTEST && !straight(a, b) {
                let middle = (a + b) / 2;
                found.push(at(middle));
                open.extend([(a, middle), (middle, b)]);
            }
        }
        found
    }

    /// Bisection for the time at which the rate, of the sign `sign` at `low`, changes its sign before `high`.
    fn change_of_sign(&self, mut low: f64, mut high: f64, sign: f64) -> f64 {
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if self.rate(middle) * sign > 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    }
}

/// Times of the corners of a polyline that is constant before and after, and straight between corners up to round-off:
/// a point is skipped while the line from the last corner to the next point passes all points between at that distance.
fn corners(points: &[(f64, f64)]) -> Vec<f64> {
    let (Some(first), Some(last)) = (points.first(), points.last()) else { return Vec::new() };
    let (low, high) =
        points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p.1), h.max(p.1)));
    let (tolerance, span) = (ROUND_OFF * (high - low), last.0 - first.0);
    let mut out = Vec::new();
    let mut corner = (first.0 - span, first.1);
    let mut before = corner;
    let (mut least, mut most) = (f64::NEG_INFINITY, f64::INFINITY);
    for &p in points.iter().chain(&[(last.0 + span, last.1)]) {
        if p.0 <= before.0 {
            continue;
        }
        let slope = (p.1 - corner.1) / (p.0 - corner.0);
        if !(least..=most).contains(&slope) {
            out.push(before.0);
            corner = before;
            (least, most) = (f64::NEG_INFINITY, f64::INFINITY);
        }
        let run = p.0 - corner.0;
        least = least.max((p.1 - tolerance - corner.1) / run);
        most = most.min((p.1 + tolerance - corner.1) / run);
        before = p;
    }
    out
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::model::{Amplitude, ExpressionAmplitude, RampAmplitude, TableAmplitude};

    fn table(times: Vec<f64>, values: Vec<f64>) -> TimeFunction {
        TimeFunction::new(&Amplitude::Table(TableAmplitude { times, values })).unwrap()
    }

    fn formula(text: &str) -> TimeFunction {
        TimeFunction::new(&Amplitude::Expression(ExpressionAmplitude { expression: text.into() })).unwrap()
    }

    #[test]
    fn kinks_of_a_table_leave_out_points_on_straight_lines() {
        let f = table(vec![0.3, 0.305, 0.31], vec![0.0, 100.0, 0.0]);
        assert_eq!(f.kinks(), [0.3, 0.305, 0.31]);
        let f = table(vec![0.0, 0.1, 0.2, 0.3, 1.0], vec![0.0, 0.1, 0.2, 0.3, 1.0]);
        assert_eq!(f.kinks(), [0.0, 1.0]);
        let f = table(vec![0.0, 1.0, 2.0], vec![5.0, 5.0, 5.0]);
        assert!(f.kinks().is_empty() && table(vec![1.0], vec![3.0]).kinks().is_empty());
        let ramp = TimeFunction::new(&Amplitude::Ramp(RampAmplitude { start: 0.25, end: 0.5 })).unwrap();
        assert_eq!(ramp.kinks(), [0.25, 0.5]);
    }

    #[test]
    fn kinks_of_a_finely_sampled_curve_are_all_its_points_and_of_a_sampled_line_its_ends() {
        let times: Vec<f64> = (0..20_000).map(|i| f64::from(i) * 1e-3).collect();
        let wave = table(times.clone(), times.iter().map(|t| (3.0 * t).sin()).collect());
        // At the inflections of a sine three points may lie on a line.
        assert!(wave.kinks().len() > 19_900);
        let line = table(times.clone(), times.iter().map(|t| 0.1 * t - 7.0).collect());
        assert_eq!(line.kinks(), [0.0, times[19_999]]);
    }

    #[test]
    fn curved_formulas_are_divided_until_they_are_nearly_straight() {
        let mut found = formula("t^2").nearly_straight(0.0, 1.0, 1e-3);
        found.sort_by(f64::total_cmp);
        assert_eq!(found, (1..16).map(|i| f64::from(i) / 16.0).collect::<Vec<_>>());
        assert!(formula("3*t - 1").nearly_straight(0.0, 1.0, 1e-3).is_empty());
        assert!(formula("tanh(500*(t-0.3))").nearly_straight(0.0, 1.0, 1e-3).len() < 200);
    }

    #[test]
    fn turning_points_of_formulas_are_found_to_the_last_digits() {
        let f = formula("sin(PI*t)");
        let found = f.turning_points(0.0, 1.0);
        assert!(found.len() == 1 && (found[0] - 0.5).abs() < 1e-15, "{found:?}");
        assert_eq!(formula("sin(2*PI*3*t)").turning_points(0.0, 1.0).len(), 6);
        for monotone in ["t", "t^3", "1 - exp(-5*t)", "3", "tanh(500*t)", "t*t - t*t"] {
            assert!(formula(monotone).turning_points(0.0, 1.0).is_empty(), "{monotone}");
        }
    }
}
