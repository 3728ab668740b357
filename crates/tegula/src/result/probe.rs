//! Points of the mesh whose motion is recorded.

use crate::analysis::State;
use crate::mesh::Mesh;
use crate::model::OutputPoint;
use crate::system::System;
use crate::{Error, Issue, Result, Vec3};

/// A point whose motion is recorded.
#[derive(Debug, Clone, PartialEq)]
pub struct Probe {
    /// Name of the point.
    pub name: String,
    /// Node of the mesh.
    pub node: u32,
    /// Nodal vector of its position.
    vector: usize,
}

impl Probe {
    /// The probes of a model's output points.
    ///
    /// # Errors
    /// A point names no set of one node, or its node belongs to no element.
    pub fn all(points: &[OutputPoint], mesh: &Mesh, system: &System) -> Result<Vec<Self>> {
        let mut issues = Vec::new();
        let mut probes = Vec::new();
        for (i, point) in points.iter().enumerate() {
            let node = match (&point.on, point.at) {
                (Some(on), _) => mesh.nodes_on(on).and_then(|nodes| nodes.first().copied()),
                (None, Some(at)) => mesh.nearest_node(Vec3::from(at)),
                (None, None) => None,
            };
            let vector =
                node.and_then(|n| system.coordinates.position_of.get(n as usize)).filter(|&&v| v != u32::MAX);
            match (node, vector) {
                (Some(node), Some(&v)) => {
                    probes.push(Self { name: point.name.clone(), node, vector: v as usize });
                }
                _ => issues.push(Issue::new(
                    format!("output.points[{i}]"),
                    format!("point \"{}\" is not on any element", point.name),
                    "name a set with one node of the shell, or give a position with `at`",
                )),
            }
        }
        if issues.is_empty() { Ok(probes) } else { Err(Error::Model(issues)) }
    }

    /// Position (length).
    pub fn position(&self, system: &System, state: &State) -> [f64; 3] {
        let (x, u) = (system.coordinates.reference[self.vector], self.displacement(state));
        std::array::from_fn(|i| x[i] + u[i])
    }

    /// Displacement (length).
    pub fn displacement(&self, state: &State) -> [f64; 3] {
        state.u[self.vector]
    }

    /// Velocity [length/time].
    pub fn velocity(&self, state: &State) -> [f64; 3] {
        state.v.get(self.vector).copied().unwrap_or_default()
    }
}
