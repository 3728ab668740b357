//! Piece of a path: one series, the length up to which it is used, and the points on it that are reported.

use super::branch::{self, Branch, onto_branch};
use super::critical_points::{Found, INVERSE_ITERATIONS, SeriesCurve, bifurcations, limit_points};
use super::crossing::refuse_fold_of_other_path;
use super::expansion::{Directions, Expansion};
use super::geometric;
use super::opposite_crossings::{Place, opposite_crossings};
use super::series::{Series, is_flat};
use super::start::{away_from_critical_point, forward};
use super::state::{CriticalKind, CriticalPoint, ExpansionPoint};
use crate::analysis::dynamics::project_unit_vectors;
use crate::analysis::unstable_modes::UnstableModes;
use crate::element::Nodal;
use crate::model::PathAnalysis;
use crate::norm::larger;
use crate::system::{System, add_multiple};

/// Residual at the end of a piece over the forces that is too large; the piece is shortened then.
const LARGEST_RESIDUAL: f64 = 1e-5;
/// Errors of the displacements and of the load factor at the end of a piece over them that are too large. Next to a bifurcation small
/// residuals have large responses along the path, which are errors of the load factor.
const LARGEST_ERROR: f64 = 1e-6;
/// Error of the load factor over it from which on the next piece begins at a corrected point: else errors would add up from piece to piece.
const CORRECTED: f64 = 1e-7;
/// Corrections of the end of a piece.
const CORRECTIONS: usize = 3;
/// Newton iterations at the load factor at which the path ends, and the largest first increment over the displacements: larger ones may lead to another path.
const MOST_AT_LOAD: usize = 10;
const MOST_CORRECTED: f64 = 1e-2;
/// Size of the next increment over the displacements, by the decrease of the residual, below which the iteration there ends.
const AT_LOAD: f64 = 1e-9;
/// Factor by which a piece is shortened whose end has too large a residual or error, or a singular tangent.
const SHORTER: f64 = 0.8;
/// Shortenings after which a piece is given up: where the method is not given, the arc-length method takes over with longer steps.
const MOST_SHORTENED: usize = 40;
const MOST_BEFORE_ARC_LENGTH: usize = 10;
/// Largest length of a piece over that at which the residual of the step before has faded: beyond, it would grow.
const BEYOND: f64 = 2.0;
/// Place at which the tangent is not yet singular, over the parameter of a bifurcation.
const BEFORE_BIFURCATION: f64 = 0.9;
/// Distance of two points over the length of the piece below which they are one.
const SAME: f64 = 1e-9;

/// Start of a piece, whose tangent is factored.
pub struct Start {
    point: ExpansionPoint,
    directions: Directions,
    /// Negative pivots of the tangent.
    negative: usize,
    /// Eigenvectors of its negative eigenvalues, where they are known.
    unstable: Option<UnstableModes>,
}

impl Start {
    /// Factors the tangent at an expansion point.
    ///
    /// # Errors
    /// The tangent is singular; the text gives the reason.
    pub fn new(
        system: &System,
        expansion: &mut Expansion,
        (point, options): (ExpansionPoint, &PathAnalysis),
    ) -> Result<Self, String> {
        let at_start = point.position == 0.0 && point.direction.is_empty();
        if let Some(direction) = away_from_critical_point(system, options).filter(|_| at_start) {
            return Self::away_from_critical_point(system, expansion, (point, direction), options);
        }
        let negative = expansion.factor(system, &point.u, point.load)?;
        let directions = expansion.directions(system, &point.u, point.load)?;
        let direction = match forward(system, &directions.unit) {
            Some(_) if at_start && options.end_load > 0.0 => system.path_before.direction.clone(),
            _ => point.direction,
        };
        Ok(Self { point: ExpansionPoint { direction, ..point }, directions, negative, unstable: None })
    }

