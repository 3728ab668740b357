//! Coordinates of the model: nodal vectors with their kinds, nodes and reference values.

use super::Attached;
use crate::element::Nodal;
pub use crate::element::VectorKind;
use crate::{Mat3, Vec3};

/// Nodal vectors of a model, node by node: the position of a node, then its directors, each followed by its gradients
/// where an element has them. They do not change while the model is analysed.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Coordinates {
    /// Nodal vectors of the reference configuration.
    pub reference: Vec<Nodal>,
    /// Kind of each nodal vector.
    pub kinds: Vec<VectorKind>,
    /// Node of each nodal vector; `u32::MAX` for those of bodies.
    pub nodes: Vec<u32>,
    /// Nodal vector of the position of each node (`u32::MAX` for nodes without elements).
    pub position_of: Vec<u32>,
    /// Nodal vector of the (first) director of each node (`u32::MAX` for nodes without elements).
    pub director_of: Vec<u32>,
    /// Flags of the inextensible directors among the nodal vectors; empty: none.
    pub inextensible: Vec<bool>,
    /// Rigid bodies and point masses; their nodal vectors come after those of the nodes.
    pub bodies: Vec<Body>,
}

/// Nodal vectors and inertia of a rigid body or a point mass.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Name of the body in the model.
    pub name: String,
    /// Nodal vector of the mass centre.
    pub centre: u32,
    /// Nodal vectors of the directors: unit vectors fixed in the body, along its axes; `None` for point masses.
    pub directors: Option<[u32; 3]>,
    /// Mass.
    pub mass: f64,
    /// Euler tensor `∫ρ X Xᵀ dV = ½ tr(J) I − J` about the mass centre, along the axes of the body
    /// \[mass · length²\].
    pub euler: Mat3,
    /// Nodal vectors of the mesh that are fixed in the body, ascending.
    pub attached: Vec<Attached>,
    /// Mass of the attached part of the shell, its first moments and its Euler tensor about the mass centre of the body, along the
    /// axes of the body.
    pub patch: (f64, Vec3, Mat3),
}

impl Body {
    /// Mass and Euler tensor with those of the attached part of the shell, about the mass centre of both.
    pub fn inertia(&self) -> (f64, Mat3) {
        let (mass, first, euler) = self.patch;
        let total = self.mass + mass;
        let shift = if total == 0.0 { Mat3::zeros() } else { first * first.transpose() / total };
        (total, self.euler + euler - shift)
    }

    /// Radius of gyration √(tr E/m) (length) of the body with its patch; 0 without mass.
    pub fn gyration(&self) -> f64 {
        let (mass, euler) = self.inertia();
        if mass == 0.0 { 0.0 } else { (euler.trace() / mass).sqrt() }
    }
}

impl Coordinates {
    /// Adds a nodal vector of a node; returns its index.
    pub fn push(&mut self, value: Nodal, kind: VectorKind, node: u32) -> u32 {
        self.reference.push(value);
        self.kinds.push(kind);
        self.nodes.push(node);
        (self.reference.len() - 1) as u32
    }

    /// Number of nodal vectors.
    pub fn len(&self) -> usize {
        self.reference.len()
    }

    /// Whether there are no nodal vectors.
    pub fn is_empty(&self) -> bool {
        self.reference.is_empty()
    }

    /// Body of a nodal vector; `None` for those of nodes.
    pub fn body_of(&self, vector: usize) -> Option<&Body> {
        let after = self.bodies.partition_point(|body| body.centre as usize <= vector);
        self.bodies[..after].last()
    }

    /// Reference position of the node or the body that a nodal vector belongs to.
    pub fn place(&self, vector: usize) -> Nodal {
        let position = match self.body_of(vector) {
            Some(body) => body.centre,
            None => self.position_of[self.nodes[vector] as usize],
        };
        self.reference[position as usize]
    }

    /// Adds a body with its directors along the axes; returns its index.
    pub fn push_body(&mut self, name: &str, centre: Vec3, inertia: (f64, Option<(Mat3, Mat3)>)) -> usize {
        let (mass, rotary) = inertia;
        let place = self.push(centre.into(), VectorKind::Position, u32::MAX);
        let (mut directors, mut euler) = (None, Mat3::zeros());
        if let Some((axes, tensor)) = rotary {
            let push =
                |i: usize| self.push(axes.column(i).into_owned().into(), VectorKind::Director, u32::MAX);
            directors = Some([0, 1, 2].map(push));
            euler = tensor;
        }
        let (attached, patch) = (Vec::new(), (0.0, Vec3::zeros(), Mat3::zeros()));
        let name = name.to_owned();
        self.bodies.push(Body { name, centre: place, directors, mass, euler, attached, patch });
        self.bodies.len() - 1
    }

    /// Directors of the rigid bodies.
    pub fn triads(&self) -> Vec<[u32; 3]> {
        self.bodies.iter().filter_map(|body| body.directors).collect()
    }

    /// Nodal vectors attached to rigid bodies, ascending.
    pub fn attached(&self) -> Vec<Attached> {
        let mut out: Vec<Attached> = self.bodies.iter().flat_map(|body| &body.attached).copied().collect();
        out.sort_unstable_by_key(|attached| attached.vector);
        out
    }
}
