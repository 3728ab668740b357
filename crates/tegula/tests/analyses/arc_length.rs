//! Equilibrium paths by the arc-length method: joints, bodies, beams, inextensible directors, follower loads.

use std::f64::consts::PI;

use crate::buckling::ring;
use crate::common::{compile, model, plate, vector_load};
use crate::multibody::{axis_joint, spring, torsion_spring};
use crate::paths::{FULL, critical, elastica, follow, roof, same_path_in_units};
use tegula::analysis::path::{self, CriticalKind, PathOutcome};
use tegula::analysis::{Observer, State, Step};
use tegula::model::*;
use tegula::system::System;
use tegula::{Result, Vec3};

/// Takes the arc-length method for the path of a model.
pub fn by_arc_length(m: &Model) -> Model {
    let mut m = m.clone();
    if let Analysis::Path(options) = &mut m.analysis {
        options.method = Some(PathMethod::ArcLength);
    }
    m
}

/// Observer that keeps load factor, state and messages.
#[derive(Default)]
pub struct Record {
    pub states: Vec<State>,
    pub events: Vec<String>,
}

impl Observer for Record {
    fn on_step(&mut self, step: &Step) -> Result<()> {
        self.states.push(step.state.clone());
        Ok(())
    }
    fn on_event(&mut self, message: &str) {
        self.events.push(message.into());
    }
}

pub fn run(m: &Model) -> (System, PathOutcome, Record) {
    let Analysis::Path(options) = &m.analysis else { panic!("no path") };
    let (_, system) = compile(m);
    let mut record = Record::default();
    let outcome = path::run(&system, options, None, &mut record);
    (system, outcome.unwrap_or_else(|error| panic!("{error}: {:?}", record.events)), record)
}

/// Place of a body's centre.
pub fn centre(system: &System, state: &State, body: &str) -> Vec3 {
    let body = system.coordinates.bodies.iter().find(|b| b.name == body).unwrap();
    Vec3::from(system.coordinates.reference[body.centre as usize]) + Vec3::from(state.u[body.centre as usize])
}

/// Independent program with the elements of the paper on 8 × 8 elements, by power series: limit loads (N).
#[test]
fn limit_points_of_hinged_roofs_are_those_of_power_series() {
    for (thickness, limits, counted) in
        [(12.7, [2223.04, 520.39], [22, 133, 1]), (6.35, [594.63, -382.49], [37, 203, 2])]
    {
        let m = roof(8, thickness);
        let [(outcome, points), (series, _)] = [by_arc_length(&m), m].map(|m| follow(&m, "u_min_v_min"));
        let found = critical(&outcome);
        let kinds: Vec<_> = found.iter().map(|p| (p.kind, p.change)).collect();
        assert_eq!(kinds, [(CriticalKind::Limit, 1), (CriticalKind::Limit, -1)]);
        for ((point, limit), other) in found.iter().zip(limits).zip(critical(&series)) {
            assert!((FULL * point.load - limit).abs() < 0.006, "{} {limit}", point.load);
            assert!((point.load / other.load - 1.0).abs() < 1e-8, "{} {}", point.load, other.load);
        }
        let [w, _] = points.last().unwrap();
        assert!((w / 30.0 - 1.0).abs() < 1e-6, "{w}");
        assert_eq!(outcome.state.negative_pivots, 0);
        let counts = outcome.statistics;
        assert_eq!([counts.steps, counts.factorizations, counts.cutbacks], counted);
    }
}

