//! Subdomain of a shell: its unknowns, the assembly of its matrix `K`, and the factors on its interface.
//!
//! The interior unknowns are eliminated by [`tegula_sparse::SchurComplement`], which leaves the Schur complement on the
//! interface, `S = K_ΓΓ − K_ΓI K_II⁻¹ K_IΓ`. Its dual unknowns are then eliminated by dense kernels.

use std::ops::Range;

use super::Terms;
use super::assembly::{LocalAssembly, LocalVector, NONE};
use super::schur_complement::{DenseSchurComplement, NotPositive, eliminate};
use crate::system::LocalFrames;
use crate::system::dof_map::CONSTRAINED;
use tegula_sparse::dense::PartialCholesky;
use tegula_sparse::{FactorError, SchurComplement, Workspace};

/// Unknowns of a subdomain and assembly of its matrix, which do not depend on the values of the matrix.
#[derive(Debug)]
pub(super) struct Subdomain {
    /// Number of the subdomain.
    pub number: u32,
    /// Assembly of its matrix, without terms where the subdomain belongs to another rank.
    assembly: LocalAssembly,
    /// Free degree of freedom of each unknown: interior unknowns, then dual unknowns, then primal unknowns.
    pub unknowns: Vec<u32>,
    /// Number of interior unknowns.
    pub inner: usize,
    /// Number of dual unknowns: on the interface, but not primal.
    pub dual: usize,
}

/// Roles of the unknowns of the mesh in a subdomain.
pub(super) struct Roles<'a> {
    pub frames: &'a LocalFrames,
    /// Node of every nodal vector.
    pub node_of: &'a [u32],
    /// Whether several subdomains share a vector.
    pub shared: &'a (dyn Fn(u32) -> bool + Sync),
    /// Whether a vector belongs to a primal node.
    pub primal: &'a (dyn Fn(u32) -> bool + Sync),
}

/// Role of a nodal vector in a subdomain, in the order in which their unknowns are numbered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Role {
    Interior,
    Dual,
    Primal,
}

impl Roles<'_> {
    /// Vectors with free degrees of freedom of some terms: by role, those of a node together.
    fn vectors(&self, terms: &Terms, order: &[u32]) -> Vec<(Role, u32, u32)> {
        let mut all: Vec<u32> = order.iter().flat_map(|&t| terms.vectors(t as usize)).copied().collect();
        all.sort_unstable();
        all.dedup();
        all.retain(|&v| self.frames.of(v as usize).iter().any(|&n| n != CONSTRAINED));
        let role = |v: u32| match ((self.shared)(v), (self.primal)(v)) {
            (false, _) => Role::Interior,
            (true, false) => Role::Dual,
            (true, true) => Role::Primal,
        };
        let mut out: Vec<_> = all.into_iter().map(|v| (role(v), self.node_of[v as usize], v)).collect();
        out.sort_unstable();
        out
    }
}

impl Subdomain {
    /// Subdomain of the terms `order`, and the symbolic factorisation of its interior, unless it belongs to another rank.
    ///
    /// # Errors
    /// The matrix or its factor is too large to be indexed.
    pub fn new(
        terms: &Terms,
        order: &[u32],
        roles: &Roles<'_>,
        is_own: bool,
    ) -> Result<(Self, Option<SchurComplement>), FactorError> {
        let (mut unknowns, mut vectors) = (Vec::new(), Vec::new());
        let mut counts = [0; 3];
        for (role, _, v) in roles.vectors(terms, order) {
            let number = |n: u32| {
                if n == CONSTRAINED {
                    return NONE;
                }
                counts[role as usize] += 1;
                unknowns.push(n);
                unknowns.len() as u32 - 1
            };
            vectors.push(LocalVector { vector: v, unknowns: roles.frames.of(v as usize).map(number) });
        }
        let [inner, dual, _] = counts;
        if !is_own {
            let assembly = LocalAssembly::default();
            return Ok((Self { number: 0, assembly, unknowns, inner, dual }, None));
        }
        let (assembly, pattern) = LocalAssembly::new(terms, order, vectors)?;
        let interface: Vec<u32> = (inner as u32..unknowns.len() as u32).collect();
        let interior = SchurComplement::sequential(&pattern, &interface)?;
        Ok((Self { number: 0, assembly, unknowns, inner, dual }, Some(interior)))
    }

    /// Number of interface unknowns.
    pub fn interface_size(&self) -> usize {
        self.unknowns.len() - self.inner
    }

    /// Number of primal unknowns.
    pub fn primal(&self) -> usize {
        self.interface_size() - self.dual
    }

    /// Number of entries in the blocks of all terms.
    pub fn blocks(&self) -> usize {
        self.assembly.blocks()
    }

