//! Cylinder under axial compression with an axisymmetric imperfection: bifurcation loads over its amplitude (knock-down curve).

use std::f64::consts::{PI, TAU};

use tegula::analysis::path::CriticalKind;
use tegula::analysis::{Observer, Step, statics};
use tegula::compile::{build, imperfect_mesh};
use tegula::mesh::generators::generate;
use tegula::model::{
    Analysis, Axis, Condition, Crossing, CylinderMesh, FixComponents, Grid, Imperfection, Isotropic,
    MeshSource, Model, NodalVector, PathAnalysis, PrescribeComponent, StopCondition, SymmetryPlane,
    WaveImperfection,
};
use tegula::system::Assembly;
use tegula::{Error, Result, System};
use tegula_io::plot::{LinePlot, Series, Style, lines};

use super::report::Report;
use super::statistics::run_path;
use super::{Case, Cost};

/// Cases of this file.
pub(super) const CASES: &[Case] = &[Case {
    name: "paths-imperfect-cylinder",
    about: "axially compressed cylinders with axisymmetric imperfections: bifurcation loads of Koiter's theory",
    cost: Cost::Normal,
    run: imperfect_cylinder,
}];

const CASE: &str = "path-imperfect-cylinder";
/// Young's modulus, Poisson's ratio, radius and thickness.
const YOUNG: f64 = 1.0;
const POISSON: f64 = 0.3;
const RADIUS: f64 = 1.0;
const THICKNESS: f64 = 0.01;
/// Waves of the imperfection along the axis, and the angle of half a wave of the buckles around it (degrees): of whole numbers of waves nine make the
/// buckles most nearly square.
const WAVES: f64 = 2.0;
const WEDGE: f64 = 20.0;
const ELEMENTS: [u32; 2] = [18, 40];
/// Amplitudes of the imperfection over the thickness.
const AMPLITUDES: [f64; 4] = [0.02, 0.05, 0.1, 0.2];

/// √(3 (1 − ν²)).
fn c() -> f64 {
    (3.0 * (1.0 - POISSON * POISSON)).sqrt()
}

/// Wavelength of the axisymmetric buckles of the perfect cylinder, 2π √(R h)/(12 (1 − ν²))^¼.
fn wavelength() -> f64 {
    TAU * (RADIUS * THICKNESS / (2.0 * c())).sqrt()
}

/// Stress under which the perfect cylinder buckles, E h/(R c).
fn classical() -> f64 {
    YOUNG * THICKNESS / (RADIUS * c())
}

/// Bifurcation load over the classical one, of an imperfection of the amplitude δ = μ h, from small amplitudes on: `(1 − λ)² = (3/2) c μ λ`.
fn asymptotic(mu: f64) -> f64 {
    let b = 1.0 + 0.75 * c() * mu;
    b - (b * b - 1.0).sqrt()
}

/// Bifurcation load over the classical one of any amplitude, by one term of the buckles: the lowest root of `(1 − λ)³ − c μ (1 + λ/2)(1 − λ) + (c μ)²/2 = 0`.
///
/// With the imperfection −δ cos(p x) the compressed shell has the curvature `δ p² cos(p x)/(1 − λ)` and the hoop force
/// `−E h δ λ cos(p x)/(R (1 − λ))` before it buckles. Into Donnell's equations about this state
///
/// ```text
/// D ∇⁴w + F,xx/R + N w,xx − N_θ w,yy − W'' F,yy = 0,   ∇⁴F/(E h) − w,xx/R + W'' w,yy = 0
/// ```
///
/// go buckles and their stress function, both as cos(p x/2) cos(p y/2) (Galerkin). For small amplitudes it becomes [`asymptotic`].
fn one_term(mu: f64) -> f64 {
    let a = c() * mu;
    let value = |l: f64| (1.0 - l).powi(3) - a * (1.0 + 0.5 * l) * (1.0 - l) + 0.5 * a * a;
    let (mut low, mut high) = (0.0, asymptotic(mu));
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if value(middle) > 0.0 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Part of the cylinder between planes of symmetry, shortened by twice the classical stress at load factor 2.
fn model(amplitude: f64) -> Model {
    let length = WAVES * wavelength();
    let mesh = MeshSource::Cylinder(CylinderMesh {
        center: [0.0; 3],
        axis: [0.0, 1.0, 0.0],
        start: [0.0, 0.0, 1.0],
        radius: RADIUS,
        angles: [0.0, WEDGE],
        length,
        grid: Grid::uniform(ELEMENTS[0], ELEMENTS[1]),
    });
    let beyond = StopCondition { column: "buckled".into(), value: 0.5, direction: Crossing::Rising };
    let options = PathAnalysis { end_load: 2.0, stop: vec![beyond], ..PathAnalysis::default() };
    let material = Isotropic::new(YOUNG, POISSON, 1.0);
    let mut m = Model::new(mesh, Analysis::Path(options), material, THICKNESS);
    let plane = |on: &str, normal: [f64; 3]| Condition::Symmetry(SymmetryPlane { on: on.into(), normal });
    let (sine, cosine) = WEDGE.to_radians().sin_cos();
    m.conditions = vec![
        plane("u_min", [1.0, 0.0, 0.0]),
        plane("u_max", [cosine, 0.0, -sine]),
        plane("v_min", [0.0, 1.0, 0.0]),
        Condition::Fix(FixComponents { on: "v_max".into(), position: Vec::new(), director: vec![Axis::Y] }),
        Condition::Prescribe(PrescribeComponent {
            on: "v_max".into(),
            of: NodalVector::Position,
            component: Axis::Y,
            value: -length * classical() / YOUNG,
            amplitude: None,
        }),
    ];
    // Inwards at the end, where the buckles have a crest.
    m.imperfections = vec![Imperfection::Wave(WaveImperfection {
        amplitude: -amplitude,
        direction: [0.0, 1.0, 0.0],
        wavelength: wavelength(),
        phase: 0.0,
    })];
    m
}

/// Mean axial stress over the classical one along a path, by the load factor.
struct Stress<'a> {
    system: &'a System,
    assembly: Assembly,
    end: Vec<usize>,
    points: Vec<(f64, f64)>,
}

