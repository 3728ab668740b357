//! Joints in the power series of a path: quadratic constraints `g(v) = 0` with their multipliers ν.
//!
//! At order p, with the gradients G at the expansion point and the second derivatives g″ of the constraints,
//!
//! ```text
//! K v_p + Gᵀ ν_p = λ_p F − f_p − Σ_{r=1}^{p−1} ν_r·g″ v_{p−r},     G v_p = −½ Σ_{r=1}^{p−1} v_r·g″ v_{p−r}
//! ```
//!
//! where K contains `ν₀·g″`: each order is a solution with the Schur complement that Newton's method has.
//!
//! The multipliers of an equilibrium follow from its displacements, `Gᵀν = λF − f`, in the sense of least squares: of constraints that depend
//! on each other those of minimum norm, weighed with the compliances of the constraints at the last factored tangent as in Newton's method. So a path
//! carries none from point to point.

use nalgebra::{DMatrix, DVector};

use crate::Vec3;
use crate::analysis::constraints::{Rates, end_of, gradients_of, joint_rates};
use crate::constraint::{DriveValue, Joint};
use crate::element::{Motion, Nodal};
use crate::system::{LocalFrames, System, VectorKind};

/// Eigenvalue or pivot of the normal equations, scaled to a unit diagonal, over the largest one that is round-off of a dependent constraint.
const ROUNDING: f64 = 1e-11;

/// Joint whose constraints are no quadratic forms, or depend on a drive, friction or stops; `None` where there is none.
pub fn without_series(system: &System) -> Option<&str> {
    let quadratic = |joint: &&Joint| {
        joint.law.is_none() && joint.drive.is_none() && joint.rows.iter().all(|row| row.is_quadratic())
    };
    system.joints.iter().find(|joint| !quadratic(joint)).map(|joint| joint.name.as_str())
}

/// Multipliers of the constraints at an equilibrium with these displacements and load factor, from the forces `rest` that they balance. Of constraints
/// that depend on each other those of minimum norm, in units of the `norm` where it is given.
pub fn multipliers_at(
    system: &System,
    frames: &LocalFrames,
    (u, load): (&[Nodal], f64),
    (rest, norm): (&[f64], Option<&[f64]>),
) -> Vec<f64> {
    let gradients = gradients_of(system, frames, (u, load));
    let weights = weights(system, frames);
    let m = gradients.len();
    let mut dense = vec![0.0; rest.len()];
    let mut matrix = DMatrix::zeros(m, m);
    let mut right = DVector::zeros(m);
    for (i, gradient) in gradients.iter().enumerate() {
        gradient.iter().for_each(|&(n, x)| dense[n as usize] = x * weights[n as usize]);
        for (j, other) in gradients[..=i].iter().enumerate() {
            let product: f64 = other.iter().map(|&(n, x)| x * dense[n as usize]).sum();
            (matrix[(i, j)], matrix[(j, i)]) = (product, product);
        }
        right[i] = gradient.iter().map(|&(n, _)| dense[n as usize] * rest[n as usize]).sum();
        gradient.iter().for_each(|&(n, _)| dense[n as usize] = 0.0);
    }
    minimum_norm(matrix, right, norm)
}

/// Solution of a symmetric system that may be singular, of minimum norm of the unknowns times `norm`; without it in unknowns that make its diagonal 1.
fn minimum_norm(mut matrix: DMatrix<f64>, mut right: DVector<f64>, norm: Option<&[f64]>) -> Vec<f64> {
    let m = right.len();
    let scale: Vec<f64> =
        (0..m).map(|i| if matrix[(i, i)] > 0.0 { matrix[(i, i)].sqrt().recip() } else { 0.0 }).collect();
    for i in 0..m {
        right[i] *= scale[i];
        (0..m).for_each(|j| matrix[(i, j)] *= scale[i] * scale[j]);
    }
    let scaled = |x: &DVector<f64>| x.iter().zip(&scale).map(|(x, scale)| x * scale).collect();
    if let Some(factor) = matrix.clone().cholesky()
        && factor.l_dirty().diagonal().iter().all(|pivot| pivot * pivot > ROUNDING)
    {
        return scaled(&factor.solve(&right));
    }
    let eigen = matrix.symmetric_eigen();
    let limit = ROUNDING * eigen.eigenvalues.iter().fold(0.0, |a: f64, x| crate::norm::larger(a, x.abs()));
    let (mut solution, mut null) = (DVector::zeros(m), Vec::new());
    for (vector, value) in eigen.eigenvectors.column_iter().zip(eigen.eigenvalues.iter()) {
        if *value > limit {
            solution += vector * (vector.dot(&right) / value);
        } else {
            null.push(vector.into_owned());
        }
    }
    let Some(norm) = norm.filter(|_| !null.is_empty()) else { return scaled(&solution) };
    let null = DMatrix::from_columns(&null);
    let weighted = DMatrix::from_fn(m, null.ncols(), |i, j| norm[i] * scale[i] * null[(i, j)]);
    let rest = DVector::from_fn(m, |i, _| norm[i] * scale[i] * solution[i]);
    if let Ok(part) = weighted.svd(true, true).solve(&rest, ROUNDING) {
        solution -= null * part;
    }
    scaled(&solution)
}

