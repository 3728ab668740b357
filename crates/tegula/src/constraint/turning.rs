//! Angles in constraints: a displacement that is a multiple of a relative angle, as those of screws and racks are.
//!
//! The angle `φ = atan2(g, h)` of two quadratic forms is known up to full turns. In the constraint `z + c φ = 0` the displacement z, which
//! is a form of its own, tells how many they are: the angle is the one that is nearest to −z/c, and no turn is ever lost.
//!
//! In the energy–momentum scheme the gradient is that of the change of the angle in a step,
//!
//! ```text
//! w = ½ (h₀ + h₁) ∂g − ½ (g₀ + g₁) ∂h,   w·(q₁ − q₀) = h₀ g₁ − g₀ h₁ = ρ₀ ρ₁ sin Δφ,   ρ² = g² + h²
//! ∂φ = Δφ/(ρ₀ ρ₁ sin Δφ) w
//! ```
//!
//! with ∂g and ∂h in the middle of the step: `∂φ·(q₁ − q₀) = Δφ` exactly, so that the constraint forces do no work (O. Gonzalez, *Mechanical
//! systems subject to holonomic constraints: differential-algebraic formulations and conservative integration*, Physica D 132 (1999)
//! 165–174). The forms do not change in rigid motions, so that momenta are conserved.

use super::Row;
use super::joint::{Few, MOST_VECTORS};
use super::joints::{LARGEST_TURN, RelativeAngle};
use crate::Vec3;

/// Multiple of an angle that a constraint contains beside its form.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Turning {
    /// Factor c of the angle (length per rad).
    pub factor: f64,
    /// Form g, the sine of the angle.
    pub sine: Row,
    /// Form h, the cosine of the angle.
    pub cosine: Row,
}

impl Turning {
    fn forms(&self, v: &[Vec3]) -> [f64; 2] {
        [self.sine.form(v), self.cosine.form(v)]
    }

    /// Angle that is nearest to the one at which the constraint would hold.
    fn angle(&self, form: f64, forms: [f64; 2]) -> f64 {
        RelativeAngle::continued(-form / self.factor, forms)
    }

    /// Multiple of the angle, where the form of the constraint has this value.
    pub fn value(&self, form: f64, v: &[Vec3]) -> f64 {
        self.factor * self.angle(form, self.forms(v))
    }

    /// Adds a multiple of the gradient in the middle `v` of a motion that ends at `v + half` and starts at `v − half`.
    pub fn add_gradient(
        &self,
        factor: f64,
        (row, v): (&Row, &[Vec3]),
        half: impl Fn(usize) -> Vec3,
        out: &mut [Vec3],
    ) {
        let at = |sign: f64| -> Few {
            std::array::from_fn(|i| v.get(i).map_or_else(Vec3::zeros, |x| x + half(i) * sign))
        };
        let [before, after] = [at(-1.0), at(1.0)];
        let [[g0, h0], [g1, h1]] = [&before, &after].map(|v| self.forms(v));
        let change = self.angle(row.form(&after), [g1, h1]) - self.angle(row.form(&before), [g0, h0]);
        let sizes = g0.hypot(h0) * g1.hypot(h1);
        // Near π the gradient has no limit: NaN lets the step be cut back.
        let scale = if change.abs() <= LARGEST_TURN { 1.0 / sinc(change) } else { f64::NAN } / sizes;
        let scale = 0.5 * factor * self.factor * scale;
        self.sine.add_gradient((h0 + h1) * scale, v, 0.0, out);
        self.cosine.add_gradient(-(g0 + g1) * scale, v, 0.0, out);
    }

    /// Second derivatives of atan2(g, h) by g and g, and by g and h; that by h and h is minus the first.
    fn curvature([g, h]: [f64; 2]) -> [f64; 2] {
        let square = g * g + h * h;
        [-2.0 * g * h, g * g - h * h].map(|x| x / (square * square))
    }

    /// Adds a multiple of the second derivative to the lower blocks of a joint.
    pub fn add_second_derivative(&self, factor: f64, v: &[Vec3], blocks: &mut [f64]) {
        let [g, h] = self.forms(v);
        let (square, factor) = (g * g + h * h, factor * self.factor);
        let [gg, gh] = Self::curvature([g, h]).map(|x| x * factor);
        let [of_g, of_h] = [&self.sine, &self.cosine].map(|form| {
            let mut out = [Vec3::zeros(); MOST_VECTORS];
            form.add_gradient(1.0, v, 0.0, &mut out);
            out
        });
        let mut block = blocks.chunks_exact_mut(9);
        for a in 0..v.len() {
            for b in 0..=a {
                let Some(out) = block.next() else { break };
                let sum = (of_g[a] * of_g[b].transpose() - of_h[a] * of_h[b].transpose()) * gg
                    + (of_g[a] * of_h[b].transpose() + of_h[a] * of_g[b].transpose()) * gh;
                out.iter_mut().enumerate().for_each(|(i, out)| *out += sum[(i / 3, i % 3)]);
            }
        }
        self.sine.add_second_derivative(factor * h / square, 0.0, blocks);
        self.cosine.add_second_derivative(-factor * g / square, 0.0, blocks);
    }

    /// Part of the second rate that follows from the velocities alone.
    pub fn velocity_term(&self, v: &[Vec3], rates: &[Vec3]) -> f64 {
        let [g, h] = self.forms(v);
        let [g_rate, h_rate] = [&self.sine, &self.cosine].map(|form| form.form_rate(v, rates));
        let [g_term, h_term] = [&self.sine, &self.cosine].map(|form| form.form_velocity_term(rates));
        let [gg, gh] = Self::curvature([g, h]);
        let of_rates = gg * (g_rate * g_rate - h_rate * h_rate) + 2.0 * gh * g_rate * h_rate;
        self.factor * ((h * g_term - g * h_term) / (g * g + h * h) + of_rates)
    }
}

/// sin x/x.
pub(super) fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-4 { 1.0 - x * x / 6.0 } else { x.sin() / x }
}
