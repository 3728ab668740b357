//! Supports, loads, added masses and initial velocities of a model on the nodal vectors of its mesh.

use std::collections::{BTreeMap, HashMap};

use super::adaptive_integrals::Integral;
use super::factors::Factors;
use super::turning_nodes::TurningNodes;
use super::{StepModel, Vectors};
use crate::element::Nodal;
use crate::element::geometry::{ShellGeometry, nodal_areas, shell_mass, tangents};
use crate::load::{FollowerLoad, LoadFactor, OwnLoad};
use crate::mesh::Mesh;
use crate::model::loads::{Action, LoadedMesh};
use crate::model::supports::{Constraints, Direction, SupportedNode};
use crate::model::{AddedMass, Condition, InitialVelocity, Load, Model};
use crate::section::SectionInertia;
use crate::system::coordinates::Body;
use crate::system::dof_map::DofMap;
use crate::system::supports::{Conflict, Support};
use crate::system::{Coordinates, DeadLoad, System, VectorKind};
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
    let mut out = Vec::new();
    for (i, condition) in model.conditions.iter().enumerate() {
        let key = format!("conditions[{i}]");
        let amplitude = condition.motion().and_then(|m| amplitudes.get(m.amplitude.as_ref()?).copied());
        let mut refusal = None;
        for node in mesh.nodes_on(condition.on()).unwrap_or_default() {
            let position = vectors.coordinates.position_of[node as usize];
            let found = constraints(
                condition,
                &SupportedNode {
                    position: if position == u32::MAX { &[] } else { std::slice::from_ref(&position) },
                    directors: directors.get(&node).map_or(&[], Vec::as_slice),
                    gradients: gradients.get(&node).map_or(&[], Vec::as_slice),
                    reference: &vectors.coordinates.reference,
                },
            );
            for (vector, direction, change) in found.list {
                let motion = change.map(|change| (change, amplitude));
                let one = |direction| Support { vector, direction, motion, key: key.clone() };
                match direction {
                    Direction::Along(direction) => out.push(one(direction)),
                    Direction::Across(normal) => out.extend(tangents(&normal).map(one)),
                }
            }
            refusal = refusal.or(found.refusal.map(|r| (r, node)));
        }
        if let Some(((last, message, help), node)) = refusal {
            let message = format!("{message} at node {}", mesh.node_label(node));
            issues.push(Issue::new(format!("{key}.{last}"), message, help));
        }
    }
    out
}

/// Constraints of a condition at a node.
fn constraints(condition: &Condition, node: &SupportedNode) -> Constraints {
    let mut out = Constraints::default();
    condition.constrain(node, &mut out);
    out
}

/// Supports of a step that contradict one another: an issue for each pair of conditions, with the first component and node.
pub(super) fn contradictions(
    step: &StepModel,
    conflicts: &[Conflict],
    vectors: &Vectors,
    mesh: &Mesh,
) -> Vec<Issue> {
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
                "it prescribes the {component} component of the {kind} of node {}, which {} supports differently{more}",
                mesh.node_label(node),
                step.key(&first)
            ),
            "take the shared nodes out of one of the two sets, or drop one condition",
        ))
    };
    pairs.into_iter().filter_map(issue).collect()
}

/// Follower loads, each with the number of its load of the model. A moment on a node that is attached to a body acts on the body, which takes
/// all its components.
pub(super) fn follower_loads(
    step: &StepModel,
    mesh: &Mesh,
    (vectors, dofs): (&Vectors, &DofMap),
    amplitudes: &BTreeMap<String, usize>,
) -> (Vec<FollowerLoad>, Vec<usize>) {
    let (mut out, mut load_of) = (Vec::new(), Vec::new());
    for (number, (load, continued)) in step.model.loads.iter().zip(&step.loads).enumerate() {
        let loaded = Loaded::new(load, mesh, &vectors.coordinates);
        let turning = TurningNodes::new(&loaded, (vectors, dofs));
        let amplitude = load.amplitude().as_ref().and_then(|a| amplitudes.get(a).copied());
        let factor = continued.factor(amplitude);
        for action in load.actions(&loaded) {
            match action {
                Action::Moment { node, moment } if loaded.body(node).is_some() => {
                    let directors = loaded.body(node).and_then(|body| body.directors);
                    out.extend(directors.map(|directors| FollowerLoad::BodyMoment {
                        directors,
                        moment,
                        factor,
                    }));
                }
                Action::Moment { node, moment } => {
                    let vector = vectors.coordinates.director_of[node as usize];
                    out.push(match dofs.carried(vector as usize) {
                        Some(attached) => {
                            let directors = dofs.triads[attached.triad as usize];
                            FollowerLoad::BodyMoment { directors, moment, factor }
                        }
                        None => FollowerLoad::Moment { vector, moment, factor },
                    });
                }
                Action::EdgeMoment { set, moment } => {
                    out.extend(edge_moments((&set, moment), factor, &loaded, vectors));
                }
                Action::Pressure { quad, pressure } => {
                    let vectors = quad.map(|n| vectors.coordinates.position_of[n as usize]);
                    out.push(FollowerLoad::Pressure { vectors, pressure, factor });
                }
                Action::FollowerForce { node, force } => {
                    let loads = turning.force(node, force).into_iter();
                    out.extend(loads.map(|load| FollowerLoad::Own { load, factor }));
                }
                Action::FollowerMoment { node, moment } => {
                    let loads = turning.moment(node, moment).into_iter();
                    out.extend(loads.map(|load| FollowerLoad::Own { load, factor }));
                }
                Action::Follower(load) => out.push(FollowerLoad::Own { load: OwnLoad(load), factor }),
                Action::Force { .. } | Action::Gravity(_) | Action::Centrifugal { .. } => {}
            }
        }
        load_of.resize(out.len(), number);
    }
    (out, load_of)
}

