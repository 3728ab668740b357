//! Cuts: from the model to the element forces that make up their resultants.

use std::collections::BTreeSet;

use super::sections::Elements;
use crate::Issue;
use crate::checker::Checker;
use crate::element::ElementGroup;
use crate::mesh::Mesh;
use crate::model::{self, Analysis, Model};
use crate::system::{Attached, BeamLine, Coordinates, Cut, GroupOffsets, Shell, System};

/// Longest name of a cut (characters).
const LONGEST_NAME: usize = 60;

/// Mistakes in the values of cuts, and cuts of analyses without forces.
pub(super) fn keys(model: &Model) -> Vec<Issue> {
    let mut c = Checker::default();
    let modal = |analysis: &Analysis| matches!(analysis, Analysis::Modal(_) | Analysis::Buckling(_));
    let modal_alone = match model.steps.as_slice() {
        [] => modal(&model.analysis),
        steps => steps.iter().all(|step| modal(&step.analysis)),
    };
    if modal_alone && !model.output.cuts.is_empty() {
        c.add(
            "output.cuts",
            "a modal analysis has no section forces: modes have any amplitude",
            "leave the cuts out, or add a static or transient analysis",
        );
    }
    for (i, cut) in model.output.cuts.iter().enumerate() {
        let key = format!("output.cuts[{i}]");
        let fits = c.file_name(&format!("{key}.name"), &cut.name, LONGEST_NAME);
        if fits && model.output.cuts[..i].iter().any(|other| other.name == cut.name) {
            let message = format!("two cuts are named \"{}\"", cut.name);
            c.add(format!("{key}.name"), message, "give each cut its own name");
        }
        let column = format!("cut.{}", cut.name);
        if model.output.points.iter().any(|point| point.name == column) {
            let message = format!(
                "the columns of the cut \"{}\" and of the point \"{column}\" have the same names",
                cut.name
            );
            c.add(format!("{key}.name"), message, "give the point another name");
        }
        cut.about.iter().for_each(|x| c.finite(&format!("{key}.about"), "the point", x));
    }
    c.issues
}

/// Sets of cuts that the mesh does not have.
pub(super) fn sets(model: &Model, mesh: &Mesh, c: &mut Checker) {
    for (i, cut) in model.output.cuts.iter().enumerate() {
        let lines = |mesh: &Mesh, name: &str| {
            let known = mesh.node_sets.contains_key(name) || mesh.edge_sets.contains_key(name);
            known.then(|| mesh.nodes_on(name)).flatten()
        };
        c.set(mesh, format!("output.cuts[{i}].on"), &cut.on, "nodes or edges", lines);
        c.set(mesh, format!("output.cuts[{i}].of"), &cut.of, "elements", Mesh::quads_on);
    }
}

/// Cuts of the model, or what is wrong with their lines.
pub(super) fn cuts(
    (model, mesh): (&Model, &Mesh),
    coordinates: &Coordinates,
    (elements, offsets): (&Elements, &[GroupOffsets]),
    issues: &mut Vec<Issue>,
) -> Vec<Cut> {
    let mut c = Checker::default();
    let cuts = model.output.cuts.iter().enumerate();
    let compiled = |(i, data): (usize, &model::Cut)| {
        let line = Line::new(data, mesh);
        let (key, name) = (format!("output.cuts[{i}]"), &data.name);
        let parts = || elements.list.iter().filter(|shell| line.touches(mesh, shell));
        if parts().next().is_none() {
            c.add(
                format!("{key}.of"),
                format!(
                    "no element of the set \"{}\" has a node on the line \"{}\" of the cut \"{name}\"",
                    data.of, data.on
                ),
                "name the set of the elements on one side of the line",
            );
            return None;
        }
        if let Some(shell) = parts().find(|shell| line.holds(mesh, shell)) {
            c.add(
                format!("{key}.on"),
                format!(
                    "the set \"{}\" holds all nodes of element {}: it is no line that cuts the set \"{}\"",
                    data.on,
                    mesh.quad_label(shell.quad as usize),
                    data.of
                ),
                "name a set of the nodes along one line of the mesh",
            );
            return None;
        }
        let rigid = parts().find_map(|shell| Some((shell, rigid(coordinates, mesh, shell)?)));
        if let Some((shell, body)) = rigid {
            c.add(
                format!("{key}.of"),
                format!(
                    "element {} at the cut \"{name}\" is a part of the body \"{body}\", and a rigid element has no stress",
                    mesh.quad_label(shell.quad as usize)
                ),
                "name the set of the elements on the other side of the line, or move the line off the attached nodes",
            );
            return None;
        }
        let position = |n: &u32| coordinates.position_of.get(*n as usize).copied();
        Some(Cut {
            name: name.clone(),
            about: data.about.map(Into::into),
            positions: line.nodes.iter().filter_map(position).filter(|&v| v != u32::MAX).collect(),
            forces: parts().flat_map(|shell| line.forces(shell, coordinates, (elements, offsets))).collect(),
        })
    };
    let out = cuts.filter_map(compiled).collect();
    issues.append(&mut c.issues);
    out
}

