//! Loads of a caller.

use std::fmt::Debug;
use std::sync::Arc;

use super::follower::LoadStiffness;
use crate::Vec3;
use crate::element::Nodal;

/// Load of a caller on up to four nodal vectors (positions and directors), as a function of their present values: a spring
/// to the ground, a magnet, a contact force
/// ([`Compiler::add_load`](crate::compile::Compiler::add_load)).
pub trait NodalLoad: Debug + Send + Sync {
    /// Nodal vectors on which the load acts, one to four different ones.
    fn vectors(&self) -> &[u32];
    /// Forces on the nodal vectors at their present values `x`.
    fn forces(&self, x: &[Vec3], out: &mut [Nodal]);
    /// Blocks −∂f_a/∂x_b at `x`; those of unused places are zero. It need not be symmetric.
    fn stiffness(&self, x: &[Vec3]) -> LoadStiffness;
}

/// Shared load of a caller; two are equal if they are the same object.
#[derive(Debug, Clone)]
pub struct OwnLoad(pub Arc<dyn NodalLoad>);

impl PartialEq for OwnLoad {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}
