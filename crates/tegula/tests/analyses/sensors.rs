//! Sensors and stop conditions against closed solutions: falls, pendulums, oscillators, wheels that turn many times; statics.

use crate::multibody::{between, body, gravity, machine, revolute};
use tegula::analysis::{Observer, State, Step, Stopped, dynamics, statics};
use tegula::model::*;
use tegula::norm::max_norm;
use tegula::result::{sensor_columns, sensor_values};
use tegula::{Error, Result, System, compile, mesh};

const ENERGY_MOMENTUM: Scheme = Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 });
const FOURTH_ORDER: Scheme = Scheme::EnergyMomentum(EnergyMomentumScheme { order: 4 });
const ALPHA: Scheme = Scheme::GeneralizedAlpha(GeneralizedAlphaScheme { spectral_radius: 0.9 });

/// Columns of the sensors, for stop conditions; messages.
#[derive(Default)]
pub struct Columns {
    system: Option<System>,
    times: Vec<f64>,
    values: Vec<Vec<f64>>,
    warnings: Vec<String>,
    events: Vec<String>,
}

impl Observer for Columns {
    fn on_step(&mut self, step: &Step) -> Result<()> {
        self.times.push(step.state.time);
        self.values.extend(self.system.as_ref().map(|system| sensor_values(system, step.state)));
        Ok(())
    }
    fn on_event(&mut self, message: &str) {
        self.events.push(message.into());
    }
    fn on_warning(&mut self, message: &str) {
        self.warnings.push(message.into());
    }
    fn column(&mut self, name: &str, step: &Step) -> Option<f64> {
        let system = self.system.as_ref()?;
        let number = sensor_columns(system).iter().position(|column| column == name)?;
        Some(sensor_values(system, step.state)[number])
    }
}

fn compiled(model: &Model) -> System {
    let mesh = mesh::generators::generate(&model.mesh).unwrap();
    compile::build(model, &mesh).unwrap()
}

/// Runs a model; returns its end, the stop condition and what the observer has seen.
fn analysed(model: &Model) -> (State, Option<Stopped>, Columns) {
    let system = compiled(model);
    let mut seen = Columns { system: Some(compiled(model)), ..Columns::default() };
    let (state, stopped) = match &model.analysis {
        Analysis::Static(options) => {
            let outcome = statics::run(&system, options, None, &mut seen).unwrap();
            (outcome.state, outcome.stopped)
        }
        Analysis::Transient(options) => {
            let outcome = dynamics::run(&system, options, None, &mut seen).unwrap();
            (outcome.state, outcome.stopped)
        }
        Analysis::Path(_) | Analysis::Modal(_) | Analysis::Buckling(_) => panic!(),
    };
    (state, stopped, seen)
}

fn stop(column: &str, value: f64, direction: Crossing) -> StopCondition {
    StopCondition { column: column.into(), value, direction }
}

fn with_stops(model: Model, scheme: Scheme, time_step: Option<f64>, stop: Vec<StopCondition>) -> Model {
    let Analysis::Transient(options) = model.analysis.clone() else { panic!() };
    let options = TransientAnalysis { scheme, time_step, stop, ..options };
    Model { analysis: Analysis::Transient(options), ..model }
}

fn point(on: &str) -> Sensor {
    Sensor::Point(PointSensor { name: "p".into(), on: on.into(), at: None })
}

fn angle(name: &str, first: &str, second: &str) -> Sensor {
    let between = between(first, second);
    Sensor::Angle(AngleSensor { name: name.into(), between, axis: [0.0, 0.0, 2.0] })
}

