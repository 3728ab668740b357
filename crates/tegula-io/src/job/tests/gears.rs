//! Runs with gears: their turns are counted by the state, and resumed.

use std::cell::Cell;
use std::fs;
use std::path::Path;

use super::super::*;
use super::options;
use super::steps::{StopIn, files};
use crate::deck::Deck;

/// Two wheels of an irrational ratio that turn many times against a torsion spring, geared, released, and geared again.
const MACHINE: &str = r#"
title = "Gears"
output = { pictures = false }

[[bodies]]
name = "pinion"
at = [0.0, 0.0, 0.0]
mass = 1.0
inertia = [0.02, 0.02, 0.02]
angular_velocity = [0.0, 0.0, 30.0]

[[bodies]]
name = "wheel"
at = [0.4, 0.0, 0.0]
mass = 1.0
inertia = [0.3, 0.3, 0.3]
angular_velocity = [0.0, 0.0, -10.0]

[[joints]]
type = "revolute"
name = "first"
between = ["ground", "pinion"]
at = [0.0, 0.0, 0.0]
axis = [0.0, 0.0, 1.0]

[[joints]]
type = "revolute"
name = "second"
between = ["ground", "wheel"]
at = [0.4, 0.0, 0.0]
axis = [0.0, 0.0, 1.0]

[[joints]]
type = "gear"
name = "teeth"
between = ["pinion", "wheel"]
axes = [[0.0, 0.0, 1.0], [0.0, 0.0, 1.0]]
ratio = -2.718281828459045

[[torsion_springs]]
name = "spring"
between = ["ground", "wheel"]
axis = [0.0, 0.0, 1.0]
stiffness = 0.4

[[sensors]]
type = "angle"
name = "turn"
between = ["ground", "wheel"]
axis = [0.0, 0.0, 1.0]

[[steps]]
name = "geared"
analysis = { type = "transient", end_time = 1.5, time_step = 0.01, scheme = { type = "energy-momentum" } }

[[steps]]
name = "free"
released = ["teeth"]
analysis = { type = "transient", end_time = 0.3, time_step = 0.01, scheme = { type = "generalized-alpha" } }

[[steps]]
name = "again"
analysis = { type = "transient", end_time = 0.6, time_step = 0.01, scheme = { type = "energy-momentum", order = 4 } }
"#;

#[test]
fn runs_with_gears_are_resumed_to_the_bit() {
    let deck = Deck::parse("machine.toml", MACHINE).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let straight = folder.path().join("straight");
    let whole = run(&deck, &options(&straight, false), &mut Unwatched).unwrap();
    assert_eq!(whole.status, Status::Complete);
    let (names, rows) = crate::out::csv::read(&straight.join("1-geared").join("history.csv")).unwrap();
    let turn = names.iter().position(|name| name == "sensor.turn.angle").unwrap();
    assert!(rows.last().unwrap()[turn] < -540.0, "{:?}", rows.last());
    for (analysis, steps) in [(1, 30), (1, 90), (1, 149), (2, 10), (3, 5), (3, 40)] {
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
