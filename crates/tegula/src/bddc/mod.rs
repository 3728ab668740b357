//! BDDC (balancing domain decomposition by constraints) for shells too large to be factored as a whole.
//!
//! The mesh is partitioned into subdomains of constant size. Each of them eliminates its interior unknowns; the system
//! `S u = g` on the interface Γ remains, `S = Σ Rᵀ S_p R` with the dense Schur complements `S_p` of the subdomains, and
//! is solved by preconditioned conjugate gradients. The preconditioner couples the subdomains at primal nodes only:
//! this partially assembled operator `S̃` is solved subdomain by subdomain, with a small coarse problem for the primal
//! unknowns. The averaging operator `E_D` averages its solution where subdomains meet, and its transpose distributes
//! the residual to them,
//!
//! ```text
//! M⁻¹ = E_D S̃⁻¹ E_Dᵀ,   κ(M⁻¹ S) = O(1 + log³(H/h))
//! ```
//!
//! with the size `H` of a subdomain and `h` of an element. The bound holds for Reissner–Mindlin plates of MITC
//! elements, whatever their thickness.
//!
//! C. R. Dohrmann, *A preconditioner for substructuring based on constrained energy minimization*, SIAM J. Sci.
//! Comput. 25 (2003) 246–258; L. Beirão da Veiga, C. Chinosi, C. Lovadina, L. F. Pavarino, *Robust BDDC
//! preconditioners for Reissner–Mindlin plate bending problems and MITC elements*, SIAM J. Numer. Anal. 47 (2010)
//! 4214–4238.
//!
//! A restriction of the partially assembled operator `S̃` to continuous functions is the assembled `S`. If all pivots
//! of `S̃` are positive, `S` is therefore positive definite, too.

mod assembly;
mod coarse;
mod conjugate_gradients;
mod deluxe_scaling;
mod elements;
mod interface;
mod partition;
mod primal_nodes;
mod ranks;
mod schur_complement;
mod subdomain;
mod tridiagonal;

use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rayon::prelude::*;

use self::coarse::Coarse;
pub use self::conjugate_gradients::StoppingCriterion;
use self::deluxe_scaling::DeluxeScaling;
use self::interface::Interface;
use self::primal_nodes::{PrimalNodes, Sharing, select_primal_nodes};
use self::ranks::Distribution;
pub use self::ranks::{Ranks, share_subdomains};
use self::schur_complement::DenseSchurComplement;
use self::subdomain::{Refused, Roles, Scratch, Subdomain};
use crate::Vec3;
use crate::lists::Lists;
use crate::system::LocalFrames;
use tegula_sparse::{FactorError, SchurComplement, Workspace};

/// Quadrilaterals of a mesh, and the positions of their nodes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Quads<'a> {
    /// Four nodes of each quadrilateral, in order around it.
    pub nodes: &'a [[u32; 4]],
    /// Positions of the nodes of the mesh.
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

    /// Unit vectors from each side to the opposite side.
    fn directions(&self, quad: u32) -> [Vec3; 2] {
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| self.corner(quad, k));
        [b + c - a - d, c + d - a - b].map(|v| v.try_normalize(0.0).unwrap_or_else(Vec3::x))
    }
}

/// Terms of the matrix, each with its nodal vectors and the quadrilateral it belongs to.
#[derive(Debug, Clone, Default)]
pub(crate) struct Terms {
    start: Vec<u32>,
    vectors: Vec<u32>,
    quads: Vec<u32>,
    /// Terms that are no elements: director-angle constraints and follower loads.
    ties: Vec<u32>,
}

impl Terms {
    /// Adds a term of a quadrilateral that couples these nodal vectors, and is no element.
    pub fn push_tie(&mut self, vectors: &[u32], quad: u32) {
        self.ties.push(self.len() as u32);
        self.push(vectors, quad);
    }

