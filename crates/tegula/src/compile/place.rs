//! Sides of joints and springs: the bodies, nodes or the ground that names stand for.

use super::inner_point::Corners;
use crate::checker::Checker;
use crate::constraint::joints::End;
use crate::element::VectorKind;
use crate::mesh::Mesh;
use crate::model::Model;
use crate::model::joint::GROUND;
use crate::system::Coordinates;
use crate::{Mat3, Vec3};

/// Relative distance of points that are the same but for round-off.
const SAME: f64 = 1e-9;

/// Model in which the sides of joints and springs are found.
pub(super) struct Place<'a> {
    /// Model.
    pub(super) model: &'a Model,
    /// Mesh.
    pub(super) mesh: &'a Mesh,
    /// Nodal vectors.
    pub(super) coordinates: &'a Coordinates,
    /// Size of the model (length).
    pub(super) length: f64,
    /// Corners of the shells.
    pub(super) corners: &'a Corners,
}

/// Both sides of a joint or spring, which must not lie beside the node or the point mass that they name; `None` where one does not
/// exist.
pub(super) fn ends(
    place: &Place,
    (key, between): (&str, &[String; 2]),
    points: [Option<(String, [f64; 3])>; 2],
    c: &mut Checker,
) -> Option<[End; 2]> {
    let [first, second] = [0, 1].map(|side| {
        let at = points[side].as_ref().map(|(key, at)| (key.as_str(), *at));
        end_at(place, (format!("{key}.between[{side}]"), &between[side]), at, c)
    });
    let ends = [first?, second?];
    for ((end, name), point) in ends.iter().zip(between).zip(points) {
        if let Some((key, at)) = point {
            not_beside(place, end, (key, name, at), c);
        }
    }
    Some(ends)
}

/// Refuses a point that lies beside the node or the point mass that it is meant to be on.
pub(super) fn not_beside(
    place: &Place,
    end: &End,
    (key, name, at): (String, &str, [f64; 3]),
    c: &mut Checker,
) {
    let End::Point { vector, .. } = end else { return };
    let x = Vec3::from(place.coordinates.reference[*vector as usize]);
    if (x - Vec3::from(at)).norm() > SAME * place.length {
        c.add(
            key,
            format!("the point lies beside \"{name}\", which is at ({}, {}, {})", x.x, x.y, x.z),
            "give the position of the node or the point mass",
        );
    }
}

/// Directors of a node with their values at the reference.
fn directors(coordinates: &Coordinates, node: u32) -> Vec<(u32, Vec3)> {
    let first = coordinates.position_of[node as usize] as usize;
    let of_node = (first..coordinates.len()).take_while(|&v| coordinates.nodes[v] == node);
    of_node
        .filter(|&v| coordinates.kinds[v] == VectorKind::Director)
        .map(|v| (v as u32, coordinates.reference[v].into()))
        .collect()
}

/// Body, node or ground that a name stands for, which is the value of this key.
pub(super) fn end(place: &Place, key: String, name: &str, c: &mut Checker) -> Option<End> {
    end_at(place, (key, name), None, c)
}

/// Body, node, ground or point of a shell that a name stands for, which is the value of a key. The point is the value of another one.
pub(super) fn end_at(
    place: &Place,
    (key, name): (String, &str),
    point: Option<(&str, [f64; 3])>,
    c: &mut Checker,
) -> Option<End> {
    let Place { model, mesh, coordinates, .. } = *place;
    if name == GROUND {
        return Some(End::Ground);
    }
    let body = coordinates.bodies.iter().find(|body| body.name == name);
    match (body, mesh.nodes_on(name)) {
        (Some(_), Some(_)) => {
            c.add(
                key,
                format!("\"{name}\" is the name of a body and of a set of the mesh"),
                "give the body another name",
            );
            None
        }
        (Some(body), None) => Some(match body.directors {
            None => End::Point { vector: body.centre, mass: body.mass, directors: Vec::new() },
            Some(directors) => {
                let vector = |v: u32| Vec3::from(coordinates.reference[v as usize]);
                End::Body {
                    vectors: (body.centre, directors),
                    reference: (vector(body.centre), Mat3::from_columns(&directors.map(vector))),
                    inertia: [body.inertia().0, body.inertia().1.trace()],
                }
            }
        }),
        (None, Some(nodes)) => match nodes[..] {
            [node] if coordinates.position_of.get(node as usize).is_some_and(|&v| v != u32::MAX) => {
                let directors = directors(coordinates, node);
                Some(End::Point { vector: coordinates.position_of[node as usize], mass: 0.0, directors })
            }
            _ => {
                let quads = mesh.quads_on(name).filter(|quads| !quads.is_empty());
                if let (Some(quads), Some((key, at))) = (quads, point) {
                    let reference = |v: u32| Vec3::from(coordinates.reference[v as usize]);
                    let found = place.corners.end(&quads, &at.into(), (reference, place.length));
                    return found.map_err(|(message, help)| c.add(key, message, help)).ok();
                }
                c.add(
                        key,
                        format!(
                            "set \"{name}\" holds {} nodes, and a joint connects one that belongs to an element, or a point of a set of elements",
                            nodes.len()
                        ),
                        "name a set of one node, or a set of elements and a point in one of them",
                    );
                None
            }
        },
        (None, None) => {
            let bodies = model.bodies.iter().map(|body| body.name.clone());
            let single = |set: &String| mesh.nodes_on(set).is_some_and(|nodes| nodes.len() == 1);
            let sets = mesh.set_names().into_iter().filter(single);
            let known: Vec<String> = bodies.chain([GROUND.to_owned()]).chain(sets).collect();
            c.missing(key, "body or set of one node", name, known.iter());
            None
        }
    }
}
