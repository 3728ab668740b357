//! Reports of runs and of models: one HTML file, of a run with checks, the shapes in three dimensions, curves, results and the model file; of a
//! model with its mesh, supports, loads and sets.
//!
//! The file needs no network and no other file. Numbers of the shapes are rounded to 16 bits of the range of each field, those of
//! curves and tables are not rounded. The shapes are drawn by WebGL 2 (`assets/report/viewer.js`), the curves by uPlot, which is part of the
//! program (`assets/report/uPlot-LICENSE.txt`).

// Tests may unwrap; the code they test may not.
#![cfg_attr(test, allow(clippy::unwrap_used))]

mod blocks;
mod checks;
mod history;
mod marks;
mod model;
mod page;
mod scene;
mod tables;

use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::deck::Deck;
use crate::job::{self, CriticalResult, JobError, Summary};
use crate::out::{OutputError, write_whole};
use blocks::Blocks;
use history::Table;
use scene::{Kind, List, Scene};

pub(crate) use page::{STYLE, VIEWER_SCRIPTS, colours};

/// Characters of all blocks of a report beyond which no fields are added.
const MOST_CHARACTERS: usize = 28_000_000;

/// Bytes of the displacements of a report before compression.
const MOST_BYTES: usize = 24 << 20;
/// Characters of a model file beyond which its end is not shown.
const MOST_OF_MODEL: usize = 1_000_000;

/// One analysis of a report.
#[derive(Debug, Serialize)]
struct Part {
    /// Name of its folder, empty where there is one analysis only.
    name: String,
    analysis: String,
    history: Option<Table>,
    response: Option<Table>,
    modes: Option<Table>,
    critical_points: Vec<CriticalResult>,
    scenes: Vec<Scene>,
    #[serde(skip)]
    summary: Summary,
}

/// A report, and a list of its omissions.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Report {
    /// Pieces of the HTML file in their order.
    pub page: Vec<String>,
    /// Omissions, in words.
    pub omissions: Vec<String>,
}

impl Report {
    /// Report of a result folder. Fields are left out that would make it longer than about `most` characters, but for the displacements.
    ///
    /// # Errors
    /// The folder holds no result of this program, or one of its files is damaged.
    pub fn of(folder: &Path, most: usize) -> Result<Self, OutputError> {
        let summary = Summary::read(folder)?;
        let mut blocks = Blocks::default();
        let folders = folders(&summary, folder);
        let count = folders.len().max(1);
        let mut parts = Vec::new();
        for (i, (name, folder)) in folders.into_iter().enumerate() {
            let summary = Summary::read(&folder)?;
            let bytes = MOST_BYTES.min(most) / count;
            parts.push(part(name, &folder, summary, (&mut blocks, most / count * (i + 1), bytes))?);
        }
        let omissions = omissions(&parts);
        let page = page::page(&summary, &parts, &blocks, model_text(&summary).as_deref(), &omissions);
        Ok(Self { page, omissions })
    }

    /// Report of a model that has not been run. Its mesh is left out where the report would be longer than about `most` characters.
    ///
    /// # Errors
    /// Everything that is wrong with the model, at its places in the file.
    pub fn of_model(deck: &Deck, most: usize) -> Result<Self, JobError> {
        Ok(model::report(deck, &job::prepare(deck)?, most))
    }

    /// Writes the report to a file, whole or not at all.
    fn save(&self, file: &Path) -> Result<(), OutputError> {
        write_whole(file, |w| self.page.iter().try_for_each(|text| w.write_all(text.as_bytes())))
    }
}

/// Writes the report of a result folder to `file`, whole or not at all, and returns what it does not show, in words.
///
/// # Errors
/// The folder holds no result of this program, one of its files is damaged, or the report cannot be written.
pub fn write(folder: &Path, file: &Path) -> Result<Vec<String>, OutputError> {
    let report = Report::of(folder, MOST_CHARACTERS)?;
    report.save(file)?;
    Ok(report.omissions)
}

/// Writes the report of a model that has not been run to `file`, whole or not at all, and returns what it does not show, in words.
///
/// # Errors
/// The model is wrong, or the report cannot be written.
pub fn write_model(deck: &Deck, file: &Path) -> Result<Vec<String>, JobError> {
    let report = Report::of_model(deck, MOST_CHARACTERS)?;
    report.save(file)?;
    Ok(report.omissions)
}

