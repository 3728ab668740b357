//! Analyses that go on where loads have a limit: statics along the path, and steps behind paths that end anywhere.

use crate::arches::{arch, critical_loads};
use crate::common::{Notes, compile, vector_load};
use crate::multibody::{axis_joint, spring};
use crate::paths::roof;
use tegula::Vec3;
use tegula::analysis::path::{self, CriticalKind};
use tegula::analysis::{Observer, State, Step, dynamics, modal, statics};
use tegula::compile::Compiler;
use tegula::mesh::generators::generate;
use tegula::model::*;
use tegula::system::System;
use tegula::{Error, Result};

/// Half the span, height and spring stiffness of the truss.
const TRUSS: (f64, f64, f64) = (2.0, 0.5, 300.0);
const MASS: f64 = 3.0;

/// Force of the truss at the deflection w.
fn force(w: f64) -> f64 {
    let (b, h, k) = TRUSS;
    2.0 * k * (b.hypot(h) / b.hypot(h - w) - 1.0) * (h - w)
}

/// Largest force, and the deflection there: `L³ = L₀ b²`.
fn limit() -> (f64, f64) {
    let (b, h, _) = TRUSS;
    let height = ((b.hypot(h) * b * b).powf(2.0 / 3.0) - b * b).sqrt();
    (force(h - height), h - height)
}

/// Deflection on the side beyond the snap at which the truss has a force.
fn behind_the_snap(wanted: f64) -> f64 {
    let (mut low, mut high) = (1.4 * TRUSS.1, 10.0 * TRUSS.1);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        *(if force(middle) < wanted { &mut low } else { &mut high }) = middle;
    }
    low
}

/// Body on a vertical slide between two springs, under a force.
fn truss(analysis: Analysis, load: f64) -> Model {
    let (b, h, k) = TRUSS;
    let slide = axis_joint("slide", "ground", "apex", [0.0, 0.0, h], [0.0, 0.0, 1.0]);
    let body = RigidBody::new("apex", [0.0, 0.0, h], MASS, Some([0.1; 3]));
    let leg = |name: &str, x: f64| spring(name, ["ground", "apex"], [[x, 0.0, 0.0], [0.0, 0.0, h]], k);
    let mut m = Model::of_bodies(analysis, vec![body], vec![Joint::Prismatic(slide.into())]);
    m.springs = vec![leg("left", -b), leg("right", b)];
    m.loads = vec![Load::Force(vector_load("apex", [0.0, 0.0, -load]))];
    m
}

fn with_steps(m: Model, steps: Vec<AnalysisStep>) -> Model {
    Model { steps, ..m }
}

fn deflection(system: &System, state: &State) -> f64 {
    let body = &system.coordinates.bodies[0];
    -Vec3::from(state.u[body.centre as usize]).z
}

/// Observer that keeps messages and states, and has the deflection of the truss as the column `w`.
struct Record<'a> {
    system: &'a System,
    notes: Notes,
}

impl<'a> Record<'a> {
    fn new(system: &'a System) -> Self {
        Self { system, notes: Notes::keeping() }
    }
}

impl Observer for Record<'_> {
    fn on_step(&mut self, step: &Step) -> Result<()> {
        self.notes.on_step(step)
    }
    fn on_event(&mut self, message: &str) {
        self.notes.on_event(message);
    }
    fn column(&mut self, name: &str, step: &Step) -> Option<f64> {
        (name == "w").then(|| deflection(self.system, step.state))
    }
}

fn continued() -> StaticAnalysis {
    StaticAnalysis { continuation: Some(Continuation::Path), ..Default::default() }
}

