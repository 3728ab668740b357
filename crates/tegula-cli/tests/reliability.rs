//! The program under bad conditions: closed and full outputs, limits, signals, pipes, thousands of mistakes.
#![cfg(target_os = "linux")]
#![allow(missing_docs, clippy::unwrap_used)]

use std::fs::{self, File, OpenOptions};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

const PLATE: &str = "title = \"TITLE\"\n[analysis]\ntype = \"static\"\n[mesh]\ntype = \"plate\"\nsize = [1.0, 1.0]\n\
    [mesh.grid]\nelements = [3, 3]\n[materials.m]\ntype = \"isotropic\"\nyoung = 2e8\npoisson = 0.3\n[[sections]]\n\
    material = \"m\"\nthickness = 0.01\n[[conditions]]\ntype = \"clamp\"\non = \"u_min\"\n[[loads]]\n\
    type = \"pressure\"\nvalue = 1.0\n[output]\npoints = [{ name = \"tip\", on = \"u_max_v_max\" }]\n";

fn program() -> Command {
    Command::new(env!("CARGO_BIN_EXE_tegula"))
}

/// The program behind a shell's preparations.
fn after(preparation: &str, arguments: &[&str]) -> Command {
    let mut shell = Command::new("sh");
    shell
        .args(["-c", &format!("{preparation}; exec \"$0\" \"$@\""), env!("CARGO_BIN_EXE_tegula")])
        .args(arguments);
    shell
}

