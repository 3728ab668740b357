//! One scalar constraint: a quadratic form of nodal vectors.

use std::f64::consts::TAU;
use std::sync::Arc;

use super::Attachment;
use super::on_curve::OnCurve;
use super::spline::Spline;
use super::turning::{Angle, Counted, Turning};
use crate::Vec3;
use crate::element::TangentWeights;

/// Scalar constraint `g(v) = Σ C_ab v_a·v_b + Σ c_a·v_a + c₀ = 0` of the nodal vectors v of a joint, which it names by their
/// places in the joint's list.
///
/// The constraint of a driven joint depends on the value s of its drive, too: `g(v) − s` where s is a length, and
/// `g(v) cos s − h(v) sin s` where it is an angle, with a second form h. That of a screw contains a multiple of an angle: `g(v) + c φ(v)`;
/// that of a gear contains two, and s is the first angle at the end of the step before. Those of a point on a curve have its distance from the
/// nearest point of the curve in place of the form.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Row {
    products: Vec<(usize, usize, f64)>,
    linear: Vec<(usize, Vec3)>,
    constant: f64,
    /// How the constraint depends on the drive of the joint.
    driven: Driven,
    /// Parts of the constraint that are no quadratic form.
    other: Option<Box<Other>>,
    /// Form that is positive where the constraint holds as it is meant, and negative half a turn away, where its value vanishes, too.
    positive: Option<Box<Row>>,
    /// Size of the values of the constraint: the length of the model for distances, 1 for products of unit vectors.
    pub size: f64,
    /// Inertia that the constraint acts on \[mass for distances, mass · length² for products of unit vectors\]: weight of
    /// the augmented Lagrangian.
    pub inertia: f64,
    /// Quantity that the constraint keeps.
    pub keeps: Quantity,
    /// Square of the model's length over `size`: weight of the augmented Lagrangian in statics.
    pub measure: f64,
}

/// Quantity that a constraint keeps.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Quantity {
    /// Position along a direction (length).
    #[default]
    Position,
    /// Product of two axes of unit length.
    Axes,
    /// Distance of two points, by half its square less that of this distance (length).
    Distance(f64),
}

/// Part of a constraint that is no quadratic form.
#[derive(Debug, Clone, PartialEq)]
enum Other {
    /// Multiples of angles beside the form.
    Turning(Turning),
    /// Distance from a curve in place of the form, which is zero.
    Curve(OnCurve),
}

/// How a constraint depends on the value s of the drive of its joint.
#[derive(Debug, Clone, PartialEq, Default)]
enum Driven {
    /// Not at all.
    #[default]
    Not,
    /// The form is equal to s.
    Length,
    /// The form times cos s is equal to this form times sin s.
    Angle(Box<Row>),
    /// The angle whose sine is the form, and whose cosine this form, is equal to s.
    Coordinate(Box<Row>),
}

/// Value of a drive with its first and second rate.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DriveValue {
    /// Angle (rad) or length.
    pub value: f64,
    /// Rate per time.
    pub rate: f64,
    /// Second rate per time².
    pub acceleration: f64,
}

impl Row {
    /// Whether the constraint drives an angle.
    pub fn is_driven_angle(&self) -> bool {
        matches!(self.driven, Driven::Angle(_))
    }

    /// Makes the form equal to the drive's value.
    pub fn drive_length(&mut self) {
        self.driven = Driven::Length;
    }

    /// Makes `g cos s − h sin s = 0`, with this form g and the drive's value s.
    pub fn drive_angle(&mut self, h: Row) {
        self.driven = Driven::Angle(Box::new(h));
    }

    /// Adds `factor · φ` with the angle φ that has this sine and cosine and counts full turns: the form is a displacement that is
    /// proportional to it.
    pub fn turn(&mut self, factor: f64, [sine, cosine]: [Row; 2]) {
        let angle = Angle { sine, cosine };
        self.other = Some(Box::new(Other::Turning(Turning { factor, angle, counted: None })));
    }

    /// Adds `c₁ φ₁ + c₂ φ₂` with the angles that have these sines and cosines and count full turns; the turns of the first one are counted
    /// by the state.
    pub fn gear(&mut self, factors: [f64; 2], forms: [[Row; 2]; 2]) {
        let [first, angle] = forms.map(|[sine, cosine]| Angle { sine, cosine });
        let counted = Some(Counted { factor: factors[0], angle: first, offset: 0.0 });
        self.other = Some(Box::new(Other::Turning(Turning { factor: factors[1], angle, counted })));
    }

