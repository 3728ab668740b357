//! Analyses that follow one another: each starts where the one before has ended.

use std::f64::consts::PI;

use tegula::analysis::{Observer, Silent, State, Step, dynamics, modal, statics};
use tegula::compile::{Compiler, steps, warnings_before_start};
use tegula::mesh::generators::generate;
use tegula::model::{
    Amplitude, Analysis, AnalysisStep, Axis, Condition, ElementKind, EnergyMomentumScheme, ExplicitScheme,
    FixComponents, GravityLoad, HhtScheme, InitialVelocity, Isotropic, Load, Material, ModalAnalysis, Model,
    NaturalStrain, NodalVector, OnSet, Plastic, PrescribeComponent, PrescribedStrain, PressureLoad, Scheme,
    StaticAnalysis, SymmetryPlane, TableAmplitude, TransientAnalysis, VectorLoad,
};
use tegula::norm::{larger, max_norm};
use tegula::result::ReactionFinder;
use tegula::{Error, System};

use crate::common::{on, plate, vector_load};

const LENGTH: f64 = 1.0;
const WIDTH: f64 = 0.1;
const THICKNESS: f64 = 0.01;
const YOUNG: f64 = 1e9;
const DENSITY: f64 = 1000.0;
/// Strain of the preload.
const STRAIN: f64 = 2e-3;

fn stretched(of: f64) -> Condition {
    Condition::Prescribe(PrescribeComponent {
        on: "u_max".into(),
        of: NodalVector::Position,
        component: Axis::X,
        value: of,
        amplitude: None,
    })
}

/// A strip between two hinges, the right one of which is pulled.
fn strip(steps: Vec<AnalysisStep>) -> Model {
    let analysis = Analysis::Static(StaticAnalysis::default());
    let mut model = Model::new(
        plate([LENGTH, WIDTH], [32, 2], 0.0),
        analysis,
        Isotropic::new(YOUNG, 0.0, DENSITY),
        THICKNESS,
    );
    let across = FixComponents { on: "u_max".into(), position: vec![Axis::Y, Axis::Z], director: Vec::new() };
    model.conditions = vec![
        Condition::Hinge(OnSet { on: "u_min".into() }),
        stretched(STRAIN * LENGTH),
        Condition::Fix(across),
    ];
    model.steps = steps;
    model
}

fn at_rest(name: &str) -> AnalysisStep {
    AnalysisStep::new(name, Analysis::Static(StaticAnalysis::default()))
}

fn transient(name: &str, end: f64, dt: f64) -> AnalysisStep {
    let options = TransientAnalysis { time_step: Some(dt), ..TransientAnalysis::new(end) };
    AnalysisStep::new(name, Analysis::Transient(options))
}

fn modes(name: &str) -> AnalysisStep {
    AnalysisStep::new(name, Analysis::Modal(ModalAnalysis::new(3)))
}

/// Runs all steps; `look` gets the number of the step, its system and each of its states.
fn run(model: &Model, mut look: impl FnMut(usize, &System, &State)) -> Result<Vec<State>, Error> {
    struct Look<'a, F>(usize, &'a System, &'a mut F);
    impl<F: FnMut(usize, &System, &State)> Observer for Look<'_, F> {
        fn on_step(&mut self, step: &Step) -> tegula::Result<()> {
            (self.2)(self.0, self.1, step.state);
            Ok(())
        }
    }
    let mesh = generate(&model.mesh)?;
    let compiler = Compiler::new(model, &mesh)?;
    let mut ends: Vec<State> = Vec::new();
    for (i, step) in compiler.steps().iter().enumerate() {
        let before = step.starts_from.map(|b| &ends[b]);
        let system = compiler.system(i, before.map(State::end_of_step))?;
        let mut observer = Look(i, &system, &mut look);
        let end = match &step.model.analysis {
            Analysis::Static(options) => statics::run(&system, options, None, &mut observer)?.state,
            Analysis::Transient(options) => dynamics::run(&system, options, None, &mut observer)?.state,
            Analysis::Path(_) | Analysis::Modal(_) | Analysis::Buckling(_) => State::default(),
        };
        ends.push(end);
    }
    Ok(ends)
}

