//! Models that turn at a constant angular velocity: centrifugal forces, relative equilibria, complex modes and whirl.

use crate::common::{Notes, compile, model, plate, static_options, vector_load};
use crate::modes_with_joints::modal;
use crate::multibody::{between, body, gravity, machine, revolute};
use tegula::analysis::modal::{self, ModalOutcome};
use tegula::analysis::{Silent, State, dynamics, statics};
use tegula::model::*;
use tegula::norm::max_norm;
use tegula::{Error, Vec3, mesh};

const DENSITY: f64 = 2.0;

fn turning(axis: [f64; 3], velocity: f64, ground: Ground) -> Load {
    Load::Centrifugal(CentrifugalLoad { axis, at: [0.0; 3], velocity, ground, amplitude: None })
}

/// Modes about the relative equilibrium.
fn spin(model: &Model) -> tegula::Result<ModalOutcome> {
    let mesh = mesh::generators::generate(&model.mesh).unwrap();
    let system = tegula::compile::build(model, &mesh)?;
    let Analysis::Modal(options) = &model.analysis else { panic!() };
    let about = modal::prestress(&system, &mut Silent)?.state;
    modal::run(&system, options.modes as usize, Some(&about), &mut Silent)
}

fn hub() -> Bushing {
    Bushing {
        name: "hub".into(),
        between: between("ground", "disc"),
        at: [0.0; 3],
        axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        stiffness: None,
        stiffness_matrix: None,
        damping: None,
        damping_matrix: None,
        free: [0.0; 6],
    }
}

/// A disc on an elastic hub at its centre, with the displacement stiffness k and the angular stiffness c: `ω² = k/m` in all directions of
/// the fixed frame, below and above the critical speed, and `Jt ω² − Ja Ω ω − c = 0` for tilting.
#[test]
fn a_disc_on_an_elastic_hub_whirls_as_the_rotor_of_jeffcott() {
    let (m, ja, jt, k, c) = (2.0, 0.5, 0.3, 800.0, 300.0);
    let axis = [0.0, 0.0, 1.0];
    for speed in [7.0, -12.0, 55.0] {
        let disc = body("disc", [0.0; 3], m, Some([jt, jt, ja]));
        let mut model = Model::of_bodies(modal(6, true), vec![disc], Vec::new());
        model.bushings = vec![Bushing { stiffness: Some([k, k, 5.0 * k, c, c, 4.0 * c]), ..hub() }];
        model.loads = vec![turning(axis, speed, Ground::Turns)];
        let found = spin(&model).unwrap();
        let turn = speed.abs();
        let root = (ja * ja * turn * turn + 4.0 * jt * c).sqrt();
        let tilts = [(ja * turn + root) / (2.0 * jt), (ja * turn - root) / (2.0 * jt)];
        let whirls = [(k / m).sqrt(), -(k / m).sqrt(), (5.0 * k / m).sqrt(), (4.0 * c / ja).sqrt()];
        assert!(found.modes.iter().all(|mode| mode.complex.as_ref().unwrap().growth == 0.0));
        for expected in whirls.into_iter().chain(tilts) {
            let near = found.modes.iter().filter_map(|mode| mode.complex.as_ref().unwrap().fixed_frame);
            let error = near.map(|omega| (omega / expected - 1.0).abs()).min_by(f64::total_cmp).unwrap();
            assert!(error < 1e-9, "{speed}: {expected} {:?}", found.modes);
        }
    }
}

/// Dampers have no part in these modes; a warning says so.
#[test]
fn dampers_of_a_rotor_are_warned_of() {
    let mut model =
        Model::of_bodies(modal(6, true), vec![body("disc", [0.0; 3], 2.0, Some([0.3, 0.3, 0.5]))], vec![]);
    model.loads = vec![turning([0.0, 0.0, 1.0], 7.0, Ground::Turns)];
    for damping in [None, Some([5.0; 6])] {
        let stiffness = Some([800.0, 800.0, 4000.0, 300.0, 300.0, 1200.0]);
        model.bushings = vec![Bushing { stiffness, damping, ..hub() }];
        let mut notes = Notes::default();
        let system =
            tegula::compile::build(&model, &mesh::generators::generate(&model.mesh).unwrap()).unwrap();
        let about = modal::prestress(&system, &mut Silent).unwrap().state;
        modal::run(&system, 6, Some(&about), &mut notes).unwrap();
        let told = notes.warnings.iter().any(|w| w.contains("leave dampers"));
        assert_eq!(told, damping.is_some(), "{:?}", notes.warnings);
    }
}

