//! Formulas against derivatives in closed form.

use std::f64::consts::{E, LN_2, LN_10, PI, TAU};

use super::*;

fn formula(text: &str) -> Formula {
    match read(text) {
        Ok(TimeFunction::Formula(formula)) => formula,
        other => panic!("{text}: {other:?}"),
    }
}

/// A closed form: value, first and second derivative.
type Exact = fn(f64) -> [f64; 3];

/// Formulas and their closed forms.
const CLOSED_FORMS: [(&str, Exact); 40] = [
    ("3", |_| [3.0, 0.0, 0.0]),
    ("t", |t| [t, 1.0, 0.0]),
    ("2*t - 3*t + 1e-3", |t| [1e-3 - t, -1.0, 0.0]),
    ("t/4*8/2", |t| [t, 1.0, 0.0]),
    ("10 - 4 - t", |t| [6.0 - t, -1.0, 0.0]),
    ("-t^2", |t| [-t * t, -2.0 * t, -2.0]),
    ("(-t)^2", |t| [t * t, 2.0 * t, 2.0]),
    ("2*-t^2", |t| [-2.0 * t * t, -4.0 * t, -4.0]),
    ("1 - -+-t^3", |t| [1.0 - t.powi(3), -3.0 * t * t, -6.0 * t]),
    ("2^3^2 + t", |t| [64.0 + t, 1.0, 0.0]),
    ("t^2^3", |t| [t.powi(6), 6.0 * t.powi(5), 30.0 * t.powi(4)]),
    ("t^-1", |t| [1.0 / t, -1.0 / (t * t), 2.0 / t.powi(3)]),
    ("2^-t^2", |t| {
        let y = 0.5_f64.powf(t * t);
        [y, -2.0 * t * LN_2 * y, ((2.0 * t * LN_2).powi(2) - 2.0 * LN_2) * y]
    }),
    ("t^2.5", |t| [t.powf(2.5), 2.5 * t.powf(1.5), 3.75 * t.sqrt()]),
    ("t^t", |t| {
        let (y, l) = (t.powf(t), t.ln() + 1.0);
        [y, y * l, y * (l * l + 1.0 / t)]
    }),
    ("2^t", |t| [2.0_f64.powf(t), LN_2 * 2.0_f64.powf(t), LN_2 * LN_2 * 2.0_f64.powf(t)]),
    ("E^t + e", |t| [t.exp() + E, t.exp(), t.exp()]),
    ("sin(2*t)", |t| [(2.0 * t).sin(), 2.0 * (2.0 * t).cos(), -4.0 * (2.0 * t).sin()]),
    ("cos(TAU*t)", |t| [(TAU * t).cos(), -TAU * (TAU * t).sin(), -TAU * TAU * (TAU * t).cos()]),
    ("sin(t)^2", |t| [t.sin().powi(2), (2.0 * t).sin(), 2.0 * (2.0 * t).cos()]),
    ("sin t ^2", |t| [t.sin().powi(2), (2.0 * t).sin(), 2.0 * (2.0 * t).cos()]),
    ("-sin t", |t| [-t.sin(), -t.cos(), t.sin()]),
    ("sin -t", |t| [-t.sin(), -t.cos(), t.sin()]),
    ("tan(t)", |t| [t.tan(), t.cos().powi(-2), 2.0 * t.tan() / t.cos().powi(2)]),
    ("asin(t)", |t| [t.asin(), (1.0 - t * t).powf(-0.5), t * (1.0 - t * t).powf(-1.5)]),
    ("acos(t)", |t| [t.acos(), -(1.0 - t * t).powf(-0.5), -t * (1.0 - t * t).powf(-1.5)]),
    ("atan(t)", |t| [t.atan(), 1.0 / (1.0 + t * t), -2.0 * t / (1.0 + t * t).powi(2)]),
    ("sinh(3*t)", |t| [(3.0 * t).sinh(), 3.0 * (3.0 * t).cosh(), 9.0 * (3.0 * t).sinh()]),
    ("cosh(t)", |t| [t.cosh(), t.sinh(), t.cosh()]),
    ("tanh(t)", |t| [t.tanh(), t.cosh().powi(-2), -2.0 * t.tanh() / t.cosh().powi(2)]),
    ("asinh(t)", |t| [t.asinh(), (1.0 + t * t).powf(-0.5), -t * (1.0 + t * t).powf(-1.5)]),
    ("acosh(t + 1)", |t| {
        let x = t + 1.0;
        [x.acosh(), (x * x - 1.0).powf(-0.5), -x * (x * x - 1.0).powf(-1.5)]
    }),
    ("atanh(t)", |t| [t.atanh(), 1.0 / (1.0 - t * t), 2.0 * t / (1.0 - t * t).powi(2)]),
    ("exp(-t)*sin(t)", |t| {
        let y = (-t).exp();
        [y * t.sin(), y * (t.cos() - t.sin()), -2.0 * y * t.cos()]
    }),
    ("ln(t) + log(t)", |t| [2.0 * t.ln(), 2.0 / t, -2.0 / (t * t)]),
    ("log2(t)", |t| [t.log2(), 1.0 / (t * LN_2), -1.0 / (t * t * LN_2)]),
    ("log10(t)", |t| [t.log10(), 1.0 / (t * LN_10), -1.0 / (t * t * LN_10)]),
    ("sqrt(1 + t^2)", |t| {
        let y = (1.0 + t * t).sqrt();
        [y, t / y, 1.0 / y.powi(3)]
    }),
    ("sin(t)/t", |t| {
        let (s, c) = t.sin_cos();
        [s / t, (t * c - s) / (t * t), -s / t - 2.0 * c / (t * t) + 2.0 * s / t.powi(3)]
    }),
    ("1 - cos(π*t)*exp(-((t-1)/2)^2)", |t| {
        let x = 0.5 * (t - 1.0);
        let (g, g1) = ((-x * x).exp(), -x * (-x * x).exp());
        let g2 = (x * x - 0.5) * g;
        let (s, c) = (PI * t).sin_cos();
        [1.0 - c * g, PI * s * g - c * g1, PI * PI * c * g + 2.0 * PI * s * g1 - c * g2]
    }),
];

