//! Runs of several analyses that follow one another.

use std::cell::Cell;
use std::fs;
use std::path::{Path, PathBuf};

use super::super::*;
use super::options;
use crate::deck::Deck;

const STEPS: &str = r#"
title = "Stretched strip"
[mesh]
type = "plate"
size = [1.0, 0.1]
grid = { elements = [8, 2] }
[materials.m]
type = "isotropic"
young = 1e9
poisson = 0.3
density = 1000.0
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
[[loads]]
type = "edge"
on = "u_max"
value = [2e4, 0.0, 0.0]
[output]
points = [{ name = "middle", at = [0.5, 0.05, 0.0] }]
pictures = false
[[steps]]
name = "preload"
analysis = { type = "static", load_steps = 6 }
[[steps]]
name = "modes"
analysis = { type = "modal", modes = 3 }
[[steps]]
name = "pluck. up"
at = [0.35]
[steps.analysis]
type = "static"
load_steps = 6
[[steps.loads]]
type = "pressure"
value = -10.0
[[steps]]
analysis = { type = "transient", end_time = 0.05, time_step = 1e-3 }
[[steps]]
name = "more"
analysis = { type = "transient", end_time = 0.02, time_step = 1e-3, scheme = { type = "energy-momentum" } }
[[steps.conditions]]
type = "fix"
on = "u_max"
position = ["x"]
"#;

const FOLDERS: [&str; 5] = ["1-preload", "2-modes", "3-pluck__up", "4-step_4", "5-more"];

fn deck() -> Deck {
    Deck::parse("strip.toml", STEPS).unwrap()
}

/// Asks to stop in the analysis with this number, behind a number of steps.
pub(super) struct StopIn {
    pub analysis: usize,
    pub steps: u64,
    pub begun: usize,
    pub stop: Cell<bool>,
}

impl JobObserver for StopIn {
    fn on_start(&mut self, _: &Start) {
        self.begun += 1;
        self.stop.set(self.begun == self.analysis && self.steps == 0);
    }
    fn on_step(&mut self, progress: &Progress) {
        self.stop.set(self.begun == self.analysis && progress.step >= self.steps);
    }
    fn interrupted(&self) -> bool {
        self.stop.get()
    }
}

/// All files below a folder but for those with times on the clock.
pub(super) fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut open = vec![folder.to_owned()];
    while let Some(next) = open.pop() {
        for entry in fs::read_dir(next).unwrap().map(|e| e.unwrap().path()) {
            let name = entry.file_name().unwrap().to_str().unwrap().to_owned();
            if entry.is_dir() {
                open.push(entry);
            } else if !["summary.json", "log.txt", "checkpoint.bin"].contains(&name.as_str()) {
                found.push(entry.strip_prefix(folder).unwrap().to_owned());
            }
        }
    }
    found.sort();
    found
}