/// Laminates of three plies with the material of K. Y. Sze, X. H. Liu, S. H. Lo, Finite Elem. Anal. Des. 40 (2004) 1551–1569, Table 7.
#[test]
fn limit_points_of_laminated_roofs_are_those_of_power_series() {
    for angles in [[0.0, 90.0, 0.0], [90.0, 0.0, 90.0]] {
        let mut m = roof(8, 12.7);
        let name = m.sections[0].material.clone();
        let orthotropic = Orthotropic {
            young: [3300.0, 1100.0, 1100.0],
            poisson: [0.25; 3],
            shear: [660.0; 3],
            density: 1.0,
            expansion: [0.0; 3],
            strength: None,
        };
        m.materials.insert(name.clone(), Material::Orthotropic(orthotropic));
        let ply = |angle| LayupPly { material: Some(name.clone()), angle, thickness: Some(12.7 / 3.0) };
        m.sections[0].layup = Some(Layup { plies: angles.map(ply).to_vec(), ..Layup::default() });
        (m.sections[0].material, m.sections[0].thickness) = (String::new(), 0.0);
        let [(outcome, _), (series, _)] = [by_arc_length(&m), m].map(|m| follow(&m, "u_min_v_min"));
        let [found, other] = [&outcome, &series].map(critical);
        assert!(found.len() == 2 && other.len() == 2, "{angles:?}: {found:?} {other:?}");
        for (point, other) in found.iter().zip(other) {
            assert!(point.kind == CriticalKind::Limit && other.kind == CriticalKind::Limit);
            assert!((point.load / other.load - 1.0).abs() < 1e-8, "{} {}", point.load, other.load);
        }
    }
}

/// A path does not depend on units: lengths in other units, stresses in others.
#[test]
fn arc_length_paths_do_not_depend_on_units() {
    let m = by_arc_length(&roof(6, 6.35));
    let (length, stress) = (1e3, 1e9);
    let scaled = crate::paths::in_other_units(&m, length, stress);
    same_path_in_units(&m, &scaled, length);
}

/// A body on a vertical slide between two springs from supports at the distance b: with the lengths L₀ and
/// `L = √(b² + (h − w)²)` the force is `P = 2 k (L₀/L − 1)(h − w)`; it is largest where `L³ = L₀ b²`. Points of power series, which are not corrected, have
/// their residual.
#[test]
fn springs_in_a_truss_snap_at_the_load_of_von_mises() {
    let (b, h, k) = (2.0_f64, 0.5_f64, 300.0);
    let rest = b.hypot(h);
    let slide = axis_joint("slide", "ground", "apex", [0.0, 0.0, h], [0.0, 0.0, 1.0]);
    let body = RigidBody::new("apex", [0.0, 0.0, h], 1.0, Some([0.1; 3]));
    let leg = |name: &str, x: f64| spring(name, ["ground", "apex"], [[x, 0.0, 0.0], [0.0, 0.0, h]], k);
    let options = PathAnalysis { end_load: 2.0, ..Default::default() };
    let mut m = Model::of_bodies(Analysis::Path(options), vec![body], vec![Joint::Prismatic(slide.into())]);
    m.springs = vec![leg("left", -b), leg("right", b)];
    let force = |w: f64| 2.0 * k * (rest / b.hypot(h - w) - 1.0) * (h - w);
    let limit_height = ((rest * b * b).powf(2.0 / 3.0) - b * b).sqrt();
    let limit = force(h - limit_height);
    m.loads = vec![Load::Force(VectorLoad::new("apex", [0.0, 0.0, -limit]))];
    for by_formula in [false, true] {
        if by_formula {
            // The same law as a formula, which has no power series.
            for leg in &mut m.springs {
                (leg.stiffness, leg.force) = (0.0, Some(format!("{k} * x")));
            }
        }
        let (system, outcome, record) = run(&m);
        assert_eq!(record.events.iter().any(|event| event.contains("arc-length method")), by_formula);
        let found = critical(&outcome);
        assert_eq!(
            found.iter().map(|p| (p.kind, p.change)).collect::<Vec<_>>(),
            [(CriticalKind::Limit, 1), (CriticalKind::Limit, -1)]
        );
        for (point, load) in found.iter().zip([1.0, -1.0]) {
            assert!((point.load - load).abs() < 1e-9, "{} {load}", point.load);
        }
        assert_eq!(outcome.state.time, 2.0);
        for state in &record.states {
            let w = h - centre(&system, state, "apex").z;
            let accuracy = if by_formula { 1e-9 } else { 1e-5 };
            let error = (state.time - force(w) / limit).abs();
            assert!(error < accuracy, "{w} {}: {error:e}", state.time);
            let unstable = (h - w).abs() < limit_height * (1.0 - 1e-3);
            assert!(!unstable || state.negative_pivots == 1, "{w}");
        }
        // The work of the force is the energy of the springs.
        assert!(outcome.balance.strain > 0.0);
    }
}

