//! Residual, tangent, mass and constraints of a model as functions of a state.

use std::sync::{Arc, OnceLock};

use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rayon::ThreadPool;
use tegula::analysis::{self, equilibrium};
use tegula::element::{Motion, TangentWeights};
use tegula::system::assembly::TangentCoefficients;
use tegula::system::dof_map::CONSTRAINED;
use tegula::system::{CirculatoryStiffness, VectorKind};
use tegula::{System, Vec3};
use tegula_io::job::Prepared;

use crate::failure;
use crate::matrices::{Arrays, Compressed};
use crate::own::Raised;
use crate::state::{State, finite, rows, vector};
use crate::threads::compute;

/// Sparse matrix as a list of rows, columns and values.
type Entries<'py> = (Bound<'py, PyArray1<i64>>, Bound<'py, PyArray1<i64>>, Bound<'py, PyArray1<f64>>);

/// The equations of motion of a compiled model.
#[pyclass(frozen, module = "tegula._tegula")]
pub struct Equations {
    prepared: Arc<Prepared>,
    /// Exception of a load or law of the caller.
    raised: Raised,
    /// Threads for callers other than the main thread.
    pool: OnceLock<ThreadPool>,
}

impl Equations {
    /// Equations of a prepared model, and the exception of its loads and laws.
    pub fn new(prepared: Arc<Prepared>, raised: Raised) -> Self {
        Self { prepared, raised, pool: OnceLock::new() }
    }

    fn system(&self) -> &System {
        &self.prepared.system
    }

    /// Evaluates a function of the system and a state without the interpreter.
    fn at<T: Send>(
        &self,
        py: Python<'_>,
        state: &Bound<'_, State>,
        evaluate: impl FnOnce(&System, &analysis::State) -> T + Send,
    ) -> PyResult<T> {
        let system = self.system();
        let state = state.get().of(system)?;
        // Functions may read values that have changed since the last evaluation.
        system.forget_field_loads();
        let found = compute(py, &self.pool, || evaluate(system, state));
        self.raised.check()?;
        found
    }

    /// Symmetric matrix of the free degrees of freedom with these values of its lower triangle.
    fn symmetric<'py>(&self, py: Python<'py>, lower: &[f64]) -> PyResult<Arrays<'py>> {
        all_finite(lower)?;
        let whole =
            compute(py, &self.pool, || Compressed::symmetric(&self.system().tangent_pattern(), lower))?;
        Ok(whole.into_arrays(py))
    }
}

/// Refuses forces and matrices that could not be evaluated.
fn all_finite(values: &[f64]) -> PyResult<()> {
    if values.iter().all(|x| x.is_finite()) {
        return Ok(());
    }
    let message =
        "the forces at this state are not finite: an element is inverted, or a law cannot be evaluated there";
    Err(failure::AnalysisError::new_err((message, None::<String>)))
}

/// Exception of an analysis without a tangent.
fn without_tangent(_: tegula::Error) -> PyErr {
    PyValueError::new_err(
        "the analysis of the model has no tangent, from which tangent and mass have their pattern: it is explicit, or static with \
         the iterative linear solver; take another scheme or `linear_solver = \"direct\"`",
    )
}

#[pymethods]
impl Equations {
    /// Number of free degrees of freedom.
    #[getter]
    fn unknowns(&self) -> usize {
        self.system().unknowns()
    }

