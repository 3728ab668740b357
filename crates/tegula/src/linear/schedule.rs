//! Which part of the elimination is worked off when: tasks, and the order in which threads take them up.
//!
//! A task is a subtree that one thread works off, or a front above such subtrees, in which threads work together. A
//! free thread takes the first task, in the order of the elimination, whose children are done. So what waits is little
//! more than with one thread: were the tree halved between threads, one of them would begin with what is needed last.

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
    /// The task that takes it.
    parent: Option<u32>,
    /// Tasks whose fronts are children of the first front.
    pub children: Vec<u32>,
}

impl Task {
    /// Tasks in the order of the elimination. Fronts that are `split` are tasks of their own.
    pub fn all(tree: &AssemblyTree, split: &[bool]) -> Vec<Self> {
        let mut tasks: Vec<Self> = Vec::new();
        let mut task_of = vec![0_u32; tree.fronts.len()];
        for (f, front) in tree.fronts.iter().enumerate() {
            if !split[f] && front.parent.is_some_and(|p| !split[p as usize]) {
                continue;
            }
            let number = tasks.len() as u32;
            task_of[f] = number;
            let mut task = Self { fronts: front.leaf..f + 1, parent: None, children: Vec::new() };
            if split[f] {
                task.fronts.start = f;
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

/// Calls `event` with the number of each task, when it begins (`true`) and when it is done, as threads would take the tasks
/// up if each took as long as it has `work`.
pub(super) fn rehearse(
    tasks: &[Task],
    threads: usize,
    work: impl Fn(&Task) -> f64,
    mut event: impl FnMut(usize, bool),
) {
    let mut missing: Vec<usize> = tasks.iter().map(|t| t.children.len()).collect();
    let mut ready: BinaryHeap<_> = (0..tasks.len()).filter(|&t| missing[t] == 0).map(Reverse).collect();
    // Tasks at work, and when they are done.
    let mut busy: Vec<(f64, usize)> = Vec::new();
    let mut now = 0.0;
    loop {
        while busy.len() < threads
            && let Some(Reverse(t)) = ready.pop()
        {
            event(t, true);
            busy.push((now + work(&tasks[t]), t));
        }
        let Some(first) = (0..busy.len()).min_by(|&a, &b| busy[a].0.total_cmp(&busy[b].0)) else { return };
        let (end, t) = busy.swap_remove(first);
        now = end;
        event(t, false);
        if let Some(parent) = tasks[t].parent {
            missing[parent as usize] -= 1;
            if missing[parent as usize] == 0 {
                ready.push(Reverse(parent as usize));
            }
        }
    }
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
    /// Threads at work.
    workers: usize,
    /// The first task that failed, and why.
    error: Option<(u32, FactorError)>,
}

/// Tasks that threads work off.
struct Schedule<'a, F> {
    tasks: &'a [Task],
    threads: usize,
    state: Mutex<State>,
    run: F,
}

/// Runs tasks, the first ones of all, each after its children.
///
/// # Errors
/// That of a task; others may be left undone then.
pub(super) fn run_all(
    tasks: &[Task],
    threads: usize,
    run: impl Fn(usize) -> Result<(), FactorError> + Sync,
) -> Result<(), FactorError> {
    let missing: Vec<usize> = tasks.iter().map(|t| t.children.len()).collect();
    let ready = (0..tasks.len() as u32).filter(|&t| missing[t as usize] == 0).map(Reverse).collect();
    let state = State { ready, missing, workers: 1, error: None };
    let schedule = Schedule { tasks, threads, state: Mutex::new(state), run };
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

    /// Takes up one task after another while there are any.
    fn work<'s>(&'s self, scope: &Scope<'s>) {
        loop {
            let mut state = self.state();
            let next = if state.error.is_none() { state.ready.pop() } else { None };
            let Some(Reverse(task)) = next else {
                state.workers -= 1;
                return;
            };
            let more = state.ready.len().min(self.threads.saturating_sub(state.workers));
            state.workers += more;
            drop(state);
            for _ in 0..more {
                scope.spawn(|scope| self.work(scope));
            }
            let done = (self.run)(task as usize);
            let mut state = self.state();
            match done {
                // That of the first task, whichever thread was faster.
                Err(error) if state.error.as_ref().is_none_or(|(first, _)| task < *first) => {
                    state.error = Some((task, error));
                }
                Err(_) => {}
                Ok(()) => {
                    let parent = self.tasks[task as usize].parent;
                    if let Some(parent) = parent.filter(|&p| (p as usize) < self.tasks.len()) {
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
