//! Friction and stops of joints against closed forms.

use crate::common::Notes;
use crate::multibody::{between, body, gravity, machine, pose, run};
use tegula::analysis::State;
use tegula::constraint::CoordinateMode;
use tegula::model::*;
use tegula::norm::max_norm;
use tegula::{Error, System, compile, mesh};

const G: f64 = 10.0;

fn slide(friction: Option<JointFriction>, stops: Option<JointStops>, axis: [f64; 3]) -> Joint {
    let (name, between, at) = ("slide".into(), between("ground", "block"), [0.0; 3]);
    Joint::Prismatic(CoordinateJoint {
        name,
        between,
        at,
        axis,
        friction,
        stops,
        second_at: None,
        second_axis: None,
    })
}

/// Block on a slope that falls along −x by the slope's angle; its initial velocity is along x.
fn slope(angle: f64, mu: f64, speed: f64, end: f64, step: f64) -> Model {
    let friction = JointFriction { coefficient: mu, ..JointFriction::default() };
    let block =
        RigidBody { velocity: [speed, 0.0, 0.0], ..body("block", [0.0; 3], 2.0, Some([0.2, 0.25, 0.3])) };
    let (sine, cosine) = angle.sin_cos();
    let joint = slide(Some(friction), None, [1.0, 0.0, 0.0]);
    Model { loads: gravity([-G * sine, 0.0, -G * cosine]), ..machine(end, step, vec![block], vec![joint]) }
}

/// Below the angle of friction the block sticks.
#[test]
fn a_block_on_a_slope_below_the_angle_of_friction_sticks() {
    let mut notes = Notes::default();
    let (system, state) = run(&slope(0.2, 0.25, 0.0, 10.0, 0.01), &mut notes);
    let (x, _) = pose(&system, &state, 0);
    assert!(x.norm() < 1e-9, "{x}");
}

/// Above it a = g (sin θ − μ cos θ).
#[test]
fn a_block_on_a_slope_above_the_angle_of_friction_slides() {
    let mut notes = Notes::default();
    let (system, state) = run(&slope(0.4, 0.25, 0.0, 2.0, 0.01), &mut notes);
    let (x, _) = pose(&system, &state, 0);
    let a = G * (0.4_f64.sin() - 0.25 * 0.4_f64.cos());
    assert!((x.x + 2.0 * a).abs() < 1e-9, "{x}");
    assert!(notes.drift() <= 1e-9 * notes.kinetic, "{}", notes.drift());
}

/// A block that moves up or down the slope stops for good at v²/(2 a), with a = g (μ cos θ ± sin θ).
#[test]
fn a_moving_block_stops_for_good() {
    for speed in [1.5, -1.5_f64] {
        let mut notes = Notes::default();
        let (system, state) = run(&slope(0.2, 0.4, speed, 5.0, 0.01), &mut notes);
        let (x, _) = pose(&system, &state, 0);
        let a = G * (0.4 * 0.2_f64.cos() + speed.signum() * 0.2_f64.sin());
        let expected = speed.signum() * speed * speed / (2.0 * a);
        assert!((x.x - expected).abs() < 1e-9, "{x} {expected}");
        let v = state.v[system.coordinates.bodies[0].centre as usize];
        assert!(v[0].abs() < 1e-9, "{v:?}");
        assert!(notes.drift() <= 1e-9 * notes.kinetic, "{}", notes.drift());
    }
}

/// With the static coefficient μ_s > tan θ > μ a block at rest sticks, and one that moves down slides on.
#[test]
fn static_friction_holds_a_block_that_sliding_friction_does_not() {
    let with = |speed: f64| {
        let mut model = slope(0.3, 0.2, speed, 2.0, 0.01);
        let friction =
            JointFriction { coefficient: 0.2, static_coefficient: Some(0.4), ..JointFriction::default() };
        model.joints = vec![slide(Some(friction), None, [1.0, 0.0, 0.0])];
        let (system, state) = run(&model, &mut Notes::default());
        pose(&system, &state, 0).0.x
    };
    assert!(with(0.0).abs() < 1e-9, "{}", with(0.0));
    let a = G * (0.3_f64.sin() - 0.2 * 0.3_f64.cos());
    let error = with(-0.5) + 0.5 * 2.0 + 0.5 * a * 4.0;
    assert!(error.abs() < 1e-9, "{error}");
    // Sliding up, it comes to rest and stays.
    let up = G * (0.3_f64.sin() + 0.2 * 0.3_f64.cos());
    let error = with(0.5) - 0.25 / (2.0 * up);
    assert!(error.abs() < 1e-9, "{error}");
}

