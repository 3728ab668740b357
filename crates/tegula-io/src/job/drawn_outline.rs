//! Outline of bodies, beams and springs in pictures, where lines are thin prisms.

use tegula::element::Nodal;
use tegula::{System, Vec3};

/// Half the width of a line, as a part of the model.
const HALF_WIDTH: f64 = 4e-3;

/// Faces of the outline and of its lines, as indices of the positions behind the first `before` ones.
pub(super) fn faces(system: &System, before: usize) -> Vec<[u32; 4]> {
    let outline = &system.outline;
    let quads = outline.quads.iter().map(|quad| quad.map(|corner| before as u32 + corner));
    quads.chain(faces_of_lines(outline.lines.len(), before + outline.points.len())).collect()
}

/// Positions of the points of the outline and of the corners of its lines, at displacements `u` times `scale`.
pub(super) fn positions(system: &System, u: &[Nodal], scale: f64) -> Vec<[f64; 3]> {
    let outline = &system.outline;
    let mut out = outline.positions(&system.coordinates.reference, u, scale);
    let corners = corners_of_lines(&out, &outline.lines, system.length);
    out.extend(corners);
    out
}

/// Faces of prisms along lines, as indices of the positions behind the first `before` ones.
pub(crate) fn faces_of_lines(count: usize, before: usize) -> Vec<[u32; 4]> {
    let of_prism = |line: usize| {
        let first = (before + 8 * line) as u32;
        let side = |i: u32| [i, (i + 1) % 4, (i + 1) % 4 + 4, i + 4];
        let faces = (0..4).map(side).chain([[0, 1, 2, 3], [4, 5, 6, 7]]);
        faces.map(move |face| face.map(|corner| first + corner))
    };
    (0..count).flat_map(of_prism).collect()
}

/// Corners of thin prisms along lines between points, in a model of a length.
pub(crate) fn corners_of_lines(points: &[[f64; 3]], lines: &[[u32; 2]], length: f64) -> Vec<[f64; 3]> {
    let of_line = |line: &[u32; 2]| {
        let ends = line.map(|end| Vec3::from(points[end as usize]));
        let along = (ends[1] - ends[0]).try_normalize(0.0).unwrap_or_else(Vec3::x);
        let across = along.cross(&Vec3::ith(along.iamin(), 1.0)).normalize();
        let sides = [across, along.cross(&across)].map(|side| side * (HALF_WIDTH * length));
        let corners = [sides[0] + sides[1], sides[1] - sides[0], -sides[0] - sides[1], sides[0] - sides[1]];
        ends.into_iter().flat_map(move |end| corners.map(|corner| -> Nodal { (end + corner).into() }))
    };
    lines.iter().flat_map(of_line).collect()
}
