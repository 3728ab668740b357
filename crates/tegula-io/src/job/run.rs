//! Run of one model: from the model file to the summary.

use std::sync::Arc;

use tegula::analysis::{Observer, State, Stopped, dynamics, path, statics};
use tegula::model::Analysis;
use tegula::{Error, System};

use super::recorder::Recorder;
use super::resume::CheckpointData;
use super::summary::StopResult;
use super::{
    AssemblyResult, Claim, Energy, JobError, JobObserver, JobOptions, OwnParts, Prepared, ResultFolder,
    Start, Status, Summary, branches, buckling, modal, pictures, prepare_with, steps,
};
use crate::deck::{Deck, Diagnostic};
use crate::out::OutputError;

/// Runs a model file and leaves the results in a folder.
///
/// # Errors
/// The model is wrong, the folder cannot be used, the analysis failed or was interrupted. In the last
/// two cases the folder holds everything up to the last finished step.
pub fn run(deck: &Deck, options: &JobOptions, watch: &mut dyn JobObserver) -> Result<Summary, JobError> {
    run_with(deck, Arc::default(), options, watch)
}

/// [`run`] with loads and material laws of the caller. A run is resumed with the parts of the same names, which are to be the same.
///
/// # Errors
/// As [`run`].
pub fn run_with(
    deck: &Deck,
    own: Arc<OwnParts>,
    options: &JobOptions,
    watch: &mut dyn JobObserver,
) -> Result<Summary, JobError> {
    if options.resume {
        ResultFolder::refuse_branch(&options.folder)?;
    }
    let prepared = prepare_with(deck, own)?;
    if deck.model.steps.is_empty() {
        run_prepared(deck, &prepared, options, watch)
    } else {
        steps::run(deck, &prepared, options, watch)
    }
}

/// Runs the one analysis of a model that is prepared, and the branches of a path.
pub(super) fn run_prepared(
    deck: &Deck,
    prepared: &Prepared,
    options: &JobOptions,
    watch: &mut dyn JobObserver,
) -> Result<Summary, JobError> {
    let done = run_one(deck, (prepared, &prepared.warnings), options, watch)?;
    match &deck.model.analysis {
        Analysis::Path(path) if path.branches.is_some() => {
            branches::run((deck, path), prepared, options, (done, watch))
        }
        _ => Ok(done),
    }
}

/// Runs the one analysis of a model that is prepared, with warnings of its model.
pub(super) fn run_one(
    deck: &Deck,
    (prepared, warnings): (&Prepared, &[Diagnostic]),
    options: &JobOptions,
    watch: &mut dyn JobObserver,
) -> Result<Summary, JobError> {
    match &deck.model.analysis {
        Analysis::Modal(analysis) => return modal::run(deck, analysis, prepared, options, watch),
        Analysis::Buckling(analysis) => return buckling::run(deck, analysis, prepared, options, watch),
        Analysis::Static(_) | Analysis::Path(_) | Analysis::Transient(_) => {}
    }
    if let Some(done) = completed(prepared, options) {
        if !branches::are_left(&deck.model.analysis, &done) {
            watch.on_warning(
                "the run in this folder is complete: there is nothing to resume, and its results stay as they are",
            );
        }
        return Ok(done);
    }
    let earlier_warnings = Summary::earlier_warnings(options);
    let folder = if options.resume {
        ResultFolder::resume(&options.folder)?
    } else {
        ResultFolder::start(&options.folder, &claim(deck, prepared, options))?
    };
    let memory = if options.resume {
        let path = folder.file("checkpoint.bin");
        Some(CheckpointData::load(&path, prepared.fingerprint, &prepared.system)?)
    } else {
        None
    };
    let start = start(deck, prepared, memory.as_ref());
    watch.on_start(&start);
    let summary = Summary { warnings: earlier_warnings, ..summary(deck, prepared, &start) };
    let (mut opening, place) = (summary.clone(), folder.path().to_owned());
    let opened =
        Recorder::new(&deck.model, prepared, folder, summary, memory, watch).and_then(|mut recorder| {
            recorder.announce(&start)?;
            if let Some(gaps) = prepared.system.closed_gaps.as_ref().filter(|_| !options.resume) {
                gaps.messages().iter().for_each(|message| recorder.on_event(message));
            }
            recorder.warn(warnings)?;
            Ok(recorder)
        });
    let mut recorder = opened.inspect_err(|error| opening.write_failure(&place, error))?;
    let state = (!recorder.memory.state.u.is_empty()).then(|| recorder.memory.state.clone());
    let outcome = analyse(deck, &prepared.system, state, &start, &mut recorder);
    let outcome = outcome.map(|stopped| recorder.summary.stop = stopped.map(StopResult::from));
    conclude(recorder, outcome)
}

/// The summary of a run of this model that has reached its end, where it is to be resumed.
pub(super) fn completed(prepared: &Prepared, options: &JobOptions) -> Option<Summary> {
    let summary = options.resume.then(|| Summary::read(&options.folder).ok())??;
    let same = summary.fingerprint == format!("{:016x}", prepared.fingerprint);
    (same && summary.status == Status::Complete).then_some(summary)
}

/// Identity of a run, with which it claims a result folder.
pub(super) fn claim<'a>(deck: &'a Deck, prepared: &Prepared, options: &JobOptions) -> Claim<'a> {
    Claim { model: &deck.path, fingerprint: prepared.fingerprint, force: options.force }
}

