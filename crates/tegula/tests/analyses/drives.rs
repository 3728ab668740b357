//! Driven joints: motion, reactions and work of the drives, contradictions.

use crate::common::{Notes, driven_edge, move_in_time, plate};
use crate::multibody::{between, body, gravity, machine, pose, run};
use tegula::analysis::{Observer, Silent, State, Step, dynamics, statics};
use tegula::load::{Signal, TimeFunction};
use tegula::model::*;
use tegula::norm::{larger, max_norm};
use tegula::result::joint_reaction;
use tegula::{Mat3, Vec3, compile, mesh};

/// A hinge of the ground about an axis through the origin, and a drive of its angle by a formula (degrees).
fn driven_hinge(body: &str, at: [f64; 3], axis: [f64; 3]) -> Vec<Joint> {
    vec![
        Joint::Revolute(
            AxisJoint {
                name: "hinge".into(),
                between: between("ground", body),
                at,
                axis,
                second_at: None,
                second_axis: None,
            }
            .into(),
        ),
        Joint::DrivenAngle(DrivenAngleJoint {
            name: "drive".into(),
            between: between("ground", body),
            axis,
            angle: 1.0,
            amplitude: "angle".into(),
        }),
    ]
}

fn formula(text: &str) -> Amplitude {
    Amplitude::Expression(ExpressionAmplitude { expression: text.into() })
}

/// Cardan joint between shafts at 40° whose driven fork is across their plane at the start: tan φ₂ = cos β tan φ₁ after ten turns,
/// in steps of up to a fifth of a turn.
#[test]
fn a_cardan_joint_transmits_the_angle_of_a_driven_shaft() {
    let beta = 40f64.to_radians();
    let axis = [beta.cos(), beta.sin(), 0.0];
    let shaft = |name: &str, at| body(name, at, 1.0, Some([0.02, 0.03, 0.04]));
    let output = RigidBody { axes: [axis, [-beta.sin(), beta.cos(), 0.0]], ..shaft("output", axis) };
    let mut joints = driven_hinge("input", [-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]);
    joints.push(Joint::Cylindrical(AxisJoint {
        name: "bearing".into(),
        between: between("ground", "output"),
        at: axis,
        axis,
        second_at: None,
        second_axis: None,
    }));
    joints.push(Joint::Universal(TwoAxesJoint {
        name: "cardan".into(),
        between: between("input", "output"),
        at: [0.0; 3],
        axes: [[0.0, 0.0, 1.0], [-beta.sin(), beta.cos(), 0.0]],
        second_at: None,
    }));
    let mut model = machine(1.0, 0.01, vec![shaft("input", [-1.0, 0.0, 0.0]), output], joints);
    model.amplitudes.insert("angle".into(), formula("3650*t^2"));
    let mut notes = Notes::default();
    let (system, state) = run(&model, &mut notes);
    assert!(notes.drift() <= 1e-10 * notes.kinetic, "{}", notes.drift());
    let (_, r) = pose(&system, &state, 1);
    let second = (beta.cos() * 50f64.to_radians().tan()).atan();
    let fork = Vec3::new(-beta.sin(), beta.cos(), 0.0) * second.cos() + Vec3::z() * second.sin();
    assert!((r.column(1) - fork).norm() < 1e-8, "{r} {fork}");
}

/// A pendulum whose hinge is driven by θ = θ₀ (1 − cos ωt): moment of the drive J θ̈ + m g l sin θ, its work the energy gained.
#[test]
fn a_driven_pendulum_takes_the_moment_of_its_equation_of_motion() {
    let arm = body("arm", [0.0, -0.7, 0.0], 2.0, Some([0.1, 0.02, 0.1]));
    let joints = driven_hinge("arm", [0.0; 3], [0.0, 0.0, 1.0]);
    let moment = |step: f64| {
        let mut model = machine(0.8, step, vec![arm.clone()], joints.clone());
        model.amplitudes.insert("angle".into(), formula("60*(1 - cos(4*t))"));
        model.loads = gravity([0.0, -9.81, 0.0]);
        let mut notes = Notes::default();
        let (system, state) = run(&model, &mut notes);
        assert!(notes.drift() <= 1e-10 * notes.kinetic, "{}", notes.drift());
        let angle = |t: f64| 60f64.to_radians() * (1.0 - (4.0 * t).cos());
        let (x, _) = pose(&system, &state, 0);
        let expected = Vec3::new(angle(0.8).sin(), -angle(0.8).cos(), 0.0) * 0.7;
        assert!((x - expected).norm() < 1e-11, "{x}");
        let t: f64 = 0.8 - 0.5 * step;
        let exact = (0.1 + 2.0 * 0.49) * 60f64.to_radians() * 16.0 * (4.0 * t).cos()
            + 2.0 * 9.81 * 0.7 * angle(t).sin();
        let (_, m) = joint_reaction(&system, &state, &system.joints[1]);
        (m.z - exact).abs() / exact.abs()
    };
    let errors = [moment(8e-3), moment(4e-3), moment(2e-3)];
    assert!(errors[2] < 1e-3, "{errors:?}");
    assert!((3.6..4.4).contains(&(errors[1] / errors[2])), "{errors:?}");
}

