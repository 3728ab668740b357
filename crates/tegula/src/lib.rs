//! Flexible multibody dynamics with thin and moderately thick shells.

pub mod analysis;
pub mod bddc;
pub mod compile;
pub mod element;
pub mod error;
mod lists;
pub mod load;
pub mod material;
pub mod mesh;
pub mod model;
pub mod result;
pub mod section;
pub mod system;

pub use error::{Error, Issue, Place, Result};
pub use mesh::Mesh;
pub use model::Model;
pub use system::System;
pub use tegula_sparse::norm;

/// A vector of three-dimensional space.
pub type Vec3 = nalgebra::Vector3<f64>;
/// A 3×3 matrix.
pub type Mat3 = nalgebra::Matrix3<f64>;
