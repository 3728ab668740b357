//! Properties of the time integration schemes that their theory gives: order, recurrences of an oscillator, damping,
//! estimates of the local error, step control.

use crate::common::{Notes, distance, model, move_in_time, plate, vector_load};
use tegula::System;
use tegula::analysis::dynamics::Span;
use tegula::analysis::newton::Newton;
use tegula::analysis::{Silent, State};
use tegula::element::Nodal;
use tegula::model::*;

const NEWMARK: Scheme = Scheme::Newmark(NewmarkScheme { beta: 0.25, gamma: 0.5 });
const HHT: Scheme = Scheme::Hht(HhtScheme { alpha: -0.1 });
const ENERGY_MOMENTUM: Scheme = Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 });
const GENERALIZED_ALPHA: Scheme = Scheme::GeneralizedAlpha(GeneralizedAlphaScheme { spectral_radius: 0.8 });
const BDF2: Scheme = Scheme::Bdf2(Bdf2Scheme {});
const EXPLICIT: Scheme = Scheme::Explicit(ExplicitScheme { scale_director_inertia: true });

fn options(scheme: Scheme, end_time: f64, time_step: Option<f64>) -> TransientAnalysis {
    TransientAnalysis { scheme, time_step, ..TransientAnalysis::new(end_time) }
}

fn with_material(mut m: Model, young: f64, poisson: f64, density: f64) -> Model {
    m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(young, poisson, density)));
    m
}

/// A strip of 3 × 1 elements that swings on a corner and bends.
fn swinging() -> Model {
    let mut m = with_material(model(plate([1.0, 0.3], [3, 1], 0.0), 1e6, 0.02), 1e6, 0.3, 1e3);
    m.conditions = vec![Condition::Spherical(OnSet { on: "u_min_v_min".into() })];
    m.loads = vec![Load::Gravity(GravityLoad { value: [0.0, 0.0, -9.81], amplitude: None })];
    m
}

/// The drift of the energy goes with the square of the step through five halvings, far below what the tolerance of the
/// step control would ask for: the iteration leaves nothing that does not vanish with the step.
#[test]
fn energy_drift_of_newmark_falls_with_the_square_of_the_step_through_five_halvings() {
    let (m, end) = (swinging(), 0.25);
    let drift = |steps: u32| {
        let mut notes = Notes::default();
        move_in_time(&m, &options(NEWMARK, end, Some(end / f64::from(steps))), &mut notes);
        notes.drift() / notes.kinetic
    };
    let drifts: Vec<f64> = (0..6).map(|k| drift(500 << k)).collect();
    let ratios: Vec<f64> = drifts.windows(2).map(|w| w[0] / w[1]).collect();
    assert!(ratios.iter().all(|r| (3.8..4.2).contains(r)), "{drifts:?} {ratios:?}");
}

/// Positions and velocities of a large motion converge with the square of the step while the step resolves the motion:
/// differences of successive runs fall by four (a ratio of 3.73 is the order 1.9). Explicit steps take mass damping at the
/// end of the step; strain-rate damping lags by half a step there and makes them of first order, as documented, like γ
/// above ½ does with Newmark. The implicit schemes have one limit.
#[test]
#[ignore = "long"]
fn positions_and_velocities_of_large_motions_converge_at_the_order_of_the_scheme() {
    let free = soft_plate();
    let damped = |mass, stiffness| Model { damping: Damping { mass, stiffness }, ..soft_plate() };
    let (both, mass_alone, strain_rate) = (damped(0.5, 2e-3), damped(0.5, 0.0), damped(0.0, 2e-3));
    let (second, first) = (3.73..4.3, 1.8..2.4);
    let damped_newmark = Scheme::Newmark(NewmarkScheme { beta: 0.36, gamma: 0.7 });
    let mut limit: Option<State> = None;
    for (scheme, m, expected) in [
        (NEWMARK, &free, &second),
        (HHT, &free, &second),
        (ENERGY_MOMENTUM, &free, &second),
        (GENERALIZED_ALPHA, &free, &second),
        (GENERALIZED_ALPHA, &both, &second),
        (BDF2, &free, &second),
        (BDF2, &both, &second),
        (damped_newmark, &free, &first),
        (EXPLICIT, &free, &second),
        (NEWMARK, &both, &second),
        (HHT, &both, &second),
        (ENERGY_MOMENTUM, &both, &second),
        (EXPLICIT, &mass_alone, &second),
        (EXPLICIT, &strain_rate, &first),
    ] {
        let end = 0.256;
        let run = |steps: u32, linear: bool| {
            let o = TransientAnalysis { linear, ..options(scheme, end, Some(end / f64::from(steps))) };
            let state = move_in_time(m, &o, &mut Notes::default()).1.state;
            assert_eq!(state.step, u64::from(steps), "{scheme:?}");
            state
        };
        let states: Vec<State> = (0..5).map(|k| run(128 << k, false)).collect();
        for (name, field) in [("position", (|s| &s.u) as fn(&State) -> &Vec<Nodal>), ("velocity", |s| &s.v)] {
            let differences: Vec<f64> =
                states.windows(2).map(|w| distance(field(&w[0]), field(&w[1]))).collect();
            let ratios: Vec<f64> = differences.windows(2).map(|w| w[0] / w[1]).collect();
            println!("{scheme:?} {:?}, {name}: {ratios:?}", m.damping);
            assert!(ratios.iter().all(|r| expected.contains(r)), "{scheme:?}, {name}: {ratios:?}");
        }
        if scheme == NEWMARK {
            limit = Some(states[4].clone());
        } else if let (HHT | ENERGY_MOMENTUM | GENERALIZED_ALPHA, Some(limit)) = (scheme, &limit)
            && m.damping == free.damping
        {
            let [coarse, fine] = [0, 4].map(|i| distance(&states[i].u, &limit.u));
            assert!(fine < 0.01 * coarse, "{scheme:?}: {fine:e} from the limit of Newmark, {coarse:e}");
        }
        let (large, linear) = (&states[0].u, run(128, true).u);
        let size = distance(large, &vec![[0.0; 3]; large.len()]);
        assert!(distance(large, &linear) > 0.1 * size, "{scheme:?}: the motion is nearly linear");
    }
}