#[test]
#[ignore = "long"]
fn steps_interrupted_anywhere_are_resumed_to_the_bit() {
    let folder = tempfile::tempdir().unwrap();
    let straight = folder.path().join("straight");
    let whole = run(&deck(), &options(&straight, false), &mut Unwatched).unwrap();
    let listed: Vec<_> = whole.analyses.iter().map(|a| (a.folder.as_str(), a.status)).collect();
    assert_eq!(listed, FOLDERS.map(|f| (f, Some(Status::Complete))));
    assert_eq!((whole.analysis.as_str(), whole.status), ("steps", Status::Complete));
    let parts = FOLDERS.map(|f| Summary::read(&straight.join(f)).unwrap());
    assert_eq!(whole.steps, parts.iter().map(|p| p.steps).sum::<u64>());
    assert_eq!(whole.points, parts[4].points);
    assert!(parts[1].frequencies_hz.as_ref().unwrap()[0] > 0.0);
    assert_eq!(
        fs::read_to_string(straight.join("3-pluck__up/fields.pvd")).unwrap().matches("0.35").count(),
        1
    );
    // Each step starts where the one before has ended.
    let history = |f: &str| crate::out::csv::read(&straight.join(f).join("history.csv")).unwrap().1;
    for (before, after) in [(0, 2), (2, 3), (3, 4)] {
        let end = history(FOLDERS[before]).last().unwrap()[1..7].to_vec();
        assert_eq!(history(FOLDERS[after])[0][1..7], end, "{}", FOLDERS[after]);
    }
    // The energy at the start of a step is that at the end of the one before.
    let strain = |row: &Vec<f64>| row[8];
    let (end, start) = (history(FOLDERS[0]), history(FOLDERS[2]));
    assert!(strain(end.last().unwrap()) > 0.0);
    assert!((strain(&start[0]) / strain(end.last().unwrap()) - 1.0).abs() < 1e-12);
    for (analysis, steps) in [(1, 3), (2, 0), (3, 2), (4, 20), (5, 7)] {
        let place = folder.path().join(format!("stopped in {analysis}"));
        let mut stop = StopIn { analysis, steps, begun: 0, stop: Cell::new(false) };
        let error = run(&deck(), &options(&place, false), &mut stop).unwrap_err();
        assert!(matches!(error, JobError::Interrupted { resumable: true, .. }), "{analysis}: {error}");
        let stopped = Summary::read(&place).unwrap();
        assert_eq!(stopped.status, Status::Interrupted, "{analysis}");
        assert_eq!(stopped.analyses[analysis - 1].status, Some(Status::Interrupted));
        assert!(stopped.analyses[analysis..].iter().all(|a| a.status.is_none()));
        let resumed = run(&deck(), &options(&place, true), &mut Unwatched).unwrap();
        assert_eq!((resumed.points, resumed.energy), (whole.points.clone(), whole.energy), "{analysis}");
        assert_eq!((resumed.steps, resumed.iterations), (whole.steps, whole.iterations), "{analysis}");
        assert_eq!(files(&place), files(&straight));
        for file in files(&straight) {
            let read = |folder: &Path| fs::read(folder.join(&file)).unwrap();
            assert!(read(&straight) == read(&place), "stopped in {analysis}: {} differs", file.display());
        }
        let again = run(&deck(), &options(&place, true), &mut Unwatched).unwrap();
        assert_eq!(again.status, Status::Complete);
    }
}

#[test]
fn folders_of_earlier_steps_are_cleared_and_what_is_foreign_stays() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("out");
    run(&deck(), &options(&place, false), &mut Unwatched).unwrap();
    fs::write(place.join("2-modes/notes.txt"), "mine").unwrap();
    // One analysis in the folder of several, and several again.
    let one = STEPS.split("[[steps]]").next().unwrap().to_owned() + "[analysis]\ntype = \"static\"\n";
    let one = Deck::parse("strip.toml", one).unwrap();
    run(&one, &options(&place, false), &mut Unwatched).unwrap();
    assert!(!place.join("1-preload").exists() && !place.join("4-step_4").exists());
    assert_eq!(files(&place.join("2-modes")), [Path::new("notes.txt")]);
    run(&deck(), &options(&place, false), &mut Unwatched).unwrap();
    assert!(!place.join("history.csv").exists() && place.join("5-more/history.csv").exists());
    // Results of another model are not resumed.
    let other = Deck::parse("strip.toml", STEPS.replace("2e4", "3e4")).unwrap();
    let error = run(&other, &options(&place, true), &mut Unwatched).unwrap_err();
    assert!(error.to_string().contains("of another model"), "{error}");
}

#[test]
fn a_step_that_fails_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("out");
    let text = STEPS.replace(
        "value = -10.0",
        "value = -10.0\n[[steps.loads]]\ntype = \"edge\"\non = \"u_max\"\nvalue = [-1e6, 0.0, 0.0]",
    );
    let error =
        run(&Deck::parse("strip.toml", text).unwrap(), &options(&place, false), &mut Unwatched).unwrap_err();
    assert!(matches!(error, JobError::Analysis { .. }), "{error}");
    let summary = Summary::read(&place).unwrap();
    assert_eq!(summary.status, Status::Failed);
    assert!(
        summary.error.as_ref().unwrap().starts_with("step \"pluck. up\": no equilibrium found"),
        "{:?}",
        summary.error
    );
    let states: Vec<_> = summary.analyses.iter().map(|a| a.status).collect();
    let (done, failed) = (Some(Status::Complete), Some(Status::Failed));
    assert_eq!(states, [done, done, failed, None, None]);
    // Mistakes of later steps are told before anything is computed.
    let text = STEPS.replace("on = \"u_max\"\nposition = [\"x\"]", "on = \"nowhere\"\nposition = [\"x\"]");
    let fresh = folder.path().join("fresh");
    let Err(JobError::Model(found)) =
        run(&Deck::parse("strip.toml", text).unwrap(), &options(&fresh, false), &mut Unwatched)
    else {
        panic!("accepted")
    };
    assert_eq!(found[0].key, "steps[4].conditions[0].on");
    assert!(found[0].line == 51 && !fresh.exists(), "{:?}", found[0]);
}