/// Two rigid bars of length L/2 between hinges with a torsion spring k at their common one: with the angle θ of each the energy
/// ½ k (2θ)² − P L (1 − cos θ) gives P = 4 k θ/(L sin θ), from the bifurcation at 4 k/L on.
#[test]
fn a_column_of_two_rigid_bars_leaves_its_line_on_either_side() {
    let (length, stiffness) = (2.0, 30.0);
    let hinge = |name: &str, [a, b]: [&str; 2], x: f64| {
        Joint::Revolute(axis_joint(name, a, b, [x, 0.0, 0.0], [0.0, 0.0, 1.0]).into())
    };
    let bar = |name: &str, x: f64| RigidBody::new(name, [x * length, 0.0, 0.0], 1.0, Some([0.1; 3]));
    let slide = axis_joint("slide", "ground", "slider", [length, 0.0, 0.0], [1.0, 0.0, 0.0]);
    let bodies = vec![bar("left", 0.25), bar("right", 0.75), bar("slider", 1.0)];
    let joints = vec![
        hinge("foot", ["ground", "left"], 0.0),
        hinge("knee", ["left", "right"], 0.5 * length),
        hinge("head", ["right", "slider"], length),
        Joint::Prismatic(slide.into()),
    ];
    let mut m = Model::of_bodies(Analysis::Path(PathAnalysis::default()), bodies, joints);
    m.torsion_springs = vec![torsion_spring(["left", "right"], [0.0, 0.0, 1.0], stiffness)];
    m.loads = vec![Load::Force(VectorLoad::new("slider", [-4.0 * stiffness / length, 0.0, 0.0]))];
    // The line of the bars carries any load: nothing moves on it.
    let sides = [1, -1].map(|side| {
        let mut m = m.clone();
        m.loads.push(Load::Force(VectorLoad::new("left", [0.0, 1e-3 * f64::from(side), 0.0])));
        m.analysis = Analysis::Path(PathAnalysis { end_load: 1.5, ..Default::default() });
        let (system, outcome, record) = run(&m);
        assert_eq!(outcome.state.time, 1.5);
        assert!(critical(&outcome).is_empty());
        for state in &record.states {
            let at = centre(&system, state, "left");
            let theta = at.y.atan2(at.x);
            // The side load does the work of its lever of L/4.
            let p = 4.0 * stiffness / length * state.time;
            let side_moment = 1e-3 * f64::from(side) * state.time * 0.25 * length * theta.cos();
            let residual = p * length * theta.sin() + side_moment - 4.0 * stiffness * theta;
            assert!(residual.abs() < 1e-9 * stiffness, "{theta} {residual}");
        }
        centre(&system, &outcome.state, "left").y
    });
    assert!((sides[0] + sides[1]).abs() < 1e-9 && sides[0] > 0.3, "{sides:?}");
}

/// A clamped strip of length 10 and width 1 under its Euler load at load factor 1, and this load.
fn strip(n: u32, element: ElementKind, h: f64, young: f64, options: &PathAnalysis) -> (Model, f64) {
    let length = 10.0;
    let euler = PI.powi(2) * young * h.powi(3) / 12.0 / (4.0 * length * length);
    let mut strip = model(plate([length, 1.0], [n, 1], 0.0), young, h);
    if let Some(Material::Isotropic(material)) = strip.materials.values_mut().next() {
        material.poisson = 0.0;
    }
    strip.sections[0].element = element;
    strip.loads = vec![Load::Edge(vector_load("u_max", [-euler, 0.0, 0.0]))];
    strip.analysis = Analysis::Path(options.clone());
    (strip, euler)
}

/// Observer with the load factor as the column `load`.
struct LoadFactor;

impl Observer for LoadFactor {
    fn on_step(&mut self, _: &Step) -> Result<()> {
        Ok(())
    }
    fn column(&mut self, name: &str, step: &Step) -> Option<f64> {
        (name == "load").then_some(step.state.time)
    }
}

