//! The program from outside: results of the examples, exit codes, messages, interruption.
#![allow(missing_docs, clippy::unwrap_used)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

fn tegula(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_tegula")).args(arguments).output().unwrap()
}

fn example(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples").join(name)
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn errors(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

fn summary(folder: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(folder.join("summary.json")).unwrap()).unwrap()
}

/// Runs an example and gives its summary.
fn result_of(name: &str) -> Value {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let output = tegula(&["run", text(&example(name)), "--out", text(&out), "--quiet"]);
    assert!(output.status.success() && output.stderr.is_empty(), "{}", errors(&output));
    summary(&out)
}

fn near(found: &Value, expected: f64, relative: f64) {
    let found = found.as_f64().unwrap();
    assert!((found / expected - 1.0).abs() < relative, "{found} for {expected}");
}

/// Writes a changed example and gives its path.
fn changed(folder: &Path, name: &str, changes: &[(&str, &str)]) -> PathBuf {
    let mut model = fs::read_to_string(example(name)).unwrap();
    for (from, to) in changes {
        assert!(model.contains(from), "{from}");
        model = model.replace(from, to);
    }
    let path = folder.join("model.toml");
    fs::write(&path, model).unwrap();
    path
}

#[test]
fn the_cantilever_plate_of_sect_5_1() {
    // Independent reference program; OpenSees prints the same digits.
    let s = result_of("cantilever_plate.toml");
    assert_eq!(s["status"], "complete");
    near(&s["points"]["corner"]["displacement"][2], -8.807639547e-4, 1e-7);
    near(&s["points"]["edge middle"]["displacement"][2], -9.033132579e-4, 1e-7);
}

#[test]
fn the_quarter_cylinder_of_sect_5_2() {
    // Independent reference program; three other codes converge to these values.
    let s = result_of("quarter_cylinder_static.toml");
    for (i, u) in [0.552276341, 0.005049535, -1.196237226].into_iter().enumerate() {
        near(&s["points"]["corner"]["displacement"][i], u, 1e-6);
    }
    near(&s["energy"]["strain"], 13.027580957, 1e-8);
    assert!(s["iterations"].as_u64().unwrap() <= 16 && s["cutbacks"] == 0, "{s}");
    for key in ["wall_s", "threads", "version", "fingerprint", "unknowns", "factorizations"] {
        assert!(!s[key].is_null(), "{key}");
    }
}

#[test]
fn the_free_plate_of_sect_5_3() {
    let s = result_of("free_plate_modes.toml");
    let f = s["frequencies_hz"].as_array().unwrap();
    assert_eq!(f.len(), 16);
    for (i, omega) in [1.3632442, 1.9871379, 2.4625301, 3.5251958, 3.5251958].into_iter().enumerate() {
        near(&f[6 + i], omega * std::f64::consts::PI / 2.0, 1e-6);
    }
}

/// To 0.5 s, where the published comparison allows 5 mm: trapezoidal rule with 0.5 ms on the same mesh by an
/// independent program, `verification/reference/pendulum_n16_trapezoid_dt05.csv`.
#[test]
fn the_pendulum_of_sect_5_4() {
    let folder = tempfile::tempdir().unwrap();
    let model =
        changed(folder.path(), "quarter_cylinder_pendulum.toml", &[("end_time = 1.5", "end_time = 0.5")]);
    let out = folder.path().join("results");
    let run = tegula(&["run", text(&model), "--out", text(&out), "--quiet"]);
    assert!(run.status.success(), "{}", errors(&run));
    let summary = summary(&out);
    let found = summary["points"]["opposite"]["position"].as_array().unwrap();
    for (x, expected) in found.iter().zip([0.8071271, 1.0172099, -0.6733573]) {
        assert!((x.as_f64().unwrap() - expected).abs() < 5e-3, "{found:?}");
    }
    assert!(out.join("fields.pvd").exists() && out.join("snapshots.png").exists());
}

#[test]
fn wrong_command_lines_and_files_exit_with_1() {
    let folder = tempfile::tempdir().unwrap();
    for arguments in
        [vec!["fly"], vec!["run"], vec!["run", "nowhere.toml"], vec!["new", "static", "Cargo.toml"]]
    {
        assert_eq!(tegula(&arguments).status.code(), Some(1), "{arguments:?}");
    }
    let help = tegula(&["--help"]);
    assert_eq!(help.status.code(), Some(0));
    let help = String::from_utf8(help.stdout).unwrap();
    for code in
        ["0    done", "1    wrong", "2    errors", "3    the analysis", "4    verify", "130  interrupted"]
    {
        assert!(help.contains(code), "{code}: {help}");
    }
    let template = folder.path().join("flag.toml");
    assert!(tegula(&["new", "transient", text(&template)]).status.success());
    let again = tegula(&["new", "transient", text(&template)]);
    assert!(again.status.code() == Some(1) && errors(&again).contains("not overwritten"));
    assert!(tegula(&["check", text(&template)]).status.success());

    // Templates with a mesh beside each other.
    for name in ["first.toml", "second.toml"] {
        let model = folder.path().join(name);
        assert!(tegula(&["new", "gmsh", text(&model)]).status.success());
        assert!(model.with_extension("geo").exists() && model.with_extension("msh").exists());
        assert!(tegula(&["check", text(&model)]).status.success());
    }

    let taken = folder.path().join("taken");
    fs::create_dir(&taken).unwrap();
    fs::write(taken.join("thesis.tex"), "my only copy").unwrap();
    let output = tegula(&["run", text(&example("cantilever_plate.toml")), "--out", text(&taken)]);
    assert!(output.status.code() == Some(1) && errors(&output).contains("not a result of tegula"));
    assert_eq!(fs::read_dir(&taken).unwrap().count(), 1);
}

#[test]
fn model_errors_exit_with_2_and_show_the_line() {
    let folder = tempfile::tempdir().unwrap();
    let message = |changes: &[(&str, &str)]| {
        let model = changed(folder.path(), "cantilever_plate.toml", changes);
        let output = tegula(&["check", text(&model)]);
        assert_eq!(output.status.code(), Some(2));
        errors(&output)
    };
    let wrong_key = message(&[("thickness", "tickness")]);
    assert!(wrong_key.contains("did you mean \"thickness\"?") && wrong_key.contains("tickness = 0.01"));
    let both = message(&[("\"u_min\"", "\"u_mim\""), ("young = 2.1e11", "young = -1")]);
    assert!(both.contains("did you mean \"u_min\"?") && both.contains("Young's modulus is -1"), "{both}");
    let long = message(&[
        ("thickness", "tickness"),
        ("[[sections]]", &format!("[[sections]] # {}", "x".repeat(900))),
    ]);
    assert!(long.contains("did you mean \"thickness\"?") && !long.contains("xxx"), "{long}");
    let free = message(&[("type = \"clamp\"", "type = \"hinge\"")]);
    assert!(free.contains("free mechanism") && free.contains("can turn about"), "{free}");
}

#[test]
fn warnings_fail_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let model = changed(
        folder.path(),
        "free_plate_modes.toml",
        &[("[analysis]", "[[loads]]\ntype = \"gravity\"\nvalue = [0, 0, 0]\n[analysis]")],
    );
    let output = tegula(&["check", text(&model)]);
    assert_eq!(output.status.code(), Some(0));
    assert!(String::from_utf8(output.stdout.clone()).unwrap().ends_with("no errors, 2 warnings\n"));
    let warnings = errors(&output);
    assert!(
        warnings.contains("warning: ") && warnings.contains("no effect on this modal analysis"),
        "{warnings}"
    );
    let out = folder.path().join("out");
    let run = tegula(&["run", text(&model), "--out", text(&out)]);
    assert!(run.status.success() && errors(&run).contains("the load is zero"));
    let printed = String::from_utf8(run.stdout.clone()).unwrap();
    assert!(
        printed.contains("complete: 16 modes, ") && printed.contains("cycles per unit of time"),
        "{printed}"
    );
    assert!(fs::read_to_string(out.join("log.txt")).unwrap().contains("warning: "));
}

