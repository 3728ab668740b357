//! Joints between bodies, nodes and the ground, with the registry of their kinds.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::curve_joint::CurveJoint;
use super::gear_joint::GearJoint;
use super::second_side::SecondSide;

/// The registry: one line for each joint. Calls the macro `$made` with all entries. An entry is
///
/// ```text
/// file::Kind(Keys): "help of the schema",
/// ```
///
/// - `crates/tegula/src/constraint/joints/file.rs` defines the type `Kind`, which implements `JointKind`;
/// - `Kind` becomes the variant of [`Joint`] that holds the `Keys`, and its name in kebab case the word of the model file.
///
/// [`Joint`] is made from it below, the modules and the constraints in `crates/tegula/src/constraint/joints/mod.rs`.
macro_rules! joints {
    ($made:ident) => {
        $made! {
            fixed::Fixed(PointJoint): "No relative motion.",
            spherical::Spherical(PointJoint): "Ball joint: the points coincide.",
            revolute::Revolute(CoordinateJoint): "Hinge: rotation about the axis.",
            universal::Universal(TwoAxesJoint): "Cardan joint: the points coincide, the two axes stay perpendicular.",
            cylindrical::Cylindrical(AxisJoint): "Rotation about the axis and sliding along it.",
            screw::Screw(ScrewJoint): "Rotation about the axis, and sliding along it by the pitch in each turn.",
            rack_and_pinion::RackAndPinion(RackJoint): "The pinion, the second side, rolls on the rack, the first one: it moves along it by the radius times its angle.",
            gear::Gear(GearJoint): "Gears: the angles of two wheels about their axes in a carrier have a constant ratio.",
            point_on_curve::PointOnCurve(CurveJoint): "A point of the second side moves along a smooth curve that is fixed in the first one.",
            prismatic::Prismatic(CoordinateJoint): "Sliding along the axis without rotation.",
            planar::Planar(AxisJoint): "Motion in the plane across the axis, and rotation about it.",
            driven_angle::DrivenAngle(DrivenAngleJoint): "Prescribed rotation about an axis, beside a revolute or cylindrical joint.",
            driven_length::DrivenLength(DrivenLengthJoint): "Prescribed displacement along an axis, beside a prismatic or cylindrical joint.",
            director_alignment::DirectorAlignment(DirectorJoint): "The director of a shell node stays parallel to an axis of the other side.",
            clamped_director::ClampedDirector(PointJoint): "The points coincide and the director of a shell node stays parallel to an axis of the other side: fixed but for drilling.",
            distance::Distance(DistanceJoint): "Rod without mass: the distance of two points is constant.",
        }
    };
}
pub(crate) use joints;

macro_rules! joint {
    ($($file:ident::$kind:ident($keys:ident): $help:literal,)*) => {
        /// A joint between two bodies, nodes or the ground.
        #[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(tag = "type", rename_all = "kebab-case")]
        pub enum Joint {
            $(#[doc = $help] $kind($keys),)*
        }

        impl Joint {
            /// Keys that all joints have.
            pub fn common(&self) -> &dyn JointKeys {
                match self {
                    $(Self::$kind(keys) => keys,)*
                }
            }

            /// Word of the model file.
            pub fn word(&self) -> String {
                match self {
                    $(Self::$kind(_) => stringify!($file).replace('_', "-"),)*
                }
            }
        }
    };
}
joints!(joint);

/// Keys that all joints have.
pub trait JointKeys {
    /// Name of the joint in messages and results.
    fn name(&self) -> &str;
    /// Both sides: names of bodies, of sets with one node or of sets of elements (the point of one of them), or `ground`.
    fn between(&self) -> &[String; 2];
    /// Directions that it needs, each with its key.
    fn directions(&self) -> Vec<(&'static str, [f64; 3])> {
        Vec::new()
    }
    /// Point of the first and point of the second side in the reference configuration, each with its key; one where they
    /// coincide. Reactions are given there.
    fn points(&self) -> Vec<(&'static str, [f64; 3])>;
    /// Prescribed motion of a driven joint.
    fn drive(&self) -> Option<JointDrive<'_>> {
        None
    }
    /// Name of the body in which the hinges of gears lie.
    fn carrier(&self) -> Option<&str> {
        None
    }
    /// Points of the curve that is fixed in the first side.
    fn curve(&self) -> &[[f64; 3]] {
        &[]
    }
    /// Place of the joint on the second side, where it differs from that on the first one.
    fn second_side(&self) -> SecondSide {
        SecondSide::default()
    }
    /// Friction of its relative motion.
    fn friction(&self) -> Option<&JointFriction> {
        None
    }
    /// Stops of its relative motion.
    fn stops(&self) -> Option<&JointStops> {
        None
    }
}

/// Prescribed motion of a driven joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointDrive<'a> {
    /// Key of the value.
    pub key: &'static str,
    /// Angle (degrees) or length at amplitude 1.
    pub given: f64,
    /// Angle (rad) or length at amplitude 1.
    pub value: f64,
    /// Name of the amplitude.
    pub amplitude: &'a str,
}

