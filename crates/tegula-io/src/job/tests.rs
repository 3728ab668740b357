//! Whole runs in temporary folders.

mod buckling;
mod checkpoint;
mod cuts;
mod fields;
mod friction;
mod gears;
mod inputs;
mod mesh_parts;
mod response;
mod steps;
mod stop_conditions;

use std::cell::Cell;
use std::fs;
use std::path::Path;

use super::resume::CheckpointData;
use super::snapshots::StoredSnapshot;
use super::*;
use crate::deck::Deck;
use crate::out::{PvdSeries, csv};

const SWING: &str = r#"
title = "Swinging strip"
[analysis]
type = "transient"
end_time = 0.2
tolerance = 1e-4
scheme = { type = "SCHEME" }
[mesh]
type = "plate"
size = [1.0, 0.5]
grid = { elements = [4, 2] }
[materials.rubber]
type = "isotropic"
young = 1e6
poisson = 0.3
density = 1000.0
[[sections]]
material = "rubber"
thickness = 0.02
retardation_time = 0.001
[[conditions]]
type = "hinge"
on = "u_min"
[[loads]]
type = "gravity"
value = [0.0, 0.0, -9.81]
[[loads]]
type = "force"
on = "u_max_v_max"
value = [0.0, 1.0, 0.0]
amplitude = "pull"
[amplitudes.pull]
type = "ramp"
end = 0.1
[output]
points = [{ name = "corner", on = "u_max_v_max" }]
interval = 0.02
pictures = false
"#;

fn deck(scheme: &str) -> Deck {
    Deck::parse("swing.toml", SWING.replace("SCHEME", scheme)).unwrap()
}

fn options(folder: &Path, resume: bool) -> JobOptions {
    JobOptions { folder: folder.to_owned(), resume, force: false }
}

fn claim() -> Claim<'static> {
    Claim { model: Path::new("swing.toml"), fingerprint: 1, force: false }
}

/// Asks to stop after a number of steps.
struct StopAfter(u64, Cell<bool>);

impl JobObserver for StopAfter {
    fn on_step(&mut self, progress: &Progress) {
        self.1.set(progress.step >= self.0);
    }
    fn interrupted(&self) -> bool {
        self.1.get()
    }
}

fn stop_after(steps: u64) -> StopAfter {
    StopAfter(steps, Cell::new(false))
}

#[test]
#[ignore = "long"]
fn a_resumed_run_repeats_the_straight_one_to_the_bit() {
    for scheme in ["newmark", "energy-momentum", "hht", "generalized-alpha", "explicit"] {
        // Drawing takes most of the time; no picture depends on the scheme.
        let drawn = scheme == "newmark";
        let cut = "[output]\ncuts = [{ name = \"hinge\", on = \"u_min\", of = \"all\" }]";
        let text = SWING.replace("SCHEME", scheme).replace("[output]", cut);
        let (mut deck, folder) = (Deck::parse("swing.toml", text).unwrap(), tempfile::tempdir().unwrap());
        deck.model.output.pictures = drawn;
        let (straight, parts) = (folder.path().join("straight"), folder.path().join("parts"));
        let whole = run(&deck, &options(&straight, false), &mut Unwatched).unwrap();
        // Explicit steps are reported by tens.
        let stops = if scheme == "explicit" { [10, 20, 30] } else { [5, 6, 11] };
        assert!(whole.steps > stops[2] + 1, "{} steps", whole.steps);
        for (resume, stop) in [false, true, true].into_iter().zip(stops) {
            let error = run(&deck, &options(&parts, resume), &mut stop_after(stop)).unwrap_err();
            assert!(matches!(error, JobError::Interrupted { .. }), "{error}");
            let summary = Summary::read(&parts).unwrap();
            assert_eq!((summary.status, summary.steps), (Status::Interrupted, stop));
        }
        let resumed = run(&deck, &options(&parts, true), &mut Unwatched).unwrap();
        let read = |folder: &Path, name: &str| fs::read(folder.join(name)).unwrap();
        let pictures = ["energy.png", "step_size.png", "snapshots.png"].into_iter().filter(|_| drawn);
        for name in ["history.csv", "fields.pvd"].into_iter().chain(pictures) {
            assert!(read(&straight, name) == read(&parts, name), "{scheme}: {name} differs");
        }
        let series = PvdSeries::open(&parts.join("fields.pvd")).unwrap();
        for (_, name) in series.entries() {
            assert!(read(&straight, name) == read(&parts, name), "{scheme}: {name} differs");
        }
        assert_eq!(fs::read_dir(parts.join("fields")).unwrap().count(), series.entries().len());
        assert_eq!(
            (whole.steps, whole.iterations, whole.points, whole.energy),
            (resumed.steps, resumed.iterations, resumed.points, resumed.energy)
        );
        assert_eq!(whole.energy_error, resumed.energy_error, "{scheme}");
        assert_eq!(whole.energy_error.is_some(), scheme == "explicit");
        assert!(!whole.supports.is_empty() && whole.balance.is_some());
        assert_eq!((whole.supports, whole.loads), (resumed.supports, resumed.loads), "{scheme}");
        assert_eq!((whole.cuts.len(), &whole.cuts), (1, &resumed.cuts), "{scheme}");

        // To resume what is complete changes nothing.
        let before = read(&parts, "summary.json");
        let again = run(&deck, &options(&parts, true), &mut Unwatched).unwrap();
        assert!(again.status == Status::Complete && read(&parts, "summary.json") == before, "{scheme}");
        // Killed between the last checkpoint and the last summary: nothing is missing.
        let text = String::from_utf8(before).unwrap().replace("\"complete\"", "\"running\"");
        fs::write(parts.join("summary.json"), text).unwrap();
        let last = run(&deck, &options(&parts, true), &mut Unwatched).unwrap();
        let forces = |s: &Summary| (s.supports.clone(), s.loads.clone(), s.cuts.clone(), s.balance);
        assert!(last.status == Status::Complete && forces(&last) == forces(&again), "{scheme}");
        let explicit = |s: &Summary| (s.critical_step, s.energy_error);
        assert_eq!(explicit(&last), explicit(&again), "{scheme}");
    }
}

