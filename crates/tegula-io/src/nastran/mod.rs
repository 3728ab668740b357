//! Bulk data files of Nastran: from cards to the text of a model file.
//!
//! | file | is |
//! |---|---|
//! | `case_control` | solution sequence and subcases |
//! | `analyses` | the analyses of the subcases |
//! | `parameters` | `PARAM` |
//! | `materials`, `properties` | `MAT1`, `MAT8`; `PSHELL`, `PCOMP` |
//! | `loads` | `LOAD`, `GRAV` and the load sets |
//! | `notes` | what has no effect |
//!
//! The text names the input file as the mesh, and is read like every model file, with all its checks. Nothing of the input file is dropped
//! without a message.

mod analyses;
mod case_control;
mod loads;
mod materials;
mod notes;
mod parameters;
mod properties;

use std::path::Path;

use self::analyses::Step;
use self::case_control::Control;
use self::loads::LoadSets;
use self::notes::Notes;
use self::parameters::Parameters;
pub use crate::conversion::Converted;
use crate::conversion::document::{Document, quoted, vector};
use crate::conversion::supports::{self, Restraint};
use crate::conversion::{Errors, Point, distinct, head, listed, write_points};
use crate::mesh::MeshError;
use crate::mesh::nastran::bulk::{self, Bulk};
use crate::mesh::nastran::file::{self, File};
use crate::mesh::nastran::rigid::{self, Body};
use crate::mesh::nastran::supports::Support;
use crate::mesh::numbered::{Parts, Reader};

/// Cards that are read.
const READ: &[&str] = &[
    "GRID", "CQUAD4", "PSHELL", "PCOMP", "MAT1", "MAT8", "SPC", "SPC1", "SPCADD", "FORCE", "MOMENT", "LOAD",
    "PLOAD2", "PLOAD4", "GRAV", "EIGRL", "EIGR", "NLPARM", "RBE2", "PARAM",
];

/// Coordinate systems, which have no effect: a card that refers to one is refused.
const SYSTEMS: &[&str] = &["CORD1R", "CORD1C", "CORD1S", "CORD2R", "CORD2C", "CORD2S"];

/// Converts the bytes of an input file; `path` appears in errors, and `mesh_file` is the name of the file for the model file.
///
/// # Errors
/// Mistakes of the file and cards that are not read.
pub fn convert(path: &Path, bytes: &[u8], mesh_file: &str) -> Result<Converted, Vec<MeshError>> {
    let reader = Reader::new(path);
    let text = file::text(bytes);
    let file = file::file(&reader, &text).map_err(|error| vec![error])?;
    let mut errors = Vec::new();
    let mut keep = Errors(&mut errors);
    let mut notes = Notes::default();
    keep.add(unknown(&reader, &file));
    let bulk = keep.value(bulk::bulk(&reader, &file));
    let materials = keep.value(materials::materials(&reader, &file, &mut notes));
    let control = keep.value(case_control::control(&reader, &file));
    let parameters = keep.value(parameters::parameters(&reader, &file));
    let (Some(bulk), Some(materials), Some(control), Some(parameters)) =
        (bulk, materials, control, parameters)
    else {
        return Err(distinct(errors));
    };
    let steps = keep
        .value(analyses::steps(&reader, &file, &control, &parameters, &mut notes.phrases))
        .unwrap_or_default();
    let mut out = Document::default();
    head(&mut out, path);
    if let Some((title, line)) = &control.title {
        out.key(*line, "title", &quoted(title));
    }
    if let [step] = &steps[..] {
        step.analysis.write(&mut out, "[analysis]");
    }
    mesh(&mut out, &file, mesh_file);
    materials.values().for_each(|material| material.write(&mut out));
    let sections =
        keep.value(properties::sections(&reader, &file, &bulk, &materials, &mut notes)).unwrap_or_default();
    sections.iter().for_each(|section| section.write(&mut out));
    let bodies = keep.value(rigid::bodies(&reader, &file, &bulk.parts)).unwrap_or_default();
    bodies.iter().for_each(|body| write_body(&mut out, body));
    keep.value(write_supports(&mut out, &reader, &file, &bulk.parts));
    keep.value(write_loads(&mut out, &reader, &file, &bulk, &steps));
    let points = points(&file, &bulk.parts);
    write_points(&mut out, &points, "DISPLACEMENT");
    if !errors.is_empty() {
        return Err(distinct(errors));
    }
    note(&mut notes, &file, &control, &parameters, &bodies, &steps, &bulk.parts);
    Ok(Converted { text: out.text, lines: out.lines, warnings: notes.warning().into_iter().collect() })
}

/// One error for all cards that are not read.
fn unknown(reader: &Reader<'_>, file: &File<'_>) -> Option<MeshError> {
    let unknown =
        |name: &str| !READ.contains(&name) && !SYSTEMS.contains(&name) && bulk::refusal(name).is_none();
    let cards: Vec<_> = file.cards.iter().filter(|card| unknown(&card.name)).collect();
    let first = cards.first()?;
    let list = listed("", cards.iter().map(|card| (card.name.as_str(), card.line)));
    Some(reader.error(
        first.line,
        format!("these cards are not read: {list}"),
        "remove them, and add their counterparts to the model file that `tegula convert` writes of the rest",
    ))
}