/// A body that falls from rest reaches y = −h at √(2h/g), which no step ends at: all schemes integrate this motion exactly.
#[test]
fn a_fall_ends_at_its_depth() {
    let (g, h) = (9.81, 3.3);
    let falling = Model { loads: gravity([0.0, -g, 0.0]), ..machine(2.0, 0.1, vec![], vec![]) };
    let stone = body("stone", [1.0, 0.0, 0.0], 2.0, Some([0.1, 0.2, 0.25]));
    let falling = Model { bodies: vec![stone], sensors: vec![point("stone")], ..falling };
    let exact = (2.0 * h / g).sqrt();
    for (scheme, step) in [
        (ENERGY_MOMENTUM, Some(0.1)),
        (ENERGY_MOMENTUM, None),
        (FOURTH_ORDER, Some(0.1)),
        (ALPHA, Some(0.03)),
    ] {
        let model =
            with_stops(falling.clone(), scheme, step, vec![stop("sensor.p.y", -h, Crossing::Falling)]);
        let (state, stopped, seen) = analysed(&model);
        let stopped = stopped.unwrap();
        assert!((state.time - exact).abs() < 1e-6 * exact, "{scheme:?} {}: {exact}", state.time);
        assert!(stopped.reached <= -h && stopped.reached > -h - 1e-5, "{stopped:?}");
        assert_eq!((stopped.time, stopped.condition), (state.time, 0));
        assert_eq!(seen.times.last(), Some(&state.time));
        assert!(seen.times.windows(2).all(|t| t[0] < t[1]), "{:?}", seen.times);
        assert!(seen.warnings.is_empty() && seen.events.iter().any(|e| e.contains("sensor.p.y")));
    }
}

/// A falling sheet reaches its depth at the same time with every scheme for shells; the explicit scheme compares columns at every tenth
/// step.
#[test]
fn a_sheet_that_falls_ends_at_its_depth_with_all_schemes_of_shells() {
    let (g, h) = (9.81, 0.5);
    let plate = MeshSource::Plate(PlateMesh::new([1.0, 0.5], [2, 1]));
    let rubber = Isotropic::new(1e6, 0.3, 1000.0);
    let exact = (2.0_f64 * h / g).sqrt();
    for (scheme, step) in [
        (Scheme::Newmark(NewmarkScheme::default()), Some(0.05)),
        (Scheme::Hht(HhtScheme::default()), None),
        (Scheme::Explicit(ExplicitScheme::default()), None),
        (ENERGY_MOMENTUM, None),
    ] {
        let analysis = Analysis::Transient(TransientAnalysis::new(1.0));
        let model = Model::new(plate.clone(), analysis, rubber.clone(), 0.05);
        let model = Model { loads: gravity([0.0, 0.0, -g]), sensors: vec![point("u_max_v_max")], ..model };
        let condition = stop("sensor.p.z", -h, Crossing::Either);
        let (state, stopped, _) = analysed(&with_stops(model, scheme, step, vec![condition]));
        assert!(stopped.is_some() && (state.time - exact).abs() < 1e-6, "{scheme:?} {}: {exact}", state.time);
    }
}

/// Complete elliptic integral of the first kind, by the arithmetic–geometric mean (Gauss).
fn elliptic_integral(k: f64) -> f64 {
    let (mut a, mut b) = (1.0, (1.0 - k * k).sqrt());
    for _ in 0..10 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    std::f64::consts::FRAC_PI_2 / a
}

/// A bar released at rest 70° from the vertical passes its lowest point at K(sin 35°) √(J/(m g l)): second order in the step.
#[test]
fn a_pendulum_ends_at_its_lowest_point() {
    let (g, l, m, j, start) = (9.81, 0.7, 2.0, 0.5, 70.0_f64.to_radians());
    let at = [l * start.sin(), -l * start.cos(), 0.0];
    let bar = body("bar", at, m, Some([0.3, 0.3, j]));
    let hinge = revolute("hinge", "ground", "bar", [0.0; 3], [0.0, 0.0, 1.0]);
    let exact = elliptic_integral((0.5 * start).sin()) * ((j + m * l * l) / (m * g * l)).sqrt();
    for scheme in [ENERGY_MOMENTUM, ALPHA] {
        let error = |step: f64| {
            let model = machine(3.0, step, vec![bar.clone()], vec![hinge.clone()]);
            let sensors = vec![angle("swing", "ground", "bar")];
            let model = Model { loads: gravity([0.0, -g, 0.0]), sensors, ..model };
            let condition = stop("sensor.swing.angle", -70.0, Crossing::Falling);
            let (state, stopped, seen) = analysed(&with_stops(model, scheme, Some(step), vec![condition]));
            assert!((stopped.unwrap().reached + 70.0).abs() < 1e-4);
            // There its kinetic energy is m g l (1 − cos θ₀): the rate of the angle follows.
            let fastest = (2.0 * m * g * l * (1.0 - start.cos()) / (j + m * l * l)).sqrt().to_degrees();
            let rate = seen.values.last().unwrap()[1];
            assert!((rate / -fastest - 1.0).abs() < 1e-2, "{rate} {fastest}");
            (state.time - exact).abs()
        };
        let [coarse, fine] = [0.02, 0.01].map(error);
        assert!(fine < 2e-4 && (3.5..4.5).contains(&(coarse / fine)), "{scheme:?} {coarse} {fine}");
    }
}

