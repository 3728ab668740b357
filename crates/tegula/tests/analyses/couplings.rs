//! Distributing couplings: bodies that follow the mean motion of nodes, against loads on edges, added masses, closed forms and
//! conservation laws.

use crate::common::*;
use crate::patches::{clamped, gravity, hub, steps, strip};
use tegula::analysis::modal;
use tegula::element::Nodal;
use tegula::model::*;
use tegula::norm::max_norm;
use tegula::result::joint_reaction;
use tegula::result::reactions::ReactionFinder;
use tegula::{Error, System, Vec3, compile};

const YOUNG: f64 = 2.1e6;
const LENGTH: f64 = 1.0;
const WIDTH: f64 = 0.2;
const THICKNESS: f64 = 0.02;
const END: [f64; 3] = [LENGTH, 0.5 * WIDTH, 0.0];

/// A body without mass that follows sets of the mesh.
fn follower(name: &str, at: [f64; 3], sets: &[&str]) -> RigidBody {
    let distributed = sets.iter().map(|set| (*set).to_owned()).collect();
    RigidBody { mass: None, distributed, ..RigidBody::new(name, at, 1.0, None) }
}

fn with_poisson(mut m: Model, poisson: f64) -> Model {
    for material in m.materials.values_mut() {
        *material = Material::Isotropic(Isotropic::new(YOUNG, poisson, 700.0));
    }
    m
}

/// Largest difference of two fields on the nodal vectors of the mesh over the largest value.
fn difference(a: &[Nodal], b: &[Nodal]) -> f64 {
    let n = a.len().min(b.len());
    max_norm(a[..n].as_flattened().iter().zip(b[..n].as_flattened()).map(|(a, b)| a - b))
        / max_norm(b[..n].as_flattened())
}

fn place(system: &System, u: &[Nodal], v: u32) -> Vec3 {
    Vec3::from(system.coordinates.reference[v as usize]) + Vec3::from(u[v as usize])
}

/// Exact state of uniform tension, σ = F/(W h): the free end contracts by ν σ W/E under a force on the body as under one along
/// the edge. A rigid patch holds the edge together.
#[test]
fn a_force_on_a_following_body_leaves_the_contraction_of_a_strip_free() {
    let poisson = 0.3;
    for element in ElementKind::ALL.iter().copied() {
        let mut m = with_poisson(strip(element, [5, 3], 0.3), poisson);
        let (axial, across) = (vec![Axis::X, Axis::Z], vec![Axis::Y]);
        let fix = |on: &str, position| {
            Condition::Fix(FixComponents { on: on.into(), position, director: vec![Axis::X] })
        };
        m.conditions = vec![fix("u_min", axial), fix("u_min_v_min", across)];
        let force = 1e-4;
        let edge = Load::Edge(vector_load("u_max", [force / WIDTH, 0.0, 0.0]));
        let on_edge = solve(&Model { loads: vec![edge], ..m.clone() }).2.state.u;
        let pulled = |body: RigidBody| {
            let load = Load::Force(vector_load("end", [force, 0.0, 0.0]));
            solve(&Model { bodies: vec![body], loads: vec![load], ..m.clone() })
        };
        let (mesh, system, outcome) = pulled(follower("end", END, &["u_max"]));
        let d = difference(&outcome.state.u, &on_edge);
        assert!(d < 1e-9, "{element:?}: {d:e}");
        let stress = force / (WIDTH * THICKNESS);
        let contraction = |mesh: &tegula::Mesh, system: &System, u: &[Nodal]| {
            let [low, high] = ["u_max_v_min", "u_max_v_max"].map(|set| displacement(mesh, system, u, set).y);
            low - high
        };
        let exact = poisson * stress / YOUNG * WIDTH;
        let found = contraction(&mesh, &system, &outcome.state.u);
        // The body moves with the mean of the edge, here by σ L/E. On this mesh `ancf-full` does not have the exact state, under
        // the load along the edge neither.
        let moved = Vec3::from(outcome.state.u[system.coordinates.bodies[0].centre as usize]);
        if element != ElementKind::AncfFull {
            assert!((found / exact - 1.0).abs() < 1e-4, "{element:?}: {found:e} {exact:e}");
            assert!((moved.x / (stress / YOUNG * LENGTH) - 1.0).abs() < 1e-4, "{element:?}: {moved}");
        }
        let (mesh, system, outcome) = pulled(hub("end", END, &["u_max"]));
        assert!(contraction(&mesh, &system, &outcome.state.u).abs() < 1e-9 * exact);
        assert!(difference(&outcome.state.u, &on_edge) > 1e-3);
    }
}

