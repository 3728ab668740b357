//! Multifrontal LDLᵀ factorisation over faer's dense kernels, with tree-level and node-level parallelism.
//!
//! Every front assembles the original entries of its fully summed columns and the contribution blocks of its children
//! (extend-add), [eliminates](super::partial_factorization) these columns and leaves the Schur complement,
//! `C − L₂₁ L₂₁ᵀ`, as its own contribution block. Subtrees are independent: large ones are [divided among the
//! threads](super::schedule), small ones are factored front by front with a contribution-block stack. The order of the
//! extend-adds and the tiles of the dense kernels are fixed, so the result is bitwise identical for any number of
//! threads. Memory beyond the factor is needed for the diagonal block of a node-level front, for contribution blocks
//! until the parent assembles them, and for the pivots of blocks that are not positive definite.
//!
//! J. W. H. Liu, *The multifrontal method for sparse matrix solution*, SIAM Review 34 (1992) 82–109.

mod solution;

use std::ops::Range;
use std::sync::Mutex;

use pulp::Arch;

use super::assembly_tree::AssemblyTree;
use super::delayed_pivots::GROWTH;
use super::diagonal_block::DiagonalBlock;
use super::numeric::{Entries, Numeric, Part};
use super::ordering::CompressedGraph;
use super::partial_factorization::FrontPivots;
use super::schedule::{Task, locked, run_all};
use super::workspace::{Buffer, WorkspacePool, zeros};
use super::{FactorError, Inertia};

/// Work (floating-point operations) below which a subtree is not divided among threads.
const MIN_PARALLEL_FLOPS: f64 = 2e7;
/// Entries of a factor (256 MB) from which on the low-memory mode is used, at the cost of 3 % more time: subtree tasks
/// are half as large, threads wait for node-level fronts, the last fronts are stored in place of the values, and
/// contribution blocks get workspace buffers of about their own size.
const LOW_MEMORY_ENTRIES: usize = 1 << 25;

/// Multifrontal factor of matrices of one pattern.
pub(super) struct Multifrontal {
    tree: AssemblyTree,
    /// Panels of all fronts but those stored in place of the values, by block columns.
    factor: Vec<f64>,
    in_place: Option<InPlaceFronts>,
    /// Memory of the values of the matrix, or its replacement, which holds the panels of the fronts stored in place.
    value_memory: Vec<f64>,
    pivoting: Pivoting,
    /// Diagonal of the matrix.
    diagonal: Vec<f64>,
    /// Pivots of all fronts.
    pivots: Vec<FrontPivots>,
    /// Tasks of the schedule: subtrees and node-level fronts.
    tasks: Vec<Task>,
    /// Node-level fronts: fronts whose subtree is divided among threads.
    node_level: Vec<bool>,
    /// Largest size of the contribution-block stack in each task that is a subtree.
    stack_sizes: Vec<usize>,
    mode: Mode,
    /// Workspace for a diagonal block, one for each thread.
    diagonal_blocks: Vec<Mutex<DiagonalBlock>>,
    /// Workspace pool for contribution blocks and for the row sums of a solution.
    workspace: WorkspacePool,
    /// Vector of all columns in elimination order, for a solution.
    columns: Vec<f64>,
}

/// Last fronts of the tree, stored in place of the values of the matrix once no other front needs these.
struct InPlaceFronts {
    /// First task of these fronts; `front` is the first of the fronts themselves.
    task: usize,
    front: usize,
    /// Start of the original entries of each of these fronts in the copy set aside for them, then the end.
    starts: Vec<usize>,
    /// Number of entries of their panels.
    size: usize,
}