    /// Lets a gear mesh where it stands, with the first angle `earlier`; nothing for other constraints.
    pub fn mesh(&mut self, v: &[Vec3], earlier: f64) {
        if let Some(Other::Turning(turning)) = self.other.as_deref_mut() {
            turning.mesh(v, earlier);
        }
    }

    /// Keeps the point with these coordinates on a curve, along one of the curve's two normals.
    pub fn follow_curve(&mut self, curve: &Arc<Spline>, coordinates: [Row; 3], normal: usize) {
        let curve = OnCurve { curve: Arc::clone(curve), coordinates, normal };
        self.other = Some(Box::new(Other::Curve(curve)));
    }

    fn turning(&self) -> Option<&Turning> {
        match self.other.as_deref() {
            Some(Other::Turning(turning)) => Some(turning),
            _ => None,
        }
    }

    fn curve(&self) -> Option<&OnCurve> {
        match self.other.as_deref() {
            Some(Other::Curve(curve)) => Some(curve),
            _ => None,
        }
    }

    /// Whether the constraint keeps a point on a curve.
    pub fn follows_curve(&self) -> bool {
        self.curve().is_some()
    }

    /// Curve on which the constraint keeps a point, with the parameter of its point that is nearest now.
    pub fn place_on_curve(&self, v: &[Vec3]) -> Option<(&Spline, f64)> {
        self.curve().map(|curve| (&*curve.curve, curve.parameter(v)))
    }

    /// Makes the angle `atan2(g, h)` equal to a value, with this form g.
    pub fn measure_angle(&mut self, h: Row) {
        self.driven = Driven::Coordinate(Box::new(h));
    }

    /// Excludes the configurations in which a form of the same nodal vectors is not positive.
    pub fn keep_positive(&mut self, form: Row) {
        self.positive = Some(Box::new(form));
    }

    /// Constraint `(a − b)·e = 0` of two points along a fixed direction of space.
    pub fn coincident(vectors: &mut Vec<u32>, a: &Attachment, b: &Attachment, e: &Vec3) -> Self {
        let mut row = Self { constant: (a.constant - b.constant).dot(e), ..Self::default() };
        for (list, sign) in [(&a.terms, 1.0), (&b.terms, -1.0)] {
            for &(v, w) in list {
                row.linear.push((place(vectors, v), e * (sign * w)));
            }
        }
        row
    }

    /// Adds `factor · a·b`, the product of two points or axes.
    pub fn add_product(&mut self, vectors: &mut Vec<u32>, factor: f64, a: &Attachment, b: &Attachment) {
        self.constant += factor * a.constant.dot(&b.constant);
        for (list, other) in [(a, b), (b, a)] {
            for &(v, w) in &list.terms {
                self.linear.push((place(vectors, v), other.constant * (factor * w)));
            }
        }
        for &(v, w) in &a.terms {
            for &(x, y) in &b.terms {
                self.products.push((place(vectors, v), place(vectors, x), factor * w * y));
            }
        }
    }

    /// Adds a constant.
    pub fn add_constant(&mut self, value: f64) {
        self.constant += value;
    }

    /// Value of the constraint, where its drive has the value `s`, or the first angle of a gear had it at the end of the step before.
    pub fn value(&self, v: &[Vec3], s: f64) -> f64 {
        if let Some(curve) = self.curve() {
            return curve.value(v);
        }
        let form = self.form(v);
        match &self.driven {
            Driven::Not => form + self.turning().map_or(0.0, |turning| turning.value(form, v, s)),
            Driven::Length => form - s,
            Driven::Angle(other) => form * s.cos() - other.form(v) * s.sin(),
            Driven::Coordinate(other) => {
                let difference = form.atan2(other.form(v)) - s;
                difference - TAU * (difference / TAU).round()
            }
        }
    }

    /// Value that a drive has where the joint stands: the angle between −π and π, or the length.
    pub fn driven_value(&self, v: &[Vec3]) -> f64 {
        match &self.driven {
            Driven::Not => 0.0,
            Driven::Length => self.form(v),
            Driven::Angle(other) | Driven::Coordinate(other) => self.form(v).atan2(other.form(v)),
        }
    }

