//! Models whose joints do not meet in the reference configuration: positions at the start against closed forms, and what follows from there.

use crate::common::{Notes, model, on, plate};
use crate::modes_with_joints::modal;
use crate::multibody::{axis_joint, between, body, gravity, machine, pose, revolute, run};
use tegula::analysis::{Silent, State, dynamics, modal as modes, statics};
use tegula::model::*;
use tegula::norm::max_norm;
use tegula::result::joint_reaction;
use tegula::{System, Vec3, compile, mesh};

pub const Z: [f64; 3] = [0.0, 0.0, 1.0];
pub const INERTIA: [f64; 3] = [0.02, 0.3, 0.31];

/// A ball joint between two points of the reference configuration.
pub fn ball(name: &str, a: &str, b: &str, at: [f64; 3], second: [f64; 3]) -> Joint {
    Joint::Spherical(PointJoint { name: name.into(), between: between(a, b), at, second_at: Some(second) })
}

/// A hinge between two points of the reference configuration.
pub fn hinge(name: &str, a: &str, b: &str, [at, second]: [[f64; 3]; 2]) -> Joint {
    Joint::Revolute(AxisJoint { second_at: Some(second), ..axis_joint(name, a, b, at, Z) }.into())
}

pub fn built(model: &Model) -> System {
    compile::build(model, &mesh::generators::generate(&model.mesh).unwrap()).unwrap()
}

fn refused(model: &Model) -> String {
    compile::build(model, &mesh::generators::generate(&model.mesh).unwrap()).err().unwrap().to_string()
}

/// Displacement and angle about z of a body at the start.
pub fn moved(system: &System, body: usize) -> (Vec3, f64) {
    let state = State::first(system);
    let (place, axes) = pose(system, &state, body);
    let centre = system.coordinates.bodies[body].centre as usize;
    (place - Vec3::from(system.coordinates.reference[centre]), axes[(1, 0)].atan2(axes[(0, 0)]))
}

/// Largest gap of the joints in a state: distance and angle.
pub fn gaps(system: &System, state: &State) -> [f64; 2] {
    let of_joint = |joint: &tegula::constraint::Joint| {
        let at = |v: &u32| {
            Vec3::from(system.coordinates.reference[*v as usize]) + Vec3::from(state.u[*v as usize])
        };
        joint.gap(&joint.vectors.iter().map(at).collect::<Vec<_>>())
    };
    let all: Vec<[f64; 2]> = system.joints.iter().map(of_joint).collect();
    [0, 1].map(|i| max_norm(all.iter().map(|gap| gap[i])))
}

/// Two bodies with a gap between their mass centres: the mass centre of both stays, and none of them turns.
#[test]
fn bodies_share_a_gap_by_their_masses() {
    let gap = Vec3::new(0.3, -0.4, 1.2);
    let bodies = |inertia: Option<[f64; 3]>| {
        vec![body("a", [1.0, 2.0, 3.0], 2.0, inertia), body("b", [1.3, 1.6, 4.2], 5.0, inertia)]
    };
    for inertia in [None, Some([0.1, 0.2, 0.25])] {
        let joint = ball("joint", "a", "b", [1.0, 2.0, 3.0], [1.3, 1.6, 4.2]);
        let system = built(&machine(1.0, 0.1, bodies(inertia), vec![joint]));
        let expected = [gap * (5.0 / 7.0), -gap * (2.0 / 7.0)];
        for (i, expected) in expected.into_iter().enumerate() {
            let (displacement, angle) = moved(&system, i);
            assert!((displacement - expected).norm() < 1e-13 && angle.abs() < 1e-13, "{displacement:?}");
        }
        let report = system.closed_gaps.as_ref().unwrap();
        assert!((report.joints[0].distance - 1.3).abs() < 1e-14 && report.joints[0].angle == 0.0);
        let found = Vec3::from(report.bodies[1].displacement);
        assert!((found - expected[1]).norm() < 1e-13 && report.bodies.len() == 2, "{report:?}");
        assert!(report.messages()[0].contains("\"joint\"") && report.messages()[0].contains("1.300000e0"));
    }
}

