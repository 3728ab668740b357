//! Force per length of an edge, constant in direction.

use super::{Action, LoadKind, LoadedMesh, LoadedPart};
use crate::Vec3;
use crate::model::VectorLoad;

/// Force per length of an edge, constant in direction.
pub struct Edge;

impl LoadKind for Edge {
    type Keys = VectorLoad;
    const WORD: &'static str = "edge";
    const PART: LoadedPart = LoadedPart::Edges;

    fn actions(keys: &VectorLoad, mesh: &dyn LoadedMesh) -> Vec<Action> {
        let nodes = mesh.lengths(&keys.on).into_iter();
        nodes.map(|(node, length)| Action::Force { node, force: Vec3::from(keys.value) * length }).collect()
    }

    fn example() -> VectorLoad {
        VectorLoad::new("u_max", [0.3, -0.2, 0.5])
    }
}
