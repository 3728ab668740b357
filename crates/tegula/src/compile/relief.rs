//! Inertia relief: rigid motions that supports leave, and statically determinate supports against them.

use super::steps::StepModel;
use crate::Issue;
use crate::Vec3;
use crate::element::Nodal;
use crate::model::joint::GROUND;
use crate::model::{Analysis, LinearSolver, Load, Model, StaticAnalysis};
use crate::norm::larger;
pub(super) use crate::system::inertia_relief::KEY;
use crate::system::supports::Support;
use crate::system::{Coordinates, InertiaRelief, System, VectorKind};

/// Name of the inertia forces among the loads, and of the added supports among the supports.
pub(super) const NAME: &str = "inertia_relief";
/// Square of a velocity over the largest one that is round-off.
const ROUND_OFF: f64 = 1e-12;

/// Static analysis with inertia relief of a step, if it is one.
pub(super) fn is_asked(model: &Model) -> bool {
    matches!(&model.analysis, Analysis::Static(StaticAnalysis { inertia_relief: true, .. }))
}

/// Rigid motions that the supports of a step leave, and supports of single components that hold the model against them; their
/// reactions vanish, since the inertia forces balance the loads. Positions are those at the start of the step.
///
/// # Errors
/// The supports leave no rigid motion, or no position can be supported against one.
pub(super) fn relief(
    supports: &[Support],
    coordinates: &Coordinates,
    (current, length): (&[Nodal], f64),
) -> Result<(InertiaRelief, Vec<Support>), Issue> {
    if supports.iter().any(|support| support.motion.is_some_and(|(value, _)| value != 0.0)) {
        return Err(Issue::new(
            KEY,
            "prescribed motions hold the model, where inertia relief lets it accelerate freely",
            "leave them or `inertia_relief` out",
        ));
    }
    let positions = || (0..current.len()).filter(|&v| coordinates.kinds[v] == VectorKind::Position);
    let about = positions().map(|v| Vec3::from(current[v])).sum::<Vec3>() / positions().count().max(1) as f64;
    // Velocity of a vector along a direction in the six rigid motions; rotations are scaled by the size of the model.
    let row = |v: usize, along: &Vec3| -> nalgebra::Vector6<f64> {
        let x = Vec3::from(current[v]);
        let (shift, arm) = match coordinates.kinds[v] {
            VectorKind::Position => (*along, x - about),
            _ => (Vec3::zeros(), x),
        };
        let turn = arm.cross(along) / length;
        nalgebra::Vector6::new(shift.x, shift.y, shift.z, turn.x, turn.y, turn.z)
    };
    let held: nalgebra::Matrix6<f64> = supports
        .iter()
        .map(|support| row(support.vector as usize, &support.direction))
        .map(|row| row * row.transpose())
        .sum();
    let parts = held.symmetric_eigen();
    let largest = parts.eigenvalues.amax();
    let free: Vec<nalgebra::Vector6<f64>> = (0..6)
        .filter(|&i| parts.eigenvalues[i] <= ROUND_OFF * largest)
        .map(|i| parts.eigenvectors.column(i).into_owned())
        .collect();
    if free.is_empty() {
        return Err(Issue::new(
            KEY,
            "the supports hold the model against all rigid motions",
            "leave `inertia_relief` out, or those supports that are no planes of symmetry",
        ));
    }
    let attached = coordinates.attached();
    let free_of_bodies = |v: &usize| attached.iter().all(|attached| attached.vector as usize != *v);
    let of_mesh = |v: &usize| coordinates.nodes[*v] != u32::MAX;
    let mut movable: Vec<usize> = positions().filter(free_of_bodies).filter(of_mesh).collect();
    if movable.is_empty() {
        movable = positions().filter(free_of_bodies).collect();
    }
    let mut left = free.clone();
    let mut added = Vec::new();
    for _ in 0..free.len() {
        let size = |(v, axis): (usize, usize)| {
            let row = row(v, &Vec3::ith(axis, 1.0));
            left.iter().map(|motion| motion.dot(&row).powi(2)).sum::<f64>()
        };
        let mut best: Option<((usize, usize), f64)> = None;
        for place in movable.iter().flat_map(|&v| (0..3).map(move |axis| (v, axis))) {
            let size = size(place);
            // Places that are equal but for round-off: the first one.
            if best.is_none_or(|(_, largest)| size > largest * (1.0 + 1e-9)) {
                best = Some((place, size));
            }
        }
        let Some(((v, axis), _)) = best.filter(|(_, size)| *size > ROUND_OFF) else {
            return Err(Issue::new(
                KEY,
                "no node can be supported against all rigid motions that the supports leave",
                "support the model in a statically determinate way",
            ));
        };
        let direction = Vec3::ith(axis, 1.0);
        added.push(Support { vector: v as u32, direction, motion: None, key: KEY.into() });
        left = without(&left, &row(v, &direction));
    }
    let motions = free.iter().map(|m| [Vec3::new(m[0], m[1], m[2]), Vec3::new(m[3], m[4], m[5]) / length]);
    Ok((InertiaRelief { motions: motions.collect(), about, load_set: 0 }, added))
}

