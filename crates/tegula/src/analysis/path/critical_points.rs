//! Critical points of a piece of a path: limit points are roots of dλ/da; bifurcations change the number of negative pivots of the
//! tangent without one.
//!
//! At a limit point `K φ = 0` with `φ = dv/da`. From the second derivative of the equilibrium, `φᵀ(dK/da)φ = (d²λ/da²) φᵀF`, which
//! tells the direction in which the eigenvalue passes through zero; so limit points and bifurcations that would cancel in the count
//! are told apart. The error of the load factor is `−φᵀR/φᵀF` with the residual R of the series there.

use super::expansion::Expansion;
use super::opposite_crossings::{CurveWithModes, Unstable};
use super::series::{Series, roots};
use super::state::{CriticalKind, CriticalPoint};
use crate::analysis::unstable_modes::normalize;
use crate::element::Nodal;
use crate::norm::larger;
use crate::system::{System, dot};

/// Part of the length of a piece within which a bifurcation is located.
const LOCATED: f64 = 1e-9;
/// Eigenvalue next to zero at a bifurcation, over that at the ends of the bracket.
const VANISHING: f64 = 1e-9;
/// Eigenvalue where the count changes over those at the ends of the bracket, above which it has not passed through zero.
const JUMP: f64 = 1e-6;
/// Eigenvalue next to zero over the largest one at the nearest equilibrium from which one that is lost in round-off is approached again, by half of
/// the way; and that from which the bifurcation is extrapolated.
const RETREAT: f64 = 1e-2;
const LOST: f64 = 1e-4;
/// Part of the way from the lost equilibrium back to the nearest one, where that is farther away and a secant has led to the lost one.
const SHORT_WAY: f64 = 1.0 / 16.0;
/// Distance of eigenvalues over the largest one from their line that is round-off in very thin shells.
const ROUND_OFF: f64 = 1e-3;
/// Difference of two slopes of the eigenvalue over them up to which they belong to one curve.
const SAME_SLOPE: f64 = 0.1;
/// Eigenvalue over the largest one at the trials from which it is no round-off.
const RESOLVED: f64 = 1e-5;
/// Eigenvalue of a trial farther away over the largest one and over that next to zero, and the largest ratio of the slopes up to both.
const FARTHER: [f64; 2] = [1e-2, 4.0];
const STEADY: f64 = 2.0;
/// Largest number of factorisations for one bifurcation.
const MOST_TRIALS: usize = 40;
/// Iterations of the inverse iteration for the eigenvalue next to zero.
pub const INVERSE_ITERATIONS: usize = 12;
/// Work of the loads on a mode, over the norms of both, below which it is none, and below which it may be that on a local mode: the number of negative
/// eigenvalues decides then.
const WITHOUT_WORK: f64 = 1e-9;
const HARDLY_ANY_WORK: f64 = 1e-4;
/// Part of the piece's length before and behind an extremum at which negative eigenvalues are counted.
const BESIDE: f64 = 1e-3;
/// Part of the piece's length for differences of forces at a limit point.
const DIFFERENCE: f64 = 1e-4;

/// Critical point of a piece, at the parameter `a` of its series.
pub struct Found {
    /// Parameter of the series.
    pub a: f64,
    /// The point; its position on the whole path is filled in later.
    pub point: CriticalPoint,
}

impl Found {
    /// Whether the path passes this bifurcation as the crossing one, along the critical mode: no eigenvalue changes its sign then.
    pub fn is_passed_along_mode(&self) -> bool {
        self.point.kind == CriticalKind::Bifurcation && self.point.change == 0
    }

    /// Critical mode on the side of a sign.
    pub fn mode_on_side(&self, sign: f64) -> Vec<Nodal> {
        self.point.mode.iter().map(|x| x.map(|x| sign * x)).collect()
    }
}

/// Limit points of a piece up to the parameter `end`. The tangent that is factored afterwards may be another one.
pub fn limit_points(system: &System, expansion: &mut Expansion, series: &Series, end: f64) -> Vec<Found> {
    let places = roots(end, |a| series.load_derivative(a, 1));
    places.into_iter().map(|a| limit_point(system, expansion, series, (a, end))).collect()
}

