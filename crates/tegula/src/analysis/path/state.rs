//! State of an equilibrium path beyond displacements and load factor: where it is expanded, and the critical points found.

use serde::{Deserialize, Serialize};

use crate::Error;
use crate::analysis::mobility::{free_motions, is_searched, neutral_motions, told_neutral};
use crate::analysis::newton::PathTangent;
use crate::analysis::{Observer, State};
use crate::element::Nodal;
use crate::model::{PathAnalysis, PathEnd};
use crate::system::{PathBefore, System, add_multiple};

/// Place on a path at which it is expanded into a power series.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct ExpansionPoint {
    /// Path parameter from the start of the path.
    pub position: f64,
    /// Displacements.
    pub u: Vec<Nodal>,
    /// Load factor.
    pub load: f64,
    /// Derivative of the displacements with respect to the path parameter, by the series before; empty at the start of the path.
    pub direction: Vec<Nodal>,
    /// Length over which the residual of the step before fades; 0 at the start of the path.
    pub expected: f64,
    /// Number of the expansion, from 0.
    pub number: u32,
    /// Number of bifurcations that the path has passed.
    pub bifurcations: usize,
}

/// Kind of a critical point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CriticalKind {
    /// Limit point: the load factor has a maximum or a minimum.
    Limit,
    /// Bifurcation: another path crosses.
    Bifurcation,
    /// Onset of flutter under loads without a potential: two frequencies meet, and vibrations about the equilibria behind it grow.
    Flutter,
}

impl CriticalKind {
    /// Whether a path is to end at a critical point of this kind.
    pub fn ends(self, options: &PathAnalysis) -> bool {
        options.end_at.is_some_and(|end| match end {
            PathEnd::LimitPoint => self == Self::Limit,
            PathEnd::Bifurcation => self == Self::Bifurcation,
            PathEnd::Flutter => self == Self::Flutter,
            PathEnd::CriticalPoint => true,
        })
    }

    /// Name in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Limit => "limit point",
            Self::Bifurcation => "bifurcation",
            Self::Flutter => "onset of flutter",
        }
    }
}

/// Critical point of a path: an eigenvalue of the tangent passes through zero, or vibrations begin to grow.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CriticalPoint {
    /// Kind of the point.
    pub kind: CriticalKind,
    /// Load factor.
    pub load: f64,
    /// Path parameter from the start of the path.
    pub position: f64,
    /// Change of the number of negative eigenvalues of the tangent along the path.
    pub change: i32,
    /// Displacements.
    pub u: Vec<Nodal>,
    /// Eigenvector: motion at constant load, of unit norm ([`System::norm`](crate::System::norm)). At the onset of flutter the real part of a mode.
    pub mode: Vec<Nodal>,
}

/// Distance of two points of a path over the size of the displacements, and difference of their load factors over them, below which they
/// are one.
const SAME: f64 = 1e-5;
/// Way between two passages of one point over the size of the displacements: of points that lie as near to each other on a path, as those
/// of nearly equal eigenvalues, none is passed again.
const WAY: f64 = 100.0 * SAME;

/// Distance along the critical mode over the size of the displacements at which a path that returns to its bifurcation may be rounded off.
const ALONG_MODE: f64 = 3e-3;
/// Distance across the mode over the square of that along it, times the size of the displacements.
const CURVED: f64 = 10.0;

/// Difference of load factors over them beside a bifurcation.
const BESIDE: f64 = 1e-4;

impl CriticalPoint {
    /// Whether this is a bifurcation next to which a load factor lies.
    pub fn is_bifurcation_beside(&self, load: f64) -> bool {
        self.kind == CriticalKind::Bifurcation && (self.load - load).abs() <= BESIDE * load.abs()
    }

    /// Whether a later point is this one. Where a crossing path returns to its bifurcation it may be rounded off along the critical mode, and
    /// have an extremum of the load there.
    pub fn is_passed_again_at(&self, system: &System, later: &Self) -> bool {
        let size = system.norm(&self.u);
        let same_load = (self.load - later.load).abs() <= SAME * self.load.abs();
        if !(same_load && later.position - self.position > WAY * size) {
            return false;
        }
        let mut difference = later.u.clone();
        add_multiple(&mut difference, -1.0, &self.u);
        if self.kind != CriticalKind::Bifurcation {
            return later.kind == self.kind && system.norm(&difference) <= SAME * size;
        }
        let along = system.inner_product(&self.mode, &difference);
        add_multiple(&mut difference, -along, &self.mode);
        // Across the mode the path is curved.
        along.abs() <= ALONG_MODE * size
            && system.norm(&difference) <= SAME * size + CURVED * along * along / size
    }
}

