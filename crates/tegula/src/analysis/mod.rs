//! Analyses: statics, linear buckling, natural frequencies, transient dynamics.

mod bending_watch;
pub mod buckling;
mod circulatory;
mod constraints;
mod copies;
pub mod direct;
mod drilling;
pub mod dynamics;
pub mod equilibrium;
pub mod lagged_tangent;
mod mobility;
pub mod modal;
pub mod newton;
pub mod path;
mod potential;
pub mod solver;
pub mod statics;
pub mod stepper;
pub mod stop_condition;
pub mod stops;
mod unstable_modes;

use std::collections::HashSet;

use serde::{Deserialize, Serialize};

use crate::Result;
use crate::constraint::CoordinateState;
use crate::element::{Motion, Nodal};
use crate::system::dof_map::CONSTRAINED;
use crate::system::{EvaluationPoint, Internal, StepStart, System, VectorKind};
pub use direct::solve_by;
use lagged_tangent::LaggedTangent;
pub use newton::Stability;
pub use stepper::Stepper;
pub use stop_condition::{Stopped, Watched};

/// State of a model at a time: plain data, which serde writes and reads; a checkpoint is its dump.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Time (load factor in statics).
    pub time: f64,
    /// Number of the last finished step.
    pub step: u64,
    /// Displacements of the nodal vectors.
    pub u: Vec<Nodal>,
    /// Velocities; empty in statics.
    pub v: Vec<Nodal>,
    /// Accelerations; empty in statics.
    pub a: Vec<Nodal>,
    /// Mean accelerations of the last finished time step of a nonlinear model, from which the next one is predicted;
    /// empty before the first step and for other analyses.
    pub mean_a: Vec<Nodal>,
    /// Velocities from which the next time step starts, where they are not `v`: those of composed steps have parts across the
    /// constraints, which belong to the energy that the scheme conserves.
    #[serde(default)]
    pub scheme_v: Vec<Nodal>,
    /// Difference between the auxiliary accelerations of the generalised-α method and the accelerations, over the time step; empty
    /// before its first step and for other schemes.
    #[serde(default)]
    pub acceleration_lag: Vec<Nodal>,
    /// Mean velocities and mean accelerations of the last finished step of BDF2; empty at its start, behind a jump of the velocities, and
    /// for other schemes.
    #[serde(default)]
    pub mean_rates: [Vec<Nodal>; 2],
    /// Mean loads of the last finished step of BDF2; empty at its start and for other schemes.
    #[serde(default)]
    pub mean_loads: Vec<Nodal>,
    /// Loads in the equation of motion at the end of the last finished step of BDF2, which are not those of this time; empty at its start,
    /// behind a jump of the velocities, and for other schemes.
    #[serde(default)]
    pub scheme_loads: Vec<Nodal>,
    /// Enhanced parameters and internal variables of the materials.
    pub history: Vec<f64>,
    /// Lagrange multipliers of the constraints of joints, in the order of the joints.
    #[serde(default)]
    pub multipliers: Vec<f64>,
    /// Displacements in the middle of the last step, where the multipliers of the energy–momentum scheme of second order act and its
    /// accelerations turn bodies; empty for other schemes, at the start, and for models without joints and bodies. They are not stored: reactions of a state that was read are in the configuration at its end.
    #[serde(default, skip)]
    pub middle: Vec<Nodal>,
    /// Angles of sensors, and behind them the first angles of gears (rad), continued over full turns.
    #[serde(default)]
    pub angles: Vec<f64>,
    /// Relative coordinates of the joints with friction or stops, in the order of the joints.
    #[serde(default)]
    pub coordinates: Vec<CoordinateState>,
    /// Length of the next time step (load step).
    pub next_step: f64,
    /// Length of the last finished time step; 0 at the start.
    pub last_step: f64,
    /// Work of loads other than constant gravity since the start.
    pub work: f64,
    /// Energy dissipated by damping since the start.
    pub dissipated: f64,
    /// Largest energy so far: scale of the convergence test.
    pub energy_scale: f64,
    /// Swing term of explicit steps, ⅛ Δt² a·M a: part of the energy that oscillates about the conserved one, summed
    /// over the steps.
    pub swing: f64,
    /// Largest displacement of a static equilibrium so far ([`System::norm`]): scale of the convergence test.
    pub displacement_scale: f64,
    /// Whether the last static equilibrium was found with the form of Newton's method that is not the default one for
    /// the materials.
    pub other_form: bool,
    /// Norm of the response to the loads at the start of the last static step, over the step's length.
    pub compliance: f64,
    /// Negative pivots of the tangent at the last static equilibrium: above 0 it is unstable, unless follower loads
    /// stabilise it.
    pub negative_pivots: usize,
    /// Lagged tangent, whose factor is reused in several time steps.
    pub tangent: LaggedTangent,
    /// Place on an equilibrium path; `None` for other analyses.
    #[serde(default)]
    pub path: Option<Box<path::PathState>>,
    /// Columns of the stop conditions, and the condition that has been met.
    #[serde(default)]
    pub watched: Watched,
}

