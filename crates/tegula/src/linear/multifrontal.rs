//! Multifrontal factorisation over faer's dense kernels, with independent subtrees in parallel.
//!
//! Every front adds the entries of its columns and what its children pass on, [eliminates](super::elimination) its
//! columns and passes on the rest, `C − L₂₁ L₂₁ᵀ`. Subtrees do not know of each other: large ones are [split between
//! threads](super::schedule), small ones are worked off one front after another with what waits on a stack. Children are
//! added in a fixed order and dense work is cut at fixed places, so the result is the same to the bit for any number of
//! threads. Beyond the factor, memory is taken where threads share a front, for its triangle and for what it passes on until
//! that is added to its parent, and for the pivots of blocks that are not positive definite.
//!
//! J. W. H. Liu, *The multifrontal method for sparse matrix solution*, SIAM Review 34 (1992) 82–109.

use std::ops::Range;
use std::sync::{Mutex, MutexGuard, PoisonError};

use pulp::Arch;

use super::assembly_tree::{AssemblyTree, Front};
use super::delayed::GROWTH;
use super::elimination::{Elimination, FrontPivots, half};
use super::ordering::Quotient;
use super::schedule::{Task, locked, run_all};
use super::substitution::Solver;
use super::trapezoid::{BLOCK, Trapezoid};
use super::triangle::Triangle;
use super::{FactorError, Inertia};

/// Work (operations) below which a subtree is not split.
const GRAIN: f64 = 2e7;

/// Factor of matrices of one pattern.
pub(super) struct Multifrontal {
    tree: AssemblyTree,
    /// Panels of all fronts, by block columns.
    factor: Vec<f64>,
    /// Pivots of all fronts.
    pivots: Vec<FrontPivots>,
    /// What is worked off at a time.
    tasks: Vec<Task>,
    /// Whether the subtree of a front is split between threads.
    split: Vec<bool>,
    /// Stacks of the subtrees at work, one for each thread. Solutions take the first for the sums of all rows.
    stacks: Vec<Mutex<Stack>>,
    /// Vector of all columns.
    columns: Vec<f64>,
}

/// What waits in a subtree that one thread works off, and memory for a block.
struct Stack {
    values: Vec<f64>,
    triangle: Triangle,
}

impl Multifrontal {
    /// Analyses a lower triangle in compressed columns.
    pub fn new(pointers: &[usize], rows: &[u32]) -> Result<Self, FactorError> {
        let quotient = Quotient::new(pointers, rows);
        let order = quotient.minimum_degree()?;
        Self::of_tree(AssemblyTree::new(&quotient, &order, pointers, rows)?)
    }

    fn of_tree(tree: AssemblyTree) -> Result<Self, FactorError> {
        let n = tree.fronts.len();
        let threads = rayon::current_num_threads();
        let grain = (tree.operations() / (8.0 * threads as f64)).max(GRAIN);
        let split: Vec<bool> = (0..n)
            .map(|f| threads > 1 && tree.fronts[f].work > grain && !tree.children[f].is_empty())
            .collect();
        let tasks = Task::all(&tree, &split);
        let stack = stack_size(&tree, &split);
        let stacks = (0..threads)
            .map(|thread| {
                let values = zeros(if thread == 0 { stack.max(tree.rows) } else { stack })?;
                Ok(Mutex::new(Stack { values, triangle: Triangle::new() }))
            })
            .collect::<Result<_, _>>()?;
        Ok(Self {
            factor: zeros(tree.size)?,
            pivots: (0..n).map(|_| FrontPivots::default()).collect(),
            columns: zeros(tree.order.len())?,
            tree,
            tasks,
            split,
            stacks,
        })
    }

    /// Gives back the memory of the factor.
    pub fn release(&mut self) {
        self.factor = Vec::new();
    }

    /// Entries of the factor.
    pub fn entries(&self) -> usize {
        self.tree.size
    }

    /// Operations of a factorisation.
    pub fn operations(&self) -> f64 {
        self.tree.operations()
    }