/// A straight edge turns by its directors about its own line: a moment on the body is one per length of the edge.
#[test]
fn a_moment_on_a_following_body_bends_a_strip_as_one_along_the_edge() {
    let inertia = WIDTH * THICKNESS.powi(3) / 12.0;
    for element in ElementKind::ALL.iter().copied() {
        let mut m = strip(element, [16, 2], 0.0);
        m.conditions = vec![clamped("u_min")];
        let moment = YOUNG * inertia / LENGTH;
        let edge = Load::EdgeMoment(vector_load("u_max", [0.0, -moment / WIDTH, 0.0]));
        let on_edge = solve(&Model { loads: vec![edge], ..m.clone() }).2.state.u;
        let load = Load::Moment(vector_load("end", [0.0, -moment, 0.0]));
        let coupled = Model { bodies: vec![follower("end", END, &["u_max"])], loads: vec![load], ..m };
        let (_, system, outcome) = solve(&coupled);
        let d = difference(&outcome.state.u, &on_edge);
        assert!(d < 1e-7, "{element:?}: {d:e}");
        // A circular arc of the angle M L/(E I) = 1 rad.
        let [d1, ..] = system.coordinates.bodies[0].directors.unwrap();
        let axis = place(&system, &outcome.state.u, d1);
        assert!((axis.z.atan2(axis.x) - 1.0).abs() < 4e-3, "{element:?}: {axis}");
    }
}

/// Thickness of the tube.
const WALL: f64 = 0.01;

/// A tube about z, clamped at z = 0, with the set `dent` of one node of its end.
fn tube(radius: f64, length: f64) -> Model {
    let mesh = MeshSource::Cylinder(CylinderMesh {
        center: [0.0; 3],
        axis: [0.0, 0.0, 1.0],
        start: [1.0, 0.0, 0.0],
        radius,
        angles: [0.0, 360.0],
        length,
        grid: Grid { points: [("dent".to_owned(), [radius, 0.0, length])].into(), ..Grid::uniform(24, 8) },
    });
    let mut m = Model::new(
        mesh,
        Analysis::Static(StaticAnalysis::default()),
        Isotropic::new(YOUNG, 0.3, 700.0),
        WALL,
    );
    m.conditions = vec![clamped("v_min")];
    m
}

/// A torque on the end of a thin tube turns it by T L/(2 π G R³ h) (R. Bredt), here within the error of a polygon of 24 sides and
/// of the thickness; all of it arrives at the clamp, also where the tube is turned far.
#[test]
fn a_torque_on_the_end_of_a_tube_arrives_at_its_clamp() {
    let (radius, length) = (0.1_f64, 0.3);
    let shear = YOUNG / 2.6;
    for angle in [1e-4, 0.1] {
        let torque = angle * std::f64::consts::TAU * shear * radius.powi(3) * WALL / length;
        let mut m = tube(radius, length);
        m.bodies = vec![follower("end", [0.05, 0.0, length + 0.1], &["v_max"])];
        m.loads = vec![Load::Moment(vector_load("end", [0.0, 0.0, torque]))];
        let (_, system, outcome) = solve(&m);
        let u = &outcome.state.u;
        let balance = ReactionFinder::new(&system, None).find(&system, None, &outcome.state);
        let clamp = &balance.supports[0];
        let reaction = Vec3::from(clamp.moment);
        assert!((reaction + Vec3::z() * torque).norm() < 1e-9 * torque, "{angle}: {reaction} {torque}");
        assert!(Vec3::from(clamp.force).norm() * length < 1e-9 * torque, "{angle}: {:?}", clamp.force);
        let [d1, ..] = system.coordinates.bodies[0].directors.unwrap();
        let axis = place(&system, u, d1);
        let turned = axis.y.atan2(axis.x);
        assert!((turned / angle - 1.0).abs() < 0.03, "{angle}: {turned}");
        // The coupling transfers the torque from the body, and no force.
        let (force, moment) = joint_reaction(&system, &outcome.state, &system.joints[0]);
        assert!(
            (moment - Vec3::z() * torque).norm() < 1e-9 * torque && force.norm() * length < 1e-9 * torque
        );
    }
}