    /// Nodal vectors that only ties, and no elements, connect with a subdomain: it holds them along one direction or not at
    /// all.
    fn dangling(&self, subdomain_of_term: impl Fn(usize) -> u32) -> BTreeSet<u32> {
        let mut found: BTreeSet<(u32, u32)> = BTreeSet::new();
        for &t in &self.ties {
            let subdomain = subdomain_of_term(t as usize);
            found.extend(self.vectors(t as usize).iter().map(|&v| (v, subdomain)));
        }
        if !found.is_empty() {
            let mut ties = self.ties.iter().peekable();
            for t in 0..self.len() {
                if ties.next_if(|tie| **tie == t as u32).is_none() {
                    let subdomain = subdomain_of_term(t);
                    for &v in self.vectors(t) {
                        found.remove(&(v, subdomain));
                    }
                }
            }
        }
        found.into_iter().map(|(v, _)| v).collect()
    }

    /// Adds a term of a quadrilateral that couples these nodal vectors.
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

/// Options of the partition and of the selection of primal nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Number of elements of a subdomain, 1 to 4096; other values are clamped to this range.
    pub size: usize,
    /// Largest number of elements along an interface edge from any node to the next primal node.
    pub reach: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self { size: 256, reach: 3 }
    }
}

/// Reason why a linear system was not solved.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BddcError {
    /// The matrix or the right side holds values that are not numbers.
    #[error("the matrix or the right side holds values that are not numbers")]
    NotFinite,
    /// A subdomain, the coarse matrix or a search direction shows that the matrix is not positive definite, or nearly
    /// so.
    #[error("{0}")]
    Indefinite(&'static str),
    /// The factors need more memory than there is, or more than can be indexed.
    #[error("the factors of the subdomains do not fit in memory")]
    TooLarge,
    /// There are no factors to solve with: no matrix was factored since the last one was begun, or the last one was
    /// refused.
    #[error("there is no factored matrix to solve with; give the blocks of all terms and factor them first")]
    NotFactored,
    /// The matrix is not complete: blocks of terms are missing.
    #[error(
        "the blocks of {missing} of the {terms} terms of the matrix were not given; give those of every term before \
         the matrix is factored"
    )]
    Incomplete {
        /// Number of terms without blocks.
        missing: usize,
        /// Number of terms of the mesh.
        terms: usize,
    },
    /// The size of the blocks of a term, of the shifts or of a right side does not match this mesh.
    #[error("{what} has {found} entries where the mesh has {expected}; use those of the same system")]
    WrongSize {
        /// Name of the input.
        what: &'static str,
        /// Size of the input.
        found: usize,
        /// Expected size.
        expected: usize,
    },
    /// The ranks that share the subdomains cannot communicate.
    #[error("the ranks that share the subdomains cannot communicate: {0}")]
    Ranks(String),
    /// The solution did not become accurate enough and is not returned.
    #[error(
        "not converged after {iterations} iterations: relative residual {residual:.1e} for {tolerance:.1e}"
    )]
    NotConverged {
        /// Number of iterations.
        iterations: usize,
        /// Relative residual that was reached.
        residual: f64,
        /// Relative residual that was required.
        tolerance: f64,
    },
}

impl From<Refused> for BddcError {
    fn from(refused: Refused) -> Self {
        match refused {
            Refused::Inner => Self::Indefinite(
                "the stiffness of the interior unknowns of a subdomain is not positive definite",
            ),
            Refused::Border => Self::Indefinite(
                "the stiffness of a subdomain with fixed primal nodes is not positive definite",
            ),
            Refused::Factor(e) => e.into(),
        }
    }
}

impl From<FactorError> for BddcError {
    fn from(e: FactorError) -> Self {
        match e {
            FactorError::NotFinite => Self::NotFinite,
            FactorError::Singular => Self::Indefinite("a matrix of a subdomain is singular"),
            // Subdomains have factors of the program's own.
            FactorError::TooLarge | FactorError::Other(_) => Self::TooLarge,
        }
    }
}

