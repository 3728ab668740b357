//! Explicit integration of what models may hold: motions of supports, damping, plastic layers, rubber, folds, pressure;
//! what it refuses; interruption.

use std::cell::Cell;

use crate::common::{Notes, compile, model, plate};
use tegula::analysis::dynamics::{self, TransientOutcome};
use tegula::analysis::{Observer, Silent, State, Step};
use tegula::compile::build;
use tegula::mesh::generators::generate;
use tegula::model::*;
use tegula::norm::larger;
use tegula::{Error, Result, System, Vec3};

const EXPLICIT: Scheme = Scheme::Explicit(ExplicitScheme { scale_director_inertia: true });
const NEWMARK: Scheme = Scheme::Newmark(NewmarkScheme { beta: 0.25, gamma: 0.5 });

fn with(m: &Model, scheme: Scheme, end: f64, time_step: Option<f64>) -> Model {
    let t = TransientAnalysis { scheme, time_step, ..TransientAnalysis::new(end) };
    Model { analysis: Analysis::Transient(t), ..m.clone() }
}

fn run(m: &Model, observer: &mut dyn Observer) -> Result<TransientOutcome> {
    let (_, system) = compile(m);
    let Analysis::Transient(t) = &m.analysis else { unreachable!() };
    dynamics::run(&system, t, None, observer)
}

/// Model `m` with lumped mass, for implicit steps.
fn twin(m: &Model) -> System {
    let (_, lumped) = compile(m);
    let (_, mut system) = compile(&with(m, NEWMARK, 1.0, None));
    let mut mass = vec![0.0; lumped.vectors()];
    lumped.pattern.for_each_mass(|i, _, m| mass[i] = m);
    system.pattern.set_mass(|i, j| if i == j { mass[i] } else { 0.0 });
    // Gravity acts on the lumped mass, too.
    system.dead_loads = lumped.dead_loads;
    system
}

fn size(a: &[[f64; 3]]) -> f64 {
    a.iter().map(|a| Vec3::from(*a).norm_squared()).sum::<f64>().sqrt()
}

fn distance(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (Vec3::from(*a) - Vec3::from(*b)).norm_squared()).sum::<f64>().sqrt()
}

/// A strip of rubber-like stiffness, clamped at its left end.
fn strip() -> Model {
    let mut m = model(plate([1.0, 0.5], [6, 3], 0.2), 1e6, 0.05);
    m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(1e6, 0.3, 1e3)));
    m
}

/// Steps of the explicit scheme, so many for one critical step, against implicit ones of the same length on the same
/// lumped mass: both are of second order.
fn against_newmark(m: &Model, parts: f64, end: f64, tolerance: f64) -> (TransientOutcome, TransientOutcome) {
    let critical = run(&with(m, EXPLICIT, end, None), &mut Silent).unwrap().statistics.critical_step;
    let step = end / (parts * end / critical).ceil();
    let mut notes = Notes::default();
    let fast = run(&with(m, EXPLICIT, end, Some(step)), &mut notes).unwrap();
    let options = TransientAnalysis { scheme: NEWMARK, time_step: Some(step), ..TransientAnalysis::new(end) };
    let slow = dynamics::run(&twin(&with(m, EXPLICIT, end, None)), &options, None, &mut Silent).unwrap();
    let error = distance(&fast.state.u, &slow.state.u) / size(&slow.state.u);
    let (b, c) = (&fast.balance, &slow.balance);
    println!(
        "{} steps: displacement {error:.1e}; explicit: kinetic {:.3e}, strain {:.3e}, work {:.3e}, dissipated {:.3e}, \
         balance {:.1e} (largest {:.1e}); implicit: {:.3e} {:.3e} {:.3e} {:.3e}",
        fast.statistics.steps,
        b.kinetic,
        b.strain,
        b.work,
        b.dissipated,
        notes.drift() / fast.state.energy_scale,
        fast.statistics.energy_error,
        c.kinetic,
        c.strain,
        c.work,
        c.dissipated,
    );
    assert!(error < tolerance, "{error}");
    assert!(fast.statistics.energy_error < 0.01, "{}", fast.statistics.energy_error);
    assert!(slow.balance.kinetic + slow.balance.strain > 0.0);
    (fast, slow)
}

fn near(found: f64, expected: f64, relative: f64) {
    assert!((found / expected - 1.0).abs() < relative, "{found} for {expected}");
}

