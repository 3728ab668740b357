//! Warnings of modal analyses: those that must come, and one that must not.

use crate::common::{Notes, compile, model, plate, solve, vector_load};
use tegula::analysis::modal;
use tegula::model::*;

/// Two hinges of a double pendulum, turned in space, whose bodies differ a hundredfold in mass over inertia: no constraint follows from others, though the
/// elimination in their compliances has small pivots.
#[test]
fn constraints_of_different_compliances_are_not_called_redundant() {
    let text = r#"{
        "bodies": [
            { "name": "a", "at": [0.34806873657636506, -0.39843170137420392, -0.84858725771613497], "mass": 2.0, "inertia": [0.01, 0.01, 0.01] },
            { "name": "b", "at": [0.55690997852218416, -0.63749072219872627, -1.3577396123458161], "mass": 1.0, "inertia": [0.02, 0.02, 0.02] }],
        "joints": [
            { "type": "revolute", "name": "h1", "between": ["ground", "a"], "at": [0, 0, 0], "axis": [0.66482139822759356, -0.53328773087246162, 0.52308384085116633] },
            { "type": "revolute", "name": "h2", "between": ["a", "b"], "at": [0.34806873657636506, -0.39843170137420392, -0.84858725771613497],
              "axis": [0.66482139822759356, -0.53328773087246162, 0.52308384085116633] }],
        "torsion_springs": [
            { "name": "s1", "between": ["ground", "a"], "axis": [0.66482139822759356, -0.53328773087246162, 0.52308384085116633], "stiffness": 3.0 },
            { "name": "s2", "between": ["a", "b"], "axis": [0.66482139822759356, -0.53328773087246162, 0.52308384085116633], "stiffness": 5.0 }],
        "loads": [{ "type": "follower-force", "on": "b", "value": [-2.0884124194581903, 2.3905902082452233, 5.09152354629681] }],
        "analysis": { "type": "modal", "modes": 2, "prestressed": true } }"#;
    let (_, system) = compile(&serde_json::from_str(text).unwrap());
    let mut notes = Notes::default();
    let state = modal::prestress(&system, &mut notes).unwrap().state;
    modal::run(&system, 2, Some(&state), &mut notes).unwrap();
    assert!(!notes.warnings.iter().any(|text| text.contains("follow from")), "{:?}", notes.warnings);
}

/// Modes about the equilibrium of a loaded strip, of whose load the modal step has half.
#[test]
fn a_state_that_is_no_equilibrium_of_the_modal_step_is_warned_of() {
    let (_, system, outcome) = solve(&strip_with_load(100.0));
    let warnings = |system: &tegula::System| {
        let mut notes = Notes::default();
        modal::run(system, 2, Some(&outcome.state), &mut notes).unwrap();
        notes.warnings
    };
    assert_eq!(warnings(&system), Vec::<String>::new());
    let told = warnings(&compile(&strip_with_load(50.0)).1);
    assert!(told[0].contains("about no equilibrium") && told.len() == 1, "{told:?}");
}

/// A clamped strip with a force across its end.
fn strip_with_load(force: f64) -> Model {
    let mut m = model(plate([1.0, 0.1], [10, 2], 0.0), 7e10, 0.01);
    m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(7e10, 0.0, 2700.0)));
    m.loads = vec![Load::Edge(vector_load("u_max", [0.0, 0.0, force]))];
    m
}

/// A mass between two springs of unlike forces, without joints: the modes are those about no equilibrium.
#[test]
fn springs_that_nothing_balances_are_warned_of_in_models_without_joints() {
    let spring = |name: &str, x: f64, stiffness: f64| serde_json::json!({ "name": name, "between": ["ground", "b"], "points": [[x, 0.0, 0.0], [0.0, 0.0, 0.0]], "stiffness": stiffness, "length": 0.5 });
    for (second, warned) in [(50.0, true), (100.0, false)] {
        let m = serde_json::json!({
            "analysis": { "type": "modal", "modes": 3 },
            "bodies": [{ "name": "b", "at": [0.0, 0.0, 0.0], "mass": 1.0 }],
            "springs": [spring("s1", -1.0, 100.0), spring("s2", 1.0, second)]
        });
        let (_, system) = compile(&serde_json::from_value(m).unwrap());
        let mut notes = Notes::default();
        modal::run(&system, 3, None, &mut notes).unwrap();
        assert_eq!(notes.warnings.iter().any(|text| text.contains("do not balance")), warned, "{second}");
    }
}
