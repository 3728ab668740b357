//! Sheets that meet at an angle: folds and junctions against frame theory.
use crate::common;
use std::collections::BTreeMap;

use tegula::analysis::{Silent, modal, statics};
use tegula::mesh::Mesh;
use tegula::mesh::generators::generate;
use tegula::model::{
    Analysis, Axis, Condition, ElementKind, ExtrusionMesh, FixComponents, Grid, Isotropic, Load, Material,
    MeshSource, ModalAnalysis, Model, NodalVector, OnSet, PrescribeComponent, Section, StaticAnalysis,
    VectorLoad,
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
    let system = tegula::compile::build(model, mesh).unwrap();
    let Analysis::Static(options) = &model.analysis else { unreachable!() };
    let outcome = statics::run(&system, options, None, &mut Silent).unwrap();
    let node = mesh.nodes_on(set).unwrap()[0];
    let u = outcome.state.u[system.coordinates.position_of[node as usize] as usize];
    (system, u)
}

fn linear(model: &mut Model, loads: Vec<Load>) {
    model.loads = loads;
    model.analysis = Analysis::Static(StaticAnalysis { linear: true, ..Default::default() });
}

/// Sum of a load over an edge of the strip, as a load per length.
fn spread(on: &str, force: [f64; 3]) -> VectorLoad {
    VectorLoad { on: on.into(), value: force.map(|f| f / WIDTH), amplitude: None, distribution: None }
}

/// Second moment of area of a strip.
fn inertia(h: f64) -> f64 {
    WIDTH * h.powi(3) / 12.0
}

/// An L of two arms of length 1, clamped at the foot, pushed sideways at the top: bending of both arms,
/// `u = F/EI (L₂³/3 + L₁ L₂²)`, with the stretch of the first and the shear of the second arm. The error falls with the
/// mesh at any thickness.
#[test]
fn l_frames_converge_to_beam_theory_at_any_thickness() {
    for h in [0.1, 0.05, 0.02] {
        let mut errors = Vec::new();
        for n in [10, 40, 160] {
            let mut model = strip(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 1.0]], 2 * n);
            model.sections[0].thickness = h;
            let force = 1e-4;
            linear(&mut model, vec![Load::Edge(spread("u_max", [force, 0.0, 0.0]))]);
            let mesh = generate(&model.mesh).unwrap();
            let (system, u) = deflection(&model, &mesh, "u_max_v_min");
            let area = WIDTH * h;
            let expected = force / (E * inertia(h)) * (1.0 / 3.0 + 1.0)
                + force / (E * area)
                + force / (5.0 / 6.0 * 0.5 * E * area);
            errors.push((u[0] / expected - 1.0).abs());
            // One more director at each of the three nodes of the fold.
            assert_eq!(system.vectors(), 2 * mesh.positions.len() + 3);
        }
        println!("h = {h}: {errors:?}");
        assert!(errors[2] < 1e-4 && errors[1] < 0.2 * errors[0] && errors[2] < 0.2 * errors[1], "{errors:?}");
    }
}

/// A prescribed director of a fold turns the fold as a whole: the foot of an L of length 1 bends with the energy
/// `½ EI φ²`, and the other arm goes along without strain.
#[test]
fn a_prescribed_director_of_a_fold_turns_all_sheets() {
    for element in [ElementKind::Ems, ElementKind::Cm] {
        let mut model = strip(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 1.0]], 40);
        model.sections[0].element = element;
        linear(&mut model, Vec::new());
        let mut mesh = generate(&model.mesh).unwrap();
        let fold = |x: &Vec3| (x - Vec3::new(1.0, x.y, 0.0)).norm() < 1e-9;
        let nodes: Vec<u32> =
            (0..mesh.positions.len() as u32).filter(|&n| fold(&mesh.positions[n as usize])).collect();
        let first = nodes[0] as usize;
        mesh.node_sets.insert("fold".into(), nodes);
        // The first director is that of the foot, (0, 0, 1): turned about y, it moves along x.
        let turned = 1e-3;
        model.conditions.push(Condition::Prescribe(PrescribeComponent {
            on: "fold".into(),
            of: NodalVector::Director,
            component: Axis::X,
            value: turned,
            amplitude: None,
        }));
        let system = tegula::compile::build(&model, &mesh).unwrap();
        let director = system.coordinates.reference[system.coordinates.director_of[first] as usize];
        assert!((director[2].abs() - 1.0).abs() < 1e-12, "{director:?}");
        let Analysis::Static(options) = &model.analysis else { unreachable!() };
        let outcome = statics::run(&system, options, None, &mut Silent).unwrap();
        let exact = 0.5 * E * inertia(H) * turned * turned;
        let found = outcome.balance.strain;
        assert!((found / exact - 1.0).abs() < 5e-3, "{element:?}: {found:e} for {exact:e}");
    }
}

