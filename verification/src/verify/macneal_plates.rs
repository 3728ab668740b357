//! Rectangular plates of MacNeal and Harder: thin, supported or clamped, under pressure or a force in the middle.
//!
//! R. H. MacNeal, R. L. Harder, Finite Elements in Analysis and Design 1 (1985) 3–20: sides a = 2 and b = 2 or 10,
//! thickness 1e-4, one quarter. Navier's series checks the values of supported plates. The value of the long clamped
//! plate under pressure, 2.56, is below what plates of this length have: at b = 5 a the middle bends as a clamped strip,
//! q a⁴/(384 D) = 2.604, and the finest meshes say 2.60. The tolerance of 2 % leaves room for that.

use std::f64::consts::PI;

use tegula::Result;
use tegula::model::{Axis, Condition, FixComponents, Load, MeshSource, OnSet, VectorLoad};

use super::model::{Compiled, read, refine, switch};
use super::reference::records;
use super::report::{Report, Table};
use super::{Case, Cost};

/// Cases of this file.
pub(super) const CASES: &[Case] = &[Case {
    name: "macneal-harder-plates",
    about: "MacNeal and Harder: thin rectangular plates",
    cost: Cost::Normal,
    run: all,
}];

const MODEL: &str = include_str!("../../models/rectangular_plate.toml");
const REFERENCE: &str = include_str!("../../reference/macneal_harder.csv");
const CASE: &str = "macneal-harder-plates";
const ELEMENTS: [&str; 4] = ["ems", "cm", "mitc4", "solid-shell"];
/// Short side, bending stiffness, pressure, force.
const A: f64 = 2.0;
const D: f64 = 1.7472e7 * 1e-12 / (12.0 * (1.0 - 0.3 * 0.3));
const PRESSURE: f64 = 1e-4;
const FORCE: f64 = 4e-4;

/// All plates and elements: the fine meshes against the values of the paper, the coarse ones in a table.
pub fn all(report: &mut Report) -> Result<()> {
    let references = records(REFERENCE);
    let mut columns = vec!["plate", "load", "quarter"];
    columns.extend(ELEMENTS);
    let mut table = Table::new(
        "macneal-harder-plates",
        "MacNeal and Harder: deflection of the middle over the paper's value",
        &columns,
    );
    for support in ["supported", "clamped"] {
        for ratio in [1, 5] {
            let problem = format!("plate {support} {ratio}");
            for load in ["pressure", "force"] {
                let row = references.iter().find(|r| r.text("problem") == problem && r.text("load") == load);
                let paper = row.map_or(f64::NAN, |r| r.number("value"));
                let name = format!("{support}, b/a = {ratio}: {load}");
                if support == "supported" {
                    report.element("series");
                    // Printed to four digits, cut off or rounded.
                    report.relative(CASE, &name, "", paper, navier(f64::from(ratio), load), 2e-3);
                }
                for elements in [[4, 4], [32, if ratio == 1 { 32 } else { 64 }]] {
                    let mesh = elements.map(|n: u32| n.to_string()).join("x");
                    let mut cells = vec![format!("{support}, b/a = {ratio}"), load.into(), mesh.clone()];
                    for element in ELEMENTS {
                        report.element(element);
                        let w = deflection(support, ratio, load, element, elements)?;
                        cells.push(format!("{:.3}", w / paper));
                        if elements[0] == 32 {
                            let tolerance = if (support, ratio, load) == ("clamped", 5, "pressure") {
                                0.02
                            } else {
                                0.01
                            };
                            report.relative(CASE, &name, &mesh, w, paper, tolerance);
                        }
                    }
                    table.cells.push(cells);
                }
            }
        }
    }
    report.table(table);
    report.element("ems");
    Ok(())
}

/// Deflection of the middle.
fn deflection(support: &str, ratio: u32, load: &str, element: &str, elements: [u32; 2]) -> Result<f64> {
    let mut model = read(MODEL)?;
    refine(&mut model, elements);
    switch(&mut model, element);
    if let MeshSource::Plate(p) = &mut model.mesh {
        p.size = [0.5 * A, 0.5 * A * f64::from(ratio)];
    }
    for (on, along) in [("u_max", Axis::Y), ("v_max", Axis::X)] {
        let on = on.to_string();
        model.conditions.push(if support == "clamped" {
            Condition::Clamp(OnSet { on })
        } else {
            // No deflection, and no rotation along the edge, as thin plates have it.
            Condition::Fix(FixComponents { on, position: vec![Axis::Z], director: vec![along] })
        });
    }
    let vector = |on: &str, z: f64| VectorLoad {
        on: on.into(),
        value: [0.0, 0.0, z],
        amplitude: None,
        distribution: None,
    };
    model.loads.push(match load {
        "pressure" => Load::Traction(vector("all", PRESSURE)),
        _ => Load::Force(vector("u_min_v_min", 0.25 * FORCE)),
    });
    let compiled = Compiled::new(&model)?;
    Ok(compiled.statics(&model)?.state.u[compiled.point("u_min_v_min")?][2])
}

/// Navier's series for the middle of a simply supported thin plate with b/a = `ratio`.
fn navier(ratio: f64, load: &str) -> f64 {
    let b = A * ratio;
    let mut sum = 0.0;
    for m in (1..1000).step_by(2) {
        for n in (1..1000).step_by(2) {
            let [x, y] = [f64::from(m), f64::from(n)];
            let stiffness = ((x / A).powi(2) + (y / b).powi(2)).powi(2);
            let sign = if (m + n) % 4 == 2 { 1.0 } else { -1.0 };
            sum += match load {
                "pressure" => sign * 16.0 * PRESSURE / (PI * PI * x * y) / stiffness,
                _ => 4.0 * FORCE / (A * b) / stiffness,
            };
        }
    }
    sum / (PI.powi(4) * D)
}
