//! Friction and stops of joints against closed forms.

use crate::common::Notes;
use crate::multibody::{between, body, gravity, machine, pose, run};
use tegula::model::*;

const G: f64 = 10.0;

fn slide(friction: Option<JointFriction>, stops: Option<JointStops>, axis: [f64; 3]) -> Joint {
    let (name, between, at) = ("slide".into(), between("ground", "block"), [0.0; 3]);
    Joint::Prismatic(CoordinateJoint { name, between, at, axis, friction, stops })
}

/// Block on a slope that falls along −x by the slope's angle; its initial velocity is along x.
fn slope(angle: f64, mu: f64, speed: f64, end: f64, step: f64) -> Model {
    let friction = JointFriction { coefficient: mu, ..JointFriction::default() };
    let block =
        RigidBody { velocity: [speed, 0.0, 0.0], ..body("block", [0.0; 3], 2.0, Some([0.2, 0.25, 0.3])) };
    let (sine, cosine) = angle.sin_cos();
    let joint = slide(Some(friction), None, [1.0, 0.0, 0.0]);
    Model { loads: gravity([-G * sine, 0.0, -G * cosine]), ..machine(end, step, vec![block], vec![joint]) }
}

/// Below the angle of friction the block sticks.
#[test]
fn a_block_on_a_slope_below_the_angle_of_friction_sticks() {
    let mut notes = Notes::default();
    let (system, state) = run(&slope(0.2, 0.25, 0.0, 10.0, 0.01), &mut notes);
    let (x, _) = pose(&system, &state, 0);
    println!("drift {:e}", x.norm());
    assert!(x.norm() < 1e-9, "{x}");
}

/// Above it a = g (sin θ − μ cos θ).
#[test]
fn a_block_on_a_slope_above_the_angle_of_friction_slides() {
    let mut notes = Notes::default();
    let (system, state) = run(&slope(0.4, 0.25, 0.0, 2.0, 0.01), &mut notes);
    let (x, _) = pose(&system, &state, 0);
    let a = G * (0.4_f64.sin() - 0.25 * 0.4_f64.cos());
    println!("error {:e} energy {:e}", x.x + 2.0 * a, notes.drift());
    assert!((x.x + 2.0 * a).abs() < 1e-9, "{x}");
    assert!(notes.drift() <= 1e-9 * notes.kinetic, "{}", notes.drift());
}

/// A block that moves up or down the slope stops for good at v²/(2 a), with a = g (μ cos θ ± sin θ).
#[test]
fn a_moving_block_stops_for_good() {
    for speed in [1.5, -1.5_f64] {
        let mut notes = Notes::default();
        let (system, state) = run(&slope(0.2, 0.4, speed, 5.0, 0.01), &mut notes);
        let (x, _) = pose(&system, &state, 0);
        let a = G * (0.4 * 0.2_f64.cos() + speed.signum() * 0.2_f64.sin());
        let expected = speed.signum() * speed * speed / (2.0 * a);
        println!("error {:e} energy {:e}", x.x - expected, notes.drift());
        assert!((x.x - expected).abs() < 1e-9, "{x} {expected}");
        let v = state.v[system.coordinates.bodies[0].centre as usize];
        assert!(v[0].abs() < 1e-9, "{v:?}");
        assert!(notes.drift() <= 1e-9 * notes.kinetic, "{}", notes.drift());
    }
}

/// A mass falls from the height h on a stop: behind √(2h/g) (1 + e)/(1 − e) it rests there; the first rebound has the height e² h.
#[test]
fn a_bouncing_mass_rests_behind_the_sum_of_its_flights() {
    let (h, e) = (0.5, 0.6);
    let first = (2.0 * h / G).sqrt();
    let total = first * (1.0 + e) / (1.0 - e);
    let at = |end: f64, step: f64| {
        let stops = JointStops { lower: Some(-h), upper: None, restitution: e };
        let block = body("block", [0.0; 3], 2.0, Some([0.2, 0.25, 0.3]));
        let joint = slide(None, Some(stops), [0.0, 0.0, 1.0]);
        let model = Model { loads: gravity([0.0, 0.0, -G]), ..machine(end, step, vec![block], vec![joint]) };
        let mut notes = Notes::default();
        let (system, state) = run(&model, &mut notes);
        println!("energy {:e}", notes.drift());
        (pose(&system, &state, 0).0.z, state.v[system.coordinates.bodies[0].centre as usize][2])
    };
    let (z, v) = at(first * (1.0 + e), 0.01);
    println!("apex {:e} {v:e}", z + h - e * e * h);
    assert!((z + h - e * e * h).abs() < 1e-8 && v.abs() < 1e-7, "{z} {v}");
    let (z, v) = at(total + 3.0, 0.01);
    println!("rest {:e} {v:e}", z + h);
    assert!((z + h).abs() < 1e-9 && v.abs() < 1e-9, "{z} {v}");
}
