//! Springs with formulas of the elongation, its rate and the time, against closed forms.

use crate::common::{Notes, vector_load};
use crate::multibody::{axis_joint, between, body, gravity, machine, pose, revolute, run};
use tegula::analysis::{Silent, modal, statics};
use tegula::model::*;
use tegula::norm::max_norm;
use tegula::result::bodies::{spring_lengths_and_forces, torsion_angles_and_moments};
use tegula::{Error, compile, mesh};

/// A spring from the ground to the mass `bob` at the origin, 2 long along x, with this elongation at the start.
fn spring(force: &str, elongation: f64) -> SpringDamper {
    SpringDamper {
        across: None,
        name: "soft".into(),
        between: between("ground", "bob"),
        points: [[-2.0, 0.0, 0.0], [0.0; 3]],
        stiffness: 0.0,
        damping: 0.0,
        force: Some(force.into()),
        length: Some(2.0 - elongation),
    }
}

/// A mass of 2 on such a spring, with the velocity `speed` along x.
fn oscillator((end, steps): (f64, u32), (force, elongation, speed): (&str, f64, f64)) -> Model {
    let bob = RigidBody { velocity: [speed, 0.0, 0.0], ..body("bob", [0.0; 3], 2.0, None) };
    let mut model = machine(end, end / f64::from(steps), vec![bob], Vec::new());
    model.springs = vec![spring(force, elongation)];
    model
}

fn with_scheme(mut model: Model, scheme: Scheme) -> Model {
    let Analysis::Transient(options) = &mut model.analysis else { panic!() };
    options.scheme = scheme;
    model
}

const ORDER_4: Scheme = Scheme::EnergyMomentum(EnergyMomentumScheme { order: 4 });
const ALPHA: Scheme = Scheme::GeneralizedAlpha(GeneralizedAlphaScheme { spectral_radius: 0.9 });

/// Complete elliptic integral of the first kind of the parameter m, by the arithmetic–geometric mean.
fn elliptic(m: f64) -> f64 {
    let (mut a, mut b) = (1.0, (1.0 - m).sqrt());
    for _ in 0..40 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    std::f64::consts::FRAC_PI_2 / a
}

/// The limit of a result of second order, from steps and half steps, and the ratio of successive changes.
fn limit(of: impl Fn(u32) -> f64, steps: u32) -> (f64, f64) {
    let found = [of(steps), of(2 * steps), of(4 * steps)];
    (found[2] + (found[2] - found[1]) / 3.0, (found[1] - found[0]) / (found[2] - found[1]))
}

/// Duffing's oscillator m ẍ + k x + c x³ = 0 swings from the amplitude A with the period `4 K/√((k + c A²)/m)` and the parameter
/// `½ c A²/(k + c A²)`; after a quarter of it x = 0 (Nayfeh & Mook, Nonlinear Oscillations, 1979, sect. 2.1).
#[test]
fn duffings_oscillator_has_its_period_and_keeps_its_energy() {
    let (k, c, amplitude) = (8.0, 300.0, 0.5_f64);
    let stiff = k + c * amplitude * amplitude;
    let quarter = elliptic(0.5 * c * amplitude * amplitude / stiff) / (stiff / 2.0).sqrt();
    let energy = 0.5 * k * amplitude.powi(2) + 0.25 * c * amplitude.powi(4);
    let at_quarter = |steps: u32, scheme: Option<Scheme>| {
        let mut model = oscillator((quarter, steps), ("8*x + 300*x^3", amplitude, 0.0));
        if let Some(scheme) = scheme {
            model = with_scheme(model, scheme);
        }
        let mut notes = Notes::default();
        let (system, state) = run(&model, &mut notes);
        assert!((notes.totals[0].1 - energy).abs() < 1e-14 * energy, "{:?}", notes.totals[0]);
        assert!(notes.drift() < 1e-13 * energy, "{steps}: {}", notes.drift());
        pose(&system, &state, 0).0.x + amplitude
    };
    let (place, ratio) = limit(|steps| at_quarter(steps, None), 40);
    assert!(place.abs() < 1e-6 && (ratio - 4.0).abs() < 0.02, "{place} {ratio}");
    let errors = [20, 40].map(|steps| at_quarter(steps, Some(ORDER_4)).abs());
    assert!(errors[1] < 1e-6 && (errors[0] / errors[1] - 16.0).abs() < 1.0, "{errors:?}");
    // Generalised-α is of second order, too.
    let (place, ratio) = limit(
        |steps| {
            let model = oscillator((quarter, steps), ("8*x + 300*x^3", amplitude, 0.0));
            let (system, state) = run(&with_scheme(model, ALPHA), &mut Silent);
            pose(&system, &state, 0).0.x + amplitude
        },
        80,
    );
    assert!(place.abs() < 1e-6 && (ratio - 4.0).abs() < 0.1, "{place} {ratio}");
}

