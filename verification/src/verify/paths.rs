//! Equilibrium paths of Sze, Liu and Lo by power series: hinged roofs, open cylinder, and the benchmarks without limit points.

use tegula::analysis::path::CriticalKind;
use tegula::analysis::{Observer, Step};
use tegula::compile::build;
use tegula::model::{
    Analysis, Condition, Crossing, ElementKind, Isotropic, Load, Material, Model, MooneyRivlin, NeoHookean,
    PathAnalysis, PressureLoad, Sensor, StopCondition, SymmetryPlane, VolumeSensor,
};
use tegula::norm::{larger, max_norm};
use tegula::result::{sensor_columns, sensor_values};
use tegula::system::System;
use tegula::{Error, Mesh, Result, Vec3};
use tegula_io::plot::{LinePlot, Series, Style, lines};

use super::benchmarks::{SZE, Watched, setup};
use super::inside::{flat, octant};
use super::model::{Compiled, read, refine, section, switch};
use super::reference::records;
use super::report::Report;
use super::statistics::run_path;
use super::{Case, Cost};

/// Cases of this file.
pub(super) const CASES: &[Case] = &[
    Case {
        name: "paths-roofs",
        about: "hinged roofs through limit points and a snap-back: literature and an independent program",
        cost: Cost::Normal,
        run: roofs,
    },
    Case {
        name: "paths-balloon",
        about: "spheres of rubber under pressure by the arc-length method: through their limit",
        cost: Cost::Normal,
        run: balloon,
    },
    Case {
        name: "paths-full-load",
        about: "strip, slit annulus, hemisphere and open cylinder to full load by power series",
        cost: Cost::Normal,
        run: full_load,
    },
];

const ROOF: &str = include_str!("../../models/hinged_roof.toml");
const CYLINDER: &str = include_str!("../../models/open_cylinder.toml");
const PUBLISHED: &str = include_str!("../../reference/sze_paths.csv");

/// Force of load ratio 1 (N).
const FULL: f64 = 3000.0;
/// Layup of the laminated roof, counted from its axis.
const LAYUP: &str = "layup = { stacking = \"[90/0/90]\", material = \"ply\", ply_thickness = 4.233333333333333, \
                     direction = [0.0, 1.0, 0.0] }";

/// Displacement of a point along a path, and the load factor.
struct Curve {
    vector: usize,
    component: usize,
    sign: f64,
    points: Vec<(f64, f64)>,
}

impl Observer for Curve {
    fn on_step(&mut self, step: &Step) -> Result<()> {
        self.points.push((self.sign * step.state.u[self.vector][self.component], step.state.time));
        Ok(())
    }
}

/// Path of a model: displacement of a set of one node, load factor; limit loads, factorisations.
struct Path {
    points: Vec<(f64, f64)>,
    limits: Vec<f64>,
    factorizations: u64,
}

fn follow(model: &Model, (set, component, sign): Watched) -> Result<Path> {
    let Analysis::Path(options) = &model.analysis else {
        return Err(Error::Outside("the model has no path".into()));
    };
    let compiled = Compiled::new(model)?;
    let mut curve = Curve { vector: compiled.point(set)?, component, sign, points: vec![(0.0, 0.0)] };
    let outcome = run_path(&compiled.system, options, &mut curve)?;
    let critical = outcome.state.path.map(|path| path.critical).unwrap_or_default();
    Ok(Path {
        points: curve.points,
        limits: critical.iter().filter(|p| p.kind == CriticalKind::Limit).map(|p| p.load).collect(),
        factorizations: outcome.statistics.factorizations,
    })
}

/// Published points of a path: displacement, load ratio.
fn published(problem: &str) -> Vec<(f64, f64)> {
    let all = records(PUBLISHED);
    let own = all.iter().filter(|record| record.text("problem") == problem);
    own.map(|record| (record.number("value"), record.number("load_ratio"))).collect()
}

/// Largest distance of the points from a curve, displacement and load over the largest published ones.
fn distance(points: &[(f64, f64)], curve: &[(f64, f64)]) -> f64 {
    let scale = [max_norm(points.iter().map(|p| p.0)), max_norm(points.iter().map(|p| p.1))];
    let scaled = |(x, y): &(f64, f64)| [x / scale[0], y / scale[1]];
    let from_segment = |p: [f64; 2], pair: &[(f64, f64)]| {
        let (a, b) = (scaled(&pair[0]), scaled(&pair[1]));
        let d = [b[0] - a[0], b[1] - a[1]];
        let along = ((p[0] - a[0]) * d[0] + (p[1] - a[1]) * d[1]) / (d[0] * d[0] + d[1] * d[1]);
        let t = along.clamp(0.0, 1.0);
        (p[0] - a[0] - t * d[0]).hypot(p[1] - a[1] - t * d[1])
    };
    let nearest = |p: &(f64, f64)| {
        let p = scaled(p);
        curve.windows(2).map(|pair| from_segment(p, pair)).min_by(f64::total_cmp).unwrap_or(f64::NAN)
    };
    points.iter().map(nearest).fold(0.0, larger)
}

