//! Materials: their keys in the model file, and their constitutive laws at a point, which give stress and tangent as pure
//! functions of strain and history variables.
//!
//! Strains are Green–Lagrange strains, stresses second Piola–Kirchhoff stresses, in an orthonormal frame of the
//! reference configuration; components are ordered xx, yy, xy, zz, xz, yz with engineering shear strains. The caller
//! passes history variables in and receives the updated ones; nothing is stored here.
//!
//! A material is one file of this folder, with its keys and perhaps its law, and one line in the registry at the end of
//! this file.

pub mod hyperelastic;
pub mod linear;
pub mod plane_stress;
pub mod plasticity;
mod strengths;

use std::fmt::Debug;
use std::sync::Arc;

use nalgebra::{Matrix2, Matrix3, Matrix6, Vector6};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::checker::Checker;
pub use hyperelastic::Hyperelastic;
pub use neo_hookean::NeoHookeanForm;
pub use plane_stress::PlaneStressPlasticity;
pub use plasticity::Plasticity;
pub use strengths::Strengths;

/// Strain xx, yy, 2xy, zz, 2xz, 2yz.
pub type Strain = Vector6<f64>;
/// Stress xx, yy, xy, zz, xz, yz [force/area].
pub type Stress = Vector6<f64>;

/// Tensor indices (row, column) of the six components.
pub(crate) const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (0, 1), (2, 2), (0, 2), (1, 2)];

/// Response of a material: stress, tangent and energies.
#[derive(Debug, Clone, PartialEq)]
pub struct Response {
    /// Second Piola–Kirchhoff stress S.
    pub stress: Stress,
    /// Consistent tangent ∂S/∂E, symmetric.
    pub tangent: Matrix6<f64>,
    /// Stored energy per reference volume.
    pub energy: f64,
    /// Energy dissipated per reference volume since the committed state.
    pub dissipation: f64,
}

/// Law at a material point: stress, tangent and energy of a three-dimensional strain as a pure function of strain and
/// history variables. A law of a caller takes the place of the law of a material of the model
/// ([`Compiler::with_laws`](crate::compile::Compiler::with_laws)).
pub trait MaterialLaw: Debug + Send + Sync {
    /// Number of internal (history) variables, at most 16; all are 0 at the start.
    fn history(&self) -> usize {
        0
    }
    /// Stress, consistent (symmetric) tangent and energies for a strain; `updated` receives the internal variables that
    /// belong to it. `None` where the law cannot be evaluated: the step is then cut back. A zero strain without history
    /// has no stress.
    fn respond(&self, strain: &Strain, committed: &[f64], updated: &mut [f64]) -> Option<Response>;
    /// Equivalent plastic strain among the internal variables, for laws that have one.
    fn plastic_strain(&self, _history: &[f64]) -> Option<f64> {
        None
    }
    /// True for rubber: large elastic strains, for which elements take the membrane part `assumed-shear`.
    fn is_hyperelastic(&self) -> bool {
        false
    }
    /// True for a law without internal variables whose calls cost more than its arithmetic: elements collect the strains of many points for one call of
    /// [`respond_many`](Self::respond_many). Results at single places, as stresses of output, are still asked for by [`respond`](Self::respond).
    fn is_collected(&self) -> bool {
        false
    }
    /// Responses to many strains, of a law without internal variables; as many as there are strains.
    fn respond_many(&self, strains: &[Strain]) -> Vec<Option<Response>> {
        strains.iter().map(|strain| self.respond(strain, &[], &mut [])).collect()
    }
}

/// Shared law of a caller; two are equal if they are the same object.
#[derive(Debug, Clone)]
pub struct OwnLaw(pub Arc<dyn MaterialLaw>);

impl PartialEq for OwnLaw {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl MaterialLaw for OwnLaw {
    fn history(&self) -> usize {
        self.0.history()
    }

    fn respond(&self, strain: &Strain, committed: &[f64], updated: &mut [f64]) -> Option<Response> {
        self.0.respond(strain, committed, updated)
    }

    fn plastic_strain(&self, history: &[f64]) -> Option<f64> {
        self.0.plastic_strain(history)
    }

    fn is_hyperelastic(&self) -> bool {
        self.0.is_hyperelastic()
    }

    fn is_collected(&self) -> bool {
        self.0.is_collected() && self.0.history() == 0
    }

