//! Plates whose resultants are known in closed form.

use super::*;
use crate::analysis::{Silent, statics};
use crate::mesh::Mesh;
use crate::mesh::generators::generate;
use crate::model::{Axis, *};

const H: f64 = 0.02;

/// A distorted plate of 2 × 1 clamped or symmetric at u_min.
fn plate(poisson: f64, conditions: Vec<Condition>, loads: Vec<Load>) -> (Mesh, Model) {
    let mut grid = Grid::uniform(8, 4);
    grid.distortion = 0.2;
    let source = MeshSource::Plate(PlateMesh {
        origin: [0.0; 3],
        u_axis: [1.0, 0.0, 0.0],
        v_axis: [0.0, 1.0, 0.0],
        size: [2.0, 1.0],
        grid,
    });
    let mesh = generate(&source).unwrap();
    let analysis = Analysis::Static(StaticAnalysis { linear: true, ..Default::default() });
    let mut model = Model::new(source, analysis, Isotropic::new(2e6, poisson, 1.0), H);
    model.conditions = conditions;
    model.loads = loads;
    (mesh, model)
}

fn solve(mesh: &Mesh, model: &Model) -> (System, statics::StaticOutcome) {
    let system = crate::compile::build(model, mesh).unwrap();
    let Analysis::Static(options) = &model.analysis else { unreachable!() };
    let outcome = statics::run(&system, options, None, &mut Silent).unwrap();
    (system, outcome)
}

fn fix(on: &str, position: &[Axis], director: &[Axis]) -> Condition {
    Condition::Fix(FixComponents { on: on.into(), position: position.into(), director: director.into() })
}

fn edge(on: &str, value: [f64; 3]) -> VectorLoad {
    VectorLoad { on: on.into(), value, amplitude: None, distribution: None }
}

fn near(found: f64, expected: f64, scale: f64, what: &str) {
    assert!((found - expected).abs() <= 1e-8 * scale, "{what}: {found} for {expected}");
}

/// The cross-section frame follows r,η of distorted elements: back to the axes of the plate.
fn along_x(system: &System, shell: usize, values: [f64; 3]) -> [f64; 3] {
    let g = system.geometry(&system.shells[shell]).positions;
    let j = (g[3] - g[0] + g[2] - g[1]).normalize();
    let (c, s) = (j.y, -j.x);
    let [x, y, xy] = values;
    [
        c * c * x + s * s * y - 2.0 * c * s * xy,
        s * s * x + c * c * y + 2.0 * c * s * xy,
        c * s * (x - y) + (c * c - s * s) * xy,
    ]
}

#[test]
fn uniform_tension_gives_its_load() {
    let supports = vec![
        fix("u_min", &[Axis::X], &[Axis::X]),
        fix("u_min_v_min", &[Axis::Y], &[Axis::Y]),
        fix("all", &[Axis::Z], &[]),
    ];
    let (mesh, mut model) = plate(0.3, supports, vec![Load::Edge(edge("u_max", [50.0, 0.0, 0.0]))]);
    if let MeshSource::Plate(p) = &mut model.mesh {
        p.grid.distortion = 0.0;
    }
    let mesh = generate(&model.mesh).unwrap_or(mesh);
    let (system, outcome) = solve(&mesh, &model);
    for r in recover(&system, &outcome.state) {
        near(r.membrane[0], 50.0, 50.0, "n_xx");
        near(r.membrane[1], 0.0, 50.0, "n_yy");
        near(r.membrane[2], 0.0, 50.0, "n_xy");
        near(r.bending[0], 0.0, 50.0 * H, "m_xx");
        near(r.stress_top[0], 50.0 / H, 50.0 / H, "stress");
        near(r.von_mises, 50.0 / H, 50.0 / H, "von Mises");
        near(r.energy_density, 0.5 * 50.0 * 50.0 / (2e6 * H), 0.1, "energy density");
    }
}

#[test]
fn distorted_elements_keep_the_tension() {
    let supports = vec![
        fix("u_min", &[Axis::X], &[Axis::X]),
        fix("u_min_v_min", &[Axis::Y], &[Axis::Y]),
        fix("all", &[Axis::Z], &[]),
    ];
    let (mesh, model) = plate(0.3, supports, vec![Load::Edge(edge("u_max", [50.0, 0.0, 0.0]))]);
    let (system, outcome) = solve(&mesh, &model);
    let results = recover(&system, &outcome.state);
    for (i, r) in results.iter().enumerate() {
        let n = along_x(&system, i, r.membrane);
        near(n[0], 50.0, 50.0, "n_xx");
        near(n[1], 0.0, 50.0, "n_yy");
        near(n[2], 0.0, 50.0, "n_xy");
        near(r.energy_density, 0.5 * 50.0 * 50.0 / (2e6 * H), 0.1, "energy density");
        near(r.von_mises, 50.0 / H, 50.0 / H, "von Mises");
    }
}

#[test]
fn pure_bending_gives_the_moment_and_pulls_one_side() {
    // A moment about y at the free edge, along +y: it turns the director (0, 0, 1) towards +x, so the
    // strip bends downwards there (away from the director) and its top is pulled.
    let clamp = vec![Condition::Clamp(OnSet { on: "u_min".into() })];
    let load = vec![Load::EdgeMoment(edge("u_max", [0.0, 3.0, 0.0]))];
    let (_, mut model) = plate(0.0, clamp, load);
    if let MeshSource::Plate(p) = &mut model.mesh {
        p.grid.distortion = 0.0;
    }
    let mesh = generate(&model.mesh).unwrap();
    let (system, outcome) = solve(&mesh, &model);
    let tip = system.coordinates.position_of[mesh.nodes_on("u_max_v_max").unwrap()[0] as usize] as usize;
    assert!(outcome.state.u[tip][2] < 0.0, "the strip bends downwards");
    for r in recover(&system, &outcome.state) {
        near(r.bending[0], -3.0, 3.0, "m_xx");
        near(r.bending[1], 0.0, 3.0, "m_yy");
        near(r.membrane[0], 0.0, 3.0 / H, "n_xx");
        let s = 6.0 * 3.0 / (H * H);
        near(r.stress_top[0], s, s, "top, pulled");
        near(r.stress_bottom[0], -s, s, "bottom, pressed");
        near(r.von_mises, s, s, "von Mises");
    }
}

