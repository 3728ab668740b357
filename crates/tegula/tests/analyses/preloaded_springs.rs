//! Statics of springs that are stressed in the reference configuration.

use crate::arc_length::{Record, centre};
use crate::buckling::modes;
use crate::bushings::bushing;
use crate::common::{compile, static_options, vector_load};
use crate::multibody::{axis_joint, between, body, pose, revolute, spring, torsion_spring};
use tegula::analysis::statics;
use tegula::model::*;

/// A body on a hinge with a torsion spring of stiffness c, which a spring of stiffness k pulls around: with the anchor (0, 2) and the point (cos φ, sin φ) of the
/// body at the distance L, `c φ = k (1 − l/L) · 2 cos φ`.
fn pulled_around(k: f64) -> Model {
    let hinge = revolute("hinge", "ground", "arm", [0.0; 3], [0.0, 0.0, 1.0]);
    let arm = body("arm", [0.0; 3], 1.0, Some([1.0; 3]));
    let mut m = Model::of_bodies(Analysis::Static(StaticAnalysis::default()), vec![arm], vec![hinge]);
    m.torsion_springs = vec![torsion_spring(["ground", "arm"], [0.0, 0.0, 1.0], 1.0)];
    let mut pull = spring("pull", ["ground", "arm"], [[0.0, 2.0, 0.0], [1.0, 0.0, 0.0]], k);
    pull.length = Some(0.2);
    m.springs = vec![pull];
    m.loads = vec![Load::Force(vector_load("arm", [0.0, 1e-3, 0.0]))];
    m
}

/// Whatever the stiffness, the body comes to the equilibrium next to it.
#[test]
fn stressed_springs_turn_a_body_to_its_equilibrium() {
    for k in [0.1, 1.0, 10.0, 100.0, 1e4] {
        let moment = |angle: f64| {
            let length = (5.0 - 4.0 * angle.sin()).sqrt();
            k * (1.0 - 0.2 / length) * 2.0 * angle.cos() - angle
        };
        let (mut low, mut high) = (0.0, std::f64::consts::FRAC_PI_2);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if moment(middle) > 0.0 { low = middle } else { high = middle }
        }
        let m = pulled_around(k);
        let (_, system) = compile(&m);
        let state = statics::run(&system, &static_options(&m), None, &mut Record::default()).unwrap().state;
        let (_, turned) = pose(&system, &state, 0);
        let angle = turned[(1, 0)].atan2(turned[(0, 0)]);
        assert!((angle - low).abs() < 1e-8, "{k}: {angle} {low}");
    }
}

/// A stretched spring turns a body on a soft bushing by 10°: Newton's method does not find the equilibrium from the reference configuration, and cut-backs
/// leave the spring its whole force. From load factor −1 on the force is led to the model in steps.
#[test]
fn stressed_springs_are_led_to_their_forces_where_no_step_leads_from_the_reference() {
    let at = [1.0, 0.2, 0.1];
    let mass = body("mass", at, 1.0, Some([0.1, 0.15, 0.12]));
    let mut m = Model::of_bodies(Analysis::Static(StaticAnalysis::default()), vec![mass], Vec::new());
    let stiffness = Some([20.0, 30.0, 15.0, 2.0, 3.0, 2.5]);
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    m.bushings = vec![Bushing { stiffness, axes, ..bushing(["ground", "mass"], at) }];
    let mut pull = spring("pull", ["ground", "mass"], [[0.0, 0.0, 0.3], [1.0, 0.5, 0.1]], 100.0);
    pull.length = Some(1.0);
    m.springs = vec![pull];
    m.loads = vec![Load::Force(vector_load("mass", [0.0, 0.0, -1e-3]))];
    let (_, system) = compile(&m);
    let mut record = Record::default();
    let found = statics::run(&system, &static_options(&m), None, &mut record).unwrap();
    assert!(
        record.events.iter().any(|event| event.contains("ramped from load factor -1 to 0")),
        "{:?}",
        record.events
    );
    // The energy has a minimum there: it grows along every small motion of the body.
    let energy = |increment: &[f64]| {
        let u = tegula::analysis::equilibrium::moved(&system, &found.state, increment);
        let mut assembly = tegula::system::Assembly::for_forces(&system);
        let k = tegula::system::EvaluationPoint::at_rest(&system, &u, 1.0, found.state.internal());
        let mut loads = vec![[0.0; 3]; u.len()];
        system.add_dead_loads(1.0, 1.0, &mut loads);
        assembly.strain_energy(&system, &k) - tegula::system::dot(&loads, &u)
    };
    let least = energy(&[0.0; 6]);
    for i in 0..6 {
        for size in [1e-3, -1e-3] {
            let mut increment = [0.0; 6];
            increment[i] = size;
            assert!(energy(&increment) > least, "{i} {size}");
        }
    }
    let (_, turned) = pose(&system, &found.state, 0);
    let angle = (0.5 * (turned.trace() - 1.0)).acos().to_degrees();
    assert!(angle > 5.0 && angle < 20.0, "{angle}");
}

