//! Moment on every node of a set, or on a body, that turns with it.

use super::{Action, LoadKind, LoadedMesh, LoadedPart};
use crate::Vec3;
use crate::model::VectorLoad;

/// Moment on every node of a set that turns with the node; its value is that in the reference configuration.
pub struct FollowerMoment;

impl LoadKind for FollowerMoment {
    type Keys = VectorLoad;
    const WORD: &'static str = "follower-moment";
    const PART: LoadedPart = LoadedPart::Nodes;

    fn actions(keys: &VectorLoad, mesh: &dyn LoadedMesh) -> Vec<Action> {
        let moment = Vec3::from(keys.value);
        let nodes = mesh.nodes(&keys.on).into_iter();
        nodes.map(|node| Action::FollowerMoment { node, moment: moment * mesh.factor(node) }).collect()
    }

    fn example() -> VectorLoad {
        VectorLoad::new("u_max", [0.2, 0.4, -0.3])
    }
}
