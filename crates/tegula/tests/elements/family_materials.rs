//! Layups and nonlinear materials in all elements: masses and weights of uneven layups, prescribed strains, locking of rubber,
//! memory of metal; what is refused and warned of.

use crate::common;
use crate::common::{compile, model, on, plate, resultant, strains, vector_load};
use crate::harness::{H, YOUNG, layup, materials};
use tegula::analysis::statics;
use tegula::material::NeoHookeanForm;
use tegula::model::*;
use tegula::norm::larger;
use tegula::system::Assembly;
use tegula::{System, Vec3};

/// Rubber and fibre, heavy and light: the first moment of the mass does not vanish.
fn uneven_plate(element: ElementKind) -> Model {
    let mut m = model(plate([1.2, 0.7], [3, 2], 0.2), YOUNG, H);
    m.materials = materials();
    m.sections[0].element = element;
    if element != ElementKind::AncfFull {
        m.sections[0] = Section { element, ..Section::new("", 0.0) };
        m.sections[0].layup = Some(layup(&[("m", 0.0, 0.5), ("ply", 30.0, 0.3), ("ply", -50.0, 0.2)]));
    }
    m.loads = vec![Load::Gravity(GravityLoad { value: [0.4, -0.3, -1.0], amplitude: None })];
    m
}

#[test]
fn uneven_layups_have_their_weight_and_its_moment_and_reactions_balance_it() {
    for &element in ElementKind::ALL {
        let m = uneven_plate(element);
        let (_, system) = compile(&m);
        let area = 1.2 * 0.7;
        let (mass, first) = if element == ElementKind::AncfFull {
            (2.0 * H, 0.0)
        } else {
            // ∫ρ dz and ∫ρ z dz: 2.0 over the lower half, 0.7 over the upper.
            ((0.5 * 2.0 + 0.5 * 0.7) * H, (0.7 - 2.0) * H * H / 8.0)
        };
        let total = mass * area;
        assert!((system.total_mass() - total).abs() < 1e-12 * total, "{element:?}");
        let g = Vec3::new(0.4, -0.3, -1.0);
        let still = vec![[0.0; 3]; system.vectors()];
        let mut weight = still.clone();
        system.add_dead_loads(1.0, 1.0, &mut weight);
        let (force, moment) = resultant(&system, &still, &weight);
        let centre = Vec3::new(0.6, 0.35, first / mass);
        assert!((force - g * total).norm() < 1e-12 * total, "{element:?}: {force:?}");
        let exact = centre.cross(&g) * total;
        assert!((moment - exact).norm() < 1e-11 * exact.norm(), "{element:?}: {moment:?} for {exact:?}");

        let outcome = statics::run(&system, &common::static_options(&m), None, &mut common::Notes::default());
        let state = outcome.unwrap().state;
        let mut assembly = Assembly::new(&system);
        let reactions = statics::reactions(&system, &mut assembly, &state);
        assert!(!system.linear);
        let held = resultant(&system, &state.u, &reactions);
        let loads = resultant(&system, &state.u, &weight);
        assert!((held.0 + loads.0).norm() < 1e-9 * loads.0.norm(), "{element:?}: {held:?} {loads:?}");
        assert!((held.1 + loads.1).norm() < 1e-9 * loads.1.norm(), "{element:?}: {held:?} {loads:?}");
    }
}

fn warned(m: &Model) -> Vec<String> {
    let (mesh, system) = compile(m);
    tegula::compile::warnings(m, &mesh, &system).iter().map(|i| i.place.key.clone()).collect()
}

#[test]
fn keys_without_effect_are_warned_of() {
    let base = |element| {
        let mut m = model(plate([1.0, 0.5], [2, 1], 0.0), YOUNG, 0.01);
        m.sections[0].element = element;
        m.loads = vec![Load::Edge(vector_load("u_max", [0.0, 0.0, 1.0]))];
        m
    };
    let mut m = base(ElementKind::Mitc4);
    m.sections[0].ans_thickness = false;
    m.sections[0].thickness_points = Some(4);
    m.sections[0].thickness_eas = 3;
    m.sections[0].shear_stabilization = 0.1;
    let all = ["sections[0].ans_thickness", "sections[0].thickness_eas", "sections[0].thickness_points"];
    assert_eq!(warned(&m), all);
    m.sections[0].element = ElementKind::Cm;
    assert_eq!(warned(&m), ["sections[0].shear_stabilization"]);
    m.sections[0].shear_stabilization = 0.0;
    assert!(warned(&m).is_empty());
    let mut m = base(ElementKind::AncfFull);
    (m.sections[0].ans_shear, m.sections[0].eas) = (false, false);
    assert_eq!(warned(&m), ["sections[0].ans_shear", "sections[0].eas"]);
    // The thickness of a layup is that of its plies.
    let mut m = base(ElementKind::Ems);
    m.sections[0] = Section::new("", 0.0);
    m.sections[0].layup = Some(Layup {
        stacking: Some("[0/0]".into()),
        material: Some("m".into()),
        ply_thickness: Some(9.0),
        ..Layup::default()
    });
    assert_eq!(warned(&m), ["sections[0].thickness"]);
    // Only motions have velocities at the start.
    let mut m = base(ElementKind::Ems);
    m.initial_velocities = vec![InitialVelocity {
        on: "all".into(),
        velocity: [1.0, 0.0, 0.0],
        angular_velocity: [0.0; 3],
        center: [0.0; 3],
    }];
    m.analysis = Analysis::Static(StaticAnalysis::default());
    assert_eq!(warned(&m), ["initial_velocities[0]"]);
    let given = std::mem::take(&mut m.initial_velocities);
    m.bodies = vec![RigidBody {
        attached: vec!["u_max".into()],
        ..RigidBody::new("hub", [1.0, 0.25, 0.0], 1.0, Some([1.0; 3]))
    }];
    assert!(warned(&m).is_empty(), "{:?}", warned(&m));
    m.bodies[0].angular_velocity = [0.0, 0.0, 2.0];
    assert_eq!(warned(&m), ["bodies[0].velocity"]);
    (m.initial_velocities, m.bodies) = (given, Vec::new());
    m.analysis = Analysis::Transient(TransientAnalysis::new(1.0));
    m.conditions.clear();
    assert!(warned(&m).is_empty(), "{:?}", warned(&m));
}

