//! Amplitudes: functions of time and their derivatives.

use super::formula;
use super::{Formula, Signal, Spline};
use crate::model::Amplitude;

/// Amplitude: the function of time of a load or a prescribed motion.
#[derive(Debug, Clone)]
pub enum TimeFunction {
    /// Constant value.
    Constant(f64),
    /// Linear interpolation between points, constant before and after.
    Table(Vec<(f64, f64)>),
    /// Cubic spline through points.
    Spline(Spline),
    /// A formula with its first and second derivative.
    Formula(Formula),
    /// A value that the caller sets between steps.
    Signal(Signal),
}

impl TimeFunction {
    /// Function of an amplitude of the model.
    ///
    /// # Errors
    /// The amplitude is invalid: description of the mistake, and remedy.
    pub fn new(amplitude: &Amplitude) -> Result<Self, (String, String)> {
        match amplitude {
            Amplitude::Constant(c) if c.value.is_finite() => Ok(Self::Constant(c.value)),
            Amplitude::Constant(_) => Err(("its value is not a number".into(), "give a finite value".into())),
            Amplitude::Ramp(r) if r.end > r.start => Ok(Self::Table(vec![(r.start, 0.0), (r.end, 1.0)])),
            Amplitude::Ramp(r) => Err((
                format!("the ramp ends at {} before it starts at {}", r.end, r.start),
                "let `end` be later than `start`".into(),
            )),
            Amplitude::Table(t) => Ok(Self::Table(points(&t.times, &t.values)?)),
            Amplitude::Spline(s) => {
                let points = points(&s.times, &s.values)?;
                let spline = s.rates.iter().all(|x| x.is_finite()).then(|| Spline::new(&points, s.rates));
                spline.flatten().map(Self::Spline).ok_or_else(|| {
                    let message = "the spline has less than two points, or its rates are not numbers";
                    (message.into(), "give two or more points".into())
                })
            }
            Amplitude::Expression(e) => formula::read(&e.expression),
        }
    }

    /// True for a formula or a spline: its values at two times do not determine the values between them.
    pub fn is_formula(&self) -> bool {
        matches!(self, Self::Formula(_) | Self::Spline(_))
    }

    /// Value at a time.
    pub fn value(&self, t: f64) -> f64 {
        match self {
            Self::Constant(c) => *c,
            Self::Signal(signal) => signal.value(),
            Self::Table(points) => table(points, t).0,
            Self::Spline(spline) => spline.at(t)[0],
            Self::Formula(f) => f.value(t),
        }
    }

    /// The first value at a time that is not a finite number: "value", "velocity" or "acceleration". Motions need
    /// all three, loads the value only.
    pub fn undefined(&self, t: f64, motion: bool) -> Option<(&'static str, f64)> {
        let all =
            [("value", self.value(t)), ("velocity", self.rate(t)), ("acceleration", self.acceleration(t))];
        let needed = if motion { 3 } else { 1 };
        all.into_iter().take(needed).find(|(_, x)| !x.is_finite())
    }

    /// First derivative at a time.
    pub fn rate(&self, t: f64) -> f64 {
        match self {
            Self::Constant(_) | Self::Signal(_) => 0.0,
            Self::Table(points) => table(points, t).1,
            Self::Spline(spline) => spline.at(t)[1],
            Self::Formula(f) => f.rate(t),
        }
    }

    /// First derivative just before a time: at a point of a table the left-sided slope.
    pub fn rate_before(&self, t: f64) -> f64 {
        match self {
            Self::Table(points) => {
                let after = points.partition_point(|p| p.0 < t);
                match (after.checked_sub(1).and_then(|i| points.get(i)), points.get(after)) {
                    (Some(a), Some(b)) => (b.1 - a.1) / (b.0 - a.0),
                    _ => 0.0,
                }
            }
            Self::Constant(_) | Self::Spline(_) | Self::Formula(_) | Self::Signal(_) => self.rate(t),
        }
    }

    /// Second derivative just before a time: at the end of a spline it differs from that behind it.
    pub fn acceleration_before(&self, t: f64) -> f64 {
        match self {
            Self::Spline(spline) => spline.acceleration_before(t),
            Self::Constant(_) | Self::Table(_) | Self::Formula(_) | Self::Signal(_) => self.acceleration(t),
        }
    }

    /// Whether a point of a table lies in an interval of time, its ends included: the slope may jump there.
    pub fn has_point_between(&self, first: f64, last: f64) -> bool {
        match self {
            Self::Table(points) => {
                points.get(points.partition_point(|p| p.0 < first)).is_some_and(|p| p.0 <= last)
            }
            Self::Constant(_) | Self::Spline(_) | Self::Formula(_) | Self::Signal(_) => false,
        }
    }

