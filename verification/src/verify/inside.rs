//! Materials that are not linear, and strains of their own: balloon, bimetal, tube.

use std::f64::consts::FRAC_PI_4;

use tegula::analysis::{Silent, State, statics};
use tegula::compile::build;
use tegula::model::{
    Analysis, Axis, Condition, ElementKind, Grid, Isotropic, Layup, LayupPly, Load, Material, MeshSource,
    Model, NeoHookean, NodalVector, PlateMesh, PrescribeComponent, PrescribedStrain, PressureLoad, Section,
    StaticAnalysis, SymmetryPlane, ThermalStrain,
};
use tegula::system::Assembly;
use tegula::{Error, Mesh, Result, Vec3};

use super::reference::records;
use super::report::{Report, Table};
use super::statistics::run_static;
use super::{Case, Cost};
use tegula_io::plot::{LinePlot, Series, Style, lines};

/// Cases of this file.
pub(super) const CASES: &[Case] = &[
    Case {
        name: "balloon",
        about: "sphere of neo-Hookean rubber under pressure, through its limit",
        cost: Cost::Normal,
        run: balloon,
    },
    Case {
        name: "bimetal",
        about: "Timoshenko's bimetal strip: two layers that expand differently",
        cost: Cost::Fast,
        run: bimetal,
    },
];

const BALLOON: &str = include_str!("../../reference/balloon.csv");

pub(super) fn flat(size: [f64; 2], elements: [u32; 2]) -> MeshSource {
    MeshSource::Plate(PlateMesh {
        origin: [0.0; 3],
        u_axis: [1.0, 0.0, 0.0],
        v_axis: [0.0, 1.0, 0.0],
        size,
        grid: Grid::uniform(elements[0], elements[1]),
    })
}

/// The points of the octant that are held, and the coordinate that each is held by: its poles and its middle.
const HELD: [(&str, Axis); 4] =
    [("pole x", Axis::X), ("pole y", Axis::Y), ("pole z", Axis::Z), ("middle", Axis::X)];

/// An octant of a sphere of radius 1: three faces of a cube with `n × n` elements each, pushed out to the sphere.
pub(super) fn octant(n: u32) -> Mesh {
    let mut mesh = Mesh::default();
    // Nodes by where they lie on the cube, so that the faces share those of their edges.
    let mut node_at = std::collections::BTreeMap::new();
    let mut normals = Vec::new();
    for face in 0..3_usize {
        let mut node = |i: u32, j: u32| {
            let mut key = [n; 3];
            key[(face + 1) % 3] = i;
            key[(face + 2) % 3] = j;
            *node_at.entry(key).or_insert_with(|| {
                let on_cube = key.map(|k| (FRAC_PI_4 * f64::from(k) / f64::from(n)).tan());
                mesh.positions.push(Vec3::from(on_cube).normalize());
                mesh.positions.len() as u32 - 1
            })
        };
        for j in 0..n {
            for i in 0..n {
                mesh.quads.push([node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)]);
            }
        }
    }
    for quad in &mesh.quads {
        normals.push(quad.map(|k| mesh.positions[k as usize]));
    }
    mesh.normals = Some(normals);
    for (axis, name) in ["x = 0", "y = 0", "z = 0"].into_iter().enumerate() {
        let on_plane = node_at.iter().filter(|(key, _)| key[axis] == 0).map(|(_, node)| *node).collect();
        mesh.node_sets.insert(name.into(), on_plane);
    }
    for ((name, _), key) in HELD.iter().zip([[n, 0, 0], [0, n, 0], [0, 0, n], [n, n, n]]) {
        mesh.node_sets.insert((*name).into(), node_at.get(&key).copied().into_iter().collect());
    }
    mesh
}

/// Shear modulus and thickness of the balloon.
const SHEAR: f64 = 1.0;
const H: f64 = 0.01;

/// Blown-up sphere of neo-Hookean rubber with four held points.
struct Balloon {
    mesh: Mesh,
    model: Model,
    options: StaticAnalysis,
    /// Nodes of the held points.
    held: Vec<u32>,
    /// Stretch and state from which the next ones are found.
    start: Option<(f64, State)>,
}

