//! Sensors: quantities of the motion that are recorded as columns of the history.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Sensor: a quantity of the motion with columns `sensor.NAME.…` in the history, on which stop conditions may depend.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "type", rename_all = "kebab-case")]
pub enum Sensor {
    /// Distance of two points, and its rate.
    Distance(DistanceSensor),
    /// Angle of one body relative to another about an axis, and its rate.
    Angle(AngleSensor),
    /// Position, velocity and acceleration of a point.
    Point(PointSensor),
    /// Magnitudes of the force and the moment in a joint.
    Reaction(ReactionSensor),
    /// Volume that a surface encloses, and its rate.
    Volume(VolumeSensor),
    /// Elongation of a material line of a shell, and its rate: a strain gauge.
    Strain(StrainSensor),
}

impl Sensor {
    /// Name of the sensor.
    pub fn name(&self) -> &String {
        match self {
            Self::Distance(keys) => &keys.name,
            Self::Angle(keys) => &keys.name,
            Self::Point(keys) => &keys.name,
            Self::Reaction(keys) => &keys.name,
            Self::Volume(keys) => &keys.name,
            Self::Strain(keys) => &keys.name,
        }
    }
}

/// Distance of two points.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DistanceSensor {
    /// Name of the sensor in results.
    pub name: String,
    /// Both sides: names of bodies, of sets with one node or of sets of elements (the point of one of them), or `ground`.
    pub between: [String; 2],
    /// Point of the first and point of the second one, in the reference configuration (length).
    #[schemars(extend("x-marker" = "point"))]
    pub points: [[f64; 3]; 2],
}

/// Angle about an axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AngleSensor {
    /// Name of the sensor in results.
    pub name: String,
    /// Both sides: names of bodies or of nodes of beams, or `ground`.
    pub between: [String; 2],
    /// Direction of the axis in the reference configuration. The angle is that of the second side relative to the first one,
    /// right-handed about the axis and 0 in the reference configuration (degrees); it counts full turns.
    #[schemars(extend("x-marker" = "direction"))]
    pub axis: [f64; 3],
}

/// Position, velocity and acceleration of a point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PointSensor {
    /// Name of the sensor in results.
    pub name: String,
    /// Name of a body, of a set with one node or of a set of elements.
    pub on: String,
    /// Point of the body in the reference configuration (length); its mass centre unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-marker" = "point"))]
    pub at: Option<[f64; 3]>,
}

/// Magnitudes of the reaction of a joint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReactionSensor {
    /// Name of the sensor in results.
    pub name: String,
    /// Name of the joint, or of a body with `distributed` nodes; the components are columns of the history without a sensor.
    pub joint: String,
}

/// Volume that a surface encloses.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VolumeSensor {
    /// Name of the sensor in results.
    pub name: String,
    /// Name of a set of elements. A closed surface whose directors point outwards has a positive volume.
    pub on: String,
    /// Tip of the cone over a surface that is open (length): its volume counts. On planes of symmetry that cut the surface the tip makes it that of
    /// the part on this side of them.
    #[serde(default)]
    #[schemars(extend("x-marker" = "point"))]
    pub tip: [f64; 3],
}

/// Strain gauge on a shell: elongation of the material line through a point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StrainSensor {
    /// Name of the sensor in results.
    pub name: String,
    /// Name of a set of elements.
    pub on: String,
    /// Point of one of the elements in the reference configuration (length), at any height between the faces: on a face for the strain
    /// there, on the mid-surface for that of the membrane.
    #[schemars(extend("x-marker" = "point"))]
    pub at: [f64; 3],
    /// Direction of the line in the reference configuration; it is projected along the director onto the surface.
    #[schemars(extend("x-marker" = "direction"))]
    pub direction: [f64; 3],
}
