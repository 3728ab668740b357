//! Files of the response of a modal analysis, value by value.

use std::f64::consts::TAU;
use std::fs;

use nalgebra::{Complex, DMatrix};

use super::super::*;
use super::options;
use crate::deck::Deck;
use crate::out::csv;

const HUB: &str = r#"
title = "Strip on a hub"
[analysis]
type = "modal"
modes = 4
damping_ratio = 0.02
frequency_response = { from = 0.5, to = 8.0, points = 12, spacing = "linear" }
[[analysis.inputs]]
name = "shaker"
loads = [{ type = "force", on = "u_max_v_max", value = [0.0, 0.0, 2.0] }]
[[analysis.inputs]]
name = "base"
loads = [{ type = "gravity", value = [0.0, 0.0, -1.0] }, { type = "moment", on = "hub", value = [0.0, 0.5, 0.0] }]
[mesh]
type = "plate"
size = [1.0, 0.2]
grid = { elements = [8, 2] }
[materials.m]
type = "isotropic"
young = 1e9
poisson = 0.3
density = 1000.0
[[sections]]
material = "m"
thickness = 0.01
[[bodies]]
name = "hub"
at = [-0.1, 0.1, 0.0]
mass = 2.0
inertia = [0.01, 0.02, 0.01]
attached = ["u_min"]
[[joints]]
type = "revolute"
name = "pin"
between = ["ground", "hub"]
at = [-0.1, 0.1, 0.0]
axis = [0.0, 1.0, 0.0]
[[torsion_springs]]
name = "spring"
between = ["ground", "hub"]
axis = [0.0, 1.0, 0.0]
stiffness = 40.0
damping = 0.3
[output]
points = [{ name = "tip", on = "u_max_v_max" }]
"#;

/// Matrix of a file in the format Matrix Market.
fn matrix(path: &std::path::Path) -> DMatrix<f64> {
    let text = fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next().unwrap(), "%%MatrixMarket matrix array real general");
    let mut numbers = lines.filter(|line| !line.starts_with('%'));
    let size: Vec<usize> = numbers.next().unwrap().split(' ').map(|n| n.parse().unwrap()).collect();
    let values: Vec<f64> = numbers.map(|line| line.parse().unwrap()).collect();
    assert_eq!(values.len(), size[0] * size[1]);
    DMatrix::from_vec(size[0], size[1], values)
}

/// The table is the transfer function C (iω − A)⁻¹ B of the state space, whose files name its inputs and outputs.
#[test]
fn the_frequency_response_is_the_transfer_function_of_the_state_space() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let deck = Deck::parse("hub.toml", HUB.to_owned()).unwrap();
    let summary = run(&deck, &options(&out, false), &mut Unwatched).unwrap();
    assert_eq!(summary.frequencies_hz.unwrap().len(), 4);
    let names: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(out.join("state_space.json")).unwrap()).unwrap();
    let list = |key: &str| -> Vec<String> {
        names[key].as_array().unwrap().iter().map(|name| name.as_str().unwrap().to_owned()).collect()
    };
    let (inputs, outputs) = (list("inputs"), list("outputs"));
    assert_eq!(inputs, ["shaker", "base"]);
    let of_body = ["ux", "uy", "uz", "rx", "ry", "rz"].map(|column| format!("body.hub.{column}"));
    assert_eq!(
        outputs,
        [["tip.ux", "tip.uy", "tip.uz"].map(str::to_owned).to_vec(), of_body.to_vec()].concat()
    );
    let coordinates = names["coordinates"].as_array().unwrap();
    assert!(coordinates.len() > 4 && coordinates[3]["kind"] == "mode");
    assert_eq!(coordinates[4]["kind"], "residual vector");
    let [a, b, c, d] =
        list("files").try_into().map(|files: [String; 4]| files.map(|f| matrix(&out.join(f)))).unwrap();
    assert_eq!(a.shape(), (2 * coordinates.len(), 2 * coordinates.len()));
    assert!(d.shape() == (9, 2) && d.iter().all(|d| *d == 0.0));

    let (columns, rows) = csv::read(&out.join("frequency_response.csv")).unwrap();
    assert_eq!(columns.len(), 1 + 2 * 9 * 2);
    assert!(rows.len() > 12 && rows[0][0] == 0.5 && rows[rows.len() - 1][0] == 8.0);
    let complex = |m: &DMatrix<f64>| m.map(Complex::from);
    for row in &rows {
        let s = Complex::new(0.0, TAU * row[0]);
        let shifted = DMatrix::from_diagonal_element(a.nrows(), a.nrows(), s) - complex(&a);
        let transfer = complex(&c) * shifted.lu().solve(&complex(&b)).unwrap();
        let size = tegula::norm::max_norm(transfer.iter().map(|value| value.norm()));
        for (i, output) in outputs.iter().enumerate() {
            for (j, input) in inputs.iter().enumerate() {
                let at = |what: &str| {
                    columns.iter().position(|n| *n == format!("{output}/{input}.{what}")).unwrap()
                };
                let (amplitude, phase) = (row[at("amplitude")], row[at("phase")]);
                assert!(phase > -180.0 && phase <= 180.0);
                let found = Complex::from_polar(amplitude, phase.to_radians());
                let error = (found - transfer[(i, j)]).norm();
                assert!(error < 1e-8 * size, "{output}/{input} at {}: {found} {}", row[0], transfer[(i, j)]);
            }
        }
    }
    // The hub turns about its pin, and its centre stays there.
    let last = &rows[0];
    let amplitude =
        |name: &str| last[columns.iter().position(|n| n == &format!("{name}.amplitude")).unwrap()];
    assert!(amplitude("body.hub.ry/base") > 1e-4 && amplitude("body.hub.uz/base") < 1e-12);
    assert!(out.join("frequency_response.png").exists());

    // Another model leaves nothing of it.
    let without = HUB.replace("damping_ratio = 0.02", "").replace("frequency_response", "#");
    let at = without.find("[[analysis.inputs]]").unwrap();
    let until = without.find("[mesh]").unwrap();
    let without = Deck::parse("hub.toml", format!("{}{}", &without[..at], &without[until..])).unwrap();
    run(&without, &JobOptions { force: true, ..options(&out, false) }, &mut Unwatched).unwrap();
    let left = |name: &str| out.join(name).exists();
    assert!(left("modes.csv"));
    assert!(
        !["frequency_response.csv", "frequency_response.png", "state_space.json", "state_space_c.mtx"]
            .map(left)
            .contains(&true)
    );
}
