//! Tangents whose factors serve several time steps of a swinging shell, turned with it.

use crate::common::{Notes, Random, compile, distance, move_in_time, pendulum, quarter_cylinder, rotation};
use tegula::analysis::dynamics::{self, TransientOutcome};
use tegula::element::{Nodal, TangentWeights};
use tegula::model::*;
use tegula::norm::max_norm;
use tegula::system::assembly::TangentCoefficients;
use tegula::system::{Assembly, CorotationalUpdate, EvaluationPoint, VectorKind};
use tegula::{System, Vec3};

const NEWMARK: Scheme = Scheme::Newmark(NewmarkScheme { beta: 0.25, gamma: 0.5 });
const HHT: Scheme = Scheme::Hht(HhtScheme { alpha: -0.1 });
const ENERGY_MOMENTUM: Scheme = Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 });
const STEPS: u32 = 150;

fn options(scheme: Scheme) -> TransientAnalysis {
    let dt = 0.003;
    TransientAnalysis { scheme, time_step: Some(dt), ..TransientAnalysis::new(f64::from(STEPS) * dt) }
}

/// The run of a pendulum, with all its states.
fn swing(scheme: Scheme) -> (System, TransientOutcome, Notes) {
    let mut notes = Notes::keeping();
    let (system, outcome) = move_in_time(&pendulum(16), &options(scheme), &mut notes);
    (system, outcome, notes)
}

/// Largest angle (rad) by which a director has turned.
fn turned(system: &System, u: &[Nodal]) -> f64 {
    let directors = (0..system.vectors()).filter(|&v| system.coordinates.kinds[v] == VectorKind::Director);
    let angle = |v: usize| {
        let d = Vec3::from(system.coordinates.reference[v]);
        d.angle(&(d + Vec3::from(u[v])))
    };
    max_norm(directors.map(angle))
}

#[test]
#[ignore = "long"]
fn an_old_factor_serves_several_steps_of_a_pendulum() {
    for scheme in [NEWMARK, HHT, ENERGY_MOMENTUM] {
        let (system, lagged, notes) = swing(scheme);
        let angle = turned(&system, &lagged.state.u);
        let s = lagged.statistics;
        let longest = notes.states.iter().map(|s| s.tangent.steps).max().unwrap();
        println!("{scheme:?}: turned by {angle}, {s:?}, up to {longest} steps");
        assert!(angle > 1.0, "{scheme:?}: {angle}");
        assert!(s.factorizations < s.steps / 2 && s.cutbacks == 0, "{scheme:?}: {s:?}");
        assert!(longest > 3, "{scheme:?}: {longest}");

        // The same with tangents of its own for every step: as near as the schemes ask of the end of an iteration.
        let tolerance = if scheme == ENERGY_MOMENTUM { 1e-10 } else { 2e-6 };
        let mut start = notes.states[0].clone();
        start.tangent.pause = u32::MAX;
        let mut own = Notes::keeping();
        let outcome = dynamics::run(&system, &options(scheme), Some(start), &mut own).unwrap();
        assert!(own.states.iter().all(|s| !s.tangent.valid));
        assert!(outcome.statistics.factorizations >= outcome.statistics.steps, "{:?}", outcome.statistics);
        let nothing = vec![[0.0; 3]; system.vectors()];
        for (a, b) in notes.states[1..].iter().zip(&own.states) {
            assert_eq!(a.step, b.step);
            let off = distance(&a.u, &b.u) / distance(&a.u, &nothing);
            assert!(off < tolerance, "{scheme:?}: step {}: {off:e}", a.step);
        }
    }
}

#[test]
#[ignore = "long"]
fn a_run_resumed_with_an_old_tangent_is_the_run_itself() {
    for scheme in [NEWMARK, HHT, ENERGY_MOMENTUM] {
        let (system, straight, notes) = swing(scheme);
        let serves = |s: &&tegula::analysis::State| s.tangent.valid && s.tangent.steps > 1 && s.step > 20;
        let start = notes.states.iter().find(serves).unwrap().clone();
        let middle = start.step as usize;
        let mut rest = Notes::keeping();
        let continued = dynamics::run(&system, &options(scheme), Some(start), &mut rest).unwrap();
        assert_eq!(rest.iterations, notes.iterations[middle + 1..], "{scheme:?}");
        for (a, b) in notes.states[middle + 1..].iter().zip(&rest.states) {
            assert!(a == b, "{scheme:?}: step {} differs", a.step);
        }
        assert!(straight.state == continued.state && straight.balance == continued.balance);
    }
}

/// The coefficients of BDF2 depend on the ratio of two steps: a tangent of a step that was longer than the one before serves later ones of its
/// length with the coefficients of its own.
#[test]
#[ignore = "long"]
fn a_run_of_automatic_steps_of_two_step_formulas_resumes_as_itself_from_each_step() {
    let scheme = Scheme::Bdf2(Bdf2Scheme {});
    let options = TransientAnalysis { scheme, tolerance: 1e-6, ..TransientAnalysis::new(0.1) };
    let mut notes = Notes::keeping();
    let (system, straight) = move_in_time(&pendulum(16), &options, &mut notes);
    // The next step has the length for which the tangent was computed.
    let others = |s: &&tegula::analysis::State| s.tangent.valid && s.tangent.dt == s.next_step;
    let starts: Vec<_> = notes.states.iter().filter(others).cloned().collect();
    assert!(starts.len() > 3, "{}", starts.len());
    for start in starts {
        let (middle, mut rest) = (start.step as usize, Notes::keeping());
        let continued = dynamics::run(&system, &options, Some(start), &mut rest).unwrap();
        assert_eq!(rest.iterations, notes.iterations[middle + 1..], "from step {middle}");
        assert!(
            straight.state == continued.state && straight.balance == continued.balance,
            "from step {middle}"
        );
    }
}