#[test]
fn formulas_have_the_derivatives_of_their_closed_forms() {
    for (text, exact) in CLOSED_FORMS {
        // Logarithms have no value at 0, where `read` asks for one.
        let f =
            Formula { program: parse(text, OF_AMPLITUDES).unwrap_or_else(|e| panic!("{text} {e}")).into() };
        for t in [0.11, 0.5, 0.83] {
            let found = [f.value(t), f.rate(t), f.acceleration(t)];
            for (found, exact) in found.into_iter().zip(exact(t)) {
                let close = (found - exact).abs() <= 4e-13 * (1.0 + exact.abs());
                assert!(close, "{text} at {t}: {found} for {exact}");
            }
            assert_eq!(f.value(t).to_bits(), f.jet(t).value.to_bits(), "{text}");
        }
    }
}

#[test]
fn towers_of_powers_are_read_at_once() {
    // The second derivative of this text, formed as text, filled the memory of the machine.
    let tower = formula(&["t"; 71].join("^"));
    // ((t^t)^t)^… = t^(t^70).
    let exact = 0.9_f64.powf(0.9_f64.powi(70));
    approx::assert_relative_eq!(tower.value(0.9), exact, max_relative = 1e-12);
    let h = 1e-5;
    let slope = (tower.value(0.9 + h) - tower.value(0.9 - h)) / (2.0 * h);
    approx::assert_relative_eq!(tower.rate(0.9), slope, max_relative = 1e-7);
    let product = ["sin(t)"; 500].join("*");
    assert!(read(&product).is_ok() && product.len() < LONGEST);
    // Sums may be as long as the text; brackets and signs are bounded.
    assert!(read(&["t"; 2000].join("+")).is_ok());
    for deep in [
        format!("{}t{}", "(".repeat(500), ")".repeat(500)),
        format!("{}t", "sin ".repeat(500)),
        format!("t{}", "^-t".repeat(500)),
        format!("{}t{}", "t*(1+".repeat(300), ")".repeat(300)),
    ] {
        let (message, _) = read(&deep).unwrap_err();
        assert!(message.contains("within each other") && message.len() < 400, "{message}");
    }
    assert_eq!(formula(&format!("{}t", "-".repeat(4000))).value(2.0), 2.0);
    for (open, most) in [("(", 64), ("atan(", 64), ("sin ", 64)] {
        let close = |n| if open.ends_with('(') { ")".repeat(n) } else { String::new() };
        let nested = |n: usize| read(&format!("{}t{}", open.repeat(n), close(n)));
        assert!(nested(most).is_ok() && nested(most + 1).is_err(), "{open}");
    }
}

#[test]
fn functions_without_smooth_courses_are_refused() {
    for rough in ["abs", "signum", "floor", "round", "ceil", "trunc", "fract", "cbrt", "min", "max"] {
        let (message, _) = read(&format!("{rough}(t)")).unwrap_err();
        assert!(message.contains("cannot be differentiated"), "{message}");
    }
}