/// Between the critical speeds of a hub with two stiffnesses the disc is thrown out: `(λ² + a)(λ² + b) + 4 Ω² λ² = 0` with
/// `a = k₁/m − Ω²` and b alike.
#[test]
fn a_hub_of_two_stiffnesses_is_unstable_between_its_critical_speeds() {
    let speed = 25.0;
    let disc = body("disc", [0.0; 3], 1.0, Some([0.1; 3]));
    let mut model = Model::of_bodies(modal(2, true), vec![disc], Vec::new());
    model.bushings = vec![Bushing { stiffness: Some([400.0, 900.0, 1e5, 1e4, 1e4, 1e4]), ..hub() }];
    model.loads = vec![turning([0.0, 0.0, 1.0], speed, Ground::Turns)];
    let found = spin(&model).unwrap();
    let [a, b] = [400.0, 900.0].map(|k| k - speed * speed);
    let half = 0.5 * (a + b + 4.0 * speed * speed);
    let root = (half * half - a * b).sqrt();
    let (growth, omega) = ((root - half).sqrt(), (half + root).sqrt());
    let whirl = found.modes[0].complex.as_ref().unwrap();
    assert!((whirl.growth / growth - 1.0).abs() < 1e-9 && found.modes[0].omega == 0.0, "{found:?}");
    assert!((found.modes[1].omega / omega - 1.0).abs() < 1e-9, "{found:?}");
    // The same hub stands still: there is no relative equilibrium.
    model.loads = vec![turning([0.0, 0.0, 1.0], speed, Ground::Stands)];
    let error = spin(&model).unwrap_err().to_string();
    assert!(error.contains("\"bushing\"") && error.contains("ground = \"turns\""), "{error}");
}

/// Shaft with a disc in its middle (O. Bauchau and others, Multibody Syst. Dyn. 37 (2016) 29–48): at 60 rad/s, above the critical
/// speed of 56.85 rad/s, the second bending pair is at 285.2 and 291.7 rad/s in the fixed frame; the first one stays.
#[test]
fn a_shaft_with_a_disc_splits_its_second_bending_pair_as_in_the_benchmark() {
    let section = BeamSection::Constants(SectionConstants {
        axial: 313.4e6,
        shear: [60.5e6; 2],
        bending: [354.5e3; 2],
        torsion: 272.7e3,
        mass: 11.64,
        inertia: [0.013167; 2],
    });
    let along = [1.0, 0.0, 0.0];
    let point = |name: &str, sides: [&str; 2], at: [f64; 3]| PointJoint {
        name: name.into(),
        between: sides.map(Into::into),
        at,
        second_at: None,
    };
    let end = |at: [f64; 3]| AxisJoint {
        name: "right".into(),
        between: between("ground", "shaft.end"),
        at,
        axis: along,
        second_at: None,
        second_axis: None,
    };
    let shaft = |right: [f64; 3]| {
        let joints = vec![
            Joint::Fixed(point("hub", ["shaft.8", "disc"], [3.0, 0.0, 0.0])),
            Joint::Fixed(point("left", ["ground", "shaft.start"], [0.0; 3])),
            Joint::Cylindrical(end(right)),
        ];
        let disc = body("disc", [3.0, 0.0, 0.0], 70.573, Some([2.0325, 1.0163, 1.0163]));
        let mut model = Model::of_bodies(modal(6, true), vec![disc], joints);
        model.beams =
            vec![Beam::straight("shaft", [[0.0; 3], [6.0, 0.0, 0.0]], 16, [0.0, 1.0, 0.0], section)];
        model.loads = vec![turning(along, 60.0, Ground::Stands)];
        model
    };
    let found = spin(&shaft([6.0, 0.0, 0.0])).unwrap();
    let mut whirls: Vec<f64> =
        found.modes.iter().filter_map(|mode| mode.complex.as_ref().unwrap().fixed_frame).collect();
    whirls.sort_by(f64::total_cmp);
    println!("{whirls:?}");
    for (expected, tolerance) in [(-285.2, 0.005), (-56.85, 0.005), (56.85, 0.005), (291.7, 0.005)] {
        let error = whirls.iter().map(|omega| (omega / expected - 1.0).abs()).min_by(f64::total_cmp).unwrap();
        assert!(error < tolerance, "{expected}: {whirls:?}");
    }
    assert!(found.modes.iter().all(|mode| mode.complex.as_ref().unwrap().growth == 0.0));
    // A bearing beside the axis does not let the shaft turn.
    let error = spin(&shaft([6.0, 0.1, 0.0])).unwrap_err().to_string();
    assert!(error.contains("\"right\""), "{error}");
}

