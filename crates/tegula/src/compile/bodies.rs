//! Rigid bodies, point masses and joints: from the model to nodal vectors and constraints.

use super::body_inertia::{self, axes, centre, direction, euler_tensor, mass};
use super::inner_point::Corners;
use super::place::{Place, end, ends};
use crate::checker::Checker;
use crate::constraint::joints::{End, SecondPlace, joint_at};
use crate::constraint::{Drive, Joint};
use crate::element::Nodal;
use crate::mesh::Mesh;
use crate::model::joint::GROUND;
use crate::model::{self, Analysis, Load, Model, RigidBody};
use crate::norm::larger;
use crate::system::Coordinates;
use crate::system::coordinates::Body;
use crate::{Issue, Vec3};

/// Longest name of a body or a joint (characters): it becomes part of file names.
pub(super) const LONGEST_NAME: usize = 60;

/// Mistakes in the values of bodies and joints.
pub(super) fn keys(model: &Model, c: &mut Checker) {
    if !model.is_mechanism() {
        return;
    }
    let kinematic = matches!(&model.analysis, Analysis::Transient(t) if t.scheme.is_kinematic());
    let moves = matches!(&model.analysis, Analysis::Transient(t) if t.scheme.moves_bodies());
    let is_linear = matches!(&model.analysis, Analysis::Transient(t) if t.linear);
    let transient = moves && !is_linear;
    if !transient && !super::patches::solved_at_rest(model) {
        c.add(
            "analysis",
            "bodies, beams, joints, ties, springs and bushings move in nonlinear transient analyses with the schemes \"energy-momentum\", \
             \"generalized-alpha\", \"hht\", \"bdf2\", \"explicit\" and \"kinematic\" only; nonlinear static analyses with the direct solver, paths, modal and buckling analyses take them, too",
            if moves && is_linear {
                "leave `linear = true` out"
            } else {
                "give `type = \"transient\"` and `scheme = { type = \"energy-momentum\" }`, or for numerical damping \
                 `scheme = { type = \"generalized-alpha\" }` or \"hht\"; leave `linear = true` out"
            },
        );
    }
    if !matches!(model.analysis, Analysis::Transient(_)) {
        held(model, c);
    }
    let joint_names: Vec<String> =
        model.joints.iter().map(|joint| joint.common().name().to_owned()).collect();
    let beams: Vec<&String> = model.beams.iter().map(|beam| &beam.name).collect();
    names(model.bodies.iter().map(|body| &body.name), "bodies", &beams, c);
    names(joint_names.iter(), "joints", &[], c);
    names(model.springs.iter().map(|spring| &spring.name), "springs", &[], c);
    names(model.torsion_springs.iter().map(|spring| &spring.name), "torsion_springs", &[], c);
    for (i, body) in model.bodies.iter().enumerate() {
        body_inertia::values(body, &format!("bodies[{i}]"), kinematic, c);
    }
    for (i, joint) in model.joints.iter().enumerate() {
        let (keys, place) = (joint.common(), format!("joints[{i}]"));
        for (key, point) in keys.points() {
            c.finite(&format!("{place}.{key}"), "the point", &point);
        }
        for (key, axis) in keys.directions() {
            direction(&format!("{place}.{key}"), axis, c);
        }
        let second = keys.second_side();
        if let Some(point) = second.at {
            c.finite(&format!("{place}.second_at"), "the point", &point);
        }
        if let Some(axis) = second.axis {
            direction(&format!("{place}.second_axis"), axis, c);
        }
        not_with_itself((&format!("joint \"{}\"", keys.name()), keys.between()), &place, c);
        joint.check(&place, c);
        if let Some(drive) = keys.drive() {
            c.finite(&format!("{place}.{}", drive.key), "the motion at amplitude 1", &[drive.given]);
            if !model.amplitudes.contains_key(drive.amplitude) {
                c.missing(
                    format!("{place}.amplitude"),
                    "amplitude",
                    drive.amplitude,
                    model.amplitudes.keys(),
                );
            }
        }
    }
    super::springs::keys(model, c);
    super::guided_axes::keys(model, c);
    super::bushings::keys(model, c);
    super::couplings::keys(model, c);
}