/// The coefficients of the series of a very thin strip are round-off next to its bifurcation.
#[test]
fn the_arc_length_method_goes_on_where_series_lead_no_further() {
    let options = PathAnalysis { end_load: 1.5, switch_at: vec![1], ..Default::default() };
    let (mut m, _) = strip(32, ElementKind::Ems, 0.001, 1e7, &options);
    let (system, outcome, record) = run(&m);
    let changes: Vec<&String> =
        record.events.iter().filter(|event| event.contains("power series lead no further")).collect();
    assert_eq!(changes.len(), 1, "{:?}", record.events);
    let found = critical(&outcome);
    assert!(found.len() == 1 && found[0].kind == CriticalKind::Bifurcation, "{found:?}");
    assert_eq!(outcome.state.time, 1.5);
    // The deflection of the end, which the mode moves up.
    let end = |state: &State| state.u.iter().map(|u| u[2]).fold(0.0, tegula::norm::larger) / 10.0;
    assert!((elastica(end(&outcome.state)) / 1.5 - 1.0).abs() < 1e-2, "{}", elastica(end(&outcome.state)));
    // Resumed on either side of the change.
    let Analysis::Path(options) = &m.analysis else { unreachable!() };
    for state in record.states.iter().rev().step_by(4) {
        let again = path::run(&system, options, Some(state.clone()), &mut Record::default()).unwrap();
        assert!((end(&again.state) / end(&outcome.state) - 1.0).abs() < 1e-9);
    }
    // A stop condition that is met in the first step behind the change: the step is repeated from where it began.
    let is_behind = |state: &State| state.path.as_ref().is_some_and(|path| path.arc.is_some());
    let first = record.states.iter().position(is_behind).unwrap();
    let begun = if first == 0 { 0.0 } else { record.states[first - 1].time };
    let wanted = 0.5 * (begun + record.states[first].time);
    let mut stopping = m.clone();
    if let Analysis::Path(options) = &mut stopping.analysis {
        options.stop =
            vec![StopCondition { column: "load".into(), value: wanted, direction: Crossing::Rising }];
    }
    let Analysis::Path(with_stop) = &stopping.analysis else { unreachable!() };
    let stopped = path::run(&system, with_stop, None, &mut LoadFactor).unwrap();
    let at = stopped.state.time;
    assert!(stopped.stopped.is_some() && (at / wanted - 1.0).abs() < 1e-5, "{at} {wanted}");
    // Wanted series end with an error.
    if let Analysis::Path(options) = &mut m.analysis {
        options.method = Some(PathMethod::Series);
    }
    let Analysis::Path(options) = &m.analysis else { unreachable!() };
    assert!(path::run(&system, options, None, &mut Record::default()).is_err());
}

/// A still thinner strip has no series at the start of the path.
#[test]
fn the_arc_length_method_begins_where_there_are_no_series() {
    let options = PathAnalysis { end_load: 1.5, switch_at: vec![1], ..Default::default() };
    let (m, _) = strip(32, ElementKind::Ems, 0.0002, 1e7, &options);
    let (_, outcome, record) = run(&m);
    let changes = record.events.iter().filter(|event| event.contains("no further than load factor 0.0"));
    assert_eq!(changes.count(), 1, "{:?}", record.events);
    let end = outcome.state.u.iter().map(|u| u[2]).fold(0.0, tegula::norm::larger) / 10.0;
    assert!((elastica(end) / 1.5 - 1.0).abs() < 2e-3, "{}", elastica(end));
}

/// Slightly curved strips, which bend more and more below the Euler load, where a small residual stands for a large error along the path: the end of the
/// path is the equilibrium of statics.
#[test]
fn paths_of_very_thin_imperfect_strips_are_those_of_statics() {
    for (h, load) in [(0.01, 1.0), (0.0005, 0.998)] {
        let (mut m, _) =
            strip(32, ElementKind::Ems, h, 1e7, &PathAnalysis { end_load: load, ..Default::default() });
        m.imperfections = vec![Imperfection::Mode(ModeImperfection { mode: 1, amplitude: 1e-5 })];
        let nominal = tegula::mesh::generators::generate(&m.mesh).unwrap();
        let mesh =
            tegula::compile::imperfect_mesh(&m, &nominal, &mut tegula::analysis::Silent).unwrap().unwrap();
        let ends = [
            m.analysis.clone(),
            Analysis::Path(PathAnalysis {
                end_load: load,
                method: Some(PathMethod::ArcLength),
                ..Default::default()
            }),
            Analysis::Static(StaticAnalysis::default()),
        ]
        .map(|analysis| {
            let mut m = Model { analysis, ..m.clone() };
            let state = match &m.analysis.clone() {
                Analysis::Path(options) => {
                    let system = tegula::compile::build(&m, &mesh).unwrap();
                    path::run(&system, options, None, &mut tegula::analysis::Silent).unwrap().state
                }
                Analysis::Static(options) => {
                    m.loads = m.loads.iter().map(|l| scaled(l, load)).collect();
                    let system = tegula::compile::build(&m, &mesh).unwrap();
                    tegula::analysis::statics::run(&system, options, None, &mut tegula::analysis::Silent)
                        .unwrap()
                        .state
                }
                _ => unreachable!(),
            };
            state.u.iter().map(|u| u[2].abs()).fold(0.0, tegula::norm::larger)
        });
        assert!(ends[2] > 1e-4, "{ends:?}");
        for end in &ends[..2] {
            assert!((end / ends[2] - 1.0).abs() < 1e-4, "{h}: {ends:?}");
        }
    }
}

