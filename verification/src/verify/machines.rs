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
        about: "rigid mechanisms: pendulum, four-bar, squeezer, Bricard, governor, slider-crank, tops; a free flight",
        cost: Cost::Normal,
        run: normal,
    },
    Case {
        name: "flexible-machines",
        about: "beams: soft pendulum, spin-up, slider-crank, four-bar, lateral buckling, shaft with a disc and its modes",
        cost: Cost::Normal,
        run: flexible,
    },
    Case {
        name: "flexible-machines-shells",
        about: "strips of shell on rigid patches: soft pendulum, spin-up, slider-crank, four-bar, lateral buckling",
        cost: Cost::Normal,
        run: shells,
    },
];

const CASE: &str = "machines";
const REFERENCE: &str = include_str!("../../reference/machines.csv");
/// Drift of the total energy over the largest kinetic energy: the tolerance of Newton's method.
const DRIFT: f64 = 1e-10;
/// Drift of a momentum over its value.
const MOMENTA: f64 = 1e-9;

macro_rules! model {
    ($name:literal) => {
        ($name, include_str!(concat!("../../models/machines/", $name, ".toml")))
    };
}

fn fast(report: &mut Report) -> Result<()> {
    compare_all(report, &[model!("pendulum"), model!("four_bar")])
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
        model!("heavy_top_fourth_order"),
    ];
    compare_all(report, &models)?;
    free_flight(report)
}

/// A sheet with two hinged plates flies freely: momenta, and like those of all machines the energy, stay over 10 000 steps.
fn free_flight(report: &mut Report) -> Result<()> {
    let (machine, text) = model!("free_flight");
    let history = compare(report, (machine, text))?;
    let momentum = |row: &Record, names: [&str; 3]| Vec3::from(names.map(|name| row.number(name)));
    for (quantity, names) in
        [("linear momentum", ["px", "py", "pz"]), ("angular momentum", ["lx", "ly", "lz"])]
    {
        let start = history.first().map_or_else(Vec3::zeros, |row| momentum(row, names));
        let drift = history.iter().map(|row| (momentum(row, names) - start).norm()).fold(0.0, larger);
        report.at_most(
            CASE,
            &format!("{machine}: drift of the {quantity}"),
            "",
            drift / start.norm(),
            MOMENTA,
        );
    }
    report.absolute(CASE, &format!("{machine}: steps"), "", history.len() as f64 - 1.0, 10_000.0, 0.0);
    Ok(())
}

/// Natural frequencies of the shaft at rest.
fn shaft_modes(report: &mut Report) -> Result<()> {
    let (machine, text) = model!("shaft_modes");
    report.element("");
    let modes = Results::of(text)?.table("modes.csv")?;
    for row in records(REFERENCE).iter().filter(|row| row.text("machine") == machine) {
        let found = modes.iter().find(|mode| mode.text("mode") == row.text("quantity"));
        let found = found.map_or(f64::NAN, |mode| mode.number("omega"));
        let name = format!("{machine}: circular frequency of mode {}", row.text("quantity"));
        report.absolute(CASE, &name, "", found, row.number("value"), row.number("tolerance"));
    }
    Ok(())
}

fn flexible(report: &mut Report) -> Result<()> {
    let models = [
        model!("soft_pendulum"),
        model!("spin_up"),
        model!("flexible_slider_crank"),
        model!("skewed_four_bar"),
        model!("lateral_buckling"),
        model!("shaft"),
    ];
    compare_all(report, &models)?;
    shaft_modes(report)
}

fn shells(report: &mut Report) -> Result<()> {
    let models = [
        model!("soft_pendulum_shell"),
        model!("spin_up_shell"),
        model!("flexible_slider_crank_shell"),
        model!("skewed_four_bar_shell"),
    ];
    compare_all(report, &models)?;
    // Two meshes: what buckling magnifies must not come from the mesh.
    let (machine, text) = model!("lateral_buckling_shell");
    for mesh in ["[20, 16]", "[40, 16]"] {
        compare(report, (machine, &text.replace("[40, 16]", mesh)))?;
    }
    Ok(())
}