/// One body, whose point p is to lie at a point of the ground with the vector q from its mass centre: `f = ½ m |q − R p|² + J (1 − cos θ)` has
/// its minimum at `tan θ = m |p||q| sin α/(m |p||q| cos α + J)`, with the angle α from p to q.
#[test]
fn a_body_turns_to_its_pin_as_far_as_its_inertia_lets_it() {
    let (mass, length) = (3.0, 0.8);
    for (distance, degrees) in [(0.9, 5.0), (0.5, 40.0), (2.5, 110.0), (0.7, -75.0)] {
        let alpha = f64::to_radians(degrees);
        let pin = [distance * alpha.cos(), distance * alpha.sin(), 0.0];
        let joint = hinge("pin", "ground", "bar", [pin, [length, 0.0, 0.0]]);
        let bar = body("bar", [0.0; 3], mass, Some(INERTIA));
        let system = built(&machine(1.0, 0.1, vec![bar], vec![joint]));
        let arm = mass * length * distance;
        let expected = (arm * alpha.sin()).atan2(arm * alpha.cos() + INERTIA[2]);
        let (displacement, angle) = moved(&system, 0);
        assert!((angle - expected).abs() < 1e-9, "{degrees}: {angle} {expected}");
        let place = Vec3::from(pin) - Vec3::new(expected.cos(), expected.sin(), 0.0) * length;
        assert!((displacement - place).norm() < 1e-9, "{displacement:?} {place:?}");
    }
}

/// Links that hang below each other with gaps in between move up by the sums of the gaps.
#[test]
fn a_chain_closes_its_gaps_from_its_hook_on() {
    let gap = [0.1, 0.02, 0.3];
    let mut top = 0.0;
    let (mut bodies, mut joints) = (Vec::new(), Vec::new());
    let mut end = ("ground".to_owned(), [0.0; 3]);
    for (i, gap) in gap.into_iter().enumerate() {
        let name = format!("link {i}");
        let start = [0.0, top - gap, 0.0];
        joints.push(hinge(&format!("pin {i}"), &end.0, &name, [end.1, start]));
        bodies.push(body(&name, [0.0, start[1] - 0.5, 0.0], 1.0 + i as f64, Some(INERTIA)));
        top = start[1] - 1.0;
        end = (name, [0.0, top, 0.0]);
    }
    let system = built(&machine(1.0, 0.1, bodies, joints));
    let mut sum = 0.0;
    for (i, gap) in gap.into_iter().enumerate() {
        sum += gap;
        let (displacement, angle) = moved(&system, i);
        assert!((displacement - Vec3::y() * sum).norm() < 1e-12 && angle.abs() < 1e-12, "{displacement:?}");
    }
}

/// Lengths of frame, crank, coupler and rocker, and the angle of the crank.
pub const LINKS: [f64; 4] = [4.0, 1.5, 3.6, 2.8];
pub const CRANK: f64 = 0.9;

/// Angle of the rocker by Freudenstein's equation `K₁ cos ψ − K₂ cos φ + K₃ = cos(φ − ψ)` (F. Freudenstein, *Approximate synthesis of four-bar
/// linkages*, Trans. ASME 77 (1955) 853–861), solved by the half angle: both branches.
pub fn freudenstein(phi: f64, [d, a, b, c]: [f64; 4]) -> [f64; 2] {
    let [k1, k2, k3] = [d / a, d / c, (a * a - b * b + c * c + d * d) / (2.0 * a * c)];
    // (K₁ − cos φ) cos ψ − sin φ sin ψ + K₃ − K₂ cos φ = 0.
    let (p, q, r) = (k1 - phi.cos(), -phi.sin(), k3 - k2 * phi.cos());
    let root = (p * p + q * q - r * r).sqrt();
    [1.0, -1.0].map(|sign| 2.0 * (-q + sign * root).atan2(r - p))
}

