//! Steady-state response to harmonic inputs: closed solutions of oscillators and pendulums, and the direct solution of the whole
//! equations of a damped plate.

use crate::common::{compile, model, plate, vector_load};
use crate::multibody::{between, body, gravity, revolute, spring};
use nalgebra::{Complex, DMatrix, DVector};
use std::f64::consts::TAU;
use tegula::analysis::modal::{self, ReducedModel, Response};
use tegula::analysis::{Silent, State, equilibrium};
use tegula::element::Nodal;
use tegula::model::*;
use tegula::norm::max_norm;
use tegula::{Result, System, Vec3, mesh};
use tegula_sparse::SymmetricPattern;

fn steel() -> Material {
    Material::Isotropic(Isotropic::new(2.1e11, 0.3, 7850.0))
}

fn input(name: &str, loads: Vec<Load>) -> ResponseInput {
    ResponseInput { name: name.into(), loads }
}

fn force(on: &str, value: [f64; 3]) -> Load {
    Load::Force(vector_load(on, value))
}

fn range(from: f64, to: f64, points: u32) -> Option<FrequencyResponse> {
    Some(FrequencyResponse { from, to, points, spacing: Spacing::Logarithmic })
}

fn respond(model: &Model) -> Result<(System, State, Response)> {
    let mesh = mesh::generators::generate(&model.mesh)?;
    let system = tegula::compile::build(model, &mesh)?;
    let Analysis::Modal(options) = &model.analysis else { panic!("no modal analysis") };
    let equilibrium =
        if options.prestressed { Some(modal::prestress(&system, &mut Silent)?.state) } else { None };
    let (_, response) = modal::run_with_inputs(&system, options, equilibrium.as_ref(), &mut Silent)?;
    let state = equilibrium.unwrap_or_else(|| State::at_rest(&system));
    Ok((system, state, response.unwrap()))
}

/// Complex displacement of a nodal vector at a frequency.
fn displacement(reduced: &ReducedModel, vector: u32, frequency: f64) -> [Complex<f64>; 3] {
    let q = reduced.response(TAU * frequency, 0);
    let of = |i: usize| q.iter().zip(&reduced.shapes).map(|(q, shape)| q * shape[vector as usize][i]).sum();
    [0, 1, 2].map(of)
}

fn error(found: Complex<f64>, expected: Complex<f64>) -> f64 {
    (found - expected).norm() / expected.norm()
}

/// A mass on a spring with a damper, to the ground: x = F/(k − mω² + iωc), below, at and above its resonance.
#[test]
fn a_damped_oscillator_has_the_amplitude_and_phase_of_its_closed_form() {
    let (m, k, c) = (2.0, 800.0, 3.0);
    let spring = SpringDamper {
        across: None,
        name: "spring".into(),
        between: between("ground", "mass"),
        points: [[-1.0, 0.0, 0.0], [0.0; 3]],
        stiffness: k,
        damping: c,
        force: None,
        length: None,
    };
    let slide = Joint::Prismatic(
        AxisJoint {
            name: "slide".into(),
            between: between("ground", "mass"),
            at: [0.0; 3],
            axis: [1.0, 0.0, 0.0],
            second_at: None,
            second_axis: None,
        }
        .into(),
    );
    // Formulas act with their slopes at the state.
    let law = format!("{k}*x + {c}*v + 90*x^3 - 7*v*abs(v)");
    let formula = SpringDamper { stiffness: 0.0, damping: 0.0, force: Some(law), ..spring.clone() };
    for (spring, mass_damping, ratio) in
        [(&spring, 0.0, 0.0), (&spring, 0.7, 0.0), (&spring, 0.0, 0.05), (&formula, 0.0, 0.0)]
    {
        let analysis = ModalAnalysis {
            inputs: vec![input("push", vec![force("mass", [5.0, 0.0, 0.0])])],
            frequency_response: range(0.1, 30.0, 40),
            damping_ratio: ratio,
            ..ModalAnalysis::new(1)
        };
        let bodies = vec![body("mass", [0.0; 3], m, Some([0.1; 3]))];
        let mut model = Model::of_bodies(Analysis::Modal(analysis), bodies, vec![slide.clone()]);
        model.springs = vec![spring.clone()];
        model.damping.mass = mass_damping;
        let (system, _, response) = respond(&model).unwrap();
        let c = c + mass_damping * m + 2.0 * ratio * (k * m).sqrt();
        assert!(response.frequencies.len() > 40, "the peak has frequencies of its own");
        let centre = system.coordinates.bodies[0].centre;
        for frequency in response.frequencies {
            let w = TAU * frequency;
            let expected = Complex::from(5.0) / Complex::new(k - m * w * w, w * c);
            let [x, y, z] = displacement(&response.reduced, centre, frequency);
            assert!(error(x, expected) < 1e-10, "{frequency} {x} {expected}");
            assert!(max_norm([y.norm(), z.norm()]) < 1e-12);
        }
    }
}

