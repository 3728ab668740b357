//! Equilibria inside a step, and its critical points.
//!
//! A trial begins at the nearest equilibrium that is known and goes along the direction there: next to a critical point the tangent is nearly
//! singular, and an iteration that begins farther away may end on another path.

use super::limits::EigenvalueCount;
use super::{ArcLengthSteps, ArcStart, End, Plane, TOLERANCES, TURN};
use crate::analysis::Observer;
use crate::analysis::newton::{PathTangent, TangentPart};
use crate::analysis::path::critical_points::{Curve, Found, INVERSE_ITERATIONS, Trial, bifurcations};
use crate::analysis::path::crossing::refuse_fold_of_other_path;
use crate::analysis::path::state::{CriticalKind, CriticalPoint};
use crate::analysis::statics::StaticEquation;
use crate::norm::larger;
use crate::system::add_multiple;

/// Change of the load factor over it that still separates a point from the limit point; in mechanisms, whose constraints depend on each other in the dead
/// centre.
const AT_LIMIT: f64 = 1e-10;
const AT_DEAD_CENTRE: f64 = 1e-8;
/// Largest number of trials for a limit point.
const MOST_TRIALS: usize = 30;
/// Largest distance of a trial from the nearest known equilibrium on the same path: twice that along the step and a twentieth of the step.
const FAR: [f64; 2] = [2.0, 0.05];

/// Newton's method at constant load may move at most [`REST`] times the distance that the tangent predicts and this part of the length of the step; it
/// begins from at most [`MOST_NEARER`] equilibria.
const NEAR: f64 = 1e-4;
const REST: f64 = 3.0;
const MOST_NEARER: usize = 6;

/// Length of a step in which a zero of the symmetric part need not be found: next to it the unsymmetric tangent may be singular.
pub(super) const SHORT: f64 = 1e-3;

/// Change of the load factor over its size, within which two bifurcations need not be told apart: shorter steps come too near to both of them.
const TOGETHER: f64 = 2e-4;

/// Work of the loads on the direction at an extremum of the load factor, over that at the ends of the step, below which it is none: the direction is
/// the mode of a bifurcation.
const CROSSING: f64 = 1e-2;

/// Work of the loads on the mode at a bifurcation, over that on the direction of the path, that may be round-off.
const WORK: f64 = 1e-4;

/// This work up to which paths cross, but for round-off: with a larger one of an imperfection, the eigenvalue of a path that nearly crosses another one
/// does not become less than about its power 2/3.
const PERFECT: f64 = 1e-9;

/// Known equilibria of a step: its start and end, and trials.
pub(super) struct Known(Vec<End>);

impl Known {
    /// Start, with its negative eigenvalues, and end of a step.
    pub fn new(steps: &ArcLengthSteps, (arc, negative): (&ArcStart, usize), end: &End) -> Self {
        let state = &steps.state;
        let equation = StaticEquation {
            u: state.u.clone(),
            multipliers: state.multipliers.clone(),
            time: state.time,
            ..StaticEquation::default()
        };
        let tangent = arc.tangent.clone();
        Self(vec![End { a: 0.0, equation, tangent, negative, iterations: 0 }, end.clone()])
    }

    fn ends(&self) -> [&End; 2] {
        [&self.0[0], &self.0[1]]
    }

    pub fn add(&mut self, trial: End) {
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
        // Next to a critical point the direction may be that of the mode.
        let along = system.inner_product(normal, &near.tangent.direction);
        let (tangent, length) =
            if along >= TURN { (&near.tangent, (a - near.a) / along) } else { (&start.tangent, a - near.a) };
        let plane = Plane { origin: &start.equation.u, normal, distance: a };
        let iterations = self.correct((tangent, length), &plane, observer)?;
        self.stays_near(near, FAR[0] * (a - near.a).abs() + FAR[1] * end.a)?;
        self.end_at(a, &start.tangent, iterations)
    }

    /// Refuses an equation that lies farther from an equilibrium than a distance.
    fn stays_near(&self, near: &End, distance: f64) -> std::result::Result<(), String> {
        let mut moved = self.equation.u.clone();
        add_multiple(&mut moved, -1.0, &near.equation.u);
        if self.system.norm(&moved) <= distance {
            Ok(())
        } else {
            Err("an equilibrium between the ends of the step lies on another path".into())
        }
    }