/// Displacement over the size of the model, and velocity over the largest one, of a support that is round-off.
const AT_SUPPORT: f64 = 1e-9;
/// Distance of an inextensible director from one of unit length that is round-off.
const OFF_UNIT: f64 = 1e-6;

impl State {
    /// First state of an analysis step: where the step before has ended, or the reference configuration at rest.
    pub fn first(system: &System) -> Self {
        match &system.start {
            None => Self::at_rest(system),
            Some(start) => {
                let StepStart { u, v, history, multipliers, angles, coordinates, .. } = start.clone();
                Self { u, v, history, multipliers, angles, coordinates, ..Self::default() }
            }
        }
    }

    /// Reference configuration at rest.
    pub fn at_rest(system: &System) -> Self {
        let history = system.groups.iter().map(|g| g.len() * g.history_per_element()).sum();
        Self {
            u: vec![[0.0; 3]; system.vectors()],
            history: vec![0.0; history],
            multipliers: vec![0.0; system.constraints()],
            angles: vec![0.0; system.number_of_angles()],
            ..Self::default()
        }
    }

    /// State without loads about which a model vibrates: the reference configuration at rest, or the position in which it is assembled.
    pub fn unloaded(system: &System) -> Self {
        if system.continues() { Self::at_rest(system) } else { Self::first(system) }
    }

    /// Velocities that the time integration scheme carries along, whose kinetic energy it accounts for.
    pub fn velocities_of_scheme(&self) -> &[Nodal] {
        if self.scheme_v.is_empty() { &self.v } else { &self.scheme_v }
    }

    /// History variables and multipliers.
    pub fn internal(&self) -> Internal<'_> {
        Internal { history: &self.history, multipliers: &self.multipliers }
    }

    /// Evaluation point of the displacements, without rates.
    pub fn point<'a>(&'a self, system: &System) -> EvaluationPoint<'a> {
        EvaluationPoint::at_rest(system, &self.u, self.time, self.internal())
    }

    /// Evaluation point of the displacements and velocities.
    pub fn point_with_rates<'a>(&'a self, system: &System) -> EvaluationPoint<'a> {
        let velocity = (!self.v.is_empty()).then_some(self.v.as_slice());
        EvaluationPoint::new(system, Motion::State { u: &self.u, velocity }, self.time, self.internal())
    }

    /// Nodal vector of the state that moves where a system holds it, or is elsewhere than the system prescribes; `None` where there is none.
    pub fn moved_support(&self, system: &System) -> Option<usize> {
        let (frames, dofs) = (&system.frames, system.dofs());
        let mut prescribed = self.u.clone();
        system.prescribe(self.time, &mut prescribed);
        let fastest = self.v.as_flattened().iter().fold(0.0, |most, x| crate::norm::larger(most, x.abs()));
        let given: HashSet<u32> = dofs.prescribed.iter().map(|p| p.dof).collect();
        let turns = |v: usize| dofs.unit.iter().any(|unit| unit.vector as usize == v);
        (0..self.u.len()).filter(|v| !dofs.is_carried(*v) && !turns(*v)).find(|&v| {
            let apart =
                (0..3).any(|i| !((prescribed[v][i] - self.u[v][i]).abs() <= AT_SUPPORT * system.length));
            let at = frames.to_local(v, self.u[v]);
            let speed = frames.to_local(v, self.v.get(v).copied().unwrap_or_default());
            let fixed = |c: usize| dofs.of(v)[c] == CONSTRAINED && !given.contains(&((3 * v + c) as u32));
            let moves = |c: usize| {
                !(at[c].abs() <= AT_SUPPORT * system.length && speed[c].abs() <= AT_SUPPORT * fastest)
            };
            apart || (0..3).any(|c| fixed(c) && moves(c))
        })
    }

    /// Nodal vector of the state that is an inextensible director or one of a body, and is not of unit length or not perpendicular to the others of its
    /// body; `None` where there is none.
    pub fn distorted_director(&self, system: &System) -> Option<usize> {
        let mut projected = self.u.clone();
        dynamics::project_unit_vectors(system, &mut projected);
        let apart = |v: usize| (0..3).any(|i| !((projected[v][i] - self.u[v][i]).abs() <= OFF_UNIT));
        (0..self.u.len()).find(|&v| system.coordinates.kinds[v] == VectorKind::Director && apart(v))
    }

    /// First array whose length is not that of a system, by its name; `None` where the state fits.
    pub fn misfit(&self, system: &System) -> Option<&'static str> {
        let n = system.vectors();
        let history = system.groups.iter().map(|g| g.len() * g.history_per_element()).sum();
        let (s, t) = (self, &self.tangent);
        let lengths = [
            ("u", s.u.len(), n),
            ("history", s.history.len(), history),
            ("multipliers", s.multipliers.len(), system.constraints()),
            ("angles", s.angles.len(), system.number_of_angles()),
            ("tangent u", if t.valid { t.u.len() } else { n }, n),
            ("tangent history", if t.valid { t.history.len() } else { history }, history),
        ];
        let maybe_empty = [
            ("v", s.v.len()),
            ("a", s.a.len()),
            ("mean a", s.mean_a.len()),
            ("scheme v", s.scheme_v.len()),
            ("acceleration lag", s.acceleration_lag.len()),
            ("mean velocities", s.mean_rates[0].len()),
            ("mean accelerations", s.mean_rates[1].len()),
            ("mean loads", s.mean_loads.len()),
            ("scheme loads", s.scheme_loads.len()),
            ("middle", s.middle.len()),
            ("tangent v", t.v.len()),
        ];
        let optional = maybe_empty.into_iter().filter(|(_, length)| *length > 0);
        let mut all = lengths.into_iter().chain(optional.map(|(name, length)| (name, length, n)));
        all.find(|(_, length, expected)| length != expected).map(|(name, ..)| name)
    }

    /// Displacements, velocities, history variables, multipliers and angles of sensors from which the next analysis step starts.
    pub fn end_of_step(&self) -> StepStart {
        let Self { time, u, v, history, multipliers, angles, coordinates, .. } = self.clone();
        let path = self.path.as_ref().map(|path| path.before(self.negative_pivots)).unwrap_or_default();
        StepStart { time, path, u, v, history, multipliers, angles, coordinates }
    }
}

