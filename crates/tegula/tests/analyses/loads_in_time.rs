//! Steps meet what loads and motions do: kinks of tables, pulses, formulas faster than a step, times that the user wants.

use crate::common;
use std::f64::consts::TAU;

use crate::common::{Notes, compile, displacement, driven_edge, model, move_in_time, plate, vector_load};
use tegula::analysis::statics;
use tegula::model::*;
use tegula::norm::max_norm;
use tegula::result::plastic_strains;
use tegula::system::Assembly;

const NEWMARK: Scheme = Scheme::Newmark(NewmarkScheme { beta: 0.25, gamma: 0.5 });
const HHT: Scheme = Scheme::Hht(HhtScheme { alpha: -0.1 });
const ENERGY_MOMENTUM: Scheme = Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 });
const EXPLICIT: Scheme = Scheme::Explicit(ExplicitScheme { scale_director_inertia: true });
const ALL: [Scheme; 4] = [NEWMARK, HHT, ENERGY_MOMENTUM, EXPLICIT];

fn formula(text: &str) -> Amplitude {
    Amplitude::Expression(ExpressionAmplitude { expression: text.into() })
}

fn table(times: &[f64], values: &[f64]) -> Amplitude {
    Amplitude::Table(TableAmplitude { times: times.into(), values: values.into() })
}

/// A free plate of mass 20 on which a traction with the resultant 3 along z acts, times the amplitude "p": all its
/// points move as one.
fn pushed(amplitude: Amplitude) -> Model {
    let mut m = model(plate([1.0, 1.0], [2, 2], 0.2), 1e6, 0.02);
    m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(1e6, 0.3, 1e3)));
    m.conditions.clear();
    m.amplitudes.insert("p".into(), amplitude);
    m.loads = vec![Load::Traction(VectorLoad {
        amplitude: Some("p".into()),
        ..vector_load("all", [0.0, 0.0, 3.0])
    })];
    m
}

fn run(m: &Model, scheme: Scheme, end: f64, step: Option<f64>, notes: &mut Notes) -> f64 {
    let options = TransientAnalysis { scheme, time_step: step, ..TransientAnalysis::new(end) };
    let (_, outcome) = move_in_time(m, &options, notes);
    outcome.balance.momentum[2] / 20.0
}

/// A load that begins just before the end has the impulse of its short action alone, also where this is shorter than two ends of steps
/// may be apart, and explicit steps do not take the half step for an instability.
#[test]
fn a_load_that_begins_just_before_the_end_gives_its_impulse() {
    for width in [1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-15] {
        let m = pushed(table(&[1.0 - width, 1.0, 2.0], &[0.0, 1.0, 1.0]));
        let exact = 3.0 / 20.0 * 0.5 * width;
        for scheme in ALL {
            for step in [None, Some(0.01)] {
                if step.is_some() && scheme == EXPLICIT {
                    continue;
                }
                let velocity = run(&m, scheme, 1.0, step, &mut Notes::default());
                // Ends of steps are 1e-9 apart, and accelerations of HHT hold a tenth of the load before.
                let (share, gap) = (if scheme == HHT { 0.11 } else { 1e-5 }, 0.15 * 1e-9);
                assert!(
                    (velocity - exact).abs() <= share * exact + gap,
                    "{width} {scheme:?} {step:?}: {velocity} for {exact}"
                );
            }
        }
    }
}

/// A clamped plate that is heated at once stretches through its thickness much faster than any usual step.
fn suddenly_heated() -> Model {
    let mut m = model(plate([1.0, 0.4], [6, 3], 0.0), 70e9, 0.004);
    let material = Isotropic { expansion: 2.3e-5, ..Isotropic::new(70e9, 0.3, 2700.0) };
    m.materials.insert("m".into(), Material::Isotropic(material));
    m.loads.clear();
    m.prescribed_strains = vec![PrescribedStrain::Thermal(ThermalStrain {
        on: "all".into(),
        temperature: 20.0,
        gradient: 0.0,
        distribution: None,
        amplitude: None,
    })];
    m
}

