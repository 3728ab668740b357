//! Joints, springs and sensors on points inside shell elements.

use crate::common::{Notes, compile, model, plate, solve, static_options, vector_load};
use crate::multibody::{between, body};
use tegula::analysis::{Silent, dynamics, statics};
use tegula::model::*;
use tegula::result::joint_reaction;
use tegula::{Error, Vec3, mesh};

fn ball(name: &str, sides: [&str; 2], at: [f64; 3]) -> Joint {
    Joint::Spherical(PointJoint { name: name.into(), between: sides.map(Into::into), at, second_at: None })
}

/// Cantilever with the load P at its end and a prop at a place a inside an element, free to slide: `R = P (3 L − a)/(2 a)`.
#[test]
fn a_prop_inside_an_element_carries_the_reaction_of_beam_theory() {
    let (length, a, load) = (1.0, 0.6137, 1e-5);
    let reaction = |elements: u32| {
        let mut m = model(plate([length, 0.1], [elements, 3], 0.0), 1e6, 0.02);
        m.materials
            .values_mut()
            .for_each(|material| *material = Material::Isotropic(Isotropic::new(1e6, 0.0, 1.0)));
        m.loads = vec![Load::Force(vector_load("u_max", [0.0, 0.0, load / 4.0]))];
        m.joints = vec![Joint::Distance(DistanceJoint {
            name: "prop".into(),
            between: between("ground", "all"),
            points: [[a, 0.05, -3.0], [a, 0.05, 0.0]],
        })];
        let (_, system) = compile(&m);
        let state = statics::run(&system, &static_options(&m), None, &mut Silent).unwrap().state;
        joint_reaction(&system, &state, &system.joints[0]).0.norm()
    };
    let exact = load * (3.0 * length - a) / (2.0 * a);
    let errors = [10, 40].map(|n| (reaction(n) / exact - 1.0).abs());
    // Shear makes the reaction a little smaller, in proportion to (t/L)².
    assert!(errors[1] < 3e-3 && errors[1] < errors[0], "{errors:?}");
}

/// A point of a set of elements that is a node is that node.
#[test]
fn a_point_at_a_corner_of_an_element_is_the_node() {
    let solved = |name: &str| {
        let mut m = model(plate([1.0, 0.5], [4, 2], 0.2), 1e6, 0.05);
        m.loads = vec![Load::Force(vector_load("u_max_v_min", [0.0, 0.0, 0.05]))];
        m.springs = vec![SpringDamper {
            across: None,
            name: "spring".into(),
            between: between("ground", name),
            points: [[1.0, 0.5, -1.0], [1.0, 0.5, 0.0]],
            stiffness: 3.0,
            damping: 0.0,
            force: None,
            length: None,
        }];
        solve(&m).2.state
    };
    let [node, point] = ["u_max_v_max", "all"].map(solved);
    for (a, b) in node.u.iter().zip(&point.u) {
        assert!((Vec3::from(*a) - Vec3::from(*b)).norm() < 1e-9, "{a:?} {b:?}");
    }
}

/// A plate that swings on a ball inside one of its elements, with a body on another ball on its upper face: the joints stay closed, and energy
/// and the moment of momentum about the vertical are conserved.
#[test]
fn a_plate_on_balls_inside_elements_conserves_energy_and_momentum() {
    let mut m = model(plate([1.0, 0.4], [5, 3], 0.2), 1e5, 0.05);
    m.conditions.clear();
    let options = TransientAnalysis {
        scheme: Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 }),
        time_step: Some(2e-3),
        ..TransientAnalysis::new(0.4)
    };
    m.analysis = Analysis::Transient(options.clone());
    let (pivot, lug) = ([0.23, 0.19, 0.0], [0.83, 0.11, 0.025]);
    m.bodies = vec![body("bob", [0.83, 0.11, 0.225], 0.01, Some([1e-4; 3]))];
    m.joints = vec![ball("pivot", ["ground", "all"], pivot), ball("lug", ["all", "bob"], lug)];
    m.loads = vec![Load::Gravity(GravityLoad { value: [0.0, 0.0, -9.81], amplitude: None })];
    m.initial_velocities = vec![InitialVelocity {
        on: "model".into(),
        velocity: [0.0; 3],
        angular_velocity: [0.4, 0.3, 1.0],
        center: pivot,
    }];
    m.sensors = vec![
        Sensor::Distance(DistanceSensor {
            name: "pivot".into(),
            between: between("ground", "all"),
            points: [pivot; 2],
        }),
        Sensor::Distance(DistanceSensor {
            name: "lug".into(),
            between: between("bob", "all"),
            points: [lug; 2],
        }),
    ];
    let (_, system) = compile(&m);
    let mut notes = Notes::keeping();
    dynamics::run(&system, &options, None, &mut notes).unwrap();
    assert!(notes.drift() <= 1e-9 * notes.kinetic, "{}", notes.drift());
    let [first, last] = [notes.states.first().unwrap(), notes.states.last().unwrap()];
    let about = |state: &tegula::analysis::State| {
        let (linear, angular) = system.momentum(&state.u, &state.v);
        (angular - Vec3::from(pivot).cross(&linear)).z
    };
    assert!((about(last) / about(first) - 1.0).abs() < 1e-8, "{} {}", about(first), about(last));
    let moved = |state: &tegula::analysis::State| {
        let centre = system.coordinates.bodies[0].centre as usize;
        Vec3::from(state.u[centre]).norm()
    };
    assert!(moved(last) > 0.1, "{}", moved(last));
    for joint in system.joints.iter() {
        let of = |v: usize| Vec3::from(system.coordinates.reference[v]) + Vec3::from(last.u[v]);
        let open = joint.with_vectors(of, |v, _| {
            joint.rows.iter().map(|row| row.form(v).abs()).fold(0.0, tegula::norm::larger)
        });
        assert!(open < 1e-9, "{}: {open}", joint.name);
    }
}

/// Points beside the shell are refused with the nearest one, and points without axes where a joint needs them.
#[test]
fn points_beside_a_shell_and_axes_of_a_point_are_refused() {
    let refused = |joint: Joint| {
        let mut m = model(plate([1.0, 0.5], [4, 2], 0.0), 1e6, 0.05);
        m.joints = vec![joint];
        m.loads = vec![Load::Gravity(GravityLoad { value: [0.0, 0.0, -9.81], amplitude: None })];
        let mesh = mesh::generators::generate(&m.mesh).unwrap();
        let Err(Error::Model(issues)) = tegula::compile::build(&m, &mesh) else { panic!("not refused") };
        format!("{:?} {}", issues[0].place, issues[0].message)
    };
    let above = refused(ball("ball", ["ground", "all"], [0.3, 0.2, 0.03]));
    assert!(above.contains("joints[0].at") && above.contains("nearest point is (0.3, 0.2, 0.0)"), "{above}");
    let beside = refused(ball("ball", ["ground", "all"], [1.3, 0.2, 0.0]));
    assert!(beside.contains("beside all elements"), "{beside}");
    let hinge =
        refused(crate::multibody::revolute("hinge", "ground", "all", [0.3, 0.2, 0.0], [0.0, 1.0, 0.0]));
    assert!(hinge.contains("joints[0].between"), "{hinge}");
}
