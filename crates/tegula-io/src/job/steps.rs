//! Analysis steps of a model, each with results in a folder of its own.

use std::path::Path;

use tegula::compile::{Compiler, StepModel, warnings_at_start};
use tegula::model::Analysis;
use tegula::system::StepStart;

use super::resume::CheckpointData;
use super::run::{claim, completed, run_prepared, start, summary};
use super::{
    BranchResult, JobError, JobObserver, JobOptions, Prepared, ResultFolder, Status, StepSummary, Summary,
    branches,
};
use crate::deck::Deck;
use crate::out::fingerprint;

/// Runs the analysis steps of a model one after another. A run that is resumed leaves complete steps as they are.
pub(super) fn run(
    deck: &Deck,
    prepared: &Prepared,
    options: &JobOptions,
    watch: &mut dyn JobObserver,
) -> Result<Summary, JobError> {
    if let Some(done) = completed(prepared, options) {
        watch.on_warning("the run in this folder is complete: there is nothing to resume, and its results stay as they are");
        return Ok(done);
    }
    let compiler = prepared
        .own
        .compiler(&prepared.model, &prepared.mesh)
        .map_err(|error| model_error(deck, &options.folder, error))?;
    for listed in compiler.steps().iter().enumerate().map(|(i, step)| listed(i, step)) {
        ResultFolder::refuse_foreign(&options.folder.join(listed.folder))?;
    }
    let earlier_warnings = Summary::earlier_warnings(options);
    let mut folder = if options.resume {
        ResultFolder::resume_steps(&options.folder, prepared.fingerprint)?
    } else {
        ResultFolder::start(&options.folder, &claim(deck, prepared, options))?
    };
    let mut whole = Whole::new(deck, prepared, compiler.steps());
    whole.summary.warnings = earlier_warnings;
    for warning in &prepared.warnings {
        whole.warn(&warning.to_string(), (&mut folder, watch))?;
    }
    whole.summary.write(folder.path())?;
    let outcome = whole.run(deck, prepared, compiler, options, (&mut folder, watch));
    whole.conclude(&mut folder, outcome)
}

/// Run of several analyses.
struct Whole {
    summary: Summary,
    /// Summaries of the steps so far.
    parts: Vec<Summary>,
    /// Name of the step begun last.
    present: String,
}

impl Whole {
    fn new(deck: &Deck, prepared: &Prepared, steps: &[StepModel]) -> Self {
        let mut summary = summary(deck, prepared, &start(deck, prepared, None));
        summary.analysis = "steps".into();
        summary.analyses = steps.iter().enumerate().map(|(i, step)| listed(i, step)).collect();
        Self { summary, parts: Vec::new(), present: String::new() }
    }

    /// Runs the steps; an error is that of the step begun last.
    fn run(
        &mut self,
        deck: &Deck,
        prepared: &Prepared,
        mut compiler: Compiler<'_>,
        options: &JobOptions,
        (folder, watch): (&mut ResultFolder, &mut dyn JobObserver),
    ) -> Result<(), JobError> {
        let count = compiler.steps().len();
        let mut ends: Vec<Option<StepStart>> = Vec::new();
        for i in 0..count {
            let step = &compiler.steps()[i].clone();
            let place = options.folder.join(&self.summary.analyses[i].folder);
            let begun = step.starts_from.and_then(|before| ends.get(before).cloned().flatten());
            self.present.clone_from(&step.name);
            let system =
                compiler.system(i, begun).map_err(|error| model_error(deck, &options.folder, error))?;
            let of_step = Prepared {
                model: prepared.model.clone(),
                mesh: prepared.mesh.clone(),
                probes: prepared.probes.clone(),
                warnings: Vec::new(),
                fingerprint: fingerprint(
                    [prepared.fingerprint.to_le_bytes(), (i as u64).to_le_bytes()].concat(),
                ),
                system,
                own: prepared.own.clone(),
            };
            let title = titled(&deck.model.title, &format!("step {} of {count}, {}", i + 1, step.name));
            let model = tegula::Model { title, ..step.model.clone() };
            let of_deck = deck.leading_to(model);
            let own = JobOptions { folder: place.clone(), resume: false, force: true };
            let done = match completed(&of_step, &JobOptions { resume: options.resume, ..own.clone() }) {
                Some(done) if !branches::are_left(&step.model.analysis, &done) => done,
                _ => {
                    self.begin(i, folder)?;
                    for warning in
                        step.starts_from.map(|_| warnings_at_start(step, &of_step.system)).unwrap_or_default()
                    {
                        self.warn(&warning.to_string(), (folder, watch))?;
                    }
                    let resume = options.resume && resumable(&step.model.analysis, &place);
                    let outcome = run_prepared(&of_deck, &of_step, &JobOptions { resume, ..own }, watch);
                    if let Ok(left) = Summary::read(&place) {
                        self.take(i, &left);
                    }
                    outcome?
                }
            };
            self.take(i, &done);
            let end = end_of(&step.model.analysis, &place, &of_step)?;
            if let Some((_, time)) = end {
                compiler.end_step(i, time);
            }
            ends.push(end.map(|(end, _)| end));
        }
        Ok(())
    }

