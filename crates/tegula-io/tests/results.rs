//! Result files of whole runs, read as a user reads them.

#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use tegula_io::deck::Deck;
use tegula_io::job::{self, JobObserver, JobOptions, Progress, Summary, Unwatched};
use tegula_io::out::csv;

fn run(text: &str, folder: &Path) -> Summary {
    let deck = Deck::parse("model.toml", text).unwrap();
    job::run(&deck, &JobOptions { folder: folder.to_owned(), resume: false, force: false }, &mut Unwatched)
        .unwrap()
}

/// All files of a result but those that tell the time.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut out = BTreeMap::new();
    for part in ["", "fields", "modes"] {
        let Ok(entries) = fs::read_dir(folder.join(part)) else { continue };
        for path in entries.map(|e| e.unwrap().path()).filter(|p| p.is_file()) {
            let name = path.strip_prefix(folder).unwrap().display().to_string();
            if !["summary.json", "log.txt", "checkpoint.bin"].contains(&name.as_str()) {
                out.insert(name, fs::read(&path).unwrap());
            }
        }
    }
    out
}

/// A strip with a force of zero, of which the program warns.
const WARNED: &str = r#"
[mesh]
type = "plate"
size = [1.0, 0.5]
grid = { elements = [2, 1] }
[materials.rubber]
type = "isotropic"
young = 1e6
poisson = 0.3
density = 1000.0
[[sections]]
material = "rubber"
thickness = 0.02
[[conditions]]
type = "clamp"
on = "u_min"
[[loads]]
type = "force"
on = "u_max_v_max"
value = [0.0, 0.0, 0.0]
[output]
pictures = false
"#;

/// Collects warnings, and asks to stop after a step.
#[derive(Default)]
struct Heard {
    messages: Vec<String>,
    step: u64,
    stops_after: Option<u64>,
}

impl JobObserver for Heard {
    fn on_step(&mut self, progress: &Progress) {
        self.step = progress.step;
    }
    fn on_warning(&mut self, message: &str) {
        self.messages.push(message.to_owned());
    }
    fn interrupted(&self) -> bool {
        self.stops_after == Some(self.step)
    }
}

#[test]
fn the_summary_lists_the_warnings_of_every_analysis() {
    let analyses = [
        "[analysis]\ntype = \"static\"\n",
        "[analysis]\ntype = \"modal\"\nmodes = 1\n",
        "[[steps]]\nname = \"load\"\nanalysis = { type = \"static\" }\n[[steps]]\nname = \"tones\"\nanalysis = { type = \"modal\", modes = 1 }\n",
    ];
    for analysis in analyses {
        let folder = tempfile::tempdir().unwrap();
        let deck = Deck::parse("model.toml", [analysis, WARNED].concat()).unwrap();
        let options = JobOptions { folder: folder.path().join("out"), resume: false, force: false };
        let mut heard = Heard::default();
        let summary = job::run(&deck, &options, &mut heard).unwrap();
        let Heard { mut messages, .. } = heard;
        messages.dedup();
        assert!(messages.iter().any(|message| message.contains("zero")), "{analysis}: {messages:?}");
        assert_eq!(summary.warnings, messages, "{analysis}");
        assert_eq!(Summary::read(&options.folder).unwrap().warnings, messages, "{analysis}");
    }
}

#[test]
fn the_summary_keeps_the_warnings_of_an_interrupted_run() {
    let text = format!("[analysis]\ntype = \"transient\"\nend_time = 0.1\ntime_step = 0.01\n{WARNED}");
    let folder = tempfile::tempdir().unwrap();
    let deck = Deck::parse("model.toml", text).unwrap();
    let mut options = JobOptions { folder: folder.path().join("out"), resume: false, force: false };
    let mut first = Heard { stops_after: Some(2), ..Heard::default() };
    job::run(&deck, &options, &mut first).unwrap_err();
    assert!(!first.messages.is_empty());
    assert_eq!(Summary::read(&options.folder).unwrap().warnings, first.messages);
    fs::remove_dir_all(options.folder.join("fields")).unwrap();
    options.resume = true;
    let mut second = Heard::default();
    let summary = job::run(&deck, &options, &mut second).unwrap();
    // The loss of the files is new; the warnings of the model are told again, but listed once.
    let new = second.messages.iter().filter(|message| !first.messages.contains(message)).cloned();
    assert_eq!(summary.warnings, [first.messages.clone(), new.collect()].concat());
    assert_eq!(summary.warnings.len(), first.messages.len() + 1);
}

const SHELL: &str = r#"
[analysis]
ANALYSIS
[mesh]
MESH
[materials.ply]
type = "orthotropic"
young = [25e9, 1e9, 1e9]
poisson = [0.25, 0.25, 0.25]
shear = [0.5e9, 0.5e9, 0.2e9]
density = 1500.0
strength = { xt = 500e6, xc = 350e6, yt = 5e6, yc = 75e6, s12 = 35e6 }
[materials.steel]
type = "isotropic"
young = 2e11
poisson = 0.3
density = 7800.0
[materials.metal]
type = "plastic"
young = 2e11
poisson = 0.3
density = 7800.0
yield_stress = 8e6
hardening = 1e9
[[sections]]
SECTION
[[conditions]]
type = "clamp"
on = "u_min"
[[loads]]
type = "edge"
on = "u_max"
value = [0.0, 30.0, -200.0]
[output]
points = [{ name = "corner", on = "u_max_v_max" }]
fields = ["displacement", "director", "velocity", "reaction", "membrane", "bending", "shear", "surface-stress",
    "von-mises", "energy-density", "ply-stress", "failure", "plastic-strain"]
interval = 1.0
pictures = false
"#;