/// A mass on a slide that is driven along a length: force m s̈ + m g, and no other motion.
#[test]
fn a_driven_slide_carries_weight_and_inertia() {
    let keys = |name: &str| (name.to_owned(), between("ground", "mass"));
    let (name, sides) = keys("slide");
    let (drive, _) = keys("drive");
    let axis = [0.0, 0.0, 2.0];
    let at = [0.3, 0.0, 0.0];
    let joints = vec![
        Joint::Prismatic(
            AxisJoint { name, between: sides.clone(), at, axis, second_at: None, second_axis: None }.into(),
        ),
        Joint::DrivenLength(DrivenLengthJoint {
            name: drive,
            between: sides,
            at,
            axis,
            length: 0.5,
            amplitude: "lift".into(),
        }),
    ];
    let mass = body("mass", [0.0; 3], 3.0, Some([0.1; 3]));
    let mut model = machine(1.0, 1e-2, vec![mass], joints);
    model.amplitudes.insert("lift".into(), formula("t^2"));
    model.loads = gravity([0.0, 0.0, -9.81]);
    let (system, state) = run(&model, &mut Notes::default());
    let (x, r) = pose(&system, &state, 0);
    assert!((x - Vec3::new(0.0, 0.0, 0.5)).norm() < 1e-12 && (r - Mat3::identity()).norm() < 1e-12, "{x}");
    let (force, _) = joint_reaction(&system, &state, &system.joints[1]);
    assert!((force - Vec3::new(0.0, 0.0, 3.0 * (9.81 + 1.0))).norm() < 1e-9, "{force}");
}

/// Two drives of one hinge that disagree contradict each other; the one that is named is a drive.
#[test]
fn drives_that_contradict_each_other_are_refused_by_name() {
    let arm = body("arm", [0.0, -0.7, 0.0], 2.0, Some([0.1, 0.02, 0.1]));
    let mut joints = driven_hinge("arm", [0.0; 3], [0.0, 0.0, 1.0]);
    let Joint::DrivenAngle(mut second) = joints[1].clone() else { panic!() };
    (second.name, second.angle) = ("second".into(), 2.0);
    joints.push(Joint::DrivenAngle(second));
    let mut model = machine(0.8, 0.01, vec![arm], joints);
    model.amplitudes.insert("angle".into(), formula("60*(1 - cos(4*t))"));
    let mesh = mesh::generators::generate(&model.mesh).unwrap();
    let system = compile::build(&model, &mesh).unwrap();
    let Analysis::Transient(options) = &model.analysis else { panic!() };
    let error = dynamics::run(&system, options, None, &mut Notes::default()).unwrap_err().to_string();
    assert!(error.contains("the drives \"drive\", \"second\" contradict each other"), "{error}");
}

/// A rotor on a driven hinge with the angle π t² (rad): speed 2π t. Its place at the ends of steps does not tell how often it turns.
fn driven_rotor(scheme: Scheme, end: f64, time_step: Option<f64>) -> Model {
    let rotor = body("rotor", [0.0; 3], 2.0, Some([0.1, 0.02, 0.1]));
    let mut model = machine(end, 1.0, vec![rotor], driven_hinge("rotor", [0.0; 3], [0.0, 0.0, 1.0]));
    model.amplitudes.insert("angle".into(), formula("180*t^2"));
    let options = TransientAnalysis { scheme, time_step, ..TransientAnalysis::new(end) };
    Model { analysis: Analysis::Transient(options), ..model }
}

