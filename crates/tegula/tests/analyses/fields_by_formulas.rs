//! Thickness and prescribed strains that vary over the surface by a formula: each element has the mean.

use crate::common::{self, compile, plate};
use tegula::compile::{build, check, warnings};
use tegula::mesh::generators::generate;
use tegula::model::*;
use tegula::result::recover;

const YOUNG: f64 = 2e5;
const EXPANSION: f64 = 1e-5;

/// A linear model of a strip along x, without lateral contraction, whose material expands.
fn strip([length, width]: [f64; 2], elements: [u32; 2], thickness: f64) -> Model {
    let mut m = common::model(plate([length, width], elements, 0.0), YOUNG, thickness);
    let material = Isotropic { expansion: EXPANSION, ..Isotropic::new(YOUNG, 0.0, 3.0) };
    m.materials.insert("m".into(), Material::Isotropic(material));
    m.analysis = Analysis::Static(StaticAnalysis { linear: true, ..Default::default() });
    m.loads = vec![Load::Edge(VectorLoad::new("u_max", [0.0, 0.0, 1e-9]))];
    m
}

fn heat(temperature: f64, distribution: &str) -> PrescribedStrain {
    PrescribedStrain::Thermal(ThermalStrain {
        on: "all".into(),
        temperature,
        gradient: 0.0,
        distribution: Some(distribution.into()),
        amplitude: None,
    })
}

/// A strip between two walls under the temperature 4T x(1 − x)/1, whose mean is 2T/3: the force is −E h α 2T/3 everywhere.
#[test]
fn a_strip_between_walls_has_the_force_of_the_mean_temperature() {
    let (h, top) = (0.02, 30.0);
    for element in [ElementKind::Ems, ElementKind::Mitc4, ElementKind::Cm, ElementKind::SolidShell] {
        let mut m = strip([1.0, 0.2], [7, 1], h);
        m.sections[0].element = element;
        m.conditions.push(Condition::Clamp(common::on("u_max")));
        m.prescribed_strains = vec![heat(4.0 * top, "x*(1 - x)")];
        let (_, system, outcome) = common::solve(&m);
        let exact = -YOUNG * h * EXPANSION * 2.0 / 3.0 * top;
        for stress in recover(&system, &outcome.state) {
            let found = stress.membrane[0];
            assert!((found / exact - 1.0).abs() < 1e-5, "{element:?}: {found} for {exact}");
        }
    }
}

/// The natural curvature κ x of a cantilever of length 1 moves its tip by ∫κ x (1 − x) dx = κ/6 towards the director.
#[test]
fn a_growing_natural_curvature_lifts_the_tip() {
    let mut m = strip([1.0, 0.1], [32, 1], 0.01);
    let PrescribedStrain::Natural(mut natural) = common::natural([0.0; 3], [1e-3, 0.0, 0.0], None) else {
        unreachable!()
    };
    natural.distribution = Some("x".into());
    m.prescribed_strains = vec![PrescribedStrain::Natural(natural)];
    let (mesh, system, outcome) = common::solve(&m);
    let found = common::displacement(&mesh, &system, &outcome.state.u, "u_max_v_min").z;
    assert!((found / (1e-3 / 6.0) - 1.0).abs() < 1e-3, "{found}");
}

#[test]
fn a_prestress_has_its_mean_in_each_element() {
    let mut m = strip([1.0, 0.1], [4, 1], 0.01);
    m.prescribed_strains = vec![PrescribedStrain::Prestress(Prestress {
        on: "all".into(),
        membrane: [8.0, 0.0, 0.0],
        bending: [0.0; 3],
        direction: [1.0, 0.0, 0.0],
        distribution: Some("x^2".into()),
        amplitude: None,
    })];
    let (_, system) = compile(&m);
    let factors: Vec<f64> = system.shells.iter().map(|shell| shell.prescribed[0]).collect();
    // (b³ − a³)/(3(b − a)) of the quarters.
    for (found, exact) in factors.iter().zip([1.0, 7.0, 19.0, 37.0].map(|x| x / 48.0)) {
        assert!((found - exact).abs() < 1e-9, "{factors:?}");
    }
}

