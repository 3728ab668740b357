//! Linear buckling: closed solutions for columns, strips, plates, rings, cylinders and mechanisms; preload, units, refusals.

use std::f64::consts::PI;

use crate::common::{compile, cylinder, on, plate, vector_load};
use tegula::analysis::buckling::{self, BucklingMode, BucklingOutcome};
use tegula::analysis::{Silent, statics};
use tegula::compile::{Compiler, build};
use tegula::mesh::generators::generate;
use tegula::model::*;
use tegula::norm::larger;
use tegula::system::VectorKind;
use tegula::{Error, Result, System};

pub const YOUNG: f64 = 2e7;

/// A flat strip in the plane z = 0 along x of Poisson's ratio 0, compressed by the force 1 at its end.
#[derive(Clone, Copy)]
struct Strip {
    length: f64,
    width: f64,
    thickness: f64,
    young: f64,
}

impl Strip {
    /// L/h = 10.
    const STOUT: Self = Self { length: 1.0, width: 0.2, thickness: 0.1, young: YOUNG };
    /// L/h = 200.
    const SLENDER: Self = Self { length: 1.0, width: 0.1, thickness: 0.005, young: YOUNG };

    /// Clamped at x = 0, free at the loaded end.
    fn model(&self, elements: [u32; 2], element: ElementKind) -> Model {
        let analysis = Analysis::Buckling(BucklingAnalysis::new(1));
        let mesh = plate([self.length, self.width], elements, 0.0);
        let mut m = Model::new(mesh, analysis, Isotropic::new(self.young, 0.0, 1.0), self.thickness);
        m.sections[0].element = element;
        m.conditions = vec![Condition::Clamp(on("u_min"))];
        m.loads = vec![self.end_load(1.0)];
        m
    }

    /// Compression by a force at the end.
    fn end_load(&self, force: f64) -> Load {
        Load::Edge(vector_load("u_max", [-force / self.width, 0.0, 0.0]))
    }

    /// Between two hinges, one of which moves along x.
    fn between_hinges(&self, elements: [u32; 2], element: ElementKind) -> Model {
        let mut m = self.model(elements, element);
        m.conditions = vec![Condition::Hinge(on("u_min")), guided("u_max", &[Axis::Y, Axis::Z])];
        m
    }

    fn bending(&self) -> f64 {
        self.young * self.width * self.thickness.powi(3) / 12.0
    }

    fn stretching(&self) -> f64 {
        self.young * self.width * self.thickness
    }

    /// Load of a column of a buckling length by F. Engesser, *Die Knickfestigkeit gerader Stäbe*, Centralblatt der Bauverwaltung 11
    /// (1891) 483–486: 1/P = 1/P_E + 1/(κ G A), with the factor κ = 5/6 of the sections.
    fn engesser(&self, length: f64) -> f64 {
        let euler = PI * PI * self.bending() / (length * length);
        euler / (1.0 + euler / (5.0 / 6.0 * 0.5 * self.stretching()))
    }
}

fn guided(set: &str, axes: &[Axis]) -> Condition {
    Condition::Fix(FixComponents { on: set.into(), position: axes.to_vec(), director: Vec::new() })
}

fn moved(set: &str, value: f64) -> Condition {
    Condition::Prescribe(PrescribeComponent {
        on: set.into(),
        of: NodalVector::Position,
        component: Axis::X,
        value,
        amplitude: None,
    })
}

fn run(system: &System, analysis: &Analysis) -> Result<BucklingOutcome> {
    let Analysis::Buckling(options) = analysis else { panic!("no buckling analysis") };
    buckling::run(system, options, &mut Silent)
}

pub fn modes(m: &Model) -> Vec<BucklingMode> {
    let found = run(&compile(m).1, &m.analysis).unwrap();
    assert!(found.sturm_checked);
    found.modes
}

pub fn factors(m: &Model) -> Vec<f64> {
    modes(m).into_iter().map(|mode| mode.factor).collect()
}

/// Extrapolates the lowest factor of two meshes, the second of which is twice as fine: the error of bilinear elements is of second order.
pub fn extrapolated(model: impl Fn(u32) -> Model, n: u32) -> f64 {
    let [coarse, fine] = [n, 2 * n].map(|n| factors(&model(n))[0]);
    fine + (fine - coarse) / 3.0
}