    /// Second derivative at a time (0 between the points of a table).
    pub fn acceleration(&self, t: f64) -> f64 {
        match self {
            Self::Constant(_) | Self::Table(_) | Self::Signal(_) => 0.0,
            Self::Spline(spline) => spline.at(t)[2],
            Self::Formula(f) => f.acceleration(t),
        }
    }
}

/// Points of a table, or what is wrong with them.
fn points(times: &[f64], values: &[f64]) -> Result<Vec<(f64, f64)>, (String, String)> {
    if times.len() != values.len() || times.is_empty() {
        return Err((
            format!("the table has {} times and {} values", times.len(), values.len()),
            "give one value per time, at least one".into(),
        ));
    }
    if times.windows(2).any(|w| w[0] >= w[1]) || !times.iter().chain(values).all(|x| x.is_finite()) {
        return Err((
            "the times of the table do not ascend, or are not numbers".into(),
            "sort the times and make each one once".into(),
        ));
    }
    Ok(times.iter().copied().zip(values.iter().copied()).collect())
}

/// Value and slope of a table; at a point the right-sided slope.
fn table(points: &[(f64, f64)], t: f64) -> (f64, f64) {
    let after = points.partition_point(|p| p.0 <= t);
    if after == 0 {
        (points[0].1, 0.0)
    } else if after == points.len() {
        (points[after - 1].1, 0.0)
    } else {
        let ((t0, y0), (t1, y1)) = (points[after - 1], points[after]);
        let slope = (y1 - y0) / (t1 - t0);
        (y0 + slope * (t - t0), slope)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{ExpressionAmplitude, TableAmplitude};

    fn expression(text: &str) -> Result<TimeFunction, (String, String)> {
        TimeFunction::new(&Amplitude::Expression(ExpressionAmplitude { expression: text.into() }))
    }

    #[test]
    fn formulas_have_exact_derivatives() {
        let f = expression("sin(2*t) + t^2").unwrap();
        approx::assert_relative_eq!(f.value(0.3), 0.6_f64.sin() + 0.09, epsilon = 1e-14);
        approx::assert_relative_eq!(f.rate(0.3), 2.0 * 0.6_f64.cos() + 0.6, epsilon = 1e-13);
        approx::assert_relative_eq!(f.acceleration(0.3), -4.0 * 0.6_f64.sin() + 2.0, epsilon = 1e-12);
        assert_eq!(expression("3").unwrap().rate(1.0), 0.0);
    }

    #[test]
    fn tables_are_constant_outside() {
        let f = TimeFunction::new(&Amplitude::Table(TableAmplitude {
            times: vec![1.0, 2.0],
            values: vec![3.0, 5.0],
        }))
        .unwrap();
        assert_eq!([0.0, 1.5, 9.0].map(|t| f.value(t)), [3.0, 4.0, 5.0]);
        assert_eq!([0.0, 1.5, 9.0].map(|t| f.rate(t)), [0.0, 2.0, 0.0]);
        assert_eq!([0.0, 1.0, 1.5, 2.0, 9.0].map(|t| f.rate_before(t)), [0.0, 0.0, 2.0, 2.0, 0.0]);
        assert_eq!([1.0, 2.0].map(|t| f.rate(t)), [2.0, 0.0]);
        let kinks = [[0.0, 0.9], [0.5, 1.0], [1.1, 1.9], [1.5, 2.5], [2.1, 3.0]];
        assert_eq!(kinks.map(|[a, b]| f.has_point_between(a, b)), [false, true, false, true, false]);
    }

    #[test]
    fn nonsense_is_named() {
        assert!(expression("sin(x)").unwrap_err().0.contains("\"x\""));
        assert!(expression("1/t").unwrap_err().0.contains("t = 0"));
    }

    #[test]
    fn places_without_value_are_found() {
        let root = expression("sqrt(t)").unwrap();
        assert_eq!(root.undefined(0.0, false), None);
        assert_eq!(root.undefined(0.0, true), Some(("velocity", f64::INFINITY)));
        assert_eq!(root.undefined(1.0, true), None);
        assert!(
            expression("ln(1-t)")
                .unwrap()
                .undefined(2.0, false)
                .is_some_and(|(what, x)| what == "value" && x.is_nan())
        );
        // Common formulas have all derivatives at 0.
        for text in
            ["t", "t^2", "t^3", "3*t^2 - 2*t^3", "1 - cos(2*PI*t)", "exp(-t)*sin(t)", "tanh(t)", "t*t"]
        {
            assert_eq!(expression(text).unwrap().undefined(0.0, true), None, "{text}");
        }
    }
}
