//! Torsion springs: closed solutions over several turns, conservation of energy and momenta, statics, modes, refusals.

use crate::common::Notes;
use crate::multibody::{between, body, machine, revolute, run};
use tegula::analysis::modal;
use tegula::analysis::{Observer, Silent, Step, dynamics, statics};
use tegula::element::{ElementGroup, GroupPoint, InternalVariables, Motion, TangentRequest, TangentWeights};
use tegula::model::*;
use tegula::norm::larger;
use tegula::result::bodies::torsion_angles_and_moments;
use tegula::{Error, System, Vec3, compile, mesh};

fn spring(ends: [&str; 2], stiffness: f64, damping: f64, free_angle: f64) -> TorsionSpring {
    let between = between(ends[0], ends[1]);
    TorsionSpring {
        name: "clock".into(),
        between,
        axis: [0.0, 0.0, 2.0],
        stiffness,
        damping,
        moment: None,
        free_angle,
    }
}

/// A wheel on a hinge with a torsion spring to the ground, without gravity.
fn wheel(end: f64, step: f64, spring: TorsionSpring) -> Model {
    let wheel = body("wheel", [0.0; 3], 2.0, Some([0.3, 0.3, 0.5]));
    let hinge = revolute("hinge", "ground", "wheel", [0.0; 3], [0.0, 0.0, 1.0]);
    let mut model = machine(end, step, vec![wheel], vec![hinge]);
    model.torsion_springs = vec![spring];
    model
}

/// Wound up by two and a quarter turns, the wheel swings with ω² = k/J about the free angle, through full turns: the error is that of
/// the scheme, of second order.
#[test]
fn a_wheel_swings_about_the_free_angle_through_several_turns() {
    for damping in [0.0, 0.4] {
        for scheme in [
            Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 }),
            Scheme::GeneralizedAlpha(GeneralizedAlphaScheme { spectral_radius: 0.9 }),
        ] {
            let error = |step: f64| {
                let mut model = wheel(3.0, step, spring(["ground", "wheel"], 2.0, damping, 810.0));
                let Analysis::Transient(options) = &mut model.analysis else { panic!() };
                options.scheme = scheme;
                let mut notes = Notes::default();
                let (system, state) = run(&model, &mut notes);
                let (omega, decay, t) = (2.0_f64, damping / (2.0 * 0.5), 3.0);
                let damped = (omega * omega - decay * decay).sqrt();
                let swing = (damped * t).cos() + decay / damped * (damped * t).sin();
                let free = 810_f64.to_radians();
                let expected = free * (1.0 - (-decay * t).exp() * swing);
                let [angle, moment] = torsion_angles_and_moments(&system, &state)[0];
                if damping == 0.0 {
                    assert!((moment - 2.0 * (angle - free)).abs() < 1e-9);
                }
                if matches!(scheme, Scheme::EnergyMomentum(_)) {
                    assert!(notes.drift() <= 1e-11 * notes.kinetic, "{} {}", notes.drift(), notes.kinetic);
                }
                (angle - expected).abs()
            };
            let [coarse, fine] = [2e-3, 1e-3].map(error);
            assert!(
                fine < 4e-3 && (3.5..4.5).contains(&(coarse / fine)),
                "{scheme:?} {damping}: {coarse} {fine}"
            );
        }
    }
}

/// Two bodies on a common hinge that fly through space and turn against each other by more than half a turn: energy and momenta are
/// conserved exactly.
#[test]
fn two_bodies_against_each_other_keep_energy_and_momenta() {
    let spun = |name: &str, x: f64, w: [f64; 3]| RigidBody {
        angular_velocity: w,
        velocity: Vec3::from(w).cross(&Vec3::new(x, 0.0, 0.0)).into(),
        ..body(name, [x, 0.0, 0.0], 1.0, Some([0.2, 0.3, 0.4]))
    };
    let hinge = revolute("hinge", "a", "b", [0.0; 3], [0.0, 0.0, 1.0]);
    let bodies = vec![spun("a", -0.4, [0.5, 1.0, -6.0]), spun("b", 0.3, [0.5, 1.0, 9.0])];
    let mut model = machine(4.0, 0.01, bodies, vec![hinge]);
    model.torsion_springs = vec![spring(["a", "b"], 1.5, 0.0, 0.0)];
    let mut notes = Notes::default();
    let (system, _) = run(&model, &mut notes);
    let mut turned = Turned { system: &system, most: 0.0 };
    let Analysis::Transient(options) = &model.analysis else { panic!() };
    dynamics::run(&system, options, None, &mut turned).unwrap();
    assert!(turned.most > 1.2 * std::f64::consts::PI, "{}", turned.most);
    assert!(notes.drift() <= 1e-10 * notes.kinetic, "{} {}", notes.drift(), notes.kinetic);
    let (linear, angular) = notes.momenta[0];
    let (p, l) = notes.momenta.last().unwrap();
    assert!((p - linear).norm() <= 1e-10 * linear.norm(), "{p} {linear}");
    assert!((l - angular).norm() <= 1e-10 * angular.norm(), "{l} {angular}");
}

