//! Models and measures that tests, benchmarks and examples share.
#![allow(dead_code, clippy::unwrap_used)]

use nalgebra::{Rotation3, Unit};
use tegula::analysis::direct::Direct;
use tegula::analysis::dynamics::{self, TransientOutcome};
use tegula::analysis::solver::{Linearization, TangentSolver};
use tegula::analysis::statics::{self, StaticOutcome};
use tegula::analysis::{Observer, State, Step};
use tegula::compile::build;
use tegula::element::{Nodal, ShellGeometry};
use tegula::mesh::generators::generate;
use tegula::model::*;
use tegula::norm::{larger, max_norm};
use tegula::system::{Assembly, VectorKind};
use tegula::{Mesh, System, Vec3};

/// A static model of one section on a mesh, clamped at `u_min`.
pub fn model(mesh: MeshSource, young: f64, thickness: f64) -> Model {
    let material = Isotropic::new(young, 0.3, 1.0);
    let mut model = Model::new(mesh, Analysis::Static(StaticAnalysis::default()), material, thickness);
    model.conditions = vec![Condition::Clamp(OnSet { on: "u_min".into() })];
    model
}

/// A natural strain and curvature of the whole model along x and y.
pub fn natural(strain: [f64; 3], curvature: [f64; 3], amplitude: Option<String>) -> PrescribedStrain {
    let direction = [1.0, 0.0, 0.0];
    PrescribedStrain::Natural(NaturalStrain {
        distribution: None,
        on: "all".into(),
        strain,
        curvature,
        direction,
        amplitude,
    })
}

/// Sect. 5.2 of the paper: x = sin θ, z = 1 − cos θ, θ from 0 to 90°, h = 0.01, clamped at θ = 0.
pub fn quarter_cylinder(n: u32, young: f64) -> Model {
    let mesh = MeshSource::Cylinder(CylinderMesh {
        center: [0.0, 0.0, 1.0],
        axis: [0.0, 1.0, 0.0],
        start: [0.0, 0.0, -1.0],
        radius: 1.0,
        angles: [0.0, -90.0],
        length: 1.0,
        grid: Grid::uniform(n, n),
    });
    model(mesh, young, 0.01)
}

/// A square plate of side 1 or a quarter cylinder of radius and length 1, of thickness 1/`slenderness` and n × n
/// elements, clamped on one edge and loaded on the other; `distortion` shifts the inner nodes of the plate by as many
/// elements.
pub fn edge_loaded_shell(curved: bool, n: u32, slenderness: f64, distortion: f64) -> Model {
    let mut m = if curved {
        quarter_cylinder(n, 2.1e11)
    } else {
        model(plate([1.0, 1.0], [n, n], distortion), 2.1e11, 0.01)
    };
    m.sections[0].thickness = 1.0 / slenderness;
    m.loads = vec![Load::Edge(vector_load("u_max", [0.0, 1.0, -1.0]))];
    m
}

/// The pendulum of Sect. 5.4: a quarter cylinder of 5 kg swings on a corner.
pub fn pendulum(n: u32) -> Model {
    let mut m = quarter_cylinder(n, 2.1e7);
    m.conditions = vec![Condition::Spherical(on("u_min_v_min"))];
    m.sections[0].total_mass = Some(5.0);
    m.loads = vec![Load::Gravity(GravityLoad { value: [0.0, 0.0, -9.81], amplitude: None })];
    m
}

/// Part of a cylinder about the y axis from y = 0 on; the angles (degrees) count from the z axis towards the x axis.
pub fn cylinder(radius: f64, angles: [f64; 2], length: f64, [around, along]: [u32; 2]) -> MeshSource {
    MeshSource::Cylinder(CylinderMesh {
        center: [0.0; 3],
        axis: [0.0, 1.0, 0.0],
        start: [0.0, 0.0, 1.0],
        radius,
        angles,
        length,
        grid: Grid::uniform(around, along),
    })
}

/// Quarter of the hinged cylindrical roof under a force on the whole roof in the middle (K. Y. Sze, X. H. Liu, S. H. Lo, *Popular
/// benchmark problems for geometric nonlinear analysis of shells*, Finite Elem. Anal. Des. 40 (2004) 1551–1569, Sect. 3.6); millimetres, N.
pub fn hinged_roof(n: u32, thickness: f64, force: f64) -> Model {
    let mesh = cylinder(2540.0, [0.0, 0.1_f64.to_degrees()], 254.0, [n, n]);
    let mut m = model(mesh, 3102.75, thickness);
    let plane = |on: &str, normal| Condition::Symmetry(SymmetryPlane { on: on.into(), normal });
    m.conditions =
        vec![plane("u_min", [1.0, 0.0, 0.0]), plane("v_min", [0.0, 1.0, 0.0]), Condition::Hinge(on("u_max"))];
    m.loads = vec![Load::Force(vector_load("u_min_v_min", [0.0, 0.0, -0.25 * force]))];
    m
}

