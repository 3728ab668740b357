//! The shear-deformable bilinear shell of the absolute nodal coordinate formulation with elastic middle surface ("ANCF
//! EMS shell"), with assumed natural strains (ANS) and enhanced assumed strains (EAS).
//!
//! A. I. Valkeapää, H. Yamashita, P. Jayakumar, H. Sugiyama: *On the use of elastic
//! middle surface approach in the large deformation analysis of moderately thick
//! shell structures using absolute nodal coordinate formulation*, Nonlinear Dynamics
//! 80 (2015) 1133–1146. Equation numbers are the paper's.
//!
//! | paper | here | is |
//! |---|---|---|
//! | r_m, ∂r/∂z | `positions`, `directors` | nodal vectors, bilinear over the element (eq. 3) |
//! | J = \[G1 G2 G3\] | `base` | covariant base of the reference (eq. 10) |
//! | A | `frame` | cross-section frame (eqs. 17–19) |
//! | B = AᵀJ, C | `b`, `c` | base in the frame; its in-plane 2×2 block (eqs. 14, 20) |
//! | ε̃, κ̃ | samples | covariant strains and curvatures (eqs. 12, 22) |
//! | G(ξ) α | `enhanced` | enhanced assumed strain (eqs. 28–31) |
//!
//! Because the interpolation is bilinear, few sampling points determine all strains (g = 1/√3):
//!
//! | strain | sampled at | count | form |
//! |---|---|---|---|
//! | ε̃xx, κ̃xx | η = ±g | 2 + 2 | ½ r,ξ·r,ξ and −d,ξ·r,ξ |
//! | ε̃yy, κ̃yy | ξ = ±g | 2 + 2 | ½ r,η·r,η and −d,η·r,η |
//! | 2ε̃xy, 2κ̃xy | Gauss points | 4 + 4 | r,ξ·r,η and −(d,ξ·r,η + d,η·r,ξ) |
//! | ε̃zz | nodes (ANS, eq. 34) | 4 | ½ d·d |
//! | 2ε̃xz | C(0,−1), D(0,1) (ANS, eq. 33) | 2 | r,ξ·d |
//! | 2ε̃yz | A(−1,0), B(1,0) | 2 | r,η·d |
//!
//! The strains are those of the middle surface of the layers, and the paper's nodes lie on it. Where it lies at the height
//! e above the nodes ([`EmsShell::offset`]), its positions are `r + e d`, bilinear, too: all of the above is taken for them,
//! so that the result does not depend on the surface that the mesh describes. A strain linear in z about the nodes would:
//! the part `½ z² d,i·d,j` of the Green–Lagrange strain, which it leaves out, is large wherever e is long compared with a
//! radius of curvature, however small the strains of the shell are.
//!
//! With a linear material the energy is `½ sᵀ H s`. The condition on the enhanced parameters (eq. 36) is linear in α
//! with constant matrices, so static condensation eliminates α once, `H ← H − K_αsᵀ K_αα⁻¹ K_αs`, without iterations
//! and stored parameters.
//!
//! Where the paper leaves a choice:
//! * G (eq. 29) is built in the frame of the Gauss point from the base of the centre,
//!   `B₀ = A(gp)ᵀ J(centre)`: the same tensor at every point. Components added across
//!   frames, as eqs. 29–30 read, break the membrane patch test on distorted elements.
//! * |J| in eq. 29 is the measure of the integration, dA₀ = |G1×G2| dξdη, so that ∫G dA₀ = 0.
//! * k lies along G3, which on coarse curved meshes is not normal to the facet; the
//!   full 6×6 transformation is used.
//! * The thickness strain has modulus E and no Poisson coupling (eq. 24).

use nalgebra::{DMatrix, Matrix2, SMatrix, Vector2};

use super::curved_strain::ReferenceMetric;
use super::geometry::{
    GAUSS, GAUSS_POINTS, ShellGeometry, area_measure, covariant_base, cross_section_frame,
    in_plane_transformation, shape, shape_eta, shape_xi, shell_mass, strain_transformation, stretch_gradient,
};
use super::membrane::{HourglassWeights, InPlaneSamples, Membrane, ShearPoint, assumed_shear};
use super::registry::FromSection;
use super::shell::{GroupBuilder, GroupSetup, QuadraticBuilder, ShellElement, StrainOperator};
use super::strains::SampledStrains;
use crate::Mat3;
use crate::model::Section;
use crate::section::SectionInertia;