    fn warn(
        &mut self,
        message: &str,
        (folder, watch): (&mut ResultFolder, &mut dyn JobObserver),
    ) -> Result<(), JobError> {
        watch.on_warning(message);
        self.summary.add_warning(message);
        Ok(folder.log(&format!("warning: {message}"))?)
    }

    fn begin(&mut self, step: usize, folder: &mut ResultFolder) -> Result<(), JobError> {
        self.summary.analyses[step].status = Some(Status::Running);
        let name = &self.summary.analyses[step].name;
        folder.log(&format!("step {}, {name}, begins", step + 1))?;
        Ok(self.summary.write(folder.path())?)
    }

    /// Makes the results of a step those of the whole; counts and costs of all steps are added.
    fn take(&mut self, step: usize, of_step: &Summary) {
        self.parts.truncate(step);
        self.parts.push(of_step.clone());
        let parts = || self.parts.iter();
        let before = &self.summary;
        let mut summary = Summary {
            // The whole is complete when its last step is.
            status: Status::Running,
            error: None,
            analysis: before.analysis.clone(),
            title: before.title.clone(),
            fingerprint: before.fingerprint.clone(),
            analyses: before.analyses.clone(),
            warnings: before.warnings.clone(),
            assembly: before.assembly.clone().or_else(|| of_step.assembly.clone()),
            steps: parts().map(|p| p.steps).sum(),
            iterations: parts().map(|p| p.iterations).sum(),
            factorizations: parts().map(|p| p.factorizations).sum(),
            cutbacks: parts().map(|p| p.cutbacks).sum(),
            wall_s: parts().map(|p| p.wall_s).sum(),
            cpu_s: parts().map(|p| p.cpu_s).sum(),
            branches: of_step
                .branches
                .iter()
                .map(|branch| within(&before.analyses[step].folder, branch))
                .collect(),
            ..of_step.clone()
        };
        for message in &of_step.warnings {
            summary.add_warning(message);
        }
        summary.analyses[step].status = Some(of_step.status);
        summary.analyses[step].stop.clone_from(&of_step.stop);
        self.summary = summary;
    }

    fn conclude(
        mut self,
        folder: &mut ResultFolder,
        outcome: Result<(), JobError>,
    ) -> Result<Summary, JobError> {
        let place = folder.path().to_owned();
        let (status, message, outcome) = match outcome {
            Ok(()) => (Status::Complete, None, Ok(())),
            Err(JobError::Interrupted { .. }) => {
                (Status::Interrupted, None, Err(JobError::Interrupted { folder: place, resumable: true }))
            }
            Err(JobError::Analysis { error, .. }) => (
                Status::Failed,
                Some(format!("step \"{}\": {error}", self.present)),
                Err(JobError::Analysis { error, folder: place }),
            ),
            Err(error) => (Status::Failed, Some(format!("step \"{}\": {error}", self.present)), Err(error)),
        };
        (self.summary.status, self.summary.error) = (status, message);
        folder.log(&match &self.summary.error {
            None => format!("{status:?}"),
            Some(error) => format!("{status:?}: {error}"),
        })?;
        self.summary.write(folder.path())?;
        outcome.map(|()| self.summary)
    }
}

/// Branch of a step, in the folder of the whole.
fn within(step: &str, branch: &BranchResult) -> BranchResult {
    BranchResult { folder: format!("{step}/{}", branch.folder), ..branch.clone() }
}

fn listed(number: usize, step: &StepModel) -> StepSummary {
    let analysis = match step.model.analysis {
        Analysis::Static(_) => "static",
        Analysis::Path(_) => "path",
        Analysis::Modal(_) => "modal",
        Analysis::Buckling(_) => "buckling",
        Analysis::Transient(_) => "transient",
    };
    StepSummary {
        name: step.name.clone(),
        folder: format!("{}-{}", number + 1, step.name.replace([' ', '.'], "_")),
        analysis: analysis.into(),
        status: None,
        stop: None,
    }
}

fn titled(title: &str, step: &str) -> String {
    if title.is_empty() { step.to_owned() } else { format!("{title}: {step}") }
}

/// Whether a step has a checkpoint to restart from.
fn resumable(analysis: &Analysis, place: &Path) -> bool {
    !matches!(analysis, Analysis::Modal(_) | Analysis::Buckling(_))
        && place.join("checkpoint.bin").exists()
        && Summary::read(place).is_ok()
}

/// State at which a step has ended, from its checkpoint, and its time or load factor; `None` where it has none, as modes.
fn end_of(analysis: &Analysis, place: &Path, step: &Prepared) -> Result<Option<(StepStart, f64)>, JobError> {
    if matches!(analysis, Analysis::Modal(_) | Analysis::Buckling(_)) {
        return Ok(None);
    }
    let data = CheckpointData::load(&place.join("checkpoint.bin"), step.fingerprint, &step.system)?;
    Ok(Some((data.state.end_of_step(), data.state.time)))
}

fn model_error(deck: &Deck, folder: &Path, error: tegula::Error) -> JobError {
    match error {
        tegula::Error::Model(issues) => JobError::Model(deck.locate(&issues)),
        error => JobError::Analysis { error, folder: folder.to_owned() },
    }
}
