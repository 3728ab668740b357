//! States of a model: read, changed, pickled.

use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyBytes;
use tegula::System;
use tegula::analysis;
use tegula::element::Nodal;

/// A state as bytes, with the displacements in the middle of its last step, which these lack, its analysis, and the fingerprint of its mesh.
type Dump<'py> = (Bound<'py, PyBytes>, Bound<'py, PyArray2<f64>>, String, u64);

/// A field of three components as an array with a row for each vector.
pub fn rows<'py>(py: Python<'py>, values: Vec<Nodal>) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let number = values.len();
    values.into_flattened().into_pyarray(py).reshape([number, 3])
}

/// A state of a model, with the arrays of its fields that Python has read.
#[pyclass(frozen, module = "tegula._tegula")]
pub struct State {
    state: analysis::State,
    /// Analysis that has reached the state; empty: none has.
    analysis: String,
    /// Fingerprint of the system to which the state belongs.
    mesh: u64,
    fields: [PyOnceLock<Py<PyArray2<f64>>>; 3],
}

impl State {
    /// State of a system for Python, with the name of the analysis that has reached it.
    pub fn new(state: analysis::State, analysis: &str, system: &System) -> Self {
        Self::with(state, analysis.to_owned(), system.fingerprint())
    }

    fn with(state: analysis::State, analysis: String, mesh: u64) -> Self {
        Self { state, analysis, mesh, fields: std::array::from_fn(|_| PyOnceLock::new()) }
    }

    /// Another state, from this one.
    pub fn changed(&self, state: analysis::State) -> Self {
        Self::with(state, self.analysis.clone(), self.mesh)
    }

    /// State, if an analysis of a system can start there.
    ///
    /// # Errors
    /// The state does not fit the system, or no analysis of this kind has reached it.
    pub fn as_start(&self, system: &System, analysis: &str) -> PyResult<&analysis::State> {
        let state = self.of(system)?;
        if let Some(v) = state.moved_support(system) {
            return Err(PyValueError::new_err(format!(
                "the state belongs to another model: node {} moves, or is elsewhere, where this model holds it; continue with other supports by \
                 [[steps]]",
                system.coordinates.nodes[v]
            )));
        }
        if let Some(v) = state.distorted_director(system) {
            let what = match system.coordinates.body_of(v) {
                Some(body) => format!("the directors of body \"{}\" are not orthonormal", body.name),
                None => {
                    format!("the director of node {} has not its length of 1", system.coordinates.nodes[v])
                }
            };
            return Err(PyValueError::new_err(format!("{what}: Equations.moved keeps directors so")));
        }
        if self.analysis == analysis {
            return Ok(state);
        }
        let found = match self.analysis.as_str() {
            "" => "no analysis has reached the state: start from the `state` of a simulation".to_owned(),
            other => format!("the state is one of a {other} analysis"),
        };
        Err(PyValueError::new_err(format!("{found}, and the analysis of the model is {analysis}")))
    }

    /// State, if it fits a system.
    ///
    /// # Errors
    /// Its arrays have other lengths, or it belongs to another mesh.
    pub fn of(&self, system: &System) -> PyResult<&analysis::State> {
        match self.state.misfit(system) {
            None if self.mesh == system.fingerprint() => Ok(&self.state),
            None => Err(PyValueError::new_err(
                "the state belongs to another model: its nodes or its elements are others",
            )),
            Some(array) => Err(PyValueError::new_err(format!(
                "the state belongs to another model: its array `{array}` has another length"
            ))),
        }
    }

    /// Read-only array of a field, which is copied in the first call; zero where the state has none.
    fn field<'py>(&self, py: Python<'py>, number: usize) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let state = &self.state;
        let made = self.fields[number].get_or_try_init(py, || -> PyResult<_> {
            let mut values = [&state.u, &state.v, &state.a][number].clone();
            values.resize(state.u.len(), [0.0; 3]);
            let array = rows(py, values)?;
            array.readwrite().make_nonwriteable();
            Ok(array.unbind())
        })?;
        Ok(made.bind(py).clone())
    }
}

/// Values of a given field, one for each nodal vector.
fn given(name: &str, vectors: usize, field: &PyReadonlyArray2<f64>) -> PyResult<Vec<Nodal>> {
    let values = field.as_array();
    if values.dim() != (vectors, 3) {
        let (rows, columns) = values.dim();
        return Err(PyValueError::new_err(format!(
            "{name}: the shape is ({rows}, {columns}), and the model has {vectors} nodal vectors: give ({vectors}, 3)"
        )));
    }
    finite(name, values.iter())?;
    Ok(values.outer_iter().map(|row| std::array::from_fn(|i| row[i])).collect())
}