#[test]
fn a_model_has_one_analysis_or_steps() {
    let both = format!("{STEPS}\n[analysis]\ntype = \"static\"\n");
    let found = Deck::parse("strip.toml", both).unwrap_err();
    assert_eq!((found.len(), found[0].key.as_str()), (1, "analysis"), "{found:?}");
    let none = STEPS.split("[[steps]]").next().unwrap();
    for text in [none.to_owned(), none.replace("[mesh]\n", "steps = []\n[mesh]\n")] {
        let found = Deck::parse("strip.toml", text).unwrap_err();
        assert!(found.iter().any(|d| d.message == "missing key \"analysis\""), "{found:?}");
    }
}

/// Copies the result folder when an analysis begins, as a run that is killed there leaves it.
struct CopyAt<'a> {
    analysis: usize,
    begun: usize,
    from: &'a Path,
    to: &'a Path,
}

impl JobObserver for CopyAt<'_> {
    fn on_start(&mut self, _: &Start) {
        self.begun += 1;
        assert_eq!(Summary::read(self.from).unwrap().status, Status::Running);
        if self.begun == self.analysis {
            copy(self.from, self.to);
        }
    }
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap().map(|e| e.unwrap()) {
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &target);
        } else {
            fs::copy(entry.path(), target).unwrap();
        }
    }
}

#[test]
fn a_run_killed_in_a_later_step_is_resumed() {
    let folder = tempfile::tempdir().unwrap();
    let straight = folder.path().join("straight");
    for analysis in [2, 3, 5] {
        let killed = folder.path().join(format!("killed in {analysis}"));
        let mut watch = CopyAt { analysis, begun: 0, from: &straight, to: &killed };
        let whole = run(&deck(), &options(&straight, false), &mut watch).unwrap();
        let resumed = run(&deck(), &options(&killed, true), &mut Unwatched).unwrap();
        assert_eq!((resumed.points, resumed.steps), (whole.points, whole.steps), "{analysis}");
        for file in files(&straight) {
            let read = |folder: &Path| fs::read(folder.join(&file)).unwrap();
            assert!(read(&straight) == read(&killed), "killed in {analysis}: {} differs", file.display());
        }
    }
    // A file in the way of a later step stops the run before it begins.
    let stray = straight.join("5-more/fields/0777.vtu");
    fs::write(stray, "mine").unwrap();
    let error = run(&deck(), &options(&straight, false), &mut Unwatched).unwrap_err();
    assert!(error.to_string().contains("was not written by tegula"), "{error}");
    assert_eq!(Summary::read(&straight).unwrap().status, Status::Complete);
}

/// A flap that a bolt holds, swings, is caught by its locked hinge and swings again.
const FLAP: &str = r#"
output = { pictures = false }
loads = [{ type = "gravity", value = [0.0, -10.0, 0.0] }]

[[bodies]]
name = "flap"
at = [0.5, 0.0, 0.0]
mass = 2.0
inertia = [0.2, 0.25, 0.3]

[[joints]]
type = "revolute"
name = "hinge"
between = ["ground", "flap"]
at = [0.0, 0.0, 0.0]
axis = [0.0, 0.0, 1.0]

[[joints]]
type = "fixed"
name = "bolt"
between = ["ground", "flap"]
at = [1.0, 0.0, 0.0]

[[steps]]
name = "bolted"
released = ["hinge"]
analysis = { type = "static", load_steps = 3 }

[[steps]]
name = "free"
released = ["bolt"]
analysis = { type = "transient", end_time = 0.2, time_step = 0.01, scheme = { type = "energy-momentum" } }

[[steps]]
name = "caught"
released = ["bolt"]
locked = ["hinge"]
analysis = { type = "transient", end_time = 0.1, time_step = 0.01, scheme = { type = "generalized-alpha" } }

[[steps]]
name = "free again"
released = ["bolt"]
analysis = { type = "transient", end_time = 0.1, time_step = 0.01, scheme = { type = "energy-momentum" } }
"#;

