//! Sheets that meet at an angle: folds and junctions against frame theory.
#![allow(clippy::unwrap_used)]
mod common;

use std::collections::BTreeMap;

use tegula::analysis::{Silent, modal, statics};
use tegula::mesh::Mesh;
use tegula::mesh::generators::generate;
use tegula::model::{
    Analysis, Condition, ExtrusionMesh, Grid, Isotropic, Load, Material, MeshSource, ModalAnalysis, Model,
    OnSet, StaticAnalysis, VectorLoad, build,
};
use tegula::{System, Vec3};

const E: f64 = 1e7;
const H: f64 = 0.02;
const WIDTH: f64 = 0.1;

fn strip(vertices: &[[f64; 3]], elements: u32) -> Model {
    let mesh = MeshSource::Extrusion(ExtrusionMesh {
        vertices: vertices.to_vec(),
        sweep: [0.0, WIDTH, 0.0],
        grid: Grid::uniform(elements, 2),
    });
    let mut model = common::model(mesh, E, H);
    model.materials = BTreeMap::from([("m".into(), Material::Isotropic(Isotropic::new(E, 0.0, 1000.0)))]);
    model
}

fn deflection(model: &Model, mesh: &Mesh, set: &str) -> (System, [f64; 3]) {
    let system = build::build(model, mesh).unwrap();
    let Analysis::Static(options) = &model.analysis else { unreachable!() };
    let outcome = statics::run(&system, options, None, &mut Silent).unwrap();
    let node = mesh.nodes_on(set).unwrap()[0];
    let u = outcome.state.u[system.position_of[node as usize] as usize];
    (system, u)
}

/// An L of two arms of length 1, clamped at the foot, pushed sideways at the top: bending of both arms,
/// `u = F/EI (L₂³/3 + L₁ L₂²)` with the shear of the second arm.
#[test]
fn an_l_frame_bends_as_one_beam() {
    let mut model = strip(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 1.0]], 64);
    let force = 1e-4;
    model.loads = vec![Load::Edge(VectorLoad {
        on: "u_max".into(),
        value: [force / WIDTH, 0.0, 0.0],
        amplitude: None,
    })];
    model.analysis = Analysis::Static(StaticAnalysis { linear: true, ..Default::default() });
    let mesh = generate(&model.mesh).unwrap();
    let (system, u) = deflection(&model, &mesh, "u_max_v_min");
    let inertia = WIDTH * H.powi(3) / 12.0;
    let shear = force / (5.0 / 6.0 * 0.5 * E * WIDTH * H);
    let expected = force / (E * inertia) * (1.0 / 3.0 + 1.0) + shear;
    println!("L-frame: {} of {expected}", u[0]);
    assert!((u[0] / expected - 1.0).abs() < 2e-3, "{} instead of {expected}", u[0]);
    // One more director at each of the three nodes of the fold.
    assert_eq!(system.vectors(), 2 * mesh.positions.len() + 3);
}

/// Large rotations: the frame turned as a whole by its load keeps its right angle.
#[test]
fn the_angle_of_a_fold_is_kept_under_large_rotation() {
    let mut model = strip(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.2]], 48);
    let inertia = WIDTH * H.powi(3) / 12.0;
    // A moment that bends the long arm to a right angle turns the short one upside down with it.
    let moment = std::f64::consts::FRAC_PI_2 * E * inertia / WIDTH;
    model.loads = vec![Load::EdgeMoment(VectorLoad {
        on: "u_max".into(),
        value: [0.0, -moment, 0.0],
        amplitude: None,
    })];
    model.analysis = Analysis::Static(StaticAnalysis { load_steps: 10, ..Default::default() });
    let mesh = generate(&model.mesh).unwrap();
    let (_, u) = deflection(&model, &mesh, "u_max_v_min");
    let at = |x: f64, z: f64| mesh.nearest_node(Vec3::new(x, 0.0, z)).unwrap();
    assert_eq!(at(1.0, 0.2), mesh.nodes_on("u_max_v_min").unwrap()[0]);
    // Long arm: quarter circle of radius 2/π, its end points up; the short arm bends on by a fifth of that.
    let r = 2.0 / std::f64::consts::PI;
    let short = |s: f64| (r * (1.0 - (s / r).cos()), r * (s / r).sin());
    let (sag, along) = short(0.2);
    let end = [r - along, r - sag];
    let found = [1.0 + u[0], 0.2 + u[2]];
    println!("{found:?} of {end:?}");
    for i in 0..2 {
        assert!((found[i] - end[i]).abs() < 5e-3, "{found:?} instead of {end:?}");
    }
}