/// Largest angle of the first torsion spring.
struct Turned<'a> {
    system: &'a System,
    most: f64,
}

impl Observer for Turned<'_> {
    fn on_step(&mut self, step: &Step) -> tegula::Result<()> {
        let [angle, _] = torsion_angles_and_moments(self.system, step.state)[0];
        self.most = larger(self.most, angle.abs());
        Ok(())
    }
}

/// Two wheels whose relative angle grows beyond half a turn in one load step: the step is cut back, and no turn is lost.
#[test]
fn load_steps_beyond_half_a_turn_are_cut_back() {
    let bodies = ["a", "b"].map(|name| body(name, [0.0; 3], 1.0, Some([0.3, 0.3, 0.5]))).to_vec();
    let hinges = ["a", "b"].map(|name| revolute(name, "ground", name, [0.0; 3], [0.0, 0.0, 1.0])).to_vec();
    let options = StaticAnalysis::default();
    let mut model = Model::of_bodies(Analysis::Static(options.clone()), bodies, hinges);
    model.torsion_springs =
        [("of a", ["ground", "a"], 1.0), ("of b", ["ground", "b"], 1.0), ("both", ["a", "b"], 0.1)]
            .map(|(name, ends, k)| TorsionSpring { name: name.into(), ..spring(ends, k, 0.0, 0.0) })
            .to_vec();
    let moment = |on: &str, value: f64| {
        Load::Moment(VectorLoad {
            on: on.into(),
            value: [0.0, 0.0, value],
            amplitude: None,
            distribution: None,
        })
    };
    model.loads = vec![moment("a", -2.4), moment("b", 2.4)];
    let system = compile::build(&model, &mesh::generators::generate(&model.mesh).unwrap()).unwrap();
    let state = statics::run(&system, &options, None, &mut Silent).unwrap().state;
    let found = torsion_angles_and_moments(&system, &state);
    // θ (k + 2 k₂) = M for both, against each other.
    for ([angle, _], expected) in found.iter().zip([-2.0, 2.0, 4.0]) {
        assert!((angle - expected).abs() < 1e-9, "{found:?}");
    }
}

/// A moment of 1.7 turns times the stiffness winds the spring up by 1.7 turns, in load steps.
#[test]
fn a_static_moment_winds_the_spring_up_beyond_a_turn() {
    let mut model = wheel(1.0, 0.1, spring(["ground", "wheel"], 2.0, 0.0, 0.0));
    let target = 1.7 * std::f64::consts::TAU;
    let value = [0.0, 0.0, 2.0 * target];
    model.loads =
        vec![Load::Moment(VectorLoad { on: "wheel".into(), value, amplitude: None, distribution: None })];
    let options = StaticAnalysis { load_steps: 10, ..StaticAnalysis::default() };
    model.analysis = Analysis::Static(options.clone());
    let mesh = mesh::generators::generate(&model.mesh).unwrap();
    let system = compile::build(&model, &mesh).unwrap();
    let state = statics::run(&system, &options, None, &mut Silent).unwrap().state;
    let [angle, moment] = torsion_angles_and_moments(&system, &state)[0];
    assert!((angle / target - 1.0).abs() < 1e-9, "{angle} {target}");
    assert!((moment / value[2] - 1.0).abs() < 1e-9, "{moment}");
}

