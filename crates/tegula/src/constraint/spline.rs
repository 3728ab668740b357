//! Interpolating cubic splines in space: curves along which points move.
//!
//! The curve c(u) is a piecewise cubic through the given points with continuous first and second derivatives; u is the sum of the chords
//! (chord-length parametrisation; C. de Boor, *A Practical Guide to Splines*, 2001, ch. IV). At the ends of an open curve it has the slope
//! of the cubic through the four points there (one of lower degree where there are fewer), so that the error is of fourth order in the
//! spacing up to the ends. A closed curve is periodic. Beyond its ends an open curve continues straight: iterations may look there.

use crate::Vec3;

/// Samples of each piece, from which the search for the nearest point starts.
const SAMPLES: usize = 4;
/// Sweeps of the Gauss–Seidel iteration for the slopes, whose error at least halves in each.
const SWEEPS: usize = 80;
/// Steps of the search for the nearest point; bisection alone reaches round-off in as many.
const STEPS: usize = 60;

/// Interpolating cubic spline with a normal that is transported along it.
#[derive(Debug, Clone, PartialEq)]
pub struct Spline {
    points: Vec<Vec3>,
    /// Parameter at each point; for a closed curve also at its first point after one turn.
    knots: Vec<f64>,
    /// Derivatives by u at the points.
    slopes: Vec<Vec3>,
    closed: bool,
    /// Positions and normals at the samples, `SAMPLES` per piece, and at the end.
    samples: Vec<[Vec3; 2]>,
}

/// Point of a curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurvePoint {
    /// Parameter u (length).
    pub parameter: f64,
    /// Position c.
    pub position: Vec3,
    /// First and second derivative by u.
    pub derivatives: [Vec3; 2],
    /// Direction near a normal of the curve, which changes smoothly along it.
    pub normal: Vec3,
}

impl Spline {
    /// Spline through at least two points (three of a closed curve), of which neighbours do not coincide.
    pub fn new(points: Vec<Vec3>, closed: bool) -> Self {
        let n = points.len();
        let pieces = if closed { n } else { n.saturating_sub(1) };
        let mut knots = vec![0.0];
        for k in 0..pieces {
            knots.push(knots[k] + (points[(k + 1) % n] - points[k]).norm());
        }
        let mut out = Self { slopes: vec![Vec3::zeros(); n], points, knots, closed, samples: Vec::new() };
        out.find_slopes();
        out.sample();
        out
    }

    fn pieces(&self) -> usize {
        self.knots.len() - 1
    }

    /// Length of the parameter, the sum of the chords.
    pub fn length(&self) -> f64 {
        self.knots[self.pieces()]
    }

    fn find_slopes(&mut self) {
        let (n, pieces) = (self.points.len(), self.pieces());
        let width = |k: usize| self.knots[k + 1] - self.knots[k];
        let chord = |k: usize| (self.points[(k + 1) % n] - self.points[k]) / width(k);
        if !self.closed {
            self.slopes[0] = self.end_slope(false);
            self.slopes[n - 1] = self.end_slope(true);
        }
        let inner = if self.closed { 0..n } else { 1..n - 1 };
        for _ in 0..SWEEPS {
            for k in inner.clone() {
                let before = (k + pieces - 1) % pieces;
                let [a, b] = [before, k].map(|piece| 1.0 / width(piece));
                let right = (chord(before) * a + chord(k) * b) * 3.0;
                let neighbours = self.slopes[(k + n - 1) % n] * a + self.slopes[(k + 1) % n] * b;
                self.slopes[k] = (right - neighbours) / (2.0 * (a + b));
            }
        }
    }

    /// Slope at an end of the polynomial through the four points there, by its barycentric form.
    fn end_slope(&self, last: bool) -> Vec3 {
        let n = self.points.len();
        let count = n.min(4);
        let place = |i: usize| if last { n - 1 - i } else { i };
        let weight = |j: usize| -> f64 {
            let others = (0..count).filter(|&k| k != j);
            others.map(|k| 1.0 / (self.knots[place(j)] - self.knots[place(k)])).product()
        };
        let term = |j: usize| {
            let distance = self.knots[place(0)] - self.knots[place(j)];
            (self.points[place(j)] - self.points[place(0)]) * (weight(j) / weight(0) / distance)
        };
        (1..count).map(term).sum()
    }

