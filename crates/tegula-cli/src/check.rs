//! `tegula check`

use std::path::PathBuf;

use clap::Args;
use serde_json::json;
use tegula::compile::{StepModel, steps};
use tegula::mesh::folds::Fold;
use tegula::mesh::quality::quality;
use tegula::model::{Analysis, BodyShape};
use tegula::system::coordinates::Body;
use tegula::{Mat3, Mesh, System};
use tegula_io::deck::{Deck, Diagnostic};
use tegula_io::job;
use tegula_io::out::numbers::{grouped, significant};

use crate::report::{self, Failure, warn};

/// Arguments of `tegula check`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Model file (TOML), or input file of Abaqus, CalculiX (.inp) or Nastran (.bdf, .nas); `-` reads a model file from standard input
    model: PathBuf,
    /// Print the findings, or what is wrong, as JSON on standard output
    #[arg(long)]
    pub json: bool,
}

/// Checks the model and prints what it is.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let deck = Deck::read(&arguments.model).map_err(Failure::Model)?;
    print(&deck, arguments.json)
}

/// Prints what a model is.
pub fn print(deck: &Deck, as_json: bool) -> Result<(), Failure> {
    let prepared = job::prepare(deck)?;
    let (mesh, system) = (&prepared.mesh, &prepared.system);
    let supported = 3 * system.vectors() - system.unknowns();
    let q = quality(mesh);
    let title = &deck.model.title;
    if as_json {
        let out = json!({
            "status": "ok",
            "title": title,
            "elements": system.elements(),
            "nodes": mesh.positions.len(),
            "unknowns": system.unknowns(),
            "supported": supported,
            "steps": deck.model.steps.iter().map(|step| kind(&step.analysis)).collect::<Vec<_>>(),
            "mass": system.total_mass(),
            "size": system.length,
            "bodies": solids(deck, system).map(|(body, inertia)| json!({
                "name": body.name,
                "mass": body.mass,
                "centre": system.coordinates.reference[body.centre as usize],
                "inertia": [inertia.m11, inertia.m22, inertia.m33],
                "products_of_inertia": [inertia.m12, inertia.m13, inertia.m23],
            })).collect::<Vec<_>>(),
            "assembly": system.closed_gaps.as_deref().map(job::AssemblyResult::from),
            "quality": {
                "max_aspect": q.max_aspect,
                "min_angle_deg": q.min_angle_deg,
                "max_angle_deg": q.max_angle_deg,
                "max_warp": q.max_warp,
            },
            "parts": parts(mesh).iter().map(|(node, size)| json!({
                "nodes": size,
                "first": mesh.node_label(*node),
            })).collect::<Vec<_>>(),
            "fold_angle_deg": deck.model.mesh.fold_angle(),
            "folds": system.folds.lines.iter().map(|line| fold_as_json(mesh, line)).collect::<Vec<_>>(),
            "sets": mesh.set_names(),
            "warnings": prepared.warnings.iter().map(report::as_json).collect::<Vec<_>>(),
        });
        say!("{out:#}");
        return Ok(());
    }
    if !title.is_empty() {
        say!("{title}");
    }
    if let Some(labels) = &mesh.labels {
        say!("mesh file  {}", labels.file);
    }
    say!("elements   {}", grouped(system.elements()));
    say!("nodes      {}", grouped(mesh.positions.len()));
    say!("unknowns   {}", grouped(system.unknowns()));
    say!("supported  {} coordinates", grouped(supported));
    if !deck.model.steps.is_empty() {
        let named = |step: &StepModel| format!("{} ({})", step.name, kind(&step.model.analysis));
        say!("steps      {}", steps(&deck.model).iter().map(named).collect::<Vec<_>>().join(", "));
    }
    say!("mass       {}", significant(system.total_mass(), 7));
    say!("size       {}", significant(system.length, 7));
    print_solids(deck, system);
    for message in system.closed_gaps.iter().flat_map(|gaps| gaps.messages()) {
        say!("{message}");
    }
    say!(
        "quality    aspect ratio to {:.3}, angles {:.1} to {:.1} degrees, warp to {}",
        q.max_aspect,
        q.min_angle_deg,
        q.max_angle_deg,
        significant(q.max_warp, 3)
    );
    print_parts(mesh);
    print_folds(mesh, system, deck.model.mesh.fold_angle());
    say!("sets       {}", mesh.set_names().join(", "));
    print_warnings(&prepared.warnings);
    Ok(())
}

fn print_warnings(warnings: &[Diagnostic]) {
    warnings.iter().for_each(warn);
    match warnings.iter().map(|w| w.hidden.max(1)).sum() {
        0 => say!("no errors"),
        1 => say!("no errors, 1 warning"),
        n => say!("no errors, {n} warnings"),
    }
}

/// Bodies within surfaces, each with its inertia tensor about the mass centre along the axes of the body.
fn solids<'a>(deck: &'a Deck, system: &'a System) -> impl Iterator<Item = (&'a Body, Mat3)> {
    let bodies = deck.model.bodies.iter().zip(&system.coordinates.bodies);
    bodies
        .filter(|(data, _)| matches!(data.shape, Some(BodyShape::Stl(_))))
        .map(|(_, body)| (body, Mat3::identity() * body.euler.trace() - body.euler))
}