/// Three discs on hinges with springs between them: ω² of the chain with ends free and fixed.
#[test]
fn discs_on_torsion_springs_vibrate_as_a_chain() {
    let bodies = ["a", "b"].map(|name| body(name, [0.0; 3], 1.0, Some([0.3, 0.3, 0.5]))).to_vec();
    let hinges = ["a", "b"].map(|name| revolute(name, "ground", name, [0.0; 3], [0.0, 0.0, 1.0])).to_vec();
    let mut model = Model::of_bodies(Analysis::Modal(ModalAnalysis::new(2)), bodies, hinges);
    model.torsion_springs = vec![
        spring(["ground", "a"], 2.0, 0.0, 0.0),
        TorsionSpring { name: "second".into(), ..spring(["a", "b"], 2.0, 0.0, 0.0) },
    ];
    let mesh = mesh::generators::generate(&model.mesh).unwrap();
    let system = compile::build(&model, &mesh).unwrap();
    let found = modal::run(&system, 2, None, &mut Silent).unwrap();
    // ω² J/k of a chain of two: (3 ∓ √5)/2.
    for (mode, sign) in found.modes.iter().zip([-1.0, 1.0]) {
        let expected = (4.0 * (3.0 + sign * 5_f64.sqrt()) / 2.0).sqrt();
        assert!((mode.omega / expected - 1.0).abs() < 1e-9, "{} {expected}", mode.omega);
    }
}

/// The tangent is the derivative of the forces, at a large angle and under a moment.
#[test]
fn the_tangent_is_the_derivative_of_the_forces() {
    tangent_is_derivative(spring(["ground", "wheel"], 2.0, 0.0, 40.0));
    tangent_is_derivative(crate::spring_formulas::torsion("2*sin(x) + 0.3*x^2*cos(t) + v", 40.0));
}

fn tangent_is_derivative(spring: TorsionSpring) {
    let model = wheel(1.0, 0.1, spring);
    let mesh = mesh::generators::generate(&model.mesh).unwrap();
    let system = compile::build(&model, &mesh).unwrap();
    let (_, [group, _]) = system.torsion_springs[0];
    let group: &dyn ElementGroup = system.groups[group].as_ref();
    let u = displaced(&system);
    // The spring has turned by a whole turn before.
    let angle = &system.torsion_springs[0].0.angle;
    let at = |v: &u32| Vec3::from(system.coordinates.reference[*v as usize]) + Vec3::from(u[*v as usize]);
    let [sine, cosine] = angle.forms(&angle.vectors.iter().map(at).collect::<Vec<_>>());
    let mut history = vec![std::f64::consts::TAU + sine.atan2(cosine) + 0.3];
    history.extend(angle.rotation(|v| at(&v)).numbers());
    tangent_of_group_is_derivative(&system, group, (&u, &history));
}

/// Displacements of all nodal vectors, as large as directors.
pub fn displaced(system: &tegula::System) -> Vec<[f64; 3]> {
    let of_vector = |v: usize| std::array::from_fn(|i| 0.3 * ((3 * v + i) as f64 * 1.7 + 0.4).sin());
    (0..system.vectors()).map(of_vector).collect()
}

/// The tangent of the first element of a group at these displacements, with these history variables, is the derivative of its forces.
pub fn tangent_of_group_is_derivative(
    system: &tegula::System,
    group: &dyn ElementGroup,
    (u, history): (&[[f64; 3]], &[f64]),
) {
    let n = group.vectors_per_element();
    let evaluate = |u: &[[f64; 3]], request: Option<TangentRequest>| {
        let mut forces = vec![0.0; 3 * n];
        let k = GroupPoint {
            reference: &system.coordinates.reference,
            motion: Motion::State { u, velocity: None },
            linear: false,
            interior: InternalVariables { history, factors: &[] },
            inextensible: &[],
            multipliers: &[],
            time: 0.0,
            drives: &[],
            preload: 1.0,
        };
        group.evaluate(&k, 0, &mut forces, request);
        forces
    };
    let mut blocks = vec![0.0; 9 * n * (n + 1) / 2];
    let request = TangentRequest {
        weights: TangentWeights::STATIC,
        stress: None,
        prescribed: None,
        blocks: &mut blocks,
    };
    evaluate(u, Some(request));
    let entry = |row: usize, column: usize| {
        let (a, b) = (row / 3, column / 3);
        let at = |a: usize, b: usize, i: usize, j: usize| blocks[9 * (a * (a + 1) / 2 + b) + 3 * i + j];
        if a >= b { at(a, b, row % 3, column % 3) } else { at(b, a, column % 3, row % 3) }
    };
    let size = blocks.iter().map(|k| k.abs()).fold(0.0, larger);
    for column in 0..3 * n {
        let vector = group.vectors(0)[column / 3] as usize;
        let moved = |step: f64| {
            let mut u = u.to_vec();
            u[vector][column % 3] += step;
            evaluate(&u, None)
        };
        let (more, less) = (moved(1e-5), moved(-1e-5));
        for row in 0..3 * n {
            let difference = (more[row] - less[row]) / 2e-5;
            assert!((difference - entry(row, column)).abs() < 1e-8 * size, "{row} {column}");
        }
    }
}