/// Nodes and elements of a cut.
struct Line {
    /// Nodes of the line.
    nodes: BTreeSet<u32>,
    /// Quads on one side.
    quads: BTreeSet<u32>,
}

impl Line {
    fn new(cut: &model::Cut, mesh: &Mesh) -> Self {
        Self {
            nodes: mesh.nodes_on(&cut.on).unwrap_or_default().into_iter().collect(),
            quads: mesh.quads_on(&cut.of).unwrap_or_default().into_iter().collect(),
        }
    }

    /// Whether a shell belongs to the part of the cut and has a node on the line.
    fn touches(&self, mesh: &Mesh, shell: &Shell) -> bool {
        self.quads.contains(&shell.quad) && corners(mesh, shell).iter().any(|n| self.nodes.contains(n))
    }

    /// Whether all nodes of a shell are on the line.
    fn holds(&self, mesh: &Mesh, shell: &Shell) -> bool {
        corners(mesh, shell).iter().all(|n| self.nodes.contains(n))
    }

    /// Places and nodal vectors of the forces of a shell at the nodes of the line.
    fn forces(
        &self,
        shell: &Shell,
        coordinates: &Coordinates,
        (elements, offsets): (&Elements, &[GroupOffsets]),
    ) -> Vec<(u32, u32)> {
        let of_group = |g: usize| {
            let group: &dyn ElementGroup = elements.groups[g].as_ref();
            let first = offsets[g].forces.start / 3 + shell.member * group.vectors_per_element();
            let vectors = group.vectors(shell.member).iter().copied();
            (first as u32..).zip(vectors)
        };
        let on_line = |(_, v): &(u32, u32)| self.nodes.contains(&coordinates.nodes[*v as usize]);
        shell.groups.clone().flat_map(of_group).filter(on_line).collect()
    }
}

fn corners<'a>(mesh: &'a Mesh, shell: &Shell) -> &'a [u32; 4] {
    &mesh.quads[shell.quad as usize]
}

/// Body to which all nodes of a shell are attached.
fn rigid<'a>(coordinates: &'a Coordinates, mesh: &Mesh, shell: &Shell) -> Option<&'a str> {
    let holds = |attached: &[crate::system::Attached], node: &u32| {
        let position = coordinates.position_of[*node as usize];
        attached.binary_search_by_key(&position, |a| a.vector).is_ok()
    };
    let body = coordinates
        .bodies
        .iter()
        .find(|body| corners(mesh, shell).iter().all(|n| holds(&body.attached, n)))?;
    Some(&body.name)
}

/// Warning of cuts that a beam passes with the nodes that it carries.
pub(super) fn beside_beams(model: &Model, mesh: &Mesh, system: &System) -> Vec<Issue> {
    let mut found = Vec::new();
    for (i, data) in model.output.cuts.iter().enumerate() {
        let line = Line::new(data, mesh);
        let on_line = |attached: &Attached| {
            system
                .coordinates
                .nodes
                .get(attached.vector as usize)
                .is_some_and(|node| line.nodes.contains(node))
        };
        let passes = |beam: &&BeamLine| {
            system.coordinates.bodies[beam.bodies.clone()]
                .iter()
                .any(|body| body.attached.iter().any(on_line))
        };
        let Some(beam) = system.beams.iter().find(passes) else { continue };
        found.push(Issue::new(
            format!("output.cuts[{i}].on"),
            format!(
                "beam \"{}\" passes the line of the cut \"{}\", whose force and moment are those of the shell alone",
                beam.name, data.name
            ),
            format!("add the resultants of the beam, the columns `beam.{}…` of nodes in its `history`", beam.name),
        ));
    }
    found
}

/// Warning of cuts at which nothing is connected to the elements.
pub(super) fn idle(model: &Model, mesh: &Mesh, system: &System) -> Vec<Issue> {
    let shells: BTreeSet<usize> = system.shells.iter().flat_map(|shell| shell.groups.clone()).collect();
    let warn = |(i, data): (usize, &model::Cut)| {
        let line = Line::new(data, mesh);
        let beyond = |shell: &Shell| {
            !line.quads.contains(&shell.quad) && corners(mesh, shell).iter().any(|n| line.nodes.contains(n))
        };
        let on_line =
            |v: &u32| system.coordinates.nodes.get(*v as usize).is_some_and(|node| line.nodes.contains(node));
        let connected = system.shells.iter().any(beyond)
            || system.supports.iter().any(|support| on_line(&support.vector))
            || system.dofs().attached.iter().any(|attached| on_line(&attached.vector))
            || system
                .numbered_groups()
                .filter(|(g, ..)| !shells.contains(g))
                .any(|(_, group, _)| (0..group.len()).any(|e| group.vectors(e).iter().any(on_line)));
        (!connected).then(|| {
            Issue::new(
                format!("output.cuts[{i}].of"),
                format!(
                    "all elements at the line \"{}\" of the cut \"{}\" belong to the set \"{}\", and nothing else is connected there: its \
                     force is that of loads and inertia at the line alone",
                    data.on, data.name, data.of
                ),
                "name the set of the elements on one side of the line",
            )
        })
    };
    model.output.cuts.iter().enumerate().filter_map(warn).collect()
}