    /// Equilibrium at a load factor, near a distance from the start of the step. Next to a bifurcation Newton's method at this load factor may end on another path: where
    /// its way is longer than the tangent tells, it begins nearer to the load factor.
    pub(super) fn at_load(
        &mut self,
        known: &mut Known,
        (a, load): (f64, f64),
        observer: &mut dyn Observer,
    ) -> std::result::Result<End, String> {
        let length = known.ends()[1].a;
        let mut near = self.equilibrium_near(known, a, observer)?;
        for _ in 0..MOST_NEARER {
            let Self { newton, system, state, equation, statistics, .. } = self;
            equation.time = load;
            newton.restore(system, state, false);
            let solved = newton.solve(system, equation, &state.history, &TOLERANCES, observer);
            statistics.iterations +=
                u64::from(solved.as_ref().map_or_else(|failed| failed.iterations, |s| s.iterations));
            let rest = (load - near.equation.time) / near.tangent.load;
            // Up to a limit point at this load factor the way is twice as long as the tangent tells.
            let far = (REST * rest.abs() + NEAR * length).min(FAR[1] * length);
            let stays = solved.map_err(|failed| failed.reason).and_then(|_| self.stays_near(&near, far));
            let [start, _] = known.ends();
            if stays.is_ok() {
                let mut moved = self.equation.u.clone();
                add_multiple(&mut moved, -1.0, &start.equation.u);
                let a = self.system.inner_product(&start.tangent.direction, &moved);
                return self.end_at(a, &start.tangent, near.iterations);
            }
            let along = self.system.inner_product(&start.tangent.direction, &near.tangent.direction);
            let next = near.a + rest * along;
            if !(next > 0.0 && next < length) {
                return Err(stays.err().unwrap_or_default());
            }
            known.add(near);
            near = self.equilibrium_near(known, next, observer)?;
        }
        Err("the equilibrium at a load factor in the step was not found".into())
    }

    /// End of a step at a load factor, near a distance from its start: [`Self::at_load`], with the direction of the path there where the response to the
    /// loads is none, `tangent` by those at both ends of the step.
    pub(super) fn end_at_load(
        &mut self,
        known: &mut Known,
        place: (f64, f64),
        tangent: PathTangent,
        observer: &mut dyn Observer,
    ) -> std::result::Result<End, String> {
        let mut end = self.at_load(known, place, observer)?;
        if self.system.inner_product(&tangent.direction, &end.tangent.direction) < TURN {
            // Next to a bifurcation the response to the loads is the eigenvector of the eigenvalue that vanishes there.
            let PathTangent { determinant_sign, crossings, .. } = end.tangent;
            end.tangent = PathTangent { determinant_sign, crossings, ..tangent };
        }
        Ok(end)
    }

