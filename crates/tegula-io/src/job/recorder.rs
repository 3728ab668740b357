//! Observer that writes history, fields, checkpoints and log of an analysis.

use std::time::Instant;

use tegula::analysis::{Balance, Observer, State, Statistics, Step};
use tegula::model::{Analysis, Model};
use tegula::norm::larger;
use tegula::result::{Equilibrium, ShellResult, plastic_strains, recover};
use tegula::system::Shell;
use tegula::{Error, Result, System};

use super::history::HistoryRows;
use super::resume::{CheckpointData, RunCounters};
use super::series::{FieldSeries, STATES};
use super::summary::{PointResult, Status, Summary};
use super::{
    JobObserver, Prepared, Progress, RecordedStep, ResultFolder, Start, critical_modes, fields, forces,
    frames, process, snapshots,
};
use crate::deck::Diagnostic;
use crate::out::{HistoryWriter, OutputError};

/// Error of the balance of loads and reactions, as a part of their size, above which a static analysis warns.
pub const IMBALANCE: f64 = 1e-5;
/// Longest time on the clock between two checkpoints (s).
const CHECKPOINT_SECONDS: f64 = 30.0;
/// Shortest one where every step writes a field file (s).
const SMALLEST_CHECKPOINT_SECONDS: f64 = 1.0;
/// Strain above which a law that is linear in the Green–Lagrange strain no longer describes a real material.
const LARGE_STRAIN: f64 = 0.2;

/// Writes fields, history, checkpoints and the summary of one run.
pub(super) struct Recorder<'a> {
    pub model: &'a Model,
    pub prepared: &'a Prepared,
    pub folder: ResultFolder,
    pub summary: Summary,
    /// Data of the next checkpoint; its notes count the parts of the run before this one.
    pub memory: CheckpointData,
    watch: &'a mut dyn JobObserver,
    history: HistoryWriter,
    series: FieldSeries,
    rows: HistoryRows,
    /// Reactions, loads and inertia of the last step.
    forces: Option<Equilibrium>,
    statistics: Statistics,
    started: Instant,
    cpu_at_start: Option<f64>,
    last_checkpoint: Instant,
    /// Large strains have been reported.
    strained: bool,
    /// The size of all field files has been reported.
    foretold: bool,
    /// The first output that failed; the analysis was ended by it.
    failed: Option<OutputError>,
}

impl<'a> Recorder<'a> {
    /// Recorder of a new run, or of one that restarts from `memory`.
    pub fn new(
        model: &'a Model,
        prepared: &'a Prepared,
        folder: ResultFolder,
        summary: Summary,
        memory: Option<CheckpointData>,
        watch: &'a mut dyn JobObserver,
    ) -> std::result::Result<Self, OutputError> {
        summary.write(folder.path())?;
        let csv = folder.file("history.csv");
        let mut missing = 0;
        let rows = HistoryRows::new(model, prepared);
        watch.on_model(prepared, rows.columns());
        let (history, series) = match &memory {
            None => (
                HistoryWriter::create(&csv, rows.columns())?,
                FieldSeries::create(&folder, prepared, STATES)?,
            ),
            Some(memory) => {
                let written = (memory.notes.frames, memory.notes.last_frame);
                let (series, lost) = FieldSeries::resume(&folder, prepared, STATES, written)?;
                missing = lost;
                (HistoryWriter::resume(&csv, memory.notes.rows)?, series)
            }
        };
        // A run that is resumed at its end takes no step.
        let kept = memory.as_ref().map(|memory| &memory.forces);
        let forces = kept.and_then(|(row, reactions)| forces::restored(&prepared.system, row, reactions));
        let mut recorder = Self {
            model,
            prepared,
            folder,
            summary,
            memory: memory.unwrap_or_default(),
            watch,
            history,
            series,
            rows,
            forces,
            statistics: Statistics::default(),
            started: Instant::now(),
            cpu_at_start: process::cpu_seconds(),
            last_checkpoint: Instant::now(),
            strained: false,
            foretold: false,
            failed: None,
        };
        if missing > 0 {
            recorder.warning(&format!(
                "{missing} field file(s) of the earlier part are no longer there; the lists (`.pvd`) name the others only"
            ))?;
        }
        Ok(recorder)
    }

    /// Writes the start of the run to the log.
    pub fn announce(&mut self, start: &Start) -> std::result::Result<(), OutputError> {
        let how = if start.time > 0.0 { format!("resumed at {}", start.time) } else { "started".into() };
        self.folder.log(&format!(
            "tegula {}: {} of {} elements, {} unknowns, {how}",
            self.summary.version,
            start.described(),
            start.elements,
            start.unknowns
        ))
    }