/// A plate in the plane z = 0 from the origin.
pub fn plate(size: [f64; 2], elements: [u32; 2], distortion: f64) -> MeshSource {
    MeshSource::Plate(PlateMesh {
        origin: [0.0; 3],
        u_axis: [1.0, 0.0, 0.0],
        v_axis: [0.0, 1.0, 0.0],
        size,
        grid: Grid { distortion, seed: 7, ..Grid::uniform(elements[0], elements[1]) },
    })
}

/// A wavy square of side 1 in n × n squares, each cut into two triangles along alternating diagonals, each of those
/// cut into three quads: nodes have 3 to 8 neighbours. Edge sets `u_min` and `u_max` at x = 0 and 1, quad sets
/// `half` and `other_half`.
pub fn irregular(n: usize) -> Mesh {
    let mut mesh = Mesh::default();
    let mut numbers = std::collections::HashMap::new();
    // Coordinates in sixths of a square are whole numbers.
    let mut node = |mesh: &mut Mesh, p: [usize; 2]| {
        *numbers.entry(p).or_insert_with(|| {
            let [x, y] = p.map(|c| c as f64 / (6 * n) as f64);
            mesh.positions.push(Vec3::new(x, y, 0.1 * (3.0 * x).sin() * (2.0 * y).cos()));
            (mesh.positions.len() - 1) as u32
        })
    };
    for i in 0..n {
        for j in 0..n {
            let [a, b, c, d] = [[0, 0], [6, 0], [6, 6], [0, 6]].map(|[x, y]| [6 * i + x, 6 * j + y]);
            let triangles = if (i + j) % 3 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] };
            for t in triangles {
                let middle = |p: [usize; 2], q: [usize; 2]| [(p[0] + q[0]) / 2, (p[1] + q[1]) / 2];
                let centre = std::array::from_fn(|k| (t[0][k] + t[1][k] + t[2][k]) / 3);
                for k in 0..3 {
                    let (before, here, after) = (t[(k + 2) % 3], t[k], t[(k + 1) % 3]);
                    let corners = [here, middle(here, after), centre, middle(before, here)];
                    let quad = corners.map(|p| node(&mut mesh, p));
                    let set = if i < n / 2 { "half" } else { "other_half" };
                    mesh.quad_sets.entry(set.into()).or_default().push(mesh.quads.len() as u32);
                    mesh.quads.push(quad);
                }
            }
        }
    }
    for (set, x) in [("u_min", 0), ("u_max", 6 * n)] {
        let edges = (0..2 * n).map(|k| [node(&mut mesh, [x, 3 * k]), node(&mut mesh, [x, 3 * k + 3])]);
        let edges: Vec<[u32; 2]> = edges.collect();
        mesh.edge_sets.insert(set.into(), edges);
    }
    mesh
}

/// Meshes side by side, not connected; the sets of the first are `u_min0` and so on.
pub fn side_by_side(parts: &[Mesh]) -> Mesh {
    let mut out = Mesh::default();
    for (k, part) in parts.iter().enumerate() {
        let (nodes, quads) = (out.positions.len() as u32, out.quads.len() as u32);
        out.positions.extend(part.positions.iter().map(|x| x + Vec3::z() * k as f64));
        out.quads.extend(part.quads.iter().map(|q| q.map(|n| n + nodes)));
        for (name, edges) in &part.edge_sets {
            let moved = edges.iter().map(|e| e.map(|n| n + nodes)).collect();
            out.edge_sets.insert(format!("{name}{k}"), moved);
        }
        for (name, list) in &part.node_sets {
            out.node_sets.insert(format!("{name}{k}"), list.iter().map(|n| n + nodes).collect());
        }
        let all = (quads..quads + part.quads.len() as u32).collect();
        out.quad_sets.insert(format!("part{k}"), all);
    }
    out
}

/// The mesh and system of a model.
pub fn compile(model: &Model) -> (Mesh, System) {
    let mesh = generate(&model.mesh).unwrap();
    let system = build(model, &mesh).unwrap();
    (mesh, system)
}

/// The static options of a model.
pub fn static_options(model: &Model) -> StaticAnalysis {
    match &model.analysis {
        Analysis::Static(s) => s.clone(),
        _ => StaticAnalysis::default(),
    }
}

