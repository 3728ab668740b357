//! Compilation: from the model and its mesh to the [`System`].

mod actions;
mod adaptive_integrals;
mod amplitudes;
mod assembly;
mod beams;
mod bodies;
mod body_inertia;
mod bushings;
pub mod check;
mod check_buckling;
mod check_material;
mod check_modal;
mod check_path;
mod check_sections;
mod closing;
mod congruence;
mod couplings;
mod cuts;
mod distributions;
mod factors;
mod force_sets;
mod foundations;
mod guided_axes;
mod imperfections;
mod inner_point;
mod layers;
mod mechanism;
mod mesh_sets;
mod outline;
mod own_parts;
mod patches;
mod pattern;
mod perturbation_steps;
mod place;
mod procedure;
mod relief;
mod sections;
mod sensors;
mod springs;
mod step_joints;
mod step_loads;
mod step_start;
mod steps;
mod stills;
mod ties;
mod turning;
mod turning_nodes;
mod uncorrected_shear;
mod vectors;
mod warnings;

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::Arc;

use crate::constraint::{
    Bushing, BushingGroup, FoundationElement, FoundationGroup, Joint, JointGroup, Sensor, Spring,
    SpringGroup, TorsionSpring, TorsionSpringGroup,
};
use crate::element::{ElementGroup, Nodal, director_angle};
use crate::load::{FollowerLoad, LoadOnNodes, OwnLoad};
use crate::material::{MaterialLaw, OwnLaw};
use crate::mesh::directors::Directors;
use crate::mesh::folds::Folds;
use crate::mesh::{Mesh, quality};
use crate::model::{Analysis, MeshSource, Model, PrescribedStrain, ResponseInput};
use crate::system::supports::Support;
use crate::system::{
    BeamLine, ClosedGaps, Cut, GroupOffsets, InertiaRelief, LocalFrames, Outline, PrescribedField, Procedure,
    Reduction, Shell, ShellSection, StepStart, System,
};
use crate::{Error, Issue, Result};
use actions::{added_masses, contradictions, dead_loads, initial_velocity, supports};
use assembly::Assembled;
pub use imperfections::imperfect_mesh;
use inner_point::Corners;
pub use mesh_sets::define_sets;
use pattern::ReducedLoads;
use place::Place;
use procedure::procedure;
use sections::Elements;
use step_joints::{JointGroups, Lock, StepJoints};
use steps::Continued;
pub use steps::{StepModel, steps};
use vectors::{Connections, Vectors};
pub use warnings::{soft_folds, warnings, warnings_at_start, warnings_before_start};

/// Compiles a model on its mesh; of a model with several analysis steps the first one.
///
/// # Errors
/// Everything that is wrong with the model, at once, each with the key or element and a remedy.
pub fn build(model: &Model, mesh: &Mesh) -> Result<System> {
    Compiler::new(model, mesh)?.system(0, None)
}

/// Compiler of a model: it makes nodal vectors and elements once, and from them a system for each analysis step.
pub struct Compiler<'a> {
    mesh: &'a Mesh,
    /// The model, with the nodes of its beams.
    model: Model,
    steps: Vec<StepModel>,
    directors: Directors,
    vectors: Vectors,
    groups: Arc<Vec<Arc<dyn ElementGroup>>>,
    offsets: Arc<Vec<GroupOffsets>>,
    joints: Arc<Vec<Joint>>,
    /// Sides of the joints that some step locks.
    locks: Vec<Option<Lock>>,
    /// Groups of the joints.
    joint_groups: JointGroups,
    /// Size of the model (length).
    length: f64,
    beams: Arc<Vec<BeamLine>>,
    springs: Arc<Vec<(String, Spring)>>,
    torsion_springs: Arc<Vec<(TorsionSpring, [usize; 2])>>,
    bushings: Arc<Vec<Bushing>>,
    sensors: Arc<Vec<Sensor>>,
    cuts: Arc<Vec<Cut>>,
    outline: Arc<Outline>,
    shells: Vec<Shell>,
    sections: Arc<Vec<ShellSection>>,
    /// Nodal vectors that keep their length.
    unit: BTreeSet<u32>,
    strains: Vec<PrescribedStrain>,
    /// Whether displacements are small.
    linear: bool,
    /// Loads of the caller with their names; they act in all steps.
    own_loads: Vec<(String, OwnLoad)>,
    /// Loads of the caller on many nodes with their names; they act in all steps.
    field_loads: Vec<(String, Arc<LoadOnNodes>)>,
    /// Starts of the steps that begin where the model is assembled.
    assembled: Vec<Option<Assembled>>,
}

