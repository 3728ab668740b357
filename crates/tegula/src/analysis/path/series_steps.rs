//! Steps of a path by power series: from one reported point of a piece to the next.

use super::expansion::Expansion;
use super::piece::{Piece, Start};
use super::start::{hold_mechanisms, in_equilibrium};
use super::state::{ExpansionPoint, PathState, ended_early, not_continued};
use super::{first_state, scope};
use crate::analysis::bending_watch::BendingWatch;
use crate::analysis::statics::{self, reactions};
use crate::analysis::stepper::Reached;
use crate::analysis::{Balance, Observer, State, Statistics, Stepper, Watched};
use crate::element::{Motion, Nodal};
use crate::model::PathAnalysis;
use crate::norm::larger;
use crate::system::assembly::add_follower_loads;
use crate::system::fields::dot;
use crate::system::{System, inverted_element};
use crate::{Error, Result};

/// A path between two of its points.
pub struct SeriesSteps<'a> {
    system: &'a System,
    options: &'a PathAnalysis,
    expansion: Expansion,
    /// Present piece; `None` before the first one, and in a run that is resumed.
    piece: Option<Piece>,
    /// Where the last piece was begun.
    begun: Option<ExpansionPoint>,
    /// Whether the last piece was not found because it was to go over to a crossing path with a wanted load factor too near.
    wanted_too_near: bool,
    state: State,
    balance: Balance,
    statistics: Statistics,
    /// Path parameter at which the next step ends at the latest.
    limit: f64,
    /// Displacements of a point that is looked at.
    trial: Vec<Nodal>,
    bending: BendingWatch,
}

impl<'a> SeriesSteps<'a> {
    /// Path from `start`, a state of the same analysis, or from its first state.
    ///
    /// # Errors
    /// The model has no power series, or there is not enough memory.
    pub fn new(system: &'a System, options: &'a PathAnalysis, start: Option<State>) -> Result<Self> {
        let stresses = scope::stresses(system, options.order as usize)
            .map_err(|reason| Error::Model(vec![scope::without_series(&reason)]))?;
        let state = start.filter(|state| state.path.is_some()).unwrap_or_else(|| first_state(system));
        let mut expansion = Expansion::new(system, stresses)?;
        Ok(Self {
            balance: statics::energies(system, expansion.assembly(), &state),
            statistics: Statistics { steps: state.step, ..Statistics::default() },
            trial: state.u.clone(),
            limit: f64::INFINITY,
            bending: BendingWatch::new(),
            piece: None,
            begun: None,
            wanted_too_near: false,
            system,
            options,
            expansion,
            state,
        })
    }

    /// Makes sure that the present piece leads on from the state.
    ///
    /// # Errors
    /// There is no piece that leads on; the text gives the reason.
    pub(super) fn provide_piece(&mut self) -> std::result::Result<(), String> {
        let Some(path) = self.path() else { return Ok(()) };
        let (position, recorded) = (path.position, path.expansion.clone());
        if position == 0.0 && self.piece.is_none() {
            in_equilibrium(self.system, self.expansion.assembly(), &self.state, 0.0)?;
        }
        while !self.piece.as_ref().is_some_and(|piece| piece.leads_on_from(position)) {
            let goes_on = self.piece.as_mut().filter(|piece| position == piece.end_position());
            let start = match goes_on.and_then(Piece::next_start) {
                Some(start) => start,
                // The piece of a run that is resumed or repeated is found anew; the state may be the end of it.
                None => Start::new(self.system, &mut self.expansion, (recorded.clone(), self.options))?,
            };
            self.begun = Some(start.point().clone());
            self.piece = Some(self.find_piece(start)?);
        }
        Ok(())
    }

    fn find_piece(&mut self, start: Start) -> std::result::Result<Piece, String> {
        let last = self.path().and_then(|path| path.critical.last());
        let beside = last.is_some_and(|point| point.is_bifurcation_beside(start.point().load));
        let piece = Piece::new(self.system, &mut self.expansion, (start, beside), self.options);
        self.statistics.factorizations = self.expansion.factorizations();
        self.wanted_too_near = piece.as_ref().is_err_and(|failed| failed.wanted_too_near);
        piece.map_err(|failed| failed.reason)
    }

    /// Whether the path has no series at its start.
    pub(super) fn has_none_at_start(&self) -> bool {
        self.position() == 0.0 && !self.wanted_too_near
    }

    /// Point from which no piece led on: at the end of the last piece, or on the path that crosses there.
    pub(super) fn end_of_series(&self) -> Option<&ExpansionPoint> {
        self.begun.as_ref().filter(|point| point.position == self.position() && !point.direction.is_empty())
    }

    /// System, options, state, run counters, and the position at which the next step ends at the latest.
    pub(super) fn parts(&self) -> (&'a System, &'a PathAnalysis, &State, &Statistics, f64) {
        (self.system, self.options, &self.state, &self.statistics, self.limit)
    }

