//! Number of threads.

use std::num::NonZero;

use crate::report::Failure;
use crate::terminal;

/// Threads that are allowed on any machine.
const ALWAYS: usize = 16;

/// Starts the threads of the run: those wanted, else those of `RAYON_NUM_THREADS`, else one for each processor. At most
/// twice as many as there are processors: more only get in each other's way, and thousands exhaust the machine.
///
/// # Errors
/// The threads cannot be started.
pub fn start(wanted: Option<u32>) -> Result<(), Failure> {
    let from_environment = || std::env::var("RAYON_NUM_THREADS").ok()?.trim().parse::<u32>().ok();
    let processors = std::thread::available_parallelism().map_or(1, NonZero::get);
    let Some(wanted) = wanted.or_else(from_environment).filter(|&n| n > 0) else { return build(processors) };
    let most = ALWAYS.max(2 * processors);
    let threads = usize::try_from(wanted).unwrap_or(usize::MAX).min(most);
    if threads < wanted as usize {
        let there = if processors == 1 { "1 processor".into() } else { format!("{processors} processors") };
        terminal::report(
            "warning",
            &format!("{threads} threads are used instead of {wanted}: there are {there}"),
        );
    }
    build(threads)
}

/// Makes the pool. The present thread is one of it: it does its share of the work, and small models do not pay for handing
/// all of it to another thread and waiting.
fn build(threads: usize) -> Result<(), Failure> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .use_current_thread()
        .build_global()
        .map_err(|e| Failure::Usage(format!("{threads} threads cannot be started: {e}")))
}
