//! The independent quadratic forms of a bilinear shell.
//!
//! Position and director are bilinear over the element, in the natural coordinates ξ, η
//!
//! ```text
//! 4 r = r₀ + ξ r₁ + η r₂ + ξη r₃,    4 d = d₀ + ξ d₁ + η d₂ + ξη d₃,    r₁ = Σ_a ξ_a r_a, …
//! ```
//!
//! with the nodes a at the corners (±1, ±1). Every sampled strain (metric and curvature of the surface, transverse
//! shear, thickness) is a linear combination of few scalar products of `r₁ r₂ r₃ d₀ d₁ d₂ d₃`:
//!
//! | strain | forms | count |
//! |---|---|---|
//! | membrane | ½ rᵢ·rᵢ, rᵢ·rⱼ | 6 |
//! | linear in z | rᵢ·dᵢ, rᵢ·dⱼ + rⱼ·dᵢ | 6 |
//! | quadratic in z | ½ dᵢ·dᵢ, dᵢ·dⱼ | 6 |
//! | transverse shear at the middle of the edges | r₁·d₀ + r₃·d₂, r₁·d₂ + r₃·d₀, r₂·d₀ + r₃·d₁, r₂·d₁ + r₃·d₀ | 4 |
//! | thickness at the nodes | ½ Σ dᵢ·dᵢ, d₀·d₁ + d₂·d₃, d₀·d₂ + d₁·d₃, d₀·d₃ + d₁·d₂ | 4 |
//!
//! The elastic-middle-surface element needs 20 of them for its 24 sampled strains. `s = R f` holds for all
//! displacements, so the energy `½ sᵀHs` is `½ fᵀ(RᵀHR)f`. All coefficients of the forms' derivatives are one, which
//! the [kernel](super::bilinear) exploits.

use nalgebra::{DMatrix, DVector};

use super::geometry::NODES;
use super::strains::SampledStrains;

/// Number of vectors of the basis: r₁ r₂ r₃ d₀ d₁ d₂ d₃.
pub const BASIS: usize = 7;
/// Number of nodal vectors: four positions, four directors.
pub const VECTORS: usize = 8;
/// Largest number of forms of an element type.
pub const MOST: usize = 26;

/// Index of r₁ in the basis.
pub const R1: usize = 0;
/// Index of r₂ in the basis.
pub const R2: usize = 1;
/// Index of r₃ in the basis.
pub const R3: usize = 2;
/// Index of d₀ in the basis.
pub const D0: usize = 3;
/// Index of d₁ in the basis.
pub const D1: usize = 4;
/// Index of d₂ in the basis.
pub const D2: usize = 5;
/// Index of d₃ in the basis.
pub const D3: usize = 6;

/// Index of the first form that is quadratic in z; these forms come last.
pub const QUADRATIC: usize = 20;

/// Calls a macro with `form, a, b` for the forms of membrane, curvature, shear and thickness: form = Σ a·b, with one
/// half for a = b and both orders for a ≠ b. The derivative of a form with respect to a is therefore the sum of its b.
macro_rules! surface_terms {
    ($call:ident) => {
        $call!(0, R1, R1);
        $call!(1, R2, R2);
        $call!(2, R3, R3);
        $call!(3, R1, R2);
        $call!(3, R2, R1);
        $call!(4, R1, R3);
        $call!(4, R3, R1);
        $call!(5, R2, R3);
        $call!(5, R3, R2);
        $call!(6, R1, D1);
        $call!(6, D1, R1);
        $call!(7, R2, D2);
        $call!(7, D2, R2);
        $call!(8, R3, D3);
        $call!(8, D3, R3);
        $call!(9, R1, D2);
        $call!(9, D2, R1);
        $call!(9, R2, D1);
        $call!(9, D1, R2);
        $call!(10, R1, D3);
        $call!(10, D3, R1);
        $call!(10, R3, D1);
        $call!(10, D1, R3);
        $call!(11, R2, D3);
        $call!(11, D3, R2);
        $call!(11, R3, D2);
        $call!(11, D2, R3);
        $call!(12, R1, D0);
        $call!(12, D0, R1);
        $call!(12, R3, D2);
        $call!(12, D2, R3);
        $call!(13, R1, D2);
        $call!(13, D2, R1);
        $call!(13, R3, D0);
        $call!(13, D0, R3);
        $call!(14, R2, D0);
        $call!(14, D0, R2);
        $call!(14, R3, D1);
        $call!(14, D1, R3);
        $call!(15, R2, D1);
        $call!(15, D1, R2);
        $call!(15, R3, D0);
        $call!(15, D0, R3);
        $call!(16, D0, D0);
        $call!(16, D1, D1);
        $call!(16, D2, D2);
        $call!(16, D3, D3);
        $call!(17, D0, D1);
        $call!(17, D1, D0);
        $call!(17, D2, D3);
        $call!(17, D3, D2);
        $call!(18, D0, D2);
        $call!(18, D2, D0);
        $call!(18, D1, D3);
        $call!(18, D3, D1);
        $call!(19, D0, D3);
        $call!(19, D3, D0);
        $call!(19, D1, D2);
        $call!(19, D2, D1);
    };
}

