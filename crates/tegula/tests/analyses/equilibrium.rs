//! Residual, tangent and mass as functions of a state.

use crate::common::{Notes, Random, compile, model, move_in_time, plate, solve, vector_load};
use crate::multibody::{body, machine, spherical};
use tegula::analysis::State;
use tegula::analysis::equilibrium::{constraints, frames, mass, moved, residual, tangent};
use tegula::element::Nodal;
use tegula::model::*;
use tegula::norm::max_norm;

fn loaded(element: ElementKind) -> Model {
    let mut m = model(plate([1.0, 0.6], [4, 3], 0.2), 1e6, 0.05);
    m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(1e6, 0.3, 500.0)));
    m.sections[0].element = element;
    m.loads = vec![
        Load::Edge(vector_load("u_max", [0.0, 0.0, 30.0])),
        Load::Pressure(PressureLoad { on: "all".into(), value: 20.0, amplitude: None, distribution: None }),
    ];
    m
}

#[test]
fn residual_vanishes_at_equilibria_and_in_motion() {
    for element in [ElementKind::Ems, ElementKind::Mitc4, ElementKind::SolidShell] {
        let (_, system, outcome) = solve(&loaded(element));
        let at_rest = State { time: 1.0, ..State::at_rest(&system) };
        let loads = max_norm(residual(&system, &at_rest));
        let left = max_norm(residual(&system, &outcome.state));
        assert!(loads > 0.1 && left < 1e-7 * loads, "{element:?}: {left:e} of {loads:e}");
        let newmark = Scheme::Newmark(NewmarkScheme { beta: 0.25, gamma: 0.5 });
        let options =
            TransientAnalysis { scheme: newmark, time_step: Some(1e-3), ..TransientAnalysis::new(0.02) };
        let (system, moved) = move_in_time(&loaded(element), &options, &mut Notes::default());
        let left = max_norm(residual(&system, &moved.state));
        assert!(left < 1e-4 * loads, "{element:?} in motion: {left:e} of {loads:e}");
    }
}

/// The tangent is symmetric: it is compared with the symmetric part of the differences.
#[test]
fn tangent_is_the_derivative_of_the_residual() {
    for element in [ElementKind::Ems, ElementKind::Cm] {
        let (_, system, outcome) = solve(&loaded(element));
        let state = outcome.state;
        let (pattern, values) = tangent(&system, &state).unwrap();
        let mut random = Random::new(7);
        let mut direction = || {
            let mut field: Vec<Nodal> = (0..system.vectors()).map(|_| random.vector().into()).collect();
            let mut free = vec![0.0; system.unknowns()];
            frames(&system, &state).reduce(&field, &mut free);
            frames(&system, &state).expand(&free, &mut field);
            (field, free)
        };
        let (x, y) = (direction(), direction());
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let difference = |along: &[Nodal], of: &[f64]| {
            let at = |h: f64| {
                let mut moved = state.clone();
                for (u, d) in moved.u.as_flattened_mut().iter_mut().zip(along.as_flattened()) {
                    *u += h * d;
                }
                dot(&residual(&system, &moved), of)
            };
            (at(-1e-6) - at(1e-6)) / 2e-6
        };
        let mut product = vec![0.0; system.unknowns()];
        pattern.add_product(&values, &x.1, &mut product);
        let found = dot(&product, &y.1);
        let exact = 0.5 * (difference(&x.0, &y.1) + difference(&y.0, &x.1));
        assert!((found - exact).abs() < 1e-6 * max_norm(&product), "{element:?}: {found} for {exact}");
    }
}

#[test]
fn mass_is_that_of_the_kinetic_energy() {
    let (_, system) = compile(&loaded(ElementKind::Ems));
    let state = State::at_rest(&system);
    let (pattern, _) = tangent(&system, &state).unwrap();
    let values = mass(&system, &state).unwrap();
    let mut random = Random::new(3);
    let free: Vec<f64> = (0..system.unknowns()).map(|_| random.next()).collect();
    let mut velocity = vec![[0.0; 3]; system.vectors()];
    frames(&system, &state).expand(&free, &mut velocity);
    let mut product = vec![0.0; free.len()];
    pattern.add_product(&values, &free, &mut product);
    let twice: f64 = product.iter().zip(&free).map(|(a, b)| a * b).sum();
    approx::assert_relative_eq!(0.5 * twice, system.kinetic_energy(&velocity), max_relative = 1e-12);
}

