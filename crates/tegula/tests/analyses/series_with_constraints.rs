//! Equilibrium paths by power series of models with quadratic constraints: inextensible directors, rigid bodies, beams, joints.

use crate::arc_length::{Record, by_arc_length, centre, run};
use crate::beams::fixed;
use crate::common::{model, on, plate, vector_load};
use crate::multibody::{axis_joint, between, body, revolute};
use crate::paths::{critical, follow, roof};
use tegula::analysis::path::{CriticalKind, PathOutcome};
use tegula::model::*;
use tegula::{System, Vec3};

/// Outcomes by power series, which are the default, and by the arc-length method.
pub fn both(m: &Model) -> [(System, PathOutcome, Record); 2] {
    let found = [m.clone(), by_arc_length(m)].map(|m| run(&m));
    assert!(found[0].2.events.iter().all(|event| !event.contains("arc-length")), "{:?}", found[0].2.events);
    found
}

/// Distance of the displacements of two outcomes over their size.
pub fn distance([a, b]: [&PathOutcome; 2]) -> f64 {
    let size = |u: &[[f64; 3]]| u.as_flattened().iter().map(|x| x * x).sum::<f64>().sqrt();
    let pairs = a.state.u.iter().zip(&b.state.u);
    let difference: Vec<[f64; 3]> = pairs.map(|(a, b)| std::array::from_fn(|i| a[i] - b[i])).collect();
    size(&difference) / size(&b.state.u)
}

fn path_of(bodies: Vec<RigidBody>, beams: Vec<Beam>, joints: Vec<Joint>, loads: Vec<Load>) -> Model {
    let options = PathAnalysis { end_load: 1.0, ..Default::default() };
    Model { beams, loads, ..Model::of_bodies(Analysis::Path(options), bodies, joints) }
}

/// A beam that hardly stretches, shears and twists, with these bending stiffnesses about z (the first one of a beam along x) and across it.
fn slender(name: &str, points: [[f64; 3]; 2], elements: u32, bending: [f64; 2]) -> Beam {
    let constants = SectionConstants {
        axial: 1e6,
        shear: [1e6; 2],
        bending,
        torsion: 1e3,
        mass: 1.0,
        inertia: [1e-3; 2],
    };
    Beam::straight(name, points, elements, [0.0, 0.0, 1.0], BeamSection::Constants(constants))
}

fn force(on: &str, value: [f64; 3]) -> Load {
    Load::Force(VectorLoad::new(on, value))
}

/// Bilinear shells of inextensible directors (MITC4): both limit points of the hinged roof, and its snap-back.
#[test]
fn a_roof_of_inextensible_directors_has_its_limit_points_in_few_factorisations() {
    let mut m = roof(8, 6.35);
    m.sections[0].element = ElementKind::Mitc4;
    m.sections[0].membrane = None;
    let [(series, _), (arc, _)] = [m.clone(), by_arc_length(&m)].map(|m| follow(&m, "u_min_v_min"));
    let [found, other] = [&series, &arc].map(critical);
    let kinds: Vec<_> = found.iter().map(|p| (p.kind, p.change)).collect();
    assert_eq!(kinds, [(CriticalKind::Limit, 1), (CriticalKind::Limit, -1)]);
    for (point, other) in found.iter().zip(&other) {
        assert!((point.load / other.load - 1.0).abs() < 1e-8, "{} {}", point.load, other.load);
    }
    let counts = [series.statistics.factorizations, arc.statistics.factorizations];
    println!("{counts:?}");
    assert!(counts[0] <= 26 && series.statistics.iterations == 0, "{counts:?}");
}

