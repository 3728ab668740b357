//! Loads of an analysis step that depend on the displacements, and the sets whose forces are reported.

use std::collections::BTreeMap;

use super::actions::{drilling_components, follower_loads};
use super::step_joints::{Released, StepJoints};
use super::steps::StepModel;
use super::{Compiler, force_sets, relief, turning};
use crate::Issue;
use crate::load::{CentrifugalLoad, Dependence, FollowerLoad, LoadOnNodes, OwnLoad};
use crate::model::{Analysis, Scheme};
use crate::system::dof_map::DofMap;
use crate::system::{ForceSet, InertiaRelief};

/// Loads of a step that depend on the displacements, each with the number of the load of the model that it belongs to.
pub(super) struct StepLoads {
    /// Follower loads.
    pub(super) followers: Vec<FollowerLoad>,
    /// Load of each follower load.
    pub(super) load_of_follower: Vec<usize>,
    /// Centrifugal loads.
    pub(super) centrifugal: Vec<CentrifugalLoad>,
    /// Load of each centrifugal load.
    pub(super) load_of_centrifugal: Vec<usize>,
    /// Nodes on which each load acts.
    pub(super) load_sets: Vec<ForceSet>,
    /// Nodes that each condition supports.
    pub(super) support_sets: Vec<ForceSet>,
}

impl Compiler<'_> {
    /// Loads of a step that depend on the displacements: those of the model, of the caller, and the couples of released constraints.
    pub(super) fn step_loads(
        &self,
        step: &StepModel,
        (names, dofs): (&BTreeMap<String, usize>, &DofMap),
        (released, inertia_relief): (&[Released], Option<&mut InertiaRelief>),
        issues: &mut Vec<Issue>,
    ) -> StepLoads {
        let (model, mesh, vectors) = (&step.model, self.mesh, &self.vectors);
        let (mut followers, mut load_of_follower) = follower_loads(step, mesh, (vectors, dofs), names);
        let mut load_sets = force_sets::of_loads(model, mesh);
        for (name, load) in &self.own_loads {
            load_of_follower.push(load_sets.len());
            load_sets.push(force_sets::of_caller(name, mesh));
            followers.push(of_caller(load, step));
        }
        for (name, load) in &self.field_loads {
            issues.extend(refused_field(name, load, step));
            load_of_follower.resize(followers.len() + load.vectors().len(), load_sets.len());
            load_sets.push(force_sets::of_caller(name, mesh));
            let factor = step.of_caller.factor(None);
            let nodes = 0..load.vectors().len();
            followers.extend(nodes.map(|place| FollowerLoad::Field { load: load.clone(), place, factor }));
        }
        let mut support_sets = force_sets::of_conditions(model, mesh);
        if let Some(relief) = inertia_relief {
            relief.load_set = load_sets.len();
            load_sets.push(force_sets::of_caller(relief::NAME, mesh));
            support_sets.push(force_sets::of_relief(mesh));
        }
        issues.extend(relief::refused(step));
        let (centrifugal, load_of_centrifugal) =
            turning::centrifugal_loads(step, mesh, &vectors.coordinates, names);
        issues.extend(turning::centrifugal(step));
        issues.extend(turning::loads_across_the_axis(step, mesh, &vectors.coordinates));
        if model.analysis.seeks_equilibria() {
            let (couples, loads) = StepJoints::couples(released, load_sets.len());
            followers.extend(couples);
            load_of_follower.extend(loads);
        }
        issues.extend(drilling_components(&followers, &load_of_follower, vectors, mesh));
        StepLoads { followers, load_of_follower, centrifugal, load_of_centrifugal, load_sets, support_sets }
    }
}

/// Load of a caller in an analysis step: new in the first one, continued in the others.
fn of_caller(load: &OwnLoad, step: &StepModel) -> FollowerLoad {
    FollowerLoad::Own { load: load.clone(), factor: step.of_caller.factor(None) }
}

/// A step that cannot have a load of the caller on many nodes.
fn refused_field(name: &str, load: &LoadOnNodes, step: &StepModel) -> Option<Issue> {
    let dependence = load.dependence();
    let (reason, help) = match &step.model.analysis {
        Analysis::Buckling(_) => (
            "a buckling analysis has loads that grow in proportion, and these are functions",
            "find the load by a static analysis or along a path",
        ),
        Analysis::Modal(keys)
            if step.starts_from.is_none() && !keys.prestressed && keys.speeds.is_empty() =>
        {
            (
                "a modal analysis alone has no loads, and so not their stiffness",
                "set `prestressed = true`, or put a static analysis before it by [[steps]]",
            )
        }
        Analysis::Static(keys) if keys.linear && dependence > Dependence::Time => LINEAR,
        Analysis::Transient(keys) if keys.linear && dependence > Dependence::Time => LINEAR,
        Analysis::Transient(keys) if dependence == Dependence::Velocities => match &keys.scheme {
            Scheme::EnergyMomentum(scheme) if scheme.order > 2 => {
                ("steps of order 4 go backwards in time, where dampers feed", "use `order = 2` of the scheme")
            }
            _ => return None,
        },
        _ => return None,
    };
    Some(Issue::new("loads", format!("the load \"{name}\" of the caller cannot act: {reason}"), help))
}

/// Refusal of loads that depend on the motion where displacements are small.
const LINEAR: (&str, &str) = (
    "a linear analysis evaluates loads in the reference configuration, and this one depends on the motion",
    "leave `linear` out, or make the load a function of the time alone",
);
