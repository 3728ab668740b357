//! Models that turn: their centrifugal loads, and loads that would turn with them.

use std::collections::BTreeMap;

use super::StepModel;
use super::actions::Loaded;
use crate::checker::Checker;
use crate::load::CentrifugalLoad;
use crate::mesh::Mesh;
use crate::model::loads::Action;
use crate::model::{self, Analysis, LinearSolver, Load};
use crate::norm::larger;
use crate::system::Coordinates;
use crate::{Issue, Vec3};

/// Angle between two axes, and their distance over that from the origin, up to which they are one.
const SAME_AXIS: f64 = 1e-9;

/// Centrifugal loads, and the number of the load of the model that each belongs to.
pub(super) fn centrifugal_loads(
    step: &StepModel,
    mesh: &Mesh,
    coordinates: &Coordinates,
    amplitudes: &BTreeMap<String, usize>,
) -> (Vec<CentrifugalLoad>, Vec<usize>) {
    let (mut out, mut load_of) = (Vec::new(), Vec::new());
    for (number, (load, continued)) in step.model.loads.iter().zip(&step.loads).enumerate() {
        let amplitude = load.amplitude().as_ref().and_then(|a| amplitudes.get(a).copied());
        for action in load.actions(&Loaded::new(load, mesh, coordinates)) {
            if let Action::Centrifugal { axis, at, velocity, with_ground } = action {
                let factor = continued.factor(amplitude);
                out.push(CentrifugalLoad { axis, at, velocity, with_ground, factor });
                load_of.push(number);
            }
        }
    }
    (out, load_of)
}

/// Centrifugal loads that an analysis step cannot have.
pub(super) fn centrifugal(step: &StepModel) -> Vec<Issue> {
    let mut c = Checker::default();
    let mut first: Option<&model::CentrifugalLoad> = None;
    for (i, (load, continued)) in step.model.loads.iter().zip(&step.loads).enumerate() {
        let Load::Centrifugal(keys) = load else { continue };
        let key = format!("loads[{i}]");
        let [axis, at] = [keys.axis, keys.at].map(Vec3::from);
        if !(axis.norm() > 0.0) {
            c.add(format!("{key}.axis"), "the axis has no direction", "give a vector that is not zero");
        }
        let other = *first.get_or_insert(keys);
        let apart =
            axis.cross(&Vec3::from(other.axis)).norm() / (axis.norm() * Vec3::from(other.axis).norm());
        let offset = (at - Vec3::from(other.at)).cross(&axis.normalize());
        if apart > SAME_AXIS || offset.norm() > SAME_AXIS * larger(at.norm(), Vec3::from(other.at).norm()) {
            c.add(&key, "the model turns about two axes", "leave one of the centrifugal loads out");
        }
        let analysis = &step.model.analysis;
        let iterative = matches!(analysis, Analysis::Static(s) if s.linear_solver == LinearSolver::Iterative);
        if matches!(analysis, Analysis::Modal(modal) if !modal.prestressed && step.starts_from.is_none()) {
            c.add(
                &key,
                "modes of a model that turns are those about its equilibrium under centrifugal forces",
                "say `prestressed = true` in the analysis, or leave the load out",
            );
        }
        if matches!(analysis, Analysis::Transient(_)) && !continued.released {
            c.add(
                &key,
                "a transient analysis describes motions in the fixed frame, which has no centrifugal forces",
                "leave the load out and give initial velocities; a static step before may have the load",
            );
        } else if iterative {
            c.add(
                &key,
                "the linear solver \"iterative\" has no centrifugal forces",
                "take the linear solver \"direct\", or leave the load out",
            );
        }
    }
    c.issues
}

/// Loads whose direction is constant in space, in a model that turns about an axis across it.
pub(super) fn loads_across_the_axis(step: &StepModel, mesh: &Mesh, coordinates: &Coordinates) -> Vec<Issue> {
    let active = || {
        let loads = step.model.loads.iter().zip(&step.loads).enumerate();
        loads
            .filter(|(_, (_, continued))| !continued.released)
            .map(|(i, (load, _))| (i, load.actions(&Loaded::new(load, mesh, coordinates))))
    };
    let turning = active().flat_map(|(_, actions)| actions).find_map(|action| match action {
        Action::Centrifugal { axis, with_ground, .. } => Some((axis, with_ground)),
        _ => None,
    });
    let Some((axis, with_ground)) = turning else { return Vec::new() };
    let across = |vector: &Vec3| vector.cross(&axis).norm() > SAME_AXIS * vector.norm();
    let issue = |(i, actions): (usize, Vec<Action>)| {
        let key = format!("loads[{i}]");
        let gravity = |action: &Action| matches!(action, Action::Gravity(value) if across(value));
        if actions.iter().any(gravity) {
            return Some(Issue::new(
                key,
                "gravity across the axis turns round in the frame of a model that turns, in which it is described",
                "leave out gravity or its part across the axis, or compute a transient analysis in the fixed frame",
            ));
        }
        let constant = |action: &Action| match action {
            Action::Force { force: value, .. }
            | Action::Moment { moment: value, .. }
            | Action::EdgeMoment { moment: value, .. } => across(value),
            Action::Gravity(_)
            | Action::Centrifugal { .. }
            | Action::Pressure { .. }
            | Action::FollowerForce { .. }
            | Action::FollowerMoment { .. }
            | Action::Follower(_) => false,
        };
        (!with_ground && actions.iter().any(constant)).then(|| {
            Issue::new(
                key,
                "a load across the axis of a model that turns would turn with it",
                "where it does, say `ground = \"turns\"` in the load \"centrifugal\"; else compute a transient analysis in the fixed frame",
            )
        })
    };
    active().filter_map(issue).collect()
}
