//! Observer of a run that calls Python.

use std::sync::Mutex;

use pyo3::prelude::*;
use tegula_io::job::{JobObserver, Progress};

/// Observer that reports steps to Python, asks it for Ctrl-C, and keeps warnings.
#[derive(Default)]
pub struct Watch {
    /// Called with step, time, end time, step size and iterations after each step.
    progress: Option<Py<PyAny>>,
    warnings: Vec<String>,
    /// Exception of a call, which ends the run.
    raised: Mutex<Option<PyErr>>,
}

impl Watch {
    /// Observer with a function for the progress.
    pub fn new(progress: Option<Py<PyAny>>) -> Self {
        Self { progress, ..Self::default() }
    }

    /// Warnings, and the exception of a call or of Ctrl-C, if there was one.
    pub fn end(self) -> (Vec<String>, Option<PyErr>) {
        (self.warnings, self.raised.into_inner().ok().flatten())
    }

    fn keep(&self, result: PyResult<()>) {
        if let (Err(error), Ok(mut raised)) = (result, self.raised.lock()) {
            raised.get_or_insert(error);
        }
    }
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
        self.warnings.push(message.to_owned());
    }

    fn interrupted(&self) -> bool {
        let raised = || self.raised.lock().is_ok_and(|raised| raised.is_some());
        if !raised() {
            self.keep(Python::attach(|py| py.check_signals()));
        }
        raised()
    }
}
