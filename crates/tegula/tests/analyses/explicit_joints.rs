//! Explicit steps with rigid bodies and joints: closed forms, conservation laws, implicit steps, and what is refused.

use std::f64::consts::FRAC_PI_2;

use crate::common::{Notes, move_in_time, vector_load};
use crate::multibody::{
    axis_joint, between, body, gravity, heavy_top, machine, pose, revolute, run, spin, spring,
};
use crate::patches::{hub, strip};
use crate::step_joints::{self, step};
use tegula::analysis::{Silent, dynamics};
use tegula::model::*;
use tegula::norm::max_norm;
use tegula::result::joint_reaction;
use tegula::{System, Vec3, compile, mesh};

const Y: [f64; 3] = [0.0, 1.0, 0.0];
const GRAVITY: f64 = 9.81;

/// A machine in explicit steps of constant length, or of the length that is found.
fn explicit(end: f64, step: Option<f64>, bodies: Vec<RigidBody>, joints: Vec<Joint>) -> Model {
    let model = machine(end, 1.0, bodies, joints);
    let scheme = Scheme::Explicit(ExplicitScheme::default());
    let analysis = TransientAnalysis { scheme, time_step: step, ..TransientAnalysis::new(end) };
    Model { analysis: Analysis::Transient(analysis), ..model }
}

/// Jacobi's functions sn, cn and dn of the modulus k, by the arithmetic–geometric mean (Abramowitz, Stegun 16.4).
fn jacobi(u: f64, k: f64) -> [f64; 3] {
    let (mut a, mut b, mut c) = (vec![1.0_f64], (1.0 - k * k).sqrt(), vec![k]);
    while c[c.len() - 1].abs() > 1e-16 {
        let last = a[a.len() - 1];
        c.push(0.5 * (last - b));
        a.push(0.5 * (last + b));
        b = (last * b).sqrt();
    }
    let n = a.len() - 1;
    let mut phi = a[n] * u * 2.0_f64.powi(n as i32);
    for i in (1..=n).rev() {
        phi = 0.5 * (phi + (c[i] / a[i] * phi.sin()).asin());
    }
    let [sn, cn] = [phi.sin(), phi.cos()];
    [sn, cn, (1.0 - k * k * sn * sn).sqrt()]
}

#[test]
fn jacobi_functions_have_tabulated_values() {
    // Abramowitz, Stegun, example 16.1: sn(0.2 | m = 0.81), and limits.
    let [sn, cn, dn] = jacobi(0.20, 0.9);
    assert!((sn - 0.19762).abs() < 1e-5 && (sn * sn + cn * cn - 1.0).abs() < 1e-15, "{sn} {cn} {dn}");
}

const MASS: f64 = 2.0;
const ARM: f64 = 0.4;
const INERTIA: [f64; 3] = [0.03, 0.11, 0.09];

/// A body on a hinge at the origin, released from rest in the horizontal.
fn pendulum(end: f64, step: Option<f64>) -> Model {
    let bob = body("bob", [ARM, 0.0, 0.0], MASS, Some(INERTIA));
    let model = explicit(end, step, vec![bob], vec![revolute("hinge", "ground", "bob", [0.0; 3], Y)]);
    Model { loads: gravity([0.0, 0.0, -GRAVITY]), ..model }
}

/// Position and velocity of the mass centre, and force of the hinge on the body, at a time: θ is the angle from the vertical,
/// `sin θ/2 = k cd(Ω t, k)` (L. Landau, E. Lifshitz, *Mechanics*, § 11).
fn exact(t: f64) -> [Vec3; 3] {
    let omega = (MASS * GRAVITY * ARM / (INERTIA[1] + MASS * ARM * ARM)).sqrt();
    let k = (0.5 * FRAC_PI_2).sin();
    let [sn, cn, dn] = jacobi(omega * t, k);
    let half = (k * cn / dn).asin();
    let theta = 2.0 * half;
    // d cd/du = −(1 − k²) sn/dn².
    let rate = -2.0 * k * omega * (1.0 - k * k) * sn / (dn * dn) / half.cos();
    let second = -omega * omega * theta.sin();
    let radial = Vec3::new(theta.sin(), 0.0, -theta.cos());
    let tangent = Vec3::new(theta.cos(), 0.0, theta.sin());
    let acceleration = (tangent * second - radial * (rate * rate)) * ARM;
    [radial * ARM, tangent * (ARM * rate), (acceleration + Vec3::z() * GRAVITY) * MASS]
}

