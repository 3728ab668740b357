//! Axes of drives, gears and torsion springs against those of the joints beside which they stand.
//!
//! A drive of an angle about another axis than that of the hinge beside it holds the twist about this axis, which is not the angle of the
//! hinge.

use crate::checker::Checker;
use crate::model::{Joint, Model};
use crate::{Issue, Vec3};

/// Sine of the angle above which two axes are different.
const PARALLEL: f64 = 1e-6;

/// Motion that is driven.
#[derive(Clone, Copy, PartialEq)]
enum Motion {
    Rotation,
    Translation,
}

/// Joint that leaves a motion about or along its axis free, with the names of both sides.
fn guide(joint: &Joint, motion: Motion) -> Option<(&str, &[String; 2], Vec3)> {
    match (joint, motion) {
        (Joint::Revolute(keys), Motion::Rotation) | (Joint::Prismatic(keys), Motion::Translation) => {
            Some((&keys.name, &keys.between, keys.axis.into()))
        }
        (Joint::Planar(keys), Motion::Rotation) | (Joint::Cylindrical(keys), _) => {
            Some((&keys.name, &keys.between, keys.axis.into()))
        }
        (Joint::Screw(keys), _) => Some((&keys.name, &keys.between, keys.axis.into())),
        _ => None,
    }
}

/// Adds drives, wheels of gears and torsion springs whose axis is not that of the joint between the same two sides.
pub(super) fn keys(model: &Model, c: &mut Checker) {
    for (i, joint) in model.joints.iter().enumerate() {
        let (axis, motion) = match joint {
            Joint::DrivenAngle(keys) => (keys.axis, Motion::Rotation),
            Joint::DrivenLength(keys) => (keys.axis, Motion::Translation),
            _ => continue,
        };
        let keys = joint.common();
        let what = format!("the drive \"{}\"", keys.name());
        one(model, (&format!("joints[{i}].axis"), &what), (keys.between(), axis), motion, c);
    }
    for (i, joint) in model.joints.iter().enumerate() {
        let Joint::Gear(keys) = joint else { continue };
        for (side, wheel) in keys.between.iter().enumerate() {
            let what = format!("the wheel \"{wheel}\" of the gear \"{}\"", keys.name);
            let (key, between) = (format!("joints[{i}].axes[{side}]"), [keys.carrier.clone(), wheel.clone()]);
            one(model, (&key, &what), (&between, keys.axes[side]), Motion::Rotation, c);
        }
    }
    for (i, spring) in model.torsion_springs.iter().enumerate() {
        let what = format!("the torsion spring \"{}\"", spring.name);
        let key = format!("torsion_springs[{i}].axis");
        one(model, (&key, &what), (&spring.between, spring.axis), Motion::Rotation, c);
    }
}

/// Sides of a hinge, with a point of its axis and the direction.
fn hinge(joint: &Joint) -> Option<(&[String; 2], [Vec3; 2])> {
    match joint {
        Joint::Revolute(keys) => Some((&keys.between, [keys.at.into(), keys.axis.into()])),
        Joint::Cylindrical(keys) => Some((&keys.between, [keys.at.into(), keys.axis.into()])),
        Joint::Screw(keys) => Some((&keys.between, [keys.at.into(), keys.axis.into()])),
        _ => None,
    }
}

/// Whether two axes are one line.
fn coaxial([at, axis]: &[Vec3; 2], [other, direction]: &[Vec3; 2]) -> bool {
    let apart = other - at;
    axis.cross(direction).norm() <= PARALLEL * axis.norm() * direction.norm()
        && axis.cross(&apart).norm() <= PARALLEL * axis.norm() * apart.norm()
}

/// Wheels of gears with hinges to other bodies, and none to the carrier relative to which their angle counts: none between both, and none
/// on the axis of a hinge of the carrier.
pub(super) fn wheels_beside_carriers(model: &Model) -> Vec<Issue> {
    let hinges: Vec<_> = model.joints.iter().filter_map(hinge).collect();
    let mut found = Vec::new();
    for (i, joint) in model.joints.iter().enumerate() {
        let Joint::Gear(keys) = joint else { continue };
        for wheel in &keys.between {
            let other = |between: &'_ [String; 2]| between[usize::from(between[0] == *wheel)].clone();
            let own: Vec<_> = hinges.iter().filter(|(between, _)| between.contains(wheel)).collect();
            let in_carrier = own.iter().any(|(between, line)| {
                let through = other(between);
                let joins =
                    |between: &[String; 2]| between.contains(&through) && between.contains(&keys.carrier);
                through == keys.carrier
                    || hinges.iter().any(|(between, next)| joins(between) && coaxial(line, next))
            });
            let Some((between, _)) = own.first().filter(|_| !in_carrier) else { continue };
            let other = other(between);
            found.push(Issue::new(
                format!("joints[{i}].carrier"),
                format!(
                    "the wheel \"{wheel}\" of the gear \"{}\" has a hinge to \"{other}\", but none to the carrier \"{}\", relative to \
                     which its angle counts",
                    keys.name, keys.carrier
                ),
                "name the body in which the hinges of both wheels lie as `carrier`",
            ));
        }
    }
    found
}

/// Joint with another axis on its second side beside which something turns whose sides are named in the other order: its axis would be that
/// of the joint's first side on its second one.
fn exchanged(model: &Model, between: &[String; 2], motion: Motion) -> Option<String> {
    let turned = model.joints.iter().filter(|joint| joint.common().second_side().axis.is_some());
    let guides = turned.filter_map(|joint| guide(joint, motion));
    let mut exchanged = guides.filter(|(_, other, _)| other[0] == between[1] && other[1] == between[0]);
    exchanged.next().map(|(name, ..)| name.to_owned())
}

fn one(
    model: &Model,
    (key, what): (&str, &str),
    (between, axis): (&[String; 2], [f64; 3]),
    motion: Motion,
    c: &mut Checker,
) {
    if let Some(name) = exchanged(model, between, motion) {
        c.add(
            key.replace("axis", "between").replace("axes", "between"),
            format!(
                "{what} names its sides in the other order than the joint \"{name}\", whose axis lies elsewhere on its second side \
                 (`second_axis`)"
            ),
            "name the sides of both in the same order; the sense of an angle changes with it",
        );
        return;
    }
    let axis = Vec3::from(axis);
    let same = |other: &[String; 2]| other == between || (other[0] == between[1] && other[1] == between[0]);
    let guides = model.joints.iter().filter_map(|joint| guide(joint, motion));
    for (name, _, guided) in guides.filter(|(_, other, _)| same(other)) {
        if axis.cross(&guided).norm() > PARALLEL * axis.norm() * guided.norm() {
            c.add(
                key,
                format!("the axis of {what} is not that of the joint \"{name}\" between the same two sides"),
                "give both the same axis",
            );
        }
    }
}
