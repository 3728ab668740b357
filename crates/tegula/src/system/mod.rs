//! The compiled model: coordinates, degrees of freedom, pattern, element groups, loads. Immutable during an analysis.

pub mod assembly;
mod body_curvature;
mod centrifugal;
pub mod circulatory;
mod closed_gaps;
pub mod connection_frequency;
pub mod coordinates;
pub mod corotational_update;
mod curves;
mod cut;
pub mod dof_map;
mod drives;
pub mod element_frequency;
pub mod evaluation_point;
pub mod fields;
mod fingerprint;
mod force_laws;
pub(crate) mod inertia_relief;
mod inverted_element;
mod jumps;
mod local_frames;
pub mod lumped_body;
pub mod lumping;
mod mechanism;
pub mod outline;
pub mod pattern;
pub mod power_series;
mod procedure;
mod reduction;
pub mod rigid_patch;
mod sensors;
mod shell_geometry;
pub mod supports;

use std::ops::Range;
use std::sync::Arc;

use crate::Vec3;
use crate::constraint::{Bushing, CoordinateState, DriveValue, Joint, Sensor, Spring, TorsionSpring};
use crate::element::shell::ShellElement;
use crate::element::{ElementGroup, Nodal};
use crate::load::{CentrifugalLoad, FollowerLoad, LoadFactor, LoadParameter, Signal, TimeFunction};
use crate::mesh::Labels;
use crate::mesh::folds::Folds;
use crate::model::PrescribedStrain;
use crate::section::CompiledSection;
pub use assembly::Assembly;
pub use circulatory::CirculatoryStiffness;
pub use closed_gaps::{ClosedGap, ClosedGaps, MovedBody};
pub use coordinates::{Coordinates, VectorKind};
pub use corotational_update::CorotationalUpdate;
pub use curves::OffCurve;
pub use cut::Cut;
pub use dof_map::DofMap;
use dof_map::Prescribed;
pub use evaluation_point::{EvaluationPoint, GroupOffsets, Internal};
pub use fields::{add_multiple, dot, dot3};
pub use inertia_relief::{InertiaRelief, RigidAcceleration};
pub use inverted_element::inverted_element;
pub use local_frames::LocalFrames;
pub use lumped_body::LumpedBody;
pub use outline::Outline;
pub use pattern::Pattern;
pub use procedure::Procedure;
pub use reduction::Reduction;
pub use rigid_patch::Attached;
use supports::Support;
use tegula_sparse::SymmetricPattern;

/// Dead load: a force on nodal vectors that does not depend on the motion.
#[derive(Debug, Clone)]
pub struct DeadLoad {
    /// Force at factor 1.
    pub force: Vec<Nodal>,
    /// Factor over the analysis step.
    pub factor: LoadFactor,
    /// Whether the load is gravity, whose potential is part of the energy.
    pub gravity: bool,
}

/// A beam: its nodes among the rigid bodies, and its elements.
#[derive(Debug, Clone, PartialEq)]
pub struct BeamLine {
    /// Name of the beam.
    pub name: String,
    /// Its nodes among the bodies, from the start to the end.
    pub bodies: Range<usize>,
    /// Group of its elements.
    pub group: usize,
    /// Nodes whose motion appears in the history.
    pub history: Vec<u32>,
}

/// A set of the mesh on which supports or a load act, for the recovery of resultants.
#[derive(Debug, Clone, PartialEq)]
pub struct ForceSet {
    /// Name in messages: of the set, and of the kind of load where it is one.
    pub name: String,
    /// Keys of the model that act on it.
    pub keys: Vec<String>,
    /// Point about which moments are taken: the mean of the set's nodes at the reference.
    pub about: Vec3,
}

/// A shell element, for the recovery of stresses.
#[derive(Debug, Clone)]
pub struct Shell {
    /// Quad of the mesh.
    pub quad: u32,
    /// Element groups of the shell.
    pub groups: Range<usize>,
    /// Index of the shell's element in each of its groups.
    pub member: usize,
    /// Section.
    pub section: usize,
    /// First congruent element of the section, by its index in the groups.
    pub shape: usize,
    /// Factors of the fields of prescribed strain on the shell, from their distributions, 0 where a field does not act; empty: none.
    pub prescribed: Vec<f64>,
}

