//! From input files of other programs to the text of model files: what the formats have in common.
//!
//! | file | is |
//! |---|---|
//! | `document` | the text, with the lines that it comes from |
//! | `supports` | from fixed degrees of freedom to components of nodal vectors |
//! | `held` | from fixed degrees of freedom of bodies and beams to joints |
//! | `bars`, `loads`, `materials`, `sections`, `analyses` | tables of the model file |

pub(crate) mod analyses;
pub(crate) mod bars;
pub(crate) mod document;
pub(crate) mod held;
pub(crate) mod loads;
pub(crate) mod materials;
pub(crate) mod sections;
pub(crate) mod supports;

use std::collections::BTreeMap;
use std::path::Path;

use tegula::Issue;

use self::analyses::StepAnalysis;
use self::document::{Document, quoted};
use self::loads::Load;
use crate::mesh::MeshError;
use crate::mesh::numbered::{Reader, shown};

/// Text of a model file made of an input file.
#[derive(Debug, Clone, PartialEq)]
pub struct Converted {
    /// The text.
    pub text: String,
    /// Line of the input file that each line of the text comes from, counted from 1; 0 for none.
    pub lines: Vec<usize>,
    /// Warnings: requests that are not read, and steps that programs understand differently.
    pub warnings: Vec<Issue>,
}

/// Errors of the parts of a file, which are reported together.
pub(crate) struct Errors<'e>(pub &'e mut Vec<MeshError>);

impl Errors<'_> {
    /// The value, or nothing where it is an error.
    pub fn value<T>(&mut self, of: Result<T, MeshError>) -> Option<T> {
        of.map_err(|error| self.0.push(error)).ok()
    }

    /// Adds an error.
    pub fn add(&mut self, error: Option<MeshError>) {
        self.0.extend(error);
    }
}

/// The errors without repetition.
pub(crate) fn distinct(errors: Vec<MeshError>) -> Vec<MeshError> {
    let mut out: Vec<MeshError> = Vec::new();
    for error in errors {
        if !out.contains(&error) {
            out.push(error);
        }
    }
    out
}

/// Most lines of one keyword that a message lists.
const MOST_LINES: usize = 20;

/// Keywords with their lines, of which many are counted; `star` stands before each of them.
pub(crate) fn listed<'a>(star: &str, cards: impl Iterator<Item = (&'a str, usize)>) -> String {
    let mut lines: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for (keyword, line) in cards {
        lines.entry(keyword).or_default().push(line.to_string());
    }
    let named = |(keyword, lines): (&str, Vec<String>)| {
        let word = if lines.len() == 1 { "line" } else { "lines" };
        let more = match lines.len().saturating_sub(MOST_LINES) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        let first: Vec<String> = lines.into_iter().take(MOST_LINES).collect();
        format!("{star}{} ({word} {}{more})", shown(keyword), first.join(", "))
    };
    lines.into_iter().map(named).collect::<Vec<_>>().join(", ")
}

/// One error for all cards that are not read; `star` stands before each of them.
pub(crate) fn unread<'a>(
    reader: &Reader<'_>,
    star: &str,
    cards: impl Iterator<Item = (&'a str, usize)> + Clone,
) -> Option<MeshError> {
    let (_, line) = cards.clone().next()?;
    Some(reader.error(
        line,
        format!("these cards are not read: {}", listed(star, cards)),
        "remove them, and add their counterparts to the model file that `tegula convert` writes of the rest",
    ))
}

/// The table `[mesh]`, of the first `card` of a node.
pub(crate) fn write_mesh(out: &mut Document, line: usize, card: &str, kind: &str, file: &str) {
    out.table(line, "[mesh]", card);
    out.key(line, "type", &quoted(kind));
    out.key(line, "file", &quoted(file));
}

/// Writes the loads of a single analysis, or of each step with its analysis; `card` begins a step.
pub(crate) fn write_steps(out: &mut Document, card: &str, analyses: &[StepAnalysis], loads: &[Vec<Load>]) {
    let single = analyses.len() == 1;
    for (analysis, loads) in analyses.iter().zip(loads) {
        if !single {
            out.table(analysis.line, "[[steps]]", card);
            if !analysis.name.is_empty() {
                out.key(analysis.line, "name", &quoted(&analysis.name));
            }
            analysis.write(out, "[steps.analysis]");
        }
        let head = if single { "[[loads]]" } else { "[[steps.loads]]" };
        loads.iter().for_each(|load| load.write(out, head));
    }
}

/// Warning of parts of an input file without effect.
pub(crate) fn without_effect(what: &str, list: &str) -> Option<Issue> {
    let help = "results are those of `[output]` in the model file, which `tegula convert` writes";
    let message = format!("{what} of the input file without effect: {list}");
    (!list.is_empty()).then(|| Issue::new("", message, help))
}

/// A point whose displacements are recorded.
pub(crate) struct Point {
    /// Name in results.
    pub name: String,
    /// Number of the node.
    pub node: u64,
    /// Line that asks for it.
    pub line: usize,
}

/// Writes the recorded points.
pub(crate) fn write_points(out: &mut Document, points: &[Point], card: &str) {
    for point in points {
        out.table(point.line, "[[output.points]]", card);
        out.key(point.line, "name", &quoted(&point.name));
        out.key(point.line, "on", &quoted(&point.node.to_string()));
    }
}

/// Comment at the beginning.
pub(crate) fn head(out: &mut Document, path: &Path) {
    let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
    let plain: String = name.chars().filter(|c| !c.is_control()).collect();
    out.line(
        0,
        &format!("# Model of the input file {plain}. Comments tell the lines that the tables come from."),
    );
}