/// Positions, velocities and multipliers of a pendulum are of second order, and the joint stays closed to round-off.
#[test]
fn a_pendulum_is_of_second_order_in_positions_velocities_and_reactions() {
    let end = 1.7;
    let errors = |steps: u32| {
        let (system, state) = run(&pendulum(end, Some(end / f64::from(steps))), &mut Silent);
        let (x, axes) = pose(&system, &state, 0);
        let v = Vec3::from(state.v[system.coordinates.bodies[0].centre as usize]);
        let (reaction, _) = joint_reaction(&system, &state, &system.joints[0]);
        let [place, velocity, force] = exact(end);
        let open = (x - axes * Vec3::new(ARM, 0.0, 0.0)).norm();
        assert!(open < 1e-14, "{open}");
        [(x - place).norm(), (v - velocity).norm(), (reaction - force).norm() / (MASS * GRAVITY)]
    };
    let [coarse, middle, fine] = [400, 800, 1600].map(errors);
    println!("{coarse:?} {middle:?} {fine:?}");
    for i in 0..3 {
        let ratios = [coarse[i] / middle[i], middle[i] / fine[i]];
        assert!(ratios.iter().all(|r| (3.8..4.2).contains(r)), "{i}: {coarse:?} {middle:?} {fine:?}");
    }
    assert!(max_norm(fine) < 1e-4, "{fine:?}");
}

fn options(model: &Model) -> &TransientAnalysis {
    let Analysis::Transient(options) = &model.analysis else { panic!("no transient analysis") };
    options
}

fn built(model: &Model) -> System {
    compile::build(model, &mesh::generators::generate(&model.mesh).unwrap()).unwrap()
}

/// Largest distance of the momenta from the first ones.
fn lost(notes: &Notes) -> [f64; 2] {
    let first = notes.momenta[0];
    let all = notes.momenta.iter();
    [max_norm(all.clone().map(|m| (m.0 - first.0).norm())), max_norm(all.map(|m| (m.1 - first.1).norm()))]
}

/// A free body turns over about its intermediate axis (Dzhanibekov): angular momentum and energy stay to round-off, and the angular velocity is of
/// second order, compared with a Runge–Kutta method of order 8 at 1e-13.
#[test]
fn a_free_body_keeps_angular_momentum_and_energy() {
    let top = RigidBody {
        angular_velocity: [0.01, 10.0, 0.02],
        velocity: [1.0, -2.0, 0.5],
        ..body("top", [0.3, 0.0, 0.0], 1.0, Some([1.0, 2.0, 3.0]))
    };
    let error = |step: f64, end: f64| {
        let model = explicit(end, Some(step), vec![top.clone()], Vec::new());
        let mut notes = Notes::default();
        let (system, state) = run(&model, &mut notes);
        let [linear, angular] = lost(&notes);
        assert!(linear < 1e-12 && angular < 1e-10, "{linear} {angular}");
        assert!(notes.drift() < 1e-11 * notes.kinetic, "{}", notes.drift());
        (spin(&system, &state, 0) - Vec3::new(-3.8133094, 9.2443914, 2.2016985)).norm()
    };
    let [coarse, middle, fine] = [4e-3, 2e-3, 1e-3].map(|step| error(step, 1.0));
    println!("{coarse} {middle} {fine}");
    for ratio in [coarse / middle, middle / fine] {
        assert!((3.8..4.2).contains(&ratio), "{coarse} {middle} {fine}");
    }
    // Through many turns.
    error(4e-3, 80.0);
}