/// Circular frequency of the hinged strip under its tension: ω² = (π/L)² (N + EI (π/L)²)/(ρA).
fn exact() -> f64 {
    let (area, k) = (WIDTH * THICKNESS, PI / LENGTH);
    let bending = YOUNG * WIDTH * THICKNESS.powi(3) / 12.0;
    let tension = YOUNG * (STRAIN + 0.5 * STRAIN * STRAIN) * area * (1.0 + STRAIN);
    // The stretched strip is longer, and its mass per length smaller.
    (k * k / (1.0 + STRAIN).powi(2) * (tension + bending * k * k) / (DENSITY * area / (1.0 + STRAIN))).sqrt()
}

/// Amplitude of a mode in a field: φ·M u.
fn amplitude(system: &System, mode: &[[f64; 3]], u: &[[f64; 3]]) -> f64 {
    let mut momentum = vec![[0.0; 3]; u.len()];
    system.pattern.add_mass_product(1.0, u, &mut momentum);
    tegula::system::dot(mode, &momentum)
}

/// Circular frequency of samples at equal steps: from the first and the last passage upwards through zero.
fn frequency(samples: &[(f64, f64)]) -> f64 {
    let upwards = |w: &&[(f64, f64)]| w[0].1 < 0.0 && w[1].1 >= 0.0;
    let zeros: Vec<f64> = samples
        .windows(2)
        .filter(upwards)
        .map(|w| w[0].0 - w[0].1 * (w[1].0 - w[0].0) / (w[1].1 - w[0].1))
        .collect();
    assert!(zeros.len() > 3, "{zeros:?}");
    2.0 * PI * (zeros.len() - 1) as f64 / (zeros[zeros.len() - 1] - zeros[0])
}

#[test]
#[ignore = "long"]
fn a_preloaded_strip_vibrates_at_the_frequency_of_its_mode() {
    for element in [ElementKind::Ems, ElementKind::Mitc4] {
        let pluck = AnalysisStep {
            loads: vec![Load::Traction(vector_load("all", [0.0, 0.0, 0.1]))],
            ..at_rest("pluck")
        };
        let period = 2.0 * PI / exact();
        let free = transient("free", 6.0 * period, period / 400.0);
        let mut model = strip(vec![at_rest("preload"), modes("modes"), pluck, free]);
        model.sections[0].element = element;
        let mesh = generate(&model.mesh).unwrap();
        let compiler = Compiler::new(&model, &mesh).unwrap();
        let names: Vec<_> = compiler.steps().iter().map(|s| (s.name.as_str(), s.starts_from)).collect();
        assert_eq!(names, [("preload", None), ("modes", Some(0)), ("pluck", Some(0)), ("free", Some(2))]);
        let mut mode = None;
        let mut samples = Vec::new();
        run(&model, |step, system, state| match step {
            0 if state.time == 1.0 => {
                let modal_system = compiler.system(1, Some(state.end_of_step())).unwrap();
                let found = modal::run(&modal_system, 3, Some(state), &mut Silent).unwrap();
                mode = Some((found.modes[0].omega, found.modes[0].shape.clone(), state.u.clone()));
            }
            3 => {
                let (_, shape, about) = mode.as_ref().unwrap();
                let u: Vec<_> =
                    state.u.iter().zip(about).map(|(u, a)| std::array::from_fn(|i| u[i] - a[i])).collect();
                samples.push((state.time, amplitude(system, shape, &u)));
            }
            _ => {}
        })
        .unwrap();
        let omega = mode.unwrap().0;
        assert!((omega / exact() - 1.0).abs() < 2e-3, "{element:?}: {omega} for {}", exact());
        // Newmark's method with 400 steps to a period makes it longer by (ω Δt)²/24 = 1e-5.
        let measured = frequency(&samples);
        assert!((measured / omega - 1.0).abs() < 2e-4, "{element:?}: {measured} for {omega}");
        assert!(samples[0].1.abs() > 1e-9, "{:?}", samples[0]);
    }
}

/// Largest difference of two fields over the largest entry of the first.
fn difference(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let size = max_norm(a.as_flattened());
    max_norm(a.as_flattened().iter().zip(b.as_flattened()).map(|(x, y)| x - y)) / size
}

/// A cantilever under large bending.
fn cantilever(steps: Vec<AnalysisStep>) -> Model {
    let mut model = strip(steps);
    model.conditions = vec![Condition::Clamp(on("u_min"))];
    model
}

fn with_loads(name: &str, loads: &[Load]) -> AnalysisStep {
    AnalysisStep { loads: loads.to_vec(), ..at_rest(name) }
}

