//! Kind of analysis for which a system is compiled.

use crate::model::{Analysis, ExplicitScheme, LinearSolver, Scheme, TransientAnalysis};
use crate::system::Procedure;

/// Kind of analysis for which a system has to be compiled.
pub(super) fn procedure(analysis: &Analysis) -> Procedure {
    match analysis {
        Analysis::Static(s) if s.continuation.is_some() => Procedure::Path,
        Analysis::Static(s) if s.linear_solver == LinearSolver::Iterative => Procedure::IterativeStatic,
        Analysis::Static(_) => Procedure::Static,
        Analysis::Path(_) => Procedure::Path,
        Analysis::Modal(_) => Procedure::Modal,
        Analysis::Buckling(_) => Procedure::Buckling,
        Analysis::Transient(t) if t.scheme.is_explicit() => Procedure::Explicit,
        Analysis::Transient(_) => Procedure::Transient,
    }
}

/// Scheme of an explicit analysis.
pub(super) fn explicit_scheme(analysis: &Analysis) -> Option<ExplicitScheme> {
    match analysis {
        Analysis::Transient(TransientAnalysis { scheme: Scheme::Explicit(scheme), .. }) => Some(*scheme),
        _ => None,
    }
}
