//! Sect. 5.2: quarter cylinder under a point force, large deformation.

use tegula::Result;
use tegula::model::{Load, MeshSource, Model};

use super::model::{Compiled, read, refine, switch};
use super::reference::records;
use super::report::Report;
use super::{Case, Cost};
use tegula_io::plot::{LinePlot, Series, Style, lines};

/// Cases of this file.
pub(super) const CASES: &[Case] = &[
    Case {
        name: "quarter-cylinder",
        about: "Sect. 5.2: large deformation, set-ups S1-S4, convergence",
        cost: Cost::Normal,
        run: all,
    },
    Case { name: "quarter-cylinder-fast", about: "Sect. 5.2 up to 16x16", cost: Cost::Fast, run: fast },
];

const MODEL: &str = include_str!("../../models/quarter_cylinder.toml");
const REFERENCE: &str = include_str!("../../reference/quarter_cylinder.csv");
const CASE: &str = "quarter-cylinder";

pub fn all(report: &mut Report) -> Result<()> {
    compare(report, 64)?;
    convergence(report)
}

pub fn fast(report: &mut Report) -> Result<()> {
    compare(report, 16)
}

/// Set-ups: S1 as the paper, S2 force up, S3 and S4 with the clamped edge vertical.
fn setup(name: &str, n: u32) -> Result<Model> {
    let mut model = read(MODEL)?;
    refine(&mut model, [n, n]);
    if matches!(name, "S3" | "S4")
        && let MeshSource::Cylinder(c) = &mut model.mesh
    {
        c.center = [1.0, 0.0, 0.0];
        c.start = [-1.0, 0.0, 0.0];
        c.angles = [0.0, 90.0];
    }
    if matches!(name, "S2" | "S4")
        && let Some(Load::Force(f)) = model.loads.first_mut()
    {
        f.value[2] = 20.0;
    }
    Ok(model)
}

fn compare(report: &mut Report, finest: u32) -> Result<()> {
    for record in records(REFERENCE) {
        let n = record.number("n") as u32;
        if n > finest {
            continue;
        }
        let (name, variant) = (record.text("setup"), record.text("element"));
        let mut model = setup(name, n)?;
        switch(&mut model, variant);
        let compiled = Compiled::new(&model)?;
        let outcome = compiled.statics(&model)?;
        let loaded = outcome.state.u[compiled.point("u_max_v_max")?];
        let other = outcome.state.u[compiled.point("u_max_v_min")?];
        let mesh = format!("{n}x{n}");
        report.element(variant);
        for (quantity, value, column) in [
            ("loaded corner u_x", loaded[0], "ux"),
            ("loaded corner u_y", loaded[1], "uy"),
            ("loaded corner u_z", loaded[2], "uz"),
            ("other corner u_z", other[2], "uz_other_corner"),
            ("strain energy", outcome.balance.strain, "strain_energy"),
        ] {
            report.relative(CASE, &format!("{name}: {quantity}"), &mesh, value, record.number(column), 1e-6);
        }
        if variant == "EMS" {
            let (steps, iterations) = if name == "S1" { (1.0, 12.0) } else { (2.0, 20.0) };
            report.at_most(
                CASE,
                &format!("{name}: load steps"),
                &mesh,
                outcome.statistics.steps as f64,
                steps,
            );
            report.at_most(
                CASE,
                &format!("{name}: iterations"),
                &mesh,
                outcome.statistics.iterations as f64,
                iterations,
            );
        }
    }
    report.element("ems");
    Ok(())
}

/// Error of the deflection against the 100×100 solution, as Fig. 7.
fn convergence(report: &mut Report) -> Result<()> {
    const FINEST: f64 = -1.197_874_192;
    let mut points = Vec::new();
    for n in [2, 4, 8, 16, 32, 64] {
        let model = setup("S1", n)?;
        let compiled = Compiled::new(&model)?;
        let u = compiled.statics(&model)?.state.u[compiled.point("u_max_v_max")?];
        points.push((f64::from(n), ((u[2] - FINEST) / FINEST).abs()));
    }
    let order = |a: (f64, f64), b: (f64, f64)| (a.1 / b.1).ln() / (b.0 / a.0).ln();
    report.absolute(
        CASE,
        "S1: observed order of u_z, 8x8 to 32x32",
        "",
        order(points[2], points[4]),
        2.0,
        0.2,
    );
    if let Some(path) = report.picture("quarter_cylinder_convergence.png") {
        let slope = points.iter().map(|p| (p.0, points[1].1 * (points[1].0 / p.0).powi(2))).collect();
        let plot = LinePlot {
            title: "Quarter cylinder: error of the deflection at the force".into(),
            x_label: "elements along an edge".into(),
            y_label: "relative error against 100×100".into(),
            series: vec![
                Series { name: "EMS".into(), points, style: Style::Both },
                Series { name: "order 2".into(), points: slope, style: Style::Dashed },
            ],
            x_log: true,
            y_log: true,
            ..LinePlot::default()
        };
        lines(&path, &plot).map_err(|e| tegula::Error::Outside(e.to_string()))?;
    }
    Ok(())
}

/// Deflection u_z of S1 at the force.
pub fn deflection(variant: &str, n: u32) -> Result<f64> {
    let mut model = setup("S1", n)?;
    switch(&mut model, variant);
    let compiled = Compiled::new(&model)?;
    Ok(compiled.statics(&model)?.state.u[compiled.point("u_max_v_max")?][2])
}
