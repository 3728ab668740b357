//! Integration points of an element with a section: the terms of its energy, from the strain operators of the element
//! type and the layers or the stiffness of the section.

use nalgebra::{DMatrix, DVector, Matrix2, Matrix6, SMatrix, Vector2, Vector3};

use super::curved_strain::CurvedStrain;
use super::geometry::ShellGeometry;
use super::shell::{IntegrationPoint, PointResponse, ShellElement, StrainOperator};
use crate::Mat3;
use crate::model::PrescribedStrain;
use crate::section::CompiledSection;
use crate::section::compiled::{Layer, plane_stress_3d, resultants};

impl CompiledSection {
    /// Stiffness of a layer of an element in plane stress, with E in zz and the reduced transverse shear moduli.
    pub fn stiffness_plane(&self, layer: &Layer, turn: f64, g: &ShellGeometry) -> Matrix6<f64> {
        let mut c = plane_stress_3d(&layer.material, turn);
        c.view_mut((4, 4), (2, 2)).scale_mut(self.shear_reduction(g));
        c
    }

    /// Stabilisation factor `h²/(h² + α l²)` of the transverse shear stiffness of an element that works with stress
    /// resultants; l is its longest edge. Where elements are longer than the shell is thick, it removes what an element
    /// cannot resolve of the boundary layers at free edges, whose width is of the order of h; it tends to 1 as l/h
    /// tends to 0.
    ///
    /// M. Lyly, R. Stenberg, T. Vihinen, *A stable bilinear element for the Reissner–Mindlin plate model*, Comput.
    /// Methods Appl. Mech. Eng. 110 (1993) 343–357.
    pub fn shear_reduction(&self, g: &ShellGeometry) -> f64 {
        let edges = (0..4).map(|a| (g.positions[a] - g.positions[(a + 1) % 4]).norm_squared());
        let h2 = self.thickness * self.thickness;
        h2 / (h2 + self.shear_stabilization * edges.fold(0.0, crate::norm::larger))
    }

    /// Integration points of an element, the terms of its energy; `prescribed` holds the prescribed strain fields that
    /// act on it.
    ///
    /// # Errors
    /// The geometry is invalid; the text says how.
    pub fn integration_points(
        &self,
        element: &dyn ShellElement,
        g: &ShellGeometry,
        prescribed: &[Option<&PrescribedStrain>],
    ) -> Result<Vec<IntegrationPoint>, String> {
        let mut out = Vec::new();
        for point in 0..element.surface_points() {
            if element.is_solid() {
                self.over_thickness(element, g, point, prescribed, &mut out)?;
            } else {
                self.with_resultants(element, g, point, prescribed, &mut out)?;
            }
        }
        let stiffness = element.parameter_stiffness(g);
        if !stiffness.is_empty() {
            let (n, all) = (stiffness.len(), element.parameters());
            let response = DMatrix::from_diagonal(&DVector::from_vec(stiffness)) * self.resultant.stretch();
            out.push(IntegrationPoint {
                samples: DMatrix::zeros(n, element.samples()),
                enhanced: DMatrix::from_fn(n, all, |i, j| if j == all - n + i { 1.0 } else { 0.0 }),
                response: PointResponse::Linear(response),
                weight: 1.0,
                prescribed: prescribed.iter().map(|_| DVector::zeros(n)).collect(),
                residual_energy: DMatrix::zeros(0, 0),
            });
        }
        Ok(out)
    }

    /// Adds integration points over the thickness with three-dimensional stresses.
    fn over_thickness(
        &self,
        element: &dyn ShellElement,
        g: &ShellGeometry,
        point: usize,
        prescribed: &[Option<&PrescribedStrain>],
        out: &mut Vec<IntegrationPoint>,
    ) -> Result<(), String> {
        let (mut points, mut heights) = (Vec::new(), Vec::new());
        let none = vec![CurvedStrain::none(); prescribed.len()];
        for layer in &self.layers {
            for &(z, weight) in &layer.points {
                let operator = element.operator(g, point, z)?;
                let turn = self.turn(&operator.frame)? + layer.angle;
                let stiffness = self.stiffness_3d(layer, turn);
                let place = (turn, z, operator.measure * weight);
                let fields = (prescribed, &none[..], 6);
                points.push(self.layer_point(layer, operator, place, &stiffness, fields)?);
                heights.push(z);
            }
        }
        if self.has_thickness_strain_of_layers() {
            out.push(condense_thickness_strain(&mut points, &heights)?);
        }
        out.append(&mut points);
        Ok(())
    }

