//! Compiled section of the model: layers, material laws and section stiffness, which give the elements their
//! integration points.

use nalgebra::{DMatrix, DVector, Matrix6, SMatrix, SVector, Vector3, Vector6};

use super::laminate::Laminate;
use super::ply::{angle_in_plane, shear_turn, strain_turn, turned_plane_stress, turned_shear};
use super::quadrature::{gauss, lobatto};
use super::{SectionInertia, SectionStiffness};
use crate::element::geometry::ShellGeometry;
use crate::element::shell::{IntegrationPoint, PointResponse, ShellElement, StrainOperator};
use crate::material::Law;
use crate::model::{Material, PrescribedStrain};
use crate::{Mat3, Vec3};

/// Layer of one material.
#[derive(Debug, Clone)]
pub struct Layer {
    /// Height of its lower side (length).
    pub bottom: f64,
    /// Height of its upper side (length).
    pub top: f64,
    /// Angle from the section's direction to the material's first axis, about the director (rad).
    pub angle: f64,
    /// Name of its material.
    pub name: String,
    /// Material.
    pub material: Material,
    /// Index of its law in [`CompiledSection::laws`] where its material is not linear.
    pub law: Option<usize>,
    /// Heights and weights of its integration points.
    pub points: Vec<(f64, f64)>,
}

impl Layer {
    /// Layer with its integration points: Gauss–Lobatto rule if they include the `ends`, otherwise Gauss–Legendre rule.
    pub fn new(
        name: &str,
        material: &Material,
        [bottom, top]: [f64; 2],
        angle: f64,
        points: usize,
        ends: bool,
    ) -> Self {
        let (middle, half) = (0.5 * (bottom + top), 0.5 * (top - bottom));
        let rule = if ends { lobatto(points) } else { gauss(points) };
        let points = rule.into_iter().map(|(x, w)| (middle + half * x, half * w)).collect();
        Self { bottom, top, angle, name: name.into(), material: material.clone(), law: None, points }
    }

    /// Moments ∫1 dz, ∫z dz, ∫z² dz of the layer.
    pub fn moments(&self) -> [f64; 3] {
        let (a, b) = (self.bottom, self.top);
        [b - a, 0.5 * (b * b - a * a), (b * b * b - a * a * a) / 3.0]
    }
}

/// Section of the model with its material laws.
#[derive(Debug, Clone)]
pub struct CompiledSection {
    /// Total thickness (length).
    pub thickness: f64,
    /// Layers from the bottom to the top.
    pub layers: Vec<Layer>,
    /// Nonlinear material laws; empty if all materials are linear.
    pub laws: Vec<Law>,
    /// Inertia per area.
    pub inertia: SectionInertia,
    /// Direction that layer angles are measured from; its projection on the surface is taken.
    pub direction: Vec3,
    /// Section stiffness in the axes of `direction`.
    pub resultant: Resultant,
    /// Shear correction factors of three-dimensional materials.
    pub shear_factors: [f64; 2],
    /// Coefficient α of [`Self::shear_reduction`].
    pub shear_stabilization: f64,
    /// True if every layer is isotropic in the surface.
    pub isotropic: bool,
}

/// Section stiffness per area.
#[derive(Debug, Clone)]
pub enum Resultant {
    /// Isotropic in the surface.
    Isotropic(SectionStiffness),
    /// Laminate: a stack of layers.
    Laminate(Laminate),
    /// No section stiffness: the materials have three-dimensional stresses only; the value ∫E3 dz serves for estimates.
    None(f64),
}

impl Resultant {
    /// Section stiffness in axes from which the section's direction is rotated by `turn` (rad).
    pub fn at(&self, turn: f64) -> SectionStiffness {
        match self {
            Self::Isotropic(s) => s.clone(),
            Self::Laminate(l) => l.stiffness(turn),
            Self::None(_) => SectionStiffness::zero(),
        }
    }

    /// Stiffness of the thickness stretch, ∫E3 dz.
    pub fn stretch(&self) -> f64 {
        match self {
            Self::Isotropic(s) => s.thickness,
            Self::Laminate(l) => l.stiffness(0.0).thickness,
            Self::None(stretch) => *stretch,
        }
    }
}

