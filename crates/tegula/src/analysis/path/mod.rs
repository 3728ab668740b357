//! Equilibrium paths: all equilibria under loads that depend on a load factor, through limit points, by power series or the arc-length
//! method.
//!
//! **Power series.** Strains that are quadratic in the nodal vectors and linear materials make equilibrium a polynomial equation, and its path an
//! analytic curve. At a point of the path one factorisation of the tangent gives displacements and load factor as power series in the
//! path parameter (asymptotic numerical method). The series holds up to a length that its last term tells; there the
//! next one begins. Nothing is iterated and no step length is guessed, and what lies between the ends of a step is known as a
//! polynomial: reported points, wanted load factors, limit points and the end of the path are evaluated from it. Inextensible directors,
//! bodies, beams and joints add quadratic constraints with multipliers, which are power series, too, as are pressures and the lengths of springs.
//!
//! **Arc-length method.** Of models whose equilibrium is no polynomial, with bushings, driven joints, nonlinear materials or other follower
//! loads, Newton's method finds the next equilibrium on a plane across the path, with the load factor as an unknown. It
//! goes on, too, where power series lead no further, unless these are asked for.

mod arc_length;
mod branch;
mod critical_points;
mod crossing;
mod directors;
mod expansion;
mod geometric;
mod hand_over;
mod joint_series;
mod opposite_crossings;
mod piece;
mod pressure_series;
mod scope;
mod series;
mod series_steps;
mod start;
mod state;

pub use arc_length::ArcLengthSteps;
pub use series_steps::SeriesSteps;
pub use state::{ArcStart, CriticalKind, CriticalPoint, ExpansionPoint, PathState};

use super::{Balance, Observer, State, Statistics, Stepper, Stopped, stepper};
use crate::error::Issue;
use crate::model::{PathAnalysis, PathMethod};
use crate::system::{Procedure, System};
use crate::{Error, Result};
pub(in crate::analysis) use critical_points::INVERSE_ITERATIONS;
pub(in crate::analysis) use hand_over::{Advance, BeforeArcLength, HandOver};

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

/// Why a path cannot be followed with its options; `None` where it can.
pub fn outside_of_scope(system: &System, options: &PathAnalysis) -> Option<Issue> {
    scope::method(system, options).err()
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
/// The method wanted does not suit the model, or the path cannot be continued; the error names the load factor reached. The observer
/// does not know the column of a stop condition.
pub fn run(
    system: &System,
    options: &PathAnalysis,
    start: Option<State>,
    observer: &mut dyn Observer,
) -> Result<PathOutcome> {
    let fresh = start.is_none();
    let (mut steps, why) = steps(system, options, start)?;
    if let Some(reason) = why.filter(|_| fresh) {
        observer.on_event(&format!(
            "the path is followed by the arc-length method, as it has no power series: {reason}; `order`, `tolerance` and `points` are \
             keys of power series"
        ));
    }
    let stopped = stepper::run(steps.as_mut(), &options.stop, observer)?;
    let (state, balance, statistics) = steps.finish();
    if let Some(path) = &state.path {
        path.warn_of_what_was_missed(system, options, observer);
    }
    Ok(PathOutcome { state, balance, statistics, stopped })
}

/// Steps of a path from `start`, a state of the same analysis (from its first state where `None`), and why they are no power series
/// where the method was not given.
///
/// # Errors
/// The method wanted does not suit the model, or there is not enough memory.
pub fn steps<'a>(
    system: &'a System,
    options: &'a PathAnalysis,
    start: Option<State>,
) -> Result<(Box<dyn Stepper + 'a>, Option<String>)> {
    system.require(&[Procedure::Path])?;
    let (method, why) = scope::method(system, options).map_err(|issue| Error::Model(vec![issue]))?;
    let steps: Box<dyn Stepper + 'a> = match method {
        PathMethod::Series if options.method.is_some() => Box::new(SeriesSteps::new(system, options, start)?),
        PathMethod::Series => {
            let by_arc_length =
                start.as_ref().and_then(|state| state.path.as_ref()).is_some_and(|path| path.arc.is_some());
            Box::new(if by_arc_length {
                let steps = Box::new(ArcLengthSteps::new(system, options, start)?);
                HandOver::ArcLength { steps, begun: None }
            } else {
                HandOver::Before(Box::new(SeriesSteps::new(system, options, start)?))
            })
        }
        PathMethod::ArcLength => Box::new(ArcLengthSteps::new(system, options, start)?),
    };
    Ok((steps, why))
}