impl InPlaceFronts {
    /// Selects as many of the last tasks as fit into the memory of `values` matrix values.
    fn new(tree: &AssemblyTree, tasks: &[Task], values: usize) -> Option<Self> {
        let mut size = 0;
        let fits = |task: &&Task| {
            size += panel_sizes(tree, task);
            size <= values
        };
        let number = tasks.iter().rev().take_while(fits).count();
        let task = tasks.len() - number;
        let front = tasks.get(task)?.fronts.start;
        let mut starts = vec![0];
        for f in front..tree.fronts.len() {
            starts.push(starts[f - front] + tree.entries.number(f));
        }
        let size = tasks[task..].iter().map(|t| panel_sizes(tree, t)).sum();
        Some(Self { task, front, starts, size })
    }

    /// Number of original entries that are set aside.
    fn entries(&self) -> usize {
        self.starts.last().copied().unwrap_or(0)
    }
}

/// Pivoting strategy.
enum Pivoting {
    /// Cholesky of each 128-column diagonal block; a block that is not positive definite is factored with rook pivoting
    /// restricted to that block, or to the columns from there on if the block is singular.
    Restricted,
    /// Growth check of a restricted factorisation: it is accepted, with this number of negative pivots, unless these
    /// pivot sizes are too large relative to the scales.
    GrowthCheck(Vec<f64>, usize),
    /// Threshold pivoting among all fully summed columns of a front; columns that fail the test are delayed.
    Threshold,
}

/// Circumstances of the factorisations.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Mode {
    /// Low-memory mode: memory counts more than time.
    pub low_memory: bool,
    /// Whether one thread alone factors and solves, which may be one of many that do so with matrices of their own.
    pub sequential: bool,
}

/// Outcome of one attempt to factor a matrix.
pub(super) enum Attempt {
    /// The matrix is factored and has this inertia.
    Done(Inertia),
    /// Another attempt with the same values is necessary.
    Again,
}

/// Values of the matrix.
pub(super) enum Values<'a> {
    /// Values that are only read.
    Borrowed(&'a [f64]),
    /// Values whose memory is reused.
    Owned(Vec<f64>),
}

impl Values<'_> {
    fn all(&self) -> &[f64] {
        match self {
            Self::Borrowed(values) => values,
            Self::Owned(values) => values,
        }
    }
}

impl Multifrontal {
    /// Orders and analyses a lower triangle in compressed columns. The unknowns of the `interface` are not eliminated.
    pub fn new(
        pointers: &[usize],
        rows: &[u32],
        interface: &[u32],
        sequential: bool,
    ) -> Result<Self, FactorError> {
        let graph = CompressedGraph::new(pointers, rows, interface);
        let order = graph.minimum_degree()?;
        let tree = AssemblyTree::new(&graph, &order, pointers, rows)?;
        let low_memory = tree.size >= LOW_MEMORY_ENTRIES && !sequential;
        Self::of_tree(tree, rows.len(), Mode { low_memory, sequential })
    }

    /// Allocates the factor of an assembly tree, for a matrix with `values` entries.
    fn of_tree(tree: AssemblyTree, values: usize, mode: Mode) -> Result<Self, FactorError> {
        let n = tree.fronts.len();
        let low_memory = mode.low_memory;
        let threads = if mode.sequential { 1 } else { rayon::current_num_threads() };
        let parts = (8 * threads).max(16) * if low_memory { 2 } else { 1 };
        let grain = (tree.operations() / parts as f64).max(MIN_PARALLEL_FLOPS);
        let is_node_level = |f: usize| tree.fronts[f].flops > grain && !tree.children[f].is_empty();
        let node_level: Vec<bool> = (0..n).map(|f| (threads > 1 || low_memory) && is_node_level(f)).collect();
        let tasks = Task::all(&tree, &node_level);
        let in_place = if low_memory && node_level.contains(&true) {
            InPlaceFronts::new(&tree, &tasks, values)
        } else {
            None
        };
        let stack_sizes: Vec<usize> = tasks.iter().map(|task| stack_size(&tree, &task.fronts)).collect();
        let diagonal_blocks = (0..threads).map(|_| Mutex::new(DiagonalBlock::new())).collect();
        Ok(Self {
            factor: zeros(tree.size - in_place.as_ref().map_or(0, |in_place| in_place.size))?,
            in_place,
            value_memory: Vec::new(),
            pivoting: Pivoting::Restricted,
            diagonal: zeros(tree.order.len())?,
            pivots: (0..n).map(|_| FrontPivots::default()).collect(),
            columns: zeros(tree.order.len())?,
            tree,
            tasks,
            node_level,
            stack_sizes,
            diagonal_blocks,
            workspace: WorkspacePool::new(low_memory),
            mode,
        })
    }