/// A force beside the mean of the nodes is that force and its moment there, but for the rotation of the arm.
#[test]
fn a_force_beside_the_mean_of_the_nodes_has_its_moment() {
    let mut m = tube(0.1, 0.3);
    let force = Vec3::new(0.3, -0.2, 0.5) * 1e-5;
    let arm = Vec3::new(0.2, 0.1, 0.1);
    let middle = Vec3::new(0.0, 0.0, 0.3);
    let end = |at: Vec3| follower("end", at.into(), &["v_max"]);
    let push = Load::Force(vector_load("end", force.into()));
    m.loads = vec![push.clone()];
    m.bodies = vec![end(middle + arm)];
    let (mesh, _, beside) = solve(&m);
    m.bodies = vec![end(middle)];
    m.loads = vec![push, Load::Moment(vector_load("end", arm.cross(&force).into()))];
    let centred = solve(&m).2;
    let nodes = 2 * mesh.positions.len();
    let d = difference(&beside.state.u[..nodes], &centred.state.u[..nodes]);
    assert!(d < 1e-4, "{d:e}");
}

/// Strip whose corners at the end share the loads of a body by the weights 1 and 3.
fn weighted(at: [f64; 3]) -> Model {
    let mut m = with_poisson(strip(ElementKind::Ems, [6, 2], 0.0), 0.3);
    m.conditions = vec![clamped("u_min")];
    let body = follower("end", at, &["u_max_v_min", "u_max_v_max"]);
    m.bodies = vec![RigidBody { weights: vec![1.0, 3.0], ..body }];
    m
}

/// A force at the weighted mean of two nodes is a quarter and three quarters of it on them, and the body moves by the weighted mean.
#[test]
fn weights_by_number_share_a_force_between_sets() {
    let m = weighted([LENGTH, 0.75 * WIDTH, 0.0]);
    let force = Vec3::new(2e-3, -1e-3, 4e-3);
    let push = |on: &str, part: f64| Load::Force(vector_load(on, (force * part).into()));
    let (mesh, system, coupled) = solve(&Model { loads: vec![push("end", 1.0)], ..m.clone() });
    let alone = Model { bodies: Vec::new(), ..m.clone() };
    let nodal = vec![push("u_max_v_min", 0.25), push("u_max_v_max", 0.75)];
    let on_nodes = solve(&Model { loads: nodal, ..alone.clone() }).2;
    let d = difference(&coupled.state.u, &on_nodes.state.u);
    assert!(d < 1e-8, "{d:e}");
    let [first, second] =
        ["u_max_v_min", "u_max_v_max"].map(|set| displacement(&mesh, &system, &coupled.state.u, set));
    let moved = Vec3::from(coupled.state.u[system.coordinates.bodies[0].centre as usize]);
    assert!((moved - (first + second * 3.0) / 4.0).norm() < 1e-10 * moved.norm(), "{moved}");
    // Without loads on the body the strip is as soft as without it.
    let loads = vec![push("u_max_v_min", 1.0)];
    let with_body = solve(&Model { loads: loads.clone(), ..m }).2;
    let d = difference(&with_body.state.u, &solve(&Model { loads, ..alone }).2.state.u);
    assert!(d < 1e-8, "{d:e}");
}

/// Forces and moments on a body beside the weighted mean arrive at the clamp.
#[test]
fn loads_on_weighted_nodes_balance() {
    let place_of_body = Vec3::new(1.1, 0.3, 0.05);
    let mut m = weighted(place_of_body.into());
    let (force, moment) = (Vec3::new(2e-4, -1e-4, 4e-4), Vec3::new(3e-5, -1e-5, 2e-5));
    m.loads =
        vec![Load::Force(vector_load("end", force.into())), Load::Moment(vector_load("end", moment.into()))];
    let (_, system, outcome) = solve(&m);
    let balance = ReactionFinder::new(&system, None).find(&system, None, &outcome.state);
    let clamp = &balance.supports[0];
    let reaction = Vec3::from(clamp.force);
    assert!((reaction + force).norm() < 1e-9 * force.norm(), "{reaction}");
    // Moments count about the middle of the clamp.
    let arm = place(&system, &outcome.state.u, system.coordinates.bodies[0].centre)
        - Vec3::new(0.0, 0.5 * WIDTH, 0.0);
    let expected = arm.cross(&force) + moment;
    let found = Vec3::from(clamp.moment);
    assert!((found + expected).norm() < 1e-8 * expected.norm(), "{found} {expected}");
}

