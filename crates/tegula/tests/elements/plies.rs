//! Stresses and failure of plies against laminate theory and against each other.

use crate::common;
use crate::common::{plate, vector_load};
use nalgebra::Vector3;
use tegula::analysis::{Silent, statics};
use tegula::compile::build;
use tegula::mesh::generators::generate;
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

/// A square sheet of two isotropic plies on supports that leave every deformation free.
fn two_plies(element: ElementKind, plies: [Isotropic; 2]) -> Model {
    let mut m = common::model(plate([1.0, 1.0], [4, 4], 0.0), 1.0, 0.1);
    let [lower, upper] = plies;
    m.materials.insert("lower".into(), Material::Isotropic(lower));
    m.materials.insert("upper".into(), Material::Isotropic(upper));
    let layer =
        |material: &str| LayupPly { material: Some(material.into()), angle: 0.0, thickness: Some(0.01) };
    m.sections[0] = Section {
        element,
        layup: Some(Layup { plies: vec![layer("lower"), layer("upper")], ..Layup::default() }),
        ..Section::new("", 0.0)
    };
    let fix = |on: &str, position: Vec<Axis>| {
        Condition::Fix(FixComponents { on: on.into(), position, director: vec![] })
    };
    m.conditions = vec![
        fix("u_min_v_min", vec![Axis::X, Axis::Y, Axis::Z]),
        fix("u_max_v_min", vec![Axis::Y, Axis::Z]),
        fix("u_min_v_max", vec![Axis::Z]),
    ];
    m.analysis = Analysis::Static(StaticAnalysis { linear: true, ..Default::default() });
    m
}

fn expanding(young: f64, poisson: f64, expansion: f64) -> Isotropic {
    Isotropic { expansion, ..Isotropic::new(young, poisson, 1.0) }
}

/// Two heated plies of one stiffness bend freely to a sphere. With the misfit strain ±a, biaxial modulus `Ē = E/(1 − ν)` and
/// the thickness h the curvature is 3a/h, the stress ∓Ē a (1 − 3|z|/h) in both directions, and the energy of these residual stresses
/// ¼ Ē a² h per area.
#[test]
fn heated_plies_keep_their_residual_stresses_and_energy() {
    let (young, poisson, heat, misfit) = (2e5, 0.3, 10.0, 1e-5);
    let (a, h) = (heat * misfit, 0.02);
    let modulus = young / (1.0 - poisson);
    for element in [ElementKind::Ems, ElementKind::Mitc4, ElementKind::Cm, ElementKind::SolidShell] {
        let of = |sign: f64| expanding(young, poisson, 2e-5 + sign * misfit);
        let mut m = two_plies(element, [of(1.0), of(-1.0)]);
        m.prescribed_strains = vec![PrescribedStrain::Thermal(ThermalStrain {
            distribution: None,
            on: "all".into(),
            temperature: heat,
            gradient: 0.0,
            amplitude: None,
        })];
        let (_, system) = common::compile(&m);
        let outcome = statics::run(&system, &common::static_options(&m), None, &mut Silent).unwrap();
        let energy = 0.25 * modulus * a * a * h;
        let found = outcome.balance.strain;
        assert!((found / energy - 1.0).abs() < 1e-3, "{element:?}: {found:e} for {energy:e}");
        let density = recover(&system, &outcome.state)[5].energy_density;
        assert!((density / energy - 1.0).abs() < 1e-3, "{element:?}: {density:e} for {energy:e}");
        for plies in recover_plies(&system, &outcome.state) {
            for (ply, sign) in plies.iter().zip([-1.0, 1.0]) {
                for at in &ply.stress {
                    let exact = sign * modulus * a * (1.0 - 3.0 * at.height.abs() / h);
                    for c in 0..2 {
                        let off = (at.plane[c] - exact).abs();
                        assert!(off < 2e-3 * modulus * a, "{element:?}: {:?} for {exact}", at.plane);
                    }
                }
            }
        }
    }
}

/// Nonlinear layers of different materials share one thickness strain in elements with three-dimensional stresses, which is
/// warned of.
#[test]
fn unlike_nonlinear_layers_of_solid_elements_are_warned_of() {
    for (element, expected) in [(ElementKind::Ems, 0), (ElementKind::Cm, 1), (ElementKind::SolidShell, 1)] {
        let mut m = two_plies(element, [expanding(2e5, 0.3, 0.0), expanding(2e5, 0.2, 0.0)]);
        m.materials.insert(
            "upper".into(),
            Material::Plastic(Plastic {
                young: 2e5,
                poisson: 0.3,
                yield_stress: 1e3,
                hardening: 1e3,
                saturation: None,
                saturation_rate: 0.0,
                kinematic: 0.0,
                density: 1.0,
                expansion: 0.0,
            }),
        );
        m.loads = vec![Load::Edge(vector_load("u_max", [4.0, 0.0, 0.0]))];
        m.analysis = Analysis::Static(StaticAnalysis::default());
        let (mesh, system) = common::compile(&m);
        let found = tegula::compile::warnings(&m, &mesh, &system);
        assert_eq!(found.len(), expected, "{element:?}: {found:?}");
        assert!(found.iter().all(|w| w.place.key == "sections[0].element"), "{found:?}");
    }
}

