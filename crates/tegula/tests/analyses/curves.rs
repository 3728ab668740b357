//! Points on curves: the cycloid as tautochrone, laps of a closed curve, statics, modes, ends of curves, refusals.

use std::f64::consts::{PI, TAU};

use crate::common::Notes;
use crate::multibody::{between, body, gravity, machine, pose, run};
use tegula::analysis::{Silent, dynamics, modal, statics};
use tegula::model::*;
use tegula::result::joint_reaction;
use tegula::{Vec3, compile, mesh};

const G: f64 = 9.81;

fn on_curve(at: [f64; 3], points: Vec<[f64; 3]>, closed: bool) -> Joint {
    Joint::PointOnCurve(CurveJoint {
        name: "wire".into(),
        between: between("ground", "bead"),
        at,
        points,
        closed,
    })
}

fn bead(at: [f64; 3]) -> RigidBody {
    body("bead", at, 0.7, None)
}

/// Radius of the rolling circle of the cycloid.
const R: f64 = 0.5;

/// Cycloid with its lowest point at the origin, up to just below its cusps, in an oblique vertical plane.
fn cycloid(pieces: usize) -> Vec<[f64; 3]> {
    let at = |k: usize| {
        let angle = 0.96 * PI * (2.0 * k as f64 / pieces as f64 - 1.0);
        let x = R * (angle + angle.sin());
        [0.6 * x, 0.8 * x, R * (1.0 - angle.cos())]
    };
    (0..=pieces).map(at).collect()
}

/// Arc of the cycloid from its lowest point, `s² = 8 r z`.
fn arc(x: &Vec3) -> f64 {
    (8.0 * R * x.z).sqrt().copysign(x.x)
}

fn with_scheme(mut model: Model, scheme: Scheme) -> Model {
    let Analysis::Transient(options) = &mut model.analysis else { panic!() };
    options.scheme = scheme;
    model
}

/// A bead on a cycloid swings as `s = s₀ cos ω t` with `ω = ½ √(g/r)` from any height (Huygens' tautochrone): the period is 4π √(r/g).
#[test]
fn the_period_on_a_cycloid_does_not_depend_on_the_amplitude() {
    let omega = 0.5 * (G / R).sqrt();
    let points = cycloid(240);
    for (scheme, order) in [
        (Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 }), 4.0),
        (Scheme::GeneralizedAlpha(GeneralizedAlphaScheme { spectral_radius: 0.9 }), 4.0),
    ] {
        for start in [30, 75, 110] {
            let at = points[start];
            let first = arc(&at.into());
            let error = |steps: f64| {
                // Two periods and an eighth: where the bead moves.
                let end = 2.125 * TAU / omega;
                let joints = vec![on_curve(at, points.clone(), false)];
                let model = machine(end, end / steps, vec![bead(at)], joints);
                let mut notes = Notes::default();
                let model = with_scheme(Model { loads: gravity([0.0, 0.0, -G]), ..model }, scheme);
                let (system, state) = run(&model, &mut notes);
                if matches!(scheme, Scheme::EnergyMomentum(_)) {
                    assert!(notes.drift() <= 1e-10 * notes.kinetic, "{} {}", notes.drift(), notes.kinetic);
                }
                (arc(&pose(&system, &state, 0).0) - first * (omega * end).cos()).abs() / first.abs()
            };
            let [coarse, fine] = [400.0, 800.0].map(error);
            println!("{scheme:?} {start}: {coarse:e} {fine:e}");
            let ratio = coarse / fine;
            assert!(
                fine < 4e-3 && (0.9 * order..1.1 * order).contains(&ratio),
                "{start}: {coarse:e} {fine:e}"
            );
        }
    }
}

