//! Functions of time and their derivatives.

use exmex::{Differentiate, Express, FlatEx};

use crate::model::Amplitude;

/// A function of time that a load or a prescribed motion follows.
#[derive(Debug, Clone)]
pub enum TimeFunction {
    /// The same at all times.
    Constant(f64),
    /// Straight lines between points, constant before and after.
    Table(Vec<(f64, f64)>),
    /// A formula with its first and second derivative.
    Formula(Box<[FlatEx<f64>; 3]>),
}

impl TimeFunction {
    /// From the model's amplitude.
    ///
    /// # Errors
    /// What is wrong with it and what to do.
    pub fn new(amplitude: &Amplitude) -> Result<Self, (String, String)> {
        match amplitude {
            Amplitude::Constant(c) if c.value.is_finite() => Ok(Self::Constant(c.value)),
            Amplitude::Constant(_) => Err(("its value is not a number".into(), "give a finite value".into())),
            Amplitude::Ramp(r) if r.end > r.start => Ok(Self::Table(vec![(r.start, 0.0), (r.end, 1.0)])),
            Amplitude::Ramp(r) => Err((
                format!("the ramp ends at {} before it starts at {}", r.end, r.start),
                "let `end` be later than `start`".into(),
            )),
            Amplitude::Table(t) => {
                if t.times.len() != t.values.len() || t.times.is_empty() {
                    return Err((
                        format!("the table has {} times and {} values", t.times.len(), t.values.len()),
                        "give one value per time, at least one".into(),
                    ));
                }
                if t.times.windows(2).any(|w| w[0] >= w[1])
                    || !t.times.iter().chain(&t.values).all(|x| x.is_finite())
                {
                    return Err((
                        "the times of the table do not ascend, or are not numbers".into(),
                        "sort the times and make each one once".into(),
                    ));
                }
                Ok(Self::Table(t.times.iter().copied().zip(t.values.iter().copied()).collect()))
            }
            Amplitude::Expression(e) => on_a_large_stack(&e.expression),
        }
    }

    /// Value at a time.
    pub fn value(&self, t: f64) -> f64 {
        match self {
            Self::Constant(c) => *c,
            Self::Table(points) => table(points, t).0,
            Self::Formula(f) => evaluate(&f[0], t),
        }
    }

    /// First derivative at a time.
    pub fn rate(&self, t: f64) -> f64 {
        match self {
            Self::Constant(_) => 0.0,
            Self::Table(points) => table(points, t).1,
            Self::Formula(f) => evaluate(&f[1], t),
        }
    }

    /// Second derivative at a time (0 between the points of a table).
    pub fn acceleration(&self, t: f64) -> f64 {
        match self {
            Self::Constant(_) | Self::Table(_) => 0.0,
            Self::Formula(f) => evaluate(&f[2], t),
        }
    }
}

/// Longest formula. Its second derivative is formed as a formula too, which grows without bounds with its length.
const LONGEST_FORMULA: usize = 160;

/// Differentiation recurses deeper than the stack of an ordinary thread allows.
fn on_a_large_stack(text: &str) -> Result<TimeFunction, (String, String)> {
    const STACK: usize = 256 << 20;
    let own = text.to_owned();
    let thread = std::thread::Builder::new().stack_size(STACK).spawn(move || formula(&own));
    thread.ok().and_then(|t| t.join().ok()).unwrap_or_else(|| {
        Err((
            format!("the expression \"{text}\" cannot be differentiated"),
            "write it shorter, or give a table".into(),
        ))
    })
}

fn formula(text: &str) -> Result<TimeFunction, (String, String)> {
    let remedy = || "write a formula in `t`, such as \"1 - cos(2*PI*t)\"".to_string();
    let wrong = |e: exmex::ExError| (format!("the expression \"{text}\" cannot be read: {e}"), remedy());
    if text.chars().count() > LONGEST_FORMULA {
        return Err((
            format!(
                "the expression has {} characters; at most {LONGEST_FORMULA} are taken",
                text.chars().count()
            ),
            "give a table of times and values instead, or split the load into several".into(),
        ));
    }
    let value = exmex::parse::<f64>(text).map_err(wrong)?;
    let names = value.var_names();
    if let Some(other) = names.iter().find(|n| *n != "t") {
        return Err((format!("the expression \"{text}\" has an unknown variable \"{other}\""), remedy()));
    }
    let derivative = |f: &FlatEx<f64>| {
        if f.var_names().is_empty() { exmex::parse::<f64>("0") } else { f.clone().partial(0) }
    };
    let rate = derivative(&value).map_err(wrong)?;
    let acceleration = derivative(&rate).map_err(wrong)?;
    let function = TimeFunction::Formula(Box::new([value, rate, acceleration]));
    if function.value(0.0).is_finite() {
        Ok(function)
    } else {
        Err((format!("the expression \"{text}\" has no value at t = 0"), remedy()))
    }
}

fn evaluate(f: &FlatEx<f64>, t: f64) -> f64 {
    let result = if f.var_names().is_empty() { f.eval(&[]) } else { f.eval(&[t]) };
    result.unwrap_or(f64::NAN)
}

/// Value and slope; at a point the slope to the right.
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
    }

    #[test]
    fn nonsense_is_named() {
        assert!(expression("sin(x)").unwrap_err().0.contains("\"x\""));
        assert!(expression("2*(t").is_err());
        let long = (1..=100).map(|i| format!("{i}*sin({i}*t)")).collect::<Vec<_>>().join("+");
        assert!(expression(&long).unwrap_err().0.contains("characters"));
        let product = ["sin(t)"; 23].join("*");
        assert!(expression(&product).is_ok() && product.len() <= LONGEST_FORMULA);
        assert!(expression("1/t").unwrap_err().0.contains("t = 0"));
    }
}