/// A moment at the end bends a folded strip to one curvature, which all elements contain: position and angle of the fold
/// make no difference, and the tie adds its thousandth of an element's rotation.
#[test]
fn folds_of_any_angle_pass_on_a_moment_alike() {
    for element in [ElementKind::Ems, ElementKind::Mitc4, ElementKind::Cm, ElementKind::SolidShell] {
        for h in [0.1, 0.005] {
            let mut errors = Vec::new();
            for degrees in [20.0, 45.0, 90.0, 135.0, 160.0_f64] {
                let t = Vec3::new(degrees.to_radians().cos(), 0.0, degrees.to_radians().sin());
                let mut model = strip(&[[0.0; 3], [1.0, 0.0, 0.0], (Vec3::x() + t).into()], 16);
                model.sections[0].element = element;
                model.sections[0].thickness = h;
                let moment = 1e-3 * E * inertia(h);
                linear(&mut model, vec![Load::EdgeMoment(spread("u_max", [0.0, moment, 0.0]))]);
                let mesh = generate(&model.mesh).unwrap();
                let (_, u) = deflection(&model, &mesh, "u_max_v_min");
                // u = ∫ ω × t ds with ω = κ s about y.
                let expected = 1e-3 * Vec3::y().cross(&(Vec3::x() * 0.5 + t * 1.5));
                errors.push((Vec3::from(u) - expected).norm() / expected.norm());
            }
            println!("{element:?}, h = {h}: {errors:?}");
            // Half a thousandth of an element's rotation, κ/8, over an arm of 1, of 0.7 κ to 2 κ.
            assert!(errors.iter().all(|e| *e < 1e-4), "{element:?}, h = {h}: {errors:?}");
        }
    }
}

/// Tension along the fold makes both sheets narrower and thinner alike: their angle stays.
#[test]
fn tension_along_a_fold_does_not_open_it() {
    for element in [ElementKind::Ems, ElementKind::Cm, ElementKind::SolidShell] {
        for degrees in [30.0, 90.0, 140.0_f64] {
            let t = Vec3::new(degrees.to_radians().cos(), 0.0, degrees.to_radians().sin());
            let mut model = strip(&[[0.0; 3], [1.0, 0.0, 0.0], (Vec3::x() + t).into()], 16);
            model.materials.insert("m".into(), Material::Isotropic(Isotropic::new(E, 0.3, 0.0)));
            model.sections[0].element = element;
            let fix = |set: &str, position: Vec<Axis>, director: Vec<Axis>| {
                Condition::Fix(FixComponents { on: set.into(), position, director })
            };
            model.conditions = vec![
                fix("v_min", vec![Axis::Y], vec![]),
                fix("u_min_v_min", vec![Axis::X, Axis::Z], vec![Axis::X]),
            ];
            let strain = 1e-3;
            let pull = Load::Edge(VectorLoad {
                on: "v_max".into(),
                value: [0.0, strain * E * H, 0.0],
                amplitude: None,
                distribution: None,
            });
            linear(&mut model, vec![pull]);
            let mesh = generate(&model.mesh).unwrap();
            let (_, u) = deflection(&model, &mesh, "u_max_v_max");
            let expected = (Vec3::x() + t) * (-0.3 * strain) + Vec3::y() * (strain * WIDTH);
            let error = (Vec3::from(u) - expected).norm() / expected.norm();
            assert!(error < 1e-8, "{element:?}, {degrees}: {error:.1e}");
        }
    }
}

/// Sheets of length 1 and n elements that begin at a common edge along y, in the directions given (degrees from x
/// towards z), with quad sets and end edges `0`, `1`, …
fn star(directions: &[f64], n: u32) -> Mesh {
    let mut mesh = Mesh::default();
    let columns = [0.0, 0.5 * WIDTH, WIDTH];
    let axis = columns.map(|y| add(&mut mesh, Vec3::y() * y));
    for (k, degrees) in directions.iter().enumerate() {
        let t = Vec3::new(degrees.to_radians().cos(), 0.0, degrees.to_radians().sin());
        let mut last = axis;
        for i in 1..=n {
            let next = columns.map(|y| add(&mut mesh, t * (f64::from(i) / f64::from(n)) + Vec3::y() * y));
            for j in 0..2 {
                mesh.quad_sets.entry(format!("sheet{k}")).or_default().push(mesh.quads.len() as u32);
                mesh.quads.push([last[j], next[j], next[j + 1], last[j + 1]]);
            }
            last = next;
        }
        mesh.edge_sets.insert(format!("end{k}"), vec![[last[0], last[1]], [last[1], last[2]]]);
    }
    mesh
}