#[test]
fn a_cantilever_under_a_weight_is_pulled_on_top() {
    let clamp = vec![Condition::Clamp(OnSet { on: "u_min".into() })];
    let (mesh, model) = plate(0.3, clamp, vec![Load::Edge(edge("u_max", [0.0, 0.0, -1.0]))]);
    let (system, outcome) = solve(&mesh, &model);
    let results = recover(&system, &outcome.state);
    let root = &results[0];
    assert!(root.stress_top[0] > 0.0 && root.stress_bottom[0] < 0.0, "{root:?}");
    // The moment at the middle of the first row of elements: load times arm, shared by both sides.
    assert!((root.stress_top[0] / (6.0 * 1.875 / (H * H)) - 1.0).abs() < 0.2, "{root:?}");
    // Equilibrium: the transverse shear carries the load.
    let mean = results.iter().map(|r| r.shear[0] * r.area).sum::<f64>() / 2.0;
    assert!((mean.abs() - 1.0).abs() < 0.05, "{mean}");
}

/// Between a clamp and a guide the moment vanishes in the middle, where von Mises' stress is that of the shear stress
/// 1.5 Q/h at half the thickness (J. M. Gere, S. P. Timoshenko, *Mechanics of Materials*, 4th ed., Sect. 5.8).
#[test]
fn von_mises_stress_without_a_moment_is_that_of_the_greatest_shear_stress() {
    let supports =
        vec![Condition::Clamp(OnSet { on: "u_min".into() }), fix("u_max", &[], &[Axis::X, Axis::Y, Axis::Z])];
    let (_, mut model) = plate(0.0, supports, vec![Load::Edge(edge("u_max", [0.0, 0.0, -2.0]))]);
    if let MeshSource::Plate(p) = &mut model.mesh {
        p.grid = Grid::uniform(9, 2);
    }
    let mesh = generate(&model.mesh).unwrap();
    let (system, outcome) = solve(&mesh, &model);
    let results = recover(&system, &outcome.state);
    for r in &results {
        near(r.shear[0], -2.0, 2.0, "q_xz");
        near(r.shear[1], 0.0, 2.0, "q_yz");
    }
    for middle in [4, 13] {
        let r = &results[middle];
        near(r.bending[0], 0.0, 2.0, "m_xx");
        near(r.von_mises, 3.0_f64.sqrt() * 1.5 * 2.0 / H, 2.0 / H, "von Mises");
    }
}

#[test]
fn the_energy_density_integrates_to_the_strain_energy() {
    let clamp = vec![Condition::Clamp(OnSet { on: "u_min".into() })];
    let (mesh, mut model) = plate(0.3, clamp, vec![Load::Edge(edge("u_max", [1.0, 2.0, -3.0]))]);
    model.analysis = Analysis::Static(StaticAnalysis::default());
    let (system, outcome) = solve(&mesh, &model);
    let results = recover(&system, &outcome.state);
    let sum: f64 = results.iter().map(|r| r.energy_density * r.area).sum();
    near(sum, outcome.balance.strain, outcome.balance.strain, "strain energy");
    near(results.iter().map(|r| r.area).sum(), 2.0, 2.0, "area");
}

/// The von Mises stress of hydrostatic pressure is 0, that of a single normal stress is its size, and that of a single
/// shear stress √3 times its size.
#[test]
fn equivalent_stress_of_three_dimensional_states() {
    assert_eq!(equivalent(&Vector6::new(7.0, 7.0, 0.0, 7.0, 0.0, 0.0)), 0.0);
    for (i, expected) in
        [1.0, 1.0, 3.0_f64.sqrt(), 1.0, 3.0_f64.sqrt(), 3.0_f64.sqrt()].into_iter().enumerate()
    {
        let mut s = Vector6::zeros();
        s[i] = -2.0;
        near(equivalent(&s), 2.0 * expected, 1.0, &format!("component {i}"));
    }
}

/// A sheet of a three-dimensional material between rigid plates: ε_xx alone gives σ_xx = (λ + 2G) ε and
/// σ_yy = σ_zz = λ ε, and their difference 2G ε is the equivalent stress.
#[test]
fn stress_over_a_held_thickness_counts() {
    let (young, poisson, strain) = (2e6, 0.3, 1e-3);
    let all = [Axis::X, Axis::Y, Axis::Z];
    let stretch = PrescribeComponent {
        on: "u_max".into(),
        of: NodalVector::Position,
        component: Axis::X,
        value: 2.0 * strain,
        amplitude: None,
    };
    let conditions = vec![
        fix("all", &[Axis::Y, Axis::Z], &all),
        fix("u_min", &[Axis::X], &[]),
        Condition::Prescribe(stretch),
    ];
    let (mesh, mut model) = plate(poisson, conditions, Vec::new());
    model.sections[0].element = ElementKind::Cm;
    let (system, outcome) = solve(&mesh, &model);
    let shear = 0.5 * young / (1.0 + poisson);
    for r in super::recover(&system, &outcome.state) {
        near(r.von_mises, 2.0 * shear * strain, shear * strain, "equivalent stress");
    }
}
