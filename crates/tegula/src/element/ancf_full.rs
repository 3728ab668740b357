//! The fully parameterized plate of the absolute nodal coordinate formulation: 48 coordinates.
//!
//! A. M. Mikkola, A. A. Shabana, *A non-incremental finite element procedure for the analysis of large deformation of
//! plates and shells in mechanical system applications*, Multibody Syst. Dyn. 9 (2003) 283–309. A node has its position
//! and three gradients `r,x r,y r,z`; the mid-surface is an incomplete bicubic (12 shape functions), the gradient along
//! the thickness bilinear. Strains and stresses are three-dimensional with full integration (5×5×2) and without any
//! remedy: the element locks, in thickness and in transverse shear, and serves for comparison.
//!
//! Nodes share the gradients along two unit tangents of the surface; an element transforms them to derivatives with
//! respect to its natural coordinates ([`NodalTransform`]), so any quadrilateral mesh works. Each integration point has
//! six sampled strains and is an element group of its own.

use nalgebra::DMatrix;

use super::VectorKind;
use super::geometry::{NODES, ShellGeometry, cross_section_frame, shape, strain_transformation};
use super::group::ElementGroup;
use super::registry::FromSection;
use super::shell::{
    GroupBuilder, GroupSetup, IntegrationPoint, Member, QuadraticBuilder, ShellElement, StrainOperator,
};
use super::strains::SampledStrains;
use super::transform::NodalTransform;
use crate::model::Section;
use crate::section::SectionInertia;
use crate::{Mat3, Vec3};

/// Number of nodal vectors: positions of nodes 1–4, directors, first and second tangential gradients.
const VECTORS: usize = 16;
/// Number of sampled strains of one integration point.
const SAMPLES: usize = 6;
/// Number of integration points over the thickness.
const HEIGHTS: usize = 2;
/// Abscissae and weights of the five-point Gauss rule.
const RULE: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (0.906_179_845_938_664, 0.236_926_885_056_189_1),
];
/// Number of integration points over the mid-surface.
const POINTS: usize = RULE.len() * RULE.len();

/// Fully parameterized ANCF plate element.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AncfFull {
    /// Thickness h (length).
    pub thickness: f64,
}

/// Shape functions of the mid-surface for r, r,ξ and r,η of each node: values and derivatives by ξ and η.
struct Bicubic {
    value: [[f64; 3]; 4],
    xi: [[f64; 3]; 4],
    eta: [[f64; 3]; 4],
}

impl Bicubic {
    fn at(xi: f64, eta: f64) -> Self {
        let mut out = Self { value: [[0.0; 3]; 4], xi: [[0.0; 3]; 4], eta: [[0.0; 3]; 4] };
        for (a, [x, y]) in NODES.into_iter().enumerate() {
            let (p, q) = (x * xi, y * eta);
            let (p1, q1) = (1.0 + p, 1.0 + q);
            let bulge = 2.0 + p + q - xi * xi - eta * eta;
            out.value[a] = [p1 * q1 * bulge, x * p1 * p1 * (p - 1.0) * q1, y * q1 * q1 * (q - 1.0) * p1]
                .map(|v| 0.125 * v);
            out.xi[a] = [
                x * q1 * bulge + p1 * q1 * (x - 2.0 * xi),
                p1 * (3.0 * p - 1.0) * q1,
                x * y * q1 * q1 * (q - 1.0),
            ]
            .map(|v| 0.125 * v);
            out.eta[a] = [
                y * p1 * bulge + p1 * q1 * (y - 2.0 * eta),
                x * y * p1 * p1 * (p - 1.0),
                q1 * (3.0 * q - 1.0) * p1,
            ]
            .map(|v| 0.125 * v);
        }
        out
    }
}

/// Bilinear shape functions and their derivatives by ξ and η.
fn bilinear(xi: f64, eta: f64) -> [[f64; 4]; 3] {
    [shape(xi, eta), super::geometry::shape_xi(eta), super::geometry::shape_eta(xi)]
}

/// Coefficients of a base vector: shape functions of the mid-surface, and `z` times those of the director.
fn coefficients(surface: &[[f64; 3]; 4], director: &[f64; 4], z: f64) -> [f64; VECTORS] {
    std::array::from_fn(|v| {
        let a = v % 4;
        match v / 4 {
            0 => surface[a][0],
            1 => z * director[a],
            2 => surface[a][1],
            _ => surface[a][2],
        }
    })
}

