//! Rigid bodies and joints: classical mechanisms against their exact solutions, conservation laws, redundant and singular
//! joints. Sources of the numbers are with each test.

use crate::common::Notes;
use tegula::analysis::{Observer, State, dynamics};
use tegula::model::*;
use tegula::norm::larger;
use tegula::result::joint_reaction;
use tegula::{Mat3, System, Vec3, compile, mesh};

/// A model of bodies in a transient analysis with energy–momentum steps of constant length.
pub fn machine(end: f64, step: f64, bodies: Vec<RigidBody>, joints: Vec<Joint>) -> Model {
    let scheme = Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 });
    let analysis = TransientAnalysis { scheme, time_step: Some(step), ..TransientAnalysis::new(end) };
    Model::of_bodies(Analysis::Transient(analysis), bodies, joints)
}

pub fn body(name: &str, at: [f64; 3], mass: f64, inertia: Option<[f64; 3]>) -> RigidBody {
    RigidBody::new(name, at, mass, inertia)
}

pub fn between(a: &str, b: &str) -> [String; 2] {
    [a.into(), b.into()]
}

/// A spring that is free of force at the start.
pub fn spring(name: &str, [a, b]: [&str; 2], points: [[f64; 3]; 2], stiffness: f64) -> SpringDamper {
    SpringDamper {
        across: None,
        name: name.into(),
        between: between(a, b),
        points,
        stiffness,
        damping: 0.0,
        force: None,
        length: None,
    }
}

/// A torsion spring that is free of moment at the start.
pub fn torsion_spring([a, b]: [&str; 2], axis: [f64; 3], stiffness: f64) -> TorsionSpring {
    TorsionSpring {
        name: "spring".into(),
        between: between(a, b),
        axis,
        stiffness,
        damping: 0.0,
        moment: None,
        free_angle: 0.0,
    }
}

pub fn gravity(value: [f64; 3]) -> Vec<Load> {
    vec![Load::Gravity(GravityLoad { value, amplitude: None })]
}

/// Integrates a machine; returns the system and the final state.
pub fn run(model: &Model, observer: &mut dyn Observer) -> (System, State) {
    let mesh = mesh::generators::generate(&model.mesh).unwrap();
    let system = compile::build(model, &mesh).unwrap();
    let Analysis::Transient(options) = &model.analysis else { panic!("no transient analysis") };
    let outcome = dynamics::run(&system, options, None, observer).unwrap();
    (system, outcome.state)
}

/// Place of a body's mass centre, and its directors as columns.
pub fn pose(system: &System, state: &State, body: usize) -> (Vec3, Mat3) {
    let body = &system.coordinates.bodies[body];
    let at = |v: u32| Vec3::from(system.coordinates.reference[v as usize]) + Vec3::from(state.u[v as usize]);
    (at(body.centre), body.directors.map_or(Mat3::identity(), |d| Mat3::from_columns(&d.map(at))))
}

/// Angular velocity of a body along its own axes.
pub fn spin(system: &System, state: &State, body: usize) -> Vec3 {
    let (_, r) = pose(system, state, body);
    let d = system.coordinates.bodies[body].directors.unwrap();
    let rates = Mat3::from_columns(&d.map(|v| Vec3::from(state.v[v as usize])));
    let skew = r.transpose() * rates;
    Vec3::new(skew.m32 - skew.m23, skew.m13 - skew.m31, skew.m21 - skew.m12) * 0.5
}

/// The free body about its intermediate axis (Dzhanibekov): Ω by elliptic functions, computed with a Runge–Kutta method of
/// order 8 at 1e-13.
#[test]
fn a_free_body_turns_over_about_its_intermediate_axis() {
    let top = RigidBody {
        angular_velocity: [0.01, 10.0, 0.02],
        ..body("top", [0.0; 3], 1.0, Some([1.0, 2.0, 3.0]))
    };
    let error = |step: f64| {
        let mut notes = Notes::default();
        let (system, state) = run(&machine(1.0, step, vec![top.clone()], Vec::new()), &mut notes);
        assert!(notes.drift() <= 1e-10 * notes.kinetic, "{}", notes.drift());
        (spin(&system, &state, 0) - Vec3::new(-3.8133094, 9.2443914, 2.2016985)).norm()
    };
    let errors = [error(4e-3), error(2e-3), error(1e-3)];
    let ratios = [errors[0] / errors[1], errors[1] / errors[2]];
    assert!(ratios.iter().all(|r| (3.8..4.2).contains(r)), "{errors:?}");
}