/// Refuses values that are no numbers.
///
/// # Errors
/// A value is NaN or infinite.
pub fn finite<'a>(name: &str, mut values: impl Iterator<Item = &'a f64>) -> PyResult<()> {
    match values.find(|x| !x.is_finite()) {
        None => Ok(()),
        Some(x) => Err(PyValueError::new_err(format!("{name}: {x} is not a finite number"))),
    }
}

/// Values of a given vector.
///
/// # Errors
/// It has another length, or values that are no numbers.
pub fn vector(name: &str, length: usize, given: &PyReadonlyArray1<f64>) -> PyResult<Vec<f64>> {
    let values = given.as_array();
    if values.len() != length {
        let found = values.len();
        return Err(PyValueError::new_err(format!("{name}: {found} values are given for {length}")));
    }
    finite(name, values.iter())?;
    Ok(values.to_vec())
}

#[pymethods]
impl State {
    /// State with other values in place of those given.
    #[pyo3(signature = (time, displacements, velocities, accelerations, multipliers))]
    fn replaced(
        &self,
        time: Option<f64>,
        displacements: Option<PyReadonlyArray2<f64>>,
        velocities: Option<PyReadonlyArray2<f64>>,
        accelerations: Option<PyReadonlyArray2<f64>>,
        multipliers: Option<PyReadonlyArray1<f64>>,
    ) -> PyResult<Self> {
        let mut state = self.state.clone();
        let vectors = state.u.len();
        if let Some(time) = time {
            finite("time", std::iter::once(&time))?;
            state.time = time;
        }
        if let Some(field) = displacements {
            state.u = given("displacements", vectors, &field)?;
        }
        if let Some(field) = velocities {
            state.v = given("velocities", vectors, &field)?;
        }
        if let Some(field) = accelerations {
            state.a = given("accelerations", vectors, &field)?;
        }
        if let Some(values) = multipliers {
            state.multipliers = vector("multipliers", state.multipliers.len(), &values)?;
        }
        Ok(self.changed(state))
    }

    /// Time (load factor).
    #[getter]
    fn time(&self) -> f64 {
        self.state.time
    }

    /// Number of the last finished step.
    #[getter]
    fn step(&self) -> u64 {
        self.state.step
    }

    /// Displacements of the nodal vectors.
    #[getter]
    fn displacements<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.field(py, 0)
    }

    /// Velocities of the nodal vectors.
    #[getter]
    fn velocities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.field(py, 1)
    }

    /// Accelerations of the nodal vectors.
    #[getter]
    fn accelerations<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.field(py, 2)
    }

    /// Lagrange multipliers.
    #[getter]
    fn multipliers<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let array = self.state.multipliers.clone().into_pyarray(py);
        array.readwrite().make_nonwriteable();
        array
    }

    /// Whether all data of another state are equal.
    fn equals(&self, other: &Bound<'_, Self>) -> bool {
        self.state == other.get().state
            && self.analysis == other.get().analysis
            && self.mesh == other.get().mesh
    }

    /// Data of a pickle.
    fn dump<'py>(&self, py: Python<'py>) -> PyResult<Dump<'py>> {
        let bytes = py.detach(|| rmp_serde::to_vec_named(&self.state));
        let bytes = bytes.map_err(|error| PyValueError::new_err(error.to_string()))?;
        Ok((PyBytes::new(py, &bytes), rows(py, self.state.middle.clone())?, self.analysis.clone(), self.mesh))
    }

    /// State of [`dump`](Self::dump).
    #[staticmethod]
    fn load(
        py: Python<'_>,
        bytes: &[u8],
        middle: PyReadonlyArray2<f64>,
        analysis: String,
        mesh: u64,
    ) -> PyResult<Self> {
        let state = py.detach(|| rmp_serde::from_slice::<analysis::State>(bytes));
        let mut state = state.map_err(|error| {
            PyValueError::new_err(format!(
                "the state cannot be read: it is damaged, or of another version of tegula ({error})"
            ))
        })?;
        state.middle = given("middle", middle.as_array().nrows(), &middle)?;
        Ok(Self::with(state, analysis, mesh))
    }
}
