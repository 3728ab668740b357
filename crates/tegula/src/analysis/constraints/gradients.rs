//! Gradients and rates of the constraints of joints.

use super::{Gradient, Rates, end_of};
use crate::Vec3;
use crate::analysis::State;
use crate::constraint::joint::MOST_VECTORS;
use crate::constraint::{DriveValue, Joint};
use crate::element::{Motion, Nodal};
use crate::system::{LocalFrames, System};

/// Gradients of all constraints over a motion with this middle and half of the change of each nodal vector, with respect to the degrees of
/// freedom of `frames`.
pub(in crate::analysis) fn gradients(
    system: &System,
    (frames, time): (&LocalFrames, f64),
    (middle, half): (impl Fn(usize) -> Vec3, impl Fn(usize) -> Vec3),
    out: &mut [Gradient],
) {
    for joint in system.joints.iter() {
        let drive = system.drive_value(joint, time);
        joint.with_vectors(&middle, |v, forces| {
            for (i, row) in joint.multipliers().zip(&joint.rows) {
                forces.fill(Vec3::zeros());
                let half = |i: usize| half(joint.vectors[i] as usize);
                row.add_acting_gradient(1.0, (v, half), drive, forces);
                let gradient = &mut out[i];
                gradient.clear();
                for (&v, g) in joint.vectors.iter().zip(&*forces).filter(|(_, g)| **g != Vec3::zeros()) {
                    frames.reduce_one(v as usize, g, |number, x| add_entry(gradient, number, x));
                }
            }
        });
    }
}

/// Rates of the constraints of a joint where the nodal vectors have the values `end`.
pub(in crate::analysis) fn joint_rates(
    joint: &Joint,
    (end, drive): (impl Fn(usize) -> Vec3, DriveValue),
    rates: Rates,
    out: &mut [f64],
) {
    let of = |field: &[Nodal], v: usize| Vec3::from(field[v]);
    joint.with_vectors(end, |q, gradient| {
        for (i, row) in joint.multipliers().zip(&joint.rows) {
            let mut along = |field: &[Nodal]| {
                gradient.fill(Vec3::zeros());
                row.add_gradient(1.0, q, drive.value, gradient);
                let products =
                    gradient.iter().zip(&joint.vectors).map(|(g, &v)| g.dot(&of(field, v as usize)));
                products.sum::<f64>()
            };
            out[i] = match rates {
                Rates::First(v) => along(v) + row.driven_rate(q, drive),
                Rates::Second(v, a) => {
                    let term = joint.with_vectors(|k| of(v, k), |v, _| row.velocity_term(q, v, drive));
                    along(a) + term
                }
                Rates::Along(field) => along(field),
            };
        }
    });
}

/// Gradients of all constraints in a state, with respect to the degrees of freedom of `frames`; those of friction and stops are empty.
pub(in crate::analysis) fn gradients_at(
    system: &System,
    frames: &LocalFrames,
    state: &State,
) -> Vec<Gradient> {
    gradients_of(system, frames, (&state.u, state.time))
}

/// Gradients of the constraints at displacements and a time.
pub(in crate::analysis) fn gradients_of(
    system: &System,
    frames: &LocalFrames,
    (u, time): (&[Nodal], f64),
) -> Vec<Gradient> {
    let mut out = vec![Gradient::new(); system.constraints()];
    let motion = Motion::State { u, velocity: None };
    gradients(system, (frames, time), (end_of(system, &motion), |_| Vec3::zeros()), &mut out);
    for (number, _) in system.joints.iter().filter_map(Joint::law_row) {
        out[number].clear();
    }
    out
}

/// Adds to the entry of a number. Vectors that share degrees of freedom belong to bodies, which stand at the beginning of a
/// list; the many nodes of a coupling behind them have their own.
fn add_entry(gradient: &mut Gradient, number: u32, x: f64) {
    match gradient.iter_mut().take(3 * MOST_VECTORS).find(|(n, _)| *n == number) {
        Some((_, sum)) => *sum += x,
        None => gradient.push((number, x)),
    }
}
