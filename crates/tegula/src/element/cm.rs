//! The bilinear shell of the absolute nodal coordinate formulation by continuum mechanics ("ANCF CM shell").
//!
//! H. Yamashita, A. I. Valkeapää, P. Jayakumar, H. Sugiyama, *Continuum mechanics based bilinear shear
//! deformable shell element using absolute nodal coordinate formulation*, J. Comput. Nonlinear Dyn. 10
//! (2015) 051012. Nodes and interpolation are those of the elastic-middle-surface element, but strains
//! and stresses are three-dimensional at 2×2 points over the surface and at heights z over the thickness:
//!
//! ```text
//! x = r + z d,   g_ξ = r,ξ + z d,ξ,   g_η = r,η + z d,η,   g_z = d
//! 2 ε̃ = (gᵢ·gⱼ) − (Gᵢ·Gⱼ)
//! ```
//!
//! The coefficients of 1, z and z² are sampled separately. Assumed natural strains for transverse shear (points A–D)
//! and thickness (nodes) are those of the EMS element. Three-dimensional stresses lock in bending (Poisson thickness
//! locking), because ε_zz cannot grow linearly with z as Poisson's effect requires: enhanced strains `ζ·{1, ξ, η, ξη}`
//! of ε_zz cure this. With one of them the element fails the bending patch test on distorted meshes, with three or four
//! it passes.
//!
//! | strain | sampled at | count |
//! |---|---|---|
//! | ε̃xx, ε̃yy: 1, z, z² | η = ±g, ξ = ±g | 6 + 6 |
//! | 2ε̃xy: 1, z, z² | Gauss points | 12 |
//! | 2ε̃xz, 2ε̃yz | C, D and A, B on the mid-surface (ANS) | 2 + 2 |
//! | ε̃zz | nodes (ANS) | 4 |
//!
//! In elements shorter than a quarter of the thickness, transverse shear has the part `z d,ξ·d = z ∂(½ d·d)/∂ξ`, which
//! follows from the sampled ε̃zz by differences along the edges. Without it the hourglass mode in which directors
//! alternately stretch and shrink has no stiffness, and elements shorter than a third of the thickness lose stability
//! in bending. In longer elements the part is left out, and the element is that of the paper. Hyperelastic materials have
//! it in elements shorter than six times the thickness.

use nalgebra::{DMatrix, Matrix6, SMatrix};

use super::geometry::{
    GAUSS, GAUSS_POINTS, NODES, ShellGeometry, cross_section_frame, nodal_areas, shape, shape_eta, shape_xi,
    shell_mass, strain_transformation, stretch_gradient,
};
use super::membrane::{HourglassWeights, InPlaneSamples, Membrane, ShearPoint, assumed_shear};
use super::registry::FromSection;
use super::shell::{GroupBuilder, GroupSetup, QuadraticBuilder, ShellElement, StrainOperator};
use super::strains::SampledStrains;
use crate::model::Section;
use crate::section::SectionInertia;

/// Number of sampled strains with assumed natural transverse shear.
pub const SAMPLES: usize = 32;
/// Number of sampled strains without assumed natural transverse shear.
pub const SAMPLES_WITHOUT_ANS_SHEAR: usize = 44;
const DIRECTIONS: usize = 20;
const VECTORS: usize = 8;

const XX: usize = 0;
const YY: usize = 6;
const XY: usize = 12;
const ZZ: usize = 24;
const SHEAR: usize = 28;

/// Stabilisation stiffness of the enhanced thickness stretch over Young's modulus: about the shear modulus of rubber.
/// Values from a tenth to three times Young's modulus work as well.
const STRETCH_STIFFNESS: f64 = 1.0 / 3.0;

/// ANCF continuum-mechanics shell with its locking remedies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CmShell {
    /// Assumed natural strain for transverse shear.
    pub ans_shear: bool,
    /// Assumed natural strain for the thickness.
    pub ans_thickness: bool,
    /// Membrane formulation.
    pub membrane: Membrane,
    /// Number of enhanced parameters of the thickness strain: 0, 1, 3 or 4.
    pub thickness_parameters: usize,
    /// Thickness h (length).
    pub thickness: f64,
    /// True for hyperelastic materials, whose transverse shear has its part linear in z in longer elements, too.
    pub rubber: bool,
}