/// A four-bar linkage whose crank is in place and driven; the coupler is drawn at any place, turned by an angle about z, and the rocker
/// stands upright on its pin.
pub fn four_bar(scale: f64, (place, turned): ([f64; 2], f64), links: [f64; 4], driven: bool) -> Model {
    let [d, a, b, c] = links.map(|length| length * scale);
    let link = |name: &str, at: [f64; 2], angle: f64, mass: f64| {
        let (sine, cosine) = angle.sin_cos();
        RigidBody {
            axes: [[cosine, sine, 0.0], [-sine, cosine, 0.0]],
            ..body(name, [at[0], at[1], 0.0], mass, Some(INERTIA.map(|j| j * scale * scale)))
        }
    };
    let from =
        |[x, y]: [f64; 2], angle: f64, length: f64| [x + length * angle.cos(), y + length * angle.sin()];
    let centre = place.map(|x| x * scale);
    let bodies = vec![
        link("crank", from([0.0; 2], CRANK, 0.5 * a), CRANK, 1.0),
        link("coupler", centre, turned, 2.0),
        link("rocker", [d, 0.5 * c], std::f64::consts::FRAC_PI_2, 1.5),
    ];
    let space = |[x, y]: [f64; 2]| [x, y, 0.0];
    let mut joints = vec![
        revolute("O", "ground", "crank", [0.0; 3], Z),
        hinge("A", "crank", "coupler", [from([0.0; 2], CRANK, a), from(centre, turned, -0.5 * b)].map(space)),
        hinge("B", "coupler", "rocker", [from(centre, turned, 0.5 * b), [d, c]].map(space)),
        revolute("C", "ground", "rocker", [d, 0.0, 0.0], Z),
    ];
    let mut model = machine(1.0, 0.01, bodies, Vec::new());
    if driven {
        joints.push(Joint::DrivenAngle(DrivenAngleJoint {
            name: "motor".into(),
            between: between("ground", "crank"),
            axis: Z,
            angle: 1.0,
            amplitude: "turn".into(),
        }));
        let turn = ExpressionAmplitude { expression: "30*t + 40*t^2".into() };
        model.amplitudes.insert("turn".into(), Amplitude::Expression(turn));
    }
    model.joints = joints;
    model
}

fn nearest_branch(angle: f64, phi: f64) -> f64 {
    let apart = |psi: f64| (angle - psi).sin().hypot(1.0 - (angle - psi).cos());
    let [p, q] = freudenstein(phi, LINKS).map(apart);
    if p < q { p } else { q }
}

#[test]
fn a_four_bar_linkage_closes_to_the_angles_of_freudenstein() {
    for drawn in [([2.0, 1.0], 0.3), ([6.0, -3.0], 1.4), ([1.0, 2.5], -0.8)] {
        let system = built(&four_bar(1.0, drawn, LINKS, true));
        let first = State::first(&system);
        let [distance, angle] = gaps(&system, &first);
        assert!(distance < 1e-12 && angle < 1e-12, "{distance} {angle}");
        let (displacement, turn) = moved(&system, 0);
        assert!(displacement.norm() < 1e-11 && (turn - CRANK).abs() < 1e-11, "{displacement:?} {turn}");
        let rocker = moved(&system, 2).1;
        assert!(nearest_branch(rocker, CRANK) < 1e-10, "{rocker} {:?}", freudenstein(CRANK, LINKS));
        let (place, axes) = pose(&system, &first, 1);
        let start = place - axes.column(0) * (0.5 * LINKS[2]);
        let pin = Vec3::new(CRANK.cos(), CRANK.sin(), 0.0) * LINKS[1];
        assert!((start - pin).norm() < 1e-10 && place.z.abs() < 1e-12, "{start:?}");
    }
}

/// The unit of length does not matter.
#[test]
fn an_assembled_model_has_no_units() {
    let drawn = ([3.0, -1.0], 0.9);
    let [one, other] = [1.0, 1e3].map(|scale| built(&four_bar(scale, drawn, LINKS, false)));
    for i in 0..3 {
        let ((x, a), (y, b)) = (moved(&one, i), moved(&other, i));
        assert!((x - y * 1e-3).norm() < 1e-9 && (a - b).abs() < 1e-9, "{x:?} {y:?}");
    }
}

