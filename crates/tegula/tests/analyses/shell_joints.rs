//! Joints of the directors of shell nodes: against supports, which are eliminated, and against beam theory.

use crate::common::*;
use crate::modes_with_joints::{modal, omegas};
use crate::multibody::{axis_joint, between, pose};
use crate::patches::{clamped, fixed, gravity, hub, steps, strip};
use tegula::element::Nodal;
use tegula::mesh::generators::generate;
use tegula::model::*;
use tegula::norm::max_norm;
use tegula::result::joint_reaction;
use tegula::{Vec3, compile as compiler};

/// Young's modulus, width and thickness of the strip, and its second moment of area.
const YOUNG: f64 = 2.1e6;
const WIDTH: f64 = 0.2;
const THICKNESS: f64 = 0.02;
const INERTIA: f64 = WIDTH * THICKNESS * THICKNESS * THICKNESS / 12.0;

/// Joints of the nodes of an edge of the strip with another side, made by `joint` from a name, the set and the position of the node.
pub fn on_edge(m: &mut Model, x: f64, joint: &dyn Fn(String, &str, [f64; 3]) -> Joint) {
    for (i, p) in generate(&m.mesh).unwrap().positions.iter().enumerate() {
        if (p.x - x).abs() < 1e-9 {
            m.joints.push(joint(format!("joint{i}"), &format!("node{i}"), (*p).into()));
        }
    }
}

/// Mesh of a model with a set `node0`, `node1`, … for each node.
pub fn mesh_of(m: &Model) -> tegula::Mesh {
    let mut mesh = generate(&m.mesh).unwrap();
    for node in 0..mesh.positions.len() as u32 {
        mesh.node_sets.insert(format!("node{node}"), vec![node]);
    }
    mesh
}

fn aligned(name: String, between: [String; 2]) -> Joint {
    Joint::DirectorAlignment(DirectorJoint { name, between })
}

/// Joint that holds the position and the director of a node.
pub fn clamp(name: String, between: [String; 2], at: [f64; 3]) -> Joint {
    Joint::ClampedDirector(PointJoint { name, between, at, second_at: None })
}

fn fix(on: &str, position: &[Axis], director: &[Axis]) -> Condition {
    Condition::Fix(FixComponents { on: on.into(), position: position.to_vec(), director: director.to_vec() })
}

fn compile_named(m: &Model) -> (tegula::Mesh, tegula::System) {
    let mesh = mesh_of(m);
    let system = compiler::build(m, &mesh).unwrap();
    (mesh, system)
}

fn solve_named(m: &Model) -> (tegula::Mesh, tegula::System, tegula::analysis::State) {
    let (mesh, system) = compile_named(m);
    let outcome =
        tegula::analysis::statics::run(&system, &static_options(m), None, &mut Notes::default()).unwrap();
    (mesh, system, outcome.state)
}

fn refused(m: &Model) -> String {
    compiler::build(m, &mesh_of(m)).err().unwrap().to_string()
}

fn difference(a: &[Nodal], b: &[Nodal]) -> f64 {
    let pairs = a.as_flattened().iter().zip(b.as_flattened());
    max_norm(pairs.map(|(a, b)| a - b)) / max_norm(b.as_flattened())
}

/// Joints with the ground hold exactly the components that supports eliminate, in large rotations of the rest.
#[test]
fn joints_of_directors_with_the_ground_are_supports() {
    use Axis::{X, Y, Z};
    let ground = |set: &str| between("ground", set);
    let hinge = |name: String, set: &str, at| {
        Joint::Revolute(axis_joint(&name, "ground", set, at, [0.0, 2.0, 0.0]).into())
    };
    let cross = |name: String, set: &str, at| {
        let axes = [[0.0, 1.0, 0.0], [0.0, 0.0, -1.0]];
        Joint::Universal(TwoAxesJoint { name, between: ground(set), at, axes, second_at: None })
    };
    type Maker<'a> = &'a dyn Fn(String, &str, [f64; 3]) -> Joint;
    let cases: [(&str, Maker, Condition); 4] = [
        ("alignment", &|name, set, _| aligned(name, ground(set)), fix("u_max", &[], &[X, Y])),
        ("clamp", &|name, set, at| clamp(name, ground(set), at), fix("u_max", &[X, Y, Z], &[X, Y])),
        ("hinge", &hinge, fix("u_max", &[X, Y, Z], &[Y])),
        ("universal", &cross, fix("u_max", &[X, Y, Z], &[Y])),
    ];
    for element in ElementKind::ALL.iter().copied() {
        let mut motions = Vec::new();
        for (name, joint, support) in &cases {
            let mut m = strip(element, [6, 2], 0.2);
            m.conditions = vec![clamped("u_min")];
            m.loads = vec![gravity([0.0, 0.5, -3.0])];
            let mut jointed = m.clone();
            on_edge(&mut jointed, 1.0, joint);
            m.conditions.push(support.clone());
            let (a, b) = (solve_named(&jointed).2.u, solve_named(&m).2.u);
            let d = difference(&a, &b);
            println!("{element:?} {name}: {d:e}");
            assert!(d < 1e-8, "{element:?} {name}: {d}");
            motions.push(a);
        }
        for (a, b) in [(0, 1), (1, 2)] {
            let d = difference(&motions[a], &motions[b]);
            assert!(d > 0.1, "{element:?}: cases {a} and {b} differ by {d} only");
        }
    }
}

