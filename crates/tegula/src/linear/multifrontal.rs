//! Multifrontal Cholesky factorisation over faer's dense kernels, with independent subtrees in parallel.
//!
//! Every front adds the entries of its columns and what its children pass on, eliminates its columns and passes on
//! the rest, `C − L₂₁ L₂₁ᵀ`. Subtrees do not know of each other: large ones are split between threads, small ones are
//! worked off one front after another with what waits on a stack. Children are added in a fixed order, so the
//! result does not depend on the threads. Nothing is allocated after the analysis.
//!
//! J. W. H. Liu, *The multifrontal method for sparse matrix solution*, SIAM Review 34 (1992) 82–109.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{BlockStructure, matmul as triangular_matmul};
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_unit_lower_triangular_in_place,
    solve_unit_upper_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, MatMut, MatRef, Par};

use super::assembly_tree::{AssemblyTree, Front};
use super::ordering::Quotient;
use super::pivoted::Pivots;
use super::{FactorError, Inertia};

/// Work (operations) below which a subtree is not split.
const GRAIN: f64 = 2e7;

/// Why a factorisation ended early.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::linear) enum Stop {
    /// A pivot is not positive.
    NotPositive,
    /// Not enough memory.
    Memory,
}

/// Cholesky factor of matrices of one pattern.
pub(super) struct Multifrontal {
    tree: AssemblyTree,
    /// Panels of all fronts, by columns.
    factor: Vec<f64>,
    /// What fronts pass on whose parents are split, while it waits.
    passed: Vec<Vec<f64>>,
    /// Memory for that, to be used again.
    pool: Mutex<Vec<Vec<f64>>>,
    /// Number of such fronts before each front.
    passed_before: Vec<u32>,
    /// Whether the subtree of a front is split between threads.
    split: Vec<bool>,
    /// Stacks of the subtrees at work, one for each thread.
    stacks: Vec<Mutex<Scratch>>,
    /// Memory of the dense kernels for each front whose subtree is split. Not that of the thread: a thread that
    /// waits within a kernel may take up another subtree meanwhile.
    kernels: BTreeMap<usize, Mutex<MemBuffer>>,
    /// Pivots of an indefinite matrix; made when the first is met.
    pivots: Option<Box<Pivots>>,
    /// Whether the last matrix was factored with them.
    pivoted: bool,
    /// Vectors of all columns and of all rows.
    columns: Vec<f64>,
    rows: Vec<f64>,
}

struct Scratch {
    stack: Vec<f64>,
    dense: MemBuffer,
}

impl Multifrontal {
    /// Analyses a lower triangle in compressed columns.
    pub fn new(pointers: &[usize], rows: &[u32]) -> Result<Self, FactorError> {
        let quotient = Quotient::new(pointers, rows);
        let order = quotient.minimum_degree()?;
        let tree = AssemblyTree::new(&quotient, &order, pointers, rows)?;
        let n = tree.fronts.len();
        let threads = rayon::current_num_threads();
        let total: f64 = tree.fronts.iter().filter(|f| f.parent.is_none()).map(|f| f.work).sum();
        let grain = (total / (8.0 * threads as f64)).max(GRAIN);
        let split: Vec<bool> = (0..n)
            .map(|f| threads > 1 && tree.fronts[f].work > grain && !tree.children[f].is_empty())
            .collect();
        let waits = |f: &Front| f.parent.is_some_and(|p| split[p as usize]);
        let mut passed = Vec::new();
        let mut passed_before = Vec::with_capacity(n + 1);
        for front in &tree.fronts {
            passed_before.push(passed.len() as u32);
            if waits(front) {
                passed.push(Vec::new());
            }
        }
        passed_before.push(passed.len() as u32);
        let stack = stack_size(&tree, &split);
        let widest = tree.fronts.iter().map(|f| f.width).max().unwrap_or(0);
        let dense = |width: usize| {
            let request = cholesky_in_place_scratch::<f64>(width, Par::Seq, Default::default());
            MemBuffer::try_new(request).map_err(|_| FactorError::TooLarge)
        };
        let kernel = |f: usize| Ok::<_, FactorError>((f, Mutex::new(dense(tree.fronts[f].width)?)));
        let kernels = (0..n).filter(|&f| split[f]).map(kernel).collect::<Result<_, _>>()?;
        let scratch = || -> Result<_, FactorError> {
            Ok(Mutex::new(Scratch { stack: zeros(stack)?, dense: dense(widest)? }))
        };
        let stacks = (0..threads).map(|_| scratch()).collect::<Result<_, _>>()?;
        Ok(Self {
            factor: zeros(tree.size)?,
            pivots: None,
            pivoted: false,
            columns: zeros(pointers.len() - 1)?,
            rows: zeros(tree.rows)?,
            tree,
            pool: Mutex::new(Vec::with_capacity(passed.len())),
            passed,
            passed_before,
            split,
            stacks,
            kernels,
        })
    }

