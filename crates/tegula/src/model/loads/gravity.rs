//! Gravity on all masses.

use super::{Action, LoadKeys, LoadKind, LoadedMesh, LoadedPart};
use crate::model::GravityLoad;

/// Gravity on all masses.
pub struct Gravity;

impl LoadKind for Gravity {
    type Keys = GravityLoad;
    const WORD: &'static str = "gravity";
    const PART: LoadedPart = LoadedPart::Model;
    const NEEDS_MASS: bool = true;

    fn actions(keys: &GravityLoad, _: &dyn LoadedMesh) -> Vec<Action> {
        vec![Action::Gravity(keys.value.into())]
    }

    fn example() -> GravityLoad {
        GravityLoad { value: [0.0, 0.0, -9.81], amplitude: None }
    }
}

impl LoadKeys for GravityLoad {
    fn on(&self) -> &str {
        ""
    }

    fn values(&self) -> &[f64] {
        &self.value
    }

    fn amplitude(&self) -> &Option<String> {
        &self.amplitude
    }

    fn amplitude_mut(&mut self) -> &mut Option<String> {
        &mut self.amplitude
    }
}
