//! First-ply failure in plane stress: Tsai–Wu and maximum-stress criteria.
//!
//! Stresses are in ply axes: σ11, σ22, τ12. The criteria mark first failure only, without degradation.

use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use crate::model::Strengths;

/// How a ply fails by the criterion of maximum stress.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FailureMode {
    /// σ11 > 0 reaches X_t.
    FibreTension,
    /// σ11 < 0 reaches −X_c.
    FibreCompression,
    /// σ22 > 0 reaches Y_t.
    TransverseTension,
    /// σ22 < 0 reaches −Y_c.
    TransverseCompression,
    /// |τ12| reaches S_12.
    Shear,
}

impl Strengths {
    /// Tsai–Wu index f; failure at 1:
    ///
    /// ```text
    /// f = F1 σ1 + F2 σ2 + F11 σ1² + F22 σ2² + F66 τ12² + 2 F12 σ1 σ2
    /// F1 = 1/X_t − 1/X_c   F11 = 1/(X_t X_c)   (2: Y)   F66 = 1/S²   F12 = F12* √(F11 F22)
    /// ```
    ///
    /// The index is not proportional to the load; [`Strengths::tsai_wu_reserve`] is the margin. Source:
    /// Tsai and Wu, J. Compos. Mater. 5 (1971) 58–80.
    pub fn tsai_wu(&self, stress: &Vector3<f64>) -> f64 {
        let (linear, quadratic) = self.tsai_wu_terms(stress);
        linear + quadratic
    }

    /// Whether the Tsai–Wu index does not depend on the axes: `X = Y` and `F66 = 2 (F11 − F12)`, to 1 %, as shear strengths are given
    /// with few digits. Von Mises' criterion is the case `S = X/√3` with `F12* = −1/2`.
    pub fn is_isotropic(&self) -> bool {
        let shear = self.xt * self.xc / (2.0 * (1.0 - self.tsai_wu_interaction) * self.s12 * self.s12);
        (self.xt, self.xc) == (self.yt, self.yc) && (shear - 1.0).abs() < 1e-2
    }

    /// Reserve factor R of Tsai–Wu: the multiple of the stress at which the index is 1, from
    /// `a R² + b R = 1` with the quadratic part a and the linear part b of the index. Below 1 the ply has
    /// failed; infinite without stress.
    pub fn tsai_wu_reserve(&self, stress: &Vector3<f64>) -> f64 {
        let (b, a) = self.tsai_wu_terms(stress);
        let root = (b * b + 4.0 * a).sqrt();
        // Both expressions are the positive root; each is used where it does not cancel.
        if b >= 0.0 { 2.0 / (b + root) } else { (root - b) / (2.0 * a) }
    }

    fn tsai_wu_terms(&self, stress: &Vector3<f64>) -> (f64, f64) {
        // Scaled by geometric means the coefficients neither overflow nor lose digits.
        let (x, y) = ((self.xt * self.xc).sqrt(), (self.yt * self.yc).sqrt());
        let (s1, s2, s6) = (stress[0] / x, stress[1] / y, stress[2] / self.s12);
        let linear =
            stress[0] * (1.0 / self.xt - 1.0 / self.xc) + stress[1] * (1.0 / self.yt - 1.0 / self.yc);
        (linear, s1 * s1 + s2 * s2 + s6 * s6 + 2.0 * self.tsai_wu_interaction * s1 * s2)
    }

