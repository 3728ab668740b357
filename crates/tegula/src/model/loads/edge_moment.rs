//! Moment per length of an edge, constant in space with all its components.

use super::{Action, LoadKind, LoadedMesh, LoadedPart};
use crate::model::VectorLoad;

/// Moment per length of an edge, constant in space with all its components.
pub struct EdgeMoment;

impl LoadKind for EdgeMoment {
    type Keys = VectorLoad;
    const WORD: &'static str = "edge-moment";
    const PART: LoadedPart = LoadedPart::Edges;

    fn actions(keys: &VectorLoad, _: &dyn LoadedMesh) -> Vec<Action> {
        vec![Action::EdgeMoment { set: keys.on.clone(), moment: keys.value.into() }]
    }

    fn example() -> VectorLoad {
        VectorLoad::new("u_max", [0.1, 0.4, 0.2])
    }
}
