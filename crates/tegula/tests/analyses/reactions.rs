//! Reactions, resultants of loads and their balance against closed forms.

use crate::common;
use crate::common::{compile, model, on, plate, vector_load};
use tegula::analysis::{Observer, State, Step, dynamics, statics};
use tegula::model::*;
use tegula::norm::max_norm;
use tegula::result::{Equilibrium, ReactionFinder};
use tegula::{System, Vec3};

const ELEMENTS: [ElementKind; 4] =
    [ElementKind::Ems, ElementKind::Mitc4, ElementKind::Cm, ElementKind::SolidShell];

/// Finds the forces of every step.
struct Recorder<'a> {
    system: &'a System,
    finder: ReactionFinder,
    last: Option<State>,
    found: Vec<(State, Equilibrium)>,
    /// Work of loads and prescribed motions, and strain energy.
    energies: Vec<(f64, f64)>,
}

impl<'a> Recorder<'a> {
    fn new(system: &'a System, scheme: Option<Scheme>) -> Self {
        let finder = ReactionFinder::new(system, scheme);
        Self { system, finder, last: None, found: Vec::new(), energies: Vec::new() }
    }
}

impl Observer for Recorder<'_> {
    fn on_step(&mut self, step: &Step) -> tegula::Result<()> {
        let forces = self.finder.find(self.system, self.last.as_ref(), step.state);
        self.found.push((step.state.clone(), forces));
        self.energies.push((step.balance.work - step.balance.potential, step.balance.strain));
        self.last = Some(step.state.clone());
        Ok(())
    }
}

fn close(found: Vec3, expected: Vec3, tolerance: f64) {
    let error = (found - expected).norm();
    assert!(error <= tolerance * expected.norm(), "{found:?} for {expected:?}");
}

/// A strip along x, clamped at x = 0.
fn cantilever(element: ElementKind, linear: bool) -> Model {
    let mut m = model(plate([2.0, 0.5], [8, 2], 0.0), 1e6, 0.05);
    m.sections[0].element = element;
    m.analysis = Analysis::Static(StaticAnalysis { linear, ..StaticAnalysis::default() });
    m
}

fn equilibrium(m: &Model) -> (System, State, Equilibrium, (f64, f64)) {
    let (_, system) = compile(m);
    let mut recorder = Recorder::new(&system, None);
    statics::run(&system, &common::static_options(m), None, &mut recorder).unwrap();
    let (state, forces) = recorder.found.pop().unwrap();
    let energies = recorder.energies.pop().unwrap();
    (system, state, forces, energies)
}

/// A cantilever of a natural curvature rolls up without stress: all its forces are round-off, and do not count as an imbalance.
#[test]
fn a_strip_that_follows_its_natural_curvature_is_in_balance() {
    for element in ELEMENTS {
        for linear in [false, true] {
            let mut m = cantilever(element, linear);
            m.prescribed_strains = vec![common::natural([0.0; 3], [0.1, 0.0, 0.0], None)];
            let (_, _, forces, _) = equilibrium(&m);
            let bending = 1e6 * 0.05_f64.powi(3) / 12.0 * 0.1 * 0.5;
            assert!(forces.supports[0].moment.norm() <= 1e-8 * bending, "{element:?}: {forces:?}");
            assert!(forces.force_error <= 1e-8 && forces.moment_error <= 1e-8, "{element:?}: {forces:?}");
        }
    }
}

/// Force and moment at the clamp of a cantilever under a load at its tip: −F and −r × F; moments of directors count.
#[test]
fn clamp_of_a_cantilever_takes_force_and_moment() {
    for element in ELEMENTS {
        let mut m = cantilever(element, true);
        m.loads = vec![Load::Edge(vector_load("u_max", [3.0, 1.0, -0.2]))];
        let (system, _, forces, _) = equilibrium(&m);
        let load = Vec3::new(3.0, 1.0, -0.2) * 0.5;
        assert_eq!((system.support_sets.len(), system.support_sets[0].name.as_str()), (1, "u_min"));
        close(system.support_sets[0].about, Vec3::new(0.0, 0.25, 0.0), 1e-12);
        close(forces.supports[0].force, -load, 1e-8);
        close(forces.supports[0].moment, -Vec3::new(2.0, 0.0, 0.0).cross(&load), 1e-8);
        close(forces.loads[0].force, load, 1e-12);
        assert!(forces.loads[0].moment.norm() <= 1e-12 * load.norm());
        assert!(forces.force_error <= 1e-9 && forces.moment_error <= 1e-9, "{forces:?}");
    }
}

