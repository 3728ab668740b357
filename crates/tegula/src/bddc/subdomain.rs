//! Subdomain of a shell: its unknowns in elimination order, the fronts in which the interior unknowns are eliminated,
//! and the Schur complement on its interface.
//!
//! The elements of a subdomain are bisected recursively, which gives the assembly tree. A nodal vector is eliminated in
//! the smallest branch that contains all of its elements; the others stay in the contribution block, which goes up the
//! tree. The unknowns of the interface reach the root, with the Schur complement `S = K_BB − K_BI K_II⁻¹ K_IB`.

use std::collections::HashMap;
use std::ops::Range;

use dyn_stack::MemBuffer;
use faer::linalg::cholesky::llt::factor::cholesky_in_place_scratch;
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, MatMut, MatRef, Par};

use super::front::{NotPositive, eliminate};
use super::partition::tree;
use super::schur_complement::SchurComplement;
use super::{Quads, Terms};
use crate::system::LocalFrames;
use crate::system::dof_map::CONSTRAINED;
use tegula_sparse::FactorError;
use tegula_sparse::zeros;

/// Largest number of elements of a leaf of the assembly tree.
const LEAF: usize = 6;

/// Marks a constrained degree of freedom.
const NONE: u32 = u32::MAX;

/// Front: dense matrix of the fully summed columns that are eliminated in it and of the rows of its contribution block.
#[derive(Debug)]
struct Front {
    /// First fully summed column.
    first: usize,
    /// Number of fully summed columns.
    width: usize,
    /// Unknowns of the contribution block, ascending.
    rows: Vec<u32>,
    /// Terms that are assembled in this front.
    terms: Range<usize>,
    /// Children in the assembly tree; the second one is the front right before this one.
    children: Option<(usize, usize)>,
    /// Start of its panel among the panels of the subdomain.
    panel: usize,
}

/// Symbolic factorisation of a subdomain, which does not depend on the values of the matrix.
#[derive(Debug)]
pub(super) struct Subdomain {
    /// Number of the subdomain.
    pub number: u32,
    fronts: Vec<Front>,
    /// Start of the blocks and start of the vectors of each term, in tree order; then the ends.
    terms: Vec<[u32; 2]>,
    /// Vectors of the terms, as indices of `vectors`.
    term_vectors: Vec<u32>,
    /// Nodal vectors with free degrees of freedom, and the places of these; the last entry stands for all vectors
    /// without any.
    vectors: Vec<(u32, [u32; 3])>,
    /// Free degree of freedom at each place: interior unknowns, then dual unknowns, then primal unknowns.
    pub unknowns: Vec<u32>,
    /// Number of interior unknowns.
    pub inner: usize,
    /// Number of dual unknowns: on the interface, but not primal.
    pub dual: usize,
    /// Number of entries in the panels of all fronts.
    panels: usize,
    /// Largest size of the contribution-block stack.
    stack: usize,
}

/// Roles of the unknowns of the mesh in a subdomain.
pub(super) struct Roles<'a> {
    pub frames: &'a LocalFrames,
    /// Whether several subdomains share a vector.
    pub shared: &'a dyn Fn(u32) -> bool,
    /// Whether a vector belongs to a primal node.
    pub primal: &'a dyn Fn(u32) -> bool,
}

