//! Motion of rigid bodies, reactions of joints, springs, bushings and resultants of beams: columns of the history.

use tegula::System;
use tegula::analysis::State;
use tegula::result::beams::beam_resultants;
use tegula::result::bodies::{
    BodyMotion, bushing_responses, coordinate_response, reference_axes, spring_lengths_and_forces,
    torsion_angles_and_moments,
};
use tegula::result::{JointResponse, joint_drift};
use tegula::system::BeamLine;
use tegula::system::coordinates::Body;

/// Columns of a body: position, quaternion from the reference (scalar first), velocity, angular velocity along the axes of
/// space and along those of the body.
const OF_BODY: [&str; 16] =
    ["x", "y", "z", "q0", "q1", "q2", "q3", "vx", "vy", "vz", "wx", "wy", "wz", "w1", "w2", "w3"];
/// Columns of a point mass.
const OF_POINT: [&str; 6] = ["x", "y", "z", "vx", "vy", "vz"];
/// Columns behind them in transient analyses: acceleration of the mass centre, and, not of point masses, angular acceleration along
/// the axes of space.
pub(super) const ACCELERATIONS: [&str; 6] = ["ax", "ay", "az", "alpha_x", "alpha_y", "alpha_z"];
/// Columns of a joint: force and moment of the first end on the second one.
const OF_JOINT: [&str; 6] = ["fx", "fy", "fz", "mx", "my", "mz"];
/// Columns of a joint behind the others of a reaction: force and moment along its axes.
const ALONG_AXES: [&str; 6] = ["f1", "f2", "f3", "m1", "m2", "m3"];
/// Column of a joint behind them: largest violation of its constraints.
const DRIFT: &str = "drift";
/// Column of a joint behind that in transient analyses: power that its drive supplies, less that of its friction and stops.
const POWER: &str = "power";
/// Column of the relative coordinate of a joint with friction or stops.
pub(super) const ANGLE: &str = "angle";
pub(super) const DISPLACEMENT: &str = "displacement";
/// Columns of a joint with friction or stops behind its displacement or angle (degrees): friction and force of the stop on the second
/// end along or about the axis, and 1 where the joint is held, 0 where it moves.
const OF_COORDINATE: [&str; 3] = ["friction", "stop", "held"];

/// Columns of a spring: length, and force that draws its points together.
const OF_SPRING: [&str; 2] = ["length", "force"];
/// Columns of a torsion spring: angle (degrees), and moment that resists it.
const OF_TORSION_SPRING: [&str; 2] = ["angle", "moment"];
/// Columns of a bushing: displacement and force; with stiffness or damping of rotations the rotation vector (degrees) and the moment, too.
const OF_BUSHING: [&str; 12] = ["ux", "uy", "uz", "fx", "fy", "fz", "rx", "ry", "rz", "mx", "my", "mz"];
/// Number of the columns of displacement and force.
const OF_DISPLACEMENT: usize = 6;

/// Columns of a node of a beam: shear forces along the axes 1 and 2 of the cross-section, axial force, bending moments about the
/// axes 1 and 2, torsional moment.
const OF_BEAM: [&str; 6] = ["v1", "v2", "n", "m1", "m2", "t"];

/// Bodies with columns: nodes of beams have them where the model asks for them.
pub(super) fn shown(system: &System) -> impl Iterator<Item = &Body> {
    let wanted = |(i, _): &(usize, &Body)| match system.beams.iter().find(|beam| beam.bodies.contains(i)) {
        Some(beam) => beam.history.contains(&((i - beam.bodies.start) as u32)),
        None => true,
    };
    system.coordinates.bodies.iter().enumerate().filter(wanted).map(|(_, body)| body)
}

/// Nodes of a beam with columns.
fn nodes(beam: &BeamLine) -> impl Iterator<Item = usize> {
    (0..beam.bodies.len()).filter(|node| beam.history.contains(&(*node as u32)))
}

