//! Angles about an axis of sides that also tilt against each other: the twist, which is the angle of a hinge where the axis stays common.

use std::f64::consts::PI;

use crate::multibody::{between, body, gravity, machine, pose, run, spherical, torsion_spring};
use tegula::analysis::{Silent, State};
use tegula::model::*;
use tegula::result::sensor_values;
use tegula::{Mat3, Vec3};

fn sensor(name: &str, axis: Vec3) -> Sensor {
    Sensor::Angle(AngleSensor { name: name.into(), between: between("ground", "b"), axis: axis.into() })
}

/// A free ball that turns by φ about z has turned by `2 atan(n·z tan φ/2)` about an axis n.
#[test]
fn a_rotation_about_another_axis_is_measured_by_its_twist() {
    let axes = [
        Vec3::z(),
        Vec3::new(0.0, 1.0, 1.0),
        Vec3::new(-2.0, 1.0, 3.0),
        Vec3::new(1.0, 1.0, -1.0),
        Vec3::x(),
    ];
    let ball = RigidBody { angular_velocity: [0.0, 0.0, 1.3], ..body("b", [0.0; 3], 2.0, Some([0.1; 3])) };
    let mut model = machine(1.0, 0.02, vec![ball], Vec::new());
    model.sensors = axes.iter().enumerate().map(|(i, axis)| sensor(&format!("s{i}"), *axis)).collect();
    let (system, state) = run(&model, &mut Silent);
    let (_, turned) = pose(&system, &state, 0);
    let angle = turned[(1, 0)].atan2(turned[(0, 0)]);
    assert!((angle - 1.3).abs() < 1e-3, "{angle}");
    let values = sensor_values(&system, &state);
    // Angle and rate of each sensor.
    for (axis, value) in axes.iter().zip(values.chunks(2)) {
        let twist = 2.0 * (axis.normalize().z * (0.5 * angle).tan()).atan();
        assert!((value[0] - twist.to_degrees()).abs() < 1e-10, "{axis} {} {}", value[0], twist.to_degrees());
    }
}

/// A body on a universal joint with torsion springs about both of its axes, in a frame turned by `turn`.
fn cardan(turn: &Mat3) -> Model {
    let turned = |x: Vec3| <[f64; 3]>::from(turn * x);
    let body = RigidBody {
        axes: [turned(Vec3::x()), turned(Vec3::y())],
        ..body("b", turned(Vec3::new(0.1, 0.2, -0.4)), 2.0, Some([0.1, 0.2, 0.25]))
    };
    let joint = Joint::Universal(TwoAxesJoint {
        name: "cross".into(),
        between: between("ground", "b"),
        at: [0.0; 3],
        axes: [turned(Vec3::x()), turned(Vec3::y())],
        second_at: None,
    });
    let springs = [(Vec3::x(), "x", 3.0), (Vec3::y(), "y", 2.0)];
    let spring = |(axis, name, stiffness): (Vec3, &str, f64)| TorsionSpring {
        name: name.into(),
        ..torsion_spring(["ground", "b"], turned(axis), stiffness)
    };
    Model {
        torsion_springs: springs.into_iter().map(spring).collect(),
        sensors: vec![sensor("x", turn * Vec3::x()), sensor("y", turn * Vec3::y())],
        loads: gravity(turned(Vec3::new(3.0, 5.0, -6.0))),
        ..machine(1.0, 5e-3, vec![body], vec![joint])
    }
}