/// A wheel with a torsion spring wound up by two and a quarter turns: θ = θ₀ (1 − cos ωt), on the way there and on the way back.
#[test]
fn an_oscillator_ends_at_angles_beyond_full_turns() {
    let wheel = body("wheel", [0.0; 3], 2.0, Some([0.3, 0.3, 0.5]));
    let hinge = revolute("hinge", "ground", "wheel", [0.0; 3], [0.0, 0.0, 1.0]);
    let coil = TorsionSpring {
        name: "coil".into(),
        between: between("ground", "wheel"),
        axis: [0.0, 0.0, 1.0],
        stiffness: 2.0,
        damping: 0.0,
        moment: None,
        free_angle: 810.0,
    };
    let model = machine(5.0, 1e-3, vec![wheel], vec![hinge]);
    let sensors = vec![angle("turns", "ground", "wheel"), angle("back", "wheel", "ground")];
    let model = Model { torsion_springs: vec![coil], sensors, ..model };
    let (omega, value) = (2.0_f64, 900.0);
    let first = (1.0 - value / 810.0_f64).acos() / omega;
    let second = std::f64::consts::TAU / omega - first;
    for (column, sign, direction, exact) in [
        ("sensor.turns.angle", 1.0, Crossing::Rising, first),
        ("sensor.turns.angle", 1.0, Crossing::Falling, second),
        ("sensor.back.angle", -1.0, Crossing::Falling, first),
        ("sensor.back.angle", -1.0, Crossing::Rising, second),
    ] {
        let condition = stop(column, sign * value, direction);
        let error = |step: f64| {
            let conditions = vec![condition.clone()];
            let (state, stopped, seen) =
                analysed(&with_stops(model.clone(), ENERGY_MOMENTUM, Some(step), conditions));
            assert!((stopped.unwrap().reached - sign * value).abs() < 1e-4);
            // The rate is 810° ω sin ωt.
            let number = if column.contains("turns") { 1 } else { 3 };
            let rate = sign * seen.values.last().unwrap()[number];
            let expected = 810.0 * omega * (omega * exact).sin();
            assert!((rate / expected - 1.0).abs() < 1e-3, "{rate} {expected}");
            (state.time - exact).abs()
        };
        let [coarse, fine] = [2e-3, 1e-3].map(error);
        assert!(
            fine < 1e-4 && (3.5..4.5).contains(&(coarse / fine)),
            "{column} {direction:?} {coarse} {fine}"
        );
    }
}

/// Two wheels that turn against each other by more than half a turn in each given step: no turn is lost, whether steps are cut back or
/// not. In such steps schemes turn bodies too slowly or too fast, by less than a turn here.
#[test]
fn no_turn_is_lost_where_bodies_turn_fast_against_each_other() {
    let spun = |name: &str, w: f64| RigidBody {
        angular_velocity: [0.0, 0.0, w],
        ..body(name, [0.0; 3], 1.0, Some([0.2, 0.2, 0.4]))
    };
    for (scheme, speed) in [(FOURTH_ORDER, 18.0), (FOURTH_ORDER, 12.0), (ALPHA, 14.0), (ALPHA, 11.0)] {
        let bodies = vec![spun("a", -speed), spun("b", speed)];
        let sensors = vec![angle("both", "a", "b"), angle("a", "ground", "a"), angle("b", "ground", "b")];
        let model = Model { sensors, ..machine(1.0, 0.1, bodies, vec![]) };
        let (state, _, seen) = analysed(&with_stops(model, scheme, Some(0.1), vec![]));
        let [both, a, b] = [0, 2, 4].map(|i| seen.values.last().unwrap()[i].to_radians());
        assert!((both - (b - a)).abs() < 1e-9, "{scheme:?} {both} {a} {b}");
        assert!(state.time == 1.0 && (0.75..1.25).contains(&(b / speed)), "{scheme:?} {b}");
    }
}

