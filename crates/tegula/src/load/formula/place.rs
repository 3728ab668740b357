//! Formulas in the coordinates `x`, `y` and `z` of a place, and inequalities between them.

use super::gradient::Gradient;
use super::parse::{Instruction, Names, evaluate};
use super::{all_functions, poles, program, quoted};
use crate::Vec3;

const OF_PLACES: Names = Names { variables: &["x", "y", "z"], kinks: true };

/// Formula in `x`, `y` and `z`, compiled for evaluation.
#[derive(Debug, Clone, PartialEq)]
pub struct PlaceFormula {
    program: Box<[Instruction]>,
}

impl PlaceFormula {
    /// Parses a formula.
    ///
    /// # Errors
    /// The text is not a valid formula: description of the mistake, and remedy.
    pub(crate) fn read(text: &str) -> Result<Self, (String, String)> {
        let remedy = || {
            format!(
                "write a formula in the coordinates `x`, `y` and `z`, such as \"1 - z/2\", with the operators + - * / ^ and the functions {}",
                all_functions()
            )
        };
        let program = program(text, OF_PLACES, (remedy, "split the load into several"))?;
        Ok(Self { program: program.into() })
    }

    /// Value at a place; NaN where the formula is undefined.
    pub fn value(&self, at: &Vec3) -> f64 {
        evaluate(&self.program, [at.x, at.y, at.z])
    }

    /// A place between two others where the formula grows beyond all bounds or is undefined, if there is one.
    pub fn pole(&self, ends: [Vec3; 2]) -> Option<Vec3> {
        poles::pole(&self.program, ends.map(Into::into)).map(|at: [f64; 3]| at.into())
    }
}

/// Inequality `formula ≤ 0`, or `formula < 0`.
#[derive(Debug, Clone, PartialEq)]
struct Inequality {
    /// The left side, and the right side; the sides of `>` are exchanged.
    sides: [Box<[Instruction]>; 2],
    /// Whether the sides may be equal.
    or_equal: bool,
}

impl Inequality {
    /// Whether the inequality holds at a place; `None` where a side is undefined. Places within a distance `tolerance` of the surface on which both
    /// sides are equal, by the gradient of their difference, lie on it. It holds up to a distance `slack` beyond, too.
    fn holds(&self, at: &Vec3, [tolerance, slack]: [f64; 2]) -> Option<bool> {
        let variables = [0, 1, 2].map(|i| Gradient::<3>::variable(at[i], i));
        let [a, b] = [0, 1].map(|i| evaluate(&self.sides[i], variables));
        let difference = a.value - b.value;
        if !difference.is_finite() {
            return None;
        }
        let slope = Vec3::from_fn(|i, _| a.by[i] - b.by[i]).norm();
        let [margin, beyond] = [tolerance, slack].map(|x| if slope.is_finite() { x * slope } else { 0.0 });
        Some(if self.or_equal { difference <= beyond + margin } else { difference < beyond - margin })
    }
}

/// Inequalities joined by `and` and `or`, compiled for evaluation.
#[derive(Debug, Clone, PartialEq)]
pub struct PlaceCondition {
    /// Of these alternatives one holds; all inequalities of it hold.
    alternatives: Vec<Vec<Inequality>>,
}

impl PlaceCondition {
    /// Parses a condition.
    ///
    /// # Errors
    /// The text is not a valid condition: description of the mistake, and remedy.
    pub(crate) fn read(text: &str) -> Result<Self, (String, String)> {
        if text.trim().is_empty() {
            return Err(("the condition is empty".into(), remedy()));
        }
        let words = split_at_words(text);
        let mut alternatives = Vec::new();
        for part in words.split(|word| *word == "or") {
            let mut all = Vec::new();
            for chain in part.split(|word| *word == "and") {
                all.extend(inequalities(&chain.concat(), text)?);
            }
            alternatives.push(all);
        }
        Ok(Self { alternatives })
    }

