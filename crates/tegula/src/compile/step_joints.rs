//! Joints of an analysis step: those that act, those that it releases, and those that it locks.

use std::ops::Range;
use std::sync::Arc;

use super::Compiler;
use super::place::{Place, ends};
use super::steps::StepModel;
use crate::checker::Checker;
use crate::constraint::joints::{End, lock};
use crate::constraint::{Joint, JointGroup, Role};
use crate::element::{ElementGroup, Nodal};
use crate::load::{FollowerLoad, LoadFactor, TimeFunction};
use crate::model::{
    self, Analysis, AnalysisStep, EnergyMomentumScheme, JointKeys, JointStops, Model, Scheme,
    TransientAnalysis,
};
use crate::system::{DeadLoad, ForceSet, Procedure, StepStart, System};
use crate::{Issue, Vec3};

/// Gap of a joint that acts again, over the size of the model (rad for axes), which is round-off.
const CLOSED: f64 = 1e-9;

/// Joints that act in a step, and their keys in the model file where these differ.
pub(super) fn acting(model: &Model, step: &AnalysisStep) -> (Vec<model::Joint>, Vec<(String, String)>) {
    let acts =
        |(_, joint): &(usize, &model::Joint)| !step.released.iter().any(|name| name == joint.common().name());
    let list = model.joints.iter().enumerate().filter(acts).enumerate();
    list.map(|(own, (file, joint))| (joint.clone(), (format!("joints[{own}]"), format!("joints[{file}]"))))
        .unzip()
}

/// Mistakes in the lists `released` and `locked` of a step, whose key is given.
pub(super) fn keys(model: &Model, step: &AnalysisStep, key: &str, c: &mut Checker) {
    let names: Vec<String> = model.joints.iter().map(|joint| joint.common().name().to_owned()).collect();
    for (list, given) in [("released", &step.released), ("locked", &step.locked)] {
        for (i, name) in given.iter().enumerate() {
            let place = format!("{key}.{list}[{i}]");
            let Some(joint) = names.iter().position(|other| other == name) else {
                c.missing(place, "joint", name, names.iter());
                continue;
            };
            if given[..i].contains(name) {
                c.add(place, format!("the joint \"{name}\" is listed twice"), "name it once");
            } else if list == "locked" && step.released.contains(name) {
                c.add(
                    place,
                    format!("the joint \"{name}\" is released and locked in the same step"),
                    "take it out of one of the two lists",
                );
            } else if list == "locked" && !model.joints[joint].can_be_locked() {
                let (message, help) = not_lockable(&model.joints[joint]);
                c.add(place, message, help);
            } else if list == "released" && model.steps.iter().all(|step| step.released.contains(name)) {
                c.add(
                    place,
                    format!("the joint \"{name}\" is released in all steps: it never acts"),
                    "leave the joint out of the model, or let it act in a step",
                );
            }
        }
    }
}

/// Reason why a joint cannot be locked, and what to do instead.
fn not_lockable(joint: &model::Joint) -> (String, &'static str) {
    let (name, kind) = (joint.common().name(), joint.word());
    let (reason, help) = match joint {
        model::Joint::Fixed(_) => {
            ("leaves no motion free", "take it out of the list: it holds its two sides already")
        }
        model::Joint::DrivenAngle(_) | model::Joint::DrivenLength(_) => (
            "prescribes a motion",
            "release the drive in this step, and lock the joint beside which it stands",
        ),
        model::Joint::ClampedDirector(_) | model::Joint::DirectorAlignment(_) => (
            "holds the director of a shell node, which has no other axes",
            "take it out of the list, or attach nodes to a body and lock a joint of the body",
        ),
        model::Joint::RackAndPinion(_) => (
            "couples two motions that other joints leave free",
            "lock the hinge of the pinion or the guide of the rack",
        ),
        model::Joint::Gear(_) => {
            ("couples two rotations that hinges leave free", "lock the hinge of one of its wheels")
        }
        model::Joint::PointOnCurve(_) => (
            "lets a point move along a curve, in whose changing direction no lock is made",
            "release it in this step, and hold the point by a joint that other steps release",
        ),
        _ => ("is a rod between two points", "lock other joints of the same bodies"),
    };
    (format!("the joint \"{name}\" of the type \"{kind}\" {reason}, and cannot be locked"), help)
}