impl Subdomain {
    /// Symbolic factorisation of the subdomain of some elements; `terms_of` gives the terms of an element. Returns with
    /// it the number of each of its terms, in tree order.
    ///
    /// # Errors
    /// The blocks are too many to be indexed.
    pub fn new(
        quads: &Quads<'_>,
        terms: &Terms,
        terms_of: &dyn Fn(u32) -> Vec<u32>,
        mut cells: Vec<u32>,
        roles: &Roles<'_>,
    ) -> Result<(Self, Vec<u32>), FactorError> {
        let branches = tree(quads, &mut cells, LEAF);
        let mut order = Vec::new();
        let mut term_start = vec![0];
        for &cell in &cells {
            order.extend(terms_of(cell));
            term_start.push(order.len());
        }
        // Vectors with free degrees of freedom, and the first and the last of the cells that touch each.
        let mut number: HashMap<u32, u32> = HashMap::new();
        let mut vectors: Vec<u32> = Vec::new();
        let mut span: Vec<(usize, usize)> = Vec::new();
        let mut touched: Vec<Vec<u32>> = vec![Vec::new(); cells.len()];
        for (c, touched) in touched.iter_mut().enumerate() {
            for &t in &order[term_start[c]..term_start[c + 1]] {
                for &v in terms.vectors(t as usize) {
                    if roles.frames.of(v as usize).iter().all(|&n| n == CONSTRAINED) {
                        continue;
                    }
                    let n = *number.entry(v).or_insert_with(|| {
                        vectors.push(v);
                        span.push((c, c));
                        (vectors.len() - 1) as u32
                    });
                    span[n as usize].1 = c;
                    touched.push(n);
                }
            }
            touched.sort_unstable();
            touched.dedup();
        }
        let shared: Vec<bool> = vectors.iter().map(|&v| (roles.shared)(v)).collect();
        // Branch in which each vector is eliminated.
        let mut columns: Vec<Vec<u32>> = vec![Vec::new(); branches.len()];
        for (n, &(low, high)) in span.iter().enumerate() {
            if shared[n] {
                continue;
            }
            let mut b = branches.len() - 1;
            while let Some((left, right)) = branches[b].children {
                let within = |b: usize| branches[b].cells.contains(&low) && branches[b].cells.contains(&high);
                if within(left) {
                    b = left;
                } else if within(right) {
                    b = right;
                } else {
                    break;
                }
            }
            columns[b].push(n as u32);
        }
        let mut out = Self {
            number: 0,
            fronts: Vec::with_capacity(branches.len()),
            terms: Vec::with_capacity(order.len()),
            term_vectors: Vec::new(),
            vectors: vectors.iter().map(|&v| (v, [NONE; 3])).collect(),
            unknowns: Vec::new(),
            inner: 0,
            dual: 0,
            panels: 0,
            stack: 0,
        };
        let mut bounds = Vec::with_capacity(branches.len());
        for columns in &columns {
            let first = out.unknowns.len();
            out.place(columns.iter().copied(), roles.frames);
            bounds.push((first, out.unknowns.len() - first));
        }
        out.inner = out.unknowns.len();
        let interface_size = |corner: bool| {
            let mut of: Vec<u32> = (0..vectors.len() as u32)
                .filter(|&n| shared[n as usize] && (roles.primal)(vectors[n as usize]) == corner)
                .collect();
            of.sort_unstable_by_key(|&n| vectors[n as usize]);
            of
        };
        out.place(interface_size(false).into_iter(), roles.frames);
        out.dual = out.unknowns.len() - out.inner;
        out.place(interface_size(true).into_iter(), roles.frames);
        // Rows of each front: unknowns of its children's rows or of its cells, without those that are eliminated.
        let mut rows: Vec<Vec<u32>> = Vec::with_capacity(branches.len());
        for (b, branch) in branches.iter().enumerate() {
            let (first, width) = bounds[b];
            let mut here: Vec<u32> = match branch.children {
                Some((left, right)) => rows[left].iter().chain(&rows[right]).copied().collect(),
                None => touched[branch.cells.clone()]
                    .iter()
                    .flatten()
                    .flat_map(|&n| out.vectors[n as usize].1)
                    .filter(|&p| p != NONE)
                    .collect(),
            };
            here.retain(|&p| !(first..first + width).contains(&(p as usize)));
            here.sort_unstable();
            here.dedup();
            rows.push(here);
        }
        let mut held = 0;
        for (b, (branch, rows)) in branches.iter().zip(rows).enumerate() {
            let (first, width) = bounds[b];
            let own = rows.len().pow(2);
            out.stack = out.stack.max(held + own);
            let passed = |f: usize| out.fronts.get(f).map_or(0, |f: &Front| f.rows.len().pow(2));
            held += own;
            held -= branch.children.map_or(0, |(l, r)| passed(l) + passed(r));
            let terms = match branch.children {
                Some(_) => 0..0,
                None => term_start[branch.cells.start]..term_start[branch.cells.end],
            };
            let panel = out.panels;
            out.panels += width * (width + rows.len());
            out.fronts.push(Front { first, width, rows, terms, children: branch.children, panel });
        }
        // One more entry for the vectors without free degrees of freedom.
        let without = out.vectors.len() as u32;
        out.vectors.push((0, [NONE; 3]));
        let index = |n: usize| u32::try_from(n).map_err(|_| FactorError::TooLarge);
        let mut blocks = 0;
        for &t in &order {
            out.terms.push([index(blocks)?, index(out.term_vectors.len())?]);
            let of = terms.vectors(t as usize);
            out.term_vectors.extend(of.iter().map(|v| number.get(v).copied().unwrap_or(without)));
            blocks += 9 * of.len() * (of.len() + 1) / 2;
        }
        out.terms.push([index(blocks)?, index(out.term_vectors.len())?]);
        Ok((out, order))
    }

