//! Equilibrium paths by power series: hinged roofs through limit points and a snap-back.

use crate::arches::{arch, critical_loads};
use crate::common::{Notes, compile, displacement, hinged_roof, model, on, plate, vector_load};
use crate::multibody::spring;
use tegula::analysis::path::{self, CriticalKind, CriticalPoint, PathOutcome};
use tegula::analysis::{Observer, State, Step, statics};
use tegula::mesh::Mesh;
use tegula::model::*;
use tegula::system::System;
use tegula::{Error, Result};

/// Force on the whole roof at load factor 1 (N).
pub const FULL: f64 = 3000.0;

/// The hinged roof, whose path ends at a deflection of 30 mm.
pub fn roof(n: u32, thickness: f64) -> Model {
    let deflected = StopCondition { column: "w".into(), value: 30.0, direction: Crossing::Rising };
    let options = PathAnalysis { end_load: 2.0, stop: vec![deflected], ..Default::default() };
    Model { analysis: Analysis::Path(options), ..hinged_roof(n, thickness, FULL) }
}

/// Observer that keeps load factor and deflection of a corner.
struct Curve<'a> {
    mesh: &'a Mesh,
    system: &'a System,
    corner: &'a str,
    points: Vec<[f64; 2]>,
}

impl Curve<'_> {
    fn deflection(&self, step: &Step) -> f64 {
        -displacement(self.mesh, self.system, &step.state.u, self.corner).z
    }
}

impl Observer for Curve<'_> {
    fn on_step(&mut self, step: &Step) -> Result<()> {
        self.points.push([self.deflection(step), step.state.time]);
        Ok(())
    }
    fn column(&mut self, name: &str, step: &Step) -> Option<f64> {
        (name == "w").then(|| self.deflection(step))
    }
}

pub fn follow(m: &Model, corner: &str) -> (PathOutcome, Vec<[f64; 2]>) {
    let Analysis::Path(options) = &m.analysis else { panic!("no path") };
    let (mesh, system) = compile(m);
    let mut curve = Curve { mesh: &mesh, system: &system, corner, points: vec![[0.0; 2]] };
    let outcome = path::run(&system, options, None, &mut curve).unwrap();
    (outcome, curve.points)
}

pub fn critical(outcome: &PathOutcome) -> Vec<CriticalPoint> {
    outcome.state.path.as_ref().unwrap().critical.clone()
}

/// Independent program with the elements of the paper on 8 × 8 elements, by power series: limit loads (N).
#[test]
fn limit_points_of_hinged_roofs_are_those_of_an_independent_program() {
    for (thickness, limits, factorizations) in [(12.7, [2223.04, 520.39], 8), (6.35, [594.63, -382.49], 20)] {
        let (outcome, points) = follow(&roof(8, thickness), "u_min_v_min");
        let found = critical(&outcome);
        let loads: Vec<f64> =
            found.iter().filter(|p| p.kind == CriticalKind::Limit).map(|p| FULL * p.load).collect();
        assert_eq!(loads.len(), 2, "{loads:?}");
        for (load, limit) in loads.iter().zip(limits) {
            assert!((load - limit).abs() < 0.006, "{load} {limit}");
        }
        // Behind the maximum an eigenvalue is negative, behind the minimum it is positive again.
        assert_eq!(found.iter().map(|p| p.change).collect::<Vec<_>>(), [1, -1]);
        assert_eq!(outcome.statistics.factorizations, factorizations);
        let [w, _] = points.last().unwrap();
        assert!((w - 30.0).abs() < 1e-6, "{w}");
        assert_eq!(outcome.state.negative_pivots, 0);
    }
}

/// A hinged roof in other units of length and stress.
pub fn in_other_units(m: &Model, length: f64, stress: f64) -> Model {
    let mut scaled = m.clone();
    if let MeshSource::Cylinder(mesh) = &mut scaled.mesh {
        mesh.radius *= length;
        mesh.length *= length;
    }
    if let Some(Material::Isotropic(steel)) = scaled.materials.values_mut().next() {
        steel.young *= stress;
    }
    scaled.sections[0].thickness *= length;
    if let Load::Force(force) = &mut scaled.loads[0] {
        force.value = force.value.map(|f| f * stress * length * length);
    }
    if let Analysis::Path(path) = &mut scaled.analysis {
        path.stop[0].value *= length;
    }
    scaled
}