/// The composed scheme is of fourth order on curves, too.
#[test]
fn composed_steps_on_a_curve_are_of_fourth_order() {
    let omega = 0.5 * (G / R).sqrt();
    // The spline is fine enough for its own error, of fourth order in its spacing, not to count.
    let points = cycloid(900);
    let at = points[300];
    let first = arc(&at.into());
    let error = |steps: f64| {
        let end = 1.125 * TAU / omega;
        let model = machine(end, end / steps, vec![bead(at)], vec![on_curve(at, points.clone(), false)]);
        let model = Model { loads: gravity([0.0, 0.0, -G]), ..model };
        let scheme = Scheme::EnergyMomentum(EnergyMomentumScheme { order: 4 });
        let mut notes = Notes::default();
        let (system, state) = run(&with_scheme(model, scheme), &mut notes);
        assert!(notes.drift() <= 5e-10 * notes.kinetic, "{} {}", notes.drift(), notes.kinetic);
        (arc(&pose(&system, &state, 0).0) - first * (omega * end).cos()).abs()
    };
    let errors = [50.0, 100.0].map(error);
    println!("{errors:?}");
    assert!(errors[1] < 1e-4 && (12.0..20.0).contains(&(errors[0] / errors[1])), "{errors:?}");
}

/// Ellipse with the semi-axes 1 and b in a plane that is inclined.
fn ellipse(b: f64, n: usize) -> Vec<[f64; 3]> {
    let at = |k: usize| {
        let angle = TAU * k as f64 / n as f64;
        [angle.cos(), 0.8 * b * angle.sin(), 0.6 * b * angle.sin()]
    };
    (0..n).map(at).collect()
}

/// A bead on the narrow ellipse with the semi-axes 1 and b that starts at its flattest place with the speed 2, and the time of three laps.
fn laps(b: f64, steps: f64) -> (Model, Vec3) {
    let points = ellipse(b, 96);
    // Perimeter by the trapezoidal rule, which converges exponentially for periodic functions.
    let speed = |k: usize| {
        let (sine, cosine) = (TAU * k as f64 / 4000.0).sin_cos();
        sine.hypot(b * cosine)
    };
    let perimeter = TAU / 4000.0 * (0..4000).map(speed).sum::<f64>();
    let at = points[24];
    let rider = RigidBody { velocity: [-2.0, 0.0, 0.0], ..bead(at) };
    let end = 3.0 * perimeter / 2.0;
    (machine(end, end / steps, vec![rider], vec![on_curve(at, points, true)]), at.into())
}

/// Without loads the speed is constant: three laps bring the bead back to its start.
#[test]
fn a_bead_laps_a_closed_curve_with_constant_speed() {
    let error = |steps: f64| {
        let (model, at) = laps(0.2, steps);
        let mut notes = Notes::default();
        let (system, state) = run(&model, &mut notes);
        assert!(notes.drift() <= 1e-10 * notes.kinetic, "{} {}", notes.drift(), notes.kinetic);
        (pose(&system, &state, 0).0 - at).norm()
    };
    let [coarse, fine] = [2000.0, 4000.0].map(error);
    assert!(fine < 0.02 && (3.5..4.5).contains(&(coarse / fine)), "{coarse} {fine}");
}

/// In long steps the bead would jump from one side of the ellipse to the other, which is nearer than a step is long, and whose tangent is
/// turned by half a turn: such steps are cut back.
#[test]
fn a_bead_takes_no_short_cut_in_long_steps() {
    let b = 0.2;
    let (model, _) = laps(b, 48.0);
    let mut notes = Notes::keeping();
    let (system, _) = run(&model, &mut notes);
    assert!(notes.events.iter().any(|event| event.contains("\"wire\"") && event.contains("turns by more")));
    assert!(notes.drift() <= 1e-10 * notes.kinetic, "{} {}", notes.drift(), notes.kinetic);
    let mut before: Option<f64> = None;
    for state in &notes.states {
        let x = pose(&system, state, 0).0;
        let off = x.x * x.x + (x.y * x.y + x.z * x.z) / (b * b) - 1.0;
        assert!(off.abs() < 1e-4, "{off}");
        // Direction of the tangent of the ellipse.
        let direction = (b * x.x).atan2(-(0.8 * x.y + 0.6 * x.z) / b);
        let change = before.replace(direction).map_or(0.0, |before| direction - before);
        let change = change - TAU * (change / TAU).round();
        assert!(change.abs() < 0.52, "{change}");
    }
}

