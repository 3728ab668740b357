//! From the model file to the mesh and the compiled system.

use std::collections::BTreeMap;
use std::sync::Arc;

use tegula::analysis::{Observer, Step};
use tegula::compile::{
    StepModel, check, define_sets, imperfect_mesh, soft_folds, warnings, warnings_before_start,
};
use tegula::mesh::generators;
use tegula::model::{
    Analysis, BodyShape, Imperfection, Scheme, Sensor, StopCondition, TransientAnalysis, TriangulatedSurface,
};
use tegula::result::Probe;
use tegula::{Error, Issue, Mesh, Model, System};

use super::{JobError, OwnParts, bodies, forces, history};
use crate::deck::{Deck, Diagnostic};
use crate::memory;
use crate::mesh::{self, FileMesh, node_table, stl};
use crate::out::fingerprint;

/// A model file ready to run.
pub struct Prepared {
    /// The model, with the surfaces of its bodies and the tables of its imperfections.
    pub model: Arc<Model>,
    /// The mesh.
    pub mesh: Arc<Mesh>,
    /// The compiled model; of several analysis steps the first one.
    pub system: System,
    /// The recorded points.
    pub probes: Vec<Probe>,
    /// Warnings: the model can be computed but is most likely not intended.
    pub warnings: Vec<Diagnostic>,
    /// Fingerprint of the model file, of its mesh file, and of the files of surfaces and imperfections.
    pub fingerprint: u64,
    /// Loads and material laws of the caller.
    pub own: Arc<OwnParts>,
}

/// Reads or generates the mesh and compiles the model.
///
/// # Errors
/// Everything that is wrong with the model, at its places in the file.
pub fn prepare(deck: &Deck) -> Result<Prepared, JobError> {
    prepare_with(deck, Arc::default())
}

/// Reads or generates the mesh and compiles the model with loads and material laws of the caller.
///
/// # Errors
/// Everything that is wrong with the model, at its places in the file.
pub fn prepare_with(deck: &Deck, own: Arc<OwnParts>) -> Result<Prepared, JobError> {
    let located = |issues: Vec<Issue>| JobError::Model(deck.locate(&issues));
    if let Some(issue) = memory::too_large(&deck.model, memory::limit()) {
        return Err(located(vec![issue]));
    }
    let mut model = deck.model.clone();
    let mut issues = Vec::new();
    let surfaces = surfaces(deck, &mut model, &mut issues);
    let displaced = displacements(deck, &mut model, &mut issues);
    let read = mesh(deck).map_err(|found| issues.extend(found));
    let (true, Ok((mesh, fingerprint))) = (issues.is_empty(), read) else {
        // Without a mesh the sets cannot be checked, but everything else can.
        issues.extend(check::keys(&model));
        return Err(located(issues));
    };
    let fingerprint = own.fingerprint(surfaces.into_iter().chain(displaced).fold(fingerprint, combined));
    let mut of_imperfections = Warnings::default();
    let mesh = match imperfect_mesh(&model, &mesh, &mut of_imperfections) {
        Ok(imperfect) => imperfect.unwrap_or(mesh),
        Err(error) => return Err(located(imperfections_failed(error))),
    };
    match compiled(&model, &mesh, &own) {
        Ok((system, probes, warnings)) => {
            let warnings = deck.locate(&[deck.warnings.clone(), of_imperfections.0, warnings].concat());
            let (model, mesh) = (Arc::new(model), Arc::new(mesh));
            Ok(Prepared { model, mesh, system, probes, warnings, fingerprint, own })
        }
        Err(error) => Err(located(issues_of(error))),
    }
}

/// Warnings of the buckling analysis whose modes are imperfections.
#[derive(Default)]
struct Warnings(Vec<Issue>);

impl Observer for Warnings {
    fn on_step(&mut self, _: &Step) -> tegula::Result<()> {
        Ok(())
    }

    fn on_warning(&mut self, message: &str) {
        self.0.push(Issue::new("imperfections", message, ""));
    }
}

/// Issues of the buckling analysis whose modes are imperfections.
fn imperfections_failed(error: Error) -> Vec<Issue> {
    match error {
        Error::Model(issues) => issues,
        error => vec![Issue::new(
            "imperfections",
            format!("the buckling modes of the nominal structure cannot be computed: {error}"),
            "run the model with `type = \"buckling\"` and without imperfections to look into it",
        )],
    }
}

