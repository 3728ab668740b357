//! Angles in constraints: a displacement that is a multiple of a relative angle, as those of screws and racks are, and two angles of a
//! constant ratio, as those of gears are.
//!
//! The angle `φ = atan2(g, h)` of two quadratic forms is known up to full turns. In the constraint `z + c φ = 0` the displacement z, which
//! is a form of its own, tells how many they are: the angle is the one that is nearest to −z/c, and no turn is ever lost. In that of a gear,
//! `c₁ φ₁ + c φ = o`, the first angle is the one nearest to its value at the end of the step before, which belongs to the state, and the
//! second one is that nearest to (o − c₁ φ₁)/c. The ratio need not be a rational number. The constant o is 0 until gears mesh anew, see
//! [`Turning::mesh`].
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

/// Angle `atan2(g, h)` of two forms of the nodal vectors of a joint.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Angle {
    /// Form g, the sine of the angle.
    pub sine: Row,
    /// Form h, the cosine of the angle.
    pub cosine: Row,
}

/// Multiples of angles that a constraint contains beside its form.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Turning {
    /// Factor c of the angle (length per rad, or a number for gears).
    pub factor: f64,
    /// Angle whose turns follow from the constraint.
    pub angle: Angle,
    /// Angle of the first gear.
    pub counted: Option<Counted>,
}

/// Angle whose turns the state counts.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Counted {
    /// Factor c₁ of the angle.
    pub factor: f64,
    /// Angle φ₁.
    pub angle: Angle,
    /// Sum o of both multiples (rad).
    pub offset: f64,
}

impl Angle {
    fn forms(&self, v: &[Vec3]) -> [f64; 2] {
        [self.sine.form(v), self.cosine.form(v)]
    }

    /// Adds a multiple of the gradient of the change of the angle by `change` in a motion with the middle v, and these forms at its start
    /// and its end.
    fn add_gradient(
        &self,
        factor: f64,
        change: f64,
        (v, [[g0, h0], [g1, h1]]): (&[Vec3], [[f64; 2]; 2]),
        out: &mut [Vec3],
    ) {
        let sizes = g0.hypot(h0) * g1.hypot(h1);
        // Near π the gradient has no limit: NaN lets the step be cut back.
        let scale = if change.abs() <= LARGEST_TURN { 1.0 / sinc(change) } else { f64::NAN } / sizes;
        let scale = 0.5 * factor * scale;
        self.sine.add_gradient((h0 + h1) * scale, v, 0.0, out);
        self.cosine.add_gradient(-(g0 + g1) * scale, v, 0.0, out);
    }

    /// Second derivatives of atan2(g, h) by g and g, and by g and h; that by h and h is minus the first.
    fn curvature([g, h]: [f64; 2]) -> [f64; 2] {
        let square = g * g + h * h;
        [-2.0 * g * h, g * g - h * h].map(|x| x / (square * square))
    }

    /// Adds a multiple of the second derivative to the lower blocks of a joint.
    fn add_second_derivative(&self, factor: f64, v: &[Vec3], blocks: &mut [f64]) {
        let [g, h] = self.forms(v);
        let square = g * g + h * h;
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
    fn velocity_term(&self, v: &[Vec3], rates: &[Vec3]) -> f64 {
        let [g, h] = self.forms(v);
        let [g_rate, h_rate] = [&self.sine, &self.cosine].map(|form| form.form_rate(v, rates));
        let [g_term, h_term] = [&self.sine, &self.cosine].map(|form| form.form_velocity_term(rates));
        let [gg, gh] = Self::curvature([g, h]);
        let of_rates = gg * (g_rate * g_rate - h_rate * h_rate) + 2.0 * gh * g_rate * h_rate;
        (h * g_term - g * h_term) / (g * g + h * h) + of_rates
    }
}

impl Turning {
    /// Multiples of the angles, where the form of the constraint has this value and the first angle of a gear had the value `earlier` at
    /// the end of the step before.
    pub fn value(&self, form: f64, v: &[Vec3], earlier: f64) -> f64 {
        let counted = self.counted.as_ref().map_or(0.0, |first| {
            first.factor * RelativeAngle::continued(earlier, first.angle.forms(v)) - first.offset
        });
        // The angle is the one that is nearest to that at which the constraint would hold.
        let nearest = -(form + counted) / self.factor;
        counted + self.factor * RelativeAngle::continued(nearest, self.angle.forms(v))
    }

    /// Lets gears mesh where they stand: the first angle had the value `earlier`.
    pub fn mesh(&mut self, v: &[Vec3], earlier: f64) {
        let [g, h] = self.angle.forms(v);
        if let Some(first) = &mut self.counted {
            let angle = RelativeAngle::continued(earlier, first.angle.forms(v));
            first.offset = first.factor * angle + self.factor * g.atan2(h);
        }
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
        let ends = [at(-1.0), at(1.0)];
        let forms = |angle: &Angle| [angle.forms(&ends[0]), angle.forms(&ends[1])];
        let change = |[[g0, h0], [g1, h1]]: [[f64; 2]; 2]| {
            RelativeAngle::continued(g0.atan2(h0), [g1, h1]) - g0.atan2(h0)
        };
        let own = forms(&self.angle);
        let own_change = if let Some(Counted { factor: of_angle, angle, .. }) = &self.counted {
            let first = forms(angle);
            angle.add_gradient(factor * of_angle, change(first), (v, first), out);
            change(own)
        } else {
            let [before, after] =
                [0, 1].map(|i| RelativeAngle::continued(-row.form(&ends[i]) / self.factor, own[i]));
            after - before
        };
        self.angle.add_gradient(factor * self.factor, own_change, (v, own), out);
    }

    /// Adds a multiple of the second derivative to the lower blocks of a joint.
    pub fn add_second_derivative(&self, factor: f64, v: &[Vec3], blocks: &mut [f64]) {
        for (of_angle, angle) in self.angles() {
            angle.add_second_derivative(factor * of_angle, v, blocks);
        }
    }

    /// Part of the second rate that follows from the velocities alone.
    pub fn velocity_term(&self, v: &[Vec3], rates: &[Vec3]) -> f64 {
        self.angles().map(|(factor, angle)| factor * angle.velocity_term(v, rates)).sum()
    }

    /// Angles with their factors.
    fn angles(&self) -> impl Iterator<Item = (f64, &Angle)> {
        let counted = self.counted.iter().map(|first| (first.factor, &first.angle));
        counted.chain([(self.factor, &self.angle)])
    }
}

/// sin x/x.
pub(super) fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-4 { 1.0 - x * x / 6.0 } else { x.sin() / x }
}