/// Without a drive the crank turns, too, and the position is the nearest one: no small motion of the mechanism comes closer.
#[test]
fn a_free_linkage_closes_to_the_nearest_position() {
    let drawn = ([2.3, 1.1], 0.1);
    let system = built(&four_bar(1.0, drawn, LINKS, false));
    let distance = |system: &System| {
        let state = State::first(system);
        system.kinetic_energy(&state.u)
    };
    let nearest = distance(&system);
    let crank = moved(&system, 0).1;
    assert!((crank - CRANK).abs() > 1e-3, "{crank}");
    // Cranks that are held beside that angle.
    let held = |angle: f64| {
        let mut model = four_bar(1.0, drawn, LINKS, true);
        let pin = [0.0; 3];
        let (sine, cosine) = (angle - CRANK).sin_cos();
        // A frame that is turned by the angle, to which the crank is fixed: its axis of the hinge is the same.
        let to = |at: [f64; 3]| [cosine * at[0] - sine * at[1], sine * at[0] + cosine * at[1], 0.0];
        model.joints.retain(|joint| joint.common().name() != "motor");
        let end = [CRANK.cos(), CRANK.sin(), 0.0];
        model.joints.push(ball("hold", "ground", "crank", to(end), end));
        assert!(to(pin) == pin);
        distance(&built(&model))
    };
    let [before, at, behind] = [-1e-3, 0.0, 1e-3].map(|change| held(crank + change));
    assert!((at - nearest).abs() < 1e-9 * nearest, "{at} {nearest}");
    assert!(before > nearest && behind > nearest, "{before} {nearest} {behind}");
    // The distance is stationary: differences to both sides are equal.
    assert!(
        (before - behind).abs() < 1e-2 * (before + behind - 2.0 * nearest),
        "{before} {behind} {nearest}"
    );
}

#[test]
fn a_gap_that_no_motion_closes_is_refused_with_what_is_left_of_it() {
    // Links of 3 units in all between pins at a distance of 4.
    let mut model = four_bar(1.0, ([2.0, 0.5], 0.0), [4.0, 1.0, 1.0, 1.0], false);
    // One joint with a gap: the rocker meets the coupler.
    let bodies = &model.bodies;
    assert!(bodies.len() == 3);
    let text = refused(&model);
    assert!(text.contains("cannot be closed") && text.contains("\"A\"") && text.contains("\"B\""), "{text}");
    model.bodies[1].at = [CRANK.cos() + 0.5, CRANK.sin(), 0.0];
    model.joints[1] = revolute("A", "crank", "coupler", [CRANK.cos(), CRANK.sin(), 0.0], Z);
    let end = [CRANK.cos() + 1.0, CRANK.sin(), 0.0];
    model.joints[2] = hinge("B", "coupler", "rocker", [end, [4.0, 1.0, 0.0]]);
    let text = refused(&model);
    assert!(text.contains("\"B\" cannot be closed") && text.contains("joints[2].second_at"), "{text}");
    let left = text.split("by the distance ").nth(1).unwrap().split(' ').next().unwrap();
    assert!((left.parse::<f64>().unwrap() - 1.0).abs() < 1e-5, "{text}");
}

/// Axes that a weld holds apart: what is left of the gap is an angle.
#[test]
fn axes_that_stay_apart_are_refused_with_their_angle() {
    let clamp = Joint::Fixed(PointJoint {
        name: "clamp".into(),
        between: between("ground", "bar"),
        at: [0.0; 3],
        second_at: None,
    });
    let tilted = AxisJoint {
        second_axis: Some([0.0, 0.5, 0.75f64.sqrt()]),
        ..axis_joint("guide", "ground", "bar", [1.0, 0.0, 0.0], Z)
    };
    let bar = body("bar", [0.5, 0.0, 0.0], 1.0, Some(INERTIA));
    let text = refused(&machine(1.0, 0.1, vec![bar], vec![clamp, Joint::Planar(tilted)]));
    assert!(text.contains("\"guide\" cannot be closed") && text.contains("angle 30.0000"), "{text}");
}

