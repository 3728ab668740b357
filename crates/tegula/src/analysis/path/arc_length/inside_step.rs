//! Equilibria inside a step, and its critical points.
//!
//! A trial begins at the nearest equilibrium that is known and goes along the direction there: next to a critical point the tangent is nearly
//! singular, and an iteration that begins farther away may end on another path.

use super::{ArcLengthSteps, ArcStart, End, Plane};
use crate::analysis::Observer;
use crate::analysis::path::critical_points::{Curve, Found, INVERSE_ITERATIONS, Trial};
use crate::analysis::path::state::{CriticalKind, CriticalPoint};
use crate::analysis::statics::StaticEquation;
use crate::system::add_multiple;

/// Change of the load factor over it that still separates a point from the limit point.
const AT_LIMIT: f64 = 1e-10;
/// Largest number of trials for a limit point.
const MOST_TRIALS: usize = 30;
/// Distance of a trial from the nearest equilibrium over that along the step, and over the length of the step, above which it lies on another path.
const FAR: [f64; 2] = [2.0, 0.05];

/// Known equilibria of a step: its start and end, and trials.
pub(super) struct Known(Vec<End>);

impl Known {
    /// Start and end of a step.
    pub fn new(steps: &ArcLengthSteps, arc: &ArcStart, end: &End) -> Self {
        let state = &steps.state;
        let equation = StaticEquation {
            u: state.u.clone(),
            multipliers: state.multipliers.clone(),
            time: state.time,
            ..StaticEquation::default()
        };
        let (tangent, negative) = (arc.tangent.clone(), state.negative_pivots);
        Self(vec![End { a: 0.0, equation, tangent, negative, iterations: 0 }, end.clone()])
    }

    fn ends(&self) -> [&End; 2] {
        [&self.0[0], &self.0[1]]
    }

    fn add(&mut self, trial: End) {
        self.0.push(trial);
    }

    fn nearest(&self, a: f64) -> &End {
        let nearer = |p: &&End, q: &&End| (p.a - a).abs().total_cmp(&(q.a - a).abs());
        self.0.iter().min_by(nearer).unwrap_or(&self.0[0])
    }
}

impl ArcLengthSteps<'_> {
    /// Equilibrium of a step at the distance `a` from its start, from the nearest known one.
    pub(super) fn equilibrium_near(
        &mut self,
        known: &Known,
        a: f64,
        observer: &mut dyn Observer,
    ) -> std::result::Result<End, String> {
        let ([start, end], near) = (known.ends(), known.nearest(a));
        self.go_back();
        let Self { equation, system, .. } = self;
        equation.u.clone_from(&near.equation.u);
        equation.multipliers.clone_from(&near.equation.multipliers);
        equation.time = near.equation.time;
        let normal = &start.tangent.direction;
        let length = (a - near.a) / system.inner_product(normal, &near.tangent.direction);
        let plane = Plane { origin: &start.equation.u, normal, distance: a };
        let iterations = self.correct((&near.tangent, length), &plane, observer)?;
        let mut moved = self.equation.u.clone();
        add_multiple(&mut moved, -1.0, &near.equation.u);
        if !(self.system.norm(&moved) <= FAR[0] * length.abs() + FAR[1] * end.a) {
            return Err("an equilibrium between the ends of the step lies on another path".into());
        }
        self.end_at(a, &start.tangent, iterations)
    }

    /// Limit point of a step by the secant of the derivative of the load factor, kept in a bracket, from a first estimate.
    pub(super) fn locate_limit(
        &mut self,
        known: &mut Known,
        estimate: f64,
        observer: &mut dyn Observer,
    ) -> std::result::Result<End, String> {
        let [start, end] = known.ends();
        let rises = start.tangent.load > 0.0;
        let (mut low, mut high) = ((0.0, start.tangent.load), (end.a, end.tangent.load));
        let (mut at, mut before) = (estimate, None::<(f64, f64)>);
        for _ in 0..MOST_TRIALS {
            let found = self.equilibrium_near(known, at, observer)?;
            let here = (at, found.tangent.load);
            let other = before.unwrap_or(if (here.1 > 0.0) == rises { high } else { low });
            let slope = (here.1 - other.1) / (here.0 - other.0);
            let rest = 0.5 * here.1 * here.1 / slope.abs();
            if rest <= AT_LIMIT * found.equation.time.abs() {
                return Ok(found);
            }
            if (here.1 > 0.0) == rises {
                low = here
            } else {
                high = here
            }
            let secant = at - here.1 / slope;
            before = Some(here);
            known.add(found);
            at = if secant > low.0 && secant < high.0 { secant } else { 0.5 * (low.0 + high.0) };
        }
        Err("the limit point in the step was not located".into())
    }

    /// Limit point at the end of a step, behind which the step is taken to end.
    pub(super) fn limit_point(&self, arc: &ArcStart, end: &mut End) -> Found {
        let change = if arc.tangent.load * end.tangent.work > 0.0 { 1 } else { -1 };
        if (end.tangent.load > 0.0) == (arc.tangent.load > 0.0) {
            // The pivots are those before the point.
            end.negative = (end.negative as i32 + change).max(0) as usize;
            end.tangent.load = -end.tangent.load;
        }
        let point = CriticalPoint {
            kind: CriticalKind::Limit,
            load: end.equation.time,
            position: 0.0,
            change,
            u: end.equation.u.clone(),
            mode: end.tangent.direction.clone(),
        };
        Found { a: end.a, point }
    }
}

/// Path of an arc-length step.
pub(super) struct PathCurve<'s, 'a, 'o> {
    pub steps: &'s mut ArcLengthSteps<'a>,
    pub known: &'s mut Known,
    pub observer: &'o mut dyn Observer,
}

impl Curve for PathCurve<'_, '_, '_> {
    fn trial(&mut self, a: f64) -> std::result::Result<Trial, String> {
        let end = self.steps.equilibrium_near(self.known, a, self.observer)?;
        let ArcLengthSteps { newton, system, response, .. } = &mut *self.steps;
        let mut softest = newton.eigenvalue_next_to_zero(system, &end.equation, INVERSE_ITERATIONS)?;
        system.orient(&mut softest.1);
        let work = response.relative_work(system, &softest.1);
        let (u, load, negative) = (end.equation.u.clone(), end.equation.time, end.negative);
        self.known.add(end);
        Ok(Trial { u, load, negative, softest, work })
    }
}
