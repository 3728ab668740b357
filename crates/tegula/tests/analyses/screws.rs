//! Screws: closed solutions over several turns, frictionless reactions, statics, modes, refusals.

use std::f64::consts::TAU;

use crate::common::Notes;
use crate::modes_with_joints::{modal, omegas};
use crate::multibody::{between, body, gravity, machine, pose, run};
use tegula::analysis::{Silent, statics};
use tegula::model::*;
use tegula::result::joint_reaction;
use tegula::{Vec3, compile, mesh};

const AXIS: [f64; 3] = [1.0, 2.0, 2.0];
const MASS: f64 = 2.0;
const INERTIA: f64 = 0.1;
const PITCH: f64 = 0.5;

fn axis() -> Vec3 {
    Vec3::from(AXIS).normalize()
}

fn screw(pitch: f64) -> Joint {
    Joint::Screw(ScrewJoint {
        name: "thread".into(),
        between: between("ground", "nut"),
        at: [0.0; 3],
        axis: AXIS,
        pitch,
        second_at: None,
        second_axis: None,
    })
}

/// A nut on a screw under its weight along the axis.
fn nut(scheme: Scheme, end: f64, step: f64, pitch: f64) -> Model {
    let nut = body("nut", [0.0; 3], MASS, Some([INERTIA; 3]));
    let mut model = machine(end, step, vec![nut], vec![screw(pitch)]);
    let Analysis::Transient(options) = &mut model.analysis else { panic!() };
    options.scheme = scheme;
    Model { loads: gravity((axis() * 9.81).into()), ..model }
}

fn energy_momentum() -> Scheme {
    Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 })
}

/// Acceleration along the axis: the energy of the nut is `½ (m + I (2π/p)²) ż²`.
fn acceleration(pitch: f64) -> f64 {
    MASS * 9.81 / (MASS + INERTIA * (TAU / pitch).powi(2))
}

/// The nut falls with constant acceleration through more than four turns, left-handed threads as well: the error is that of the scheme.
#[test]
fn a_nut_falls_along_its_screw_with_constant_acceleration() {
    for pitch in [PITCH, -PITCH] {
        for scheme in
            [energy_momentum(), Scheme::GeneralizedAlpha(GeneralizedAlphaScheme { spectral_radius: 0.9 })]
        {
            let exact = 0.5 * acceleration(pitch) * 4.0;
            let error = |step: f64| {
                let mut notes = Notes::default();
                let (system, state) = run(&nut(scheme, 2.0, step, pitch), &mut notes);
                let (place, turned) = pose(&system, &state, 0);
                let z = place.dot(&axis());
                let [e1, e2] = [Vec3::new(2.0, -2.0, 1.0) / 3.0, Vec3::new(2.0, 1.0, -2.0) / 3.0];
                let hand = e1.cross(&e2).dot(&axis());
                let angle = (turned * e1).dot(&e2).atan2((turned * e1).dot(&e1)) * hand;
                let apart = angle - TAU * z / pitch;
                assert!((apart / TAU - (apart / TAU).round()).abs() < 1e-10, "{apart}");
                assert!((place - axis() * z).norm() < 1e-10 && z.abs() > 4.0 * PITCH);
                if matches!(scheme, Scheme::EnergyMomentum(_)) {
                    assert!(notes.drift() <= 1e-10 * notes.kinetic, "{} {}", notes.drift(), notes.kinetic);
                }
                (z - exact).abs()
            };
            let [coarse, fine] = [4e-3, 2e-3].map(error);
            assert!(
                fine < 1e-3 * exact && (3.5..4.5).contains(&(coarse / fine)),
                "{scheme:?}: {coarse} {fine}"
            );
        }
    }
}

/// In long steps, which turn the nut by up to 2 rad, the thread still does no work: energy stays, and so do force and moment of the thread, means
/// over a step. The scheme turns directors by `2 tan(Δφ/2)` times their middle, so that `F Δz + 2 M tan(Δφ/2) = 0`.
#[test]
fn a_thread_does_no_work_in_long_steps() {
    let mut notes = Notes::default();
    let (system, state) = run(&nut(energy_momentum(), 2.0, 0.08, PITCH), &mut notes);
    assert!(notes.drift() <= 1e-10 * notes.kinetic, "{} {}", notes.drift(), notes.kinetic);
    let (force, moment) = joint_reaction(&system, &state, &system.joints[0]);
    let [force, moment] = [force, moment].map(|x| x.dot(&axis()));
    let centre = system.coordinates.bodies[0].centre as usize;
    let way = 2.0 * (Vec3::from(state.u[centre]) - Vec3::from(state.middle[centre])).dot(&axis());
    let turned = TAU * way / PITCH;
    let work = [force * way, 2.0 * moment * (0.5 * turned).tan()];
    assert!(turned > 0.5 && work[0] < -1.0, "{turned} {work:?}");
    assert!((work[0] + work[1]).abs() < 1e-8 * work[0].abs(), "{turned} {work:?}");
}