/// The analysis itself.
fn analyse(
    deck: &Deck,
    system: &System,
    state: Option<State>,
    start: &Start,
    recorder: &mut Recorder<'_>,
) -> tegula::Result<Option<Stopped>> {
    let first = match &deck.model.analysis {
        Analysis::Static(options) => Some(statics::first_state(system, options)),
        Analysis::Path(_) => Some(path::first_state(system)),
        Analysis::Transient(_) | Analysis::Modal(_) | Analysis::Buckling(_) => None,
    };
    if let Some(mut first) = first.filter(|_| state.is_none()) {
        if first.path.is_some() {
            first.negative_pivots = path::ArcLengthSteps::negative_eigenvalues(system, &first)?;
        }
        recorder.record_start(&first, &statics::first_energies(system, &first), start.end)?;
    }
    match &deck.model.analysis {
        Analysis::Static(options) => Ok(statics::run(system, options, state, recorder)?.stopped),
        Analysis::Path(options) => Ok(path::run(system, options, state, recorder)?.stopped),
        Analysis::Transient(options) => Ok(dynamics::run(system, options, state, recorder)?.stopped),
        Analysis::Modal(_) | Analysis::Buckling(_) => Ok(None),
    }
}

/// Pictures, checkpoint and, last of all, the summary.
fn conclude(mut recorder: Recorder<'_>, outcome: tegula::Result<()>) -> Result<Summary, JobError> {
    let failure: Option<OutputError> = recorder.take_failure();
    let (status, message) = match (&failure, &outcome) {
        (Some(error), _) => (Status::Failed, Some(error.to_string())),
        (None, Ok(())) => (Status::Complete, None),
        (None, Err(Error::Interrupted)) => (Status::Interrupted, None),
        (None, Err(error)) => (Status::Failed, Some(error.to_string())),
    };
    let finished = recorder.finish(status, message);
    if let Some(error) = failure.or(finished.err()) {
        // The disk may be full: the first error is what counts.
        recorder.fail(&error);
        return Err(error.into());
    }
    if recorder.model.output.pictures {
        pictures::draw(&mut recorder);
    }
    recorder.update_summary();
    if status == Status::Complete {
        recorder.warn_of_imbalance().inspect_err(|error| recorder.fail(error))?;
    }
    recorder.log_end().and_then(|()| recorder.write_summary()).inspect_err(|error| recorder.fail(error))?;
    let folder = recorder.folder.path().to_owned();
    match outcome {
        Ok(()) => Ok(recorder.summary),
        Err(Error::Interrupted) => Err(JobError::Interrupted { folder, resumable: true }),
        Err(error) => Err(JobError::Analysis { error, folder }),
    }
}

/// Announcement of a run.
pub(super) fn start(deck: &Deck, prepared: &Prepared, memory: Option<&CheckpointData>) -> Start {
    let (analysis, end) = match &deck.model.analysis {
        Analysis::Static(_) => ("static", 1.0),
        Analysis::Path(p) => ("path", p.end_load),
        Analysis::Modal(_) => ("modal", 1.0),
        Analysis::Buckling(_) => ("buckling", 1.0),
        Analysis::Transient(t) => ("transient", t.end_time),
    };
    let scheme = match &deck.model.analysis {
        Analysis::Transient(t) => t.scheme.name(),
        _ => "",
    };
    Start {
        title: deck.model.title.clone(),
        analysis,
        scheme,
        elements: prepared.system.elements(),
        unknowns: prepared.system.unknowns(),
        time: memory.map_or(prepared.system.first_load_factor(), |m| m.state.time),
        end,
    }
}

/// The summary of a run that has just begun.
pub(super) fn summary(deck: &Deck, prepared: &Prepared, start: &Start) -> Summary {
    Summary {
        program: "tegula".into(),
        version: env!("CARGO_PKG_VERSION").into(),
        status: Status::Running,
        error: None,
        analysis: start.analysis.into(),
        title: start.title.clone(),
        model: deck.path.display().to_string(),
        model_path: deck.path.canonicalize().ok().map(|path| path.display().to_string()),
        fingerprint: format!("{:016x}", prepared.fingerprint),
        deformed: deck.model.output.deformed,
        elements: start.elements,
        unknowns: start.unknowns,
        mass: prepared.system.total_mass(),
        time: start.time,
        end: start.end,
        stop: None,
        steps: 0,
        iterations: 0,
        factorizations: 0,
        cutbacks: 0,
        critical_step: None,
        energy_error: None,
        linear_iterations: None,
        negative_pivots: None,
        critical_points: None,
        branches: Vec::new(),
        assembly: prepared.system.closed_gaps.as_deref().map(AssemblyResult::from),
        warnings: Vec::new(),
        energy: Energy::default(),
        points: Default::default(),
        supports: Default::default(),
        loads: Default::default(),
        cuts: Default::default(),
        balance: None,
        acceleration: None,
        frequencies_hz: None,
        load_factors: None,
        sturm_checked: None,
        analyses: Vec::new(),
        stills: deck.model.output.stills.iter().map(|still| still.file.clone()).collect(),
        wall_s: 0.0,
        cpu_s: None,
        peak_memory_bytes: None,
        threads: rayon::current_num_threads(),
    }
}