    fn place(&mut self, vectors: impl Iterator<Item = u32>, frames: &LocalFrames) {
        for n in vectors {
            let (v, places) = &mut self.vectors[n as usize];
            for (place, number) in places.iter_mut().zip(frames.of(*v as usize)) {
                if number != CONSTRAINED {
                    *place = self.unknowns.len() as u32;
                    self.unknowns.push(number);
                }
            }
        }
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
        self.terms.last().map_or(0, |end| end[0] as usize)
    }

    /// Range of the blocks of one term.
    pub fn term(&self, term: usize) -> Range<usize> {
        self.terms[term][0] as usize..self.terms[term + 1][0] as usize
    }

    /// Shifts of the diagonal of this subdomain: shifts of nodal vectors, divided by the number of subdomains that
    /// share them, which `subdomains` gives for an interface unknown. Empty without shifts.
    pub fn shifts(&self, shifts: &[f64], subdomains: impl Fn(usize) -> usize) -> Vec<f64> {
        if shifts.is_empty() {
            return Vec::new();
        }
        let mut out = vec![0.0; self.unknowns.len()];
        for (v, places) in &self.vectors {
            for p in places.iter().filter(|p| **p != NONE).map(|&p| p as usize) {
                let share = if p < self.inner { 1 } else { subdomains(p - self.inner) };
                out[p] = shifts[*v as usize] / share as f64;
            }
        }
        out
    }

    /// Assembles the blocks of a leaf's terms in its panel and in its contribution block.
    fn enter(
        &self,
        front: &Front,
        place: &[u32],
        (blocks, frames): (&[f64], &LocalFrames),
        panel: &mut [f64],
        out: &mut [f64],
    ) {
        let (width, below) = (front.width, front.rows.len());
        let height = width + below;
        for t in front.terms.clone() {
            let [mut at, start] = self.terms[t].map(|x| x as usize);
            let members = &self.term_vectors[start..self.terms[t + 1][1] as usize];
            for (a, &va) in members.iter().enumerate() {
                let (vector_a, places_a) = self.vectors[va as usize];
                let rows = places_a.map(|p| if p == NONE { NONE } else { place[p as usize] });
                for &vb in &members[..=a] {
                    let (vector_b, places_b) = self.vectors[vb as usize];
                    let mut k: [f64; 9] = std::array::from_fn(|i| blocks[at + i]);
                    at += 9;
                    if rows == [NONE; 3] || places_b == [NONE; 3] {
                        continue;
                    }
                    frames.rotate(&mut k, vector_a as usize, vector_b as usize);
                    for (c, &p) in places_b.iter().enumerate() {
                        if p == NONE {
                            continue;
                        }
                        let column = place[p as usize];
                        for (r, &row) in rows.iter().enumerate() {
                            if row == NONE || (va == vb && row < column) {
                                continue;
                            }
                            let (i, j) = (row.max(column) as usize, row.min(column) as usize);
                            if j < width {
                                panel[j * height + i] += k[3 * r + c];
                            } else {
                                out[(j - width) * below + i - width] += k[3 * r + c];
                            }
                        }
                    }
                }
            }
        }
    }