/// A cantilever under a dead force across its end, P L²/(E I) = 10: K. Mattiasson, Numerical results from large deflection beam and frame
/// problems analysed by means of elliptic integrals, Int. J. Numer. Meth. Engng 17 (1981) 145–153, Table I.
#[test]
fn a_cantilever_of_beams_bends_as_elliptic_integrals_say() {
    let beam = slender("arm", [[0.0; 3], [1.0, 0.0, 0.0]], 128, [1.0; 2]);
    let clamp = fixed("clamp", "ground", "arm.start", [0.0; 3]);
    let m = path_of(Vec::new(), vec![beam], vec![clamp], vec![force("arm.end", [0.0, 0.0, -10.0])]);
    let [(system, series, _), (_, arc, _)] = both(&m);
    let end = centre(&system, &series.state, "arm.end") - Vec3::x();
    assert!((end.x + 0.55500).abs() < 1e-4 && (end.z + 0.81061).abs() < 1e-4 && end.y == 0.0, "{end}");
    assert!(distance([&series, &arc]) < 1e-9, "{}", distance([&series, &arc]));
    assert!(series.statistics.factorizations <= 8, "{}", series.statistics.factorizations);
    let multipliers = series.state.multipliers.iter().zip(&arc.state.multipliers);
    multipliers.for_each(|(a, b)| assert!((a - b).abs() < 1e-7, "{a} {b}"));
}

/// Two clamps of one beam in space: the reactions are shared, the path is the same, and a warning tells of it.
#[test]
fn redundant_joints_share_their_reactions_on_a_path() {
    let beam = slender("arm", [[0.0; 3], [1.0, 0.0, 0.0]], 8, [1.0, 0.5]);
    let clamp = |name: &str| fixed(name, "ground", "arm.start", [0.0; 3]);
    let loads = vec![force("arm.end", [0.0, 2.0, -5.0])];
    let single = path_of(Vec::new(), vec![beam.clone()], vec![clamp("a")], loads.clone());
    let double = path_of(Vec::new(), vec![beam], vec![clamp("a"), clamp("b")], loads);
    let (_, alone, _) = run(&single);
    let (system, twice, record) = run(&double);
    assert!(distance([&twice, &alone]) < 1e-9);
    assert!(
        record.events.iter().any(|event| event.contains("its reactions are not unique")),
        "{:?}",
        record.events
    );
    let n = system.constraints() / 2;
    for (i, whole) in alone.state.multipliers.iter().enumerate() {
        for part in [twice.state.multipliers[i], twice.state.multipliers[n + i]] {
            assert!((part - 0.5 * whole).abs() < 1e-7 * (1.0 + whole.abs()), "{part} {whole}");
        }
    }
}

/// A door on two hinges of one axis, held by a beam: forces of the hinges along the axis are not unique. Both methods, which weigh them with
/// compliances, share them alike.
#[test]
fn a_door_on_two_hinges_has_the_reactions_of_the_arc_length_method() {
    let beam = slender("arm", [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0]], 8, [100.0, 30.0]);
    let ball = PointJoint {
        name: "ball".into(),
        between: between("door", "arm.start"),
        at: [1.0, 0.0, 0.0],
        second_at: None,
    };
    let hinge = |name: &str, z: f64| revolute(name, "ground", "door", [0.0, 0.0, z], [0.0, 0.0, 1.0]);
    let joints = vec![
        fixed("clamp", "ground", "arm.end", [1.0, 1.0, 0.0]),
        hinge("lower", 0.0),
        hinge("upper", 1.0),
        Joint::Spherical(ball),
    ];
    let door = body("door", [0.5, 0.0, 0.5], 1.0, Some([0.1; 3]));
    let m = path_of(vec![door], vec![beam], joints, vec![force("door", [0.0, 50.0, -3.0])]);
    let [(_, series, record), (_, arc, _)] = both(&m);
    assert!(record.events.iter().any(|event| event.contains("not unique")), "{:?}", record.events);
    for (i, (a, b)) in series.state.multipliers.iter().zip(&arc.state.multipliers).enumerate() {
        assert!((a - b).abs() < 1e-5 * (1.0 + b.abs()), "{i}: {a} {b}");
    }
}

