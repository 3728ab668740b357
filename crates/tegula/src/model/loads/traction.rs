//! Force per reference area, constant in direction.

use super::{Action, LoadKind, LoadedMesh, LoadedPart};
use crate::Vec3;
use crate::model::VectorLoad;

/// Force per reference area, constant in direction.
pub struct Traction;

impl LoadKind for Traction {
    type Keys = VectorLoad;
    const WORD: &'static str = "traction";
    const PART: LoadedPart = LoadedPart::Quads;

    fn actions(keys: &VectorLoad, mesh: &dyn LoadedMesh) -> Vec<Action> {
        let nodes = mesh.areas(&keys.on).into_iter();
        nodes.map(|(node, area)| Action::Force { node, force: Vec3::from(keys.value) * area }).collect()
    }

    fn example() -> VectorLoad {
        VectorLoad::new("all", [0.3, -0.2, 0.5])
    }
}