/// Number of nodal vectors: positions of nodes 1–4, then their directors.
pub const VECTORS: usize = 8;
/// Number of coordinates of an element.
pub const COORDINATES: usize = 24;
/// Number of sampled strains with assumed natural transverse shear.
pub const SAMPLES: usize = 24;
/// Number of sampled strains without assumed natural transverse shear, which is then sampled at the Gauss points.
pub const SAMPLES_WITHOUT_ANS_SHEAR: usize = 28;

/// Largest number of base vectors.
pub const DIRECTIONS: usize = 20;

const KXX: usize = 8;
const KYY: usize = 10;
const KXY: usize = 12;
const SHEAR: usize = 16;

/// ANCF EMS shell with its locking remedies, each of which can be switched off to show the locking that it cures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EmsShell {
    /// Assumed natural strain for transverse shear (eq. 33).
    pub ans_shear: bool,
    /// Assumed natural strain for the thickness (eq. 34).
    pub ans_thickness: bool,
    /// Membrane formulation; the paper's is [`Membrane::Eas`], 4 parameters (eqs. 27–31).
    pub membrane: Membrane,
    /// e: height of the middle of the layers above the nodes, along the directors (length); 0 in the paper.
    pub offset: f64,
}

impl Default for EmsShell {
    fn default() -> Self {
        Self { ans_shear: true, ans_thickness: true, membrane: Membrane::Eas, offset: 0.0 }
    }
}

/// Strain operator at a Gauss point: strains from sampled strains and enhanced parameters.
#[derive(Debug, Clone)]
pub struct PointStrains {
    /// Rows ε_xx, ε_yy, 2ε_xy, ε_zz, 2ε_xz, 2ε_yz, κ_xx, κ_yy, 2κ_xy in the cross-section frame; columns are the
    /// sampled strains.
    pub matrix: SMatrix<f64, 9, SAMPLES_WITHOUT_ANS_SHEAR>,
    /// Coefficients of the enhanced parameters in ε_xx, ε_yy, 2ε_xy (eq. 29).
    pub enhanced: SMatrix<f64, 3, 4>,
    /// Gradient of ε_zz along the axes i and j of the frame, from the sampled strains.
    pub stretch_gradient: SMatrix<f64, 2, SAMPLES_WITHOUT_ANS_SHEAR>,
    /// Cross-section frame.
    pub frame: Mat3,
    /// Reference area that the point stands for.
    pub area: f64,
}

/// Covariant strains and curvatures from the sampled strains.
type CovariantStrains = SMatrix<f64, 6, SAMPLES_WITHOUT_ANS_SHEAR>;
type CovariantCurvatures = SMatrix<f64, 3, SAMPLES_WITHOUT_ANS_SHEAR>;

impl EmsShell {
    /// Index of the first sampled thickness strain; these come last.
    fn zz(&self) -> usize {
        if self.ans_shear { SHEAR + 4 } else { SHEAR + 8 }
    }