/// Values that are no numbers are written as `null`; a folder with such a summary is known as a result.
#[test]
fn a_summary_without_numbers_is_read_again() {
    let folder = tempfile::tempdir().unwrap();
    let summary = run(&deck("newmark"), &options(folder.path(), false), &mut Unwatched).unwrap();
    let broken = Summary {
        energy: Energy { kinetic: f64::NAN, total: f64::INFINITY, ..summary.energy },
        points: summary.points.keys().map(|n| (n.clone(), no_point())).collect(),
        ..summary.clone()
    };
    broken.write(folder.path()).unwrap();
    let read = Summary::read(folder.path()).unwrap();
    assert!(read.energy.kinetic.is_nan() && read.energy.total.is_nan());
    assert_eq!(read.energy.strain, summary.energy.strain);
    assert!(read.points.len() == summary.points.len() && !read.points.is_empty());
    assert!(read.points.values().all(|p| p.position[1].is_nan() && p.displacement[0] == 1.0));
    run(&deck("newmark"), &options(folder.path(), false), &mut Unwatched).unwrap();
}

fn no_point() -> PointResult {
    PointResult { position: [0.0, f64::NAN, 0.0], displacement: [1.0; 3] }
}

#[test]
#[ignore = "long"]
fn pictures_can_be_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let pictures = |text: String| {
        let deck = Deck::parse("swing.toml", text).unwrap();
        run(&deck, &options(folder.path(), false), &mut Unwatched).unwrap();
        let files = fs::read_dir(folder.path()).unwrap().map(|f| f.unwrap().path());
        files.filter(|f| f.extension().is_some_and(|e| e == "png")).count()
    };
    let text = SWING.replace("SCHEME", "newmark");
    assert_eq!(pictures(text.clone()), 0);
    assert!(pictures(text.replace("pictures = false", "")) >= 3);
}

#[test]
fn a_killed_run_resumes_from_its_last_checkpoint() {
    let (deck, folder) = (deck("newmark"), tempfile::tempdir().unwrap());
    let (straight, killed) = (folder.path().join("straight"), folder.path().join("killed"));
    run(&deck, &options(&straight, false), &mut Unwatched).unwrap();
    // What a killed run leaves: an old checkpoint, later rows (the last one half written), later fields.
    run(&deck, &options(&killed, false), &mut stop_after(7)).unwrap_err();
    let checkpoint = fs::read(killed.join("checkpoint.bin")).unwrap();
    run(&deck, &options(&killed, true), &mut stop_after(12)).unwrap_err();
    fs::write(killed.join("checkpoint.bin"), checkpoint).unwrap();
    let mut history = fs::read_to_string(killed.join("history.csv")).unwrap();
    history.push_str("0.12,3.4");
    fs::write(killed.join("history.csv"), history).unwrap();
    run(&deck, &options(&killed, true), &mut Unwatched).unwrap();
    for name in ["history.csv", "fields.pvd", "fields/0003.vtu"] {
        assert!(fs::read(straight.join(name)).unwrap() == fs::read(killed.join(name)).unwrap(), "{name}");
    }
}

