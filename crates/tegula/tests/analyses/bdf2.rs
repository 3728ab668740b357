//! The backward differentiation formula of second order: its recurrence on an oscillator, order with joints, settling, spin, jumps.

use crate::common::{Notes, distance, move_in_time};
use crate::composition::{errors_of_pendulum, hung, pendulum};
use crate::family_dynamics::soft_plate;
use crate::generalized_alpha::{heavy_top, ratios, with_scheme};
use crate::multibody::{between, body, machine, pose, revolute, run};
use tegula::Vec3;
use tegula::analysis::statics;
use tegula::model::*;
use tegula::norm::{larger, max_norm};
use tegula::result::{BodyMotion, joint_reaction};

const BDF2: Scheme = Scheme::Bdf2(Bdf2Scheme {});

/// The model with steps of this length, up to `end`.
fn stepped(model: &Model, end: f64, step: f64) -> Model {
    with_scheme(model, BDF2, end, step)
}

/// A point mass on a spring of no length: `ẍ = −ω² x` from x = 1 at rest.
fn oscillator(omega: f64) -> Model {
    let spring = SpringDamper {
        across: None,
        name: "spring".into(),
        between: between("ground", "mass"),
        points: [[0.0; 3], [1.0, 0.0, 0.0]],
        stiffness: omega * omega,
        damping: 0.0,
        length: Some(0.0),
        force: None,
    };
    Model {
        springs: vec![spring],
        ..machine(1.0, 0.1, vec![body("mass", [1.0, 0.0, 0.0], 1.0, None)], Vec::new())
    }
}

/// Positions and velocities of the formula itself, for steps that end at these times.
fn recurrence(omega: f64, times: &[f64]) -> Vec<[f64; 2]> {
    let (mut t, mut x) = (vec![0.0], vec![[1.0, 0.0]]);
    for &end in times {
        let n = x.len() - 1;
        let dt = end - t[n];
        // u₁ (1 + 2ω)/(1 + ω) − u₀ (1 + ω) + u₋₁ ω²/(1 + ω) = Δt u₁′
        let [c0, c1, c2] = if n == 0 {
            [1.0, 1.0, 0.0]
        } else {
            let r = dt / (t[n] - t[n - 1]);
            [(1.0 + 2.0 * r) / (1.0 + r), 1.0 + r, r * r / (1.0 + r)]
        };
        let before = if n == 0 { [0.0; 2] } else { x[n - 1] };
        let known: [f64; 2] = std::array::from_fn(|i| c1 * x[n][i] - c2 * before[i]);
        // c0 u − Δt v = known₀ and c0 v + Δt ω² u = known₁
        let det = c0 * c0 + dt * dt * omega * omega;
        let u = (c0 * known[0] + dt * known[1]) / det;
        let v = (c0 * known[1] - dt * omega * omega * known[0]) / det;
        x.push([u, v]);
        t.push(end);
    }
    x
}

/// Steps of a fifth of a radian and of a hundred radians, the first one by backward Euler; a stop makes two of them unequal.
#[test]
fn an_oscillator_follows_the_recurrence_of_the_formula() {
    for omega in [2.0, 1000.0] {
        let mut model = stepped(&oscillator(omega), 1.0, 0.1);
        model.output.at = vec![0.44];
        let mut notes = Notes::keeping();
        let (system, _) = run(&model, &mut notes);
        let times: Vec<f64> = notes.states[1..].iter().map(|s| s.time).collect();
        assert!(times.iter().any(|t| (t - 0.44).abs() < 1e-12), "{times:?}");
        let expected = recurrence(omega, &times);
        for (state, [x, v]) in notes.states.iter().zip(expected) {
            let motion = BodyMotion::new(&system, state, &system.coordinates.bodies[0]);
            assert!(
                (motion.position.x - x).abs() < 1e-10,
                "{omega} {}: {} {x}",
                state.time,
                motion.position.x
            );
            assert!(
                (motion.velocity.x - v).abs() < 1e-8,
                "{omega} {}: {} {v}",
                state.time,
                motion.velocity.x
            );
        }
    }
}

