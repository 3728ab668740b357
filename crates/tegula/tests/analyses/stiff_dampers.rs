//! Dampers much stiffer than the mass over the step: their forces, and the energies of schemes whose velocities do not follow.

use crate::bushings::{bushing, rows};
use crate::common::{Notes, vector_load};
use crate::generalized_alpha::with_scheme;
use crate::multibody::{between, body, machine, revolute, run};
use nalgebra::Matrix6;
use tegula::model::*;
use tegula::norm::larger;
use tegula::result::bodies::{bushing_responses, spring_lengths_and_forces, torsion_angles_and_moments};

const ENERGY_MOMENTUM: Scheme = Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 });

/// A point mass that a force of 1 pulls against a damper to the ground.
fn dashpot(damping: f64) -> Model {
    let mut model = machine(1.0, 0.01, vec![body("mass", [0.0; 3], 1.0, None)], Vec::new());
    model.springs = vec![SpringDamper {
        across: None,
        name: "dashpot".into(),
        between: between("ground", "mass"),
        points: [[-1.0, 0.0, 0.0], [0.0; 3]],
        stiffness: 0.0,
        damping,
        length: None,
        force: None,
    }];
    model.loads = vec![Load::Force(vector_load("mass", [1.0, 0.0, 0.0]))];
    model
}

/// Wheel on a hinge, with torsional dampers of a torsion spring and of a bushing that share a moment of 1.
fn wheel(damping: f64) -> Model {
    let hinge = revolute("hinge", "ground", "wheel", [0.0; 3], [0.0, 0.0, 1.0]);
    let wheel = body("wheel", [0.0; 3], 2.0, Some([0.5, 0.5, 1.0]));
    let mut model = machine(1.0, 0.01, vec![wheel], vec![hinge]);
    model.torsion_springs = vec![TorsionSpring {
        name: "clock".into(),
        between: between("ground", "wheel"),
        axis: [0.0, 0.0, 1.0],
        stiffness: 0.0,
        damping: 0.25 * damping,
        moment: None,
        free_angle: 0.0,
    }];
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mut matrix = Matrix6::zeros();
    matrix[(5, 5)] = 0.75 * damping;
    model.bushings =
        vec![Bushing { damping_matrix: rows(&matrix), axes, ..bushing(["ground", "wheel"], [0.0; 3]) }];
    model.loads = vec![Load::Moment(vector_load("wheel", [0.0, 0.0, 1.0]))];
    model
}

/// The damper takes the load but for a part m/(d Δt) of it, while the velocity alternates between nothing and twice its mean.
#[test]
fn forces_of_stiff_dampers_are_means_over_the_step() {
    for damping in [1e4, 1e6, 1e8] {
        let limit = 3.0 / (damping * 0.01);
        let mut notes = Notes::keeping();
        let (system, _) = run(&with_scheme(&dashpot(damping), ENERGY_MOMENTUM, 1.0, 0.01), &mut notes);
        for state in &notes.states[1..] {
            let [_, force] = spring_lengths_and_forces(&system, state)[0];
            assert!((force - 1.0).abs() < limit, "{damping} {}: {force}", state.time);
        }
        let mut notes = Notes::keeping();
        let (system, _) = run(&with_scheme(&wheel(damping), ENERGY_MOMENTUM, 1.0, 0.01), &mut notes);
        for state in &notes.states[1..] {
            let [_, moment] = torsion_angles_and_moments(&system, state)[0];
            let of_bushing = bushing_responses(&system, state)[0].moment.z;
            assert!((moment - 0.25).abs() < limit, "{damping} {}: {moment}", state.time);
            assert!((of_bushing - 0.75).abs() < limit, "{damping} {}: {of_bushing}", state.time);
        }
    }
}

/// A damper of ten times the critical one over the step and more: what it dissipates is the work of the load, to the error of the
/// displacements, which the scheme knows in the first steps to a part of Δt² only.
#[test]
fn stiff_dampers_dissipate_the_work_of_loads_in_schemes_with_numerical_damping() {
    let generalized = Scheme::GeneralizedAlpha(GeneralizedAlphaScheme { spectral_radius: 0.8 });
    for scheme in [generalized, Scheme::Hht(HhtScheme { alpha: -0.05 })] {
        for (damping, limit) in [(1e2, 1e-3), (1e4, 2e-3), (1e6, 0.1)] {
            for model in [dashpot(damping), wheel(damping)] {
                let (system, state) = run(&with_scheme(&model, scheme, 1.0, 0.01), &mut Notes::default());
                let kinetic = system.kinetic_energy(&state.v);
                let missing = (state.work - state.dissipated - kinetic).abs();
                assert!(
                    missing < limit * larger(state.work, state.dissipated),
                    "{scheme:?} {damping}: {state:?}"
                );
            }
        }
    }
}