/// A cantilever whose tip is guided: its directors stay parallel to those of the ground while it moves. The deflection under a force
/// at the tip is F L³/(12 E I).
#[test]
fn a_guided_tip_deflects_as_beam_theory_says() {
    for element in [ElementKind::Ems, ElementKind::Mitc4] {
        let mut m = strip(element, [32, 2], 0.0);
        m.conditions = vec![clamped("u_min")];
        on_edge(&mut m, 1.0, &|name, set, _| aligned(name, between("ground", set)));
        let wanted = 1e-4;
        let force = 12.0 * YOUNG * INERTIA * wanted / WIDTH;
        m.loads = vec![Load::Edge(vector_load("u_max", [0.0, 0.0, force]))];
        let (mesh, system, state) = solve_named(&m);
        let found = displacement(&mesh, &system, &state.u, "u_max_v_min").z;
        // Shear adds 12 E I/(κ G A L²) = 4.8e-4 of it, with ν = 0 and κ = 5/6 or 1.
        println!("{element:?}: {}", found / wanted - 1.0);
        assert!((found / wanted - 1.0).abs() < 2e-3, "{element:?}: {found}");
        let moment: f64 = system.joints.iter().map(|joint| joint_reaction(&system, &state, joint).1.y).sum();
        let exact = 0.5 * force * WIDTH;
        assert!((moment.abs() / exact - 1.0).abs() < 2e-3, "{element:?}: {moment} {exact}");
    }
}

/// A body on the clamped directors of an edge bends the strip by its moment into a circle, as one to which the edge is attached.
#[test]
fn a_moment_on_a_body_with_clamped_directors_bends_a_strip_into_a_circle() {
    let angle: f64 = 1.5;
    let mut m = strip(ElementKind::Ems, [16, 2], 0.0);
    m.conditions = vec![clamped("u_min")];
    let at = [1.0, 0.5 * WIDTH, 0.0];
    m.bodies = vec![RigidBody::new("tip", at, 1.0, Some([1.0; 3]))];
    on_edge(&mut m, 1.0, &|name, set, at| clamp(name, between("tip", set), at));
    m.loads = vec![Load::Moment(vector_load("tip", [0.0, -angle * YOUNG * INERTIA, 0.0]))];
    let (_, system, state) = solve_named(&m);
    let (place, axes) = pose(&system, &state, 0);
    let turned = axes[(2, 0)].atan2(axes[(0, 0)]);
    println!("turned by {turned}");
    assert!((turned - angle).abs() < 4e-3 * angle, "{turned}");
    let exact = Vec3::new(angle.sin() / angle, 0.1, (1.0 - angle.cos()) / angle);
    assert!((place - exact).norm() < 4e-3, "{place}");
}