/// A force that grows by 1 N/s holds until μ_s m g, and moves the block by ∫∫ (F − μ m g)/m from then on.
#[test]
fn a_growing_force_breaks_the_block_loose() {
    let (m, mu, mu_s, end) = (2.0, 0.1, 0.15, 4.0);
    let error = |step: f64| {
        let friction =
            JointFriction { coefficient: mu, static_coefficient: Some(mu_s), ..JointFriction::default() };
        let block = body("block", [0.0; 3], m, Some([0.2, 0.25, 0.3]));
        let mut model = machine(end, step, vec![block], vec![slide(Some(friction), None, [1.0, 0.0, 0.0])]);
        model.loads = gravity([0.0, 0.0, -G]);
        let pull = Amplitude::Table(TableAmplitude { times: vec![0.0, end], values: vec![0.0, end] });
        model.amplitudes.insert("pull".into(), pull);
        model.loads.push(Load::Force(VectorLoad {
            on: "block".into(),
            value: [1.0, 0.0, 0.0],
            amplitude: Some("pull".into()),
            distribution: None,
        }));
        let mut notes = Notes::default();
        let (system, state) = run(&model, &mut notes);
        let (start, t) = (mu_s * m * G, end - mu_s * m * G);
        let expected = ((start - mu * m * G) * t * t / 2.0 + t.powi(3) / 6.0) / m;
        assert!(notes.drift() <= 1e-9 * notes.kinetic, "{}", notes.drift());
        (pose(&system, &state, 0).0.x - expected).abs() / expected
    };
    // The limit is passed at a step's start; it is between the steps in the other cases.
    let errors = [0.01, 0.007, 0.0035, 0.3].map(error);
    assert!(errors[0] < 1e-4 && errors[1] < 1e-4 && errors[2] < 3e-5 && errors[3] < 3e-2, "{errors:?}");
}

/// A periodic force breaks a block loose again and again; automatic steps follow an integration of the motion in very short steps.
#[test]
fn automatic_steps_find_where_a_block_breaks_loose() {
    let (mu, mu_s, end, size) = (0.3, 0.5, 3.0, 8.0);
    let (mut x, mut v) = (0.0_f64, 0.0_f64);
    let count = 3_000_000;
    let dt = end / f64::from(count);
    for i in 0..count {
        let force = size * (std::f64::consts::TAU * dt * (f64::from(i) + 0.5)).sin();
        if v == 0.0 && force.abs() <= mu_s * G {
            continue;
        }
        let direction = if v == 0.0 { force.signum() } else { v.signum() };
        let next = v + dt * (force - direction * mu * G);
        v = if next * direction < 0.0 { 0.0 } else { next };
        x += dt * v;
    }
    let error = |tolerance: f64| {
        let friction =
            JointFriction { coefficient: mu, static_coefficient: Some(mu_s), ..JointFriction::default() };
        let block = body("block", [0.0; 3], 1.0, Some([0.1; 3]));
        let mut model = machine(end, 0.01, vec![block], vec![slide(Some(friction), None, [1.0, 0.0, 0.0])]);
        let Analysis::Transient(options) = &mut model.analysis else { unreachable!() };
        (options.time_step, options.tolerance) = (None, tolerance);
        model.loads = gravity([0.0, 0.0, -G]);
        let wave = ExpressionAmplitude { expression: "sin(2*PI*t)".into() };
        model.amplitudes.insert("wave".into(), Amplitude::Expression(wave));
        model.loads.push(Load::Force(VectorLoad {
            on: "block".into(),
            value: [size, 0.0, 0.0],
            amplitude: Some("wave".into()),
            distribution: None,
        }));
        let (system, state) = run(&model, &mut Notes::default());
        (pose(&system, &state, 0).0.x / x - 1.0).abs()
    };
    let errors = [error(1e-5), error(1e-7)];
    assert!(errors[0] < 1e-2 && errors[1] < 3e-4, "{errors:?} {x}");
}