impl CompiledSection {
    /// Bending stiffness (force × length) along the stiffer axis of the section; an estimate from the modulus where the
    /// materials have three-dimensional stresses only.
    pub fn bending(&self) -> f64 {
        match &self.resultant {
            Resultant::None(stretch) => stretch * self.thickness * self.thickness / 12.0,
            stiffness => stiffness.at(0.0).bending.diagonal().max(),
        }
    }

    /// True if all materials are linear.
    pub fn is_linear(&self) -> bool {
        self.laws.is_empty()
    }

    /// True if a layer is hyperelastic.
    pub fn has_rubber(&self) -> bool {
        self.laws.iter().any(|l| matches!(l, Law::Hyperelastic(_)))
    }

    /// Angle from the x axis of a cross-section frame to a direction's projection on the surface.
    ///
    /// # Errors
    /// The direction is normal to the surface there.
    pub fn angle(frame: &Mat3, direction: &Vec3) -> Result<f64, String> {
        angle_in_plane(direction, &frame.column(0).into(), &frame.column(1).into()).ok_or_else(|| {
            format!(
                "the direction ({}, {}, {}) is normal to it and gives no angle",
                direction.x, direction.y, direction.z
            )
        })
    }

    /// Angle from the x axis of a cross-section frame to a layer's first axis.
    ///
    /// # Errors
    /// The section's direction is normal to the surface there.
    pub fn layer_turn(&self, layer: &Layer, frame: &Mat3) -> Result<f64, String> {
        Ok(self.turn(frame)? + layer.angle)
    }

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
        h2 / (h2 + self.shear_stabilization * edges.fold(0.0, f64::max))
    }

    /// Prescribed strain of a layer at the height `z`; a prestress σ counts as the strain −C⁻¹σ.
    ///
    /// # Errors
    /// A direction is normal to the surface there.
    pub fn prescribed_strain(
        &self,
        prescribed: &PrescribedStrain,
        layer: &Layer,
        frame: &Mat3,
        z: f64,
    ) -> Result<Vector6<f64>, String> {
        let turn = self.layer_turn(layer, frame)?;
        let e = self.strain_3d(prescribed, layer, frame, turn, z, &self.stiffness_3d(layer, turn))?;
        Ok(Vector6::from_column_slice(e.as_slice()))
    }

    fn turn(&self, frame: &Mat3) -> Result<f64, String> {
        if self.isotropic { Ok(0.0) } else { Self::angle(frame, &self.direction) }
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
        for layer in &self.layers {
            for &(z, weight) in &layer.points {
                let operator = element.operator(g, point, z)?;
                let turn = self.turn(&operator.frame)? + layer.angle;
                let stiffness = self.stiffness_3d(layer, turn);
                let place = (turn, z, operator.measure * weight);
                out.push(self.layer_station(layer, operator, place, &stiffness, prescribed, 6)?);
            }
        }
        Ok(())
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
        let fields = prescribed
            .iter()
            .map(|p| match p {
                None => Ok(DVector::zeros(rows)),
                Some(p) => {
                    let mut strain = self.resultant_strain(p, &middle.frame, turn, &stiffness, linear)?;
                    if element.unit_directors() {
                        // Inextensible directors take no part in the thickness stretch.
                        strain[3] = 0.0;
                    }
                    Ok(strain.resize_vertically(rows, 0.0))
                }
            })
            .collect::<Result<_, String>>()?;
        out.push(IntegrationPoint {
            samples,
            enhanced,
            response: PointResponse::Linear(response),
            weight: middle.measure,
            prescribed: fields,
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
                out.push(self.layer_station(layer, operator, place, &stiffness, prescribed, 3)?);
            }
        }
        Ok(())
    }

    /// Integration point of a layer at the height `z`; prescribed strains act on its first `components` strains.
    fn layer_station(
        &self,
        layer: &Layer,
        operator: StrainOperator,
        (turn, z, weight): (f64, f64, f64),
        stiffness: &Matrix6<f64>,
        prescribed: &[Option<&PrescribedStrain>],
        components: usize,
    ) -> Result<IntegrationPoint, String> {
        let field = |p: &Option<&PrescribedStrain>| {
            let Some(p) = p else { return Ok(DVector::zeros(6)) };
            let mut strain = self.strain_3d(p, layer, &operator.frame, turn, z, stiffness)?;
            strain.rows_mut(components, 6 - components).fill(0.0);
            Ok::<_, String>(strain)
        };
        Ok(IntegrationPoint {
            prescribed: prescribed.iter().map(field).collect::<Result<_, _>>()?,
            samples: operator.samples,
            enhanced: operator.enhanced,
            response: match layer.law {
                Some(law) => PointResponse::Law(law),
                None => PointResponse::Linear(dynamic(stiffness)),
            },
            weight,
        })
    }

    /// Three-dimensional stiffness of a layer at zero strain, in axes from which its first axis is rotated by `turn`,
    /// with shear correction factors.
    pub fn stiffness_3d(&self, layer: &Layer, turn: f64) -> Matrix6<f64> {
        let law = layer.material.law_3d();
        let mut zero = [0.0; 16];
        let zero = &mut zero[..law.history()];
        let committed = zero.to_vec();
        let mut c = law.respond(&Vector6::zeros(), &committed, zero).map_or(Matrix6::zeros(), |r| r.tangent);
        if !layer.material.is_isotropic() {
            let t = turn_3d(turn);
            c = t.transpose() * c * t;
        }
        for (i, factor) in self.shear_factors.into_iter().enumerate() {
            let root = factor.sqrt();
            for j in 0..6 {
                c[(4 + i, j)] *= root;
                c[(j, 4 + i)] *= root;
            }
        }
        c
    }

    /// Prescribed strain of a layer at the height `z`; a prestress σ counts as the strain −C⁻¹σ.
    fn strain_3d(
        &self,
        prescribed: &PrescribedStrain,
        layer: &Layer,
        frame: &Mat3,
        turn: f64,
        z: f64,
        stiffness: &Matrix6<f64>,
    ) -> Result<DVector<f64>, String> {
        let h = self.thickness;
        let strain = match prescribed {
            PrescribedStrain::Thermal(t) => {
                expansion(&layer.material, turn) * (t.temperature + t.gradient * z)
            }
            PrescribedStrain::Natural(n) => {
                let angle = Self::angle(frame, &n.direction.into())?;
                let at = Vector3::from(n.strain) - Vector3::from(n.curvature) * z;
                in_plane(&turned_strain(at, angle))
            }
            PrescribedStrain::Prestress(p) => {
                let angle = Self::angle(frame, &p.direction.into())?;
                let at = Vector3::from(p.membrane) / h - Vector3::from(p.bending) * (12.0 * z / h.powi(3));
                let stress = in_plane(&turned_stress(at, angle));
                -stiffness.lu().solve(&stress).ok_or("its stiffness is singular")?
            }
        };
        Ok(DVector::from_column_slice(strain.as_slice()))
    }

    /// Prescribed section strains ε, ε_zz, γ, κ, conjugate to the stress resultants.
    fn resultant_strain(
        &self,
        prescribed: &PrescribedStrain,
        frame: &Mat3,
        turn: f64,
        stiffness: &SMatrix<f64, 9, 9>,
        linear: bool,
    ) -> Result<DVector<f64>, String> {
        let mut strain = SVector::<f64, 9>::zeros();
        match prescribed {
            PrescribedStrain::Thermal(t) => {
                let mut held_back = SVector::<f64, 9>::zeros();
                for layer in &self.layers {
                    let [z0, z1, z2] = layer.moments();
                    let alpha = expansion(&layer.material, turn + layer.angle);
                    let stress = plane_stress_3d(&layer.material, turn + layer.angle) * alpha;
                    let (t0, t1) =
                        (t.temperature * z0 + t.gradient * z1, t.temperature * z1 + t.gradient * z2);
                    for i in 0..3 {
                        held_back[i] += stress[i] * t0;
                        held_back[6 + i] -= stress[i] * t1;
                    }
                    held_back[3] += stress[3] * t0;
                }
                if linear {
                    strain = stiffness.lu().solve(&held_back).ok_or("the section's stiffness is singular")?;
                } else {
                    strain[3] = held_back[3] / stiffness[(3, 3)];
                }
            }
            PrescribedStrain::Natural(n) => {
                let angle = Self::angle(frame, &n.direction.into())?;
                strain.fixed_rows_mut::<3>(0).copy_from(&turned_strain(n.strain.into(), angle));
                strain.fixed_rows_mut::<3>(6).copy_from(&turned_strain(n.curvature.into(), angle));
            }
            PrescribedStrain::Prestress(p) if linear => {
                let angle = Self::angle(frame, &p.direction.into())?;
                let mut stress = SVector::<f64, 9>::zeros();
                stress.fixed_rows_mut::<3>(0).copy_from(&turned_stress(p.membrane.into(), angle));
                stress.fixed_rows_mut::<3>(6).copy_from(&turned_stress(p.bending.into(), angle));
                strain = -stiffness.lu().solve(&stress).ok_or("the section's stiffness is singular")?;
            }
            PrescribedStrain::Prestress(_) => {}
        }
        Ok(DVector::from_column_slice(strain.as_slice()))
    }
}

