//! Pressure that follows the surface; positive pushes against the director.

use super::{Action, LoadKeys, LoadKind, LoadedMesh, LoadedPart};
use crate::model::{Distribution, PressureLoad};

/// Pressure that follows the surface; positive pushes against the director.
pub struct Pressure;

impl LoadKind for Pressure {
    type Keys = PressureLoad;
    const WORD: &'static str = "pressure";
    const PART: LoadedPart = LoadedPart::Quads;

    fn actions(keys: &PressureLoad, mesh: &dyn LoadedMesh) -> Vec<Action> {
        let quads = mesh.quads(&keys.on);
        let factors = mesh.mean_factors(&quads);
        let pairs = quads.into_iter().zip(factors);
        pairs.map(|(quad, factor)| Action::Pressure { quad, pressure: keys.value * factor }).collect()
    }

    fn example() -> PressureLoad {
        PressureLoad { on: "all".into(), value: 0.3, amplitude: None, distribution: None }
    }
}

impl LoadKeys for PressureLoad {
    fn on(&self) -> &str {
        &self.on
    }

    fn values(&self) -> &[f64] {
        std::slice::from_ref(&self.value)
    }

    fn distribution(&self) -> Option<&Distribution> {
        self.distribution.as_ref()
    }

    fn amplitude(&self) -> &Option<String> {
        &self.amplitude
    }

    fn amplitude_mut(&mut self) -> &mut Option<String> {
        &mut self.amplitude
    }
}
