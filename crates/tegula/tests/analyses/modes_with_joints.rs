//! Modes of bodies, beams and shells that joints connect: closed solutions, mechanisms of frequency zero, redundant joints, and
//! joints in the place of supports.

use crate::common::on;
use crate::multibody::{between, body, gravity, revolute, spherical};
use tegula::analysis::modal::{self, ModalOutcome};
use tegula::analysis::{Silent, State, statics};
use tegula::model::*;
use tegula::{System, compile, mesh};

pub fn modal(modes: u32, prestressed: bool) -> Analysis {
    Analysis::Modal(ModalAnalysis { prestressed, ..ModalAnalysis::new(modes) })
}

/// Modes of a model; the number of all modes was proved by a Sturm sequence count.
pub fn modes(model: &Model) -> (System, ModalOutcome) {
    let mesh = mesh::generators::generate(&model.mesh).unwrap();
    let system = compile::build(model, &mesh).unwrap();
    let Analysis::Modal(options) = &model.analysis else { panic!() };
    let equilibrium = options.prestressed.then(|| modal::prestress(&system, &mut Silent).unwrap().state);
    let found = modal::run(&system, options.modes as usize, equilibrium.as_ref(), &mut Silent).unwrap();
    assert!(found.sturm_checked);
    (system, found)
}

pub fn omegas(model: &Model) -> Vec<f64> {
    modes(model).1.modes.iter().map(|mode| mode.omega).collect()
}

fn slide(name: &str) -> Joint {
    Joint::Prismatic(
        AxisJoint {
            name: format!("slide of {name}"),
            between: between("ground", name),
            at: [0.0; 3],
            axis: [1.0, 0.0, 0.0],
            second_at: None,
            second_axis: None,
        }
        .into(),
    )
}

/// Two bodies on slides with a spring between them: they drift, or vibrate with ω² = k (1/m₁ + 1/m₂).
#[test]
fn two_bodies_on_slides_drift_and_vibrate_against_their_spring() {
    let bodies =
        vec![body("a", [0.0; 3], 2.0, Some([0.1; 3])), body("b", [1.0, 0.0, 0.0], 3.0, Some([0.2; 3]))];
    let mut model = Model::of_bodies(modal(2, false), bodies, vec![slide("a"), slide("b")]);
    model.springs = vec![SpringDamper {
        across: None,
        name: "spring".into(),
        between: between("a", "b"),
        points: [[0.0; 3], [1.0, 0.0, 0.0]],
        stiffness: 600.0,
        damping: 0.0,
        force: None,
        length: None,
    }];
    let found = omegas(&model);
    assert!(found[0] == 0.0 && (found[1] / 500f64.sqrt() - 1.0).abs() < 1e-10, "{found:?}");
}

pub fn to_ground(name: &str, body: &str, points: [[f64; 3]; 2], stiffness: f64) -> SpringDamper {
    let between = between("ground", body);
    SpringDamper {
        across: None,
        name: name.into(),
        between,
        points,
        stiffness,
        damping: 0.0,
        force: None,
        length: None,
    }
}

/// A point mass and a body on three springs to the ground: ω² = k/m along each; rotations of the body are free.
#[test]
fn springs_to_the_ground_hold_bodies_without_joints() {
    let ends = [[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]];
    let springs: Vec<SpringDamper> = ends
        .into_iter()
        .zip([200.0, 800.0, 1800.0])
        .map(|(end, k)| to_ground(&format!("spring {k}"), "mass", [end, [0.0; 3]], k))
        .collect();
    for (inertia, count) in [(None, 3), (Some([1.0, 2.0, 2.5]), 6)] {
        let mass = body("mass", [0.0; 3], 2.0, inertia);
        let mut model = Model::of_bodies(modal(count as u32, false), vec![mass], Vec::new());
        model.springs = springs.clone();
        let found = omegas(&model);
        assert_eq!(found.len(), count);
        let (free, elastic) = found.split_at(count - 3);
        assert!(free.iter().all(|omega| *omega == 0.0), "{found:?}");
        for (omega, expected) in elastic.iter().zip([10.0, 20.0, 30.0]) {
            assert!((omega / expected - 1.0).abs() < 1e-10, "{found:?}");
        }
    }
}