/// The heavy top of Géradin and Cardona: mass centre at 0.1 s by a Runge–Kutta method of order 8.
#[test]
fn a_heavy_top_is_of_second_order() {
    let top = heavy_top();
    let tip =
        PointJoint { name: "tip".into(), between: between("ground", "top"), at: [0.0; 3], second_at: None };
    let error = |step: f64| {
        let model = explicit(0.1, Some(step), vec![top.clone()], vec![Joint::Spherical(tip.clone())]);
        let model = Model { loads: gravity([0.0, 0.0, -9.81]), ..model };
        let mut notes = Notes::default();
        let (system, state) = run(&model, &mut notes);
        let (x, _) = pose(&system, &state, 0);
        // Gravity and the tip have no moment about the vertical.
        let first = notes.momenta[0].1.z;
        let vertical = max_norm(notes.momenta.iter().map(|m| m.1.z - first));
        assert!(vertical < 1e-10 * notes.momenta[0].1.norm(), "{vertical}");
        ((x - Vec3::new(0.42129666, 0.89457197, -0.14916470)).norm(), notes.drift() / notes.kinetic)
    };
    let [coarse, middle, fine] = [4e-4, 2e-4, 1e-4].map(error);
    println!("{coarse:?} {middle:?} {fine:?}");
    for ratio in [coarse.0 / middle.0, middle.0 / fine.0] {
        assert!((3.8..4.2).contains(&ratio), "{coarse:?} {middle:?} {fine:?}");
    }
    assert!(fine.0 < 1e-3, "{fine:?}");
}

/// The step that is found resolves the motion of a pendulum: balance and period over many swings, and round-off of the joint.
#[test]
fn bodies_without_springs_get_a_step_that_resolves_their_motion() {
    let model = pendulum(20.0, None);
    let (system, options) = (built(&model), options(&model));
    let mut notes = Notes::keeping();
    let outcome = dynamics::run(&system, options, None, &mut notes).unwrap();
    println!("{} steps, error {}", outcome.statistics.steps, outcome.statistics.energy_error);
    assert!(outcome.statistics.energy_error < 2e-3, "{:?}", outcome.statistics);
    assert!((1_000..20_000).contains(&outcome.statistics.steps), "{:?}", outcome.statistics);
    for state in &notes.states {
        let (x, _) = pose(&system, state, 0);
        assert!((x - exact(state.time)[0]).norm() < 0.05 * ARM, "{}: {x:?}", state.time);
    }
}

/// A strip with a hub at one end, on a hinge, and a lever on another hinge at its other end.
fn swing(elements: [u32; 2], scheme: Scheme, end: f64, time_step: Option<f64>) -> Model {
    let mut m = strip(ElementKind::Ems, elements, 0.0);
    m.bodies = vec![
        hub("hub", [0.0, 0.1, 0.0], &["u_min"]),
        RigidBody { attached: vec!["u_max".into()], ..body("tip", [1.0, 0.1, 0.0], 0.5, Some([2e-3; 3])) },
        body("lever", [1.2, 0.1, 0.0], 0.8, Some([4e-3, 8e-3, 8e-3])),
    ];
    m.joints = vec![
        revolute("hinge", "ground", "hub", [0.0, 0.1, 0.0], Y),
        revolute("elbow", "tip", "lever", [1.0, 0.1, 0.0], Y),
    ];
    m.loads = gravity([0.0, 0.0, -GRAVITY]);
    m.analysis = Analysis::Transient(TransientAnalysis { scheme, time_step, ..TransientAnalysis::new(end) });
    m
}

/// Shells, patches and joints move as with implicit steps; lumped masses make a difference that vanishes with the square of the element size.
#[test]
#[ignore = "long"]
fn a_strip_between_hinges_moves_as_with_implicit_steps() {
    let end = 0.4;
    let lever = |m: &Model| {
        let (system, outcome) = move_in_time(m, options(m), &mut Notes::default());
        println!("{} steps, {}", outcome.statistics.steps, outcome.statistics.energy_error);
        assert!(outcome.statistics.energy_error < 1e-3, "{:?}", outcome.statistics);
        pose(&system, &outcome.state, 2).0
    };
    let implicit = Scheme::EnergyMomentum(EnergyMomentumScheme { order: 4 });
    let difference = |elements: [u32; 2]| {
        let quick = lever(&swing(elements, Scheme::Explicit(ExplicitScheme::default()), end, None));
        let slow = lever(&swing(elements, implicit, end, Some(2e-3)));
        (quick - slow).norm()
    };
    let [coarse, middle, fine] = [[6, 1], [12, 2], [24, 4]].map(difference);
    println!("{coarse:?} {middle:?} {fine:?}");
    assert!(fine < 2e-3 && middle < 0.35 * coarse && fine < 0.35 * middle, "{coarse} {middle} {fine}");
}

