//! A, B, D, Z and inertia.

use nalgebra::{Matrix3, Vector2, Vector3};

use super::super::laminate::{Laminate, LaminateError};
use super::super::ply::{angle_in_plane, shear_turn, strain_turn, turned_plane_stress};
use super::super::{SectionInertia, SectionStiffness};
use super::*;
use crate::model::Isotropic;

/// Q̄ by the explicit formulas of Jones, Mechanics of Composite Materials, eq. 2.85.
fn jones(c: &Constants, degrees: f64) -> Matrix3<f64> {
    let q = orthotropic_plane_stress(c.e1, c.e2, c.nu12, c.g12);
    let (q11, q22, q12, q66) = (q[(0, 0)], q[(1, 1)], q[(0, 1)], q[(2, 2)]);
    let (s, c) = degrees.to_radians().sin_cos();
    let (s2, c2) = (s * s, c * c);
    let b11 = q11 * c2 * c2 + 2.0 * (q12 + 2.0 * q66) * s2 * c2 + q22 * s2 * s2;
    let b12 = (q11 + q22 - 4.0 * q66) * s2 * c2 + q12 * (s2 * s2 + c2 * c2);
    let b22 = q11 * s2 * s2 + 2.0 * (q12 + 2.0 * q66) * s2 * c2 + q22 * c2 * c2;
    let b16 = (q11 - q12 - 2.0 * q66) * s * c * c2 + (q12 - q22 + 2.0 * q66) * s * s2 * c;
    let b26 = (q11 - q12 - 2.0 * q66) * s * s2 * c + (q12 - q22 + 2.0 * q66) * s * c * c2;
    let b66 = (q11 + q22 - 2.0 * q12 - 2.0 * q66) * s2 * c2 + q66 * (s2 * s2 + c2 * c2);
    Matrix3::new(b11, b12, b16, b12, b22, b26, b16, b26, b66)
}

#[track_caller]
fn same(found: &Matrix3<f64>, expected: &Matrix3<f64>, scale: f64, what: &str) {
    assert!((found - expected).norm() <= 1e-12 * scale, "{what}: {found} for {expected}");
}

#[test]
fn plane_stress_inverts_the_compliance() {
    let c = E25;
    let q = orthotropic_plane_stress(c.e1, c.e2, c.nu12, c.g12);
    let s =
        Matrix3::new(1.0 / c.e1, -c.nu12 / c.e1, 0.0, -c.nu12 / c.e1, 1.0 / c.e2, 0.0, 0.0, 0.0, 1.0 / c.g12);
    same(&(q * s), &Matrix3::identity(), 1.0, "Q S");
}

#[test]
fn a_turned_ply_has_the_stiffness_of_the_textbook() {
    for degrees in [0.0, 30.0, 45.0, -60.0, 90.0, 123.0] {
        let a = E25.laminate(&[degrees], 2.0).stiffness(0.0);
        let q = jones(&E25, degrees);
        same(&a.membrane, &(q * 2.0), 25.0, "A");
        same(&a.bending, &(q * (8.0 / 12.0)), 25.0, "D");
        same(&a.coupling, &Matrix3::zeros(), 25.0, "B");
    }
}

#[test]
fn isotropic_plies_are_a_homogeneous_section() {
    let (material, h) = (Isotropic::new(7.0, 0.3, 1.0), 0.4);
    let expected = SectionStiffness::homogeneous(&material, h, [5.0 / 6.0; 2]);
    let found = Constants::isotropic(7.0, 0.3).laminate(&[10.0, -40.0, 75.0], h).stiffness(0.3);
    same(&found.membrane, &expected.membrane, 7.0 * h, "A");
    same(&found.coupling, &expected.coupling, 7.0 * h * h, "B");
    same(&found.bending, &expected.bending, 7.0 * h * h * h, "D");
    assert!((found.shear - expected.shear).norm() < 1e-12 * h, "S");
    near(found.thickness, expected.thickness, 1e-12 * h, "Z");
}

