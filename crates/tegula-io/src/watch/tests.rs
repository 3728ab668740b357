//! Requests of clients that are friendly, hostile or slow.

use std::io::{Read as _, Write as _};
use std::net::TcpStream;

use serde_json::Value;

use super::*;
use crate::deck::Deck;
use crate::job::{self, JobOptions};

const PLATE: &str = r#"
    title = "Plate"
    [analysis]
    type = "transient"
    end_time = 0.2
    time_step = 0.01
    scheme = { type = "energy-momentum" }
    [mesh]
    type = "plate"
    size = [1.0, 0.5]
    [mesh.grid]
    elements = [4, 2]
    [materials.rubber]
    type = "isotropic"
    young = 2e7
    poisson = 0.3
    density = 500.0
    [[sections]]
    material = "rubber"
    thickness = 0.02
    [[conditions]]
    type = "spherical"
    on = "u_min"
    [[loads]]
    type = "gravity"
    value = [0.0, 0.0, -9.81]
    [output]
    points = [{ name = "tip", on = "u_max_v_max" }]
    pictures = false
"#;

/// Port and token of an address.
fn parts(page: &RunPage) -> (u16, String) {
    let url = page.url();
    let rest = url.strip_prefix("http://127.0.0.1:").unwrap();
    let (port, token) = rest.split_once('/').unwrap();
    (port.parse().unwrap(), token.trim_end_matches('/').into())
}

/// Answer to a request that is sent as it stands.
fn sent(port: u16, request: &str) -> Vec<u8> {
    let mut stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
    // The server may refuse a request before all of it is sent.
    let _ = stream.write_all(request.as_bytes());
    let mut answer = Vec::new();
    let _ = stream.read_to_end(&mut answer);
    answer
}

/// Status and content of an answer to a request with a method, a target and headers.
fn asked(port: u16, method: &str, target: &str, headers: &str) -> (u16, Vec<u8>) {
    let answer = sent(port, &format!("{method} {target} HTTP/1.1\r\n{headers}\r\n"));
    let end = answer.windows(4).position(|four| four == b"\r\n\r\n").unwrap();
    let head = String::from_utf8(answer[..end].to_vec()).unwrap();
    let code = head.split(' ').nth(1).unwrap().parse().unwrap();
    assert!(head.contains("Cache-Control: no-store") && head.contains("Connection: close"), "{head}");
    (code, answer[end + 4..].to_vec())
}

/// Status and content of an answer to the page.
fn got(page: &RunPage, name: &str) -> (u16, Vec<u8>) {
    let (port, token) = parts(page);
    asked(port, "GET", &format!("/{token}/{name}"), &format!("Host: 127.0.0.1:{port}\r\n"))
}

fn news(page: &RunPage, known: &str) -> Value {
    serde_json::from_slice(&got(page, &format!("news?{known}")).1).unwrap()
}

/// Runs the plate with a page.
fn run(page: &mut RunPage, model: &str) -> Result<Summary, JobError> {
    let folder = tempfile::tempdir().unwrap();
    let deck = Deck::parse("plate.toml", model).unwrap();
    let options = JobOptions { folder: folder.path().join("out"), resume: false, force: false };
    let outcome = job::run(&deck, &options, page);
    page.end(&outcome);
    outcome
}

fn singles(bytes: &[u8]) -> Vec<f32> {
    bytes.chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect()
}

fn words(bytes: &[u8]) -> Vec<u32> {
    bytes.chunks(4).map(|b| u32::from_le_bytes(b.try_into().unwrap())).collect()
}

#[test]
fn only_who_knows_the_token_gets_anything() {
    let page = RunPage::serve().unwrap();
    let (port, token) = parts(&page);
    assert_eq!(token.len(), 32);
    let host = format!("Host: 127.0.0.1:{port}\r\n");
    let wrong = format!("{}0", &token[..31]);
    let wrong = if wrong == token { format!("{}1", &token[..31]) } else { wrong };
    let upper = token.to_uppercase();
    for target in [
        "/".into(),
        "/news".into(),
        format!("/{token}"),
        format!("//{token}/"),
        format!("/{wrong}/"),
        format!("/{upper}x/"),
        format!("/{}/", &token[1..]),
        format!("/{token}{token}/"),
        format!("/{token}/../"),
        format!("/{token}/etc/passwd"),
        format!("/?{token}"),
        "/éééééééééééééééé/".into(),
        "/ééééééééééééééééé/".into(),
    ] {
        assert_eq!(asked(port, "GET", &target, &host), (404, Vec::new()), "{target}");
        assert_eq!(asked(port, "POST", &target, &host).0, 404, "{target}");
    }
    // Without the token a wrong host gets nothing else.
    assert_eq!(asked(port, "GET", "/", "Host: example.com\r\n"), (404, Vec::new()));
    let (code, html) = got(&page, "");
    let html = String::from_utf8(html).unwrap();
    assert!(code == 200 && html.contains("<button type=\"button\" id=\"stop\"") && !html.contains(&token));
    assert_eq!(asked(port, "HEAD", &format!("/{token}/"), &host), (405, Vec::new()));
    assert_eq!(asked(port, "GET", &format!("/{token}/stop"), &host), (405, Vec::new()));
    assert_ne!(page.url(), RunPage::serve().unwrap().url());
}

