//! Plates whose nodes all are attached to one body: the shell has a mass and carries loads, but its stiffness does not take part.

use crate::common::*;
use crate::multibody::{revolute, spring, torsion_spring};
use crate::patches::{fixed, gravity, hub};
use tegula::analysis::{modal, path};
use tegula::compile::warnings;
use tegula::model::*;
use tegula::result::reactions::ReactionFinder;
use tegula::{System, Vec3};

const MASS: f64 = 10.0;
const SPRING: f64 = 100.0;
const PRESSURE: f64 = 40.0;
const GRAVITY: f64 = 4.0;
const Y: [f64; 3] = [0.0, 1.0, 0.0];

/// A square plate with sides of 1 on a body.
fn plate_on_body(elements: u32, joint: Joint, load: Load) -> Model {
    let mesh = plate([1.0, 1.0], [elements; 2], 0.0);
    let material = Isotropic::new(2e9, 0.3, MASS / 0.01);
    let mut m = Model::new(mesh, Analysis::Static(StaticAnalysis::default()), material, 0.01);
    m.bodies = vec![hub("plate", [0.0, 0.5, 0.0], &["all"])];
    m.joints = vec![joint];
    m.loads = vec![load];
    m
}

fn hinged(elements: u32, load: Load) -> Model {
    let hinge = revolute("hinge", "ground", "plate", [0.0, 0.5, 0.0], Y);
    let spring = torsion_spring(["ground", "plate"], Y, SPRING);
    Model { torsion_springs: vec![spring], ..plate_on_body(elements, hinge, load) }
}

fn pressure() -> Load {
    Load::Pressure(PressureLoad { on: "all".into(), value: PRESSURE, amplitude: None, distribution: None })
}

/// Angle by which the plate hangs down.
fn angle(system: &System, u: &[[f64; 3]]) -> f64 {
    let axis = Vec3::x() + Vec3::from(u[system.coordinates.bodies[0].directors.unwrap()[0] as usize]);
    (-axis.z).atan2(axis.x)
}

/// Equilibrium angles, and the stiffnesses about the hinge there: the moment of a pressure is constant, that of the weight falls with the cosine.
fn equilibria() -> [(Load, f64, f64); 2] {
    let weight = 0.5 * MASS * GRAVITY;
    let mut hanging: f64 = 0.2;
    for _ in 0..50 {
        hanging = weight * hanging.cos() / SPRING;
    }
    [
        (pressure(), 0.5 * PRESSURE / SPRING, SPRING),
        (gravity([0.0, 0.0, -GRAVITY]), hanging, SPRING + weight * hanging.sin()),
    ]
}

#[test]
fn rigid_plates_on_hinges_hang_and_swing_as_rigid_bodies_do() {
    let inertia = MASS * (1.0 / 3.0 + 1e-4 / 12.0);
    for (load, exact, stiffness) in equilibria() {
        for elements in [1, 4] {
            let mut m = hinged(elements, load.clone());
            let (_, system, outcome) = solve(&m);
            let found = angle(&system, &outcome.state.u);
            assert!((found.abs() - exact).abs() < 1e-9, "{load:?} {elements}: {found} {exact}");

            let options = ModalAnalysis { prestressed: true, ..ModalAnalysis::new(1) };
            m.analysis = Analysis::Modal(options);
            let (_, system) = compile(&m);
            let state = modal::prestress(&system, &mut Notes::default()).unwrap().state;
            let modes = modal::run(&system, 1, Some(&state), &mut Notes::default()).unwrap();
            let exact_omega = (stiffness / inertia).sqrt();
            let error = modes.modes[0].omega / exact_omega - 1.0;
            assert!(error.abs() < 1e-8, "{load:?} {elements}: {error}");

            let options = PathAnalysis::default();
            m.analysis = Analysis::Path(options.clone());
            let (_, system) = compile(&m);
            let outcome = path::run(&system, &options, None, &mut Notes::default()).unwrap();
            let found = angle(&system, &outcome.state.u);
            assert!((found.abs() - exact).abs() < 1e-8, "{load:?} {elements}: {found} {exact}");
            assert!(outcome.state.path.as_ref().unwrap().critical.is_empty());
        }
    }
}

