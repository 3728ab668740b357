//! The HHT method with bodies and joints: second order in positions, velocities and multipliers, its published recurrence, its damping.

use crate::common::Notes;
use crate::composition::{errors_of_pendulum, hung, pendulum};
use crate::generalized_alpha::{heavy_top, ratios, with_scheme};
use crate::multibody::{body, machine, pose, revolute, run};
use tegula::Vec3;
use tegula::model::*;
use tegula::norm::larger;
use tegula::result::{BodyMotion, ReactionFinder, joint_reaction};

fn scheme(alpha: f64) -> Scheme {
    Scheme::Hht(HhtScheme { alpha })
}

/// Position, velocity and tension of the pendulum at 2 s: exact by elliptic functions (IFToMM benchmark A01).
#[test]
fn hht_moves_a_pendulum_with_second_order_in_position_velocity_and_reaction() {
    let (place, turning) = (Vec3::new(-0.7935661953, -0.6084839304, 0.0), -3.4552068991);
    for alpha in [-1.0 / 3.0, -0.1, -0.05, 0.0] {
        let errors = [2e-3, 1e-3, 5e-4].map(|step| {
            let found = run(&with_scheme(&pendulum(), scheme(alpha), 2.0, step), &mut Notes::default());
            errors_of_pendulum(&found, place, turning)
        });
        for i in 0..3 {
            let ratios = [errors[0][i] / errors[1][i], errors[1][i] / errors[2][i]];
            println!("{alpha} {i}: {ratios:?} {}", errors[2][i]);
            assert!(ratios.iter().all(|r| (3.7..4.3).contains(r)), "{alpha} {i}: {ratios:?} {errors:?}");
        }
    }
}

#[test]
fn hht_is_of_second_order_for_a_top_and_for_a_body_on_a_shell() {
    for (model, end, steps) in [(heavy_top(), 0.04, 800), (hung(), 0.256, 256)] {
        let found = ratios(&model, scheme(-0.1), end, steps);
        println!("{found:?}");
        assert!(found.iter().all(|r| (3.7..4.3).contains(r)), "{found:?}");
    }
}

/// A point mass on a spring. Three invariants of the published recurrence relate four successive positions, whatever the start.
#[test]
fn hht_with_bodies_repeats_its_published_recurrence_on_a_spring() {
    let (mass, omega, step) = (2.0, 5.0_f64, 0.2);
    for alpha in [-1.0 / 3.0, -0.1, 0.0] {
        let invariants = characteristic_polynomial(amplification(alpha, omega * step));
        let start = RigidBody { velocity: [0.5, 0.0, 0.0], ..body("mass", [1.0, 0.0, 0.0], mass, None) };
        let spring = SpringDamper {
            across: None,
            name: "spring".into(),
            between: ["ground".into(), "mass".into()],
            points: [[0.0; 3], [1.0, 0.0, 0.0]],
            stiffness: mass * omega * omega,
            damping: 0.0,
            force: None,
            length: None,
        };
        let model = Model { springs: vec![spring], ..machine(4.0, step, vec![start], Vec::new()) };
        let mut notes = Notes::keeping();
        let (system, _) = run(&with_scheme(&model, scheme(alpha), 4.0, step), &mut notes);
        let x: Vec<f64> = notes.states.iter().map(|state| pose(&system, state, 0).0.x - 1.0).collect();
        let rest = x
            .windows(4)
            .map(|w| (w[3] + invariants[0] * w[2] + invariants[1] * w[1] + invariants[2] * w[0]).abs());
        let rest = rest.fold(0.0, larger);
        assert!(x.len() == 21 && rest < 1e-10, "{alpha}: {rest} {x:?}");
        // The balance of reactions is that of the end of a step.
        let mut finder = ReactionFinder::new(&system, Some(scheme(alpha)));
        for pair in notes.states.windows(2) {
            let balance = finder.find(&system, Some(&pair[0]), &pair[1]);
            assert!(balance.force_error < 1e-8, "{alpha}: {}", balance.force_error);
        }
    }
}

/// Amplification matrix of u, Δt v, Δt² a by the recurrence of Hilber, Hughes and Taylor (1977) for ü + ω² u = 0.
fn amplification(alpha: f64, omega_step: f64) -> [[f64; 3]; 3] {
    let (beta, gamma, square) = (0.25 * (1.0 - alpha).powi(2), 0.5 - alpha, omega_step * omega_step);
    let mut columns = [[0.0; 3]; 3];
    for (j, column) in columns.iter_mut().enumerate() {
        let mut old = [0.0; 3];
        old[j] = 1.0;
        let [u, v, a] = old;
        let foretold = u + v + (0.5 - beta) * a;
        let new =
            (-(1.0 + alpha) * square * foretold + alpha * square * u) / (1.0 + (1.0 + alpha) * square * beta);
        *column = [foretold + beta * new, v + (1.0 - gamma) * a + gamma * new, new];
    }
    columns
}

