//! Observer of a run that calls Python.

use pyo3::prelude::*;
use tegula_io::job::{JobObserver, Progress};

use crate::own::Raised;

/// Observer that reports steps to Python, asks it for Ctrl-C, and keeps warnings.
pub struct Watch {
    /// Called with step, time, end time, step size and iterations after each step, and with the numbers of vectors, modes found and modes wanted
    /// in a search for modes.
    progress: Option<Py<PyAny>>,
    warnings: Vec<String>,
    /// Exception of a call, which ends the run.
    raised: Raised,
}

impl Watch {
    /// Observer with a function for the progress, and the exception of loads and laws.
    pub fn new(progress: Option<Py<PyAny>>, raised: Raised) -> Self {
        Self { progress, warnings: Vec::new(), raised }
    }

    /// Warnings, and the exception of a call or of Ctrl-C, if there was one.
    pub fn end(self) -> (Vec<String>, Option<PyErr>) {
        (self.warnings, self.raised.take())
    }
}

impl JobObserver for Watch {
    fn on_step(&mut self, progress: &Progress) {
        let Some(function) = &self.progress else { return };
        let Progress { step, time, end, step_size, iterations } = *progress;
        let result =
            Python::attach(|py| function.call1(py, (step, time, end, step_size, iterations)).map(|_| ()));
        self.raised.keep(result);
    }

    fn on_modes(&mut self, found: usize, wanted: usize, vectors: usize) {
        let Some(function) = &self.progress else { return };
        let result = Python::attach(|py| {
            function.call1(py, (vectors, found as f64, wanted as f64, 1.0, vectors, "modes")).map(|_| ())
        });
        self.raised.keep(result);
    }

    fn on_warning(&mut self, message: &str) {
        self.warnings.push(message.to_owned());
    }

    fn interrupted(&self) -> bool {
        if !self.raised.is_set() {
            self.raised.keep(Python::attach(|py| py.check_signals()));
        }
        self.raised.is_set()
    }
}
