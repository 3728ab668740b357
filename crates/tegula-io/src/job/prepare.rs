//! From the model file to the mesh and the compiled system.

use tegula::compile::{self, check, warnings};
use tegula::mesh::generators;
use tegula::model::MeshSource;
use tegula::result::Probe;
use tegula::{Error, Issue, Mesh, System};

use super::JobError;
use crate::deck::{Deck, Diagnostic};
use crate::memory;
use crate::mesh::{MeshError, gmsh};
use crate::out::fingerprint;

/// A model file ready to run.
pub struct Prepared {
    /// The mesh.
    pub mesh: Mesh,
    /// The compiled model.
    pub system: System,
    /// The recorded points.
    pub probes: Vec<Probe>,
    /// Warnings: the model can be computed but is most likely not meant so.
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
    let compiled = compile::build(&deck.model, &mesh).and_then(|system| {
        let probes = Probe::all(&deck.model.output.points, &mesh, &system)?;
        Ok((system, probes))
    });
    match compiled {
        Ok((system, probes)) => {
            let warnings = deck.locate(&warnings(&deck.model, &mesh, &system));
            Ok(Prepared { mesh, system, probes, warnings, fingerprint })
        }
        Err(error) => Err(located(issues_of(error))),
    }
}

/// The mesh, and the fingerprint of the files that the model is made of.
fn mesh(deck: &Deck) -> Result<(Mesh, u64), Vec<Issue>> {
    let text = fingerprint(&deck.text);
    let MeshSource::Gmsh(source) = &deck.model.mesh else {
        return generators::generate(&deck.model.mesh).map(|mesh| (mesh, text)).map_err(issues_of);
    };
    let path = deck.beside(&source.file);
    let issue = |error: MeshError| vec![error.issue()];
    let bytes = gmsh::load(&path).map_err(issue)?;
    let mut mesh = gmsh::parse(&path, &bytes, source.scale).map_err(issue)?;
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
