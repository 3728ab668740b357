//! Runs that end at a stop condition: summary, warnings, later steps, resuming.

use std::f64::consts::PI;
use std::fs;
use std::path::Path;

use super::super::*;
use super::{SWING, Warnings, options, stop_after};
use crate::deck::Deck;
use crate::out::csv;

/// A wheel that a moment turns from rest to 90°, and that turns on without it.
const SPIN_UP: &str = r#"
    [[bodies]]
    name = "wheel"
    at = [0, 0, 0]
    mass = 1.0
    inertia = [0.3, 0.3, 0.5]
    [[joints]]
    type = "revolute"
    name = "hinge"
    between = ["ground", "wheel"]
    at = [0, 0, 0]
    axis = [0, 0, 1]
    [[sensors]]
    type = "angle"
    name = "turns"
    between = ["ground", "wheel"]
    axis = [0, 0, 1]
    [[sensors]]
    type = "reaction"
    name = "bearing"
    joint = "hinge"
    [output]
    pictures = false
    [[steps]]
    name = "spin-up"
    [[steps.loads]]
    type = "moment"
    on = "wheel"
    value = [0, 0, 0.4]
    [steps.analysis]
    type = "transient"
    end_time = 10.0
    time_step = 0.01
    scheme = { type = "energy-momentum" }
    stop = [{ column = "sensor.turns.angle", value = 90.0, direction = "rising" }]
    [[steps]]
    name = "coast"
    [steps.analysis]
    type = "transient"
    end_time = 10.0
    time_step = 0.01
    scheme = { type = "energy-momentum" }
    stop = [{ column = "sensor.turns.angle", value = 600.0 }, { column = "body.wheel.wz", value = 99.0 }]
"#;

fn value(folder: &Path, row: usize, column: &str) -> f64 {
    let (names, rows) = csv::read(&folder.join("history.csv")).unwrap();
    rows[row.min(rows.len() - 1)][names.iter().position(|n| n == column).unwrap()]
}

/// The spin-up takes √(2·½π·J/M), and the coast from 90° to 600° the rest at its last rate.
#[test]
fn the_next_step_continues_where_a_condition_has_ended_the_one_before() {
    let folder = tempfile::tempdir().unwrap();
    let deck = Deck::parse("m.toml", SPIN_UP).unwrap();
    let straight = folder.path().join("straight");
    let whole = run(&deck, &options(&straight, false), &mut Unwatched).unwrap();
    let rate = 0.4 / 0.5 * (PI * 0.5 / 0.4_f64).sqrt();
    for (i, (part, time)) in
        [("1-spin-up", (PI * 0.5 / 0.4_f64).sqrt()), ("2-coast", 510_f64.to_radians() / rate)]
            .into_iter()
            .enumerate()
    {
        let summary = Summary::read(&straight.join(part)).unwrap();
        assert!((summary.time - time).abs() < 2e-4 * time, "{part} {} {time}", summary.time);
        let stop = summary.stop.clone().unwrap();
        assert_eq!((stop.time, stop.column.as_str()), (summary.time, "sensor.turns.angle"));
        assert!((stop.reached - stop.value).abs() < 1e-5, "{stop:?}");
        assert_eq!((summary.status, summary.end), (Status::Complete, 10.0));
        assert_eq!(whole.analyses[i].stop.as_ref(), Some(&stop));
        let last = value(&straight.join(part), usize::MAX, "sensor.turns.angle");
        assert_eq!(last, stop.reached);
        let log = fs::read_to_string(straight.join(part).join("log.txt")).unwrap();
        assert!(log.contains("`sensor.turns.angle` has crossed"), "{log}");
    }
    let (end, start) = (
        value(&straight.join("1-spin-up"), usize::MAX, "sensor.turns.angle"),
        value(&straight.join("2-coast"), 0, "sensor.turns.angle"),
    );
    assert!((end - start).abs() < 1e-12);
    let bearing = |column: &str| value(&straight.join("1-spin-up"), 7, column);
    let moment = ["mx", "my", "mz"].map(|c| bearing(&format!("joint.hinge.{c}")).powi(2)).iter().sum::<f64>();
    assert!((bearing("sensor.bearing.moment") - moment.sqrt()).abs() <= 1e-14 * moment.sqrt());

    let steps = whole.analyses.len() as u64;
    assert_eq!(steps, 2);
    let first = Summary::read(&straight.join("1-spin-up")).unwrap().steps;
    for stop in [3, first - 1] {
        let place = folder.path().join(format!("stopped behind {stop}"));
        run(&deck, &options(&place, false), &mut stop_after(stop)).unwrap_err();
        let resumed = run(&deck, &options(&place, true), &mut Unwatched).unwrap();
        assert_eq!((resumed.steps, resumed.time, &resumed.stop), (whole.steps, whole.time, &whole.stop));
        for part in ["1-spin-up", "2-coast"] {
            let read = |folder: &Path| fs::read(folder.join(part).join("history.csv")).unwrap();
            assert!(read(&straight) == read(&place), "{part} differs");
        }
    }
}

