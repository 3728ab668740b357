//! Time integration: order of accuracy, conservation, energy balance, restart.

use crate::common::{
    Notes, compile, distance, driven_edge, model, move_in_time as run, pendulum, plate, quarter_cylinder,
    vector_load,
};
use tegula::analysis::dynamics;
use tegula::element::Motion;
use tegula::model::*;
use tegula::norm::max_norm;
use tegula::system::{Assembly, dot};

const NEWMARK: Scheme = Scheme::Newmark(NewmarkScheme { beta: 0.25, gamma: 0.5 });
const HHT: Scheme = Scheme::Hht(HhtScheme { alpha: -0.1 });
const ENERGY_MOMENTUM: Scheme = Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 });

fn options(scheme: Scheme, end_time: f64, time_step: Option<f64>) -> TransientAnalysis {
    TransientAnalysis {
        end_time,
        scheme,
        tolerance: 1e-4,
        time_step,
        initial_step: None,
        max_step: None,
        max_iterations: 20,
        linear: false,
        stop: Vec::new(),
    }
}

/// A soft, thick, clamped plate of 2 × 2 elements whose fastest vibration (that of its thickness)
/// takes 0.1 s: a few milliseconds resolve all of its motion.
fn soft_plate() -> Model {
    let mut m = model(plate([1.0, 1.0], [2, 2], 0.2), 1e5, 0.5);
    m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(1e5, 0.3, 1e3)));
    m.loads = vec![Load::Gravity(GravityLoad { value: [2.0, 1.0, -9.81], amplitude: None })];
    m
}

fn moving(mut m: Model) -> Model {
    m.initial_velocities = vec![InitialVelocity {
        on: "all".into(),
        velocity: [0.0; 3],
        angular_velocity: [0.3, 2.0, 0.0],
        center: [0.0; 3],
    }];
    m
}

/// The very first step is as good as any: its error goes with Δt⁴ from rest (where the rate of the
/// acceleration vanishes) and with Δt³ from motion. A start with zero acceleration would give Δt².
#[test]
fn the_first_step_has_full_order() {
    for scheme in [NEWMARK, ENERGY_MOMENTUM] {
        for (name, m, expected) in [("rest", soft_plate(), 16.0), ("motion", moving(soft_plate()), 8.0)] {
            let error = |dt: f64| {
                let end = |steps: u32| {
                    let o = options(NEWMARK, dt, Some(dt / f64::from(steps)));
                    run(&m, &o, &mut Notes::default()).1.state.u
                };
                let one = run(&m, &options(scheme, dt, Some(dt)), &mut Notes::default()).1.state.u;
                distance(&one, &end(64))
            };
            let ratio = error(4e-3) / error(2e-3);
            println!("{scheme:?} {name}: {ratio}");
            assert!((0.8 * expected..1.2 * expected).contains(&ratio), "{scheme:?} {name}: {ratio}");
        }
    }
}

/// `M a = F − f_int − C v` on the free coordinates at the start.
#[test]
fn the_start_satisfies_the_equations_of_motion() {
    let mut m = moving(quarter_cylinder(3, 2.1e7));
    m.damping = Damping { mass: 0.7, stiffness: 1e-3 };
    m.loads = vec![
        Load::Gravity(GravityLoad { value: [0.0, 0.0, -9.81], amplitude: None }),
        Load::Pressure(PressureLoad { on: "all".into(), value: 2.0, amplitude: None, distribution: None }),
        Load::Force(vector_load("u_max_v_max", [1.0, 2.0, 3.0])),
    ];
    let mut notes = Notes::keeping();
    let (system, _) = run(&m, &options(NEWMARK, 1e-6, Some(1e-6)), &mut notes);
    let state = &notes.states[0];
    assert_eq!(state.step, 0);
    let n = system.vectors();
    let mut force = vec![[0.0; 3]; n];
    let mut internal = vec![[0.0; 3]; n];
    system.add_dead_loads(0.0, 1.0, &mut force);
    let rest = Motion::State { u: &state.u, velocity: None };
    tegula::system::assembly::add_follower_loads(&system, &rest, 0.0, 1.0, &mut force);
    Assembly::new(&system).forces(&system, &state.point_with_rates(&system), &mut internal);
    system.pattern.add_mass_product(-0.7, &state.v, &mut force);
    let scale = dot(&force, &force).sqrt() + dot(&internal, &internal).sqrt();
    system.pattern.add_mass_product(-1.0, &state.a, &mut force);
    for (f, i) in force.iter_mut().zip(&internal) {
        for c in 0..3 {
            f[c] -= i[c];
        }
    }
    let mut free = vec![0.0; system.unknowns()];
    system.frames.reduce(&force, &mut free);
    let residual = free.iter().map(|r| r * r).sum::<f64>().sqrt();
    assert!(dot(&internal, &internal) > 0.0 && residual < 1e-12 * scale, "{residual:e} of {scale:e}");
    // The clamped edge does not move, whatever initial velocity is asked for.
    let mut supported = vec![[0.0; 3]; n];
    system.frames.constrained_part(&state.v, &mut supported);
    assert_eq!(dot(&supported, &supported), 0.0);
}