#[test]
fn a_scheme_that_gains_energy_behind_sudden_heat_warns() {
    let dissipative = Scheme::GeneralizedAlpha(GeneralizedAlphaScheme { spectral_radius: 0.0 });
    for (scheme, step) in [(dissipative, None), (HHT, Some(2e-4))] {
        let mut notes = Notes::default();
        run(&suddenly_heated(), scheme, 0.01, step, &mut notes);
        let largest = max_norm(notes.totals.iter().map(|t| t.1));
        assert!(largest > 3.0 * notes.totals[0].1, "{scheme:?}: {largest}");
        let told =
            notes.warnings.iter().any(|warning| warning.contains("in the first steps the motion has gained"));
        assert!(told, "{scheme:?}: {:?}", notes.events);
    }
    let mut notes = Notes::default();
    run(&suddenly_heated(), ENERGY_MOMENTUM, 0.01, None, &mut notes);
    assert!(notes.drift() < 1e-6 * notes.totals[0].1, "{}", notes.drift());
    assert!(!notes.events.iter().any(|event| event.contains("gained")), "{:?}", notes.events);
}

/// Tractions on irregular quads do not push each node by its mass: the momentum is exact, the motion is not rigid.
#[test]
fn a_pulse_between_steps_gives_its_impulse_in_every_scheme() {
    for width in [1e-2, 1e-3, 1e-4, 1e-6] {
        let [start, end] = [0.3, 0.3 + width];
        let m = pushed(table(&[start, 0.5 * (start + end), end], &[0.0, 100.0, 0.0]));
        let exact = 3.0 / 20.0 * 50.0 * (end - start);
        for scheme in ALL {
            for step in [None, Some(0.01), Some(0.0123)] {
                if step.is_some() && scheme == EXPLICIT {
                    continue;
                }
                let mut notes = Notes::keeping();
                let velocity = run(&m, scheme, 1.0, step, &mut notes);
                let error = (velocity / exact - 1.0).abs();
                println!("{scheme:?} {width} {step:?}: {error:e} in {} steps", notes.totals.len());
                assert!(error < 1e-9, "{scheme:?} {width} {step:?}: {velocity} for {exact}");
                if scheme != EXPLICIT {
                    let met = |t: f64| notes.totals.iter().any(|&(time, _)| time == t);
                    assert!(met(start) && met(end), "{scheme:?}: steps end on the kinks to the bit");
                }
            }
        }
    }
}

/// A jump, written as two points of a table that no step can tell apart, costs no accuracy.
#[test]
fn a_jump_of_a_table_gives_its_impulse_in_every_scheme() {
    let m = pushed(table(&[0.3, 0.3 + 1e-13, 0.6, 0.6 + 1e-13], &[0.0, 1.0, 1.0, 0.0]));
    let exact = 3.0 / 20.0 * 0.3;
    for scheme in ALL {
        let mut notes = Notes::default();
        let velocity = run(&m, scheme, 1.0, None, &mut notes);
        println!("{scheme:?}: {:e} in {} steps", velocity / exact - 1.0, notes.totals.len());
        assert!((velocity / exact - 1.0).abs() < 1e-8, "{scheme:?}: {velocity} for {exact}");
    }
}

/// v = F/(m ω) (1 − cos ωt), z = F/(m ω) (t − sin ωt/ω) of the centre of mass.
#[test]
#[ignore = "long"]
fn a_formula_faster_than_the_motion_is_resolved_by_automatic_steps() {
    for hertz in [80.0, 800.0, 1600.0] {
        let m = pushed(formula(&format!("sin(2*PI*{hertz}*t)")));
        let (end, omega) = (0.1, TAU * hertz);
        for scheme in ALL {
            let options = TransientAnalysis { scheme, ..TransientAnalysis::new(end) };
            let (system, outcome) = move_in_time(&m, &options, &mut Notes::default());
            let state = &outcome.state;
            let z = state.u[system.coordinates.position_of[4] as usize][2];
            let exact = 3.0 / 20.0 / omega * (end - (omega * end).sin() / omega);
            println!("{hertz} {scheme:?}: {:e} in {} steps", z / exact - 1.0, state.step);
            assert!((z / exact - 1.0).abs() < 0.03, "{hertz} {scheme:?}: {z} for {exact}");
        }
    }
}

