//! `tegula render`

use std::fs;
use std::path::Path;

use crate::{changed, errors, example, tegula, text};

/// Results of the modes of a small plate.
fn modes(folder: &Path) -> std::path::PathBuf {
    let changes = [("elements = [32, 32]", "elements = [4, 4]"), ("modes = 16", "modes = 8")];
    let model = changed(folder, "free_plate_modes.toml", &changes);
    let result = folder.join("modes");
    let run = tegula(&["run", text(&model), "--out", text(&result), "--quiet"]);
    assert!(run.status.success(), "{}", errors(&run));
    result
}

/// Width and height in the header of a PNG file.
fn size(png: &[u8]) -> [u32; 2] {
    assert!(png.starts_with(b"\x89PNG\r\n\x1a\n"));
    [16, 20].map(|at| u32::from_be_bytes(png[at..at + 4].try_into().unwrap()))
}

#[test]
#[ignore = "long"]
fn pictures_show_the_field_and_the_state_that_are_wanted() {
    let folder = tempfile::tempdir().unwrap();
    let result = folder.path().join("tank");
    let run = tegula(&["run", text(&example("water_tank.toml")), "--out", text(&result), "--quiet"]);
    assert!(run.status.success(), "{}", errors(&run));
    let drawn = |name: &str, options: &[&str]| {
        let file = folder.path().join(name);
        let arguments =
            [&["render", text(&result), "--out", text(&file), "--size", "320,240"], options].concat();
        let output = tegula(&arguments);
        assert!(output.status.success(), "{}", errors(&output));
        let picture = fs::read(&file).unwrap();
        assert_eq!(size(&picture), [320, 240]);
        picture
    };
    let stress = drawn("a.png", &[]);
    assert_eq!(drawn("b.png", &["--field", "von_mises"]), stress);
    let others: [&[&str]; 6] = [
        &["--field", "none"],
        &["--field", "displacement"],
        &["--field", "displacement.z"],
        &["--field", "stress_top.1"],
        &["--view", "-120,60"],
        &["--range", "-1e6,1e6"],
    ];
    let pictures: Vec<_> = others.iter().map(|options| drawn("c.png", options)).collect();
    for (i, picture) in pictures.iter().enumerate() {
        assert!(*picture != stress && pictures[..i].iter().all(|other| other != picture), "{:?}", others[i]);
    }
    // Without a name the picture lies in the result folder, with the usual size.
    assert!(tegula(&["render", text(&result)]).status.success());
    assert_eq!(size(&fs::read(result.join("render.png")).unwrap()), [1200, 800]);
}

#[test]
fn films_of_modes_have_a_period_and_repeat() {
    let folder = tempfile::tempdir().unwrap();
    let (result, film) = (modes(folder.path()), folder.path().join("mode.gif"));
    let output = tegula(&[
        "render",
        text(&result),
        "--mode",
        "7",
        "--out",
        text(&film),
        "--size",
        "240,200",
        "--fps",
        "24",
    ]);
    assert!(output.status.success(), "{}", errors(&output));
    assert!(String::from_utf8(output.stdout).unwrap().ends_with("mode.gif (48 frames)\n"));
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut decoder = options.read_info(fs::File::open(&film).unwrap()).unwrap();
    let (mut frames, mut delays) = (Vec::new(), 0);
    while let Some(frame) = decoder.read_next_frame().unwrap() {
        assert_eq!((frame.width, frame.height), (240, 200));
        frames.push(frame.buffer.to_vec());
        delays += u32::from(frame.delay);
    }
    assert_eq!((frames.len(), delays), (48, 200));
    assert_eq!(decoder.repeat(), gif::Repeat::Infinite);
    // At its quarters the shape is flat.
    assert!(frames[0] != frames[12] && frames[0] != frames[24] && frames[12] == frames[36]);
}