    /// Eliminates the interior unknowns and factors the Schur complement on the interface. Returns the factors and the
    /// Schur complement at the primal unknowns, after elimination of the dual unknowns, too: lower triangle by columns.
    ///
    /// # Errors
    /// A pivot is not positive, or the memory does not suffice.
    pub fn factor(
        &self,
        blocks: &[f64],
        frames: &LocalFrames,
        shifts: &[f64],
        scratch: &mut Scratch,
    ) -> Result<(Factored, Vec<f64>), Refused> {
        let mut panels = zeros(self.panels).map_err(Refused::from)?;
        let Scratch { stack, place, dense, factor, square, coarse } = scratch;
        if stack.len() < self.stack {
            *stack = zeros(self.stack)?;
        }
        place.clear();
        place.resize(self.unknowns.len(), NONE);
        let interface_size = self.interface_size();
        square.clear();
        square.resize(interface_size * interface_size, 0.0);
        let mut top = 0;
        let last = self.fronts.len() - 1;
        for (f, front) in self.fronts.iter().enumerate() {
            let (width, below) = (front.width, front.rows.len());
            let (height, own) = (width + below, below * below);
            for j in 0..width {
                place[front.first + j] = j as u32;
            }
            for (i, &row) in front.rows.iter().enumerate() {
                place[row as usize] = (width + i) as u32;
            }
            let (held, free) = stack.split_at_mut(top);
            let next = if f == last { square.as_mut_slice() } else { &mut free[..own] };
            next.fill(0.0);
            let panel = &mut panels[front.panel..front.panel + width * height];
            self.enter(front, place, (blocks, frames), panel, next);
            let mut passed = 0;
            if let Some((left, right)) = front.children {
                let sizes = [left, right].map(|c| self.fronts[c].rows.len().pow(2));
                passed = sizes[0] + sizes[1];
                let (a, b) = held[top - passed..].split_at(sizes[0]);
                for (c, from) in [(left, a), (right, b)] {
                    add(&self.fronts[c].rows, place, from, (width, below), panel, next);
                }
            }
            if let Some(shifts) = shifts.get(front.first..front.first + width) {
                shifts.iter().enumerate().for_each(|(j, shift)| panel[j * height + j] += shift);
            }
            if width > 0 {
                let need = cholesky_in_place_scratch::<f64>(width, Par::Seq, Default::default());
                let dense = dense.hold(need)?;
                eliminate((width, below), panel, next, dense).map_err(|NotPositive| Refused::Inner)?;
            }
            if f != last {
                stack.copy_within(top..top + own, top - passed);
                top = top - passed + own;
            }
        }
        if let Some(shifts) = shifts.get(self.inner..) {
            shifts.iter().enumerate().for_each(|(j, shift)| square[j * interface_size + j] += shift);
        }
        let primal = self.primal();
        coarse.clear();
        coarse.resize(primal * primal, 0.0);
        for j in 0..primal {
            let from = (self.dual + j) * interface_size + self.dual;
            coarse[j * primal + j..(j + 1) * primal].copy_from_slice(&square[from + j..from + primal]);
        }
        factor.clear();
        factor.extend_from_slice(&square[..self.dual * interface_size]);
        if self.dual > 0 {
            let need = cholesky_in_place_scratch::<f64>(self.dual, Par::Seq, Default::default());
            let dense = dense.hold(need)?;
            eliminate((self.dual, primal), factor, coarse, dense).map_err(|NotPositive| Refused::Border)?;
        }
        let schur = SchurComplement::new(square, factor, (interface_size, self.dual))?;
        let left = (0..primal).flat_map(|j| &coarse[j * primal + j..(j + 1) * primal]).copied().collect();
        Ok((Factored { panels, schur }, left))
    }