const CYLINDER: &str = r#"type = "cylinder"
center = [0.1, 0.2, 1.3]
axis = [0.1, 1.0, 0.0]
start = [0.0, 0.0, -1.0]
radius = 1.0
angles = [0.0, -90.0]
length = 1.0
grid = { elements = [24, 19] }"#;

const PLATE: &str = r#"type = "plate"
origin = [0.1, 0.2, 1.3]
u_axis = [1.0, 0.3, 0.2]
v_axis = [-0.3, 1.0, 0.0]
size = [1.1, 0.7]
grid = { elements = [36, 36] }"#;

/// Elements of one shape share what follows from it. Which of them a thread meets first depends on the number of
/// threads; the results do not.
#[test]
#[ignore = "long"]
fn result_files_have_the_same_bits_for_any_number_of_threads() {
    let sheet = |element: &str, material: &str| {
        format!("element = \"{element}\"\nmaterial = \"{material}\"\nthickness = 0.01")
    };
    let laminate = |element: &str| {
        let layup = "{ stacking = \"[0/45/90]s\", material = \"ply\", ply_thickness = 0.002 }";
        format!("element = \"{element}\"\nlayup = {layup}")
    };
    let (statics, modal) = ("type = \"static\"", "type = \"modal\"\nmodes = 3");
    let linear = "type = \"static\"\nlinear = true";
    let transient =
        "type = \"transient\"\nend_time = 0.002\ntime_step = 0.001\nscheme = { type = \"newmark\" }";
    for (analysis, mesh, section) in [
        (statics, CYLINDER, sheet("ems", "steel")),
        (linear, PLATE, laminate("cm")),
        (transient, CYLINDER, sheet("solid-shell", "steel")),
        (transient, CYLINDER, sheet("cm", "metal")),
        (modal, CYLINDER, sheet("cm", "steel")),
    ] {
        let text = SHELL.replace("ANALYSIS", analysis).replace("MESH", mesh).replace("SECTION", &section);
        let mut first: Option<BTreeMap<String, Vec<u8>>> = None;
        for threads in [1, 2, 5] {
            let folder = tempfile::tempdir().unwrap();
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| run(&text, folder.path()));
            let found = files(folder.path());
            assert!(found.keys().any(|name| name.ends_with(".vtu")), "{:?}", found.keys());
            match &first {
                None => first = Some(found),
                Some(first) => {
                    assert_eq!(first.keys().collect::<Vec<_>>(), found.keys().collect::<Vec<_>>());
                    for (name, bytes) in &found {
                        assert!(first[name] == *bytes, "{name} differs with {threads} threads: {section}");
                    }
                }
            }
        }
    }
}

const CANTILEVER: &str = r#"
[analysis]
type = "static"
linear = true
[mesh]
type = "plate"
size = [2.0, 0.5]
grid = { elements = [8, 2] }
[materials.steel]
type = "isotropic"
young = 2.1e11
poisson = 0.3
density = 7850.0
[[sections]]
material = "steel"
thickness = 0.05
[[conditions]]
type = "clamp"
on = "u_min"
[[loads]]
type = "edge"
on = "u_max"
value = [0.0, 0.0, -300.0]
[output]
pictures = false
"#;

/// Force 150 down at the arm 2: the clamp takes 150 up and the moment −300 about y.
#[test]
fn reactions_are_in_history_summary_and_fields() {
    let folder = tempfile::tempdir().unwrap();
    let summary = run(CANTILEVER, folder.path());
    let near = |a: f64, b: f64| assert!((a - b).abs() <= 1e-6 * 300.0, "{a} for {b}");
    let clamp = &summary.supports["u_min"];
    [0.0, 0.0, 150.0].into_iter().zip(clamp.force).for_each(|(a, b)| near(b, a));
    [0.0, -300.0, 0.0].into_iter().zip(clamp.moment).for_each(|(a, b)| near(b, a));
    assert_eq!(clamp.about, [0.0, 0.25, 0.0]);
    near(summary.loads["edge.u_max"].force[2], -150.0);
    let balance = summary.balance.unwrap();
    assert!(balance.force <= 1e-9 && balance.moment <= 1e-9, "{balance:?}");

    let (names, rows) = csv::read(&folder.path().join("history.csv")).unwrap();
    let last = rows.last().unwrap();
    let column = |name: &str| last[names.iter().position(|n| n == name).unwrap()];
    near(column("support.u_min.fz"), 150.0);
    near(column("support.u_min.my"), -300.0);
    near(column("load.edge.u_max.fz"), -150.0);
    assert!(column("balance.force") <= 1e-9 && column("balance.moment") <= 1e-9);

    let vtu = fs::read_to_string(folder.path().join("fields/0001.vtu")).unwrap();
    for name in ["reaction", "reaction_moment"] {
        assert!(vtu.contains(&format!("Name=\"{name}\" NumberOfComponents=\"3\"")), "{name}");
    }
}

/// The mesh of a mode is the configuration about which it vibrates; a rigid mode has no stress.
#[test]
fn modes_of_a_free_plate_are_rigid_first() {
    let text = CANTILEVER
        .split("[[conditions]]")
        .next()
        .unwrap()
        .replace("type = \"static\"\nlinear = true", "type = \"modal\"\nmodes = 3")
        + "[output]\npictures = false\n";
    let folder = tempfile::tempdir().unwrap();
    let summary = run(&text, folder.path());
    assert_eq!(summary.frequencies_hz, Some(vec![0.0; 3]));
    assert_eq!(summary.sturm_checked, Some(true));
    let (names, rows) = csv::read(&folder.path().join("modes.csv")).unwrap();
    let rigid = names.iter().position(|n| n == "rigid").unwrap();
    assert!(rows.len() == 3 && rows.iter().all(|row| row[rigid] == 1.0));
}