/// Prints the mass properties of bodies within surfaces.
fn print_solids(deck: &Deck, system: &System) {
    for (body, j) in solids(deck, system) {
        let list = |values: [f64; 3]| values.map(|x| significant(x, 7)).join(", ");
        // Products of inertia that are round-off are printed as 0.
        let tidy = |x: f64| if x.abs() < ROUND_OFF * j.trace() { 0.0 } else { x };
        say!("body       {}: mass {}", body.name, significant(body.mass, 7));
        say!("           mass centre ({})", list(system.coordinates.reference[body.centre as usize]));
        say!(
            "           moments of inertia about it along the axes of the body {}",
            list([j.m11, j.m22, j.m33])
        );
        say!("           products of inertia J12, J13, J23 {}", list([j.m12, j.m13, j.m23].map(tidy)));
    }
}

/// Kind of an analysis.
fn kind(analysis: &Analysis) -> &'static str {
    match analysis {
        Analysis::Static(_) => "static",
        Analysis::Path(_) => "path",
        Analysis::Modal(_) => "modal",
        Analysis::Buckling(_) => "buckling",
        Analysis::Transient(_) => "transient",
    }
}

/// Products of inertia over the trace of the tensor below which they are round-off.
const ROUND_OFF: f64 = 1e-12;

/// Lines of a list that are written out.
const SHOWN: usize = 10;

/// First node and number of nodes of each connected part of a mesh.
fn parts(mesh: &Mesh) -> Vec<(u32, usize)> {
    let mut parts: Vec<(u32, usize)> = Vec::new();
    for (node, part) in (0u32..).zip(mesh.parts()).filter(|(_, part)| *part != u32::MAX) {
        match parts.get_mut(part as usize) {
            Some((_, size)) => *size += 1,
            None => parts.push((node, 1)),
        }
    }
    parts
}

/// A fold (two sheets, with least and largest angle) or a junction of more.
fn fold_as_json(mesh: &Mesh, line: &Fold) -> serde_json::Value {
    json!({
        "sheets": line.sheets,
        "length": line.length,
        "edges": line.edges,
        "angles_deg": line.angles,
        "ends": line.ends.map(|node| mesh.node_label(node)),
    })
}

/// Prints the connected parts of a mesh.
fn print_parts(mesh: &Mesh) {
    let parts = parts(mesh);
    if parts.len() == 1 {
        say!("parts      1: all elements are connected");
        return;
    }
    say!("parts      {}, which no element connects", parts.len());
    for (first, size) in parts.iter().take(SHOWN) {
        say!("           {size} nodes, first {}", place(mesh, *first));
    }
    more(parts.len());
}

/// Prints the lines along which sheets meet at an angle, and the rule that makes them.
fn print_folds(mesh: &Mesh, system: &System, fold_angle: f64) {
    let (folds, junctions): (Vec<_>, Vec<_>) = system.folds.lines.iter().partition(|line| line.sheets == 2);
    let length = |lines: &[&Fold]| lines.iter().map(|line| line.length).sum::<f64>();
    if folds.is_empty() {
        say!("folds      none: neighbours meet at less than {fold_angle} degrees");
    } else {
        say!(
            "folds      {} of length {:.6} in all: neighbours meet at {fold_angle} degrees or more",
            folds.len(),
            length(&folds)
        );
        for line in folds.iter().take(SHOWN) {
            let [low, high] = line.angles.unwrap_or_default();
            let angles =
                if high - low < 0.05 { format!("{low:.1}") } else { format!("{low:.1} to {high:.1}") };
            say!("           {angles} degrees, {}", extent(mesh, line));
        }
        more(folds.len());
    }
    if !junctions.is_empty() {
        say!(
            "junctions  {} of length {:.6} in all: three or more elements meet",
            junctions.len(),
            length(&junctions)
        );
        for line in junctions.iter().take(SHOWN) {
            say!("           {} sheets, {}", line.sheets, extent(mesh, line));
        }
        more(junctions.len());
    }
}

/// "length 0.2, 2 edges, from node 3 at (…) to node 13 at (…)".
fn extent(mesh: &Mesh, line: &Fold) -> String {
    let [a, b] = line.ends;
    let (edges, plural) = (line.edges, if line.edges == 1 { "" } else { "s" });
    if a == b {
        format!("length {:.6}, {edges} edge{plural}, closed, through node {}", line.length, place(mesh, a))
    } else {
        format!(
            "length {:.6}, {edges} edge{plural}, from node {} to node {}",
            line.length,
            place(mesh, a),
            place(mesh, b)
        )
    }
}

/// "3 at (1, 0, 0)".
fn place(mesh: &Mesh, node: u32) -> String {
    let label = mesh.node_label(node);
    match mesh.positions.get(node as usize) {
        Some(x) => format!("{label} at ({:.6}, {:.6}, {:.6})", x.x, x.y, x.z),
        None => label.to_string(),
    }
}

fn more(count: usize) {
    if count > SHOWN {
        say!("           and {} more", count - SHOWN);
    }
}
