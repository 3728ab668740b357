//! Convergence of Newton's method: energy and norm of the increments, constraints, round-off.

use super::FactoredTangent;
use super::iteration::{Failed, Progress, Setting, Size};
use super::{Cause, Converged, Equation, Newton, ROUND_OFF, Tolerances, largest};
use crate::analysis::Observer;
use crate::analysis::lagged_tangent::{self, Increment};
use crate::analysis::solver::TangentSolver;
use crate::norm::{larger, max_norm};
use crate::system::System;

/// Value of a constraint over its size, to which iterations go on, and above which a joint counts as open where they cannot.
pub(super) const CLOSED: f64 = 1e-12;
pub(super) const OPEN: f64 = 1e-9;

/// Energy of increments over that of the model, below which they may stall: displacements are then right to eight digits.
const STALLED: f64 = 1e-16;

/// Energy of an increment over that of the model, up to which the tangent that gave it decides on the stability in models with springs. At the iterate of
/// that tangent a spring of the stiffness k may have the force √(2 k e) too much for an energy e, which beside a soft structure would be
/// a stabilising tension or compression.
const JUDGED: f64 = 1e-18;
/// Largest number of further tangents for that.
const MOST_ASKED: u32 = 3;

/// Increment over the size of the model that is round-off of places.
const PLACES: f64 = 1e-14;
/// Sum of the loads over their sizes that is round-off: they cancel each other.
const CANCELLED: f64 = 1e-13;
/// Out-of-balance force over the loads, above which an equilibrium found to the round-off of places alone is refused.
const UNBALANCED: f64 = 1e-3;
/// Iterations after which bodies whose places change by round-off alone are held.
const HELD: u32 = 5;

impl<S: TangentSolver> Newton<S> {
    /// Test of convergence: energy and norm of the increment against the scales of the model, and the estimated error
    /// against the limit of a time step. `None` asks for another iteration.
    pub(super) fn converged(
        &mut self,
        system: &System,
        equation: &mut dyn Equation,
        (setting, tolerances): (&Setting, &Tolerances),
        size @ Size { energy, norm, scale: energy_scale }: Size,
        progress: &mut Progress,
        observer: &mut dyn Observer,
    ) -> Result<Option<Converged>, Failed> {
        self.solver.note_energy(energy_scale);
        let scale = equation.displacement_scale(system);
        let relative = energy / energy_scale.max(f64::MIN_POSITIVE);
        observer.on_iteration(setting.number, relative, norm / scale.max(f64::MIN_POSITIVE));
        let in_time = setting.coefficients.mass != 0.0;
        if setting.number == 1 && !system.linear {
            progress.limit = equation.error_limit(energy);
        }
        let converged = self.is_small(system, (setting, tolerances), (size, scale), progress);
        if setting.number == 1 && !in_time && self.constraints.is_some() {
            // The first tangent does not know the forces of joints yet.
            return Ok(None);
        }
        let done = Converged {
            iterations: setting.number,
            tangents: progress.tangents,
            negative_pivots: progress.negative_pivots,
            most_negative_pivots: self.most_negative_pivots,
            first_increment: progress.first_increment,
            floor: false,
        };
        let places = larger(PLACES, self.round_off);
        // Bodies that loads and joints hold where they are: the increments are round-off, and there is no energy to compare with.
        let held = self.constraints.is_some() && setting.number > HELD && norm <= places && scale <= places;
        let rests = energy == 0.0 && norm == 0.0;
        if converged || held || rests {
            if held && !converged && !in_time {
                self.refuse_unbalanced(system, equation)?;
            }
            let accepted = self.accepts(system, equation, (in_time, rests), progress)?;
            return Ok(accepted.then_some(done));
        }
        let floor = self.at_round_off(system, equation, relative, (norm, scale), !in_time)?;
        if floor && let Some(open) = self.open_joint(system, equation) {
            return Err((Cause::Constraints, open));
        }
        Ok(floor.then_some(Converged { floor: true, ..done }))
    }

    /// Whether an increment, which is recorded, is within the tolerances by its energy and norm, and by its error, which follows from the rate of
    /// convergence. The scale of displacements follows its size.
    fn is_small(
        &mut self,
        system: &System,
        (setting, tolerances): (&Setting, &Tolerances),
        (Size { energy, norm, scale: energy_scale }, scale): (Size, f64),
        progress: &mut Progress,
    ) -> bool {
        let in_time = setting.coefficients.mass != 0.0;
        // The tangent of rigid bodies and joints leaves terms out, too: its convergence is linear.
        let approximate = setting.reuse || self.constraints.is_some() || !system.dofs().triads.is_empty();
        let rest = if approximate && !system.linear { lagged_tangent::rest(in_time) } else { 1.0 };
        let limit = progress.limit.max(ROUND_OFF * energy_scale);
        let relative = energy / energy_scale.max(f64::MIN_POSITIVE);
        let excess = (relative / (rest * tolerances.energy))
            .max(energy / limit)
            .sqrt()
            .max(norm / (scale * tolerances.increment));
        self.increments.push(Increment {
            energy: relative,
            size: norm / scale,
            excess,
            fresh: !setting.reuse,
            absolute: [energy, norm],
        });
        if !setting.reuse {
            progress.tangent_energy = relative;
        }
        // The error behind an increment is the increment times the contraction.
        let error = self.increments.contraction().powi(2).min(1.0) * energy;
        let left = if rest < 1.0 { error } else { energy };
        energy <= tolerances.energy * energy_scale
            && norm <= larger(tolerances.increment * scale, self.round_off)
            && left <= rest * tolerances.energy * energy_scale
            && error <= limit
    }