    /// Node of each nodal vector; −1 for those of bodies.
    fn nodes<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        let number = |&node: &u32| if node == u32::MAX { -1 } else { i64::from(node) };
        self.system().coordinates.nodes.iter().map(number).collect::<Vec<_>>().into_pyarray(py)
    }

    /// Name of the body of each nodal vector; empty for those of nodes.
    fn bodies(&self) -> Vec<String> {
        let of = &self.system().coordinates;
        let name = |v: usize| match of.nodes[v] {
            u32::MAX => of.body_of(v).map_or_else(String::new, |body| body.name.clone()),
            _ => String::new(),
        };
        (0..of.len()).map(name).collect()
    }

    /// Kind of each nodal vector.
    fn kinds(&self) -> Vec<&'static str> {
        let name = |kind: &VectorKind| match kind {
            VectorKind::Position => "position",
            VectorKind::Director => "director",
            VectorKind::Gradient => "gradient",
        };
        self.system().coordinates.kinds.iter().map(name).collect()
    }

    /// Nodal vectors of the reference configuration.
    fn reference<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        rows(py, self.system().coordinates.reference.clone())
    }

    /// Numbers of the free degrees of freedom of each nodal vector; −1 for constrained ones.
    fn numbers<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i64>>> {
        let system = self.system();
        let number = |n: u32| if n == CONSTRAINED { -1 } else { i64::from(n) };
        let all: Vec<i64> = (0..system.vectors()).flat_map(|v| system.dofs().of(v).map(number)).collect();
        all.into_pyarray(py).reshape([system.vectors(), 3])
    }

    /// Name of the joint of each constraint.
    fn joints(&self) -> Vec<String> {
        let joints = self.system().joints.iter();
        joints.flat_map(|joint| std::iter::repeat_n(joint.name.clone(), joint.rows.len())).collect()
    }

    /// State at rest without deformation, with the prescribed displacements of a time.
    fn state(&self, time: f64) -> PyResult<State> {
        finite("time", std::iter::once(&time))?;
        let system = self.system();
        let mut state = analysis::State { time, ..analysis::State::unloaded(system) };
        system.prescribe(time, &mut state.u);
        Ok(State::new(state, "", system))
    }

    /// State behind an increment of the free degrees of freedom.
    fn moved(
        &self,
        py: Python<'_>,
        state: &Bound<'_, State>,
        increment: PyReadonlyArray1<f64>,
    ) -> PyResult<State> {
        let increment = vector("increment", self.system().unknowns(), &increment)?;
        let moved = self.at(py, state, |system, state| {
            let u = equilibrium::moved(system, state, &increment);
            analysis::State { u, ..state.clone() }
        })?;
        Ok(state.get().changed(moved))
    }

    /// Residual of the free degrees of freedom.
    fn residual<'py>(
        &self,
        py: Python<'py>,
        state: &Bound<'py, State>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let values = self.at(py, state, equilibrium::residual)?;
        all_finite(&values)?;
        Ok(values.into_pyarray(py))
    }

    /// Tangent stiffness: its symmetric part in compressed columns, and entries of the skew one.
    fn tangent<'py>(
        &self,
        py: Python<'py>,
        state: &Bound<'py, State>,
    ) -> PyResult<(Arrays<'py>, Entries<'py>)> {
        let (symmetric, skew) = self
            .at(py, state, |system, state| {
                let (_, values) = equilibrium::tangent(system, state)?;
                Ok((values, skew_entries(system, state)))
            })?
            .map_err(without_tangent)?;
        let (rows, columns, values) = skew;
        all_finite(&values)?;
        let skew = (rows.into_pyarray(py), columns.into_pyarray(py), values.into_pyarray(py));
        Ok((self.symmetric(py, &symmetric)?, skew))
    }

    /// Mass matrix in compressed columns.
    fn mass<'py>(&self, py: Python<'py>, state: &Bound<'py, State>) -> PyResult<Arrays<'py>> {
        let values = self.at(py, state, equilibrium::mass)?.map_err(without_tangent)?;
        self.symmetric(py, &values)
    }

    /// Values of the constraints of joints, and their gradients in compressed rows.
    fn constraints<'py>(
        &self,
        py: Python<'py>,
        state: &Bound<'py, State>,
    ) -> PyResult<(Bound<'py, PyArray1<f64>>, Arrays<'py>)> {
        let found = self.at(py, state, equilibrium::constraints)?;
        let (mut values, mut gradients) = (Vec::with_capacity(found.len()), Compressed::new());
        for (value, gradient) in found {
            values.push(value);
            gradient.into_iter().for_each(|(number, x)| gradients.push(number, x));
            gradients.end();
        }
        all_finite(&values)?;
        all_finite(&gradients.values)?;
        Ok((values.into_pyarray(py), gradients.into_arrays(py)))
    }

    /// Change of the components of all nodal vectors with the free degrees of freedom, in compressed rows.
    fn expansion<'py>(&self, py: Python<'py>, state: &Bound<'py, State>) -> PyResult<Arrays<'py>> {
        let found = self.at(py, state, |system, state| {
            let (frames, mut out) = (equilibrium::frames(system, state), Compressed::new());
            for (v, axis) in (0..system.vectors()).flat_map(|v| [0, 1, 2].map(|axis| (v, axis))) {
                frames.reduce_one(v, &Vec3::ith(axis, 1.0), |number, x| out.push(number, x));
                out.end();
            }
            out
        })?;
        Ok(found.into_arrays(py))
    }
}

/// Entries of the skew part of the tangent stiffness, which follower loads may have.
fn skew_entries(system: &System, state: &analysis::State) -> (Vec<i64>, Vec<i64>, Vec<f64>) {
    let (mut rows, mut columns, mut values) = (Vec::new(), Vec::new(), Vec::new());
    if system.has_follower_loads() {
        let mut stiffness = CirculatoryStiffness::new(system);
        let parts = TangentCoefficients { weights: TangentWeights::STATIC, mass: 0.0, time: state.time };
        stiffness.take(system, &Motion::State { u: &state.u, velocity: None }, &parts);
        stiffness.for_each_entry(&equilibrium::frames(system, state), |row, column, value| {
            rows.push(i64::from(row));
            columns.push(i64::from(column));
            values.push(value);
        });
    }
    (rows, columns, values)
}