/// Calls a macro with `form, a, b` for the forms that are quadratic in z, in the convention of `surface_terms`.
macro_rules! quadratic_terms {
    ($call:ident) => {
        $call!(20, D1, D1);
        $call!(21, D2, D2);
        $call!(22, D3, D3);
        $call!(23, D1, D2);
        $call!(23, D2, D1);
        $call!(24, D1, D3);
        $call!(24, D3, D1);
        $call!(25, D2, D3);
        $call!(25, D3, D2);
    };
}

pub(super) use {quadratic_terms, surface_terms};

/// Terms `(form, a, b)` of all forms.
fn terms() -> Vec<(usize, usize, usize)> {
    let mut terms = Vec::new();
    macro_rules! push {
        ($form:literal, $a:ident, $b:ident) => {
            terms.push(($form, $a, $b));
        };
    }
    surface_terms!(push);
    quadratic_terms!(push);
    terms
}

/// Coefficient (±1 or 0) of each nodal vector in a vector of the basis.
pub(super) fn shares(vector: usize) -> [f64; VECTORS] {
    std::array::from_fn(|a| {
        let [xi, eta] = NODES[a % 4];
        let director = a >= 4;
        match (vector, director) {
            (R1, false) | (D1, true) => xi,
            (R2, false) | (D2, true) => eta,
            (R3, false) | (D3, true) => xi * eta,
            (D0, true) => 1.0,
            _ => 0.0,
        }
    })
}

/// Quadratic forms that an element type needs, and its sampled strains in terms of them.
#[derive(Debug, Clone)]
pub struct Forms {
    /// `R` of `s = R f`: sampled strains from forms; columns of forms that are not needed are zero.
    pub samples: DMatrix<f64>,
    /// Terms `(form, a, b)` of the needed forms.
    pub terms: Vec<(usize, usize, usize)>,
    /// Indices of the needed forms, ascending.
    pub needed: Vec<usize>,
}

impl Forms {
    /// Forms of an element type; `None` if its sampled strains are not linear combinations of them.
    pub fn of<const M: usize, const N: usize, const S: usize, const D: usize>(
        strains: &SampledStrains<M, N, S, D>,
    ) -> Option<Self> {
        if M != VECTORS {
            return None;
        }
        let mut terms = terms();
        // `2 A` of each form, lower triangle; for a ≠ b the list holds both orders.
        let mut columns = DMatrix::<f64>::zeros(VECTORS * (VECTORS + 1) / 2, MOST);
        for &(form, left, right) in &terms {
            let (p, q) = (shares(left), shares(right));
            let lower = (0..VECTORS).flat_map(|a| (0..=a).map(move |b| (a, b)));
            for (pair, (a, b)) in lower.enumerate() {
                columns[(pair, form)] += 0.5 * (p[a] * q[b] + q[a] * p[b]);
            }
        }
        let inverse = (columns.transpose() * &columns).cholesky()?;
        let mut samples = DMatrix::<f64>::zeros(S, MOST);
        for k in 0..S {
            let wanted = DVector::from_column_slice(strains.form(k));
            let mut shares = inverse.solve(&(columns.transpose() * &wanted));
            let size = shares.amax();
            shares.iter_mut().filter(|r| r.abs() < 1e-13 * size).for_each(|r| *r = 0.0);
            if (&columns * &shares - &wanted).amax() > 1e-13 * wanted.amax() {
                return None;
            }
            samples.row_mut(k).copy_from(&shares.transpose());
        }
        let needed: Vec<usize> = (0..MOST).filter(|&f| samples.column(f).amax() > 0.0).collect();
        terms.retain(|(form, ..)| needed.binary_search(form).is_ok());
        Some(Self { samples, terms, needed })
    }
}