/// A flying strip with a hinged body at each end: momenta to round-off, energy without drift.
fn flying(end: f64) -> Model {
    let mut m = strip(ElementKind::Ems, [8, 2], 0.1);
    let wing = |name: &str, x: f64, spin: f64| RigidBody {
        angular_velocity: [0.0, spin, 0.0],
        ..body(name, [x, 0.1, 0.0], 0.6, Some([3e-3, 6e-3, 6e-3]))
    };
    m.bodies = vec![
        hub("left", [0.0, 0.1, 0.0], &["u_min"]),
        hub("right", [1.0, 0.1, 0.0], &["u_max"]),
        wing("a", -0.2, 9.0),
        wing("b", 1.2, -6.0),
    ];
    m.joints = vec![
        revolute("left hinge", "left", "a", [0.0, 0.1, 0.0], Y),
        revolute("right hinge", "right", "b", [1.0, 0.1, 0.0], Y),
    ];
    m.conditions.clear();
    let scheme = Scheme::Explicit(ExplicitScheme::default());
    m.analysis = Analysis::Transient(TransientAnalysis { scheme, ..TransientAnalysis::new(end) });
    m
}

#[test]
fn a_flying_strip_with_hinged_bodies_keeps_momenta_and_energy() {
    let m = flying(3.0);
    let mut notes = Notes::default();
    let (_, outcome) = move_in_time(&m, options(&m), &mut notes);
    let [linear, angular] = lost(&notes);
    let scale = notes.momenta[0].1.norm();
    let error = outcome.statistics.energy_error;
    println!("{} steps: {linear:e} {angular:e} of {scale}, {error:e}", outcome.statistics.steps);
    assert!(linear < 1e-11 && angular < 1e-12, "{linear} {angular} {scale}");
    assert!(error < 1e-3, "{error}");
}

/// Results do not depend on the number of threads, and a run that is resumed in the middle ends like the whole run, bit for bit.
#[test]
fn results_repeat_to_the_bit() {
    let m = flying(0.1);
    let (system, options) = (built(&m), options(&m));
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut notes = Notes::keeping();
        let outcome = pool.install(|| dynamics::run(&system, options, None, &mut notes)).unwrap();
        (outcome.state, notes)
    };
    let ((one, notes), (two, _)) = (with(1), with(2));
    assert_eq!(one, two);
    let part = notes.states[notes.states.len() / 2].clone();
    assert!(part.step >= 50 && part.step < one.step, "{}", part.step);
    let rest = dynamics::run(&system, options, Some(part), &mut Silent).unwrap().state;
    assert_eq!(rest, one);
}

/// A plane four-bar linkage: three of its constraints are redundant, and joints are named.
#[test]
fn redundant_joints_are_named() {
    let link = |name: &str, at: [f64; 3]| body(name, at, 1.0, Some([0.01, 0.02, 0.02]));
    let bodies = vec![
        RigidBody { angular_velocity: [0.0, 1.0, 0.0], ..link("crank", [0.0, 0.0, 0.25]) },
        link("coupler", [0.5, 0.0, 0.5]),
        link("rocker", [1.0, 0.0, 0.25]),
    ];
    let joints = vec![
        revolute("A", "ground", "crank", [0.0; 3], Y),
        revolute("B", "crank", "coupler", [0.0, 0.0, 0.5], Y),
        revolute("C", "coupler", "rocker", [1.0, 0.0, 0.5], Y),
        revolute("D", "ground", "rocker", [1.0, 0.0, 0.0], Y),
    ];
    let mut notes = Notes::default();
    let model = explicit(0.2, None, bodies, joints);
    run(&model, &mut notes);
    let named: Vec<&String> =
        notes.events.iter().filter(|e| e.contains("follow from those of other")).collect();
    let count = |e: &String| e.split("\": ").nth(1)?.split(' ').next()?.parse::<u32>().ok();
    assert_eq!(named.iter().filter_map(|e| count(e)).sum::<u32>(), 3, "{:?}", notes.events);
    assert!(notes.drift() < 1e-3 * notes.kinetic, "{}", notes.drift());
}

