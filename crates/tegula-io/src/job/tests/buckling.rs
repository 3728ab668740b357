//! Files of a buckling analysis, alone and behind a preload.

use std::f64::consts::PI;
use std::fs;

use super::super::*;
use super::options;
use crate::deck::Deck;
use crate::out::csv;

/// A column between hinges under a dead load, of Poisson's ratio 0: π² EI/L² = 8.2247 per width 0.1.
const COLUMN: &str = r#"
[mesh]
type = "plate"
size = [1.0, 0.1]
grid = { elements = [40, 1] }
[materials.m]
type = "isotropic"
young = 1e8
poisson = 0.0
density = 1.0
[[sections]]
material = "m"
thickness = 0.01
[[conditions]]
type = "hinge"
on = "u_min"
[[conditions]]
type = "fix"
on = "u_max"
position = ["y", "z"]
"#;

const LOAD: &str = "type = \"edge\"\non = \"u_max\"\nvalue = [-10.0, 0.0, 0.0]\n";

fn load_factors(text: &str, folder: &std::path::Path) -> Vec<f64> {
    let deck = Deck::parse("column.toml", text).unwrap();
    run(&deck, &options(folder, false), &mut Unwatched).unwrap().load_factors.unwrap()
}

#[test]
fn load_factors_and_modes_are_written() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("column");
    let text = format!("{COLUMN}[analysis]\ntype = \"buckling\"\nfactors = 2\n[[loads]]\n{LOAD}");
    let factors = load_factors(&text, &out);
    let euler = PI * PI * 1e8 * 0.1 * 1e-6 / 12.0;
    for (i, factor) in factors.iter().enumerate() {
        let expected = euler * ((i + 1) * (i + 1)) as f64;
        assert!((factor / expected - 1.0).abs() < 5e-3, "{factor} {expected}");
    }
    let summary = Summary::read(&out).unwrap();
    assert_eq!((summary.analysis.as_str(), summary.status), ("buckling", Status::Complete));
    assert_eq!((summary.load_factors.as_ref(), summary.sturm_checked), (Some(&factors), Some(true)));
    let (names, rows) = csv::read(&out.join("modes.csv")).unwrap();
    assert_eq!(names, ["mode", "load_factor", "residual"]);
    assert_eq!(rows.iter().map(|row| row[1]).collect::<Vec<_>>(), factors);
    assert_eq!(fs::read_dir(out.join("modes")).unwrap().count(), 2);
    assert!(out.join("modes.png").exists() && out.join("modes.pvd").exists());
    let deck = Deck::parse("column.toml", &text).unwrap();
    let error = run(&deck, &options(&out, true), &mut Unwatched).unwrap_err().to_string();
    assert!(error.contains("cannot be resumed"), "{error}");
}

/// The load 2.5 of the static step stays, and the factor is that of the rest.
#[test]
fn buckling_about_a_preload_keeps_its_loads() {
    let folder = tempfile::tempdir().unwrap();
    let alone = format!("{COLUMN}[analysis]\ntype = \"buckling\"\nfactors = 1\n[[loads]]\n{LOAD}");
    let total = load_factors(&alone, &folder.path().join("alone"))[0];
    let preload = LOAD.replace("-10.0", "-2.5");
    let steps = format!(
        "{COLUMN}[[steps]]\nname = \"preload\"\nanalysis = {{ type = \"static\" }}\n[[steps.loads]]\n{preload}\
         [[steps]]\nname = \"rest\"\nanalysis = {{ type = \"buckling\", factors = 1 }}\n[[steps.loads]]\n{LOAD}"
    );
    let out = folder.path().join("steps");
    let rest = load_factors(&steps, &out)[0];
    assert!(((rest + 0.25) / total - 1.0).abs() < 1e-4, "{rest} {total}");
    let summary = Summary::read(&out).unwrap();
    let listed: Vec<_> = summary.analyses.iter().map(|a| (a.folder.as_str(), a.analysis.as_str())).collect();
    assert_eq!(listed, [("1-preload", "static"), ("2-rest", "buckling")]);
    assert!(out.join("2-rest/modes.csv").exists());
}
