//! Poles of a formula between two places: values beyond all bounds that a step from one to the other would not see.

use super::branches::Branched;
use super::jet::{Function, Number, Operator};
use super::parse::{Instruction, evaluate};

/// Value next to a sign change over the larger one at the ends above which it grows beyond all bounds: round-off of the place,
/// 10⁻¹⁶, leaves 10⁸ of the weakest pole in use, an inverse square root.
const UNBOUNDED: f64 = 1e6;
/// Distance beside a place, over that of the ends, at which a formula that is undefined in a range is undefined, too.
const BESIDE: f64 = 1e-9;
/// Pieces of a step between whose ends signs are compared.
const PIECES: u32 = 16;
/// Halvings after which the two ends of a piece are neighbours in floating-point numbers.
const HALVINGS: u32 = 60;

/// Value with the signs of all intermediate results on the way to it: a denominator that vanishes between two values changes its
/// sign or, where it is an even power, that of the number below the power.
#[derive(Debug, Clone, Copy)]
struct Signed {
    value: f64,
    signs: Branched,
}

impl Signed {
    fn new(value: f64, signs: Branched) -> Self {
        Self { value, signs: signs.on(value >= 0.0) }
    }
}

impl Number for Signed {
    fn constant(value: f64) -> Self {
        Self { value, signs: Branched::constant(value) }
    }

    fn combine(operator: Operator, a: Self, b: Self) -> Self {
        Self::new(f64::combine(operator, a.value, b.value), Branched::combine(operator, a.signs, b.signs))
    }

    fn apply(function: Function, u: Self) -> Self {
        let signs = Branched::apply(function, u.signs);
        // A tangent has its poles between its branches.
        let branch = (u.value / std::f64::consts::PI).round().rem_euclid(64.0);
        let signs =
            if function == Function::Tan { (0..branch as u8).fold(signs, |s, _| s.on(true)) } else { signs };
        Self::new(f64::apply(function, u.value), signs)
    }
}

/// A place between two others where a formula grows beyond all bounds or is undefined, if there is one.
pub(super) fn pole<const V: usize>(program: &[Instruction], ends: [[f64; V]; 2]) -> Option<[f64; V]> {
    let at = |part: f64| -> [f64; V] {
        std::array::from_fn(|i| {
            if part == 1.0 { ends[1][i] } else { ends[0][i] + part * (ends[1][i] - ends[0][i]) }
        })
    };
    let of = |part: f64| {
        let variables = at(part).map(|x| Signed::new(x, Branched::variable(x)));
        let Signed { value, signs } = evaluate(program, variables);
        (part, value, signs.sides)
    };
    let (first, last) = (of(0.0), of(1.0));
    let bound = UNBOUNDED * first.1.abs().max(last.1.abs());
    // Two poles in a step change a sign twice.
    (0..PIECES).find_map(|i| {
        let piece = [i, i + 1].map(|i| of(f64::from(i) / f64::from(PIECES)));
        search(&of, piece.into(), (bound, HALVINGS)).map(at)
    })
}

/// Part of the way, value and signs at a place.
type Place = (f64, f64, u64);

/// Looks for a pole in a piece whose ends have different signs.
fn search(
    of: &impl Fn(f64) -> Place,
    (first, last): (Place, Place),
    (bound, halvings): (f64, u32),
) -> Option<f64> {
    if first.2 == last.2 {
        return None;
    }
    let middle = of(0.5 * (first.0 + last.0));
    if halvings == 0 || middle.0 <= first.0 || middle.0 >= last.0 {
        let unbounded = |place: &Place| place.1.abs() > bound;
        // A removable singularity, as that of sin(x)/x, is undefined at one place alone.
        let undefined = |place: &Place| {
            let beside = [place.0 - BESIDE, place.0 + BESIDE].map(|part| of(part.clamp(0.0, 1.0)).1);
            place.1.is_nan() && beside.iter().any(|value| value.is_nan())
        };
        let mut ends = [first, last].into_iter();
        return ends.find(|place| unbounded(place) || undefined(place)).map(|place| place.0);
    }
    let halves = [(first, middle), (middle, last)];
    halves.into_iter().find_map(|half| search(of, half, (bound, halvings - 1)))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use crate::load::ForceFormula;

    /// The place of a pole between two elongations.
    fn pole(text: &str, ends: [f64; 2]) -> Option<f64> {
        ForceFormula::read(text).unwrap().pole(ends.map(|x| [x, 0.0, 0.0])).map(|at| at[0])
    }

    #[test]
    fn poles_between_two_places_are_found() {
        let third = 1.0 / 3.0;
        for (text, ends, place) in [
            ("1/(3*x - 1)", [0.2, 0.7], third),
            ("5*x + 1/(3*x - 1)^2", [0.7, 0.2], third),
            ("1/abs(3*x - 1) + x", [0.0, 1.0], third),
            ("(3*x - 1)^(-4)", [0.0, 1.0], third),
            ("1/sqrt(abs(3*x - 1))", [0.0, 1.0], third),
            ("tan(x)", [1.0, 2.0], std::f64::consts::FRAC_PI_2),
            ("tan(x)", [0.0, 7.73], std::f64::consts::FRAC_PI_2),
            ("1/sin(x)", [0.5, 7.0], std::f64::consts::PI),
            ("x/((x - 0.5)*(x - 0.6))", [0.0, 0.55], 0.5),
            ("1/(x^2 - 0.25) + sin(20*x)", [-0.1, 0.6], 0.5),
        ] {
            let found = pole(text, ends).unwrap();
            assert!((found - place).abs() < 1e-9, "{text}: {found}");
        }
    }

    #[test]
    fn formulas_without_a_pole_between_two_places_have_none() {
        for (text, ends) in [
            ("sin(x)/x", [-0.3, 0.4]),
            ("100*x + 4e3*x^3", [-1.0, 1.0]),
            ("max(x - 0.1, 0)*800", [0.0, 0.3]),
            ("1/(1 + x^2)", [-3.0, 3.0]),
            ("1/(x - 1)", [0.0, 0.9]),
            ("tanh(1e6*x)", [-1.0, 1.0]),
            ("abs(x)*log(abs(x) + 1e-9)", [-1.0, 1.0]),
            ("tan(x)", [-1.5, 1.5]),
        ] {
            assert_eq!(pole(text, ends), None, "{text}");
        }
    }
}