#[test]
fn a_formula_that_pulses_or_jumps_is_met_by_automatic_steps() {
    // ∫ exp(−((t − 0.3)/w)²) dt = w √π.
    let pulse = pushed(formula("exp(-((t-0.3)/0.0005)^2)"));
    let jump = pushed(formula("0.5*(1 + tanh(1000000000*(t-0.3)))"));
    for scheme in [NEWMARK, HHT, ENERGY_MOMENTUM] {
        let exact = 3.0 / 20.0 * 5e-4 * std::f64::consts::PI.sqrt();
        let velocity = run(&pulse, scheme, 1.0, None, &mut Notes::default());
        assert!((velocity / exact - 1.0).abs() < 0.02, "{scheme:?}: {velocity} for {exact}");
        let exact = 3.0 / 20.0 * 0.7;
        let mut notes = Notes::default();
        let velocity = run(&jump, scheme, 1.0, None, &mut notes);
        println!("jump {scheme:?}: {:e} in {} steps", velocity / exact - 1.0, notes.totals.len());
        assert!((velocity / exact - 1.0).abs() < 1e-6, "{scheme:?}: {velocity} for {exact}");
        assert!(
            notes.events.iter().any(|e| e.contains("\"p\"") && e.contains("jumps")),
            "{:?}",
            notes.events
        );
    }
}

#[test]
fn a_constant_step_that_misses_a_formula_is_reported_by_its_name() {
    let m = pushed(formula("sin(2*PI*800*t)"));
    let told = |step: f64| {
        let mut notes = Notes::default();
        run(&m, NEWMARK, 0.1, Some(step), &mut notes);
        notes.events.iter().filter(|e| e.contains("\"p\"") && e.contains("time_step")).count()
    };
    // A whole number of periods to a step: the load is 0 at the end of every one.
    assert_eq!(told(0.01), 1);
    assert_eq!(told(0.000_05), 0);
}

/// The motion of a table is followed through its kinks, where its velocity jumps, and the energy balance closes.
#[test]
fn a_support_moves_as_its_table_says_and_the_energy_balance_closes_over_its_kinks() {
    let mut m = model(plate([1.0, 0.3], [4, 2], 0.1), 1e5, 0.05);
    m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(1e5, 0.3, 1e3)));
    m.amplitudes.insert("p".into(), table(&[0.0, 0.1, 0.25, 0.3], &[0.0, 1.0, 1.0, 0.2]));
    m.conditions = driven_edge("u_min", 0.01, "p");
    for scheme in [NEWMARK, HHT, ENERGY_MOMENTUM, EXPLICIT] {
        let drift = |step: f64| {
            let mut notes = Notes::keeping();
            let time_step = (scheme != EXPLICIT).then_some(step);
            let max_step = (scheme == EXPLICIT).then_some(0.1 * step);
            let options = TransientAnalysis { scheme, time_step, max_step, ..TransientAnalysis::new(0.4) };
            let (system, _) = move_in_time(&m, &options, &mut notes);
            let v = system.coordinates.position_of[0] as usize;
            for s in notes.states.iter().filter(|s| s.time > 0.3 + 1e-9) {
                assert!((s.u[v][2] - 0.002).abs() < 1e-15 && s.v[v][2] == 0.0, "{scheme:?} at {}", s.time);
            }
            notes.drift() / notes.kinetic
        };
        let (coarse, fine) = (drift(4e-3), drift(1e-3));
        println!("{scheme:?}: {coarse:e}, a quarter of the step {fine:e}");
        match scheme {
            Scheme::EnergyMomentum(_) => assert!(coarse < 1e-11 && fine < 1e-11),
            _ => assert!(coarse < 0.05 && fine < coarse / 8.0, "{scheme:?}: {coarse:e}, {fine:e}"),
        }
    }
}

