//! Runs with friction and stops of joints: columns of the history, and resuming.

use std::cell::Cell;
use std::fs;
use std::path::Path;

use super::super::*;
use super::options;
use super::steps::{StopIn, files};
use crate::deck::Deck;

/// A block that slides up a slope, comes to rest and sticks, a ball that bounces, and a braked pendulum; then a step in which the block
/// is locked and the hinge of the pendulum released.
const MACHINE: &str = r#"
title = "Friction and stops"
output = { pictures = false }

[[bodies]]
name = "block"
at = [0.0, 0.0, 0.0]
mass = 2.0
inertia = [0.2, 0.25, 0.3]
velocity = [1.2, 0.0, 0.0]

[[bodies]]
name = "ball"
at = [0.0, 1.0, 0.0]
mass = 1.0
inertia = [0.1, 0.1, 0.1]

[[bodies]]
name = "bob"
at = [0.5, 2.0, 0.0]
mass = 2.0
inertia = [0.02, 0.02, 0.02]

[[joints]]
type = "prismatic"
name = "slope"
between = ["ground", "block"]
at = [0.0, 0.0, 0.0]
axis = [1.0, 0.0, 0.3]
friction = { coefficient = 0.4, static_coefficient = 0.5 }

[[joints]]
type = "prismatic"
name = "guide"
between = ["ground", "ball"]
at = [0.0, 1.0, 0.0]
axis = [0.0, 0.0, 1.0]
stops = { lower = -0.2, restitution = 0.6 }

[[joints]]
type = "revolute"
name = "hinge"
between = ["ground", "bob"]
at = [0.0, 2.0, 0.0]
axis = [0.0, 1.0, 0.0]
friction = { coefficient = 0.3, radius = 0.05, preload = 0.5 }

[[loads]]
type = "gravity"
value = [0.0, 0.0, -10.0]

[[steps]]
name = "motion"
analysis = { type = "transient", end_time = 1.2, time_step = 0.01, scheme = { type = "energy-momentum" } }

[[steps]]
name = "locked"
locked = ["slope"]
released = ["hinge", "guide"]
analysis = { type = "transient", end_time = 0.1, time_step = 0.01, scheme = { type = "generalized-alpha" } }

[[steps]]
name = "again"
released = ["hinge", "guide"]
analysis = { type = "transient", end_time = 0.1, time_step = 0.01, scheme = { type = "energy-momentum" } }
"#;

const FOLDERS: [&str; 3] = ["1-motion", "2-locked", "3-again"];

#[test]
#[ignore = "long"]
fn runs_with_friction_and_stops_are_resumed_to_the_bit() {
    let deck = Deck::parse("machine.toml", MACHINE).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let straight = folder.path().join("straight");
    let whole = run(&deck, &options(&straight, false), &mut Unwatched).unwrap();
    assert_eq!(whole.status, Status::Complete);
    let column = |step: usize, name: &str| {
        let (names, rows) = crate::out::csv::read(&straight.join(FOLDERS[step]).join("history.csv")).unwrap();
        let place = names.iter().position(|n| n == name);
        place.map(|place| rows.iter().map(|row| row[place]).collect::<Vec<f64>>())
    };
    // The block slides up by v²/(2 g (sin α + μ cos α)), tan α = 0.3, and friction holds its weight then.
    let (sine, cosine) = 0.3_f64.atan().sin_cos();
    let speed = 1.2 * cosine;
    let end = |step: usize, name: &str| *column(step, name).unwrap().last().unwrap();
    let way = speed * speed / (20.0 * (sine + 0.4 * cosine));
    assert!((end(0, "joint.slope.displacement") - way).abs() < 1e-9);
    assert!((end(0, "joint.slope.friction") - 20.0 * sine).abs() < 1e-9);
    assert_eq!((end(0, "joint.slope.held"), end(0, "joint.slope.stop")), (1.0, 0.0));
    let first = column(0, "joint.slope.friction").unwrap()[3];
    assert!((first + 0.4 * 20.0 * cosine).abs() < 1e-9, "{first}");
    assert_eq!(column(0, "joint.slope.held").unwrap()[3], 0.0);
    // The ball rests on its stop, which carries its weight, and the hinge brakes the pendulum.
    assert!((end(0, "joint.guide.displacement") + 0.2).abs() < 1e-9);
    assert!((end(0, "joint.guide.stop") - 10.0).abs() < 1e-9);
    assert!(column(0, "joint.hinge.angle").unwrap().iter().any(|angle| *angle > 90.0));
    assert!(column(0, "joint.hinge.friction").unwrap()[5] < -0.5);
    // Where the joint is locked it has no friction; then it sticks where it was.
    assert!(column(1, "joint.slope.friction").is_none());
    assert!((end(2, "joint.slope.displacement") - way).abs() < 1e-9);
    for (analysis, steps) in [(1, 7), (1, 20), (1, 33), (1, 60), (1, 110), (2, 3), (3, 4)] {
        let place = folder.path().join(format!("stopped in {analysis} at {steps}"));
        let mut stop = StopIn { analysis, steps, begun: 0, stop: Cell::new(false) };
        let error = run(&deck, &options(&place, false), &mut stop).unwrap_err();
        assert!(matches!(error, JobError::Interrupted { resumable: true, .. }), "{analysis}: {error}");
        run(&deck, &options(&place, true), &mut Unwatched).unwrap();
        assert_eq!(files(&place), files(&straight));
        for file in files(&straight) {
            let read = |folder: &Path| fs::read(folder.join(&file)).unwrap();
            assert!(
                read(&straight) == read(&place),
                "stopped in {analysis} at {steps}: {} differs",
                file.display()
            );
        }
    }
}
