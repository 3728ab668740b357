//! Problems with known linear deflections.

use std::f64::consts::PI;

use tegula::analysis::{Silent, statics};
use tegula::compile::build;
use tegula::mesh::generators::generate;
use tegula::model::{
    Analysis, Condition, CylinderMesh, Grid, Isotropic, Load, MeshSource, Model, OnSet, PlateMesh, Section,
    StaticAnalysis, VectorLoad,
};
use tegula::{Error, Result};

/// Converged corner deflections of the square cantilever plate by slenderness: Reissner–Mindlin plate by a p-version
/// of order 8, k = 5/6, for L = W = 1, E = 2.1e11, ν = 0.3 and the edge load 5e7 H³ (`verification/reference/plate_converged.csv`).
const PLATE: [(u32, f64); 3] = [(10, 8.939657115e-4), (100, 8.813196873e-4), (1000, 8.808953740e-4)];

/// A problem that calls for one or more remedies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Example {
    /// Square cantilever plate with a line load, ν = 0.3: transverse shear, Poisson's ratio over the thickness.
    Plate,
    /// Quarter circle clamped at one end with a load at the other, ν = 0: curvature and thickness.
    Arch,
    /// Straight cantilever bent in its own plane, ν = 0, one element deep: bending in the plane.
    Beam,
}

impl Example {
    /// All of them.
    pub const EVERY: [Self; 3] = [Self::Plate, Self::Arch, Self::Beam];

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Plate => "plate",
            Self::Arch => "arch",
            Self::Beam => "beam",
        }
    }

    /// Title for tables and pictures.
    pub fn title(self) -> &'static str {
        match self {
            Self::Plate => "cantilever plate",
            Self::Arch => "quarter arch",
            Self::Beam => "beam in its plane",
        }
    }

    /// Definition of the slenderness.
    pub fn slenderness(self) -> &'static str {
        match self {
            Self::Plate => "L/h",
            Self::Arch => "R/h",
            Self::Beam => "L/depth",
        }
    }

    /// Values of the slenderness for which the exact deflection is known; none: all.
    pub fn known(self) -> Option<Vec<u32>> {
        (self == Self::Plate).then(|| PLATE.iter().map(|p| p.0).collect())
    }

    /// Elements of the mesh `n`.
    pub fn elements(self, n: u32) -> [u32; 2] {
        if self == Self::Plate { [n, n] } else { [n, 1] }
    }

    /// Deflection over the exact one, with a section changed as wanted.
    pub(super) fn ratio(self, slenderness: u32, n: u32, change: &dyn Fn(&mut Section)) -> Result<f64> {
        let s = f64::from(slenderness);
        let young = 2.1e11;
        let (mesh, nu, h, load, exact) = match self {
            Self::Plate => {
                let exact = PLATE.iter().find(|p| p.0 == slenderness).map(|p| p.1).ok_or_else(|| {
                    Error::Outside(format!(
                        "the plate has no converged value for the slenderness {slenderness}"
                    ))
                })?;
                (flat([1.0, 1.0], self.elements(n)), 0.3, 1.0 / s, [0.0, 0.0, -5e7 / s.powi(3)], -exact)
            }
            Self::Arch => {
                // Castigliano: bending, extension, shear with k = 5/6, E/G = 2. Load along the tangent of the clamped end.
                let h = 1.0 / s;
                let force = 1e7 * h.powi(3);
                let exact = PI * force / (4.0 * young) * (12.0 / h.powi(3) + 1.0 / h + 2.0 * 1.2 / h);
                let mesh = MeshSource::Cylinder(CylinderMesh {
                    center: [0.0; 3],
                    axis: [0.0, 1.0, 0.0],
                    start: [1.0, 0.0, 0.0],
                    radius: 1.0,
                    angles: [0.0, 90.0],
                    length: 0.25,
                    grid: Grid::uniform(n, 1),
                });
                (mesh, 0.0, h, [0.0, 0.0, -force], -exact)
            }
            Self::Beam => {
                // Bending and shear with k = 5/6 of the depth; the thickness cancels.
                let depth = 1.0 / s;
                let force = 1e7 * depth.powi(3);
                let exact = force / young * (4.0 / depth.powi(3) + 2.0 * 1.2 / depth);
                let line = [0.0, force / depth, 0.0];
                let mesh = flat([1.0, depth], self.elements(n));
                // A line load acts on the whole thickness, which is 1/10 of the depth.
                return deflection(mesh, 0.0, 0.1 * depth, line.map(|f| f * 0.1 * depth), 1, change)
                    .map(|v| v / exact);
            }
        };
        deflection(mesh, nu, h, load, 2, change).map(|v| v / exact)
    }
}

fn flat(size: [f64; 2], elements: [u32; 2]) -> MeshSource {
    MeshSource::Plate(PlateMesh {
        origin: [0.0; 3],
        u_axis: [1.0, 0.0, 0.0],
        v_axis: [0.0, 1.0, 0.0],
        size,
        grid: Grid::uniform(elements[0], elements[1]),
    })
}

/// Linear deflection of the corner of the loaded edge.
fn deflection(
    source: MeshSource,
    nu: f64,
    h: f64,
    load: [f64; 3],
    along: usize,
    change: &dyn Fn(&mut Section),
) -> Result<f64> {
    let options = StaticAnalysis { linear: true, ..StaticAnalysis::default() };
    let analysis = Analysis::Static(options.clone());
    let mut model = Model::new(source, analysis, Isotropic::new(2.1e11, nu, 1.0), h);
    model.sections.iter_mut().for_each(change);
    model.conditions = vec![Condition::Clamp(OnSet { on: "u_min".into() })];
    model.loads =
        vec![Load::Edge(VectorLoad { on: "u_max".into(), value: load, amplitude: None, distribution: None })];
    let mesh = generate(&model.mesh)?;
    let system = build(&model, &mesh)?;
    let outcome = statics::run(&system, &options, None, &mut Silent)?;
    let tip = mesh.nodes_on("u_max_v_min").and_then(|n| n.first().copied()).unwrap_or(0);
    Ok(outcome.state.u[system.coordinates.position_of[tip as usize] as usize][along])
}
