//! Recovery of the strains and stresses of plies.

use nalgebra::{Vector2, Vector3};

use super::super::laminate::{PlyPoint, PlyState};
use super::super::ply::{shear_turn, strain_turn};
use super::*;

fn strains() -> (Vector3<f64>, Vector3<f64>, Vector2<f64>) {
    (Vector3::new(0.3, -0.2, 0.7), Vector3::new(-0.5, 0.1, 0.4), Vector2::new(0.2, -0.9))
}

/// ∫ f dz by Simpson's rule, exact for stresses and their moments.
fn integral<T>(states: &[PlyState], f: impl Fn(usize, &PlyPoint) -> T) -> T
where
    T: std::ops::Add<Output = T> + std::ops::Mul<f64, Output = T> + std::iter::Sum,
{
    let ply = |(k, s): (usize, &PlyState)| {
        let t = s.top.height - s.bottom.height;
        f(k, &s.bottom) * (t / 6.0) + f(k, &s.middle) * (4.0 * t / 6.0) + f(k, &s.top) * (t / 6.0)
    };
    states.iter().enumerate().map(ply).sum()
}

#[test]
fn stresses_add_up_to_the_resultants() {
    let (e, k, g) = strains();
    for (turn, offset) in [(0.0, 0.0), (0.8, 0.3), (-2.0, -1.0)] {
        let l = arbitrary().with_offset(offset).unwrap();
        let s = l.stiffness(turn);
        let states = l.recover(turn, &e, &k, &g);
        let angle = |i: usize| l.plies()[i].angle + turn;
        let n = integral(&states, |i, p| strain_turn(angle(i)).transpose() * p.stress);
        let m = integral(&states, |i, p| strain_turn(angle(i)).transpose() * p.stress * -p.height);
        let q = integral(&states, |i, p| shear_turn(angle(i)).transpose() * p.shear_stress);
        assert!((n - (s.membrane * e + s.coupling * k)).norm() < 1e-11 * n.norm(), "n");
        assert!((m - (s.coupling.transpose() * e + s.bending * k)).norm() < 1e-11 * m.norm(), "m");
        assert!((q - s.shear * g).norm() < 1e-11 * q.norm(), "q");
    }
}

#[test]
fn transverse_shear_is_continuous_and_leaves_the_faces_free() {
    let (e, k, g) = strains();
    let l = arbitrary();
    let states = l.recover(0.4, &e, &k, &g);
    let scale = states[1].middle.shear_stress.norm();
    let at = |i: usize, p: &PlyPoint| shear_turn(l.plies()[i].angle).transpose() * p.shear_stress;
    assert!(states[0].bottom.shear_stress.norm() < 1e-12 * scale, "bottom");
    assert!(states[3].top.shear_stress.norm() < 1e-12 * scale, "top");
    for i in 0..3 {
        let jump = at(i, &states[i].top) - at(i + 1, &states[i + 1].bottom);
        assert!(jump.norm() < 1e-12 * scale, "between plies {i} and {}", i + 1);
    }
    for (state, ply) in states.iter().zip(l.plies()) {
        let p = &state.middle;
        assert!((ply.shear * p.shear_strain - p.shear_stress).norm() < 1e-12 * scale);
    }
}

#[test]
fn a_homogeneous_section_has_the_parabola() {
    // τ = 3/2 q/h in the middle, q = 5/6 h G γ.
    let l = E25.laminate(&[0.0], 0.2);
    let state = l.recover(0.0, &Vector3::zeros(), &Vector3::zeros(), &Vector2::new(0.3, 0.7))[0];
    near(state.middle.shear_stress[0], 1.25 * 0.5 * 0.3, 1e-12, "τ13");
    near(state.middle.shear_stress[1], 1.25 * 0.2 * 0.7, 1e-12, "τ23");
}

#[test]
fn bending_presses_the_top_where_the_curvature_is_positive() {
    let l = E25.laminate(&[0.0, 90.0], 2.0);
    let k = Vector3::new(1.0, 0.0, 0.0);
    let states = l.recover(0.0, &Vector3::zeros(), &k, &Vector2::zeros());
    near(states[0].bottom.strain[0], 1.0, 1e-12, "ε11 at the bottom");
    near(states[1].top.strain[1], -1.0, 1e-12, "ε22 of the 90° ply at the top");
    near(states[1].bottom.strain[1], 0.0, 1e-12, "in the middle");
    let q22 = orthotropic_plane_stress(25.0, 1.0, 0.25, 0.5)[(1, 1)];
    near(states[1].top.stress[1], -q22, 1e-12, "σ22 at the top");
}

#[test]
fn plies_do_not_depend_on_the_frame() {
    let (e, k, g) = strains();
    let l = arbitrary();
    let expected = l.recover(0.0, &e, &k, &g);
    for angle in [0.5, -2.2] {
        let (t, r) = (strain_turn(angle), shear_turn(angle));
        let found = l.recover(-angle, &(t * e), &(t * k), &(r * g));
        for (f, x) in found.iter().zip(&expected) {
            for (f, x) in [(f.bottom, x.bottom), (f.middle, x.middle), (f.top, x.top)] {
                assert!((f.stress - x.stress).norm() < 1e-11 * 25.0);
                assert!((f.strain - x.strain).norm() < 1e-12);
                assert!((f.shear_stress - x.shear_stress).norm() < 1e-12);
            }
        }
    }
}
