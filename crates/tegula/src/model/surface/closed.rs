//! Edges of a surface: a closed surface passes each of them twice, in opposite directions.

use super::{SurfaceDefect, defect};
use crate::Vec3;

/// Edge of a closed surface: the two triangles that share it.
pub(super) type Edge = [u32; 2];

/// Passage of a triangle along the edge between two vertices, from the lower to the higher number or back.
type Passage = ((u32, u32), bool, u32);

/// Edges of a closed surface of consistent orientation, each with its two triangles.
pub(super) fn edges(triangles: &[[u32; 3]], points: &[Vec3]) -> Result<Vec<Edge>, SurfaceDefect> {
    let mut passages: Vec<Passage> = Vec::with_capacity(3 * triangles.len());
    for (number, t) in (0u32..).zip(triangles) {
        for i in 0..3 {
            let (a, b) = (t[i], t[(i + 1) % 3]);
            passages.push(((a.min(b), a.max(b)), a < b, number));
        }
    }
    passages.sort_unstable();
    let mut out = Vec::with_capacity(passages.len() / 2);
    let [mut open, mut crowded, mut reversed] = [const { Vec::new() }; 3];
    for group in passages.chunk_by(|a, b| a.0 == b.0) {
        match group {
            [(_, first, a), (_, second, b)] if first != second => out.push([*a, *b]),
            [(edge, ..), _] => reversed.push(*edge),
            [(edge, ..)] => open.push(*edge),
            [(edge, ..), ..] => crowded.push(*edge),
            [] => {}
        }
    }
    let place = |list: &[(u32, u32)]| {
        let (a, b) = list.first().copied().unwrap_or_default();
        format!("from {} to {}", at(&points[a as usize]), at(&points[b as usize]))
    };
    let count = |list: &[(u32, u32)], verb: [&str; 2]| match list.len() {
        1 => format!("1 edge {}", verb[0]),
        n => format!("{n} edges {}", verb[1]),
    };
    if !open.is_empty() {
        return Err(defect(
            format!(
                "the surface is not closed: {} to one triangle only, such as the edge {}",
                count(&open, ["belongs", "belong"]),
                place(&open)
            ),
            "close the holes in the program that made the surface; vertices that should be one must have equal coordinates",
        ));
    }
    if !crowded.is_empty() {
        return Err(defect(
            format!(
                "the surface does not bound one solid: {} to more than two triangles, such as the edge {}",
                count(&crowded, ["belongs", "belong"]),
                place(&crowded)
            ),
            "remove triangles that are there twice and inner walls; make solids that touch along an edge bodies of their own",
        ));
    }
    if !reversed.is_empty() {
        return Err(defect(
            format!(
                "the triangles are not oriented alike: {} between triangles of opposite orientation, such as the edge {}",
                count(&reversed, ["lies", "lie"]),
                place(&reversed)
            ),
            "orient all triangles outwards in the program that made the surface",
        ));
    }
    Ok(out)
}

/// "(1, 2, 3)".
pub(super) fn at(x: &Vec3) -> String {
    format!("({}, {}, {})", x.x, x.y, x.z)
}
