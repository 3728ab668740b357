//! Loads and material laws that are functions of Python.
//!
//! Analyses compute without the interpreter, some of them in threads of a pool. A load or law attaches its thread for a call and holds no
//! lock meanwhile, so no thread that has the interpreter waits for one that needs it.

use std::cell::Cell;
use std::collections::BTreeMap;
use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use numpy::{IntoPyArray, PyArray2, PyArrayMethods};
use pyo3::exceptions::{PyRecursionError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use tegula::element::Nodal;
use tegula::load::{Dependence, FieldLoad, LoadPoint, node_of_wrong_stiffness};
use tegula::material::{MaterialLaw, Response, Strain};
use tegula::{Mat3, Vec3};
use tegula_io::job::{OwnLoad, OwnParts};

use crate::consistency;
use crate::given::Given;
use crate::state::rows;

/// Most calls of functions within each other in a thread, whose stack would not hold many.
const DEEPEST: u32 = 10;

thread_local! {
    /// Calls of functions under way in this thread.
    static CALLS: Cell<u32> = const { Cell::new(0) };
}

/// Call of a function that is under way.
struct Call;

impl Drop for Call {
    fn drop(&mut self) {
        CALLS.set(CALLS.get() - 1);
    }
}

/// Whether this thread is within a function of a load or law, and so in the midst of a step of some analysis.
pub fn is_within_function() -> bool {
    CALLS.get() > 0
}

/// Result of a function of a load or law.
fn call<'py>(function: &Bound<'py, PyAny>, arguments: Bound<'py, PyTuple>) -> PyResult<Bound<'py, PyAny>> {
    if CALLS.get() >= DEEPEST {
        return Err(PyRecursionError::new_err(
            "a load or material law is evaluated within itself again and again: its function evaluates a model that has it",
        ));
    }
    CALLS.set(CALLS.get() + 1);
    let _call = Call;
    function.call1(arguments)
}

/// Exception of a function, which ends an analysis.
#[derive(Clone, Default)]
pub struct Raised(Arc<Mutex<Option<PyErr>>>);

impl Raised {
    /// Keeps the exception of a result, if it is the first one.
    pub fn keep<T>(&self, result: PyResult<T>) -> Option<T> {
        match result {
            Ok(value) => Some(value),
            Err(error) => {
                self.0.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
                None
            }
        }
    }

    /// Whether there is an exception.
    pub fn is_set(&self) -> bool {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).is_some()
    }

    /// Takes the exception out.
    pub fn take(&self) -> Option<PyErr> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    /// Fails with the exception, if there is one.
    ///
    /// # Errors
    /// The exception.
    pub fn check(&self) -> PyResult<()> {
        self.take().map_or(Ok(()), Err)
    }
}

/// Name, set, number of arguments, forces, stiffness and damping of a load.
type LoadSpec = (String, String, u8, Py<PyAny>, Option<Py<PyAny>>, Option<Py<PyAny>>);

/// Loads and laws that a caller gives to an analysis.
#[pyclass(frozen, module = "tegula._tegula")]
pub struct Own {
    loads: Vec<LoadSpec>,
    /// Material, function, and whether it is rubber.
    laws: Vec<(String, Py<PyAny>, bool)>,
}

#[pymethods]
impl Own {
    #[new]
    fn new(loads: Vec<LoadSpec>, laws: Vec<(String, Py<PyAny>, bool)>) -> Self {
        Self { loads, laws }
    }
}