/// A strip of one element that stretches along x only: one degree of freedom with the circular frequency
/// ω = √(3 E/ρ)/L of linear interpolation with consistent mass.
fn oscillator(damping: &Damping) -> (Model, f64) {
    let (young, density) = (4e4, 1e3);
    let mut m = with_material(model(plate([1.0, 0.5], [1, 1], 0.0), young, 0.1), young, 0.0, density);
    let fix = |on: &str, position: Vec<Axis>| {
        Condition::Fix(FixComponents { on: on.into(), position, director: vec![Axis::X, Axis::Y, Axis::Z] })
    };
    m.conditions = vec![fix("u_min", vec![Axis::X, Axis::Y, Axis::Z]), fix("u_max", vec![Axis::Y, Axis::Z])];
    m.initial_velocities = vec![InitialVelocity {
        on: "u_max".into(),
        velocity: [1.0, 0.0, 0.0],
        angular_velocity: [0.0; 3],
        center: [0.0; 3],
    }];
    m.damping = damping.clone();
    (m, (3.0 * young / density).sqrt())
}

/// Displacements, velocities and accelerations of the oscillator's free edge at every step.
fn history(m: &Model, o: &TransientAnalysis) -> Vec<[f64; 3]> {
    let mut notes = Notes::keeping();
    let (system, _) = move_in_time(m, &TransientAnalysis { linear: true, ..o.clone() }, &mut notes);
    let v = system.coordinates.position_of[1] as usize;
    assert_eq!(system.coordinates.reference[v][0], 1.0);
    notes.states.iter().map(|s| [s.u[v][0], s.v[v][0], s.a[v][0]]).collect()
}

/// The formulas of N. M. Newmark (1959) and H. M. Hilber, T. J. R. Hughes, R. L. Taylor (1977) for
/// ü + 2 ξ ω u̇ + ω² u = 0, solved for the acceleration: `alpha` ≤ 0 is that of HHT.
fn recurrence(
    [omega, xi]: [f64; 2],
    [beta, gamma, alpha]: [f64; 3],
    dt: f64,
    [mut u, mut v, mut a]: [f64; 3],
    steps: usize,
) -> Vec<[f64; 3]> {
    let (k, c) = (omega * omega, 2.0 * xi * omega);
    let mut out = vec![[u, v, a]];
    for _ in 0..steps {
        let (u_free, v_free) = (u + dt * v + dt * dt * (0.5 - beta) * a, v + dt * (1.0 - gamma) * a);
        let known = (1.0 + alpha) * (k * u_free + c * v_free) - alpha * (k * u + c * v);
        a = -known / (1.0 + (1.0 + alpha) * (k * beta * dt * dt + c * gamma * dt));
        (u, v) = (u_free + beta * dt * dt * a, v_free + gamma * dt * a);
        out.push([u, v, a]);
    }
    out
}