    /// Reports the warnings of the check of the model.
    pub fn warn(&mut self, warnings: &[Diagnostic]) -> std::result::Result<(), OutputError> {
        warnings.iter().try_for_each(|warning| self.warning(&warning.to_string()))
    }

    /// Warns where the loads and reactions of an equilibrium do not balance, as beside springs that are stiffer than places are exact.
    pub fn warn_of_imbalance(&mut self) -> std::result::Result<(), OutputError> {
        let Some(balance) = self.summary.balance else { return Ok(()) };
        let error = larger(balance.force, balance.moment);
        if !matches!(self.model.analysis, Analysis::Static(_)) || error <= IMBALANCE {
            return Ok(());
        }
        self.warning(&format!(
            "loads and reactions balance only up to {error:.1e} of their size: the forces of springs or parts that are very stiff beside the others \
             are round-off; make them softer, or put a joint or a support in their place"
        ))
    }

    fn warning(&mut self, message: &str) -> std::result::Result<(), OutputError> {
        self.watch.on_warning(message);
        if self.summary.add_warning(message) {
            // A run that is killed and resumed keeps it.
            self.summary.write(self.folder.path())?;
        }
        self.folder.log(&format!("warning: {message}"))
    }

    /// Writes the end of the run to the log.
    pub fn log_end(&mut self) -> std::result::Result<(), OutputError> {
        let s = &self.summary;
        let mut line = format!(
            "{:?} at {} after {} steps, {} iterations, {} cut-backs, {:.2} s",
            s.status, s.time, s.steps, s.iterations, s.cutbacks, s.wall_s
        );
        if let Some(error) = &s.error {
            line.push_str(&format!(": {error}"));
        }
        self.folder.log(&line)
    }

    /// Records the first state of an analysis that does not report it itself.
    pub fn record_start(&mut self, state: &State, balance: &Balance, end: f64) -> Result<()> {
        let statistics = Statistics::default();
        self.on_step(&Step { state, balance, statistics: &statistics, iterations: 0, end })
    }

    /// The output error that ended the analysis, if one did.
    pub fn take_failure(&mut self) -> Option<OutputError> {
        self.failed.take()
    }

    /// Writes the last state, the checkpoint and the summary.
    pub fn finish(&mut self, status: Status, error: Option<String>) -> std::result::Result<(), OutputError> {
        let regular = self.memory.notes;
        let pictures = self.memory.kept.len();
        let any = !self.memory.state.u.is_empty();
        if any {
            self.watch.on_last_state(self.prepared, &self.memory.state);
        }
        if any && (regular.frames == 0 || frames::place(&self.memory.state) != regular.last_frame) {
            self.frame()?;
        }
        if any {
            self.keep_last();
            if self.forces.is_none() {
                self.forces = Some(self.rows.forces_at(&self.prepared.system, &self.memory.state));
            }
        }
        // A run that restarts from here writes the last field file again only when it is due.
        let mut extra = Vec::new();
        if status != Status::Complete {
            (self.memory.notes.frames, self.memory.notes.last_frame) = (regular.frames, regular.last_frame);
            extra = self.memory.kept.split_off(pictures);
        }
        self.history.sync()?;
        if any {
            self.checkpoint()?;
        }
        self.memory.kept.extend(extra);
        let critical = self.memory.state.path.as_ref().map_or(&[][..], |path| &path.critical);
        if !critical.is_empty() {
            critical_modes::write(&self.folder, self.prepared, &self.model.output, critical)?;
        }
        self.update_summary();
        self.summary.status = status;
        self.summary.error = error;
        Ok(())
    }

    /// Keeps the last state for the picture, wherever it stands between the instants that are kept regularly.
    fn keep_last(&mut self) {
        let state = &self.memory.state;
        if self.model.output.pictures && snapshots::lacks(&self.memory.kept, state) {
            let Prepared { mesh, system, .. } = self.prepared;
            let values = fields::von_mises(mesh, system, state);
            snapshots::keep(&mut self.memory.kept, state, values);
        }
    }

    /// Replaces the summary in the folder by the present one.
    pub fn write_summary(&self) -> std::result::Result<(), OutputError> {
        self.summary.write(self.folder.path())
    }

    /// Writes a summary with the reason of the failure, even on a full disk.
    pub fn fail(&mut self, error: &OutputError) {
        self.update_summary();
        self.summary.write_failure(self.folder.path(), error);
    }