impl<'a> Compiler<'a> {
    /// Checks a model on its mesh, and makes its nodal vectors and elements.
    ///
    /// # Errors
    /// Everything that is wrong with keys, sets, mesh, sections and supports, at once, each with a remedy.
    pub fn new(model: &Model, mesh: &'a Mesh) -> Result<Self> {
        Self::with_own_parts(model, mesh, &BTreeMap::new(), false)
    }

    fn compiled(
        model: &Model,
        mesh: &'a Mesh,
        laws: &BTreeMap<String, Arc<dyn MaterialLaw>>,
        loaded: bool,
    ) -> Result<Self> {
        let without_shells = model.mesh == MeshSource::None && mesh.quads.is_empty();
        let (model, steps) = checked(model, mesh, laws, loaded)?;
        let model = &model;
        let mut issues = Vec::new();
        let laws = laws.iter().map(|(name, law)| (name.clone(), OwnLaw(Arc::clone(law)))).collect();
        let directors =
            if without_shells { Directors::default() } else { Directors::of(mesh, model.mesh.fold_angle())? };
        let mut vectors = Vectors::new(mesh, &directors, &Elements::gradients(model, mesh, &directors));
        let strains = steps::all_strains(model);
        let whole = Model { prescribed_strains: strains.clone(), ..model.clone() };
        let mut elements = Elements::default();
        elements.shells(&whole, mesh, &directors, &vectors, &laws, &mut issues);
        let explicit = steps.iter().any(|step| procedure(&step.model.analysis) == Procedure::Explicit);
        let tie = if explicit { director_angle::EXPLICIT_STIFFNESS } else { director_angle::STIFFNESS };
        elements.ties(&directors, &vectors, tie);
        let Connections { mut joints, springs, torsion_springs, bushings } =
            vectors.add_bodies((model, mesh), &mut elements, &mut issues);
        let length = bodies::extent(model, mesh, &vectors.coordinates);
        let corners = Corners::new(mesh, &elements);
        let place = Place { model, mesh, coordinates: &vectors.coordinates, length, corners: &corners };
        let locks = step_joints::locks(&place, &steps, &mut joints, &mut issues);
        let joints = Arc::new(joints);
        let (of_beams, mut beams) = beams::elements(model, &vectors.coordinates);
        beams.iter_mut().for_each(|beam| beam.group += elements.groups.len());
        elements.groups.extend(of_beams);
        let foundations = foundations::elements(model, mesh, &vectors.coordinates);
        let (joint_groups, places) = add_groups(
            &mut elements.groups,
            (&joints, &foundations),
            (&springs, &torsion_springs),
            &bushings,
        );
        let place = Place { model, mesh, coordinates: &vectors.coordinates, length, corners: &corners };
        let sensors = sensors::sensors(&place, &joints, &mut issues);
        let outline = outline::outline(&place, &beams);
        let offsets = GroupOffsets::of(&elements.groups);
        let cuts = cuts::cuts((model, mesh), &vectors.coordinates, (&elements, &offsets), &mut issues);
        vectors.mark_inextensible(&elements.unit);
        let mut compiler = Self {
            mesh,
            model: model.clone(),
            linear: steps.iter().any(is_linear),
            steps,
            directors,
            vectors,
            offsets: Arc::new(offsets),
            groups: Arc::new(elements.groups.into_iter().map(Arc::from).collect()),
            joints,
            locks,
            joint_groups,
            length,
            beams: Arc::new(beams),
            springs: Arc::new(model.springs.iter().map(|spring| spring.name.clone()).zip(springs).collect()),
            torsion_springs: Arc::new(torsion_springs.into_iter().zip(places).collect()),
            bushings: Arc::new(bushings),
            sensors: Arc::new(sensors),
            cuts: Arc::new(cuts),
            outline: Arc::new(outline),
            shells: elements.list,
            sections: Arc::new(elements.sections),
            unit: elements.unit,
            strains,
            own_loads: Vec::new(),
            field_loads: Vec::new(),
            assembled: Vec::new(),
        };
        compiler.check_supports(&mut issues);
        if issues.is_empty() {
            let coordinates = Arc::clone(&compiler.vectors.coordinates);
            let place = Place { model, mesh, coordinates: &coordinates, length, corners: &corners };
            compiler.assembled = compiler.assembled(&place, &mut issues);
        }
        if issues.is_empty() { Ok(compiler) } else { Err(Error::Model(issues)) }
    }