fn write(folder: &Path, text: &str) -> PathBuf {
    let path = folder.join("model.toml");
    fs::write(&path, text).unwrap();
    path
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn errors(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

fn printed(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn summary(folder: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(folder.join("summary.json")).unwrap()).unwrap()
}

#[test]
#[ignore = "long"]
fn a_closed_or_full_standard_error_does_not_end_a_run() {
    let folder = tempfile::tempdir().unwrap();
    let model = write(folder.path(), PLATE);
    let out = folder.path().join("out");
    let full = || OpenOptions::new().write(true).open("/dev/full").unwrap();
    let run = || {
        let mut command = program();
        command.args(["run", text(&model), "--out", text(&out), "--verbose"]).stdout(Stdio::null());
        command
    };
    let mut closed = run().stderr(Stdio::piped()).spawn().unwrap();
    drop(closed.stderr.take());
    assert_eq!(closed.wait().unwrap().code(), Some(0));
    assert_eq!(summary(&out)["status"], "complete");
    assert_eq!(run().stderr(full()).status().unwrap().code(), Some(0));
    // Errors keep their exit codes.
    let missing = program().args(["run", "nowhere.toml"]).stderr(full()).status().unwrap();
    assert_eq!(missing.code(), Some(1));
    // Output that somebody waits for is either whole or an error.
    let schema = program().arg("schema").stdout(full()).output().unwrap();
    assert_eq!(schema.status.code(), Some(1));
    assert!(errors(&schema).contains("cannot write to standard output"), "{}", errors(&schema));
}

#[test]
fn a_mesh_beyond_the_memory_is_refused_beside_other_mistakes() {
    let folder = tempfile::tempdir().unwrap();
    let text_of = PLATE.replace("[3, 3]", "[50000, 50000]").replace("value = 1.0", "valu = 1.0");
    let model = write(folder.path(), &text_of);
    // Far below what such a mesh takes; enough for the program.
    let output = after("ulimit -v 4000000", &["check", text(&model)]).output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", errors(&output));
    let said = errors(&output);
    assert!(
        said.contains("unknown key \"valu\"") && said.contains("50000 x 50000 elements need more"),
        "{said}"
    );
}

#[test]
fn limits_of_the_process_count_as_memory() {
    let folder = tempfile::tempdir().unwrap();
    let model = write(folder.path(), &PLATE.replace("[3, 3]", "[400, 400]"));
    let output = after("ulimit -v 3000000", &["check", text(&model)]).output().unwrap();
    let said = errors(&output);
    assert!(output.status.code() == Some(1) && said.contains("ulimit -v"), "{said}");
}

#[test]
fn thousands_of_mistakes_are_reported_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let loads = "[[loads]]\ntype = \"pressure\"\nvalue = 1.0\nvalu = 2.0\n".repeat(20_000);
    let begun = Instant::now();
    let check = |text_of: &str| {
        let model = write(folder.path(), text_of);
        let output = program().args(["check", text(&model)]).output().unwrap();
        assert_eq!(output.status.code(), Some(1));
        errors(&output)
    };
    let said = check(&format!("{PLATE}{loads}"));
    assert_eq!(said.matches("error: ").count(), 101);
    assert!(said.contains("19900 more mistakes are not shown") && said.ends_with("20000 errors\n"), "{said}");
    // Mistakes of meaning instead of form, and of syntax.
    let said = check(&format!("{PLATE}{}", loads.replace("valu = 2.0", "amplitude = \"none\"")));
    assert!(said.ends_with("20000 errors\n"), "{said}");
    let said = check(&format!("{PLATE}{}", "a = \n".repeat(20_000)));
    assert!(said.matches("error: ").count() <= 101);
    // It took over a minute to report the first of these.
    assert!(begun.elapsed() < Duration::from_secs(40), "{:?}", begun.elapsed());
}

#[test]
fn towers_of_powers_do_not_fill_the_memory() {
    let folder = tempfile::tempdir().unwrap();
    let tower = format!(
        "{}[amplitudes.a]\ntype = \"expression\"\nexpression = \"{}\"\n",
        PLATE.replace("value = 1.0", "value = 1.0\namplitude = \"a\""),
        ["t"; 71].join("^")
    );
    let (model, out) = (write(folder.path(), &tower), folder.path().join("out"));
    let run = after("ulimit -v 4000000", &["run", text(&model), "--out", text(&out), "-q"]).output().unwrap();
    assert!(run.status.success(), "{}", errors(&run));
}

/// A transient run long enough to be stopped.
fn pendulum(folder: &Path, end: &str) -> PathBuf {
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/quarter_cylinder_pendulum.toml");
    let text = fs::read_to_string(example).unwrap();
    write(folder, &text.replace("[16, 16]", "[8, 8]").replace("end_time = 1.5", end))
}

fn wait_for_rows(out: &Path, rows: usize) {
    let begun = Instant::now();
    let there = || fs::read_to_string(out.join("history.csv")).map_or(0, |h| h.lines().count());
    while there() < rows && begun.elapsed() < Duration::from_secs(120) {
        std::thread::sleep(Duration::from_millis(2));
    }
    assert!(there() >= rows, "the run did not begin");
}

#[test]
#[ignore = "long"]
fn a_terminated_run_can_be_resumed() {
    let folder = tempfile::tempdir().unwrap();
    let model = pendulum(folder.path(), "end_time = 0.9");
    for signal in ["-TERM", "-HUP"] {
        let out = folder.path().join(signal);
        let mut child =
            after("trap - HUP", &["run", text(&model), "--out", text(&out), "-q"]).spawn().unwrap();
        wait_for_rows(&out, 5);
        assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
        assert_eq!(child.wait().unwrap().code(), Some(130), "{signal}");
        assert_eq!(summary(&out)["status"], "interrupted");
    }
}

#[test]
#[ignore = "long"]
fn under_nohup_a_run_outlives_its_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let (model, out) = (pendulum(folder.path(), "end_time = 0.1"), folder.path().join("out"));
    let mut child = after("trap '' HUP", &["run", text(&model), "--out", text(&out), "-q"]).spawn().unwrap();
    wait_for_rows(&out, 3);
    assert!(Command::new("kill").args(["-HUP", &child.id().to_string()]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(0));
    assert_eq!(summary(&out)["status"], "complete");
}

#[test]
fn a_failed_write_is_the_end_that_the_summary_tells() {
    let folder = tempfile::tempdir().unwrap();
    let (model, out) =
        (write(folder.path(), &PLATE.replace("[3, 3]", "[60, 60]")), folder.path().join("out"));
    // Files of more than 16 blocks cannot be written: those with the fields.
    let limits = "trap '' XFSZ; ulimit -f 16";
    let run = after(limits, &["run", text(&model), "--out", text(&out), "-q"]).output().unwrap();
    assert_eq!(run.status.code(), Some(1), "{}", errors(&run));
    let s = summary(&out);
    assert!(s["status"] == "failed" && s["error"].as_str().unwrap().contains("cannot write"), "{s}");
}

#[test]
fn names_cannot_steer_the_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let hostile = PLATE.replace("TITLE", "\\u001b]0;gone\\u0007\\u001b[2J");
    let out = folder.path().join("out");
    let model = write(folder.path(), &hostile);
    let run = program().args(["run", text(&model), "--out", text(&out)]).output().unwrap();
    let check = program().args(["check", text(&model)]).output().unwrap();
    let model = write(folder.path(), &hostile.replace("on = \"u_min\"", "on = \"\\u001b[31mu\""));
    let wrong = program().args(["check", text(&model)]).output().unwrap();
    let log = fs::read(out.join("log.txt")).unwrap();
    assert!(run.status.success() && check.status.success() && !wrong.status.success());
    for bytes in [&run.stdout, &run.stderr, &check.stdout, &wrong.stderr, &log] {
        assert!(!bytes.iter().any(|&b| b < 0x20 && b != b'\n' && b != b'\t'), "{bytes:?}");
    }
    assert!(errors(&wrong).contains("\\u{1b}[31mu"), "{}", errors(&wrong));
}

