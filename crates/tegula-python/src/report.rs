//! Reports of results.

use std::path::PathBuf;

use pyo3::prelude::*;
use tegula_io::report::{self, Report};

use crate::failure;

/// Writes the report of a result folder to a file; returns what it leaves out.
#[pyfunction]
pub fn write_report(py: Python<'_>, folder: PathBuf, file: PathBuf) -> PyResult<Vec<String>> {
    py.detach(|| report::write(&folder, &file)).map_err(failure::of_output)
}

/// The report of a result folder as HTML, of about so many characters.
#[pyfunction]
pub fn report_page(py: Python<'_>, folder: PathBuf, most: usize) -> PyResult<String> {
    py.detach(|| Report::of(&folder, most)).map(|report| report.page.concat()).map_err(failure::of_output)
}
