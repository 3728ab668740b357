//! Registry of the element types.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The registry: one line for each element type. Calls the macro `$made` with all entries. An entry is
///
/// ```text
/// file::Type as Kind: "help of the schema",
/// ```
///
/// - `crates/tegula/src/element/file.rs` defines `Type`, which implements `ShellElement` and `FromSection`;
/// - `Kind` becomes the variant of [`ElementKind`], and its name in kebab case the word of the model file.
///
/// [`ElementKind`] is made from it below, the modules of the files in `element/mod.rs`, the elements of a section in
/// `element/registry.rs`.
macro_rules! element_types {
    ($made:ident) => {
        $made! {
            ems::EmsShell as Ems: "Shear-deformable bilinear shell of the absolute nodal coordinate formulation, elastic middle surface.",
            cm::CmShell as Cm: "`ems` with three-dimensional stresses integrated over the thickness: continuum mechanics based shell.",
            mitc4::Mitc4 as Mitc4: "Bilinear shell with directors of unit length (MITC4 with enhanced membrane strains).",
            solid_shell::SolidShell as SolidShell: "Eight-node solid shell: positions at the bottom and the top of the thickened mid-surface.",
            ancf_full::AncfFull as AncfFull: "Fully parameterized plate with 48 coordinates; it locks and serves for comparison.",
        }
    };
}
pub(crate) use element_types;

macro_rules! element_kind {
    ($($file:ident::$type:ident as $kind:ident: $help:literal,)*) => {
        /// Element types.
        #[derive(
            Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
        )]
        #[serde(rename_all = "kebab-case")]
        pub enum ElementKind {
            $(#[doc = $help] $kind,)*
        }

        impl ElementKind {
            /// Every element type, in the order of the registry.
            pub const ALL: &[Self] = &[$(Self::$kind),*];
        }
    };
}

element_types!(element_kind);

impl Default for ElementKind {
    fn default() -> Self {
        Self::Ems
    }
}
