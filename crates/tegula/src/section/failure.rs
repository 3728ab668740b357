//! Failure indices of plies from stresses in their axes.

use crate::model::Strength;

/// Indices of a ply; 1 is the limit.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Failure {
    /// Tsai and Wu's polynomial.
    pub tsai_wu: f64,
    /// Factor that the stresses may grow by until Tsai and Wu's polynomial reaches 1.
    pub reserve: f64,
    /// Greatest stress over its strength.
    pub max_stress: f64,
    /// Which stress that is.
    pub mode: Mode,
}

/// Component that is nearest to its strength.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Mode {
    /// Tension along the fibres.
    #[default]
    FibreTension,
    /// Compression along the fibres.
    FibreCompression,
    /// Tension across the fibres.
    MatrixTension,
    /// Compression across the fibres.
    MatrixCompression,
    /// Shear in the plane.
    Shear,
}

/// Indices for the stresses σ1, σ2, τ12:
///
/// ```text
/// F1 σ1 + F2 σ2 + F11 σ1² + F22 σ2² + F66 τ12² + 2 F12 σ1 σ2
/// F1 = 1/Xt − 1/Xc,  F11 = 1/(Xt Xc),  F66 = 1/S²,  F12 = interaction · √(F11 F22)
/// ```
///
/// S. W. Tsai, E. M. Wu, *A general theory of strength for anisotropic materials*, J. Compos. Mater. 5 (1971) 58–80.
pub fn failure([s1, s2, s12]: [f64; 3], strength: &Strength) -> Failure {
    let Strength { xt, xc, yt, yc, s, interaction } = *strength;
    let linear = (1.0 / xt - 1.0 / xc) * s1 + (1.0 / yt - 1.0 / yc) * s2;
    let (f11, f22) = (1.0 / (xt * xc), 1.0 / (yt * yc));
    let f12 = interaction * (f11 * f22).sqrt();
    let quadratic = f11 * s1 * s1 + f22 * s2 * s2 + s12 * s12 / (s * s) + 2.0 * f12 * s1 * s2;
    let candidates = [
        (s1 / xt, Mode::FibreTension),
        (-s1 / xc, Mode::FibreCompression),
        (s2 / yt, Mode::MatrixTension),
        (-s2 / yc, Mode::MatrixCompression),
        (s12.abs() / s, Mode::Shear),
    ];
    let worst = candidates.into_iter().fold((0.0, Mode::default()), |a, b| if b.0 > a.0 { b } else { a });
    // quadratic r² + linear r = 1, in the form that does not cancel.
    let root = (linear * linear + 4.0 * quadratic).max(0.0).sqrt();
    let reserve = if linear + root > 0.0 { 2.0 / (linear + root) } else { f64::INFINITY };
    Failure { tsai_wu: linear + quadratic, reserve, max_stress: worst.0, mode: worst.1 }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STRENGTH: Strength =
        Strength { xt: 1500.0, xc: 1200.0, yt: 50.0, yc: 200.0, s: 70.0, interaction: -0.5 };

    #[test]
    fn each_strength_alone_is_the_limit() {
        for (stress, mode) in [
            ([1500.0, 0.0, 0.0], Mode::FibreTension),
            ([-1200.0, 0.0, 0.0], Mode::FibreCompression),
            ([0.0, 50.0, 0.0], Mode::MatrixTension),
            ([0.0, -200.0, 0.0], Mode::MatrixCompression),
            ([0.0, 0.0, -70.0], Mode::Shear),
        ] {
            let f = failure(stress, &STRENGTH);
            assert!((f.tsai_wu - 1.0).abs() < 1e-14 && (f.max_stress - 1.0).abs() < 1e-14, "{f:?}");
            assert!((f.reserve - 1.0).abs() < 1e-14 && f.mode == mode, "{f:?}");
        }
    }

    #[test]
    fn the_reserve_factor_leads_to_the_limit() {
        let stress = [300.0, -20.0, 31.0];
        let r = failure(stress, &STRENGTH).reserve;
        assert!(r > 1.0);
        assert!((failure(stress.map(|s| r * s), &STRENGTH).tsai_wu - 1.0).abs() < 1e-13);
        assert!((failure(stress.map(|s| 0.5 * s), &STRENGTH).reserve - 2.0 * r).abs() < 1e-12 * r);
    }
}
