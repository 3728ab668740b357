//! Reactions of joints against the change of momentum, and along the axes of joints.

use crate::common::Notes;
use crate::generalized_alpha::with_scheme;
use crate::multibody::{axis_joint, between, body, gravity, machine, revolute, run, spherical};
use tegula::Vec3;
use tegula::model::*;
use tegula::norm::{larger, max_norm};
use tegula::result::{JointResponse, joint_reaction};

/// The reaction of the energy–momentum scheme is the mean of a step: with the weight it changes the momentum, exactly, also where the
/// direction of the constraint turns.
#[test]
fn the_reaction_of_a_rod_is_the_change_of_momentum_of_each_step() {
    let rod = Joint::Distance(DistanceJoint {
        name: "rod".into(),
        between: between("ground", "m"),
        points: [[0.0; 3], [1.0, 0.0, 0.0]],
    });
    let mut model = machine(0.6, 0.02, vec![body("m", [1.0, 0.0, 0.0], 1.5, None)], vec![rod]);
    model.loads = gravity([0.0, -10.0, 0.0]);
    let mut notes = Notes::keeping();
    let (system, _) = run(&model, &mut notes);
    let mut worst = Vec::new();
    for pair in notes.states.windows(2) {
        let centre = system.coordinates.bodies[0].centre as usize;
        let [before, after] = [0, 1].map(|i: usize| Vec3::from(pair[i].v[centre]));
        let dt = pair[1].time - pair[0].time;
        let (force, _) = joint_reaction(&system, &pair[1], &system.joints[0]);
        worst.push(((after - before) * (1.5 / dt) + Vec3::new(0.0, 15.0, 0.0) - force).norm());
    }
    assert!(worst.len() > 20 && max_norm(&worst) < 1e-9, "{worst:?}");
}

/// Two bodies move on a joint whose axis lies askew. Of its force (f₁, f₂, f₃) and moment (m₁, m₂, m₃) the joint does not transmit the
/// components with the given numbers from 0 to 5.
#[test]
fn components_that_a_joint_does_not_transmit_vanish_along_its_axes() {
    let (at, axis) = ([1.0, 0.1, 0.2], [0.3, -0.5, 0.8]);
    let keys = || axis_joint("joint", "a", "b", at, axis);
    let universal = Joint::Universal(TwoAxesJoint {
        name: "joint".into(),
        between: between("a", "b"),
        at,
        axes: [axis, [0.5, 0.3, 0.0]],
        second_at: None,
    });
    let joints: [(Joint, &[usize]); 6] = [
        (spherical("a", "b", at), &[3, 4, 5]),
        (revolute("joint", "a", "b", at, axis), &[5]),
        (universal, &[5]),
        (Joint::Cylindrical(keys()), &[2, 5]),
        (Joint::Prismatic(keys().into()), &[2]),
        (Joint::Planar(keys()), &[0, 1, 5]),
    ];
    let schemes = [
        Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 }),
        Scheme::EnergyMomentum(EnergyMomentumScheme { order: 4 }),
        Scheme::GeneralizedAlpha(GeneralizedAlphaScheme { spectral_radius: 0.8 }),
        Scheme::Hht(HhtScheme { alpha: -0.1 }),
        Scheme::Bdf2(Bdf2Scheme {}),
    ];
    for (joint, free) in joints {
        for scheme in schemes {
            let bodies = vec![
                body("a", [0.5, 0.0, 0.0], 2.0, Some([0.1, 0.2, 0.25])),
                body("b", [1.5, 0.3, 0.1], 1.0, Some([0.05, 0.03, 0.04])),
            ];
            let joints = vec![spherical("ground", "a", [0.0; 3]), joint.clone()];
            let model = Model { loads: gravity([1.0, 2.0, -9.81]), ..machine(0.3, 0.01, bodies, joints) };
            let mut notes = Notes::keeping();
            let (system, _) = run(&with_scheme(&model, scheme, 0.3, 0.01), &mut notes);
            let turned = notes.states.last().unwrap();
            let axes = JointResponse::new(&system, turned, &system.joints[1]).axes.unwrap();
            assert!((axes.determinant() - 1.0).abs() < 1e-9, "{joint:?}: {axes}");
            assert!(
                (axes.column(2).dot(&Vec3::from(axis).normalize()) - 1.0).abs() > 1e-3,
                "{joint:?}: {axes}"
            );
            let (mut largest, mut left) = (0.0, 0.0);
            for state in &notes.states {
                let response = JointResponse::new(&system, state, &system.joints[1]);
                let [force, moment] = response.along_axes().unwrap();
                let size = force.norm() + moment.norm();
                assert!((size - response.force.norm() - response.moment.norm()).abs() < 1e-9 * size);
                let components: Vec<f64> = force.iter().chain(moment.iter()).copied().collect();
                largest = larger(largest, size);
                left = free.iter().fold(left, |left, i| larger(left, components[*i].abs()));
                let carried = (0..6).filter(|i| !free.contains(i)).map(|i| components[i].abs());
                assert!(carried.fold(0.0, larger) > 0.1 * size);
            }
            // Means over a step act along means of axes, which are perpendicular to each other up to the square of the rotation in the step.
            let is_mean = scheme == schemes[0] && free.contains(&2);
            let limit = if is_mean { 1e-3 } else { 1e-9 };
            assert!(largest > 1.0 && left < limit * largest, "{joint:?} {scheme:?}: {left} of {largest}");
        }
    }
}

/// An arm that turns at a constant speed: the bearing pulls it along its own axis with m ω² r, whatever its position.
#[test]
fn the_bearing_of_a_turning_arm_pulls_along_the_axes_of_the_arm() {
    let (mass, radius, omega) = (2.0, 0.5, 10.0);
    let arm = RigidBody {
        angular_velocity: [0.0, 0.0, omega],
        velocity: [0.0, omega * radius, 0.0],
        ..body("arm", [radius, 0.0, 0.0], mass, Some([0.01, 0.02, 0.02]))
    };
    let hinge = revolute("hinge", "ground", "arm", [0.0; 3], [0.0, 0.0, 1.0]);
    let model = with_scheme(
        &machine(1.0, 1e-3, vec![arm], vec![hinge]),
        Scheme::GeneralizedAlpha(GeneralizedAlphaScheme { spectral_radius: 0.8 }),
        1.0,
        1e-3,
    );
    let mut notes = Notes::keeping();
    let (system, _) = run(&model, &mut notes);
    let pull = mass * omega * omega * radius;
    for state in &notes.states {
        let [force, moment] = JointResponse::new(&system, state, &system.joints[0]).along_axes().unwrap();
        let error = larger((force + Vec3::x() * pull).norm(), moment.norm());
        assert!(error < 1e-3 * pull, "{} {force} {moment}", state.time);
    }
}
