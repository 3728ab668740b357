//! Complex modes under follower loads without a potential: flutter and divergence against characteristic equations.

use nalgebra::{Complex, DMatrix, DVector};
use tegula::System;
use tegula::analysis::modal::{self, Mode};
use tegula::analysis::path::{self, CriticalKind};
use tegula::analysis::{Silent, State, equilibrium};
use tegula::model::*;

use crate::common::{Notes, compile, solve};
use crate::patches::{LENGTH as LENGTH_OF_STRIP, clamped, derivative_of_residual, hub, strip};

/// Length, thickness and mass per length of a column of unit bending stiffness in its soft plane.
const LENGTH: f64 = 1.0;
const THICKNESS: f64 = 0.01;
const MASS: f64 = 1.0;

/// A cantilever of beams on a joint, or of shells that a support clamps, under a force along its end.
fn beck(force: f64, wanted: u32, shells: bool) -> Model {
    let (width, h) = (10.0 * THICKNESS, THICKNESS);
    let young = 12.0 / (width * h.powi(3));
    let (parts, load) = if shells {
        let strip = format!(
            r#""mesh": {{ "type": "plate", "size": [{LENGTH}, {width}], "grid": {{ "elements": [60, 1] }} }},
               "sections": [{{ "material": "m", "thickness": {h} }}], "conditions": [{{ "type": "clamp", "on": "u_min" }}]"#
        );
        (strip, format!(r#""on": "u_max", "value": [{}, 0, 0]"#, -0.5 * force))
    } else {
        let beam = format!(
            r#""beams": [{{ "name": "column", "points": [[0, 0, 0], [{LENGTH}, 0, 0]], "elements": 60, "direction": [0, 1, 0],
                            "section": {{ "type": "rectangle", "size": [{width}, {h}] }}, "material": "m" }}],
               "joints": [{{ "type": "fixed", "name": "root", "between": ["ground", "column.start"], "at": [0, 0, 0] }}]"#
        );
        (beam, format!(r#""on": "column.end", "value": [{}, 0, 0]"#, -force))
    };
    let text = format!(
        r#"{{ "materials": {{ "m": {{ "type": "isotropic", "young": {young}, "poisson": 0.0, "density": {} }} }}, {parts},
            "loads": [{{ "type": "follower-force", {load} }}],
            "analysis": {{ "type": "modal", "modes": {wanted}, "prestressed": true }} }}"#,
        MASS / (width * h)
    );
    serde_json::from_str(&text).unwrap()
}

fn modes(m: &Model, notes: &mut Notes) -> Vec<Mode> {
    let (_, system) = compile(m);
    let Analysis::Modal(options) = &m.analysis else { panic!("no modal analysis") };
    let state: State = modal::prestress(&system, &mut Silent).unwrap().state;
    modal::run(&system, options.modes as usize, Some(&state), notes).unwrap().modes
}

/// Root of Beck's characteristic equation next to a complex circular frequency: with p = P L²/EI and Ω = ω L² √(m/EI), λ₁,₂² = √(p²/4 + Ω²) ± p/2,
/// `p² + 2 Ω² (1 + cos λ₁ cosh λ₂) + p Ω sin λ₁ sinh λ₂ = 0` (M. Beck, ZAMP 3 (1952) 225–228; V. V. Bolotin, *Nonconservative problems of the theory of
/// elastic stability*, 1963, Sect. 2.2).
fn root(p: f64, near: Complex<f64>) -> Complex<f64> {
    let equation = |omega: Complex<f64>| {
        let middle = (omega * omega + p * p / 4.0).sqrt();
        let [a, b] = [p / 2.0, -p / 2.0].map(|half| (middle + half).sqrt());
        omega * omega * 2.0 * (a.cos() * b.cosh() + 1.0) + omega * p * a.sin() * b.sinh() + p * p
    };
    let mut omega = near;
    for _ in 0..50 {
        let h = 1e-6 * omega.norm();
        let slope = (equation(omega + h) - equation(omega - h)) / (2.0 * h);
        omega -= equation(omega) / slope;
    }
    omega
}

