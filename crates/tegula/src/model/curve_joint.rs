//! Keys of a point that moves along a curve.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::joint::{EXAMPLE, JointKeys};

/// A curve, fixed in the first side, along which a point of the second side moves.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CurveJoint {
    /// Name of the joint in messages and results.
    pub name: String,
    /// Side in which the curve is fixed, a body or `ground`, and side of the point: the name of a body or of a set with one node.
    pub between: [String; 2],
    /// Point of the second side in the reference configuration, on the curve (length); any of `points` is.
    #[schemars(extend("x-marker" = "point"))]
    pub at: [f64; 3],
    /// Points through which the curve goes in the reference configuration, in this order (length): it is a cubic spline, whose curvature is
    /// continuous.
    #[schemars(extend("x-marker" = "point"))]
    pub points: Vec<[f64; 3]>,
    /// Whether the curve is closed: a smooth piece connects its last point with the first one.
    #[serde(default)]
    pub closed: bool,
}

impl JointKeys for CurveJoint {
    fn name(&self) -> &str {
        &self.name
    }

    fn between(&self) -> &[String; 2] {
        &self.between
    }

    fn points(&self) -> Vec<(&'static str, [f64; 3])> {
        vec![("at", self.at)]
    }

    fn curve(&self) -> &[[f64; 3]] {
        &self.points
    }
}

impl CurveJoint {
    pub(crate) fn example() -> Self {
        let (between, at, _) = EXAMPLE;
        let points = [[-1.8, -0.6, 0.3], [-0.3, 0.8, 0.4], at, [1.3, 0.9, 0.8], [2.9, 0.4, -0.7]].to_vec();
        Self { name: "joint".into(), between: between.map(str::to_owned), at, points, closed: true }
    }
}
