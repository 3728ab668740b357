//! Elastic foundations: Hetényi's beam, frequencies, damping, conservation of energy, refusals.

use crate::common::{Notes, move_in_time, plate};
use tegula::analysis::modal;
use tegula::analysis::{Silent, statics};
use tegula::model::*;
use tegula::norm::larger;
use tegula::{Error, compile, mesh};

fn area(normal: f64) -> Foundation {
    let stiffness = [0.0; 3];
    Foundation::Area(AreaFoundation { on: "all".into(), stiffness, normal, retardation_time: 0.0 })
}

/// A strip along x without Poisson's effect, of length 2 and width 0.1, without supports.
fn strip(elements: [u32; 2]) -> Model {
    let analysis = Analysis::Static(StaticAnalysis { linear: true, ..StaticAnalysis::default() });
    let mut m =
        Model::new(plate([2.0, 0.1], elements, 0.0), analysis, Isotropic::new(2.1e9, 0.0, 800.0), 0.02);
    m.sections[0].element = ElementKind::Mitc4;
    m
}

/// A free beam on a foundation with a force in its middle sinks there by `(P β/2k) (cosh λ + cos λ + 2)/(sinh λ + sin λ)`,
/// β = (k/4EI)^¼, λ = βL (M. Hetényi, *Beams on elastic foundation*, 1946).
#[test]
fn a_beam_with_free_ends_sinks_as_hetenyi_says() {
    let (k, width, force) = (2e5, 0.1, 100.0);
    let deflection = |foundation: Foundation| {
        let mut m = strip([200, 2]);
        m.foundations = vec![foundation];
        // In the plane nothing else holds the strip.
        m.foundations.push(Foundation::Point(FoundationOn {
            on: "u_min".into(),
            stiffness: [1e3, 1e3, 0.0],
            retardation_time: 0.0,
        }));
        let mut mesh = mesh::generators::generate(&m.mesh).unwrap();
        let middle: Vec<u32> = (0..mesh.positions.len() as u32)
            .filter(|&n| (mesh.positions[n as usize].x - 1.0).abs() < 1e-9)
            .collect();
        mesh.node_sets.insert("middle".into(), middle.clone());
        let value = [0.0, 0.0, -force / middle.len() as f64];
        m.loads =
            vec![Load::Force(VectorLoad { on: "middle".into(), value, amplitude: None, distribution: None })];
        let system = compile::build(&m, &mesh).unwrap();
        let Analysis::Static(options) = &m.analysis else { panic!() };
        let state = statics::run(&system, options, None, &mut Silent).unwrap().state;
        -state.u[system.coordinates.position_of[middle[1] as usize] as usize][2]
    };
    let bending = 2.1e9 * width * 0.02_f64.powi(3) / 12.0;
    let beta = (k * width / (4.0 * bending)).powf(0.25);
    let lambda = beta * 2.0;
    let expected = force * beta / (2.0 * k * width) * (lambda.cosh() + lambda.cos() + 2.0)
        / (lambda.sinh() + lambda.sin());
    let along_z =
        AreaFoundation { on: "all".into(), stiffness: [0.0, 0.0, k], normal: 0.0, retardation_time: 0.0 };
    for foundation in [area(k), Foundation::Area(along_z)] {
        let found = deflection(foundation);
        // The shear of the strip adds some thousandths.
        assert!((found / expected - 1.0).abs() < 5e-3, "{found} {expected}");
    }
}

/// On a foundation along the normals a free plate keeps the three rigid motions in its plane; its heave has ω² = k/ρh, and the
/// squares of its bending frequencies grow by as much, but for rotary inertia.
#[test]
fn a_free_plate_on_a_foundation_vibrates_faster_by_k_over_m() {
    let omegas = |foundations: Vec<Foundation>| {
        let mesh = plate([1.0, 1.0], [8, 8], 0.0);
        let analysis = Analysis::Modal(ModalAnalysis::new(9));
        let mut m = Model::new(mesh, analysis, Isotropic::new(2.1e9, 0.3, 1000.0), 0.01);
        m.foundations = foundations;
        let system = compile::build(&m, &mesh::generators::generate(&m.mesh).unwrap()).unwrap();
        let found = modal::run(&system, 9, None, &mut Silent).unwrap();
        assert!(found.sturm_checked);
        found.modes.iter().map(|mode| mode.omega).collect::<Vec<_>>()
    };
    let (free, held) = (omegas(Vec::new()), omegas(vec![area(4e3)]));
    assert!(free[..6].iter().chain(&held[..3]).all(|omega| *omega == 0.0), "{free:?} {held:?}");
    // k/ρh = 400; heave exactly, roll and pitch but for rotary inertia h²/L².
    for omega in &held[3..6] {
        assert!((omega / 20.0 - 1.0).abs() < 1e-4, "{held:?}");
    }
    assert!(held[3..6].iter().any(|omega| (omega / 20.0 - 1.0).abs() < 1e-9), "{held:?}");
    for (free, held) in free[6..].iter().zip(&held[6..]) {
        assert!((held * held / (free * free + 400.0) - 1.0).abs() < 1e-3, "{free} {held}");
    }
}