/// A free linkage in the field of gravity keeps its energy from the assembled position on, and its joints stay closed.
#[test]
fn an_assembled_linkage_moves_with_constant_energy() {
    let mut model = four_bar(1.0, ([2.0, 3.0], 0.7), LINKS, false);
    model.loads = gravity([0.0, -9.81, 0.0]);
    let mut notes = Notes::default();
    let (system, state) = run(&model, &mut notes);
    assert!(
        notes.kinetic > 1.0 && notes.drift() <= 1e-10 * notes.kinetic,
        "{} {}",
        notes.drift(),
        notes.kinetic
    );
    let [distance, angle] = gaps(&system, &state);
    assert!(distance < 1e-9 && angle < 1e-9, "{distance} {angle}");
}

/// Positions of a driven linkage follow Freudenstein's equation from the assembled position on.
#[test]
fn an_assembled_linkage_is_driven() {
    let mut model = four_bar(1.0, ([6.0, -3.0], 1.4), LINKS, true);
    let mut schemes = vec![model.analysis.clone()];
    if let Analysis::Transient(options) = &mut model.analysis {
        options.scheme = Scheme::Kinematic(KinematicScheme::default());
    }
    schemes.push(model.analysis.clone());
    for analysis in schemes {
        let model = Model { analysis, ..model.clone() };
        let (system, state) = run(&model, &mut Notes::default());
        let (_, axes) = pose(&system, &state, 2);
        let rocker = axes[(1, 0)].atan2(axes[(0, 0)]);
        let crank = CRANK + 70_f64.to_radians();
        assert!(nearest_branch(rocker, crank) < 1e-8, "{rocker} {:?}", freudenstein(crank, LINKS));
    }
}

/// A pendulum that is drawn beside its hinge swings in explicit steps as one that is drawn in place.
#[test]
fn explicit_steps_begin_in_the_assembled_position() {
    let bar = |at: [f64; 3]| body("bar", at, 2.0, Some(INERTIA));
    let explicit = |mut model: Model| {
        if let Analysis::Transient(options) = &mut model.analysis {
            options.scheme = Scheme::Explicit(ExplicitScheme::default());
        }
        model.loads = gravity([0.0, -9.81, 0.0]);
        run(&model, &mut Notes::default())
    };
    let placed = revolute("pin", "ground", "bar", [0.0; 3], Z);
    let (one, there) = explicit(machine(0.5, 1e-3, vec![bar([0.5, 0.0, 0.0])], vec![placed]));
    // The gap is along the bar, which does not turn then.
    let drawn = hinge("pin", "ground", "bar", [[0.0; 3], [0.7, 0.0, 0.0]]);
    let (other, here) = explicit(machine(0.5, 1e-3, vec![bar([1.2, 0.0, 0.0])], vec![drawn]));
    let ((x, a), (y, b)) = (pose(&one, &there, 0), pose(&other, &here, 0));
    assert!((x - y).norm() < 1e-10 && (a - b).norm() < 1e-10 && x.y < -0.3, "{x:?} {y:?}");
}

/// A body that is fixed to the ground with a gap: the joint carries its weight at the point to which it has moved.
#[test]
fn statics_begin_in_the_assembled_position() {
    let weld = Joint::Fixed(PointJoint {
        name: "weld".into(),
        between: between("ground", "block"),
        at: [0.0; 3],
        second_at: Some([1.0, 0.5, 0.0]),
    });
    let block = body("block", [3.0, 0.5, 0.0], 4.0, Some(INERTIA));
    let mut model = Model::of_bodies(Analysis::Static(StaticAnalysis::default()), vec![block], vec![weld]);
    model.loads = gravity([0.0, -10.0, 0.0]);
    let system = built(&model);
    let Analysis::Static(options) = &model.analysis else { panic!() };
    let state = statics::run(&system, options, None, &mut Notes::default()).unwrap().state;
    let (place, _) = pose(&system, &state, 0);
    assert!((place - Vec3::new(2.0, 0.0, 0.0)).norm() < 1e-12, "{place:?}");
    let (force, moment) = joint_reaction(&system, &state, &system.joints[0]);
    assert!((force - Vec3::y() * 40.0).norm() < 1e-9, "{force:?}");
    assert!((moment - Vec3::z() * 80.0).norm() < 1e-9, "{moment:?}");
}