#[test]
fn rigid_plates_on_fixed_joints_hand_their_loads_to_the_joint() {
    for (load, force) in [(pressure(), PRESSURE), (gravity([0.0, 0.0, -GRAVITY]), MASS * GRAVITY)] {
        let m = plate_on_body(4, fixed("plate", [0.0, 0.5, 0.0]), load);
        let (_, system, outcome) = solve(&m);
        assert!(angle(&system, &outcome.state.u).abs() < 1e-12);
        let balance = ReactionFinder::new(&system, None).find(&system, None, &outcome.state);
        assert!(balance.force_error < 1e-12 && balance.moment_error < 1e-12, "{balance:?}");
        let multiplier = outcome.state.multipliers.iter().map(|x| x.abs()).fold(0.0, tegula::norm::larger);
        assert!((multiplier / force - 1.0).abs() < 1e-9, "{:?}", outcome.state.multipliers);
    }
}

/// A single node does not take a moment about its director; the body to which it is attached does.
#[test]
fn moments_on_attached_nodes_turn_their_body_about_every_axis() {
    for axis in [[1.0, 0.0, 0.0], [0.0, 0.6, 0.8], [0.0, 0.0, 1.0]] {
        let moment = axis.map(|x| 0.5 * SPRING * x);
        let load = Load::Moment(vector_load("u_max_v_max", moment));
        let hinge = revolute("hinge", "ground", "plate", [0.0, 0.5, 0.0], axis);
        let spring = torsion_spring(["ground", "plate"], axis, SPRING);
        let m = Model { torsion_springs: vec![spring], ..plate_on_body(2, hinge, load) };
        let (_, system, outcome) = solve(&m);
        let turned = rotation(axis, 0.5);
        let directors = system.coordinates.bodies[0].directors.unwrap();
        for v in directors.map(|v| v as usize) {
            let reference = Vec3::from(system.coordinates.reference[v]);
            let error = reference + Vec3::from(outcome.state.u[v]) - turned * reference;
            assert!(error.norm() < 1e-9, "{axis:?}: {error}");
        }
    }
}

/// The stiffness of a plate against motions of its body is zero, not the round-off of its elements: a free hinge leaves a free motion, and a spring of
/// any stiffness has its frequency.
#[test]
fn rigid_plates_do_not_hold_their_hinges() {
    let upright = [0.0, 0.0, 1.0];
    let inertia = MASS * (1.0 / 3.0 + 1.0 / 12.0);
    for stiffness in [0.0, 1e-9] {
        for prestressed in [false, true] {
            // Without a spring, there is no equilibrium to be found.
            if prestressed && stiffness == 0.0 {
                continue;
            }
            let hinge = revolute("hinge", "ground", "plate", [0.0, 0.5, 0.0], upright);
            let mut m = plate_on_body(4, hinge, gravity([0.0, 0.0, -GRAVITY]));
            if stiffness > 0.0 {
                m.torsion_springs = vec![torsion_spring(["ground", "plate"], upright, stiffness)];
            }
            m.analysis = Analysis::Modal(ModalAnalysis { prestressed, ..ModalAnalysis::new(1) });
            let (_, system) = compile(&m);
            let state = prestressed.then(|| modal::prestress(&system, &mut Notes::default()).unwrap().state);
            let modes = modal::run(&system, 1, state.as_ref(), &mut Notes::default()).unwrap();
            let (found, exact) = (&modes.modes[0], (stiffness / inertia).sqrt());
            assert_eq!(found.rigid, stiffness == 0.0, "{prestressed}: {}", found.omega);
            assert!(
                (found.omega - exact).abs() <= 1e-6 * exact,
                "{prestressed} {stiffness}: {} {exact}",
                found.omega
            );
        }
    }
}

/// A steel plate that is attached by one edge to a hinge with a spring a million times as soft turns with it: round-off of the shell does not make the
/// motion a free one. Under an edge load in its plane the hinge has the stiffness k − P L.
#[test]
fn soft_hinges_of_stiff_plates_have_a_frequency_under_loads() {
    let (length, width, thickness, density, spring) = (2.0, 0.4, 0.02, 7850.0, 10.0);
    let mesh = plate([length, width], [60, 12], 0.0);
    let material = Isotropic::new(2.1e11, 0.3, density);
    let options = ModalAnalysis { prestressed: true, ..ModalAnalysis::new(1) };
    let mut m = Model::new(mesh, Analysis::Modal(options), material, thickness);
    m.bodies = vec![hub("arm", [0.0, 0.5 * width, 0.0], &["u_min"])];
    m.joints = vec![revolute("hinge", "ground", "arm", [0.0, 0.5 * width, 0.0], Y)];
    m.torsion_springs = vec![torsion_spring(["ground", "arm"], Y, spring)];
    let mass = density * length * width * thickness;
    let inertia = mass * (length * length / 3.0 + thickness * thickness / 12.0);
    for part in [0.5, -0.5] {
        let load = part * spring / (length * width);
        m.loads = vec![Load::Edge(vector_load("u_max", [-load, 0.0, 0.0]))];
        let (_, system) = compile(&m);
        let state = modal::prestress(&system, &mut Notes::default()).unwrap().state;
        let modes = modal::run(&system, 1, Some(&state), &mut Notes::default()).unwrap();
        let exact = spring * (1.0 - part) / inertia;
        assert!(
            (modes.modes[0].omega.powi(2) / exact - 1.0).abs() < 2e-3,
            "{part}: {:?}",
            modes.modes[0].omega
        );
    }
}

