//! Limit and bifurcation points: no equilibrium beyond them is taken for one that the load path leads to, and messages name
//! them.

use crate::common::{
    Notes, compile, displacement, hinged_roof, model, on, plate, quarter_cylinder, side_by_side,
    static_options, vector_load,
};
use crate::multibody::spring;
use tegula::analysis::statics::{self, StaticOutcome};
use tegula::compile::build;
use tegula::mesh::generators::generate;
use tegula::model::*;
use tegula::{Error, Result};

/// Limit point of [`roof`] on 8 × 8 elements: force on the whole roof and deflection, from an independent program that
/// follows the path by power series.
const LIMIT: (f64, f64) = (2223.04, 10.79);

/// The hinged roof of 12.7 mm.
fn roof(force: f64, load_steps: u32, method: Option<NewtonMethod>) -> Model {
    let analysis = Analysis::Static(StaticAnalysis { load_steps, method, ..Default::default() });
    Model { analysis, ..hinged_roof(8, 12.7, force) }
}

fn run(m: &Model) -> Result<StaticOutcome> {
    let (_, system) = compile(m);
    statics::run(&system, &static_options(m), None, &mut Notes::default())
}

/// Place, reason and help of a failure.
fn failure(m: &Model) -> (f64, String, String) {
    match run(m) {
        Err(Error::NotConverged { at, reason, help }) => {
            (at.trim_start_matches("load factor ").parse().unwrap(), reason, help)
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn snap_through_is_refused_whatever_the_step_and_the_form() {
    for load_steps in [1, 10] {
        for method in [None, Some(NewtonMethod::Mixed), Some(NewtonMethod::Displacement)] {
            let (factor, reason, help) = failure(&roof(3000.0, load_steps, method));
            let error = 3000.0 * factor / LIMIT.0 - 1.0;
            assert!(error.abs() < 2e-3, "{load_steps} {method:?}: {factor} {reason}");
            assert!(reason.starts_with("limit point: "), "{load_steps} {method:?}: {reason}");
            assert!(help.contains("prescribe the displacement"), "{help}");
        }
    }
}

#[test]
fn loads_below_the_limit_are_reached_in_one_step() {
    let m = roof(0.9 * LIMIT.0, 1, None);
    let outcome = run(&m).unwrap();
    assert_eq!((outcome.statistics.steps, outcome.negative_pivots), (1, 0));
}

/// Prescribed displacements pass the limit point, and the force that they need has its maximum there.
#[test]
fn prescribed_displacements_pass_the_limit_point() {
    let mut m = roof(0.0, 10, None);
    m.loads.clear();
    m.conditions.push(Condition::Prescribe(PrescribeComponent {
        on: "u_min_v_min".into(),
        of: NodalVector::default(),
        component: Axis::Z,
        value: -25.0,
        amplitude: None,
    }));
    let (mesh, system) = compile(&m);
    let outcome = statics::run(&system, &static_options(&m), None, &mut Notes::default()).unwrap();
    assert_eq!(displacement(&mesh, &system, &outcome.state.u, "u_min_v_min").z, -25.0);
}

#[test]
fn stiffening_paths_are_taken_in_one_step() {
    let mut m = quarter_cylinder(16, 2.1e8);
    m.loads = vec![Load::Force(vector_load("u_max_v_max", [0.0, 0.0, -20.0]))];
    let outcome = run(&m).unwrap();
    assert_eq!((outcome.statistics.steps, outcome.statistics.cutbacks), (1, 0));
}

/// A clamped strip under an end force, 12 times Euler's load, and a pressure.
fn column(pressure: Option<f64>, linear_solver: LinearSolver) -> Model {
    let mut m = model(plate([1.0, 0.1], [16, 2], 0.0), 2e11, 0.01);
    m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(2e11, 0.0, 1.0)));
    m.loads = vec![Load::Edge(vector_load("u_max", [-493_480.0, 0.0, 0.0]))];
    m.loads.extend(pressure.map(|value| {
        Load::Pressure(PressureLoad { on: "all".into(), value, amplitude: None, distribution: None })
    }));
    m.analysis = Analysis::Static(StaticAnalysis { linear_solver, ..Default::default() });
    m
}

#[test]
fn weak_follower_loads_do_not_switch_off_the_refusal() {
    for solver in [LinearSolver::Direct, LinearSolver::Iterative] {
        for pressure in [None, Some(0.0), Some(1e-30)] {
            let (factor, reason, _) = failure(&column(pressure, solver));
            // Euler's load to the length of the last step and the error of the mesh.
            assert!((12.0 * factor - 1.0).abs() < 0.02, "{solver:?} {pressure:?}: {factor} {reason}");
        }
    }
}

/// A pressure that deflects the column by 1e-6 of its thickness bends it to its side at Euler's load, and it becomes an elastica: with the complete
/// integral `K = ½π √(P/P_E)` of a modulus k that differs from 1 by 1e-4 the end is deflected by `2 k/K` of the length.
#[test]
fn columns_far_behind_an_imperfect_bifurcation_are_elasticas_on_the_side_of_the_imperfection() {
    for pressure in [1e-3, -1e-3] {
        let m = column(Some(pressure), LinearSolver::Direct);
        let (mesh, system) = compile(&m);
        let outcome = statics::run(&system, &static_options(&m), None, &mut Notes::default()).unwrap();
        let end = displacement(&mesh, &system, &outcome.state.u, "u_max_v_min");
        assert!(end.z * pressure < 0.0, "{pressure} {end}");
        let elastica = 2.0 / (0.5 * std::f64::consts::PI * 12.0_f64.sqrt());
        assert!((end.z.abs() / elastica - 1.0).abs() < 0.02, "{pressure} {end} {elastica}");
        assert_eq!(outcome.negative_pivots, 0);
    }
}

/// One or two columns at 1.2 times Euler's load beside a soft sheet under a follower pressure: more than a hundred motions
/// of the sheet are softer than the buckling modes are unstable.
#[test]
#[ignore = "long"]
fn stiff_unstable_modes_are_found_among_soft_ones_under_follower_loads() {
    for columns in [1, 2] {
        let mut m = column(None, LinearSolver::Direct);
        let strip = generate(&m.mesh).unwrap();
        let mut parts = vec![generate(&plate([1.0, 1.0], [12, 12], 0.0)).unwrap()];
        parts.extend(vec![strip; columns]);
        let mesh = side_by_side(&parts);
        m.materials.insert("soft".into(), Material::Isotropic(Isotropic::new(2e4, 0.0, 1.0)));
        m.sections = (0..parts.len())
            .map(|k| {
                let material = if k == 0 { "soft" } else { "m" };
                let on = format!("part{k}").as_str().into();
                Section { on, material: material.into(), ..m.sections[0].clone() }
            })
            .collect();
        m.conditions = (0..parts.len()).map(|k| Condition::Clamp(on(&format!("u_min{k}")))).collect();
        for factor in [0.8, 1.2] {
            let pressure =
                PressureLoad { on: "part0".into(), value: 1e-4, amplitude: None, distribution: None };
            m.loads = vec![Load::Pressure(pressure)];
            m.loads.extend((1..parts.len()).map(|k| {
                let force = [-factor / 12.0 * 493_480.0, 0.0, 0.0];
                Load::Edge(vector_load(&format!("u_max{k}"), force))
            }));
            let system = build(&m, &mesh).unwrap();
            let outcome = statics::run(&system, &static_options(&m), None, &mut Notes::default());
            assert_eq!(outcome.is_ok(), factor < 1.0, "{columns} at {factor}: {:?}", outcome.err());
        }
    }
}

#[test]
fn buckling_of_a_straight_column_is_told_as_bifurcation() {
    let (_, reason, help) = failure(&column(None, LinearSolver::Direct));
    assert!(reason.starts_with("bifurcation point (buckling): 1 negative pivot"), "{reason}");
    assert!(help.contains("imperfection") && help.contains("allow_unstable"), "{help}");
}

/// A spring along the loaded edge bears nothing, but the rotation of its first increment stretches it by far more than the load. The column buckles at
/// π² E I/(4 L²) = 205.6 N for each unit of its width, on this mesh at 206.46, whatever the spring.
#[test]
fn columns_beside_stiff_springs_buckle_at_their_load() {
    for power in [0, 10, 12, 13, 14] {
        for load in [200.0, 215.0] {
            let mut m = model(plate([1.0, 0.2], [10, 2], 0.0), 1e9, 0.01);
            m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(1e9, 0.0, 1.0)));
            let ends = [[1.0, 0.7, 0.0], [1.0, 0.2, 0.0]];
            m.springs = vec![spring("s", ["ground", "u_max_v_max"], ends, 10_f64.powi(power))];
            m.loads = vec![Load::Edge(vector_load("u_max", [-load, 0.0, 0.0]))];
            if load < 206.0 {
                assert_eq!(run(&m).unwrap().negative_pivots, 0, "{power}");
                continue;
            }
            let (factor, reason, _) = failure(&m);
            assert!((load * factor / 206.455 - 1.0).abs() < 2e-3, "1e{power}: {}", load * factor);
            assert!(reason.starts_with("bifurcation point"), "1e{power}: {reason}");
        }
    }
}
