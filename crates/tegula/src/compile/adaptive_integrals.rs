//! Adaptive integration of a factor over edges and elements.
//!
//! Parts of edges and elements are integrated by the Gauss rule with two points in each direction, and so are their halves or quarters. The parts whose
//! two values differ most are divided further, so that kinks, jumps and narrow peaks are resolved where they lie, until the sum of the differences
//! is small beside the integral over all edges or elements. A jump next to a side of a part, which no Gauss point sees, shows at its corners. Around a
//! pole each division changes the integral by as much as the one before, and the integral does not converge. Force laws along a line are
//! integrated by `constraint::quadrature`, in each time step and without a test of convergence.

use crate::Vec3;
use crate::element::geometry::{GAUSS, area_measure, covariant_base, shape};
use crate::norm::larger;

/// Differences are relative to the integral of the absolute value over all edges or elements. Their sum at which all parts are resolved; the same where
/// many parts are open, as along a jump; and that from which on an integral that cannot be resolved has no value.
const RESOLVED: f64 = 1e-6;
const RESOLVED_BY_MANY: f64 = 1e-3;
const UNRESOLVED: f64 = 2e-3;
/// Difference of a part that is not looked at again.
const SMALL: f64 = 1e-10;
/// Open parts that are many, and those up to which parts are divided.
const MANY_PARTS: usize = 2_000;
const MOST_PARTS: usize = 100_000;
/// Divisions that make no progress around a pole, the factor by which they would have to lower the difference, and the divisions before that find narrow
/// peaks.
const PROGRESS: (usize, f64) = (4, 0.5);
const SEARCH: usize = 12;
/// Largest number of divisions: parts of the size of round-off.
const MOST_DIVISIONS: usize = 48;
/// Gauss points at the beginning, about: so many parts along each side of few elements, and at least and at most so many.
const FIRST_POINTS: f64 = 1e5;
const FIRST_PARTS: [f64; 2] = [2.0, 32.0];
/// Largest value of a factor.
const LARGEST: f64 = 1e100;

/// Why a factor of the place has no integral.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum WithoutIntegral {
    /// It has no finite value close to a place.
    Undefined(Vec3),
    /// Its integral does not converge at a place.
    Divergent(Vec3),
}

/// Point of an edge or element.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample<const N: usize> {
    /// Index of the edge or element.
    pub(super) body: usize,
    /// Shape functions.
    pub(super) shapes: [f64; N],
    /// Position in the reference configuration.
    pub(super) place: Vec3,
}

/// Integrals over an edge or element.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Integral<const N: usize> {
    /// Shape functions times the factor.
    pub(super) nodal: [f64; N],
    /// Absolute value of the factor.
    pub(super) size: f64,
    /// Length or area.
    pub(super) measure: f64,
}

/// Integrals `∫N_a φ ds` of the shape functions of straight edges times a factor φ.
///
/// # Errors
/// The factor is undefined, or an integral does not converge.
pub(super) fn over_edges(
    edges: &[[Vec3; 2]],
    factor: impl Fn(&Sample<2>) -> f64,
) -> Result<Vec<Integral<2>>, WithoutIntegral> {
    let shapes = |[xi]: [f64; 1]| [0.5 * (1.0 - xi), 0.5 * (1.0 + xi)];
    let density = |[a, b]: &[Vec3; 2], _: [f64; 1]| 0.5 * (a - b).norm();
    Integrand { bodies: edges, factor, shapes, density, end: extrapolation() }.integrate()
}

/// Integrals `∫N_a φ dA₀` of the shape functions of elements times a factor φ.
///
/// # Errors
/// The factor is undefined, or an integral does not converge.
pub(super) fn over_elements(
    elements: &[[Vec3; 4]],
    factor: impl Fn(&Sample<4>) -> f64,
) -> Result<Vec<Integral<4>>, WithoutIntegral> {
    let shapes = |[xi, eta]: [f64; 2]| shape(xi, eta);
    let density =
        |x: &[Vec3; 4], [xi, eta]: [f64; 2]| area_measure(&covariant_base(x, &[Vec3::z(); 4], xi, eta));
    Integrand { bodies: elements, factor, shapes, density, end: extrapolation() }.integrate()
}

