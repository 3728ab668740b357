//! Explicit integration: order, energy, momenta, the critical step, lumped mass.

use crate::common;
use crate::common::{Notes, compile, model, plate};
use tegula::analysis::dynamics::{self, TransientOutcome};
use tegula::analysis::{Silent, modal};
use tegula::model::*;
use tegula::system::EvaluationPoint;
use tegula::{Error, Result, System, Vec3};

const NEWMARK: Scheme = Scheme::Newmark(NewmarkScheme { beta: 0.25, gamma: 0.5 });

fn explicit(scale_director_inertia: bool) -> Scheme {
    Scheme::Explicit(ExplicitScheme { scale_director_inertia })
}

fn with(m: &Model, scheme: Scheme, end: f64, time_step: Option<f64>) -> Model {
    let t = TransientAnalysis { scheme, time_step, ..TransientAnalysis::new(end) };
    Model { analysis: Analysis::Transient(t), ..m.clone() }
}

fn run(m: &Model, notes: &mut Notes) -> (System, Result<TransientOutcome>) {
    let (_, system) = compile(m);
    let Analysis::Transient(t) = &m.analysis else { unreachable!() };
    let outcome = dynamics::run(&system, t, None, notes);
    (system, outcome)
}

/// A clamped plate that starts with an even velocity gradient, which excites its lowest bending modes most.
fn vibrating(n: u32, thickness: f64) -> Model {
    let mut m = model(plate([1.0, 1.0], [n, n], 0.2), 1e6, thickness);
    m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(1e6, 0.3, 1e3)));
    m.initial_velocities = vec![InitialVelocity {
        on: "all".into(),
        velocity: [0.0; 3],
        angular_velocity: [0.0, -0.02, 0.0],
        center: [0.0; 3],
    }];
    m
}

fn distance(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (Vec3::from(*a) - Vec3::from(*b)).norm_squared()).sum::<f64>().sqrt()
}

/// Model `m` with lumped mass, for implicit steps and modes.
fn twin(m: &Model) -> System {
    let (_, lumped) = compile(m);
    let (_, mut system) = compile(&with(m, NEWMARK, 1.0, None));
    let mut mass = vec![0.0; lumped.vectors()];
    lumped.pattern.for_each_mass(|i, j, m| {
        assert_eq!(i, j, "not lumped");
        mass[i] = m;
    });
    system.pattern.set_mass(|i, j| if i == j { mass[i] } else { 0.0 });
    system
}

/// Halving the step quarters the error in displacement and velocity, and the swing of the energy; the limit is the
/// implicit solution of the same lumped system.
#[test]
fn it_is_of_second_order_and_agrees_with_implicit_steps() {
    let mut m = vibrating(4, 0.1);
    m.damping.mass = 0.5;
    let end = 0.128;
    let at = |steps: u32| {
        let mut notes = Notes::default();
        let m = with(&m, explicit(true), end, Some(end / f64::from(steps)));
        let (_, outcome) = run(&m, &mut notes);
        (outcome.unwrap().state, notes.drift() / notes.kinetic)
    };
    let exact =
        TransientAnalysis { scheme: NEWMARK, time_step: Some(end / 4096.0), ..TransientAnalysis::new(end) };
    let system = twin(&with(&m, explicit(true), end, None));
    let exact = dynamics::run(&system, &exact, None, &mut Silent).unwrap().state;
    let [(a, swing_a), (b, swing_b)] = [at(160), at(320)];
    let u = distance(&a.u, &exact.u) / distance(&b.u, &exact.u);
    let v = distance(&a.v, &exact.v) / distance(&b.v, &exact.v);
    println!("displacement {u}, velocity {v}, energy {}", swing_a / swing_b);
    for ratio in [u, v, swing_a / swing_b] {
        assert!((3.6..4.4).contains(&ratio), "{u} {v} {swing_a:e} {swing_b:e}");
    }
}