#[test]
fn loads_continue_grow_and_fall_from_step_to_step() {
    let down = Load::Edge(vector_load("u_max", [0.0, 0.0, -20.0]));
    let along = Load::Edge(vector_load("u_max", [30.0, 0.0, 0.0]));
    let pressure =
        Load::Pressure(PressureLoad { on: "all".into(), value: 25.0, amplitude: None, distribution: None });
    let at_once =
        |loads: &[Load]| run(&cantilever(vec![with_loads("", loads)]), |_, _, _| {}).unwrap().remove(0).u;
    let steps = vec![
        with_loads("a", std::slice::from_ref(&down)),
        with_loads("b", &[pressure.clone(), down.clone()]),
        with_loads("c", &[along.clone(), pressure.clone()]),
        with_loads("d", &[]),
    ];
    let mut moved = [0; 4];
    let ends = run(&cantilever(steps), |step, _, _| moved[step] += 1).unwrap();
    assert!(difference(&at_once(std::slice::from_ref(&down)), &ends[0].u) < 1e-9);
    assert!(difference(&at_once(&[down, pressure.clone()]), &ends[1].u) < 1e-8);
    assert!(difference(&at_once(&[along, pressure]), &ends[2].u) < 1e-8);
    let rest = max_norm(ends[3].u.as_flattened());
    assert!(rest < 1e-9, "{rest}");
    assert!(moved.iter().all(|&n| n >= 1), "{moved:?}");
}

#[test]
fn what_is_fixed_in_a_later_step_stays_where_it_is() {
    for element in [ElementKind::Ems, ElementKind::Mitc4] {
        let load = Load::Edge(vector_load("u_max", [0.0, 0.0, -20.0]));
        let held = AnalysisStep { conditions: vec![Condition::Clamp(on("u_max"))], ..at_rest("held") };
        let back = with_loads("back", std::slice::from_ref(&load));
        let mut model = cantilever(vec![with_loads("bend", &[load]), held, back]);
        model.sections[0].element = element;
        let mut pull = 0.0;
        let ends = run(&model, |step, system, state| {
            if step == 1 {
                let forces = statics::reactions(system, &mut tegula::system::Assembly::new(system), state);
                let nodes = generate(&model.mesh).unwrap().nodes_on("u_max").unwrap();
                pull = nodes
                    .iter()
                    .map(|&n| forces[system.coordinates.position_of[n as usize] as usize][2])
                    .sum();
            }
        })
        .unwrap();
        assert!(difference(&ends[0].u, &ends[1].u) < 1e-9, "{element:?}");
        assert!((pull / (-20.0 * WIDTH) - 1.0).abs() < 1e-6, "{element:?}: {pull}");
        assert!(difference(&ends[0].u, &ends[2].u) < 1e-8, "{element:?}");
    }
}

#[test]
#[ignore = "long"]
fn a_motion_in_two_steps_is_the_motion_in_one() {
    let gravity = Load::Gravity(GravityLoad { value: [0.0, 0.0, -9.81], amplitude: None });
    for scheme in [
        Scheme::default(),
        Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 }),
        Scheme::Explicit(ExplicitScheme::default()),
    ] {
        let (end, dt) = (0.02, if matches!(scheme, Scheme::Explicit(_)) { None } else { Some(2.5e-5) });
        let motion = |end: f64| {
            let options = TransientAnalysis { scheme, time_step: dt, ..TransientAnalysis::new(end) };
            AnalysisStep {
                loads: vec![gravity.clone()],
                ..AnalysisStep::new("", Analysis::Transient(options))
            }
        };
        let turn = InitialVelocity {
            on: "all".into(),
            velocity: [0.0; 3],
            angular_velocity: [0.0, 3.0, 0.0],
            center: [0.0; 3],
        };
        let first = |end: f64| AnalysisStep { initial_velocities: vec![turn.clone()], ..motion(end) };
        let mut model = cantilever(vec![first(end)]);
        model.conditions = vec![Condition::Hinge(on("u_min"))];
        let whole = run(&model, |_, _, _| {}).unwrap();
        model.steps = vec![first(0.4 * end), motion(0.6 * end)];
        let parts = run(&model, |_, _, _| {}).unwrap();
        let error = difference(&whole[0].u, &parts[1].u);
        assert!(error < 2e-6, "{scheme:?}: {error}");
        let velocity = difference(&whole[0].v, &parts[1].v);
        assert!(velocity < 1e-3, "{scheme:?}: {velocity}");
    }
}

