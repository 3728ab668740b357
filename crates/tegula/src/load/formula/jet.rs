//! Jets, numbers that carry their derivatives: forward automatic differentiation of second order.
//!
//! A jet holds value, first and second derivative in one variable. Functions of jets follow from the chain rule
//! `(f∘u)' = f'(u) u'`, `(f∘u)'' = f''(u) u'² + f'(u) u''` (Griewank & Walther, Evaluating Derivatives, 2008, ch. 13).

/// Arithmetic of a formula: plain numbers, or numbers with derivatives.
pub(super) trait Number: Copy {
    /// A number that does not depend on the variable.
    fn constant(value: f64) -> Self;
    /// Result of an operator between two numbers.
    fn combine(operator: Operator, left: Self, right: Self) -> Self;
    /// Result of a function.
    fn apply(function: Function, argument: Self) -> Self;
}

/// Operators between two numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Operator {
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
    /// The smaller of two numbers.
    Min,
    /// The larger one.
    Max,
}

impl Operator {
    /// Whether the first of two numbers is the value of [`Operator::Min`] or [`Operator::Max`]; NaN is the value wherever it stands.
    pub fn takes_first(self, first: f64, second: f64) -> bool {
        first.is_nan() || if self == Self::Min { first <= second } else { first >= second }
    }
}

/// Functions of one number, smooth where they are defined but for the kink of the absolute value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Function {
    Negate,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Sinh,
    Cosh,
    Tanh,
    Asinh,
    Acosh,
    Atanh,
    Exp,
    Ln,
    Log2,
    Log10,
    Sqrt,
    Abs,
}

impl Function {
    /// The functions by name; `log` is the natural logarithm.
    pub const NAMED: [(&'static str, Self); 18] = [
        ("sin", Self::Sin),
        ("cos", Self::Cos),
        ("tan", Self::Tan),
        ("asin", Self::Asin),
        ("acos", Self::Acos),
        ("atan", Self::Atan),
        ("sinh", Self::Sinh),
        ("cosh", Self::Cosh),
        ("tanh", Self::Tanh),
        ("asinh", Self::Asinh),
        ("acosh", Self::Acosh),
        ("atanh", Self::Atanh),
        ("exp", Self::Exp),
        ("ln", Self::Ln),
        ("log", Self::Ln),
        ("log2", Self::Log2),
        ("log10", Self::Log10),
        ("sqrt", Self::Sqrt),
    ];

    /// Value at `x`.
    pub fn value(self, x: f64) -> f64 {
        match self {
            Self::Negate => -x,
            Self::Sin => x.sin(),
            Self::Cos => x.cos(),
            Self::Tan => x.tan(),
            Self::Asin => x.asin(),
            Self::Acos => x.acos(),
            Self::Atan => x.atan(),
            Self::Sinh => x.sinh(),
            Self::Cosh => x.cosh(),
            Self::Tanh => x.tanh(),
            Self::Asinh => x.asinh(),
            Self::Acosh => x.acosh(),
            Self::Atanh => x.atanh(),
            Self::Exp => x.exp(),
            Self::Ln => x.ln(),
            Self::Log2 => x.log2(),
            Self::Log10 => x.log10(),
            Self::Sqrt => x.sqrt(),
            Self::Abs => x.abs(),
        }
    }

    /// `f''/f'²` at `x`, where the value is `y`, of slowly growing functions, whose f'' underflows long before
    /// `f'' u'² = (f''/f'²) (f' u')²` does.
    fn curvature_by_rate(self, x: f64, y: f64) -> Option<f64> {
        match self {
            Self::Ln => Some(-1.0),
            Self::Log2 => Some(-std::f64::consts::LN_2),
            Self::Log10 => Some(-std::f64::consts::LN_10),
            Self::Sqrt => Some(-y.recip()),
            Self::Asinh => Some(-x / x.hypot(1.0)),
            Self::Acosh => Some(-x / ((x - 1.0).sqrt() * (x + 1.0).sqrt())),
            _ => None,
        }
    }

    /// First and second derivative at `x`, where the value is `y`.
    pub fn derivatives(self, x: f64, y: f64) -> [f64; 2] {
        match self {
            Self::Negate => [-1.0, 0.0],
            Self::Sin => [x.cos(), -y],
            Self::Cos => [-x.sin(), -y],
            Self::Tan => {
                let d = 1.0 + y * y;
                [d, 2.0 * y * d]
            }
            Self::Asin => {
                let d = ((1.0 - x) * (1.0 + x)).sqrt().recip();
                [d, x * d.powi(3)]
            }
            Self::Acos => {
                let d = ((1.0 - x) * (1.0 + x)).sqrt().recip();
                [-d, -x * d.powi(3)]
            }
            Self::Atan => {
                let d = (1.0 + x * x).recip();
                [d, -2.0 * x * d * d]
            }
            Self::Sinh => [x.cosh(), y],
            Self::Cosh => [x.sinh(), y],
            Self::Tanh => {
                let d = x.cosh().recip().powi(2);
                [d, -2.0 * y * d]
            }
            Self::Asinh => {
                let d = x.hypot(1.0).recip();
                [d, -x * d.powi(3)]
            }
            Self::Acosh => {
                let d = ((x - 1.0).sqrt() * (x + 1.0).sqrt()).recip();
                [d, -x * d.powi(3)]
            }
            Self::Atanh => {
                let d = ((1.0 - x) * (1.0 + x)).recip();
                [d, 2.0 * x * d * d]
            }
            Self::Exp => [y, y],
            Self::Ln => logarithm(x, 1.0),
            Self::Log2 => logarithm(x, std::f64::consts::LOG2_E),
            Self::Log10 => logarithm(x, std::f64::consts::LOG10_E),
            Self::Sqrt => {
                let d = 0.5 / y;
                [d, -0.5 * d / x]
            }
            Self::Abs => [if x >= 0.0 { 1.0 } else { -1.0 }, 0.0],
        }
    }
}

/// Derivatives of `scale · ln x`.
fn logarithm(x: f64, scale: f64) -> [f64; 2] {
    let d = scale / x;
    [d, -d / x]
}

impl Number for f64 {
    fn constant(value: f64) -> Self {
        value
    }

