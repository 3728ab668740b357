//! Cuts in a run: columns of the history, entries of the summary, stop conditions.

use std::fs;
use std::path::Path;

use super::super::*;
use super::options;
use crate::deck::Deck;
use crate::out::csv;

/// A strip of width 1 along x from 0 to 2 in four elements: the sets `inner` and `outer` meet at the edge set `line` at x = 1.
const MESH: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n\
    $PhysicalNames\n5\n2 1 \"inner\"\n2 2 \"outer\"\n1 3 \"root\"\n1 4 \"line\"\n1 5 \"tip\"\n$EndPhysicalNames\n\
    $Nodes\n10\n1 0 0 0\n2 0 1 0\n3 0.5 0 0\n4 0.5 1 0\n5 1 0 0\n6 1 1 0\n7 1.5 0 0\n8 1.5 1 0\n9 2 0 0\n10 2 1 0\n$EndNodes\n\
    $Elements\n7\n1 1 2 3 3 1 2\n2 1 2 4 4 5 6\n3 1 2 5 5 9 10\n\
    4 3 2 1 1 1 3 4 2\n5 3 2 1 1 3 5 6 4\n6 3 2 2 2 5 7 8 6\n7 3 2 2 2 7 9 10 8\n$EndElements\n";

const STRIP: &str = r#"
    [mesh]
    type = "gmsh"
    file = "strip.msh"
    [materials.m]
    type = "isotropic"
    young = 1e6
    poisson = 0.0
    density = 1.0
    [[sections]]
    material = "m"
    thickness = 0.05
    [[conditions]]
    type = "clamp"
    on = "root"
    [[loads]]
    type = "edge"
    on = "tip"
    value = [3.0, 0.0, -2.0]
    [output]
    pictures = false
    [[output.cuts]]
    name = "middle"
    on = "line"
    of = "inner"
    [[output.cuts]]
    name = "origin"
    on = "line"
    of = "outer"
    about = [0.0, 0.0, 0.0]
"#;

fn deck(folder: &Path, analysis: &str) -> Deck {
    fs::write(folder.join("strip.msh"), MESH).unwrap();
    Deck::parse(folder.join("strip.toml"), format!("[analysis]\n{analysis}\n{STRIP}")).unwrap()
}

/// The middle carries the force (3, 0, −2) at the tip and the moment 2 about y with the arm 1; the outer part has the opposite of both,
/// and the moment −4 with the arm 2 from the origin.
#[test]
fn history_and_summary_hold_the_section_forces() {
    let folder = tempfile::tempdir().unwrap();
    let deck = deck(folder.path(), "type = \"static\"\nlinear = true");
    let results = folder.path().join("results");
    let summary = run(&deck, &options(&results, false), &mut Unwatched).unwrap();
    let (names, rows) = csv::read(&results.join("history.csv")).unwrap();
    let last = rows.last().unwrap();
    for (name, force, moment, about) in [
        ("middle", [3.0, 0.0, -2.0], [0.0, 2.0, 0.0], [1.0, 0.5, 0.0]),
        // −(2, ½, 0) × (3, 0, −2)
        ("origin", [-3.0, 0.0, 2.0], [1.0, -4.0, 1.5], [0.0; 3]),
    ] {
        let found = summary.cuts[name];
        let columns = ["fx", "fy", "fz", "mx", "my", "mz", "x", "y", "z"];
        let of_summary = [found.force, found.moment, found.about].concat();
        let expected = [force, moment, about].concat();
        for ((column, of_summary), expected) in columns.iter().zip(of_summary).zip(expected) {
            let number = names.iter().position(|n| *n == format!("cut.{name}.{column}")).unwrap();
            assert_eq!(last[number], of_summary, "{name} {column}");
            assert!((of_summary - expected).abs() < 1e-8, "{name} {column}: {of_summary} {expected}");
        }
    }
    let behind = names.iter().position(|n| n == "cut.middle.fx").unwrap();
    assert_eq!(
        (names[behind - 1].as_str(), names[behind + 18].as_str()),
        ("load.edge.tip.mz", "balance.force")
    );
    assert_eq!(Summary::read(&results).unwrap().cuts, summary.cuts);
}

/// The axial force of the middle is 3 λ: it crosses 1.5 at half the load.
#[test]
fn an_analysis_stops_at_a_section_force() {
    let folder = tempfile::tempdir().unwrap();
    let stop = "stop = [{ column = \"cut.middle.fx\", value = 1.5 }]";
    let deck = deck(folder.path(), &format!("type = \"static\"\nlinear = true\n{stop}"));
    let summary = run(&deck, &options(&folder.path().join("results"), false), &mut Unwatched).unwrap();
    assert!((summary.stop.unwrap().time - 0.5).abs() < 1e-5, "{}", summary.time);
    assert!((summary.cuts["middle"].force[0] - 1.5).abs() < 1e-5);
    // Forces of the second order scheme are means over the step.
    let moving =
        format!("type = \"transient\"\nend_time = 0.1\nscheme = {{ type = \"energy-momentum\" }}\n{stop}");
    let moving = self::deck(folder.path(), &moving);
    let Err(JobError::Model(issues)) = prepare(&moving) else { panic!("it is taken") };
    assert!(issues.iter().any(|issue| issue.to_string().contains("mean over the step")), "{issues:?}");
}
