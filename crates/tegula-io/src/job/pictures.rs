//! Pictures of a run, drawn from its history and its snapshots.

mod path;

pub(super) use path::with_branches;

use tegula::norm::max_norm;
use tegula::result::Probe;
use tegula::{Mesh, Model, System};

use super::history::{BEHIND, PER_POINT};
use super::recorder::Recorder;
use super::snapshots::{StoredSnapshot, shown};
use super::{Prepared, drawn_outline, fields, history};
use crate::out::{OutputError, csv};
use crate::plot::{LinePlot, Series, Snapshot, Style, SurfacePlot, lines, surfaces};

/// Displacements smaller than this part of the model are drawn larger.
const VISIBLE: f64 = 0.02;
/// Part of the model that enlarged displacements reach, at most.
const ENLARGED: f64 = 0.1;

/// Draws all pictures. One that cannot be drawn is an event in the log: the results do not depend on it.
pub(super) fn draw(recorder: &mut Recorder<'_>) {
    let mut problems: Vec<OutputError> = Vec::new();
    let mut check = |result: Result<(), OutputError>| problems.extend(result.err());
    match csv::read(&recorder.folder.file("history.csv")) {
        Ok((head, rows)) if rows.len() > 1 => {
            if recorder.memory.state.path.is_some() {
                let primary = path::Followed {
                    rows: rows.clone(),
                    start: 0.0,
                    critical: recorder.summary.critical_points.clone(),
                };
                check(path::load_displacement(
                    (recorder.model, recorder.prepared, recorder.folder.path()),
                    &head,
                    &[primary],
                ));
            } else if recorder.summary.analysis == "static" {
                check(load_displacement(recorder, &rows));
            } else {
                points(recorder, &rows).into_iter().for_each(&mut check);
                check(step_size(recorder, &rows));
            }
            check(energy(recorder, &rows));
        }
        Ok(_) => {}
        Err(error) => check(Err(error)),
    }
    check(snapshots(recorder));
    for problem in problems {
        tegula::analysis::Observer::on_event(recorder, &format!("a picture is missing: {problem}"));
    }
}

/// Column of a quantity behind the points.
fn column(recorder: &Recorder<'_>, name: &str) -> usize {
    let offset = BEHIND.iter().position(|&n| n == name).unwrap_or(0);
    1 + PER_POINT * recorder.prepared.probes.len() + offset
}

fn curve(rows: &[Vec<f64>], x: usize, y: usize) -> Vec<(f64, f64)> {
    rows.iter().filter_map(|row| Some((*row.get(x)?, *row.get(y)?))).collect()
}

/// Title of the model, and what the picture shows.
fn title(model: &Model, what: &str) -> String {
    let title = &model.title;
    if title.is_empty() { what.to_owned() } else { format!("{title}: {what}") }
}

/// A label with the name of its unit, where the model gives one.
pub(super) fn with_unit(label: &str, unit: Option<&str>) -> String {
    unit.map_or(label.to_owned(), |unit| format!("{label} [{unit}]"))
}

/// Rows of a history up to which each is marked in its curves.
const MARKED: usize = 40;

/// Line with the points of a short history.
fn style(rows: &[Vec<f64>]) -> Style {
    if rows.len() < MARKED { Style::Both } else { Style::Line }
}

/// Displacement of each point over time.
fn points(recorder: &Recorder<'_>, rows: &[Vec<f64>]) -> Vec<Result<(), OutputError>> {
    let one = |(i, probe): (usize, &tegula::result::Probe)| {
        let first = 1 + PER_POINT * i + 3;
        let series = ["ux", "uy", "uz"].into_iter().enumerate().map(|(c, name)| Series {
            name: name.into(),
            points: curve(rows, 0, first + c),
            style: style(rows),
        });
        let plot = LinePlot {
            title: title(recorder.model, &format!("displacement of {}", probe.name)),
            x_label: time_label(recorder),
            y_label: with_unit("displacement", recorder.model.output.units.length.as_deref()),
            series: series.collect(),
            ..LinePlot::default()
        };
        lines(&recorder.folder.file(&format!("point_{}.png", probe.name)), &plot)
    };
    recorder.prepared.probes.iter().enumerate().map(one).collect()
}

