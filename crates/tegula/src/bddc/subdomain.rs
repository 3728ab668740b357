//! A piece of a shell: its unknowns in the order of their elimination, the fronts in which the inner ones are
//! eliminated, and what is left at its border.
//!
//! The elements of a piece are halved again and again. A nodal vector is eliminated in the smallest half in which
//! all of its elements lie; the rest goes up the tree. What reaches the root are the unknowns of the border with
//! the matrix `S = K_BB − K_BI K_II⁻¹ K_IB`.

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
use crate::system::Numbering;
use crate::system::numbering::CONSTRAINED;
use tegula_sparse::FactorError;
use tegula_sparse::zeros;

/// Elements of the smallest halves.
const LEAF: usize = 6;

/// Marks a coordinate that is not free.
const NONE: u32 = u32::MAX;

/// A dense matrix of unknowns that are eliminated in it and of those that it passes on.
#[derive(Debug)]
struct Front {
    /// First unknown that is eliminated here.
    first: usize,
    /// How many.
    width: usize,
    /// Unknowns that are passed on, ascending.
    rows: Vec<u32>,
    /// Terms that enter here.
    terms: Range<usize>,
    /// The two fronts before it in the tree, the second is the one right before.
    children: Option<(usize, usize)>,
    /// Where its columns begin among the factors of the piece.
    panel: usize,
}

/// What does not change with the matrix.
#[derive(Debug)]
pub(super) struct Subdomain {
    /// Its number.
    pub number: u32,
    fronts: Vec<Front>,
    /// Terms in the order of the tree: where their blocks begin, and where their vectors do; then the ends.
    terms: Vec<[u32; 2]>,
    /// Vectors of the terms, as numbers in `vectors`.
    term_vectors: Vec<u32>,
    /// Nodal vectors with free coordinates, and the places of those coordinates; the last one stands for all without.
    vectors: Vec<(u32, [u32; 3])>,
    /// Free coordinate at each place: inner ones, then dual ones, then those of the corners.
    pub unknowns: Vec<u32>,
    /// Inner unknowns.
    pub inner: usize,
    /// Dual unknowns: of the border but not of a corner.
    pub dual: usize,
    /// Numbers in the panels of all fronts.
    panels: usize,
    /// Largest stack of what waits to be passed on.
    stack: usize,
}

/// What the unknowns of the mesh are to a piece.
pub(super) struct Roles<'a> {
    pub numbering: &'a Numbering,
    /// Vectors that several pieces share.
    pub shared: &'a dyn Fn(u32) -> bool,
    /// Vectors of corners.
    pub primal: &'a dyn Fn(u32) -> bool,
}

impl Subdomain {
    /// Analyses the piece of some elements; `terms_of` gives the terms of an element. Returns with it, for each
    /// term in order, its number.
    ///
    /// # Errors
    /// Its blocks are too many to be indexed.
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
        // Vectors with free coordinates, and first and last of the cells that touch them.
        let mut number: HashMap<u32, u32> = HashMap::new();
        let mut vectors: Vec<u32> = Vec::new();
        let mut span: Vec<(usize, usize)> = Vec::new();
        let mut touched: Vec<Vec<u32>> = vec![Vec::new(); cells.len()];
        for (c, touched) in touched.iter_mut().enumerate() {
            for &t in &order[term_start[c]..term_start[c + 1]] {
                for &v in terms.vectors(t as usize) {
                    if roles.numbering.of(v as usize).iter().all(|&n| n == CONSTRAINED) {
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
        // The branch in which each vector is eliminated.
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
            out.place(columns.iter().copied(), roles.numbering);
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
        out.place(interface_size(false).into_iter(), roles.numbering);
        out.dual = out.unknowns.len() - out.inner;
        out.place(interface_size(true).into_iter(), roles.numbering);
        // Rows: what the halves or the cells touch, without what is eliminated.
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
        // One more for the vectors without free coordinates.
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

    fn place(&mut self, vectors: impl Iterator<Item = u32>, numbering: &Numbering) {
        for n in vectors {
            let (v, places) = &mut self.vectors[n as usize];
            for (place, number) in places.iter_mut().zip(numbering.of(*v as usize)) {
                if number != CONSTRAINED {
                    *place = self.unknowns.len() as u32;
                    self.unknowns.push(number);
                }
            }
        }
    }

    /// Unknowns of the border.
    pub fn interface_size(&self) -> usize {
        self.unknowns.len() - self.inner
    }

    /// Unknowns at corners.
    pub fn primal(&self) -> usize {
        self.interface_size() - self.dual
    }

    /// Numbers in the blocks of all terms.
    pub fn blocks(&self) -> usize {
        self.terms.last().map_or(0, |end| end[0] as usize)
    }

    /// Those of one term.
    pub fn term(&self, term: usize) -> Range<usize> {
        self.terms[term][0] as usize..self.terms[term + 1][0] as usize
    }

    /// What is added to the diagonal of this piece: shifts of nodal vectors, divided by the number of pieces where
    /// they are shared. `pieces` gives that for an unknown of the border. Empty: nothing is.
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

    /// Adds the blocks of a leaf's terms to its columns and to what it passes on.
    fn enter(
        &self,
        front: &Front,
        place: &[u32],
        (blocks, numbering): (&[f64], &Numbering),
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
                    numbering.rotate(&mut k, vector_a as usize, vector_b as usize);
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

    /// Eliminates the inner unknowns and factors what is left at the border. Returns with the factors what is left at
    /// the corners when the dual unknowns are eliminated, too: lower triangle by columns.
    ///
    /// # Errors
    /// A pivot is not positive, or the memory does not suffice.
    pub fn factor(
        &self,
        blocks: &[f64],
        numbering: &Numbering,
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
            self.enter(front, place, (blocks, numbering), panel, next);
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

    /// `L y = b` for the inner unknowns; what they leave at the border is taken off there.
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

    /// `Lᵀ x = y` for the inner unknowns; the border holds the solution.
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

/// Adds what a half passes on to columns and rows of the whole.
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

/// Why a piece could not be factored.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Refused {
    /// The inner unknowns have a pivot that is not positive.
    Inner,
    /// Those of the border have, with the corners held.
    Border,
    /// Something else.
    Factor(FactorError),
}

impl From<FactorError> for Refused {
    fn from(e: FactorError) -> Self {
        Self::Factor(e)
    }
}

/// The factors of a piece.
#[derive(Debug)]
pub(super) struct Factored {
    /// Columns of all fronts.
    panels: Vec<f64>,
    /// Matrix of the border.
    pub schur: SchurComplement,
}

/// Memory of a thread.
#[derive(Default)]
pub(super) struct Scratch {
    stack: Vec<f64>,
    place: Vec<u32>,
    /// Matrix of the border, its factor, and what is left at the corners.
    square: Vec<f64>,
    factor: Vec<f64>,
    coarse: Vec<f64>,
    dense: Dense,
}

/// Memory of the dense kernels.
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
