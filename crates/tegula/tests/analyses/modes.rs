//! Natural modes: rigid ones, their stresses, counts, nearly all of them, and parts of very different stiffness.

use crate::common;
use crate::common::{compile, distance, model, on, plate, side_by_side};
use tegula::analysis::modal::{self, ModalOutcome, Mode};
use tegula::analysis::{Silent, State, statics};
use tegula::element::{Motion, Nodal};
use tegula::material::NeoHookeanForm;
use tegula::mesh::generators::generate;
use tegula::model::*;
use tegula::norm::max_norm;
use tegula::result::inside::Snapshot;
use tegula::result::{ShellResult, recovery};
use tegula::system::{Assembly, EvaluationPoint, dot};
use tegula::{Error, Result, System, Vec3};

const E: f64 = 2.1e11;
const RHO: f64 = 7850.0;

fn material(young: f64, poisson: f64) -> Material {
    Material::Isotropic(Isotropic::new(young, poisson, RHO))
}

fn modal_model(size: [f64; 2], elements: [u32; 2], thickness: f64) -> Model {
    let mut m = model(plate(size, elements, 0.0), E, thickness);
    m.materials.insert("m".into(), material(E, 0.3));
    m.conditions.clear();
    m.analysis = Analysis::Modal(ModalAnalysis::new(1));
    m
}

fn modes(system: &System, wanted: usize) -> ModalOutcome {
    modal::run(system, wanted, None, &mut Silent).unwrap()
}

fn stresses(system: &System, state: &State, mode: &Mode) -> Vec<ShellResult> {
    recovery::shells(&Snapshot::of_small_motion(system, state, &mode.shape))
}

#[test]
fn fewer_modes_than_rigid_ones_are_rigid() {
    let (_, system) = compile(&modal_model([1.0, 1.0], [8, 8], 0.01));
    for wanted in [1, 3, 6] {
        let outcome = modes(&system, wanted);
        assert_eq!(outcome.modes.len(), wanted);
        assert!(outcome.sturm_checked);
        assert!(outcome.modes.iter().all(|m| m.rigid && m.omega == 0.0 && m.residual <= 1e-6), "{wanted}");
    }
}

/// A rigid mode turns by radians at its amplitude of modal mass 1; its strain is zero to rounding.
#[test]
fn rigid_modes_have_no_stress() {
    for element in [ElementKind::Ems, ElementKind::Cm, ElementKind::Mitc4, ElementKind::SolidShell] {
        let mut m = modal_model([1.0, 0.6], [5, 4], 0.01);
        m.sections[0].element = element;
        let (_, system) = compile(&m);
        let found = modes(&system, 8).modes;
        let rest = State::at_rest(&system);
        let of = |mode: &Mode| max_norm(stresses(&system, &rest, mode).iter().map(|r| r.von_mises));
        let elastic = of(&found[6]);
        for (i, mode) in found.iter().enumerate() {
            assert_eq!(mode.rigid, i < 6, "{element:?} {i}");
            let share = of(mode) / elastic;
            assert!(if i < 6 { share <= 1e-9 } else { share > 0.1 }, "{element:?} {i}: {share:e}");
        }
    }
}

/// Surface stress of the first mode of a cantilever, of modal mass 1: σ = E h/2 φ'' with
/// φ = (cosh βx − cos βx − s (sinh βx − sin βx))/√m, βL = 1.875104, s = 0.734096 (R. D. Blevins, *Formulas for Natural
/// Frequency and Mode Shape*, 1979, table 8-1). It is that of its own moments alone.
#[test]
fn stress_of_a_bending_mode_is_that_of_its_moments() {
    let (length, width, h, n) = (1.0, 0.1, 0.01, 40);
    let mut m = modal_model([length, width], [n, 2], h);
    m.materials.insert("m".into(), material(E, 0.0));
    m.conditions = vec![Condition::Clamp(on("u_min"))];
    let (_, system) = compile(&m);
    let found = &modes(&system, 1).modes[0];
    let (beta, s) = (1.875_104 / length, 0.734_096);
    let mass = RHO * length * width * h;
    let results = stresses(&system, &State::at_rest(&system), found);
    let scale = max_norm(results.iter().map(|r| r.stress_top[0].abs()));
    for (shell, r) in system.shells.iter().zip(&results) {
        for i in 0..3 {
            let own = 6.0 * r.bending[i] / (h * h);
            assert!((r.stress_top[i] + own).abs() <= 1e-9 * scale, "{} of {own}", r.stress_top[i]);
            assert!((r.stress_bottom[i] - own).abs() <= 1e-9 * scale, "{} of {own}", r.stress_bottom[i]);
        }
        let x = beta * system.geometry(shell).centre().x;
        let second = beta * beta * (x.cosh() + x.cos() - s * (x.sinh() + x.sin())) / mass.sqrt();
        let expected = E * 0.5 * h * second;
        let error = (r.stress_top[0].abs() - expected).abs();
        assert!(error <= 0.01 * scale, "{} for {expected} at {x}", r.stress_top[0]);
    }
}

