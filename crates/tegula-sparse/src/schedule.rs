//! Task schedule of the numeric factorisation: tree-level and node-level parallelism.
//!
//! A task is a subtree that one thread factors (tree-level parallelism), or a front above such subtrees that all
//! threads factor together (node-level parallelism). A free thread takes the first task in elimination order whose
//! children are done; in low-memory mode it takes none while a node-level front is in progress. The contribution blocks
//! therefore need little more memory than with one thread: if the tree were halved between two threads, one of them
//! would begin with the contribution blocks that are needed last.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::ops::Range;
use std::sync::{Mutex, MutexGuard, PoisonError};

use rayon::Scope;

use super::FactorError;
use super::assembly_tree::AssemblyTree;

/// Task of the schedule: consecutive fronts, either a subtree or one node-level front.
#[derive(Debug, Clone)]
pub(super) struct Task {
    /// Fronts of the task; the last one leaves the contribution block of the task.
    pub fronts: Range<usize>,
    /// Whether the task is a front with node-level parallelism.
    pub node_level: bool,
    /// Task that assembles the contribution block.
    parent: Option<u32>,
    /// Child tasks: their last fronts are the children of this node-level front.
    pub children: Vec<u32>,
}

impl Task {
    /// Tasks in elimination order. Every front flagged in `node_level` is a task of its own.
    pub fn all(tree: &AssemblyTree, node_level: &[bool]) -> Vec<Self> {
        let mut tasks: Vec<Self> = Vec::new();
        let mut task_of = vec![0_u32; tree.fronts.len()];
        for (f, front) in tree.fronts.iter().enumerate() {
            if !node_level[f] && front.parent.is_some_and(|p| !node_level[p as usize]) {
                continue;
            }
            let number = tasks.len() as u32;
            task_of[f] = number;
            let fronts = if node_level[f] { f..f + 1 } else { front.leaf..f + 1 };
            let mut task = Self { fronts, node_level: node_level[f], parent: None, children: Vec::new() };
            if node_level[f] {
                task.children = tree.children[f].iter().map(|&c| task_of[c as usize]).collect();
                for &c in &task.children {
                    tasks[c as usize].parent = Some(number);
                }
            }
            tasks.push(task);
        }
        tasks
    }
}

/// Number of children of each task within a range of the tasks.
fn missing(tasks: &[Task], part: &Range<usize>) -> Vec<usize> {
    let in_part = |c: &&u32| part.contains(&(**c as usize));
    tasks.iter().map(|t| t.children.iter().filter(in_part).count()).collect()
}

/// Locks a mutex, also after a panic of another thread that held it.
pub(super) fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Shared state of a schedule: ready tasks, and dependencies of the others.
struct State {
    ready: BinaryHeap<Reverse<u32>>,
    /// Number of unfinished children of each task.
    missing: Vec<usize>,
    /// Number of threads that take tasks.
    workers: usize,
    /// Whether the other threads wait for a node-level front in progress.
    node_level: bool,
    /// First failed task in elimination order, and its error.
    error: Option<(u32, FactorError)>,
}

/// Schedule of a range of tasks on several threads.
struct Schedule<'a, F> {
    tasks: &'a [Task],
    part: Range<usize>,
    threads: usize,
    /// Low-memory mode: no thread begins a task while a node-level front is in progress.
    wait: bool,
    state: Mutex<State>,
    run: F,
}

/// Runs the tasks `part`, each after its children; the tasks before them are done. With `wait` (low-memory mode)
/// threads take no task while a node-level front is in progress.
///
/// # Errors
/// The error of the first task that failed; other tasks may be left undone then.
pub(super) fn run_all(
    tasks: &[Task],
    part: Range<usize>,
    (threads, wait): (usize, bool),
    run: impl Fn(usize) -> Result<(), FactorError> + Sync,
) -> Result<(), FactorError> {
    let missing = missing(tasks, &part);
    let ready = part.clone().filter(|&t| missing[t] == 0).map(|t| Reverse(t as u32)).collect();
    let state = State { ready, missing, workers: 1, node_level: false, error: None };
    let schedule = Schedule { tasks, part, threads, wait, state: Mutex::new(state), run };
    rayon::scope(|scope| schedule.work(scope));
    schedule
        .state
        .into_inner()
        .unwrap_or_else(PoisonError::into_inner)
        .error
        .map_or(Ok(()), |(_, error)| Err(error))
}

impl<'a, F: Fn(usize) -> Result<(), FactorError> + Sync> Schedule<'a, F> {
    fn state(&self) -> MutexGuard<'_, State> {
        locked(&self.state)
    }

    /// Runs one ready task after another. A thread that finds none is free to take parts of a node-level front; the
    /// thread that began that front continues with the tasks.
    fn work<'s>(&'s self, scope: &Scope<'s>) {
        loop {
            let mut state = self.state();
            let free = state.error.is_none() && !state.node_level;
            let next = if free { state.ready.pop() } else { None };
            let Some(Reverse(task)) = next else {
                state.workers -= 1;
                return;
            };
            state.node_level = self.wait && self.tasks[task as usize].node_level;
            let free = if state.node_level { 0 } else { self.threads.saturating_sub(state.workers) };
            let more = state.ready.len().min(free);
            state.workers += more;
            drop(state);
            for _ in 0..more {
                scope.spawn(|scope| self.work(scope));
            }
            let done = (self.run)(task as usize);
            let mut state = self.state();
            if self.tasks[task as usize].node_level {
                state.node_level = false;
            }
            match done {
                // The first task in elimination order decides the error, whichever thread was faster.
                Err(error) if state.error.as_ref().is_none_or(|(first, _)| task < *first) => {
                    state.error = Some((task, error));
                }
                Err(_) => {}
                Ok(()) => {
                    let parent = self.tasks[task as usize].parent;
                    if let Some(parent) = parent.filter(|&p| self.part.contains(&(p as usize))) {
                        state.missing[parent as usize] -= 1;
                        if state.missing[parent as usize] == 0 {
                            state.ready.push(Reverse(parent));
                        }
                    }
                }
            }
        }
    }
}