/// Quadratic damping m v̇ = −c v|v|: `v = v₀/(1 + c v₀ t/m)`, in both directions.
#[test]
fn quadratic_damping_slows_a_mass_down() {
    for (speed, scheme) in [(3.0, None), (-0.3, None), (3.0, Some(ALPHA))] {
        let (mass, c, end) = (2.0, 1.5, 2.0);
        let exact = speed / (1.0 + c * f64::abs(speed) * end / mass);
        let velocity = |steps: u32| {
            let model = oscillator((end, steps), ("1.5*v*abs(v)", 0.0, speed));
            let model = if let Some(scheme) = scheme { with_scheme(model, scheme) } else { model };
            let mut notes = Notes::default();
            let (_, state) = run(&model, &mut notes);
            let lost = 0.5 * mass * (speed * speed - exact * exact);
            let tolerance = if scheme.is_none() { 1e-13 } else { 30.0 * f64::from(steps).powi(-2) };
            assert!(notes.drift() < tolerance * lost, "{steps}: {}", notes.drift());
            assert!((state.dissipated / lost - 1.0).abs() < 30.0 * f64::from(steps).powi(-2));
            assert!(state.work == 0.0);
            state.v[0][0]
        };
        let (found, ratio) = limit(velocity, 50);
        assert!((found - exact).abs() < 1e-6 && (ratio - 4.0).abs() < 0.1, "{found} {exact} {ratio}");
    }
}

/// An actuator that pushes with 3 t + 4 sin 2t: `m v = ³⁄₂ t² + 2 (1 − cos 2t)`. Its work is the kinetic energy.
#[test]
fn an_actuator_supplies_its_work() {
    for scheme in [None, Some(ALPHA), Some(ORDER_4)] {
        let (mass, end) = (2.0, 1.7_f64);
        let exact = (1.5 * end * end + 2.0 * (1.0 - (2.0 * end).cos())) / mass;
        let velocity = |steps: u32| {
            let model = oscillator((end, steps), ("-(3*t + 4*sin(2*t))", 0.3, 0.0));
            let model = if let Some(scheme) = scheme { with_scheme(model, scheme) } else { model };
            let mut notes = Notes::default();
            let (system, state) = run(&model, &mut notes);
            let done = 0.5 * mass * state.v[0][0].powi(2);
            let tolerance = if scheme == Some(ALPHA) { 20.0 * f64::from(steps).powi(-2) } else { 1e-13 };
            assert!(notes.drift() < tolerance * done, "{steps}: {} {done}", notes.drift());
            assert!((state.work / done - 1.0).abs() < tolerance && state.dissipated == 0.0);
            let force = spring_lengths_and_forces(&system, &state)[0][1];
            assert!((force + 3.0 * end + 4.0 * (2.0 * end).sin()).abs() < 1e-14, "{force}");
            state.v[0][0]
        };
        if scheme == Some(ORDER_4) {
            assert!((velocity(40) - exact).abs() < 1e-6);
            continue;
        }
        let (found, ratio) = limit(velocity, 40);
        assert!((found - exact).abs() < 1e-6 && (ratio - 4.0).abs() < 0.1, "{found} {exact} {ratio}");
    }
}