impl CmShell {
    pub(super) fn strains<const S: usize>(&self) -> SampledStrains<VECTORS, 24, S, DIRECTIONS> {
        let mut t = SampledStrains::new();
        let position = |n: [f64; 4]| std::array::from_fn(|a| if a < 4 { n[a] } else { 0.0 });
        let director = |n: [f64; 4]| std::array::from_fn(|a| if a < 4 { 0.0 } else { n[a - 4] });
        let r_xi = [-GAUSS, GAUSS].map(|eta| t.direction(position(shape_xi(eta))));
        let r_eta = [-GAUSS, GAUSS].map(|xi| t.direction(position(shape_eta(xi))));
        let d_xi = [-GAUSS, GAUSS].map(|eta| t.direction(director(shape_xi(eta))));
        let d_eta = [-GAUSS, GAUSS].map(|xi| t.direction(director(shape_eta(xi))));
        for i in 0..2 {
            for (first, r, d) in [(XX, r_xi[i], d_xi[i]), (YY, r_eta[i], d_eta[i])] {
                t.product(first + i, 0.5, r, r);
                t.product(first + 2 + i, 1.0, r, d);
                t.product(first + 4 + i, 0.5, d, d);
            }
        }
        for p in 0..4 {
            let (xi, eta) = (p % 2, p / 2);
            t.product(XY + p, 1.0, r_xi[eta], r_eta[xi]);
            t.product(XY + 4 + p, 1.0, d_xi[eta], r_eta[xi]);
            t.product(XY + 4 + p, 1.0, r_xi[eta], d_eta[xi]);
            t.product(XY + 8 + p, 1.0, d_xi[eta], d_eta[xi]);
        }
        let needed = !(self.ans_shear && self.ans_thickness);
        let at_gauss: [usize; 4] =
            if needed { GAUSS_POINTS.map(|[xi, eta]| t.direction(director(shape(xi, eta)))) } else { [0; 4] };
        let thickness = if self.ans_thickness {
            NODES.map(|[xi, eta]| t.direction(director(shape(xi, eta))))
        } else {
            at_gauss
        };
        for (a, d) in thickness.into_iter().enumerate() {
            t.product(ZZ + a, 0.5, d, d);
        }
        if self.ans_shear {
            for (i, side) in [-1.0, 1.0].into_iter().enumerate() {
                for (first, slope, at) in [
                    (SHEAR, shape_xi(side), shape(0.0, side)),
                    (SHEAR + 2, shape_eta(side), shape(side, 0.0)),
                ] {
                    let (r, d) = (t.direction(position(slope)), t.direction(director(at)));
                    t.product(first + i, 1.0, r, d);
                }
            }
        } else {
            for p in 0..4 {
                let (xi, eta) = (p % 2, p / 2);
                t.product(SHEAR + p, 1.0, r_xi[eta], at_gauss[p]);
                t.product(SHEAR + 4 + p, 1.0, d_xi[eta], at_gauss[p]);
                t.product(SHEAR + 8 + p, 1.0, r_eta[xi], at_gauss[p]);
                t.product(SHEAR + 12 + p, 1.0, d_eta[xi], at_gauss[p]);
            }
        }
        t
    }

    /// Number of enhanced parameters of the thickness strain that are uniform over the thickness and vary over the
    /// element.
    ///
    /// Assumed shear leaves in-plane normal strains that vary over the element, and no parameters that smooth them. The
    /// thickness, which neighbours share at the nodes, could not follow them without a change of volume: a nearly
    /// incompressible sheet would show volumetric locking and buckle under its stresses. The parameters have a
    /// stabilisation stiffness of their own; otherwise thicknesses that alternate from node to node would form
    /// zero-energy modes.
    fn stretch_parameters(&self) -> usize {
        if self.membrane == Membrane::AssumedShear { 3 } else { 0 }
    }

    /// Weight of the transverse shear strain linear in z, `z d,ξ·d`, in the shear energy.
    ///
    /// Hyperelastic materials have the weight 1 in elements shorter than six times the thickness. Without this strain, the thickness can alternate from
    /// element to element at no cost in shear, and compressed sheets lose stability long before the surface of a half-space
    /// does (M. A. Biot, *Surface instability of rubber in compression*, Appl. Sci. Res. A 12 (1963) 168–182).
    fn linear_shear_share(&self, g: &ShellGeometry) -> f64 {
        if self.rubber && g.is_shorter_than(ShellGeometry::SHORT_RUBBER * self.thickness) {
            1.0
        } else if g.is_shorter_than(ShellGeometry::SHORT * self.thickness) {
            ShellGeometry::SHORT_SHARE
        } else {
            0.0
        }
    }