/// A load of 1.5 times the limit: load steps end at the limit point, and the path leads to the equilibrium beyond the snap.
#[test]
fn statics_go_on_along_the_path_behind_a_limit_point() {
    let full = 1.5 * limit().0;
    let m = truss(Analysis::Static(continued()), full);
    let Analysis::Static(options) = &m.analysis else { unreachable!() };
    let (_, system) = compile(&m);
    let mut record = Record::new(&system);
    let outcome = statics::run(&system, options, None, &mut record).unwrap();
    let exact = behind_the_snap(full);
    assert!((deflection(&system, &outcome.state) / exact - 1.0).abs() < 1e-9);
    assert_eq!((outcome.state.time, outcome.negative_pivots), (1.0, 0));
    assert!(
        record.notes.events.iter().any(|event| event.contains("goes on along the equilibrium path")),
        "{:?}",
        record.notes.events
    );
    let path = outcome.state.path.as_ref().unwrap();
    assert_eq!(path.critical.len(), 2);
    assert!((path.critical[0].load * full / limit().0 - 1.0).abs() < 1e-9);
    for state in &record.notes.states {
        let w = deflection(&system, state);
        assert!((state.time * full - force(w)).abs() < 1e-8 * full, "{w} {}", state.time);
    }
    let positions: Vec<f64> =
        record.notes.states.iter().map(|state| state.path.as_ref().unwrap().position).collect();
    assert!(positions.windows(2).all(|pair| pair[0] < pair[1]), "{positions:?}");
    // Resumed anywhere, in load steps and on the path.
    for state in &record.notes.states[..record.notes.states.len() - 1] {
        let again = statics::run(&system, options, Some(state.clone()), &mut Record::new(&system)).unwrap();
        assert_eq!(again.state.u, outcome.state.u);
    }
    // A stop condition on the unstable part.
    for (w, direction) in [(0.5, Crossing::Rising), (0.1, Crossing::Either)] {
        let stop = vec![StopCondition { column: "w".into(), value: w, direction }];
        let stopping = StaticAnalysis { stop, ..options.clone() };
        let stopped = statics::run(&system, &stopping, None, &mut Record::new(&system)).unwrap();
        assert!((deflection(&system, &stopped.state) - w).abs() < 1e-6, "{w}");
    }
    // Without the key the limit point is an error that names it.
    let m = truss(Analysis::Static(StaticAnalysis::default()), full);
    let Analysis::Static(options) = &m.analysis else { unreachable!() };
    let (_, system) = compile(&m);
    let message = statics::run(&system, options, None, &mut Record::new(&system)).unwrap_err().to_string();
    assert!(message.contains("limit point") && message.contains("continue = \"path\""), "{message}");
}

/// Statics without a limit point take load steps only, and are those without the key, to the bit.
#[test]
fn statics_below_the_limit_take_load_steps_only() {
    let run = |options: StaticAnalysis| {
        let m = truss(Analysis::Static(options.clone()), 0.9 * limit().0);
        let (_, system) = compile(&m);
        statics::run(&system, &options, None, &mut Record::new(&system)).unwrap()
    };
    let [plain, other] = [StaticAnalysis::default(), continued()].map(run);
    assert_eq!((plain.state.u, plain.statistics), (other.state.u, other.statistics));
}

/// The hinged roof of shells beyond its limit load: statics end where the path ends.
#[test]
fn statics_of_shells_go_on_to_the_end_of_the_path() {
    let mut m = roof(8, 12.7);
    let outcome = |m: &Model| {
        let (_, system) = compile(m);
        match &m.analysis {
            Analysis::Static(options) => {
                statics::run(&system, options, None, &mut Record::new(&system)).unwrap().state
            }
            Analysis::Path(options) => {
                path::run(&system, options, None, &mut Record::new(&system)).unwrap().state
            }
            _ => unreachable!(),
        }
    };
    m.analysis = Analysis::Path(PathAnalysis::default());
    let by_path = outcome(&m);
    m.analysis = Analysis::Static(continued());
    let by_statics = outcome(&m);
    assert_eq!((by_path.time, by_statics.time, by_statics.negative_pivots), (1.0, 1.0, 0));
    let size = |u: &[[f64; 3]]| u.iter().flatten().map(|x| x * x).sum::<f64>().sqrt();
    let difference: Vec<[f64; 3]> =
        by_path.u.iter().zip(&by_statics.u).map(|(a, b)| std::array::from_fn(|i| a[i] - b[i])).collect();
    assert!(size(&difference) < 1e-7 * size(&by_path.u), "{:e}", size(&difference) / size(&by_path.u));
}

#[test]
fn statics_that_cannot_go_on_are_refused() {
    let with = |change: &dyn Fn(&mut StaticAnalysis)| {
        let mut options = continued();
        change(&mut options);
        let m = truss(Analysis::Static(options), 1.0);
        let mesh = generate(&m.mesh).unwrap();
        match tegula::compile::build(&m, &mesh) {
            Err(Error::Model(issues)) => issues.iter().any(|issue| issue.place.key == "analysis.continue"),
            _ => false,
        }
    };
    assert!(with(&|o| o.linear = true));
    assert!(with(&|o| o.linear_solver = LinearSolver::Iterative));
    assert!(with(&|o| o.inertia_relief = true));
    assert!(!with(&|_| {}));
}