/// A stiff plate on soft vertical springs at its corners drifts and spins in its plane, heaves with ω² = 4k/m, and rolls with
/// ω² = 12 k/m, for a square.
#[test]
fn a_plate_on_springs_to_the_ground_heaves_and_rolls() {
    let mut model = crate::common::model(crate::common::plate([1.0, 1.0], [4, 4], 0.0), 2.1e11, 0.05);
    model.analysis = modal(6, false);
    model.conditions.clear();
    // Density 1, area 1.
    let mass = 0.05_f64;
    for (corner, x, y) in [
        ("u_min_v_min", 0.0, 0.0),
        ("u_max_v_min", 1.0, 0.0),
        ("u_min_v_max", 0.0, 1.0),
        ("u_max_v_max", 1.0, 1.0),
    ] {
        model.springs.push(to_ground(corner, corner, [[x, y, -1.0], [x, y, 0.0]], 1e3));
    }
    let found = omegas(&model);
    assert!(found[..3].iter().all(|omega| *omega == 0.0), "{found:?}");
    for (omega, factor) in found[3..].iter().zip([4.0, 12.0, 12.0]) {
        let expected = (factor * 1e3 / mass).sqrt();
        assert!((omega / expected - 1.0).abs() < 2e-3, "{found:?} {expected}");
    }
}

/// Two pairs of bodies without connection, whose springs differ by 10⁶: each pair drifts and vibrates, and joints of one take no
/// mode from the other.
#[test]
fn separate_mechanisms_of_unlike_stiffness_keep_their_own_modes() {
    let inertia = Some([0.1; 3]);
    let bodies = ["a", "b", "c", "d"].map(|name| body(name, [0.0; 3], 2.0, inertia)).to_vec();
    let slides = ["a", "b", "c", "d"].map(slide).to_vec();
    let mut model = Model::of_bodies(modal(6, false), bodies, slides);
    let spring = |a: &str, b: &str, stiffness| SpringDamper {
        across: None,
        name: format!("{a} to {b}"),
        between: between(a, b),
        points: [[0.0; 3], [1.0, 0.0, 0.0]],
        stiffness,
        damping: 0.0,
        force: None,
        length: None,
    };
    model.springs = vec![spring("a", "b", 100.0), spring("c", "d", 1e8)];
    let found = omegas(&model);
    assert_eq!(found.len(), 4);
    assert!(found[0] == 0.0 && found[1] == 0.0, "{found:?}");
    for (omega, expected) in found[2..].iter().zip([10.0, 1e4]) {
        assert!((omega / expected - 1.0).abs() < 1e-9, "{found:?}");
    }
}

/// A body that hangs on a hinge: ω² = m g l/(J + m l²) by the geometric stiffness of the joint's forces; a second hinge on the same
/// axis changes nothing.
#[test]
fn a_hanging_body_swings_as_a_compound_pendulum_on_one_hinge_or_two() {
    let hinge = |name: &str, y: f64| revolute(name, "ground", "bob", [0.0, y, 0.0], [0.0, 1.0, 0.0]);
    let bob = body("bob", [0.0, 0.0, -0.4], 3.0, Some([0.3, 0.2, 0.1]));
    for joints in [vec![hinge("one", 0.0)], vec![hinge("one", 0.0), hinge("two", 0.5)]] {
        let mut model = Model::of_bodies(modal(6, true), vec![bob.clone()], joints);
        model.loads = gravity([0.0, 0.0, -9.81]);
        let found = omegas(&model);
        let expected = (3.0 * 9.81 * 0.4 / (0.2 + 3.0 * 0.16_f64)).sqrt();
        assert!(found.len() == 1 && (found[0] / expected - 1.0).abs() < 1e-9, "{found:?} {expected}");
    }
}

