//! Statics of springs that are stressed in the reference configuration.

use crate::arc_length::Record;
use crate::bushings::bushing;
use crate::common::{compile, static_options, vector_load};
use crate::multibody::{body, pose, revolute, spring, torsion_spring};
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
    assert!(record.events.iter().any(|event| event.contains("led to their forces")), "{:?}", record.events);
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