/// Two wheels that moments turn against each other by 4 rad, each by its spring: one load step would be longer than half a turn.
#[test]
fn load_steps_that_would_lose_a_turn_are_cut_back() {
    let bodies = ["a", "b"].map(|name| body(name, [0.0; 3], 1.0, Some([0.3, 0.3, 0.5]))).to_vec();
    let hinges = ["a", "b"].map(|name| revolute(name, "ground", name, [0.0; 3], [0.0, 0.0, 1.0])).to_vec();
    let mut model = Model::of_bodies(Analysis::Static(StaticAnalysis::default()), bodies, hinges);
    for (on, value) in [("a", -2.0), ("b", 2.0)] {
        let (between, axis) = (between("ground", on), [0.0, 0.0, 1.0]);
        let (stiffness, damping, free_angle) = (1.0, 0.0, 0.0);
        model.torsion_springs.push(TorsionSpring {
            name: on.into(),
            between,
            axis,
            stiffness,
            damping,
            moment: None,
            free_angle,
        });
        let load =
            VectorLoad { on: on.into(), value: [0.0, 0.0, value], amplitude: None, distribution: None };
        model.loads.push(Load::Moment(load));
    }
    model.sensors = vec![angle("both", "a", "b")];
    let (_, _, seen) = analysed(&model);
    let found = seen.values.last().unwrap()[0];
    assert!((found - 4_f64.to_degrees()).abs() < 1e-7, "{found}");
    assert!(seen.events.iter().any(|e| e.contains("the angle of the sensor \"both\"")), "{:?}", seen.events);
}

/// A disc that spins about its axis and flies: a point on it has x = x₀ + v t + R r, its velocity and acceleration; the distance of
/// the disc from the ground and its rate are those of a straight line.
#[test]
fn sensors_measure_distances_and_the_motion_of_points() {
    let (w, v) = (3.0, [0.0, 2.0, 0.0]);
    let disc = RigidBody {
        velocity: v,
        angular_velocity: [0.0, 0.0, w],
        ..body("disc", [1.0, 0.0, 0.0], 1.0, Some([0.2, 0.2, 0.4]))
    };
    let rim = PointSensor { name: "rim".into(), on: "disc".into(), at: Some([1.5, 0.0, 0.1]) };
    let way = DistanceSensor {
        name: "way".into(),
        between: between("ground", "disc"),
        points: [[0.0; 3], [1.0, 0.0, 0.0]],
    };
    let error = |step: f64| {
        let sensors = vec![Sensor::Distance(way.clone()), Sensor::Point(rim.clone())];
        let model = Model { sensors, ..machine(0.5, step, vec![disc.clone()], vec![]) };
        let (state, _, seen) = analysed(&with_stops(model, ALPHA, Some(step), vec![]));
        let (t, found) = (state.time, seen.values.last().unwrap());
        let distance = (1.0 + 4.0 * t * t).sqrt();
        assert!((found[0] - distance).abs() < 1e-9 && (found[1] - 4.0 * t / distance).abs() < 1e-9);
        let (sin, cos) = (w * t).sin_cos();
        let expected = [
            [1.0 + 0.5 * cos, 2.0 * t + 0.5 * sin, 0.1],
            [-0.5 * w * sin, 2.0 + 0.5 * w * cos, 0.0],
            [-0.5 * w * w * cos, -0.5 * w * w * sin, 0.0],
        ];
        let off: Vec<f64> = found[2..].iter().zip(expected.as_flattened()).map(|(a, b)| a - b).collect();
        max_norm(&off)
    };
    let [coarse, fine] = [4e-3, 2e-3].map(error);
    assert!(fine < 1e-3 && (3.0..5.0).contains(&(coarse / fine)), "{coarse} {fine}");
}

