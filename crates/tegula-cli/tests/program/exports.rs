//! `tegula convert` of results.

use std::fs;

use tegula_io::out::numbers::counted;

use crate::{changed, errors, tegula, text};

#[test]
fn results_are_converted_and_no_file_is_written_over() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    let model = changed(folder.path(), "slider_crank.toml", &[("end_time = 5.0", "end_time = 0.01")]);
    let out = file("out");
    assert!(tegula(&["run", text(&model), "--out", text(&out), "--quiet"]).status.success());
    let vtkhdf = file("a.vtkhdf");
    // Bodies alone: the folder has no fields.
    let converted = tegula(&["convert", text(&out), text(&vtkhdf)]);
    assert!(converted.status.success() && converted.stderr.is_empty(), "{}", errors(&converted));
    let instants = fs::read_dir(out.join("bodies")).unwrap().count();
    let told = String::from_utf8(converted.stdout).unwrap();
    assert_eq!(
        told.trim(),
        format!("{}: {instants} instants of {}", text(&vtkhdf), text(&out.join("bodies.pvd")))
    );
    let written = fs::read(&vtkhdf).unwrap();
    assert!(written.starts_with(b"\x89HDF\r\n\x1a\n"));
    // By the name of the list it is the same file.
    let again = file("b.vtkhdf");
    assert!(tegula(&["convert", text(&out.join("bodies.pvd")), text(&again)]).status.success());
    assert!(fs::read(&again).unwrap() == written);
    let refused = tegula(&["convert", text(&out), text(&vtkhdf)]);
    assert!(refused.status.code() == Some(1) && errors(&refused).contains("not overwritten"));
    assert!(fs::read(&vtkhdf).unwrap() == written);

    // A removed file is left out, and told of.
    fs::remove_file(out.join("bodies/0001.vtu")).unwrap();
    let fewer = tegula(&["convert", text(&out), text(&file("c.vtkhdf"))]);
    assert!(fewer.status.success() && errors(&fewer).contains("the list names 1 file that cannot be found"));

    let table = file("a.parquet");
    let converted = tegula(&["convert", text(&out.join("history.csv")), text(&table)]);
    assert!(converted.status.success(), "{}", errors(&converted));
    let history = fs::read_to_string(out.join("history.csv")).unwrap();
    let (columns, rows) = (history.lines().next().unwrap().split(',').count(), history.lines().count() - 1);
    let told = String::from_utf8(converted.stdout).unwrap();
    assert_eq!(told.trim(), format!("{}: {columns} columns, {}", text(&table), counted(rows as u64, "row")));
    // The first page holds the times.
    let bytes = fs::read(&table).unwrap();
    let times = history.lines().skip(1).map(|line| line.split(',').next().unwrap().parse::<f64>().unwrap());
    let page: Vec<u8> = times.flat_map(f64::to_le_bytes).collect();
    assert!(bytes.windows(page.len()).take(100).any(|window| window == page));
}

#[test]
fn mistakes_in_the_names_of_results_are_explained() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    let empty = file("empty");
    fs::create_dir(&empty).unwrap();
    fs::write(file("t.csv"), "time,x\n0.0,one\n").unwrap();
    let told = |input: &str, output: &str, code: i32| {
        let refused = tegula(&["convert", text(&file(input)), text(&file(output))]);
        assert_eq!(refused.status.code(), Some(code), "{}", errors(&refused));
        assert!(!file(output).exists());
        errors(&refused)
    };
    let message = told("empty", "a.vtkhdf", 1);
    assert!(message.contains("it has no field files") && message.contains("lists (.pvd)"), "{message}");
    assert!(told("empty", "a.parquet", 1).contains("such as `history.csv`"));
    assert!(told("empty", "a.toml", 2).contains(".vtkhdf (field files) or .parquet (tables)"));
    assert!(told("t.csv", "a.parquet", 1).contains("line 2 has `one` for a number in column `x`"));
    assert!(told("t.csv", "a.vtkhdf", 1).contains("not a list of result files"));
    assert!(told("none.csv", "a.parquet", 1).contains("none.csv"));
    fs::write(file("t.csv"), "time,x\n0.0,1.0\n").unwrap();
    assert!(told("t.csv", "nowhere/a.parquet", 1).contains("Check that the folder exists"));
}

#[test]
fn the_steps_of_a_sequence_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let coarse = [("elements = [18, 12]", "elements = [4, 4]"), ("end_time = 0.2", "end_time = 0.002")];
    let model = changed(folder.path(), "preloaded_plate.toml", &coarse);
    let out = folder.path().join("out");
    assert!(tegula(&["run", text(&model), "--out", text(&out), "--quiet"]).status.success());
    let refused = tegula(&["convert", text(&out), text(&folder.path().join("a.vtkhdf"))]);
    assert!(errors(&refused).contains("Give the folder of one of its steps: `"), "{}", errors(&refused));
    let modes = folder.path().join("modes.vtkhdf");
    let step =
        fs::read_dir(&out).unwrap().map(|e| e.unwrap().path()).find(|path| path.join("modes.pvd").exists());
    assert!(tegula(&["convert", text(&step.unwrap()), text(&modes)]).status.success());
    assert!(fs::read(&modes).unwrap().starts_with(b"\x89HDF"));
}
