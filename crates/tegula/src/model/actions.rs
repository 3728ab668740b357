//! Supports, loads, added masses and initial velocities of a model on the nodal vectors of its mesh.

use std::collections::BTreeMap;

use super::build::{Vectors, pair};
use super::{AddedMass, Condition, Load, Model, NodalVector};
use crate::element::Nodal;
use crate::element::ems::{EmsShell, ShellGeometry};
use crate::load::FollowerLoad;
use crate::mesh::Mesh;
use crate::section::SectionInertia;
use crate::system::numbering::{Support, VectorKind};
use crate::system::{DeadLoad, System};
use crate::{Issue, Vec3};

pub(super) fn supports(
    model: &Model,
    mesh: &Mesh,
    vectors: &Vectors,
    amplitudes: &BTreeMap<String, usize>,
) -> Vec<Support> {
    let directors = vectors.directors_by_node();
    let axes = [Vec3::x(), Vec3::y(), Vec3::z()];
    let mut out = Vec::new();
    for (i, condition) in model.conditions.iter().enumerate() {
        let key = format!("conditions[{i}]");
        let mut add = |node: u32, of: NodalVector, direction: Vec3, motion| {
            let position = [vectors.position_of[node as usize]];
            let list: &[u32] = match of {
                NodalVector::Position => &position,
                NodalVector::Director => directors.get(&node).map_or(&[], Vec::as_slice),
            };
            for &vector in list.iter().filter(|&&v| v != u32::MAX) {
                out.push(Support { vector, direction, motion, key: key.clone() });
            }
        };
        for node in mesh.nodes_on(condition.on()).unwrap_or_default() {
            match condition {
                Condition::Clamp(_) => {
                    for a in axes {
                        add(node, NodalVector::Position, a, None);
                        add(node, NodalVector::Director, a, None);
                    }
                }
                Condition::Hinge(_) | Condition::Spherical(_) => {
                    axes.into_iter().for_each(|a| add(node, NodalVector::Position, a, None));
                }
                Condition::Symmetry(plane) => {
                    let normal = Vec3::from(plane.normal).normalize();
                    add(node, NodalVector::Position, normal, None);
                    add(node, NodalVector::Director, normal, None);
                }
                Condition::Fix(fix) => {
                    for a in &fix.position {
                        add(node, NodalVector::Position, axes[a.index()], None);
                    }
                    for a in &fix.director {
                        add(node, NodalVector::Director, axes[a.index()], None);
                    }
                }
                Condition::Prescribe(p) => {
                    let amplitude = p.amplitude.as_ref().and_then(|a| amplitudes.get(a).copied());
                    add(node, p.of, axes[p.component.index()], Some((p.value, amplitude)));
                }
            }
        }
    }
    out
}

pub(super) fn follower_loads(
    model: &Model,
    mesh: &Mesh,
    vectors: &Vectors,
    amplitudes: &BTreeMap<String, usize>,
) -> Vec<FollowerLoad> {
    let mut out = Vec::new();
    let find = |a: &Option<String>| a.as_ref().and_then(|a| amplitudes.get(a).copied());
    for load in &model.loads {
        match load {
            Load::Moment(l) => {
                for node in mesh.nodes_on(&l.on).unwrap_or_default() {
                    let vector = vectors.director_of[node as usize];
                    out.push(FollowerLoad::Moment {
                        vector,
                        moment: Vec3::from(l.value),
                        amplitude: find(&l.amplitude),
                    });
                }
            }
            Load::EdgeMoment(l) => {
                for (node, length) in tributary_lengths(mesh, &l.on) {
                    out.push(FollowerLoad::Moment {
                        vector: vectors.director_of[node as usize],
                        moment: Vec3::from(l.value) * length,
                        amplitude: find(&l.amplitude),
                    });
                }
            }
            Load::Pressure(l) => {
                for q in mesh.quads_on(&l.on).unwrap_or_default() {
                    out.push(FollowerLoad::Pressure {
                        vectors: mesh.quads[q as usize].map(|n| vectors.position_of[n as usize]),
                        pressure: l.value,
                        amplitude: find(&l.amplitude),
                    });
                }
            }
            Load::Force(_) | Load::Edge(_) | Load::Traction(_) | Load::Gravity(_) => {}
        }
    }
    out
}

/// Moments along a director: nothing of the shell resists there, so that part would be lost.
pub(super) fn lost_moments(loads: &[FollowerLoad], vectors: &Vectors) -> Vec<Issue> {
    let lost = |load: &FollowerLoad| match load {
        FollowerLoad::Moment { vector, moment, .. } => {
            let d = Vec3::from(vectors.reference[*vector as usize]);
            let along = moment.dot(&d).abs();
            (along > 1e-3 * moment.norm()).then(|| (vectors.nodes[*vector as usize], along, moment.norm()))
        }
        FollowerLoad::Pressure { .. } => None,
    };
    let all: Vec<_> = loads.iter().filter_map(lost).collect();
    let Some((node, along, whole)) = all.first() else { return Vec::new() };
    vec![Issue::new(
        "loads",
        format!(
            "{} moment(s) have a part along the director, the first at node {node}: {along:.3e} of {whole:.3e} would be lost",
            all.len()
        ),
        "a shell node does not resist turning about its director; use a pair of forces for that part",
    )]
}