/// Of two conditions that are met in one step, the earlier one ends the analysis: a fall reaches a depth before a speed, or after.
#[test]
fn the_first_of_several_conditions_ends_the_analysis() {
    let g = 10.0;
    let stone = body("stone", [0.0; 3], 1.0, Some([0.1, 0.2, 0.25]));
    let model = machine(2.0, 0.5, vec![stone], vec![]);
    let model = Model { loads: gravity([0.0, -g, 0.0]), sensors: vec![point("stone")], ..model };
    for (depth, speed, first) in [(2.0, 9.0, 0), (4.5, 6.0, 1)] {
        let conditions = vec![
            stop("sensor.p.y", -depth, Crossing::Either),
            stop("sensor.p.vy", -speed, Crossing::Falling),
        ];
        let exact = if first == 0 { (2.0_f64 * depth / g).sqrt() } else { speed / g };
        let (state, stopped, _) =
            analysed(&with_stops(model.clone(), ENERGY_MOMENTUM, Some(0.5), conditions));
        assert_eq!(stopped.unwrap().condition, first);
        assert!((state.time - exact).abs() < 1e-5, "{} {exact}", state.time);
    }
}

/// A linear spring under a growing moment turns by λ M/k; a strip under a growing load stretches in proportion: the analyses end at
/// the load factor that belongs to the value, whatever the load steps.
#[test]
fn load_steps_end_at_the_load_factor_of_a_value() {
    let wheel = body("wheel", [0.0; 3], 2.0, Some([0.3, 0.3, 0.5]));
    let hinge = revolute("hinge", "ground", "wheel", [0.0; 3], [0.0, 0.0, 1.0]);
    let coil = TorsionSpring {
        name: "coil".into(),
        between: between("ground", "wheel"),
        axis: [0.0, 0.0, 1.0],
        stiffness: 2.0,
        damping: 0.0,
        moment: None,
        free_angle: 0.0,
    };
    let moment = 2.0 * 500_f64.to_radians();
    let condition = stop("sensor.turns.angle", 400.0, Crossing::Rising);
    let options = StaticAnalysis { load_steps: 7, stop: vec![condition], ..StaticAnalysis::default() };
    let model = Model::of_bodies(Analysis::Static(options), vec![wheel], vec![hinge]);
    let load =
        VectorLoad { on: "wheel".into(), value: [0.0, 0.0, moment], amplitude: None, distribution: None };
    let sensors = vec![angle("turns", "ground", "wheel")];
    let model = Model { torsion_springs: vec![coil], loads: vec![Load::Moment(load)], sensors, ..model };
    let (state, stopped, seen) = analysed(&model);
    assert!(stopped.is_some() && (state.time - 0.8).abs() < 1e-6, "{}", state.time);
    assert_eq!(sensor_columns(seen.system.as_ref().unwrap()), ["sensor.turns.angle"]);

    for linear_solver in [LinearSolver::Direct, LinearSolver::Iterative] {
        for (load_steps, whole) in [(1, 0.01), (4, 0.01)] {
            let strip = MeshSource::Plate(PlateMesh::new([1.0, 0.1], [8, 2]));
            let condition = stop("sensor.p.x", 1.0 + 0.37 * whole, Crossing::Either);
            let options = StaticAnalysis {
                linear: true,
                load_steps,
                linear_solver,
                stop: vec![condition],
                ..Default::default()
            };
            let model = Model::new(strip, Analysis::Static(options), Isotropic::new(1e9, 0.0, 1.0), 0.01);
            let model = Model {
                conditions: vec![Condition::Clamp(OnSet::new("u_min"))],
                loads: vec![Load::Edge(VectorLoad::new("u_max", [1e9 * 0.01 * whole, 0.0, 0.0]))],
                sensors: vec![point("u_max_v_max")],
                ..model
            };
            let (state, stopped, _) = analysed(&model);
            assert!(stopped.is_some() && (state.time - 0.37).abs() < 1e-6, "{}", state.time);
        }
    }
}