/// Names and folders of the analyses: those of `[[steps]]`, or the only one; behind each path its branches.
fn folders(summary: &Summary, folder: &Path) -> Vec<(String, PathBuf)> {
    let begun = summary.analyses.iter().filter(|step| step.status.is_some());
    let mut own: Vec<(String, PathBuf)> =
        begun.map(|step| (step.folder.clone(), folder.join(&step.folder))).collect();
    if own.is_empty() {
        own.push((String::new(), folder.to_owned()));
    }
    let mut out = Vec::new();
    for (name, folder) in own {
        let branches = Summary::read(&folder).map(|s| s.branches).unwrap_or_default();
        out.push((name.clone(), folder.clone()));
        let begun = branches.iter().filter(|branch| branch.status.is_some());
        out.extend(begun.map(|branch| {
            let own =
                if name.is_empty() { branch.folder.clone() } else { format!("{name}/{}", branch.folder) };
            (own, folder.join(&branch.folder))
        }));
    }
    out.retain(|(_, folder)| folder.join("summary.json").is_file());
    out
}

fn part(
    name: String,
    folder: &Path,
    summary: Summary,
    (blocks, most, most_bytes): (&mut Blocks, usize, usize),
) -> Result<Part, OutputError> {
    let parameter = match summary.analysis.as_str() {
        "transient" => "time",
        "path" => "position on the path",
        _ => "load factor",
    };
    let deformed = summary.deformed;
    let states = List {
        name: "States",
        shells: "fields.pvd",
        bodies: "bodies.pvd",
        kind: Kind::States,
        parameter,
        deformed,
        most_bytes,
    };
    let modes = List {
        name: "Modes",
        shells: "modes.pvd",
        bodies: "mode_bodies.pvd",
        kind: Kind::Modes,
        parameter: "mode",
        ..states
    };
    let critical = List {
        name: "Critical modes",
        shells: "critical_modes.pvd",
        bodies: "critical_mode_bodies.pvd",
        ..modes
    };
    let history = history::read(&folder.join("history.csv"), blocks)?;
    let response = history::read(&folder.join("frequency_response.csv"), blocks)?;
    let table = history::read(&folder.join("modes.csv"), blocks)?;
    let mut scenes = Vec::new();
    for list in [states, modes, critical] {
        let Some(mut scene) = scene::read(folder, list, blocks, most)? else { continue };
        scene.labels = match list.name {
            "Modes" => tables::mode_labels(&summary, &scene.values),
            "Critical modes" => tables::critical_labels(&summary, &scene.values),
            _ if summary.analysis == "path" => history::loads_at(&folder.join("history.csv"), &scene.values)?,
            _ => Vec::new(),
        };
        scenes.push(scene);
    }
    let critical_points = summary.critical_points.clone().unwrap_or_default();
    let analysis = summary.analysis.clone();
    Ok(Part { name, analysis, history, response, modes: table, critical_points, scenes, summary })
}

/// Omissions of a report, in words.
fn omissions(parts: &[Part]) -> Vec<String> {
    let mut out = Vec::new();
    for part in parts {
        let of = if part.name.is_empty() { String::new() } else { format!(" of {}", part.name) };
        for scene in &part.scenes {
            let shown = scene.values.len();
            if shown < scene.available {
                out.push(format!("It shows {shown} of the {} states{of}.", scene.available));
            }
            if !scene.left_out.is_empty() {
                out.push(format!("The fields {}{of} had no room in it.", scene.left_out.join(", ")));
            }
        }
        if let Some(history) = part.history.as_ref().filter(|h| h.rows < h.available) {
            out.push(format!(
                "Curves have {} of the {} rows of the history{of}.",
                history.rows, history.available
            ));
        }
    }
    out
}

/// Text of the model file, if it is still the one that was run.
fn model_text(summary: &Summary) -> Option<String> {
    let deck = Deck::read(summary.model_path.as_ref()?).ok()?;
    let same = job::fingerprint_of(&deck).is_some_and(|print| format!("{print:016x}") == summary.fingerprint);
    same.then(|| shortened(&deck.text))
}

/// Text of a model file up to the length at which its end is not shown.
fn shortened(text: &str) -> String {
    let most = MOST_OF_MODEL.min(text.len());
    let end = (0..=most).rev().find(|&i| text.is_char_boundary(i)).unwrap_or(0);
    let rest = if end < text.len() { "\n# … the rest is not shown" } else { "" };
    format!("{}{rest}", &text[..end])
}
