//! Conjugate gradients on the borders of the pieces of a shell, for models too large to be factored whole.
//!
//! The mesh is divided into pieces of constant size. Each eliminates its inner unknowns; what is left is `S u = g`
//! on the borders, `S = Σ Rᵀ S_p R` with the dense matrices `S_p` of the pieces. The preconditioner is balancing
//! domain decomposition by constraints: the pieces are tied at corners only, which leaves a matrix that can be
//! solved piece by piece with a small coarse one for the corners; its solution is averaged where pieces touch,
//!
//! ```text
//! M⁻¹ = Dᵀ S̃⁻¹ D,   κ(M⁻¹ S) = O(1 + log³(H/h))
//! ```
//!
//! with `H` the size of a piece and `h` that of an element, for Reissner–Mindlin plates of MITC elements whatever
//! their thickness.
//!
//! C. R. Dohrmann, *A preconditioner for substructuring based on constrained energy minimization*, SIAM J. Sci.
//! Comput. 25 (2003) 246–258; L. Beirão da Veiga, C. Chinosi, C. Lovadina, L. F. Pavarino, *Robust BDDC
//! preconditioners for Reissner–Mindlin plate bending problems and MITC elements*, SIAM J. Numer. Anal. 47 (2010)
//! 4214–4238.
//!
//! `S̃` is the matrix of the pieces tied at corners only: a restriction of it is the matrix of the whole. So if all
//! its pivots are positive, those of the whole are, too.

mod coarse;
mod conjugate_gradients;
mod deluxe_scaling;
mod front;
mod interface;
mod partition;
mod primal_nodes;
mod schur_complement;
mod subdomain;
mod tridiagonal;

use std::sync::{Mutex, MutexGuard, PoisonError};

use rayon::prelude::*;

use self::coarse::Coarse;
pub use self::conjugate_gradients::StoppingCriterion;
use self::deluxe_scaling::DeluxeScaling;
use self::interface::Interface;
use self::primal_nodes::{PrimalNodes, Sharing, select_primal_nodes};
use self::subdomain::{Factored, Refused, Roles, Scratch, Subdomain};
use crate::Vec3;
use crate::lists::Lists;
use crate::system::Numbering;
use tegula_sparse::FactorError;

/// Quadrilaterals of a mesh, and where their nodes are.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Quads<'a> {
    /// Four nodes of each, around it.
    pub nodes: &'a [[u32; 4]],
    /// Positions of the nodes.
    pub positions: &'a [Vec3],
}

impl Quads<'_> {
    fn len(&self) -> usize {
        self.nodes.len()
    }

    fn corner(&self, quad: u32, corner: usize) -> Vec3 {
        self.positions[self.nodes[quad as usize][corner] as usize]
    }

    fn centre(&self, quad: u32) -> Vec3 {
        (0..4).map(|a| self.corner(quad, a)).sum::<Vec3>() * 0.25
    }

    fn sides(&self, quad: u32) -> [(u32, u32); 4] {
        let n = self.nodes[quad as usize];
        std::array::from_fn(|a| (n[a], n[(a + 1) % 4]))
    }

    /// Unit vectors from side to opposite side.
    fn directions(&self, quad: u32) -> [Vec3; 2] {
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| self.corner(quad, k));
        [b + c - a - d, c + d - a - b].map(|v| v.try_normalize(0.0).unwrap_or_else(Vec3::x))
    }
}

/// What contributes to the matrix, term by term: the nodal vectors of each and the quadrilateral it belongs to.
#[derive(Debug, Clone, Default)]
pub(crate) struct Terms {
    start: Vec<u32>,
    vectors: Vec<u32>,
    quads: Vec<u32>,
}

impl Terms {
    /// Adds a term.
    pub fn push(&mut self, vectors: &[u32], quad: u32) {
        if self.start.is_empty() {
            self.start.push(0);
        }
        self.vectors.extend_from_slice(vectors);
        self.start.push(self.vectors.len() as u32);
        self.quads.push(quad);
    }

    /// Number of terms.
    pub fn len(&self) -> usize {
        self.quads.len()
    }

