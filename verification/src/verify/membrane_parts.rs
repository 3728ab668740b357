//! Comparison of all membrane parts: accuracy and stability.
//!
//! The tables `membrane-accuracy` and `membrane-stability` of the book. The properties of the default are compared with
//! references: accuracy of enhanced strains on coarse meshes, no loss of stability in strips of stretched elements and in
//! rubber that no theory knows.

use tegula::analysis::{Observer, Silent, Step};
use tegula::compile::build;
use tegula::model::{
    Analysis, Axis, Condition, ElementKind, FixComponents, Isotropic, Load, Material, Membrane, MeshSource,
    Model, MooneyRivlin, NodalVector, OnSet, PrescribeComponent, PressureLoad, StaticAnalysis, SymmetryPlane,
    VectorLoad,
};
use tegula::{Error, Mesh, Result, Vec3};

use super::inside::{flat, octant};
use super::report::{Report, Table};
use super::statistics::run_static;
use super::{Case, Cost};
use super::{benchmarks, frequencies, macneal_beams, paper, pendulum, plate, quarter_cylinder};

/// Cases of this file.
pub(super) const CASES: &[Case] = &[Case {
    name: "membrane-parts",
    about: "all values of the key membrane: accuracy, stability of stretched elements and of rubber",
    cost: Cost::Normal,
    run: all,
}];

const CASE: &str = "membrane-parts";

/// Row of a table: its title, and its value for a membrane part.
type Line = (String, Box<dyn Fn(Membrane) -> Result<f64>>);

/// Both tables.
pub fn all(report: &mut Report) -> Result<()> {
    accuracy(report)?;
    stretched(report)?;
    rubber(report)?;
    report.element("ems");
    Ok(())
}

/// An element with a membrane part, as [`super::model::switch`] reads it.
fn variant(element: &str, part: Membrane) -> String {
    format!("{element} membrane {}", part.name())
}

fn heads(first: &str) -> Vec<&str> {
    std::iter::once(first).chain(Membrane::ALL.map(Membrane::name)).collect()
}

/// Values over those of the references.
fn accuracy(report: &mut Report) -> Result<()> {
    let mut table = Table::new(
        "membrane-accuracy",
        "Membrane parts of `ems`: values over those of the references",
        &heads("problem, elements"),
    );
    let mut lines: Vec<Line> = Vec::new();
    for n in [4, 8, 16] {
        lines.push((format!("Cook's membrane, {n}x{n}"), Box::new(move |part| Ok(cook(part, n)? / 23.96))));
    }
    for (index, (name, _)) in macneal_beams::coarse("ems")?.into_iter().enumerate() {
        let value = move |part| Ok(macneal_beams::coarse(&variant("ems", part))?[index].1);
        lines.push((format!("MacNeal-Harder, {name}"), Box::new(value)));
    }
    for (problem, name) in [
        ("pinched_cylinder", "pinched cylinder"),
        ("scordelis_lo", "Scordelis-Lo roof"),
        ("hemisphere_18", "hemisphere with a hole"),
    ] {
        for n in [8, 16] {
            let value = move |part| benchmarks::linear_ratio(problem, &variant("EMS", part), n);
            lines.push((format!("{name}, {n}x{n}"), Box::new(value)));
        }
    }
    for n in [8, 16] {
        lines.push((format!("hyperbolic paraboloid, {n}x{n}"), Box::new(move |part| hypar(part, n))));
    }
    lines.push((
        "Sect. 5.1, cantilever plate L/H = 100, 8x8".into(),
        Box::new(|part| Ok(plate::deflections(&variant("EMS", part), 8, 1e-2)?[0] / paper::theory(1e-2)[0])),
    ));
    lines.push((
        "Sect. 5.2, quarter cylinder, 16x16".into(),
        // The limit of three programs, on 64 x 64 to 100 x 100 elements.
        Box::new(|part| Ok(quarter_cylinder::deflection(&variant("EMS", part), 16)? / -1.1979)),
    ));
    lines.push((
        "Sect. 5.3, free plate L/H = 100, first frequency, 8x8".into(),
        Box::new(|part| Ok(frequencies::lowest(&variant("EMS", part), 8)? / paper::series(100.0)[0])),
    ));
    lines.push((
        "Sect. 5.4, pendulum, 8x8: distance [m] from the reference within 0.4 s".into(),
        Box::new(|part| pendulum::deviation(&variant("EMS", part))),
    ));
    for (name, value) in lines {
        let mut row = vec![name.clone()];
        for part in Membrane::ALL {
            let value = value(part)?;
            row.push(format!("{value:.3}"));
            report.element(&variant("ems", part));
            if part == Membrane::default() && name == "Cook's membrane, 8x8" {
                report.relative(CASE, "Cook's membrane over 23.96", "8x8", value, 1.0, 0.015);
            }
        }
        table.cells.push(row);
    }
    report.table(table);
    Ok(())
}