fn speed(model: &Model) -> f64 {
    let (system, state) = run(model, &mut Notes::default());
    let [d, ..] = system.coordinates.bodies[0].directors.unwrap();
    let (d, rate) = (pose(&system, &state, 0).1.column(0).into_owned(), Vec3::from(state.v[d as usize]));
    d.cross(&rate).z
}

#[test]
fn automatic_steps_resolve_the_motion_of_a_mechanism_that_a_drive_moves_alone() {
    for scheme in [
        Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 }),
        Scheme::GeneralizedAlpha(GeneralizedAlphaScheme { spectral_radius: 0.8 }),
    ] {
        let found = speed(&driven_rotor(scheme, 2.0, None));
        assert!((found / (4.0 * std::f64::consts::PI) - 1.0).abs() < 0.02, "{found}");
    }
}

#[test]
fn steps_in_which_a_drive_turns_by_more_than_a_quarter_turn_are_cut_back() {
    for scheme in [
        Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 }),
        Scheme::GeneralizedAlpha(GeneralizedAlphaScheme { spectral_radius: 0.8 }),
    ] {
        // Steps of 0.97 turns at the end.
        let found = speed(&driven_rotor(scheme, 4.0, Some(0.1217)));
        let expected = 8.0 * std::f64::consts::PI;
        assert!((found / expected - 1.0).abs() < 0.5, "{found} {expected}");
    }
}

/// The drive pauses, turning on, at 0.5 s, where its angular acceleration is zero.
#[test]
fn composed_steps_pass_times_at_which_the_acceleration_of_a_drive_vanishes() {
    let mut model = driven_rotor(Scheme::EnergyMomentum(EnergyMomentumScheme { order: 4 }), 1.0, Some(0.02));
    model.amplitudes.insert("angle".into(), formula("90*(t - sin(2*PI*t)/(2*PI))"));
    let found = speed(&model);
    assert!(found.abs() < 1e-6, "{found}");
}

/// A shaft, clamped at one end and driven at the other by 350° in one load step: G J θ/L, and not that of −10°.
#[test]
fn a_static_drive_of_almost_a_turn_twists_a_shaft_the_long_way() {
    let section = BeamSection::Constants(SectionConstants {
        axial: 1e4,
        shear: [1e4; 2],
        bending: [1e4; 2],
        torsion: 3.0,
        mass: 1.0,
        inertia: [1.0; 2],
    });
    let mut joints = driven_hinge("shaft.end", [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]);
    joints[0] = Joint::Cylindrical(AxisJoint {
        name: "bearing".into(),
        between: between("ground", "shaft.end"),
        at: [1.0, 0.0, 0.0],
        axis: [1.0, 0.0, 0.0],
        second_at: None,
        second_axis: None,
    });
    let clamp = PointJoint {
        name: "clamp".into(),
        between: between("ground", "shaft.start"),
        at: [0.0; 3],
        second_at: None,
    };
    joints.push(Joint::Fixed(clamp));
    let mut model = Model::of_bodies(Analysis::Static(StaticAnalysis::default()), Vec::new(), joints);
    model.beams = vec![Beam::straight("shaft", [[0.0; 3], [1.0, 0.0, 0.0]], 64, [0.0, 1.0, 0.0], section)];
    model.amplitudes.insert("angle".into(), formula("350*t"));
    let mesh = mesh::generators::generate(&model.mesh).unwrap();
    let system = compile::build(&model, &mesh).unwrap();
    let Analysis::Static(options) = &model.analysis else { panic!() };
    let outcome = statics::run(&system, options, None, &mut Silent).unwrap();
    let (_, moment) = joint_reaction(&system, &outcome.state, &system.joints[1]);
    let expected = 3.0 * 350f64.to_radians();
    assert!((moment.x / expected - 1.0).abs() < 0.01, "{moment} {expected}");
    assert!(outcome.statistics.cutbacks > 0);
}