    /// Whether the condition holds at a place; `None` where it needs a formula that is undefined there. Inequalities are looked at in their order, up
    /// to the first of an alternative that does not hold. Places within a distance `tolerance` of a surface on which both sides of an inequality are
    /// equal lie on it; inequalities hold up to a distance `slack` beyond it, too.
    pub fn holds(&self, at: &Vec3, [tolerance, slack]: [f64; 2]) -> Option<bool> {
        for all in &self.alternatives {
            let mut every = true;
            for one in all {
                every = one.holds(at, [tolerance, slack])?;
                if !every {
                    break;
                }
            }
            if every {
                return Some(true);
            }
        }
        Some(false)
    }
}

fn remedy() -> String {
    format!(
        "write inequalities in `x`, `y` and `z` with < <= > >=, joined by `and` and `or`, such as \"0 <= x < 0.5 and sqrt(y^2 + z^2) >= 2\", with \
         the operators + - * / ^ and the functions {}",
        all_functions()
    )
}

/// Pieces of a text: the words `and` and `or`, and what stands between them.
fn split_at_words(text: &str) -> Vec<&str> {
    let mut out = Vec::new();
    let (mut start, mut at) = (0, 0);
    while let Some(length) = text[at..].find(|c: char| c.is_alphabetic()) {
        let word = at + length;
        let end =
            text[word..].find(|c: char| !(c.is_alphanumeric() || c == '_')).map_or(text.len(), |n| word + n);
        if ["and", "or"].contains(&&text[word..end]) {
            out.extend([&text[start..word], &text[word..end]]);
            start = end;
        }
        at = end;
    }
    out.push(&text[start..]);
    out
}