/// Moments at both ends of each edge, with the length that they stand for.
fn edge_moments(
    (set, moment): (&str, Vec3),
    factor: LoadFactor,
    loaded: &Loaded,
    vectors: &Vectors,
) -> Vec<FollowerLoad> {
    let directors = vectors.by_node(VectorKind::Director);
    let at = |v: u32| Vec3::from(vectors.coordinates.reference[v as usize]);
    let mut out = Vec::new();
    let edges = loaded.mesh.edges_on(set).unwrap_or_default();
    let lengths = loaded.shares(&edges);
    for ([a, b], lengths) in edges.into_iter().zip(lengths) {
        let [first, second] = [a, b].map(|n| vectors.coordinates.position_of[n as usize]);
        let edge = at(second) - at(first);
        for (node, length) in [a, b].into_iter().zip(lengths) {
            // The first director of the node, unless at a fold another one stands more across the edge.
            let across = |v: &u32| at(*v).cross(&edge).norm() / (at(*v).norm() * edge.norm());
            let list = directors.get(&node).map_or(&[][..], Vec::as_slice);
            let best = list.iter().map(across).fold(0.0, crate::norm::larger);
            if let Some(&director) = list.iter().find(|v| across(v) >= 0.9 * best) {
                out.push(FollowerLoad::EdgeMoment {
                    vectors: [first, second, director],
                    moment: moment * length,
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
        FollowerLoad::Pressure { .. }
        | FollowerLoad::EdgeMoment { .. }
        | FollowerLoad::BodyMoment { .. }
        | FollowerLoad::Own { .. }
        | FollowerLoad::Field { .. } => None,
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
        let loaded = Loaded::new(load, mesh, &system.coordinates);
        let mut force = vec![[0.0; 3]; n];
        let (mut acts, mut gravity) = (false, false);
        for action in load.actions(&loaded) {
            match action {
                Action::Force { node, force: f } => {
                    acts = true;
                    let v = loaded.vectors(node)[0] as usize;
                    for i in 0..3 {
                        force[v][i] += f[i];
                    }
                }
                Action::Gravity(acceleration) => {
                    (acts, gravity) = (true, true);
                    let mut field = vec![[0.0; 3]; n];
                    for (v, kind) in system.coordinates.kinds.iter().enumerate() {
                        if *kind == VectorKind::Position {
                            field[v] = acceleration.into();
                        }
                    }
                    // Gravity acts on masses; a director carries weight only where the section is not symmetric.
                    system.pattern.add_mass_product(1.0, &field, &mut force);
                }
                Action::Moment { .. }
                | Action::EdgeMoment { .. }
                | Action::Pressure { .. }
                | Action::Centrifugal { .. }
                | Action::FollowerForce { .. }
                | Action::FollowerMoment { .. }
                | Action::Follower(_) => {}
            }
        }
        if !acts {
            continue;
        }
        let amplitude = load.amplitude().as_ref().and_then(|a| amplitudes.get(a).copied());
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
                    let [of_a, of_both, of_b] = consistent_edge(mesh, [a, b]).map(|weight| m.value * weight);
                    let (a, b) = (
                        vectors.coordinates.position_of[a as usize],
                        vectors.coordinates.position_of[b as usize],
                    );
                    out.extend([(a, a, of_a), (b, b, of_b), (a, b, of_both)]);
                }
            }
            AddedMass::Area(m) => {
                for q in mesh.quads_on(&m.on).unwrap_or_default() {
                    let nodes = mesh.quads[q as usize];
                    let geometry =
                        ShellGeometry::new(nodes.map(|n| mesh.positions[n as usize]), [Vec3::z(); 4]);
                    let weights = consistent_quad(&geometry);
                    for a in 0..4 {
                        for b in 0..=a {
                            let (va, vb) = (
                                vectors.coordinates.position_of[nodes[a] as usize],
                                vectors.coordinates.position_of[nodes[b] as usize],
                            );
                            out.push((va, vb, m.value * weights[pair(a, b)]));
                        }
                    }
                }
            }
        }
    }
    out
}

/// Consistent mass matrix of an edge with the mass 1 per length: lower triangle by rows.
pub(super) fn consistent_edge(mesh: &Mesh, [a, b]: [u32; 2]) -> [f64; 3] {
    let third = (mesh.positions[a as usize] - mesh.positions[b as usize]).norm() / 3.0;
    [third, 0.5 * third, third]
}

/// Consistent mass matrix of a quad with the mass 1 per area: lower triangle by rows.
pub(super) fn consistent_quad(geometry: &ShellGeometry) -> [f64; 10] {
    let matrix = shell_mass(geometry, &SectionInertia { mass: 1.0, rotary: 0.0, coupling: 0.0 });
    std::array::from_fn(|i| matrix[i])
}

/// Whether initial velocities are those of the whole model.
pub(super) fn moves_model(initial: &InitialVelocity, mesh: &Mesh) -> bool {
    initial.on == "model" && mesh.nodes_on("model").is_none()
}

/// Velocities of rigid motions of sets where an analysis step starts, with the nodal vectors `current`; empty where there are none.
pub(super) fn initial_velocity(
    model: &Model,
    mesh: &Mesh,
    vectors: &Vectors,
    current: &[Nodal],
) -> Vec<Nodal> {
    if model.initial_velocities.is_empty() {
        return Vec::new();
    }
    let mut out = vec![[0.0; 3]; vectors.coordinates.reference.len()];
    let directors = vectors.by_node(VectorKind::Director);
    let gradients = vectors.by_node(VectorKind::Gradient);
    for initial in &model.initial_velocities {
        let (v, omega) = (Vec3::from(initial.velocity), Vec3::from(initial.angular_velocity));
        let center = Vec3::from(initial.center);
        let whole = moves_model(initial, mesh);
        for node in mesh.nodes_on(if whole { "all" } else { &initial.on }).unwrap_or_default() {
            let p = vectors.coordinates.position_of[node as usize];
            if p != u32::MAX {
                let x = Vec3::from(current[p as usize]);
                out[p as usize] = (v + omega.cross(&(x - center))).into();
            }
            for &d in [&directors, &gradients].into_iter().filter_map(|l| l.get(&node)).flatten() {
                out[d as usize] = omega.cross(&Vec3::from(current[d as usize])).into();
            }
        }
        let of_beam = |name: &str| {
            name.strip_prefix(initial.on.as_str()).is_some_and(|rest| rest.starts_with('.'))
                && model.beams.iter().any(|beam| beam.name == initial.on)
        };
        let moved = |body: &&Body| whole || body.name == initial.on || of_beam(&body.name);
        for body in vectors.coordinates.bodies.iter().filter(moved) {
            let x = Vec3::from(current[body.centre as usize]);
            out[body.centre as usize] = (v + omega.cross(&(x - center))).into();
            for &d in body.directors.iter().flatten() {
                out[d as usize] = omega.cross(&Vec3::from(current[d as usize])).into();
            }
        }
    }
    out
}

/// Mesh as its loads see it.
pub(super) struct Loaded<'a> {
    pub mesh: &'a Mesh,
    pub coordinates: &'a Coordinates,
    /// Factor on the value of the load; `None` where it is 1.
    distribution: Option<Factors<'a>>,
    /// Numbers of quads by their nodes, for fields with a value for each quad.
    numbers: HashMap<[u32; 4], u32>,
}