    /// Start next to a critical point, at which a path begins, in a direction.
    fn away_from_critical_point(
        system: &System,
        expansion: &mut Expansion,
        (point, direction): (ExpansionPoint, &[Nodal]),
        options: &PathAnalysis,
    ) -> Result<Self, String> {
        if !system.dofs().prescribed.is_empty() {
            return Err(
                "the path begins at a critical point, and prescribed motions work on the way from there"
                    .into(),
            );
        }
        let at = (point.u.as_slice(), point.load);
        let Branch { u, load, negative } =
            onto_branch(system, expansion, at, (direction, options.end_load)).map_err(branch::not_found)?;
        let directions = expansion.directions(system, &u, load)?;
        let direction = direction.to_vec();
        let point = ExpansionPoint { u, load, direction, ..point };
        Ok(Self { point, directions, negative, unstable: None })
    }

    /// The expansion point.
    pub fn point(&self) -> &ExpansionPoint {
        &self.point
    }
}

/// Why there is no piece.
pub struct NoPiece {
    /// Reason, as text.
    pub reason: String,
    /// Whether there is a series that was to go over to a crossing path, on which a wanted load factor is too near.
    pub wanted_too_near: bool,
}

impl From<String> for NoPiece {
    fn from(reason: String) -> Self {
        Self { reason, wanted_too_near: false }
    }
}

/// Piece of a path.
pub struct Piece {
    series: Series,
    start: ExpansionPoint,
    negative: usize,
    /// Length of the piece.
    length: f64,
    /// Parameters of the points that are reported, ascending; the last one is the end.
    points: Vec<f64>,
    /// Critical points, ascending.
    critical: Vec<CriticalPoint>,
    /// Load factor at the end, where the path ends at it exactly.
    end_load: Option<f64>,
    /// Whether the path ends with this piece because of the number of steps.
    run_out: bool,
    /// Displacements at the end of the path, corrected at its load factor.
    last: Option<Vec<Nodal>>,
    /// Start of the next piece, until it is taken.
    next: Option<Start>,
}

impl Piece {
    /// Expands the path at a point whose tangent is factored, and which may lie beside the bifurcation that was passed last; the tangent at the
    /// end of the piece is factored then.
    ///
    /// # Errors
    /// There is no series, its residual is too large, or the tangent has no factor; the text gives the reason.
    pub fn new(
        system: &System,
        expansion: &mut Expansion,
        (start, beside_bifurcation): (Start, bool),
        options: &PathAnalysis,
    ) -> Result<Self, NoPiece> {
        let Start { point, directions, negative, unstable } = start;
        let unstable = unstable.or_else(|| expansion.unstable_modes(system, negative));
        let at = (point.u.as_slice(), point.load, directions);
        let mut series = expansion.series(system, at, (&point.direction, point.expected), options)?;
        // The search for bifurcations finds those that the extracted series tell.
        while geometric::extract(system, &mut series, options.tolerance).is_some() {}
        let longest = if point.expected > 0.0 { BEYOND * point.expected } else { f64::INFINITY };
        let mut length = series.range.min(longest);
        let end_of_path = series.reaches(options.end_load, length).first().copied();
        length = end_of_path.unwrap_or(length);
        let most = if options.method.is_some() { MOST_SHORTENED } else { MOST_BEFORE_ARC_LENGTH };
        let end = usable_end(system, expansion, &series, (length, most, end_of_path.is_some()))?;
        let mut end_load = end_of_path.map(|_| options.end_load).filter(|_| end.length == length);
        length = end.length;
        let followed = unstable.as_ref().and_then(|modes| expansion.followed(system, modes, end.negative));
        let changes = followed.is_none();
        let unstable = [unstable, followed.or_else(|| expansion.unstable_modes(system, end.negative))];
        let at_end = expansion.factorizations();
        let places = [(0.0, negative, &unstable[0]), (length, end.negative, &unstable[1])];
        let mut critical =
            critical_points(system, expansion, &series, ([beside_bifurcation, changes], places))?;
        let mut branch = None;
        if let Some((found, sign)) = switched(&critical, point.bifurcations, &options.switch_at) {
            let at = (found.point.u.as_slice(), found.point.load);
            let mode = leaving(system, expansion, &series, (found, sign))?;
            let crossing =
                onto_branch(system, expansion, at, (&mode, options.end_load)).map_err(|passed| NoPiece {
                    reason: branch::not_found(passed) + &meeting(found.point.change),
                    wanted_too_near: passed.is_some(),
                })?;
            branch = Some((crossing, mode));
            (length, end_load) = (found.a, None);
            critical.retain(|found| found.a <= length);
        } else if expansion.factorizations() != at_end {
            // The tangent at the end serves the next piece.
            expansion.factor(system, &end.u, end.load)?;
        }
        let [_, at_the_end] = unstable;
        let last = end_load.and_then(|load| end.at_load(system, expansion, load));
        let run_out = point.number + 1 >= options.max_steps && end_load.is_none();
        let points = points(system, &series, (length, options.points), &critical);
        let position = |a: f64| point.position + a;
        let critical =
            critical.into_iter().map(|Found { a, point }| CriticalPoint { position: position(a), ..point });
        let mut piece = Self {
            critical: critical.collect(),
            series,
            start: point,
            negative,
            length,
            points,
            end_load,
            run_out,
            last,
            next: None,
        };
        piece.next = Some(match branch {
            None => piece.going_on(end, at_the_end),
            Some((Branch { u, load, negative }, direction)) => {
                let directions = expansion.directions(system, &u, load)?;
                let point = ExpansionPoint { u, load, direction, ..piece.behind() };
                Start { point, directions, negative, unstable: None }
            }
        });
        Ok(piece)
    }