    /// Whether layers of different linear materials have thickness strains of their own in elements with three-dimensional
    /// stresses. One thickness strain, linear in z, for all of them would let layers that expand or contract differently
    /// hold each other across the thickness, which free faces do not.
    pub fn has_thickness_strain_of_layers(&self) -> bool {
        let equal = |a: &Layer, b: &Layer| {
            a.material == b.material && (a.angle == b.angle || a.material.is_isotropic())
        };
        self.is_linear() && self.layers.windows(2).any(|pair| !equal(&pair[0], &pair[1]))
    }

    /// Adds an integration point with the section stiffness. If a layer is not linear, this point has transverse shear
    /// and thickness stiffness only, and the layers are integrated over the thickness in plane stress.
    fn with_resultants(
        &self,
        element: &dyn ShellElement,
        g: &ShellGeometry,
        point: usize,
        prescribed: &[Option<&PrescribedStrain>],
        out: &mut Vec<IntegrationPoint>,
    ) -> Result<(), String> {
        let middle = element.operator(g, point, 0.0)?;
        // Strains are ε − z κ.
        let above = element.operator(g, point, 1.0)?;
        let turn = self.turn(&middle.frame)?;
        let mut stiffness = resultants(&self.resultant.at(turn));
        // Second moment of the transverse shear stiffness, as if it were uniform over the thickness.
        let shear_moment = stiffness.fixed_view::<2, 2>(4, 4)
            * (self.thickness * self.thickness / 12.0 * ShellGeometry::SHORT_SHARE);
        stiffness.view_mut((4, 4), (2, 2)).scale_mut(self.shear_reduction(g));
        let linear = self.is_linear();
        if !linear {
            for i in [0, 1, 2, 6, 7, 8] {
                for j in 0..9 {
                    stiffness[(i, j)] = 0.0;
                    stiffness[(j, i)] = 0.0;
                }
            }
        }
        // Shear linear in z matters in short elements only.
        let gradient = g
            .is_shorter_than(ShellGeometry::SHORT * self.thickness)
            .then(|| element.stretch_gradient(g, point))
            .flatten();
        let rows = 9 + gradient.as_ref().map_or(0, |m| m.nrows());
        let (s, a) = (element.samples(), element.parameters());
        let mut samples = DMatrix::zeros(rows, s);
        samples.rows_mut(0, 6).copy_from(&middle.samples);
        samples.rows_mut(6, 3).copy_from(&(middle.samples.rows(0, 3) - above.samples.rows(0, 3)));
        let mut enhanced = DMatrix::zeros(rows, a);
        enhanced.rows_mut(0, 6).copy_from(&middle.enhanced);
        let mut response = DMatrix::zeros(rows, rows);
        response.view_mut((0, 0), (9, 9)).copy_from(&stiffness);
        if let Some(gradient) = gradient {
            samples.rows_mut(9, 2).copy_from(&gradient);
            response.view_mut((9, 9), (2, 2)).copy_from(&shear_moment);
        }
        let curved = self.curved_strains(element, g, (point, &middle.frame), prescribed)?;
        let at = (&middle.frame, turn, &stiffness);
        let fields = self.prescribed_resultants(at, &curved, element.unit_directors(), prescribed)?;
        let fields = fields.into_iter().map(|strain| strain.resize_vertically(rows, 0.0)).collect();
        out.push(IntegrationPoint {
            samples,
            enhanced,
            response: PointResponse::Linear(response),
            weight: middle.measure,
            prescribed: fields,
            residual_energy: if linear {
                self.residual_energy(prescribed, turn)?
            } else {
                DMatrix::zeros(0, 0)
            },
        });
        if linear {
            return Ok(());
        }
        for layer in &self.layers {
            for &(z, weight) in &layer.points {
                let mut operator = element.operator(g, point, z)?;
                let turn = turn + layer.angle;
                let stiffness = plane_stress_3d(&layer.material, turn);
                for row in 3..6 {
                    operator.samples.row_mut(row).fill(0.0);
                    operator.enhanced.row_mut(row).fill(0.0);
                }
                let place = (turn, z, operator.measure * weight);
                let fields = (prescribed, &curved[..], 3);
                out.push(self.layer_point(layer, operator, place, &stiffness, fields)?);
            }
        }
        Ok(())
    }