/// Runs machines and compares their histories.
fn compare_all(report: &mut Report, models: &[(&str, &str)]) -> Result<()> {
    models.iter().try_for_each(|&model| compare(report, model).map(|_| ()))
}

/// Runs a machine and compares its history, which is returned.
fn compare(report: &mut Report, (machine, text): (&str, &str)) -> Result<Vec<Record>> {
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
            Some(("offset", place)) => offset(place, now).unwrap_or(f64::NAN),
            Some(("passes", limit)) => passes(limit, &history).unwrap_or(f64::NAN),
            Some(("bow", bodies)) => bow(bodies, now).unwrap_or(f64::NAN),
            Some((body, point)) => place(body, point, first, now).unwrap_or(f64::NAN),
        };
        let name = format!("{machine}: {quantity} at {time} s");
        report.absolute(CASE, &name, "", found, row.number("value"), row.number("tolerance"));
    }
    let total = |row: &Record| row.number("total");
    let start = history.first().map_or(f64::NAN, total);
    let drift = history.iter().map(|row| (total(row) - start).abs()).fold(0.0, larger);
    let largest = |energy: &str| history.iter().map(|row| row.number(energy)).fold(0.0, larger);
    // Slow elastic machines have far more strain energy than kinetic energy.
    let elastic = text.contains("[[beams]]") || text.contains("[[sections]]");
    let scale = if elastic { larger(largest("kinetic"), largest("strain")) } else { largest("kinetic") };
    report.at_most(CASE, &format!("{machine}: drift of the energy"), "", drift / scale, DRIFT);
    Ok(history)
}

/// Place of a body, or of a recorded point of a shell.
fn at(name: &str, now: &Record) -> Vec3 {
    let body = !now.text(&format!("body.{name}.x")).is_empty();
    let prefix = if body { "body." } else { "" };
    Vec3::from(["x", "y", "z"].map(|c| now.number(&format!("{prefix}{name}.{c}"))))
}

/// Component 1 or 2 of the place of a body or point along axes that have turned about z, given as `NAME ANGLE.c`.
fn offset(place: &str, now: &Record) -> Option<f64> {
    let (name, turn) = place.split_once(' ')?;
    let (angle, component) = turn.rsplit_once('.')?;
    let (sine, cosine) = angle.parse::<f64>().ok()?.sin_cos();
    let place = at(name, now);
    let (x, y) = (place.x, place.y);
    Some(if component == "1" { x * cosine + y * sine } else { y * cosine - x * sine })
}

/// Distance of the second of three bodies or points from the chord between the others over its length, in the plane x-y.
fn bow(names: &str, now: &Record) -> Option<f64> {
    let places: Vec<Vec3> = names.split(' ').map(|name| at(name, now)).collect();
    let [start, middle, end] = places[..] else { return None };
    let (chord, rise) = (end - start, middle - (start + end) * 0.5);
    Some((chord.x * rise.y - chord.y * rise.x) / chord.norm_squared())
}

/// First time at which the absolute value of a column passes a limit, given as `COLUMN LIMIT`; straight between steps.
fn passes(limit: &str, history: &[Record]) -> Option<f64> {
    let (column, limit) = limit.split_once(' ')?;
    let limit: f64 = limit.parse().ok()?;
    let size = |row: &Record| row.number(column).abs();
    let [before, after] = history.windows(2).find(|pair| size(&pair[1]) > limit)? else { return None };
    let part = (limit - size(before)) / (size(after) - size(before));
    Some(before.number("time") + part * (after.number("time") - before.number("time")))
}

/// Component of the present place of a point of a body, given as `X Y Z.c` by its place at the start.
fn place(body: &str, point: &str, first: &Record, now: &Record) -> Option<f64> {
    let (point, component) = point.rsplit_once('.')?;
    let numbers: Vec<f64> = point.split(' ').map(str::parse).collect::<std::result::Result<_, _>>().ok()?;
    let [w, i, j, k] = ["q0", "q1", "q2", "q3"].map(|c| now.number(&format!("body.{body}.{c}")));
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k));
    let x = at(body, now) + turn * (Vec3::from_column_slice(numbers.get(..3)?) - at(body, first));
    ["x", "y", "z"].iter().position(|c| *c == component).map(|c| x[c])
}
