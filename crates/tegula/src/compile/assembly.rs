//! Assembly of a model at its start: joints whose sides do not meet in the reference configuration are closed.
//!
//! Bodies with places and orientations of their own, as they come from drawings of single parts, seldom meet exactly. The reference
//! configuration stays that of the model file; each analysis step that would begin in it begins in the position [nearest](super::closing) to it
//! in which all joints are closed. Driven joints keep the angle or length of the reference configuration, gears mesh where they come to stand,
//! locked joints whose sides meet hold them. Nodes of shells and beams, and bodies that are attached to nodes, do not move.

use std::sync::Arc;

use super::Compiler;
use super::bodies::sides;
use super::closing::{Aim, Closing, Movable};
use super::place::Place;
use super::steps::StepModel;
use crate::checker::Checker;
use crate::constraint::joints::{End, NO_GAP, RelativeAngle, SecondPlace, joint_at};
use crate::constraint::{Joint, Row};
use crate::element::Nodal;
use crate::model;
use crate::norm::larger;
use crate::system::{ClosedGap, ClosedGaps, MovedBody, PathBefore, StepStart};
use crate::{Issue, Mat3, Vec3};

/// First and smallest part of the way from sides that meet to those of the model, along which joints are led.
const WAY: [f64; 2] = [0.125, 1e-3];

/// Start of a step in the assembled position, and what was changed for it.
pub(super) type Assembled = (StepStart, Arc<ClosedGaps>);

/// Joint whose sides do not meet in the reference configuration.
struct Gap {
    keys: model::Joint,
    /// Key in the model of the step.
    key: String,
    ends: [End; 2],
    /// Joint among those that are closed.
    joint: usize,
    before: ClosedGap,
}

