//! Force laws of springs: formulas in the elongation `x`, its rate `v` and the time `t`.

use super::branches::Branched;
use super::gradient::Gradient;
use super::parse::{EXTREMES, Instruction, KINKED, Names, evaluate};
use super::poles;
use super::{all_functions, program, quoted};

const OF_SPRINGS: Names = Names { variables: &["x", "v", "t"], kinks: true };

/// Formula in `x`, `v` and `t`, compiled for evaluation.
#[derive(Debug, Clone, PartialEq)]
pub struct ForceFormula {
    program: Box<[Instruction]>,
    text: String,
}

/// Value of a force law with its partial derivatives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Partials {
    /// Value.
    pub value: f64,
    /// Derivative by the elongation or angle.
    pub by_position: f64,
    /// Derivative by its rate.
    pub by_rate: f64,
}

impl ForceFormula {
    /// Parses a formula.
    ///
    /// # Errors
    /// The text is not a valid formula: description of the mistake, and remedy.
    pub(crate) fn read(text: &str) -> Result<Self, (String, String)> {
        let remedy = || {
            format!(
                "write a formula in `x` (from the free length or angle), its rate `v` and the time `t`, with numbers for all constants, such as \
                 \"1e3*x + 2e4*x^3 + 15*v*abs(v)\", with the operators + - * / ^ and the functions {}",
                all_functions()
            )
        };
        let program = program(text, OF_SPRINGS, (remedy, "split the force among several springs"))?;
        Ok(Self { program: program.into(), text: text.into() })
    }

    fn has(&self, variable: u8) -> bool {
        self.program.contains(&Instruction::Variable(variable))
    }

    /// Whether the rate stands in the formula.
    pub fn depends_on_rate(&self) -> bool {
        self.has(1)
    }

    /// Whether the time stands in the formula.
    pub fn depends_on_time(&self) -> bool {
        self.has(2)
    }

    /// Whether the formula may have kinks: `abs`, `min` or `max`.
    pub fn has_kinks(&self) -> bool {
        self.program.iter().any(|instruction| match instruction {
            Instruction::Apply(function) => KINKED.iter().any(|(_, kinked)| kinked == function),
            Instruction::Combine(operator) => EXTREMES.iter().any(|(_, extreme)| extreme == operator),
            _ => false,
        })
    }

    /// Value at `[x, v, t]`; NaN where the formula is undefined.
    pub fn value(&self, at: [f64; 3]) -> f64 {
        evaluate(&self.program, at)
    }

    /// Value and partial derivatives at `[x, v, t]`.
    pub fn partials(&self, [x, v, t]: [f64; 3]) -> Partials {
        let variables = [Gradient::<2>::variable(x, 0), Gradient::variable(v, 1), Gradient::variable(t, 2)];
        let Gradient { value, by: [by_position, by_rate] } = evaluate(&self.program, variables);
        Partials { value, by_position, by_rate }
    }

    /// Sides of its kinks on which the formula is evaluated at `[x, v, t]`: between places with different sides lies a kink.
    pub fn sides(&self, at: [f64; 3]) -> u64 {
        evaluate(&self.program, at.map(Branched::variable)).sides
    }

    /// A place between two others, each `[x, v, t]`, where the formula grows beyond all bounds or is undefined, if there is one.
    pub fn pole(&self, ends: [[f64; 3]; 2]) -> Option<[f64; 3]> {
        poles::pole(&self.program, ends)
    }

    /// The formula, as quoted in messages.
    pub fn quoted(&self) -> String {
        quoted(&self.text)
    }
}