/// Equal weights of the nodes of overlapping sets add: one node in two sets has twice the weight.
#[test]
fn a_node_of_two_sets_has_the_sum_of_their_weights() {
    let mut m = weighted([LENGTH, 0.75 * WIDTH, 0.0]);
    m.loads = vec![Load::Force(vector_load("end", [0.0, 0.0, 4e-3]))];
    let once = solve(&m).2.state.u;
    m.bodies[0].distributed.push("u_max_v_max".into());
    m.bodies[0].weights = vec![2.0, 2.0, 4.0];
    let d = difference(&solve(&m).2.state.u, &once);
    assert!(d < 1e-9, "{d:e}");
    let mesh = tegula::mesh::generators::generate(&m.mesh).unwrap();
    for (weights, message) in [
        (vec![1.0, 2.0], "body \"end\" has 2 weights for 3 `distributed` sets"),
        (vec![1.0, 0.0, 2.0], "a weight is 0"),
    ] {
        m.bodies[0].weights = weights;
        let Err(Error::Model(issues)) = compile::build(&m, &mesh) else { panic!("{message}") };
        let found = |issue: &tegula::Issue| {
            issue.place.key == "bodies[0].weights" && issue.message.starts_with(message)
        };
        assert!(issues.iter().any(found), "{issues:?}");
    }
}

/// A shell with a spinning body that hangs on its edge flies freely: energy and both momenta stay.
#[test]
#[ignore = "long"]
fn a_body_that_hangs_on_a_flying_shell_keeps_energy_and_momenta() {
    for (element, order) in
        ElementKind::ALL.iter().map(|element| (*element, 2)).chain([(ElementKind::Ems, 4)])
    {
        let mut m = quarter_cylinder(5, 2.1e6);
        m.sections[0].element = element;
        m.sections[0].thickness = 0.05;
        m = with_poisson(m, 0.3);
        m.conditions = Vec::new();
        let spinning = RigidBody {
            mass: Some(4.0),
            inertia: Some([0.2, 0.3, 0.4]),
            axes: [[0.6, 0.0, 0.8], [0.0, 1.0, 0.0]],
            velocity: [1.0, -2.0, 0.5],
            angular_velocity: [15.0, 5.0, -10.0],
            ..follower("first", [-0.2, 0.6, 0.1], &["u_min"])
        };
        m.bodies = vec![spinning, follower("second", [1.1, 0.5, 1.2], &["u_max"])];
        m.initial_velocities = vec![InitialVelocity {
            on: "all".into(),
            velocity: [0.5, 0.0, 0.0],
            angular_velocity: [3.0, 1.0, -2.0],
            center: [0.0; 3],
        }];
        let mut options = steps(0.12, 5e-3);
        options.scheme = Scheme::EnergyMomentum(EnergyMomentumScheme { order });
        let mut notes = Notes::default();
        let (system, outcome) = move_in_time(&m, &options, &mut notes);
        assert!(outcome.balance.strain > 1e-3 * notes.kinetic, "the shell deforms: {:?}", outcome.balance);
        let drift = notes.drift() / notes.kinetic;
        assert!(drift <= 1e-10, "{element:?}: {drift:e}");
        let (linear, angular) = notes.momenta[0];
        for (p, l) in &notes.momenta {
            assert!((p - linear).norm() <= 1e-10 * linear.norm(), "{element:?}: {p} {linear}");
            assert!((l - angular).norm() <= 1e-10 * angular.norm(), "{element:?}: {l} {angular}");
        }
        // The rotation of the body is the one of the polar decomposition of the motion of the nodes.
        let body = &system.coordinates.bodies[0];
        let (joint, u) = (&system.joints[0], &outcome.state.u);
        assert_eq!(joint.name, "first");
        let open = joint.rows.iter().map(|row| {
            row.form(&joint.vectors.iter().map(|v| place(&system, u, *v)).collect::<Vec<_>>()).abs()
        });
        assert!(max_norm(open) < 1e-9);
        let turned = place(&system, u, body.directors.unwrap()[0]);
        assert!((turned - Vec3::new(0.6, 0.0, 0.8)).norm() > 0.3, "the body turns far: {turned}");
    }
}