/// A plate that floats, with a heavy ball that is drawn above one of its corners: a force on the ball along the diagonal passes through the mass
/// centre of both once they are joined, and makes no rotation.
#[test]
fn inertia_relief_takes_the_assembled_position() {
    let mut m = model(plate([1.0, 1.0], [4, 4], 0.0), 7e10, 0.01);
    let options = StaticAnalysis { inertia_relief: true, ..StaticAnalysis::default() };
    m.analysis = Analysis::Static(options.clone());
    m.conditions.clear();
    m.bodies = vec![body("ball", [1.0, 0.0, 0.5], 0.02, None)];
    m.joints = vec![ball("socket", "ball", "u_max_v_min", [1.0, 0.0, 0.5], [1.0, 0.0, 0.0])];
    m.loads = vec![Load::Force(VectorLoad {
        on: "ball".into(),
        value: [3e-3, -3e-3, 0.0],
        amplitude: None,
        distribution: None,
    })];
    let system = built(&m);
    let state = statics::run(&system, &options, None, &mut Notes::default()).unwrap().state;
    let found = system.relief_acceleration(&state.u, state.time).unwrap();
    // The plate has the mass 0.01, the ball twice that.
    assert!((found.linear - Vec3::new(0.1, -0.1, 0.0)).norm() < 1e-8, "{found:?}");
    assert!(found.angular.norm() < 1e-8, "{found:?}");
}

/// A bar on a hinge with a coil: ω² = k/(J + m l²), wherever the bar is drawn.
#[test]
fn modes_are_those_of_the_assembled_position() {
    let bar = body("bar", [5.0, -2.0, 0.0], 2.0, Some(INERTIA));
    let pin = hinge("pin", "ground", "bar", [[0.0; 3], [4.2, -2.0, 0.0]]);
    let mut model = Model::of_bodies(modal(1, false), vec![bar], vec![pin]);
    // No rotation: the gap is along the line from the pin to the mass centre after a displacement only where the body does not turn.
    model.torsion_springs = vec![TorsionSpring {
        name: "coil".into(),
        between: between("ground", "bar"),
        axis: Z,
        stiffness: 7.0,
        damping: 0.0,
        moment: None,
        free_angle: 0.0,
    }];
    let system = built(&model);
    let found = modes::run(&system, 1, None, &mut Silent).unwrap().modes[0].omega;
    let exact = (7.0_f64 / (INERTIA[2] + 2.0 * 0.64)).sqrt();
    assert!((found / exact - 1.0).abs() < 1e-10, "{found} {exact}");
    // A free mechanism has a mode of frequency zero.
    model.torsion_springs.clear();
    let found = modes::run(&built(&model), 1, None, &mut Silent).unwrap().modes[0].omega;
    assert!(found == 0.0, "{found}");
}

