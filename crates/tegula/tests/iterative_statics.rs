//! Static analyses with the iterative linear solver against the direct one.

#![allow(clippy::unwrap_used)]

mod common;

use common::{Notes, compile, model, plate, quarter_cylinder, static_options, vector_load};
use tegula::analysis::statics::{self, StaticOutcome};
use tegula::model::*;
use tegula::{Error, Result};

const ITERATIVE: LinearSolver = LinearSolver::Iterative;

fn run(model: &Model, solver: LinearSolver) -> Result<StaticOutcome> {
    let options = StaticAnalysis { linear_solver: solver, ..static_options(model) };
    let (_, system) = compile(&Model { analysis: Analysis::Static(options.clone()), ..model.clone() });
    statics::run(&system, &options, None, &mut Notes::default())
}

/// Largest difference of displacements relative to the largest displacement, and iterations of conjugate gradients.
fn difference(model: &Model) -> (f64, u64) {
    let direct = run(model, LinearSolver::Direct).unwrap();
    let iterative = run(model, ITERATIVE).unwrap();
    assert_eq!(direct.statistics.linear_iterations, 0);
    assert!(iterative.statistics.linear_iterations > 0);
    let all = |o: &StaticOutcome| o.state.u.as_flattened().to_vec();
    let (a, b) = (all(&direct), all(&iterative));
    let largest = a.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let off = a.iter().zip(&b).fold(0.0_f64, |m, (x, y)| m.max((x - y).abs()));
    (off / largest, iterative.statistics.linear_iterations)
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
fn plates_cylinders_and_folds_agree_with_the_direct_solver() {
    // Rounding of the direct solution itself grows with the square of the slenderness.
    for (slenderness, tolerance) in [(10.0, 1e-9), (100.0, 1e-8), (1000.0, 1e-6)] {
        for curved in [false, true] {
            let mut m = if curved {
                quarter_cylinder(28, 2.1e11)
            } else {
                model(plate([1.0, 1.0], [26, 30], 0.2), 2.1e11, 0.01)
            };
            m.sections[0].thickness = 1.0 / slenderness;
            m.loads = vec![Load::Edge(vector_load("u_max", [0.0, 1.0, -1.0]))];
            let (off, iterations) = difference(&linear(m));
            println!("curved {curved} L/h {slenderness}: {off:.1e} after {iterations}");
            assert!(off < tolerance, "curved {curved} L/h {slenderness}: {off:e}");
        }
    }
    let (off, iterations) = difference(&linear(folded(24)));
    println!("folded: {off:.1e} after {iterations}");
    assert!(off < 1e-8, "{off:e}");
}

#[test]
fn prescribed_displacements_and_few_supports_agree_with_the_direct_solver() {
    let mut m = model(plate([1.0, 0.7], [30, 20], 0.1), 2.1e11, 0.005);
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
    let (off, _) = difference(&linear(m));
    assert!(off < 1e-8, "{off:e}");
}

#[test]
fn large_rotations_agree_with_the_direct_solver() {
    let mut m = quarter_cylinder(20, 2.1e8);
    m.loads = vec![Load::Force(vector_load("u_max_v_max", [0.0, 0.0, -20.0]))];
    let (off, iterations) = difference(&m);
    assert!(off < 1e-8, "{off:e} after {iterations}");
    // Directors of unit length have two unknowns, along axes that turn.
    m.sections[0].element = ElementKind::Mitc4;
    let (off, iterations) = difference(&m);
    assert!(off < 1e-8, "{off:e} after {iterations}");
}

#[test]
fn unstable_equilibria_are_refused_in_words() {
    for elements in [[10, 2], [80, 16]] {
        let mut m = model(plate([1.0, 0.2], elements, 0.0), 2.1e8, 0.01);
        m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(2.1e8, 0.0, 1.0)));
        let euler = std::f64::consts::PI.powi(2) * 2.1e8 * 0.2 * 1e-6 / 12.0 / 4.0;
        let analysis = StaticAnalysis { max_cutbacks: 2, ..Default::default() };
        m.analysis = Analysis::Static(analysis);
        for (factor, stable) in [(0.5, true), (1.5, false)] {
            m.loads = vec![Load::Edge(vector_load("u_max", [-factor * euler / 0.2, 0.0, 0.0]))];
            match run(&m, ITERATIVE) {
                Ok(_) => assert!(stable, "{elements:?}: {factor} times Euler's load"),
                Err(Error::NotConverged { reason, .. }) => {
                    assert!(!stable && reason.contains("be positive definite"), "{elements:?} {factor}: {reason}");
                    assert!(reason.contains("direct"), "{reason}");
                }
                other => panic!("{other:?}"),
            }
        }
    }
}

#[test]
fn the_result_does_not_depend_on_the_threads() {
    let m = linear(folded(16));
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
