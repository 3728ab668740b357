//! Motion of rigid bodies and reactions of joints: columns of the history.

use tegula::System;
use tegula::analysis::State;
use tegula::result::bodies::{BodyMotion, joint_reaction, reference_axes};

/// Columns of a body: position, quaternion from the reference (scalar first), velocity, angular velocity along the axes of
/// space and along those of the body.
const OF_BODY: [&str; 16] =
    ["x", "y", "z", "q0", "q1", "q2", "q3", "vx", "vy", "vz", "wx", "wy", "wz", "w1", "w2", "w3"];
/// Columns of a point mass.
const OF_POINT: [&str; 6] = ["x", "y", "z", "vx", "vy", "vz"];
/// Columns of a joint: force and moment of the first end on the second one.
const OF_JOINT: [&str; 6] = ["fx", "fy", "fz", "mx", "my", "mz"];

/// Names of the columns behind all others.
pub(super) fn names(system: &System) -> Vec<String> {
    let mut out = Vec::new();
    for body in &system.coordinates.bodies {
        let columns = if body.directors.is_some() { &OF_BODY[..] } else { &OF_POINT[..] };
        out.extend(columns.iter().map(|column| format!("body.{}.{column}", body.name)));
    }
    for joint in system.joints.iter() {
        out.extend(OF_JOINT.map(|column| format!("joint.{}.{column}", joint.name)));
    }
    out
}

/// Values of the columns.
pub(super) fn row(system: &System, state: &State) -> Vec<f64> {
    let mut out = Vec::new();
    for body in &system.coordinates.bodies {
        let motion = BodyMotion::new(system, state, body);
        out.extend(motion.position.iter());
        if body.directors.is_none() {
            out.extend(motion.velocity.iter());
            continue;
        }
        out.extend(motion.quaternion(&reference_axes(system, body)));
        let spin = motion.spin();
        out.extend([&motion.velocity, &motion.angular_velocity, &spin].into_iter().flat_map(|v| v.iter()));
    }
    for joint in system.joints.iter() {
        let (force, moment) = joint_reaction(system, state, joint);
        out.extend(force.iter().chain(moment.iter()));
    }
    out
}