/// Convergence of the solution of a system.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Convergence {
    /// Number of iterations.
    pub iterations: usize,
    /// Norm `√(r·M⁻¹r)` of the true residual at the end: a bound of the error in the energy norm.
    pub error: f64,
    /// Norm `√(r·M⁻¹r)` of the residual at the start: about the size of the solution.
    pub start: f64,
    /// Estimated condition number of the preconditioned matrix, from the coefficients of the iteration.
    pub condition: f64,
}

/// BDDC solver for the matrix of one mesh and its supports: [`Self::begin`] a matrix, [`Self::put`] the blocks of all
/// terms, [`Self::factor`] it and [`Self::solve`] as often as needed.
pub struct Bddc {
    subdomains: Vec<Subdomain>,
    /// Subdomain of each term, and the position of the term there.
    slots: Vec<(u32, u32)>,
    data: Vec<SubdomainData>,
    interface: Interface,
    scaling: DeluxeScaling,
    coarse: Coarse,
    /// Whether the blocks of each term were given since the last matrix was factored.
    given: Vec<bool>,
    /// First invalid input, until the next matrix begins.
    fault: Option<BddcError>,
    /// Whether all factors belong to one matrix.
    ready: bool,
    /// Shifts that are added to the diagonal, by nodal vector; empty without shifts.
    shifts: Vec<f64>,
    /// Number of nodal vectors.
    nodal: usize,
    unknowns: usize,
    distribution: Distribution,
    vectors: conjugate_gradients::Vectors,
    /// Workspaces of the threads for the substitutions in the interiors.
    workspaces: Mutex<Vec<Workspace>>,
}

/// Numerical data of a subdomain.
struct SubdomainData {
    /// Blocks of its terms, until they are factored.
    blocks: Vec<f64>,
    /// Factor of its interior unknowns; none where the subdomain belongs to another rank.
    interior: Option<SchurComplement>,
    /// Schur complement on its interface, and the factor of that.
    schur: Option<DenseSchurComplement>,
    /// Schur complement at its primal unknowns, until the coarse matrix is factored: lower triangle by columns.
    primal: Vec<f64>,
    /// Vector of all its unknowns.
    x: Vec<f64>,
    /// Vector of its interface unknowns.
    y: Vec<f64>,
    /// Weights of the subdomain at its dual unknowns.
    weights: Vec<f64>,
}

impl SubdomainData {
    fn new(subdomain: &Subdomain, interior: Option<SchurComplement>) -> Self {
        Self {
            blocks: Vec::new(),
            interior,
            schur: None,
            primal: Vec::new(),
            x: vec![0.0; subdomain.unknowns.len()],
            y: vec![0.0; subdomain.interface_size()],
            weights: Vec::new(),
        }
    }
}

