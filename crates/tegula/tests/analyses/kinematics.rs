//! Kinematic analyses of driven mechanisms against closed forms, inverse dynamics, and what joints and drives leave free.

use std::f64::consts::TAU;

use nalgebra::Complex;

use crate::common::{Notes, distance};
use crate::multibody::{axis_joint, between, body, gravity, machine, revolute, run};
use tegula::analysis::{State, dynamics, statics};
use tegula::model::*;
use tegula::norm::{larger, max_norm};
use tegula::result::bodies::BodyMotion;
use tegula::result::joint_reaction;
use tegula::{System, Vec3, compile, mesh};

type C = Complex<f64>;

const Z: [f64; 3] = [0.0, 0.0, 1.0];
const GRAVITY: f64 = 9.81;
/// Lengths of ground, crank, coupler and rocker.
const LINKS: [f64; 4] = [1.0, 0.3, 0.9, 0.7];
/// Masses of crank, coupler and rocker, and their moments of inertia about z.
const MASSES: [f64; 3] = [0.6, 1.8, 1.4];
const INERTIA: [f64; 3] = [0.01, 0.13, 0.06];

/// Angle (rad), its rate and its second rate of the driven crank.
fn drive(t: f64) -> [f64; 3] {
    [3.0 * t + 1.5 * t * t, 3.0 + 3.0 * t, 3.0]
}

/// Motion of the four-bar linkage by complex numbers: angles of crank, coupler and rocker with both rates.
fn linkage(crank: [f64; 3]) -> [[f64; 3]; 3] {
    let [d, a, b, c] = LINKS;
    let unit = |angle: f64| C::new(0.0, angle).exp();
    // The end of the coupler is where the circles about the crank's pin and about the rocker's hinge meet.
    let pin = unit(crank[0]) * a;
    let to_hinge = C::new(d, 0.0) - pin;
    let apart = to_hinge.norm();
    let along = (apart * apart + b * b - c * c) / (2.0 * apart);
    let end = pin + to_hinge / apart * C::new(along, (b * b - along * along).sqrt());
    let coupler = (end - pin).arg();
    let rocker = (end - d).arg();
    // b i φ′ e^{iφ} − c i ψ′ e^{iψ} = right, solved for both rates.
    let solve = |right: C| {
        let [p, q] = [unit(coupler) * C::i() * b, -unit(rocker) * C::i() * c];
        let det = p.re * q.im - p.im * q.re;
        [(right.re * q.im - right.im * q.re) / det, (p.re * right.im - p.im * right.re) / det]
    };
    let [rate, second] = [crank[1], crank[2]];
    let [phi, psi] = solve(-unit(crank[0]) * C::i() * a * rate);
    let centripetal =
        unit(crank[0]) * a * (rate * rate) + unit(coupler) * b * (phi * phi) - unit(rocker) * c * (psi * psi);
    let [phi2, psi2] = solve(centripetal - unit(crank[0]) * C::i() * a * second);
    [crank, [coupler, phi, phi2], [rocker, psi, psi2]]
}

/// Positions, velocities and accelerations of the mass centres, in the middle of each link.
fn centres(crank: [f64; 3]) -> [[C; 3]; 3] {
    let [d, a, b, c] = LINKS;
    let arm = |[angle, rate, second]: [f64; 3], length: f64| {
        let r = C::new(0.0, angle).exp() * length;
        [r, C::i() * r * rate, r * C::new(-rate * rate, second)]
    };
    let [one, two, three] = linkage(crank);
    let crank = arm(one, a);
    let half = arm(two, 0.5 * b);
    let rocker = arm(three, 0.5 * c);
    [
        arm(one, 0.5 * a),
        std::array::from_fn(|i| crank[i] + half[i]),
        std::array::from_fn(|i| rocker[i] + if i == 0 { C::new(d, 0.0) } else { C::new(0.0, 0.0) }),
    ]
}

/// Moment of the drive by the power of all bodies: `M ω = d(kinetic energy + potential)/dt`.
fn moment(crank: [f64; 3]) -> f64 {
    let power = |i: usize| {
        let [_, v, a] = centres(crank)[i];
        let [_, rate, second] = linkage(crank)[i];
        MASSES[i] * (v.re * a.re + v.im * (a.im + GRAVITY)) + INERTIA[i] * rate * second
    };
    (0..3).map(power).sum::<f64>() / crank[1]
}

