//! Stops of joints against closed forms of Newton's law of restitution.

use crate::common::Notes;
use crate::multibody::{between, body, gravity, machine, pose, run};
use tegula::analysis::{State, dynamics};
use tegula::model::*;
use tegula::norm::max_norm;
use tegula::{Error, System, compile, mesh};

const G: f64 = 10.0;
const H: f64 = 0.5;
const E: f64 = 0.6;

fn slide(name: &str, between: [String; 2], axis: [f64; 3], stops: Option<JointStops>) -> Joint {
    Joint::Prismatic(CoordinateJoint {
        name: name.into(),
        between,
        at: [0.0; 3],
        axis,
        friction: None,
        stops,
        second_at: None,
        second_axis: None,
    })
}

/// Mass that falls from the height `H` above its lower stop.
fn ball(restitution: f64, end: f64, step: Option<f64>) -> Model {
    let stops = JointStops { lower: Some(-H), upper: None, restitution };
    let block = body("block", [0.0; 3], 2.0, Some([0.2, 0.25, 0.3]));
    let joint = slide("guide", between("ground", "block"), [0.0, 0.0, 1.0], Some(stops));
    let mut model = machine(end, 0.01, vec![block], vec![joint]);
    model.loads = gravity([0.0, 0.0, -G]);
    let Analysis::Transient(options) = &mut model.analysis else { unreachable!() };
    options.time_step = step;
    model
}

fn height(system: &System, state: &State) -> [f64; 2] {
    let centre = system.coordinates.bodies[0].centre as usize;
    [pose(system, state, 0).0.z, state.v[centre][2]]
}

/// Impacts are at `t₁ (1 + 2 Σ eⁿ)` with `t₁ = √(2 H/g)`, where the velocity behind is `eⁿ g t₁`; the mass rises to `e²ⁿ H`, and rests
/// behind `t₁ (1 + e)/(1 − e)`. All energy m g H is dissipated.
#[test]
fn a_bouncing_mass_rises_and_rests_as_the_geometric_series_says() {
    let first = (2.0 * H / G).sqrt();
    let total = first * (1.0 + E) / (1.0 - E);
    for step in [Some(0.01), Some(0.0037), None] {
        let mut notes = Notes::keeping();
        let (system, state) = run(&ball(E, total + 1.0, step), &mut notes);
        let impacts: Vec<&State> = notes
            .states
            .iter()
            .filter(|state| {
                let [z, v] = height(&system, state);
                (z + H).abs() < 1e-9 && v > 1e-6
            })
            .collect();
        assert!(impacts.len() >= 12, "{}", impacts.len());
        let (mut time, mut errors) = (first, Vec::new());
        for (n, impact) in impacts.iter().take(12).enumerate() {
            let behind = E.powi(n as i32 + 1) * G * first;
            let [z, v] = height(&system, impact);
            // The place of an impact is found to 1e-11: so are its time times the velocity, and the energy over the weight.
            errors.extend([(impact.time - time) * behind, z + H, (v * v - behind * behind) / (2.0 * G)]);
            time += 2.0 * behind / G;
        }
        let drift = notes.drift();
        let [z, v] = height(&system, &state);
        assert!(max_norm(&errors) < 1e-10, "{errors:?}");
        assert!((z + H).abs() < 1e-9 && v.abs() < 1e-9, "{z} {v}");
        assert!(drift <= 1e-9 * notes.kinetic, "{drift}");
        assert!((state.dissipated / (2.0 * G * H) - 1.0).abs() < 1e-9, "{}", state.dissipated);
        assert!(state.work.abs() < 1e-9, "{}", state.work);
        assert!(state.coordinates[0].mode.is_held());
    }
    // The first rebound rises to e² H.
    let (system, state) = run(&ball(E, first * (1.0 + E), Some(0.01)), &mut Notes::default());
    let [z, v] = height(&system, &state);
    assert!((z + H - E * E * H).abs() < 1e-9 && v.abs() < 1e-8, "{z} {v}");
}

/// With e = 1 nothing is lost: behind any number of impacts the mass has its height again.
#[test]
fn an_elastic_stop_keeps_the_energy() {
    let first = (2.0 * H / G).sqrt();
    let mut notes = Notes::default();
    let (system, state) = run(&ball(1.0, 20.0 * first, Some(0.01)), &mut notes);
    let [z, v] = height(&system, &state);
    assert!(z.abs() < 1e-8 && v.abs() < 1e-6, "{z} {v}");
    assert!(state.dissipated.abs() < 1e-9 && notes.drift() < 1e-9 * notes.kinetic);
}