/// A free plate that flies and tumbles, deforming on the way.
fn tumbling() -> Model {
    let mut m = model(plate([1.0, 0.6], [4, 3], 0.2), 1e6, 0.02);
    m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(1e6, 0.3, 500.0)));
    m.conditions.clear();
    m.initial_velocities = vec![InitialVelocity {
        on: "all".into(),
        velocity: [1.0, -2.0, 0.5],
        angular_velocity: [4.0, 2.0, 6.0],
        center: [0.5, 0.3, 0.0],
    }];
    m
}

#[test]
fn energy_momentum_conserves_what_its_name_says() {
    let mut notes = Notes::default();
    let (_, outcome) = run(&tumbling(), &options(ENERGY_MOMENTUM, 2.0, Some(0.02)), &mut notes);
    println!("{:?}, energy {:e} of {}", outcome.statistics, notes.drift(), notes.kinetic);
    assert_eq!(outcome.statistics.cutbacks, 0);
    assert!(notes.drift() < 2e-12 * notes.kinetic);
    assert!(outcome.balance.strain > 1e-4 * notes.kinetic, "it deforms");
    let (p0, l0) = notes.momenta[0];
    let p_drift = max_norm(notes.momenta.iter().map(|(p, _)| (p - p0).norm()));
    let l_drift = max_norm(notes.momenta.iter().map(|(_, l)| (l - l0).norm()));
    println!("momentum {:e}, angular momentum {:e}", p_drift / p0.norm(), l_drift / l0.norm());
    assert!(p_drift < 2e-13 * p0.norm() && l_drift < 2e-12 * l0.norm());
    // The trapezoidal rule does not keep the energy at this step.
    let mut trapezoid = Notes::default();
    run(&tumbling(), &options(NEWMARK, 0.2, Some(0.02)), &mut trapezoid);
    println!("trapezoidal rule {:e}", trapezoid.drift() / trapezoid.kinetic);
    assert!(trapezoid.drift() > 1e-6 * trapezoid.kinetic);
}

/// kinetic + strain + potential + dissipated − work stays constant: exactly in the energy–momentum
/// scheme, to second order in the others.
fn check_energy_balance(name: &str, m: &Model, end: f64, dt: f64) {
    let mut notes = Notes::default();
    let (_, outcome) = run(m, &options(ENERGY_MOMENTUM, end, Some(dt)), &mut notes);
    println!("{name}: {:?} drift {:e} of {}", outcome.balance, notes.drift(), notes.kinetic);
    assert!(notes.drift() < 2e-12 * notes.kinetic, "{name}: {:e}", notes.drift());
    let exchanged = outcome.balance.work.abs() + outcome.balance.dissipated;
    assert!(exchanged > 0.05 * notes.kinetic, "{name}: {exchanged:e}");
    for scheme in [NEWMARK, HHT] {
        let drift = |dt| {
            let mut notes = Notes::default();
            run(m, &options(scheme, end, Some(dt)), &mut notes);
            notes.drift() / notes.kinetic
        };
        let (coarse, fine) = (drift(dt), drift(0.5 * dt));
        println!("  {scheme:?}: {coarse:e}, halved {fine:e}");
        assert!(coarse < 2e-2, "{name} {scheme:?}: {coarse:e}");
        assert!(fine < coarse / 3.0, "{name} {scheme:?}: {coarse:e}, {fine:e}");
    }
}