/// The linkage, in steps of a given size; its joints say three times that it is plane.
fn four_bar(end: f64, step: f64, masses: bool) -> Model {
    let at = |z: C| [z.re, z.im, 0.0];
    let places = centres(drive(0.0));
    let names = ["crank", "coupler", "rocker"];
    let link = |i: usize| {
        let inertia = masses.then_some([0.4 * INERTIA[i], INERTIA[i], INERTIA[i]]);
        let along = C::new(0.0, linkage(drive(0.0))[i][0]).exp();
        RigidBody {
            axes: [at(along), at(C::i() * along)],
            mass: masses.then_some(MASSES[i]),
            inertia,
            ..body(names[i], at(places[i][0]), 1.0, None)
        }
    };
    let end_of_coupler = C::new(LINKS[0], 0.0) + C::new(0.0, linkage(drive(0.0))[2][0]).exp() * LINKS[3];
    let joints = vec![
        revolute("O", "ground", "crank", [0.0; 3], Z),
        revolute("A", "crank", "coupler", [LINKS[1], 0.0, 0.0], Z),
        revolute("B", "coupler", "rocker", at(end_of_coupler), Z),
        revolute("C", "ground", "rocker", [LINKS[0], 0.0, 0.0], Z),
        motor("crank"),
    ];
    let mut model = machine(end, step, (0..3).map(link).collect(), joints);
    model.amplitudes.insert("turn".into(), formula("(3*t + 1.5*t^2)*180/PI"));
    if masses {
        model.loads = gravity([0.0, -GRAVITY, 0.0]);
    }
    kinematic(model)
}

fn formula(text: &str) -> Amplitude {
    Amplitude::Expression(ExpressionAmplitude { expression: text.into() })
}

fn motor(body: &str) -> Joint {
    Joint::DrivenAngle(DrivenAngleJoint {
        name: "motor".into(),
        between: between("ground", body),
        axis: Z,
        angle: 1.0,
        amplitude: "turn".into(),
    })
}

fn kinematic(mut model: Model) -> Model {
    if let Analysis::Transient(options) = &mut model.analysis {
        options.scheme = Scheme::Kinematic(KinematicScheme::default());
    }
    model
}

fn complex(v: Vec3) -> C {
    C::new(v.x, v.y)
}

/// Largest differences of positions, velocities and accelerations from the closed form, over all states.
fn differences(system: &System, states: &[State]) -> [f64; 3] {
    let mut out = [0.0_f64; 3];
    for state in states {
        let (places, angles) = (centres(drive(state.time)), linkage(drive(state.time)));
        for (i, body) in system.coordinates.bodies.iter().enumerate() {
            let motion = BodyMotion::new(system, state, body);
            let acceleration = Vec3::from(state.a[body.centre as usize]);
            let found = [motion.position, motion.velocity, acceleration];
            for k in 0..3 {
                let apart = (complex(found[k]) - places[i][k]).norm() + found[k].z.abs();
                out[k] = larger(out[k], apart);
            }
            let axis = C::new(0.0, angles[i][0]).exp();
            out[0] = larger(out[0], (complex(motion.axes.column(0).into()) - axis).norm());
            let spin = (motion.angular_velocity - Vec3::from(Z) * angles[i][1]).norm();
            out[1] = larger(out[1], spin);
        }
    }
    out
}

/// Two turns of the crank in 30 steps, with masses and without: every position, velocity and acceleration is that of the loop equation,
/// whatever the step.
#[test]
fn a_four_bar_linkage_moves_by_its_loop_equation() {
    for masses in [true, false] {
        let mut notes = Notes::keeping();
        let (system, _) = run(&four_bar(2.0, 2.0 / 30.0, masses), &mut notes);
        // The state at the start, and one for each step.
        assert_eq!(notes.states.len(), 31);
        let [x, v, a] = differences(&system, &notes.states);
        assert!(x < 1e-12 && v < 1e-10 && a < 1e-8, "{masses}: {x} {v} {a}");
        assert!(notes.iterations.iter().all(|n| *n <= 6), "{:?}", notes.iterations);
    }
}