impl Bddc {
    /// Partitions a mesh and analyses its subdomains, of which each of the ranks has some. `node_of` gives the node of every nodal vector.
    ///
    /// # Errors
    /// A subdomain or the coarse matrix would be too large.
    pub(crate) fn new(
        quads: Quads<'_>,
        terms: &Terms,
        node_of: &[u32],
        frames: &LocalFrames,
        (options, ranks): (&Options, Option<Arc<dyn Ranks>>),
    ) -> Result<Self, BddcError> {
        let (piece_of, count) = partition::partition(&quads, options.size.clamp(1, 4096));
        let mut distribution = Distribution::new(ranks, count);
        let of_term = |t: usize| piece_of[terms.quads[t] as usize];
        let sharing = Sharing::new(terms, of_term, node_of.len());
        let PrimalNodes { primal, edges } =
            select_primal_nodes(&quads, (&sharing, &terms.dangling(of_term)), node_of, frames, options.reach);
        let shared = |v: u32| sharing.shared.contains_key(&v);
        let primal = |v: u32| primal.contains(&node_of[v as usize]);
        let roles = Roles { frames, node_of, shared: &shared, primal: &primal };
        let Parts { subdomains, data, slots } =
            Parts::new(terms, (&piece_of, count), &roles, &mut distribution)?;
        let groups = deluxe_scaling::groups(&sharing, &edges, node_of, frames);
        let interface = Interface::new(&subdomains, frames.dofs().unknowns, &groups);
        let scaling = DeluxeScaling::new(&groups, &interface);
        let coarse = Coarse::new(&subdomains, &interface)?;
        let vectors = conjugate_gradients::Vectors::new(interface.len());
        let own = distribution.own();
        Ok(Self {
            subdomains,
            given: slots.iter().map(|slot| !own.contains(&(slot.0 as usize))).collect(),
            distribution,
            slots,
            data,
            interface,
            scaling,
            coarse,
            fault: None,
            ready: false,
            shifts: Vec::new(),
            nodal: node_of.len(),
            unknowns: frames.dofs().unknowns,
            vectors,
            workspaces: Mutex::default(),
        })
    }

    /// Begins a new matrix and frees the old factors.
    pub fn begin(&mut self) {
        self.clear();
        self.fault = None;
    }

    /// Drops the factors, the blocks and the shifts.
    fn clear(&mut self) {
        for datum in &mut self.data {
            if let Some(interior) = &mut datum.interior {
                interior.release();
            }
            datum.schur = None;
            datum.blocks = Vec::new();
            datum.primal = Vec::new();
        }
        self.expect_terms();
        self.shifts.clear();
        self.ready = false;
    }

    /// Expects the blocks of all terms of this rank's subdomains anew.
    fn expect_terms(&mut self) {
        let own = self.distribution.own();
        for (given, slot) in self.given.iter_mut().zip(&self.slots) {
            *given = !own.contains(&(slot.0 as usize));
        }
    }

    /// Adds multiples of the unit matrix to the diagonal blocks of nodal vectors, of which there are `count`. A `count`
    /// that is not that of the mesh, or a vector beyond it, makes [`Self::factor`] fail.
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