/// Change of the number of negative eigenvalues at an extremum of the load factor; `None` where it is not known.
fn change_at(
    system: &System,
    expansion: &mut Expansion,
    series: &Series,
    (a, end): (f64, f64),
) -> Option<i32> {
    let mut u = vec![[0.0; 3]; system.vectors()];
    let mut count = |at: f64| {
        series.displacements(at, &mut u);
        expansion.factor(system, &u, series.load(at)).ok()
    };
    let before = count(f64::max(a - BESIDE * end, 0.5 * a))?;
    let behind = count(f64::min(a + BESIDE * end, 0.5 * (a + end)))?;
    Some(behind as i32 - before as i32)
}

fn limit_point(system: &System, expansion: &mut Expansion, series: &Series, (a, end): (f64, f64)) -> Found {
    let fields = || vec![[0.0; 3]; system.vectors()];
    let (mut u, mut mode, mut force) = (fields(), fields(), fields());
    series.displacements(a, &mut u);
    series.direction(a, &mut mode);
    let load = series.load(a);
    let mut residual = vec![0.0; system.unknowns()];
    expansion.residual(system, &u, load, &mut residual);
    expansion.load_at(system, &u, load, &mut force);
    let mut work = dot(&mode, &force);
    if !system.dofs().prescribed.is_empty() {
        // Forces that prescribed displacements exert per load factor: −K ū on φ, and K φ is the change of the internal forces.
        let step = DIFFERENCE * end;
        let (mut before, mut behind) = (fields(), fields());
        for (at, out) in [(a - step, &mut before), (a + step, &mut behind)] {
            series.displacements(at, &mut u);
            expansion.forces(system, &u, load, out);
        }
        let moved = expansion.prescribed();
        work -= (dot(moved, &behind) - dot(moved, &before)) / (2.0 * step);
    }
    series.displacements(a, &mut u);
    let mut free = vec![0.0; system.unknowns()];
    expansion.assembly().frames.components(&mode, &mut free);
    let unbalanced: f64 = free.iter().zip(&residual).map(|(x, r)| x * r).sum();
    let correction = if work == 0.0 { 0.0 } else { -unbalanced / work };
    let curvature = series.load_derivative(a, 2) * work;
    // A crossing path has an extremum of the load where it passes the bifurcation; its loads do no work on its mode there.
    let size = system.norm(&mode) * system.force_norm(&force);
    let crossing = work.abs() <= WITHOUT_WORK * size
        || (work.abs() <= HARDLY_ANY_WORK * size
            && change_at(system, expansion, series, (a, end)).is_none_or(|change| change == 0));
    let (kind, change) = match (crossing, curvature < 0.0) {
        (true, _) => (CriticalKind::Bifurcation, 0),
        (false, true) => (CriticalKind::Limit, 1),
        (false, false) => (CriticalKind::Limit, -1),
    };
    let load = if crossing { load } else { load + correction };
    normalize(system, &mut mode);
    let point = CriticalPoint { kind, load, position: 0.0, change, u, mode };
    Found { a, point }
}

/// Curve of equilibria, on which critical points are looked for.
pub trait Curve {
    /// Equilibrium at a parameter.
    ///
    /// # Errors
    /// There is none, or its tangent has no factor; the text gives the reason.
    fn trial(&mut self, a: f64) -> Result<Trial, String>;

    /// Whether the curve may pass bifurcations at which eigenvalues are lost in round-off.
    fn passes_round_off(&self) -> bool {
        true
    }
}

/// Equilibrium on a curve.
pub struct Trial {
    /// Displacements.
    pub u: Vec<Nodal>,
    /// Load factor.
    pub load: f64,
    /// Negative eigenvalues of the tangent.
    pub negative: usize,
    /// Its eigenvalue next to zero, and the eigenvector.
    pub softest: (f64, Vec<Nodal>),
    /// Work of the loads on the eigenvector over that on the direction of the curve, 0 on a curve that cannot jump, and the largest one at a
    /// bifurcation. It may be in proportion to the eigenvalue. At the limit point of another path, onto which a step may leap beside a path that
    /// nearly crosses, it does not vanish with the eigenvalue.
    pub work: [f64; 2],
    /// Whether no other path nearly crosses this one, to which trials could go over.
    pub is_alone: bool,
}