/// A body on a slide between two springs with this free length, under a force.
fn compressed(free: f64, force: f64) -> Model {
    let slide = axis_joint("slide", "ground", "apex", [0.0, 0.0, 0.5], [0.0, 0.0, 1.0]);
    let apex = body("apex", [0.0, 0.0, 0.5], 1.0, Some([0.01; 3]));
    let analysis = Analysis::Static(StaticAnalysis::default());
    let mut m = Model::of_bodies(analysis, vec![apex], vec![Joint::Prismatic(slide.into())]);
    m.springs = [("left", -2.0), ("right", 2.0)]
        .map(|(name, x)| {
            let mut leg = spring(name, ["ground", "apex"], [[x, 0.0, 0.0], [0.0, 0.0, 0.5]], 300.0);
            leg.length = Some(free);
            leg
        })
        .to_vec();
    m.loads = vec![Load::Force(vector_load("apex", [0.0, 0.0, force]))];
    m
}

/// Two compressed springs push a body on a slide away from the line between their supports, to its own side: with the free length l and `L = √(b² + z²)` the equilibrium
/// has `2 k (l/L − 1) z = P`. The tangent of the reference configuration is negative, and Newton's method from there may end on the other side.
/// The ramp of the preload belongs to the first load step.
#[test]
fn compressed_springs_push_a_body_to_its_own_side() {
    for free in [2.1, 2.15, 2.19, 2.195, 2.2, 2.3, 2.5, 3.0] {
        for force in [-1.0, 1.0] {
            let m = compressed(free, force);
            let (_, system) = compile(&m);
            let mut record = Record::default();
            let state = statics::run(&system, &static_options(&m), None, &mut record)
                .unwrap_or_else(|error| panic!("{free} {force}: {error} {:?}", record.events))
                .state;
            let z = centre(&system, &state, "apex").z;
            let times: Vec<f64> = record.states.iter().map(|state| state.time).collect();
            let push = 600.0 * (free / 2_f64.hypot(z) - 1.0) * z + force;
            assert!(z > 0.4 && push.abs() < 1e-7, "{free} {force}: {z} {push:e}");
            assert!(times.iter().all(|time| *time >= 0.0), "{times:?}");
        }
    }
}

/// A step that is taken again ramps the preload again.
#[test]
fn ramps_of_preload_are_repeated_with_their_step() {
    let m = compressed(2.2, 1.0);
    let (_, system) = compile(&m);
    let options = static_options(&m);
    let mut stepper = statics::steps(&system, &options, None).unwrap();
    let mut positions = [0.0; 2];
    for position in &mut positions {
        let start = statics::first_state(&system, &options);
        stepper.repeat(&start, f64::INFINITY);
        stepper.advance(&mut Record::default()).unwrap();
        *position = centre(&system, stepper.reached().state, "apex").z;
    }
    assert_eq!(positions[0], positions[1]);
}

