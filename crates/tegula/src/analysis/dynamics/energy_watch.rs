//! Total energy of motions by schemes that do not conserve it.
//!
//! Newmark's method, HHT and generalised-α are stable for linear models. Where stiff parts rotate fast, they may gain energy in every step
//! (J. C. Simo, N. Tarnow, ZAMP 43 (1992) 757–792), and constant steps go on with it.

use super::step_end::Span;
use crate::Vec3;
use crate::analysis::{Balance, Observer, State, equilibrium};
use crate::element::Nodal;
use crate::system::{System, VectorKind};
use tegula_sparse::norm::larger;

/// Gain of energy over the largest energy that triggers the first report, and growth of it that triggers the next one.
const FIRST: f64 = 0.05;
const GROWTH: f64 = 2.0;

/// Number of first steps that are judged together: from rest, the error of one is as large as the energy.
const FIRST_STEPS: u64 = 20;

/// Gain in all the first steps together, over the energy that was supplied in them, that is reported.
const REPORTED_AT_FIRST: f64 = 0.1;

/// Loss of energy by numerical damping over the largest energy that is reported at the end.
const DAMPED: f64 = 0.1;

/// Energy that displacements miss beside dampers, over the largest energy, below which it does not matter.
const NOTICEABLE: f64 = 1e-9;

/// Steps in which stresses of damped material relax to half and less: errors of displacements vanish with them.
const RELAXED: f64 = 10.0;

/// Change of the total energy in a step, over the largest energy so far, above which the step has lost its way; and the gain of a
/// scheme that does not conserve it.
const LOST: f64 = 1e-3;
const GAINED: f64 = 1e-2;

/// Part of the energy that a scheme may gain in the first steps from rest, where the error is as large as the energy.
const GAINED_AT_FIRST: f64 = 1.0;

/// Round-off of a position over the size of the model, and of what an iteration leaves of it.
const ROUND_OFF: f64 = 1e-13;

/// Kinetic energy of a model at rest whose positions and directors change by round-off in a step: energies below are none. Bodies may be larger
/// than the distances between the points of the model.
fn energy_of_round_off(system: &System, dt: f64) -> f64 {
    let of_rotations: f64 = system.coordinates.bodies.iter().map(|body| body.inertia().1.trace()).sum();
    let inertia = system.total_mass() * system.length.powi(2) + of_rotations;
    0.5 * inertia * (ROUND_OFF / dt).powi(2)
}

/// Work of the loads on a model whose positions and directors change by round-off: of one that is held at rest there is no other.
fn work_of_round_off(system: &System, state: &State) -> f64 {
    let loads = equilibrium::external(system, &state.point(system));
    let work = |(force, kind): (&Nodal, &VectorKind)| {
        let size = if *kind == VectorKind::Position { system.length } else { 1.0 };
        Vec3::from(*force).norm() * size
    };
    ROUND_OFF * loads.iter().zip(&system.coordinates.kinds).map(work).sum::<f64>()
}

/// Whether an error of the energy is that of a model which is held at rest, up to round-off.
pub(super) fn is_round_off(system: &System, (state, dt): (&State, f64), error: f64) -> bool {
    error <= energy_of_round_off(system, dt) || error <= work_of_round_off(system, state)
}

/// Largest energy that the state at the start and the loads can have supplied to a motion so far.
pub(super) struct SuppliedEnergy {
    /// Kinetic and strain energy, and potential, at the start.
    stored: f64,
    potential: f64,
    largest: f64,
}

impl SuppliedEnergy {
    /// Energy of the state at the start.
    pub fn new(start: &Balance) -> Self {
        let stored = start.kinetic + start.strain;
        Self { stored, potential: start.potential, largest: stored }
    }

    /// Counts the work of the loads up to a state whose balance is not known.
    pub fn count_work(&mut self, work: f64) {
        self.largest = larger(self.largest, self.stored + work.abs());
    }

