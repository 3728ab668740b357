//! The program knows no units: the same model in other consistent units, or with stiffness, mass and
//! loads scaled together, gives the same dimensionless results with the same iterations and steps.

use crate::common::{Notes, compile, on, quarter_cylinder, static_options, vector_load};
use tegula::analysis::{Silent, Statistics, dynamics, modal, statics};
use tegula::model::*;
use tegula::norm::max_norm;
use tegula::system::VectorKind;

/// Units of length, mass and time, as parts of metre, kilogram and second.
#[derive(Debug, Clone, Copy)]
struct Units {
    length: f64,
    mass: f64,
    time: f64,
}

impl Units {
    fn force(self) -> f64 {
        self.mass * self.length / self.time.powi(2)
    }
    fn stress(self) -> f64 {
        self.force() / self.length.powi(2)
    }
    fn acceleration(self) -> f64 {
        self.length / self.time.powi(2)
    }
    fn energy(self) -> f64 {
        self.force() * self.length
    }
}

const SYSTEMS: [Units; 5] = [
    Units { length: 1.0, mass: 1.0, time: 1.0 },
    // millimetre, tonne, second
    Units { length: 1e-3, mass: 1e3, time: 1.0 },
    // millimetre, kilogram, millisecond
    Units { length: 1e-3, mass: 1.0, time: 1e-3 },
    // E, ρ and loads times 1e9 and 1e-9
    Units { length: 1.0, mass: 1e-9, time: 1.0 },
    Units { length: 1.0, mass: 1e9, time: 1.0 },
];

/// The quarter cylinder of the paper in given units.
fn cylinder(n: u32, young: f64, density: f64, units: Units) -> Model {
    let mut m = quarter_cylinder(n, young);
    if let MeshSource::Cylinder(c) = &mut m.mesh {
        c.center = c.center.map(|x| x / units.length);
        c.radius /= units.length;
        c.length /= units.length;
    }
    m.sections[0].thickness /= units.length;
    m.materials.insert(
        "m".into(),
        Material::Isotropic(Isotropic::new(
            young / units.stress(),
            0.3,
            density / (units.mass / units.length.powi(3)),
        )),
    );
    m
}

/// Results that must not depend on units: dimensionless nodal vectors, energies in joule, counts.
struct Result {
    u: Vec<f64>,
    energies: Vec<f64>,
    counts: (Statistics, Vec<u32>),
}

fn dimensionless(kinds: &[VectorKind], u: &[[f64; 3]], units: Units) -> Vec<f64> {
    let scale = |k: VectorKind| if k == VectorKind::Position { units.length } else { 1.0 };
    kinds.iter().zip(u).flat_map(|(k, u)| u.map(|x| x * scale(*k))).collect()
}

fn compare(run: impl Fn(Units) -> Result) {
    let first = run(SYSTEMS[0]);
    let size = max_norm(&first.u);
    let energy = max_norm(&first.energies);
    assert!(size > 0.1 && energy > 0.01);
    for units in &SYSTEMS[1..] {
        let other = run(*units);
        assert_eq!(first.counts, other.counts, "{units:?}");
        for (a, b) in first.u.iter().zip(&other.u) {
            assert!((a - b).abs() < 1e-9 * size, "{units:?}: {a:e} became {b:e}");
        }
        for (a, b) in first.energies.iter().zip(&other.energies) {
            assert!((a - b).abs() < 1e-9 * energy, "{units:?}: energy {a:e} became {b:e}");
        }
    }
}

#[test]
fn statics_do_not_know_units() {
    compare(|units| {
        let mut m = cylinder(8, 2.1e8, 1.0, units);
        m.loads = vec![
            Load::Force(vector_load("u_max_v_max", [0.0, 0.0, -20.0 / units.force()])),
            Load::Pressure(PressureLoad {
                on: "all".into(),
                value: 3.0 / units.stress(),
                amplitude: None,
                distribution: None,
            }),
            Load::EdgeMoment(vector_load("u_max", [0.0, 0.5 / units.force(), 0.0])),
            Load::Edge(vector_load("v_min", [2.0 * units.length / units.force(), 0.0, 0.0])),
        ];
        let (_, system) = compile(&m);
        let mut notes = Notes::default();
        let outcome = statics::run(&system, &static_options(&m), None, &mut notes).unwrap();
        Result {
            u: dimensionless(&system.coordinates.kinds, &outcome.state.u, units),
            energies: vec![outcome.balance.strain * units.energy(), outcome.state.work * units.energy()],
            counts: (outcome.statistics, notes.iterations),
        }
    });
}

/// Thirty steps of the pendulum of Sect. 5.4 on 4 × 4, automatic steps.
fn pendulum(scheme: Scheme) {
    compare(|units| {
        let mut m = cylinder(4, 2.1e7, 318.3, units);
        m.conditions = vec![Condition::Spherical(on("u_min_v_min"))];
        m.damping = Damping { mass: 0.1 * units.time, stiffness: 1e-4 / units.time };
        let g = [0.0, 0.0, -9.81 / units.acceleration()];
        m.loads = vec![Load::Gravity(GravityLoad { value: g, amplitude: None })];
        let options = TransientAnalysis {
            end_time: 0.25 / units.time,
            scheme,
            tolerance: 2e-5,
            time_step: None,
            initial_step: None,
            max_step: None,
            max_iterations: 20,
            linear: false,
            stop: Vec::new(),
        };
        m.analysis = Analysis::Transient(options.clone());
        let (_, system) = compile(&m);
        let mut notes = Notes::default();
        let outcome = dynamics::run(&system, &options, None, &mut notes).unwrap();
        assert!(outcome.statistics.steps >= 20, "{:?}", outcome.statistics);
        let b = outcome.balance;
        Result {
            u: dimensionless(&system.coordinates.kinds, &outcome.state.u, units),
            energies: [b.kinetic, b.strain, b.potential, b.dissipated, b.total]
                .map(|e| e * units.energy())
                .to_vec(),
            counts: (outcome.statistics, notes.iterations),
        }
    });
}

#[test]
fn newmark_does_not_know_units() {
    pendulum(Scheme::default());
}

#[test]
fn hht_does_not_know_units() {
    pendulum(Scheme::Hht(HhtScheme { alpha: -0.1 }));
}

#[test]
fn energy_momentum_does_not_know_units() {
    pendulum(Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 }));
}

#[test]
fn modes_do_not_know_units() {
    let frequencies = |units: Units| {
        let mut m = cylinder(6, 2.1e7, 318.3, units);
        m.conditions.clear();
        m.analysis = Analysis::Modal(ModalAnalysis::new(12));
        let outcome = modal::run(&compile(&m).1, 12, None, &mut Silent).unwrap();
        assert!(outcome.sturm_checked);
        outcome.modes.iter().map(|m| (m.rigid, m.omega / units.time)).collect::<Vec<_>>()
    };
    let first = frequencies(SYSTEMS[0]);
    assert_eq!(first.iter().filter(|m| m.0).count(), 6);
    for units in &SYSTEMS[1..] {
        for (a, b) in first.iter().zip(&frequencies(*units)) {
            assert!(a.0 == b.0 && (a.1 - b.1).abs() < 1e-9 * first[11].1, "{units:?}: {a:?} became {b:?}");
        }
    }
}
