//! Observer of a run that calls Python.

use std::sync::Mutex;

use pyo3::prelude::*;
use tegula_io::job::{JobObserver, Progress};

/// Observer that reports steps and warnings to Python and asks it for Ctrl-C.
#[derive(Default)]
pub struct Watch {
    /// Called with step, time, end time, step size and iterations after each step.
    progress: Option<Py<PyAny>>,
    /// Exception of a call, which ends the run.
    raised: Mutex<Option<PyErr>>,
}

impl Watch {
    /// Observer with a function for the progress.
    pub fn new(progress: Option<Py<PyAny>>) -> Self {
        Self { progress, raised: Mutex::default() }
    }

    /// Exception of a call or Ctrl-C, if there was one.
    pub fn raised(self) -> Option<PyErr> {
        self.raised.into_inner().ok().flatten()
    }

    fn keep(&self, result: PyResult<()>) {
        if let (Err(error), Ok(mut raised)) = (result, self.raised.lock()) {
            raised.get_or_insert(error);
        }
    }
}

/// Gives a warning at the place of the caller, `level` calls above.
pub fn warn(py: Python<'_>, message: &str, level: u32) -> PyResult<()> {
    let category = py.import("tegula._errors")?.getattr("ModelWarning")?;
    py.import("warnings")?.call_method1("warn", (message, category, level)).map(|_| ())
}

impl JobObserver for Watch {
    fn on_step(&mut self, progress: &Progress) {
        let Some(function) = &self.progress else { return };
        let Progress { step, time, end, step_size, iterations } = *progress;
        let result =
            Python::attach(|py| function.call1(py, (step, time, end, step_size, iterations)).map(|_| ()));
        self.keep(result);
    }

    fn on_warning(&mut self, message: &str) {
        self.keep(Python::attach(|py| warn(py, message, 3)));
    }

    fn interrupted(&self) -> bool {
        let raised = || self.raised.lock().is_ok_and(|raised| raised.is_some());
        if !raised() {
            self.keep(Python::attach(|py| py.check_signals()));
        }
        raised()
    }
}