/// A clamped blade that turns about its root: the first flapping frequency over √(EI/(ρA L⁴)) at the angular velocities η in the same
/// unit (A. Wright and others, J. Appl. Mech. 49 (1982) 197–202), and the first one in the plane of rotation, `√(ω² − η²)`.
#[test]
fn a_turning_blade_is_stiffened_by_centrifugal_forces() {
    let (length, width, thickness, modulus) = (1.0, 0.04, 0.01, 1e9);
    let blade = |speed: f64, ground: Ground| {
        let mut m = model(plate([length, width], [40, 2], 0.0), modulus, thickness);
        m.materials
            .values_mut()
            .for_each(|material| *material = Material::Isotropic(Isotropic::new(modulus, 0.0, DENSITY)));
        m.analysis = modal(3, true);
        m.loads = vec![Load::Centrifugal(CentrifugalLoad {
            axis: [0.0, 0.0, 1.0],
            at: [0.0, 0.5 * width, 0.0],
            velocity: speed,
            ground,
            amplitude: None,
        })];
        m
    };
    let unit = |height: f64| (modulus * height * height / (12.0 * DENSITY)).sqrt() / length.powi(2);
    for (eta, flap) in [(2.0, 4.1373), (6.0, 7.3604), (10.0, 11.2023)] {
        let speed = eta * unit(thickness);
        let found = spin(&blade(speed, Ground::Turns)).unwrap();
        let first = found.modes[0].omega / unit(thickness);
        assert!((first / flap - 1.0).abs() < 3e-3, "{eta}: {first} {flap}");
    }
    let error = spin(&blade(1.0, Ground::Stands)).unwrap_err().to_string();
    assert!(error.contains("a support holds") && error.contains("ground = \"turns\""), "{error}");
}

/// A rod that turns about its end grows by ρ Ω² L³/(3 E).
#[test]
fn a_turning_rod_grows_longer() {
    let mut m = model(plate([2.0, 0.1], [8, 1], 0.0), 1e6, 0.05);
    m.materials
        .values_mut()
        .for_each(|material| *material = Material::Isotropic(Isotropic::new(1e6, 0.0, DENSITY)));
    m.analysis = Analysis::Static(StaticAnalysis { linear: true, ..StaticAnalysis::default() });
    m.loads = vec![Load::Centrifugal(CentrifugalLoad {
        axis: [0.0, 0.0, 1.0],
        at: [0.0, 0.05, 0.0],
        velocity: 0.1,
        ground: Ground::Stands,
        amplitude: None,
    })];
    let (mesh, system) = compile(&m);
    let state = statics::run(&system, &static_options(&m), None, &mut Silent).unwrap().state;
    let node = mesh.node_sets["u_max"][0];
    let u = state.u[system.coordinates.position_of[node as usize] as usize][0];
    let expected = DENSITY * 0.01 * 8.0 / 3e6;
    assert!((u / expected - 1.0).abs() < 1e-3, "{u} {expected}");
}

/// A body on a hinge across the axis, which turns with it: `cos θ = m g l/(Ω² D)`, `D = m l² + J₁ − J₃`, and small motions have
/// `ω² = Ω² D sin² θ/(m l² + J₂)`.
#[test]
fn a_turning_pendulum_stands_out_at_the_angle_of_a_governor() {
    let (m, l, [j1, j2, j3], speed, g) = (3.0, 0.4, [0.18, 0.2, 0.05], 8.0, 9.81);
    let d = m * l * l + j1 - j3;
    let cosine: f64 = m * g * l / (speed * speed * d);
    let sine = (1.0 - cosine * cosine).sqrt();
    let bob = RigidBody {
        axes: [[cosine, 0.0, sine], [0.0, 1.0, 0.0]],
        ..body("bob", [l * sine, 0.0, -l * cosine], m, Some([j1, j2, j3]))
    };
    let hinge = revolute("hinge", "ground", "bob", [0.0; 3], [0.0, 1.0, 0.0]);
    let mut governor = Model::of_bodies(modal(1, true), vec![bob], vec![hinge]);
    governor.loads = gravity([0.0, 0.0, -g]);
    governor.loads.push(turning([0.0, 0.0, 1.0], speed, Ground::Turns));
    let found = spin(&governor).unwrap();
    let expected = speed * sine * (d / (m * l * l + j2)).sqrt();
    assert!((found.modes[0].omega / expected - 1.0).abs() < 1e-9, "{found:?} {expected}");
}

