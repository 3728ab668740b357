//! Start of an analysis step: what holds the model, its velocities, and the loads that it has from there.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::procedure::explicit_scheme;
use super::step_joints::{Released, StepJoints};
use super::steps::StepModel;
use super::{
    Compiler, amplitudes, bodies, check, dead_loads, force_sets, foundations, initial_velocity, mechanism,
    patches, relief, supports,
};
use crate::Issue;
use crate::analysis::{path, statics};
use crate::constraint::Joint;
use crate::element::Nodal;
use crate::load::LoadFactor;
use crate::mesh::Mesh;
use crate::model::{Analysis, Model};
use crate::system::supports::Support;
use crate::system::{DeadLoad, LocalFrames, StepStart, System, lumping};

/// Two nodal vectors and the mass that is added for them.
type AddedEntry = (u32, u32, f64);

impl Compiler<'_> {
    /// Motions that nothing holds in a search for equilibria; models with joints, springs and beams are judged later. Supports of inertia
    /// relief are chosen in the configuration `at_start`, and the others hold there as in the reference.
    pub(super) fn unheld(
        &self,
        model: &Model,
        joints: &[Joint],
        supports: &[Support],
        at_start: Option<Vec<Nodal>>,
    ) -> Vec<Issue> {
        let mut issues = Vec::new();
        let alone = joints.iter().all(|joint| joint.rows.is_empty())
            && !model.has_springs()
            && model.beams.is_empty();
        if !model.analysis.seeks_equilibria() || !alone {
            return issues;
        }
        if model.foundations.is_empty() {
            let mut coordinates = Arc::clone(&self.vectors.coordinates);
            if let Some(at_start) = at_start {
                Arc::make_mut(&mut coordinates).reference = at_start;
            }
            issues.extend(mechanism::mechanisms(self.mesh, &coordinates, supports));
        }
        issues.extend(patches::spinning(&self.vectors.coordinates, &self.beams));
        issues
    }

    /// Velocities that the start of a transient step adds to those of its first state.
    pub(super) fn initial_velocities(
        &self,
        step: &StepModel,
        (frames, start): (&LocalFrames, Option<&StepStart>),
        issues: &mut Vec<Issue>,
    ) -> Vec<Nodal> {
        let (model, coordinates) = (&step.model, &self.vectors.coordinates);
        let current = self.current(start);
        let mut out = initial_velocity(model, self.mesh, &self.vectors, &current);
        if !self.moved_before(step) {
            bodies::add_velocities(model, (coordinates, &current), &mut out);
        }
        issues.extend(patches::carry_velocities(coordinates, frames.dofs(), self.mesh, &mut out));
        out
    }

    /// Adds masses of explicit steps, dead loads, and what joints and supports that the step does not have any more leave; checks what needs
    /// the whole system.
    pub(super) fn add_dead_loads(
        &self,
        step: &StepModel,
        system: &mut System,
        (names, added): (&BTreeMap<String, usize>, &[AddedEntry]),
        (released, issues): (Vec<Released>, &mut Vec<Issue>),
    ) {
        let model = &step.model;
        issues.extend(check::masses(model, system));
        issues.extend(relief::without_mass(system));
        if let Some(scheme) = explicit_scheme(&model.analysis).filter(|_| issues.is_empty()) {
            // Before gravity is found: bodies of lumped mass shall fall without rotation.
            issues.extend(lumping::lump(system, added, scheme.scale_director_inertia));
        }
        (system.dead_loads, system.load_of_dead) = dead_loads(step, self.mesh, system, names);
        let is_static = model.analysis.seeks_equilibria();
        if is_static {
            StepJoints::release(released, system);
            issues.extend(foundations::free_motions(model, system));
        }
        if issues.is_empty() && is_static && !self.keeps_supports(step, &system.supports) {
            release_supports(system, self.mesh);
        }
        let options = match &model.analysis {
            Analysis::Path(options) => Some(options.clone()),
            Analysis::Static(options) => options.continuation.map(|_| statics::path_options()),
            Analysis::Modal(_) | Analysis::Buckling(_) | Analysis::Transient(_) => None,
        };
        if issues.is_empty() {
            let found = options.and_then(|options| path::outside_of_scope(system, &options));
            let is_static = matches!(model.analysis, Analysis::Static(_));
            let help = "take loads that grow from 0 smoothly with the load factor, or leave `continue` out";
            let of_static = |issue: Issue| Issue::new("analysis.continue", issue.message, help);
            let place = |issue: Issue| if is_static { of_static(issue) } else { issue };
            issues.extend(found.map(place));
        }
    }

    /// Whether a transient step comes before a step: bodies then have the velocities at its end, and no longer those of the model.
    fn moved_before(&self, step: &StepModel) -> bool {
        let before = |step: &StepModel| step.starts_from.and_then(|index| self.steps.get(index));
        let chain = std::iter::successors(before(step), |step| before(step));
        chain.into_iter().any(|step| matches!(step.model.analysis, Analysis::Transient(_)))
    }

    /// Whether a step has all supports of the step before: then its first state needs no other forces than its own.
    fn keeps_supports(&self, step: &StepModel, supports_now: &[Support]) -> bool {
        let Some(before) = step.starts_from.and_then(|index| self.steps.get(index)) else { return false };
        let (_, names) = amplitudes::time_functions(&before.model, &mut Vec::new());
        let place = |s: &Support| (s.vector, [s.direction.x, s.direction.y, s.direction.z].map(f64::to_bits));
        let now: BTreeSet<_> = supports_now.iter().map(place).collect();
        let before = supports(&before.model, self.mesh, &self.vectors, &names, &mut Vec::new());
        before.iter().all(|s| now.contains(&place(s)))
    }
}

/// Replaces the supports that the step before had and a static step has not by their reactions: a dead load that falls to
/// 0 with the load factor, as released loads do.
fn release_supports(system: &mut System, mesh: &Mesh) {
    if let Some(force) = statics::released_reactions(system) {
        let factor = LoadFactor { start: 1.0, released: true, ..LoadFactor::new(None) };
        system.load_of_dead.push(system.load_sets.len());
        system.load_sets.push(force_sets::of_released_supports(mesh, &system.load_sets));
        system.dead_loads.push(DeadLoad { force, factor, gravity: false });
    }
}