    /// Limit point of a step by the secant of the derivative of the load factor, kept in a bracket, from a first estimate: an equilibrium next to it, and
    /// its load factor.
    pub(super) fn locate_limit(
        &mut self,
        known: &mut Known,
        estimate: f64,
        observer: &mut dyn Observer,
    ) -> std::result::Result<(End, f64), String> {
        let near = if self.is_driven() { AT_DEAD_CENTRE } else { AT_LIMIT };
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
            if rest <= near * found.equation.time.abs() {
                let limit = found.equation.time + if rises { rest } else { -rest };
                return Ok((found, limit));
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

    /// Whether the motion of joints follows the load factor.
    pub(super) fn is_driven(&self) -> bool {
        self.system.joints.iter().any(|joint| joint.drive.is_some())
    }

    /// Extremum of the load factor at the end of a step, behind which the step is taken to end: a limit point, or a bifurcation that the path
    /// passes as the crossing one.
    ///
    /// # Errors
    /// The linear solver failed, or the extremum does not lie on the path; the text gives the reason.
    pub(super) fn extremum(
        &mut self,
        known: &mut Known,
        (end, load): (&mut End, f64),
        (has_potential, sign): (bool, i8),
        observer: &mut dyn Observer,
    ) -> std::result::Result<Found, String> {
        let ends @ [start, whole] = known.ends();
        let works = ends.map(|end| end.tangent.work.abs());
        let by_sign = !has_potential && sign != 0 && whole.tangent.determinant_sign != 0;
        let work = if by_sign { self.work_on_left_eigenvector(end)? } else { end.tangent.work };
        let crosses = work.abs() <= CROSSING * larger(works[0], works[1]);
        let is_before = (end.tangent.load > 0.0) == (start.tangent.load > 0.0);
        let (kind, change) = match (crosses, start.tangent.load * work > 0.0) {
            (true, _) => (CriticalKind::Bifurcation, 0),
            // In a dead centre a mechanism cannot follow its drive; no eigenvalue vanishes there.
            _ if self.is_driven() && whole.negative == start.negative => (CriticalKind::Limit, 0),
            (false, true) => (CriticalKind::Limit, 1),
            (false, false) => (CriticalKind::Limit, -1),
        };
        if !has_potential {
            // The eigenvalue that vanishes is not one of the symmetric part.
        } else if crosses {
            // An eigenvalue touches zero there.
            end.negative = whole.negative;
        } else if is_before {
            end.negative = (end.negative as i32 + change).max(0) as usize;
        }
        if by_sign {
            // At the extremum the sign that was found is round-off.
            let [first, last] = [sign, whole.tangent.determinant_sign];
            end.tangent.determinant_sign = if change == 0 { first } else { -first };
            end.tangent.crossings = None;
            if end.tangent.determinant_sign != last {
                return Err("there may be two critical points in the step".into());
            }
        }
        if is_before {
            end.tangent.load = -end.tangent.load;
        }
        if crosses {
            self.refuse_fold(known, (end.a, load), observer)?;
        }
        let point = CriticalPoint {
            kind,
            load,
            position: 0.0,
            change,
            u: end.equation.u.clone(),
            mode: end.tangent.direction.clone(),
        };
        Ok(Found { a: end.a, point })
    }
}

impl ArcLengthSteps<'_> {
    /// Refuses an extremum of the load factor, taken for a crossing, that is the fold of a path which nearly crosses that of the step.
    ///
    /// # Errors
    /// As [`refuse_fold_of_other_path`].
    pub(super) fn refuse_fold(
        &mut self,
        known: &mut Known,
        (at, load): (f64, f64),
        observer: &mut dyn Observer,
    ) -> std::result::Result<(), String> {
        let [start, end] = known.ends();
        let (loads, length) = ([start.equation.time, load, end.equation.time], end.a);
        refuse_fold_of_other_path(loads, [at, length], |a| {
            let trial = self.equilibrium_near(known, a, observer)?;
            let load = trial.equation.time;
            known.add(trial);
            Ok(load)
        })
    }
}

/// Limit points of a step and eigenvalues at its start, which explain those at its end.
pub(super) struct Explained<'f> {
    /// Limit points of the step.
    pub limits: &'f [Found],
    /// Eigenvalues of the tangent at its start.
    pub start: EigenvalueCount,
    /// Whether the loads have a potential.
    pub has_potential: bool,
}

