//! Bifurcations that cancel in the number of negative eigenvalues: one structure becomes stable where another one becomes unstable.

use crate::common::{Notes, model, on, plate, vector_load};
use tegula::analysis::path::{self, CriticalKind};
use tegula::analysis::{buckling, statics};
use tegula::compile::{Compiler, build};
use tegula::mesh::Mesh;
use tegula::mesh::generators::generate;
use tegula::model::*;
use tegula::{Result, Vec3};

/// Critical load of a column of the test by linear buckling.
fn critical_load() -> f64 {
    let mut m = model(plate([10.0, 1.0], [16, 1], 0.0), 1.2e6, 0.1);
    m.conditions = vec![Condition::Clamp(on("u_min"))];
    m.loads = vec![Load::Edge(vector_load("u_max", [-1.0, 0.0, 0.0]))];
    m.analysis = Analysis::Buckling(BucklingAnalysis::new(1));
    let system = build(&m, &generate(&m.mesh).unwrap()).unwrap();
    let Analysis::Buckling(options) = &m.analysis else { panic!() };
    buckling::run(&system, options, &mut Notes::default()).unwrap().modes[0].factor
}

/// Two columns side by side, with the edges `a` and `b` at their free ends.
fn two_columns() -> (Model, Mesh) {
    let mut m = model(plate([10.0, 1.0], [16, 1], 0.0), 1.2e6, 0.1);
    m.conditions = vec![Condition::Clamp(on("u_min"))];
    let mut mesh = generate(&m.mesh).unwrap();
    let nodes = mesh.positions.len() as u32;
    let beside: Vec<Vec3> = mesh.positions.iter().map(|x| Vec3::new(x.x, x.y + 3.0, x.z)).collect();
    mesh.positions.extend(beside);
    mesh.quads.extend(mesh.quads.clone().iter().map(|quad| quad.map(|node| node + nodes)));
    if let Some(normals) = &mut mesh.normals {
        normals.extend_from_within(..);
    }
    let quads = mesh.quads.len() as u32 / 2;
    mesh.node_sets.retain(|name, _| name == "u_min");
    mesh.node_sets.values_mut().for_each(|set| set.extend(set.clone().iter().map(|node| node + nodes)));
    mesh.quad_sets.values_mut().for_each(|set| set.extend(set.clone().iter().map(|quad| quad + quads)));
    let first = mesh.edge_sets["u_max"].clone();
    let second = first.iter().map(|edge| edge.map(|node| node + nodes)).collect();
    mesh.edge_sets.clear();
    mesh.edge_sets.insert("a".into(), first);
    mesh.edge_sets.insert("b".into(), second);
    (m, mesh)
}

/// Loads of the columns over the critical one: `b` is loaded first, beyond its bifurcation; then `a` is loaded and `b` relieved. Bifurcations of the
/// second path, which reports these load factors: load factors and changes.
fn found(end: [f64; 2], (method, at): (Option<PathMethod>, &[f64])) -> Result<Vec<(f64, i32)>> {
    let (mut m, mesh) = two_columns();
    let critical = critical_load();
    let load = |set: &str, part: f64| Load::Edge(vector_load(set, [-part * critical, 0.0, 0.0]));
    m.loads = vec![load("b", 1.5)];
    let options = PathAnalysis { method, ..PathAnalysis::default() };
    let step = |name: &str| AnalysisStep::new(name, Analysis::Path(options.clone()));
    let second = AnalysisStep {
        at: at.to_vec(),
        loads: vec![load("a", end[0]), load("b", end[1] - 1.5)],
        ..step("second")
    };
    m.steps = vec![step("first"), second];
    let compiler = Compiler::new(&m, &mesh)?;
    let mut start = None;
    let mut out = Vec::new();
    for number in 0..2 {
        let system = compiler.system(number, start.take())?;
        let outcome = path::run(&system, &options, None, &mut Notes::default())?;
        let path = outcome.state.path.as_ref().unwrap();
        let kinds: Vec<_> =
            path.critical.iter().map(|point| (point.kind, point.load, point.change)).collect();
        assert!(kinds.iter().all(|point| point.0 == CriticalKind::Bifurcation), "{number}: {kinds:?}");
        out = path.critical.iter().map(|point| (point.load, point.change)).collect();
        start = Some(outcome.state.end_of_step());
    }
    Ok(out)
}

