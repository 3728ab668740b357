//! Beams: rigid motions, conservation, and closed solutions of beam theory. The machines with beams of the verification
//! compare with other programs.

use crate::common::Notes;
use tegula::analysis::{Observer, State, dynamics};
use tegula::model::*;
use tegula::result::beams::beam_resultants;
use tegula::result::joint_reaction;
use tegula::{System, Vec3, compile, mesh};

const STEEL: Isotropic =
    Isotropic { young: 2.1e11, poisson: 0.3, density: 7800.0, expansion: 0.0, strength: None };

fn model(end: f64, step: Option<f64>, beams: Vec<Beam>, joints: Vec<Joint>) -> Model {
    let scheme = Scheme::EnergyMomentum(EnergyMomentumScheme {});
    let analysis = TransientAnalysis { scheme, time_step: step, ..TransientAnalysis::new(end) };
    let mut model = Model::of_bodies(Analysis::Transient(analysis), Vec::new(), joints);
    model.materials.insert("steel".into(), Material::Isotropic(STEEL));
    Model { beams, ..model }
}

fn run(model: &Model, observer: &mut dyn Observer) -> (System, State) {
    let mesh = mesh::generators::generate(&model.mesh).unwrap();
    let system = compile::build(model, &mesh).unwrap();
    let Analysis::Transient(options) = &model.analysis else { panic!() };
    let outcome = dynamics::run(&system, options, None, observer).unwrap();
    (system, outcome.state)
}

fn rectangle(size: [f64; 2]) -> BeamSection {
    BeamSection::Rectangle(RectangularSection { size })
}

/// A quarter of a circle of radius 1 in the plane x-y, twisted by 60°.
fn curved(elements: usize) -> Beam {
    let at = |i: usize| {
        let angle = std::f64::consts::FRAC_PI_2 * i as f64 / elements as f64;
        [angle.cos(), angle.sin(), 0.0]
    };
    Beam {
        points: (0..=elements).map(at).collect(),
        elements: None,
        twist: 60.0,
        material: Some("steel".into()),
        ..Beam::straight("arc", [[0.0; 3]; 2], 1, [0.0, 0.0, 1.0], rectangle([0.05, 0.02]))
    }
}

fn place(system: &System, state: &State, body: &str) -> Vec3 {
    let body = system.coordinates.bodies.iter().find(|b| b.name == body).unwrap();
    Vec3::from(system.coordinates.reference[body.centre as usize]) + Vec3::from(state.u[body.centre as usize])
}

fn fixed(name: &str, a: &str, b: &str, at: [f64; 3]) -> Joint {
    Joint::Fixed(PointJoint { name: name.into(), between: [a.into(), b.into()], at })
}

#[test]
fn a_curved_twisted_beam_that_translates_and_turns_slowly_has_no_resultants() {
    let beam = Beam { velocity: [3.0, -1.0, 2.0], ..curved(6) };
    let (system, state) = run(&model(1.0, Some(0.1), vec![beam], Vec::new()), &mut Notes::default());
    let line = &system.beams[0];
    let largest =
        beam_resultants(&system, &state, line).concat().into_iter().map(f64::abs).fold(0.0, f64::max);
    // EA = 2.1e8.
    assert!(largest < 1e-6, "{largest}");
    let moved = place(&system, &state, "arc.end") - Vec3::new(0.0, 1.0, 0.0);
    assert!((moved - Vec3::new(3.0, -1.0, 2.0)).norm() < 1e-12, "{moved}");
}

#[test]
fn a_free_curved_twisted_beam_keeps_energy_and_momenta() {
    let beam = Beam { angular_velocity: [20.0, -30.0, 40.0], velocity: [1.0, 0.0, 2.0], ..curved(6) };
    let mut notes = Notes::default();
    run(&model(0.05, Some(2e-4), vec![beam], Vec::new()), &mut notes);
    assert!(
        notes.kinetic > 1.0 && notes.drift() <= 1e-10 * notes.kinetic,
        "{}",
        notes.drift() / notes.kinetic
    );
    let (linear, angular) = notes.momenta[0];
    for (p, l) in &notes.momenta {
        assert!((p - linear).norm() <= 1e-9 * linear.norm(), "{p}");
        assert!((l - angular).norm() <= 1e-9 * angular.norm(), "{l}");
    }
}

/// A clamped beam under a suddenly applied small force vibrates about the static deflection, which the mean over whole periods
/// of the first mode shows: F L³/(3 EI) + F L/(kGA). Period 2π/(3.516 √(EI/(ρA L⁴))) of Euler and Bernoulli less the part of
/// shear and rotary inertia.
#[test]
fn a_clamped_beam_vibrates_about_the_deflection_of_timoshenko_with_the_period_of_its_first_mode() {
    let (length, size) = (2.0, [0.05, 0.1]);
    let beam = Beam {
        material: Some("steel".into()),
        ..Beam::straight("beam", [[0.0; 3], [length, 0.0, 0.0]], 16, [0.0, 1.0, 0.0], rectangle(size))
    };
    // Axis 1 is y, axis 2 is z: a force along z bends about axis 1.
    let (area, moment) = (size[0] * size[1], size[0] * size[1].powi(3) / 12.0);
    let (bending, shear) = (STEEL.young * moment, 5.0 / 6.0 * STEEL.young / 2.6 * area);
    let period =
        std::f64::consts::TAU / (3.516015 * (bending / (STEEL.density * area * length.powi(4))).sqrt());
    let force = 1.0;
    let mut model = model(
        3.0 * period,
        Some(period / 400.0),
        vec![beam],
        vec![fixed("clamp", "ground", "beam.start", [0.0; 3])],
    );
    let value = [0.0, 0.0, force];
    model.loads = vec![Load::Force(VectorLoad::new("beam.end", value))];
    let mut notes = Notes { keep: true, ..Notes::default() };
    let (system, state) = run(&model, &mut notes);
    let tip: Vec<(f64, f64)> =
        notes.states.iter().map(|state| (state.time, place(&system, state, "beam.end").z)).collect();
    let mean: f64 = tip.iter().skip(1).map(|(_, z)| z).sum::<f64>() / (tip.len() - 1) as f64;
    let expected = force * (length.powi(3) / (3.0 * bending) + length / shear);
    assert!((mean - expected).abs() < 0.01 * expected, "{mean} {expected}");
    // Returns to zero after whole periods: the last minimum.
    let last = tip.iter().filter(|(t, _)| *t > 2.5 * period).min_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
    assert!((last.0 / (3.0 * period) - 1.0).abs() < 0.02, "{} {period}", last.0 / period);
    let (reaction, _) = joint_reaction(&system, &state, &system.joints[0]);
    assert!(reaction.norm().is_finite());
}