    fn respond_many(&self, strains: &[Strain]) -> Vec<Option<Response>> {
        self.0.respond_many(strains)
    }
}

/// Material of the model file: its keys, the check of their values, and its laws.
pub(crate) trait MaterialKeys {
    /// Word of the model file, for messages.
    fn kind(&self) -> &'static str;
    /// Density [mass/volume].
    fn density(&self) -> f64;
    /// Thermal expansion along the axes of the material [1/temperature].
    fn expansion(&self) -> [f64; 3] {
        [0.0; 3]
    }
    /// Strengths of a ply, where given.
    fn strength(&self) -> Option<Strengths> {
        None
    }
    /// True if stress is proportional to strain: elements then condense the material into a constant stiffness.
    fn is_linear(&self) -> bool {
        false
    }
    /// True if no direction differs from another.
    fn is_isotropic(&self) -> bool {
        true
    }
    /// True if the material dissipates energy by yielding: five integration points over the thickness, displacement-based
    /// Newton, no energy–momentum scheme.
    fn yields(&self) -> bool {
        false
    }
    /// Law of three-dimensional stresses.
    fn law_3d(&self) -> Law;
    /// Law of plane stress for layers that are not linear; `None` where there is none.
    fn law_plane_stress(&self) -> Option<Law> {
        None
    }
    /// Elastic plane stress in the material's axes: reduced stiffness, transverse shear diag(G13, G23) and thickness modulus
    /// E3 [force/area]; `None` for materials without plane stress.
    fn plane_stress(&self) -> Option<(Matrix3<f64>, Matrix2<f64>, f64)> {
        None
    }
    /// Adds the mistakes in the values to an empty checker; `key` is the path of the material in the model file. Density,
    /// expansion and strengths are checked for all materials.
    fn check(&self, key: &str, checker: &mut Checker);
    /// Material with valid values, on which the contract of all materials is tested.
    fn example() -> Self
    where
        Self: Sized;
    /// Size of the strains at which the example is tested.
    fn example_strain(&self) -> f64 {
        0.2
    }
}

/// Checks Poisson's ratio of an isotropic material.
fn check_poisson(key: &str, c: &mut Checker, nu: f64) {
    if !(nu > -1.0 && nu < 0.5) {
        c.add(
            format!("{key}.poisson"),
            format!("Poisson's ratio is {nu}; it must be above -1 and below 0.5"),
            "at 0.5 a material is incompressible and plane stress has no limit here; use 0.49 or less",
        );
    }
}

impl Material {
    /// Word of the model file.
    pub fn kind(&self) -> &'static str {
        self.keys().kind()
    }

    /// Density [mass/volume].
    pub fn density(&self) -> f64 {
        self.keys().density()
    }

    /// Thermal expansion along the axes [1/temperature].
    pub fn expansion(&self) -> [f64; 3] {
        self.keys().expansion()
    }

    /// Strengths, where given.
    pub fn strength(&self) -> Option<Strengths> {
        self.keys().strength()
    }

    /// True if stress is proportional to strain.
    pub fn is_linear(&self) -> bool {
        self.keys().is_linear()
    }

    /// True if no direction differs from another.
    pub fn is_isotropic(&self) -> bool {
        self.keys().is_isotropic()
    }

    /// True if the material dissipates energy by yielding.
    pub fn yields(&self) -> bool {
        self.keys().yields()
    }

    /// Law of three-dimensional stresses.
    pub fn law_3d(&self) -> Law {
        self.keys().law_3d()
    }

    /// Law of plane stress for layers that are not linear; `None` where there is none.
    pub fn law_plane_stress(&self) -> Option<Law> {
        self.keys().law_plane_stress()
    }

    /// Elastic plane stress in the material's axes: reduced stiffness, transverse shear diag(G13, G23), and the modulus
    /// E3 of the thickness [force/area]; `None` for hyperelastic materials.
    pub fn plane_stress(&self) -> Option<(Matrix3<f64>, Matrix2<f64>, f64)> {
        self.keys().plane_stress()
    }

    /// Size of the strains at which the material of [`examples`](Self::examples) is tested.
    pub fn example_strain(&self) -> f64 {
        self.keys().example_strain()
    }
}

impl Law {
    /// True for `S = C E`.
    pub fn is_linear(&self) -> bool {
        matches!(self, Self::Linear(_))
    }
}