/// Above many times its critical speed the rotor of Jeffcott keeps its frequencies, whatever the number of modes.
#[test]
fn a_rotor_far_above_its_critical_speed_has_its_modes() {
    for (speed, modes) in [(35.0, 2), (600.0, 6), (1e4, 3)] {
        let disc = body("disc", [0.0; 3], 2.0, Some([0.3, 0.3, 0.5]));
        let mut model = Model::of_bodies(modal(modes, true), vec![disc], Vec::new());
        model.bushings =
            vec![Bushing { stiffness: Some([800.0, 800.0, 4e3, 300.0, 300.0, 1200.0]), ..hub() }];
        model.loads = vec![turning([0.0, 0.0, 1.0], speed, Ground::Turns)];
        let found = spin(&model).unwrap();
        let [first, second] = [(20.0 - speed).abs(), 20.0 + speed];
        let has = |omega: f64| found.modes.iter().any(|mode| (mode.omega / omega - 1.0).abs() < 1e-8);
        // The others are those of tilting, torsion and translation along the axis.
        assert!(has(first) || has(second) || modes < 6, "{speed}: {found:?}");
        assert!(found.modes.iter().all(|mode| mode.complex.as_ref().unwrap().growth == 0.0), "{speed}");
    }
}

/// Springs beside the axis wind up, and gravity across it turns round: there is no relative equilibrium.
#[test]
fn springs_beside_the_axis_and_loads_across_it_are_refused() {
    let disc = || {
        Model::of_bodies(modal(2, true), vec![body("disc", [0.0; 3], 2.0, Some([0.3, 0.3, 0.5]))], Vec::new())
    };
    let z = [0.0, 0.0, 1.0];
    let mut model = disc();
    let beside = |y: f64| Bushing {
        name: format!("at {y}"),
        at: [0.0, y, 0.0],
        stiffness: Some([1e3, 1e3, 1e3, 0.0, 0.0, 0.0]),
        ..hub()
    };
    model.bushings = vec![beside(0.3), beside(-0.3)];
    model.loads = vec![turning(z, 1.0, Ground::Stands)];
    let error = spin(&model).unwrap_err().to_string();
    assert!(error.contains("wind up"), "{error}");
    for (load, ground, refused) in [
        (gravity([0.0, -9.81, 0.0]).remove(0), Ground::Turns, true),
        (gravity([0.0, 0.0, -9.81]).remove(0), Ground::Stands, false),
        (Load::Force(vector_load("disc", [1.0, 0.0, 0.0])), Ground::Stands, true),
        (Load::Force(vector_load("disc", [1.0, 0.0, 0.0])), Ground::Turns, false),
        (Load::Moment(vector_load("disc", [0.0, 1.0, 0.0])), Ground::Stands, true),
        (Load::Moment(vector_load("disc", [0.0, 0.0, 1.0])), Ground::Turns, false),
    ] {
        let mut model = disc();
        model.bushings = vec![Bushing { stiffness: Some([1e3, 1e3, 1e3, 50.0, 50.0, 50.0]), ..hub() }];
        model.loads = vec![turning(z, 1.0, ground), load.clone()];
        let mesh = mesh::generators::generate(&model.mesh).unwrap();
        let built = tegula::compile::build(&model, &mesh);
        assert_eq!(built.is_err(), refused, "{load:?} {ground:?}");
        if let Err(Error::Model(issues)) = built {
            assert!(issues[0].place.to_string().contains("loads[1]"), "{issues:?}");
        }
    }
}

