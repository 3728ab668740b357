//! Rigid patches: nodes of the mesh that are attached to rigid bodies.

use std::collections::BTreeMap;

use crate::element::{ElementGroup, Nodal};
use crate::mesh::Mesh;
use crate::model::{Analysis, LinearSolver, Model};
use crate::norm::larger;
use crate::system::coordinates::Body;
use crate::system::supports::Support;
use crate::system::{Attached, BeamLine, Coordinates, DofMap, VectorKind};
use crate::{Issue, Mat3, Vec3};

/// Relative size of round-off in velocities and moments of inertia.
const SAME: f64 = 1e-9;

/// Whether a model of bodies can be solved by statics, or by a modal analysis.
pub(super) fn solved_at_rest(model: &Model) -> bool {
    let constrained =
        !model.joints.is_empty() || !model.ties.is_empty() || super::couplings::has_couplings(model);
    let patches_alone = !constrained && !model.has_springs() && model.beams.is_empty();
    match &model.analysis {
        Analysis::Static(s) => s.linear_solver == LinearSolver::Direct && (!s.linear || patches_alone),
        Analysis::Path(_) | Analysis::Modal(_) | Analysis::Buckling(_) => true,
        Analysis::Transient(_) => false,
    }
}

/// Attaches the nodes of the sets that bodies and beams name to them.
pub(super) fn attach(model: &Model, mesh: &Mesh, coordinates: &mut Coordinates, issues: &mut Vec<Issue>) {
    let mut body_of: BTreeMap<u32, usize> = BTreeMap::new();
    for (i, data) in model.bodies.iter().enumerate() {
        if coordinates.bodies[i].directors.is_none() {
            continue;
        }
        for (k, set) in data.attached.iter().enumerate() {
            let key = format!("bodies[{i}].attached[{k}]");
            let nodes = shell_nodes((&key, set), mesh, coordinates, issues);
            let other = nodes.into_iter().find_map(|node| take((node, i), &mut body_of));
            issues.extend(other.map(|other| on_two_bodies(&key, other, model, mesh)));
        }
    }
    for (i, beam) in model.beams.iter().enumerate().filter(|(_, beam)| !beam.attached.is_empty()) {
        let nodes_of_beam = super::beams::Nodes::of(beam, coordinates);
        for (k, set) in beam.attached.iter().enumerate() {
            let key = format!("beams[{i}].attached[{k}]");
            for node in shell_nodes((&key, set), mesh, coordinates, issues) {
                let place = mesh.positions[node as usize];
                let found = nodes_of_beam.beside(&place);
                let issue = match found {
                    Ok(body) => {
                        let other = take((node, body), &mut body_of);
                        other.map(|other| on_two_bodies(&key, other, model, mesh))
                    }
                    Err(along) => Some(Issue::new(
                        key.clone(),
                        format!(
                            "node {} lies {along:.3e} before or behind the nearest node of beam \"{}\"",
                            mesh.node_label(node),
                            beam.name
                        ),
                        "give the beam a node beside each node of the set, by `points` or as many `elements` as the line has; its axis runs along the line",
                    )),
                };
                if let Some(issue) = issue {
                    issues.push(issue);
                    break;
                }
            }
        }
    }
    let with_axes: Vec<(usize, [u32; 3])> =
        (0..).zip(&coordinates.bodies).filter_map(|(i, body)| Some((i, body.directors?))).collect();
    for (triad, (i, directors)) in (0..).zip(with_axes) {
        let nodes = body_of.iter().filter(|(_, body)| **body == i).map(|(node, _)| *node);
        let attached = nodes.flat_map(|node| of_node(node, (triad, i, &directors), coordinates)).collect();
        coordinates.bodies[i].attached = attached;
    }
}

/// Nodes of a set that belong to elements; there must be some.
fn shell_nodes(
    (key, set): (&str, &str),
    mesh: &Mesh,
    coordinates: &Coordinates,
    issues: &mut Vec<Issue>,
) -> Vec<u32> {
    let Some(mut nodes) = mesh.nodes_on(set) else { return Vec::new() };
    nodes.retain(|&node| coordinates.position_of[node as usize] != u32::MAX);
    if nodes.is_empty() {
        let message = format!("no node of the set \"{set}\" belongs to an element");
        issues.push(Issue::new(key, message, "name a set with nodes of the shell"));
    }
    nodes
}

