//! Closed triangulated surfaces, from which mass, mass centre and inertia of rigid bodies are computed.
//!
//! | file | contents |
//! |---|---|
//! | `closed` | edges: each belongs to two triangles that pass it in opposite directions |
//! | `shells` | connected shells of a surface: outer boundaries and cavities |
//! | `integrals` | volume, mass centre and second moments of the enclosed solid |

mod closed;
mod integrals;
mod shells;

use std::collections::HashMap;
use std::fmt;

use crate::{Mat3, Vec3};
use integrals::VolumeIntegrals;

/// Largest coordinate, 10^60: second moments are products of five of them.
const LARGEST: f64 = 1e60;
/// Volume over area times size, below which a surface encloses nothing but round-off.
const FLAT: f64 = 1e-12;

/// Closed surface of triangles around a homogeneous solid, oriented outwards: seen from outside the corners of a triangle are in
/// counterclockwise order. Cavities have surfaces of their own, which are oriented into the cavity.
#[derive(Debug, Clone, PartialEq)]
pub struct TriangulatedSurface {
    /// Vertices, as seen from the mass centre (length).
    pub points: Vec<Vec3>,
    /// Corners of the triangles, as indices of vertices.
    pub triangles: Vec<[u32; 3]>,
    /// Mass centre of the solid (length).
    pub centre: Vec3,
    /// Volume (length³).
    pub volume: f64,
    /// Second moments ∫X Xᵀ dV / V about the mass centre (length²).
    pub second_moments: Mat3,
}

/// Reason why a surface is not the boundary of a solid, and what to do about it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SurfaceDefect {
    /// Defect, in one sentence.
    pub message: String,
    /// Remedy.
    pub help: String,
}

impl fmt::Display for SurfaceDefect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}; {}", self.message, self.help)
    }
}

impl std::error::Error for SurfaceDefect {}

fn defect(message: String, help: &str) -> SurfaceDefect {
    SurfaceDefect { message, help: help.to_owned() }
}

impl TriangulatedSurface {
    /// Surface of triangles with these corners. Corners with equal coordinates are one vertex; triangles that two equal corners reduce
    /// to a line are left out.
    ///
    /// # Errors
    /// The surface is not closed, not oriented outwards, encloses no volume, or has coordinates that are not finite.
    pub fn new(corners: &[[[f64; 3]; 3]]) -> Result<Self, SurfaceDefect> {
        if let Some((i, _)) =
            corners.iter().enumerate().find(|(_, t)| !t.iter().flatten().all(|x| x.abs() < LARGEST))
        {
            return Err(defect(
                format!("triangle {} has a coordinate that is not a number below {LARGEST:e} in size", i + 1),
                "export the surface again",
            ));
        }
        let (mut points, triangles) = merged(corners);
        if triangles.is_empty() {
            return Err(defect(
                match corners.len() {
                    0 => "the surface has no triangles".to_owned(),
                    n => format!(
                        "all {n} triangles of the surface are reduced to lines or points by equal corners"
                    ),
                },
                "export the surface of a solid",
            ));
        }
        let edges = closed::edges(&triangles, &points)?;
        // The middle of the surface is the origin of the sums, so that its distance from the origin of space is not in them.
        let [low, high] = extremes(&points);
        let middle = (low + high) * 0.5;
        points.iter_mut().for_each(|x| *x -= middle);
        let of_all = VolumeIntegrals::of(&points, triangles.iter());
        let flat = FLAT * of_all.area * (high - low).norm();
        shells::check(&triangles, (&points, &middle), &edges, flat)?;
        if !(of_all.volume > flat) {
            return Err(defect(
                format!(
                    "the surface encloses no volume: it is {:e}, for an area of {:e}",
                    of_all.volume, of_all.area
                ),
                "export the surface of a solid",
            ));
        }
        let centre = of_all.centre();
        points.iter_mut().for_each(|x| *x -= centre);
        let about_centre = VolumeIntegrals::of(&points, triangles.iter());
        Ok(Self {
            points,
            triangles,
            centre: middle + centre,
            volume: of_all.volume,
            second_moments: about_centre.second / of_all.volume,
        })
    }
}

/// Vertices and triangles after corners with equal coordinates are merged, without triangles of fewer than three vertices.
fn merged(corners: &[[[f64; 3]; 3]]) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let mut points: Vec<Vec3> = Vec::new();
    let mut number_of: HashMap<[u64; 3], u32> = HashMap::new();
    let mut number = |x: &[f64; 3]| {
        // −0 and 0 are equal, but not their bits.
        let bits = x.map(|x| (x + 0.0).to_bits());
        *number_of.entry(bits).or_insert_with(|| {
            points.push(Vec3::from(*x));
            (points.len() - 1) as u32
        })
    };
    let all: Vec<[u32; 3]> = corners.iter().map(|t| [number(&t[0]), number(&t[1]), number(&t[2])]).collect();
    (points, all.into_iter().filter(|[a, b, c]| a != b && b != c && c != a).collect())
}

/// Corners of the box about points.
fn extremes(points: &[Vec3]) -> [Vec3; 2] {
    let none = [Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY)];
    points.iter().fold(none, |[low, high], x| [low.inf(x), high.sup(x)])
}

#[cfg(test)]
mod tests;