/// The path of a roof in other units of length: the same steps, and the same points.
pub fn same_path_in_units(m: &Model, scaled: &Model, length: f64) {
    let [(a, first), (b, second)] = [m, scaled].map(|m| follow(m, "u_min_v_min"));
    assert_eq!(a.statistics, b.statistics);
    assert_eq!(first.len(), second.len());
    for (p, q) in first.iter().zip(&second) {
        assert!((q[0] / length - p[0]).abs() < 1e-9 * 30.0 && (q[1] - p[1]).abs() < 1e-9, "{p:?} {q:?}");
    }
}

/// A path does not depend on units: lengths in other units, stresses in others.
#[test]
fn paths_do_not_depend_on_units() {
    let (length, stress) = (1e3, 1e9);
    let m = roof(6, 6.35);
    let scaled = in_other_units(&m, length, stress);
    same_path_in_units(&m, &scaled, length);
}

/// Where the path has no limit point, its end is the equilibrium of a static analysis: under forces, prescribed displacements,
/// prescribed strains.
#[test]
fn ends_of_paths_are_equilibria_of_statics() {
    let mut forces = roof(6, 12.7);
    if let Load::Force(force) = &mut forces.loads[0] {
        force.value[2] *= 0.6;
    }
    let mut moved = roof(6, 12.7);
    moved.loads.clear();
    moved.conditions.push(Condition::Prescribe(PrescribeComponent {
        on: "u_min_v_min".into(),
        of: NodalVector::default(),
        component: Axis::Z,
        value: -25.0,
        amplitude: None,
    }));
    let mut strained = roof(6, 12.7);
    strained.loads.clear();
    strained.prescribed_strains = vec![PrescribedStrain::Natural(NaturalStrain {
        distribution: None,
        on: "all".into(),
        strain: [2e-4, 1e-4, 0.0],
        curvature: [-2e-5, 0.0, 0.0],
        direction: [1.0, 0.0, 0.0],
        amplitude: None,
    })];
    for (name, mut m) in [("forces", forces), ("moved", moved), ("strained", strained)] {
        m.analysis = Analysis::Path(PathAnalysis::default());
        let (outcome, _) = follow(&m, "u_min_v_min");
        assert_eq!(outcome.state.time, 1.0);
        m.analysis = Analysis::Static(StaticAnalysis { load_steps: 10, ..Default::default() });
        let (_, system) = compile(&m);
        let Analysis::Static(options) = &m.analysis else { unreachable!() };
        let found = statics::run(&system, options, None, &mut Notes::default()).unwrap();
        let both = outcome.state.u.iter().zip(&found.state.u);
        let difference: Vec<_> = both.map(|(a, b)| [a[0] - b[0], a[1] - b[1], a[2] - b[2]]).collect();
        let relative = system.norm(&difference) / system.norm(&found.state.u);
        assert!(relative < 1e-6, "{name}: {relative:e}");
        assert!((outcome.balance.strain / found.balance.strain - 1.0).abs() < 1e-6, "{name}");
        assert!((outcome.balance.work - found.balance.work).abs() < 1e-2 * found.balance.strain, "{name}");
    }
}

/// Observer that keeps the last state and stops the run after a number of points.
struct Stops(Option<State>, u32);

impl Observer for Stops {
    fn on_step(&mut self, step: &Step) -> Result<()> {
        self.0 = Some(step.state.clone());
        self.1 = self.1.saturating_sub(1);
        if self.1 == 0 { Err(Error::Interrupted) } else { Ok(()) }
    }
}

#[test]
fn a_resumed_path_has_the_same_bits() {
    let mut m = roof(4, 6.35);
    let options = PathAnalysis { end_load: 1.0, ..Default::default() };
    m.analysis = Analysis::Path(options.clone());
    let (_, system) = compile(&m);
    let whole = path::run(&system, &options, None, &mut Notes::default()).unwrap();
    // In the middle of a piece, and at the end of one.
    for points in [3, 10, 27] {
        let mut stops = Stops(None, points);
        assert!(matches!(path::run(&system, &options, None, &mut stops), Err(Error::Interrupted)));
        let resumed = path::run(&system, &options, stops.0, &mut Notes::default()).unwrap();
        assert_eq!(resumed.state, whole.state, "{points}");
    }
}