/// A column between hinges of which one slides: Euler's load, and the path that branches off there as the arc-length method finds it.
#[test]
fn a_column_of_beams_on_joints_branches_at_eulers_load() {
    let euler = std::f64::consts::PI.powi(2) * 0.5;
    let beam = slender("column", [[0.0; 3], [1.0, 0.0, 0.0]], 32, [0.5, 1.0]);
    let foot = revolute("foot", "ground", "column.start", [0.0; 3], [0.0, 0.0, 1.0]);
    let guide = |name: &str, at| Joint::Cylindrical(axis_joint(name, "ground", "head", at, [1.0, 0.0, 0.0]));
    let head = body("head", [1.0, 0.0, 0.0], 1.0, Some([1.0; 3]));
    let pin = revolute("pin", "head", "column.end", [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    let joints = vec![foot, pin, guide("guide", [1.0, 0.0, 0.0])];
    let mut m = path_of(vec![head], vec![beam], joints, vec![force("head", [-1.2 * euler, 0.0, 0.0])]);
    let [(_, series, _), (_, arc, _)] = both(&m);
    let [found, other] = [&series, &arc].map(critical);
    assert_eq!((found.len(), found[0].kind), (1, CriticalKind::Bifurcation));
    assert!((1.2 * found[0].load - 1.0).abs() < 2e-3, "{}", 1.2 * found[0].load);
    assert!((found[0].load / other[0].load - 1.0).abs() < 1e-7, "{} {}", found[0].load, other[0].load);
    let Analysis::Path(options) = &mut m.analysis else { panic!() };
    options.switch_at = vec![1];
    let [(system, series, _), (_, arc, _)] = both(&m);
    let middle = |outcome: &PathOutcome| centre(&system, &outcome.state, "column.16").y.abs();
    assert!(middle(&series) > 0.3, "{}", middle(&series));
    assert!((middle(&series) / middle(&arc) - 1.0).abs() < 1e-6, "{} {}", middle(&series), middle(&arc));
}

/// Two beams at a right angle, welded with a fixed joint, on hinges, snap through at 18.5 E I/L²: the frame of S. L. Lee, F. S. Manuel, E. C. Rossow,
/// J. Eng. Mech. Div. ASCE 94 (1968) 521–547; J. C. Simo, L. Vu-Quoc, Comput. Methods Appl. Mech. Engrg. 58 (1986) 79–116.
#[test]
fn a_frame_of_beams_snaps_as_by_arc_length() {
    let column = slender("column", [[0.0; 3], [0.0, 1.0, 0.0]], 40, [1.0, 1e3]);
    let girder = slender("girder", [[0.0, 1.0, 0.0], [1.0, 1.0, 0.0]], 40, [1.0, 1e3]);
    let axis = [0.0, 0.0, 1.0];
    let joints = vec![
        revolute("foot", "ground", "column.start", [0.0; 3], axis),
        fixed("corner", "column.end", "girder.start", [0.0, 1.0, 0.0]),
        revolute("wall", "ground", "girder.end", [1.0, 1.0, 0.0], axis),
    ];
    let m = path_of(Vec::new(), vec![column, girder], joints, vec![force("girder.8", [0.0, -20.0, 0.0])]);
    let [(_, series, _), (_, arc, _)] = both(&m);
    let [found, other] = [&series, &arc].map(critical);
    assert!(found.len() >= 2 && found.len() == other.len(), "{found:?} {other:?}");
    for (point, other) in found.iter().zip(&other) {
        assert!((point.load / other.load - 1.0).abs() < 1e-6, "{} {}", point.load, other.load);
    }
    let limit = 20.0 * found[0].load;
    println!("{limit}");
    assert!((limit / 18.5 - 1.0).abs() < 0.01, "{limit}");
    println!("{:?}", [&series, &arc].map(|outcome| outcome.statistics.factorizations));
}

/// A force on a rigid body that an edge of a plate is fixed in, with free and with inextensible directors.
#[test]
fn a_body_on_the_edge_of_a_plate_moves_as_by_arc_length() {
    for element in [ElementKind::Ems, ElementKind::Mitc4] {
        let mut m = model(plate([1.0, 0.2], [8, 2], 0.0), 1e9, 0.01);
        m.sections[0].element = element;
        let mut tip = body("tip", [1.1, 0.1, 0.03], 1.0, Some([1.0; 3]));
        tip.attached = vec!["u_max".into()];
        m.bodies = vec![tip];
        m.loads = vec![force("tip", [0.0, 80.0, 400.0])];
        m.analysis = Analysis::Path(PathAnalysis { end_load: 1.0, ..Default::default() });
        let [(_, series, _), (_, arc, _)] = both(&m);
        assert!(distance([&series, &arc]) < 1e-9, "{}", distance([&series, &arc]));
        assert!(10 * series.statistics.factorizations < arc.statistics.factorizations);
    }
}

/// A strip of MITC4 elements on an elastic foundation c per area buckles in n half waves at `N = D (nπ/L)² + c (L/nπ)²` per width (ν = 0), here two of
/// them (M. Hetényi, *Beams on Elastic Foundation*, 1946): bifurcation and path as by arc length.
#[test]
fn a_strip_on_a_foundation_branches_at_its_load() {
    let (young, thickness, width) = (1e9, 0.01_f64, 0.05);
    let bending = young * thickness.powi(3) / 12.0;
    let stiffness = 6.0 * bending * std::f64::consts::PI.powi(4);
    let euler = |n: f64| {
        let wave = n * std::f64::consts::PI;
        bending * wave * wave + stiffness / (wave * wave)
    };
    let load = euler(2.0);
    assert!(load < euler(1.0) && load < euler(3.0));
    let mut m = model(plate([1.0, width], [40, 1], 0.0), young, thickness);
    m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(young, 0.0, 1.0)));
    m.sections[0].element = ElementKind::Mitc4;
    let guided = FixComponents { on: "u_max".into(), position: vec![Axis::Y, Axis::Z], director: Vec::new() };
    m.conditions = vec![Condition::Hinge(on("u_min")), Condition::Fix(guided)];
    m.foundations = vec![Foundation::Area(AreaFoundation {
        on: "all".into(),
        stiffness: [0.0, 0.0, stiffness],
        normal: 0.0,
        retardation_time: 0.0,
    })];
    m.loads = vec![Load::Edge(vector_load("u_max", [-1.1 * load, 0.0, 0.0]))];
    m.analysis = Analysis::Path(PathAnalysis { end_load: 1.0, ..Default::default() });
    let [(_, series, _), (_, arc, _)] = both(&m);
    let [found, other] = [&series, &arc].map(critical);
    assert!((1.1 * found[0].load - 1.0).abs() < 5e-3, "{}", 1.1 * found[0].load);
    assert!((found[0].load / other[0].load - 1.0).abs() < 1e-7, "{} {}", found[0].load, other[0].load);
}