/// Name for the ground in `between`.
pub const GROUND: &str = "ground";

/// A joint at a point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PointJoint {
    /// Name of the joint in messages and results.
    pub name: String,
    /// Both sides: names of bodies, of sets with one node or of sets of elements (the point of one of them), or `ground`.
    pub between: [String; 2],
    /// Point of the joint in the reference configuration (length).
    #[schemars(extend("x-marker" = "point"))]
    pub at: [f64; 3],
    /// Point of the joint on the second side, in the reference configuration (length); that of the first one unless given. Where both do
    /// not meet, the model is assembled at the start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-marker" = "point"))]
    pub second_at: Option<[f64; 3]>,
}

/// A joint with an axis through a point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AxisJoint {
    /// Name of the joint in messages and results.
    pub name: String,
    /// Both sides: names of bodies, of sets with one node or of sets of elements (the point of one of them), or `ground`.
    pub between: [String; 2],
    /// Point of the joint in the reference configuration (length).
    #[schemars(extend("x-marker" = "point"))]
    pub at: [f64; 3],
    /// Direction of the axis in the reference configuration.
    #[schemars(extend("x-marker" = "direction"))]
    pub axis: [f64; 3],
    /// Point of the joint on the second side, in the reference configuration (length); that of the first one unless given. Where both do
    /// not meet, the model is assembled at the start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-marker" = "point"))]
    pub second_at: Option<[f64; 3]>,
    /// Direction of the axis on the second side, in the reference configuration; that of the first one unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-marker" = "direction"))]
    pub second_axis: Option<[f64; 3]>,
}

/// A screw.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScrewJoint {
    /// Name of the joint in messages and results.
    pub name: String,
    /// Both sides: names of bodies, or `ground`.
    pub between: [String; 2],
    /// Point of the joint in the reference configuration (length).
    #[schemars(extend("x-marker" = "point"))]
    pub at: [f64; 3],
    /// Direction of the axis in the reference configuration.
    #[schemars(extend("x-marker" = "direction"))]
    pub axis: [f64; 3],
    /// Point of the joint on the second side, in the reference configuration (length); that of the first one unless given. Where both do
    /// not meet, the model is assembled at the start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-marker" = "point"))]
    pub second_at: Option<[f64; 3]>,
    /// Direction of the axis on the second side, in the reference configuration; that of the first one unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-marker" = "direction"))]
    pub second_axis: Option<[f64; 3]>,
    /// Displacement of the second side relative to the first one along the axis per turn, right-handed about the axis (length); negative
    /// for left-hand threads.
    pub pitch: f64,
}

/// A joint with one relative motion, along or about an axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CoordinateJoint {
    /// Name of the joint in messages and results.
    pub name: String,
    /// Both sides: names of bodies, of sets with one node or of sets of elements (the point of one of them), or `ground`.
    pub between: [String; 2],
    /// Point of the joint in the reference configuration (length).
    #[schemars(extend("x-marker" = "point"))]
    pub at: [f64; 3],
    /// Direction of the axis in the reference configuration.
    #[schemars(extend("x-marker" = "direction"))]
    pub axis: [f64; 3],
    /// Point of the joint on the second side, in the reference configuration (length); that of the first one unless given. Where both do
    /// not meet, the model is assembled at the start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-marker" = "point"))]
    pub second_at: Option<[f64; 3]>,
    /// Direction of the axis on the second side, in the reference configuration; that of the first one unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-marker" = "direction"))]
    pub second_axis: Option<[f64; 3]>,
    /// Coulomb friction of the relative motion; in transient analyses with the scheme `energy-momentum`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<JointFriction>,
    /// Stops of the relative motion; in transient analyses with the scheme `energy-momentum`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stops: Option<JointStops>,
}

