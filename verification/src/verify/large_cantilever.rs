//! A1: square cantilever plate under a corner force, large displacements, against quadratic solid elements.

use tegula::analysis::{Observer, Step};
use tegula::model::{Analysis, StaticAnalysis};
use tegula::norm::max_norm;
use tegula::{Error, Result, Vec3};

use super::model::{Compiled, read, refine, switch};
use super::reference::{Record, records};
use super::report::Report;
use super::{Case, Cost};
use tegula_io::plot::{LinePlot, Series, Style, lines};

/// Cases of this file.
pub(super) const CASES: &[Case] = &[Case {
    name: "large-cantilever",
    about: "A1: cantilever plate under a corner force against quadratic solids, large displacement",
    cost: Cost::Normal,
    run: all,
}];

/// The plate of T1, which comes to rest at this equilibrium.
const MODEL: &str = include_str!("../../models/cantilever_corner_force.toml");
const REFERENCE: &str = include_str!("../../reference/large_cantilever.csv");
const CASE: &str = "large-cantilever";
const ELEMENTS: [&str; 4] = ["ems", "cm", "mitc4", "solid-shell"];
/// Points of the reference and their sets.
const POINTS: [(&str, &str); 2] = [("loaded", "u_max_v_max"), ("other", "u_max_v_min")];
const LOAD_STEPS: u32 = 5;

/// All elements at 16×16 and 32×32: every component at every load within 1 % of the largest displacement.
///
/// The reference meshes themselves are 0.3 % apart, and meshes of the same size are compared. Shells and solids differ
/// under a point force, below which the solid gives way.
pub fn all(report: &mut Report) -> Result<()> {
    let all = records(REFERENCE);
    let mut curves = Vec::new();
    for n in [16, 32] {
        let mesh = format!("{n}x{n}");
        let rows: Vec<&Record> = all.iter().filter(|r| r.text("mesh") == mesh).collect();
        let size = max_norm(rows.iter().flat_map(|r| <[f64; 3]>::from(displacement(r))));
        for element in ELEMENTS {
            report.element(element);
            let path = path(element, n)?;
            for row in &rows {
                let (point, ratio) = (row.text("point"), row.number("load_ratio"));
                let found = path
                    .iter()
                    .find(|p| (p.0 - ratio).abs() < 1e-9)
                    .ok_or_else(|| Error::Outside(format!("no equilibrium at load ratio {ratio}")))?
                    .1[usize::from(point == POINTS[1].0)];
                for (c, axis) in ["x", "y", "z"].into_iter().enumerate() {
                    report.absolute(
                        CASE,
                        &format!("{point} corner u_{axis} at {ratio}"),
                        &mesh,
                        found[c],
                        displacement(row)[c],
                        0.01 * size,
                    );
                }
            }
            curves.push((format!("{element} {mesh}"), path));
        }
    }
    report.element("ems");
    picture(report, &all, &curves)
}

fn displacement(row: &Record) -> Vec3 {
    Vec3::new(row.number("ux"), row.number("uy"), row.number("uz"))
}

struct Corners {
    vectors: [usize; 2],
    rows: Path,
}

/// Load ratio and displacement of both corners.
type Path = Vec<(f64, [Vec3; 2])>;

impl Observer for Corners {
    fn on_step(&mut self, step: &Step) -> Result<()> {
        self.rows.push((step.state.time, self.vectors.map(|v| step.state.u[v].into())));
        Ok(())
    }
}

fn path(element: &str, n: u32) -> Result<Path> {
    let mut model = read(MODEL)?;
    model.analysis = Analysis::Static(StaticAnalysis { load_steps: LOAD_STEPS, ..StaticAnalysis::default() });
    refine(&mut model, [n, n]);
    switch(&mut model, element);
    let compiled = Compiled::new(&model)?;
    let vectors = [compiled.point(POINTS[0].1)?, compiled.point(POINTS[1].1)?];
    let mut corners = Corners { vectors, rows: vec![(0.0, [Vec3::zeros(); 2])] };
    compiled.statics_watched(&model, &mut corners)?;
    Ok(corners.rows)
}

fn picture(report: &Report, reference: &[Record], curves: &[(String, Path)]) -> Result<()> {
    let Some(path) = report.picture("large_cantilever.png") else { return Ok(()) };
    let mut series = Vec::new();
    for (name, path) in curves.iter().filter(|c| c.0.ends_with("32x32")) {
        let points = path.iter().map(|(ratio, u)| (-u[0].z, *ratio)).collect();
        series.push(Series { name: name.clone(), points, style: Style::Line });
    }
    let fine = reference.iter().filter(|r| r.text("mesh") == "32x32" && r.text("point") == "loaded");
    let points = fine.map(|r| (-r.number("uz"), r.number("load_ratio"))).collect();
    series.push(Series { name: "quadratic solids 32×32".into(), points, style: Style::Markers });
    let plot = LinePlot {
        title: "Cantilever plate under a corner force of 50".into(),
        x_label: "deflection of the loaded corner [m]".into(),
        y_label: "load ratio".into(),
        series,
        ..LinePlot::default()
    };
    lines(&path, &plot).map_err(|e| Error::Outside(e.to_string()))
}
