//! Springs with dampers between two points, and torsion springs between two bodies.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A spring with a damper between two points.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpringDamper {
    /// Name of the spring in messages.
    pub name: String,
    /// Both sides: names of bodies, of sets with one node or of sets of elements (the point of one of them), or `ground`.
    pub between: [String; 2],
    /// Point of the first and point of the second one, in the reference configuration (length).
    #[schemars(extend("x-marker" = "point"))]
    pub points: [[f64; 3]; 2],
    /// Stiffness [force/length].
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub stiffness: f64,
    /// Damping: force per rate of the length [force·time/length].
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub damping: f64,
    /// Force that draws the points together, as a formula in the elongation `x` (length), its rate `v` and the time `t`, in place of
    /// `stiffness` and `damping`. A formula in `t` is an actuator.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force: Option<String>,
    /// Direction of an axis through the first point, which moves with the first side, in the reference configuration. The length of the spring is then the distance
    /// of the second point from this axis, and its force acts across it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-marker" = "direction"))]
    pub across: Option<[f64; 3]>,
    /// Length from which the elongation counts, without force where `stiffness` acts; the distance of the points unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0))]
    pub length: Option<f64>,
}

/// A torsion spring with a damper about the common axis of two bodies, beside a joint that lets them turn about it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TorsionSpring {
    /// Name of the spring in messages and results.
    pub name: String,
    /// Both sides: names of bodies or of nodes of beams, or `ground`.
    pub between: [String; 2],
    /// Direction of the axis in the reference configuration.
    #[schemars(extend("x-marker" = "direction"))]
    pub axis: [f64; 3],
    /// Stiffness [force·length/rad].
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub stiffness: f64,
    /// Damping: moment per rate of the angle [force·length·time/rad].
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub damping: f64,
    /// Moment that turns the sides back, as a formula in the angle `x` from the free angle (rad), its rate `v` (rad/time) and the time `t`, in
    /// place of `stiffness` and `damping`. A formula in `t` is an actuator.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub moment: Option<String>,
    /// Angle from which that of the spring counts, without moment where `stiffness` acts: of the second side relative to the first one and
    /// right-handed about the axis (degrees); 0 is the reference configuration.
    #[serde(default)]
    pub free_angle: f64,
}