#[test]
fn pages_of_other_sites_are_refused() {
    let page = RunPage::serve().unwrap();
    let (port, token) = parts(&page);
    let target = |name: &str| format!("/{token}/{name}");
    let other = port ^ 1;
    for host in [
        String::new(),
        "Host: example.com\r\n".into(),
        "Host: 127.0.0.1\r\n".into(),
        format!("Host: 127.0.0.1:{other}\r\n"),
        format!("Host: example.com:{port}\r\n"),
        format!("Host: 127.0.0.1.example.com:{port}\r\n"),
    ] {
        for name in ["", "news", "mesh", "shape"] {
            assert_eq!(asked(port, "GET", &target(name), &host), (403, Vec::new()), "{host}");
        }
        let origin = format!("{host}Origin: http://127.0.0.1:{port}\r\n");
        assert_eq!(asked(port, "POST", &target("stop"), &origin), (403, Vec::new()), "{host}");
    }
    let host = format!("Host: localhost:{port}\r\n");
    assert_eq!(asked(port, "GET", &target("news"), &host).0, 200);
    for origin in [
        String::new(),
        "Origin: null\r\n".into(),
        "Origin: http://example.com\r\n".into(),
        format!("Origin: https://127.0.0.1:{port}\r\n"),
        format!("Origin: http://127.0.0.1:{other}\r\n"),
        format!("Origin: http://example.com:{port}\r\n"),
    ] {
        let headers = format!("{host}{origin}");
        assert_eq!(asked(port, "POST", &target("stop"), &headers), (403, Vec::new()), "{origin}");
    }
    assert!(!page.interrupted());
    let headers = format!("{host}Origin: http://localhost:{port}\r\nContent-Length: 0\r\n");
    assert_eq!(asked(port, "POST", &target("stop"), &headers), (204, Vec::new()));
    assert!(page.interrupted());
}

#[test]
fn requests_that_are_long_or_have_a_body_are_refused() {
    let page = RunPage::serve().unwrap();
    let (port, token) = parts(&page);
    let host = format!("Host: 127.0.0.1:{port}\r\n");
    let long = "a".repeat(9000);
    assert_eq!(asked(port, "GET", &format!("/{token}/{long}"), &host), (431, Vec::new()));
    assert_eq!(asked(port, "GET", "/", &format!("{host}Cookie: {long}\r\n")), (431, Vec::new()));
    let huge = "a".repeat(3 << 20);
    assert!(sent(port, &format!("GET / HTTP/1.1\r\nCookie: {huge}\r\n\r\n")).len() < 500);
    let body = format!("{host}Origin: http://127.0.0.1:{port}\r\nContent-Length: 100000\r\n");
    assert_eq!(asked(port, "POST", &format!("/{token}/stop"), &body), (413, Vec::new()));
    assert!(sent(port, "\x16\x03\x01\x02\x00\r\n\r\n").starts_with(b"HTTP/1.1 400 Bad Request\r\n"));
    assert!(!page.interrupted());
    assert_eq!(got(&page, "news").0, 200);
}

