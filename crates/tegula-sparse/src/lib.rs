//! Sparse symmetric linear algebra: multifrontal LDLᵀ factorisation, block Lanczos, GMRES.

mod assembly_tree;
mod block_column;
mod delayed_pivots;
mod diagonal_block;
mod entry_map;
pub mod gmres;
pub mod lanczos;
mod ldlt;
mod multifrontal;
pub mod norm;
mod numeric;
mod ordering;
mod partial_factorization;
mod rook_pivoting;
mod schedule;
mod substitution;
mod supernodes;
mod trapezoid;
mod workspace;

pub use ldlt::{SparseLdlt, SymmetricPattern};
pub use workspace::zeros;

/// Signs of the pivots of a symmetric factorisation: the inertia of the matrix.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Inertia {
    /// Positive pivots.
    pub positive: usize,
    /// Negative pivots: eigenvalues below zero.
    pub negative: usize,
    /// BlockPivots that are exactly zero or not a number.
    pub zero: usize,
}

/// A direct solver for symmetric matrices of one pattern: analysed once, factored often.
pub trait Factor: Send {
    /// Factors the matrix with the given values of the pattern's lower triangle.
    /// Positive definite matrices take the fast path; the inertia tells what the matrix was.
    ///
    /// # Errors
    /// The matrix is singular to working precision, or holds values that are not numbers.
    fn factor(&mut self, values: &[f64]) -> Result<Inertia, FactorError>;
    /// Solves in place with the last factor.
    fn solve(&mut self, right_side: &mut [f64]);
    /// Number of factorisations so far.
    fn factorizations(&self) -> usize;
    /// Stored entries of the factor.
    fn factor_entries(&self) -> usize;
}

/// A factorisation that failed.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum FactorError {
    /// An entry of the matrix is not a number.
    #[error("the matrix holds values that are not numbers")]
    NotFinite,
    /// A pivot vanished.
    #[error("the matrix is singular")]
    Singular,
    /// Too large to index or to store.
    #[error("the factor does not fit in memory")]
    TooLarge,
}