/// A plate with a body on its edge, by a rigid or a distributing coupling, and a second body that a joint in space holds there, and a ball joint or a hinge
/// in the ground: `tip` and `strut` turn far under a force.
fn strut(element: ElementKind, distributed: bool, (joint, hinge): (Joint, bool)) -> Model {
    let mut m = model(plate([1.0, 0.2], [8, 2], 0.0), 2e9, 0.01);
    m.sections[0].element = element;
    let mut tip = body("tip", [1.1, 0.1, 0.05], 1.0, Some([0.1; 3]));
    if distributed {
        tip.distributed = vec!["u_max".into()];
    } else {
        tip.attached = vec!["u_max".into()];
    }
    m.bodies = vec![tip, body("strut", [1.3, 0.1, 0.2], 1.0, Some([0.1; 3]))];
    let at = [1.5, 0.2, 0.3];
    let ball = PointJoint { name: "ball".into(), between: between("ground", "strut"), at, second_at: None };
    m.joints = match hinge {
        true => vec![joint, revolute("hinge", "ground", "strut", at, [1.0, 1.0, 0.0])],
        false => vec![joint, Joint::Spherical(ball)],
    };
    m.loads = vec![force("strut", [-10.0, 5.0, -20.0]), force("tip", [0.0, 3.0, -10.0])];
    m.analysis = Analysis::Path(PathAnalysis { end_load: 1.0, ..Default::default() });
    m
}

