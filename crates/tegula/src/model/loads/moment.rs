//! Moment on the director of every node of a set, constant in space: `f = m × d / |d|²`.

use super::{Action, LoadKind, LoadedMesh, LoadedPart};
use crate::Vec3;
use crate::model::VectorLoad;

/// Moment on the director of every node of a set, constant in space: `f = m × d / |d|²`.
pub struct Moment;

impl LoadKind for Moment {
    type Keys = VectorLoad;
    const WORD: &'static str = "moment";
    const PART: LoadedPart = LoadedPart::Nodes;

    fn actions(keys: &VectorLoad, mesh: &dyn LoadedMesh) -> Vec<Action> {
        let moment = Vec3::from(keys.value);
        let nodes = mesh.nodes(&keys.on).into_iter();
        nodes.map(|node| Action::Moment { node, moment: moment * mesh.factor(node) }).collect()
    }

    fn example() -> VectorLoad {
        VectorLoad::new("u_max", [0.0, 0.4, 0.0])
    }
}