#[test]
fn more_threads_than_make_sense_are_not_started() {
    let folder = tempfile::tempdir().unwrap();
    let (model, out) = (write(folder.path(), PLATE), folder.path().join("out"));
    let run = program().args(["run", text(&model), "--out", text(&out), "-j", "60000"]).output().unwrap();
    assert!(run.status.success() && errors(&run).contains("instead of 60000"), "{}", errors(&run));
    assert!(summary(&out)["threads"].as_u64().unwrap() < 1000);
}

#[test]
#[ignore = "long"]
fn a_model_may_come_through_a_pipe() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let through = |path: &str, model: &str, more: &[&str]| {
        let mut child = program()
            .args(["run", path, "-o", text(&out), "-q"])
            .args(more)
            .stdin(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        child.stdin.take().unwrap().write_all(model.as_bytes()).unwrap();
        child.wait_with_output().unwrap()
    };
    for path in ["-", "/dev/stdin"] {
        assert!(through(path, PLATE, &["--force"]).status.success(), "{path}");
        // The line is shown, though the pipe cannot be read again.
        let wrong = through(path, &PLATE.replace("thickness", "tickness"), &[]);
        assert!(
            wrong.status.code() == Some(1) && errors(&wrong).contains("| tickness = 0.01"),
            "{}",
            errors(&wrong)
        );
        // Another model through the same pipe does not replace the results of the first one.
        let other = through(path, &PLATE.replace("young = 2e8", "young = 3e8"), &[]);
        assert!(other.status.code() == Some(1) && errors(&other).contains("--force"), "{}", errors(&other));
    }
    assert_eq!(summary(&out)["model"], "/dev/stdin");
    assert!(through("-", PLATE, &[]).status.success() && summary(&out)["model"] == "<stdin>");
}

#[test]
fn json_is_printed_for_programs() {
    let folder = tempfile::tempdir().unwrap();
    let (model, out) = (write(folder.path(), PLATE), folder.path().join("out"));
    let json = |arguments: &[&str]| -> (Option<i32>, Value) {
        let output = program().args(arguments).stderr(Stdio::null()).output().unwrap();
        (output.status.code(), serde_json::from_str(&printed(&output)).unwrap())
    };
    let (code, checked) = json(&["check", text(&model), "--json"]);
    assert!(code == Some(0) && checked["elements"] == 9 && checked["status"] == "ok", "{checked}");
    let (code, ran) = json(&["run", text(&model), "--out", text(&out), "--json"]);
    assert!(code == Some(0) && ran["status"] == "complete" && ran["points"]["tip"].is_object(), "{ran}");
    let (_, told) = json(&["info", text(&out), "--json"]);
    assert_eq!(told, summary(&out));
    assert!(json(&["info", "--json"]).1["threads"].as_u64().unwrap() > 0);
    let wrong = write(folder.path(), &PLATE.replace("thickness", "tickness"));
    let (code, failed) = json(&["run", text(&wrong), "--out", text(&out), "--json"]);
    assert_eq!((code, &failed["exit_code"]), (Some(1), &Value::from(1)));
    let first = &failed["errors"][0];
    assert!(first["line"] == 15 && first["key"] == "sections[0].tickness", "{failed}");
    let (code, missing) = json(&["check", "nowhere.toml", "--json"]);
    assert!(code == Some(1) && missing["errors"][0]["message"] == "there is no such file", "{missing}");
}

