//! Directors of rigid bodies in time integration: predictions and rates that integrate all nine components freely are
//! projected onto rotations.

use crate::analysis::State;
use crate::element::Nodal;
use crate::system::System;
use crate::{Mat3, Vec3};
use nalgebra::Rotation3;

/// Iterations for the polar decomposition: quadratic convergence from the prediction of a step.
const POLAR_ITERATIONS: usize = 30;

/// Directors of a body at displacements `u`, as columns.
fn directors(system: &System, u: &[Nodal], triad: &[u32; 3]) -> Mat3 {
    Mat3::from_columns(&triad.map(|v| {
        let v = v as usize;
        Vec3::from(system.coordinates.reference[v]) + Vec3::from(u[v])
    }))
}

/// Rotation nearest to a matrix: orthogonal factor of its polar decomposition, by Newton's iteration
/// `R ← ½ (R + R⁻ᵀ)` (N. Higham, *Functions of matrices*, Sect. 8.3); the matrix itself where it is singular.
fn nearest_rotation(matrix: &Mat3) -> Mat3 {
    let mut r = *matrix;
    for _ in 0..POLAR_ITERATIONS {
        let Some(inverse) = r.try_inverse() else { return *matrix };
        let next = (r + inverse.transpose()) * 0.5;
        let change = (next - r).norm();
        r = next;
        if !(change > 1e-15) {
            break;
        }
    }
    r
}

/// Projects the directors of rigid bodies of a prediction onto rotations; attached vectors follow.
pub(super) fn project_directors(system: &System, u: &mut [Nodal]) {
    for triad in &system.dofs().triads {
        let r = nearest_rotation(&directors(system, u, triad));
        for (i, &v) in triad.iter().enumerate() {
            let reference = Vec3::from(system.coordinates.reference[v as usize]);
            u[v as usize] = (r.column(i) - reference).into();
        }
    }
    system.dofs().carry(u);
}

/// Keeps of the changes that [`project_directors`] has made to directors only the symmetric part `R S`: round-off that
/// rotates a body, divided by the square of a short step, would be an acceleration.
pub(super) fn keep_stretch(system: &System, u: &[Nodal], moved: &mut [Nodal]) {
    for triad in &system.dofs().triads {
        let r = directors(system, u, triad);
        let change = Mat3::from_columns(&triad.map(|v| Vec3::from(moved[v as usize])));
        let local = r.transpose() * change;
        let stretch = r * ((local + local.transpose()) * 0.5);
        for (i, &v) in triad.iter().enumerate() {
            moved[v as usize] = stretch.column(i).into_owned().into();
        }
    }
    system.dofs().carry(moved);
}

/// Angular velocity of directors d from their rates, `½ Σ dᵢ × ḋᵢ`.
fn spin(d: &Mat3, rates: &[Nodal], triad: &[u32; 3]) -> Vec3 {
    (0..3).map(|i| d.column(i).cross(&Vec3::from(rates[triad[i] as usize]))).sum::<Vec3>() * 0.5
}

/// Projects velocities of directors d onto those of a rotation, `ω × d`; attached vectors follow.
pub(crate) fn project_director_velocities(system: &System, u: &[Nodal], v: &mut [Nodal]) {
    for triad in &system.dofs().triads {
        let d = directors(system, u, triad);
        let omega = spin(&d, v, triad);
        for (i, &n) in triad.iter().enumerate() {
            v[n as usize] = omega.cross(&d.column(i)).into();
        }
    }
    system.dofs().carry(v);
}

/// Projects rates of directors d onto those of a rotation: velocities `ω × d`, accelerations `α × d + ω × (ω × d)`; attached
/// vectors follow.
pub(super) fn project_rates(system: &System, u: &[Nodal], v: &mut [Nodal], a: &mut [Nodal]) {
    for triad in &system.dofs().triads {
        let d = directors(system, u, triad);
        let (omega, alpha) = (spin(&d, v, triad), spin(&d, a, triad));
        for (i, &n) in triad.iter().enumerate() {
            let turned = omega.cross(&d.column(i));
            v[n as usize] = turned.into();
            a[n as usize] = (alpha.cross(&d.column(i)) + omega.cross(&turned)).into();
        }
    }
    system.dofs().carry(v);
    system.dofs().carry(a);
}