#[cfg(unix)]
#[test]
fn films_in_mp4_are_encoded_by_ffmpeg() {
    use std::os::unix::fs::PermissionsExt as _;
    use std::process::Command;

    let folder = tempfile::tempdir().unwrap();
    let (result, film) = (modes(folder.path()), folder.path().join("mode.mp4"));
    let with_path = |path: &Path, size: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_tegula"));
        command.args(["render", text(&result), "--mode", "7", "--out", text(&film), "--size", size]);
        command.env("PATH", path).output().unwrap()
    };
    let none = folder.path().join("none");
    fs::create_dir(&none).unwrap();
    let output = with_path(&none, "240,200");
    assert_eq!(output.status.code(), Some(1));
    assert!(
        errors(&output).contains("`ffmpeg` cannot be started") && errors(&output).contains(".gif"),
        "{}",
        errors(&output)
    );
    // A program that counts what it gets, in place of the encoder.
    let counter = none.join("ffmpeg");
    let script = "#!/bin/sh\nfor last; do :; done\n/usr/bin/wc -c > \"$last\"\n";
    fs::write(&counter, script).unwrap();
    fs::set_permissions(&counter, fs::Permissions::from_mode(0o755)).unwrap();
    let output = with_path(&none, "240,200");
    assert!(output.status.success(), "{}", errors(&output));
    let counted: u32 = fs::read_to_string(&film).unwrap().trim().parse().unwrap();
    assert_eq!(counted, 48 * 240 * 200 * 3);
    fs::remove_file(&film).unwrap();
    // One that fails leaves no file.
    fs::write(&counter, "#!/bin/sh\n/bin/cat > /dev/null\necho unknown encoder >&2\nexit 1\n").unwrap();
    let output = with_path(&none, "240,200");
    assert!(errors(&output).contains("`ffmpeg` failed: unknown encoder"), "{}", errors(&output));
    assert!(
        !film.exists()
            && fs::read_dir(folder.path()).unwrap().all(|e| e
                .unwrap()
                .path()
                .extension()
                .is_none_or(|e| e != "mp4"))
    );
    let output = with_path(&none, "241,200");
    assert!(errors(&output).contains("even numbers of pixels"), "{}", errors(&output));
}

#[test]
fn what_cannot_be_drawn_is_refused_in_words() {
    let folder = tempfile::tempdir().unwrap();
    let result = modes(folder.path());
    let file = folder.path().join("a.png");
    for (options, message) in [
        (&["--field", "stress"] as &[&str], "it has no field `stress`. It has the fields "),
        (&["--field", "displacement.w"], "has no component `w`"),
        (&["--mode", "9"], "no files of mode 9, but of 8 modes"),
        (&["--size", "10,10"], "give 200 to 4096 pixels"),
        (&["--range", "2,1"], "the first value must be below the second"),
        (&["--at", "0.5"], "modes have no time"),
        (&["--scale", "inf"], "--scale inf: give a finite number"),
    ] {
        let output = tegula(&[&["render", text(&result), "--out", text(&file)], options].concat());
        assert!(
            !output.status.success() && errors(&output).contains(message),
            "{options:?}: {}",
            errors(&output)
        );
        assert!(!file.exists());
    }
    for (name, message) in
        [("a.pdf", "give .png, .svg, .gif or .mp4"), ("a", "give .png, .svg, .gif or .mp4")]
    {
        let output = tegula(&["render", text(&result), "--out", text(&folder.path().join(name))]);
        assert!(errors(&output).contains(message), "{}", errors(&output));
    }
    let film = folder.path().join("a.gif");
    let output = tegula(&["render", text(&result), "--out", text(&film), "--fps", "0"]);
    assert!(errors(&output).contains("--fps 0: give more than 0") && !film.exists(), "{}", errors(&output));
    assert_eq!(tegula(&["render", text(folder.path())]).status.code(), Some(1));
}

#[test]
fn vector_graphics_have_the_letters_of_the_picture() {
    let folder = tempfile::tempdir().unwrap();
    let (result, file) = (modes(folder.path()), folder.path().join("a.svg"));
    let output = tegula(&["render", text(&result), "--mode", "7", "--size", "600,400", "--out", text(&file)]);
    assert!(output.status.success(), "{}", errors(&output));
    let drawn = fs::read_to_string(&file).unwrap();
    assert!(drawn.contains("width=\"600\" height=\"400\" viewBox=\"0 0 600 400\""));
    assert!(
        drawn.contains("mode 7") && drawn.contains(">x</text>") && drawn.contains("data:image/png;base64,")
    );
}

#[test]
fn bodies_alone_are_drawn_in_one_colour() {
    let folder = tempfile::tempdir().unwrap();
    let model = changed(folder.path(), "slider_crank.toml", &[("end_time = 5.0", "end_time = 0.1")]);
    let result = folder.path().join("crank");
    let run = tegula(&["run", text(&model), "--out", text(&result), "--quiet"]);
    assert!(run.status.success(), "{}", errors(&run));
    let file = folder.path().join("a.png");
    let output = tegula(&["render", text(&result), "--out", text(&file)]);
    assert!(output.status.success(), "{}", errors(&output));
    assert!(size(&fs::read(&file).unwrap()) == [1200, 800]);
    let output = tegula(&["render", text(&result), "--field", "velocity", "--out", text(&file)]);
    assert!(errors(&output).contains("bodies alone have one colour"), "{}", errors(&output));
    let output =
        tegula(&["render", text(&result), "--at", "0.05", "--out", text(&folder.path().join("a.gif"))]);
    assert_eq!(output.status.code(), Some(2), "{}", errors(&output));
}