/// A mesh of nu × nv quads from a map of the unit square to position and normal, with the sets `root` (u = 0), `tip`
/// (u = 1) and `middle` (u = 1, v = ½).
fn mapped([nu, nv]: [u32; 2], map: fn(f64, f64) -> (Vec3, Vec3)) -> Mesh {
    let at = |i: u32, j: u32| map(f64::from(i) / f64::from(nu), f64::from(j) / f64::from(nv));
    let node = |i: u32, j: u32| j * (nu + 1) + i;
    let mut mesh = Mesh::default();
    let mut normals = Vec::new();
    for j in 0..=nv {
        mesh.positions.extend((0..=nu).map(|i| at(i, j).0));
    }
    for (j, i) in (0..nv).flat_map(|j| (0..nu).map(move |i| (j, i))) {
        let corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
        mesh.quads.push(corners.map(|(i, j)| node(i, j)));
        normals.push(corners.map(|(i, j)| at(i, j).1));
    }
    mesh.normals = Some(normals);
    mesh.node_sets.insert("root".into(), (0..=nv).map(|j| node(0, j)).collect());
    mesh.node_sets.insert("tip".into(), (0..=nv).map(|j| node(nu, j)).collect());
    mesh.node_sets.insert("middle".into(), vec![node(nu, nv / 2)]);
    for j in 0..=nv {
        mesh.node_sets.insert(format!("tip-{j}"), vec![node(nu, j)]);
    }
    mesh
}

/// A clamped sheet on a mapped mesh, linear.
fn clamped(material: Isotropic, thickness: f64, part: Membrane) -> (Model, StaticAnalysis) {
    let options = StaticAnalysis { linear: true, ..StaticAnalysis::default() };
    let mut model =
        Model::new(flat([1.0; 2], [1, 1]), Analysis::Static(options.clone()), material, thickness);
    model.sections[0].membrane = Some(part);
    model.conditions = vec![Condition::Clamp(OnSet { on: "root".into() })];
    (model, options)
}

/// Displacement of the middle of the tip.
fn at_middle(model: &Model, options: &StaticAnalysis, mesh: &Mesh) -> Result<Vec3> {
    let system = build(model, mesh)?;
    let outcome = run_static(&system, options, None, &mut Silent)?;
    let node = mesh.nodes_on("middle").and_then(|n| n.first().copied()).unwrap_or(0);
    Ok(Vec3::from(outcome.state.u[system.coordinates.position_of[node as usize] as usize]))
}