/// Stresses of a small motion are the derivative of those of the state, about a bent and stretched configuration too.
#[test]
fn stresses_of_a_mode_are_the_derivative_of_those_of_the_state() {
    let rubber = |m: &mut Model| {
        let law = NeoHookean { shear: 1e6, bulk: 1e8, density: 1e3, form: NeoHookeanForm::Split };
        m.materials.insert("m".into(), Material::NeoHookean(law));
    };
    for (element, hyperelastic) in [
        (ElementKind::Ems, false),
        (ElementKind::Mitc4, false),
        (ElementKind::Cm, false),
        (ElementKind::SolidShell, false),
        (ElementKind::Cm, true),
    ] {
        let mut m = modal_model([1.0, 0.6], [4, 3], 0.05);
        m.mesh = plate([1.0, 0.6], [4, 3], 0.2);
        m.sections[0].element = element;
        let mut load = 2e6;
        if hyperelastic {
            rubber(&mut m);
            load = 20.0;
        }
        m.conditions = vec![Condition::Clamp(on("u_min"))];
        m.loads = vec![Load::Edge(common::vector_load("u_max", [2.0 * load, 0.0, 0.1 * load]))];
        let (_, system) = compile(&m);
        let state = statics::run(&system, &StaticAnalysis::default(), None, &mut Silent).unwrap().state;
        let mode = modal::run(&system, 1, Some(&state), &mut Silent).unwrap().modes.remove(0);
        let size = max_norm(mode.shape.iter().map(|s| Vec3::from(*s).norm()));
        let step = 1e-5 / size;
        let at = |sign: f64| {
            let mut moved = state.clone();
            for (u, s) in moved.u.iter_mut().zip(&mode.shape) {
                *u = std::array::from_fn(|i| u[i] + sign * step * s[i]);
            }
            // Enhanced parameters of materials that are not linear are internal variables.
            let motion = Motion::State { u: &moved.u, velocity: None };
            Assembly::new(&system).commit(&system, motion, state.time, &mut moved.history);
            recovery::recover(&system, &moved)
        };
        let (plus, minus) = (at(1.0), at(-1.0));
        let found = stresses(&system, &state, &mode);
        let values = |r: &ShellResult| {
            let moments = r.bending.map(|m| 6.0 * m / 0.05);
            [r.membrane, moments, r.stress_top, r.stress_bottom].concat()
        };
        let scale = max_norm(found.iter().flat_map(&values).map(f64::abs));
        for ((r, p), m) in found.iter().zip(&plus).zip(&minus) {
            for ((r, p), m) in values(r).into_iter().zip(values(p)).zip(values(m)) {
                let difference = (p - m) / (2.0 * step);
                assert!(
                    (r - difference).abs() <= 1e-5 * scale,
                    "{element:?}: {r} for {difference} of {scale}"
                );
            }
        }
    }
}

/// Three plates that nothing connects: one free, one on a hinge, one on a ball joint have 6 + 1 + 3 rigid modes.
#[test]
fn free_parts_have_their_own_rigid_modes() {
    for element in [ElementKind::Ems, ElementKind::Mitc4] {
        let mut m = modal_model([1.0, 0.6], [4, 3], 0.01);
        m.sections[0].element = element;
        let mesh = generate(&m.mesh).unwrap();
        let mesh = side_by_side(&[mesh.clone(), mesh.clone(), mesh]);
        m.conditions = vec![Condition::Hinge(on("u_min1")), Condition::Spherical(on("u_min_v_min2"))];
        let system = tegula::compile::build(&m, &mesh).unwrap();
        let outcome = modes(&system, 13);
        let rigid: Vec<bool> = outcome.modes.iter().map(|m| m.rigid).collect();
        assert_eq!(rigid, (0..13).map(|i| i < 10).collect::<Vec<_>>(), "{element:?}");
        assert!(outcome.modes[10..].iter().all(|m| m.omega > 1.0));
        assert!(outcome.sturm_checked);
        assert!(modes(&system, 8).modes.iter().all(|m| m.rigid));
    }
}

