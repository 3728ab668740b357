//! Hyperelastic and plastic shells, and sheets with strains of their own, against closed forms.

use crate::common;
use std::f64::consts::PI;

use crate::common::{Notes, compile, displacement, plate, solve, vector_load};
use tegula::Vec3;
use tegula::analysis::newton::{Equation as _, Newton, Tolerances};
use tegula::analysis::statics::StaticEquation;
use tegula::analysis::{dynamics, statics};
use tegula::material::NeoHookeanForm;
use tegula::model::*;

/// A strip of 2 × 1 × 0.1 pulled along x to a stretch, free to narrow: `u_min` and `v_min` are planes of symmetry.
fn pulled(element: ElementKind, material: Material, stretch: f64) -> Model {
    let mut m = common::model(plate([2.0, 1.0], [4, 2], 0.2), 1.0, 0.1);
    m.materials.insert("m".into(), material);
    m.sections[0].element = element;
    let plane = |set: &str, normal| Condition::Symmetry(SymmetryPlane { on: set.into(), normal });
    let fix =
        |axis| Condition::Fix(FixComponents { on: "all".into(), position: vec![axis], director: vec![] });
    m.conditions = vec![plane("u_min", [1.0, 0.0, 0.0]), plane("v_min", [0.0, 1.0, 0.0]), fix(Axis::Z)];
    m.conditions.push(Condition::Prescribe(PrescribeComponent {
        on: "u_max".into(),
        of: NodalVector::Position,
        component: Axis::X,
        value: 2.0 * (stretch - 1.0),
        amplitude: None,
    }));
    m.analysis =
        Analysis::Static(StaticAnalysis { allow_unstable: true, load_steps: 4, ..Default::default() });
    m
}

/// Sum of the reactions on `u_max` along x, and the narrowing of the edge `v_max`.
fn pull(m: &Model) -> (f64, f64, Vec<f64>) {
    let (mesh, system) = compile(m);
    let mut notes = Notes::default();
    let outcome = statics::run(&system, &common::static_options(m), None, &mut notes).unwrap();
    let mut assembly = tegula::system::Assembly::new(&system);
    let reactions = statics::reactions(&system, &mut assembly, &outcome.state);
    let force = mesh
        .nodes_on("u_max")
        .unwrap()
        .iter()
        .map(|&n| reactions[system.coordinates.position_of[n as usize] as usize][0])
        .sum();
    let narrow = displacement(&mesh, &system, &outcome.state.u, "u_max_v_max").y;
    (force, narrow, outcome.state.history.clone())
}

#[test]
fn rubber_strips_follow_the_law_of_the_point() {
    // Nearly incompressible: nominal stress 2 (λ − λ⁻²)(c10 + c01/λ), width λ^(−1/2).
    let stretch = 1.6;
    for element in [ElementKind::Cm, ElementKind::SolidShell] {
        for (c10, c01) in [(0.5, 0.0), (0.3, 0.2)] {
            for bulk in [1e3, 1e5] {
                let law = MooneyRivlin { c10, c01, bulk, density: 0.0 };
                let (force, narrow, _) = pull(&pulled(element, Material::MooneyRivlin(law), stretch));
                let exact = 0.1 * 2.0 * (stretch - stretch.powi(-2)) * (c10 + c01 / stretch);
                assert!(
                    (force - exact).abs() < 2.0 / bulk * exact,
                    "{element:?} {bulk}: {force} for {exact}"
                );
                assert!((1.0 + narrow - stretch.powf(-0.5)).abs() < 1.0 / bulk);
            }
        }
    }
}

#[test]
fn plastic_strips_follow_the_law_of_the_point_in_every_element() {
    // σ = y + H E/(E + H) (ε − y/E) with the second Piola–Kirchhoff stress and Green–Lagrange's strain; force = λ σ A.
    let (e, y, h) = (2e5, 250.0, 1000.0);
    let law = Plastic {
        young: e,
        poisson: 0.3,
        yield_stress: y,
        hardening: h,
        saturation: None,
        saturation_rate: 0.0,
        kinematic: 0.0,
        density: 0.0,
        expansion: 0.0,
    };
    let strain = 0.01;
    let stretch = (1.0_f64 + 2.0 * strain).sqrt();
    let exact = 0.1 * stretch * (y + h * e / (e + h) * (strain - y / e));
    for element in [ElementKind::Ems, ElementKind::Mitc4, ElementKind::Cm, ElementKind::SolidShell] {
        let (force, _, _) = pull(&pulled(element, Material::Plastic(law.clone()), stretch));
        assert!((force - exact).abs() < 1e-8 * exact, "{element:?}: {force} for {exact}");
    }
}