#[test]
fn silent_and_slow_clients_hold_up_nobody() {
    let page = RunPage::serve().unwrap();
    let (port, token) = parts(&page);
    let mut slow: Vec<TcpStream> =
        (0..20).map(|_| TcpStream::connect(("127.0.0.1", port)).unwrap()).collect();
    let begun = Instant::now();
    slow[0].write_all(format!("GET /{token}/ HTTP/1.1\r\n").as_bytes()).unwrap();
    for _ in 0..5 {
        assert_eq!(got(&page, "news").0, 200);
    }
    assert!(begun.elapsed() < Duration::from_secs(10), "{:?}", begun.elapsed());
    // One that sends a byte now and then has no more time than others.
    slow[0].set_read_timeout(Some(Duration::from_millis(100))).unwrap();
    let ended = loop {
        let _ = slow[0].write_all(b"a");
        match slow[0].read(&mut [0; 10]) {
            Ok(_) => break begun.elapsed(),
            Err(e) if matches!(e.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut) => {}
            Err(_) => break begun.elapsed(),
        }
        assert!(begun.elapsed() < Duration::from_secs(15));
    };
    assert!(ended > Duration::from_secs(1));
    // More than there is room for: the others are closed, and soon there is room again.
    let many: Vec<TcpStream> = (0..100).map(|_| TcpStream::connect(("127.0.0.1", port)).unwrap()).collect();
    let begun = Instant::now();
    loop {
        let answer = sent(port, &format!("GET /{token}/news HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n"));
        if answer.starts_with(b"HTTP/1.1 200 OK\r\n") {
            break;
        }
        assert!(begun.elapsed() < Duration::from_secs(15));
        std::thread::sleep(Duration::from_millis(50));
    }
    drop(many);
}

#[test]
fn clients_that_do_not_read_end_no_run() {
    let mut page = RunPage::serve().unwrap();
    let (port, token) = parts(&page);
    let request = format!("GET /{token}/ HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n");
    let deaf: Vec<TcpStream> = (0..5)
        .map(|_| {
            let mut stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
            stream.write_all(request.as_bytes()).unwrap();
            stream
        })
        .collect();
    drop(TcpStream::connect(("127.0.0.1", port)).unwrap());
    run(&mut page, PLATE).unwrap();
    assert_eq!(news(&page, "")["outcome"]["status"], "complete");
    drop(deaf);
}

#[test]
fn pages_show_the_last_state_of_a_run() {
    let mut page = RunPage::serve().unwrap();
    assert_eq!(news(&page, "part=0&row=0&message=0&shape=0")["part"], 0);
    assert!(got(&page, "mesh").1.is_empty() && got(&page, "shape").1.is_empty());
    let summary = run(&mut page, PLATE).unwrap();
    let first = news(&page, "");
    assert_eq!(first["heading"]["title"], "Plate");
    let columns: Vec<&str> =
        first["heading"]["columns"].as_array().unwrap().iter().map(|name| name.as_str().unwrap()).collect();
    assert_eq!(
        columns,
        [
            "time",
            "tip.ux",
            "tip.uy",
            "tip.uz",
            "kinetic",
            "strain",
            "dissipated",
            "total",
            "iterations",
            "step_size"
        ]
    );
    let rows = first["rows"].as_array().unwrap();
    let steps = summary.steps as usize;
    assert_eq!(rows.len(), columns.len() * (steps + 1));
    let last = &rows[columns.len() * steps..];
    let tip = summary.points["tip"].displacement;
    assert_eq!((last[0].as_f64(), last[3].as_f64()), (Some(summary.time), Some(tip[2])));
    assert_eq!(first["progress"][0], summary.steps as f64);
    let (mesh, shape) = (got(&page, "mesh").1, got(&page, "shape").1);
    assert_eq!(words(&mesh[..24]), [1, 1, 0, 15, 8, 0]);
    assert_eq!(mesh.len(), 24 + 4 * (3 * 15 + 4 * 8));
    let places = singles(&mesh[24..24 + 12 * 15]);
    let node = places.chunks(3).position(|x| x == [1.0, 0.5, 0.0]).unwrap();
    let number = first["shape"].as_u64().unwrap();
    assert_eq!(words(&shape[..8]), [1, number as u32]);
    let found = &singles(&shape[8..])[1 + 3 * node..][..3];
    assert_eq!(singles(&shape[8..])[0], summary.time as f32);
    assert_eq!(found, tip.map(|u| u as f32));
    assert_eq!(shape.len(), 4 * (3 + 3 * 15 + 8));
    // A client that has all of it lets the server end.
    let known = format!("part=1&row={}&message={}&shape={number}", first["row"], first["message"]);
    assert_eq!(first["whole"], false);
    assert_eq!(news(&page, &known)["whole"], true);
    let begun = Instant::now();
    page.close(|| false);
    assert!(begun.elapsed() < LAST_CALL - Duration::from_secs(1), "{:?}", begun.elapsed());
}