/// Twelve equal plates: a block of eight vectors holds eight of the twelve equal modes, and only the Sturm count tells
/// that the ninth mode found is not the ninth mode.
#[test]
fn sturm_count_finds_modes_that_the_blocks_miss() {
    let mut m = modal_model([1.0, 0.2], [3, 1], 0.01);
    let mesh = generate(&m.mesh).unwrap();
    let mesh = side_by_side(&vec![mesh; 12]);
    m.conditions = (0..12).map(|k| Condition::Clamp(on(&format!("u_min{k}")))).collect();
    let system = tegula::compile::build(&m, &mesh).unwrap();
    for wanted in [3, 9, 10, 12, 14] {
        let outcome = modes(&system, wanted);
        assert!(outcome.sturm_checked);
        let first = outcome.modes[0].omega;
        for (i, mode) in outcome.modes.iter().enumerate() {
            let equal = (mode.omega / first - 1.0).abs() < 1e-6;
            assert_eq!(equal, i < 12, "mode {i} of {wanted}: {} of {first}", mode.omega);
        }
    }
}

/// Internal forces of a small motion, from strains.
fn forces(system: &System, shape: &[Nodal]) -> Vec<Nodal> {
    let mut out = vec![[0.0; 3]; shape.len()];
    let motion = Motion::State { u: shape, velocity: None };
    let k = EvaluationPoint { motion, linear: true, time: 0.0, internal: (&[]).into() };
    Assembly::new(system).forces(system, &k, &mut out);
    out
}

/// From one mode to all of a small model: M-orthonormal, in equilibrium, and the same whatever the number wanted.
#[test]
fn any_number_of_modes_of_a_small_model_is_found() {
    for (clamped, thickness) in [(true, 0.05), (false, 0.05), (false, 1e-4)] {
        let mut m = modal_model([1.0, 0.6], [2, 2], thickness);
        if clamped {
            m.conditions = vec![Condition::Clamp(on("u_min"))];
        }
        let (_, system) = compile(&m);
        let n = system.unknowns();
        let all = modes(&system, n).modes;
        assert_eq!(all.len(), n);
        for wanted in [7, 9, n / 2, n - 7, n - 1] {
            let outcome = modes(&system, wanted);
            assert_eq!(outcome.modes.len(), wanted);
            assert!(outcome.sturm_checked, "{wanted}");
            for (a, b) in outcome.modes.iter().zip(&all) {
                assert!((a.omega - b.omega).abs() <= 1e-7 * b.omega, "{wanted}: {} for {}", a.omega, b.omega);
            }
        }
        let product = |shape: &[Nodal]| {
            let mut out = vec![[0.0; 3]; shape.len()];
            system.pattern.add_mass_product(1.0, shape, &mut out);
            out
        };
        let products: Vec<_> = all.iter().map(|m| product(&m.shape)).collect();
        for (i, a) in all.iter().enumerate() {
            for (j, m_b) in products.iter().enumerate().take(i + 1) {
                let expected = if i == j { 1.0 } else { 0.0 };
                let found = dot(&a.shape, m_b);
                assert!((found - expected).abs() <= 1e-6, "{thickness} {i} {j}: {found}");
            }
        }
        let top = all.last().unwrap().omega;
        for (mode, m_shape) in all.iter().zip(&products) {
            let mut inertia = m_shape.clone();
            inertia.iter_mut().flatten().for_each(|x| *x *= mode.omega * mode.omega);
            let mut internal = forces(&system, &mode.shape);
            let mut reactions = vec![[0.0; 3]; internal.len()];
            system.frames.constrained_part(&internal, &mut reactions);
            internal.iter_mut().flatten().zip(reactions.iter().flatten()).for_each(|(f, r)| *f -= r);
            system.frames.constrained_part(&inertia.clone(), &mut reactions);
            inertia.iter_mut().flatten().zip(reactions.iter().flatten()).for_each(|(f, r)| *f -= r);
            let scale = top * top * distance(m_shape, &vec![[0.0; 3]; m_shape.len()]);
            let error = distance(&internal, &inertia);
            assert!(error <= 1e-9 * scale, "{thickness}, ω = {}: {error:e} of {scale:e}", mode.omega);
        }
    }
}

/// Two free plates, the second as many times as stiff.
fn two_plates(joined: bool, ratio: f64) -> Result<(System, ModalOutcome)> {
    let mut m = modal_model([1.0, 0.4], [6, 3], 0.01);
    let mesh = generate(&m.mesh).unwrap();
    let mesh = if joined {
        let mut mesh = mesh;
        let centre = |q: &[u32; 4]| q.iter().map(|&n| mesh.positions[n as usize].x).sum::<f64>() / 4.0;
        let (soft, stiff): (Vec<u32>, Vec<u32>) =
            (0..mesh.quads.len() as u32).partition(|&q| centre(&mesh.quads[q as usize]) < 0.5);
        mesh.quad_sets.insert("part0".into(), soft);
        mesh.quad_sets.insert("part1".into(), stiff);
        mesh
    } else {
        side_by_side(&[mesh.clone(), mesh])
    };
    m.materials.insert("stiff".into(), material(ratio * E, 0.3));
    let mut stiff = m.sections[0].clone();
    stiff.material = "stiff".into();
    (m.sections[0].on, stiff.on) = ("part0".into(), "part1".into());
    m.sections.push(stiff);
    let system = tegula::compile::build(&m, &mesh)?;
    let outcome = modal::run(&system, if joined { 9 } else { 16 }, None, &mut Silent)?;
    Ok((system, outcome))
}