/// A cantilever of the thickness h (1 − x/2) under a force F at its end bends by `w = ∫ F (1 − x)²/(E I) dx` with `E I = E b h³(1 − x/2)³/12`,
/// that is `(12F/(E b h³)) 8 (ln 2 − 5/8)`, as follows with s = 2 − x: `∫₁² 8 (s − 1)²/s³ ds = 8 [ln s + 2/s − 1/(2s²)]₁²`.
/// Shear adds `∫ F/(5/6 G b h (1 − x/2)) dx` with G = E/2.
#[test]
#[ignore = "long"]
fn a_tapered_cantilever_deflects_as_a_beam() {
    let (h, width, force) = (0.01, 0.1, 1e-3);
    let bending = 12.0 / (h * h) * 8.0 * (2.0_f64.ln() - 0.625);
    let shear = 2.4 * 2.0 * 2.0_f64.ln();
    let exact = force / (YOUNG * width * h) * (bending + shear);
    for element in [ElementKind::Ems, ElementKind::Mitc4, ElementKind::Cm, ElementKind::SolidShell] {
        let off = |n: u32, layup: bool| {
            let mut m = strip([1.0, width], [n, 1], h);
            m.sections[0].element = element;
            if layup {
                m.sections[0].material = String::new();
                m.sections[0].thickness = 0.0;
                m.sections[0].layup = Some(Layup {
                    stacking: Some("[0/90]s".into()),
                    material: Some("m".into()),
                    ply_thickness: Some(0.25 * h),
                    ..Layup::default()
                });
            }
            m.sections[0].thickness_distribution = Some("1 - x/2".into());
            m.loads = vec![Load::Edge(VectorLoad::new("u_max", [0.0, 0.0, force / width]))];
            let (mesh, system, outcome) = common::solve(&m);
            common::displacement(&mesh, &system, &outcome.state.u, "u_max_v_min").z / exact - 1.0
        };
        let [coarse, fine] = [8, 16].map(|n| off(n, false));
        // The error falls as the length of the elements squared.
        assert!(fine.abs() < 2e-3, "{element:?}: {coarse:.2e}, {fine:.2e}");
        assert!((0.2..0.32).contains(&(fine / coarse)), "{element:?}: {coarse:.2e}, {fine:.2e}");
        let plies = off(16, true);
        assert!((plies - fine).abs() < 1e-3, "{element:?}: {plies:.2e} for {fine:.2e}");
    }
}

/// The mass of the thickness 0.01 (1 + x) on the unit square is ρ · 0.015; a given total mass is met and keeps the shares.
#[test]
fn the_mass_is_that_of_the_distributed_thickness() {
    let mut m = strip([1.0, 1.0], [5, 3], 0.01);
    m.sections[0].thickness_distribution = Some("1 + x".into());
    let mass = |m: &Model| {
        let (_, system) = compile(m);
        system.total_mass()
    };
    assert!((mass(&m) / (3.0 * 0.015) - 1.0).abs() < 1e-9, "{}", mass(&m));
    m.sections[0].total_mass = Some(7.0);
    assert!((mass(&m) / 7.0 - 1.0).abs() < 1e-12, "{}", mass(&m));
}