/// About the axes of a universal joint they are the two angles of its cross, whatever the frame.
#[test]
fn springs_about_the_axes_of_a_universal_joint_act_on_the_angles_of_its_cross() {
    let mut first = None;
    for [axis, angle] in [
        [Vec3::x(), Vec3::zeros()],
        [Vec3::new(1.0, 2.0, 3.0), Vec3::repeat(1.2)],
        [Vec3::new(1.0, -1.0, 3.0), Vec3::repeat(0.5)],
    ] {
        let turn =
            nalgebra::Rotation3::from_axis_angle(&nalgebra::Unit::new_normalize(axis), angle.x).into_inner();
        let (system, state) = run(&cardan(&turn), &mut Silent);
        let (place, axes) = pose(&system, &state, 0);
        let (_, at_start) = pose(&system, &State::first(&system), 0);
        let place = turn.transpose() * place;
        let rotation = turn.transpose() * axes * at_start.transpose() * turn;
        let angles = [rotation[(2, 1)].atan2(rotation[(1, 1)]), rotation[(0, 2)].atan2(rotation[(0, 0)])];
        assert!(angles.iter().all(|angle| angle.abs() > 0.1), "{angles:?}");
        let values = sensor_values(&system, &state);
        for (value, angle) in values.chunks(2).zip(angles) {
            assert!((value[0] - angle.to_degrees()).abs() < 1e-9, "{} {}", value[0], angle.to_degrees());
        }
        let at_first = *first.get_or_insert(place);
        assert!((place - at_first).norm() < 1e-10, "{place} {at_first}");
    }
}

/// A ball on a spherical joint that turns end over end and a little about z.
fn tumbling(dt: f64) -> Model {
    let ball = RigidBody { angular_velocity: [PI, 0.0, 0.01], ..body("b", [0.0; 3], 1.0, Some([1.0; 3])) };
    Model {
        sensors: vec![sensor("z", Vec3::z())],
        ..machine(1.5, dt, vec![ball], vec![spherical("ground", "b", [0.0; 3])])
    }
}

/// Where the tilt passes by 180 degrees at a distance of 0.36 degrees, the twist changes by nearly a full turn within 1/1000 of a turn; the steps are
/// 3 to 50 times as long.
#[test]
fn a_twist_beside_a_tilt_of_180_degrees_keeps_its_turns_in_long_steps() {
    for dt in [0.002, 0.0173, 0.1] {
        let (system, state) = run(&tumbling(dt), &mut Silent);
        let (_, axes) = pose(&system, &state, 0);
        // Sine and cosine of half the angle about (π, 0, 0.01), of which it is more than half a turn.
        let half = PI - 0.5 * ((axes.trace() - 1.0) * 0.5).acos();
        let twist = 2.0 * (half.sin() * 0.01 / PI.hypot(0.01)).atan2(half.cos());
        let value = sensor_values(&system, &state)[0];
        assert!((value - twist.to_degrees()).abs() < 1e-6, "{dt} {value} {}", twist.to_degrees());
        assert!(value > 359.6, "{dt} {value}");
    }
}

/// The sides pass through a tilt of 180 degrees itself: the twist has no value there, and goes on without a turn.
#[test]
fn a_twist_through_a_tilt_of_180_degrees_goes_on_without_a_turn() {
    let mut model = tumbling(0.0173);
    model.bodies[0].angular_velocity[2] = 0.0;
    let (system, state) = run(&model, &mut Silent);
    let value = sensor_values(&system, &state)[0];
    assert!(value.abs() < 1e-6, "{value}");
}

/// A spring about z is wound up by the turn: the steps of any scheme are cut back until the twist changes by less than 2.5 rad in each.
#[test]
fn a_spring_beside_a_tilt_of_180_degrees_keeps_its_turns_in_long_steps() {
    let order_two = Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 });
    let schemes = [order_two, Scheme::GeneralizedAlpha(GeneralizedAlphaScheme::default())];
    for scheme in schemes {
        let angle = |dt: f64| {
            let mut model = tumbling(dt);
            model.torsion_springs = vec![TorsionSpring {
                name: "z".into(),
                ..torsion_spring(["ground", "b"], [0.0, 0.0, 1.0], 0.001)
            }];
            let Analysis::Transient(options) = &mut model.analysis else { unreachable!() };
            options.scheme = scheme;
            let (system, state) = run(&model, &mut Silent);
            sensor_values(&system, &state)[0]
        };
        let [long, short] = [0.0173, 0.0005].map(angle);
        assert!((short - 359.06).abs() < 0.1, "{short}");
        assert!((long - short).abs() < 2.0, "{long} {short}");
    }
}