    /// Whether an iterate behind a small increment is the solution: its constraints are closed, and in statics its last tangent tells its stability. The
    /// increment of one that `rests` is zero.
    ///
    /// # Errors
    /// A joint stays open although the increment is zero.
    fn accepts(
        &mut self,
        system: &System,
        equation: &dyn Equation,
        (in_time, rests): (bool, bool),
        progress: &mut Progress,
    ) -> Result<bool, Failed> {
        // Constraints are as exact as the increment that follows; a dependent one may still be open.
        let violation = self.violation(system, equation);
        if violation <= if rests { OPEN } else { larger(CLOSED, self.round_off).min(OPEN) } {
            let open = progress.tangent_energy > JUDGED && progress.asked < MOST_ASKED && !rests;
            // The tangent of the first iterate does not know the stresses of the equilibrium: it says nothing about its stability.
            let of_start = progress.tangents == 1;
            if !in_time && !system.linear && (of_start || (open && system.has_force_elements())) {
                progress.asked += 1;
                self.factored = FactoredTangent::Nothing;
                return Ok(false);
            }
            return Ok(true);
        }
        if rests && let Some(open) = self.open_joint(system, equation) {
            return Err((Cause::Constraints, open));
        }
        if let Some(constraints) = &mut self.constraints
            && !constraints.closes(violation)
        {
            constraints.readmit();
        }
        Ok(false)
    }

    /// Largest value of a constraint over its size, of an iterate; 0 without joints.
    pub(super) fn violation(&self, system: &System, equation: &dyn Equation) -> f64 {
        let at = (&equation.motion(), equation.parts().time);
        self.constraints.as_ref().map_or(0.0, |constraints| constraints.largest_violation(system, at))
    }

    /// Joint that an iterate leaves open, as text.
    pub(super) fn open_joint(&mut self, system: &System, equation: &dyn Equation) -> Option<String> {
        let open = self.constraints.as_mut()?.violation(
            system,
            (&equation.motion(), equation.parts().time),
            OPEN,
        )?;
        Some(format!("{open}: its constraints contradict those of other joints"))
    }

    /// Whether the increments stagnate at round-off, which is accepted. `relative` is the energy of the increment over that
    /// of the model; its norm and the scale of displacements follow.
    ///
    /// # Errors
    /// The iteration stagnates above round-off.
    fn at_round_off(
        &self,
        system: &System,
        equation: &dyn Equation,
        relative: f64,
        (norm, scale): (f64, f64),
        is_static: bool,
    ) -> Result<bool, Failed> {
        let Some(floor) = self.increments.stagnation() else { return Ok(false) };
        // Near a rigid motion there is next to no energy to compare with: increments at round-off suffice then.
        // Increments whose energy is round-off beside that of self-equilibrated stresses suffice, too: there
        // the displacement itself vanishes.
        let resolved = norm <= 1e-10 * scale || relative <= ROUND_OFF;
        let rounding = resolved || norm <= larger(PLACES, self.round_off);
        if is_static && rounding && !resolved {
            self.refuse_unbalanced(system, equation)?;
        }
        // Bodies in motion converge linearly, in long steps slowly: increments that decrease little are no round-off there.
        let exact = self.constraints.is_none() && (is_static || system.dofs().triads.is_empty());
        if rounding || (exact && relative <= 1e-9 && norm <= 1e-5 * scale) {
            return Ok(true);
        }
        // A motion that begins smoothly from an equilibrium moves less than the round-off of the stresses there.
        if floor && !is_static && relative <= STALLED {
            return Ok(true);
        }
        if floor {
            let place = largest(system, &self.assembly.frames, &self.residual);
            let energy = format!("energy of the increment {relative:.1e} of the model's");
            return Err((Cause::Stagnation, format!("the iteration stagnates ({energy}); {place}")));
        }
        Ok(false)
    }

    /// Refuses a static equilibrium whose displacements vanish beside the round-off of places, where that round-off times the stiffness
    /// (a spring that is far stiffer than the structure) is an out-of-balance force that compares with the loads.
    ///
    /// # Errors
    /// Forces are out of balance by more than 1e-3 of the loads.
    fn refuse_unbalanced(&self, system: &System, equation: &dyn Equation) -> Result<(), Failed> {
        let mut loads = vec![[0.0; 3]; self.residual.len()];
        equation.external_minus_inertia(system, &mut loads);
        let mut reduced = vec![0.0; self.right_side.len()];
        self.frames.reduce(&loads, &mut reduced);
        let [left, loads] = [&self.right_side, &reduced].map(|forces| max_norm(forces.iter().copied()));
        // Loads that cancel each other but for their round-off leave the model in its equilibrium.
        let cancelled = loads <= CANCELLED * system.size_of_loads(equation.parts().time);
        if loads == 0.0 || cancelled || left <= UNBALANCED * loads {
            return Ok(());
        }
        let place = largest(system, &self.assembly.frames, &self.residual);
        Err((
            Cause::Stagnation,
            format!(
                "the displacements vanish beside the round-off of places, which times the stiffness leaves {left:.1e} out of \
                 balance where the loads are {loads:.1e} ({place}): a spring or a part is too stiff for these loads; a support \
                 or a joint in its place holds exactly"
            ),
        ))
    }
}