/// Equilibrium of a static model.
pub fn solve(model: &Model) -> (Mesh, System, StaticOutcome) {
    let (mesh, system) = compile(model);
    let outcome = statics::run(&system, &static_options(model), None, &mut Notes::default()).unwrap();
    (mesh, system, outcome)
}

/// Motion of a model.
pub fn move_in_time(m: &Model, options: &TransientAnalysis, notes: &mut Notes) -> (System, TransientOutcome) {
    let m = Model { analysis: Analysis::Transient(options.clone()), ..m.clone() };
    let (_, system) = compile(&m);
    let outcome = dynamics::run(&system, options, None, notes).unwrap();
    (system, outcome)
}

/// Norm of the difference of two fields.
pub fn distance(a: &[Nodal], b: &[Nodal]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (Vec3::from(*a) - Vec3::from(*b)).norm_squared()).sum::<f64>().sqrt()
}

/// A load by its vector.
pub fn vector_load(on: &str, value: [f64; 3]) -> VectorLoad {
    VectorLoad { on: on.into(), value, amplitude: None, distribution: None }
}

/// Set by name.
pub fn on(set: &str) -> OnSet {
    OnSet { on: set.into() }
}

/// Conditions of an edge that is clamped across the plane and moved along z, `value` times an amplitude.
pub fn driven_edge(on: &str, value: f64, amplitude: &str) -> Vec<Condition> {
    vec![
        Condition::Fix(FixComponents {
            on: on.into(),
            position: vec![Axis::X, Axis::Y],
            director: vec![Axis::X, Axis::Y, Axis::Z],
        }),
        Condition::Prescribe(PrescribeComponent {
            on: on.into(),
            of: NodalVector::Position,
            component: Axis::Z,
            value,
            amplitude: Some(amplitude.into()),
        }),
    ]
}

/// Displacement of the only node of a set.
pub fn displacement(mesh: &Mesh, system: &System, u: &[Nodal], set: &str) -> Vec3 {
    let nodes = mesh.nodes_on(set).unwrap();
    assert_eq!(nodes.len(), 1, "{set}");
    Vec3::from(u[system.coordinates.position_of[nodes[0] as usize] as usize])
}

/// Resultant force and moment about the origin of generalised forces at displacements `u`;
/// the force on a director contributes the moment d × f.
pub fn resultant(system: &System, u: &[Nodal], force: &[Nodal]) -> (Vec3, Vec3) {
    let (mut sum, mut moment) = (Vec3::zeros(), Vec3::zeros());
    for (v, f) in force.iter().enumerate() {
        let (f, x) = (Vec3::from(*f), Vec3::from(system.coordinates.reference[v]) + Vec3::from(u[v]));
        if system.coordinates.kinds[v] == VectorKind::Position {
            sum += f;
        }
        moment += x.cross(&f);
    }
    (sum, moment)
}

/// A rotation by its axis (any length) and angle.
pub fn rotation(axis: [f64; 3], angle: f64) -> Rotation3<f64> {
    Rotation3::from_axis_angle(&Unit::new_normalize(Vec3::from(axis)), angle)
}

/// Reproducible numbers in −1…1.
pub struct Random(u64);