pub fn message(m: &Model) -> String {
    run(&compile(m).1, &m.analysis).unwrap_err().to_string()
}

#[test]
fn columns_with_shear_flexibility_buckle_as_engesser_says() {
    let strip = Strip::STOUT;
    for element in [ElementKind::Ems, ElementKind::Mitc4] {
        let clamped = extrapolated(|n| strip.model([n, 2], element), 32);
        let hinged = extrapolated(|n| strip.between_hinges([n, 2], element), 32);
        assert!((clamped / strip.engesser(2.0) - 1.0).abs() < 1e-7, "{element:?} {clamped}");
        assert!((hinged / strip.engesser(1.0) - 1.0).abs() < 1e-6, "{element:?} {hinged}");
    }
    // Strains quadratic in z let the stress act on the curvature, too, which lowers the bending stiffness EI by P I/A at most.
    for element in [ElementKind::Cm, ElementKind::SolidShell, ElementKind::AncfFull] {
        let clamped = extrapolated(|n| strip.model([n, 2], element), 32);
        let lower = 1.0 - clamped / strip.engesser(2.0);
        assert!(lower > 0.0 && lower < clamped / strip.stretching(), "{element:?} {lower}");
    }
}

/// Modes of a column between hinges: factors n² within the shear flexibility, sines, largest displacement 1.
#[test]
fn higher_modes_of_a_column_are_sines() {
    let strip = Strip::SLENDER;
    let mut m = strip.between_hinges([128, 1], ElementKind::Ems);
    m.analysis = Analysis::Buckling(BucklingAnalysis::new(3));
    let (_, system) = compile(&m);
    let found = run(&system, &m.analysis).unwrap().modes;
    assert_eq!(found.len(), 3);
    for (i, mode) in found.iter().enumerate() {
        let half_waves = (i + 1) as f64;
        let expected = strip.engesser(1.0 / half_waves);
        assert!((mode.factor / expected - 1.0).abs() < 3e-3, "{i} {} {expected}", mode.factor);
        assert!(mode.residual <= 1e-8);
        let (mut largest, mut error) = (0.0, 0.0);
        for (v, kind) in system.coordinates.kinds.iter().enumerate() {
            if *kind != VectorKind::Position {
                continue;
            }
            let x = system.coordinates.reference[v][0];
            let [ux, uy, uz] = mode.shape[v];
            let sine = (half_waves * PI * x).sin();
            error = larger(error, ux.abs() + uy.abs() + (uz.abs() - sine.abs()).abs());
            largest = larger(largest, uz.abs());
        }
        assert!((largest - 1.0).abs() < 1e-12 && error < 1e-4, "{i} {largest} {error}");
    }
}

/// Heated or shortened between supports that do not move, a strip has the compression EA α T, or EA δ/L.
#[test]
fn prescribed_strains_and_displacements_are_loads() {
    let strip = Strip::SLENDER;
    let by_force = factors(&strip.between_hinges([32, 1], ElementKind::Ems))[0] / strip.stretching();
    let mut heated = strip.between_hinges([32, 1], ElementKind::Ems);
    heated.conditions = vec![Condition::Hinge(on("u_min")), Condition::Hinge(on("u_max"))];
    heated.loads.clear();
    let mut material = Isotropic::new(YOUNG, 0.0, 1.0);
    material.expansion = 1e-5;
    heated.materials.insert("m".into(), Material::Isotropic(material));
    heated.prescribed_strains = vec![PrescribedStrain::Thermal(ThermalStrain {
        distribution: None,
        on: "all".into(),
        temperature: 2.0,
        gradient: 0.0,
        amplitude: None,
    })];
    let by_heat = factors(&heated)[0] * 2e-5;
    let mut shortened = strip.between_hinges([32, 1], ElementKind::Ems);
    shortened.loads.clear();
    shortened.conditions.push(moved("u_max", -1e-3));
    let by_motion = factors(&shortened)[0] * 1e-3;
    assert!((by_motion / by_force - 1.0).abs() < 1e-8, "{by_motion} {by_force}");
    assert!((by_heat / by_force - 1.0).abs() < 1e-8, "{by_heat} {by_force}");
}

