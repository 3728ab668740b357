//! Whether follower loads have a potential: their skew stiffness vanishes in the motions that supports and joints leave.
//!
//! With the gradients G of the constraints, in unknowns without a unit, these motions are the range of `P = I − Gᵀ (G Gᵀ)⁻¹ G`, and the loads have a
//! potential where `P N P` is round-off: pressures on surfaces whose edges are held across them, also by bodies on joints, and moments about the axes
//! of hinges.

use super::constraints::{Schur, gradients_of, product};
use super::equilibrium::{self, unknowns_of};
use crate::element::{Motion, Nodal, TangentWeights};
use crate::norm::{larger, max_norm};
use crate::system::assembly::TangentCoefficients;
use crate::system::{CirculatoryStiffness, EvaluationPoint, LocalFrames, System, VectorKind};

/// Skew load stiffness over the size of the loads per length of the model below which it is round-off.
const WITHOUT_POTENTIAL: f64 = 1e-9;

/// Place at which loads are looked at: displacements, time or load factor, and local frames there.
pub(super) struct Place<'a> {
    pub u: &'a [Nodal],
    pub time: f64,
    pub frames: &'a LocalFrames,
}

/// Whether follower loads with this skew stiffness have a potential at a place. Forces `others` count for the size of the loads, too.
pub(super) fn have_potential(
    system: &System,
    place: &Place,
    mut skew: CirculatoryStiffness,
    others: &[Nodal],
) -> bool {
    let Place { u, time, frames } = place;
    let parts = TangentCoefficients { weights: TangentWeights::STATIC, mass: 0.0, time: *time };
    skew.take(system, &Motion::State { u, velocity: None }, &parts);
    if skew.is_zero() {
        return true;
    }
    let external = equilibrium::external(system, &EvaluationPoint::at_rest(system, u, *time, &[0.0; 0]));
    let size = larger(size_of_forces(system, &external), size_of_forces(system, others));
    let limit = WITHOUT_POTENTIAL * size * system.length;
    let scales = scales(system, frames);
    let mut leave = Motions::new(gradients_of(system, frames, (u, *time)), &scales);
    let (mut x, mut y) = (vec![0.0; scales.len()], vec![0.0; scales.len()]);
    skew.support().iter().all(|&number| {
        x.fill(0.0);
        x[number as usize] = 1.0;
        leave.project(&mut x);
        x.iter_mut().zip(&scales).for_each(|(x, scale)| *x /= scale);
        skew.product(frames, &x, &mut y);
        y.iter_mut().zip(&scales).for_each(|(y, scale)| *y /= scale);
        leave.project(&mut y);
        y.iter().all(|y| y.abs() <= limit)
    })
}

/// Largest force of a field, with moments over the length of the model.
fn size_of_forces(system: &System, forces: &[Nodal]) -> f64 {
    let of_kind = |(force, kind): (&Nodal, &VectorKind)| {
        let arm = if *kind == VectorKind::Position { 1.0 } else { system.length };
        max_norm(force.iter().copied()) / arm
    };
    forces.iter().zip(&system.coordinates.kinds).map(of_kind).fold(0.0, larger)
}

/// Scale of each unknown: 1/length of positions, 1 of directors and rotations.
pub(super) fn scales(system: &System, frames: &LocalFrames) -> Vec<f64> {
    let mut scales = vec![1.0; system.unknowns()];
    for number in unknowns_of(system, frames.dofs(), VectorKind::Position) {
        scales[number as usize] = 1.0 / system.length;
    }
    scales
}

/// Motions that constraints leave, in scaled unknowns.
struct Motions {
    gradients: Vec<Vec<(u32, f64)>>,
    schur: Schur,
    right: Vec<f64>,
    multipliers: Vec<f64>,
}

impl Motions {
    fn new(mut gradients: Vec<Vec<(u32, f64)>>, scales: &[f64]) -> Self {
        let m = gradients.len();
        for (number, entry) in gradients.iter_mut().flatten() {
            *entry /= scales[*number as usize];
        }
        let mut schur = Schur::new(m);
        let mut dense = vec![0.0; scales.len()];
        for (i, gradient) in gradients.iter().enumerate() {
            gradient.iter().for_each(|&(number, entry)| dense[number as usize] += entry);
            for (j, other) in gradients.iter().enumerate() {
                schur.matrix[i * m + j] = product(other, &dense);
            }
            gradient.iter().for_each(|&(number, _)| dense[number as usize] = 0.0);
        }
        if m > 0 {
            schur.factor();
        }
        Self { gradients, schur, right: vec![0.0; m], multipliers: vec![0.0; m] }
    }

    /// Removes from x what the constraints prevent.
    fn project(&mut self, x: &mut [f64]) {
        let Self { gradients, schur, right, multipliers } = self;
        if gradients.is_empty() {
            return;
        }
        right.iter_mut().zip(&*gradients).for_each(|(right, gradient)| *right = product(gradient, x));
        schur.solve(right, &[], multipliers);
        for (gradient, multiplier) in gradients.iter().zip(&*multipliers) {
            gradient.iter().for_each(|&(number, entry)| x[number as usize] -= multiplier * entry);
        }
    }
}