/// A mass between two stops with clearance: flight, half a swing with ω² = k/m, flight back. The steps straddle the kinks of the
/// formula; energy is kept to round-off all the same.
#[test]
fn clearance_keeps_the_energy_across_its_kinks() {
    let (gap, omega, speed) = (0.1, 20.0, 1.5_f64);
    let period = 4.0 * gap / speed + 2.0 * std::f64::consts::PI / omega;
    let place = |steps: u32| {
        let law = "800*(max(x - 0.1, 0) + min(x + 0.1, 0))";
        let mut notes = Notes::default();
        let (system, state) = run(&oscillator((period, steps), (law, 0.0, speed)), &mut notes);
        assert!(notes.drift() < 2e-13 * notes.kinetic, "{}", notes.drift());
        assert!((state.v[0][0] - speed).abs() < 1e-12 * speed, "{}", state.v[0][0]);
        pose(&system, &state, 0).0.x
    };
    let errors = [200, 800, 3200].map(|steps| place(steps).abs());
    assert!(errors[2] < 1e-5 && errors[0] > 8.0 * errors[1] && errors[1] > 8.0 * errors[2], "{errors:?}");
}

fn solved(model: &Model) -> tegula::Result<(tegula::System, statics::StaticOutcome)> {
    let Analysis::Static(options) = &model.analysis else { panic!() };
    let system = compile::build(model, &mesh::generators::generate(&model.mesh)?)?;
    let outcome = statics::run(&system, options, None, &mut Silent)?;
    Ok((system, outcome))
}

fn hanging(force: &str, elongation: f64, load: f64) -> Model {
    let slide = Joint::Prismatic(axis_joint("slide", "ground", "bob", [0.0; 3], [1.0, 0.0, 0.0]).into());
    let bob = body("bob", [0.0; 3], 2.0, Some([0.1; 3]));
    let mut model = Model::of_bodies(Analysis::Static(StaticAnalysis::default()), vec![bob], vec![slide]);
    model.springs = vec![spring(force, elongation)];
    if load != 0.0 {
        model.loads = gravity([load / 2.0, 0.0, 0.0]);
    }
    model
}

/// k x + c x³ = F has the solution of Cardano, `x = u − k/(3 c u)` with `u³ = F/(2c) + √(F²/(4c²) + k³/(27c³))`.
#[test]
fn a_cubic_spring_hangs_where_cardano_says() {
    let (k, c, load) = (50.0_f64, 4e3, 70.0);
    let u = (load / (2.0 * c) + (load * load / (4.0 * c * c) + (k / (3.0 * c)).powi(3)).sqrt()).cbrt();
    let exact = u - k / (3.0 * c * u);
    for (elongation, damping) in [(0.0, ""), (0.1, " + 5*v*abs(v)")] {
        let model = hanging(&format!("50*x + 4e3*x^3{damping}"), elongation, load);
        let (system, outcome) = solved(&model).unwrap();
        let x = pose(&system, &outcome.state, 0).0.x + elongation;
        assert!((x - exact).abs() < 1e-12, "{x} {exact}");
        let energy = 0.5 * k * x * x + 0.25 * c * x.powi(4);
        assert!((outcome.balance.strain / energy - 1.0).abs() < 1e-13, "{energy} {:?}", outcome.balance);
    }
}

/// In statics `t` is the load factor: the actuator 20 t, which the linear part 50 x resists, ends at x = −0.4 with the work
/// `∫ (50 x + 20 t) dx` on the model, which nothing else stores.
#[test]
fn an_actuator_grows_with_the_load_factor() {
    let mut model = hanging("20*t", 0.0, 0.0);
    model.springs.push(SpringDamper {
        name: "linear".into(),
        stiffness: 50.0,
        force: None,
        ..spring("", 0.0)
    });
    let (system, outcome) = solved(&model).unwrap();
    let x = pose(&system, &outcome.state, 0).0.x;
    assert!((x + 0.4).abs() < 1e-12, "{x}");
    let stored = 0.5 * 50.0 * 0.16;
    assert!((outcome.state.work - stored).abs() < 1e-12, "{}", outcome.state.work);
    assert!((outcome.balance.strain - stored).abs() < 1e-12 && outcome.balance.total.abs() < 1e-12);
    // One formula for both.
    let (system, outcome) = solved(&hanging("50*x + 20*t", 0.0, 0.0)).unwrap();
    let x = pose(&system, &outcome.state, 0).0.x;
    assert!((x + 0.4).abs() < 1e-9 && outcome.balance.strain == 0.0, "{x}");
    assert!(outcome.balance.total.abs() < 1e-12, "{:?}", outcome.balance);
}