    /// Brings counts, energies, points and costs up to date.
    pub fn update_summary(&mut self) {
        let totals = self.memory.notes.total(&self.statistics);
        let cpu_s = self.cpu();
        let s = &mut self.summary;
        s.steps = totals.steps.max(self.memory.state.step);
        (s.iterations, s.factorizations, s.cutbacks) =
            (totals.iterations, totals.factorizations, totals.cutbacks);
        s.critical_step = Some(totals.critical_step).filter(|&step| step > 0.0);
        s.energy_error = s.critical_step.map(|_| totals.energy_error);
        s.linear_iterations = (totals.linear_iterations > 0).then_some(totals.linear_iterations);
        s.negative_pivots = Some(self.memory.state.negative_pivots).filter(|&n| n > 0);
        let path = self.memory.state.path.as_ref();
        s.critical_points = path.map(|path| path.critical.iter().map(Into::into).collect());
        s.time = self.memory.state.time;
        s.energy = (&self.memory.balance).into();
        if !self.memory.state.u.is_empty() {
            let (system, state) = (&self.prepared.system, &self.memory.state);
            s.acceleration = system.relief_acceleration(&state.u, state.time).map(Into::into);
            let point = |p: &tegula::result::Probe| PointResult {
                position: p.position(system, state),
                displacement: p.displacement(state),
            };
            if let Some(forces) = &self.forces {
                let balance;
                (s.supports, s.loads, balance) = forces::results(system, forces);
                s.balance = Some(balance);
                s.cuts = forces::of_cuts(system, forces);
            }
            s.points = self.prepared.probes.iter().map(|p| (p.name.clone(), point(p))).collect();
        }
        s.wall_s = self.memory.notes.wall_s + self.started.elapsed().as_secs_f64();
        s.cpu_s = cpu_s;
        s.peak_memory_bytes = process::peak_memory_bytes();
    }

    fn cpu(&self) -> Option<f64> {
        let spent = process::cpu_seconds()? - self.cpu_at_start?;
        Some(spent + self.memory.notes.cpu_s.unwrap_or(0.0))
    }

    /// Row of a step behind the last recorded one, its forces and its length.
    fn row(&mut self, step: &Step) -> (Vec<f64>, Equilibrium, f64) {
        self.rows.row(self.prepared, &self.memory.state, step)
    }

    fn record(&mut self, step: &Step) -> std::result::Result<(), OutputError> {
        let first = self.memory.state.u.is_empty();
        let (row, forces, step_size) = self.row(step);
        self.memory.state.clone_from(step.state);
        self.memory.balance = *step.balance;
        self.statistics = *step.statistics;
        self.forces = Some(forces);
        self.history.append(&row)?;
        let on_path = step.state.path.is_some();
        let now = frames::Instant { step: step.state.step, time: step.state.time, end: step.end, on_path };
        let due = first
            || self.prepared.system.wanted_times.contains(&step.state.time)
            || frames::due(&self.model.output, now, self.memory.notes.last_frame);
        if due {
            self.frame()?;
            self.foretell(now)?;
        }
        let since = self.last_checkpoint.elapsed().as_secs_f64();
        let spaced = self.model.output.interval.is_some_and(|interval| interval > 0.0);
        if (due && (spaced || since > SMALLEST_CHECKPOINT_SECONDS)) || since > CHECKPOINT_SECONDS {
            self.history.sync()?;
            self.series.sync()?;
            self.checkpoint()?;
        } else {
            self.history.flush()?;
        }
        let progress = Progress {
            step: step.state.step,
            time: step.state.time,
            step_size,
            iterations: step.iterations,
            end: step.end,
        };
        self.watch.on_step(&progress);
        let Self { prepared, memory, .. } = self;
        self.watch.on_recorded_step(&RecordedStep { prepared, state: &memory.state, row: &row });
        Ok(())
    }

    /// Warns once of field files that will take much room.
    fn foretell(&mut self, now: frames::Instant) -> std::result::Result<(), OutputError> {
        if self.foretold {
            return Ok(());
        }
        let bytes = self.series.bytes(&self.folder, self.memory.notes.frames.saturating_sub(1));
        match frames::too_many(self.memory.notes.frames, bytes, now) {
            Some(warning) => {
                self.foretold = true;
                self.warning(&warning)
            }
            None => Ok(()),
        }
    }