/// At 0.9 of the critical step the energy does not drift: its mean over the last tenth of many periods is that of the
/// first.
#[test]
fn the_energy_of_a_vibrating_plate_does_not_drift() {
    let mut notes = Notes::default();
    let (_, outcome) = run(&with(&vibrating(6, 0.05), explicit(true), 12.0, None), &mut notes);
    let outcome = outcome.unwrap();
    let tenth = notes.totals.len() / 10;
    let mean = |t: &[(f64, f64)]| t.iter().map(|t| t.1).sum::<f64>() / t.len() as f64;
    let drift = mean(&notes.totals[9 * tenth..]) - mean(&notes.totals[..tenth]);
    println!(
        "{} steps, drift {:.1e}, largest swing {:.1e}, critical {:.2e}",
        outcome.statistics.steps,
        drift / notes.kinetic,
        notes.drift() / notes.kinetic,
        outcome.statistics.critical_step
    );
    assert!(outcome.statistics.steps > 2000, "{}", outcome.statistics.steps);
    assert!(drift.abs() < 1e-3 * notes.kinetic, "{drift:e} of {:e}", notes.kinetic);
}

#[test]
fn a_free_plate_keeps_its_momenta() {
    let mut m = vibrating(4, 0.02);
    m.conditions.clear();
    m.initial_velocities[0].velocity = [1.0, -2.0, 0.5];
    m.initial_velocities[0].angular_velocity = [1.0, 2.0, 3.0];
    let mut notes = Notes::default();
    run(&with(&m, explicit(true), 0.5, None), &mut notes).1.unwrap();
    let (linear, angular) = notes.momenta[0];
    for (l, a) in &notes.momenta {
        assert!((l - linear).norm() < 1e-11 * linear.norm(), "{l} {linear}");
        assert!((a - angular).norm() < 1e-11 * angular.norm(), "{a} {angular}");
    }
    assert!(notes.momenta.len() > 10, "{}", notes.momenta.len());
}

/// The critical step by the highest frequency of the whole model, iterated from internal forces of small displacements:
/// from above.
fn critical_by_iteration(m: &Model) -> f64 {
    let (_, mut system) = compile(m);
    system.linear = true;
    let mut mass = vec![0.0; system.vectors()];
    system.pattern.for_each_mass(|i, _, m| mass[i] = m);
    let mut assembly = tegula::system::Assembly::new(&system);
    let mut random = common::Random::new(1);
    let mut x: Vec<[f64; 3]> = mass.iter().map(|_| random.vector().into()).collect();
    let (mut force, mut held) = (x.clone(), x.clone());
    let mut square = 0.0;
    for _ in 0..3000 {
        system.frames.constrained_part(&x, &mut held);
        let mut norm = 0.0;
        for v in 0..x.len() {
            for i in 0..3 {
                x[v][i] -= held[v][i];
                norm += mass[v] * x[v][i] * x[v][i];
            }
        }
        x.iter_mut().flatten().for_each(|x| *x /= norm.sqrt());
        let k = EvaluationPoint::at_rest(&system, &x, 0.0, &[]);
        assembly.forces(&system, &k, &mut force);
        square = tegula::system::dot(&x, &force);
        for v in 0..x.len() {
            x[v] = force[v].map(|f| f / mass[v]);
        }
    }
    2.0 / square.sqrt()
}

/// The bound by single elements is safe, and not far off, whatever the mesh, the element and the thickness.
#[test]
fn the_bound_is_below_the_critical_step_and_near_it() {
    for element in [ElementKind::Ems, ElementKind::Cm, ElementKind::SolidShell] {
        for (thickness, scale) in [(0.2, true), (0.2, false), (1e-3, true), (1e-3, false)] {
            let mut m = with(&vibrating(6, thickness), explicit(scale), 1e-9, None);
            m.sections[0].element = element;
            let bound = run(&m, &mut Notes::default()).1.unwrap().statistics.critical_step;
            let critical = critical_by_iteration(&m);
            println!(
                "{element:?} {thickness} {scale}: {bound:.4e} of {critical:.4e}, {:.3}",
                bound / critical
            );
            assert!(bound < critical && bound > 0.75 * critical, "{bound} {critical}");
        }
    }
}