/// The model with everything at another place.
fn moved(model: &Model, by: f64) -> Model {
    let mut model = model.clone();
    model.bodies.iter_mut().for_each(|body| body.at[0] += by);
    for joint in &mut model.joints {
        if let Joint::Revolute(keys) = joint {
            keys.at[0] += by;
        }
    }
    model
}

/// At 1e5 and 1e6 sizes from the origin positions have fewer digits, and the motion is the same otherwise, in kinematics and in dynamics.
#[test]
fn a_machine_far_from_the_origin_moves_as_at_the_origin() {
    let kinematic = four_bar(0.5, 0.05, true);
    let mut dynamic = kinematic.clone();
    let options = TransientAnalysis { time_step: Some(1e-3), ..TransientAnalysis::new(0.5) };
    dynamic.analysis = Analysis::Transient(TransientAnalysis {
        scheme: Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 }),
        ..options
    });
    for model in [kinematic, dynamic] {
        let (system, here) = run(&model, &mut Notes::default());
        for away in [1e5, 1e6] {
            let (_, there) = run(&moved(&model, away), &mut Notes::default());
            assert!(distance(&here.u, &there.u) < 1e-13 * away, "{away}: {}", distance(&here.u, &there.u));
        }
        assert!(system.norm(&here.u) > 0.1);
    }
    let far = moved(&four_bar(0.5, 0.05, true), 1e7);
    let mesh = mesh::generators::generate(&far.mesh).unwrap();
    let system = compile::build(&far, &mesh).unwrap();
    let found = compile::warnings(&far, &mesh, &system);
    assert!(found.iter().any(|issue| issue.message.contains("from the origin")), "{found:?}");
}

/// The moment of the drive is the power of all masses over its speed; without masses there is none.
#[test]
fn the_drive_of_a_kinematic_analysis_has_the_moment_of_inverse_dynamics() {
    let mut notes = Notes::keeping();
    let (system, _) = run(&four_bar(2.0, 0.05, true), &mut notes);
    let largest = max_norm(notes.states.iter().map(|s| moment(drive(s.time))));
    for state in &notes.states {
        let (_, found) = joint_reaction(&system, state, &system.joints[4]);
        let expected = moment(drive(state.time));
        assert!((found.z - expected).abs() < 1e-9 * largest, "{}: {} {expected}", state.time, found.z);
    }
    let (system, state) = run(&four_bar(0.2, 0.05, false), &mut Notes::default());
    for joint in system.joints.iter() {
        let (force, moment) = joint_reaction(&system, &state, joint);
        assert_eq!((force.norm(), moment.norm()), (0.0, 0.0));
    }
}

/// Message of a model that is refused.
fn refusal(model: &Model) -> String {
    let mesh = mesh::generators::generate(&model.mesh).unwrap();
    match compile::build(model, &mesh) {
        Err(error) => error.to_string(),
        Ok(system) => {
            let Analysis::Transient(options) = &model.analysis else { panic!() };
            dynamics::run(&system, options, None, &mut Notes::default()).err().unwrap().to_string()
        }
    }
}

/// A coupler between two ball joints turns about the line through them, whatever the drive does.
#[test]
fn a_motion_that_no_drive_determines_is_named_by_body_and_axis() {
    let mut model = four_bar(1.0, 0.1, true);
    for joint in &mut model.joints[1..3] {
        let Joint::Revolute(keys) = joint else { panic!() };
        let (name, [a, b], at) = (keys.name.clone(), keys.between.clone(), keys.at);
        *joint = Joint::Spherical(PointJoint { name, between: [a, b], at, second_at: None });
    }
    let text = refusal(&model);
    let phi = linkage(drive(0.0))[1][0];
    let axis = format!("along ({:.4}, {:.4}, 0.0000)", phi.cos(), phi.sin());
    assert!(text.contains("1 motion(s) free: body \"coupler\" turns about the axis"), "{text}");
    assert!(text.contains(&axis) && text.contains("at the start"), "{text}");
}