/// On a universal joint with horizontal axes the body swings about both.
#[test]
fn a_hanging_body_on_a_universal_joint_swings_about_both_axes() {
    let bob = body("bob", [0.0, 0.0, -0.4], 3.0, Some([0.3, 0.2, 0.1]));
    let cross = Joint::Universal(TwoAxesJoint {
        name: "cross".into(),
        between: between("ground", "bob"),
        at: [0.0; 3],
        axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        second_at: None,
    });
    let mut model = Model::of_bodies(modal(6, true), vec![bob], vec![cross]);
    model.loads = gravity([0.0, 0.0, -9.81]);
    let found = omegas(&model);
    let expected = |inertia: f64| (3.0 * 9.81 * 0.4 / (inertia + 0.48_f64)).sqrt();
    assert_eq!(found.len(), 2);
    for (omega, inertia) in found.iter().zip([0.3, 0.2]) {
        assert!((omega / expected(inertia) - 1.0).abs() < 1e-9, "{found:?}");
    }
}

/// A slender beam between hinges: Euler's (n π/L)² √(EI/ρA), less `½ (n π r/L)² (1 + E/κG)` of it for rotary inertia and shear
/// (S. Timoshenko, Phil. Mag. 43 (1922) 125–131).
#[test]
fn a_beam_between_hinges_has_timoshenkos_frequencies() {
    let steel = Isotropic { young: 2.1e11, poisson: 0.3, density: 7800.0, expansion: 0.0, strength: None };
    let section = BeamSection::Rectangle(RectangularSection { size: [0.04, 0.01] });
    let beam = Beam {
        material: Some("steel".into()),
        ..Beam::straight("beam", [[0.0; 3], [2.0, 0.0, 0.0]], 32, [0.0, 1.0, 0.0], section)
    };
    let hinge = |name: &str, node: &str, at: [f64; 3]| revolute(name, "ground", node, at, [0.0, 1.0, 0.0]);
    let joints = vec![hinge("left", "beam.start", [0.0; 3]), hinge("right", "beam.end", [2.0, 0.0, 0.0])];
    let mut model = Model::of_bodies(modal(2, false), Vec::new(), joints);
    model.materials.insert("steel".into(), Material::Isotropic(steel));
    for (n, omega) in omegas(&Model { beams: vec![beam], ..model }).into_iter().enumerate() {
        let (wave, radius) = ((n + 1) as f64 * std::f64::consts::PI / 2.0, 1e-4 / 12.0);
        let euler = wave.powi(2) * (2.1e11 * radius / 7800.0_f64).sqrt();
        let expected = euler * (1.0 - 0.5 * wave.powi(2) * radius * (1.0 + 2.6 * 1.2));
        assert!((omega / expected - 1.0).abs() < 2e-5, "{n}: {omega} {expected}");
    }
}

/// A strip whose edge is attached to a body that a fixed joint holds vibrates as a clamped one; on spherical joints at its corners as
/// one whose corners are supported.
#[test]
fn joints_in_the_place_of_supports_leave_the_frequencies_of_a_strip_unchanged() {
    let strip = || {
        let mesh = crate::common::plate([1.0, 0.3], [8, 3], 0.0);
        let mut model = crate::common::model(mesh, 2.1e11, 0.01);
        model.materials.insert("m".into(), Material::Isotropic(Isotropic::new(2.1e11, 0.3, 7850.0)));
        model.conditions.clear();
        model.analysis = modal(5, false);
        model
    };
    let compare = |supported: &Model, jointed: &Model| {
        let (a, b) = (omegas(supported), omegas(jointed));
        for (a, b) in a.iter().zip(&b) {
            assert!(*a > 0.0 && (a / b - 1.0).abs() < 1e-7, "{a} {b}");
        }
    };
    let clamped = Model { conditions: vec![Condition::Clamp(on("u_min"))], ..strip() };
    let mut hub = body("hub", [-0.1, 0.15, 0.0], 2.0, Some([0.1; 3]));
    hub.attached = vec!["u_min".into()];
    let at = [-0.1, 0.15, 0.0];
    let weld = Joint::Fixed(PointJoint {
        name: "weld".into(),
        between: between("ground", "hub"),
        at,
        second_at: None,
    });
    compare(&clamped, &Model { bodies: vec![hub], joints: vec![weld], ..strip() });
    let corners = [
        ("u_min_v_min", [0.0, 0.0, 0.0]),
        ("u_max_v_min", [1.0, 0.0, 0.0]),
        ("u_min_v_max", [0.0, 0.3, 0.0]),
    ];
    let pinned = Model {
        conditions: corners.iter().map(|(set, _)| Condition::Spherical(on(set))).collect(),
        ..strip()
    };
    let joints = corners.iter().map(|(set, at)| spherical("ground", set, *at)).collect();
    compare(&pinned, &Model { joints, ..strip() });
}