/// A point mass on a rod without mass, released at the horizontal: exact by elliptic functions (IFToMM benchmark A01).
#[test]
fn a_pendulum_swings_as_elliptic_functions_say() {
    let rod = Joint::Distance(DistanceJoint {
        name: "rod".into(),
        between: between("ground", "mass"),
        points: [[0.0; 3], [-1.0, 0.0, 0.0]],
    });
    let bodies = vec![body("mass", [-1.0, 0.0, 0.0], 1.0, None)];
    let model = Model { loads: gravity([0.0, -9.81, 0.0]), ..machine(10.0, 1e-3, bodies, vec![rod]) };
    let mut notes = Notes::default();
    let (system, state) = run(&model, &mut notes);
    let (x, _) = pose(&system, &state, 0);
    assert!(notes.drift() <= 1e-10 * notes.kinetic, "{}", notes.drift());
    assert!((x - Vec3::new(-0.2750874626, -0.9614192051, 0.0)).norm() < 1e-4, "{x:?}");
}

/// The heavy top of M. Géradin and A. Cardona, *Flexible multibody dynamics* (2001), at its start.
pub fn heavy_top() -> RigidBody {
    let omega = [0.0, 150.0, -4.61538];
    RigidBody {
        angular_velocity: omega,
        velocity: Vec3::from(omega).cross(&Vec3::y()).into(),
        ..body("top", [0.0, 1.0, 0.0], 15.0, Some([0.234375, 0.46875, 0.234375]))
    }
}

/// The heavy top of Géradin and Cardona on a spherical joint: mass centre at 0.1 s by a Runge–Kutta method of order 8.
#[test]
fn a_heavy_top_precesses_and_nutates() {
    let top = heavy_top();
    let joint = Joint::Spherical(PointJoint {
        name: "tip".into(),
        between: between("ground", "top"),
        at: [0.0; 3],
        second_at: None,
    });
    let error = |step: f64| {
        let model = machine(0.1, step, vec![top.clone()], vec![joint.clone()]);
        let model = Model { loads: gravity([0.0, 0.0, -9.81]), ..model };
        let mut notes = Notes::default();
        let (system, state) = run(&model, &mut notes);
        assert!(notes.drift() <= 1e-10 * notes.kinetic, "{}", notes.drift());
        let (x, _) = pose(&system, &state, 0);
        (x - Vec3::new(0.42129666, 0.89457197, -0.14916470)).norm()
    };
    let errors = [error(4e-4), error(2e-4), error(1e-4)];
    assert!(errors[2] < 1e-3, "{errors:?}");
}

pub fn axis_joint(name: &str, a: &str, b: &str, at: [f64; 3], axis: [f64; 3]) -> AxisJoint {
    AxisJoint { name: name.into(), between: between(a, b), at, axis, second_at: None, second_axis: None }
}

pub fn revolute(name: &str, a: &str, b: &str, at: [f64; 3], axis: [f64; 3]) -> Joint {
    Joint::Revolute(axis_joint(name, a, b, at, axis).into())
}

/// Point fixed in a body that is at `x` in the reference configuration.
fn point(system: &System, state: &State, body: usize, x: [f64; 3]) -> Vec3 {
    let at = &system.coordinates.bodies[body];
    let reference = |v: u32| Vec3::from(system.coordinates.reference[v as usize]);
    let axes = Mat3::from_columns(&at.directors.unwrap().map(reference));
    let (place, r) = pose(system, state, body);
    place + r * axes.transpose() * (Vec3::from(x) - reference(at.centre))
}