    fn combine(operator: Operator, left: Self, right: Self) -> Self {
        match operator {
            Operator::Add => left + right,
            Operator::Subtract => left - right,
            Operator::Multiply => left * right,
            Operator::Divide => left / right,
            Operator::Power => left.powf(right),
            Operator::Min | Operator::Max => {
                if operator.takes_first(left, right) {
                    left
                } else {
                    right
                }
            }
        }
    }

    fn apply(function: Function, argument: Self) -> Self {
        function.value(argument)
    }
}

/// Value, first and second derivative in the variable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Jet {
    /// Value.
    pub value: f64,
    /// First derivative.
    pub rate: f64,
    /// Second derivative.
    pub second: f64,
}

impl Jet {
    /// The variable itself at `t`.
    pub fn variable(t: f64) -> Self {
        Self { value: t, rate: 1.0, second: 0.0 }
    }

    fn is_constant(self) -> bool {
        self.rate == 0.0 && self.second == 0.0
    }

    /// The chain rule: a function with the derivatives `[f', f'']` and the value `value` at this jet.
    fn chain(self, value: f64, [first, second]: [f64; 2]) -> Self {
        // A constant argument has zero derivatives even where those of the function are infinite.
        if self.is_constant() {
            return Self::constant(value);
        }
        let curved = if self.second == 0.0 { 0.0 } else { first * self.second };
        Self { value, rate: first * self.rate, second: second * self.rate * self.rate + curved }
    }

    fn times(self, other: Self) -> Self {
        Self {
            value: self.value * other.value,
            rate: self.rate * other.value + self.value * other.rate,
            second: self.second * other.value + 2.0 * self.rate * other.rate + self.value * other.second,
        }
    }

    /// `selfⁿ` for a constant exponent; a zero factor of a derivative makes it zero even where the power of 0 behind it
    /// is infinite.
    fn to_constant(self, n: f64) -> Self {
        if self.value.abs() > 1.0 && !self.is_constant() {
            // By ratios: powers of large values underflow before their products with large rates do.
            let value = self.value.powf(n);
            let (rate, second) = (self.rate / self.value, self.second / self.value);
            return Self {
                value,
                rate: n * value * rate,
                second: n * value * (second + (n - 1.0) * rate * rate),
            };
        }
        let power = |factor: f64, n: f64| if factor == 0.0 { 0.0 } else { factor * self.value.powf(n) };
        self.chain(self.value.powf(n), [power(n, n - 1.0), power(n * (n - 1.0), n - 2.0)])
    }

    /// `exp(exponent · ln self)`.
    fn to_the(self, exponent: Self) -> Self {
        if exponent.is_constant() {
            return self.to_constant(exponent.value);
        }
        let logarithm = exponent.times(Self::apply(Function::Ln, self));
        let value = self.value.powf(exponent.value);
        logarithm.chain(value, [value, value])
    }
}

impl Number for Jet {
    fn constant(value: f64) -> Self {
        Self { value, rate: 0.0, second: 0.0 }
    }

    fn combine(operator: Operator, a: Self, b: Self) -> Self {
        match operator {
            Operator::Add => {
                Self { value: a.value + b.value, rate: a.rate + b.rate, second: a.second + b.second }
            }
            Operator::Subtract => {
                Self { value: a.value - b.value, rate: a.rate - b.rate, second: a.second - b.second }
            }
            Operator::Multiply => a.times(b),
            Operator::Divide => {
                // From a = q b: a' = q' b + q b', a'' = q'' b + 2 q' b' + q b''.
                let value = a.value / b.value;
                let rate = (a.rate - value * b.rate) / b.value;
                Self { value, rate, second: (a.second - 2.0 * rate * b.rate - value * b.second) / b.value }
            }
            Operator::Power => a.to_the(b),
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
        let derivatives = function.derivatives(u.value, value);
        match function.curvature_by_rate(u.value, value) {
            Some(curvature) if !u.is_constant() => {
                let rate = derivatives[0] * u.rate;
                let straight = if u.second == 0.0 { 0.0 } else { derivatives[0] * u.second };
                Self { value, rate, second: straight + curvature * rate * rate }
            }
            _ => u.chain(value, derivatives),
        }
    }
}