/// Block of mass m on a cart of mass M that a force F pulls: it goes along where F/(M + m) < μ g, else it has the acceleration μ g.
#[test]
fn a_block_on_a_cart_goes_along_or_slips() {
    let (m, cart, mu) = (2.0, 3.0, 0.25);
    for (force, slips) in [(10.0, false), (20.0, true)] {
        let friction = JointFriction { coefficient: mu, ..JointFriction::default() };
        let (axis, at) = ([1.0, 0.0, 0.0], [0.0; 3]);
        let rail = Joint::Prismatic(CoordinateJoint {
            name: "rail".into(),
            between: between("ground", "cart"),
            at,
            axis,
            friction: None,
            stops: None,
            second_at: None,
            second_axis: None,
        });
        let deck = Joint::Prismatic(CoordinateJoint {
            name: "deck".into(),
            between: between("cart", "block"),
            at,
            axis,
            friction: Some(friction),
            stops: None,
            second_at: None,
            second_axis: None,
        });
        let bodies =
            vec![body("cart", at, cart, Some([0.3; 3])), body("block", at, m, Some([0.2, 0.25, 0.3]))];
        let mut model = machine(1.0, 0.01, bodies, vec![rail, deck]);
        model.loads = gravity([0.0, 0.0, -G]);
        model.loads.push(Load::Force(VectorLoad {
            on: "cart".into(),
            value: [force, 0.0, 0.0],
            amplitude: None,
            distribution: None,
        }));
        let mut notes = Notes::default();
        let (system, state) = run(&model, &mut notes);
        let [a, b] = [0, 1].map(|i| pose(&system, &state, i).0.x);
        let expected = match slips {
            true => [(force - mu * m * G) / cart, mu * G],
            false => [force / (m + cart); 2],
        };
        assert!((a - 0.5 * expected[0]).abs() < 1e-9 && (b - 0.5 * expected[1]).abs() < 1e-9, "{a} {b}");
        assert!(notes.drift() <= 1e-9 * notes.kinetic, "{}", notes.drift());
    }
}

/// Physical pendulum of mass 2 on a hinge along y, at the angle α from the vertical; its mass centre is 0.5 from the hinge.
fn pendulum(
    angle: f64,
    end: f64,
    step: f64,
    (friction, stops): (Option<JointFriction>, Option<JointStops>),
) -> Model {
    let (sine, cosine) = angle.sin_cos();
    let bob = body("bob", [ARM * sine, 0.0, -ARM * cosine], MASS, Some([0.02; 3]));
    let hinge = Joint::Revolute(CoordinateJoint {
        name: "hinge".into(),
        between: between("ground", "bob"),
        at: [0.0; 3],
        axis: [0.0, -1.0, 0.0],
        friction,
        stops,
        second_at: None,
        second_axis: None,
    });
    Model { loads: gravity([0.0, 0.0, -G]), ..machine(end, step, vec![bob], vec![hinge]) }
}

const ARM: f64 = 0.5;
const MASS: f64 = 2.0;
/// Moment of inertia about the hinge.
const INERTIA: f64 = 0.02 + MASS * ARM * ARM;

/// Angles of a joint from the vertical at which its motion ends for a moment or for good, as the history shows them.
fn turning_points(states: &[State], start: f64) -> Vec<f64> {
    let held = |state: &State| matches!(state.coordinates[0].mode, CoordinateMode::Held { .. });
    let mut out: Vec<f64> = Vec::new();
    for pair in states.windows(2).filter(|pair| held(&pair[1]) && !held(&pair[0])) {
        out.push(pair[1].coordinates[0].value + start);
    }
    out
}

/// A constant friction torque M brakes a pendulum: between two turning points a and b on both sides of the vertical
/// `m g L (cos b − cos a) = M (a + b)`, and it rests at the first one with `m g L sin b ≤ M`.
#[test]
fn the_amplitude_of_a_braked_pendulum_decreases_as_its_energy_says() {
    let (torque, start) = (1.0, 1.0_f64);
    let moment = MASS * G * ARM;
    let mut expected = vec![start];
    while moment * expected[expected.len() - 1].sin() > torque {
        let a = expected[expected.len() - 1];
        let (mut low, mut high) = (-a, a);
        for _ in 0..200 {
            let b = 0.5 * (low + high);
            let gains = moment * (b.cos() - a.cos()) - torque * (a + b) > 0.0;
            (low, high) = if gains { (b, high) } else { (low, b) };
        }
        expected.push(0.5 * (low + high));
    }
    expected.remove(0);
    assert!(expected.len() > 3, "{expected:?}");
    let error = |step: f64| {
        let friction = JointFriction { preload: torque, ..JointFriction::default() };
        let mut notes = Notes::keeping();
        let (_, state) = run(&pendulum(start, 6.0, step, (Some(friction), None)), &mut notes);
        assert!(notes.drift() <= 1e-9 * notes.kinetic, "{}", notes.drift());
        let found = turning_points(&notes.states, start);
        assert_eq!(found.len(), expected.len(), "{found:?} {expected:?}");
        assert!(state.coordinates[0].mode.is_held());
        let differences = found.iter().zip(&expected).map(|(a, b)| a.abs() - b.abs());
        max_norm(differences)
    };
    let errors = [error(8e-3), error(4e-3)];
    assert!(errors[1] < 1e-4 && errors[0] / errors[1] > 3.0, "{errors:?}");
}