/// Inequalities of a chain such as `0 <= x < 1`.
///
/// # Errors
/// There is no inequality, or a side is no formula.
fn inequalities(chain: &str, text: &str) -> Result<Vec<Inequality>, (String, String)> {
    let (mut sides, mut signs) = (Vec::new(), Vec::new());
    let mut rest = chain;
    while let Some(at) = rest.find(['<', '>', '=']) {
        let sign = ["<=", ">=", "<", ">"].into_iter().find(|sign| rest[at..].starts_with(sign));
        let Some(sign) = sign else {
            let problem =
                format!("the condition {} has an \"=\" that is no part of \"<=\" or \">=\"", quoted(text));
            return Err((problem, remedy()));
        };
        sides.push(&rest[..at]);
        signs.push(sign);
        rest = &rest[at + sign.len()..];
    }
    sides.push(rest);
    if signs.is_empty() {
        let problem = if chain.trim().is_empty() {
            "lacks an inequality beside `and` or `or`"
        } else {
            "has a part without an inequality"
        };
        return Err((format!("the condition {} {problem}", quoted(text)), remedy()));
    }
    let unbalanced = |side: &&str| side.matches('(').count() != side.matches(')').count();
    if sides.iter().any(unbalanced) && !unbalanced(&text) {
        let problem = format!("the condition {} has brackets around an inequality", quoted(text));
        return Err((
            problem,
            "brackets belong to formulas; combine several sets by `union` and `intersection`".into(),
        ));
    }
    let programs = sides.into_iter().map(|side| program(side, OF_PLACES, (remedy, "combine several sets")));
    let programs: Vec<Box<[Instruction]>> = programs.map(|p| p.map(Into::into)).collect::<Result<_, _>>()?;
    let pair = |(sides, sign): (&[Box<[Instruction]>], &&str)| {
        let [left, right] = [0, 1].map(|i| sides[i].clone());
        let sides = if sign.starts_with('>') { [right, left] } else { [left, right] };
        Inequality { sides, or_equal: sign.ends_with('=') }
    };
    Ok(programs.windows(2).zip(&signs).map(pair).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn holds(text: &str, at: [f64; 3]) -> bool {
        PlaceCondition::read(text).unwrap().holds(&at.into(), [1e-6, 0.0]).unwrap()
    }

    #[test]
    fn inequalities_hold_where_they_do_and_on_their_surfaces() {
        for (text, at, expected) in [
            ("x < 1", [0.9, 0.0, 0.0], true),
            ("x < 1", [1.0, 0.0, 0.0], false),
            ("x < 1", [1.0 - 1e-9, 0.0, 0.0], false),
            ("x <= 1", [1.0 + 1e-9, 0.0, 0.0], true),
            ("x <= 1", [1.0 + 1e-5, 0.0, 0.0], false),
            ("1 > x", [0.0; 3], true),
            ("y >= 2*x", [1.0, 2.0 - 1e-9, 0.0], true),
            ("0 <= x < 1", [-0.1, 0.0, 0.0], false),
            ("0 <= x < 1", [0.5, 0.0, 0.0], true),
            ("0 <= x < 1", [1.5, 0.0, 0.0], false),
            ("x < 0 or x > 1 and y > 0", [2.0, -1.0, 0.0], false),
            ("x < 0 or x > 1 and y > 0", [-1.0, -1.0, 0.0], true),
            ("x < 0 or x > 1 and y > 0", [2.0, 1.0, 0.0], true),
            ("sqrt(x^2 + y^2) <= 2", [2.0 + 1e-7, 0.0, 5.0], true),
            ("1e6*x^2 <= 1e6", [1.0 + 5e-7, 0.0, 0.0], true),
            ("max(abs(x), abs(y)) < 1", [0.5, -0.7, 9.0], true),
            ("max(abs(x), abs(y)) < 1", [0.5, -1.7, 9.0], false),
            ("x > 0 and sqrt(x) >= 0", [-1.0, 0.0, 0.0], false),
            ("z < 1 or sqrt(x) < 1", [-1.0, 0.0, 0.0], true),
        ] {
            assert_eq!(holds(text, at), expected, "{text} at {at:?}");
        }
    }

    #[test]
    fn a_slack_widens_the_region_on_all_its_sides() {
        let holds = |x: f64| {
            PlaceCondition::read("0 <= 2*x and x < 1").unwrap().holds(&Vec3::new(x, 0.0, 0.0), [1e-6, 0.1])
        };
        assert_eq!([-0.11, -0.09, 0.5, 1.09, 1.11].map(holds), [false, true, true, true, false].map(Some));
    }

    #[test]
    fn conditions_have_no_value_where_they_need_a_formula_that_has_none() {
        for text in ["sqrt(x) >= 0", "y < 1 and sqrt(x) < 1", "y > 1 or ln(x) < 1", "x/y < 1", "1/y > 0"] {
            let at = if text == "x/y < 1" { [0.0; 3] } else { [-1.0, 0.0, 0.0] };
            assert_eq!(PlaceCondition::read(text).unwrap().holds(&at.into(), [1e-6, 0.0]), None, "{text}");
        }
    }

    #[test]
    fn conditions_that_are_none_are_refused_with_the_reason() {
        for (text, reason) in [
            ("", "is empty"),
            ("x", "without an inequality"),
            ("x = 1", "\"=\""),
            ("x < 1 and", "lacks an inequality"),
            ("or x < 1", "lacks an inequality"),
            ("x < ", "empty"),
            ("x < t", "unknown variable \"t\""),
            ("x < 1 && y < 1", "'&'"),
            ("x << 1", "empty"),
            ("floor(x) < 1", "cannot be differentiated"),
            ("x < (1", "bracket"),
            ("(x < 1 or y < 1) and z < 1", "has brackets around an inequality"),
        ] {
            let (problem, remedy) = PlaceCondition::read(text).unwrap_err();
            assert!(problem.contains(reason), "{text}: {problem}");
            assert!(remedy.contains("inequalities") || remedy.contains("sets"), "{remedy}");
        }
    }
}