    /// Checks the supports of all steps in the reference configuration.
    fn check_supports(&self, issues: &mut Vec<Issue>) {
        for step in &self.steps {
            let mut found = Vec::new();
            let (_, names) = amplitudes::time_functions(&step.model, &mut found);
            self.frames(step, &names, None, &mut found);
            issues.extend(
                step.located(found).into_iter().filter(|issue| !issues.contains(issue)).collect::<Vec<_>>(),
            );
        }
    }

    /// Analysis steps of the model.
    pub fn steps(&self) -> &[StepModel] {
        &self.steps
    }

    /// Takes over at which time or load factor a step has ended: the loads of later steps continue from there.
    pub fn end_step(&mut self, step: usize, at: f64) {
        let mut ends: Vec<f64> = self.steps.iter().map(|step| step.ends_at).collect();
        if let Some(end) = ends.get_mut(step) {
            *end = at;
            self.steps = steps::steps_with_ends(&self.model, &ends);
        }
    }

    /// System of an analysis step that begins at `start` (where `None` at rest in the reference configuration, or where joints do not meet there,
    /// in the assembled one).
    ///
    /// # Errors
    /// Everything that is wrong with loads, supports and masses of the step, at once, each with a remedy; there is no such
    /// step.
    pub fn system(&self, step: usize, start: Option<StepStart>) -> Result<System> {
        let assembled = self.assembled.get(step).cloned().flatten().filter(|_| start.is_none());
        let Some(step) = self.steps.get(step) else {
            return Err(Error::model(
                "steps",
                format!("there is no step {step}"),
                "name a step of the model",
            ));
        };
        let (vectors, history) =
            (self.vectors.coordinates.len(), self.offsets.last().map_or(0, |last| last.history.end));
        let constraints = self.constraints_in(self.step_before(step));
        let angles =
            self.sensor_angles() + self.joints.iter().filter(|joint| joint.counted.is_some()).count();
        let fits = |s: &StepStart| {
            s.u.len() == vectors
                && (s.v.is_empty() || s.v.len() == vectors)
                && (s.history.len(), s.multipliers.len()) == (history, constraints)
                && s.angles.len() == angles
        };
        if start.as_ref().is_some_and(|start| !fits(start)) {
            return Err(Error::model(
                "steps",
                format!(
                    "the start has not the {vectors} nodal vectors, {history} history variables, {constraints} multipliers and \
                     {angles} angles of the model"
                ),
                "take the start from a state of this model, by `State::end_of_step`",
            ));
        }
        let before = step.starts_from.and_then(|before| self.steps.get(before));
        if let Some((start, before)) = start.as_ref().zip(before)
            && before.model.analysis.seeks_equilibria()
            && start.time != before.ends_at
        {
            return Err(Error::model(
                "steps",
                format!(
                    "the step before has ended at load factor {}, and the loads of this one continue from load factor {}",
                    start.time, before.ends_at
                ),
                "tell the compiler where the step before has ended, by `Compiler::end_step`",
            ));
        }
        let earlier = before.and_then(|before| self.steps.get(before.starts_from?));
        if let Some((before, what)) = before.and_then(|before| Some((before, before.falling(earlier)?))) {
            return Err(Error::model(
                "steps",
                format!(
                    "the step before has ended at load factor {}, where {what} has not fallen to 0 yet",
                    before.ends_at
                ),
                "let that step end at load factor 1, and give the analysis that ends early a step of its own",
            ));
        }
        let (start, closed_gaps) = match assembled {
            Some((start, gaps)) => (Some(start), Some(gaps)),
            None => (start, None),
        };
        self.compile(step, (start, closed_gaps)).map_err(|error| match error {
            Error::Model(issues) => named(Error::Model(step.located(issues)), self.mesh),
            other => other,
        })
    }

    /// Number of the sensors that measure an angle, whose angles stand before those of gears.
    fn sensor_angles(&self) -> usize {
        self.sensors.iter().filter(|sensor| sensor.angle().is_some()).count()
    }

    /// Nodal vectors where an analysis step starts; those of the reference where displacements are small.
    fn current(&self, start: Option<&StepStart>) -> Vec<Nodal> {
        let reference = &self.vectors.coordinates.reference;
        match start {
            Some(start) if !self.linear => {
                let add = |(x, u): (&Nodal, &Nodal)| std::array::from_fn(|i| x[i] + u[i]);
                reference.iter().zip(&start.u).map(add).collect()
            }
            _ => reference.clone(),
        }
    }

