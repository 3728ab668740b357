//! Analyses that Python advances step by step.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, TryLockError};

use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods};
use pyo3::exceptions::{PyKeyError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::MutexExt;
use rayon::ThreadPool;
use self_cell::self_cell;
use tegula::System;
use tegula::analysis::{Observer, Silent, State, Step, Stepper, dynamics, path, statics};
use tegula::load::Signal;
use tegula::model::{Analysis, Scheme, TransientAnalysis};
use tegula_io::deck::Deck;
use tegula_io::job::{self, HistoryRows, OwnParts, Prepared};

use crate::equations::Equations;
use crate::failure;
use crate::own::{Raised, is_within_function};
use crate::state::{self, rows};
use crate::threads::compute;

type Borrowed<'a> = Box<dyn Stepper + 'a>;

self_cell!(
    /// A prepared model and the analysis that refers to it.
    struct Running {
        owner: Arc<Prepared>,
        #[not_covariant]
        dependent: Borrowed,
    }
);

/// An analysis with what it records.
struct Analysed {
    running: Running,
    rows: HistoryRows,
    /// State before the last step, which is empty before the first one.
    before: State,
    /// Buffer of the state at the start of a step.
    start: State,
    /// Iterations of the last step.
    iterations: u32,
    signals: BTreeMap<String, Signal>,
    /// Values of the signals in the last step, in their order.
    applied: Vec<f64>,
    /// Position at which the step ends that is to be taken again.
    again_to: Option<f64>,
    /// Warnings of the analysis that Python has not had yet.
    warned: Warned,
}

/// The analysis of a model, step by step.
#[pyclass(frozen, module = "tegula._tegula")]
pub struct Steps {
    analysed: Mutex<Analysed>,
    columns: Vec<String>,
    warnings: Vec<String>,
    /// Exception of a load or law of the caller.
    raised: Raised,
    /// Threads for callers other than the main thread.
    pool: OnceLock<ThreadPool>,
}

impl Steps {
    /// Begins the analysis of a model, at its beginning or at the state `start`, with signals in place of the amplitudes named.
    ///
    /// # Errors
    /// The model is wrong, its analysis has no steps or several parts, it has no such amplitude, or the state is not one of it.
    pub fn new(
        deck: &Deck,
        (signals, start): (&[String], Option<&state::State>),
        (own, raised): (Arc<OwnParts>, Raised),
    ) -> PyResult<Self> {
        let mut prepared = job::prepare_with(deck, own).map_err(failure::of_run)?;
        if !prepared.model.steps.is_empty() {
            return Err(PyValueError::new_err(
                "a model with `[[steps]]` is run as a whole: use run(), or give it an `[analysis]` of its own",
            ));
        }
        if !signals.is_empty() {
            takes_signals(&prepared.model.analysis)?;
        }
        let mut given = BTreeMap::new();
        for name in signals {
            takes_a_signal(&prepared.system, name)?;
            let unknown = || {
                PyKeyError::new_err(format!(
                    "the model has no amplitude \"{name}\" that a load or drive follows"
                ))
            };
            let signal = prepared.system.signal(name).ok_or_else(unknown)?;
            given.insert(name.clone(), signal);
        }
        let rows = HistoryRows::new(&prepared.model, &prepared);
        let columns = rows.columns().to_vec();
        let warnings = prepared.warnings.iter().map(ToString::to_string).collect();
        let analysis = kind(&prepared.model.analysis);
        let start = start.map(|state| state.as_start(&prepared.system, &analysis)).transpose()?.cloned();
        let running = Running::try_new(Arc::new(prepared), |prepared| begun(prepared, start))?;
        let analysed = Analysed {
            running,
            rows,
            before: State::default(),
            start: State::default(),
            iterations: 0,
            applied: given.values().map(Signal::value).collect(),
            signals: given,
            again_to: None,
            warned: Warned { messages: Vec::new(), raised: raised.clone() },
        };
        Ok(Self { analysed: Mutex::new(analysed), columns, warnings, raised, pool: OnceLock::new() })
    }

    /// The analysis, for which a step in another thread is waited for.
    ///
    /// # Errors
    /// A load or law would wait for the step that waits for it.
    fn lock(&self, py: Python<'_>) -> PyResult<MutexGuard<'_, Analysed>> {
        match self.analysed.try_lock() {
            Ok(guard) => Ok(guard),
            Err(TryLockError::Poisoned(poisoned)) => Ok(poisoned.into_inner()),
            Err(TryLockError::WouldBlock) if is_within_function() => Err(PyRuntimeError::new_err(
                "the simulation is in the middle of a step, and a load or material law cannot read it meanwhile: use the arguments of the function \
                 (time, positions, velocities; strains)",
            )),
            // A thread that waits must not hold the interpreter, which the other one needs.
            Err(TryLockError::WouldBlock) => {
                Ok(self.analysed.lock_py_attached(py).unwrap_or_else(|poisoned| poisoned.into_inner()))
            }
        }
    }

    /// Reads the present state.
    fn read<T>(&self, py: Python<'_>, read: impl FnOnce(&Prepared, &dyn Stepper) -> T) -> PyResult<T> {
        let guard = self.lock(py)?;
        Ok(guard.running.with_dependent(|prepared, stepper| read(prepared, stepper.as_ref())))
    }
}

/// Name of an analysis with steps: another one starts from its states if it has the same.
fn kind(analysis: &Analysis) -> String {
    match analysis {
        Analysis::Transient(options) => format!("transient {}", options.scheme.name()),
        Analysis::Path(_) => "path".into(),
        _ => "static".into(),
    }
}

/// Refuses signals in analyses that cannot hold a value constant within a step.
fn takes_signals(analysis: &Analysis) -> PyResult<()> {
    match analysis {
        Analysis::Transient(TransientAnalysis { scheme: Scheme::EnergyMomentum(_), .. }) => Ok(()),
        // Other schemes evaluate loads and drives at the end of a step, too, where the value of the next one acts already.
        Analysis::Transient(_) => Err(PyValueError::new_err(
            "signals are constant within a step only with the scheme `energy-momentum`: give the analysis \
             scheme = {type = \"energy-momentum\"}",
        )),
        // The start of a load step would be no equilibrium, and its release of energy would be taken for a snap.
        _ => Err(PyValueError::new_err(
            "signals act in transient analyses; for a static one, run one model for each value, or give the amplitude a table",
        )),
    }
}

/// Refuses signals that move supports, whose velocity would be unknown, or that scale prescribed strains, whose change between two steps does work.
fn takes_a_signal(system: &System, amplitude: &str) -> PyResult<()> {
    let follows =
        |number: Option<usize>| number.is_some_and(|number| system.amplitude_name(number) == amplitude);
    if system.dofs().prescribed.iter().any(|prescribed| follows(prescribed.amplitude)) {
        return Err(PyValueError::new_err(format!(
            "the amplitude \"{amplitude}\" moves supports (`prescribe`), whose velocity a signal does not give: drive a joint, or a \
             body that the nodes are attached to"
        )));
    }
    if system.prescribed_strains.iter().any(|field| follows(field.factor.amplitude)) {
        return Err(PyValueError::new_err(format!(
            "the amplitude \"{amplitude}\" scales prescribed strains, and the work of a jump in them would be missing in the energy balance: give it \
             a table of times and values"
        )));
    }
    Ok(())
}

/// Observer that keeps warnings, and interrupts a step in which a load or law has raised an exception.
struct Warned {
    messages: Vec<String>,
    raised: Raised,
}

impl Observer for Warned {
    fn on_step(&mut self, _step: &Step) -> tegula::Result<()> {
        Ok(())
    }

    fn on_event(&mut self, _message: &str) {}

    fn on_warning(&mut self, message: &str) {
        self.messages.push(message.to_owned());
    }

    fn interrupted(&self) -> bool {
        self.raised.is_set()
    }
}

/// The analysis of a prepared model at its beginning, or at a state of it.
fn begun(prepared: &Prepared, start: Option<State>) -> PyResult<Borrowed<'_>> {
    let system = &prepared.system;
    let stepper = match &prepared.model.analysis {
        Analysis::Static(options) => statics::steps(system, options, start),
        Analysis::Path(options) => path::steps(system, options, start).map(|(stepper, _)| stepper),
        Analysis::Transient(options) => dynamics::steps(system, options, start),
        Analysis::Modal(_) | Analysis::Buckling(_) => {
            return Err(PyValueError::new_err("modal and buckling analyses have no steps: use run()"));
        }
    };
    let mut stepper = stepper.map_err(|error| failure::of_analysis(&error, None))?;
    stepper.begin(&mut Silent).map_err(|error| failure::of_analysis(&error, None))?;
    Ok(stepper)
}

impl Analysed {
    fn advance(&mut self) -> PyResult<()> {
        let Self { running, before, start, iterations, signals, applied, again_to, warned, .. } = self;
        running.with_dependent_mut(|prepared, stepper| {
            if stepper.is_finished() {
                return Err(PyValueError::new_err("the analysis has come to its end"));
            }
            start.clone_from(stepper.state());
            // Functions may read values that have changed since the last step.
            prepared.system.forget_field_loads();
            match stepper.advance(warned) {
                Ok(number) => *iterations = number,
                Err(error) => {
                    // The step length of the last attempt is forgotten, too.
                    stepper.repeat(start, again_to.unwrap_or(f64::INFINITY));
                    return Err(failure::of_analysis(&error, None));
                }
            }
            std::mem::swap(before, start);
            applied.clear();
            applied.extend(signals.values().map(Signal::value));
            if again_to.take().is_some() {
                stepper.release();
            }
            Ok(())
        })
    }

    /// Goes back to the start of the last step, which ends at the same time when it is taken again, or earlier at an impact.
    fn repeat(&mut self) -> PyResult<()> {
        let Self { running, before, iterations, again_to, .. } = self;
        running.with_dependent_mut(|_, stepper| {
            if before.u.is_empty() {
                return Err(PyValueError::new_err(
                    "there is no step to repeat: advance first, and repeat a step only once before it is taken again",
                ));
            }
            let end = stepper.position();
            stepper.repeat(before, end);
            (*iterations, *again_to) = (0, Some(end));
            *before = State::default();
            Ok(())
        })
    }

    /// Row of the history for the last step, under the signals that acted in it.
    fn row(&mut self) -> PyResult<Vec<f64>> {
        if self.again_to.is_some() {
            return Err(PyValueError::new_err(
                "the last step has been undone, and forces belong to a step: take it again first; positions and velocities are there",
            ));
        }
        let Self { running, rows, before, iterations, signals, applied, .. } = self;
        let present: Vec<f64> = signals.values().map(Signal::value).collect();
        let set =
            |values: &[f64]| signals.values().zip(values).for_each(|(signal, value)| signal.set(*value));
        set(applied);
        let row = running.with_dependent(|prepared, stepper| {
            let step = stepper.reached().step(*iterations);
            rows.row(prepared, before, &step).0
        });
        set(&present);
        Ok(row)
    }

    fn signal(&self, name: &str) -> PyResult<&Signal> {
        let unknown = || {
            let given: Vec<_> = self.signals.keys().map(String::as_str).collect();
            PyKeyError::new_err(format!(
                "\"{name}\" is no signal of this simulation; it has: {}",
                given.join(", ")
            ))
        };
        self.signals.get(name).ok_or_else(unknown)
    }
}

#[pymethods]
impl Steps {
    /// Takes steps; returns the iterations of the last one, and warnings.
    fn advance(&self, py: Python<'_>, steps: usize) -> PyResult<(u32, Vec<String>)> {
        let mut warnings = Vec::new();
        for _ in 0..steps {
            let mut guard = self.lock(py)?;
            let analysed = &mut *guard;
            let outcome = compute(py, &self.pool, || analysed.advance())?;
            let warned = std::mem::take(&mut analysed.warned.messages);
            drop(guard);
            warnings.extend(warned);
            let outcome = self.raised.check().and(outcome);
            // The exception takes the warnings along.
            outcome.inspect_err(|error| {
                for warning in &warnings {
                    let _ = error.value(py).call_method1("add_note", (format!("warning: {warning}"),));
                }
            })?;
            py.check_signals()?;
        }
        Ok((self.lock(py)?.iterations, warnings))
    }

    /// Goes back to the start of the last step.
    fn repeat(&self, py: Python<'_>) -> PyResult<()> {
        let mut guard = self.lock(py)?;
        let analysed = &mut *guard;
        compute(py, &self.pool, || analysed.repeat())?
    }

    /// Sets the value of a signal for the steps to come; a step that another thread takes is waited for.
    fn set_signal(&self, py: Python<'_>, name: &str, value: f64) -> PyResult<()> {
        if !value.is_finite() {
            return Err(PyValueError::new_err(format!("the signal \"{name}\" cannot be {value}")));
        }
        self.lock(py)?.signal(name)?.set(value);
        Ok(())
    }

    /// Present value of a signal.
    fn signal_value(&self, py: Python<'_>, name: &str) -> PyResult<f64> {
        Ok(self.lock(py)?.signal(name)?.value())
    }

    /// Names of the signals.
    fn signals(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        Ok(self.lock(py)?.signals.keys().cloned().collect())
    }

    /// Warnings about the model.
    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    /// The present state.
    fn state(&self, py: Python<'_>) -> PyResult<state::State> {
        let of = |prepared: &Prepared, stepper: &dyn Stepper| {
            state::State::new(stepper.state().clone(), &kind(&prepared.model.analysis), &prepared.system)
        };
        self.read(py, of)
    }

    /// The equations of motion of the model, with the present values of the signals.
    fn equations(&self, py: Python<'_>) -> PyResult<Equations> {
        Ok(Equations::new(self.lock(py)?.running.borrow_owner().clone(), self.raised.clone()))
    }

    /// Names of the columns of a row.
    fn columns(&self) -> Vec<String> {
        self.columns.clone()
    }

    /// Row of the history for the last step.
    fn row<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let mut guard = self.lock(py)?;
        let analysed = &mut *guard;
        let row = compute(py, &self.pool, || analysed.row())?;
        self.raised.check()?;
        Ok(row?.into_pyarray(py))
    }

    /// Time (load factor), and that at which the analysis ends.
    fn time(&self, py: Python<'_>) -> PyResult<(f64, f64)> {
        self.read(py, |_, stepper| (stepper.state().time, stepper.end()))
    }

    /// Whether the analysis has come to its end.
    fn finished(&self, py: Python<'_>) -> PyResult<bool> {
        self.read(py, |_, stepper| stepper.is_finished())
    }

    /// Kinetic, strain and potential energy, work, dissipation and their total.
    fn energies(&self, py: Python<'_>) -> PyResult<[f64; 6]> {
        self.read(py, |_, stepper| {
            let b = stepper.balance();
            [b.kinetic, b.strain, b.potential, b.work, b.dissipated, b.total]
        })
    }

    /// Steps, iterations, factorisations, cut-backs.
    fn statistics(&self, py: Python<'_>) -> PyResult<[u64; 4]> {
        self.read(py, |_, stepper| {
            let s = stepper.reached().statistics;
            [s.steps, s.iterations, s.factorizations, s.cutbacks]
        })
    }

    /// Nodes of a set of the mesh.
    fn nodes_on<'py>(&self, py: Python<'py>, set: &str) -> PyResult<Bound<'py, PyArray1<u32>>> {
        let nodes = self.read(py, |prepared, _| prepared.mesh.nodes_on(set))?;
        let nodes = nodes.ok_or_else(|| PyKeyError::new_err(format!("the mesh has no set \"{set}\"")))?;
        Ok(nodes.into_pyarray(py))
    }

    /// Displacements of the nodes.
    fn displacements<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        rows(py, self.read(py, |prepared, stepper| job::nodal(&prepared.system, &stepper.state().u))?)
    }

    /// Positions of the nodes.
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let of = |prepared: &Prepared, stepper: &dyn Stepper| {
            job::positions(&prepared.mesh, &prepared.system, &stepper.state().u, 1.0)
        };
        rows(py, self.read(py, of)?)
    }

    /// Directors of the nodes.
    fn directors<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        rows(py, self.read(py, |prepared, stepper| job::directors(&prepared.system, stepper.state(), None))?)
    }

    /// Velocities of the nodes; zero in statics.
    fn velocities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        rows(py, self.read(py, |prepared, stepper| job::nodal(&prepared.system, &stepper.state().v))?)
    }

    /// Quadrilaterals of the mesh, by the numbers of their nodes.
    fn quads<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        let quads = self.read(py, |prepared, _| prepared.mesh.quads.clone())?;
        let number = quads.len();
        quads.into_flattened().into_pyarray(py).reshape([number, 4])
    }
}