/// Hinged roofs on 16 × 16 and 32 × 32 elements.
fn roofs(report: &mut Report) -> Result<()> {
    for (problem, thickness, most) in [("S8a", 12.7, 12.0), ("S8b", 6.35, 36.0), ("S8d", 12.7, 12.0)] {
        let points = published(problem);
        let case = format!("path-{problem}");
        let mut curves = Vec::new();
        for n in [16, 32] {
            let laminated = ROOF.replace("material = \"m\"\nthickness = 12.7", LAYUP);
            let mut model = read(if problem == "S8d" { &laminated } else { ROOF })?;
            refine(&mut model, [n, n]);
            if problem != "S8d" {
                switch(&mut model, "EMS");
                section(&mut model)?.thickness = thickness;
            }
            if let Analysis::Path(options) = &mut model.analysis {
                (options.end_load, options.points) = (1.25, 40);
            }
            let path = follow(&model, ("u_min_v_min", 2, -1.0))?;
            let mesh = format!("{n}x{n}");
            report.at_most(
                &case,
                "distance of the published points",
                &mesh,
                distance(&points, &path.points),
                0.015,
            );
            report.at_most(&case, "factorisations", &mesh, path.factorizations as f64, most);
            let limit = FULL * path.limits.first().copied().unwrap_or(f64::NAN);
            for (reference, _) in published(&format!("{problem}-limit-{mesh}")) {
                report.absolute(&case, "first limit load", &mesh, limit, reference, 0.006);
            }
            curves.push((mesh, path.points));
        }
        picture(report, problem, &points, curves)?;
    }
    report.element("ems");
    Ok(())
}

fn picture(
    report: &Report,
    problem: &str,
    published: &[(f64, f64)],
    curves: Vec<(String, Vec<(f64, f64)>)>,
) -> Result<()> {
    let Some(path) = report.picture(&format!("path_{}.png", problem.to_lowercase())) else { return Ok(()) };
    let mut series: Vec<Series> = curves
        .into_iter()
        .map(|(mesh, points)| Series { name: format!("EMS {mesh}"), points, style: Style::Line })
        .collect();
    series.push(Series { name: "literature".into(), points: published.to_vec(), style: Style::Markers });
    let plot = LinePlot {
        title: format!("Sze, Liu, Lo: equilibrium path {problem}"),
        x_label: "deflection [mm]".into(),
        y_label: "load ratio".into(),
        series,
        ..LinePlot::default()
    };
    lines(&path, &plot).map_err(|e| Error::Outside(e.to_string()))
}

/// Benchmarks to full load: few factorisations, and the displacements of the reference program.
fn full_load(report: &mut Report) -> Result<()> {
    let all = records(SZE);
    for (problem, mesh, most) in [("S1", "16x1", 4.0), ("S3", "6x30", 20.0), ("S4", "16x16", 8.0)] {
        let (mut model, [_, watched]) = setup(problem, mesh)?;
        switch(&mut model, "EMS");
        model.analysis = Analysis::Path(PathAnalysis::default());
        let path = follow(&model, watched)?;
        let reference = all.iter().find(|r| {
            ["problem", "element", "mesh"].map(|c| r.text(c)) == [problem, "EMS", mesh]
                && r.number("load_ratio") == 1.0
        });
        let reference = reference.map_or(f64::NAN, |r| r.number("value2"));
        let case = format!("path-{problem}");
        let reached = path.points.last().map_or(f64::NAN, |p| p.0);
        // The reference is printed to six decimals.
        report.absolute(
            &case,
            "displacement at full load",
            mesh,
            reached,
            reference,
            1e-6 * reference + 6e-7,
        );
        report.at_most(&case, "factorisations", mesh, path.factorizations as f64, most);
    }
    let model = read(CYLINDER)?;
    let path = follow(&model, ("u_min_v_min", 2, 1.0))?;
    let mesh = "24x16";
    report.at_most(
        "path-S5",
        "distance of the published points",
        mesh,
        distance(&published("S5"), &path.points),
        0.015,
    );
    report.absolute(
        "path-S5",
        "limit load over full load",
        mesh,
        path.limits.first().copied().unwrap_or(f64::NAN),
        0.51,
        0.01,
    );
    report.element("ems");
    Ok(())
}

/// Mean stretch of a sphere of radius 1 along a path, and the pressure `p R/(μ h)`.
struct Stretch<'a> {
    mesh: &'a Mesh,
    system: &'a System,
    points: Vec<(f64, f64)>,
}

impl Stretch<'_> {
    fn mean(&self, step: &Step) -> f64 {
        let stretch = |(node, x): (usize, &Vec3)| {
            let u = Vec3::from(step.state.u[self.system.coordinates.position_of[node] as usize]);
            (x + u).norm() / x.norm()
        };
        let sum: f64 = self.mesh.positions.iter().enumerate().map(stretch).sum();
        sum / self.mesh.positions.len() as f64
    }
}