/// An arm on a driven hinge with θ = a (1 − cos w t) in the field of gravity: moment `J θ″ + m g l cos θ`, and its work.
#[test]
fn a_drive_does_the_work_of_its_moment() {
    let (length, mass, inertia) = (0.7, 2.0, 0.1);
    let (amplitude, w, end) = (1.2_f64, 4.0_f64, 1.0);
    let errors = |steps: u32| {
        let arm = body("arm", [length, 0.0, 0.0], mass, Some([0.02, inertia, inertia]));
        let joints = vec![
            revolute("hinge", "ground", "arm", [0.0; 3], Y),
            Joint::DrivenAngle(DrivenAngleJoint {
                name: "drive".into(),
                between: between("ground", "arm"),
                axis: [0.0, -1.0, 0.0],
                angle: amplitude.to_degrees(),
                amplitude: "turn".into(),
            }),
        ];
        let model = explicit(end, Some(end / f64::from(steps)), vec![arm], joints);
        let mut model = Model { loads: gravity([0.0, 0.0, -GRAVITY]), ..model };
        let expression = format!("1 - cos({w}*t)");
        model.amplitudes.insert("turn".into(), Amplitude::Expression(ExpressionAmplitude { expression }));
        let mut notes = Notes::default();
        let (system, state) = run(&model, &mut notes);
        let [angle, rate, second] = [
            amplitude * (1.0 - (w * end).cos()),
            amplitude * w * (w * end).sin(),
            amplitude * w * w * (w * end).cos(),
        ];
        let whole = inertia + mass * length * length;
        let moment = -(whole * second + mass * GRAVITY * length * angle.cos());
        let (_, found) = joint_reaction(&system, &state, &system.joints[1]);
        let (x, _) = pose(&system, &state, 0);
        let place = Vec3::new(angle.cos(), 0.0, angle.sin()) * length;
        assert!((x - place).norm() < 1e-13, "{x:?} {place:?}");
        let work = 0.5 * whole * rate * rate + mass * GRAVITY * length * angle.sin();
        let energies = [(found.y - moment).abs() / moment.abs(), (state.work - work).abs() / work.abs()];
        (energies, notes.drift())
    };
    let [coarse, fine] = [500, 1000].map(errors);
    println!("{coarse:?} {fine:?}");
    // The velocity follows from the drive at once, and so does the moment.
    assert!(fine.0[0] < 1e-12, "{fine:?}");
    assert!((3.7..4.3).contains(&(coarse.0[1] / fine.0[1])) && fine.0[1] < 1e-4, "{coarse:?} {fine:?}");
}

/// Two bodies on a slide with a stiff spring: `ω² = k (1/m + 1/M)`, and the bound of the critical step is below 2/ω and not far below.
#[test]
fn stiff_springs_between_bodies_limit_the_step() {
    let (k, m, big) = (4e6, 1.0, 3.0);
    let bodies = vec![
        RigidBody { velocity: [0.1, 0.0, 0.0], ..body("a", [0.0; 3], m, Some([0.1; 3])) },
        body("b", [1.0, 0.0, 0.0], big, Some([0.1; 3])),
    ];
    let slide = |name: &str, of: &str, x: f64| {
        Joint::Prismatic(axis_joint(name, "ground", of, [x, 0.0, 0.0], [1.0, 0.0, 0.0]).into())
    };
    let mut model =
        explicit(0.05, None, bodies, vec![slide("slide a", "a", 0.0), slide("slide b", "b", 1.0)]);
    model.springs = vec![spring("spring", ["a", "b"], [[0.0; 3], [1.0, 0.0, 0.0]], k)];
    let critical = |model: &Model| {
        let (system, options) = (built(model), options(model));
        let outcome = dynamics::run(&system, options, None, &mut Notes::default()).unwrap();
        (outcome.statistics.critical_step, outcome)
    };
    let omega = (k * (1.0 / m + 1.0 / big)).sqrt();
    let (step, outcome) = critical(&model);
    println!("{step} of {}", 2.0 / omega);
    assert!(step <= 2.0 / omega && step > 1.8 / omega, "{step} {omega}");
    assert!(outcome.statistics.energy_error < 1e-6, "{:?}", outcome.statistics);
    // A damper: the force of a half step lags, and 2/(√(ω² + γ²/4) + γ/2) with γ = c (1/m + 1/M).
    model.springs[0].damping = 1e4;
    let gamma = 1e4 * (1.0 / m + 1.0 / big);
    let limit = 2.0 / ((omega * omega + 0.25 * gamma * gamma).sqrt() + 0.5 * gamma);
    if let Analysis::Transient(options) = &mut model.analysis {
        // What a lagging force dissipates is not resolved near the critical step.
        options.time_step = Some(0.02 * limit);
    }
    let (step, outcome) = critical(&model);
    println!("{step} of {limit}");
    assert!(step <= limit * 1.000_001 && step > 0.8 * limit, "{step} {limit}");
    let moved = (outcome.state.v[4][0] - 0.1 / 4.0).abs();
    assert!(moved < 1e-3, "{:?}", outcome.state.v);
}