    /// Energy of the state at the start and of the loads up to a later state.
    pub fn up_to(&mut self, balance: &Balance) -> f64 {
        let loads = balance.work.abs() + (balance.potential - self.potential).abs();
        self.largest = larger(self.largest, self.stored + loads);
        self.largest
    }
}

/// Whether errors of displacements beside dampers last longer than some steps: beside springs and bushings, damped material that creeps slowly, and
/// damping of masses that exceeds them over a step.
fn lags(system: &System, dt: f64) -> bool {
    let creeps = system.groups.iter().any(|group| group.retardation_time() > RELAXED * dt);
    system.has_springs() || creeps || system.mass_damping * dt > 1.0
}

/// Reports that a motion gains energy, each time that the gain has grown.
pub(super) struct EnergyWatch {
    /// Lowest sum that an exact integration keeps constant, so far.
    lowest: f64,
    /// Gain that triggers the next report.
    next: f64,
    /// Sum that an exact integration keeps constant, at the start.
    total: f64,
    supplied: SuppliedEnergy,
    /// Largest gain since the start.
    largest: f64,
    /// Whether drives or prescribed motions do work, which is known to the error of the reactions only.
    led: bool,
    /// Energies that displacements miss beside dampers, that were supplied, and that were dissipated, up to the steps judged last.
    before: [f64; 3],
    /// Whether displacements that miss velocities were told.
    told: bool,
}

impl EnergyWatch {
    /// Watch without any report yet, from the energies at the start.
    pub fn new(system: &System, balance: &Balance) -> Self {
        let driven = system.joints.iter().any(|joint| joint.drive.is_some());
        Self {
            led: driven || !system.dofs().prescribed.is_empty(),
            lowest: f64::INFINITY,
            next: FIRST,
            total: balance.total,
            supplied: SuppliedEnergy::new(balance),
            largest: 0.0,
            before: [0.0; 3],
            told: false,
        }
    }

    /// Looks at the energies at the end of a step with this number; `scale` is the largest energy so far, and `unresolved` that of dampers in rates which
    /// the displacements do not follow. The first steps are judged together, at the last of them, when loads have done more work than in the very first one.
    pub fn look(
        &mut self,
        system: &System,
        (balance, scale, unresolved): (&Balance, f64, f64),
        (step, Span { end: time, dt }, last): (u64, Span, bool),
        observer: &mut dyn Observer,
    ) {
        let supplied = self.supplied.up_to(balance);
        if step.is_multiple_of(FIRST_STEPS) || last {
            self.look_at_dampers(system, (balance, unresolved), (time, dt), observer);
        }
        let judged = step == FIRST_STEPS || last && step < FIRST_STEPS;
        self.lowest = self.lowest.min(balance.total);
        let since_start = balance.total - self.total;
        if !self.led && since_start > energy_of_round_off(system, dt) {
            self.largest = larger(self.largest, since_start);
        }
        if judged && self.largest > REPORTED_AT_FIRST * supplied {
            observer.on_warning(&format!(
                "time {time:.6e}: in the first steps the motion has gained an energy of {:.3e}, where loads and initial state supply {:.3e}: \
                 vibrations much faster than the steps, such as those of the thickness behind sudden loads or temperatures, overshoot, and \
                 energies and stresses are wrong there; take the scheme \"energy-momentum\", shorter steps, or loads that grow from 0",
                self.largest, supplied
            ));
        }
        // Where dampers take what loads supply, the motion itself has little energy.
        let most = larger(larger(scale, supplied), larger(balance.kinetic, balance.strain));
        if last && !self.led && -since_start > DAMPED * most {
            observer.on_warning(&format!(
                "numerical damping has taken {:.0} % of the largest energy of the motion; where it is not meant to settle, take shorter or automatic \
                 steps, or the scheme \"energy-momentum\"",
                -100.0 * since_start / most
            ));
        }
        let gain = (balance.total - self.lowest) / most;
        if step <= FIRST_STEPS || most == 0.0 || gain <= self.next {
            return;
        }
        if gain * most <= energy_of_round_off(system, dt) {
            return;
        }
        self.next = GROWTH * gain;
        observer.on_warning(&format!(
            "time {time:.6e}: the motion has gained {:.0} % of its largest energy: the time steps are too long for it; take shorter or automatic \
             steps, or the scheme \"energy-momentum\"",
            100.0 * gain
        ));
    }

