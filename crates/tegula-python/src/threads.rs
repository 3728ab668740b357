//! Threads that compute.
//!
//! A model of some thousand unknowns hands work to other threads thousands of times a second, and each time the caller is not one of
//! them it waits for two of them to wake. So the main thread of Python is one of the threads of its pool, as in the command line
//! program. Other threads of Python come and go; they share a pool of their own, in one of whose threads all of an analysis runs.

use std::cell::Cell;
use std::sync::OnceLock;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

thread_local! {
    static IN_POOL: Cell<bool> = const { Cell::new(false) };
}
static OF_OTHERS: OnceLock<rayon::ThreadPool> = OnceLock::new();

/// Computes without the interpreter, in the pool of the thread.
///
/// # Errors
/// The threads cannot be started.
pub fn compute<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let inside = IN_POOL.get() || rayon::current_thread_index().is_some();
    if inside || joined_as_main(py)? {
        return Ok(py.detach(work));
    }
    if OF_OTHERS.get().is_none() {
        let pool = rayon::ThreadPoolBuilder::new().build();
        // Of two threads that come here at once one pool is dropped.
        let _ = OF_OTHERS
            .set(pool.map_err(|e| PyRuntimeError::new_err(format!("no threads can be started: {e}")))?);
    }
    Ok(py.detach(|| match OF_OTHERS.get() {
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
    let joined = rayon::ThreadPoolBuilder::new().use_current_thread().build_global().is_ok();
    IN_POOL.set(joined);
    Ok(joined)
}
