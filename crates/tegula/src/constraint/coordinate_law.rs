//! Force laws of the relative coordinate of a joint: Coulomb friction and stops.
//!
//! The coordinate s is the length by which the second side of a prismatic joint has moved along the axis, or the angle by which that of
//! a revolute joint has turned about it; both are 0 in the reference configuration. Its multiplier λ is the force (torque) that resists
//! its growth: the joint acts with `−λ ∂s/∂q`. With the reaction force N of the joint across its axis, the radius r of a revolute joint
//! (1 for a prismatic one) and the constant part T₀ the law is
//!
//! ```text
//! moving:  λ = sign(ṡ) T,  T = μ r |N| + T₀
//! held:    s = const,  |λ| ≤ T_s,  T_s = μ_s r |N| + T₀;   at an upper stop −T_s ≤ λ < ∞, at a lower one −∞ < λ ≤ T_s
//! impact:  ṡ⁺ = −e ṡ⁻
//! ```
//!
//! Coulomb's law with true stick, Signorini's unilateral contact and Newton's law of impact: J. J. Moreau, *Unilateral contact and dry
//! friction in finite freedom dynamics* (1988); F. Pfeiffer, Ch. Glocker, *Multibody dynamics with unilateral contacts* (1996); V. Acary,
//! B. Brogliato, *Numerical methods for nonsmooth dynamical systems* (2008). Where the joint is held, the force law is a further
//! constraint, a locked joint whose multiplier must stay within its limits; friction and the force of a stop are one multiplier then, of
//! which friction is said to carry as much as it can.
//!
//! **Limits.** N is the reaction force at the point of the joint; reaction moments, such as those of a prismatic joint that is loaded
//! beside its axis, do not contribute to friction. Impacts are free of friction: impulses of reactions make no friction impulses, and a
//! joint that sticks does not transmit any. A joint whose reactions are not unique has those of minimum norm, and friction from them.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::{Attachment, Joint, Row};
use crate::Vec3;

/// Most constraints of a joint that make up the reaction across its axis.
pub const MOST_NORMALS: usize = 3;

/// Force law of the relative coordinate of a joint.
#[derive(Debug, Clone, PartialEq)]
pub struct CoordinateLaw {
    /// Coordinate less the value at which it is held.
    pub row: Row,
    /// Whether the coordinate is an angle.
    pub is_angle: bool,
    /// Friction per reaction force, μ r and μ_s r: a number for lengths, a length for angles.
    pub coefficients: [f64; 2],
    /// Constant part of the friction force or torque.
    pub preload: f64,
    /// Lower and upper stop (length, rad); infinite where there is none.
    pub stops: [f64; 2],
    /// Coefficient of restitution.
    pub restitution: f64,
    /// Constraints of the joint whose multipliers make up its reaction force.
    pub normals: Range<usize>,
    /// Whether it acts in the analysis step: then its constraint is the last one of the joint.
    pub acts: bool,
    /// Axis of the joint, along which the reaction force does not count; `None` where all its constraints are across it.
    pub axis: Option<Attachment>,
}

/// Friction at a reaction force.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FrictionLimit {
    /// Friction T of the moving joint.
    pub sliding: f64,
    /// Friction T_s up to which the joint sticks.
    pub sticking: f64,
    /// Derivatives of T by the multipliers of the constraints that make up the reaction.
    pub gradient: [f64; MOST_NORMALS],
}

impl CoordinateLaw {
    /// Whether it has friction.
    pub fn has_friction(&self) -> bool {
        self.coefficients != [0.0; 2] || self.preload != 0.0
    }

    /// Friction of a joint with this law for the multipliers of all constraints, where the nodal vectors have the values `value`.
    pub fn limit(&self, joint: &Joint, multipliers: &[f64], value: impl Fn(u32) -> Vec3) -> FrictionLimit {
        let mut normal = Vec3::zeros();
        for (n, row) in normal.iter_mut().zip(self.normals.clone()) {
            // The friction of an unknown reaction must not look like none.
            *n = multipliers.get(joint.first + row).copied().unwrap_or(f64::NAN);
        }
        if let Some(axis) = &self.axis {
            let axis = axis.value(value).normalize();
            normal -= axis * axis.dot(&normal);
        }
        let size = normal.norm();
        let [sliding, sticking] = self.coefficients.map(|factor| factor * size + self.preload);
        let gradient = if size > 0.0 { normal * (self.coefficients[0] / size) } else { Vec3::zeros() };
        FrictionLimit { sliding, sticking, gradient: gradient.into() }
    }
}

/// Relative coordinate of a joint with a force law: part of the state.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CoordinateState {
    /// Number of the joint.
    pub joint: usize,
    /// Value (length, rad), continued over full turns.
    pub value: f64,
    /// Whether the joint moves or is held.
    pub mode: CoordinateMode,
}

/// Whether the coordinate of a joint moves or is held.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum CoordinateMode {
    /// It moves; with friction the sign of its velocity, else 0.
    Moving(f64),
    /// It is held.
    Held {
        /// Value at which it is held.
        at: f64,
        /// −1 at the lower stop, 1 at the upper one, 0 where friction alone holds it.
        stop: f64,
    },
}

impl CoordinateMode {
    /// Whether the coordinate is held.
    pub fn is_held(&self) -> bool {
        matches!(self, Self::Held { .. })
    }
}

/// Friction and force of a stop on the second side, along or about the axis, of a multiplier λ.
pub fn parts(mode: &CoordinateMode, limit: &FrictionLimit, multiplier: f64) -> [f64; 2] {
    match mode {
        CoordinateMode::Held { stop, .. } if *stop != 0.0 => {
            let friction = multiplier.clamp(-limit.sticking.abs(), limit.sticking.abs());
            [-friction, friction - multiplier]
        }
        _ => [-multiplier, 0.0],
    }
}