/// Where the velocity of a support jumps, the momentum of free coordinates does not: no force on them is infinite.
#[test]
fn free_coordinates_keep_their_momentum_where_the_velocity_of_a_support_jumps() {
    for (element, at_start) in
        [ElementKind::Ems, ElementKind::Mitc4].into_iter().flat_map(|e| [(e, true), (e, false)])
    {
        let mut m = model(plate([1.0, 0.3], [4, 2], 0.1), 1e5, 0.05);
        m.sections[0].element = element;
        m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(1e5, 0.3, 1e3)));
        m.damping = Damping { stiffness: 1e-3, ..Default::default() };
        // The support is at rest up to the kink: nothing has moved there, whatever the scheme.
        let times = if at_start { [0.0, 0.1] } else { [0.05, 0.1] };
        m.amplitudes.insert("p".into(), table(&times, &[0.0, 1.0]));
        m.conditions = driven_edge("u_min", 0.1, "p");
        for scheme in [NEWMARK, HHT, ENERGY_MOMENTUM] {
            let mut notes = Notes::keeping();
            let options = TransientAnalysis { scheme, time_step: Some(0.05), ..TransientAnalysis::new(0.05) };
            let (system, outcome) = move_in_time(&m, &options, &mut notes);
            let state = if at_start { &notes.states[0] } else { &outcome.state };
            let mut momentum = vec![[0.0; 3]; system.vectors()];
            system.pattern.add_mass_product(1.0, &state.v, &mut momentum);
            let mut free = vec![0.0; system.unknowns()];
            system.frames.reduce(&momentum, &mut free);
            let largest = max_norm(momentum.as_flattened());
            assert!(largest > 0.1, "{element:?} {scheme:?}: the supported nodes move");
            assert!(max_norm(&free) <= 1e-12 * largest, "{element:?} {scheme:?}: {free:?}");
            let kinetic = system.kinetic_energy(&state.v);
            assert!(at_start || (state.work / kinetic - 1.0).abs() < 1e-12, "{element:?} {scheme:?}");
            if scheme == ENERGY_MOMENTUM {
                // Its accelerations are means of steps.
                continue;
            }
            // The equations of motion hold behind the kink, with damping forces that the jump has changed.
            let k = state.point_with_rates(&system);
            let mut rest = vec![[0.0; 3]; system.vectors()];
            let mut assembly = Assembly::new(&system);
            assembly.follow(&system, &k);
            assembly.forces(&system, &k, &mut rest);
            let damping = max_norm(rest.as_flattened());
            system.pattern.add_mass_product(1.0, &state.a, &mut rest);
            assembly.frames.reduce(&rest, &mut free);
            assert!(damping > 1.0, "{element:?} {scheme:?}: damping acts, {damping:e}");
            assert!(max_norm(&free) <= 1e-9 * damping, "{element:?} {scheme:?}: {:e}", max_norm(&free));
        }
    }
}

