//! Patch tests of all elements: a mesh of any shape must reproduce constant strains.
//!
//! R. H. MacNeal, R. L. Harder, *A proposed standard set of problems to test finite element accuracy*, Finite
//! Elements in Analysis and Design 1 (1985) 3–20: the membrane and the bending patch on their mesh; two more of the
//! same kind for transverse shear and stretch of the thickness. The boundary follows the exact field, what lies
//! inside must too. Linear.

use std::collections::BTreeSet;

use tegula::analysis::{Silent, State};
use tegula::compile::build;
use tegula::model::{
    Analysis, Axis, Condition, ElementKind, Isotropic, MeshSource, Model, NodalVector, PlateMesh,
    PrescribeComponent, StaticAnalysis,
};
use tegula::norm::{larger, max_norm};
use tegula::result::inside::{Inside, Snapshot};
use tegula::result::recover;
use tegula::system::{Shell, VectorKind};
use tegula::{Mesh, Result, System, Vec3};

use super::model::switch;
use super::report::{Report, Table};
use super::statistics::run_static;
use super::{Case, Cost};

/// Cases of this file.
pub(super) const CASES: &[Case] = &[Case {
    name: "patch",
    about: "patch tests of MacNeal and Harder for all elements",
    cost: Cost::Fast,
    run: all,
}];

const CASE: &str = "patch";
const NU: f64 = 0.25;
const H: f64 = 0.001;
/// Errors below are rounding.
const ROUNDING: f64 = 1e-8;

/// Change of position, director and gradients along x and y at a point of the plate.
type Field = fn(Vec3) -> [Vec3; 4];

/// Thickness strain of plane stress beside the strains ε_xx + ε_yy; only three-dimensional elements have one.
fn thinning(sum: f64) -> f64 {
    -NU / (1.0 - NU) * sum
}

fn membrane(x: Vec3, solid: bool) -> [Vec3; 4] {
    let d = if solid { thinning(2e-3) } else { 0.0 };
    [
        Vec3::new(x.x + 0.5 * x.y, x.y + 0.5 * x.x, 0.0) * 1e-3,
        Vec3::new(0.0, 0.0, d),
        Vec3::new(1e-3, 0.5e-3, 0.0),
        Vec3::new(0.5e-3, 1e-3, 0.0),
    ]
}

fn bending(x: Vec3) -> [Vec3; 4] {
    let slope = [x.x + 0.5 * x.y, x.y + 0.5 * x.x].map(|s| 1e-3 * s);
    [
        Vec3::new(0.0, 0.0, 0.5e-3 * (x.x * x.x + x.x * x.y + x.y * x.y)),
        Vec3::new(-slope[0], -slope[1], 0.0),
        Vec3::new(0.0, 0.0, slope[0]),
        Vec3::new(0.0, 0.0, slope[1]),
    ]
}

fn shear(x: Vec3) -> [Vec3; 4] {
    [
        Vec3::new(0.0, 0.0, 1e-3 * (x.x + 0.5 * x.y)),
        Vec3::zeros(),
        Vec3::new(0.0, 0.0, 1e-3),
        Vec3::new(0.0, 0.0, 0.5e-3),
    ]
}

fn thickness(_: Vec3) -> [Vec3; 4] {
    [Vec3::zeros(), Vec3::new(0.0, 0.0, 1e-3), Vec3::zeros(), Vec3::zeros()]
}

/// The mesh of MacNeal and Harder.
fn distorted() -> Mesh {
    let inner = [[0.04, 0.02], [0.18, 0.03], [0.16, 0.08], [0.08, 0.08]];
    mesh(inner)
}

/// MacNeal and Harder's patch with a rectangle inside.
fn regular() -> Mesh {
    mesh([[0.08, 0.04], [0.16, 0.04], [0.16, 0.08], [0.08, 0.08]])
}

