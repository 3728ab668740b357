//! Input files of Abaqus and CalculiX: from cards to the text of a model file.
//!
//! | file | is |
//! |---|---|
//! | `materials`, `sections` | `*MATERIAL`, `*SHELL SECTION` |
//! | `beams` | `*BEAM SECTION`, `*BEAM GENERAL SECTION`, supports of beams |
//! | `solids` | supports and forces of continuum shells |
//! | `targets` | nodes and elements of supports and loads |
//! | `boundary`, `loads` | `*BOUNDARY`, `*CLOAD`, `*DLOAD` |
//! | `steps` | `*STEP` and its analysis |
//!
//! The text names the input file as the mesh, and is read like every model file, with all its checks. Nothing of the input file is dropped
//! without a message: cards that are not read are errors, and requests for results are warnings.

mod beams;
mod boundary;
mod loads;
mod materials;
mod sections;
mod solids;
mod steps;
mod targets;

use std::collections::BTreeSet;
use std::path::Path;

use tegula::Issue;

use self::materials::Materials;
use self::steps::StepCards;
pub use crate::conversion::Converted;
use crate::conversion::analyses::{StepAnalysis, make_nonlinear};
use crate::conversion::document::{Document, quoted};
use crate::conversion::loads::Load;
use crate::conversion::supports::{self, Restraint};
use crate::conversion::{
    Errors, Point, bars, distinct, head, held, listed, unread, without_effect, write_mesh, write_points,
    write_steps,
};
use crate::mesh::MeshError;
use crate::mesh::abaqus::beams as of_mesh;
use crate::mesh::abaqus::cards::{self, Card, Reader};
use crate::mesh::abaqus::parts;
use crate::mesh::numbered::bars::frame::Frame;
use crate::mesh::numbered::{MOST_PRINTED, Parts};

/// Keywords that are read.
const READ: &[&str] = &[
    "HEADING",
    "NODE",
    "ELEMENT",
    "NSET",
    "ELSET",
    "MATERIAL",
    "ELASTIC",
    "DENSITY",
    "EXPANSION",
    "SHELL SECTION",
    "BEAM SECTION",
    "BEAM GENERAL SECTION",
    "BOUNDARY",
    "STEP",
    "STATIC",
    "FREQUENCY",
    "BUCKLE",
    "CLOAD",
    "DLOAD",
    "END STEP",
    "NODE PRINT",
];

/// Keywords that do not change what is computed.
const IGNORED: &[&str] = &[
    "NODE FILE",
    "NODE OUTPUT",
    "EL FILE",
    "EL PRINT",
    "ELEMENT OUTPUT",
    "ENERGY FILE",
    "ENERGY OUTPUT",
    "ENERGY PRINT",
    "OUTPUT",
    "RESTART",
    "PREPRINT",
    "PRINT",
    "FILE FORMAT",
    "MONITOR",
    "SECTION PRINT",
    "SECTION FILE",
    "CONTACT FILE",
    "CONTACT PRINT",
    "CONTACT OUTPUT",
    "NO PRINT",
    "CONTROLS",
];

/// Converts the bytes of an input file; `path` appears in errors, and `mesh_file` is the name of the file for the model file.
///
/// # Errors
/// Mistakes of the file and cards that are not read.
pub fn convert(path: &Path, bytes: &[u8], mesh_file: &str) -> Result<Converted, Vec<MeshError>> {
    let reader = Reader::new(path);
    let text = cards::text(bytes);
    let cards = reader.cards(&text).map_err(|error| vec![error])?;
    let mut errors = Vec::new();
    let mut keep = Errors(&mut errors);
    keep.add(unknown(&reader, &cards));
    let parts = keep.value(parts::parts(&reader, &cards));
    let materials = keep.value(Materials::read(&reader, &cards));
    let steps = keep.value(steps::split(&reader, &cards));
    let analyses = steps.as_ref().and_then(|(_, steps)| keep.value(analyses(&reader, steps)));
    let frame = parts.as_ref().and_then(|parts| keep.value(of_mesh::frame(&reader, &cards, parts)));
    let (Some(parts), Some(frame), Some(materials), Some((model, steps)), Some(mut analyses)) =
        (parts, frame, materials, steps, analyses)
    else {
        return Err(distinct(errors));
    };
    let ambiguous = ambiguous(&steps, &analyses);
    let large = keep.value(large_displacements(&reader, &frame, &mut analyses)).flatten();
    let mut out = Document::default();
    head(&mut out, path);
    title(&mut out, &cards);
    let single = matches!(steps[..], [_]);
    if let (true, Some(analysis)) = (single, analyses.first()) {
        analysis.write(&mut out, "[analysis]");
    }
    if !parts.elements.is_empty() || frame.lines.is_empty() {
        mesh(&mut out, &cards, mesh_file);
    }
    materials.write(&mut out);
    for card in cards.iter().filter(|card| card.keyword == "SHELL SECTION") {
        if let Some(section) = keep.value(sections::section(&reader, card, &parts, &materials)) {
            section.write(&mut out);
        }
    }
    let printed = printed(&parts, &cards);
    if let Some(sections) = keep.value(beams::sections(&reader, &cards, &materials)) {
        bars::write(&mut out, "*ELEMENT", &frame, &sections, &recorded(&parts, &cards));
    }
    let supports = keep.value(supports(&reader, &parts, model, &steps)).unwrap_or_default();
    let mut turning = None;
    if let Some((shells, holds)) = keep.value(beams::held(&reader, &parts, &frame, supports)) {
        turning = bars::turning_freely(&frame, holds.iter().map(|hold| hold.name.as_str()));
        keep.value(held::write(&mut out, &reader, &holds));
        keep.value(match parts.through.is_empty() {
            true => supports::write(&mut out, &reader, &parts, "[[conditions]]", &shells),
            false => solids::write_supports(&mut out, &reader, &parts, &shells),
        });
    }
    let loads = keep.value(loads_of(&reader, (&parts, &frame), &steps, &analyses)).unwrap_or_default();
    write_steps(&mut out, "*STEP", &analyses, &loads);
    write_points(&mut out, &printed, "*NODE PRINT");
    if errors.is_empty() {
        let warnings =
            ignored(&parts, &cards).into_iter().chain(ambiguous).chain(large).chain(turning).collect();
        Ok(Converted { text: out.text, lines: out.lines, warnings })
    } else {
        Err(distinct(errors))
    }
}