/// Coefficients of z², z and 1 in det(z I − A).
fn characteristic_polynomial(a: [[f64; 3]; 3]) -> [f64; 3] {
    let minor = |i: usize, j: usize| a[i][i] * a[j][j] - a[i][j] * a[j][i];
    let [x, y, z] = a.map(Vec3::from);
    [-(a[0][0] + a[1][1] + a[2][2]), minor(0, 1) + minor(0, 2) + minor(1, 2), -x.dot(&y.cross(&z))]
}

/// A drive by a sine: the torque J θ̈ of the first rows is of second order, too, with the accelerations of the start on the constraints.
#[test]
fn torques_of_the_first_steps_are_of_second_order() {
    let generalized = |spectral_radius| Scheme::GeneralizedAlpha(GeneralizedAlphaScheme { spectral_radius });
    for scheme in [scheme(-0.1), scheme(-1.0 / 3.0), generalized(0.8), generalized(0.5), generalized(0.0)] {
        let error = |step: f64| {
            let arm = body("arm", [0.5, 0.0, 0.0], 2.0, Some([0.1; 3]));
            let hinge = revolute("hinge", "ground", "arm", [0.0; 3], [0.0, 0.0, 1.0]);
            let drive = Joint::DrivenAngle(DrivenAngleJoint {
                name: "drive".into(),
                between: ["ground".into(), "arm".into()],
                axis: [0.0, 0.0, 1.0],
                angle: 1.0_f64.to_degrees(),
                amplitude: "turn".into(),
            });
            let mut model = machine(1.0, step, vec![arm], vec![hinge, drive]);
            let expression = "0.8*sin(3*t + 0.4)".into();
            model.amplitudes.insert("turn".into(), Amplitude::Expression(ExpressionAmplitude { expression }));
            let mut notes = Notes::keeping();
            let (system, _) = run(&with_scheme(&model, scheme, 6.0 * step, step), &mut notes);
            notes.states.iter().fold(0.0, |worst, state| {
                let (_, moment) = joint_reaction(&system, state, &system.joints[1]);
                let exact = -0.8 * 9.0 * (3.0 * state.time + 0.4).sin() * 0.1;
                let (force, _) = joint_reaction(&system, state, &system.joints[0]);
                // The drive is a pure moment; the force of the hinge about the mass centre takes the rest.
                let rate = 0.8 * 3.0 * (3.0 * state.time + 0.4).cos();
                let acceleration = exact / 0.1;
                let pull = 2.0 * 0.5 * (rate.powi(4) + acceleration * acceleration).sqrt();
                let total = acceleration * (0.1 + 2.0 * 0.25);
                larger(worst, larger((moment.z - total).abs(), (force.norm() - pull).abs()))
            })
        };
        let errors = [8e-3, 4e-3, 2e-3].map(error);
        println!("{scheme:?}: {errors:?}");
        let ratios = [errors[0] / errors[1], errors[1] / errors[2]];
        assert!(errors[2] < 1e-3 && ratios.iter().all(|r| *r > 3.5), "{scheme:?}: {errors:?}");
    }
}

/// A free ball keeps its spin within the damping of the scheme, and never gains any.
#[test]
fn hht_feeds_no_spin_into_a_body_that_turns_by_a_fifth_of_a_radian_in_a_step() {
    for (alpha, least) in [(-1.0 / 3.0, 0.97), (-0.1, 0.98), (-0.05, 0.98), (0.0, 0.9999)] {
        for angle in [0.05, 0.1, 0.2] {
            let ball = RigidBody {
                angular_velocity: [0.0, 0.0, 100.0],
                ..body("ball", [0.0; 3], 1.0, Some([0.004; 3]))
            };
            let model = machine(5.0 * angle, angle / 100.0, vec![ball], Vec::new());
            let model = with_scheme(&model, scheme(alpha), 5.0 * angle, angle / 100.0);
            let (system, state) = run(&model, &mut Notes::default());
            let spin = BodyMotion::new(&system, &state, &system.coordinates.bodies[0]).angular_velocity.z;
            println!("{alpha} {angle}: {spin}");
            assert!(spin > 100.0 * least && spin < 100.0 * (1.0 + 1e-9), "{alpha} {angle}: {spin}");
        }
    }
}