/// Names of the columns behind all others.
pub(super) fn names(system: &System) -> Vec<String> {
    let mut out = Vec::new();
    for body in shown(system) {
        let (columns, accelerations) = match body.directors {
            Some(_) => (&OF_BODY[..], &ACCELERATIONS[..]),
            None => (&OF_POINT[..], &ACCELERATIONS[..3]),
        };
        let accelerations = accelerations.iter().filter(|_| system.moves());
        out.extend(columns.iter().chain(accelerations).map(|column| format!("body.{}.{column}", body.name)));
    }
    for joint in system.joints.iter() {
        let of_joint = OF_JOINT.into_iter().chain([DRIFT]).chain(system.moves().then_some(POWER));
        out.extend(of_joint.map(|column| format!("joint.{}.{column}", joint.name)));
        let along = ALONG_AXES.iter().filter(|_| joint.axes.is_some());
        out.extend(along.map(|column| format!("joint.{}.{column}", joint.name)));
        if let Some((_, law)) = joint.law_row() {
            out.push(format!("joint.{}.{}", joint.name, if law.is_angle { ANGLE } else { DISPLACEMENT }));
            out.extend(OF_COORDINATE.map(|column| format!("joint.{}.{column}", joint.name)));
        }
    }
    for (name, _) in system.springs.iter() {
        out.extend(OF_SPRING.map(|column| format!("spring.{name}.{column}")));
    }
    for (spring, _) in system.torsion_springs.iter() {
        out.extend(OF_TORSION_SPRING.map(|column| format!("torsion_spring.{}.{column}", spring.name)));
    }
    for bushing in system.bushings.iter() {
        let columns = if bushing.turns { &OF_BUSHING[..] } else { &OF_BUSHING[..OF_DISPLACEMENT] };
        out.extend(columns.iter().map(|column| format!("bushing.{}.{column}", bushing.name)));
    }
    for beam in system.beams.iter() {
        for node in nodes(beam) {
            let name = &system.coordinates.bodies[beam.bodies.start + node].name;
            out.extend(OF_BEAM.map(|column| format!("beam.{name}.{column}")));
        }
    }
    out
}

/// Values of the columns.
pub(super) fn row(system: &System, state: &State) -> Vec<f64> {
    let mut out = Vec::new();
    for body in shown(system) {
        let motion = BodyMotion::new(system, state, body);
        out.extend(motion.position.iter());
        let turns = body.directors.is_some();
        if turns {
            out.extend(motion.quaternion(&reference_axes(system, body)));
        }
        out.extend(motion.velocity.iter());
        if turns {
            out.extend(motion.angular_velocity.iter().chain(motion.spin().iter()));
        }
        if system.moves() {
            out.extend(motion.acceleration.iter());
            out.extend(motion.angular_acceleration.iter().filter(|_| turns));
        }
    }
    for joint in system.joints.iter() {
        let found = JointResponse::new(system, state, joint);
        out.extend(found.force.iter().chain(found.moment.iter()));
        out.push(joint_drift(system, state, joint));
        out.extend(system.moves().then_some(found.power));
        out.extend(
            found.along_axes().into_iter().flatten().flat_map(|vector| [vector.x, vector.y, vector.z]),
        );
        if let Some(found) = coordinate_response(system, state, joint) {
            let value = if found.is_angle { found.value.to_degrees() } else { found.value };
            out.extend([value, found.friction, found.stop, f64::from(u8::from(found.is_held))]);
        }
    }
    spring_lengths_and_forces(system, state).into_iter().for_each(|of_spring| out.extend(of_spring));
    for [angle, moment] in torsion_angles_and_moments(system, state) {
        out.extend([angle.to_degrees(), moment]);
    }
    for (bushing, found) in system.bushings.iter().zip(bushing_responses(system, state)) {
        out.extend(found.displacement.iter().chain(found.force.iter()));
        if bushing.turns {
            out.extend(
                found.rotation.iter().map(|angle| angle.to_degrees()).chain(found.moment.iter().copied()),
            );
        }
    }
    for beam in system.beams.iter() {
        let resultants = beam_resultants(system, state, beam);
        // At a node that of the element which begins there; at the last one that of the element which ends there.
        nodes(beam).for_each(|node| out.extend(resultants[node.min(resultants.len() - 1)]));
    }
    out
}