impl Own {
    /// Loads and laws for one analysis, and the exception that one of them raises.
    pub fn parts(&self, py: Python<'_>) -> (Arc<OwnParts>, Raised) {
        let raised = Raised::default();
        let copy = |function: &Option<Py<PyAny>>| function.as_ref().map(|function| function.clone_ref(py));
        let load = |(name, on, arguments, forces, stiffness, damping): &LoadSpec| {
            let load = PythonLoad {
                name: name.clone(),
                dependence: match arguments {
                    1 => Dependence::Time,
                    2 => Dependence::Positions,
                    _ => Dependence::Velocities,
                },
                forces: forces.clone_ref(py),
                stiffness: copy(stiffness),
                damping: copy(damping),
                checks: StiffnessChecks::default(),
                raised: raised.clone(),
            };
            OwnLoad { name: name.clone(), on: on.clone(), load: Arc::new(load) }
        };
        let law = |(name, function, is_rubber): &(String, Py<PyAny>, bool)| {
            let law = PythonLaw {
                name: name.clone(),
                function: function.clone_ref(py),
                is_rubber: *is_rubber,
                at_rest: OnceLock::new(),
                raised: raised.clone(),
            };
            (name.clone(), Arc::new(law) as Arc<dyn MaterialLaw>)
        };
        let laws: BTreeMap<_, _> = self.laws.iter().map(law).collect();
        let loads = self.loads.iter().map(load).collect();
        (Arc::new(OwnParts { loads, laws }), raised)
    }
}

/// Load that is a function of Python, evaluated for all its nodes in one call.
struct PythonLoad {
    name: String,
    dependence: Dependence,
    forces: Py<PyAny>,
    stiffness: Option<Py<PyAny>>,
    damping: Option<Py<PyAny>>,
    checks: StiffnessChecks,
    raised: Raised,
}

/// Whether stiffness and damping have been found to be derivatives of the forces. Blocks of zero, such as those of a contact that is open, tell nothing of
/// others: they are compared at the first place, at the first one with forces, and the first others once more.
#[derive(Default)]
struct StiffnessChecks {
    /// Whether the last forces were other than zero.
    is_loaded: AtomicBool,
    of_zero: AtomicBool,
    of_zero_under_load: AtomicBool,
    of_others: AtomicBool,
}

impl StiffnessChecks {
    /// Whether these blocks need a comparison, which then is taken for done.
    fn begin(&self, blocks: &[Mat3]) -> bool {
        let is_zero = blocks.iter().all(|block| *block == Mat3::zeros());
        let kind = match (is_zero, self.is_loaded.load(Ordering::Acquire)) {
            (false, _) => &self.of_others,
            (true, true) => &self.of_zero_under_load,
            (true, false) => &self.of_zero,
        };
        !kind.swap(true, Ordering::AcqRel)
    }
}

impl fmt::Debug for PythonLoad {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("PythonLoad").field("name", &self.name).finish_non_exhaustive()
    }
}

/// Vectors as an array with a row for each.
fn vectors<'py>(py: Python<'py>, values: &[Vec3]) -> PyResult<Bound<'py, PyArray2<f64>>> {
    rows(py, values.iter().map(|x| (*x).into()).collect())
}

impl PythonLoad {
    /// Arguments of a call.
    fn arguments<'py>(&self, py: Python<'py>, at: &LoadPoint) -> PyResult<Bound<'py, PyTuple>> {
        match self.dependence {
            Dependence::Time => (at.time,).into_pyobject(py),
            Dependence::Positions => (at.time, vectors(py, at.positions)?).into_pyobject(py),
            Dependence::Velocities => {
                (at.time, vectors(py, at.positions)?, vectors(py, at.velocities)?).into_pyobject(py)
            }
        }
    }

    fn evaluate(&self, at: &LoadPoint, out: &mut [Nodal]) -> PyResult<()> {
        Python::attach(|py| {
            let value = call(self.forces.bind(py), self.arguments(py, at)?)?;
            let what = format!("forces of the load \"{}\"", self.name);
            let given = Given::new(&what, &value, &[out.len(), 3])?;
            out.as_flattened_mut().copy_from_slice(given.finite(&what, 3)?);
            let is_loaded = out.as_flattened().iter().any(|x| *x != 0.0);
            self.checks.is_loaded.store(is_loaded, Ordering::Release);
            Ok(())
        })
    }

    /// Refuses functions of the stiffness and the damping that are no derivatives of the forces.
    fn check(&self, at: &LoadPoint) -> PyResult<()> {
        let damped = self.damping.is_some().then_some(([0.0, 1.0], "damping", "velocity"));
        let parts = [Some(([1.0, 0.0], "stiffness", "position")), damped];
        for (weights, what, of) in parts.into_iter().flatten() {
            if let Some(row) = node_of_wrong_stiffness(self, at, weights) {
                return Err(PyValueError::new_err(format!(
                    "the {what} of the load \"{}\" is not the derivative of its forces, with the other sign: row {row} at t = {} differs from \
                     -df/dx of its own {of} x by differences; correct it, or leave it out for differences",
                    self.name, at.time
                )));
            }
        }
        Ok(())
    }

    /// Adds the blocks of a function, times a weight.
    fn add_blocks(
        &self,
        (function, what, weight): (&Py<PyAny>, &str, f64),
        at: &LoadPoint,
        out: &mut [Mat3],
    ) -> PyResult<()> {
        Python::attach(|py| {
            let value = call(function.bind(py), self.arguments(py, at)?)?;
            let what = format!("{what} of the load \"{}\"", self.name);
            let given = Given::new(&what, &value, &[out.len(), 3, 3])?;
            let blocks = given.finite(&what, 9)?.chunks_exact(9);
            out.iter_mut().zip(blocks).for_each(|(out, block)| *out += Mat3::from_row_slice(block) * weight);
            Ok(())
        })
    }
}

