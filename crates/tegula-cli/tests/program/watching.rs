//! `tegula run --watch`.

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::{changed, errors, summary, tegula, text};

/// A run with a page, its port and the path of the page.
struct Run {
    child: Child,
    port: u16,
    path: String,
}

impl Run {
    fn start(model: &Path, out: &Path) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_tegula"))
            .args(["run", text(model), "--out", text(out), "--watch", "--quiet"])
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut line = String::new();
        BufReader::new(child.stderr.as_mut().unwrap()).read_line(&mut line).unwrap();
        let (_, rest) = line.trim_end().split_once("http://127.0.0.1:").unwrap();
        let (port, path) = rest.split_at(rest.find('/').unwrap());
        Self { port: port.parse().unwrap(), path: path.into(), child }
    }

    /// Answer to a request for content of the page.
    fn ask(&self, method: &str, name: &str) -> String {
        let (port, path) = (self.port, &self.path);
        let mut stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        let host = format!("127.0.0.1:{port}");
        write!(stream, "{method} {path}{name} HTTP/1.1\r\nHost: {host}\r\nOrigin: http://{host}\r\n\r\n")
            .unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        answer
    }

    fn news(&self, known: &str) -> Value {
        let answer = self.ask("GET", &format!("news?{known}"));
        serde_json::from_str(answer.split_once("\r\n\r\n").unwrap().1).unwrap()
    }
}

/// It would swing for hours.
#[test]
fn the_button_ends_a_run_as_an_interrupt_does() {
    let folder = tempfile::tempdir().unwrap();
    let changes = [
        ("[16, 16]", "[4, 4]"),
        ("end_time = 1.5", "end_time = 9999.0"),
        ("interval = ", "interval = 9999.0 # "),
    ];
    let model = changed(folder.path(), "quarter_cylinder_pendulum.toml", &changes);
    let out = folder.path().join("out");
    let run = Run::start(&model, &out);
    let begun = Instant::now();
    while run.news("part=1")["row"].as_u64() < Some(3) {
        assert!(begun.elapsed() < Duration::from_secs(60));
        std::thread::sleep(Duration::from_millis(20));
    }
    assert!(run.ask("POST", "stop").starts_with("HTTP/1.1 204 "));
    let output = run.child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130), "{}", errors(&output));
    assert!(errors(&output).contains("--resume restarts from there"), "{}", errors(&output));
    let s = summary(&out);
    assert_eq!(s["status"], "interrupted");
    assert!(s["steps"].as_u64() >= Some(2) && s["time"].as_f64() < Some(9999.0), "{s}");
}

#[test]
fn pages_show_runs_that_fail_and_the_program_ends_when_that_is_fetched() {
    let folder = tempfile::tempdir().unwrap();
    let hasty = "type = \"static\"\nmax_iterations = 2\nmax_cutbacks = 1";
    let changes = [("type = \"static\"", hasty), ("[32, 32]", "[8, 8]")];
    let model = changed(folder.path(), "quarter_cylinder_static.toml", &changes);
    let run = Run::start(&model, &folder.path().join("out"));
    let begun = Instant::now();
    let mut news = run.news("");
    while news["outcome"].is_null() {
        assert!(begun.elapsed() < Duration::from_secs(60));
        std::thread::sleep(Duration::from_millis(20));
        news = run.news("");
    }
    assert_eq!(news["outcome"]["status"], "failed");
    assert!(news["outcome"]["text"].as_str().unwrap().contains("no equilibrium"), "{news}");
    let [part, row, message, shape] = ["part", "row", "message", "shape"].map(|name| &news[name]);
    let known = format!("part={part}&row={row}&message={message}&shape={shape}");
    assert_eq!(run.news(&known)["whole"], true);
    let fetched = Instant::now();
    assert_eq!(run.child.wait_with_output().unwrap().status.code(), Some(3));
    assert!(fetched.elapsed() < Duration::from_secs(4), "{:?}", fetched.elapsed());
}

#[test]
fn wrong_models_have_no_page() {
    let folder = tempfile::tempdir().unwrap();
    let model =
        changed(folder.path(), "quarter_cylinder_static.toml", &[("type = \"static\"", "type = \"x\"")]);
    let output = tegula(&["run", text(&model), "--watch"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(!errors(&output).contains("http://"));
}
