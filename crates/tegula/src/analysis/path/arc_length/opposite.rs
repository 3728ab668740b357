//! Bifurcations of arc-length steps that cancel in the number of negative eigenvalues.

use super::inside_step::{Known, PathCurve, SHORT};
use super::{ArcLengthSteps, ArcStart, End};
use crate::analysis::Observer;
use crate::analysis::newton::PathTangent;
use crate::analysis::path::critical_points::{Curve, Found};
use crate::analysis::path::opposite_crossings::{CurveWithModes, Place, Unstable, opposite_crossings};
use crate::analysis::unstable_modes::UnstableModes;

/// Unstable modes at the end of a step, and whether they are those of its start.
pub(super) type ModesAtEnd = Option<(UnstableModes, bool)>;

impl ArcLengthSteps<'_> {
    /// Finds the unstable modes at the start of a step where they are not known: its tangent is factored once more. Without a potential the
    /// eigenvalues of the symmetric part tell nothing.
    pub(super) fn find_modes_at_start(&mut self, direction: &PathTangent) {
        let negative = self.state.negative_pivots;
        if negative == 0 || self.unstable.is_some() || direction.determinant_sign != 0 {
            return;
        }
        self.go_back();
        let Self { newton, system, state, equation, response, .. } = self;
        let at = (&mut *equation, state.history.as_slice());
        if newton.path_tangent(system, at, Some(&direction.direction), response).is_ok() {
            self.unstable = newton.unstable_modes(system, negative, None).map(|(modes, _)| modes);
        }
    }

    /// Unstable modes at the end of a step, whose tangent is factored.
    pub(super) fn modes_at_end(&mut self, end: &End) -> ModesAtEnd {
        if end.negative == 0 || end.tangent.determinant_sign != 0 {
            return None;
        }
        self.newton.unstable_modes(self.system, end.negative, self.unstable.as_ref())
    }

    /// Unstable modes at the end of a step that ends before its planned length, at a limit point or a wanted load factor: its tangent is factored once more.
    pub(super) fn modes_at_new_end(&mut self, end: &End) -> ModesAtEnd {
        if end.negative == 0 || end.tangent.determinant_sign != 0 {
            return None;
        }
        let Self { newton, system, state, equation, response, .. } = self;
        equation.clone_from(&end.equation);
        let at = (&mut *equation, state.history.as_slice());
        let direction = Some(end.tangent.direction.as_slice());
        let (_, negative) = newton.path_tangent(system, at, direction, response).ok()?;
        // At a limit point the number of negative eigenvalues is that behind it.
        if negative == end.negative { self.modes_at_end(end) } else { None }
    }

    /// Bifurcations of a step beside its critical points that the number of negative eigenvalues tells: limit points and others. Where none can be told
    /// even in a short step, a warning says so.
    ///
    /// # Errors
    /// A trial in a longer step failed; the text gives the reason.
    pub(super) fn opposite_bifurcations(
        &mut self,
        limits: &[Found],
        others: &[Found],
        (arc, known): (&ArcStart, &mut Option<Known>),
        (end, unstable): (&End, &ModesAtEnd),
        observer: &mut dyn Observer,
    ) -> std::result::Result<Vec<Found>, String> {
        let Some((last, false)) = unstable else { return Ok(Vec::new()) };
        let Some(first) = self.unstable.clone() else { return Ok(Vec::new()) };
        let (system, negative, from) = (self.system, self.state.negative_pivots, self.state.time);
        let places = [(0.0, negative, first), (end.a, end.negative, last.clone())]
            .map(|(a, negative, modes)| Place { a, negative, modes });
        let told: Vec<(f64, i32)> =
            limits.iter().chain(others).map(|found| (found.a, found.point.change)).collect();
        let known = known.get_or_insert_with(|| Known::new(self, (arc, negative), end));
        let mut curve = PathCurve { steps: self, known, observer, has_potential: true };
        match opposite_crossings(system, &mut curve, places, &told) {
            Err(reason) if end.a <= SHORT => {
                observer.on_warning(&format!(
                    "between load factors {from:.6} and {:.6} the unstable modes change, and bifurcations that cancel in the number of negative \
                     eigenvalues are not told: {reason}",
                    end.equation.time
                ));
                Ok(Vec::new())
            }
            found => found,
        }
    }
}

impl CurveWithModes for PathCurve<'_, '_, '_> {
    fn unstable(&mut self, a: f64) -> std::result::Result<Unstable, String> {
        let trial = self.trial(a)?;
        let ArcLengthSteps { newton, system, .. } = &mut *self.steps;
        let (modes, _) =
            newton.unstable_modes(system, trial.negative, None).ok_or("the unstable modes were not found")?;
        Ok(Unstable { u: trial.u, load: trial.load, negative: trial.negative, modes })
    }
}
