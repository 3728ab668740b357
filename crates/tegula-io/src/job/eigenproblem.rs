//! Analyses that find modes: one solve, no history, nothing to resume.

use std::time::Instant;

use tegula::Error;
use tegula::analysis::{Observer, Statistics, Step};

use super::run::{claim, start, summary};
use super::{
    JobError, JobObserver, JobOptions, Prepared, Progress, ResultFolder, Start, Status, Summary, process,
};
use crate::deck::Deck;
use crate::out::OutputError;

/// Finds the modes by `solve`, and writes them by `record`, which gets the run counters of what went before.
pub(super) fn run<T>(
    (deck, prepared, options): (&Deck, &Prepared, &JobOptions),
    watch: &mut dyn JobObserver,
    solve: impl FnOnce(&mut Forward<'_>) -> tegula::Result<T>,
    record: impl FnOnce(&mut ResultFolder, &mut Summary, &Statistics, T) -> Result<(), OutputError>,
) -> Result<Summary, JobError> {
    if options.resume {
        return Err(JobError::Folder {
            folder: options.folder.clone(),
            reason: "a modal or buckling analysis is one solve and cannot be resumed. Run without `--resume`"
                .into(),
        });
    }
    let (clock, cpu) = (Instant::now(), process::cpu_seconds());
    let mut folder = ResultFolder::start(&options.folder, &claim(deck, prepared, options))?;
    let start = start(deck, prepared, None);
    watch.on_start(&start);
    watch.on_model(prepared, &[]);
    let mut summary = summary(deck, prepared, &start);
    summary.write(folder.path())?;
    let mut forward = Forward {
        folder: &mut folder,
        watch,
        failed: None,
        before: Statistics::default(),
        warnings: Vec::new(),
    };
    forward.log(&opening(&summary, &start));
    for message in prepared.system.closed_gaps.iter().flat_map(|gaps| gaps.messages()) {
        forward.on_event(&message);
    }
    for warning in &prepared.warnings {
        forward.on_warning(&warning.to_string());
    }
    let outcome = solve(&mut forward);
    let (before, mut failed) = (forward.before, forward.failed);
    for message in &forward.warnings {
        summary.add_warning(message);
    }
    let result = match outcome {
        Ok(found) => {
            (summary.status, summary.time) = (Status::Complete, start.end);
            let recorded = record(&mut folder, &mut summary, &before, found);
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
        "tegula {}: {} analysis of {} elements, {} unknowns, started",
        summary.version, start.analysis, start.elements, start.unknowns
    )
}

/// Forwards events to the log and to the job's observer.
pub(super) struct Forward<'a> {
    folder: &'a mut ResultFolder,
    watch: &'a mut dyn JobObserver,
    failed: Option<OutputError>,
    /// Counts of the equilibrium about which the modes are.
    pub before: Statistics,
    warnings: Vec<String>,
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

    fn on_modes(&mut self, found: usize, wanted: usize, vectors: usize) {
        self.watch.on_modes(found, wanted, vectors);
    }

    fn on_repeat(&mut self, statistics: &Statistics) {
        self.before = *statistics;
    }

    fn on_event(&mut self, message: &str) {
        self.log(message);
        self.watch.on_event(message);
    }

    fn on_warning(&mut self, message: &str) {
        self.log(&format!("warning: {message}"));
        self.warnings.push(message.into());
        self.watch.on_warning(message);
    }

    fn interrupted(&self) -> bool {
        self.watch.interrupted()
    }
}