/// Frequencies and growth rates of Beck's column, before and behind the load 20.05 EI/L² at which its two lowest ones meet.
#[test]
fn a_column_under_a_follower_force_flutters_as_that_of_beck() {
    let loads = [4.0, 15.0, 19.9, 20.2, 25.0];
    for (force, shells) in loads.into_iter().flat_map(|force| [(force, false), (force, true)]) {
        let mut notes = Notes::default();
        let found = modes(&beck(force, 2, shells), &mut notes);
        let flutters = force > 20.05;
        assert_eq!(
            notes.warnings.iter().any(|text| text.contains("flutter")),
            flutters,
            "{force} {notes:?}",
            notes = notes.warnings
        );
        for (number, mode) in found.iter().enumerate() {
            let growth = mode.complex.as_ref().unwrap().growth;
            // The motion e^{(growth + iω)t} is that of e^{iΩt}.
            let omega = Complex::new(mode.omega, -growth);
            let exact = root(force, omega);
            println!("{force} {number}: {omega} {exact}");
            assert!((omega - exact).norm() < 4e-3 * exact.norm(), "{force} {number}: {omega} {exact}");
            assert_eq!(growth != 0.0, flutters, "{force}: {growth}");
        }
        assert!(
            !flutters
                || (found[0].complex.as_ref().unwrap().growth + found[1].complex.as_ref().unwrap().growth)
                    .abs()
                    < 1e-6
        );
    }
}

/// Eigenvalues λ = ω² of `J φ = λ M φ` with the derivative J of the residual by differences, by a dense solver, ascending in the absolute value.
fn dense(system: &System, state: &State) -> Vec<Complex<f64>> {
    let columns = derivative_of_residual(system, state);
    let (n, frames) = (columns.len(), equilibrium::frames(system, state));
    let stiffness = DMatrix::from_fn(n, n, |i, j| columns[j][i]);
    let mass = DMatrix::from_columns(&Vec::from_iter((0..n).map(|j| {
        let (mut free, mut column) = (vec![0.0; n], vec![0.0; n]);
        free[j] = 1.0;
        let [mut moved, mut forces] = [vec![[0.0; 3]; system.vectors()], vec![[0.0; 3]; system.vectors()]];
        frames.expand(&free, &mut moved);
        system.pattern.add_mass_product(1.0, &moved, &mut forces);
        frames.reduce(&forces, &mut column);
        DVector::from_vec(column)
    })));
    let inverse = stiffness.lu().solve(&mass).unwrap();
    let mut found: Vec<Complex<f64>> = inverse.complex_eigenvalues().iter().map(|mu| mu.inv()).collect();
    found.sort_by(|a, b| a.norm().total_cmp(&b.norm()));
    found
}

/// Modes under a pressure on a sheet with free edges, and under a moment that is constant in space on the rigid end of a strip, are those of the derivative of
/// the residual: two motions e^{±(growth + iω)t} belong to a complex eigenvalue λ = −(growth + iω)².
#[test]
fn modes_under_loads_without_potential_are_those_of_the_whole_tangent() {
    let mut pressed = strip(ElementKind::Ems, [8, 2], 0.0);
    pressed.conditions = vec![clamped("u_min")];
    let pressure =
        |value| Load::Pressure(PressureLoad { on: "all".into(), value, amplitude: None, distribution: None });
    let mut turned = pressed.clone();
    turned.bodies = vec![hub("tip", [LENGTH_OF_STRIP, 0.1, 0.0], &["u_max"])];
    turned.loads = vec![Load::Moment(VectorLoad::new("tip", [0.6, 0.5, 0.0]))];
    pressed.loads = vec![pressure(30.0)];
    let mut heavily = pressed.clone();
    heavily.loads = vec![pressure(100.0)];
    let wanted = 6;
    for (name, m) in [("pressure", pressed), ("heavy pressure", heavily), ("moment", turned)] {
        let (_, system, outcome) = solve(&m);
        let found = modal::run(&system, wanted, Some(&outcome.state), &mut Notes::default()).unwrap().modes;
        let exact = dense(&system, &outcome.state);
        assert!(found.iter().all(|mode| mode.complex.is_some()), "{name}: the loads do not matter");
        for (mode, exact) in found.iter().zip(&exact) {
            let rate = Complex::new(mode.complex.as_ref().unwrap().growth, mode.omega);
            let lambda = -(rate * rate);
            let [first, second] = [lambda, lambda.conj()].map(|lambda| (lambda - exact).norm());
            let error = if first < second { first } else { second };
            println!("{name}: {lambda} {exact}");
            assert!(error < 1e-5 * exact.norm(), "{name}: {lambda} {exact}");
        }
    }
}

