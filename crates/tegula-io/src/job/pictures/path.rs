//! Load factor over displacements along an equilibrium path.

use tegula::analysis::path::CriticalKind;

use super::{curve, moving, title, with_unit};
use crate::job::history;
use crate::job::recorder::Recorder;
use crate::out::OutputError;
use crate::plot::{LinePlot, Series, Style, lines};

/// Load factor over the displacements of the points that move: stable equilibria as lines, unstable ones dashed, critical points
/// marked.
pub(super) fn load_displacement(recorder: &Recorder<'_>, rows: &[Vec<f64>]) -> Result<(), OutputError> {
    let names = history::names(&recorder.prepared.probes);
    let Some(columns) = rows.first().map(Vec::len) else { return Ok(()) };
    let [position, negative] = [columns - 2, columns - 1];
    let unstable = |row: &Vec<f64>| row.get(negative).is_some_and(|n| *n > 0.0);
    let mut series: Vec<Series> = Vec::new();
    let mut critical = [CriticalKind::Limit, CriticalKind::Bifurcation].map(|kind| (kind, Vec::new()));
    for column in moving(recorder, rows) {
        let all = curve(rows, column, 0);
        let own = series.len();
        let mut parts = [Vec::new(), Vec::new()];
        // The part between two points has the stability behind the first of them.
        for (i, point) in all.iter().enumerate() {
            let kinds = [i.checked_sub(1), Some(i)].map(|i| rows.get(i?).map(unstable));
            for (part, wanted) in parts.iter_mut().zip([false, true]) {
                let belongs = kinds.iter().flatten().any(|is| *is == wanted);
                part.push(if belongs { *point } else { (f64::NAN, f64::NAN) });
            }
        }
        let [stable, dashed] = parts.map(|part| interrupted(&part));
        series.push(Series { name: names[column].replace('.', " "), points: stable, style: Style::Line });
        if dashed.iter().any(|point| point.0.is_finite()) {
            series.push(Series { name: String::new(), points: dashed, style: Style::DashedLike(own) });
        }
        for point in recorder.summary.critical_points.iter().flatten() {
            let at = rows.iter().find(|row| row.get(position).is_some_and(|p| *p == point.position));
            let places = critical.iter_mut().find(|(kind, _)| *kind == point.kind);
            if let (Some(row), Some((_, places))) = (at, places) {
                places.push((row[column], point.load_factor));
            }
        }
    }
    for (kind, points) in critical.into_iter().filter(|(_, points)| !points.is_empty()) {
        series.push(Series { name: kind.name().into(), points, style: Style::Markers });
    }
    if series.is_empty() {
        return Ok(());
    }
    let plot = LinePlot {
        title: title(recorder, "equilibrium path"),
        x_label: with_unit("displacement", recorder.model.output.units.length.as_deref()),
        y_label: "load factor".into(),
        series,
        note: "Dashed: unstable equilibria.".into(),
        ..LinePlot::default()
    };
    lines(&recorder.folder.file("load_displacement.png"), &plot)
}

/// Points of a line, with one gap between its parts.
fn interrupted(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut out: Vec<(f64, f64)> = Vec::new();
    for point in points {
        if point.0.is_finite() || out.last().is_some_and(|last| last.0.is_finite()) {
            out.push(*point);
        }
    }
    out
}