/// Constrained degrees of freedom have the velocities of their motion; with the energy–momentum scheme they do not
/// oscillate about them when the motion stops.
#[test]
fn a_ramp_that_stops_leaves_no_motion_behind() {
    let mut m = model(plate([1.0, 0.1], [8, 1], 0.0), 1e7, 0.02);
    m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(1e7, 0.3, 1e3)));
    m.amplitudes.insert("p".into(), Amplitude::Ramp(RampAmplitude { start: 0.0, end: 0.5 }));
    m.conditions = vec![
        Condition::Fix(FixComponents {
            on: "all".into(),
            position: vec![Axis::Y, Axis::Z],
            director: vec![Axis::X, Axis::Y],
        }),
        Condition::Prescribe(PrescribeComponent {
            on: "all".into(),
            of: NodalVector::Position,
            component: Axis::X,
            value: 0.1,
            amplitude: Some("p".into()),
        }),
    ];
    for scheme in [NEWMARK, HHT, ENERGY_MOMENTUM] {
        for step in [Some(0.02), Some(0.03), None] {
            let mut notes = Notes::keeping();
            let options = TransientAnalysis { scheme, time_step: step, ..TransientAnalysis::new(1.0) };
            let (system, outcome) = move_in_time(&m, &options, &mut notes);
            // ½ m v² with the velocity 0.2 on the way.
            assert!((notes.kinetic / (0.5 * system.total_mass() * 0.04) - 1.0).abs() < 1e-9);
            for s in notes.states.iter().filter(|s| s.time >= 0.5) {
                let kinetic = system.kinetic_energy(&s.v);
                assert!(kinetic < 1e-20 * notes.kinetic, "{scheme:?} {step:?}: {kinetic:e} at {}", s.time);
            }
            assert!(outcome.balance.kinetic < 1e-20 * notes.kinetic);
        }
    }
}

/// A cantilever of ideally elastic and hardening plastic layers that is bent beyond yield and back.
fn plastic_cycle(amplitude: Amplitude, load_steps: u32) -> Model {
    let mut m = model(plate([1.0, 0.1], [8, 1], 0.0), 2e11, 0.01);
    let law = Plastic {
        young: 2e11,
        poisson: 0.3,
        yield_stress: 2.5e8,
        hardening: 2e10,
        saturation: None,
        saturation_rate: 0.0,
        kinematic: 0.0,
        density: 0.0,
        expansion: 0.0,
    };
    m.materials.insert("m".into(), Material::Plastic(law));
    m.amplitudes.insert("p".into(), amplitude);
    m.loads = vec![Load::Edge(VectorLoad {
        amplitude: Some("p".into()),
        ..vector_load("u_max", [0.0, 0.0, 5000.0])
    })];
    m.analysis = Analysis::Static(StaticAnalysis { load_steps, ..Default::default() });
    m
}

#[test]
#[ignore = "long"]
fn a_plastic_cycle_gives_one_answer_whatever_the_load_steps() {
    // The stress update over a step is of first order where the direction of the stress turns: what remains is its error.
    let courses = [(table(&[0.0, 0.5, 1.0], &[0.0, 1.0, 0.0]), 1e-3), (formula("sin(PI*t)"), 2e-3)];
    for (amplitude, tolerance) in courses {
        let answer = |load_steps: u32| {
            let m = plastic_cycle(amplitude.clone(), load_steps);
            let (mesh, system, outcome) = common::solve(&m);
            let largest =
                plastic_strains(&system, &outcome.state).into_iter().max_by(f64::total_cmp).unwrap();
            (largest, displacement(&mesh, &system, &outcome.state.u, "u_max_v_max").z)
        };
        let (strain, z) = answer(64);
        println!("{amplitude:?}: plastic strain {strain:e}, tip {z:e}");
        assert!(strain > 5e-5 && z > 1e-4, "it yields");
        for steps in [1, 3, 7] {
            let (s, x) = answer(steps);
            let (of_s, of_x) = ((s / strain - 1.0).abs(), (x / z - 1.0).abs());
            println!("  {steps} steps: {of_s:e} {of_x:e}");
            assert!(of_s < tolerance && of_x < tolerance, "{amplitude:?} {steps}: {s:e} {x:e}");
        }
    }
}

