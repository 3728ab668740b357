//! Rotations in constant time steps, and how far the motion lags behind in them.
//!
//! Schemes whose velocities are those of the middle of a step turn a body that rotates with the angular velocity ω by `2 atan(½ωΔt)`
//! instead of ωΔt in a step: energy and momenta stay right, and the angle lags behind by about (ωΔt)²/12 of it. Automatic steps see this
//! in their local error. In constant steps nothing shows it. Numerical damping adds to it.

use crate::Vec3;
use crate::analysis::Observer;
use crate::element::Nodal;
use crate::system::System;
use rayon::prelude::*;
use tegula_sparse::norm::larger;

/// Part of a rotation by which it lags behind that triggers the first report, and growth of it that triggers the next one.
const FIRST: f64 = 0.01;
const GROWTH: f64 = 2.0;

/// Shells per task.
const CHUNK: usize = 256;

/// Reports rotations in constant steps that are too long for them, each time that they have grown.
pub(super) struct RotationWatch {
    /// Displacements at the end of the last step; empty where the steps are automatic.
    before: Vec<Nodal>,
    /// Lag that triggers the next report.
    next: f64,
}

impl RotationWatch {
    /// Watch from displacements on.
    pub fn new(system: &System, constant_steps: bool, u: &[Nodal]) -> Self {
        let before = if constant_steps && !system.linear { u.to_vec() } else { Vec::new() };
        Self { before, next: FIRST }
    }

    /// Goes back to the displacements `u` at the start of a step that is repeated.
    pub fn restart(&mut self, u: &[Nodal]) {
        if !self.before.is_empty() {
            self.before.copy_from_slice(u);
        }
    }

    /// Looks at the displacements `u` at the end of a step, which consists of `sub_steps`.
    pub fn look(
        &mut self,
        system: &System,
        (u, time): (&[Nodal], f64),
        sub_steps: &[f64],
        observer: &mut dyn Observer,
    ) {
        if self.before.is_empty() {
            return;
        }
        let Turned { angle, place } = largest(system, [&self.before, u]);
        self.before.copy_from_slice(u);
        let lag = lag(angle, sub_steps);
        if lag < self.next {
            return;
        }
        self.next = GROWTH * lag;
        observer.on_event(&format!(
            "time {time:.6e}: {} turns by {angle:.2} rad in one step; a rotation that no drive holds lags behind by \
             {:.0} % or more in steps of this constant length: take a shorter `time_step`, or automatic steps",
            place.name(system),
            100.0 * lag
        ));
    }
}

/// Largest rotation of a step.
struct Turned {
    /// Angle (rad).
    angle: f64,
    place: Place,
}

/// Part of a model that rotates.
#[derive(Clone, Copy)]
enum Place {
    /// Number of a shell.
    Shell(usize),
    /// Number of a body.
    Body(usize),
}

impl Place {
    fn name(self, system: &System) -> String {
        match self {
            Self::Body(body) => format!("\"{}\"", system.coordinates.bodies[body].name),
            Self::Shell(shell) => format!("element {}", system.quad_label(system.shells[shell].quad)),
        }
    }
}

/// Part of a rotation by an angle in a step by which it lags behind: of a body that rotates steadily by θ in time, a sub-step of the
/// length γ turns it by 2 atan(½γθ).
fn lag(angle: f64, sub_steps: &[f64]) -> f64 {
    if angle == 0.0 {
        return 0.0;
    }
    let turned: f64 = sub_steps.iter().map(|part| 2.0 * (0.5 * part * angle).atan()).sum();
    (1.0 - turned / angle).abs()
}

/// Largest rotation between two displacements.
fn largest(system: &System, u: [&[Nodal]; 2]) -> Turned {
    let at = |u: &[Nodal], v: u32| {
        let v = v as usize;
        Vec3::from(system.coordinates.reference[v]) + Vec3::from(u[v])
    };
    let shells = system.shells.par_iter().with_min_len(CHUNK).enumerate().map(|(i, shell)| {
        let vectors = system.groups[shell.groups.start].vectors(shell.member);
        let [before, after] = u.map(|u| [1, 3].map(|corner| at(u, vectors[corner]) - at(u, vectors[0])));
        Turned {
            angle: larger(between(before[0], after[0]), between(before[1], after[1])),
            place: Place::Shell(i),
        }
    });
    let more = |a: Turned, b: Turned| if b.angle > a.angle { b } else { a };
    let none = || Turned { angle: 0.0, place: Place::Body(0) };
    let bodies = system.coordinates.bodies.iter().enumerate().filter_map(|(i, body)| {
        let angles = body.directors?.map(|v| between(at(u[0], v), at(u[1], v)));
        Some(Turned { angle: angles.into_iter().fold(0.0, larger), place: Place::Body(i) })
    });
    bodies.fold(shells.reduce(none, more), more)
}

/// Angle between two vectors (rad).
fn between(a: Vec3, b: Vec3) -> f64 {
    a.cross(&b).norm().atan2(a.dot(&b))
}

#[cfg(test)]
mod tests {
    use super::lag;

    #[test]
    fn a_rotation_lags_behind_by_a_twelfth_of_the_squared_angle() {
        for angle in [0.01, 0.1, 0.3] {
            let expected = angle * angle / 12.0;
            assert!((lag(angle, &[1.0]) / expected - 1.0).abs() < angle * angle);
        }
    }

    #[test]
    fn composed_steps_lag_behind_in_fourth_order() {
        let parts = super::super::composition::FOURTH_ORDER;
        let ratio = lag(0.2, &parts) / lag(0.1, &parts);
        assert!((ratio - 16.0).abs() < 0.2, "{ratio}");
    }
}