/// Joints of all kinds with axes askew: the path as by the arc-length method, joints closed to round-off, in few factorisations.
#[test]
fn plates_on_joints_in_space_move_as_by_arc_length() {
    let axis = axis_joint("joint", "tip", "strut", [1.2, 0.15, 0.1], [1.0, 2.0, 3.0]);
    let rod = Joint::Distance(DistanceJoint {
        name: "joint".into(),
        between: between("tip", "strut"),
        points: [[1.2, 0.15, 0.1], [1.4, 0.2, 0.4]],
    });
    let joints = [
        (Joint::Cylindrical(axis.clone()), false),
        (Joint::Revolute(axis.clone().into()), false),
        (Joint::Prismatic(axis.clone().into()), false),
        (Joint::Planar(axis), true),
        (rod, true),
    ];
    for (i, joint) in joints.into_iter().enumerate() {
        let (element, distributed) =
            if i % 2 == 0 { (ElementKind::Mitc4, true) } else { (ElementKind::Ems, false) };
        let m = strut(element, distributed, joint);
        let [(system, series, _), (_, arc, _)] = both(&m);
        let (apart, counts) = (distance([&series, &arc]), series.statistics.factorizations);
        assert!(apart < 1e-8, "{i}: {apart}");
        assert!(counts <= 8 && 3 * counts < arc.statistics.factorizations, "{i}: {counts}");
        for joint in system.joints.iter() {
            let drift = tegula::result::joint_drift(&system, &series.state, joint);
            assert!(drift < 1e-11, "{i} {}: {drift}", joint.name);
        }
    }
}

/// A prescribed motion of a node that a joint holds in the ground contradicts it: both methods refuse it with the name of the joint, and a mechanism
/// with the motion that it leaves free; a force on a point that is held moves nothing.
#[test]
fn paths_that_joints_do_not_admit_are_refused() {
    let refusal = |m: &Model| {
        let Analysis::Path(options) = &m.analysis else { panic!("no path") };
        let (_, system) = crate::common::compile(m);
        tegula::analysis::path::run(&system, options, None, &mut tegula::analysis::Silent)
            .unwrap_err()
            .to_string()
    };
    let mut pinned = model(plate([1.0, 0.2], [4, 1], 0.0), 1e9, 0.01);
    let at = [1.0, 0.0, 0.0];
    let pin =
        PointJoint { name: "pin".into(), between: between("ground", "u_max_v_min"), at, second_at: None };
    pinned.joints = vec![Joint::Spherical(pin)];
    pinned.conditions.push(Condition::Prescribe(PrescribeComponent {
        on: "u_max_v_min".into(),
        of: NodalVector::Position,
        component: Axis::Y,
        value: 0.2,
        amplitude: None,
    }));
    pinned.loads.clear();
    pinned.analysis = Analysis::Path(PathAnalysis { end_load: 1.0, ..Default::default() });
    let text = refusal(&pinned);
    assert!(text.contains("joint \"pin\" is open") && text.contains("contradict"), "{text}");

    let hinge = revolute("hinge", "ground", "bar", [0.0; 3], [0.0, 0.0, 1.0]);
    let bar = body("bar", [1.0, 0.0, 0.0], 1.0, Some([0.1; 3]));
    let pendulum = path_of(vec![bar.clone()], Vec::new(), vec![hinge], vec![force("bar", [0.0, -1.0, 0.0])]);
    let text = refusal(&pendulum);
    assert!(text.contains("mechanism") && text.contains("body \"bar\" turns about the axis"), "{text}");

    let ball = PointJoint {
        name: "ball".into(),
        between: between("ground", "tip"),
        at: [1.1, 0.1, 0.05],
        second_at: None,
    };
    let mut held = strut(ElementKind::Ems, false, (Joint::Spherical(ball), false));
    held.bodies.truncate(1);
    held.joints.truncate(1);
    held.loads = vec![force("tip", [0.0, 0.0, -20.0])];
    let text = refusal(&held);
    assert!(text.contains("nothing moves with the load factor"), "{text}");

    // A body between two planar joints slides along the line in which their planes meet, beside a beam that is not strained.
    let beam = slender("arm", [[0.0; 3], [1.0, 0.0, 0.0]], 4, [1.0; 2]);
    let planar = |name: &str, first: &str, axis| {
        Joint::Planar(axis_joint(name, first, "slider", [1.5, 0.1, 0.2], axis))
    };
    let carriage = body("carriage", [1.2, -0.2, -0.3], 1.0, Some([0.1; 3]));
    let joints = vec![
        fixed("clamp", "ground", "arm.start", [0.0; 3]),
        fixed("weld", "arm.end", "carriage", [1.0, 0.0, 0.0]),
        planar("first", "carriage", [0.8, 0.0, 0.6]),
        planar("second", "ground", [-0.5, 0.8, 0.2]),
    ];
    let slider = body("slider", [1.6, 0.0, 0.1], 1.0, Some([0.1; 3]));
    let m = path_of(vec![carriage, slider], vec![beam], joints, vec![force("slider", [-1.0, 2.0, 3.0])]);
    let text = refusal(&m);
    assert!(text.contains("mechanism") && text.contains("body \"slider\" moves along"), "{text}");
}

