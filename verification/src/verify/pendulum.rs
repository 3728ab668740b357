//! Sect. 5.4: quarter cylinder pendulum.

use tegula::analysis::{Balance, Observer, Statistics, Step};
use tegula::model::{Analysis, EnergyMomentumScheme, Model, Scheme};
use tegula::norm::max_norm;
use tegula::{Error, Result};

use super::model::{Compiled, read, refine, switch};
use super::reference::{Record, records};
use super::report::Report;
use super::statistics::run_transient;
use super::{Case, Cost};
use tegula_io::plot::{LinePlot, Series, Style, lines};

/// Cases of this file.
pub(super) const CASES: &[Case] = &[
    Case {
        name: "pendulum",
        about: "Sect. 5.4: quarter cylinder pendulum at 16x16 and 32x32",
        cost: Cost::Normal,
        run: all,
    },
    Case { name: "pendulum-64", about: "Sect. 5.4: the pendulum at 64x64", cost: Cost::Normal, run: fine },
    Case {
        name: "pendulum-fast",
        about: "Sect. 5.4: the start of the pendulum at 8x8, energy-momentum",
        cost: Cost::Fast,
        run: fast,
    },
];

const MODEL: &str = include_str!("../../models/pendulum.toml");
const COARSE: &str = include_str!("../../reference/pendulum_n16_trapezoid_dt05.csv");
const FINE: &str = include_str!("../../reference/pendulum_n32_hht005_dt05.csv");
const CASE: &str = "pendulum";

/// Corners: set in the mesh, column prefix in the reference, name in rows.
const CORNERS: [(&str, &str, &str); 3] = [
    ("u_max_v_max", "free_opposite", "opposite corner"),
    ("u_max_v_min", "free_arc_end_y0", "end of the arc"),
    ("u_min_v_max", "free_th0_y1", "end of the axis"),
];

pub fn all(report: &mut Report) -> Result<()> {
    let coarse = run(16, Scheme::default(), 1.0)?;
    coarse.compare(report, COARSE, &[(0.5, 5e-3), (1.0, 15e-3)])?;
    report.at_most(CASE, "time steps to 1 s", "16x16", coarse.statistics.steps as f64, 600.0);
    let fine = run(32, Scheme::default(), 1.0)?;
    fine.compare(report, FINE, &[(0.4, 5e-3), (0.8, 12e-3)])?;
    figures(report, &[&coarse, &fine])?;
    let conserving = run(16, Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 }), 1.5)?;
    conserving.energy(report);
    conserving.compare(report, COARSE, &[(0.5, 5e-3), (1.0, 15e-3)])
}

pub fn fine(report: &mut Report) -> Result<()> {
    let history = run(64, Scheme::default(), 1.0)?;
    // The reference is of another mesh: its effect (5 mm to 0.4 s, 12 mm to 0.8 s, as the reference
    // program found between meshes) adds to that of the time steps (5 and 15 mm).
    history.compare(report, FINE, &[(0.4, 10e-3), (0.8, 27e-3)])?;
    figures(report, &[&history])
}

pub fn fast(report: &mut Report) -> Result<()> {
    let history = run(8, Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 }), 0.4)?;
    history.energy(report);
    // Coarse mesh: 3 cm of 1.5 m swung through.
    history.compare(report, COARSE, &[(0.4, 30e-3)])
}

/// Positions and velocities of the corners over time.
struct History {
    n: u32,
    scheme: &'static str,
    times: Vec<f64>,
    corners: [Vec<([f64; 3], [f64; 3])>; 3],
    energies: Vec<Balance>,
    statistics: Statistics,
}

struct Recorder<'a> {
    vectors: [usize; 3],
    reference: &'a [[f64; 3]],
    history: History,
}

impl Observer for Recorder<'_> {
    fn on_step(&mut self, step: &Step) -> Result<()> {
        self.history.times.push(step.state.time);
        self.history.energies.push(*step.balance);
        for (corner, &v) in self.history.corners.iter_mut().zip(&self.vectors) {
            let x = std::array::from_fn(|i| self.reference[v][i] + step.state.u[v][i]);
            corner.push((x, step.state.v[v]));
        }
        Ok(())
    }
}

fn model(n: u32, scheme: Scheme, end: f64) -> Result<Model> {
    let mut model = read(MODEL)?;
    refine(&mut model, [n, n]);
    if let Analysis::Transient(t) = &mut model.analysis {
        t.scheme = scheme;
        t.end_time = end;
    }
    Ok(model)
}

fn run(n: u32, scheme: Scheme, end: f64) -> Result<History> {
    run_model(&model(n, scheme, end)?, n, scheme)
}

/// Largest distance of the corners from the reference of the coarse mesh within 0.4 s, 8 × 8 elements of a variant.
pub fn deviation(variant: &str) -> Result<f64> {
    let scheme = Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 });
    let mut model = model(8, scheme, 0.4)?;
    switch(&mut model, variant);
    let history = run_model(&model, 8, scheme)?;
    Ok(max_norm((0..CORNERS.len()).map(|corner| history.distance(corner, &records(COARSE), (0.0, 0.4)))))
}