/// The rotation of a body after a large motion is that of the polar decomposition by singular values (W. Kabsch 1976), computed
/// from the nodes alone.
#[test]
fn the_rotation_is_that_of_the_best_fit_of_the_nodes() {
    let mut m = tube(0.1, 0.3);
    m.bodies = vec![follower("end", [0.0, 0.0, 0.3], &["v_max"])];
    m.loads = vec![
        Load::Moment(vector_load("end", [5.0, 2.5, 4.0])),
        Load::Force(vector_load("dent", [2.5, 1.5, 0.0])),
    ];
    let (mesh, system, outcome) = solve(&m);
    let u = &outcome.state.u;
    let nodes = mesh.nodes_on("v_max").unwrap();
    let vectors = |of: &[u32]| -> Vec<u32> { nodes.iter().map(|&n| of[n as usize]).collect() };
    let (positions, directors) =
        (vectors(&system.coordinates.position_of), vectors(&system.coordinates.director_of));
    let at = |v: &u32| Vec3::from(system.coordinates.reference[*v as usize]);
    let mean = |x: &dyn Fn(&u32) -> Vec3| positions.iter().map(x).sum::<Vec3>() / positions.len() as f64;
    let now = |v: &u32| place(&system, u, *v);
    let (before, after) = (mean(&at), mean(&now));
    let mut fit: tegula::Mat3 =
        positions.iter().map(|v| (now(v) - after) * (at(v) - before).transpose()).sum();
    fit += directors.iter().map(|v| now(v) * at(v).transpose() * (WALL * WALL / 12.0)).sum::<tegula::Mat3>();
    // The nodes lie in a plane: the third singular value is round-off, and the product of the other matrices may be a reflection.
    let svd = fit.svd(true, true);
    let (left, right) = (svd.u.unwrap(), svd.v_t.unwrap());
    let sign = (left * right).determinant();
    let smallest = svd.singular_values.imin();
    let signs = Vec3::from_fn(|i, _| if i == smallest { sign } else { 1.0 });
    let rotation = left * tegula::Mat3::from_diagonal(&signs) * right;
    let body = &system.coordinates.bodies[0];
    let found = tegula::Mat3::from_columns(&body.directors.unwrap().map(|d| now(&d)));
    assert!((rotation - tegula::Mat3::identity()).norm() > 0.01, "it turns: {rotation}");
    assert!((found - rotation).norm() < 1e-9, "{found} {rotation}");
    assert!((now(&body.centre) - (after + rotation * (Vec3::new(0.0, 0.0, 0.3) - before))).norm() < 1e-9);
}

/// A mass on a body that follows the end of a strip: where the end stays straight and its mean alone moves the mass, as in bending
/// without Poisson's effect, the modes are those of the strip with the mass along its edge; ω² = 3 E I/(L³ (m + 33/140 m_strip))
/// by Rayleigh's quotient with the static deflection.
#[test]
fn a_mass_on_a_following_body_has_the_modes_of_a_mass_along_the_edge() {
    let mass = 50.0;
    let mut m = strip(ElementKind::Mitc4, [16, 2], 0.0);
    m.analysis = Analysis::Modal(ModalAnalysis::new(1));
    m.conditions = vec![clamped("u_min")];
    let along_edge = AddedMass::Edge(MassOn { on: "u_max".into(), value: mass / WIDTH });
    let body = RigidBody { mass: Some(mass), ..follower("end", END, &["u_max"]) };
    let lowest = |m: &Model| {
        let (_, system) = compile(m);
        let found = modal::run(&system, 1, None, &mut Notes::default()).unwrap();
        assert!(found.sturm_checked);
        found.modes[0].omega
    };
    let on_edge = lowest(&Model { masses: vec![along_edge], ..m.clone() });
    let coupled = lowest(&Model { bodies: vec![body], ..m });
    assert!((coupled / on_edge - 1.0).abs() < 1e-9, "{coupled} {on_edge}");
    let inertia = WIDTH * THICKNESS.powi(3) / 12.0;
    let total = mass + 33.0 / 140.0 * 700.0 * LENGTH * WIDTH * THICKNESS;
    let exact = (3.0 * YOUNG * inertia / (LENGTH.powi(3) * total)).sqrt();
    assert!((coupled / exact - 1.0).abs() < 2e-3, "{coupled} {exact}");
}