/// A parabola `z = x²/(2 R)` as its spline, which is exact to the fourth power of the spacing.
fn parabola(radius: f64, pieces: i32) -> Vec<[f64; 3]> {
    (-pieces..=pieces)
        .map(|k| 1.5 * f64::from(k) / f64::from(pieces))
        .map(|x| [x, 0.0, 0.5 * x * x / radius])
        .collect()
}

fn tied(at: [f64; 3], stiffness: f64) -> SpringDamper {
    SpringDamper {
        across: None,
        name: "tie".into(),
        between: between("ground", "bead"),
        points: [at; 2],
        stiffness,
        damping: 0.0,
        force: None,
        length: Some(0.0),
    }
}

/// A bead on a parabola that a spring holds at x₀ slides down until `m g z' + k ((x − x₀) + (z − z₀) z') = 0`; the wire pushes
/// across its tangent.
#[test]
fn a_bead_on_a_parabola_rests_where_weight_and_spring_balance() {
    let (radius, k) = (0.9, 6.0);
    let points = parabola(radius, 60);
    let at = points[100];
    let mut model = machine(1.0, 0.1, vec![bead(at)], vec![on_curve(at, points, false)]);
    model.loads = gravity([0.0, 0.0, -G]);
    model.springs = vec![tied(at, k)];
    let options = StaticAnalysis { load_steps: 5, ..StaticAnalysis::default() };
    model.analysis = Analysis::Static(options.clone());
    let mesh = mesh::generators::generate(&model.mesh).unwrap();
    let system = compile::build(&model, &mesh).unwrap();
    let state = statics::run(&system, &options, None, &mut Silent).unwrap().state;
    let place = pose(&system, &state, 0).0;
    let balance = |x: f64| {
        let (z, slope) = (0.5 * x * x / radius, x / radius);
        0.7 * G * slope + k * ((x - at[0]) + (z - at[2]) * slope)
    };
    let [mut low, mut high] = [0.0, at[0]];
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if balance(middle) > 0.0 { high = middle } else { low = middle }
    }
    assert!((place.x - low).abs() < 1e-6 && (low - at[0]).abs() > 0.3, "{place} {low}");
    assert!((place.z - 0.5 * low * low / radius).abs() < 1e-6 && place.y.abs() < 1e-12, "{place}");
    let (force, _) = joint_reaction(&system, &state, &system.joints[0]);
    let rest = force - Vec3::new(0.0, 0.0, 0.7 * G) - (place - Vec3::from(at)) * k;
    assert!(rest.norm() < 1e-8 * force.norm(), "{force} {rest}");
}

/// At the lowest point of the parabola, on a spring, the bead vibrates with `ω² = g/R + k/m` under its weight, and with `ω² = k/m` without.
/// The curvature of a spline has an error of the second power of its spacing.
#[test]
fn a_bead_vibrates_about_the_lowest_point_with_the_curvature_of_the_wire() {
    let (radius, k) = (0.9, 6.0);
    let error = |prestressed: bool, pieces: i32| {
        let wire = on_curve([0.0; 3], parabola(radius, pieces), false);
        let mut model = machine(1.0, 0.1, vec![bead([0.0; 3])], vec![wire]);
        model.loads = gravity([0.0, 0.0, -G]);
        model.springs = vec![tied([0.0; 3], k)];
        model.analysis = Analysis::Modal(ModalAnalysis { prestressed, ..ModalAnalysis::new(1) });
        let mesh = mesh::generators::generate(&model.mesh).unwrap();
        let system = compile::build(&model, &mesh).unwrap();
        let equilibrium = prestressed.then(|| modal::prestress(&system, &mut Silent).unwrap().state);
        let found = modal::run(&system, 1, equilibrium.as_ref(), &mut Silent).unwrap();
        let exact = (k / 0.7 + if prestressed { G / radius } else { 0.0 }).sqrt();
        (found.modes[0].omega / exact - 1.0).abs()
    };
    assert!(error(false, 60) < 1e-10);
    let [coarse, fine] = [60, 120].map(|pieces| error(true, pieces));
    assert!(fine < 3e-5 && (3.8..4.2).contains(&(coarse / fine)), "{coarse} {fine}");
}

