//! Rows of a verification and how they are written.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use serde::Serialize;
use tegula::norm::larger;

use super::statistics::{self, Counters};

/// Standard by which a value is judged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// |value − reference| ≤ tolerance · |reference|.
    Relative,
    /// |value − reference| ≤ tolerance.
    Absolute,
    /// value ≤ reference.
    AtMost,
}

/// One compared value.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// Case of the command line that computed it.
    pub run: String,
    /// Case, or a part of it.
    pub case: String,
    /// Quantity.
    pub quantity: String,
    /// Element type and switches.
    pub element: String,
    /// Mesh.
    pub mesh: String,
    /// Computed value.
    pub value: f64,
    /// Value of the reference, or the limit.
    pub reference: f64,
    /// Tolerance.
    pub tolerance: f64,
    /// How the two are compared.
    pub verdict: Verdict,
    /// The value holds.
    pub pass: bool,
}

impl Row {
    /// Difference as the verdict counts it.
    pub fn difference(&self) -> f64 {
        match self.verdict {
            Verdict::Relative => (self.value - self.reference).abs() / self.reference.abs(),
            Verdict::Absolute | Verdict::AtMost => self.value - self.reference,
        }
    }

    /// Difference over what is allowed (value over limit), above 1 for a miss; 0 where nothing but equality is allowed and met.
    pub fn use_of_tolerance(&self) -> f64 {
        match self.verdict {
            Verdict::AtMost if self.pass && self.value == 0.0 => 0.0,
            Verdict::AtMost => self.value / self.reference,
            _ if self.pass && self.tolerance == 0.0 => 0.0,
            _ => self.difference().abs() / self.tolerance,
        }
    }

    /// One line of a table.
    pub fn line(&self) -> String {
        let reference = match self.verdict {
            Verdict::AtMost => format!("<= {:.6e}", self.reference),
            _ => format!("{:.9e}", self.reference),
        };
        format!(
            "{} {:<22} {:<44} {:<12} {:<8} {:>17} {:>17} {:>10} {:>8}",
            if self.pass { "ok  " } else { "MISS" },
            self.case,
            self.quantity,
            self.element,
            self.mesh,
            format!("{:.9e}", self.value),
            reference,
            format!("{:.1e}", self.difference()),
            if self.verdict == Verdict::AtMost { String::new() } else { format!("{:.0e}", self.tolerance) },
        )
    }

    /// Heading of the lines.
    pub fn heading() -> String {
        format!(
            "     {:<22} {:<44} {:<12} {:<8} {:>17} {:>17} {:>10} {:>8}",
            "case", "quantity", "element", "mesh", "value", "reference", "difference", "allowed"
        )
    }
}

/// A table that a case makes for readers.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Table {
    /// File name in the book, without ending.
    pub name: String,
    /// Heading.
    pub title: String,
    /// Heads of the columns.
    pub columns: Vec<String>,
    /// Cells by rows.
    pub cells: Vec<Vec<String>>,
}

impl Table {
    /// An empty table.
    pub fn new(name: &str, title: &str, columns: &[&str]) -> Self {
        let columns = columns.iter().map(|c| (*c).into()).collect();
        Self { name: name.into(), title: title.into(), columns, cells: Vec::new() }
    }

    /// The table in Markdown, columns aligned for the terminal as well.
    pub fn markdown(&self) -> String {
        let rows = || std::iter::once(&self.columns).chain(&self.cells);
        let width = |c: usize| rows().filter_map(|r| r.get(c)).map(|t| t.chars().count()).max().unwrap_or(0);
        let widths: Vec<usize> = (0..self.columns.len()).map(width).collect();
        let mut out = format!("**{}**\n\n", self.title);
        for (i, row) in rows().enumerate() {
            for (c, w) in widths.iter().enumerate() {
                let text = row.get(c).map_or("", String::as_str);
                let _ = write!(out, "| {text}{} ", " ".repeat(w - text.chars().count()));
            }
            out.push_str("|\n");
            if i == 0 {
                for (c, w) in widths.iter().enumerate() {
                    out.push_str(if c == 0 { "|:" } else { "|-" });
                    out.push_str(&"-".repeat(*w));
                    out.push_str(if c == 0 { "-" } else { ":" });
                }
                out.push_str("|\n");
            }
        }
        out
    }
}

/// Rows of all cases run.
#[derive(Debug, Clone, Default)]
pub struct Report {
    rows: Vec<Row>,
    tables: Vec<Table>,
    pictures: Option<PathBuf>,
    element: String,
    run: &'static str,
    counters: Vec<(&'static str, Vec<Counters>)>,
}

impl Report {
    /// An empty report; figures go to `pictures`.
    pub fn new(pictures: Option<&Path>) -> Self {
        Self {
            rows: Vec::new(),
            tables: Vec::new(),
            pictures: pictures.map(Path::to_path_buf),
            element: "ems".into(),
            run: "",
            counters: Vec::new(),
        }
    }

    /// The rows.
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// The tables that cases made for readers.
    pub fn tables(&self) -> &[Table] {
        &self.tables
    }

