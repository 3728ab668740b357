//! Rates of convergence of the elements to exact solutions of shell theory.
//!
//! A square plate on hard simple supports under a uniform load, Reissner–Mindlin theory (Navier's series): with
//! `k² = (mπ/a)² + (nπ/a)²` and `q_mn = 16 q/(π² m n)` for odd m, n,
//!
//! ```text
//! w = Σ q_mn/(D k⁴) (1 + D k²/S) sin(mπx/a) sin(nπy/a)      D = E h³/12, S = κ G h, ν = 0
//! U = ½ ∫ q w dA = Σ ½ (16 q/π²)² a²/(4 m² n²) (1 + D k²/S)/(D k⁴)
//! ```
//!
//! Without Poisson's effect the elements with three-dimensional stresses have the same limit, with κ = 1. S. P. Timoshenko,
//! S. Woinowsky-Krieger, *Theory of Plates and Shells*, 2nd ed. 1959, Sect. 30; for shear C. M. Wang, J. N. Reddy, K. H.
//! Lee, *Shear Deformable Beams and Plates*, 2000, Sect. 6.2.

use std::f64::consts::PI;

use tegula::Vec3;
use tegula::model::{
    Analysis, Axis, Condition, ElementKind, FixComponents, Isotropic, Load, Model, StaticAnalysis,
};

use crate::common::{plate, solve, vector_load};

const SIDE: f64 = 1.0;
const THICKNESS: f64 = 0.05;
const YOUNG: f64 = 1e7;
const LOAD: f64 = 1.0;

/// Deflection of the centre and strain energy of the whole plate.
fn exact(shear_factor: f64) -> (f64, f64) {
    let bending = YOUNG * THICKNESS.powi(3) / 12.0;
    let shear = shear_factor * 0.5 * YOUNG * THICKNESS;
    let (mut centre, mut energy) = (0.0, 0.0);
    // Smallest terms first.
    for m in (1..400).rev().step_by(2) {
        for n in (1..400).rev().step_by(2) {
            let (p, q) = (f64::from(m), f64::from(n));
            let k2 = (PI / SIDE).powi(2) * (p * p + q * q);
            let response = (1.0 + bending * k2 / shear) / (bending * k2 * k2);
            let load = 16.0 * LOAD / (PI * PI * p * q);
            let sign = if ((m - 1) / 2 + (n - 1) / 2) % 2 == 0 { 1.0 } else { -1.0 };
            centre += sign * load * response;
            energy += 0.125 * load * load * response * SIDE * SIDE;
        }
    }
    (centre, energy)
}

fn supported_plate(element: ElementKind, n: u32, distortion: f64) -> Model {
    let analysis = Analysis::Static(StaticAnalysis { linear: true, ..StaticAnalysis::default() });
    let mesh = plate([SIDE, SIDE], [n, n], distortion);
    let mut model = Model::new(mesh, analysis, Isotropic::new(YOUNG, 0.0, 0.0), THICKNESS);
    model.sections[0].element = element;
    let hard = |on: &str, along: Axis| {
        Condition::Fix(FixComponents { on: on.into(), position: vec![Axis::Z], director: vec![along] })
    };
    model.conditions = vec![
        hard("u_min", Axis::Y),
        hard("u_max", Axis::Y),
        hard("v_min", Axis::X),
        hard("v_max", Axis::X),
        Condition::Fix(FixComponents {
            on: "u_min_v_min".into(),
            position: vec![Axis::X, Axis::Y],
            director: vec![],
        }),
        Condition::Fix(FixComponents { on: "u_max_v_min".into(), position: vec![Axis::Y], director: vec![] }),
    ];
    model.loads = vec![Load::Traction(vector_load("all", [0.0, 0.0, LOAD]))];
    model
}

/// Relative errors of deflection and energy on a mesh.
fn errors(element: ElementKind, n: u32, distortion: f64, (centre, energy): (f64, f64)) -> [f64; 2] {
    let (mesh, system, outcome) = solve(&supported_plate(element, n, distortion));
    let middle = mesh.nearest_node(Vec3::new(0.5 * SIDE, 0.5 * SIDE, 0.0)).unwrap();
    let w = outcome.state.u[system.coordinates.position_of[middle as usize] as usize][2];
    [(w / centre - 1.0).abs(), (outcome.balance.strain / energy - 1.0).abs()]
}

#[test]
fn deflection_and_energy_of_plates_converge_with_the_square_of_the_element_size() {
    for (element, shear_factor) in [
        (ElementKind::Ems, 5.0 / 6.0),
        (ElementKind::Mitc4, 5.0 / 6.0),
        (ElementKind::Cm, 1.0),
        (ElementKind::SolidShell, 1.0),
    ] {
        let exact = exact(shear_factor);
        let meshes = [8, 16, 32];
        let found = meshes.map(|n| errors(element, n, 0.0, exact));
        for quantity in 0..2 {
            for pair in found.windows(2) {
                let rate = (pair[0][quantity] / pair[1][quantity]).log2();
                assert!((1.9..2.15).contains(&rate), "{element:?}, quantity {quantity}: {rate}, {found:?}");
            }
        }
        // On distorted meshes the node nearest to the centre is not there; energy has no place.
        let [coarse, fine] = [8, 32].map(|n| errors(element, n, 0.2, exact)[1]);
        let rate = 0.5 * (coarse / fine).log2();
        assert!(rate > 1.7 && fine < 5e-3, "{element:?}, distorted: {rate}, {coarse} {fine}");
    }
}
