//! Shells of a surface: its connected parts, each of which is an outer boundary or that of a cavity.
//!
//! About a point off the surface the solid angles of all triangles, with sign, sum to 4π times the winding number of the surface: 1
//! within a solid, 0 outside and in a cavity. Without its own part the winding number at a shell is 0 at an outer boundary, and 1
//! at a cavity; anything else counts material twice, or subtracts it where there is none.

use std::f64::consts::PI;

use super::closed::{Edge, at};
use super::integrals::VolumeIntegrals;
use super::{SurfaceDefect, defect, extremes};
use crate::Vec3;

/// Largest deviation of a winding number: it is ½ where two shells touch.
const TOLERANCE: f64 = 0.75;

/// Connected part of a surface.
struct Shell {
    /// Numbers of its triangles.
    triangles: Vec<u32>,
    /// Volume with the sign of its orientation.
    volume: f64,
    /// Middle of its largest triangle.
    place: Vec3,
    /// Corners of the box about it.
    extremes: [Vec3; 2],
}

/// Refuses shells of the wrong orientation, and shells within shells. Volumes up to `flat` are round-off, and such shells without
/// effect. Points count from `middle`.
pub(super) fn check(
    triangles: &[[u32; 3]],
    (points, middle): (&[Vec3], &Vec3),
    edges: &[Edge],
    flat: f64,
) -> Result<(), SurfaceDefect> {
    let shells: Vec<Shell> =
        parts(triangles.len(), edges).into_iter().map(|part| shell(part, triangles, points)).collect();
    if shells.iter().all(|shell| shell.volume < -flat) {
        let volume: f64 = shells.iter().map(|shell| shell.volume).sum();
        return Err(defect(
            format!("the surface is oriented inwards: its volume is {volume:e}"),
            "reverse the orientation of the triangles (flip the normals) in the program that made the surface",
        ));
    }
    for (i, shell) in shells.iter().enumerate().filter(|(_, shell)| shell.volume.abs() > flat) {
        let others = shells.iter().enumerate().filter(|(k, other)| *k != i && other.surrounds(&shell.place));
        let winding: f64 = others.map(|(_, other)| other.winding(&shell.place, triangles, points)).sum();
        let expected = if shell.volume > 0.0 { 0.0 } else { 1.0 };
        if (winding - expected).abs() <= TOLERANCE {
            continue;
        }
        let part =
            format!("a part of {} triangles about {}", shell.triangles.len(), at(&(shell.place + middle)));
        return Err(if shell.volume > 0.0 {
            defect(
                format!("{part} lies within the solid, where its volume would count twice"),
                "unite the parts, orient the surface of a cavity into the cavity, or make the parts bodies of their own",
            )
        } else {
            defect(
                format!("{part} is oriented inwards, but is not the surface of a cavity"),
                "reverse the orientation of its triangles (flip the normals) in the program that made the surface",
            )
        });
    }
    Ok(())
}

/// Numbers of the triangles of each part that edges connect, in the order of their first triangles.
fn parts(count: usize, edges: &[Edge]) -> Vec<Vec<u32>> {
    let mut parent: Vec<u32> = (0..count as u32).collect();
    let root = |parent: &mut Vec<u32>, mut i: u32| {
        while parent[i as usize] != i {
            let above = parent[i as usize];
            parent[i as usize] = parent[above as usize];
            i = above;
        }
        i
    };
    for [a, b] in edges {
        let (a, b) = (root(&mut parent, *a), root(&mut parent, *b));
        parent[a.max(b) as usize] = a.min(b);
    }
    let mut out: Vec<Vec<u32>> = Vec::new();
    let mut part_of = vec![u32::MAX; count];
    for i in 0..count as u32 {
        let first = root(&mut parent, i) as usize;
        if part_of[first] == u32::MAX {
            part_of[first] = out.len() as u32;
            out.push(Vec::new());
        }
        out[part_of[first] as usize].push(i);
    }
    out
}

fn shell(own: Vec<u32>, triangles: &[[u32; 3]], points: &[Vec3]) -> Shell {
    let corners = |i: &u32| triangles[*i as usize].map(|corner| points[corner as usize]);
    let mut largest = (-1.0, Vec3::zeros());
    for [a, b, c] in own.iter().map(corners) {
        let area = (b - a).cross(&(c - a)).norm_squared();
        if area > largest.0 {
            largest = (area, (a + b + c) / 3.0);
        }
    }
    let all: Vec<Vec3> = own.iter().flat_map(corners).collect();
    let volume = VolumeIntegrals::of(points, own.iter().map(|i| &triangles[*i as usize])).volume;
    Shell { volume, place: largest.1, extremes: extremes(&all), triangles: own }
}

impl Shell {
    /// Whether a point lies in the box about the shell; outside of it the winding number is 0.
    fn surrounds(&self, x: &Vec3) -> bool {
        let [low, high] = self.extremes;
        (0..3).all(|i| (low[i]..=high[i]).contains(&x[i]))
    }

    /// Winding number of the shell about a point.
    fn winding(&self, x: &Vec3, triangles: &[[u32; 3]], points: &[Vec3]) -> f64 {
        let angle = |i: &u32| solid_angle(triangles[*i as usize].map(|corner| points[corner as usize] - x));
        self.triangles.iter().map(angle).sum::<f64>() / (4.0 * PI)
    }
}

/// Solid angle of a triangle seen from the origin, positive where its corners are in clockwise order from there: A. van Oosterom and
/// J. Strackee, *The solid angle of a plane triangle*, IEEE Transactions on Biomedical Engineering 30 (1983) 125–126.
fn solid_angle([a, b, c]: [Vec3; 3]) -> f64 {
    let [x, y, z] = [a.norm(), b.norm(), c.norm()];
    let across = x * y * z + a.dot(&b) * z + b.dot(&c) * x + c.dot(&a) * y;
    2.0 * a.dot(&b.cross(&c)).atan2(across)
}