/// The compound pendulum in two steps: the force in the hinge comes from the static one.
#[test]
fn a_modal_step_behind_a_static_one_has_the_forces_in_the_joints_of_its_end() {
    let bob = body("bob", [0.0, 0.0, -0.4], 3.0, Some([0.3, 0.2, 0.1]));
    let hinge = revolute("hinge", "ground", "bob", [0.0; 3], [0.0, 1.0, 0.0]);
    let mut model = Model::of_bodies(modal(1, false), vec![bob], vec![hinge]);
    model.loads = gravity([0.0, 0.0, -9.81]);
    model.steps = vec![
        AnalysisStep::new("hang", Analysis::Static(StaticAnalysis::default())),
        AnalysisStep::new("modes", modal(1, false)),
    ];
    let mesh = mesh::generators::generate(&model.mesh).unwrap();
    let compiler = compile::Compiler::new(&model, &mesh).unwrap();
    let system = compiler.system(0, None).unwrap();
    let hanging = statics::run(&system, &StaticAnalysis::default(), None, &mut Silent).unwrap();
    let next = compiler.system(1, Some(hanging.state.end_of_step())).unwrap();
    let about = State { time: 1.0, ..State::first(&next) };
    let found = modal::run(&next, 1, Some(&about), &mut Silent).unwrap();
    let expected = (3.0 * 9.81 * 0.4 / (0.2 + 3.0 * 0.16_f64)).sqrt();
    assert!((found.modes[0].omega / expected - 1.0).abs() < 1e-9, "{} {expected}", found.modes[0].omega);
}

/// Shaft with a disc in its middle between hinges that clamp it in bending (O. Bauchau and others, Multibody Syst. Dyn. 37 (2016) 29–48,
/// with the disc centred): the first bending pair at 56.85 rad/s by Timoshenko's theory. The second pair is at 285.2 and 291.7 rad/s
/// where the shaft turns at 60 rad/s; gyroscopic moments split a pair so that the product of both frequencies stays.
#[test]
fn a_shaft_with_a_disc_has_the_bending_pairs_of_the_benchmark() {
    let section = BeamSection::Constants(SectionConstants {
        axial: 313.4e6,
        shear: [60.5e6; 2],
        bending: [354.5e3; 2],
        torsion: 272.7e3,
        mass: 11.64,
        inertia: [0.013167; 2],
    });
    let along = [1.0, 0.0, 0.0];
    let joints = vec![
        Joint::Fixed(PointJoint {
            name: "hub".into(),
            between: between("shaft.8", "disc"),
            at: [3.0, 0.0, 0.0],
            second_at: None,
        }),
        Joint::Fixed(PointJoint {
            name: "left".into(),
            between: between("ground", "shaft.start"),
            at: [0.0; 3],
            second_at: None,
        }),
        Joint::Cylindrical(AxisJoint {
            name: "right".into(),
            between: between("ground", "shaft.end"),
            at: [6.0, 0.0, 0.0],
            axis: along,
            second_at: None,
            second_axis: None,
        }),
    ];
    let disc = body("disc", [3.0, 0.0, 0.0], 70.573, Some([2.0325, 1.0163, 1.0163]));
    let mut model = Model::of_bodies(modal(5, false), vec![disc], joints);
    model.beams = vec![Beam::straight("shaft", [[0.0; 3], [6.0, 0.0, 0.0]], 16, [0.0, 1.0, 0.0], section)];
    let found = omegas(&model);
    // In between the disc turns on the shaft; its free half turns with it, of the other half a third counts.
    let torsion = (272.7e3 / 3.0 / (2.0325 + 4.0 * 0.026334_f64)).sqrt();
    let pair = (285.2 * 291.7_f64).sqrt();
    for (omega, expected) in found.iter().zip([56.85, 56.85, torsion, pair, pair]) {
        assert!((omega / expected - 1.0).abs() < 0.01, "{found:?} {expected}");
    }
}