#[test]
fn a_folder_with_foreign_files_is_refused_and_an_earlier_result_cleared() {
    let (deck, folder) = (deck("newmark"), tempfile::tempdir().unwrap());
    let path = folder.path();
    fs::write(path.join("thesis.tex"), "my only copy").unwrap();
    let error = run(&deck, &options(path, false), &mut Unwatched).unwrap_err();
    assert!(error.to_string().contains("not a result"), "{error}");
    assert_eq!(fs::read_dir(path).unwrap().count(), 1);
    // To run without `--resume` there would be refused as well.
    let error = run(&deck, &options(path, true), &mut Unwatched).unwrap_err().to_string();
    assert!(error.contains("no result of tegula to resume") && !error.contains("without"), "{error}");
    let error = run(&deck, &options(&path.join("new"), true), &mut Unwatched).unwrap_err();
    assert!(error.to_string().contains("no interrupted run"), "{error}");

    let results = path.join("results");
    run(&deck, &options(&results, false), &mut Unwatched).unwrap();
    fs::write(results.join("notes.md"), "kept").unwrap();
    fs::copy(results.join("fields/0001.vtu"), results.join("fields/0999.vtu")).unwrap();
    let mine =
        ["fields/mine.vtu", "fields/7.vtu", "fields/notes.txt", "point_of_view.png"].map(|f| results.join(f));
    mine.iter().for_each(|file| fs::write(file, "my only copy").unwrap());
    run(&deck, &options(&results, false), &mut stop_after(2)).unwrap_err();
    run(&deck, &options(&results, true), &mut Unwatched).unwrap();
    assert!(results.join("notes.md").exists() && !results.join("fields/0999.vtu").exists());
    assert!(mine.iter().all(|file| fs::read(file).unwrap() == b"my only copy"));
    // Where one has the name of a field file, nothing is touched.
    fs::write(results.join("fields/0998.vtu"), "my only copy").unwrap();
    let error = run(&deck, &options(&results, false), &mut Unwatched).unwrap_err().to_string();
    assert!(error.contains("0998.vtu") && error.contains("Move it"), "{error}");
    assert_eq!(Summary::read(&results).unwrap().status, Status::Complete);
    assert_eq!(fs::read(results.join("fields/0998.vtu")).unwrap(), b"my only copy");
    let error = run(&deck, &options(&path.join("thesis.tex"), false), &mut Unwatched).unwrap_err();
    assert!(error.to_string().contains("is a file"), "{error}");
}

#[test]
fn a_folder_is_written_by_one_run_at_a_time() {
    let folder = tempfile::tempdir().unwrap();
    let first = ResultFolder::start(folder.path(), &claim()).unwrap();
    let error = ResultFolder::start(folder.path(), &claim()).unwrap_err();
    assert!(error.to_string().contains("another run"), "{error}");
    drop(first);
    ResultFolder::start(folder.path(), &claim()).unwrap();
}

#[test]
fn a_failed_run_says_so_and_keeps_what_it_found() {
    let few = "load_steps = 2\nmax_iterations = 3\nmax_cutbacks = 1\nmethod = \"displacement\"";
    let text = SWING
        .replace("type = \"transient\"", "type = \"static\"")
        .replace("end_time = 0.2\ntolerance = 1e-4\nscheme = { type = \"SCHEME\" }", few)
        .replace("type = \"hinge\"", "type = \"clamp\"");
    let deck = Deck::parse("hasty.toml", text).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let error = run(&deck, &options(folder.path(), false), &mut Unwatched).unwrap_err();
    assert!(matches!(error, JobError::Analysis { .. }), "{error}");
    let summary = Summary::read(folder.path()).unwrap();
    assert_eq!(summary.status, Status::Failed);
    assert!(summary.error.is_some_and(|e| e.contains("no equilibrium")));
    let (_, rows) = csv::read(&folder.path().join("history.csv")).unwrap();
    assert_eq!(rows.len() as u64, summary.steps + 1);
}

#[test]
fn a_model_with_errors_touches_nothing() {
    let text = SWING.replace("SCHEME", "newmark").replace("on = \"u_min\"", "on = \"left\"");
    let deck = Deck::parse("swing.toml", text).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("results");
    let JobError::Model(found) = run(&deck, &options(&path, false), &mut Unwatched).unwrap_err() else {
        panic!("not a model error")
    };
    assert!(found[0].key == "conditions[0].on" && found[0].line > 0, "{}", found[0]);
    assert!(!path.exists());
}

/// Collects warnings.
#[derive(Default)]
struct Warnings(Vec<String>);