/// Lateral buckling of a cantilever of narrow rectangular section under a force at the centroid of its end, S. P. Timoshenko and J. M. Gere, *Theory of
/// Elastic Stability*, 2nd ed. (1961), sect. 6.3: P = 4.013 √(EI GJ)/L². Torsion of a strip by the theory of Reissner and Mindlin has
/// GJ = G (b t³/3)(1 − tanh x/x), x = √10 b/(2t). The twist φ satisfies GJ φ'' + P² (L − x)²/EI φ = 0; at the clamp, which prevents warping, it is that
/// of a length shorter by √(E C_w/GJ), with C_w = b³ t³/144 (V. Z. Vlasov, *Thin-walled elastic beams*, 1961): 0.8 % of the load.
#[test]
fn a_cantilever_strip_buckles_laterally() {
    let strip = Strip { length: 1.0, width: 0.02, thickness: 0.001, young: YOUNG };
    // The shear stresses turn round at the edges within a third of the thickness.
    let lowest = |n: u32| {
        let mut m = strip.model([n, 24], ElementKind::Ems);
        m.loads = vec![Load::Edge(vector_load("u_max", [0.0, -1.0 / strip.width, 0.0]))];
        let mut mesh = generate(&m.mesh).unwrap();
        for x in &mut mesh.positions {
            x[1] = 0.5 * strip.width * (1.0 - (PI * x[1] / strip.width).cos());
        }
        let system = build(&m, &mesh).unwrap();
        run(&system, &m.analysis).unwrap().modes[0].factor
    };
    let x = 10_f64.sqrt() * strip.width / (2.0 * strip.thickness);
    let torsion = 0.5 * YOUNG * strip.width * strip.thickness.powi(3) / 3.0 * (1.0 - x.tanh() / x);
    let warping = YOUNG * (strip.width * strip.thickness).powi(3) / 144.0;
    let length = strip.length - (warping / torsion).sqrt();
    let expected = 4.0126 * (strip.bending() * torsion).sqrt() / (length * length);
    let [coarse, fine] = [32, 64].map(lowest);
    let found = fine + (fine - coarse) / 3.0;
    assert!((found / expected - 1.0).abs() < 1e-3, "{found} {expected}");
}

/// Simply supported square plate under compression in one direction: N = 4 π² D/b² of thin plates (G. H. Bryan, Proc. London Math. Soc. 22
/// (1890) 54–67), and N = 4 π² D/b² / (1 + 2 π² D/(b² κ G h)) by the theory of Mindlin, from the deflection sin πx/b sin πy/b.
#[test]
fn a_square_plate_under_compression_buckles_as_thin_and_as_shear_flexible_plates_do() {
    let side = 1.0;
    for (thickness, element) in
        [(0.01, ElementKind::Ems), (0.05, ElementKind::Ems), (0.05, ElementKind::Mitc4)]
    {
        let model = |n: u32| {
            let analysis = Analysis::Buckling(BucklingAnalysis::new(1));
            let mesh = plate([side, side], [n, n], 0.0);
            let mut m = Model::new(mesh, analysis, Isotropic::new(YOUNG, 0.3, 1.0), thickness);
            m.sections[0].element = element;
            let support = |set: &str, position: &[Axis], director: Axis| {
                Condition::Fix(FixComponents {
                    on: set.into(),
                    position: position.to_vec(),
                    director: vec![director],
                })
            };
            m.conditions = vec![
                support("u_min", &[Axis::X, Axis::Z], Axis::Y),
                support("u_max", &[Axis::Z], Axis::Y),
                support("v_min", &[Axis::Y, Axis::Z], Axis::X),
                support("v_max", &[Axis::Z], Axis::X),
            ];
            m.loads = vec![Load::Edge(vector_load("u_max", [-1.0, 0.0, 0.0]))];
            m
        };
        let bending = YOUNG * thickness.powi(3) / (12.0 * (1.0 - 0.09));
        let shear = 5.0 / 6.0 * YOUNG / 2.6 * thickness;
        let thin = 4.0 * PI * PI * bending / (side * side);
        let expected = thin / (1.0 + 2.0 * PI * PI * bending / (side * side * shear));
        let found = extrapolated(model, 16);
        assert!((found / expected - 1.0).abs() < 2e-5, "{thickness} {element:?} {found} {expected}");
    }
}

