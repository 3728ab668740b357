//! Error and cost of one run.

use tegula::analysis::{Observer, Silent, Statistics, Step, dynamics};
use tegula::analysis::{direct::Direct, solver::TangentSolver as _};
use tegula::model::{Analysis, EnergyMomentumScheme, Model, Scheme, TransientAnalysis};
use tegula::{Error, Result, System, Vec3};

use super::{Reference, Row, Stepping, Transient};
use crate::verify::history::cubic;
use crate::verify::model::Compiled;
use tegula_io::job::process::cpu_seconds;

/// Times at which positions are compared; the last one is the end.
const TIMES: usize = 100;
/// Scheme of the reference: it stays stable where rotations are large.
const REFERENCE: Scheme = Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 });

/// A transient, compiled for its schemes, with its reference.
pub(super) struct Bench {
    transient: Transient,
    implicit: System,
    explicit: System,
    pub(super) reference: Reference,
    /// End of the motion (s).
    pub(super) end: f64,
    positions: Vec<Vec3>,
}

impl Bench {
    /// Compiles a transient and computes its reference with steps `finer` times as short as the shortest constant ones.
    pub(super) fn new(transient: Transient, side: Option<u32>, finer: f64) -> Result<Self> {
        let (model, end) = transient.model(side)?;
        let step = transient.shortest(end) / finer;
        let options =
            TransientAnalysis { time_step: Some(step), scheme: REFERENCE, ..TransientAnalysis::new(end) };
        let compile = |options: &TransientAnalysis| {
            let analysis = Analysis::Transient(options.clone());
            Ok::<_, Error>(Compiled::new(&Model { analysis, ..model.clone() })?.system)
        };
        let implicit = compile(&options)?;
        let explicit =
            compile(&TransientAnalysis { scheme: Scheme::Explicit(Default::default()), ..options.clone() })?;
        let price = Direct::new(&implicit)?.price([implicit.unknowns(), implicit.constraints()]);
        let mut positions = Course::of(&implicit, &options)?.0.positions;
        let twice = TransientAnalysis { time_step: Some(2.0 * step), ..options };
        let twice = Course::of(&implicit, &twice)?.0.positions;
        let uncertainty = distance(&twice, &positions) / (3.0 * implicit.length);
        // A scheme of second order: twice the step makes four times the error.
        positions.iter_mut().zip(&twice).for_each(|(x, x_2h)| *x += (*x - x_2h) / 3.0);
        let reference = Reference { transient, unknowns: implicit.unknowns(), price, step, uncertainty };
        Ok(Self { transient, implicit, explicit, reference, end, positions })
    }

    /// Runs a scheme `repetitions` times.
    ///
    /// # Errors
    /// The critical step cannot be found. A run that fails is a row that says so.
    pub(super) fn measure(&self, scheme: Scheme, stepping: Stepping, repetitions: u32) -> Result<Row> {
        let explicit = matches!(scheme, Scheme::Explicit(_));
        let system = if explicit { &self.explicit } else { &self.implicit };
        let mut options = TransientAnalysis { scheme, ..TransientAnalysis::new(self.end) };
        match stepping {
            Stepping::Fixed(step) => options.time_step = Some(step),
            Stepping::Tolerance(tolerance) => options.tolerance = tolerance,
            Stepping::Critical(part) => {
                let end_time = 1e-9 * options.end_time;
                let first = TransientAnalysis { end_time, ..options.clone() };
                let critical = dynamics::run(system, &first, None, &mut Silent)?.statistics.critical_step;
                options.max_step = Some(part * critical);
            }
        }
        let mut row = Row {
            transient: self.transient,
            scheme,
            stepping,
            statistics: Statistics::default(),
            work: f64::NAN,
            seconds: f64::INFINITY,
            error: f64::NAN,
            failure: String::new(),
        };
        for _ in 0..repetitions {
            let begin = cpu_seconds();
            let (course, statistics) = match Course::of(system, &options) {
                Ok(done) => done,
                Err(e) => {
                    row.failure = e.to_string();
                    return Ok(row);
                }
            };
            let spent = cpu_seconds().zip(begin).map(|(now, then)| now - then);
            row.seconds = spent.map_or(f64::NAN, |spent| row.seconds.min(spent));
            row.error = distance(&course.positions, &self.positions) / system.length;
            row.statistics = statistics;
        }
        let s = &row.statistics;
        row.work = if explicit {
            s.steps as f64
        } else {
            s.iterations as f64 + self.reference.price * s.factorizations as f64
        };
        Ok(row)
    }
}