/// A vibration loses (Ω Δt)⁴/4 of its amplitude in each step, and ¾ (Ω Δt)² in the steps at the start.
#[test]
fn the_numerical_damping_is_that_of_the_characteristic_roots() {
    let angle = 0.05;
    let times: Vec<f64> = (1..=1000).map(|i| f64::from(i) * angle).collect();
    let size: Vec<f64> = recurrence(1.0, &times).iter().map(|[x, v]| x.hypot(*v)).collect();
    let a_step = (1.0 - size[1000] / size[500]) / 500.0;
    assert!((a_step / (0.25 * angle.powi(4)) - 1.0).abs() < 0.02, "{a_step}");
    let start = 1.0 - size[10];
    assert!((start / (0.75 * angle * angle) - 1.0).abs() < 0.02, "{start}");
}

/// Position, velocity and tension of the pendulum at 2 s: exact by elliptic functions (IFToMM benchmark A01).
#[test]
fn a_pendulum_converges_with_the_square_of_the_step_in_position_velocity_and_reaction() {
    let (place, turning) = (Vec3::new(-0.7935661953, -0.6084839304, 0.0), -3.4552068991);
    let errors = [1e-3, 5e-4, 2.5e-4].map(|step| {
        let found = run(&stepped(&pendulum(), 2.0, step), &mut Notes::default());
        errors_of_pendulum(&found, place, turning)
    });
    for i in 0..3 {
        let ratios = [errors[0][i] / errors[1][i], errors[1][i] / errors[2][i]];
        assert!(ratios.iter().all(|r| (3.7..4.3).contains(r)), "{i}: {ratios:?} {errors:?}");
    }
}

/// Geradin and Cardona's top on a ball joint, and a body on the corner of a shell with free and with inextensible directors.
#[test]
fn motions_with_joints_converge_with_the_square_of_the_step() {
    let shell = |element| {
        let mut model = hung();
        model.sections[0].element = element;
        model
    };
    for (model, end, steps) in [
        (heavy_top(), 0.04, 800),
        (shell(ElementKind::Ems), 0.256, 512),
        (shell(ElementKind::Mitc4), 0.256, 512),
    ] {
        let found = ratios(&model, BDF2, end, steps);
        println!("{found:?}");
        assert!(found.iter().all(|r| (3.6..4.4).contains(r)), "{found:?}");
    }
}

/// A plate that falls into its supports settles in the static equilibrium: automatic steps grow over its periods.
#[test]
fn a_plate_settles_in_its_equilibrium_under_gravity() {
    let model = soft_plate(ElementKind::Ems);
    let (_, system) = crate::common::compile(&model);
    let rest = statics::run(&system, &StaticAnalysis::default(), None, &mut Notes::default()).unwrap().state;
    let options = TransientAnalysis { scheme: BDF2, tolerance: 1e-2, ..TransientAnalysis::new(1000.0) };
    let mut notes = Notes::default();
    let (_, outcome) = move_in_time(&model, &options, &mut notes);
    let size = max_norm(rest.u.iter().flatten());
    let apart = distance(&outcome.state.u, &rest.u);
    assert!(size > 0.05 && apart < 1e-6 * size, "{apart} {size}");
    assert!(
        max_norm(outcome.state.v.iter().flatten()) < 1e-6 && outcome.statistics.steps < 400,
        "{}",
        outcome.statistics.steps
    );
}