#[test]
fn newmark_and_hht_repeat_their_published_recurrences_on_an_oscillator() {
    let stiffness = 8e-3;
    for damping in [Damping::default(), Damping { mass: 0.0, stiffness }] {
        let (m, omega) = oscillator(&damping);
        let xi = 0.5 * damping.stiffness * omega;
        let newmark = |beta, gamma| (Scheme::Newmark(NewmarkScheme { beta, gamma }), [beta, gamma, 0.0]);
        let hht = |alpha: f64| {
            let parameters = [0.25 * (1.0 - alpha) * (1.0 - alpha), 0.5 - alpha, alpha];
            (Scheme::Hht(HhtScheme { alpha }), parameters)
        };
        let schemes = [
            newmark(0.25, 0.5),
            newmark(0.3, 0.5),
            newmark(0.36, 0.7),
            hht(-0.05),
            hht(-0.1),
            hht(-1.0 / 3.0),
        ];
        for (scheme, parameters) in schemes {
            for phase in [0.1, 1.0, 5.0] {
                let dt = phase / omega;
                let found = history(&m, &options(scheme, 50.0 * dt, Some(dt)));
                let expected = recurrence([omega, xi], parameters, dt, found[0], found.len() - 1);
                assert!(found.len() == 51 && found[0][1] == 1.0);
                let scale = [1.0 / omega, 1.0, omega];
                for (step, (f, e)) in found.iter().zip(&expected).enumerate() {
                    for i in 0..3 {
                        let error = (f[i] - e[i]).abs() / scale[i];
                        assert!(error < 1e-11, "{scheme:?} ωΔt {phase}, step {step}, {i}: {error:e}");
                    }
                }
            }
        }
    }
}

/// ρ∞ = (1 + α)/(1 − α) of HHT: what a step leaves of a mode that is far too fast for it.
#[test]
fn hht_damps_unresolved_modes_by_its_spectral_radius() {
    let (m, omega) = oscillator(&Damping::default());
    let dt = 1e4 / omega;
    for alpha in [-0.05, -0.1, -1.0 / 3.0] {
        let found = history(&m, &options(Scheme::Hht(HhtScheme { alpha }), 400.0 * dt, Some(dt)));
        // The norm of displacement and Δt² acceleration goes with n ρⁿ at the double root.
        let size = |n: usize| (found[n][0].powi(2) + (dt * dt * found[n][2]).powi(2)).sqrt();
        let radius = (size(400) / size(200)).powf(1.0 / 200.0);
        let exact = (1.0 + alpha) / (1.0 - alpha);
        println!("α = {alpha}: {radius} for {exact}");
        assert!((radius / exact - 1.0).abs() < 0.01, "α = {alpha}: {radius} for {exact}");
    }
}

/// Free vibration u = v₀/ω_d exp(−ξωt) sin ω_d t with ξ = β ω/2 by Rayleigh's factor β of the stiffness, ξ = α/(2ω) by
/// that of the mass.
#[test]
fn rayleigh_damping_is_that_of_the_closed_form() {
    let xi = 0.05;
    let (_, omega) = oscillator(&Damping::default());
    let stiffness = Damping { mass: 0.0, stiffness: 2.0 * xi / omega };
    let mass = Damping { mass: 2.0 * xi * omega, stiffness: 0.0 };
    for damping in [stiffness, mass] {
        let (m, _) = oscillator(&damping);
        let damped = omega * (1.0 - xi * xi).sqrt();
        let dt = 0.01 / omega;
        for scheme in [NEWMARK, HHT, ENERGY_MOMENTUM, GENERALIZED_ALPHA] {
            let found = history(&m, &options(scheme, 3000.0 * dt, Some(dt)));
            for (n, f) in found.iter().enumerate() {
                let t = n as f64 * dt;
                let exact = (-xi * omega * t).exp() * (damped * t).sin() / damped;
                let error = (f[0] - exact).abs() * damped;
                // The schemes lag by about (ωΔt)²/12 · ωt. Damping that is 10 % low is 0.04 off.
                assert!(error < 3e-4, "{damping:?} {scheme:?} at {t}: {error:e}");
            }
        }
    }
}

/// A soft, thick, clamped plate that turns: a few milliseconds resolve all of its motion.
fn soft_plate() -> Model {
    let mut m = with_material(model(plate([1.0, 1.0], [2, 2], 0.2), 1e5, 0.5), 1e5, 0.3, 1e3);
    m.loads = vec![Load::Gravity(GravityLoad { value: [2.0, 1.0, -9.81], amplitude: None })];
    m.initial_velocities = vec![InitialVelocity {
        on: "all".into(),
        velocity: [0.0; 3],
        angular_velocity: [0.3, 2.0, 0.0],
        center: [0.0; 3],
    }];
    m
}

