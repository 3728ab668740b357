//! Clearance of bearings and guides: springs that act beyond a radial clearance, between points or across an axis.

use crate::common::Notes;
use crate::multibody::{axis_joint, between, body, machine, run};
use crate::torsion_springs::{displaced, tangent_of_group_is_derivative};
use tegula::analysis::State;
use tegula::model::*;
use tegula::norm::{larger, max_norm};
use tegula::result::BodyMotion;
use tegula::{Mat3, Vec3};

const GAP: f64 = 1e-3;
const STIFFNESS: f64 = 1e7;
const MASS: f64 = 2.0;

/// A journal in a bearing with the radial clearance [`GAP`], whose surfaces resist the depth δ by `k δ^n`; it starts at the centre.
fn journal(velocity: [f64; 3], end: f64, (step, exponent): (f64, f64)) -> Model {
    let journal = RigidBody { velocity, ..body("journal", [0.0; 3], MASS, Some([1e-3; 3])) };
    let guide = axis_joint("guide", "ground", "journal", [0.0; 3], [0.0, 0.0, 1.0]);
    let contact = SpringDamper {
        across: None,
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

/// A journal that moves in a plane: its distance from the axis is that from the centre of the bearing.
#[test]
fn a_spring_across_the_axis_of_a_bearing_is_that_between_its_centres() {
    let place = |across: Option<[f64; 3]>| {
        let mut model = journal([0.15, 0.1, 0.0], 0.05, (2e-5, 1.5));
        model.bodies[0].at = [0.0, -0.5 * GAP, 0.0];
        model.springs[0].points[1] = model.bodies[0].at;
        model.springs[0].across = across;
        let (system, state) = run(&model, &mut Notes::default());
        BodyMotion::new(&system, &state, &system.coordinates.bodies[0]).position
    };
    let [between, across] = [None, Some([0.0, 0.0, 2.0])].map(place);
    assert!(between.norm() > 0.3 * GAP && (between - across).norm() < 1e-9 * GAP, "{between} {across}");
}

/// Half length of a slider.
const HALF: f64 = 0.05;

/// A slider in a guide along an axis: both of its ends have the radial clearance [`GAP`]. The guide is a free body.
fn slider(turn: &Mat3, (end, step): (f64, f64)) -> Model {
    let turned = |x: [f64; 3]| <[f64; 3]>::from(turn * Vec3::from(x));
    let axes = [turned([1.0, 0.0, 0.0]), turned([0.0, 1.0, 0.0])];
    let guide = RigidBody { axes, ..body("guide", [0.0; 3], 5.0, Some([0.02, 0.05, 0.06])) };
    let slider = RigidBody {
        axes,
        velocity: turned([0.3, 0.2, 0.1]),
        angular_velocity: turned([0.5, 1.0, -3.0]),
        ..body("slider", [0.0; 3], MASS, Some([1e-3, 2e-3, 2e-3]))
    };
    let contact = |(name, at): (&str, f64)| SpringDamper {
        across: Some(axes[0]),
        name: name.into(),
        between: between("guide", "slider"),
        points: [[0.0; 3], turned([at, 0.0, 0.0])],
        stiffness: 0.0,
        damping: 0.0,
        length: Some(GAP),
        force: Some(format!("{}*max(x, 0)^2", STIFFNESS / GAP.sqrt())),
    };
    Model {
        springs: [("left", -HALF), ("right", HALF)].map(contact).to_vec(),
        ..machine(end, step, vec![guide, slider], Vec::new())
    }
}

/// The ends of the slider bounce between the walls of the guide, which moves with them: energy and momenta are kept, and no force acts along the guide.
#[test]
fn a_slider_rattles_in_its_guide_and_keeps_energy_and_momenta() {
    let mut notes = Notes::keeping();
    let (system, _) = run(&slider(&Mat3::identity(), (0.3, 2e-5)), &mut notes);
    assert!(notes.drift() < 1e-10 * notes.kinetic, "{} {}", notes.drift(), notes.kinetic);
    let (first, last) = (notes.momenta[0], notes.momenta.last().unwrap());
    assert!((last.0 - first.0).norm() < 1e-10 * first.0.norm(), "{first:?} {last:?}");
    assert!((last.1 - first.1).norm() < 1e-10 * first.1.norm(), "{first:?} {last:?}");
    let lengths = |state: &State| {
        let at = |v: usize| Vec3::from(system.coordinates.reference[v]) + Vec3::from(state.u[v]);
        let of = |(_, spring): &(String, tegula::constraint::Spring)| {
            spring.length_and_force(at, |_| Vec3::zeros(), 0.0)[0]
        };
        max_norm(system.springs.iter().map(of))
    };
    let apart: Vec<f64> = notes.states.iter().map(lengths).collect();
    let farthest = max_norm(apart.iter().copied());
    // No contact stores more than the whole energy, ⅓ k δ³.
    let deepest = (3.0 * notes.kinetic / (STIFFNESS / GAP.sqrt())).cbrt();
    assert!(farthest > 1.01 * GAP && farthest < GAP + deepest, "{farthest} {deepest}");
    // It rattles: the walls are hit more than ten times.
    let hits = apart.windows(2).filter(|pair| pair[0] <= GAP && pair[1] > GAP).count();
    assert!(hits > 10, "{hits}");
}

/// The motion does not depend on the frame in which the guide lies.
#[test]
fn a_slider_in_a_turned_guide_moves_likewise() {
    let place = |turn: &Mat3| {
        let (system, state) = run(&slider(turn, (0.02, 2e-5)), &mut Notes::default());
        turn.transpose() * BodyMotion::new(&system, &state, &system.coordinates.bodies[1]).position
    };
    let turn = nalgebra::Rotation3::from_euler_angles(0.4, -1.1, 2.0).into_inner();
    let [one, other] = [Mat3::identity(), turn].map(|turn| place(&turn));
    assert!((one - other).norm() < 1e-9 * GAP, "{one} {other}");
}

/// The tangent of a spring across an axis is the derivative of its forces, under a force.
#[test]
fn the_tangent_of_a_spring_across_an_axis_is_the_derivative_of_its_forces() {
    let mut model = slider(&Mat3::identity(), (0.02, 1e-3));
    model.springs.truncate(1);
    model.springs[0].points[1] = [0.05, 0.03, -0.02];
    (model.springs[0].length, model.springs[0].force) = (Some(0.01), Some("3*x + 2*x^2".into()));
    let system = crate::assembly::built(&model);
    let group = system.groups.iter().find(|group| group.name() == "spring").unwrap();
    let u = displaced(&system);
    tangent_of_group_is_derivative(&system, group.as_ref(), (&u, &[]));
}