/// A strip bent beyond yield: the moment of an ideally plastic section is (1 − (κ_y/κ)²/3) 3/2 of the yield moment.
#[test]
fn bent_strips_yield_layer_by_layer() {
    let (e, y, h) = (2e5, 200.0, 0.1);
    let law = Plastic {
        young: e,
        poisson: 0.0,
        yield_stress: y,
        hardening: 0.0,
        saturation: None,
        saturation_rate: 0.0,
        kinematic: 0.0,
        density: 0.0,
        expansion: 0.0,
    };
    for element in [ElementKind::Ems, ElementKind::Mitc4, ElementKind::Cm] {
        let mut m = common::model(plate([1.0, 0.1], [4, 1], 0.0), e, h);
        m.materials.insert("m".into(), Material::Plastic(law.clone()));
        m.sections[0].element = element;
        // Plastic flow narrows the strip: symmetry planes let it, where a clamp would not.
        let symmetry = |set: &str, normal| Condition::Symmetry(SymmetryPlane { on: set.into(), normal });
        let hold = FixComponents { on: "u_min_v_min".into(), position: vec![Axis::Z], director: vec![] };
        m.conditions = vec![
            symmetry("u_min", [1.0, 0.0, 0.0]),
            symmetry("v_min", [0.0, 1.0, 0.0]),
            Condition::Fix(hold),
        ];
        m.sections[0].thickness_points = Some(20);
        // The moment for which κ = 2 κ_y: 11/12 of the plastic moment y h²/4 per width.
        let moment = 11.0 / 12.0 * y * h * h / 4.0;
        m.loads = vec![Load::EdgeMoment(vector_load("u_max", [0.0, -moment, 0.0]))];
        m.analysis = Analysis::Static(StaticAnalysis { load_steps: 4, ..Default::default() });
        let (mesh, system, outcome) = common::solve(&m);
        // Constant curvature over a length of 1: the tip turns by κ.
        let node = mesh.nodes_on("u_max_v_min").unwrap()[0];
        let d = system.coordinates.director_of[node as usize] as usize;
        let director = Vec3::from(system.coordinates.reference[d]) + Vec3::from(outcome.state.u[d]);
        let angle = director.x.atan2(director.z).abs();
        // Where the section is nearly spent its curvature is a poor measure: the moment that belongs to it is held.
        let ratio = 2.0 * y / (e * h) / angle;
        let carried = y * h * h / 4.0 * (1.0 - ratio * ratio / 3.0);
        // Enhanced thickness strain is linear in z; plastic flow is not, and the solid elements feel it.
        let tolerance = if element == ElementKind::Cm { 0.025 } else { 0.01 };
        assert!(
            (carried - moment).abs() < tolerance * moment,
            "{element:?}: {carried} for {moment}, turned by {angle}"
        );
    }
}

/// Newton's method stays quadratic: the energy of the increments, iteration by iteration.
#[test]
fn plastic_tangents_are_consistent() {
    for element in [ElementKind::Ems, ElementKind::Cm] {
        let law = Plastic {
            young: 2e5,
            poisson: 0.3,
            yield_stress: 200.0,
            hardening: 500.0,
            saturation: Some(300.0),
            saturation_rate: 20.0,
            kinematic: 300.0,
            density: 0.0,
            expansion: 0.0,
        };
        let mut m = common::model(plate([1.0, 0.4], [6, 3], 0.15), 2e5, 0.02);
        m.materials.insert("m".into(), Material::Plastic(law));
        m.sections[0].element = element;
        m.loads = vec![Load::Edge(vector_load("u_max", [0.0, 0.0, 0.021]))];
        m.analysis = Analysis::Static(StaticAnalysis { load_steps: 5, ..Default::default() });
        let (_, system) = compile(&m);
        let outcome =
            statics::run(&system, &common::static_options(&m), None, &mut Notes::default()).unwrap();
        let lost = outcome.balance.dissipated / outcome.balance.strain;
        assert!(lost > 0.05, "{element:?}: the strip must yield for the test to mean something: {lost}");
        // Every increment with its own tangent, step by step to the same end.
        let mut energies = Energies::default();
        let solver = common::Fresh(tegula::analysis::direct::Direct::new(&system).unwrap());
        let mut newton = Newton::with_solver(&system, None, solver);
        let tolerances = Tolerances { energy: 1e-18, increment: 1e-6, max_iterations: 20 };
        let mut equation =
            StaticEquation { u: vec![[0.0; 3]; system.vectors()], ..StaticEquation::default() };
        let mut pairs = 0;
        let mut history = tegula::analysis::State::at_rest(&system).history;
        for step in 1..=5 {
            equation.time = f64::from(step) / 5.0;
            let found = newton.solve(&system, &mut equation, &history, &tolerances, &mut energies).unwrap();
            assert_eq!(found.tangents, found.iterations);
            newton.assembly.commit(&system, equation.motion(), equation.time, &mut history);
            let step = std::mem::take(&mut energies.now);
            // At the end of each step the energy of the next increment is the square of the last but for a factor.
            let tail = &step[step.len().saturating_sub(3)..];
            for w in tail.windows(2).filter(|w| w[0] < 1e-3) {
                pairs += 1;
                assert!(w[1] <= 1e3 * w[0] * w[0] + 1e-24, "{element:?}: {step:?}");
            }
        }
        assert!(pairs >= 5, "{element:?}: {pairs} pairs in five steps");
        let off = common::distance(&equation.u, &outcome.state.u);
        let size = common::distance(&vec![[0.0; 3]; equation.u.len()], &equation.u);
        assert!(off < 1e-8 * size, "{element:?}: {off:e} of {size:e}");
        insta::assert_debug_snapshot!(format!("plastic_iterations_{element:?}"), outcome.statistics);
    }
}