/// Bent far, the arm is the present one; edge moments and pressure are balanced, too.
#[test]
fn reactions_balance_loads_on_the_deformed_shell() {
    for element in ELEMENTS {
        let mut m = cantilever(element, false);
        // Without lateral contraction directors stay across the edge moment, of which nothing is lost.
        m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(1e6, 0.0, 1.0)));
        m.loads = vec![
            Load::Edge(vector_load("u_max", [0.0, 0.0, -1.5])),
            Load::EdgeMoment(vector_load("u_max", [0.0, 0.5, 0.0])),
            Load::Pressure(PressureLoad {
                on: "all".into(),
                value: 0.2,
                amplitude: None,
                distribution: None,
            }),
        ];
        let (system, state, forces, _) = equilibrium(&m);
        let tip = max_norm(state.u.iter().map(|u| u[2]));
        assert!(tip > 0.3, "{tip}");
        let names: Vec<&str> = system.load_sets.iter().map(|s| s.name.as_str()).collect();
        assert_eq!(names, ["edge.u_max", "edge-moment.u_max", "pressure.all"]);
        let sum: Vec3 = forces.loads.iter().map(|l| l.force).sum();
        close(forces.supports[0].force, -sum, 1e-7);
        close(forces.loads[0].force, Vec3::new(0.0, 0.0, -0.75), 1e-12);
        close(forces.loads[1].moment, Vec3::new(0.0, 0.25, 0.0), 1e-9);
        let about = system.support_sets[0].about;
        let moment = |(i, l): (usize, &tegula::result::Resultant)| {
            l.moment + (system.load_sets[i].about - about).cross(&l.force)
        };
        let sum: Vec3 = forces.loads.iter().enumerate().map(moment).sum();
        close(forces.supports[0].moment, -sum, 1e-7);
        assert!(forces.force_error <= 1e-8 && forces.moment_error <= 1e-8, "{forces:?}");
    }
}

/// A quarter of a plate between planes of symmetry, one of them inclined, on a hinge: the hinge bears the pressure, and
/// nodes of two supports are counted once.
#[test]
fn supports_share_their_nodes() {
    for element in [ElementKind::Ems, ElementKind::Mitc4] {
        let mut m = cantilever(element, true);
        let s = std::f64::consts::FRAC_1_SQRT_2;
        m.mesh = MeshSource::Plate(PlateMesh {
            origin: [0.0; 3],
            u_axis: [s, s, 0.0],
            v_axis: [-s, s, 0.0],
            size: [2.0, 1.0],
            grid: Grid::uniform(4, 3),
        });
        let symmetry = |set: &str, normal| Condition::Symmetry(SymmetryPlane { on: set.into(), normal });
        m.conditions = vec![
            symmetry("u_min", [s, s, 0.0]),
            symmetry("v_min", [-s, s, 0.0]),
            Condition::Hinge(on("v_max")),
        ];
        m.loads = vec![Load::Pressure(PressureLoad {
            on: "all".into(),
            value: 3.0,
            amplitude: None,
            distribution: None,
        })];
        let (system, _, forces, _) = equilibrium(&m);
        let names: Vec<&str> = system.support_sets.iter().map(|s| s.name.as_str()).collect();
        assert_eq!(names, ["u_min", "v_min", "v_max"]);
        close(forces.loads[0].force, Vec3::new(0.0, 0.0, -6.0), 1e-12);
        close(forces.supports[2].force, Vec3::new(0.0, 0.0, 6.0), 1e-8);
        // The plane at the middle takes the moment of the pressure about the hinge: p b · a²/2 about the u axis.
        let about = system.support_sets[1].about;
        close(forces.supports[1].moment, Vec3::new(s, s, 0.0) * -3.0, 1e-6);
        assert!((about - Vec3::new(s, s, 0.0)).norm() <= 1e-12);
        assert!(forces.force_error <= 1e-9 && forces.moment_error <= 1e-9, "{forces:?}");
    }
}