/// Each step has its own constraints, and the checkpoint of each as many multipliers.
#[test]
fn steps_that_release_and_lock_joints_are_resumed_to_the_bit() {
    let flap = Deck::parse("flap.toml", FLAP).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let straight = folder.path().join("straight");
    let whole = run(&flap, &options(&straight, false), &mut Unwatched).unwrap();
    let history = |place: &Path, f: &str| crate::out::csv::read(&place.join(f).join("history.csv")).unwrap();
    let folders: Vec<String> = whole.analyses.iter().map(|a| a.folder.clone()).collect();
    let at = |f: &str, column: &str, row: usize| {
        let (names, rows) = history(&straight, f);
        rows[row][names.iter().position(|n| n == column).unwrap()]
    };
    // The bolt carries m g l about its point at the end of the flap, and nothing when it is gone.
    assert!((at(&folders[0], "joint.bolt.mz", 3) + 10.0).abs() < 1e-8);
    assert_eq!(at(&folders[1], "joint.bolt.fy", 10), 0.0);
    // All kinetic energy of the flap is lost where its hinge locks; then it stays, and falls again.
    let last = history(&straight, &folders[1]).1.len() - 1;
    let kinetic = at(&folders[1], "kinetic", last);
    assert!(kinetic > 1.0 && (at(&folders[2], "dissipated", 0) / kinetic - 1.0).abs() < 1e-3);
    assert_eq!(at(&folders[2], "body.flap.y", 0), at(&folders[1], "body.flap.y", last));
    assert!((at(&folders[2], "body.flap.y", 10) / at(&folders[2], "body.flap.y", 0) - 1.0).abs() < 1e-10);
    assert!(at(&folders[3], "body.flap.y", 10) < 1.01 * at(&folders[3], "body.flap.y", 0));
    for (analysis, steps) in [(1, 2), (2, 0), (2, 7), (3, 0), (3, 5), (4, 3)] {
        let place = folder.path().join(format!("stopped in {analysis} at {steps}"));
        let mut stop = StopIn { analysis, steps, begun: 0, stop: Cell::new(false) };
        let error = run(&flap, &options(&place, false), &mut stop).unwrap_err();
        assert!(matches!(error, JobError::Interrupted { resumable: true, .. }), "{analysis}: {error}");
        run(&flap, &options(&place, true), &mut Unwatched).unwrap();
        assert_eq!(files(&place), files(&straight));
        for file in files(&straight) {
            let read = |folder: &Path| fs::read(folder.join(&file)).unwrap();
            assert!(read(&straight) == read(&place), "stopped in {analysis}: {} differs", file.display());
        }
    }
}

/// A column that a static step has taken to 1.5 times its Euler load, straight and unstable, and a path that takes the load back: the number of negative
/// eigenvalues of its first row is that of the state from which it starts.
#[test]
fn the_first_row_of_a_path_tells_how_unstable_its_start_is() {
    let text = r#"
    [materials.m]
    type = "isotropic"
    young = 1e9
    poisson = 0.0
    density = 1.0
    [[beams]]
    name = "column"
    points = [[0, 0, 0], [1, 0, 0]]
    elements = 16
    direction = [0, 0, 1]
    section = { type = "rectangle", size = [0.01, 0.02] }
    material = "m"
    [[bodies]]
    name = "slider"
    at = [1, 0, 0]
    mass = 1.0
    inertia = [1, 1, 1]
    [[joints]]
    type = "revolute"
    name = "foot"
    between = ["ground", "column.start"]
    at = [0, 0, 0]
    axis = [0, 1, 0]
    [[joints]]
    type = "revolute"
    name = "head"
    between = ["slider", "column.end"]
    at = [1, 0, 0]
    axis = [0, 1, 0]
    [[joints]]
    type = "prismatic"
    name = "guide"
    between = ["ground", "slider"]
    at = [1, 0, 0]
    axis = [1, 0, 0]
    [output]
    pictures = false
    [[steps]]
    name = "up"
    analysis = { type = "static", allow_unstable = true }
    loads = [{ type = "force", on = "slider", value = [-24.67, 0, 0] }]
    [[steps]]
    name = "down"
    analysis = { type = "path" }
    loads = [{ type = "force", on = "slider", value = [-8.22, 0, 0] }]
    "#;
    let folder = tempfile::tempdir().unwrap();
    let deck = Deck::parse("column.toml", text).unwrap();
    run(&deck, &options(folder.path(), false), &mut Unwatched).unwrap();
    let (names, rows) = crate::out::csv::read(&folder.path().join("2-down/history.csv")).unwrap();
    let place = names.iter().position(|name| name == "path.negative_eigenvalues").unwrap();
    let negative: Vec<f64> = rows.iter().map(|row| row[place]).collect();
    assert!(negative.len() > 3 && negative[0] == 1.0 && negative[1] == 1.0, "{negative:?}");
    assert_eq!(negative.last(), Some(&0.0), "{negative:?}");
}
