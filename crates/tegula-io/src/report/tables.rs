//! Tables of a report, as HTML, and labels of shapes.

use super::checks::{Verdict, of};
use crate::job::{ForceResult, Summary};
use crate::out::numbers::significant;
use crate::out::vtu::escape;

/// Digits of numbers in tables.
const DIGITS: usize = 7;
/// Most rows of a table.
const MOST_ROWS: usize = 500;

/// Labels of modes by their time values.
pub(super) fn mode_labels(summary: &Summary, values: &[f64]) -> Vec<String> {
    let (found, name) = match (&summary.frequencies_hz, &summary.load_factors) {
        (Some(found), _) => (found.as_slice(), "f"),
        (None, Some(found)) => (found.as_slice(), "λ"),
        (None, None) => (&[][..], ""),
    };
    let label = |value: &f64| {
        let number = value.floor();
        let found = found.get((number as usize).wrapping_sub(1));
        found.map_or(format!("mode {number}"), |x| {
            format!("mode {number}: {name} = {}", significant(*x, DIGITS))
        })
    };
    values.iter().map(label).collect()
}

/// Labels of the modes of critical points by their time values.
pub(super) fn critical_labels(summary: &Summary, values: &[f64]) -> Vec<String> {
    let points = summary.critical_points.as_deref().unwrap_or_default();
    let label = |value: &f64| {
        let number = value.floor();
        let point = points.get((number as usize).wrapping_sub(1));
        point.map_or(format!("point {number}"), |p| {
            format!("point {number}: {} at λ = {}", p.kind.name(), significant(p.load_factor, DIGITS))
        })
    };
    values.iter().map(label).collect()
}

/// A table with a caption; nothing without rows.
pub(super) fn table(caption: &str, head: &[&str], rows: &[Vec<String>]) -> String {
    if rows.is_empty() {
        return String::new();
    }
    let cells = |tag: &str, row: &[String]| -> String {
        row.iter().map(|text| format!("<{tag}>{}</{tag}>", escape(text))).collect()
    };
    let head: Vec<String> = head.iter().map(|&text| text.into()).collect();
    let body: String =
        rows.iter().take(MOST_ROWS).map(|row| format!("<tr>{}</tr>\n", cells("td", row))).collect();
    let more = if rows.len() > MOST_ROWS {
        format!("<p>{} rows more.</p>", rows.len() - MOST_ROWS)
    } else {
        String::new()
    };
    format!(
        "<div class=\"wide\"><table><caption>{}</caption><thead><tr>{}</tr></thead><tbody>\n{body}</tbody></table>{more}</div>\n",
        escape(caption),
        cells("th", &head)
    )
}

/// Checks and warnings of a run.
pub(super) fn checks(summary: &Summary) -> String {
    let row = |check: super::checks::Check| {
        let (class, mark) = match check.verdict {
            Verdict::Good => ("good", "✓"),
            Verdict::Doubtful => ("doubtful", "!"),
            Verdict::Bad => ("bad", "✗"),
            Verdict::Fact => ("fact", ""),
        };
        format!(
            "<tr class=\"{class}\"><td>{mark}</td><th scope=\"row\">{}</th><td>{}</td></tr>\n",
            escape(check.name),
            escape(&check.value)
        )
    };
    let rows: String = of(summary).into_iter().map(row).collect();
    format!("<table class=\"checks\"><tbody>\n{rows}</tbody></table>\n{}", warnings(&summary.warnings))
}

/// List of warnings; nothing without any.
pub(super) fn warnings(found: &[String]) -> String {
    if found.is_empty() {
        return String::new();
    }
    let items: String = found.iter().map(|w| format!("<li>{}</li>\n", escape(w))).collect();
    format!("<h3>Warnings</h3>\n<ul class=\"warnings\">{items}</ul>\n")
}

/// Results at the end of a run.
pub(super) fn results(s: &Summary) -> String {
    let numbers = |x: &[f64]| x.iter().map(|x| significant(*x, DIGITS)).collect::<Vec<_>>();
    let named = |name: &str, values: &[&[f64]]| {
        let mut row = vec![name.to_owned()];
        row.extend(values.iter().flat_map(|v| numbers(v)));
        row
    };
    let points: Vec<_> = s.points.iter().map(|(n, p)| named(n, &[&p.displacement, &p.position])).collect();
    let mut out = table("Points at the end", &["point", "u x", "u y", "u z", "x", "y", "z"], &points);
    let forces = |found: &std::collections::BTreeMap<String, ForceResult>| -> Vec<Vec<String>> {
        found.iter().map(|(n, f)| named(n, &[&f.force, &f.moment, &f.about])).collect()
    };
    let head = ["set", "force x", "y", "z", "moment x", "y", "z", "about x", "y", "z"];
    out += &table("Reactions at the end", &head, &forces(&s.supports));
    out += &table("Loads at the end", &head, &forces(&s.loads));
    out += &table("Section forces at the end", &head, &forces(&s.cuts));
    let counted = |found: &Option<Vec<f64>>| -> Vec<Vec<String>> {
        let values = found.iter().flatten().enumerate();
        values.map(|(i, x)| vec![(i + 1).to_string(), significant(*x, 9)]).collect()
    };
    out += &table("Natural frequencies", &["mode", "cycles per unit of time"], &counted(&s.frequencies_hz));
    out += &table("Load factors of buckling", &["mode", "load factor"], &counted(&s.load_factors));
    let critical = s.critical_points.iter().flatten().enumerate().map(|(i, p)| {
        vec![
            (i + 1).to_string(),
            p.kind.name().into(),
            significant(p.load_factor, 9),
            significant(p.position, DIGITS),
        ]
    });
    out += &table(
        "Critical points of the path",
        &["number", "kind", "load factor", "position on the path"],
        &critical.collect::<Vec<_>>(),
    );
    out
}