/// A free ball keeps its spin within the damping of the scheme, without gain, and so does an arm on a hinge.
#[test]
fn bodies_that_turn_fast_gain_no_spin() {
    for (angle, least) in [(0.05, 0.99), (0.1, 0.96), (0.2, 0.75)] {
        let ball = RigidBody {
            angular_velocity: [0.0, 0.0, 100.0],
            ..body("ball", [0.0; 3], 1.0, Some([0.004; 3]))
        };
        let arm = RigidBody {
            angular_velocity: [0.0, 0.0, 100.0],
            velocity: [0.0, 50.0, 0.0],
            ..body("arm", [0.5, 0.0, 0.0], 1.0, Some([0.01, 0.02, 0.02]))
        };
        let hinge = revolute("hinge", "ground", "arm", [0.0; 3], [0.0, 0.0, 1.0]);
        for (body, joints) in [(ball, Vec::new()), (arm, vec![hinge])] {
            let model = machine(1.0, 0.1, vec![body], joints);
            let (system, state) = run(&stepped(&model, 5.0 * angle, angle / 100.0), &mut Notes::default());
            let spin = BodyMotion::new(&system, &state, &system.coordinates.bodies[0]).angular_velocity.z;
            println!("{angle}: {spin}");
            assert!(spin > 100.0 * least && spin < 100.0 * (1.0 + 1e-9), "{angle}: {spin}");
        }
    }
}

/// A drive that sets off and stops at once, in a ramp: the arm goes on at its speed behind the kink, not with a mean of both speeds.
#[test]
fn a_jump_of_the_velocity_starts_the_formula_anew() {
    let arm = body("arm", [0.5, 0.0, 0.0], 1.0, Some([0.1; 3]));
    let drive = Joint::DrivenAngle(DrivenAngleJoint {
        name: "drive".into(),
        between: between("ground", "arm"),
        axis: [0.0, 0.0, 1.0],
        angle: 1.0,
        amplitude: "turn".into(),
    });
    let joints = vec![revolute("hinge", "ground", "arm", [0.0; 3], [0.0, 0.0, 1.0]), drive];
    let mut model = machine(1.0, 0.05, vec![arm], joints);
    let (times, values) = (vec![0.0, 0.3, 0.6, 1.0], vec![0.0, 0.0, 90.0, 90.0]);
    model.amplitudes.insert("turn".into(), Amplitude::Table(TableAmplitude { times, values }));
    let mut notes = Notes::keeping();
    let (system, _) = run(&stepped(&model, 1.0, 0.05), &mut notes);
    for state in &notes.states {
        let motion = BodyMotion::new(&system, state, &system.coordinates.bodies[0]);
        let moves = state.time > 0.3 - 1e-9 && state.time < 0.6 - 1e-9;
        let speed = if moves { 0.5 * std::f64::consts::PI / 0.3 } else { 0.0 };
        assert!(
            (motion.angular_velocity.z - speed).abs() < 1e-9,
            "{}: {}",
            state.time,
            motion.angular_velocity.z
        );
        let (_, moment) = joint_reaction(&system, state, &system.joints[1]);
        let still = state.time < 0.29 || state.time > 0.61;
        assert!(!still || moment.norm() < 1e-8, "{}: {moment}", state.time);
        let (place, _) = pose(&system, state, 0);
        assert!((place.norm() - 0.5).abs() < 1e-12);
    }
}

/// An arm on a hinge, of 2 kg 0.5 m from it, which a drive turns at this rate [rad/s] from the start on.
fn driven_arm(rate: f64) -> Model {
    let arm = RigidBody {
        angular_velocity: [0.0, 0.0, rate],
        velocity: [0.0, 0.5 * rate, 0.0],
        ..body("arm", [0.5, 0.0, 0.0], 2.0, Some([0.1; 3]))
    };
    let drive = Joint::DrivenAngle(DrivenAngleJoint {
        name: "drive".into(),
        between: between("ground", "arm"),
        axis: [0.0, 0.0, 1.0],
        angle: rate.to_degrees(),
        amplitude: "turn".into(),
    });
    let joints = vec![revolute("hinge", "ground", "arm", [0.0; 3], [0.0, 0.0, 1.0]), drive];
    let mut model = machine(1.0, 0.05, vec![arm], joints);
    let (times, values) = (vec![0.0, 100.0], vec![0.0, 100.0]);
    model.amplitudes.insert("turn".into(), Amplitude::Table(TableAmplitude { times, values }));
    model
}

