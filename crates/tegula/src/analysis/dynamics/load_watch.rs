//! Work of loads of a caller, whose forces schemes evaluate at one or two places of a step.
//!
//! Forces a and b at the ends of a step and m in its middle do the work `(a + 4 m + b)/6 · Δx` by Simpson's rule; it differs from that of the scheme by
//! `(a + b − 2 m)/6 · Δx` and by multiples of it. It vanishes for springs and dampers of constant stiffness, and is as large as the energy where a body runs
//! into a stop within one step.
//!
//! A force that jumps with the motion, such as dry friction by the sign of a velocity, has no equilibrium where it vanishes: steps become ever shorter there.

use crate::Vec3;
use crate::analysis::{Observer, State};
use crate::element::{Motion, Nodal};
use crate::model::{Scheme, TransientAnalysis};
use crate::system::System;
use tegula_sparse::norm::larger;

/// Work in one step that is unknown, over the largest energy, that is reported, and that of all steps together.
const REPORTED: f64 = 0.1;
/// Number of first steps that are judged together: from rest, the work of one is as small as what is unknown of it.
const FIRST_STEPS: u64 = 20;

/// Number of implicit steps that advance a motion by its constant step at least, or by a part of its length.
const MANY_STEPS: u64 = 1000;
const SHORT: f64 = 1e-4;

/// Time, positions and velocities of a load, and its forces there.
struct LoadState {
    time: f64,
    motion: [Vec<Vec3>; 2],
    forces: Vec<Nodal>,
}

/// Watch of the work of all loads that are functions of a caller.
pub(super) struct LoadWatch {
    before: Vec<LoadState>,
    /// Unknown work of each load so far, and whether it was told.
    missed: Vec<(f64, bool)>,
    /// Step and time from which steps are counted; `None` once short ones were told.
    counted: Option<(u64, f64)>,
    /// Time by which many steps advance the motion at least.
    least_advance: f64,
}

impl LoadWatch {
    /// Watch from a state on.
    pub fn new(system: &System, options: &TransientAnalysis, state: &State) -> Self {
        let before = evaluated(system, state);
        // Explicit steps are short for other reasons.
        let counted = (!matches!(options.scheme, Scheme::Explicit(_))).then_some((state.step, state.time));
        let least_advance = options.time_step.unwrap_or(SHORT * options.end_time);
        Self { missed: vec![(0.0, false); before.len()], before, counted, least_advance }
    }

    /// Warns once where many steps hardly advance the motion.
    fn look_at_steps(&mut self, system: &System, state: &State, observer: &mut dyn Observer) {
        let Some((_, time)) = self.counted.filter(|(step, _)| state.step >= step + MANY_STEPS) else {
            return;
        };
        let advanced = state.time - time;
        self.counted = Some((state.step, state.time));
        if advanced < self.least_advance {
            self.counted = None;
            let names: Vec<&str> = system
                .field_loads()
                .map(|(.., of)| system.load_sets[system.load_of_follower[of]].name.as_str())
                .collect();
            observer.on_warning(&format!(
                "time {:.6e}: the last {MANY_STEPS} steps have advanced the motion by {advanced:.1e} only: a force of {} may jump with the motion, as \
                 friction does with the sign of a velocity; let it change over a small distance or velocity",
                state.time,
                names.join(", ")
            ));
        }
    }

    /// Looks at the end of a step, the `last` one or another, and warns once for each load whose work is not known to a tenth of the largest energy of the
    /// motion.
    pub fn look(&mut self, system: &System, (state, last): (&State, bool), observer: &mut dyn Observer) {
        if self.before.is_empty() {
            return;
        }
        self.look_at_steps(system, state, observer);
        let now = evaluated(system, state);
        let scale = larger(state.energy_scale, state.work.abs());
        let judged = last || state.step >= FIRST_STEPS;
        let pairs = self.before.iter().zip(&now);
        for (((load, factor, number), (old, new)), (missed, told)) in
            system.field_loads().zip(pairs).zip(&mut self.missed)
        {
            let mean = |part: usize| -> Vec<Vec3> {
                old.motion[part].iter().zip(&new.motion[part]).map(|(a, b)| 0.5 * (a + b)).collect()
            };
            let time = 0.5 * (old.time + new.time);
            let middle = load.forces(time, [mean(0), mean(1)], system.length);
            let unknown = |i: usize| {
                let [a, b, m] = [&old.forces[i], &new.forces[i], &middle[i]].map(|force| Vec3::from(*force));
                (a + b - 2.0 * m).dot(&(new.motion[0][i] - old.motion[0][i])) / 6.0
            };
            let step = system.factor(factor, time) * (0..middle.len()).map(unknown).sum::<f64>();
            *missed += step;
            let most = larger(step.abs(), missed.abs());
            if judged && !*told && most > REPORTED * scale && scale > 0.0 {
                *told = true;
                let name = &system.load_sets[system.load_of_follower[number]].name;
                observer.on_warning(&format!(
                    "time {:.6e}: the force of the load \"{name}\" changes so much within a step that its work is uncertain by {:.0} % of the largest \
                     energy of the motion: the motion may gain or lose as much; take steps (`time_step`, `max_step`) that resolve it",
                    state.time,
                    100.0 * most / scale
                ));
            }
        }
        self.before = now;
    }
}

/// Loads of a caller in a state.
fn evaluated(system: &System, state: &State) -> Vec<LoadState> {
    let motion = Motion::State { u: &state.u, velocity: Some(&state.v) };
    let of = |(load, _, _): (&crate::load::LoadOnNodes, _, _)| {
        let motion = system.motion_of_load(&motion, load);
        let forces = load.forces(state.time, motion.clone(), system.length);
        LoadState { time: state.time, motion, forces }
    };
    system.field_loads().map(of).collect()
}