#[test]
fn rate_damping_closes_the_energy_balance() {
    let m = Model { damping: Damping { mass: 0.0, stiffness: 5e-3 }, ..moving(soft_plate()) };
    check_energy_balance("rate damping", &m, 0.256, 4e-3);
    let mut m = moving(soft_plate());
    m.sections[0].retardation_time = 5e-3;
    check_energy_balance("retardation time", &m, 0.256, 4e-3);
}

#[test]
fn mass_damping_closes_the_energy_balance() {
    let m = Model { damping: Damping { mass: 2.0, stiffness: 0.0 }, ..moving(soft_plate()) };
    check_energy_balance("mass damping", &m, 0.256, 4e-3);
}

#[test]
fn loads_in_time_close_the_energy_balance() {
    let mut m = soft_plate();
    let formula = |text: &str| Amplitude::Expression(ExpressionAmplitude { expression: text.into() });
    m.amplitudes.insert("wave".into(), formula("sin(9*t)"));
    let wave = Some("wave".to_string());
    m.loads = vec![
        Load::Gravity(GravityLoad { value: [0.0, 0.0, -9.81], amplitude: wave.clone() }),
        Load::Pressure(PressureLoad { on: "all".into(), value: 900.0, amplitude: None, distribution: None }),
        Load::Edge(VectorLoad {
            on: "u_max".into(),
            value: [500.0, 0.0, 300.0],
            amplitude: wave,
            distribution: None,
        }),
    ];
    check_energy_balance("loads", &m, 0.256, 4e-3);
}

#[test]
fn prescribed_motion_closes_the_energy_balance() {
    let mut m = soft_plate();
    let formula = |text: &str| Amplitude::Expression(ExpressionAmplitude { expression: text.into() });
    m.amplitudes.insert("lift".into(), formula("0.3*t + 0.2*(1 - cos(6*t))"));
    m.conditions = driven_edge("u_min", 0.5, "lift");
    check_energy_balance("prescribed motion", &m, 0.256, 4e-3);
    // The support is where it should be, with its velocity.
    let mut notes = Notes::keeping();
    let o = options(NEWMARK, 0.1, Some(4e-3));
    let (system, outcome) = run(&m, &o, &mut notes);
    let v = system.coordinates.position_of[0] as usize;
    let t = 0.1_f64;
    assert!((outcome.state.u[v][2] - 0.5 * (0.3 * t + 0.2 * (1.0 - (6.0 * t).cos()))).abs() < 1e-15);
    assert!((outcome.state.v[v][2] - 0.5 * (0.3 + 1.2 * (6.0 * t).sin())).abs() < 1e-14);
}

/// A run continued from a state in its middle is the run itself, bit for bit.
fn check_restart(m: &Model, o: &TransientAnalysis, middle: usize) {
    let mut notes = Notes::keeping();
    let (system, straight) = run(m, o, &mut notes);
    let start = notes.states[middle].clone();
    assert_eq!(start.step, middle as u64);
    let mut rest = Notes::keeping();
    let continued = dynamics::run(&system, o, Some(start), &mut rest).unwrap();
    assert_eq!(rest.iterations, notes.iterations[middle + 1..], "{:?}", o.scheme);
    for (a, b) in notes.states[middle + 1..].iter().zip(&rest.states) {
        assert!(a == b, "{:?}: step {} differs", o.scheme, a.step);
    }
    assert!(straight.state == continued.state && straight.balance == continued.balance);
}

#[test]
fn restart_is_exact() {
    let m = Model { damping: Damping { mass: 0.1, stiffness: 1e-3 }, ..moving(soft_plate()) };
    for scheme in [NEWMARK, HHT, ENERGY_MOMENTUM] {
        check_restart(&m, &options(scheme, 0.1, Some(4e-3)), 10);
        check_restart(&m, &options(scheme, 0.1, None), 10);
    }
}

