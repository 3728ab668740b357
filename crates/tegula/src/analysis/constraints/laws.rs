//! Friction and stops in the equations of the multipliers.
//!
//! Where the relative coordinate of a joint is held, its constraint is one like all others. Where it moves, its multiplier is that of
//! the [law](crate::constraint::coordinate_law): with the sign σ of the velocity and the friction T(λ) of the reactions
//!
//! ```text
//! Δλ_i = b + Σ c_j Δλ_j,   b = σ T(λ) − λ_i,   c_j = σ ∂T/∂λ_j,
//! ```
//!
//! which is eliminated: b acts as a force, and a multiplier λ_j of the reaction brings the friction `c_j` times the force of the
//! coordinate along with it, `K⁻¹Gᵀ_j + c_j K⁻¹Gᵀ_i`. Friction is that of the reactions of the same step, and Newton's method is
//! consistent with it. The derivative of the axis by the motion is left out.

use crate::Vec3;
use crate::constraint::coordinate_law::MOST_NORMALS;
use crate::constraint::{CoordinateMode, CoordinateState, DriveValue, Joint};
use crate::element::Motion;
use crate::system::evaluation_point::current_vector;
use crate::system::{EvaluationPoint, System};

/// Relative coordinate of one joint.
struct Law {
    /// Index of the joint in the system.
    joint: usize,
    /// Number of its constraint.
    row: usize,
    /// Number of the first constraint that makes up the reaction, and how many do.
    normals: (usize, usize),
    mode: CoordinateMode,
    /// Derivatives c at the last tangent.
    gradient: [f64; MOST_NORMALS],
    /// Change b of the multiplier in the next increment.
    change: f64,
}

impl Law {
    /// Sign of the velocity of a coordinate that moves.
    fn direction(&self) -> Option<f64> {
        match self.mode {
            CoordinateMode::Moving(direction) => Some(direction),
            CoordinateMode::Held { .. } => None,
        }
    }
}

/// Relative coordinates with friction or stops of all joints.
pub(super) struct Laws {
    list: Vec<Law>,
    /// Number of constraints.
    rows: usize,
    /// Whether friction follows reactions.
    friction: bool,
}

impl Laws {
    pub fn new(system: &System) -> Self {
        let of_joint = |(joint, data): (usize, &Joint)| {
            let (row, law) = data.law_row()?;
            Some(Law {
                joint,
                row,
                normals: (data.first + law.normals.start, law.normals.len()),
                mode: CoordinateMode::Moving(0.0),
                gradient: [0.0; MOST_NORMALS],
                change: 0.0,
            })
        };
        let list = system.joints.iter().enumerate().filter_map(of_joint).collect();
        Self { list, rows: system.constraints(), friction: true }
    }

    pub fn set_modes(&mut self, coordinates: &[CoordinateState]) {
        for (law, coordinate) in self.list.iter_mut().zip(coordinates) {
            law.mode = coordinate.mode;
        }
    }

    pub fn set_friction(&mut self, acts: bool) {
        self.friction = acts;
    }

    /// Whether a constraint is that of a coordinate that moves.
    pub fn is_moving(&self, row: usize) -> bool {
        self.list.iter().any(|law| law.row == row && law.direction().is_some())
    }

    /// Value of the drive of a joint, or at which its relative coordinate is held.
    pub fn target(&self, system: &System, joint: &Joint, time: f64) -> f64 {
        match self.list.iter().find(|law| system.joints[law.joint].number == joint.number) {
            Some(Law { mode: CoordinateMode::Held { at, .. }, .. }) => *at,
            Some(_) => 0.0,
            None => system.drive_value(joint, time),
        }
    }

    /// Value and rates of the drive of a joint; coordinates are held at rest.
    pub fn drive(&self, system: &System, joint: &Joint, time: f64) -> DriveValue {
        if joint.law_row().is_some() {
            DriveValue { value: self.target(system, joint, time), ..DriveValue::default() }
        } else {
            system.drive(joint, time)
        }
    }

    /// Lets the responses to multipliers of reactions contain friction.
    pub fn couple(&mut self, system: &System, k: &EvaluationPoint, responses: &mut [f64]) {
        let n = responses.len() / self.rows.max(1);
        for law in &mut self.list {
            let direction = law.direction().filter(|_| self.friction).unwrap_or(0.0);
            law.gradient = [0.0; MOST_NORMALS];
            if direction == 0.0 {
                continue;
            }
            let (first, count) = law.normals;
            let joint = &system.joints[law.joint];
            let Some((_, own)) = joint.law_row() else { continue };
            let limit =
                own.limit(joint, k.internal.multipliers, |v| current_vector(system, &k.motion, v as usize));
            for (i, c) in limit.gradient.iter().enumerate().take(count).filter(|(_, c)| **c != 0.0) {
                law.gradient[i] = direction * c;
                let (before, behind) = responses.split_at_mut(law.row * n);
                let of_reaction = &mut before[(first + i) * n..][..n];
                of_reaction.iter_mut().zip(&behind[..n]).for_each(|(x, y)| *x += law.gradient[i] * y);
            }
        }
    }

    /// Takes the multipliers of coordinates that move out of the equations of the others.
    pub fn separate(&self, matrix: &mut [f64]) {
        let m = self.rows;
        for law in self.list.iter().filter(|law| law.direction().is_some()) {
            let i = law.row;
            let diagonal = matrix[i * m + i].abs();
            (0..m).for_each(|j| (matrix[i * m + j], matrix[j * m + i]) = (0.0, 0.0));
            matrix[i * m + i] = if diagonal > 0.0 { diagonal } else { 1.0 };
        }
    }

    /// Finds the changes b of the multipliers from their laws.
    pub fn follow(&mut self, system: &System, motion: &Motion, multipliers: &[f64]) {
        for law in &mut self.list {
            let Some(direction) = law.direction() else { continue };
            let joint = &system.joints[law.joint];
            let Some((row, own)) = joint.law_row() else { continue };
            let value = |v: u32| -> Vec3 { current_vector(system, motion, v as usize) };
            let friction =
                if direction == 0.0 { 0.0 } else { direction * own.limit(joint, multipliers, value).sliding };
            law.change = friction - multipliers[row];
        }
    }

    /// Adds the response to the changes b to an increment.
    pub fn add_response(&self, responses: &[f64], x: &mut [f64]) {
        for law in self.list.iter().filter(|law| law.change != 0.0) {
            let response = &responses[law.row * x.len()..][..x.len()];
            x.iter_mut().zip(response).for_each(|(x, z)| *x -= law.change * z);
        }
    }

    /// Clears the right sides of coordinates that move.
    pub fn clear(&self, right: &mut [f64]) {
        for law in self.list.iter().filter(|law| law.direction().is_some()) {
            right[law.row] = 0.0;
        }
    }

    /// Completes the changes of the multipliers by those of coordinates that move.
    pub fn complete(&mut self, change: &mut [f64]) {
        for law in &mut self.list {
            if law.direction().is_none() {
                continue;
            }
            let reactions = &change[law.normals.0..][..law.normals.1];
            let friction: f64 = law.gradient.iter().zip(reactions).map(|(c, x)| c * x).sum();
            change[law.row] = std::mem::take(&mut law.change) + friction;
        }
    }
}
