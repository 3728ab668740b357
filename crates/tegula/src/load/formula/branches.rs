//! Numbers that remember on which side of its kinks a formula was evaluated.

use super::jet::{Function, Number, Operator};

/// Value with the sides of all kinks on the way to it. Between two values with different sides lies a kink.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Branched {
    value: f64,
    /// Sides of the kinks, hashed.
    pub sides: u64,
}

/// Odd number that spreads the bits of a hash (the golden ratio, 2⁶⁴/φ).
const SPREAD: u64 = 0x9e37_79b9_7f4a_7c15;

impl Branched {
    /// The value of a variable.
    pub fn variable(value: f64) -> Self {
        Self { value, sides: 0 }
    }

    /// The number, with the side of one more kink.
    pub fn on(self, is_first: bool) -> Self {
        Self { sides: (self.sides ^ if is_first { 1 } else { 2 }).wrapping_mul(SPREAD), ..self }
    }
}

impl Number for Branched {
    fn constant(value: f64) -> Self {
        Self::variable(value)
    }

    fn combine(operator: Operator, a: Self, b: Self) -> Self {
        let value = f64::combine(operator, a.value, b.value);
        let both = Self { value, sides: a.sides.wrapping_mul(3).wrapping_add(b.sides) };
        match operator {
            Operator::Min | Operator::Max => both.on(operator.takes_first(a.value, b.value)),
            _ => both,
        }
    }

    fn apply(function: Function, u: Self) -> Self {
        let of = Self { value: f64::apply(function, u.value), ..u };
        if function == Function::Abs { of.on(u.value >= 0.0) } else { of }
    }
}
