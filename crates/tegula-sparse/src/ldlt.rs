//! Sparse LDLᵀ factorisation of symmetric matrices.
//!
//! Ordering and symbolic factorisation are computed once for the pattern of a model and serve all iterations and steps.
//! Matrices are factored by the [multifrontal method](super::multifrontal). Diagonal blocks that turn out not to be
//! positive definite are factored with [rook pivoting](super::rook_pivoting), which also gives the inertia.

use std::sync::Arc;

use super::multifrontal::{Attempt, Multifrontal, Values};
use super::workspace::Workspace;
use super::{Factor, FactorError, Inertia};

/// Sparsity pattern of a symmetric matrix: its lower triangle in compressed columns, without values.
#[derive(Debug, Clone)]
pub struct SymmetricPattern {
    pointers: Arc<Vec<usize>>,
    rows: Vec<u32>,
}

impl SymmetricPattern {
    /// Creates the pattern from column pointers and row numbers (ascending within a column, the first on the diagonal).
    pub fn new(column_pointers: impl Into<Arc<Vec<usize>>>, rows: Vec<u32>) -> Self {
        let pointers = column_pointers.into();
        debug_assert_eq!(pointers.last(), Some(&rows.len()));
        Self { pointers, rows }
    }

    /// Number of rows of the matrix.
    pub fn size(&self) -> usize {
        self.pointers.len() - 1
    }

    /// Column pointers and row numbers of the lower triangle.
    pub fn columns(&self) -> (&[usize], &[u32]) {
        (&self.pointers, &self.rows)
    }

    /// Diagonal of the matrix with these values.
    pub fn diagonal<'a>(&'a self, values: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        self.pointers[..self.size()].iter().map(move |&p| values[p])
    }

    /// Matrix–vector product `y += A x` with the matrix of these values.
    pub fn add_product(&self, values: &[f64], x: &[f64], y: &mut [f64]) {
        for j in 0..self.size() {
            for k in self.pointers[j]..self.pointers[j + 1] {
                let i = self.rows[k] as usize;
                y[i] += values[k] * x[j];
                if i != j {
                    y[j] += values[k] * x[i];
                }
            }
        }
    }
}

/// Sparse LDLᵀ factorisation of symmetric matrices of one pattern, by the multifrontal method.
pub struct SparseLdlt {
    /// Column pointers: index of the first value of each column, which is on the diagonal.
    pointers: Arc<Vec<usize>>,
    fronts: Multifrontal,
    /// Whether there is a factor to solve with.
    factored: bool,
    factorizations: usize,
}

impl SparseLdlt {
    /// Orders and analyses a pattern (symbolic factorisation).
    ///
    /// # Errors
    /// The factor would be too large.
    pub fn new(pattern: &SymmetricPattern) -> Result<Self, FactorError> {
        Self::with_interface(pattern, &[], false)
    }

    /// Orders and analyses a pattern whose unknowns of the `interface` are not eliminated. If it is `sequential`, the
    /// calling thread alone factors and solves.
    pub(super) fn with_interface(
        pattern: &SymmetricPattern,
        interface: &[u32],
        sequential: bool,
    ) -> Result<Self, FactorError> {
        let fronts = Multifrontal::new(&pattern.pointers, &pattern.rows, interface, sequential)?;
        Ok(Self { pointers: pattern.pointers.clone(), fronts, factored: false, factorizations: 0 })
    }

    /// Frees the memory of the factor; the next factorisation allocates it again.
    pub fn release(&mut self) {
        self.factored = false;
        self.fronts.release();
    }

    /// Factors the matrix with these values and takes their memory, which becomes part of the factor. If it returns
    /// `None`, another attempt is necessary: the values are needed once more, in other memory.
    ///
    /// # Errors
    /// The errors of [`factor`](Factor::factor).
    pub fn factor_values(&mut self, values: &mut Vec<f64>) -> Result<Option<Inertia>, FactorError> {
        check_finite(values)?;
        self.attempt(Values::Owned(std::mem::take(values)))
    }

