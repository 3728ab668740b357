//! Keys of gears.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::joint::{EXAMPLE, GROUND, JointKeys};

/// Gears: two wheels that turn about their axes in a carrier.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GearJoint {
    /// Name of the joint in messages and results.
    pub name: String,
    /// Both wheels: names of bodies, or `ground`.
    pub between: [String; 2],
    /// Body in which the hinges of both wheels lie, and relative to which their angles count: the name of a body, or `ground`.
    #[serde(default = "ground")]
    pub carrier: String,
    /// Directions of the axes of both wheels in the reference configuration; they are fixed in the carrier. Angles are right-handed about
    /// them.
    #[schemars(extend("x-marker" = "direction"))]
    pub axes: [[f64; 3]; 2],
    /// Radii of the pitch circles (length), or numbers of teeth, of which only the ratio counts: the first angular velocity is minus the second radius over the
    /// first one times the second one. A negative radius is that of a wheel with internal teeth. Parallel axes point in the same direction,
    /// those of bevel gears both away from their apex, or both towards it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radii: Option<[f64; 2]>,
    /// Ratio of the angular velocities, that of the first wheel over that of the second one, in place of `radii`; negative where they turn
    /// in opposite senses.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ratio: Option<f64>,
}

fn ground() -> String {
    GROUND.to_owned()
}

impl GearJoint {
    /// Ratio of the first angle to the second one; NaN where none is given.
    pub fn ratio_of_angles(&self) -> f64 {
        self.radii.map_or(self.ratio.unwrap_or(f64::NAN), |[first, second]| -second / first)
    }
}

impl JointKeys for GearJoint {
    fn name(&self) -> &str {
        &self.name
    }

    fn between(&self) -> &[String; 2] {
        &self.between
    }

    fn directions(&self) -> Vec<(&'static str, [f64; 3])> {
        vec![("axes[0]", self.axes[0]), ("axes[1]", self.axes[1])]
    }

    fn points(&self) -> Vec<(&'static str, [f64; 3])> {
        Vec::new()
    }

    fn carrier(&self) -> Option<&str> {
        Some(&self.carrier)
    }
}

impl GearJoint {
    pub(crate) fn example() -> Self {
        let (between, _, axis) = EXAMPLE;
        let (carrier, axes) = ("c".into(), [axis, [0.0, 1.0, 1.0]]);
        let between = between.map(str::to_owned);
        Self { name: "joint".into(), between, carrier, axes, radii: None, ratio: Some(-1.7) }
    }
}