/// The centripetal force m r ω² from the first step on: its error falls with the step. The drive of a motion that is steady does no work.
#[test]
fn reactions_from_the_start_in_motion_on_are_those_of_the_motion() {
    let errors = [0.01, 0.005, 0.0025].map(|angle| {
        let mut notes = Notes::keeping();
        let (system, state) = run(&stepped(&driven_arm(10.0), 0.05, angle / 10.0), &mut notes);
        let off = |state: &_| {
            let (force, moment) = joint_reaction(&system, state, &system.joints[0]);
            let (_, drive) = joint_reaction(&system, state, &system.joints[1]);
            let expected = 2.0 * 0.5 * 100.0;
            larger((force.norm() - expected).abs(), larger(moment.norm(), drive.norm())) / expected
        };
        assert!(state.work.abs() < 1e-3 * 30.0, "{}", state.work);
        notes.states.iter().map(off).fold(0.0, larger)
    });
    println!("{errors:?}");
    assert!(errors[0] < 0.02, "{errors:?}");
    assert!(errors.windows(2).all(|pair| pair[0] / pair[1] > 1.9), "{errors:?}");
}

/// Behind a jump of the rate, too, the first steps have the centripetal force, up to an error that falls with the step.
#[test]
fn reactions_behind_a_jump_of_the_rate_are_those_of_the_motion() {
    let errors = [0.02, 0.01, 0.005].map(|angle| {
        let mut model = driven_arm(1.0);
        model.bodies[0].velocity = [0.0; 3];
        model.bodies[0].angular_velocity = [0.0; 3];
        let (times, values) = (vec![0.0, 0.1, 100.1], vec![0.0, 0.0, 100.0]);
        model.amplitudes.insert("turn".into(), Amplitude::Table(TableAmplitude { times, values }));
        let mut notes = Notes::keeping();
        let (system, _) = run(&stepped(&model, 0.3, angle), &mut notes);
        let behind = notes.states.iter().filter(|state| state.time > 0.1 + 1e-9);
        let off = |state: &_| (joint_reaction(&system, state, &system.joints[0]).0.norm() - 1.0).abs();
        behind.map(off).fold(0.0, larger)
    });
    println!("{errors:?}");
    assert!(errors[0] < 0.05, "{errors:?}");
    assert!(errors.windows(2).all(|pair| pair[0] / pair[1] > 1.9), "{errors:?}");
}

/// A drive whose rate jumps does the work of the impulse at once, and the velocities before it belong to the rate before.
#[test]
fn a_jump_of_the_rate_of_a_drive_does_the_work_of_its_impulse() {
    let generalized = Scheme::GeneralizedAlpha(GeneralizedAlphaScheme { spectral_radius: 0.8 });
    for scheme in [BDF2, generalized] {
        let mut model = driven_arm(1.0);
        let (times, values) = (vec![0.0, 0.1003, 100.1003], vec![0.0, 0.1003, 200.1003]);
        model.amplitudes.insert("turn".into(), Amplitude::Table(TableAmplitude { times, values }));
        let mut notes = Notes::keeping();
        let (system, _) = run(&with_scheme(&model, scheme, 0.2, 1e-3), &mut notes);
        for state in notes.states.iter().filter(|state| (state.time - 0.1003).abs() > 1e-9) {
            let exact = if state.time < 0.1003 { 1.0 } else { 4.0 };
            let force = joint_reaction(&system, state, &system.joints[0]).0.norm();
            assert!((force / exact - 1.0).abs() < 0.02, "{scheme:?} {}: {force}", state.time);
        }
        // ½ (0.1 + 2·0.5²) ω² with ω from 1 to 2 rad/s.
        let work = notes.states.last().unwrap().work;
        assert!((work - 0.3 * 3.0).abs() < 2e-3, "{scheme:?}: {work}");
        assert!(notes.events.is_empty(), "{scheme:?}: {:?}", notes.events);
    }
}