/// A wheel with the moment 2 sin θ swings like a pendulum: from 150° to 0 in `K(sin² 75°)/ω` with ω² = 2/J.
#[test]
fn a_moment_with_a_sine_swings_like_a_pendulum() {
    let quarter = elliptic(75_f64.to_radians().sin().powi(2)) / 2.0;
    let angle = |steps: u32| {
        let wheel = body("wheel", [0.0; 3], 2.0, Some([0.3, 0.3, 0.5]));
        let hinge = revolute("hinge", "ground", "wheel", [0.0; 3], [0.0, 0.0, 1.0]);
        let mut model = machine(quarter, quarter / f64::from(steps), vec![wheel], vec![hinge]);
        model.torsion_springs = vec![torsion("2*sin(x)", 150.0)];
        let mut notes = Notes::default();
        let (system, state) = run(&model, &mut notes);
        assert!(notes.drift() < 1e-11 * notes.kinetic, "{} {}", notes.drift(), notes.kinetic);
        let stored = 2.0 * (1.0 - 150_f64.to_radians().cos());
        assert!((notes.totals[0].1 / stored - 1.0).abs() < 1e-14, "{stored} {:?}", notes.totals[0]);
        torsion_angles_and_moments(&system, &state)[0][0] - 150_f64.to_radians()
    };
    let (found, ratio) = limit(angle, 100);
    assert!(found.abs() < 1e-5 && (ratio - 4.0).abs() < 0.05, "{found} {ratio}");
}

pub fn torsion(moment: &str, free_angle: f64) -> TorsionSpring {
    TorsionSpring {
        name: "clock".into(),
        between: between("ground", "wheel"),
        axis: [0.0, 0.0, 2.0],
        stiffness: 0.0,
        damping: 0.0,
        moment: Some(moment.into()),
        free_angle,
    }
}

/// Modes about a state: ω² = (k + 3 c x²)/m, also where the force at the reference is that of `t = 0`.
#[test]
fn modes_take_the_slope_of_the_formula() {
    for (law, elongation, stiffness) in [
        ("100*x + 1e4*x^3", 0.1, 400.0),
        ("100*x + 1e4*x^3 + 3*v*abs(v)", 0.0, 100.0),
        ("5*cos(t) + 100*x", 0.0, 100.0),
    ] {
        let mut model = hanging(law, elongation, 0.0);
        model.analysis = Analysis::Modal(ModalAnalysis::new(1));
        let system = compile::build(&model, &mesh::generators::generate(&model.mesh).unwrap()).unwrap();
        let found = modal::run(&system, 1, None, &mut Silent).unwrap();
        let expected = (stiffness / 2.0_f64).sqrt();
        assert!((found.modes[0].omega / expected - 1.0).abs() < 1e-9, "{law}: {}", found.modes[0].omega);
    }
}

