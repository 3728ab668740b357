//! Modes of a model that turns at a constant angular velocity, about its relative equilibrium.
//!
//! In the frame that turns with the model, with the generator A of the rotation ([`crate::load::CentrifugalLoad`]), small motions satisfy
//!
//! ```text
//! M ü + 2 M A u̇ + (K + M A²) u = 0,
//! ```
//!
//! where K is the tangent at the equilibrium under centrifugal forces, whose stiffness is M A². The gyroscopic matrix `G = 2 M A` is skew: the
//! [modes](super::complex_modes) are complex.

use super::problem::Problem;
use crate::Vec3;
use crate::element::Nodal;
use crate::system::{System, VectorKind};

/// Part of the motion across the axis that turns in one sense, from which on the mode whirls in this sense; and least part of the
/// motion across the axis in the whole one.
const PURE: f64 = 0.99;
const ACROSS: f64 = 1e-6;
/// Distance from the axis over the size of the model from which on a point is beside it.
const BESIDE: f64 = 1e-3;

/// Rotation of the model about an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Spin {
    /// Direction of the axis, of length 1.
    pub axis: Vec3,
    /// Point of the axis (length).
    pub at: Vec3,
    /// Angular velocity [rad/time].
    pub omega: f64,
    /// Whether the ground turns with the model.
    pub with_ground: bool,
}

impl Spin {
    /// Rotation of a model with centrifugal loads at a time.
    pub fn of(system: &System, time: f64) -> Option<Self> {
        let first = system.centrifugal.first()?;
        let square =
            |load: &crate::load::CentrifugalLoad| system.factor(&load.factor, time) * load.velocity.powi(2);
        let sum: f64 = system.centrifugal.iter().map(square).sum();
        let omega = sum.max(0.0).sqrt() * first.velocity.signum();
        Some(Self { axis: first.axis, at: first.at, omega, with_ground: first.with_ground })
    }
}

/// `G x = 2 M A x` in the free degrees of freedom.
pub(super) fn gyroscopic(problem: &Problem, spin: &Spin, x: &[f64]) -> Vec<f64> {
    let Problem { system, newton, .. } = problem;
    let frames = &newton.assembly.frames;
    let mut field = vec![[0.0; 3]; system.vectors()];
    frames.expand(x, &mut field);
    for v in &mut field {
        *v = (spin.axis.cross(&Vec3::from(*v)) * spin.omega).into();
    }
    let (mut forces, mut out) = (vec![[0.0; 3]; field.len()], vec![0.0; x.len()]);
    system.pattern.add_mass_product(2.0, &field, &mut forces);
    frames.reduce(&forces, &mut out);
    out
}

/// Circular frequency in the fixed frame of a motion that whirls in one sense. With the axes e₁, e₂ across the axis of rotation the motion
/// is `Z = a e^{iωt} + b e^{−iωt}`, Z = u₁ + i u₂, to which the rotation adds the factor `e^{iΩt}`. Displacements count, and rotations of bodies.
pub(super) fn fixed_frame(problem: &Problem, spin: &Spin, shape: [&[Nodal]; 2], omega: f64) -> Option<f64> {
    let Problem { system, newton, .. } = problem;
    let first = spin.axis.cross(&Vec3::ith(spin.axis.iamin(), 1.0)).normalize();
    let axes = [first, spin.axis.cross(&first), spin.axis];
    let [mut forward, mut backward, mut along] = [0.0; 3];
    // Motions along the axis of points beside it: sums, sum of squares, number.
    let mut beside = [0.0; 4];
    let mut count = |motion: [Vec3; 2]| {
        let [x, y] = motion.map(|u| axes.map(|e| e.dot(&u)));
        // a = (u₁ + i u₂)/2 and b* = (u₁ − i u₂)/2 with the complex amplitudes u = x + i y.
        forward += (x[0] - y[1]).powi(2) + (y[0] + x[1]).powi(2);
        backward += (x[0] + y[1]).powi(2) + (y[0] - x[1]).powi(2);
        along += x[2].powi(2) + y[2].powi(2);
    };
    for v in (0..system.vectors()).filter(|v| system.coordinates.kinds[*v] == VectorKind::Position) {
        let motion = shape.map(|field| Vec3::from(field[v]));
        count(motion);
        let arm = Vec3::from(system.coordinates.reference[v]) + Vec3::from(problem.state.u[v]) - spin.at;
        if spin.axis.cross(&arm).norm() > BESIDE * system.length {
            let [x, y] = motion.map(|u| spin.axis.dot(&u));
            for (sum, term) in beside.iter_mut().zip([x, y, x * x + y * y, 1.0]) {
                *sum += term;
            }
        }
    }
    for (directors, arms) in newton.assembly.frames.triads() {
        let turned = |field: &[Nodal]| {
            let parts = (0..3).map(|i| arms.column(i).cross(&Vec3::from(field[directors[i] as usize])));
            parts.sum::<Vec3>() * (0.5 * system.length)
        };
        count(shape.map(turned));
    }
    let across = forward + backward;
    let [x, y, squares, number] = beside;
    // Nodal diameters: the pattern around the axis, which turns with the model, decides about the frequency.
    let uniform = x * x + y * y >= PURE * number * squares;
    if squares > (1.0 - PURE) * (across + along) && !uniform {
        return None;
    }
    let whirls = across > ACROSS * (across + along);
    let turn = spin.omega.abs();
    match whirls {
        false => Some(omega),
        true if forward >= PURE * across => Some(turn + spin.omega.signum() * omega),
        true if backward >= PURE * across => Some(turn - spin.omega.signum() * omega),
        true => None,
    }
}