fn motion(end: f64) -> Analysis {
    let scheme = Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 });
    Analysis::Transient(TransientAnalysis { scheme, ..TransientAnalysis::new(end) })
}

/// Runs the steps of the truss; returns the system and the last state of each, and all states.
fn run_steps(m: &Model) -> Vec<(State, Vec<[f64; 2]>, Vec<String>)> {
    let mesh = generate(&m.mesh).unwrap();
    let mut compiler = Compiler::new(m, &mesh).unwrap();
    let mut ends: Vec<(State, Vec<[f64; 2]>, Vec<String>)> = Vec::new();
    for i in 0..compiler.steps().len() {
        let start = i.checked_sub(1).map(|before| ends[before].0.end_of_step());
        let system = compiler.system(i, start).unwrap();
        let mut record = Record::new(&system);
        let state = match &compiler.steps()[i].model.analysis {
            Analysis::Static(options) => statics::run(&system, options, None, &mut record).unwrap().state,
            Analysis::Path(options) => path::run(&system, options, None, &mut record).unwrap().state,
            Analysis::Transient(options) => dynamics::run(&system, options, None, &mut record).unwrap().state,
            Analysis::Modal(_) | Analysis::Buckling(_) => unreachable!(),
        };
        let points = record.notes.states.iter().map(|s| [s.time, deflection(&system, s)]).collect();
        let messages = record.notes.events;
        compiler.end_step(i, state.time);
        ends.push((state, points, messages));
    }
    ends
}

/// A path to the limit point, then the motion under the load there and a push of 1 %: with damping it comes to rest in the equilibrium beyond
/// the snap, under both loads.
#[test]
fn a_snap_is_followed_dynamically_from_the_limit_point() {
    let full = 2.0 * limit().0;
    let to_limit = PathAnalysis { end_at: Some(PathEnd::LimitPoint), ..Default::default() };
    let mut snap = AnalysisStep::new("snap", motion(60.0));
    let push = 0.01 * full;
    snap.loads = vec![Load::Force(vector_load("apex", [0.0, 0.0, -push]))];
    let mut m = truss(Analysis::Static(StaticAnalysis::default()), full);
    for leg in &mut m.springs {
        leg.damping = 30.0;
    }
    let m = with_steps(m, vec![AnalysisStep::new("path", Analysis::Path(to_limit)), snap]);
    let ends = run_steps(&m);
    assert!((ends[0].0.time - 0.5).abs() < 1e-9, "{}", ends[0].0.time);
    assert!((ends[0].1.last().unwrap()[1] - limit().1).abs() < 1e-4);
    // The motion begins where the path has ended, slowly.
    let [_, first] = ends[1].1[0];
    assert_eq!(first, ends[0].1.last().unwrap()[1]);
    let exact = behind_the_snap(limit().0 + push);
    let [_, last] = *ends[1].1.last().unwrap();
    assert!((last - exact).abs() < 1e-5 * exact, "{last} {exact}");
}

/// A path that a stop condition ends at 0.6 of the limit load: a motion stays in the equilibrium there, another static step leads from there to the
/// full load.
#[test]
fn loads_continue_from_where_a_path_has_ended() {
    let full = 0.9 * limit().0;
    let half = 0.5 * limit().1;
    let stop = vec![StopCondition { column: "w".into(), value: half, direction: Crossing::Rising }];
    let first = [
        Analysis::Path(PathAnalysis { stop: stop.clone(), ..Default::default() }),
        Analysis::Static(StaticAnalysis { stop, ..Default::default() }),
        Analysis::Path(PathAnalysis { end_load: 0.4, ..Default::default() }),
    ];
    for analysis in first {
        let rest = AnalysisStep::new("rest", motion(2.0));
        let begin = AnalysisStep::new("begin", analysis);
        let m = truss(Analysis::Static(StaticAnalysis::default()), full);
        let still = run_steps(&with_steps(m.clone(), vec![begin.clone(), rest]));
        let w = still[0].1.last().unwrap()[1];
        assert!((still[0].0.time * full / force(w) - 1.0).abs() < 1e-6);
        for [_, there] in &still[1].1 {
            assert!((there - w).abs() < 1e-6 * w, "{there} {w}");
        }
        let up =
            AnalysisStep::new("up", Analysis::Static(StaticAnalysis { load_steps: 4, ..Default::default() }));
        let again = AnalysisStep::new("again", Analysis::Path(PathAnalysis::default()));
        for next in [up, again] {
            let loaded = run_steps(&with_steps(m.clone(), vec![begin.clone(), next]));
            for [factor, there] in &loaded[1].1 {
                let load = loaded[0].0.time + factor * (1.0 - loaded[0].0.time);
                assert!((force(*there) - load * full).abs() < 1e-7 * full, "{factor} {there}");
            }
            assert_eq!(loaded[1].0.time, 1.0);
        }
    }
}