    /// Whether an angle is that of the drive, or an axis points the right way, and not half a turn away from it, where the constraint
    /// vanishes, too.
    pub fn is_on_branch(&self, v: &[Vec3], s: f64) -> bool {
        if self.positive.as_ref().is_some_and(|form| form.form(v) <= 0.0) {
            return false;
        }
        match &self.driven {
            Driven::Angle(other) => self.form(v) * s.sin() + other.form(v) * s.cos() > 0.0,
            Driven::Not | Driven::Length | Driven::Coordinate(_) => true,
        }
    }

    /// Whether the constraint is a quadratic form of the nodal vectors alone.
    pub fn is_quadratic(&self) -> bool {
        self.other.is_none() && self.driven == Driven::Not
    }

    /// Second derivative `x·g″ y` of the quadratic form along two changes of the nodal vectors.
    pub fn second_derivative(&self, x: &[Vec3], y: &[Vec3]) -> f64 {
        self.products.iter().map(|&(a, b, c)| c * (x[a].dot(&y[b]) + x[b].dot(&y[a]))).sum()
    }

    /// Adds `factor · g″ x`, the change of the gradient of the quadratic form with a change of the nodal vectors.
    pub fn add_change_of_gradient(&self, factor: f64, x: &[Vec3], out: &mut [Vec3]) {
        for &(a, b, c) in &self.products {
            out[a] += x[b] * (factor * c);
            out[b] += x[a] * (factor * c);
        }
    }

    /// Value of the quadratic form.
    pub fn form(&self, v: &[Vec3]) -> f64 {
        let products: f64 = self.products.iter().map(|&(a, b, c)| c * v[a].dot(&v[b])).sum();
        products + self.linear.iter().map(|(a, c)| c.dot(&v[*a])).sum::<f64>() + self.constant
    }

    /// Adds `factor · ∂g/∂v` to the gradient of each nodal vector, where the drive has the value `s`.
    pub fn add_gradient(&self, factor: f64, v: &[Vec3], s: f64, out: &mut [Vec3]) {
        match &self.driven {
            Driven::Not | Driven::Length => {
                self.add_form_gradient(factor, v, out);
                if let Some(turning) = self.turning() {
                    turning.add_gradient(factor, (self, v), |_| Vec3::zeros(), out);
                }
                if let Some(curve) = self.curve() {
                    curve.add_gradient(factor, v, |_| Vec3::zeros(), out);
                }
            }
            Driven::Angle(other) => {
                self.add_form_gradient(factor * s.cos(), v, out);
                other.add_form_gradient(-factor * s.sin(), v, out);
            }
            Driven::Coordinate(other) => {
                let (g, h) = (self.form(v), other.form(v));
                let scale = factor / (g * g + h * h);
                self.add_form_gradient(scale * h, v, out);
                other.add_form_gradient(-scale * g, v, out);
            }
        }
    }

    /// Adds a multiple of the gradient by which the constraint acts over a motion with the middle `v`, which ends at `v + half` for the
    /// vectors by their places: its product with the motion is the change of the constraint. For a quadratic form it is the gradient in
    /// the middle.
    pub fn add_acting_gradient(
        &self,
        factor: f64,
        (v, half): (&[Vec3], impl Fn(usize) -> Vec3),
        s: f64,
        out: &mut [Vec3],
    ) {
        match self.other.as_deref() {
            None => self.add_gradient(factor, v, s, out),
            Some(Other::Turning(turning)) => {
                self.add_form_gradient(factor, v, out);
                turning.add_gradient(factor, (self, v), half, out);
            }
            Some(Other::Curve(curve)) => curve.add_gradient(factor, v, half, out),
        }
    }

    /// Weight γ of the constraint in the augmented Lagrangian.
    pub fn weight(&self, weights: &TangentWeights) -> f64 {
        weights.augmentation * self.inertia + weights.penalty * self.measure
    }

    /// Adds the second derivative of the multiples of angles that the constraint contains, or of the curve on which it keeps a point.
    pub(crate) fn add_other_second_derivatives(&self, factor: f64, v: &[Vec3], blocks: &mut [f64]) {
        if let Some(turning) = self.turning() {
            turning.add_second_derivative(factor, v, blocks);
        }
        if let Some(curve) = self.curve() {
            curve.add_second_derivative(factor, v, blocks);
        }
    }

