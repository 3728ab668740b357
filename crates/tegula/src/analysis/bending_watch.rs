//! Watch of the angles by which elements of beams bend and twist during a run.
//!
//! Directors are linear over an element. Where it bends or twists by the angle θ from its reference shape, its moment is too small by 2θ²/3: a beam
//! of few elements is too soft without any other sign of it.

use nalgebra::Rotation3;

use super::Observer;
use crate::element::Nodal;
use crate::system::System;
use crate::{Mat3, Vec3};

/// Angle of an element (rad) that triggers the first warning: its moment is too small by 5 %.
const FIRST: f64 = 0.27;
/// Growth factor of this angle that triggers the next warning.
const GROWTH: f64 = 2.0;

/// Watch of the elements of beams: warns each time that the largest angle has grown.
pub(super) struct BendingWatch {
    /// Angle that triggers the next warning (rad).
    next: f64,
}

impl BendingWatch {
    /// Watch without any warning yet.
    pub fn new() -> Self {
        Self { next: FIRST }
    }

    /// Looks at the beams of a state; `at` gives its time or load factor as text.
    pub fn look(
        &mut self,
        system: &System,
        u: &[Nodal],
        observer: &mut dyn Observer,
        at: impl Fn() -> String,
    ) {
        if system.linear {
            return;
        }
        let largest = system.beams.iter().map(|beam| (largest_angle(system, u, beam.bodies.clone()), beam));
        let Some((angle, beam)) = largest.max_by(|a, b| a.0.total_cmp(&b.0)) else { return };
        if !(angle >= self.next) {
            return;
        }
        self.next = GROWTH * angle;
        observer.on_warning(&format!(
            "{}: an element of the beam \"{}\" bends or twists by {:.0}°, and its moment is too small by about {:.0} %: give the beam more `elements`",
            at(),
            beam.name,
            angle.to_degrees(),
            100.0 * 2.0 / 3.0 * angle * angle
        ));
    }
}

/// Largest angle between neighbouring nodes beyond that in the reference configuration (rad).
fn largest_angle(system: &System, u: &[Nodal], nodes: std::ops::Range<usize>) -> f64 {
    let bodies = system.coordinates.bodies.get(nodes).unwrap_or_default();
    let axes = |body: usize, moved: bool| {
        let directors = bodies.get(body)?.directors?;
        let at = |v: u32| {
            let change = if moved { Vec3::from(u[v as usize]) } else { Vec3::zeros() };
            Vec3::from(system.coordinates.reference[v as usize]) + change
        };
        Some(Mat3::from_columns(&directors.map(at)))
    };
    let turned = |first: usize| {
        let [before, now] =
            [false, true].map(|moved| Some(axes(first, moved)?.transpose() * axes(first + 1, moved)?));
        Some(Rotation3::from_matrix_unchecked(before?.transpose() * now?).angle())
    };
    (0..bodies.len().saturating_sub(1)).filter_map(turned).fold(0.0, crate::norm::larger)
}
