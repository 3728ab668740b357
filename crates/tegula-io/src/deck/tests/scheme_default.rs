//! Schemes of time integration that a model file does not give.

use crate::deck::Deck;
use tegula::model::Analysis;

/// Names of the schemes of the analysis and of all steps.
fn schemes(text: &str) -> Vec<&'static str> {
    let model = Deck::parse("m.toml", text).unwrap().model;
    let analyses = std::iter::once(&model.analysis).chain(model.steps.iter().map(|step| &step.analysis));
    analyses
        .filter_map(|analysis| match analysis {
            Analysis::Transient(options) => Some(options.scheme.name()),
            _ => None,
        })
        .collect()
}

const BODY: &str = r#"
[[bodies]]
name = "ball"
at = [0.0, 0.0, 0.0]
mass = 1.0
"#;

const SHELL: &str = r#"
[mesh]
type = "plate"
size = [1.0, 1.0]

[mesh.grid]
elements = [2, 2]

[[sections]]
material = "m"
thickness = 0.1

[materials.m]
"#;

const ELASTIC: &str = "type = \"isotropic\"\nyoung = 1e6\npoisson = 0.3\ndensity = 1.0\n";
const PLASTIC: &str =
    "type = \"plastic\"\nyoung = 1e6\npoisson = 0.3\ndensity = 1.0\nyield_stress = 1e3\nhardening = 1e4\n";

#[test]
fn transient_analyses_without_a_scheme_take_one_that_moves_the_model() {
    let motion = "[analysis]\ntype = \"transient\"\nend_time = 1.0\n";
    let of = |parts: &[&str]| schemes(&parts.concat());
    assert_eq!(of(&[motion, BODY]), ["energy-momentum"]);
    assert_eq!(of(&[motion, SHELL, ELASTIC]), ["newmark"]);
    assert_eq!(of(&[motion, SHELL, ELASTIC, BODY]), ["energy-momentum"]);
    assert_eq!(of(&[motion, SHELL, PLASTIC, BODY]), ["generalized-alpha"]);
    assert_eq!(of(&[motion, SHELL, PLASTIC]), ["newmark"]);
    assert_eq!(of(&[motion, "scheme = { type = \"bdf2\" }\n", BODY]), ["bdf2"]);
}

#[test]
fn each_step_without_a_scheme_takes_one() {
    let steps = r#"
[[steps]]
analysis = { type = "transient", end_time = 1.0 }

[[steps]]
analysis = { type = "transient", end_time = 1.0, scheme = { type = "generalized-alpha" } }

[[steps]]
analysis = { type = "transient", end_time = 1.0 }
"#;
    assert_eq!(schemes(&[BODY, steps].concat()), ["energy-momentum", "generalized-alpha", "energy-momentum"]);
}