/// Bodies of a static analysis that nothing holds.
fn held(model: &Model, c: &mut Checker) {
    let joints = model.joints.iter().flat_map(|joint| joint.common().between());
    let springs = model.springs.iter().flat_map(|spring| &spring.between);
    let torsion = model.torsion_springs.iter().flat_map(|spring| &spring.between);
    let bushings = model.bushings.iter().flat_map(|bushing| &bushing.between);
    let sides: Vec<&String> = joints.chain(springs).chain(torsion).chain(bushings).collect();
    let loose = |body: &RigidBody| !body.is_on_nodes() && !sides.contains(&&body.name);
    for (i, body) in model.bodies.iter().enumerate().filter(|(_, body)| loose(body)) {
        let message = format!("nothing holds body \"{}\" in a static or modal analysis", body.name);
        c.add(
            format!("bodies[{i}]"),
            message,
            "connect it by a joint, a spring or a bushing, give it `attached` or `distributed` nodes, or leave it out",
        );
    }
}

/// A joint or spring that connects a body with itself.
pub(super) fn not_with_itself((what, between): (&str, &[String; 2]), key: &str, c: &mut Checker) {
    if between[0] == between[1] {
        c.add(
            format!("{key}.between"),
            format!("{what} connects \"{}\" with itself", between[0]),
            "name two different bodies, nodes, or the ground",
        );
    }
}

/// Names that serve as file names and are given once.
pub(super) fn names<'a>(
    list: impl Iterator<Item = &'a String> + Clone,
    key: &str,
    beams: &[&String],
    c: &mut Checker,
) {
    for (i, name) in list.clone().enumerate() {
        let place = format!("{key}[{i}].name");
        if !c.file_name(&place, name, LONGEST_NAME) {
            continue;
        }
        if let Some(beam) = beams.iter().find(|beam| is_node_of(name, beam)) {
            let message = format!("\"{name}\" is the name of a node of the beam \"{beam}\"");
            c.add(place, message, "give the body another name");
        } else if name == GROUND && key == "bodies" {
            c.add(place, "the name \"ground\" stands for the ground in joints", "give the body another name");
        } else if list.clone().take(i).any(|other| other == name) {
            c.add(place, format!("the name \"{name}\" is given twice"), "give each one its own name");
        }
    }
}

/// Whether a body has the name of a node of a beam: that of the beam, a point, and `start`, `end` or a number.
fn is_node_of(name: &str, beam: &str) -> bool {
    let node = name.strip_prefix(beam).and_then(|rest| rest.strip_prefix('.'));
    node.is_some_and(|node| node == "start" || node == "end" || node.parse::<u32>().is_ok())
}

/// Adds the nodal vectors of all bodies.
pub(super) fn add_vectors(model: &Model, coordinates: &mut Coordinates) {
    for body in &model.bodies {
        let rotary = (!body.is_point_mass()).then(|| (axes(body), euler_tensor(body)));
        coordinates.push_body(&body.name, centre(body), (mass(body), rotary));
    }
}

/// Adds the velocities of bodies at the start, where their nodal vectors are the `current` ones, to those of nodes; empty while all
/// are zero.
pub(super) fn add_velocities(
    model: &Model,
    (coordinates, current): (&Coordinates, &[Nodal]),
    out: &mut Vec<Nodal>,
) {
    for (data, body) in model.bodies.iter().zip(&coordinates.bodies) {
        if data.velocity == [0.0; 3] && data.angular_velocity == [0.0; 3] {
            continue;
        }
        out.resize(coordinates.len(), [0.0; 3]);
        out[body.centre as usize] = data.velocity;
        let omega = Vec3::from(data.angular_velocity);
        for d in body.directors.iter().flatten() {
            out[*d as usize] = omega.cross(&Vec3::from(current[*d as usize])).into();
        }
    }
}

/// Size of a model with bodies (length): largest side of the box about nodes, mass centres and joints, or for a single
/// body its radius of gyration. For a single point mass it is the shortest of its springs, whose direction changes most with
/// its motion; without springs the equations have no length, and it is 1.
pub(super) fn extent(model: &Model, mesh: &Mesh, coordinates: &Coordinates) -> f64 {
    if model.bodies.is_empty() && model.joints.is_empty() {
        return mesh.extent();
    }
    let joints = model.joints.iter().flat_map(|joint| joint.common().points()).map(|(_, x)| Vec3::from(x));
    let curves = model.joints.iter().flat_map(|joint| joint.common().curve()).map(|x| Vec3::from(*x));
    let second = model.joints.iter().filter_map(|joint| joint.common().second_side().at).map(Vec3::from);
    let joints = joints.chain(curves).chain(second);
    let bodies = model.bodies.iter().map(centre);
    let points = mesh.positions.iter().copied().chain(joints).chain(bodies);
    let [low, high] = points
        .fold([Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY)], |[a, b], x| {
            [a.inf(&x), b.sup(&x)]
        });
    let largest = coordinates.bodies.iter().map(Body::gyration).fold((high - low).max(), larger);
    if largest > 0.0 {
        return largest;
    }
    let springs = model.springs.iter().map(|spring| {
        let [a, b] = spring.points.map(Vec3::from);
        (b - a).norm()
    });
    springs.filter(|length| *length > 0.0).min_by(f64::total_cmp).unwrap_or(1.0)
}

