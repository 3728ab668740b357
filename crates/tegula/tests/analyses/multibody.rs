//! Rigid bodies and joints: classical mechanisms against their exact solutions, conservation laws, redundant and singular
//! joints. Sources of the numbers are with each test.

use crate::common::{Notes, distance};
use tegula::analysis::{Observer, Silent, State, dynamics};
use tegula::model::*;
use tegula::{Mat3, System, Vec3, compile, mesh};

/// A model of bodies in a transient analysis with energy–momentum steps of constant length.
fn machine(end: f64, step: f64, bodies: Vec<RigidBody>, joints: Vec<Joint>) -> Model {
    let scheme = Scheme::EnergyMomentum(EnergyMomentumScheme {});
    let analysis = TransientAnalysis { scheme, time_step: Some(step), ..TransientAnalysis::new(end) };
    let steel = Isotropic::new(1.0, 0.0, 1.0);
    let model = Model::new(MeshSource::None, Analysis::Transient(analysis), steel, 1.0);
    Model { sections: Vec::new(), materials: Default::default(), bodies, joints, ..model }
}

fn body(name: &str, at: [f64; 3], mass: f64, inertia: Option<[f64; 3]>) -> RigidBody {
    RigidBody {
        name: name.into(),
        at,
        mass: Some(mass),
        inertia,
        products_of_inertia: [0.0; 3],
        shape: None,
        density: None,
        axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        velocity: [0.0; 3],
        angular_velocity: [0.0; 3],
    }
}

fn between(a: &str, b: &str) -> [String; 2] {
    [a.into(), b.into()]
}

fn gravity(value: [f64; 3]) -> Vec<Load> {
    vec![Load::Gravity(GravityLoad { value, amplitude: None })]
}

/// Integrates a machine; returns the system and the final state.
fn run(model: &Model, observer: &mut dyn Observer) -> (System, State) {
    let mesh = mesh::generators::generate(&model.mesh).unwrap();
    let system = compile::build(model, &mesh).unwrap();
    let Analysis::Transient(options) = &model.analysis else { panic!("no transient analysis") };
    let outcome = dynamics::run(&system, options, None, observer).unwrap();
    (system, outcome.state)
}

/// Place of a body's mass centre, and its directors as columns.
fn pose(system: &System, state: &State, body: usize) -> (Vec3, Mat3) {
    let body = &system.coordinates.bodies[body];
    let at = |v: u32| {
        Vec3::from(system.coordinates.reference[v as usize]) + Vec3::from(state.u[v as usize])
    };
    (at(body.centre), body.directors.map_or(Mat3::identity(), |d| Mat3::from_columns(&d.map(at))))
}

/// Angular velocity of a body along its own axes.
fn spin(system: &System, state: &State, body: usize) -> Vec3 {
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
    println!("{errors:?}");
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
    let started = std::time::Instant::now();
    let (system, state) = run(&model, &mut notes);
    let (x, _) = pose(&system, &state, 0);
    println!("{x:?} {} {:?}", notes.drift(), started.elapsed());
    let _ = distance;
    assert!(notes.drift() <= 1e-10 * notes.kinetic, "{}", notes.drift());
    assert!((x - Vec3::new(-0.2750874626, -0.9614192051, 0.0)).norm() < 1e-4, "{x:?}");
}

/// The heavy top of Géradin and Cardona on a spherical joint: mass centre at 0.1 s by a Runge–Kutta method of order 8.
#[test]
fn a_heavy_top_precesses_and_nutates() {
    let omega = [0.0, 150.0, -4.61538];
    let top = RigidBody {
        angular_velocity: omega,
        velocity: Vec3::from(omega).cross(&Vec3::y()).into(),
        ..body("top", [0.0, 1.0, 0.0], 15.0, Some([0.234375, 0.46875, 0.234375]))
    };
    let joint = Joint::Spherical(PointJoint { name: "tip".into(), between: between("ground", "top"), at: [0.0; 3] });
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
    println!("{errors:?}");
    let _ = Silent;
    assert!(errors[2] < 1e-3, "{errors:?}");
}
