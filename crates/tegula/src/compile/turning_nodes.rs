//! Nodes whose forces and moments turn with them: the triad of each, of its body or of its shell.

use std::cell::OnceCell;
use std::sync::Arc;

use super::actions::Loaded;
use crate::Vec3;
use crate::load::{
    ForceOnBody, ForceOnShell, MomentOnBody, MomentOnShell, NodalLoad, OwnLoad, SurfaceTriad,
};
use crate::model::loads::LoadedMesh as _;
use crate::system::dof_map::DofMap;

/// Nodes of a mesh and bodies, with the nodal vectors that turn with each.
pub(super) struct TurningNodes<'a> {
    loaded: &'a Loaded<'a>,
    dofs: &'a DofMap,
    /// Quads around each node.
    quads: OnceCell<Vec<Vec<u32>>>,
}

/// Nodal vectors that turn with a node.
enum Triad {
    /// Directors of a rigid body or of a node of a beam.
    Body([u32; 3]),
    /// Position of the node, position of the other end of a mesh edge, director.
    Shell([u32; 3]),
}

impl<'a> TurningNodes<'a> {
    pub fn new(loaded: &'a Loaded<'a>, dofs: &'a DofMap) -> Self {
        Self { loaded, dofs, quads: OnceCell::new() }
    }

    /// Force that turns with a node; `None` where nothing does.
    pub fn force(&self, node: u32, force: Vec3) -> Option<OwnLoad> {
        let [position, _] = self.loaded.vectors(node);
        let load: Arc<dyn NodalLoad> = match self.triad(node, &force)? {
            Triad::Body(directors @ [a, b, c]) => Arc::new(ForceOnBody {
                vectors: [position, a, b, c],
                components: components(&force, &directors.map(|v| self.reference(v))),
            }),
            Triad::Shell(vectors) => {
                let components = components(&force, &self.surface_axes(vectors));
                Arc::new(ForceOnShell { vectors, components })
            }
        };
        Some(OwnLoad(load))
    }

    /// Moment that turns with a node; `None` where nothing does.
    pub fn moment(&self, node: u32, moment: Vec3) -> Option<OwnLoad> {
        let load: Arc<dyn NodalLoad> = match self.triad(node, &moment)? {
            Triad::Body(directors) => Arc::new(MomentOnBody {
                directors,
                components: components(&moment, &directors.map(|v| self.reference(v))),
            }),
            Triad::Shell(vectors) => {
                let components = components(&moment, &self.surface_axes(vectors));
                Arc::new(MomentOnShell { vectors, components })
            }
        };
        Some(OwnLoad(load))
    }

    fn reference(&self, vector: u32) -> Vec3 {
        self.loaded.coordinates.reference[vector as usize].into()
    }

    fn surface_axes(&self, vectors: [u32; 3]) -> [Vec3; 3] {
        SurfaceTriad::new(&vectors.map(|v| self.reference(v))).axes
    }

    fn triad(&self, node: u32, value: &Vec3) -> Option<Triad> {
        if let Some(body) = self.loaded.body(node) {
            return body.directors.map(Triad::Body);
        }
        let [position, director] = self.loaded.vectors(node);
        match self.dofs.carried(position as usize) {
            Some(attached) => Some(Triad::Body(self.dofs.triads[attached.triad as usize])),
            None => Some(Triad::Shell([position, self.neighbour(node, value)?, director])),
        }
    }

    /// Position of the node at the other end of a mesh edge of a node: of that edge which is nearest to the direction of the part of a
    /// force or a moment in the surface, so that shear of the elements turns it least.
    fn neighbour(&self, node: u32, value: &Vec3) -> Option<u32> {
        let mesh = self.loaded.mesh;
        let quads = self.quads.get_or_init(|| {
            let mut quads = vec![Vec::new(); mesh.positions.len()];
            for (number, quad) in (0u32..).zip(&mesh.quads) {
                quad.iter().for_each(|&n| quads[n as usize].push(number));
            }
            quads
        });
        let ends = quads.get(node as usize)?.iter().flat_map(|&number| {
            let quad = mesh.quads[number as usize];
            let place = quad.iter().position(|&n| n == node).unwrap_or_default();
            [quad[(place + 1) % 4], quad[(place + 3) % 4]]
        });
        let director = self.reference(self.loaded.vectors(node)[1]).normalize();
        let across = |x: &Vec3| x - director * director.dot(x);
        let wanted = across(value);
        let nearness = |&end: &u32| {
            let edge = across(&(mesh.positions[end as usize] - mesh.positions[node as usize]));
            let cosine = wanted.dot(&edge).abs() / edge.norm();
            // Rounding must not choose among edges in one line.
            (cosine / value.norm() * 1e6).round()
        };
        // The first one of the nearest, so that the choice does not depend on the order of comparison.
        let mut best: Option<(f64, u32)> = None;
        for end in ends.filter(|&end| end != node) {
            let nearness = nearness(&end);
            if best.is_none_or(|(largest, _)| nearness > largest) {
                best = Some((nearness, end));
            }
        }
        best.map(|(_, end)| self.loaded.vectors(end)[0])
    }
}

/// Components of a vector along orthonormal axes.
fn components(value: &Vec3, axes: &[Vec3; 3]) -> Vec3 {
    Vec3::from(axes.map(|axis| axis.dot(value)))
}
