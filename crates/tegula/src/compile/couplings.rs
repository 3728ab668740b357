//! Distributing couplings: bodies that follow the weighted mean motion of nodes of the mesh.

use std::collections::{BTreeMap, BTreeSet};

use super::inner_point::Corners;
use super::place::{Place, end};
use super::sections::Elements;
use crate::checker::Checker;
use crate::constraint::Joint;
use crate::constraint::distributing::{AveragedNode, distributing};
use crate::constraint::joint::MOST_COUPLED_VECTORS;
use crate::element::ElementGroup;
use crate::element::geometry::nodal_areas;
use crate::mesh::Mesh;
use crate::model::{Model, RigidBody};
use crate::norm::larger;
use crate::system::supports::Support;
use crate::system::{Coordinates, VectorKind};
use crate::{Issue, Mat3, Vec3};

/// Relative distance of points that are the same but for round-off.
const SAME: f64 = 1e-9;
/// Determinant of the sum of the dyads of supported directions above which they span space.
const SPANNED: f64 = 1e-9;

/// Whether a body of the model follows the mean motion of nodes.
pub(super) fn has_couplings(model: &Model) -> bool {
    model.bodies.iter().any(|body| !body.distributed.is_empty())
}

/// Weights of bodies that follow nodes, and their names: a coupling has columns as a joint has, so that no joint must have the same name.
pub(super) fn keys(model: &Model, c: &mut Checker) {
    for (i, body) in model.bodies.iter().enumerate() {
        let key = format!("bodies[{i}].weights");
        let [weights, sets] = [body.weights.len(), body.distributed.len()];
        if weights > 0 && weights != sets {
            let message =
                format!("body \"{}\" has {weights} weights for {sets} `distributed` sets", body.name);
            c.add(key.as_str(), message, "give a number for each set, or leave `weights` out");
        }
        body.weights.iter().for_each(|weight| c.positive(&key, "a weight", *weight));
    }
    for (i, body) in model.bodies.iter().enumerate().filter(|(_, body)| !body.distributed.is_empty()) {
        if !body.attached.is_empty() {
            c.add(
                format!("bodies[{i}].distributed"),
                format!("body \"{}\" has `attached` nodes, which move with it, and `distributed` ones, which it follows", body.name),
                "keep one of the two, or give two bodies and a joint with type = \"fixed\" between them",
            );
        }
        if let Some(joint) = model.joints.iter().position(|joint| joint.common().name() == body.name) {
            c.add(
                format!("joints[{joint}].name"),
                format!("\"{}\" is the name of a body with `distributed` nodes, whose forces have the columns `joint.{0}`", body.name),
                "give the joint another name",
            );
        }
    }
}

/// Adds the couplings of bodies to the joints, or what is wrong with their nodes.
pub(super) fn add(
    (model, mesh): (&Model, &Mesh),
    (coordinates, elements): (&Coordinates, &Elements),
    joints: &mut Vec<Joint>,
    issues: &mut Vec<Issue>,
) {
    if !has_couplings(model) {
        return;
    }
    let mut c = Checker::default();
    let length = super::bodies::extent(model, mesh, coordinates);
    let shares = Shares::new((mesh, coordinates), elements);
    let corners = &Corners::default();
    let place = Place { model, mesh, coordinates, length, corners };
    for (i, body) in model.bodies.iter().enumerate().filter(|(_, body)| !body.distributed.is_empty()) {
        let key = format!("bodies[{i}].distributed");
        let Some(of_body) = end(&place, format!("bodies[{i}].name"), &body.name, &mut c) else { continue };
        let weights = weights(mesh, body);
        let nodes: Vec<(u32, f64)> =
            weights.into_iter().filter(|(n, _)| coordinates.position_of[*n as usize] != u32::MAX).collect();
        if let Some((message, help)) = unsuitable((mesh, coordinates), body, &nodes, length) {
            c.add(key, message, help);
            continue;
        }
        let averaged: Vec<_> =
            nodes.iter().map(|&(node, weight)| shares.node(coordinates, node, weight)).collect();
        let vectors = 4 + averaged.iter().map(|node| 1 + node.directors.len()).sum::<usize>();
        if vectors > MOST_COUPLED_VECTORS {
            c.add(
                key,
                format!(
                    "body \"{}\" follows {} nodes with {} positions and directors, and a coupling takes at most {}: it couples each \
                     node with each other one in the equations",
                    body.name,
                    nodes.len(),
                    vectors - 4,
                    MOST_COUPLED_VECTORS - 4
                ),
                "name a smaller set, as that of the nodes on an edge",
            );
            continue;
        }
        match distributing(&body.name, &of_body, &averaged, (length, joints)) {
            Some(joint) => joints.push(joint),
            None => c.add(
                key,
                format!(
                    "the {} nodes that body \"{}\" follows lie on a line along their directors, and leave its rotation about this \
                     line open",
                    nodes.len(),
                    body.name
                ),
                "add nodes beside the line to the set",
            ),
        }
    }
    issues.append(&mut c.issues);
}