/// The path of Beck's column has one critical point, the onset of flutter at 20.05 EI/L², which a warning tells, too, and at which it may end.
#[test]
fn a_path_locates_the_onset_of_flutter() {
    for (shells, end_at) in [(false, None), (true, None), (false, Some(PathEnd::Flutter))] {
        let mut m = beck(25.0, 2, shells);
        let options = PathAnalysis { end_load: 1.0, end_at, ..PathAnalysis::default() };
        m.analysis = Analysis::Path(options.clone());
        let (_, system) = compile(&m);
        let mut notes = Notes::default();
        let outcome = path::run(&system, &options, None, &mut notes).unwrap();
        let path = outcome.state.path.unwrap();
        let [onset] = &path.critical[..] else { panic!("{:?}", path.critical.len()) };
        println!("{} {:?}", 25.0 * onset.load, notes.warnings);
        assert_eq!((onset.kind, onset.change), (CriticalKind::Flutter, 0));
        assert!((25.0 * onset.load / 20.051 - 1.0).abs() < 1e-3, "{}", 25.0 * onset.load);
        assert!((system.norm(&onset.mode) - 1.0).abs() < 1e-12);
        let told: Vec<_> = notes.warnings.iter().filter(|text| text.contains("flutter")).collect();
        let place = format!("at load factor {:.6}", onset.load);
        if end_at.is_some() {
            assert!((outcome.state.time - onset.load).abs() < 1e-6 * onset.load && path.finished);
        } else {
            assert!(path.flutters && told.len() == 1 && told[0].contains(&place), "{told:?} {place}");
        }
    }
}

/// The response to inputs about an equilibrium with complex modes is refused, also where the loads are moments on bodies.
#[test]
fn responses_under_loads_without_potential_are_refused() {
    let mut turned = strip(ElementKind::Ems, [8, 2], 0.0);
    turned.conditions = vec![clamped("u_min")];
    turned.bodies = vec![hub("tip", [LENGTH_OF_STRIP, 0.1, 0.0], &["u_max"])];
    turned.loads = vec![Load::Moment(VectorLoad::new("tip", [0.6, 0.5, 0.0]))];
    let (_, system, outcome) = solve(&turned);
    let mut options = ModalAnalysis::new(4);
    options.inputs = vec![ResponseInput { name: "moment".into(), loads: turned.loads.clone() }];
    let refused = modal::run_with_inputs(&system, &options, Some(&outcome.state), &mut Notes::default());
    assert!(refused.unwrap_err().to_string().contains("no potential"));
}

/// A steel column of beams under a force along its end in units of length: frequencies and growth rates of the two lowest modes in its soft plane.
fn column_in_units(unit: f64) -> Vec<[f64; 2]> {
    let [young, density, length, side] = [2.1e11 / unit, 7850.0 / unit.powi(3), unit, 0.01 * unit];
    let force = 25.0 * 2.1e11 * 1e-8 / 12.0 * unit;
    let text = format!(
        r#"{{ "materials": {{ "steel": {{ "type": "isotropic", "young": {young:e}, "poisson": 0.3, "density": {density:e} }} }},
            "beams": [{{ "name": "column", "points": [[0, 0, 0], [{length}, 0, 0]], "elements": 40, "direction": [0, 1, 0],
                         "section": {{ "type": "rectangle", "size": [{side}, {side}] }}, "material": "steel" }}],
            "joints": [{{ "type": "fixed", "name": "root", "between": ["ground", "column.start"], "at": [0, 0, 0] }}],
            "loads": [{{ "type": "follower-force", "on": "column.end", "value": [{}, 0, 0] }}],
            "analysis": {{ "type": "modal", "modes": 4, "prestressed": true }} }}"#,
        -force
    );
    let found = modes(&serde_json::from_str(&text).unwrap(), &mut Notes::default());
    found.iter().map(|mode| [mode.omega, mode.complex.as_ref().unwrap().growth]).collect()
}

