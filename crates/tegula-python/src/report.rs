//! Reports and tables of results.

use std::path::PathBuf;

use numpy::{IntoPyArray, PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use tegula_io::out::csv;
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

/// Columns of a table with their names, as read-only arrays.
#[pyfunction]
pub fn read_table(py: Python<'_>, path: PathBuf) -> PyResult<Vec<(String, Bound<'_, PyArray1<f64>>)>> {
    let columns = py.detach(|| csv::read_columns(&path)).map_err(failure::of_output)?;
    let array = |(name, values): (String, Vec<f64>)| {
        let array = values.into_pyarray(py);
        array.readwrite().make_nonwriteable();
        (name, array)
    };
    Ok(columns.into_iter().map(array).collect())
}
