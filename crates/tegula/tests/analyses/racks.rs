//! Racks and pinions: closed solutions over several turns with bodies that carry the pinion and racks that slide, refusals.

use crate::common::Notes;
use crate::multibody::{between, body, gravity, machine, pose, run};
use tegula::model::*;
use tegula::{Vec3, compile, mesh};

const RADIUS: f64 = 0.2;
const PINION: f64 = 3.0;
const INERTIA: f64 = 0.09;
/// Direction of the rack, and the axis of the pinion, perpendicular to it.
const RACK: [f64; 3] = [2.0, 1.0, 2.0];
const AXIS: [f64; 3] = [1.0, -2.0, 0.0];

fn along() -> Vec3 {
    Vec3::from(RACK).normalize()
}

fn pinion(first: &str, radius: f64) -> Joint {
    Joint::RackAndPinion(RackJoint {
        name: "teeth".into(),
        between: between(first, "pinion"),
        at: [0.0; 3],
        axis: AXIS,
        direction: RACK,
        radius,
    })
}

fn hinge(first: &str) -> Joint {
    let keys = AxisJoint {
        name: "hinge".into(),
        between: between(first, "pinion"),
        at: [0.0; 3],
        axis: AXIS,
        second_at: None,
        second_axis: None,
    };
    Joint::Revolute(keys.into())
}

fn guide(body: &str) -> Joint {
    let keys = AxisJoint {
        name: "guide".into(),
        between: between("ground", body),
        at: [0.0; 3],
        axis: RACK,
        second_at: None,
        second_axis: None,
    };
    Joint::Prismatic(keys.into())
}

/// A carriage with a pinion that rolls on a rack on the ground, under gravity along it.
fn carriage(step: f64, radius: f64) -> Model {
    let bodies = vec![
        body("carriage", [0.0; 3], 5.0, Some([0.1; 3])),
        body("pinion", [0.0; 3], PINION, Some([INERTIA; 3])),
    ];
    let joints = vec![guide("carriage"), hinge("carriage"), pinion("ground", radius)];
    Model { loads: gravity((along() * 4.0).into()), ..machine(2.0, step, bodies, joints) }
}

/// Angle of the pinion about its axis, up to full turns.
fn angle(turned: &tegula::Mat3) -> f64 {
    let axis = Vec3::from(AXIS).normalize();
    let across = axis.cross(&along());
    (turned * along()).dot(&across).atan2((turned * along()).dot(&along()))
}

/// The acceleration is `(M + m) g/(M + m + I/r²)`; the energy stays, and the pinion turns by the way over its radius.
#[test]
fn a_pinion_rolls_along_its_rack_with_its_inertia_of_rotation() {
    for radius in [RADIUS, -RADIUS] {
        let exact = 0.5 * 4.0 * (5.0 + PINION) / (5.0 + PINION + INERTIA / (radius * radius)) * 4.0;
        let error = |step: f64| {
            let mut notes = Notes::default();
            let (system, state) = run(&carriage(step, radius), &mut notes);
            let (place, turned) = pose(&system, &state, 1);
            let way = place.dot(&along());
            assert!((place - along() * way).norm() < 1e-9, "{place}");
            let apart = (angle(&turned) - way / radius) / std::f64::consts::TAU;
            assert!((apart - apart.round()).abs() < 1e-10 && way / radius.abs() > 20.0, "{apart}");
            assert!(notes.drift() <= 1e-10 * notes.kinetic, "{} {}", notes.drift(), notes.kinetic);
            (way - exact).abs()
        };
        let [coarse, fine] = [8e-3, 4e-3].map(error);
        assert!(fine < 1e-2 * exact && (3.5..4.5).contains(&(coarse / fine)), "{radius}: {coarse} {fine}");
    }
}

/// A moment on a pinion with a fixed axis moves a rack that slides: `a = −M r/(I + m r²)` along its direction.
#[test]
fn a_pinion_moves_a_rack_that_slides() {
    let (moment, mass) = (1.5, 4.0);
    let bodies = vec![
        body("rack", [0.0; 3], mass, Some([0.1; 3])),
        body("pinion", [0.0; 3], PINION, Some([INERTIA; 3])),
    ];
    let joints = vec![guide("rack"), hinge("ground"), pinion("rack", RADIUS)];
    let value: [f64; 3] = (Vec3::from(AXIS).normalize() * moment).into();
    let load = Load::Moment(VectorLoad { on: "pinion".into(), value, amplitude: None, distribution: None });
    let model = Model { loads: vec![load], ..machine(1.0, 2e-3, bodies, joints) };
    let (system, state) = run(&model, &mut Notes::default());
    let way = pose(&system, &state, 0).0.dot(&along());
    let exact = -0.5 * moment * RADIUS / (INERTIA + mass * RADIUS * RADIUS);
    assert!((way / exact - 1.0).abs() < 1e-4, "{way} {exact}");
}

#[test]
fn a_rack_without_radius_or_not_perpendicular_to_the_axis_is_refused() {
    let refused = |change: &dyn Fn(&mut RackJoint)| {
        let mut model = carriage(1e-3, RADIUS);
        let Joint::RackAndPinion(keys) = &mut model.joints[2] else { panic!() };
        change(keys);
        let mesh = mesh::generators::generate(&model.mesh).unwrap();
        compile::build(&model, &mesh).err().unwrap().to_string()
    };
    for radius in [0.0, f64::NAN] {
        let message = refused(&|keys| keys.radius = radius);
        assert!(message.contains("joints[2].radius") && message.contains("\"teeth\""), "{message}");
    }
    let message = refused(&|keys| keys.direction = [1.0, 0.0, 0.0]);
    assert!(message.contains("joints[2].direction") && message.contains("not perpendicular"), "{message}");
}
