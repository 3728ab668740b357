//! The generalised-α method: second order in positions, velocities and multipliers with joints, its recurrence and damping on an
//! oscillator, automatic steps, refusals.

use crate::common::{Notes, distance};
use crate::composition::{errors_of_pendulum, hung, pendulum};
use crate::family_dynamics::soft_plate;
use crate::multibody::{body, gravity, machine, pose, revolute, run, spherical};
use tegula::Vec3;
use tegula::analysis::State;
use tegula::model::*;
use tegula::norm::{larger, max_norm};
use tegula::result::{BodyMotion, joint_reaction};
use tegula::{compile, mesh};

fn scheme(spectral_radius: f64) -> Scheme {
    Scheme::GeneralizedAlpha(GeneralizedAlphaScheme { spectral_radius })
}

/// The model with steps of this length, up to `end`.
fn stepped(model: &Model, rho: f64, end: f64, step: f64) -> Model {
    with_scheme(model, scheme(rho), end, step)
}

/// The model by a scheme with steps of this length, up to `end`.
pub fn with_scheme(model: &Model, scheme: Scheme, end: f64, step: f64) -> Model {
    let options = TransientAnalysis { scheme, time_step: Some(step), ..TransientAnalysis::new(end) };
    Model { analysis: Analysis::Transient(options), ..model.clone() }
}

/// Position, velocity and tension of the pendulum at 2 s: exact by elliptic functions (IFToMM benchmark A01).
#[test]
fn a_pendulum_converges_with_the_square_of_the_step_in_position_velocity_and_reaction() {
    let (place, turning) = (Vec3::new(-0.7935661953, -0.6084839304, 0.0), -3.4552068991);
    for rho in [0.0, 0.5, 0.8, 0.95, 1.0] {
        let errors = |step: f64| {
            let found = run(&stepped(&pendulum(), rho, 2.0, step), &mut Notes::default());
            errors_of_pendulum(&found, place, turning)
        };
        let errors = [2e-3, 1e-3, 5e-4].map(errors);
        for i in 0..3 {
            let ratios = [errors[0][i] / errors[1][i], errors[1][i] / errors[2][i]];
            println!("{rho} {i}: {ratios:?}");
            assert!(ratios.iter().all(|r| (3.7..4.3).contains(r)), "{rho} {i}: {ratios:?} {errors:?}");
        }
    }
}

/// The multipliers are of second order from the first step on, not only after a while.
#[test]
fn reactions_are_of_second_order_at_the_start() {
    let error = |step: f64| {
        let mut notes = Notes::keeping();
        let (system, _) = run(&stepped(&pendulum(), 0.8, 0.1, step), &mut notes);
        let centre = system.coordinates.bodies[0].centre as usize;
        notes.states[1..]
            .iter()
            .map(|state| {
                // With the exact motion v² = −2 g y, up to the error of y.
                let y = pose(&system, state, 0).0.y;
                assert!(state.v[centre][1] < 0.0);
                (joint_reaction(&system, state, &system.joints[0]).0.norm() + 3.0 * 9.81 * y).abs()
            })
            .fold(0.0, larger)
    };
    let errors = [4e-3, 2e-3, 1e-3].map(error);
    println!("{errors:?}");
    assert!(errors[0] / errors[1] > 3.6 && errors[1] / errors[2] > 3.6, "{errors:?}");
}

/// Positions, velocities and multipliers of successively halved steps: ratios of their differences.
pub fn ratios(model: &Model, scheme: Scheme, end: f64, steps: u32) -> [f64; 3] {
    let states = [0, 1, 2]
        .map(|k| run(&with_scheme(model, scheme, end, end / f64::from(steps << k)), &mut Notes::default()).1);
    let apart = |i: usize| {
        let (a, b) = (&states[i], &states[i + 1]);
        let force = max_norm(a.multipliers.iter().zip(&b.multipliers).map(|(x, y)| x - y));
        [distance(&a.u, &b.u), distance(&a.v, &b.v), force]
    };
    let (coarse, fine) = (apart(0), apart(1));
    std::array::from_fn(|i| coarse[i] / fine[i])
}

