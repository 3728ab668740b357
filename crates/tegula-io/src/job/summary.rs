//! `summary.json`: status, results and costs of a run.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Deserializer, Serialize};
use tegula::analysis::path::{CriticalKind, CriticalPoint};
use tegula::analysis::{Balance, Stopped};

use super::JobOptions;
use super::assembly::AssemblyResult;
use super::forces::{AccelerationResult, BalanceResult, ForceResult};
use crate::out::{OutputError, write_over, write_whole};

/// A number; NaN and infinity are written as `null`.
pub(super) fn number<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    Ok(Option::<f64>::deserialize(from)?.unwrap_or(f64::NAN))
}

/// Three numbers.
pub(super) fn vector<'de, D: Deserializer<'de>>(from: D) -> Result<[f64; 3], D::Error> {
    Ok(<[Option<f64>; 3]>::deserialize(from)?.map(|x| x.unwrap_or(f64::NAN)))
}

/// Status of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// It has not ended, or the machine stopped it.
    Running,
    /// It reached its end.
    Complete,
    /// The user stopped it; it can be resumed.
    Interrupted,
    /// The analysis failed; the key `error` gives the reason.
    Failed,
}

/// Energies at the end of the run (energy).
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Energy {
    /// Kinetic energy.
    #[serde(deserialize_with = "number")]
    pub kinetic: f64,
    /// Strain energy.
    #[serde(deserialize_with = "number")]
    pub strain: f64,
    /// Potential of gravity (in statics: of all dead loads).
    #[serde(deserialize_with = "number")]
    pub potential: f64,
    /// Work of the other loads.
    #[serde(deserialize_with = "number")]
    pub work: f64,
    /// Dissipated energy.
    #[serde(deserialize_with = "number")]
    pub dissipated: f64,
    /// Sum that an exact integration keeps constant.
    #[serde(deserialize_with = "number")]
    pub total: f64,
}

impl From<&Balance> for Energy {
    fn from(b: &Balance) -> Self {
        Self {
            kinetic: b.kinetic,
            strain: b.strain,
            potential: b.potential,
            work: b.work,
            dissipated: b.dissipated,
            total: b.total,
        }
    }
}

/// A recorded point at the end of the run.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct PointResult {
    /// Position (length).
    #[serde(deserialize_with = "vector")]
    pub position: [f64; 3],
    /// Displacement (length).
    #[serde(deserialize_with = "vector")]
    pub displacement: [f64; 3],
}

/// Stop condition at which an analysis has ended.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StopResult {
    /// Column of the history.
    pub column: String,
    /// Value of the condition.
    #[serde(deserialize_with = "number")]
    pub value: f64,
    /// Value of the column at the end.
    #[serde(deserialize_with = "number")]
    pub reached: f64,
    /// Time (load factor) at the end.
    #[serde(deserialize_with = "number")]
    pub time: f64,
}

/// Critical point of an equilibrium path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CriticalResult {
    /// Limit point or bifurcation.
    pub kind: CriticalKind,
    /// Load factor.
    #[serde(deserialize_with = "number")]
    pub load_factor: f64,
    /// Parameter of the path, as in the column `path.position` of the history.
    #[serde(deserialize_with = "number")]
    pub position: f64,
    /// Change of the number of negative eigenvalues of the tangent along the path.
    pub change_of_negative_eigenvalues: i32,
}

impl From<&CriticalPoint> for CriticalResult {
    fn from(point: &CriticalPoint) -> Self {
        Self {
            kind: point.kind,
            load_factor: point.load,
            position: point.position,
            change_of_negative_eigenvalues: point.change,
        }
    }
}

impl From<Stopped> for StopResult {
    fn from(stopped: Stopped) -> Self {
        let Stopped { column, value, reached, time, .. } = stopped;
        Self { column, value, reached, time }
    }
}

/// One of several analyses that follow one another.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StepSummary {
    /// Name of the step.
    pub name: String,
    /// Folder of its results within the result folder.
    pub folder: String,
    /// `static`, `path`, `modal`, `buckling` or `transient`.
    pub analysis: String,
    /// Status; null before the analysis begins.
    #[serde(default)]
    pub status: Option<Status>,
    /// Stop condition at which it has ended, if one was met.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stop: Option<StopResult>,
}

/// Path that crosses the primary one at a bifurcation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BranchResult {
    /// Number of the bifurcation along the primary path, from 1; negative for the other side of its mode, as in `switch_at`.
    pub bifurcation: i32,
    /// Folder of its results within the result folder.
    pub folder: String,
    /// Status; null before it begins.
    #[serde(default)]
    pub status: Option<Status>,
    /// Load factor at its end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub load_factor: Option<f64>,
}