/// Cook's membrane (R. D. Cook, J. Struct. Div. ASCE 100 (1974) 1851–1863): E = 1, ν = 1/3, a shear load of 1 on the
/// right edge; displacement of its middle. The fine-mesh value 23.96 is that of J. C. Simo, M. S. Rifai, Int. J. Numer.
/// Methods Eng. 29 (1990) 1595–1638.
fn cook(part: Membrane, n: u32) -> Result<f64> {
    let map = |u: f64, v: f64| {
        let (low, high) = (44.0 * u, 44.0 + 16.0 * u);
        (Vec3::new(48.0 * u, low + v * (high - low), 0.0), Vec3::z())
    };
    let mesh = mapped([n, n], map);
    let (mut model, options) = clamped(Isotropic::new(1.0, 1.0 / 3.0, 1.0), 1.0, part);
    let flat = FixComponents {
        on: "all".into(),
        position: vec![Axis::Z],
        director: vec![Axis::X, Axis::Y, Axis::Z],
    };
    model.conditions = vec![
        Condition::Fix(FixComponents {
            on: "root".into(),
            position: vec![Axis::X, Axis::Y],
            director: Vec::new(),
        }),
        Condition::Fix(flat),
    ];
    for j in 0..=n {
        let share = if j == 0 || j == n { 0.5 } else { 1.0 } / f64::from(n);
        model.loads.push(Load::Force(VectorLoad {
            on: format!("tip-{j}"),
            value: [0.0, share, 0.0],
            amplitude: None,
            distribution: None,
        }));
    }
    Ok(at_middle(&model, &options, &mesh)?.y)
}

/// Hyperbolic paraboloid `z = x² − y²` on the square of side 1, clamped at x = −½, under a load of 8 per area along −z,
/// E = 2e11, ν = 0.3, h = 1/1000 (K.-J. Bathe, A. Iosilevich, D. Chapelle, *An evaluation of the MITC shell elements*,
/// Comput. Struct. 75 (2000) 1–30): deflection of the middle of the far edge over theirs, 6.3941e-3.
fn hypar(part: Membrane, n: u32) -> Result<f64> {
    let map = |u: f64, v: f64| {
        let (x, y) = (u - 0.5, v - 0.5);
        (Vec3::new(x, y, x * x - y * y), Vec3::new(-2.0 * x, 2.0 * y, 1.0).normalize())
    };
    let mesh = mapped([n, n], map);
    let (mut model, options) = clamped(Isotropic::new(2e11, 0.3, 1.0), 1e-3, part);
    let weight =
        VectorLoad { on: "all".into(), value: [0.0, 0.0, -8.0], amplitude: None, distribution: None };
    model.loads = vec![Load::Traction(weight)];
    Ok(at_middle(&model, &options, &mesh)?.z / -6.3941e-3)
}

/// Load factor of the last equilibrium that was found.
#[derive(Default)]
struct Reached(f64);

impl Observer for Reached {
    fn on_step(&mut self, step: &Step) -> Result<()> {
        self.0 = step.state.time;
        Ok(())
    }
}

/// Load factor up to which equilibria are stable.
fn stable_up_to(model: &Model, options: &StaticAnalysis, mesh: &Mesh) -> Result<f64> {
    let system = build(model, mesh)?;
    let mut reached = Reached::default();
    match run_static(&system, options, None, &mut reached) {
        Ok(_) | Err(Error::NotConverged { .. }) => Ok(reached.0),
        Err(other) => Err(other),
    }
}

/// A clamped square of side 1 and thickness 0.05 in n × 1 elements under an edge load whose linear moment strains the
/// fibres at the support by a tenth: the strain up to which it is stable.
fn strip(part: Membrane, n: u32) -> Result<f64> {
    let (young, h, strain) = (1e6, 0.05, 0.1);
    let options = StaticAnalysis { load_steps: 10, ..StaticAnalysis::default() };
    let source = flat([1.0; 2], [n, 1]);
    let mut model =
        Model::new(source.clone(), Analysis::Static(options.clone()), Isotropic::new(young, 0.0, 1.0), h);
    model.sections[0].membrane = Some(part);
    model.conditions = vec![Condition::Clamp(OnSet { on: "u_min".into() })];
    let force = strain * young * h * h / 6.0;
    model.loads = vec![Load::Edge(VectorLoad {
        on: "u_max".into(),
        value: [0.0, 0.0, force],
        amplitude: None,
        distribution: None,
    })];
    Ok(strain * stable_up_to(&model, &options, &tegula::mesh::generators::generate(&source)?)?)
}