#[test]
fn symmetric_layups_do_not_couple() {
    let s = E25.laminate(&[20.0, -70.0, 45.0, 45.0, -70.0, 20.0], 1.0).stiffness(0.4);
    same(&s.coupling, &Matrix3::zeros(), 25.0, "B");
    let s = arbitrary().stiffness(0.0);
    assert!(s.coupling.norm() > 0.1, "an unsymmetric one does");
}

#[test]
fn the_coupling_of_two_cross_plies() {
    // 0° at the bottom (z < 0): B = −∫Q z dz = h²/8 (Q(0°) − Q(90°)).
    let h = 0.6;
    let q = orthotropic_plane_stress(25.0, 1.0, 0.25, 0.5);
    let s = E25.laminate(&[0.0, 90.0], h).stiffness(0.0);
    let b = h * h / 8.0 * (q[(0, 0)] - q[(1, 1)]);
    near(s.coupling[(0, 0)], b, 1e-12, "B11");
    near(s.coupling[(1, 1)], -b, 1e-12, "B22");
    for (i, j) in [(0, 1), (0, 2), (1, 2), (2, 2)] {
        near(s.coupling[(i, j)], 0.0, 1e-12, "other B");
    }
    // Under tension along x the stiff bottom elongates less than the top: m = Bᵀ ε.
    assert!(b > 0.0);
}

#[test]
fn the_coupling_of_two_angle_plies_is_shear_only() {
    let s = E25.laminate(&[-30.0, 30.0], 1.0).stiffness(0.0);
    for (i, j) in [(0, 0), (1, 1), (0, 1), (2, 2)] {
        near(s.coupling[(i, j)], 0.0, 1e-12, "B");
    }
    let q16 = jones(&E25, 30.0)[(0, 2)];
    near(s.coupling[(0, 2)], -q16 / 4.0, 1e-12, "B16");
}

#[test]
fn a_quasi_isotropic_layup_is_isotropic_in_its_plane() {
    // The invariants of Tsai and Pagano: A = h (U1, U4, U5) whatever the number of directions.
    let q = orthotropic_plane_stress(25.0, 1.0, 0.25, 0.5);
    let (q11, q22, q12, q66) = (q[(0, 0)], q[(1, 1)], q[(0, 1)], q[(2, 2)]);
    let u1 = (3.0 * q11 + 3.0 * q22 + 2.0 * q12 + 4.0 * q66) / 8.0;
    let u4 = (q11 + q22 + 6.0 * q12 - 4.0 * q66) / 8.0;
    let u5 = 0.5 * (u1 - u4);
    let expected = Matrix3::new(u1, u4, 0.0, u4, u1, 0.0, 0.0, 0.0, u5);
    for angles in [&[0.0, 60.0, -60.0][..], &[0.0, 45.0, -45.0, 90.0], &[7.0, 43.0, 79.0, 115.0, 151.0]] {
        for turn in [0.0, 0.7] {
            let s = E25.laminate(angles, 1.0).stiffness(turn);
            same(&s.membrane, &expected, 25.0, "A");
        }
    }
}

#[test]
fn turning_the_laminate_turns_its_plies() {
    let turn = 0.6;
    let turned = arbitrary().stiffness(turn);
    let plies = arbitrary().plies().iter().map(|p| Ply { angle: p.angle + turn, ..p.clone() }).collect();
    let other = Laminate::new(plies).unwrap().stiffness(0.0);
    same(&turned.membrane, &other.membrane, 25.0, "A");
    same(&turned.coupling, &other.coupling, 25.0, "B");
    same(&turned.bending, &other.bending, 25.0, "D");
}

#[test]
fn the_energy_does_not_depend_on_the_frame() {
    let l = arbitrary();
    let (e, k) = (Vector3::new(0.3, -0.2, 0.7), Vector3::new(-0.5, 0.1, 0.4));
    let g = Vector2::new(0.2, -0.9);
    let energy = |s: &SectionStiffness, e: &Vector3<f64>, k: &Vector3<f64>, g: &Vector2<f64>| {
        e.dot(&(s.membrane * e))
            + 2.0 * e.dot(&(s.coupling * k))
            + k.dot(&(s.bending * k))
            + g.dot(&(s.shear * g))
    };
    let expected = energy(&l.stiffness(0.0), &e, &k, &g);
    for angle in [0.4, -1.3, 2.9] {
        // In a frame turned by `angle` the laminate's 0° direction is at −angle.
        let (t, r) = (strain_turn(angle), shear_turn(angle));
        let found = energy(&l.stiffness(-angle), &(t * e), &(t * k), &(r * g));
        near(found, expected, 1e-12 * expected, "energy");
    }
}

