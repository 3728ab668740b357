//! Power series of internal forces along an equilibrium path, for elements whose strains are quadratic and whose material is linear, and for
//! joints, whose forces `Gᵀν` are quadratic in the nodal vectors and the multipliers ν.
//!
//! On a path `v(a) = v₀ + Σ aᵖ v_p`, `λ(a) = λ₀ + Σ aᵖ λ_p` strains, generalised stresses and forces are power series, too. With the
//! symmetric bilinear form `P(u, w) = B(u) w` of the sampled strains, `s(v₀ + w) = s(v₀) + P(v₀, w) + ½ P(w, w)`, order p of a path of
//! equilibria has
//!
//! ```text
//! e_p = ½ Σ_{r=1}^{p−1} P(v_r, v_{p−r})                          known strains
//! f_p = Bᵀ(v₀) H e_p + Σ_{r=1}^{p−1} Bᵀ(v_{p−r}) n_r              known forces
//! K v_p = λ_p F − f_p                                            with the tangent K at v₀
//! n_p = H (P(v₀, v_p) + e_p) − λ_p n₀                            stresses, less those of prescribed strains per load factor
//! ```
//!
//! Asymptotic numerical method: N. Damil, M. Potier-Ferry, *A new method to compute perturbed bifurcations: application to the buckling
//! of imperfect elastic structures*, Int. J. Eng. Sci. 28 (1990) 943–957; B. Cochelin, N. Damil, M. Potier-Ferry, *Asymptotic-numerical
//! methods and Padé approximants for non-linear elastic structures*, Int. J. Numer. Meth. Engng 37 (1994) 1187–1213.

use super::group::{GroupPoint, Nodal};

/// Coefficients of a path that are known when the forces of the next order are to be found.
#[derive(Debug, Clone, Copy)]
pub struct KnownOrders<'a> {
    /// Nodal vectors of the reference configuration.
    pub reference: &'a [Nodal],
    /// Displacements at the expansion point.
    pub u: &'a [Nodal],
    /// Coefficients v₁ … v_{p−1} of the nodal vectors.
    pub coefficients: &'a [Vec<Nodal>],
    /// Last known coefficient λ_{p−1} times the changes of the factors of the prescribed strains with the load factor.
    pub strain_factors: &'a [f64],
    /// Coefficients ν₀ … ν_{p−1} of the multipliers of all constraints.
    pub multipliers: &'a [Vec<f64>],
    /// Highest order N of the series, which sets the places of the stored stresses.
    pub highest: usize,
}

impl KnownOrders<'_> {
    /// Order p whose forces are to be found; 2 or more.
    pub fn order(&self) -> usize {
        self.coefficients.len() + 1
    }
}

/// Group of elements with quadratic strains and a linear material, or of joints with quadratic constraints.
pub trait PowerSeries {
    /// Room for the generalised stresses n₁ … n_{N−1} of all elements of the group; none for joints.
    fn stored_stresses(&self, highest: usize) -> usize;

    /// Forces f_p of all elements, one block of `3 · vectors_per_element` each. `stresses` keeps the stresses of lower orders from
    /// one order to the next; orders are found in ascending sequence, from 2 on.
    fn forces_of_order(&self, known: &KnownOrders, stresses: &mut [f64], forces: &mut [f64]);

    /// Products `K x = Bᵀ(v₀) H B(v₀) x + Bᵀ(x) n₀` of the tangents of all elements in a state with a field of all nodal vectors, without the
    /// curvature of constraints; one block of `3 · vectors_per_element` each.
    fn tangent_products(&self, k: &GroupPoint, field: &[Nodal], forces: &mut [f64]);
}