#[test]
fn plastic_strains_and_heat_are_carried_from_step_to_step() {
    let load = Load::Edge(vector_load("u_max", [0.0, 0.0, -25.0]));
    let heat = PrescribedStrain::Natural(NaturalStrain {
        distribution: None,
        on: "all".into(),
        strain: [1e-3, 0.0, 0.0],
        curvature: [0.1, 0.0, 0.0],
        direction: [1.0, 0.0, 0.0],
        amplitude: None,
    });
    let plastic = |steps: Vec<AnalysisStep>| {
        let mut model = cantilever(steps);
        model.materials.insert(
            "m".into(),
            Material::Plastic(Plastic {
                young: YOUNG,
                poisson: 0.0,
                yield_stress: 1e6,
                hardening: 1e8,
                saturation: None,
                saturation_rate: 0.0,
                kinematic: 0.0,
                density: DENSITY,
                expansion: 0.0,
            }),
        );
        model
    };
    // One step: the load rises and falls by a table.
    let mut cycle = plastic(vec![]);
    cycle.loads = vec![Load::Edge(VectorLoad {
        amplitude: Some("cycle".into()),
        ..vector_load("u_max", [0.0, 0.0, -25.0])
    })];
    let table = TableAmplitude { times: vec![0.0, 0.5, 1.0], values: vec![0.0, 1.0, 0.0] };
    cycle.amplitudes.insert("cycle".into(), Amplitude::Table(table));
    cycle.analysis = Analysis::Static(StaticAnalysis { load_steps: 8, ..StaticAnalysis::default() });
    let expected = run(&cycle, |_, _, _| {}).unwrap().remove(0);
    let four = |name: &str, loads: &[Load]| AnalysisStep {
        loads: loads.to_vec(),
        ..AnalysisStep::new(
            name,
            Analysis::Static(StaticAnalysis { load_steps: 4, ..StaticAnalysis::default() }),
        )
    };
    let ends = run(&plastic(vec![four("up", std::slice::from_ref(&load)), four("down", &[])]), |_, _, _| {})
        .unwrap();
    let left = max_norm(expected.u.as_flattened());
    assert!(left > 1e-3, "{left}");
    assert!(difference(&expected.u, &ends[1].u) < 1e-6);
    // Heat of the second step only goes again in the third; without yield nothing is left.
    let warm = AnalysisStep { prescribed_strains: vec![heat], ..at_rest("warm") };
    let ends = run(&cantilever(vec![warm, at_rest("cold again")]), |_, _, _| {}).unwrap();
    // Bent to a circle of curvature 0.1, whose end turns by 0.1 and rises by 0.05.
    let size = |s: &State| max_norm(s.u.as_flattened());
    assert!((size(&ends[0]) - 0.1).abs() < 2e-3, "{}", size(&ends[0]));
    assert!(size(&ends[1]) < 1e-9, "{}", size(&ends[1]));
}

#[test]
fn an_analysis_on_a_system_of_another_one_is_refused() {
    let model = strip(vec![at_rest("preload"), transient("free", 0.1, 0.01)]);
    let mesh = generate(&model.mesh).unwrap();
    let compiler = Compiler::new(&model, &mesh).unwrap();
    let [at_rest, moving] = [0, 1].map(|i| compiler.system(i, None).unwrap());
    let refused = |error: Error| error.to_string().contains("the system was compiled for a");
    assert!(statics::run(&moving, &StaticAnalysis::default(), None, &mut Silent).is_err_and(refused));
    let options = TransientAnalysis::new(0.1);
    assert!(dynamics::run(&at_rest, &options, None, &mut Silent).is_err_and(refused));
    let explicit = TransientAnalysis { scheme: Scheme::Explicit(ExplicitScheme::default()), ..options };
    assert!(dynamics::run(&moving, &explicit, None, &mut Silent).is_err_and(refused));
}

