//! Beams of MacNeal and Harder: straight, curved and twisted cantilevers made of one or two rows of shells.
//!
//! R. H. MacNeal, R. L. Harder, Finite Elements in Analysis and Design 1 (1985) 3–20. The coarse meshes are those of
//! the paper. Their results are tabulated without a tolerance, because a bilinear element of 45° trapezoids cannot
//! represent in-plane bending. The limit is verified: each mesh, with its quads divided into 4 × 4 to 16 × 16, meets
//! beam theory within 1 %.
//!
//! Three values of the paper are replaced by closed forms, with which the finest meshes are compared; they neglect end
//! effects, below 1 %:
//! - the twist of the straight beam, 0.03208, where Saint-Venant's torsion of the 2:1 rectangle gives 0.03411
//!   (`twist`);
//! - the curved beam in its plane, 0.08734, where plane elasticity gives 0.08857 (`curved_bar`);
//! - the curved beam out of its plane, 0.5022, because its torsion depends on the shear correction
//!   (`curved_out_of_plane`).

use std::f64::consts::{FRAC_PI_2, PI};

use tegula::analysis::Silent;
use tegula::compile::build;
use tegula::model::{
    Analysis, Axis, Condition, Grid, Isotropic, Load, MeshSource, Model, NodalVector, OnSet, PlateMesh,
    PrescribeComponent, StaticAnalysis, VectorLoad,
};
use tegula::{Mesh, Result, Vec3};

use super::model::switch;
use super::reference::records;
use super::report::{Report, Table};
use super::statistics::run_static;
use super::{Case, Cost};

/// Cases of this file.
pub(super) const CASES: &[Case] = &[Case {
    name: "macneal-harder-beams",
    about: "MacNeal and Harder: straight, curved and twisted beams, coarse and fine",
    cost: Cost::Normal,
    run: all,
}];

const REFERENCE: &str = include_str!("../../reference/macneal_harder.csv");
const CASE: &str = "macneal-harder-beams";
const ELEMENTS: [&str; 4] = ["ems", "cm", "mitc4", "solid-shell"];

/// A map from (u, v), counted in coarse elements, to position and unit normal.
type Map = fn(f64, f64) -> (Vec3, Vec3);

/// Load at the tip.
#[derive(Clone, Copy)]
enum Tip {
    /// A force of 1, shared out over the edge as a constant line load; its direction.
    Force([f64; 3]),
    /// A moment of 1 about x, the edge staying straight but free to warp.
    Twist,
}

struct Beam {
    name: &'static str,
    /// Name in the table of references.
    problem: &'static str,
    map: Map,
    elements: [u32; 2],
    /// Parts of a coarse quad along each edge in the fine mesh.
    parts: u32,
    material: fn() -> Isotropic,
    thickness: f64,
    loads: &'static [BeamLoad],
}