impl ArcLengthSteps<'_> {
    /// Bifurcations of a step up to its end, where there are more or less negative eigenvalues than its limit points explain. Without a potential
    /// the eigenvalues are those of the symmetric part of the tangent, and the sign of the determinant tells bifurcations; where it is not found,
    /// a warning says so.
    ///
    /// # Errors
    /// No eigenvalue passes through zero: the step has gone over to another path.
    pub(super) fn other_bifurcations(
        &mut self,
        &Explained { limits, start, has_potential }: &Explained,
        (arc, known): (&ArcStart, &mut Option<Known>),
        end: &End,
        observer: &mut dyn Observer,
    ) -> std::result::Result<Vec<Found>, String> {
        let EigenvalueCount { negative, sign, crossings } = start;
        // Without a potential limit points are no zeros of the symmetric part.
        let explains = |found: &&Found| has_potential && found.point.change != 0;
        let zeros: Vec<(f64, i32)> = limits.iter().filter(explains).map(|f| (f.a, f.point.change)).collect();
        let explained: i32 = zeros.iter().map(|(_, change)| change).sum();
        let unexplained = end.negative as i32 - negative as i32 - explained;
        let by_sign = !has_potential && sign != 0 && end.tangent.determinant_sign != 0 && limits.is_empty();
        if (unexplained == 0 && !by_sign) || (!has_potential && sign != 0 && !limits.is_empty()) {
            return Ok(Vec::new());
        }
        let known = known.get_or_insert_with(|| Known::new(self, (arc, negative), end));
        if unexplained != 0 && (has_potential || end.a > SHORT) {
            let mut curve = PathCurve { steps: self, known, observer, has_potential };
            let found = bifurcations(&mut curve, end.a, (negative, unexplained), &zeros)?;
            if has_potential {
                return Ok(found);
            }
        }
        if by_sign {
            let may_hide = crossings
                .zip(end.tangent.crossings)
                .is_some_and(|(first, last)| two_may_cross_zero([negative, end.negative], [first, last]));
            if may_hide && sign == end.tangent.determinant_sign {
                let [first, last] = [self.state.time, end.equation.time];
                if end.a > SHORT || (last - first).abs() > TOGETHER * larger(first.abs(), last.abs()) {
                    return Err("there may be two bifurcations in the step".into());
                }
                observer.on_warning(&format!(
                    "between load factors {:.6} and {:.6} there may be two bifurcations next to each other, which are not told apart",
                    self.state.time, end.equation.time
                ));
            }
            return self.changes_of_sign(sign, (arc, known), end, observer);
        }
        observer.on_warning(&format!(
            "between load factors {:.6} and {:.6} the number of negative eigenvalues of the symmetric part of the tangent changes by \
             {unexplained:+}; bifurcations under these loads, which have no potential, are not looked for",
            self.state.time, end.equation.time
        ));
        Ok(Vec::new())
    }
}

/// Whether two eigenvalues of the tangent `K + s N` may pass through zero at s = 1 between two equilibria, whose symmetric parts (s = 0) have these numbers
/// of negative eigenvalues, and for which these numbers of eigenvalues pass through zero on the way from s = 0 to 1. Where an eigenvalue passes through zero at s = 0, both
/// numbers change by one, and either their sum or their difference stays; where it does at s = 1, only the second one changes.
fn two_may_cross_zero(negative: [usize; 2], crossings: [usize; 2]) -> bool {
    let change = |of: [usize; 2]| of[1] as i64 - of[0] as i64;
    let (by_negative, by_crossings) = (change(negative), change(crossings));
    (by_negative + by_crossings).abs() > 1 && (by_negative - by_crossings).abs() > 1
}

/// Path of an arc-length step.
pub(super) struct PathCurve<'s, 'a, 'o> {
    pub steps: &'s mut ArcLengthSteps<'a>,
    pub known: &'s mut Known,
    pub observer: &'o mut dyn Observer,
    /// Whether the loads have a potential; else the eigenvalues are those of the symmetric part of the tangent.
    pub has_potential: bool,
}

impl Curve for PathCurve<'_, '_, '_> {
    fn trial(&mut self, a: f64) -> std::result::Result<Trial, String> {
        let end = self.steps.equilibrium_near(self.known, a, self.observer)?;
        let ArcLengthSteps { newton, system, response, .. } = &mut *self.steps;
        let mut softest = newton.eigenvalue_next_to_zero(
            system,
            &end.equation,
            (TangentPart::Symmetric, INVERSE_ITERATIONS),
        )?;
        system.orient(&mut softest.1);
        let on_path = self.known.ends().map(|end| end.tangent.work.abs());
        let work = response.work_on(&softest.1).abs();
        let work = if work > 0.0 && self.has_potential { work / larger(on_path[0], on_path[1]) } else { 0.0 };
        let is_alone = self.has_potential && work <= PERFECT;
        let (u, load, negative) = (end.equation.u.clone(), end.equation.time, end.negative);
        self.known.add(end);
        Ok(Trial { u, load, negative, softest, work: [work, WORK], is_alone })
    }
}
