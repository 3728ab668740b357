//! Models: read, checked, run.

use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use tegula::model::Analysis;
use tegula_io::deck;
use tegula_io::job::{self, JobError, JobOptions};
use tegula_io::render;
use tegula_io::report::{self, Report};

use crate::equations::Equations;
use crate::own::Own;
use crate::simulation::Steps;
use crate::state::State;
use crate::threads::compute;
use crate::watch::Watch;
use crate::{convert, failure};

/// A model that has been read.
#[pyclass(frozen, module = "tegula._tegula")]
pub struct Deck(deck::Deck);

#[pymethods]
impl Deck {
    /// Reads a model file.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        py.detach(|| deck::Deck::read(path)).map(Self).map_err(failure::of_model)
    }

    /// Reads a text; files that it names lie beside `path`.
    #[staticmethod]
    fn parse(py: Python<'_>, path: PathBuf, text: String) -> PyResult<Self> {
        py.detach(|| deck::Deck::parse(path, text)).map(Self).map_err(failure::of_model)
    }

    /// Text of a model file with the contents of a dictionary.
    #[staticmethod]
    fn text_of(model: &Bound<'_, PyDict>) -> PyResult<String> {
        toml::to_string(&convert::table(model)?)
            .map_err(|error| pyo3::exceptions::PyValueError::new_err(error.to_string()))
    }

    /// Contents of the text as a dictionary.
    fn as_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let table = self.0.text.parse::<toml::Table>();
        let table = table.map_err(|error| pyo3::exceptions::PyValueError::new_err(error.to_string()))?;
        convert::dictionary(py, &table)
    }

    /// Title of the model.
    #[getter]
    fn title(&self) -> &str {
        &self.0.model.title
    }

    /// Text of the model file.
    #[getter]
    fn text(&self) -> &str {
        &self.0.text
    }

    /// Path of the model file.
    #[getter]
    fn path(&self) -> &std::path::Path {
        &self.0.path
    }

    /// Meaning of the time of a step: of several analyses it depends on the analysis.
    #[getter]
    fn parameter(&self) -> &'static str {
        match self.0.model.analysis {
            _ if !self.0.model.steps.is_empty() => "time (load factor)",
            Analysis::Transient(_) => "time",
            _ => "load factor",
        }
    }

    /// Warnings about a model that can be computed.
    fn check(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        let prepared = compute(py, &OnceLock::new(), || job::prepare(&self.0))?.map_err(failure::of_run)?;
        Ok(prepared.warnings.iter().map(ToString::to_string).collect())
    }

    /// Writes the report of the model to a file; returns what it leaves out.
    fn write_report(&self, py: Python<'_>, file: PathBuf) -> PyResult<Vec<String>> {
        compute(py, &OnceLock::new(), || report::write_model(&self.0, &file))?.map_err(failure::of_run)
    }

    /// The report of the model as HTML, of about so many characters.
    fn report_page(&self, py: Python<'_>, most: usize) -> PyResult<String> {
        let report = compute(py, &OnceLock::new(), || Report::of_model(&self.0, most))?;
        report.map(|report| report.page.concat()).map_err(failure::of_run)
    }

    /// Runs the model; the results are in the folder. Returns the warnings.
    fn run(
        &self,
        py: Python<'_>,
        folder: PathBuf,
        resume: bool,
        force: bool,
        progress: Option<Py<PyAny>>,
        own: &Bound<'_, Own>,
    ) -> PyResult<Vec<String>> {
        let options = JobOptions { folder, resume, force };
        let (own, raised) = own.get().parts(py);
        let mut watch = Watch::new(progress, raised);
        let run = || {
            let outcome = job::run_with(&self.0, own, &options, &mut watch);
            render::stills(&self.0, &options.folder, &outcome, &mut watch);
            outcome
        };
        let outcome = compute(py, &OnceLock::new(), run)?;
        let (warnings, raised) = watch.end();
        match (outcome, raised) {
            (Err(error @ JobError::Interrupted { .. }), Some(raised))
                if raised.is_instance_of::<PyKeyboardInterrupt>(py) =>
            {
                Err(failure::of_run(error))
            }
            (_, Some(raised)) => Err(raised),
            (outcome, None) => outcome.map(|_| warnings).map_err(failure::of_run),
        }
    }

    /// The analysis of the model, step by step, from its beginning or from a state. The amplitudes named become signals.
    #[pyo3(signature = (signals, start, own))]
    fn steps(
        &self,
        py: Python<'_>,
        signals: Vec<String>,
        start: Option<&Bound<'_, State>>,
        own: &Bound<'_, Own>,
    ) -> PyResult<Steps> {
        let start = start.map(|state| state.get());
        let (own, raised) = own.get().parts(py);
        let begin = || Steps::new(&self.0, (&signals, start), (own, raised.clone()));
        let made = compute(py, &OnceLock::new(), begin)?;
        raised.check()?;
        made
    }

    /// The equations of motion of the model, and warnings about it.
    fn equations(&self, py: Python<'_>, own: &Bound<'_, Own>) -> PyResult<(Equations, Vec<String>)> {
        let (own, raised) = own.get().parts(py);
        let prepared = compute(py, &OnceLock::new(), || job::prepare_with(&self.0, own))?;
        raised.check()?;
        let prepared = prepared.map_err(failure::of_run)?;
        let warnings = prepared.warnings.iter().map(ToString::to_string).collect();
        Ok((Equations::new(Arc::new(prepared), raised), warnings))
    }
}
