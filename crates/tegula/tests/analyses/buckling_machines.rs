//! Linear buckling of mechanisms: rigid bars, joints, springs, bushings, beams.

use std::f64::consts::PI;

use crate::buckling::{YOUNG, extrapolated, factors, message};
use crate::common::{on, plate};
use crate::multibody::{self, axis_joint, spring};
use tegula::model::*;

fn buckling_machine(bodies: Vec<RigidBody>, joints: Vec<Joint>, on: &str, force: [f64; 3]) -> Model {
    let analysis = Analysis::Buckling(BucklingAnalysis::new(1));
    let mut m = Model::of_bodies(analysis, bodies, joints);
    m.loads = vec![Load::Force(VectorLoad::new(on, force))];
    m
}

fn bar(name: &str, at: [f64; 3]) -> RigidBody {
    RigidBody::new(name, at, 1.0, Some([0.1, 0.1, 0.1]))
}

fn hinge(name: &str, [a, b]: [&str; 2], x: f64) -> Joint {
    Joint::Revolute(axis_joint(name, a, b, [x, 0.0, 0.0], [0.0, 0.0, 1.0]).into())
}

fn torsion_spring(between: [&str; 2], stiffness: f64) -> TorsionSpring {
    multibody::torsion_spring(between, [0.0, 0.0, 1.0], stiffness)
}

/// Two rigid bars of length L/2 between hinges with a torsion spring k at their common one: with the angle θ of each the energy
/// ½ k (2θ)² − P L θ²/2 gives P = 4 k/L.
#[test]
fn a_column_of_two_rigid_bars_buckles_at_its_spring() {
    let (length, stiffness) = (2.0, 30.0);
    let slide = axis_joint("slide", "ground", "slider", [length, 0.0, 0.0], [1.0, 0.0, 0.0]);
    let joints = vec![
        hinge("foot", ["ground", "left"], 0.0),
        hinge("knee", ["left", "right"], 0.5 * length),
        hinge("head", ["right", "slider"], length),
        Joint::Prismatic(slide.into()),
    ];
    let bodies = vec![
        bar("left", [0.25 * length, 0.0, 0.0]),
        bar("right", [0.75 * length, 0.0, 0.0]),
        bar("slider", [length, 0.0, 0.0]),
    ];
    let mut m = buckling_machine(bodies, joints, "slider", [-1.0, 0.0, 0.0]);
    m.torsion_springs = vec![torsion_spring(["left", "right"], stiffness)];
    // The inertia of the bars, which is a measure of their size, does not matter.
    for inertia in [1e-4, 0.1, 1e3, 1e6] {
        m.bodies.iter_mut().for_each(|body| body.inertia = Some([inertia; 3]));
        let found = factors(&m);
        // An inertia that makes the model look a thousand times as large takes digits from the springs.
        let digits = if inertia > 1.0 { 1e-6 } else { 1e-9 };
        assert!((found[0] / (4.0 * stiffness / length) - 1.0).abs() < digits, "{inertia:e}: {found:?}");
        assert_eq!(found.len(), 1);
    }
    // Without the spring it is a mechanism.
    m.torsion_springs.clear();
    assert!(message(&m).contains("mechanism"), "{}", message(&m));
}

/// A rigid bar of length L on a bushing or on a hinge with a torsion spring k, with a force at its tip: P = k/L.
#[test]
fn a_rigid_bar_on_an_elastic_foot_buckles() {
    let (length, stiffness) = (2.0, 30.0);
    let foot = |joints: Vec<Joint>| {
        buckling_machine(vec![bar("bar", [length, 0.0, 0.0])], joints, "bar", [-1.0, 0.0, 0.0])
    };
    let mut on_hinge = foot(vec![hinge("foot", ["ground", "bar"], 0.0)]);
    on_hinge.torsion_springs = vec![torsion_spring(["ground", "bar"], stiffness)];
    let mut on_bushing = foot(Vec::new());
    on_bushing.bushings = vec![Bushing {
        name: "foot".into(),
        between: ["ground".into(), "bar".into()],
        at: [0.0; 3],
        axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        stiffness: Some([1e6, 1e6, 1e6, 50.0, 2.0 * stiffness, stiffness]),
        stiffness_matrix: None,
        damping: None,
        damping_matrix: None,
        free: [0.0; 6],
    }];
    for m in [on_hinge, on_bushing] {
        let found = factors(&m);
        // The bushing yields across, too: 1/P = L/k to the order of P/(k_y L).
        assert!((found[0] / (stiffness / length) - 1.0).abs() < 1e-4, "{found:?}");
    }
}

