//! Nodal vectors of a mesh.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::inner_point::Corners;
use super::sections::Elements;
use super::{bodies, bushings, couplings, patches, springs, ties};
use crate::constraint::{Bushing, Joint, Spring, TorsionSpring};
use crate::element::VectorKind;
use crate::element::geometry::tangents;
use crate::mesh::Mesh;
use crate::mesh::directors::Directors;
use crate::system::Coordinates;
use crate::{Issue, Model, Vec3};

/// Nodal vectors of a mesh: position of each node, then its directors, node by node.
pub(super) struct Vectors {
    /// Nodal vectors.
    pub(super) coordinates: Arc<Coordinates>,
    /// Nodal vector of each director.
    pub(super) of_director: Vec<u32>,
    /// First of the two gradient vectors beside each director, where an element has them.
    pub(super) gradient_of: Vec<u32>,
}

/// Joints and force elements between bodies, nodes and the ground.
pub(super) struct Connections {
    /// Joints.
    pub(super) joints: Vec<Joint>,
    /// Springs between two points.
    pub(super) springs: Vec<Spring>,
    /// Torsion springs.
    pub(super) torsion_springs: Vec<TorsionSpring>,
    /// Bushings.
    pub(super) bushings: Vec<Bushing>,
}

impl Vectors {
    pub(super) fn new(mesh: &Mesh, directors: &Directors, with_gradients: &[bool]) -> Self {
        let nodes = mesh.positions.len();
        let mut of_node: Vec<Vec<u32>> = vec![Vec::new(); nodes];
        for (d, &node) in directors.node.iter().enumerate() {
            of_node[node as usize].push(d as u32);
        }
        let unknown = || vec![u32::MAX; nodes];
        let mut coordinates =
            Coordinates { position_of: unknown(), director_of: unknown(), ..Coordinates::default() };
        let mut of_director = vec![u32::MAX; directors.values.len()];
        let mut gradient_of = of_director.clone();
        for (node, list) in of_node.iter().enumerate().filter(|(_, l)| !l.is_empty()) {
            let mut push = |value: Vec3, kind| coordinates.push(value.into(), kind, node as u32);
            let position = push(mesh.positions[node], VectorKind::Position);
            for &d in list {
                let value = directors.values[d as usize];
                of_director[d as usize] = push(value, VectorKind::Director);
                if with_gradients[d as usize] {
                    let [t1, t2] = tangents(&value);
                    gradient_of[d as usize] = push(t1, VectorKind::Gradient);
                    push(t2, VectorKind::Gradient);
                }
            }
            coordinates.position_of[node] = position;
            coordinates.director_of[node] = of_director[list[0] as usize];
        }
        Self { coordinates: Arc::new(coordinates), of_director, gradient_of }
    }

    /// Adds the nodal vectors of bodies, behind those of all nodes, and attaches nodes to them; returns the joints and
    /// force elements.
    pub(super) fn add_bodies(
        &mut self,
        (model, mesh): (&Model, &Mesh),
        elements: &mut Elements,
        issues: &mut Vec<Issue>,
    ) -> Connections {
        let coordinates = Arc::make_mut(&mut self.coordinates);
        bodies::add_vectors(model, coordinates);
        patches::attach(model, mesh, coordinates, issues);
        patches::add_inertia(coordinates, &elements.groups);
        for attached in coordinates.attached() {
            elements.unit.remove(&attached.vector);
        }
        let corners = Corners::new(mesh, elements);
        let surface = (mesh, &corners);
        let mut joints = bodies::joints(model, surface, coordinates, issues);
        couplings::add((model, mesh), (coordinates, elements), &mut joints, issues);
        let length = bodies::extent(model, mesh, coordinates);
        ties::add(model, surface, (coordinates, length), &mut joints, issues);
        Connections {
            joints,
            springs: springs::springs(model, surface, coordinates, issues),
            torsion_springs: springs::torsion_springs(model, surface, coordinates, issues),
            bushings: bushings::bushings(model, surface, coordinates, issues),
        }
    }

    /// Marks the directors that keep their length.
    pub(super) fn mark_inextensible(&mut self, directors: &BTreeSet<u32>) {
        if !directors.is_empty() {
            let flags = (0..self.coordinates.len() as u32).map(|v| directors.contains(&v)).collect();
            Arc::make_mut(&mut self.coordinates).inextensible = flags;
        }
    }

    /// Vectors of a kind of each node.
    pub(super) fn by_node(&self, wanted: VectorKind) -> BTreeMap<u32, Vec<u32>> {
        let mut out: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for (v, (kind, node)) in self.coordinates.kinds.iter().zip(&self.coordinates.nodes).enumerate() {
            if *kind == wanted {
                out.entry(*node).or_default().push(v as u32);
            }
        }
        out
    }
}