/// Where an arc-length step starts.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct ArcStart {
    /// Direction of the path.
    pub tangent: PathTangent,
    /// Length of the next step ([`System::norm`]).
    pub length: f64,
}

/// State of a path.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct PathState {
    /// Path parameter from the start of the path, summed over the expansions: nearly the arc length of the displacements
    /// ([`System::norm`](crate::System::norm)).
    pub position: f64,
    /// Where the present piece of the path is expanded; of an arc-length path only the number of the step counts.
    pub expansion: ExpansionPoint,
    /// Where the next arc-length step starts; `None` for power series, and before the first step.
    #[serde(default)]
    pub arc: Option<ArcStart>,
    /// Direction of power series at the state; empty for arc-length steps, and before the first step.
    #[serde(default)]
    pub direction: Vec<Nodal>,
    /// Derivative of the load factor of power series along it; 0 for arc-length steps, and before the first step.
    #[serde(default)]
    pub load_rate: f64,
    /// Critical points passed so far.
    pub critical: Vec<CriticalPoint>,
    /// Least and largest load factor so far.
    pub loads: [f64; 2],
    /// Whether vibrations about the last equilibrium grow (flutter).
    #[serde(default)]
    pub flutters: bool,
    /// Whether the path has ended.
    pub finished: bool,
}

impl PathState {
    /// Direction and kind of the end of this path, for the next analysis step; the tangent has a number of negative pivots there.
    pub fn before(&self, negative_pivots: usize) -> PathBefore {
        let at_end =
            |point: &&CriticalPoint| point.position == self.position && point.kind != CriticalKind::Flutter;
        let end = self.critical.last().filter(at_end);
        if negative_pivots == 0 && end.is_none() {
            return PathBefore::default();
        }
        let direction = self.arc.as_ref().map_or(&self.direction, |arc| &arc.tangent.direction).clone();
        PathBefore {
            direction,
            rises: self.arc.as_ref().map_or(self.load_rate, |arc| arc.tangent.load) > 0.0,
            at_critical_point: end.is_some(),
            change: end.map_or(0, |point| point.change),
        }
    }

    /// Notes a critical point that the path has passed, with `negative` negative eigenvalues behind it. The path ends where it is to end at
    /// such a point, and where it passes the point again: it is closed.
    pub fn pass(
        &mut self,
        (system, options): (&System, &PathAnalysis),
        found: &CriticalPoint,
        negative: usize,
        observer: &mut dyn Observer,
    ) {
        observer.on_event(&format!(
            "{} at load factor {:.9e}: the path behind it has {negative} negative eigenvalue(s)",
            found.kind.name(),
            found.load,
        ));
        let is_bifurcation = |point: &CriticalPoint| point.kind == CriticalKind::Bifurcation;
        if is_bifurcation(found) && !self.critical.iter().any(is_bifurcation) {
            warn_of_free_motions(system, found, observer);
        }
        let modes = found.change.unsigned_abs();
        if is_bifurcation(found) && modes > 1 && (!options.switch_at.is_empty() || options.branches.is_some())
        {
            observer.on_warning(&format!(
                "{modes} modes meet at the bifurcation at load factor {:.6e}: of the paths that cross there one is found on each side, and others are not",
                found.load
            ));
        }
        if let Some(earlier) = self.critical.iter().find(|earlier| earlier.is_passed_again_at(system, found))
        {
            observer.on_event(&format!(
                "the path is closed and ends here: it has passed this {} before, at the path parameter {:.6e}",
                found.kind.name(),
                earlier.position
            ));
            self.finished = true;
        }
        self.finished |= found.kind.ends(options);
        self.critical.push(found.clone());
    }

