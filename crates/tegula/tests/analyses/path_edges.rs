//! Equilibrium paths at their edges: multiple bifurcations, small units of length, ends next to a bifurcation, inverted elements.

use crate::common::{compile, displacement, on, plate, vector_load};
use crate::paths::{critical, follow, in_other_units, roof};
use tegula::analysis::path::{self, CriticalKind, PathOutcome};
use tegula::analysis::{Observer, Step};
use tegula::model::*;
use tegula::{Error, Result};

/// Square plate of side 1 between hinges that may shorten, under compression of the Euler load of a wide strip along x and `across` of
/// it along y.
pub fn hinged_plate(n: u32, across: f64, options: PathAnalysis) -> Model {
    let (young, h, poisson) = (1e9, 0.01_f64, 0.3);
    let mut m = Model::new(
        plate([1.0; 2], [n, n], 0.0),
        Analysis::Path(options),
        Isotropic::new(young, poisson, 1.0),
        h,
    );
    let fix = |on: &str, position: &[Axis]| {
        Condition::Fix(FixComponents { on: on.into(), position: position.to_vec(), director: Vec::new() })
    };
    m.conditions = vec![
        fix("u_min", &[Axis::X, Axis::Z]),
        fix("u_max", &[Axis::Z]),
        fix("v_min", &[Axis::Y, Axis::Z]),
        fix("v_max", &[Axis::Z]),
    ];
    let load = std::f64::consts::PI.powi(2) * young * h.powi(3) / (12.0 * (1.0 - poisson * poisson));
    m.loads = vec![Load::Edge(vector_load("u_max", [-load, 0.0, 0.0]))];
    if across != 0.0 {
        m.loads.push(Load::Edge(vector_load("v_max", [0.0, -across * load, 0.0])));
    }
    m
}

/// Strip of length 1 between hinges under compression, L/h = 100.
fn hinged_strip(scale: f64, options: PathAnalysis) -> Model {
    let (young, h) = (1e9 / (scale * scale), 0.01 * scale);
    let mesh = plate([scale, 0.1 * scale], [16, 1], 0.0);
    let mut m = Model::new(mesh, Analysis::Path(options), Isotropic::new(young, 0.0, 1.0), h);
    let guide = FixComponents { on: "u_max".into(), position: vec![Axis::Y, Axis::Z], director: Vec::new() };
    m.conditions = vec![Condition::Hinge(on("u_min")), Condition::Fix(guide)];
    let euler = std::f64::consts::PI.powi(2) * young * h.powi(3) / 12.0 / (scale * scale);
    m.loads = vec![Load::Edge(vector_load("u_max", [-euler, 0.0, 0.0]))];
    m
}

/// Deflection of the middle of a plate or strip at the end of its path.
fn middle(m: &Model, outcome: &PathOutcome, at: [f64; 2]) -> f64 {
    let (mesh, system) = compile(m);
    let near = |x: &tegula::Vec3| (x.x - at[0]).hypot(x.y - at[1]);
    let node = (0..mesh.positions.len())
        .min_by(|&a, &b| near(&mesh.positions[a]).total_cmp(&near(&mesh.positions[b])))
        .unwrap();
    outcome.state.u[system.coordinates.position_of[node] as usize][2]
}

#[derive(Default)]
pub struct Warnings(pub Vec<String>);

impl Observer for Warnings {
    fn on_step(&mut self, _: &Step) -> Result<()> {
        Ok(())
    }
    fn on_warning(&mut self, message: &str) {
        self.0.push(message.into());
    }
}

fn run(m: &Model) -> (Result<PathOutcome>, Vec<String>) {
    let Analysis::Path(options) = &m.analysis else { panic!("no path") };
    let (_, system) = compile(m);
    let mut warnings = Warnings::default();
    (path::run(&system, options, None, &mut warnings), warnings.0)
}