    /// Covariant strains of a Gauss point at the height z from the sampled strains.
    fn covariant(&self, g: &ShellGeometry, point: usize, z: f64) -> DMatrix<f64> {
        let [xi, eta] = GAUSS_POINTS[point];
        let (i_xi, i_eta) = (point % 2, point / 2);
        let mut c = DMatrix::zeros(6, self.samples());
        for (power, factor) in [1.0, z, z * z].into_iter().enumerate() {
            c[(0, XX + 2 * power + i_eta)] = factor;
            c[(1, YY + 2 * power + i_xi)] = factor;
            c[(2, XY + 4 * power + point)] = factor;
        }
        if let Some(hourglass) = HourglassWeights::of(self.membrane, g) {
            for (power, factor) in [1.0, z, z * z].into_iter().enumerate() {
                let samples = InPlaneSamples { xx: XX + 2 * power, yy: YY + 2 * power, xy: XY + 4 * power };
                hourglass.apply(samples, power, point, 0, &mut |row, sample, value| {
                    c[(row, sample)] += factor * value;
                });
            }
        }
        if self.ans_thickness {
            for (a, n) in shape(xi, eta).into_iter().enumerate() {
                c[(3, ZZ + a)] = n;
            }
        } else {
            c[(3, ZZ + point)] = 1.0;
        }
        if self.ans_shear {
            for (i, side) in [-1.0, 1.0].into_iter().enumerate() {
                c[(4, SHEAR + i)] = 0.5 * (1.0 + side * eta);
                c[(5, SHEAR + 2 + i)] = 0.5 * (1.0 + side * xi);
            }
            let share = self.linear_shear_share(g);
            if self.ans_thickness && share > 0.0 {
                // z d,ξ·d is the derivative of ½ z d·d.
                for (a, gradient) in stretch_gradient(xi, eta).into_iter().enumerate() {
                    for (i, slope) in gradient.into_iter().enumerate() {
                        c[(4 + i, ZZ + a)] = share.sqrt() * z * slope;
                    }
                }
            }
        } else {
            for (power, factor) in [1.0, z].into_iter().enumerate() {
                c[(4, SHEAR + 4 * power + point)] = factor;
                c[(5, SHEAR + 8 + 4 * power + point)] = factor;
            }
        }
        c
    }

    /// Strain operator at the height z over a Gauss point, without enhanced strains and assumed in-plane shear.
    fn point_strains(&self, g: &ShellGeometry, point: usize, z: f64) -> Result<PointStrains, String> {
        let [xi, eta] = GAUSS_POINTS[point];
        let base = g.base(xi, eta, z);
        let frame = cross_section_frame(&base)
            .ok_or("its director lies in the surface or vanishes: no cross-section frame")?;
        // A director may point to either side of the element.
        let measure = base.determinant().abs();
        let centre = g.base(0.0, 0.0, 0.0);
        let inverse = |m: nalgebra::Matrix3<f64>| m.try_inverse().filter(|b| b.iter().all(|x| x.is_finite()));
        let (b, b0) = inverse(frame.transpose() * base)
            .zip(inverse(frame.transpose() * centre))
            .filter(|_| measure > 0.0)
            .ok_or("it is collapsed: its volume vanishes at an integration point")?;
        let transformation = strain_transformation(&b);
        let transformation = DMatrix::from_column_slice(6, 6, transformation.as_slice());
        Ok(PointStrains {
            samples: transformation * self.covariant(g, point, z),
            centre: strain_transformation(&b0) * (centre.determinant().abs() / measure),
            frame,
            measure,
        })
    }

    /// Amplitudes of the enhanced shear modes that the assumed shear projects out, from the sampled strains of the
    /// mid-surface.
    fn assumed_shear(&self, g: &ShellGeometry) -> Result<DMatrix<f64>, String> {
        let points = (0..4)
            .map(|point| {
                let p = self.point_strains(g, point, 0.0)?;
                let shear = shear_polynomials(&p.centre, point);
                Ok(ShearPoint { strain: p.samples, shear, measure: p.measure })
            })
            .collect::<Result<Vec<_>, String>>()?;
        assumed_shear(g, &points).ok_or_else(|| "its in-plane shear strains are not independent".into())
    }
}