/// A chain of two bodies on spherical joints, one of them to the ground.
fn chain() -> Model {
    let bodies = vec![
        body("a", [1.0, 0.0, 0.0], 2.0, Some([0.1, 0.2, 0.3])),
        body("b", [3.0, 0.0, 0.0], 1.0, Some([0.1; 3])),
    ];
    let joints = vec![spherical("ground", "a", [0.0; 3]), spherical("a", "b", [2.0, 0.0, 0.0])];
    machine(0.1, 1e-2, bodies, joints)
}

/// Behind an increment bodies are where the exponential map turns them, and gradients are the derivatives of the constraints.
#[test]
fn constraints_have_their_gradients_and_bodies_turn() {
    let (_, system) = compile(&chain());
    let start = State::at_rest(&system);
    let along = |state: &State, x: &[f64], h: f64| {
        let increment: Vec<f64> = x.iter().map(|x| h * x).collect();
        State { u: moved(&system, state, &increment), ..state.clone() }
    };
    let mut quarter = vec![0.0; system.unknowns()];
    let directors = system.coordinates.bodies[0].directors.unwrap();
    quarter[system.dofs().of(directors[0] as usize)[2] as usize] = std::f64::consts::FRAC_PI_2;
    let turned = along(&start, &quarter, 1.0);
    let now = |v: u32, i: usize| system.coordinates.reference[v as usize][i] + turned.u[v as usize][i];
    let found = [0, 1, 2].map(|d| [0, 1, 2].map(|i| now(directors[d], i)));
    let expected = [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    for (found, expected) in found.as_flattened().iter().zip(expected.as_flattened()) {
        approx::assert_abs_diff_eq!(found, expected, epsilon = 1e-15);
    }
    // The body has turned about its mass centre by a quarter, and both of its joints are open by what its arms have moved.
    let values: Vec<f64> = constraints(&system, &turned).into_iter().map(|(value, _)| value.abs()).collect();
    for (found, expected) in values.iter().zip([1.0, 1.0, 0.0, 1.0, 1.0, 0.0]) {
        approx::assert_abs_diff_eq!(found, &expected, epsilon = 1e-15);
    }
    let mut random = Random::new(5);
    let x: Vec<f64> = (0..system.unknowns()).map(|_| random.next()).collect();
    let [behind, ahead] = [-1e-6, 1e-6].map(|h| constraints(&system, &along(&turned, &x, h)));
    for (i, (_, gradient)) in constraints(&system, &turned).iter().enumerate() {
        let product: f64 = gradient.iter().map(|(number, g)| g * x[*number as usize]).sum();
        approx::assert_relative_eq!(product, (ahead[i].0 - behind[i].0) / 2e-6, max_relative = 1e-8);
    }
}

#[test]
fn states_of_other_systems_do_not_fit() {
    let (_, system) = compile(&chain());
    let state = State::at_rest(&system);
    assert_eq!(state.misfit(&system), None);
    assert_eq!(State { multipliers: vec![0.0; 5], ..state.clone() }.misfit(&system), Some("multipliers"));
    assert_eq!(State { v: vec![[0.0; 3]; 1], ..state.clone() }.misfit(&system), Some("v"));
    let (_, other) = compile(&loaded(ElementKind::Ems));
    assert_eq!(state.misfit(&other), Some("u"));
}

#[test]
fn states_are_written_and_read_without_loss() {
    let (_, _, outcome) = solve(&loaded(ElementKind::Ems));
    let text = serde_json::to_string(&outcome.state).unwrap();
    assert_eq!(serde_json::from_str::<State>(&text).unwrap(), outcome.state);
}

#[test]
fn systems_without_a_tangent_are_refused() {
    let mut m = loaded(ElementKind::Ems);
    let scheme = Scheme::Explicit(ExplicitScheme::default());
    m.analysis = Analysis::Transient(TransientAnalysis { scheme, ..TransientAnalysis::new(0.1) });
    let (_, system) = compile(&m);
    let state = State::at_rest(&system);
    assert!(tangent(&system, &state).is_err() && mass(&system, &state).is_err());
}
