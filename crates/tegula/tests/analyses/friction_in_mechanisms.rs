//! Friction of joints in mechanisms: dead centres, motions that drives force, several joints with friction on one motion.

use crate::common::Notes;
use crate::multibody::{between, body, machine, pose, run};
use tegula::Vec3;
use tegula::analysis::State;
use tegula::model::*;
use tegula::norm::max_norm;

/// Radius of the crank, length of the rod, friction of the slider.
const CRANK: f64 = 0.2;
const REACH: f64 = 0.6;
const FRICTION: f64 = 4.0;

fn preload(size: f64) -> Option<JointFriction> {
    Some(JointFriction { preload: size, ..JointFriction::default() })
}

fn coordinate(name: &str, sides: [&str; 2], (at, axis): ([f64; 3], [f64; 3]), size: f64) -> CoordinateJoint {
    let friction = preload(size).filter(|_| size > 0.0);
    CoordinateJoint {
        name: name.into(),
        between: sides.map(Into::into),
        at,
        axis,
        friction,
        stops: None,
        second_at: None,
        second_axis: None,
    }
}

/// Crank, rod and slider in a plane, with the crank across the guide at the start, which turns with the velocity `omega`; constant friction
/// in the guide.
fn slider_crank(omega: f64, end: f64, step: f64) -> Model {
    let moving = |name: &str, at: [f64; 3], vx: f64| RigidBody {
        velocity: [vx, 0.0, 0.0],
        ..body(name, at, 1.0, Some([0.01, 0.02, 0.02]))
    };
    let mut crank = moving("crank", [0.0, 0.5 * CRANK, 0.0], -0.5 * CRANK * omega);
    crank.angular_velocity = [0.0, 0.0, omega];
    let rod = moving("rod", [0.5 * REACH, 0.5 * CRANK, 0.0], -CRANK * omega);
    let slider = moving("slider", [REACH, 0.0, 0.0], -CRANK * omega);
    let z = [0.0, 0.0, 1.0];
    let joints = vec![
        Joint::Revolute(coordinate("hinge", ["ground", "crank"], ([0.0; 3], z), 0.0)),
        Joint::Universal(TwoAxesJoint {
            name: "pin".into(),
            between: between("crank", "rod"),
            at: [0.0, CRANK, 0.0],
            // The rod does not turn about itself.
            axes: [z, [CRANK, REACH, 0.0]],
            second_at: None,
        }),
        Joint::Spherical(PointJoint {
            name: "ball".into(),
            between: between("slider", "rod"),
            at: [REACH, 0.0, 0.0],
            second_at: None,
        }),
        Joint::Prismatic(coordinate(
            "guide",
            ["ground", "slider"],
            ([REACH, 0.0, 0.0], [1.0, 0.0, 0.0]),
            FRICTION,
        )),
    ];
    machine(end, step, vec![crank, rod, slider], joints)
}

/// Place of the slider at an angle of the crank from the guide.
fn place(angle: f64) -> f64 {
    let length = REACH.hypot(CRANK);
    CRANK * angle.cos() + (length * length - (CRANK * angle.sin()).powi(2)).sqrt()
}

/// Way of the slider, there and back, from the start at a quarter turn to a greater angle.
fn way(angle: f64) -> f64 {
    use std::f64::consts::{FRAC_PI_2, PI};
    let half_turns = (angle / PI).floor();
    let behind = (place(angle) - place(half_turns * PI)).abs();
    match half_turns {
        0.0 => place(FRAC_PI_2) - place(angle),
        _ => place(FRAC_PI_2) - place(PI) + (half_turns - 1.0) * 2.0 * CRANK + behind,
    }
}

/// Angles of the crank from the guide in the states of a motion, continued over full turns.
fn angles(system: &tegula::System, states: &[State]) -> Vec<f64> {
    let mut angle = std::f64::consts::FRAC_PI_2;
    let mut next = |state: &State| {
        let (_, turned) = pose(system, state, 0);
        let now = turned[(1, 0)].atan2(turned[(0, 0)]) + std::f64::consts::FRAC_PI_2;
        angle = now + std::f64::consts::TAU * ((angle - now) / std::f64::consts::TAU).round();
        angle
    };
    states.iter().map(&mut next).collect()
}