/// Ending a run and continuing it to a later time is the straight run, for steps that meet the end.
#[test]
fn a_finished_run_can_be_continued() {
    let m = moving(soft_plate());
    for scheme in [NEWMARK, HHT, ENERGY_MOMENTUM] {
        let dt = 1.0 / 256.0;
        let (system, first) = run(&m, &options(scheme, 16.0 * dt, Some(dt)), &mut Notes::default());
        let o = options(scheme, 40.0 * dt, Some(dt));
        let continued = dynamics::run(&system, &o, Some(first.state), &mut Notes::default()).unwrap();
        let (_, straight) = run(&m, &o, &mut Notes::default());
        assert!(straight.state == continued.state, "{scheme:?}");
    }
}

/// Sect. 5.4 on 4 × 4: 5 kg swing on a corner; statistics of the first 30 steps.
#[test]
fn pendulum_statistics() {
    let m = pendulum(4);
    let mut lines = Vec::new();
    for scheme in [NEWMARK, HHT, ENERGY_MOMENTUM] {
        let mut notes = Notes::default();
        let (_, outcome) = run(&m, &options(scheme, 0.3, Some(0.01)), &mut notes);
        assert!(outcome.balance.kinetic > 10.0);
        lines.push(format!("{:?}", outcome.statistics));
        let (_, outcome) = run(&m, &options(scheme, 0.3, None), &mut notes);
        lines.push(format!("automatic {:?}", outcome.statistics));
    }
    insta::assert_snapshot!(lines.join("\n"), @r"
    Statistics { steps: 30, iterations: 137, factorizations: 64, cutbacks: 0, linear_iterations: 0, critical_step: 0.0, energy_error: 0.0 }
    automatic Statistics { steps: 19, iterations: 95, factorizations: 51, cutbacks: 0, linear_iterations: 0, critical_step: 0.0, energy_error: 0.0 }
    Statistics { steps: 30, iterations: 128, factorizations: 57, cutbacks: 0, linear_iterations: 0, critical_step: 0.0, energy_error: 0.0 }
    automatic Statistics { steps: 20, iterations: 100, factorizations: 48, cutbacks: 0, linear_iterations: 0, critical_step: 0.0, energy_error: 0.0 }
    Statistics { steps: 30, iterations: 205, factorizations: 120, cutbacks: 0, linear_iterations: 0, critical_step: 0.0, energy_error: 0.0 }
    automatic Statistics { steps: 18, iterations: 145, factorizations: 87, cutbacks: 0, linear_iterations: 0, critical_step: 0.0, energy_error: 0.0 }
    ");
}

/// A linear model is factored once for the masses and once for each length of the step.
#[test]
fn linear_models_keep_their_factor() {
    for scheme in [NEWMARK, HHT, ENERGY_MOMENTUM] {
        let fixed = TransientAnalysis { linear: true, ..options(scheme, 0.4, Some(0.01)) };
        let (_, outcome) = run(&soft_plate(), &fixed, &mut Notes::default());
        assert_eq!((outcome.statistics.steps, outcome.statistics.factorizations), (40, 2));
        let automatic = TransientAnalysis { linear: true, ..options(scheme, 4.0, None) };
        let (_, outcome) = run(&soft_plate(), &automatic, &mut Notes::default());
        let s = outcome.statistics;
        println!("{scheme:?}: {s:?}");
        assert!(s.factorizations * 2 < s.steps, "{s:?}");
    }
}

/// Advice on a motion whose steps shrink to nothing leaves out what is in use already.
#[test]
fn advice_leaves_out_what_is_in_use() {
    let help = |scheme: Scheme, tau: f64| {
        let mut m = soft_plate();
        m.sections[0].retardation_time = tau;
        let hasty = TransientAnalysis { max_iterations: 1, ..options(scheme, 1.0, None) };
        let m = Model { analysis: Analysis::Transient(hasty.clone()), ..m };
        let (_, system) = compile(&m);
        match dynamics::run(&system, &hasty, None, &mut Notes::default()) {
            Err(tegula::Error::NotConverged { help, .. }) => help,
            other => panic!("{other:?}"),
        }
    };
    let plain = help(NEWMARK, 0.0);
    assert!(
        plain.contains("energy-momentum") && plain.contains("damping") && plain.contains("`tolerance`"),
        "{plain}"
    );
    let all = help(ENERGY_MOMENTUM, 0.01);
    assert!(
        !all.contains("energy-momentum") && !all.contains("damping") && all.contains("`tolerance`"),
        "{all}"
    );
}