fn scaled(load: &Load, factor: f64) -> Load {
    let Load::Edge(load) = load else { panic!("no load on an edge") };
    Load::Edge(VectorLoad { value: load.value.map(|x| factor * x), ..load.clone() })
}

/// Post-buckling of a strip of elements with inextensible directors, and of a beam, L/h = 200.
#[test]
fn buckled_strips_and_beams_are_elasticas() {
    let (length, h, young) = (10.0, 0.05_f64, 1e7);
    let options = PathAnalysis { end_load: 1.5, switch_at: vec![1], ..Default::default() };
    let (strip, euler) = strip(64, ElementKind::Mitc4, h, young, &options);
    let section = BeamSection::Rectangle(RectangularSection { size: [h, 1.0] });
    let ends = [[0.0; 3], [length, 0.0, 0.0]];
    let beam = Beam {
        material: Some("steel".into()),
        ..Beam::straight("column", ends, 96, [0.0, 0.0, 1.0], section)
    };
    let foot = Joint::Fixed(PointJoint {
        name: "foot".into(),
        between: ["ground".into(), "column.start".into()],
        at: [0.0; 3],
        second_at: None,
    });
    let mut column = Model::of_bodies(Analysis::Path(options), Vec::new(), vec![foot]);
    column.materials.insert("steel".into(), Material::Isotropic(Isotropic::new(young, 0.0, 1.0)));
    column.beams = vec![beam];
    column.loads = vec![Load::Force(VectorLoad::new("column.end", [-euler, 0.0, 0.0]))];
    for (m, name) in [(strip, "strip"), (column, "column")] {
        let (system, outcome, record) = run(&m);
        let found = critical(&outcome);
        assert_eq!(
            found.iter().map(|p| (p.kind, p.change)).collect::<Vec<_>>(),
            [(CriticalKind::Bifurcation, 1)],
            "{name}"
        );
        assert!((found[0].load - 1.0).abs() < 3e-4, "{name} {}", found[0].load);
        assert_eq!(outcome.state.negative_pivots, 0, "{name}");
        assert_eq!(outcome.state.time, 1.5, "{name}");
        let deflection = |state: &State| {
            let tip = system.coordinates.reference.iter().zip(&state.u).filter(|(x, _)| x[0] == length);
            tip.map(|(_, u)| u[2].abs()).fold(0.0, tegula::norm::larger) / length
        };
        let mut compared = 0;
        for state in &record.states {
            let z = deflection(state);
            if z > 0.05 {
                let exact = elastica(z);
                assert!((state.time / exact - 1.0).abs() < 1e-3, "{name} {z}: {} {exact}", state.time);
                compared += 1;
            }
        }
        assert!(compared > 5, "{name} {compared}");
    }
}

/// A run that is resumed from any of its states ends in the same bits.
#[test]
fn arc_length_paths_are_resumed_to_the_bit() {
    let mut m = by_arc_length(&roof(6, 12.7));
    if let Analysis::Path(options) = &mut m.analysis {
        options.stop.clear();
        options.end_load = 0.9;
    }
    let (system, outcome, record) = run(&m);
    let Analysis::Path(options) = &m.analysis else { unreachable!() };
    for state in record.states.iter().step_by(3) {
        let again = path::run(&system, options, Some(state.clone()), &mut Record::default()).unwrap();
        assert_eq!(again.state, outcome.state);
        assert_eq!(again.balance, outcome.balance);
    }
}