/// Each scheme repeats its last step to the same numbers, whether the run was interrupted or not; a run that was killed behind its last
/// step, before its summary said so, has ended, too.
#[test]
fn resumed_runs_end_at_the_same_condition_to_the_bit() {
    for (scheme, column, value) in [
        ("newmark", "support.u_min.fz", 8.0),
        ("energy-momentum", "corner.uz", -0.02),
        ("hht", "kinetic", 0.5),
        ("generalized-alpha", "sensor.corner.vz", -1.0),
        ("explicit", "sensor.corner.vz", -1.0),
    ] {
        let text = SWING.replace("SCHEME", scheme).replace(
            "[mesh]",
            &format!(
                "stop = [{{ column = \"{column}\", value = {value} }}]\n[[sensors]]\ntype = \"point\"\nname = \"corner\"\n\
                 on = \"u_max_v_max\"\n[mesh]"
            ),
        );
        let (deck, folder) = (Deck::parse("swing.toml", text).unwrap(), tempfile::tempdir().unwrap());
        let (straight, parts) = (folder.path().join("straight"), folder.path().join("parts"));
        let whole = run(&deck, &options(&straight, false), &mut Unwatched).unwrap();
        let stop = whole.stop.clone().unwrap_or_else(|| panic!("{scheme}: not met until {}", whole.time));
        assert!(whole.time < 0.2 && stop.time == whole.time, "{scheme} {stop:?}");
        assert!((stop.reached - value).abs() < 1e-5 * value.abs(), "{scheme} {stop:?}");
        assert!(whole.steps > 4, "{scheme} {}", whole.steps);
        let last_but_one = if scheme == "explicit" { (whole.steps - 1) / 10 * 10 } else { whole.steps - 1 };
        for (resume, steps) in [(false, 2), (true, last_but_one)] {
            run(&deck, &options(&parts, resume), &mut stop_after(steps)).unwrap_err();
        }
        let resumed = run(&deck, &options(&parts, true), &mut Unwatched).unwrap();
        let read = |folder: &Path, name: &str| fs::read(folder.join(name)).unwrap();
        assert!(read(&straight, "history.csv") == read(&parts, "history.csv"), "{scheme}");
        assert_eq!((&resumed.stop, resumed.steps), (&whole.stop, whole.steps), "{scheme}");
        let text =
            fs::read_to_string(parts.join("summary.json")).unwrap().replace("\"complete\"", "\"running\"");
        fs::write(parts.join("summary.json"), text).unwrap();
        let last = run(&deck, &options(&parts, true), &mut Unwatched).unwrap();
        assert_eq!(
            (&last.stop, last.steps, last.status),
            (&whole.stop, whole.steps, Status::Complete),
            "{scheme}"
        );
        assert!(read(&straight, "history.csv") == read(&parts, "history.csv"), "{scheme}");
    }
}

#[test]
fn conditions_that_are_never_met_are_warned_of() {
    let text = SWING
        .replace("SCHEME", "newmark")
        .replace("[mesh]", "stop = [{ column = \"kinetic\", value = 1e6, direction = \"rising\" }]\n[mesh]");
    let folder = tempfile::tempdir().unwrap();
    let mut warnings = Warnings::default();
    let summary =
        run(&Deck::parse("m.toml", text).unwrap(), &options(folder.path(), false), &mut warnings).unwrap();
    assert!(summary.stop.is_none() && summary.time == 0.2);
    assert!(
        warnings.0.iter().any(|w| w.contains("no stop condition was met: `kinetic` rises to 1000000")),
        "{:?}",
        warnings.0
    );
    let log = fs::read_to_string(folder.path().join("log.txt")).unwrap();
    assert!(log.contains("warning: the analysis has reached its end"), "{log}");
}

/// Means over a step tell nothing in the short step to a crossing.
#[test]
fn reactions_and_accelerations_of_energy_momentum_steps_are_refused() {
    for column in ["joint.hinge.fx", "sensor.bearing.moment", "body.wheel.alpha_z"] {
        let text = SPIN_UP.replace("\"body.wheel.wz\"", &format!("\"{column}\""));
        let error = prepare(&Deck::parse("m.toml", text.clone()).unwrap()).err().unwrap().to_string();
        assert!(error.contains("is a mean over the step"), "{error}");
        let fourth = text.replace("\"energy-momentum\" }", "\"energy-momentum\", order = 4 }");
        assert!(prepare(&Deck::parse("m.toml", fourth).unwrap()).is_ok());
    }
    let stop = "stop = [{ column = \"support.u_min.fz\", value = 1.0, direction = \"rising\" }]\n[mesh]";
    let text = SWING.replace("SCHEME", "energy-momentum").replace("[mesh]", stop);
    let error = prepare(&Deck::parse("m.toml", text.clone()).unwrap()).err().unwrap().to_string();
    assert!(error.contains("\"support.u_min.fz\" is a mean over the step"), "{error}");
    prepare(&Deck::parse("m.toml", text.replace("energy-momentum", "newmark")).unwrap()).unwrap();
}

#[test]
fn columns_that_the_history_does_not_have_are_refused_at_their_place() {
    let text = SPIN_UP.replace("\"body.wheel.wz\"", "\"body.wheel.spin\"");
    let error = prepare(&Deck::parse("m.toml", text).unwrap()).err().unwrap().to_string();
    let line = 1 + SPIN_UP.lines().position(|line| line.contains("\"body.wheel.wz\"")).unwrap();
    assert!(error.contains(&format!("m.toml:{line}:")), "{error}");
    assert!(error.contains("no column \"body.wheel.spin\"") && error.contains("body.wheel.wz"), "{error}");
}