/// Moment of inertia over the largest one below which a body has none: a thin rod about its axis.
const NO_INERTIA: f64 = 1e-12;

/// Projects the velocities of bodies onto those of rigid motions in the norm of their kinetic energy: linear momentum and moment of
/// momentum about the mass centre stay as they are. Attached vectors follow.
pub(super) fn project_velocities(system: &System, u: &[Nodal], v: &mut [Nodal]) {
    for body in &system.coordinates.bodies {
        let Some(triad) = &body.directors else { continue };
        let d = directors(system, u, triad);
        let rates = triad.map(|i| Vec3::from(v[i as usize]));
        let (mass, euler) = body.inertia();
        let inertia = (Mat3::identity() * euler.trace()) - d * euler * d.transpose();
        let mut momentum = Vec3::zeros();
        for i in 0..3 {
            for j in 0..3 {
                momentum += d.column(i).cross(&rates[j]) * euler[(i, j)];
            }
        }
        // About an axis without inertia, that of a thin rod, the mean of the directors counts.
        let mean = (0..3).map(|i| d.column(i).cross(&rates[i])).sum::<Vec3>() * 0.5;
        let eigen = inertia.symmetric_eigen();
        let rest = eigen.eigenvectors.transpose() * (momentum - inertia * mean);
        let part = |i: usize| {
            let moment = eigen.eigenvalues[i];
            if moment > NO_INERTIA * euler.trace() { rest[i] / moment } else { 0.0 }
        };
        let omega = mean + eigen.eigenvectors * Vec3::from_fn(|i, _| part(i));
        let first = body.patch.1;
        for (i, &n) in triad.iter().enumerate() {
            let turned = omega.cross(&d.column(i));
            if mass > 0.0 {
                let moved = (rates[i] - turned) * (first[i] / mass);
                let centre = &mut v[body.centre as usize];
                (0..3).for_each(|c| centre[c] += moved[c]);
            }
            v[n as usize] = turned.into();
        }
    }
    system.dofs().carry(v);
}

/// Largest rotation of a body in a step (rad). The directors in the middle of a step of half a turn vanish: beyond it the equations
/// of the step have other solutions.
pub(super) const MOST_ROTATION: f64 = 2.0;

/// Largest rotation (rad) between the end of a step and where the angular velocity at its start would lead: joints such as the
/// universal one are closed after half a turn, too, and a long step may end there.
const MOST_DEVIATION: f64 = 1.0;

/// Name of a body that turns too far in a step of length `dt` from a state to the displacements `new`: by its angular velocity at
/// the start, by its displacements, or by what one differs from the other.
pub(super) fn turned_too_far<'a>(
    system: &'a System,
    (state, dt): (&State, f64),
    new: &[Nodal],
) -> Option<&'a str> {
    let [least, least_deviation] = [MOST_ROTATION, MOST_DEVIATION].map(|angle| 1.0 + 2.0 * angle.cos());
    let far = |triad: &[u32; 3]| {
        let before = directors(system, &state.u, triad);
        let rate = |i: usize| before.column(i).cross(&Vec3::from(state.v[triad[i] as usize]));
        let rotation = (0..3).map(rate).sum::<Vec3>() * (0.5 * dt);
        let after = directors(system, new, triad);
        // The trace of a rotation by an angle is 1 + 2 cos of it.
        let trace = (before.transpose() * after).trace();
        let predicted = Rotation3::new(rotation).into_inner() * before;
        let deviation = (predicted.transpose() * after).trace();
        !(trace >= least && rotation.norm() <= MOST_ROTATION && deviation >= least_deviation)
    };
    let body = system.coordinates.bodies.iter().find(|body| body.directors.as_ref().is_some_and(far))?;
    Some(&body.name)
}
