//! Sect. 5.1: cantilevered square plates under an edge load, linear.

use tegula::Result;
use tegula::model::Load;

use super::model::{Compiled, read, refine, section, switch};
use super::reference::records;
use super::report::Report;
use super::{Case, Cost};

/// Cases of this file.
pub(super) const CASES: &[Case] = &[
    Case {
        name: "plate",
        about: "Sect. 5.1: cantilevered plates, three slendernesses, n = 1…32",
        cost: Cost::Normal,
        run: all,
    },
    Case { name: "plate-fast", about: "Sect. 5.1 up to n = 8", cost: Cost::Fast, run: fast },
];

const MODEL: &str = include_str!("../../models/cantilever_plate.toml");
const REFERENCE: &str = include_str!("../../reference/cantilever_plate.csv");
const CASE: &str = "plate";

pub fn all(report: &mut Report) -> Result<()> {
    compare(report, 32)
}

pub fn fast(report: &mut Report) -> Result<()> {
    compare(report, 8)
}

fn compare(report: &mut Report, finest: u32) -> Result<()> {
    for record in records(REFERENCE) {
        let n = record.number("n") as u32;
        if n > finest {
            continue;
        }
        let (slenderness, h) = match record.text("case") {
            "A_thin" => ("L/H = 1000", 1e-3),
            "B_moderate" => ("L/H = 100", 1e-2),
            _ => ("L/H = 10", 1e-1),
        };
        let variant = record.text("variant");
        let w = deflections(variant, n, h)?;
        report.element(&variant.replace(" ks=5/6", ""));
        let mesh = format!("{n}x{n}");
        // The independent solid shell loses digits when thin: its corners of one element, equal by symmetry, differ
        // by 5e-5 there.
        let noisy = h == 1e-3 && variant.starts_with("indep solid-shell");
        let tolerance = if noisy { 1e-3 } else { 1e-6 };
        for (name, value, column) in [
            ("corner deflection", w[0], "w_corner"),
            ("mid-edge deflection", w[1], "w_mid"),
            ("mean deflection", w[2], "w_mean"),
        ] {
            report.relative(
                CASE,
                &format!("{slenderness}: {name}"),
                &mesh,
                value,
                record.number(column),
                tolerance,
            );
        }
    }
    report.element("ems");
    Ok(())
}

/// Deflection of the free edge: corner, middle, mean.
pub fn deflections(variant: &str, n: u32, h: f64) -> Result<[f64; 3]> {
    let mut model = read(MODEL)?;
    refine(&mut model, [n, n]);
    switch(&mut model, variant);
    section(&mut model)?.thickness = h;
    if let Some(Load::Edge(load)) = model.loads.first_mut() {
        // 5e-2, 5e1 and 5e4 for H = 1e-3, 1e-2 and 1e-1: the same deflection by thin-plate theory.
        load.value = [0.0, 0.0, -5e7 * h.powi(3)];
    }
    let compiled = Compiled::new(&model)?;
    let outcome = compiled.statics(&model)?;
    let deflection =
        |node: u32| outcome.state.u[compiled.system.coordinates.position_of[node as usize] as usize][2];
    // Nodes of the edge from v = 0 to v = 1; the mean weighs them by their length.
    let mut edge = compiled.mesh.nodes_on("u_max").unwrap_or_default();
    edge.sort_by(|a, b| {
        compiled.mesh.positions[*a as usize].y.total_cmp(&compiled.mesh.positions[*b as usize].y)
    });
    let w: Vec<f64> = edge.iter().map(|&n| deflection(n)).collect();
    let mean = w.windows(2).map(|p| 0.5 * (p[0] + p[1])).sum::<f64>() / (w.len() - 1) as f64;
    let middle = if n == 1 { mean } else { w[w.len() / 2] };
    Ok([w[0], middle, mean])
}
