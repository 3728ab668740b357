//! Formulas: amplitudes in `t` with first and second derivatives, force laws of springs in `x`, `v` and `t` with partial derivatives,
//! inequalities between the coordinates of places, and messages for invalid formulas.
//!
//! A formula is compiled to a short program, which is evaluated on numbers that carry their derivatives (forward
//! automatic differentiation). Nothing is differentiated symbolically, so time and memory grow with the length of the
//! formula only.

mod branches;
mod force;
mod gradient;
mod jet;
mod parse;
mod place;
mod poles;

pub use force::{ForceFormula, Partials};
use jet::{Function, Jet};
use parse::{EXTREMES, Instruction, KINKED, LONGEST, Names, evaluate, parse};
pub use place::{PlaceCondition, PlaceFormula};

use super::TimeFunction;

/// Names in formulas of amplitudes.
const OF_AMPLITUDES: Names = Names { variables: &["t"], kinks: false };

/// Formula in `t`, compiled for evaluation.
#[derive(Debug, Clone, PartialEq)]
pub struct Formula {
    program: Box<[Instruction]>,
}

impl Formula {
    /// Value at a time; NaN where the formula is undefined.
    pub fn value(&self, t: f64) -> f64 {
        evaluate(&self.program, [t])
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
        evaluate(&self.program, [Jet::variable(t)])
    }
}

/// Parses a formula.
///
/// # Errors
/// The text is not a valid formula: description of the mistake, and remedy.
pub(super) fn read(text: &str) -> Result<TimeFunction, (String, String)> {
    let remedy = || {
        format!(
            "write a formula in `t`, such as \"1 - cos(2*PI*t)\", with the operators + - * / ^ and the functions {}",
            functions().join(", ")
        )
    };
    let shorter = "give a table of times and values instead, such as `type = \"table\"`, or split the load into several";
    let program = program(text, OF_AMPLITUDES, (remedy, shorter))?;
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

/// Names of the smooth functions.
fn functions() -> Vec<&'static str> {
    Function::NAMED.iter().map(|(name, _)| *name).collect()
}

/// Names of all functions, also those with kinks.
fn all_functions() -> String {
    let kinked = KINKED.map(|(name, _)| name).into_iter().chain(EXTREMES.map(|(name, _)| name));
    functions().into_iter().chain(kinked).collect::<Vec<_>>().join(", ")
}

/// Program of a formula with these names; remedies for invalid formulas and for those that are too long.
///
/// # Errors
/// The text is not a valid formula: description of the mistake, and remedy.
fn program(
    text: &str,
    names: Names,
    (remedy, shorter): (impl Fn() -> String, &str),
) -> Result<Vec<Instruction>, (String, String)> {
    if text.trim().is_empty() {
        return Err(("the expression is empty".into(), remedy()));
    }
    let length = text.chars().count();
    if length > LONGEST {
        return Err((
            format!("the expression has {length} characters; at most {LONGEST} are taken"),
            shorter.into(),
        ));
    }
    parse(text, names).map_err(|problem| (format!("the expression {} {problem}", quoted(text)), remedy()))
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