/// Displacements smaller than this part of the largest one are not drawn over the load.
const STILL: f64 = 1e-6;

/// Columns with the displacements of the points that move.
fn moving(probes: &[Probe], rows: &[Vec<f64>]) -> Vec<usize> {
    let size = |c: usize| max_norm(rows.iter().filter_map(|row| row.get(c).copied()));
    let columns = (0..probes.len()).flat_map(|i| (0..3).map(move |c| 1 + PER_POINT * i + 3 + c));
    let columns: Vec<(usize, f64)> = columns.map(|c| (c, size(c))).collect();
    let largest = max_norm(columns.iter().map(|(_, size)| *size));
    columns.into_iter().filter(|(_, size)| *size > STILL * largest).map(|(c, _)| c).collect()
}

/// Load factor over the displacements of the points that move.
fn load_displacement(recorder: &Recorder<'_>, rows: &[Vec<f64>]) -> Result<(), OutputError> {
    let names = history::names(&recorder.prepared.probes);
    let series: Vec<Series> = moving(&recorder.prepared.probes, rows)
        .into_iter()
        .map(|c| Series { name: names[c].replace('.', " "), points: curve(rows, c, 0), style: style(rows) })
        .collect();
    if series.is_empty() {
        return Ok(());
    }
    let plot = LinePlot {
        title: title(recorder.model, "displacement under the load"),
        x_label: with_unit("displacement", recorder.model.output.units.length.as_deref()),
        y_label: "load factor".into(),
        series,
        ..LinePlot::default()
    };
    lines(&recorder.folder.file("load_displacement.png"), &plot)
}

/// Energies that are not zero throughout.
fn energy(recorder: &Recorder<'_>, rows: &[Vec<f64>]) -> Result<(), OutputError> {
    let names = ["kinetic", "strain", "potential", "work", "dissipated", "total"];
    let series: Vec<Series> = names
        .into_iter()
        .map(|name| Series {
            name: name.into(),
            points: curve(rows, 0, column(recorder, name)),
            style: if name == "total" { Style::Dashed } else { style(rows) },
        })
        .filter(|s| s.points.iter().any(|p| p.1 != 0.0))
        .collect();
    if series.is_empty() {
        return Ok(());
    }
    let plot = LinePlot {
        title: title(recorder.model, "energy"),
        x_label: time_label(recorder),
        y_label: with_unit("energy", recorder.model.output.units.of_energy().as_deref()),
        series,
        ..LinePlot::default()
    };
    lines(&recorder.folder.file("energy.png"), &plot)
}

fn time_label(recorder: &Recorder<'_>) -> String {
    if recorder.summary.analysis != "transient" {
        return "load factor".into();
    }
    with_unit("time", recorder.model.output.units.time.as_deref())
}

/// Length of the time steps.
fn step_size(recorder: &Recorder<'_>, rows: &[Vec<f64>]) -> Result<(), OutputError> {
    // The first row is the start and has no step.
    let points = curve(rows, 0, column(recorder, "step_size")).split_off(1);
    let s = &recorder.summary;
    let plot = LinePlot {
        title: title(recorder.model, "time steps"),
        x_label: time_label(recorder),
        y_label: with_unit("step size", recorder.model.output.units.time.as_deref()),
        series: vec![Series { name: String::new(), points, style: Style::Line }],
        y_log: true,
        note: format!("{} steps, {} iterations, {} cut-backs", s.steps, s.iterations, s.cutbacks),
        ..LinePlot::default()
    };
    lines(&recorder.folder.file("step_size.png"), &plot)
}