    /// Factors the matrix with the given values and tells its inertia, and how many factorisations it took: a positive
    /// pivot that is tiny beside the entries of its column does no harm to a definite matrix, but to one that turns out
    /// indefinite. Then all pivots are chosen anew, with care, and once more for columns that had to be
    /// [delayed](super::delayed).
    ///
    /// # Errors
    /// The matrix is singular, or the memory does not suffice.
    pub fn factor(&mut self, pointers: &[usize], values: &[f64]) -> Result<(Inertia, usize), FactorError> {
        let mut times = 1;
        let done = match self.factor_once(values, None) {
            Err(FactorError::Singular) => None,
            other => Some(other?).filter(|&n| n == 0 || !self.pivots_grew(pointers, values)),
        };
        let negative = match done {
            Some(negative) => negative,
            None => {
                let scales = self.scales(values);
                loop {
                    times += 1;
                    let negative = self.factor_once(values, Some(&scales))?;
                    let delayed = self.delayed();
                    if delayed.is_empty() {
                        break negative;
                    }
                    let tree = self.tree.delay(&delayed, pointers)?;
                    self.release();
                    *self = Self::of_tree(tree)?;
                }
            }
        };
        Ok((Inertia { positive: self.columns.len() - negative, negative, zero: 0 }, times))
    }

    /// Columns that are without pivots, in the order of elimination. What became of the fronts above them says nothing.
    fn delayed(&self) -> Vec<u32> {
        let mut out = Vec::new();
        let mut above = vec![false; self.tree.fronts.len()];
        for (f, (front, pivots)) in self.tree.fronts.iter().zip(&self.pivots).enumerate() {
            if !above[f] {
                out.extend(pivots.delayed.iter().map(|j| front.first as u32 + j));
            }
            if let Some(parent) = front.parent {
                above[parent as usize] |= above[f] || !pivots.delayed.is_empty();
            }
        }
        out
    }

    /// Whether a pivot is larger than `GROWTH` times the entries of its row.
    fn pivots_grew(&self, pointers: &[usize], values: &[f64]) -> bool {
        let n = self.columns.len();
        let mut size = vec![0.0; n];
        for (front, pivots) in self.tree.fronts.iter().zip(&self.pivots) {
            let layout = front.layout();
            let old = &self.tree.order[front.first..front.first + front.width];
            for (j, &old) in old.iter().enumerate() {
                size[old as usize] = self.factor[front.panel + layout.diagonal(j)].powi(2);
            }
            for pivoted in &pivots.blocks {
                let columns = pivoted.columns(front.width);
                for (&old, s) in old[columns].iter().zip(pivoted.pivots.sizes()) {
                    size[old as usize] = s;
                }
            }
        }
        if (0..n).all(|i| size[i] <= GROWTH * values[pointers[i]].abs()) {
            return false;
        }
        let scales = self.scales(values);
        // Not a number: grew, too.
        !(0..n).all(|i| size[i] <= GROWTH * scales[i] * scales[i])
    }

    /// Scales of the unknowns with which the largest entry of every row becomes about one: D. Ruiz, A scaling
    /// algorithm to equilibrate both rows and columns norms in matrices, RAL-TR-2001-034 (2001).
    fn scales(&self, values: &[f64]) -> Vec<f64> {
        let n = self.columns.len();
        let mut scale = vec![1.0; n];
        for _ in 0..4 {
            let mut largest = vec![0.0_f64; n];
            self.tree.each_entry(|k, i, j| {
                let entry = values[k].abs() / (scale[i] * scale[j]);
                largest[i] = largest[i].max(entry);
                largest[j] = largest[j].max(entry);
            });
            for (s, l) in scale.iter_mut().zip(largest).filter(|(_, l)| *l > 0.0) {
                *s *= l.sqrt();
            }
        }
        scale
    }

    /// Factors the matrix and tells how many pivots are negative. With scales of the unknowns pivots are chosen with care.
    fn factor_once(&mut self, values: &[f64], wary: Option<&[f64]>) -> Result<usize, FactorError> {
        self.pivots.iter_mut().for_each(FrontPivots::clear);
        if self.factor.is_empty() {
            self.factor = zeros(self.tree.size)?;
        }
        let Self { tree, split, tasks, stacks, factor, pivots, .. } = self;
        let numeric = Numeric { tree, stacks, values, wary, arch: Arch::new() };
        let mut rest = Part { panels: factor, pivots };
        let mut take = |task: &Task| {
            let size = task.fronts.clone().map(|f| tree.fronts[f].layout().size()).sum();
            let (mine, others) = std::mem::take(&mut rest).split_at(size, task.fronts.len());
            rest = others;
            mine
        };
        if !split.contains(&true) {
            for task in tasks {
                numeric.one_after_another(task.fronts.clone(), take(task), &mut Vec::new())?;
            }
        } else {
            // What belongs to each task, and what it passes on while that waits.
            let slots: Vec<_> =
                tasks.iter().map(|task| (Mutex::new(take(task)), Mutex::new(Vec::new()))).collect();
            run_all(tasks, stacks.len(), |t| {
                let task = &tasks[t];
                let part = std::mem::take(&mut *locked(&slots[t].0));
                let mut out = Vec::new();
                if split[task.fronts.start] {
                    let from =
                        task.children.iter().map(|&c| std::mem::take(&mut *locked(&slots[c as usize].1)));
                    numeric.together(task.fronts.start, part, from.collect(), &mut out)?;
                } else {
                    numeric.one_after_another(task.fronts.clone(), part, &mut out)?;
                }
                *locked(&slots[t].1) = out;
                Ok(())
            })?;
        }
        Ok(self.pivots.iter().flat_map(|front| &front.blocks).map(|p| p.pivots.inertia().negative).sum())
    }

