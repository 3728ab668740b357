//! Constraints that keep a point on a curve.
//!
//! The curve c(u) is fixed in one side of the joint, along whose axes the point of the other side has the coordinates y; these are
//! quadratic forms of the nodal vectors. With the nearest point of the curve, `c'·(y − c) = 0`, and two unit normals n₁ and n₂ there the
//! constraints are
//!
//! ```text
//! n_k·(y − c(u(y))) = 0,   gradient n_k·∂y,   ∂²: n_k·∂²y − (n_k·c'')/|c'|⁴ (c'·∂y)(c'·∂y)ᵀ
//! second rate: n_k·ÿ − (n_k·c'') u̇²,   u̇ = c'·ẏ/|c'|²
//! ```
//!
//! where the constraints hold. Terms by which the normals turn about the tangent are left out of ∂²: they mix both multipliers and vanish for motions
//! along the curve. u is found anew in each evaluation and is no part of the state.
//!
//! In the energy–momentum scheme the forces act across the chord of the step: n₁ and n₂ are perpendicular to `y₁ − y₀`, and the gradients
//! of the forms are those in the middle, so that `n_k·∂y (q₁ − q₀) = n_k·(y₁ − y₀) = 0` exactly. The constraint forces do no work, and the
//! forms do not change in rigid motions, so that energy and momenta are conserved, as with the discrete gradient of O. Gonzalez
//! (Physica D 132 (1999) 165–174), whose correction along the step removes the same component.

use std::sync::Arc;

use super::Row;
use super::joint::{Few, MOST_VECTORS};
use super::spline::{CurvePoint, Spline};
use crate::Vec3;

/// Chord over the length of the curve, below which its direction is that of the tangent: round-off would turn it.
const SHORT: f64 = 1e-6;

/// One of the two constraints of a point on a curve.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct OnCurve {
    /// Curve in the coordinates of the side in which it is fixed.
    pub curve: Arc<Spline>,
    /// Coordinates y of the point.
    pub coordinates: [Row; 3],
    /// Number of the normal along which the constraint acts.
    pub normal: usize,
}

impl OnCurve {
    fn place(&self, v: &[Vec3]) -> Vec3 {
        Vec3::from(self.coordinates.each_ref().map(|form| form.form(v)))
    }

    /// Nearest point of the curve.
    fn nearest(&self, v: &[Vec3]) -> CurvePoint {
        self.curve.nearest(&self.place(v))
    }

    /// Unit vector across a direction near the tangent.
    fn across(&self, at: &CurvePoint, direction: &Vec3) -> Vec3 {
        let first = (at.normal - direction * at.normal.dot(direction)).normalize();
        if self.normal == 0 { first } else { direction.cross(&first) }
    }

    fn normal_at(&self, at: &CurvePoint) -> Vec3 {
        self.across(at, &at.derivatives[0].normalize())
    }

    fn add_along(&self, direction: &Vec3, v: &[Vec3], out: &mut [Vec3]) {
        for (form, component) in self.coordinates.iter().zip(direction.iter()) {
            form.add_gradient(*component, v, 0.0, out);
        }
    }

    /// Distance of the point from the curve along the normal.
    pub fn value(&self, v: &[Vec3]) -> f64 {
        let place = self.place(v);
        let at = self.curve.nearest(&place);
        self.normal_at(&at).dot(&(place - at.position))
    }

    /// Parameter of the nearest point of the curve.
    pub fn parameter(&self, v: &[Vec3]) -> f64 {
        self.nearest(v).parameter
    }

    /// Adds a multiple of the gradient in the middle `v` of a motion that ends at `v + half` and starts at `v − half`.
    pub fn add_gradient(&self, factor: f64, v: &[Vec3], half: impl Fn(usize) -> Vec3, out: &mut [Vec3]) {
        let at = |sign: f64| -> Few {
            std::array::from_fn(|i| v.get(i).map_or_else(Vec3::zeros, |x| x + half(i) * sign))
        };
        let [before, after] = [-1.0, 1.0].map(|sign| self.place(&at(sign)));
        let near = self.curve.nearest(&((before + after) * 0.5));
        let chord = after - before;
        let normal = if chord.norm() > SHORT * self.curve.length() {
            // Either sense of the chord has the same normals.
            let sense = chord.dot(&near.derivatives[0]).signum();
            self.across(&near, &(chord * (sense / chord.norm())))
        } else {
            self.normal_at(&near)
        };
        self.add_along(&(normal * factor), v, out);
    }

    /// Adds a multiple of the second derivative to the lower blocks of a joint.
    pub fn add_second_derivative(&self, factor: f64, v: &[Vec3], blocks: &mut [f64]) {
        let at = self.nearest(v);
        let [first, second] = at.derivatives;
        let normal = self.normal_at(&at);
        for (form, component) in self.coordinates.iter().zip(normal.iter()) {
            form.add_second_derivative(factor * component, 0.0, blocks);
        }
        let mut along = [Vec3::zeros(); MOST_VECTORS];
        self.add_along(&(first / first.norm_squared()), v, &mut along);
        let bent = -factor * normal.dot(&second);
        let mut block = blocks.chunks_exact_mut(9);
        for a in 0..v.len() {
            for b in 0..=a {
                let Some(out) = block.next() else { break };
                let product = along[a] * along[b].transpose() * bent;
                out.iter_mut().enumerate().for_each(|(i, out)| *out += product[(i / 3, i % 3)]);
            }
        }
    }

    /// Part of the second rate that follows from the velocities alone.
    pub fn velocity_term(&self, v: &[Vec3], rates: &[Vec3]) -> f64 {
        let at = self.nearest(v);
        let [first, second] = at.derivatives;
        let [rate, term] = [
            Vec3::from(self.coordinates.each_ref().map(|form| form.form_rate(v, rates))),
            Vec3::from(self.coordinates.each_ref().map(|form| form.form_velocity_term(rates))),
        ];
        let along = first.dot(&rate) / first.norm_squared();
        self.normal_at(&at).dot(&(term - second * (along * along)))
    }
}
