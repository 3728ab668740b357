//! Meshes, displacements and stresses as bytes that a page reads without decoding: little-endian numbers of 32 bits.
//!
//! The reference configuration begins with the number of the analysis and that of the meshes. Of each mesh follow: 1 for outlines of
//! bodies or 0, the numbers of points, quadrilaterals and lines, the coordinates, the corners, the ends. A shape begins with the number of
//! the analysis, that of the shape and the time, in single precision; the displacements of the points of all meshes follow, and the von Mises
//! stresses of the quadrilaterals of the shells.

use tegula::analysis::State;

use crate::job::{Prepared, nodal, von_mises};

/// The reference configuration.
pub(super) fn mesh(part: u64, prepared: &Prepared) -> Vec<u8> {
    let Prepared { mesh, system, .. } = prepared;
    let mut bodies = Vec::new();
    if !mesh.quads.is_empty() {
        let points = mesh.positions.iter().flat_map(|x| [x[0], x[1], x[2]]);
        bodies.push(one((false, mesh.positions.len()), points, &mesh.quads, &[]));
    }
    if !system.outline.is_empty() {
        let points = system.outline.positions(&system.coordinates.reference, &[], 1.0);
        let (count, outline) = (points.len(), &system.outline);
        bodies.push(one((true, count), points.into_iter().flatten(), &outline.quads, &outline.lines));
    }
    let mut out = Vec::new();
    word(&mut out, part as u32);
    word(&mut out, bodies.len() as u32);
    out.extend(bodies.concat());
    out
}

fn one(
    (outline, count): (bool, usize),
    points: impl Iterator<Item = f64>,
    quads: &[[u32; 4]],
    lines: &[[u32; 2]],
) -> Vec<u8> {
    let mut out = Vec::new();
    for number in [usize::from(outline), count, quads.len(), lines.len()] {
        word(&mut out, number as u32);
    }
    points.for_each(|x| single(&mut out, x));
    quads.iter().flatten().chain(lines.iter().flatten()).for_each(|&i| word(&mut out, i));
    out
}

/// Displacements and stresses in a state.
pub(super) fn shape(part: u64, number: u64, prepared: &Prepared, state: &State) -> Vec<u8> {
    let Prepared { mesh, system, .. } = prepared;
    let shells = if mesh.quads.is_empty() { Vec::new() } else { nodal(system, &state.u) };
    let bodies = if system.outline.is_empty() { Vec::new() } else { system.outline.displacements(&state.u) };
    let mut out = Vec::with_capacity(12 * (1 + shells.len() + bodies.len()) + 4 * mesh.quads.len());
    word(&mut out, part as u32);
    word(&mut out, number as u32);
    single(&mut out, state.time);
    shells.iter().chain(&bodies).flatten().for_each(|&x| single(&mut out, x));
    if !mesh.quads.is_empty() {
        von_mises(mesh, system, state).into_iter().for_each(|x| single(&mut out, x));
    }
    out
}

fn word(out: &mut Vec<u8>, number: u32) {
    out.extend_from_slice(&number.to_le_bytes());
}

fn single(out: &mut Vec<u8>, x: f64) {
    out.extend_from_slice(&(x as f32).to_le_bytes());
}
