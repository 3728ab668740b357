//! Equilibrium paths: all equilibria under loads in proportion to a load factor, through limit points, by power series.
//!
//! Strains that are quadratic in the nodal vectors and linear materials make equilibrium a polynomial equation, and its path an
//! analytic curve. At a point of the path one factorisation of the tangent gives displacements and load factor as power series in the
//! path parameter (asymptotic numerical method). The series holds up to a length that its last term tells; there the
//! next one begins. Nothing is iterated and no step length is guessed, and what lies between the ends of a step is known as a
//! polynomial: reported points, wanted load factors, limit points and the end of the path are evaluated from it.

mod branch;
mod critical_points;
mod expansion;
mod geometric;
mod piece;
mod scope;
mod series;
mod state;

pub use state::{CriticalKind, CriticalPoint, ExpansionPoint, PathState};

use super::statics::{self, reactions};
use super::stepper::{self, Reached};
use super::{Balance, Observer, State, Statistics, Stepper, Stopped, Watched};
use crate::element::Nodal;
use crate::error::Issue;
use crate::model::PathAnalysis;
use crate::norm::larger;
use crate::system::{Procedure, System};
use crate::{Error, Result};
use expansion::Expansion;
use piece::{Piece, Start};

/// Outcome of a path.
#[derive(Debug, Clone, PartialEq)]
pub struct PathOutcome {
    /// Final state; its [`PathState`] has the critical points.
    pub state: State,
    /// Energies of the final state.
    pub balance: Balance,
    /// Run counters.
    pub statistics: Statistics,
    /// Stop condition at which the path has ended.
    pub stopped: Option<Stopped>,
}

/// Why a path cannot be expanded into power series; `None` where it can.
pub fn outside_of_scope(system: &System) -> Option<Issue> {
    scope::stresses(system, 2).err().map(|reason| outside(&reason))
}

fn outside(reason: &str) -> Issue {
    Issue::new(
        "analysis.type",
        format!("the path cannot be expanded into power series: {reason}"),
        "take elements with free directors (`ems`, `cm`, `solid-shell`, `ancf-full`), linear materials, and loads of constant direction \
         that grow from 0 in a straight line; or a static analysis, up to the limit point",
    )
}

/// First state of a path: where the analysis step before has ended, or the reference configuration.
pub fn first_state(system: &System) -> State {
    let state = State::first(system);
    let expansion = ExpansionPoint { u: state.u.clone(), ..ExpansionPoint::default() };
    State { path: Some(Box::new(PathState { expansion, ..PathState::default() })), ..state }
}

/// Follows a path from `start`, a state of the same analysis (from its first state where `None`), to its end.
///
/// # Errors
/// The model has no power series, or a series has no convergence; the error names the load factor reached. The observer does not know
/// the column of a stop condition.
pub fn run(
    system: &System,
    options: &PathAnalysis,
    start: Option<State>,
    observer: &mut dyn Observer,
) -> Result<PathOutcome> {
    let mut steps = PathSteps::new(system, options, start)?;
    let stopped = stepper::run(&mut steps, &options.stop, observer)?;
    let (state, balance, statistics) = Box::new(steps).finish();
    Ok(PathOutcome { state, balance, statistics, stopped })
}

/// A path between two of its points.
pub struct PathSteps<'a> {
    system: &'a System,
    options: &'a PathAnalysis,
    expansion: Expansion,
    /// Present piece; `None` before the first one, and in a run that is resumed.
    piece: Option<Piece>,
    state: State,
    balance: Balance,
    statistics: Statistics,
    /// Path parameter at which the next step ends at the latest.
    limit: f64,
    /// Reactions at the last point; empty where no motion is prescribed.
    reactions: Vec<Nodal>,
    /// Displacements of the point before.
    before: Vec<Nodal>,
}

impl<'a> PathSteps<'a> {
    /// Path from `start`, a state of the same analysis, or from its first state.
    ///
    /// # Errors
    /// The model has no power series, or there is not enough memory.
    pub fn new(system: &'a System, options: &'a PathAnalysis, start: Option<State>) -> Result<Self> {
        system.require(&[Procedure::Path])?;
        let stresses = scope::stresses(system, options.order as usize)
            .map_err(|reason| Error::Model(vec![outside(&reason)]))?;
        let mut expansion = Expansion::new(system, stresses)?;
        let state = start.filter(|state| state.path.is_some()).unwrap_or_else(|| first_state(system));
        let moves = !system.dofs().prescribed.is_empty();
        Ok(Self {
            reactions: if moves { reactions(system, expansion.assembly(), &state) } else { Vec::new() },
            balance: statics::energies(system, expansion.assembly(), &state),
            statistics: Statistics { steps: state.step, ..Statistics::default() },
            before: state.u.clone(),
            limit: f64::INFINITY,
            piece: None,
            system,
            options,
            expansion,
            state,
        })
    }

    /// Makes sure that the present piece leads on from the state.
    fn provide_piece(&mut self) -> Result<()> {
        let Some(path) = self.path() else { return Ok(()) };
        let (position, recorded) = (path.position, path.expansion.clone());
        while !self.piece.as_ref().is_some_and(|piece| piece.leads_on_from(position)) {
            let goes_on = self.piece.as_mut().filter(|piece| position == piece.end_position());
            let start = match goes_on.and_then(Piece::next_start) {
                Some(start) => start,
                // The piece of a run that is resumed or repeated is found anew; the state may be the end of it.
                None => Start::new(self.system, &mut self.expansion, recorded.clone())
                    .map_err(|reason| self.error(&reason))?,
            };
            self.piece = Some(self.find_piece(start)?);
        }
        Ok(())
    }