/// A rotor of weight m g in a bearing of radius r: the friction torque μ r m g stops it behind the angle ω² J/(2 μ r m g).
#[test]
fn bearing_friction_stops_a_rotor() {
    let (mass, inertia, mu, radius, speed) = (4.0, 0.5, 0.2, 0.05, 3.0);
    let friction = JointFriction { coefficient: mu, radius: Some(radius), ..JointFriction::default() };
    let rotor = RigidBody {
        angular_velocity: [0.0, speed, 0.0],
        ..body("rotor", [0.0; 3], mass, Some([0.3, inertia, 0.3]))
    };
    let bearing = Joint::Revolute(CoordinateJoint {
        name: "bearing".into(),
        between: between("ground", "rotor"),
        at: [0.0; 3],
        axis: [0.0, 1.0, 0.0],
        friction: Some(friction),
        stops: None,
        second_at: None,
        second_axis: None,
    });
    // The weight has a component along the axis, which makes no friction.
    let mut model = machine(6.0, 2e-3, vec![rotor], vec![bearing]);
    model.loads = gravity([0.0, 5.0, -G]);
    let mut notes = Notes::default();
    let (_, state) = run(&model, &mut notes);
    let expected = speed * speed * inertia / (2.0 * mu * radius * mass * G);
    let error = state.coordinates[0].value / expected - 1.0;
    assert!(error.abs() < 1e-5, "{error}");
    assert!(state.coordinates[0].mode.is_held());
    assert!(notes.drift() <= 1e-9 * notes.kinetic, "{}", notes.drift());
}

/// Friction torque μ r |N| of a pendulum, whose reaction N depends on its motion and on the friction: the equation
/// `J θ̈ = −m g L sin θ − μ r |N| sign θ̇`, `N = m (L θ̈ + g sin θ, L θ̇² + g cos θ)`, by a Runge–Kutta method of order 4.
#[test]
fn bearing_friction_follows_the_reaction_of_a_pendulum() {
    let (mu, radius, start, end) = (0.5, 0.1, 1.2, 0.4);
    let acceleration = |angle: f64, rate: f64| {
        let mut a = 0.0;
        for _ in 0..100 {
            let normal = MASS * (ARM * a + G * angle.sin()).hypot(ARM * rate * rate + G * angle.cos());
            a = (-MASS * G * ARM * angle.sin() + mu * radius * normal) / INERTIA;
        }
        a
    };
    let (mut angle, mut rate) = (start, 0.0);
    let h = end / 4000.0;
    for _ in 0..4000 {
        let k1 = (rate, acceleration(angle, rate));
        let k2 = (rate + 0.5 * h * k1.1, acceleration(angle + 0.5 * h * k1.0, rate + 0.5 * h * k1.1));
        let k3 = (rate + 0.5 * h * k2.1, acceleration(angle + 0.5 * h * k2.0, rate + 0.5 * h * k2.1));
        let k4 = (rate + h * k3.1, acceleration(angle + h * k3.0, rate + h * k3.1));
        angle += h / 6.0 * (k1.0 + 2.0 * k2.0 + 2.0 * k3.0 + k4.0);
        rate += h / 6.0 * (k1.1 + 2.0 * k2.1 + 2.0 * k3.1 + k4.1);
    }
    assert!(rate < -1.0 && angle < 0.8, "{angle} {rate}");
    let error = |step: f64| {
        let friction = JointFriction { coefficient: mu, radius: Some(radius), ..JointFriction::default() };
        let mut notes = Notes::default();
        let (_, state) = run(&pendulum(start, end, step, (Some(friction), None)), &mut notes);
        assert!(notes.drift() <= 1e-9 * notes.kinetic, "{}", notes.drift());
        (state.coordinates[0].value + start - angle).abs()
    };
    let errors = [error(8e-3), error(4e-3)];
    assert!(errors[1] < 1e-4 && (3.5..4.5).contains(&(errors[0] / errors[1])), "{errors:?}");
}