/// Two masses on slides with a spring between them, which drift and vibrate: the first moves by
/// `F (k − m₂ω²)/((k − m₁ω²)(k − m₂ω²) − k²)`, the second by `F k` over the same.
#[test]
fn masses_that_drift_respond_as_their_closed_form() {
    let (m, k) = ([2.0, 3.0], 600.0);
    let slide = |name: &str, at: [f64; 3]| {
        Joint::Prismatic(
            AxisJoint {
                name: format!("slide of {name}"),
                between: between("ground", name),
                at,
                axis: [1.0, 0.0, 0.0],
                second_at: None,
                second_axis: None,
            }
            .into(),
        )
    };
    let analysis = ModalAnalysis {
        inputs: vec![input("push", vec![force("a", [5.0, 0.0, 0.0])])],
        frequency_response: range(0.1, 30.0, 10),
        ..ModalAnalysis::new(2)
    };
    let bodies =
        vec![body("a", [0.0; 3], m[0], Some([0.1; 3])), body("b", [1.0, 0.0, 0.0], m[1], Some([0.2; 3]))];
    let slides = vec![slide("a", [0.0; 3]), slide("b", [1.0, 0.0, 0.0])];
    let mut model = Model::of_bodies(Analysis::Modal(analysis), bodies, slides);
    model.springs = vec![spring("spring", ["a", "b"], [[0.0; 3], [1.0, 0.0, 0.0]], k)];
    let (system, _, response) = respond(&model).unwrap();
    for frequency in response.frequencies {
        let w2 = (TAU * frequency).powi(2);
        let determinant = (k - m[0] * w2) * (k - m[1] * w2) - k * k;
        for (i, expected) in [5.0 * (k - m[1] * w2), 5.0 * k].into_iter().enumerate() {
            let [x, ..] = displacement(&response.reduced, system.coordinates.bodies[i].centre, frequency);
            assert!(error(x, Complex::from(expected / determinant)) < 1e-9, "{frequency} {i} {x}");
        }
    }
}

/// A pendulum under gravity on a hinge, pushed at its mass centre: φ = F l/(m g l − (J + m l²) ω²). Its stiffness is that of the
/// force in the hinge.
#[test]
fn a_hanging_pendulum_swings_as_its_closed_form() {
    let (m, l, j, g) = (2.0, 0.8, 0.1, 9.81);
    let analysis = ModalAnalysis {
        prestressed: true,
        inputs: vec![input("push", vec![force("bob", [1.5, 0.0, 0.0])])],
        frequency_response: range(0.05, 4.0, 20),
        damping_ratio: 1e-3,
        ..ModalAnalysis::new(1)
    };
    let bodies = vec![body("bob", [0.0, 0.0, -l], m, Some([j; 3]))];
    let hinge = revolute("hinge", "ground", "bob", [0.0; 3], [0.0, 1.0, 0.0]);
    let mut model = Model::of_bodies(Analysis::Modal(analysis), bodies, vec![hinge]);
    model.loads = gravity([0.0, 0.0, -g]);
    let (system, _, response) = respond(&model).unwrap();
    let (stiffness, inertia) = (m * g * l, j + m * l * l);
    for frequency in response.frequencies {
        let w = TAU * frequency;
        let damping = 2e-3 * (stiffness * inertia).sqrt();
        let angle = Complex::from(1.5 * l) / Complex::new(stiffness - inertia * w * w, w * damping);
        let [x, ..] = displacement(&response.reduced, system.coordinates.bodies[0].centre, frequency);
        assert!(error(x, angle * l) < 1e-8, "{frequency} {x} {}", angle * l);
    }
}

