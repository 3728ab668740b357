//! Sparse factorisation of symmetric matrices.
//!
//! Ordering and symbolic analysis are made once for the pattern of a model and serve all iterations and steps. A
//! positive definite matrix is factored by the [multifrontal method](super::multifrontal). One that turns out
//! indefinite is factored again by faer as LBLᵀ with Bunch–Kaufman pivots inside the supernodes, which also gives
//! its inertia; what that needs is only made then.

use dyn_stack::{MemBuffer, MemStack};
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, IntranodeLbltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat};
use faer::{Conj, MatMut, Par, Side};

use super::multifrontal::Multifrontal;
use super::{Factor, FactorError, Inertia};

/// Lower triangle of a symmetric matrix in compressed columns, without its values.
#[derive(Debug, Clone)]
pub struct SymmetricPattern {
    symbolic: SymbolicSparseColMat<usize>,
}

impl SymmetricPattern {
    /// From column pointers and row numbers (ascending within a column, none above the diagonal).
    pub fn new(column_pointers: Vec<usize>, row_indices: Vec<usize>) -> Self {
        let n = column_pointers.len() - 1;
        Self { symbolic: SymbolicSparseColMat::new_checked(n, n, column_pointers, None, row_indices) }
    }

    /// Number of rows.
    pub fn size(&self) -> usize {
        self.symbolic.nrows()
    }

    /// Stored entries.
    pub fn entries(&self) -> usize {
        self.symbolic.row_idx().len()
    }

    /// Diagonal of the matrix with these values.
    pub fn diagonal<'a>(&'a self, values: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        self.symbolic.col_ptr()[..self.size()].iter().map(move |&p| values[p])
    }

    /// `y += A x`.
    pub fn add_product(&self, values: &[f64], x: &[f64], y: &mut [f64]) {
        let (pointers, rows) = (self.symbolic.col_ptr(), self.symbolic.row_idx());
        for j in 0..self.size() {
            for k in pointers[j]..pointers[j + 1] {
                let i = rows[k];
                y[i] += values[k] * x[j];
                if i != j {
                    y[j] += values[k] * x[i];
                }
            }
        }
    }
}

enum Kind {
    None,
    Definite,
    Indefinite,
}

/// Sparse Cholesky factorisation of matrices of one pattern.
pub struct SparseCholesky {
    pattern: SymmetricPattern,
    definite: Multifrontal,
    /// Made once a matrix was indefinite.
    indefinite: Option<Indefinite>,
    kind: Kind,
    factorizations: usize,
}

impl SparseCholesky {
    /// Orders and analyses a pattern.
    ///
    /// # Errors
    /// The factor would be too large.
    pub fn new(pattern: SymmetricPattern) -> Result<Self, FactorError> {
        let definite = Multifrontal::new(pattern.symbolic.col_ptr(), pattern.symbolic.row_idx())?;
        Ok(Self { pattern, definite, indefinite: None, kind: Kind::None, factorizations: 0 })
    }

    /// The pattern.
    pub fn pattern(&self) -> &SymmetricPattern {
        &self.pattern
    }
}

impl Factor for SparseCholesky {
    fn factor(&mut self, values: &[f64]) -> Result<Inertia, FactorError> {
        self.kind = Kind::None;
        if !values.iter().all(|v| v.is_finite()) {
            return Err(FactorError::NotFinite);
        }
        self.factorizations += 1;
        if self.definite.factor(values).is_ok() {
            self.kind = Kind::Definite;
            return Ok(Inertia { positive: self.pattern.size(), ..Default::default() });
        }
        self.factorizations += 1;
        let indefinite = match &mut self.indefinite {
            Some(made) => made,
            none => none.insert(Indefinite::new(&self.pattern)?),
        };
        let inertia = indefinite.factor(&self.pattern, values)?;
        self.kind = Kind::Indefinite;
        Ok(inertia)
    }

    fn solve(&mut self, right_side: &mut [f64]) {
        match (&self.kind, &mut self.indefinite) {
            (Kind::Definite, _) => self.definite.solve(right_side),
            (Kind::Indefinite, Some(factor)) => factor.solve(right_side),
            // Without a factor there is no solution; what is returned must not look like one.
            _ => right_side.fill(f64::NAN),
        }
    }

    fn factorizations(&self) -> usize {
        self.factorizations
    }

    fn factor_entries(&self) -> usize {
        self.definite.entries()
    }
}

