//! Schur complement of the interior of a symmetric matrix on an interface of some of its unknowns; inertia by
//! Haynsworth's formula.
//!
//! The [multifrontal method](super::multifrontal) leaves it behind if the interface is ordered last and not eliminated:
//! the last front assembles the entries of the interface and the contribution blocks of the interior, which are all
//! Schur updates. Kernels, parallelism and pivoting are those of [`SparseLdlt`].

use super::{Factor, FactorError, Inertia, SparseLdlt, SymmetricPattern, Workspace, zeros};

/// Schur complement `S = A_ΓΓ − A_ΓI A_II⁻¹ A_IΓ` of symmetric matrices of one pattern on an interface Γ, and the factor
/// of the interior, `A_II`, by which the unknowns of the interior are eliminated and found again.
///
/// A system `A u = f` is solved in three steps, of which the middle one is left to the caller:
/// [`condense`](Self::condense), the solution of `S u_Γ = g`, [`expand`](Self::expand). Domain decomposition methods
/// hold one such object for each subdomain ([`sequential`](Self::sequential)) and solve for all interfaces together. The
/// functions with a [`Workspace`] keep only the symbolic factorisation and the factor of the interior in it; the
/// subdomains that a thread works on share the rest.
///
/// ```
/// use tegula_sparse::{FactorError, SchurComplement, SymmetricPattern};
///
/// // Lower triangle of [[2, −1, 0], [−1, 2, −1], [0, −1, 2]]; the interface is the first and the last unknown.
/// let pattern = SymmetricPattern::new(vec![0_usize, 2, 4, 5], vec![0, 1, 1, 2, 2]);
/// let mut schur = SchurComplement::new(&pattern, &[0, 2])?;
/// let inertia = schur.factor(&[2.0, -1.0, 2.0, -1.0, 2.0])?;
/// assert_eq!((inertia.positive, inertia.negative), (1, 0));
/// let exact = [1.5, -0.5, -0.5, 1.5];
/// assert!(schur.matrix().iter().zip(exact).all(|(s, exact)| (s - exact).abs() < 1e-15));
///
/// let mut x = [1.0, 0.0, 1.0];
/// schur.condense(&mut x);
/// (x[0], x[2]) = (1.0, 1.0); // the solution of S u = [1, 1]
/// schur.expand(&mut x);
/// assert!((x[1] - 1.0).abs() < 1e-14);
/// # Ok::<(), FactorError>(())
/// ```
pub struct SchurComplement {
    ldlt: SparseLdlt,
    /// Number of unknowns of the interface.
    size: usize,
    /// Unknowns of the interface, ascending, and the row of the Schur complement of each.
    places: Vec<(u32, u32)>,
    /// Schur complement, both triangles; NaN if there is no factor, empty before the first one.
    matrix: Vec<f64>,
}

impl SchurComplement {
    /// Orders and analyses a pattern for an interface, whose unknowns may be given in any order. That is the order of
    /// the rows of the Schur complement. The interface may be empty or hold all unknowns.
    ///
    /// # Errors
    /// The factor or the Schur complement would be too large.
    ///
    /// # Panics
    /// An unknown of the interface is not one of the pattern, or is given twice.
    pub fn new(pattern: &SymmetricPattern, interface: &[u32]) -> Result<Self, FactorError> {
        Self::analyse(pattern, interface, false)
    }

    /// Like [`new`](Self::new), for one of many small matrices that are factored in parallel: the calling thread alone
    /// factors and solves, without rayon. The results are bitwise those of `new`.
    ///
    /// # Errors
    /// The factor or the Schur complement would be too large.
    ///
    /// # Panics
    /// An unknown of the interface is not one of the pattern, or is given twice.
    pub fn sequential(pattern: &SymmetricPattern, interface: &[u32]) -> Result<Self, FactorError> {
        Self::analyse(pattern, interface, true)
    }

    fn analyse(pattern: &SymmetricPattern, interface: &[u32], sequential: bool) -> Result<Self, FactorError> {
        let size = interface.len();
        let mut places: Vec<(u32, u32)> = interface.iter().copied().zip(0..).collect();
        places.sort_unstable();
        assert!(places.windows(2).all(|pair| pair[0].0 < pair[1].0), "an unknown is given twice");
        let last = places.last().map(|(unknown, _)| *unknown as usize);
        assert!(last.is_none_or(|last| last < pattern.size()), "the pattern has no unknown {last:?}");
        size.checked_mul(size).ok_or(FactorError::TooLarge)?;
        let ldlt = SparseLdlt::with_interface(pattern, interface, sequential)?;
        Ok(Self { ldlt, size, places, matrix: Vec::new() })
    }

    /// Factors `A_II` and computes the Schur complement of the matrix with the given values of the pattern's lower
    /// triangle. Returns the inertia of `A_II`; with that of S it is the inertia of A (Haynsworth).
    ///
    /// # Errors
    /// `A_II` is singular to working precision, the matrix holds values that are not numbers, or the memory does not
    /// suffice. The Schur complement is NaN then.
    pub fn factor(&mut self, values: &[f64]) -> Result<Inertia, FactorError> {
        let m = self.size;
        let mut matrix = std::mem::take(&mut self.matrix);
        if matrix.len() < m * m {
            matrix = zeros(m * m)?;
        }
        let inertia = self.ldlt.factor(values);
        self.copy_to(&mut matrix);
        for j in 0..m {
            for i in j + 1..m {
                matrix[i * m + j] = matrix[j * m + i];
            }
        }
        self.matrix = matrix;
        inertia
    }