/// A strip hangs on a hinge that is driven by −90°; the drive of a motion from there begins with the angle 1.5 t² turns: at first the
/// strip moves by less than the round-off of its stresses.
#[test]
fn a_motion_begins_smoothly_from_a_loaded_equilibrium() {
    let mut hub = body("hub", [0.0; 3], 1.0, None);
    (hub.mass, hub.attached) = (None, vec!["u_min".into()]);
    let mut model = crate::multibody::strip(1.0, 1e-3);
    let MeshSource::Plate(plate) = &mut model.mesh else { panic!() };
    *plate = PlateMesh { origin: [0.0, -0.025, 0.0], ..PlateMesh::new([1.0, 0.05], [12, 2]) };
    model.materials.insert("m".into(), Material::Isotropic(Isotropic::new(7e10, 0.0, 2700.0)));
    model.sections[0] = Section { thickness: 0.01, ..model.sections[0].clone() };
    model.bodies = vec![hub];
    model.joints = driven_hinge("hub", [0.0; 3], [0.0, 1.0, 0.0]);
    model.amplitudes.insert("angle".into(), formula("-90*t^2*(3 - 2*t)"));
    let scheme = Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 });
    let motion = TransientAnalysis { scheme, time_step: Some(1e-3), ..TransientAnalysis::new(0.02) };
    model.steps = vec![
        AnalysisStep::new(
            "hang",
            Analysis::Static(StaticAnalysis { load_steps: 4, ..StaticAnalysis::default() }),
        ),
        AnalysisStep::new("swing", Analysis::Transient(motion.clone())),
    ];
    let mesh = mesh::generators::generate(&model.mesh).unwrap();
    let compiler = compile::Compiler::new(&model, &mesh).unwrap();
    let system = compiler.system(0, None).unwrap();
    let Analysis::Static(options) = &model.steps[0].analysis else { panic!() };
    let hanging = statics::run(&system, options, None, &mut Silent).unwrap();
    let next = compiler.system(1, Some(hanging.state.end_of_step())).unwrap();
    let moved = dynamics::run(&next, &motion, None, &mut Silent).unwrap();
    assert_eq!((moved.statistics.steps, moved.statistics.cutbacks), (20, 0));
}

/// A run-up to 50 turns a second in steps of 20 ms: the velocities of steps of a quarter turn are those of no rotor.
#[test]
fn velocities_that_miss_the_rate_of_a_drive_by_half_of_it_are_refused() {
    let mut model = driven_rotor(Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 }), 1.0, Some(0.02));
    model.amplitudes.insert("angle".into(), formula("18000*(t - sin(PI*t)/PI)"));
    let mesh = mesh::generators::generate(&model.mesh).unwrap();
    let system = compile::build(&model, &mesh).unwrap();
    let Analysis::Transient(options) = &model.analysis else { panic!() };
    let error = dynamics::run(&system, options, None, &mut Silent).unwrap_err().to_string();
    assert!(error.contains("the velocities miss the rate of the drive \"drive\""), "{error}");
}

/// A drive that stops at once between two steps leaves a body behind whose velocities alternate; the log says so.
#[test]
fn velocities_that_alternate_behind_a_drive_that_stops_at_once_are_told() {
    let told = |amplitude: Amplitude| {
        let joints = driven_hinge("arm", [0.0; 3], [0.0, 0.0, 1.0]);
        let mut model = machine(2.0, 0.01, vec![body("arm", [1.0, 0.0, 0.0], 2.0, Some([1.0; 3]))], joints);
        model.amplitudes.insert("angle".into(), amplitude);
        let mut notes = Notes::default();
        run(&model, &mut notes);
        notes.events.iter().any(|event| event.contains("keep the joint") && event.contains("hinge"))
    };
    let (times, values) = (vec![0.0, 1.0, 1.01, 2.0], vec![0.0, 0.0, 85.0, 85.0]);
    assert!(told(Amplitude::Table(TableAmplitude { times, values })));
    // Moves and comes to rest smoothly.
    let (times, values) = (vec![0.0, 0.5, 1.0, 1.5, 2.0], vec![0.0, 45.0, 80.0, 85.0, 85.0]);
    assert!(!told(Amplitude::Spline(SplineAmplitude { times, values, rates: [0.0; 2] })));
}