/// A parallelogram may fold over where all its links lie in one line: the drive does not say on which branch it goes on.
#[test]
fn a_position_that_the_drive_passes_without_determining_it_is_refused_with_its_time() {
    let bar = |name: &str, at, axes| RigidBody { axes, ..body(name, at, 1.0, Some([0.1; 3])) };
    let along = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let bodies = vec![
        bar("crank", [0.0, 0.5, 0.0], along),
        bar("coupler", [1.0, 1.0, 0.0], along),
        bar("rocker", [2.0, 0.5, 0.0], along),
    ];
    let joints = vec![
        revolute("O", "ground", "crank", [0.0; 3], Z),
        revolute("A", "crank", "coupler", [0.0, 1.0, 0.0], Z),
        revolute("B", "coupler", "rocker", [2.0, 1.0, 0.0], Z),
        revolute("C", "ground", "rocker", [2.0, 0.0, 0.0], Z),
        motor("crank"),
    ];
    let mut model = machine(2.0, 0.125, bodies, joints);
    model.amplitudes.insert("turn".into(), formula("-90*t"));
    let text = refusal(&kinematic(model));
    assert!(text.contains("time 1.000000e0: in this singular position"), "{text}");
    assert!(text.contains("1 motion(s) free: body"), "{text}");
}

/// A drive swings a pendulum to 60° and rests there; then it is released, and the pendulum swings with the period of its elliptic
/// integral, `T = 2π √(J/(m g l)) / agm(1, cos 30°)`.
#[test]
fn a_motion_goes_on_from_the_position_to_which_a_kinematic_step_has_driven_it() {
    let arm = body("arm", [0.0, -0.5, 0.0], 2.0, Some([0.1; 3]));
    let joints = vec![revolute("hinge", "ground", "arm", [0.0; 3], Z), motor("arm")];
    let (mut a, mut b) = (1.0_f64, 30f64.to_radians().cos());
    for _ in 0..6 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    let period = TAU * ((0.1 + 2.0 * 0.25) / (2.0 * GRAVITY * 0.5)).sqrt() / a;
    let mut model = kinematic(machine(1.0, 0.05, vec![arm], joints));
    model.amplitudes.insert("turn".into(), formula("60*(10*t^3 - 15*t^4 + 6*t^5)"));
    model.loads = gravity([0.0, -GRAVITY, 0.0]);
    let swing = TransientAnalysis {
        scheme: Scheme::EnergyMomentum(EnergyMomentumScheme { order: 4 }),
        time_step: Some(period / 200.0),
        ..TransientAnalysis::new(period)
    };
    let steps = [model.analysis.clone(), Analysis::Transient(swing)];
    model.steps = steps.iter().map(|a| AnalysisStep::new("", a.clone())).collect();
    model.steps[1].released = vec!["motor".into()];
    let mesh = mesh::generators::generate(&model.mesh).unwrap();
    let compiler = compile::Compiler::new(&model, &mesh).unwrap();
    let mut start = None;
    for (number, analysis) in steps.iter().enumerate() {
        let system = compiler.system(number, start.take()).unwrap();
        let Analysis::Transient(options) = analysis else { panic!() };
        let state = dynamics::run(&system, options, None, &mut Notes::default()).unwrap().state;
        let place = BodyMotion::new(&system, &state, &system.coordinates.bodies[0]).position;
        let expected = Vec3::new(60f64.to_radians().sin(), -60f64.to_radians().cos(), 0.0) * 0.5;
        assert!((place - expected).norm() < [1e-12, 1e-6][number], "{number}: {place}");
        start = Some(state.end_of_step());
    }
}

/// A moment turns a wheel without end: no equilibrium is found, and the message says which body turns about which axis.
#[test]
fn a_static_mechanism_without_equilibrium_is_named_by_body_and_axis() {
    let wheel = body("wheel", [0.3, 0.2, 0.0], 2.0, Some([0.1; 3]));
    let pin = axis_joint("hinge", "ground", "wheel", [0.3, 0.2, 0.0], [0.0, 3.0, 4.0]);
    let mut model = machine(1.0, 0.1, vec![wheel], vec![Joint::Revolute(pin.into())]);
    let options = StaticAnalysis::default();
    model.analysis = Analysis::Static(options.clone());
    model.loads = vec![Load::Moment(crate::common::vector_load("wheel", [0.0, 0.0, 5.0]))];
    let mesh = mesh::generators::generate(&model.mesh).unwrap();
    let system = compile::build(&model, &mesh).unwrap();
    let error = statics::run(&system, &options, None, &mut Notes::default()).err().unwrap().to_string();
    let axis =
        "body \"wheel\" turns about the axis through (0.3000, 0.2000, 0.0000) along (0.0000, 0.6000, 0.8000)";
    assert!(error.contains(axis), "{error}");
}

