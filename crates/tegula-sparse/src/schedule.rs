//! Which part of the elimination is worked off when: tasks, and the order in which threads take them up.
//!
//! A task is a subtree that one thread works off, or a front above such subtrees, in which threads work together. A
//! free thread takes the first task, in the order of the elimination, whose children are done; where memory counts, none
//! while there is a front to work on together. So what waits is little more than with one thread: were the tree halved
//! between threads, one of them would begin with what is needed last.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::ops::Range;
use std::sync::{Mutex, MutexGuard, PoisonError};

use rayon::Scope;

use super::FactorError;
use super::assembly_tree::AssemblyTree;

/// Consecutive fronts.
#[derive(Debug, Clone)]
pub(super) struct Task {
    /// The last of them is the one that passes something on.
    pub fronts: Range<usize>,
    /// A front in which threads work together.
    pub node_level: bool,
    /// The task that takes it.
    parent: Option<u32>,
    /// Tasks whose fronts are children of the first front.
    pub children: Vec<u32>,
}

impl Task {
    /// Tasks in the order of the elimination. Fronts that are `split` are tasks of their own.
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

/// How many children of each task belong to a part of the tasks.
fn missing(tasks: &[Task], part: &Range<usize>) -> Vec<usize> {
    let in_part = |c: &&u32| part.contains(&(**c as usize));
    tasks.iter().map(|t| t.children.iter().filter(in_part).count()).collect()
}

/// Holds what a mutex holds, also after a panic elsewhere.
pub(super) fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Tasks that are ready, and what others wait for.
struct State {
    ready: BinaryHeap<Reverse<u32>>,
    /// Children of each task that are not done.
    missing: Vec<usize>,
    /// Threads that take up tasks.
    workers: usize,
    /// Others wait for a front in which threads work together.
    node_level: bool,
    /// The first task that failed, and why.
    error: Option<(u32, FactorError)>,
}

/// Tasks that threads work off.
struct Schedule<'a, F> {
    tasks: &'a [Task],
    part: Range<usize>,
    threads: usize,
    /// No thread begins a task while there is a front in which threads work together.
    wait: bool,
    state: Mutex<State>,
    run: F,
}

/// Runs a part of the tasks, each after its children. Those before are done. Threads may have to wait for one another.
///
/// # Errors
/// That of a task; others may be left undone then.
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

    /// Takes up one task after another while there are any. A thread that finds none is free for parts of a front in which
    /// threads work together; the one that began it goes on with the tasks.
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
                // That of the first task, whichever thread was faster.
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
