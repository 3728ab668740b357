//! Snap-through test of a load step: whether a stable path leads from the last equilibrium to the new one.
//!
//! A path of stable equilibria u(τ) under the loads F(τ) of a step, 0 ≤ τ ≤ 1, has four properties that are tested from what
//! is known at the ends of the step.
//!
//! - **Speed.** The step is `Δu = ∫ u' dτ`, so it is not longer than the fastest part of the path. Where both ends are slow
//!   and the step is long, there was no path in between, or one that is soft in the middle:
//!
//!   ```text
//!   |Δu| ≤ 1.5 max(|u'(0)|, |u'(1)|),   K u' = ΔF
//!   ```
//!
//!   Near a limit point u'(0) grows beyond all bounds and carries no information. A step that begins softer than the one
//!   before must therefore not end with less than half of the speed: `|u'(1)| ≥ ½ |u'(0)|`.
//!
//!   u'(0) is the first increment of Newton's method, u'(1) costs a solution with the last factor. The norm is that of
//!   `System::norm`. Halving the step decides: on a path u' becomes uniform in the step, a snap keeps its length.
//! - **Mean speed.** Where u' changes from one end to the other, its mean Δu lies in the triangle of u'(0), u'(1) and zero. A step that lies
//!   half its length away from there has gone where neither tangent leads.
//! - **Energy.** Loads of constant direction that grow in proportion, F = F₀ + τ ΔF, do the work of the strain energy U.
//!   With `Π* = F·u − U` it is `dΠ*/dτ = ΔF·u`, and stability, `ΔF·u' = u'·K u' > 0`, lets ΔF·u grow along the path, so
//!
//!   ```text
//!   ΔF·u(0) ≤ Π*(1) − Π*(0) ≤ ΔF·u(1)
//!   ```
//!
//!   The preload of springs that is ramped enters like a load: U depends on τ then, in proportion, and `∂U/∂τ` is subtracted from ΔF·u.
//!   In a snap Π* gains the energy that is released. Near a limit point, where u'(0) is large, only this test is left. Where
//!   ΔF·u grows at most as fast as at the start, `ΔF·u(1) − (Π*(1) − Π*(0)) ≥ (ΔF·Δu)²/(2 ΔF·u'(0))`; a step that stores much
//!   less is doubted, too.
//! - **Direction.** A path leaves its start along u'(0). A step that leads the other way has reached another branch.
//!
//! Behind a bifurcation, a model with a small imperfection has stable equilibria on both sides, but its path leads to one of them; the
//! other side begins at a limit point of its own. A step to there passes all four tests: it releases no energy, and the model is about as
//! stiff on either side. That such a point is near show negative pivots of the iteration. Then a step that does not follow a smooth path,
//!
//! ```text
//! |Δu − ½ (u'(0) + u'(1))| > 0.1 |Δu|,
//! ```
//!
//! is doubtful: the equilibrium path decides which equilibrium belongs to it. Where the path cannot be followed, the step
//! must end on the side, along the softest mode at its end, to which u'(0) moves the model.
//!
//! J. M. T. Thompson, G. W. Hunt, *A General Theory of Elastic Stability*, Wiley 1973, for the sign of ΔF·u'.
//!
//! The tests miss a snap within one step whose tangents at both ends are as soft as the snap is long and lead the same way, and which
//! releases less energy than the bound leaves: shorter load steps resolve more.

use super::StaticEquation;
use crate::analysis::newton::Equation;
use crate::element::Nodal;
use crate::norm::larger;
use crate::system::{Assembly, EvaluationPoint, System, add_multiple, dot};

/// Ratio of the displacement of a step to that of the faster of its two ends above which the step is refused. Large
/// steps on smooth paths reach 1.27 (quarter cylinder of Sect. 5.2 in one step), snaps of roofs begin at 2.1.
const LEAP: f64 = 1.5;
/// Distance of a step from the triangle of the speeds at its ends, over its length, above which it is refused. Large steps on smooth paths reach 0.46
/// (quarter cylinder in one step).
const AWAY: f64 = 0.5;
/// Ratio of the speed at the end of a step to that at its start below which the step is refused on a path that softens.
const STIFFER: f64 = 0.5;
/// Ratio of the speed at the start of a step to that at the start of the one before above which a path softens.
pub(super) const SOFTER: f64 = 1.1;
/// Work that a step stores over the least that its first tangent lets expect of a path without sudden bends, below which it is doubted.
const LEAST_STORED: f64 = 0.5;
/// Cosine between the first tangent and the step below which the step is doubted.
const BACKWARDS: f64 = -0.2;
/// Part of the displacement of a step by which it differs at most from the mean of the speeds at its ends on a smooth path.
const SMOOTH: f64 = 0.1;
/// Part of the displacement of a step along the softest mode above which its side counts.
const SIDEWAYS: f64 = 1e-2;
/// Round-off of energies, over their sum.
const ROUNDING: f64 = 1e-9;