impl From<AxisJoint> for CoordinateJoint {
    /// The joint without friction and stops.
    fn from(AxisJoint { name, between, at, axis, second_at, second_axis }: AxisJoint) -> Self {
        Self { name, between, at, axis, second_at, second_axis, friction: None, stops: None }
    }
}

/// Coulomb friction of a joint: the friction force of a prismatic joint is at most `μ |N| + preload`, the friction torque of a revolute
/// joint `μ r |N| + preload`, with the reaction force N of the joint across its axis.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JointFriction {
    /// Coefficient μ of sliding friction.
    #[serde(default)]
    #[schemars(extend("minimum" = 0))]
    pub coefficient: f64,
    /// Coefficient of static friction, not below that of sliding friction, to which it is equal unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub static_coefficient: Option<f64>,
    /// Radius r of the bearing of a revolute joint (length).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub radius: Option<f64>,
    /// Constant part of the friction force (force), or torque (force·length), whatever the reaction of the joint.
    #[serde(default)]
    #[schemars(extend("minimum" = 0))]
    pub preload: f64,
}

/// Stops of a joint: limits of the displacement of the second side relative to the first one along the axis, or of its angle about the
/// axis, both zero in the reference configuration.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JointStops {
    /// Smallest displacement (length), or angle (degrees); none unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lower: Option<f64>,
    /// Largest displacement (length), or angle (degrees); none unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub upper: Option<f64>,
    /// Coefficient of restitution e, from 0 (plastic impact) to 1: the relative velocity behind an impact is −e times that before.
    #[serde(default)]
    #[schemars(range(min = 0, max = 1))]
    pub restitution: f64,
}

/// A rack, the first side, and a pinion, the second one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RackJoint {
    /// Name of the joint in messages and results.
    pub name: String,
    /// Rack and pinion: names of bodies, or `ground`.
    pub between: [String; 2],
    /// Centre of the pinion in the reference configuration (length).
    #[schemars(extend("x-marker" = "point"))]
    pub at: [f64; 3],
    /// Direction of the axis of the pinion in the reference configuration.
    #[schemars(extend("x-marker" = "direction"))]
    pub axis: [f64; 3],
    /// Direction of the rack in the reference configuration, perpendicular to the axis.
    #[schemars(extend("x-marker" = "direction"))]
    pub direction: [f64; 3],
    /// Radius of the pitch circle: displacement of the centre relative to the rack along its direction per radian, right-handed about the
    /// axis (length per rad); negative where the rack lies on the other side.
    pub radius: f64,
}

/// A joint with one axis in each of the two bodies.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TwoAxesJoint {
    /// Name of the joint in messages and results.
    pub name: String,
    /// Both sides: names of bodies, of sets with one node or of sets of elements (the point of one of them), or `ground`.
    pub between: [String; 2],
    /// Point of the joint in the reference configuration (length).
    #[schemars(extend("x-marker" = "point"))]
    pub at: [f64; 3],
    /// Axis fixed in the first body and axis fixed in the second one, perpendicular to each other, in the reference
    /// configuration.
    #[schemars(extend("x-marker" = "direction"))]
    pub axes: [[f64; 3]; 2],
    /// Point of the joint on the second side, in the reference configuration (length); that of the first one unless given. Where both do
    /// not meet, the model is assembled at the start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-marker" = "point"))]
    pub second_at: Option<[f64; 3]>,
}

/// A joint of the director of a shell node.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DirectorJoint {
    /// Name of the joint in messages and results.
    pub name: String,
    /// Both sides: the name of a set with one node of a shell, and that of a body or `ground`.
    pub between: [String; 2],
}

