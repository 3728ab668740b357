//! Rotations in constant time steps that are long for them: what is told, and by how much they lag behind.

use crate::common::Notes;
use crate::multibody::{body, machine};
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
