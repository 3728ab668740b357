//! Clearance of a bearing: a planar joint with a spring that acts beyond the radial clearance.

use crate::common::Notes;
use crate::multibody::{axis_joint, between, body, machine, run};
use tegula::model::*;
use tegula::norm::{larger, max_norm};
use tegula::result::BodyMotion;

const GAP: f64 = 1e-3;
const STIFFNESS: f64 = 1e7;
const MASS: f64 = 2.0;

/// A journal in a bearing with the radial clearance [`GAP`], whose surfaces resist the depth δ by `k δ^n`; it starts at the centre.
fn journal(velocity: [f64; 3], end: f64, (step, exponent): (f64, f64)) -> Model {
    let journal = RigidBody { velocity, ..body("journal", [0.0; 3], MASS, Some([1e-3; 3])) };
    let guide = axis_joint("guide", "ground", "journal", [0.0; 3], [0.0, 0.0, 1.0]);
    let contact = SpringDamper {
        name: "contact".into(),
        between: between("ground", "journal"),
        points: [[0.0; 3]; 2],
        stiffness: 0.0,
        damping: 0.0,
        length: Some(GAP),
        force: Some(format!("{STIFFNESS}*max(x, 0)^{exponent}")),
    };
    Model { springs: vec![contact], ..machine(end, step, vec![journal], vec![Joint::Planar(guide)]) }
}

/// The depth of an impact along the radius is that of Hertz, `½ m v² = k δ^2.5/2.5`, and the journal crosses the clearance again and
/// again without a loss.
#[test]
fn a_journal_bounces_in_its_clearance_as_deep_as_its_energy_says() {
    let speed = 0.2;
    let deepest = (2.5 * 0.5 * MASS * speed * speed / STIFFNESS).powf(0.4);
    let mut notes = Notes::keeping();
    let (system, _) = run(&journal([speed, 0.0, 0.0], 0.05, (2e-5, 1.5)), &mut notes);
    let places: Vec<f64> = notes
        .states
        .iter()
        .map(|state| BodyMotion::new(&system, state, &system.coordinates.bodies[0]).position.x)
        .collect();
    let [right, left] = [1.0, -1.0].map(|sign| places.iter().map(|x| sign * x).fold(0.0, larger) - GAP);
    for found in [right, left] {
        assert!((found / deepest - 1.0).abs() < 1e-3, "{found} {deepest}");
    }
    assert!(notes.drift() < 1e-9 * notes.kinetic, "{} {}", notes.drift(), notes.kinetic);
}

/// Aslant, the journal runs round in its bearing; the contact acts towards the centre and keeps the moment of momentum about it.
#[test]
fn a_journal_runs_round_in_its_clearance_with_constant_moment_of_momentum() {
    // The work of a polynomial is exact in each step, that of the power 1.5 up to the Gauss rule where the contact begins.
    for (exponent, drift) in [(2.0, 1e-12), (1.5, 1e-9)] {
        let stiffness = STIFFNESS * GAP.powf(1.5 - exponent);
        let mut model = journal([0.15, 0.1, 0.0], 0.1, (2e-5, exponent));
        model.bodies[0].at = [0.0, -0.5 * GAP, 0.0];
        model.springs[0].points[1] = model.bodies[0].at;
        model.springs[0].force = Some(format!("{stiffness}*max(x, 0)^{exponent}"));
        let mut notes = Notes::keeping();
        let (system, _) = run(&model, &mut notes);
        let first = notes.momenta[0].1;
        let apart = max_norm(notes.momenta.iter().map(|m| (m.1 - first).norm()));
        assert!(first.norm() > 1e-4 && apart < 1e-10 * first.norm(), "{apart} {first}");
        assert!(notes.drift() < drift * notes.kinetic, "{exponent}: {} {}", notes.drift(), notes.kinetic);
        let place = |state| BodyMotion::new(&system, state, &system.coordinates.bodies[0]).position.norm();
        let farthest = max_norm(notes.states.iter().map(place));
        assert!(farthest > GAP && farthest < 2.0 * GAP, "{farthest}");
    }
}