/// A body stands on a hinge, held by a spring at its mass centre: ω² = (k l² − m g l)/(J + m l²). Where the spring is too weak, the
/// upright position is no equilibrium that statics accepts.
#[test]
fn a_body_that_stands_on_a_hinge_needs_a_spring_of_m_g_over_l() {
    let standing = |stiffness: f64, analysis: Analysis| {
        let bob = body("bob", [0.0, 0.0, 0.4], 3.0, Some([0.3, 0.2, 0.1]));
        let hinge = revolute("hinge", "ground", "bob", [0.0; 3], [0.0, 1.0, 0.0]);
        let mut model = Model::of_bodies(analysis, vec![bob], vec![hinge]);
        model.loads = gravity([0.0, 0.0, -9.81]);
        model.springs = vec![SpringDamper {
            across: None,
            name: "spring".into(),
            between: between("ground", "bob"),
            points: [[-1.0, 0.0, 0.4], [0.0, 0.0, 0.4]],
            stiffness,
            damping: 0.0,
            force: None,
            length: None,
        }];
        model
    };
    let critical = 3.0 * 9.81 / 0.4;
    let found = omegas(&standing(1.2 * critical, modal(1, true)));
    let expected = (0.2 * critical * 0.16 / (0.2 + 3.0 * 0.16_f64)).sqrt();
    assert!((found[0] / expected - 1.0).abs() < 1e-9, "{found:?} {expected}");
    for (share, stands) in [(0.95, false), (1.05, true)] {
        let model = standing(share * critical, Analysis::Static(StaticAnalysis::default()));
        let mesh = mesh::generators::generate(&model.mesh).unwrap();
        let system = compile::build(&model, &mesh).unwrap();
        let outcome = statics::run(&system, &StaticAnalysis::default(), None, &mut Silent);
        assert_eq!(outcome.is_ok(), stands, "{share}: {:?}", outcome.map(|outcome| outcome.statistics));
    }
}

/// Bodies that nothing holds before the load acts: the first tangent is singular to the last digit.
#[test]
fn bodies_at_places_without_round_off_hang_as_others() {
    let bob = body("bob", [0.0, -0.5, 0.0], 1.0, Some([1.0 / 16.0; 3]));
    let hinge = revolute("hinge", "ground", "bob", [0.0; 3], [0.0, 0.0, 1.0]);
    let mut hanging = Model::of_bodies(modal(1, true), vec![bob], vec![hinge]);
    hanging.loads = gravity([0.0, -8.0, 0.0]);
    let found = omegas(&hanging);
    // m g l/(J + m l²) = 4/(5/16).
    assert!((found[0] / 12.8_f64.sqrt() - 1.0).abs() < 1e-9, "{found:?}");
    // A mass on a spring bounces with k/m and swings with g over the stretched length, also where that is a stiff one.
    for stiffness in [32.0, 2e7] {
        let mass = body("mass", [0.0, -1.0, 0.0], 1.0, None);
        let mut bouncing = Model::of_bodies(modal(3, true), vec![mass], Vec::new());
        bouncing.springs = vec![to_ground("spring", "mass", [[0.0; 3], [0.0, -1.0, 0.0]], stiffness)];
        bouncing.loads = gravity([0.0, -8.0, 0.0]);
        let found = omegas(&bouncing);
        let swing = (8.0_f64 / (1.0 + 8.0 / stiffness)).sqrt();
        for (omega, expected) in found.iter().zip([swing, swing, stiffness.sqrt()]) {
            assert!((omega / expected - 1.0).abs() < 1e-6, "{found:?} {expected}");
        }
    }
}