    fn vectors(&self, term: usize) -> &[u32] {
        &self.vectors[self.start[term] as usize..self.start[term + 1] as usize]
    }
}

/// How pieces are cut and tied.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Elements of a piece, 1 to 4096; what is less or more is taken as the nearest of these.
    pub size: usize,
    /// Elements along a border from any node to the next corner at most.
    pub reach: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self { size: 256, reach: 3 }
    }
}

/// A linear system that was not solved.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BddcError {
    /// The matrix or the right side hold values that are not numbers.
    #[error("the matrix or the right side holds values that are not numbers")]
    NotFinite,
    /// A piece, the coarse matrix or a search direction shows that the matrix is not positive definite, or nearly so.
    #[error("{0}")]
    Indefinite(&'static str),
    /// Not enough memory, or more than can be indexed.
    #[error("the factors of the subdomains do not fit in memory")]
    TooLarge,
    /// There is nothing to solve with: no matrix was factored since the last one was begun, or the last one was refused.
    #[error("there is no factored matrix to solve with; give the blocks of all terms and factor them first")]
    NotFactored,
    /// The matrix is not complete.
    #[error(
        "the blocks of {missing} of the {terms} terms of the matrix were not given; give those of every term before \
         the matrix is factored"
    )]
    Incomplete {
        /// Terms without blocks.
        missing: usize,
        /// Terms of the mesh.
        terms: usize,
    },
    /// Blocks of a term, shifts or a right side do not belong to this mesh.
    #[error("{what} has {found} entries where the mesh has {expected}; use those of the same system")]
    WrongSize {
        /// What was given.
        what: &'static str,
        /// Its length.
        found: usize,
        /// What it should be.
        expected: usize,
    },
    /// Not accurate enough; the solution is not returned.
    #[error(
        "not converged after {iterations} iterations: relative residual {residual:.1e} for {tolerance:.1e}"
    )]
    NotConverged {
        /// Iterations.
        iterations: usize,
        /// Residual that was reached.
        residual: f64,
        /// Residual that was wanted.
        tolerance: f64,
    },
}

impl From<FactorError> for BddcError {
    fn from(e: FactorError) -> Self {
        match e {
            FactorError::NotFinite => Self::NotFinite,
            FactorError::Singular => Self::Indefinite("a matrix of a subdomain is singular"),
            FactorError::TooLarge => Self::TooLarge,
        }
    }
}

/// How a system was solved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Convergence {
    /// Iterations.
    pub iterations: usize,
    /// `√(r·M⁻¹r)` of the true residual at the end: a bound of the error in the energy norm.
    pub error: f64,
    /// The same at the start: about the size of the solution.
    pub start: f64,
    /// Estimate of the condition of the preconditioned matrix from the coefficients of the iteration.
    pub condition: f64,
}

/// Solver for the matrix of one mesh and its supports: [`Self::begin`] a matrix, [`Self::put`] the blocks of all
/// terms, [`Self::factor`] it and [`Self::solve`] as often as needed.
pub struct Bddc {
    subdomains: Vec<Subdomain>,
    /// Piece of each term, and its place there.
    slots: Vec<(u32, u32)>,
    data: Vec<SubdomainData>,
    interface: Interface,
    scaling: DeluxeScaling,
    coarse: Coarse,
    /// Terms whose blocks were given since the last matrix was factored.
    given: Vec<bool>,
    /// What was wrong with what was given, until the next matrix begins.
    fault: Option<BddcError>,
    /// The factors are those of one matrix, all of them.
    ready: bool,
    /// What is added to the diagonal of nodal vectors; empty: nothing is.
    shifts: Vec<f64>,
    /// Nodal vectors.
    nodal: usize,
    unknowns: usize,
    vectors: conjugate_gradients::Vectors,
}

/// What a piece works with.
#[derive(Default)]
struct SubdomainData {
    /// Blocks of its terms until they are factored.
    blocks: Vec<f64>,
    factored: Option<Factored>,
    /// What is left at its corners, until the coarse matrix is factored: lower triangle by columns.
    primal: Vec<f64>,
    /// All its unknowns.
    x: Vec<f64>,
    /// Those of its border.
    y: Vec<f64>,
    /// Its share of the dual unknowns.
    weights: Vec<f64>,
    rows: Vec<f64>,
}