/// A body on a hinge that turns with it has no stiffness but that of centrifugal forces: the units of mass and time do not matter.
#[test]
fn a_rod_on_a_hinge_stands_out_in_any_units() {
    for (speed, m) in [(1.0, 1.0), (10.0, 0.01), (0.5_f64.sqrt(), 2.0), (2.0, 1.0)] {
        let rod = body("rod", [0.6, 0.0, 0.0], m, Some([0.001 * m, 0.12 * m, 0.12 * m]));
        let hinge = revolute("hinge", "ground", "rod", [0.1, 0.0, 0.0], [0.0, 1.0, 0.0]);
        let mut model = Model::of_bodies(modal(1, true), vec![rod], vec![hinge]);
        model.loads = vec![turning([0.0, 0.0, 1.0], speed, Ground::Turns)];
        let found = spin(&model).unwrap();
        // Flapping: Ω² (1 + m e l/J) about the hinge at the distance e from the axis, J of the rod about it without that about its axis.
        let about = m * 0.25 + 0.12 * m;
        let expected = speed * ((m * 0.25 + 0.12 * m - 0.001 * m + m * 0.1 * 0.5) / about).sqrt();
        assert!((found.modes[0].omega / expected - 1.0).abs() < 1e-8, "{speed} {m}: {found:?} {expected}");
    }
}

/// Transient analyses describe motions in the fixed frame.
#[test]
fn a_transient_analysis_refuses_centrifugal_forces() {
    let mut model = machine(1.0, 1e-2, vec![body("a", [1.0, 0.0, 0.0], 1.0, Some([0.1; 3]))], Vec::new());
    model.loads = vec![turning([0.0, 0.0, 1.0], 1.0, Ground::Stands)];
    let mesh = mesh::generators::generate(&model.mesh).unwrap();
    let Err(Error::Model(issues)) = tegula::compile::build(&model, &mesh) else { panic!() };
    assert!(issues[0].message.contains("fixed frame"), "{issues:?}");
}

/// A soft beam with a body at its end turns about a hinge. Behind its relative equilibrium it goes on steadily: the distance of the body from the
/// axis stays at any step, as the energy–momentum scheme keeps relative equilibria (O. Gonzalez, J. C. Simo, Comput. Methods Appl. Mech. Engrg.
/// 134 (1996) 197–222). Without the static step the body swings by more than its extension.
#[test]
fn a_model_that_is_spun_up_goes_on_steadily() {
    let speed = 2.0;
    let section = BeamSection::Constants(SectionConstants {
        axial: 200.0,
        shear: [100.0; 2],
        bending: [5.0; 2],
        torsion: 5.0,
        mass: 0.5,
        inertia: [1e-3; 2],
    });
    let z = [0.0, 0.0, 1.0];
    let joints = vec![
        revolute("axis", "ground", "arm.start", [0.0; 3], z),
        Joint::Fixed(PointJoint {
            name: "tip".into(),
            between: between("arm.end", "weight"),
            at: [1.0, 0.0, 0.0],
            second_at: None,
        }),
    ];
    let weight = body("weight", [1.0, 0.0, 0.0], 2.0, Some([1e-2; 3]));
    let swing = |step: f64, spun_up: bool| {
        let mut model = machine(1.5, step, vec![weight.clone()], joints.clone());
        model.beams = vec![Beam::straight("arm", [[0.0; 3], [1.0, 0.0, 0.0]], 6, [0.0, 1.0, 0.0], section)];
        let spin = InitialVelocity {
            on: "model".into(),
            velocity: [0.0; 3],
            angular_velocity: [0.0, 0.0, speed],
            center: [0.0; 3],
        };
        let rest = StaticAnalysis::default();
        let loads = vec![turning(z, if spun_up { speed } else { 1e-3 * speed }, Ground::Stands)];
        model.steps = vec![
            AnalysisStep {
                loads,
                locked: vec!["axis".into()],
                ..AnalysisStep::new("spin", Analysis::Static(rest.clone()))
            },
            AnalysisStep {
                initial_velocities: vec![spin],
                ..AnalysisStep::new("go", model.analysis.clone())
            },
        ];
        let mesh = mesh::generators::generate(&model.mesh).unwrap();
        let compiler = tegula::compile::Compiler::new(&model, &mesh).unwrap();
        let system = compiler.system(0, None).unwrap();
        let start = statics::run(&system, &rest, None, &mut Silent).unwrap().state;
        let system = compiler.system(1, Some(start.end_of_step())).unwrap();
        let Analysis::Transient(options) = &model.analysis else { panic!() };
        let mut notes = Notes::keeping();
        dynamics::run(&system, options, None, &mut notes).unwrap();
        assert!(notes.drift() <= 1e-9 * notes.kinetic, "{}", notes.drift());
        let centre = system.coordinates.bodies[0].centre as usize;
        let radius = |state: &State| {
            let x = Vec3::from(system.coordinates.reference[centre]) + Vec3::from(state.u[centre]);
            x.norm()
        };
        let first = radius(&notes.states[0]);
        let changes = notes.states.iter().map(|state| radius(state) - first);
        [first - 1.0, max_norm(changes)]
    };
    for step in [2e-3, 0.02] {
        let [extension, change] = swing(step, true);
        // m Ω² (1 + e)/EA from the weight alone: 0.04/(1 − 0.04).
        assert!(extension > 0.0416 && extension < 0.06, "{extension}");
        assert!(change < 1e-11, "{step}: {change}");
    }
    let [_, swings] = swing(4e-3, false);
    assert!(swings > 0.0416, "{swings}");
}