/// Shell section with its element type.
#[derive(Debug)]
pub struct ShellSection {
    /// Layers and stiffness.
    pub section: CompiledSection,
    /// Element type with its locking remedies.
    pub element: Box<dyn ShellElement>,
    /// Index of the section of the model, which has one of these for each thickness.
    pub of_model: usize,
}

/// A field of prescribed strain.
#[derive(Debug, Clone)]
pub struct PrescribedField {
    /// The strain at factor 1.
    pub strain: PrescribedStrain,
    /// Factor over the analysis step.
    pub factor: LoadFactor,
}

/// Path of an analysis step that has ended at a critical point or behind one.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PathBefore {
    /// Its direction at the end; empty where there is no such path.
    pub direction: Vec<Nodal>,
    /// Whether the load factor rises along this direction.
    pub rises: bool,
    /// Whether it has ended at a critical point, a limit point or a bifurcation.
    pub at_critical_point: bool,
    /// Change of the number of negative eigenvalues there: where it grows, the stable equilibria lie against the direction.
    pub change: i32,
}

/// State at which an analysis step starts, left by the step before.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StepStart {
    /// Time or load factor at which that step has ended.
    pub time: f64,
    /// Path that has ended at a critical point or behind one.
    pub path: PathBefore,
    /// Displacements of the nodal vectors.
    pub u: Vec<Nodal>,
    /// Velocities; empty where the step before was static.
    pub v: Vec<Nodal>,
    /// Enhanced parameters and internal variables of the materials.
    pub history: Vec<f64>,
    /// Lagrange multipliers of the constraints of joints.
    pub multipliers: Vec<f64>,
    /// Angles of sensors and gears (rad).
    pub angles: Vec<f64>,
    /// Relative coordinates of joints with friction or stops.
    pub coordinates: Vec<CoordinateState>,
}

/// The compiled model.
pub struct System {
    /// Nodal vectors.
    pub coordinates: Arc<Coordinates>,
    /// Local frames of the nodal vectors where the analysis step starts, and the degree-of-freedom map.
    pub frames: LocalFrames,
    /// Path of the step before, where it has ended at a critical point or behind one.
    pub path_before: PathBefore,
    /// Elements.
    pub groups: Arc<Vec<Arc<dyn ElementGroup>>>,
    /// Ranges of each group in the arrays that hold the data of all groups.
    pub offsets: Arc<Vec<GroupOffsets>>,
    /// Reduction of each group to the degrees of freedom of rigid bodies, where it contains some.
    pub reductions: Vec<Option<Reduction>>,
    /// Reduction of the follower loads; `None`: none of them acts on a body.
    pub reduction_of_followers: Option<Reduction>,
    /// Joints; their constraint forces are those of the groups of joints.
    pub joints: Arc<Vec<Joint>>,
    /// Beams.
    pub beams: Arc<Vec<BeamLine>>,
    /// Springs with their names.
    pub springs: Arc<Vec<(String, Spring)>>,
    /// Torsion springs, each with its group and its number in it.
    pub torsion_springs: Arc<Vec<(TorsionSpring, [usize; 2])>>,
    /// Bushings.
    pub bushings: Arc<Vec<Bushing>>,
    /// Sensors.
    pub sensors: Arc<Vec<Sensor>>,
    /// Cuts.
    pub cuts: Arc<Vec<Cut>>,
    /// Outline of bodies, beams and springs, for pictures.
    pub outline: Arc<Outline>,
    /// Shells, one per quad that has an element.
    pub shells: Vec<Shell>,
    /// Sections of the shells.
    pub sections: Arc<Vec<ShellSection>>,
    /// Fields of prescribed strain.
    pub prescribed_strains: Vec<PrescribedField>,
    /// Forces independent of the motion.
    pub dead_loads: Vec<DeadLoad>,
    /// Follower loads.
    pub followers: Vec<FollowerLoad>,
    /// Centrifugal forces.
    pub centrifugal: Vec<CentrifugalLoad>,
    /// Inertia forces that balance the loads of a model without supports.
    pub inertia_relief: Option<InertiaRelief>,
    /// Supports as the model has them, condition by condition.
    pub supports: Vec<Support>,
    /// Sets on which the supports act.
    pub support_sets: Vec<ForceSet>,
    /// Loads of the model.
    pub load_sets: Vec<ForceSet>,
    /// Index of the load that each of the dead loads belongs to.
    pub load_of_dead: Vec<usize>,
    /// Index of the load that each of the follower loads belongs to.
    pub load_of_follower: Vec<usize>,
    /// Index of the load that each of the centrifugal loads belongs to.
    pub load_of_centrifugal: Vec<usize>,
    /// Loads of each input of a modal analysis, by their index; they act in the response to the input only.
    pub inputs: Vec<Range<usize>>,
    /// Functions of time.
    pub amplitudes: Vec<TimeFunction>,
    /// Names of the amplitudes.
    pub amplitude_names: Vec<String>,
    /// Sparsity and mass.
    pub pattern: Pattern,
    /// Kind of analysis for which the system is compiled.
    pub procedure: Procedure,
    /// Rayleigh factor of the mass.
    pub mass_damping: f64,
    /// Size of the model: largest side of its bounding box (length).
    pub length: f64,
    /// Whether displacements are small (geometrically linear model).
    pub linear: bool,
    /// State at which the analysis step starts; `None`: the reference configuration at rest.
    pub start: Option<StepStart>,
    /// Gaps closed and bodies moved where the model is assembled at the start; `None` where the sides of its joints meet in the reference configuration.
    pub closed_gaps: Option<Arc<ClosedGaps>>,
    /// Velocities that the start of a transient analysis adds to those of its first state; empty if all are zero.
    pub initial_velocity: Vec<Nodal>,
    /// Times (load factors) at which the user wants a step to end.
    pub wanted_times: Vec<f64>,
    /// Numbers of nodes and quads in the mesh file, for messages.
    pub labels: Option<Labels>,
    /// Lines along which sheets meet at an angle.
    pub folds: Folds,
}