/// Geradin and Cardona's top on a ball joint.
pub fn heavy_top() -> Model {
    let omega = [0.0, 150.0, -4.61538];
    let top = RigidBody {
        angular_velocity: omega,
        velocity: Vec3::from(omega).cross(&Vec3::y()).into(),
        ..body("top", [0.0, 1.0, 0.0], 15.0, Some([0.234375, 0.46875, 0.234375]))
    };
    let model = machine(0.1, 1e-4, vec![top], vec![spherical("ground", "top", [0.0; 3])]);
    Model { loads: gravity([0.0, 0.0, -9.81]), ..model }
}

#[test]
fn a_heavy_top_converges_with_the_square_of_the_step() {
    let model = heavy_top();
    for rho in [0.8, 1.0] {
        let found = ratios(&model, scheme(rho), 0.04, 800);
        println!("{found:?}");
        assert!(found.iter().all(|r| (3.7..4.3).contains(r)), "{rho}: {found:?}");
    }
}

/// A body with three unlike moments of inertia on the corner of a shell, which has inextensible directors or not, and damping.
#[test]
fn a_body_on_a_shell_converges_with_the_square_of_the_step() {
    for (element, stiffness) in [(ElementKind::Ems, 0.0), (ElementKind::Mitc4, 0.0), (ElementKind::Ems, 2e-3)]
    {
        let mut model = hung();
        model.sections[0].element = element;
        model.damping = Damping { mass: 0.0, stiffness };
        for rho in [0.8, 1.0] {
            let found = ratios(&model, scheme(rho), 0.256, 256);
            println!("{element:?} {found:?}");
            assert!(found.iter().all(|r| (3.7..4.3).contains(r)), "{element:?} {rho}: {found:?}");
        }
    }
}

/// The trapezoidal rule damps nothing; with velocities on the constraints the ripple of the reactions of a body on a shell does not grow.
#[test]
fn reactions_of_the_trapezoidal_rule_do_not_grow() {
    let mut notes = Notes::keeping();
    run(&stepped(&hung(), 1.0, 8.0, 4e-3), &mut notes);
    let ripple = |states: &[State]| {
        let second =
            |w: &[State], i: usize| w[0].multipliers[i] - 2.0 * w[1].multipliers[i] + w[2].multipliers[i];
        max_norm(states.windows(3).flat_map(|w| (0..w[0].multipliers.len()).map(move |i| second(w, i))))
    };
    let parts: Vec<f64> = notes.states[1..].chunks(400).map(ripple).collect();
    assert!(parts.len() == 5 && parts[4] < 2.0 * larger(parts[0], parts[1]), "{parts:?}");
}

/// Automatic steps go through the motion of a pendulum near the tolerance; what is lost of the energy is small.
#[test]
fn automatic_steps_resolve_a_pendulum() {
    let options = TransientAnalysis { scheme: scheme(0.8), tolerance: 1e-7, ..TransientAnalysis::new(2.0) };
    let model = Model { analysis: Analysis::Transient(options), ..pendulum() };
    let mut notes = Notes::default();
    let (system, state) = run(&model, &mut notes);
    let place = Vec3::new(-0.7935661953, -0.6084839304, 0.0);
    let error = (pose(&system, &state, 0).0 - place).norm();
    println!("{error} {} {}", state.step, notes.drift());
    assert!(error < 1e-3 && notes.drift() < 1e-3 * notes.kinetic, "{error} {}", notes.drift());
    assert!(state.step < 1000 && notes.events.len() < 20, "{} {:?}", state.step, notes.events);
}