fn stretched(report: &mut Report) -> Result<()> {
    let title = "Fibre strain up to which a clamped strip is stable (computed to 0.1), by the aspect ratio of its elements";
    let mut table = Table::new("membrane-stretched", title, &heads("aspect ratio"));
    for n in [1, 2, 4, 8, 16, 32, 64] {
        let mut row = vec![n.to_string()];
        for part in Membrane::ALL {
            let strain = strip(part, n)?;
            row.push(format!("{strain:.3}"));
            // A single element is a chord that turns as a whole: it is not the membrane part that gives way.
            if part == Membrane::default() && n > 1 {
                report.element(&variant("ems", part));
                report.relative(CASE, "strip: stable fibre strain", &format!("{n}x1"), strain, 0.1, 0.0);
            }
        }
        table.cells.push(row);
    }
    report.table(table);
    Ok(())
}

const TYRE: MooneyRivlin = MooneyRivlin { c10: 2e5, c01: 5e4, bulk: 5e8, density: 0.0 };
/// Constants whose balloon has its limit at a stretch of 1.535.
const SOFT: MooneyRivlin = MooneyRivlin { c10: 7e5, c01: 1e5, bulk: 1e9, density: 0.0 };

fn with_rubber(
    source: MeshSource,
    law: MooneyRivlin,
    h: f64,
    part: Option<Membrane>,
) -> (Model, StaticAnalysis) {
    let options = StaticAnalysis { load_steps: 40, max_cutbacks: 14, ..StaticAnalysis::default() };
    let mut model = Model::new(source, Analysis::Static(options.clone()), Isotropic::new(1.0, 0.3, 1.0), h);
    model.materials.insert("m".into(), Material::MooneyRivlin(law));
    model.sections[0].element = ElementKind::Cm;
    model.sections[0].membrane = part;
    (model, options)
}

fn symmetry(on: &str, normal: [f64; 3]) -> Condition {
    Condition::Symmetry(SymmetryPlane { on: on.into(), normal })
}

/// Quarter of a sheet under equal biaxial tension up to a stretch of 3: largest stretch at which it is stable.
fn biaxial(part: Option<Membrane>, distortion: f64) -> Result<f64> {
    let mut source = flat([1.0; 2], [4, 4]);
    if let Some(grid) = super::model::grid(&mut source) {
        grid.distortion = distortion;
    }
    let (mut model, options) = with_rubber(source.clone(), TYRE, 0.02, part);
    let pull = |on: &str, component| {
        Condition::Prescribe(PrescribeComponent {
            on: on.into(),
            of: NodalVector::Position,
            component,
            value: 2.0,
            amplitude: None,
        })
    };
    let hold = FixComponents { on: "u_min_v_min".into(), position: vec![Axis::Z], director: Vec::new() };
    model.conditions = vec![
        symmetry("u_min", [1.0, 0.0, 0.0]),
        symmetry("v_min", [0.0, 1.0, 0.0]),
        Condition::Fix(hold),
        pull("u_max", Axis::X),
        pull("v_max", Axis::Y),
    ];
    let mesh = tegula::mesh::generators::generate(&source)?;
    Ok(1.0 + 2.0 * stable_up_to(&model, &options, &mesh)?)
}

/// Pressure `p R/(4 c10 h) = (λ⁻¹ − λ⁻⁷)(1 + (c01/c10) λ²)` of a thin sphere, and the stretch of its highest value.
fn sphere(law: &MooneyRivlin) -> (impl Fn(f64) -> f64, f64) {
    let (c10, ratio) = (law.c10, law.c01 / law.c10);
    let pressure = move |l: f64| 4.0 * c10 * (l.recip() - l.powi(-7)) * (1.0 + ratio * l * l);
    let limit =
        (0..=100_000).map(|i| 1.2 + 1e-5 * f64::from(i)).max_by(|a, b| pressure(*a).total_cmp(&pressure(*b)));
    (pressure, limit.unwrap_or(f64::NAN))
}

