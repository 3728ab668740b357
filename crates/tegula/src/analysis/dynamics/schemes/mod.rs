//! Schemes of time integration: their keys in the model file, the check of their values, and their integrators.
//!
//! A scheme is one file of this folder and one line in the registry in `crates/tegula/src/model/scheme.rs`.

use super::Integrator;
use crate::checker::Checker;
use crate::model::{Model, Scheme, TransientAnalysis, schemes};
use crate::system::System;

/// Instant at which the equation of motion of a step holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Instant {
    /// End of the step.
    End,
    /// Between its start and its end: internal, damping and external forces are weighted with this at the start.
    Between(f64),
    /// Middle of the step, with mean stresses (energy–momentum).
    Middle,
}

/// Keys of a scheme, with all that the program asks of them. The default keys are the recommended ones.
pub(crate) trait SchemeKeys: Copy + Default {
    /// Word of the model file.
    const WORD: &'static str;
    /// Adds the mistakes in the values; `key` is the path of the scheme in the model file.
    fn check(&self, _key: &str, _checker: &mut Checker) {}
    /// Adds the mistakes of a model and of the other options that do not go with the scheme; `key` as for [`check`](Self::check).
    fn check_model(&self, _key: &str, _model: &Model, _options: &TransientAnalysis, _checker: &mut Checker) {}
    /// Integrator of the scheme; `None` for explicit ones, which have no equation to solve.
    fn integrator(&self, system: &System) -> Option<Box<dyn Integrator>>;
    /// True for explicit schemes: lumped mass, no tangent.
    fn is_explicit(&self) -> bool {
        false
    }
    /// Instant at which the equation of motion of a step holds.
    fn instant(&self, _system: &System) -> Instant {
        Instant::End
    }
    /// True if the scheme conserves energy, so that it cannot follow materials that dissipate it.
    fn conserves_energy(&self) -> bool {
        false
    }
    /// True if the scheme moves rigid bodies and joints.
    fn moves_bodies(&self) -> bool {
        false
    }
    /// True if positions follow from joints and drives alone: nothing is integrated, and bodies need no mass.
    fn is_kinematic(&self) -> bool {
        false
    }
}

/// Declares the files of the schemes and hands the questions to their keys.
macro_rules! dispatch {
    ($($file:ident::$keys:ident as $kind:ident: $help:literal,)*) => {
        $(pub mod $file;)*

        impl Scheme {
            /// Word of the model file.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$kind(_) => $file::$keys::WORD,)*
                }
            }

            /// Adds the mistakes in the values.
            pub(crate) fn check(self, key: &str, checker: &mut Checker) {
                match self {
                    $(Self::$kind(keys) => keys.check(key, checker),)*
                }
            }

            /// Adds the mistakes of a model and of the other options that do not go with the scheme.
            pub(crate) fn check_model(self, key: &str, model: &Model, options: &TransientAnalysis, checker: &mut Checker) {
                match self {
                    $(Self::$kind(keys) => keys.check_model(key, model, options, checker),)*
                }
            }

            /// Integrator of the scheme; `None` for explicit ones, which have no equation to solve.
            pub fn integrator(self, system: &System) -> Option<Box<dyn Integrator>> {
                match self {
                    $(Self::$kind(keys) => keys.integrator(system),)*
                }
            }

            /// True for explicit schemes: lumped mass, no tangent.
            pub fn is_explicit(self) -> bool {
                match self {
                    $(Self::$kind(keys) => keys.is_explicit(),)*
                }
            }

            /// Instant at which the equation of motion of a step holds.
            pub fn instant(self, system: &System) -> Instant {
                match self {
                    $(Self::$kind(keys) => keys.instant(system),)*
                }
            }

            /// True if the scheme moves rigid bodies and joints.
            pub fn moves_bodies(self) -> bool {
                match self {
                    $(Self::$kind(keys) => keys.moves_bodies(),)*
                }
            }

            /// True if positions follow from joints and drives alone: nothing is integrated, and bodies need no mass.
            pub fn is_kinematic(self) -> bool {
                match self {
                    $(Self::$kind(keys) => keys.is_kinematic(),)*
                }
            }

            /// True if the scheme conserves energy.
            pub fn conserves_energy(self) -> bool {
                match self {
                    $(Self::$kind(keys) => keys.conserves_energy(),)*
                }
            }
        }
    };
}
schemes!(dispatch);
