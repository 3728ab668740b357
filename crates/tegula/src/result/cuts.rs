//! Resultants of cuts: forces and moments that elements on one side of a line receive from the rest of the model.
//!
//! An element needs the nodal forces f = ∂Π/∂x to hold its strain; its surroundings exert them on it. The sum over some elements and
//! the nodal vectors of a line,
//!
//! ```text
//! F = Σ f_r,    M = Σ (r − c) × f_r + Σ d × f_d,
//! ```
//!
//! over positions r and directors (gradients) d, is the action of everything beyond the line on these elements, about the point c. Internal
//! forces of an element have no resultant, so that F and M balance the loads less the inertia at all other nodes of the elements. Loads,
//! inertia, supports and constraints at the nodes of the line belong to its surroundings.

use super::resultant::{Resultant, add_to, arm};
use crate::Vec3;
use crate::element::Nodal;
use crate::system::System;

/// Resultant of a cut.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct CutResultant {
    /// Force, and moment about the point [`about`](Self::about).
    pub resultant: Resultant,
    /// Point about which the moment is taken.
    pub about: Vec3,
}

/// Resultants of all cuts in the configuration `u`, from the element forces of [`System::cut_forces`].
pub(super) fn cut_resultants(system: &System, u: &[Nodal], forces: &[Nodal]) -> Vec<CutResultant> {
    let mut forces = forces.iter();
    let of_cut = |cut: &crate::system::Cut| {
        let count = cut.positions.len() as f64;
        let mean = || cut.positions.iter().map(|&v| arm(system, u, v as usize)).sum::<Vec3>() / count;
        let about = cut.about.unwrap_or_else(mean);
        let mut resultant = Resultant::default();
        for ((_, v), force) in cut.forces.iter().zip(&mut forces) {
            add_to(&mut resultant, system, (u, *v as usize), &Vec3::from(*force), &about);
        }
        CutResultant { resultant, about }
    };
    system.cuts.iter().map(of_cut).collect()
}
