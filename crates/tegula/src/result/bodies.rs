//! Motion of rigid bodies, reactions of joints, and forces of springs and bushings.

use nalgebra::{Rotation3, UnitQuaternion};

use crate::analysis::State;
use crate::analysis::dynamics::triads::project_director_velocities;
use crate::constraint::coordinate_law::parts;
use crate::constraint::{Bushing, BushingResponse, Joint, Spring, TorsionSpring};
use crate::element::Nodal;
use crate::system::coordinates::Body;
use crate::system::{EvaluationPoint, System};
use crate::{Mat3, Vec3};

/// Motion of a rigid body or a point mass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyMotion {
    /// Position of the mass centre (length).
    pub position: Vec3,
    /// Directors as columns: rotation matrix from the axes of the body to those of space; the unit matrix for point masses.
    pub axes: Mat3,
    /// Velocity of the mass centre [length/time].
    pub velocity: Vec3,
    /// Angular velocity along the axes of space [rad/time].
    pub angular_velocity: Vec3,
    /// Acceleration of the mass centre [length/time²]: with the energy–momentum scheme of second order its mean over the step, and
    /// zero where nothing moves in time.
    pub acceleration: Vec3,
    /// Angular acceleration along the axes of space [rad/time²], as the acceleration.
    pub angular_acceleration: Vec3,
}

impl BodyMotion {
    /// Motion of a body in a state.
    pub fn new(system: &System, state: &State, body: &Body) -> Self {
        let rate = |v: u32| state.v.get(v as usize).copied().map_or_else(Vec3::zeros, Vec3::from);
        let at = |v: u32| current(system, &state.u, v);
        let axes = body.directors.map_or_else(Mat3::identity, |d| Mat3::from_columns(&d.map(at)));
        let turning = |d: [u32; 3]| d.map(|v| at(v).cross(&rate(v))).iter().sum::<Vec3>() * 0.5;
        // Of d̈ = α × d + ω × (ω × d) the sum of d × d̈ over three orthonormal directors leaves 2 α.
        let u = if state.middle.is_empty() { &state.u } else { &state.middle };
        let second = |v: u32| state.a.get(v as usize).copied().map_or_else(Vec3::zeros, Vec3::from);
        let spinning_up =
            |d: [u32; 3]| d.map(|v| current(system, u, v).cross(&second(v))).iter().sum::<Vec3>() * 0.5;
        Self {
            position: at(body.centre),
            axes,
            velocity: rate(body.centre),
            angular_velocity: body.directors.map_or_else(Vec3::zeros, turning),
            acceleration: second(body.centre),
            angular_acceleration: body.directors.map_or_else(Vec3::zeros, spinning_up),
        }
    }

    /// Angular velocity along the axes of the body [rad/time].
    pub fn spin(&self) -> Vec3 {
        self.axes.transpose() * self.angular_velocity
    }

    /// Unit quaternion (scalar first) of the rotation from the reference axes of the body to the present ones, with a scalar
    /// part that is not negative.
    pub fn quaternion(&self, reference: &Mat3) -> [f64; 4] {
        let rotation = Rotation3::from_matrix_unchecked(self.axes * reference.transpose());
        let q = UnitQuaternion::from_rotation_matrix(&rotation);
        let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
        [q.w, q.i, q.j, q.k].map(|x| sign * x)
    }
}

/// Axes of a body in the reference configuration, as columns; the unit matrix for point masses.
pub fn reference_axes(system: &System, body: &Body) -> Mat3 {
    let at = |v: u32| Vec3::from(system.coordinates.reference[v as usize]);
    body.directors.map_or_else(Mat3::identity, |d| Mat3::from_columns(&d.map(at)))
}

/// Relative coordinate of a joint with friction or stops, and the forces of these (torques of a revolute joint).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CoordinateResponse {
    /// Displacement (length), or angle (rad), of the second side relative to the first one.
    pub value: f64,
    /// Whether the coordinate is an angle.
    pub is_angle: bool,
    /// Friction on the second side along the axis; a mean over the step.
    pub friction: f64,
    /// Force of the stop on the second side along the axis, without impulses; a mean over the step.
    pub stop: f64,
    /// Whether the joint is held: it sticks, or rests at a stop.
    pub is_held: bool,
}