impl System {
    /// Pattern of the tangent and of the mass of the free degrees of freedom.
    pub fn tangent_pattern(&self) -> SymmetricPattern {
        self.pattern.compressed(&self.frames)
    }

    /// Number of nodal vectors.
    pub fn vectors(&self) -> usize {
        self.coordinates.len()
    }

    /// Degree-of-freedom map.
    pub fn dofs(&self) -> &DofMap {
        self.frames.dofs()
    }

    /// Number of free degrees of freedom.
    pub fn unknowns(&self) -> usize {
        self.dofs().unknowns
    }

    /// Groups of elements, each with its number and its ranges in the arrays of all groups.
    pub fn numbered_groups(&self) -> impl Iterator<Item = (usize, &dyn ElementGroup, &GroupOffsets)> {
        let groups = self.groups.iter().map(AsRef::as_ref).zip(self.offsets.iter());
        groups.enumerate().map(|(number, (group, offsets))| (number, group, offsets))
    }

    /// True if no elastic element has history variables: enhanced parameters that are iterated, or internal variables. Angles of
    /// torsion springs and rotations of bushings do not count.
    pub fn without_internal_variables(&self) -> bool {
        self.groups.iter().all(|group| group.history_per_element() == 0 || group.stresses_per_element() == 0)
    }

    /// True if a material of the model can yield.
    pub fn yields(&self) -> bool {
        self.sections.iter().any(|s| s.section.laws.iter().any(|law| law.history() > 0))
    }

    /// Number of a node in messages: that of the mesh file, or the internal one, counted from 0.
    pub fn node_label(&self, node: u32) -> u64 {
        self.labels.as_ref().map_or(u64::from(node), |labels| labels.node(node as usize))
    }

    /// Number of a quad in messages: that of the mesh file, or the internal one, counted from 0.
    pub fn quad_label(&self, quad: u32) -> u64 {
        self.labels.as_ref().map_or(u64::from(quad), |labels| labels.quad(quad as usize))
    }

    /// Whether bodies or joints may leave motions free that no element strains.
    pub fn may_be_loose(&self) -> bool {
        !self.joints.is_empty() || !self.coordinates.bodies.is_empty()
    }

    /// Whether joints or springs may transfer forces to the ground.
    pub fn acts_on_ground(&self) -> bool {
        self.groups.iter().any(|group| group.acts_on_ground())
    }

