//! Adaptive integration of a factor of the place over edges and elements.
//!
//! A part of an edge or element is integrated by the Gauss rule with two points in each direction, and so are its halves or quarters. Where both
//! values differ, the halves or quarters are divided further: kinks, jumps and narrow peaks are resolved where they lie. Around a pole each
//! division changes the integral by as much as the one before, and the integral does not converge.

use crate::Vec3;
use crate::element::geometry::{GAUSS, area_measure, covariant_base, shape};

/// Change of the integral of a part with its division up to which the part is not divided again, over the integral of the absolute value.
const TOLERANCE: f64 = 1e-6;
/// Error that a jump next to the side of a part hides from its integrals, over the integral of the absolute value, if such parts lie along a line.
const HIDDEN: f64 = 1e-3;
/// Sum of the changes of the smallest parts from which on an integral does not converge, over the integral of the absolute value: a jump along a
/// line leaves a tenth of it.
const UNCONVERGED: f64 = 2e-3;
/// Divisions of an edge, and of an element, one after another.
const DIVISIONS_OF_EDGE: u32 = 24;
const DIVISIONS_OF_ELEMENT: u32 = 11;
/// Parts of an element up to which all are divided.
const MOST_PARTS: usize = 1 << 17;

/// Integrals of a factor of the place over an edge or element.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Distributed<const N: usize> {
    /// Integrals of the shape functions times the factor.
    pub(super) nodal: [f64; N],
    /// Integral of the absolute value of the factor.
    pub(super) size: f64,
    /// Place at which the integrals do not converge, if there is one.
    pub(super) divergent_at: Option<Vec3>,
}

/// Integrals `∫N_a φ ds` of both shape functions of a straight edge times a factor φ of the place.
///
/// # Errors
/// A place close to which the factor has no finite value.
pub(super) fn over_edge([a, b]: [Vec3; 2], factor: impl Fn(&Vec3) -> f64) -> Result<Distributed<2>, Vec3> {
    let shapes = |[xi]: [f64; 1]| [0.5 * (1.0 - xi), 0.5 * (1.0 + xi)];
    let place = |at: [f64; 1]| a * shapes(at)[0] + b * shapes(at)[1];
    let density = 0.5 * (a - b).norm();
    integrate(DIVISIONS_OF_EDGE, place, &factor, |_| density, shapes)
}

/// Integrals `∫N_a φ dA₀` of the shape functions of an element times a factor φ of the place.
///
/// # Errors
/// A place close to which the factor has no finite value.
pub(super) fn over_element(
    corners: &[Vec3; 4],
    factor: impl Fn(&Vec3) -> f64,
) -> Result<Distributed<4>, Vec3> {
    let directors = [Vec3::z(); 4];
    let shapes = |[xi, eta]: [f64; 2]| shape(xi, eta);
    let place = |at: [f64; 2]| corners.iter().zip(shapes(at)).fold(Vec3::zeros(), |sum, (x, n)| sum + x * n);
    let density = |[xi, eta]: [f64; 2]| area_measure(&covariant_base(corners, &directors, xi, eta));
    integrate(DIVISIONS_OF_ELEMENT, place, &factor, density, shapes)
}

/// Integrals over a part.
#[derive(Clone, Copy)]
struct Integral<const N: usize> {
    /// Shape functions times the factor.
    nodal: [f64; N],
    /// Absolute value of the factor.
    size: f64,
}

impl<const N: usize> Default for Integral<N> {
    fn default() -> Self {
        Self { nodal: [0.0; N], size: 0.0 }
    }
}

impl<const N: usize> Integral<N> {
    fn add(&mut self, shapes: [f64; N], weight: f64) {
        self.nodal.iter_mut().zip(shapes).for_each(|(sum, n)| *sum += n * weight);
        self.size += weight.abs();
    }

    fn merge(&mut self, other: &Self) {
        self.nodal.iter_mut().zip(other.nodal).for_each(|(sum, x)| *sum += x);
        self.size += other.size;
    }

    fn change(&self, before: &Self) -> f64 {
        self.nodal.iter().zip(before.nodal).map(|(a, b)| (a - b).abs()).sum()
    }
}

/// Part between `centre` − `half` and `centre` + `half` in natural coordinates.
struct Part<const N: usize, const D: usize> {
    centre: [f64; D],
    half: f64,
    integral: Integral<N>,
    /// Factor at the Gauss points.
    values: [f64; 4],
    /// Length or area.
    measure: f64,
}

impl<const N: usize, const D: usize> Part<N, D> {
    /// Place between the centre and a corner.
    fn towards(&self, corner: [f64; D], share: f64) -> [f64; D] {
        std::array::from_fn(|i| self.centre[i] + self.half * share * corner[i])
    }