impl<'a> Loaded<'a> {
    /// The mesh as a load sees it, whose distribution was checked.
    pub fn new(load: &Load, mesh: &'a Mesh, coordinates: &'a Coordinates) -> Self {
        let distribution = load.distribution().and_then(|distribution| Factors::of(distribution, mesh));
        let by_quad = distribution.as_ref().is_some_and(|factors| factors.by_quad().is_some());
        let numbers = if by_quad { mesh.quads.iter().copied().zip(0..).collect() } else { HashMap::new() };
        Self { mesh, coordinates, distribution, numbers }
    }

    /// Values of a field for each quad; `None` where the factor varies within them.
    fn by_quad(&self, quads: &[[u32; 4]]) -> Option<Vec<f64>> {
        let values = self.distribution.as_ref()?.by_quad()?;
        let value = |quad: &[u32; 4]| values.get(*self.numbers.get(quad)? as usize).copied();
        Some(quads.iter().map(|quad| value(quad).unwrap_or(f64::NAN)).collect())
    }

    /// Integrals over elements with the factor, which has been checked.
    fn weighted(&self, quads: &[[u32; 4]]) -> Vec<Integral<4>> {
        let integrals =
            self.distribution.as_ref().and_then(|factors| factors.over_elements(self.mesh, quads).ok());
        integrals.unwrap_or_default()
    }