impl FieldLoad for PythonLoad {
    fn dependence(&self) -> Dependence {
        self.dependence
    }

    fn forces(&self, at: &LoadPoint, out: &mut [Nodal]) {
        if self.raised.is_set() || self.raised.keep(self.evaluate(at, out)).is_none() {
            out.fill([f64::NAN; 3]);
        }
    }

    fn stiffness(&self, at: &LoadPoint, weights: [f64; 2], out: &mut [Mat3]) {
        let Some(stiffness) = &self.stiffness else {
            return tegula::load::stiffness_by_differences(self, at, weights, out);
        };
        out.fill(Mat3::zeros());
        let parts = [(Some(stiffness), "stiffness"), (self.damping.as_ref(), "damping")];
        for ((function, what), weight) in parts.into_iter().zip(weights) {
            let Some(function) = function.filter(|_| weight != 0.0) else { continue };
            let done = !self.raised.is_set()
                && self.raised.keep(self.add_blocks((function, what, weight), at, out)).is_some();
            if !done {
                return out.fill(Mat3::repeat(f64::NAN));
            }
        }
        if self.checks.begin(out) {
            self.raised.keep(self.check(at));
        }
    }
}

/// Elastic law that is a function of Python, evaluated for many points in one call.
struct PythonLaw {
    name: String,
    function: Py<PyAny>,
    is_rubber: bool,
    /// Energy without strain, once energy, stress and tangent have been found to be derivatives of each other.
    at_rest: OnceLock<f64>,
    raised: Raised,
}

/// Difference of a tangent from its transpose, and stress without strain, over the largest entry of the tangent.
const UNSYMMETRIC: f64 = 1e-8;

impl fmt::Debug for PythonLaw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("PythonLaw").field("name", &self.name).finish_non_exhaustive()
    }
}

impl PythonLaw {
    /// Responses at strains; before the first ones the law is checked. Energies are those above the one without strain.
    fn evaluate(&self, strains: &[Strain]) -> PyResult<Vec<Option<Response>>> {
        let at_rest = match self.at_rest.get() {
            Some(known) => *known,
            None => {
                let found = self.check()?;
                *self.at_rest.get_or_init(|| found)
            }
        };
        let (mut responses, _) = self.responses(strains)?;
        responses.iter_mut().flatten().for_each(|response| response.energy -= at_rest);
        Ok(responses)
    }

    /// Energy without strain. Refuses a law whose stress is no derivative of its energy, or whose tangent is none of its stress.
    fn check(&self) -> PyResult<f64> {
        let (responses, is_coarse) = self.responses(&consistency::strains())?;
        // Differences of numbers of single precision are round-off.
        if let Some(mistake) = consistency::mistake(&responses).filter(|_| !is_coarse) {
            let name = &self.name;
            return Err(PyValueError::new_err(format!("the law of material \"{name}\" {mistake}")));
        }
        Ok(responses.first().and_then(Option::as_ref).map_or(0.0, |response| response.energy))
    }

