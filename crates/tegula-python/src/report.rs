//! Reports, tables and fields of results.

use std::path::PathBuf;

use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayDyn, PyArrayMethods};
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use tegula_io::out::csv;
use tegula_io::out::vtu_file::{ArrayHead, Cells, Place, VtuFile};
use tegula_io::report::{self, Report};

use crate::failure;
use crate::state::rows;

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

/// File with the fields of an instant, whose arrays are decoded on demand.
#[pyclass(frozen, module = "tegula._tegula")]
pub struct FieldFile(VtuFile);

#[pymethods]
impl FieldFile {
    /// Opens a file.
    #[staticmethod]
    fn open(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        py.detach(|| VtuFile::open(&path)).map(Self).map_err(failure::of_output)
    }

    /// Names of the fields on points, and of those on cells.
    fn names(&self) -> [Vec<String>; 2] {
        [Place::Points, Place::Cells].map(|place| self.of(place).map(|head| head.name.clone()).collect())
    }

    /// Positions of the points.
    fn points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        rows(py, py.detach(|| self.0.coordinates()).map_err(failure::of_output)?)
    }

    /// Quadrilaterals and lines by the numbers of their points.
    fn cells<'py>(&self, py: Python<'py>) -> PyResult<[Bound<'py, PyArray2<u32>>; 2]> {
        let Cells { quads, lines } = py.detach(|| self.0.cells()).map_err(failure::of_output)?;
        let sizes = [[quads.len(), 4], [lines.len(), 2]];
        let quads = quads.into_flattened().into_pyarray(py).reshape(sizes[0])?;
        Ok([quads, lines.into_flattened().into_pyarray(py).reshape(sizes[1])?])
    }

    /// Values of a field on points or cells, with a column for each component where it has several.
    fn values<'py>(
        &self,
        py: Python<'py>,
        on_cells: bool,
        name: &str,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let place = if on_cells { Place::Cells } else { Place::Points };
        let head = self.of(place).find(|head| head.name == name);
        let head = head.ok_or_else(|| PyKeyError::new_err(name.to_owned()))?;
        let values = py.detach(|| self.0.values(head)).map_err(failure::of_output)?;
        let count = if on_cells { self.0.cells } else { self.0.points };
        let shape = if head.components == 1 { vec![count] } else { vec![count, head.components] };
        values.into_pyarray(py).reshape(shape)
    }
}

impl FieldFile {
    fn of(&self, place: Place) -> impl Iterator<Item = &ArrayHead> {
        self.0.arrays.iter().filter(move |head| head.place == place)
    }
}