    /// Series of the piece.
    pub fn series(&self) -> &Series {
        &self.series
    }

    /// Where the piece begins.
    pub fn start(&self) -> &ExpansionPoint {
        &self.start
    }

    /// Load factor at a parameter; at the end of the path exactly that at which it ends.
    pub fn load(&self, a: f64) -> f64 {
        self.end_load.filter(|_| a == self.length).unwrap_or_else(|| self.series.load(a))
    }

    /// Displacements at a parameter; at the end of the path the corrected ones.
    pub fn displacements(&self, system: &System, a: f64, out: &mut [Nodal]) {
        match self.last.as_ref().filter(|_| a == self.length) {
            Some(last) => out.copy_from_slice(last),
            None => {
                self.series.displacements(a, out);
                project_unit_vectors(system, out);
            }
        }
    }

    /// Path parameter from the start of the path.
    pub fn position_of(&self, a: f64) -> f64 {
        self.start.position + a
    }

    /// Path parameter at the end of the piece.
    pub fn end_position(&self) -> f64 {
        self.position_of(self.length)
    }

    /// Whether a position lies on the piece, before its end.
    pub fn leads_on_from(&self, position: f64) -> bool {
        self.start.position <= position && position < self.end_position()
    }

    /// Whether the path ends with this piece.
    pub fn is_last(&self) -> bool {
        self.run_out || self.end_load.is_some()
    }

    /// Whether the path ends with this piece because of the number of steps.
    pub fn has_run_out(&self) -> bool {
        self.run_out
    }

    /// Start of the next piece, whose tangent is factored.
    pub fn next_start(&mut self) -> Option<Start> {
        self.next.take()
    }

    /// Start of the next piece at the end of this one.
    fn going_on(
        &self,
        End { u, load, directions, negative, .. }: End,
        unstable: Option<UnstableModes>,
    ) -> Start {
        let mut direction = self.series.u.clone();
        self.series.direction(self.length, &mut direction);
        let point = ExpansionPoint { u, load, direction, expected: self.length, ..self.behind() };
        Start { point, directions, negative, unstable }
    }

    /// Counts behind the piece.
    fn behind(&self) -> ExpansionPoint {
        let passed = self.critical.iter().filter(|point| point.kind == CriticalKind::Bifurcation).count();
        ExpansionPoint {
            position: self.end_position(),
            number: self.start.number + 1,
            bifurcations: self.start.bifurcations + passed,
            ..ExpansionPoint::default()
        }
    }

