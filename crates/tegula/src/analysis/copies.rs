//! Copies of states into the memory of others: no time step allocates.

use super::State;
use super::lagged_tangent::LaggedTangent;

impl State {
    /// Takes over the values of another state of the same model, in the memory of this one.
    pub fn copy_from(&mut self, other: &Self) {
        // Without `..`, so that the compiler names a new field here.
        let Self {
            time,
            step,
            u,
            v,
            a,
            mean_a,
            scheme_v,
            acceleration_lag,
            mean_rates,
            mean_loads,
            scheme_loads,
            history,
            multipliers,
            middle,
            angles,
            coordinates,
            next_step,
            last_step,
            work,
            dissipated,
            energy_scale,
            swing,
            displacement_scale,
            other_form,
            compliance,
            negative_pivots,
            tangent,
            path,
            watched,
        } = other;
        self.time = *time;
        self.step = *step;
        self.u.clone_from(u);
        self.v.clone_from(v);
        self.a.clone_from(a);
        self.mean_a.clone_from(mean_a);
        self.scheme_v.clone_from(scheme_v);
        self.acceleration_lag.clone_from(acceleration_lag);
        for (to, from) in self.mean_rates.iter_mut().zip(mean_rates) {
            to.clone_from(from);
        }
        self.mean_loads.clone_from(mean_loads);
        self.scheme_loads.clone_from(scheme_loads);
        self.history.clone_from(history);
        self.multipliers.clone_from(multipliers);
        self.middle.clone_from(middle);
        self.angles.clone_from(angles);
        self.coordinates.clone_from(coordinates);
        self.next_step = *next_step;
        self.last_step = *last_step;
        self.work = *work;
        self.dissipated = *dissipated;
        self.energy_scale = *energy_scale;
        self.swing = *swing;
        self.displacement_scale = *displacement_scale;
        self.other_form = *other_form;
        self.compliance = *compliance;
        self.negative_pivots = *negative_pivots;
        self.tangent.copy_from(tangent);
        self.path.clone_from(path);
        self.watched.values.clone_from(&watched.values);
        self.watched.met = watched.met;
    }
}

impl LaggedTangent {
    /// Takes over the values of another one, in the memory of this one.
    fn copy_from(&mut self, other: &Self) {
        let Self { valid, time, dt, coefficients, u, v, history, steps, iterations, last, pause, next_pause } =
            other;
        self.valid = *valid;
        self.time = *time;
        self.dt = *dt;
        self.coefficients = *coefficients;
        self.u.clone_from(u);
        self.v.clone_from(v);
        self.history.clone_from(history);
        self.steps = *steps;
        self.iterations = *iterations;
        self.last = *last;
        self.pause = *pause;
        self.next_pause = *next_pause;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::Watched;

    #[test]
    fn a_copy_equals_the_state_and_keeps_its_memory() {
        let field = |x: f64| vec![[x, 2.0, 3.0]; 4];
        let tangent = LaggedTangent {
            valid: true,
            u: field(7.0),
            history: vec![1.0],
            steps: 3,
            ..LaggedTangent::default()
        };
        let watched = Watched { values: vec![4.0], met: Some(1) };
        let mut state = State {
            time: 0.5,
            step: 7,
            u: field(1.0),
            v: field(2.0),
            a: field(3.0),
            tangent,
            watched,
            ..State::default()
        };
        state.mean_rates = [field(4.0), field(5.0)];
        state.mean_loads = field(6.0);
        state.scheme_loads = field(6.5);
        state.history = vec![1.0; 9];
        (state.work, state.other_form, state.negative_pivots) = (3.0, true, 2);
        let mut copy = State { u: field(9.0), ..State::default() };
        let memory = copy.u.as_ptr();
        copy.copy_from(&state);
        assert!(copy == state && copy.u.as_ptr() == memory);
    }
}