/// Response of the relative coordinate of each joint in a state; `None` for joints without friction and stops.
pub fn coordinate_response(system: &System, state: &State, joint: &Joint) -> Option<CoordinateResponse> {
    let (row, law) = joint.law_row()?;
    let coordinate = state.coordinates.iter().find(|c| c.joint == joint.number)?;
    let u = if state.middle.is_empty() { &state.u } else { &state.middle };
    let limit = law.limit(joint, &state.multipliers, |v| current(system, u, v));
    let multiplier = state.multipliers.get(row).copied().unwrap_or(f64::NAN);
    let [friction, stop] = parts(&coordinate.mode, &limit, multiplier);
    let (value, is_angle, is_held) = (coordinate.value, law.is_angle, coordinate.mode.is_held());
    Some(CoordinateResponse { value, is_angle, friction, stop, is_held })
}

/// Length, and force that draws its points together, of each spring in a state. Dampers act with the rates of the state; for the
/// energy–momentum scheme of second order with the mean rates of the last step, since the velocity at its end alternates where a damper is
/// much stiffer than the mass over the step.
pub fn spring_lengths_and_forces(system: &System, state: &State) -> Vec<[f64; 2]> {
    let time = state.time.max(0.0);
    let value = |v: usize| current(system, &state.u, v as u32);
    if !state.middle.is_empty() {
        let start = |v: usize| start_of_step(system, state, v as u32);
        let ends: [&dyn Fn(usize) -> Vec3; 2] = [&start, &value];
        let of = |(_, spring): &(_, Spring)| spring.length_and_force_of_step(ends, state.last_step, time);
        return system.springs.iter().map(of).collect();
    }
    let rates = rigid_rates(system, state);
    let rate = |v: usize| rates.get(v).copied().map_or_else(Vec3::zeros, Vec3::from);
    system.springs.iter().map(|(_, spring)| spring.length_and_force(value, rate, time)).collect()
}

/// Angle (rad), continued over full turns, and moment of each torsion spring in a state, with the rates of
/// [springs](spring_lengths_and_forces).
pub fn torsion_angles_and_moments(system: &System, state: &State) -> Vec<[f64; 2]> {
    let (factors, point): (Vec<f64>, _) =
        (system.factors(state.time).collect(), state.point_with_rates(system));
    let start: Vec<Nodal> = match state.middle.is_empty() || system.torsion_springs.is_empty() {
        true => Vec::new(),
        false => (0..state.u.len()).map(|v| displacement_at_start(state, v)).collect(),
    };
    let before = EvaluationPoint::at_rest(system, &start, state.time, state.internal());
    let of = |(spring, [group, number]): &(TorsionSpring, [usize; 2])| {
        let [before, point] = [&before, &point].map(|point| point.of_group(system, *group, &factors));
        let last_step = (!start.is_empty()).then_some((&before, state.last_step));
        spring.angle_and_moment(&point, *number, last_step)
    };
    system.torsion_springs.iter().map(of).collect()
}

/// Displacement, rotation, force and moment of each bushing in a state, with the rates of [springs](spring_lengths_and_forces).
pub fn bushing_responses(system: &System, state: &State) -> Vec<BushingResponse> {
    let value = |v: u32| current(system, &state.u, v);
    if !state.middle.is_empty() {
        let start = |v: u32| start_of_step(system, state, v);
        let ends: [&dyn Fn(u32) -> Vec3; 2] = [&start, &value];
        let of = |bushing: &Bushing| bushing.response_of_step(ends, state.last_step);
        return system.bushings.iter().map(of).collect();
    }
    let rates = rigid_rates(system, state);
    let rate = |v: u32| rates.get(v as usize).copied().map_or_else(Vec3::zeros, Vec3::from);
    system.bushings.iter().map(|bushing| bushing.response(value, rate)).collect()
}

/// Displacement of a nodal vector at the start of the last step, for the energy–momentum scheme of second order.
fn displacement_at_start(state: &State, v: usize) -> Nodal {
    std::array::from_fn(|i| 2.0 * state.middle[v][i] - state.u[v][i])
}

fn start_of_step(system: &System, state: &State, v: u32) -> Vec3 {
    Vec3::from(system.coordinates.reference[v as usize])
        + Vec3::from(displacement_at_start(state, v as usize))
}

/// Velocities of the nodal vectors, those of bodies as rigid motions with their angular velocity. The rates of directors in the
/// energy–momentum scheme follow a rotation over the step only to second order.
fn rigid_rates(system: &System, state: &State) -> Vec<Nodal> {
    let mut rates = state.v.clone();
    if !rates.is_empty() {
        project_director_velocities(system, &state.u, &mut rates);
    }
    rates
}

pub(super) fn current(system: &System, u: &[Nodal], v: u32) -> Vec3 {
    Vec3::from(system.coordinates.reference[v as usize]) + Vec3::from(u[v as usize])
}