/// A body on a hinge under a moment about its axis that jumps: the bearing at a distance from the mass centre takes the tangential force
/// m r M/J at once, whatever the step.
#[test]
fn a_jump_of_a_load_is_in_the_reactions_behind_it() {
    for (step, gap) in [(5e-3, 1e-9), (2.5e-3, 1e-9), (5e-3, 1e-5)] {
        let arm = body("arm", [0.5, 0.0, 0.0], 2.0, Some([0.1, 0.1, 0.1]));
        let hinge = revolute("hinge", "ground", "arm", [0.0; 3], [0.0, 0.0, 1.0]);
        let mut model = machine(0.03, step, vec![arm], vec![hinge]);
        let (times, values) = (vec![0.0, 0.0101, 0.0101 + gap, 1.0], vec![0.0, 0.0, 1.0, 1.0]);
        model.amplitudes.insert("jump".into(), Amplitude::Table(TableAmplitude { times, values }));
        let value = [0.0, 0.0, 3.0];
        let amplitude = Some("jump".into());
        model.loads =
            vec![Load::Moment(VectorLoad { on: "arm".into(), value, amplitude, distribution: None })];
        let mut notes = Notes::keeping();
        let (system, _) = run(&stepped(&model, 0.03, step), &mut notes);
        let force = 2.0 * 0.5 * 3.0 / (0.1 + 2.0 * 0.25);
        for state in &notes.states {
            let exact = if state.time < 0.0101 + 0.5 * gap { 0.0 } else { force };
            let found = joint_reaction(&system, state, &system.joints[0]).0.norm();
            assert!((found - exact).abs() < 1e-2 * force, "{step} {gap} {}: {found} {exact}", state.time);
        }
    }
}

/// An output time that cuts a step short leaves no trace in reactions and drives, however short the step is.
#[test]
fn a_step_that_is_cut_short_does_not_spoil_the_reactions() {
    for cut in [1e-5, 1e-3, 4e-3] {
        let mut model = stepped(&driven_arm(3.0), 0.3, 5e-3);
        model.output.at = vec![0.2 + cut];
        let mut notes = Notes::keeping();
        let (system, _) = run(&model, &mut notes);
        for state in notes.states.iter().filter(|state| state.time > 0.1) {
            let (force, _) = joint_reaction(&system, state, &system.joints[0]);
            let (_, drive) = joint_reaction(&system, state, &system.joints[1]);
            let (off, moment) = ((force.norm() / 9.0 - 1.0).abs(), drive.norm() / 9.0);
            assert!(off < 2e-3 && moment < 1e-2, "{cut} {}: {off} {moment}", state.time);
        }
    }
}

/// Steps of a twentieth of a radian are taken in silence, steps of a seventh with a message.
#[test]
fn steps_too_long_for_a_drive_are_told() {
    for (angle, steps, told) in [(0.05, 40.0, false), (0.15, 40.0, true), (0.15, 10.0, true)] {
        let mut notes = Notes::default();
        run(&stepped(&driven_arm(1.0), steps * angle, angle), &mut notes);
        let found = notes.events.iter().any(|event| event.contains("the steps are long for this motion"));
        assert_eq!(found, told, "{angle}: {:?}", notes.events);
    }
}