/// A free shell, deformed a little, and the same turned by a finite rotation and shifted.
fn turned_shell(angle: f64) -> (System, nalgebra::Rotation3<f64>, [Vec<Nodal>; 2]) {
    let mut m = quarter_cylinder(3, 2.1e7);
    m.conditions.clear();
    m.analysis = Analysis::Transient(TransientAnalysis::new(1.0));
    let (_, system) = compile(&m);
    let q = rotation([1.0, -2.0, 0.5], angle);
    let (mut random, shift) = (Random::new(9), Vec3::new(3.0, -1.0, 2.0));
    let from: Vec<Nodal> = (0..system.vectors()).map(|_| (random.vector() * 1e-3).into()).collect();
    let place = |v: usize| {
        let x = Vec3::from(system.coordinates.reference[v]);
        let moved = if system.coordinates.kinds[v] == VectorKind::Position { shift } else { Vec3::zeros() };
        (q * (x + Vec3::from(from[v])) + moved - x).into()
    };
    let to = (0..system.vectors()).map(place).collect();
    (system, q, [from, to])
}

#[test]
fn the_rotations_of_a_turned_shell_are_its_rotation() {
    for angle in [0.1, 0.5, 1.0, 2.0, 3.0] {
        let (system, q, [from, to]) = turned_shell(angle);
        let mut turning = CorotationalUpdate::new(&system);
        turning.find(&system, &from, &to);
        let mut random = Random::new(10);
        let field: Vec<Nodal> = (0..system.vectors()).map(|_| random.vector().into()).collect();
        let mut out = field.clone();
        turning.turn(&system, false, &mut out);
        let off = |(x, y): (&Nodal, &Nodal)| {
            let x = Vec3::from(*x);
            (Vec3::from(*y) - q * x).norm() / x.norm()
        };
        let worst = max_norm(field.iter().zip(&out).map(off));
        assert!(worst < 2e-6, "turned by {angle}: {worst:e}");
        turning.turn(&system, true, &mut out);
        assert!(distance(&field, &out) < 1e-12);
    }
}

#[test]
fn the_tangent_of_a_turned_shell_is_the_turned_tangent() {
    let (system, _, [from, to]) = turned_shell(2.0);
    let mut turning = CorotationalUpdate::new(&system);
    turning.find(&system, &from, &to);
    let pattern = system.tangent_pattern();
    let product = |u: &[Nodal], x: &[Nodal]| {
        let mut assembly = Assembly::new(&system);
        let weights = TangentWeights::STATIC;
        let parts = TangentCoefficients { weights, mass: 0.0, time: 0.0 };
        let mut forces = vec![[0.0; 3]; system.vectors()];
        let k = EvaluationPoint::at_rest(&system, u, 0.0, &[]);
        assembly.forces_and_tangent(&system, &k, &parts, false, None, &mut forces);
        let (mut free, mut out) = (vec![0.0; system.unknowns()], vec![0.0; system.unknowns()]);
        system.frames.reduce(x, &mut free);
        pattern.add_product(&assembly.values, &free, &mut out);
        let mut all = vec![[0.0; 3]; system.vectors()];
        system.frames.expand(&out, &mut all);
        all
    };
    let mut random = Random::new(11);
    let x: Vec<Nodal> = (0..system.vectors()).map(|_| random.vector().into()).collect();
    let exact = product(&to, &x);
    let mut turned = x.clone();
    turning.turn(&system, true, &mut turned);
    let mut found = product(&from, &turned);
    turning.turn(&system, false, &mut found);
    let size = distance(&exact, &vec![[0.0; 3]; exact.len()]);
    // Neither the old tangent nor the one turned the other way would do.
    let off = distance(&exact, &found) / size;
    assert!(off < 1e-6, "{off:e}");
    assert!(distance(&exact, &product(&from, &x)) > 0.1 * size);
}

/// The equations of large steps have several solutions, most of them with wrinkles that have nothing to do with the
/// motion. There the steps would become many.
#[test]
fn old_factors_do_not_lead_large_steps_to_other_solutions() {
    let nothing = |system: &System| vec![[0.0; 3]; system.vectors()];
    for scheme in [NEWMARK, HHT] {
        let run = |tolerance: f64| {
            let options = TransientAnalysis { scheme, tolerance, ..TransientAnalysis::new(1.0) };
            move_in_time(&pendulum(8), &options, &mut Notes::default())
        };
        let (system, fine) = run(1e-5);
        let (_, coarse) = run(1e-3);
        let off = distance(&coarse.state.u, &fine.state.u) / distance(&fine.state.u, &nothing(&system));
        println!("{scheme:?}: {off}, {:?}", coarse.statistics);
        assert_eq!(coarse.statistics.cutbacks, 0, "{scheme:?}");
        assert!(coarse.statistics.steps < fine.statistics.steps / 4, "{scheme:?}: {:?}", coarse.statistics);
        assert!(off < 0.1, "{scheme:?}: {off}");
    }
}