/// A cross of four sheets, free: six rigid modes and nothing loose between the sheets.
#[test]
fn a_junction_of_four_sheets_has_six_rigid_modes() {
    let n = 4;
    let mut mesh = Mesh::default();
    let axis: Vec<u32> = (0..=n).map(|j| add(&mut mesh, Vec3::new(0.0, f64::from(j) * 0.1, 0.0))).collect();
    for direction in [Vec3::x(), Vec3::z(), -Vec3::x(), -Vec3::z()] {
        let mut last = axis.clone();
        for i in 1..=n {
            let next: Vec<u32> = (0..=n)
                .map(|j| add(&mut mesh, direction * (f64::from(i) * 0.1) + Vec3::y() * (f64::from(j) * 0.1)))
                .collect();
            for j in 0..n as usize {
                mesh.quads.push([last[j], next[j], next[j + 1], last[j + 1]]);
            }
            last = next;
        }
    }
    let mut model = strip(&[[0.0; 3], [1.0, 0.0, 0.0]], 1);
    model.conditions.clear();
    model.analysis = Analysis::Modal(ModalAnalysis { modes: 12, prestressed: false });
    let system = build::build(&model, &mesh).unwrap();
    let outcome = modal::run(&system, 12, None, &mut Silent).unwrap();
    let rigid = outcome.modes.iter().filter(|m| m.rigid).count();
    let frequencies: Vec<f64> = outcome.modes.iter().map(|m| m.frequency_hz).collect();
    println!("{frequencies:?}");
    assert_eq!(rigid, 6, "{frequencies:?}");
    // A sheet hinged at the junction would swing at almost nothing; clamped, a cantilever of length 0.4 swings at
    // 3.516/2π √(EI/ρA)/L².
    let cantilever = 3.516 / std::f64::consts::TAU * (E * H * H / 12.0 / 1000.0).sqrt() / 0.16;
    assert!(frequencies[6] > 0.5 * cantilever, "{frequencies:?}, cantilever {cantilever}");
}

fn add(mesh: &mut Mesh, x: Vec3) -> u32 {
    mesh.positions.push(x);
    mesh.positions.len() as u32 - 1
}

/// A box girder needs its corners: without them the webs would fold like paper.
#[test]
fn a_closed_box_bends_as_a_beam() {
    let a = 0.1;
    let mesh = MeshSource::Extrusion(ExtrusionMesh {
        vertices: vec![[0.0, 0.0, 0.0], [a, 0.0, 0.0], [a, 0.0, a], [0.0, 0.0, a], [0.0, 0.0, 0.0]],
        sweep: [0.0, 1.0, 0.0],
        grid: Grid::uniform(16, 40),
    });
    let mut model = common::model(mesh, E, 0.004);
    model.materials = BTreeMap::from([("m".into(), Material::Isotropic(Isotropic::new(E, 0.0, 0.0)))]);
    model.conditions = vec![Condition::Clamp(OnSet { on: "v_min".into() })];
    let force = 1e-3;
    model.loads = vec![Load::Edge(VectorLoad {
        on: "v_max".into(),
        value: [0.0, 0.0, -force / (4.0 * a)],
        amplitude: None,
    })];
    model.analysis = Analysis::Static(StaticAnalysis { linear: true, ..Default::default() });
    let mesh = generate(&model.mesh).unwrap();
    let system = build::build(&model, &mesh).unwrap();
    let outcome =
        statics::run(&system, &StaticAnalysis { linear: true, ..Default::default() }, None, &mut Silent)
            .unwrap();
    // At a corner: between the corners the end of the flanges hangs through under its own share of the load.
    let node = mesh.nearest_node(Vec3::new(0.0, 1.0, 0.0)).unwrap();
    let u = outcome.state.u[system.position_of[node as usize] as usize][2];
    let h = 0.004;
    let inertia = 2.0 * (h * a.powi(3) / 12.0 + a * h * a * a / 4.0);
    let shear = force / (0.5 * E * 2.0 * h * a);
    let expected = -(force / (3.0 * E * inertia) + shear);
    println!("box: {u} of {expected}");
    assert!((u / expected - 1.0).abs() < 0.03, "{u} instead of {expected}");
}