fn run_model(model: &Model, n: u32, scheme: Scheme) -> Result<History> {
    let Analysis::Transient(options) = &model.analysis else {
        return Err(Error::Outside("the pendulum is not transient".into()));
    };
    let compiled = Compiled::new(model)?;
    let mut vectors = [0; 3];
    for (v, (set, _, _)) in vectors.iter_mut().zip(CORNERS) {
        *v = compiled.point(set)?;
    }
    let name = if matches!(scheme, Scheme::EnergyMomentum(_)) { "energy-momentum" } else { "newmark" };
    let history = History {
        n,
        scheme: name,
        times: Vec::new(),
        corners: Default::default(),
        energies: Vec::new(),
        statistics: Statistics::default(),
    };
    let mut recorder = Recorder { vectors, reference: &compiled.system.coordinates.reference, history };
    let outcome = run_transient(&compiled.system, options, &mut recorder)?;
    let mut history = recorder.history;
    history.statistics = outcome.statistics;
    Ok(history)
}

impl History {
    /// Position of a corner at a time, cubic in each step.
    fn position(&self, corner: usize, t: f64) -> [f64; 3] {
        let after = self.times.partition_point(|&s| s < t).clamp(1, self.times.len() - 1);
        let (t0, t1) = (self.times[after - 1], self.times[after]);
        let ((x0, v0), (x1, v1)) = (self.corners[corner][after - 1], self.corners[corner][after]);
        let h = t1 - t0;
        let s = (t - t0) / h;
        std::array::from_fn(|i| {
            let (a, b) = (s * s * (3.0 - 2.0 * s), s * (1.0 - s));
            (1.0 - a) * x0[i] + a * x1[i] + h * b * ((1.0 - s) * v0[i] - s * v1[i])
        })
    }

    /// Largest distance of a corner from a reference within a window of time.
    fn distance(&self, corner: usize, records: &[Record], (start, end): (f64, f64)) -> f64 {
        let column = CORNERS[corner].1;
        let inside = |r: &&Record| r.number("t") > start - 1e-9 && r.number("t") < end + 1e-9;
        max_norm(records.iter().filter(inside).map(|r| {
            let x = self.position(corner, r.number("t"));
            max_norm((0..3).map(|i| x[i] - r.number(&format!("{column}_{}", ["x", "y", "z"][i]))))
        }))
    }

    fn compare(&self, report: &mut Report, reference: &str, windows: &[(f64, f64)]) -> Result<()> {
        let records = records(reference);
        let mesh = format!("{0}x{0}", self.n);
        for (corner, (_, _, name)) in CORNERS.iter().enumerate() {
            let mut start = 0.0;
            for &(end, limit) in windows {
                let worst = self.distance(corner, &records, (start, end));
                let quantity = format!("{}: {name}, {start}-{end} s, distance", self.scheme);
                report.at_most(CASE, &quantity, &mesh, worst, limit);
                start = end;
            }
        }
        Ok(())
    }

    fn energy(&self, report: &mut Report) {
        let largest = max_norm(self.energies.iter().map(|e| e.kinetic));
        let drift = max_norm(self.energies.iter().map(|e| e.total - self.energies[0].total));
        let mesh = format!("{0}x{0}", self.n);
        report.at_most(
            CASE,
            &format!("{}: energy drift / largest kinetic", self.scheme),
            &mesh,
            drift / largest,
            1e-10,
        );
    }
}

/// Position of the opposite corner, as Figs. 8–10.
fn figures(report: &Report, histories: &[&History]) -> Result<()> {
    let reference = records(FINE);
    for (i, axis) in ["x", "y", "z"].into_iter().enumerate() {
        let meshes = histories.iter().map(|h| h.n.to_string()).collect::<Vec<_>>().join("_");
        let Some(path) = report.picture(&format!("pendulum_{axis}_{meshes}.png")) else { continue };
        let mut series: Vec<Series> = histories
            .iter()
            .map(|h| Series {
                name: format!("EMS {0}×{0}", h.n),
                points: h.times.iter().zip(&h.corners[0]).map(|(t, x)| (*t, x.0[i])).collect(),
                style: Style::Line,
            })
            .collect();
        series.push(Series {
            name: "reference 32×32".into(),
            points: reference
                .iter()
                .map(|r| (r.number("t"), r.number(&format!("free_opposite_{axis}"))))
                .filter(|p| p.0 <= 1.0)
                .collect(),
            style: Style::Dashed,
        });
        let plot = LinePlot {
            title: format!(
                "Quarter cylinder pendulum: global {} of the opposite corner",
                axis.to_uppercase()
            ),
            x_label: "time [s]".into(),
            y_label: format!("{axis} [m]"),
            series,
            ..LinePlot::default()
        };
        lines(&path, &plot).map_err(|e| Error::Outside(e.to_string()))?;
    }
    Ok(())
}
