//! From input files of other programs to the text of model files: what the formats have in common.
//!
//! | file | is |
//! |---|---|
//! | `document` | the text, with the lines that it comes from |
//! | `supports` | from fixed degrees of freedom to components of nodal vectors |
//! | `loads`, `materials`, `sections`, `analyses` | tables of the model file |

pub(crate) mod analyses;
pub(crate) mod document;
pub(crate) mod loads;
pub(crate) mod materials;
pub(crate) mod sections;
pub(crate) mod supports;

use std::collections::BTreeMap;
use std::path::Path;

use tegula::Issue;

use self::document::{Document, quoted};
use crate::mesh::MeshError;
use crate::mesh::numbered::shown;

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

/// Keywords with their lines; `star` stands before each of them.
pub(crate) fn listed<'a>(star: &str, cards: impl Iterator<Item = (&'a str, usize)>) -> String {
    let mut lines: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for (keyword, line) in cards {
        lines.entry(keyword).or_default().push(line.to_string());
    }
    let named = |(keyword, lines): (&str, Vec<String>)| {
        let word = if lines.len() == 1 { "line" } else { "lines" };
        format!("{star}{} ({word} {})", shown(keyword), lines.join(", "))
    };
    lines.into_iter().map(named).collect::<Vec<_>>().join(", ")
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
