//! Power series of paths under pressures, which follow the surface: against the arc-length method and closed forms.

use crate::arc_length::{by_arc_length, run};
use crate::common::{cylinder, model, on, vector_load};
use crate::paths::critical;
use crate::series_with_constraints::{both, distance};
use tegula::analysis::path::CriticalKind;
use tegula::model::*;

fn pressure(value: f64) -> Load {
    Load::Pressure(PressureLoad { on: "all".into(), value, amplitude: None, distribution: None })
}

fn symmetry(set: &str, normal: [f64; 3]) -> Condition {
    Condition::Symmetry(SymmetryPlane { on: set.into(), normal })
}

/// Part of a long cylinder with its middle at `u_min`.
fn arch(element: ElementKind, [radius, angle, thickness]: [f64; 3], elements: u32) -> Model {
    let mut m = model(cylinder(radius, [0.0, angle], 0.1 * radius, [elements, 1]), 3102.75, thickness);
    m.sections[0].element = element;
    m.conditions = vec![
        symmetry("u_min", [1.0, 0.0, 0.0]),
        symmetry("v_min", [0.0, 1.0, 0.0]),
        symmetry("v_max", [0.0, 1.0, 0.0]),
    ];
    m.analysis = Analysis::Path(PathAnalysis { end_load: 1.0, ..Default::default() });
    m
}

/// A hinged arch under pressure, and under a force beside it, snaps as by arc length, in a tenth of the factorisations; the work of the pressure is the
/// strain energy.
#[test]
fn arches_under_pressure_snap_as_by_arc_length_in_a_tenth_of_the_factorisations() {
    for element in [ElementKind::Ems, ElementKind::Mitc4] {
        for force in [0.0, 20.0] {
            let mut m = arch(element, [2540.0, 5.729_577_951_308_232, 6.35], 16);
            m.conditions.push(Condition::Hinge(on("u_max")));
            m.loads = vec![pressure(0.01), Load::Force(vector_load("u_min", [0.0, 0.0, -force]))];
            let [(_, series, _), (_, arc, _)] = both(&m);
            let [found, other] = [&series, &arc].map(critical);
            assert_eq!((found.len(), other.len()), (2, 2));
            for (a, b) in found.iter().zip(other) {
                assert!(a.kind == CriticalKind::Limit && (a.load / b.load - 1.0).abs() < 1e-7, "{a:?} {b:?}");
            }
            assert!(distance([&series, &arc]) < 1e-9);
            let [few, many] = [&series, &arc].map(|outcome| outcome.statistics.factorizations);
            assert!(few <= 20 && 8 * few <= many, "{few} {many}");
            if force == 0.0 {
                let [work, strain] = [series.state.work, series.balance.strain];
                assert!((work / strain - 1.0).abs() < 1e-8, "{element:?}: {work} {strain}");
            }
        }
    }
}

/// The work of a pressure is the strain energy on a crossing path, too: that of the jump to it is counted.
#[test]
fn work_of_pressures_counts_the_jump_to_a_crossing_path() {
    let mut m = arch(ElementKind::Ems, [2540.0, 5.729_577_951_308_232, 2.0], 24);
    m.mesh = cylinder(2540.0, [-5.729_577_951_308_232, 5.729_577_951_308_232], 254.0, [24, 1]);
    m.conditions.remove(0);
    m.conditions.extend(["u_min", "u_max"].map(|edge| Condition::Hinge(on(edge))));
    m.loads = vec![pressure(1e-2)];
    let options = PathAnalysis { end_load: 1.0, switch_at: vec![1], max_steps: 5, ..Default::default() };
    m.analysis = Analysis::Path(options);
    let (_, outcome, record) = run(&m);
    assert!(record.events.iter().all(|event| !event.contains("arc-length")), "{:?}", record.events);
    assert_eq!(critical(&outcome)[0].kind, CriticalKind::Bifurcation);
    let [work, strain] = [outcome.state.work, outcome.balance.strain];
    assert!((work / strain - 1.0).abs() < 1e-5, "{work} {strain}");
}

/// A long ring buckles under a pressure that follows it at 3 EI/R³, where a pressure of constant direction would need 4 EI/R³ (S. P. Timoshenko, J. M.
/// Gere, *Theory of Elastic Stability*, 2nd ed. 1961, Sect. 7.3).
#[test]
fn a_ring_under_pressure_buckles_at_three_times_its_bending_stiffness() {
    let (radius, thickness) = (100.0, 0.5_f64);
    let mut m = arch(ElementKind::Ems, [radius, 90.0, thickness], 48);
    if let Some(Material::Isotropic(material)) = m.materials.values_mut().next() {
        material.poisson = 0.0;
    }
    m.conditions.push(symmetry("u_max", [0.0, 0.0, 1.0]));
    let exact = 3.0 * 3102.75 * thickness.powi(3) / 12.0 / radius.powi(3);
    m.loads = vec![pressure(1.2 * exact)];
    let (_, outcome, record) = run(&m);
    assert!(record.events.iter().all(|event| !event.contains("arc-length")), "{:?}", record.events);
    let found = critical(&outcome);
    assert!(found[0].kind == CriticalKind::Bifurcation, "{found:?}");
    let load = 1.2 * found[0].load;
    assert!((load - 1.0).abs() < 3e-3, "{load}");
}

/// Where an edge on which a pressure acts is free, or the pressure varies, it has no potential; pressures on nodes of bodies and beside prescribed motions
/// have no series either. The arc-length method follows these paths, and says why.
#[test]
fn pressures_without_potential_are_followed_by_arc_length() {
    let mut held = arch(ElementKind::Ems, [2540.0, 5.729_577_951_308_232, 12.7], 4);
    held.conditions.push(Condition::Hinge(on("u_max")));
    held.loads = vec![pressure(1e-3)];
    let mut free = held.clone();
    free.conditions
        .retain(|condition| !matches!(condition, Condition::Symmetry(plane) if plane.on == "v_max"));
    let mut varying = held.clone();
    varying.loads = vec![Load::Pressure(PressureLoad {
        on: "all".into(),
        value: 1e-3,
        amplitude: None,
        distribution: Some("1 + x / 254".into()),
    })];
    let mut driven = held.clone();
    driven.conditions.push(Condition::Prescribe(PrescribeComponent {
        on: "u_min".into(),
        of: NodalVector::Position,
        component: Axis::Z,
        value: -1.0,
        amplitude: None,
    }));
    for (m, reason) in [
        (free, "without a potential"),
        (varying, "without a potential"),
        (driven, "beside prescribed motions"),
    ] {
        let (_, outcome, record) = run(&m);
        assert!(record.events.iter().any(|event| event.contains(reason)), "{reason}: {:?}", record.events);
        let (_, other, _) = run(&by_arc_length(&m));
        assert_eq!(outcome.state.u, other.state.u);
    }
    assert!(run(&held).2.events.iter().all(|event| !event.contains("arc-length")));
}
