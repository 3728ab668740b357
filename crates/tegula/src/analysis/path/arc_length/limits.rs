//! Limit points of an arc-length step, and load factors that are wanted: the first of them ends the step.

use super::inside_step::Known;
use super::{ArcLengthSteps, ArcStart, End};
use crate::analysis::Observer;
use crate::analysis::newton::PathTangent;
use crate::analysis::path::critical_points::Found;
use crate::analysis::path::series::{Series, is_flat, roots};

/// Work of the loads on the direction beside a bifurcation, over their size, that is hardly any.
const WORKLESS: f64 = 1e-2;

/// Count of the eigenvalues of the tangent at an equilibrium, which changes at critical points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct EigenvalueCount {
    /// Negative eigenvalues.
    pub negative: usize,
    /// Sign of the determinant.
    pub sign: i8,
    /// Eigenvalues that pass through zero while the circulatory part of the tangent grows.
    pub crossings: Option<usize>,
}

impl EigenvalueCount {
    /// Count at the end of a step.
    pub fn of(end: &End) -> Self {
        Self::new(end.negative, &end.tangent)
    }

    fn new(negative: usize, tangent: &PathTangent) -> Self {
        Self { negative, sign: tangent.determinant_sign, crossings: tangent.crossings }
    }
}

impl ArcLengthSteps<'_> {
    /// Places of the limit points of a step, where its load factor has an extremum, and the eigenvalues at its start, as far as they are no
    /// round-off: those at its end are compared with them.
    ///
    /// # Errors
    /// The load factor has the extremum of another path; the text gives the reason.
    pub(super) fn limits(
        &mut self,
        arc: &ArcStart,
        (end, loads): (&End, &Series),
        observer: &mut dyn Observer,
    ) -> std::result::Result<(Vec<f64>, EigenvalueCount), String> {
        let mut limits = roots(end.a, |a| loads.load_derivative(a, 1));
        let flat = is_flat(loads, end.a) && !self.is_driven();
        let flat_limit = limits.last().is_some_and(|limit| is_flat(loads, *limit));
        let mut start = EigenvalueCount::new(self.state.negative_pivots, &arc.tangent);
        if flat_limit && self.begins_beside_bifurcation(&arc.tangent) {
            // The eigenvalue that vanishes there, and the derivative of the load, are round-off at the start of the step.
            limits.clear();
            start = EigenvalueCount::of(end);
        }
        if flat && end.negative == start.negative {
            // Next to a bifurcation the load of a crossing path is constant, but for round-off. In a dead centre no eigenvalue vanishes.
            if let [at] = limits[..] {
                let mut known = Known::new(self, (arc, start.negative), end);
                self.refuse_fold(&mut known, (at, loads.load(at)), observer)?;
            }
            limits.clear();
        }
        Ok((limits, start))
    }

    /// Ends a step at its first load factor that is wanted, or at its limit point, where one of them lies before its end. Returns the limit point.
    ///
    /// # Errors
    /// There is no such end on the path; the text gives the reason.
    pub(super) fn end_before(
        &mut self,
        (arc, known): (&ArcStart, &mut Option<Known>),
        (loads, limit): (&Series, Option<f64>),
        (start, has_potential): (EigenvalueCount, bool),
        end: &mut End,
        observer: &mut dyn Observer,
    ) -> std::result::Result<Option<Found>, String> {
        let mut critical = None;
        let mut first = self.wanted(loads, limit.unwrap_or(f64::INFINITY).min(end.a));
        if let (None, Some(limit)) = (first, limit) {
            let inside = known.insert(Known::new(self, (arc, start.negative), end));
            let (found, load) = self.locate_limit(inside, limit, observer)?;
            first = self.wanted(&self.loads(arc, &found), found.a);
            *end = found;
            if first.is_none() {
                let found = self.extremum(inside, (end, load), (has_potential, start.sign), observer)?;
                critical = Some(found);
            }
        }
        if let Some((a, load)) = first {
            let known = known.get_or_insert_with(|| Known::new(self, (arc, start.negative), end));
            let tangent = PathTangent::between(self.system, [&arc.tangent, &end.tangent], a / end.a);
            *end = self.end_at_load(known, (a, load), tangent, observer)?;
        }
        Ok(critical)
    }

    /// Whether a step in a direction leads away from a bifurcation at its load factor along the crossing path, on which the loads do hardly any work
    /// there.
    fn begins_beside_bifurcation(&self, direction: &PathTangent) -> bool {
        let last = self.path().and_then(|path| path.critical.last());
        let is_near = last.is_some_and(|point| point.is_bifurcation_beside(self.state.time));
        let size = self.response.size_of_loads(self.system);
        is_near && direction.work.abs() <= WORKLESS * size
    }
}
