//! Suddenly loaded clamped shells of large motion: published histories of another code (T1, T2, T3).
//!
//! The histories are those of Project Chrono's unit tests `utest_FEA_ANCFShell_Iso`, `_Ort` and `_OrtGrav`, made with
//! its four-node ANCF shell of position and director (A. Recuero, R. Serban), after H. Yamashita, A. Valkeapää,
//! P. Jayakumar, H. Sugiyama, J. Comput. Nonlinear Dyn. 10(5), 2015. From these tests come meshes (4×4, 6×6 and 8×8),
//! clamps (position and director), plies (+20° below −20°, from the circumference about the director), gravity (in T3
//! only) and damping: the stress is that of the strain `ε + α dε/dt`, the stiffness part of this program's damping.
//! That element has three-dimensional stresses and no shear correction, as `cm` and `solid-shell` here.
//!
//! The meshes of the histories are coarse. What refinement changes is in a table; refined meshes are held
//! against each other, one element against the other, because nothing published is as fine.

use tegula::model::Model;
use tegula::norm::max_norm;
use tegula::{Error, Result};

use super::history::{History, range};
use super::model::{read, refine, switch};
use super::reference::records;
use super::report::{Report, Table};
use super::{Case, Cost};
use tegula_io::plot::{LinePlot, Series, Style, lines};

/// Cases of this file.
pub(super) const CASES: &[Case] = &[
    Case {
        name: "transients-literature",
        about: "T1-T3: clamped plate and laminated quarter cylinders, suddenly loaded, large motion",
        cost: Cost::Normal,
        run: all,
    },
    Case {
        name: "transients-literature-fine",
        about: "T1-T3 with the published meshes halved twice",
        cost: Cost::Long,
        run: fine,
    },
];

const FLAT: &str = include_str!("../../models/cantilever_corner_force.toml");
const FORCE: &str = include_str!("../../models/laminated_cylinder_force.toml");
const GRAVITY: &str = include_str!("../../models/laminated_cylinder_gravity.toml");
const REFERENCE: &str = include_str!("../../reference/transients_literature.csv");
const CASE: &str = "transients-literature";
const TIP: &str = "u_max_v_max";
const ELEMENTS: [&str; 4] = ["ems", "cm", "mitc4", "solid-shell"];
const COMPONENTS: [&str; 3] = ["x", "y", "z"];

/// A published history.
struct Problem {
    name: &'static str,
    title: &'static str,
    model: &'static str,
    /// Elements along an edge in the published mesh.
    n: u32,
    /// Components that were published, those along which the motion is large first.
    components: &'static [usize],
    /// How many of them every element has to meet within the tolerance of their own range.
    large: usize,
    /// Tolerances of the elements with the stresses of the published one, and of the others, whose sections and shear
    /// are not its own. Damping that is 10 % low is farther off in T1 and T2.
    tolerances: [f64; 2],
    /// Where the tip is at rest.
    start: [f64; 3],
}

const PROBLEMS: [Problem; 3] = [
    Problem {
        name: "T1",
        title: "T1: cantilever plate under a sudden corner force",
        model: FLAT,
        n: 4,
        components: &[2],
        large: 1,
        tolerances: [0.004, 0.004],
        start: [0.0; 3],
    },
    Problem {
        name: "T2",
        title: "T2: laminated quarter cylinder under a sudden corner force",
        model: FORCE,
        n: 6,
        components: &[2, 0, 1],
        large: 3,
        tolerances: [0.006, 0.02],
        start: [1.0; 3],
    },
    // Along the axis the tip of T3 moves by 5 mm while it falls by 1.4 m. On 8×8 elements this small motion is mostly
    // discretisation: it changes by a fifth when the mesh is halved (see the table). The elements of the same stresses
    // as the published one meet it, the others are held to a part of the motion as a whole.
    Problem {
        name: "T3",
        title: "T3: laminated quarter cylinder under gravity",
        model: GRAVITY,
        n: 8,
        components: &[2, 0, 1],
        large: 2,
        tolerances: [0.035, 0.012],
        start: [1.0; 3],
    },
];

/// One component of a published history: (time, value), start included.
struct Published {
    component: usize,
    points: Vec<(f64, f64)>,
    range: f64,
}

/// T1, T2, T3 on the published meshes, and EMS against CM on halved ones.
pub fn all(report: &mut Report) -> Result<()> {
    compute(report, 2, &["ems", "cm"])
}

/// Transients of the literature with meshes halved twice.
pub fn fine(report: &mut Report) -> Result<()> {
    compute(report, 3, &["ems", "cm", "mitc4"])
}

/// `meshes`: the published one and how many halved ones for the elements `refined`. The solid shell repeats `cm` to
/// the printed digits and is kept to the published mesh.
fn compute(report: &mut Report, meshes: usize, refined: &[&str]) -> Result<()> {
    let mut table = Table::new(
        "transients-literature",
        "Largest distance of the tip from the published history, in % of the range of each component",
        &["problem", "element", "mesh", "z", "x", "y"],
    );
    for problem in &PROBLEMS {
        let mut curves = Vec::new();
        for element in ELEMENTS {
            let count = if refined.contains(&element) { meshes } else { 1 };
            let histories: Result<Vec<_>> =
                (0..count).map(|k| problem.run(element, problem.n << k)).collect();
            curves.push((element, histories?));
        }
        compare(report, problem, &curves, &mut table);
        among_ourselves(report, problem, &curves);
        picture(report, problem, &curves)?;
    }
    report.table(table);
    report.element("ems");
    Ok(())
}