impl JobObserver for Warnings {
    fn on_warning(&mut self, message: &str) {
        self.0.push(message.to_owned());
    }
}

#[test]
fn a_run_goes_on_without_the_files_that_are_gone_and_says_so() {
    let (deck, folder) = (deck("newmark"), tempfile::tempdir().unwrap());
    let path = folder.path();
    run(&deck, &options(path, false), &mut stop_after(7)).unwrap_err();
    fs::remove_dir_all(path.join("fields")).unwrap();
    fs::write(path.join(".tegula-abc.part"), "half").unwrap();
    let mut warnings = Warnings::default();
    let summary = run(&deck, &options(path, true), &mut warnings).unwrap();
    assert_eq!(summary.warnings, warnings.0);
    assert!(
        warnings.0.iter().any(|w| w.contains("field file(s) of the earlier part are no longer there")),
        "{:?}",
        warnings.0
    );
    assert!(!path.join(".tegula-abc.part").exists());
    for (_, name) in PvdSeries::open(&path.join("fields.pvd")).unwrap().entries() {
        assert!(path.join(name).exists(), "{name}");
    }
}

#[cfg(unix)]
#[test]
fn a_log_that_is_a_link_is_replaced_and_its_file_stays() {
    let (deck, folder) = (deck("newmark"), tempfile::tempdir().unwrap());
    let (out, other) = (folder.path().join("out"), folder.path().join("other.txt"));
    run(&deck, &options(&out, false), &mut Unwatched).unwrap();
    fs::write(&other, "keep").unwrap();
    fs::remove_file(out.join("log.txt")).unwrap();
    std::os::unix::fs::symlink(&other, out.join("log.txt")).unwrap();
    run(&deck, &options(&out, false), &mut Unwatched).unwrap();
    assert_eq!(fs::read_to_string(&other).unwrap(), "keep");
    assert!(
        !out.join("log.txt").is_symlink()
            && fs::read_to_string(out.join("log.txt")).unwrap().contains("steps")
    );
}

#[test]
fn half_written_files_of_a_killed_run_do_not_make_a_folder_foreign() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join(".tegula-abc.part"), "half").unwrap();
    let started = ResultFolder::start(folder.path(), &claim()).unwrap();
    assert!(!folder.path().join(".tegula-abc.part").exists());
    drop(started);
}

/// Makes further writing impossible after a number of steps: a folder takes the place of the next field file.
#[cfg(unix)]
struct Obstruct<'a>(&'a Path, u64);

#[cfg(unix)]
impl JobObserver for Obstruct<'_> {
    fn on_step(&mut self, progress: &Progress) {
        if progress.step == self.1 {
            for number in 0..40 {
                let _ = fs::create_dir(self.0.join(format!("fields/{number:04}.vtu")));
            }
        }
    }
}

#[cfg(unix)]
#[test]
fn a_run_that_cannot_write_says_so_in_its_summary() {
    let folder = tempfile::tempdir().unwrap();
    let error =
        run(&deck("newmark"), &options(folder.path(), false), &mut Obstruct(folder.path(), 5)).unwrap_err();
    assert!(matches!(error, JobError::Output(_)), "{error}");
    let summary = Summary::read(folder.path()).unwrap();
    assert_eq!(summary.status, Status::Failed);
    assert!(summary.error.is_some_and(|e| e.contains(".vtu") && e.contains("cannot write")));
    // Modes are written at the end, behind the solve.
    let modes = tempfile::tempdir().unwrap();
    fs::write(modes.path().join(".tegula-x.part"), "").unwrap();
    let text = SWING.replace(
        "type = \"transient\"\nend_time = 0.2\ntolerance = 1e-4\nscheme = { type = \"SCHEME\" }",
        "type = \"modal\"\nmodes = 3",
    );
    let deck = Deck::parse("modes.toml", text).unwrap();
    struct Block<'a>(&'a Path);
    impl JobObserver for Block<'_> {
        fn on_start(&mut self, _: &Start) {
            fs::create_dir(self.0.join("modes.csv")).unwrap();
        }
    }
    run(&deck, &options(modes.path(), false), &mut Block(modes.path())).unwrap_err();
    let summary = Summary::read(modes.path()).unwrap();
    assert_eq!(summary.status, Status::Failed);
    assert!(summary.error.is_some_and(|e| e.contains("modes.csv")));
}