    /// Factors a matrix whose interior is expected to be positive definite, in a workspace of the caller. The lower
    /// triangle of S is written to `matrix`, a square matrix by columns whose entries above the diagonal are left as they
    /// are; no copy of S is kept.
    ///
    /// There is no growth check, and no column is delayed: if the inertia shows negative pivots, the interior is
    /// indefinite, but S and the factor may be inaccurate. The results do not depend on the matrices factored before.
    ///
    /// # Errors
    /// The errors of [`factor`](Self::factor). The lower triangle of `matrix` is NaN then.
    ///
    /// # Panics
    /// The matrix has fewer entries than S.
    pub fn factor_definite(
        &mut self,
        values: &[f64],
        matrix: &mut [f64],
        workspace: &mut Workspace,
    ) -> Result<Inertia, FactorError> {
        self.matrix = Vec::new();
        self.with(workspace, |own| {
            let inertia = own.ldlt.factor_definite(values);
            own.copy_to(matrix);
            inertia
        })
    }

    /// Writes the lower triangle of S to `matrix`, or NaN without a factor.
    fn copy_to(&mut self, matrix: &mut [f64]) {
        let m = self.size;
        let Self { ldlt, places, .. } = self;
        let place = |unknown: u32| {
            let k = places.partition_point(|(other, _)| *other < unknown);
            places[k].1 as usize
        };
        match ldlt.fronts() {
            Some(fronts) => fronts.copy_schur_complement(matrix, place),
            None => (0..m).for_each(|j| matrix[j * m + j..(j + 1) * m].fill(f64::NAN)),
        }
    }

    /// Calls `work` while the workspace is that of the caller.
    fn with<T>(&mut self, workspace: &mut Workspace, work: impl FnOnce(&mut Self) -> T) -> T {
        std::mem::swap(self.ldlt.workspace(), workspace);
        let done = work(self);
        std::mem::swap(self.ldlt.workspace(), workspace);
        done
    }

    /// Frees the factor; the next factorisation allocates it again.
    pub fn release(&mut self) {
        self.ldlt.release();
        self.matrix = Vec::new();
    }

    /// Schur complement S of the last [`factor`](Self::factor): a dense square matrix by columns, both triangles, its
    /// rows in the order of the interface. All entries are NaN if the factorisation failed; it is empty if there was
    /// none, or one [in a workspace of the caller](Self::factor_definite).
    pub fn matrix(&self) -> &[f64] {
        &self.matrix
    }

    /// Number of unknowns of the interface, the order of S.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Condensation of a right side f of all unknowns, in place: the interface gets `g = f_Γ − A_ΓI A_II⁻¹ f_I`, the
    /// right side of `S u_Γ = g`. The interior gets the result of the forward substitution, `L⁻¹ f_I` in the order of the
    /// pivots, which serves for [`expand`](Self::expand) only. All entries are NaN without a factor.
    ///
    /// # Panics
    /// The right side is shorter than the number of unknowns.
    pub fn condense(&mut self, right_side: &mut [f64]) {
        let done = self.ldlt.fronts().is_some_and(|fronts| fronts.condense(right_side).is_ok());
        if !done {
            right_side.fill(f64::NAN);
        }
    }

    /// Condenses like [`condense`](Self::condense), in a workspace of the caller.
    ///
    /// # Panics
    /// The right side is shorter than the number of unknowns.
    pub fn condense_with(&mut self, right_side: &mut [f64], workspace: &mut Workspace) {
        self.with(workspace, |own| own.condense(right_side));
    }

    /// Expansion of a solution `u_Γ` of the interface, in place: the interior gets `u_I = A_II⁻¹ (f_I − A_IΓ u_Γ)`. On
    /// entry it holds the result of [`condense`](Self::condense), or zeros for `f_I = 0` (the discrete harmonic
    /// extension of `u_Γ`). With `u_Γ = 0` this is the solution of `A_II u_I = f_I`. All entries are NaN without a
    /// factor.
    ///
    /// # Panics
    /// The vector is shorter than the number of unknowns.
    pub fn expand(&mut self, vector: &mut [f64]) {
        let done = self.ldlt.fronts().is_some_and(|fronts| fronts.expand(vector).is_ok());
        if !done {
            vector.fill(f64::NAN);
        }
    }

    /// Expands like [`expand`](Self::expand), in a workspace of the caller.
    ///
    /// # Panics
    /// The vector is shorter than the number of unknowns.
    pub fn expand_with(&mut self, vector: &mut [f64], workspace: &mut Workspace) {
        self.with(workspace, |own| own.expand(vector));
    }

    /// Number of factorisations so far.
    pub fn factorizations(&self) -> usize {
        self.ldlt.factorizations()
    }

    /// Number of stored entries of the factor and of the front of the interface.
    pub fn factor_entries(&self) -> usize {
        self.ldlt.factor_entries()
    }

    /// Number of operations (additions and multiplications) of a factorisation.
    pub fn operations(&self) -> f64 {
        self.ldlt.operations()
    }
}