// faer's own threading made factorisation slower on shell matrices: its supernodes run one after another.
const PAR: Par = Par::Seq;

/// LBLᵀ with Bunch–Kaufman pivots inside the supernodes.
struct Indefinite {
    symbolic: SymbolicCholesky<usize>,
    factor: Vec<f64>,
    subdiagonal: Vec<f64>,
    permutation: (Vec<usize>, Vec<usize>),
    memory: MemBuffer,
}

impl Indefinite {
    fn new(pattern: &SymmetricPattern) -> Result<Self, FactorError> {
        let symbolic = factorize_symbolic_cholesky(
            pattern.symbolic.as_ref(),
            Side::Lower,
            SymmetricOrdering::Amd,
            CholeskySymbolicParams::default(),
        )
        .map_err(|_| FactorError::TooLarge)?;
        let request = symbolic
            .factorize_numeric_intranode_lblt_scratch::<f64>(PAR, Default::default())
            .or(symbolic.solve_in_place_scratch::<f64>(1, PAR));
        let memory = MemBuffer::try_new(request).map_err(|_| FactorError::TooLarge)?;
        let mut factor = Vec::new();
        factor.try_reserve_exact(symbolic.len_val()).map_err(|_| FactorError::TooLarge)?;
        factor.resize(symbolic.len_val(), 0.0);
        let n = pattern.size();
        Ok(Self {
            symbolic,
            factor,
            subdiagonal: vec![0.0; n],
            permutation: (vec![0; n], vec![0; n]),
            memory,
        })
    }

    fn factor(&mut self, pattern: &SymmetricPattern, values: &[f64]) -> Result<Inertia, FactorError> {
        self.subdiagonal.fill(0.0);
        self.symbolic.factorize_numeric_intranode_lblt(
            &mut self.factor,
            &mut self.subdiagonal,
            &mut self.permutation.0,
            &mut self.permutation.1,
            SparseColMatRef::new(pattern.symbolic.as_ref(), values),
            Side::Lower,
            PAR,
            MemStack::new(&mut self.memory),
            Default::default(),
        );
        let inertia = self.inertia(pattern.size());
        if inertia.zero > 0 || !self.factor.iter().all(|v| v.is_finite()) {
            return Err(FactorError::Singular);
        }
        Ok(inertia)
    }

    fn solve(&mut self, right_side: &mut [f64]) {
        let n = right_side.len();
        let (forward, inverse) = (&self.permutation.0, &self.permutation.1);
        let permutation = faer::perm::PermRef::new_checked(forward, inverse, n);
        IntranodeLbltRef::new(&self.symbolic, &self.factor, &self.subdiagonal, permutation)
            .solve_in_place_with_conj(
                Conj::No,
                MatMut::from_column_major_slice_mut(right_side, n, 1),
                PAR,
                MemStack::new(&mut self.memory),
            );
    }

    fn inertia(&self, n: usize) -> Inertia {
        let mut out = Inertia::default();
        let mut count = |d: f64| {
            if d > 0.0 {
                out.positive += 1;
            } else if d < 0.0 {
                out.negative += 1;
            } else {
                out.zero += 1;
            }
        };
        let diagonal = self.block_diagonal(n);
        let mut i = 0;
        while i < diagonal.len() {
            let e = self.subdiagonal.get(i).copied().unwrap_or(0.0);
            if e == 0.0 || i + 1 == diagonal.len() {
                count(diagonal[i]);
                i += 1;
            } else {
                let (a, c) = (diagonal[i], diagonal[i + 1]);
                let (mean, radius) = (0.5 * (a + c), (0.25 * (a - c) * (a - c) + e * e).sqrt());
                count(mean - radius);
                count(mean + radius);
                i += 2;
            }
        }
        out
    }

    fn block_diagonal(&self, n: usize) -> Vec<f64> {
        let mut out = vec![0.0; n];
        match self.symbolic.raw() {
            SymbolicCholeskyRaw::Simplicial(s) => {
                for (j, d) in out.iter_mut().enumerate() {
                    *d = self.factor[s.col_ptr()[j]];
                }
            }
            SymbolicCholeskyRaw::Supernodal(s) => {
                let l = faer::sparse::linalg::cholesky::supernodal::SupernodalLltRef::new(s, &self.factor);
                for node in 0..s.n_supernodes() {
                    let block = l.supernode(node);
                    for j in 0..block.val().ncols() {
                        out[block.start() + j] = block.val()[(j, j)];
                    }
                }
            }
        }
        out
    }
}
