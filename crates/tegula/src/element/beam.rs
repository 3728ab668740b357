//! Shear-deformable beam with directors.
//!
//! Each node has a position r and three orthonormal directors d₁, d₂, d₃: a rigid cross-section with the axes d₁ and d₂. Both
//! are linear over the element, which has one integration point in its middle. With the difference Δ and the mean (a bar) of
//! the values at both nodes the strains of the geometrically exact beam times the length L of the element are
//!
//! ```text
//! Γ_i L = d̄_i · Δr                       shear along the axes 1 and 2
//! E L = ½ Δr·Δr / L                       stretch
//! K_1 L = ½ (Δd₂·d̄₃ − Δd₃·d̄₂)            curvature about axis 1; 2 and 3 (twist) by rotation of the indices
//! ```
//!
//! less their values in the reference configuration: quadratic forms of the nodal vectors that do not change in rigid motions.
//! P. Betsch, P. Steinmann, *Frame-indifferent beam finite elements based upon the geometrically exact beam theory*, Int. J.
//! Numer. Meth. Engng 54 (2002) 1775–1788. The stretch is Green's: with `d̄₃·Δr` the axial force N would do work on the mean
//! director, which is shorter than 1 where the element bends, as if the bending stiffness were EI − N L²/4.
//!
//! One integration point does not lock, but bends like a chain of rigid bars. The residual bending flexibility
//! `1/(kGA)* = 1/(kGA) + L²/(12 EI)` gives the exact linear stiffness of a straight beam under forces at its ends (R. H.
//! MacNeal, *A simple quadrilateral shell element*, Comput. Struct. 8 (1978) 175–183).

use super::strains::SampledStrains;
use crate::model::SectionConstants;

/// Number of nodal vectors: position and three directors of both nodes.
pub const VECTORS: usize = 8;
/// Number of strains: Γ₁, Γ₂, Γ₃, K₁, K₂, K₃.
pub const STRAINS: usize = 6;
/// Number of base vectors: Δr, d̄₁, d̄₂, d̄₃, Δd₁, Δd₂, Δd₃.
pub const BASE: usize = 7;

/// Table of the sampled strains.
pub type BeamStrains = SampledStrains<VECTORS, { 3 * VECTORS }, STRAINS, BASE>;

/// Sampled strains: the strains times the length of the element, the stretch times the square of the length.
pub fn strains() -> BeamStrains {
    let mut t = BeamStrains::new();
    let pair = |vector: usize, start: f64, end: f64| {
        let mut shares = [0.0; VECTORS];
        (shares[vector], shares[4 + vector]) = (start, end);
        shares
    };
    let difference = t.direction(pair(0, -1.0, 1.0));
    let mean = [1, 2, 3].map(|i| t.direction(pair(i, 0.5, 0.5)));
    let change = [1, 2, 3].map(|i| t.direction(pair(i, -1.0, 1.0)));
    t.product(2, 0.5, difference, difference);
    for i in 0..3 {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        if i < 2 {
            t.product(i, 1.0, mean[i], difference);
        }
        t.product(3 + i, 0.5, change[j], mean[k]);
        t.product(3 + i, -0.5, change[k], mean[j]);
    }
    t
}

/// `H` by rows of an element of this length: resultants H s of the sampled strains s, of the stretch the axial force over the
/// length.
pub fn stiffness(section: &SectionConstants, length: f64) -> [f64; STRAINS * STRAINS] {
    let [bending_1, bending_2] = section.bending;
    // Shear along axis 1 goes with bending about axis 2.
    let with_bending = |shear: f64, bending: f64| 1.0 / (1.0 / shear + length * length / (12.0 * bending));
    let diagonal = [
        with_bending(section.shear[0], bending_2),
        with_bending(section.shear[1], bending_1),
        section.axial / (length * length),
        bending_1,
        bending_2,
        section.torsion,
    ];
    let mut h = [0.0; STRAINS * STRAINS];
    for (i, c) in diagonal.into_iter().enumerate() {
        h[i * (STRAINS + 1)] = c / length;
    }
    h
}
