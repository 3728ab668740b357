//! Static analyses with the iterative linear solver against the direct one.

use crate::common::{Notes, irregular, model, plate, quarter_cylinder, static_options, vector_load};
use tegula::analysis::statics::{self, StaticOutcome};
use tegula::compile::{build, check};
use tegula::mesh::generators::generate;
use tegula::model::*;
use tegula::norm::max_norm;
use tegula::{Error, Mesh, Result};

const ITERATIVE: LinearSolver = LinearSolver::Iterative;

fn run_on(
    mesh: &Mesh,
    model: &Model,
    linear_solver: LinearSolver,
    notes: &mut Notes,
) -> Result<StaticOutcome> {
    let options = StaticAnalysis { linear_solver, ..static_options(model) };
    let model = Model { analysis: Analysis::Static(options.clone()), ..model.clone() };
    statics::run(&build(&model, mesh)?, &options, None, notes)
}

fn run(model: &Model, solver: LinearSolver) -> Result<StaticOutcome> {
    run_on(&generate(&model.mesh).unwrap(), model, solver, &mut Notes::default())
}

/// Largest difference of displacements relative to the largest displacement. With `may_cut` the iterative solver may meet
/// a tangent that is not positive definite on the way, and take shorter load steps.
fn difference(mesh: &Mesh, model: &Model, may_cut: bool) -> f64 {
    let mut notes = Notes::default();
    let direct = run_on(mesh, model, LinearSolver::Direct, &mut Notes::default()).unwrap();
    let iterative = run_on(mesh, model, ITERATIVE, &mut notes).unwrap();
    // Solutions for the skew stiffness of follower loads count, too.
    let extra = direct.statistics.linear_iterations;
    let follows = |l: &Load| matches!(l, Load::Pressure(_) | Load::Moment(_) | Load::EdgeMoment(_));
    assert!(extra < if model.loads.iter().any(follows) { 20 } else { 1 }, "{extra}");
    assert!(iterative.statistics.linear_iterations > 0);
    let (a, b) = (direct.statistics.iterations, iterative.statistics.iterations);
    let cut = iterative.statistics.cutbacks > 0;
    assert!(direct.statistics.cutbacks == 0 && (may_cut || !cut), "{:?}", iterative.statistics);
    assert!(notes.events.iter().all(|e| e.contains("positive definite")), "{:?}", notes.events);
    // The iteration does not notice.
    assert!(cut || a.abs_diff(b) <= 1, "{a} iterations, {b}");
    let all = |o: &StaticOutcome| o.state.u.as_flattened().to_vec();
    let (a, b) = (all(&direct), all(&iterative));
    max_norm(a.iter().zip(&b).map(|(x, y)| x - y)) / max_norm(&a)
}

fn same(model: &Model) {
    let off = difference(&generate(&model.mesh).unwrap(), model, false);
    assert!(off < 1e-9, "{off:e}");
}

fn linear(mut model: Model) -> Model {
    model.analysis = Analysis::Static(StaticAnalysis { linear: true, ..Default::default() });
    model
}

/// A channel: two flanges on a web, clamped at one end and pulled sideways at the other.
fn folded(n: u32) -> Model {
    let mesh = MeshSource::Extrusion(ExtrusionMesh {
        vertices: vec![[0.0, 0.0, 0.2], [0.0, 0.0, 0.0], [0.0, 0.4, 0.0], [0.0, 0.4, 0.2]],
        sweep: [1.0, 0.0, 0.0],
        grid: Grid::uniform(n, n),
    });
    let mut m = model(mesh, 2.1e11, 0.004);
    m.conditions = vec![Condition::Clamp(OnSet { on: "v_min".into() })];
    m.loads = vec![Load::Edge(vector_load("v_max", [0.0, 10.0, 3.0]))];
    m
}

#[test]
#[ignore = "long"]
fn plates_cylinders_and_folds_agree_with_the_direct_solver() {
    for slenderness in [10.0, 100.0, 1000.0] {
        for curved in [false, true] {
            let mut m = if curved {
                quarter_cylinder(40, 2.1e11)
            } else {
                model(plate([1.0, 1.0], [36, 40], 0.2), 2.1e11, 0.01)
            };
            m.sections[0].thickness = 1.0 / slenderness;
            m.loads = vec![Load::Edge(vector_load("u_max", [0.0, 1.0, -1.0]))];
            same(&linear(m));
        }
    }
    same(&linear(folded(34)));
}

#[test]
fn prescribed_displacements_and_few_supports_agree_with_the_direct_solver() {
    let mut m = model(plate([1.0, 0.7], [50, 20], 0.1), 2.1e11, 0.005);
    m.conditions = vec![
        Condition::Hinge(OnSet { on: "u_min".into() }),
        Condition::Prescribe(PrescribeComponent {
            on: "u_max_v_max".into(),
            of: NodalVector::default(),
            component: Axis::Z,
            value: 0.05,
            amplitude: None,
        }),
    ];
    m.loads = vec![Load::Edge(vector_load("v_min", [0.0, 0.0, 100.0]))];
    same(&linear(m));
}