/// A body on a damper alone beside one on a spring: three translations of each are free, but for that along the spring.
#[test]
fn a_damper_alone_holds_no_body() {
    let bodies = vec![body("a", [0.0; 3], 2.0, None), body("b", [3.0, 0.0, 0.0], 1.0, None)];
    let mut model = Model::of_bodies(modal(6, false), bodies, Vec::new());
    let damper =
        SpringDamper { damping: 1.0, ..to_ground("damper", "b", [[4.0, 0.0, 0.0], [3.0, 0.0, 0.0]], 0.0) };
    model.springs = vec![to_ground("spring", "a", [[-1.0, 0.0, 0.0], [0.0; 3]], 200.0), damper];
    let found = omegas(&model);
    assert!(found.len() == 6 && found[..5].iter().all(|omega| *omega == 0.0), "{found:?}");
    assert!((found[5] - 10.0).abs() < 1e-9, "{found:?}");
}

/// A linkage without a load that could hold it is no structure: statics refuses it still.
#[test]
fn statics_refuses_bodies_that_are_free_to_move_at_the_end() {
    let bob = body("bob", [0.0, -0.5, 0.0], 1.0, Some([1.0 / 16.0; 3]));
    let hinge = revolute("hinge", "ground", "bob", [0.0; 3], [0.0, 0.0, 1.0]);
    let mut model = Model::of_bodies(Analysis::Static(StaticAnalysis::default()), vec![bob], vec![hinge]);
    // Along the axis of the hinge.
    model.loads = gravity([0.0, 0.0, -8.0]);
    let system = compile::build(&model, &mesh::generators::generate(&model.mesh).unwrap()).unwrap();
    assert!(statics::run(&system, &StaticAnalysis::default(), None, &mut Silent).is_err());
}

/// A beam that flies freely has six rigid modes, and the bending frequencies of a free Timoshenko beam.
#[test]
fn a_free_beam_has_six_rigid_modes() {
    let section = BeamSection::Rectangle(RectangularSection { size: [0.02, 0.05] });
    let steel = Isotropic { young: 2.1e11, poisson: 0.3, density: 7850.0, expansion: 0.0, strength: None };
    let beam = Beam {
        material: Some("steel".into()),
        ..Beam::straight("beam", [[0.0; 3], [1.0, 0.0, 0.0]], 64, [0.0, 1.0, 0.0], section)
    };
    let mut model = Model::of_bodies(modal(8, false), Vec::new(), Vec::new());
    model.materials.insert("steel".into(), Material::Isotropic(steel));
    let (_, found) = modes(&Model { beams: vec![beam], ..model });
    assert!(found.modes[..6].iter().all(|mode| mode.rigid && mode.omega == 0.0), "{:?}", found.modes.len());
    for (mode, thickness) in found.modes[6..].iter().zip([0.02, 0.05]) {
        let euler = 4.730040745_f64.powi(2) * (2.1e11 / 7850.0 / 12.0_f64).sqrt() * thickness;
        // Shear and rotary inertia lower it, by some thousandths.
        assert!((0.98..1.0).contains(&(mode.omega / euler)), "{} {euler}", mode.omega);
    }
}

/// A shell with a rigid patch that flies freely has them, too.
#[test]
fn a_free_shell_with_a_patch_has_six_rigid_modes() {
    let mut model = crate::common::model(crate::common::plate([1.0, 0.2], [8, 2], 0.0), 2.1e11, 0.02);
    model.conditions.clear();
    model.analysis = modal(8, false);
    model.bodies = vec![RigidBody {
        mass: None,
        attached: vec!["u_max".into()],
        ..RigidBody::new("hub", [1.1, 0.1, 0.05], 1.0, None)
    }];
    let (_, found) = modes(&model);
    assert!(found.modes[..6].iter().all(|mode| mode.rigid && mode.omega == 0.0));
    assert!(found.modes[6..].iter().all(|mode| mode.omega > 1.0));
}

