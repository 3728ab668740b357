//! Ties the directors of one node where sheets meet at an angle.
//!
//! A smooth surface has one director a node. Where sheets meet at a fold or a junction
//! each sheet keeps its own director and the angle between them is kept by one strain,
//!
//! ```text
//! s = d₁·d₂ − (d₁·d₂)₀
//! ```
//!
//! the same kind of quadratic form as every strain of the shells, with a stiffness of the
//! size of their thickness stretch (h E A). Rotation of one sheet about the fold turns the
//! other; the remaining rotations are tied by the shared edge.

use super::strains::SampledStrains;

/// Nodal vectors: the two directors.
pub const VECTORS: usize = 2;

/// The strain of a tie.
pub fn strains() -> SampledStrains<2, 6, 1, 2> {
    let mut t = SampledStrains::new();
    let first = t.direction([1.0, 0.0]);
    let second = t.direction([0.0, 1.0]);
    t.product(0, 1.0, first, second);
    t
}