    /// Warns of what the path was to do and has not done: wanted load factors, bifurcations at which it was to go over to another path.
    pub fn warn_of_what_was_missed(
        &self,
        system: &System,
        options: &PathAnalysis,
        observer: &mut dyn Observer,
    ) {
        let passed = self.critical.iter().filter(|point| point.kind == CriticalKind::Bifurcation).count();
        let wanted = self.critical.iter().any(|point| point.kind.ends(options));
        if options.end_at.is_some() && !wanted {
            let reason = match options.end_at {
                Some(PathEnd::Flutter) if self.flutters => {
                    "the onset of its flutter is known only between the two load factors that a warning has told; modal steps about static states between them narrow it"
                }
                Some(PathEnd::Flutter) => {
                    "it has passed no onset of flutter of the lowest modes, which are watched"
                }
                _ => "it has passed none of the kind that is named",
            };
            observer.on_warning(&format!("the path has not ended at a critical point (`end_at`): {reason}"));
        }
        for number in options.switch_at.iter().filter(|number| number.unsigned_abs() as usize > passed) {
            observer.on_warning(&format!(
                "the path has not gone over to another one at bifurcation {number} (`switch_at`): it has passed {passed} bifurcation(s)"
            ));
        }
        let [least, largest] = self.loads;
        for wanted in system.wanted_times.iter().filter(|load| !(least..=largest).contains(*load)) {
            observer.on_warning(&format!(
                "the path has not passed load factor {wanted} (`output.at`): it has been between {least:.6} and {largest:.6}"
            ));
        }
    }
}

/// Error of a path on which a mechanism may move freely from an equilibrium to others.
pub fn one_of_many(state: &State, neutral: &[String]) -> Error {
    Error::NotConverged {
        at: format!("load factor {:.6}", state.time),
        reason: told_neutral(neutral),
        help: "Hold the free motions by joints, supports or springs.".into(),
    }
}

/// Error of a path that cannot be continued from a state. The motions that a mechanism has at its start, or that nothing holds later, are named.
pub fn not_continued(system: &System, state: &State, reason: &str) -> Error {
    if state.step > 0 {
        let neutral = neutral_motions(system, state);
        if !neutral.is_empty() {
            return one_of_many(state, &neutral);
        }
    }
    let free = if state.step == 0 { free_motions(system, state, None) } else { Vec::new() };
    if !free.is_empty() {
        return Error::NotConverged {
            at: format!("load factor {:.6}", state.time),
            reason: format!(
                "the model is a mechanism: joints, springs and supports leave {} motion(s) free: {}. The path could not be begun: {reason}",
                free.len(),
                free.join("; ")
            ),
            help: "Hold the free motions by joints, supports or springs.".into(),
        };
    }
    Error::NotConverged {
        at: format!("load factor {:.6}", state.time),
        reason: format!("the path could not be continued: {reason}"),
        help: format!(
            "Results up to this load factor are complete. {}",
            many_modes(state).unwrap_or_else(|| {
                "Look at the shape there: elements may be inverted, parts may move freely, springs may have lost their length, or several paths \
                 may cross."
                    .into()
            })
        ),
    }
}

/// Hint for a path that ends behind a bifurcation where several modes meet; `None` where the last one is a simple one.
fn many_modes(state: &State) -> Option<String> {
    let last = state.path.as_ref()?.critical.last()?;
    let modes = last.change.unsigned_abs();
    (last.kind == CriticalKind::Bifurcation && modes > 1).then(|| {
        format!(
            "{modes} modes meet at the bifurcation at load factor {:.6}: the paths that cross there may be a family, such as those of a column which \
             buckles in any direction, and the tangent along them stays singular. Let a small imperfection choose one of them, or hold the others.",
            last.load
        )
    })
}

/// Warns of motions that the joints of a small model leave free at a bifurcation: their eigenvalues are round-off, and the bifurcation may be one
/// of them.
fn warn_of_free_motions(system: &System, found: &CriticalPoint, observer: &mut dyn Observer) {
    if !is_searched(system) {
        return;
    }
    let state = State { u: found.u.clone(), time: found.load, ..State::first(system) };
    let free = free_motions(system, &state, None);
    if !free.is_empty() {
        observer.on_warning(&format!(
            "load factor {:.6e}: joints, springs and supports leave {} motion(s) free: {}; where no stress resists them, this bifurcation is one of \
             round-off",
            found.load,
            free.len(),
            free.join("; ")
        ));
    }
}

/// Warns of a path that its number of steps has ended.
pub fn ended_early(state: &State, options: &PathAnalysis, observer: &mut dyn Observer) {
    observer.on_warning(&format!(
        "the path ends after {} step(s) (`max_steps`) at load factor {:.6}, before it has reached load factor {}",
        options.max_steps, state.time, options.end_load
    ));
}
