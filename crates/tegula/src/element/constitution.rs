//! From sampled strains to the stress resultants conjugate to them.
//!
//! With a linear material the energy is `½ sᵀHs` and everything inside of the element is in the
//! constant matrix `H` ([`LinearConstitution`]); else it is summed over integration points
//! ([`super::points::PointConstitution`]).

use super::group::Interior;

/// Energy of the elements of a group as a function of their sampled strains.
pub trait Constitution<const S: usize>: Send + Sync {
    /// Stress resultants n = ∂ψ/∂s.
    fn stress(&self, element: usize, s: &[f64; S], interior: &Interior) -> [f64; S];

    /// Stress of a step from `old` to `new` that does the work ψ(new) − ψ(old) on `new − old`.
    fn mean_stress(&self, element: usize, old: &[f64; S], new: &[f64; S], interior: &Interior) -> [f64; S];

    /// Calls `f` with n and with H = ∂²ψ/∂s² by rows.
    fn with_tangent<R>(
        &self,
        element: usize,
        s: &[f64; S],
        interior: &Interior,
        f: impl FnOnce(&[f64]) -> R,
    ) -> R;

    /// ∂²ψ/∂s² at `s` times a change of the strains.
    fn tangent_product(
        &self,
        element: usize,
        s: &[f64; S],
        change: &[f64; S],
        interior: &Interior,
    ) -> [f64; S];

    /// Stiffness of the reference times a strain rate: what rate damping acts with.
    fn viscous(&self, element: usize, rate: &[f64; S]) -> [f64; S];

    /// Stored energy ψ.
    fn energy(&self, element: usize, s: &[f64; S], interior: &Interior) -> f64;

    /// Enhanced parameters and internal variables per element.
    fn history(&self) -> usize {
        0
    }

    /// Internal variables that belong to `s`; returns the energy dissipated since the stored ones.
    fn update(&self, _element: usize, _s: &[f64; S], _interior: &Interior, _history: &mut [f64]) -> f64 {
        0.0
    }
}

/// Linear material: `ψ = ½ sᵀHs − Σ f n₀·s + ½ Σ f f c₀` with fields of prescribed strain of factors f.
#[derive(Debug, Clone, Default)]
pub struct LinearConstitution<const S: usize> {
    /// `S × S` per element, by rows.
    pub h: Vec<f64>,
    /// Stress that would hold back the prescribed strains, `S` per field and element.
    pub prescribed: Vec<f64>,
    /// Energy of the fields held back, by pairs of fields, per element.
    pub prescribed_energy: Vec<f64>,
    /// Number of fields of the model; 0 if none acts on this group.
    pub fields: usize,
}

impl<const S: usize> LinearConstitution<S> {
    #[inline(always)]
    fn multiply(&self, element: usize, s: &[f64; S]) -> [f64; S] {
        let h = &self.h[element * S * S..(element + 1) * S * S];
        let mut n = [0.0; S];
        for (n_k, row) in n.iter_mut().zip(h.chunks_exact(S)) {
            let mut sum = 0.0;
            for (a, b) in row.iter().zip(s) {
                sum += a * b;
            }
            *n_k = sum;
        }
        n
    }

    /// Stress of each field and its factor.
    #[inline(always)]
    fn fields<'a>(
        &'a self,
        element: usize,
        interior: &'a Interior,
    ) -> impl Iterator<Item = (f64, &'a [f64])> {
        let f = self.fields;
        interior
            .factors
            .iter()
            .copied()
            .zip(self.prescribed[element * f * S..(element + 1) * f * S].chunks(S))
    }
}

/// What an element's fields of prescribed strain store by themselves, `½ Σ f f c₀`, with c₀ by pairs of fields.
pub(super) fn energy_of_fields(constants: &[f64], factors: &[f64]) -> f64 {
    let rows = constants.chunks_exact(factors.len().max(1)).zip(factors);
    rows.flat_map(|(row, a)| row.iter().zip(factors).map(move |(c, b)| 0.5 * a * b * c)).sum()
}

impl<const S: usize> Constitution<S> for LinearConstitution<S> {
    #[inline(always)]
    fn stress(&self, element: usize, s: &[f64; S], interior: &Interior) -> [f64; S] {
        let mut n = self.multiply(element, s);
        if self.fields != 0 {
            for (factor, field) in self.fields(element, interior) {
                for (n, f) in n.iter_mut().zip(field) {
                    *n -= factor * f;
                }
            }
        }
        n
    }

    #[inline(always)]
    fn mean_stress(&self, element: usize, old: &[f64; S], new: &[f64; S], interior: &Interior) -> [f64; S] {
        self.stress(element, &std::array::from_fn(|i| 0.5 * (old[i] + new[i])), interior)
    }

    #[inline(always)]
    fn with_tangent<R>(
        &self,
        element: usize,
        _s: &[f64; S],
        _interior: &Interior,
        f: impl FnOnce(&[f64]) -> R,
    ) -> R {
        f(&self.h[element * S * S..(element + 1) * S * S])
    }

    #[inline(always)]
    fn tangent_product(&self, element: usize, _s: &[f64; S], change: &[f64; S], _: &Interior) -> [f64; S] {
        self.multiply(element, change)
    }

    #[inline(always)]
    fn viscous(&self, element: usize, rate: &[f64; S]) -> [f64; S] {
        self.multiply(element, rate)
    }

    fn energy(&self, element: usize, s: &[f64; S], interior: &Interior) -> f64 {
        let n = self.multiply(element, s);
        let mut energy = 0.5 * s.iter().zip(&n).map(|(a, b)| a * b).sum::<f64>();
        if self.fields != 0 {
            for (factor, field) in self.fields(element, interior) {
                energy -= factor * s.iter().zip(field).map(|(a, b)| a * b).sum::<f64>();
            }
            let f = self.fields;
            energy += energy_of_fields(&self.prescribed_energy[element * f * f..], interior.factors);
        }
        energy
    }
}
