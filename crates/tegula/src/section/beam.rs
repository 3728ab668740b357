//! Constants of beam cross-sections.

use std::f64::consts::PI;

use crate::model::{BeamSection, CircularSection, Isotropic, RectangularSection, SectionConstants};

/// Terms of the series for the torsion of a rectangle: the first one that is left out is below 1e-12.
const TERMS: u32 = 200;

/// Constants of a cross-section of a material; `None` for a shape without a material.
pub fn constants(section: &BeamSection, material: Option<&Isotropic>) -> Option<SectionConstants> {
    let (area, moments, torsion, shear) = match section {
        BeamSection::Constants(constants) => return Some(*constants),
        BeamSection::Rectangle(RectangularSection { size: [a, b] }) => {
            (a * b, [a * b.powi(3) / 12.0, b * a.powi(3) / 12.0], torsion_of_rectangle(*a, *b), 5.0 / 6.0)
        }
        BeamSection::Circle(CircularSection { radius, inner_radius }) => {
            let moment = 0.25 * PI * (radius.powi(4) - inner_radius.powi(4));
            let area = PI * (radius * radius - inner_radius * inner_radius);
            (area, [moment; 2], 2.0 * moment, shear_factor_of_ring(inner_radius / radius, material?.poisson))
        }
    };
    let Isotropic { young, poisson, density, .. } = *material?;
    let modulus = 0.5 * young / (1.0 + poisson);
    Some(SectionConstants {
        axial: young * area,
        shear: [shear * modulus * area; 2],
        bending: moments.map(|moment| young * moment),
        torsion: modulus * torsion,
        mass: density * area,
        inertia: moments.map(|moment| density * moment),
    })
}

/// Torsion constant of a rectangle by Saint-Venant's series (S. Timoshenko, J. Goodier, *Theory of elasticity*, Sect. 109).
fn torsion_of_rectangle(a: f64, b: f64) -> f64 {
    let (long, short) = if a >= b { (a, b) } else { (b, a) };
    let term = |n: f64| (0.5 * n * PI * long / short).tanh() / n.powi(5);
    let sum: f64 = (0..TERMS).map(|i| term(f64::from(2 * i + 1))).sum();
    long * short.powi(3) / 3.0 * (1.0 - 192.0 / PI.powi(5) * short / long * sum)
}

/// Shear correction factor of a ring with the ratio `m` of its radii (G. R. Cowper, *The shear coefficient in Timoshenko's beam
/// theory*, J. Appl. Mech. 33 (1966) 335–340).
fn shear_factor_of_ring(m: f64, poisson: f64) -> f64 {
    let square = (1.0 + m * m).powi(2);
    6.0 * (1.0 + poisson) * square / ((7.0 + 6.0 * poisson) * square + (20.0 + 12.0 * poisson) * m * m)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn torsion_of_rectangles_is_that_of_timoshenkos_table() {
        // Timoshenko, Goodier, Sect. 109: J/(a b³) for a/b.
        for (ratio, expected) in [(1.0, 0.1406), (1.5, 0.196), (2.0, 0.229), (4.0, 0.281), (10.0, 0.312)] {
            let j = torsion_of_rectangle(ratio, 1.0) / ratio;
            assert!((j - expected).abs() < 5e-4, "{ratio}: {j}");
            assert!((torsion_of_rectangle(1.0, ratio) / ratio - j).abs() < 1e-12);
        }
    }

    #[test]
    fn shear_factors_are_those_of_cowper() {
        assert!((shear_factor_of_ring(0.0, 0.3) - 7.8 / 8.8).abs() < 1e-12);
        assert!((shear_factor_of_ring(1.0, 0.3) - 2.6 / 4.9).abs() < 1e-12);
    }
}