/// The clamp shakes along an inclined support; its reactions do all the work.
#[test]
fn supports_that_move_do_work() {
    let mut m = strip();
    for component in [Axis::X, Axis::Z] {
        m.conditions.push(Condition::Prescribe(PrescribeComponent {
            on: "u_max".into(),
            of: NodalVector::Position,
            component,
            value: 0.05,
            amplitude: Some("shake".into()),
        }));
    }
    let expression = ExpressionAmplitude { expression: "1 - cos(60*t)".into() };
    m.amplitudes.insert("shake".into(), Amplitude::Expression(expression));
    let (fast, slow) = against_newmark(&m, 8.0, 0.15, 5e-3);
    assert!(slow.balance.work > 0.5 * slow.state.energy_scale, "{:?}", slow.balance);
    near(fast.balance.work, slow.balance.work, 5e-3);
}

#[test]
fn damping_takes_energy() {
    let mut m = strip();
    m.damping.stiffness = 2e-3;
    m.damping.mass = 1.0;
    m.loads = vec![Load::Gravity(GravityLoad { value: [0.0, 0.0, -9.81], amplitude: None })];
    let (fast, slow) = against_newmark(&m, 4.0, 0.5, 1e-2);
    assert!(slow.balance.dissipated > 0.1 * slow.state.energy_scale, "{:?}", slow.balance);
    near(fast.balance.dissipated, slow.balance.dissipated, 2e-2);
}

/// Damping of strain rates lowers the critical step: what is chosen is stable, and it is needed.
#[test]
fn damping_of_strain_rates_lowers_the_step() {
    let mut m = strip();
    m.initial_velocities = vec![InitialVelocity {
        on: "all".into(),
        velocity: [0.0; 3],
        angular_velocity: [0.0, -0.5, 0.0],
        center: [0.0; 3],
    }];
    let free = run(&with(&m, EXPLICIT, 0.5, None), &mut Silent).unwrap().statistics.critical_step;
    m.damping.stiffness = 5e-3;
    let damped = run(&with(&m, EXPLICIT, 0.5, None), &mut Silent).unwrap();
    assert!(damped.statistics.critical_step < 0.7 * free, "{} {free}", damped.statistics.critical_step);
    assert!(damped.balance.kinetic < 0.5 * damped.state.energy_scale, "{:?}", damped.balance);
    let error = run(&with(&m, EXPLICIT, 0.5, Some(0.95 * free)), &mut Silent).unwrap_err();
    assert!(matches!(error, Error::Unstable { .. }), "{error}");
}

#[test]
#[ignore = "long"]
fn plastic_layers_dissipate() {
    let mut m = model(plate([1.0, 0.5], [4, 2], 0.2), 1e6, 0.05);
    let law = Plastic {
        young: 1e6,
        poisson: 0.3,
        yield_stress: 4e3,
        hardening: 2e4,
        saturation: None,
        saturation_rate: 0.0,
        kinematic: 0.0,
        density: 1e3,
        expansion: 0.0,
    };
    m.materials.insert("m".into(), Material::Plastic(law));
    for element in [ElementKind::Ems, ElementKind::Cm] {
        m.sections[0].element = element;
        m.initial_velocities = vec![InitialVelocity {
            on: "all".into(),
            velocity: [0.0; 3],
            angular_velocity: [0.0, -1.5, 0.0],
            center: [0.0; 3],
        }];
        let (fast, slow) = against_newmark(&m, 4.0, 0.4, 1e-2);
        assert!(slow.balance.dissipated > 0.05 * slow.state.energy_scale, "{:?}", slow.balance);
        near(fast.balance.dissipated, slow.balance.dissipated, 1e-2);
    }
}

/// A blown-up membrane of rubber under a pressure that follows it.
#[test]
#[ignore = "long"]
fn rubber_under_pressure() {
    let mut m = model(plate([1.0, 1.0], [4, 4], 0.1), 1.0, 0.02);
    let rubber = NeoHookean { shear: 4e5, bulk: 8e6, density: 1e3, form: Default::default() };
    m.materials.insert("m".into(), Material::NeoHookean(rubber));
    m.sections[0].element = ElementKind::Cm;
    m.conditions =
        ["u_min", "u_max", "v_min", "v_max"].map(|set| Condition::Clamp(OnSet { on: set.into() })).into();
    m.loads = vec![Load::Pressure(PressureLoad {
        on: "all".into(),
        value: -1.5e3,
        amplitude: None,
        distribution: None,
    })];
    let (fast, _) = against_newmark(&m, 4.0, 0.08, 1e-2);
    let top = fast.state.u.iter().map(|u| u[2]).reduce(larger).unwrap();
    assert!(top > 0.1, "the sheet bulges by {top}");
}