/// Section stiffness matrix: stress resultants (n, n_zz, q, m) from (ε, ε_zz, γ, κ).
pub fn resultants(section: &SectionStiffness) -> SMatrix<f64, 9, 9> {
    let mut d = SMatrix::<f64, 9, 9>::zeros();
    d.fixed_view_mut::<3, 3>(0, 0).copy_from(&section.membrane);
    d.fixed_view_mut::<3, 3>(0, 6).copy_from(&section.coupling);
    d.fixed_view_mut::<3, 3>(6, 0).copy_from(&section.coupling.transpose());
    d.fixed_view_mut::<3, 3>(6, 6).copy_from(&section.bending);
    d.fixed_view_mut::<2, 2>(4, 4).copy_from(&section.shear);
    d[(3, 3)] = section.thickness;
    d
}

fn dynamic<const N: usize>(m: &SMatrix<f64, N, N>) -> DMatrix<f64> {
    DMatrix::from_column_slice(N, N, m.as_slice())
}

/// Stiffness of a material: plane stress in xx, yy, xy; uncoupled E in zz and transverse shear moduli.
fn plane_stress_3d(material: &Material, turn: f64) -> Matrix6<f64> {
    let mut out = Matrix6::zeros();
    let Some((plane, shear, thickness)) = material.plane_stress() else { return out };
    let (plane, shear) = if material.is_isotropic() {
        (plane, shear)
    } else {
        (turned_plane_stress(&plane, turn), turned_shear(&shear, turn))
    };
    out.fixed_view_mut::<3, 3>(0, 0).copy_from(&plane);
    out.fixed_view_mut::<2, 2>(4, 4).copy_from(&shear);
    out[(3, 3)] = thickness;
    out
}