/// The energy–momentum scheme takes loads at the middle of a step: second order also where they change with time.
#[test]
fn schemes_are_of_second_order_under_loads_that_change_with_time() {
    let amplitude = || Some("wave".to_string());
    let dead = Load::Edge(VectorLoad { amplitude: amplitude(), ..vector_load("u_max", [4e3, 0.0, 6e3]) });
    let pressure = Load::Pressure(PressureLoad {
        on: "all".into(),
        value: 9e3,
        amplitude: amplitude(),
        distribution: None,
    });
    let moment =
        Load::EdgeMoment(VectorLoad { amplitude: amplitude(), ..vector_load("u_max", [0.0, 3e2, 0.0]) });
    for (name, load) in [("dead", dead), ("pressure", pressure), ("moment", moment)] {
        let mut m = soft_plate();
        let expression = ExpressionAmplitude { expression: "sin(20*t)+0.5*t".into() };
        m.amplitudes.insert("wave".into(), Amplitude::Expression(expression));
        m.loads = vec![load];
        let at = |scheme, steps: u32| {
            let o = options(scheme, 0.256, Some(0.256 / f64::from(steps)));
            move_in_time(&m, &o, &mut Notes::default()).1.state
        };
        let exact = at(NEWMARK, 2048);
        for scheme in [NEWMARK, HHT, ENERGY_MOMENTUM] {
            let error = |steps| distance(&at(scheme, steps).u, &exact.u);
            let ratio = error(64) / error(128);
            println!("{name} {scheme:?}: {ratio}");
            assert!((3.7..4.3).contains(&ratio), "{name} {scheme:?}: {ratio}");
        }
    }
}

/// One step of a scheme from a state, and the error that it estimates.
fn step(system: &System, scheme: Scheme, state: &State, dt: f64) -> (State, f64) {
    let mut scheme = scheme.integrator(system).unwrap();
    let mut newton = Newton::new(system, None).unwrap();
    newton.restore(system, state, true);
    let mut end = state.clone();
    scheme.begin(system, &mut newton.assembly, state, Span { dt, end: state.time + dt });
    let tolerances = scheme.tolerances(30);
    newton.solve(system, scheme.as_mut(), &state.history, &tolerances, &mut Silent).unwrap();
    let error = scheme.local_error(system, &mut newton, state);
    scheme.close_rates(system, &mut newton);
    scheme.finish(system, &mut end);
    (end, error)
}

/// The estimate of the local error of position is the error of a step as that goes to zero: Newmark's leading term, that
/// of the midpoint rule, and for HHT, whose accelerations lag, at least the error and at most twice it.
#[test]
fn local_errors_are_estimated_as_they_are() {
    let m = soft_plate();
    let (dt, before) = (5e-4, 0.05);
    for (scheme, most) in [(NEWMARK, 1.15), (HHT, 2.0), (ENERGY_MOMENTUM, 1.15), (BDF2, 1.15)] {
        // A smooth state with the acceleration of the scheme, from short steps; the last one is as long as the next.
        let (system, outcome) = move_in_time(&m, &options(scheme, before, Some(dt)), &mut Notes::default());
        let start = outcome.state;
        let (end, estimate) = step(&system, scheme, &start, dt);
        let mut exact = start.clone();
        if let Scheme::EnergyMomentum(_) = scheme {
            // Its accelerations are means over steps; those of the state itself come from a very short step.
            let (short, _) = step(&system, scheme, &start, 1e-3 * dt);
            exact.a = short.a;
        }
        for _ in 0..64 {
            exact = step(&system, NEWMARK, &exact, dt / 64.0).0;
            exact.time += dt / 64.0;
        }
        let error = system.position_rms(|v| std::array::from_fn(|i| end.u[v][i] - exact.u[v][i]));
        println!("{scheme:?}: {estimate:e} for {error:e}: {}", estimate / error);
        assert!((0.85..most).contains(&(estimate / error)), "{scheme:?}: {estimate:e} for {error:e}");
    }
}

/// With steps that keep the local error at the tolerance, an eighth of it takes twice the steps and leaves a quarter of
/// the error at the end.
#[test]
fn automatic_steps_keep_the_error_in_proportion_to_the_tolerance() {
    let m = soft_plate();
    let exact = move_in_time(&m, &options(NEWMARK, 0.3, Some(0.3 / 8192.0)), &mut Notes::default()).1.state;
    for scheme in [NEWMARK, HHT, ENERGY_MOMENTUM, BDF2] {
        let run = |tolerance: f64| {
            let o = TransientAnalysis { tolerance, ..options(scheme, 0.3, None) };
            let (_, outcome) = move_in_time(&m, &o, &mut Notes::default());
            (outcome.statistics.steps as f64, distance(&outcome.state.u, &exact.u))
        };
        let (coarse, fine) = (run(8e-6), run(1e-6));
        println!("{scheme:?}: {coarse:?} {fine:?}");
        assert!((1.7..2.4).contains(&(fine.0 / coarse.0)), "{scheme:?}: {coarse:?} {fine:?}");
        assert!((2.5..6.5).contains(&(coarse.1 / fine.1)), "{scheme:?}: {coarse:?} {fine:?}");
    }
}