    /// Writes the fields of the present state.
    fn frame(&mut self) -> std::result::Result<(), OutputError> {
        let Prepared { mesh, system, .. } = self.prepared;
        let state = &self.memory.state;
        let results = recover(system, state);
        let strain = if self.strained { None } else { largest_strain(system, state, &results) };
        let found;
        let forces = match &self.forces {
            Some(forces) => forces,
            None => {
                found = self.rows.forces_at(system, state);
                &found
            }
        };
        let frame = fields::Frame { forces: Some(forces), ..fields::Frame::of_state(state) };
        let model = (&**mesh, system, &self.model.output);
        self.series.write(&self.folder, model, (self.memory.notes.frames, &frame), &results)?;
        if self.model.output.pictures && snapshots::wanted(&mut self.memory.kept, state, self.summary.end) {
            let values = fields::by_quad(mesh, system, &results, |r| [r.von_mises]);
            snapshots::keep(&mut self.memory.kept, state, values);
        }
        self.memory.notes.frames += 1;
        self.memory.notes.last_frame = frames::place(state);
        if let Some((strain, quad)) = strain.filter(|(strain, _)| *strain > LARGE_STRAIN) {
            self.strained = true;
            let (label, time) = (system.quad_label(quad), self.memory.state.time);
            self.warning(&format!(
                "element {label} is strained by {:.0} % at {time:.6e}: the material law holds for small strains only; \
                 check units, loads and thickness",
                100.0 * strain
            ))?;
        }
        Ok(())
    }

    fn checkpoint(&mut self) -> std::result::Result<(), OutputError> {
        let totals = self.memory.notes.total(&self.statistics);
        // The parts before stay in the memory; the file holds everything up to now.
        let before = self.memory.notes;
        self.memory.notes = RunCounters {
            rows: self.history.rows(),
            iterations: totals.iterations,
            factorizations: totals.factorizations,
            cutbacks: totals.cutbacks,
            linear_iterations: totals.linear_iterations,
            energy_error: totals.energy_error,
            critical_step: totals.critical_step,
            wall_s: before.wall_s + self.started.elapsed().as_secs_f64(),
            cpu_s: self.cpu(),
            ..before
        };
        if let Some(forces) = &self.forces {
            self.memory.forces = (forces::row(forces), forces.reactions.clone());
        }
        let saved = self.memory.save(&self.folder.file("checkpoint.bin"), self.prepared.fingerprint);
        self.memory.notes = before;
        self.last_checkpoint = Instant::now();
        saved?;
        // A run that is killed leaves a summary of what it can be resumed from.
        self.update_summary();
        self.write_summary()
    }
}

/// Largest strain and its quad among the shells whose material is for small strains: root mean square over the
/// thickness, from the energy per area w = Z ε²/2 with the stiffness Z = E h of stretching, or the plastic strain,
/// which stores no energy.
fn largest_strain(system: &System, state: &State, results: &[ShellResult]) -> Option<(f64, u32)> {
    let laws = |shell: &Shell| system.sections.get(shell.section).map_or(&[][..], |s| &s.section.laws[..]);
    let plastic = if system.shells.iter().all(|s| laws(s).is_empty()) {
        Vec::new()
    } else {
        plastic_strains(system, state)
    };
    let strain = |(i, (shell, result)): (usize, (&Shell, &ShellResult))| {
        if laws(shell).iter().any(|law| law.is_hyperelastic()) {
            return None;
        }
        let stretching = system.sections.get(shell.section)?.section.resultant.stretch();
        let elastic = (2.0 * result.energy_density / stretching).max(0.0).sqrt();
        Some((elastic.max(plastic.get(i).copied().unwrap_or(0.0)), shell.quad))
    };
    let shells = system.shells.iter().zip(results).enumerate();
    shells.filter_map(strain).max_by(|a, b| a.0.total_cmp(&b.0))
}

impl Observer for Recorder<'_> {
    fn on_step(&mut self, step: &Step) -> Result<()> {
        self.record(step).map_err(|error| {
            let message = error.to_string();
            self.watch.on_output_failure(&error);
            self.failed.get_or_insert(error);
            Error::Outside(message)
        })
    }

    fn on_repeat(&mut self, statistics: &Statistics) {
        self.statistics = *statistics;
    }

    fn on_event(&mut self, message: &str) {
        if let Err(error) = self.folder.log(message) {
            self.failed.get_or_insert(error);
        }
        self.watch.on_event(message);
    }

    fn on_warning(&mut self, message: &str) {
        if let Err(error) = self.warning(message) {
            self.failed.get_or_insert(error);
        }
    }

    fn column(&mut self, name: &str, step: &Step) -> Option<f64> {
        let number = self.rows.columns().iter().position(|column| column == name)?;
        self.row(step).0.get(number).copied()
    }

    fn interrupted(&self) -> bool {
        self.watch.interrupted()
    }
}