#[test]
fn motions_that_begin_with_a_jump_are_warned_of() {
    let warned = |amplitude: Option<&str>, analysis: Analysis| {
        let mut m = model(plate([1.0, 0.5], [2, 1], 0.0), YOUNG, 0.01);
        for name in ["1 - t", "sin(t)"] {
            let formula = ExpressionAmplitude { expression: name.into() };
            m.amplitudes.insert(name.into(), Amplitude::Expression(formula));
        }
        m.conditions.push(Condition::Prescribe(PrescribeComponent {
            on: "u_max".into(),
            of: NodalVector::Position,
            component: Axis::Z,
            value: 0.01,
            amplitude: amplitude.map(str::to_owned),
        }));
        m.analysis = analysis;
        warned(&m)
    };
    let transient = || Analysis::Transient(TransientAnalysis::new(0.1));
    assert_eq!(warned(None, transient()), ["conditions[1]"]);
    assert_eq!(warned(Some("1 - t"), transient()), ["conditions[1]"]);
    assert!(warned(Some("sin(t)"), transient()).is_empty());
    assert!(warned(None, Analysis::Static(StaticAnalysis::default())).is_empty());
}

#[test]
fn modal_analyses_know_prescribed_strains_as_loads() {
    for (prestressed, expected) in [(true, vec![]), (false, vec!["prescribed_strains[0]".to_string()])] {
        let mut m = model(plate([1.0, 0.5], [2, 1], 0.0), YOUNG, 0.01);
        m.prescribed_strains = vec![strains()[2].clone()];
        m.analysis = Analysis::Modal(ModalAnalysis { prestressed, ..ModalAnalysis::new(2) });
        assert_eq!(warned(&m), expected);
    }
}

fn refused(m: &Model) -> Vec<(String, String)> {
    let mesh = tegula::mesh::generators::generate(&m.mesh).unwrap();
    match tegula::compile::build(m, &mesh) {
        Err(tegula::Error::Model(list)) => {
            list.iter().map(|i| (i.place.key.clone(), i.message.clone())).collect()
        }
        Ok(_) => Vec::new(),
        Err(e) => panic!("{e}"),
    }
}

#[test]
fn layups_are_refused_for_one_reason_only() {
    let with = |layup| {
        let mut m = model(plate([1.0, 0.5], [2, 1], 0.0), YOUNG, 0.01);
        m.materials = materials();
        m.sections[0] = Section { element: ElementKind::Mitc4, ..Section::new("", 0.0) };
        m.sections[0].layup = Some(layup);
        m.loads = vec![Load::Edge(vector_load("u_max", [0.0, 0.0, 1.0]))];
        m
    };
    let found = refused(&with(layup(&[("m", 0.0, 0.5), ("rubber", 0.0, 0.5)])));
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].1.contains("plane stress"), "{found:?}");
    for direction in [[0.0; 3], [1e-200, 0.0, 0.0]] {
        let found = refused(&with(Layup { direction, ..layup(&[("m", 0.0, 1.0)]) }));
        let keys: Vec<_> = found.iter().map(|f| f.0.as_str()).collect();
        assert_eq!(keys, ["sections[0].layup.direction"], "{found:?}");
    }
}