/// Springs a trillion times as soft as their plates give a frequency about a loaded state, too, also where the plate has turned far; where the plate is as
/// stiff as that, gravity gives the frequency of the pendulum.
#[test]
fn nearly_rigid_plates_have_a_frequency_about_a_loaded_state() {
    let (mass, thickness) = (785.0, 0.1);
    let about_edge = mass * (1.0 / 3.0 + thickness * thickness / 12.0);
    let of = |young: f64, elements: u32, spring: f64, load: Load| {
        let mesh = plate([1.0, 1.0], [elements; 2], 0.0);
        let options = ModalAnalysis { prestressed: true, ..ModalAnalysis::new(1) };
        let material = Isotropic::new(young, 0.3, mass / thickness);
        let mut m = Model::new(mesh, Analysis::Modal(options), material, thickness);
        m.bodies = vec![hub("arm", [0.0, 0.5, 0.0], &["u_min"])];
        m.joints = vec![revolute("hinge", "ground", "arm", [0.0, 0.5, 0.0], Y)];
        if spring > 0.0 {
            m.torsion_springs = vec![torsion_spring(["ground", "arm"], Y, spring)];
        }
        m.loads = vec![load];
        let (_, system) = compile(&m);
        let state = modal::prestress(&system, &mut Notes::default()).unwrap().state;
        let found = modal::run(&system, 1, Some(&state), &mut Notes::default()).unwrap();
        assert!(!found.modes[0].rigid, "{young:e} {spring:e}");
        found.modes[0].omega
    };
    for (elements, soft) in [(8, 0.01), (16, 0.1), (32, 0.3)] {
        let omega = of(2.1e11, elements, soft, Load::Edge(vector_load("u_max", [0.0, 1e-9, 0.0])));
        let exact = (soft / about_edge).sqrt();
        assert!((omega / exact - 1.0).abs() < 1e-6, "{elements} {soft}: {omega} {exact}");
        let turning = Load::Moment(vector_load("arm", [0.0, soft, 0.0]));
        let omega = of(2.1e11, elements, soft, turning);
        assert!((omega / exact - 1.0).abs() < 1e-4, "turned {elements} {soft}: {omega} {exact}");
    }
    let exact = (mass * GRAVITY * 0.5 / about_edge).sqrt();
    for young in [1e14, 1e16, 1e17] {
        let omega = of(young, 8, 0.0, gravity([GRAVITY, 0.0, 0.0]));
        assert!((omega / exact - 1.0).abs() < 1e-7, "{young:e}: {omega} {exact}");
    }
}

/// Without loads the strain energy, whose round-off is the square of that of the stiffness, tells slow motions from free ones.
#[test]
fn very_soft_hinges_of_stiff_plates_have_a_frequency() {
    let (mass, thickness) = (78.0, 0.01);
    for (elements, soft) in [(4, 1e-4), (4, 1e-2), (32, 1e-2)] {
        let mesh = plate([1.0, 1.0], [elements; 2], 0.0);
        let analysis = Analysis::Modal(ModalAnalysis::new(2));
        let mut m = Model::new(mesh, analysis, Isotropic::new(2e11, 0.3, mass / thickness), thickness);
        m.bodies = vec![hub("arm", [0.0, 0.5, 0.0], &["u_min"])];
        m.joints = vec![revolute("hinge", "ground", "arm", [0.0, 0.5, 0.0], Y)];
        m.torsion_springs = vec![torsion_spring(["ground", "arm"], Y, soft)];
        let (_, system) = compile(&m);
        let modes = modal::run(&system, 2, None, &mut Notes::default()).unwrap();
        let exact = (soft / (mass * (1.0 / 3.0 + thickness * thickness / 12.0))).sqrt();
        assert!(
            !modes.modes[0].rigid && (modes.modes[0].omega / exact - 1.0).abs() < 1e-4,
            "{elements} {soft}"
        );
        m.torsion_springs.clear();
        let (_, system) = compile(&m);
        let free = modal::run(&system, 2, None, &mut Notes::default()).unwrap();
        assert!(free.modes[0].rigid && free.modes[0].omega == 0.0, "{elements}");
        assert!((free.modes[1].omega / modes.modes[1].omega - 1.0).abs() < 1e-6);
    }
}

