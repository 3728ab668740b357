//! Judgement of an equilibrium that a load step has found: whether the stable path of the last one leads to it.

use super::{LoadSteps, ROUND_OFF};
use crate::analysis::newton::{Cause, Converged, Equation, TangentPart};
use crate::analysis::path::INVERSE_ITERATIONS;
use crate::analysis::solver::TangentSolver;
use crate::analysis::statics::connection::{
    SOFTER, Speeds, is_smooth, leaves_speeds, other_side, released_energy, turned_back, unstable_side,
};
use crate::analysis::statics::failure::{Failure, Kind};
use crate::analysis::statics::{StaticEquation, equilibrium_step};
use crate::analysis::{Observer, Stability};
use crate::element::Nodal;
use crate::system::assembly::add_follower_loads;
use crate::system::{add_multiple, inverted_element};

/// Inertia forces over loads and inertia forces up to which the loads balance each other.
const SELF_BALANCED: f64 = 1e-2;

impl<S: TangentSolver> LoadSteps<'_, S> {
    /// Refuses inverted elements, unstable equilibria, and equilibria that no stable path connects with the last one.
    pub(super) fn judge(
        &mut self,
        target: f64,
        converged: Converged,
        observer: &mut dyn Observer,
    ) -> std::result::Result<Converged, Failure> {
        if let Some(inverted) = inverted_element(self.system, &self.equation.u) {
            return Err(Failure::new(Kind::Inverted, inverted, converged.most_negative_pivots));
        }
        let negative = converged.negative_pivots;
        let ends = (&self.state, &self.equation);
        if let Some(reason) = equilibrium_step::refusal(self.system, &self.newton.assembly, ends) {
            return Err(Failure::new(Kind::Iteration(Cause::Flight), reason, negative));
        }
        let stability = self
            .newton
            .stability(self.system, negative)
            .map_err(|reason| Failure::new(Kind::Iteration(Cause::Tangent), reason, negative))?;
        if matches!(stability, Stability::Unstable(_)) && self.accelerates() {
            observer.on_event(&format!(
                "load factor {target}: {negative} negative pivot(s) of the tangent, which has the inertia forces of `inertia_relief` as constant ones, \
                 though they follow the loads of a model that turns: whether the equilibrium is stable is not known"
            ));
        } else if matches!(stability, Stability::Unstable(_)) && !self.accepts_unstable() {
            return Err(Failure::new(
                Kind::Unstable,
                format!(
                    "the equilibrium found is unstable ({negative} negative pivot(s) of the tangent): the structure \
                     would buckle"
                ),
                negative,
            ));
        }
        let converged = self.connect(target, converged, observer)?;
        if matches!(stability, Stability::Undecided(_)) {
            // Moments and pressures need not have a potential: the symmetric part alone does not decide.
            observer.on_event(&format!(
                "load factor {target}: {negative} negative pivot(s) of the symmetric part of the tangent, but no eigenvalue of \
                 the tangent with the circulatory part of the follower loads has passed through zero: no bifurcation; whether motions grow, with \
                 vibrations (flutter) or without (divergence), a modal step behind this one tells"
            ));
        }
        if converged.floor {
            observer.on_event(&format!(
                "load factor {target}: the increments stagnate at round-off; the equilibrium is accepted"
            ));
        }
        Ok(converged)
    }

    /// Whether inertia forces of a rigid acceleration balance the loads, whose change with the displacements the tangent lacks.
    fn accelerates(&mut self) -> bool {
        let (system, equation) = (self.system, &self.equation);
        if system.inertia_relief.is_none() {
            return false;
        }
        let mut forces = vec![[0.0; 3]; system.vectors()];
        system.add_inertia_relief(&equation.motion(), equation.time, 1.0, &mut forces);
        let inertia = system.force_norm(&forces);
        forces.fill([0.0; 3]);
        add_follower_loads(system, &equation.motion(), equation.time, 1.0, &mut forces);
        system.add_dead_loads(equation.time, 1.0, &mut forces);
        inertia > SELF_BALANCED * system.force_norm(&forces)
    }

    /// Refuses an equilibrium that no stable path leads to (snap-through test, see `connection`). Where the path turns sharply next to
    /// unstable equilibria, it is followed, and the equilibrium to which it leads is taken.
    fn connect(
        &mut self,
        target: f64,
        converged: Converged,
        observer: &mut dyn Observer,
    ) -> std::result::Result<Converged, Failure> {
        let moved = self.moved();
        let scale = self.system.norm(&self.equation.u).max(self.state.displacement_scale);
        let noticeable = self.tolerances.increment * scale;
        if self.system.linear || moved <= noticeable.max(ROUND_OFF) {
            return Ok(converged);
        }
        let before =
            StaticEquation { u: self.state.u.clone(), time: self.state.time, ..self.equation.clone() };
        let Self { newton, system, equation, external, buffers, state, .. } = self;
        let [first, last] = buffers;
        let loads: [&mut [Nodal]; 3] = [first, last, external];
        // `external` holds the displacement of the step. Prescribed strains roll shells up by many turns in one step.
        let away = turned_back(system, loads[2], &newton.first_response)
            .filter(|_| system.prescribed_strains.is_empty())
            .or_else(|| unstable_side(system, loads[2]).filter(|_| state.step == 0));
        let steps = (&before, &*equation, state.history.as_slice());
        let released = released_energy(system, &mut newton.assembly, steps, &newton.first_response, loads);
        let speeds = Speeds {
            moved,
            start: converged.first_increment,
            softens: state.compliance > 0.0
                && converged.first_increment > SOFTER * state.compliance * (target - state.time),
        };
        // Preloaded springs are out of equilibrium in the reference configuration, and release energy on the way to the first one.
        let preloaded = state.step == 0
            && state.time >= 0.0
            && !system.continues()
            && newton.assembly.strain_energy(system, &state.point(system)) > 0.0;
        // The ramp of their preload brings energy of its own.
        let released = released.filter(|_| !self.ramps_preload_alone());
        let mut doubt = released.or(away).filter(|_| !preloaded);
        let mut away = None;
        if doubt.is_none() {
            [doubt, away] = self.doubts_of_tangents(&speeds, &converged);
            away = away.filter(|_| !preloaded);
        }
        if doubt.is_none() && !self.accepts_unstable() && (away.is_some() || self.turns_sharply(&converged)) {
            match self.along_path(target, observer) {
                Some(end) => {
                    let first_increment = converged.first_increment;
                    return end.map(|end| Converged { first_increment, ..end });
                }
                None => doubt = away.or_else(|| self.other_side()),
            }
        } else {
            doubt = doubt.or(away);
        }
        let Some(doubt) = doubt else { return Ok(converged) };
        let reason = format!(
            "snap-through test: no stable path connects the equilibrium found with the last one: {doubt}"
        );
        if self.accepts_unstable() {
            observer.on_event(&format!("load factor {target:.6}: {reason}"));
            return Ok(converged);
        }
        Err(Failure::new(Kind::Leap, reason, converged.most_negative_pivots))
    }

    /// Reasons to doubt a step from the lengths of the responses at both its ends, and else from their directions, as text.
    fn doubts_of_tangents(&mut self, speeds: &Speeds, converged: &Converged) -> [Option<String>; 2] {
        let is_direct = self.newton.linear_iterations() == 0;
        let smooth = self.system.without_internal_variables() && self.system.prescribed_strains.is_empty();
        let (by_lengths, by_directions) =
            (self.meets_unstable(converged) || speeds.need_the_end(), is_direct && smooth);
        if !by_lengths && !by_directions {
            return [None, None];
        }
        let end = self.speed_at_end();
        let of_lengths = if by_lengths { speeds.doubt(end) } else { None };
        if of_lengths.is_some() || !by_directions || !(end > 0.0) {
            return [of_lengths, None];
        }
        self.moved();
        let responses = (self.newton.first_response.as_slice(), self.newton.last_response());
        [None, leaves_speeds(self.system, &self.external, responses)]
    }

    /// Norm of the linear response at the end of a step to the change of its loads, which the solver holds then; 0 where it is not found.
    fn speed_at_end(&mut self) -> f64 {
        let unloaded = StaticEquation { time: self.state.time, ..self.equation.clone() };
        let ends = (&unloaded as &dyn Equation, &self.equation as &dyn Equation);
        self.newton.response(self.system, ends, &self.state.history).unwrap_or(0.0)
    }

    /// Whether the iteration of a step has met negative pivots. Internal variables make paths that are not smooth.
    fn meets_unstable(&self, converged: &Converged) -> bool {
        converged.most_negative_pivots > 0 && self.system.without_internal_variables()
    }

    /// Whether a step that has met unstable equilibria does not follow a smooth path; the speeds at its ends are those found last.
    fn turns_sharply(&mut self, converged: &Converged) -> bool {
        self.meets_unstable(converged) && {
            self.moved();
            let speeds = (self.newton.first_response.as_slice(), self.newton.last_response());
            !is_smooth(self.system, &self.external, speeds)
        }
    }

    /// Reason to doubt a step from the softest mode at its end, as text.
    fn other_side(&mut self) -> Option<String> {
        self.moved();
        let Self { newton, system, equation, external: step, .. } = self;
        let wanted = (TangentPart::Symmetric, INVERSE_ITERATIONS);
        let (_, mode) = newton.eigenvalue_next_to_zero(system, equation, wanted).ok()?;
        other_side(system, [step, &newton.first_response], &mode)
    }

    /// Norm of the displacement of the step, which `external` holds then ([`System::norm`]).
    fn moved(&mut self) -> f64 {
        let Self { external, equation, state, system, .. } = self;
        external.copy_from_slice(&equation.u);
        add_multiple(external, -1.0, &state.u);
        system.norm(external)
    }
}