#[test]
fn mistakes_in_steps_are_named_at_their_keys() {
    let load = Load::Force(vector_load("nowhere", [1.0; 3]));
    let mut model = strip(vec![
        with_loads("a", std::slice::from_ref(&load)),
        transient("b", 0.1, 0.01),
        at_rest("c"),
        AnalysisStep { loads: vec![load], ..modes("d/") },
    ]);
    model.output.at = vec![0.5];
    let mesh = generate(&model.mesh).unwrap();
    let Err(Error::Model(issues)) = Compiler::new(&model, &mesh) else { panic!("accepted") };
    let mut keys: Vec<_> = issues.iter().map(|i| i.place.key.as_str()).collect();
    keys.sort_unstable();
    assert_eq!(
        keys,
        [
            "output.at",
            "steps[0].loads[0].on",
            "steps[2].analysis.type",
            "steps[3].analysis.type",
            "steps[3].name",
        ]
    );
    let first = &steps(&model)[1];
    assert_eq!(first.key("loads[1].value"), "loads[1].value");
    assert_eq!(first.key("analysis.end_time"), "steps[1].analysis.end_time");

    let late = AnalysisStep { at: vec![0.5], ..modes("modes") };
    let endless = transient("endless", 1e30, 0.01);
    let model = strip(vec![at_rest("a"), late, endless]);
    let Err(Error::Model(issues)) = Compiler::new(&model, &mesh) else { panic!("accepted") };
    let keys: Vec<_> = issues.iter().map(|i| i.place.key.as_str()).collect();
    assert_eq!(keys, ["steps[1].at", "steps[2].analysis.time_step"]);
}

#[test]
fn supports_that_a_static_step_releases_let_go_with_the_load_factor() {
    for element in [ElementKind::Ems, ElementKind::Mitc4] {
        let pushed = Condition::Prescribe(PrescribeComponent {
            on: "u_max".into(),
            of: NodalVector::Position,
            component: Axis::Z,
            value: 0.6 * LENGTH,
            amplitude: None,
        });
        let push = AnalysisStep { conditions: vec![pushed], ..steps_of("push", 10) };
        let mut model = cantilever(vec![push, steps_of("let go", 4)]);
        model.sections[0].element = element;
        let mesh = generate(&model.mesh).unwrap();
        let tip = mesh.nodes_on("u_max").unwrap()[1];
        let (mut path, mut left, mut balance) = (Vec::new(), Vec::new(), Vec::new());
        let ends = run(&model, |step, system, state| {
            let z = state.u[system.coordinates.position_of[tip as usize] as usize][2];
            if step == 1 {
                path.push((state.time, z));
                let forces = ReactionFinder::new(system, None).find(system, None, state);
                let set = system.load_sets.iter().position(|set| set.name == "released").unwrap();
                left.push(forces.loads[set].force.z);
                balance.push(larger(forces.force_error, forces.moment_error));
            }
        })
        .unwrap();
        // The reaction that is left falls in proportion, it is a load of the history, and forces balance in each step, also
        // where there are none any more.
        for (share, force) in [0.75, 0.5, 0.25].into_iter().zip(&left) {
            assert!((force / left[0] * 0.75 - share).abs() < 1e-12 && *force > 0.0, "{element:?}: {left:?}");
        }
        assert!(balance.iter().all(|&error| error < 1e-6), "{element:?}: {balance:?}");
        assert_eq!(path.len(), 4, "{element:?}: {path:?}");
        let half = path[1].1;
        assert!(half > 0.2 && half < 0.5, "{element:?}: {path:?}");
        assert!(max_norm(ends[1].u.as_flattened()) < 1e-8, "{element:?}");
    }
}

#[test]
fn steps_that_keep_their_supports_release_nothing() {
    let load = Load::Edge(vector_load("u_max", [0.0, 0.0, -20.0]));
    let push = AnalysisStep { loads: vec![load.clone()], ..steps_of("push", 2) };
    let again = AnalysisStep { loads: vec![load], ..steps_of("again", 2) };
    let model = cantilever(vec![push, steps_of("unload", 2), again]);
    run(&model, |_, system, _| assert!(system.load_sets.iter().all(|set| set.name != "released"))).unwrap();
    let mesh = generate(&model.mesh).unwrap();
    let compiler = Compiler::new(&model, &mesh).unwrap();
    assert!(compiler.system(1, Some(tegula::system::StepStart::default())).is_err());
}

fn steps_of(name: &str, load_steps: u32) -> AnalysisStep {
    AnalysisStep::new(name, Analysis::Static(StaticAnalysis { load_steps, ..StaticAnalysis::default() }))
}