#[test]
fn formulas_of_thickness_and_strains_without_meaning_are_refused() {
    let issues = |m: &Model| {
        let mesh = generate(&m.mesh).unwrap();
        let mut issues = check::keys(m);
        issues.extend(check::sets(m, &mesh));
        assert!(build(m, &mesh).is_err());
        issues
    };
    for (element, formula, message) in [
        (
            ElementKind::Ems,
            "max(1 - 2*x, 0)",
            "over element 1 at (0.75, 0.5, 0.0) is 0.000e0: the thickness must be above 0",
        ),
        (ElementKind::Ems, "1 - 1.02*x", "is -2.000e-2 at node "),
        (ElementKind::Ems, "x - 1", "at (0.0, 0.0, 0.0): no thickness is below 0"),
        (ElementKind::Ems, "0", "is 0.000e0: the thickness must be above 0"),
        (ElementKind::Ems, "1/x", "grows beyond all bounds, at (0.0, 0.0, 0.0)"),
        (ElementKind::Ems, "1 + ", "formula"),
        (ElementKind::AncfFull, "1 + x", "`ancf-full` has one thickness in each section"),
    ] {
        let mut m = strip([1.0, 1.0], [2, 1], 0.01);
        m.sections[0].element = element;
        m.sections[0].thickness_distribution = Some(formula.into());
        let found = issues(&m);
        let key = "sections[0].thickness_distribution";
        assert!(
            found.iter().any(|i| i.place.key == key && i.message.contains(message)),
            "{formula}: {found:?}"
        );
    }
    for (formula, message) in [("t", "unknown variable \"t\""), ("1/x", "grows beyond all bounds")] {
        let mut m = strip([1.0, 1.0], [2, 1], 0.01);
        m.prescribed_strains = vec![heat(1.0, formula)];
        let found = issues(&m);
        let key = "prescribed_strains[0].distribution";
        assert!(
            found.iter().any(|i| i.place.key == key && i.message.contains(message)),
            "{formula}: {found:?}"
        );
    }
}

#[test]
fn a_prescribed_strain_that_is_zero_on_its_set_is_a_warning() {
    for (formula, count) in [("max(x - 2, 0)", 1), ("max(x - 0.9, 0)", 0)] {
        let mut m = strip([1.0, 1.0], [2, 1], 0.01);
        m.prescribed_strains = vec![heat(1.0, formula)];
        let mesh = generate(&m.mesh).unwrap();
        let found = warnings(&m, &mesh, &build(&m, &mesh).unwrap());
        let zero = found.iter().filter(|w| w.message.contains("the prescribed strain is zero"));
        assert_eq!(zero.count(), count, "{formula}: {found:?}");
    }
}

/// A free plate under a linear temperature expands without stress (B. A. Boley, J. H. Weiner, *Theory of Thermal Stresses* (1960), sect. 3.8).
/// Elements that have its mean hold each other: their stress is a part of that of the change of the temperature within an element.
#[test]
fn a_linear_temperature_leaves_stress_of_the_first_order() {
    let h = 0.01;
    for (distortion, limit) in [(0.0, 0.25), (0.25, 0.6)] {
        for elements in [4, 8, 16] {
            let mut m = common::model(plate([1.0, 1.0], [elements, elements], distortion), YOUNG, h);
            let material = Isotropic { expansion: EXPANSION, ..Isotropic::new(YOUNG, 0.0, 3.0) };
            m.materials.insert("m".into(), Material::Isotropic(material));
            m.analysis = Analysis::Static(StaticAnalysis { linear: true, ..Default::default() });
            let held = |on: &str, position: Vec<Axis>| {
                Condition::Fix(FixComponents { on: on.into(), position, director: Vec::new() })
            };
            m.conditions = vec![
                held("u_min_v_min", vec![Axis::X, Axis::Y, Axis::Z]),
                held("u_max_v_min", vec![Axis::Y, Axis::Z]),
                held("u_min_v_max", vec![Axis::Z]),
            ];
            m.loads.clear();
            m.prescribed_strains = vec![heat(10.0, "x + y")];
            let (_, system, outcome) = common::solve(&m);
            let along_a_side = YOUNG * h * EXPANSION * 10.0 / f64::from(elements);
            let stresses: Vec<f64> =
                recover(&system, &outcome.state).iter().flat_map(|stress| stress.membrane).collect();
            let largest = stresses.iter().fold(0.0_f64, |a, b| if b.abs() <= a { a } else { b.abs() });
            assert!(largest < limit * along_a_side, "{distortion} {elements}: {}", largest / along_a_side);
        }
    }
}