impl AncfFull {
    fn heights(&self) -> [f64; HEIGHTS] {
        [-0.5, 0.5].map(|s| s * self.thickness * super::geometry::GAUSS)
    }

    fn natural(point: usize) -> ([f64; 2], f64) {
        let ((xi, w), (eta, v)) = (RULE[point % 5], RULE[point / 5]);
        ([xi, eta], w * v)
    }

    /// Coefficients of the base vectors ∂x/∂ξ, ∂x/∂η, ∂x/∂z.
    fn directions([xi, eta]: [f64; 2], z: f64) -> [[f64; VECTORS]; 3] {
        let (surface, [n, n_xi, n_eta]) = (Bicubic::at(xi, eta), bilinear(xi, eta));
        [
            coefficients(&surface.xi, &n_xi, z),
            coefficients(&surface.eta, &n_eta, z),
            coefficients(&[[0.0; 3]; 4], &n, 1.0),
        ]
    }

    fn strains(natural: [f64; 2], z: f64) -> SampledStrains<VECTORS, 48, SAMPLES, 3> {
        let mut t = SampledStrains::new();
        let [x, y, d] = Self::directions(natural, z).map(|c| t.direction(c));
        for (sample, weight, left, right) in
            [(0, 0.5, x, x), (1, 0.5, y, y), (2, 1.0, x, y), (3, 0.5, d, d), (4, 1.0, x, d), (5, 1.0, y, d)]
        {
            t.product(sample, weight, left, right);
        }
        t
    }

    /// Natural derivatives at the nodes from gradients along unit tangents: along an edge the position advances by half
    /// the length of the edge, in the direction of its projection on the tangent plane.
    fn transform(g: &ShellGeometry) -> NodalTransform<VECTORS> {
        let mut t = Box::new([[0.0; VECTORS]; VECTORS]);
        for v in 0..8 {
            t[v][v] = 1.0;
        }
        let edge = |a: usize, b: usize| (g.positions[b] - g.positions[a]) * 0.5;
        let along = [
            [edge(0, 1), edge(0, 3)],
            [edge(0, 1), edge(1, 2)],
            [edge(3, 2), edge(1, 2)],
            [edge(3, 2), edge(0, 3)],
        ];
        for (a, [xi, eta]) in along.into_iter().enumerate() {
            for (row, tangent) in [(8 + a, xi), (12 + a, eta)] {
                let parts = g.tangents[a].map(|t| t.dot(&tangent));
                let size = parts[0].hypot(parts[1]);
                let factor = if size > 0.0 { tangent.norm() / size } else { 0.0 };
                t[row][8 + a] = factor * parts[0];
                t[row][12 + a] = factor * parts[1];
            }
        }
        NodalTransform(t)
    }

    /// Nodal vectors of the element type in the reference configuration.
    fn reference(g: &ShellGeometry) -> [[f64; 3]; VECTORS] {
        let model = std::array::from_fn(|v| {
            let a = v % 4;
            let value: Vec3 = match v / 4 {
                0 => g.positions[a],
                1 => g.directors[a],
                2 => g.tangents[a][0],
                _ => g.tangents[a][1],
            };
            value.into()
        });
        Self::transform(g).apply(&model)
    }

    fn base(g: &ShellGeometry, natural: [f64; 2], z: f64) -> Mat3 {
        let v = Self::reference(g);
        let columns = Self::directions(natural, z)
            .map(|c| c.iter().zip(&v).map(|(c, v)| Vec3::from(*v) * *c).sum::<Vec3>());
        Mat3::from_columns(&columns)
    }
}

impl FromSection for AncfFull {
    fn from_section(_: &Section, thickness: f64, _: bool) -> Self {
        Self { thickness }
    }
}