    /// Positions, and normals by parallel transport: those of a closed curve are twisted until they meet.
    fn sample(&mut self) {
        let count = SAMPLES * self.pieces();
        let tangent = |i: usize| self.tangent(self.parameter_of(i));
        let mut normal = crate::element::geometry::tangents(&tangent(0))[0];
        let mut samples = vec![[self.point(0.0).position, normal]];
        for i in 1..=count {
            let [old, new] = [i - 1, i].map(tangent);
            normal = transported(&normal, &old, &new);
            samples.push([self.point(self.parameter_of(i)).position, normal]);
        }
        if self.closed {
            let (first, axis) = (samples[0][1], tangent(0));
            let angle = axis.dot(&normal.cross(&first)).atan2(normal.dot(&first));
            for (i, [_, normal]) in samples.iter_mut().enumerate() {
                let (sine, cosine) = (angle * i as f64 / count as f64).sin_cos();
                *normal = *normal * cosine + tangent(i).cross(normal) * sine;
            }
        }
        self.samples = samples;
    }

    /// Parameter of a sample.
    fn parameter_of(&self, sample: usize) -> f64 {
        let piece = (sample / SAMPLES).min(self.pieces() - 1);
        let part = (sample - SAMPLES * piece) as f64 / SAMPLES as f64;
        self.knots[piece] + part * (self.knots[piece + 1] - self.knots[piece])
    }

    /// Unit tangent.
    pub fn tangent(&self, parameter: f64) -> Vec3 {
        self.point(parameter).derivatives[0].normalize()
    }

    /// Point at a parameter: that of a closed curve counts modulo its length, and beyond the ends of an open one the curve is straight.
    pub fn point(&self, parameter: f64) -> CurvePoint {
        let n = self.points.len();
        let inside = if self.closed {
            parameter - self.length() * (parameter / self.length()).floor()
        } else {
            parameter.clamp(0.0, self.length())
        };
        let piece = self.knots.partition_point(|knot| *knot <= inside).clamp(1, self.pieces()) - 1;
        let h = self.knots[piece + 1] - self.knots[piece];
        let t = (inside - self.knots[piece]) / h;
        let [p, q] = [self.points[piece], self.points[(piece + 1) % n]];
        let [a, b] = [self.slopes[piece], self.slopes[(piece + 1) % n]].map(|slope| slope * h);
        // Hermite's form: p + t a + t² (3 d − 2 a − b) + t³ (a + b − 2 d), d = q − p.
        let d = q - p;
        let (square, cube) = (d * 3.0 - a * 2.0 - b, a + b - d * 2.0);
        let first = (a + (square * 2.0 + cube * (3.0 * t)) * t) / h;
        let mut out = CurvePoint {
            parameter: inside,
            position: p + (a + (square + cube * t) * t) * t,
            derivatives: [first, (square * 2.0 + cube * (6.0 * t)) / (h * h)],
            normal: self.normal(piece, t),
        };
        if !self.closed && inside != parameter {
            out.parameter = parameter;
            out.position += first * (parameter - inside);
            out.derivatives[1] = Vec3::zeros();
        }
        out
    }

    /// Direction between the normals of the samples; any before these are found.
    fn normal(&self, piece: usize, t: f64) -> Vec3 {
        let place = t * SAMPLES as f64;
        let sample = (place as usize).min(SAMPLES - 1);
        let part = place - sample as f64;
        let normal = |i: usize| self.samples.get(SAMPLES * piece + i).map_or_else(Vec3::zeros, |s| s[1]);
        normal(sample) * (1.0 - part) + normal(sample + 1) * part
    }

    /// Point of the curve that is nearest to a place.
    pub fn nearest(&self, place: &Vec3) -> CurvePoint {
        let count = self.samples.len() - 1;
        let distance = |i: usize| (self.samples[i][0] - place).norm_squared();
        let mut best = (0, distance(0));
        for i in 1..self.samples.len() {
            let found = distance(i);
            if found < best.1 {
                best = (i, found);
            }
        }
        let at = self.parameter_of(best.0);
        if !self.closed && (best.0 == 0 || best.0 == count) {
            let end = self.point(at);
            let beyond = end.derivatives[0].dot(&(place - end.position)) / end.derivatives[0].norm_squared();
            if (best.0 == 0 && beyond <= 0.0) || (best.0 == count && beyond >= 0.0) {
                return self.point(at + beyond);
            }
        }
        let step = |i: usize| (self.parameter_of(i + 1) - self.parameter_of(i)).abs();
        let low = if best.0 > 0 {
            at - step(best.0 - 1)
        } else if self.closed {
            at - step(count - 1)
        } else {
            at
        };
        let high = if best.0 < count {
            at + step(best.0)
        } else if self.closed {
            at + step(0)
        } else {
            at
        };
        self.refined(place, at, [low, high])
    }