/// A mass m in a box of mass M on a rail, with stops on both sides: momentum stays, and the relative velocity is e times that before each
/// impact. The n-th impact is at `d/v (1 + 2/e + 2/e² + …)` (first half way, then whole ways).
#[test]
fn a_mass_in_a_free_box_keeps_the_momentum() {
    let (m, cart, d, v) = (2.0, 3.0, 0.1, 1.0);
    let stops = JointStops { lower: Some(-d), upper: Some(d), restitution: E };
    let x = [1.0, 0.0, 0.0];
    let joints = vec![
        slide("rail", between("ground", "box"), x, None),
        slide("play", between("box", "mass"), x, Some(stops)),
    ];
    let mass = RigidBody { velocity: [v, 0.0, 0.0], ..body("mass", [0.0; 3], m, Some([0.2, 0.25, 0.3])) };
    // Half way between the third and the fourth impact.
    let third = d / v * (1.0 + 2.0 / E + 2.0 / (E * E));
    let end = third + d / v / E.powi(3);
    let model = machine(end, 0.01, vec![body("box", [0.0; 3], cart, Some([0.3; 3])), mass], joints);
    let mut notes = Notes::default();
    let (system, state) = run(&model, &mut notes);
    let [a, b] = [0, 1].map(|i| state.v[system.coordinates.bodies[i].centre as usize][0]);
    assert!((cart * a + m * b - m * v).abs() < 1e-10);
    assert!((b - a + E.powi(3) * v).abs() < 1e-9, "{a} {b}");
    assert!(state.coordinates[0].value.abs() < 1e-8, "{:?}", state.coordinates);
    let lost = 0.5 * m * cart / (m + cart) * v * v * (1.0 - E.powi(6));
    assert!((state.dissipated / lost - 1.0).abs() < 1e-9 && notes.drift() <= 1e-9 * notes.kinetic);
}

/// A block slides with friction against a stop, rebounds, and friction stops it: `d₂ = v₂²/(2 μ g)` from the stop.
#[test]
fn friction_and_stop_act_in_one_joint() {
    let (mu, v, d) = (0.2, 2.0, 0.5);
    let block = RigidBody { velocity: [v, 0.0, 0.0], ..body("block", [0.0; 3], 2.0, Some([0.2, 0.25, 0.3])) };
    let joint = Joint::Prismatic(CoordinateJoint {
        name: "slide".into(),
        between: between("ground", "block"),
        at: [0.0; 3],
        axis: [1.0, 0.0, 0.0],
        friction: Some(JointFriction { coefficient: mu, ..JointFriction::default() }),
        stops: Some(JointStops { lower: None, upper: Some(d), restitution: E }),
        second_at: None,
        second_axis: None,
    });
    let model = Model { loads: gravity([0.0, 0.0, -G]), ..machine(3.0, 0.01, vec![block], vec![joint]) };
    let mut notes = Notes::default();
    let (system, state) = run(&model, &mut notes);
    let square = E * E * (v * v - 2.0 * mu * G * d);
    let error = pose(&system, &state, 0).0.x - (d - square / (2.0 * mu * G));
    assert!(error.abs() < 1e-9 && state.coordinates[0].mode.is_held(), "{error}");
    assert!(notes.drift() <= 1e-9 * notes.kinetic);
}

/// A pendulum of moment J falls from the horizontal on a stop below its hinge and rises again to `sin β = 1 − e²` above the
/// vertical, measured from the horizontal.
#[test]
fn a_pendulum_rebounds_from_its_stop() {
    let arm = 0.5;
    let stops = JointStops { lower: None, upper: Some(90.0), restitution: E };
    let bob = body("bob", [arm, 0.0, 0.0], 2.0, Some([0.02; 3]));
    let hinge = Joint::Revolute(CoordinateJoint {
        name: "hinge".into(),
        between: between("ground", "bob"),
        at: [0.0; 3],
        axis: [0.0, 1.0, 0.0],
        friction: None,
        stops: Some(stops),
        second_at: None,
        second_axis: None,
    });
    let model = Model { loads: gravity([0.0, 0.0, -G]), ..machine(1.0, 2e-3, vec![bob], vec![hinge]) };
    let mut notes = Notes::keeping();
    let (_, _) = run(&model, &mut notes);
    assert!(notes.drift() <= 1e-9 * notes.kinetic, "{}", notes.drift());
    let values: Vec<f64> = notes.states.iter().map(|s| s.coordinates[0].value).collect();
    let hit = values.iter().position(|x| (x - std::f64::consts::FRAC_PI_2).abs() < 1e-9).unwrap();
    let top = values[hit..].windows(3).find(|w| w[0] > w[1] && w[1] <= w[2]).unwrap()[1];
    assert!((top.sin() - (1.0 - E * E)).abs() < 2e-5, "{top}");
}