/// The error of the energy, which remains from the first steps, is told as a part of the energy that the load has supplied.
#[test]
fn a_gain_of_energy_beside_a_stiff_damper_is_told_as_a_part_of_the_work() {
    let generalized = Scheme::GeneralizedAlpha(GeneralizedAlphaScheme { spectral_radius: 0.8 });
    let mut notes = Notes::default();
    run(&with_scheme(&dashpot(1e6), generalized, 1.0, 0.01), &mut notes);
    assert!(
        notes.warnings.iter().any(|text| text.contains("gained 8 % of its largest energy")),
        "{:?}",
        notes.warnings
    );
    let mut notes = Notes::default();
    run(&with_scheme(&dashpot(1e4), generalized, 1.0, 0.01), &mut notes);
    assert!(notes.warnings.is_empty(), "{:?}", notes.warnings);
}

/// A mass on a damper moves by F t/d − F m/d² at last. What a sudden load adds in the first steps stays, and is told where it matters, also where the
/// energy of the motion falls.
#[test]
fn displacements_that_do_not_follow_velocities_beside_dampers_are_told() {
    for (radius, damping, is_wrong) in
        [(0.8, 1e4, false), (0.8, 1e5, true), (0.0, 1e2, false), (0.0, 1e3, true)]
    {
        let scheme = Scheme::GeneralizedAlpha(GeneralizedAlphaScheme { spectral_radius: radius });
        for model in [dashpot(damping), wheel(damping)] {
            let mut notes = Notes::default();
            let (system, state) = run(&with_scheme(&model, scheme, 1.0, 0.01), &mut notes);
            let case = format!("{radius} {damping} {:?}", notes.warnings);
            assert_eq!(
                notes.warnings.iter().any(|text| text.contains("do not follow the velocities")),
                is_wrong,
                "{case}"
            );
            if !model.springs.is_empty() {
                let [length, _] = spring_lengths_and_forces(&system, &state)[0];
                let exact = 1.0 / damping - 1.0 / damping.powi(2);
                let error = ((length - 1.0) / exact - 1.0).abs();
                assert!(if is_wrong { error > 0.03 } else { error < 0.01 }, "{case}: {error}");
            }
        }
    }
}

/// A load that jumps on the way, and material that creeps slowly, make displacements miss the velocities, too; with a load that grows from 0 they follow.
#[test]
fn displacements_beside_dampers_are_watched_in_all_steps_and_materials() {
    let generalized = Scheme::GeneralizedAlpha(GeneralizedAlphaScheme { spectral_radius: 0.5 });
    let told = |m: &Model| {
        let mut notes = Notes::default();
        run(&with_scheme(m, generalized, 1.0, 0.01), &mut notes);
        notes.warnings.iter().filter(|text| text.contains("do not follow the velocities")).count()
    };
    let following = |amplitude: Amplitude| {
        let mut m = dashpot(1e6);
        m.amplitudes.insert("a".into(), amplitude);
        let mut load = vector_load("mass", [1.0, 0.0, 0.0]);
        load.amplitude = Some("a".into());
        m.loads = vec![Load::Force(load)];
        m
    };
    let table = |times: Vec<f64>, values: Vec<f64>| Amplitude::Table(TableAmplitude { times, values });
    assert_eq!(told(&following(table(vec![0.0, 0.5, 0.500_000_1, 1.0], vec![0.0, 0.0, 1.0, 1.0]))), 1);
    assert_eq!(told(&following(table(vec![0.0, 1.0], vec![0.0, 1.0]))), 0);
    for (retardation_time, times) in [(10.0, 1), (1e-3, 0)] {
        let mut m = crate::common::model(crate::common::plate([1.0, 0.1], [4, 1], 0.0), 1e9, 0.01);
        m.sections[0].retardation_time = retardation_time;
        m.sections[0].element = ElementKind::Mitc4;
        let fix = FixComponents { on: "all".into(), position: vec![Axis::Y, Axis::Z], director: Vec::new() };
        m.conditions = vec![Condition::Clamp(crate::common::on("u_min")), Condition::Fix(fix)];
        m.loads = vec![Load::Edge(vector_load("u_max", [1000.0, 0.0, 0.0]))];
        assert_eq!(told(&m), times, "{retardation_time}");
    }
}