    /// Zero of `c'·(c − x)` between two parameters by Newton's method, with bisection where this leaves them.
    fn refined(&self, place: &Vec3, start: f64, [mut low, mut high]: [f64; 2]) -> CurvePoint {
        let mut at = start;
        for _ in 0..STEPS {
            let found = self.point(at);
            let [first, second] = found.derivatives;
            let away = found.position - place;
            let value = first.dot(&away);
            if value > 0.0 {
                high = at
            } else {
                low = at
            }
            let slope = first.norm_squared() + second.dot(&away);
            let mut next = at - value / slope;
            // Not a number does not lie between, either.
            if !(slope > 0.0 && next >= low && next <= high) {
                next = 0.5 * (low + high);
            }
            let change = (next - at).abs();
            at = next;
            if change <= 1e-15 * self.length() {
                break;
            }
        }
        self.point(at)
    }

    /// End of an open curve beyond which a parameter lies: 0 for its first point, 1 for its last one.
    pub fn end_passed(&self, parameter: f64) -> Option<usize> {
        // A point that stands at the end may be beyond it by round-off.
        let margin = 1e-9 * self.length();
        match parameter {
            _ if self.closed => None,
            u if u < -margin => Some(0),
            u if u > self.length() + margin => Some(1),
            _ => None,
        }
    }

    /// Angle by which the tangent turns on the way between two parameters, the shorter one of a closed curve (rad), summed over the samples
    /// between them.
    pub fn turning(&self, from: f64, to: f64) -> f64 {
        let [mut low, mut high] = if from <= to { [from, to] } else { [to, from] };
        if self.closed && high - low > 0.5 * self.length() {
            [low, high] = [high, low + self.length()];
        }
        let mut before = self.tangent(low);
        let mut sum = 0.0;
        let mut add = |tangent: Vec3| {
            sum += before.cross(&tangent).norm().atan2(before.dot(&tangent));
            before = tangent;
        };
        let turns = if self.closed { 2 } else { 1 };
        let count = self.samples.len() - 1;
        for turn in 0..turns {
            for sample in 0..count {
                let parameter = self.parameter_of(sample) + f64::from(turn) * self.length();
                if parameter > low && parameter < high {
                    add(self.tangent(parameter));
                }
            }
        }
        add(self.tangent(high));
        sum
    }

    /// Two parameters between which the curve comes back to itself: it passes at a distance below that of its samples, in between it has
    /// turned by more than a right angle.
    pub fn meets_itself(&self) -> Option<[f64; 2]> {
        let count = self.samples.len() - 1;
        let spacing = |i: usize| (self.samples[(i + 1) % self.samples.len()][0] - self.samples[i][0]).norm();
        for i in 0..count {
            let reach = spacing(i);
            for j in i + 2..count {
                let near = (self.samples[j][0] - self.samples[i][0]).norm() < 0.75 * reach.max(spacing(j));
                let neighbours = self.closed && i == 0 && j + 2 > count;
                let [a, b] = [i, j].map(|sample| self.parameter_of(sample));
                if near && !neighbours && self.turning(a, b) > std::f64::consts::FRAC_PI_2 {
                    return Some([a, b]);
                }
            }
        }
        None
    }
}