#[derive(Default)]
struct Energies {
    now: Vec<f64>,
}

impl tegula::analysis::Observer for Energies {
    fn on_step(&mut self, _step: &tegula::analysis::Step) -> tegula::Result<()> {
        Ok(())
    }

    fn on_iteration(&mut self, _iteration: u32, energy: f64, _increment: f64) {
        self.now.push(energy);
    }
}

/// The energy-momentum scheme conserves the energy of rubber in free flight.
#[test]
#[ignore = "long"]
fn rubber_conserves_energy_and_momentum() {
    let mut m = common::model(plate([1.0, 0.5], [4, 2], 0.2), 1.0, 0.05);
    let law = NeoHookean { shear: 1e6, bulk: 5e6, density: 1000.0, form: NeoHookeanForm::Split };
    m.materials.insert("m".into(), Material::NeoHookean(law));
    m.sections[0].element = ElementKind::Cm;
    m.conditions.clear();
    let spin = |set: &str, velocity, angular_velocity| InitialVelocity {
        on: set.into(),
        velocity,
        angular_velocity,
        center: [0.5, 0.25, 0.0],
    };
    m.initial_velocities =
        vec![spin("all", [0.2, 0.0, 0.1], [1.0, 8.0, 2.0]), spin("u_max", [0.0, 0.0, 6.0], [0.0; 3])];
    let options = TransientAnalysis {
        scheme: Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 }),
        time_step: Some(2e-3),
        ..TransientAnalysis::new(0.1)
    };
    m.analysis = Analysis::Transient(options.clone());
    let (_, system) = compile(&m);
    let mut notes = Notes::default();
    let outcome = dynamics::run(&system, &options, None, &mut notes).unwrap();
    let largest = notes.kinetic;
    assert!(notes.drift() < 1e-9 * largest, "energy drifts by {:e} of {largest:e}", notes.drift());
    assert!(outcome.balance.strain > 1e-4 * largest, "{:?}: it must deform", outcome.balance);
    let (first, last) = (notes.momenta[0], notes.momenta[notes.momenta.len() - 1]);
    assert!((last.0 - first.0).norm() < 1e-9 * first.0.norm());
    assert!((last.1 - first.1).norm() < 1e-9 * first.1.norm());
}

