//! The shell that the iterative solver is measured with.

use crate::common::{model, plate, quarter_cylinder, vector_load};
use tegula::model::{Load, Model};

/// A square plate of side 1 or a quarter cylinder of radius and length 1, of thickness 1/`slenderness` and n × n
/// elements, clamped on one edge and loaded on the other; `distortion` shifts the inner nodes of the plate by as many
/// elements.
pub fn shell(curved: bool, n: u32, slenderness: f64, distortion: f64) -> Model {
    let mut m = if curved {
        quarter_cylinder(n, 2.1e11)
    } else {
        model(plate([1.0, 1.0], [n, n], distortion), 2.1e11, 0.01)
    };
    m.sections[0].thickness = 1.0 / slenderness;
    m.loads = vec![Load::Edge(vector_load("u_max", [0.0, 1.0, -1.0]))];
    m
}