/// A torsion spring between two discs on one axis, `ω² = k (1/J + 1/j)`.
#[test]
fn stiff_torsion_springs_limit_the_step() {
    let (k, j, big) = (9e3, 0.02, 0.05);
    let disc = |name: &str, moment: f64, spin: f64| RigidBody {
        angular_velocity: [0.0, 0.0, spin],
        ..body(name, [0.0; 3], 1.0, Some([0.06, 0.06, moment]))
    };
    let z = [0.0, 0.0, 1.0];
    let joints =
        vec![revolute("a", "ground", "one", [0.0; 3], z), revolute("b", "ground", "two", [0.0; 3], z)];
    let mut model = explicit(0.05, None, vec![disc("one", j, 1.0), disc("two", big, 0.0)], joints);
    model.torsion_springs = vec![TorsionSpring {
        name: "shaft".into(),
        between: between("one", "two"),
        axis: z,
        stiffness: k,
        damping: 0.0,
        moment: None,
        free_angle: 0.0,
    }];
    let outcome = dynamics::run(&built(&model), options(&model), None, &mut Notes::default()).unwrap();
    let (step, omega) = (outcome.statistics.critical_step, (k * (1.0 / j + 1.0 / big)).sqrt());
    println!("{step} of {}", 2.0 / omega);
    assert!(step <= 2.0 / omega && step > 1.5 / omega, "{step} {omega}");
    assert!(outcome.statistics.energy_error < 1e-5, "{:?}", outcome.statistics);
}

/// A pendulum that is held at rest by statics and its lock, then falls in explicit steps, then goes on in implicit ones.
#[test]
fn explicit_steps_follow_others_and_are_followed() {
    let model = pendulum(0.3, Some(1e-3));
    let quick = model.analysis.clone();
    let slow = machine(0.3, 1e-3, Vec::new(), Vec::new()).analysis;
    let rest = Analysis::Static(StaticAnalysis::default());
    let steps = vec![
        step("held", rest, &[], &["hinge"]),
        step("explicit", quick, &[], &[]),
        step("implicit", slow, &[], &[]),
    ];
    let done = step_joints::run(&Model { steps, ..model }).unwrap();
    for (i, time) in [(1, 0.3), (2, 0.6)] {
        let (x, _) = pose(&done[i].system, &done[i].state, 0);
        assert!((x - exact(time)[0]).norm() < 1e-5, "{i} {x:?} {:?}", exact(time)[0]);
    }
}

#[test]
fn what_explicit_steps_cannot_move_is_refused_with_a_remedy() {
    let refused = |change: &dyn Fn(&mut Model)| {
        let mut model = pendulum(0.1, None);
        change(&mut model);
        let mesh = mesh::generators::generate(&model.mesh).unwrap();
        compile::build(&model, &mesh).err().unwrap().to_string()
    };
    let friction = refused(&|model| {
        let Joint::Revolute(joint) = &mut model.joints[0] else { panic!() };
        joint.friction = Some(JointFriction { coefficient: 0.1, preload: 1.0, ..JointFriction::default() });
    });
    assert!(friction.contains("explicit steps do not compute the friction of joint \"hinge\""), "{friction}");
    let stops = refused(&|model| {
        let Joint::Revolute(joint) = &mut model.joints[0] else { panic!() };
        joint.stops = Some(JointStops { lower: Some(-1.0), upper: Some(1.0), restitution: 0.5 });
    });
    assert!(stops.contains("explicit steps do not compute the stops of joint \"hinge\""), "{stops}");
    let rod = refused(&|model| {
        model.bodies[0].inertia = Some([0.0, 0.1, 0.1]);
    });
    assert!(rod.contains("body \"bob\" has no moment of inertia about one of its axes"), "{rod}");
    for message in [friction, stops, rod] {
        assert!(message.contains("use `energy-momentum`"), "{message}");
    }
}

