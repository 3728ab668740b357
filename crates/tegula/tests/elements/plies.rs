//! Stresses and failure of plies against laminate theory and against each other.

use crate::common;
use crate::common::{plate, vector_load};
use nalgebra::Vector3;
use tegula::model::*;
use tegula::result::{recover, recover_plies};
use tegula::section::failure::Strengths;
use tegula::section::ply::{orthotropic_plane_stress, strain_turn};

fn carbon() -> Material {
    Material::Orthotropic(Orthotropic {
        young: [140e3, 10e3, 10e3],
        poisson: [0.3, 0.3, 0.4],
        shear: [5e3, 5e3, 3.5e3],
        density: 1.6e-9,
        expansion: [0.0; 3],
        strength: Some(Strengths::new(1500.0, 1200.0, 50.0, 250.0, 70.0)),
    })
}

/// A plate of a layup with its fibres' 0° along `direction`, pulled along x.
fn pulled(element: ElementKind, stacking: &str, direction: [f64; 3]) -> Model {
    let mut m = common::model(plate([1.0, 1.0], [4, 4], 0.25), 1.0, 0.1);
    m.materials.insert("carbon".into(), carbon());
    m.sections[0] = Section {
        element,
        layup: Some(Layup {
            stacking: Some(stacking.into()),
            material: Some("carbon".into()),
            ply_thickness: Some(0.01),
            direction,
            ..Layup::default()
        }),
        ..Section::new("", 0.0)
    };
    let plane = |set: &str, normal| Condition::Symmetry(SymmetryPlane { on: set.into(), normal });
    let fix = FixComponents { on: "all".into(), position: vec![Axis::Z], director: vec![] };
    m.conditions =
        vec![plane("u_min", [1.0, 0.0, 0.0]), plane("v_min", [0.0, 1.0, 0.0]), Condition::Fix(fix)];
    m.loads = vec![Load::Edge(vector_load("u_max", [4.0, 0.0, 0.0]))];
    m.analysis = Analysis::Static(StaticAnalysis { linear: true, ..Default::default() });
    m
}

#[test]
fn plies_of_a_pulled_laminate_follow_laminate_theory() {
    let (e1, e2, nu, g) = (140e3, 10e3, 0.3, 5e3);
    let q = orthotropic_plane_stress(e1, e2, nu, g);
    for (stacking, angles, rotated) in [
        ("[0/90]s", [0.0, 90.0, 90.0, 0.0], 0.0_f64),
        ("[±45]s", [45.0, -45.0, -45.0, 45.0], 0.0),
        // The same plates described from another direction.
        ("[-30/60]s", [0.0, 90.0, 90.0, 0.0], 30.0),
    ] {
        // Balanced and symmetric: ε = A⁻¹ n.
        let mut a = nalgebra::Matrix3::zeros();
        for angle in angles {
            let t = strain_turn(f64::to_radians(angle));
            a += t.transpose() * q * t * 0.01;
        }
        let strain = a.lu().solve(&Vector3::new(4.0, 0.0, 0.0)).unwrap();
        for element in [ElementKind::Ems, ElementKind::Mitc4, ElementKind::Cm] {
            let direction = [rotated.to_radians().cos(), rotated.to_radians().sin(), 0.0];
            let (_, system, outcome) = common::solve(&pulled(element, stacking, direction));
            for of_shell in recover_plies(&system, &outcome.state) {
                assert_eq!(of_shell.len(), 4);
                for (ply, angle) in of_shell.iter().zip(angles) {
                    let exact = q * strain_turn(f64::to_radians(angle)) * strain;
                    for at in &ply.stress {
                        let error = (Vector3::from(at.plane) - exact).norm();
                        // Plies of three-dimensional stress feel their unlike contraction across the thickness.
                        let tolerance = if element == ElementKind::Cm { 0.02 } else { 1e-9 };
                        assert!(
                            error < tolerance * exact.norm(),
                            "{element:?} {stacking}: {:?} for {exact:?}",
                            at.plane
                        );
                    }
                    let failure = ply.failure.unwrap();
                    let Some(strength) = carbon().strength() else { unreachable!() };
                    if element != ElementKind::Cm {
                        assert!((failure.tsai_wu - strength.tsai_wu(&exact)).abs() < 1e-8);
                    }
                }
            }
        }
    }
}

/// Moments and shear forces are carried by the plies: their stresses integrate to the resultants.
#[test]
fn ply_stresses_integrate_to_the_resultants() {
    for element in [ElementKind::Ems, ElementKind::Mitc4] {
        let mut m = pulled(element, "[0/90/±45]2", [1.0, 0.0, 0.0]);
        m.conditions = vec![Condition::Clamp(common::on("u_min"))];
        m.loads = vec![Load::Edge(vector_load("u_max", [0.0, 0.0, 0.05]))];
        let (_, system, outcome) = common::solve(&m);
        let resultants = recover(&system, &outcome.state);
        for (r, of_shell) in resultants.iter().zip(recover_plies(&system, &outcome.state)) {
            // Traces do not depend on axes. Simpson's rule is exact for stresses linear in z times z.
            let (mut n, mut moment) = (0.0, 0.0);
            for ply in &of_shell {
                let h = ply.stress[2].height - ply.stress[0].height;
                for (at, w) in ply.stress.iter().zip([1.0, 4.0, 1.0]) {
                    n += h / 6.0 * w * (at.plane[0] + at.plane[1]);
                    moment -= h / 6.0 * w * at.height * (at.plane[0] + at.plane[1]);
                }
            }
            let size = r.bending[0].abs() + r.bending[1].abs() + 1e-6;
            assert!((moment - r.bending[0] - r.bending[1]).abs() < 1e-9 * size, "{element:?}");
            assert!((n - r.membrane[0] - r.membrane[1]).abs() < 1e-6 * size);
        }
    }
}