/// Dense symmetric matrix of a lower triangle by columns.
fn dense(pattern: &SymmetricPattern, values: &[f64]) -> DMatrix<f64> {
    let n = pattern.size();
    let mut out = DMatrix::zeros(n, n);
    for column in 0..n {
        let mut unit = vec![0.0; n];
        unit[column] = 1.0;
        let mut product = vec![0.0; n];
        pattern.add_product(values, &unit, &mut product);
        out.set_column(column, &DVector::from_vec(product));
    }
    out
}

/// A cantilever plate with Rayleigh damping, under a corner force and a pressure: the response from five modes is that of the whole
/// equations `(K (1 + iωτ) + iωαM − ω²M) x = F`, also far from resonances and for all elements.
#[test]
fn few_modes_give_the_response_of_the_whole_equations() {
    let (alpha, tau) = (0.8, 2e-5);
    for element in [ElementKind::Ems, ElementKind::Mitc4, ElementKind::SolidShell] {
        let loads = vec![
            force("u_max_v_max", [1.0, 2.0, -30.0]),
            Load::Pressure(PressureLoad {
                on: "all".into(),
                value: 50.0,
                amplitude: None,
                distribution: None,
            }),
        ];
        let mut m = model(plate([1.0, 0.4], [6, 3], 0.2), 2.1e11, 0.01);
        m.sections[0].element = element;
        m.materials.insert("m".into(), steel());
        m.damping = Damping { mass: alpha, stiffness: tau };
        m.output.points =
            vec![OutputPoint { name: "corner".into(), on: Some("u_max_v_max".into()), at: None }];
        let analysis = ModalAnalysis {
            inputs: vec![input("both", loads.clone())],
            frequency_response: range(0.5, 90.0, 30),
            ..ModalAnalysis::new(5)
        };
        m.analysis = Analysis::Modal(analysis);
        let (system, state, response) = respond(&m).unwrap();
        let (pattern, stiffness) = equilibrium::tangent(&system, &state).unwrap();
        let mass = dense(&pattern, &equilibrium::mass(&system, &state).unwrap()).map(Complex::from);
        let stiffness = dense(&pattern, &stiffness).map(Complex::from);
        // Forces of the same loads as those of a static analysis.
        let at_once = Model {
            loads,
            damping: Damping::default(),
            analysis: Analysis::Static(StaticAnalysis::default()),
            ..m.clone()
        };
        let (_, loaded) = compile(&at_once);
        let state = State { time: 1.0, ..State::at_rest(&loaded) };
        let load = DVector::from_vec(equilibrium::residual(&loaded, &state)).map(Complex::from);
        let frames = equilibrium::frames(&system, &state);
        for &frequency in response.frequencies.iter().step_by(3) {
            let w = TAU * frequency;
            let matrix = &stiffness * Complex::new(1.0, w * tau) + &mass * Complex::new(-w * w, w * alpha);
            let exact = matrix.lu().solve(&load).unwrap();
            let q = response.reduced.response(w, 0);
            let mut found = DVector::from_element(exact.len(), Complex::from(0.0));
            for (q, shape) in q.iter().zip(&response.reduced.shapes) {
                let mut x = vec![0.0; exact.len()];
                frames.components(shape, &mut x);
                found += DVector::from_vec(x).map(Complex::from) * *q;
            }
            let error = (&found - &exact).norm() / exact.norm();
            assert!(error < 1e-5, "{element:?} {frequency}: {error:.1e}");
        }
        assert_eq!(response.reduced.modes, 5);
    }
}