/// System of the first analysis step, recorded points, and warnings. The systems of all later steps are made, too, so
/// that their mistakes show before anything is computed.
fn compiled(model: &Model, mesh: &Mesh, own: &OwnParts) -> tegula::Result<(System, Vec<Probe>, Vec<Issue>)> {
    let compiler = own.compiler(model, mesh)?;
    let first = compiler.system(0, None)?;
    let probes = Probe::all(&model.output.points, mesh, &first)?;
    let mut issues = Vec::new();
    if let Some(step) = compiler.steps().first() {
        issues.extend(unknown_columns(step, &first, &probes));
    }
    if model.steps.is_empty() && issues.is_empty() {
        let warnings = warnings(model, mesh, &first);
        return Ok((first, probes, warnings));
    }
    let mut warned: Vec<Issue> = soft_folds(compiler.steps(), &first).into_iter().collect();
    let mut warn = |step: &StepModel, system: &System| {
        let found = warnings_before_start(step, mesh, system);
        warned.extend(found.into_iter().filter(|w| !warned.contains(w)).collect::<Vec<_>>());
    };
    warn(&compiler.steps()[0], &first);
    for (i, step) in compiler.steps().iter().enumerate().skip(1) {
        match compiler.system(i, None) {
            Ok(system) => {
                issues.extend(unknown_columns(step, &system, &probes));
                warn(step, &system);
            }
            Err(error) => issues.extend(issues_of(error)),
        }
    }
    if issues.is_empty() { Ok((first, probes, warned)) } else { Err(Error::Model(issues)) }
}

/// Largest number of columns that a message names.
const LISTED: usize = 30;

/// Stop conditions on columns that the history of a step does not have.
fn unknown_columns(step: &StepModel, system: &System, probes: &[Probe]) -> Vec<Issue> {
    let columns = history::columns(system, probes);
    let unknown = |(i, condition): (usize, &StopCondition)| {
        let name = &condition.column;
        if columns.contains(name) {
            return is_mean(&step.model, system, name).then(|| {
                Issue::new(
                    format!("analysis.stop[{i}].column"),
                    format!("with `energy-momentum` of order 2 \"{name}\" is a mean over the step, and round-off in the short step to a crossing"),
                    "give the scheme `order = 4`, take `generalized-alpha`, or a column of the motion",
                )
            });
        }
        // Columns of the same body, joint or sensor, or else of any.
        let owner = name.rsplit_once('.').map_or(name.as_str(), |(owner, _)| owner);
        let of_owner: Vec<&str> =
            columns.iter().filter(|c| c.starts_with(owner)).map(String::as_str).collect();
        let known = if of_owner.is_empty() { columns.iter().map(String::as_str).collect() } else { of_owner };
        let listed = known.iter().take(LISTED).copied().collect::<Vec<_>>().join(", ");
        let more =
            if known.len() > LISTED { format!(" and {} more", known.len() - LISTED) } else { String::new() };
        let help = format!("known: {listed}{more}");
        let message = format!("the history has no column \"{name}\"");
        Some(Issue::new(format!("analysis.stop[{i}].column"), message, help))
    };
    let conditions = step.model.analysis.stop_conditions().iter().enumerate();
    step.located(conditions.filter_map(unknown).collect())
}

/// Whether a column is a mean over the step: reactions, loads, section forces and accelerations, with the energy–momentum scheme of
/// second order.
fn is_mean(model: &Model, system: &System, column: &str) -> bool {
    let Analysis::Transient(TransientAnalysis { scheme: Scheme::EnergyMomentum(scheme), .. }) =
        &model.analysis
    else {
        return false;
    };
    let of_sensor = |sensor: &Sensor| {
        let own = column
            .strip_prefix("sensor.")
            .and_then(|rest| rest.strip_prefix(sensor.name())?.strip_prefix('.'));
        match sensor {
            Sensor::Reaction(_) => own.is_some(),
            Sensor::Point(_) => own.is_some_and(|own| ["ax", "ay", "az"].contains(&own)),
            _ => false,
        }
    };
    let of_end = [bodies::ANGLE, bodies::DISPLACEMENT]
        .iter()
        .any(|name| column.rsplit_once('.').is_some_and(|(_, last)| last == *name));
    let of_forces = || forces::names(system).iter().any(|name| name == column);
    let of_body = column.starts_with("body.")
        && column.rsplit_once('.').is_some_and(|(_, last)| bodies::ACCELERATIONS.contains(&last));
    let of_step = (column.starts_with("joint.") && !of_end) || of_body || of_forces();
    scheme.order == 2 && (of_step || model.sensors.iter().any(of_sensor))
}