    /// Prescribed section strains by fields at a point of the mid-surface with its frame, angle and stiffness. `curved` is
    /// what the curvature of the shell adds.
    fn prescribed_resultants(
        &self,
        (frame, turn, stiffness): (&Mat3, f64, &SMatrix<f64, 9, 9>),
        curved: &[CurvedStrain],
        unit_directors: bool,
        prescribed: &[Option<&PrescribedStrain>],
    ) -> Result<Vec<DVector<f64>>, String> {
        let field = |(p, curved): (&Option<&PrescribedStrain>, &CurvedStrain)| {
            let Some(p) = p else { return Ok(DVector::zeros(9)) };
            let mut strain = self.resultant_strain(p, frame, turn, stiffness, self.is_linear())?;
            let mut in_surface = strain.rows_mut(0, 6);
            in_surface += curved.added_to_section();
            let mut bending = strain.rows_mut(6, 3);
            bending += curved.curvature;
            if unit_directors {
                // Inextensible directors take no part in the thickness stretch.
                strain[3] = 0.0;
            }
            Ok(strain)
        };
        prescribed.iter().zip(curved).map(field).collect()
    }

    /// Integration point of a layer at the height `z`; prescribed strains, to which the curvature of the shell adds, act on its
    /// first `components` strains.
    fn layer_point(
        &self,
        layer: &Layer,
        operator: StrainOperator,
        (turn, z, weight): (f64, f64, f64),
        stiffness: &Matrix6<f64>,
        (prescribed, curved, components): (&[Option<&PrescribedStrain>], &[CurvedStrain], usize),
    ) -> Result<IntegrationPoint, String> {
        let field = |(p, curved): (&Option<&PrescribedStrain>, &CurvedStrain)| {
            let Some(p) = p else { return Ok(DVector::zeros(6)) };
            let mut strain = self.strain_3d(p, layer, &operator.frame, turn, z, stiffness)?;
            strain += curved.added(Vector3::new(strain[0], strain[1], strain[2]), z);
            strain.rows_mut(components, 6 - components).fill(0.0);
            Ok::<_, String>(strain)
        };
        Ok(IntegrationPoint {
            prescribed: prescribed.iter().zip(curved).map(field).collect::<Result<_, _>>()?,
            samples: operator.samples,
            enhanced: operator.enhanced,
            response: match layer.law {
                Some(law) => PointResponse::Law(law),
                None => PointResponse::Linear(DMatrix::from_column_slice(6, 6, stiffness.as_slice())),
            },
            weight,
            residual_energy: DMatrix::zeros(0, 0),
        })
    }
}

/// Static condensation of the thickness strains β of layers over a point of the mid-surface, which add to the strain ε_zz of
/// the element and do no work on a stress σ_zz linear in z: `Σ w β = Σ w z β = 0`.
///
/// Minimising the energy `Σ w ½ (ε + β e − ε₀)·C (ε + β e − ε₀)` with the unit vector e of ε_zz gives `σ_zz = p + q z` and
///
/// ```text
/// Σ w ½ (ε − ε₀)·C̄ (ε − ε₀) + ½ r·M⁻¹ r,   C̄ = C − c cᵀ/C₃₃,   c = C e,
/// r = Σ w/C₃₃ (1, z) c·(ε − ε₀),            M = Σ w/C₃₃ (1, z)(1, z)ᵀ,   (p, q) = M⁻¹ r .
/// ```
///
/// The points get C̄ in place of C; the point returned has the strains r, and the stress (p, q).
///
/// # Errors
/// A layer has no stiffness across the thickness.
fn condense_thickness_strain(
    points: &mut [IntegrationPoint],
    heights: &[f64],
) -> Result<IntegrationPoint, String> {
    let sizes =
        points.first().map_or((0, 0, 0), |p| (p.samples.ncols(), p.enhanced.ncols(), p.prescribed.len()));
    let mut samples = DMatrix::zeros(2, sizes.0);
    let mut enhanced = DMatrix::zeros(2, sizes.1);
    let mut prescribed = vec![DVector::zeros(2); sizes.2];
    let mut m = Matrix2::zeros();
    for (point, &z) in points.iter_mut().zip(heights) {
        let PointResponse::Linear(c) = &mut point.response else { continue };
        let (column, stiffness) = (c.column(3).into_owned(), c[(3, 3)]);
        let basis = Vector2::new(1.0, z);
        let along = basis * (point.weight / stiffness);
        m += along * basis.transpose();
        samples += along * column.tr_mul(&point.samples);
        enhanced += along * column.tr_mul(&point.enhanced);
        for (sum, e0) in prescribed.iter_mut().zip(&point.prescribed) {
            *sum += along * column.dot(e0);
        }
        *c -= &column * column.transpose() / stiffness;
        c.row_mut(3).fill(0.0);
        c.column_mut(3).fill(0.0);
    }
    let response = m.try_inverse().ok_or("its layers have no stiffness across the thickness")?;
    Ok(IntegrationPoint {
        samples,
        enhanced,
        response: PointResponse::Linear(DMatrix::from_column_slice(2, 2, response.as_slice())),
        weight: 1.0,
        prescribed,
        residual_energy: DMatrix::zeros(0, 0),
    })
}
