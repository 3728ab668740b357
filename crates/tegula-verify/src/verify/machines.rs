//! Rigid bodies and joints: classical mechanisms against exact and independent solutions, from the files of a run.
//!
//! Each model of `verification/models/machines/` is run as `tegula run` does, and its history is compared with
//! `verification/reference/machines.csv`. Energy is asserted where nothing but gravity, springs and constant moments acts.

use nalgebra::{Quaternion, UnitQuaternion};
use tegula::norm::larger;
use tegula::{Error, Result, Vec3};

use super::files::Results;
use super::reference::{Record, records};
use super::report::Report;
use super::{Case, Cost};

/// Cases of this file.
pub(super) const CASES: &[Case] = &[
    Case {
        name: "machines-fast",
        about: "rigid mechanisms with few steps: pendulum, four-bar through its singular position",
        cost: Cost::Fast,
        run: fast,
    },
    Case {
        name: "machines",
        about: "rigid mechanisms: pendulum, four-bar, squeezer, Bricard, governor, slider-crank, tops",
        cost: Cost::Normal,
        run: normal,
    },
];

const CASE: &str = "machines";
const REFERENCE: &str = include_str!("../../../../verification/reference/machines.csv");
/// Drift of the total energy over the largest kinetic energy: the tolerance of Newton's method.
const DRIFT: f64 = 1e-10;

macro_rules! model {
    ($name:literal) => {
        ($name, include_str!(concat!("../../../../verification/models/machines/", $name, ".toml")))
    };
}

fn fast(report: &mut Report) -> Result<()> {
    [model!("pendulum"), model!("four_bar")].into_iter().try_for_each(|model| compare(report, model))
}

fn normal(report: &mut Report) -> Result<()> {
    fast(report)?;
    let models = [
        model!("squeezer"),
        model!("bricard"),
        model!("governor"),
        model!("slider_crank"),
        model!("heavy_top"),
        model!("free_body"),
        model!("pendulum_fourth_order"),
        model!("bricard_fourth_order"),
        model!("slider_crank_fourth_order"),
    ];
    models.into_iter().try_for_each(|model| compare(report, model))
}

/// Runs a machine and compares its history.
fn compare(report: &mut Report, (machine, text): (&str, &str)) -> Result<()> {
    report.element("");
    let results = Results::of(text)?;
    let history = results.table("history.csv")?;
    for row in records(REFERENCE).iter().filter(|row| row.text("machine") == machine) {
        let (time, quantity) = (row.number("time_s"), row.text("quantity"));
        let now = history.iter().find(|now| (now.number("time") - time).abs() <= 1e-9 * time);
        let (Some(first), Some(now)) = (history.first(), now) else {
            return Err(Error::Outside(format!("{machine} has no step that ends at {time}")));
        };
        let found = match quantity.split_once('@') {
            None => now.number(quantity),
            Some((body, point)) => place(body, point, first, now).unwrap_or(f64::NAN),
        };
        let name = format!("{machine}: {quantity} at {time} s");
        report.absolute(CASE, &name, "", found, row.number("value"), row.number("tolerance"));
    }
    let total = |row: &Record| row.number("total");
    let start = history.first().map_or(f64::NAN, total);
    let drift = history.iter().map(|row| (total(row) - start).abs()).fold(0.0, larger);
    let kinetic = history.iter().map(|row| row.number("kinetic")).fold(0.0, larger);
    report.at_most(CASE, &format!("{machine}: drift of the energy"), "", drift / kinetic, DRIFT);
    Ok(())
}

/// Component of the present place of a point of a body, given as `X Y Z.c` by its place at the start.
fn place(body: &str, point: &str, first: &Record, now: &Record) -> Option<f64> {
    let (point, component) = point.rsplit_once('.')?;
    let numbers: Vec<f64> = point.split(' ').map(str::parse).collect::<std::result::Result<_, _>>().ok()?;
    let at = |row: &Record| Vec3::from(["x", "y", "z"].map(|c| row.number(&format!("body.{body}.{c}"))));
    let [w, i, j, k] = ["q0", "q1", "q2", "q3"].map(|c| now.number(&format!("body.{body}.{c}")));
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k));
    let x = at(now) + turn * (Vec3::from_column_slice(numbers.get(..3)?) - at(first));
    ["x", "y", "z"].iter().position(|c| *c == component).map(|c| x[c])
}