/// A strip pulled by a prescribed displacement: force E A ε, work of the motion equal to the strain energy.
#[test]
fn prescribed_motions_do_the_work_of_the_strain_energy() {
    for (element, linear) in ELEMENTS.into_iter().flat_map(|e| [(e, true), (e, false)]) {
        let mut m = cantilever(element, linear);
        m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(1e6, 0.0, 1.0)));
        let motion = |component, value| {
            let of = NodalVector::Position;
            Condition::Prescribe(PrescribeComponent {
                on: "u_max".into(),
                of,
                component,
                value,
                amplitude: None,
            })
        };
        m.conditions.extend([motion(Axis::X, 1e-3), motion(Axis::Z, 2e-3)]);
        let steps = if linear { 1 } else { 20 };
        m.analysis =
            Analysis::Static(StaticAnalysis { linear, load_steps: steps, ..StaticAnalysis::default() });
        let (_, _, forces, (work, strain)) = equilibrium(&m);
        let pull = 1e6 * 0.05 * 0.5 * 1e-3 / 2.0;
        let (clamp, moved) = (forces.supports[0].force, forces.supports[1].force);
        assert!((moved.x / pull - 1.0).abs() <= if linear { 1e-8 } else { 0.01 }, "{moved:?} {pull}");
        close(clamp, -moved, 1e-7);
        let tolerance = if linear { 1e-9 } else { 1e-4 };
        assert!((work / strain - 1.0).abs() <= tolerance, "{element:?} {linear}: {work} for {strain}");
        assert!(forces.force_error <= 1e-8 && forces.moment_error <= 1e-8, "{forces:?}");
    }
}

/// A stiff plate hinged at an edge falls from the horizontal. At the angle θ below it the pivot takes 5/2 m g sin θ
/// along the plate and 1/4 m g cos θ across it, as that of a uniform rod.
#[test]
fn pivot_of_a_falling_plate_takes_the_force_of_a_rod() {
    let mut m = model(plate([1.0, 0.2], [6, 1], 0.0), 2.1e11, 0.05);
    m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(2.1e11, 0.3, 7850.0)));
    m.conditions = vec![Condition::Hinge(on("u_min"))];
    m.loads = vec![Load::Gravity(GravityLoad { value: [0.0, 0.0, -9.81], amplitude: None })];
    let options = TransientAnalysis {
        scheme: Scheme::Hht(HhtScheme { alpha: -0.3 }),
        time_step: Some(2e-3),
        ..TransientAnalysis::new(0.42)
    };
    m.analysis = Analysis::Transient(options.clone());
    let (mesh, system) = compile(&m);
    let mut recorder = Recorder::new(&system, Some(options.scheme));
    dynamics::run(&system, &options, None, &mut recorder).unwrap();
    let weight = system.total_mass() * 9.81;
    let mut angles = 0;
    for (state, forces) in recorder.found.iter().filter(|(s, _)| s.time > 0.2) {
        let tip = Vec3::x() + common::displacement(&mesh, &system, &state.u, "u_max_v_min");
        let theta = (-tip.z).atan2(tip.x);
        let (along, across) =
            (Vec3::new(theta.cos(), 0.0, -theta.sin()), Vec3::new(theta.sin(), 0.0, theta.cos()));
        let expected = along * (-2.5 * theta.sin()) + across * (0.25 * theta.cos());
        let found = forces.supports[0].force / weight;
        assert!((found - expected).norm() <= 0.05, "{theta}: {found:?} for {expected:?}");
        assert!(forces.force_error <= 1e-6, "{forces:?}");
        angles += 1;
    }
    assert!(angles > 50);
}

/// Loads, reactions, inertia and damping balance in every step of every scheme, where its equation holds.
#[test]
fn moving_shells_are_in_balance() {
    for (scheme, element, tolerance) in [
        (Scheme::Newmark(NewmarkScheme { beta: 0.25, gamma: 0.5 }), ElementKind::Ems, 1e-5),
        (Scheme::Newmark(NewmarkScheme { beta: 0.25, gamma: 0.5 }), ElementKind::Mitc4, 1e-5),
        (Scheme::EnergyMomentum(Default::default()), ElementKind::Ems, 1e-8),
        (Scheme::Explicit(ExplicitScheme { scale_director_inertia: true }), ElementKind::Ems, 1e-8),
    ] {
        let mut m = cantilever(element, false);
        m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(1e6, 0.3, 1e3)));
        m.damping.mass = 0.3;
        let lift = PrescribeComponent {
            on: "u_min".into(),
            of: NodalVector::Position,
            component: Axis::Z,
            value: 0.1,
            amplitude: Some("lift".into()),
        };
        m.amplitudes.insert(
            "lift".into(),
            Amplitude::Expression(ExpressionAmplitude { expression: "sin(3*t)".into() }),
        );
        let fixed = FixComponents {
            on: "u_min".into(),
            position: vec![Axis::X, Axis::Y],
            director: vec![Axis::X, Axis::Y],
        };
        m.conditions = vec![Condition::Prescribe(lift), Condition::Fix(fixed)];
        m.loads = vec![
            Load::Gravity(GravityLoad { value: [0.0, 0.0, -9.81], amplitude: None }),
            Load::Pressure(PressureLoad {
                on: "all".into(),
                value: 20.0,
                amplitude: None,
                distribution: None,
            }),
        ];
        let options = TransientAnalysis { scheme, max_step: Some(2e-3), ..TransientAnalysis::new(0.3) };
        m.analysis = Analysis::Transient(options.clone());
        let (_, system) = compile(&m);
        let mut recorder = Recorder::new(&system, Some(scheme));
        dynamics::run(&system, &options, None, &mut recorder).unwrap();
        assert!(recorder.found.len() > 10);
        for (state, forces) in &recorder.found {
            let (force, moment) = (forces.force_error, forces.moment_error);
            assert!(
                force <= tolerance && moment <= tolerance,
                "{scheme:?} {}: {force:e} {moment:e}",
                state.time
            );
            assert!(forces.supports[0].force.norm() > 1.0);
        }
    }
}