#[test]
fn invalid_formulas_are_refused_by_name() {
    let refused = |model: &Model, key: &str, parts: &[&str]| {
        let mesh = mesh::generators::generate(&model.mesh).unwrap();
        let Err(Error::Model(issues)) = compile::build(model, &mesh) else { panic!("{parts:?} is taken") };
        let found: Vec<_> = issues.iter().filter(|issue| issue.place.key == key).collect();
        assert!(found.len() == 1, "{issues:?}");
        let text = format!("{} {}", found[0].message, found[0].help);
        assert!(parts.iter().all(|part| text.contains(part)), "{text}");
    };
    let of = |law: &str, elongation: f64| oscillator((1.0, 10), (law, elongation, 0.0));
    for (law, elongation, parts) in [
        ("k1*x", 0.0, ["the spring \"soft\"", "\"k1*x\"", "unknown variable \"k1\"", "numbers for all"]),
        ("1/x", 0.0, ["the spring \"soft\"", "\"1/x\"", "no finite value", "x = 0.0"]),
        ("sqrt(x)", 0.0, ["the spring \"soft\"", "\"sqrt(x)\"", "no finite derivatives", "smooth"]),
        ("floor(x)", 0.0, ["the spring \"soft\"", "\"floor(x)\"", "cannot be differentiated", "max"]),
        ("0,5*x", 0.0, ["the spring \"soft\"", "\"0,5*x\"", "a comma", "write a formula"]),
        ("max(x)", 0.0, ["the spring \"soft\"", "\"max(x)\"", "two arguments", "write a formula"]),
        ("max(x, 0", 0.0, ["the spring \"soft\"", "\"max(x, 0\"", "two arguments", "write a formula"]),
        (" ", 0.0, ["the spring \"soft\"", "empty", "write a formula", "abs"]),
    ] {
        refused(&of(law, elongation), "springs[0].force", &parts);
    }
    let mut both = of("3*x", 0.0);
    both.springs[0].stiffness = 2.0;
    refused(&both, "springs[0].force", &["the spring \"soft\"", "\"3*x\"", "2*x + 0*v"]);
    let mut none = of("", 0.0);
    none.springs[0].force = None;
    refused(&none, "springs[0]", &["does nothing", "`force`"]);
    let damped = with_scheme(of("3*x + v^3", 0.0), ORDER_4);
    refused(&damped, "analysis.scheme.order", &["the damper of \"soft\""]);

    let wheel = body("wheel", [0.0; 3], 2.0, Some([0.3, 0.3, 0.5]));
    let hinge = revolute("hinge", "ground", "wheel", [0.0; 3], [0.0, 0.0, 1.0]);
    let mut turning = machine(1.0, 0.1, vec![wheel], vec![hinge]);
    turning.torsion_springs = vec![torsion("ln(x)", 90.0)];
    refused(
        &turning,
        "torsion_springs[0].moment",
        &["the torsion spring \"clock\"", "\"ln(x)\"", "x = -1.57"],
    );
    turning.torsion_springs[0].moment = Some("y".into());
    refused(&turning, "torsion_springs[0].moment", &["unknown variable \"y\""]);
    turning.torsion_springs[0].moment = None;
    refused(&turning, "torsion_springs[0]", &["does nothing", "`moment`"]);
}

/// A mass leaves the range of a formula during the motion, or begins outside with its velocity: the error names spring, formula and place.
#[test]
fn a_force_without_a_value_ends_the_motion_with_its_reason() {
    for (law, speed) in [("sqrt(1 - x)", 4.0), ("x + ln(1 - v)", 4.0), ("x/(1 - t)^0.5", 4.0)] {
        for scheme in [None, Some(ALPHA)] {
            let model = oscillator((2.0, 100), (law, 0.0, speed));
            let model = if let Some(scheme) = scheme { with_scheme(model, scheme) } else { model };
            let mesh = mesh::generators::generate(&model.mesh).unwrap();
            let system = compile::build(&model, &mesh).unwrap();
            let Analysis::Transient(options) = &model.analysis else { panic!() };
            let error = tegula::analysis::dynamics::run(&system, options, None, &mut Silent).unwrap_err();
            let text = error.to_string();
            assert!(text.contains(&format!("\"{law}\" of the spring \"soft\"")), "{law}: {text}");
        }
    }
}

/// A load that no elongation in the range of the formula balances.
#[test]
fn a_static_force_without_a_value_is_told() {
    let error = solved(&hanging("10 - 10*sqrt(1 - x)", 0.0, 20.0)).err().unwrap().to_string();
    assert!(error.contains("\"10 - 10*sqrt(1 - x)\" of the spring \"soft\""), "{error}");
}