#[test]
fn the_results_of_another_model_are_replaced_only_by_force() {
    let folder = tempfile::tempdir().unwrap();
    let (home, out) = (folder.path(), folder.path().join("out"));
    let write = |name: &str, young: &str| {
        let path = home.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, SWING.replace("SCHEME", "newmark").replace("young = 1e6", young)).unwrap();
        Deck::read(&path).unwrap()
    };
    let start =
        |deck: &Deck, force| run(deck, &JobOptions { force, ..options(&out, false) }, &mut stop_after(1));
    let interrupted = |r: Result<Summary, JobError>| matches!(r.unwrap_err(), JobError::Interrupted { .. });
    assert!(interrupted(start(&write("a/m.toml", "young = 1e6"), false)));
    // The same file, changed; the same text at another place.
    assert!(interrupted(start(&write("a/m.toml", "young = 2e6"), false)));
    assert!(interrupted(start(&write("b/m.toml", "young = 2e6"), false)));
    let other = write("c/m.toml", "young = 3e6");
    let error = start(&other, false).unwrap_err().to_string();
    assert!(
        error.contains("another model") && error.contains("--force") && error.contains("b/m.toml"),
        "{error}"
    );
    assert!(interrupted(start(&other, true)));
    // A model that has been moved.
    fs::rename(home.join("c"), home.join("d")).unwrap();
    assert!(interrupted(start(&write("d/m.toml", "young = 4e6"), false)));
}

#[test]
fn a_lost_list_of_field_files_is_begun_anew() {
    let (deck, folder) = (deck("newmark"), tempfile::tempdir().unwrap());
    run(&deck, &options(folder.path(), false), &mut stop_after(7)).unwrap_err();
    let list = folder.path().join("fields.pvd");
    fs::write(&list, "damaged").unwrap();
    let error = run(&deck, &options(folder.path(), true), &mut Unwatched).unwrap_err().to_string();
    assert!(error.contains("Remove the file to start a new list"), "{error}");
    assert_eq!(Summary::read(folder.path()).unwrap().status, Status::Failed);
    fs::remove_file(&list).unwrap();
    run(&deck, &options(folder.path(), true), &mut Unwatched).unwrap();
    assert!(!PvdSeries::open(&list).unwrap().entries().is_empty());
}

/// Reads the summary in the middle of a run.
struct Reader<'a>(&'a Path, Vec<Summary>);

impl JobObserver for Reader<'_> {
    fn on_step(&mut self, _progress: &Progress) {
        self.1.push(Summary::read(self.0).unwrap());
    }
}

#[test]
fn the_summary_keeps_up_with_the_checkpoint() {
    let folder = tempfile::tempdir().unwrap();
    let mut reader = Reader(folder.path(), Vec::new());
    run(&deck("newmark"), &options(folder.path(), false), &mut reader).unwrap();
    let late = reader.1.iter().rev().nth(1).unwrap();
    assert!(late.status == Status::Running && late.time > 0.1 && late.iterations > 10, "{late:?}");
}

#[test]
fn repeated_steps_count_also_where_none_succeeds() {
    let few = "load_steps = 1\nmax_iterations = 2\nmax_cutbacks = 3\nmethod = \"displacement\"";
    let text = SWING
        .replace("type = \"transient\"", "type = \"static\"")
        .replace("end_time = 0.2\ntolerance = 1e-4\nscheme = { type = \"SCHEME\" }", few)
        .replace("type = \"hinge\"", "type = \"clamp\"");
    let deck = Deck::parse("hasty.toml", text).unwrap();
    let folder = tempfile::tempdir().unwrap();
    run(&deck, &options(folder.path(), false), &mut Unwatched).unwrap_err();
    let summary = Summary::read(folder.path()).unwrap();
    assert_eq!((summary.steps, summary.cutbacks, summary.iterations), (0, 3, 8));
}

/// Asks to stop from the start, and counts how often it is asked.
struct Impatient(Cell<u64>);

impl JobObserver for Impatient {
    fn interrupted(&self) -> bool {
        self.0.set(self.0.get() + 1);
        self.0.get() > 40
    }
}

#[test]
fn a_modal_analysis_stops_between_two_applications_of_the_inverse() {
    let text = SWING.replace(
        "type = \"transient\"\nend_time = 0.2\ntolerance = 1e-4\nscheme = { type = \"SCHEME\" }",
        "type = \"modal\"\nmodes = 30",
    );
    let deck = Deck::parse("modes.toml", text).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let mut watch = Impatient(Cell::new(0));
    let error = run(&deck, &options(folder.path(), false), &mut watch).unwrap_err();
    assert!(matches!(error, JobError::Interrupted { resumable: false, .. }), "{error}");
    assert_eq!(Summary::read(folder.path()).unwrap().status, Status::Interrupted);
    // Once noticed, nothing more is computed.
    assert!(watch.0.get() < 46, "{}", watch.0.get());
}