/// A soft ply of another contraction between free faces has the plane stress of its own law: with the membrane strains of
/// laminate theory, in elements with three-dimensional stresses as in those with resultants.
#[test]
fn plies_of_unlike_contraction_do_not_hold_each_other() {
    let (stiff, soft) = (expanding(2e5, 0.3, 0.0), expanding(2e3, 0.45, 0.0));
    for element in [ElementKind::Ems, ElementKind::Mitc4, ElementKind::Cm, ElementKind::SolidShell] {
        let mut m = two_plies(element, [stiff.clone(), soft.clone()]);
        let ply = |material: &str, thickness| LayupPly {
            material: Some(material.into()),
            angle: 0.0,
            thickness: Some(thickness),
        };
        let plies = vec![ply("lower", 0.005), ply("upper", 0.01), ply("lower", 0.005)];
        m.sections[0].layup = Some(Layup { plies, ..Layup::default() });
        m.conditions.push(Condition::Fix(FixComponents {
            on: "u_min".into(),
            position: vec![Axis::X],
            director: vec![],
        }));
        m.loads = vec![Load::Edge(vector_load("u_max", [4.0, 0.0, 0.0]))];
        let (_, system) = common::compile(&m);
        let outcome = statics::run(&system, &common::static_options(&m), None, &mut Silent).unwrap();
        let plane = |e: f64, nu: f64| nalgebra::Matrix2::new(1.0, nu, nu, 1.0) * (e / (1.0 - nu * nu));
        let section = plane(2e5, 0.3) * 0.01 + plane(2e3, 0.45) * 0.01;
        let strain = section.try_inverse().unwrap() * nalgebra::Vector2::new(4.0, 0.0);
        let exact = plane(2e3, 0.45) * strain;
        for plies in recover_plies(&system, &outcome.state) {
            let core = plies[1].stress[1].plane;
            let off = (core[0] - exact[0]).hypot(core[1] - exact[1]);
            assert!(off < 2e-3 * exact.norm(), "{element:?}: {core:?} for {exact:?}");
        }
    }
}

/// Strengths of a material may depend on the direction where its stiffness does not: axes count from the direction of the layup, however the mesh lies.
#[test]
fn plies_of_isotropic_materials_have_the_axes_of_the_layup() {
    let strength = Strengths::new(100.0, 100.0, 20.0, 20.0, 15.0);
    let sheet = Material::Isotropic(Isotropic {
        young: 1000.0,
        poisson: 0.3,
        density: 1.0,
        expansion: 0.0,
        strength: Some(strength),
    });
    for element in [ElementKind::Ems, ElementKind::Mitc4, ElementKind::Cm, ElementKind::SolidShell] {
        // The pull of 10 along x, in the axes of plies with their 0° along x, y and 30° from x.
        for (direction, sigma) in [
            ([1.0, 0.0, 0.0], [10.0, 0.0, 0.0]),
            ([0.0, 1.0, 0.0], [0.0, 10.0, 0.0]),
            ([0.75_f64.sqrt(), 0.5, 0.0], [7.5, 2.5, -5.0 * 0.75_f64.sqrt()]),
        ] {
            let mut m = pulled(element, "[0]", direction);
            m.materials.insert("carbon".into(), sheet.clone());
            m.loads = vec![Load::Edge(vector_load("u_max", [0.1, 0.0, 0.0]))];
            let (_, system, outcome) = common::solve(&m);
            for plies in recover_plies(&system, &outcome.state) {
                let exact = Vector3::from(sigma);
                let failure = plies[0].failure.unwrap();
                for at in &plies[0].stress {
                    let error = (Vector3::from(at.plane) - exact).norm();
                    assert!(error < 1e-8, "{element:?} {direction:?}: {:?} for {sigma:?}", at.plane);
                }
                let reserve = strength.tsai_wu_reserve(&exact);
                assert!((failure.reserve / reserve - 1.0).abs() < 1e-8, "{} for {reserve}", failure.reserve);
            }
        }
    }
    // A direction across the sheet is an error where strengths depend on it.
    let mut m = pulled(ElementKind::Ems, "[0]", [0.0, 0.0, 1.0]);
    m.materials.insert("carbon".into(), sheet);
    let mesh = generate(&m.mesh).unwrap();
    let refused = build(&m, &mesh).err().unwrap().to_string();
    assert!(refused.contains("normal to the surface"), "{refused}");
}