/// The spatial slider–crank (Haug 1989; IFToMM benchmark) with revolute, spherical, universal and prismatic joints. The slider's
/// way was computed with natural coordinates and an index-1 formulation at 1e-12.
#[test]
fn a_spatial_slider_crank_moves_as_its_ordinary_differential_equation_says() {
    let b = Vec3::new(0.0, -2.0, 1.0) / 5f64.sqrt();
    let (pin, slider) = (Vec3::new(0.0, 0.1, 0.2), Vec3::new(0.2, 0.0, 0.0));
    let along = (slider - pin) / (slider - pin).norm();
    let crank_velocity = Vec3::new(6.0, 0.0, 0.0).cross(&Vec3::new(0.0, 0.0, 0.04));
    let bodies = vec![
        RigidBody {
            velocity: crank_velocity.into(),
            angular_velocity: [6.0, 0.0, 0.0],
            ..body("crank", [0.0, 0.1, 0.16], 0.12, Some([1e-4, 1e-4, 1e-5]))
        },
        RigidBody {
            axes: [along.into(), b.into()],
            velocity: [0.12, -0.24, 0.0],
            angular_velocity: [1.92, -0.96, 0.48],
            ..body("rod", ((pin + slider) * 0.5).into(), 0.5, Some([4e-4, 4e-3, 4e-3]))
        },
        RigidBody { velocity: [0.24, 0.0, 0.0], ..body("slider", slider.into(), 2.0, Some([1e-4; 3])) },
    ];
    let universal = TwoAxesJoint {
        name: "C".into(),
        between: between("slider", "rod"),
        at: slider.into(),
        axes: [[1.0, 0.0, 0.0], b.into()],
        second_at: None,
    };
    let joints = vec![
        revolute("A", "ground", "crank", [0.0, 0.1, 0.12], [1.0, 0.0, 0.0]),
        Joint::Spherical(PointJoint {
            name: "B".into(),
            between: between("crank", "rod"),
            at: pin.into(),
            second_at: None,
        }),
        Joint::Universal(universal),
        Joint::Prismatic(axis_joint("guide", "ground", "slider", slider.into(), [1.0, 0.0, 0.0]).into()),
    ];
    let error = |step: f64| {
        let model = machine(2.5, step, bodies.clone(), joints.clone());
        let mut notes = Notes::default();
        let (system, state) = run(&Model { loads: gravity([0.0, 0.0, -9.81]), ..model }, &mut notes);
        assert!(notes.drift() <= 1e-10 * notes.kinetic, "{}", notes.drift());
        pose(&system, &state, 2).0.x - 0.25655287
    };
    let errors = [error(2e-3), error(1e-3), error(5e-4)];
    assert!(
        (errors[0] / errors[1] - 4.0).abs() < 0.2 && (errors[1] / errors[2] - 4.0).abs() < 0.2,
        "{errors:?}"
    );
    assert!(errors[2].abs() < 1e-5, "{errors:?}");
}

/// Bricard's mechanism: five rods and six hinges, one freedom although none is left by count; one constraint is redundant all
/// the time. Place of the end of the third rod by a least-squares index-1 formulation, six digits (IFToMM benchmark A04).
#[test]
fn bricards_mechanism_moves_although_it_is_overconstrained() {
    let points = [[0., 0., 0.], [1., 0., 0.], [1., -1., 0.], [1., -1., 1.], [0., -1., 1.], [0., 0., 1.]]
        .map(Vec3::from);
    let axes = [[0., 1., 0.], [0., 0., 1.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.], [1., 0., 0.]];
    let name = |i: usize| if i < 5 { format!("rod{}", i + 1) } else { "ground".into() };
    let rod = |i: usize| RigidBody {
        axes: {
            let along = points[i + 1] - points[i];
            [along.into(), if along.x.abs() < 0.5 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] }]
        },
        ..body(&name(i), ((points[i] + points[i + 1]) * 0.5).into(), 1.0, {
            let (s, l) = (0.01, 1.0);
            Some([2.0 * s / 12.0, (l + s) / 12.0, (l + s) / 12.0])
        })
    };
    let joints = (0..6).map(|i| {
        let before = if i == 0 { "ground".to_owned() } else { name(i - 1) };
        revolute(&format!("P{i}"), &before, &name(i), points[i].into(), axes[i])
    });
    let model = machine(1.0, 2e-3, (0..5).map(rod).collect(), joints.collect());
    let mut notes = Notes::default();
    let (system, state) = run(&Model { loads: gravity([0.0, -9.81, 0.0]), ..model }, &mut notes);
    let end = point(&system, &state, 2, [1.0, -1.0, 1.0]);
    assert!(notes.drift() <= 1e-9, "{}", notes.drift());
    assert!((end - Vec3::new(0.5105015, -1.6491676, 0.1401231)).norm() < 1e-5, "{end:?}");
    assert!(
        notes.events.iter().any(|e| e.contains("follow from those of other joints and supports")),
        "{:?}",
        notes.events
    );
}