    /// Discards the factor and returns the memory taken by [`factor_values`](Self::factor_values), or an empty vector.
    pub fn reclaim_values(&mut self) -> Vec<f64> {
        self.factored = false;
        self.fronts.reclaim_values()
    }

    fn attempt(&mut self, values: Values) -> Result<Option<Inertia>, FactorError> {
        self.factored = false;
        let outcome = self.fronts.factor(&self.pointers, values);
        let judged = matches!(outcome, Ok((_, false)));
        self.factorizations += usize::from(!judged);
        Ok(match outcome?.0 {
            Attempt::Done(inertia) => {
                self.factored = true;
                Some(inertia)
            }
            Attempt::Again => None,
        })
    }

    /// Solves `A X = B` with the last factor, in place of the `count` right sides: columns of length n, one after
    /// another (n × `count`, column-major). Every entry of the factor is read once for 16 right sides, which makes many
    /// right sides much faster than a [`solve`](Factor::solve) for each, whose time is that of reading the factor.
    ///
    /// The solution of a right side is bitwise the same for any number of threads and whichever right sides stand beside
    /// it. It equals that of `solve` to rounding only, because the sums have another order. Without a factor all
    /// solutions are NaN.
    ///
    /// The workspace, 16 numbers for every unknown and for every row of a front, is kept for the next call.
    ///
    /// # Panics
    /// `right_sides` does not have n · `count` entries.
    pub fn solve_many(&mut self, right_sides: &mut [f64], count: usize) {
        let size = (self.pointers.len() - 1).checked_mul(count);
        assert_eq!(Some(right_sides.len()), size, "{count} right sides have another size");
        if !self.factored || self.fronts.solve_many(right_sides).is_err() {
            // Without a factor there is no solution, and the result must not look like one.
            right_sides.fill(f64::NAN);
        }
    }

    /// Factors a matrix that is expected to be positive definite, without growth check and delayed columns.
    pub(super) fn factor_definite(&mut self, values: &[f64]) -> Result<Inertia, FactorError> {
        self.factored = false;
        check_finite(values)?;
        self.factorizations += 1;
        let inertia = self.fronts.factor_definite(values)?;
        self.factored = true;
        Ok(inertia)
    }

    /// Workspace of factorisations and solutions.
    pub(super) fn workspace(&mut self) -> &mut Workspace {
        &mut self.fronts.workspace
    }

    /// Multifrontal factor, if there is one to solve with.
    pub(super) fn fronts(&mut self) -> Option<&mut Multifrontal> {
        Some(&mut self.fronts).filter(|_| self.factored)
    }

    /// Number of operations (additions and multiplications) of a factorisation.
    pub fn operations(&self) -> f64 {
        self.fronts.operations()
    }
}

impl Factor for SparseLdlt {
    fn factor(&mut self, values: &[f64]) -> Result<Inertia, FactorError> {
        self.factored = false;
        check_finite(values)?;
        loop {
            if let Some(inertia) = self.attempt(Values::Borrowed(values))? {
                return Ok(inertia);
            }
        }
    }

    fn solve(&mut self, right_side: &mut [f64]) {
        if !self.factored || self.fronts.solve(right_side).is_err() {
            // Without a factor there is no solution, and the result must not look like one.
            right_side.fill(f64::NAN);
        }
    }

    fn factorizations(&self) -> usize {
        self.factorizations
    }

    fn factor_entries(&self) -> usize {
        self.fronts.entries()
    }

    fn solve_many(&mut self, right_sides: &mut [f64], count: usize) {
        Self::solve_many(self, right_sides, count);
    }

    fn release(&mut self) {
        Self::release(self);
    }
}

fn check_finite(values: &[f64]) -> Result<(), FactorError> {
    if values.iter().all(|v| v.is_finite()) { Ok(()) } else { Err(FactorError::NotFinite) }
}
