//! Prescribed strains of curved shells, in the measures of elements that work with stress resultants.
//!
//! The bending strain of these elements is the change of `κ = −sym(d,i·r,j)`, a covariant measure. Its value K at the
//! reference is the curvature, and it changes where a curved surface stretches without bending: a similarity with the strain
//! a changes it by 2 a K, and by a K where the director keeps its length. A fibre at the height z has the base vectors
//! `(I − z K) r,i`, so the stress-free strain e in the surface has the components `e − z (e K + K e)`. With the strain e_z
//! across the thickness, which moves fibres away from the surface, and the stretch e_d that the director takes on,
//!
//! ```text
//! κ₀ = e K + K e − (e_z − e_d) K
//! ```
//!
//! adds to the prescribed curvature; e_d is 0 for inextensible directors. A free arc then changes its angle by the part
//! `e_φφ − e_z`, the spring-in of curved laminates.
//!
//! Plies of unlike expansion hold each other by stresses σ. Then e is the strain of the section as a whole, which they agree
//! on, and e_z the mean over the plies, with their contraction. The stresses have no resultants in the measure of the
//! mid-surface; on the areas of curved fibres they have the moment
//!
//! ```text
//! m = ∫ z² (tr K σ − ½ (σ K + K σ)) dz ,
//! ```
//!
//! which the section takes up by a further strain and curvature. It bends angle-plies and hardly any other.
//!
//! K, and likewise the metric of the reference, are those that the strain operator of the element gives for the sampled
//! products of the reference. A similarity is therefore free of stress up to rounding on any mesh, although assumed
//! strains are not the strains of the point. Heights z, e and K are those of the middle surface of the layers.

use nalgebra::{DMatrix, Matrix2, Matrix3, SMatrix, SVector, Vector3, Vector6};

use super::geometry::ShellGeometry;
use super::shell::ShellElement;
use crate::Mat3;
use crate::model::PrescribedStrain;
use crate::section::CompiledSection;
use crate::section::compiled::{plane_stress_3d, resultants};
use crate::section::quadrature::gauss;

/// Deviations from a flat surface with normal directors below this count as rounding.
const ROUNDING: f64 = 1e-12;

/// Metric and curvature of the reference at a point, as an element sees them: rows of its strain operator times the
/// sampled products of the reference, of which sampled strains are the changes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReferenceMetric {
    /// Twice the strains, less those of an orthonormal base: xx, yy, 2xy, zz, 2xz, 2yz.
    deviation: Vector6<f64>,
    /// Strains of a similarity of unit strain that an inextensible director does not take on.
    of_director: Vector6<f64>,
    /// K_xx, K_yy, 2K_xy.
    curvature: Vector3<f64>,
}

impl ReferenceMetric {
    /// Metric from the strain operators at the heights 0 and 1 and the sampled products; of these, `tangents` are products
    /// of two tangents, the `last` are products of two directors, and the others hold one director. `length` is a length of
    /// the element.
    pub fn new(
        [middle, above]: [&DMatrix<f64>; 2],
        products: &[f64],
        (tangents, last): (usize, usize),
        length: f64,
    ) -> Self {
        let six = |z: &DMatrix<f64>, from: usize, to: usize| {
            Vector6::from_fn(|i, _| (from..to).map(|j| z[(i, j)] * products[j]).sum::<f64>())
        };
        let (first, end) = (products.len() - last, products.len());
        let mixed = six(middle, tangents, first);
        let directors = six(middle, first, end);
        let base = Vector6::new(1.0, 1.0, 0.0, 1.0, 0.0, 0.0);
        let bent = mixed - six(above, tangents, first);
        let curved = |x: f64, unit: f64| if (x * unit).abs() <= ROUNDING { 0.0 } else { x };
        Self {
            deviation: ((six(middle, 0, tangents) + mixed + directors) * 2.0 - base).map(|x| curved(x, 1.0)),
            of_director: (mixed + directors * 2.0).map(|x| curved(x, 1.0)),
            curvature: Vector3::new(bent[0], bent[1], bent[2]).map(|x| curved(x, length)),
        }
    }