/// Two bars on hinges are free to move in two ways, and nothing else.
#[test]
fn a_mechanism_without_any_elastic_mode_has_frequencies_of_zero() {
    let inertia = Some([1.0 / 600.0, 1.0 / 12.0, 1.0 / 12.0]);
    let bodies = vec![body("a", [0.5, 0.0, 0.0], 1.0, inertia), body("b", [1.5, 0.0, 0.0], 1.0, inertia)];
    let hinge = |name: &str, a: &str, b: &str, x: f64| revolute(name, a, b, [x, 0.0, 0.0], [0.0, 0.0, 1.0]);
    let joints = vec![hinge("A", "ground", "a", 0.0), hinge("B", "a", "b", 1.0)];
    for wanted in [1, 2] {
        let found = omegas(&Model::of_bodies(modal(wanted, false), bodies.clone(), joints.clone()));
        assert!(found.len() == wanted as usize && found.iter().all(|omega| *omega == 0.0), "{found:?}");
    }
}

/// Two free masses between which a spring acts drift and vibrate with ω² = 2k/m.
#[test]
fn two_free_masses_vibrate_against_their_spring() {
    let bodies = vec![body("a", [0.0; 3], 1.0, None), body("b", [1.0, 0.0, 0.0], 1.0, None)];
    let mut model = Model::of_bodies(modal(6, false), bodies, Vec::new());
    model.springs = vec![SpringDamper {
        between: between("a", "b"),
        ..to_ground("spring", "b", [[0.0; 3], [1.0, 0.0, 0.0]], 100.0)
    }];
    let found = omegas(&model);
    assert!(found.len() == 6 && found[..5].iter().all(|omega| *omega == 0.0), "{found:?}");
    assert!((found[5] / 200_f64.sqrt() - 1.0).abs() < 1e-9, "{found:?}");
}

/// A corner on a support and three on springs: as with a spherical joint in the place of the support.
#[test]
fn supports_and_springs_together_hold_a_plate() {
    let plate = |supported: bool| {
        let mut model = crate::common::model(crate::common::plate([0.5, 0.1], [8, 2], 0.0), 2.1e11, 0.01);
        model.conditions.clear();
        model.analysis = modal(4, false);
        if supported {
            model.conditions = vec![Condition::Spherical(OnSet { on: "u_min_v_min".into() })];
        } else {
            model.joints = vec![spherical("ground", "u_min_v_min", [0.0; 3])];
        }
        for (corner, x, y) in
            [("u_max_v_min", 0.5, 0.0), ("u_min_v_max", 0.0, 0.1), ("u_max_v_max", 0.5, 0.1)]
        {
            model.springs.push(to_ground(corner, corner, [[x, y, -1.0], [x, y, 0.0]], 1e3));
        }
        omegas(&model)
    };
    let (supported, jointed) = (plate(true), plate(false));
    assert!(supported[0] == 0.0 && jointed[0] == 0.0, "{supported:?} {jointed:?}");
    for (a, b) in supported[1..].iter().zip(&jointed[1..]) {
        assert!(*a > 1.0 && (a / b - 1.0).abs() < 1e-6, "{supported:?} {jointed:?}");
    }
}