impl Compiler<'_> {
    /// Assembled starts of all steps, of which only those that begin in the reference configuration have one.
    pub(super) fn assembled(&self, place: &Place, issues: &mut Vec<Issue>) -> Vec<Option<Assembled>> {
        let mut of_step = |step: &StepModel| {
            let given = |joint: &model::Joint| joint.common().second_side().is_given();
            if step.starts_from.is_some() || !step.model.joints.iter().any(given) {
                return None;
            }
            let mut found = Vec::new();
            let out = self.assemble(step, place, &mut found);
            issues
                .extend(step.located(found).into_iter().filter(|f| !issues.contains(f)).collect::<Vec<_>>());
            out
        };
        self.steps.iter().map(&mut of_step).collect()
    }

    fn assemble(&self, step: &StepModel, place: &Place, issues: &mut Vec<Issue>) -> Option<Assembled> {
        let reference: Vec<Vec3> = place.coordinates.reference.iter().map(|x| Vec3::from(*x)).collect();
        let joints = self.closed_joints(step, &reference);
        let gaps = gaps(step, place, &joints, &reference);
        if !gaps.iter().any(|gap| gap.is_open(self.length)) {
            return None;
        }
        let bodies = self.movable(place);
        let closing = Closing::new((&joints, &bodies), (&reference, self.length));
        let mut x = reference.clone();
        closing.close(&mut x);
        let immovable = gaps.iter().filter(|gap| !closing.moves(gap.joint) && gap.is_open(self.length));
        let found: Vec<Issue> = immovable.map(Gap::immovable).collect();
        if !found.is_empty() {
            issues.extend(found);
            return None;
        }
        if !closing.is_closed(&x) {
            x.clone_from(&reference);
            self.lead(&mut x, &gaps, (&joints, &bodies), &reference);
        }
        let axes = step.model.joints.iter().flat_map(|joint| joint.common().directions());
        let axes: Vec<Vec3> = axes.map(|(_, axis)| Vec3::from(axis)).collect();
        if let Some(nearest) = closing.nearest(x.clone(), &axes) {
            return Some(self.start_at(step, &nearest, &reference, gaps));
        }
        x.clone_from(&reference);
        let has_gap = |joint: &usize| gaps.iter().any(|gap| gap.joint == *joint);
        let (own, others): (Vec<usize>, Vec<usize>) = (0..joints.len()).partition(has_gap);
        let [own, others] = [own, others].map(|of| of.iter().map(|&j| joints[j].clone()).collect::<Vec<_>>());
        let at = (reference.as_slice(), self.length);
        let gap = Closing::new((&own, &bodies), at).by_size();
        Closing::new((&others, &bodies), at).approach(&Aim::Gaps(&gap), &mut x);
        issues.extend(open(&gaps, &joints, &x, self.length));
        None
    }

    /// Joints of a step that hold when it is assembled.
    fn closed_joints(&self, step: &StepModel, reference: &[Vec3]) -> Vec<Joint> {
        let meet = |name: &str| {
            let keys = step.model.joints.iter().find(|keys| keys.common().name() == name);
            keys.is_none_or(|keys| !keys.common().second_side().is_given())
        };
        let acting = self.joints.iter().filter(|joint| !step.released.contains(&joint.name));
        let of_step = |joint: &Joint| {
            let locked = step.locked.contains(&joint.name) && meet(&joint.name);
            self.with_lock(joint, locked, |v| reference[v as usize])
        };
        acting.filter(|joint| joint.counted.is_none()).map(of_step).collect()
    }

    /// Bodies that are not held by nodes of shells or beams.
    fn movable(&self, place: &Place) -> Vec<Movable> {
        let bodies = &place.coordinates.bodies;
        let own = self.beams.first().map_or(bodies.len(), |beam| beam.bodies.start);
        let free = place.model.bodies.iter().zip(bodies).take(own).filter(|(data, _)| !data.is_on_nodes());
        let free: Vec<_> = free.map(|(_, body)| body).collect();
        let masses: Vec<f64> = free.iter().map(|body| body.mass).filter(|mass| *mass > 0.0).collect();
        let mean = if masses.is_empty() { 1.0 } else { masses.iter().sum::<f64>() / masses.len() as f64 };
        free.into_iter().map(|body| Movable::new(body, self.length, mean)).collect()
    }

    /// Leads the joints from sides that meet to those of the model, part by part: axes that differ by more than a right angle do not come to
    /// stand opposite to each other.
    fn lead(
        &self,
        x: &mut Vec<Vec3>,
        gaps: &[Gap],
        (joints, bodies): (&[Joint], &[Movable]),
        reference: &[Vec3],
    ) {
        let (mut at, mut step) = (0.0, WAY[0]);
        while at < 1.0 {
            let next = f64::min(at + step, 1.0);
            let mut partly = joints.to_vec();
            for gap in gaps {
                let sides =
                    (gap.ends.clone(), End::Ground, SecondPlace::of(gap.keys.common(), next, self.length));
                let Ok(made) = joint_at(&gap.keys, sides, self.length, (&[], None)) else { return };
                let joint = &mut partly[gap.joint];
                (joint.vectors, joint.rows) = (made.vectors, made.rows);
            }
            let closing = Closing::new((&partly, bodies), (reference, self.length));
            let mut trial = x.clone();
            closing.close(&mut trial);
            if closing.is_closed(&trial) {
                (*x, at) = (trial, next);
            } else {
                step *= 0.5;
                if !(step >= WAY[1]) {
                    return;
                }
            }
        }
    }

    /// Start of a step in which the nodal vectors have the values x.
    fn start_at(&self, step: &StepModel, x: &[Vec3], reference: &[Vec3], gaps: Vec<Gap>) -> Assembled {
        let angle = |angle: &RelativeAngle| {
            let v: Vec<Vec3> = angle.vectors.iter().map(|&v| x[v as usize]).collect();
            RelativeAngle::continued(0.0, angle.forms(&v))
        };
        let sensors = self.sensors.iter().filter_map(|sensor| sensor.angle()).map(angle);
        let gears = self.joints.iter().filter_map(|joint| joint.counted.as_deref()).map(angle);
        let start = StepStart {
            time: 0.0,
            path: PathBefore::default(),
            u: x.iter().zip(reference).map(|(x, at)| Nodal::from(x - at)).collect(),
            v: Vec::new(),
            history: vec![0.0; self.offsets.last().map_or(0, |last| last.history.end)],
            multipliers: vec![0.0; self.constraints_in(step)],
            angles: sensors.chain(gears).collect(),
            coordinates: Vec::new(),
        };
        let moved = |body: &crate::system::coordinates::Body| {
            let displacement = x[body.centre as usize] - reference[body.centre as usize];
            let rotation = body.directors.map_or_else(Vec3::zeros, |d| {
                let [now, then] = [x, reference].map(|x| Mat3::from_columns(&d.map(|d| x[d as usize])));
                let rotation = nalgebra::Rotation3::from_matrix_unchecked(now * then.transpose());
                nalgebra::UnitQuaternion::from_rotation_matrix(&rotation).scaled_axis()
            });
            let far = displacement.norm() > NO_GAP * self.length || rotation.norm() > NO_GAP;
            let name = body.name.clone();
            far.then(|| MovedBody { name, displacement: displacement.into(), rotation: rotation.into() })
        };
        let open = gaps.into_iter().filter(|gap| gap.is_open(self.length));
        let joints = open.map(|gap| gap.before).collect();
        let bodies = self.vectors.coordinates.bodies.iter().filter_map(moved).collect();
        (start, Arc::new(ClosedGaps { joints, bodies }))
    }
}