impl<const N: usize> Default for Integral<N> {
    fn default() -> Self {
        Self { nodal: [0.0; N], size: 0.0, measure: 0.0 }
    }
}

impl<const N: usize> Integral<N> {
    fn add(&mut self, shapes: [f64; N], weight: f64, factor: f64) {
        self.nodal.iter_mut().zip(shapes).for_each(|(sum, n)| *sum += n * weight * factor);
        self.size += weight * factor.abs();
        self.measure += weight;
    }

    fn merge(&mut self, other: &Self) {
        self.nodal.iter_mut().zip(other.nodal).for_each(|(sum, x)| *sum += x);
        self.size += other.size;
        self.measure += other.measure;
    }

    /// Mean of the factor.
    pub(super) fn mean(&self) -> f64 {
        self.nodal.iter().sum::<f64>() / self.measure
    }

    fn difference(&self, other: &Self) -> f64 {
        self.nodal.iter().zip(other.nodal).map(|(a, b)| (a - b).abs()).sum()
    }
}

/// Part of an edge or element between `centre` − `half` and `centre` + `half` in natural coordinates.
#[derive(Clone, Copy)]
struct Part<const D: usize> {
    body: usize,
    centre: [f64; D],
    half: f64,
}

impl<const D: usize> Part<D> {
    /// Place between the centre and a corner.
    fn towards(&self, corner: [f64; D], share: f64) -> [f64; D] {
        std::array::from_fn(|i| self.centre[i] + self.half * share * corner[i])
    }

    /// Halves or quarters, in the order of the corners.
    fn pieces(self) -> impl Iterator<Item = Self> {
        let half = 0.5 * self.half;
        corners().map(move |corner| Self { centre: self.towards(corner, 0.5), half, ..self })
    }
}

/// Part that its pieces have been summed up for.
struct Divided<const N: usize, const D: usize> {
    part: Part<D>,
    sum: Integral<N>,
    /// Estimate of the error of the sum.
    difference: f64,
}

/// Signs of the corners of a line or square: bit i of the number of a corner tells the sign of coordinate i.
fn corners<const D: usize>() -> impl Iterator<Item = [f64; D]> {
    (0..1_usize << D).map(|corner| std::array::from_fn(|i| if (corner >> i) & 1 == 1 { 1.0 } else { -1.0 }))
}

/// Weights of the values at the four Gauss points of two halves of a line, in their order, in the cubic polynomial at its end.
fn extrapolation() -> [f64; 4] {
    let places = [-0.5 - 0.5 * GAUSS, -0.5 + 0.5 * GAUSS, 0.5 - 0.5 * GAUSS, 0.5 + 0.5 * GAUSS];
    std::array::from_fn(|i| {
        let others = (0..4).filter(|j| *j != i);
        others.map(|j| (1.0 - places[j]) / (places[i] - places[j])).product()
    })
}

/// Factor over edges or elements, with N nodes and D natural coordinates.
struct Integrand<'a, F, S, M, const N: usize> {
    bodies: &'a [[Vec3; N]],
    factor: F,
    shapes: S,
    density: M,
    /// [`extrapolation`] to the end of a line.
    end: [f64; 4],
}