/// Reason to doubt from the energy that is released in a step that a path leads through it, as text; `None` where the bounds hold or do
/// not apply: to follower loads, actuators, prescribed motions and strains, loads that do not grow in proportion, and materials that
/// dissipate. `response` is u'(0).
pub(super) fn released_energy(
    system: &System,
    assembly: &mut Assembly,
    (before, after, history): (&StaticEquation, &StaticEquation, &[f64]),
    response: &[Nodal],
    [first, last, change]: [&mut [Nodal]; 3],
) -> Option<String> {
    let elastic = system.without_internal_variables()
        && system.prescribed_strains.is_empty()
        && !system.has_actuators();
    let driven = system.joints.iter().any(|joint| joint.drive.is_some());
    if !elastic || driven || system.has_follower_loads() || !system.dofs().prescribed.is_empty() {
        return None;
    }
    // Loads at the middle of the step: in proportion, they are the mean of those at its ends.
    change.fill([0.0; 3]);
    system.add_dead_loads(0.5 * (before.time + after.time), 1.0, change);
    before.external_minus_inertia(system, first);
    after.external_minus_inertia(system, last);
    let (mut bend, mut size) = (0.0_f64, 0.0_f64);
    for ((c, f), l) in change.iter_mut().zip(&*first).zip(&*last) {
        for i in 0..3 {
            bend = bend.max((c[i] - 0.5 * (f[i] + l[i])).abs());
            c[i] = l[i] - f[i];
            size = size.max(c[i].abs());
        }
    }
    if bend.is_nan() || bend > ROUNDING * size {
        return None;
    }
    let mut energy = |of: &StaticEquation, time| {
        assembly.strain_energy(system, &EvaluationPoint::at_rest(system, &of.u, time, history))
    };
    let strain = [before, after].map(|e| energy(e, e.time));
    let work = [dot(first, &before.u), dot(last, &after.u)];
    let gain = (work[1] - strain[1]) - (work[0] - strain[0]);
    // The energy of springs whose preload is ramped changes without displacements, too.
    let ramps = [before, after].iter().any(|e| system.part_of_preload(e.time) != 1.0) && system.has_springs();
    let ramped = match ramps {
        true => [energy(before, after.time) - strain[0], strain[1] - energy(after, before.time)],
        false => [0.0; 2],
    };
    let most = dot(change, &after.u) - ramped[1];
    let range = most - (dot(change, &before.u) - ramped[0]);
    let rounding = ROUNDING * (strain[1].abs() + strain[0].abs() + work[1].abs() + work[0].abs());
    if !(range > rounding) {
        return None;
    }
    if gain > most + rounding {
        let released = (gain - most) / range;
        return Some(format!(
            "the step releases energy, {released:.2} times the work of its load increment, where a stable path releases none"
        ));
    }
    // The first tangent of a ramp is that of its end: it has another part of the preload than the start.
    if ramps {
        return None;
    }
    let stored = (most - gain) / range;
    let expected = 0.5 / larger(dot(change, response) / range, 1.0);
    (stored < LEAST_STORED * expected).then(|| {
        format!(
            "the step stores {:.1} % of the work of its load increment, where its first tangent lets expect {:.0} %",
            100.0 * stored,
            100.0 * expected
        )
    })
}

/// Reason to doubt that a path leads through the step Δu, whose start moves with the speed u'(0) in the opposite direction, as text.
pub(super) fn turned_back(system: &System, step: &[Nodal], response: &[Nodal]) -> Option<String> {
    let cosine = cosine(system, step, response);
    (cosine < BACKWARDS).then(|| {
        format!("the step leads away from the direction in which its first tangent moves the model (cosine {cosine:.2})")
    })
}

/// Reason to doubt the first step behind a path that has ended at a critical point, as text: it leads to the side on which that path is unstable.
pub(super) fn unstable_side(system: &System, step: &[Nodal]) -> Option<String> {
    let path = &system.path_before;
    if !path.at_critical_point || path.change == 0 {
        return None;
    }
    let along = cosine(system, step, &path.direction);
    let onto_stable = if path.change > 0 { -along } else { along };
    (onto_stable < BACKWARDS).then(|| {
        format!(
            "the path before has ended at a critical point, and the step leads to the side on which that path is unstable (cosine {along:.2} \
             with its direction)"
        )
    })
}

fn cosine(system: &System, a: &[Nodal], b: &[Nodal]) -> f64 {
    system.inner_product(a, b) / (system.norm(a) * system.norm(b))
}

/// Reason to doubt a step that lies far from the triangle of the speeds u'(0) and −u'(1) at its ends and zero, as text.
pub(super) fn leaves_speeds(system: &System, step: &[Nodal], speeds: (&[Nodal], &[Nodal])) -> Option<String> {
    let away = distance_from_speeds(system, step, speeds);
    (away > AWAY).then(|| {
        format!(
            "the step goes where neither tangent at its ends leads, {away:.2} of its length away from there"
        )
    })
}