/// Two sheets at a right angle: the ties of their directors have no mass of their own.
#[test]
fn folds_move_as_with_implicit_steps() {
    for scale_director_inertia in [true, false] {
        let mesh = MeshSource::Extrusion(ExtrusionMesh {
            vertices: vec![[0.0, 0.0, 0.0], [0.6, 0.0, 0.0], [0.6, 0.0, 0.4]],
            sweep: [0.0, 0.3, 0.0],
            grid: Grid::uniform(8, 2),
        });
        let mut m = model(mesh, 1e6, 0.05);
        m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(1e6, 0.3, 1e3)));
        m.loads = vec![Load::Gravity(GravityLoad { value: [3.0, 0.0, -9.81], amplitude: None })];
        if scale_director_inertia {
            against_newmark(&m, 4.0, 0.3, 1e-2);
        } else {
            let scheme = Scheme::Explicit(ExplicitScheme { scale_director_inertia });
            let outcome = run(&with(&m, scheme, 0.3, None), &mut Silent).unwrap();
            assert!(outcome.statistics.energy_error < 0.01, "{}", outcome.statistics.energy_error);
        }
    }
}

#[test]
fn what_cannot_be_lumped_is_refused_with_a_remedy() {
    let mut refused = Vec::new();
    for change in ["mitc4", "ancf-full", "offset"] {
        let mut m = with(&strip(), EXPLICIT, 0.1, None);
        match change {
            "mitc4" => m.sections[0].element = ElementKind::Mitc4,
            "ancf-full" => m.sections[0].element = ElementKind::AncfFull,
            _ => {
                m.sections[0].layup = Some(Layup {
                    plies: vec![LayupPly { material: Some("m".into()), angle: 0.0, thickness: Some(0.05) }],
                    offset: 0.02,
                    ..Layup::default()
                });
                (m.sections[0].material, m.sections[0].thickness) = (String::new(), 0.0);
            }
        }
        let mesh = generate(&m.mesh).unwrap();
        let Err(Error::Model(issues)) = build(&m, &mesh) else { panic!("{change} is taken") };
        assert_eq!((issues.len(), issues[0].place.key.as_str()), (1, "analysis.scheme"), "{issues:?}");
        assert!(issues[0].help.contains("`newmark`"), "{issues:?}");
        refused.push(issues[0].message.clone());
    }
    for (message, word) in refused.iter().zip(["inextensible", "gradient", "mid-surface"]) {
        assert!(message.contains(word), "{message}");
    }
}

/// A system knows for which kind of integration it was compiled.
#[test]
fn a_system_of_the_other_kind_is_an_error() {
    for (compiled, run_with) in [(EXPLICIT, NEWMARK), (NEWMARK, EXPLICIT)] {
        let (_, system) = compile(&with(&strip(), compiled, 0.1, None));
        let options = TransientAnalysis { scheme: run_with, ..TransientAnalysis::new(0.1) };
        let error = dynamics::run(&system, &options, None, &mut Silent).unwrap_err();
        assert!(matches!(error, Error::Model(_)), "{error}");
        assert!(error.to_string().contains("compile the model with the analysis, the scheme"), "{error}");
    }
}

/// Asks to stop after a number of reports and keeps the last state.
struct Stop(u32, Cell<u32>, Option<State>);

impl Observer for Stop {
    fn on_step(&mut self, step: &Step) -> Result<()> {
        self.1.set(self.1.get() + 1);
        self.2 = Some(step.state.clone());
        Ok(())
    }

    fn interrupted(&self) -> bool {
        self.1.get() >= self.0
    }
}

/// An interrupted run ends with a report, and restarts from there with identical bits.
#[test]
fn an_interrupted_run_goes_on_where_it_was() {
    let mut m = strip();
    m.damping.stiffness = 1e-3;
    m.loads = vec![Load::Gravity(GravityLoad { value: [0.0, 0.0, -1.0], amplitude: None })];
    m.conditions.push(Condition::Prescribe(PrescribeComponent {
        on: "u_max_v_max".into(),
        of: NodalVector::Position,
        component: Axis::Y,
        value: 0.02,
        amplitude: Some("move".into()),
    }));
    let expression = ExpressionAmplitude { expression: "1 - cos(20*t)".into() };
    m.amplitudes.insert("move".into(), Amplitude::Expression(expression));
    let m = with(&m, EXPLICIT, 0.8, None);
    let whole = run(&m, &mut Silent).unwrap().state;
    assert!(whole.step > 220, "{}", whole.step);
    let mut stop = Stop(16, Cell::new(0), None);
    assert!(matches!(run(&m, &mut stop), Err(Error::Interrupted)));
    let part = stop.2.unwrap();
    assert_eq!(part.step, 150);
    let (_, system) = compile(&m);
    let Analysis::Transient(t) = &m.analysis else { unreachable!() };
    let rest = dynamics::run(&system, t, Some(part), &mut Silent).unwrap().state;
    assert_eq!(rest, whole);
}
