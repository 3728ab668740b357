//! Nodes whose forces and moments turn with them: the triad of each, of its body or of its shell.

use std::cell::OnceCell;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::Vectors;
use super::actions::Loaded;
use crate::Vec3;
use crate::load::{ForceOnBody, ForceOnShell, MomentOnBody, MomentOnShell, NodalLoad, OwnLoad, SurfaceTriad};
use crate::model::loads::LoadedMesh as _;
use crate::system::VectorKind;
use crate::system::dof_map::DofMap;

/// Sine of the angle between an edge and a director from which on the edge lies in the surface of the director: at a fold edges of other parts may lie along it.
const ACROSS: f64 = 0.5;

/// Nodes of a mesh and bodies, with the nodal vectors that turn with each.
pub(super) struct TurningNodes<'a> {
    loaded: &'a Loaded<'a>,
    vectors: &'a Vectors,
    dofs: &'a DofMap,
    mesh: OnceCell<Surroundings>,
}

/// Edges and directors of the nodes of a mesh.
struct Surroundings {
    /// Positions at the other ends of the edges around each node.
    ends: BTreeMap<u32, BTreeSet<u32>>,
    directors: BTreeMap<u32, Vec<u32>>,
}

/// Nodal vectors that turn with a node.
enum Triads {
    /// Directors of a rigid body or of a node of a beam.
    Body([u32; 3]),
    /// Position of the node, position of the other end of a mesh edge, director: of each edge that lies in the surface of a director. Each has the
    /// same share of a load, so that nothing depends on numbers of nodes or elements.
    Shell(Vec<[u32; 3]>),
}

impl<'a> TurningNodes<'a> {
    pub fn new(loaded: &'a Loaded<'a>, (vectors, dofs): (&'a Vectors, &'a DofMap)) -> Self {
        Self { loaded, vectors, dofs, mesh: OnceCell::new() }
    }

    /// Forces that turn with a node; none where nothing does.
    pub fn force(&self, node: u32, force: Vec3) -> Vec<OwnLoad> {
        let [position, _] = self.loaded.vectors(node);
        let on_body = |directors: [u32; 3], components| -> Arc<dyn NodalLoad> {
            let [a, b, c] = directors;
            Arc::new(ForceOnBody { vectors: [position, a, b, c], components })
        };
        let on_shell =
            |vectors, components| -> Arc<dyn NodalLoad> { Arc::new(ForceOnShell { vectors, components }) };
        self.loads(node, force, on_body, on_shell)
    }

    /// Moments that turn with a node; none where nothing does.
    pub fn moment(&self, node: u32, moment: Vec3) -> Vec<OwnLoad> {
        let on_body = |directors, components| -> Arc<dyn NodalLoad> {
            Arc::new(MomentOnBody { directors, components })
        };
        let on_shell =
            |vectors, components| -> Arc<dyn NodalLoad> { Arc::new(MomentOnShell { vectors, components }) };
        self.loads(node, moment, on_body, on_shell)
    }

    fn loads(
        &self,
        node: u32,
        value: Vec3,
        on_body: impl Fn([u32; 3], Vec3) -> Arc<dyn NodalLoad>,
        on_shell: impl Fn([u32; 3], Vec3) -> Arc<dyn NodalLoad>,
    ) -> Vec<OwnLoad> {
        let reference = |v: u32| Vec3::from(self.loaded.coordinates.reference[v as usize]);
        match self.triads(node) {
            None => Vec::new(),
            Some(Triads::Body(directors)) => {
                vec![OwnLoad(on_body(directors, components(&value, &directors.map(reference))))]
            }
            Some(Triads::Shell(list)) => {
                let share = value / list.len() as f64;
                let axes = |vectors: [u32; 3]| SurfaceTriad::new(&vectors.map(reference)).axes;
                list.into_iter().map(|v| OwnLoad(on_shell(v, components(&share, &axes(v))))).collect()
            }
        }
    }

    fn triads(&self, node: u32) -> Option<Triads> {
        if let Some(body) = self.loaded.body(node) {
            return body.directors.map(Triads::Body);
        }
        let [position, _] = self.loaded.vectors(node);
        if let Some(attached) = self.dofs.carried(position as usize) {
            return Some(Triads::Body(self.dofs.triads[attached.triad as usize]));
        }
        let around = self.mesh.get_or_init(|| self.surroundings());
        let reference = |v: u32| Vec3::from(self.loaded.coordinates.reference[v as usize]);
        let (ends, directors) = (around.ends.get(&node)?, around.directors.get(&node)?);
        let sine = |end: u32, director: u32| {
            let (edge, director) = (reference(end) - reference(position), reference(director));
            edge.cross(&director).norm() / (edge.norm() * director.norm())
        };
        let all = || directors.iter().flat_map(|&director| ends.iter().map(move |&end| (end, director)));
        let largest = all().map(|(end, director)| sine(end, director)).fold(0.0, crate::norm::larger);
        let in_surface = all().filter(|&(end, director)| sine(end, director) >= ACROSS.min(largest));
        Some(Triads::Shell(in_surface.map(|(end, director)| [position, end, director]).collect()))
    }

    fn surroundings(&self) -> Surroundings {
        let mut ends: BTreeMap<u32, BTreeSet<u32>> = BTreeMap::new();
        for quad in &self.loaded.mesh.quads {
            for (i, &node) in quad.iter().enumerate() {
                for end in [quad[(i + 1) % 4], quad[(i + 3) % 4]].into_iter().filter(|&end| end != node) {
                    ends.entry(node).or_default().insert(self.loaded.vectors(end)[0]);
                }
            }
        }
        let directors = self.vectors.by_node(VectorKind::Director).into_iter().collect();
        Surroundings { ends, directors }
    }
}

/// Components of a vector along orthonormal axes.
fn components(value: &Vec3, axes: &[Vec3; 3]) -> Vec3 {
    Vec3::from(axes.map(|axis| axis.dot(value)))
}
