//! Stability of stretched, short and rubber elements: instabilities that belong to the element and not to the structure.

use crate::common::{Notes, compile, displacement, model, on, plate, static_options, vector_load};
use tegula::analysis::statics;
use tegula::material::NeoHookeanForm;
use tegula::model::*;
use tegula::norm::larger;
use tegula::{Error, Result};

fn run(m: &Model) -> Result<statics::StaticOutcome> {
    let (_, system) = compile(m);
    statics::run(&system, &static_options(m), None, &mut Notes::default())
}

/// A clamped square of side 1 under an edge load whose linear moment strains the fibres by a tenth, in n × 1 elements.
fn strip(n: u32, element: ElementKind, membrane: Option<Membrane>) -> Model {
    let (young, h) = (1e6, 0.05);
    let mut m = model(plate([1.0, 1.0], [n, 1], 0.0), young, h);
    m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(young, 0.0, 1.0)));
    m.sections[0].element = element;
    m.sections[0].membrane = membrane;
    m.loads = vec![Load::Edge(vector_load("u_max", [0.0, 0.0, 0.1 * young * h * h / 6.0]))];
    m.analysis = Analysis::Static(StaticAnalysis { load_steps: 10, ..Default::default() });
    m
}

const BILINEAR: [ElementKind; 4] =
    [ElementKind::Ems, ElementKind::Cm, ElementKind::Mitc4, ElementKind::SolidShell];

/// T. Sussman, K.-J. Bathe, Comput. Struct. 140 (2014) 14–22: incompatible modes lose stability at a fibre strain of
/// about 1.2 over the aspect ratio.
#[test]
fn stretched_elements_stay_stable_in_bending() {
    for element in [ElementKind::Ems, ElementKind::Cm, ElementKind::Mitc4] {
        for membrane in [None, Some(Membrane::Displacement)] {
            let outcome = run(&strip(64, element, membrane));
            assert_eq!(outcome.unwrap().negative_pivots, 0, "{element:?} {membrane:?}");
        }
    }
    // The paper's element has the defect; else this test would test nothing.
    match run(&strip(64, ElementKind::Ems, Some(Membrane::Eas))) {
        Err(Error::NotConverged { reason, at, .. }) => {
            assert!(reason.contains("unstable"), "{reason}");
            // The message says where the mode lives.
            assert!(reason.contains("enhanced strains remove 9"), "{reason}");
            let factor: f64 = at.trim_start_matches("load factor ").parse().unwrap();
            assert!((0.1..0.3).contains(&factor), "{at}");
        }
        other => panic!("{:?}", other.map(|o| o.negative_pivots)),
    }
}

#[test]
fn membrane_parts_agree_where_elements_are_not_stretched() {
    // Rectangles of an aspect ratio of 2 are the paper's to the bit.
    let tip = |membrane| run(&strip(2, ElementKind::Ems, Some(membrane))).unwrap().state.u;
    assert_eq!(tip(Membrane::StableEas), tip(Membrane::Eas));
    assert_ne!(tip(Membrane::StableEas), tip(Membrane::Mitc4Plus));
}

/// A cantilever of five times its thickness in cylindrical bending up to fibre strains of about a fifth.
fn block(n: u32, element: ElementKind) -> Model {
    let (young, h) = (1e6, 0.2);
    let mut m = model(plate([1.0, 0.1], [n, 1], 0.0), young, h);
    m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(young, 0.0, 1.0)));
    m.sections[0].element = element;
    m.sections[0].membrane = Some(Membrane::Displacement);
    let plane = |position, director| {
        Condition::Fix(FixComponents { on: "all".into(), position: vec![position], director: vec![director] })
    };
    m.conditions.push(plane(Axis::Y, Axis::Y));
    m.loads = vec![Load::Edge(vector_load("u_max", [0.0, 0.0, 0.4 * young * h * h / 6.0]))];
    m.analysis = Analysis::Static(StaticAnalysis { load_steps: 10, ..Default::default() });
    m
}