/// Free heated layers of different expansion: σ = E/(1 − ν) (ε̄ − α ΔT) in both directions, which is their von Mises stress.
#[test]
fn von_mises_stress_of_heated_layers_is_that_of_plane_stress() {
    let layer = |expansion: f64| {
        Material::Isotropic(Isotropic { young: 1e5, poisson: 0.3, density: 1.0, expansion, strength: None })
    };
    let hottest = 1e5 / 0.7 * (5e-3 / 3.0 - 3e-3_f64).abs();
    for element in [ElementKind::Ems, ElementKind::Mitc4, ElementKind::Cm, ElementKind::SolidShell] {
        let mut m = pulled(element, "[0]", [1.0, 0.0, 0.0]);
        m.materials.insert("cold".into(), layer(1e-5));
        m.materials.insert("hot".into(), layer(3e-5));
        let ply =
            |material: &str| LayupPly { material: Some(material.into()), thickness: Some(0.1), angle: 0.0 };
        m.sections[0].layup =
            Some(Layup { plies: vec![ply("cold"), ply("hot"), ply("cold")], ..Layup::default() });
        m.loads.clear();
        m.prescribed_strains = vec![PrescribedStrain::Thermal(ThermalStrain {
            distribution: None,
            on: "all".into(),
            temperature: 100.0,
            gradient: 0.0,
            amplitude: None,
        })];
        let (_, system, outcome) = common::solve(&m);
        for r in recover(&system, &outcome.state) {
            assert!((r.von_mises / hottest - 1.0).abs() < 1e-6, "{element:?}: {} for {hottest}", r.von_mises);
        }
    }
}

/// Shear correction factors count in the axes of the layup: a cantilever along x that is soft in shear along the 0° direction only. Deflection of
/// Timoshenko's beam, P (L³/3EI + L/kGA).
#[test]
fn shear_correction_factors_have_the_axes_of_the_layup() {
    let (length, h, young, force) = (4.0_f64, 0.1, 1e3, 1e-3);
    let sheet = Material::Isotropic(Isotropic::new(young, 0.0, 1.0));
    let (shear, bending) = (0.5 * young * h, young * h.powi(3) / 12.0);
    for element in [ElementKind::Ems, ElementKind::Mitc4, ElementKind::Cm, ElementKind::SolidShell] {
        for (direction, factor) in [([1.0, 0.0, 0.0], 1e-3), ([0.0, 1.0, 0.0], 1.0)] {
            let mut m = pulled(element, "[0]", direction);
            m.mesh = plate([length, 1.0], [16, 2], 0.0);
            m.materials.insert("carbon".into(), sheet.clone());
            m.sections[0].layup.as_mut().unwrap().ply_thickness = Some(h);
            m.sections[0].shear_correction = Some([1e-3, 1.0]);
            m.conditions = vec![Condition::Clamp(common::on("u_min"))];
            m.loads = vec![Load::Edge(vector_load("u_max", [0.0, 0.0, force]))];
            let (mesh, system, outcome) = common::solve(&m);
            let exact = force * (length.powi(3) / (3.0 * bending) + length / (factor * shear));
            let found = common::displacement(&mesh, &system, &outcome.state.u, "u_max_v_min").z;
            assert!((found / exact - 1.0).abs() < 2e-3, "{element:?} {direction:?}: {found} for {exact}");
        }
    }
}

/// A sheet that lies on its reference surface, pulled in it without bending moment, bends about its middle: σ = N/h (1 ± 3) at its faces.
#[test]
fn stresses_of_a_sheet_beside_its_reference_surface_are_those_of_its_faces() {
    let (h, force) = (0.1, 1e-6);
    let sheet = Material::Isotropic(Isotropic::new(1e3, 0.0, 1.0));
    for element in [ElementKind::Ems, ElementKind::Mitc4] {
        for side in [-1.0, 1.0] {
            let mut m = pulled(element, "[0]", [1.0, 0.0, 0.0]);
            m.mesh = plate([1.0, 1.0], [4, 4], 0.0);
            m.materials.insert("carbon".into(), sheet.clone());
            let layup = m.sections[0].layup.as_mut().unwrap();
            (layup.ply_thickness, layup.offset) = (Some(h), 0.5 * side * h);
            m.conditions = vec![Condition::Clamp(common::on("u_min"))];
            m.loads = vec![Load::Edge(vector_load("u_max", [force, 0.0, 0.0]))];
            let (_, system, outcome) = common::solve(&m);
            let expected = |far: bool| force / h * if far { -2.0 } else { 4.0 };
            for r in recover(&system, &outcome.state) {
                for (found, far) in [(r.stress_top[0], side > 0.0), (r.stress_bottom[0], side < 0.0)] {
                    let error = (found - expected(far)).abs() / (force / h);
                    assert!(error < 1e-6, "{element:?} {side}: {found} for {}", expected(far));
                }
                assert!((r.von_mises / expected(false) - 1.0).abs() < 1e-6, "{element:?}: {}", r.von_mises);
            }
        }
    }
}