/// The mesh with the sets of the model, and the fingerprint of the files that the model is made of.
fn mesh(deck: &Deck) -> Result<(Mesh, u64), Vec<Issue>> {
    let (mut mesh, fingerprint) = source_mesh(deck)?;
    let issues = define_sets(&deck.model.sets, &mut mesh);
    if issues.is_empty() { Ok((mesh, fingerprint)) } else { Err(issues) }
}

fn source_mesh(deck: &Deck) -> Result<(Mesh, u64), Vec<Issue>> {
    let text = fingerprint(&deck.text);
    let file = deck
        .model
        .mesh
        .file()
        .and_then(|source| Some((source, mesh::read(&deck.model.mesh, &deck.beside(&source.file))?)));
    let Some((source, read)) = file else {
        return generators::generate(&deck.model.mesh).map(|mesh| (mesh, text)).map_err(issues_of);
    };
    let FileMesh { mut mesh, bytes } = read.map_err(|error| vec![error.issue()])?;
    if source.merge_coincident == Some(true) {
        mesh.merge_coincident_nodes()?;
    }
    let issues = mesh.name_points(&source.points);
    if !issues.is_empty() {
        return Err(issues);
    }
    Ok((mesh, combined(text, fingerprint(&bytes))))
}

/// Fingerprint of the files that a model is made of, as in its `summary.json`; `None` where one of them cannot be read.
pub fn fingerprint_of(deck: &Deck) -> Option<u64> {
    let (mut model, mut issues) = (deck.model.clone(), Vec::new());
    let surfaces = surfaces(deck, &mut model, &mut issues);
    let displaced = displacements(deck, &mut model, &mut issues);
    let (_, fingerprint) = mesh(deck).ok()?;
    issues.is_empty().then(|| surfaces.into_iter().chain(displaced).fold(fingerprint, combined))
}

/// Fingerprint of two files.
fn combined(first: u64, second: u64) -> u64 {
    fingerprint([first.to_le_bytes(), second.to_le_bytes()].concat())
}

/// Reads the surfaces of bodies into the model; returns the fingerprints of their files. A file that several bodies name is read
/// once.
fn surfaces(deck: &Deck, model: &mut Model, issues: &mut Vec<Issue>) -> Vec<u64> {
    let mut read: BTreeMap<String, Option<(Arc<TriangulatedSurface>, u64)>> = BTreeMap::new();
    let mut out = Vec::new();
    for (i, body) in model.bodies.iter_mut().enumerate() {
        let Some(BodyShape::Stl(shape)) = &mut body.shape else { continue };
        let of_file =
            read.entry(shape.file.clone()).or_insert_with(|| match stl::read(&deck.beside(&shape.file)) {
                Ok((surface, bytes)) => Some((Arc::new(surface), fingerprint(&bytes))),
                Err(error) => {
                    issues.push(error.issue_at(format!("bodies[{i}].shape.file")));
                    None
                }
            });
        if let Some((surface, print)) = of_file {
            shape.surface = Some(Arc::clone(surface));
            out.push(*print);
        }
    }
    out
}

/// Reads the displacements of imperfections into the model; returns the fingerprints of their files.
fn displacements(deck: &Deck, model: &mut Model, issues: &mut Vec<Issue>) -> Vec<u64> {
    let mut out = Vec::new();
    for (i, imperfection) in model.imperfections.iter_mut().enumerate() {
        let Imperfection::File(keys) = imperfection else { continue };
        match node_table::read(&deck.beside(&keys.file)) {
            Ok((table, bytes)) => {
                keys.displacements = Some(Arc::new(table));
                out.push(fingerprint(&bytes));
            }
            Err(error) => issues.push(error.issue_at(format!("imperfections[{i}].file"))),
        }
    }
    out
}

fn issues_of(error: Error) -> Vec<Issue> {
    match error {
        Error::Model(issues) => issues,
        other => vec![Issue::new("", other.to_string(), "")],
    }
}