/// A square plate under equal compression along both sides has a double bifurcation, whose two points are no return of the path.
#[test]
fn paths_go_on_behind_double_bifurcations() {
    let m = hinged_plate(6, 1.0, PathAnalysis { end_load: 8.0, ..Default::default() });
    let (outcome, _) = follow(&m, "u_min_v_min");
    assert_eq!(outcome.state.time, 8.0);
    let changes: i32 = critical(&outcome).iter().map(|point| point.change).sum();
    // Factors m² + n² of the plate: 2, and 5 twice.
    assert_eq!(changes, 3, "{:?}", critical(&outcome).iter().map(|p| (p.kind, p.load)).collect::<Vec<_>>());
    assert_eq!(outcome.state.negative_pivots, 3);
}

/// Limit points do not become bifurcations where a model is small beside the unit of length.
#[test]
fn critical_points_do_not_depend_on_the_unit_of_length() {
    let m = roof(6, 12.7);
    for length in [1e-9, 1e-6, 1e6] {
        let scaled = in_other_units(&m, length, 1.0);
        let [a, b] = [&m, &scaled].map(|m| follow(m, "u_min_v_min").0);
        let kinds =
            |outcome: &PathOutcome| critical(outcome).iter().map(|p| (p.kind, p.change)).collect::<Vec<_>>();
        assert_eq!(kinds(&a), [(CriticalKind::Limit, 1), (CriticalKind::Limit, -1)]);
        assert_eq!(kinds(&a), kinds(&b), "{length:e}");
        assert_eq!(a.statistics, b.statistics);
    }
}

/// The side of a crossing path is that of the first of the largest displacements, whatever the units.
#[test]
fn sides_of_crossing_paths_are_decided_by_displacements() {
    for (switch, end_load) in [(1, 1.5), (-1, 1.5), (1, 1.51), (1, 1.6)] {
        for scale in [1.0, 1e3, 1e-3] {
            let m =
                hinged_strip(scale, PathAnalysis { end_load, switch_at: vec![switch], ..Default::default() });
            let (outcome, _) = follow(&m, "u_max_v_min");
            let w = middle(&m, &outcome, [0.5 * scale, 0.0]) / scale;
            assert!(w * f64::from(switch) > 0.3, "{switch} {end_load} {scale}: {w}");
        }
    }
}

/// On the crossing path of a pitchfork the deflection grows with the root of the load: also where the path ends right behind the bifurcation.
#[test]
fn paths_end_right_behind_a_bifurcation() {
    let bifurcation = {
        let (outcome, _) = follow(
            &hinged_plate(6, 0.0, PathAnalysis { end_load: 5.0, ..Default::default() }),
            "u_min_v_min",
        );
        critical(&outcome)[0].load
    };
    let deflection = |above: f64| {
        let options =
            PathAnalysis { end_load: bifurcation + above, switch_at: vec![1], ..Default::default() };
        let m = hinged_plate(6, 0.0, options);
        let (outcome, _) = follow(&m, "u_min_v_min");
        assert_eq!(outcome.state.time, bifurcation + above);
        assert!(outcome.statistics.factorizations < 80, "{above:e}: {:?}", outcome.statistics);
        middle(&m, &outcome, [0.5; 2]).abs()
    };
    let reference = deflection(5e-3) / 5e-3_f64.sqrt();
    for above in [1e-3, 1e-4, 1e-5] {
        let w = deflection(above) / above.sqrt();
        assert!((w / reference - 1.0).abs() < 0.01, "{above:e}: {w} {reference}");
    }
    // Too near for a point in between: refused with the load factor, not passed.
    let options =
        PathAnalysis { end_load: bifurcation * (1.0 + 1e-14), switch_at: vec![1], ..Default::default() };
    if let (Err(error), _) = run(&hinged_plate(6, 0.0, options)) {
        assert!(error.to_string().contains("near to the bifurcation"), "{error}");
    }
}

