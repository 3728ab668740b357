//! Registry of the schemes of time integration.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The registry: one line for each scheme. Calls the macro `$made` with all entries. An entry is
///
/// ```text
/// file::Keys as Kind: "help of the schema",
/// ```
///
/// - `crates/tegula/src/analysis/dynamics/schemes/file.rs` defines the `Keys`, which implement `SchemeKeys`, and perhaps the
///   integrator;
/// - `Kind` becomes the variant of [`Scheme`] that holds the keys, and its name in kebab case the word of the model file.
///
/// [`Scheme`] is made from it below, the modules and the choice of the integrator in
/// `crates/tegula/src/analysis/dynamics/schemes/mod.rs`.
macro_rules! schemes {
    ($made:ident) => {
        $made! {
            newmark::NewmarkScheme as Newmark: "Newmark-β; β = 1/4, γ = 1/2 (trapezoidal rule) unless given.",
            energy_momentum::EnergyMomentumScheme as EnergyMomentum: "Conserves energy and momenta exactly (Simo–Tarnow).",
            hht::HhtScheme as Hht: "Hilber–Hughes–Taylor α method: second order with numerical damping, also with bodies and joints.",
            generalized_alpha::GeneralizedAlphaScheme as GeneralizedAlpha: "Generalised-α method: second order with numerical damping, also with bodies and joints.",
            bdf2::Bdf2Scheme as Bdf2: "Backward differentiation formula of second order: strong numerical damping, for motions that settle.",
            kinematic::KinematicScheme as Kinematic: "Kinematic analysis of rigid bodies: positions from joints and drives alone, forces by inverse dynamics.",
            explicit::ExplicitScheme as Explicit: "Central differences with lumped mass: no equations are solved, steps are small.",
        }
    };
}
pub(crate) use schemes;

macro_rules! scheme {
    ($($file:ident::$keys:ident as $kind:ident: $help:literal,)*) => {
        $(pub use crate::analysis::dynamics::schemes::$file::$keys;)*

        /// Time integration schemes.
        #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(tag = "type", rename_all = "kebab-case")]
        pub enum Scheme {
            $(#[doc = $help] $kind($keys),)*
        }

        impl Scheme {
            /// One scheme of each kind, in the order of the registry: the contract of all schemes is tested on them.
            pub fn examples() -> Vec<Self> {
                vec![$(Self::$kind($keys::default())),*]
            }
        }
    };
}
schemes!(scheme);

impl Default for Scheme {
    fn default() -> Self {
        Self::Newmark(NewmarkScheme::default())
    }
}
