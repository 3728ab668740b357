//! Bulk data files of Nastran: from cards to the text of a model file.
//!
//! | file | is |
//! |---|---|
//! | `case_control` | solution sequence and subcases |
//! | `analyses` | the analyses of the subcases |
//! | `parameters` | `PARAM` |
//! | `materials`, `properties` | `MAT1`, `MAT8`; `PSHELL`, `PCOMP` |
//! | `bars` | `CBAR` with `PBAR` and `PBARL` |
//! | `held` | supports |
//! | `loads` | `LOAD`, `GRAV` and the load sets |
//! | `notes`, `unused` | what has no effect, and what no analysis uses |
//!
//! The text names the input file as the mesh, and is read like every model file, with all its checks. Nothing of the input file is dropped
//! without a message.

mod analyses;
mod bars;
mod case_control;
mod held;
mod loads;
mod materials;
mod notes;
mod parameters;
mod properties;
mod unused;

use std::path::Path;

use tegula::Issue;

use self::analyses::Step;
use self::case_control::{Control, Solution};
use self::loads::LoadSets;
use self::notes::Notes;
use self::parameters::Parameters;
pub use crate::conversion::Converted;
use crate::conversion::analyses::{StepAnalysis, make_nonlinear};
use crate::conversion::bars as of_beams;
use crate::conversion::document::{Document, quoted, vector};
use crate::conversion::loads::Load;
use crate::conversion::{
    Errors, Point, distinct, head, listed, unread, write_mesh, write_points, write_steps,
};
use crate::mesh::MeshError;
use crate::mesh::nastran::bars::frame;
use crate::mesh::nastran::bulk;
use crate::mesh::nastran::file::{self, File};
use crate::mesh::nastran::rigid::{self, Body};
use crate::mesh::nastran::supports::{self, Support};
use crate::mesh::numbered::bars::frame::Frame;
use crate::mesh::numbered::{Parts, Reader};

/// Cards that are read.
const READ: &[&str] = &[
    "GRID", "CQUAD4", "PSHELL", "PCOMP", "MAT1", "MAT8", "SPC", "SPC1", "SPCADD", "FORCE", "MOMENT", "LOAD",
    "PLOAD2", "PLOAD4", "GRAV", "EIGRL", "EIGR", "NLPARM", "RBE2", "RBE3", "CBAR", "PBAR", "PBARL", "PARAM",
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
    keep.add(bulk::refused(&reader, &file));
    let bulk = keep.value(bulk::bulk(&reader, &file));
    let materials = keep.value(materials::materials(&reader, &file, &mut notes));
    let control = keep.value(case_control::control(&reader, &file));
    let parameters = keep.value(parameters::parameters(&reader, &file));
    let frame = bulk.as_ref().and_then(|bulk| keep.value(frame::frame(&reader, &file, &bulk.parts)));
    let (Some(bulk), Some(frame), Some(materials), Some(control), Some(parameters)) =
        (bulk, frame, materials, control, parameters)
    else {
        return Err(distinct(errors));
    };
    let mut steps = keep
        .value(analyses::steps(&reader, &file, &control, &parameters, &mut notes.phrases))
        .unwrap_or_default();
    large_displacements(&mut notes, &mut steps, jointed((&reader, &file, &bulk.parts), &frame));
    let mut out = Document::default();
    head(&mut out, path);
    if let Some((title, line)) = &control.title {
        out.key(*line, "title", &quoted(title));
    }
    if let [step] = &steps[..] {
        step.analysis.write(&mut out, "[analysis]");
    }
    if !bulk.parts.elements.is_empty() || frame.lines.is_empty() {
        let line = file.named("GRID").next().map_or(1, |card| card.line);
        write_mesh(&mut out, line, "GRID", "nastran", mesh_file);
    }
    materials.values().for_each(|material| material.write(&mut out));
    let sections =
        keep.value(properties::sections(&reader, &file, &bulk, &materials, &mut notes)).unwrap_or_default();
    sections.iter().for_each(|section| section.write(&mut out));
    let bodies = keep.value(rigid::bodies(&reader, &file, &bulk.parts)).unwrap_or_default();
    bodies.iter().for_each(|body| write_body(&mut out, body));
    let printed = bulk::printed(&file, &bulk.parts).into_iter().flat_map(|(_, nodes)| nodes).collect();
    let of_bars = keep.value(bars::sections(&reader, &file, &frame, &materials, &mut notes));
    of_beams::write(&mut out, "CBAR", &frame, &of_bars.unwrap_or_default(), &printed);
    let supported = keep.value(held::write(&mut out, &reader, &file, &bulk.parts)).unwrap_or_default();
    small_rotations(&mut notes, &control, &bodies, &steps);
    rotations_of_nodes(&mut notes, &bodies);
    let sets = keep.value(LoadSets::read(&reader, &file, &bulk));
    if let Some(sets) = &sets {
        keep.value(write_loads(&mut out, &reader, sets, steps));
    }
    write_points(&mut out, &points(&file, &bulk.parts), "DISPLACEMENT");
    match sets {
        Some(sets) if errors.is_empty() => {
            let mut warnings = warnings(notes, (&reader, &file, &bulk.parts), &control, &parameters, &sets);
            warnings.extend(of_beams::turning_freely(&frame, supported.iter().map(String::as_str)));
            Ok(Converted { text: out.text, lines: out.lines, warnings })
        }
        _ => Err(distinct(errors)),
    }
}