/// Axes that differ by more than a right angle meet in the same direction, and not half a turn away.
#[test]
fn axes_meet_in_their_own_directions() {
    for degrees in [30_f64, 89.0, 100.0, 150.0, 179.0, 180.0] {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        let keys = AxisJoint {
            second_axis: Some([0.0, sine, cosine]),
            ..axis_joint("pin", "ground", "bar", [0.0; 3], Z)
        };
        let bar = || vec![body("bar", [0.5, 0.0, 0.0], 1.0, Some([0.3, 0.2, 0.25]))];
        for joint in [
            Joint::Revolute(keys.clone().into()),
            Joint::Cylindrical(keys.clone()),
            Joint::Planar(keys.clone()),
            Joint::Prismatic(keys.clone().into()),
        ] {
            let system = built(&machine(1.0, 0.1, bar(), vec![joint]));
            let state = State::first(&system);
            let (_, axes) = pose(&system, &state, 0);
            let axis = axes * Vec3::new(0.0, sine, cosine);
            assert!((axis - Vec3::z()).norm() < 1e-9, "{degrees}: {axis:?}");
            let report = system.closed_gaps.as_ref().unwrap();
            assert!((report.joints[0].angle.to_degrees() - degrees).abs() < 1e-9, "{report:?}");
        }
    }
}

/// A screw is closed along its axis and turns with its pitch from there.
#[test]
fn a_screw_is_closed_along_its_thread() {
    let keys = ScrewJoint {
        name: "screw".into(),
        between: between("ground", "nut"),
        at: [0.0; 3],
        axis: Z,
        second_at: Some([0.2, 0.1, 0.31]),
        second_axis: None,
        pitch: 0.05,
    };
    let nut = body("nut", [0.2, 0.1, 0.31], 1.0, Some([1e-3; 3]));
    let system = built(&machine(1.0, 0.1, vec![nut], vec![Joint::Screw(keys)]));
    let (displacement, angle) = moved(&system, 0);
    assert!((displacement.x + 0.2).abs() < 1e-12 && (displacement.y + 0.1).abs() < 1e-12, "{displacement:?}");
    // The nut stands at z = 0.31 + its displacement, where it has turned by that over the pitch.
    let turns = (0.31 + displacement.z) / 0.05;
    let apart = turns - angle / std::f64::consts::TAU;
    assert!((apart - apart.round()).abs() < 1e-10, "{turns} {angle}");
}

/// Axes of a universal joint that are not perpendicular in the reference configuration are closed to a right angle.
#[test]
fn a_universal_joint_makes_its_axes_perpendicular() {
    let keys = TwoAxesJoint {
        name: "cross".into(),
        between: between("ground", "shaft"),
        at: [0.0; 3],
        axes: [[1.0, 0.0, 0.0], [0.6, 0.8, 0.0]],
        second_at: Some([0.5, 0.5, 0.0]),
    };
    let shaft = body("shaft", [0.5, 0.5, 1.0], 1.0, Some(INERTIA));
    let system = built(&machine(1.0, 0.1, vec![shaft], vec![Joint::Universal(keys)]));
    let (_, axes) = pose(&system, &State::first(&system), 0);
    assert!((axes * Vec3::new(0.6, 0.8, 0.0)).x.abs() < 1e-12, "{axes:?}");
    let report = system.closed_gaps.as_ref().unwrap();
    assert!((report.joints[0].angle - 0.6_f64.asin()).abs() < 1e-12, "{report:?}");
}

/// A drawer whose rail has a stop begins where its sides have come to stand.
#[test]
fn stops_count_from_where_the_sides_would_meet() {
    let rail = |second: f64| {
        let mut keys: CoordinateJoint =
            axis_joint("rail", "ground", "block", [0.0; 3], [1.0, 0.0, 0.0]).into();
        keys.second_at = Some([second, 0.2, 0.0]);
        keys.stops = Some(JointStops { lower: Some(-0.5), upper: Some(1.0), restitution: 0.0 });
        machine(
            0.1,
            0.01,
            vec![body("block", [0.0, 0.2, 0.0], 1.0, Some(INERTIA))],
            vec![Joint::Prismatic(keys)],
        )
    };
    // The gap across the rail is closed, and the displacement along it stays.
    let (system, state) = run(&rail(0.3), &mut Notes::default());
    let (place, _) = pose(&system, &state, 0);
    assert!((place - Vec3::zeros()).norm() < 1e-12, "{place:?}");
    assert!((state.coordinates[0].value - 0.3).abs() < 1e-12, "{:?}", state.coordinates);
    let model = rail(1.4);
    let Analysis::Transient(options) = &model.analysis else { panic!() };
    let error = dynamics::run(&built(&model), options, None, &mut Notes::default()).unwrap_err().to_string();
    assert!(error.contains("rail"), "{error}");
}