/// Weights of the squares of the residual: forces count as they are, and moments and forces on directors over the length of the model.
fn weights(system: &System, frames: &LocalFrames) -> Vec<f64> {
    let mut out = vec![0.0; system.unknowns()];
    for (v, kind) in system.coordinates.kinds.iter().enumerate() {
        let weight = if *kind == VectorKind::Position { 1.0 } else { system.length.powi(-2) };
        for number in frames.of(v) {
            if let Some(out) = out.get_mut(number as usize) {
                *out = weight;
            }
        }
    }
    out
}

/// Products `G x` of the gradients at displacements with a field, and half the second derivatives along pairs of lower coefficients.
pub fn rates(system: &System, u: &[Nodal], field: &[Nodal], coefficients: &[Vec<Nodal>]) -> Vec<f64> {
    let mut out = vec![0.0; system.constraints()];
    let motion = Motion::State { u, velocity: None };
    for joint in system.joints.iter() {
        joint_rates(joint, (end_of(system, &motion), DriveValue::default()), Rates::Along(field), &mut out);
        let values = |field: &Vec<Nodal>| -> Vec<Vec3> {
            joint.vectors.iter().map(|&v| Vec3::from(field[v as usize])).collect()
        };
        let lower: Vec<Vec<Vec3>> = coefficients.iter().map(values).collect();
        for (number, row) in joint.multipliers().zip(&joint.rows) {
            let pairs = lower.iter().zip(lower.iter().rev());
            out[number] += 0.5 * pairs.map(|(a, b)| row.second_derivative(a, b)).sum::<f64>();
        }
    }
    out
}

/// Adds the constraint forces `Gᵀν` at displacements.
pub fn add_forces(system: &System, u: &[Nodal], multipliers: &[f64], out: &mut [Nodal]) {
    let motion = Motion::State { u, velocity: None };
    for joint in system.joints.iter() {
        joint.with_vectors(end_of(system, &motion), |q, gradient| {
            for (number, row) in joint.multipliers().zip(&joint.rows) {
                row.add_gradient(multipliers[number], q, 0.0, gradient);
            }
            for (&v, g) in joint.vectors.iter().zip(gradient.iter()) {
                (0..3).for_each(|i| out[v as usize][i] += g[i]);
            }
        });
    }
}

/// Length of the series of the multipliers by its last term, as that of displacements; infinite where they do not change. Each counts with the size
/// of the values of its constraint, as energy.
pub fn range(system: &System, multipliers: &[Vec<f64>], tolerance: f64) -> f64 {
    let rows = || system.joints.iter().flat_map(|joint| &joint.rows);
    let size = |of_order: &[f64]| {
        of_order.iter().zip(rows()).map(|(x, row)| (x * row.size).powi(2)).sum::<f64>().sqrt()
    };
    let [at_start, first, .., last] = multipliers else { return f64::INFINITY };
    let [at_start, first, last] = [at_start, first, last].map(|of_order| size(of_order));
    if last == 0.0 {
        return f64::INFINITY;
    }
    let order = (multipliers.len() - 1) as f64;
    // Where they change little, their error is a part of their size.
    let by_size = (tolerance * at_start / last).powf(1.0 / order);
    let by_change = (tolerance * first / last).powf(1.0 / (order - 1.0));
    crate::norm::larger(by_size, by_change)
}