/// Strip under axial compression P, clamped and free or between hinges: it bifurcates at the load of Euler with shear, on the path of the compressed
/// strip at `P = n √(1 − 2 n/EA)`.
#[test]
fn a_compressed_strip_bifurcates_at_the_load_of_euler_with_shear() {
    for (hinged, error) in [(false, 1e-6), (true, 2e-6)] {
        let found = strip_on_its_path(hinged);
        assert!((found - 1.0).abs() < error, "{hinged} {found}");
    }
}

/// Load at which the strip bifurcates over the exact one, extrapolated.
fn strip_on_its_path(hinged: bool) -> f64 {
    let (length, h, young) = (10.0, 1.0_f64, 1e4);
    let buckling_length = if hinged { length } else { 2.0 * length };
    let euler = std::f64::consts::PI.powi(2) * young * h.powi(3) / 12.0 / (buckling_length * buckling_length);
    let shear = 5.0 / 6.0 * 0.5 * young * h;
    let n = euler / (1.0 + euler / shear);
    let exact = n * (1.0 - 2.0 * n / (young * h)).sqrt();
    let load = |elements: u32| {
        let mut m = model(plate([length, 3.0], [elements, 1], 0.0), young, h);
        if let Some(Material::Isotropic(material)) = m.materials.values_mut().next() {
            material.poisson = 0.0;
        }
        if hinged {
            let position = vec![Axis::Y, Axis::Z];
            let guided = FixComponents { on: "u_max".into(), position, director: Vec::new() };
            m.conditions = vec![Condition::Hinge(on("u_min")), Condition::Fix(guided)];
        }
        m.loads = vec![Load::Edge(vector_load("u_max", [-exact, 0.0, 0.0]))];
        m.analysis = Analysis::Path(PathAnalysis { end_load: 1.2, ..Default::default() });
        let (outcome, _) = follow(&m, "u_max_v_min");
        let found = critical(&outcome);
        assert_eq!(
            found.iter().map(|p| (p.kind, p.change)).collect::<Vec<_>>(),
            [(CriticalKind::Bifurcation, 1)]
        );
        found[0].load
    };
    let [coarse, fine] = [32, 64].map(load);
    fine + (fine - coarse) / 3.0
}

/// Complete elliptic integral of the first kind of the modulus k, by the arithmetic–geometric mean.
fn elliptic(k: f64) -> f64 {
    let (mut a, mut b) = (1.0, (1.0 - k * k).sqrt());
    for _ in 0..40 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    0.5 * std::f64::consts::PI / a
}

/// Load over that of Euler of a clamped–free elastica whose end is deflected by z over its length: with the modulus k,
/// `z/L = 2 k/K(k)` and `P/P_E = (2 K/π)²` (S. P. Timoshenko, J. M. Gere, *Theory of Elastic Stability*, 2nd ed., Sect. 2.7).
pub fn elastica(z: f64) -> f64 {
    let (mut low, mut high) = (0.0, 0.9);
    for _ in 0..80 {
        let k = 0.5 * (low + high);
        if 2.0 * k / elliptic(k) < z { low = k } else { high = k }
    }
    (2.0 * elliptic(low) / std::f64::consts::PI).powi(2)
}

/// Post-buckling of a strip with L/h = 200: at the bifurcation the path goes over to either side of the crossing one.
#[test]
fn a_buckled_strip_is_an_elastica() {
    let (length, h, young) = (10.0, 0.05_f64, 1e7);
    let euler = std::f64::consts::PI.powi(2) * young * h.powi(3) / 12.0 / (4.0 * length * length);
    let follow_to = |side: i32| {
        let mut m = model(plate([length, 1.0], [64, 1], 0.0), young, h);
        if let Some(Material::Isotropic(material)) = m.materials.values_mut().next() {
            material.poisson = 0.0;
        }
        m.loads = vec![Load::Edge(vector_load("u_max", [-euler, 0.0, 0.0]))];
        m.analysis =
            Analysis::Path(PathAnalysis { end_load: 1.5, switch_at: vec![side], ..Default::default() });
        follow(&m, "u_max_v_min")
    };
    let [(outcome, up), (_, down)] = [1, -1].map(follow_to);
    let found = critical(&outcome);
    assert_eq!(
        found.iter().map(|p| (p.kind, p.change)).collect::<Vec<_>>(),
        [(CriticalKind::Bifurcation, 1)]
    );
    assert!((found[0].load - 1.0).abs() < 3e-4, "{}", found[0].load);
    assert_eq!(outcome.state.negative_pivots, 0);
    let mut compared = 0;
    for (a, b) in up.iter().zip(&down) {
        assert!((a[0] + b[0]).abs() < 1e-6 * length && (a[1] - b[1]).abs() < 1e-6, "{a:?} {b:?}");
        let z = a[0].abs() / length;
        if z > 0.05 {
            let exact = elastica(z);
            assert!((a[1] / exact - 1.0).abs() < 1e-3, "{z}: {} {exact}", a[1]);
            compared += 1;
        }
    }
    assert!(compared > 10 && up.last().unwrap()[1] == 1.5);
}

