//! Loads: what each kind does to the nodes of the model.
//!
//! A load is one file of this folder and one line in the registry at the end of this file. A file may bring keys of its own;
//! the keys here serve several loads.

use std::collections::BTreeMap;
use std::fmt::Debug;
use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{CentrifugalLoad, Distribution, GravityLoad, PressureLoad, VectorLoad};
use crate::{Mat3, Vec3};

/// Load stiffness: blocks `−∂f_a/∂x_b` of a follower load.
pub type LoadStiffness = [[Mat3; 4]; 4];

/// Load on up to four nodal vectors (positions and directors), as a function of their present values: a spring to the
/// ground, a magnet, a contact force. A caller hands it to
/// [`Compiler::add_load`](crate::compile::Compiler::add_load), a load of the model file to its actions.
pub trait NodalLoad: Debug + Send + Sync {
    /// Nodal vectors on which the load acts, one to four different ones.
    fn vectors(&self) -> &[u32];
    /// Forces on the nodal vectors at their present values `x`.
    fn forces(&self, x: &[Vec3], out: &mut [[f64; 3]]);
    /// Blocks −∂f_a/∂x_b at `x`; those of unused places are zero. It need not be symmetric.
    fn stiffness(&self, x: &[Vec3]) -> LoadStiffness;
}

/// Part of the mesh on which a load acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LoadedPart {
    /// Nodes of a set.
    Nodes,
    /// Edges of a set.
    Edges,
    /// Quads of a set.
    Quads,
    /// The whole model; the load names no set.
    Model,
}

/// Mesh as loads see it: sets, reference positions, nodal vectors.
pub trait LoadedMesh {
    /// Nodes of a set.
    fn nodes(&self, set: &str) -> Vec<u32>;
    /// Quads of a set, by their nodes.
    fn quads(&self, set: &str) -> Vec<[u32; 4]>;
    /// Factor φ of the distribution of the load at a node; 1 where it has none.
    fn factor(&self, node: u32) -> f64;
    /// Means of the factor φ over quads, given by their nodes.
    fn mean_factors(&self, quads: &[[u32; 4]]) -> Vec<f64>;
    /// Integral ∫N_a φ ds over an edge set with the factor φ of the distribution: the length that each of its nodes stands for (length).
    fn lengths(&self, set: &str) -> BTreeMap<u32, f64>;
    /// Integral ∫N_a φ dA over a quad set: the area that each of its nodes stands for (length²).
    fn areas(&self, set: &str) -> BTreeMap<u32, f64>;
    /// Nodal vectors of the position and of the first director of a node.
    fn vectors(&self, node: u32) -> [u32; 2];
}

/// Action of a load at factor 1.
#[derive(Debug, Clone)]
pub enum Action {
    /// Force on a node, constant in space.
    Force {
        /// Node.
        node: u32,
        /// Force (force).
        force: Vec3,
    },
    /// Acceleration on all masses [length/time²].
    Gravity(Vec3),
    /// Centrifugal forces on all masses, in a frame that turns with the model.
    Centrifugal {
        /// Direction of the axis; of length 1, or zero where the model gives none.
        axis: Vec3,
        /// Point of the axis (length).
        at: Vec3,
        /// Angular velocity [rad/time].
        velocity: f64,
        /// Whether supports and the ground turn with the model.
        with_ground: bool,
    },
    /// Moment on the first director of a node, constant in space (force·length).
    Moment {
        /// Node.
        node: u32,
        /// Moment (force·length).
        moment: Vec3,
    },
    /// Moment per length on all edges of a set, constant in space, which the distribution of the load multiplies (force).
    EdgeMoment {
        /// Edge set.
        set: String,
        /// Moment per length (force).
        moment: Vec3,
    },
    /// Pressure that follows a quad [force/area].
    Pressure {
        /// Nodes of the quad.
        quad: [u32; 4],
        /// Pressure [force/area].
        pressure: f64,
    },
    /// Force on a node that turns with it.
    FollowerForce {
        /// Node.
        node: u32,
        /// Force in the reference configuration (force).
        force: Vec3,
    },
    /// Moment on a node that turns with it (force·length).
    FollowerMoment {
        /// Node.
        node: u32,
        /// Moment in the reference configuration (force·length).
        moment: Vec3,
    },
    /// Any other load that follows the motion.
    Follower(Arc<dyn NodalLoad>),
}

/// Keys of a load that all loads have.
pub trait LoadKeys {
    /// Name of the set; empty for loads on the whole model.
    fn on(&self) -> &str;
    /// Values, which have to be finite; a load all of whose values are 0 does nothing.
    fn values(&self) -> &[f64];
    /// Factor on the value in each place.
    fn distribution(&self) -> Option<&Distribution> {
        None
    }
    /// Name of the amplitude.
    fn amplitude(&self) -> &Option<String>;
    /// The key of the amplitude, to be changed.
    fn amplitude_mut(&mut self) -> &mut Option<String>;
}

