//! Table and picture of a locking study.

use std::fmt::Write as _;
use std::path::Path;

use super::Row;
use tegula_io::out::OutputError;
use tegula_io::plot::{Group, HeatMap, heat_map};

/// All rows as comma-separated values.
pub fn csv(rows: &[Row]) -> String {
    let mut out = String::from("example,element,without,slenderness,mesh,deflection_over_exact\n");
    for r in rows {
        let [nu, nv] = r.example.elements(r.mesh);
        let _ = writeln!(
            out,
            "{},{},{},{},{nu}x{nv},{:.9}",
            r.example.name(),
            r.element.name(),
            r.without.name(),
            r.slenderness,
            r.ratio
        );
    }
    out
}

/// First rows of the lines of the table; the rows of a line differ in the mesh only.
fn lines(rows: &[Row]) -> Vec<&Row> {
    let mut out: Vec<&Row> = Vec::new();
    for r in rows {
        if !out.iter().any(|o| (o.element, o.without) == (r.element, r.without)) {
            out.push(r);
        }
    }
    out
}

fn columns(rows: &[Row]) -> Vec<&Row> {
    let mut out: Vec<&Row> = Vec::new();
    for r in rows {
        if !out.iter().any(|o| (o.example, o.slenderness, o.mesh) == (r.example, r.slenderness, r.mesh)) {
            out.push(r);
        }
    }
    out
}

fn find<'a>(rows: &'a [Row], line: &Row, column: &Row) -> Option<&'a Row> {
    rows.iter().find(|r| {
        (r.element, r.without, r.example, r.slenderness, r.mesh)
            == (line.element, line.without, column.example, column.slenderness, column.mesh)
    })
}

/// Tables in Markdown, one for each example and slenderness: elements and remedies by meshes.
pub fn markdown(rows: &[Row]) -> String {
    let mut out = String::new();
    let mut done = Vec::new();
    for c in columns(rows) {
        if done.contains(&(c.example, c.slenderness)) {
            continue;
        }
        done.push((c.example, c.slenderness));
        let meshes: Vec<&Row> = columns(rows)
            .into_iter()
            .filter(|o| (o.example, o.slenderness) == (c.example, c.slenderness))
            .collect();
        let _ = write!(
            out,
            "{}**{}, {} = {}: deflection over the exact one**\n\n| element | remedies |",
            if out.is_empty() { "" } else { "\n" },
            c.example.title(),
            c.example.slenderness(),
            c.slenderness
        );
        for m in &meshes {
            let [nu, nv] = m.example.elements(m.mesh);
            let _ = write!(out, " {nu}×{nv} |");
        }
        out.push_str("\n|:--|:--|");
        out.push_str(&"--:|".repeat(meshes.len()));
        out.push('\n');
        for line in lines(rows) {
            let _ = write!(out, "| `{}` | {} |", line.element.name(), line.without.title());
            for m in &meshes {
                match find(rows, line, m) {
                    Some(r) => drop(write!(out, " {} |", number(r.ratio, 4))),
                    None => out.push_str(" |"),
                }
            }
            out.push('\n');
        }
    }
    out
}

/// A ratio with digits that a reader can compare; what is tiny as a power of ten.
fn number(ratio: f64, digits: usize) -> String {
    if ratio.abs() < 0.5 * 10_f64.powi(-(digits as i32)) {
        format!("{ratio:.0e}")
    } else {
        format!("{ratio:.digits$}")
    }
}

/// Draws the study on one of its meshes: elements and remedies by examples and slenderness.
///
/// # Errors
/// The file cannot be written.
pub fn picture(path: &Path, rows: &[Row], mesh: u32) -> Result<(), OutputError> {
    let columns: Vec<&Row> = columns(rows).into_iter().filter(|c| c.mesh == mesh).collect();
    let lines = lines(rows);
    let mut map = HeatMap {
        title: "Each remedy cures one kind of locking".into(),
        note: format!(
            "Computed over exact deflection; plate {mesh}×{mesh} elements, arch and beam {mesh}×1. 1.00 is right, 0 does not move."
        ),
        values: lines
            .iter()
            .map(|line| columns.iter().map(|c| find(rows, line, c).map_or(f64::NAN, |r| r.ratio)).collect())
            .collect(),
        ..HeatMap::default()
    };
    for line in &lines {
        Group::add(&mut map.rows, line.element.name(), line.without.title());
    }
    for c in &columns {
        let head = format!("{}, {}", c.example.title(), c.example.slenderness());
        Group::add(&mut map.columns, &head, &c.slenderness.to_string());
    }
    heat_map(path, &map)
}