#[cfg(target_os = "linux")]
#[test]
fn a_modal_analysis_stops_soon_and_promises_nothing() {
    use std::time::{Duration, Instant};
    let folder = tempfile::tempdir().unwrap();
    let model = changed(
        folder.path(),
        "free_plate_modes.toml",
        &[("elements = [", "elements = [70, 70] # ["), ("modes = 16", "modes = 90")],
    );
    let out = folder.path().join("out");
    let child = Command::new(env!("CARGO_BIN_EXE_tegula"))
        .args(["run", text(&model), "--out", text(&out)])
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let begun = Instant::now();
    while !out.join("summary.json").exists() && begun.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(5));
    }
    std::thread::sleep(Duration::from_millis(200));
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130));
    let said = errors(&output);
    assert!(said.contains("start it anew") && !said.contains("--resume"), "{said}");
}

#[test]
fn failed_analyses_exit_with_3() {
    let folder = tempfile::tempdir().unwrap();
    let hasty = "type = \"static\"\nmax_iterations = 2\nmax_cutbacks = 1";
    let model = changed(folder.path(), "quarter_cylinder_static.toml", &[("type = \"static\"", hasty)]);
    let out = folder.path().join("out");
    let output = tegula(&["run", text(&model), "--out", text(&out)]);
    assert_eq!(output.status.code(), Some(3));
    assert!(errors(&output).contains("no equilibrium"));
    assert_eq!(summary(&out)["status"], "failed");
}

#[cfg(target_os = "linux")]
#[test]
fn an_interrupted_run_resumes_to_the_same_history() {
    use std::process::Stdio;
    use std::time::{Duration, Instant};

    let folder = tempfile::tempdir().unwrap();
    let changes = [("[16, 16]", "[8, 8]"), ("end_time = 1.5", "end_time = 0.9")];
    let model = changed(folder.path(), "quarter_cylinder_pendulum.toml", &changes);
    let (straight, parts) = (folder.path().join("straight"), folder.path().join("parts"));
    assert!(tegula(&["run", text(&model), "--out", text(&straight), "--quiet"]).status.success());

    let mut child = Command::new(env!("CARGO_BIN_EXE_tegula"))
        .args(["run", text(&model), "--out", text(&parts), "--quiet"])
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let begun = Instant::now();
    let rows = || fs::read_to_string(parts.join("history.csv")).map_or(0, |h| h.lines().count());
    while rows() < 12 && begun.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(2));
    }
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let s = summary(&parts);
    assert_eq!(s["status"], "interrupted");
    assert!(s["time"].as_f64().unwrap() < 0.9);

    let resumed = tegula(&["run", text(&model), "--out", text(&parts), "--resume", "--quiet"]);
    assert!(resumed.status.success(), "{}", errors(&resumed));
    assert_eq!(summary(&parts)["status"], "complete");
    let read = |folder: &Path| fs::read(folder.join("history.csv")).unwrap();
    assert!(read(&straight) == read(&parts), "the histories differ");
}