    /// Forward substitution `L y = b` for the interior unknowns, whose contribution is subtracted from the interface
    /// unknowns.
    pub fn forward(&self, factored: &Factored, x: &mut [f64], rows: &mut Vec<f64>) {
        for front in self.fronts.iter().filter(|f| f.width > 0) {
            let (first, second) = panel(&factored.panels, front);
            let x_own = &mut x[front.first..front.first + front.width];
            let mut x_own = MatMut::from_column_major_slice_mut(x_own, front.width, 1);
            solve_lower_triangular_in_place(first, x_own.rb_mut(), Par::Seq);
            if front.rows.is_empty() {
                continue;
            }
            rows.clear();
            rows.resize(front.rows.len(), 0.0);
            let y = MatMut::from_column_major_slice_mut(rows, front.rows.len(), 1);
            matmul(y, Accum::Replace, second, x_own.rb(), 1.0, Par::Seq);
            for (&row, y) in front.rows.iter().zip(rows.iter()) {
                x[row as usize] -= y;
            }
        }
    }

    /// Backward substitution `Lᵀ x = y` for the interior unknowns; the interface unknowns hold the solution.
    pub fn backward(&self, factored: &Factored, x: &mut [f64], rows: &mut Vec<f64>) {
        for front in self.fronts.iter().rev().filter(|f| f.width > 0) {
            let (first, second) = panel(&factored.panels, front);
            rows.clear();
            rows.extend(front.rows.iter().map(|&row| x[row as usize]));
            let x_own = &mut x[front.first..front.first + front.width];
            let mut x_own = MatMut::from_column_major_slice_mut(x_own, front.width, 1);
            if !rows.is_empty() {
                let y = MatRef::from_column_major_slice(rows, rows.len(), 1);
                matmul(x_own.rb_mut(), Accum::Add, second.transpose(), y, -1.0, Par::Seq);
            }
            solve_upper_triangular_in_place(first.transpose(), x_own, Par::Seq);
        }
    }
}

fn panel<'a>(panels: &'a [f64], front: &Front) -> (MatRef<'a, f64>, MatRef<'a, f64>) {
    let height = front.width + front.rows.len();
    let panel = &panels[front.panel..front.panel + height * front.width];
    MatRef::from_column_major_slice(panel, height, front.width).split_at_row(front.width)
}

/// Extend-add: adds a child's contribution block to the panel and to the contribution block of its parent.
fn add(
    rows: &[u32],
    place: &[u32],
    from: &[f64],
    (width, below): (usize, usize),
    panel: &mut [f64],
    out: &mut [f64],
) {
    let (m, height) = (rows.len(), width + below);
    for j in 0..m {
        let column = place[rows[j] as usize] as usize;
        let source = &from[j * m + j..(j + 1) * m];
        let (target, shift) = if column < width {
            (&mut panel[column * height..(column + 1) * height], 0)
        } else {
            (&mut out[(column - width) * below..(column - width + 1) * below], width)
        };
        for (&row, value) in rows[j..].iter().zip(source) {
            target[place[row as usize] as usize - shift] += value;
        }
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

impl From<FactorError> for Refused {
    fn from(e: FactorError) -> Self {
        Self::Factor(e)
    }
}

/// Factors of a subdomain.
#[derive(Debug)]
pub(super) struct Factored {
    /// Panels of all fronts.
    panels: Vec<f64>,
    /// Schur complement on the interface.
    pub schur: SchurComplement,
}

/// Workspace of a thread.
#[derive(Default)]
pub(super) struct Scratch {
    stack: Vec<f64>,
    place: Vec<u32>,
    /// Schur complement on the interface; `factor` is its factor, `coarse` the Schur complement at the primal unknowns.
    square: Vec<f64>,
    factor: Vec<f64>,
    coarse: Vec<f64>,
    dense: Dense,
}

/// Workspace of the dense kernels.
#[derive(Default)]
struct Dense(Option<(usize, MemBuffer)>);

impl Dense {
    fn hold(&mut self, need: dyn_stack::StackReq) -> Result<&mut MemBuffer, FactorError> {
        let size = need.unaligned_bytes_required();
        if self.0.as_ref().is_none_or(|(have, _)| *have < size) {
            self.0 = Some((size, MemBuffer::try_new(need).map_err(|_| FactorError::TooLarge)?));
        }
        match &mut self.0 {
            Some((_, buffer)) => Ok(buffer),
            None => Err(FactorError::TooLarge),
        }
    }
}