/// The example of the book is a formula without force at rest.
#[test]
fn the_formula_of_the_book_is_taken() {
    let book = include_str!("../../../../book/src/bodies-and-joints.md");
    let line = book.lines().find_map(|line| line.strip_prefix("force = \"")).unwrap();
    let law = line.split('"').next().unwrap();
    let (system, state) = run(&oscillator((1e-3, 1), (law, 0.0, 0.0)), &mut Silent);
    assert!(law.contains("min") && spring_lengths_and_forces(&system, &state) == [[2.0, 0.0]]);
}

/// A gas spring, whose formula has no value at x = 0.
#[test]
fn gas_springs_store_energy_from_their_start() {
    // p A = 3 at the start, 0.5 above the bottom: F = −3 (0.5/s)^1.4 with s = x, which has no value at x = 0.
    let mut model = hanging("-3*(0.5/x)^1.4", 0.5, 0.0);
    model.loads = vec![Load::Force(vector_load("bob", [-6.0, 0.0, 0.0]))];
    let (system, outcome) = solved(&model).unwrap();
    let x = pose(&system, &outcome.state, 0).0.x + 0.5;
    let exact = 0.5 * 0.5_f64.powf(1.0 / 1.4);
    assert!((x - exact).abs() < 1e-10, "{x} {exact}");
    let stored = 3.0 * 0.5_f64.powf(1.4) * (x.powf(-0.4) - 0.5_f64.powf(-0.4)) / 0.4;
    assert!((outcome.balance.strain / stored - 1.0).abs() < 1e-12, "{stored} {:?}", outcome.balance);
}

/// The tangent of a state with rates and of a step along the spring is the derivative of the forces, by central differences; so is that of
/// a state aslant without rates.
#[test]
fn tangents_are_derivatives_of_the_forces() {
    use tegula::element::{Motion, TangentRequest, TangentWeights};
    use tegula::system::EvaluationPoint;
    let law = "40*x + 300*x^3 + 5*v*abs(v) + 90*max(x - 0.3, 0) - 2*t*x";
    let model = oscillator((1.0, 10), (law, 0.25, 0.0));
    let system = compile::build(&model, &mesh::generators::generate(&model.mesh).unwrap()).unwrap();
    let group = system.groups[0].as_ref();
    let state = TangentWeights { rate: 7.0, ..TangentWeights::STATIC };
    let step =
        TangentWeights { stress: 0.5, direction: 0.5, rate: 20.0, multiplier: 0.0, ..TangentWeights::STATIC };
    let evaluate = |u: [f64; 3], weights: &TangentWeights, aslant: bool| {
        // The velocity changes with the displacement by the weight of the rates; a step of 1/20 has the mean rate 20 Δx.
        let v = if aslant { [0.0; 3] } else { [0.4 + 7.0 * (u[0] - 0.1), 0.0, 0.0] };
        let (old, new, v) = ([[-0.2, 0.0, 0.0]], [u], [v]);
        let motion = if weights.stress == 0.5 {
            Motion::Step { old: &old, new: &new, dt: 0.05 }
        } else {
            Motion::State { u: &new, velocity: Some(&v) }
        };
        let k = EvaluationPoint::new(&system, motion, 0.6, &[]);
        let (mut forces, mut blocks) = ([0.0; 3], [0.0; 9]);
        let request =
            TangentRequest { weights: *weights, stress: None, prescribed: None, blocks: &mut blocks };
        group.evaluate(&k.of_group(&system, 0, &[]), 0, &mut forces, Some(request));
        (forces, blocks)
    };
    for (u, weights, aslant) in
        [([0.1, 0.0, 0.0], &state, false), ([0.1, 0.0, 0.0], &step, false), ([0.1, 0.5, -0.4], &state, true)]
    {
        let (_, tangent) = evaluate(u, weights, aslant);
        let rates = if aslant { TangentWeights::STATIC } else { *weights };
        let (_, plain) = evaluate(u, &rates, aslant);
        let size = max_norm(tangent);
        for j in 0..3 {
            let h = 1e-6;
            let moved = |d: f64| {
                evaluate(std::array::from_fn(|i| u[i] + if i == j { d } else { 0.0 }), weights, aslant).0
            };
            let (more, less) = (moved(h), moved(-h));
            for i in 0..3 {
                let difference = (more[i] - less[i]) / (2.0 * h);
                assert!(
                    (difference - plain[3 * i + j]).abs() < 1e-7 * size,
                    "{i} {j}: {difference} {plain:?}"
                );
            }
        }
    }
}

