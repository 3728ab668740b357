//! Force on every node of a set.

use super::{Action, LoadKind, LoadedMesh, LoadedPart};
use crate::Vec3;
use crate::model::VectorLoad;

/// Force on every node of a set.
pub struct Force;

impl LoadKind for Force {
    type Keys = VectorLoad;
    const WORD: &'static str = "force";
    const PART: LoadedPart = LoadedPart::Nodes;

    fn actions(keys: &VectorLoad, mesh: &dyn LoadedMesh) -> Vec<Action> {
        let force = Vec3::from(keys.value);
        let nodes = mesh.nodes(&keys.on).into_iter();
        nodes.map(|node| Action::Force { node, force: force * mesh.factor(node) }).collect()
    }

    fn example() -> VectorLoad {
        VectorLoad::new("u_max", [0.3, -0.2, 0.5])
    }
}
