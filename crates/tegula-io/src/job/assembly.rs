//! Report of a run on a model that was assembled at its start.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use tegula::Vec3;
use tegula::system::ClosedGaps;

use super::summary::{number, vector};

/// Assembly of a model whose joints do not meet in the reference configuration.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct AssemblyResult {
    /// Gaps of joints before they were closed, by name.
    pub joints: BTreeMap<String, GapResult>,
    /// Motions of bodies from the reference configuration to the start, by name.
    pub bodies: BTreeMap<String, MotionResult>,
}

/// Gap of a joint.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct GapResult {
    /// Distance of the points (length).
    #[serde(deserialize_with = "number")]
    pub distance: f64,
    /// Angle between the axes (degrees).
    #[serde(deserialize_with = "number")]
    pub angle: f64,
}

/// Motion of a body.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct MotionResult {
    /// Displacement of the mass centre (length).
    #[serde(deserialize_with = "vector")]
    pub displacement: [f64; 3],
    /// Axis of the rotation times its angle (degrees).
    #[serde(deserialize_with = "vector")]
    pub rotation: [f64; 3],
}

impl From<&ClosedGaps> for AssemblyResult {
    fn from(gaps: &ClosedGaps) -> Self {
        let joint = |gap: &tegula::system::ClosedGap| {
            (gap.name.clone(), GapResult { distance: gap.distance, angle: gap.angle.to_degrees() })
        };
        let body = |body: &tegula::system::MovedBody| {
            let rotation = Vec3::from(body.rotation).map(f64::to_degrees).into();
            (body.name.clone(), MotionResult { displacement: body.displacement, rotation })
        };
        Self {
            joints: gaps.joints.iter().map(joint).collect(),
            bodies: gaps.bodies.iter().map(body).collect(),
        }
    }
}