impl Balloon {
    /// Octant of the sphere without pressure, with `n × n` elements on each of its three faces.
    fn new(element: ElementKind, n: u32) -> Self {
        let mesh = octant(n);
        let options =
            StaticAnalysis { allow_unstable: true, max_iterations: 60, ..StaticAnalysis::default() };
        let analysis = Analysis::Static(options.clone());
        let mut model = Model::new(flat([1.0; 2], [1, 1]), analysis, Isotropic::new(1.0, 0.3, 1.0), H);
        let rubber = NeoHookean { shear: SHEAR, bulk: 2e3, density: 0.0, form: Default::default() };
        model.materials.insert("m".into(), Material::NeoHookean(rubber));
        model.sections[0].element = element;
        for (on, normal) in
            [("x = 0", [1.0, 0.0, 0.0]), ("y = 0", [0.0, 1.0, 0.0]), ("z = 0", [0.0, 0.0, 1.0])]
        {
            model.conditions.push(Condition::Symmetry(SymmetryPlane { on: on.into(), normal }));
        }
        for (on, component) in HELD {
            model.conditions.push(Condition::Prescribe(PrescribeComponent {
                on: on.into(),
                of: NodalVector::Position,
                component,
                value: 0.0,
                amplitude: None,
            }));
        }
        model.loads = vec![Load::Pressure(PressureLoad {
            on: "all".into(),
            value: 0.0,
            amplitude: None,
            distribution: None,
        })];
        let held = HELD.iter().filter_map(|(name, _)| mesh.nodes_on(name)?.first().copied()).collect();
        Self { mesh, model, options, held, start: None }
    }

    /// Equilibrium at a stretch of the held points and a pressure, and the work of their supports when the sphere grows.
    fn solve(&mut self, stretch: f64, pressure: f64) -> Result<(f64, State)> {
        let Self { mesh, model, options, held, start } = self;
        let supports = model.conditions.iter_mut().filter_map(|c| match c {
            Condition::Prescribe(p) => Some(p),
            _ => None,
        });
        for (support, node) in supports.zip(&*held) {
            support.value = (stretch - 1.0) * mesh.positions[*node as usize][support.component as usize];
        }
        if let Some(Load::Pressure(p)) = model.loads.first_mut() {
            // Positive pressure pushes against the directors, which point outwards here.
            p.value = -pressure * SHEAR * H;
        }
        let system = build(model, mesh)?;
        // The last shape, blown up without a change of volume, is near the next one.
        let mut state = State::at_rest(&system);
        let before = start.as_ref().map_or(1.0, |(before, last)| {
            state.history.copy_from_slice(&last.history);
            state.u.copy_from_slice(&last.u);
            *before
        });
        let ratio = stretch / before;
        for (v, u) in state.u.iter_mut().enumerate() {
            let reference = Vec3::from(system.coordinates.reference[v]);
            let director = system.coordinates.kinds[v] != tegula::system::VectorKind::Position;
            let factor = if director { ratio.powi(-2) } else { ratio };
            *u = ((reference + Vec3::from(*u)) * factor - reference).into();
        }
        state.next_step = 1.0;
        let outcome = run_static(&system, options, Some(state), &mut Silent)?;
        let mut assembly = Assembly::new(&system);
        let reactions = statics::reactions(&system, &mut assembly, &outcome.state);
        let work = |node: &u32| {
            let v = system.coordinates.position_of[*node as usize] as usize;
            Vec3::from(reactions[v]).dot(&Vec3::from(system.coordinates.reference[v]))
        };
        Ok((held.iter().map(work).sum(), outcome.state))
    }

    /// Pressure at a stretch, near an estimate, by the secant on the work of the supports, which is linear in the pressure but for the change of shape.
    fn pressure(&mut self, stretch: f64, near: f64) -> Result<f64> {
        let (mut p0, mut p1) = ((1.0 - 2e-5) * near, (1.0 + 2e-5) * near);
        let (mut r0, _) = self.solve(stretch, p0)?;
        for _ in 0..20 {
            let (r1, state) = self.solve(stretch, p1)?;
            let next = p1 - r1 * (p1 - p0) / (r1 - r0);
            let settled = (next - p1).abs() < 1e-8 * p1.abs();
            (p0, r0, p1) = (p1, r1, next);
            if settled {
                self.start = Some((stretch, state));
                return Ok(p1);
            }
        }
        Err(Error::Outside(format!("balloon: no pressure found at stretch {stretch}")))
    }
}

