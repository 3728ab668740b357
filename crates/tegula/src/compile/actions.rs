//! Supports, loads, added masses and initial velocities of a model on the nodal vectors of its mesh.

use std::collections::BTreeMap;

use super::amplitudes::amplitude_of;
use super::{StepModel, Vectors, pair};
use crate::element::Nodal;
use crate::element::geometry::{ShellGeometry, nodal_areas, shell_mass, tangents};
use crate::load::{FollowerLoad, LoadFactor};
use crate::mesh::Mesh;
use crate::model::{AddedMass, Condition, Load, Model, NodalVector, VectorLoad};
use crate::section::SectionInertia;
use crate::system::VectorKind;
use crate::system::supports::{Conflict, Support};
use crate::system::{DeadLoad, System};
use crate::{Issue, Vec3};

pub(super) fn supports(
    model: &Model,
    mesh: &Mesh,
    vectors: &Vectors,
    amplitudes: &BTreeMap<String, usize>,
    issues: &mut Vec<Issue>,
) -> Vec<Support> {
    let directors = vectors.by_node(VectorKind::Director);
    let gradients = vectors.by_node(VectorKind::Gradient);
    let axes = [Vec3::x(), Vec3::y(), Vec3::z()];
    let mut out = Vec::new();
    for (i, condition) in model.conditions.iter().enumerate() {
        let key = format!("conditions[{i}]");
        let mut oblique = None;
        let mut without_gradients = None;
        let mut on = |vectors: &[u32], direction: Vec3, motion| {
            for &vector in vectors.iter().filter(|&&v| v != u32::MAX) {
                out.push(Support { vector, direction, motion, key: key.clone() });
            }
        };
        let position = |node: u32| [vectors.coordinates.position_of[node as usize]];
        let of_node =
            |list: &'_ BTreeMap<u32, Vec<u32>>, node: u32| list.get(&node).cloned().unwrap_or_default();
        for node in mesh.nodes_on(condition.on()).unwrap_or_default() {
            match condition {
                Condition::Clamp(_) => {
                    for a in axes {
                        on(&position(node), a, None);
                        on(&of_node(&directors, node), a, None);
                        on(&of_node(&gradients, node), a, None);
                    }
                }
                Condition::Hinge(_) | Condition::Spherical(_) => {
                    axes.into_iter().for_each(|a| on(&position(node), a, None));
                }
                Condition::Symmetry(plane) => {
                    let normal = Vec3::from(plane.normal).normalize();
                    on(&position(node), normal, None);
                    on(&of_node(&directors, node), normal, None);
                    for vector in of_node(&gradients, node) {
                        let g = Vec3::from(vectors.coordinates.reference[vector as usize]);
                        let along = g.dot(&normal).abs();
                        // The mirror image of the derivative across the plane is its opposite.
                        let fixed: Vec<Vec3> = if along < 1e-6 {
                            vec![normal]
                        } else if along > 1.0 - 1e-6 {
                            tangents(&normal).into()
                        } else {
                            oblique.get_or_insert(node);
                            continue;
                        };
                        fixed.into_iter().for_each(|direction| on(&[vector], direction, None));
                    }
                }
                Condition::Fix(fix) => {
                    for a in &fix.position {
                        on(&position(node), axes[a.index()], None);
                    }
                    for a in &fix.director {
                        on(&of_node(&directors, node), axes[a.index()], None);
                    }
                }
                Condition::Prescribe(p) => {
                    let amplitude = p.amplitude.as_ref().and_then(|a| amplitudes.get(a).copied());
                    let motion = Some((p.value, amplitude));
                    match p.of {
                        NodalVector::Position => on(&position(node), axes[p.component.index()], motion),
                        NodalVector::Director => {
                            // At a fold a rotation changes each director differently: the tie moves the others.
                            let first = vectors.coordinates.director_of[node as usize];
                            on(&[first], axes[p.component.index()], motion)
                        }
                        NodalVector::FirstGradient | NodalVector::SecondGradient => {
                            let second = p.of == NodalVector::SecondGradient;
                            let list = of_node(&gradients, node);
                            if list.is_empty() {
                                without_gradients.get_or_insert(node);
                            }
                            let half: Vec<u32> =
                                list.into_iter().skip(usize::from(second)).step_by(2).collect();
                            on(&half, axes[p.component.index()], motion);
                        }
                    }
                }
            }
        }
        if let Some(node) = without_gradients {
            issues.push(Issue::new(
                format!("{key}.of"),
                format!("node {} has no gradients along the surface", mesh.node_label(node)),
                "only the nodes of `ancf-full` have them; prescribe positions and directors",
            ));
        }
        if let Some(node) = oblique {
            issues.push(Issue::new(
                format!("{key}.normal"),
                format!("the plane of symmetry lies obliquely to the gradients of ancf-full at node {node}"),
                "use a plane along the coordinate axes, or another element",
            ));
        }
    }
    out
}