/// A turning slider-crank loses the work of friction over the way of its slider, through its dead centres, and rests where the kinetic
/// energy is used up.
#[test]
fn a_slider_crank_with_friction_passes_its_dead_centres_and_rests_where_its_energy_ends() {
    // ½ (J + m r²/4) ω² of the crank and ½ m (r ω)² of both other bodies.
    let energy = 0.5 * (0.03 + 2.0 * CRANK * CRANK) * 100.0;
    let (mut low, mut high) = (std::f64::consts::FRAC_PI_2, 30.0);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        (low, high) = if FRICTION * way(middle) < energy { (middle, high) } else { (low, middle) };
    }
    let error = |step: f64| {
        let mut notes = Notes::keeping();
        let (system, state) = run(&slider_crank(10.0, 3.0, step), &mut notes);
        assert!(notes.drift() <= 1e-9 * notes.kinetic, "{}", notes.drift());
        assert!(state.coordinates[0].mode.is_held());
        let turned = angles(&system, &notes.states);
        assert!(turned[turned.len() - 1] > 3.0 * std::f64::consts::PI);
        let kinetic = notes.states.iter().map(|state| system.kinetic_energy(&state.v));
        let lost = kinetic.zip(&turned).map(|(kinetic, angle)| kinetic + FRICTION * way(*angle) - energy);
        let earlier = turned[turned.len() - 100];
        assert!((turned[turned.len() - 1] - earlier).abs() < 1e-9, "{earlier}");
        assert!(system.kinetic_energy(&state.v) < 1e-12 * energy);
        [max_norm(lost) / energy, (turned[turned.len() - 1] - low).abs()]
    };
    // The scheme conserves energy, and the friction is constant: only the round-off of the iteration is left.
    for step in [4e-3, 2e-3] {
        let found = error(step);
        assert!(found[0] < 1e-6 && found[1] < 1e-5, "{found:?}");
    }
}

/// A drive sets a slider-crank in motion from rest, `θ = π/2 + t²` rad, also where it begins with an acceleration and where it begins
/// without one: friction dissipates its force times the way of the slider.
#[test]
fn a_drive_moves_a_slider_crank_with_friction_from_rest() {
    for (text, turned) in [("180/PI*t^2", 9.0), ("180/PI*t^3", 27.0)] {
        let mut model = slider_crank(0.0, 3.0, 2e-3);
        model.joints.push(Joint::DrivenAngle(DrivenAngleJoint {
            name: "motor".into(),
            between: between("ground", "crank"),
            axis: [0.0, 0.0, 1.0],
            angle: 1.0,
            amplitude: "angle".into(),
        }));
        let angle = Amplitude::Expression(ExpressionAmplitude { expression: text.into() });
        model.amplitudes.insert("angle".into(), angle);
        let (_, state) = run(&model, &mut Notes::default());
        let expected = FRICTION * way(std::f64::consts::FRAC_PI_2 + turned);
        let error = (state.dissipated / expected - 1.0).abs();
        assert!(error < 2e-4, "{} {expected}", state.dissipated);
    }
}

/// Pinion on a hinge and rack on a guide, both with friction: effective mass 10, friction 8 along the rack.
fn rack(end: f64, step: f64, speed: f64) -> Model {
    let pinion = RigidBody {
        angular_velocity: [0.0, 10.0 * speed, 0.0],
        ..body("pinion", [0.0; 3], 1.0, Some([0.05; 3]))
    };
    let rack =
        RigidBody { velocity: [-speed, 0.0, 0.0], ..body("rack", [0.0, 0.0, -0.1], 5.0, Some([0.1; 3])) };
    let (x, y) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let joints = vec![
        Joint::Revolute(coordinate("hinge", ["ground", "pinion"], ([0.0; 3], y), 0.4)),
        Joint::Prismatic(coordinate("guide", ["ground", "rack"], ([0.0, 0.0, -0.1], x), 4.0)),
        Joint::RackAndPinion(RackJoint {
            name: "teeth".into(),
            between: between("rack", "pinion"),
            at: [0.0; 3],
            axis: y,
            direction: x,
            radius: 0.1,
        }),
    ];
    machine(end, step, vec![pinion, rack], joints)
}