    /// Parameter of the next point to report behind a position, or that of the position `limit` where it comes first.
    pub fn next_point(&self, position: f64, limit: f64) -> f64 {
        let next = self.points.iter().copied().find(|&a| self.position_of(a) > position);
        let next = next.unwrap_or(self.length);
        if limit < self.position_of(next) { limit - self.start.position } else { next }
    }

    /// Critical points behind a position, up to another one.
    pub fn passed(&self, from: f64, to: f64) -> impl Iterator<Item = &CriticalPoint> {
        self.critical.iter().filter(move |point| from < point.position && point.position <= to)
    }

    /// Negative eigenvalues of the tangent at a position of the piece.
    pub fn negative_at(&self, position: f64) -> usize {
        let passed = self.critical.iter().filter(|point| point.position <= position);
        (self.negative as i32 + passed.map(|point| point.change).sum::<i32>()).max(0) as usize
    }
}

/// Part of a message about the modes that meet at a bifurcation with this change of the negative eigenvalues.
fn meeting(change: i32) -> String {
    match change.unsigned_abs() {
        0 | 1 => String::new(),
        modes => format!(", where {modes} modes meet; let a small imperfection choose one of them"),
    }
}

/// Parameter of an end of a piece, negative eigenvalues of the tangent there, and their eigenvectors where they are known.
type Counted<'a> = (f64, usize, &'a Option<UnstableModes>);

/// Critical points of a piece between its ends, at its start beside a bifurcation or not; unstable modes change in it or not. The tangent that is factored
/// afterwards may be another one.
///
/// # Errors
/// A bifurcation was not located, or a crossing is a fold of another path; the text gives the reason.
fn critical_points(
    system: &System,
    expansion: &mut Expansion,
    series: &Series,
    ([beside_bifurcation, changes], places): ([bool; 2], [Counted; 2]),
) -> Result<Vec<Found>, String> {
    let [(_, negative, _), last] = places;
    let length = last.0;
    let mut critical = if beside_bifurcation && is_flat(series, length) && last.1 == negative {
        // Behind it the load of a crossing path is constant, but for round-off.
        Vec::new()
    } else {
        limit_points(system, expansion, series, length)
    };
    for crossing in critical.iter().filter(|found| found.is_passed_along_mode()) {
        refuse_fold(system, expansion, series, (crossing, length))?;
    }
    let explained: i32 = critical.iter().map(|found| found.point.change).sum();
    let unexplained = last.1 as i32 - negative as i32 - explained;
    if unexplained != 0 {
        let limits: Vec<(f64, i32)> = critical.iter().map(|found| (found.a, found.point.change)).collect();
        let mut curve = SeriesCurve { system, expansion, series };
        let more = bifurcations(&mut curve, length, (negative, unexplained), &limits)?;
        critical.extend(more);
        critical.sort_by(|p, q| p.a.total_cmp(&q.a));
    }
    if changes
        && let [Some(first), Some(last)] = places.map(|(a, negative, modes)| {
            modes.as_ref().map(|modes| Place { a, negative, modes: modes.clone() })
        })
    {
        let known: Vec<(f64, i32)> = critical.iter().map(|found| (found.a, found.point.change)).collect();
        let mut curve = SeriesCurve { system, expansion, series };
        // Where a trial fails, the known points stand.
        critical.extend(opposite_crossings(system, &mut curve, [first, last], &known).unwrap_or_default());
        critical.sort_by(|p, q| p.a.total_cmp(&q.a));
    }
    Ok(critical)
}

/// End of a piece, where the tangent is factored.
struct End {
    length: f64,
    u: Vec<Nodal>,
    load: f64,
    directions: Directions,
    negative: usize,
}

impl End {
    /// Point of a series, at which the tangent is factored.
    fn new(system: &System, expansion: &mut Expansion, series: &Series, length: f64) -> Result<Self, String> {
        let mut u = series.u.clone();
        series.displacements(length, &mut u);
        project_unit_vectors(system, &mut u);
        let load = series.load(length);
        let negative = expansion.factor(system, &u, load)?;
        let directions = expansion.directions(system, &u, load)?;
        Ok(Self { length, u, load, directions, negative })
    }