/// Message and help about nodes that no coupling can have.
fn unsuitable(
    (mesh, coordinates): (&Mesh, &Coordinates),
    body: &RigidBody,
    nodes: &[(u32, f64)],
    length: f64,
) -> Option<(String, String)> {
    let name = &body.name;
    let say = |message: String, help: &str| Some((message, help.to_owned()));
    let attached_to = |node: u32| {
        let position = coordinates.position_of[node as usize];
        coordinates.bodies.iter().find(|other| other.attached.iter().any(|a| a.vector == position))
    };
    if let Some((node, other)) = nodes.iter().find_map(|(node, _)| Some((*node, attached_to(*node)?))) {
        return say(
            format!(
                "body \"{name}\" follows node {}, which is attached to body \"{}\"",
                mesh.node_label(node),
                other.name
            ),
            "take the node out of one of the sets, or connect the bodies by a joint",
        );
    }
    let place = |node: u32| mesh.positions[node as usize];
    match nodes {
        [] => say(
            format!("no node that body \"{name}\" follows belongs to an element"),
            "name a set with nodes of the shell",
        ),
        [(node, _)] => say(
            format!(
                "body \"{name}\" follows the one node {}, which does not determine its rotation about the director",
                mesh.node_label(*node)
            ),
            "name a set with several nodes, or connect a point mass or a body by a joint with type = \"spherical\"",
        ),
        [(first, _), others @ ..]
            if others.iter().all(|(node, _)| (place(*node) - place(*first)).norm() <= SAME * length) =>
        {
            say(
                format!("the {} nodes that body \"{name}\" follows all lie in one place", nodes.len()),
                "name a set with nodes in several places",
            )
        }
        _ => None,
    }
}

/// Nodes that a body follows, with their weights: those of its sets where they are given, else areas where all sets have elements, else lengths
/// where all nodes lie on edges of the sets, else 1.
fn weights(mesh: &Mesh, body: &RigidBody) -> BTreeMap<u32, f64> {
    let sets = &body.distributed;
    if !body.weights.is_empty() {
        let mut given: BTreeMap<u32, f64> = BTreeMap::new();
        for (set, weight) in sets.iter().zip(&body.weights) {
            for node in mesh.nodes_on(set).unwrap_or_default() {
                *given.entry(node).or_default() += weight;
            }
        }
        return given;
    }
    let nodes: BTreeSet<u32> = sets.iter().flat_map(|set| mesh.nodes_on(set).unwrap_or_default()).collect();
    let positive = |weights: &BTreeMap<u32, f64>| {
        nodes.iter().all(|node| weights.get(node).is_some_and(|weight| *weight > 0.0))
    };
    let mut areas: BTreeMap<u32, f64> = BTreeMap::new();
    let quads: BTreeSet<u32> = sets.iter().flat_map(|set| mesh.quads_on(set).unwrap_or_default()).collect();
    for quad in quads {
        let corners = mesh.quads[quad as usize];
        for (node, area) in corners.into_iter().zip(nodal_areas(&corners.map(|n| mesh.positions[n as usize])))
        {
            *areas.entry(node).or_default() += area;
        }
    }
    if positive(&areas) {
        return areas;
    }
    let mut lengths: BTreeMap<u32, f64> = BTreeMap::new();
    let edges = sets.iter().flat_map(|set| mesh.edges_on(set).unwrap_or_default());
    let edges: BTreeSet<[u32; 2]> = edges.map(|[a, b]| [a.min(b), a.max(b)]).collect();
    for [a, b] in edges {
        let half = 0.5 * (mesh.positions[a as usize] - mesh.positions[b as usize]).norm();
        *lengths.entry(a).or_default() += half;
        *lengths.entry(b).or_default() += half;
    }
    if positive(&lengths) { lengths } else { nodes.into_iter().map(|node| (node, 1.0)).collect() }
}