/// A flat strip whose natural curvature is that of a circle of its own length rolls into a tube without stress.
#[test]
fn a_sheet_that_wants_to_be_a_tube_becomes_one() {
    let n = 16;
    for element in [ElementKind::Ems, ElementKind::Mitc4, ElementKind::Cm] {
        let mut m = common::model(plate([2.0, 0.4], [n, 2], 0.0), 1e6, 0.01);
        m.sections[0].element = element;
        // Sixteen chords close when 2 sin(π/n)/L is the curvature; directors point away from the centre for κ < 0.
        let curvature = 2.0 * (PI / f64::from(n)).sin() / (2.0 / f64::from(n));
        m.prescribed_strains = vec![PrescribedStrain::Natural(NaturalStrain {
            distribution: None,
            on: "all".into(),
            strain: [0.0; 3],
            curvature: [curvature, 0.0, 0.0],
            direction: [1.0, 0.0, 0.0],
            amplitude: None,
        })];
        m.analysis = Analysis::Static(StaticAnalysis { load_steps: 4, ..Default::default() });
        let (mesh, system, outcome) = common::solve(&m);
        let tip = displacement(&mesh, &system, &outcome.state.u, "u_max_v_min");
        let gap = (tip + Vec3::new(2.0, 0.0, 0.0)).norm();
        assert!(gap < 5e-3 * 2.0, "{element:?}: the tube stays open by {gap}");
        // Energy of bending the strip flat again, ½ D κ² A: next to nothing of it is left in the tube.
        let flat = 0.5 * 1e6 * 1e-6 / 12.0 / (1.0 - 0.09) * curvature * curvature * 0.8;
        assert!(
            outcome.balance.strain.abs() < 2e-2 * flat,
            "{element:?}: {:e} of {flat:e}",
            outcome.balance.strain
        );
    }
}

/// Free thermal expansion is without stress; held back it is σ = E α T/(1 − ν).
#[test]
fn heat_expands_what_is_free_and_stresses_what_is_held() {
    for element in [
        ElementKind::Ems,
        ElementKind::Mitc4,
        ElementKind::Cm,
        ElementKind::SolidShell,
        ElementKind::AncfFull,
    ] {
        let (alpha, heat, e, nu) = (1e-5, 100.0, 2e5, 0.3);
        let mut m = common::model(plate([1.0, 1.0], [3, 3], 0.25), e, 0.05);
        m.materials.insert(
            "m".into(),
            Material::Isotropic(Isotropic { expansion: alpha, ..Isotropic::new(e, nu, 1.0) }),
        );
        m.sections[0].element = element;
        let symmetry = |set: &str, normal| Condition::Symmetry(SymmetryPlane { on: set.into(), normal });
        m.conditions = vec![
            symmetry("u_min", [1.0, 0.0, 0.0]),
            symmetry("v_min", [0.0, 1.0, 0.0]),
            Condition::Fix(FixComponents { on: "all".into(), position: vec![Axis::Z], director: vec![] }),
        ];
        m.prescribed_strains = vec![PrescribedStrain::Thermal(ThermalStrain {
            distribution: None,
            on: "all".into(),
            temperature: heat,
            gradient: 0.0,
            amplitude: None,
        })];
        m.analysis = Analysis::Static(StaticAnalysis::default());
        let (mesh, system, outcome) = common::solve(&m);
        let corner = displacement(&mesh, &system, &outcome.state.u, "u_max_v_max");
        let exact = (1.0_f64 + 2.0 * alpha * heat).sqrt() - 1.0;
        assert!((corner.x - exact).abs() < 1e-9 * exact, "{element:?}: {corner:?} for {exact}");
        assert!(outcome.balance.strain.abs() < 1e-12 * e * 0.05 * (alpha * heat).powi(2));

        m.conditions = vec![Condition::Fix(FixComponents {
            on: "all".into(),
            position: vec![Axis::X, Axis::Y, Axis::Z],
            director: vec![],
        })];
        if element == ElementKind::Mitc4 || element == ElementKind::AncfFull {
            // The other supports of the held plate are the same in spirit, but not in keys.
            continue;
        }
        let (_, system, outcome) = common::solve(&m);
        let held = e * alpha * heat / (1.0 - nu);
        for r in tegula::result::recover(&system, &outcome.state) {
            for n in [r.membrane[0], r.membrane[1]] {
                assert!(
                    (n + held * 0.05).abs() < 1e-3 * held * 0.05,
                    "{element:?}: {n} for {}",
                    -held * 0.05
                );
            }
        }
    }
}

