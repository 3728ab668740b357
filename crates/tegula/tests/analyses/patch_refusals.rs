//! Rigid patches that contradict other parts of the model, or leave it without inertia, are refused by name.

use crate::common::*;
use crate::patches::{clamped, fixed, gravity, hub, steps, strip};
use tegula::model::*;
use tegula::{Error, compile};

/// Everything that contradicts a patch is refused with its place.
#[test]
fn contradictions_of_patches_are_refused_by_name() {
    let refused = |m: &Model, key: &str, words: &[&str]| {
        let mesh = tegula::mesh::generators::generate(&m.mesh).unwrap();
        let Err(Error::Model(issues)) = compile::build(m, &mesh) else { panic!("{key} is taken") };
        let found = issues
            .iter()
            .any(|issue| issue.place.key == key && words.iter().all(|word| issue.message.contains(word)));
        assert!(found, "{key} {words:?}: {issues:?}");
    };
    let mut m = strip(ElementKind::Ems, [4, 2], 0.0);
    m.analysis = Analysis::Transient(steps(1.0, 0.1));
    m.loads = vec![gravity([0.0, 0.0, -9.81])];
    m.bodies = vec![hub("left", [0.0; 3], &["u_min"]), hub("right", [1.0, 0.0, 0.0], &["u_max"])];
    let change = |f: &dyn Fn(&mut Model)| {
        let mut changed = m.clone();
        f(&mut changed);
        changed
    };
    refused(
        &change(&|m| m.bodies[1].attached.push("v_min".into())),
        "bodies[1].attached[1]",
        &["left", "right"],
    );
    refused(&change(&|m| m.bodies[0].attached[0] = "no".into()), "bodies[0].attached[0]", &["no"]);
    refused(&change(&|m| m.conditions = vec![clamped("v_min")]), "conditions[0].on", &["left"]);
    let velocity = InitialVelocity {
        on: "all".into(),
        velocity: [1.0, 0.0, 0.0],
        angular_velocity: [0.0, 0.0, 1.0],
        center: [0.0; 3],
    };
    refused(&change(&|m| m.initial_velocities = vec![velocity.clone()]), "initial_velocities", &["left"]);
    let at_rest = |m: &mut Model| m.analysis = Analysis::Static(StaticAnalysis::default());
    refused(
        &change(&|m| {
            at_rest(m);
            m.bodies[0].attached.clear();
            m.bodies[0].mass = Some(1.0)
        }),
        "bodies[0]",
        &["nothing holds"],
    );
    refused(
        &change(&|m| {
            m.analysis = Analysis::Static(StaticAnalysis { linear: true, ..StaticAnalysis::default() });
            m.joints = vec![fixed("left", [0.0; 3])]
        }),
        "analysis",
        &["static"],
    );
    refused(
        &change(&|m| {
            at_rest(m);
            m.conditions = vec![clamped("u_max_v_min")];
            m.bodies = vec![hub("dot", [0.0; 3], &["u_min_v_min"])]
        }),
        "bodies[0].attached",
        &["dot", "spin"],
    );
    refused(&change(&at_rest), "conditions", &["no support at all"]);
}

/// A massless body on one node could spin about the director without resistance.
#[test]
fn a_massless_body_on_one_node_is_refused_in_motion() {
    let mut m = strip(ElementKind::Ems, [3, 2], 0.0);
    m.bodies = vec![hub("dot", [0.1, 0.0, 0.2], &["u_min_v_min"])];
    m.loads = vec![gravity([0.0, 0.0, -1.0])];
    let options = steps(0.1, 0.01);
    m.analysis = Analysis::Transient(options.clone());
    let (_, system) = compile(&m);
    let outcome = tegula::analysis::dynamics::run(&system, &options, None, &mut Notes::default());
    let Err(Error::Singular { what, help }) = outcome else { panic!("it is taken") };
    assert!(what.contains("dot") && help.contains("attach another node"), "{what} {help}");
}