/// A plate on a hub that nothing holds about its hinge falls: the message names the hub and its axis.
#[test]
fn a_shell_that_turns_freely_on_a_hinge_is_named_by_its_hub() {
    let mut model = crate::common::model(crate::common::plate([1.0, 0.2], [4, 2], 0.0), 2.1e11, 0.005);
    let options = StaticAnalysis::default();
    model.analysis = Analysis::Static(options.clone());
    model.conditions.clear();
    let hub =
        RigidBody { mass: None, attached: vec!["u_min".into()], ..body("hub", [0.0, 0.1, 0.0], 1.0, None) };
    model.bodies = vec![hub];
    model.joints = vec![revolute("hinge", "ground", "hub", [0.0, 0.1, 0.0], [0.0, 1.0, 0.0])];
    model.loads = vec![Load::Edge(VectorLoad::new("u_max", [0.0, 0.0, -1.0]))];
    let (_, system) = crate::common::compile(&model);
    let error = statics::run(&system, &options, None, &mut Notes::default()).err().unwrap().to_string();
    let axis =
        "body \"hub\" turns about the axis through (0.0000, 0.1000, 0.0000) along (0.0000, 1.0000, 0.0000)";
    assert!(error.contains("1 motion(s) free") && error.contains(axis), "{error}");
    assert!(error.contains("nodes of the mesh"), "{error}");
}

/// A kinematic analysis refuses what it does not know, with the body or the joint.
#[test]
fn a_kinematic_analysis_refuses_velocities_friction_and_missing_drives() {
    let mut fast = four_bar(1.0, 0.1, true);
    fast.bodies[1].velocity = [1.0, 0.0, 0.0];
    let mut undriven = four_bar(1.0, 0.1, true);
    undriven.joints.truncate(4);
    for (model, words) in [(&fast, "\"coupler\" has a velocity"), (&undriven, "no joint is driven")] {
        let text = refusal(model);
        assert!(text.contains(words), "{text}");
    }
}

/// One arm on a hinge, which a drive turns by this formula or table (degrees).
fn driven_arm(amplitude: Amplitude, time_step: Option<f64>) -> Model {
    let arm = body("arm", [0.5, 0.0, 0.0], 2.0, Some([0.1, 0.2, 0.3]));
    let joints = vec![revolute("hinge", "ground", "arm", [0.0; 3], Z), motor("arm")];
    let mut model = kinematic(machine(1.0, 0.05, vec![arm], joints));
    model.amplitudes.insert("turn".into(), amplitude);
    if let Analysis::Transient(options) = &mut model.analysis {
        options.time_step = time_step;
    }
    model
}

/// Crank, coupler and rocker of 0.3, 0.8 and 0.81 on a ground of 0.32 come close to their other branch: a step of 21° would jump there.
#[test]
fn long_steps_stay_on_the_branch_of_the_mechanism() {
    let [d, a, b, c] = [0.32_f64, 0.3, 0.8, 0.81];
    let end_of = |crank: f64| {
        let pin = C::new(0.0, crank).exp() * a;
        let to_hinge = C::new(d, 0.0) - pin;
        let apart = to_hinge.norm();
        let along = (apart * apart + b * b - c * c) / (2.0 * apart);
        pin + to_hinge / apart * C::new(along, (b * b - along * along).sqrt())
    };
    let at = |z: C| [z.re, z.im, 0.0];
    let start = 0.7;
    let (pin, end) = (C::new(0.0, start).exp() * a, end_of(start));
    let hinge = C::new(d, 0.0);
    let bodies = [("crank", pin * 0.5), ("coupler", (pin + end) * 0.5), ("rocker", (hinge + end) * 0.5)]
        .map(|(name, place)| body(name, at(place), 1.0, Some([0.1; 3])));
    let joints = vec![
        revolute("O", "ground", "crank", [0.0; 3], Z),
        revolute("A", "crank", "coupler", at(pin), Z),
        revolute("B", "coupler", "rocker", at(end), Z),
        revolute("C", "ground", "rocker", at(hinge), Z),
        motor("crank"),
    ];
    for step in [0.25, 0.15, 0.05] {
        let mut model = kinematic(machine(12.0, step, bodies.to_vec(), joints.clone()));
        model.amplitudes.insert("turn".into(), formula("1.5*t*180/PI"));
        let mut notes = Notes::keeping();
        let (system, _) = run(&model, &mut notes);
        let apart = max_norm(notes.states.iter().map(|state| {
            let place = BodyMotion::new(&system, state, &system.coordinates.bodies[2]).position;
            (complex(place) - (hinge + end_of(start + 1.5 * state.time)) * 0.5).norm()
        }));
        assert!(apart < 1e-10, "{step}: {apart}");
        let shortened = notes.states.len() > (12.0_f64 / step).round() as usize + 1;
        assert_eq!(shortened, step > 0.1, "{step}: {}", notes.states.len());
    }
}