/// A prescribed rotation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DrivenAngleJoint {
    /// Name of the joint in messages and results.
    pub name: String,
    /// Both sides: names of bodies, or `ground`.
    pub between: [String; 2],
    /// Direction of the axis in the reference configuration, about which another joint lets the two sides turn.
    #[schemars(extend("x-marker" = "direction"))]
    pub axis: [f64; 3],
    /// Rotation of the second side relative to the first one per unit of the amplitude, right-handed about the axis (degrees). It begins
    /// where the joint stands at the start of the analysis step.
    pub angle: f64,
    /// Name of the amplitude, of whose change the motion is a multiple.
    pub amplitude: String,
}

/// A prescribed displacement along an axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DrivenLengthJoint {
    /// Name of the joint in messages and results.
    pub name: String,
    /// Both sides: names of bodies, of sets with one node or of sets of elements (the point of one of them), or `ground`.
    pub between: [String; 2],
    /// Point of both sides in the reference configuration (length).
    #[schemars(extend("x-marker" = "point"))]
    pub at: [f64; 3],
    /// Direction of the axis in the reference configuration; it is fixed in the first side.
    #[schemars(extend("x-marker" = "direction"))]
    pub axis: [f64; 3],
    /// Displacement of the second side relative to the first one along the axis per unit of the amplitude (length). It begins where the
    /// joint stands at the start of the analysis step.
    pub length: f64,
    /// Name of the amplitude, of whose change the motion is a multiple.
    pub amplitude: String,
}

/// A constant distance of two points.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DistanceJoint {
    /// Name of the joint in messages and results.
    pub name: String,
    /// Both sides: names of bodies, of sets with one node or of sets of elements (the point of one of them), or `ground`.
    pub between: [String; 2],
    /// Point of the first and point of the second one, in the reference configuration (length).
    #[schemars(extend("x-marker" = "point"))]
    pub points: [[f64; 3]; 2],
}

impl JointKeys for CoordinateJoint {
    fn name(&self) -> &str {
        &self.name
    }

    fn between(&self) -> &[String; 2] {
        &self.between
    }

    fn directions(&self) -> Vec<(&'static str, [f64; 3])> {
        vec![("axis", self.axis)]
    }

    fn points(&self) -> Vec<(&'static str, [f64; 3])> {
        vec![("at", self.at)]
    }

    fn second_side(&self) -> SecondSide {
        SecondSide { at: self.second_at, axis: self.second_axis }
    }

    fn friction(&self) -> Option<&JointFriction> {
        self.friction.as_ref()
    }

    fn stops(&self) -> Option<&JointStops> {
        self.stops.as_ref()
    }
}

/// Implements [`JointKeys`] for keys with `name`, `between` and these points and directions.
macro_rules! joint_keys {
    ($keys:ident, $self:ident, [$($point:expr),*], [$($direction:expr),*] $(, drive $drive:expr)? $(, second $second:expr)?) => {
        impl JointKeys for $keys {
            fn name(&self) -> &str {
                &self.name
            }

            fn between(&self) -> &[String; 2] {
                &self.between
            }

            fn directions(&$self) -> Vec<(&'static str, [f64; 3])> {
                vec![$($direction),*]
            }

            fn points(&$self) -> Vec<(&'static str, [f64; 3])> {
                vec![$($point),*]
            }

            $(fn drive(&$self) -> Option<JointDrive<'_>> {
                Some($drive)
            })?

            $(fn second_side(&$self) -> SecondSide {
                $second
            })?
        }
    };
}
joint_keys!(PointJoint, self, [("at", self.at)], [], second SecondSide { at: self.second_at, axis: None });
joint_keys!(
    AxisJoint,
    self,
    [("at", self.at)],
    [("axis", self.axis)],
    second SecondSide { at: self.second_at, axis: self.second_axis }
);
joint_keys!(
    ScrewJoint,
    self,
    [("at", self.at)],
    [("axis", self.axis)],
    second SecondSide { at: self.second_at, axis: self.second_axis }
);
joint_keys!(RackJoint, self, [("at", self.at)], [("axis", self.axis), ("direction", self.direction)]);
joint_keys!(
    TwoAxesJoint,
    self,
    [("at", self.at)],
    [("axes[0]", self.axes[0]), ("axes[1]", self.axes[1])],
    second SecondSide { at: self.second_at, axis: None }
);
joint_keys!(DirectorJoint, self, [], []);
joint_keys!(
    DrivenAngleJoint,
    self,
    [],
    [("axis", self.axis)],
    drive JointDrive {
        key: "angle",
        given: self.angle,
        value: self.angle.to_radians(),
        amplitude: &self.amplitude
    }
);
joint_keys!(
    DrivenLengthJoint,
    self,
    [("at", self.at)],
    [("axis", self.axis)],
    drive JointDrive { key: "length", given: self.length, value: self.length, amplitude: &self.amplitude }
);
joint_keys!(DistanceJoint, self, [("points[0]", self.points[0]), ("points[1]", self.points[1])], []);