/// A triangular pulse of force between 1 and 1.2 s on a free mass, which nothing but the pulse limits the step of: the velocity 10 from
/// 1.2 s on, and the place `10·0.1 + 10·1.8` at 3 s.
#[test]
fn automatic_steps_resolve_a_pulse_on_a_free_mass() {
    let mut model = explicit(3.0, None, vec![body("m", [0.0; 3], 1.0, None)], Vec::new());
    let pulse = vec![0.0, 0.0, 100.0, 0.0, 0.0];
    let table = TableAmplitude { times: vec![0.0, 1.0, 1.1, 1.2, 5.0], values: pulse };
    model.amplitudes.insert("pulse".into(), Amplitude::Table(table));
    model.loads = vec![Load::Force(VectorLoad {
        on: "m".into(),
        value: [1.0, 0.0, 0.0],
        amplitude: Some("pulse".into()),
        distribution: None,
    })];
    let outcome = dynamics::run(&built(&model), options(&model), None, &mut Notes::default()).unwrap();
    assert!((outcome.state.u[0][0] - 19.0).abs() < 1e-3, "{:?}", outcome.state.u[0]);
    assert!((outcome.state.work / 50.0 - 1.0).abs() < 1e-3, "{}", outcome.state.work);
}

/// A body that a joint holds at rest under its weight has energies of round-off only, which violate no balance.
#[test]
fn a_body_at_rest_stays_at_rest() {
    let joint = Joint::Fixed(PointJoint {
        name: "wall".into(),
        between: between("ground", "b"),
        at: [0.0; 3],
        second_at: None,
    });
    let mut model =
        explicit(0.5, None, vec![body("b", [0.4, 0.1, 0.0], 1.7, Some([0.1, 0.2, 0.3]))], vec![joint]);
    model.loads = gravity([0.0, -9.81, 0.0]);
    let outcome = dynamics::run(&built(&model), options(&model), None, &mut Notes::default()).unwrap();
    assert!(outcome.state.u.iter().flatten().all(|x| x.abs() < 1e-12));
}

/// A load that jumps within a ten-millionth of the analysis acts as a jump: steps end at both of its ends, and are not shortened for it elsewhere.
#[test]
fn a_steep_ramp_of_a_load_acts_as_a_jump() {
    let mut model = explicit(1.0, None, vec![body("mass", [0.0; 3], 2.0, None)], Vec::new());
    let table = TableAmplitude { times: vec![0.0, 0.5, 0.5 + 1e-7, 1.0], values: vec![3.0, 3.0, -1.0, -1.0] };
    model.amplitudes.insert("jump".into(), Amplitude::Table(table));
    let load = VectorLoad { amplitude: Some("jump".into()), ..vector_load("mass", [1.0, 0.0, 0.0]) };
    model.loads = vec![Load::Force(load)];
    let outcome = dynamics::run(&built(&model), options(&model), None, &mut Notes::default()).unwrap();
    let [x, v] = [outcome.state.u[0][0], outcome.state.v[0][0]];
    assert!((x - 0.5).abs() < 1e-5 && (v - 0.5).abs() < 1e-5, "{x} {v}");
    assert!((outcome.state.work / 0.25 - 1.0).abs() < 1e-4, "{}", outcome.state.work);
    assert!(outcome.statistics.steps < 1_000, "{:?}", outcome.statistics);
}

/// A force that falls from 1 to −1 accelerates a mass and stops it again: its work vanishes at the first place where the balance is checked, and the
/// velocities of half steps do not. `x = t²/2 − 2 t³/3`.
#[test]
fn loads_that_have_taken_back_their_work_are_no_instability() {
    for dt in [0.05, 0.025, 0.0125] {
        let mut m = explicit(0.5, Some(dt), vec![body("mass", [0.0; 3], 1.0, None)], Vec::new());
        let table = TableAmplitude { times: vec![0.0, 0.5], values: vec![1.0, -1.0] };
        m.amplitudes.insert("turning".into(), Amplitude::Table(table));
        let load = VectorLoad { amplitude: Some("turning".into()), ..vector_load("mass", [1.0, 0.0, 0.0]) };
        m.loads = vec![Load::Force(load)];
        let (system, state) = run(&m, &mut Silent);
        let error = (pose(&system, &state, 0).0.x - 1.0 / 24.0).abs();
        assert!(error < 0.5 * dt * dt, "{dt}: {error:e}");
    }
}