/// Root mean square distance of positions (length).
fn distance(a: &[Vec3], b: &[Vec3]) -> f64 {
    if a.len() != b.len() {
        return f64::NAN;
    }
    let sum: f64 = a.iter().zip(b).map(|(a, b)| (a - b).norm_squared()).sum();
    (sum / a.len().max(1) as f64).sqrt()
}

/// Displacements of all nodes at even times, cubic between reports.
struct Course {
    /// Nodal vectors of the positions.
    vectors: Vec<usize>,
    end: f64,
    last: (f64, Vec<Vec3>, Vec<Vec3>),
    positions: Vec<Vec3>,
}

impl Course {
    /// Runs an analysis and watches it.
    fn of(system: &System, options: &TransientAnalysis) -> Result<(Self, Statistics)> {
        let vectors =
            system.coordinates.position_of.iter().filter(|&&v| v != u32::MAX).map(|&v| v as usize).collect();
        let nothing = (0.0, Vec::new(), Vec::new());
        let mut course = Self { vectors, end: options.end_time, last: nothing, positions: Vec::new() };
        let outcome = dynamics::run(system, options, None, &mut course)?;
        Ok((course, outcome.statistics))
    }
}

impl Observer for Course {
    fn on_step(&mut self, step: &Step) -> Result<()> {
        let state = step.state;
        let pick = |field: &[[f64; 3]]| self.vectors.iter().map(|&v| Vec3::from(field[v])).collect();
        let new: (f64, Vec<Vec3>, Vec<Vec3>) = (state.time, pick(&state.u), pick(&state.v));
        let nodes = self.vectors.len();
        while !self.last.1.is_empty() && self.positions.len() < TIMES * nodes {
            let sample = self.positions.len() / nodes + 1;
            let time = self.end * sample as f64 / TIMES as f64;
            if time > new.0 * (1.0 + 1e-12) {
                break;
            }
            let (old, h) = (&self.last, new.0 - self.last.0);
            let s = ((time - old.0) / h).min(1.0);
            self.positions
                .extend((0..nodes).map(|n| cubic(h, s, (old.1[n], old.2[n]), (new.1[n], new.2[n]))));
        }
        self.last = new;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    #[ignore = "long"]
    fn the_error_of_a_constant_step_is_of_second_order_and_its_work_is_counted() {
        let bench = Bench::new(Transient::Tumbling, Some(5), 2.0).unwrap();
        assert!(bench.reference.uncertainty < 1e-4, "{:?}", bench.reference);
        let run = |scheme, n: f64| bench.measure(scheme, Stepping::Fixed(1.0 / n), 1).unwrap();
        for scheme in &super::super::schemes()[..3] {
            let (coarse, fine) = (run(*scheme, 100.0), run(*scheme, 200.0));
            assert!((3.4..4.6).contains(&(coarse.error / fine.error)), "{coarse:?} {fine:?}");
            let counted = fine.statistics.iterations as f64;
            assert!(fine.work > counted && fine.seconds > 0.0 && fine.failure.is_empty());
        }
        let explicit = bench.measure(super::super::schemes()[3], Stepping::Critical(0.9), 1).unwrap();
        assert!(explicit.error < 0.05 && explicit.work == explicit.statistics.steps as f64, "{explicit:?}");
    }
}