/// In millimetres a column under a follower force is found to be in equilibrium as in metres, with the same modes. Both planes of its square section flutter.
#[test]
fn flutter_does_not_depend_on_the_unit_of_length() {
    let [metres, millimetres] = [1.0, 1e3].map(column_in_units);
    for (a, b) in metres.iter().zip(&millimetres) {
        assert!((a[0] - b[0]).abs() < 1e-6 * a[0] && (a[1] - b[1]).abs() < 1e-5 * a[0], "{a:?} {b:?}");
    }
    assert_eq!(metres.iter().filter(|mode| mode[1] > 0.0).count(), 2, "{metres:?}");
}

/// A shaft under an axial moment that is constant in space is unstable from the smallest moment on (H. Ziegler, *Principles of structural stability*, 1968,
/// Sect. 4.2): its growth rate is proportional to the moment, however little this changes the frequencies.
#[test]
fn a_shaft_under_an_axial_moment_flutters_from_the_smallest_moment_on() {
    let growth = |moment: f64| {
        let mut m = beck(0.0, 2, false);
        let [width, h] = [THICKNESS; 2];
        m.beams[0].section = BeamSection::Rectangle(RectangularSection { size: [width, h] });
        if let Some(Material::Isotropic(material)) = m.materials.values_mut().next() {
            (material.young, material.density) = (12.0 / (width * h.powi(3)), MASS / (width * h));
        }
        m.loads = vec![Load::Moment(VectorLoad::new("column.end", [moment, 0.0, 0.0]))];
        let mut notes = Notes::default();
        let found = modes(&m, &mut notes);
        assert!(notes.warnings.iter().any(|text| text.contains("flutter")), "{moment} {:?}", notes.warnings);
        found[0].complex.as_ref().unwrap().growth / moment
    };
    let [small, large] = [1e-4, 1e-2].map(growth);
    assert!(small > 0.5 && (small / large - 1.0).abs() < 0.01, "{small} {large}");
}

/// A path that begins in flutter and takes the load back says so at its start, and where the flutter ends.
#[test]
fn a_path_that_begins_in_flutter_says_so() {
    let mut m = beck(25.0, 2, false);
    let load = std::mem::take(&mut m.loads);
    let options = PathAnalysis { end_load: 1.0, ..PathAnalysis::default() };
    let steps = r#"[{ "name": "up", "analysis": { "type": "path" } }, { "name": "down", "analysis": { "type": "path" } }]"#;
    m.steps = serde_json::from_str(steps).unwrap();
    m.steps[0].loads = load;
    let (mesh, _) = compile(&beck(25.0, 2, false));
    let compiler = tegula::compile::Compiler::new(&m, &mesh).unwrap();
    let up = path::run(&compiler.system(0, None).unwrap(), &options, None, &mut Notes::default()).unwrap();
    let system = compiler.system(1, Some(up.state.end_of_step())).unwrap();
    let mut notes = Notes::default();
    let down = path::run(&system, &options, None, &mut notes).unwrap();
    assert!(!down.state.path.unwrap().flutters);
    assert_eq!(notes.warnings.len(), 1, "{:?}", notes.warnings);
    assert!(notes.warnings[0].contains("the path begins at an equilibrium that is unstable by flutter"));
    assert!(
        notes.events.iter().any(|event| event.contains("vibrations about the equilibria no longer grow")),
        "{:?}",
        notes.events
    );
}

