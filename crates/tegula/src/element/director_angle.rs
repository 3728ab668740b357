//! Director-angle constraint at folds and junctions, by a penalty that vanishes with the mesh.
//!
//! Where sheets meet at an angle each keeps its own director d of the common node. Bending of one sheet about the
//! common edge has to rotate the others by the same angle; the remaining rotations of a director follow the edge
//! itself, through the transverse shear of its sheet. The constraint is that the angle φ between two directors stays
//! φ₀.
//!
//! **Strain.** With extensible directors, dᵢ = (1 + eᵢ) nᵢ, the product d₁·d₂ alone responds to both: its change is
//! −sin φ₀ Δφ + cos φ₀ (e₁ + e₂), which weakens with the angle and couples a change of thickness with the rotation. The
//! quadratic form
//!
//! ```text
//! s = [d₁·d₂ − ½ cos φ₀ (d₁·d₁ + d₂·d₂)] / sin φ₀ − (value at the reference)
//! ```
//!
//! changes by −Δφ, whatever φ₀, and not at all with the stretches: a common stretch drops out exactly, different ones
//! to first order. At a rotation Δφ it is −sin Δφ − cot φ₀ (1 − cos Δφ). Its gradient with respect to d₁ is a unit
//! vector perpendicular to d₁, so that the constraint transfers a moment and no thickness force, and does no work on
//! inextensible directors beyond their rotation. All constraints share the sampled products; the angle is in the matrix
//! `H`.
//!
//! **Stiffness.** A rotational spring k per length of fold lies in series with the sheets. A row of elements of length
//! a beside the fold rotates by a/D under a unit moment per length (D: bending stiffness of the section). The
//! constraint has the stiffness
//!
//! ```text
//! k = 2 γ D / a,        at a node  K = k b = γ D b²/A
//! ```
//!
//! with the node's tributary length b of the fold and A = a b/2 of the sheet's area, so that it adds 1/(2γ) of the
//! rotation that one row of elements has anyway. This error falls in proportion to the element size, for any thickness
//! and any angle. γ is `STIFFNESS`, or `EXPLICIT_STIFFNESS` in explicit integration, where the penalty costs critical
//! time step or rotary inertia. Of several sheets the stiffest is decisive. A penalty of this size does not spoil the
//! conditioning: thin elements have stiffer terms themselves, E h A = 6 (a/h)² D b/a for the thickness stretch of a
//! director.

use super::strains::SampledStrains;
use crate::Vec3;

/// Number of nodal vectors of a constraint: the two directors.
pub const VECTORS: usize = 2;

/// γ: stiffness of a director-angle constraint over the bending stiffness of one row of elements beside the fold.
pub const STIFFNESS: f64 = 1e3;

/// γ of explicit integration: a stiffer constraint needs more rotary inertia or a smaller time step.
pub const EXPLICIT_STIFFNESS: f64 = 20.0;

/// Sampled strains of the constraint: the products d₁·d₂, ½ d₁·d₁ and ½ d₂·d₂.
pub fn strains() -> SampledStrains<2, 6, 3, 2> {
    let mut t = SampledStrains::new();
    let first = t.direction([1.0, 0.0]);
    let second = t.direction([0.0, 1.0]);
    t.product(0, 1.0, first, second);
    t.product(1, 0.5, first, first);
    t.product(2, 0.5, second, second);
    t
}

/// `H` by rows of a director-angle constraint of rotational stiffness `k` (moment per angle) between two unit directors
/// at the reference, which are neither parallel nor antiparallel: `k a aᵀ` with `s = a·(d₁·d₂, ½ d₁·d₁, ½ d₂·d₂)`.
pub fn stiffness(d: [&Vec3; 2], k: f64) -> [f64; 9] {
    let (cosine, sine) = (d[0].dot(d[1]), d[0].cross(d[1]).norm());
    let a = [1.0 / sine, -cosine / sine, -cosine / sine];
    std::array::from_fn(|i| k * a[i / 3] * a[i % 3])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::Nodal;

    /// Twice the energy over k is the square of the formula of the module head, at any angle and stretch.
    #[test]
    fn energy_is_that_of_the_relative_rotation_alone() {
        let kernel = strains();
        for degrees in [1.0, 20.0, 60.0, 90.0, 135.0, 179.0_f64] {
            let phi = degrees.to_radians();
            let at = |angle: f64| Vec3::new(angle.sin(), 0.0, angle.cos());
            let h = stiffness([&at(0.0), &at(phi)], 2.0);
            let energy = |turn: f64, stretch: [f64; 2]| {
                let reference: [Nodal; 2] = [at(0.0).into(), at(phi).into()];
                let u = [(at(0.0) * stretch[0] - at(0.0)), (at(phi + turn) * stretch[1] - at(phi))];
                let p0 = kernel.directions(&reference);
                let s = kernel.strains(&p0, &kernel.directions(&u.map(Into::into)), true);
                (0..9).map(|i| 0.5 * s[i / 3] * h[i] * s[i % 3]).sum::<f64>()
            };
            for turn in [1e-3, -0.1, 0.4_f64] {
                let expected = (turn.sin() + (1.0 - turn.cos()) / phi.tan()).powi(2);
                let found = energy(turn, [1.0, 1.0]);
                assert!((found - expected).abs() <= 1e-10 * (expected + 1e-4), "{degrees} {turn}: {found}");
            }
            // A rotation of 1e-3 has the energy 1e-6. The three products of H and s cancel.
            let rounding = 1e-14 / phi.sin().powi(2);
            assert!(energy(0.0, [1.3, 1.3]).abs() < rounding, "{degrees}");
            let second_order = (0.5 * 0.01_f64.powi(2) / phi.tan()).powi(2);
            let found = energy(0.0, [1.01, 1.0]);
            assert!(
                (found - second_order).abs() <= 1e-3 * second_order + 1e-4 * rounding,
                "{degrees}: {found}"
            );
        }
    }
}