/// A driven body turns a node's director by three quarters of a turn: it stays along the axis of the body, not against it.
#[test]
fn a_director_follows_its_axis_beyond_half_a_turn() {
    let exact = Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 });
    let damped = Scheme::GeneralizedAlpha(GeneralizedAlphaScheme { spectral_radius: 0.8 });
    for (element, scheme) in
        [(ElementKind::Ems, exact), (ElementKind::Mitc4, exact), (ElementKind::Ems, damped)]
    {
        let mut m = strip(element, [4, 2], 0.0);
        let stiff = Isotropic::new(1e3 * YOUNG, 0.0, 700.0);
        m.materials.insert("m".into(), Material::Isotropic(stiff));
        m.bodies = vec![RigidBody::new("drum", [-0.1, 0.1, 0.0], 1.0, Some([0.1; 3]))];
        let y = [0.0, 1.0, 0.0];
        m.joints.push(Joint::Revolute(axis_joint("bearing", "ground", "drum", [-0.1, 0.1, 0.0], y).into()));
        m.joints.push(Joint::DrivenAngle(DrivenAngleJoint {
            name: "motor".into(),
            between: between("ground", "drum"),
            axis: y,
            angle: 270.0,
            amplitude: "turn".into(),
        }));
        m.amplitudes.insert(
            "turn".into(),
            Amplitude::Expression(ExpressionAmplitude { expression: "0.5*(1 - cos(PI*t))".into() }),
        );
        on_edge(&mut m, 0.0, &|name, set, at| clamp(name, between("drum", set), at));
        let options = TransientAnalysis { scheme, ..steps(1.0, 0.01) };
        m.analysis = Analysis::Transient(options.clone());
        let (mesh, system) = compile_named(&m);
        let mut notes = Notes::default();
        let state = tegula::analysis::dynamics::run(&system, &options, None, &mut notes).unwrap().state;
        let node = mesh.nodes_on("u_min_v_min").unwrap()[0];
        let v = system.coordinates.director_of[node as usize] as usize;
        let d = Vec3::from(system.coordinates.reference[v]) + Vec3::from(state.u[v]);
        // Three quarters of a turn about y take z to −x.
        assert!((d.normalize() + Vec3::x()).norm() < 1e-9, "{element:?}: {d}");
        println!("{element:?} {scheme:?}: drift {:e} of {:e}", notes.drift(), notes.kinetic);
        if scheme == exact {
            assert!(notes.drift() <= 1e-9 * notes.kinetic, "{element:?}: {}", notes.drift());
        }
    }
}

/// A strip whose edge is held by joints has the modes of one held by supports.
#[test]
fn a_strip_on_clamped_directors_has_the_modes_of_a_cantilever() {
    for element in ElementKind::ALL.iter().copied() {
        let mut m = strip(element, [6, 1], 0.0);
        m.analysis = modal(4, false);
        let mut jointed = m.clone();
        for (set, y) in [("u_min_v_min", 0.0), ("u_min_v_max", WIDTH)] {
            jointed.joints.push(clamp(set.into(), between("ground", set), [0.0, y, 0.0]));
        }
        m.conditions = vec![fix("u_min", &[Axis::X, Axis::Y, Axis::Z], &[Axis::X, Axis::Y])];
        let [found, wanted] = [omegas(&jointed), omegas(&m)];
        println!("{element:?}: {found:?} {wanted:?}");
        assert_eq!((found.len(), wanted.len()), (4, 4));
        for (a, b) in found.iter().zip(&wanted) {
            assert!((a / b - 1.0).abs() < 1e-8, "{element:?}: {found:?} {wanted:?}");
        }
    }
}

/// Joints that need more than a director are refused with the reason.
#[test]
fn joints_that_directors_cannot_have_are_refused_with_the_reason() {
    let with = |joint: Joint| {
        let mut m = strip(ElementKind::Ems, [4, 2], 0.0);
        m.bodies = vec![hub("hub", [0.0, 0.1, 0.0], &["u_min"])];
        m.joints = vec![fixed("hub", [0.0, 0.1, 0.0]), joint];
        m.loads = vec![gravity([0.0, 0.0, -1.0])];
        m
    };
    let at = [1.0, 0.0, 0.0];
    let corner = "u_max_v_min";
    let lean = [0.5, 0.0, 0.75_f64.sqrt()];
    let text = refused(&with(Joint::Revolute(axis_joint("hinge", "ground", corner, at, lean).into())));
    assert!(
        text.contains("not perpendicular to the director") && text.contains("30.000000 degrees"),
        "{text}"
    );
    let text = refused(&with(Joint::Universal(TwoAxesJoint {
        name: "cross".into(),
        between: between("ground", corner),
        at,
        axes: [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]],
        second_at: None,
    })));
    assert!(text.contains("not along its director") && text.contains("90.000000 degrees"), "{text}");
    let text = refused(&with(aligned("two".into(), between("u_max_v_max", corner))));
    assert!(text.contains("directors of two shell nodes"), "{text}");
    let text = refused(&with(aligned("none".into(), between("ground", "hub"))));
    assert!(text.contains("neither of its sides"), "{text}");
    let text = refused(&with(Joint::Fixed(PointJoint {
        name: "weld".into(),
        between: between("ground", corner),
        at,
        second_at: None,
    })));
    assert!(text.contains("\"weld\" needs an axis") && text.contains("clamped-director"), "{text}");
}