/// Supports that contradict one another: an issue for each pair of conditions, with the first component and node.
pub(super) fn contradictions(conflicts: &[Conflict], vectors: &Vectors, mesh: &Mesh) -> Vec<Issue> {
    let mut pairs: BTreeMap<[String; 2], Vec<&Conflict>> = BTreeMap::new();
    for conflict in conflicts {
        pairs.entry(conflict.keys.clone()).or_default().push(conflict);
    }
    let issue = |([first, second], list): ([String; 2], Vec<&Conflict>)| {
        let here = list.first()?;
        let axis = ["x", "y", "z"].into_iter().zip(here.direction.iter()).find(|(_, c)| c.abs() > 1.0 - 1e-9);
        let component = axis.map_or_else(|| "inclined".into(), |(name, _)| name.to_owned());
        let (kind, node) = match vectors.coordinates.kinds[here.vector as usize] {
            VectorKind::Position => ("position", vectors.coordinates.nodes[here.vector as usize]),
            VectorKind::Director => ("director", vectors.coordinates.nodes[here.vector as usize]),
            VectorKind::Gradient => ("gradient", vectors.coordinates.nodes[here.vector as usize]),
        };
        if first == second {
            return Some(Issue::new(
                second,
                format!(
                    "it prescribes only some components of the inextensible director of node {} (`mitc4`)",
                    mesh.node_label(node)
                ),
                "prescribe all three components of the director, or use another element",
            ));
        }
        let more = match list.len() {
            1 => String::new(),
            n => format!(", and {} more component(s)", n - 1),
        };
        Some(Issue::new(
            second,
            format!(
                "it prescribes the {component} component of the {kind} of node {}, which {first} supports differently{more}",
                mesh.node_label(node)
            ),
            "take the shared nodes out of one of the two sets, or drop one condition",
        ))
    };
    pairs.into_iter().filter_map(issue).collect()
}

/// Follower loads, each with the number of its load of the model.
pub(super) fn follower_loads(
    step: &StepModel,
    mesh: &Mesh,
    vectors: &Vectors,
    amplitudes: &BTreeMap<String, usize>,
) -> (Vec<FollowerLoad>, Vec<usize>) {
    let (mut out, mut load_of) = (Vec::new(), Vec::new());
    for (number, (load, continued)) in step.model.loads.iter().zip(&step.loads).enumerate() {
        let amplitude = amplitude_of(load).as_ref().and_then(|a| amplitudes.get(a).copied());
        let factor = continued.factor(amplitude);
        match load {
            Load::Moment(l) => {
                for node in mesh.nodes_on(&l.on).unwrap_or_default() {
                    let vector = vectors.coordinates.director_of[node as usize];
                    out.push(FollowerLoad::Moment { vector, moment: Vec3::from(l.value), factor });
                }
            }
            Load::EdgeMoment(l) => {
                out.extend(edge_moments(l, factor, mesh, vectors));
            }
            Load::Pressure(l) => {
                for q in mesh.quads_on(&l.on).unwrap_or_default() {
                    out.push(FollowerLoad::Pressure {
                        vectors: mesh.quads[q as usize].map(|n| vectors.coordinates.position_of[n as usize]),
                        pressure: l.value,
                        factor,
                    });
                }
            }
            Load::Force(_) | Load::Edge(_) | Load::Traction(_) | Load::Gravity(_) => {}
        }
        load_of.resize(out.len(), number);
    }
    (out, load_of)
}