/// The load of a second static step continues that of the first one, and a motion behind them rests where its load stays.
#[test]
fn steps_continue_the_forces_of_couplings() {
    let mut m = strip(ElementKind::Ems, [8, 2], 0.0);
    m.conditions = vec![clamped("u_min")];
    m.bodies = vec![follower("end", END, &["u_max"])];
    let pull = |factor: f64| {
        vec![
            Load::Force(vector_load("end", [0.0, 0.001 * factor, 0.01 * factor])),
            Load::Moment(vector_load("end", [0.0005 * factor, 0.0, 0.002 * factor])),
        ]
    };
    let whole = solve(&Model { loads: pull(1.0), ..m.clone() }).2.state.u;
    let at_rest = || Analysis::Static(StaticAnalysis::default());
    let mut first = AnalysisStep::new("half", at_rest());
    first.loads = pull(0.5);
    let mut second = AnalysisStep::new("whole", at_rest());
    second.loads = pull(1.0);
    let options = steps(0.1, 0.02);
    let mut third = AnalysisStep::new("motion", Analysis::Transient(options.clone()));
    third.loads = pull(1.0);
    m.steps = vec![first, second, third];
    let mesh = tegula::mesh::generators::generate(&m.mesh).unwrap();
    let compiler = compile::Compiler::new(&m, &mesh).unwrap();
    let mut start = None;
    for step in 0..2 {
        let system = compiler.system(step, start.take()).unwrap();
        let run =
            tegula::analysis::statics::run(&system, &StaticAnalysis::default(), None, &mut Notes::default());
        start = Some(run.unwrap().state.end_of_step());
    }
    let u = start.as_ref().unwrap().u.clone();
    let d = difference(&u, &whole);
    assert!(d < 1e-8, "{d:e}");
    let system = compiler.system(2, start).unwrap();
    let outcome = tegula::analysis::dynamics::run(&system, &options, None, &mut Notes::default()).unwrap();
    let d = difference(&outcome.state.u, &u);
    assert!(d < 1e-7, "the model rests: {d:e}");
}

/// With numerical damping the motion of a body that hangs on a strip is that of the conserving scheme in short steps.
#[test]
fn both_integrators_agree_on_a_body_that_hangs_on_a_strip() {
    let mut m = strip(ElementKind::Ems, [8, 2], 0.0);
    m.conditions = vec![clamped("u_min")];
    let hanging =
        RigidBody { mass: Some(1.0), inertia: Some([2e-3, 3e-3, 4e-3]), ..follower("end", END, &["u_max"]) };
    m.bodies = vec![hanging, follower("mean", [0.5, 0.1, 0.1], &["u_max"])];
    m.loads = vec![gravity([0.0, 0.0, -1.0])];
    let end = |scheme: Scheme| {
        let options = TransientAnalysis { scheme, ..steps(0.5, 2e-3) };
        let (system, outcome) = move_in_time(&m, &options, &mut Notes::default());
        place(&system, &outcome.state.u, system.coordinates.bodies[0].centre) - Vec3::from(END)
    };
    let conserving = end(steps(1.0, 1.0).scheme);
    let damping = end(Scheme::GeneralizedAlpha(GeneralizedAlphaScheme { spectral_radius: 0.9 }));
    assert!((conserving - damping).norm() < 2e-3 * conserving.norm(), "{conserving} {damping}");
    assert!(conserving.norm() > 0.05, "{conserving}");
}

/// A force on a rigid patch is one on an attached node with the moment of its arm.
#[test]
fn a_force_on_the_body_of_a_patch_is_one_on_its_node_with_the_moment_of_its_arm() {
    let mut m = with_poisson(strip(ElementKind::Ems, [6, 2], 0.0), 0.3);
    m.analysis = Analysis::Static(StaticAnalysis { linear: true, ..StaticAnalysis::default() });
    m.conditions = vec![clamped("u_min")];
    m.bodies = vec![hub("end", [1.2, 0.3, 0.1], &["u_max"])];
    let force = Vec3::new(0.02, 0.03, -0.01);
    let node = Vec3::new(LENGTH, 0.0, 0.0);
    let arm = node - Vec3::new(1.2, 0.3, 0.1);
    let loaded = |loads: Vec<Load>| solve(&Model { loads, ..m.clone() }).2.state.u;
    let on_node = loaded(vec![Load::Force(vector_load("u_max_v_min", force.into()))]);
    let on_body = loaded(vec![
        Load::Force(vector_load("end", force.into())),
        Load::Moment(vector_load("end", arm.cross(&force).into())),
    ]);
    let d = difference(&on_body, &on_node);
    assert!(d < 1e-9, "{d:e}");
}