/// Curve of a power series.
pub struct SeriesCurve<'a> {
    /// The compiled model.
    pub system: &'a System,
    /// Workspace of the expansion.
    pub expansion: &'a mut Expansion,
    /// The series.
    pub series: &'a Series,
}

impl Curve for SeriesCurve<'_> {
    fn trial(&mut self, a: f64) -> Result<Trial, String> {
        let Self { system, expansion, series } = self;
        let mut u = vec![[0.0; 3]; system.vectors()];
        series.displacements(a, &mut u);
        let load = series.load(a);
        let negative = expansion.factor(system, &u, load)?;
        let mut softest = expansion.eigenvalue_next_to_zero(system, INVERSE_ITERATIONS)?;
        system.orient(&mut softest.1);
        Ok(Trial { u, load, negative, softest, work: [0.0; 2], is_alone: true })
    }

    fn passes_round_off(&self) -> bool {
        // Coefficients of the next series would be round-off, too.
        false
    }
}

impl CurveWithModes for SeriesCurve<'_> {
    fn unstable(&mut self, a: f64) -> Result<Unstable, String> {
        let Self { system, expansion, series } = self;
        let mut u = vec![[0.0; 3]; system.vectors()];
        series.displacements(a, &mut u);
        let load = series.load(a);
        let negative = expansion.factor(system, &u, load)?;
        let modes = expansion.unstable_modes(system, negative).ok_or("the unstable modes were not found")?;
        Ok(Unstable { u, load, negative, modes })
    }
}

/// Bifurcations of a curve up to the parameter `end`, where the tangent has `change` more negative eigenvalues than the `start` ones at
/// parameter 0, beside those that limit points explain (parameters and changes). The tangent that is factored afterwards is another one.
///
/// # Errors
/// The tangent has no factor where it should; the text gives the reason.
pub fn bifurcations(
    curve: &mut dyn Curve,
    end: f64,
    (start, change): (usize, i32),
    limits: &[(f64, i32)],
) -> Result<Vec<Found>, String> {
    bifurcations_between(curve, (end, start), vec![([0.0, end], [0, change])], limits)
}

/// Interval of parameters, and at both its ends the number of negative eigenvalues beyond those at the start of the curve and those that known
/// critical points explain.
pub type Counted = ([f64; 2], [i32; 2]);

/// Bifurcations in intervals of a curve up to the parameter `end`, at whose start the tangent has `start` negative eigenvalues. The tangent that is
/// factored afterwards is another one.
///
/// # Errors
/// The tangent has no factor where it should; the text gives the reason.
pub fn bifurcations_between(
    curve: &mut dyn Curve,
    (end, start): (f64, usize),
    mut open: Vec<Counted>,
    known: &[(f64, i32)],
) -> Result<Vec<Found>, String> {
    let mut out = Vec::new();
    let mut search = Search { curve, start, limits: known };
    while let Some((interval, counts)) = open.pop() {
        if counts[0] == counts[1] {
            continue;
        }
        match search.locate(interval, counts, end)? {
            Located::Point(found) => out.push(found),
            Located::Split(middle, count) => {
                open.push(([interval[0], middle], [counts[0], count]));
                open.push(([middle, interval[1]], [count, counts[1]]));
            }
        }
    }
    out.sort_by(|p, q| p.a.total_cmp(&q.a));
    Ok(out)
}

/// Outcome of the search in an interval.
enum Located {
    /// The one crossing in it.
    Point(Found),
    /// More than one crossing: a point between them, and the count there.
    Split(f64, i32),
}

struct Search<'a> {
    curve: &'a mut dyn Curve,
    /// Negative eigenvalues at the start of the curve.
    start: usize,
    limits: &'a [(f64, i32)],
}