    /// Newton increment across the direction of the path with its change of the load factor, and the relative errors of displacements and load factor
    /// that they are.
    fn errors(&self, system: &System, series: &Series, direction: &[Nodal]) -> (Vec<Nodal>, f64, [f64; 2]) {
        let (increment, change) = self.directions.across(system, direction);
        let size = larger(self.load.abs(), series.load(0.0).abs());
        let of_load = if change == 0.0 { 0.0 } else { change.abs() / size };
        let of_displacements = system.norm(&increment) / larger(system.norm(&self.u), self.length);
        (increment, change, [of_displacements, of_load])
    }

    /// Newton's method across the direction of the path, with the load factor as an unknown, until its error is small or round-off.
    fn correct(
        &mut self,
        system: &System,
        expansion: &mut Expansion,
        (series, direction): (&Series, &[Nodal]),
    ) -> Result<(), String> {
        let mut before = f64::INFINITY;
        for _ in 0..CORRECTIONS {
            let (increment, change, [_, error]) = self.errors(system, series, direction);
            if error <= CORRECTED || !(error <= 0.5 * before) {
                break;
            }
            before = error;
            add_multiple(&mut self.u, 1.0, &increment);
            project_unit_vectors(system, &mut self.u);
            self.load += change;
            self.negative = expansion.factor(system, &self.u, self.load)?;
            self.directions = expansion.directions(system, &self.u, self.load)?;
        }
        Ok(())
    }

    /// Displacements at a load factor by Newton's method from this end, the tangent of which is factored; `None` where it does not converge, as at
    /// limit points. The next increment is expected to be as much less as the residual is.
    fn at_load(&self, system: &System, expansion: &mut Expansion, load: f64) -> Option<Vec<Nodal>> {
        let Directions { increment, unit, .. } = &self.directions;
        let (mut u, mut increment) = (self.u.clone(), increment.clone());
        add_multiple(&mut increment, load - self.load, unit);
        let mut left = vec![0.0; system.unknowns()];
        let [mut residual, _] = expansion.residual(system, &u, load, &mut left);
        let mut before = 2.0 * MOST_CORRECTED;
        for _ in 0..MOST_AT_LOAD {
            let size = system.norm(&increment) / larger(system.norm(&u), self.length);
            if !(size <= 0.5 * before) {
                return (size <= CORRECTED).then_some(u);
            }
            before = size;
            add_multiple(&mut u, 1.0, &increment);
            project_unit_vectors(system, &mut u);
            let [behind, _] = expansion.residual(system, &u, load, &mut left);
            if size * (behind / residual) <= AT_LOAD || size <= AT_LOAD {
                return Some(u);
            }
            residual = behind;
            expansion.factor(system, &u, load).ok()?;
            increment = expansion.directions(system, &u, load).ok()?.increment;
        }
        None
    }
}