/// A mass at the end of a spring swings freely across it, next to the modes of a stiff plate to which it is attached.
#[test]
fn a_mass_on_a_spring_at_a_clamped_plate_swings_freely() {
    let mut mesh = plate([1.0, 1.0], [4, 4], 0.0);
    let MeshSource::Plate(of_plate) = &mut mesh else { unreachable!("a plate") };
    of_plate.grid.points.insert("tie".into(), [1.0, 0.5, 0.0]);
    let mut m =
        Model::new(mesh, Analysis::Modal(ModalAnalysis::new(4)), Isotropic::new(2e11, 0.3, 7800.0), 0.01);
    m.conditions = vec![Condition::Clamp(on("u_min"))];
    m.bodies = vec![RigidBody::new("mass", [1.0, 0.5, 1.0], 1.0, None)];
    m.springs = vec![spring("spring", ["mass", "tie"], [[1.0, 0.5, 1.0], [1.0, 0.5, 0.0]], 1.0)];
    let (_, system) = compile(&m);
    let modes = modal::run(&system, 4, None, &mut Notes::default()).unwrap().modes;
    assert!(modes[..2].iter().all(|mode| mode.rigid && mode.omega == 0.0));
    // The plate is a thousand times as stiff as the spring.
    assert!(!modes[2].rigid && (modes[2].omega - 1.0).abs() < 1e-3, "{}", modes[2].omega);
    assert!(!modes[3].rigid && modes[3].omega > 10.0);
}

/// A moment on a body without mass of its own leaves explicit steps their critical step, which springs set: the plate swings as
/// `(M/k) (1 − cos ωt)`, `ω² = k/I`, with the inertia of the lumped masses.
#[test]
#[ignore = "long"]
fn explicit_steps_under_a_moment_on_an_attached_plate_stay_below_the_critical_one() {
    let (moment, n, end) = (0.5 * SPRING, 4.0_f64, 0.1);
    let inertia = MASS * (0.25 + (1.0 + 2.0 / (n * n)) / 12.0 + 1e-4 / 12.0);
    let omega = (SPRING / inertia).sqrt();
    for on in ["plate", "u_max_v_max"] {
        let mut m = hinged(4, Load::Moment(vector_load(on, [0.0, moment, 0.0])));
        let scheme = Scheme::Explicit(ExplicitScheme { scale_director_inertia: false });
        let options = TransientAnalysis { scheme, ..TransientAnalysis::new(end) };
        m.analysis = Analysis::Transient(options.clone());
        let (system, outcome) = move_in_time(&m, &options, &mut Notes::default());
        let critical = outcome.statistics.critical_step;
        assert!(critical > 0.0 && critical < 2.1 / omega, "{on}: {critical}");
        let exact = moment / SPRING * (1.0 - (omega * end).cos());
        let found = angle(&system, &outcome.state.u);
        assert!((found / exact - 1.0).abs() < 1e-3, "{on}: {found} {exact}");
    }
}

/// Four masses in the corners of one element have three times the moment of inertia of the plate about its normal. Of n² elements, each one has
/// `1 + 2/n²` times that of the plate, as `Σ xᵢ² = ∫x²dx + 1/(6n²)`.
#[test]
fn the_raised_inertia_of_lumped_masses_is_a_warning() {
    for elements in [1_u32, 4, 8] {
        let mut m = hinged(elements, pressure());
        let scheme = Scheme::Explicit(ExplicitScheme { scale_director_inertia: false });
        m.analysis = Analysis::Transient(TransientAnalysis { scheme, ..TransientAnalysis::new(1.0) });
        let (mesh, system) = compile(&m);
        let found = warnings(&m, &mesh, &system);
        let raised = found.iter().find(|issue| issue.message.contains("lump the masses"));
        let ratio = 1.0 + 2.0 / f64::from(elements * elements);
        match raised {
            Some(issue) => {
                assert!(issue.message.contains("body \"plate\""), "{issue:?}");
                assert!(issue.message.contains(&format!("{ratio:.3} times")), "{issue:?}");
            }
            None => assert!(ratio <= 1.05, "{found:?}"),
        }
    }
}