/// A damper beside a drive whose rate changes its sign: the torque of the drive is that of the damper on both sides of the kink.
#[test]
fn a_damper_takes_the_jump_of_the_rate_of_a_drive() {
    for scheme in [
        Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 }),
        Scheme::GeneralizedAlpha(GeneralizedAlphaScheme { spectral_radius: 0.8 }),
        Scheme::Hht(HhtScheme { alpha: -0.1 }),
        Scheme::Bdf2(Bdf2Scheme {}),
    ] {
        let wheel = body("wheel", [0.0; 3], 2.0, Some([0.2, 0.2, 0.3]));
        let z = [0.0, 0.0, 1.0];
        let hinge = crate::multibody::revolute("hinge", "ground", "wheel", [0.0; 3], z);
        let drive = Joint::DrivenAngle(DrivenAngleJoint {
            name: "drive".into(),
            between: between("ground", "wheel"),
            axis: z,
            angle: 1.0_f64.to_degrees(),
            amplitude: "turn".into(),
        });
        let mut model = machine(0.4, 0.01, vec![wheel], vec![hinge, drive]);
        let table = TableAmplitude { times: vec![0.0, 0.2, 0.5], values: vec![0.0, 0.2, -0.1] };
        model.amplitudes.insert("turn".into(), Amplitude::Table(table));
        model.torsion_springs = vec![TorsionSpring {
            name: "damper".into(),
            between: between("ground", "wheel"),
            axis: z,
            stiffness: 0.0,
            damping: 0.7,
            free_angle: 0.0,
            moment: None,
        }];
        let mut notes = Notes::keeping();
        let (system, _) = run(&crate::generalized_alpha::with_scheme(&model, scheme, 0.4, 0.01), &mut notes);
        for state in notes.states[1..].iter().filter(|state| (state.time - 0.2).abs() > 0.011) {
            let (_, moment) = joint_reaction(&system, state, &system.joints[1]);
            let exact = if state.time < 0.2 { 0.7 } else { -0.7 };
            // The first rows of BDF2 are of first order.
            let limit = if matches!(scheme, Scheme::Bdf2(_)) { 5e-3 } else { 1e-3 };
            assert!((moment.z - exact).abs() < limit, "{scheme:?} {}: {}", state.time, moment.z);
        }
        let last = notes.states.last().unwrap();
        assert!((last.dissipated - 0.7 * 0.4).abs() < 2e-3, "{scheme:?}: {}", last.dissipated);
    }
}

/// A body that a spline turns by 1° and then holds stands still without acceleration: that of the end of the spline, 6°/s², does not alternate on.
#[test]
fn accelerations_behind_a_spline_are_those_of_rest() {
    let generalized = |spectral_radius| Scheme::GeneralizedAlpha(GeneralizedAlphaScheme { spectral_radius });
    for scheme in [generalized(1.0), generalized(0.8), Scheme::Bdf2(Bdf2Scheme {})] {
        let arm = body("arm", [0.5, 0.0, 0.0], 1.0, Some([0.1; 3]));
        let mut m = machine(1.5, 7e-3, vec![arm], driven_hinge("arm", [0.0; 3], [0.0, 0.0, 1.0]));
        let turn = SplineAmplitude { times: vec![0.0, 1.0], values: vec![0.0, 1.0], rates: [0.0; 2] };
        m.amplitudes.insert("angle".into(), Amplitude::Spline(turn));
        let Analysis::Transient(options) = &mut m.analysis else { panic!("no transient analysis") };
        options.scheme = scheme;
        let (_, state) = run(&m, &mut Silent);
        for (what, field) in [("acceleration", &state.a), ("velocity", &state.v)] {
            let size = max_norm(field.as_flattened().iter().copied());
            assert!(size < 1e-6, "{scheme:?}: {what} {size}");
        }
    }
}

/// Time function of a motion from rest that ends with the rate −1.5 and an acceleration, and goes on straight.
fn leaving_straight() -> Amplitude {
    let (times, values) = (vec![0.1, 0.3, 0.6], vec![0.0, 0.4, 0.5]);
    Amplitude::Spline(SplineAmplitude { times, values, rates: [0.0, -1.5] })
}

