//! Simply supported square cross-ply plates by Navier's series in first-order shear deformation theory.
//!
//! The numbers are those of the tables for cross-ply plates in Reddy, Mechanics of Laminated Composite
//! Plates and Shells, with E1/E2 = 25, G12 = G13 = E2/2, G23 = E2/5, ν12 = 1/4, a/h = 10 and the factor 5/6.

use nalgebra::{SMatrix, SVector};

use super::super::laminate::Laminate;
use super::*;

const SIDE: f64 = 10.0;

type Matrix5 = SMatrix<f64, 5, 5>;

/// Stiffness of the amplitudes (u, v, w, θx, θy) of the harmonic with wave numbers α, β, per mean square of
/// the harmonic: u = U cos αx sin βy, v = V sin cos, w = W sin sin, rotations as u and v, `u + z θ`.
fn stiffness(l: &Laminate, alpha: f64, beta: f64) -> Matrix5 {
    let s = l.stiffness(0.0);
    let mut c = SMatrix::<f64, 8, 8>::zeros();
    c.fixed_view_mut::<3, 3>(0, 0).copy_from(&s.membrane);
    c.fixed_view_mut::<3, 3>(0, 3).copy_from(&s.coupling);
    c.fixed_view_mut::<3, 3>(3, 0).copy_from(&s.coupling.transpose());
    c.fixed_view_mut::<3, 3>(3, 3).copy_from(&s.bending);
    c.fixed_view_mut::<2, 2>(6, 6).copy_from(&s.shear);
    let mut b = SMatrix::<f64, 8, 5>::zeros();
    // Rows: ε_xx, ε_yy, γ_xy, then κ = −(these strains of θ), then γ_xz, γ_yz.
    for (row, column, sign) in [(0, 0, 1.0), (3, 3, -1.0)] {
        b[(row, column)] = -alpha * sign;
        b[(row + 1, column + 1)] = -beta * sign;
        b[(row + 2, column)] = beta * sign;
        b[(row + 2, column + 1)] = alpha * sign;
    }
    b[(6, 2)] = alpha;
    b[(6, 3)] = 1.0;
    b[(7, 2)] = beta;
    b[(7, 4)] = 1.0;
    b.transpose() * c * b
}

fn deflection(l: &Laminate, m: usize, n: usize) -> f64 {
    let wave = std::f64::consts::PI / SIDE;
    let mut load = SVector::<f64, 5>::zeros();
    load[2] = 1.0;
    stiffness(l, m as f64 * wave, n as f64 * wave).cholesky().unwrap().solve(&load)[2]
}

/// Deflection at the centre under a uniform load of 1.
fn uniform(l: &Laminate) -> f64 {
    let sign = |m: usize| if m % 4 == 1 { 1.0 } else { -1.0 };
    let mut sum = 0.0;
    for m in (1..60).step_by(2) {
        for n in (1..60).step_by(2) {
            let q = 16.0 / (std::f64::consts::PI.powi(2) * (m * n) as f64);
            sum += q * sign(m) * sign(n) * deflection(l, m, n);
        }
    }
    sum
}

/// Lowest frequency of the harmonic (1, 1), rotary inertia included.
fn frequency(l: &Laminate) -> f64 {
    let wave = std::f64::consts::PI / SIDE;
    let i = l.inertia();
    let mut mass = Matrix5::zeros();
    for a in 0..3 {
        mass[(a, a)] = i.mass;
    }
    for a in 0..2 {
        mass[(a + 3, a + 3)] = i.rotary;
        mass[(a, a + 3)] = i.coupling;
        mass[(a + 3, a)] = i.coupling;
    }
    let root = mass.cholesky().unwrap().l().try_inverse().unwrap();
    let eigen = (root * stiffness(l, wave, wave) * root.transpose()).symmetric_eigenvalues();
    eigen.min().sqrt()
}

#[test]
fn deflections_and_frequencies_of_the_literature() {
    let stacks: [(&[f64], f64, f64, f64); 3] = [
        (&[0.0, 90.0], 1.2373, 1.9469, 8.9001),
        (&[0.0, 90.0, 90.0, 0.0], 0.6627, 1.0250, 12.2272),
        (&[0.0, 90.0, 0.0, 90.0, 0.0, 90.0, 0.0, 90.0], 0.6216, 0.9661, 12.6276),
    ];
    // h = 1, E2 = 1, ρ = 1: w̄ = 100 w E2 h³/(q a⁴), ω̄ = ω a²/h √(ρ/E2).
    let scale = 100.0 / SIDE.powi(4);
    for (angles, sine, load, omega) in stacks {
        let l = E25.laminate(angles, 1.0).with_shear_correction([5.0 / 6.0; 2]).unwrap();
        near(deflection(&l, 1, 1) * scale, sine, 0.5e-4, "sinusoidal load");
        near(uniform(&l) * scale, load, 0.5e-4, "uniform load");
        near(frequency(&l) * SIDE * SIDE, omega, 0.5e-4, "frequency");
    }
}

#[test]
fn neither_the_turn_nor_the_reference_surface_matters() {
    // The reference surface at the bottom face changes only the amplitudes of u and v.
    let l = E25.laminate(&[0.0, 90.0, 0.0, 0.0], 1.0);
    let moved = l.clone().with_offset(0.5).unwrap();
    near(deflection(&moved, 1, 3) / deflection(&l, 1, 3), 1.0, 1e-10, "deflection");
    near(frequency(&moved) / frequency(&l), 1.0, 1e-10, "frequency");
}