/// The N-four-bar with two windows passes the position in which all rods are horizontal and the rank of its constraints falls.
/// Exact by its one regular freedom (IFToMM benchmark A02); the library's criterion is an energy error of 0.1 J.
#[test]
fn a_four_bar_passes_its_singular_position() {
    let rod = |name: &str, from: [f64; 2], to: [f64; 2], v: f64, omega: f64| RigidBody {
        shape: Some(BodyShape::Rod(RodShape { length: 1.0 })),
        axes: [[to[0] - from[0], to[1] - from[1], 0.0], [0.0, 0.0, 1.0]],
        velocity: [v, 0.0, 0.0],
        angular_velocity: [0.0, 0.0, omega],
        ..body(name, [0.5 * (from[0] + to[0]), 0.5 * (from[1] + to[1]), 0.0], 1.0, None)
    };
    let mut bodies = Vec::new();
    for i in 0..3 {
        let x = f64::from(i);
        bodies.push(rod(&format!("v{i}"), [x, 0.0], [x, 1.0], 0.5, -1.0));
    }
    for i in 0..2 {
        let x = f64::from(i);
        bodies.push(rod(&format!("h{i}"), [x, 1.0], [x + 1.0, 1.0], 1.0, 0.0));
    }
    let z = [0.0, 0.0, 1.0];
    let mut joints = Vec::new();
    for i in 0..3 {
        joints.push(revolute(&format!("A{i}"), "ground", &format!("v{i}"), [f64::from(i), 0.0, 0.0], z));
    }
    for i in 0..2 {
        let (x, h) = (f64::from(i), format!("h{i}"));
        joints.push(revolute(&format!("B{i}"), &format!("v{i}"), &h, [x, 1.0, 0.0], z));
        joints.push(revolute(&format!("C{i}"), &format!("v{}", i + 1), &h, [x + 1.0, 1.0, 0.0], z));
    }
    let model = machine(10.0, 5e-3, bodies, joints);
    let mut notes = Notes::default();
    let (system, state) = run(&Model { loads: gravity([0.0, -9.81, 0.0]), ..model }, &mut notes);
    let top = point(&system, &state, 0, [0.0, 1.0, 0.0]);
    assert!(notes.drift() < 0.1, "{}", notes.drift());
    assert!((top - Vec3::new(0.3284581, 0.9445185, 0.0)).norm() < 0.05, "{top:?}");
}

/// A soft strip that swings under gravity, 4 × 2 elements, with the corner named `corner` at the origin.
pub fn strip(end: f64, step: f64) -> Model {
    let scheme = Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 });
    let analysis = TransientAnalysis { scheme, time_step: Some(step), ..TransientAnalysis::new(end) };
    let mesh = MeshSource::Plate(PlateMesh::new([1.0, 0.4], [4, 2]));
    let rubber = Isotropic::new(1e6, 0.3, 1e3);
    let model = Model::new(mesh, Analysis::Transient(analysis), rubber, 0.03);
    Model { loads: gravity([0.0, 0.0, -9.81]), ..model }
}

/// Largest difference of the displacements of the nodes of two states.
fn difference(of: &System, a: &State, b: &State) -> f64 {
    let nodal = of.coordinates.position_of.iter().map(|&v| v as usize);
    nodal.map(|v| (Vec3::from(a.u[v]) - Vec3::from(b.u[v])).norm()).fold(0.0, larger)
}

pub fn spherical(a: &str, b: &str, at: [f64; 3]) -> Joint {
    Joint::Spherical(PointJoint { name: format!("{a}-{b}"), between: between(a, b), at, second_at: None })
}

