//! Constraint drift and power of joints.

use super::bodies::joint_forces;
use crate::Vec3;
use crate::analysis::State;
use crate::constraint::Joint;
use crate::element::Nodal;
use crate::system::System;

/// Largest violation of the constraints of a joint in a state: of positions over the length of the model, of axes as the cosine or sine of the
/// angle that they miss (rad for small ones). A coordinate that friction or a stop holds does not count.
pub fn joint_drift(system: &System, state: &State, joint: &Joint) -> f64 {
    let gears = state.angles.get(system.number_of_angle_sensors()..).unwrap_or_default();
    let counted = system.counted_angles().zip(gears).find(|((gear, _), _)| gear.number == joint.number);
    let drive = counted.map_or_else(|| system.drive_value(joint, state.time), |(_, angle)| *angle);
    let at =
        |v: &u32| Vec3::from(system.coordinates.reference[*v as usize]) + Vec3::from(state.u[*v as usize]);
    let v: Vec<Vec3> = joint.vectors.iter().map(at).collect();
    joint.constraints().iter().map(|row| row.value(&v, drive).abs() / row.size).fold(0.0, crate::norm::larger)
}

/// Power that a joint supplies to the model, `−λᵀ G v` \[force · length/time\]: that of its drive less that of its friction and stops, without
/// their impulses; 0 to round-off for any other joint. For the energy–momentum scheme of second order the mean over the last step, whose sum over all steps is
/// the change of the energy.
pub fn joint_power(system: &System, state: &State, joint: &Joint) -> f64 {
    let (v, forces) = joint_forces(system, state, joint);
    let vector = |field: &[Nodal], i: usize| Vec3::from(field[joint.vectors[i] as usize]);
    let rate = |i: usize| match state.middle.is_empty() {
        true => vector(&state.v, i),
        false => {
            let reference = Vec3::from(system.coordinates.reference[joint.vectors[i] as usize]);
            (reference + vector(&state.u, i) - v[i]) * (2.0 / state.last_step)
        }
    };
    // The joint acts with −Gᵀλ.
    -forces.iter().enumerate().map(|(i, force)| force.dot(&rate(i))).sum::<f64>()
}
