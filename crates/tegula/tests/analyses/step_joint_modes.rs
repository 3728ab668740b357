//! Modes of analysis steps that release and lock joints.

use crate::multibody::{between, body, gravity, spring};
use crate::step_joints::{at_rest, step};
use tegula::analysis::{Silent, State, modal, statics};
use tegula::model::*;
use tegula::{compile, mesh};

/// Frequencies of a modal step of a model, about the reference or behind a static first step.
fn omegas(model: &Model, number: usize) -> Vec<f64> {
    let mesh = mesh::generators::generate(&model.mesh).unwrap();
    let compiler = compile::Compiler::new(model, &mesh).unwrap();
    let Analysis::Modal(options) = &model.steps[number].analysis else { panic!() };
    let mut end = None;
    let behind = matches!(model.steps[0].analysis, Analysis::Static(_));
    if behind {
        let system = compiler.system(0, None).unwrap();
        let state = statics::run(&system, &StaticAnalysis::default(), None, &mut Silent).unwrap().state;
        end = Some(state.end_of_step());
    }
    let system = compiler.system(number, end).unwrap();
    let about = behind.then(|| State { time: 1.0, ..State::first(&system) });
    let found = modal::run(&system, options.modes as usize, about.as_ref(), &mut Silent).unwrap();
    assert!(found.sturm_checked);
    found.modes.iter().map(|mode| mode.omega).collect()
}

/// Modes with a locked joint are those with a fixed one, and modes with a released joint those without it: about the reference, and
/// about an equilibrium far away from it, whose forces are in the joints.
#[test]
fn modes_with_locked_and_released_joints_are_those_with_fixed_ones_and_without() {
    let modes = |count| Analysis::Modal(ModalAnalysis::new(count));
    let spring = |name: &str, body: &str, from: [f64; 3], to: [f64; 3], stiffness| {
        spring(name, ["ground", body], [from, to], stiffness)
    };
    for joint in Joint::examples().into_iter().filter(Joint::can_be_locked) {
        let mut model = Model::of_bodies(
            modes(6),
            vec![
                body("a", [0.0; 3], 2.0, Some([0.4, 0.5, 0.3])),
                body("b", [1.2, 0.3, 0.1], 2.0, Some([0.2, 0.25, 0.3])),
            ],
            vec![joint.clone()],
        );
        model.springs = vec![
            spring("1", "a", [-1.0, 0.0, 0.0], [-0.2, 0.1, 0.0], 300.0),
            spring("2", "a", [0.0, -1.0, 0.2], [0.1, -0.3, 0.1], 400.0),
            spring("3", "a", [0.0, 0.1, -1.0], [0.3, 0.1, -0.2], 500.0),
            spring("4", "b", [2.2, 0.3, 0.0], [1.4, 0.5, 0.3], 350.0),
            spring("5", "b", [1.0, 1.3, 0.2], [1.3, 0.6, 0.1], 450.0),
            spring("6", "b", [1.2, 0.1, 1.5], [1.1, 0.2, 0.4], 600.0),
            spring("7", "a", [-1.0, 0.2, 0.3], [-0.1, -0.2, 0.4], 350.0),
            spring("8", "a", [0.3, -1.0, 0.1], [-0.3, -0.2, -0.1], 250.0),
            spring("9", "a", [0.4, 0.3, -1.0], [-0.2, 0.4, -0.1], 450.0),
            spring("10", "b", [2.2, 0.1, 0.4], [1.3, 0.0, 0.2], 300.0),
            spring("11", "b", [0.9, 1.3, -0.2], [1.0, 0.5, -0.3], 500.0),
            spring("12", "b", [1.4, 0.5, 1.5], [1.5, 0.1, 0.3], 400.0),
        ];
        let fixed = Joint::Fixed(PointJoint {
            name: "joint".into(),
            between: between("a", "b"),
            at: [0.6, 0.1, -0.2],
            second_at: None,
        });
        let with = |joints: Vec<Joint>, loaded: bool, released: &[&str], locked: &[&str]| {
            let mut model = Model { joints, ..model.clone() };
            if loaded {
                // A small weight: far heavier loads bring these springs to a limit point.
                model.loads = gravity([-1.0, 0.5, -1.5]);
                model.steps =
                    vec![step("load", at_rest(), released, locked), AnalysisStep::new("modes", modes(6))];
            } else {
                model.steps = vec![step("modes", modes(6), released, locked)];
            }
            omegas(&model, usize::from(loaded))
        };
        let compare = |what: &str, found: Vec<f64>, expected: Vec<f64>| {
            assert_eq!(found.len(), expected.len(), "{what}");
            for (a, b) in found.iter().zip(&expected) {
                assert!((a / b - 1.0).abs() < 1e-9, "{what} {}: {found:?} {expected:?}", joint.word());
            }
        };
        for loaded in [false, true] {
            let held = with(vec![joint.clone()], loaded, &[], &["joint"]);
            compare("locked", held.clone(), with(vec![fixed.clone()], loaded, &[], &[]));
            let free = with(vec![joint.clone()], loaded, &[], &[]);
            assert!(free.iter().zip(&held).any(|(a, b)| (a / b - 1.0).abs() > 1e-3), "{}", joint.word());
        }
        let spare = Joint::Spherical(PointJoint {
            name: "spare".into(),
            between: between("ground", "b"),
            at: [1.2, 0.3, 0.1],
            second_at: None,
        });
        let mut other = Model { joints: vec![joint.clone(), spare], ..model.clone() };
        other.steps = vec![step("modes", modes(6), &["spare"], &[]), step("modes", modes(6), &[], &[])];
        compare("released", omegas(&other, 0), with(vec![joint.clone()], false, &[], &[]));
    }
}