/// A sphere under pressure, an octant of 3 × 8 × 8 elements: pressure over the exact limit up to which it is stable, and
/// the mean stretch there.
fn balloon(part: Option<Membrane>) -> Result<[f64; 2]> {
    struct Radius<'a> {
        mesh: &'a Mesh,
        position_of: &'a [u32],
        reached: [f64; 2],
    }
    impl Observer for Radius<'_> {
        fn on_step(&mut self, step: &Step) -> Result<()> {
            let stretch = |(node, x): (usize, &Vec3)| {
                let u = Vec3::from(step.state.u[self.position_of[node] as usize]);
                (x + u).norm() / x.norm()
            };
            let sum: f64 = self.mesh.positions.iter().enumerate().map(stretch).sum();
            self.reached = [step.state.time, sum / self.mesh.positions.len() as f64];
            Ok(())
        }
    }
    const H: f64 = 0.01;
    let mesh = octant(8);
    let (mut model, options) = with_rubber(flat([1.0; 2], [1, 1]), SOFT, H, part);
    model.conditions = vec![
        symmetry("x = 0", [1.0, 0.0, 0.0]),
        symmetry("y = 0", [0.0, 1.0, 0.0]),
        symmetry("z = 0", [0.0, 0.0, 1.0]),
    ];
    let (pressure, limit) = sphere(&SOFT);
    // Positive pressure pushes against the directors, which point outwards here.
    let value = -1.1 * pressure(limit) * H;
    model.loads =
        vec![Load::Pressure(PressureLoad { on: "all".into(), value, amplitude: None, distribution: None })];
    let system = build(&model, &mesh)?;
    let mut radius =
        Radius { mesh: &mesh, position_of: &system.coordinates.position_of, reached: [0.0, 1.0] };
    match run_static(&system, &options, None, &mut radius) {
        Ok(_) | Err(Error::NotConverged { .. }) => {
            let [factor, stretch] = radius.reached;
            Ok([1.1 * factor, stretch])
        }
        Err(other) => Err(other),
    }
}

fn rubber(report: &mut Report) -> Result<()> {
    let title = "Mooney-Rivlin rubber in `cm`: how far it is stable";
    let mut columns = heads("problem");
    columns.push("unless given");
    let mut table = Table::new("membrane-rubber", title, &columns);
    let parts: Vec<Option<Membrane>> = Membrane::ALL.into_iter().map(Some).chain([None]).collect();
    for distortion in [0.0, 0.2] {
        let mut row = vec![format!("equal biaxial tension to 3, 4x4, distortion {distortion}: stretch")];
        for part in &parts {
            let stretch = biaxial(*part, distortion)?;
            row.push(format!("{stretch:.2}"));
            if part.is_none() {
                report.element("cm");
                let name = format!("equal biaxial tension, distortion {distortion}: stable stretch");
                report.relative(CASE, &name, "4x4", stretch, 3.0, 0.0);
            }
        }
        table.cells.push(row);
    }
    let mut pressures = vec!["balloon, 3x8x8: pressure over its limit".to_owned()];
    let mut stretches = vec!["balloon, 3x8x8: stretch (limit 1.535)".to_owned()];
    let (_, limit) = sphere(&SOFT);
    for part in &parts {
        let [pressure, stretch] = balloon(*part)?;
        pressures.push(format!("{pressure:.3}"));
        stretches.push(format!("{stretch:.3}"));
        if part.is_none() {
            report.relative(CASE, "balloon: highest pressure over the limit", "3x8x8", pressure, 1.0, 5e-3);
            report.relative(CASE, "balloon: stretch at the highest pressure", "3x8x8", stretch, limit, 0.01);
        }
    }
    table.cells.extend([pressures, stretches]);
    report.table(table);
    Ok(())
}