/// A point mass between two springs in line, each of length L/2, that is held across by a spring k: the compression P of both springs
/// has the geometric stiffness −4P/L, so that P = k L/4. One of the springs leads to a second mass, on which the force acts.
#[test]
fn springs_in_line_buckle_against_a_spring_across() {
    let (length, across) = (2.0, 3.0);
    let (middle, end) = ([0.5 * length, 0.0, 0.0], [length, 0.0, 0.0]);
    let bodies = vec![RigidBody::new("middle", middle, 1.0, None), RigidBody::new("end", end, 1.0, None)];
    let mut m = buckling_machine(bodies, Vec::new(), "end", [-1.0, 0.0, 0.0]);
    let beside = |at: [f64; 3], axis: usize| {
        let mut anchor = at;
        anchor[axis] += 1.0;
        [anchor, at]
    };
    m.springs = vec![
        spring("left", ["ground", "middle"], [[0.0; 3], middle], 1e3),
        spring("right", ["middle", "end"], [middle, end], 1e3),
        spring("y", ["ground", "middle"], beside(middle, 1), across),
        spring("z", ["ground", "middle"], beside(middle, 2), 2.0 * across),
        spring("end y", ["ground", "end"], beside(end, 1), 1e6),
        spring("end z", ["ground", "end"], beside(end, 2), 1e6),
    ];
    let found = factors(&m);
    assert!((found[0] / (across * length / 4.0) - 1.0).abs() < 1e-5, "{found:?}");
}

/// A strip of L/h = 1000 with a rigid end is no mechanism, though its bending is soft beside its stretching.
#[test]
fn a_thin_strip_with_a_rigid_end_buckles() {
    let (length, width, thickness, young) = (1000.0, 100.0, 1.0_f64, 210e3);
    let analysis = Analysis::Buckling(BucklingAnalysis::new(1));
    let mesh = plate([length, width], [20, 2], 0.0);
    let mut m = Model::new(mesh, analysis, Isotropic::new(young, 0.0, 1.0), thickness);
    m.conditions = vec![Condition::Clamp(on("u_min"))];
    m.bodies = vec![RigidBody { attached: vec!["u_max".into()], ..bar("end", [length, 0.5 * width, 0.0]) }];
    m.loads = vec![Load::Force(VectorLoad::new("end", [-1.0, 0.0, 0.0]))];
    let expected = PI * PI * young * width * thickness.powi(3) / 12.0 / (4.0 * length * length);
    let found = factors(&m)[0];
    assert!((found / expected - 1.0).abs() < 2e-3, "{found} {expected}");
    m.conditions.clear();
    assert!(message(&m).contains("mechanism") || message(&m).contains("moves freely"), "{}", message(&m));
}

/// A column of beam elements, clamped and free: Engesser's load.
#[test]
fn a_column_of_beam_elements_buckles() {
    let size: [f64; 2] = [0.1, 0.2];
    let steel = Isotropic::new(YOUNG, 0.3, 1.0);
    let (area, inertia) = (size[0] * size[1], size[1] * size[0].powi(3) / 12.0);
    let euler = PI * PI * YOUNG * inertia / 4.0;
    let expected = euler / (1.0 + euler / (5.0 / 6.0 * YOUNG / 2.6 * area));
    let model = |n: u32| {
        let clamp = PointJoint {
            name: "clamp".into(),
            between: ["ground".into(), "beam.start".into()],
            at: [0.0; 3],
            second_at: None,
        };
        let mut m = buckling_machine(Vec::new(), vec![Joint::Fixed(clamp)], "beam.end", [-1.0, 0.0, 0.0]);
        let section = BeamSection::Rectangle(RectangularSection { size });
        let ends = [[0.0; 3], [1.0, 0.0, 0.0]];
        m.materials.insert("steel".into(), Material::Isotropic(steel.clone()));
        m.beams = vec![Beam {
            material: Some("steel".into()),
            ..Beam::straight("beam", ends, n, [0.0, 1.0, 0.0], section)
        }];
        m
    };
    let found = extrapolated(model, 16);
    assert!((found / expected - 1.0).abs() < 1e-6, "{found} {expected}");
}

/// A pendulum that stands on a hinge with a torsion spring k: it buckles at P = k/l. A stressed spring whose line passes through the hinge
/// has no effect but a reaction there; bodies and springs of any unit of force have the same factors.
#[test]
fn springs_that_are_stressed_at_the_start_load_the_joints_there() {
    let (length, stiffness) = (2.0, 3.0);
    let pendulum = |unit: f64, stressed: bool| {
        let foot = axis_joint("foot", "ground", "bar", [0.0; 3], [0.0, 0.0, 1.0]);
        let joints = vec![Joint::Revolute(foot.into())];
        let mut m = buckling_machine(vec![bar("bar", [length, 0.0, 0.0])], joints, "bar", [-unit, 0.0, 0.0]);
        m.torsion_springs = vec![torsion_spring(["ground", "bar"], unit * stiffness)];
        if stressed {
            let ends = [[0.0; 3], [length, 0.0, 0.0]];
            let free = spring("stressed", ["ground", "bar"], ends, 10.0 * unit);
            m.springs = vec![SpringDamper { length: Some(0.95 * length), ..free }];
        }
        m
    };
    for unit in [1.0, 1e12, 1e-12] {
        for stressed in [false, true] {
            let found = factors(&pendulum(unit, stressed))[0];
            assert!((found / (stiffness / length) - 1.0).abs() < 1e-9, "{unit:e} {stressed}: {found}");
        }
    }
    // A spring across the hinge would turn the pendulum: the start is no equilibrium.
    let mut m = pendulum(1.0, true);
    m.springs[0].points[0] = [0.0, 1.0, 0.0];
    assert!(message(&m).contains("no equilibrium"), "{}", message(&m));
}