/// The frequency about the end of a path is that of the truss there, `ω² = P'(w)/m`, also of a load that turns with the body.
#[test]
fn modes_about_the_end_of_a_path_are_those_of_its_load() {
    let full = 1.0;
    let wanted = 0.3 * limit().1;
    let stop = vec![StopCondition { column: "w".into(), value: wanted, direction: Crossing::Rising }];
    let modes = AnalysisStep::new("modes", Analysis::Modal(ModalAnalysis::new(1)));
    let begin = AnalysisStep::new(
        "path",
        Analysis::Path(PathAnalysis { stop, end_load: 100.0, ..Default::default() }),
    );
    let m = with_steps(truss(Analysis::Static(StaticAnalysis::default()), full), vec![begin, modes]);
    let mesh = generate(&m.mesh).unwrap();
    let mut compiler = Compiler::new(&m, &mesh).unwrap();
    let system = compiler.system(0, None).unwrap();
    let Analysis::Path(options) = &compiler.steps()[0].model.analysis else { unreachable!() };
    let end = path::run(&system, options, None, &mut Record::new(&system)).unwrap().state;
    let w = deflection(&system, &end);
    // The compiler is to know where the path has ended.
    let Err(Error::Model(issues)) = compiler.system(1, Some(end.end_of_step())) else { panic!("accepted") };
    assert!(issues[0].help.contains("end_step"), "{:?}", issues[0]);
    compiler.end_step(0, end.time);
    let system = compiler.system(1, Some(end.end_of_step())).unwrap();
    let state = State::first(&system);
    let mut external = vec![[0.0; 3]; system.vectors()];
    system.add_dead_loads(state.time, 1.0, &mut external);
    let vertical: f64 = external.iter().map(|f| f[2]).sum();
    assert!((vertical / -force(w) - 1.0).abs() < 1e-6, "{vertical} {}", force(w));
    let mode = modal::run(&system, 1, Some(&state), &mut Record::new(&system)).unwrap().modes.remove(0);
    let slope = (force(w + 1e-6) - force(w - 1e-6)) / 2e-6;
    let exact = (slope / MASS).sqrt() / (2.0 * std::f64::consts::PI);
    assert!((mode.frequency_hz / exact - 1.0).abs() < 1e-5, "{} {exact}", mode.frequency_hz);
}

/// A pinned arch bifurcates before its limit point: paths of either method end at the point that is named, at the loads of the closed form.
#[test]
fn paths_end_at_the_critical_point_that_is_named() {
    let (mut m, shape) = arch(48, 0.01);
    let [bifurcation, limit, ..] = critical_loads(&shape);
    m.loads = vec![Load::Traction(vector_load("all", [0.0, 0.0, -limit]))];
    let ends = [
        (PathEnd::Bifurcation, CriticalKind::Bifurcation, bifurcation, 0),
        (PathEnd::LimitPoint, CriticalKind::Limit, limit, 1),
        (PathEnd::CriticalPoint, CriticalKind::Bifurcation, bifurcation, 0),
    ];
    for method in [PathMethod::Series, PathMethod::ArcLength] {
        for (end, kind, load, before) in ends {
            let options =
                PathAnalysis { end_at: Some(end), end_load: 1.5, method: Some(method), ..Default::default() };
            m.analysis = Analysis::Path(options.clone());
            let (_, system) = compile(&m);
            let state = path::run(&system, &options, None, &mut Record::new(&system)).unwrap().state;
            let path = state.path.clone().unwrap();
            let last = path.critical.last().unwrap();
            assert_eq!((last.kind, path.critical.len()), (kind, before + 1), "{method:?} {end:?}");
            assert!((state.time / last.load - 1.0).abs() < 1e-7, "{} {}", state.time, last.load);
            assert!((state.time * limit / load - 1.0).abs() < 0.005, "{method:?} {end:?} {}", state.time);
        }
        // A path without such a point says so.
        let options = PathAnalysis {
            end_at: Some(PathEnd::LimitPoint),
            end_load: 0.1,
            method: Some(method),
            ..Default::default()
        };
        m.analysis = Analysis::Path(options.clone());
        let (_, system) = compile(&m);
        let mut record = Record::new(&system);
        assert_eq!(path::run(&system, &options, None, &mut record).unwrap().state.time, 0.1);
        assert!(
            record.notes.events.iter().any(|warning| warning.contains("end_at")),
            "{:?}",
            record.notes.events
        );
    }
}