/// End up to which a series has a small residual, and a small error of its displacements across the path and of its load factor, and at which the
/// tangent has a factor: at the wanted length or a shorter one. The point there is corrected.
fn usable_end(
    system: &System,
    expansion: &mut Expansion,
    series: &Series,
    (wanted, most_shortened, ends_path): (f64, usize, bool),
) -> Result<End, String> {
    let (mut u, mut direction) = (series.u.clone(), series.u.clone());
    let mut residual = vec![0.0; system.unknowns()];
    // Where the loads vanish, so do the forces.
    let [_, before] = expansion.residual(system, &series.u, series.load(0.0), &mut residual);
    let mut length = wanted;
    for shortened in 0.. {
        series.displacements(length, &mut u);
        series.direction(length, &mut direction);
        let [unbalanced, size] = expansion.residual(system, &u, series.load(length), &mut residual);
        let relative = unbalanced / larger(before, size);
        let open = expansion.open_joint(system, &u, series.load(length));
        let judge = || {
            if let Some(open) = open {
                return Err(open);
            }
            if !(relative <= LARGEST_RESIDUAL) {
                return Err(format!("the residual at the end of the series is {relative:.1e} of the forces"));
            }
            let mut end = End::new(system, expansion, series, length)?;
            let (_, _, errors) = end.errors(system, series, &direction);
            for (error, what) in errors.into_iter().zip(["displacements", "load factor"]) {
                if !(error <= LARGEST_ERROR) {
                    return Err(format!(
                        "the error of the {what} at the end of the series is {error:.1e} of it"
                    ));
                }
            }
            // The end of the path is corrected at its load factor.
            if !(ends_path && length == wanted) {
                end.correct(system, expansion, (series, &direction))?;
            }
            Ok(end)
        };
        match judge() {
            Err(_) if shortened < most_shortened => length *= SHORTER,
            outcome => return outcome,
        }
    }
    Err("the series has no usable length".into())
}

/// Refuses a crossing of a piece that is the fold of a path which nearly crosses it.
fn refuse_fold(
    system: &System,
    expansion: &mut Expansion,
    series: &Series,
    (crossing, length): (&Found, f64),
) -> Result<(), String> {
    let loads = [series.load(0.0), crossing.point.load, series.load(length)];
    let mut direction = series.u.clone();
    refuse_fold_of_other_path(loads, [crossing.a, length], |a| {
        let mut trial = End::new(system, expansion, series, a)?;
        series.direction(a, &mut direction);
        trial.correct(system, expansion, (series, &direction))?;
        Ok(trial.load)
    })
}

/// First bifurcation of a piece at which the path goes over to the crossing one, and the sign of the side wanted.
pub fn switched<'a>(critical: &'a [Found], passed: usize, wanted: &[i32]) -> Option<(&'a Found, f64)> {
    let bifurcations = critical.iter().filter(|found| found.point.kind == CriticalKind::Bifurcation);
    bifurcations.zip(passed + 1..).find_map(|(found, number)| {
        let choice = wanted.iter().find(|n| n.unsigned_abs() as usize == number)?;
        Some((found, f64::from(choice.signum())))
    })
}

/// Direction in which the other path leaves a bifurcation of a series. The tangent that is factored afterwards may be another one.
fn leaving(
    system: &System,
    expansion: &mut Expansion,
    series: &Series,
    (found, sign): (&Found, f64),
) -> Result<Vec<Nodal>, String> {
    if !found.is_passed_along_mode() {
        return Ok(found.mode_on_side(sign));
    }
    let before = BEFORE_BIFURCATION * found.a;
    let (mut u, load) = (series.u.clone(), series.load(before));
    series.displacements(before, &mut u);
    expansion.factor(system, &u, load)?;
    let response = expansion.directions(system, &u, load)?.unit;
    let (_, eigenvector) = expansion.eigenvalue_next_to_zero(system, INVERSE_ITERATIONS)?;
    Ok(branch::primary_direction(system, &response, &eigenvector, sign))
}

/// Points of a piece that are reported: equal parts of it, wanted load factors, critical points, its end.
fn points(system: &System, series: &Series, (length, count): (f64, u32), critical: &[Found]) -> Vec<f64> {
    let mut exact: Vec<f64> = critical.iter().map(|found| found.a).collect();
    for &wanted in &system.wanted_times {
        exact.extend(series.reaches(wanted, length));
    }
    exact.push(length);
    let near = |a: f64, others: &[f64]| others.iter().any(|b| (a - b).abs() <= SAME * length);
    let regular = (1..count).map(|i| length * f64::from(i) / f64::from(count));
    let mut all: Vec<f64> = regular.filter(|&a| !near(a, &exact)).collect();
    all.extend(exact);
    all.sort_by(f64::total_cmp);
    all.dedup_by(|b, a| *b - *a <= SAME * length);
    if let Some(end) = all.last_mut() {
        *end = length;
    }
    all
}
