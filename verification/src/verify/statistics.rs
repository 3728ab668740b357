//! Run counters of the cases: steps, iterations, factorisations and cut-backs of every analysis.
//!
//! The cases run their analyses through the functions of this module, which note the run counters; [`take`] returns those
//! noted by the present thread. `verification/statistics.txt` keeps them.

use std::cell::RefCell;
use std::fmt::Write as _;

use tegula::analysis::dynamics::{self, TransientOutcome};
use tegula::analysis::modal::{self, ModalOutcome};
use tegula::analysis::path::{self, PathOutcome};
use tegula::analysis::statics::{self, StaticOutcome};
use tegula::analysis::{Observer, State, Statistics, Step};
use tegula::model::{PathAnalysis, StaticAnalysis, TransientAnalysis};
use tegula::{Result, System};

/// Run counters of one analysis of a case.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Counters {
    /// `static`, `path`, `modal`, `transient`, or `run`: all analyses of a model file.
    pub analysis: &'static str,
    /// Unknowns of the model.
    pub unknowns: usize,
    /// Finished steps; modes of a modal analysis.
    pub steps: u64,
    /// Iterations, including those of repeated steps.
    pub iterations: u64,
    /// Numerical factorisations.
    pub factorizations: u64,
    /// Cut-backs: steps repeated with a smaller length.
    pub cutbacks: u64,
}

thread_local! {
    static NOTED: RefCell<Vec<Counters>> = const { RefCell::new(Vec::new()) };
}

/// Notes the counters of an analysis.
pub fn note(counters: Counters) {
    NOTED.with_borrow_mut(|noted| noted.push(counters));
}

/// Counters noted since the last call.
pub fn take() -> Vec<Counters> {
    NOTED.take()
}

fn note_statistics(analysis: &'static str, system: &System, s: &Statistics) {
    note(Counters {
        analysis,
        unknowns: system.unknowns(),
        steps: s.steps,
        iterations: s.iterations,
        factorizations: s.factorizations,
        cutbacks: s.cutbacks,
    });
}

/// Observer that keeps the latest counters, for analyses that end in an error.
struct Latest<'a> {
    inner: &'a mut dyn Observer,
    statistics: Statistics,
}

impl Observer for Latest<'_> {
    fn on_step(&mut self, step: &Step) -> Result<()> {
        self.statistics = *step.statistics;
        self.inner.on_step(step)
    }

    fn on_iteration(&mut self, iteration: u32, energy: f64, increment: f64) {
        self.inner.on_iteration(iteration, energy, increment);
    }

    fn on_repeat(&mut self, statistics: &Statistics) {
        self.statistics = *statistics;
        self.inner.on_repeat(statistics);
    }

    fn on_event(&mut self, message: &str) {
        self.inner.on_event(message);
    }

    fn on_warning(&mut self, message: &str) {
        self.inner.on_warning(message);
    }

    fn column(&mut self, name: &str, step: &Step) -> Option<f64> {
        self.inner.column(name, step)
    }

    fn interrupted(&self) -> bool {
        self.inner.interrupted()
    }
}

/// [`statics::run`], counted.
pub fn run_static(
    system: &System,
    options: &StaticAnalysis,
    start: Option<State>,
    observer: &mut dyn Observer,
) -> Result<StaticOutcome> {
    let mut latest = Latest { inner: observer, statistics: Statistics::default() };
    let outcome = statics::run(system, options, start, &mut latest);
    note_statistics("static", system, outcome.as_ref().map_or(&latest.statistics, |o| &o.statistics));
    outcome
}

/// [`path::run`] from the first state, counted.
pub fn run_path(system: &System, options: &PathAnalysis, observer: &mut dyn Observer) -> Result<PathOutcome> {
    let mut latest = Latest { inner: observer, statistics: Statistics::default() };
    let outcome = path::run(system, options, None, &mut latest);
    note_statistics("path", system, outcome.as_ref().map_or(&latest.statistics, |o| &o.statistics));
    outcome
}

/// [`dynamics::run`] from the first state, counted.
pub fn run_transient(
    system: &System,
    options: &TransientAnalysis,
    observer: &mut dyn Observer,
) -> Result<TransientOutcome> {
    let mut latest = Latest { inner: observer, statistics: Statistics::default() };
    let outcome = dynamics::run(system, options, None, &mut latest);
    note_statistics("transient", system, outcome.as_ref().map_or(&latest.statistics, |o| &o.statistics));
    outcome
}

/// [`modal::run`] about the reference configuration, counted.
pub fn run_modal(system: &System, modes: usize, observer: &mut dyn Observer) -> Result<ModalOutcome> {
    let outcome = modal::run(system, modes, None, observer)?;
    note_statistics("modal", system, &outcome.statistics);
    Ok(outcome)
}

/// Text table of the counters of all cases, in the order of the analyses. Successive analyses of a case with the same
/// counters share a line: `models` counts them, `unknowns` is their sum.
pub fn table(cases: &[(&str, Vec<Counters>)]) -> String {
    let mut out = String::new();
    let mut line = |case: &str, models: &str, analysis: &str, unknowns: &str, counts: [&str; 4]| {
        let [steps, iterations, factorizations, cutbacks] = counts;
        let _ = writeln!(
            out,
            "{case:<26} {models:>6} {analysis:<9} {unknowns:>9} {steps:>6} {iterations:>10} {factorizations:>14} {cutbacks:>8}"
        );
    };
    let heads = ["steps", "iterations", "factorizations", "cutbacks"];
    line("case", "models", "analysis", "unknowns", heads);
    for (case, all) in cases {
        let same = |a: &Counters, b: &Counters| Counters { unknowns: b.unknowns, ..*a } == *b;
        for group in all.chunk_by(same) {
            let c = group[0];
            let unknowns: usize = group.iter().map(|c| c.unknowns).sum();
            let counts = [c.steps, c.iterations, c.factorizations, c.cutbacks].map(|n| n.to_string());
            let [steps, iterations, factorizations, cutbacks] = &counts;
            line(
                case,
                &group.len().to_string(),
                c.analysis,
                &unknowns.to_string(),
                [steps, iterations, factorizations, cutbacks],
            );
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn successive_analyses_with_equal_counters_share_a_line() {
        let of = |unknowns, iterations| Counters {
            analysis: "static",
            unknowns,
            steps: 1,
            iterations,
            factorizations: 1,
            cutbacks: 0,
        };
        let text = table(&[("plate", vec![of(10, 1), of(20, 1), of(20, 2)]), ("patch", vec![of(20, 2)])]);
        let rows: Vec<Vec<&str>> = text.lines().skip(1).map(|l| l.split_whitespace().collect()).collect();
        let expected =
            ["plate 2 static 30 1 1 1 0", "plate 1 static 20 1 2 1 0", "patch 1 static 20 1 2 1 0"];
        assert_eq!(rows, expected.map(|l| l.split(' ').collect::<Vec<_>>()));
    }
}