/// Properties of the nodes of the mesh that a coupling needs.
struct Shares {
    /// Directors of each node.
    directors: BTreeMap<u32, Vec<u32>>,
    /// Mean of h²/12 of the elements around each node \[length²\].
    square: BTreeMap<u32, f64>,
    /// Mass of each nodal vector, from the diagonals of the elements' mass matrices.
    mass: Vec<f64>,
}

impl Shares {
    fn new((mesh, coordinates): (&Mesh, &Coordinates), elements: &Elements) -> Self {
        let mut directors: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for (v, (kind, node)) in (0..).zip(coordinates.kinds.iter().zip(&coordinates.nodes)) {
            if *kind == VectorKind::Director && *node != u32::MAX {
                directors.entry(*node).or_default().push(v);
            }
        }
        let mut sums: BTreeMap<u32, (f64, u32)> = BTreeMap::new();
        for shell in &elements.list {
            let thickness = elements.sections[shell.section].section.thickness;
            for node in mesh.quads[shell.quad as usize] {
                let (sum, count) = sums.entry(node).or_default();
                (*sum, *count) = (*sum + thickness * thickness / 12.0, *count + 1);
            }
        }
        let square = sums.into_iter().map(|(node, (sum, count))| (node, sum / f64::from(count))).collect();
        let mut mass = vec![0.0; coordinates.len()];
        elements.groups.iter().for_each(|group| add_masses(group.as_ref(), &mut mass));
        Self { directors, square, mass }
    }

    /// Node with its weight in a coupling; several directors at a fold share the weight.
    fn node(&self, coordinates: &Coordinates, node: u32, weight: f64) -> AveragedNode {
        let at = |v: u32| Vec3::from(coordinates.reference[v as usize]);
        let position = coordinates.position_of[node as usize];
        let list = self.directors.get(&node).map_or(&[][..], Vec::as_slice);
        let share = self.square.get(&node).map_or(0.0, |square| square / larger(1.0, list.len() as f64));
        AveragedNode {
            position: (position, at(position)),
            weight,
            directors: list.iter().map(|&v| (v, at(v), share)).collect(),
            mass: self.mass[position as usize],
        }
    }
}

/// Adds the diagonals of the mass matrices of a group.
fn add_masses(group: &dyn ElementGroup, out: &mut [f64]) {
    for e in 0..group.len() {
        let mut diagonal = 0;
        for (a, &v) in group.vectors(e).iter().enumerate() {
            out[v as usize] += group.mass(e).get(diagonal).copied().unwrap_or(0.0);
            diagonal += a + 2;
        }
    }
}

/// Nodes of couplings that the supports of an analysis step hold in all directions: the first one of each body.
pub(super) fn held(
    model: &Model,
    joints: &[Joint],
    (supports, coordinates): (&[Support], &Coordinates),
    mesh: &Mesh,
) -> Vec<Issue> {
    let mut directions: BTreeMap<u32, Mat3> = BTreeMap::new();
    for support in supports {
        *directions.entry(support.vector).or_insert_with(Mat3::zeros) +=
            support.direction * support.direction.transpose();
    }
    let is_held = |v: &&u32| {
        let position = coordinates.kinds[**v as usize] == VectorKind::Position;
        position && directions.get(v).is_some_and(|sum| sum.determinant() > SPANNED)
    };
    let issue = |(i, body): (usize, &RigidBody)| {
        let joint = joints.iter().find(|joint| joint.name == body.name)?;
        let vector = *joint.vectors.iter().find(is_held)?;
        let node = mesh.node_label(coordinates.nodes[vector as usize]);
        let condition = supports.iter().find(|support| support.vector == vector)?;
        Some(Issue::new(
            format!("bodies[{i}].distributed"),
            format!(
                "body \"{}\" follows node {node}, which {} holds in all directions: the support would take its share of the forces on \
                 the body",
                body.name, condition.key
            ),
            "take the node out of one of the two sets",
        ))
    };
    let coupled = model.bodies.iter().enumerate().filter(|(_, body)| !body.distributed.is_empty());
    coupled.filter_map(issue).collect()
}