/// Joints with friction or stops that act in a step whose analysis does not know them, or beside a drive.
pub(super) fn laws(step: &StepModel) -> Vec<Issue> {
    let joints = &step.model.joints;
    let of_joint = |(i, joint): (usize, &model::Joint)| {
        let keys = joint.common();
        let key = match (keys.friction(), keys.stops()) {
            (Some(_), _) => "friction",
            (None, Some(_)) => "stops",
            (None, None) => return None,
        };
        if step.locked.iter().any(|name| name == keys.name()) {
            return None;
        }
        let (problem, help) = if let Some((does_not, help)) = ignorant(&step.model.analysis) {
            (format!("which {does_not}"), help)
        } else if let Some(violated) = keys.stops().and_then(violated).filter(|_| begins_at_reference(step)) {
            return Some(Issue::new(
                format!("joints[{i}].stops"),
                format!("the joint \"{}\" begins at 0, {violated}", keys.name()),
                "displacements and angles count from the reference configuration: give stops that contain 0",
            ));
        } else {
            let [a, b] = keys.between();
            let beside = |other: &&dyn JointKeys| {
                other.drive().is_some() && [[a, b], [b, a]].contains(&other.between().each_ref())
            };
            let drive = joints.iter().map(model::Joint::common).find(beside)?;
            (
                format!("which a joint whose motion is prescribed by \"{}\" cannot have", drive.name()),
                "leave it out, or let a load, a spring or a torsion spring drive the joint",
            )
        };
        let message = format!("the joint \"{}\" has {key}, {problem}", keys.name());
        Some(Issue::new(format!("joints[{i}].{key}"), message, help))
    };
    joints.iter().enumerate().filter_map(of_joint).collect()
}

/// Whether a step begins in the reference configuration, and not where another one has ended or where the model is assembled.
fn begins_at_reference(step: &StepModel) -> bool {
    let assembled = step.model.joints.iter().any(|joint| joint.common().second_side().is_given());
    step.starts_from.is_none() && !assembled
}

/// Stop that does not admit the reference configuration, in which joints stand at 0.
fn violated(stops: &JointStops) -> Option<String> {
    let lower =
        stops.lower.filter(|lower| *lower > 0.0).map(|lower| format!("below its lower stop, {lower}"));
    let upper =
        stops.upper.filter(|upper| *upper < 0.0).map(|upper| format!("above its upper stop, {upper}"));
    lower.or(upper)
}

/// Reason why an analysis does not compute friction and stops of joints, and what to do instead.
fn ignorant(analysis: &Analysis) -> Option<(&'static str, &'static str)> {
    match analysis {
        _ if knows_laws(analysis) => None,
        Analysis::Transient(_) => Some((
            "the scheme of this transient analysis does not compute",
            "use `scheme = { type = \"energy-momentum\" }` of order 2 with `linear = false`",
        )),
        Analysis::Static(_) | Analysis::Path(_) => Some((
            "a static analysis, in which forces of friction are not unique, does not compute",
            "list the joint in `locked` (it sticks) or `released` of this analysis step, or compute a transient analysis",
        )),
        Analysis::Buckling(_) => Some((
            "a buckling analysis, which is linear, does not compute",
            "list the joint in `locked` (it sticks) or `released` of this analysis step, or leave the key out",
        )),
        Analysis::Modal(_) => Some((
            "a modal analysis, which is linear, does not compute",
            "list the joint in `locked` (it sticks) or `released` of this analysis step, or leave the key out",
        )),
    }
}

/// Whether an analysis is linear about its first state, in which drives stay.
fn is_linearised(procedure: Procedure) -> bool {
    matches!(procedure, Procedure::Modal | Procedure::Buckling)
}

/// Whether an analysis computes friction and stops of joints.
fn knows_laws(analysis: &Analysis) -> bool {
    matches!(
        analysis,
        Analysis::Transient(TransientAnalysis {
            scheme: Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 }),
            linear: false,
            ..
        })
    )
}