/// A point mass between a spring with a damper and the ground: x = e^(−ξωt) v₀ sin(ω_d t)/ω_d along its line.
#[test]
fn a_damped_spring_follows_its_closed_form() {
    let (mass, omega, xi) = (2.0, 5.0_f64, 0.2);
    let speed = RigidBody { velocity: [0.5, 0.0, 0.0], ..body("mass", [1.0, 0.0, 0.0], mass, None) };
    let spring = SpringDamper {
        across: None,
        name: "spring".into(),
        between: ["ground".into(), "mass".into()],
        points: [[0.0; 3], [1.0, 0.0, 0.0]],
        stiffness: mass * omega * omega,
        damping: 2.0 * xi * omega * mass,
        force: None,
        length: None,
    };
    let model = Model { springs: vec![spring], ..machine(1.0, 1e-3, vec![speed], Vec::new()) };
    let damped = omega * (1.0 - xi * xi).sqrt();
    let exact = 0.5 * (-xi * omega).exp() * damped.sin() / damped;
    let error = |step: f64| {
        let mut notes = Notes::default();
        let (system, state) = run(&stepped(&model, 0.8, 1.0, step), &mut notes);
        assert!(notes.events.is_empty() && notes.drift() < 1e-2 * notes.kinetic, "{:?}", notes.events);
        (pose(&system, &state, 0).0.x - 1.0 - exact).abs()
    };
    let errors = [1e-2, 5e-3].map(error);
    let ratio = errors[0] / errors[1];
    assert!(errors[0] < 1e-3 && (3.7..4.3).contains(&ratio), "{errors:?}");
}

#[test]
fn a_scheme_that_does_not_project_velocities_is_refused_with_joints() {
    let refused = |scheme: Scheme| {
        let options = TransientAnalysis { scheme, ..TransientAnalysis::new(1.0) };
        let model = Model { analysis: Analysis::Transient(options), ..pendulum() };
        let mesh = mesh::generators::generate(&model.mesh).unwrap();
        compile::build(&model, &mesh).err().expect("the model is wrong").to_string()
    };
    assert!(refused(Scheme::default()).contains("generalized-alpha"));
    assert!(refused(scheme(-0.1)).contains("0…1"));
    let shell = stepped(&soft_plate(ElementKind::Mitc4), 1.0, 0.1, 1e-2);
    let mut notes = Notes::default();
    run(&shell, &mut notes);
    assert_eq!(notes.totals.len(), 11);
}

/// A sudden load on a cantilever with strong damping: what is dissipated in the first steps exceeds the energy, and no joint is near
/// a singular position.
#[test]
fn a_strongly_damped_beam_starts_under_a_sudden_load() {
    let steel = Isotropic { young: 2.1e11, poisson: 0.3, density: 7850.0, expansion: 0.0, strength: None };
    let section = BeamSection::Rectangle(RectangularSection { size: [0.02; 2] });
    let beam = Beam {
        material: Some("steel".into()),
        ..Beam::straight("rod", [[0.0; 3], [1.0, 0.0, 0.0]], 20, [0.0, 1.0, 0.0], section)
    };
    let clamp = PointJoint {
        name: "clamp".into(),
        between: ["ground".into(), "rod.start".into()],
        at: [0.0; 3],
        second_at: None,
    };
    for time_step in [None, Some(1e-3)] {
        let scheme = Scheme::GeneralizedAlpha(GeneralizedAlphaScheme::default());
        let options = TransientAnalysis { scheme, time_step, ..TransientAnalysis::new(0.3) };
        let mut model =
            Model::of_bodies(Analysis::Transient(options), Vec::new(), vec![Joint::Fixed(clamp.clone())]);
        model.materials.insert("steel".into(), Material::Isotropic(steel.clone()));
        model.beams = vec![beam.clone()];
        model.damping.stiffness = 0.01;
        let value = [0.0, 0.0, 5.0];
        model.loads = vec![Load::Force(VectorLoad {
            on: "rod.end".into(),
            value,
            amplitude: None,
            distribution: None,
        })];
        let (system, state) = run(&model, &mut Notes::default());
        let end = system.coordinates.bodies.last().unwrap().centre as usize;
        // F L³/3EI, to which the damped vibration has come close.
        let expected = 5.0 / (3.0 * 2.1e11 * 0.02_f64.powi(4) / 12.0);
        assert!((state.u[end][2] / expected - 1.0).abs() < 0.05, "{:?} {expected}", state.u[end]);
    }
}