/// Energies and momenta at the end of a step.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Balance {
    /// ½ v·M v.
    pub kinetic: f64,
    /// Strain energy.
    pub strain: f64,
    /// Potential of gravity, 0 at the start; in statics that of all loads of constant direction, −F·u.
    pub potential: f64,
    /// Work of all other loads, of actuators, of prescribed motions and of prescribed strains that change with time since the start;
    /// in statics of follower loads, actuators and prescribed motions.
    pub work: f64,
    /// Energy dissipated since the start.
    pub dissipated: f64,
    /// kinetic + strain + potential + dissipated − work: constant in time for an exact integration; in statics
    /// strain energy less the work of all loads and prescribed motions, the potential that equilibrium makes stationary.
    pub total: f64,
    /// Linear momentum.
    pub momentum: [f64; 3],
    /// Angular momentum about the origin.
    pub angular_momentum: [f64; 3],
}

/// Run counters of an analysis.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Statistics {
    /// Finished steps.
    pub steps: u64,
    /// Iterations, including those of repeated steps.
    pub iterations: u64,
    /// Numerical factorisations.
    pub factorizations: u64,
    /// Cut-backs: steps repeated with a smaller length.
    pub cutbacks: u64,
    /// Iterations of the iterative linear solver, and solves for the circulatory stiffness of follower loads; 0 with
    /// the direct solver and without such loads.
    pub linear_iterations: u64,
    /// Latest lower bound of the critical time step of an explicit scheme (time); 0 for others.
    pub critical_step: f64,
    /// Largest error of the energy balance of an explicit scheme, over the largest kinetic or strain energy (of this
    /// run, if it was resumed); 0 for others.
    pub energy_error: f64,
}

/// Finished step, as reported to observers.
#[derive(Debug)]
pub struct Step<'a> {
    /// State at the end of the step.
    pub state: &'a State,
    /// Energies and momenta at the end of the step.
    pub balance: &'a Balance,
    /// Run counters so far.
    pub statistics: &'a Statistics,
    /// Iterations of this step.
    pub iterations: u32,
    /// Time at which the analysis ends.
    pub end: f64,
}

/// Observer of an analysis: progress, writers, probes.
pub trait Observer {
    /// Receives a finished step.
    ///
    /// # Errors
    /// Ends the analysis ([`Error::Interrupted`](crate::Error::Interrupted) on request of the user).
    fn on_step(&mut self, step: &Step) -> Result<()>;
    /// Receives a finished iteration: its number, energy of the increment over the energy scale, size of the increment.
    fn on_iteration(&mut self, _iteration: u32, _energy: f64, _increment: f64) {}
    /// Receives the course of a search for modes: the number found of those wanted, and that of the basis vectors.
    fn on_modes(&mut self, _found: usize, _wanted: usize, _vectors: usize) {}
    /// Receives a failed step, which is cut back or given up: run counters so far, this attempt included.
    fn on_repeat(&mut self, _statistics: &Statistics) {}
    /// Receives a message of interest to the user (a cut-back, stagnation at round-off).
    fn on_event(&mut self, _message: &str) {}
    /// Receives a warning: results may not be what the user expects.
    fn on_warning(&mut self, message: &str) {
        self.on_event(message);
    }
    /// Value of a column of the history at the end of a step, which may be repeated and is not reported yet: stop conditions depend on
    /// it. `None` where there is no such column.
    fn column(&mut self, _name: &str, _step: &Step) -> Option<f64> {
        None
    }
    /// Stop request, asked between iterations; true ends the analysis after the last finished step.
    fn interrupted(&self) -> bool {
        false
    }
}

/// Observer that ignores everything.
#[derive(Debug, Default, Clone, Copy)]
pub struct Silent;

impl Observer for Silent {
    fn on_step(&mut self, _step: &Step) -> Result<()> {
        Ok(())
    }
}