/// Sides of a joint that some step locks.
pub(super) struct Lock {
    keys: model::Joint,
    ends: [End; 2],
    /// Number of constraints of the lock.
    rows: usize,
}

/// Sides of the joints that some step locks, joint by joint; their joints then contain all nodal vectors of both sides.
pub(super) fn locks(
    place: &Place,
    steps: &[StepModel],
    joints: &mut [Joint],
    issues: &mut Vec<Issue>,
) -> Vec<Option<Lock>> {
    let reference = |v: u32| Vec3::from(place.coordinates.reference[v as usize]);
    let of_joint = |joint: &mut Joint| {
        let listed = |(i, step): (usize, &StepModel)| {
            Some((i, step.locked.iter().position(|name| *name == joint.name)?))
        };
        let (step, number) = steps.iter().enumerate().find_map(listed)?;
        let keys = place.model.joints.iter().find(|keys| keys.common().name() == joint.name)?;
        let ends = ends(place, ("joints", keys.common().between()), [None, None], &mut Checker::default())?;
        for (end, first) in ends.iter().zip([true, false]) {
            joint.add_vectors(&end.vectors(), first);
        }
        let Some(rows) = lock(keys, &ends, (joint, place.length), reference) else {
            issues.push(Issue::new(
                format!("steps[{step}].locked[{number}]"),
                format!(
                    "the joint \"{}\" cannot be locked: one of its sides is a point mass or a node, which has no axes",
                    joint.name
                ),
                "connect rigid bodies and the ground, or take the joint out of the list",
            ));
            return None;
        };
        Some(Lock { keys: keys.clone(), ends, rows: rows.len() })
    };
    joints.iter_mut().map(of_joint).collect()
}

/// Part that a joint has in a step.
fn role(step: &StepModel, joint: &Joint) -> Role {
    if step.released.contains(&joint.name) {
        Role::Released
    } else if step.locked.contains(&joint.name) {
        Role::Locked
    } else {
        Role::Acting
    }
}

/// Joints of a step, and what they make of the state at which it starts.
pub(super) struct StepJoints {
    pub(super) joints: Arc<Vec<Joint>>,
    /// Elements, with the groups of these joints among them.
    pub(super) groups: Arc<Vec<Arc<dyn ElementGroup>>>,
    /// Start of the step with a multiplier for each constraint of these joints.
    pub(super) start: Option<StepStart>,
    /// Forces of the constraints that the step before had, and this one has not, joint by joint.
    released: Vec<Released>,
}

/// Forces of released constraints on both sides of a joint, with a constant direction: forces at its place, and couples.
pub(super) struct Released {
    set: ForceSet,
    /// Forces on nodal vectors; those at a place of a body act on its mass centre and, by their arm, on its directors.
    field: Vec<Nodal>,
    /// Directors of bodies, and couples on these.
    couples: Vec<([u32; 3], Vec3)>,
}

impl StepJoints {
    /// Lets the forces of released constraints fall to 0 with the load factor of a static step.
    pub(super) fn release(released: Vec<Released>, system: &mut System) {
        for Released { set, field: force, .. } in released {
            system.load_of_dead.push(system.load_sets.len());
            system.load_sets.push(set);
            system.dead_loads.push(DeadLoad { force, factor: FALLING, gravity: false });
        }
    }

    /// Takes the forces of released constraints out.
    pub(super) fn take_released(&mut self) -> Vec<Released> {
        std::mem::take(&mut self.released)
    }

    /// Couples of released constraints, each with the number of its load behind `loads` others.
    pub(super) fn couples(released: &[Released], loads: usize) -> (Vec<FollowerLoad>, Vec<usize>) {
        let of_joint = |(number, released): (usize, &Released)| {
            let load = move |&(directors, moment): &([u32; 3], Vec3)| {
                (FollowerLoad::BodyMoment { directors, moment, factor: FALLING }, number)
            };
            released.couples.iter().map(load).collect::<Vec<_>>()
        };
        (loads..).zip(released).flat_map(of_joint).unzip()
    }
}

/// Factor of forces that a static step takes away.
const FALLING: LoadFactor = LoadFactor { amplitude: None, start: 1.0, released: true, held: false };