#[test]
fn torsion_springs_between_points_are_refused() {
    let mut model = wheel(1.0, 0.1, spring(["ground", "wheel"], 2.0, 0.0, 0.0));
    model.bodies.push(body("dot", [1.0, 0.0, 0.0], 1.0, None));
    let refused = |spring: TorsionSpring, key: &str| {
        let model = Model { torsion_springs: vec![spring], ..model.clone() };
        let mesh = mesh::generators::generate(&model.mesh).unwrap();
        let Err(Error::Model(issues)) = compile::build(&model, &mesh) else { panic!("{key} is taken") };
        assert!(issues.iter().any(|issue| issue.place.key == key), "{key}: {issues:?}");
    };
    refused(spring(["wheel", "dot"], 1.0, 0.0, 0.0), "torsion_springs[0].between");
    refused(spring(["wheel", "wheel"], 1.0, 0.0, 0.0), "torsion_springs[0].between");
    refused(spring(["ground", "wheel"], 0.0, 0.0, 0.0), "torsion_springs[0]");
    refused(
        TorsionSpring { axis: [0.0; 3], ..spring(["ground", "wheel"], 1.0, 0.0, 0.0) },
        "torsion_springs[0].axis",
    );
}

/// A moment winds a spring through several turns in a few load steps: θ = M/k, with the work ½ M θ, whatever the steps.
#[test]
fn a_moment_winds_a_spring_in_few_load_steps_with_the_work_of_its_turns() {
    for (moment, load_steps) in [(1.0, 1), (10.0, 2), (10.0, 1), (20.0, 1), (20.0, 8)] {
        let wheel = body("wheel", [0.0; 3], 2.0, Some([0.05, 0.05, 0.09]));
        let hinge = revolute("ax", "ground", "wheel", [0.0; 3], [0.0, 0.0, 1.0]);
        let options = StaticAnalysis { load_steps, ..StaticAnalysis::default() };
        let mut model = Model::of_bodies(Analysis::Static(options.clone()), vec![wheel], vec![hinge]);
        model.torsion_springs = vec![TorsionSpring {
            name: "clock".into(),
            between: ["ground".into(), "wheel".into()],
            axis: [0.0, 0.0, 1.0],
            stiffness: 1.0,
            damping: 0.0,
            moment: None,
            free_angle: 0.0,
        }];
        model.loads = vec![Load::Moment(crate::common::vector_load("wheel", [0.0, 0.0, moment]))];
        let system = compile::build(&model, &mesh::generators::generate(&model.mesh).unwrap()).unwrap();
        let outcome = tegula::analysis::statics::run(&system, &options, None, &mut Silent).unwrap();
        let [angle, _] = torsion_angles_and_moments(&system, &outcome.state)[0];
        assert!((angle - moment).abs() < 1e-9, "{moment} {load_steps}: {angle}");
        let work = 0.5 * moment * moment;
        assert!((outcome.state.work / work - 1.0).abs() < 1e-9, "{}", outcome.state.work);
        assert!(outcome.balance.total.abs() < 1e-9 * work, "{}", outcome.balance.total);
    }
}

/// A moment on a body that hardly turns, or not at all, does the work of its small arc.
#[test]
fn moments_on_bodies_that_hardly_turn_do_little_work() {
    for stiffness in [Some(1e8), None] {
        let wheel = body("wheel", [0.0; 3], 2.0, Some([0.05, 0.05, 0.09]));
        let hinge = match stiffness {
            Some(_) => revolute("ax", "ground", "wheel", [0.0; 3], [0.0, 0.0, 1.0]),
            None => Joint::Fixed(PointJoint {
                name: "weld".into(),
                between: between("ground", "wheel"),
                at: [0.0; 3],
                second_at: None,
            }),
        };
        let options = StaticAnalysis { load_steps: 7, ..StaticAnalysis::default() };
        let mut model = Model::of_bodies(Analysis::Static(options.clone()), vec![wheel], vec![hinge]);
        model.torsion_springs =
            stiffness.map(|k| spring(["ground", "wheel"], k, 0.0, 0.0)).into_iter().collect();
        model.loads = vec![Load::Moment(crate::common::vector_load("wheel", [0.0, 0.0, 1.0]))];
        let system = compile::build(&model, &mesh::generators::generate(&model.mesh).unwrap()).unwrap();
        let work = statics::run(&system, &options, None, &mut Silent).unwrap().state.work;
        let expected = stiffness.map_or(0.0, |k| 0.5 / k);
        assert!((work - expected).abs() < 1e-14, "{work} {expected}");
    }
}

