//! Generalised constitutive law of an element: from sampled strains to the generalised stresses work-conjugate to them.
//!
//! With a linear material the energy is `½ sᵀHs`, and the constant matrix `H` ([`LinearLaw`]) contains the
//! integrated stiffness and the static condensation of the enhanced parameters. Otherwise the energy is summed over
//! integration points ([`super::points::PointLaw`]).

use super::group::InternalVariables;

/// Generalised constitutive law of a group: energy ψ of each element as a function of its sampled strains s, with its
/// derivatives.
pub trait GeneralizedLaw<const S: usize>: Send + Sync {
    /// Generalised stresses n = ∂ψ/∂s.
    fn stress(&self, element: usize, s: &[f64; S], interior: &InternalVariables) -> [f64; S];

    /// Algorithmic stress of a step from `old` to `new` in the energy–momentum scheme (discrete gradient): its work on
    /// `new − old` is ψ(new) − ψ(old).
    fn mean_stress(
        &self,
        element: usize,
        old: &[f64; S],
        new: &[f64; S],
        interior: &InternalVariables,
    ) -> [f64; S];

    /// Calls `f` with the tangent H = ∂²ψ/∂s², by rows.
    fn with_tangent<R>(
        &self,
        element: usize,
        s: &[f64; S],
        interior: &InternalVariables,
        f: impl FnOnce(&[f64]) -> R,
    ) -> R;

    /// Product of the tangent ∂²ψ/∂s² at `s` with a change of the strains.
    fn tangent_product(
        &self,
        element: usize,
        s: &[f64; S],
        change: &[f64; S],
        interior: &InternalVariables,
    ) -> [f64; S];

    /// Stiffness of the reference configuration times a strain rate; τ times this is the stress of Kelvin–Voigt
    /// damping.
    fn viscous(&self, element: usize, rate: &[f64; S]) -> [f64; S];

    /// Stored energy ψ.
    fn energy(&self, element: usize, s: &[f64; S], interior: &InternalVariables) -> f64;

    /// Runs an evaluation of many elements, whose results it overwrites: several times where it has laws that are evaluated at many points in one call.
    fn evaluated(&self, work: &mut dyn FnMut()) {
        work();
    }

    /// Whether stresses are affine functions of the strains and of the factors of prescribed strains, without history.
    fn is_linear(&self) -> bool {
        false
    }

    /// Number of history variables per element: enhanced parameters and internal variables.
    fn history(&self) -> usize {
        0
    }

    /// Computes the history variables at `s`; returns the energy dissipated since the committed ones.
    fn update(
        &self,
        _element: usize,
        _s: &[f64; S],
        _interior: &InternalVariables,
        _history: &mut [f64],
    ) -> f64 {
        0.0
    }
}

/// Linear generalised constitutive law: `ψ = ½ sᵀHs − Σ f n₀·s + ½ Σ f f c₀` with prescribed strain fields of factors
/// f.
#[derive(Debug, Clone, Default)]
pub struct LinearLaw<const S: usize> {
    /// H: condensed stiffness, `S × S` per element, by rows.
    pub h: Vec<f64>,
    /// n₀: generalised stress of the prescribed strains when fully restrained, `S` per field and element.
    pub prescribed: Vec<f64>,
    /// c₀: energy of the prescribed strain fields when fully restrained, by pairs of fields, per element.
    pub prescribed_energy: Vec<f64>,
    /// Number of prescribed strain fields of the model; 0 if none acts on this group.
    pub fields: usize,
}

impl<const S: usize> LinearLaw<S> {
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

    /// Factor f and restrained stress n₀ of each prescribed strain field.
    #[inline(always)]
    fn fields<'a>(
        &'a self,
        element: usize,
        interior: &'a InternalVariables,
    ) -> impl Iterator<Item = (f64, &'a [f64])> {
        let f = self.fields;
        interior
            .factors
            .iter()
            .copied()
            .zip(self.prescribed[element * f * S..(element + 1) * f * S].chunks(S))
    }
}

/// Constant part of an element's energy due to prescribed strain fields, `½ Σ f f c₀`, with c₀ by pairs of fields.
pub(super) fn energy_of_fields(constants: &[f64], factors: &[f64]) -> f64 {
    let rows = constants.chunks_exact(factors.len().max(1)).zip(factors);
    rows.flat_map(|(row, a)| row.iter().zip(factors).map(move |(c, b)| 0.5 * a * b * c)).sum()
}

impl<const S: usize> GeneralizedLaw<S> for LinearLaw<S> {
    fn is_linear(&self) -> bool {
        true
    }

    #[inline(always)]
    fn stress(&self, element: usize, s: &[f64; S], interior: &InternalVariables) -> [f64; S] {
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
    fn mean_stress(
        &self,
        element: usize,
        old: &[f64; S],
        new: &[f64; S],
        interior: &InternalVariables,
    ) -> [f64; S] {
        self.stress(element, &std::array::from_fn(|i| 0.5 * (old[i] + new[i])), interior)
    }

    #[inline(always)]
    fn with_tangent<R>(
        &self,
        element: usize,
        _s: &[f64; S],
        _interior: &InternalVariables,
        f: impl FnOnce(&[f64]) -> R,
    ) -> R {
        f(&self.h[element * S * S..(element + 1) * S * S])
    }

    #[inline(always)]
    fn tangent_product(
        &self,
        element: usize,
        _s: &[f64; S],
        change: &[f64; S],
        _: &InternalVariables,
    ) -> [f64; S] {
        self.multiply(element, change)
    }

    #[inline(always)]
    fn viscous(&self, element: usize, rate: &[f64; S]) -> [f64; S] {
        self.multiply(element, rate)
    }

    fn energy(&self, element: usize, s: &[f64; S], interior: &InternalVariables) -> f64 {
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
