//! Sections: element type, and material and thickness or the layers of a laminate.
//!
//! A description of layers is one file of this folder and one line in the registry at the end of this file.

mod stacking;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Distribution, ElementKind, Membrane, all, yes};
use crate::checker::is_zero;
use crate::error::Issue;
pub use layup::{LayupPly, StackedPly};

/// Description of the layers of a section, instead of its keys `material` and `thickness`.
pub trait Layers {
    /// Plies from the bottom (against the director) to the top. `key` is the path of the description in the model file, for
    /// messages.
    ///
    /// # Errors
    /// Everything wrong with the values of the description, at their keys. Whether the materials exist is not looked at.
    fn plies(&self, key: &str) -> Result<Vec<StackedPly>, Vec<Issue>>;
    /// Direction of the angle 0° in space, projected on the surface.
    fn direction(&self) -> [f64; 3] {
        [1.0, 0.0, 0.0]
    }
    /// Height of the middle of the layers above the mesh, along the director (length).
    fn offset(&self) -> f64 {
        0.0
    }
    /// Layers of one material, on which the contract of all descriptions is tested.
    fn example(material: &str) -> Self
    where
        Self: Sized;
}

impl Section {
    /// Description of its layers with the key of the model file; `None` for one layer of `material` and `thickness`.
    pub fn layers(&self) -> Option<(&'static str, &dyn Layers)> {
        self.described().into_iter().next()
    }

    /// Height of the middle of its layers above the mesh, along the director (length).
    pub fn offset(&self) -> f64 {
        self.layers().map_or(0.0, |(_, layers)| layers.offset())
    }

    /// Membrane part of its elements where the material is no rubber.
    pub fn membrane_part(&self) -> Membrane {
        match (self.membrane, self.eas) {
            (Some(membrane), _) => membrane,
            (None, true) => Membrane::default(),
            (None, false) => Membrane::Displacement,
        }
    }
}

/// Makes [`Section`] from the registry. An entry is
///
/// ```text
/// key::Keys: "help of the schema",
/// ```
///
/// - `key.rs` of this folder defines `Keys`, which implements [`Layers`]; `mod` and `pub use` come from here, too;
/// - `key` becomes the optional key of a section that holds them.
macro_rules! sections {
    ($($key:ident::$keys:ident: $help:literal,)*) => {
        $(
            mod $key;
            pub use $key::$keys;
        )*

        /// Element type, material and thickness of a part of the mesh.
        #[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields)]
        pub struct Section {
            /// Name of a quad set, or `"all"`.
            #[serde(default = "all")]
            pub on: String,
            /// Element type.
            #[serde(default)]
            pub element: ElementKind,
            /// Name of a material; needed unless there is a `layup`.
            #[serde(default, skip_serializing_if = "String::is_empty")]
            pub material: String,
            /// Thickness h (length), above 0; needed unless there is a `layup`.
            #[serde(default, skip_serializing_if = "is_zero")]
            #[schemars(extend("exclusiveMinimum" = 0))]
            pub thickness: f64,
            /// Factor on the thickness of all layers in each element: the mean over it of a formula in the coordinates `x`, `y` and `z` of the
            /// reference configuration, or of an array of the mesh file, such as `{ field = "t" }`; above 0. Not for `ancf-full`.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub thickness_distribution: Option<Distribution>,
            $(
                #[doc = $help]
                #[serde(default, skip_serializing_if = "Option::is_none")]
                pub $key: Option<$keys>,
            )*
            /// Transverse shear correction factors c_xz, c_yz. Unless given: 5/6 each for one layer, the layup's own for a
            /// laminate, 1 for the elements with three-dimensional stresses (`cm`, `solid-shell`, `ancf-full`).
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub shear_correction: Option<[f64; 2]>,
            /// Coefficient α of stabilised transverse shear: the shear stiffness of an element is multiplied by h²/(h² + α l²), l
            /// its longest edge. 0.1 is usual; makes `ems` and `mitc4` more exact where elements are longer than h.
            #[serde(default, skip_serializing_if = "is_zero")]
            pub shear_stabilization: f64,
            /// Assumed natural strain for transverse shear; off: the element locks when thin.
            #[serde(default = "yes")]
            pub ans_shear: bool,
            /// Assumed natural strain for the thickness; off: curved elements lock.
            #[serde(default = "yes")]
            pub ans_thickness: bool,
            /// Enhanced assumed strain in the plane (4 parameters); off: in-plane bending is too stiff.
            #[serde(default = "yes")]
            pub eas: bool,
            /// Membrane part of the bilinear elements. Unless given: `stable-eas`, for rubber `assumed-shear`, with `eas = false`
            /// `displacement`.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub membrane: Option<Membrane>,
            /// Enhanced parameters of the thickness strain of `cm` and `solid-shell`: 0, 1, 3 or 4; with 0 bending locks, with
            /// 1 distorted meshes fail the bending patch test.
            #[serde(default = "four")]
            pub thickness_eas: u8,
            /// Integration points over the thickness (of each layer): by default 2, and 5 for plastic materials.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub thickness_points: Option<u8>,
            /// Total mass of the section (mass); given, the density is scaled to meet it on the mesh.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            #[schemars(extend("exclusiveMinimum" = 0))]
            pub total_mass: Option<f64>,
            /// Retardation time τ of Kelvin–Voigt damping (time): the stress is that of the strain `ε + τ dε/dt`.
            #[serde(default)]
            #[schemars(range(min = 0.0))]
            pub retardation_time: f64,
        }

        impl Section {
            /// One layer of a material on the whole mesh, with the default element and all remedies.
            pub fn new(material: &str, thickness: f64) -> Self {
                Self {
                    on: all(),
                    element: ElementKind::default(),
                    material: material.into(),
                    thickness,
                    thickness_distribution: None,
                    $($key: None,)*
                    shear_correction: None,
                    shear_stabilization: 0.0,
                    ans_shear: true,
                    ans_thickness: true,
                    eas: true,
                    membrane: None,
                    thickness_eas: four(),
                    thickness_points: None,
                    total_mass: None,
                    retardation_time: 0.0,
                }
            }

            /// Descriptions of its layers, of which there should be one at most, with their keys.
            pub(crate) fn described(&self) -> Vec<(&'static str, &dyn Layers)> {
                let mut found: Vec<(&'static str, &dyn Layers)> = Vec::new();
                $(if let Some(layers) = &self.$key {
                    found.push((stringify!($key), layers));
                })*
                found
            }

            /// One section of each description of layers, of one material: their contract is tested on them.
            pub fn examples(material: &str) -> Vec<Self> {
                vec![$(Self { $key: Some($keys::example(material)), ..Self::new("", 0.0) }),*]
            }
        }
    };
}

// The registry: one line for each description of layers.
sections! {
    layup::Layup: "Plies of a laminate, instead of `material` and `thickness`.",
}

fn four() -> u8 {
    4
}