/// A free mass ends with the impulse of a pulse, whatever its shape and however short it is beside the step: of a triangle, of a rectangle, of
/// a saw tooth, and of one that lasts for several steps; also beside a joint.
#[test]
fn a_free_mass_keeps_the_impulse_of_a_pulse() {
    const JUMP: f64 = 1e-9;
    for (points, impulse) in [
        (vec![[0.5, 0.0], [0.501, 1.0], [0.502, 0.0]], 0.001),
        (vec![[0.51, 0.0], [0.51 + JUMP, 1.0], [0.514, 1.0], [0.514 + JUMP, 0.0]], 0.004),
        (vec![[0.5, 0.0], [0.52, 1.0], [0.52 + JUMP, 0.0]], 0.01),
        (vec![[0.2, 0.0], [0.27, 1.0], [0.61, 1.0], [0.66, -1.0], [0.7, 0.0]], 0.035 + 0.34 - 0.02),
    ] {
        for (time_step, constrained) in [(Some(0.05), false), (None, false), (Some(0.05), true), (None, true)]
        {
            let mut bodies = vec![body("mass", [0.0; 3], 2.0, None)];
            // With a joint anywhere the formula starts anew in another way.
            let joints = match constrained {
                true => vec![revolute("hinge", "ground", "arm", [0.0; 3], [0.0, 0.0, 1.0])],
                false => Vec::new(),
            };
            bodies.extend(constrained.then(|| body("arm", [0.1, 0.0, 0.0], 1.0, Some([1.0; 3]))));
            let mut model = stepped(&machine(1.0, 0.05, bodies, joints), 1.0, 0.05);
            let Analysis::Transient(options) = &mut model.analysis else { panic!() };
            options.time_step = time_step;
            let (times, values) = points.iter().map(|[t, f]| (*t, *f)).unzip();
            model.amplitudes.insert("pulse".into(), Amplitude::Table(TableAmplitude { times, values }));
            let load = GravityLoad { value: [100.0, 0.0, 0.0], amplitude: Some("pulse".into()) };
            model.loads = vec![Load::Gravity(load)];
            let (system, state) = run(&model, &mut Notes::default());
            let speed = BodyMotion::new(&system, &state, &system.coordinates.bodies[0]).velocity.x;
            let off = (speed / (100.0 * impulse) - 1.0).abs();
            assert!(off < 1e-6, "{points:?} {time_step:?}: {speed} {impulse}");
        }
    }
}

/// Steps that end at kinks of a load are cut to halves, and the next one is twice as long up to round-off of the times, which differs
/// between units of time: whether the formula continues must not.
#[test]
fn steps_that_grow_to_twice_their_length_continue_in_all_units_of_time() {
    let swing = |unit: f64| {
        let mut model = stepped(&pendulum(), 0.4 * unit, 0.002 * unit);
        let kinks: Vec<f64> = (0..10).map(|i| 0.007 + 0.034 * f64::from(i)).collect();
        let values: Vec<f64> = (0..10).map(|i| 1.0 + 0.1 * f64::from(i % 2)).collect();
        let times = kinks.iter().map(|time| time * unit).collect();
        model.amplitudes.insert("kinks".into(), Amplitude::Table(TableAmplitude { times, values }));
        let Load::Gravity(weight) = &mut model.loads[0] else { panic!() };
        weight.amplitude = Some("kinks".into());
        weight.value = weight.value.map(|g| g / (unit * unit));
        let (system, state) = run(&model, &mut Notes::default());
        BodyMotion::new(&system, &state, &system.coordinates.bodies[0]).position
    };
    let seconds = swing(1.0);
    for unit in [1e3, 1e-3, 60.0] {
        let distance = (swing(unit) - seconds).norm();
        assert!(distance < 1e-11, "{unit}: {distance}");
    }
}

/// A wheel that spins freely loses a fifth of its spin in 50 rad of a quarter each, and nothing to speak of in shorter steps: what numerical damping takes of the
/// energy is told.
#[test]
fn energy_that_numerical_damping_takes_is_told() {
    let told = |scheme: Scheme, step: f64| {
        let mut wheel = body("wheel", [0.0; 3], 1.0, Some([0.1; 3]));
        wheel.angular_velocity = [0.0, 0.0, 25.0];
        let hinge = revolute("hinge", "ground", "wheel", [0.0; 3], [0.0, 0.0, 1.0]);
        let m = with_scheme(&machine(1.0, 0.1, vec![wheel], vec![hinge]), scheme, 2.0, step);
        let mut notes = Notes::default();
        run(&m, &mut notes);
        notes.warnings.iter().any(|text| text.contains("numerical damping has taken"))
    };
    let generalized = |spectral_radius| Scheme::GeneralizedAlpha(GeneralizedAlphaScheme { spectral_radius });
    let conserving = Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 });
    for (scheme, step, is_told) in [
        (BDF2, 0.01, true),
        (BDF2, 0.002, false),
        (generalized(0.0), 0.01, true),
        (generalized(0.9), 0.01, false),
        (conserving, 0.01, false),
    ] {
        assert_eq!(told(scheme, step), is_told, "{scheme:?} {step}");
    }
}