/// A stiff plate that falls on its foundation from rest oscillates as a mass on a spring, and loses its energy to the damper.
#[test]
fn a_heavy_plate_on_a_damped_foundation_follows_its_closed_form() {
    for (scheme, tolerance) in [
        (Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 }), 2e-4),
        (Scheme::GeneralizedAlpha(GeneralizedAlphaScheme { spectral_radius: 0.8 }), 5e-4),
        (Scheme::Newmark(NewmarkScheme::default()), 2e-4),
    ] {
        for retardation_time in [0.0, 0.01] {
            let mut m = Model::new(
                plate([0.4, 0.4], [2, 2], 0.0),
                Analysis::Static(StaticAnalysis::default()),
                Isotropic::new(2.1e11, 0.3, 1000.0),
                0.05,
            );
            let stiffness = [0.0, 0.0, 2e4];
            m.foundations = vec![Foundation::Area(AreaFoundation {
                on: "all".into(),
                stiffness,
                normal: 0.0,
                retardation_time,
            })];
            m.loads = vec![Load::Gravity(GravityLoad { value: [0.0, 0.0, -9.81], amplitude: None })];
            let options = TransientAnalysis { scheme, time_step: Some(1e-3), ..TransientAnalysis::new(0.5) };
            m.analysis = Analysis::Transient(options.clone());
            let mut notes = Notes::default();
            let (system, outcome) = move_in_time(&m, &options, &mut notes);
            // m = 50, k = 2e4 per area: ω² = 400, 2ζω = 400 τ.
            let (omega, decay) = (20.0_f64, 200.0 * retardation_time);
            let damped = (omega * omega - decay * decay).sqrt();
            let sunk = 9.81 / 400.0;
            let t = 0.5;
            let swing = (damped * t).cos() + decay / damped * (damped * t).sin();
            let expected = sunk * ((-decay * t).exp() * swing - 1.0);
            let positions = system.coordinates.position_of.iter();
            let worst =
                positions.map(|&v| (outcome.state.u[v as usize][2] - expected).abs()).fold(0.0, larger);
            assert!(worst < tolerance, "{scheme:?} {retardation_time}: {worst} {expected}");
            if matches!(scheme, Scheme::EnergyMomentum(_)) {
                assert!(notes.drift() <= 1e-9 * notes.kinetic, "{} {}", notes.drift(), notes.kinetic);
            }
        }
    }
}

/// A foundation along the normals leaves the motions in the plane free.
#[test]
fn static_analyses_are_refused_where_the_foundation_leaves_motions_free() {
    let mut m = strip([10, 2]);
    m.foundations = vec![area(1e5)];
    m.loads = vec![Load::Pressure(PressureLoad {
        on: "all".into(),
        value: 10.0,
        amplitude: None,
        distribution: None,
    })];
    let mesh = mesh::generators::generate(&m.mesh).unwrap();
    for (linear, density) in [(true, 800.0), (false, 800.0), (true, 0.0), (false, 0.0)] {
        m.analysis = Analysis::Static(StaticAnalysis { linear, ..StaticAnalysis::default() });
        m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(2.1e9, 0.0, density)));
        let Err(Error::Model(issues)) = compile::build(&m, &mesh) else { panic!("it is taken") };
        assert!(issues[0].place.key == "foundations" && issues[0].message.contains("3 rigid"), "{issues:?}");
    }
}

/// A stiffness in the plane that is small beside that across it holds the plate all the same.
#[test]
fn a_weak_foundation_in_the_plane_holds_a_plate_in_it() {
    let mut m = strip([10, 2]);
    let on = "all".to_owned();
    let stiffness = [40.0, 40.0, 2e9];
    m.foundations =
        vec![Foundation::Area(AreaFoundation { on, stiffness, normal: 0.0, retardation_time: 0.0 })];
    m.analysis = Analysis::Modal(ModalAnalysis::new(3));
    let system = compile::build(&m, &mesh::generators::generate(&m.mesh).unwrap()).unwrap();
    let found = modal::run(&system, 3, None, &mut Silent).unwrap();
    // k/ρh = 40/16, for both translations, and for the rotation in the plane.
    for mode in &found.modes {
        assert!((mode.omega / 2.5_f64.sqrt() - 1.0).abs() < 1e-4, "{}", mode.omega);
    }
    m.analysis = Analysis::Static(StaticAnalysis { linear: true, ..StaticAnalysis::default() });
    m.loads = vec![Load::Traction(VectorLoad {
        on: "all".into(),
        value: [10.0, 0.0, 0.0],
        amplitude: None,
        distribution: None,
    })];
    compile::build(&m, &mesh::generators::generate(&m.mesh).unwrap()).unwrap();
}