impl Random {
    /// Starts from a seed.
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    /// The next number.
    pub fn next(&mut self) -> f64 {
        for shift in [13, -7, 17_i32] {
            self.0 ^= if shift > 0 { self.0 << shift } else { self.0 >> -shift };
        }
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// The next vector.
    pub fn vector(&mut self) -> Vec3 {
        Vec3::from_fn(|_, _| self.next())
    }
}

/// A distorted rectangle with directors near its normals.
pub fn geometry(random: &mut Random, [a, b]: [f64; 2], noise: f64) -> ShellGeometry {
    let rectangle = [[0.0, 0.0], [a, 0.0], [a, b], [0.0, b]];
    let flat = rectangle.map(|[x, y]| Vec3::new(x, y, 0.0) + random.vector() * noise);
    let directors = std::array::from_fn(|a| {
        let normal = (flat[(a + 1) % 4] - flat[a]).cross(&(flat[(a + 3) % 4] - flat[a])).normalize();
        (normal + random.vector() * noise).normalize()
    });
    ShellGeometry::new(flat, directors)
}

/// A unidirectional ply.
pub fn ply() -> Material {
    orthotropic([3e3, 6e2, 5e2], [4e2, 3e2, 2e2], 0.7)
}

/// An orthotropic material that expands with heat.
pub fn orthotropic(young: [f64; 3], shear: [f64; 3], density: f64) -> Material {
    Material::Orthotropic(Orthotropic {
        young,
        poisson: [0.3, 0.25, 0.2],
        shear,
        density,
        expansion: [1e-3, 4e-3, 4e-3],
        strength: None,
    })
}

/// A prescribed strain of each kind, on all elements.
pub fn strains() -> Vec<PrescribedStrain> {
    vec![
        PrescribedStrain::Thermal(ThermalStrain {
            distribution: None,
            on: "all".into(),
            temperature: 8.0,
            gradient: 60.0,
            amplitude: None,
        }),
        PrescribedStrain::Natural(NaturalStrain {
            distribution: None,
            on: "all".into(),
            strain: [0.01, -0.02, 0.015],
            curvature: [0.2, -0.1, 0.3],
            direction: [0.8, -0.5, 0.1],
            amplitude: None,
        }),
        PrescribedStrain::Prestress(Prestress {
            distribution: None,
            on: "all".into(),
            membrane: [1.0, 2.0, -0.5],
            bending: [0.02, 0.01, 0.03],
            direction: [0.4, 0.9, 0.1],
            amplitude: None,
        }),
    ]
}

/// The quarter cylinder of Sect. 5.2 under the force at its corner.
pub fn loaded_quarter_cylinder(n: u32, element: ElementKind) -> System {
    let mut model = quarter_cylinder(n, 2.1e8);
    model.sections[0].element = element;
    model.loads = vec![Load::Force(vector_load("u_max_v_max", [0.0, 0.0, -20.0]))];
    compile(&model).1
}

/// An observer that keeps what it is told.
#[derive(Default)]
pub struct Notes {
    /// Events and warnings in words.
    pub events: Vec<String>,
    /// Warnings in words.
    pub warnings: Vec<String>,
    /// Time and total energy after each step.
    pub totals: Vec<(f64, f64)>,
    /// Largest kinetic energy.
    pub kinetic: f64,
    /// Linear and angular momentum after each step.
    pub momenta: Vec<(Vec3, Vec3)>,
    /// States after each step, where wanted.
    pub states: Vec<State>,
    /// Keep the states.
    pub keep: bool,
    /// Iterations of all steps.
    pub iterations: Vec<u32>,
}

impl Notes {
    /// Notes that keep the states.
    pub fn keeping() -> Self {
        Self { keep: true, ..Self::default() }
    }

    /// Asserts that the total energy keeps its first value, up to 1e-10 of the largest kinetic energy, and linear and angular momentum theirs up to
    /// a share.
    pub fn assert_conserved(&self, share: f64) {
        let drift = self.drift();
        assert!(self.kinetic > 1.0 && drift <= 1e-10 * self.kinetic, "energy: {}", drift / self.kinetic);
        let (linear, angular) = self.momenta[0];
        for (p, l) in &self.momenta {
            assert!((p - linear).norm() <= share * linear.norm(), "linear momentum: {p}");
            assert!((l - angular).norm() <= share * angular.norm(), "angular momentum: {l}");
        }
    }

    /// Largest difference of the total energy from its first value.
    pub fn drift(&self) -> f64 {
        let first = self.totals.first().map_or(0.0, |t| t.1);
        max_norm(self.totals.iter().map(|t| t.1 - first))
    }
}

impl Observer for Notes {
    fn on_step(&mut self, step: &Step) -> tegula::Result<()> {
        let b = step.balance;
        self.totals.push((step.state.time, b.total));
        self.kinetic = larger(self.kinetic, b.kinetic);
        self.momenta.push((Vec3::from(b.momentum), Vec3::from(b.angular_momentum)));
        self.iterations.push(step.iterations);
        if self.keep {
            self.states.push(step.state.clone());
        }
        Ok(())
    }

    fn on_event(&mut self, message: &str) {
        self.events.push(message.to_string());
    }

    fn on_warning(&mut self, message: &str) {
        self.warnings.push(message.to_string());
        self.on_event(message);
    }
}

/// The direct solver, to which a new tangent has no price: an old one never serves.
pub struct Fresh(pub Direct);

impl TangentSolver for Fresh {
    fn assemble(&mut self, assembly: &mut Assembly, at: &Linearization, out: &mut [Nodal]) {
        self.0.assemble(assembly, at, out);
    }

    fn add_curvature(&mut self, assembly: &mut Assembly, at: &Linearization, rest: &[Nodal]) {
        self.0.add_curvature(assembly, at, rest);
    }

    fn prepare(&mut self, assembly: &mut Assembly) -> Result<Option<usize>, String> {
        self.0.prepare(assembly)
    }

    fn solve_tangent(&mut self, x: &mut [f64]) -> Result<(), String> {
        self.0.solve_tangent(x)
    }

    fn tangents(&self) -> usize {
        self.0.tangents()
    }
}