/// Strain operator of a point, without enhanced strains and assumed in-plane shear.
struct PointStrains {
    /// Strains in the frame from the sampled strains.
    samples: DMatrix<f64>,
    /// Strains in the frame from covariant strains at the centre, times the ratio of the measures (eq. 29).
    centre: Matrix6<f64>,
    frame: crate::Mat3,
    measure: f64,
}

/// Enhanced in-plane shear modes, linear in ξ and in η.
fn shear_polynomials(centre: &Matrix6<f64>, point: usize) -> DMatrix<f64> {
    let [xi, eta] = GAUSS_POINTS[point];
    DMatrix::from_fn(6, 2, |i, j| centre[(i, 2)] * [xi, eta][j])
}

impl FromSection for CmShell {
    fn from_section(section: &Section, thickness: f64, rubber: bool) -> Self {
        Self {
            ans_shear: section.ans_shear,
            ans_thickness: section.ans_thickness,
            membrane: section.membrane_part(),
            thickness_parameters: usize::from(section.thickness_eas),
            thickness,
            rubber,
        }
    }
}

impl ShellElement for CmShell {
    fn name(&self) -> &'static str {
        "cm"
    }

    fn samples(&self) -> usize {
        if self.ans_shear { SAMPLES } else { SAMPLES_WITHOUT_ANS_SHEAR }
    }

    fn parameters(&self) -> usize {
        self.thickness_parameters + self.membrane.parameters() + self.stretch_parameters()
    }

    fn without_enhanced_strains(&self) -> Option<Box<dyn ShellElement>> {
        (self.membrane.parameters() > 0).then(|| -> Box<dyn ShellElement> {
            Box::new(Self { membrane: Membrane::Displacement, ..*self })
        })
    }

    fn is_solid(&self) -> bool {
        true
    }

    /// The enhanced strains are those of eqs. 29–31 of the EMS paper with three-dimensional measures and with the
    /// base of the centre in the frame of the point.
    fn operator(&self, g: &ShellGeometry, point: usize, z: f64) -> Result<StrainOperator, String> {
        let [xi, eta] = GAUSS_POINTS[point];
        let at = self.point_strains(g, point, z)?;
        let zeta = 2.0 * z / self.thickness;
        let mut polynomials = SMatrix::<f64, 6, 8>::zeros();
        let mut column = 0;
        if self.membrane.parameters() > 0 {
            for (row, value) in [(0, xi), (1, eta), (2, xi), (2, eta)] {
                polynomials[(row, column)] = value;
                column += 1;
            }
        }
        for value in
            [zeta, zeta * xi, zeta * eta, zeta * xi * eta].into_iter().take(self.thickness_parameters)
        {
            polynomials[(3, column)] = value;
            column += 1;
        }
        for value in [xi, eta, xi * eta].into_iter().take(self.stretch_parameters()) {
            polynomials[(3, column)] = value;
            column += 1;
        }
        let enhanced = (at.centre * polynomials).columns(0, column).into_owned();
        let enhanced = DMatrix::from_column_slice(6, column, enhanced.as_slice());
        let mut samples = at.samples;
        if self.membrane == Membrane::AssumedShear {
            samples += shear_polynomials(&at.centre, point) * self.assumed_shear(g)?;
        }
        Ok(StrainOperator { samples, enhanced, frame: at.frame, measure: at.measure })
    }

    fn parameter_stiffness(&self, g: &ShellGeometry) -> Vec<f64> {
        let area: f64 = nodal_areas(&g.positions).iter().sum();
        // Means of ξ², η² and ξ²η².
        [1.0 / 3.0, 1.0 / 3.0, 1.0 / 9.0]
            .into_iter()
            .take(self.stretch_parameters())
            .map(|m| STRETCH_STIFFNESS * m * area)
            .collect()
    }

    fn mass(&self, g: &ShellGeometry, inertia: &SectionInertia) -> Vec<f64> {
        shell_mass(g, inertia)
    }

    fn builder(&self, setup: GroupSetup) -> Box<dyn GroupBuilder> {
        let a = self.parameters();
        if self.ans_shear {
            Box::new(QuadraticBuilder::new("cm", self.strains::<SAMPLES>(), a, setup))
        } else {
            Box::new(QuadraticBuilder::new("cm", self.strains::<SAMPLES_WITHOUT_ANS_SHEAR>(), a, setup))
        }
    }
}
