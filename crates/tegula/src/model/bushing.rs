//! Bushings: stiffness and damping of all six relative motions of two bodies.

use nalgebra::Matrix6;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::body::axes_of_space;

/// A bushing between two bodies: forces and moments that depend linearly on the displacement of its points, its rotation vector and their
/// rates, along axes that move with the first side. The order of all sixes is: displacement along the axes 1, 2, 3, rotation about the
/// axes 1, 2, 3.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Bushing {
    /// Name of the bushing in messages and results.
    pub name: String,
    /// Both sides: names of bodies or of nodes of beams, or `ground`. The axes move with the first one. The second one may be a point mass
    /// or a set with one node where the bushing has no stiffness and damping of rotations.
    pub between: [String; 2],
    /// Place of the bushing in the reference configuration: the point of both sides whose distance it resists (length).
    #[schemars(extend("x-marker" = "point"))]
    pub at: [f64; 3],
    /// Direction of the first axis, and a second direction in the plane of the first two axes, in the reference configuration; the axes
    /// of space unless given.
    #[serde(default = "axes_of_space")]
    #[schemars(extend("x-marker" = "direction"))]
    pub axes: [[f64; 3]; 2],
    /// Stiffness of displacements [force/length] and of rotations [force·length/rad].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stiffness: Option<[f64; 6]>,
    /// Full stiffness matrix instead of `stiffness`, by rows: symmetric, without negative eigenvalues.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stiffness_matrix: Option<[[f64; 6]; 6]>,
    /// Damping of displacements [force·time/length] and of rotations [force·length·time/rad].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub damping: Option<[f64; 6]>,
    /// Full damping matrix instead of `damping`, by rows: symmetric, without negative eigenvalues.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub damping_matrix: Option<[[f64; 6]; 6]>,
    /// Displacement (length) and rotation vector (degrees) at which the springs have no force: a preload; zero unless given.
    #[serde(default)]
    pub free: [f64; 6],
}

impl Bushing {
    /// Stiffness matrix.
    pub fn stiffness(&self) -> Matrix6<f64> {
        matrix(self.stiffness, self.stiffness_matrix)
    }

    /// Damping matrix.
    pub fn damping(&self) -> Matrix6<f64> {
        matrix(self.damping, self.damping_matrix)
    }
}

/// Matrix of its diagonal or its rows; of rows that differ by round-off from those of a symmetric matrix the symmetric part.
fn matrix(diagonal: Option<[f64; 6]>, rows: Option<[[f64; 6]; 6]>) -> Matrix6<f64> {
    match (rows, diagonal) {
        (Some(rows), _) => {
            let full = Matrix6::from_fn(|i, j| rows[i][j]);
            (full + full.transpose()) * 0.5
        }
        (None, Some(diagonal)) => Matrix6::from_diagonal(&diagonal.into()),
        (None, None) => Matrix6::zeros(),
    }
}