#[test]
fn a_load_with_another_amplitude_is_the_same_load() {
    let load = |name: Option<&str>| {
        let amplitude = name.map(str::to_owned);
        Load::Edge(VectorLoad { amplitude, ..vector_load("u_max", [0.0, 0.0, -20.0]) })
    };
    let heat = |name: Option<&str>| {
        PrescribedStrain::Natural(NaturalStrain {
            distribution: None,
            on: "all".into(),
            strain: [1e-3, 0.0, 0.0],
            curvature: [0.1, 0.0, 0.0],
            direction: [1.0, 0.0, 0.0],
            amplitude: name.map(str::to_owned),
        })
    };
    let step = |name: Option<&str>| AnalysisStep {
        loads: vec![load(name)],
        prescribed_strains: vec![heat(name)],
        ..steps_of("", 2)
    };
    let mut model = cantilever(vec![step(None), step(Some("down")), step(Some("half"))]);
    for (name, values) in [("down", vec![1.0, 0.0]), ("half", vec![0.5, 0.5])] {
        let table = TableAmplitude { times: vec![0.0, 1.0], values };
        model.amplitudes.insert(name.into(), Amplitude::Table(table));
    }
    let mesh = generate(&model.mesh).unwrap();
    let compiler = Compiler::new(&model, &mesh).unwrap();
    let systems = [0, 1, 2].map(|i| compiler.system(i, None).unwrap());
    assert!(systems.iter().all(|s| s.dead_loads.len() == 1 && s.prescribed_strains.len() == 1));
    assert_eq!(systems.each_ref().map(System::first_load_factor), [0.0, 0.0, -1.0]);
    let mut times = Vec::new();
    let ends = run(&model, |step, _, state| times.push((step, state.time))).unwrap();
    let expected = [(0, 0.5), (0, 1.0), (1, 0.5), (1, 1.0), (2, -0.5), (2, 0.0), (2, 0.5), (2, 1.0)];
    assert_eq!(times, expected);
    assert!(max_norm(ends[1].u.as_flattened()) < 1e-9);
    let mut one = cantilever(vec![]);
    one.loads = vec![Load::Edge(vector_load("u_max", [0.0, 0.0, -10.0]))];
    let PrescribedStrain::Natural(mut half) = heat(None) else { unreachable!() };
    (half.strain, half.curvature) = (half.strain.map(|x| 0.5 * x), half.curvature.map(|x| 0.5 * x));
    one.prescribed_strains = vec![PrescribedStrain::Natural(half)];
    let alone = run(&one, |_, _, _| {}).unwrap();
    assert!(difference(&alone[0].u, &ends[2].u) < 1e-8);
}

#[test]
fn a_preloaded_structure_in_equilibrium_stays_at_rest() {
    let pressure =
        Load::Pressure(PressureLoad { on: "all".into(), value: -2e4, amplitude: None, distribution: None });
    for scheme in [
        Scheme::default(),
        Scheme::Hht(HhtScheme { alpha: -0.05 }),
        Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 }),
        Scheme::Explicit(ExplicitScheme::default()),
    ] {
        for damped in [false, true] {
            let explicit = matches!(scheme, Scheme::Explicit(_));
            let dt = if explicit { None } else { Some(2e-3) };
            let end = if explicit { 1e-3 } else { 2e-2 };
            let rest = TransientAnalysis { scheme, time_step: dt, ..TransientAnalysis::new(end) };
            let mut model = crate::common::quarter_cylinder(8, 2.1e11);
            model.conditions =
                [("u_min", [1.0, 0.0, 0.0]), ("u_max", [0.0, 0.0, 1.0]), ("v_min", [0.0, 1.0, 0.0])]
                    .map(|(on, normal)| Condition::Symmetry(SymmetryPlane { on: on.into(), normal }))
                    .to_vec();
            model.loads = vec![pressure.clone()];
            model.materials.insert("m".into(), Material::Isotropic(Isotropic::new(2.1e11, 0.3, 7850.0)));
            if damped {
                (model.damping.mass, model.damping.stiffness) = (2.0, 1e-5);
            }
            model.steps = vec![at_rest("inflate"), AnalysisStep::new("rest", Analysis::Transient(rest))];
            let mut count = 0;
            let ends = run(&model, |step, _, _| count += usize::from(step == 1)).unwrap();
            assert!(difference(&ends[0].u, &ends[1].u) < 1e-9, "{scheme:?}");
            if !explicit {
                assert_eq!(count, 11, "{scheme:?}, damped {damped}: steps were cut back");
            }
        }
    }
}

