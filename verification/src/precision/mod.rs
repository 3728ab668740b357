//! Work–precision studies: cost of the integrators for a given error.
//!
//! A transient is computed with every scheme, with constant steps and with automatic ones of several tolerances. The
//! error is the distance of all nodes from a reference on the same mesh with a much shorter step,
//!
//! ```text
//! e = √(Σ_t Σ_n |x(t, n) − x_ref(t, n)|² / (N_t N_n)) / L,
//! ```
//!
//! with N_t times spread evenly over the motion, N_n nodes and the size L of the model. Between the ends of a step the
//! motion is the cubic of its displacements and velocities; explicit steps are reported by tens, and the cubic spans ten
//! of them. The cost is the processor time of all threads, and a count
//! that does not depend on the machine: iterations, with factorisations at their cost in iterations
//! ([`tegula::analysis::lagged_tangent::cost`]).

mod measure;
mod report;
mod transients;

use tegula::Result;
use tegula::analysis::Statistics;
use tegula::model::{EnergyMomentumScheme, ExplicitScheme, HhtScheme, NewmarkScheme, Scheme};

pub use report::{Cost, csv, markdown, picture};
pub use transients::Transient;

use measure::Bench;

/// How the length of steps is chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stepping {
    /// Constant (time).
    Fixed(f64),
    /// Automatic with a tolerance of the local error over the size of the model.
    Tolerance(f64),
    /// A part of the bound of the critical step of the explicit scheme.
    Critical(f64),
}

/// Schemes that are compared.
pub fn schemes() -> [Scheme; 4] {
    [
        Scheme::Newmark(NewmarkScheme::default()),
        Scheme::Hht(HhtScheme { alpha: -0.05 }),
        Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 }),
        Scheme::Explicit(ExplicitScheme::default()),
    ]
}

/// One run of a transient.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// The motion.
    pub transient: Transient,
    /// Integrator.
    pub scheme: Scheme,
    /// Its steps.
    pub stepping: Stepping,
    /// Counts of the run.
    pub statistics: Statistics,
    /// Iterations, and factorisations at their cost in iterations; steps of the explicit scheme.
    pub work: f64,
    /// Processor time of all threads (s), the least of the repetitions.
    pub seconds: f64,
    /// Error of position as defined in the module; not a number where the analysis failed.
    pub error: f64,
    /// Why it failed; empty if it did not.
    pub failure: String,
}

/// The reference of a transient: the energy-momentum scheme with short steps, extrapolated from those of twice the length
/// with second order.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// The motion.
    pub transient: Transient,
    /// Unknowns of the model.
    pub unknowns: usize,
    /// Cost of a factorisation (iterations).
    pub price: f64,
    /// Step of the reference (time).
    pub step: f64,
    /// Change by the extrapolation: the error of the short steps themselves. That of the reference is smaller.
    pub uncertainty: f64,
}

/// Parameters of a study.
#[derive(Debug, Clone)]
pub struct Study {
    /// Motions.
    pub transients: Vec<Transient>,
    /// Elements along a side; that of the transient where `None`.
    pub elements: Option<u32>,
    /// How often each run is repeated for its processor time.
    pub repetitions: u32,
    /// How many times shorter the steps of the reference are than the shortest constant one.
    pub reference: f64,
    /// Leaves out every other constant step and tolerance.
    pub coarse: bool,
}

impl Study {
    /// Computes all; `progress` gets every row.
    ///
    /// # Errors
    /// A model that cannot be compiled, or a reference that cannot be computed.
    pub fn run(&self, progress: &mut dyn FnMut(&Row)) -> Result<(Vec<Reference>, Vec<Row>)> {
        let (mut references, mut rows) = (Vec::new(), Vec::new());
        for &transient in &self.transients {
            let bench = Bench::new(transient, self.elements, self.reference)?;
            references.push(bench.reference.clone());
            for scheme in schemes() {
                for stepping in transient.steppings(scheme, bench.end, self.coarse) {
                    let row = bench.measure(scheme, stepping, self.repetitions.max(1))?;
                    progress(&row);
                    rows.push(row);
                }
            }
        }
        Ok((references, rows))
    }
}