/// Change of a valid analysis and its model.
type Change = fn(&mut ModalAnalysis, &mut Model);

fn oscillator(change: impl Fn(&mut ModalAnalysis, &mut Model)) -> String {
    let mut m = model(plate([1.0, 0.4], [4, 2], 0.0), 2.1e11, 0.01);
    m.materials.insert("m".into(), steel());
    m.output.points = vec![OutputPoint { name: "tip".into(), on: Some("u_max_v_min".into()), at: None }];
    let mut analysis = ModalAnalysis {
        inputs: vec![input("push", vec![force("u_max_v_min", [0.0, 0.0, 1.0])])],
        frequency_response: range(1.0, 20.0, 10),
        damping_ratio: 0.01,
        ..ModalAnalysis::new(3)
    };
    change(&mut analysis, &mut m);
    m.analysis = Analysis::Modal(analysis);
    respond(&m).map_or_else(|error| error.to_string(), |_| String::new())
}

#[test]
fn inputs_that_give_no_response_are_refused_by_their_key() {
    assert_eq!(oscillator(|_, _| {}), "");
    let cases: [(&str, Change); 14] = [
        ("analysis.inputs[0].loads[0].on", |a, _| a.inputs[0].loads = vec![force("nowhere", [1.0; 3])]),
        ("analysis.inputs[0].loads[0]: the load of the input is 0", |a, _| {
            a.inputs[0].loads = vec![force("u_max", [0.0; 3])];
        }),
        ("analysis.inputs[0].loads[0].value", |a, _| a.inputs[0].loads = vec![force("u_max", [f64::NAN; 3])]),
        ("analysis.inputs[0].loads: the input has no loads", |a, _| a.inputs[0].loads.clear()),
        ("analysis.inputs[1].name", |a, _| a.inputs.push(a.inputs[0].clone())),
        ("analysis.inputs: the response has no outputs", |_, m| m.output.points.clear()),
        ("analysis.damping_ratio", |a, _| a.damping_ratio = 1.0),
        ("analysis.damping_ratio", |a, _| a.damping_ratio = f64::NAN),
        ("analysis.frequency_response: no input", |a, _| a.inputs.clear()),
        ("analysis.frequency_response.from", |a, _| a.frequency_response = range(0.0, 3.0, 5)),
        ("analysis.frequency_response.from", |a, _| a.frequency_response = range(f64::NAN, 3.0, 5)),
        ("analysis.frequency_response.to", |a, _| a.frequency_response = range(4.0, 3.0, 5)),
        ("analysis.frequency_response.points", |a, _| a.frequency_response = range(1.0, 3.0, 1)),
        ("is wanted up to 1000, and the highest of the 3 modes", |a, _| {
            a.frequency_response = range(1.0, 1000.0, 5);
        }),
    ];
    for (expected, change) in cases {
        let message = oscillator(change);
        assert!(message.contains(expected), "{expected}: {message}");
    }
}

/// A bar on a hinge and a spring has one degree of freedom: what its mode leaves of the force the hinge balances. The static rotation
/// is −½ F/(k L²), and the hinge stays closed.
#[test]
fn joints_balance_what_the_modes_leave_of_a_load() {
    for response in [None, range(0.1, 3.0, 10)] {
        let analysis = ModalAnalysis {
            inputs: vec![input("f", vec![force("bar", [0.0, 0.0, 1.0])])],
            frequency_response: response,
            ..ModalAnalysis::new(1)
        };
        let bodies = vec![body("bar", [0.5, 0.0, 0.0], 1.0, Some([0.1, 0.2, 0.25]))];
        let hinge = revolute("hinge", "ground", "bar", [0.0; 3], [0.0, 1.0, 0.0]);
        let mut model = Model::of_bodies(Analysis::Modal(analysis), bodies, vec![hinge]);
        model.springs = vec![SpringDamper {
            across: None,
            name: "s".into(),
            between: between("ground", "bar"),
            points: [[1.0, 0.0, 1.0], [1.0, 0.0, 0.0]],
            stiffness: 200.0,
            damping: 0.0,
            force: None,
            length: None,
        }];
        let (system, _, response) = respond(&model).unwrap();
        assert_eq!(response.reduced.lambdas.len(), 1);
        let body = &system.coordinates.bodies[0];
        let [x, y, z] = displacement(&response.reduced, body.centre, 0.0);
        assert!(
            error(z, Complex::from(1.25e-3)) < 1e-9 && max_norm([x.norm(), y.norm()]) < 1e-15,
            "{x} {y} {z}"
        );
        let [_, _, turned] = displacement(&response.reduced, body.directors.unwrap()[0], 0.0);
        assert!(error(turned, Complex::from(2.5e-3)) < 1e-9, "{turned}");
    }
}

