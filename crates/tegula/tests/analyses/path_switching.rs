//! Paths that go over to the other path at a bifurcation, or begin at one, on the pinned arch of symmetry.

use crate::arches::{arch, critical_loads};
use crate::common::{Notes, compile, model, on, plate, vector_load};
use tegula::analysis::path::{self, CriticalKind, PathOutcome};
use tegula::analysis::{State, modal};
use tegula::compile::Compiler;
use tegula::mesh::generators::generate;
use tegula::model::*;
use tegula::norm::larger;
use tegula::system::{System, VectorKind};

use CriticalKind::{Bifurcation, Limit};

const METHODS: [Option<PathMethod>; 2] = [None, Some(PathMethod::ArcLength)];

/// The arch under 1.5 times its upper limit load, and the loads at which it bifurcates or has a limit, over the full one.
fn loaded_arch(options: PathAnalysis) -> (Model, [f64; 4]) {
    let (mut m, exact) = arch(24, 0.02);
    let loads = critical_loads(&exact);
    let full = 1.5 * loads[1];
    m.loads = vec![Load::Traction(vector_load("all", [0.0, 0.0, -full]))];
    m.analysis = Analysis::Path(options);
    (m, loads.map(|load| load / full))
}

/// Sway of the arch over its deflection: zero on the path of symmetry.
fn sway(system: &System, state: &State) -> f64 {
    let kinds = &system.coordinates.kinds;
    let places = || state.u.iter().zip(kinds).filter(|(_, kind)| **kind == VectorKind::Position);
    let [along, down] = [0, 2].map(|i| places().map(|(u, _)| u[i]).sum::<f64>());
    (along / down).abs()
}

fn found(outcome: &PathOutcome) -> Vec<(CriticalKind, i32, f64)> {
    let path = outcome.state.path.as_ref().unwrap();
    path.critical.iter().map(|point| (point.kind, point.change, point.load)).collect()
}

/// At its second bifurcation the path of sway meets the path of symmetry again: it goes over to that, with rising loads to the full one, or
/// with falling ones over both limits back to the first bifurcation.
#[test]
#[ignore = "long"]
fn the_crossing_path_of_an_arch_goes_back_to_the_path_of_symmetry() {
    for method in METHODS {
        for side in [2, -2] {
            let options =
                PathAnalysis { method, switch_at: vec![1, side], end_load: 1.0, ..Default::default() };
            let (m, loads) = loaded_arch(options.clone());
            let (_, system) = compile(&m);
            let mut notes = Notes::keeping();
            let outcome = path::run(&system, &options, None, &mut notes).unwrap();
            let found = found(&outcome);
            let kinds: Vec<_> = found.iter().map(|(kind, change, _)| (*kind, *change)).collect();
            assert_eq!(kinds[..2], [(Bifurcation, 1), (Bifurcation, 0)], "{method:?} {side} {found:?}");
            let wanted: &[f64] = if side > 0 {
                assert_eq!(kinds.len(), 2, "{method:?} {found:?}");
                assert_eq!((outcome.state.time, outcome.state.negative_pivots), (1.0, 0));
                &[loads[0], loads[3]]
            } else {
                assert_eq!(kinds[2..4], [(Limit, 1), (Limit, -1)], "{method:?} {found:?}");
                assert!(outcome.state.path.as_ref().unwrap().finished);
                &[loads[0], loads[3], loads[2], loads[1], loads[0]]
            };
            assert_eq!(found.len(), wanted.len());
            for ((_, _, load), exact) in found.iter().zip(wanted) {
                assert!((load - exact).abs() < 0.02 * loads[1], "{method:?} {side}: {load} {exact}");
            }
            let sways: Vec<f64> = notes.states.iter().map(|state| sway(&system, state)).collect();
            assert!(sways.iter().copied().fold(0.0, larger) > 0.05, "the path of sway");
            let last = sway(&system, &outcome.state);
            assert!(last < 1e-5, "{method:?} {side}: {last:e}");
        }
    }
}