    /// Table of the sampled strains; `S` is their number, or 4 less to leave out the thickness strains.
    pub fn strains<const S: usize>(&self) -> SampledStrains<VECTORS, COORDINATES, S, DIRECTIONS> {
        let mut t = SampledStrains::new();
        let position =
            |n: [f64; 4]| std::array::from_fn(|a| if a < 4 { n[a] } else { self.offset * n[a - 4] });
        let director = |n: [f64; 4]| std::array::from_fn(|a| if a < 4 { 0.0 } else { n[a - 4] });
        let r_xi = [-GAUSS, GAUSS].map(|eta| t.direction(position(shape_xi(eta))));
        let r_eta = [-GAUSS, GAUSS].map(|xi| t.direction(position(shape_eta(xi))));
        let d_xi = [-GAUSS, GAUSS].map(|eta| t.direction(director(shape_xi(eta))));
        let d_eta = [-GAUSS, GAUSS].map(|xi| t.direction(director(shape_eta(xi))));
        for i in 0..2 {
            t.product(i, 0.5, r_xi[i], r_xi[i]);
            t.product(2 + i, 0.5, r_eta[i], r_eta[i]);
            t.product(KXX + i, -1.0, d_xi[i], r_xi[i]);
            t.product(KYY + i, -1.0, d_eta[i], r_eta[i]);
        }
        for p in 0..4 {
            let (xi, eta) = (p % 2, p / 2);
            t.product(4 + p, 1.0, r_xi[eta], r_eta[xi]);
            t.product(KXY + p, -1.0, d_xi[eta], r_eta[xi]);
            t.product(KXY + p, -1.0, d_eta[xi], r_xi[eta]);
        }
        let at_gauss: [usize; 4] = if self.ans_shear && self.ans_thickness {
            [0; 4]
        } else {
            GAUSS_POINTS.map(|[xi, eta]| t.direction(director(shape(xi, eta))))
        };
        let thickness = if self.ans_thickness {
            super::geometry::NODES.map(|[xi, eta]| t.direction(director(shape(xi, eta))))
        } else {
            at_gauss
        };
        if S > self.zz() {
            for (a, d) in thickness.into_iter().enumerate() {
                t.product(self.zz() + a, 0.5, d, d);
            }
        }
        if self.ans_shear {
            for (i, side) in [-1.0, 1.0].into_iter().enumerate() {
                let tangent = t.direction(position(shape_xi(side)));
                let normal = t.direction(director(shape(0.0, side)));
                t.product(SHEAR + i, 1.0, tangent, normal);
                let tangent = t.direction(position(shape_eta(side)));
                let normal = t.direction(director(shape(side, 0.0)));
                t.product(SHEAR + 2 + i, 1.0, tangent, normal);
            }
        } else {
            for p in 0..4 {
                t.product(SHEAR + p, 1.0, r_xi[p / 2], at_gauss[p]);
                t.product(SHEAR + 4 + p, 1.0, r_eta[p % 2], at_gauss[p]);
            }
        }
        t
    }

    /// Sampled products of the reference, of which the sampled strains are the changes.
    fn products<const S: usize>(&self, g: &ShellGeometry) -> Vec<f64> {
        let t = self.strains::<S>();
        let centre = g.centre();
        let vectors = std::array::from_fn(|a| {
            if a < 4 { (g.positions[a] - centre).into() } else { g.directors[a - 4].into() }
        });
        t.strains(&[[0.0; 3]; DIRECTIONS], &t.directions(&vectors), true).to_vec()
    }

    /// Element with its nodes on the middle surface of the layers.
    fn on_middle(&self, g: &ShellGeometry) -> ShellGeometry {
        let mut g = *g;
        for (x, d) in g.positions.iter_mut().zip(&g.directors) {
            *x += d * self.offset;
        }
        g
    }