/// The onset is located wherever the steps of the path end: next to it the two eigenvalues are nearly one, and their imaginary parts round-off.
#[test]
fn the_onset_of_flutter_does_not_depend_on_the_steps_of_the_path() {
    let loads = [21.0, 25.0, 29.0, 35.0, 40.0, 50.0].map(|force| {
        let mut m = beck(force, 2, false);
        m.beams[0].elements = Some(16);
        let options =
            PathAnalysis { end_load: 1.0, end_at: Some(PathEnd::Flutter), ..PathAnalysis::default() };
        m.analysis = Analysis::Path(options.clone());
        let path =
            path::run(&compile(&m).1, &options, None, &mut Notes::default()).unwrap().state.path.unwrap();
        assert_eq!(path.critical.len(), 1, "{force}");
        force * path.critical[0].load
    });
    println!("{loads:?}");
    for load in loads {
        assert!((load / loads[0] - 1.0).abs() < 1e-6, "{loads:?}");
    }
}

/// Ziegler's pendulum of two links of length l = 1 with masses at their ends, torsion springs of stiffness c = 1 and a follower force P.
fn double_pendulum(force: f64, analysis: serde_json::Value) -> Model {
    double_pendulums(1, force, analysis)
}

/// Such pendulums side by side, which nothing connects.
fn double_pendulums(copies: usize, force: f64, analysis: serde_json::Value) -> Model {
    let axis = [0.0, 0.0, 1.0];
    let of = |list: &dyn Fn(usize) -> [serde_json::Value; 2]| (0..copies).flat_map(list).collect::<Vec<_>>();
    let place = |i: usize, x: f64| [x, 0.0, i as f64];
    let body = |name: &str, i: usize, x: f64, mass: f64| serde_json::json!({ "name": format!("{name}{i}"), "at": place(i, x), "mass": mass, "inertia": [0.01 * mass, 0.01 * mass, 0.01 * mass] });
    let hinge = |number: usize, i: usize, between: [String; 2], x: f64| serde_json::json!({ "type": "revolute", "name": format!("h{number}{i}"), "between": between, "at": place(i, x), "axis": axis });
    let spring = |number: usize, i: usize, between: [String; 2]| serde_json::json!({ "name": format!("s{number}{i}"), "between": between, "axis": axis, "stiffness": 1.0 });
    let links = |i: usize| [["ground".into(), format!("a{i}")], [format!("a{i}"), format!("b{i}")]];
    let load = |i: usize| serde_json::json!({ "type": "follower-force", "on": format!("b{i}"), "value": [-force, 0.0, 0.0] });
    serde_json::from_value(serde_json::json!({
        "bodies": of(&|i| [body("a", i, 1.0, 2.0), body("b", i, 2.0, 1.0)]),
        "joints": of(&|i| { let [one, other] = links(i); [hinge(1, i, one, 0.0), hinge(2, i, other, 1.0)] }),
        "torsion_springs": of(&|i| { let [one, other] = links(i); [spring(1, i, one), spring(2, i, other)] }),
        "loads": (0..copies).map(load).collect::<Vec<_>>(),
        "analysis": analysis
    }))
    .unwrap()
}

/// Discriminant of the equation of ω² of the double pendulum, from K + N and M of the two angles.
fn discriminant(p: f64) -> (f64, f64) {
    let mass = DMatrix::from_row_slice(2, 2, &[3.0 + 0.02, 1.0, 1.0, 1.0 + 0.01]);
    let stiffness = DMatrix::from_row_slice(2, 2, &[2.0 - p, p - 1.0, -1.0, 1.0]);
    let a = mass.lu().solve(&stiffness).unwrap();
    ((a[(0, 0)] - a[(1, 1)]).powi(2) + 4.0 * a[(0, 1)] * a[(1, 0)], (0.5 * a.trace()).sqrt())
}

/// Force at which the flutter of the double pendulum begins.
fn onset_of_double_pendulum() -> f64 {
    let (mut low, mut high) = (1.5, 2.5);
    assert!(discriminant(low).0 > 0.0 && discriminant(high).0 < 0.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if discriminant(middle).0 > 0.0 { low = middle } else { high = middle }
    }
    low
}