/// The table `[mesh]`.
fn mesh(out: &mut Document, file: &File<'_>, name: &str) {
    let line = file.named("GRID").next().map_or(1, |card| card.line);
    out.table(line, "[mesh]", "GRID");
    out.key(line, "type", "\"nastran\"");
    out.key(line, "file", &quoted(name));
}

/// A rigid patch.
fn write_body(out: &mut Document, body: &Body) {
    out.table(body.line, "[[bodies]]", "RBE2");
    out.key(body.line, "name", &quoted(&body.name));
    out.key(body.line, "at", &vector(&body.at));
    out.key(body.line, "attached", &format!("[{}]", quoted(&body.set())));
}

/// Supports of nodes and of the bodies of rigid elements.
fn write_supports(
    out: &mut Document,
    reader: &Reader<'_>,
    file: &File<'_>,
    parts: &Parts,
) -> Result<(), MeshError> {
    let found = crate::mesh::nastran::supports::supports(reader, file, parts)?;
    let (bodies, nodes): (Vec<Support>, Vec<Support>) =
        found.into_iter().partition(|support| support.body.is_some());
    for Support { target, line, card, values, body } in bodies {
        let free = values.map(|value| value.is_none());
        let zero = values.iter().flatten().all(|(value, _)| *value == 0.0);
        let kind = match free {
            [false, false, false, false, false, false] if zero => "fixed",
            [false, false, false, true, true, true] if zero => "spherical",
            _ => {
                return Err(reader.error(
                    line,
                    format!("the independent node of {} is held in some directions only", target.name),
                    "hold all of them, or 123; give other joints of the body in the model file that `tegula convert` writes",
                ));
            }
        };
        out.table(line, "[[joints]]", card);
        out.key(line, "type", &quoted(kind));
        out.key(line, "name", &quoted(&format!("support of {}", target.name)));
        out.key(line, "between", &format!("[\"ground\", {}]", quoted(&target.name)));
        out.key(line, "at", &vector(&body.unwrap_or_default()));
    }
    let restraint =
        |Support { target, line, card, values, .. }: Support| Restraint { target, line, dofs: values, card };
    let restraints: Vec<Restraint> = nodes.into_iter().map(restraint).collect();
    supports::write(out, reader, parts, "[[conditions]]", &restraints)
}

/// Loads of the analysis, or of each step with its analysis.
fn write_loads(
    out: &mut Document,
    reader: &Reader<'_>,
    file: &File<'_>,
    bulk: &Bulk,
    steps: &[Step],
) -> Result<(), MeshError> {
    let sets = LoadSets::read(reader, file, bulk)?;
    let single = steps.len() == 1;
    for step in steps {
        let loads =
            step.loads.map(|selected| sets.selected(reader, selected)).transpose()?.unwrap_or_default();
        if !single {
            out.table(step.analysis.line, "[[steps]]", "SUBCASE");
            out.key(step.analysis.line, "name", &quoted(&step.analysis.name));
            step.analysis.write(out, "[steps.analysis]");
        }
        loads.iter().for_each(|load| load.write(out, if single { "[[loads]]" } else { "[[steps.loads]]" }));
    }
    Ok(())
}

/// Points of the sets of few nodes whose displacements the case control asks for.
fn points(file: &File<'_>, parts: &Parts) -> Vec<Point> {
    let printed = bulk::printed(file, parts).into_iter();
    printed
        .flat_map(|(line, nodes)| {
            nodes.into_iter().map(move |node| Point { name: format!("node {node}"), node, line })
        })
        .collect()
}

/// Notes of everything without effect.
fn note(
    notes: &mut Notes,
    file: &File<'_>,
    control: &Control,
    parameters: &Parameters,
    bodies: &[Body],
    steps: &[Step],
    parts: &Parts,
) {
    let printed: Vec<usize> = bulk::printed(file, parts).into_iter().map(|(line, _)| line).collect();
    for (name, line) in control
        .ignored
        .iter()
        .filter(|(name, line)| !printed.contains(line) && (printed.is_empty() || name != "SET"))
    {
        notes.add(name.clone(), *line);
    }
    parameters.ignored.iter().for_each(|(name, line)| notes.add(format!("PARAM,{name}"), *line));
    for card in file.cards.iter().filter(|card| SYSTEMS.contains(&card.name.as_str())) {
        notes.add(card.name.clone(), card.line);
    }
    for card in file.named("NLPARM").filter(|card| card.len() > 2) {
        notes.add("NLPARM but for its increments", card.line);
    }
    if let (Some(body), true) = (
        bodies.first(),
        steps.iter().any(|step| step.analysis.card == "SOL 106" && step.analysis.is_nonlinear()),
    ) {
        notes.phrases.push(format!(
            "small rotations of {} (line {}), which here may have any size",
            body.name, body.line
        ));
    }
}

#[cfg(test)]
mod tests;