/// A body that taut wires hold by their tension alone has no equilibrium without it: its first step is taken from the reference configuration.
///
/// With a load of constant amplitude, which grows from load factor −1 to 0 with the preload, results begin at 0, where springs have their whole preload.
#[test]
fn bodies_that_tension_alone_holds_come_to_equilibrium() {
    let mut m = Model::of_bodies(
        Analysis::Static(StaticAnalysis::default()),
        vec![body("bead", [0.0; 3], 1.0, None)],
        Vec::new(),
    );
    m.springs = [("left", -1.0), ("right", 1.0)]
        .map(|(name, x)| {
            let mut wire = spring(name, ["ground", "bead"], [[x, 0.0, 0.0], [0.0; 3]], 100.0);
            wire.length = Some(0.5);
            wire
        })
        .to_vec();
    m.amplitudes.insert("held".into(), Amplitude::Constant(ConstantAmplitude { value: 1.0 }));
    for amplitude in [None, Some("held".to_owned())] {
        m.loads = vec![Load::Force(VectorLoad { amplitude, ..vector_load("bead", [0.0, 1.0, 0.5]) })];
        let (_, system) = compile(&m);
        let mut record = Record::default();
        let state = statics::run(&system, &static_options(&m), None, &mut record).unwrap().state;
        assert!(record.states.iter().all(|state| state.time >= 0.0));
        let at = centre(&system, &state, "bead");
        let length = (1.0 + at.y * at.y + at.z * at.z).sqrt();
        let pull = 2.0 * 100.0 * (1.0 - 0.5 / length);
        assert!(
            (pull * at.y - 1.0).abs() < 1e-8 && (pull * at.z - 0.5).abs() < 1e-8 && at.x.abs() < 1e-12,
            "{at}"
        );
    }
}

/// A bar on a universal joint, held at its top by taut wires alone: across the wires their tension T holds it, `2 T/L`, and it buckles at `P = 2 T h/L`.
#[test]
fn tension_of_wires_holds_a_bar_against_buckling() {
    let cross = Joint::Universal(TwoAxesJoint {
        name: "cross".into(),
        between: between("ground", "bar"),
        at: [0.0; 3],
        axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        second_at: None,
    });
    let bar = body("bar", [0.0, 0.0, 1.5], 1.0, Some([1.0; 3]));
    let mut m = Model::of_bodies(Analysis::Buckling(BucklingAnalysis::new(1)), vec![bar], vec![cross]);
    m.springs = [("left", -2.0), ("right", 2.0)]
        .map(|(name, x)| {
            let mut wire = spring(name, ["ground", "bar"], [[x, 0.0, 1.5], [0.0, 0.0, 1.5]], 1e4);
            wire.length = Some(2.0 - 40.0 / 1e4);
            wire
        })
        .to_vec();
    m.loads = vec![Load::Force(vector_load("bar", [0.0, 0.0, -1.0]))];
    let found = modes(&m);
    let expected = 2.0 * 40.0 * 1.5 / 2.0;
    assert!((found[0].factor / expected - 1.0).abs() < 1e-9, "{} {expected}", found[0].factor);
}

/// Gas springs push at their free length, too, and their force grows with the length: an unstable equilibrium between two of them is not blamed on that.
#[test]
fn gas_springs_are_not_said_to_have_a_force_that_does_not_grow() {
    let bodies = vec![body("mass", [0.0; 3], 1.0, None)];
    let mut m = Model::of_bodies(Analysis::Static(StaticAnalysis::default()), bodies, Vec::new());
    m.springs = [("left", -1.0), ("right", 1.0)]
        .map(|(name, x)| SpringDamper {
            force: Some("-40/(1.2-x)+100*x".into()),
            ..spring(name, ["ground", "mass"], [[x, 0.0, 0.0], [0.0; 3]], 0.0)
        })
        .to_vec();
    m.loads = vec![Load::Force(vector_load("mass", [0.0, 0.0, 5.0]))];
    let (_, system) = compile(&m);
    let refused = statics::run(&system, &static_options(&m), None, &mut Record::default());
    let error = refused.map(|_| ()).unwrap_err().to_string();
    assert!(!error.contains("does not grow") && error.contains("negative pivot"), "{error}");
}

