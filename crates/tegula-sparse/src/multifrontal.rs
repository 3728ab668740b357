//! Multifrontal LDLᵀ factorisation over dense kernels, with tree-level and node-level parallelism.
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
use super::numeric::{Entries, Numeric, Part};
use super::ordering::CompressedGraph;
use super::partial_factorization::FrontPivots;
use super::schedule::{Task, locked, run_all};
use super::workspace::{Buffer, Workspace, zeros};
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
    /// Panels of all fronts, by block columns, but those of the fronts stored in place of the values and, in sequential
    /// mode, that of the interface, which stays in the workspace.
    factor: Vec<f64>,
    in_place: Option<InPlaceFronts>,
    /// Memory of the values of the matrix, or its replacement, which holds the panels of the fronts stored in place.
    value_memory: Vec<f64>,
    pivoting: Pivoting,
    /// Pivots of all fronts.
    pivots: Vec<FrontPivots>,
    /// Tasks of the schedule: subtrees and node-level fronts.
    tasks: Vec<Task>,
    /// Node-level fronts: fronts whose subtree is divided among threads.
    node_level: Vec<bool>,
    /// Largest size of the contribution-block stack in each task that is a subtree.
    stack_sizes: Vec<usize>,
    mode: Mode,
    /// Workspace of factorisations and solutions.
    pub workspace: Workspace,
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

    /// Copy of the original entries of these fronts, which outlives the values of the matrix.
    fn original_entries(
        &self,
        tree: &AssemblyTree,
        workspace: &Workspace,
        values: &[f64],
    ) -> Result<Buffer, FactorError> {
        let mut out = workspace.pool.take(self.starts.last().copied().unwrap_or(0))?;
        for (k, place) in self.starts.windows(2).enumerate() {
            tree.entries.collect(self.front + k, values, &mut out[place[0]..place[1]]);
        }
        Ok(out)
    }
}

/// Panels and pivots that are split off task by task. The last front's panel may be elsewhere, in `interface`.
struct Unassigned<'a> {
    tree: &'a AssemblyTree,
    panels: &'a mut [f64],
    pivots: &'a mut [FrontPivots],
    interface: &'a mut [f64],
}

impl<'a> Unassigned<'a> {
    /// Splits off the part of the next task. Fronts stored in place, the last ones, have no panels yet.
    fn next(&mut self, task: &Task) -> Part<'a> {
        let mut part = Part::default();
        let mut size = panel_sizes(self.tree, task);
        if task.fronts.end == self.tree.fronts.len() {
            part.interface = std::mem::take(&mut self.interface);
            size -= part.interface.len();
        }
        part.panels = self.panels.split_off_mut(..size).unwrap_or_default();
        part.pivots = self.pivots.split_off_mut(..task.fronts.len()).unwrap_or_default();
        part
    }
}

/// Tasks of the schedule in progress.
struct Progress<'a> {
    tasks: &'a [Task],
    stack_sizes: &'a [usize],
    /// Panels and pivots of each task, until it begins.
    parts: Vec<Mutex<Part<'a>>>,
    /// Contribution block of each task, until its parent assembles it.
    contributions: Vec<Mutex<Buffer>>,
}

