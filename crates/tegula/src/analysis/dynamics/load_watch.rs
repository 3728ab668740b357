//! Work of loads of a caller, whose forces schemes evaluate at one or two places of a step.
//!
//! Forces a and b at the ends of a step and m in its middle do the work `(a + 4 m + b)/6 · Δx` by Simpson's rule; it differs from that of the scheme by
//! `(a + b − 2 m)/6 · Δx` and by multiples of it. It vanishes for springs and dampers of constant stiffness, and is as large as the energy where a body runs
//! into a stop within one step.

use crate::Vec3;
use crate::analysis::{Observer, State};
use crate::element::{Motion, Nodal};
use crate::system::System;
use tegula_sparse::norm::larger;

/// Work in one step that is unknown, over the largest energy, that is reported, and that of all steps together.
const REPORTED: f64 = 0.1;
/// Number of first steps that are judged together: from rest, the work of one is as small as what is unknown of it.
const FIRST_STEPS: u64 = 20;

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
}

impl LoadWatch {
    /// Watch from a state on.
    pub fn new(system: &System, state: &State) -> Self {
        let before = evaluated(system, state);
        Self { missed: vec![(0.0, false); before.len()], before }
    }

    /// Looks at the end of a step, the `last` one or another, and warns once for each load whose work is not known to a tenth of the largest energy of the
    /// motion.
    pub fn look(&mut self, system: &System, (state, last): (&State, bool), observer: &mut dyn Observer) {
        if self.before.is_empty() {
            return;
        }
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
