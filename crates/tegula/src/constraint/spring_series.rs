//! Power series of linear springs between two points.
//!
//! The force `k (1 − l/L) x` on the vector x between the points contains the inverse of the length L. With `s = x·x` the coefficients of
//! `w = s^{−1/2}` follow from `s w' = −½ s' w`,
//!
//! ```text
//! w_p = 1/(p s₀) Σ_{i=1}^{p} (½ i − p) s_i w_{p−i},      f_p = k x_p − k l Σ_{i=0}^{p} w_i x_{p−i}
//! ```
//!
//! so that those of order p are linear in x_p, as the tangent is.

use super::spring::SpringGroup;
use crate::element::power_series::{KnownOrders, PowerSeries};
use crate::element::{ElementGroup, GroupPoint, Nodal};
use crate::{Mat3, Vec3};

impl PowerSeries for SpringGroup {
    fn stored_stresses(&self, _: usize) -> usize {
        0
    }

    fn forces_of_order(&self, known: &KnownOrders, _: &mut [f64], forces: &mut [f64]) {
        let (mut x, mut w) = (Vec::new(), Vec::new());
        for (spring, out) in self.springs().zip(forces.chunks_exact_mut(3 * self.vectors_per_element())) {
            let Some((weights, [stiffness, free])) = spring.linear() else { continue };
            x.clear();
            x.push(spring.at(known.reference, known.u));
            x.extend(known.coefficients.iter().map(|field| spring.change_of_points(weights, field)));
            // Of the order sought only the vector is unknown.
            x.push(Vec3::zeros());
            let force =
                if free == 0.0 { Vec3::zeros() } else { inverse_length(&x, &mut w) * (-stiffness * free) };
            out.chunks_exact_mut(3)
                .zip(weights)
                .for_each(|(out, weight)| out.copy_from_slice((force * *weight).as_slice()));
        }
    }

    fn tangent_products(&self, k: &GroupPoint, field: &[Nodal], forces: &mut [f64]) {
        for (spring, out) in self.springs().zip(forces.chunks_exact_mut(3 * self.vectors_per_element())) {
            let Some((weights, [stiffness, free])) = spring.linear() else { continue };
            let force = tangent(&spring.now(k), [stiffness, free]) * spring.change_of_points(weights, field);
            out.chunks_exact_mut(3)
                .zip(weights)
                .for_each(|(out, weight)| out.copy_from_slice((force * *weight).as_slice()));
        }
    }
}

/// Highest coefficient of `x/|x|`, from those of x; `w` becomes the coefficients of `1/|x|`.
fn inverse_length(x: &[Vec3], w: &mut Vec<f64>) -> Vec3 {
    let square = |p: usize| (0..=p).map(|i| x[i].dot(&x[p - i])).sum::<f64>();
    let squares: Vec<f64> = (0..x.len()).map(square).collect();
    w.clear();
    w.push(1.0 / squares[0].sqrt());
    for p in 1..x.len() {
        let terms = (1..=p).map(|i| (0.5 * i as f64 - p as f64) * squares[i] * w[p - i]);
        let next = terms.sum::<f64>() / (p as f64 * squares[0]);
        w.push(next);
    }
    let highest = x.len() - 1;
    (0..=highest).map(|i| x[highest - i] * w[i]).sum()
}

/// Stiffness of a spring against changes of the vector between its points.
fn tangent(x: &Vec3, [stiffness, free]: [f64; 2]) -> Mat3 {
    if free == 0.0 {
        return Mat3::identity() * stiffness;
    }
    let length = x.norm();
    let axis = x / length;
    let along = axis * axis.transpose();
    (along + (Mat3::identity() - along) * (1.0 - free / length)) * stiffness
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Coefficients of `x/|x|` are those of its Taylor polynomial: the polynomial misses the value by a term of the next order.
    #[test]
    fn coefficients_of_a_direction_are_those_of_its_taylor_polynomial() {
        let x = [
            Vec3::new(1.0, -2.0, 0.5),
            Vec3::new(0.3, 0.7, -0.2),
            Vec3::new(-0.4, 0.1, 0.6),
            Vec3::new(0.2, -0.3, 0.1),
        ];
        let at = |a: f64| x.iter().rev().fold(Vec3::zeros(), |sum, c| sum * a + c);
        let mut w = Vec::new();
        let coefficients: Vec<Vec3> = (1..=9)
            .map(|orders| {
                let padded: Vec<Vec3> = (0..orders).map(|i| x.get(i).copied().unwrap_or_default()).collect();
                inverse_length(&padded, &mut w)
            })
            .collect();
        let error = |a: f64| {
            let sum = coefficients.iter().rev().fold(Vec3::zeros(), |sum, c| sum * a + c);
            (sum - at(a).normalize()).norm()
        };
        let order = (error(0.2) / error(0.1)).log2();
        assert!((order - 9.0).abs() < 0.3 && error(0.1) < 1e-8, "{order} {}", error(0.1));
    }
}