#[test]
fn free_bodies_of_very_different_stiffness_keep_their_modes() {
    let (_, alone) = compile(&modal_model([1.0, 0.4], [6, 3], 0.01));
    let alone = modes(&alone, 10).modes;
    for (ratio, soft) in [(1e-12, 1e-6), (1.0, 1.0), (1e6, 1.0), (1e12, 1.0)] {
        let (_, outcome) = two_plates(false, ratio).unwrap();
        assert!(outcome.sturm_checked);
        for (i, mode) in outcome.modes.iter().enumerate() {
            assert_eq!(mode.rigid, i < 12, "{ratio:e}: mode {i} is {}", mode.omega);
            if i >= 12 {
                let k = if ratio == 1.0 { (i - 12) / 2 } else { i - 12 };
                let expected = soft * alone[6 + k].omega;
                assert!((mode.omega / expected - 1.0).abs() <= 1e-8, "{ratio:e}, {i}: {}", mode.omega);
            }
        }
    }
}

/// A stiff half is rigid: from ratio to ratio the modes hardly change. What round-off hides is refused.
#[test]
fn joined_bodies_of_very_different_stiffness_are_right_or_refused() {
    let (_, reference) = two_plates(true, 1e5).unwrap();
    for ratio in [1e7, 1e9, 1e12] {
        match two_plates(true, ratio) {
            Ok((_, outcome)) => {
                for (i, (a, b)) in outcome.modes.iter().zip(&reference.modes).enumerate() {
                    assert_eq!(a.rigid, i < 6, "{ratio:e}: mode {i} is {}", a.omega);
                    assert!(
                        (a.omega - b.omega).abs() <= 1e-3 * b.omega,
                        "{ratio:e}: {} for {}",
                        a.omega,
                        b.omega
                    );
                }
                println!("{ratio:e}: found");
            }
            Err(Error::NotConverged { reason, .. }) if ratio > 1e8 => {
                println!("{ratio:e}: {reason}");
                assert!(reason.contains("round-off"), "{reason}");
            }
            Err(other) => panic!("{ratio:e}: {other}"),
        }
    }
}

/// A pressure on a sheet with free edges has no potential: its modes are complex, and those of a sheet on supported edges are not. One mode
/// alone is coupled with those that were not asked for.
#[test]
fn modes_under_a_pressure_are_complex_where_it_has_no_potential() {
    let run = |pressure: f64, all_edges: bool, wanted: u32| {
        let mut m = modal_model([10.0, 1.0], [20, 2], 0.1);
        m.materials.insert("m".into(), material(1.2e6, 0.3));
        let edges: &[&str] = if all_edges { &["u_min", "u_max", "v_min", "v_max"] } else { &["u_min"] };
        m.conditions = edges.iter().map(|edge| Condition::Clamp(on(edge))).collect();
        m.loads = vec![Load::Pressure(PressureLoad {
            on: "all".into(),
            value: pressure,
            amplitude: None,
            distribution: None,
        })];
        m.analysis = Analysis::Modal(ModalAnalysis { prestressed: true, ..ModalAnalysis::new(wanted) });
        let (_, system) = compile(&m);
        let start = modal::prestress(&system, &mut Silent).unwrap().state;
        modal::run(&system, wanted as usize, Some(&start), &mut Silent).unwrap().modes
    };
    let free = run(1e-6, false, 4);
    assert!(free.iter().all(|mode| mode.complex.is_none()));
    let [one, four] = [1, 4].map(|wanted| run(2.0, false, wanted));
    assert!(one[0].complex.is_some() && (one[0].omega / four[0].omega - 1.0).abs() < 1e-9);
    let supported = run(2.0, true, 4);
    assert!(supported[0].complex.is_none() && supported[0].omega > free[0].omega);
}

#[test]
fn a_free_body_with_prescribed_strains_is_told_to_be_free() {
    let mut m = modal_model([1.0, 0.2], [20, 4], 0.01);
    let warm = |expansion: f64| Isotropic { expansion, ..Isotropic::new(1e9, 0.3, 1000.0) };
    m.materials.insert("m".into(), Material::Isotropic(warm(1e-5)));
    let thermal = ThermalStrain {
        distribution: None,
        on: "all".into(),
        temperature: 10.0,
        gradient: 0.0,
        amplitude: None,
    };
    m.prescribed_strains = vec![PrescribedStrain::Thermal(thermal)];
    let (_, system) = compile(&m);
    let error = modal::prestress(&system, &mut Silent).unwrap_err().to_string();
    assert!(error.contains("moves freely in 6 way(s)"), "{error}");
}