/// Just below the critical step the motion is bounded, just above it blows up and says when, where and what to do.
#[test]
fn a_step_above_the_critical_one_is_an_error_with_a_remedy() {
    let m = vibrating(4, 0.05);
    let critical = critical_by_iteration(&with(&m, explicit(true), 1.0, None));
    run(&with(&m, explicit(true), 400.0 * critical, Some(0.98 * critical)), &mut Notes::default()).1.unwrap();
    for factor in [1.03, 1.1, 2.0] {
        let mut notes = Notes::default();
        let m = with(&m, explicit(true), 2000.0 * critical, Some(factor * critical));
        let error = run(&m, &mut notes).1.unwrap_err();
        let text = error.to_string();
        println!("{factor}: {text}");
        let Error::Unstable { at, reason, help } = &error else { panic!("{error:?}") };
        assert!(at.contains("time") && at.contains("step") && reason.contains("node"), "{text}");
        assert!(reason.contains("energy") && help.contains("Leave out `time_step`"), "{text}");
        assert!(notes.warnings.iter().any(|w| w.contains("certainly stable")), "{:?}", notes.events);
    }
}

/// Small displacements keep the balance to rounding, high modes and jumps of the load or not.
#[test]
fn the_energy_balance_of_a_linear_motion_is_exact() {
    let mut m = vibrating(5, 0.05);
    m.loads = vec![Load::Edge(VectorLoad {
        on: "u_max".into(),
        value: [0.0, 3.0, 1.0],
        amplitude: None,
        distribution: None,
    })];
    let mut m = with(&m, explicit(true), 0.5, None);
    if let Analysis::Transient(t) = &mut m.analysis {
        t.linear = true;
    }
    let mut notes = Notes::default();
    let error = run(&m, &mut notes).1.unwrap().statistics.energy_error;
    println!("error {error:.1e}, swing {:.1e}", notes.drift() / notes.kinetic);
    assert!(notes.totals.len() > 10 && notes.drift() > 1e-5 * notes.kinetic, "{:e}", notes.drift());
    assert!(error < 1e-11, "{error:e}");
}

/// Values that are not finite end the analysis in the step where they arise, and the error names the place.
#[test]
fn values_that_are_not_finite_are_an_error_with_their_place() {
    let mut m = vibrating(4, 0.05);
    m.loads = vec![Load::Force(VectorLoad {
        on: "u_max_v_max".into(),
        value: [0.0, 0.0, 1e100],
        amplitude: Some("late".into()),
        distribution: None,
    })];
    let table = TableAmplitude { times: vec![0.0, 0.01, 0.011, 1.0], values: vec![0.0, 0.0, 1e200, 1e200] };
    m.amplitudes.insert("late".into(), Amplitude::Table(table));
    let error = run(&with(&m, explicit(true), 0.1, None), &mut Notes::default()).1.unwrap_err();
    println!("{error}");
    let Error::Unstable { at, reason, .. } = &error else { panic!("{error:?}") };
    // Three steps reach the kink of the table at 0.01, the fourth ends on the next one.
    assert!(at.contains("step 4") && at.contains("1.100000e-2"), "{error}");
    assert!(reason.contains("no longer finite") && reason.contains("at (1.0000, 1.0000, 0.0000)"), "{error}");
}

/// Without scaling the thickness of a thin plate limits the step, with it the size of the elements does.
#[test]
fn the_thickness_does_not_limit_the_step() {
    let step = |scale, thickness| {
        let m = with(&vibrating(8, thickness), explicit(scale), 1e-5, None);
        run(&m, &mut Notes::default()).1.unwrap().statistics.critical_step
    };
    let (scaled, plain, thinner) = (step(true, 1e-3), step(false, 1e-3), step(true, 1e-4));
    println!("{scaled:.3e} {plain:.3e} {thinner:.3e}");
    assert!(scaled > 30.0 * plain, "{scaled} {plain}");
    assert!((thinner / scaled - 1.0).abs() < 0.05, "{thinner} {scaled}");
}