/// A body between two springs of slightly different stiffness that are steeper than wide: the path of the perfect truss bifurcates, and that
/// of the imperfect one turns aside at the bifurcation. Limit loads of a continuation with two unknowns: ±233.574 for k and 1.001 k, ±235.014 for k and
/// (1 + 1/3e5) k.
#[test]
fn steps_do_not_leap_over_the_turn_beside_a_bifurcation() {
    for (second, limit, load) in
        [(300.3, 233.574, 700.0), (300.001, 235.014, 700.0), (303.0, f64::NAN, 700.0)]
    {
        for unit in [1.0, 1e-3] {
            let h = 3.0 * unit;
            let body = RigidBody::new("apex", [0.0, 0.0, h], 1.0, Some([0.01; 3]));
            let plane = axis_joint("plane", "ground", "apex", [0.0, 0.0, h], [0.0, 1.0, 0.0]);
            let leg = |name: &str, x: f64, k: f64| {
                spring(name, ["ground", "apex"], [[x * unit, 0.0, 0.0], [0.0, 0.0, h]], k / unit)
            };
            let analysis = Analysis::Path(PathAnalysis::default());
            let mut m = Model::of_bodies(analysis, vec![body], vec![Joint::Planar(plane)]);
            m.springs = vec![leg("left", -1.0, 300.0), leg("right", 1.0, second)];
            m.torsion_springs = vec![torsion_spring(["ground", "apex"], [0.0, 1.0, 0.0], 10.0 * unit)];
            m.loads = vec![Load::Force(VectorLoad::new("apex", [0.0, 0.0, -load]))];
            let (_, outcome, _) = run(&m);
            let found = critical(&outcome);
            assert!(found.iter().all(|p| p.kind == CriticalKind::Limit), "{second} {unit}");
            assert_eq!(found.len(), 2, "{second} {unit}");
            assert_eq!(outcome.state.time, 1.0);
            if limit.is_finite() {
                for (point, sign) in found.iter().zip([1.0, -1.0]) {
                    assert!((point.load * load - sign * limit).abs() < 2e-3, "{} {limit}", point.load * load);
                }
            }
        }
    }
}

/// The truss of von Mises below a soft spring whose other end a drive moves down by D per load factor: with the force P(w) of the truss at
/// the deflection w the drive is at `λ = (w + P(w)/c)/D`, which has limit points where the soft spring lets the truss snap.
#[test]
fn a_driven_truss_snaps_at_the_limits_of_its_drive() {
    let (b, h, k, soft, drive) = (2.0_f64, 0.5_f64, 300.0, 5.0, 3.0);
    let rest = b.hypot(h);
    let slide = |name: &str, body: &str, z: f64| {
        Joint::Prismatic(axis_joint(name, "ground", body, [0.0, 0.0, z], [0.0, 0.0, 1.0]).into())
    };
    let body = |name: &str, z: f64| RigidBody::new(name, [0.0, 0.0, z], 1.0, Some([0.1; 3]));
    let (apex, carriage) = ([0.0, 0.0, h], [0.0, 0.0, h + 5.0]);
    let joints = vec![
        slide("slide", "apex", h),
        slide("guide", "carriage", h + 5.0),
        Joint::DrivenLength(DrivenLengthJoint {
            name: "drive".into(),
            between: ["ground".into(), "carriage".into()],
            at: carriage,
            axis: [0.0, 0.0, -1.0],
            length: drive,
            amplitude: "t".into(),
        }),
    ];
    let path_to = |end_load: f64| {
        let analysis = Analysis::Path(PathAnalysis { end_load, ..Default::default() });
        let bodies = vec![body("apex", h), body("carriage", h + 5.0)];
        let mut m = Model::of_bodies(analysis, bodies, joints.clone());
        let t = ExpressionAmplitude { expression: "t".into() };
        m.amplitudes.insert("t".into(), Amplitude::Expression(t));
        m.springs = vec![
            spring("left", ["ground", "apex"], [[-b, 0.0, 0.0], apex], k),
            spring("right", ["ground", "apex"], [[b, 0.0, 0.0], apex], k),
            spring("soft", ["carriage", "apex"], [carriage, apex], soft),
        ];
        m
    };
    let force = |w: f64| 2.0 * k * (rest / b.hypot(h - w) - 1.0) * (h - w);
    let at = |w: f64| (w + force(w) / soft) / drive;
    // The maximum lies before the flat position, the minimum behind it.
    let extremum = |sign: f64| {
        let side = (0..50_000).map(|i| h - sign * 1e-5 * f64::from(i));
        sign * side.map(|w| sign * at(w)).max_by(f64::total_cmp).unwrap()
    };
    let (_, outcome, record) = run(&path_to(1.0));
    let system = compile(&path_to(1.0)).1;
    let found = critical(&outcome);
    let kinds: Vec<_> = found.iter().map(|p| (p.kind, p.change)).collect();
    assert_eq!(kinds, [(CriticalKind::Limit, 1), (CriticalKind::Limit, -1)]);
    for (point, sign) in found.iter().zip([1.0, -1.0]) {
        let exact = extremum(sign);
        assert!((point.load - exact).abs() < 1e-8, "{} {exact}", point.load);
    }
    let (other, _, falling) = run(&path_to(-0.5));
    for (system, states) in [(&system, &record.states), (&other, &falling.states)] {
        for state in states {
            let w = h - centre(system, state, "apex").z;
            assert!((state.time - at(w)).abs() < 1e-9, "{w} {}", state.time);
        }
    }
    assert_eq!(falling.states.last().unwrap().time, -0.5);
}

