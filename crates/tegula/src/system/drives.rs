//! Work and rates of driven joints.

use super::System;
use crate::Vec3;
use crate::constraint::{CoordinateLaw, Drive, DriveValue, Joint, Row};
use crate::element::Nodal;
use crate::norm::larger;

/// Largest rotation of a drive in a step.
const QUARTER_TURN: f64 = std::f64::consts::FRAC_PI_2 * (1.0 + 1e-9);
/// Number of times in a step at which drives are looked at.
const LOOKS: u32 = 8;

impl System {
    /// Value of the drive of a joint at a time with its rates just before it: at a kink of a table and at the end of a spline they differ
    /// from those behind it.
    pub fn drive_before(&self, joint: &Joint, time: f64) -> DriveValue {
        let value = self.drive(joint, time);
        let before = |drive: Drive| {
            let amplitude = self.amplitudes.get(drive.amplitude)?;
            let [rate, acceleration] = [amplitude.rate_before(time), amplitude.acceleration_before(time)];
            Some(DriveValue { rate: drive.value * rate, acceleration: drive.value * acceleration, ..value })
        };
        joint.drive.and_then(before).unwrap_or(value)
    }

    /// Work that the drives of joints do on the model between the displacements `old` and `new`: that of the constraint forces
    /// `−Gᵀλ` with the gradients in the middle of the motion, where the drives have their values at `time`. Constraints that do
    /// not depend on time do no work, and are left out. `multiplier` gives λ of a constraint by its number.
    pub fn work_of_drives(
        &self,
        [old, new]: [&[Nodal]; 2],
        time: f64,
        multiplier: impl Fn(usize) -> f64,
    ) -> f64 {
        let mut work = 0.0;
        for joint in self.joints.iter().filter(|joint| joint.drive.is_some()) {
            let drive = self.drive_value(joint, time);
            let middle = |v| (Vec3::from(old[v]) + Vec3::from(new[v])) * 0.5;
            work += joint.with_vectors(self.displaced(middle), |middle, gradient| {
                for (number, row) in joint.multipliers().zip(&joint.rows) {
                    row.add_gradient(-multiplier(number), middle, drive, gradient);
                }
                along(joint, gradient, |v| Vec3::from(new[v]) - Vec3::from(old[v]))
            });
        }
        work
    }

    /// Work that the drives of joints do on the model in a step, from the displacements, time (load factor) and multipliers at its start to
    /// those at its end, where the constraint forces act in these two configurations: the integral of `λ ∂g/∂s` over the motion s of the drive, by the trapezoidal rule.
    pub fn work_of_driven_motions(
        &self,
        start: (&[Nodal], f64, &[f64]),
        end: (&[Nodal], f64, &[f64]),
    ) -> f64 {
        let mut work = 0.0;
        for joint in self.joints.iter().filter(|joint| joint.drive.is_some()) {
            let change = self.drive_value(joint, end.1) - self.drive_value(joint, start.1);
            for (u, time, multipliers) in [start, end] {
                let drive = DriveValue { rate: change, ..self.drive(joint, time) };
                let rows = joint.multipliers().zip(&joint.rows);
                work += joint.with_vectors(self.displaced(|v| Vec3::from(u[v])), |v, _| {
                    rows.map(|(i, row)| 0.5 * multipliers[i] * row.driven_rate(v, drive)).sum::<f64>()
                });
            }
        }
        work
    }

    /// Energy that friction and stops of joints dissipate between the displacements `old` and `new`: the work of the constraint forces
    /// `Gᵀλ` with the gradients of the relative coordinates in the middle of the motion. Coordinates that are held do no work.
    pub fn work_against_laws(&self, [old, new]: [&[Nodal]; 2], multipliers: &[f64]) -> f64 {
        let mut work = 0.0;
        for joint in self.joints.iter() {
            let Some((number, law)) = joint.law_row() else { continue };
            let middle = |v| (Vec3::from(old[v]) + Vec3::from(new[v])) * 0.5;
            work += joint.with_vectors(self.displaced(middle), |middle, gradient| {
                law.row.add_gradient(multipliers[number], middle, 0.0, gradient);
                along(joint, gradient, |v| Vec3::from(new[v]) - Vec3::from(old[v]))
            });
        }
        work
    }

    /// Value of the relative coordinate of a joint at the displacements `u`; an angle lies between −π and π.
    pub fn coordinate(&self, joint: &Joint, law: &CoordinateLaw, u: &[Nodal]) -> f64 {
        joint.with_vectors(self.displaced(|v| Vec3::from(u[v])), |current, _| law.row.driven_value(current))
    }

    /// Rate of the relative coordinate of a joint with velocities `v` at the displacements `u`.
    pub fn coordinate_rate(&self, joint: &Joint, law: &CoordinateLaw, [u, v]: [&[Nodal]; 2]) -> f64 {
        self.row_rate(joint, &law.row, [u, v], DriveValue::default())
    }