impl Observer for Stress<'_> {
    fn on_step(&mut self, step: &Step) -> Result<()> {
        let reactions = statics::reactions(self.system, &mut self.assembly, step.state);
        let force: f64 = self.end.iter().map(|&v| reactions[v][1]).sum();
        let area = WEDGE / 180.0 * PI * RADIUS * THICKNESS;
        self.points.push((step.state.time, force / (area * classical())));
        Ok(())
    }

    fn column(&mut self, name: &str, step: &Step) -> Option<f64> {
        (name == "buckled").then_some(step.state.negative_pivots as f64)
    }
}

/// Axial stress at the first bifurcation over the classical one.
fn bifurcation(amplitude: f64) -> Result<f64> {
    let m = model(amplitude);
    let Analysis::Path(options) = &m.analysis else { return Ok(f64::NAN) };
    let nominal = generate(&m.mesh)?;
    let mesh = imperfect_mesh(&m, &nominal, &mut tegula::analysis::Silent)?.unwrap_or(nominal);
    let system = build(&m, &mesh)?;
    let position_of = &system.coordinates.position_of;
    let end =
        mesh.nodes_on("v_min").into_iter().flatten().map(|n| position_of[n as usize] as usize).collect();
    let assembly = Assembly::new(&system);
    let mut stress = Stress { system: &system, assembly, end, points: vec![(0.0, 0.0)] };
    let outcome = run_path(&system, options, &mut stress)?;
    let critical = outcome.state.path.map(|path| path.critical).unwrap_or_default();
    let first = critical.iter().find(|point| point.kind == CriticalKind::Bifurcation);
    let load = first.map_or(f64::NAN, |point| point.load);
    let at = |pair: &[(f64, f64)]| {
        let part = (load - pair[0].0) / (pair[1].0 - pair[0].0);
        (0.0..=1.0).contains(&part).then(|| pair[0].1 + part * (pair[1].1 - pair[0].1))
    };
    Ok(stress.points.windows(2).find_map(at).unwrap_or(f64::NAN))
}

/// Bifurcation loads of four amplitudes against one term of Donnell's equations; and against the asymptotic formula, which lies 12 % above that at
/// δ/h = 0.2.
fn imperfect_cylinder(report: &mut Report) -> Result<()> {
    let mesh = format!("{}x{}", ELEMENTS[0], ELEMENTS[1]);
    let mut points = Vec::new();
    for mu in AMPLITUDES {
        let found = bifurcation(mu * THICKNESS)?;
        let quantity = |of: &str| format!("bifurcation load of amplitude {mu} h, {of}");
        report.relative(CASE, &quantity("Donnell's equations"), &mesh, found, one_term(mu), 0.02);
        if mu < 0.15 {
            report.relative(CASE, &quantity("asymptotic formula"), &mesh, found, asymptotic(mu), 0.08);
        }
        points.push((mu, found));
    }
    report.element("ems");
    let Some(path) = report.picture("imperfect_cylinder.png") else { return Ok(()) };
    let curve =
        |f: fn(f64) -> f64| (0..=100).map(|i| 2.2e-5 * f64::from(i * i)).map(|mu| (mu, f(mu))).collect();
    let series =
        |name: &str, points: Vec<(f64, f64)>, style: Style| Series { name: name.into(), points, style };
    let plot = LinePlot {
        title: "Cylinder under axial compression, axisymmetric imperfection".into(),
        x_label: "amplitude / thickness".into(),
        y_label: "bifurcation load / classical load".into(),
        series: vec![
            series("asymptotic formula", curve(asymptotic), Style::Line),
            series("Donnell's equations, one term", curve(one_term), Style::Line),
            series(&format!("EMS {mesh}"), points, Style::Markers),
        ],
        ..LinePlot::default()
    };
    lines(&path, &plot).map_err(|e| Error::Outside(e.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both relations agree to first order in √μ.
    #[test]
    fn the_cubic_becomes_the_asymptotic_formula() {
        for mu in [1e-4, 1e-6] {
            let (a, b) = (asymptotic(mu), one_term(mu));
            assert!(
                (a - b).abs() < 2.0 * c() * mu && (1.0 - a - (1.5 * c() * mu).sqrt()).abs() < 2.0 * mu,
                "{a} {b}"
            );
        }
    }
}