    /// Adds `factor · ∂²g/∂v_a∂v_b` of the quadratic forms to the lower blocks of a joint, where the drive has the value `s`. That of a
    /// relative angle is left out: it belongs to schemes whose tangent has no such terms.
    pub fn add_second_derivative(&self, factor: f64, s: f64, blocks: &mut [f64]) {
        let cosine = match &self.driven {
            Driven::Not | Driven::Length => 1.0,
            Driven::Coordinate(_) => return,
            Driven::Angle(other) => {
                other.add_form_second_derivative(-factor * s.sin(), blocks);
                s.cos()
            }
        };
        self.add_form_second_derivative(factor * cosine, blocks);
    }

    fn add_form_second_derivative(&self, factor: f64, blocks: &mut [f64]) {
        for &(a, b, c) in &self.products {
            // A product of a vector with itself has the second derivative 2.
            let value = factor * if a == b { 2.0 * c } else { c };
            let (row, column) = (a.max(b), a.min(b));
            let at = 9 * (row * (row + 1) / 2 + column);
            for i in 0..3 {
                blocks[at + 4 * i] += value;
            }
        }
    }

    fn add_form_gradient(&self, factor: f64, v: &[Vec3], out: &mut [Vec3]) {
        for &(a, b, c) in &self.products {
            out[a] += v[b] * (factor * c);
            out[b] += v[a] * (factor * c);
        }
        for (a, c) in &self.linear {
            out[*a] += c * factor;
        }
    }

    /// Part `∂g/∂t` of the rate of the constraint that its drive makes.
    pub fn driven_rate(&self, v: &[Vec3], s: DriveValue) -> f64 {
        match &self.driven {
            Driven::Not => 0.0,
            Driven::Length | Driven::Coordinate(_) => -s.rate,
            Driven::Angle(other) => -s.rate * (self.form(v) * s.value.sin() + other.form(v) * s.value.cos()),
        }
    }

    /// Part of the second rate of the constraint that follows from the velocities and the drive alone.
    pub fn velocity_term(&self, v: &[Vec3], rates: &[Vec3], s: DriveValue) -> f64 {
        if let Some(curve) = self.curve() {
            return curve.velocity_term(v, rates);
        }
        match &self.driven {
            Driven::Not => {
                let of_angle = self.turning().map_or(0.0, |turning| turning.velocity_term(v, rates));
                self.form_velocity_term(rates) + of_angle
            }
            Driven::Length => self.form_velocity_term(rates) - s.acceleration,
            Driven::Angle(other) => {
                let (sine, cosine) = s.value.sin_cos();
                let [g, h] = [self.form(v), other.form(v)];
                let [g_rate, h_rate] = [self.form_rate(v, rates), other.form_rate(v, rates)];
                self.form_velocity_term(rates) * cosine
                    - other.form_velocity_term(rates) * sine
                    - 2.0 * s.rate * (g_rate * sine + h_rate * cosine)
                    - s.acceleration * (g * sine + h * cosine)
                    - s.rate * s.rate * (g * cosine - h * sine)
            }
            Driven::Coordinate(other) => {
                let [g, h] = [self.form(v), other.form(v)];
                let [g_rate, h_rate] = [self.form_rate(v, rates), other.form_rate(v, rates)];
                let square = g * g + h * h;
                let rate = (h * g_rate - g * h_rate) / square;
                (h * self.form_velocity_term(rates) - g * other.form_velocity_term(rates)) / square
                    - 2.0 * rate * (g * g_rate + h * h_rate) / square
                    - s.acceleration
            }
        }
    }

    /// Rate of the quadratic form.
    pub(super) fn form_rate(&self, v: &[Vec3], rates: &[Vec3]) -> f64 {
        let product = |&(a, b, c): &(usize, usize, f64)| c * (v[a].dot(&rates[b]) + rates[a].dot(&v[b]));
        self.products.iter().map(product).sum::<f64>()
            + self.linear.iter().map(|(a, c)| c.dot(&rates[*a])).sum::<f64>()
    }

    /// Part `2 Σ C_ab v̇_a·v̇_b` of the second rate of the quadratic form.
    pub(super) fn form_velocity_term(&self, rates: &[Vec3]) -> f64 {
        self.products.iter().map(|&(a, b, c)| 2.0 * c * rates[a].dot(&rates[b])).sum()
    }
}

/// Place of a nodal vector in the list of a joint, to which it is added if it is new.
fn place(vectors: &mut Vec<u32>, vector: u32) -> usize {
    vectors.iter().position(|&v| v == vector).unwrap_or_else(|| {
        vectors.push(vector);
        vectors.len() - 1
    })
}
