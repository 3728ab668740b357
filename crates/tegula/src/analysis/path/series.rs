//! Power series of a piece of an equilibrium path.

use crate::element::Nodal;

/// Displacements and load factor as power series in the path parameter a, from 0 to its range.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Series {
    /// Displacements at the expansion point.
    pub u: Vec<Nodal>,
    /// Coefficients of the displacements, from order 1 on.
    pub coefficients: Vec<Vec<Nodal>>,
    /// Load factor at the expansion point, and its coefficients.
    pub loads: Vec<f64>,
    /// Length a up to which the truncation error is within the tolerance.
    pub range: f64,
}

impl Series {
    /// Displacements at a parameter.
    pub fn displacements(&self, a: f64, out: &mut [Nodal]) {
        out.fill([0.0; 3]);
        for coefficient in self.coefficients.iter().rev().chain([&self.u]) {
            for (x, c) in out.as_flattened_mut().iter_mut().zip(coefficient.as_flattened()) {
                *x = *x * a + c;
            }
        }
    }

    /// Derivative of the displacements with respect to the parameter.
    pub fn direction(&self, a: f64, out: &mut [Nodal]) {
        out.fill([0.0; 3]);
        for (p, coefficient) in self.coefficients.iter().enumerate().rev() {
            let order = (p + 1) as f64;
            for (x, c) in out.as_flattened_mut().iter_mut().zip(coefficient.as_flattened()) {
                *x = *x * a + order * c;
            }
        }
    }

    /// Load factor at a parameter.
    pub fn load(&self, a: f64) -> f64 {
        self.loads.iter().rev().fold(0.0, |sum, c| sum * a + c)
    }

    /// Derivative of the load factor of an order with respect to the parameter.
    pub fn load_derivative(&self, a: f64, order: usize) -> f64 {
        let falling = |p: usize| (0..order).map(|k| (p - k) as f64).product::<f64>();
        self.loads.iter().enumerate().skip(order).rev().fold(0.0, |sum, (p, c)| sum * a + falling(p) * c)
    }
}

impl Series {
    /// Parameters up to `end` at which the load factor has a value, ascending. Between two limit points it is monotonic.
    pub fn reaches(&self, load: f64, end: f64) -> Vec<f64> {
        let limits = roots(end, |a| self.load_derivative(a, 1));
        let ends: Vec<f64> = [0.0].into_iter().chain(limits).chain([end]).collect();
        ends.windows(2).filter_map(|pair| root([pair[0], pair[1]], |a| self.load(a) - load)).collect()
    }
}

/// Change of the load factor over it that is round-off next to a bifurcation, where a crossing path has a stationary load.
const FLAT: f64 = 1e-5;

/// Whether the load factor of a piece is constant up to the parameter `end`, but for round-off: limit points there are none unless an
/// eigenvalue changes its sign.
pub fn is_flat(series: &Series, end: f64) -> bool {
    let start = series.load(0.0);
    (1..=PARTS).all(|i| (series.load(end * i as f64 / PARTS as f64) - start).abs() <= FLAT * start.abs())
}

/// Root of a function between two places where its sign differs; `None` where it does not.
fn root([mut low, mut high]: [f64; 2], f: impl Fn(f64) -> f64) -> Option<f64> {
    let (before, after) = (f(low), f(high));
    if !((before < 0.0 && after >= 0.0) || (before > 0.0 && after <= 0.0)) {
        return None;
    }
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        if (f(middle) < 0.0) == (before < 0.0) { low = middle } else { high = middle }
    }
    Some(high)
}

/// Equal parts of an interval in which a sign change is looked for.
const PARTS: usize = 256;
/// Bisections of a part.
const BISECTIONS: usize = 60;

/// Roots of a function between 0 and `end`, ascending: places where it changes its sign from one of [`PARTS`] equal parts to the next.
pub fn roots(end: f64, f: impl Fn(f64) -> f64) -> Vec<f64> {
    let place = |i: usize| end * i as f64 / PARTS as f64;
    (1..=PARTS).filter_map(|i| root([place(i - 1), place(i)], &f)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cubic() -> Series {
        let coefficients = vec![vec![[1.0, 0.0, 2.0]], vec![[0.0, 3.0, 0.0]], vec![[0.5, 0.0, 0.0]]];
        Series { u: vec![[4.0, 0.0, 0.0]], coefficients, loads: vec![1.0, 2.0, -3.0, 0.5], range: 1.0 }
    }

    #[test]
    fn values_and_derivatives_are_those_of_the_polynomials() {
        let (series, a) = (cubic(), 0.7_f64);
        let mut x = vec![[0.0; 3]];
        series.displacements(a, &mut x);
        let expected = [4.0 + a + 0.5 * a.powi(3), 3.0 * a * a, 2.0 * a];
        assert!((0..3).all(|i| (x[0][i] - expected[i]).abs() < 1e-14));
        series.direction(a, &mut x);
        let expected = [1.0 + 1.5 * a * a, 6.0 * a, 2.0];
        assert!((0..3).all(|i| (x[0][i] - expected[i]).abs() < 1e-14));
        assert!((series.load(a) - (1.0 + 2.0 * a - 3.0 * a * a + 0.5 * a.powi(3))).abs() < 1e-14);
        assert!((series.load_derivative(a, 1) - (2.0 - 6.0 * a + 1.5 * a * a)).abs() < 1e-14);
        assert!((series.load_derivative(a, 2) - (-6.0 + 3.0 * a)).abs() < 1e-14);
    }

    #[test]
    fn loads_that_change_by_round_off_are_flat() {
        let of = |loads: Vec<f64>| Series { loads, ..cubic() };
        assert!(is_flat(&of(vec![-2.0, 0.0, 1e-6]), 1.0) && is_flat(&of(vec![3.0, 1e-5]), 1.0));
        // It comes back to its first value.
        assert!(!is_flat(&of(vec![3.0, 1e-3, -1e-3]), 1.0) && !is_flat(&of(vec![0.0, 1e-9]), 1.0));
        assert!(!is_flat(&of(vec![3.0, f64::NAN]), 1.0));
    }

    #[test]
    fn roots_are_found_in_ascending_order() {
        let found = roots(4.0, |x| (x - 0.5) * (x - 1.75) * (x - 3.9));
        assert_eq!(found.len(), 3);
        for (root, expected) in found.iter().zip([0.5, 1.75, 3.9]) {
            assert!((root - expected).abs() < 1e-14);
        }
        assert!(roots(1.0, |x| x * x + 1.0).is_empty());
    }
}
