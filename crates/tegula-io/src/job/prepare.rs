//! From the model file to the mesh and the compiled system.

use std::sync::Arc;

use tegula::compile::{Compiler, StepModel, check, soft_folds, warnings, warnings_before_start};
use tegula::mesh::generators;
use tegula::model::StopCondition;
use tegula::result::Probe;
use tegula::{Error, Issue, Mesh, System};

use super::{JobError, history};
use crate::deck::{Deck, Diagnostic};
use crate::memory;
use crate::mesh::{self, FileMesh};
use crate::out::fingerprint;

/// A model file ready to run.
pub struct Prepared {
    /// The mesh.
    pub mesh: Arc<Mesh>,
    /// The compiled model; of several analysis steps the first one.
    pub system: System,
    /// The recorded points.
    pub probes: Vec<Probe>,
    /// Warnings: the model can be computed but is most likely not intended.
    pub warnings: Vec<Diagnostic>,
    /// Fingerprint of the model file and of its mesh file.
    pub fingerprint: u64,
}

/// Reads or generates the mesh and compiles the model.
///
/// # Errors
/// Everything that is wrong with the model, at its places in the file.
pub fn prepare(deck: &Deck) -> Result<Prepared, JobError> {
    let located = |issues: Vec<Issue>| JobError::Model(deck.locate(&issues));
    if let Some(issue) = memory::too_large(&deck.model, memory::limit()) {
        return Err(located(vec![issue]));
    }
    let (mesh, fingerprint) = mesh(deck).map_err(|mut issues| {
        // Without a mesh the sets cannot be checked, but everything else can.
        issues.extend(check::keys(&deck.model));
        located(issues)
    })?;
    match compiled(deck, &mesh) {
        Ok((system, probes, warnings)) => {
            let warnings = deck.locate(&warnings);
            Ok(Prepared { mesh: Arc::new(mesh), system, probes, warnings, fingerprint })
        }
        Err(error) => Err(located(issues_of(error))),
    }
}

/// System of the first analysis step, recorded points, and warnings. The systems of all later steps are made, too, so
/// that their mistakes show before anything is computed.
fn compiled(deck: &Deck, mesh: &Mesh) -> tegula::Result<(System, Vec<Probe>, Vec<Issue>)> {
    let compiler = Compiler::new(&deck.model, mesh)?;
    let first = compiler.system(0, None)?;
    let probes = Probe::all(&deck.model.output.points, mesh, &first)?;
    let mut issues = Vec::new();
    if let Some(step) = compiler.steps().first() {
        issues.extend(unknown_columns(step, &first, &probes));
    }
    if deck.model.steps.is_empty() && issues.is_empty() {
        let warnings = warnings(&deck.model, mesh, &first);
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
            return None;
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

/// The mesh, and the fingerprint of the files that the model is made of.
fn mesh(deck: &Deck) -> Result<(Mesh, u64), Vec<Issue>> {
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
    let both = [text.to_le_bytes(), fingerprint(&bytes).to_le_bytes()].concat();
    Ok((mesh, fingerprint(both)))
}

fn issues_of(error: Error) -> Vec<Issue> {
    match error {
        Error::Model(issues) => issues,
        other => vec![Issue::new("", other.to_string(), "")],
    }
}