/// Makes [`Material`] and [`Law`] from the registry. An entry is
///
/// ```text
/// file::Keys [Variant(Type), …]: "help of the schema",
/// ```
///
/// - `file.rs` of this folder defines `Keys`, which implements [`MaterialKeys`]; `mod` and `pub use` come from here, too;
/// - the keys become the variant `Keys` of [`Material`], and its name in kebab case the word of the model file;
/// - brackets, where there are any, list the laws that the file adds to [`Law`]; each type implements [`MaterialLaw`].
macro_rules! materials {
    ($($file:ident::$keys:ident $([$($law:ident($type:ty)),+])?: $help:literal,)*) => {
        $(
            pub mod $file;
            pub use $file::$keys;
        )*

        /// A material.
        #[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(tag = "type", rename_all = "kebab-case")]
        pub enum Material {
            $(#[doc = $help] $keys($keys),)*
        }

        impl Material {
            fn keys(&self) -> &dyn MaterialKeys {
                match self {
                    $(Self::$keys(keys) => keys,)*
                }
            }

            /// Adds the mistakes in the material's own values to an empty checker.
            pub(crate) fn check(&self, key: &str, checker: &mut Checker) {
                self.keys().check(key, checker);
            }

            /// One valid material of each kind, in the order of the registry: the contract of all materials is tested on them.
            pub fn examples() -> Vec<Self> {
                vec![$(Self::$keys($keys::example())),*]
            }
        }

        laws! {
            Linear(Box<Matrix6<f64>>): "Linear elastic (St. Venant–Kirchhoff): `S = C E`.",
            $($($($law($type): concat!("Law of the material [`", stringify!($keys), "`]."),)+)?)*
            Own(OwnLaw): "Law of a caller.",
        }
    };
}

/// Makes [`Law`] with static dispatch, because laws are evaluated at every integration point in every iteration.
macro_rules! laws {
    ($($law:ident($type:ty): $help:expr,)*) => {
        /// Material law.
        #[derive(Debug, Clone, PartialEq)]
        pub enum Law {
            $(#[doc = $help] $law($type),)*
        }

        impl Law {
            /// Number of internal (history) variables.
            pub fn history(&self) -> usize {
                match self {
                    $(Self::$law(law) => law.history(),)*
                }
            }

            /// Stress, tangent and energies for a strain; `updated` receives the internal variables that belong to it.
            /// `None` where the law cannot be evaluated: `C = 1 + 2E` is not positive definite, or the return mapping does
            /// not converge.
            pub fn respond(&self, strain: &Strain, committed: &[f64], updated: &mut [f64]) -> Option<Response> {
                match self {
                    $(Self::$law(law) => MaterialLaw::respond(law, strain, committed, updated),)*
                }
            }

            /// Equivalent plastic strain among the internal variables, for laws that have one.
            pub fn plastic_strain(&self, history: &[f64]) -> Option<f64> {
                match self {
                    $(Self::$law(law) => law.plastic_strain(history),)*
                }
            }

            /// True for rubber: large elastic strains.
            pub fn is_hyperelastic(&self) -> bool {
                match self {
                    $(Self::$law(law) => law.is_hyperelastic(),)*
                }
            }

            /// True for laws that are evaluated at many points in one call.
            pub fn is_collected(&self) -> bool {
                matches!(self, Self::Own(law) if law.is_collected())
            }

            /// Responses to many strains, of a law without internal variables.
            pub fn respond_many(&self, strains: &[Strain]) -> Vec<Option<Response>> {
                match self {
                    $(Self::$law(law) => MaterialLaw::respond_many(law, strains),)*
                }
            }
        }
    };
}

// The registry: one line for each material.
materials! {
    isotropic::Isotropic: "Isotropic linear elastic (St. Venant–Kirchhoff).",
    orthotropic::Orthotropic: "Orthotropic linear elastic, such as a fibre-reinforced ply.",
    neo_hookean::NeoHookean [Hyperelastic(Hyperelastic)]: "Hyperelastic, neo-Hooke; for `cm` and `solid-shell`.",
    mooney_rivlin::MooneyRivlin: "Hyperelastic, Mooney–Rivlin; for `cm` and `solid-shell`.",
    plastic::Plastic [Plastic(Plasticity), PlaneStressPlastic(PlaneStressPlasticity)]: "Plastic with von Mises' yield condition; small strains, any rotation.",
}

/// Symmetric tensor from stress-like components (no factor 2 on shears).
pub(crate) fn tensor(v: &Vector6<f64>) -> Matrix3<f64> {
    Matrix3::new(v[0], v[2], v[4], v[2], v[1], v[5], v[4], v[5], v[3])
}

/// Stress-like components of a symmetric tensor.
pub(crate) fn components(m: &Matrix3<f64>) -> Vector6<f64> {
    Vector6::from_fn(|i, _| m[PAIRS[i]])
}