/// Two strips joined at an edge, one of each element, bend as one strip of either.
#[test]
fn elements_meet_at_an_edge() {
    let halves = |elements: [ElementKind; 2]| {
        let mut m = common::model(plate([2.0, 0.5], [8, 2], 0.0), 1e6, 0.05);
        if let Material::Isotropic(i) = m.materials.get_mut("m").unwrap() {
            i.poisson = 0.0;
        }
        let mut mesh = tegula::mesh::generators::generate(&m.mesh).unwrap();
        let half = |right: bool| -> Vec<u32> {
            (0..mesh.quads.len() as u32)
                .filter(|&q| {
                    let x: f64 = mesh.quads[q as usize].iter().map(|&n| mesh.positions[n as usize].x).sum();
                    (x > 4.0) == right
                })
                .collect()
        };
        let (left, right) = (half(false), half(true));
        mesh.quad_sets.insert("left".into(), left);
        mesh.quad_sets.insert("right".into(), right);
        let section = |set: &str, element| Section { on: set.into(), element, ..m.sections[0].clone() };
        m.sections = vec![section("left", elements[0]), section("right", elements[1])];
        m.loads = vec![Load::Edge(vector_load("u_max", [0.0, 0.0, 1.0]))];
        (m, mesh)
    };
    let tip = |elements: [ElementKind; 2]| {
        let (m, mesh) = halves(elements);
        let system = tegula::compile::build(&m, &mesh).unwrap();
        let outcome =
            statics::run(&system, &common::static_options(&m), None, &mut Notes::default()).unwrap();
        displacement(&mesh, &system, &outcome.state.u, "u_max_v_min").z
    };
    let alone = tip([ElementKind::Ems, ElementKind::Ems]);
    for other in [ElementKind::Cm, ElementKind::SolidShell, ElementKind::Mitc4] {
        for pair in [[ElementKind::Ems, other], [other, ElementKind::Ems], [other, other]] {
            let z = tip(pair);
            assert!((z - alone).abs() < 2e-3 * alone.abs(), "{pair:?}: {z} for {alone}");
        }
    }
    // The edges of ancf-full are cubic: beside straight ones they would gape.
    let (m, mesh) = halves([ElementKind::AncfFull, ElementKind::Ems]);
    let error = tegula::compile::build(&m, &mesh).err().unwrap().to_string();
    assert!(error.contains("`ems` and the `ancf-full` of sections[0] meet at node 4"), "{error}");
}

/// A strip of a plastic material that is free to expand, under heat.
fn heated_strip(element: ElementKind, temperature: f64, gradient: f64) -> Model {
    let mut m = Model::new(
        plate([100.0, 10.0], [4, 1], 0.0),
        Analysis::Static(StaticAnalysis::default()),
        Isotropic::new(1.0, 0.0, 0.0),
        1.0,
    );
    m.materials.insert(
        "m".into(),
        Material::Plastic(Plastic {
            young: 2e5,
            poisson: 0.3,
            yield_stress: 250.0,
            hardening: 1000.0,
            saturation: None,
            saturation_rate: 0.0,
            kinematic: 0.0,
            density: 0.0,
            expansion: 1e-5,
        }),
    );
    m.sections[0].element = element;
    let plane = |on: &str, normal| Condition::Symmetry(SymmetryPlane { on: on.into(), normal });
    m.conditions = vec![
        plane("u_min", [1.0, 0.0, 0.0]),
        plane("v_min", [0.0, 1.0, 0.0]),
        Condition::Fix(FixComponents { on: "u_min_v_min".into(), position: vec![Axis::Z], director: vec![] }),
    ];
    let heat = ThermalStrain { distribution: None, on: "all".into(), temperature, gradient, amplitude: None };
    m.prescribed_strains = vec![PrescribedStrain::Thermal(heat)];
    m
}

#[test]
fn free_heating_of_plastic_elements_leaves_neither_stress_nor_energy() {
    for element in [ElementKind::Ems, ElementKind::Mitc4, ElementKind::Cm] {
        for (temperature, gradient) in [(20.0, 0.0), (20.0, 10.0)] {
            let (mesh, system, outcome) = solve(&heated_strip(element, temperature, gradient));
            let end = mesh.nodes_on("u_max_v_min").unwrap()[0];
            let u = outcome.state.u[system.coordinates.position_of[end as usize] as usize];
            if gradient == 0.0 {
                // Green–Lagrange strain αT = λ²/2 − 1/2 of 100.
                let exact = 100.0 * ((1.0 + 2.0 * 2e-4_f64).sqrt() - 1.0);
                assert!((u[0] / exact - 1.0).abs() < 1e-9, "{element:?}: {u:?} for {exact}");
            }
            // Restrained, the strip would store ½ E (αT)² V = 4 per direction.
            let energy = outcome.balance.strain;
            assert!(energy.abs() < 1e-4, "{element:?}, gradient {gradient}: {energy}");
            assert_eq!(outcome.statistics.cutbacks, 0);
        }
    }
}

