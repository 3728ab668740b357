//! Input files of Abaqus and CalculiX: run, checked and converted.

use super::{errors, example, near, result_of, summary, tegula, text};

/// K. Y. Sze, X. H. Liu, S. H. Lo, Popular benchmark problems for geometric nonlinear analysis of shells, Finite Elements in Analysis and
/// Design 40 (2004), Table 1: the end of the cantilever at the full load. CalculiX 2.20 gives 6.698486 and −3.288555 for the same file.
#[test]
fn the_cantilever_of_sze_is_read_from_its_input_file() {
    let s = result_of("sze_cantilever.inp");
    assert_eq!((&s["status"], &s["elements"]), (&"complete".into(), &64.into()));
    let u = &s["points"]["TIP"]["displacement"];
    near(&u[2], 6.698, 2e-3);
    near(&u[0], -3.286, 2e-3);
    near(&u[2], 6.698486, 2e-3);
    near(&u[0], -3.288555, 2e-3);
    assert!(u[1].as_f64().unwrap().abs() < 1e-6, "{u}");
    near(&s["supports"]["ROOT"]["force"][2], -4.0, 1e-6);
}

#[test]
fn a_converted_input_file_gives_the_same_results() {
    let folder = tempfile::tempdir().unwrap();
    let (model, out) = (folder.path().join("model.toml"), folder.path().join("out"));
    let deck = example("sze_cantilever.inp");
    let converted = tegula(&["convert", text(&deck), text(&model)]);
    assert!(converted.status.success(), "{}", errors(&converted));
    assert!(errors(&converted).contains("without effect: *NODE FILE (line "), "{}", errors(&converted));
    let written = std::fs::read_to_string(&model).unwrap();
    assert!(written.contains("type = \"clamp\"") && written.contains(": *BOUNDARY"), "{written}");
    let again = tegula(&["convert", text(&deck), text(&model)]);
    assert!(again.status.code() == Some(1) && errors(&again).contains("not overwritten"));
    let run = tegula(&["run", text(&model), "--out", text(&out), "--quiet"]);
    assert!(run.status.success(), "{}", errors(&run));
    let direct = result_of("sze_cantilever.inp");
    assert_eq!(summary(&out)["points"], direct["points"]);
}

#[test]
fn mistakes_of_an_input_file_show_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let deck = std::fs::read_to_string(example("sze_cantilever.inp")).unwrap();
    let path = folder.path().join("deck.INP");
    std::fs::write(&path, deck.replace("1.2e6, 0.", "-1.2e6, 0.")).unwrap();
    let check = tegula(&["check", text(&path)]);
    assert_eq!(check.status.code(), Some(1));
    let line = 1 + deck.lines().position(|line| line == "1.2e6, 0.").unwrap();
    let found = errors(&check);
    assert!(
        found.contains(&format!("deck.INP:{}:1", line - 1)) || found.contains(&format!("deck.INP:{line}:1")),
        "{found}"
    );
    std::fs::write(&path, deck.replace("*NODE FILE", "*VISCOELASTIC\n*PLASTIC")).unwrap();
    let check = tegula(&["check", text(&path)]);
    assert!(errors(&check).contains("these cards are not read: *PLASTIC (line "), "{}", errors(&check));
}