/// Name and line of the first part of the model that moves in analyses of large displacements only: bars, a distributing coupling, or a supported body.
fn jointed(
    (reader, file, parts): (&Reader<'_>, &File<'_>, &Parts),
    frame: &Frame,
) -> Option<(String, usize)> {
    let of_bars = frame.lines.first().map(|line| (line.name.clone(), line.line));
    let supports = || supports::supports(reader, file, parts).unwrap_or_default();
    let of_body = |support: Support| support.body.map(|_| (support.target.name, support.line));
    let bodies = || rigid::bodies(reader, file, parts).unwrap_or_default().into_iter();
    let of_coupling = || {
        let body = bodies().find(|body| !body.weighted.is_empty())?;
        Some((body.name, body.line))
    };
    of_bars.or_else(of_coupling).or_else(|| supports().into_iter().find_map(of_body))
}

/// Makes analyses of small displacements those of large ones where the model has something that moves in these only.
fn large_displacements(notes: &mut Notes, steps: &mut [Step], because: Option<(String, usize)>) {
    let analyses = steps.iter_mut().map(|step| &mut step.analysis);
    notes.phrases.extend(because.and_then(|because| make_nonlinear(analyses, because)));
}

/// Notes that rigid elements have large rotations here, where those of Nastran have small ones.
fn small_rotations(notes: &mut Notes, control: &Control, bodies: &[Body], steps: &[Step]) {
    let small = control.solution.0 == Solution::Nonlinear(false);
    let large = steps.iter().any(|step| step.analysis.is_nonlinear());
    if let (Some(Body { name, line, .. }), true) = (bodies.first(), small && large) {
        notes.phrases.push(format!("small rotations of {name} (line {line}), which here may have any size"));
    }
}

/// Notes that rotations of the nodes of distributing couplings have other weights.
fn rotations_of_nodes(notes: &mut Notes, bodies: &[Body]) {
    let named = bodies.iter().filter(|body| body.rotations).map(|body| (body.name.as_str(), body.line));
    let list = listed("", named);
    if !list.is_empty() {
        notes.phrases.push(format!(
            "the components 456 of the nodes of {list}, whose rotations have the weight h²/12 of the thickness h here"
        ));
    }
}