/// Orthonormal basis of those combinations of orthonormal motions that do not move along a row.
fn without(motions: &[nalgebra::Vector6<f64>], row: &nalgebra::Vector6<f64>) -> Vec<nalgebra::Vector6<f64>> {
    let gradient: nalgebra::Vector6<f64> = motions.iter().map(|m| m * m.dot(row)).sum();
    let moved = gradient.normalize();
    let mut out: Vec<nalgebra::Vector6<f64>> = Vec::new();
    for motion in motions {
        let rest = motion - moved * moved.dot(motion);
        let rest = out.iter().fold(rest, |rest, other| rest - other * other.dot(&rest));
        if out.len() + 1 < motions.len() && rest.norm() > 1e-6 {
            out.push(rest.normalize());
        }
    }
    out
}

/// Refuses inertia relief of a model without mass, or without moment of inertia, along a motion that its supports leave.
pub(super) fn without_mass(system: &System) -> Option<Issue> {
    let relief = system.inertia_relief.as_ref()?;
    let masses = relief.masses(system).symmetric_eigenvalues();
    let largest = masses.iter().copied().fold(0.0, larger);
    masses.iter().any(|mass| !(*mass > ROUND_OFF * largest)).then(|| {
        Issue::new(
            KEY,
            "the model has no mass that balances its loads along one of its rigid motions",
            "give materials a density, sections a `total_mass`, or bodies a mass and `inertia`",
        )
    })
}

/// Parts of a model that inertia relief cannot have.
pub(super) fn refused(step: &StepModel) -> Vec<Issue> {
    let model = &step.model;
    let Analysis::Static(StaticAnalysis { inertia_relief: true, linear_solver, .. }) = &model.analysis else {
        return Vec::new();
    };
    let mut found = Vec::new();
    let mut add = |problem: String, help: &str| found.push(Issue::new(KEY, problem, help));
    let joints = model.joints.iter().map(|joint| ("joint", joint.common().name(), joint.common().between()));
    let springs = model.springs.iter().map(|spring| ("spring", spring.name.as_str(), &spring.between));
    let torsion =
        model.torsion_springs.iter().map(|spring| ("torsion spring", spring.name.as_str(), &spring.between));
    let bushings = model.bushings.iter().map(|bushing| ("bushing", bushing.name.as_str(), &bushing.between));
    let connections = joints.chain(springs).chain(torsion).chain(bushings);
    for (kind, name, _) in connections.filter(|(_, _, between)| between.iter().any(|side| side == GROUND)) {
        add(
            format!(
                "the {kind} \"{name}\" holds the model at the ground, where inertia relief lets it accelerate freely"
            ),
            "connect it to a part of the model, or leave it or `inertia_relief` out",
        );
    }
    if !model.foundations.is_empty() {
        add(
            "elastic foundations hold the model, where inertia relief lets it accelerate freely".into(),
            "leave them or `inertia_relief` out",
        );
    }
    if model.loads.iter().any(|load| matches!(load, Load::Centrifugal(_))) {
        add(
            "centrifugal forces belong to a model that turns, which inertia relief does not know".into(),
            "leave the load or `inertia_relief` out",
        );
    }
    if *linear_solver == LinearSolver::Iterative {
        add(
            "the linear solver \"iterative\" has no inertia relief".into(),
            "take the linear solver \"direct\"",
        );
    }
    found
}