/// A node on a spherical joint to the ground moves as the same node with a support, which is eliminated.
#[test]
fn a_strip_on_a_joint_swings_as_on_a_support() {
    let free = strip(0.4, 4e-3);
    let on = OnSet { on: "u_min_v_min".into() };
    let supported = Model { conditions: vec![Condition::Spherical(on)], ..free.clone() };
    let jointed = Model { joints: vec![spherical("ground", "u_min_v_min", [0.0; 3])], ..free };
    let mut notes = [Notes::default(), Notes::default()];
    let (system, a) = run(&supported, &mut notes[0]);
    let (_, b) = run(&jointed, &mut notes[1]);
    let moved = difference(&system, &a, &State { u: vec![[0.0; 3]; a.u.len()], ..a.clone() });
    let difference = difference(&system, &a, &b);
    assert!(moved > 0.3 && difference < 1e-7, "{difference} of {moved}");
    assert!(notes[1].drift() <= 1e-10 * notes[1].kinetic, "{}", notes[1].drift());
}

/// A point mass on a node by a joint moves the strip as the same mass added to the node.
#[test]
fn a_strip_with_a_point_mass_on_a_joint_moves_as_with_an_added_mass() {
    let on = OnSet { on: "u_min_v_min".into() };
    let free = Model { conditions: vec![Condition::Spherical(on)], ..strip(0.4, 4e-3) };
    let added = AddedMass::Point(MassOn { on: "u_max_v_max".into(), value: 3.0 });
    let heavy = Model { masses: vec![added], ..free.clone() };
    let tip = [1.0, 0.4, 0.0];
    let jointed = Model {
        bodies: vec![body("mass", tip, 3.0, None)],
        joints: vec![spherical("mass", "u_max_v_max", tip)],
        ..free
    };
    let (system, a) = run(&heavy, &mut Notes::default());
    let (_, b) = run(&jointed, &mut Notes::default());
    let difference = difference(&system, &a, &b);
    assert!(difference < 1e-7, "{difference}");
}

/// A free-flying shell with two bodies, each hinged to it by two spherical joints, keeps energy, linear and angular momentum.
#[test]
fn a_free_flying_shell_with_two_hinged_bodies_keeps_energy_and_momenta() {
    let plate = |name: &str, x: f64, omega: [f64; 3]| RigidBody {
        shape: Some(BodyShape::Box(BoxShape { size: [0.5, 0.4, 0.02] })),
        angular_velocity: omega,
        ..body(name, [x, 0.2, 0.0], 2.0, None)
    };
    let model = Model {
        loads: Vec::new(),
        bodies: vec![plate("left", -0.25, [0.0, 4.0, 0.0]), plate("right", 1.25, [0.0, -4.0, 0.0])],
        joints: vec![
            spherical("left", "u_min_v_min", [0.0, 0.0, 0.0]),
            spherical("left", "u_min_v_max", [0.0, 0.4, 0.0]),
            spherical("right", "u_max_v_min", [1.0, 0.0, 0.0]),
            spherical("right", "u_max_v_max", [1.0, 0.4, 0.0]),
        ],
        ..strip(2.0, 2e-3)
    };
    let mut notes = Notes::default();
    let (system, state) = run(&model, &mut notes);
    assert!(notes.drift() <= 1e-9 * notes.kinetic, "{}", notes.drift());
    let (_, angular) = notes.momenta[0];
    let size = notes.kinetic * 2.0;
    for (p, l) in &notes.momenta {
        assert!((p - notes.momenta[0].0).norm() <= 1e-9 * size, "{p}");
        assert!((l - angular).norm() <= 1e-9 * size, "{l}");
    }
    let (_, r) = pose(&system, &state, 0);
    assert!((r - Mat3::identity()).norm() > 0.1, "the bodies turn: {r}");
    assert!(notes.events.iter().any(|e| e.contains("velocities at the start")), "{:?}", notes.events);
}