/// Attaches a node to a body; the node with the body that has it already and this one, if that is another one.
fn take((node, body): (u32, usize), body_of: &mut BTreeMap<u32, usize>) -> Option<(u32, [usize; 2])> {
    let other = *body_of.entry(node).or_insert(body);
    (other != body).then_some((node, [other, body]))
}

fn on_two_bodies(key: &str, (node, bodies): (u32, [usize; 2]), model: &Model, mesh: &Mesh) -> Issue {
    let [first, second] = bodies.map(|body| &model.bodies[body].name);
    Issue::new(
        key,
        format!("node {} is attached to the bodies \"{first}\" and \"{second}\"", mesh.node_label(node)),
        "take the node out of one of the sets, or connect the bodies by a joint",
    )
}

/// Nodal vectors of a node, which follow each other, attached to a body.
fn of_node(
    node: u32,
    (triad, body, directors): (u32, usize, &[u32; 3]),
    coordinates: &Coordinates,
) -> Vec<Attached> {
    let at = |v: u32| Vec3::from(coordinates.reference[v as usize]);
    let axes = Mat3::from_columns(&directors.map(at));
    let centre = coordinates.bodies[body].centre;
    let first = coordinates.position_of[node as usize];
    let vectors = (first..).take_while(|&v| coordinates.nodes.get(v as usize) == Some(&node));
    let attached = |vector: u32| {
        let position = coordinates.kinds[vector as usize] == VectorKind::Position;
        let arm = if position { at(vector) - at(centre) } else { at(vector) };
        Attached { vector, triad, centre: position.then_some(centre), coordinates: axes.tr_mul(&arm) }
    };
    vectors.map(attached).collect()
}

/// Adds mass, first moments and Euler tensor of the attached part of the shell to each body.
pub(super) fn add_inertia(coordinates: &mut Coordinates, groups: &[Box<dyn ElementGroup>]) {
    let attached = coordinates.attached();
    if attached.is_empty() {
        return;
    }
    let find = |v: u32| Some(&attached[attached.binary_search_by_key(&v, |a| a.vector).ok()?]);
    let mut patches: BTreeMap<u32, (f64, Vec3, Mat3)> = BTreeMap::new();
    for group in groups {
        for e in 0..group.len() {
            let vectors = group.vectors(e);
            let pairs =
                vectors.iter().enumerate().flat_map(|(a, v)| vectors[..=a].iter().map(move |w| (*v, *w)));
            for ((v, w), &mass) in pairs.zip(group.mass(e)) {
                let (Some(a), Some(b)) = (find(v), find(w)) else { continue };
                if a.triad != b.triad {
                    continue;
                }
                let product = a.coordinates * b.coordinates.transpose() * mass;
                let (total, first, euler) =
                    patches.entry(a.triad).or_insert((0.0, Vec3::zeros(), Mat3::zeros()));
                *euler += if v == w { product } else { product + product.transpose() };
                let twice = if v == w { 1.0 } else { 2.0 };
                if a.centre.is_some() && b.centre.is_some() {
                    *total += twice * mass;
                }
                // Σ m_ab c_a Y_b over both orders of each pair, with c = 1 for positions.
                for (one, other) in [(a, b), (b, a)] {
                    if one.centre.is_some() {
                        *first += other.coordinates * (0.5 * twice * mass);
                    }
                }
            }
        }
    }
    let with_axes = coordinates.bodies.iter_mut().filter(|body| body.directors.is_some());
    for (triad, body) in (0..).zip(with_axes) {
        if let Some(patch) = patches.remove(&triad) {
            body.patch = patch;
        }
    }
}

/// Body that an attached vector belongs to.
fn body<'a>(coordinates: &'a Coordinates, attached: &Attached) -> Option<&'a Body> {
    coordinates.bodies.iter().filter(|body| body.directors.is_some()).nth(attached.triad as usize)
}