/// A mass on a slide, 1 m from the anchor of a spring by a formula.
fn on_slide(force: &str, analysis: Analysis) -> Model {
    let mass = body("m", [1.0, 0.0, 0.0], 1.0, Some([1.0; 3]));
    let slide = crate::multibody::axis_joint("slide", "ground", "m", [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]);
    let spring = SpringDamper {
        across: None,
        name: "s".into(),
        between: between("ground", "m"),
        points: [[0.0; 3], [1.0, 0.0, 0.0]],
        stiffness: 0.0,
        damping: 0.0,
        length: Some(1.0),
        force: Some(force.into()),
    };
    let joints = vec![Joint::Prismatic(slide.into())];
    Model { springs: vec![spring], ..Model::of_bodies(analysis, vec![mass], joints) }
}

/// The force 100 x − 300 x² + 200 x³ has its maximum `100/(6 √3)` at `x = (3 − √3)/6` and grows again beyond x = 1. Any number
/// of load steps ends just below the maximum; a spring that snaps there is no answer.
#[test]
fn a_spring_that_softens_does_not_snap_to_its_other_branch() {
    let (limit, at) = (100.0 / (6.0 * 3.0_f64.sqrt()), (3.0 - 3.0_f64.sqrt()) / 6.0);
    let found = |load: f64, load_steps: u32| {
        let options = StaticAnalysis { load_steps, ..StaticAnalysis::default() };
        let mut model = on_slide("100*x - 300*x^2 + 200*x^3", Analysis::Static(options));
        model.loads = vec![Load::Force(vector_load("m", [load, 0.0, 0.0]))];
        solved(&model).map(|(_, outcome)| outcome.state.u[0][0])
    };
    for (load, steps) in [(12.0, 1), (12.0, 2), (12.0, 5), (12.0, 10), (30.0, 1), (30.0, 5), (30.0, 50)] {
        let error = found(load, steps).unwrap_err();
        let Error::NotConverged { at: place, reason, .. } = &error else { panic!("{error}") };
        let factor: f64 = place.trim_start_matches("load factor ").parse().unwrap();
        assert!((factor * load / limit - 1.0).abs() < 1e-2, "{load} {steps}: {error}");
        assert!(reason.contains("limit point"), "{error}");
    }
    let x = found(0.99 * limit, 1).unwrap();
    assert!(x < at && (100.0 * x - 300.0 * x * x + 200.0 * x.powi(3) - 0.99 * limit).abs() < 1e-9, "{x}");
}

/// An actuator whose force has a pole at the end of a step ends the analysis there.
#[test]
fn an_actuator_without_a_force_at_the_end_of_a_step_is_named() {
    for force in ["100*x + 1/(t - 0.5)", "100*x + 0*log(0.5 - t)"] {
        let options = TransientAnalysis {
            scheme: Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 }),
            time_step: Some(1.0 / 64.0),
            ..TransientAnalysis::new(1.0)
        };
        let model = on_slide(force, Analysis::Transient(options.clone()));
        let mesh = tegula::mesh::generators::generate(&model.mesh).unwrap();
        let system = tegula::compile::build(&model, &mesh).unwrap();
        let found = tegula::analysis::dynamics::run(&system, &options, None, &mut Notes::default());
        let text = found.err().unwrap().to_string();
        assert!(text.contains("the spring \"s\" has no finite value"), "{text}");
    }
}