/// Loads along a rigid bar, under which it stands still, and amplitudes with a maximum are refused with the reason.
#[test]
fn loads_without_a_path_are_refused() {
    let refused = |load: [f64; 3], expression: &str| {
        let bar = RigidBody::new("bar", [1.0, 0.0, 0.0], 1.0, Some([0.1; 3]));
        let foot = axis_joint("foot", "ground", "bar", [0.0; 3], [0.0, 0.0, 1.0]);
        let analysis = Analysis::Path(PathAnalysis::default());
        let mut m = Model::of_bodies(analysis, vec![bar], vec![Joint::Revolute(foot.into())]);
        m.torsion_springs = vec![torsion_spring(["ground", "bar"], [0.0, 0.0, 1.0], 2.0)];
        let amplitude = ExpressionAmplitude { expression: expression.into() };
        m.amplitudes.insert("a".into(), Amplitude::Expression(amplitude));
        m.loads =
            vec![Load::Force(VectorLoad { amplitude: Some("a".into()), ..VectorLoad::new("bar", load) })];
        let mesh = tegula::mesh::generators::generate(&m.mesh).unwrap();
        let system = match tegula::compile::build(&m, &mesh) {
            Ok(system) => system,
            Err(error) => return error.to_string(),
        };
        path::run(&system, &PathAnalysis::default(), None, &mut Record::default()).unwrap_err().to_string()
    };
    let along = refused([-5.0, 0.0, 0.0], "t");
    assert!(along.contains("nothing moves"), "{along}");
    for expression in ["sin(3*t)", "t^2", "1 - cos(t)"] {
        let message = refused([0.0, 1.0, 0.0], expression);
        assert!(message.contains("slope of the amplitude \"a\""), "{expression}: {message}");
    }
}

/// A ring under pressure has a potential between its planes of symmetry, though its load stiffness has skew blocks there: the bifurcation of the
/// path is the load factor of linear buckling, but for the compression of the ring, `(h/R)²/4`.
#[test]
fn pressures_with_a_potential_have_bifurcations() {
    let mut m = ring(32);
    let factor = crate::buckling::factors(&m)[0];
    if let Load::Pressure(pressure) = &mut m.loads[0] {
        pressure.value = factor;
    }
    m.analysis = Analysis::Path(PathAnalysis { end_load: 1.1, ..Default::default() });
    let (_, outcome, _) = run(&m);
    let found = critical(&outcome);
    assert_eq!(
        found.iter().map(|p| (p.kind, p.change)).collect::<Vec<_>>(),
        [(CriticalKind::Bifurcation, 1)]
    );
    assert!((found[0].load - 1.0).abs() < 1e-4, "{}", found[0].load);
}