fn mesh(inner: [[f64; 2]; 4]) -> Mesh {
    let outer = [[0.0, 0.0], [0.24, 0.0], [0.24, 0.12], [0.0, 0.12]];
    let positions = outer.into_iter().chain(inner).map(|[x, y]| Vec3::new(x, y, 0.0)).collect();
    let quads = vec![[4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];
    Mesh { positions, quads, ..Mesh::default() }
}

/// Greatest error over the greatest value of the field, of positions, directors and of what is `known` of the stress.
fn error(
    variant: &str,
    mut mesh: Mesh,
    field: Field,
    everywhere: &[NodalVector],
    known: Known,
) -> Result<f64> {
    let source = MeshSource::Plate(PlateMesh {
        origin: [0.0; 3],
        u_axis: [1.0, 0.0, 0.0],
        v_axis: [0.0, 1.0, 0.0],
        size: [1.0; 2],
        grid: tegula::model::Grid::uniform(1, 1),
    });
    let options = StaticAnalysis { linear: true, ..StaticAnalysis::default() };
    let mut model = Model::new(source, Analysis::Static(options.clone()), Isotropic::new(1e6, NU, 1.0), H);
    switch(&mut model, variant);
    let with_gradients = model.sections[0].element == ElementKind::AncfFull;
    let boundary: BTreeSet<u32> = mesh.boundary_edges().into_iter().flatten().collect();
    let all = [
        NodalVector::Position,
        NodalVector::Director,
        NodalVector::FirstGradient,
        NodalVector::SecondGradient,
    ];
    for node in 0..mesh.positions.len() as u32 {
        let name = format!("node-{node}");
        mesh.node_sets.insert(name.clone(), vec![node]);
        let values = field(mesh.positions[node as usize]);
        for (of, change) in all.into_iter().zip(values).take(if with_gradients { 4 } else { 2 }) {
            if !boundary.contains(&node) && !everywhere.contains(&of) {
                continue;
            }
            for (component, value) in [Axis::X, Axis::Y, Axis::Z].into_iter().zip(change.iter()) {
                let prescribe =
                    PrescribeComponent { on: name.clone(), of, component, value: *value, amplitude: None };
                model.conditions.push(Condition::Prescribe(prescribe));
            }
        }
    }
    let system = build(&model, &mesh)?;
    let outcome = run_static(&system, &options, None, &mut Silent)?;
    let (mut worst, mut size) = ([0.0_f64; 2], [0.0_f64; 2]);
    for (v, kind) in system.coordinates.kinds.iter().enumerate() {
        let exact = field(mesh.positions[system.coordinates.nodes[v] as usize]);
        let (i, exact) = match kind {
            VectorKind::Position => (0, exact[0]),
            VectorKind::Director => (1, exact[1]),
            VectorKind::Gradient => continue,
        };
        worst[i] = larger(worst[i], (Vec3::from(outcome.state.u[v]) - exact).norm());
        size[i] = larger(size[i], exact.norm());
    }
    let relative = |i: usize| if size[i] > 0.0 { worst[i] / size[i] } else { worst[i] / size[1 - i] };
    let mut error = larger(relative(0), relative(1));
    // Stresses too, by what does not depend on the frames of the elements.
    let trace = |v: [f64; 3]| v[0] + v[1];
    let results = recover(&system, &outcome.state);
    let (found, exact): (Vec<f64>, f64) = match known {
        Known::Membrane(exact) => (results.iter().map(|r| trace(r.membrane)).collect(), exact),
        Known::Bending(exact) => (results.iter().map(|r| trace(r.bending)).collect(), exact),
        Known::Shear(exact) => (results.iter().map(|r| r.shear[0].hypot(r.shear[1])).collect(), exact),
        Known::Thickness(exact) => (thickness_stresses(&system, &outcome.state), exact),
    };
    error = larger(error, max_norm(found.iter().map(|found| (found - exact) / exact)));
    Ok(error)
}

/// A constant that the stress of a patch test has.
#[derive(Clone, Copy)]
enum Known {
    /// n_xx + n_yy.
    Membrane(f64),
    /// m_xx + m_yy.
    Bending(f64),
    /// Length of (q_xz, q_yz).
    Shear(f64),
    /// Stress across the thickness.
    Thickness(f64),
}

/// Stress σ_zz at all integration points.
fn thickness_stresses(system: &System, state: &State) -> Vec<f64> {
    let snapshot = Snapshot::new(system, state);
    let of = |shell: &Shell| {
        let solid = system.sections[shell.section].element.is_solid();
        let thickness = if solid { 1.0 } else { H };
        let stresses = Inside::new(&snapshot, shell).map_or_else(Vec::new, |inside| inside.point_stresses());
        stresses.into_iter().map(move |s| s[3] / thickness)
    };
    system.shells.iter().flat_map(of).collect()
}

/// All elements, and what is expected of them.
pub fn all(report: &mut Report) -> Result<()> {
    let mut table = Table::new(
        "patch-tests",
        "Patch tests: error on a regular and on the distorted mesh of MacNeal and Harder",
        &["element", "mesh", "membrane", "bending", "transverse shear", "constant thickness"],
    );
    for (variant, solid, fails) in [
        ("EMS", false, &[][..]),
        ("MITC4", false, &[]),
        ("CM eas4+4", true, &[]),
        ("CM eas4+3", true, &[]),
        ("CM eas4+1", true, &["bending"]),
        ("CM no thickness EAS", true, &["bending"]),
        ("solid-shell EAS8", true, &[]),
        ("EMS assumed in-plane shear", false, &[]),
        ("CM assumed in-plane shear", true, &[]),
        ("EMS no ANS shear", false, &["bending"]),
        ("ancf-full", true, &["bending"]),
    ] {
        report.element(variant);
        for (name, mesh) in [("regular", regular as fn() -> Mesh), ("distorted", distorted)] {
            let membrane: Field = if solid { |x| membrane(x, true) } else { |x| membrane(x, false) };
            let tests: [(&str, Field, &[NodalVector]); 4] = [
                ("membrane", membrane, &[]),
                ("bending", bending, &[]),
                // Constant shear and constant stretch of the thickness with given directors: positions must follow.
                ("transverse shear", shear, &[NodalVector::Director]),
                ("constant thickness", thickness, &[NodalVector::Director]),
            ];
            let mut row = vec![variant.to_lowercase(), name.into()];
            for (test, field, everywhere) in tests {
                if variant == "MITC4" && test == "constant thickness" {
                    row.push("keeps its length".into());
                    continue;
                }
                // Both principal strains and curvatures sum up to 2e-3; κ is above 0 towards the director.
                let plane = 1e6 / (1.0 - NU) * 2e-3;
                // Elements with resultants have the shear correction 5/6 and a thickness of its own, E ε; the others
                // are solids that cannot give way in the plane.
                let g = 0.5e6 / (1.0 + NU);
                let confined = (1.0 - NU) / ((1.0 + NU) * (1.0 - 2.0 * NU));
                let known = match test {
                    "membrane" => Known::Membrane(plane * H),
                    "bending" => Known::Bending(plane * H.powi(3) / 12.0),
                    "transverse shear" => {
                        Known::Shear(if solid { 1.0 } else { 5.0 / 6.0 } * g * H * 1e-3 * 1.25_f64.sqrt())
                    }
                    _ => Known::Thickness(if solid { confined } else { 1.0 } * 1e6 * 1e-3),
                };
                let error = error(variant, mesh(), field, everywhere, known)?;
                row.push(if error < ROUNDING { "pass".into() } else { format!("{error:.1e}") });
                if fails.contains(&test) {
                    // The table shows by how much; what must not happen is that a known weakness goes unseen.
                    if name == "distorted" {
                        report.at_most(
                            CASE,
                            &format!("{test}: rounding over error, known to fail"),
                            name,
                            ROUNDING / error,
                            1.0,
                        );
                    }
                } else {
                    report.at_most(CASE, test, name, error, ROUNDING);
                }
            }
            table.cells.push(row);
        }
    }
    report.element("ems");
    report.table(table);
    Ok(())
}