/// The contents of `summary.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Always `tegula`: by this a folder is known as a result.
    pub program: String,
    /// Version of the program.
    pub version: String,
    /// Status of the run.
    pub status: Status,
    /// Error message of a run that failed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    /// `static`, `path`, `modal`, `buckling` or `transient`; `steps` where several analyses follow one another, whose last one gives the
    /// results here.
    pub analysis: String,
    /// Title of the model.
    pub title: String,
    /// Path of the model file as it was given.
    pub model: String,
    /// Its whole path, by which a later run knows whether the folder holds results of the same model.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub model_path: Option<String>,
    /// Fingerprint of the model file and its mesh file, hexadecimal.
    pub fingerprint: String,
    /// Whether the field files contain the deformed mesh (`output.deformed`).
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub deformed: bool,
    /// Shell elements.
    pub elements: usize,
    /// Unknowns.
    pub unknowns: usize,
    /// Total mass (mass).
    #[serde(deserialize_with = "number")]
    pub mass: f64,
    /// Time (load factor) reached.
    #[serde(deserialize_with = "number")]
    pub time: f64,
    /// Time (load factor) at which the analysis ends.
    #[serde(deserialize_with = "number")]
    pub end: f64,
    /// Stop condition at which the analysis has ended, if one was met.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stop: Option<StopResult>,
    /// Finished steps.
    pub steps: u64,
    /// Iterations, those of repeated steps included.
    pub iterations: u64,
    /// Numerical factorisations.
    pub factorizations: u64,
    /// Steps repeated smaller.
    pub cutbacks: u64,
    /// Last lower bound of the critical step of an explicit scheme (time).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub critical_step: Option<f64>,
    /// Largest error of the energy balance of an explicit scheme over the largest kinetic or strain energy.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub energy_error: Option<f64>,
    /// Iterations of the iterative linear solver, where it was used.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub linear_iterations: Option<u64>,
    /// Negative pivots of the tangent at the last static equilibrium, where there are some.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub negative_pivots: Option<usize>,
    /// Critical points of a path, in the order in which it passes them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub critical_points: Option<Vec<CriticalResult>>,
    /// Paths that cross at the bifurcations of a path, where they are followed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub branches: Vec<BranchResult>,
    /// Gaps that were closed at the start and bodies that have moved for it, where the joints do not meet in the reference configuration.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub assembly: Option<AssemblyResult>,
    /// Warnings, each text once, in the order in which they came; those of all analyses where several follow one another.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
    /// Energies at the end.
    pub energy: Energy,
    /// Recorded points at the end.
    pub points: BTreeMap<String, PointResult>,
    /// Reactions at the end on each set that is supported or moved: forces that the supports exert on the model.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub supports: BTreeMap<String, ForceResult>,
    /// Loads at the end, by kind and set.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub loads: BTreeMap<String, ForceResult>,
    /// Forces and moments of the cuts at the end: actions of the rest of the model on the elements of each.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub cuts: BTreeMap<String, ForceResult>,
    /// Balance of loads, reactions and inertia at the end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub balance: Option<BalanceResult>,
    /// Rigid acceleration of a model with inertia relief.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub acceleration: Option<AccelerationResult>,
    /// Natural frequencies [1/time] of a modal analysis, rigid modes included.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frequencies_hz: Option<Vec<f64>>,
    /// Load factors of a buckling analysis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub load_factors: Option<Vec<f64>>,
    /// Whether a Sturm sequence has proved that no mode is missing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sturm_checked: Option<bool>,
    /// Analyses that follow one another, each with results in a folder of its own; empty where there is one only.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub analyses: Vec<StepSummary>,
    /// Files of the stills that the model asks for.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stills: Vec<String>,
    /// Time on the clock, those of resumed parts added (s).
    pub wall_s: f64,
    /// Processor time of all threads, user and system (s); null where it is not known.
    pub cpu_s: Option<f64>,
    /// Largest memory of the process (bytes); null where it is not known.
    pub peak_memory_bytes: Option<u64>,
    /// Threads.
    pub threads: usize,
}

/// Largest number of warnings in a summary.
const MOST_WARNINGS: usize = 100;

impl Summary {
    /// Adds a warning, unless the same one is known. The last one that is listed says that the log has more. Returns whether the list has grown.
    pub(super) fn add_warning(&mut self, message: &str) -> bool {
        let grows =
            self.warnings.len() <= MOST_WARNINGS && !self.warnings.iter().any(|known| known == message);
        if grows {
            let full = self.warnings.len() == MOST_WARNINGS;
            self.warnings.push(if full { "`log.txt` has more warnings".into() } else { message.into() });
        }
        grows
    }

    /// Warnings of an earlier part of a run, if there is one.
    pub(super) fn earlier_warnings(options: &JobOptions) -> Vec<String> {
        let earlier = options.resume.then(|| Self::read(&options.folder).ok()).flatten();
        earlier.map(|summary| summary.warnings).unwrap_or_default()
    }

    /// Reads the summary of a result folder.
    ///
    /// # Errors
    /// There is none, or it is not one of this program.
    pub fn read(folder: &Path) -> Result<Self, OutputError> {
        let path = folder.join("summary.json");
        let text = std::fs::read_to_string(&path).map_err(|cause| OutputError::read(&path, cause))?;
        let damaged =
            |problem: String| OutputError::damaged(&path, problem, "Choose a result folder of tegula");
        let summary: Self =
            serde_json::from_str(&text).map_err(|e| damaged(format!("it is no summary: {e}")))?;
        if summary.program == "tegula" {
            Ok(summary)
        } else {
            Err(damaged(format!("it was written by `{}`", summary.program)))
        }
    }

    /// Writes it, whole or not at all.
    pub(super) fn write(&self, folder: &Path) -> Result<(), OutputError> {
        let (path, text) = self.file(folder)?;
        write_whole(&path, |w| w.write_all(text.as_bytes()))
    }

    /// Writes that the run has failed, and why; over the present summary where the disk has no room for another.
    pub(super) fn write_failure(&mut self, folder: &Path, error: &OutputError) {
        (self.status, self.error) = (Status::Failed, Some(error.to_string()));
        if self.write(folder).is_err()
            && let Ok((path, text)) = self.file(folder)
        {
            let _ = write_over(&path, text.as_bytes());
        }
    }

    fn file(&self, folder: &Path) -> Result<(PathBuf, String), OutputError> {
        let path = folder.join("summary.json");
        let text = serde_json::to_string_pretty(self)
            .map_err(|e| OutputError::refused(&path, format!("it cannot be written as JSON: {e}")))?;
        Ok((path, text + "\n"))
    }
}