#[test]
#[ignore = "long"]
fn all_elements_agree_with_the_direct_solver_in_large_rotations() {
    let mut m = quarter_cylinder(24, 2.1e8);
    m.loads = vec![Load::Force(vector_load("u_max_v_max", [0.0, 0.0, -20.0]))];
    // Directors of `mitc4` have two unknowns, along axes that turn; `ancf-full` has gradients, and groups of its
    // own for each integration point.
    let kinds = [
        ElementKind::Ems,
        ElementKind::Cm,
        ElementKind::Mitc4,
        ElementKind::SolidShell,
        ElementKind::AncfFull,
    ];
    for element in kinds {
        m.sections[0].element = element;
        // Its increments lead through a tangent that is not proved positive definite.
        let may_cut = element == ElementKind::Mitc4;
        let off = difference(&generate(&m.mesh).unwrap(), &m, may_cut);
        assert!(off < 1e-9, "{element:?}: {off:e}");
    }
}

#[test]
#[ignore = "long"]
fn irregular_meshes_with_several_sections_and_pressure_agree_with_the_direct_solver() {
    let mesh = irregular(20);
    let mut m = model(plate([1.0, 1.0], [1, 1], 0.0), 2.1e8, 0.01);
    m.sections[0].on = "other_half".into();
    let mut second = m.sections[0].clone();
    second.on = "half".into();
    second.thickness = 0.02;
    second.element = ElementKind::Cm;
    m.sections.push(second);
    m.loads = vec![
        Load::Pressure(PressureLoad { on: "all".into(), value: 2.0, amplitude: None, distribution: None }),
        Load::Gravity(GravityLoad { value: [0.0, 0.0, -9.8], amplitude: None }),
    ];
    let off = difference(&mesh, &m, false);
    assert!(off < 1e-9, "{off:e}");
}

#[test]
fn what_is_accepted_is_stable() {
    for elements in [[10, 2], [80, 16]] {
        let mut m = model(plate([1.0, 0.2], elements, 0.0), 2.1e8, 0.01);
        m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(2.1e8, 0.0, 1.0)));
        let euler = std::f64::consts::PI.powi(2) * 2.1e8 * 0.2 * 1e-6 / 12.0 / 4.0;
        let analysis = StaticAnalysis { max_cutbacks: 2, ..Default::default() };
        m.analysis = Analysis::Static(analysis);
        for (factor, stable) in [(0.5, true), (1.1, false), (1.5, false)] {
            m.loads = vec![Load::Edge(vector_load("u_max", [-factor * euler / 0.2, 0.0, 0.0]))];
            match run(&m, ITERATIVE) {
                Ok(o) => {
                    assert!(stable && o.negative_pivots == 0, "{elements:?}: {factor} times Euler's load")
                }
                Err(Error::NotConverged { reason, .. }) => {
                    assert!(
                        !stable && reason.contains("positive definite"),
                        "{elements:?} {factor}: {reason}"
                    );
                    assert!(reason.contains("direct"), "{reason}");
                }
                other => panic!("{other:?}"),
            }
        }
    }
}

#[test]
fn the_result_does_not_depend_on_the_threads() {
    let m = linear(folded(34));
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run(&m, ITERATIVE)).unwrap().state.u
    };
    assert_eq!(with(1), with(2));
}

#[test]
fn unstable_equilibria_are_not_asked_of_the_iterative_solver() {
    let mut m = folded(4);
    m.analysis = Analysis::Static(StaticAnalysis {
        linear_solver: ITERATIVE,
        allow_unstable: true,
        ..Default::default()
    });
    let issues = check::keys(&m);
    let found = issues.iter().find(|i| i.place.to_string() == "analysis.allow_unstable");
    assert!(found.is_some_and(|i| i.help.contains("direct")), "{issues:?}");
}

#[test]
fn systems_compiled_without_a_pattern_say_so() {
    let mut m = folded(4);
    m.analysis = Analysis::Static(StaticAnalysis { linear_solver: ITERATIVE, ..Default::default() });
    let system = build(&m, &generate(&m.mesh).unwrap()).unwrap();
    let error = statics::run(&system, &StaticAnalysis::default(), None, &mut Notes::default()).unwrap_err();
    assert!(error.to_string().contains("iterative"), "{error}");
}

/// Folded sheets on meshes whose folds lie between subdomains in many ways: a subdomain may hold a director of its neighbour by a
/// director-angle constraint alone.
#[test]
fn folded_sheets_are_solved_wherever_the_subdomains_meet() {
    for elements in [[60, 24], [48, 16], [52, 20], [36, 32]] {
        let mesh = MeshSource::Extrusion(ExtrusionMesh {
            vertices: vec![[0.0; 3], [0.5, 0.0, 0.0], [0.5, 0.0, 0.5], [0.8, 0.0, 0.9]],
            sweep: [0.0, 0.6, 0.0],
            grid: Grid::uniform(elements[0], elements[1]),
        });
        let rubber = Isotropic::new(1e9, 0.3, 1e3);
        let mut sheet = Model::new(mesh, Analysis::Static(StaticAnalysis::default()), rubber, 0.01);
        sheet.conditions = vec![Condition::Clamp(OnSet::new("u_min"))];
        sheet.loads = vec![Load::Edge(VectorLoad::new("u_max", [0.0, 0.0, 1e-3]))];
        same(&linear(sheet));
    }
}