/// A drive that winds a spring by 1000° does the work ½ k θ².
#[test]
fn a_static_drive_does_the_work_that_a_spring_stores() {
    let wheel = body("wheel", [0.0; 3], 2.0, Some([0.05, 0.05, 0.09]));
    let hinge = revolute("ax", "ground", "wheel", [0.0; 3], [0.0, 0.0, 1.0]);
    let drive = Joint::DrivenAngle(DrivenAngleJoint {
        name: "motor".into(),
        between: ["ground".into(), "wheel".into()],
        axis: [0.0, 0.0, 1.0],
        angle: 1000.0,
        amplitude: "ramp".into(),
    });
    let options = StaticAnalysis::default();
    let mut model = Model::of_bodies(Analysis::Static(options.clone()), vec![wheel], vec![hinge, drive]);
    model.amplitudes.insert("ramp".into(), Amplitude::Ramp(RampAmplitude { start: 0.0, end: 1.0 }));
    model.torsion_springs = vec![TorsionSpring {
        name: "clock".into(),
        between: ["ground".into(), "wheel".into()],
        axis: [0.0, 0.0, 1.0],
        stiffness: 2.0,
        damping: 0.0,
        moment: None,
        free_angle: 0.0,
    }];
    let system = compile::build(&model, &mesh::generators::generate(&model.mesh).unwrap()).unwrap();
    let outcome = tegula::analysis::statics::run(&system, &options, None, &mut Silent).unwrap();
    let work = 1000.0_f64.to_radians().powi(2);
    assert!((outcome.state.work / work - 1.0).abs() < 1e-9, "{} {work}", outcome.state.work);
}

/// Preloaded springs that move a body along its weight: k (θ − θ₀) = m g l cos θ, and k (z − z₀) = −m g, are the only equilibria.
#[test]
fn preloaded_springs_may_move_a_body_along_its_weight() {
    let weight = || vec![Load::Gravity(GravityLoad { value: [0.0, 0.0, -10.0], amplitude: None })];
    let solved = |model: &Model, options: &StaticAnalysis| {
        let system = compile::build(model, &mesh::generators::generate(&model.mesh).unwrap()).unwrap();
        let state = statics::run(&system, options, None, &mut Silent).unwrap().state;
        (system, state)
    };
    for (free_angle, load_steps) in [(30.0_f64, 4), (10.0, 1), (90.0, 4), (-30.0, 2)] {
        let rod = body("rod", [0.5, 0.0, 0.0], 2.0, Some([0.1, 0.2, 0.3]));
        let hinge = revolute("j", "ground", "rod", [0.0; 3], [0.0, 1.0, 0.0]);
        let options = StaticAnalysis { load_steps, ..StaticAnalysis::default() };
        let mut model = Model::of_bodies(Analysis::Static(options.clone()), vec![rod], vec![hinge]);
        let axis = [0.0, 1.0, 0.0];
        model.torsion_springs =
            vec![TorsionSpring { axis, ..spring(["ground", "rod"], 30.0, 0.0, free_angle) }];
        model.loads = weight();
        let (system, state) = solved(&model, &options);
        let [angle, _] = torsion_angles_and_moments(&system, &state)[0];
        let rest = 30.0 * (angle - free_angle.to_radians()) - 10.0 * angle.cos();
        assert!(rest.abs() < 1e-8, "{free_angle}: {angle} {rest}");
    }
    for length in [1.1, 1.5] {
        let slide = Joint::Prismatic(
            AxisJoint {
                name: "slide".into(),
                between: between("ground", "block"),
                at: [0.0; 3],
                axis: [0.0, 0.0, 1.0],
                second_at: None,
                second_axis: None,
            }
            .into(),
        );
        let options = StaticAnalysis::default();
        let block = body("block", [0.0; 3], 1.0, Some([0.1; 3]));
        let mut model = Model::of_bodies(Analysis::Static(options.clone()), vec![block], vec![slide]);
        model.springs = vec![SpringDamper {
            across: None,
            name: "coil".into(),
            between: between("ground", "block"),
            points: [[0.0, 0.0, 1.0], [0.0; 3]],
            stiffness: 100.0,
            damping: 0.0,
            force: None,
            length: Some(length),
        }];
        model.loads = weight();
        let (system, state) = solved(&model, &options);
        let z = state.u[system.coordinates.bodies[0].centre as usize][2];
        assert!((z - (0.9 - length)).abs() < 1e-9, "{length}: {z}");
    }
}