/// Distance of the displacement of a step from the triangle of the speeds u'(0) and −u'(1) at its ends and zero, over the displacement.
fn distance_from_speeds(system: &System, step: &[Nodal], (start, back): (&[Nodal], &[Nodal])) -> f64 {
    let product = |a: &[Nodal], b: &[Nodal]| system.inner_product(a, b);
    // The speed at the end is −`back`.
    let (aa, ab, bb) = (product(start, start), -product(start, back), product(back, back));
    let (ad, bd, dd) = (product(start, step), -product(back, step), product(step, step));
    // Squared distance at a point of the triangle.
    let distance =
        |[a, b]: [f64; 2]| dd - 2.0 * (a * ad + b * bd) + a * a * aa + 2.0 * a * b * ab + b * b * bb;
    let part = |along: f64, length: f64| if length > 0.0 { (along / length).clamp(0.0, 1.0) } else { 0.0 };
    let between = part(bd - ad + aa - ab, aa - 2.0 * ab + bb);
    let edges = [[part(ad, aa), 0.0], [0.0, part(bd, bb)], [1.0 - between, between]];
    let gram = aa * bb - ab * ab;
    let inside = [(ad * bb - bd * ab) / gram, (bd * aa - ad * ab) / gram];
    let is_inside = inside.iter().all(|x| *x >= 0.0) && inside[0] + inside[1] <= 1.0;
    let least = if is_inside {
        distance(inside)
    } else {
        edges.into_iter().map(distance).fold(f64::INFINITY, f64::min)
    };
    // The difference of equal products is round-off.
    larger(least / dd, 0.0).sqrt()
}

/// Whether a step follows a smooth path, from the speeds u'(0) and −u'(1) at its ends.
pub(super) fn is_smooth(system: &System, step: &[Nodal], (start, back): (&[Nodal], &[Nodal])) -> bool {
    let mut away = step.to_vec();
    add_multiple(&mut away, -0.5, start);
    add_multiple(&mut away, 0.5, back);
    system.norm(&away) <= SMOOTH * system.norm(step)
}

/// Reason to doubt a step whose iteration met negative pivots, as text: along the softest mode at its end it has gone to the other side than its
/// start moves to.
pub(super) fn other_side(system: &System, [step, start]: [&[Nodal]; 2], mode: &[Nodal]) -> Option<String> {
    let [moved, speed] = [step, start].map(|x| system.inner_product(mode, x));
    let noticeable = moved.abs() > SIDEWAYS * system.norm(step);
    (noticeable && moved * speed < 0.0).then(|| {
        "the iteration met negative pivots, and along the softest mode the step has gone to the other side than its first tangent \
         moves the model to"
            .into()
    })
}

/// Displacement of a step and the speeds at its ends.
#[derive(Debug, Clone, Copy)]
pub(super) struct Speeds {
    /// Displacement of the step, |Δu|.
    pub moved: f64,
    /// Speed at the start of the step, |u'(0)|.
    pub start: f64,
    /// Whether the path softens up to the start of the step.
    pub softens: bool,
}

impl Speeds {
    /// Whether the decision needs the speed at the end of the step.
    pub fn need_the_end(&self) -> bool {
        self.softens || self.moved > LEAP * self.start
    }

    /// Reason to doubt that a path leads through the step, from the speed |u'(1)| at its end, as text.
    pub fn doubt(&self, end: f64) -> Option<String> {
        let fastest = self.start.max(end);
        if self.moved > LEAP * fastest {
            let times = self.moved / fastest;
            return Some(format!(
                "the displacement of the step is {times:.2} times the larger one that the tangents at its ends predict"
            ));
        }
        (self.softens && end < STIFFER * self.start).then(|| {
            let times = self.start / end;
            format!(
                "the path softens, but the tangent at the end of the step is {times:.2} times as stiff as at its start"
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_longer_than_both_ends_tell_are_doubted() {
        // Hinged roof of 12.7 mm: a step over its limit point, one before it, and the quarter cylinder in one step.
        let speeds = |moved, start| Speeds { moved, start, softens: false };
        assert!(speeds(7.47e-2, 8.77e-3).doubt(1.79e-3).is_some());
        assert!(speeds(6.09e-3, 4.67e-3).doubt(8.77e-3).is_none());
        assert!(speeds(0.740, 0.431).need_the_end() && speeds(0.740, 0.431).doubt(0.769).is_none());
        assert!(!speeds(0.632, 1.133).need_the_end(), "stiffening paths cost nothing");
    }

    #[test]
    fn steps_that_begin_near_a_limit_point_and_end_stiff_are_doubted() {
        // Pull-out of a cylinder: soft before the limit point, stiff behind it, and no longer than the soft end predicts.
        let speeds = Speeds { moved: 0.1257, start: 0.1216, softens: true };
        assert!(speeds.doubt(0.0356).is_some() && speeds.doubt(0.1).is_none());
        assert!(Speeds { softens: false, ..speeds }.doubt(0.0356).is_none(), "a path that only stiffens");
    }
}
