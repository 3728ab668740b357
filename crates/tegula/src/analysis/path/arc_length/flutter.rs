//! Flutter along a path: under loads without a potential vibrations about an equilibrium may grow although no eigenvalue of the tangent has passed through
//! zero (H. Ziegler, *Principles of structural stability*, 1968). The masses decide, and the [complex modes](crate::analysis::modal) tell.
//!
//! Two frequencies meet at the onset. Behind it the square γ² of the growth rate is a smooth function of the place on the path, with a simple zero at the onset:
//! its secants locate it.

use super::inside_step::Known;
use super::{ArcLengthSteps, ArcStart, End};
use crate::Error;
use crate::analysis::modal::{self, GrowingMotion, KnownModes};
use crate::analysis::path::critical_points::Found;
use crate::analysis::path::state::{CriticalKind, CriticalPoint, PathState};
use crate::analysis::{Observer, State};
use crate::norm::larger;
use crate::system::System;

/// Change of the load factor over it from secant to secant, below which the onset is located.
const LOCATED: f64 = 1e-5;
/// Growth rate over the circular frequency, below which an equilibrium is next to the onset: its two eigenvalues λ are nearly one, and their errors the square
/// roots of that of the matrices.
const NEXT_TO_ONSET: f64 = 0.01;
/// Largest number of equilibria whose vibrations are looked at for it.
const MOST_TRIALS: usize = 24;
/// Part of the way from the last onset that a secant tells to the nearest equilibrium behind it, at which the vibrations are looked at next: they grow there.
const BEHIND: f64 = 0.1;

/// Motion about an equilibrium that grows, if one does; the outer option is `None` where the modes are not found.
type Judged = Option<Option<GrowingMotion>>;

impl ArcLengthSteps<'_> {
    /// Motions about the end of a step, and where they begin to grow within the step, which has these critical points.
    pub(super) fn flutter_within(
        &mut self,
        (arc, known, negative): (&ArcStart, &mut Option<Known>, usize),
        end: &End,
        critical: &[Found],
        observer: &mut dyn Observer,
    ) -> (Judged, Option<Found>) {
        let state = self.state_at(end);
        let began_before = self.path().is_some_and(|path| path.flutters);
        // Trials inside the step have factored other tangents than that of its end.
        if let Some(modes) = self.modes.as_ref().filter(|_| known.is_none() && !began_before)
            && self.newton.exclude_growth(self.system, &state, modes)
        {
            return (Some(None), None);
        }
        let judged = growing_motion((self.system, &mut self.unknown), &state, observer).map(|(found, modes)| {
            if modes.is_some() && !std::mem::replace(&mut self.watches, true) {
                observer.on_event(
                    "the loads have no potential: the six lowest modes of the equilibria are watched for flutter, higher ones are not; `path.negative_eigenvalues` counts those of the symmetric \
                     part of the tangent, which do not tell the stability",
                );
            }
            self.modes = modes;
            found
        });
        let divergent = expected(self.path(), critical, end.a);
        let judged = judged.map(|growing| growing.filter(|motion| is_untold(motion, divergent)));
        let growing = judged.as_ref().and_then(Option::as_ref).filter(|_| !began_before);
        let Some(vibration) = growing else { return (judged, None) };
        let known = known.get_or_insert_with(|| Known::new(self, (arc, negative), end));
        let located = self.onset_of_flutter(known, (end.a, vibration, critical), observer);
        (judged, located)
    }

    /// State at an equilibrium of the path.
    fn state_at(&self, end: &End) -> State {
        let equation = &end.equation;
        State {
            u: equation.u.clone(),
            multipliers: equation.multipliers.clone(),
            angles: equation.angles.clone(),
            time: equation.time,
            ..State::first(self.system)
        }
    }

    /// Onset of flutter in a step that begins without it, has these bifurcations and limit points, and ends at the distance `length` with this growing motion;
    /// `None` where it is not located.
    fn onset_of_flutter(
        &mut self,
        known: &mut Known,
        (length, vibration, critical): (f64, &GrowingMotion, &[Found]),
        observer: &mut dyn Observer,
    ) -> Option<Found> {
        // Places before the onset, and behind it with γ².
        let square =
            |motion: &GrowingMotion| if motion.omega > 0.0 { motion.growth.powi(2) } else { f64::NAN };
        let (mut before, mut behind) = (0.0, (length, square(vibration)));
        let (mut next, mut last) = (0.5 * length, None::<f64>);
        for _ in 0..MOST_TRIALS {
            if observer.interrupted() {
                return None;
            }
            let trial = self.equilibrium_near(known, next, observer).ok()?;
            let state = self.state_at(&trial);
            let (growing, _) = growing_motion((self.system, &mut self.unknown), &state, observer)?;
            known.add(trial);
            let divergent = expected(self.path(), critical, next);
            let Some(motion) = growing.filter(|motion| is_untold(motion, divergent)) else {
                before = next;
                next = 0.5 * (before + behind.0);
                continue;
            };
            let here = (next, square(&motion));
            let GrowingMotion { growth, omega, mut shape, .. } = motion;
            let zero = here.0 - here.1 * (behind.0 - here.0) / (behind.1 - here.1);
            behind = here;
            let is_next_to_onset = growth <= NEXT_TO_ONSET * omega;
            if !(is_next_to_onset || (zero >= before && zero <= here.0)) {
                next = 0.5 * (before + here.0);
                continue;
            }
            let zero = larger(zero, before).min(here.0);
            let onset = self.equilibrium_near(known, zero, observer).ok()?;
            let load = onset.equation.time;
            let is_located = last.is_some_and(|last| (load - last).abs() <= LOCATED * load.abs());
            if is_located || is_next_to_onset {
                let size = self.system.norm(&shape);
                shape.as_flattened_mut().iter_mut().for_each(|x| *x /= size);
                let u = onset.equation.u.clone();
                let point = CriticalPoint {
                    kind: CriticalKind::Flutter,
                    load,
                    position: 0.0,
                    change: 0,
                    u,
                    mode: shape,
                };
                return Some(Found { a: zero, point });
            }
            known.add(onset);
            last = Some(load);
            next = zero + BEHIND * (here.0 - zero);
        }
        None
    }
}