/// Friction of the hinge and of the guide brakes one motion, which ends behind `v²/(2 a)`, a = 8/10, and both hold it.
#[test]
fn friction_of_two_joints_stops_one_motion() {
    for (speed, step) in [(0.5, 1e-3), (-0.5, 3e-3)] {
        let mut notes = Notes::default();
        let (system, state) = run(&rack(1.0, step, speed), &mut notes);
        let x = pose(&system, &state, 1).0.x;
        let expected = -speed * speed.abs() / 1.6;
        assert!((x / expected - 1.0).abs() < 1e-5, "{x} {expected}");
        assert!(state.coordinates.iter().all(|c| c.mode.is_held()));
        assert!(notes.drift() <= 1e-9 * notes.kinetic, "{}", notes.drift());
    }
}

/// A force 16 t on the rack breaks both joints loose at 8, the sum of their limits: `x = 16 (t − ½)³/60` behind it.
#[test]
fn two_joints_hold_one_motion_up_to_the_sum_of_their_friction() {
    for step in [1e-2, 7e-3] {
        let mut model = rack(1.0, step, 0.0);
        let pull = Amplitude::Table(TableAmplitude { times: vec![0.0, 1.0], values: vec![0.0, 16.0] });
        model.amplitudes.insert("pull".into(), pull);
        model.loads.push(Load::Force(VectorLoad {
            on: "rack".into(),
            value: [1.0, 0.0, 0.0],
            amplitude: Some("pull".into()),
            distribution: None,
        }));
        let mut notes = Notes::default();
        let (system, state) = run(&model, &mut notes);
        let x = pose(&system, &state, 1).0.x;
        let expected = 16.0 * 0.125 / 60.0;
        assert!((x / expected - 1.0).abs() < 2e-4, "{x} {expected}");
        assert!(notes.drift() <= 1e-9 * notes.kinetic, "{}", notes.drift());
    }
}

/// A force 16 t on the rack, whose guide has the static friction 0.4 N and the sliding friction 0.2 N at the normal force N = 10, breaks it
/// loose at 8, the sum of static friction and of that of the hinge. From there on `10 ẍ = 16 t − 6`.
#[test]
fn static_friction_holds_one_motion_up_to_the_sum_of_its_limits() {
    for step in [1e-2, 7e-3] {
        let mut model = rack(1.0, step, 0.0);
        let Joint::Prismatic(guide) = &mut model.joints[1] else { unreachable!() };
        let (coefficient, static_coefficient) = (0.2, Some(0.4));
        guide.friction = Some(JointFriction { coefficient, static_coefficient, ..JointFriction::default() });
        let pull = Amplitude::Table(TableAmplitude { times: vec![0.0, 1.0], values: vec![0.0, 16.0] });
        model.amplitudes.insert("pull".into(), pull);
        let force = |value: [f64; 3], amplitude: Option<&str>| {
            let amplitude = amplitude.map(Into::into);
            Load::Force(VectorLoad { on: "rack".into(), value, amplitude, distribution: None })
        };
        model.loads = vec![force([1.0, 0.0, 0.0], Some("pull")), force([0.0, 0.0, -10.0], None)];
        let mut notes = Notes::default();
        let (system, state) = run(&model, &mut notes);
        let x = pose(&system, &state, 1).0.x;
        let expected = (16.0 * 0.125 / 6.0 + 0.25) / 10.0;
        assert!((x / expected - 1.0).abs() < 2e-4, "{x} {expected}");
        assert!(notes.drift() <= 1e-9 * notes.kinetic, "{}", notes.drift());
    }
}