#[test]
fn steps_end_at_the_times_that_the_user_wants() {
    let at = vec![0.123, 0.5, 0.777];
    let mut m = plastic_cycle(formula("t"), 4);
    m.output.at = at.clone();
    let (_, system) = compile(&m);
    let mut notes = Notes::default();
    statics::run(&system, &common::static_options(&m), None, &mut notes).unwrap();
    let times: Vec<f64> = notes.totals.iter().map(|t| t.0).collect();
    assert_eq!(times, [0.123, 0.25, 0.5, 0.75, 0.777, 1.0]);
    let mut m = pushed(formula("t"));
    m.output.at = at.clone();
    for scheme in ALL {
        let mut notes = Notes::default();
        run(&m, scheme, 1.0, None, &mut notes);
        assert!(at.iter().all(|t| notes.totals.iter().any(|(time, _)| time == t)), "{scheme:?}");
    }
    m.output.at = vec![0.0, 2.0, f64::NAN];
    m.analysis = Analysis::Transient(TransientAnalysis::new(1.0));
    let mesh = tegula::mesh::generators::generate(&m.mesh).unwrap();
    let Err(tegula::Error::Model(issues)) = tegula::compile::build(&m, &mesh) else { panic!("accepted") };
    assert_eq!(
        issues.iter().filter(|i| format!("{:?}", i.place).contains("output.at[")).count(),
        3,
        "{issues:?}"
    );
}

/// The work of a prescribed motion is that of its reactions, also where directors keep their length and turn: no support
/// does work on them. The balance of a strip driven across closes.
#[test]
fn work_of_a_driven_edge_closes_the_balance_with_every_element() {
    for element in [ElementKind::Ems, ElementKind::Mitc4, ElementKind::Cm] {
        let mut m = model(plate([1.0, 0.3], [4, 2], 0.1), 1e5, 0.05);
        m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(1e5, 0.3, 1e3)));
        m.sections[0].element = element;
        m.amplitudes.insert("p".into(), formula("1 - cos(4*t)"));
        m.conditions = vec![
            Condition::Fix(FixComponents {
                on: "u_min".into(),
                position: vec![Axis::X, Axis::Y],
                director: Vec::new(),
            }),
            Condition::Prescribe(PrescribeComponent {
                on: "u_min".into(),
                of: NodalVector::Position,
                component: Axis::Z,
                value: 0.1,
                amplitude: Some("p".into()),
            }),
        ];
        for (scheme, bound) in [(NEWMARK, 2e-3), (HHT, 2e-3), (ENERGY_MOMENTUM, 1e-9)] {
            let mut notes = Notes::default();
            let options = TransientAnalysis { scheme, time_step: Some(2e-3), ..TransientAnalysis::new(1.0) };
            let (_, outcome) = move_in_time(&m, &options, &mut notes);
            assert!(outcome.balance.work.abs() > 0.1 * notes.kinetic, "{element:?}: the drive works");
            let drift = notes.drift() / notes.kinetic;
            println!("{element:?} {scheme:?}: {drift:e}");
            assert!(drift < bound, "{element:?} {scheme:?}: {drift:e}");
        }
    }
}

/// A pulse that begins as exp(−2500): its first energies grow by powers of ten in a step, and mean nothing.
#[test]
fn a_pulse_from_nothing_is_no_instability_of_explicit_steps() {
    let m = pushed(formula("exp(-((t-1)/0.02)^2)"));
    let exact = 3.0 / 20.0 * 0.02 * std::f64::consts::PI.sqrt();
    let velocity = run(&m, EXPLICIT, 2.0, None, &mut Notes::default());
    assert!((velocity / exact - 1.0).abs() < 0.02, "{velocity} for {exact}");
}

#[test]
fn a_prescribed_motion_that_jumps_is_refused() {
    let mut m = pushed(table(&[0.0, 0.5, 0.500_000_000_001, 1.0], &[0.0, 0.0, 0.1, 0.1]));
    m.loads.clear();
    m.conditions = vec![Condition::Prescribe(PrescribeComponent {
        on: "u_min".into(),
        of: NodalVector::Position,
        component: Axis::X,
        value: 1.0,
        amplitude: Some("p".into()),
    })];
    m.analysis = Analysis::Transient(TransientAnalysis::new(1.0));
    let mesh = tegula::mesh::generators::generate(&m.mesh).unwrap();
    let Err(tegula::Error::Model(issues)) = tegula::compile::build(&m, &mesh) else { panic!("accepted") };
    assert!(issues.iter().any(|i| i.to_string().contains("discontinuous at t = 0.5")), "{issues:?}");
}
