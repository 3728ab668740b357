//! Supports and prescribed motions: which components of the nodal vectors each kind constrains.
//!
//! A support is one file of this folder and one line in the registry at the end of this file. A file may bring keys of its
//! own; the keys of `condition.rs` serve several supports.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Axis, FixComponents, NodalVector, OnSet, PrescribeComponent, SymmetryPlane};
use crate::Vec3;
use crate::checker::Checker;

/// Axes of space.
pub(crate) const AXES: [Vec3; 3] =
    [Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.0, 1.0, 0.0), Vec3::new(0.0, 0.0, 1.0)];

/// Nodal vectors of a node that a support holds, by their numbers.
pub(crate) struct SupportedNode<'a> {
    /// Position; none for orphan nodes.
    pub(crate) position: &'a [u32],
    /// Directors: several where sheets meet at an angle.
    pub(crate) directors: &'a [u32],
    /// Gradients along the surface, two for each director (`ancf-full` only).
    pub(crate) gradients: &'a [u32],
    /// Reference values of all nodal vectors of the model.
    pub(crate) reference: &'a [[f64; 3]],
}

/// Direction in which a nodal vector is constrained.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Direction {
    /// Along a unit vector.
    Along(Vec3),
    /// Both directions across a unit vector.
    Across(Vec3),
}

/// Mistake of a support that the mesh reveals: key of the support, message, help.
pub(crate) type Refusal = (&'static str, &'static str, &'static str);

/// Constraints of a support at a node.
#[derive(Debug, Default)]
pub(crate) struct Constraints {
    /// Nodal vector, direction, prescribed change (`None`: fixed), in the order in which they were added.
    pub(crate) list: Vec<(u32, Direction, Option<f64>)>,
    /// First mistake at this node.
    pub(crate) refusal: Option<Refusal>,
}

impl Constraints {
    /// Fixes the component of nodal vectors along a unit vector.
    pub(crate) fn fix(&mut self, vectors: &[u32], direction: Vec3) {
        self.list.extend(vectors.iter().map(|&v| (v, Direction::Along(direction), None)));
    }

    /// Fixes the components of nodal vectors across a unit vector.
    pub(crate) fn fix_across(&mut self, vectors: &[u32], normal: Vec3) {
        self.list.extend(vectors.iter().map(|&v| (v, Direction::Across(normal), None)));
    }

    /// Prescribes the change of the component of nodal vectors along a unit vector, times the amplitude of the support.
    pub(crate) fn prescribe(&mut self, vectors: &[u32], direction: Vec3, change: f64) {
        self.list.extend(vectors.iter().map(|&v| (v, Direction::Along(direction), Some(change))));
    }

    /// Refuses the support at this node.
    pub(crate) fn refuse(&mut self, refusal: Refusal) {
        self.refusal.get_or_insert(refusal);
    }
}

/// Motion that a support prescribes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PrescribedMotion<'a> {
    /// Nodal vector that moves.
    pub(crate) of: NodalVector,
    /// Component that is prescribed.
    pub(crate) component: Axis,
    /// Change of the component at amplitude 1 [length, or none for directors].
    pub(crate) value: f64,
    /// Name of the amplitude.
    pub(crate) amplitude: &'a Option<String>,
}

/// Keys of a support that all supports have.
pub(crate) trait SupportKeys {
    /// Name of the node or edge set.
    fn on(&self) -> &str;
    /// Motion that the support prescribes; `None` where it fixes.
    fn motion(&self) -> Option<PrescribedMotion<'_>> {
        None
    }
}

/// Kind of support.
pub(crate) trait SupportKind {
    /// Keys in the model file.
    type Keys: SupportKeys;
    /// Adds the mistakes in the values; `key` is the path of the support in the model file.
    fn check(_keys: &Self::Keys, _key: &str, _checker: &mut Checker) {}
    /// Adds the mistakes that the reference positions of the nodes (at least one) reveal, in a model of the size `extent`
    /// (length); `key` is the path of the set in the model file.
    fn check_nodes(_keys: &Self::Keys, _key: &str, _nodes: &[Vec3], _extent: f64, _checker: &mut Checker) {}
    /// Constrains a node of the set.
    fn constrain(keys: &Self::Keys, node: &SupportedNode, out: &mut Constraints);
    /// Support with valid values on the set `u_min`, an edge of a plate along the y axis, on which the contract of all
    /// supports is tested.
    fn example() -> Self::Keys;
}

impl Condition {
    /// Name of the set it acts on.
    pub fn on(&self) -> &str {
        self.keys().on()
    }

    /// Motion that the condition prescribes; `None` where it fixes.
    pub(crate) fn motion(&self) -> Option<PrescribedMotion<'_>> {
        self.keys().motion()
    }
}

impl SupportKeys for OnSet {
    fn on(&self) -> &str {
        &self.on
    }
}

/// Makes [`Condition`] from the registry. An entry is
///
/// ```text
/// file::Kind(Keys): "help of the schema",
/// ```
///
/// - `file.rs` of this folder defines the type `Kind`, which implements [`SupportKind`]; `mod` comes from here, too;
/// - `Kind` becomes the variant of [`Condition`] that holds the `Keys`, and its name in kebab case the word of the model file.
macro_rules! supports {
    ($($file:ident::$kind:ident($keys:ty): $help:literal,)*) => {
        $(mod $file;)*

        /// A support or a prescribed motion.
        #[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(tag = "type", rename_all = "kebab-case")]
        pub enum Condition {
            $(#[doc = $help] $kind($keys),)*
        }

        impl Condition {
            fn keys(&self) -> &dyn SupportKeys {
                match self {
                    $(Self::$kind(keys) => keys,)*
                }
            }

            /// Adds the mistakes in the values.
            pub(crate) fn check(&self, key: &str, checker: &mut Checker) {
                match self {
                    $(Self::$kind(keys) => $file::$kind::check(keys, key, checker),)*
                }
            }

            /// Adds the mistakes that the positions of the nodes reveal.
            pub(crate) fn check_nodes(&self, key: &str, nodes: &[Vec3], extent: f64, checker: &mut Checker) {
                match self {
                    $(Self::$kind(keys) => $file::$kind::check_nodes(keys, key, nodes, extent, checker),)*
                }
            }

            /// Constrains a node of the set.
            pub(crate) fn constrain(&self, node: &SupportedNode, out: &mut Constraints) {
                match self {
                    $(Self::$kind(keys) => $file::$kind::constrain(keys, node, out),)*
                }
            }

            /// One valid condition of each kind on the set `u_min`, in the order of the registry: the contract of all supports
            /// is tested on them.
            pub fn examples() -> Vec<Self> {
                vec![$(Self::$kind($file::$kind::example())),*]
            }
        }
    };
}

// The registry: one line for each support.
supports! {
    clamp::Clamp(OnSet): "Positions and directors fixed: no displacement, no rotation.",
    hinge::Hinge(OnSet): "Positions fixed along an edge, rotation about it free.",
    spherical::Spherical(OnSet): "Positions fixed, directors free: a ball joint to the ground.",
    symmetry::Symmetry(SymmetryPlane): "Symmetry plane: position and director do not move along its normal.",
    fix::Fix(FixComponents): "Chosen components of position and director fixed.",
    prescribe::Prescribe(PrescribeComponent): "One component of position or director prescribed as a function of time.",
}