/// Both sides of the joint with this number, and the carrier of gears; `None` where one does not exist.
pub(super) fn sides(
    place: &Place,
    (number, data): (usize, &model::Joint),
    c: &mut Checker,
) -> Option<([End; 2], End)> {
    let (keys, key) = (data.common(), format!("joints[{number}]"));
    let at = |side: usize| {
        if let Some(second) = keys.second_side().at.filter(|_| side == 1) {
            return Some((format!("{key}.second_at"), second));
        }
        let points = keys.points();
        let (point, at) = points.get(side).or_else(|| points.first())?;
        Some((format!("{key}.{point}"), *at))
    };
    let found = ends(place, (&key, keys.between()), [at(0), at(1)], c);
    let carrier = match keys.carrier() {
        Some(name) => end(place, format!("{key}.carrier"), name, c),
        None => Some(End::Ground),
    };
    found.zip(carrier)
}

/// Body that is one of two ends, and whose attached node is the other one.
fn within_a_body<'a>(ends: &[End; 2], coordinates: &'a Coordinates) -> Option<&'a Body> {
    let ([End::Body { vectors: (centre, _), .. }, End::Point { vector, .. }]
    | [End::Point { vector, .. }, End::Body { vectors: (centre, _), .. }]) = ends
    else {
        return None;
    };
    let body = coordinates.bodies.iter().find(|body| body.centre == *centre)?;
    body.attached.iter().any(|attached| attached.vector == *vector).then_some(body)
}

/// Joints of the model, or what is wrong with their ends.
pub(super) fn joints(
    model: &Model,
    (mesh, corners): (&Mesh, &Corners),
    coordinates: &Coordinates,
    issues: &mut Vec<Issue>,
) -> Vec<Joint> {
    let mut c = Checker::default();
    let length = extent(model, mesh, coordinates);
    let assembled = model.joints.iter().any(|joint| joint.common().second_side().is_given());
    let mut out: Vec<Joint> = Vec::new();
    for (i, data) in model.joints.iter().enumerate() {
        let (keys, key) = (data.common(), format!("joints[{i}]"));
        let place = Place { model, mesh, coordinates, length, corners };
        let Some((ends, carrier)) = sides(&place, (i, data), &mut c) else { continue };
        if let Some(body) = within_a_body(&ends, coordinates) {
            c.add(
                format!("{key}.between"),
                format!(
                    "the joint \"{}\" is between body \"{}\" and a node that is attached to it",
                    keys.name(),
                    body.name
                ),
                "take the node out of the `attached` set, or leave the joint out",
            );
            continue;
        }
        let drive = keys.drive().and_then(|drive| {
            let amplitude = model.amplitudes.keys().position(|name| name == drive.amplitude)?;
            Some(Drive { amplitude, value: drive.value, offset: 0.0 })
        });
        let second = SecondPlace::of(keys, 1.0, length).in_assembly(assembled);
        match joint_at(data, (ends, carrier, second), length, (&out, drive)) {
            Ok(made) if made.vectors.is_empty() => {}
            Ok(made) => out.push(made),
            Err(lack) => {
                let (message, help) = lack.told(keys.name());
                c.add(format!("{key}.between"), message, help);
            }
        }
    }
    issues.append(&mut c.issues);
    out
}

/// A load on a body, which must not have the name of a set, nor turn a point mass.
pub(super) fn load_on_body(model: &Model, load: &Load, key: &str, mesh: &Mesh, c: &mut Checker) {
    let name = load.on();
    if mesh.nodes_on(name).is_some() {
        c.add(
            key,
            format!("\"{name}\" is the name of a body and of a set of the mesh"),
            "give the body another name",
        );
    }
    let refused = match load.kind() {
        "moment" | "follower-moment" => "on which a moment cannot act",
        "follower-force" => "which has no axes that a force could turn with",
        _ => return,
    };
    if model.bodies.iter().any(|body| body.name == name && body.is_point_mass()) {
        c.add(
            key,
            format!("body \"{name}\" is a point mass, {refused}"),
            "give the body an inertia or a shape, or load another body",
        );
    }
}