#[test]
#[ignore = "long"]
fn progress_speaks_of_load_factors_and_times() {
    let folder = tempfile::tempdir().unwrap();
    let (model, out) = (write(folder.path(), PLATE), folder.path().join("out"));
    let run = program().args(["run", text(&model), "-o", text(&out), "-v"]).output().unwrap();
    let said = errors(&run);
    assert!(said.contains("step 1: load factor 1, increment 1, ") && !said.contains(" t "), "{said}");
    assert!(printed(&run).contains("complete: 1 step, "), "{}", printed(&run));
    let model = pendulum(folder.path(), "end_time = 0.05");
    let run = program().args(["run", text(&model), "-o", text(&folder.path().join("swing")), "-v"]).output();
    assert!(errors(&run.unwrap()).contains("step 1: time "));
}

#[test]
fn shells_get_their_completions() {
    for (shell, part) in [("bash", "_tegula"), ("zsh", "#compdef tegula"), ("fish", "complete -c tegula")] {
        let output = program().args(["completions", shell]).output().unwrap();
        let script = printed(&output);
        assert!(output.status.success() && script.contains(part) && script.contains("resume"), "{shell}");
    }
}

#[test]
fn each_command_has_a_manual_page() {
    let folder = tempfile::tempdir().unwrap();
    let pages = folder.path().join("share/man1");
    let output = program().args(["man", text(&pages)]).output().unwrap();
    assert!(output.status.success(), "{}", errors(&output));
    for (page, part) in
        [("tegula.1", "Exit codes"), ("tegula-run.1", "resume"), ("tegula-render.1", "RESULT")]
    {
        let page = fs::read_to_string(pages.join(page)).unwrap();
        assert!(page.starts_with(".") && page.contains(".TH") && page.contains(part), "{page}");
    }
    let file = folder.path().join("file");
    fs::write(&file, "").unwrap();
    let refused = program().args(["man", text(&file)]).output().unwrap();
    assert_eq!(refused.status.code(), Some(1));
    assert!(errors(&refused).contains("the manual pages cannot be written to"), "{}", errors(&refused));
}

#[test]
fn new_models_name_the_schema_that_lies_beside_them() {
    let folder = tempfile::tempdir().unwrap();
    let new = |name: &str| {
        let run = program().args(["new", "static", name]).current_dir(folder.path()).output().unwrap();
        assert!(run.status.success(), "{}", errors(&run));
    };
    new("a.toml");
    let model = fs::read_to_string(folder.path().join("a.toml")).unwrap();
    let file = model.lines().next().unwrap().strip_prefix("#:schema ./").unwrap();
    let schema = folder.path().join(file);
    let printed = printed(&program().arg("schema").output().unwrap());
    assert_eq!(fs::read_to_string(&schema).unwrap(), printed);
    // An older one is renewed, that of somebody else is left alone.
    fs::write(&schema, "{\"title\": \"tegula model\"}").unwrap();
    new("b.toml");
    assert_eq!(fs::read_to_string(&schema).unwrap(), printed);
    fs::write(&schema, "my notes").unwrap();
    new("c.toml");
    assert_eq!(fs::read_to_string(&schema).unwrap(), "my notes");
    assert!(File::open(folder.path().join("c.toml")).is_ok());
}