#[test]
fn modes_of_linear_steps_come_with_a_warning() {
    let linear = Analysis::Static(StaticAnalysis { linear: true, ..StaticAnalysis::default() });
    for (analysis, warned) in [(linear, 1), (at_rest("").analysis, 0)] {
        let model = strip(vec![AnalysisStep::new("preload", analysis), modes("modes")]);
        let mesh = generate(&model.mesh).unwrap();
        let compiler = Compiler::new(&model, &mesh).unwrap();
        let step = &compiler.steps()[1];
        let found = warnings_before_start(step, &mesh, &compiler.system(1, None).unwrap());
        assert_eq!(found.len(), warned, "{found:?}");
        assert!(found.iter().all(|w| w.place.key == "steps[1].analysis" && w.message.contains("unloaded")));
    }
}

/// Linear steps are linear: motions and modes after a linear static step scale with its load, also where directors keep their
/// length.
#[test]
fn linear_steps_scale_with_the_load_before_them() {
    let linear = StaticAnalysis { linear: true, ..StaticAnalysis::default() };
    for element in [ElementKind::Ems, ElementKind::Mitc4] {
        let after = |size: f64| {
            let load = Load::Edge(vector_load("u_max", [0.0, 0.0, size]));
            let mut shake = transient("shake", 0.1, 1e-3);
            if let Analysis::Transient(options) = &mut shake.analysis {
                options.linear = true;
            }
            let push = AnalysisStep {
                loads: vec![load],
                ..AnalysisStep::new("push", Analysis::Static(linear.clone()))
            };
            let mut model = cantilever(vec![push, modes("modes"), shake]);
            model.sections[0].element = element;
            let mut lowest = 0.0;
            let mesh = generate(&model.mesh).unwrap();
            let ends = run(&model, |_, _, _| {}).unwrap();
            let compiler = Compiler::new(&model, &mesh).unwrap();
            let system = compiler.system(1, Some(ends[0].end_of_step())).unwrap();
            for mode in modal::run(&system, 1, None, &mut Silent).unwrap().modes {
                lowest = mode.omega;
            }
            (ends[2].u.as_flattened().iter().map(|u| u / size).collect::<Vec<f64>>(), lowest)
        };
        let ((small, slow), (large, fast)) = (after(1e-3), after(1e12));
        let off = max_norm(small.iter().zip(&large).map(|(a, b)| a - b)) / max_norm(&small);
        assert!(off < 1e-7, "{element:?}: {off:e}");
        assert!((fast / slow - 1.0).abs() < 1e-9, "{element:?}: {slow} {fast}");
    }
}

/// A strip compressed to 3.9 times Euler's strain, straight: its first mode grows by `ω² = ω₁² (1 − 3.9)`, written as a negative frequency, and the modes
/// do not depend on how many of them are wanted.
#[test]
fn modes_about_an_unstable_equilibrium_do_not_depend_on_their_number() {
    let critical = (PI * THICKNESS / LENGTH).powi(2) / 12.0;
    let mut preload = at_rest("preload");
    preload.analysis = Analysis::Static(StaticAnalysis { allow_unstable: true, ..StaticAnalysis::default() });
    let mut model = strip(vec![preload, modes("modes")]);
    model.conditions[1] = stretched(-3.9 * critical * LENGTH);
    let mesh = generate(&model.mesh).unwrap();
    let compiler = Compiler::new(&model, &mesh).unwrap();
    let system = compiler.system(0, None).unwrap();
    let Analysis::Static(options) = &compiler.steps()[0].model.analysis else { panic!() };
    let end = statics::run(&system, options, None, &mut Silent).unwrap().state;
    let system = compiler.system(1, Some(State::end_of_step(&end))).unwrap();
    let found = |wanted: u32| -> Vec<f64> {
        let modes = modal::run(&system, wanted as usize, Some(&end), &mut Silent).unwrap().modes;
        modes.iter().map(|mode| mode.omega).collect()
    };
    let first = (PI / LENGTH).powi(2) * THICKNESS * (YOUNG / (12.0 * DENSITY)).sqrt();
    let all = found(8);
    assert!((all[0] / (-(2.9_f64.sqrt()) * first) - 1.0).abs() < 0.01, "{} {first}", all[0]);
    for wanted in [1, 2, 3, 5] {
        for (a, b) in found(wanted).iter().zip(&all) {
            assert!((a / b - 1.0).abs() < 1e-6, "{wanted}: {a} {b}");
        }
    }
}