/// Supports and prescribed motions of attached nodes, which follow their bodies: the first one of each condition.
pub(super) fn supported(supports: &[Support], coordinates: &Coordinates, mesh: &Mesh) -> Vec<Issue> {
    let attached = coordinates.attached();
    let mut found: BTreeMap<&str, Issue> = BTreeMap::new();
    for support in supports {
        let Ok(at) = attached.binary_search_by_key(&support.vector, |a| a.vector) else { continue };
        let Some(body) = body(coordinates, &attached[at]) else { continue };
        found.entry(&support.key).or_insert_with(|| {
            let node = mesh.node_label(coordinates.nodes[support.vector as usize]);
            Issue::new(
                format!("{}.on", support.key),
                format!("node {node} is attached to body \"{}\", with which it moves", body.name),
                "take the node out of the set, and hold or drive the body by a joint",
            )
        });
    }
    found.into_values().collect()
}

/// Bodies whose attached nodes leave them free to spin about a director: those of a static analysis need another node, and nodes of beams are held by
/// the beam.
pub(super) fn spinning(coordinates: &Coordinates, beams: &[BeamLine]) -> Vec<Issue> {
    let spins = |body: &Body| {
        let first = body.attached.iter().find(|a| a.centre.is_some()).map(|a| a.coordinates)?;
        let arms = body.attached.iter().map(|a| {
            let arm = if a.centre.is_some() { a.coordinates - first } else { a.coordinates };
            arm.try_normalize(0.0).unwrap_or_else(Vec3::zeros)
        });
        let product: Mat3 = arms.map(|arm| arm * arm.transpose()).sum();
        let held = Mat3::identity() * product.trace() - product;
        (!(held.symmetric_eigenvalues().min() > SAME * product.trace())).then(|| body.name.clone())
    };
    let issue = |(i, body): (usize, &Body)| {
        let name = spins(body)?;
        Some(Issue::new(
            format!("bodies[{i}].attached"),
            format!("body \"{name}\" can spin about the director of the one node that is attached to it"),
            "attach another node of the shell to the body",
        ))
    };
    let of_beam = |(i, _): &(usize, &Body)| beams.iter().any(|beam| beam.bodies.contains(i));
    coordinates.bodies.iter().enumerate().filter(|body| !of_beam(body)).filter_map(issue).collect()
}

/// Sets the velocities of attached vectors at the start to those of their bodies, from which given ones must not differ.
pub(super) fn carry_velocities(
    coordinates: &Coordinates,
    dofs: &DofMap,
    mesh: &Mesh,
    velocity: &mut [Nodal],
) -> Option<Issue> {
    if velocity.is_empty() || dofs.attached.is_empty() {
        return None;
    }
    let given: Vec<Nodal> = dofs.attached.iter().map(|a| velocity[a.vector as usize]).collect();
    dofs.carry(velocity);
    let pairs = || {
        let carried = dofs.attached.iter().map(|a| Vec3::from(velocity[a.vector as usize]));
        dofs.attached.iter().zip(given.iter().map(|given| Vec3::from(*given))).zip(carried)
    };
    // Round-off is relative to the largest velocity, or rate of a director.
    let size = |of_position: bool| {
        let alike = pairs().filter(|((a, _), _)| a.centre.is_some() == of_position);
        alike.map(|((_, given), found)| larger(given.norm(), found.norm())).fold(0.0, larger)
    };
    let sizes = [size(false), size(true)];
    let mut differing = pairs().filter(|((attached, given), found)| {
        let size = sizes[usize::from(attached.centre.is_some())];
        *given != Vec3::zeros() && !((given - found).norm() <= SAME * size)
    });
    let ((attached, value), _) = differing.next()?;
    let name = body(coordinates, attached).map_or("", |body| body.name.as_str());
    Some(Issue::new(
        "initial_velocities",
        format!(
            "node {} is attached to body \"{name}\", but its velocity or the rate of its director, ({}, {}, {}), is not that of \
             the body",
            mesh.node_label(coordinates.nodes[attached.vector as usize]),
            value.x,
            value.y,
            value.z
        ),
        format!(
            "give body \"{name}\" `velocity` and `angular_velocity` of the same motion (a node of a beam has those of the beam), or move all \
             with `on = \"model\"`"
        ),
    ))
}