/// Thermal expansion in axes from which the material's first axis is rotated by `turn`.
fn expansion(material: &Material, turn: f64) -> Vector6<f64> {
    let [a1, a2, a3] = material.expansion();
    let plane = turned_strain(Vector3::new(a1, a2, 0.0), turn);
    let mut out = in_plane(&plane);
    out[3] = a3;
    out
}

fn in_plane(v: &Vector3<f64>) -> Vector6<f64> {
    Vector6::new(v[0], v[1], v[2], 0.0, 0.0, 0.0)
}

/// Strains xx, yy, 2xy in the frame from those in axes rotated by `angle` from it.
pub fn turned_strain(e: Vector3<f64>, angle: f64) -> Vector3<f64> {
    strain_turn(-angle) * e
}

/// Stresses xx, yy, xy in the frame from those in axes rotated by `angle` from it.
pub fn turned_stress(s: Vector3<f64>, angle: f64) -> Vector3<f64> {
    strain_turn(angle).transpose() * s
}

/// Transformation of the strains xx, yy, 2xy, zz, 2xz, 2yz to axes rotated by `angle` about z.
fn turn_3d(angle: f64) -> Matrix6<f64> {
    let mut t = Matrix6::identity();
    t.fixed_view_mut::<3, 3>(0, 0).copy_from(&strain_turn(angle));
    t.fixed_view_mut::<2, 2>(4, 4).copy_from(&shear_turn(angle));
    t
}
