//! `tegula report` and `run --report`.

use std::fs;

use crate::{errors, example, tegula, text};

#[test]
#[ignore = "long"]
fn runs_write_reports_and_so_does_the_command() {
    let folder = tempfile::tempdir().unwrap();
    let result = folder.path().join("modes");
    let model = example("free_plate_modes.toml");
    let run = tegula(&["run", text(&model), "--out", text(&result), "--quiet", "--report"]);
    assert!(run.status.success(), "{}", errors(&run));
    let page = fs::read_to_string(result.join("report.html")).unwrap();
    let title = "Modes of a free square plate, L/H = 100";
    for part in
        [&format!("<title>{title}</title>"), "a Sturm sequence count confirms", "2.14137894", "[materials."]
    {
        assert!(page.contains(part), "{part}");
    }
    // The command writes the same report, also to another place.
    let other = folder.path().join("other.html");
    let again = tegula(&["report", text(&result), "--out", text(&other)]);
    assert!(again.status.success(), "{}", errors(&again));
    assert_eq!(String::from_utf8(again.stdout).unwrap().trim(), text(&other));
    assert_eq!(fs::read_to_string(&other).unwrap(), page);
    // A model that is not the one that was run is not shown.
    let copy = folder.path().join("copy.toml");
    fs::copy(&model, &copy).unwrap();
    let result = folder.path().join("copied");
    assert!(tegula(&["run", text(&copy), "--out", text(&result), "--quiet"]).status.success());
    fs::write(&copy, "# changed\n").unwrap();
    assert!(tegula(&["report", text(&result)]).status.success());
    let page = fs::read_to_string(result.join("report.html")).unwrap();
    assert!(page.contains("The model file has changed since the run") && !page.contains("[materials."));
}

#[test]
fn reports_of_failed_runs_say_why_they_failed() {
    let folder = tempfile::tempdir().unwrap();
    // A path through limit points, which load steps do not pass.
    let given = fs::read_to_string(example("hinged_roof_path.toml")).unwrap();
    let (begin, end) = (given.find("[analysis]").unwrap(), given.find("[mesh]").unwrap());
    let given = given
        .replace("elements = [16, 16]", "elements = [4, 4]")
        .replace(&given[begin..end], "[analysis]\ntype = \"static\"\n\n");
    let model = folder.path().join("roof.toml");
    fs::write(&model, given).unwrap();
    let result = folder.path().join("result");
    let run = tegula(&["run", text(&model), "--out", text(&result), "--quiet", "--report"]);
    assert_eq!(run.status.code(), Some(3), "{}", errors(&run));
    let page = fs::read_to_string(result.join("report.html")).unwrap();
    assert!(page.contains("<span class=\"status failed\">failed</span>"));
    assert!(page.contains("limit point: 1 negative pivot of the tangent"));
}

#[test]
fn folders_without_results_and_damaged_files_are_errors() {
    let folder = tempfile::tempdir().unwrap();
    let none = tegula(&["report", text(folder.path())]);
    assert_eq!(none.status.code(), Some(1));
    assert!(errors(&none).contains("summary.json"), "{}", errors(&none));
    let result = folder.path().join("modes");
    let model = example("free_plate_modes.toml");
    assert!(tegula(&["run", text(&model), "--out", text(&result), "--quiet"]).status.success());
    let file = result.join("modes/0003.vtu");
    let whole = fs::read_to_string(&file).unwrap();
    fs::write(&file, &whole[..whole.len() / 2]).unwrap();
    let damaged = tegula(&["report", text(&result)]);
    assert_eq!(damaged.status.code(), Some(1));
    assert!(errors(&damaged).contains("0003.vtu"), "{}", errors(&damaged));
    assert!(!result.join("report.html").exists(), "nothing is written");
}

#[test]
fn models_have_reports_before_they_are_run() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("model.html");
    let model = example("cantilever_plate.toml");
    let out = tegula(&["report", text(&model), "--out", text(&file)]);
    assert!(out.status.success(), "{}", errors(&out));
    let page = fs::read_to_string(&file).unwrap();
    for part in ["Mesh, supports and loads", "clamp on ", "[materials.", "</html>"] {
        assert!(page.contains(part), "{part}");
    }
    // A wrong model has no report.
    let wrong = folder.path().join("wrong.toml");
    let given = fs::read_to_string(&model).unwrap();
    fs::write(&wrong, given.replace("type = \"clamp\"", "type = \"clamped\"")).unwrap();
    let file = folder.path().join("wrong.html");
    let out = tegula(&["report", text(&wrong), "--out", text(&file)]);
    assert_eq!(out.status.code(), Some(1), "{}", errors(&out));
    assert!(errors(&out).contains("clamped") && !file.exists());
}