    /// Integral over the strips along the sides that the Gauss points do not see, if the factor were there as at the corners and not as it is
    /// extrapolated.
    fn hidden(&self, factor_at: impl Fn([f64; D]) -> f64) -> f64 {
        let jump = corners().map(|corner| {
            // Linear along each direction through the Gauss points.
            let reach =
                |a: &[f64; D]| (0..D).map(|i| 0.5 * (1.0 + a[i] * corner[i] / GAUSS)).product::<f64>();
            let extrapolated: f64 = corners().zip(self.values).map(|(a, value)| reach(&a) * value).sum();
            (factor_at(self.towards(corner, 1.0)) - extrapolated).abs()
        });
        // A factor that is undefined at a corner alone, as sin(x)/x, has an integral.
        let jump = jump.filter(|jump| jump.is_finite()).fold(0.0, f64::max);
        0.25 * (1.0 - GAUSS) * self.measure * jump
    }
}

/// Signs of the corners of a line or square.
fn corners<const D: usize>() -> impl Iterator<Item = [f64; D]> {
    (0..1_usize << D).map(|corner| std::array::from_fn(|i| if (corner >> i) & 1 == 1 { 1.0 } else { -1.0 }))
}

/// Integral over the line or square from −1 to 1 of a factor times shape functions, with the density of the length or area.
fn integrate<const N: usize, const D: usize>(
    divisions: u32,
    place: impl Fn([f64; D]) -> Vec3,
    factor: &impl Fn(&Vec3) -> f64,
    density: impl Fn([f64; D]) -> f64,
    shapes: impl Fn([f64; D]) -> [f64; N],
) -> Result<Distributed<N>, Vec3> {
    let part = |centre: [f64; D], half: f64| {
        let mut part = Part { centre, half, integral: Integral::default(), values: [0.0; 4], measure: 0.0 };
        for (i, corner) in corners().enumerate() {
            let at = part.towards(corner, GAUSS);
            let weight = half.powi(D as i32) * density(at);
            part.values[i] = factor(&place(at));
            part.integral.add(shapes(at), weight * part.values[i]);
            part.measure += weight;
        }
        part
    };
    let divided = |centre: [f64; D], half: f64| -> Vec<Part<N, D>> {
        let half = 0.5 * half;
        let of_corner = |corner: [f64; D]| part(std::array::from_fn(|i| centre[i] + half * corner[i]), half);
        corners().map(of_corner).collect()
    };
    let mut parts = divided([0.0; D], 1.0);
    let mut done = Integral::default();
    let mut divergent_at = None;
    for division in 1.. {
        // The pieces of each part with their sum.
        let mut pieces = Vec::with_capacity(parts.len());
        let mut open = 0.0;
        for whole in &parts {
            let of_whole = divided(whole.centre, whole.half);
            let mut sum = Integral::default();
            of_whole.iter().for_each(|piece| sum.merge(&piece.integral));
            if !(sum.size.is_finite() && whole.integral.size.is_finite()) {
                return Err(place(whole.centre));
            }
            open += sum.size;
            pieces.push((sum, of_whole));
        }
        let size = done.size + open;
        let (mut next, mut unresolved, mut worst) = (Vec::new(), 0.0, (0.0, [0.0; D]));
        let last = division == divisions || (parts.len() << D) > MOST_PARTS;
        for ((sum, pieces), whole) in pieces.into_iter().zip(&parts) {
            let change = sum.change(&whole.integral);
            let hides =
                || whole.hidden(|at| factor(&place(at))) > HIDDEN * size * whole.half.powf(0.5 * D as f64);
            if !last && (change > TOLERANCE * size || hides()) {
                next.extend(pieces);
                continue;
            }
            done.merge(&sum);
            unresolved += change;
            if change > worst.0 {
                worst = (change, whole.centre);
            }
        }
        if last && unresolved > UNCONVERGED * size {
            divergent_at = Some(place(worst.1));
        }
        if next.is_empty() {
            break;
        }
        parts = next;
    }
    Ok(Distributed { nodal: done.nodal, size: done.size, divergent_at })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    const EDGE: [Vec3; 2] = [Vec3::new(0.0, 0.0, 0.0), Vec3::new(0.25, 0.0, 0.0)];

    fn square(side: f64) -> [Vec3; 4] {
        [[0.0, 0.0], [side, 0.0], [side, side], [0.0, side]].map(|[x, y]| Vec3::new(x, y, 0.0))
    }

    fn along(factor: impl Fn(f64) -> f64) -> f64 {
        over_edge(EDGE, |x| factor(x.x)).unwrap().nodal.iter().sum()
    }

    fn over(factor: impl Fn(f64, f64) -> f64) -> f64 {
        over_element(&square(0.25), |x| factor(x.x, x.y)).unwrap().nodal.iter().sum()
    }

    #[test]
    fn integrals_of_smooth_kinked_and_steep_factors_are_exact_to_the_tolerance() {
        let ramp = |x: f64| if x > 0.0 { x } else { 0.0 };
        for (found, exact) in [
            (along(|x| (20.0 * x).sin()), (1.0 - 5.0_f64.cos()) / 20.0),
            (along(|x| ramp(x - 0.1)), 0.5 * 0.15 * 0.15),
            (along(|x| (-1e6 * (x - 0.1) * (x - 0.1)).exp()), 1e-3 * std::f64::consts::PI.sqrt()),
            (over(|x, y| (20.0 * x).sin() * y), 0.25 * 0.125 * (1.0 - 5.0_f64.cos()) / 20.0),
        ] {
            assert!((found / exact - 1.0).abs() < 2e-6, "{found} for {exact}");
        }
        // Where the line leaves the square at y = 1/4, x = 0.025, and the tolerance of each part counts along the line.
        let kink = over(|x, y| ramp(x + 0.3 * y - 0.1));
        let inner = |y: f64| 0.5 * (0.15 + 0.3 * y) * (0.15 + 0.3 * y);
        let exact: f64 = (0..2000).map(|i| inner(0.25 * (f64::from(i) + 0.5) / 2000.0) * 0.25 / 2000.0).sum();
        assert!((kink / exact - 1.0).abs() < 2e-5, "{kink} for {exact}");
        let jump = over(|x, y| if x + 0.3 * y < 0.1 { 0.0 } else { 1.0 });
        let exact = 0.25 * 0.25 - 0.5 * 0.25 * (0.1 + 0.025);
        assert!((jump / exact - 1.0).abs() < 1e-3, "{jump} for {exact}");
        for place in [0.1, 0.03, 0.124, 0.12501, 0.002] {
            let jump = along(|x| if x < place { 1.0 } else { 3.0 });
            assert!((jump / (0.75 - 2.0 * place) - 1.0).abs() < 1e-3, "{jump} at {place}");
            let jump = over(|x, _| if x < place { 1.0 } else { 3.0 });
            assert!((jump / (0.1875 - 0.5 * place) - 1.0).abs() < 2e-3, "{jump} at {place}");
        }
        assert_eq!(along(|_| 0.0), 0.0);
    }

    #[test]
    fn integrals_of_poles_do_not_converge() {
        let place = |factor: &dyn Fn(&Vec3) -> f64| {
            over_element(&square(0.25), factor)
                .unwrap()
                .divergent_at
                .unwrap_or_else(|| panic!("it converges"))
        };
        for pole in [0.1, 0.25 - 1e-17] {
            let along = over_edge(EDGE, |x| 1.0 / (x.x - pole)).unwrap().divergent_at.unwrap();
            assert!((along.x - pole).abs() < 1e-6, "{along}");
            let found = place(&|x| 1.0 / (x.x - pole));
            assert!((found.x - pole).abs() < 1e-3, "{found}");
        }
        // The tangent at its pole is 1.6e16: the nearest number is not the pole.
        let tangent = |x: &Vec3| (2.0 * std::f64::consts::PI * x.x).tan();
        assert!((place(&tangent).x - 0.25).abs() < 1e-3);
        let squared = |x: &Vec3| (2.0 * std::f64::consts::PI * x.x).cos().powi(-2);
        assert!((place(&squared).x - 0.25).abs() < 1e-3);
        let point = |x: &Vec3| 1.0 / (Vec3::new(0.11, 0.07, 0.0) - x).norm_squared();
        assert!((place(&point) - Vec3::new(0.11, 0.07, 0.0)).norm() < 1e-3);
        let undefined = over_edge(EDGE, |x| (x.x - 0.1).sqrt());
        assert!(undefined.is_err(), "{undefined:?}");
    }

    /// A pole in a point may be integrable: over the square with the corner in the pole ∫ dA/r = 2 a ln(1 + √2).
    #[test]
    fn integrable_poles_in_a_point_have_their_integral() {
        let found = over(|x, y| 1.0 / x.hypot(y));
        let exact = 0.5 * (1.0 + 2.0_f64.sqrt()).ln();
        assert!((found / exact - 1.0).abs() < 1e-3, "{found} for {exact}");
    }
}
