//! Natural frequencies: one solve, no history, nothing to resume.

use std::time::Instant;

use tegula::Error;
use tegula::analysis::modal::{self, ModalOutcome, Response};
use tegula::analysis::{Observer, State, Statistics, Step};
use tegula::model::ModalAnalysis;

use super::campbell::{self, Campbell};
use super::run::{claim, start, summary};
use super::{
    JobError, JobObserver, JobOptions, Prepared, Progress, ResultFolder, Start, Status, Summary, process,
};
use super::{modes, response};
use crate::deck::Deck;
use crate::out::OutputError;

/// Runs a modal analysis.
pub(super) fn run(
    deck: &Deck,
    analysis: &ModalAnalysis,
    prepared: &Prepared,
    options: &JobOptions,
    watch: &mut dyn JobObserver,
) -> Result<Summary, JobError> {
    if options.resume {
        return Err(JobError::Folder {
            folder: options.folder.clone(),
            reason: "a modal analysis is one solve and cannot be resumed. Run without `--resume`".into(),
        });
    }
    let (clock, cpu) = (Instant::now(), process::cpu_seconds());
    let mut folder = ResultFolder::start(&options.folder, &claim(deck, prepared, options))?;
    let start = start(deck, prepared, None);
    watch.on_start(&start);
    let mut summary = summary(deck, prepared, &start);
    summary.write(folder.path())?;
    let mut forward = Forward { folder: &mut folder, watch, failed: None, before: Statistics::default() };
    forward.log(&opening(&summary, &start));
    for message in prepared.system.closed_gaps.iter().flat_map(|gaps| gaps.messages()) {
        forward.on_event(&message);
    }
    for warning in &prepared.warnings {
        forward.log(&format!("warning: {warning}"));
        forward.watch.on_warning(&warning.to_string());
    }
    let outcome = spectrum(analysis, prepared, &mut forward);
    let (before, mut failed) = (forward.before, forward.failed);
    let result = match outcome {
        Ok(found) => {
            (summary.status, summary.time) = (Status::Complete, start.end);
            let recorded = record(deck, prepared, &mut folder, &mut summary, &before, &found);
            failed = failed.or(recorded.err());
            Ok(())
        }
        Err(Error::Interrupted) => {
            summary.status = Status::Interrupted;
            Err(JobError::Interrupted { folder: options.folder.clone(), resumable: false })
        }
        Err(error) => {
            (summary.status, summary.error) = (Status::Failed, Some(error.to_string()));
            (summary.steps, summary.iterations) = (before.steps, before.iterations);
            (summary.factorizations, summary.cutbacks) = (before.factorizations, before.cutbacks);
            Err(JobError::Analysis { error, folder: options.folder.clone() })
        }
    };
    summary.wall_s = clock.elapsed().as_secs_f64();
    summary.cpu_s = process::cpu_seconds().zip(cpu).map(|(now, then)| now - then);
    summary.peak_memory_bytes = process::peak_memory_bytes();
    if let Some(error) = failed.or_else(|| summary.write(folder.path()).err()) {
        summary.write_failure(folder.path(), &error);
        return Err(error.into());
    }
    result.map(|()| summary)
}

fn opening(summary: &Summary, start: &Start) -> String {
    format!(
        "tegula {}: modal analysis of {} elements, {} unknowns, started",
        summary.version, start.elements, start.unknowns
    )
}

/// The modes, and the state about which they are: the equilibrium under the loads where that is wanted.
fn spectrum(
    analysis: &ModalAnalysis,
    prepared: &Prepared,
    forward: &mut Forward<'_>,
) -> tegula::Result<Found> {
    if let (campbell, Some((about, outcome))) = campbell::run(prepared, analysis, forward)? {
        return Ok(Found { about, outcome, response: None, campbell: Some(campbell) });
    }
    let system = &prepared.system;
    let mut equilibrium: Option<State> = None;
    if analysis.prestressed {
        let outcome = modal::prestress(system, forward)?;
        forward.before = outcome.statistics;
        equilibrium = Some(outcome.state);
    }
    if system.continues() {
        // The step before was static: its loads act as at its end.
        equilibrium = Some(State { time: 1.0, ..State::first(system) });
    }
    let (outcome, response) = modal::run_with_inputs(system, analysis, equilibrium.as_ref(), forward)?;
    let about = equilibrium.unwrap_or_else(|| State::unloaded(system));
    Ok(Found { about, outcome, response, campbell: None })
}

/// Result of a modal analysis.
struct Found {
    /// State about which the model vibrates.
    about: State,
    outcome: ModalOutcome,
    response: Option<Response>,
    campbell: Option<Campbell>,
}

/// Writes what was found.
fn record(
    deck: &Deck,
    prepared: &Prepared,
    folder: &mut ResultFolder,
    summary: &mut Summary,
    before: &Statistics,
    Found { about, outcome, response, campbell }: &Found,
) -> Result<(), OutputError> {
    let rows = outcome.modes.as_slice();
    modes::write(folder, prepared, &deck.model.output, about, rows)?;
    let unit = deck.model.output.units.of_frequency();
    let drawn = || modes::picture(folder, prepared, &deck.model.title, unit.as_deref(), rows);
    if deck.model.output.pictures
        && let Err(problem) = drawn()
    {
        folder.log(&format!("a picture is missing: {problem}"))?;
    }
    if let Some(campbell) = campbell {
        campbell::write(folder, campbell)?;
        let drawn = || campbell::picture(folder, campbell, (&deck.model.title, unit.as_deref()));
        if deck.model.output.pictures
            && let Err(problem) = drawn()
        {
            folder.log(&format!("a picture is missing: {problem}"))?;
        }
    }
    summary.frequencies_hz = Some(rows.iter().map(|m| m.frequency_hz).collect());
    summary.sturm_checked = Some(outcome.sturm_checked);
    let s = &outcome.statistics;
    summary.steps = before.steps;
    summary.iterations = before.iterations + s.iterations;
    summary.factorizations = before.factorizations + s.factorizations;
    summary.cutbacks = before.cutbacks;
    let mut end = format!("Complete: {} modes", rows.len());
    if let Some(response) = response {
        if let Some(problem) = response::write(folder, prepared, &deck.model, (about, response))? {
            folder.log(&problem)?;
        }
        let (n, reduced) = (response.frequencies.len(), &response.reduced);
        let residual = reduced.lambdas.len() - reduced.modes;
        end += &format!(", {residual} residual vectors, response at {n} frequencies");
    }
    folder.log(&end)
}

/// Forwards events to the log and to the job's observer.
struct Forward<'a> {
    folder: &'a mut ResultFolder,
    watch: &'a mut dyn JobObserver,
    failed: Option<OutputError>,
    /// Counts of the equilibrium about which the model vibrates.
    before: Statistics,
}

impl Forward<'_> {
    fn log(&mut self, line: &str) {
        if let Err(error) = self.folder.log(line) {
            self.failed.get_or_insert(error);
        }
    }
}

impl Observer for Forward<'_> {
    fn on_step(&mut self, step: &Step) -> tegula::Result<()> {
        self.watch.on_step(&Progress {
            step: step.state.step,
            time: step.state.time,
            step_size: step.state.last_step,
            iterations: step.iterations,
            end: step.end,
        });
        Ok(())
    }

    fn on_repeat(&mut self, statistics: &Statistics) {
        self.before = *statistics;
    }

    fn on_event(&mut self, message: &str) {
        self.log(message);
        self.watch.on_event(message);
    }

    fn interrupted(&self) -> bool {
        self.watch.interrupted()
    }
}