/// Joints that are open at the start, sides that do not exist, and bodies that cannot be are refused with their keys.
#[test]
fn wrong_bodies_and_joints_are_refused_with_their_keys() {
    let top = body("top", [0.0, 1.0, 0.0], 1.0, Some([1.0, 1.0, 1.0]));
    let refused = |bodies: Vec<RigidBody>, joints: Vec<Joint>| {
        let model = machine(1.0, 0.1, bodies, joints);
        let mesh = mesh::generators::generate(&model.mesh).unwrap();
        let error = compile::build(&model, &mesh).err().expect("the model is wrong");
        error.to_string()
    };
    let heavy = RigidBody { inertia: Some([1.0, 1.0, 2.5]), ..top.clone() };
    assert!(refused(vec![heavy], Vec::new()).contains("exceeds the sum"));
    let nameless = refused(vec![top.clone()], vec![spherical("ground", "tip", [0.0; 3])]);
    assert!(nameless.contains("no body or set of one node \"tip\""), "{nameless}");
    let point = body("point", [1.0, 0.0, 0.0], 1.0, None);
    let beside = refused(vec![point.clone()], vec![spherical("ground", "point", [0.0; 3])]);
    assert!(beside.contains("lies beside \"point\""), "{beside}");
    let axis =
        refused(vec![point], vec![revolute("hinge", "ground", "point", [1.0, 0.0, 0.0], [0.0, 0.0, 1.0])]);
    assert!(axis.contains("\"hinge\" needs an axis"), "{axis}");
    let twice = refused(vec![top.clone(), top.clone()], Vec::new());
    assert!(twice.contains("given twice"), "{twice}");
    let itself = refused(vec![top.clone()], vec![spherical("top", "top", [0.0; 3])]);
    assert!(itself.contains("with itself"), "{itself}");
    let massless = refused(vec![RigidBody { mass: None, ..top }], Vec::new());
    assert!(massless.contains("has no mass"), "{massless}");
}

