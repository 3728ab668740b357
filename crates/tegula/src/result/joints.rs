//! Reactions, power and constraint drift of joints.

use super::bodies::current;
use crate::analysis::State;
use crate::constraint::Joint;
use crate::element::Nodal;
use crate::system::{System, VectorKind};
use crate::{Mat3, Vec3};

/// Action of a joint in a state; for the energy–momentum scheme of second order means over the last step, in the configuration in its middle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointResponse {
    /// Force of the first end (of gears: and the carrier) on the second one, along the axes of space.
    pub force: Vec3,
    /// Moment of the first end on the second one about the point of the joint, along the axes of space.
    pub moment: Vec3,
    /// Power that the joint supplies to the model, `−λᵀ G v` \[force · length/time\]: that of its drive less that of its friction and stops, without
    /// their impulses; 0 to round-off for any other joint, and in statics. For the energy–momentum scheme of second order the sum over all
    /// steps is the change of the energy.
    pub power: f64,
    /// [Axes of the joint](Joint::axes) as columns, of unit length, in the configuration in which the force acts; `None` where neither end has axes.
    pub axes: Option<Mat3>,
}

impl JointResponse {
    /// Response of a joint in a state.
    pub fn new(system: &System, state: &State, joint: &Joint) -> Self {
        let (u, time) = configuration(state);
        let v: Vec<Vec3> = joint.vectors.iter().map(|&v| current(system, u, v)).collect();
        let half = |i: usize| current(system, &state.u, joint.vectors[i]) - v[i];
        let mut forces = vec![Vec3::zeros(); v.len()];
        let drive = system.drive_value(joint, time);
        for (row, number) in joint.rows.iter().zip(joint.multipliers()) {
            let multiplier = state.multipliers.get(number).copied().unwrap_or(f64::NAN);
            row.add_acting_gradient(multiplier, (&v, half), drive, &mut forces);
        }
        let rate = |i: usize| match state.middle.is_empty() {
            true => state.v.get(joint.vectors[i] as usize).copied().map_or_else(Vec3::zeros, Vec3::from),
            false => half(i) * (2.0 / state.last_step),
        };
        // The joint acts with −Gᵀλ.
        let power = -forces.iter().enumerate().map(|(i, force)| force.dot(&rate(i))).sum::<f64>();
        let point = joint.place(|n| current(system, u, n));
        // What acts on the first end acts with opposite sign on the second one.
        // The carrier of gears, which may be the ground, takes a part: their wheels do not act with opposite moments on each other.
        let from_second = joint.counted.is_some() && joint.of_first.contains(&false);
        let from_first = joint.of_first.contains(&true) && !from_second;
        let sign = if from_first { 1.0 } else { -1.0 };
        let (mut force, mut moment) = (Vec3::zeros(), Vec3::zeros());
        for (i, f) in forces.iter().enumerate().filter(|(i, _)| joint.of_first[*i] == from_first) {
            let arm = match system.coordinates.kinds[joint.vectors[i] as usize] {
                VectorKind::Position => {
                    force += f * sign;
                    v[i] - point
                }
                VectorKind::Director | VectorKind::Gradient => v[i],
            };
            moment += arm.cross(f) * sign;
        }
        let axes = joint.axes.as_ref().map(|axes| {
            let [first, _, third] = axes.each_ref().map(|axis| axis.value(|n| current(system, u, n)));
            // In the middle of a step the means of axes are neither of unit length nor perpendicular.
            let third = third.normalize();
            let second = third.cross(&first).normalize();
            Mat3::from_columns(&[second.cross(&third), second, third])
        });
        Self { force, moment, power, axes }
    }

    /// Force and moment along the axes of the joint; `None` where neither end has axes.
    pub fn along_axes(&self) -> Option<[Vec3; 2]> {
        self.axes.map(|axes| [self.force, self.moment].map(|x| axes.tr_mul(&x)))
    }
}

/// Displacements and time at which the constraint forces of a state act: in the middle of the last step for the energy–momentum scheme of
/// second order.
fn configuration(state: &State) -> (&[Nodal], f64) {
    match state.middle.is_empty() {
        true => (&state.u, state.time),
        false => (&state.middle, state.time - 0.5 * state.last_step),
    }
}

/// Force and moment of the first end of a joint on the second one: those of its [response](JointResponse).
pub fn joint_reaction(system: &System, state: &State, joint: &Joint) -> (Vec3, Vec3) {
    let JointResponse { force, moment, .. } = JointResponse::new(system, state, joint);
    (force, moment)
}

/// Largest violation of the constraints of a joint in a state: of positions over the length of the model, of axes as the cosine or sine of the
/// angle that they miss (rad for small ones). A coordinate that friction or a stop holds does not count.
pub fn joint_drift(system: &System, state: &State, joint: &Joint) -> f64 {
    let gears = state.angles.get(system.number_of_angle_sensors()..).unwrap_or_default();
    let counted = system.counted_angles().zip(gears).find(|((gear, _), _)| gear.number == joint.number);
    let drive = counted.map_or_else(|| system.drive_value(joint, state.time), |(_, angle)| *angle);
    let v: Vec<Vec3> = joint.vectors.iter().map(|&v| current(system, &state.u, v)).collect();
    joint.constraints().iter().map(|row| row.value(&v, drive).abs() / row.size).fold(0.0, crate::norm::larger)
}