impl Search<'_> {
    /// Finds the crossing of an interval by the secant of the eigenvalue next to zero, kept in the bracket of the count.
    fn locate(&mut self, interval: [f64; 2], counts: [i32; 2], whole: f64) -> Result<Located, String> {
        let [mut low, mut high] = interval;
        let mut known: Vec<Known> = Vec::new();
        let mut best: Option<(f64, Trial)> = None;
        let (mut again, mut extrapolated) = (None, None);
        for number in 0..MOST_TRIALS {
            let middle = 0.5 * (low + high);
            let next = secant(&known).filter(|a| number % 4 != 3 && *a > low && *a < high);
            let a = again.take().or(next).unwrap_or(middle);
            let trial = match (self.curve.trial(a), &best) {
                (Ok(trial), _) => trial,
                (Err(reason), Some((nearest, best))) => {
                    // Next to the point an equilibrium may be lost in round-off.
                    let part = best.softest.0.abs() / largest_of(&known);
                    extrapolated = extrapolated_zero(&known, *nearest)
                        .filter(|[zero, _]| part <= LOST && *zero >= low && *zero <= high);
                    if part <= JUMP || extrapolated.is_some() {
                        break;
                    }
                    // A secant through far trials may have met the point at once.
                    if !((part <= RETREAT || next == Some(a)) && high - low > LOCATED * whole) {
                        return Err(reason);
                    }
                    let way = if part <= RETREAT { 0.5 } else { SHORT_WAY };
                    again = Some(a + way * (nearest - a));
                    continue;
                }
                (Err(reason), None) => return Err(reason),
            };
            let explained: i32 = self.limits.iter().filter(|(at, _)| *at < a).map(|(_, change)| change).sum();
            let count = trial.negative as i32 - self.start as i32 - explained;
            if count != counts[0] && count != counts[1] {
                return Ok(Located::Split(a, count));
            }
            let eigenvalue = trial.softest.0;
            known.push(Known { a, eigenvalue, load: trial.load });
            if count == counts[0] {
                low = a
            } else {
                high = a
            }
            let largest = largest_of(&known);
            // Of several crossings the first zero is not the only one.
            let vanishes = (counts[1] - counts[0]).abs() == 1 && eigenvalue.abs() <= VANISHING * largest;
            let better = best.as_ref().is_none_or(|(_, b)| eigenvalue.abs() <= b.softest.0.abs());
            if better {
                best = Some((a, trial));
            }
            if vanishes || high - low <= LOCATED * whole {
                break;
            }
        }
        let best = best.ok_or("no bifurcation was located")?;
        self.bifurcation(best, (&known, extrapolated), counts[1] - counts[0]).map(Located::Point)
    }

    /// Bifurcation next to the trial of the smallest eigenvalue, at which the number of negative eigenvalues changes by `change`; at the zero and load factor
    /// that were extrapolated, where the trials beside it are lost in round-off.
    ///
    /// # Errors
    /// The eigenvalue does not vanish there.
    fn bifurcation(
        &self,
        (a, best): (f64, Trial),
        (known, extrapolated): (&[Known], Option<[f64; 2]>),
        change: i32,
    ) -> Result<Found, String> {
        let Trial { u, load, softest: (eigenvalue, mode), work, is_alone, .. } = best;
        let part = eigenvalue.abs() / largest_of(known);
        let among_round_off = if self.curve.passes_round_off() && extrapolated.is_none() && part > JUMP {
            zero_among_round_off(known)
        } else {
            None
        };
        let is_steady = is_alone || among_round_off.is_some() || passes_steadily(known);
        let extrapolated = extrapolated.or(among_round_off);
        let vanishing = if extrapolated.is_some() { LOST } else { JUMP };
        let [a, load] = extrapolated.unwrap_or([a, load]);
        if !(part <= vanishing && work[0] <= larger(part, work[1]) && is_steady) {
            return Err(
                "an eigenvalue does not vanish as at a bifurcation: the step has gone over to another path"
                    .into(),
            );
        }
        let kind = CriticalKind::Bifurcation;
        Ok(Found { a, point: CriticalPoint { kind, load, position: 0.0, change, u, mode } })
    }
}

/// Equilibrium of a search.
struct Known {
    a: f64,
    eigenvalue: f64,
    load: f64,
}

