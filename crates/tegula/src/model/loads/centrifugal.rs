//! Centrifugal forces of a model that turns at a constant angular velocity, in the frame that turns with it.

use super::{Action, LoadKeys, LoadKind, LoadedMesh, LoadedPart};
use crate::Vec3;
use crate::model::{CentrifugalLoad, Ground};

/// Centrifugal forces on all masses.
pub struct Centrifugal;

impl LoadKind for Centrifugal {
    type Keys = CentrifugalLoad;
    const WORD: &'static str = "centrifugal";
    const PART: LoadedPart = LoadedPart::Model;
    const NEEDS_MASS: bool = true;

    fn actions(keys: &CentrifugalLoad, _: &dyn LoadedMesh) -> Vec<Action> {
        let axis = Vec3::from(keys.axis);
        let size = axis.norm();
        let axis = if size > 0.0 { axis / size } else { axis };
        let with_ground = keys.ground == Ground::Turns;
        vec![Action::Centrifugal { axis, at: keys.at.into(), velocity: keys.velocity, with_ground }]
    }

    fn example() -> CentrifugalLoad {
        CentrifugalLoad {
            axis: [0.0, 0.0, 2.0],
            at: [-1.0, 0.25, 0.0],
            velocity: 3.0,
            ground: Ground::Turns,
            amplitude: None,
        }
    }
}

impl LoadKeys for CentrifugalLoad {
    fn on(&self) -> &str {
        ""
    }

    fn values(&self) -> &[f64] {
        std::slice::from_ref(&self.velocity)
    }

    fn amplitude(&self) -> &Option<String> {
        &self.amplitude
    }

    fn amplitude_mut(&mut self) -> &mut Option<String> {
        &mut self.amplitude
    }
}