    /// Supports of a step and the numbers of its free degrees of freedom; `None` where supports contradict each other.
    fn frames(
        &self,
        step: &StepModel,
        names: &BTreeMap<String, usize>,
        start: Option<&StepStart>,
        issues: &mut Vec<Issue>,
    ) -> Option<(Vec<Support>, LocalFrames, Option<InertiaRelief>)> {
        let vectors = &self.vectors;
        let mut supports = supports(&step.model, self.mesh, vectors, names, issues);
        supports
            .iter_mut()
            .filter(|support| step.stays(&support.key))
            .for_each(|support| support.motion = None);
        issues.extend(patches::supported(&supports, &vectors.coordinates, self.mesh));
        let at = (supports.as_slice(), &*vectors.coordinates);
        issues.extend(couplings::held(&step.model, &self.joints, at, self.mesh));
        let current = self.current(start);
        let relief = if relief::is_asked(&step.model) {
            let found = relief::relief(&supports, &vectors.coordinates, (&current, self.length));
            let (relief, added) = found.map_err(|issue| issues.push(issue)).ok()?;
            supports.extend(added);
            Some(relief)
        } else {
            None
        };
        let (triads, attached) = (vectors.coordinates.triads(), vectors.coordinates.attached());
        match LocalFrames::new(&supports, &self.unit, (&triads, &attached), &current) {
            Ok(mut frames) => {
                if let Some(start) = start {
                    frames.start_at(&current, &start.u);
                }
                Some((supports, frames, relief))
            }
            Err(conflicts) => {
                issues.extend(contradictions(step, &conflicts, vectors, self.mesh));
                None
            }
        }
    }

    fn compile(
        &self,
        step: &StepModel,
        (start, closed_gaps): (Option<StepStart>, Option<Arc<ClosedGaps>>),
    ) -> Result<System> {
        let (model, mesh, vectors) = (&step.model, self.mesh, &self.vectors);
        let mut issues = Vec::new();
        let (amplitudes, names) = amplitudes::time_functions(model, &mut issues);
        let numbered = self.frames(step, &names, start.as_ref(), &mut issues);
        let Some((supports, frames, mut inertia_relief)) = numbered.filter(|_| issues.is_empty()) else {
            return Err(Error::Model(issues));
        };
        issues.extend(unmovable(&frames));
        let mut of_step =
            self.step_joints(step, (start, procedure(&model.analysis)), &amplitudes, &mut issues);
        let released = of_step.take_released();
        let StepJoints { joints, groups, start, .. } = of_step;
        let at_start = inertia_relief.as_ref().map(|_| self.current(start.as_ref()));
        issues.extend(self.unheld(model, &joints, &supports, at_start));
        let dofs = frames.dofs();
        let loads = self.step_loads(step, (&names, dofs), (&released, inertia_relief.as_mut()), &mut issues);
        let added = added_masses(model, mesh, vectors);
        let procedure = procedure(&model.analysis);
        let reductions = self.groups.iter().map(|group| Reduction::of_elements(group.as_ref(), dofs));
        let reductions: Vec<_> = reductions.collect();
        let reduction_of_followers =
            Reduction::new(loads.followers.iter().map(FollowerLoad::vectors), false, dofs);
        let reduced = ReducedLoads { loads: &loads.followers, reduction: reduction_of_followers.as_ref() };
        let pattern = self.pattern(procedure, &frames, (&reductions, reduced), &added)?;
        let initial_velocity = self.initial_velocities(step, (&frames, start.as_ref()), &mut issues);
        let mut system = System {
            coordinates: Arc::clone(&vectors.coordinates),
            path_before: start.as_ref().map(|start| start.path.clone()).unwrap_or_default(),
            frames,
            groups,
            offsets: Arc::clone(&self.offsets),
            reductions,
            reduction_of_followers,
            joints,
            beams: Arc::clone(&self.beams),
            springs: Arc::clone(&self.springs),
            torsion_springs: Arc::clone(&self.torsion_springs),
            bushings: Arc::clone(&self.bushings),
            sensors: Arc::clone(&self.sensors),
            cuts: Arc::clone(&self.cuts),
            outline: Arc::clone(&self.outline),
            shells: self.shells.clone(),
            sections: Arc::clone(&self.sections),
            prescribed_strains: self.prescribed_fields(step, &names),
            dead_loads: Vec::new(),
            followers: loads.followers,
            centrifugal: loads.centrifugal,
            inertia_relief,
            supports,
            support_sets: loads.support_sets,
            load_sets: loads.load_sets,
            load_of_dead: Vec::new(),
            load_of_follower: loads.load_of_follower,
            load_of_centrifugal: loads.load_of_centrifugal,
            inputs: inputs(model),
            amplitudes,
            pattern,
            procedure,
            mass_damping: model.damping.mass,
            length: self.length,
            linear: self.linear,
            start,
            closed_gaps,
            initial_velocity,
            labels: mesh.labels.clone(),
            folds: Folds::of(mesh, &self.directors),
            amplitude_names: names.keys().cloned().collect(),
            wanted_times: model.output.at.clone(),
        };
        self.add_dead_loads(step, &mut system, (&names, &added), (released, &mut issues));
        if issues.is_empty() { Ok(system) } else { Err(Error::Model(issues)) }
    }