    /// Frees the memory of the factor.
    pub fn release(&mut self) {
        self.factor = Vec::new();
        self.value_memory = Vec::new();
        self.workspace.release();
        self.pivoting = Pivoting::Restricted;
    }

    /// Frees the workspace, which is allocated again when it is needed.
    pub fn release_workspace(&mut self) {
        self.workspace.release();
    }

    /// Discards the factor and returns the memory of the values; returns none while a growth check is pending.
    pub fn reclaim_values(&mut self) -> Vec<f64> {
        if matches!(self.pivoting, Pivoting::GrowthCheck(..)) {
            Vec::new()
        } else {
            std::mem::take(&mut self.value_memory)
        }
    }

    /// Number of entries of the factor.
    pub fn entries(&self) -> usize {
        self.tree.size
    }

    /// Number of floating-point operations of a factorisation.
    pub fn operations(&self) -> f64 {
        self.tree.operations()
    }

    /// Makes one attempt to factor the matrix with the given values, or asks for them once more. A positive pivot that
    /// is tiny relative to the entries of its column is harmless in a definite matrix, but not in one that turns out to
    /// be indefinite. If an indefinite matrix fails the growth check, it is factored again with threshold pivoting, and
    /// then again in the assembly tree for its [delayed columns](super::delayed_pivots). The second result tells
    /// whether the attempt made a factorisation or only finished a growth check.
    ///
    /// # Errors
    /// The matrix is singular, or the memory does not suffice.
    pub fn factor(&mut self, pointers: &[usize], values: Values) -> Result<(Attempt, bool), FactorError> {
        let eliminated = self.tree.eliminated();
        let done =
            |negative: usize| Attempt::Done(Inertia { positive: eliminated - negative, negative, zero: 0 });
        match std::mem::replace(&mut self.pivoting, Pivoting::Restricted) {
            Pivoting::Restricted => {
                for (d, &first) in self.diagonal.iter_mut().zip(pointers) {
                    *d = values.all()[first];
                }
                match self.factor_once(values, None) {
                    // Without negative pivots only a Schur complement may have grown.
                    Ok(0) if self.tree.interface == 0 => Ok((done(0), true)),
                    Ok(negative) => {
                        let sizes = self.pivot_sizes();
                        if sizes.iter().zip(&self.diagonal).all(|(size, d)| *size <= GROWTH * d.abs()) {
                            return Ok((done(negative), true));
                        }
                        self.pivoting = Pivoting::GrowthCheck(sizes, negative);
                        Ok((Attempt::Again, true))
                    }
                    Err(FactorError::Singular) => {
                        self.pivoting = Pivoting::Threshold;
                        Ok((Attempt::Again, true))
                    }
                    Err(error) => Err(error),
                }
            }
            Pivoting::GrowthCheck(sizes, negative) => {
                let scales = self.scales(values.all());
                // A size that is not a number fails the growth check, too.
                if sizes.iter().zip(&scales).all(|(size, s)| *size <= GROWTH * s * s) {
                    return Ok((done(negative), false));
                }
                self.factor_with_threshold_pivoting(pointers, values, &scales, done)
            }
            Pivoting::Threshold => {
                let scales = self.scales(values.all());
                self.factor_with_threshold_pivoting(pointers, values, &scales, done)
            }
        }
    }