    /// Responses at strains, and whether they are of less than double precision.
    fn responses(&self, strains: &[Strain]) -> PyResult<(Vec<Option<Response>>, bool)> {
        Python::attach(|py| {
            let n = strains.len();
            let values: Vec<f64> = strains.iter().flat_map(|s| s.iter().copied()).collect();
            let values = values.into_pyarray(py).reshape([n, 6])?;
            let value = call(self.function.bind(py), (values,).into_pyobject(py)?)?;
            let what = |part: &str| format!("{part} of the law of material \"{}\"", self.name);
            let (energy, stress, tangent): (Bound<'_, PyAny>, Bound<'_, PyAny>, Bound<'_, PyAny>) =
                value.extract().map_err(|cause| {
                    let error = PyValueError::new_err(format!(
                        "the law of material \"{}\" gives no tuple of energy, stress and tangent",
                        self.name
                    ));
                    error.set_cause(py, Some(cause));
                    error
                })?;
            let energy = Given::new(&what("energy"), &energy, &[n])?;
            let stress = Given::new(&what("stress"), &stress, &[n, 6])?;
            let tangent = Given::new(&what("tangent"), &tangent, &[n, 6, 6])?;
            let is_coarse = [&energy, &stress, &tangent].iter().any(|given| given.is_coarse());
            let parts = energy.values()?.iter().zip(stress.values()?.chunks_exact(6));
            let parts = parts.zip(tangent.values()?.chunks_exact(36)).zip(strains);
            let responses: PyResult<_> = parts
                .map(|(((energy, stress), tangent), at)| self.response(*energy, stress, tangent, at))
                .collect();
            Ok((responses?, is_coarse))
        })
    }

    /// Response at a point; `None` where the law has given NaN.
    fn response(
        &self,
        energy: f64,
        stress: &[f64],
        tangent: &[f64],
        at: &Strain,
    ) -> PyResult<Option<Response>> {
        let response = Response {
            stress: Strain::from_column_slice(stress),
            tangent: nalgebra::Matrix6::from_row_slice(tangent),
            energy,
            dissipation: 0.0,
        };
        if !stress.iter().chain(tangent).chain([&energy]).all(|x| x.is_finite()) {
            return Ok(None);
        }
        let size = response.tangent.amax();
        let refuse =
            |what: &str| Err(PyValueError::new_err(format!("the law of material \"{}\" {what}", self.name)));
        if (response.tangent - response.tangent.transpose()).amax() > UNSYMMETRIC * size {
            let strain: Vec<_> = at.iter().map(|x| format!("{x:.6e}")).collect();
            return refuse(&format!(
                "has a tangent that is not symmetric, at the strain [{}]: it is the derivative of the stress, and that one of the energy",
                strain.join(", ")
            ));
        }
        if *at == Strain::zeros() && response.stress.amax() > UNSYMMETRIC * size {
            return refuse(
                "has a stress without strain, and a body at rest has none: give `prestress` or `natural` strains of the model file",
            );
        }
        Ok(Some(response))
    }
}

impl MaterialLaw for PythonLaw {
    fn respond(&self, strain: &Strain, _: &[f64], _: &mut [f64]) -> Option<Response> {
        self.respond_many(std::slice::from_ref(strain)).pop().flatten()
    }

    fn is_hyperelastic(&self) -> bool {
        self.is_rubber
    }

    fn is_collected(&self) -> bool {
        true
    }

    fn respond_many(&self, strains: &[Strain]) -> Vec<Option<Response>> {
        let found = if self.raised.is_set() || strains.is_empty() {
            None
        } else {
            self.raised.keep(self.evaluate(strains))
        };
        found.unwrap_or_else(|| vec![None; strains.len()])
    }
}