/// A strip of one element is compressed to beyond nothing.
#[test]
fn paths_end_at_inverted_elements() {
    for method in [PathMethod::Series, PathMethod::ArcLength] {
        let mesh = plate([1.0, 0.1], [1, 1], 0.0);
        let options = PathAnalysis { method: Some(method), ..Default::default() };
        let mut m = Model::new(mesh, Analysis::Path(options), Isotropic::new(1e9, 0.0, 1.0), 0.1);
        m.conditions = vec![
            Condition::Clamp(on("u_min")),
            Condition::Fix(FixComponents {
                on: "all".into(),
                position: vec![Axis::Y, Axis::Z],
                director: Vec::new(),
            }),
            Condition::Prescribe(PrescribeComponent {
                on: "u_max".into(),
                of: NodalVector::Position,
                component: Axis::X,
                value: -2.5,
                amplitude: None,
            }),
        ];
        let (outcome, _) = run(&m);
        let message = outcome.unwrap_err().to_string();
        assert!(message.contains("is inverted") || message.contains("singular"), "{message}");
    }
}

/// The work of the reactions on a prescribed displacement is the strain energy, however few points are reported.
#[test]
fn work_on_prescribed_displacements_does_not_depend_on_the_points() {
    for points in [1, 10] {
        let mut m = roof(6, 12.7);
        m.loads.clear();
        m.conditions.push(Condition::Prescribe(PrescribeComponent {
            on: "u_min_v_min".into(),
            of: NodalVector::default(),
            component: Axis::Z,
            value: -28.0,
            amplitude: None,
        }));
        m.analysis = Analysis::Path(PathAnalysis { points, ..Default::default() });
        let (outcome, _) = follow(&m, "u_min_v_min");
        let balance = outcome.balance;
        assert!(balance.total.abs() < 1e-6 * balance.strain, "{points}: {balance:?}");
        assert!(balance.strain > 1e3);
    }
}

/// High orders are beyond the largest number where the series begins on a crossing path next to its bifurcation.
#[test]
fn paths_of_any_order_leave_a_bifurcation() {
    for order in [5, 60] {
        let options = PathAnalysis { end_load: 1.2, switch_at: vec![1], order, ..Default::default() };
        let (outcome, _) = follow(&hinged_strip(1.0, options), "u_max_v_min");
        assert_eq!(outcome.state.time, 1.2, "{order}");
    }
}

#[test]
fn bifurcations_that_are_not_reached_are_named() {
    let options = PathAnalysis { end_load: 1.2, switch_at: vec![1, 99], ..Default::default() };
    let (_, warnings) = run(&hinged_strip(1.0, options));
    assert!(warnings.iter().any(|warning| warning.contains("bifurcation 99")), "{warnings:?}");
    let twice = hinged_strip(1.0, PathAnalysis { switch_at: vec![1, -1], ..Default::default() });
    let mesh = tegula::mesh::generators::generate(&twice.mesh).unwrap();
    let error: Error = tegula::compile::build(&twice, &mesh).err().unwrap();
    assert!(error.to_string().contains("named twice"), "{error}");
}

/// A path without a limit point to end at: deflections are those of a static analysis of the same load (closed by another method).
#[test]
fn both_methods_end_at_the_same_equilibrium() {
    let mut m = roof(6, 12.7);
    let ends = [PathMethod::Series, PathMethod::ArcLength].map(|method| {
        m.analysis =
            Analysis::Path(PathAnalysis { end_load: 0.6, method: Some(method), ..Default::default() });
        let (mesh, system) = compile(&m);
        let Analysis::Path(options) = &m.analysis else { unreachable!() };
        let outcome = path::run(&system, options, None, &mut Warnings::default()).unwrap();
        displacement(&mesh, &system, &outcome.state.u, "u_min_v_min").z
    });
    assert!((ends[0] / ends[1] - 1.0).abs() < 1e-6, "{ends:?}");
}