/// Two joints that fix a body to the ground in different places contradict each other where the body has to move: here a rod of
/// Elliptic trammel: a rod between two sliders on perpendicular guides passes the positions in which one of them turns back.
#[test]
fn a_slider_at_the_end_of_its_rod_turns_back_with_the_joints_closed() {
    let slider = RigidBody {
        velocity: [1.0, 0.0, 0.0],
        ..body("slider", [0.0, 0.0, 0.0], 1.0, Some([1.0, 1.0, 1.0]))
    };
    let rod = RigidBody {
        shape: Some(BodyShape::Rod(RodShape { length: 2.0 })),
        axes: [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        velocity: [0.5, 0.0, 0.0],
        angular_velocity: [0.0, 0.0, 0.5],
        ..body("rod", [0.0, -1.0, 0.0], 1.0, None)
    };
    let z = [0.0, 0.0, 1.0];
    let crank = RigidBody {
        velocity: [0.0; 3],
        angular_velocity: [0.0, 0.0, 0.0],
        ..body("crank", [0.0, -2.0, 0.0], 1.0, Some([0.1, 0.1, 0.1]))
    };
    let joints = vec![
        Joint::Prismatic(axis_joint("guide", "ground", "slider", [0.0; 3], [1.0, 0.0, 0.0]).into()),
        revolute("pin", "slider", "rod", [0.0; 3], z),
        revolute("foot", "crank", "rod", [0.0, -2.0, 0.0], z),
        Joint::Prismatic(axis_joint("well", "ground", "crank", [0.0, -2.0, 0.0], [0.0, 1.0, 0.0]).into()),
    ];
    let mut notes = Notes::default();
    let (system, state) = run(&machine(4.0, 5e-3, vec![slider, rod, crank], joints), &mut notes);
    let (x, _) = pose(&system, &state, 0);
    let (y, _) = pose(&system, &state, 2);
    assert!((x.x.hypot(y.y) - 2.0).abs() < 1e-9, "the rod keeps its length: {x} {y}");
    assert!(notes.drift() <= 1e-10 * notes.kinetic, "{}", notes.drift());
}

/// A rod without mass has no moment about its own points, in either order of its sides, and pulls with the weight and the
/// centrifugal force of the mass.
#[test]
fn a_distance_joint_pulls_along_itself_in_either_order() {
    for order in [["ground", "mass"], ["mass", "ground"]] {
        let mut points = [[0.0; 3], [0.0, -2.0, 0.0]];
        if order[0] == "mass" {
            points.reverse();
        }
        let [a, b] = order;
        let rod = Joint::Distance(DistanceJoint { name: "rod".into(), between: between(a, b), points });
        // The rod ends beside the mass centre.
        let speed = [1.0, 0.0, 0.0];
        let ball =
            RigidBody { velocity: speed, ..body("mass", [0.0, -2.5, 0.0], 3.0, Some([0.1, 0.1, 0.1])) };
        let model = machine(0.5, 1e-3, vec![ball], vec![rod]);
        let (system, state) =
            run(&Model { loads: gravity([0.0, -9.81, 0.0]), ..model }, &mut Notes::default());
        let (force, moment) = joint_reaction(&system, &state, &system.joints[0]);
        assert!(moment.norm() <= 1e-10 * force.norm(), "{moment}");
        let foot = point(&system, &state, 0, [0.0, -2.0, 0.0]);
        let along = if a == "ground" { -foot } else { foot };
        assert!((force.normalize() - along.normalize()).norm() < 1e-3, "{force} {foot}");
        assert!(force.norm() > 0.9 * 3.0 * 9.81, "{force}");
    }
}

/// A moment that is constant in space adds M t to the angular momentum, whatever the step.
#[test]
fn a_constant_moment_adds_its_impulse_to_the_angular_momentum() {
    let load = Load::Moment(VectorLoad::new("disc", [0.0, 0.0, 1e-3]));
    for step in [0.1, 0.01] {
        let disc = body("disc", [0.0; 3], 1.0, Some([1e-3; 3]));
        let model = Model { loads: vec![load.clone()], ..machine(10.0, step, vec![disc], Vec::new()) };
        let mut notes = Notes::default();
        let (system, state) = run(&model, &mut notes);
        let (_, momentum) = notes.momenta[notes.momenta.len() - 1];
        assert!((momentum - Vec3::new(0.0, 0.0, 0.01)).norm() < 1e-12, "{step}: {momentum}");
        let omega = spin(&system, &state, 0).z;
        assert!((omega - 10.0).abs() < 10.0 * (step * 10.0_f64).powi(2) / 4.0, "{step}: {omega}");
    }
}

/// A body that two joints hold, each of them alone enough, rests, and the joints carry its weight.
#[test]
fn a_body_on_two_fixed_joints_rests() {
    let fixed = |name: &str, x: f64| {
        Joint::Fixed(PointJoint {
            name: name.into(),
            between: between("ground", "beam"),
            at: [x, 0.0, 0.0],
            second_at: None,
        })
    };
    let beam = body("beam", [0.5, 0.0, 0.0], 2.0, Some([0.1, 0.4, 0.5]));
    let model = machine(0.2, 1e-3, vec![beam], vec![fixed("left", 0.0), fixed("right", 1.0)]);
    let mut notes = Notes::default();
    let (system, state) = run(&Model { loads: gravity([0.0, 0.0, -10.0]), ..model }, &mut notes);
    let carried: Vec3 = system.joints.iter().map(|joint| joint_reaction(&system, &state, joint).0).sum();
    assert!((carried - Vec3::new(0.0, 0.0, 20.0)).norm() < 1e-9, "{carried}");
    assert!(state.u.as_flattened().iter().all(|u| u.abs() < 1e-12), "{:?}", state.u);
    assert_eq!(state.step, 200, "{:?}", notes.events);
}

/// Automatic steps resolve the rotation of a small body in a large model: the tolerance holds for each body.
#[test]
fn automatic_steps_resolve_the_rotation_of_a_small_body_in_a_large_model() {
    let top = RigidBody { angular_velocity: [0.0, 0.0, 1.0], ..body("top", [0.0; 3], 1e-3, Some([1e-6; 3])) };
    let far = body("far", [100.0, 0.0, 0.0], 1.0, None);
    let scheme = Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 });
    let options = TransientAnalysis { scheme, ..TransientAnalysis::new(10.0) };
    let model = Model::of_bodies(Analysis::Transient(options), vec![top, far], Vec::new());
    let (system, state) = run(&model, &mut Notes::default());
    let (_, r) = pose(&system, &state, 0);
    let angle = r.m21.atan2(r.m11);
    let exact = 10.0 - 4.0 * std::f64::consts::PI;
    assert!((angle - exact).abs() < 5e-3, "{angle} {exact}");
}