/// Automatic steps end at the same place.
#[test]
fn automatic_steps_find_the_stop_of_a_sliding_block() {
    let mut model = slope(0.2, 0.4, 1.5, 5.0, 0.01);
    let Analysis::Transient(options) = &mut model.analysis else { unreachable!() };
    options.time_step = None;
    let (system, state) = run(&model, &mut Notes::default());
    let a = G * (0.4 * 0.2_f64.cos() + 0.2_f64.sin());
    let error = pose(&system, &state, 0).0.x - 1.5 * 1.5 / (2.0 * a);
    assert!(error.abs() < 1e-9 && state.coordinates[0].mode.is_held(), "{error}");
}

fn compiled(model: &Model) -> Result<System, Error> {
    compile::build(model, &mesh::generators::generate(&model.mesh).unwrap())
}

fn refused(model: &Model) -> String {
    let Err(Error::Model(issues)) = compiled(model) else { panic!("not refused") };
    issues.iter().map(|i| format!("{}: {}\n", i.place.key, i.message)).collect()
}

#[test]
fn wrong_friction_is_refused_at_its_key() {
    let with = |friction: JointFriction| {
        let mut model = slope(0.2, 0.4, 1.5, 5.0, 0.01);
        model.joints = vec![slide(Some(friction), None, [1.0, 0.0, 0.0])];
        refused(&model)
    };
    let none = JointFriction::default();
    let text = with(JointFriction { coefficient: -0.1, ..none });
    assert!(text.contains("joints[0].friction.coefficient: the coefficient of friction"), "{text}");
    let text = with(JointFriction { coefficient: f64::NAN, ..none });
    assert!(text.contains("joints[0].friction.coefficient"), "{text}");
    let text = with(JointFriction { coefficient: 0.3, static_coefficient: Some(0.2), ..none });
    assert!(text.contains("joints[0].friction.static_coefficient") && text.contains("below"), "{text}");
    let text = with(JointFriction { coefficient: 0.3, radius: Some(0.2), ..none });
    assert!(text.contains("joints[0].friction.radius: the prismatic joint \"slide\""), "{text}");
    let text = with(JointFriction { preload: -1.0, coefficient: 0.3, ..none });
    assert!(text.contains("joints[0].friction.preload"), "{text}");
    assert!(with(none).contains("joints[0].friction: the joint \"slide\" has no friction"));
    let text = refused(&pendulum(1.0, 1.0, 0.01, (Some(JointFriction { coefficient: 0.3, ..none }), None)));
    assert!(text.contains("needs the radius of its bearing"), "{text}");
}

#[test]
fn analyses_that_do_not_compute_friction_refuse_it() {
    let model = slope(0.2, 0.4, 1.5, 5.0, 0.01);
    let with = |change: &dyn Fn(&mut TransientAnalysis)| {
        let mut model = model.clone();
        let Analysis::Transient(options) = &mut model.analysis else { unreachable!() };
        change(options);
        refused(&model)
    };
    let other = "joints[0].friction: the joint \"slide\" has friction, which the scheme";
    let order = EnergyMomentumScheme { order: 4 };
    for scheme in [
        Scheme::default(),
        Scheme::Hht(HhtScheme { alpha: -0.1 }),
        Scheme::GeneralizedAlpha(GeneralizedAlphaScheme::default()),
        Scheme::EnergyMomentum(order),
        Scheme::Explicit(ExplicitScheme { scale_director_inertia: true }),
    ] {
        let text = with(&|options| options.scheme = scheme);
        assert!(text.contains(other), "{scheme:?}: {text}");
    }
    assert!(with(&|options| options.linear = true).contains(other));
    let text = refused(&Model { analysis: Analysis::Static(StaticAnalysis::default()), ..model.clone() });
    assert!(text.contains("which a static analysis"), "{text}");
    let text = refused(&Model { analysis: Analysis::Modal(ModalAnalysis::new(3)), ..model.clone() });
    assert!(text.contains("which a modal analysis"), "{text}");
    // A drive of the same two sides leaves nothing to friction.
    let mut driven = model.clone();
    driven.amplitudes.insert("ramp".into(), Amplitude::Ramp(RampAmplitude { start: 0.0, end: 5.0 }));
    driven.joints.push(Joint::DrivenLength(DrivenLengthJoint {
        name: "jack".into(),
        between: between("block", "ground"),
        at: [0.0; 3],
        axis: [1.0, 0.0, 0.0],
        length: 1.0,
        amplitude: "ramp".into(),
    }));
    let text = refused(&driven);
    assert!(text.contains("joints[0].friction") && text.contains("\"jack\" cannot have"), "{text}");
}