    /// Solves in place with the factor.
    pub fn solve(&mut self, right_side: &mut [f64]) {
        let Self { tree, factor, split, columns, stacks, pivots, .. } = self;
        let Some(stack) = stacks.first_mut() else { return };
        let rows = &mut stack.get_mut().unwrap_or_else(PoisonError::into_inner).values[..tree.rows];
        for (x, &old) in columns.iter_mut().zip(&tree.order) {
            *x = right_side[old as usize];
        }
        Solver { tree, factor, split, pivots }.solve(columns, rows);
        for (x, &old) in columns.iter().zip(&tree.order) {
            right_side[old as usize] = *x;
        }
    }
}

/// Memory that is not touched before it is used.
pub(super) fn zeros(n: usize) -> Result<Vec<f64>, FactorError> {
    // Asks first: where there is not enough, `vec!` would end the program.
    Vec::<f64>::new().try_reserve_exact(n).map_err(|_| FactorError::TooLarge)?;
    Ok(vec![0.0; n])
}

/// Largest stack of a subtree that is not split: what waits, and what the front at work makes.
fn stack_size(tree: &AssemblyTree, split: &[bool]) -> usize {
    let mut most = 0;
    let mut held = 0_usize;
    for (f, front) in tree.fronts.iter().enumerate() {
        if split[f] {
            continue;
        }
        if front.parent.is_none_or(|p| split[p as usize]) {
            // What it passes on does not go to the stack.
            held = 0;
            continue;
        }
        let own = front.passed().size();
        most = most.max(held + own);
        held = held + own - tree.passed_by_children(f);
    }
    most
}

/// What belongs to consecutive fronts: panels and pivots.
#[derive(Default)]
struct Part<'a> {
    panels: &'a mut [f64],
    pivots: &'a mut [FrontPivots],
}

impl Part<'_> {
    fn split_at(self, panels: usize, pivots: usize) -> (Self, Self) {
        let (p, q) = self.panels.split_at_mut(panels);
        let (a, b) = self.pivots.split_at_mut(pivots);
        (Self { panels: p, pivots: a }, Self { panels: q, pivots: b })
    }
}

/// What all fronts need to be factored.
struct Numeric<'a> {
    tree: &'a AssemblyTree,
    stacks: &'a [Mutex<Stack>],
    values: &'a [f64],
    /// Scales of the unknowns, where pivots are chosen with care.
    wary: Option<&'a [f64]>,
    arch: Arch,
}