    fn find_piece(&mut self, start: Start) -> Result<Piece> {
        let piece = Piece::new(self.system, &mut self.expansion, start, self.options);
        self.statistics.factorizations = self.expansion.factorizations();
        piece.map_err(|reason| self.error(&reason))
    }

    fn error(&self, reason: &str) -> Error {
        Error::NotConverged {
            at: format!("load factor {:.6}", self.state.time),
            reason: format!("the path could not be continued: {reason}"),
            help: "Results up to this load factor are complete. Look at the shape there: elements may be inverted, or supports missing."
                .into(),
        }
    }

    fn path(&self) -> Option<&PathState> {
        self.state.path.as_deref()
    }

    /// Warns of wanted load factors that the path has not passed.
    fn warn_of_missed_loads(&self, observer: &mut dyn Observer) {
        let Some([least, largest]) = self.path().map(|path| path.loads) else { return };
        for wanted in self.system.wanted_times.iter().filter(|load| !(least..=largest).contains(*load)) {
            observer.on_warning(&format!(
                "the path has not passed load factor {wanted} (`output.at`): it has been between {least:.6} and {largest:.6}"
            ));
        }
    }

    /// Goes to the parameter `a` of the present piece.
    fn go_to(&mut self, a: f64, observer: &mut dyn Observer) {
        let Self { system, state, before, piece, expansion, .. } = self;
        let Some(piece) = piece else { return };
        before.copy_from_slice(&state.u);
        piece.series().displacements(a, &mut state.u);
        state.time = piece.load(a);
        state.step += 1;
        let Some(path) = &mut state.path else { return };
        let from = path.position;
        path.position = piece.position_of(a);
        if path.expansion.position != piece.start().position || path.expansion.u.is_empty() {
            path.expansion = piece.start().clone();
        }
        path.loads = [path.loads[0].min(state.time), larger(path.loads[1], state.time)];
        for found in piece.passed(from, path.position) {
            observer.on_event(&format!(
                "{} at load factor {:.9e}: the path behind it has {} negative eigenvalue(s)",
                found.kind.name(),
                found.load,
                piece.negative_at(found.position)
            ));
            if let Some(earlier) =
                path.critical.iter().find(|earlier| earlier.is_passed_again_at(system, found))
            {
                observer.on_event(&format!(
                    "the path is closed and ends here: it has passed this {} before, at the path parameter {:.6e}",
                    found.kind.name(),
                    earlier.position
                ));
                path.finished = true;
            }
            path.critical.push(found.clone());
        }
        path.finished |= piece.is_last() && path.position >= piece.end_position();
        state.negative_pivots = piece.negative_at(path.position);
        if !self.reactions.is_empty() {
            let after = reactions(system, expansion.assembly(), state);
            for forces in [&self.reactions, &after] {
                state.work += 0.5 * system.work_of_prescribed(forces, before, &state.u);
            }
            self.reactions = after;
        }
        self.statistics.steps = state.step;
        self.balance = statics::energies(system, expansion.assembly(), state);
    }
}

impl Stepper for PathSteps<'_> {
    fn reached(&self) -> Reached<'_> {
        let Self { state, balance, statistics, .. } = self;
        Reached { state, balance, statistics, end: self.options.end_load }
    }

    fn is_finished(&self) -> bool {
        self.path().is_none_or(|path| path.finished)
    }

    fn position(&self) -> f64 {
        self.path().map_or(0.0, |path| path.position)
    }

    fn finish(self: Box<Self>) -> (State, Balance, Statistics) {
        (self.state, self.balance, self.statistics)
    }

    fn begin(&mut self, _: &mut dyn Observer) -> Result<bool> {
        Ok(false)
    }

    fn advance(&mut self, observer: &mut dyn Observer) -> Result<u32> {
        if observer.interrupted() {
            return Err(Error::Interrupted);
        }
        self.provide_piece()?;
        let Some(piece) = &self.piece else { return Ok(0) };
        let next = piece.next_point(self.position(), self.limit);
        self.go_to(next, observer);
        if self.is_finished() && self.piece.as_ref().is_some_and(Piece::has_run_out) {
            observer.on_warning(&format!(
                "the path ends after {} expansion(s) (`max_expansions`) at load factor {:.6}, before it has reached load factor {}",
                self.options.max_expansions, self.state.time, self.options.end_load
            ));
        }
        if self.is_finished() {
            self.warn_of_missed_loads(observer);
        }
        Ok(0)
    }

    fn repeat(&mut self, start: &State, end: f64) {
        self.state.clone_from(start);
        if !self.reactions.is_empty() {
            self.reactions = reactions(self.system, self.expansion.assembly(), &self.state);
        }
        self.balance = statics::energies(self.system, self.expansion.assembly(), &self.state);
        self.statistics.steps = self.state.step;
        self.limit = end;
    }

    fn release(&mut self) {
        self.limit = f64::INFINITY;
    }

    fn watch(&mut self, watched: &Watched) {
        self.state.watched.clone_from(watched);
    }
}