/// Kind of load.
pub trait LoadKind {
    /// Keys in the model file.
    type Keys: LoadKeys;
    /// Word of the model file; reactions and histories name the load by it.
    const WORD: &'static str;
    /// Part of the mesh on which the load acts.
    const PART: LoadedPart;
    /// True if the load acts on masses, so that the model must have some.
    const NEEDS_MASS: bool = false;
    /// Actions at factor 1.
    fn actions(keys: &Self::Keys, mesh: &dyn LoadedMesh) -> Vec<Action>;
    /// Load with valid values on the sets `u_max` or `all`, on which the contract of all loads is tested.
    fn example() -> Self::Keys;
}

impl Load {
    /// Name of the set on which the load acts; empty for loads on the whole model.
    pub fn on(&self) -> &str {
        self.keys().on()
    }

    /// Name of the amplitude.
    pub fn amplitude(&self) -> &Option<String> {
        self.keys().amplitude()
    }

    /// Factor on the values in each place; `None` where it is 1.
    pub fn distribution(&self) -> Option<&Distribution> {
        self.keys().distribution()
    }

    /// Values of the load at factor 1, in the units of its kind.
    pub fn values(&self) -> &[f64] {
        self.keys().values()
    }

    /// Load without its amplitude.
    pub fn without_amplitude(&self) -> Self {
        let mut bare = self.clone();
        *bare.keys_mut().amplitude_mut() = None;
        bare
    }
}

impl LoadKeys for VectorLoad {
    fn on(&self) -> &str {
        &self.on
    }

    fn values(&self) -> &[f64] {
        &self.value
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

/// Makes [`Load`] from the registry. An entry is
///
/// ```text
/// file::Kind(Keys): "help of the schema",
/// ```
///
/// - `file.rs` of this folder defines the type `Kind`, which implements [`LoadKind`]; `mod` comes from here, too;
/// - `Kind` becomes the variant of [`Load`] that holds the `Keys`, and its name in kebab case the word of the model file.
macro_rules! loads {
    ($($file:ident::$kind:ident($keys:ty): $help:literal,)*) => {
        $(pub mod $file;)*

        /// A load.
        #[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(tag = "type", rename_all = "kebab-case")]
        pub enum Load {
            $(#[doc = $help] $kind($keys),)*
        }

        impl Load {
            fn keys(&self) -> &dyn LoadKeys {
                match self {
                    $(Self::$kind(keys) => keys,)*
                }
            }

            fn keys_mut(&mut self) -> &mut dyn LoadKeys {
                match self {
                    $(Self::$kind(keys) => keys,)*
                }
            }

            /// Word of the model file.
            pub fn kind(&self) -> &'static str {
                match self {
                    $(Self::$kind(_) => $file::$kind::WORD,)*
                }
            }

            /// Part of the mesh on which the load acts.
            pub fn part(&self) -> LoadedPart {
                match self {
                    $(Self::$kind(_) => $file::$kind::PART,)*
                }
            }

            /// True if the load acts on masses.
            pub fn needs_mass(&self) -> bool {
                match self {
                    $(Self::$kind(_) => $file::$kind::NEEDS_MASS,)*
                }
            }

            /// Actions at factor 1.
            pub fn actions(&self, mesh: &dyn LoadedMesh) -> Vec<Action> {
                match self {
                    $(Self::$kind(keys) => $file::$kind::actions(keys, mesh),)*
                }
            }

            /// One valid load of each kind on the sets `u_max` or `all`, in the order of the registry: the contract of all
            /// loads is tested on them.
            pub fn examples() -> Vec<Self> {
                vec![$(Self::$kind($file::$kind::example())),*]
            }
        }
    };
}

// The registry: one line for each load.
loads! {
    force::Force(VectorLoad): "A force on every node of a set.",
    moment::Moment(VectorLoad): "A moment on every node of a set; it rotates the director and stays constant in space. Its drilling component\n(along the director) is dropped, but on nodes that are attached to a body, which takes all components.",
    follower_force::FollowerForce(VectorLoad): "A force on every node of a set, or on a body, that turns with it; its components are those in the reference configuration.",
    follower_moment::FollowerMoment(VectorLoad): "A moment on every node of a set, or on a body, that turns with it; its components are those in the reference configuration.",
    edge::Edge(VectorLoad): "A force per length of an edge.",
    edge_moment::EdgeMoment(VectorLoad): "A moment per length of an edge, constant in space with all components.",
    traction::Traction(VectorLoad): "A force per reference area, constant in direction.",
    pressure::Pressure(PressureLoad): "A pressure that follows the surface; positive pushes against the director.",
    gravity::Gravity(GravityLoad): "Gravity on all masses.",
    centrifugal::Centrifugal(CentrifugalLoad): "Centrifugal forces on all masses of a model that turns at a constant angular velocity, for static and modal\nanalyses in the frame that turns with it.",
}