    /// Warns where dampers much stiffer than the mass over a step take the velocities to their values in a part of it: the displacements do not follow. Steps
    /// are judged in groups, by the energy that was supplied or dissipated in them.
    fn look_at_dampers(
        &mut self,
        system: &System,
        (balance, unresolved): (&Balance, f64),
        (time, dt): (f64, f64),
        observer: &mut dyn Observer,
    ) {
        let now = [unresolved, self.supplied.largest, balance.dissipated.abs()];
        let [missed, supplied, dissipated]: [f64; 3] =
            std::array::from_fn(|i| (now[i] - self.before[i]).abs());
        self.before = now;
        let exceeds = missed > REPORTED_AT_FIRST * (supplied + dissipated)
            && missed > NOTICEABLE * self.supplied.largest;
        if self.told || !exceeds || !lags(system, dt) {
            return;
        }
        self.told = true;
        observer.on_warning(&format!(
            "time {time:.6e}: in the last steps displacements do not follow the velocities where damping is strong, and stay wrong: it is much stiffer than \
             the mass over the step; take the scheme \"energy-momentum\", shorter steps, or loads and motions without jumps"
        ));
    }

    /// Advice for a motion that ends in a failure, where it had gained energy before.
    pub fn advice(&self) -> Option<String> {
        (self.largest > GAINED_AT_FIRST * self.supplied.largest).then(|| {
            format!(
                "Before, the motion had gained an energy of {:.3e}, where loads and initial state supply {:.3e}: vibrations much faster than \
                 the steps have grown. Take the scheme \"energy-momentum\", shorter steps, or loads and temperatures that grow from 0.",
                self.largest, self.supplied.largest
            )
        })
    }
}

/// Judges whether a step of a mechanism keeps the energy: near a singular position of its joints the motion has left its branch. The
/// error is the reason, as text.
pub(super) fn keeps_energy(
    system: &System,
    (span, state): (Span, &State),
    [before, after]: [&Balance; 2],
    (scale, conserves): (f64, bool),
) -> std::result::Result<(), String> {
    let drives: Vec<_> = system.joints.iter().filter(|joint| joint.drive.is_some()).collect();
    // The work of drives is exact in schemes that conserve energy only.
    if !conserves && !drives.is_empty() {
        return Ok(());
    }
    let (gain, scale) = (after.total - before.total, larger(scale, after.kinetic));
    // From rest, what strong damping dissipates is known to a multiple of the energy only.
    let gained = match (state.step <= FIRST_STEPS, system.groups.iter().any(|group| group.has_rate_damping()))
    {
        (false, _) => GAINED,
        (true, true) if !conserves => return Ok(()),
        (true, _) => GAINED_AT_FIRST,
    };
    let cause = if conserves { "" } else { "the time steps are too long for the scheme, or " };
    let (change, limit) = if conserves { (gain.abs(), LOST) } else { (gain, gained) };
    if change <= limit * scale || is_round_off(system, (state, span.dt), change) {
        return Ok(());
    }
    let springs = if system.springs.is_empty() && system.torsion_springs.is_empty() {
        ""
    } else {
        ", or a spring is too stiff for a step of this length"
    };
    let names: Vec<_> = drives.iter().map(|joint| format!("\"{}\"", joint.name)).collect();
    let contradiction = if names.is_empty() {
        String::new()
    } else {
        format!(", or the drives ({}) contradict each other or other joints", names.join(", "))
    };
    Err(format!(
        "the total energy changed by {change:.2e} in a step, {:.1e} of the largest energy: {cause}the joints are near a singular \
         position, in which parts of the mechanism may move although they seem to be held{springs}{contradiction}",
        change / scale
    ))
}