impl Progress<'_> {
    /// Runs a task whose children are done.
    fn run(&self, numeric: &Numeric, t: usize) -> Result<(), FactorError> {
        let task = &self.tasks[t];
        let part = std::mem::take(&mut *locked(&self.parts[t]));
        *locked(&self.contributions[t]) = if task.node_level {
            let taken = |&c: &u32| std::mem::take(&mut *locked(&self.contributions[c as usize]));
            numeric.factor_front(task.fronts.start, part, task.children.iter().map(taken).collect())?
        } else {
            numeric.factor_subtree(task.fronts.clone(), self.stack_sizes[t], part)?
        };
        Ok(())
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
        let order = graph.minimum_degree();
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
        // A sequential factorisation gets its factor and its workspace, which may be that of the caller, when it begins.
        let (factor, workspace) = if mode.sequential {
            (Vec::new(), Workspace::default())
        } else {
            let size = tree.size - in_place.as_ref().map_or(0, |in_place| in_place.size);
            (zeros(size)?, Workspace::new(threads, tree.order.len(), low_memory)?)
        };
        Ok(Self {
            factor,
            in_place,
            value_memory: Vec::new(),
            pivoting: Pivoting::Restricted,
            pivots: (0..n).map(|_| FrontPivots::default()).collect(),
            tree,
            tasks,
            node_level,
            stack_sizes,
            workspace,
            mode,
        })
    }

    /// Frees the memory of the factor.
    pub fn release(&mut self) {
        self.factor = Vec::new();
        self.value_memory = Vec::new();
        self.workspace.pool.release();
        self.pivoting = Pivoting::Restricted;
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
        let done = |negative: usize| Attempt::Done(inertia(eliminated, negative));
        match std::mem::replace(&mut self.pivoting, Pivoting::Restricted) {
            Pivoting::Restricted => {
                let first = &pointers[..self.tree.order.len()];
                self.workspace.diagonal.clear();
                self.workspace.diagonal.extend(first.iter().map(|&first| values.all()[first]));
                match self.factor_once(values, None) {
                    // Without negative pivots only a Schur complement may have grown.
                    Ok(0) if self.tree.interface == 0 => Ok((done(0), true)),
                    Ok(negative) => {
                        let sizes = self.pivot_sizes();
                        if sizes
                            .iter()
                            .zip(&self.workspace.diagonal)
                            .all(|(size, d)| *size <= GROWTH * d.abs())
                        {
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

    /// Factors a matrix that is expected to be positive definite. Pivots are restricted to diagonal blocks, and there is
    /// no growth check: an indefinite matrix is recognised, but its factor may be inaccurate. The assembly tree stays as
    /// it is.
    ///
    /// # Errors
    /// The matrix is singular, or the memory does not suffice.
    pub fn factor_definite(&mut self, values: &[f64]) -> Result<Inertia, FactorError> {
        self.pivoting = Pivoting::Restricted;
        let negative = self.factor_once(Values::Borrowed(values), None)?;
        Ok(inertia(self.tree.eliminated(), negative))
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
        let mut size = vec![0.0; self.tree.order.len()];
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

    /// Number of entries of the panel of the interface if it stays in the workspace, else 0.
    fn interface_size(&self) -> usize {
        let last = self.tree.fronts.last().filter(|_| self.mode.sequential && self.tree.interface > 0);
        last.map_or(0, |front| front.layout().size())
    }

    /// Panel of a front, followed by the panels after it.
    fn panel(&self, f: usize) -> &[f64] {
        if self.mode.sequential && self.tree.is_interface(f) {
            return &self.workspace.interface;
        }
        panel(&self.factor, &self.value_memory, self.tree.fronts[f].panel)
    }

    /// Equilibration scales of the unknowns, with which the largest entry of every row becomes about one: D. Ruiz, *A
    /// scaling algorithm to equilibrate both rows and columns norms in matrices*, RAL-TR-2001-034 (2001).
    fn scales(&self, values: &[f64]) -> Vec<f64> {
        let n = self.tree.order.len();
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
        let elsewhere =
            self.in_place.as_ref().map_or_else(|| self.interface_size(), |in_place| in_place.size);
        if self.factor.is_empty() {
            self.factor = zeros(self.tree.size - elsewhere)?;
        }
        self.workspace.begin(self.interface_size())?;
        if self.node_level.contains(&true) {
            self.factor_scheduled(values, scales)?;
        } else {
            self.factor_in_sequence(values, scales)?;
        }
        Ok(self.negative_pivots())
    }

    /// Factors all subtrees, one after another.
    fn factor_in_sequence(&mut self, values: Values, scales: Option<&[f64]>) -> Result<(), FactorError> {
        let Self { tree, tasks, stack_sizes, workspace, factor, value_memory, pivots, .. } = self;
        let entries = Entries::All(values.all());
        let mut interface = std::mem::take(&mut workspace.interface);
        let numeric = Numeric { tree, workspace, entries, scales, arch: Arch::new() };
        let mut unassigned = Unassigned { tree, panels: factor, pivots, interface: &mut interface };
        for (task, stack) in tasks.iter().zip(stack_sizes) {
            numeric.factor_subtree(task.fronts.clone(), *stack, unassigned.next(task))?;
        }
        workspace.interface = interface;
        if let Values::Owned(values) = values {
            *value_memory = values;
        }
        Ok(())
    }

    /// Factors the tasks of the schedule with all threads, the fronts stored in place at last.
    fn factor_scheduled(&mut self, values: Values, scales: Option<&[f64]>) -> Result<(), FactorError> {
        let Self {
            tree, tasks, stack_sizes, workspace, factor, in_place, value_memory, pivots, mode, ..
        } = self;
        let arch = Arch::new();
        let threads = (workspace.threads(), mode.low_memory);
        let mut unassigned = Unassigned { tree, panels: factor, pivots, interface: &mut [] };
        let parts = tasks.iter().map(|task| Mutex::new(unassigned.next(task))).collect();
        let contributions = tasks.iter().map(|_| Mutex::new(Buffer::default())).collect();
        let progress = Progress { tasks, stack_sizes, parts, contributions };
        let early = 0..in_place.as_ref().map_or(tasks.len(), |in_place| in_place.task);
        let entries = Entries::All(values.all());
        let numeric = Numeric { tree, workspace, entries, scales, arch };
        run_all(tasks, early, threads, |t| progress.run(&numeric, t))?;
        let Some(in_place) = in_place else {
            if let Values::Owned(values) = values {
                *value_memory = values;
            }
            return Ok(());
        };
        let original_entries = in_place.original_entries(tree, workspace, values.all())?;
        if let Values::Owned(values) = values {
            *value_memory = values;
        } else if value_memory.len() < in_place.size {
            *value_memory = zeros(in_place.size)?;
        }
        let mut panels = value_memory.as_mut_slice();
        for (task, part) in tasks.iter().zip(&progress.parts).skip(in_place.task) {
            locked(part).panels = panels.split_off_mut(..panel_sizes(tree, task)).unwrap_or_default();
        }
        let entries = Entries::Collected(in_place.front, &in_place.starts, &original_entries);
        let numeric = Numeric { tree, workspace, entries, scales, arch };
        run_all(tasks, in_place.task..tasks.len(), threads, |t| progress.run(&numeric, t))?;
        workspace.pool.put(original_entries);
        Ok(())
    }

    fn negative_pivots(&self) -> usize {
        self.pivots.iter().flat_map(|front| &front.blocks).map(|p| p.pivots.inertia().negative).sum()
    }
}

/// Inertia of a regular matrix of which so many unknowns are eliminated.
fn inertia(eliminated: usize, negative: usize) -> Inertia {
    Inertia { positive: eliminated - negative, negative, zero: 0 }
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
