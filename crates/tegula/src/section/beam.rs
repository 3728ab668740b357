//! Constants of beam cross-sections.

use std::f64::consts::PI;

use crate::model::{
    BeamSection, BoxSection, CircularSection, Isotropic, RectangularSection, SectionConstants,
};

/// Terms of the series for the torsion of a rectangle: the first one that is left out is below 1e-12.
const TERMS: u32 = 200;

/// Constants of a cross-section of a material; `None` for a shape without a material.
pub fn constants(section: &BeamSection, material: Option<&Isotropic>) -> Option<SectionConstants> {
    let (area, moments, torsion, shear) = match section {
        BeamSection::Constants(constants) => return Some(*constants),
        BeamSection::Rectangle(RectangularSection { size: [a, b] }) => {
            (a * b, moments_of_rectangle([*a, *b]), torsion_of_rectangle(*a, *b), [5.0 / 6.0; 2])
        }
        BeamSection::Box(BoxSection { size, thickness }) => {
            let inside = size.map(|side| side - 2.0 * thickness);
            let [outer, inner] = [*size, inside].map(moments_of_rectangle);
            let middle = size.map(|side| side - thickness);
            let [a, b] = middle;
            let poisson = material?.poisson;
            (
                size[0] * size[1] - inside[0] * inside[1],
                [outer[0] - inner[0], outer[1] - inner[1]],
                torsion_of_box(middle, *thickness),
                [shear_factor_of_box(a, b, poisson), shear_factor_of_box(b, a, poisson)],
            )
        }
        BeamSection::Circle(CircularSection { radius, inner_radius }) => {
            let moment = 0.25 * PI * (radius.powi(4) - inner_radius.powi(4));
            let area = PI * (radius * radius - inner_radius * inner_radius);
            let shear = shear_factor_of_ring(inner_radius / radius, material?.poisson);
            (area, [moment; 2], 2.0 * moment, [shear; 2])
        }
    };
    let Isotropic { young, poisson, density, .. } = *material?;
    let modulus = 0.5 * young / (1.0 + poisson);
    Some(SectionConstants {
        axial: young * area,
        shear: shear.map(|factor| factor * modulus * area),
        bending: moments.map(|moment| young * moment),
        torsion: modulus * torsion,
        mass: density * area,
        inertia: moments.map(|moment| density * moment),
    })
}

/// Second moments of area of a rectangle with the sides a and b along the axes 1 and 2, about these axes.
fn moments_of_rectangle([a, b]: [f64; 2]) -> [f64; 2] {
    [a * b.powi(3) / 12.0, b * a.powi(3) / 12.0]
}

/// Torsion constant of a box with the sides of the middle line of its walls: Bredt's formula 4 A²/∮ds/t (S. Timoshenko, J. Goodier, *Theory of elasticity*,
/// Sect. 116), and the walls as an open section.
fn torsion_of_box([a, b]: [f64; 2], thickness: f64) -> f64 {
    2.0 * thickness * (a * b).powi(2) / (a + b) + 2.0 * (a + b) * thickness.powi(3) / 3.0
}

/// Shear correction factor of a box with walls of one thickness, for a force along the sides `along` of the middle line, with the sides `across` it
/// (G. R. Cowper, *The shear coefficient in Timoshenko's beam theory*, J. Appl. Mech. 33 (1966) 335–340).
fn shear_factor_of_box(along: f64, across: f64, poisson: f64) -> f64 {
    // Of equal thickness the ratio of the areas of flange and web is that of their lengths.
    let m = across / along;
    let polynomial = |c: [f64; 4]| c[0] + m * (c[1] + m * (c[2] + m * c[3]));
    let walls = polynomial([12.0, 72.0, 150.0, 90.0]) + poisson * polynomial([11.0, 66.0, 135.0, 90.0]);
    let width = 10.0 * m * m * ((3.0 + poisson) * m + 3.0 * m * m);
    10.0 * (1.0 + poisson) * (1.0 + 3.0 * m).powi(2) / (walls + width)
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

    /// Square hollow section 100 × 100 × 5 mm with sharp corners: A = 1900 mm², I = 2.866e6 mm⁴, J = a³ t for its middle line a = 95 mm.
    #[test]
    fn a_box_has_the_constants_of_thin_walls() {
        let section = BeamSection::Box(BoxSection { size: [100.0, 100.0], thickness: 5.0 });
        let material = Isotropic::new(1.0, 0.0, 1.0);
        let found = constants(&section, Some(&material)).unwrap();
        assert!((found.axial - 1900.0).abs() < 1e-9 && (found.bending[0] - 2_865_833.333).abs() < 1e-3);
        assert_eq!(found.bending[0], found.bending[1]);
        let bredt = 0.5 * 95.0_f64.powi(3) * 5.0;
        assert!((found.torsion / bredt - 1.0).abs() < 0.005, "{} {bredt}", found.torsion);
        // The first side is that along axis 1: it counts in the bending about axis 2.
        let flat = BeamSection::Box(BoxSection { size: [200.0, 50.0], thickness: 2.0 });
        let found = constants(&flat, Some(&material)).unwrap();
        assert!(
            found.bending[1] > 4.0 * found.bending[0] && found.shear[0] > 3.0 * found.shear[1],
            "{found:?}"
        );
    }

    #[test]
    fn shear_factors_are_those_of_cowper() {
        assert!((shear_factor_of_ring(0.0, 0.3) - 7.8 / 8.8).abs() < 1e-12);
        assert!((shear_factor_of_ring(1.0, 0.3) - 2.6 / 4.9).abs() < 1e-12);
        // Thin-walled square tube: 20 (1 + ν)/(48 + 39 ν).
        assert!((shear_factor_of_box(0.1, 0.1, 0.3) - 26.0 / 59.7).abs() < 1e-12);
        // Without flanges two rectangles: 10 (1 + ν)/(12 + 11 ν).
        assert!((shear_factor_of_box(1.0, 0.0, 0.3) - 13.0 / 15.3).abs() < 1e-12);
    }
}