    fn prescribed_fields(&self, step: &StepModel, names: &BTreeMap<String, usize>) -> Vec<PrescribedField> {
        let field = |(strain, (continued, amplitude)): (&PrescribedStrain, &(Continued, Option<String>))| {
            let amplitude = amplitude.as_ref().and_then(|a| names.get(a).copied());
            PrescribedField { strain: strain.clone(), factor: continued.factor(amplitude) }
        };
        self.strains.iter().zip(&step.strains).map(field).collect()
    }
}

/// Model with the nodes of its beams, and its analysis steps.
///
/// # Errors
/// Everything that is wrong with the keys, the mesh and the sets, at once, each with a remedy.
fn checked(
    model: &Model,
    mesh: &Mesh,
    laws: &BTreeMap<String, Arc<dyn MaterialLaw>>,
    loaded: bool,
) -> Result<(Model, Vec<StepModel>)> {
    let mut issues = check::keys(model);
    issues.retain(|issue| !loaded || issue.message != own_parts::NOTHING_ACTS);
    issues.extend(body_inertia::unread_surfaces(model));
    if !issues.is_empty() && !model.beams.is_empty() {
        return Err(Error::Model(issues));
    }
    if model.mesh != MeshSource::None || !mesh.quads.is_empty() {
        issues.extend(quality::check(mesh));
    }
    issues.extend(check::sets(model, mesh));
    let model = beams::with_nodes(model);
    let steps = steps::steps(&model);
    issues.extend(laws.keys().filter_map(|name| own_parts::irreplaceable(&model, name)));
    if issues.is_empty() { Ok((model, steps)) } else { Err(Error::Model(issues)) }
}

/// Whether displacements are small in a step.
fn is_linear(step: &StepModel) -> bool {
    match &step.model.analysis {
        Analysis::Static(s) => s.linear,
        Analysis::Transient(t) => t.linear,
        Analysis::Path(_) | Analysis::Modal(_) | Analysis::Buckling(_) => false,
    }
}

/// Adds the groups of joints, springs, torsion springs, bushings and foundations, in this order. Returns those of the joints, and the group of each torsion
/// spring with its number in the group.
fn add_groups(
    groups: &mut Vec<Box<dyn ElementGroup>>,
    (joints, foundations): (&Arc<Vec<Joint>>, &[FoundationElement]),
    (springs, torsion_springs): (&[Spring], &[TorsionSpring]),
    bushings: &[Bushing],
) -> (JointGroups, Vec<[usize; 2]>) {
    let before = groups.len();
    groups.extend(JointGroup::groups(joints));
    let joint_groups = before..groups.len();
    groups.extend(SpringGroup::groups(springs));
    let before = groups.len();
    groups.extend(TorsionSpringGroup::groups(torsion_springs));
    let places = TorsionSpringGroup::places(torsion_springs);
    let places = places.into_iter().map(|[group, number]| [before + group, number]);
    groups.extend(BushingGroup::groups(bushings));
    groups.extend(FoundationGroup::groups(foundations));
    (joint_groups, places.collect())
}

/// Loads of each input of a modal analysis: those at the end of the list.
fn inputs(model: &Model) -> Vec<Range<usize>> {
    let Analysis::Modal(modal) = &model.analysis else { return Vec::new() };
    let mut first = model.loads.len() - modal.inputs.iter().map(|input| input.loads.len()).sum::<usize>();
    let range = |input: &ResponseInput| {
        let range = first..first + input.loads.len();
        first = range.end;
        range
    };
    modal.inputs.iter().map(range).collect()
}

/// A model all of whose degrees of freedom are constrained.
fn unmovable(frames: &LocalFrames) -> Option<Issue> {
    (frames.dofs().unknowns == 0).then(|| {
        Issue::new(
            "conditions",
            "every coordinate of the model is supported: nothing is left to compute",
            "take nodes out of the supported sets",
        )
    })
}

/// Adds the name of the mesh file to the issues of an error.
fn named(error: Error, mesh: &Mesh) -> Error {
    match error {
        Error::Model(mut issues) => {
            mesh.name_file(&mut issues);
            Error::Model(issues)
        }
        other => other,
    }
}