/// After a plastic impact nothing presses on the stop: a wheel that has turned to 1000° without a load, and a pendulum whose stop is at its
/// lowest point, stay there, held, in steps of the whole length.
#[test]
fn a_body_rests_at_a_stop_without_a_load() {
    let wheel = |speed: f64, bound: f64, step: Option<f64>| {
        let mut wheel = body("wheel", [0.0; 3], 1.0, Some([0.1; 3]));
        wheel.angular_velocity = [0.0, speed, 0.0];
        let stops = JointStops { upper: Some(bound), ..JointStops::default() };
        let hinge = Joint::Revolute(CoordinateJoint {
            name: "hinge".into(),
            between: between("ground", "wheel"),
            at: [0.0; 3],
            axis: [0.0, 1.0, 0.0],
            friction: None,
            stops: Some(stops),
            second_at: None,
            second_axis: None,
        });
        let mut model = machine(10.0, 0.1, vec![wheel], vec![hinge]);
        let Analysis::Transient(options) = &mut model.analysis else { unreachable!() };
        options.time_step = step;
        (model, bound)
    };
    let pendulum = |step: Option<f64>| {
        let (mut model, bound) = wheel(0.0, 90.0, step);
        model.bodies[0].at = [0.5, 0.0, 0.0];
        model.loads = gravity([0.0, 0.0, -G]);
        (model, bound)
    };
    let fixed = Some(0.1);
    let cases = [wheel(10.0, 1000.0, fixed), wheel(3.0, 720.0, Some(0.03)), wheel(1.0, 90.0, None)];
    for (model, bound) in cases.into_iter().chain([pendulum(Some(0.01)), pendulum(None)]) {
        let mut notes = Notes::keeping();
        let (_, state) = run(&model, &mut notes);
        let coordinate = &state.coordinates[0];
        assert!((coordinate.value - bound.to_radians()).abs() < 1e-9, "{coordinate:?}");
        assert!(coordinate.mode.is_held() && notes.states.len() < 1100, "{bound} {}", notes.states.len());
        assert!(notes.drift() <= 1e-9 * notes.kinetic, "{}", notes.drift());
    }
}

#[test]
fn wrong_stops_are_refused() {
    let with = |stops: JointStops| {
        let mut model = ball(E, 1.0, Some(0.01));
        model.joints = vec![slide("guide", between("ground", "block"), [0.0, 0.0, 1.0], Some(stops))];
        let mesh = mesh::generators::generate(&model.mesh).unwrap();
        match compile::build(&model, &mesh) {
            Err(Error::Model(issues)) => format!("{}: {}", issues[0].place.key, issues[0].message),
            Err(other) => panic!("{other}"),
            Ok(_) => panic!("accepted"),
        }
    };
    let one = |lower: f64, upper: f64, restitution: f64| {
        with(JointStops { lower: Some(lower), upper: Some(upper), restitution })
    };
    assert!(with(JointStops::default()).contains("joints[0].stops: the joint \"guide\" has no stop"));
    assert!(one(1.0, -1.0, 0.0).contains("is not below the upper one"));
    assert!(one(-1.0, 1.0, 1.5).contains("joints[0].stops.restitution"));
    assert!(one(-1.0, f64::NAN, 0.5).contains("joints[0].stops"));
    let text = one(0.5, 1.0, 0.5);
    assert!(
        text.contains("joints[0].stops: the joint \"guide\" begins at 0, below its lower stop, 0.5"),
        "{text}"
    );
    let text = with(JointStops { upper: Some(-0.5), ..JointStops::default() });
    assert!(text.contains("begins at 0, above its upper stop, -0.5"), "{text}");
    let mut model = ball(E, 1.0, Some(0.01));
    let Analysis::Transient(options) = &mut model.analysis else { unreachable!() };
    options.scheme = Scheme::GeneralizedAlpha(GeneralizedAlphaScheme::default());
    let mesh = mesh::generators::generate(&model.mesh).unwrap();
    let text = compile::build(&model, &mesh).err().unwrap().to_string();
    assert!(text.contains("has stops, which the scheme"), "{text}");
}

/// A body that falls beyond the stop of its released guide cannot be guided in the next step.
#[test]
fn a_joint_that_stands_beyond_its_stop_when_it_acts_again_is_refused() {
    let mut model = ball(E, 0.5, Some(0.01));
    let step = |name: &str, released: &[&str]| AnalysisStep {
        released: released.iter().map(|name| (*name).to_owned()).collect(),
        ..AnalysisStep::new(name, model.analysis.clone())
    };
    model.steps = vec![step("fall", &["guide"]), step("guided", &[])];
    let mesh = mesh::generators::generate(&model.mesh).unwrap();
    let compiler = compile::Compiler::new(&model, &mesh).unwrap();
    let Analysis::Transient(options) = &model.analysis else { unreachable!() };
    let run = |system: &System| dynamics::run(system, options, None, &mut Notes::default());
    let fallen = run(&compiler.system(0, None).unwrap()).unwrap().state;
    let text = run(&compiler.system(1, Some(fallen.end_of_step())).unwrap()).unwrap_err().to_string();
    assert!(
        text.contains("\"guide\" stands at -1.2") && text.contains("between its stops -0.5 and none"),
        "{text}"
    );
}