/// A velocity without the rotation that belongs to it is changed to that with the same momentum along the motion, and reported.
#[test]
fn a_velocity_that_contradicts_the_pitch_is_reported() {
    let mut model = nut(energy_momentum(), 0.01, 1e-3, PITCH);
    model.loads.clear();
    model.bodies[0].velocity = axis().into();
    let mut notes = Notes::default();
    let (system, state) = run(&model, &mut notes);
    let told = notes.warnings.iter().any(|w| w.contains("did not keep the joints closed"));
    assert!(told, "{:?}", notes.warnings);
    let z = pose(&system, &state, 0).0.dot(&axis());
    let exact = 0.01 * acceleration(PITCH) / 9.81;
    assert!((z / exact - 1.0).abs() < 1e-4, "{z} {exact}");
}

/// A second screw between the same sides is redundant, and named.
#[test]
fn a_redundant_screw_is_named() {
    let mut model = nut(energy_momentum(), 0.01, 1e-3, PITCH);
    let Joint::Screw(keys) = screw(PITCH) else { panic!() };
    model.joints.push(Joint::Screw(ScrewJoint { name: "second".into(), ..keys }));
    let mut notes = Notes::default();
    run(&model, &mut notes);
    let named = |e: &String| {
        e.starts_with("joint \"second\": 5 of its constraints follow from those of other joints")
    };
    assert!(notes.events.iter().any(named), "{:?}", notes.events);
}

/// A torsion spring holds the nut after more than one turn: `m g = k (2π/p)² z`.
#[test]
fn a_torsion_spring_holds_the_nut_after_more_than_one_turn() {
    let mut model = nut(energy_momentum(), 1.0, 1e-3, PITCH);
    model.analysis = Analysis::Static(StaticAnalysis::default());
    let stiffness = MASS * 9.81 * PITCH / TAU / 9.0;
    model.torsion_springs = vec![TorsionSpring {
        name: "clock".into(),
        between: between("ground", "nut"),
        axis: AXIS,
        stiffness,
        damping: 0.0,
        moment: None,
        free_angle: 0.0,
    }];
    let mesh = mesh::generators::generate(&model.mesh).unwrap();
    let system = compile::build(&model, &mesh).unwrap();
    let state = statics::run(&system, &StaticAnalysis::default(), None, &mut Silent).unwrap().state;
    let z = pose(&system, &state, 0).0.dot(&axis());
    assert!((z / (9.0 * PITCH / TAU) - 1.0).abs() < 1e-8, "{z}");
}

/// On an axial spring the nut vibrates with `ω² = k/(m + I (2π/p)²)`.
#[test]
fn a_nut_on_a_spring_vibrates_with_its_inertia_of_rotation() {
    let mut model = nut(energy_momentum(), 1.0, 1e-3, PITCH);
    model.loads.clear();
    model.analysis = modal(1, false);
    let far: [f64; 3] = (axis() * 2.0).into();
    model.springs = vec![SpringDamper {
        across: None,
        name: "spring".into(),
        between: between("ground", "nut"),
        points: [far, [0.0; 3]],
        stiffness: 600.0,
        damping: 0.0,
        force: None,
        length: None,
    }];
    let exact = (600.0 * acceleration(PITCH) / (MASS * 9.81)).sqrt();
    let found = omegas(&model);
    assert!((found[0] / exact - 1.0).abs() < 1e-10, "{found:?} {exact}");
}

/// Screws without a pitch are refused.
#[test]
fn a_screw_without_pitch_is_refused() {
    for pitch in [0.0, f64::NAN, f64::INFINITY] {
        let model = nut(energy_momentum(), 1.0, 1e-3, pitch);
        let mesh = mesh::generators::generate(&model.mesh).unwrap();
        let message = compile::build(&model, &mesh).err().unwrap().to_string();
        assert!(message.contains("joints[0].pitch") && message.contains("\"thread\""), "{message}");
    }
}
