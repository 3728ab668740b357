//! Formulas in `t`, with their derivatives, and what is wrong with those that are none.

use exmex::{Differentiate, Express, FlatEx};

use super::TimeFunction;

/// Functions that have derivatives.
const FUNCTIONS: [&str; 18] = [
    "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh", "exp",
    "ln", "log", "log2", "log10", "sqrt",
];
/// Functions that the parser knows but that have kinks or jumps, so that they cannot be differentiated.
const ROUGH: [&str; 11] =
    ["abs", "signum", "floor", "round", "ceil", "trunc", "fract", "cbrt", "atan2", "min", "max"];
const CONSTANTS: [&str; 6] = ["PI", "π", "E", "e", "TAU", "τ"];

/// Longest formula. Its second derivative is formed as a formula too, which grows without bounds with its length.
pub(super) const LONGEST: usize = 160;

/// Reads a formula and differentiates it twice.
///
/// Differentiation recurses deeper than the stack of an ordinary thread allows.
pub(super) fn read(text: &str) -> Result<TimeFunction, (String, String)> {
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
    let remedy = || {
        format!(
            "write a formula in `t`, such as \"1 - cos(2*PI*t)\", with the operators + - * / ^ and the functions {}",
            FUNCTIONS.join(", ")
        )
    };
    let wrong = |_: exmex::ExError| (format!("the expression \"{text}\" {}", problem(text)), remedy());
    if text.trim().is_empty() {
        return Err(("the expression is empty".into(), remedy()));
    }
    if text.chars().count() > LONGEST {
        return Err((
            format!("the expression has {} characters; at most {LONGEST} are taken", text.chars().count()),
            "give a table of times and values instead, or split the load into several".into(),
        ));
    }
    let Some(readable) = with_usual_signs(text) else {
        return Err((
            format!("the expression \"{text}\" has a sign behind an operator and before a power"),
            "put brackets where they are meant, such as \"2*(-t)^2\" or \"2*(-(t^2))\"".into(),
        ));
    };
    let value = exmex::parse::<f64>(&readable).map_err(wrong)?;
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

/// A formula in which −a^b is −(a^b), as usual, for a parser that takes it as (−a)^b: a minus sign at the start of the
/// formula or of a bracket is taken off zero. None where a minus sign stands behind an operator and before a power.
fn with_usual_signs(text: &str) -> Option<String> {
    let mut out = String::new();
    let mut before = '(';
    // Whether a minus sign stands before the operand at hand, and the same in the brackets around.
    let (mut signed, mut around) = (false, Vec::new());
    for c in text.chars() {
        if c == '-' && before == '(' {
            out.push('0');
        }
        match c {
            '(' => around.push(std::mem::take(&mut signed)),
            ')' => signed = around.pop().unwrap_or(false),
            '^' if signed => return None,
            '+' | '-' if "+-*/^".contains(before) => signed |= c == '-',
            '+' | '-' | '*' | '/' => signed = false,
            _ => {}
        }
        out.push(c);
        if !c.is_whitespace() {
            before = c;
        }
    }
    Some(out)
}

/// Why a text is no formula, in words; what the parser says is about its insides.
fn problem(text: &str) -> String {
    let mut depth = 0_i64;
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let mut length = c.len_utf8();
        if c.is_alphabetic() || c == '_' {
            length = rest.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(rest.len());
            let (name, behind) = rest.split_at(length);
            let known = FUNCTIONS.contains(&name) || CONSTANTS.contains(&name) || name == "t";
            if ROUGH.contains(&name) {
                return format!("uses \"{name}\", which cannot be differentiated");
            }
            if !known && behind.trim_start().starts_with('(') {
                return format!("uses a function \"{name}\" that does not exist");
            }
            if !known {
                return format!("has an unknown variable \"{name}\"");
            }
        } else if c.is_ascii_digit() || c == '.' {
            // The letter of an exponent is no name.
            let mut end = rest.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(rest.len());
            let exponent = rest[end..].strip_prefix(['e', 'E']);
            if let Some(digits) = exponent.map(|x| x.strip_prefix(['+', '-']).unwrap_or(x))
                && digits.starts_with(|c: char| c.is_ascii_digit())
            {
                end = rest.len() - digits.trim_start_matches(|c: char| c.is_ascii_digit()).len();
            }
            length = end;
        } else if c == '(' {
            depth += 1;
        } else if c == ')' {
            depth -= 1;
            if depth < 0 {
                return "closes a bracket that was not opened".into();
            }
        } else if !(c.is_whitespace() || "+-*/^,".contains(c)) {
            return format!("holds the character {c:?}, which has no meaning in a formula");
        }
        rest = &rest[length..];
    }
    if depth > 0 {
        "leaves a bracket open".into()
    } else {
        "is not a formula: an operator or a number is missing".into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_function_and_constant_that_is_offered_can_be_used() {
        for function in FUNCTIONS {
            // Within the domain of each.
            let (t, shift) = if function == "acosh" { (1.5, 1.2) } else { (0.5, 0.1) };
            let f = read(&format!("{function}(t + {shift})"));
            let f = f.unwrap_or_else(|(message, _)| panic!("{message}"));
            assert_eq!(f.undefined(t, true), None, "{function}");
            let slope = (f.value(t + 1e-5) - f.value(t - 1e-5)) / 2e-5;
            approx::assert_relative_eq!(f.rate(t), slope, max_relative = 1e-6);
        }
        for constant in CONSTANTS {
            assert!(read(&format!("{constant}*t")).is_ok(), "{constant}");
        }
        for rough in ROUGH {
            assert!(read(&format!("{rough}(t)")).is_err(), "{rough}");
        }
    }

    #[test]
    fn what_is_wrong_is_said_in_words() {
        for (text, part) in [
            ("2*(t", "leaves a bracket open"),
            ("2*t)", "closes a bracket that was not opened"),
            ("2*", "an operator or a number is missing"),
            ("2 t", "an operator or a number is missing"),
            ("sin(x)", "unknown variable \"x\""),
            ("sine(t)", "a function \"sine\" that does not exist"),
            ("abs(t)", "\"abs\", which cannot be differentiated"),
            ("t; 3", "the character ';'"),
            ("1e-3*t*(", "leaves a bracket open"),
            ("", "is empty"),
        ] {
            let (message, help) = read(text).unwrap_err();
            assert!(message.contains(part), "{text}: {message}");
            assert!(help.contains("such as"), "{help}");
        }
        let long = (1..=100).map(|i| format!("{i}*sin({i}*t)")).collect::<Vec<_>>().join("+");
        assert!(read(&long).unwrap_err().0.contains("characters"));
    }

    #[test]
    fn a_minus_sign_is_weaker_than_a_power() {
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
        ] {
            assert!((read(text).unwrap().value(3.0) - exact).abs() < 1e-14, "{text}");
        }
        for text in [
            "2*-t^2",
            "t + -t^2",
            "2*-(t+1)^2",
            "2*-(t+1) ^2",
            "3*-sin(2*t)^2",
            "2*-sin(t+1)^2",
            "2*-sin(t+(t-1))^2",
            "exp(2*-(t+1)^2)",
            "2*-+t^2",
        ] {
            let (message, help) = read(text).err().unwrap();
            assert!(message.contains(text) && help.contains("brackets"), "{message}");
        }
    }
}