impl Bddc {
    /// Divides a mesh. `node_of` gives the node of every nodal vector.
    ///
    /// # Errors
    /// A piece or the coarse matrix would be too large.
    pub(crate) fn new(
        quads: Quads<'_>,
        terms: &Terms,
        node_of: &[u32],
        numbering: &Numbering,
        options: &Options,
    ) -> Result<Self, BddcError> {
        let (piece_of, count) = partition::partition(&quads, options.size.clamp(1, 4096));
        let of_term = |t: usize| piece_of[terms.quads[t] as usize];
        let sharing = Sharing::new(terms, of_term, node_of.len());
        let PrimalNodes { primal, edges } =
            select_primal_nodes(&quads, &sharing, node_of, numbering, options.reach);
        let mut cells: Vec<Vec<u32>> = vec![Vec::new(); count];
        for (q, &p) in piece_of.iter().enumerate() {
            cells[p as usize].push(q as u32);
        }
        let of_quad = Lists::by_key(quads.len(), terms.quads.iter().zip(0..).map(|(&q, t)| (q, t)));
        let terms_of = |q: u32| of_quad.of(q as usize).to_vec();
        let shared = |v: u32| sharing.shared.contains_key(&v);
        let corner = |v: u32| primal.contains(&node_of[v as usize]);
        let made: Vec<Result<(Subdomain, Vec<u32>), FactorError>> = cells
            .into_par_iter()
            .map(|cells| {
                let roles = Roles { numbering, shared: &shared, primal: &corner };
                Subdomain::new(&quads, terms, &terms_of, cells, &roles)
            })
            .collect();
        let mut slots = vec![(0, 0); terms.len()];
        let mut subdomains = Vec::with_capacity(count);
        for (p, made) in made.into_iter().enumerate() {
            let (mut subdomain, order) = made?;
            subdomain.number = p as u32;
            for (k, t) in order.into_iter().enumerate() {
                slots[t as usize] = (p as u32, k as u32);
            }
            subdomains.push(subdomain);
        }
        let groups = deluxe_scaling::groups(&sharing, &edges, node_of, numbering);
        let interface = Interface::new(&subdomains, numbering.unknowns, &groups);
        let scaling = DeluxeScaling::new(&groups, &interface);
        let coarse = Coarse::new(&subdomains, &interface)?;
        let data = subdomains
            .iter()
            .map(|p| SubdomainData {
                x: vec![0.0; p.unknowns.len()],
                y: vec![0.0; p.interface_size()],
                ..SubdomainData::default()
            })
            .collect();
        let vectors = conjugate_gradients::Vectors::new(interface.len());
        Ok(Self {
            subdomains,
            given: vec![false; slots.len()],
            slots,
            data,
            interface,
            scaling,
            coarse,
            fault: None,
            ready: false,
            shifts: Vec::new(),
            nodal: node_of.len(),
            unknowns: numbering.unknowns,
            vectors,
        })
    }

    /// Begins a new matrix: the old factors make room.
    pub fn begin(&mut self) {
        self.clear();
        self.fault = None;
    }

    /// Drops the factors and all that was given.
    fn clear(&mut self) {
        for datum in &mut self.data {
            datum.factored = None;
            datum.blocks = Vec::new();
            datum.primal = Vec::new();
        }
        self.given.fill(false);
        self.shifts.clear();
        self.ready = false;
    }

    /// Adds multiples of the unit matrix to the blocks of nodal vectors, of which there are `count`, with themselves.
    /// A `count` that is not that of the mesh, or a vector beyond it, makes [`Self::factor`] fail.
    pub fn shift(&mut self, count: usize, shifts: impl Iterator<Item = (usize, f64)>) {
        self.shifts.resize(self.nodal, 0.0);
        let mut found = count;
        for (v, shift) in shifts {
            match self.shifts.get_mut(v) {
                Some(sum) => *sum += shift,
                None => found = found.max(v + 1),
            }
        }
        self.expect("the diagonal that is added", found, self.nodal);
    }

