//! Load factor over displacements along equilibrium paths.

use std::path::Path;

use tegula::Model;
use tegula::analysis::path::CriticalKind;
use tegula::norm::max_norm;

use super::{STILL, curve, moving, title, with_unit};
use crate::job::{CriticalResult, Prepared, Summary, branches, history};
use crate::out::{OutputError, csv};
use crate::plot::{LinePlot, Series, Style, lines};

/// Path that has been followed.
pub(super) struct Followed {
    /// Rows of its history.
    pub rows: Vec<Vec<f64>>,
    /// Path parameter from which on it is drawn.
    pub start: f64,
    /// Its critical points.
    pub critical: Option<Vec<CriticalResult>>,
}

/// Draws a path and its branches in the place of the picture of the path alone.
pub(in crate::job) fn with_branches(
    (model, prepared): (&Model, &Prepared),
    (primary, folder): (&Summary, &Path),
) -> Result<(), OutputError> {
    let (head, rows) = csv::read(&folder.join("history.csv"))?;
    let mut paths = vec![Followed { rows, start: 0.0, critical: primary.critical_points.clone() }];
    for branch in &primary.branches {
        let place = folder.join(&branch.folder);
        let (_, rows) = csv::read(&place.join("history.csv"))?;
        let start = branches::start_of(primary, branch.bifurcation);
        paths.push(Followed { rows, start, critical: Summary::read(&place)?.critical_points });
    }
    load_displacement((model, prepared, folder), &head, &paths)
}

impl Followed {
    /// Rows that are drawn, and the one before them.
    fn drawn(&self, position: usize) -> &[Vec<f64>] {
        let first = self.rows.iter().position(|row| row.get(position).is_some_and(|p| *p >= self.start));
        self.rows.get(first.unwrap_or(0).saturating_sub(1)..).unwrap_or(&[])
    }

    fn is_unstable(row: &[f64]) -> bool {
        row.last().is_some_and(|negative| *negative > 0.0)
    }
}

