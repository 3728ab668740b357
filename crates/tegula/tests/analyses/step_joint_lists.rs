//! Lists of joints that steps release and lock: what is refused.

use crate::multibody::{between, body, gravity, machine, revolute, spherical};
use crate::step_joints::{at_rest, refused, run, step};
use tegula::model::joint::DRIVE;
use tegula::model::*;

const MASS: f64 = 2.0;
const ARM: f64 = 0.5;
const G: f64 = 10.0;

fn listing(steps: Vec<AnalysisStep>) -> Model {
    let bodies = vec![
        body("a", [0.5, 0.0, 0.0], 1.0, Some([0.1; 3])),
        body("b", [1.5, 0.0, 0.0], 1.0, Some([0.1; 3])),
        body("bob", [2.0, 0.0, 0.0], 1.0, None),
    ];
    let motor = Joint::DrivenAngle(DrivenAngleJoint {
        name: "motor".into(),
        between: between("ground", "a"),
        axis: [0.0, 0.0, 1.0],
        angle: 90.0,
        amplitude: DRIVE.into(),
    });
    let joints = vec![
        revolute("hinge", "ground", "a", [0.0; 3], [0.0, 0.0, 1.0]),
        motor,
        Joint::Fixed(PointJoint {
            name: "weld".into(),
            between: between("a", "b"),
            at: [1.0, 0.0, 0.0],
            second_at: None,
        }),
        spherical("b", "bob", [2.0, 0.0, 0.0]),
        Joint::Distance(DistanceJoint {
            name: "rod".into(),
            between: between("ground", "bob"),
            points: [[2.0, -1.0, 0.0], [2.0, 0.0, 0.0]],
        }),
    ];
    let mut model = machine(0.1, 0.01, bodies, joints);
    model
        .amplitudes
        .insert(DRIVE.into(), Amplitude::Expression(ExpressionAmplitude { expression: "t^2".into() }));
    model.steps = steps;
    model
}

#[test]
fn lists_of_joints_that_make_no_sense_are_refused() {
    let moves = || machine(0.1, 0.01, Vec::new(), Vec::new()).analysis;
    let model = listing(vec![
        step("first", moves(), &["hing", "weld", "weld"], &["weld", "motor", "rod"]),
        step("second", moves(), &["weld", "hinge"], &["hinge"]),
    ]);
    insta::assert_snapshot!(refused(&model));
    // The name of a spherical joint is that of its sides; a point mass has no axes to hold.
    let name = model.joints[3].common().name().to_owned();
    let text = refused(&listing(vec![
        step("only", moves(), &["rod", "motor"], &[&name]),
        step("next", moves(), &[], &[]),
    ]));
    assert!(text.starts_with("steps[0].locked[0]: ") && text.contains("point mass"), "{text}");
    let modes = Analysis::Modal(ModalAnalysis::new(2));
    let text = refused(&listing(vec![
        step("rest", at_rest(), &["motor"], &["hinge"]),
        step("modes", modes, &["motor"], &["hinge"]),
    ]));
    assert!(text.contains("steps[1].released: ") && text.contains("steps[1].locked: "), "{text}");
}

/// A body that only released joints hold, in statics.
#[test]
fn a_body_whose_joints_are_all_released_in_statics_is_refused() {
    let bar = body("bar", [ARM, 0.0, 0.0], MASS, Some([0.2, 0.25, 0.3]));
    let hinge = revolute("hinge", "ground", "bar", [0.0; 3], [0.0, 0.0, 1.0]);
    let mut model = Model::of_bodies(at_rest(), vec![bar], vec![hinge]);
    model.loads = gravity([0.0, -G, 0.0]);
    model.steps = vec![step("held", at_rest(), &[], &["hinge"]), step("gone", at_rest(), &["hinge"], &[])];
    let text = refused(&model);
    assert!(text.contains("nothing holds body \"bar\""), "{text}");
    // Free to turn, without a spring.
    model.steps = vec![step("held", at_rest(), &[], &["hinge"]), step("free", at_rest(), &[], &[])];
    assert!(run(&model).is_err());
}