impl Observer for Stretch<'_> {
    fn on_step(&mut self, step: &Step) -> Result<()> {
        self.points.push((self.mean(step), step.state.time));
        Ok(())
    }
    fn column(&mut self, name: &str, step: &Step) -> Option<f64> {
        let column = sensor_columns(self.system).iter().position(|column| column == name)?;
        sensor_values(self.system, step.state).get(column).copied()
    }
}

/// Octant of a sphere under a pressure that follows its surface: the path through the limit of the pressure, against the closed form of a
/// thin sphere of incompressible rubber, `p R/h = (λ⁻¹ − λ⁻⁷)(2 μ + 4 c₀₁ λ²)` with μ = 2 c₁₀.
fn balloon(report: &mut Report) -> Result<()> {
    const H: f64 = 0.01;
    report.element("cm");
    let neo_hooke = NeoHookean { shear: 1.0, bulk: 2e3, density: 0.0, form: Default::default() };
    // A limit at the stretch 1.535, and a minimum behind it.
    let mooney_rivlin = MooneyRivlin { c10: 0.7, c01: 0.1, bulk: 1e3, density: 0.0 };
    let laws: [(&str, Material, [f64; 2], f64); 2] = [
        ("neo-Hooke", Material::NeoHookean(neo_hooke), [2.0, 0.0], 7_f64.powf(1.0 / 6.0)),
        ("Mooney-Rivlin", Material::MooneyRivlin(mooney_rivlin), [2.8, 0.4], 1.535),
    ];
    let (mesh, largest) = (octant(8), 2.5_f64);
    for (name, material, [first, second], at_limit) in laws {
        // Volume control: the path ends at the volume of this stretch.
        let inside = VolumeSensor { name: "inside".into(), on: "all".into(), tip: [0.0; 3] };
        let volume = largest.powi(3) * volume(&mesh);
        let blown_up = StopCondition {
            column: "sensor.inside.volume".into(),
            value: volume,
            direction: Crossing::Rising,
        };
        let options = PathAnalysis { end_load: 10.0, stop: vec![blown_up], ..PathAnalysis::default() };
        let analysis = Analysis::Path(options.clone());
        let mut model = Model::new(flat([1.0; 2], [1, 1]), analysis, Isotropic::new(1.0, 0.3, 1.0), H);
        model.sensors = vec![Sensor::Volume(inside)];
        model.materials.insert("m".into(), material);
        model.sections[0].element = ElementKind::Cm;
        for (on, normal) in
            [("x = 0", [1.0, 0.0, 0.0]), ("y = 0", [0.0, 1.0, 0.0]), ("z = 0", [0.0, 0.0, 1.0])]
        {
            model.conditions.push(Condition::Symmetry(SymmetryPlane { on: on.into(), normal }));
        }
        // Positive pressure pushes against the directors, which point outwards here.
        model.loads = vec![Load::Pressure(PressureLoad {
            on: "all".into(),
            value: -H,
            amplitude: None,
            distribution: None,
        })];
        let system = build(&model, &mesh)?;
        let mut curve = Stretch { mesh: &mesh, system: &system, points: Vec::new() };
        let outcome = run_path(&system, &options, &mut curve)?;
        let pressure = |l: f64| (l.recip() - l.powi(-7)) * (first + second * l * l);
        let error = |(stretch, p): &(f64, f64)| (p / pressure(*stretch) - 1.0).abs();
        let errors = curve.points.iter().filter(|point| point.0 > 1.05).map(error);
        let quantity = |what: &str| format!("{name}: {what}");
        report.at_most(CASE, &quantity("error of the pressure"), "3x8x8", errors.fold(0.0, larger), 0.01);
        let reached = curve.points.last().map_or(f64::NAN, |point| point.0);
        report.absolute(CASE, &quantity("stretch at the end"), "3x8x8", reached, largest, 1e-4);
        let critical = outcome.state.path.map(|path| path.critical).unwrap_or_default();
        let limit = critical.iter().find(|p| p.kind == CriticalKind::Limit).map_or(f64::NAN, |p| p.load);
        report.relative(CASE, &quantity("limit pressure"), "3x8x8", limit, pressure(at_limit), 5e-3);
    }
    Ok(())
}

/// Volume of the cone from the origin over a mesh, by its quads as pairs of triangles on either diagonal.
fn volume(mesh: &Mesh) -> f64 {
    let tetrahedron = |[a, b, c]: [u32; 3]| {
        let x = [a, b, c].map(|node| mesh.positions[node as usize]);
        x[0].dot(&x[1].cross(&x[2])) / 6.0
    };
    let cone = |[a, b, c, d]: &[u32; 4]| {
        let halves = [[*a, *b, *c], [*a, *c, *d], [*a, *b, *d], [*b, *c, *d]];
        0.5 * halves.into_iter().map(tetrahedron).sum::<f64>()
    };
    mesh.quads.iter().map(cone).sum()
}

const CASE: &str = "path-balloon";