/// Modes of equal pendulums have equal eigenvalues: the search for their coupling ends, and the most growing one of each is that of one pendulum.
#[test]
fn several_equal_parts_flutter_as_one_does() {
    let analysis = serde_json::json!({ "type": "modal", "modes": 2, "prestressed": true });
    for load in [0.9, 0.999_999, 1.000_001, 1.1] {
        let force = load * onset_of_double_pendulum();
        let of = |copies| modes(&double_pendulums(copies, force, analysis.clone()), &mut Notes::default());
        let most = |found: Vec<Mode>| {
            let growths = found.iter().map(|mode| mode.complex.as_ref().unwrap().growth);
            (found[0].omega, growths.max_by(f64::total_cmp).unwrap())
        };
        let (omega, growth) = most(of(1));
        for copies in [2, 3, 4, 5, 7] {
            let (found, grows) = most(of(copies));
            assert!((found - omega).abs() < 1e-9 * omega, "{load} {copies} {found}");
            assert!((grows - growth).abs() < 1e-9, "{load} {copies} {grows} {growth}");
        }
    }
}

/// At the onset itself both eigenvectors are one: the frequency of a double pendulum is found twice, to the square root of round-off.
#[test]
fn modes_at_the_onset_of_flutter_are_the_double_one() {
    let low = onset_of_double_pendulum();
    for distance in [-1e-12, 0.0, 1e-15, 1e-12] {
        let force = low * (1.0 + distance);
        let analysis = serde_json::json!({ "type": "modal", "modes": 2, "prestressed": true });
        let found = modes(&double_pendulum(force, analysis), &mut Notes::default());
        let omega = discriminant(force).1;
        for mode in &found {
            let growth = mode.complex.as_ref().unwrap().growth;
            assert!((mode.omega - omega).abs() < 1e-5 * omega && growth.abs() < 1e-5, "{distance} {mode:?}");
        }
    }
}