    /// Integrals of both shape functions over edges, times the factor.
    fn shares(&self, edges: &[[u32; 2]]) -> Vec<[f64; 2]> {
        let Some(factors) = &self.distribution else {
            let ends = edges.iter().map(|edge| self.places(edge));
            return ends.map(|[a, b]| [0.5 * (a - b).norm(); 2]).collect();
        };
        let parts = factors.over_edges(self.mesh, edges).unwrap_or_default();
        parts.iter().map(|part| part.nodal).collect()
    }

    fn places<const N: usize>(&self, nodes: &[u32; N]) -> [Vec3; N] {
        nodes.map(|node| self.mesh.positions[node as usize])
    }

    /// Body that a number behind those of the nodes stands for.
    pub fn body(&self, node: u32) -> Option<&Body> {
        self.coordinates.bodies.get((node as usize).checked_sub(self.mesh.positions.len())?)
    }
}

/// Sums of the shares of nodes.
fn summed<const N: usize>(parts: impl Iterator<Item = ([u32; N], [f64; N])>) -> BTreeMap<u32, f64> {
    let mut out = BTreeMap::new();
    for (node, share) in parts.flat_map(|(nodes, shares)| nodes.into_iter().zip(shares)) {
        *out.entry(node).or_default() += share;
    }
    out
}

impl LoadedMesh for Loaded<'_> {
    fn nodes(&self, set: &str) -> Vec<u32> {
        let body = self.coordinates.bodies.iter().position(|body| body.name == set);
        match body {
            Some(body) => vec![(self.mesh.positions.len() + body) as u32],
            None => self.mesh.nodes_on(set).unwrap_or_default(),
        }
    }

    fn quads(&self, set: &str) -> Vec<[u32; 4]> {
        let quads = self.mesh.quads_on(set).unwrap_or_default();
        quads.into_iter().map(|q| self.mesh.quads[q as usize]).collect()
    }

    fn factor(&self, node: u32) -> f64 {
        self.distribution.as_ref().and_then(|factors| factors.at_node(self.mesh, node)).unwrap_or(1.0)
    }

    fn mean_factors(&self, quads: &[[u32; 4]]) -> Vec<f64> {
        if self.distribution.is_none() {
            return vec![1.0; quads.len()];
        }
        self.by_quad(quads).unwrap_or_else(|| self.weighted(quads).iter().map(Integral::mean).collect())
    }

    fn lengths(&self, set: &str) -> BTreeMap<u32, f64> {
        let edges = self.mesh.edges_on(set).unwrap_or_default();
        let lengths = self.shares(&edges);
        summed(edges.into_iter().zip(lengths))
    }

    fn areas(&self, set: &str) -> BTreeMap<u32, f64> {
        let quads = self.quads(set);
        let areas: Vec<[f64; 4]> = match (&self.distribution, self.by_quad(&quads)) {
            (None, _) => quads.iter().map(|quad| nodal_areas(&self.places(quad))).collect(),
            (_, Some(factors)) => {
                let areas = quads.iter().map(|quad| nodal_areas(&self.places(quad)));
                areas.zip(factors).map(|(areas, factor)| areas.map(|area| area * factor)).collect()
            }
            (Some(_), None) => self.weighted(&quads).iter().map(|part| part.nodal).collect(),
        };
        summed(quads.into_iter().zip(areas))
    }

    fn vectors(&self, node: u32) -> [u32; 2] {
        match self.body(node) {
            Some(body) => [body.centre, body.directors.map_or(u32::MAX, |directors| directors[0])],
            None => {
                [&self.coordinates.position_of, &self.coordinates.director_of].map(|of| of[node as usize])
            }
        }
    }
}

/// Place of a pair in a lower triangle.
fn pair(a: usize, b: usize) -> usize {
    let (i, j) = (a.max(b), a.min(b));
    i * (i + 1) / 2 + j
}
