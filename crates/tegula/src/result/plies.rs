//! Stresses of plies in their own axes, failure indices, and plastic strain.
//!
//! Quantities are means over the element's points of the mid-surface, at the bottom, the middle and the top of each
//! ply. In-plane stresses are those of the ply's material for the strain there minus the prescribed strains. Transverse
//! shear stresses of elements with resultants follow from equilibrium over the thickness.

use std::sync::Arc;

use nalgebra::{Vector2, Vector3};
use rayon::prelude::*;

use super::inside::{Inside, Shape, Snapshot};
use super::recovery::CHUNK;
use crate::Mat3;
use crate::analysis::State;
use crate::section::CompiledSection;
use crate::section::compiled::{Layer, Resultant, turned_stress};
use crate::section::failure::{FailureMode, Strengths};
use crate::section::ply::shear_turn;
use crate::system::{Shell, System};

/// Stresses of a ply at one height.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PlyStress {
    /// Height over the mid-surface (length).
    pub height: f64,
    /// σ11, σ22, τ12 in the ply's axes [force/area].
    pub plane: [f64; 3],
    /// τ13, τ23 [force/area].
    pub shear: [f64; 2],
}

/// A ply of an element.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PlyResult {
    /// At the bottom, the middle and the top.
    pub stress: [PlyStress; 3],
    /// Failure indices, where the material has strengths.
    pub failure: Option<PlyFailure>,
}

/// Failure indices of a ply, the worst of its bottom, middle and top; 1 is the limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlyFailure {
    /// Index of Tsai and Wu.
    pub tsai_wu: f64,
    /// Factor by which the stresses can grow until that index is 1.
    pub reserve: f64,
    /// Greatest ratio of a stress to its strength.
    pub max_stress: f64,
    /// Stress with the greatest ratio.
    pub mode: FailureMode,
}

/// Plies of all shells at a state, in the order of [`System::shells`], from the bottom to the top; empty for a shell
/// whose stresses cannot be evaluated there. Plies count their axes from the section's direction, see
/// [`layer_axis`](crate::section::compiled::CompiledSection::layer_axis).
pub fn recover_plies(system: &System, state: &State) -> Vec<Vec<PlyResult>> {
    of_shells(&Snapshot::new(system, state))
}

/// Plies of all shells of a snapshot, in the order of [`recover_plies`]. For a small motion stresses are those of the
/// motion alone, and failure indices then belong to them alone.
pub fn of_shells(snapshot: &Snapshot) -> Vec<Vec<PlyResult>> {
    let shells = &snapshot.system.shells;
    shells
        .par_iter()
        .with_min_len(CHUNK)
        .map_init(|| None, |last, shell| plies(snapshot, shell, last).unwrap_or_default())
        .collect()
}

fn plies(snapshot: &Snapshot, shell: &Shell, last: &mut Option<Arc<Shape>>) -> Option<Vec<PlyResult>> {
    let of = &snapshot.system.sections[shell.section];
    let (section, element) = (&of.section, of.element.as_ref());
    let inside = Inside::after(snapshot, shell, last)?;
    let points = element.surface_points();
    let integration_points = inside.point_stresses();
    let per_point = integration_points.len() / points;
    let mut out = Vec::with_capacity(section.layers.len());
    for (number, layer) in section.layers.iter().enumerate() {
        let mut ply = PlyResult::default();
        let heights = [layer.bottom, 0.5 * (layer.bottom + layer.top), layer.top];
        for (at, z) in ply.stress.iter_mut().zip(heights) {
            at.height = z;
            for point in 0..points {
                let (stress, frame) = match inside.stress(point, z, layer) {
                    Some((stress, strain)) => (stress, strain.frame),
                    None => inside.stress_of_nearest_point(point, z, points, &integration_points)?,
                };
                let turn = section.layer_axis(layer, &frame);
                let plane = turned_stress(Vector3::new(stress[0], stress[1], stress[2]), -turn);
                let shear = if element.is_solid() {
                    shear_turn(turn) * Vector2::new(stress[4], stress[5])
                } else {
                    // The first integration point holds the resultants.
                    let of_section = &integration_points[point * per_point];
                    let q = Vector2::new(of_section[4], of_section[5]);
                    match shear_of_equilibrium(section, (number, layer), &frame, (&q, z)) {
                        Some(shear) => shear,
                        None => shear_turn(turn) * Vector2::new(stress[4], stress[5]),
                    }
                };
                for i in 0..3 {
                    at.plane[i] += plane[i] / points as f64;
                }
                for i in 0..2 {
                    at.shear[i] += shear[i] / points as f64;
                }
            }
        }
        ply.failure = layer.material.strength().map(|s| failure(&ply.stress, &s));
        out.push(ply);
    }
    Some(out)
}

/// Transverse shear stresses τ13, τ23 of a layer at the height z, in its own axes, which equilibrium over the thickness makes of the shear forces q of a
/// point with this frame; `None` where the section has no such distribution.
pub(super) fn shear_of_equilibrium(
    section: &CompiledSection,
    (number, layer): (usize, &Layer),
    frame: &Mat3,
    (q, z): (&Vector2<f64>, f64),
) -> Option<Vector2<f64>> {
    let turn = section.layer_axis(layer, frame);
    match &section.resultant {
        Resultant::Laminate(laminate) => laminate.shear_stress(turn - layer.angle, (number, z), q),
        Resultant::Isotropic(_) => {
            let zeta = 2.0 * (z - section.offset) / section.thickness;
            Some(shear_turn(turn) * q * (1.5 / section.thickness * (1.0 - zeta * zeta)))
        }
        _ => None,
    }
}

fn failure(stresses: &[PlyStress; 3], strength: &Strengths) -> PlyFailure {
    let at = |s: &PlyStress| {
        let plane = Vector3::from(s.plane);
        let (max_stress, mode) = strength.maximum_stress(&plane);
        let (tsai_wu, reserve) = (strength.tsai_wu(&plane), strength.tsai_wu_reserve(&plane));
        PlyFailure { tsai_wu, reserve, max_stress, mode }
    };
    let mut worst = at(&stresses[0]);
    for s in &stresses[1..] {
        let f = at(s);
        worst.tsai_wu = worst.tsai_wu.max(f.tsai_wu);
        worst.reserve = worst.reserve.min(f.reserve);
        if f.max_stress > worst.max_stress {
            (worst.max_stress, worst.mode) = (f.max_stress, f.mode);
        }
    }
    worst
}

/// Greatest equivalent plastic strain of each shell, in the order of [`System::shells`]; 0 where nothing can yield.
pub fn plastic_strains(system: &System, state: &State) -> Vec<f64> {
    let snapshot = Snapshot::new(system, state);
    system
        .shells
        .par_iter()
        .map(|shell| {
            let section = &system.sections[shell.section].section;
            let Some(inside) = Inside::new(&snapshot, shell).filter(|_| !section.is_linear()) else {
                return 0.0;
            };
            let strain = |(law, history): (usize, &[f64])| section.laws[law].plastic_strain(history);
            inside.point_history().into_iter().filter_map(strain).fold(0.0, crate::norm::larger)
        })
        .collect()
}