/// A plate all of whose nodes are attached to a body is a rigid plate: on an elastic foundation it translates with ω² = k A/m, and turns
/// with ω² = k ∫r² dA/J about each axis.
#[test]
fn a_plate_that_is_a_part_of_a_body_vibrates_on_its_foundation() {
    let (a, b, k) = (1.0, 0.6, [1e4, 2e4, 3e4]);
    let mut model = crate::common::model(crate::common::plate([a, b], [1, 1], 0.0), 1e9, 0.01);
    model.conditions.clear();
    let (mass, inertia) = (10.0, [1.0, 2.0, 2.5]);
    let mut plate = body("plate", [0.5 * a, 0.5 * b, 0.0], mass, Some(inertia));
    plate.attached = vec!["all".into()];
    model.bodies = vec![plate];
    model.foundations = vec![Foundation::Area(AreaFoundation {
        on: "all".into(),
        stiffness: k,
        normal: 0.0,
        retardation_time: 0.0,
    })];
    model.analysis = modal(6, false);
    let shell = 0.01 * a * b;
    let area = a * b;
    let [second_x, second_y] = [area * b * b / 12.0, area * a * a / 12.0];
    let total = mass + shell;
    // The plate of density 1 and thickness 0.01 adds its own inertia.
    let own = [b * b, a * a, a * a + b * b].map(|square| shell * square / 12.0);
    let j: Vec<f64> = inertia.iter().zip(own).map(|(body, plate)| body + plate).collect();
    let mut expected = [
        k[0] * area / total,
        k[1] * area / total,
        k[2] * area / total,
        k[2] * second_x / j[0],
        k[2] * second_y / j[1],
        (k[0] * second_x + k[1] * second_y) / j[2],
    ];
    expected.sort_by(f64::total_cmp);
    for (omega, square) in omegas(&model).into_iter().zip(expected) {
        assert!((omega / square.sqrt() - 1.0).abs() < 1e-5, "{omega} {}", square.sqrt());
    }
}

/// A stiff shaft on a hinge and a soft spring: ω² = k L²/J, far below the round-off of the stiffness of many short elements.
#[test]
fn a_soft_mode_of_a_stiff_beam_is_not_taken_for_a_mechanism() {
    for (radius, stiffness) in [(0.05, 1.0), (0.1, 10.0)] {
        // Elements have half of their mass at each end: the inertia of the rod is larger by 1/(2n²) of it.
        for (elements, tolerance) in [(10, 3e-3), (100, 1e-4)] {
            let section = BeamSection::Circle(CircularSection { radius, inner_radius: 0.0 });
            let ends = [[0.0; 3], [1.0, 0.0, 0.0]];
            let mut beam = Beam::straight("b", ends, elements, [0.0, 1.0, 0.0], section);
            beam.material = Some("s".into());
            let hinge = revolute("h", "ground", "b.start", [0.0; 3], [0.0, 0.0, 1.0]);
            let mut model = Model::of_bodies(modal(2, false), Vec::new(), vec![hinge]);
            model.materials.insert("s".into(), Material::Isotropic(Isotropic::new(2.1e11, 0.3, 7850.0)));
            model.beams = vec![beam];
            model.springs = vec![to_ground("s", "b.end", [[1.0, 1.0, 0.0], [1.0, 0.0, 0.0]], stiffness)];
            let area = std::f64::consts::PI * radius * radius;
            // Of rigid cross-sections: the slender rod and the rotary inertia.
            let inertia = 7850.0 * (area / 3.0 + 0.25 * area * radius * radius);
            let found = omegas(&model)[0];
            let expected = (stiffness / inertia).sqrt();
            assert!((found / expected - 1.0).abs() < tolerance, "{radius} {elements}: {found} {expected}");
        }
    }
}

/// A body that is fixed in the ground has no modes, and the analysis says so.
#[test]
fn a_model_that_joints_hold_altogether_has_no_modes_and_says_so() {
    let keys =
        PointJoint { name: "f".into(), between: between("ground", "a"), at: [0.0; 3], second_at: None };
    let model = Model::of_bodies(
        modal(3, false),
        vec![body("a", [0.5, 0.0, 0.0], 1.0, Some([0.1; 3]))],
        vec![Joint::Fixed(keys)],
    );
    let mesh = mesh::generators::generate(&model.mesh).unwrap();
    let system = compile::build(&model, &mesh).unwrap();
    let Analysis::Modal(options) = &model.analysis else { panic!() };
    let mut notes = crate::common::Notes::default();
    let outcome = modal::run(&system, options.modes as usize, None, &mut notes).unwrap();
    assert!(outcome.modes.is_empty() && notes.events[0].contains("it has no modes"), "{:?}", notes.events);
}