/// The shell at the instants that were kept.
fn snapshots(recorder: &Recorder<'_>) -> Result<(), OutputError> {
    let Prepared { mesh, system, .. } = recorder.prepared;
    let kept = shown(&recorder.memory.kept);
    let bodies = drawn_outline::faces(system, mesh.positions.len());
    // Bodies without a shape are not seen.
    if kept.is_empty() || (mesh.quads.is_empty() && bodies.is_empty()) {
        return Ok(());
    }
    let largest = kept.iter().map(|k| largest_displacement(mesh, system, k)).fold(0.0, tegula::norm::larger);
    let scale = magnification(largest / system.length);
    let units = &recorder.model.output.units;
    let (letter, unit) = match &units.time {
        _ if recorder.summary.analysis != "transient" => ("load", String::new()),
        unit => ("t =", unit.as_ref().map_or(String::new(), |unit| format!(" {unit}"))),
    };
    let only_shape = kept.len() == 1;
    let count = kept.len();
    let shots = kept.into_iter().enumerate().map(|(i, k)| Snapshot {
        positions: [
            fields::positions(mesh, system, &k.displacements, scale),
            drawn_outline::positions(system, &k.displacements, scale),
        ]
        .concat(),
        values: (!only_shape).then(|| k.values.clone()),
        nodal: None,
        label: format!("{letter} {}{unit}", short(k.time)),
        opacity: opacity(i, count),
    });
    let parts = if mesh.quads.is_empty() { "motion" } else { "deformed shell" };
    let what = if scale == 1.0 { parts.into() } else { format!("displacements × {scale}") };
    let plot = SurfacePlot {
        title: title(recorder.model, &what),
        snapshots: shots.collect(),
        quads: mesh.quads.clone(),
        bodies,
        color_label: with_unit("von Mises stress", units.of_stress().as_deref()),
        ..SurfacePlot::default()
    };
    surfaces(&recorder.folder.file("snapshots.png"), &plot)
}

/// The last instant is solid; of two, the first is only a shadow of where the shell was.
fn opacity(index: usize, count: usize) -> f64 {
    match (index + 1 == count, count) {
        (true, _) => 1.0,
        (false, 2) => 0.25,
        (false, _) => 0.85,
    }
}

/// A time with few digits.
pub(super) fn short(time: f64) -> String {
    let text = format!("{time:.3}");
    if time != 0.0 && time.abs() < 1e-2 {
        return format!("{time:.2e}");
    }
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn largest_displacement(mesh: &Mesh, system: &System, kept: &StoredSnapshot) -> f64 {
    let field = fields::nodal(system, &kept.displacements);
    debug_assert_eq!(field.len(), mesh.positions.len());
    let of_bodies = system.outline.displacements(&kept.displacements);
    field
        .iter()
        .chain(&of_bodies)
        .map(|u| u.iter().map(|x| x * x).sum::<f64>().sqrt())
        .fold(0.0, tegula::norm::larger)
}

/// 1 where displacements (relative to the model) can be seen, else the 1, 2 or 5 times a power of ten
/// that makes them so.
fn magnification(relative: f64) -> f64 {
    if !relative.is_normal() || relative >= VISIBLE {
        return 1.0;
    }
    let wanted = ENLARGED / relative;
    let power = 10.0_f64.powf(wanted.log10().floor());
    [5.0, 2.0].into_iter().find(|m| m * power <= wanted).unwrap_or(1.0) * power
}

#[cfg(test)]
mod tests {
    use super::{magnification, short};

    #[test]
    fn small_displacements_are_enlarged_by_round_numbers() {
        assert_eq!(magnification(0.5), 1.0);
        assert_eq!(magnification(0.0), 1.0);
        assert_eq!(magnification(f64::NAN), 1.0);
        assert_eq!(magnification(1e-3), 100.0);
        assert_eq!(magnification(9e-4), 100.0);
        assert_eq!(magnification(4e-4), 200.0);
    }

    #[test]
    fn times_are_short() {
        assert_eq!([0.0, 1.0, 0.3001, 0.25, 2e-4].map(short), ["0", "1", "0.3", "0.25", "2.00e-4"]);
    }
}