/// A motion prescribed without amplitude stays where the path has ended.
#[test]
fn prescribed_motions_stay_where_a_path_has_ended() {
    let mut m = roof(4, 12.7);
    m.loads.clear();
    let down = PrescribeComponent {
        on: "u_min".into(),
        of: NodalVector::Position,
        component: Axis::Z,
        value: 5.0,
        amplitude: None,
    };
    m.conditions = vec![Condition::Clamp(OnSet { on: "u_max".into() }), Condition::Prescribe(down)];
    let path =
        AnalysisStep::new("path", Analysis::Path(PathAnalysis { end_load: 0.2, ..Default::default() }));
    let rest = AnalysisStep::new("rest", Analysis::Transient(TransientAnalysis::new(1e-3)));
    let m = with_steps(m, vec![path, rest]);
    let mesh = generate(&m.mesh).unwrap();
    let mut compiler = Compiler::new(&m, &mesh).unwrap();
    let system = compiler.system(0, None).unwrap();
    let Analysis::Path(options) = &compiler.steps()[0].model.analysis else { unreachable!() };
    let end = path::run(&system, options, None, &mut tegula::analysis::Silent).unwrap().state;
    compiler.end_step(0, end.time);
    let system = compiler.system(1, Some(end.end_of_step())).unwrap();
    let step = &compiler.steps()[1];
    assert!(tegula::compile::warnings_at_start(step, &system).is_empty());
    let Analysis::Transient(options) = &step.model.analysis else { unreachable!() };
    let state = dynamics::run(&system, options, None, &mut tegula::analysis::Silent).unwrap().state;
    let largest = |u: &[[f64; 3]]| u.iter().flatten().fold(0.0, |a, b| tegula::norm::larger(a, b.abs()));
    let moved: Vec<[f64; 3]> =
        state.u.iter().zip(&end.u).map(|(a, b)| std::array::from_fn(|i| a[i] - b[i])).collect();
    assert!((largest(&end.u) - 1.0).abs() < 0.3);
    assert!(largest(&moved) < 1e-6, "{:e}", largest(&moved));
}

/// A path that has ended at the limit point, or behind it: the next path and statics that go on along it lead forward, to the equilibrium beyond the
/// snap under the full load, with all points on the curve of the truss.
#[test]
fn paths_go_on_forward_from_a_limit_point_and_behind_it() {
    let full = 1.5 * limit().0;
    let stop = vec![StopCondition { column: "w".into(), value: 0.8 * TRUSS.1, direction: Crossing::Rising }];
    let firsts = [
        PathAnalysis { end_at: Some(PathEnd::LimitPoint), ..Default::default() },
        PathAnalysis { stop, ..Default::default() },
    ];
    let nexts = [Analysis::Path(PathAnalysis::default()), Analysis::Static(continued())];
    for first in &firsts {
        for next in &nexts {
            let steps = vec![
                AnalysisStep::new("first", Analysis::Path(first.clone())),
                AnalysisStep::new("next", next.clone()),
            ];
            let m = with_steps(truss(Analysis::Static(StaticAnalysis::default()), full), steps);
            let ends = run_steps(&m);
            let start = ends[0].0.time;
            assert_eq!(ends[1].0.time, 1.0);
            for [factor, w] in &ends[1].1 {
                let load = start + factor * (1.0 - start);
                assert!((force(*w) - load * full).abs() < 1e-7 * full, "{factor} {w}");
                assert!(*w > ends[0].1.last().unwrap()[1] - 1e-6, "{w}");
            }
            let w = ends[1].1.last().unwrap()[1];
            assert!((w / behind_the_snap(full) - 1.0).abs() < 1e-7, "{w}");
        }
    }
}