    /// Entries of the factor.
    pub fn entries(&self) -> usize {
        self.tree.size
    }

    /// Factors the matrix with the given values.
    ///
    /// # Errors
    /// A pivot is not positive, or the memory does not suffice.
    pub fn factor(&mut self, values: &[f64]) -> Result<(), Stop> {
        self.pivoted = false;
        let numeric = Numeric {
            tree: &self.tree,
            split: &self.split,
            passed_before: &self.passed_before,
            stacks: &self.stacks,
            kernels: &self.kernels,
            pool: &self.pool,
            values,
        };
        let (mut factor, mut passed) = (self.factor.as_mut_slice(), self.passed.as_mut_slice());
        for (f, _) in self.tree.fronts.iter().enumerate().filter(|(_, front)| front.parent.is_none()) {
            let (mine, rest) = factor.split_at_mut(numeric.panels(f).len());
            let (waiting, others) = passed.split_at_mut(numeric.waiting(f).len());
            let mut nothing = Vec::new();
            let done = numeric.subtree(f, mine, waiting, &mut nothing);
            (factor, passed) = (rest, others);
            if done.is_err() {
                // What was left behind would be in the way of the next matrix.
                self.passed.iter_mut().for_each(|slot| numeric.give_back(slot));
                return done;
            }
        }
        Ok(())
    }

    /// Factors any symmetric matrix as LBLᵀ and tells its inertia.
    ///
    /// # Errors
    /// The matrix is singular, or the memory does not suffice.
    pub fn factor_pivoted(&mut self, values: &[f64]) -> Result<Inertia, FactorError> {
        let mut pivots = match self.pivots.take() {
            Some(made) => made,
            None => Box::new(Pivots::new(&self.tree)?),
        };
        let inertia = pivots.factor(&self.tree, values, &mut self.factor);
        self.pivots = Some(pivots);
        self.pivoted = true;
        inertia
    }

    /// Solves in place with the factor.
    pub fn solve(&mut self, right_side: &mut [f64]) {
        let Self { tree, factor, split, columns, rows, pivots, pivoted, .. } = self;
        for (x, &old) in columns.iter_mut().zip(&tree.order) {
            *x = right_side[old as usize];
        }
        let pivots = pivots.as_deref().filter(|_| *pivoted);
        let solver = Solver { tree, factor, split, pivots };
        let (mut x, mut y) = (columns.as_mut_slice(), rows.as_mut_slice());
        for (f, front) in tree.fronts.iter().enumerate().filter(|(_, front)| front.parent.is_none()) {
            let (x_mine, x_rest) = x.split_at_mut(front.first + front.width - tree.fronts[front.leaf].first);
            let (y_mine, y_rest) =
                y.split_at_mut(front.row_start + front.rows.len() - tree.fronts[front.leaf].row_start);
            solver.forward(f, x_mine, y_mine);
            solver.backward(f, x_mine, y_mine);
            (x, y) = (x_rest, y_rest);
        }
        for (x, &old) in columns.iter().zip(&tree.order) {
            right_side[old as usize] = *x;
        }
    }
}