    /// Whether there are springs or other elements without strains, which may be far stiffer than shells and beams.
    pub fn has_force_elements(&self) -> bool {
        self.groups.iter().any(|group| !group.is_empty() && group.stresses_per_element() == 0)
    }

    /// Factors of the prescribed strains at a time, and behind them the values of the drives of all joints.
    pub fn factors(&self, time: f64) -> impl Iterator<Item = f64> + '_ {
        let strains = self.prescribed_strains.iter().map(move |field| self.factor(&field.factor, time));
        strains.chain(self.joints.iter().map(move |joint| self.drive_value(joint, time)))
    }

    /// Value of the drive of a joint at a time with its rates; zero for a joint without one. Before time 0, where static load grows
    /// to that of its amplitudes, drives stay where they begin.
    pub fn drive(&self, joint: &Joint, time: f64) -> DriveValue {
        joint
            .drive
            .map_or_else(DriveValue::default, |drive| drive.at(&self.amplitudes, self.time_of_drives(time)))
    }

    /// Value of the drive of a joint at a time, without its rates.
    pub fn drive_value(&self, joint: &Joint, time: f64) -> f64 {
        joint.drive.map_or(0.0, |drive| drive.value_at(&self.amplitudes, self.time_of_drives(time)))
    }

    /// Whether states of the analysis have velocities.
    pub fn moves(&self) -> bool {
        self.parameter() == LoadParameter::Time
    }

    /// Time (load factor) of drives and actuators: a static step that begins at load factor −1 has them at rest until 0; on a path the load
    /// factor may be negative.
    pub fn time_of_drives(&self, time: f64) -> f64 {
        if self.parameter() == LoadParameter::PathFactor { time } else { time.max(0.0) }
    }

    /// Node or body of a nodal vector with its place in the reference configuration, for messages.
    pub fn place_name(&self, vector: usize) -> String {
        let p = self.coordinates.place(vector);
        let owner = match self.coordinates.body_of(vector) {
            Some(body) => format!("body \"{}\"", body.name),
            None => format!("node {}", self.node_label(self.coordinates.nodes[vector])),
        };
        format!("{owner}, at ({:.4}, {:.4}, {:.4})", p[0], p[1], p[2])
    }

    /// Whether loads follow the motion.
    pub fn has_follower_loads(&self) -> bool {
        !self.followers.is_empty() || !self.centrifugal.is_empty() || self.inertia_relief.is_some()
    }

    /// Number of shell elements.
    pub fn elements(&self) -> usize {
        self.shells.len()
    }

    /// Independent variable of the loads.
    pub fn parameter(&self) -> LoadParameter {
        self.procedure.parameter()
    }

    /// Factor of a load at a time; in statics the time is the load factor λ.
    pub fn factor(&self, factor: &LoadFactor, time: f64) -> f64 {
        factor.value(&self.amplitudes, self.parameter(), time)
    }

    /// Load factor at which a static analysis step starts: −1 where an amplitude does not continue at load factor 0 what
    /// the step before has left (in a first step: is not 0 there), else 0. Yielding materials keep these loads in their
    /// history, and a step to them can be cut back.
    pub fn first_load_factor(&self) -> f64 {
        let loads = self.load_factors().any(|factor| factor.jumps(&self.amplitudes));
        let motions = self.dofs().prescribed.iter().any(|p| p.jumps(&self.amplitudes));
        if self.parameter() == LoadParameter::LoadFactor && (loads || motions) { -1.0 } else { 0.0 }
    }

    /// Factors of all loads and prescribed strains.
    pub fn load_factors(&self) -> impl Iterator<Item = &LoadFactor> {
        let dead = self.dead_loads.iter().map(|load| &load.factor);
        let followers = self.followers.iter().map(FollowerLoad::factor);
        let centrifugal = self.centrifugal.iter().map(|load| &load.factor);
        dead.chain(followers).chain(centrifugal).chain(self.prescribed_strains.iter().map(|p| &p.factor))
    }

    /// Whether loads, prescribed strains and motions do not all grow in proportion.
    pub fn load_factors_differ(&self) -> bool {
        let loads = self.load_factors().map(|f| f.key());
        let motions = self.dofs().prescribed.iter().filter(|p| !p.held).map(|p| (p.amplitude, 0, [false; 2]));
        let mut all = loads.chain(motions);
        let first = all.next();
        all.any(|key| Some(key) != first)
    }

    /// Undefined amplitude at a time: the first one in use that has no finite value, or no finite velocity or
    /// acceleration where a prescribed motion of a transient analysis follows it; as text.
    pub fn undefined_amplitude(&self, time: f64) -> Option<String> {
        let is_static = self.parameter() != LoadParameter::Time;
        let time = if self.parameter() == LoadParameter::LoadFactor { f64::max(time, 0.0) } else { time };
        self.amplitudes_in_use().find_map(|(i, motion)| {
            let (what, value) = self.amplitudes.get(i)?.undefined(time, motion && !is_static)?;
            let name = self.amplitude_name(i);
            Some(format!("the {what} of the amplitude \"{name}\" is {value} at {time:.6e}"))
        })
    }

    /// Amplitudes that loads, prescribed strains and prescribed motions follow, one for each of these, and whether it is
    /// a motion.
    pub fn amplitudes_in_use(&self) -> impl Iterator<Item = (usize, bool)> + '_ {
        let loads = self.load_factors().map(|factor| (factor.used_amplitude(), false));
        let motions = self.dofs().prescribed.iter().map(|p| (p.amplitude, true));
        let drives = self.joints.iter().map(|joint| (joint.drive.map(|drive| drive.amplitude), true));
        loads.chain(motions).chain(drives).filter_map(|(amplitude, motion)| Some((amplitude?, motion)))
    }

    /// Name of an amplitude.
    pub fn amplitude_name(&self, amplitude: usize) -> &str {
        self.amplitude_names.get(amplitude).map_or("?", String::as_str)
    }

    /// Puts a signal in place of the amplitude with this name; `None` if there is no such amplitude. Loads, prescribed
    /// strains and motions that follow the amplitude take the values that the caller sets.
    pub fn signal(&mut self, amplitude: &str) -> Option<Signal> {
        let index = self.amplitude_names.iter().position(|name| name == amplitude)?;
        let function = self.amplitudes.get_mut(index)?;
        let signal = Signal::new(function.value(0.0));
        *function = TimeFunction::Signal(signal.clone());
        Some(signal)
    }

    /// Adds the dead loads at a time.
    pub fn add_dead_loads(&self, time: f64, factor: f64, out: &mut [Nodal]) {
        for load in &self.dead_loads {
            let f = factor * self.factor(&load.factor, time);
            if f != 0.0 {
                for (o, v) in out.iter_mut().zip(&load.force) {
                    for i in 0..3 {
                        o[i] += f * v[i];
                    }
                }
            }
        }
    }

    /// Potential −F·u of gravity that is constant in time; other gravity counts as a load that does work.
    pub fn constant_gravity_potential(&self, u: &[Nodal]) -> f64 {
        self.dead_loads
            .iter()
            .filter(|l| l.gravity)
            .filter_map(|l| match l.factor.amplitude.map(|a| &self.amplitudes[a]) {
                None if self.parameter() == LoadParameter::Time => Some(-dot(&l.force, u)),
                Some(TimeFunction::Constant(c)) => Some(-c * dot(&l.force, u)),
                _ => None,
            })
            .sum()
    }

    /// Writes the prescribed displacements at a time into the constrained degrees of freedom of `u`.
    pub fn prescribe(&self, time: f64, u: &mut [Nodal]) {
        self.write_prescribed(u, |p| p.displacement(&self.amplitudes, self.parameter(), time));
    }

    /// Writes prescribed velocities at a time.
    pub fn prescribe_velocity(&self, time: f64, v: &mut [Nodal]) {
        self.write_prescribed(v, |p| p.amplitude.map_or(0.0, |a| p.value * self.amplitudes[a].rate(time)));
    }

    /// Writes prescribed velocities just before a time: at a kink of a table they differ from those behind it.
    pub fn prescribe_velocity_before(&self, time: f64, v: &mut [Nodal]) {
        let rate =
            |p: &Prescribed| p.amplitude.map_or(0.0, |a| p.value * self.amplitudes[a].rate_before(time));
        self.write_prescribed(v, rate);
    }

    /// Whether springs have formulas in the time.
    pub fn has_actuators(&self) -> bool {
        self.groups.iter().any(|g| g.has_actuators())
    }

    /// Whether elements have strain-rate damping, springs dampers, or loads depend on velocities.
    pub fn has_rate_damping(&self) -> bool {
        self.groups.iter().any(|g| g.has_rate_damping())
            || self.followers.iter().any(FollowerLoad::depends_on_velocities)
    }

    /// Writes prescribed accelerations at a time.
    pub fn prescribe_acceleration(&self, time: f64, a: &mut [Nodal]) {
        let acceleration =
            |p: &Prescribed| p.amplitude.map_or(0.0, |a| p.value * self.amplitudes[a].acceleration(time));
        self.write_prescribed(a, acceleration);
    }

    /// Writes prescribed accelerations just before a time: at the end of a spline they differ from those behind it.
    pub fn prescribe_acceleration_before(&self, time: f64, a: &mut [Nodal]) {
        let acceleration = |p: &Prescribed| {
            p.amplitude.map_or(0.0, |a| p.value * self.amplitudes[a].acceleration_before(time))
        };
        self.write_prescribed(a, acceleration);
    }

    fn write_prescribed(&self, field: &mut [Nodal], f: impl Fn(&Prescribed) -> f64) {
        for prescribed in &self.dofs().prescribed {
            let (v, c) = prescribed.place();
            let mut local = self.frames.to_local(v, field[v]);
            local[c] = f(prescribed);
            field[v] = self.frames.to_global(v, local);
        }
    }

    /// Work of forces over the change of the prescribed degrees of freedom between two displacements.
    pub fn work_of_prescribed(&self, forces: &[Nodal], from: &[Nodal], to: &[Nodal]) -> f64 {
        let work = |prescribed: &Prescribed| {
            let (v, c) = prescribed.place();
            let along = |field: &[Nodal]| self.frames.to_local(v, field[v])[c];
            along(forces) * (along(to) - along(from))
        };
        self.dofs().prescribed.iter().map(work).sum()
    }

    /// Product of forces and a change along the prescribed degrees of freedom.
    pub fn product_of_prescribed(&self, forces: &[Nodal], change: &[Nodal]) -> f64 {
        let product = |prescribed: &Prescribed| {
            let (v, c) = prescribed.place();
            self.frames.to_local(v, forces[v])[c] * self.frames.to_local(v, change[v])[c]
        };
        self.dofs().prescribed.iter().map(product).sum()
    }

    /// Total mass, from the position vectors.
    pub fn total_mass(&self) -> f64 {
        let mut m = 0.0;
        self.pattern.for_each_mass(|i, j, value| {
            if self.coordinates.kinds[i] == VectorKind::Position
                && self.coordinates.kinds[j] == VectorKind::Position
            {
                m += if i == j { value } else { 2.0 * value };
            }
        });
        m
    }

    /// Kinetic energy ½ v·M v.
    pub fn kinetic_energy(&self, v: &[Nodal]) -> f64 {
        let mut t = 0.0;
        self.pattern.for_each_mass(|i, j, m| {
            let product = m * dot3(v[i], v[j]);
            t += if i == j { 0.5 * product } else { product };
        });
        t
    }

    /// Linear and angular momentum (about the origin) at displacements `u` and velocities `v`; in linear models the arms of the
    /// momenta are those of the reference configuration.
    pub fn momentum(&self, u: &[Nodal], v: &[Nodal]) -> (Vec3, Vec3) {
        let (mut linear, mut angular) = (Vec3::zeros(), Vec3::zeros());
        let arm = |i: usize| {
            let reference = Vec3::from(self.coordinates.reference[i]);
            if self.linear { reference } else { reference + Vec3::from(u[i]) }
        };
        self.pattern.for_each_mass(|i, j, m| {
            let pairs = if i == j { 1 } else { 2 };
            for (a, b) in [(i, j), (j, i)].into_iter().take(pairs) {
                let p = Vec3::from(v[b]) * m;
                if self.coordinates.kinds[a] == VectorKind::Position {
                    linear += p;
                }
                angular += arm(a).cross(&p);
            }
        });
        (linear, angular)
    }
}