    /// Adds a table for readers.
    pub fn table(&mut self, table: Table) {
        self.tables.push(table);
    }

    /// True if every value holds.
    pub fn passed(&self) -> bool {
        !self.rows.is_empty() && self.rows.iter().all(|r| r.pass)
    }

    /// Path of a figure, if figures are wanted.
    pub fn picture(&self, name: &str) -> Option<PathBuf> {
        self.pictures.as_ref().map(|p| p.join(name))
    }

    /// Case of the command line of the rows that follow.
    pub(super) fn begin(&mut self, run: &'static str) {
        self.run = run;
    }

    /// Element name of the rows that follow.
    pub fn element(&mut self, name: &str) {
        self.element = name.to_lowercase();
    }

    /// A value equal to a reference within a relative tolerance.
    pub fn relative(
        &mut self,
        case: &str,
        quantity: &str,
        mesh: &str,
        value: f64,
        reference: f64,
        tolerance: f64,
    ) {
        let pass = (value - reference).abs() <= tolerance * reference.abs();
        self.push(case, quantity, mesh, (value, reference, tolerance), Verdict::Relative, pass);
    }

    /// A value equal to a reference within an absolute tolerance.
    pub fn absolute(
        &mut self,
        case: &str,
        quantity: &str,
        mesh: &str,
        value: f64,
        reference: f64,
        tolerance: f64,
    ) {
        let pass = (value - reference).abs() <= tolerance;
        self.push(case, quantity, mesh, (value, reference, tolerance), Verdict::Absolute, pass);
    }

    /// A value that must not exceed a limit.
    pub fn at_most(&mut self, case: &str, quantity: &str, mesh: &str, value: f64, limit: f64) {
        self.push(case, quantity, mesh, (value, limit, 0.0), Verdict::AtMost, value <= limit);
    }

    /// A case that could not be computed.
    pub fn failed(&mut self, case: &str, reason: &str) {
        self.push(case, reason, "", (f64::NAN, 0.0, 0.0), Verdict::Absolute, false);
    }

    fn push(
        &mut self,
        case: &str,
        quantity: &str,
        mesh: &str,
        (value, reference, tolerance): (f64, f64, f64),
        verdict: Verdict,
        pass: bool,
    ) {
        self.rows.push(Row {
            run: self.run.into(),
            case: case.into(),
            quantity: quantity.into(),
            element: self.element.clone(),
            mesh: mesh.into(),
            value,
            reference,
            tolerance,
            verdict,
            pass,
        });
    }

    /// The rows as JSON.
    pub fn json(&self) -> serde_json::Value {
        serde_json::json!(self.rows)
    }

    /// Adds the run counters of a case.
    pub fn count(&mut self, case: &'static str, counters: Vec<Counters>) {
        self.counters.push((case, counters));
    }

    /// Run counters of all analyses, as `verification/statistics.txt` keeps them.
    pub fn statistics(&self) -> String {
        statistics::table(&self.counters)
    }

    /// A Markdown table with one line a case: values compared, missed, and how near the worst came to what is allowed.
    pub fn summary(&self) -> String {
        let mut out = String::from(
            "| case | values | missed | worst use of a tolerance or limit |\n|---|---:|---:|---:|\n",
        );
        let mut cases: Vec<&str> = Vec::new();
        for row in &self.rows {
            if !cases.contains(&row.case.as_str()) {
                cases.push(&row.case);
            }
        }
        for case in cases {
            let rows = || self.rows.iter().filter(|r| r.case == case);
            let missed = rows().filter(|r| !r.pass).count();
            let worst = rows().map(|r| r.use_of_tolerance()).reduce(larger).unwrap_or(f64::NAN);
            let _ = writeln!(out, "| {case} | {} | {missed} | {:.0} % |", rows().count(), 100.0 * worst);
        }
        let missed = self.rows.iter().filter(|r| !r.pass).count();
        let _ = writeln!(out, "\n{} values compared, {missed} missed.", self.rows.len());
        out
    }

    /// The rows as Markdown tables, one a case.
    pub fn markdown(&self) -> String {
        let mut out = format!("# Verification\n\n{}", self.summary());
        for table in &self.tables {
            let _ = write!(out, "\n{}", table.markdown());
        }
        let mut case = "";
        for row in &self.rows {
            if row.case != case {
                case = &row.case;
                let _ = write!(
                    out,
                    "\n## {case}\n\n| quantity | element | mesh | value | reference | difference | allowed | |\n|---|---|---|---:|---:|---:|---:|---|\n"
                );
            }
            let (reference, allowed) = match row.verdict {
                Verdict::AtMost => (format!("≤ {:.3e}", row.reference), String::new()),
                _ => (format!("{:.9e}", row.reference), format!("{:.0e}", row.tolerance)),
            };
            let _ = writeln!(
                out,
                "| {} | {} | {} | {:.9e} | {reference} | {:.1e} | {allowed} | {} |",
                row.quantity,
                row.element,
                row.mesh,
                row.value,
                row.difference(),
                if row.pass { "ok" } else { "**miss**" }
            );
        }
        out
    }
}