/// An element and its histories, the published mesh first.
type Curve = (&'static str, Vec<History>);

impl Problem {
    fn published(&self) -> Vec<Published> {
        let of = |c: usize| {
            let mut points = vec![(0.0, self.start[c])];
            let rows = records(REFERENCE);
            let rows = rows.iter().filter(|r| r.text("case") == self.name);
            points.extend(
                rows.filter(|r| r.text("component") == COMPONENTS[c])
                    .map(|r| (r.number("time_s"), r.number("value"))),
            );
            points
        };
        self.components
            .iter()
            .map(|&component| {
                let points = of(component);
                Published { component, range: range(points.iter().map(|p| p.1)), points }
            })
            .collect()
    }

    fn run(&self, element: &str, n: u32) -> Result<History> {
        let mut model: Model = read(self.model)?;
        refine(&mut model, [n, n]);
        switch(&mut model, element);
        History::of(&model, TIP)
    }

    /// Largest distance of a component over the published time: five cycles, of T3 the first and a third.
    fn distance(&self, history: &History, published: &Published) -> f64 {
        let c = published.component;
        max_norm(published.points.iter().map(|(t, x)| self.start[c] + history.at(*t)[c] - x))
    }
}

/// Distances from the published history: those of the published mesh must hold, the table has all.
fn compare(report: &mut Report, problem: &Problem, curves: &[Curve], table: &mut Table) {
    let published = problem.published();
    let whole = max_norm(published.iter().map(|p| p.range));
    for (element, histories) in curves {
        report.element(element);
        let same_stresses = matches!(*element, "cm" | "solid-shell");
        for (level, history) in histories.iter().enumerate() {
            let mesh = format!("{0}x{0}", problem.n << level);
            let mut row = vec![problem.name.to_string(), (*element).to_string(), mesh.clone()];
            for (k, p) in published.iter().enumerate() {
                let distance = problem.distance(history, p);
                row.push(format!("{:.2}", 100.0 * distance / p.range));
                if level > 0 {
                    continue;
                }
                let (scale, name) = match k < problem.large || same_stresses {
                    true => (p.range, "range"),
                    false => (whole, "largest range"),
                };
                let component = COMPONENTS[p.component];
                let name = format!("{}: {component} of the tip, distance / {name}", problem.name);
                let [same, others] = problem.tolerances;
                let tolerance = if same_stresses { same } else { others };
                report.at_most(CASE, &name, &mesh, distance / scale, tolerance);
            }
            row.resize(6, "–".into());
            table.cells.push(row);
        }
    }
}

/// Largest distance of two tips over the time of both.
fn apart(a: &History, b: &History) -> f64 {
    let [a_end, b_end] = [a, b].map(|h| max_norm(h.times()));
    let end = if a_end < b_end { a_end } else { b_end };
    max_norm((0..=200).map(|i| end * f64::from(i) / 200.0).map(|t| (a.at(t) - b.at(t)).norm()))
}

/// Elements against each other on the finest mesh, and the finest mesh against the one before.
fn among_ourselves(report: &mut Report, problem: &Problem, curves: &[Curve]) {
    let whole = max_norm(problem.published().iter().map(|p| p.range));
    let refined: Vec<_> = curves.iter().filter(|c| c.1.len() > 1).collect();
    for (element, histories) in &refined {
        let [.., first, second, third] = &histories[..] else { continue };
        report.element(element);
        let mesh = format!("{0}x{0}", problem.n << (histories.len() - 1));
        let [before, last] = [apart(first, second), apart(second, third)];
        // 1.3 % at T3, which is undamped and lags a little more in each cycle.
        let name = format!("{}: tip against the mesh before / range", problem.name);
        report.at_most(CASE, &name, &mesh, last / whole, 0.02);
        // A quarter for second order, once all waves of the motion are resolved.
        let name = format!("{}: second over first change by halving", problem.name);
        report.at_most(CASE, &name, &mesh, last / before, 0.5);
    }
    let Some((_, first)) = refined.first() else { return };
    for (element, histories) in refined.iter().skip(1) {
        let (Some(a), Some(b)) = (histories.last(), first.last()) else { continue };
        report.element(element);
        let mesh = format!("{0}x{0}", problem.n << (histories.len() - 1));
        let name = format!("{}: tip against ems / range", problem.name);
        report.at_most(CASE, &name, &mesh, apart(a, b) / whole, 0.005);
    }
}

fn picture(report: &Report, problem: &Problem, curves: &[Curve]) -> Result<()> {
    let name = format!("transient_{}.png", problem.name.to_lowercase());
    let Some(path) = report.picture(&name) else { return Ok(()) };
    let line = |h: &History, c: usize| -> Vec<(f64, f64)> {
        h.times().map(|t| (t, problem.start[c] + h.at(t)[c])).collect()
    };
    let mut series = Vec::new();
    for p in problem.published().into_iter().take(2) {
        let (c, axis, n) = (p.component, COMPONENTS[p.component], problem.n);
        for (element, histories) in curves.iter().filter(|c| c.1.len() > 1) {
            let name = format!("{axis}, {element} {n}×{n}");
            series.push(Series { name, points: line(&histories[0], c), style: Style::Line });
            if let (&"cm", Some(h)) = (element, histories.last()) {
                let name = format!("{axis}, {element} {0}×{0}", n << (histories.len() - 1));
                series.push(Series { name, points: line(h, c), style: Style::Dashed });
            }
        }
        let name = format!("{axis}, published {n}×{n}");
        series.push(Series { name, points: p.points, style: Style::Markers });
    }
    let plot = LinePlot {
        title: problem.title.into(),
        x_label: "time [s]".into(),
        y_label: "tip [m]".into(),
        series,
        ..LinePlot::default()
    };
    lines(&path, &plot).map_err(|e| Error::Outside(e.to_string()))
}
