//! Ties of non-matching meshes.

use std::collections::BTreeSet;

use super::inner_point::Corners;
use crate::checker::Checker;
use crate::constraint::Joint;
use crate::constraint::joint::{MOST_COUPLED_VECTORS, Role};
use crate::mesh::Mesh;
use crate::model::{Model, Tie};
use crate::system::{Coordinates, VectorKind};
use crate::{Issue, Vec3};

/// Names of ties, whose forces have columns as those of joints.
pub(super) fn keys(model: &Model, c: &mut Checker) {
    for (i, tie) in model.ties.iter().enumerate() {
        let joints = model.joints.iter().map(|joint| joint.common().name());
        let others = joints.chain(model.ties[..i].iter().map(|other| other.name.as_str()));
        let bodies =
            model.bodies.iter().filter(|body| !body.distributed.is_empty()).map(|body| body.name.as_str());
        if others.chain(bodies).any(|name| name == tie.name) {
            c.add(
                format!("ties[{i}].name"),
                format!("\"{}\" is the name of another tie, joint or coupling", tie.name),
                "give the tie a name of its own",
            );
        }
        c.file_name(&format!("ties[{i}].name"), &tie.name, super::bodies::LONGEST_NAME);
    }
}

/// Mistakes in the sets of ties.
pub(super) fn sets(model: &Model, mesh: &Mesh, c: &mut Checker) {
    for (i, tie) in model.ties.iter().enumerate() {
        c.set(mesh, format!("ties[{i}].on"), &tie.on, "nodes", Mesh::nodes_on);
        c.set(mesh, format!("ties[{i}].to"), &tie.to, "quads", Mesh::quads_on);
    }
}

/// Adds the ties to the joints, or what is wrong with their nodes.
pub(super) fn add(
    model: &Model,
    (mesh, corners): (&Mesh, &Corners),
    (coordinates, length): (&Coordinates, f64),
    joints: &mut Vec<Joint>,
    issues: &mut Vec<Issue>,
) {
    for (i, tie) in model.ties.iter().enumerate() {
        match tied(tie, (mesh, corners), (coordinates, length), joints) {
            Ok(joint) => joints.push(joint),
            Err((key, message, help)) => issues.push(Issue::new(format!("ties[{i}].{key}"), message, help)),
        }
    }
}

/// Key, message and help of a mistake.
type Mistake = (&'static str, String, String);

fn tied(
    tie: &Tie,
    (mesh, corners): (&Mesh, &Corners),
    (coordinates, length): (&Coordinates, f64),
    others: &[Joint],
) -> Result<Joint, Mistake> {
    let nodes: BTreeSet<u32> = mesh.nodes_on(&tie.on).unwrap_or_default().into_iter().collect();
    let quads = mesh.quads_on(&tie.to).unwrap_or_default();
    let reference = |v: u32| Vec3::from(coordinates.reference[v as usize]);
    let (mut vectors, mut rows) = (Vec::new(), Vec::new());
    let mut followers = BTreeSet::new();
    for &node in &nodes {
        let label = mesh.node_label(node);
        let (position, director) = follower(tie, node, (mesh, &quads), coordinates)?;
        let director = director.map(|d| (d, reference(d)));
        let followed =
            corners.point(&quads, &reference(position), (reference, length)).map_err(|(message, _)| {
                let help = "tie nodes that lie in or on the elements, within their thickness";
                ("on", format!("node {label} cannot follow \"{}\": {message}", tie.to), help.to_owned())
            })?;
        followers.extend([Some(position), director.map(|d| d.0)].into_iter().flatten());
        let of_node = followed.rows(position, director, (&mut vectors, length));
        rows.extend(of_node.ok_or_else(|| {
            ("to", format!("the element at node {label} has no area"), "repair the mesh".into())
        })?);
    }
    if vectors.len() > MOST_COUPLED_VECTORS {
        return Err((
            "on",
            format!(
                "the tie \"{}\" couples {} positions and directors, and takes at most {MOST_COUPLED_VECTORS}",
                tie.name,
                vectors.len()
            ),
            "divide the set into several ties".into(),
        ));
    }
    let of_first = vectors.iter().map(|v| !followers.contains(v)).collect();
    let (number, first) = (others.len(), others.last().map_or(0, |last| last.multipliers().end));
    let centre = nodes.iter().map(|n| mesh.positions[*n as usize]).sum::<Vec3>() / nodes.len().max(1) as f64;
    let nearest = nodes.iter().min_by(|a, b| {
        let distance = |n: u32| (mesh.positions[n as usize] - centre).norm();
        distance(**a).total_cmp(&distance(**b))
    });
    let point = nearest.map(|n| crate::constraint::Attachment::vector(coordinates.position_of[*n as usize]));
    Ok(Joint {
        name: tie.name.clone(),
        vectors,
        of_first,
        point: point.unwrap_or_default(),
        axes: None,
        rows,
        first,
        number,
        drive: None,
        role: Role::Acting,
        engages: false,
        law: None,
        counted: None,
    })
}

/// Position of a node that follows elements, and its director where rotations follow, too.
fn follower(
    tie: &Tie,
    node: u32,
    (mesh, quads): (&Mesh, &[u32]),
    coordinates: &Coordinates,
) -> Result<(u32, Option<u32>), Mistake> {
    let label = mesh.node_label(node);
    let position = coordinates.position_of[node as usize];
    if let Some(quad) = quads.iter().find(|quad| mesh.quads[**quad as usize].contains(&node)) {
        return Err((
            "on",
            format!(
                "node {label} belongs to element {} of the set \"{}\", which it would have to follow",
                mesh.quad_label(*quad as usize),
                tie.to
            ),
            "give disjoint parts of the mesh to `on` and `to`".into(),
        ));
    }
    if position == u32::MAX {
        return Err(("on", format!("node {label} belongs to no element"), "take it out of the set".into()));
    }
    let directors: Vec<u32> = (position..coordinates.len() as u32)
        .take_while(|v| coordinates.nodes[*v as usize] == node)
        .filter(|v| coordinates.kinds[*v as usize] == VectorKind::Director)
        .collect();
    match directors[..] {
        _ if !tie.rotations => Ok((position, None)),
        [director] => Ok((position, Some(director))),
        _ => Err((
            "on",
            format!("node {label} lies on a fold and has {} directors", directors.len()),
            "say `rotations = false`, or take the node out of the set".into(),
        )),
    }
}
