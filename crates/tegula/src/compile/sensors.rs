//! Sensors: from the model to points, angles and joints of the system.

use super::bodies::{names, not_with_itself};
use super::body_inertia::direction;
use super::place::{Place, end_at, ends, not_beside};
use crate::checker::Checker;
use crate::constraint::joints::{End, RelativeAngle};
use crate::constraint::{Attachment, ConeVolume, Joint, Measure, Sensor};
use crate::model::{self, Analysis, DistanceSensor, Model, PointSensor, StrainSensor, VolumeSensor};
use crate::{Issue, Vec3};

/// Mistakes in the values of sensors of a model with these joints, some of which may not act.
pub(super) fn keys(model: &Model, joints: &[model::Joint], c: &mut Checker) {
    names(model.sensors.iter().map(|sensor| sensor.name()), "sensors", &[], c);
    for (i, sensor) in model.sensors.iter().enumerate() {
        let (key, what) = (format!("sensors[{i}]"), format!("the sensor \"{}\"", sensor.name()));
        match sensor {
            model::Sensor::Distance(keys) => {
                keys.points.iter().for_each(|x| c.finite(&format!("{key}.points"), "the point", x));
                not_with_itself((&what, &keys.between), &key, c);
            }
            model::Sensor::Angle(keys) => {
                of_large_displacements(model, (&key, &what, "an angle"), c);
                direction(&format!("{key}.axis"), keys.axis, c);
                not_with_itself((&what, &keys.between), &key, c);
            }
            model::Sensor::Point(keys) => {
                keys.at.iter().for_each(|x| c.finite(&format!("{key}.at"), "the point", x));
            }
            model::Sensor::Volume(keys) => {
                of_large_displacements(model, (&key, &what, "a volume"), c);
                c.finite(&format!("{key}.tip"), "the tip", &keys.tip);
            }
            model::Sensor::Strain(keys) => {
                c.finite(&format!("{key}.at"), "the point", &keys.at);
                direction(&format!("{key}.direction"), keys.direction, c);
            }
            model::Sensor::Reaction(keys) => {
                let coupled = model.bodies.iter().filter(|body| !body.distributed.is_empty());
                let joints = joints.iter().map(|j| j.common().name().to_owned());
                let joints: Vec<String> = joints.chain(coupled.map(|body| body.name.clone())).collect();
                if !joints.contains(&keys.joint) {
                    c.missing(format!("{key}.joint"), "joint", &keys.joint, joints.iter());
                }
            }
        }
    }
}

/// Refuses a quantity of large displacements in a linear analysis.
fn of_large_displacements(model: &Model, (key, what, quantity): (&str, &str, &str), c: &mut Checker) {
    let linear = match &model.analysis {
        Analysis::Static(options) => options.linear,
        Analysis::Transient(options) => options.linear,
        Analysis::Path(_) | Analysis::Modal(_) | Analysis::Buckling(_) => false,
    };
    if linear {
        c.add(
            key,
            format!("{what} measures {quantity}, and a linear analysis has small displacements only"),
            "leave `linear` out, or measure the displacement of a point",
        );
    }
}

/// Sensors of the model, or what is wrong with the places that they name.
pub(super) fn sensors(place: &Place, joints: &[Joint], issues: &mut Vec<Issue>) -> Vec<Sensor> {
    let mut c = Checker::default();
    let compiled = |(i, sensor): (usize, &model::Sensor)| {
        let measure = measure(place, joints, (&format!("sensors[{i}]"), sensor), &mut c)?;
        Some(Sensor { name: sensor.name().clone(), measure })
    };
    let out = place.model.sensors.iter().enumerate().filter_map(compiled).collect();
    issues.append(&mut c.issues);
    out
}

fn measure(
    place: &Place,
    joints: &[Joint],
    (key, sensor): (&str, &model::Sensor),
    c: &mut Checker,
) -> Option<Measure> {
    match sensor {
        model::Sensor::Distance(keys) => distance(place, (key, keys), c),
        model::Sensor::Angle(keys) => {
            let ends = ends(place, (key, &keys.between), [None, None], c)?;
            let angle = RelativeAngle::new(&ends, &keys.axis.into());
            if angle.is_none() {
                c.add(
                    format!("{key}.between"),
                    format!(
                        "the sensor \"{}\" needs an axis on both sides, but a point mass or a node has none",
                        keys.name
                    ),
                    "name rigid bodies, nodes of beams or the ground",
                );
            }
            angle.map(|angle| Measure::Angle(Box::new(angle)))
        }
        model::Sensor::Point(keys) => point(place, (key, keys), c),
        model::Sensor::Volume(keys) => volume(place, (key, keys), c),
        model::Sensor::Strain(keys) => strain(place, (key, keys), c),
        model::Sensor::Reaction(keys) => {
            joints.iter().position(|joint| joint.name == keys.joint).map(Measure::Reaction)
        }
    }
}

fn distance(place: &Place, (key, keys): (&str, &DistanceSensor), c: &mut Checker) -> Option<Measure> {
    let points = [0, 1].map(|side| Some((format!("{key}.points[{side}]"), keys.points[side])));
    let [a, b] = ends(place, (key, &keys.between), points, c)?;
    Some(Measure::Distance([a.point(&keys.points[0].into()), b.point(&keys.points[1].into())]))
}

fn volume(place: &Place, (key, keys): (&str, &VolumeSensor), c: &mut Checker) -> Option<Measure> {
    let Some(quads) = place.mesh.quads_on(&keys.on) else {
        c.missing(format!("{key}.on"), "set of elements", &keys.on, place.mesh.quad_sets.keys());
        return None;
    };
    let position = |node: u32| place.coordinates.position_of[node as usize];
    let quads = quads.into_iter().map(|quad| place.mesh.quads[quad as usize].map(position)).collect();
    Some(Measure::Volume(ConeVolume { quads, tip: keys.tip.into() }))
}

fn strain(place: &Place, (key, keys): (&str, &StrainSensor), c: &mut Checker) -> Option<Measure> {
    let Some(quads) = place.mesh.quads_on(&keys.on) else {
        c.missing(format!("{key}.on"), "set of elements", &keys.on, place.mesh.quad_sets.keys());
        return None;
    };
    let reference = |v: u32| Vec3::from(place.coordinates.reference[v as usize]);
    let (at, direction) = (keys.at.into(), keys.direction.into());
    match place.corners.gauges(&quads, &at, &direction, (reference, place.length)) {
        Ok(gauges) => Some(Measure::Strain(gauges)),
        Err((message, help)) => {
            c.add(key, format!("the sensor \"{}\": {message}", keys.name), help);
            None
        }
    }
}

fn point(place: &Place, (key, keys): (&str, &PointSensor), c: &mut Checker) -> Option<Measure> {
    let point_key = format!("{key}.at");
    let at = keys.at.map(|at| (point_key.as_str(), at));
    let end = end_at(place, (format!("{key}.on"), &keys.on), at, c)?;
    if let Some(at) = keys.at {
        not_beside(place, &end, (format!("{key}.at"), &keys.on, at), c);
    }
    let point = match (&end, keys.at) {
        (End::Ground, _) => {
            c.add(
                format!("{key}.on"),
                format!("the sensor \"{}\" is on the ground, which does not move", keys.name),
                "name a body or a set with one node",
            );
            return None;
        }
        (_, Some(at)) => end.point(&at.into()),
        (End::Body { vectors: (vector, _), .. } | End::Point { vector, .. }, None) => {
            Attachment::vector(*vector)
        }
        // Without a place there is no point inside an element.
        (End::Interior { .. }, None) => return None,
    };
    Some(Measure::Point(point))
}