/// A moment at the end of the last sheet of a T, Y, cross or fan, the others clamped at their ends: the joint turns by
/// `θ = M / Σ EI/L (4 + φ)/(1 + φ)` of those, `φ = 12 EI/(5/6 G A L²)`, and the end moves by `θ L + M L²/2EI` across.
#[test]
fn junctions_turn_as_stiff_frames() {
    let frames: [(&str, &[f64], &[f64]); 6] = [
        ("T", &[0.0, 180.0, 90.0], &[0.02, 0.02, 0.02]),
        ("T with a thick flange", &[0.0, 180.0, 90.0], &[0.05, 0.05, 0.005]),
        ("T with a thick web", &[0.0, 180.0, 90.0], &[0.01, 0.01, 0.1]),
        ("Y", &[90.0, 210.0, 330.0], &[0.02, 0.02, 0.02]),
        ("cross", &[0.0, 90.0, 180.0, 270.0], &[0.02, 0.02, 0.02, 0.02]),
        ("fan", &[0.0, 30.0, 140.0, 165.0], &[0.02, 0.005, 0.005, 0.02]),
    ];
    for (name, directions, thickness) in frames {
        let mut errors = Vec::new();
        for n in [10, 40] {
            let mesh = star(directions, n);
            let mut model = strip(&[[0.0; 3], [1.0, 0.0, 0.0]], 1);
            let last = directions.len() - 1;
            model.sections = (0..=last)
                .map(|k| Section { on: format!("sheet{k}"), ..Section::new("m", thickness[k]) })
                .collect();
            model.conditions = (0..last).map(|k| Condition::Clamp(OnSet { on: format!("end{k}") })).collect();
            let moment = 1e-3 * E * inertia(thickness[last]);
            linear(&mut model, vec![Load::EdgeMoment(spread(&format!("end{last}"), [0.0, -moment, 0.0]))]);
            let (_, u) = deflection(&model, &mesh, &format!("end{last}"));
            let stiffness = |h: f64| {
                let phi = h * h / (5.0 / 6.0 * 0.5);
                E * inertia(h) * (4.0 + phi) / (1.0 + phi)
            };
            let joint = moment / thickness[..last].iter().map(|h| stiffness(*h)).sum::<f64>();
            let angle = directions[last].to_radians();
            let across = -u[0] * angle.sin() + u[2] * angle.cos();
            errors.push((across / (joint + 0.5e-3) - 1.0).abs());
        }
        println!("{name}: {errors:?}");
        assert!(errors[0] < 0.02 && errors[1] < 2e-3, "{name}: {errors:?}");
    }
}

/// A square tube of side a under opposite line loads P at the middle of its flanges: corner moments P a/16, so that the
/// loads approach each other by `P a³ (5/192)/EI`, shear and axial forces apart.
#[test]
fn a_square_tube_is_squeezed_as_a_frame() {
    let h = 0.02;
    for (n, tolerance) in [(10, 2e-2), (80, 5e-4)] {
        let square = [[0.5, 0.0], [1.0, 0.0], [1.0, 1.0], [0.5, 1.0], [0.0, 1.0], [0.0, 0.0], [0.5, 0.0]];
        let mut model = strip(&square.map(|[x, z]| [x, 0.0, z]), 4 * n);
        let mut mesh = generate(&model.mesh).unwrap();
        for (set, z) in [("bottom", 0.0), ("top", 1.0)] {
            let here = |x: &Vec3| (x - Vec3::new(0.5, x.y, z)).norm() < 1e-9;
            let mut nodes: Vec<u32> =
                (0..mesh.positions.len() as u32).filter(|&n| here(&mesh.positions[n as usize])).collect();
            nodes.sort_by(|a, b| mesh.positions[*a as usize].y.total_cmp(&mesh.positions[*b as usize].y));
            mesh.edge_sets.insert(set.into(), nodes.windows(2).map(|n| [n[0], n[1]]).collect());
        }
        model.conditions = vec![Condition::Clamp(OnSet { on: "bottom".into() })];
        let force = 1e-4;
        linear(&mut model, vec![Load::Edge(spread("top", [0.0, 0.0, -force]))]);
        let (_, u) = deflection(&model, &mesh, "top");
        let area = WIDTH * h;
        let expected = force * 5.0 / 192.0 / (E * inertia(h))
            + 2.0 * 0.25 * force / (5.0 / 6.0 * 0.5 * E * area)
            + 0.5 * force / (E * area);
        let error = (-u[2] / expected - 1.0).abs();
        println!("tube, {n}: {error}");
        assert!(error < tolerance, "{error}");
    }
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
        distribution: None,
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
    model.analysis = Analysis::Modal(ModalAnalysis::new(12));
    let system = tegula::compile::build(&model, &mesh).unwrap();
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
        distribution: None,
    })];
    model.analysis = Analysis::Static(StaticAnalysis { linear: true, ..Default::default() });
    let mesh = generate(&model.mesh).unwrap();
    let system = tegula::compile::build(&model, &mesh).unwrap();
    let outcome =
        statics::run(&system, &StaticAnalysis { linear: true, ..Default::default() }, None, &mut Silent)
            .unwrap();
    // At a corner: between the corners the end of the flanges hangs through under its own share of the load.
    let node = mesh.nearest_node(Vec3::new(0.0, 1.0, 0.0)).unwrap();
    let u = outcome.state.u[system.coordinates.position_of[node as usize] as usize][2];
    let h = 0.004;
    let inertia = 2.0 * (h * a.powi(3) / 12.0 + a * h * a * a / 4.0);
    let shear = force / (0.5 * E * 2.0 * h * a);
    let expected = -(force / (3.0 * E * inertia) + shear);
    println!("box: {u} of {expected}");
    assert!((u / expected - 1.0).abs() < 0.03, "{u} instead of {expected}");
}