    /// Range of the blocks of one term.
    pub fn term(&self, term: usize) -> Range<usize> {
        self.assembly.term(term)
    }

    /// Shifts of the diagonal of this subdomain: shifts of nodal vectors, divided by the number of subdomains that
    /// share them, which `subdomains` gives for an interface unknown. Empty without shifts.
    pub fn shifts(&self, shifts: &[f64], subdomains: impl Fn(usize) -> usize) -> Vec<f64> {
        if shifts.is_empty() {
            return Vec::new();
        }
        let mut out = vec![0.0; self.unknowns.len()];
        for LocalVector { vector, unknowns } in self.assembly.vectors() {
            for p in unknowns.iter().filter(|p| **p != NONE).map(|&p| p as usize) {
                let share = if p < self.inner { 1 } else { subdomains(p - self.inner) };
                out[p] = shifts[*vector as usize] / share as f64;
            }
        }
        out
    }

    /// Eliminates the interior unknowns and factors the Schur complement on the interface. Returns the Schur complement
    /// with its factor, and the Schur complement at the primal unknowns after elimination of the dual unknowns, too: its
    /// lower triangle by columns.
    ///
    /// # Errors
    /// A pivot is not positive, or the memory does not suffice.
    pub fn factor(
        &self,
        interior: &mut SchurComplement,
        (blocks, shifts): (&[f64], &[f64]),
        frames: &LocalFrames,
        scratch: &mut Scratch,
    ) -> Result<(DenseSchurComplement, Vec<f64>), Refused> {
        let Scratch { values, workspace, square, .. } = scratch;
        self.assembly.assemble(blocks, frames, shifts, values);
        square.clear();
        square.resize(self.interface_size().pow(2), 0.0);
        match interior.factor_definite(values, square, workspace) {
            Ok(inertia) if inertia.negative == 0 => self.factor_interface(scratch),
            Ok(_) | Err(FactorError::Singular) => Err(Refused::Inner),
            Err(error) => Err(error.into()),
        }
    }

    /// Eliminates the dual unknowns of the Schur complement on the interface.
    fn factor_interface(&self, scratch: &mut Scratch) -> Result<(DenseSchurComplement, Vec<f64>), Refused> {
        let Scratch { square, factor, coarse, cholesky, .. } = scratch;
        let (size, dual, primal) = (self.interface_size(), self.dual, self.primal());
        coarse.clear();
        coarse.resize(primal * primal, 0.0);
        for j in 0..primal {
            let from = (dual + j) * size + dual;
            coarse[j * primal + j..(j + 1) * primal].copy_from_slice(&square[from + j..from + primal]);
        }
        factor.clear();
        factor.extend_from_slice(&square[..dual * size]);
        if dual > 0 {
            eliminate(cholesky, (dual, primal), factor, coarse).map_err(|NotPositive| Refused::Border)?;
        }
        let schur = DenseSchurComplement::new(square, factor, (size, dual))?;
        let left = (0..primal).flat_map(|j| &coarse[j * primal + j..(j + 1) * primal]).copied().collect();
        Ok((schur, left))
    }
}

/// Reason why a subdomain could not be factored.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Refused {
    /// A pivot of the interior unknowns is not positive.
    Inner,
    /// A pivot of the dual unknowns is not positive, with the primal unknowns held.
    Border,
    /// Another error of the factorisation.
    Factor(FactorError),
}

impl Refused {
    /// Number by which ranks tell each other the reason, not 0.
    pub fn code(&self) -> f64 {
        match self {
            Self::Inner => 1.0,
            Self::Border => 2.0,
            Self::Factor(FactorError::NotFinite) => 3.0,
            Self::Factor(FactorError::Singular) => 4.0,
            Self::Factor(FactorError::TooLarge | FactorError::Other(_)) => 5.0,
        }
    }

    /// Reason of a number; none of 0.
    pub fn of_code(code: f64) -> Option<Self> {
        Some(match code as u8 {
            0 => return None,
            1 => Self::Inner,
            2 => Self::Border,
            3 => Self::Factor(FactorError::NotFinite),
            4 => Self::Factor(FactorError::Singular),
            _ => Self::Factor(FactorError::TooLarge),
        })
    }
}

impl From<FactorError> for Refused {
    fn from(e: FactorError) -> Self {
        Self::Factor(e)
    }
}

/// Workspace of a thread.
#[derive(Default)]
pub(super) struct Scratch {
    /// Values of the matrix.
    values: Vec<f64>,
    workspace: Workspace,
    /// Schur complement on the interface; `factor` is its factor, `coarse` the Schur complement at the primal unknowns.
    square: Vec<f64>,
    factor: Vec<f64>,
    coarse: Vec<f64>,
    cholesky: PartialCholesky,
}