/// Quarter of a ring of radius 1 and thickness 0.01 under pressure, with planes of symmetry.
pub fn ring(n: u32) -> Model {
    let (radius, thickness, width) = (1.0, 0.01, 0.1);
    let mesh = cylinder(radius, [0.0, 90.0], width, [n, 1]);
    let analysis = Analysis::Buckling(BucklingAnalysis::new(1));
    let mut m = Model::new(mesh, analysis, Isotropic::new(YOUNG, 0.0, 1.0), thickness);
    let plane = |set: &str, normal: [f64; 3]| Condition::Symmetry(SymmetryPlane { on: set.into(), normal });
    m.conditions = vec![
        plane("u_min", [1.0, 0.0, 0.0]),
        plane("u_max", [0.0, 0.0, 1.0]),
        plane("v_min", [0.0, 1.0, 0.0]),
        plane("v_max", [0.0, 1.0, 0.0]),
    ];
    m.loads = vec![Load::Pressure(PressureLoad {
        on: "all".into(),
        value: 1.0,
        amplitude: None,
        distribution: None,
    })];
    m
}

/// A long tube under outer pressure, which follows the motion: p = 3 EI/R³ per length (M. Lévy, J. Math. Pures Appl. 10 (1884) 5–42; Timoshenko and
/// Gere, sect. 7.3). A load of constant direction would give 4 EI/R³. A quarter of a ring, whose mode has two waves.
#[test]
fn a_ring_buckles_under_pressure_that_follows_it() {
    let (radius, thickness) = (1.0_f64, 0.01_f64);
    let expected = 3.0 * YOUNG * thickness.powi(3) / 12.0 / radius.powi(3);
    let found = extrapolated(ring, 32);
    assert!((found / expected - 1.0).abs() < 2e-4, "{found} {expected}");
}

/// A cylinder under axial compression, R/h = 100, L/R = 2: lowest load E h²/(R √(3(1 − ν²))) per length of the edge (R. Lorenz, Phys. Z. 12 (1911) 241–260;
/// Timoshenko and Gere, sect. 11.1). Its ends move along the axis as wholes and are free to widen, so that the stress is uniform; a
/// quarter with planes of symmetry has the modes of even numbers of waves.
#[test]
#[ignore = "long"]
fn a_cylinder_buckles_under_axial_compression() {
    let (radius, thickness, length) = (1.0, 0.01, 2.0);
    let mesh = cylinder(radius, [0.0, 90.0], length, [40, 80]);
    let analysis = Analysis::Buckling(BucklingAnalysis::new(3));
    let mut m = Model::new(mesh, analysis, Isotropic::new(YOUNG, 0.3, 1.0), thickness);
    let plane = |set: &str, normal: [f64; 3]| Condition::Symmetry(SymmetryPlane { on: set.into(), normal });
    m.conditions = vec![
        plane("u_min", [1.0, 0.0, 0.0]),
        plane("u_max", [0.0, 0.0, 1.0]),
        plane("v_min", [0.0, 1.0, 0.0]),
        Condition::Fix(FixComponents { on: "v_max".into(), position: Vec::new(), director: vec![Axis::Y] }),
        Condition::Prescribe(PrescribeComponent {
            on: "v_max".into(),
            of: NodalVector::Position,
            component: Axis::Y,
            value: -1e-3 * length,
            amplitude: None,
        }),
    ];
    let expected = YOUNG * thickness * thickness / (radius * (3.0 * 0.91_f64).sqrt());
    for factor in factors(&m) {
        let load = factor * 1e-3 * YOUNG * thickness;
        assert!((load / expected - 1.0).abs() < 0.02, "{load} {expected}");
    }
    // Simply supported ends: the load acts on them, and they do not widen.
    m.conditions.truncate(2);
    m.conditions.push(guided("v_min", &[Axis::X, Axis::Y, Axis::Z]));
    m.conditions.push(guided("v_max", &[Axis::X, Axis::Z]));
    m.loads = vec![Load::Edge(vector_load("v_max", [0.0, -1.0, 0.0]))];
    for factor in factors(&m) {
        assert!((factor / expected - 1.0).abs() < 0.01, "{factor} {expected}");
    }
}