/// One error for all cards that are not read.
fn unknown(reader: &Reader<'_>, file: &File<'_>) -> Option<MeshError> {
    let known = |name: &str| READ.contains(&name) || SYSTEMS.contains(&name) || bulk::is_refused(name);
    let unknown = file.cards.iter().filter(|card| !known(&card.name));
    unread(reader, "", unknown.map(|card| (card.name.as_str(), card.line)))
}

/// A rigid patch, or a distributing coupling.
fn write_body(out: &mut Document, body: &Body) {
    let list = |names: Vec<String>| format!("[{}]", names.join(", "));
    out.table(body.line, "[[bodies]]", body.card());
    out.key(body.line, "name", &quoted(&body.name));
    out.key(body.line, "at", &vector(&body.at));
    let sets = list(body.sets().iter().map(|(set, _)| quoted(set)).collect());
    if body.weighted.is_empty() {
        out.key(body.line, "attached", &sets);
    } else {
        out.key(body.line, "distributed", &sets);
        let weights: Vec<f64> = body.weighted.iter().map(|(weight, _)| *weight).collect();
        out.key(body.line, "weights", &vector(&weights));
    }
}

/// Writes the loads of the analysis, or of each step with its analysis.
fn write_loads(
    out: &mut Document,
    reader: &Reader<'_>,
    sets: &LoadSets,
    steps: Vec<Step>,
) -> Result<(), MeshError> {
    let loads: Vec<Vec<Load>> = steps
        .iter()
        .map(|step| step.loads.map_or(Ok(Vec::new()), |selected| sets.selected(reader, selected)))
        .collect::<Result<_, _>>()?;
    let analyses: Vec<StepAnalysis> = steps.into_iter().map(|step| step.analysis).collect();
    write_steps(out, "SUBCASE", &analyses, &loads);
    Ok(())
}

/// Points of the sets of few nodes whose displacements the case control asks for.
fn points(file: &File<'_>, parts: &Parts) -> Vec<Point> {
    let printed = bulk::printed(file, parts).into_iter();
    printed
        .flat_map(|(line, nodes)| {
            let of_shells = nodes.into_iter().filter(|node| parts.used.contains(node));
            of_shells.map(move |node| Point { name: format!("node {node}"), node, line })
        })
        .collect()
}

/// Warnings of everything that has no effect, is not used, or means something else than one may expect.
fn warnings(
    mut notes: Notes,
    (reader, file, parts): (&Reader<'_>, &File<'_>, &Parts),
    control: &Control,
    parameters: &Parameters,
    sets: &LoadSets,
) -> Vec<Issue> {
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
    for card in file.named("NLPARM").filter(|card| card.count() > 2) {
        notes.add("all fields of NLPARM except the number of increments", card.line);
    }
    let dropped = supports::without_effect(reader, file, parts).unwrap_or_default();
    if let Some((node, line)) = dropped.first() {
        let count = if let [_] = dropped[..] { "" } else { " and other nodes" };
        notes.phrases.push(format!("the support of node {node} (line {line}){count}, as no element has it"));
    }
    let approximate = parameters.approximate.iter().map(|(name, line)| (name.as_str(), *line));
    let approximate = listed("PARAM,", approximate);
    let approximate = (!approximate.is_empty()).then(|| {
        let message = format!(
            "these parameters change results a little in Nastran and have no counterpart here: {approximate}"
        );
        Issue::new("", message, "expect small differences between the results, or leave the parameters out")
    });
    let lengths = sets.lengths.iter().map(|(length, line)| {
        let message = format!("the vector N of GRAV on line {line} has the length {length:.6}");
        Issue::new("", message, "the acceleration is A times N, as in Nastran, which does not normalise N")
    });
    let unused = unused::warning(reader, file, control, sets);
    notes.warning().into_iter().chain(approximate).chain(unused).chain(lengths).collect()
}

#[cfg(test)]
mod bars_tests;
#[cfg(test)]
mod coupling_tests;
#[cfg(test)]
mod selection_tests;
#[cfg(test)]
mod tests;
