//! Runs on several processes (ranks) of MPI, with the direct solver MUMPS through PETSc.
//!
//! Every rank holds the model and goes through the analysis in step with all others; the tangent is distributed by rows, factored by all ranks together, and the
//! solution is given to each of them, to the last bit the same. So all decisions are those of every rank.
//!
//! P. R. Amestoy, I. S. Duff, J.-Y. L'Excellent, J. Koster, *A fully asynchronous multifrontal solver using distributed dynamic scheduling*, SIAM J. Matrix Anal.
//! Appl. 23 (2001) 15–41 (MUMPS); S. Balay et al., *PETSc/TAO users manual*, Argonne National Laboratory ANL-21/39.

#![cfg(feature = "link")]

mod communicator;
mod mumps;
mod shim;

pub use communicator::{Communicator, is_launched};
pub use mumps::Mumps;

/// Error of MPI or PETSc.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct PetscError(String);
