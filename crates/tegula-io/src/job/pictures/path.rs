//! Load factor over displacements along an equilibrium path.

use tegula::analysis::path::CriticalKind;
use tegula::norm::max_norm;

use super::{STILL, curve, moving, title, with_unit};
use crate::job::history;
use crate::job::recorder::Recorder;
use crate::out::OutputError;
use crate::plot::{LinePlot, Series, Style, lines};

/// Load factor over the displacements of the points that move, or of the bodies where there are none: stable equilibria as lines, unstable
/// ones dashed, critical points marked.
pub(super) fn load_displacement(
    recorder: &Recorder<'_>,
    (head, rows): (&[String], &[Vec<f64>]),
) -> Result<(), OutputError> {
    let names = history::names(&recorder.prepared.probes);
    let Some(columns) = rows.first().map(Vec::len) else { return Ok(()) };
    let [position, negative] = [columns - 2, columns - 1];
    let unstable = |row: &Vec<f64>| row.get(negative).is_some_and(|n| *n > 0.0);
    let mut series: Vec<Series> = Vec::new();
    let mut critical = [CriticalKind::Limit, CriticalKind::Bifurcation].map(|kind| (kind, Vec::new()));
    let mut shown: Vec<(String, usize, f64)> = moving(recorder, rows)
        .into_iter()
        .map(|column| (names[column].replace('.', " "), column, 0.0))
        .collect();
    if shown.is_empty() {
        shown = places_of_bodies(head, rows);
    }
    for (name, column, start) in shown {
        let mut all = curve(rows, column, 0);
        all.iter_mut().for_each(|(x, _)| *x -= start);
        let own = series.len();
        for (number, (dashed, points)) in
            runs(&all, |i| rows.get(i).is_some_and(unstable)).into_iter().enumerate()
        {
            let (name, style) = match (number, dashed) {
                (0, false) => (name.clone(), Style::Line),
                (0, true) => (name.clone(), Style::Dashed),
                (_, false) => (String::new(), Style::LineLike(own)),
                (_, true) => (String::new(), Style::DashedLike(own)),
            };
            series.push(Series { name, points, style });
        }
        for point in recorder.summary.critical_points.iter().flatten() {
            let places = critical.iter_mut().find(|(kind, _)| *kind == point.kind);
            if let (Some(x), Some((_, places))) = (value_at(rows, [position, column], point.position), places)
            {
                places.push((x - start, point.load_factor));
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

/// Value of a column at a position of the path, by the rows on both sides: bifurcations lie inside arc-length steps.
fn value_at(rows: &[Vec<f64>], [position, column]: [usize; 2], at: f64) -> Option<f64> {
    let behind = rows.iter().position(|row| row.get(position).is_some_and(|p| *p >= at))?;
    let (next, last) = (rows.get(behind)?, rows.get(behind.saturating_sub(1))?);
    let (from, to) = (last[position], next[position]);
    let part = if to > from { (at - from) / (to - from) } else { 1.0 };
    Some(last[column] + part * (next[column] - last[column]))
}

/// Columns of the places of bodies that move, with their names and values at the start.
fn places_of_bodies(head: &[String], rows: &[Vec<f64>]) -> Vec<(String, usize, f64)> {
    let Some(first) = rows.first() else { return Vec::new() };
    let place = |(column, name): (usize, &String)| {
        let (body, axis) = name.strip_prefix("body.")?.rsplit_once('.')?;
        if !["x", "y", "z"].contains(&axis) {
            return None;
        }
        let start = *first.get(column)?;
        let size = max_norm(rows.iter().filter_map(|row| row.get(column)).map(|x| x - start));
        Some((size, (format!("{body} u{axis}"), column, start)))
    };
    let all: Vec<_> = head.iter().enumerate().filter_map(place).collect();
    let largest = max_norm(all.iter().map(|(size, _)| *size));
    all.into_iter().filter(|(size, _)| *size > STILL * largest).map(|(_, place)| place).collect()
}

/// Pieces of a curve that are stable or unstable as a whole, with their ends. The part between two points has the stability behind the
/// first of them.
fn runs(points: &[(f64, f64)], unstable: impl Fn(usize) -> bool) -> Vec<(bool, Vec<(f64, f64)>)> {
    let mut runs: Vec<(bool, Vec<(f64, f64)>)> = Vec::new();
    for (i, &point) in points.iter().enumerate() {
        if let Some((_, run)) = runs.last_mut() {
            run.push(point);
        }
        let is = unstable(i);
        if i + 1 < points.len() && runs.last().is_none_or(|(was, _)| *was != is) {
            runs.push((is, vec![point]));
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_between_rows_are_interpolated() {
        let rows = vec![vec![0.0, 5.0], vec![1.0, 7.0], vec![3.0, 6.0]];
        let at = |position: f64| value_at(&rows, [0, 1], position);
        assert_eq!([at(0.0), at(1.0), at(2.0), at(3.0)], [Some(5.0), Some(7.0), Some(6.5), Some(6.0)]);
        assert_eq!(at(3.1), None);
    }

    #[test]
    fn pieces_share_the_points_between_them() {
        let points: Vec<(f64, f64)> = (0..6).map(|i| (f64::from(i), 0.0)).collect();
        let found = runs(&points, |i| i == 2 || i == 3);
        let lengths: Vec<_> = found.iter().map(|(is, run)| (*is, run[0].0, run.len())).collect();
        assert_eq!(lengths, [(false, 0.0, 3), (true, 2.0, 3), (false, 4.0, 2)]);
    }
}