/// Drives that come to rest, set off slowly, or hold for a while: round-off of positions is no failure, in steps of any length.
#[test]
#[ignore = "long"]
fn drives_at_rest_and_slow_ones_are_followed() {
    for angle in [40.0, 90.0, 270.0] {
        for expression in
            [format!("{angle}*tanh(8*t)"), format!("{angle}*t^3"), format!("{angle}*t^2*(3 - 2*t)")]
        {
            for time_step in [None, Some(0.05), Some(1e-3)] {
                let (system, state) =
                    run(&driven_arm(formula(&expression), time_step), &mut Notes::default());
                let place = BodyMotion::new(&system, &state, &system.coordinates.bodies[0]).position;
                let last = if expression.contains("tanh") { 8f64.tanh() } else { 1.0 };
                let expected = C::new(0.0, (angle * last).to_radians()).exp() * 0.5;
                assert!((complex(place) - expected).norm() < 1e-12, "{expression} {time_step:?}: {place}");
            }
        }
    }
}

/// A drive that starts and stops at once takes up the kinetic energy as work: the balance is closed at each step, and steps end there.
#[test]
fn jumps_of_the_speed_of_a_drive_are_its_work() {
    let (times, values) = (vec![0.0, 0.35, 0.5, 1.0], vec![0.0, 0.0, 90.0, 45.0]);
    for time_step in [None, Some(0.1)] {
        let table = TableAmplitude { times: times.clone(), values: values.clone() };
        let mut notes = Notes::default();
        run(&driven_arm(Amplitude::Table(table), time_step), &mut notes);
        assert!(notes.kinetic > 40.0 && notes.drift() < 1e-10 * notes.kinetic, "{}", notes.drift());
        let met = |at: f64| notes.totals.iter().any(|(t, _)| (t - at).abs() < 1e-12);
        assert!(met(0.35) && met(0.5), "{:?}", notes.totals);
    }
}

/// A torsion spring counts full turns: its moment is that of the drive, over two turns.
#[test]
fn a_torsion_spring_is_wound_up_by_full_turns() {
    let mut model = driven_arm(formula("720*t"), Some(0.01));
    model.torsion_springs = vec![TorsionSpring {
        name: "coil".into(),
        between: between("ground", "arm"),
        axis: Z,
        stiffness: 5.0,
        damping: 0.0,
        free_angle: 0.0,
        moment: None,
    }];
    let mut notes = Notes::keeping();
    let (system, _) = run(&model, &mut notes);
    for state in &notes.states[1..] {
        let (_, moment) = joint_reaction(&system, state, &system.joints[1]);
        let expected = 5.0 * 2.0 * TAU * state.time;
        assert!((moment.z - expected).abs() < 1e-9, "{}: {moment} {expected}", state.time);
    }
}

/// A crank that is too long for its linkage: the analysis ends where it locks, and says so.
#[test]
fn a_mechanism_that_locks_ends_the_analysis_with_this_reason() {
    let mut model = four_bar(3.0, 0.02, true);
    let drives = Joint::DrivenAngle(DrivenAngleJoint {
        name: "motor".into(),
        between: between("ground", "rocker"),
        axis: Z,
        angle: 1.0,
        amplitude: "turn".into(),
    });
    model.joints[4] = drives;
    let text = refusal(&model);
    assert!(text.contains("no position next to the one before") || text.contains("would jump"), "{text}");
    assert!(text.contains("locks"), "{text}");
}