    /// Part of a prescribed strain of the section that is due to curvature; the middle of the layers has the height `offset`.
    fn part_of(&self, free: &FreeStrain, offset: f64, unit_directors: bool) -> CurvedStrain {
        let k = in_plane(&self.curvature);
        let e = in_plane(&free.strain);
        let stretch = if unit_directors { 0.0 } else { free.stretch };
        let added = components(&(e * k + k * e - k * (free.thickness - stretch)));
        let held = in_plane(&free.second_moment);
        let moment = components(&(held * k.trace() - (held * k + k * held) * 0.5));
        let mut resultant = SVector::<f64, 9>::zeros();
        resultant.fixed_rows_mut::<3>(6).copy_from(&Vector3::new(moment[0], moment[1], 0.5 * moment[2]));
        let released = free.flexibility * resultant;
        CurvedStrain {
            deviation: tensor(&self.deviation),
            section: free.strain,
            across: if unit_directors { free.thickness } else { free.stretch },
            lost: if unit_directors { self.of_director * free.thickness } else { Vector6::zeros() },
            // Strains of `added` vanish at the middle of the layers.
            membrane: added * offset - released.fixed_rows::<3>(0),
            curvature: added - released.fixed_rows::<3>(6),
        }
    }
}

/// Strains of a section without load.
#[derive(Debug, Clone, Copy)]
struct FreeStrain {
    /// ε_xx, ε_yy, 2ε_xy of the middle of the layers.
    strain: Vector3<f64>,
    /// Mean strain across the thickness.
    thickness: f64,
    /// Stretch of an extensible director.
    stretch: f64,
    /// ∫ z² σ dz of the stresses xx, yy, 2xy by which plies hold each other.
    second_moment: Vector3<f64>,
    /// Inverse of the stiffness of the section, where there are such stresses.
    flexibility: SMatrix<f64, 9, 9>,
}

/// Part of a prescribed strain that is due to curvature, at a point of the mid-surface; zero where the shell is flat.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurvedStrain {
    /// Deviation of the reference metric from that of an orthonormal base, twice as strains are counted.
    deviation: Matrix3<f64>,
    /// Free strain ε_xx, ε_yy, 2ε_xy of the section.
    section: Vector3<f64>,
    /// Strain across the thickness: free stretch of the director, or of the section where directors keep their length.
    across: f64,
    /// Strains that the director would take on if it were extensible.
    lost: Vector6<f64>,
    /// Added strains ε_xx, ε_yy, 2ε_xy at the height 0.
    membrane: Vector3<f64>,
    /// Added curvatures κ_xx, κ_yy, 2κ_xy.
    pub curvature: Vector3<f64>,
}

impl CurvedStrain {
    /// Part of a flat shell: zero.
    pub fn none() -> Self {
        let (deviation, zero, lost) = (Matrix3::zeros(), Vector3::zeros(), Vector6::zeros());
        Self { deviation, section: zero, across: 0.0, lost, membrane: zero, curvature: zero }
    }

    /// Strains that add to those of the section at the mid-surface.
    pub fn added_to_section(&self) -> Vector6<f64> {
        self.added(self.section, 0.0)
    }

    /// Strains that add to a prescribed strain ε_xx, ε_yy, 2ε_xy at the height z.
    pub fn added(&self, strain: Vector3<f64>, z: f64) -> Vector6<f64> {
        let mut e = Matrix3::zeros();
        e.fixed_view_mut::<2, 2>(0, 0).copy_from(&in_plane(&strain));
        e[(2, 2)] = self.across;
        let m = (e * self.deviation + self.deviation * e) * 0.5;
        let mut out =
            Vector6::new(m[(0, 0)], m[(1, 1)], 2.0 * m[(0, 1)], m[(2, 2)], 2.0 * m[(0, 2)], 2.0 * m[(1, 2)])
                - self.lost;
        for i in 0..3 {
            out[i] += self.membrane[i] - z * self.curvature[i];
        }
        out
    }
}

/// Tensor of the components xx, yy, 2xy.
fn in_plane(v: &Vector3<f64>) -> Matrix2<f64> {
    Matrix2::new(v[0], 0.5 * v[2], 0.5 * v[2], v[1])
}

/// Components xx, yy, 2xy of a tensor.
fn components(m: &Matrix2<f64>) -> Vector3<f64> {
    Vector3::new(m[(0, 0)], m[(1, 1)], m[(0, 1)] + m[(1, 0)])
}