/// A normal, turned by the smallest rotation that takes one tangent to another.
fn transported(normal: &Vec3, from: &Vec3, to: &Vec3) -> Vec3 {
    let (axis, cosine) = (from.cross(to), from.dot(to));
    let turned = if 1.0 + cosine > 1e-12 {
        normal * cosine + axis.cross(normal) + axis * (axis.dot(normal) / (1.0 + cosine))
    } else {
        *normal
    };
    (turned - to * to.dot(&turned)).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::norm::max_norm;

    fn circle(n: usize) -> Spline {
        let at = |k: usize| {
            let angle = std::f64::consts::TAU * k as f64 / n as f64;
            Vec3::new(angle.cos(), angle.sin(), 0.0)
        };
        Spline::new((0..n).map(at).collect(), true)
    }

    /// Largest distance of a curve from the unit circle.
    fn error(curve: &Spline) -> f64 {
        let at = |i: usize| curve.point(curve.length() * i as f64 / 1000.0).position.norm() - 1.0;
        max_norm((0..1000).map(at))
    }

    #[test]
    fn a_closed_spline_converges_to_a_circle_with_the_fourth_power_of_its_spacing() {
        let errors = [8, 16, 32].map(|n| error(&circle(n)));
        assert!(errors[0] / errors[1] > 14.0 && errors[1] / errors[2] > 14.0, "{errors:?}");
    }

    #[test]
    fn an_open_spline_converges_with_the_fourth_power_up_to_its_ends() {
        let arc = |n: usize| {
            let at = |k: usize| {
                let angle = 2.5 * k as f64 / n as f64;
                Vec3::new(angle.cos(), 0.6 * angle.sin(), 0.8 * angle.sin())
            };
            error(&Spline::new((0..=n).map(at).collect(), false))
        };
        let errors = [8, 16, 32].map(arc);
        assert!(errors[0] / errors[1] > 13.0 && errors[1] / errors[2] > 13.0, "{errors:?}");
    }

    /// Values and derivatives agree at the points from both sides, and derivatives with differences.
    #[test]
    fn first_and_second_derivatives_are_continuous() {
        let points = [[0.0, 0.0, 0.0], [1.0, 0.3, 0.2], [1.5, 1.4, -0.3], [2.7, 1.2, 0.4], [3.0, 0.0, 0.0]];
        for closed in [false, true] {
            let curve = Spline::new(points.map(Vec3::from).to_vec(), closed);
            for knot in &curve.knots[1..curve.pieces()] {
                let [a, b] = [-1e-9, 1e-9].map(|d| curve.point(knot + d));
                assert!((a.derivatives[0] - b.derivatives[0]).norm() < 1e-7, "{knot}");
                assert!((a.derivatives[1] - b.derivatives[1]).norm() < 1e-6, "{knot}");
            }
            let u = 0.37 * curve.length();
            let [a, b, c] = [-1e-4, 0.0, 1e-4].map(|d| curve.point(u + d).position);
            let at = curve.point(u).derivatives;
            assert!(
                ((c - a) / 2e-4 - at[0]).norm() < 1e-6 && ((c - b * 2.0 + a) / 1e-8 - at[1]).norm() < 1e-5
            );
        }
    }

    #[test]
    fn the_nearest_point_is_across_the_curve_also_beyond_the_ends() {
        let points = [[0.0, 0.0, 0.0], [1.0, 0.3, 0.2], [1.5, 1.4, -0.3], [2.7, 1.2, 0.4], [3.0, 0.0, 0.0]];
        let curve = Spline::new(points.map(Vec3::from).to_vec(), false);
        for i in 0..40 {
            let u = curve.length() * (f64::from(i) / 30.0 - 0.15);
            let there = curve.point(u);
            let across = there.derivatives[0].cross(&Vec3::new(0.3, -0.4, 0.8)).normalize();
            let found = curve.nearest(&(there.position + across * 0.02));
            assert!((found.parameter - u).abs() < 1e-9, "{u} {}", found.parameter);
            assert!(there.normal.dot(&there.derivatives[0]).abs() < 0.2 * there.derivatives[0].norm(), "{u}");
        }
        assert_eq!(curve.end_passed(-0.1), Some(0));
        assert_eq!(curve.end_passed(curve.length() + 0.1), Some(1));
        assert_eq!(curve.end_passed(1.0), None);
    }

    #[test]
    fn curves_that_cross_themselves_are_found() {
        let lemniscate = |k: usize| {
            let t = std::f64::consts::TAU * k as f64 / 24.0;
            Vec3::new(t.sin(), t.sin() * t.cos(), 0.0)
        };
        assert!(Spline::new((0..24).map(lemniscate).collect(), true).meets_itself().is_some());
        assert!(circle(12).meets_itself().is_none());
        let helix = |k: usize| Vec3::new((0.5 * k as f64).cos(), (0.5 * k as f64).sin(), 0.05 * k as f64);
        assert!(Spline::new((0..60).map(helix).collect(), false).meets_itself().is_none());
        assert!((circle(64).turning(0.1, 0.6) - 0.5).abs() < 1e-3);
        assert!((circle(64).turning(0.1, circle(64).length() - 0.1) - 0.2).abs() < 1e-3);
    }
}