impl Numeric<'_> {
    /// Factors a front, threads together; `from` is what its children pass on, `out` receives what it passes on itself.
    fn together(
        &self,
        f: usize,
        part: Part<'_>,
        from: Vec<Vec<f64>>,
        out: &mut Vec<f64>,
    ) -> Result<(), FactorError> {
        let front = &self.tree.fronts[f];
        let (layout, passed) = (front.layout(), front.passed());
        let Part { panels: panel, pivots } = part;
        self.assemble(f, &from, (layout, 0), 0..layout.blocks(), panel);
        self.tree.enter(f, self.values, panel);
        let (pivots, triangle) = (&mut pivots[0], &mut Triangle::new());
        let mut work = Elimination { layout, pivots, triangle, parallel: true, wary: self.scales(f) };
        work.columns(panel)?;
        *out = zeros(passed.size())?;
        work.rest(panel, out);
        self.assemble(f, &from, (passed, front.width), 0..passed.blocks(), out);
        Ok(())
    }

    /// Adds what the children of a front pass on to some of its block columns, halves of them in parallel.
    fn assemble(
        &self,
        f: usize,
        from: &[Vec<f64>],
        (to, offset): (Trapezoid, usize),
        blocks: Range<usize>,
        values: &mut [f64],
    ) {
        if blocks.len() > 1 {
            let middle = half(to, &blocks);
            let (left, right) = values.split_at_mut(to.start(middle) - to.start(blocks.start));
            rayon::join(
                || self.assemble(f, from, (to, offset), blocks.start..middle, left),
                || self.assemble(f, from, (to, offset), middle..blocks.end, right),
            );
            return;
        }
        if offset == 0 {
            values.fill(0.0);
        }
        for (&c, from) in self.tree.children[f].iter().zip(from) {
            self.add(&self.tree.fronts[c as usize], from, (to, offset), &blocks, values);
        }
    }

    /// Factors a subtree front by front.
    fn one_after_another(
        &self,
        subtree: Range<usize>,
        part: Part<'_>,
        out: &mut Vec<f64>,
    ) -> Result<(), FactorError> {
        let fronts = &self.tree.fronts;
        let leaf = subtree.start;
        let start = fronts[leaf].panel;
        let mut stack = self.stack();
        let Stack { values: stack, triangle } = &mut *stack;
        let mut top = 0;
        for s in subtree.clone() {
            let front = &fronts[s];
            let last = s + 1 == subtree.end;
            let (layout, passed) = (front.layout(), front.passed());
            let own = passed.size();
            let panel = &mut part.panels[front.panel - start..][..layout.size()];
            let children = self.tree.passed_by_children(s);
            let (held, free) = stack.split_at_mut(top);
            let next = if last {
                *out = zeros(own)?;
                &mut out[..]
            } else {
                &mut free[..own]
            };
            let from_children = |to: Trapezoid, offset, values: &mut [f64]| {
                let mut at = top - children;
                for &c in &self.tree.children[s] {
                    let child = &fronts[c as usize];
                    self.add(child, &held[at..], (to, offset), &(0..to.blocks()), values);
                    at += child.passed().size();
                }
            };
            panel.fill(0.0);
            from_children(layout, 0, panel);
            self.tree.enter(s, self.values, panel);
            let mut work = Elimination {
                layout,
                pivots: &mut part.pivots[s - leaf],
                triangle,
                parallel: false,
                wary: self.scales(s),
            };
            work.columns(panel)?;
            work.rest(panel, next);
            from_children(passed, front.width, next);
            if !last && children > 0 {
                stack.copy_within(top..top + own, top - children);
            }
            top = top - children + own;
        }
        Ok(())
    }

    /// Scales of the rows of a front, where pivots are chosen with care.
    fn scales(&self, f: usize) -> Option<Vec<f64>> {
        let front = &self.tree.fronts[f];
        let scale = |place: usize| Some(self.wary?[self.tree.order[place] as usize]);
        let columns = front.first..front.first + front.width;
        columns.chain(front.rows.iter().map(|&row| row as usize)).map(scale).collect()
    }

    /// As [`add`], with the registers of this machine.
    fn add(
        &self,
        child: &Front,
        from: &[f64],
        to: (Trapezoid, usize),
        blocks: &Range<usize>,
        values: &mut [f64],
    ) {
        self.arch.dispatch(|| add(child, from, to, blocks, values));
    }

    /// The stack of this thread. While it is held no other work is waited for.
    fn stack(&self) -> MutexGuard<'_, Stack> {
        let own = rayon::current_thread_index().unwrap_or(0);
        locked(&self.stacks[own % self.stacks.len()])
    }
}

/// Adds what a child passes on to block columns of its parent: of a trapezoid whose first column has the number `offset`
/// there. `values` are those block columns.
#[inline(always)]
fn add(
    child: &Front,
    from: &[f64],
    (to, offset): (Trapezoid, usize),
    blocks: &Range<usize>,
    values: &mut [f64],
) {
    let source = child.passed();
    let start = to.start(blocks.start);
    let first = offset + blocks.start * BLOCK;
    let end = offset + (blocks.end * BLOCK).min(to.columns);
    for (k, &[here, there, length]) in child.runs.iter().enumerate() {
        let (here, there, length) = (here as usize, there as usize, length as usize);
        for place in there.max(first)..(there + length).min(end) {
            let column = here + place - there;
            let source = &from[source.diagonal(column)..];
            let target = &mut values[to.diagonal(place - offset) - start..];
            // The rest of this run, then the runs below.
            let rest = there + length - place;
            add_run(&mut target[..rest], &source[..rest]);
            for &[here, there, length] in &child.runs[k + 1..] {
                let (here, there, length) = (here as usize, there as usize, length as usize);
                add_run(&mut target[there - place..][..length], &source[here - column..][..length]);
            }
        }
    }
}

#[inline(always)]
fn add_run(target: &mut [f64], source: &[f64]) {
    for (t, s) in target.iter_mut().zip(source) {
        *t += s;
    }
}
