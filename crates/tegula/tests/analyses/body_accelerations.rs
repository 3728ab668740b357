//! Accelerations of bodies in all schemes that move them.

use crate::common::Notes;
use crate::generalized_alpha::with_scheme;
use crate::multibody::{body, gravity, machine, pose, revolute, run};
use tegula::analysis::State;
use tegula::model::*;
use tegula::norm::larger;
use tegula::result::BodyMotion;
use tegula::{System, Vec3};

const MASS: f64 = 2.0;
const ARM: f64 = 0.5;
const INERTIA: [f64; 3] = [0.07, 0.05, 0.1];

/// The schemes that move bodies, each with the limit of its errors.
fn schemes(limits: [f64; 5]) -> Vec<(Scheme, f64)> {
    let schemes = [
        Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 }),
        Scheme::EnergyMomentum(EnergyMomentumScheme { order: 4 }),
        Scheme::GeneralizedAlpha(GeneralizedAlphaScheme { spectral_radius: 0.8 }),
        Scheme::Bdf2(Bdf2Scheme {}),
        Scheme::Explicit(ExplicitScheme { scale_director_inertia: true }),
    ];
    schemes.into_iter().zip(limits).collect()
}

/// A compound pendulum that is released at the horizontal, and turns about the axis z.
fn pendulum() -> Model {
    let arm = body("arm", [ARM, 0.0, 0.0], MASS, Some(INERTIA));
    let hinge = revolute("hinge", "ground", "arm", [0.0; 3], [0.0, 0.0, 1.0]);
    Model { loads: gravity([0.0, -9.81, 0.0]), ..machine(1.0, 1e-2, vec![arm], vec![hinge]) }
}

/// Errors of acceleration and angular acceleration in a state, over g/L: `α = −m g x/(J + m L²)`, `a = α × r − ω² r`.
fn errors(system: &System, state: &State) -> [f64; 2] {
    let found = BodyMotion::new(system, state, &system.coordinates.bodies[0]);
    let middle = !state.middle.is_empty();
    let place = if middle {
        let u = Vec3::from(state.middle[system.coordinates.bodies[0].centre as usize]);
        Vec3::new(ARM, 0.0, 0.0) + u
    } else {
        pose(system, state, 0).0
    };
    let lever = MASS / (INERTIA[2] + MASS * ARM * ARM);
    // From rest at the horizontal the energy gives ω² = −2 m g y/(J + m L²).
    let (spin_up, squared) = (-9.81 * place.x * lever, -2.0 * 9.81 * place.y * lever);
    let acceleration = Vec3::z().cross(&place) * spin_up - place * squared;
    let scale = 9.81 / ARM;
    [
        (found.acceleration - acceleration).norm() / (9.81 * 2.0),
        (found.angular_acceleration - Vec3::z() * spin_up).norm() / scale,
    ]
}

/// A free body tumbles by Euler's equations `J ω̇ + ω × J ω = 0`; without a joint, and from the first step on. The velocities of the
/// energy–momentum scheme of second order alternate by a part of first order from step to step.
#[test]
fn angular_accelerations_of_a_free_body_satisfy_eulers_equations_with_each_scheme() {
    let moments = Vec3::new(0.1, 0.2, 0.25);
    let top =
        RigidBody { angular_velocity: [3.0, 2.0, 4.0], ..body("top", [0.0; 3], 2.0, Some(moments.into())) };
    let model = machine(0.1, 1e-3, vec![top], Vec::new());
    for (scheme, limits) in schemes([1e-3, 1e-10, 1e-4, 5e-3, 1e-10]) {
        let largest = [2e-3, 1e-3].map(|step| {
            let mut notes = Notes::keeping();
            let (system, _) = run(&with_scheme(&model, scheme, 0.1, step), &mut notes);
            let mut before: Option<BodyMotion> = None;
            let mut largest = 0.0;
            for state in &notes.states {
                let now = BodyMotion::new(&system, state, &system.coordinates.bodies[0]);
                let expected = |motion: &BodyMotion| {
                    let spin = motion.spin();
                    motion.axes * moments.component_mul(&spin).cross(&spin).component_div(&moments)
                };
                // Means over the step are compared with the mean of both ends.
                let exact = match before.filter(|_| !state.middle.is_empty()) {
                    Some(before) => 0.5 * (expected(&before) + expected(&now)),
                    None => expected(&now),
                };
                largest = larger(largest, (now.angular_acceleration - exact).norm() / exact.norm());
                before = Some(now);
            }
            largest
        });
        println!("{scheme:?}: {largest:?}");
        assert!(largest[1] < limits, "{scheme:?}: {largest:?}");
    }
}

#[test]
fn accelerations_of_a_pendulum_satisfy_its_equation_of_motion_with_each_scheme() {
    for (scheme, limit) in schemes([1e-5, 1e-10, 1e-5, 1e-4, 1e-4]) {
        let largest = [2e-3, 1e-3].map(|step| {
            let mut notes = Notes::keeping();
            let (system, _) = run(&with_scheme(&pendulum(), scheme, 1.0, step), &mut notes);
            assert!(notes.states.len() > 2, "{}", notes.states.len());
            let found = notes.states.iter().map(|state| errors(&system, state));
            found.fold([0.0; 2], |a, b| [larger(a[0], b[0]), larger(a[1], b[1])])
        });
        println!("{scheme:?}: {largest:?}");
        assert!(largest[1].iter().all(|error| *error < limit), "{scheme:?}: {largest:?}");
    }
}