/// Moments at both ends of each edge, with half of its length.
fn edge_moments(load: &VectorLoad, factor: LoadFactor, mesh: &Mesh, vectors: &Vectors) -> Vec<FollowerLoad> {
    let directors = vectors.by_node(VectorKind::Director);
    let at = |v: u32| Vec3::from(vectors.coordinates.reference[v as usize]);
    let mut out = Vec::new();
    for [a, b] in mesh.edges_on(&load.on).unwrap_or_default() {
        let [first, second] = [a, b].map(|n| vectors.coordinates.position_of[n as usize]);
        let edge = at(second) - at(first);
        for node in [a, b] {
            // The first director of the node, unless at a fold another one stands more across the edge.
            let across = |v: &u32| at(*v).cross(&edge).norm() / (at(*v).norm() * edge.norm());
            let list = directors.get(&node).map_or(&[][..], Vec::as_slice);
            let best = list.iter().map(across).fold(0.0, f64::max);
            if let Some(&director) = list.iter().find(|v| across(v) >= 0.9 * best) {
                out.push(FollowerLoad::EdgeMoment {
                    vectors: [first, second, director],
                    moment: Vec3::from(load.value) * (0.5 * edge.norm()),
                    factor,
                });
            }
        }
    }
    out
}

/// Moments with a drilling component, for which a node has no stiffness, so that it would be dropped.
///
/// `numbers` gives the load of the model that each belongs to.
pub(super) fn drilling_components(
    loads: &[FollowerLoad],
    numbers: &[usize],
    vectors: &Vectors,
    mesh: &Mesh,
) -> Vec<Issue> {
    let lost = |(load, number): (&FollowerLoad, &usize)| match load {
        FollowerLoad::Moment { vector, moment, .. } => {
            let d = Vec3::from(vectors.coordinates.reference[*vector as usize]);
            let along = moment.dot(&d).abs();
            (along > 1e-3 * moment.norm())
                .then(|| (vectors.coordinates.nodes[*vector as usize], along, moment.norm(), *number))
        }
        FollowerLoad::Pressure { .. } | FollowerLoad::EdgeMoment { .. } | FollowerLoad::Own { .. } => None,
    };
    let all: Vec<_> = loads.iter().zip(numbers).filter_map(lost).collect();
    let Some((node, along, whole, number)) = all.first() else { return Vec::new() };
    vec![Issue::new(
        format!("loads[{number}].value"),
        format!(
            "{} moment(s) have a drilling component (along the director), the first at node {}: {along:.3e} of {whole:.3e} would be dropped",
            all.len(),
            mesh.node_label(*node)
        ),
        "a shell node has no drilling stiffness; use an `edge-moment`, or a couple of forces for that component",
    )]
}

/// Loads of constant direction, and the number of the load of the model that each belongs to.
pub(super) fn dead_loads(
    step: &StepModel,
    mesh: &Mesh,
    system: &System,
    amplitudes: &BTreeMap<String, usize>,
) -> (Vec<DeadLoad>, Vec<usize>) {
    let n = system.vectors();
    let (mut out, mut load_of) = (Vec::new(), Vec::new());
    for (number, (load, continued)) in step.model.loads.iter().zip(&step.loads).enumerate() {
        let mut force = vec![[0.0; 3]; n];
        let mut add = |node: u32, f: Vec3| {
            let v = system.coordinates.position_of[node as usize] as usize;
            for i in 0..3 {
                force[v][i] += f[i];
            }
        };
        let gravity = match load {
            Load::Force(l) => {
                for node in mesh.nodes_on(&l.on).unwrap_or_default() {
                    add(node, Vec3::from(l.value));
                }
                false
            }
            Load::Edge(l) => {
                for (node, length) in tributary_lengths(mesh, &l.on) {
                    add(node, Vec3::from(l.value) * length);
                }
                false
            }
            Load::Traction(l) => {
                for (node, area) in tributary_areas(mesh, &l.on) {
                    add(node, Vec3::from(l.value) * area);
                }
                false
            }
            Load::Gravity(l) => {
                let mut field = vec![[0.0; 3]; n];
                for (v, kind) in system.coordinates.kinds.iter().enumerate() {
                    if *kind == VectorKind::Position {
                        field[v] = l.value;
                    }
                }
                system.pattern.add_mass_product(1.0, &field, &mut force);
                // Gravity acts on masses; a director carries weight only where the section is not symmetric.
                true
            }
            Load::Moment(_) | Load::EdgeMoment(_) | Load::Pressure(_) => continue,
        };
        let amplitude = amplitude_of(load).as_ref().and_then(|a| amplitudes.get(a).copied());
        out.push(DeadLoad { force, factor: continued.factor(amplitude), gravity });
        load_of.push(number);
    }
    (out, load_of)
}

