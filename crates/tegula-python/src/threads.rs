//! Threads that compute.
//!
//! A model of some thousand unknowns hands work to other threads thousands of times a second, and each time the caller is not one of
//! them it waits for two of them to wake. So the main thread of Python is one of the threads of its pool, as in the command line
//! program. Each analysis of another thread runs as a whole in a pool of its own: in a pool that several analyses share one could
//! wait for a thread that waits for its state.

use std::cell::Cell;
use std::sync::OnceLock;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

thread_local! {
    static IN_POOL: Cell<bool> = const { Cell::new(false) };
}

/// Computes without the interpreter: in the main thread of Python with the threads of the process, in others in the `own` pool, which
/// is made when it is needed.
///
/// # Errors
/// The threads cannot be started.
pub fn compute<T: Send>(
    py: Python<'_>,
    own: &OnceLock<ThreadPool>,
    work: impl FnOnce() -> T + Send,
) -> PyResult<T> {
    let inside = IN_POOL.get() || rayon::current_thread_index().is_some();
    if inside || joined_as_main(py)? {
        return Ok(py.detach(work));
    }
    if own.get().is_none() {
        let pool = ThreadPoolBuilder::new().build();
        // Of two threads that come here at once one pool is dropped.
        let _ =
            own.set(pool.map_err(|e| PyRuntimeError::new_err(format!("no threads can be started: {e}")))?);
    }
    Ok(py.detach(|| match own.get() {
        Some(pool) => pool.install(work),
        None => work(),
    }))
}

/// Makes the main thread of Python one of the pool of the process; false in other threads.
fn joined_as_main(py: Python<'_>) -> PyResult<bool> {
    let threading = py.import("threading")?;
    let present = threading.call_method0("get_ident")?;
    if !present.eq(threading.call_method0("main_thread")?.getattr("ident")?)? {
        return Ok(false);
    }
    let joined = ThreadPoolBuilder::new().use_current_thread().build_global().is_ok();
    IN_POOL.set(joined);
    Ok(joined)
}
