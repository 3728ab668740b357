//! Length of the next arc-length step, from the curvature of the path over the last one.

use super::{ArcLengthSteps, ArcStart, End, TURN};
use crate::norm::larger;
use crate::system::add_multiple;

/// Distance between the predicted and the corrected point that is aimed at: of the displacements over the length of the step, of the load
/// factor over the largest one so far.
const DEPARTURE: [f64; 2] = [0.1, 0.03];
/// Largest distance over those.
const MOST_EXCESS: f64 = 5.0;
/// Bounds of the change of the length from step to step.
const CHANGE: [f64; 2] = [0.5, 2.0];
/// Largest change of the load factor that is planned for a step behind the first over that at the end, where the loads have no potential: eigenvalues that pass through zero in
/// opposite directions within one step are not noticed.
const MOST_LOAD: f64 = 1.0 / 16.0;
/// Iterations of a step above which the next one is not longer.
const MANY: u32 = 7;
/// Largest distance of the chord of a step, over its length, from the mean of the directions at both ends.
const SMOOTH: f64 = 0.1;

impl ArcLengthSteps<'_> {
    /// Length of the step behind one that the path does not leave too far.
    ///
    /// # Errors
    /// The path curves too much over the step.
    pub(super) fn next_length(&self, arc: &ArcStart, end: &End) -> std::result::Result<f64, String> {
        let departures = [self.departure(arc, end)?, self.load_departure(arc, end)];
        let excess = larger(departures[0] / DEPARTURE[0], departures[1] / DEPARTURE[1]);
        if excess > MOST_EXCESS {
            return Err("the path curves too much over the step".into());
        }
        let mut next = end.a * (1.0 / excess).clamp(CHANGE[0], CHANGE[1]);
        if end.iterations > MANY {
            next = next.min(end.a);
        }
        let most = (MOST_LOAD * self.options.end_load / end.tangent.load).abs();
        if next > most && arc.tangent.determinant_sign != 0 && !self.have_potential(&end.equation) {
            next = most;
        }
        Ok(next)
    }

    /// Distance of the predicted from the corrected point over the length of a step.
    ///
    /// # Errors
    /// The ends of the step do not lie on one smooth curve.
    fn departure(&self, arc: &ArcStart, end: &End) -> std::result::Result<f64, String> {
        let Self { system, state, .. } = self;
        let mut chord = end.equation.u.clone();
        add_multiple(&mut chord, -1.0, &state.u);
        chord.as_flattened_mut().iter_mut().for_each(|x| *x /= end.a);
        let mut away = chord.clone();
        add_multiple(&mut away, -1.0, &arc.tangent.direction);
        let departure = system.norm(&away);
        let (first, last) = (&arc.tangent.direction, &end.tangent.direction);
        let turn = system.inner_product(first, last);
        // The directions per distance along the first one, as the chord is.
        add_multiple(&mut chord, -0.5, first);
        add_multiple(&mut chord, -0.5 / turn, last);
        if turn >= TURN && system.norm(&chord) <= SMOOTH {
            Ok(larger(departure, f64::MIN_POSITIVE))
        } else {
            Err("the directions of the path at both ends of the step do not belong to one smooth curve"
                .into())
        }
    }

    /// Distance of the predicted from the corrected load factor over the largest one so far: models of few degrees of freedom move along a
    /// line.
    fn load_departure(&self, arc: &ArcStart, end: &End) -> f64 {
        let [least, most] = self.path().map_or([0.0; 2], |path| path.loads);
        let largest = [least, most, end.equation.time].into_iter().map(f64::abs).fold(0.0, larger);
        let away = end.equation.time - self.state.time - arc.tangent.load * end.a;
        if largest > 0.0 { away.abs() / largest } else { 0.0 }
    }
}
