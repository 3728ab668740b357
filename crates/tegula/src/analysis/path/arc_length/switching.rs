//! Steps from a bifurcation onto the path that crosses there.

use super::inside_step::Known;
use super::{ArcLengthSteps, ArcStart, End, ON_BRANCH, Outcome};
use crate::analysis::Observer;
use crate::analysis::newton::{PathTangent, Plane};
use crate::analysis::path::critical_points::{Found, INVERSE_ITERATIONS};
use crate::analysis::path::{branch, piece};
use crate::analysis::statics::StaticEquation;
use crate::element::Nodal;

impl ArcLengthSteps<'_> {
    /// First bifurcation of a step at which the path goes over to the crossing one, and the sign of the side wanted.
    pub(super) fn switched<'f>(&self, critical: &'f [Found]) -> Option<(&'f Found, f64)> {
        let passed = self.path().map_or(0, |path| path.expansion.bifurcations);
        piece::switched(critical, passed, &self.options.switch_at)
    }

    /// Direction in which the other path leaves a bifurcation of a step.
    pub(super) fn leaving(
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
        let (_, eigenvector) = newton.eigenvalue_next_to_zero(system, equation, INVERSE_ITERATIONS)?;
        let rising = sign * tangent.load.signum();
        Ok(branch::primary_direction(system, &tangent.direction, &eigenvector, rising))
    }

    /// Equilibrium on the path that crosses at a bifurcation, on the side of a direction.
    pub(super) fn onto_branch(
        &mut self,
        known: &Known,
        (a, direction): (f64, Vec<Nodal>),
        observer: &mut dyn Observer,
    ) -> std::result::Result<End, String> {
        let at = self.equilibrium_near(known, a, observer)?.equation;
        Ok(End { a, ..self.beside(&at, direction, observer)? })
    }

    /// Step from a bifurcation, at which the path begins, in a direction.
    pub(super) fn step_away(
        &mut self,
        direction: &[Nodal],
        observer: &mut dyn Observer,
    ) -> std::result::Result<Outcome, String> {
        self.go_back();
        let at = self.equation.clone();
        let end = self.beside(&at, direction.to_vec(), observer)?;
        Ok(Outcome { negative: end.negative, critical: Vec::new(), length: ON_BRANCH * end.a, end })
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
