//! Composed steps of the energy–momentum scheme: fourth order in positions, velocities and reactions, with and without constraints;
//! conservation laws; models in which a step must not go back in time.

use crate::common::{Notes, distance, move_in_time};
use crate::family_dynamics::{soft_plate, tumbling};
use crate::multibody::{between, body, gravity, machine, pose, run, spherical};
use tegula::analysis::State;
use tegula::element::Nodal;
use tegula::model::*;
use tegula::norm::max_norm;
use tegula::result::joint_reaction;
use tegula::{System, Vec3};
use tegula::{compile, mesh};

const FOURTH: Scheme = Scheme::EnergyMomentum(EnergyMomentumScheme { order: 4 });

/// The model with composed steps of this length, up to `end`.
fn composed(model: Model, end: f64, step: f64) -> Model {
    let options = TransientAnalysis { scheme: FOURTH, time_step: Some(step), ..TransientAnalysis::new(end) };
    Model { analysis: Analysis::Transient(options), ..model }
}

/// Point mass on a rod without mass, released at the horizontal.
pub fn pendulum() -> Model {
    let rod = Joint::Distance(DistanceJoint {
        name: "rod".into(),
        between: between("ground", "mass"),
        points: [[0.0; 3], [-1.0, 0.0, 0.0]],
    });
    let bodies = vec![body("mass", [-1.0, 0.0, 0.0], 1.0, None)];
    Model { loads: gravity([0.0, -9.81, 0.0]), ..machine(10.0, 1e-2, bodies, vec![rod]) }
}

/// Errors of position, velocity and tension of the pendulum that is at `place` with the angular velocity `turning`; the tension is
/// m (v²/L − g y/L).
pub fn errors_of_pendulum((system, state): &(System, State), place: Vec3, turning: f64) -> [f64; 3] {
    let centre = system.coordinates.bodies[0].centre as usize;
    let velocity = Vec3::z().cross(&place) * turning;
    let pull = place * -(turning * turning - 9.81 * place.y);
    [
        (pose(system, state, 0).0 - place).norm(),
        (Vec3::from(state.v[centre]) - velocity).norm(),
        (joint_reaction(system, state, &system.joints[0]).0 - pull).norm(),
    ]
}

/// Position, velocity and tension of the pendulum at 10 s: exact by elliptic functions (IFToMM benchmark A01).
#[test]
fn a_pendulum_converges_with_the_fourth_power_of_the_step_in_position_velocity_and_reaction() {
    let (place, turning) = (Vec3::new(-0.2750874626, -0.9614192051, 0.0), 4.3431606929);
    let errors = |step: f64| {
        let mut notes = Notes::default();
        let found = run(&composed(pendulum(), 10.0, step), &mut notes);
        assert!(notes.drift() <= 1e-10 * notes.kinetic, "{}", notes.drift());
        errors_of_pendulum(&found, place, turning)
    };
    let errors = [0.04, 0.02, 0.01].map(errors);
    for i in 0..3 {
        let ratios = [errors[0][i] / errors[1][i], errors[1][i] / errors[2][i]];
        assert!(ratios.iter().all(|r| (14.5..17.5).contains(r)), "{i}: {ratios:?} {errors:?}");
    }
    assert!(errors[2][0] < 2e-7, "{errors:?}");
}

/// Positions and velocities of successively halved steps: ratios of their differences.
fn ratios(model: &Model, end: f64, steps: u32) -> [f64; 2] {
    let run = |steps: u32| -> State {
        let m = composed(model.clone(), end, end / f64::from(steps));
        let Analysis::Transient(options) = &m.analysis else { panic!("no transient analysis") };
        move_in_time(&m, options, &mut Notes::default()).1.state
    };
    let states = [0, 1, 2].map(|k| run(steps << k));
    [(|s| &s.u) as fn(&State) -> &Vec<Nodal>, |s| &s.v].map(|field| {
        let apart = |i: usize| distance(field(&states[i]), field(&states[i + 1]));
        println!("{} {}", apart(0), apart(1));
        apart(0) / apart(1)
    })
}