    /// Strain operator at a Gauss point, from sampled strains and enhanced parameters.
    ///
    /// # Errors
    /// The cross-section frame is not defined there: collapsed element or director in the surface. The layers lie beyond
    /// the centre of curvature of the surface.
    pub fn point_strains(&self, g: &ShellGeometry, point: usize) -> Result<PointStrains, String> {
        let [xi, eta] = GAUSS_POINTS[point];
        let middle = self.on_middle(g);
        let base = covariant_base(&middle.positions, &middle.directors, xi, eta);
        if self.offset != 0.0 {
            let of_nodes = covariant_base(&g.positions, &g.directors, xi, eta);
            if base.determinant() * of_nodes.determinant() <= 0.0 {
                return Err(format!(
                    "the middle of its layers, at the offset {}, lies beyond the centre of curvature of the mesh",
                    self.offset
                ));
            }
        }
        let g = &middle;
        let frame = cross_section_frame(&base)
            .ok_or("its director lies in the surface or vanishes: no cross-section frame")?;
        let b = frame.transpose() * base;
        let c: Matrix2<f64> = b.fixed_view::<2, 2>(0, 0).into();
        let area = area_measure(&base);
        let (b_inverse, c_inverse) = b
            .try_inverse()
            .zip(c.try_inverse())
            .filter(|(b, _)| area > 0.0 && b.iter().all(|x| x.is_finite()))
            .ok_or("it is collapsed: its area vanishes at an integration point")?;

        let (covariant, curvature) = self.covariant_strains(g, point);
        let mut matrix = SMatrix::<f64, 9, SAMPLES_WITHOUT_ANS_SHEAR>::zeros();
        matrix
            .fixed_view_mut::<6, SAMPLES_WITHOUT_ANS_SHEAR>(0, 0)
            .copy_from(&(strain_transformation(&b_inverse) * covariant));
        matrix
            .fixed_view_mut::<3, SAMPLES_WITHOUT_ANS_SHEAR>(6, 0)
            .copy_from(&(in_plane_transformation(&c_inverse) * curvature));

        let centre = covariant_base(&g.positions, &g.directors, 0.0, 0.0);
        let b0 = frame.transpose() * centre;
        let c0: Matrix2<f64> = b0.fixed_view::<2, 2>(0, 0).into();
        let c0_inverse = c0.try_inverse().ok_or("it is collapsed at its centre")?;
        let polynomials = SMatrix::<f64, 3, 4>::new(
            xi, 0.0, 0.0, 0.0, //
            0.0, eta, 0.0, 0.0, //
            0.0, 0.0, xi, eta,
        );
        let enhanced = in_plane_transformation(&c0_inverse) * polynomials * (area_measure(&centre) / area);
        let mut strains = PointStrains { matrix, enhanced, stretch_gradient: SMatrix::zeros(), frame, area };
        if self.ans_thickness {
            let along = c_inverse.transpose();
            for (a, gradient) in stretch_gradient(xi, eta).into_iter().enumerate() {
                let physical = along * Vector2::from(gradient);
                strains.stretch_gradient.set_column(self.zz() + a, &physical);
            }
        }
        Ok(strains)
    }

    /// Interpolation of the covariant strains ε̃xx, ε̃yy, 2ε̃xy, ε̃zz, 2ε̃xz, 2ε̃yz and curvatures κ̃xx, κ̃yy, 2κ̃xy at a Gauss point from the sampled
    /// strains (eqs. 33, 34), for an element with its nodes on the middle surface of the layers.
    fn covariant_strains(&self, g: &ShellGeometry, point: usize) -> (CovariantStrains, CovariantCurvatures) {
        let [xi, eta] = GAUSS_POINTS[point];
        let (i_xi, i_eta) = (point % 2, point / 2);
        let mut covariant = CovariantStrains::zeros();
        covariant[(0, i_eta)] = 1.0;
        covariant[(1, 2 + i_xi)] = 1.0;
        covariant[(2, 4 + point)] = 1.0;
        if self.ans_thickness {
            for (a, n) in shape(xi, eta).into_iter().enumerate() {
                covariant[(3, self.zz() + a)] = n;
            }
        } else {
            covariant[(3, self.zz() + point)] = 1.0;
        }
        if self.ans_shear {
            for (i, side) in [-1.0, 1.0].into_iter().enumerate() {
                covariant[(4, SHEAR + i)] = 0.5 * (1.0 + side * eta);
                covariant[(5, SHEAR + 2 + i)] = 0.5 * (1.0 + side * xi);
            }
        } else {
            covariant[(4, SHEAR + point)] = 1.0;
            covariant[(5, SHEAR + 4 + point)] = 1.0;
        }
        let mut curvature = CovariantCurvatures::zeros();
        curvature[(0, KXX + i_eta)] = 1.0;
        curvature[(1, KYY + i_xi)] = 1.0;
        curvature[(2, KXY + point)] = 1.0;

        if let Some(hourglass) = HourglassWeights::of(self.membrane, g) {
            let membrane = InPlaneSamples { xx: 0, yy: 2, xy: 4 };
            hourglass.apply(membrane, 0, point, 0, &mut |row, sample, value| {
                covariant[(row, sample)] += value;
            });
            let bending = InPlaneSamples { xx: KXX, yy: KYY, xy: KXY };
            hourglass.apply(bending, 1, point, 0, &mut |row, sample, value| {
                curvature[(row, sample)] += value;
            });
        }
        (covariant, curvature)
    }

