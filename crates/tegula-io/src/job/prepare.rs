//! From the model file to the mesh and the compiled system.

use tegula::mesh::generators;
use tegula::model::{Analysis, LinearSolver, MeshSource, Model, Scheme, build, check, warnings};
use tegula::result::Probe;
use tegula::{Error, Issue, Mesh, System};

use super::{JobError, process};
use crate::deck::{Deck, Diagnostic};
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
    /// What is most likely not meant, though it can be computed.
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
    if let Some(issue) = too_large(&deck.model, process::machine_memory_bytes()) {
        return Err(located(vec![issue]));
    }
    let (mesh, fingerprint) = mesh(deck).map_err(|mut issues| {
        // Without a mesh the sets cannot be checked, but everything else can.
        issues.extend(check::keys(&deck.model));
        located(issues)
    })?;
    let compiled = build::build(&deck.model, &mesh).and_then(|system| {
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
    let issues = mesh.name_points(&source.points);
    if !issues.is_empty() {
        return Err(issues);
    }
    let both = [text.to_le_bytes(), fingerprint(&bytes).to_le_bytes()].concat();
    Ok((mesh, fingerprint(both)))
}

/// Least memory of an element of a large mesh (bytes). What it takes on regular meshes, and more on others, is in the
/// book: *How cost grows with the mesh* and *Linear solvers*.
fn least_per_element(analysis: &Analysis) -> u64 {
    match analysis {
        // Its nodes and its matrices where no other element has its shape; a million elements took 4.1 kB each.
        Analysis::Transient(t) if matches!(t.scheme, Scheme::Explicit(_)) => 4_000,
        // Its share of pieces and of the coarse matrix: 13.7 kB, and less where directors have two unknowns.
        Analysis::Static(s) if s.linear_solver == LinearSolver::Iterative => 10_000,
        // Its share of the pattern and of the factor: 22 kB at 65 000 elements, and it grows with their number.
        _ => 20_000,
    }
}

/// Elements that the machine cannot hold: said before the attempt, which would end without a word.
fn too_large(model: &Model, memory: Option<u64>) -> Option<Issue> {
    let grid = match &model.mesh {
        MeshSource::Plate(m) => &m.grid,
        MeshSource::Cylinder(m) => &m.grid,
        MeshSource::Annulus(m) => &m.grid,
        MeshSource::Sphere(m) => &m.grid,
        MeshSource::Extrusion(m) => &m.grid,
        MeshSource::Gmsh(_) => return None,
    };
    let [u, v] = grid.elements.map(u64::from);
    let (needed, there) = (u.saturating_mul(v).saturating_mul(least_per_element(&model.analysis)), memory?);
    let gibibytes = |bytes: u64| bytes as f64 / f64::from(1 << 30);
    (needed > there).then(|| {
        Issue::new(
            "mesh.grid.elements",
            format!(
                "{u} x {v} elements need more than {:.0} GiB of memory, this machine has {:.0} GiB",
                gibibytes(needed),
                gibibytes(there)
            ),
            match &model.analysis {
                Analysis::Static(s) if s.linear_solver == LinearSolver::Direct => {
                    "use fewer elements, or `linear_solver = \"iterative\"`, which takes less memory"
                }
                _ => "use fewer elements",
            },
        )
    })
}

fn issues_of(error: Error) -> Vec<Issue> {
    match error {
        Error::Model(issues) => issues,
        other => vec![Issue::new("", other.to_string(), "")],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tegula::model::{ExplicitScheme, Grid, Isotropic, PlateMesh, StaticAnalysis, TransientAnalysis};

    #[test]
    fn meshes_that_do_not_fit_are_refused() {
        let plate = |n, analysis| {
            let mesh = MeshSource::Plate(PlateMesh {
                origin: [0.0; 3],
                u_axis: [1.0, 0.0, 0.0],
                v_axis: [0.0, 1.0, 0.0],
                size: [1.0, 1.0],
                grid: Grid::uniform(n, n),
            });
            Model::new(mesh, analysis, Isotropic::new(2.1e11, 0.3, 7850.0), 0.01)
        };
        let statics =
            |linear_solver| Analysis::Static(StaticAnalysis { linear_solver, ..Default::default() });
        let transient =
            |scheme| Analysis::Transient(TransientAnalysis { scheme, ..TransientAnalysis::new(1.0) });
        let direct = || statics(LinearSolver::Direct);
        let iterative = || statics(LinearSolver::Iterative);
        let explicit = || transient(Scheme::Explicit(ExplicitScheme::default()));
        let fits =
            |n, analysis, gibibytes: u64| too_large(&plate(n, analysis), Some(gibibytes << 30)).is_none();
        // Measured: a million elements take 14 GB with the iterative solver, and 4.1 GB with explicit steps.
        for (analysis, few, enough) in [
            (direct(), 18, 19),
            (transient(Scheme::default()), 18, 19),
            (iterative(), 9, 13),
            (explicit(), 3, 4),
        ] {
            assert!(!fits(1000, analysis.clone(), few) && fits(1000, analysis, enough));
        }
        let message = |analysis| too_large(&plate(4000, analysis), Some(24 << 30)).unwrap();
        let issue = message(direct());
        assert_eq!(
            issue.message,
            "4000 x 4000 elements need more than 298 GiB of memory, this machine has 24 GiB"
        );
        assert!(issue.help.contains("iterative"), "{}", issue.help);
        assert!(message(explicit()).message.contains("more than 60 GiB"));
        assert_eq!(message(iterative()).help, "use fewer elements");
        assert!(too_large(&plate(4000, direct()), None).is_none());
    }
}