pub(super) fn zeros(n: usize) -> Result<Vec<f64>, FactorError> {
    let mut out = Vec::new();
    out.try_reserve_exact(n).map_err(|_| FactorError::TooLarge)?;
    out.resize(n, 0.0);
    Ok(out)
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Largest stack of a subtree that is not split: what waits, and what the front at work makes.
fn stack_size(tree: &AssemblyTree, split: &[bool]) -> usize {
    let mut most = 0;
    let mut held = 0_usize;
    for (f, front) in tree.fronts.iter().enumerate() {
        if split[f] {
            continue;
        }
        let own = front.rows.len().pow(2);
        most = most.max(held + own);
        held = held + own - tree.passed_by_children(f);
        if front.parent.is_none_or(|p| split[p as usize]) {
            held = 0;
        }
    }
    most
}

/// What all fronts need to be factored.
struct Numeric<'a> {
    tree: &'a AssemblyTree,
    split: &'a [bool],
    passed_before: &'a [u32],
    stacks: &'a [Mutex<Scratch>],
    kernels: &'a BTreeMap<usize, Mutex<MemBuffer>>,
    pool: &'a Mutex<Vec<Vec<f64>>>,
    values: &'a [f64],
}

impl Numeric<'_> {
    /// Where the panels of a subtree lie.
    fn panels(&self, f: usize) -> std::ops::Range<usize> {
        let front = &self.tree.fronts[f];
        self.tree.fronts[front.leaf].panel..front.panel + front.height() * front.width
    }

    /// Fronts within a subtree, itself left out, whose parents are split.
    fn waiting(&self, f: usize) -> std::ops::Range<usize> {
        self.passed_before[self.tree.fronts[f].leaf] as usize..self.passed_before[f] as usize
    }

    /// Factors a subtree; `panels` and `waiting` are its own, `out` receives memory with what it passes on.
    fn subtree(
        &self,
        f: usize,
        panels: &mut [f64],
        waiting: &mut [Vec<f64>],
        out: &mut Vec<f64>,
    ) -> Result<(), Stop> {
        let front = &self.tree.fronts[f];
        let own = front.rows.len().pow(2);
        if !self.split[f] {
            *out = self.take(own)?;
            return self.one_after_another(f, panels, &mut out[..own]);
        }
        let children = &self.tree.children[f];
        let (below, panel) = panels.split_at_mut(front.panel - self.tree.fronts[front.leaf].panel);
        self.children(children, below, waiting)?;
        *out = self.take(own)?;
        let out = &mut out[..own];
        panel.fill(0.0);
        out.fill(0.0);
        self.tree.enter(f, self.values, panel);
        for &c in children {
            let at = self.passed_before[c as usize] as usize - self.passed_before[front.leaf] as usize;
            add(front, &self.tree.fronts[c as usize], &waiting[at], panel, out);
            self.give_back(&mut waiting[at]);
        }
        let par = if self.stacks.len() > 1 { Par::rayon(self.stacks.len()) } else { Par::Seq };
        let Some(dense) = self.kernels.get(&f) else { return Err(Stop::Memory) };
        eliminate((front.width, front.rows.len()), panel, out, &mut locked(dense), par)
    }

    /// Factors subtrees that have one parent, halves of them in parallel.
    fn children(&self, children: &[u32], panels: &mut [f64], waiting: &mut [Vec<f64>]) -> Result<(), Stop> {
        match children {
            [] => Ok(()),
            &[c] => {
                let c = c as usize;
                let Some((out, inner)) = waiting.split_last_mut() else { return Ok(()) };
                self.subtree(c, panels, inner, out)
            }
            _ => {
                let (a, b) = children.split_at(self.halves(children));
                let Some(&first) = b.first() else { return Ok(()) };
                let leaf = self.tree.fronts[first as usize].leaf;
                let Some(&begin) = a.first() else { return Ok(()) };
                let start = self.tree.fronts[begin as usize].leaf;
                let at = self.tree.fronts[leaf].panel - self.tree.fronts[start].panel;
                let (panels_a, panels_b) = panels.split_at_mut(at);
                let at = (self.passed_before[leaf] - self.passed_before[start]) as usize;
                let (waiting_a, waiting_b) = waiting.split_at_mut(at);
                let (x, y) = rayon::join(
                    || self.children(a, panels_a, waiting_a),
                    || self.children(b, panels_b, waiting_b),
                );
                x.and(y)
            }
        }
    }

    /// How many of the children make up half of the work.
    fn halves(&self, children: &[u32]) -> usize {
        halves(self.tree, children)
    }

    /// Factors a subtree front by front.
    fn one_after_another(&self, f: usize, panels: &mut [f64], out: &mut [f64]) -> Result<(), Stop> {
        let fronts = &self.tree.fronts;
        let start = fronts[fronts[f].leaf].panel;
        let mut scratch = self.scratch();
        let Scratch { stack, dense } = &mut *scratch;
        let mut top = 0;
        for s in fronts[f].leaf..=f {
            let front = &fronts[s];
            let own = front.rows.len().pow(2);
            let panel = &mut panels[front.panel - start..][..front.height() * front.width];
            let children = self.tree.passed_by_children(s);
            let (held, free) = stack.split_at_mut(top);
            let next = if s == f { &mut *out } else { &mut free[..own] };
            panel.fill(0.0);
            next.fill(0.0);
            self.tree.enter(s, self.values, panel);
            let mut at = top - children;
            for &c in &self.tree.children[s] {
                let child = &fronts[c as usize];
                let size = child.rows.len().pow(2);
                add(front, child, &held[at..at + size], panel, next);
                at += size;
            }
            eliminate((front.width, front.rows.len()), panel, next, dense, Par::Seq)?;
            if s != f && children > 0 {
                stack.copy_within(top..top + own, top - children);
            }
            top = top - children + own;
        }
        Ok(())
    }

    /// Memory of at least this size: the smallest that fits of what was given back, else new.
    fn take(&self, size: usize) -> Result<Vec<f64>, Stop> {
        let mut pool = locked(self.pool);
        let fits = (0..pool.len()).filter(|&k| pool[k].len() >= size).min_by_key(|&k| pool[k].len());
        match fits {
            Some(k) => Ok(pool.swap_remove(k)),
            None => zeros(size).map_err(|_| Stop::Memory),
        }
    }

    fn give_back(&self, slot: &mut Vec<f64>) {
        if !slot.is_empty() {
            locked(self.pool).push(std::mem::take(slot));
        }
    }

    /// The stack of this thread. While it is held no other work is waited for.
    fn scratch(&self) -> MutexGuard<'_, Scratch> {
        let own = rayon::current_thread_index().unwrap_or(0);
        locked(&self.stacks[own % self.stacks.len()])
    }
}

