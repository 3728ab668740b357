//! Rotations in constant time steps that are long for them: what is told, and by how much they lag behind.

use crate::common::Notes;
use crate::multibody::{body, machine, run, spin};
use tegula::model::*;
use tegula::result::bodies::BodyMotion;
use tegula::{Vec3, compile, mesh};

/// Scheme of fourth order.
const FOURTH: Scheme = Scheme::EnergyMomentum(EnergyMomentumScheme { order: 4 });

/// Change of the options of a motion.
type Change = fn(&mut TransientAnalysis);

/// Angle that a wheel with the angular velocity 1 rad/time has turned by at the time 2, and what was told.
fn turned(change: impl Fn(&mut TransientAnalysis)) -> (f64, Vec<String>) {
    let wheel =
        RigidBody { angular_velocity: [0.0, 0.0, 1.0], ..body("wheel", [0.0; 3], 2.0, Some([1.0; 3])) };
    let mut model = machine(2.0, 0.5, vec![wheel], Vec::new());
    let Analysis::Transient(options) = &mut model.analysis else { panic!("no motion") };
    change(options);
    let options = options.clone();
    let system = compile::build(&model, &mesh::generators::generate(&model.mesh).unwrap()).unwrap();
    let mut notes = Notes::default();
    let outcome = tegula::analysis::dynamics::run(&system, &options, None, &mut notes).unwrap();
    let axes = BodyMotion::new(&system, &outcome.state, &system.coordinates.bodies[0]).axes;
    let x: Vec3 = axes.column(0).into_owned();
    (x.y.atan2(x.x), notes.events)
}

/// A step of Δt turns the wheel by 2 atan(½ωΔt): by 2 % less than ωΔt where that is half a radian.
#[test]
fn a_rotation_that_lags_behind_is_told_with_the_lag() {
    let (angle, events) = turned(|_| {});
    assert!((angle - 8.0 * 0.25f64.atan()).abs() < 1e-9, "{angle}");
    let lag = 1.0 - angle / 2.0;
    assert!((lag - 0.02008).abs() < 1e-4, "{lag}");
    let told: Vec<_> = events.iter().filter(|event| event.contains("lags behind by 2 % or more")).collect();
    assert!(told.len() == 1 && told[0].contains("\"wheel\" turns by 0.49 rad"), "{events:?}");
}

#[test]
fn rotations_in_short_automatic_and_composed_steps_are_not_told() {
    let changes: [(f64, Change); 3] = [
        (1e-2, |options| options.time_step = Some(0.2)),
        (1e-3, |options| options.time_step = None),
        (1e-3, |options| options.scheme = FOURTH),
    ];
    for (tolerance, change) in changes {
        let (angle, events) = turned(change);
        assert!((angle / 2.0 - 1.0).abs() < tolerance, "{angle}");
        assert!(events.iter().all(|event| !event.contains("lags behind")), "{events:?}");
    }
}

/// A constant step in which a body would turn by more than half a turn is cut back: its equations have other solutions.
#[test]
fn steps_in_which_a_body_turns_too_far_are_cut_back() {
    let load = Load::Moment(VectorLoad::new("disc", [0.0, 0.0, 50.0]));
    let disc = body("disc", [0.0; 3], 1.0, Some([1.0; 3]));
    let model = Model { loads: vec![load], ..machine(5.0, 1.0, vec![disc], Vec::new()) };
    let mut notes = Notes::default();
    let (system, state) = run(&model, &mut notes);
    assert!(notes.events.iter().all(|e| e.contains("cut-back") || e.contains("lags behind")));
    assert!(notes.events.iter().any(|e| e.contains("cut-back")));
    let omega = spin(&system, &state, 0).z;
    // Steps of up to 2 rad: the angular velocity has the error of the second-order scheme, the momentum has none.
    assert!((omega / 250.0 - 1.0).abs() < 0.2, "{omega}");
    let (_, momentum) = notes.momenta[notes.momenta.len() - 1];
    assert!((momentum.z / 250.0 - 1.0).abs() < 1e-9, "{momentum}");
}

/// Constant steps of many turns are cut back: the equations of a step have other solutions there, in which the body turns back.
#[test]
fn a_step_of_many_turns_is_cut_back() {
    let omega = [0.0, 0.0, 1000.0];
    let top = RigidBody { angular_velocity: omega, ..body("top", [0.0; 3], 1.0, Some([1.0, 1.5, 2.0])) };
    for step in [0.05, 2e-3 * std::f64::consts::PI] {
        let mut notes = Notes::default();
        let (system, state) = run(&machine(0.1, step, vec![top.clone()], Vec::new()), &mut notes);
        assert!(notes.drift() <= 1e-9 * notes.kinetic, "{step}: {}", notes.drift());
        assert!((spin(&system, &state, 0).z / 1000.0 - 1.0).abs() < 1e-6, "{}", spin(&system, &state, 0));
        assert!(state.step >= 50, "{} steps of at most 2 rad", state.step);
    }
}