/// Nearly incompressible rubber bends like the incompressible plate, and a clamped sheet blown up does not depend on
/// the last digits of the bulk modulus.
#[test]
#[ignore = "long"]
fn nearly_incompressible_rubber_does_not_lock() {
    for element in [ElementKind::Cm, ElementKind::SolidShell] {
        let bent = |bulk: f64| {
            let mut m = model(plate([1.0, 0.2], [8, 2], 0.15), 1.0, 0.01);
            let law = NeoHookean { shear: 1.0, bulk, density: 0.0, form: NeoHookeanForm::Split };
            m.materials.insert("m".into(), Material::NeoHookean(law));
            m.sections[0].element = element;
            m.loads = vec![Load::Edge(vector_load("u_max", [0.0, 0.0, 1e-9]))];
            let (mesh, system, outcome) = common::solve(&m);
            common::displacement(&mesh, &system, &outcome.state.u, "u_max_v_min").z
        };
        // Between the wide strip, D = E h³/12/(1 − ν²), and the narrow one.
        let (e, h) = (3.0, 0.01_f64);
        let narrow = 1e-9 / (3.0 * e * h.powi(3) / 12.0);
        for bulk in [1e3, 1e4] {
            let z = bent(bulk);
            println!("{element:?} {bulk}: {z} of {narrow}");
            assert!((0.75 * narrow..1.01 * narrow).contains(&z), "{element:?} {bulk}: {z} of {narrow}");
        }
        let blown = |bulk: f64| {
            let mut m = model(plate([1.0, 1.0], [4, 4], 0.0), 1.0, 0.02);
            let law = NeoHookean { shear: 1.0, bulk, density: 0.0, form: NeoHookeanForm::Split };
            m.materials.insert("m".into(), Material::NeoHookean(law));
            m.sections[0].element = element;
            m.conditions = ["u_min", "u_max", "v_min", "v_max"].map(|set| Condition::Hinge(on(set))).into();
            m.loads = vec![Load::Pressure(PressureLoad {
                on: "all".into(),
                value: -0.03,
                amplitude: None,
                distribution: None,
            })];
            m.analysis = Analysis::Static(StaticAnalysis { load_steps: 4, ..Default::default() });
            let (_, _, outcome) = common::solve(&m);
            outcome.state.u.iter().map(|u| u[2]).reduce(larger).unwrap()
        };
        let (soft, hard) = (blown(1e2), blown(1e4));
        println!("{element:?}: {soft} {hard}");
        assert!(soft > 0.1 && (hard - soft).abs() < 2e-2 * soft, "{element:?}: {hard} for {soft}");
    }
}

/// Pulled, pushed back and pulled again: the force follows the law of the point, whose yield point in compression
/// comes early by the back stress.
#[test]
fn metal_strips_remember_where_they_were_pulled() {
    let (e, y, k) = (2e5, 200.0, 2e4);
    for element in [ElementKind::Ems, ElementKind::Mitc4, ElementKind::Cm, ElementKind::SolidShell] {
        let mut m = model(plate([1.0, 0.5], [2, 1], 0.2), e, 0.1);
        let law = Plastic {
            young: e,
            poisson: 0.3,
            yield_stress: y,
            hardening: 0.0,
            saturation: None,
            saturation_rate: 0.0,
            kinematic: k,
            density: 0.0,
            expansion: 0.0,
        };
        m.materials.insert("m".into(), Material::Plastic(law));
        m.sections[0].element = element;
        let plane = |set: &str, normal| Condition::Symmetry(SymmetryPlane { on: set.into(), normal });
        let flat = FixComponents { on: "all".into(), position: vec![Axis::Z], director: vec![] };
        m.conditions =
            vec![plane("u_min", [1.0, 0.0, 0.0]), plane("v_min", [0.0, 1.0, 0.0]), Condition::Fix(flat)];
        let path = [0.0, 0.004, 0.002, 0.0005, 0.003, 0.005];
        let stretch = |strain: f64| (1.0 + 2.0 * strain).sqrt() - 1.0;
        let times: Vec<f64> = (0..path.len()).map(|i| i as f64 / 5.0).collect();
        let values = path.map(stretch).to_vec();
        m.amplitudes.insert("cycle".into(), Amplitude::Table(TableAmplitude { times, values }));
        m.conditions.push(Condition::Prescribe(PrescribeComponent {
            on: "u_max".into(),
            of: NodalVector::Position,
            component: Axis::X,
            value: 1.0,
            amplitude: Some("cycle".into()),
        }));
        m.analysis = Analysis::Static(StaticAnalysis { load_steps: 5, ..Default::default() });
        let (mesh, system) = compile(&m);
        let mut notes = common::Notes::keeping();
        statics::run(&system, &common::static_options(&m), None, &mut notes).unwrap();
        // The law of a bar: σ = E (ε − p), |σ − K p| ≤ y.
        let mut p = 0.0_f64;
        for (state, strain) in notes.states.iter().zip(&path[1..]) {
            let trial = e * (strain - p) - k * p;
            if trial.abs() > y {
                p += (trial.abs() - y) / (e + k) * trial.signum();
            }
            let exact = e * (strain - p) * 0.05 * (1.0 + 2.0 * strain).sqrt();
            let force = pull(&system, &mesh, state);
            assert!((force - exact).abs() < 1e-6 * y * 0.05, "{element:?} at {strain}: {force} for {exact}");
        }
        assert!(p != 0.0);
    }
}

fn pull(system: &System, mesh: &tegula::Mesh, state: &tegula::analysis::State) -> f64 {
    let mut assembly = Assembly::new(system);
    let reactions = statics::reactions(system, &mut assembly, state);
    let nodes = mesh.nodes_on("u_max").unwrap();
    nodes.iter().map(|&n| reactions[system.coordinates.position_of[n as usize] as usize][0]).sum()
}