/// One error for all cards that are not read; those without which there is no mesh have errors of their own.
fn unknown(reader: &Reader<'_>, cards: &[Card<'_>]) -> Option<MeshError> {
    let known = |card: &&Card<'_>| {
        let keyword = card.keyword.as_str();
        !READ.contains(&keyword) && !IGNORED.contains(&keyword) && !parts::is_refused(keyword)
    };
    let unknown = cards.iter().filter(known);
    unread(reader, "*", unknown.map(|card| (card.keyword.as_str(), card.line)))
}

/// Warning about requests for results that are not read.
fn ignored(parts: &Parts, cards: &[Card<'_>]) -> Option<Issue> {
    let read = |card: &Card<'_>| {
        asked(parts, card).is_some_and(|(_, nodes)| nodes.iter().any(|node| parts.has(*node)))
    };
    let ignored = |card: &&Card<'_>| {
        IGNORED.contains(&card.keyword.as_str()) || (card.keyword == "NODE PRINT" && !read(card))
    };
    let list = listed("*", cards.iter().filter(ignored).map(|card| (card.keyword.as_str(), card.line)));
    without_effect("cards", &list)
}

/// Warning about modes and buckling behind a static step with large displacements, without PERTURBATION.
fn ambiguous(steps: &[StepCards<'_, '_>], analyses: &[StepAnalysis]) -> Option<Issue> {
    let mut loaded = false;
    for (step, analysis) in steps.iter().zip(analyses) {
        if analysis.card == "*STATIC" {
            loaded |= analysis.is_nonlinear();
        } else if loaded && !step.is_perturbation() {
            let message = format!(
                "{} on line {} is about the state of the step before, as in Abaqus; CalculiX takes the unloaded structure, as the step has no PERTURBATION",
                analysis.card, analysis.line
            );
            let help = "write PERTURBATION on *STEP to have the loaded state in both programs, or a file of its own for the unloaded structure";
            return Some(Issue::new("", message, help));
        }
    }
    None
}

/// Makes linear statics those of large displacements where the model has beams, which move in these only, with a warning.
///
/// # Errors
/// Modes or buckling stand behind linear statics, which would then be about the loaded state.
fn large_displacements(
    reader: &Reader<'_>,
    frame: &Frame,
    analyses: &mut [StepAnalysis],
) -> Result<Option<Issue>, MeshError> {
    let Some(beam) = frame.lines.first() else { return Ok(None) };
    let linear = analyses.iter().position(|analysis| !analysis.is_nonlinear());
    let behind = analyses.iter().skip(linear.unwrap_or(analyses.len()));
    if let Some(modes) = behind.clone().find(|analysis| analysis.card != "*STATIC") {
        return Err(reader.error(
            modes.line,
            format!("{} stands behind a linear *STATIC of a model with beams, which has large displacements here", modes.card),
            "write NLGEOM on the step of *STATIC to have the loaded state, or a file of its own for the unloaded structure",
        ));
    }
    let phrase = make_nonlinear(analyses.iter_mut(), (beam.name.clone(), beam.line));
    Ok(phrase.and_then(|phrase| without_effect("parts", &phrase)))
}