/// Tensor of the components xx, yy, 2xy, zz, 2xz, 2yz.
fn tensor(v: &Vector6<f64>) -> Matrix3<f64> {
    let (xy, xz, yz) = (0.5 * v[2], 0.5 * v[4], 0.5 * v[5]);
    Matrix3::new(v[0], xy, xz, xy, v[1], yz, xz, yz, v[3])
}

impl CompiledSection {
    /// Parts of the prescribed strain fields that are due to curvature, at a point of the mid-surface of an element, in the
    /// frame there.
    ///
    /// # Errors
    /// The geometry is invalid, or a direction is normal to the surface there.
    pub fn curved_strains(
        &self,
        element: &dyn ShellElement,
        g: &ShellGeometry,
        (point, frame): (usize, &Mat3),
        prescribed: &[Option<&PrescribedStrain>],
    ) -> Result<Vec<CurvedStrain>, String> {
        let strains =
            |p: &Option<&PrescribedStrain>| !matches!(p, None | Some(PrescribedStrain::Prestress(_)));
        let metric = if prescribed.iter().any(strains) { element.reference_metric(g, point)? } else { None };
        let Some(metric) = metric else { return Ok(vec![CurvedStrain::none(); prescribed.len()]) };
        let of_field = |p: &Option<&PrescribedStrain>| match p {
            Some(p @ (PrescribedStrain::Thermal(_) | PrescribedStrain::Natural(_))) => {
                Ok(metric.part_of(&self.free_strain(p, frame)?, self.offset, element.unit_directors()))
            }
            _ => Ok(CurvedStrain::none()),
        };
        prescribed.iter().map(of_field).collect()
    }

    /// Strains that the section takes on without load, if it is linear. The plies of one without a section stiffness
    /// count by their thickness.
    fn free_strain(&self, p: &PrescribedStrain, frame: &Mat3) -> Result<FreeStrain, String> {
        let turn = self.turn(frame)?;
        let stiffness = resultants(&self.resultant.at(turn));
        let section = self.resultant_strain(p, frame, turn, &stiffness, true).ok();
        let (mut mean, mut contraction) = (Vector6::zeros(), 0.0);
        let mut second_moment = Vector3::zeros();
        // Strains are linear in z over a ply: two points are exact.
        let points = gauss(2);
        for (layer, (x, weight)) in self.layers.iter().flat_map(|l| points.iter().map(move |p| (l, *p))) {
            let turn = turn + layer.angle;
            let half = 0.5 * (layer.top - layer.bottom);
            let z = 0.5 * (layer.top + layer.bottom) + half * x;
            let c = self.stiffness_3d(layer, turn);
            let e0 = Vector6::from_column_slice(self.strain_3d(p, layer, frame, turn, z, &c)?.as_slice());
            mean += e0 * (half * weight / self.thickness);
            if let Some(section) = section.as_ref().filter(|_| self.layers.len() > 1) {
                let elastic = Vector3::from_fn(|i, _| section[i] - z * section[6 + i] - e0[i]);
                let across = (0..3).map(|i| c[(3, i)] * elastic[i]).sum::<f64>() / c[(3, 3)];
                contraction += across * (half * weight / self.thickness);
                let q: Matrix3<f64> = plane_stress_3d(&layer.material, turn).fixed_view::<3, 3>(0, 0).into();
                let stress = q * elastic;
                second_moment +=
                    Vector3::new(stress[0], stress[1], 2.0 * stress[2]) * (z * z * half * weight);
            }
        }
        // A single ply holds nothing back, and layers without a section stiffness release nothing.
        let inverse = if self.layers.len() > 1 { stiffness.try_inverse() } else { None };
        let flexibility = inverse.unwrap_or_else(SMatrix::zeros);
        let of_plies = mean.fixed_rows::<3>(0).into_owned();
        let strain =
            section.as_ref().map_or(of_plies, |s| s.fixed_rows::<3>(0) - s.fixed_rows::<3>(6) * self.offset);
        let stretch = section.as_ref().map_or(mean[3], |s| s[3]);
        Ok(FreeStrain { strain, thickness: mean[3] - contraction, stretch, second_moment, flexibility })
    }
}