#[test]
fn what_is_wrong_is_said_in_words() {
    for (text, part) in [
        ("2*(t", "leaves a bracket open"),
        ("2*t)", "closes a bracket that was not opened"),
        ("2*", "an operator or a number is missing"),
        ("2 t", "an operator or a number is missing"),
        ("()", "an operator or a number is missing"),
        ("*t", "an operator or a number is missing"),
        ("(2 t)", "an operator or a number is missing"),
        ("sin", "an operator or a number is missing"),
        (".", "has the number \".\""),
        ("sin(x)", "unknown variable \"x\""),
        ("sine(t)", "a function \"sine\" that does not exist"),
        ("abs(t)", "\"abs\", which cannot be differentiated"),
        ("t; 3", "the character ';'"),
        ("0,5*t", "a comma"),
        ("1e-3*t*(", "leaves a bracket open"),
        ("1/t", "no value at t = 0"),
        ("", "is empty"),
    ] {
        let (message, help) = read(text).unwrap_err();
        assert!(message.contains(part), "{text}: {message}");
        assert!(help.contains("such as") || help.contains("division by 0"), "{help}");
    }
    let long = (1..=1000).map(|i| format!("{i}*sin({i}*t)")).collect::<Vec<_>>().join("+");
    assert!(read(&long).unwrap_err().0.contains("characters"));
}

#[test]
fn powers_bind_more_tightly_than_signs() {
    for (text, exact) in [
        ("-t^2", -9.0),
        ("(-t^2) + 1", -8.0),
        ("exp(-((t-1)/2)^2)", (-1.0_f64).exp()),
        ("2 - t^2", -7.0),
        ("- t", -3.0),
        ("2*-t", -6.0),
        ("(-t)^2", 9.0),
        ("2*-(t^2+1)", -20.0),
        ("2*-(t^2+1)*t^2", -180.0),
        ("2*-sin(t^2)", -2.0 * 9.0_f64.sin()),
        ("2^-t + t^2", 9.125),
        ("2*+t^2", 18.0),
        ("(t+1)^-1 + 1^2", 1.25),
        ("2*-t^2", -18.0),
        ("t + -t^2", -6.0),
        ("2*-(t+1) ^2", -32.0),
        ("3*-sin(2*t)^2", -3.0 * 6.0_f64.sin().powi(2)),
        ("2*-+t^2", -18.0),
    ] {
        assert!((formula(text).value(3.0) - exact).abs() < 1e-14, "{text}");
    }
}

/// Value, first and second derivative.
fn derivatives(text: &str, t: f64) -> [f64; 3] {
    let f = formula(text);
    [f.value(t), f.rate(t), f.acceleration(t)]
}

/// Derivatives with intermediate values far from 1, as in smoothed ramps.
#[test]
fn derivatives_survive_large_intermediate_values() {
    // (ln(1 + e^x))'' = 1/(4 cosh²(x/2)) in x = t/w, which has died out; the first derivative is 1.
    for t in [0.3, 1.0, 1.42, 2.0] {
        let f = derivatives("0.003*ln(1+exp((t-0.3)/0.003))", t);
        let x: f64 = (t - 0.3) / 0.003;
        let exact = 0.25 / (0.5 * x).cosh().powi(2) / 0.003;
        assert!((f[1] - 1.0 / (1.0 + (-x).exp())).abs() < 1e-12, "{t}: {f:?}");
        assert!((f[2] - exact).abs() < 1e-10 * (1.0 + exact), "{t}: {f:?} for {exact}");
    }
    for (text, rate) in [
        ("sqrt(exp(600*t))", 300.0),
        ("exp(300*t)^(-2)", -600.0),
        ("exp(300*t)^0.5", 150.0),
        ("asinh(exp(600*t))", f64::NAN),
        ("log2(exp(600*t))", f64::NAN),
    ] {
        let f = derivatives(text, 1.0);
        if rate.is_nan() {
            // Straight lines up to rounding.
            assert!(f[1] > 100.0 && f[2].abs() < 1e-9 * f[1] * f[1], "{text}: {f:?}");
        } else {
            assert!((f[1] / (rate * f[0]) - 1.0).abs() < 1e-12, "{text}: {f:?}");
            assert!((f[2] / (rate * rate * f[0]) - 1.0).abs() < 1e-11, "{text}: {f:?}");
        }
    }
}
