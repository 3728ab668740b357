//! Sparse symmetric linear algebra: multifrontal LDLᵀ factorisation, block Lanczos and GMRES.
//!
//! [`SparseLdlt`] is a direct solver for sparse symmetric matrices, definite or indefinite. The symbolic factorisation
//! depends on the pattern alone and is computed once; every matrix of the pattern then needs the numeric part only. The
//! flow is ordering → supernodes → assembly tree → numeric factorisation → solve:
//!
//! - `ordering`, `minimum_degree`: compressed graph of supervariables (indistinguishable unknowns) and approximate
//!   minimum degree.
//! - `supernodes`: elimination tree, fundamental supernodes, relaxed amalgamation and the postorder that minimises the
//!   contribution-block stack.
//! - `assembly_tree`, `entry_map`: fronts with fully summed columns, relative indices and the entry-to-front map.
//! - `multifrontal`, `numeric`: assembly of original entries, extend-add of contribution blocks, choice of the pivoting
//!   strategy.
//! - `partial_factorization`, `trapezoid`, [`dense`]: blocked partial factorisation of a front by Cholesky of
//!   diagonal blocks, triangular solves (TRSM) and Schur updates (SYRK, GEMM).
//! - `rook_pivoting`, `delayed_pivots`: 1×1 and 2×2 pivots for indefinite matrices, the inertia, threshold pivoting
//!   with growth check and delayed columns.
//! - `schedule`, `workspace`: tree-level and node-level parallelism, bitwise identical results for any number of
//!   threads, and a [`Workspace`] whose pool of buffers has a low-memory mode.
//! - `substitution`, `block_column`, `right_sides`: forward and backward substitution, with one right side or with
//!   groups of 16, for which every entry of the factor is read once.
//! - `schur_complement`: [`SchurComplement`] on an interface, which is ordered last and assembled in the last front, but
//!   not eliminated. Many small matrices may share a workspace.
//!
//! [`lanczos`] finds the largest eigenvalues of a symmetric operator, for instance of a shifted and inverted stiffness
//! matrix; [`gmres`] solves systems and finds eigenvalues of operators `I + B`; [`norm`] has norms that propagate NaN.
//!
//! ```
//! use tegula_sparse::{Factor, FactorError, SparseLdlt, SymmetricPattern};
//!
//! // Lower triangle of [[2, −1, 0], [−1, 2, −1], [0, −1, 2]] in compressed columns, the diagonal entry first.
//! let pattern = SymmetricPattern::new(vec![0_usize, 2, 4, 5], vec![0, 1, 1, 2, 2]);
//! let mut ldlt = SparseLdlt::new(&pattern)?;
//! let inertia = ldlt.factor(&[2.0, -1.0, 2.0, -1.0, 2.0])?;
//! assert_eq!((inertia.positive, inertia.negative), (3, 0));
//!
//! let mut x = [1.0, 0.0, 1.0];
//! ldlt.solve(&mut x);
//! assert!(x.iter().all(|x| (x - 1.0_f64).abs() < 1e-14));
//! # Ok::<(), FactorError>(())
//! ```

mod assembly_tree;
mod block_column;
mod delayed_pivots;
pub mod dense;
mod eigenvalues;
mod entry_map;
pub mod gmres;
pub mod lanczos;
mod ldlt;
mod minimum_degree;
mod multifrontal;
pub mod norm;
mod numeric;
mod ordering;
mod partial_factorization;
mod right_sides;
mod rook_pivoting;
mod schedule;
mod schur_complement;
mod substitution;
mod supernodes;
mod trapezoid;
mod workspace;

pub use eigenvalues::eigenvalues;
pub use ldlt::{SparseLdlt, SymmetricPattern};
pub use schur_complement::SchurComplement;
pub use workspace::{Workspace, zeros};

/// Inertia of a symmetric matrix: the signs of the pivots of its factorisation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Inertia {
    /// Number of positive pivots.
    pub positive: usize,
    /// Number of negative pivots: eigenvalues below zero.
    pub negative: usize,
    /// Number of pivots that are exactly zero or not a number.
    pub zero: usize,
}

/// Direct solver for symmetric matrices of one pattern: analysed once, factored often.
pub trait Factor: Send {
    /// Factors the matrix with the given values of the pattern's lower triangle. Positive definite matrices take the
    /// fast path, Cholesky without pivoting; the inertia tells whether the matrix was definite.
    ///
    /// # Errors
    /// The matrix is singular to working precision, or holds values that are not numbers.
    fn factor(&mut self, values: &[f64]) -> Result<Inertia, FactorError>;
    /// Solves `A x = b` with the last factor, in place of `right_side`.
    fn solve(&mut self, right_side: &mut [f64]);
    /// Number of factorisations so far.
    fn factorizations(&self) -> usize;
    /// Number of stored entries of the factor.
    fn factor_entries(&self) -> usize;
    /// Solves `A X = B` with the last factor, in place of the `count` right sides: columns of length n, one after another (n × `count`, column-major).
    fn solve_many(&mut self, right_sides: &mut [f64], count: usize) {
        let size = (right_sides.len() / count.max(1)).max(1);
        right_sides.chunks_mut(size).for_each(|x| self.solve(x));
    }
    /// Frees the memory of the factor; the next factorisation allocates it again.
    fn release(&mut self) {}
}

/// Direct method for symmetric matrices: it analyses patterns, and gives the solvers of their matrices.
pub trait DirectMethod: std::fmt::Debug + Send + Sync {
    /// Orders and analyses a pattern (symbolic factorisation).
    ///
    /// # Errors
    /// The factor would be too large.
    fn analyse(&self, pattern: &SymmetricPattern) -> Result<Box<dyn Factor>, FactorError>;
}

/// Error of a factorisation.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum FactorError {
    /// An entry of the matrix is not a number.
    #[error("the matrix holds values that are not numbers")]
    NotFinite,
    /// A pivot vanished: the matrix is singular to working precision.
    #[error("the matrix is singular")]
    Singular,
    /// The factor is too large to index or to store.
    #[error("the factor does not fit in memory")]
    TooLarge,
    /// Error of another library.
    #[error("{0}")]
    Other(String),
}