fn halves(tree: &AssemblyTree, children: &[u32]) -> usize {
    let work = |c: &u32| tree.fronts[*c as usize].work;
    let total: f64 = children.iter().map(work).sum();
    let mut sum = 0.0;
    for (k, c) in children.iter().enumerate() {
        if sum + 0.5 * work(c) > 0.5 * total {
            return k.clamp(1, children.len() - 1);
        }
        sum += work(c);
    }
    children.len() - 1
}

/// Adds what a child passes on to the panel and to what the parent passes on.
pub(super) fn add(parent: &Front, child: &Front, from: &[f64], panel: &mut [f64], out: &mut [f64]) {
    let (m, height, width) = (child.rows.len(), parent.height(), parent.width);
    let below = parent.rows.len();
    for (k, &[here, there, length]) in child.runs.iter().enumerate() {
        for j in 0..length as usize {
            let (column, place) = (here as usize + j, there as usize + j);
            let source = &from[column * m..(column + 1) * m];
            let (target, shift) = if place < width {
                (&mut panel[place * height..(place + 1) * height], 0)
            } else {
                (&mut out[(place - width) * below..(place - width + 1) * below], width)
            };
            // The rest of this run, then the runs below.
            let rest = length as usize - j;
            add_run(&mut target[place - shift..place - shift + rest], &source[column..column + rest]);
            for &[here, there, length] in &child.runs[k + 1..] {
                let (here, there, length) = (here as usize, there as usize - shift, length as usize);
                add_run(&mut target[there..there + length], &source[here..here + length]);
            }
        }
    }
}