/// Lengths and forces in other units.
#[test]
fn factors_do_not_depend_on_units() {
    let base = Strip::SLENDER;
    let scaled = Strip { length: 1e3, width: 100.0, thickness: 5.0, young: 1e9 * YOUNG };
    let of = |strip: &Strip, force: f64| {
        let mut m = strip.model([24, 2], ElementKind::Ems);
        m.loads = vec![strip.end_load(force)];
        m.analysis = Analysis::Buckling(BucklingAnalysis::new(3));
        factors(&m)
    };
    for (a, b) in of(&base, 1.0).into_iter().zip(of(&scaled, 1e15)) {
        assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
    }
}

/// Outcome of the last step of a model, after the static ones before.
fn last_step(m: &Model) -> Result<BucklingOutcome> {
    let mesh = generate(&m.mesh)?;
    let compiler = Compiler::new(m, &mesh)?;
    let mut start = None;
    for (i, step) in compiler.steps().iter().enumerate() {
        let system = compiler.system(i, start.clone())?;
        match &step.model.analysis {
            Analysis::Static(options) => {
                let outcome = statics::run(&system, options, None, &mut Silent)?;
                start = Some(outcome.state.end_of_step());
            }
            analysis => return run(&system, analysis),
        }
    }
    panic!("no buckling step")
}

fn preloaded(strip: &Strip, preload: f64, options: StaticAnalysis) -> Model {
    let mut m = strip.model([32, 1], ElementKind::Ems);
    m.loads.clear();
    let preload = AnalysisStep {
        loads: vec![strip.end_load(preload)],
        ..AnalysisStep::new("preload", Analysis::Static(options))
    };
    let buckling = AnalysisStep {
        loads: vec![strip.end_load(1.0)],
        ..AnalysisStep::new("buckling", Analysis::Buckling(BucklingAnalysis::new(1)))
    };
    m.steps = vec![preload, buckling];
    m
}

/// Factor of a load beside a preload: the rest of the critical load. The column has shortened by P/EA = 5e-6 at most.
#[test]
fn a_preload_leaves_the_rest_of_the_critical_load() {
    let strip = Strip::SLENDER;
    let total = factors(&strip.model([32, 1], ElementKind::Ems))[0];
    for part in [0.4, -0.5] {
        let m = preloaded(&strip, part * total, StaticAnalysis::default());
        let found = last_step(&m).unwrap().modes[0].factor;
        assert!(((found + part * total) / total - 1.0).abs() < 1e-5, "{found} {total}");
    }
    // A load equal to that of the step before counts once more.
    let mut m = preloaded(&strip, 0.4 * total, StaticAnalysis::default());
    m.steps[1].loads = m.steps[0].loads.clone();
    let found = last_step(&m).unwrap().modes[0].factor;
    assert!((found / 1.5 - 1.0).abs() < 1e-5, "{found}");
}

/// A strip that is shortened in its base state and shortened further by the buckling step: u₀ + λ (u₁ − u₀) is the critical displacement P L/EA.
#[test]
fn a_motion_goes_on_from_that_of_the_base_state() {
    let strip = Strip::SLENDER;
    let critical = factors(&strip.model([32, 1], ElementKind::Ems))[0] / strip.stretching() * strip.length;
    for [first, last] in [[0.3, 0.8], [0.5, 0.6], [-0.4, 1.0]].map(|pair| pair.map(|part| part * critical)) {
        let mut m = preloaded(&strip, 0.0, StaticAnalysis::default());
        for (step, end) in m.steps.iter_mut().zip([first, last]) {
            step.loads.clear();
            step.conditions = vec![moved("u_max", -end)];
        }
        let expected = (critical - first) / (last - first);
        let found = last_step(&m).unwrap().modes[0].factor;
        assert!((found / expected - 1.0).abs() < 1e-4, "{first} {last}: {found} {expected}");
    }
    let mut m = preloaded(&strip, 0.0, StaticAnalysis::default());
    m.steps[0].conditions = vec![guided("u_max", &[Axis::X])];
    m.steps[1].conditions = vec![moved("u_max", -0.5 * critical)];
    let error = last_step(&m).unwrap_err().to_string();
    let named =
        error.contains("steps[1].conditions[0]") && error.contains("which steps[0].conditions[0] supports");
    assert!(named, "{error}");
}