/// A drive turns a slider-crank with friction in the guide and between crank and rod to and fro: at its reversals both come to rest at one
/// instant, and go on in the other direction. Friction dissipates its moment and its force times the angle and the way.
#[test]
fn a_drive_that_reverses_takes_a_mechanism_with_friction_along() {
    let mut model = slider_crank(0.0, 3.0, 4e-3);
    model.joints[1] =
        Joint::Revolute(coordinate("pin", ["crank", "rod"], ([0.0, CRANK, 0.0], [0.0, 0.0, 1.0]), 0.3));
    model.joints.push(Joint::DrivenAngle(DrivenAngleJoint {
        name: "drive".into(),
        between: between("ground", "crank"),
        axis: [0.0, 0.0, 1.0],
        angle: 60.0,
        amplitude: "swing".into(),
    }));
    let expression = "sin(3*t)".to_owned();
    model.amplitudes.insert("swing".into(), Amplitude::Expression(ExpressionAmplitude { expression }));
    let mut notes = Notes::default();
    let (system, state) = run(&model, &mut notes);
    // The crank swings by ±60° about its start; the angle of the rod follows from the triangle of the mechanism.
    let [mut pin, mut slider] = [0.0; 2];
    let at = |t: f64| {
        let angle = std::f64::consts::FRAC_PI_2 + (60.0_f64).to_radians() * (3.0 * t).sin();
        let rod = -(CRANK * angle.sin() / REACH.hypot(CRANK)).asin();
        [angle, rod - angle, place(angle)]
    };
    for k in 0..300_000 {
        let [before, after] = [f64::from(k), f64::from(k + 1)].map(|k| at(k * 1e-5));
        pin += (after[1] - before[1]).abs();
        slider += (after[2] - before[2]).abs();
    }
    let expected = 0.3 * pin + FRICTION * slider;
    assert!((state.dissipated / expected - 1.0).abs() < 1e-4, "{} {expected}", state.dissipated);
    let angle = angles(&system, std::slice::from_ref(&state))[0];
    assert!((angle - at(3.0)[0]).abs() < 1e-9, "{angle}");
    assert!(notes.drift() <= 1e-9 * notes.kinetic, "{}", notes.drift());
}

/// A door on two hinges with friction, of which one would do: `ω² J/(2 (T₁ + T₂))`.
#[test]
fn friction_of_both_hinges_stops_a_door() {
    let leaf = RigidBody {
        velocity: [0.0, 0.5, 0.0],
        angular_velocity: [0.0, 0.0, 1.0],
        ..body("leaf", [0.5, 0.0, 0.0], 10.0, Some([0.9; 3]))
    };
    let hinge = |name: &str, z: f64, size: f64| {
        Joint::Revolute(coordinate(name, ["ground", "leaf"], ([0.0, 0.0, z], [0.0, 0.0, 1.0]), size))
    };
    let model = machine(5.0, 2e-3, vec![leaf], vec![hinge("low", -0.8, 0.5), hinge("high", 0.8, 0.8)]);
    let mut notes = Notes::default();
    let (_, state) = run(&model, &mut notes);
    let expected = (0.9 + 10.0 * 0.25) / (2.0 * 1.3);
    let turned = [0, 1].map(|k| state.coordinates[k].value);
    assert!(turned.iter().all(|x| (x / expected - 1.0).abs() < 1e-5), "{turned:?} {expected}");
    assert!(state.coordinates.iter().all(|c| c.mode.is_held()));
    assert!(notes.drift() <= 1e-9 * notes.kinetic, "{}", notes.drift());
}

/// Arms of a double pendulum with friction in both hinges come to rest where friction can hold them: `|M₁| ≤ T₁`, `|M₂| ≤ T₂` with the
/// moments of gravity, and the energy that they have lost is the work of friction.
#[test]
fn a_double_pendulum_with_friction_rests_in_an_equilibrium_of_friction() {
    const G: f64 = 9.81;
    let arm = |name: &str, x: f64| body(name, [x, 0.0, 0.0], 1.0, Some([0.01, 0.08, 0.08]));
    let z = [0.0, 0.0, 1.0];
    let hinges = vec![
        Joint::Revolute(coordinate("shoulder", ["ground", "upper"], ([0.0; 3], z), 0.6)),
        Joint::Revolute(coordinate("elbow", ["upper", "lower"], ([1.0, 0.0, 0.0], z), 0.4)),
    ];
    let mut model = machine(30.0, 4e-3, vec![arm("upper", 0.5), arm("lower", 1.5)], hinges);
    model.loads = vec![Load::Gravity(GravityLoad { value: [0.0, -G, 0.0], amplitude: None })];
    let mut notes = Notes::default();
    let (system, state) = run(&model, &mut notes);
    assert!(state.coordinates.iter().all(|c| c.mode.is_held()));
    let [upper, lower] = [0, 1].map(|b| pose(&system, &state, b).0);
    let elbow = upper * 2.0;
    let moments = [G * (upper.x + lower.x), G * (lower.x - elbow.x)];
    assert!(moments[0].abs() <= 0.6 && moments[1].abs() <= 0.4, "{moments:?}");
    let fallen = -G * (upper.y + lower.y);
    assert!((state.dissipated / fallen - 1.0).abs() < 1e-9, "{} {fallen}", state.dissipated);
    assert!(state.work.abs() < 1e-9 * fallen, "{}", state.work);
    assert!(notes.drift() <= 1e-9 * notes.kinetic, "{}", notes.drift());
}