#[inline]
fn add_run(target: &mut [f64], source: &[f64]) {
    for (t, s) in target.iter_mut().zip(source) {
        *t += s;
    }
}

/// Eliminates the columns of a front with `width` columns and `below` rows beneath them: `L₁₁ L₁₁ᵀ = A₁₁`, `L₂₁ = A₂₁ L₁₁⁻ᵀ`, and passes on `C − L₂₁ L₂₁ᵀ`.
pub(super) fn eliminate(
    (width, below): (usize, usize),
    panel: &mut [f64],
    out: &mut [f64],
    dense: &mut MemBuffer,
    par: Par,
) -> Result<(), Stop> {
    let height = width + below;
    let panel = MatMut::from_column_major_slice_with_stride_mut(panel, height, width, height);
    let (mut first, mut second) = panel.split_at_row_mut(width);
    cholesky_in_place(first.rb_mut(), Default::default(), par, MemStack::new(dense), Default::default())
        .map_err(|_| Stop::NotPositive)?;
    if below == 0 {
        return Ok(());
    }
    solve_lower_triangular_in_place(first.rb(), second.rb_mut().transpose_mut(), par);
    let out = MatMut::from_column_major_slice_mut(out, below, below);
    triangular_matmul(
        out,
        BlockStructure::TriangularLower,
        Accum::Add,
        second.rb(),
        BlockStructure::Rectangular,
        second.rb().transpose(),
        BlockStructure::Rectangular,
        -1.0,
        par,
    );
    Ok(())
}

/// Work on a subtree: its front, its columns, its rows.
type Sweep<'a> = fn(&Solver<'a>, usize, &mut [f64], &mut [f64]);

/// What the solution with the factor needs.
struct Solver<'a> {
    tree: &'a AssemblyTree,
    factor: &'a [f64],
    split: &'a [bool],
    pivots: Option<&'a Pivots>,
}

impl<'a> Solver<'a> {
    fn panel(&self, front: &Front) -> (MatRef<'_, f64>, MatRef<'_, f64>) {
        let size = front.height() * front.width;
        let panel = &self.factor[front.panel..front.panel + size];
        MatRef::from_column_major_slice_with_stride(panel, front.height(), front.width, front.height())
            .split_at_row(front.width)
    }

    /// `L y = b` in a subtree; `x` are its columns, `y` the sums of its rows.
    fn forward(&self, f: usize, x: &mut [f64], y: &mut [f64]) {
        let fronts = &self.tree.fronts;
        let begin = &fronts[fronts[f].leaf];
        if self.split[f] {
            let front = &fronts[f];
            let (x_below, x_own) = x.split_at_mut(front.first - begin.first);
            let (y_below, y_own) = y.split_at_mut(front.row_start - begin.row_start);
            self.each(&self.tree.children[f], x_below, y_below, Self::forward);
            self.forward_front(f, x_own, y_own, y_below, begin.row_start);
        } else {
            for s in fronts[f].leaf..=f {
                let front = &fronts[s];
                let x_own = &mut x[front.first - begin.first..][..front.width];
                let (y_below, y_own) = y.split_at_mut(front.row_start - begin.row_start);
                self.forward_front(s, x_own, &mut y_own[..front.rows.len()], y_below, begin.row_start);
            }
        }
    }

    fn forward_front(&self, f: usize, x: &mut [f64], y: &mut [f64], below: &[f64], start: usize) {
        let front = &self.tree.fronts[f];
        y.fill(0.0);
        for &c in &self.tree.children[f] {
            let child = &self.tree.fronts[c as usize];
            let from = &below[child.row_start - start..][..child.rows.len()];
            for &[here, there, length] in &child.runs {
                let (here, there, length) = (here as usize, there as usize, length as usize);
                let target = if there < front.width {
                    &mut x[there..there + length]
                } else {
                    &mut y[there - front.width..there - front.width + length]
                };
                add_run(target, &from[here..here + length]);
            }
        }
        let (first, second) = self.panel(front);
        let (n, m) = (x.len(), y.len());
        if let Some(pivots) = self.pivots {
            let before = x.to_vec();
            for (x, &from) in x.iter_mut().zip(&pivots.order[front.first..]) {
                *x = before[from];
            }
        }
        let mut x = MatMut::from_column_major_slice_mut(x, n, 1);
        match self.pivots {
            None => solve_lower_triangular_in_place(first, x.rb_mut(), Par::Seq),
            Some(_) => solve_unit_lower_triangular_in_place(first, x.rb_mut(), Par::Seq),
        }
        if m > 0 {
            let y = MatMut::from_column_major_slice_mut(y, m, 1);
            matmul(y, Accum::Add, second, x.rb(), -1.0, Par::Seq);
        }
    }