/// A mass between two springs of the stiffnesses 100 and 50, with these free lengths over lengths of 1, and four soft springs across.
fn between_springs(free: [f64; 2], force: f64, amplitude: Option<&str>) -> Model {
    let mass = body("mass", [0.0; 3], 1.0, None);
    let mut m = Model::of_bodies(Analysis::Static(StaticAnalysis::default()), vec![mass], Vec::new());
    let along = [("left", -1.0, 100.0, free[0]), ("right", 1.0, 50.0, free[1])].map(|(name, x, k, free)| {
        let mut along = spring(name, ["ground", "mass"], [[x, 0.0, 0.0], [0.0; 3]], k);
        along.length = Some(free);
        along
    });
    let across =
        [("a", [0.0, -1.0, 0.0]), ("b", [0.0, 1.0, 0.0]), ("c", [0.0, 0.0, -1.0]), ("d", [0.0, 0.0, 1.0])]
            .map(|(name, from)| spring(name, ["ground", "mass"], [from, [0.0; 3]], 10.0));
    m.springs = along.into_iter().chain(across).collect();
    m.amplitudes = [("full".to_owned(), Amplitude::Constant(ConstantAmplitude { value: 1.0 }))].into();
    let load =
        VectorLoad { amplitude: amplitude.map(str::to_owned), ..vector_load("mass", [force, 0.0, 0.0]) };
    m.loads = vec![Load::Force(load)];
    m
}

/// A load that acts fully from the start enters the ramp of the preload: the mass comes to
/// `150 x + 40 x (1 − 1/√(1 + x²)) = 50 (1 − l₂) − 100 (1 − l₁) + F`.
#[test]
fn preloads_are_ramped_beside_loads_of_constant_amplitude() {
    for free in [[0.5, 0.8], [0.9, 0.1], [0.9, 0.5], [0.8, 0.5]] {
        for force in [-5.0, 5.0] {
            for amplitude in [None, Some("full")] {
                let m = between_springs(free, force, amplitude);
                let (_, system) = compile(&m);
                let mut record = Record::default();
                let state = statics::run(&system, &static_options(&m), None, &mut record)
                    .unwrap_or_else(|error| panic!("{free:?} {force}: {error} {:?}", record.events))
                    .state;
                let x = centre(&system, &state, "mass").x;
                let along = 50.0 * (1.0 - free[1]) - 100.0 * (1.0 - free[0]) + force - 150.0 * x;
                let across = 40.0 * x * (1.0 - 1.0 / 1.0_f64.hypot(x));
                assert!((along - across).abs() < 1e-8, "{free:?} {force}: {x} {along:e} {across:e}");
            }
        }
    }
}