/// Paths that end at the next critical point, one behind another, pass those of one path.
#[test]
fn a_path_goes_on_from_the_critical_point_at_which_the_one_before_has_ended() {
    for method in METHODS {
        let whole = PathAnalysis { method, ..Default::default() };
        let (m, loads) = loaded_arch(whole.clone());
        let (_, system) = compile(&m);
        let expected = found(&path::run(&system, &whole, None, &mut Notes::default()).unwrap());
        let part = PathAnalysis { end_at: Some(PathEnd::CriticalPoint), ..whole.clone() };
        let mut steps: Vec<_> =
            (1..5).map(|i| AnalysisStep::new(&format!("part {i}"), Analysis::Path(part.clone()))).collect();
        steps.push(AnalysisStep::new("last", Analysis::Path(whole)));
        let m = Model { steps, ..m };
        let mesh = generate(&m.mesh).unwrap();
        let mut compiler = Compiler::new(&m, &mesh).unwrap();
        let mut start = None;
        let mut all = Vec::new();
        let mut factor = 0.0;
        for i in 0..5 {
            let system = compiler.system(i, start).unwrap();
            let Analysis::Path(options) = &compiler.steps()[i].model.analysis else { unreachable!() };
            let outcome = path::run(&system, options, None, &mut Notes::default()).unwrap();
            let of_whole = |load: f64| factor + load * (1.0 - factor);
            all.extend(
                found(&outcome).into_iter().map(|(kind, change, load)| (kind, change, of_whole(load))),
            );
            // Next to the bifurcation sway is round-off over a small eigenvalue.
            let (last, most) = (sway(&system, &outcome.state), if i < 4 { 1e-3 } else { 1e-5 });
            assert!(last < most, "{method:?} {last:e}");
            factor = of_whole(outcome.state.time);
            compiler.end_step(i, outcome.state.time);
            start = Some(outcome.state.end_of_step());
        }
        assert!((factor - 1.0).abs() < 1e-14, "{factor}");
        assert_eq!(all.len(), expected.len(), "{method:?} {all:?} {expected:?}");
        for ((kind, change, load), (other, same, exact)) in all.iter().zip(&expected) {
            assert_eq!((kind, change), (other, same));
            assert!((load - exact).abs() < 1e-6 * loads[1], "{method:?} {load} {exact}");
        }
    }
}

/// Load factors that are wanted at a bifurcation, as where they come from an earlier result, or next to the end: the path passes both.
#[test]
#[ignore = "long"]
fn a_path_passes_wanted_loads_at_a_bifurcation_and_next_to_its_end() {
    for method in METHODS {
        let options = PathAnalysis { method, ..Default::default() };
        let (m, _) = loaded_arch(options.clone());
        let (_, system) = compile(&m);
        let expected = found(&path::run(&system, &options, None, &mut Notes::default()).unwrap());
        for part in [1.0, 1.0 - 1e-7, 1.0 + 1e-7] {
            let mut system = compile(&m).1;
            system.wanted_times = vec![expected[0].2 * part, 1.0 - 1e-13];
            let outcome = path::run(&system, &options, None, &mut Notes::default()).unwrap();
            let found = found(&outcome);
            assert!((outcome.state.time - 1.0).abs() < 1e-12, "{method:?} {part} {found:?}");
            assert_eq!(found.len(), expected.len(), "{method:?} {part} {found:?}");
            for ((kind, change, load), (other, same, exact)) in found.iter().zip(&expected) {
                assert_eq!((kind, change), (other, same), "{method:?} {part}");
                assert!((load - exact).abs() < 1e-6, "{method:?} {part}: {load} {exact}");
            }
        }
    }
}

/// At the bifurcation of a column the stresses cancel the stiffness of its first mode, whose frequency vanishes.
#[test]
fn the_first_mode_at_a_bifurcation_has_no_frequency() {
    for element in [ElementKind::Mitc4, ElementKind::Ems] {
        let mut m = model(plate([1.0, 0.05], [20, 1], 0.0), 2e11, 0.01);
        m.sections[0].element = element;
        m.conditions = vec![Condition::Clamp(on("u_min"))];
        let euler = std::f64::consts::PI.powi(2) * 2e11 * 0.01_f64.powi(3) / 12.0 / 4.0;
        m.loads = vec![Load::Edge(vector_load("u_max", [-euler, 0.0, 0.0]))];
        let end_at = Some(PathEnd::Bifurcation);
        let to_bifurcation = Analysis::Path(PathAnalysis { end_load: 1.3, end_at, ..Default::default() });
        let vibration = Analysis::Modal(ModalAnalysis::new(2));
        m.steps = vec![AnalysisStep::new("path", to_bifurcation), AnalysisStep::new("modes", vibration)];
        let mesh = generate(&m.mesh).unwrap();
        let mut compiler = Compiler::new(&m, &mesh).unwrap();
        let system = compiler.system(0, None).unwrap();
        let Analysis::Path(options) = &compiler.steps()[0].model.analysis else { unreachable!() };
        let state = path::run(&system, options, None, &mut Notes::default()).unwrap().state;
        compiler.end_step(0, state.time);
        let system = compiler.system(1, Some(state.end_of_step())).unwrap();
        let modes = modal::run(&system, 2, Some(&state), &mut Notes::default()).unwrap().modes;
        let [first, second] = [modes[0].omega, modes[1].omega];
        assert!(first.abs() < 1e-4 * second && second > 0.0, "{element:?}: {first} {second}");
    }
}