/// Amplitude of the driven joints of the contract tests.
pub const DRIVE: &str = "drive";

/// Sides, point and axis of the joints of the contract tests.
pub(super) const EXAMPLE: ([&str; 2], [f64; 3], [f64; 3]) = (["a", "b"], [0.6, 0.1, -0.2], [1.0, 2.0, 2.0]);

impl PointJoint {
    pub(crate) fn example() -> Self {
        let (between, at, _) = EXAMPLE;
        Self { name: "joint".into(), between: between.map(str::to_owned), at, second_at: None }
    }
}

/// Node of the shell of the contract tests, and its position.
const NODE: (&str, [f64; 3]) = ("u_max_v_min", [2.0, 0.0, 0.0]);

impl PointJoint {
    pub(crate) fn example_at_node() -> Self {
        Self { name: "joint".into(), between: ["b", NODE.0].map(str::to_owned), at: NODE.1, second_at: None }
    }
}

impl DirectorJoint {
    pub(crate) fn example() -> Self {
        Self { name: "joint".into(), between: ["b", NODE.0].map(str::to_owned) }
    }
}

impl AxisJoint {
    pub(crate) fn example() -> Self {
        let (between, at, axis) = EXAMPLE;
        Self {
            name: "joint".into(),
            between: between.map(str::to_owned),
            at,
            axis,
            second_at: None,
            second_axis: None,
        }
    }
}

impl ScrewJoint {
    pub(crate) fn example() -> Self {
        let (between, at, axis) = EXAMPLE;
        Self {
            name: "joint".into(),
            between: between.map(str::to_owned),
            at,
            axis,
            second_at: None,
            second_axis: None,
            pitch: 0.8,
        }
    }
}

impl RackJoint {
    pub(crate) fn example() -> Self {
        let (between, at, axis) = EXAMPLE;
        let direction = crate::Vec3::from(axis).cross(&crate::Vec3::z());
        let between = between.map(str::to_owned);
        Self { name: "joint".into(), between, at, axis, direction: direction.into(), radius: 0.4 }
    }
}

impl CoordinateJoint {
    pub(crate) fn example() -> Self {
        AxisJoint::example().into()
    }
}

impl TwoAxesJoint {
    pub(crate) fn example() -> Self {
        let (between, at, axis) = EXAMPLE;
        let axes = [axis, [2.0, 1.0, -2.0]];
        Self { name: "joint".into(), between: between.map(str::to_owned), at, axes, second_at: None }
    }
}

impl DrivenAngleJoint {
    pub(crate) fn example() -> Self {
        let (between, _, axis) = EXAMPLE;
        let amplitude = DRIVE.into();
        Self { name: "joint".into(), between: between.map(str::to_owned), axis, angle: 90.0, amplitude }
    }
}

impl DrivenLengthJoint {
    pub(crate) fn example() -> Self {
        let (between, at, axis) = EXAMPLE;
        let amplitude = DRIVE.into();
        Self { name: "joint".into(), between: between.map(str::to_owned), at, axis, length: 0.5, amplitude }
    }
}

impl DistanceJoint {
    pub(crate) fn example() -> Self {
        let (between, at, _) = EXAMPLE;
        Self { name: "joint".into(), between: between.map(str::to_owned), points: [at, [1.0, 0.4, 0.0]] }
    }
}