/// Loads that a motion keeps from the path before it stay through the next motions, too.
#[test]
fn loads_stay_through_all_motions_behind_a_path() {
    let path =
        AnalysisStep::new("path", Analysis::Path(PathAnalysis { end_load: 0.4, ..Default::default() }));
    let steps = vec![path, AnalysisStep::new("first", motion(1.0)), AnalysisStep::new("second", motion(1.0))];
    let m = with_steps(truss(Analysis::Static(StaticAnalysis::default()), 0.9 * limit().0), steps);
    let ends = run_steps(&m);
    let w = ends[0].1.last().unwrap()[1];
    assert!(w > 0.01);
    for [_, there] in ends[1].1.iter().chain(&ends[2].1) {
        assert!((there - w).abs() < 1e-6 * w, "{there} {w}");
    }
}

/// A strip that natural curvature has bent freely has no stress, and a path begins there: its end lies at `(1 − cos κL)/κ`.
#[test]
fn paths_begin_where_natural_curvature_has_bent_a_strip() {
    let mut m = crate::common::model(crate::common::plate([1.0, 0.1], [16, 1], 0.0), 1e9, 0.01);
    if let Some(Material::Isotropic(material)) = m.materials.values_mut().next() {
        material.poisson = 0.0;
    }
    m.loads.clear();
    m.prescribed_strains = vec![crate::common::natural([0.0; 3], [1.0, 0.0, 0.0], None)];
    let first = PathAnalysis { end_load: 0.4, ..Default::default() };
    let steps = vec![
        AnalysisStep::new("first", Analysis::Path(first)),
        AnalysisStep::new("next", Analysis::Path(PathAnalysis::default())),
    ];
    let m = with_steps(m, steps);
    let mesh = generate(&m.mesh).unwrap();
    let mut compiler = Compiler::new(&m, &mesh).unwrap();
    let mut start = None;
    for (i, curvature) in [(0, 0.4_f64), (1, 1.0)] {
        let system = compiler.system(i, start).unwrap();
        let Analysis::Path(options) = compiler.steps()[i].model.analysis.clone() else { unreachable!() };
        let state = path::run(&system, &options, None, &mut Record::new(&system)).unwrap().state;
        let highest = state.u.iter().map(|u| u[2].abs()).fold(0.0, tegula::norm::larger);
        let exact = (1.0 - curvature.cos()) / curvature;
        assert!((highest / exact - 1.0).abs() < 2e-3, "{highest} {exact}");
        compiler.end_step(i, state.time);
        start = Some(state.end_of_step());
    }
}

/// Limit point of a cylinder with a large imperfection under axial load, where the loads do little work on the mode: both methods tell it from a bifurcation.
#[test]
#[ignore = "long"]
fn limit_points_of_local_modes_are_limit_points() {
    let mut m = crate::common::model(crate::common::cylinder(1.0, [0.0, 90.0], 0.5, [8, 12]), 1e9, 0.005);
    let plane = |on: &str, normal| Condition::Symmetry(SymmetryPlane { on: on.into(), normal });
    m.conditions = vec![
        plane("u_min", [1.0, 0.0, 0.0]),
        plane("u_max", [0.0, 0.0, 1.0]),
        plane("v_min", [0.0, 1.0, 0.0]),
        Condition::Fix(FixComponents {
            on: "v_max".into(),
            position: vec![Axis::X, Axis::Z],
            director: vec![],
        }),
    ];
    m.loads = vec![Load::Edge(vector_load("v_max", [0.0, -15_130.688_316_720_061, 0.0]))];
    m.imperfections = vec![Imperfection::Mode(ModeImperfection { mode: 1, amplitude: 0.0015 })];
    let nominal = generate(&m.mesh).unwrap();
    m.analysis = Analysis::Path(PathAnalysis::default());
    let mesh = tegula::compile::imperfect_mesh(&m, &nominal, &mut tegula::analysis::Silent).unwrap().unwrap();
    let limits = [None, Some(PathMethod::ArcLength)].map(|method| {
        let options = PathAnalysis { method, end_at: Some(PathEnd::LimitPoint), ..Default::default() };
        let system =
            tegula::compile::build(&Model { analysis: Analysis::Path(options.clone()), ..m.clone() }, &mesh)
                .unwrap();
        let path = path::run(&system, &options, None, &mut Record::new(&system)).unwrap().state.path.unwrap();
        let kinds: Vec<_> = path.critical.iter().map(|point| (point.kind, point.change)).collect();
        assert_eq!(kinds, [(CriticalKind::Limit, 1)], "{method:?}");
        path.critical[0].load
    });
    assert!((limits[0] / limits[1] - 1.0).abs() < 1e-7, "{limits:?}");
}