/// A torsion spring that is wound by more than a turn against the weight of an arm: `c (θ₀ − θ) + m g l cos θ = 0` has one solution.
#[test]
fn torsion_springs_are_wound_beside_a_weight_of_constant_amplitude() {
    for amplitude in [None, Some("full")] {
        let hinge = revolute("hinge", "ground", "arm", [0.0; 3], [0.0, 1.0, 0.0]);
        let arm = body("arm", [0.5, 0.0, 0.0], 1.0, Some([1.0; 3]));
        let mut m = Model::of_bodies(Analysis::Static(StaticAnalysis::default()), vec![arm], vec![hinge]);
        let mut wound = torsion_spring(["ground", "arm"], [0.0, 1.0, 0.0], 10.0);
        wound.free_angle = -400.0;
        m.torsion_springs = vec![wound];
        m.amplitudes = [("full".to_owned(), Amplitude::Constant(ConstantAmplitude { value: 1.0 }))].into();
        let weight = vector_load("arm", [0.0, 0.0, -9.81]);
        m.loads = vec![Load::Force(VectorLoad { amplitude: amplitude.map(str::to_owned), ..weight })];
        let (_, system) = compile(&m);
        let state = statics::run(&system, &static_options(&m), None, &mut Record::default()).unwrap().state;
        let angle = (-centre(&system, &state, "arm").z).atan2(centre(&system, &state, "arm").x);
        let angle = angle - std::f64::consts::TAU;
        let moment = 10.0 * (-400_f64.to_radians() - angle) + 9.81 * 0.5 * angle.cos();
        assert!(moment.abs() < 1e-7, "{amplitude:?}: {} {moment:e}", angle.to_degrees());
    }
}

/// A slider on two springs and a nonlinear one, under a load that turns back at 0.3: a stable branch leads to 1 whatever the load steps, although the slope of the
/// load jumps at the end of some of them.
#[test]
fn loads_that_turn_back_at_the_end_of_a_step_are_followed() {
    let anchors = [[-0.56, 0.74, 0.0], [0.74, -0.22, 0.0], [0.36, 1.12, 0.0]];
    let lengths = [0.3, 0.49, 1.32];
    let (stiffnesses, cubic) = ([58.0, 1.58, 24.5], [0.0, 0.0, 49.0]);
    let mut m = Model::of_bodies(
        Analysis::Static(StaticAnalysis::default()),
        vec![body("slider", [0.0; 3], 2.0, Some([1.0; 3]))],
        vec![Joint::Prismatic(axis_joint("guide", "ground", "slider", [0.0; 3], [0.0, 1.0, 0.0]).into())],
    );
    m.springs = (0..3)
        .map(|i| {
            let mut spring =
                spring(&format!("s{i}"), ["ground", "slider"], [anchors[i], [0.0; 3]], stiffnesses[i]);
            spring.length = Some(lengths[i]);
            if cubic[i] != 0.0 {
                spring.stiffness = 0.0;
                spring.force = Some(format!("{}*x + {}*x^3", stiffnesses[i], cubic[i]));
            }
            spring
        })
        .collect();
    let mut load = vector_load("slider", [0.0, -15.0, 0.0]);
    load.amplitude = Some("table".into());
    m.loads = vec![Load::Force(load)];
    let values = [0.165, -0.98, -0.085];
    let table = TableAmplitude { times: vec![0.0, 0.3, 1.0], values: values.to_vec() };
    m.amplitudes.insert("table".into(), Amplitude::Table(table));
    let force = |y: f64| -> f64 {
        let of_spring = |i: usize| {
            let length = anchors[i][0].hypot(anchors[i][1] - y);
            let x = length - lengths[i];
            (stiffnesses[i] * x + cubic[i] * x.powi(3)) * (anchors[i][1] - y) / length
        };
        (0..3).map(of_spring).sum::<f64>() - 15.0 * values[2]
    };
    let (mut low, mut high) = (0.2, 0.6);
    assert!(force(low) > 0.0 && force(high) < 0.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if force(middle) > 0.0 { low = middle } else { high = middle }
    }
    for load_steps in [1, 2, 3, 10, 20, 50] {
        m.analysis = Analysis::Static(StaticAnalysis { load_steps, ..StaticAnalysis::default() });
        let (_, system) = compile(&m);
        let found = statics::run(&system, &static_options(&m), None, &mut Record::default());
        let state = found.unwrap_or_else(|e| panic!("{load_steps} steps: {e}")).state;
        let (position, _) = pose(&system, &state, 0);
        assert!((position.y - low).abs() < 1e-8, "{load_steps}: {} {low}", position.y);
    }
}
