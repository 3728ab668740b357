//! Explicit steps with rigid bodies and joints: closed forms, conservation laws, implicit steps, and what is refused.

use std::f64::consts::FRAC_PI_2;

use crate::common::Notes;
use crate::multibody::{body, gravity, machine, pose, revolute, run};
use tegula::analysis::{Silent, State};
use tegula::model::*;
use tegula::norm::max_norm;
use tegula::result::joint_reaction;
use tegula::{System, Vec3, compile, mesh};

const Y: [f64; 3] = [0.0, 1.0, 0.0];
const GRAVITY: f64 = 9.81;

/// A machine in explicit steps of constant length, or of the length that is found.
fn explicit(end: f64, step: Option<f64>, bodies: Vec<RigidBody>, joints: Vec<Joint>) -> Model {
    let model = machine(end, 1.0, bodies, joints);
    let scheme = Scheme::Explicit(ExplicitScheme::default());
    let analysis = TransientAnalysis { scheme, time_step: step, ..TransientAnalysis::new(end) };
    Model { analysis: Analysis::Transient(analysis), ..model }
}

/// Jacobi's functions sn, cn and dn of the modulus k, by the arithmetic–geometric mean (Abramowitz, Stegun 16.4).
fn jacobi(u: f64, k: f64) -> [f64; 3] {
    let (mut a, mut b, mut c) = (vec![1.0_f64], (1.0 - k * k).sqrt(), vec![k]);
    while c[c.len() - 1].abs() > 1e-16 {
        let last = a[a.len() - 1];
        c.push(0.5 * (last - b));
        a.push(0.5 * (last + b));
        b = (last * b).sqrt();
    }
    let n = a.len() - 1;
    let mut phi = a[n] * u * 2.0_f64.powi(n as i32);
    for i in (1..=n).rev() {
        phi = 0.5 * (phi + (c[i] / a[i] * phi.sin()).asin());
    }
    let [sn, cn] = [phi.sin(), phi.cos()];
    [sn, cn, (1.0 - k * k * sn * sn).sqrt()]
}

#[test]
fn jacobi_functions_have_tabulated_values() {
    // Abramowitz, Stegun, example 16.1: sn(0.2 | m = 0.81), and limits.
    let [sn, cn, dn] = jacobi(0.20, 0.9);
    assert!((sn - 0.19762).abs() < 1e-5 && (sn * sn + cn * cn - 1.0).abs() < 1e-15, "{sn} {cn} {dn}");
}

const MASS: f64 = 2.0;
const ARM: f64 = 0.4;
const INERTIA: [f64; 3] = [0.03, 0.11, 0.09];

/// A body on a hinge at the origin, released from rest in the horizontal.
fn pendulum(end: f64, step: Option<f64>) -> Model {
    let bob = body("bob", [ARM, 0.0, 0.0], MASS, Some(INERTIA));
    let model = explicit(end, step, vec![bob], vec![revolute("hinge", "ground", "bob", [0.0; 3], Y)]);
    Model { loads: gravity([0.0, 0.0, -GRAVITY]), ..model }
}

/// Position and velocity of the mass centre, and force of the hinge on the body, at a time: θ is the angle from the vertical,
/// `sin θ/2 = k cd(Ω t, k)` (L. Landau, E. Lifshitz, *Mechanics*, § 11).
fn exact(t: f64) -> [Vec3; 3] {
    let omega = (MASS * GRAVITY * ARM / (INERTIA[1] + MASS * ARM * ARM)).sqrt();
    let k = (0.5 * FRAC_PI_2).sin();
    let [sn, cn, dn] = jacobi(omega * t, k);
    let half = (k * cn / dn).asin();
    let theta = 2.0 * half;
    // d cd/du = −(1 − k²) sn/dn².
    let rate = -2.0 * k * omega * (1.0 - k * k) * sn / (dn * dn) / half.cos();
    let second = -omega * omega * theta.sin();
    let radial = Vec3::new(theta.sin(), 0.0, -theta.cos());
    let tangent = Vec3::new(theta.cos(), 0.0, theta.sin());
    let acceleration = (tangent * second - radial * (rate * rate)) * ARM;
    [radial * ARM, tangent * (ARM * rate), (acceleration + Vec3::z() * GRAVITY) * MASS]
}

/// Positions, velocities and multipliers of a pendulum are of second order, and the joint stays closed to round-off.
#[test]
fn a_pendulum_is_of_second_order_in_positions_velocities_and_reactions() {
    let end = 1.7;
    let errors = |steps: u32| {
        let (system, state) = run(&pendulum(end, Some(end / f64::from(steps))), &mut Silent);
        let (x, axes) = pose(&system, &state, 0);
        let v = Vec3::from(state.v[system.coordinates.bodies[0].centre as usize]);
        let (reaction, _) = joint_reaction(&system, &state, &system.joints[0]);
        let [place, velocity, force] = exact(end);
        let open = (x - axes * Vec3::new(ARM, 0.0, 0.0)).norm();
        assert!(open < 1e-14, "{open}");
        [(x - place).norm(), (v - velocity).norm(), (reaction - force).norm() / (MASS * GRAVITY)]
    };
    let [coarse, middle, fine] = [400, 800, 1600].map(errors);
    println!("{coarse:?} {middle:?} {fine:?}");
    for i in 0..3 {
        let ratios = [coarse[i] / middle[i], middle[i] / fine[i]];
        assert!(ratios.iter().all(|r| (3.8..4.2).contains(r)), "{i}: {coarse:?} {middle:?} {fine:?}");
    }
    assert!(max_norm(fine) < 1e-4, "{fine:?}");
}