/// Shells do not move when a model is assembled: a body comes to a node, but no node to the ground.
#[test]
fn shells_stay_where_they_are() {
    let mut m = model(plate([1.0, 1.0], [2, 2], 0.0), 7e10, 0.01);
    m.analysis = machine(0.1, 0.01, Vec::new(), Vec::new()).analysis;
    m.bodies = vec![body("ball", [1.0, 0.0, 0.5], 1.0, Some([0.1; 3]))];
    m.joints = vec![ball("socket", "ball", "u_max_v_min", [1.0, 0.0, 0.5], [1.0, 0.0, 0.0])];
    let system = built(&m);
    let (displacement, _) = moved(&system, 0);
    assert!((displacement + Vec3::z() * 0.5).norm() < 1e-12, "{displacement:?}");
    m.joints.push(ball("corner", "u_max_v_max", "ground", [1.0, 1.0, 0.0], [1.0, 1.0, 0.1]));
    let text = refused(&m);
    assert!(text.contains("\"corner\"") && text.contains("none of them is a rigid body"), "{text}");
    m.joints.pop();
    m.joints = vec![Joint::ClampedDirector(PointJoint {
        name: "clamp".into(),
        between: between("ball", "u_max_v_min"),
        at: [1.0, 0.0, 0.0],
        second_at: Some([1.0, 0.0, 0.0]),
    })];
    assert!(refused(&m).contains("joints[0].second_at"));
    m.conditions.push(Condition::Clamp(on("u_max")));
}

/// A joint that the first step releases is not closed there, and one that it locks holds the sides where they meet.
#[test]
fn the_first_step_is_assembled_with_its_own_joints() {
    let bodies =
        || vec![body("a", [0.0; 3], 1.0, Some(INERTIA)), body("b", [2.0, 0.0, 0.0], 1.0, Some(INERTIA))];
    let joints = vec![
        revolute("hinge", "ground", "a", [-1.0, 0.0, 0.0], Z),
        hinge("link", "a", "b", [[0.5, 0.0, 0.0], [1.5, 0.3, 0.0]]),
    ];
    let mut m = machine(0.1, 0.01, bodies(), joints);
    let analysis = m.analysis.clone();
    m.steps = vec![AnalysisStep::new("first", analysis.clone()), AnalysisStep::new("second", analysis)];
    m.steps[0].released = vec!["link".into()];
    assert!(built(&m).closed_gaps.is_none());
    m.steps[0].released.clear();
    let free = moved(&built(&m), 0).1;
    assert!(free.abs() > 1e-3, "{free}");
    m.steps[0].locked = vec!["hinge".into()];
    let system = built(&m);
    assert!(moved(&system, 0).1.abs() < 1e-12 && gaps(&system, &State::first(&system))[0] < 1e-12);
}

/// Coordinates that were computed differ by round-off: the sides meet, and the motion is that of sides at one place to the last bit.
#[test]
fn sides_apart_by_round_off_meet() {
    let motion = |apart: f64| {
        let rod = body("rod", [0.5, 0.0, 0.0], 2.0, Some(INERTIA));
        let mut keys = axis_joint("joint", "rod", "ground", [0.0; 3], Z);
        keys.second_at = Some([apart, 0.0, -apart]);
        keys.second_axis = Some([0.0, apart, 1.0]);
        let mut m = machine(1.0, 0.1, vec![rod], vec![Joint::Revolute(keys.into())]);
        m.loads = gravity([0.0, -9.81, 0.0]);
        let (system, state) = run(&m, &mut Silent);
        assert!(system.closed_gaps.is_none(), "{apart:e}");
        state
    };
    let exact = motion(0.0);
    for apart in [1e-16, 1e-14, 2e-13] {
        assert_eq!(motion(apart).u, exact.u, "{apart:e}");
    }
}
