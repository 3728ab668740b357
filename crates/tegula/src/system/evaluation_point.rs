//! Evaluation point: the motion, time and history variables that determine forces, tangent and energies.

use std::ops::Range;

use super::System;
use crate::Vec3;
use crate::element::{ElementGroup, GroupPoint, InternalVariables, Motion, Nodal};

/// Quantities that determine forces besides the motion and the time: committed history variables, and Lagrange multipliers.
#[derive(Debug, Clone, Copy, Default)]
pub struct Internal<'a> {
    /// Committed history variables (end of the last step) of all groups: enhanced parameters and internal variables.
    pub history: &'a [f64],
    /// Lagrange multipliers of all constraints. Where they are left out, the forces of joints are NaN.
    pub multipliers: &'a [f64],
}

impl<'a> From<&'a [f64]> for Internal<'a> {
    fn from(history: &'a [f64]) -> Self {
        Self { history, multipliers: &[] }
    }
}

impl<'a> From<&'a Vec<f64>> for Internal<'a> {
    fn from(history: &'a Vec<f64>) -> Self {
        Self::from(history.as_slice())
    }
}

impl<'a, const N: usize> From<&'a [f64; N]> for Internal<'a> {
    fn from(history: &'a [f64; N]) -> Self {
        Self::from(history.as_slice())
    }
}

/// Evaluation point of all elements of a model: a motion, its time and the history variables from which it starts.
#[derive(Debug, Clone, Copy)]
pub struct EvaluationPoint<'a> {
    /// Motion: a state or a step.
    pub motion: Motion<'a>,
    /// Geometrically linear analysis: strains linear in the displacement.
    pub linear: bool,
    /// Time (load factor) at which prescribed strains and actuators act.
    pub time: f64,
    /// History variables and multipliers.
    pub internal: Internal<'a>,
}

impl<'a> EvaluationPoint<'a> {
    /// Evaluation point of a motion of a system.
    pub fn new(system: &System, motion: Motion<'a>, time: f64, internal: impl Into<Internal<'a>>) -> Self {
        Self { motion, linear: system.linear, time, internal: internal.into() }
    }

    /// Evaluation point of displacements without rates.
    pub fn at_rest(system: &System, u: &'a [Nodal], time: f64, internal: impl Into<Internal<'a>>) -> Self {
        Self::new(system, Motion::State { u, velocity: None }, time, internal)
    }

    /// Evaluation point of the elements of a group, with the factors of the prescribed strains and the values of the drives
    /// behind them ([`System::factors`]).
    pub fn of_group(&self, system: &'a System, group: usize, factors: &'a [f64]) -> GroupPoint<'a> {
        let history = &self.internal.history[system.offsets[group].history.clone()];
        let (factors, drives) = factors.split_at(system.prescribed_strains.len().min(factors.len()));
        GroupPoint {
            reference: &system.coordinates.reference,
            motion: self.motion,
            linear: self.linear,
            interior: InternalVariables { history, factors },
            inextensible: &system.coordinates.inextensible,
            multipliers: self.internal.multipliers,
            time: system.time_of_drives(self.time),
            drives,
            preload: system.part_of_preload(self.time),
        }
    }
}

/// Nodal vector of the configuration on which the forces of a motion act: the reference configuration in a linear
/// analysis, else the current one, or that in the middle of a step.
pub fn current_vector(system: &System, motion: &Motion, v: usize) -> Vec3 {
    let mut x = Vec3::from(system.coordinates.reference[v]);
    if !system.linear {
        match motion {
            Motion::State { u, .. } => x += Vec3::from(u[v]),
            Motion::Step { old, new, .. } => x += (Vec3::from(old[v]) + Vec3::from(new[v])) * 0.5,
        }
    }
    x
}

/// Ranges of a group of elements in the arrays that hold the data of all groups, one group after another.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GroupOffsets {
    /// Elements.
    pub elements: Range<usize>,
    /// Components of the element forces.
    pub forces: Range<usize>,
    /// Generalised stresses.
    pub stresses: Range<usize>,
    /// History variables.
    pub history: Range<usize>,
}

impl GroupOffsets {
    /// Ranges of all groups.
    pub fn of(groups: &[Box<dyn ElementGroup>]) -> Vec<Self> {
        let next = |end: &mut usize, size: usize| {
            let start = *end;
            *end += size;
            start..*end
        };
        let (mut elements, mut forces, mut stresses, mut history) = (0, 0, 0, 0);
        let mut ranges = |group: &dyn ElementGroup| {
            let n = group.len();
            Self {
                elements: next(&mut elements, n),
                forces: next(&mut forces, 3 * n * group.vectors_per_element()),
                stresses: next(&mut stresses, n * group.stresses_per_element()),
                history: next(&mut history, n * group.history_per_element()),
            }
        };
        groups.iter().map(|group| ranges(group.as_ref())).collect()
    }
}