/// Everything that a coupling cannot honour is refused with its place.
#[test]
fn unsuitable_nodes_of_couplings_are_refused_by_name() {
    let refused = |m: &Model, key: &str, words: &[&str]| {
        let mesh = tegula::mesh::generators::generate(&m.mesh).unwrap();
        let Err(Error::Model(issues)) = compile::build(m, &mesh) else { panic!("{key} is taken") };
        let found = issues
            .iter()
            .any(|issue| issue.place.key == key && words.iter().all(|word| issue.message.contains(word)));
        assert!(found, "{key} {words:?}: {issues:?}");
    };
    let mut m = strip(ElementKind::Ems, [4, 2], 0.0);
    m.conditions = vec![clamped("u_min")];
    m.bodies = vec![follower("end", END, &["u_max"])];
    m.loads = vec![Load::Force(vector_load("end", [0.0, 0.0, 1.0]))];
    let change = |f: &dyn Fn(&mut Model)| {
        let mut changed = m.clone();
        f(&mut changed);
        changed
    };
    let on = |sets: &'static [&'static str]| {
        move |m: &mut Model| m.bodies[0].distributed = sets.iter().map(|set| (*set).to_owned()).collect()
    };
    let key = "bodies[0].distributed";
    refused(&change(&on(&["no"])), "bodies[0].distributed[0]", &["no"]);
    refused(&change(&on(&["u_max_v_min"])), key, &["end", "one node"]);
    refused(&change(&on(&["u_min", "v_min"])), key, &["end", "conditions[0]", "all directions"]);
    refused(
        &change(&|m| m.bodies.push(hub("plate", [1.0; 3], &["v_min"]))),
        key,
        &["end", "plate", "attached"],
    );
    refused(&change(&|m| m.bodies[0].attached = vec!["v_min".into()]), key, &["attached", "distributed"]);
    let joint = Joint::Spherical(PointJoint {
        name: "end".into(),
        between: ["ground".into(), "end".into()],
        at: END,
        second_at: None,
    });
    refused(&change(&|m| m.joints = vec![joint.clone()]), "joints[0].name", &["end", "columns"]);
    refused(
        &change(&|m| {
            m.analysis = Analysis::Static(StaticAnalysis { linear: true, ..StaticAnalysis::default() })
        }),
        "analysis",
        &["nonlinear static"],
    );
    let explicit = Scheme::Newmark(NewmarkScheme::default());
    refused(
        &change(&|m| {
            m.analysis = Analysis::Transient(TransientAnalysis { scheme: explicit, ..steps(1.0, 0.1) })
        }),
        "analysis",
        &["energy-momentum"],
    );
    refused(
        &change(&|m| {
            m.mesh = plate([LENGTH, WIDTH], [60, 20], 0.0);
            m.bodies[0].distributed = vec!["all".into()];
            m.conditions.clear();
        }),
        key,
        &["end", "at most 1020"],
    );
}

/// Nodes of sheets that stand on each other without being connected.
#[test]
fn nodes_in_one_place_or_on_a_line_along_their_directors_are_refused() {
    let mut m = strip(ElementKind::Ems, [4, 2], 0.0);
    let sheet = tegula::mesh::generators::generate(&m.mesh).unwrap();
    let corner = sheet.nodes_on("u_max_v_min").unwrap()[0];
    let count = sheet.positions.len() as u32;
    m.conditions = vec![clamped("left")];
    m.bodies = vec![follower("end", END, &["corners"])];
    m.loads = vec![Load::Force(vector_load("end", [0.0, 0.0, 1.0]))];
    for (height, word) in [(0.0, "one place"), (0.3, "on a line")] {
        let mut mesh = side_by_side(&[sheet.clone(), sheet.clone()]);
        for x in &mut mesh.positions[count as usize..] {
            x.z = height;
        }
        mesh.node_sets.insert("corners".into(), vec![corner, corner + count]);
        mesh.node_sets.insert("left".into(), sheet.nodes_on("u_min").unwrap());
        let Err(Error::Model(issues)) = compile::build(&m, &mesh) else { panic!("{word} is taken") };
        let found = issues
            .iter()
            .any(|issue| issue.place.key == "bodies[0].distributed" && issue.message.contains(word));
        assert!(found, "{word}: {issues:?}");
    }
}