    /// Second rate of the relative coordinate of a joint with velocities `v` and accelerations `a` at the displacements `u`.
    pub fn coordinate_acceleration(
        &self,
        joint: &Joint,
        law: &CoordinateLaw,
        [u, v, a]: [&[Nodal]; 3],
    ) -> f64 {
        let drive = DriveValue::default();
        let along_accelerations = self.row_rate(joint, &law.row, [u, a], drive);
        let displaced = self.displaced(|v| Vec3::from(u[v]));
        let rate = |k: usize| Vec3::from(v[k]);
        joint.with_vectors(displaced, |q, _| {
            along_accelerations + joint.with_vectors(rate, |rates, _| law.row.velocity_term(q, rates, drive))
        })
    }

    /// First drive of an angle that is further away from its value at `from` than a quarter turn at a time up to `to`, as text:
    /// positions at the ends of such a step do not tell which way and how often it has turned.
    pub fn drive_turns_too_far(&self, from: f64, to: f64) -> Option<String> {
        let driven = self.joints.iter().filter(|joint| joint.rows.first().is_some_and(Row::is_driven_angle));
        let turns = |joint: &&Joint| {
            let start = self.drive_value(joint, from);
            let at = |part: u32| from + (to - from) * f64::from(part) / f64::from(LOOKS);
            (1..=LOOKS).any(|part| !((self.drive_value(joint, at(part)) - start).abs() <= QUARTER_TURN))
        };
        let found = driven.into_iter().find(turns)?;
        Some(format!("the drive \"{}\" turns by more than a quarter turn", found.name))
    }

    /// Leading term of the local error that the drives of joints bring into a step of a second-order scheme, in which the joints hold
    /// driven positions exactly, but not their rates: `(Δt² |Δs̈| + |Δs|³)/12` for an angle s, and `Δt² |Δs̈|/12` over the model's
    /// length for a length.
    pub fn error_of_drives(&self, from: f64, to: f64) -> f64 {
        let of_joint = |joint: &Joint| {
            let (start, end) = (self.drive(joint, from), self.drive(joint, to));
            let curvature = (to - from).powi(2) * (end.acceleration - start.acceleration).abs();
            if joint.rows.first().is_some_and(Row::is_driven_angle) {
                (curvature + (end.value - start.value).abs().powi(3)) / 12.0
            } else {
                curvature / (12.0 * self.length)
            }
        };
        self.joints.iter().filter(|joint| joint.drive.is_some()).map(of_joint).fold(0.0, larger)
    }

    /// Rate by which velocities `v` at the displacements `u` miss that of a joint's drive; `None` for a joint without a drive.
    pub fn missed_rate(&self, joint: &Joint, [u, v]: [&[Nodal]; 2], time: f64) -> Option<f64> {
        joint.drive?;
        let drive = self.drive(joint, time);
        let row = joint.rows.first()?;
        Some(self.row_rate(joint, row, [u, v], drive).abs())
    }

    /// Rate by which velocities `v` at the displacements `u` exceed a rate of a joint's drive, with its sign; `None` for a joint without a drive.
    pub fn excess_rate(&self, joint: &Joint, [u, v]: [&[Nodal]; 2], (time, rate): (f64, f64)) -> Option<f64> {
        joint.drive?;
        let drive = DriveValue { rate, ..self.drive(joint, time) };
        Some(self.row_rate(joint, joint.rows.first()?, [u, v], drive))
    }

    /// Largest rate by which velocities `v` at the displacements `u` open a joint: over the length of the model for distances [1/time].
    pub fn opening_rate(&self, joint: &Joint, [u, v]: [&[Nodal]; 2], time: f64) -> f64 {
        let drive = self.drive(joint, time);
        let rate = |row: &Row| self.row_rate(joint, row, [u, v], drive).abs() / row.size;
        joint.constraints().iter().map(rate).fold(0.0, larger)
    }

    /// Rate of a constraint of a joint with velocities `v` at the displacements `u`.
    fn row_rate(&self, joint: &Joint, row: &Row, [u, v]: [&[Nodal]; 2], drive: DriveValue) -> f64 {
        joint.with_vectors(self.displaced(|v| Vec3::from(u[v])), |current, gradient| {
            row.add_gradient(1.0, current, drive.value, gradient);
            along(joint, gradient, |number| Vec3::from(v[number])) + row.driven_rate(current, drive)
        })
    }

    /// Nodal vectors with given displacements.
    fn displaced(&self, displacement: impl Fn(usize) -> Vec3) -> impl Fn(usize) -> Vec3 {
        move |v| Vec3::from(self.coordinates.reference[v]) + displacement(v)
    }
}

/// Change of a constraint of a joint with this gradient along a field.
fn along(joint: &Joint, gradient: &[Vec3], field: impl Fn(usize) -> Vec3) -> f64 {
    gradient.iter().zip(&joint.vectors).map(|(g, &v)| g.dot(&field(v as usize))).sum()
}
