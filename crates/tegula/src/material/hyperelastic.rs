//! Isotropic hyperelasticity in the invariants of `C = 1 + 2E`: neo-Hooke and Mooney–Rivlin.
//!
//! ```text
//! ψ = c10 (J^(−2/3) I1 − 3) + c01 (J^(−4/3) I2 − 3) + κ/2 (J − 1)²          split
//! ψ = μ/2 (I1 − 3) − μ ln J + λ/2 (ln J)²                                    coupled
//! ```
//!
//! In the isochoric–volumetric split form a large bulk modulus κ means "nearly incompressible" and nothing else. G. A.
//! Holzapfel, *Nonlinear Solid Mechanics*, Wiley 2000, Sects. 6.4–6.6. Differences such as `1 − C⁻¹ = 2C⁻¹E` are formed
//! from the strain, so that small strains keep their digits.

use nalgebra::{Matrix3, Matrix6, Vector6};

use super::{MaterialLaw, PAIRS, Response, Strain, components, tensor};

/// Hyperelastic law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Hyperelastic {
    /// Mooney–Rivlin with isochoric–volumetric split; neo-Hooke for c01 = 0, μ = 2 (c10 + c01).
    Split {
        /// c10 [force/area].
        c10: f64,
        /// c01 [force/area].
        c01: f64,
        /// Bulk modulus κ [force/area].
        bulk: f64,
    },
    /// Neo-Hooke without isochoric–volumetric split.
    Coupled {
        /// Shear modulus μ [force/area].
        mu: f64,
        /// Lamé's λ [force/area].
        lambda: f64,
    },
}

/// Invariants of a strain, computed without cancellation.
struct Invariants {
    e: Matrix3<f64>,
    /// C⁻¹.
    inverse: Matrix3<f64>,
    /// tr E.
    trace: f64,
    /// I2 − 3.
    i2: f64,
    /// J − 1 and ln J.
    volume: f64,
    log: f64,
}

impl Invariants {
    fn of(strain: &Strain) -> Option<Self> {
        let half =
            Vector6::new(strain[0], strain[1], 0.5 * strain[2], strain[3], 0.5 * strain[4], 0.5 * strain[5]);
        let e = tensor(&half);
        let trace = e.trace();
        let second = 0.5 * (trace * trace - (e * e).trace());
        // det C − 1
        let change = 2.0 * trace + 4.0 * second + 8.0 * e.determinant();
        if change <= -1.0 || !change.is_finite() {
            return None;
        }
        let c = Matrix3::identity() + e * 2.0;
        // det C > 0 also holds if two eigenvalues of C are negative; a deformation has a positive definite C.
        c.cholesky()?;
        let inverse = c.try_inverse()?;
        let log = 0.5 * change.ln_1p();
        let volume = change / (1.0 + (1.0 + change).sqrt());
        Some(Self { e, inverse, trace, i2: 4.0 * trace + 4.0 * second, volume, log })
    }

    /// 1 − C⁻¹.
    fn one_less_inverse(&self) -> Matrix3<f64> {
        let m = self.inverse * self.e * 2.0;
        (m + m.transpose()) * 0.5
    }
}

/// Components of `a ⊗ b + b ⊗ a`.
fn symmetric_product(a: &Matrix3<f64>, b: &Matrix3<f64>) -> Matrix6<f64> {
    let (a, b) = (components(a), components(b));
    a * b.transpose() + b * a.transpose()
}

/// Components of `½ (A_ik A_jl + A_il A_jk)`.
fn identity_of(a: &Matrix3<f64>) -> Matrix6<f64> {
    Matrix6::from_fn(|row, column| {
        let ((i, j), (k, l)) = (PAIRS[row], PAIRS[column]);
        0.5 * (a[(i, k)] * a[(j, l)] + a[(i, l)] * a[(j, k)])
    })
}

impl MaterialLaw for Hyperelastic {
    fn respond(&self, strain: &Strain, _: &[f64], _: &mut [f64]) -> Option<Response> {
        Self::respond(self, strain)
    }

    fn is_hyperelastic(&self) -> bool {
        true
    }
}

impl Hyperelastic {
    /// Stress, tangent and energy for a strain; `None` where det C is not positive.
    pub fn respond(&self, strain: &Strain) -> Option<Response> {
        let v = Invariants::of(strain)?;
        let a = v.inverse;
        let one = Matrix3::identity();
        let (of_inverse, aa) = (identity_of(&a), symmetric_product(&a, &a) * 0.5);
        let (stress, tangent, energy) = match *self {
            Self::Split { c10, c01, bulk } => {
                let j = 1.0 + v.volume;
                // J^(−2/3) and J^(−4/3), and their differences from 1.
                let (p, q) = ((-2.0 / 3.0 * v.log).exp(), (-4.0 / 3.0 * v.log).exp());
                let (p1, q1) = ((-2.0 / 3.0 * v.log).exp_m1(), (-4.0 / 3.0 * v.log).exp_m1());
                let (i1, i2) = (3.0 + 2.0 * v.trace, 3.0 + v.i2);
                let b = v.one_less_inverse();
                let first = b - a * (2.0 / 3.0 * v.trace);
                let t = one * i1 - (one + v.e * 2.0);
                let second = b * 2.0 + one * (2.0 * v.trace) - v.e * 2.0 - a * (2.0 / 3.0 * v.i2);
                let pressure = bulk * v.volume * j;
                let stress = first * (2.0 * c10 * p) + second * (2.0 * c01 * q) + a * pressure;
                let of_first =
                    symmetric_product(&one, &a) * (-1.0 / 3.0) + aa * (i1 / 9.0) + of_inverse * (i1 / 3.0);
                let ones = symmetric_product(&one, &one) * 0.5;
                let of_second = ones - identity_of(&one) - symmetric_product(&t, &a) * (2.0 / 3.0)
                    + aa * (4.0 / 9.0 * i2)
                    + of_inverse * (2.0 / 3.0 * i2);
                let of_volume = aa * (bulk * j * (2.0 * j - 1.0)) - of_inverse * (2.0 * pressure);
                let tangent = of_first * (4.0 * c10 * p) + of_second * (4.0 * c01 * q) + of_volume;
                let energy = c10 * (3.0 * p1 + p * 2.0 * v.trace)
                    + c01 * (3.0 * q1 + q * v.i2)
                    + 0.5 * bulk * v.volume * v.volume;
                (stress, tangent, energy)
            }
            Self::Coupled { mu, lambda } => {
                let stress = v.one_less_inverse() * mu + a * (lambda * v.log);
                let tangent = aa * lambda + of_inverse * (2.0 * (mu - lambda * v.log));
                let energy = mu * (v.trace - v.log) + 0.5 * lambda * v.log * v.log;
                (stress, tangent, energy)
            }
        };
        Some(Response { stress: components(&stress), tangent, energy, dissipation: 0.0 })
    }
}
