//! Bars of two nodes, and the beams that they become.
//!
//! | file | is |
//! |---|---|
//! | `lines` | bars one behind the other, which are one beam |
//! | `frame` | which cross-sections, bodies and nodes of shells move together |

pub mod frame;
pub mod lines;

use tegula::Vec3;

use super::Reader;
use crate::mesh::MeshError;

/// Sine of the angle between the orientation vector and a bar, below which they are parallel.
const PARALLEL: f64 = 1e-6;

/// Motion that the end of a bar does not share with its node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Release {
    /// None.
    Nothing,
    /// Rotation about an axis.
    Rotation(Vec3),
    /// All rotations.
    Rotations,
}

/// End of a bar.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct End {
    /// Number of its node.
    pub node: u64,
    /// Its place, which lies beside the node where there is an offset.
    pub point: Vec3,
    /// Motion that it does not share with the node.
    pub release: Release,
}

/// A bar.
#[derive(Debug, Clone, PartialEq)]
pub struct Bar {
    /// Kind of element, as it is spelt in the file.
    pub kind: &'static str,
    /// Number of the element.
    pub label: u64,
    /// Number of its property.
    pub property: u64,
    /// Both ends.
    pub ends: [End; 2],
    /// Orientation vector, in the plane of the axes x and y of the bar.
    pub orientation: Vec3,
    /// Axes x, y and z of the bar.
    pub axes: [Vec3; 3],
    /// Line on which it stands.
    pub line: usize,
}

impl Bar {
    /// Name of the bar in messages and results.
    pub fn name(&self) -> String {
        format!("{} {}", self.kind, self.label)
    }
}

/// Axes x, y and z of the bar `name` on a line, between two nodes at these points; `help` tells how to give another orientation vector.
///
/// # Errors
/// Both ends are in one place, or the orientation vector is zero or along the bar.
pub fn axes(
    reader: &Reader<'_>,
    (line, name): (usize, &str),
    (points, orientation): ([Vec3; 2], Vec3),
    help: &str,
) -> Result<[Vec3; 3], MeshError> {
    let [a, b] = points;
    let Some(x) = (b - a).try_normalize(0.0) else {
        return Err(reader.error(line, format!("both ends of {name} are in one place"), "check its nodes"));
    };
    let across = x.cross(&orientation);
    if !(across.norm() > PARALLEL * orientation.norm()) {
        let message = format!("the orientation vector of {name} is zero or along the bar");
        return Err(reader.error(line, message, help));
    }
    let z = across.normalize();
    Ok([x, z.cross(&x), z])
}