    /// Takes the lower blocks of a term, along the global axes. A term that the mesh has not, or blocks of another
    /// size than its own, make [`Self::factor`] fail.
    pub fn put(&mut self, term: usize, blocks: &[f64]) {
        let Some(&(number, at)) = self.slots.get(term) else {
            self.expect("the list of terms", term + 1, self.slots.len());
            return;
        };
        let (subdomain, datum) = (&self.subdomains[number as usize], &mut self.data[number as usize]);
        if datum.blocks.is_empty() {
            datum.blocks.resize(subdomain.blocks(), 0.0);
        }
        let own = subdomain.term(at as usize);
        let expected = own.len();
        if blocks.len() == expected {
            datum.blocks[own].copy_from_slice(blocks);
            self.given[term] = true;
        }
        self.expect("a term", blocks.len(), expected);
    }

    /// Notes the first size that is wrong.
    fn expect(&mut self, what: &'static str, found: usize, expected: usize) {
        if found != expected && self.fault.is_none() {
            self.fault = Some(BddcError::WrongSize { what, found, expected });
        }
    }

    /// Factors the pieces and the coarse matrix. What was given is used up: the next matrix needs all its terms again.
    ///
    /// # Errors
    /// Terms are missing or of a wrong size, the matrix is not positive definite as far as the pieces can tell, or
    /// there is not enough memory. Nothing can be solved then until another matrix is factored.
    pub fn factor(&mut self, numbering: &Numbering) -> Result<(), BddcError> {
        let result = self.check(numbering).and_then(|()| self.factor_all(numbering));
        if result.is_ok() {
            self.given.fill(false);
            self.shifts.clear();
            self.ready = true;
        } else {
            self.clear();
        }
        result
    }

    /// Is the matrix complete, and that of the mesh?
    fn check(&self, numbering: &Numbering) -> Result<(), BddcError> {
        if let Some(fault) = &self.fault {
            return Err(fault.clone());
        }
        if numbering.unknowns != self.unknowns {
            let (found, expected) = (numbering.unknowns, self.unknowns);
            return Err(BddcError::WrongSize { what: "the numbering", found, expected });
        }
        let missing = self.given.iter().filter(|given| !**given).count();
        if missing > 0 {
            return Err(BddcError::Incomplete { missing, terms: self.given.len() });
        }
        if !self.shifts.iter().all(|s| s.is_finite()) {
            return Err(BddcError::NotFinite);
        }
        Ok(())
    }

    fn factor_all(&mut self, numbering: &Numbering) -> Result<(), BddcError> {
        let Self { subdomains, data, interface, shifts, .. } = self;
        let scratches: Mutex<Vec<Scratch>> = Mutex::default();
        let done: Vec<Result<(), Refused>> = data
            .par_iter_mut()
            .with_max_len(1)
            .zip(subdomains.as_slice())
            .zip(&interface.of_subdomain)
            .map(|((datum, subdomain), of)| {
                let blocks = std::mem::take(&mut datum.blocks);
                if !blocks.iter().all(|b| b.is_finite()) {
                    return Err(Refused::Factor(FactorError::NotFinite));
                }
                let shifts = subdomain.shifts(shifts, |k| interface.subdomains(of[k]));
                let mut scratch = locked(&scratches).pop().unwrap_or_default();
                let factored = subdomain.factor(&blocks, numbering, &shifts, &mut scratch);
                locked(&scratches).push(scratch);
                let (factored, primal) = factored?;
                (datum.factored, datum.primal) = (Some(factored), primal);
                Ok(())
            })
            .collect();
        for result in done {
            result.map_err(|refused| match refused {
                Refused::Inner => BddcError::Indefinite("a subdomain of the shell is unstable within itself"),
                Refused::Border => BddcError::Indefinite(
                    "a subdomain of the shell is unstable when only its primal are held",
                ),
                Refused::Factor(e) => e.into(),
            })?;
        }
        self.interface.weigh(&self.subdomains, &mut self.data);
        self.scaling.weigh(&self.data)?;
        self.coarse.factor(&mut self.data)
    }
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