/// Lumping and heavier directors keep the mass and move the lowest frequencies little, by the square of the element
/// size.
#[test]
fn the_lowest_frequencies_stay() {
    let changes = |n: u32| {
        let m = vibrating(n, 0.01);
        let [(consistent, mass), (lumped, kept)] =
            [compile(&with(&m, NEWMARK, 1.0, None)).1, twin(&with(&m, explicit(true), 1.0, None))].map(
                |system| {
                    let modes = modal::run(&system, 3, None, &mut Silent).unwrap().modes;
                    (modes.iter().map(|m| m.frequency_hz).collect::<Vec<_>>(), system.total_mass())
                },
            );
        assert!((kept / mass - 1.0).abs() < 1e-12);
        consistent.iter().zip(&lumped).map(|(a, b)| b / a - 1.0).collect::<Vec<_>>()
    };
    let (coarse, fine) = (changes(20), changes(40));
    println!("{coarse:?} {fine:?}");
    for (a, b) in coarse.iter().zip(&fine) {
        assert!(b.abs() < 5e-3 && (3.0..5.0).contains(&(a / b)), "{coarse:?} {fine:?}");
    }
}

/// A strip pulled to 1.5 times its length within the time that a wave takes for three lengths: its highest frequency
/// grows by 1.7, and automatic steps stay below the critical one at every report.
#[test]
fn automatic_steps_stay_stable_under_stretch() {
    use tegula::analysis::dynamics::critical_step::CriticalStep;
    use tegula::system::Assembly;
    for element in [ElementKind::Ems, ElementKind::SolidShell] {
        let mut m = model(plate([1.0, 0.2], [20, 4], 0.0), 1e6, 0.02);
        m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(1e6, 0.0, 1e3)));
        m.sections[0].element = element;
        let pull = PrescribeComponent {
            on: "u_max".into(),
            of: NodalVector::Position,
            component: Axis::X,
            value: 0.5,
            amplitude: Some("pull".into()),
        };
        m.conditions.push(Condition::Prescribe(pull));
        let expression = "(1-cos(PI*t/0.1))/2".to_string();
        m.amplitudes.insert("pull".into(), Amplitude::Expression(ExpressionAmplitude { expression }));
        let m = with(&m, explicit(true), 0.1, None);
        let mut notes = Notes::keeping();
        let (system, outcome) = run(&m, &mut notes);
        let outcome = outcome.unwrap();
        assert!(outcome.statistics.energy_error <= 0.01, "{:?}", outcome.statistics);
        let mut mass = vec![0.0; system.vectors()];
        system.pattern.for_each_mass(|i, _, m| mass[i] = m);
        let mut critical = CriticalStep::new(&system, &mass);
        let (mut assembly, first) = (Assembly::new(&system), notes.states[1].last_step);
        for state in &notes.states[1..] {
            let bound = critical.below(&system, &mut assembly, &mass, state);
            assert!(state.last_step <= bound, "{element:?} {}: {} of {bound}", state.time, state.last_step);
        }
        let last = outcome.state.last_step.max(notes.states[notes.states.len() - 2].last_step);
        assert!(last < 0.75 * first, "{element:?}: {last} after {first}");
    }
}

/// Damping forces lag by half a step: near the critical one that costs a part of what they dissipate, which is no sign of
/// instability. The error falls with the step.
#[test]
fn damped_motions_that_begin_with_a_velocity_are_taken_at_the_automatic_step() {
    let mut m = model(plate([0.5, 0.3], [8, 3], 0.0), 1e7, 0.01);
    m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(1e7, 0.3, 1e3)));
    m.damping = Damping { stiffness: 1e-4, ..Default::default() };
    let wave = ExpressionAmplitude { expression: "sin(20*t)".into() };
    m.amplitudes.insert("wave".into(), Amplitude::Expression(wave));
    m.conditions.push(Condition::Prescribe(PrescribeComponent {
        on: "u_max_v_max".into(),
        of: NodalVector::Position,
        component: Axis::Z,
        value: 0.05,
        amplitude: Some("wave".into()),
    }));
    let error = |max_step: Option<f64>| {
        let mut m = with(&m, explicit(true), 0.1, None);
        if let Analysis::Transient(t) = &mut m.analysis {
            t.max_step = max_step;
        }
        run(&m, &mut Notes::default()).1.unwrap().statistics.energy_error
    };
    let (automatic, fine, finer) = (error(None), error(Some(1e-4)), error(Some(5e-5)));
    assert!(automatic < 0.1 && (1.7..2.3).contains(&(fine / finer)), "{automatic} {fine} {finer}");
}
