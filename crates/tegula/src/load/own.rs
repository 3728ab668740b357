//! Loads as functions of nodal vectors.

use std::sync::Arc;

use crate::model::NodalLoad;

/// Shared load; two are equal if they are the same object.
#[derive(Debug, Clone)]
pub struct OwnLoad(pub Arc<dyn NodalLoad>);

impl PartialEq for OwnLoad {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}