    fn factor_with_threshold_pivoting(
        &mut self,
        pointers: &[usize],
        values: Values,
        scales: &[f64],
        done: impl Fn(usize) -> Attempt,
    ) -> Result<(Attempt, bool), FactorError> {
        let number = values.all().len();
        let negative = self.factor_once(values, Some(scales))?;
        let delayed = self.delayed()?;
        if delayed.is_empty() {
            return Ok((done(negative), true));
        }
        let tree = self.tree.delay(&delayed, pointers)?;
        let memory = std::mem::take(&mut self.value_memory);
        self.release();
        *self = Self::of_tree(tree, number, self.mode)?;
        self.value_memory = memory;
        self.pivoting = Pivoting::Threshold;
        Ok((Attempt::Again, true))
    }

    /// Delayed columns in elimination order. Fronts above an incomplete front are ignored, since their values are
    /// meaningless.
    ///
    /// # Errors
    /// One of the columns has no pivot in any later front either: the matrix is singular.
    fn delayed(&self) -> Result<Vec<u32>, FactorError> {
        let mut out = Vec::new();
        let mut above = vec![false; self.tree.fronts.len()];
        for (f, (front, pivots)) in self.tree.fronts.iter().zip(&self.pivots).enumerate() {
            if !above[f] {
                if pivots.singular {
                    return Err(FactorError::Singular);
                }
                out.extend(pivots.delayed.iter().map(|j| front.first as u32 + j));
            }
            if let Some(parent) = front.parent {
                above[parent as usize] |= above[f] || !pivots.complete();
            }
        }
        Ok(out)
    }

    /// Sizes of the pivots by unknown: `l_jj²` of a Cholesky column, the largest entry in the column of a 1×1 or 2×2
    /// pivot; the diagonal entry of the Schur complement for an unknown of the interface.
    fn pivot_sizes(&self) -> Vec<f64> {
        let mut size = vec![0.0; self.columns.len()];
        for (f, (front, pivots)) in self.tree.fronts.iter().zip(&self.pivots).enumerate() {
            let (layout, panel) = (front.layout(), self.panel(f));
            let old = &self.tree.order[front.first..front.first + front.width];
            let eliminated = !self.tree.is_interface(f);
            for (j, &old) in old.iter().enumerate() {
                let entry = panel[layout.diagonal(j)];
                size[old as usize] = if eliminated { entry.powi(2) } else { entry.abs() };
            }
            for pivoted in &pivots.blocks {
                let columns = pivoted.columns(front.width);
                for (&old, s) in old[columns].iter().zip(pivoted.pivots.sizes()) {
                    size[old as usize] = s;
                }
            }
        }
        size
    }

    /// Panel of a front, followed by the panels after it.
    fn panel(&self, f: usize) -> &[f64] {
        panel(&self.factor, &self.value_memory, self.tree.fronts[f].panel)
    }

    /// Equilibration scales of the unknowns, with which the largest entry of every row becomes about one: D. Ruiz, *A
    /// scaling algorithm to equilibrate both rows and columns norms in matrices*, RAL-TR-2001-034 (2001).
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

