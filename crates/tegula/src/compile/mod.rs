//! Compilation: from the model and its mesh to the [`System`].

mod actions;
mod amplitudes;
pub mod check;
mod check_material;
mod check_sections;
mod checker;
mod congruence;
mod force_sets;
mod mechanism;
mod sections;
mod vectors;
mod warnings;

use std::collections::BTreeMap;

use crate::element::director_angle;
use crate::load::TimeFunction;
use crate::mesh::directors::Directors;
use crate::mesh::folds::Folds;
use crate::mesh::{Mesh, quality};
use crate::model::{Analysis, LinearSolver, Model, Scheme, StaticAnalysis, TransientAnalysis};
use crate::system::numbering::Numbering;
use crate::system::pattern::PatternBuilder;
use crate::system::{PrescribedField, System, lumping};
use crate::{Error, Issue, Result};
use actions::{
    added_masses, contradictions, dead_loads, drilling_components, follower_loads, initial_velocity, supports,
};
use sections::Elements;
use vectors::Vectors;
pub use warnings::warnings;

/// Compiles a model on its mesh.
///
/// # Errors
/// Everything that is wrong with the model, at once, each with the key or element and a remedy.
pub fn build(model: &Model, mesh: &Mesh) -> Result<System> {
    system(model, mesh).map_err(|error| match error {
        Error::Model(mut issues) => {
            mesh.name_file(&mut issues);
            Error::Model(issues)
        }
        other => other,
    })
}

fn system(model: &Model, mesh: &Mesh) -> Result<System> {
    let mut issues = check::keys(model);
    issues.extend(quality::check(mesh));
    issues.extend(check::sets(model, mesh));
    if !issues.is_empty() {
        return Err(Error::Model(issues));
    }
    let directors = Directors::of(mesh, model.mesh.fold_angle())?;
    let vectors = Vectors::new(mesh, &directors, &Elements::gradients(model, mesh, &directors));
    let mut elements = Elements::default();
    elements.shells(model, mesh, &directors, &vectors, &mut issues);
    let explicit = match &model.analysis {
        Analysis::Transient(TransientAnalysis { scheme: Scheme::Explicit(scheme), .. }) => Some(*scheme),
        _ => None,
    };
    let tie = if explicit.is_some() { director_angle::EXPLICIT_STIFFNESS } else { director_angle::STIFFNESS };
    elements.ties(&directors, &vectors, tie);
    let (amplitudes, names) = time_functions(model, &mut issues);
    let supports = supports(model, mesh, &vectors, &names, &mut issues);
    let numbering =
        match Numbering::new(vectors.reference.len(), &supports, &elements.unit, &vectors.reference) {
            Ok(n) => Some(n),
            Err(conflicts) => {
                issues.extend(contradictions(&conflicts, &vectors, mesh));
                None
            }
        };
    let Some(numbering) = numbering.filter(|_| issues.is_empty()) else { return Err(Error::Model(issues)) };
    if numbering.unknowns == 0 {
        issues.push(Issue::new(
            "conditions",
            "every coordinate of the model is supported: nothing is left to compute",
            "take nodes out of the supported sets",
        ));
    }
    if !matches!(model.analysis, Analysis::Transient(_) | Analysis::Modal(_)) {
        issues.extend(mechanism::mechanisms(
            mesh,
            &vectors.reference,
            &vectors.kinds,
            &vectors.nodes,
            &supports,
        ));
    }

    let (followers, load_of_follower) = follower_loads(model, mesh, &vectors, &names);
    issues.extend(drilling_components(&followers, &vectors, mesh));
    let added = added_masses(model, mesh, &vectors);
    // The iterative solver takes the elements' own blocks.
    let iterative = matches!(
        model.analysis,
        Analysis::Static(StaticAnalysis { linear_solver: LinearSolver::Iterative, .. })
    );
    let has_tangent_pattern = explicit.is_none() && !iterative;
    let mut builder = PatternBuilder::new(has_tangent_pattern);
    // Explicit steps need no tangent: their pattern has but the diagonal, for the lumped mass.
    if explicit.is_none() {
        for group in &elements.groups {
            for e in 0..group.len() {
                builder.element(group.vectors(e), group.mass(e));
            }
            builder.end_batch();
        }
        for load in &followers {
            builder.element(load.vectors(), &[]);
        }
        for &(a, b, m) in &added {
            builder.mass(a, b, m);
        }
    }
    let pattern = builder.build(vectors.reference.len(), &numbering)?;

    let linear = match &model.analysis {
        Analysis::Static(s) => s.linear,
        Analysis::Transient(t) => t.linear,
        Analysis::Modal(_) => false,
    };
    let proportional = matches!(model.analysis, Analysis::Static(_) | Analysis::Modal(_));
    let initial_velocity = initial_velocity(model, mesh, &vectors);
    let unit = if elements.unit.is_empty() {
        Vec::new()
    } else {
        (0..vectors.reference.len() as u32).map(|v| elements.unit.contains(&v)).collect()
    };
    let mut system = System {
        unit,
        numbering,
        groups: elements.groups,
        shells: elements.list,
        sections: elements.sections,
        prescribed_strains: model
            .prescribed_strains
            .iter()
            .map(|p| PrescribedField {
                strain: p.clone(),
                amplitude: p.amplitude().and_then(|a| names.get(a).copied()),
            })
            .collect(),
        dead_loads: Vec::new(),
        followers,
        supports,
        support_sets: force_sets::of_conditions(model, mesh),
        load_sets: force_sets::of_loads(model, mesh),
        load_of_dead: Vec::new(),
        load_of_follower,
        amplitudes,
        pattern,
        explicit: explicit.is_some(),
        has_tangent_pattern,
        mass_damping: model.damping.mass,
        length: mesh.extent(),
        linear,
        proportional,
        initial_velocity,
        reference: vectors.reference,
        kinds: vectors.kinds,
        nodes: vectors.nodes,
        position_of: vectors.position_of,
        director_of: vectors.director_of,
        labels: mesh.labels.clone(),
        folds: Folds::of(mesh, &directors),
        amplitude_names: names.keys().cloned().collect(),
        wanted_times: model.output.at.clone(),
    };
    issues.extend(check::masses(model, &system));
    if let Some(scheme) = explicit.filter(|_| issues.is_empty()) {
        // Before gravity is found: bodies of lumped mass shall fall without turning.
        issues.extend(lumping::lump(&mut system, &added, scheme.scale_director_inertia));
    }
    (system.dead_loads, system.load_of_dead) = dead_loads(model, mesh, &system, &names);
    if issues.is_empty() { Ok(system) } else { Err(Error::Model(issues)) }
}

/// Place of a pair in a lower triangle.
fn pair(a: usize, b: usize) -> usize {
    let (i, j) = (a.max(b), a.min(b));
    i * (i + 1) / 2 + j
}

fn time_functions(model: &Model, issues: &mut Vec<Issue>) -> (Vec<TimeFunction>, BTreeMap<String, usize>) {
    let mut functions = Vec::new();
    let mut names = BTreeMap::new();
    for (name, amplitude) in &model.amplitudes {
        match TimeFunction::new(amplitude) {
            Ok(f) => {
                names.insert(name.clone(), functions.len());
                functions.push(f);
            }
            Err((message, help)) => issues.push(Issue::new(amplitudes::key(name, amplitude), message, help)),
        }
    }
    (functions, names)
}