fn largest_of(known: &[Known]) -> f64 {
    known.iter().map(|known| known.eigenvalue.abs()).fold(0.0, crate::norm::larger)
}

/// Root of the line through the eigenvalues at a place and at the nearest one with the same sign, and the load factor there. The eigenvalue must
/// go on along this line to the nearest one with the other sign: where a step has gone over to another path, it jumps.
fn extrapolated_zero(known: &[Known], nearest: f64) -> Option<[f64; 2]> {
    let p = known.iter().find(|p| p.a == nearest)?;
    let nearest_with = |same: bool| {
        let others =
            known.iter().filter(|q| q.a != p.a && ((q.eigenvalue > 0.0) == (p.eigenvalue > 0.0)) == same);
        others.min_by(|q, r| (q.a - p.a).abs().total_cmp(&(r.a - p.a).abs()))
    };
    let (same, other) = (nearest_with(true)?, nearest_with(false)?);
    let slope = |q: &Known| (q.eigenvalue - p.eigenvalue) / (q.a - p.a);
    let goes_on = (slope(other) / slope(same) - 1.0).abs() <= SAME_SLOPE;
    let part = p.eigenvalue / (p.eigenvalue - same.eigenvalue);
    goes_on.then_some([p.a + part * (same.a - p.a), p.load + part * (same.load - p.load)])
}

/// Zero of the line through the two smallest eigenvalues that are no round-off, and the load factor there, where the next one belongs to this line and all smaller
/// ones lie beside it by no more than round-off of very thin shells. These change their signs with round-off, so that the place at which the count changes is
/// none of the bifurcation.
fn zero_among_round_off(known: &[Known]) -> Option<[f64; 2]> {
    let size = |p: &Known| p.eigenvalue.abs();
    let largest = largest_of(known);
    let (mut resolved, others): (Vec<&Known>, Vec<&Known>) =
        known.iter().partition(|p| size(p) >= RETREAT * largest);
    resolved.sort_by(|p, q| size(p).total_cmp(&size(q)));
    let [p, q, r, ..] = resolved[..] else { return None };
    let slope = |q: &Known| (q.eigenvalue - p.eigenvalue) / (q.a - p.a);
    let along = -p.eigenvalue / slope(q);
    let (zero, load) = (p.a + along, p.load + along * (q.load - p.load) / (q.a - p.a));
    let is_round_off = |o: &Known| (o.eigenvalue - slope(q) * (o.a - zero)).abs() <= ROUND_OFF * largest;
    let goes_on = (slope(r) / slope(q) - 1.0).abs() <= SAME_SLOPE && others.iter().all(|o| is_round_off(o));
    goes_on.then_some([zero, load])
}

/// Whether the eigenvalue goes through zero at a slope that it has farther away, too, as at a bifurcation. Trials that have gone over to another
/// path pass its fold, and next to it the eigenvalue is much steeper.
fn passes_steadily(known: &[Known]) -> bool {
    let size = |p: &Known| p.eigenvalue.abs();
    let slope = |p: &Known, q: &Known| (q.eigenvalue - p.eigenvalue) / (q.a - p.a);
    let smallest = |p: &&Known, q: &&Known| size(p).total_cmp(&size(q));
    let Some(zero) = known.iter().min_by(smallest) else { return false };
    let largest = largest_of(known);
    let Some(next) = known.iter().filter(|p| p.a != zero.a && size(p) >= RESOLVED * largest).min_by(smallest)
    else {
        return true;
    };
    let far = larger(FARTHER[0] * largest, FARTHER[1] * size(next));
    let mut farther = known.iter().filter(|p| size(p) >= far).peekable();
    let goes_on = |p: &Known| {
        let ratio = slope(zero, next) / slope(next, p);
        (1.0 / STEADY..=STEADY).contains(&ratio)
    };
    farther.peek().is_none() || farther.any(goes_on)
}

/// Root of the line through the last two eigenvalues.
fn secant(known: &[Known]) -> Option<f64> {
    let [.., p, q] = known else { return None };
    let a = q.a - q.eigenvalue * (q.a - p.a) / (q.eigenvalue - p.eigenvalue);
    (p.eigenvalue != q.eigenvalue).then_some(a)
}