/// Couple over the moments that make it up, and sine of the angle between two forces, below which they are round-off.
const NO_COUPLE: f64 = 1e-12;

/// Groups of the joints among those of all elements.
pub(super) type JointGroups = Range<usize>;

impl Compiler<'_> {
    /// Number of constraints of a joint with a part in a step, in which laws act or not.
    fn rows(&self, number: usize, role: Role, laws: bool) -> usize {
        let own = self.joints[number].rows.len();
        match role {
            Role::Released => 0,
            Role::Acting => own + usize::from(laws && self.joints[number].law.is_some()),
            Role::Locked => own + self.locks[number].as_ref().map_or(0, |lock| lock.rows),
        }
    }

    /// Number of constraints in a step.
    pub(super) fn constraints_in(&self, step: &StepModel) -> usize {
        let laws = knows_laws(&step.model.analysis);
        self.joints.iter().map(|joint| self.rows(joint.number, role(step, joint), laws)).sum()
    }

    /// Step whose joints have the multipliers of the start of a step.
    pub(super) fn step_before<'a>(&'a self, step: &'a StepModel) -> &'a StepModel {
        step.starts_from.and_then(|index| self.steps.get(index)).unwrap_or(step)
    }

    /// Joints of a step that begins at `start`. Drives begin where the step starts; modes about the end of the step before leave them
    /// there.
    pub(super) fn step_joints(
        &self,
        step: &StepModel,
        (mut start, procedure): (Option<StepStart>, Procedure),
        amplitudes: &[TimeFunction],
        issues: &mut Vec<Issue>,
    ) -> StepJoints {
        let moved = start.as_ref().map_or_else(Vec::new, |start| start.u.clone());
        let current = |v: u32| {
            let u = moved.get(v as usize).map_or_else(Vec3::zeros, |u| Vec3::from(*u));
            Vec3::from(self.vectors.coordinates.reference[v as usize]) + u
        };
        let before = start.as_ref().map(|_| self.step_before(step));
        let old = start.as_ref().map_or_else(Vec::new, |start| start.multipliers.clone());
        let (mut joints, mut multipliers, mut released, mut first_old) =
            (Vec::new(), Vec::new(), Vec::new(), 0);
        for base in self.joints.iter() {
            let present = role(step, base);
            let earlier = before.map_or(present, |before| role(before, base));
            let laws = [before.unwrap_or(step), step].map(|step| knows_laws(&step.model.analysis));
            let [had, has] = [(earlier, laws[0]), (present, laws[1])]
                .map(|(role, laws)| self.rows(base.number, role, laws));
            let mut joint = self.with_lock(base, [earlier, present].contains(&Role::Locked), current);
            let v: Vec<Vec3> = joint.vectors.iter().map(|&v| current(v)).collect();
            let before_it = &old[first_old.min(old.len())..(first_old + had).min(old.len())];
            if had > has && start.is_some() {
                released.push(self.forces((&joint, has), (&v, current), before_it));
            }
            if earlier == Role::Released && present != earlier {
                issues.extend(self.open(step, base, &v));
            }
            let kept = had.min(has).min(before_it.len());
            (joint.first, joint.role, joint.engages) =
                (multipliers.len(), present, before.is_some() && has > had);
            multipliers.extend_from_slice(&before_it[..kept]);
            multipliers.resize(joint.first + has, 0.0);
            first_old += had;
            joint.law = joint.law.filter(|_| present == Role::Acting && laws[1]);
            if let Some(law) = &mut joint.law {
                law.acts = true;
                joint.rows.truncate(base.rows.len());
                joint.rows.push(law.row.clone());
            }
            joint.rows.truncate(has);
            joint.drive = joint.drive.filter(|_| present != Role::Released);
            if let Some(drive) = joint.drive.as_mut().filter(|_| start.is_some() && is_linearised(procedure))
            {
                drive.value = 0.0;
            }
            joint.start_drive(amplitudes, current);
            if joint.counted.is_some() {
                let counted = joints.iter().filter(|joint: &&Joint| joint.counted.is_some()).count();
                let angle = start.as_ref().and_then(|start| start.angles.get(self.sensor_angles() + counted));
                joint.mesh(angle.copied().unwrap_or(0.0), current);
            }
            joints.push(joint);
        }
        if let Some(start) = &mut start {
            start.multipliers = multipliers;
        }
        let joints = Arc::new(joints);
        let groups = self.groups_with(&joints);
        StepJoints { joints, groups, start, released }
    }

    /// A joint with the constraints that lock it behind its own, where it stands, if they are wanted.
    pub(super) fn with_lock(&self, base: &Joint, wanted: bool, current: impl Fn(u32) -> Vec3) -> Joint {
        let mut joint = base.clone();
        if let Some(Lock { keys, ends, .. }) = self.locks[base.number].as_ref().filter(|_| wanted) {
            joint.rows.extend(lock(keys, ends, (base, self.length), current).unwrap_or_default());
        }
        joint
    }

    /// Forces of the constraints of a joint from one of them on, with the multipliers of all.
    ///
    /// Director forces of a body are the force at the place of the joint, by its arm, and a couple.
    fn forces(
        &self,
        (joint, first): (&Joint, usize),
        (v, current): (&[Vec3], impl Fn(u32) -> Vec3),
        multipliers: &[f64],
    ) -> Released {
        let coordinates = &self.vectors.coordinates;
        let mut field = vec![[0.0; 3]; coordinates.len()];
        for (&vector, force) in joint.vectors.iter().zip(joint.forces_from(first, v, multipliers)) {
            field[vector as usize] = force.into();
        }
        let place = joint.place(&current);
        let mut couples = Vec::new();
        for body in &coordinates.bodies {
            let Some(directors) = body.directors.filter(|d| d.iter().any(|d| joint.vectors.contains(d)))
            else {
                continue;
            };
            let force = Vec3::from(field[body.centre as usize]);
            let own = directors.map(|d| Vec3::from(field[d as usize]));
            // A force at a place of the body, such as that of a rod, has parallel director forces.
            let oblique: f64 = own.iter().map(|f| f.cross(&force).norm()).sum();
            let size: f64 = own.iter().map(Vec3::norm).sum();
            if force != Vec3::zeros() && oblique <= NO_COUPLE * size * force.norm() {
                continue;
            }
            let arm = place - current(body.centre);
            let mut couple = -arm.cross(&force);
            for (director, own) in directors.into_iter().zip(own) {
                let d = current(director);
                couple += d.cross(&own);
                field[director as usize] = (force * d.dot(&arm)).into();
            }
            if couple.norm() > NO_COUPLE * (size + arm.norm() * force.norm()) {
                couples.push((directors, couple));
            }
        }
        let about = joint.place(|v| Vec3::from(coordinates.reference[v as usize]));
        let set = ForceSet { name: format!("released.{}", joint.name), keys: Vec::new(), about };
        Released { set, field, couples }
    }

    /// Issue of a joint that acts again in a step, where its sides do not meet.
    fn open(&self, step: &StepModel, joint: &Joint, v: &[Vec3]) -> Option<Issue> {
        let [distance, angle] = joint.gap(v);
        if distance <= CLOSED * self.length && angle <= CLOSED {
            return None;
        }
        let angle = angle.to_degrees();
        Some(Issue::new(
            "released",
            format!(
                "the joint \"{}\" acts again in the step \"{}\", but its sides do not meet at the start: its points have moved apart by \
                 {distance:.3e}, and its axes by {angle:.3e} degrees",
                joint.name, step.name
            ),
            "release it in this step, too; or lock a joint that holds the sides where they stand",
        ))
    }

    /// Elements with the groups of these joints in the place of those of the model.
    fn groups_with(&self, joints: &Arc<Vec<Joint>>) -> Arc<Vec<Arc<dyn ElementGroup>>> {
        if joints.iter().all(|joint| joint.role == Role::Acting && joint.law.is_none()) {
            return Arc::clone(&self.groups);
        }
        let mut groups = (*self.groups).clone();
        // Joints have the nodal vectors of the model in all steps, and so the same groups.
        groups[self.joint_groups.clone()]
            .iter_mut()
            .zip(JointGroup::groups(joints))
            .for_each(|(group, own)| *group = own.into());
        Arc::new(groups)
    }
}