    /// Factors the matrix once and returns the number of negative pivots. Scales of the unknowns switch on threshold
    /// pivoting.
    fn factor_once(&mut self, values: Values, scales: Option<&[f64]>) -> Result<usize, FactorError> {
        self.pivots.iter_mut().for_each(FrontPivots::clear);
        if self.factor.is_empty() {
            self.factor = zeros(self.tree.size - self.in_place.as_ref().map_or(0, |in_place| in_place.size))?;
        }
        let Self {
            tree,
            node_level,
            tasks,
            stack_sizes,
            diagonal_blocks,
            workspace,
            factor,
            in_place,
            value_memory,
            pivots,
            mode,
            ..
        } = self;
        workspace.begin();
        let (mut panels, mut left) = (factor.as_mut_slice(), pivots.as_mut_slice());
        // Panels and pivots of a task, split off task by task. The fronts stored in place, the last ones, have no
        // memory yet.
        let mut take = |task: &Task| {
            let size = panel_sizes(tree, task);
            let pivots = left.split_off_mut(..task.fronts.len()).unwrap_or_default();
            Part { panels: panels.split_off_mut(..size).unwrap_or_default(), pivots }
        };
        let arch = Arch::new();
        let numeric =
            Numeric { tree, workspace, diagonal_blocks, entries: Entries::All(values.all()), scales, arch };
        if !node_level.contains(&true) {
            for (task, stack) in tasks.iter().zip(stack_sizes) {
                numeric.factor_subtree(task.fronts.clone(), *stack, take(task))?;
            }
        } else {
            let parts: Vec<_> = tasks.iter().map(|task| Mutex::new(take(task))).collect();
            // Contribution block of each task, until its parent assembles it.
            let contributions: Vec<_> = tasks.iter().map(|_| Mutex::new(Buffer::default())).collect();
            let run = |numeric: &Numeric, t: usize| {
                let task = &tasks[t];
                let part = std::mem::take(&mut *locked(&parts[t]));
                *locked(&contributions[t]) = if task.node_level {
                    let from = task
                        .children
                        .iter()
                        .map(|&c| std::mem::take(&mut *locked(&contributions[c as usize])));
                    numeric.factor_front(task.fronts.start, part, from.collect())?
                } else {
                    numeric.factor_subtree(task.fronts.clone(), stack_sizes[t], part)?
                };
                Ok(())
            };
            let early = 0..in_place.as_ref().map_or(tasks.len(), |in_place| in_place.task);
            let threads = (diagonal_blocks.len(), mode.low_memory);
            run_all(tasks, early, threads, |t| run(&numeric, t))?;
            if let Some(in_place) = in_place {
                let mut original_entries = workspace.take(in_place.entries())?;
                for (k, place) in in_place.starts.windows(2).enumerate() {
                    let out = &mut original_entries[place[0]..place[1]];
                    tree.entries.collect(in_place.front + k, values.all(), out);
                }
                if let Values::Owned(values) = values {
                    *value_memory = values;
                } else if value_memory.len() < in_place.size {
                    *value_memory = zeros(in_place.size)?;
                }
                let mut panels = value_memory.as_mut_slice();
                for (task, part) in tasks.iter().zip(&parts).skip(in_place.task) {
                    locked(part).panels = panels.split_off_mut(..panel_sizes(tree, task)).unwrap_or_default();
                }
                let entries = Entries::Collected(in_place.front, &in_place.starts, &original_entries);
                let numeric = Numeric { tree, workspace, diagonal_blocks, entries, scales, arch };
                run_all(tasks, in_place.task..tasks.len(), threads, |t| run(&numeric, t))?;
                workspace.put(original_entries);
                return Ok(self.negative_pivots());
            }
        }
        if let Values::Owned(values) = values {
            *value_memory = values;
        }
        Ok(self.negative_pivots())
    }

    fn negative_pivots(&self) -> usize {
        self.pivots.iter().flat_map(|front| &front.blocks).map(|p| p.pivots.inertia().negative).sum()
    }
}

/// Part of the factor that begins with entry `first`, the start of a panel. The fronts stored in place, in memory of
/// their own, are numbered behind all others.
pub(super) fn panel<'a>(factor: &'a [f64], in_place: &'a [f64], first: usize) -> &'a [f64] {
    if first < factor.len() { &factor[first..] } else { &in_place[first - factor.len()..] }
}

/// Number of entries of the panels of a task.
fn panel_sizes(tree: &AssemblyTree, task: &Task) -> usize {
    task.fronts.clone().map(|f| tree.fronts[f].layout().size()).sum()
}

/// Largest contribution-block stack of a subtree that one thread factors, including the block that the current front
/// creates.
fn stack_size(tree: &AssemblyTree, subtree: &Range<usize>) -> usize {
    let mut most = 0;
    let mut held = 0_usize;
    // The contribution block of the last front does not go to the stack.
    for f in subtree.start..subtree.end - 1 {
        let own = tree.fronts[f].contribution().size();
        most = most.max(held + own);
        held = held + own - tree.contributions_of_children(f);
    }
    most
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
