//! Compiled section of the model: layers, material laws and section stiffness. Its integration points in an element are
//! made in `element/section_points.rs`.

use nalgebra::{DMatrix, DVector, Matrix2, Matrix6, SMatrix, SVector, Vector2, Vector3, Vector6};

use super::laminate::Laminate;
use super::ply::{angle_in_plane, shear_turn, strain_turn, turned_plane_stress, turned_shear};
use super::quadrature::{gauss, lobatto};
use super::{SectionInertia, SectionStiffness};
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
    /// Height of the middle of the layers above the mesh (length).
    pub offset: f64,
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
    /// Coefficient α of the stabilisation factor `h²/(h² + α l²)` of transverse shear.
    pub shear_stabilization: f64,
    /// True if every layer is isotropic in the surface, and the shear correction factors are the same.
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
        self.laws.iter().any(Law::is_hyperelastic)
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

    /// True if stiffness or strengths of a layer depend on the section's direction, which then must not be normal to the surface.
    pub fn is_directed(&self) -> bool {
        let differ = |l: &Layer| l.material.strength().is_some_and(|s| !s.is_isotropic());
        !self.isotropic || self.layers.iter().any(differ)
    }

    /// Angle from the x axis of a cross-section frame to the first axis of a layer, in which its stresses are given and its strengths hold. Unlike
    /// that of [`Self::layer_turn`] it counts from the section's direction also where the stiffness does not depend on it. Where that is normal to
    /// the surface, which only sections may have that are not [directed](Self::is_directed), it counts from the x axis of the frame.
    pub fn layer_axis(&self, layer: &Layer, frame: &Mat3) -> f64 {
        Self::angle(frame, &self.direction).unwrap_or(0.0) + layer.angle
    }

    pub(crate) fn turn(&self, frame: &Mat3) -> Result<f64, String> {
        if self.isotropic { Ok(0.0) } else { Self::angle(frame, &self.direction) }
    }

    /// Three-dimensional stiffness of a layer at zero strain, in axes from which its first axis is rotated by `turn`,
    /// with shear correction factors.
    pub fn stiffness_3d(&self, layer: &Layer, turn: f64) -> Matrix6<f64> {
        let law = layer.material.law_3d();
        let mut zero = [0.0; 16];
        let zero = &mut zero[..law.history()];
        let committed = zero.to_vec();
        let mut c = law.respond(&Vector6::zeros(), &committed, zero).map_or(Matrix6::zeros(), |r| r.tangent);
        let turned = |c: Matrix6<f64>, angle: f64| {
            let t = turn_3d(angle);
            t.transpose() * c * t
        };
        let [x, y] = self.shear_factors;
        // The factors belong to the axes of the section, from which the layer is rotated by its angle.
        let first = if x == y { turn } else { layer.angle };
        if !layer.material.is_isotropic() {
            c = turned(c, first);
        }
        for (i, factor) in [x, y].into_iter().enumerate() {
            let root = factor.sqrt();
            for j in 0..6 {
                c[(4 + i, j)] *= root;
                c[(j, 4 + i)] *= root;
            }
        }
        if x == y { c } else { turned(c, turn - layer.angle) }
    }

    /// Prescribed strain of a layer at the height `z`; a prestress σ counts as the strain −C⁻¹σ.
    pub(crate) fn strain_3d(
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
                // Moments are given about the mesh; stresses are linear about the middle of the layers.
                let force = Vector3::from(p.membrane);
                let moment = Vector3::from(p.bending) + force * self.offset;
                let at = force / h - moment * (12.0 * (z - self.offset) / h.powi(3));
                let stress = in_plane(&turned_stress(at, angle));
                -stiffness.lu().solve(&stress).ok_or("its stiffness is singular")?
            }
        };
        Ok(DVector::from_column_slice(strain.as_slice()))
    }

    /// Energy per area of the self-equilibrated stresses that heated layers of different expansion leave in each other, in
    /// plane stress and by pairs of fields: `∫ε₀ᵀQ ε₀ dz − x₀ᵀ D x₀` with the thermal strains ε₀ of the layers and the section
    /// strains x₀ that take them up on the average. Other fields are given for the section as a whole and leave none. `turn`
    /// is the angle of the section's direction.
    ///
    /// # Errors
    /// The section's stiffness is singular.
    pub(crate) fn residual_energy(
        &self,
        prescribed: &[Option<&PrescribedStrain>],
        turn: f64,
    ) -> Result<DMatrix<f64>, String> {
        let heat: Vec<Option<[f64; 2]>> = prescribed
            .iter()
            .map(|field| match field {
                Some(PrescribedStrain::Thermal(t)) => Some([t.temperature, t.gradient]),
                _ => None,
            })
            .collect();
        if self.layers.len() < 2 || heat.iter().all(Option::is_none) {
            return Ok(DMatrix::zeros(0, 0));
        }
        // Stress resultants (membrane, then bending) of a temperature 1 and of a gradient 1, and their energies.
        let mut held_back = SMatrix::<f64, 6, 2>::zeros();
        let mut energy = Matrix2::<f64>::zeros();
        for layer in &self.layers {
            let [z0, z1, z2] = layer.moments();
            let alpha = expansion(&layer.material, turn + layer.angle);
            let stress = plane_stress_3d(&layer.material, turn + layer.angle) * alpha;
            let (stress, alpha) = (stress.fixed_rows::<3>(0), alpha.fixed_rows::<3>(0));
            energy += Matrix2::new(z0, z1, z1, z2) * stress.dot(&alpha);
            for (c, [force, moment]) in [[z0, z1], [z1, z2]].into_iter().enumerate() {
                let mut column = held_back.column_mut(c);
                column.fixed_rows_mut::<3>(0).axpy(force, &stress, 1.0);
                column.fixed_rows_mut::<3>(3).axpy(-moment, &stress, 1.0);
            }
        }
        let section = self.resultant.at(turn);
        let mut d = Matrix6::zeros();
        d.fixed_view_mut::<3, 3>(0, 0).copy_from(&section.membrane);
        d.fixed_view_mut::<3, 3>(0, 3).copy_from(&section.coupling);
        d.fixed_view_mut::<3, 3>(3, 0).copy_from(&section.coupling.transpose());
        d.fixed_view_mut::<3, 3>(3, 3).copy_from(&section.bending);
        let taken_up = d.lu().solve(&held_back).ok_or("the section's stiffness is singular")?;
        energy -= held_back.transpose() * taken_up;
        let pair = |i: usize, j: usize| match (heat[i], heat[j]) {
            (Some(a), Some(b)) => Vector2::from(a).dot(&(energy * Vector2::from(b))),
            _ => 0.0,
        };
        Ok(DMatrix::from_fn(heat.len(), heat.len(), pair))
    }

    /// Prescribed section strains ε, ε_zz, γ, κ, conjugate to the stress resultants.
    pub(crate) fn resultant_strain(
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

/// Stiffness of a material: plane stress in xx, yy, xy; uncoupled E in zz and transverse shear moduli.
pub(crate) fn plane_stress_3d(material: &Material, turn: f64) -> Matrix6<f64> {
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