/// With `allow_unstable` load steps end at the critical point, too, whatever their number. An arch loaded between its bifurcation and its limit point
/// comes to an unstable equilibrium of symmetry, which is refused without the key.
#[test]
fn unstable_ends_are_refused_or_accepted_whatever_the_number_of_load_steps() {
    let full = 1.5 * limit().0;
    for load_steps in [1, 2, 20] {
        let options = StaticAnalysis { load_steps, allow_unstable: true, ..continued() };
        let m = truss(Analysis::Static(options.clone()), full);
        let (_, system) = compile(&m);
        let outcome = statics::run(&system, &options, None, &mut Record::new(&system)).unwrap();
        let w = deflection(&system, &outcome.state);
        assert!((w / behind_the_snap(full) - 1.0).abs() < 1e-9, "{load_steps}: {w}");
    }
    let (mut m, shape) = arch(24, 0.01);
    let [bifurcation, limit, ..] = critical_loads(&shape);
    m.loads = vec![Load::Traction(vector_load("all", [0.0, 0.0, -0.5 * (bifurcation + limit)]))];
    let run = |allow_unstable: bool, load_steps: u32| {
        let options = StaticAnalysis { load_steps, allow_unstable, ..continued() };
        let m = Model { analysis: Analysis::Static(options.clone()), ..m.clone() };
        let (_, system) = compile(&m);
        statics::run(&system, &options, None, &mut Record::new(&system))
    };
    for load_steps in [1, 4] {
        let message = run(false, load_steps).unwrap_err().to_string();
        assert!(
            message.contains("unstable equilibrium") && message.contains("bifurcation at load factor"),
            "{message}"
        );
        let outcome = run(true, load_steps).unwrap();
        assert_eq!((outcome.state.time, outcome.negative_pivots), (1.0, 1));
    }
}

/// Loads that a step has not let go of yet cannot be left behind by an early end of it.
#[test]
fn steps_that_end_while_loads_fall_are_refused() {
    let load = Load::Force(vector_load("apex", [0.0, 0.0, -0.5]));
    let step = |name: &str, analysis: Analysis, loads: &[Load]| AnalysisStep {
        loads: loads.to_vec(),
        ..AnalysisStep::new(name, analysis)
    };
    let early = Analysis::Path(PathAnalysis { end_load: 0.4, ..Default::default() });
    let full = Analysis::Static(StaticAnalysis::default());
    let steps = vec![
        step("loaded", full.clone(), std::slice::from_ref(&load)),
        step("falling", early, &[]),
        step("again", motion(1.0), &[load]),
    ];
    let m = with_steps(truss(full, 1.0), steps);
    let mesh = generate(&m.mesh).unwrap();
    let mut compiler = Compiler::new(&m, &mesh).unwrap();
    let mut start = None;
    for i in 0..2 {
        let system = compiler.system(i, start).unwrap();
        let mut record = Record::new(&system);
        let state = match &compiler.steps()[i].model.analysis {
            Analysis::Static(options) => statics::run(&system, options, None, &mut record).unwrap().state,
            Analysis::Path(options) => path::run(&system, options, None, &mut record).unwrap().state,
            _ => unreachable!(),
        };
        compiler.end_step(i, state.time);
        start = Some(state.end_of_step());
    }
    let Err(Error::Model(issues)) = compiler.system(2, start) else { panic!("accepted") };
    assert!(issues[0].message.contains("has not fallen to 0 yet"), "{:?}", issues[0]);
}