    /// Amplitudes of the enhanced shear modes that the assumed shear projects out, from the sampled strains.
    fn assumed_shear(&self, g: &ShellGeometry) -> Result<DMatrix<f64>, String> {
        let points = (0..4)
            .map(|point| {
                let p = self.point_strains(g, point)?;
                Ok(ShearPoint {
                    strain: DMatrix::from_fn(3, self.samples(), |i, j| p.matrix[(i, j)]),
                    shear: DMatrix::from_fn(3, 2, |i, j| p.enhanced[(i, 2 + j)]),
                    measure: p.area,
                })
            })
            .collect::<Result<Vec<_>, String>>()?;
        assumed_shear(&self.on_middle(g), &points)
            .ok_or_else(|| "its in-plane shear strains are not independent".into())
    }
}

impl FromSection for EmsShell {
    fn from_section(section: &Section, _: f64, _: bool) -> Self {
        let Section { ans_shear, ans_thickness, .. } = *section;
        Self { ans_shear, ans_thickness, membrane: section.membrane_part(), offset: section.offset() }
    }
}

impl ShellElement for EmsShell {
    fn name(&self) -> &'static str {
        "ems"
    }

    fn samples(&self) -> usize {
        if self.ans_shear { SAMPLES } else { SAMPLES_WITHOUT_ANS_SHEAR }
    }

    fn parameters(&self) -> usize {
        self.membrane.parameters()
    }

    fn without_enhanced_strains(&self) -> Option<Box<dyn ShellElement>> {
        (self.membrane.parameters() > 0).then(|| -> Box<dyn ShellElement> {
            Box::new(Self { membrane: Membrane::Displacement, ..*self })
        })
    }

    fn is_solid(&self) -> bool {
        false
    }

    /// A fibre at the height z stretches by ε − (z − e) κ; transverse strains are those of the mid-surface.
    fn operator(&self, g: &ShellGeometry, point: usize, z: f64) -> Result<StrainOperator, String> {
        let p = self.point_strains(g, point)?;
        let mut samples = DMatrix::zeros(6, self.samples());
        for j in 0..self.samples() {
            for i in 0..6 {
                let bent = if i < 3 { (z - self.offset) * p.matrix[(6 + i, j)] } else { 0.0 };
                samples[(i, j)] = p.matrix[(i, j)] - bent;
            }
        }
        if self.membrane == Membrane::AssumedShear {
            let taken_off = DMatrix::from_fn(3, 2, |i, j| p.enhanced[(i, 2 + j)]) * self.assumed_shear(g)?;
            let mut in_plane = samples.rows_mut(0, 3);
            in_plane += taken_off;
        }
        let mut enhanced = DMatrix::zeros(6, self.parameters());
        for j in 0..self.parameters() {
            for i in 0..3 {
                enhanced[(i, j)] = p.enhanced[(i, j)];
            }
        }
        Ok(StrainOperator { samples, enhanced, frame: p.frame, measure: p.area })
    }

    fn stretch_gradient(&self, g: &ShellGeometry, point: usize) -> Option<DMatrix<f64>> {
        let gradient = self.point_strains(g, point).ok()?.stretch_gradient;
        self.ans_thickness.then(|| DMatrix::from_fn(2, self.samples(), |i, j| gradient[(i, j)]))
    }

    fn reference_metric(&self, g: &ShellGeometry, point: usize) -> Result<Option<ReferenceMetric>, String> {
        let products = if self.ans_shear {
            self.products::<SAMPLES>(g)
        } else {
            self.products::<SAMPLES_WITHOUT_ANS_SHEAR>(g)
        };
        let [middle, above] = [0.0, 1.0].map(|height| self.operator(g, point, self.offset + height));
        let (middle, above) = (middle?, above?);
        let parts = (KXX, products.len() - self.zz());
        let operators = [&middle.samples, &above.samples];
        Ok(Some(ReferenceMetric::new(operators, &products, parts, middle.measure.sqrt())))
    }

    fn mass(&self, g: &ShellGeometry, inertia: &SectionInertia) -> Vec<f64> {
        shell_mass(&self.on_middle(g), inertia)
    }

    fn builder(&self, setup: GroupSetup) -> Box<dyn GroupBuilder> {
        let a = self.parameters();
        if self.ans_shear {
            Box::new(QuadraticBuilder::new("ems", self.strains::<SAMPLES>(), a, setup))
        } else {
            Box::new(QuadraticBuilder::new("ems", self.strains::<SAMPLES_WITHOUT_ANS_SHEAR>(), a, setup))
        }
    }
}