/// Shells with free and with inextensible directors, without constraints and with a prescribed motion.
#[test]
fn shells_converge_with_the_fourth_power_of_the_step() {
    for element in [ElementKind::Ems, ElementKind::Mitc4] {
        for found in ratios(&soft_plate(element), 0.256, 32) {
            assert!((14.0..18.0).contains(&found), "{element:?}: {found}");
        }
    }
}

/// A body with three unlike moments of inertia, hung by a ball joint on the corner of a shell and turning about no principal axis.
pub fn hung() -> Model {
    let turned = RigidBody {
        angular_velocity: [1.0, 3.0, -2.0],
        velocity: [1.0, 0.0, 1.0],
        ..body("load", [1.2, 1.1, 0.3], 60.0, Some([3.0, 2.0, 1.4]))
    };
    let plate = soft_plate(ElementKind::Ems);
    let corner = [1.0, 0.6, 0.8];
    Model { bodies: vec![turned], joints: vec![spherical("load", "u_max_v_max", corner)], ..plate }
}

#[test]
fn a_body_on_a_shell_converges_with_the_fourth_power_of_the_step() {
    for found in ratios(&hung(), 0.256, 32) {
        assert!((14.0..18.0).contains(&found), "{found}");
    }
}

/// Energy and momenta stay to the tolerance of Newton's method in steps that resolve little: a shell with free and with
/// inextensible directors, and a shell with a body.
#[test]
fn composed_steps_conserve_energy_and_momenta() {
    let free = Model { loads: Vec::new(), conditions: Vec::new(), ..hung() };
    for model in [tumbling(ElementKind::Ems, false), tumbling(ElementKind::Mitc4, true), free] {
        let mut notes = Notes::default();
        run(&composed(model, 0.3, 1e-2), &mut notes);
        assert!(notes.totals.len() == 31, "{:?}", notes.events);
        assert!(notes.drift() <= 2e-10 * notes.kinetic, "{}", notes.drift() / notes.kinetic);
        let (p, l) = notes.momenta[0];
        let lost = |f: &dyn Fn(&(Vec3, Vec3)) -> Vec3| {
            max_norm(notes.momenta.iter().map(|x| (f(x) - f(&(p, l))).norm()))
        };
        assert!(
            lost(&|x| x.0) <= 1e-9 * p.norm() && lost(&|x| x.1) <= 1e-9 * l.norm(),
            "{:?}",
            lost(&|x| x.1)
        );
    }
}

#[test]
fn steps_of_fourth_order_are_refused_where_a_step_back_in_time_makes_no_sense() {
    let refused = |model: Model| {
        let mesh = mesh::generators::generate(&model.mesh).unwrap();
        compile::build(&model, &mesh).err().expect("the model is wrong").to_string()
    };
    let m = composed(soft_plate(ElementKind::Ems), 0.1, 1e-2);
    let automatic = Analysis::Transient(TransientAnalysis { scheme: FOURTH, ..TransientAnalysis::new(0.1) });
    assert!(refused(Model { analysis: automatic, ..m.clone() }).contains("constant length"));
    for damping in [Damping { mass: 1.0, stiffness: 0.0 }, Damping { mass: 0.0, stiffness: 1e-3 }] {
        let message = refused(Model { damping, ..m.clone() });
        assert!(message.contains("analysis.scheme.order") && message.contains("`damping`"), "{message}");
    }
    let mut late = m.clone();
    late.sections[0].retardation_time = 1e-3;
    assert!(refused(late).contains("sections[0]"));
    let mut yielding = m.clone();
    let plastic = Material::examples().into_iter().find(Material::yields).unwrap();
    yielding.materials.insert("m".into(), plastic);
    assert!(refused(yielding).contains("dissipates"));
    let third = Scheme::EnergyMomentum(EnergyMomentumScheme { order: 3 });
    let options = TransientAnalysis { scheme: third, time_step: Some(1e-2), ..TransientAnalysis::new(0.1) };
    assert!(refused(Model { analysis: Analysis::Transient(options), ..m }).contains("order is 3"));
}
