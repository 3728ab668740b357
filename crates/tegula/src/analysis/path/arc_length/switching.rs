//! Steps from a bifurcation onto the path that crosses there.

use super::inside_step::Known;
use super::{ArcLengthSteps, ArcStart, End, ON_BRANCH, Outcome};
use crate::analysis::Observer;
use crate::analysis::newton::{PathTangent, Plane, TangentPart};
use crate::analysis::path::critical_points::{Found, INVERSE_ITERATIONS};
use crate::analysis::path::{branch, piece};
use crate::analysis::statics::StaticEquation;
use crate::element::Nodal;

impl ArcLengthSteps<'_> {
    /// Goes over to the crossing path at the first bifurcation of a step where this is wanted; drops the critical points behind it.
    pub(super) fn go_over(
        &mut self,
        arc: &ArcStart,
        known: &Known,
        critical: &mut Vec<Found>,
        observer: &mut dyn Observer,
    ) -> std::result::Result<Option<End>, String> {
        let passed = self.path().map_or(0, |path| path.expansion.bifurcations);
        let Some((found, sign)) = piece::switched(critical, passed, &self.options.switch_at) else {
            return Ok(None);
        };
        let (at, direction) = (found.a, self.leaving(arc, (found, sign))?);
        critical.retain(|found| found.a <= at);
        self.onto_branch(known, (at, direction), observer).map(Some)
    }

    /// Ends a step at its first critical point at which the path is to end, and drops those behind it.
    pub(super) fn end_inside(
        &mut self,
        arc: &ArcStart,
        known: &Known,
        (critical, negative): (&mut Vec<Found>, usize),
        end: &mut End,
        observer: &mut dyn Observer,
    ) -> std::result::Result<(), String> {
        let ends = |found: &&Found| found.point.kind.ends(&self.options) && found.a < end.a;
        let Some(last) = critical.iter().find(ends).map(|found| found.a) else { return Ok(()) };
        critical.retain(|found| found.a <= last);
        let changes: i32 = critical.iter().map(|found| found.point.change).sum();
        // The eigenvalue that vanishes there is round-off, and the response to the loads its eigenvector.
        let tangent = PathTangent::between(self.system, [&arc.tangent, &end.tangent], last / end.a);
        let negative = (negative as i32 + changes).max(0) as usize;
        *end = End { negative, tangent, ..self.equilibrium_near(known, last, observer)? };
        Ok(())
    }

    /// Direction in which the other path leaves a bifurcation of a step.
    fn leaving(
        &mut self,
        arc: &ArcStart,
        (found, sign): (&Found, f64),
    ) -> std::result::Result<Vec<Nodal>, String> {
        if !found.is_passed_along_mode() {
            return Ok(found.mode_on_side(sign));
        }
        // At the start of the step the tangent is not yet singular.
        self.go_back();
        let Self { newton, system, state, equation, response, .. } = self;
        let at = (&mut *equation, state.history.as_slice());
        let (tangent, _) = newton.path_tangent(system, at, Some(&arc.tangent.direction), response)?;
        let (_, eigenvector) =
            newton.eigenvalue_next_to_zero(system, equation, (TangentPart::Whole, INVERSE_ITERATIONS))?;
        let rising = sign * tangent.load.signum();
        Ok(branch::primary_direction(system, &tangent.direction, &eigenvector, rising))
    }

    /// Equilibrium on the path that crosses at a bifurcation, on the side of a direction.
    fn onto_branch(
        &mut self,
        known: &Known,
        (a, direction): (f64, Vec<Nodal>),
        observer: &mut dyn Observer,
    ) -> std::result::Result<End, String> {
        let at = self.equilibrium_near(known, a, observer)?.equation;
        Ok(End { a, ..self.beside(&at, direction, observer)? })
    }

    /// Step from a critical point, at which the path begins, in a direction.
    pub(super) fn step_away(
        &mut self,
        direction: &[Nodal],
        observer: &mut dyn Observer,
    ) -> std::result::Result<Outcome, String> {
        self.go_back();
        let at = self.equation.clone();
        let end = self.beside(&at, direction.to_vec(), observer)?;
        Ok(Outcome {
            negative: end.negative,
            critical: Vec::new(),
            unstable: None,
            growing: None,
            length: ON_BRANCH * end.a,
            end,
        })
    }

    /// Equilibrium beside another one, on the side of a direction.
    fn beside(
        &mut self,
        at: &StaticEquation,
        direction: Vec<Nodal>,
        observer: &mut dyn Observer,
    ) -> std::result::Result<End, String> {
        let tangent = PathTangent { direction, ..PathTangent::default() };
        let (mut distance, mut passed) = (branch::FIRST, None);
        for _ in 0..branch::HALVINGS {
            self.equation.clone_from(at);
            let plane = Plane { origin: &at.u, normal: &tangent.direction, distance };
            let solved = self.correct((&tangent, distance), &plane, observer);
            if let Ok(iterations) = solved {
                let loads = [at.time, self.equation.time];
                passed = branch::wanted_between(self.system, self.options.end_load, loads);
                if passed.is_none() {
                    return self.end_at(distance, &tangent, iterations);
                }
            }
            distance *= 0.5;
        }
        Err(branch::not_found(passed))
    }
}