/// A free ball keeps its spin within the damping of the scheme, which is of second order in the angle of a step, for all ρ: velocities
/// across the directors must not come back as spin.
#[test]
fn a_body_that_turns_by_a_fifth_of_a_radian_in_a_step_gains_no_spin() {
    for (rho, least) in [(0.0, 0.7), (0.5, 0.96), (0.8, 0.99), (0.9, 0.999), (0.95, 0.999), (1.0, 0.9999)] {
        for angle in [0.05, 0.1, 0.2] {
            let ball = RigidBody {
                angular_velocity: [0.0, 0.0, 100.0],
                ..body("ball", [0.0; 3], 1.0, Some([0.004; 3]))
            };
            let mut model = machine(5.0 * angle, angle / 100.0, vec![ball], Vec::new());
            let Analysis::Transient(options) = &mut model.analysis else { panic!("no motion") };
            options.scheme = scheme(rho);
            let (system, state) = run(&model, &mut Notes::default());
            let spin = BodyMotion::new(&system, &state, &system.coordinates.bodies[0]).angular_velocity.z;
            assert!(spin > 100.0 * least && spin < 100.0 * (1.0 + 1e-9), "{rho} {angle}: {spin}");
        }
    }
}

/// Spin off the axis of a body, on a hinge: joints hold positions, and the velocities are projected onto them.
#[test]
fn a_body_on_a_hinge_that_turns_fast_gains_no_spin() {
    for (rho, least) in [(0.0, 0.7), (0.5, 0.96), (0.8, 0.99), (0.9, 0.999), (1.0, 0.9999)] {
        let arm = RigidBody {
            angular_velocity: [0.0, 0.0, 100.0],
            velocity: [0.0, 50.0, 0.0],
            ..body("arm", [0.5, 0.0, 0.0], 1.0, Some([0.01, 0.02, 0.02]))
        };
        let hinge = revolute("hinge", "ground", "arm", [0.0; 3], [0.0, 0.0, 1.0]);
        let mut model = machine(1.0, 2e-3, vec![arm], vec![hinge]);
        let Analysis::Transient(options) = &mut model.analysis else { panic!("no motion") };
        options.scheme = scheme(rho);
        let (system, state) = run(&model, &mut Notes::default());
        let spin = BodyMotion::new(&system, &state, &system.coordinates.bodies[0]).angular_velocity.z;
        assert!(spin > 100.0 * least && spin < 100.0 * (1.0 + 1e-9), "{rho}: {spin}");
    }
}

/// A free plate that turns about an axis in its plane keeps its energy within the damping of the scheme in short steps. In long ones the
/// scheme may feed energy into it, which is told.
#[test]
fn a_plate_that_turns_fast_keeps_its_energy_or_the_gain_is_told() {
    for element in [ElementKind::Ems, ElementKind::Mitc4] {
        for (rho, angle) in [(0.5, 0.02), (0.8, 0.02), (0.8, 0.1), (0.9, 0.1), (0.95, 0.1), (1.0, 0.02)] {
            let mut model = crate::common::model(crate::common::plate([1.0, 0.6], [3, 2], 0.0), 2.1e11, 0.02);
            model.materials.insert("m".into(), Material::Isotropic(Isotropic::new(2.1e11, 0.3, 7850.0)));
            model.sections[0].element = element;
            model.conditions.clear();
            model.initial_velocities = vec![InitialVelocity {
                on: "all".into(),
                velocity: [0.0; 3],
                angular_velocity: [0.0, 10.0, 0.0],
                center: [0.5, 0.3, 0.0],
            }];
            let options = TransientAnalysis {
                scheme: scheme(rho),
                time_step: Some(0.1 * angle),
                ..TransientAnalysis::new(30.0 * angle)
            };
            model.analysis = Analysis::Transient(options.clone());
            let mut notes = Notes::default();
            crate::common::move_in_time(&model, &options, &mut notes);
            let (first, last) = (notes.totals[0].1, notes.totals[notes.totals.len() - 1].1);
            let told = notes.events.iter().any(|event| event.contains("has gained"));
            println!("{element:?} {rho} {angle}: {first} {last} {told}");
            let kept = last > 0.98 * first && last < 1.05 * first;
            assert!(told || kept, "{element:?} {rho} {angle}: {first} {last}");
            assert!(angle > 0.05 || !told, "{element:?} {rho} {angle}: {first} {last}");
        }
    }
}