/// Reactions of HHT are forces between the ends of a step, each with the plastic strains of its end.
#[test]
#[ignore = "long"]
fn reactions_of_hht_balance_while_materials_yield() {
    for element in ELEMENTS {
        let mut m = cantilever(element, false);
        m.materials.insert(
            "m".into(),
            Material::Plastic(Plastic {
                young: 1e6,
                poisson: 0.3,
                yield_stress: 2e3,
                hardening: 1e4,
                saturation: None,
                saturation_rate: 0.0,
                kinematic: 0.0,
                density: 1e3,
                expansion: 0.0,
            }),
        );
        m.loads = vec![Load::Edge(vector_load("u_max", [200.0, 0.0, 0.0]))];
        let scheme = Scheme::Hht(HhtScheme { alpha: -0.3 });
        let options = TransientAnalysis { scheme, time_step: Some(2e-3), ..TransientAnalysis::new(0.08) };
        m.analysis = Analysis::Transient(options.clone());
        let (_, system) = compile(&m);
        let mut recorder = Recorder::new(&system, Some(scheme));
        let outcome = dynamics::run(&system, &options, None, &mut recorder).unwrap();
        assert!(
            outcome.state.dissipated > 0.05 * outcome.balance.strain,
            "{element:?}: {:?}",
            outcome.balance
        );
        for (state, forces) in &recorder.found[1..] {
            let error = forces.force_error;
            assert!(error < 1e-6, "{element:?} at {}: {error:e}", state.time);
        }
    }
}

/// A bar that has yielded in both directions is free of forces: what is left is the round-off of stresses, and no imbalance of forces.
#[test]
fn an_unloaded_bar_with_plastic_strains_is_in_balance() {
    for element in [ElementKind::Cm, ElementKind::SolidShell] {
        let mut m = model(plate([1.0, 0.1], [2, 1], 0.0), 200e9, 0.01);
        m.sections[0].element = element;
        m.materials.insert(
            "m".into(),
            Material::Plastic(Plastic {
                young: 200e9,
                poisson: 0.3,
                yield_stress: 250e6,
                hardening: 2e9,
                saturation: None,
                saturation_rate: 0.0,
                kinematic: 0.0,
                density: 7800.0,
                expansion: 0.0,
            }),
        );
        let fixed = |set: &str, component| {
            Condition::Fix(FixComponents { on: set.into(), position: vec![component], director: Vec::new() })
        };
        m.conditions = vec![fixed("u_min", Axis::X), fixed("all", Axis::Z), fixed("v_min", Axis::Y)];
        m.loads = vec![Load::Edge(VectorLoad {
            amplitude: Some("a".into()),
            ..vector_load("u_max", [3e6, 0.0, 0.0])
        })];
        let table = TableAmplitude {
            times: vec![0.0, 0.25, 0.5, 0.75, 1.0],
            values: vec![0.0, 1.0, 0.0, -0.87, 0.0],
        };
        m.amplitudes.insert("a".into(), Amplitude::Table(table));
        m.analysis = Analysis::Static(StaticAnalysis { load_steps: 20, ..StaticAnalysis::default() });
        let (_, _, forces, _) = equilibrium(&m);
        assert!(forces.force_error < 1e-6 && forces.moment_error < 1e-6, "{element:?}: {forces:?}");
    }
}
