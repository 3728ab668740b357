//! The HTML file of a report.

use serde::Serialize;

use super::blocks::Blocks;
use super::{Part, tables};
use crate::job::{Status, Summary};
use crate::out::vtu::escape;
use crate::plot::colour::{PALETTE, Rgb, VIRIDIS};

/// Style of a page.
pub(crate) const STYLE: [&str; 2] =
    [include_str!("../../assets/report/uPlot.min.css"), include_str!("../../assets/report/page.css")];
const VIEWER: &str = include_str!("../../assets/report/viewer.js");
const STAGE: &str = include_str!("../../assets/report/stage.js");
const CURVES: &str = include_str!("../../assets/report/curves.js");
const PLOTS: &str = include_str!("../../assets/report/uPlot.iife.min.js");
const PAGE: &str = include_str!("../../assets/report/page.js");
/// Scripts of shapes and curves.
pub(crate) const VIEWER_SCRIPTS: [&str; 4] = [PLOTS, VIEWER, CURVES, STAGE];
const SCRIPTS_OF_RUNS: &[&str] = &[PLOTS, VIEWER, CURVES, STAGE, PAGE];
const SCRIPTS_OF_MODELS: &[&str] = &[VIEWER, include_str!("../../assets/report/marks.js"), STAGE, PAGE];

/// Data that the scripts of a report read.
#[derive(Serialize)]
struct Data<'a, P> {
    title: &'a str,
    parts: &'a [P],
}

/// Colours of the pictures, for the scripts.
#[derive(Serialize)]
struct Colours {
    palette: Vec<String>,
    viridis: Vec<String>,
}

/// Colours of the pictures, as the scripts read them.
pub(crate) fn colours() -> String {
    let codes = |colours: &[Rgb]| colours.iter().map(|colour| colour.code()).collect();
    let colours = Colours { palette: codes(&PALETTE), viridis: codes(&VIRIDIS) };
    in_script(&serde_json::to_string(&colours).unwrap_or_default())
}

/// Text for a script element, in which no tag may begin.
fn in_script(text: &str) -> String {
    text.replace('<', "\\u003c")
}

/// Title of a model, or its name.
fn title(summary: &Summary) -> &str {
    if summary.title.is_empty() { &summary.model } else { &summary.title }
}

/// Subject of a page, on which its scripts depend.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Shown {
    /// A run, with curves.
    Run,
    /// A model.
    Model,
}

/// Text of a page.
pub(super) struct Document<'a> {
    /// Title.
    pub title: &'a str,
    /// Line below the title, as HTML.
    pub line: String,
    /// Sections before the shapes, as HTML.
    pub before: Vec<String>,
    /// Subject.
    pub shown: Shown,
    /// Sections behind the shapes and curves, as HTML.
    pub after: Vec<String>,
    /// Omissions.
    pub notes: &'a [String],
}

impl Document<'_> {
    /// The pieces of the HTML file in their order, with the data that the scripts read.
    pub fn pieces<P: Serialize>(&self, parts: &[P], blocks: &Blocks) -> Vec<String> {
        let title = self.title;
        let mut out = vec![format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src 'unsafe-inline'; \
             style-src 'unsafe-inline'; img-src data: blob:\">\n\
             <title>{title}</title>\n<link rel=\"icon\" href=\"data:,\">\n<style>\n{}\n</style>\n</head>\n<body>\n\
             <header>\n<h1>{title}</h1>\n<p>{}</p>\n</header>\n<main>\n",
            STYLE.join("\n"),
            self.line,
            title = escape(title),
        )];
        out.extend(self.before.iter().cloned());
        let (heading, curves) = match self.shown {
            Shown::Run => {
                ("Shapes", "<section id=\"curves\">\n<h2>Curves</h2>\n<div id=\"plots\"></div>\n</section>\n")
            }
            Shown::Model => ("Mesh, supports and loads", ""),
        };
        out.push(format!(
            "<section id=\"shapes\">\n<h2>{heading}</h2>\n<div id=\"scene\"></div>\n\
             <noscript>The shapes and curves need JavaScript.</noscript>\n</section>\n{curves}"
        ));
        out.extend(self.after.iter().cloned());
        let notes: String = self.notes.iter().map(|note| format!("<p>{}</p>\n", escape(note))).collect();
        out.push(format!("<footer>\n{notes}</footer>\n</main>\n"));
        out.extend(
            blocks
                .texts()
                .iter()
                .enumerate()
                .map(|(i, text)| format!("<script type=\"text/plain\" id=\"block-{i}\">{text}</script>\n")),
        );
        let data = serde_json::to_string(&Data { title, parts }).unwrap_or_default();
        for (id, text) in [("data", in_script(&data)), ("colours", colours())] {
            out.push(format!("<script type=\"application/json\" id=\"{id}\">{text}</script>\n"));
        }
        let scripts = match self.shown {
            Shown::Run => SCRIPTS_OF_RUNS,
            Shown::Model => SCRIPTS_OF_MODELS,
        };
        out.extend(scripts.iter().map(|script| format!("<script>\n{script}\n</script>\n")));
        out.push("</body>\n</html>\n".into());
        out
    }
}

/// The pieces of the report of a run, in their order.
pub(super) fn page(
    summary: &Summary,
    parts: &[Part],
    blocks: &Blocks,
    model: Option<&str>,
    notes: &[String],
) -> Vec<String> {
    let status = match summary.status {
        Status::Complete => "complete",
        Status::Running => "running",
        Status::Interrupted => "interrupted",
        Status::Failed => "failed",
    };
    let all = if summary.analyses.is_empty() { String::new() } else { tables::checks(summary) };
    let analyses = match summary.analysis.as_str() {
        "steps" => format!("{} analyses", summary.analyses.len()),
        analysis => format!("{analysis} analysis"),
    };
    let document = Document {
        title: title(summary),
        line: format!(
            "<span class=\"status {status}\">{status}</span> {} of <code>{}</code>, tegula {}",
            escape(&analyses),
            escape(&summary.model),
            escape(&summary.version),
        ),
        before: vec![section("checks", "Checks", &all, parts, tables::checks)],
        shown: Shown::Run,
        after: vec![section("results", "Results", "", parts, tables::results), model_section(model)],
        notes,
    };
    document.pieces(parts, blocks)
}

/// Section with the text of the model file.
pub(super) fn model_section(model: Option<&str>) -> String {
    let text = model
        .map_or("<p>The model file has changed since the run, or the model does not come from a file that is still there.</p>".into(), |text| {
            format!("<pre><code>{}</code></pre>", lines(text))
        });
    format!("<section>\n<h2>Model</h2>\n{text}\n</section>\n")
}

/// Text of several lines for HTML.
fn lines(text: &str) -> String {
    text.lines().map(|line| escape(&line.replace('\t', "    ")) + "\n").collect()
}

/// A section with a piece for each analysis, under its name where there are several.
fn section(id: &str, heading: &str, first: &str, parts: &[Part], piece: fn(&Summary) -> String) -> String {
    let of = |part: &Part| {
        let name =
            if part.name.is_empty() { String::new() } else { format!("<h3>{}</h3>\n", escape(&part.name)) };
        format!("<div>\n{name}{}</div>\n", piece(&part.summary))
    };
    let pieces: String = parts.iter().map(of).collect();
    format!(
        "<section id=\"{id}\">\n<h2>{heading}</h2>\n{first}<div class=\"runs\">\n{pieces}</div>\n</section>\n"
    )
}
