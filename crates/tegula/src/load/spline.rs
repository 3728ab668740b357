//! Clamped cubic spline: a smooth function through points.

use nalgebra::{DMatrix, DVector};

/// Change of the value in a piece by the second derivative at one of its ends, over the values, that is round-off.
const ROUND_OFF: f64 = 1e-12;

/// Cubic spline with continuous second derivative through points, and given rates at both ends. Before the first and behind the
/// last point it continues straight.
#[derive(Debug, Clone, PartialEq)]
pub struct Spline {
    /// Times, ascending; values; rates.
    points: Vec<(f64, f64, f64)>,
}

impl Spline {
    /// Spline through two or more points with ascending times, with these rates at its ends.
    pub fn new(points: &[(f64, f64)], ends: [f64; 2]) -> Option<Self> {
        let n = points.len();
        if n < 2 {
            return None;
        }
        // Continuity of the second derivative at the inner points, for the rates (C. de Boor, A practical guide to splines, Ch. 4).
        let (mut matrix, mut right) = (DMatrix::<f64>::identity(n, n), DVector::zeros(n));
        (right[0], right[n - 1]) = (ends[0], ends[1]);
        for i in 1..n - 1 {
            let step = |j: usize| points[j + 1].0 - points[j].0;
            let slope = |j: usize| (points[j + 1].1 - points[j].1) / step(j);
            let (before, after) = (step(i - 1), step(i));
            (matrix[(i, i - 1)], matrix[(i, i)], matrix[(i, i + 1)]) =
                (after, 2.0 * (before + after), before);
            right[i] = 3.0 * (after * slope(i - 1) + before * slope(i));
        }
        let rates = matrix.lu().solve(&right)?;
        let points = points.iter().zip(rates.iter()).map(|(&(t, y), &rate)| (t, y, rate)).collect();
        Some(Self { points })
    }

    /// Ends at which the second derivative jumps to zero, by more than round-off of the values.
    pub fn acceleration_jumps(&self) -> impl Iterator<Item = f64> {
        [0, self.points.len() - 1].into_iter().filter_map(|end| {
            let piece = end.saturating_sub(1);
            let ((t0, y0, r0), (t1, y1, r1)) = (self.points[piece], self.points[piece + 1]);
            let h = t1 - t0;
            let size = y0.abs() + y1.abs() + h * (r0.abs() + r1.abs());
            (0.5 * self.acceleration_at_end(end).abs() * h * h > ROUND_OFF * size)
                .then_some(self.points[end].0)
        })
    }

    /// Second derivative at the first or the last point, inside.
    fn acceleration_at_end(&self, end: usize) -> f64 {
        let piece = end.saturating_sub(1);
        let ((t0, y0, r0), (t1, y1, r1)) = (self.points[piece], self.points[piece + 1]);
        let (h, slope) = (t1 - t0, (y1 - y0) / (t1 - t0));
        let half = if end == 0 { 3.0 * slope - 2.0 * r0 - r1 } else { r0 + 2.0 * r1 - 3.0 * slope };
        2.0 * half / h
    }

    /// Second derivative just before a time: at either end that of the other side.
    pub fn acceleration_before(&self, t: f64) -> f64 {
        let last = self.points.len() - 1;
        match t {
            t if t == self.points[0].0 => 0.0,
            t if t == self.points[last].0 => self.acceleration_at_end(last),
            t => self.at(t)[2],
        }
    }

    /// Value at a time with its first and second derivative.
    pub fn at(&self, t: f64) -> [f64; 3] {
        let (first, last) = (self.points[0], self.points[self.points.len() - 1]);
        for (end, outside) in [(first, t < first.0), (last, t >= last.0)] {
            if outside {
                return [end.1 + end.2 * (t - end.0), end.2, 0.0];
            }
        }
        let after = self.points.partition_point(|p| p.0 <= t);
        let ((t0, y0, r0), (t1, y1, r1)) = (self.points[after - 1], self.points[after]);
        // Hermite's form: y₀ + r₀ s + c s² + d s³.
        let (h, s) = (t1 - t0, t - t0);
        let slope = (y1 - y0) / h;
        let c = (3.0 * slope - 2.0 * r0 - r1) / h;
        let d = (r0 + r1 - 2.0 * slope) / (h * h);
        [y0 + s * (r0 + s * (c + s * d)), r0 + s * (2.0 * c + 3.0 * s * d), 2.0 * c + 6.0 * s * d]
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn a_spline_through_points_of_a_cubic_is_the_cubic() {
        let cubic =
            |t: f64| [1.0 + t - 2.0 * t * t + 0.5 * t * t * t, 1.0 - 4.0 * t + 1.5 * t * t, -4.0 + 3.0 * t];
        let points: Vec<_> = [0.0, 0.3, 1.0, 1.2, 2.0].iter().map(|&t| (t, cubic(t)[0])).collect();
        let spline = Spline::new(&points, [cubic(0.0)[1], cubic(2.0)[1]]).unwrap();
        for i in 0..20 {
            let t = 0.1 * f64::from(i);
            assert!(spline.at(t).iter().zip(cubic(t)).all(|(a, b)| (a - b).abs() < 1e-12), "{t}");
        }
        assert_eq!(spline.at(3.0)[2], 0.0);
        assert!((spline.at(3.0)[0] - (cubic(2.0)[0] + cubic(2.0)[1])).abs() < 1e-12);
    }
}