/// A free plate has six rigid modes: with fewer of them the response would lack rigid motions.
#[test]
fn inputs_of_a_free_model_with_few_modes_are_refused() {
    let few = oscillator(|a, m| {
        m.conditions.clear();
        a.frequency_response = None;
    });
    assert!(few.contains("6 rigid modes, and 3 modes are wanted"), "{few}");
}

/// A dashpot at a point that a mode does not move gives no peak: its damping ratio is round-off.
#[test]
fn a_damper_on_a_nodal_line_is_no_damping_of_the_mode() {
    let bodies = vec![body("mass", [0.0; 3], 1.0, None)];
    let spring = |axis: usize, damping: f64| {
        let mut end = [0.0; 3];
        end[axis] = -1.0;
        SpringDamper {
            across: None,
            name: format!("spring {axis}"),
            between: between("ground", "mass"),
            points: [end, [0.0; 3]],
            stiffness: 16.0 * (1.0 + axis as f64),
            damping,
            force: None,
            length: None,
        }
    };
    let analysis = ModalAnalysis {
        inputs: vec![input("push", vec![force("mass", [1.0, 1e-20, 0.0])])],
        frequency_response: range(0.1, 0.9, 20),
        ..ModalAnalysis::new(3)
    };
    let mut model = Model::of_bodies(Analysis::Modal(analysis), bodies, Vec::new());
    model.springs = vec![spring(0, 0.4), spring(1, 1e-12), spring(2, 0.0)];
    assert!(respond(&model).is_ok());
}

/// Without damping the response beside a resonance is large, and has no bound at it: that one is refused.
#[test]
fn an_undamped_resonance_is_refused() {
    let bodies = vec![body("mass", [0.0; 3], 1.0, None)];
    let spring = |axis: usize| {
        let mut end = [0.0; 3];
        end[axis] = -1.0;
        SpringDamper {
            across: None,
            name: format!("spring {axis}"),
            between: between("ground", "mass"),
            points: [end, [0.0; 3]],
            stiffness: 16.0,
            damping: 0.0,
            force: None,
            length: None,
        }
    };
    let respond_to = |to: f64| {
        let analysis = ModalAnalysis {
            inputs: vec![input("push", vec![force("mass", [1.0, 0.0, 0.0])])],
            frequency_response: range(0.1, to, 2),
            ..ModalAnalysis::new(3)
        };
        let mut model = Model::of_bodies(Analysis::Modal(analysis), bodies.clone(), Vec::new());
        model.springs = (0..3).map(spring).collect();
        respond(&model)
    };
    let resonance = 4.0 / TAU;
    let message = respond_to(resonance).err().unwrap().to_string();
    assert!(message.contains("it is a resonance without damping"), "{message}");
    let (system, _, response) = respond_to(1.01 * resonance).unwrap();
    let [x, ..] = displacement(&response.reduced, system.coordinates.bodies[0].centre, 1.01 * resonance);
    assert!(error(x, Complex::from(1.0 / (16.0 * (1.0 - 1.01f64.powi(2))))) < 1e-10);
}