/// Title of the model.
fn title(out: &mut Document, cards: &[Card<'_>]) {
    let title = cards.iter().find(|card| card.keyword == "HEADING").and_then(|card| card.data.first());
    if let Some(title) = title {
        out.key(title.line, "title", &quoted(title.text));
    }
}

/// The table `[mesh]`.
fn mesh(out: &mut Document, cards: &[Card<'_>], file: &str) {
    let line = cards.iter().find(|card| card.keyword == "NODE").map_or(1, |card| card.line);
    write_mesh(out, line, "*NODE", "abaqus", file);
}

/// Analyses of all steps.
fn analyses(reader: &Reader<'_>, steps: &[StepCards<'_, '_>]) -> Result<Vec<StepAnalysis>, MeshError> {
    if let Some(step) = steps.iter().find(|step| steps.len() > 1 && step.is_static_perturbation()) {
        return Err(reader.error(
            step.line(),
            "a static perturbation among several steps is not read",
            "write a file of its own for it, or leave out PERTURBATION where its loads continue",
        ));
    }
    let mut nonlinear = false;
    steps.iter().map(|step| step.analysis(reader, &mut nonlinear)).collect()
}

/// Supports of the model and of its first step, which hold in all steps.
fn supports(
    reader: &Reader<'_>,
    parts: &Parts,
    model: &[Card<'_>],
    steps: &[StepCards<'_, '_>],
) -> Result<Vec<Restraint>, MeshError> {
    let mut all: Vec<&Card<'_>> = model.iter().filter(|card| card.keyword == "BOUNDARY").collect();
    for (i, step) in steps.iter().enumerate() {
        for card in step.of(&["BOUNDARY"]) {
            let new = card.parameter("OP").is_some_and(|op| op.eq_ignore_ascii_case("NEW"));
            if i > 0 || (new && !all.is_empty()) {
                return Err(reader.error(
                    card.line,
                    "the card changes supports that are given before",
                    "give all supports before or in the first step, or `conditions` of `[[steps]]` in a model file",
                ));
            }
            all.push(card);
        }
    }
    boundary::restraints(reader, parts, &all)
}

/// Loads of each step. Those of statics continue; buckling has its own beside them, and modes have none.
fn loads_of(
    reader: &Reader<'_>,
    model: (&Parts, &Frame),
    steps: &[StepCards<'_, '_>],
    analyses: &[StepAnalysis],
) -> Result<Vec<Vec<Load>>, MeshError> {
    let mut of_statics = Vec::new();
    let mut all = Vec::new();
    for (step, analysis) in steps.iter().zip(analyses) {
        let cards = step.of(&["CLOAD", "DLOAD"]);
        all.push(match (analysis.card, cards.first()) {
            ("*STATIC", _) => {
                of_statics = loads::loads(reader, model, &cards, &of_statics)?;
                of_statics.clone()
            }
            ("*BUCKLE", _) => loads::loads(reader, model, &cards, &[])?,
            (_, None) => Vec::new(),
            (_, Some(card)) => {
                return Err(reader.error(
                    card.line,
                    format!("the step of line {} has modes, which do not depend on its loads", step.line()),
                    "remove the loads, or give them to a *STATIC step before",
                ));
            }
        });
    }
    Ok(all)
}

/// Name and nodes of the set of few nodes whose displacements a card `*NODE PRINT` asks for.
fn asked<'p>(parts: &'p Parts, card: &Card<'_>) -> Option<(&'p str, &'p BTreeSet<u64>)> {
    let displacements = card.fields().any(|(_, field)| field.eq_ignore_ascii_case("U"));
    let found = parts.node_sets.get(card.parameter("NSET")?)?;
    (card.keyword == "NODE PRINT" && displacements && found.1.len() <= MOST_PRINTED).then_some(found)
}

/// Points of shells whose displacements cards ask for.
fn printed(parts: &Parts, cards: &[Card<'_>]) -> Vec<Point> {
    let mut found = Vec::new();
    let mut taken = BTreeSet::new();
    for card in cards {
        let Some((name, members)) = asked(parts, card) else { continue };
        for node in members.iter().filter_map(|node| parts.middle(*node)) {
            if taken.insert(node) {
                let name = match parts.layer.above.get(&node) {
                    Some(above) => format!("{name} {node} and {above}"),
                    None if members.len() == 1 => name.to_owned(),
                    None => format!("{name} {node}"),
                };
                found.push(Point { name, node, line: card.line });
            }
        }
    }
    found
}

/// Nodes of beams whose displacements cards ask for.
fn recorded(parts: &Parts, cards: &[Card<'_>]) -> BTreeSet<u64> {
    let sets = cards.iter().filter_map(|card| asked(parts, card)).flat_map(|(_, nodes)| nodes);
    sets.copied().filter(|node| parts.of_bars.contains(node)).collect()
}

#[cfg(test)]
mod beams_tests;
#[cfg(test)]
mod solids_tests;
#[cfg(test)]
mod tests;