/// A point mass between two bars in one line cannot move, but infinitesimally: the run ends with the reason before a row
/// without sense is written.
#[test]
fn a_mass_between_bars_in_one_line_is_refused_before_energy_is_lost() {
    let bar = |name: &str, x: f64| {
        Joint::Distance(DistanceJoint {
            name: name.into(),
            between: between("ground", "mass"),
            points: [[x, 0.0, 0.0], [1.0, 0.0, 0.0]],
        })
    };
    let mass = body("mass", [1.0, 0.0, 0.0], 1.0, None);
    let model = machine(1.0, 1e-3, vec![mass], vec![bar("left", 0.0), bar("right", 2.0)]);
    let model = Model { loads: gravity([0.0, 0.0, -10.0]), ..model };
    let mesh = mesh::generators::generate(&model.mesh).unwrap();
    let system = compile::build(&model, &mesh).unwrap();
    let Analysis::Transient(options) = &model.analysis else { panic!("no transient analysis") };
    let mut notes = Notes::default();
    if let Err(error) = dynamics::run(&system, options, None, &mut notes) {
        assert!(error.to_string().contains("time"), "{error}");
    }
    assert!(notes.drift() < 0.1, "{}", notes.drift());
}

/// The velocity of a support jumps at the kinks of its table: the joints stay closed, and the energy balance holds through the
/// impacts.
#[test]
fn a_body_on_a_driven_strip_passes_kinks_of_the_motion() {
    let drive = PrescribeComponent {
        on: "u_min".into(),
        of: NodalVector::default(),
        component: Axis::Z,
        value: 0.02,
        amplitude: Some("steps".into()),
    };
    let table = TableAmplitude { times: vec![0.0, 0.1, 0.25], values: vec![0.0, 1.0, 0.0] };
    let tip = [1.0, 0.4, 0.0];
    let box_shape = BodyShape::Box(BoxShape { size: [0.2, 0.1, 0.05] });
    let hung = RigidBody { shape: Some(box_shape), ..body("box", [1.1, 0.4, -0.05], 2.0, None) };
    let fix = FixComponents {
        on: "u_min".into(),
        position: vec![Axis::X, Axis::Y],
        director: vec![Axis::X, Axis::Y, Axis::Z],
    };
    let model = Model {
        conditions: vec![Condition::Fix(fix), Condition::Prescribe(drive)],
        amplitudes: [("steps".to_string(), Amplitude::Table(table))].into(),
        bodies: vec![hung],
        joints: vec![spherical("box", "u_max_v_max", tip)],
        ..strip(0.4, 2e-3)
    };
    let mut notes = Notes::default();
    let (system, state) = run(&model, &mut notes);
    assert!(notes.drift() <= 1e-9 * notes.kinetic, "{} of {}", notes.drift(), notes.kinetic);
    let joint = &system.joints[0];
    let node = joint.vectors[joint.vectors.len() - 1] as usize;
    let place = Vec3::from(tip) + Vec3::from(state.u[node]);
    assert!((point(&system, &state, 0, tip) - place).norm() < 1e-10, "{place}");
}

/// A body on two parallel hinges rests under a moment: its places and energies change by round-off alone.
#[test]
fn a_body_on_two_hinges_rests_under_a_moment() {
    let z = [0.0, 0.0, 1.0];
    let hinges = vec![
        revolute("left", "ground", "block", [0.0; 3], z),
        revolute("right", "ground", "block", [0.8, 0.0, 0.0], z),
    ];
    let mut model = machine(0.2, 0.01, vec![body("block", [0.4, 0.0, 0.0], 1.0, Some([0.1; 3]))], hinges);
    model.loads = vec![Load::Moment(VectorLoad::new("block", [0.0, 0.0, 0.5]))];
    let (system, state) = run(&model, &mut Notes::default());
    let (place, _) = pose(&system, &state, 0);
    assert!((place - Vec3::new(0.4, 0.0, 0.0)).norm() < 1e-12, "{place}");
}