/// A disc on a bushing whose axis lies obliquely in space turns as one along an axis of coordinates: its centrifugal forces are round-off, and the
/// reference configuration is its equilibrium.
#[test]
fn a_balanced_disc_turns_about_an_oblique_axis() {
    let frequencies = |axis: [f64; 3], at: [f64; 3]| {
        let disc = body("disc", at, 2.0, Some([0.5; 3]));
        let mut model = Model::of_bodies(modal(6, true), vec![disc], Vec::new());
        model.bushings =
            vec![Bushing { at, stiffness: Some([800.0, 800.0, 800.0, 300.0, 300.0, 300.0]), ..hub() }];
        let mut load = turning(axis, 7.0, Ground::Turns);
        if let Load::Centrifugal(load) = &mut load {
            load.at = at;
        }
        model.loads = vec![load];
        spin(&model).unwrap().modes.iter().map(|mode| mode.omega).collect::<Vec<_>>()
    };
    let along = frequencies([0.0, 0.0, 1.0], [0.0; 3]);
    let oblique = frequencies([0.36, 0.48, 0.8], [0.3, -0.7, 1.1]);
    assert_eq!(along.len(), oblique.len());
    for (a, b) in along.iter().zip(&oblique) {
        assert!((a - b).abs() < 1e-7 * along[5], "{along:?} {oblique:?}");
    }
}

/// Torsion of a shaft does not couple with its bending, and does not know of its speed: it is the lowest mode also where bending modes, which the inertia of the
/// turning frame drives away, are below it. The frequency is that of a rod without mass, √(GJ/(l I)), with a third of the polar inertia of the part of the shaft up to the disc
/// and the whole of that behind it.
#[test]
fn torsion_is_found_above_critical_speeds() {
    let (span, disc, shaft) = (1.875, 20.325, 2.0 * 0.013_167);
    let expected = (272_700.0_f64 / span / (disc + shaft * (span / 3.0 + 6.0 - span))).sqrt();
    for (velocity, wanted) in
        [(500.0, 1), (1500.0, 2), (2500.0, 3), (2500.0, 1), (10_000.0, 2), (10_000.0, 12)]
    {
        let model: Model = serde_json::from_value(serde_json::json!({
            "beams": [{ "name": "shaft", "points": [[0, 0, 0], [6, 0, 0]], "elements": 16, "direction": [0, 1, 0],
                        "section": { "type": "constants", "axial": 313.4e6, "shear": [60.5e6, 60.5e6], "bending": [354.5e3, 354.5e3], "torsion": 272.7e3, "mass": 11.64, "inertia": [0.013_167, 0.013_167] } }],
            "bodies": [{ "name": "disc", "at": [span, 0, 0], "mass": 70.573, "inertia": [disc, 10.163, 10.163] }],
            "joints": [{ "type": "fixed", "name": "hub", "between": ["shaft.5", "disc"], "at": [span, 0, 0] },
                       { "type": "fixed", "name": "left", "between": ["ground", "shaft.start"], "at": [0, 0, 0] },
                       { "type": "cylindrical", "name": "right", "between": ["ground", "shaft.end"], "at": [6, 0, 0], "axis": [1, 0, 0] }],
            "loads": [{ "type": "centrifugal", "axis": [1, 0, 0], "velocity": velocity, "ground": "stands" }],
            "analysis": { "type": "modal", "modes": wanted, "prestressed": true }
        }))
        .unwrap();
        let found = spin(&model).unwrap().modes;
        assert_eq!(found.len(), wanted);
        assert!(
            (found[0].omega / expected - 1.0).abs() < 1e-3,
            "{velocity} {wanted} {} {expected}",
            found[0].omega
        );
    }
}