/// The crossing path of the arch without symmetry leads to the other bifurcation of the symmetric one and, on the other side, back to the
/// first: with the constant compression of the antisymmetric mode its load falls in proportion to the change of the deflection.
#[test]
fn the_crossing_path_of_an_arch_is_closed() {
    let (mut m, exact) = arch(48, 0.01);
    let loads = critical_loads(&exact);
    m.loads = vec![Load::Traction(vector_load("all", [0.0, 0.0, -loads[1]]))];
    m.analysis = Analysis::Path(PathAnalysis { end_load: 1.5, switch_at: vec![1], ..Default::default() });
    let (outcome, _) = follow(&m, "u_min_v_min");
    let found = critical(&outcome);
    let kinds: Vec<_> = found.iter().map(|point| point.kind).collect();
    assert!(kinds.iter().all(|kind| *kind == CriticalKind::Bifurcation), "{kinds:?}");
    assert!(outcome.state.path.as_ref().unwrap().finished && outcome.statistics.factorizations < 200);
    assert!((found[0].load - found.last().unwrap().load).abs() < 1e-6);
    // The other bifurcation of the symmetric path.
    let lower = found.iter().map(|point| point.load * loads[1]).min_by(f64::total_cmp).unwrap();
    assert!((lower - loads[3]).abs() < 0.01 * loads[1], "{lower} {}", loads[3]);
}

/// Load factors of limit points do not depend on the tolerance of the series: they are corrected by the residual.
#[test]
fn limit_loads_are_accurate_to_eight_digits() {
    let limits = |tolerance: f64| {
        let mut m = roof(8, 6.35);
        if let Analysis::Path(path) = &mut m.analysis {
            path.tolerance = tolerance;
        }
        let (outcome, _) = follow(&m, "u_min_v_min");
        critical(&outcome).iter().map(|point| point.load).collect::<Vec<_>>()
    };
    let precise = limits(1e-13);
    assert_eq!(precise.len(), 2);
    for tolerance in [1e-9, 1e-7] {
        for (load, exact) in limits(tolerance).iter().zip(&precise) {
            assert!((load / exact - 1.0).abs() < 1e-8, "{tolerance:e}: {load} {exact}");
        }
    }
}

/// The path of a structure with a small imperfection, even if its bifurcation is near, is that of the imperfect structure: points at the
/// same load as equilibria of a static analysis.
#[test]
fn paths_of_imperfect_structures_are_theirs() {
    let (length, h, young) = (10.0, 0.05_f64, 1e7);
    let euler = std::f64::consts::PI.powi(2) * young * h.powi(3) / 12.0 / (4.0 * length * length);
    for (lateral, load) in [(1e-7, 0.5), (1e-4, 0.5), (1e-4, 0.97), (1e-3, 1.2)] {
        let mut m = model(plate([length, 1.0], [16, 1], 0.0), young, h);
        m.loads = vec![Load::Edge(vector_load("u_max", [-load * euler, 0.0, lateral * load * euler]))];
        m.analysis = Analysis::Path(PathAnalysis::default());
        let (outcome, _) = follow(&m, "u_max_v_min");
        m.analysis = Analysis::Static(StaticAnalysis { load_steps: 20, ..Default::default() });
        let (mesh, system) = compile(&m);
        let Analysis::Static(options) = &m.analysis else { unreachable!() };
        let found = statics::run(&system, options, None, &mut Notes::default()).unwrap();
        let [a, b] =
            [&outcome.state.u, &found.state.u].map(|u| displacement(&mesh, &system, u, "u_max_v_min").z);
        assert!((a / b - 1.0).abs() < 1e-4, "{lateral:e} {load}: {a} {b}");
        assert!(critical(&outcome).is_empty());
    }
}