/// Blown-up sphere of neo-Hookean rubber: the pressure that holds a stretch of four points, found so that the supports
/// which prescribe it do no work when the sphere grows. Under pressure alone it is unstable beyond the limit.
fn balloon_pressures(element: ElementKind, n: u32, stretches: &[f64]) -> Result<Vec<f64>> {
    let mut balloon = Balloon::new(element, n);
    // Beyond the limit only a narrow band of pressures keeps the points between those that are held in place.
    let mut found_to_exact = 1.0;
    let mut out = Vec::new();
    for &stretch in stretches {
        let exact = 2.0 * (stretch.recip() - stretch.powi(-7));
        let found = balloon.pressure(stretch, exact * found_to_exact)?;
        found_to_exact = found / exact;
        out.push(found);
    }
    Ok(out)
}

/// The balloon against the exact thin sphere, `p R/(μ h) = 2 (λ⁻¹ − λ⁻⁷)`, and its limit.
pub fn balloon(report: &mut Report) -> Result<()> {
    let all = records(BALLOON);
    // Near 1 the pressure feels the mesh (2.4 % at 1.05 with four elements along an edge, 0.75 % with eight); far
    // beyond the limit the held points no longer keep the sphere round.
    let listed: Vec<_> = all.iter().filter(|r| (1.1..1.4).contains(&r.number("stretch"))).collect();
    let (limit, highest) = (1.383088, 1.239463);
    let around = [1.36, limit, 1.41];
    let mut stretches: Vec<f64> =
        listed.iter().map(|r| r.number("stretch")).chain([around[0], around[2]]).collect();
    stretches.sort_by(f64::total_cmp);
    let mut series = Vec::new();
    for (element, name) in [(ElementKind::Cm, "cm"), (ElementKind::SolidShell, "solid-shell")] {
        report.element(name);
        let found = balloon_pressures(element, 8, &stretches)?;
        let at = |stretch: f64| stretches.iter().position(|s| *s == stretch).map_or(f64::NAN, |k| found[k]);
        for record in &listed {
            let stretch = record.number("stretch");
            let what = format!("p R/(mu h) at stretch {stretch}");
            report.relative("balloon", &what, "3x8x8", at(stretch), record.number("p_R0_over_mu_h0"), 5e-3);
        }
        // The limit: the top of the parabola through three points around it.
        let p = around.map(at);
        let slope = |a: usize, b: usize| (p[b] - p[a]) / (around[b] - around[a]);
        let bend = (slope(1, 2) - slope(0, 1)) / (around[2] - around[0]);
        let middle = 0.5 * (around[0] + around[1]);
        let there = middle - slope(0, 1) / (2.0 * bend);
        let top = p[1] + slope(0, 1) * (there - around[1]) + bend * (there - around[0]) * (there - around[1]);
        report.relative("balloon", "limit pressure p R/(mu h)", "3x8x8", top, highest, 5e-3);
        report.relative("balloon", "stretch at the limit", "3x8x8", there, limit, 5e-3);
        let points = stretches.iter().copied().zip(found).collect();
        series.push(Series { name: name.into(), points, style: Style::Markers });
    }
    report.element("ems");
    if let Some(path) = report.picture("balloon.png") {
        let exact = |i: i32| {
            let l = 1.0 + 0.02 * f64::from(i);
            (l, 2.0 * (l.recip() - l.powi(-7)))
        };
        series.insert(
            0,
            Series { name: "exact".into(), points: (0..=22).map(exact).collect(), style: Style::Line },
        );
        let plot = LinePlot {
            title: "Balloon of neo-Hookean rubber".into(),
            x_label: "stretch".into(),
            y_label: "pressure p R/(μ h)".into(),
            series,
            ..LinePlot::default()
        };
        lines(&path, &plot).map_err(|e| Error::Outside(e.to_string()))?;
    }
    Ok(())
}

