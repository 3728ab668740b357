//! Kind of analysis for which a system is compiled.

use super::System;
use crate::load::LoadParameter;
use crate::{Error, Result};

/// Kind of analysis for which a system is compiled: it decides how loads without amplitude develop, whether masses are
/// lumped, and whether the sparsity pattern of a tangent is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Procedure {
    /// Static equilibrium by a direct solver.
    Static,
    /// Static equilibrium by the iterative solver, which takes element matrices.
    IterativeStatic,
    /// Equilibrium path.
    Path,
    /// Natural frequencies.
    Modal,
    /// Linear buckling.
    Buckling,
    /// Motion by an implicit scheme.
    Transient,
    /// Motion by an explicit scheme.
    Explicit,
}

impl Procedure {
    /// Independent variable of the loads.
    pub fn parameter(self) -> LoadParameter {
        match self {
            Self::Static | Self::IterativeStatic | Self::Modal | Self::Buckling => LoadParameter::LoadFactor,
            Self::Path => LoadParameter::PathFactor,
            Self::Transient | Self::Explicit => LoadParameter::Time,
        }
    }

    /// Whether the system needs the sparsity pattern of its tangent.
    pub fn has_tangent_pattern(self) -> bool {
        matches!(self, Self::Static | Self::Path | Self::Modal | Self::Buckling | Self::Transient)
    }

    /// Name in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Static => "static analysis",
            Self::IterativeStatic => "static analysis with the iterative linear solver",
            Self::Path => "path analysis",
            Self::Modal => "modal analysis",
            Self::Buckling => "buckling analysis",
            Self::Transient => "transient analysis with an implicit scheme",
            Self::Explicit => "transient analysis with an explicit scheme",
        }
    }
}

impl System {
    /// Refuses an analysis that needs a tangent, where the system was compiled without the sparsity pattern of one.
    ///
    /// # Errors
    /// The system was compiled for explicit steps, or for statics with the iterative solver.
    pub fn require_tangent(&self) -> Result<()> {
        self.require(if self.procedure.has_tangent_pattern() { &[] } else { &[Procedure::Static] })
    }

    /// Refuses an analysis for which the system was not compiled: its loads would develop in another way.
    ///
    /// # Errors
    /// The system was compiled for none of the `wanted` kinds of analysis.
    pub fn require(&self, wanted: &[Procedure]) -> Result<()> {
        match wanted {
            [first, ..] if !wanted.contains(&self.procedure) => Err(Error::model(
                "analysis",
                format!(
                    "the system was compiled for a {}, not for a {}",
                    self.procedure.name(),
                    first.name()
                ),
                "compile the model with the analysis, the scheme and the linear solver that it is run with",
            )),
            _ => Ok(()),
        }
    }
}
