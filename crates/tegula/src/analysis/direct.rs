//! Direct solvers of the linear systems of Newton's method: the program's own, or one of the caller for the whole process.

use std::sync::{Arc, OnceLock};

use super::lagged_tangent;
use super::solver::{Linearization, SINGULAR, TangentSolver};
use crate::element::Nodal;
use crate::system::{Assembly, System};
use crate::{Error, Result};
use tegula_sparse::{DirectMethod, Factor, FactorError, Inertia, SparseLdlt};

/// Direct method of the caller.
static METHOD: OnceLock<Arc<dyn DirectMethod>> = OnceLock::new();

/// Lets a direct method of the caller factor all tangents of this process from now on, such as one in which several processes take part. When tangents are
/// reused, and all else, stays as with the program's own.
///
/// # Errors
/// The process has one already, which is given back.
pub fn solve_by(method: Arc<dyn DirectMethod>) -> std::result::Result<(), Arc<dyn DirectMethod>> {
    METHOD.set(method)
}

/// Direct solver of a system: the program's own, or that of [`solve_by`].
pub enum Direct {
    /// Sparse LDLᵀ factorisation of the program.
    Own(Box<SparseLdlt>),
    /// Factorisation of the caller.
    Other(OtherFactor),
}

/// Factorisation of the caller, whose cost is that of the program's own: when a tangent is reused does not depend on it.
pub struct OtherFactor {
    factor: Box<dyn Factor>,
    operations: f64,
    entries: usize,
}

impl Direct {
    /// Analyses the pattern of the tangent.
    ///
    /// # Errors
    /// The factor does not fit in memory, or the system was compiled without a sparsity pattern of the tangent.
    pub fn new(system: &System) -> Result<Self> {
        system.require_tangent()?;
        let pattern = system.tangent_pattern();
        let own = SparseLdlt::new(&pattern);
        let solver = match METHOD.get() {
            None => own.map(|own| Self::Own(Box::new(own))),
            Some(method) => own.and_then(|own| {
                let (operations, entries) = (own.operations(), own.factor_entries());
                drop(own);
                Ok(Self::Other(OtherFactor { factor: method.analyse(&pattern)?, operations, entries }))
            }),
        };
        solver.map_err(|e| Error::Singular {
            what: format!("The matrix of {} unknowns cannot be factored: {e}.", system.unknowns()),
            help: "Use a coarser mesh, a machine with more memory, or in statics `linear_solver = \"iterative\"`."
                .into(),
        })
    }

    fn factor_mut(&mut self) -> &mut dyn Factor {
        match self {
            Self::Own(factor) => &mut **factor,
            Self::Other(other) => &mut *other.factor,
        }
    }

    fn as_factor(&self) -> &dyn Factor {
        match self {
            Self::Own(factor) => &**factor,
            Self::Other(other) => &*other.factor,
        }
    }
}

impl Factor for Direct {
    fn factor(&mut self, values: &[f64]) -> std::result::Result<Inertia, FactorError> {
        self.factor_mut().factor(values)
    }

    fn solve(&mut self, right_side: &mut [f64]) {
        self.factor_mut().solve(right_side);
    }

    fn factorizations(&self) -> usize {
        self.as_factor().factorizations()
    }

    fn factor_entries(&self) -> usize {
        self.as_factor().factor_entries()
    }

    fn solve_many(&mut self, right_sides: &mut [f64], count: usize) {
        self.factor_mut().solve_many(right_sides, count);
    }

    fn release(&mut self) {
        self.factor_mut().release();
    }
}

impl TangentSolver for Direct {
    fn assemble(&mut self, assembly: &mut Assembly, at: &Linearization, out: &mut [Nodal]) {
        if let Self::Own(own) = self
            && assembly.values.is_empty()
        {
            assembly.values = own.reclaim_values();
        }
        assembly.forces_and_tangent(at.system, at.point, at.parts, at.extrapolated, at.prescribed, out);
    }

    fn add_curvature(&mut self, assembly: &mut Assembly, at: &Linearization, rest: &[Nodal]) {
        assembly.add_curvature(at.system, at.point, &at.parts.weights, rest);
    }

    fn prepare(&mut self, assembly: &mut Assembly) -> std::result::Result<Option<usize>, String> {
        let inertia = match self {
            Self::Own(own) => own.factor_values(&mut assembly.values),
            Self::Other(other) => other.factor.factor(&assembly.values).map(Some),
        };
        let inertia = inertia.map_err(|e| match e {
            FactorError::Singular => SINGULAR.into(),
            e => e.to_string(),
        })?;
        Ok(inertia.map(|i| i.negative))
    }

    fn solve_tangent(&mut self, x: &mut [f64]) -> std::result::Result<(), String> {
        self.solve(x);
        Ok(())
    }

    fn solve_tangents(&mut self, x: &mut [f64], count: usize) -> std::result::Result<(), String> {
        self.solve_many(x, count);
        Ok(())
    }

    fn release(&mut self) {
        Factor::release(self);
    }

    fn price(&self, sizes: [usize; 2]) -> f64 {
        let (operations, entries) = match self {
            Self::Own(own) => (own.operations(), own.factor_entries()),
            Self::Other(other) => (other.operations, other.entries),
        };
        lagged_tangent::cost(operations, entries, sizes)
    }

    fn tangents(&self) -> usize {
        self.factorizations()
    }
}