/// The work of a drive is the kinetic energy, also where a spline begins and ends with an acceleration: the reaction before its end belongs to the step that
/// ends there, the one behind to the next. Of second order in the step.
#[test]
fn the_work_of_a_drive_along_a_spline_is_the_kinetic_energy() {
    let generalized = |spectral_radius| Scheme::GeneralizedAlpha(GeneralizedAlphaScheme { spectral_radius });
    let schemes = [
        (Scheme::Kinematic(KinematicScheme {}), 3.5),
        (generalized(1.0), 3.5),
        (generalized(0.8), 3.5),
        (Scheme::Bdf2(Bdf2Scheme {}), 2.5),
        (Scheme::Explicit(ExplicitScheme::default()), 3.5),
    ];
    for (scheme, order) in schemes {
        let drift = |step: f64| {
            let arm = body("arm", [0.5, 0.0, 0.0], 1.0, Some([0.1; 3]));
            let mut m = machine(0.8, step, vec![arm], driven_hinge("arm", [0.0; 3], [0.0, 0.0, 1.0]));
            m.amplitudes.insert("angle".into(), leaving_straight());
            let Analysis::Transient(options) = &mut m.analysis else { panic!("no transient analysis") };
            options.scheme = scheme;
            let mut notes = Notes::default();
            run(&m, &mut notes);
            let moved = 0.5 * 0.35 * 1.5_f64.to_radians().powi(2);
            assert!((0.9 * moved..4.0 * moved).contains(&notes.kinetic), "{scheme:?}: {}", notes.kinetic);
            assert!(notes.warnings.is_empty(), "{scheme:?}: {:?}", notes.warnings);
            notes.drift() / notes.kinetic
        };
        let [coarse, fine] = [0.01, 0.005].map(drift);
        assert!(coarse < 1e-2 && coarse > order * fine, "{scheme:?}: {coarse} {fine}");
    }
}

/// Supports that move all nodes of a plate along a spline do work alike: 11 % where the reaction behind the end of the spline belonged to the step before it.
#[test]
fn the_work_of_supports_along_a_spline_is_the_kinetic_energy() {
    let schemes = [
        (Scheme::Newmark(NewmarkScheme::default()), Some(0.01)),
        (Scheme::Hht(HhtScheme::default()), Some(0.01)),
        (Scheme::GeneralizedAlpha(GeneralizedAlphaScheme::default()), Some(0.01)),
        (Scheme::Bdf2(Bdf2Scheme {}), Some(0.01)),
        (Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 }), Some(0.01)),
        (Scheme::Newmark(NewmarkScheme::default()), None),
        (Scheme::Explicit(ExplicitScheme::default()), None),
    ];
    for (scheme, time_step) in schemes {
        let options = TransientAnalysis { scheme, time_step, ..TransientAnalysis::new(0.8) };
        let mut m = Model::new(
            plate([1.0, 0.2], [4, 1], 0.0),
            Analysis::Transient(options.clone()),
            Isotropic::new(2e7, 0.3, 1000.0),
            0.01,
        );
        m.conditions = driven_edge("all", 0.7, "lift");
        let Condition::Fix(held) = &mut m.conditions[0] else { panic!("no support") };
        held.director.clear();
        let directors = FixComponents {
            on: "u_min".into(),
            position: Vec::new(),
            director: vec![Axis::X, Axis::Y, Axis::Z],
        };
        m.conditions.push(Condition::Fix(directors));
        m.amplitudes.insert("lift".into(), leaving_straight());
        let mut notes = Notes::default();
        move_in_time(&m, &options, &mut notes);
        assert!(notes.warnings.is_empty(), "{scheme:?}: {:?}", notes.warnings);
        let moved = (0.7 * 1.5_f64).powi(2);
        assert!(notes.kinetic > 0.99 * moved, "{scheme:?}: {}", notes.kinetic);
        let drift = notes.drift() / notes.kinetic;
        assert!(drift < 5e-3, "{scheme:?} {time_step:?}: {drift}");
    }
}