#[test]
fn an_offset_moves_the_reference_surface() {
    let o = 0.35;
    let (here, there) = (arbitrary().stiffness(0.2), arbitrary().with_offset(o).unwrap().stiffness(0.2));
    same(&there.membrane, &here.membrane, 25.0, "A");
    same(&there.coupling, &(here.coupling - here.membrane * o), 25.0, "B");
    same(&there.bending, &(here.bending - here.coupling * (2.0 * o) + here.membrane * (o * o)), 25.0, "D");
    assert_eq!(there.shear, here.shear);
    let (mass, h) = (arbitrary().thickness(), arbitrary().thickness());
    let moved = arbitrary().with_offset(o).unwrap().inertia();
    near(moved.mass, mass, 1e-12, "mass");
    near(moved.coupling, mass * o, 1e-12, "first moment");
    near(moved.rotary, h * h * h / 12.0 + mass * o * o, 1e-12, "rotary");
}

#[test]
fn inertia_weighs_the_heights() {
    // A heavy ply on top of a light one: the first moment is positive.
    let mut plies = vec![E25.ply(0.0, 1.0), E25.ply(0.0, 1.0)];
    plies[1].density = 3.0;
    let i = Laminate::new(plies).unwrap().inertia();
    assert_eq!(i, SectionInertia { mass: 4.0, coupling: 0.5 * (3.0 - 1.0), rotary: 4.0 / 3.0 });
    let one = E25.laminate(&[0.0, 90.0, 30.0], 0.3).inertia();
    let homogeneous = SectionInertia::homogeneous(1.0, 0.3);
    near(one.mass, homogeneous.mass, 1e-15, "mass");
    near(one.coupling, 0.0, 1e-15, "coupling");
    near(one.rotary, homogeneous.rotary, 1e-15, "rotary");
}

#[test]
fn rotation_of_a_stiffness_is_undone_by_the_opposite() {
    let q = jones(&E25, 17.0);
    same(&turned_plane_stress(&turned_plane_stress(&q, 0.8), -0.8), &q, 25.0, "Q");
}

#[test]
fn angles_are_those_of_the_projection() {
    let (x, y) = (Vector3::new(0.0, 1.0, 0.0), Vector3::new(0.0, 0.0, 1.0));
    let angle = angle_in_plane(&Vector3::new(5.0, 2.0, 2.0), &x, &y).unwrap();
    near(angle, std::f64::consts::FRAC_PI_4, 1e-15, "angle");
    assert_eq!(angle_in_plane(&Vector3::new(3.0, 0.0, 0.0), &x, &y), None);
}

#[test]
fn impossible_plies_are_refused() {
    assert_eq!(Laminate::new(vec![]), Err(LaminateError::Empty));
    let good = E25.ply(0.0, 1.0);
    let bad = [
        Ply { thickness: 0.0, ..good.clone() },
        Ply { angle: f64::NAN, ..good.clone() },
        Ply { plane_stress: orthotropic_plane_stress(1.0, 25.0, 0.25, 0.5), ..good.clone() },
        Ply { shear: Matrix2::new(1.0, 0.0, 0.0, 0.0), ..good.clone() },
        Ply { thickness_modulus: -1.0, ..good.clone() },
        Ply { density: -1.0, ..good.clone() },
    ];
    for b in bad {
        let e = Laminate::new(vec![good.clone(), b]).unwrap_err();
        assert!(e.to_string().starts_with("ply 2 from the bottom: its"), "{e}");
    }
    assert!(E25.laminate(&[0.0], 1.0).with_shear_correction([1.0, 0.0]).is_err());
    assert!(E25.laminate(&[0.0], 1.0).with_offset(f64::INFINITY).is_err());
}
