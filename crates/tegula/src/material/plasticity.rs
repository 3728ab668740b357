//! Von Mises (J2) plasticity with isotropic and kinematic hardening: return mapping and consistent tangent.
//!
//! ```text
//! S = C (E − Ep),   f = |dev S − β| − √(2/3) σ_y(p),
//! σ_y(p) = y₀ + H p + (y∞ − y₀)(1 − exp(−δ p)),   β̇ = ⅔ H_k Ėp
//! ```
//!
//! The Green–Lagrange strain splits additively into elastic and plastic parts, which holds for arbitrary rotations and
//! small strains (a few percent). Radial return mapping with the consistent tangent: J. C. Simo, T. J. R.
//! Hughes, *Computational Inelasticity*, Springer 1998, Box 3.2.

use nalgebra::{Matrix6, Vector6};

use super::{MaterialLaw, Response, Strain};

/// Number of internal variables: plastic strain (tensor components, 6), back stress (6), equivalent plastic strain.
pub const HISTORY: usize = 13;
/// Index of the equivalent plastic strain among the internal variables.
pub const EQUIVALENT: usize = 12;
/// Relative excess over the yield stress that counts as round-off.
const ROUNDING: f64 = 1e-11;

/// Elastoplastic material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plasticity {
    /// Young's modulus E [force/area].
    pub young: f64,
    /// Poisson's ratio ν.
    pub poisson: f64,
    /// Initial yield stress y₀ [force/area].
    pub yield_stress: f64,
    /// Linear isotropic hardening modulus H [force/area].
    pub hardening: f64,
    /// Saturation stress y∞ [force/area]; y₀: no saturation hardening.
    pub saturation: f64,
    /// Saturation rate δ.
    pub rate: f64,
    /// Kinematic hardening modulus H_k [force/area].
    pub kinematic: f64,
}

/// Double contraction of tensors by components: shears count twice.
pub(super) fn contract(a: &Vector6<f64>, b: &Vector6<f64>) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[3] * b[3] + 2.0 * (a[2] * b[2] + a[4] * b[4] + a[5] * b[5])
}

fn deviator(v: &Vector6<f64>) -> Vector6<f64> {
    let mean = (v[0] + v[1] + v[3]) / 3.0;
    Vector6::new(v[0] - mean, v[1] - mean, v[2], v[3] - mean, v[4], v[5])
}

impl Plasticity {
    /// Yield stress and its slope at an equivalent plastic strain.
    fn yield_at(&self, p: f64) -> (f64, f64) {
        let rise = self.saturation - self.yield_stress;
        let decay = (-self.rate * p).exp();
        (
            self.yield_stress + self.hardening * p + rise * (1.0 - decay),
            self.hardening + rise * self.rate * decay,
        )
    }

    /// Energy stored by isotropic hardening, ∫(σ_y − y₀) dp.
    fn hardening_energy(&self, p: f64) -> f64 {
        let rise = self.saturation - self.yield_stress;
        let saturating = if self.rate == 0.0 {
            0.0
        } else {
            // p − (1 − exp(−δp))/δ
            rise * (p + (-self.rate * p).exp_m1() / self.rate)
        };
        0.5 * self.hardening * p * p + saturating
    }

    /// Plastic multiplier Δγ that returns a relative stress of norm `size` to the yield surface; `None` if Newton's
    /// method does not converge.
    fn slip(&self, size: f64, p: f64, mu: f64) -> Option<f64> {
        let root = (2.0_f64 / 3.0).sqrt();
        let stiffness = 2.0 * mu + 2.0 / 3.0 * self.kinematic;
        let mut slip = 0.0;
        // The residual is convex and decreasing: Newton's method converges monotonically from the left.
        for _ in 0..60 {
            let (stress, slope) = self.yield_at(p + root * slip);
            let f = size - stiffness * slip - root * stress;
            let step = f / (stiffness + 2.0 / 3.0 * slope);
            slip += step;
            if !slip.is_finite() {
                return None;
            }
            // Converged: the residual is round-off, or the correction is negligible.
            if f.abs() <= 4.0 * f64::EPSILON * size || step.abs() <= 1e-14 * slip.abs() {
                return Some(slip);
            }
        }
        None
    }
}

impl MaterialLaw for Plasticity {
    fn history(&self) -> usize {
        HISTORY
    }

    fn respond(&self, strain: &Strain, committed: &[f64], updated: &mut [f64]) -> Option<Response> {
        let old = |from: usize| Vector6::from_fn(|i, _| committed.get(from + i).copied().unwrap_or(0.0));
        let (plastic, back) = (old(0), old(6));
        let p = committed.get(EQUIVALENT).copied().unwrap_or(0.0);
        let mu = 0.5 * self.young / (1.0 + self.poisson);
        let bulk = self.young / (3.0 * (1.0 - 2.0 * self.poisson));
        let e =
            Vector6::new(strain[0], strain[1], 0.5 * strain[2], strain[3], 0.5 * strain[4], 0.5 * strain[5]);
        let volume = e[0] + e[1] + e[3];
        let trial = (deviator(&e) - plastic) * (2.0 * mu);
        let relative = trial - back;
        let size = contract(&relative, &relative).sqrt();
        let root = (2.0_f64 / 3.0).sqrt();
        let excess = size - root * self.yield_at(p).0;

        let mut identity = Matrix6::from_diagonal(&Vector6::new(1.0, 1.0, 0.5, 1.0, 0.5, 0.5));
        let one = Vector6::new(1.0, 1.0, 0.0, 1.0, 0.0, 0.0);
        let ones = one * one.transpose();
        identity -= ones / 3.0;

        let (mut slip, mut normal, mut tangent) =
            (0.0, Vector6::zeros(), ones * bulk + identity * (2.0 * mu));
        // A yielded state lies on the yield surface up to round-off, which must not select its tangent: the tangent is
        // elastic until the strain continues.
        if excess > ROUNDING * root * self.yield_at(p).0 {
            slip = self.slip(size, p, mu)?;
            normal = relative / size;
            let slope = self.yield_at(p + root * slip).1;
            let theta = 1.0 - 2.0 * mu * slip / size;
            let other = 1.0 / (1.0 + (slope + self.kinematic) / (3.0 * mu)) - (1.0 - theta);
            tangent = ones * bulk + identity * (2.0 * mu * theta)
                - normal * normal.transpose() * (2.0 * mu * other);
        }
        let deviatoric = trial - normal * (2.0 * mu * slip);
        let stress = deviatoric + one * (bulk * volume);
        let plastic = plastic + normal * slip;
        let back = back + normal * (2.0 / 3.0 * self.kinematic * slip);
        let equivalent = p + root * slip;
        for i in 0..6 {
            if let (Some(a), Some(b)) = (updated.get_mut(i), Some(plastic[i])) {
                *a = b;
            }
            if let Some(b) = updated.get_mut(6 + i) {
                *b = back[i];
            }
        }
        if let Some(value) = updated.get_mut(EQUIVALENT) {
            *value = equivalent;
        }
        let elastic = 0.5 * bulk * volume * volume + contract(&deviatoric, &deviatoric) / (4.0 * mu);
        let of_back = if self.kinematic > 0.0 { 0.75 * contract(&back, &back) / self.kinematic } else { 0.0 };
        Some(Response {
            stress,
            tangent,
            energy: elastic + self.hardening_energy(equivalent) + of_back,
            dissipation: self.yield_stress * root * slip,
        })
    }

    fn plastic_strain(&self, history: &[f64]) -> Option<f64> {
        history.get(EQUIVALENT).copied()
    }
}