impl<F: Fn(&Sample<N>) -> f64, S, M, const N: usize> Integrand<'_, F, S, M, N> {
    fn integrate<const D: usize>(&self) -> Result<Vec<Integral<N>>, WithoutIntegral>
    where
        S: Fn([f64; D]) -> [f64; N],
        M: Fn(&[Vec3; N], [f64; D]) -> f64,
    {
        let mut done = vec![Integral::default(); self.bodies.len()];
        let first: f64 = self.first_parts().map(|part| self.integral(&part).0.size).sum();
        // Only parts that are not resolved at once are kept.
        let mut open = Vec::new();
        self.divide(self.first_parts(), first, &mut done, &mut open)?;
        let mut history = Vec::new();
        loop {
            let scale =
                done.iter().chain(open.iter().map(|part| &part.sum)).map(|part| part.size).sum::<f64>();
            let difference: f64 = open.iter().map(|part| part.difference).sum();
            let many = open.len() > MANY_PARTS;
            if difference <= if many { RESOLVED_BY_MANY } else { RESOLVED } * scale {
                break;
            }
            history.push(difference);
            let (steps, progress) = PROGRESS;
            let divisions = history.len();
            let stands = divisions > SEARCH && difference > progress * history[divisions - 1 - steps];
            if stands || open.len() > MOST_PARTS || divisions > MOST_DIVISIONS {
                if difference <= UNRESOLVED * scale {
                    break;
                }
                let worst = open.iter().max_by(|a, b| a.difference.total_cmp(&b.difference));
                let at =
                    worst.map_or(Vec3::zeros(), |worst| self.sample(&worst.part, worst.part.centre).place);
                return Err(WithoutIntegral::Divergent(at));
            }
            let parts = std::mem::take(&mut open);
            self.divide(parts.into_iter().flat_map(|part| part.part.pieces()), scale, &mut done, &mut open)?;
        }
        open.iter().for_each(|part| done[part.part.body].merge(&part.sum));
        Ok(done)
    }

    /// Divides parts; those whose difference is small beside the `scale` are done.
    fn divide<const D: usize>(
        &self,
        parts: impl Iterator<Item = Part<D>>,
        scale: f64,
        done: &mut [Integral<N>],
        open: &mut Vec<Divided<N, D>>,
    ) -> Result<(), WithoutIntegral>
    where
        S: Fn([f64; D]) -> [f64; N],
        M: Fn(&[Vec3; N], [f64; D]) -> f64,
    {
        for part in parts {
            let divided = self.divided(part);
            if !divided.difference.is_finite() {
                return Err(WithoutIntegral::Undefined(self.sample(&part, part.centre).place));
            }
            if divided.difference <= SMALL * scale {
                done[part.body].merge(&divided.sum);
            } else {
                open.push(divided);
            }
        }
        Ok(())
    }

    /// Parts with which the integration begins.
    fn first_parts<const D: usize>(&self) -> impl Iterator<Item = Part<D>> {
        let points = FIRST_POINTS / self.bodies.len() as f64;
        let [least, most] = FIRST_PARTS;
        let count = (points.powf(1.0 / D as f64) / 2.0).floor().clamp(least, most) as usize;
        let half = 1.0 / count as f64;
        (0..self.bodies.len()).flat_map(move |body| {
            (0..count.pow(D as u32)).map(move |number| {
                let along = |i: usize| number / count.pow(i as u32) % count;
                let centre = std::array::from_fn(|i| -1.0 + half * (2 * along(i) + 1) as f64);
                Part { body, centre, half }
            })
        })
    }

    fn sample<const D: usize>(&self, part: &Part<D>, at: [f64; D]) -> Sample<N>
    where
        S: Fn([f64; D]) -> [f64; N],
    {
        let shapes = (self.shapes)(at);
        let place = self.bodies[part.body].iter().zip(shapes).fold(Vec3::zeros(), |sum, (x, n)| sum + x * n);
        Sample { body: part.body, shapes, place }
    }

    /// Factor at a point; NaN where it is undefined or too large.
    fn value(&self, at: &Sample<N>) -> f64 {
        let value = (self.factor)(at);
        if value.abs() <= LARGEST { value } else { f64::NAN }
    }

    /// Integral over a part, and the factor at its Gauss points.
    fn integral<const D: usize>(&self, part: &Part<D>) -> (Integral<N>, [f64; 4])
    where
        S: Fn([f64; D]) -> [f64; N],
        M: Fn(&[Vec3; N], [f64; D]) -> f64,
    {
        let (mut out, mut values) = (Integral::default(), [0.0; 4]);
        for (value, corner) in values.iter_mut().zip(corners()) {
            let at = part.towards(corner, GAUSS);
            let sample = self.sample(part, at);
            *value = self.value(&sample);
            let weight = part.half.powi(D as i32) * (self.density)(&self.bodies[part.body], at);
            out.add(sample.shapes, weight, *value);
        }
        (out, values)
    }

    fn divided<const D: usize>(&self, part: Part<D>) -> Divided<N, D>
    where
        S: Fn([f64; D]) -> [f64; N],
        M: Fn(&[Vec3; N], [f64; D]) -> f64,
    {
        let whole = self.integral(&part).0;
        // Values at the Gauss points of the pieces, whose numbers along coordinate i are bits 2i and 2i + 1 of the place.
        let (mut sum, mut values) = (Integral::default(), [0.0; 16]);
        for (piece, each) in part.pieces().enumerate() {
            let (integral, of_piece) = self.integral(&each);
            sum.merge(&integral);
            for (point, value) in of_piece.into_iter().enumerate().take(1 << D) {
                let along = |i: usize| (2 * ((piece >> i) & 1) + ((point >> i) & 1)) << (2 * i);
                values[(0..D).map(along).sum::<usize>()] = value;
            }
        }
        let unseen = 0.25 * (1.0 - GAUSS) * whole.measure * self.jump(&part, &values);
        Divided { part, sum, difference: sum.difference(&whole) + unseen }
    }

    /// Largest difference at the corners of a part between the factor and the cubic polynomial through its values at the Gauss points of the pieces. The
    /// strips along the sides beyond these points are not seen by them.
    fn jump<const D: usize>(&self, part: &Part<D>, values: &[f64; 16]) -> f64
    where
        S: Fn([f64; D]) -> [f64; N],
    {
        let at_corner = |corner: [f64; D]| {
            let weight =
                |number: usize, i: usize| self.end[if corner[i] > 0.0 { number } else { 3 - number }];
            let weights = |place: usize| (0..D).map(|i| weight((place >> (2 * i)) & 3, i)).product::<f64>();
            let extrapolated: f64 = (0..1 << (2 * D)).map(|place| weights(place) * values[place]).sum();
            (self.value(&self.sample(part, part.towards(corner, 1.0))) - extrapolated).abs()
        };
        // A factor that is undefined at a corner alone, as sin(x)/x, has an integral.
        corners().map(at_corner).filter(|jump| jump.is_finite()).fold(0.0, larger)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    const EDGE: [Vec3; 2] = [Vec3::new(0.0, 0.0, 0.0), Vec3::new(0.25, 0.0, 0.0)];

    /// A square of side 1 of n × n elements.
    fn squares(n: usize) -> Vec<[Vec3; 4]> {
        let corner = |i: usize, j: usize| Vec3::new(i as f64 / n as f64, j as f64 / n as f64, 0.0);
        let element = |k: usize| [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[i, j]| corner(k % n + i, k / n + j));
        (0..n * n).map(element).collect()
    }

    fn total<const N: usize>(found: Result<Vec<Integral<N>>, WithoutIntegral>) -> f64 {
        found.unwrap().iter().flat_map(|part| part.nodal).sum()
    }

    fn along(factor: impl Fn(f64) -> f64) -> f64 {
        total(over_edges(&[EDGE], |at| factor(at.place.x)))
    }

    fn over(n: usize, factor: impl Fn(f64, f64) -> f64) -> f64 {
        total(over_elements(&squares(n), |at| factor(at.place.x, at.place.y)))
    }

    fn near(found: f64, exact: f64, tolerance: f64, what: &str) {
        assert!((found / exact - 1.0).abs() < tolerance, "{what}: {found} for {exact}");
    }

    #[test]
    fn integrals_of_smooth_kinked_and_steep_factors_are_exact_to_the_tolerance() {
        let ramp = |x: f64| if x > 0.0 { x } else { 0.0 };
        near(along(|x| (20.0 * x).sin()), (1.0 - 5.0_f64.cos()) / 20.0, 2e-6, "sine");
        near(along(|x| ramp(x - 0.1)), 0.5 * 0.15 * 0.15, 2e-6, "kink");
        let peak = 1e-3 * std::f64::consts::PI.sqrt();
        near(along(|x| (-1e6 * (x - 0.1) * (x - 0.1)).exp()), peak, 2e-6, "peak");
        for n in [1, 17] {
            near(over(n, |x, y| (5.0 * x).sin() * y), 0.1 * (1.0 - 5.0_f64.cos()), 2e-6, "sine");
            near(over(n, |x, _| ramp(x - 0.37)), 0.5 * 0.63 * 0.63, 2e-5, "kink along a line of the mesh");
            let exact = (0.93_f64.powi(3) - 0.63_f64.powi(3)) / (6.0 * 0.3);
            near(over(n, |x, y| ramp(x + 0.3 * y - 0.37)), exact, 2e-5, "oblique kink");
            let spot =
                |w: f64| move |x: f64, y: f64| (-((x - 0.37).powi(2) + (y - 0.61).powi(2)) / (w * w)).exp();
            near(over(n, spot(0.01)), std::f64::consts::PI * 1e-4, 1e-5, "spot");
        }
        assert_eq!(along(|_| 0.0), 0.0);
    }

    #[test]
    #[ignore = "long"]
    fn integrals_of_jumps_are_exact_to_the_tolerance_wherever_they_lie() {
        let step = |inside: bool| if inside { 1.0 } else { 0.0 };
        for place in [0.1, 0.03, 0.124, 0.12501, 0.002] {
            near(along(|x| 3.0 - 2.0 * step(x < place)), 0.75 - 2.0 * place, 1e-5, "edge");
        }
        for n in [1, 4, 24] {
            for place in [0.33, 0.003, 0.2499] {
                near(over(n, |x, _| step(x < place)), place, RESOLVED_BY_MANY, "parallel to the mesh");
            }
            let exact = 0.5 * (0.77 + 0.14);
            near(over(n, |x, y| step(x + 0.63 * y < 0.77)), exact, RESOLVED_BY_MANY, "oblique");
            for [x0, y0, r] in [[0.4852, 0.6267, 0.075], [0.37, 0.61, 0.1]] {
                let patch = |x: f64, y: f64| step((x - x0).hypot(y - y0) < r);
                near(over(n, patch), std::f64::consts::PI * r * r, RESOLVED_BY_MANY, "circle");
                let bump =
                    |x: f64, y: f64| larger(1.0 - ((x - x0).powi(2) + (y - y0).powi(2)) / (r * r), 0.0);
                near(over(n, bump), 0.5 * std::f64::consts::PI * r * r, 1e-4, "paraboloid");
            }
        }
        near(over(4, |x, _| step(x < 0.001)), 0.001, 1e-3, "band");
    }

    #[test]
    #[ignore = "long"]
    fn integrals_of_poles_do_not_converge() {
        let divergent = |n: usize, factor: &dyn Fn(&Vec3) -> f64| match over_elements(&squares(n), |at| {
            factor(&at.place)
        }) {
            Err(WithoutIntegral::Divergent(at)) => at,
            other => panic!("{:?}", other.map(|parts| parts.len())),
        };
        let pi = std::f64::consts::PI;
        for n in [1, 24] {
            for pole in [0.1, 0.5 - 1e-17] {
                assert!((divergent(n, &|x| 1.0 / (x.x - pole)).x - pole).abs() < 1e-3, "{n} {pole}");
            }
            // The tangent at its pole is 1.6e16: the nearest number is not the pole.
            assert!((divergent(n, &|x| (pi * x.x).tan()).x - 0.5).abs() < 1e-3, "{n}");
            assert!((divergent(n, &|x| (pi * x.x).cos().powi(-2)).x - 0.5).abs() < 1e-3, "{n}");
            let point = Vec3::new(0.11, 0.07, 0.0);
            assert!((divergent(n, &|x| 1.0 / (point - x).norm_squared()) - point).norm() < 1e-3, "{n}");
        }
        let along = over_edges(&[EDGE], |at| 1.0 / (at.place.x - 0.1));
        assert!(
            matches!(along, Err(WithoutIntegral::Divergent(at)) if (at.x - 0.1).abs() < 1e-3),
            "{along:?}"
        );
        let undefined = over_edges(&[EDGE], |at| (at.place.x - 0.1).sqrt());
        assert!(matches!(undefined, Err(WithoutIntegral::Undefined(_))), "{undefined:?}");
        let huge = over_edges(&[EDGE], |at| 1e200 * at.place.x);
        assert!(matches!(huge, Err(WithoutIntegral::Undefined(_))), "{huge:?}");
    }

    /// Poles may be integrable: ∫ dA/r over a square of side 1 with the corner in the pole is 2 ln(1 + √2).
    #[test]
    fn integrable_poles_have_their_integral() {
        near(over(1, |x, y| 1.0 / x.hypot(y)), 2.0 * (1.0 + 2.0_f64.sqrt()).ln(), 1e-4, "1/r");
        near(along(|x| (x - 0.1).abs().powf(-0.5)), 2.0 * (0.1_f64.sqrt() + 0.15_f64.sqrt()), 1e-5, "edge");
    }
}