/// An arch with a small side load has a limit point near the bifurcation of the perfect one, and no bifurcation.
#[test]
fn an_imperfect_arch_has_a_limit_point_in_place_of_the_bifurcation() {
    let (mut m, exact) = arch(24, 0.01);
    let loads = critical_loads(&exact);
    let path_with = |side: f64, m: &mut Model| {
        m.loads = vec![Load::Traction(vector_load("all", [side * loads[1], 0.0, -loads[1]]))];
        m.analysis = Analysis::Path(PathAnalysis { end_load: 0.9, max_steps: 60, ..Default::default() });
        critical(&follow(m, "u_min_v_min").0)[0].clone()
    };
    let perfect = path_with(0.0, &mut m);
    assert_eq!((perfect.kind, perfect.change), (CriticalKind::Bifurcation, 1));
    // Koiter: the limit load falls with the power 2/3 of the imperfection.
    let falls = [1e-4, 8e-4].map(|side| {
        let first = path_with(side, &mut m);
        assert_eq!((first.kind, first.change), (CriticalKind::Limit, 1), "{side}");
        1.0 - first.load / perfect.load
    });
    assert!(falls[0] > 0.0 && (falls[1] / falls[0] - 4.0).abs() < 0.2, "{falls:?}");
}

/// A path ends at its load factor however near it is to the start or to a limit point.
#[test]
fn paths_end_at_their_load_factor() {
    let limit = {
        let (outcome, _) = follow(&roof(4, 12.7), "u_min_v_min");
        critical(&outcome)[0].load
    };
    for end_load in [1e-12, 1e-6, limit * (1.0 - 1e-7), limit * (1.0 - 1e-3), -0.01] {
        let mut m = roof(4, 12.7);
        m.analysis = Analysis::Path(PathAnalysis { end_load, ..Default::default() });
        let (outcome, points) = follow(&m, "u_min_v_min");
        assert_eq!(outcome.state.time, end_load);
        assert!(points.iter().all(|point| point[1].abs() <= end_load.abs()), "{end_load}");
        assert!(critical(&outcome).is_empty() && points.last().unwrap()[0].abs() < 11.0);
    }
}

/// The path of a truss of two bars that carry a point mass, with long springs across its plane, does not depend on the unit of length: critical points at
/// the same load factors, once each. The limit point is that of the force 2 k (L₀/L − 1) z of the bars.
#[test]
fn paths_of_a_point_mass_do_not_depend_on_units() {
    let limit = {
        let force = |z: f64| 600.0 * (10_f64.sqrt() / (1.0 + z * z).sqrt() - 1.0) * z;
        let height = (10_f64.powf(1.0 / 3.0) - 1.0).sqrt();
        force(height)
    };
    let follow = |unit: f64, method: PathMethod| {
        let options = PathAnalysis { end_load: 1.3, method: Some(method), ..Default::default() };
        let top = [0.0, 0.0, 3.0 * unit];
        let apex = RigidBody::new("apex", top, 1.0, None);
        let mut m = Model::of_bodies(Analysis::Path(options.clone()), vec![apex], Vec::new());
        let to_top = |name: &str, foot, stiffness| spring(name, ["ground", "apex"], [foot, top], stiffness);
        m.springs = vec![
            to_top("left", [-unit, 0.0, 0.0], 300.0),
            to_top("right", [unit, 0.0, 0.0], 300.0),
            to_top("front", [0.0, -1e3 * unit, 3.0 * unit], 3000.0),
            to_top("back", [0.0, 1e3 * unit, 3.0 * unit], 3000.0),
        ];
        m.loads = vec![Load::Force(vector_load("apex", [0.0, 0.0, -limit * unit]))];
        let (_, system) = compile(&m);
        let outcome = path::run(&system, &options, None, &mut Notes::default()).unwrap();
        (critical(&outcome), outcome.statistics)
    };
    for method in [PathMethod::Series, PathMethod::ArcLength] {
        let (points, statistics) = follow(1.0, method);
        let first = points.iter().find(|p| p.kind == CriticalKind::Limit).unwrap();
        assert!((first.load - 1.0).abs() < 1e-4, "{method:?}: {}", first.load);
        for unit in [1e-6, 1e5] {
            let (other, counted) = follow(unit, method);
            assert_eq!(counted, statistics, "{method:?} {unit}");
            assert_eq!(other.len(), points.len(), "{method:?} {unit}");
            for (a, b) in points.iter().zip(&other) {
                assert!(a.kind == b.kind && (a.load - b.load).abs() < 1e-8, "{method:?} {unit}: {a:?} {b:?}");
            }
        }
    }
}
