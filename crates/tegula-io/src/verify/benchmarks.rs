//! Benchmarks of the literature: linear shells, and the nonlinear ones of Sze, Liu and Lo.

use tegula::analysis::{Observer, Step};
use tegula::model::{Analysis, Load, MeshSource, Model, VectorLoad};
use tegula::{Error, Result};

use super::model::{Compiled, read, refine, switch};
use super::reference::{Record, records};
use super::report::Report;

const ROOF: &str = include_str!("../../../../verification/models/scordelis_lo.toml");
const CYLINDER: &str = include_str!("../../../../verification/models/pinched_cylinder.toml");
const HEMISPHERE: &str = include_str!("../../../../verification/models/hemisphere.toml");
const STRIP: &str = include_str!("../../../../verification/models/strip.toml");
const ANNULUS: &str = include_str!("../../../../verification/models/slit_annulus.toml");
const LINEAR: &str = include_str!("../../../../verification/reference/linear_benchmarks.csv");
const SZE: &str = include_str!("../../../../verification/reference/sze.csv");

fn elements(mesh: &str) -> [u32; 2] {
    let mut n = mesh.split('x').map(|n| n.parse().unwrap_or(1));
    [n.next().unwrap_or(1), n.next().unwrap_or(1)]
}

/// Scordelis–Lo roof, pinched cylinder, pinched hemisphere.
pub fn linear(report: &mut Report) -> Result<()> {
    for record in records(LINEAR) {
        let problem = record.text("problem");
        let (text, point, component) = match problem {
            "scordelis_lo" => (ROOF, "u_max_v_min", 2),
            "pinched_cylinder" => (CYLINDER, "u_min_v_min", 2),
            _ => (HEMISPHERE, "u_min_v_min", 0),
        };
        let mesh = record.text("mesh");
        let mut model = read(text)?;
        refine(&mut model, elements(mesh));
        let variant = record.text("element");
        switch(&mut model, variant);
        report.element(variant);
        if let Analysis::Static(s) = &mut model.analysis {
            s.linear = true;
        }
        let compiled = Compiled::new(&model)?;
        let u = compiled.statics(&model)?.state.u[compiled.point(point)?][component];
        report.relative(problem, "displacement", mesh, u, record.number("value"), 1e-6);
        let literature = record.number("literature").copysign(record.number("value"));
        if mesh == "32x32" && matches!(variant, "EMS" | "CM eas4+4") {
            // What is left at 32 elements is the element's own discretisation error.
            report.relative(problem, "displacement against the literature", mesh, u, literature, 0.015);
        }
    }
    Ok(())
}

struct Curve<'a> {
    points: [(usize, usize, f64); 2],
    rows: Vec<(f64, [f64; 2])>,
    keep: &'a dyn Fn(f64) -> bool,
}

impl Observer for Curve<'_> {
    fn on_step(&mut self, step: &Step) -> Result<()> {
        if (self.keep)(step.state.time) {
            self.rows.push((step.state.time, self.points.map(|(v, c, sign)| sign * step.state.u[v][c])));
        }
        Ok(())
    }
}

/// S1–S4 of Sze, Liu and Lo along the whole load path.
pub fn sze(report: &mut Report) -> Result<()> {
    let all = records(SZE);
    for (problem, meshes) in [
        ("S1", ["8x1", "16x1", "32x2"]),
        ("S2", ["8x1", "16x1", "32x1"]),
        ("S3", ["6x30", "10x80", ""]),
        ("S4", ["8x8", "16x16", "32x32"]),
    ] {
        for mesh in meshes.into_iter().filter(|m| !m.is_empty()) {
            let rows: Vec<&Record> =
                all.iter().filter(|r| r.text("problem") == problem && r.text("mesh") == mesh).collect();
            curve(report, problem, mesh, &rows)?;
        }
    }
    Ok(())
}

/// A watched displacement: set, component, sign.
type Watched = (&'static str, usize, f64);

/// Model and the two watched displacements.
fn setup(problem: &str, mesh: &str) -> Result<(Model, [Watched; 2])> {
    let mut model = read(match problem {
        "S1" | "S2" => STRIP,
        "S3" => ANNULUS,
        _ => HEMISPHERE,
    })?;
    refine(&mut model, elements(mesh));
    let watched = match problem {
        "S1" => [("u_max_v_min", 0, -1.0), ("u_max_v_min", 2, 1.0)],
        "S2" => {
            if let MeshSource::Plate(plate) = &mut model.mesh {
                plate.size = [12.0, 1.0];
            }
            let moment = 50.0 * std::f64::consts::PI / 3.0;
            model.loads = vec![Load::EdgeMoment(VectorLoad {
                on: "u_max".into(),
                value: [0.0, -moment, 0.0],
                amplitude: None,
            })];
            [("u_max_v_min", 0, -1.0), ("u_max_v_min", 2, 1.0)]
        }
        "S3" => [("u_min_v_min", 2, 1.0), ("u_max_v_min", 2, 1.0)],
        _ => {
            for load in &mut model.loads {
                if let Load::Force(f) = load {
                    f.value.iter_mut().for_each(|x| *x *= 200.0);
                }
            }
            if let Analysis::Static(s) = &mut model.analysis {
                s.load_steps = 20;
            }
            [("u_min_v_min", 0, 1.0), ("u_max_v_min", 1, -1.0)]
        }
    };
    Ok((model, watched))
}

fn curve(report: &mut Report, problem: &str, mesh: &str, rows: &[&Record]) -> Result<()> {
    let (model, watched) = setup(problem, mesh)?;
    let compiled = Compiled::new(&model)?;
    let mut points = [(0, 0, 0.0); 2];
    for (p, (set, c, sign)) in points.iter_mut().zip(watched) {
        *p = (compiled.point(set)?, c, sign);
    }
    let wanted: Vec<f64> = rows.iter().map(|r| r.number("load_ratio")).collect();
    let keep = |t: f64| wanted.iter().any(|w| (w - t).abs() < 1e-9);
    let mut observer = Curve { points, rows: Vec::new(), keep: &keep };
    compiled.statics_watched(&model, &mut observer)?;
    for record in rows {
        let ratio = record.number("load_ratio");
        let found = observer.rows.iter().find(|r| (r.0 - ratio).abs() < 1e-9).ok_or_else(|| {
            Error::Outside(format!("{problem} {mesh}: no equilibrium was computed at load ratio {ratio}"))
        })?;
        for k in 0..2 {
            let name = record.text(["q1", "q2"][k]);
            let reference = record.number(["value1", "value2"][k]);
            // The reference is printed to six decimals.
            let quantity = format!("{name} at {ratio}");
            report.absolute(
                &format!("sze-{problem}"),
                &quantity,
                mesh,
                found.1[k],
                reference,
                1e-6 * reference.abs() + 6e-7,
            );
        }
    }
    Ok(())
}