/// A bead that moves with constant speed leaves a straight wire of two points at a time that is known.
#[test]
fn a_point_that_leaves_the_end_of_its_curve_is_refused() {
    for (direction, end) in [(1.0, "last"), (-1.0, "first")] {
        let points = vec![[-0.7, 0.0, 0.0], [0.7, 0.0, 0.0]];
        let rider = RigidBody { velocity: [1.3 * direction, 0.0, 0.0], ..bead([0.0; 3]) };
        let mut model = machine(2.0, 0.03, vec![rider], vec![on_curve([0.0; 3], points.clone(), false)]);
        let mesh = mesh::generators::generate(&model.mesh).unwrap();
        let system = compile::build(&model, &mesh).unwrap();
        let Analysis::Transient(options) = model.analysis.clone() else { panic!() };
        let error = dynamics::run(&system, &options, None, &mut Silent).unwrap_err();
        let tegula::Error::NotConverged { at, reason, help } = &error else { panic!("{error}") };
        assert!(reason.contains("\"wire\"") && reason.contains(&format!("at the {end} of")), "{reason}");
        assert!(help.contains("Let the curve go on"), "{help}");
        let time: f64 = at.trim_start_matches("time ").parse().unwrap();
        assert!((time - 0.7 / 1.3).abs() < 1e-4, "{at}");
        // A force along the wire pushes the bead off in statics.
        model.springs = vec![tied([0.0; 3], 1.0)];
        let value = [2.0 * direction, 0.0, 0.0];
        model.loads =
            vec![Load::Force(VectorLoad { on: "bead".into(), value, amplitude: None, distribution: None })];
        let options = StaticAnalysis { load_steps: 4, ..StaticAnalysis::default() };
        model.analysis = Analysis::Static(options.clone());
        let system = compile::build(&model, &mesh).unwrap();
        let error = statics::run(&system, &options, None, &mut Silent).err().unwrap().to_string();
        assert!(error.contains("\"wire\"") && error.contains(&format!("at the {end} of")), "{error}");
    }
}

#[test]
fn curves_that_are_none_are_refused() {
    let refused = |change: &dyn Fn(&mut CurveJoint)| {
        let points = parabola(1.0, 60);
        let mut model = machine(1.0, 1e-2, vec![bead(points[60])], vec![on_curve(points[60], points, false)]);
        let Joint::PointOnCurve(keys) = &mut model.joints[0] else { panic!() };
        change(keys);
        let mesh = mesh::generators::generate(&model.mesh).unwrap();
        compile::build(&model, &mesh).err().unwrap().to_string()
    };
    type Change = fn(&mut CurveJoint);
    let cases: [(Change, &str, &str); 8] = [
        (|keys| keys.points.truncate(1), "joints[0].points", "has 1 points"),
        (|keys| keys.points[7] = keys.points[8], "joints[0].points", "points 7 and 8"),
        (|keys| keys.points[3][1] = f64::NAN, "joints[0].points", "finite"),
        (|keys| keys.at = [0.0, 0.0, 0.01], "joints[0].at", "beside its curve"),
        (|keys| keys.at = [1.6, 0.0, 1.28], "joints[0].at", "beside its curve"),
        (|keys| (keys.points, keys.at) = (lemniscate(), [0.0; 3]), "joints[0].points", "crosses itself"),
        (
            |keys| {
                keys.points = ellipse(0.5, 12);
                keys.points.push(keys.points[0]);
                (keys.at, keys.closed) = (keys.points[0], true);
            },
            "joints[0].points",
            "points 12 and 0",
        ),
        (|keys| keys.between = between("bead", "ground"), "joints[0].between", "in which its curve is fixed"),
    ];
    for (change, key, text) in cases {
        let message = refused(&change);
        assert!(message.contains(key) && message.contains(text), "{message}");
    }
}

fn lemniscate() -> Vec<[f64; 3]> {
    let at = |k: usize| {
        let t = 0.98 * TAU * k as f64 / 40.0;
        [t.sin(), t.sin() * t.cos(), 0.0]
    };
    (0..=40).map(at).collect()
}