#[test]
fn the_largest_sum_of_loads_that_grow_differently_is_not_passed_over() {
    let largest = |load_steps: u32| {
        let mut m = heated_strip(ElementKind::Ems, 0.0, 0.0);
        m.prescribed_strains.clear();
        m.analysis = Analysis::Static(StaticAnalysis { load_steps, ..StaticAnalysis::default() });
        let load = |value: f64, name: &str| {
            Load::Edge(VectorLoad { amplitude: Some(name.into()), ..vector_load("u_max", [value, 0.0, 0.0]) })
        };
        // Their sum 1200 (λ − λ²) is largest at λ = ½, where it is above the yield stress.
        m.loads = vec![load(1200.0, "linear"), load(-1200.0, "square")];
        for (name, expression) in [("linear", "t"), ("square", "t^2")] {
            let formula = ExpressionAmplitude { expression: expression.into() };
            m.amplitudes.insert(name.into(), Amplitude::Expression(formula));
        }
        let (mesh, system, outcome) = solve(&m);
        let end = mesh.nodes_on("u_max_v_min").unwrap()[0];
        outcome.state.u[system.coordinates.position_of[end as usize] as usize][0]
    };
    let fine = largest(64);
    assert!(fine > 3.5, "{fine}");
    for steps in [1, 3, 10] {
        assert!((largest(steps) / fine - 1.0).abs() < 1e-6, "{steps}: {} for {fine}", largest(steps));
    }
}

#[test]
fn heat_beside_a_small_prescribed_motion_is_no_snap_through() {
    for kink in [0.1, 0.45] {
        let mut m = heated_strip(ElementKind::Ems, 100.0, 0.0);
        m.materials.insert(
            "m".into(),
            Material::Isotropic(Isotropic { expansion: 1e-5, ..Isotropic::new(2e5, 0.3, 0.0) }),
        );
        m.analysis = Analysis::Static(StaticAnalysis { load_steps: 10, ..StaticAnalysis::default() });
        let heat = ThermalStrain {
            distribution: None,
            on: "all".into(),
            temperature: 100.0,
            gradient: 0.0,
            amplitude: Some("kink".into()),
        };
        m.prescribed_strains = vec![PrescribedStrain::Thermal(heat)];
        let flat =
            FixComponents { on: "all".into(), position: vec![Axis::Z], director: vec![Axis::X, Axis::Y] };
        m.conditions.push(Condition::Fix(flat));
        m.conditions.push(Condition::Prescribe(PrescribeComponent {
            on: "u_min_v_max".into(),
            of: NodalVector::Position,
            component: Axis::Y,
            value: -1e-3,
            amplitude: Some("kink".into()),
        }));
        let table = TableAmplitude { times: vec![0.0, 0.5, 1.0], values: vec![0.0, kink, 1.0] };
        m.amplitudes.insert("kink".into(), Amplitude::Table(table));
        let (_, _, outcome) = solve(&m);
        assert_eq!((outcome.state.time, outcome.statistics.cutbacks), (1.0, 0), "{kink}");
    }
}

/// Enhanced strains minimise the energy of an element whose points yield one after another: Newton's method alone cycles between two sets of yielding
/// points in a seventh of these states, and needs its line search.
#[test]
fn forces_of_yielding_elements_are_known_in_any_state_of_small_strains() {
    for element in [ElementKind::Ems, ElementKind::Mitc4, ElementKind::Cm] {
        for hardening in [1e3, 1e5] {
            let mut m = common::model(plate([1.0, 1.0], [1, 1], 0.0), 1e7, 0.05);
            let law = Plastic {
                young: 1e7,
                poisson: 0.3,
                density: 1000.0,
                expansion: 0.0,
                yield_stress: 2e3,
                hardening,
                saturation: None,
                saturation_rate: 0.0,
                kinematic: 0.0,
            };
            m.materials.insert("m".into(), Material::Plastic(law));
            m.sections[0].element = element;
            m.loads = crate::multibody::gravity([0.0, 0.0, -1e-3]);
            let (_, system) = compile(&m);
            let mut random = common::Random::new(7);
            for number in 0..300 {
                let mut state = tegula::analysis::State::first(&system);
                let size = 10_f64.powf(-3.25 + 1.25 * random.next());
                for (v, u) in state.u.iter_mut().enumerate() {
                    if system.coordinates.kinds[v] == tegula::element::VectorKind::Position {
                        *u = std::array::from_fn(|_| size * random.next());
                    }
                }
                let residual = tegula::analysis::equilibrium::residual(&system, &state);
                let largest = tegula::norm::max_norm(residual);
                assert!(
                    largest > 0.0 && largest.is_finite(),
                    "{element:?} {hardening} {number} {size:e}: {largest}"
                );
            }
        }
    }
}