    /// `Lᵀ x = y` in a subtree whose `y` holds the solution at the rows of its last front.
    fn backward(&self, f: usize, x: &mut [f64], y: &mut [f64]) {
        let fronts = &self.tree.fronts;
        let begin = &fronts[fronts[f].leaf];
        if self.split[f] {
            let front = &fronts[f];
            let (x_below, x_own) = x.split_at_mut(front.first - begin.first);
            let (y_below, y_own) = y.split_at_mut(front.row_start - begin.row_start);
            self.backward_front(f, x_own, y_own, y_below, begin.row_start);
            self.each(&self.tree.children[f], x_below, y_below, Self::backward);
        } else {
            for s in (fronts[f].leaf..=f).rev() {
                let front = &fronts[s];
                let x_own = &mut x[front.first - begin.first..][..front.width];
                let (y_below, y_own) = y.split_at_mut(front.row_start - begin.row_start);
                self.backward_front(s, x_own, &mut y_own[..front.rows.len()], y_below, begin.row_start);
            }
        }
    }

    fn backward_front(&self, f: usize, x: &mut [f64], y: &mut [f64], below: &mut [f64], start: usize) {
        let front = &self.tree.fronts[f];
        let (first, second) = self.panel(front);
        let (n, m) = (x.len(), y.len());
        if let Some(pivots) = self.pivots {
            pivots.divide(front, |j| first[(j, j)], x);
        }
        {
            let mut x = MatMut::from_column_major_slice_mut(x, n, 1);
            if m > 0 {
                let y = MatRef::from_column_major_slice(y, m, 1);
                matmul(x.rb_mut(), Accum::Add, second.transpose(), y, -1.0, Par::Seq);
            }
            match self.pivots {
                None => solve_upper_triangular_in_place(first.transpose(), x, Par::Seq),
                Some(_) => solve_unit_upper_triangular_in_place(first.transpose(), x, Par::Seq),
            }
        }
        if let Some(pivots) = self.pivots {
            let before = x.to_vec();
            for (value, &to) in before.iter().zip(&pivots.order[front.first..]) {
                x[to] = *value;
            }
        }
        for &c in &self.tree.children[f] {
            let child = &self.tree.fronts[c as usize];
            let to = &mut below[child.row_start - start..][..child.rows.len()];
            for &[here, there, length] in &child.runs {
                let (here, there, length) = (here as usize, there as usize, length as usize);
                let from = if there < front.width {
                    &x[there..there + length]
                } else {
                    &y[there - front.width..there - front.width + length]
                };
                to[here..here + length].copy_from_slice(from);
            }
        }
    }

    /// Works on the subtrees of one parent, halves of them in parallel.
    fn each(&self, children: &[u32], x: &mut [f64], y: &mut [f64], work: Sweep<'a>) {
        match children {
            [] => {}
            &[c] => work(self, c as usize, x, y),
            _ => {
                let (a, b) = children.split_at(halves(self.tree, children));
                let (Some(&begin), Some(&middle)) = (a.first(), b.first()) else { return };
                let leaf = |c: u32| &self.tree.fronts[self.tree.fronts[c as usize].leaf];
                let (begin, middle) = (leaf(begin), leaf(middle));
                let (x_a, x_b) = x.split_at_mut(middle.first - begin.first);
                let (y_a, y_b) = y.split_at_mut(middle.row_start - begin.row_start);
                rayon::join(|| self.each(a, x_a, y_a, work), || self.each(b, x_b, y_b, work));
            }
        }
    }
}
