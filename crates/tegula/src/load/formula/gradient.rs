//! Numbers with partial derivatives of first order by several variables (forward automatic differentiation).

use super::jet::{Function, Number, Operator};

/// Value with its partial derivatives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Gradient<const V: usize> {
    /// Value.
    pub value: f64,
    /// Derivatives by the variables.
    pub by: [f64; V],
}

/// Product of a factor and a derivative: zero derivatives stay zero even where the factor is infinite.
fn scaled(factor: f64, by: f64) -> f64 {
    if by == 0.0 { 0.0 } else { factor * by }
}

impl<const V: usize> Gradient<V> {
    /// The variable with this number.
    pub fn variable(value: f64, number: usize) -> Self {
        Self { value, by: std::array::from_fn(|i| if i == number { 1.0 } else { 0.0 }) }
    }

    fn chain(self, value: f64, derivative: f64) -> Self {
        Self { value, by: self.by.map(|by| scaled(derivative, by)) }
    }

    /// Value with the derivatives `a ∂u + b ∂w`.
    fn combined(value: f64, (u, a): (Self, f64), (w, b): (Self, f64)) -> Self {
        Self { value, by: std::array::from_fn(|i| scaled(a, u.by[i]) + scaled(b, w.by[i])) }
    }

    fn power(self, exponent: Self) -> Self {
        let value = self.value.powf(exponent.value);
        let n = exponent.value;
        let by_base = if n == 0.0 { 0.0 } else { n * self.value.powf(n - 1.0) };
        if exponent.by == [0.0; V] {
            return self.chain(value, by_base);
        }
        Self::combined(value, (self, by_base), (exponent, value * self.value.ln()))
    }
}

impl<const V: usize> Number for Gradient<V> {
    fn constant(value: f64) -> Self {
        Self { value, by: [0.0; V] }
    }

    fn combine(operator: Operator, a: Self, b: Self) -> Self {
        let value = f64::combine(operator, a.value, b.value);
        match operator {
            Operator::Add => Self::combined(value, (a, 1.0), (b, 1.0)),
            Operator::Subtract => Self::combined(value, (a, 1.0), (b, -1.0)),
            Operator::Multiply => Self::combined(value, (a, b.value), (b, a.value)),
            Operator::Divide => Self::combined(value, (a, b.value.recip()), (b, -value / b.value)),
            Operator::Power => a.power(b),
            Operator::Min | Operator::Max => {
                if operator.takes_first(a.value, b.value) {
                    a
                } else {
                    b
                }
            }
        }
    }

    fn apply(function: Function, u: Self) -> Self {
        let value = function.value(u.value);
        u.chain(value, function.derivatives(u.value, value)[0])
    }
}