/// S. Timoshenko, *Analysis of bi-metal thermostats*, J. Opt. Soc. Am. 11 (1925) 233–255: curvature of a strip of two
/// metals, `κ = 6 (α₂ − α₁) T (1 + m)² / (h (3 (1 + m)² + (1 + m n)(m² + 1/(m n))))`, m = h₁/h₂, n = E₁/E₂.
pub fn bimetal(report: &mut Report) -> Result<()> {
    let mut table = Table::new(
        "bimetal",
        "Bimetal strip: radius by Timoshenko and by the elements",
        &["h1/h2", "E1/E2", "radius (Timoshenko)", "ems", "mitc4", "cm"],
    );
    // Thin, so that a small heat curls it: the theory is one of small strains.
    let (heat, length, h) = (10.0, 0.4, 1e-4);
    let (slow, fast) = (4e-6, 24e-6);
    for (m, n) in [(1.0, 1.0), (1.0, 2.0), (0.5, 0.4), (2.0, 1.5)] {
        let top = (1.0_f64 + m).powi(2);
        let curvature =
            6.0 * (fast - slow) * heat * top / (h * (3.0 * top + (1.0 + m * n) * (m * m + 1.0 / (m * n))));
        let mut row = vec![format!("{m}"), format!("{n}"), format!("{:.6}", 1.0 / curvature)];
        for (element, name) in
            [(ElementKind::Ems, "ems"), (ElementKind::Mitc4, "mitc4"), (ElementKind::Cm, "cm")]
        {
            let found = bimetal_curvature(element, [m, n], [slow, fast], heat, length, h)?;
            report.element(name);
            let what = format!("curvature for h1/h2 = {m}, E1/E2 = {n}");
            // Sixteen chords of the arc, and the free edges of a strip with a width; no Poisson's ratio.
            report.relative("bimetal", &what, "16x1", found, curvature, 2e-3);
            row.push(format!("{:.6}", 1.0 / found));
        }
        table.cells.push(row);
    }
    report.element("ems");
    report.table(table);
    Ok(())
}

fn bimetal_curvature(
    element: ElementKind,
    [m, n]: [f64; 2],
    [slow, fast]: [f64; 2],
    heat: f64,
    length: f64,
    h: f64,
) -> Result<f64> {
    let source = flat([length, 0.02], [16, 1]);
    let options = StaticAnalysis { load_steps: 2, ..StaticAnalysis::default() };
    let mut model =
        Model::new(source.clone(), Analysis::Static(options.clone()), Isotropic::new(1.0, 0.0, 1.0), h);
    let metal = |young: f64, expansion: f64| {
        Material::Isotropic(Isotropic { expansion, ..Isotropic::new(young, 0.0, 1.0) })
    };
    model.materials.insert("slow".into(), metal(n * 1e11, slow));
    model.materials.insert("fast".into(), metal(1e11, fast));
    let ply = |name: &str, share: f64| LayupPly {
        material: Some(name.into()),
        angle: 0.0,
        thickness: Some(share * h),
    };
    model.sections[0] = Section {
        element,
        layup: Some(Layup {
            plies: vec![ply("slow", m / (1.0 + m)), ply("fast", 1.0 / (1.0 + m))],
            ..Layup::default()
        }),
        ..Section::new("", 0.0)
    };
    model.conditions = vec![Condition::Clamp(tegula::model::OnSet { on: "u_min".into() })];
    let thermal = ThermalStrain {
        distribution: None,
        on: "all".into(),
        temperature: heat,
        gradient: 0.0,
        amplitude: None,
    };
    model.prescribed_strains = vec![PrescribedStrain::Thermal(thermal)];
    let mesh = tegula::mesh::generators::generate(&source)?;
    let system = build(&model, &mesh)?;
    let outcome = run_static(&system, &options, None, &mut Silent)?;
    let tip = mesh.nodes_on("u_max_v_min").and_then(|n| n.first().copied()).unwrap_or(0);
    let d = system.coordinates.director_of[tip as usize] as usize;
    let director = Vec3::from(system.coordinates.reference[d]) + Vec3::from(outcome.state.u[d]);
    Ok(director.x.atan2(director.z).abs() / length)
}