    /// Stores the lower blocks of a term, in global axes. A term that the mesh does not have, or blocks of another size
    /// than the term's, make [`Self::factor`] fail.
    pub fn put(&mut self, term: usize, blocks: &[f64]) {
        let Some(&(number, at)) = self.slots.get(term) else {
            self.expect("the list of terms", term + 1, self.slots.len());
            return;
        };
        if !self.distribution.own().contains(&(number as usize)) {
            return;
        }
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

    /// Records the first size that is wrong.
    fn expect(&mut self, what: &'static str, found: usize, expected: usize) {
        if found != expected && self.fault.is_none() {
            self.fault = Some(BddcError::WrongSize { what, found, expected });
        }
    }

    /// Factors the subdomains and the coarse matrix. The blocks and shifts are consumed: the next matrix needs all its
    /// terms again.
    ///
    /// # Errors
    /// Terms are missing or of a wrong size, the subdomains or the coarse matrix show that the matrix is not positive
    /// definite, or there is not enough memory. Nothing can be solved then until another matrix is factored.
    pub fn factor(&mut self, frames: &LocalFrames) -> Result<(), BddcError> {
        let checked = self.check(frames);
        let result = self.distribution.agree(checked).and_then(|()| self.factor_all(frames));
        if result.is_ok() {
            self.expect_terms();
            self.shifts.clear();
            self.ready = true;
        } else {
            self.clear();
        }
        result
    }

    /// Checks that the matrix is complete and belongs to the mesh.
    fn check(&self, frames: &LocalFrames) -> Result<(), BddcError> {
        if let Some(fault) = &self.fault {
            return Err(fault.clone());
        }
        if frames.dofs().unknowns != self.unknowns {
            let (found, expected) = (frames.dofs().unknowns, self.unknowns);
            return Err(BddcError::WrongSize { what: "the degree-of-freedom map", found, expected });
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

    fn factor_all(&mut self, frames: &LocalFrames) -> Result<(), BddcError> {
        let Self { subdomains, data, interface, shifts, distribution, .. } = self;
        let scratches: Mutex<Vec<Scratch>> = Mutex::default();
        let own = distribution.own();
        let done: Vec<Result<(), Refused>> = data[own.clone()]
            .par_iter_mut()
            .with_max_len(1)
            .zip(&subdomains[own.clone()])
            .zip(&interface.of_subdomain[own.clone()])
            .map(|((datum, subdomain), of)| {
                let blocks = std::mem::take(&mut datum.blocks);
                if !blocks.iter().all(|b| b.is_finite()) {
                    return Err(Refused::Factor(FactorError::NotFinite));
                }
                let shifts = subdomain.shifts(shifts, |k| interface.subdomains(of[k]));
                let mut scratch = locked(&scratches).pop().unwrap_or_default();
                let input = (blocks.as_slice(), shifts.as_slice());
                let Some(interior) = &mut datum.interior else { return Ok(()) };
                let factored = subdomain.factor(interior, input, frames, &mut scratch);
                locked(&scratches).push(scratch);
                let (schur, primal) = factored?;
                (datum.schur, datum.primal) = (Some(schur), primal);
                Ok(())
            })
            .collect();
        distribution.settle(done.into_iter())?;
        interface.weigh(subdomains, data, distribution)?;
        self.scaling.weigh(data, distribution)?;
        for (datum, subdomain) in data.iter_mut().zip(subdomains.as_slice()) {
            let primal = subdomain.primal();
            datum.primal.resize(primal * (primal + 1) / 2, 0.0);
        }
        distribution.exchange(data, |_, datum| &mut datum.primal)?;
        self.coarse.factor(&mut self.data)
    }
}

/// Subdomains of a partition and their data.
struct Parts {
    subdomains: Vec<Subdomain>,
    data: Vec<SubdomainData>,
    /// Subdomain of each term, and the position of the term there.
    slots: Vec<(u32, u32)>,
}

impl Parts {
    /// Analyses the subdomains in parallel. `piece_of` gives the subdomain of each quadrilateral, `count` their number.
    fn new(
        terms: &Terms,
        (piece_of, count): (&[u32], usize),
        roles: &Roles<'_>,
        distribution: &mut Distribution,
    ) -> Result<Self, BddcError> {
        let of_quad = Lists::by_key(piece_of.len(), terms.quads.iter().zip(0..).map(|(&q, t)| (q, t)));
        let mut orders: Vec<Vec<u32>> = vec![Vec::new(); count];
        for (q, &p) in piece_of.iter().enumerate() {
            orders[p as usize].extend(of_quad.of(q));
        }
        let own = distribution.own();
        let made: Vec<Result<(Subdomain, Option<SchurComplement>), FactorError>> = orders
            .par_iter()
            .with_max_len(1)
            .enumerate()
            .map(|(p, order)| Subdomain::new(terms, order, roles, own.contains(&p)))
            .collect();
        let refused = |made: &Result<_, FactorError>| made.as_ref().map(drop).map_err(|e| e.clone().into());
        distribution.settle(made[own].iter().map(refused))?;
        let (mut subdomains, mut data) = (Vec::with_capacity(count), Vec::with_capacity(count));
        let mut slots = vec![(0, 0); terms.len()];
        for ((p, made), order) in (0..).zip(made).zip(&orders) {
            let (mut subdomain, interior) = made?;
            subdomain.number = p;
            for (k, &t) in (0..).zip(order) {
                slots[t as usize] = (p, k);
            }
            data.push(SubdomainData::new(&subdomain, interior));
            subdomains.push(subdomain);
        }
        Ok(Self { subdomains, data, slots })
    }
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