/// Joints of a step with a second side.
fn gaps(step: &StepModel, place: &Place, joints: &[Joint], reference: &[Vec3]) -> Vec<Gap> {
    let of_joint = |(i, keys): (usize, &model::Joint)| {
        let common = keys.common();
        let given = common.second_side();
        let joint =
            joints.iter().position(|joint| joint.name == common.name()).filter(|_| given.is_given())?;
        let (ends, _) = sides(place, (i, keys), &mut Checker::default())?;
        let v: Vec<Vec3> = joints[joint].vectors.iter().map(|&v| reference[v as usize]).collect();
        let [distance, mut angle] = joints[joint].gap(&v);
        if let (Some(other), Some((_, own))) = (given.axis, common.directions().first()) {
            let (a, b) = (Vec3::from(*own), Vec3::from(other));
            angle = larger(angle, a.cross(&b).norm().atan2(a.dot(&b)));
        }
        let key = format!("joints[{i}].{}", if given.at.is_some() { "second_at" } else { "second_axis" });
        let before = ClosedGap { name: common.name().to_owned(), distance, angle };
        Some(Gap { keys: keys.clone(), key, ends, joint, before })
    };
    step.model.joints.iter().enumerate().filter_map(of_joint).collect()
}

impl Gap {
    fn is_open(&self, length: f64) -> bool {
        self.before.distance > NO_GAP * length || self.before.angle > NO_GAP
    }

    fn immovable(&self) -> Issue {
        Issue::new(
            &self.key,
            format!(
                "the sides of the joint \"{}\" do not meet, and none of them is a rigid body that moves when the model is assembled: nodes of \
                 shells and beams, and bodies that are attached to nodes, do not",
                self.before.name
            ),
            "let both sides meet in the reference configuration, or put a rigid body between them",
        )
    }
}

/// Issue of the joint that stays open in the position x, in which the gaps are least.
fn open(gaps: &[Gap], joints: &[Joint], x: &[Vec3], length: f64) -> Option<Issue> {
    let at = |joint: &Joint| joint.vectors.iter().map(|&v| x[v as usize]).collect::<Vec<Vec3>>();
    let left = gaps.iter().map(|gap| (gap, joints[gap.joint].gap(&at(&joints[gap.joint]))));
    let size = |gap: &[f64; 2]| larger(gap[0] / length, gap[1]);
    let (gap, [distance, angle]) = left.max_by(|a, b| size(&a.1).total_cmp(&size(&b.1)))?;
    let opposite =
        joints.iter().any(|joint| joint.rows.iter().any(|row: &Row| !row.is_on_branch(&at(joint), 0.0)));
    let rest = if size(&[distance, angle]) <= NO_GAP.sqrt() && opposite {
        "its axes meet in opposite directions only".to_owned()
    } else if distance / length >= angle {
        format!("its points stay apart by the distance {distance:.6e}")
    } else {
        format!("its axes stay apart by the angle {:.6} degrees", angle.to_degrees())
    };
    let others: Vec<String> = gaps
        .iter()
        .filter(|other| other.joint != gap.joint)
        .map(|gap| format!("\"{}\"", gap.before.name))
        .collect();
    let beside = if others.is_empty() { String::new() } else { format!(" beside {}", others.join(", ")) };
    Some(Issue::new(
        &gap.key,
        format!("the joint \"{}\" cannot be closed{beside}: {rest}", gap.before.name),
        "check the points and axes of both sides and the lengths of the bodies; `second_at` and `second_axis` are given in the reference \
         configuration, as the second side lies in it",
    ))
}