/// The column `a` buckles at the load factor 1/2; `b` becomes stable before, behind and at this load. The shortening of the columns is below 1e-4.
#[test]
fn two_bifurcations_that_cancel_in_the_count_of_negative_eigenvalues_are_found() {
    let arc_length = Some(PathMethod::ArcLength);
    // Steps of the arc-length method end at load factors that are reported.
    for method in [(None, &[][..]), (arc_length, &[]), (arc_length, &[0.2, 0.7])] {
        for relieved in [0.0, 0.3, 0.45, 0.55, 0.9] {
            let expected_b: f64 = 0.5 / (1.5 - relieved);
            let mut expected = [(0.5_f64, 1), (expected_b, -1)];
            expected.sort_by(|p, q| p.0.total_cmp(&q.0));
            let found = found([2.0, relieved], method).unwrap();
            assert_eq!(found.len(), 2, "{method:?} {relieved}: {found:?}");
            for (found, expected) in found.iter().zip(expected) {
                assert!(
                    found.1 == expected.1 && (found.0 / expected.0 - 1.0).abs() < 1e-3,
                    "{found:?} {expected:?}"
                );
            }
        }
        // Relieved so that both pass through zero at one place.
        let mut relieved = 0.5;
        let mut apart = f64::INFINITY;
        for _ in 0..3 {
            let mut together = found([2.0, relieved], method).unwrap();
            together.sort_by_key(|point| point.1);
            let [(first, -1), (second, 1)] = together[..] else { panic!("{method:?} {together:?}") };
            assert!((first - 0.5).abs() < 1e-3 && (second - 0.5).abs() < 1e-3, "{method:?} {together:?}");
            apart = first - second;
            // The first load factor grows by 1/2 with this part.
            relieved -= 2.0 * apart;
        }
        // They are told at one load factor.
        assert!(apart == 0.0, "{method:?} {apart:e}");
    }
}

/// A strip that is heated between ends that do not move, and a prestressed one: nothing moves, so that each step converges at once. Above the critical
/// load the equilibrium is unstable, and is refused whatever the number of steps.
#[test]
fn a_structure_that_does_not_move_is_refused_above_its_critical_load() {
    let strip = |analysis: Analysis, strain: f64| {
        let mut m = model(plate([10.0, 1.0], [16, 1], 0.0), 1.2e6, 0.1);
        let Some(Material::Isotropic(material)) = m.materials.values_mut().next() else { panic!() };
        (material.poisson, material.expansion) = (0.0, 1e-5);
        m.conditions = vec![Condition::Clamp(on("u_min")), Condition::Clamp(on("u_max"))];
        m.prescribed_strains = vec![PrescribedStrain::Thermal(ThermalStrain {
            distribution: None,
            on: "all".into(),
            temperature: strain / 1e-5,
            gradient: 0.0,
            amplitude: None,
        })];
        m.analysis = analysis;
        build(&m, &generate(&m.mesh).unwrap()).unwrap()
    };
    let options = BucklingAnalysis::new(1);
    let system = strip(Analysis::Buckling(options.clone()), 1e-4);
    let critical = 1e-4 * buckling::run(&system, &options, &mut Notes::default()).unwrap().modes[0].factor;
    for load_steps in [1, 3, 7] {
        let options = StaticAnalysis { load_steps, ..StaticAnalysis::default() };
        let run = |part: f64| {
            let system = strip(Analysis::Static(options.clone()), part * critical);
            statics::run(&system, &options, None, &mut Notes::default())
        };
        run(0.99).unwrap();
        for part in [1.01, 3.0, 30.0] {
            let error = run(part).unwrap_err().to_string();
            assert!(error.contains("bifurcation point (buckling)"), "{load_steps} {part}: {error}");
        }
    }
}