/// Directors that stretch and shrink in turn from node to node cost the transverse shear `z ∂ε_zz/∂x`. Without it elements
/// of a thirteenth of the thickness lost stability at a fibre strain of 9 %.
#[test]
fn elements_shorter_than_the_thickness_stay_stable_in_bending() {
    // h/4.8, h/6.4 and h/12.8.
    for n in [24, 32, 64] {
        for element in BILINEAR {
            let outcome = run(&block(n, element)).unwrap();
            assert_eq!(outcome.negative_pivots, 0, "{element:?} {n}");
        }
    }
}

/// A quarter of a sheet of rubber pulled alike in two directions.
fn rubber_sheet(membrane: Option<Membrane>, stretch: f64) -> Model {
    let mut m = model(plate([1.0, 1.0], [4, 4], 0.2), 1.0, 0.02);
    let law = MooneyRivlin { c10: 2e5, c01: 5e4, bulk: 5e9, density: 0.0 };
    m.materials.insert("m".into(), Material::MooneyRivlin(law));
    m.sections[0].element = ElementKind::Cm;
    m.sections[0].membrane = membrane;
    let symmetry = |set: &str, normal| Condition::Symmetry(SymmetryPlane { on: set.into(), normal });
    let pull = |set: &str, component| {
        Condition::Prescribe(PrescribeComponent {
            on: set.into(),
            of: NodalVector::Position,
            component,
            value: stretch - 1.0,
            amplitude: None,
        })
    };
    let hold = FixComponents { on: "u_min_v_min".into(), position: vec![Axis::Z], director: vec![] };
    m.conditions = vec![
        symmetry("u_min", [1.0, 0.0, 0.0]),
        symmetry("v_min", [0.0, 1.0, 0.0]),
        Condition::Fix(hold),
        pull("u_max", Axis::X),
        pull("v_max", Axis::Y),
    ];
    m.analysis = Analysis::Static(StaticAnalysis { load_steps: 20, ..Default::default() });
    m
}

/// Equibiaxial tension of Mooney–Rivlin's material is stable at every stretch when displacements of the edges are given.
#[test]
fn rubber_stays_stable_in_equibiaxial_tension() {
    let m = rubber_sheet(None, 3.0);
    let (mesh, system) = compile(&m);
    let outcome = statics::run(&system, &static_options(&m), None, &mut Notes::default()).unwrap();
    assert_eq!(outcome.negative_pivots, 0);
    // Homogeneous: inner nodes follow the edges, and the sheet thins by 1/9.
    for (node, x) in mesh.positions.iter().enumerate() {
        let u = outcome.state.u[system.coordinates.position_of[node] as usize];
        for i in 0..2 {
            assert!((u[i] - 2.0 * x[i]).abs() < 1e-6, "node {node}: {u:?}");
        }
        let d = outcome.state.u[system.coordinates.director_of[node] as usize];
        assert!((d[2] + 8.0 / 9.0).abs() < 1e-3, "node {node}: {d:?}");
    }
    assert!((displacement(&mesh, &system, &outcome.state.u, "u_max_v_max").x - 2.0).abs() < 1e-12);
    let refused = run(&rubber_sheet(Some(Membrane::Eas), 3.0));
    assert!(matches!(refused, Err(Error::NotConverged { .. })), "{:?}", refused.map(|o| o.negative_pivots));
}