/// Number of motions that bifurcations and limit points up to the distance `a` of the step explain, which grow without vibrating.
pub(super) fn expected(path: Option<&PathState>, critical: &[Found], a: f64) -> usize {
    let before = path.iter().flat_map(|path| &path.critical).map(|point| point.change);
    let within = critical.iter().filter(|found| found.a <= a).map(|found| found.point.change);
    let changes: i32 = before.chain(within).sum();
    changes.max(0) as usize
}

/// Whether a motion vibrates, or more of them grow without vibrating than the `divergent` ones that critical points explain: two frequencies have met and become
/// two such motions.
fn is_untold(motion: &GrowingMotion, divergent: usize) -> bool {
    motion.omega > 0.0 || motion.divergent > divergent
}

/// Looks at the equilibrium at which a path begins.
pub(super) fn look_at_start(
    system: &System,
    (state, unknown): (&mut State, &mut bool),
    observer: &mut dyn Observer,
) {
    let Some((growing, _)) = growing_motion((system, unknown), state, observer) else { return };
    let Some(path) = state.path.as_deref_mut() else { return };
    path.flutters = growing.is_some();
    if let Some(motion) = growing {
        let kind = if motion.omega > 0.0 { "flutter" } else { "divergence" };
        observer.on_warning(&format!(
            "the path begins at an equilibrium that is unstable by {kind}: {}",
            told(&motion)
        ));
    }
}

/// Looks at the equilibrium at the end of a step that has begun at the load factor `before`, where it has not been `judged`, and warns where vibrations about it
/// grow that have not grown before, with the load factor of their onset where it was located; where they no longer grow, a message says so.
pub(super) fn look(
    (system, before, divergent): (&System, f64, usize),
    (state, unknown): (&mut State, &mut bool),
    (judged, onset): (Judged, Option<f64>),
    observer: &mut dyn Observer,
) {
    let judge = || growing_motion((system, unknown), state, observer).map(|(found, _)| found);
    let Some(growing) = judged.or_else(judge) else { return };
    let growing = growing.filter(|motion| is_untold(motion, divergent));
    let (now, Some(PathState { flutters, .. })) = (state.time, state.path.as_deref_mut()) else { return };
    let between = format!("between load factors {before:.6} and {now:.6}");
    match (std::mem::replace(flutters, growing.is_some()), growing) {
        (false, Some(motion)) => {
            let place = onset.map_or(between, |onset| format!("at load factor {onset:.6}"));
            let what = if motion.omega > 0.0 { "" } else { ", and by divergence behind it" };
            observer.on_warning(&format!(
                "{place} the equilibria of the path become unstable by flutter{what}: at {now:.6} {}",
                told(&motion)
            ));
        }
        (true, None) => observer.on_event(&format!(
            "{between} vibrations about the equilibria no longer grow: the flutter ends, or has become a motion away from them (divergence), which a modal step \
             behind the path tells"
        )),
        _ => {}
    }
}

/// Motion about an equilibrium that grows, if one does, and its modes; `None` where they are not found, which a warning tells at the first of such equilibria
/// (`unknown`).
fn growing_motion(
    (system, unknown): (&System, &mut bool),
    state: &State,
    observer: &mut dyn Observer,
) -> Option<(Option<GrowingMotion>, Option<KnownModes>)> {
    match modal::growing_motion(system, state) {
        Ok(found) => {
            *unknown = false;
            Some(found)
        }
        Err(_) if std::mem::replace(unknown, true) => None,
        Err(error) => {
            let now = state.time;
            let reason = match error {
                Error::NotConverged { reason, .. } => reason,
                error => error.to_string(),
            };
            observer.on_warning(&format!(
                "whether the equilibria from the load factor {now:.6} on are stable against flutter is not known: {reason}"
            ));
            None
        }
    }
}

fn told(GrowingMotion { growth, omega, .. }: &GrowingMotion) -> String {
    let motion = if *omega > 0.0 {
        format!("a vibration of the circular frequency {omega:.4e} grows")
    } else {
        "a motion without vibration grows".into()
    };
    format!(
        "{motion} by e^(t/{:.3e}). Eigenvalues of the tangent do not tell it; a modal step behind a path or a static step does",
        1.0 / growth
    )
}
