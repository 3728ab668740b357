//! Amplitude formulas in `t`: evaluation with first and second derivatives, and messages for invalid formulas.
//!
//! A formula is compiled to a short program, which is evaluated on numbers that carry their derivatives (forward
//! automatic differentiation). Nothing is differentiated symbolically, so time and memory grow with the length of the
//! formula only.

mod jet;
mod parse;

use jet::{Function, Jet};
use parse::{Instruction, LONGEST, evaluate, parse};

use super::TimeFunction;

/// Formula in `t`, compiled for evaluation.
#[derive(Debug, Clone, PartialEq)]
pub struct Formula {
    program: Box<[Instruction]>,
}

impl Formula {
    /// Value at a time; NaN where the formula is undefined.
    pub fn value(&self, t: f64) -> f64 {
        evaluate(&self.program, t)
    }

    /// First derivative at a time.
    pub fn rate(&self, t: f64) -> f64 {
        self.jet(t).rate
    }

    /// Second derivative at a time.
    pub fn acceleration(&self, t: f64) -> f64 {
        self.jet(t).second
    }

    fn jet(&self, t: f64) -> Jet {
        evaluate(&self.program, Jet::variable(t))
    }
}

/// Parses a formula.
///
/// # Errors
/// The text is not a valid formula: description of the mistake, and remedy.
pub(super) fn read(text: &str) -> Result<TimeFunction, (String, String)> {
    let remedy = || {
        let names: Vec<&str> = Function::NAMED.iter().map(|(name, _)| *name).collect();
        format!(
            "write a formula in `t`, such as \"1 - cos(2*PI*t)\", with the operators + - * / ^ and the functions {}",
            names.join(", ")
        )
    };
    if text.trim().is_empty() {
        return Err(("the expression is empty".into(), remedy()));
    }
    let length = text.chars().count();
    if length > LONGEST {
        return Err((
            format!("the expression has {length} characters; at most {LONGEST} are taken"),
            "give a table of times and values instead, such as `type = \"table\"`, or split the load into several"
                .into(),
        ));
    }
    let program =
        parse(text).map_err(|problem| (format!("the expression {} {problem}", quoted(text)), remedy()))?;
    let formula = Formula { program: program.into() };
    if formula.value(0.0).is_finite() {
        Ok(TimeFunction::Formula(formula))
    } else {
        Err((
            format!("the expression {} has no value at t = 0", quoted(text)),
            "look for a division by 0, a root or logarithm of a negative number, and numbers above 1e308"
                .into(),
        ))
    }
}

/// Formula as quoted in messages: whole, or its beginning.
fn quoted(text: &str) -> String {
    const SHOWN: usize = 200;
    match text.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("\"{}…\"", &text[..end]),
        None => format!("\"{text}\""),
    }
}

#[cfg(test)]
mod tests;