/// A nearly incompressible sheet between hinges bears a pressure that lifts it by ten times its thickness, on any mesh:
/// none locks and buckles under the stresses of the locking.
#[test]
#[ignore = "long"]
fn rubber_between_hinges_bears_pressure_on_coarse_meshes() {
    // The whole sheet, or a quarter of it between planes of symmetry.
    let rise = |n: u32, quarter: bool| {
        let parts: u32 = if quarter { 2 } else { 1 };
        let side = 1.0 / f64::from(parts);
        let mut m = model(plate([side; 2], [n / parts; 2], 0.0), 1.0, 0.02);
        let law = NeoHookean { shear: 1.0, bulk: 1e4, density: 0.0, form: Default::default() };
        m.materials.insert("m".into(), Material::NeoHookean(law));
        m.sections[0].element = ElementKind::Cm;
        m.conditions = ["u_max", "v_max"].map(|set| Condition::Hinge(on(set))).into();
        m.conditions.extend([("u_min", [1.0, 0.0, 0.0]), ("v_min", [0.0, 1.0, 0.0])].map(|(set, normal)| {
            if quarter {
                Condition::Symmetry(SymmetryPlane { on: set.into(), normal })
            } else {
                Condition::Hinge(on(set))
            }
        }));
        m.loads = vec![Load::Pressure(PressureLoad {
            on: "all".into(),
            value: -0.03,
            amplitude: None,
            distribution: None,
        })];
        // Longer steps fail at first, where the sheet is flat.
        m.analysis = Analysis::Static(StaticAnalysis { load_steps: 32, ..Default::default() });
        let outcome = run(&m).unwrap();
        assert_eq!(outcome.negative_pivots, 0, "{n}");
        outcome.state.u.iter().map(|u| u[2]).reduce(larger).unwrap()
    };
    let fine = rise(8, true);
    assert!(fine > 0.2, "{fine}");
    for (n, quarter) in [(4, false), (6, true)] {
        // Meshes with a node in the middle: the error falls with the square of the size of the elements.
        let off = rise(n, quarter) / fine - 1.0;
        assert!(off.abs() < 1.0 / f64::from(n * n), "{n}: {off}");
    }
    rise(5, false);
}

/// A rubber block is compressed to half its length between rigid, smooth plates, its mid-surface held plane. A half-space loses stability
/// at a stretch of 0.444 under simple compression (M. A. Biot, Appl. Sci. Res. A 12 (1963) 168–182). Blocks of elements follow to a
/// stretch that does not depend on the mesh: not one that falls with the length of elements over the thickness.
#[test]
#[ignore = "long"]
fn compressed_rubber_stays_stable_on_any_mesh() {
    let meshes = [(4, 0.05), (4, 0.2), (8, 0.2), (8, 0.4)];
    for (element, meshes) in [(ElementKind::Cm, &meshes[..]), (ElementKind::SolidShell, &meshes[3..])] {
        for &(n, thickness) in meshes {
            let mut m = model(plate([1.0, 1.0], [n, n], 0.0), 1.0, thickness);
            let law = NeoHookean { shear: 1e6, bulk: 50e6, density: 0.0, form: NeoHookeanForm::default() };
            m.materials.insert("m".into(), Material::NeoHookean(law));
            m.sections[0].element = element;
            let symmetry = |set: &str, normal| Condition::Symmetry(SymmetryPlane { on: set.into(), normal });
            let mut conditions = vec![symmetry("u_min", [1.0, 0.0, 0.0]), symmetry("v_min", [0.0, 1.0, 0.0])];
            conditions.push(Condition::Fix(FixComponents {
                on: "all".into(),
                position: vec![Axis::Z],
                director: vec![],
            }));
            conditions.push(Condition::Prescribe(PrescribeComponent {
                on: "u_max".into(),
                of: NodalVector::Position,
                component: Axis::X,
                value: -0.5,
                amplitude: None,
            }));
            m.conditions = conditions;
            m.analysis = Analysis::Static(StaticAnalysis { load_steps: 10, ..Default::default() });
            let stretch = match run(&m) {
                Ok(_) => 0.5,
                Err(Error::NotConverged { at, .. }) => {
                    1.0 - 0.5 * at.trim_start_matches("load factor ").parse::<f64>().unwrap()
                }
                Err(error) => panic!("{error}"),
            };
            println!("{element:?} {n} elements, h = {thickness}: stable to {stretch}");
            assert!((0.49..0.57).contains(&stretch), "{element:?} {n} {thickness}: {stretch}");
        }
    }
}