    /// Maximum-stress index: the greatest ratio of a stress to its strength, failure at 1, and its failure mode. The
    /// index is proportional to the load; its inverse is the reserve factor.
    pub fn maximum_stress(&self, stress: &Vector3<f64>) -> (f64, FailureMode) {
        use FailureMode::*;
        let of = |s: f64, tension: (f64, FailureMode), compression: (f64, FailureMode)| {
            if s >= 0.0 { (s / tension.0, tension.1) } else { (-s / compression.0, compression.1) }
        };
        [
            of(stress[0], (self.xt, FibreTension), (self.xc, FibreCompression)),
            of(stress[1], (self.yt, TransverseTension), (self.yc, TransverseCompression)),
            (stress[2].abs() / self.s12, Shear),
        ]
        .into_iter()
        .fold((f64::NEG_INFINITY, FibreTension), |a, b| if b.0 > a.0 { b } else { a })
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;

    use super::*;

    fn carbon() -> Strengths {
        Strengths::new(1500.0, 1200.0, 50.0, 250.0, 70.0)
    }

    #[test]
    fn each_uniaxial_strength_fails() {
        let s = carbon();
        use FailureMode::*;
        let cases = [
            (Vector3::new(s.xt, 0.0, 0.0), FibreTension),
            (Vector3::new(-s.xc, 0.0, 0.0), FibreCompression),
            (Vector3::new(0.0, s.yt, 0.0), TransverseTension),
            (Vector3::new(0.0, -s.yc, 0.0), TransverseCompression),
            (Vector3::new(0.0, 0.0, s.s12), Shear),
            (Vector3::new(0.0, 0.0, -s.s12), Shear),
        ];
        for (stress, mode) in cases {
            assert!((s.tsai_wu(&stress) - 1.0).abs() < 1e-12, "{mode:?}");
            assert!((s.tsai_wu_reserve(&stress) - 1.0).abs() < 1e-12, "{mode:?}");
            let (index, found) = s.maximum_stress(&stress);
            assert_eq!(found, mode);
            assert!((index - 1.0).abs() < 1e-12);
            assert!(s.tsai_wu(&(stress * 0.99)) < 1.0 && s.tsai_wu(&(stress * 1.01)) > 1.0);
        }
    }

    #[test]
    fn the_reserve_is_a_load_multiplier() {
        let s = carbon();
        for stress in [
            Vector3::new(700.0, -30.0, 20.0),
            Vector3::new(-300.0, 20.0, -5.0),
            Vector3::new(1.0, -200.0, 60.0),
            Vector3::new(0.0, -1e-3, 0.0),
        ] {
            let r = s.tsai_wu_reserve(&stress);
            assert!((s.tsai_wu(&(stress * r)) - 1.0).abs() < 1e-10, "{stress}");
            for factor in [1e-3, 0.5, 3.0, 1e4] {
                let scaled = s.tsai_wu_reserve(&(stress * factor));
                assert!((scaled * factor / r - 1.0).abs() < 1e-10, "{stress} times {factor}");
                let (a, b) = (s.maximum_stress(&stress), s.maximum_stress(&(stress * factor)));
                assert_eq!(a.1, b.1);
                assert!((b.0 / (a.0 * factor) - 1.0).abs() < 1e-12);
            }
        }
        assert_eq!(s.tsai_wu_reserve(&Vector3::zeros()), f64::INFINITY);
    }

    #[test]
    fn the_interaction_is_that_of_biaxial_stress() {
        // Equal strengths in tension and compression: f = s1² + s2² + 2 F12* s1 s2 over the strengths.
        let mut s = Strengths::new(10.0, 10.0, 2.0, 2.0, 1.0);
        let both = Vector3::new(10.0, 2.0, 0.0);
        assert!((s.tsai_wu(&both) - 1.0).abs() < 1e-12, "1 + 1 − 2·½");
        s.tsai_wu_interaction = 0.0;
        assert!((s.tsai_wu(&both) - 2.0).abs() < 1e-12);
        // With F12* = −½ and an isotropic material this is von Mises in plane stress.
        let yield_stress = 3.0_f64;
        let s = Strengths::new(3.0, 3.0, 3.0, 3.0, yield_stress / 3.0_f64.sqrt());
        let t: Vector3<f64> = Vector3::new(1.2, -0.7, 0.4);
        let mises = (t[0] * t[0] - t[0] * t[1] + t[1] * t[1] + 3.0 * t[2] * t[2]).sqrt();
        assert!((s.tsai_wu_reserve(&t) - yield_stress / mises).abs() < 1e-12);
    }

    #[test]
    fn isotropic_strengths_have_an_index_without_axes() {
        let mut s = Strengths::new(3.0, 4.0, 3.0, 4.0, 2.0);
        assert!(s.is_isotropic());
        let t = Vector3::new(1.2, -0.7, 0.4);
        let (centre, half) = (0.5 * (t[0] + t[1]), Vector2::new(0.5 * (t[0] - t[1]), t[2]));
        for angle in [0.3, 1.1, 2.0_f64] {
            let (sin, cos) = (2.0 * angle).sin_cos();
            let d = Vector2::new(cos * half.x + sin * half.y, cos * half.y - sin * half.x);
            let turned = Vector3::new(centre + d.x, centre - d.x, d.y);
            assert!((s.tsai_wu(&turned) - s.tsai_wu(&t)).abs() < 1e-12);
        }
        s.s12 = 1.5;
        assert!(!s.is_isotropic());
        assert!(!carbon().is_isotropic());
    }

    #[test]
    fn mistakes_name_their_keys() {
        assert!(carbon().mistakes().is_empty());
        let mut s = carbon();
        s.yc = -250.0;
        s.tsai_wu_interaction = -1.0;
        let keys: Vec<_> = s.mistakes().iter().map(|m| m.0).collect();
        assert_eq!(keys, ["yc", "tsai_wu_interaction"]);
    }
}