pub(super) fn added_masses(model: &Model, mesh: &Mesh, vectors: &Vectors) -> Vec<(u32, u32, f64)> {
    let mut out = Vec::new();
    for mass in &model.masses {
        match mass {
            AddedMass::Point(m) => {
                for node in mesh.nodes_on(&m.on).unwrap_or_default() {
                    let v = vectors.coordinates.position_of[node as usize];
                    out.push((v, v, m.value));
                }
            }
            AddedMass::Edge(m) => {
                for [a, b] in mesh.edges_on(&m.on).unwrap_or_default() {
                    let length = (mesh.positions[a as usize] - mesh.positions[b as usize]).norm();
                    let (a, b) = (
                        vectors.coordinates.position_of[a as usize],
                        vectors.coordinates.position_of[b as usize],
                    );
                    let third = m.value * length / 3.0;
                    out.extend([(a, a, third), (b, b, third), (a, b, 0.5 * third)]);
                }
            }
            AddedMass::Area(m) => {
                for q in mesh.quads_on(&m.on).unwrap_or_default() {
                    let nodes = mesh.quads[q as usize];
                    let geometry =
                        ShellGeometry::new(nodes.map(|n| mesh.positions[n as usize]), [Vec3::z(); 4]);
                    let inertia = SectionInertia { mass: m.value, rotary: 0.0, coupling: 0.0 };
                    let matrix = shell_mass(&geometry, &inertia);
                    for a in 0..4 {
                        for b in 0..=a {
                            let (va, vb) = (
                                vectors.coordinates.position_of[nodes[a] as usize],
                                vectors.coordinates.position_of[nodes[b] as usize],
                            );
                            out.push((va, vb, matrix[pair(a, b)]));
                        }
                    }
                }
            }
        }
    }
    out
}

pub(super) fn initial_velocity(model: &Model, mesh: &Mesh, vectors: &Vectors) -> Vec<Nodal> {
    if model.initial_velocities.is_empty() {
        return Vec::new();
    }
    let mut out = vec![[0.0; 3]; vectors.coordinates.reference.len()];
    let directors = vectors.by_node(VectorKind::Director);
    let gradients = vectors.by_node(VectorKind::Gradient);
    for initial in &model.initial_velocities {
        let (v, omega) = (Vec3::from(initial.velocity), Vec3::from(initial.angular_velocity));
        let center = Vec3::from(initial.center);
        for node in mesh.nodes_on(&initial.on).unwrap_or_default() {
            let p = vectors.coordinates.position_of[node as usize];
            if p != u32::MAX {
                let x = mesh.positions[node as usize];
                out[p as usize] = (v + omega.cross(&(x - center))).into();
            }
            for &d in [&directors, &gradients].into_iter().filter_map(|l| l.get(&node)).flatten() {
                out[d as usize] = omega.cross(&Vec3::from(vectors.coordinates.reference[d as usize])).into();
            }
        }
    }
    out
}

/// Length of an edge set that each of its nodes stands for (consistent with linear edges).
fn tributary_lengths(mesh: &Mesh, on: &str) -> BTreeMap<u32, f64> {
    let mut out = BTreeMap::new();
    for [a, b] in mesh.edges_on(on).unwrap_or_default() {
        let half = 0.5 * (mesh.positions[a as usize] - mesh.positions[b as usize]).norm();
        *out.entry(a).or_default() += half;
        *out.entry(b).or_default() += half;
    }
    out
}

/// Area ∫N_a dA that each node of a quad set stands for.
fn tributary_areas(mesh: &Mesh, on: &str) -> BTreeMap<u32, f64> {
    let mut out = BTreeMap::new();
    for q in mesh.quads_on(on).unwrap_or_default() {
        let nodes = mesh.quads[q as usize];
        for (node, area) in nodes.into_iter().zip(nodal_areas(&nodes.map(|n| mesh.positions[n as usize]))) {
            *out.entry(node).or_default() += area;
        }
    }
    out
}