/// A load that jumps within a tiny step leaves the constant steps behind it as they would be after a jump: a strip under a sudden edge
/// load swings as with Newmark's method.
#[test]
fn a_jump_of_a_load_is_not_carried_into_longer_steps() {
    let largest = |scheme: Scheme, gap: f64| {
        let mut model = crate::common::model(crate::common::plate([1.0, 0.1], [8, 1], 0.0), 1e9, 0.01);
        model.materials.insert("m".into(), Material::Isotropic(Isotropic::new(1e9, 0.0, 2000.0)));
        let mut load = crate::common::vector_load("u_max", [0.0, 0.0, 10.0]);
        load.amplitude = Some("a".into());
        model.loads = vec![Load::Edge(load)];
        let table =
            TableAmplitude { times: vec![0.0, 0.5, 0.5 + gap, 1.0], values: vec![0.0, 0.0, 1.0, 1.0] };
        model.amplitudes.insert("a".into(), Amplitude::Table(table));
        let options = TransientAnalysis { scheme, time_step: Some(1e-2), ..TransientAnalysis::new(1.0) };
        model.analysis = Analysis::Transient(options.clone());
        let mut notes = Notes::keeping();
        crate::common::move_in_time(&model, &options, &mut notes);
        max_norm(notes.states.iter().flat_map(|state| state.u.iter().map(|u| u[2])))
    };
    let expected = largest(Scheme::Newmark(NewmarkScheme { beta: 0.25, gamma: 0.5 }), 1e-6);
    for (rho, gap) in [(0.8, 1e-6), (0.3, 1e-6), (0.95, 1e-6), (0.8, 1e-8), (0.8, 1e-3)] {
        let found = largest(scheme(rho), gap);
        assert!((found / expected - 1.0).abs() < 0.03, "{rho} {gap}: {found} {expected}");
    }
}

/// The work of a drive is the kinetic energy that it gives, with the second order of the scheme.
#[test]
fn a_drive_does_the_work_of_the_kinetic_energy() {
    let error = |step: f64| {
        let hub = body("hub", [0.5, 0.0, 0.0], 10.0, Some([0.1, 0.2, 0.3]));
        let hinge = revolute("hinge", "ground", "hub", [0.0; 3], [0.0, 0.0, 1.0]);
        let drive = Joint::DrivenAngle(DrivenAngleJoint {
            name: "drive".into(),
            between: ["ground".into(), "hub".into()],
            axis: [0.0, 0.0, 1.0],
            angle: 360.0,
            amplitude: "a".into(),
        });
        let mut model = machine(1.0, step, vec![hub], vec![hinge, drive]);
        let formula = ExpressionAmplitude { expression: "2.5*t^2".into() };
        model.amplitudes.insert("a".into(), Amplitude::Expression(formula));
        let (_, state) = run(&stepped(&model, 0.8, 1.0, step), &mut Notes::default());
        let work = 0.5 * (0.3 + 10.0 * 0.25) * (10.0 * std::f64::consts::PI).powi(2);
        (state.work / work - 1.0).abs()
    };
    let errors = [4e-3, 2e-3].map(error);
    assert!(errors[0] < 0.02 && errors[0] / errors[1] > 3.5, "{errors:?}");
}