/// Load factor over the displacements of the points that move, or of the bodies where there are none: stable equilibria as lines, unstable
/// ones dashed, critical points marked.
pub(super) fn load_displacement(
    (model, prepared, folder): (&Model, &Prepared, &Path),
    head: &[String],
    paths: &[Followed],
) -> Result<(), OutputError> {
    let names = history::names(&prepared.probes);
    let all: Vec<Vec<f64>> = paths.iter().flat_map(|path| path.rows.iter().cloned()).collect();
    let Some(columns) = all.first().map(Vec::len) else { return Ok(()) };
    let position = columns - 2;
    let mut series: Vec<Series> = Vec::new();
    let mut critical = [CriticalKind::Limit, CriticalKind::Bifurcation, CriticalKind::Flutter]
        .map(|kind| (kind, Vec::new()));
    let mut shown: Vec<(String, usize, f64)> = moving(&prepared.probes, &all)
        .into_iter()
        .map(|column| (names[column].replace('.', " "), column, 0.0))
        .collect();
    if shown.is_empty() {
        shown = places_of_bodies(head, &all);
    }
    for (name, column, start) in shown {
        let own = series.len();
        let curves: Vec<Vec<(f64, f64)>> = paths
            .iter()
            .map(|path| {
                curve(path.drawn(position), column, 0).into_iter().map(|(x, y)| (x - start, y)).collect()
            })
            .collect();
        let size = extent(&curves);
        for (number, path) in paths.iter().enumerate() {
            let (rows, points) = (path.drawn(position), &curves[number]);
            for part in new_parts(points, &curves[..number], size) {
                let unstable =
                    |i: usize| rows.get(part.start + i).is_some_and(|row| Followed::is_unstable(row));
                for (dashed, points) in runs(points.get(part.clone()).unwrap_or(&[]), unstable) {
                    let (name, style) = match (series.len() == own, dashed) {
                        (true, false) => (name.clone(), Style::Line),
                        (true, true) => (name.clone(), Style::Dashed),
                        (false, false) => (String::new(), Style::LineLike(own)),
                        (false, true) => (String::new(), Style::DashedLike(own)),
                    };
                    series.push(Series { name, points, style });
                }
            }
            for point in path.critical.iter().flatten().filter(|point| point.position >= path.start) {
                let places = critical.iter_mut().find(|(kind, _)| *kind == point.kind);
                let at = value_at(&path.rows, [position, column], point.position);
                if let (Some(x), Some((_, places))) = (at, places) {
                    places.push((x - start, point.load_factor));
                }
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
        title: title(model, if paths.len() > 1 { "equilibrium paths" } else { "equilibrium path" }),
        x_label: with_unit("displacement", model.output.units.length.as_deref()),
        y_label: "load factor".into(),
        series,
        note: "Dashed: negative eigenvalues of the tangent, of its symmetric part under loads without a potential.".into(),
        ..LinePlot::default()
    };
    lines(&folder.join("load_displacement.png"), &plot)
}

/// Distance from a curve that is drawn, over the size of the picture, within which points are not drawn again: dashes would fill each other's gaps.
const DRAWN: f64 = 3e-3;
/// Length of a curve between two of its points, over the size of the picture, from which on they are compared.
const APART: f64 = 5.0 * DRAWN;

/// Sizes of curves in both directions.
fn extent(curves: &[Vec<(f64, f64)>]) -> [f64; 2] {
    let size = |of: fn(&(f64, f64)) -> f64| {
        let values = || curves.iter().flatten().map(of).filter(|x| x.is_finite());
        values()
            .max_by(f64::total_cmp)
            .zip(values().min_by(f64::total_cmp))
            .map_or(0.0, |(most, least)| most - least)
    };
    [size(|p| p.0), size(|p| p.1)].map(|size| if size > 0.0 { size } else { 1.0 })
}

/// Parts of a curve that do not lie on curves that are drawn, with the points on both sides of each.
fn new_parts(
    points: &[(f64, f64)],
    drawn: &[Vec<(f64, f64)>],
    size: [f64; 2],
) -> Vec<std::ops::Range<usize>> {
    let scaled = |p: &(f64, f64)| [p.0 / size[0], p.1 / size[1]];
    let is_near = |p: [f64; 2], a: [f64; 2], b: [f64; 2]| {
        let (way, from) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
        let length = way[0] * way[0] + way[1] * way[1];
        let part =
            if length > 0.0 { ((from[0] * way[0] + from[1] * way[1]) / length).clamp(0.0, 1.0) } else { 0.0 };
        (from[0] - part * way[0]).hypot(from[1] - part * way[1]) <= DRAWN
    };
    let lies_on = |p: [f64; 2], pair: &[(f64, f64)]| is_near(p, scaled(&pair[0]), scaled(&pair[1]));
    // Length of the curve itself up to each point: where it runs back on itself it is drawn already.
    let mut length = 0.0;
    let lengths: Vec<f64> = (0..points.len())
        .map(|i| {
            if let Some(before) = i.checked_sub(1) {
                let [a, b] = [before, i].map(|i| scaled(&points[i]));
                length += (b[0] - a[0]).hypot(b[1] - a[1]);
            }
            length
        })
        .collect();
    let is_drawn = |i: usize| {
        let p = scaled(&points[i]);
        let own = (1..i).filter(|&j| lengths[j] < lengths[i] - APART);
        drawn.iter().any(|curve| curve.windows(2).any(|pair| lies_on(p, pair)))
            || own.into_iter().any(|j| lies_on(p, &points[j - 1..=j]))
    };
    let mut parts: Vec<std::ops::Range<usize>> = Vec::new();
    for i in (0..points.len()).filter(|i| !is_drawn(*i)) {
        let around = i.saturating_sub(1)..(i + 2).min(points.len());
        match parts.last_mut() {
            Some(last) if around.start < last.end => last.end = around.end,
            _ => parts.push(around),
        }
    }
    parts
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
    fn curves_are_drawn_once() {
        let line: Vec<(f64, f64)> = (0..=10).map(|i| (f64::from(i), 0.0)).collect();
        let leaving: Vec<(f64, f64)> =
            [(1.5, 0.0), (2.5, 0.0), (3.0, 4.0), (4.0, 9.0), (5.5, 0.0), (6.5, 0.0)].into();
        let size = extent(&[line.clone(), leaving.clone()]);
        assert_eq!(size, [10.0, 9.0]);
        let parts = |points: &[(f64, f64)], drawn: &[Vec<(f64, f64)>]| -> Vec<(usize, usize)> {
            new_parts(points, drawn, size).into_iter().map(|part| (part.start, part.end)).collect()
        };
        assert_eq!(parts(&leaving, std::slice::from_ref(&line)), [(1, 5)]);
        assert_eq!(parts(&line, &[]), [(0, 11)]);
        assert_eq!(parts(&line, std::slice::from_ref(&line)), []);
        let there_and_back: Vec<(f64, f64)> =
            (0..=20).map(|i| (10.0 - f64::from(i - 10).abs(), 0.0)).collect();
        assert_eq!(parts(&there_and_back, &[]), [(0, 12)]);
    }

    #[test]
    fn pieces_share_the_points_between_them() {
        let points: Vec<(f64, f64)> = (0..6).map(|i| (f64::from(i), 0.0)).collect();
        let found = runs(&points, |i| i == 2 || i == 3);
        let lengths: Vec<_> = found.iter().map(|(is, run)| (*is, run[0].0, run.len())).collect();
        assert_eq!(lengths, [(false, 0.0, 3), (true, 2.0, 3), (false, 4.0, 2)]);
    }
}