/// A beam between ball joints is free to spin about its axis: the bifurcation that the path meets at once is round-off of this motion, and a warning says
/// so; hinges hold it.
#[test]
fn bifurcations_of_free_motions_are_warned_of() {
    let section = BeamSection::Rectangle(RectangularSection { size: [0.02, 0.05] });
    let beam = Beam {
        material: Some("steel".into()),
        ..Beam::straight("bar", [[0.0; 3], [1.0, 0.0, 0.0]], 8, [0.0, 0.0, 1.0], section)
    };
    let ball = |name: &str, end: &str, x: f64| {
        Joint::Spherical(PointJoint {
            name: name.into(),
            between: between("ground", end),
            at: [x, 0.0, 0.0],
            second_at: None,
        })
    };
    let joints = vec![ball("left", "bar.start", 0.0), ball("right", "bar.end", 1.0)];
    let mut free = path_of(Vec::new(), vec![beam], joints, vec![force("bar.4", [0.0, 0.0, -100.0])]);
    free.materials.insert("steel".into(), Material::Isotropic(Isotropic::new(2e11, 0.3, 7800.0)));
    let warned = |m: &Model| {
        let (_, outcome, record) = run(m);
        let told = record.events.iter().any(|text| text.contains("\"bar.4\" turns about the axis"));
        (critical(&outcome).len(), told)
    };
    let (bifurcations, told) = warned(&free);
    // Whether round-off makes one is up to the machine.
    assert_eq!(bifurcations > 0, told);
    let hinge = revolute("left", "ground", "bar.start", [0.0; 3], [0.0, 1.0, 0.0]);
    let mut held = free;
    held.joints[0] = hinge;
    assert_eq!(warned(&held), (0, false));
}

/// A strip that is heated between distributing couplings on hinges: forces of couplings and elements cancel at every node, and there are no others. It
/// buckles as by arc length, where the thrust E A α ΔT is Euler's load.
#[test]
fn a_heated_strip_between_distributing_couplings_buckles_as_by_arc_length() {
    let (young, thickness, width) = (1e9, 0.01_f64, 0.1);
    let mut m = model(plate([1.0, width], [16, 1], 0.0), young, thickness);
    let material = Isotropic { expansion: 1e-5, ..Isotropic::new(young, 0.0, 1000.0) };
    m.materials.insert("m".into(), Material::Isotropic(material));
    m.sections[0].element = ElementKind::Mitc4;
    m.conditions.clear();
    m.loads.clear();
    let end = |name: &str, x: f64, set: &str| {
        let mut end = RigidBody::new(name, [x, 0.5 * width, 0.0], 1.0, Some([1.0; 3]));
        end.distributed = vec![set.into()];
        end
    };
    m.bodies = vec![end("left", 0.0, "u_min"), end("right", 1.0, "u_max")];
    let hinge =
        |name: &str, end: &str, x: f64| revolute(name, "ground", end, [x, 0.5 * width, 0.0], [0.0, 1.0, 0.0]);
    m.joints = vec![hinge("first", "left", 0.0), hinge("second", "right", 1.0)];
    let euler = (std::f64::consts::PI * thickness).powi(2) / 12.0 / 1e-5;
    m.prescribed_strains = vec![PrescribedStrain::Thermal(ThermalStrain {
        on: "all".into(),
        temperature: 1.2 * euler,
        gradient: 0.0,
        amplitude: None,
        distribution: None,
    })];
    m.analysis = Analysis::Path(PathAnalysis { end_load: 1.0, ..Default::default() });
    let [(_, series, _), (_, arc, _)] = both(&m);
    let [found, other] = [&series, &arc].map(critical);
    assert!((1.2 * found[0].load - 1.0).abs() < 1e-2, "{}", 1.2 * found[0].load);
    assert!((found[0].load / other[0].load - 1.0).abs() < 1e-7, "{} {}", found[0].load, other[0].load);
}