/// Under tension p on an edge of thickness h the stress is p/h everywhere.
#[test]
fn pages_show_the_stress_of_the_shells() {
    let mut page = RunPage::serve().unwrap();
    let pulled = PLATE
        .replace("type = \"transient\"", "type = \"static\"")
        .replace("end_time = 0.2", "")
        .replace("time_step = 0.01", "")
        .replace("scheme = { type = \"energy-momentum\" }", "")
        .replace("poisson = 0.3", "poisson = 0.0")
        .replace("type = \"spherical\"", "type = \"clamp\"")
        .replace("type = \"gravity\"", "type = \"edge\"\non = \"u_max\"")
        .replace("[0.0, 0.0, -9.81]", "[400.0, 0.0, 0.0]");
    run(&mut page, &pulled).unwrap();
    let shape = got(&page, "shape").1;
    let stresses = &singles(&shape[8..])[1 + 3 * 15..];
    assert_eq!(stresses.len(), 8);
    // The strain is 1e-3, and the stress per present area differs by that.
    assert!(stresses.iter().all(|s| (s / 2e4 - 1.0).abs() < 3e-3), "{stresses:?}");
}

#[test]
fn steps_are_shown_one_after_another_and_modes_without_history() {
    let (begin, end) = (PLATE.find("[analysis]").unwrap(), PLATE.find("[mesh]").unwrap());
    let steps = PLATE.replace(&PLATE[begin..end], "").replace("\"spherical\"", "\"clamp\"")
        + r#"
    [[steps]]
    name = "sag"
    analysis = { type = "static" }
    [[steps]]
    name = "modes"
    analysis = { type = "modal", modes = 3 }
    "#;
    let mut page = RunPage::serve().unwrap();
    run(&mut page, &steps).unwrap();
    let modal = news(&page, "part=1&row=1");
    assert_eq!((&modal["part"], &modal["shape"], &modal["row"]), (&2.into(), &0.into(), &0.into()));
    assert_eq!(modal["heading"]["columns"].as_array().unwrap().len(), 0);
    assert_eq!(modal["heading"]["title"], "Plate: step 2 of 2, modes");
    assert!(modal["outcome"]["text"].as_str().unwrap().starts_with("3 modes"), "{modal}");
    assert_eq!(words(&got(&page, "mesh").1)[..2], [2, 1]);
}

#[test]
fn two_clients_get_the_end_and_a_run_that_nobody_watches_waits_no_longer_than_its_time() {
    let mut page = RunPage::serve().unwrap();
    page.end(&Err(JobError::Interrupted { folder: "a".into(), resumable: true }));
    let url = parts(&page);
    let closing = std::thread::spawn(move || {
        let begun = Instant::now();
        page.close(|| false);
        begun.elapsed()
    });
    let asking = |_| {
        let (port, token) = url.clone();
        std::thread::spawn(move || {
            let headers = format!("Host: 127.0.0.1:{port}\r\n");
            asked(port, "GET", &format!("/{token}/news?part=0"), &headers)
        })
    };
    for client in [0, 1].map(asking) {
        let (code, body) = client.join().unwrap();
        let news: Value = serde_json::from_slice(&body).unwrap();
        assert_eq!(
            (code, &news["outcome"]["status"], &news["whole"]),
            (200, &"interrupted".into(), &true.into())
        );
    }
    assert!(closing.join().unwrap() < LAST_CALL);
    let mut lonely = RunPage::serve().unwrap();
    lonely.end(&Err(JobError::Interrupted { folder: "a".into(), resumable: true }));
    let begun = Instant::now();
    lonely.close(|| begun.elapsed() > Duration::from_millis(300));
    assert!(begun.elapsed() < Duration::from_secs(2));
}

#[test]
fn the_button_stops_a_run() {
    let mut page = RunPage::serve().unwrap();
    let (port, token) = parts(&page);
    let endless = PLATE.replace("end_time = 0.2", "end_time = 1e6");
    let client = std::thread::spawn(move || {
        let host = format!("Host: 127.0.0.1:{port}\r\n");
        let begun = Instant::now();
        // Once some steps are there.
        loop {
            let (_, body) = asked(port, "GET", &format!("/{token}/news?part=1"), &host);
            let news: Value = serde_json::from_slice(&body).unwrap();
            if news["row"].as_u64() > Some(3) && news["shape"].as_u64() > Some(1) {
                break;
            }
            assert!(begun.elapsed() < Duration::from_secs(60));
            std::thread::sleep(Duration::from_millis(50));
        }
        asked(port, "POST", &format!("/{token}/stop"), &format!("{host}Origin: http://127.0.0.1:{port}\r\n"))
            .0
    });
    let outcome = run(&mut page, &endless);
    assert!(matches!(outcome, Err(JobError::Interrupted { resumable: true, .. })));
    assert_eq!(client.join().unwrap(), 204);
    assert_eq!(news(&page, "")["outcome"]["status"], "interrupted");
}