/// A condition that is true at the start, or met never, is told; the column of a condition must be known.
#[test]
fn conditions_that_hold_at_the_start_or_never_are_told() {
    let stone = body("stone", [0.0; 3], 1.0, Some([0.1, 0.2, 0.25]));
    let model = machine(0.5, 0.1, vec![stone], vec![]);
    let model = Model { loads: gravity([0.0, -9.81, 0.0]), sensors: vec![point("stone")], ..model };
    let ended = |condition| analysed(&with_stops(model.clone(), ENERGY_MOMENTUM, Some(0.1), vec![condition]));
    let (state, stopped, seen) = ended(stop("sensor.p.y", -100.0, Crossing::Falling));
    assert!(stopped.is_none() && state.time == 0.5 && seen.warnings.len() == 1, "{:?}", seen.warnings);
    assert!(seen.warnings[0].contains("no stop condition was met"), "{:?}", seen.warnings);
    let (_, stopped, seen) = ended(stop("sensor.p.y", 0.0, Crossing::Falling));
    assert!(stopped.is_none() && seen.warnings[0].contains("true at the start"), "{:?}", seen.warnings);
    let system = compiled(&model);
    let unknown = with_stops(
        model.clone(),
        ENERGY_MOMENTUM,
        Some(0.1),
        vec![stop("sensor.q.y", 0.0, Crossing::Either)],
    );
    let Analysis::Transient(options) = &unknown.analysis else { panic!() };
    let error = dynamics::run(&system, options, None, &mut Columns::default()).unwrap_err();
    assert!(matches!(&error, Error::Model(issues) if issues[0].place.key == "analysis.stop[0].column"));
}

fn refused(model: &Model) -> Vec<String> {
    let mesh = mesh::generators::generate(&model.mesh).unwrap();
    let Err(Error::Model(issues)) = compile::build(model, &mesh) else { panic!("not refused") };
    issues.into_iter().map(|issue| format!("{}: {}", issue.place, issue.message)).collect()
}

#[test]
fn wrong_sensors_and_conditions_are_refused_at_their_keys() {
    let bodies =
        vec![body("stone", [0.0; 3], 1.0, Some([0.1, 0.2, 0.25])), body("bead", [1.0; 3], 1.0, None)];
    let model = machine(1.0, 0.1, bodies, vec![]);
    let with = |sensors: Vec<Sensor>| refused(&Model { sensors, ..model.clone() }).join("\n");
    let at = |on: &str, at| Sensor::Point(PointSensor { name: "p".into(), on: on.into(), at });
    assert!(with(vec![at("ground", None)]).contains("sensors[0].on: the sensor \"p\" is on the ground"));
    assert!(with(vec![at("moon", None)]).contains("sensors[0].on: there is no body"));
    assert!(with(vec![at("bead", Some([0.0; 3]))]).contains("sensors[0].at: the point lies beside \"bead\""));
    assert!(with(vec![at("stone", Some([f64::NAN; 3]))]).contains("sensors[0].at"));
    assert!(with(vec![at("stone", None), at("bead", None)]).contains("sensors[1].name"));
    assert!(
        with(vec![angle("a", "stone", "bead")])
            .contains("sensors[0].between: the sensor \"a\" needs an axis")
    );
    assert!(with(vec![angle("a", "stone", "stone")]).contains("connects \"stone\" with itself"));
    let reaction = ReactionSensor { name: "r".into(), joint: "hinge".into() };
    assert!(with(vec![Sensor::Reaction(reaction)]).contains("sensors[0].joint: there is no joint \"hinge\""));
    let axis = AngleSensor { name: "a".into(), between: between("ground", "stone"), axis: [0.0; 3] };
    assert!(with(vec![Sensor::Angle(axis)]).contains("sensors[0].axis"));
    for (column, value, key) in
        [("step_size", 1.0, "column"), ("balance.force", 1.0, "column"), ("px", f64::INFINITY, "value")]
    {
        let conditions = vec![stop(column, value, Crossing::Either)];
        let found = refused(&with_stops(model.clone(), ENERGY_MOMENTUM, Some(0.1), conditions));
        assert!(found[0].starts_with(&format!("analysis.stop[0].{key}")), "{found:?}");
    }
}