/// A steady vibration in time has the amplitude of the response: a plate under a sinusoidal force, once its start has died away.
#[test]
fn the_response_is_that_of_a_long_transient_analysis() {
    let mut m = model(plate([1.0, 0.4], [4, 2], 0.0), 2.1e11, 0.01);
    m.materials.insert("m".into(), steel());
    m.damping = Damping { mass: 20.0, stiffness: 0.0 };
    m.output.points = vec![OutputPoint { name: "tip".into(), on: Some("u_max_v_min".into()), at: None }];
    let frequency = 6.0;
    let analysis = ModalAnalysis {
        inputs: vec![input("push", vec![force("u_max_v_min", [0.0, 0.0, 1.0])])],
        frequency_response: range(frequency, 7.0, 2),
        ..ModalAnalysis::new(3)
    };
    m.analysis = Analysis::Modal(analysis);
    let (mesh, system) = compile(&m);
    let (_, _, response) = respond(&m).unwrap();
    let node = mesh.nodes_on("u_max_v_min").unwrap()[0];
    let vector = system.coordinates.position_of[node as usize];
    let [_, _, z] = displacement(&response.reduced, vector, frequency);
    let mut load = vector_load("u_max_v_min", [0.0, 0.0, 1.0]);
    load.amplitude = Some("wave".into());
    m.loads = vec![Load::Force(load)];
    m.amplitudes.insert(
        "wave".into(),
        Amplitude::Expression(ExpressionAmplitude { expression: format!("cos({} * t)", TAU * frequency) }),
    );
    let periods = 10.0;
    m.analysis = Analysis::Transient(TransientAnalysis {
        time_step: Some(1.0 / frequency / 200.0),
        linear: true,
        ..TransientAnalysis::new(periods / frequency)
    });
    let Analysis::Transient(options) = &m.analysis else { panic!() };
    let (_, outcome) = crate::common::move_in_time(&m, options, &mut Default::default());
    let u: &[Nodal] = &outcome.state.u;
    let v = Vec3::from(outcome.state.v[vector as usize]).z / (TAU * frequency);
    // At the end of a period x = Re(X) and ẋ = −ω Im(X).
    let found = Complex::new(u[vector as usize][2], -v);
    assert!(error(found, z) < 5e-3, "{found} {z}");
}

/// A door with a spring in its hinge has one motion, so that one mode is its exact response: what the mode leaves of the load is carried by the hinge.
#[test]
fn the_response_of_one_degree_of_freedom_is_exact_with_one_mode() {
    for number in 0..12 {
        let angle = 0.5 * f64::from(number) + 0.1;
        let arm = 1.0 + 0.3 * angle.sin();
        let (mass, k) = (8.0, 7e4);
        let at = [arm * angle.cos(), arm * angle.sin(), 0.3];
        let bodies = vec![body("door", at, mass, Some([1.0, 1.2, 1.4]))];
        let joints = vec![revolute("hinge", "ground", "door", [0.0; 3], [0.0, 0.0, 1.0])];
        let push = [0.3 - 0.01 * angle, 0.2 * angle, 5.0];
        let analysis = ModalAnalysis {
            inputs: vec![input("push", vec![force("door", push)])],
            frequency_response: range(1.0, 50.0, 20),
            ..ModalAnalysis::new(1)
        };
        let mut model = Model::of_bodies(Analysis::Modal(analysis), bodies, joints);
        model.torsion_springs = vec![TorsionSpring {
            name: "spring".into(),
            between: between("ground", "door"),
            axis: [0.0, 0.0, 1.0],
            stiffness: k,
            damping: 0.0,
            moment: None,
            free_angle: 0.0,
        }];
        let (system, _, response) = respond(&model).unwrap();
        let moment = at[0] * push[1] - at[1] * push[0];
        let inertia = 1.4 + mass * arm * arm;
        for frequency in [1.0, 7.0, 50.0_f64] {
            let turn = moment / (k - inertia * (TAU * frequency).powi(2));
            let [x, y, _] = displacement(&response.reduced, system.coordinates.bodies[0].centre, frequency);
            let exact = [-at[1] * turn, at[0] * turn];
            let difference = (x - exact[0]).norm() + (y - exact[1]).norm();
            assert!(difference < 1e-9 * (arm * turn).abs(), "{number} {frequency}: {x} {y} for {exact:?}");
        }
    }
}