/// Masses that joints couple to a driven one accelerate by its drive: their reactions behind a kink of its motion are those of the
/// velocities there. A bar that turns at 2°/s, and at 1°/s from 0.5 on, pulls its hinge by m r ω².
#[test]
fn reactions_behind_a_kink_are_those_of_the_velocities_there() {
    for scheme in [Scheme::Explicit(ExplicitScheme::default()), Scheme::Kinematic(KinematicScheme {})] {
        let arm = body("arm", [0.5, 0.0, 0.0], 2.0, Some([0.1; 3]));
        let mut m = machine(0.6, 0.01, vec![arm], driven_hinge("arm", [0.0; 3], [0.0, 0.0, 1.0]));
        let table = TableAmplitude { times: vec![0.0, 0.5, 1.0], values: vec![0.0, 1.0, 1.5] };
        m.amplitudes.insert("angle".into(), Amplitude::Table(table));
        let Analysis::Transient(options) = &mut m.analysis else { panic!("no transient analysis") };
        options.scheme = scheme;
        let mut notes = Notes::keeping();
        let (system, _) = run(&m, &mut notes);
        let at_kink = notes.states.iter().find(|state| (state.time - 0.5).abs() < 1e-12).unwrap();
        let (force, _) = joint_reaction(&system, at_kink, &system.joints[0]);
        let exact = 1_f64.to_radians().powi(2);
        assert!((force.norm() - exact).abs() < 1e-9 * exact, "{scheme:?}: {force}");
    }
}

/// Sets a signal for the next step.
struct Follow<F> {
    signal: Signal,
    value: F,
    step: f64,
    notes: Notes,
}

impl<F: Fn(f64) -> f64> Observer for Follow<F> {
    fn on_step(&mut self, step: &Step) -> tegula::Result<()> {
        self.signal.set((self.value)(step.state.time + self.step));
        self.notes.on_step(step)
    }

    fn on_warning(&mut self, message: &str) {
        self.notes.on_warning(message);
    }
}

/// A drive follows a signal. Where this stops at once, the velocities alternate from then on, and a warning says so; where it moves smoothly, they do not. The
/// composed steps of fourth order carry velocities of their own along.
#[test]
fn velocities_that_alternate_about_the_rate_of_a_signal_are_warned_of() {
    let warnings = |order: u32, value: fn(f64) -> f64| {
        let step = 5e-3;
        let arm = body("arm", [0.3, 0.0, 0.0], 1.0, Some([0.1; 3]));
        let mut m = machine(1.0, step, vec![arm], driven_hinge("arm", [0.0; 3], [0.0, 0.0, 1.0]));
        m.amplitudes.insert("angle".into(), formula("0*t"));
        let Analysis::Transient(options) = &mut m.analysis else { panic!("no transient analysis") };
        options.scheme = Scheme::EnergyMomentum(EnergyMomentumScheme { order });
        let options = options.clone();
        let mut system = compile::build(&m, &mesh::generators::generate(&m.mesh).unwrap()).unwrap();
        let signal = Signal::default();
        system.amplitudes = vec![TimeFunction::Signal(signal.clone())];
        let mut follow = Follow { signal, value, step, notes: Notes::default() };
        dynamics::run(&system, &options, None, &mut follow).unwrap();
        follow.notes.warnings
    };
    for order in [2, 4] {
        let told = warnings(order, |t| if t < 0.5 { 20.0 * t * t } else { 5.0 });
        assert_eq!(
            told.iter().filter(|text| text.contains("its signal has changed")).count(),
            1,
            "{order}: {told:?}"
        );
        let smooth = warnings(order, |t| 20.0 * (1.0 - (3.0 * t).cos()));
        assert!(smooth.is_empty(), "{order}: {smooth:?}");
    }
}

/// Behind the end of a spline, where the acceleration of a drive jumps to zero, reactions by the energy–momentum scheme vanish but for a part of the greatest
/// one: two thirds of it where steps did not end there.
#[test]
fn reactions_behind_a_spline_nearly_vanish_with_energy_momentum() {
    let arm = body("arm", [0.5, 0.0, 0.0], 1.0, Some([0.1; 3]));
    let mut m = machine(0.8, 0.01, vec![arm], driven_hinge("arm", [0.0; 3], [0.0, 0.0, 1.0]));
    let (times, values) = (vec![0.0237, 0.3511, 0.6173], vec![0.0, 0.5, 1.0]);
    m.amplitudes
        .insert("angle".into(), Amplitude::Spline(SplineAmplitude { times, values, rates: [0.0; 2] }));
    let mut notes = Notes::keeping();
    let (system, _) = run(&m, &mut notes);
    let moment = |state: &State| joint_reaction(&system, state, &system.joints[1]).1.norm();
    let largest = notes.states.iter().map(moment).fold(0.0, larger);
    let behind = notes.states.iter().filter(|state| state.time > 0.6174).map(moment).fold(0.0, larger);
    assert!(largest > 0.0 && behind < 0.05 * largest, "{behind} {largest}");
}
