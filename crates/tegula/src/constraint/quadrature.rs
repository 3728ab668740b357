//! Gauss quadrature of functions with kinks, whose intervals end at the kinks.
//!
//! A function with kinks tells at each place on which sides of its kinks it is. Between places with different sides the kink is found by
//! bisection, so that quadrature sees smooth pieces only.

/// Abscissae and weights of the five-point Gauss rule on the interval from 0 to 1; exact for polynomials up to the degree 9.
const RULE: [(f64, f64); 5] = [
    (0.046_910_077_030_668, 0.118_463_442_528_094_54),
    (0.230_765_344_947_158_45, 0.239_314_335_249_683_23),
    (0.5, 0.284_444_444_444_444_45),
    (0.769_234_655_052_841_5, 0.239_314_335_249_683_23),
    (0.953_089_922_969_332, 0.118_463_442_528_094_54),
];
/// Largest number of smooth pieces in an interval.
const PIECES: usize = 32;
/// Panels at the beginning of adaptive quadrature, and their largest number.
const PANELS: usize = 4;
const MOST_PANELS: usize = 2000;
/// Largest number of panels that wait: halves of halves, down to round-off of the interval.
const WAITING: usize = 128;
/// Error of a panel over the integral of the absolute value.
const ACCURACY: f64 = 1e-14;

/// Sides of the kinks of a function at a place; `None` for functions without kinks.
pub(super) type Sides<'a> = Option<&'a dyn Fn(f64) -> u64>;

/// Neighbouring places before and behind the first kink that the points of the rule and the ends of an interval show.
fn kink(sides: Sides, [a, b]: [f64; 2]) -> Option<[f64; 2]> {
    let sides = sides?;
    let first = sides(a);
    let points = RULE.iter().map(|(x, _)| a + (b - a) * x).chain([b]);
    let (mut before, mut behind) = (a, None);
    for x in points {
        if sides(x) != first {
            behind = Some(x);
            break;
        }
        before = x;
    }
    let mut behind = behind?;
    loop {
        let middle = before + 0.5 * (behind - before);
        // Near 0 halving would go on to the smallest numbers.
        let resolved = (behind - before).abs() <= f64::EPSILON * (b - a).abs();
        if resolved || middle == before || middle == behind {
            return Some([before, behind]);
        }
        if sides(middle) == first {
            before = middle;
        } else {
            behind = middle;
        }
    }
}

/// Integral of a function by the five-point rule.
fn panel<const N: usize>(f: impl Fn(f64) -> [f64; N], [a, b]: [f64; 2]) -> [f64; N] {
    let mut out = [0.0; N];
    for (x, weight) in RULE {
        let value = f(a + (b - a) * x);
        out.iter_mut().zip(value).for_each(|(out, value)| *out += weight * (b - a) * value);
    }
    out
}

/// Mean of a function over the interval from 0 to 1, by the five-point rule on each smooth piece.
pub(super) fn mean<const N: usize>(f: impl Fn(f64) -> [f64; N], sides: Sides) -> [f64; N] {
    let (mut out, mut from) = ([0.0; N], 0.0);
    for _ in 0..PIECES {
        let kink = kink(sides, [from, 1.0]);
        let piece = panel(&f, [from, kink.map_or(1.0, |[before, _]| before)]);
        out.iter_mut().zip(piece).for_each(|(out, piece)| *out += piece);
        match kink {
            Some([_, behind]) => from = behind,
            None => return out,
        }
    }
    let rest = panel(&f, [from, 1.0]);
    std::array::from_fn(|i| out[i] + rest[i])
}

/// Integral of a function, by panels that are divided at kinks and halved until the rule is exact up to round-off.
pub(super) fn integral(f: impl Fn(f64) -> f64, sides: Sides, [a, b]: [f64; 2]) -> f64 {
    let both = |x: f64| {
        let value = f(x);
        [value, value.abs()]
    };
    // On the stack: energies are computed in each time step.
    let (mut panels, mut waiting, mut scale) = ([([0.0; 2], 0.0); WAITING], PANELS, 0.0);
    let end = |i: usize| if i == PANELS { b } else { a + (b - a) * i as f64 / PANELS as f64 };
    for (i, place) in panels.iter_mut().take(PANELS).enumerate() {
        let ends = [end(i), end(i + 1)];
        let [whole, size] = panel(both, ends);
        *place = (ends, whole);
        scale += size.abs();
    }
    let (mut total, mut left) = (0.0, MOST_PANELS);
    while waiting > 0 {
        waiting -= 1;
        let ([a, b], whole) = panels[waiting];
        let middle = a + 0.5 * (b - a);
        let kink = kink(sides, [a, b]);
        let parts = match kink {
            Some([before, behind]) => [[a, before], [behind, b]],
            None => [[a, middle], [middle, b]],
        };
        let halves = parts.map(|part| panel(both, part)[0]);
        let error = (halves[0] + halves[1] - whole).abs();
        // Behind a kink there may be another one, however small the error.
        let resolved = kink.is_none() && error <= ACCURACY * scale;
        if error.is_nan() || resolved || left == 0 || waiting + 2 > WAITING {
            total += halves[0] + halves[1];
        } else {
            left -= 1;
            for (part, half) in parts.into_iter().zip(halves) {
                panels[waiting] = (part, half);
                waiting += 1;
            }
        }
    }
    total
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_of_degree_nine_have_exact_means() {
        for degree in 0..10 {
            let [found] = mean(|x| [x.powi(degree)], None);
            assert!((found * f64::from(degree + 1) - 1.0).abs() < 1e-15, "{degree}: {found}");
        }
    }

    #[test]
    fn kinks_do_not_disturb_means_and_integrals() {
        for c in [0.0, 0.03, 0.3, 0.5, 0.999, 1.0] {
            // A gap of width 0.1 with kinks at both of its ends, and ∫ of it.
            let f = |x: f64| if (x - c).abs() >= 0.1 { (x - c).abs() } else { 0.1 };
            let sides = |x: f64| u64::from((x - c).abs() >= 0.1) + 2 * u64::from(x >= c);
            let part = |x: f64| if x > 0.1 { 0.5 * (x * x - 0.01) + 0.01 } else { 0.1 * x };
            let exact = part(c) + part(1.0 - c);
            let [found] = mean(|x| [f(x)], Some(&sides));
            assert!((found - exact).abs() < 1e-15, "{c}: {found} {exact}");
            let found = integral(f, Some(&sides), [1.0, 0.0]);
            assert!((found + exact).abs() < 1e-15, "{c}: {found} {exact}");
        }
    }

    #[test]
    fn integrals_of_smooth_functions_are_exact_up_to_round_off() {
        let found = integral(|x| (40.0 * x).sin(), None, [0.0, 3.0]);
        assert!((found - (1.0 - 120_f64.cos()) / 40.0).abs() < 1e-14, "{found}");
        let found = integral(|x| (1.0 + x).powf(-1.4), None, [0.0, -0.99]);
        assert!((found - (1.0 - 0.01_f64.powf(-0.4)) / 0.4).abs() < 1e-13 * found.abs(), "{found}");
        assert!(integral(f64::sqrt, None, [0.0, -1.0]).is_nan());
    }
}