impl ShellElement for AncfFull {
    fn name(&self) -> &'static str {
        "ancf-full"
    }

    fn samples(&self) -> usize {
        POINTS * HEIGHTS * SAMPLES
    }

    fn parameters(&self) -> usize {
        0
    }

    fn is_solid(&self) -> bool {
        true
    }

    /// True: the sampled strains belong to two fixed heights.
    fn takes_linear_sheets_only(&self) -> bool {
        true
    }

    fn nodal_vectors(&self) -> &'static [VectorKind] {
        &[VectorKind::Position, VectorKind::Director, VectorKind::Gradient, VectorKind::Gradient]
    }

    fn surface_points(&self) -> usize {
        POINTS
    }

    /// Between the two heights of the integration rule strains are interpolated linearly.
    fn operator(&self, g: &ShellGeometry, point: usize, z: f64) -> Result<StrainOperator, String> {
        let (natural, weight) = Self::natural(point);
        let base = Self::base(g, natural, z);
        let frame = cross_section_frame(&base)
            .ok_or("its director lies in the surface or vanishes: no cross-section frame")?;
        let measure = base.determinant().abs();
        let inverse = (frame.transpose() * base)
            .try_inverse()
            .filter(|b| measure > 0.0 && b.iter().all(|x| x.is_finite()))
            .ok_or("it is collapsed: its volume vanishes at an integration point")?;
        let [low, high] = self.heights();
        let share = (z - low) / (high - low);
        let t = strain_transformation(&inverse);
        let mut samples = DMatrix::zeros(6, self.samples());
        for (height, factor) in [1.0 - share, share].into_iter().enumerate() {
            let first = (point * HEIGHTS + height) * SAMPLES;
            for i in 0..6 {
                for j in 0..6 {
                    samples[(i, first + j)] = factor * t[(i, j)];
                }
            }
        }
        Ok(StrainOperator { samples, enhanced: DMatrix::zeros(6, 0), frame, measure: weight * measure })
    }

    fn mass(&self, g: &ShellGeometry, inertia: &SectionInertia) -> Vec<f64> {
        let transform = Self::transform(g).0;
        let mut natural = DMatrix::<f64>::zeros(VECTORS, VECTORS);
        for point in 0..POINTS {
            let (at, weight) = Self::natural(point);
            let base = Self::base(g, at, 0.0);
            let area = base.column(0).cross(&base.column(1)).norm() * weight;
            let (surface, n) = (Bicubic::at(at[0], at[1]), shape(at[0], at[1]));
            let position = coefficients(&surface.value, &[0.0; 4], 0.0);
            let director = coefficients(&[[0.0; 3]; 4], &n, 1.0);
            for a in 0..VECTORS {
                for b in 0..VECTORS {
                    natural[(a, b)] += area
                        * (inertia.mass * position[a] * position[b]
                            + inertia.rotary * director[a] * director[b]
                            + inertia.coupling * (position[a] * director[b] + director[a] * position[b]));
                }
            }
        }
        let t = DMatrix::from_fn(VECTORS, VECTORS, |i, j| transform[i][j]);
        let m = t.transpose() * natural * t;
        (0..VECTORS).flat_map(|a| (0..=a).map(move |b| (a, b))).map(|(a, b)| m[(a, b)]).collect()
    }

    fn builder(&self, setup: GroupSetup) -> Box<dyn GroupBuilder> {
        let heights = self.heights();
        let points = (0..POINTS * HEIGHTS)
            .map(|k| {
                let strains = Self::strains(Self::natural(k / HEIGHTS).0, heights[k % HEIGHTS]);
                QuadraticBuilder::new("ancf-full", strains, 0, setup.clone())
            })
            .collect();
        Box::new(Builder { points })
    }
}

/// One builder per integration point.
struct Builder {
    points: Vec<QuadraticBuilder<VECTORS, 48, SAMPLES, 3>>,
}

impl GroupBuilder for Builder {
    fn push(&mut self, member: Member) -> Result<(), String> {
        let no_mass = vec![0.0; member.mass.len()];
        let transform = AncfFull::transform(member.geometry);
        for (k, (builder, integration_point)) in
            self.points.iter_mut().zip(member.integration_points).enumerate()
        {
            let samples = integration_point.samples.columns(k * SAMPLES, SAMPLES).into_owned();
            builder.push_transform(transform.clone());
            builder.push(Member {
                vectors: member.vectors,
                geometry: member.geometry,
                integration_points: vec![IntegrationPoint { samples, ..integration_point }],
                mass: if k == 0 { member.mass.clone() } else { no_mass.clone() },
            })?;
        }
        Ok(())
    }

    fn finish(self: Box<Self>) -> Vec<Box<dyn ElementGroup>> {
        self.points.into_iter().flat_map(|b| Box::new(b).finish()).collect()
    }
}