/// Name, load, and the closed form, of the shear correction factor, where the paper's value is none.
type BeamLoad = (&'static str, Tip, Option<fn(f64) -> f64>);

fn light(poisson: f64) -> Isotropic {
    Isotropic::new(1e7, poisson, 1.0)
}

/// Straight beam 6 × 0.2; `shift` is by how much the lower and upper ends of the line i between elements move.
fn straight(u: f64, v: f64, shift: fn(i32) -> [f64; 2]) -> (Vec3, Vec3) {
    let line = |i: i32| {
        let [lower, upper] = if (1..6).contains(&i) { shift(i) } else { [0.0; 2] };
        f64::from(i) + lower * (1.0 - v) + upper * v
    };
    let i = (u.floor() as i32).clamp(0, 5);
    let s = u - f64::from(i);
    (Vec3::new(line(i) * (1.0 - s) + line(i + 1) * s, 0.2 * v, 0.0), Vec3::z())
}

fn regular(u: f64, v: f64) -> (Vec3, Vec3) {
    straight(u, v, |_| [0.0; 2])
}

fn trapezoids(u: f64, v: f64) -> (Vec3, Vec3) {
    straight(u, v, |i| if i % 2 == 0 { [-0.1, 0.1] } else { [0.1, -0.1] })
}

fn parallelograms(u: f64, v: f64) -> (Vec3, Vec3) {
    straight(u, v, |_| [-0.1, 0.1])
}

/// Quarter circle from (0, R) to (R, 0), clamped at the first.
fn curved(u: f64, v: f64) -> (Vec3, Vec3) {
    let (radius, angle) = (4.12 + 0.2 * v, FRAC_PI_2 * (1.0 - u / 6.0));
    (Vec3::new(radius * angle.cos(), radius * angle.sin(), 0.0), Vec3::z())
}

/// Length 12, width 1.1, twisted by 90°; the root lies across y.
fn twisted(u: f64, v: f64) -> (Vec3, Vec3) {
    let (angle, across) = (FRAC_PI_2 * u / 12.0, 1.1 * (0.5 * v - 0.5));
    let (sin, cos) = angle.sin_cos();
    let rate = across * FRAC_PI_2 / 12.0;
    let normal = Vec3::new(1.0, -rate * sin, rate * cos).cross(&Vec3::new(0.0, cos, sin)).normalize();
    (Vec3::new(u, across * cos, across * sin), normal)
}

/// Torsion constant of the rectangle 0.2 × 0.1: Saint-Venant's series.
fn saint_venant() -> f64 {
    let (b, t) = (0.2, 0.1);
    let series: f64 =
        (1..200).step_by(2).map(f64::from).map(|n| (0.5 * n * PI * b / t).tanh() / n.powi(5)).sum();
    b * t * t * t / 3.0 * (1.0 - 192.0 / PI.powi(5) * t / b * series)
}

/// Torsion constant of a strip of shell with the shear correction factor k: J = b t³/3 (1 − tanh x / x) with
/// x = √(12 k) b/(2 t), from the layers at the free edges in which the twisting moment fades.
///
/// It is Saint-Venant's within 0.2 % for k = 5/6 and 3.8 % above for k = 1.
fn strip_torsion(factor: f64) -> f64 {
    let (b, t): (f64, f64) = (0.2, 0.1);
    let x = 0.5 * (12.0 * factor).sqrt() * b / t;
    b * t.powi(3) / 3.0 * (1.0 - x.tanh() / x)
}

/// Twist of the straight beam under a moment of 1.
fn twist(factor: f64) -> f64 {
    6.0 / (1e7 / 2.6 * strip_torsion(factor))
}

/// Deflection of the curved beam under a force of 1 normal to its plane: bending, torsion and shear of a thin ring.
fn curved_out_of_plane(factor: f64) -> f64 {
    let (radius, b, t): (f64, f64, f64) = (4.22, 0.2, 0.1);
    let shear = 1e7 / 2.5;
    let bending = 0.25 * PI / (1e7 * b * t.powi(3) / 12.0);
    let torsion = (0.75 * PI - 2.0) / (shear * strip_torsion(factor));
    radius.powi(3) * (bending + torsion) + radius * FRAC_PI_2 / (factor * shear * b * t)
}

/// Deflection of the curved beam under a radial force of 1 at its end: S. P. Timoshenko, J. N. Goodier, Theory of
/// Elasticity, 3rd ed. 1970, art. 33.
fn curved_bar(_: f64) -> f64 {
    let (a, b): (f64, f64) = (4.12, 4.32);
    let squares = a * a + b * b;
    PI * squares / (1e7 * 0.1 * (a * a - b * b + squares * (b / a).ln()))
}

const IN_PLANE: [f64; 3] = [0.0, 1.0, 0.0];
const OUT_OF_PLANE: [f64; 3] = [0.0, 0.0, 1.0];
const STRAIGHT: &[BeamLoad] = &[
    ("extension", Tip::Force([1.0, 0.0, 0.0]), None),
    ("in-plane shear", Tip::Force(IN_PLANE), None),
    ("out-of-plane shear", Tip::Force(OUT_OF_PLANE), None),
    ("twist", Tip::Twist, Some(twist)),
];

fn beams() -> [Beam; 5] {
    let straight = |name, map| Beam {
        name,
        problem: "straight",
        map,
        elements: [6, 1],
        parts: 16,
        material: || light(0.3),
        thickness: 0.1,
        loads: STRAIGHT,
    };
    [
        straight("straight, regular", regular),
        straight("straight, trapezoids", trapezoids),
        straight("straight, parallelograms", parallelograms),
        Beam {
            name: "curved",
            problem: "curved",
            map: curved,
            elements: [6, 1],
            parts: 16,
            material: || light(0.25),
            thickness: 0.1,
            loads: &[
                // Along the cut at the tip, which lies on the x axis.
                ("in-plane shear", Tip::Force([1.0, 0.0, 0.0]), Some(curved_bar)),
                ("out-of-plane shear", Tip::Force(OUT_OF_PLANE), Some(curved_out_of_plane)),
            ],
        },
        Beam {
            name: "twisted",
            problem: "twisted",
            map: twisted,
            elements: [12, 2],
            parts: 4,
            material: || Isotropic::new(29e6, 0.22, 1.0),
            thickness: 0.32,
            loads: &[
                // Along the width and the thickness of the tip, which is turned by 90°.
                ("in-plane shear", Tip::Force(OUT_OF_PLANE), None),
                ("out-of-plane shear", Tip::Force(IN_PLANE), None),
            ],
        },
    ]
}

/// All beams, loads and elements.
pub fn all(report: &mut Report) -> Result<()> {
    let references = records(REFERENCE);
    report.element("series");
    let shell = strip_torsion(5.0 / 6.0);
    report.relative(CASE, "torsion constant of the shell, Saint-Venant", "", shell, saint_venant(), 5e-3);
    let mut columns = vec!["beam", "load", "mesh"];
    columns.extend(ELEMENTS);
    let mut table =
        Table::new("macneal-harder-beams", "MacNeal and Harder: tip displacement over theory", &columns);
    for beam in beams() {
        for &(load, tip, exact) in beam.loads {
            let row = references.iter().find(|r| r.text("problem") == beam.problem && r.text("load") == load);
            let paper = row.map_or(f64::NAN, |r| r.number("value"));
            for parts in [1, beam.parts] {
                let mesh = beam.elements.map(|n| (n * parts).to_string()).join("x");
                let mut cells = vec![beam.name.to_string(), load.to_string(), mesh.clone()];
                for element in ELEMENTS {
                    report.element(element);
                    let value = displacement(&beam, tip, element, parts)?;
                    // Elements with three-dimensional stresses have no correction.
                    let plane_stress = matches!(element, "ems" | "mitc4");
                    let theory = exact.map_or(paper, |f| f(if plane_stress { 5.0 / 6.0 } else { 1.0 }));
                    cells.push(format!("{:.3}", value / theory));
                    if parts > 1 {
                        let name = format!("{}: {load}", beam.name);
                        report.relative(CASE, &name, &mesh, value, theory, 0.01);
                        if beam.problem == "curved" && plane_stress {
                            let name = format!("{name}, paper");
                            report.relative(CASE, &name, &mesh, value, paper, 0.02);
                        }
                    }
                }
                table.cells.push(cells);
            }
        }
    }
    report.table(table);
    report.element("ems");
    Ok(())
}

/// Displacements at the tip over theory on the coarse meshes of the paper: name of the beam and load, value.
pub fn coarse(element: &str) -> Result<Vec<(String, f64)>> {
    let references = records(REFERENCE);
    let mut out = Vec::new();
    for beam in beams() {
        for &(load, tip, exact) in beam.loads.iter().filter(|(load, ..)| load.ends_with("shear")) {
            let row = references.iter().find(|r| r.text("problem") == beam.problem && r.text("load") == load);
            let theory = exact.map_or(row.map_or(f64::NAN, |r| r.number("value")), |f| f(5.0 / 6.0));
            out.push((format!("{}: {load}", beam.name), displacement(&beam, tip, element, 1)? / theory));
        }
    }
    Ok(out)
}

/// Nodes u fastest; each coarse quad cut into parts × parts.
fn mesh(beam: &Beam, parts: u32) -> Mesh {
    let [nu, nv] = beam.elements.map(|n| n * parts);
    let at = |i: u32, j: u32| (beam.map)(f64::from(i) / f64::from(parts), f64::from(j) / f64::from(parts));
    let node = |i: u32, j: u32| j * (nu + 1) + i;
    let mut mesh = Mesh::default();
    let mut normals = Vec::new();
    for j in 0..=nv {
        mesh.positions.extend((0..=nu).map(|i| at(i, j).0));
    }
    for (j, i) in (0..nv).flat_map(|j| (0..nu).map(move |i| (j, i))) {
        let mut corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
        let [a, b, _, d] = corners.map(|(i, j)| at(i, j).0);
        // Counter-clockwise about the normal.
        if (b - a).cross(&(d - a)).dot(&at(i, j).1) < 0.0 {
            corners.swap(1, 3);
        }
        mesh.quads.push(corners.map(|(i, j)| node(i, j)));
        normals.push(corners.map(|(i, j)| at(i, j).1));
    }
    mesh.normals = Some(normals);
    mesh.node_sets.insert("root".into(), (0..=nv).map(|j| node(0, j)).collect());
    for j in 0..=nv {
        mesh.node_sets.insert(format!("tip-{j}"), vec![node(nu, j)]);
    }
    mesh
}

/// Displacement of the force along it, or twist under the moment.
fn displacement(beam: &Beam, tip: Tip, element: &str, parts: u32) -> Result<f64> {
    let mesh = mesh(beam, parts);
    let source = MeshSource::Plate(PlateMesh {
        origin: [0.0; 3],
        u_axis: [1.0, 0.0, 0.0],
        v_axis: [0.0, 1.0, 0.0],
        size: [1.0; 2],
        grid: Grid::uniform(1, 1),
    });
    let options = StaticAnalysis { linear: true, ..StaticAnalysis::default() };
    let analysis = Analysis::Static(options.clone());
    let mut model = Model::new(source, analysis, (beam.material)(), beam.thickness);
    switch(&mut model, element);
    model.conditions.push(Condition::Clamp(OnSet { on: "root".into() }));
    let across = beam.elements[1] * parts;
    let share = |j: u32| if j == 0 || j == across { 0.5 } else { 1.0 } / f64::from(across);
    let along = beam.elements[0] * parts;
    let tip_node = |j: u32| (j * (along + 1) + along) as usize;
    for j in 0..=across {
        let on = format!("tip-{j}");
        match tip {
            Tip::Force(direction) => {
                let value = direction.map(|x| x * share(j));
                model.loads.push(Load::Force(VectorLoad { on, value, amplitude: None, distribution: None }));
            }
            Tip::Twist => {
                let (of, component, value) = (NodalVector::Position, Axis::Z, mesh.positions[tip_node(j)].y);
                let p = PrescribeComponent { on, of, component, value, amplitude: None };
                model.conditions.push(Condition::Prescribe(p));
            }
        }
    }
    let system = build(&model, &mesh)?;
    let outcome = run_static(&system, &options, None, &mut Silent)?;
    Ok(match tip {
        Tip::Force(direction) => (0..=across)
            .map(|j| {
                let u = Vec3::from(outcome.state.u[system.coordinates.position_of[tip_node(j)] as usize]);
                share(j) * u.dot(&Vec3::from(direction))
            })
            .sum(),
        // Twisted by 1, the work ½ T is the strain energy; linear, so the twist under T = 1 is 1/T.
        Tip::Twist => 0.5 / outcome.balance.strain,
    })
}