    fn path(&self) -> Option<&PathState> {
        self.state.path.as_deref()
    }

    /// Goes to the parameter `a` of the present piece.
    fn go_to(&mut self, a: f64, observer: &mut dyn Observer) {
        let Self { system, options, state, trial, piece, expansion, .. } = self;
        let Some(piece) = piece else { return };
        let begins =
            state.path.as_ref().is_some_and(|path| path.expansion.position != piece.start().position);
        if begins {
            // A piece begins next to the end of the one before: on the corrected path, or at a bifurcation on the crossing one.
            let ExpansionPoint { u, load, .. } = piece.start();
            state.work += statics::follower_work(system, (&state.u, state.time), (u, *load), trial);
        }
        piece.displacements(system, a, &mut state.u);
        state.time = piece.load(a);
        state.multipliers = expansion.multipliers(system, &state.u, state.time);
        state.step += 1;
        let Some(path) = &mut state.path else { return };
        let from = path.position;
        path.position = piece.position_of(a);
        if begins || path.expansion.u.is_empty() {
            path.expansion = piece.start().clone();
        }
        path.direction.resize(state.u.len(), [0.0; 3]);
        piece.series().direction(a, &mut path.direction);
        path.load_rate = piece.series().load_derivative(a, 1);
        path.loads = [path.loads[0].min(state.time), larger(path.loads[1], state.time)];
        for found in piece.passed(from, path.position) {
            path.pass((system, options), found, piece.negative_at(found.position), observer);
        }
        path.finished |= piece.is_last() && path.position >= piece.end_position();
        state.negative_pivots = piece.negative_at(path.position);
        if !(system.dofs().prescribed.is_empty() && system.followers.is_empty()) {
            state.work +=
                work_of_motions_and_pressures((system, expansion), piece, [from, path.position], trial);
        }
        if state.step == 1 {
            expansion.redundant(system).for_each(|message| observer.on_warning(&message));
        }
        self.bending.look(system, &state.u, observer, || format!("load factor {}", state.time));
        self.statistics.steps = state.step;
        self.balance = statics::energies(system, expansion.assembly(), state);
    }
}

impl Stepper for SeriesSteps<'_> {
    fn reached(&self) -> Reached<'_> {
        let Self { state, balance, statistics, .. } = self;
        Reached { state, balance, statistics, end: self.options.end_load }
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
        self.provide_piece().map_err(|reason| not_continued(self.system, &self.state, &reason))?;
        let Some(piece) = &self.piece else { return Ok(0) };
        let next = piece.next_point(self.position(), self.limit);
        piece.series().displacements(next, &mut self.trial);
        if let Some(inverted) = inverted_element(self.system, &self.trial) {
            return Err(not_continued(self.system, &self.state, &inverted));
        }
        self.go_to(next, observer);
        hold_mechanisms(self.system, &self.state)?;
        if self.is_finished() && self.piece.as_ref().is_some_and(Piece::has_run_out) {
            ended_early(&self.state, self.options, observer);
        }
        Ok(0)
    }

    fn repeat(&mut self, start: &State, end: f64) {
        self.state.clone_from(start);
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

/// Abscissas on (−1, 1) and weights of Gauss's rule of three points.
const GAUSS: [(f64, f64); 3] =
    [(-0.774_596_669_241_483_4, 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)];
/// Parts of a piece over which work is integrated.
const PARTS: f64 = 8.0;

/// Work of the reactions on prescribed motions, and of pressures, between two positions of a piece. `u` is scratch space.
fn work_of_motions_and_pressures(
    (system, expansion): (&System, &mut Expansion),
    piece: &Piece,
    [from, to]: [f64; 2],
    u: &mut [Nodal],
) -> f64 {
    let length = piece.end_position() - piece.start().position;
    let parts = (PARTS * (to - from) / length).ceil().clamp(1.0, PARTS);
    let (half, start) = (0.5 * (to - from) / parts, from - piece.start().position);
    let mut state = State { u: u.to_vec(), ..State::default() };
    let mut pressure = vec![[0.0; 3]; u.len()];
    let mut work = 0.0;
    for part in 0..parts as u32 {
        for (x, weight) in GAUSS {
            let a = start + half * (2.0 * f64::from(part) + 1.0 + x);
            piece.series().displacements(a, &mut state.u);
            state.time = piece.series().load(a);
            piece.series().direction(a, u);
            let mut power = 0.0;
            if !system.dofs().prescribed.is_empty() {
                state.multipliers = expansion.multipliers(system, &state.u, state.time);
                let forces = reactions(system, expansion.assembly(), &state);
                power += system.product_of_prescribed(&forces, u);
            }
            if !system.followers.is_empty() {
                pressure.fill([0.0; 3]);
                let motion = Motion::State { u: &state.u, velocity: None };
                add_follower_loads(system, &motion, state.time, 1.0, &mut pressure);
                power += dot(&pressure, u);
            }
            work += half * weight * power;
        }
    }
    work
}