/// A moment that is constant in space has a potential where a body turns about its axis, and none on a beam that bends and twists.
#[test]
fn moments_without_potential_are_refused() {
    let mut m = buckling_machine(
        vec![bar("bar", [1.0, 0.0, 0.0])],
        vec![hinge("foot", ["ground", "bar"], 0.0)],
        "bar",
        [-1.0, 0.0, 0.0],
    );
    m.torsion_springs = vec![torsion_spring(["ground", "bar"], 30.0)];
    m.loads.push(Load::Moment(VectorLoad::new("bar", [0.0, 0.0, 1e-3])));
    assert!((factors(&m)[0] / 30.0 - 1.0).abs() < 1e-9);
    let section = BeamSection::Rectangle(RectangularSection { size: [0.2, 0.01] });
    let beam = Beam {
        material: Some("m".into()),
        ..Beam::straight("b", [[0.0; 3], [2.0, 0.0, 0.0]], 16, [0.0, 0.0, 1.0], section)
    };
    let foot = Joint::Fixed(PointJoint {
        name: "foot".into(),
        between: ["ground".into(), "b.start".into()],
        at: [0.0; 3],
        second_at: None,
    });
    let mut m = Model::of_bodies(Analysis::Buckling(BucklingAnalysis::new(1)), Vec::new(), vec![foot]);
    m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(1e6, 0.3, 1.0)));
    m.beams = vec![beam];
    m.loads = vec![Load::Moment(VectorLoad::new("b.end", [0.0, 1.0, 0.0]))];
    assert!(message(&m).contains("no potential"), "{}", message(&m));
}

/// A beam between a hinge and a body that is fixed to the ground: the joint takes a force on the body, and none goes through the beam.
#[test]
fn loads_that_joints_take_into_the_ground_are_refused() {
    let column = |joint: &str| {
        let text = format!(
            r#"{{
                "analysis": {{ "type": "buckling", "factors": 2 }},
                "materials": {{ "m": {{ "type": "isotropic", "young": 1e9, "poisson": 0.3 }} }},
                "beams": [{{
                    "name": "c", "points": [[0, 0, 0], [1, 0, 0]], "elements": 8, "direction": [0, 0, 1], "material": "m",
                    "section": {{ "type": "rectangle", "size": [0.01, 0.02] }}
                }}],
                "bodies": [{{ "name": "block", "at": [1, 0, 0], "mass": 1, "inertia": [1, 1, 1] }}],
                "joints": [
                    {{ "type": "revolute", "name": "a", "between": ["ground", "c.start"], "at": [0, 0, 0], "axis": [0, 1, 0] }},
                    {{ "type": "revolute", "name": "b", "between": ["block", "c.end"], "at": [1, 0, 0], "axis": [0, 1, 0] }},
                    {joint}
                ],
                "loads": [{{ "type": "force", "on": "block", "value": [-16, 0, 0] }}]
            }}"#
        );
        serde_json::from_str::<Model>(&text).unwrap()
    };
    let fixed = r#"{ "type": "fixed", "name": "g", "between": ["ground", "block"], "at": [1, 0, 0] }"#;
    assert!(message(&column(fixed)).contains("produce no stress"), "{}", message(&column(fixed)));
    let slide = r#"{ "type": "prismatic", "name": "g", "between": ["ground", "block"], "at": [1, 0, 0], "axis": [1, 0, 0] }"#;
    let found = factors(&column(slide));
    let euler = PI * PI * 1e9 * 0.02 * 0.01_f64.powi(3) / 12.0 / 16.0;
    assert!((found[0] / euler - 1.0).abs() < 0.02, "{found:?} {euler}");
}

/// A strip that a prescribed displacement of both ends moves as a whole has no stress but for round-off.
#[test]
fn rigid_prescribed_motions_are_refused() {
    let mut m = Model::new(
        plate([1.0, 0.1], [8, 2], 0.0),
        Analysis::Buckling(BucklingAnalysis::new(1)),
        Isotropic::new(YOUNG, 0.3, 1.0),
        0.01,
    );
    let moved = |on: &str, component: Axis, value: f64| {
        Condition::Prescribe(PrescribeComponent {
            on: on.into(),
            of: NodalVector::Position,
            component,
            value,
            amplitude: None,
        })
    };
    let ends = ["u_min", "u_max"];
    m.conditions = ends
        .iter()
        .flat_map(|on| [moved(on, Axis::X, 0.3), moved(on, Axis::Y, 0.1), moved(on, Axis::Z, 0.2)])
        .collect();
    assert!(message(&m).contains("produce no stress"), "{}", message(&m));
}