#[test]
fn an_unstable_base_state_is_refused() {
    let strip = Strip::SLENDER;
    let total = factors(&strip.model([32, 1], ElementKind::Ems))[0];
    let options = StaticAnalysis { allow_unstable: true, ..StaticAnalysis::default() };
    let error = last_step(&preloaded(&strip, 1.5 * total, options)).unwrap_err().to_string();
    assert!(
        error.contains("The base state is unstable") && error.contains("1 negative eigenvalue"),
        "{error}"
    );
}

#[test]
fn loads_that_cannot_cause_buckling_are_refused() {
    let strip = Strip::SLENDER;
    let compressed = strip.model([16, 1], ElementKind::Ems);
    let lowest = factors(&compressed)[0];
    let pulled = Model { loads: vec![strip.end_load(-1.0)], ..compressed.clone() };
    let error = message(&pulled);
    assert!(
        error.contains("The loads stabilise the structure") && error.contains(&format!("{lowest:.4e}")[..5]),
        "{error}"
    );
    let both = BucklingAnalysis { factors: 2, signs: FactorSigns::Both };
    let reversed = factors(&Model { analysis: Analysis::Buckling(both), ..pulled });
    assert!((reversed[0] / -lowest - 1.0).abs() < 1e-9 && reversed.len() == 2, "{reversed:?}");
    let nothing = Model { loads: vec![strip.end_load(0.0)], ..compressed.clone() };
    assert!(message(&nothing).contains("are zero"), "{}", message(&nothing));
    // Forces on nodes that supports hold produce no stress.
    let held =
        Model { loads: vec![Load::Edge(vector_load("u_min", [-1.0, 0.0, 0.0]))], ..compressed.clone() };
    assert!(message(&held).contains("produce no stress"), "{}", message(&held));
    let free = Model { conditions: Vec::new(), ..compressed.clone() };
    assert!(message(&free).contains("moves freely in 6 way(s)"), "{}", message(&free));
    let pressed =
        Load::Pressure(PressureLoad { on: "all".into(), value: 1.0, amplitude: None, distribution: None });
    let pressed = Model { loads: vec![pressed], ..compressed };
    assert!(message(&pressed).contains("have no potential"), "{}", message(&pressed));
}

#[test]
fn mistakes_in_the_keys_are_found() {
    let strip = Strip::SLENDER;
    let issues = |m: &Model| {
        let mesh = generate(&m.mesh).unwrap();
        let Err(Error::Model(issues)) = Compiler::new(m, &mesh).map(|_| ()) else { panic!("no mistake") };
        issues.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
    };
    let mut m = strip.model([4, 1], ElementKind::Ems);
    m.analysis = Analysis::Buckling(BucklingAnalysis::new(0));
    m.loads.clear();
    let found = issues(&m);
    assert!(
        found.contains("analysis.factors") && found.contains("loads: a buckling analysis without"),
        "{found}"
    );
    let mut m = preloaded(&strip, 1.0, StaticAnalysis { linear: true, ..StaticAnalysis::default() });
    m.steps[1].loads.clear();
    let found = issues(&m);
    assert!(found.contains("steps[1].loads") && found.contains("steps[1].analysis.type"), "{found}");
}

/// A plate that is free to expand has no stress under uniform heating, but for round-off.
#[test]
fn strains_that_a_structure_follows_freely_are_refused() {
    let strip = Strip::SLENDER;
    let mut m = strip.model([8, 4], ElementKind::Ems);
    let fix = |on: &str, position: &[Axis]| {
        Condition::Fix(FixComponents { on: on.into(), position: position.to_vec(), director: Vec::new() })
    };
    m.conditions = vec![
        fix("u_min", &[Axis::X, Axis::Z]),
        fix("u_max", &[Axis::Z]),
        fix("v_min", &[Axis::Z]),
        fix("v_max", &[Axis::Z]),
        fix("u_min_v_min", &[Axis::Y]),
    ];
    m.loads.clear();
    m.prescribed_strains = vec![crate::common::natural([1e-3, 1e-3, 0.0], [0.0; 3], None)];
    assert!(message(&m).contains("produce no stress"), "{}", message(&m));
}