/// A step across a pole of a force is none: the energy barrier of 1/(0.3 − x)² has no end, and an infinite impulse no sense.
#[test]
fn poles_within_a_step_are_not_jumped_over() {
    let schemes = [
        Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 }),
        ORDER_4,
        ALPHA,
        Scheme::Bdf2(Bdf2Scheme {}),
        Scheme::Explicit(ExplicitScheme { scale_director_inertia: true }),
    ];
    for scheme in schemes {
        for (force, speed) in [("100*x + 1/(t - 0.3)", 0.0), ("1/(0.3 - x)^2", 6.0), ("1e-3/(0.3 - x)", 6.0)]
        {
            let options =
                TransientAnalysis { scheme, time_step: Some(1.0 / 64.0), ..TransientAnalysis::new(1.0) };
            let mut model = on_slide(force, Analysis::Transient(options.clone()));
            model.bodies[0].velocity = [speed, 0.0, 0.0];
            let mesh = mesh::generators::generate(&model.mesh).unwrap();
            let system = compile::build(&model, &mesh).unwrap();
            match tegula::analysis::dynamics::run(&system, &options, None, &mut Notes::default()) {
                Err(error) => {
                    let text = error.to_string();
                    let told = [
                        "no finite value within the step",
                        "a spring is too stiff",
                        "energy balance is violated",
                    ];
                    assert!(told.iter().any(|told| text.contains(told)), "{scheme:?} {text}");
                }
                Ok(outcome) => {
                    let x = outcome.state.u[system.coordinates.bodies[0].centre as usize][0];
                    // The barrier of 1/(0.3 − x)² takes more energy than there is.
                    assert!(force == "1/(0.3 - x)^2" && x < 0.3, "{scheme:?} {force}: {x}");
                }
            }
        }
    }
}

/// Statics names springs without positive stiffness, at the start or where the load exceeds what they hold.
#[test]
fn springs_whose_force_does_not_grow_are_named() {
    for (force, load, part) in [
        ("-100*x + 30*x^3", 1.0, "does not grow there"),
        ("50*tanh(10*x)", 60.0, "does not grow there"),
        ("10/(1 - x)", 1000.0, "no finite value"),
    ] {
        let mut model = on_slide(force, Analysis::Static(StaticAnalysis::default()));
        model.loads = vec![Load::Force(vector_load("m", [load, 0.0, 0.0]))];
        match solved(&model) {
            Err(error) => assert!(error.to_string().contains(part), "{force}: {error}"),
            Ok((_, outcome)) => {
                let x = outcome.state.u[0][0];
                assert!(
                    part.starts_with("no finite") && x < 1.0 && (10.0 / (1.0 - x) / load - 1.0).abs() < 1e-9,
                    "{x}"
                );
            }
        }
    }
}

/// An arm that falls on a bump stop goes back to the height from which it has fallen, with a scheme that damps, too: the step in which the
/// stop releases it would gain energy, and is repeated with shorter ones.
#[test]
fn an_arm_that_a_bump_stop_releases_takes_shorter_steps() {
    let arm = body("arm", [0.5, 0.0, 0.0], 1.0, Some([0.01, 0.08, 0.08]));
    let joints = vec![revolute("hinge", "ground", "arm", [0.0; 3], [0.0, 1.0, 0.0])];
    let mut model = with_scheme(machine(2.0, 0.01, vec![arm], joints), ALPHA);
    let Analysis::Transient(options) = &mut model.analysis else { panic!() };
    options.time_step = None;
    model.loads = gravity([0.0, 0.0, -9.81]);
    model.springs = vec![SpringDamper {
        across: None,
        name: "stop".into(),
        between: between("ground", "arm"),
        points: [[1.0, 0.0, -1.0], [1.0, 0.0, 0.0]],
        stiffness: 0.0,
        damping: 0.0,
        force: Some("1e5*min(x,0)".into()),
        length: Some(0.8),
    }];
    let mut notes = Notes::keeping();
    let (system, _) = run(&model, &mut notes);
    let height = |state| pose(&system, state, 0).0.z;
    let late = notes.states.iter().filter(|state| state.time > 1.0).map(height);
    let highest = late.reduce(tegula::norm::larger).unwrap();
    assert!(highest < 1e-4 && highest > -0.02, "{highest}");
}