#[test]
fn foundations_without_stiffness_or_set_are_refused_by_name() {
    let refused = |foundation: Foundation, key: &str, word: &str| {
        let mut m = strip([4, 2]);
        m.foundations = vec![foundation];
        let mesh = mesh::generators::generate(&m.mesh).unwrap();
        let Err(Error::Model(issues)) = compile::build(&m, &mesh) else { panic!("{key} is taken") };
        assert!(issues.iter().any(|i| i.place.key == key && i.message.contains(word)), "{issues:?}");
    };
    refused(area(0.0), "foundations[0].stiffness", "nothing");
    refused(area(-1.0), "foundations[0].normal", "negative");
    let on = |set: &str| FoundationOn { on: set.into(), stiffness: [1.0; 3], retardation_time: 0.0 };
    refused(Foundation::Edge(on("no")), "foundations[0].on", "no");
    refused(
        Foundation::Point(FoundationOn { retardation_time: -1.0, ..on("u_min") }),
        "foundations[0].retardation_time",
        "negative",
    );
}

/// The iterative solver takes foundations, also where subdomains meet on them.
#[test]
fn the_iterative_solver_agrees_with_the_direct_one_on_a_foundation() {
    let deflections = |linear_solver| {
        let mut m = strip([40, 40]);
        m.mesh = plate([1.0, 1.0], [40, 40], 0.2);
        let stiffness = [1e3, 1e3, 1e5];
        let on = "all".to_owned();
        m.foundations =
            vec![Foundation::Area(AreaFoundation { on, stiffness, normal: 0.0, retardation_time: 0.0 })];
        m.loads = vec![Load::Force(VectorLoad {
            on: "u_max".into(),
            value: [0.0, 1.0, -3.0],
            amplitude: None,
            distribution: None,
        })];
        let options = StaticAnalysis { linear_solver, ..StaticAnalysis::default() };
        m.analysis = Analysis::Static(options.clone());
        let system = compile::build(&m, &mesh::generators::generate(&m.mesh).unwrap()).unwrap();
        statics::run(&system, &options, None, &mut Silent).unwrap().state.u
    };
    let (direct, iterative) = (deflections(LinearSolver::Direct), deflections(LinearSolver::Iterative));
    let largest = direct.iter().flatten().map(|u| u.abs()).fold(0.0, larger);
    let apart =
        direct.iter().flatten().zip(iterative.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, larger);
    assert!(apart < 1e-8 * largest, "{apart} {largest}");
}

/// Explicit steps stay stable: their bound knows the foundation, also where it alone limits the step.
#[test]
fn explicit_steps_are_short_enough_for_a_stiff_foundation() {
    for stiffness in [1e6, 1e12] {
        let mut m = Model::new(
            plate([0.4, 0.4], [2, 2], 0.0),
            Analysis::Static(StaticAnalysis::default()),
            Isotropic::new(2.1e9, 0.3, 1000.0),
            0.05,
        );
        let on = FoundationOn { on: "all".into(), stiffness: [stiffness; 3], retardation_time: 0.0 };
        m.foundations = vec![Foundation::Point(on)];
        m.loads = vec![Load::Gravity(GravityLoad { value: [0.0, 0.0, -9.81], amplitude: None })];
        let scheme = Scheme::Explicit(ExplicitScheme::default());
        let options = TransientAnalysis { scheme, ..TransientAnalysis::new(2e-3) };
        m.analysis = Analysis::Transient(options.clone());
        let mut notes = Notes::default();
        let (system, outcome) = move_in_time(&m, &options, &mut notes);
        // Under a load applied at once a spring sinks to twice its static displacement; nodes share the mass unequally.
        let sunk = 8.0 * 9.81 / (9.0 * stiffness);
        let positions = system.coordinates.position_of.iter();
        let largest = positions.map(|&v| outcome.state.u[v as usize][2].abs()).fold(0.0, larger);
        assert!(largest > 0.1 * sunk && largest < 4.0 * sunk, "{stiffness}: {largest} {sunk}");
    }
}