/// Complex modes of a column without mass that carries a mass are not found; the path is, and says so once.
#[test]
fn paths_of_parts_without_mass_go_on_without_the_search_for_flutter() {
    let mut m = beck(4.0, 2, true);
    if let Some(Material::Isotropic(material)) = m.materials.values_mut().next() {
        material.density = 0.0;
    }
    m.masses = serde_json::from_str(r#"[{ "type": "point", "on": "u_max", "value": 0.3 }]"#).unwrap();
    let options = PathAnalysis { end_load: 1.0, ..PathAnalysis::default() };
    m.analysis = Analysis::Path(options.clone());
    let mut notes = Notes::default();
    let outcome = path::run(&compile(&m).1, &options, None, &mut notes).unwrap();
    assert_eq!(outcome.state.time, 1.0);
    assert_eq!(notes.warnings.len(), 1, "{:?}", notes.warnings);
    assert!(
        notes.warnings[0].contains("is not known: parts of the model have no mass"),
        "{:?}",
        notes.warnings
    );
}

/// Real circular frequencies below the third of a column with m L = 1 under a follower force p EI/L² that carries a mass μ m L at its end: roots of
/// the boundary conditions w″ = 0, w‴ + μ Ω² w = 0 of the equation w⁗ + p w″ − Ω² w = 0 (A. Pflüger, ZAMM 35 (1955) 191; V. V. Bolotin, *Nonconservative
/// problems of the theory of elastic stability*, 1963, Sect. 2.3).
fn real_frequencies_with_mass(p: f64, mass: f64) -> usize {
    let determinant = |omega: f64| {
        let middle = (omega * omega + p * p / 4.0).sqrt();
        let [a, b] = [(middle + p / 2.0).sqrt(), (middle - p / 2.0).sqrt()];
        let [deflection, moment, shear] = [
            [b.cosh() - a.cos(), a * b.sinh() - b * a.sin()],
            [b * b * b.cosh() + a * a * a.cos(), a * b * (b * b.sinh() + a * a.sin())],
            [b.powi(3) * b.sinh() - a.powi(3) * a.sin(), a * b * (b * b * b.cosh() + a * a * a.cos())],
        ];
        let end = [0, 1].map(|i| shear[i] + mass * omega * omega * deflection[i]);
        (moment[0] * end[1] - moment[1] * end[0]) / b.cosh()
    };
    let values: Vec<f64> = (0..4000).map(|i| determinant(1e-4 * (6e5_f64).powf(i as f64 / 3999.0))).collect();
    values.windows(2).filter(|pair| pair[0] * pair[1] < 0.0).count()
}

/// A light column with a heavy end flutters in a narrow interval of loads only and diverges behind it; a path that steps over the interval locates it.
#[test]
fn flutter_before_divergence_of_a_column_with_a_heavy_end_is_located() {
    let (mut low, mut high) = (19.0, 21.0);
    let before = real_frequencies_with_mass(low, 9000.0);
    assert_eq!(before, real_frequencies_with_mass(high, 9000.0) + 2);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if real_frequencies_with_mass(middle, 9000.0) == before { low = middle } else { high = middle }
    }
    for end in [21.0, 25.0, 40.0] {
        let mut m = beck(end, 2, true);
        m.masses = serde_json::from_str(r#"[{ "type": "point", "on": "u_max", "value": 4500.0 }]"#).unwrap();
        let options = PathAnalysis { end_load: 1.0, ..PathAnalysis::default() };
        m.analysis = Analysis::Path(options.clone());
        let mut notes = Notes::default();
        let path = path::run(&compile(&m).1, &options, None, &mut notes).unwrap().state.path.unwrap();
        println!(
            "{low} {:?} {:?}",
            path.critical.iter().map(|c| end * c.load).collect::<Vec<_>>(),
            notes.warnings
        );
        let onset = &path.critical[0];
        assert_eq!(onset.kind, CriticalKind::Flutter);
        assert!((end * onset.load / low - 1.0).abs() < 2e-3, "{low} {}", end * onset.load);
        assert!(notes.warnings.iter().any(|text| text.contains("flutter")), "{:?}", notes.warnings);
    }
}

/// A flutter that begins in the same step in which a divergence ends is located, and ends the path. The loads are those of the cantilever under the part
/// η = 0.4 of a follower load and the part 1 − η of a dead one: η + (1 − η) cos √p = 0 where divergence begins and ends, and two frequencies meet at the
/// onset, roots of the boundary conditions w″ = 0, w‴ + (1 − η) p w′ = 0 of w⁗ + p w″ − Ω² w = 0 (V. V. Bolotin, *Nonconservative problems of the theory of
/// elastic stability*, 1963).
#[test]
fn flutter_in_the_step_in_which_a_divergence_ends_is_located() {
    let eta = 0.4;
    for force in [30.0, 40.0, 50.0] {
        let mut m = beck(eta * force, 2, false);
        m.beams[0].elements = Some(30);
        let dead = serde_json::json!({ "type": "force", "on": "column.end", "value": [-(1.0 - eta) * force, 0.0, 0.0] });
        m.loads.push(serde_json::from_value(dead).unwrap());
        let options =
            PathAnalysis { end_load: 1.0, end_at: Some(PathEnd::Flutter), ..PathAnalysis::default() };
        m.analysis = Analysis::Path(options.clone());
        let mut notes = Notes::default();
        let critical =
            path::run(&compile(&m).1, &options, None, &mut notes).unwrap().state.path.unwrap().critical;
        assert!(notes.warnings.is_empty(), "{force} {:?}", notes.warnings);
        assert_eq!(critical.len(), 3, "{critical:?}");
        for (point, expected) in critical.iter().zip([5.2924, 15.8616, 16.4039]) {
            let load = force * point.load;
            assert!((load / expected - 1.0).abs() < 2e-3, "{force} {load}");
        }
        assert_eq!(critical[2].kind, CriticalKind::Flutter);
    }
}

/// Complex modes of a clamped column do not depend on how many are asked for, and its longitudinal frequency is that of a rod, (π/2) √(EA/m)/L. Vectors of the
/// basis keep the joint closed, also where little of them is new.
#[test]
fn complex_modes_do_not_depend_on_their_number() {
    let column = |bending: [f64; 2], wanted: usize| -> Vec<f64> {
        let model: Model = serde_json::from_value(serde_json::json!({
            "beams": [{ "name": "column", "points": [[0, 0, 0], [1, 0, 0]], "elements": 20, "direction": [0, 0, 1],
                        "section": { "type": "constants", "axial": 1e4, "shear": [1e4, 1e4], "bending": bending, "torsion": 10.0, "mass": 1.0, "inertia": [1e-4, 1e-4] } }],
            "joints": [{ "type": "fixed", "name": "root", "between": ["ground", "column.start"], "at": [0, 0, 0] }],
            "loads": [{ "type": "follower-force", "on": "column.end", "value": [-1.0, 0, 0] }],
            "analysis": { "type": "modal", "modes": wanted, "prestressed": true }
        }))
        .unwrap();
        modes(&model, &mut Notes::default()).iter().map(|mode| mode.omega).collect()
    };
    for bending in [[1000.0, 1.0], [1.0, 1.0]] {
        let many = column(bending, 20);
        for wanted in [1, 4, 8, 9, 10, 12, 14] {
            for (number, (few, many)) in column(bending, wanted).iter().zip(&many).enumerate() {
                assert!((few - many).abs() < 1e-7 * many, "{bending:?} {wanted} {number}: {few} {many}");
            }
        }
        let rod = 0.5 * std::f64::consts::PI * 100.0;
        let nearest = many.iter().map(|omega| (omega / rod - 1.0).abs()).min_by(f64::total_cmp).unwrap();
        assert!(nearest < 1e-3, "{bending:?} {nearest} {many:?}");
    }
}

/// Six slow modes of other parts lie below the two that flutter: a path finds the onset of the column alone, and modes tell of what grows beyond them.
#[test]
fn flutter_above_slow_modes_of_other_parts_is_found() {
    let column = |masses: usize, analysis: serde_json::Value| -> Model {
        let places: Vec<f64> = (0..masses).map(|i| 5.0 + i as f64).collect();
        let body = |(i, y): (usize, &f64)| serde_json::json!({ "name": format!("p{i}"), "at": [0.0, y, 0.0], "mass": 1.0 });
        let springs = |(i, y): (usize, &f64)| {
            let at = [0.0, *y, 0.0];
            [(0, [0.3, *y, 0.0]), (1, [0.0, y + 0.3, 0.0]), (2, [0.0, *y, 0.3])].map(|(axis, from)| serde_json::json!({ "name": format!("s{i}{axis}"), "between": ["ground", format!("p{i}")], "points": [from, at], "stiffness": 0.01 }))
        };
        serde_json::from_value(serde_json::json!({
            "beams": [{ "name": "column", "points": [[0, 0, 0], [1, 0, 0]], "elements": 8, "direction": [0, 0, 1],
                        "section": { "type": "constants", "axial": 1e4, "shear": [1e4, 1e4], "bending": [20.0, 1.0], "torsion": 10.0, "mass": 1.0, "inertia": [1e-4, 1e-4] } }],
            "joints": [{ "type": "fixed", "name": "root", "between": ["ground", "column.start"], "at": [0, 0, 0] }],
            "bodies": places.iter().enumerate().map(body).collect::<Vec<_>>(),
            "springs": places.iter().enumerate().flat_map(springs).collect::<Vec<_>>(),
            "loads": [{ "type": "follower-force", "on": "column.end", "value": [-25.0, 0, 0] }],
            "analysis": analysis
        }))
        .unwrap()
    };
    let onset = |masses: usize| {
        let options =
            PathAnalysis { end_load: 1.0, end_at: Some(PathEnd::Flutter), ..PathAnalysis::default() };
        let system = compile(&column(masses, serde_json::json!({ "type": "path" }))).1;
        path::run(&system, &options, None, &mut Notes::default()).unwrap().state.path.unwrap().critical
    };
    let alone = onset(0);
    let beside = onset(2);
    assert_eq!([alone.len(), beside.len()], [1, 1], "{alone:?} {beside:?}");
    assert!((beside[0].load / alone[0].load - 1.0).abs() < 1e-5, "{} {}", beside[0].load, alone[0].load);

    for (wanted, place) in [(6, "which is mode 7, beyond the 6"), (8, "see `growth` in the table")] {
        let analysis = serde_json::json!({ "type": "modal", "modes": wanted, "prestressed": true });
        let mut notes = Notes::default();
        assert_eq!(modes(&column(2, analysis), &mut notes).len(), wanted);
        let told = |text: &String| text.contains("flutter") && text.contains(place);
        assert!(notes.warnings.iter().any(told), "{wanted} {:?}", notes.warnings);
    }
}