pub(super) fn dead_loads(
    model: &Model,
    mesh: &Mesh,
    system: &System,
    amplitudes: &BTreeMap<String, usize>,
) -> Vec<DeadLoad> {
    let n = system.vectors();
    let mut out = Vec::new();
    for load in &model.loads {
        let mut force = vec![[0.0; 3]; n];
        let mut add = |node: u32, f: Vec3| {
            let v = system.position_of[node as usize] as usize;
            for i in 0..3 {
                force[v][i] += f[i];
            }
        };
        let (amplitude, gravity) = match load {
            Load::Force(l) => {
                for node in mesh.nodes_on(&l.on).unwrap_or_default() {
                    add(node, Vec3::from(l.value));
                }
                (&l.amplitude, false)
            }
            Load::Edge(l) => {
                for (node, length) in tributary_lengths(mesh, &l.on) {
                    add(node, Vec3::from(l.value) * length);
                }
                (&l.amplitude, false)
            }
            Load::Traction(l) => {
                for (node, area) in tributary_areas(mesh, &l.on) {
                    add(node, Vec3::from(l.value) * area);
                }
                (&l.amplitude, false)
            }
            Load::Gravity(l) => {
                let mut field = vec![[0.0; 3]; n];
                for (v, kind) in system.kinds.iter().enumerate() {
                    if *kind == VectorKind::Position {
                        field[v] = l.value;
                    }
                }
                system.pattern.add_mass_product(1.0, &field, &mut force);
                // Gravity acts on masses; a director carries weight only where the section is not symmetric.
                (&l.amplitude, true)
            }
            Load::Moment(_) | Load::EdgeMoment(_) | Load::Pressure(_) => continue,
        };
        let amplitude = amplitude.as_ref().and_then(|a| amplitudes.get(a).copied());
        out.push(DeadLoad { force, amplitude, gravity });
    }
    out
}

pub(super) fn added_masses(model: &Model, mesh: &Mesh, vectors: &Vectors) -> Vec<(u32, u32, f64)> {
    let mut out = Vec::new();
    for mass in &model.masses {
        match mass {
            AddedMass::Point(m) => {
                for node in mesh.nodes_on(&m.on).unwrap_or_default() {
                    let v = vectors.position_of[node as usize];
                    out.push((v, v, m.value));
                }
            }
            AddedMass::Edge(m) => {
                for [a, b] in mesh.edges_on(&m.on).unwrap_or_default() {
                    let length = (mesh.positions[a as usize] - mesh.positions[b as usize]).norm();
                    let (a, b) = (vectors.position_of[a as usize], vectors.position_of[b as usize]);
                    let third = m.value * length / 3.0;
                    out.extend([(a, a, third), (b, b, third), (a, b, 0.5 * third)]);
                }
            }
            AddedMass::Area(m) => {
                for q in mesh.quads_on(&m.on).unwrap_or_default() {
                    let nodes = mesh.quads[q as usize];
                    let geometry = ShellGeometry {
                        positions: nodes.map(|n| mesh.positions[n as usize]),
                        directors: [Vec3::z(); 4],
                    };
                    let inertia = SectionInertia { mass: m.value, coupling: 0.0, rotary: 0.0 };
                    let matrix = EmsShell::default().mass(&geometry, &inertia);
                    for a in 0..4 {
                        for b in 0..=a {
                            let (va, vb) = (
                                vectors.position_of[nodes[a] as usize],
                                vectors.position_of[nodes[b] as usize],
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
    let mut out = vec![[0.0; 3]; vectors.reference.len()];
    let directors = vectors.directors_by_node();
    for initial in &model.initial_velocities {
        let (v, omega) = (Vec3::from(initial.velocity), Vec3::from(initial.angular_velocity));
        let center = Vec3::from(initial.center);
        for node in mesh.nodes_on(&initial.on).unwrap_or_default() {
            let p = vectors.position_of[node as usize];
            if p != u32::MAX {
                let x = mesh.positions[node as usize];
                out[p as usize] = (v + omega.cross(&(x - center))).into();
            }
            for &d in directors.get(&node).map_or(&[][..], Vec::as_slice) {
                out[d as usize] = omega.cross(&Vec3::from(vectors.reference[d as usize])).into();
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
        let geometry =
            ShellGeometry { positions: nodes.map(|n| mesh.positions[n as usize]), directors: [Vec3::z(); 4] };
        let matrix =
            EmsShell::default().mass(&geometry, &SectionInertia { mass: 1.0, coupling: 0.0, rotary: 0.0 });
        for a in 0..4 {
            *out.entry(nodes[a]).or_default() += (0..4).map(|b| matrix[pair(a, b)]).sum::<f64>();
        }
    }
    out
}