/// A body on a joint that does not let it move rests under a moment, whatever the scheme: round-off is no motion.
#[test]
fn a_held_body_rests_under_a_moment() {
    let fixed = Joint::Fixed(PointJoint {
        name: "joint".into(),
        between: between("ground", "block"),
        at: [0.0; 3],
        second_at: None,
    });
    let stuck = Joint::Revolute(coordinate("joint", ["ground", "block"], ([0.0; 3], [0.0, 0.0, 1.0]), 5.0));
    let generalized_alpha = Scheme::GeneralizedAlpha(GeneralizedAlphaScheme { spectral_radius: 0.9 });
    let conserving = Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 });
    for (scheme, joint) in [(conserving, fixed.clone()), (generalized_alpha, fixed), (conserving, stuck)] {
        let block = body("block", [0.5, 0.0, 0.0], 1.0, Some([0.1; 3]));
        let mut model = machine(0.5, 1e-3, vec![block], vec![joint]);
        let Analysis::Transient(options) = &mut model.analysis else { unreachable!() };
        options.scheme = scheme;
        model.loads.push(Load::Moment(VectorLoad {
            on: "block".into(),
            value: [0.0, 0.0, 3.0],
            amplitude: None,
            distribution: None,
        }));
        let (system, state) = run(&model, &mut Notes::default());
        let (place, _) = pose(&system, &state, 0);
        assert!((place - Vec3::new(0.5, 0.0, 0.0)).norm() < 1e-9, "{place}");
    }
}

/// A parallelogram of two cranks and a rod, with friction in all four hinges, rests under a moment below the sum of their limits, which is
/// 4 · 0.5 as all hinges turn alike, and moves under one above.
#[test]
fn a_parallelogram_rests_up_to_the_sum_of_the_friction_of_its_hinges() {
    let z = [0.0, 0.0, 1.0];
    let hinge =
        |name: &str, sides: [&str; 2], at: [f64; 3]| Joint::Revolute(coordinate(name, sides, (at, z), 0.5));
    for (moment, holds) in [(0.5, true), (1.99, true), (2.1, false)] {
        let bodies = vec![
            body("left", [0.0, 0.2, 0.0], 1.0, Some([0.02; 3])),
            body("right", [1.0, 0.2, 0.0], 1.0, Some([0.02; 3])),
            body("rod", [0.5, 0.4, 0.0], 2.0, Some([0.2; 3])),
        ];
        let joints = vec![
            hinge("a", ["ground", "left"], [0.0; 3]),
            hinge("b", ["ground", "right"], [1.0, 0.0, 0.0]),
            hinge("c", ["left", "rod"], [0.0, 0.4, 0.0]),
            hinge("d", ["right", "rod"], [1.0, 0.4, 0.0]),
        ];
        let mut model = machine(0.5, 5e-3, bodies, joints);
        model.loads = vec![Load::Moment(VectorLoad {
            on: "left".into(),
            value: [0.0, 0.0, moment],
            amplitude: None,
            distribution: None,
        })];
        let (_, state) = run(&model, &mut Notes::default());
        let turned = state.coordinates[0].value;
        // Cranks of the inertia 0.02 + 0.04, the rod moves on a circle of the radius 0.4.
        let expected = if holds { 0.0 } else { 0.5 * (moment - 2.0) / (2.0 * 0.06 + 2.0 * 0.16) * 0.25 };
        assert!((turned - expected).abs() < 1e-6 * (1.0 + expected), "{moment}: {turned} {expected}");
        assert_eq!(state.coordinates.iter().all(|c| c.mode.is_held()), holds, "{moment}");
    }
}
