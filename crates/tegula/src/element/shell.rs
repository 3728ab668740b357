//! Interface of a shell element type, and the builder of its element groups, with static condensation.
//!
//! An element type consists of its table of sampled strains and of strain operators at any height over a few points of
//! its mid-surface. Sections and materials make integration points of them ([`IntegrationPoint`]), the terms of the element's
//! energy; static condensation of the enhanced parameters takes place here, once, where all materials are linear.

use std::fmt::Debug;

use nalgebra::{DMatrix, DVector};

use super::VectorKind;
use super::bilinear::{BilinearGroup, BilinearMembers};
use super::curved_strain::ReferenceMetric;
use super::forms::Forms;
use super::generalized_law::LinearLaw;
use super::geometry::ShellGeometry;
use super::group::ElementGroup;
use super::points::{PointElement, PointLaw};
use super::quadratic::{Members, QuadraticGroup};
use super::strains::SampledStrains;
use super::transform::NodalTransform;
use crate::Mat3;
use crate::material::Law;
use crate::section::SectionInertia;

/// Strain operator at a point of an element: strains from sampled strains and enhanced parameters.
#[derive(Debug, Clone)]
pub struct StrainOperator {
    /// Rows ε_xx, ε_yy, 2ε_xy, ε_zz, 2ε_xz, 2ε_yz in the frame; columns are the sampled strains.
    pub samples: DMatrix<f64>,
    /// Rows as in `samples`; columns are the enhanced parameters.
    pub enhanced: DMatrix<f64>,
    /// Orthonormal frame, z along the director.
    pub frame: Mat3,
    /// Reference area (volume per height for solid elements) that the point stands for.
    pub measure: f64,
}

/// A shell element type.
pub trait ShellElement: Debug + Send + Sync {
    /// Name in model files.
    fn name(&self) -> &'static str;
    /// Number of sampled strains.
    fn samples(&self) -> usize;
    /// Number of enhanced parameters.
    fn parameters(&self) -> usize;
    /// This element without enhanced in-plane strains; `None` if it has none.
    fn without_enhanced_strains(&self) -> Option<Box<dyn ShellElement>> {
        None
    }
    /// True if stresses are three-dimensional and integrated over the thickness; false if the element works with the
    /// stress resultants of a section in plane stress.
    fn is_solid(&self) -> bool;
    /// Kinds of the vectors of a node, position first.
    fn nodal_vectors(&self) -> &'static [VectorKind] {
        &[VectorKind::Position, VectorKind::Director]
    }
    /// True if directors are inextensible.
    fn unit_directors(&self) -> bool {
        false
    }
    /// True if the element supports only one layer of a linear material with two integration points over the thickness.
    fn takes_linear_sheets_only(&self) -> bool {
        false
    }
    /// Number of integration points over the mid-surface.
    fn surface_points(&self) -> usize {
        4
    }
    /// Strain operator at the height `z` over a point of the mid-surface.
    ///
    /// # Errors
    /// The geometry is invalid there; the text says how.
    fn operator(&self, g: &ShellGeometry, point: usize, z: f64) -> Result<StrainOperator, String>;
    /// Gradient of the thickness strain ε_zz along the first two axes of the frame, from the sampled strains, for
    /// elements that work with stress resultants. `z ∇ε_zz` is the part of the transverse shear that is linear in z.
    fn stretch_gradient(&self, _g: &ShellGeometry, _point: usize) -> Option<DMatrix<f64>> {
        None
    }
    /// Metric and curvature of the reference over a point of the mid-surface, for elements that work with stress resultants and
    /// whose bending strain changes where a curved surface stretches. Prescribed strains of the others have no part due to
    /// curvature.
    ///
    /// # Errors
    /// The geometry is invalid there; the text says how.
    fn reference_metric(&self, _g: &ShellGeometry, _point: usize) -> Result<Option<ReferenceMetric>, String> {
        Ok(None)
    }
    /// Stabilisation stiffness of the last enhanced parameters, per ∫E dz over the thickness; empty if they have none.
    fn parameter_stiffness(&self, _g: &ShellGeometry) -> Vec<f64> {
        Vec::new()
    }
    /// Consistent mass: one scalar per pair of nodal vectors, lower triangle by rows.
    fn mass(&self, g: &ShellGeometry, inertia: &SectionInertia) -> Vec<f64>;
    /// Builder that collects the elements of a section.
    fn builder(&self, setup: GroupSetup) -> Box<dyn GroupBuilder>;
}

/// Data that the elements of a group share.
#[derive(Debug, Clone, Default)]
pub struct GroupSetup {
    /// Retardation time τ of Kelvin–Voigt damping.
    pub retardation_time: f64,
    /// Material laws that integration points refer to.
    pub laws: Vec<Law>,
    /// Number of prescribed strain fields that act on the group, or 0.
    pub fields: usize,
    /// Uses the general kernel, which serves every element type, where a faster one would be chosen: the reference for
    /// tests.
    pub reference_kernel: bool,
}

/// Integration point: a term `w ψ(L s + G α − Σ f ε₀)` of an element's energy.
#[derive(Debug, Clone)]
pub struct IntegrationPoint {
    /// L: strains from the sampled strains s.
    pub samples: DMatrix<f64>,
    /// G: strains from the enhanced parameters α.
    pub enhanced: DMatrix<f64>,
    /// Material response ψ.
    pub response: PointResponse,
    /// w: integration weight.
    pub weight: f64,
    /// ε₀ of each prescribed strain field.
    pub prescribed: Vec<DVector<f64>>,
    /// Energy of the self-equilibrated stresses that the prescribed strain fields leave between layers, per weight and by
    /// pairs of fields; empty where there is none.
    pub residual_energy: DMatrix<f64>,
}

/// Material response of an integration point.
#[derive(Debug, Clone)]
pub enum PointResponse {
    /// Linear elastic: `½ εᵀ C ε − σ₀·ε` per prescribed strain field, with `σ₀ = C ε₀`.
    Linear(DMatrix<f64>),
    /// Material law of the group, by index; it takes six strains.
    Law(usize),
}

/// Element to be added to a group.
#[derive(Debug)]
pub struct Member<'a> {
    /// Connectivity: nodal vectors of the element.
    pub vectors: &'a [u32],
    /// Reference geometry of the element.
    pub geometry: &'a ShellGeometry,
    /// Integration points, the terms of the element's energy.
    pub integration_points: Vec<IntegrationPoint>,
    /// Mass: one scalar per pair of nodal vectors, lower triangle by rows.
    pub mass: Vec<f64>,
}

/// Builder of element groups.
pub trait GroupBuilder {
    /// Adds an element.
    ///
    /// # Errors
    /// The enhanced strains of the element are linearly dependent.
    fn push(&mut self, member: Member) -> Result<(), String>;
    /// Adds an element that is congruent to element `first` (moved and rotated as a rigid body) and shares its
    /// stiffness; false if each element of this group has to be added individually.
    fn push_like(&mut self, _first: usize, _vectors: &[u32], _geometry: &ShellGeometry) -> bool {
        false
    }
    /// Finished groups; element `e` is the same element in each.
    fn finish(self: Box<Self>) -> Vec<Box<dyn ElementGroup>>;
}

/// Statically condensed stiffness of an element with linear materials.
#[derive(Debug, Clone)]
pub struct Condensed {
    /// `H` of the energy `½ sᵀHs`.
    pub stiffness: DMatrix<f64>,
    /// `−K_αα⁻¹ K_αs`: enhanced parameters α from the sampled strains.
    pub recovery: DMatrix<f64>,
    /// Generalised stress of each prescribed strain field when fully restrained.
    pub prescribed: Vec<DVector<f64>>,
    /// α of each prescribed strain field.
    pub prescribed_parameters: Vec<DVector<f64>>,
    /// Energy of the prescribed strain fields when fully restrained, by pairs of fields.
    pub prescribed_energy: DMatrix<f64>,
}

/// Static condensation: sums the linear integration points and eliminates α, `H ← H − K_αsᵀ K_αα⁻¹ K_αs`.
///
/// # Errors
/// K_αα is not positive definite.
pub fn condense(
    integration_points: &[IntegrationPoint],
    samples: usize,
    parameters: usize,
    fields: usize,
) -> Result<Condensed, String> {
    let mut h = DMatrix::zeros(samples, samples);
    let mut k_aa = DMatrix::zeros(parameters, parameters);
    let mut k_as = DMatrix::zeros(parameters, samples);
    let mut n = vec![DVector::zeros(samples); fields];
    let mut n_alpha = vec![DVector::zeros(parameters); fields];
    let mut energy = DMatrix::zeros(fields, fields);
    for s in integration_points {
        let PointResponse::Linear(c) = &s.response else { continue };
        let cl = c * &s.samples * s.weight;
        h += s.samples.transpose() * &cl;
        if parameters > 0 {
            k_aa += s.enhanced.transpose() * (c * &s.enhanced) * s.weight;
            k_as += s.enhanced.transpose() * &cl;
        }
        if !s.residual_energy.is_empty() {
            energy += &s.residual_energy * s.weight;
        }
        for (i, e0) in s.prescribed.iter().enumerate() {
            let stress = c * e0 * s.weight;
            n[i] += s.samples.transpose() * &stress;
            n_alpha[i] += s.enhanced.transpose() * &stress;
            for (j, other) in s.prescribed.iter().enumerate() {
                energy[(i, j)] += stress.dot(other);
            }
        }
    }
    let mut recovery = DMatrix::zeros(parameters, samples);
    let mut prescribed_parameters = vec![DVector::zeros(parameters); fields];
    if parameters > 0 {
        let inverse = k_aa.cholesky().ok_or("its enhanced strains are not independent")?;
        recovery = -inverse.solve(&k_as);
        h += k_as.transpose() * &recovery;
        for i in 0..fields {
            prescribed_parameters[i] = inverse.solve(&n_alpha[i]);
            n[i] -= k_as.transpose() * &prescribed_parameters[i];
        }
        for i in 0..fields {
            for j in 0..fields {
                energy[(i, j)] -= n_alpha[i].dot(&prescribed_parameters[j]);
            }
        }
    }
    // Round-off leaves H unsymmetric in the last digit; the tangent must be symmetric.
    let h = (&h + h.transpose()) * 0.5;
    Ok(Condensed { stiffness: h, recovery, prescribed: n, prescribed_parameters, prescribed_energy: energy })
}

/// Builder of one [`QuadraticGroup`].
pub struct QuadraticBuilder<const M: usize, const N: usize, const S: usize, const D: usize> {
    name: &'static str,
    strains: SampledStrains<M, N, S, D>,
    parameters: usize,
    setup: GroupSetup,
    members: Members<M>,
    linear: LinearLaw<S>,
    points: Vec<PointElement>,
    /// Data of the bilinear kernel where it applies: forms of the element type, and elements in place of `linear`.
    bilinear: Option<(Forms, BilinearMembers)>,
}

impl<const M: usize, const N: usize, const S: usize, const D: usize> QuadraticBuilder<M, N, S, D> {
    /// Builder for elements with the given sampled strains.
    pub fn new(
        name: &'static str,
        strains: SampledStrains<M, N, S, D>,
        parameters: usize,
        setup: GroupSetup,
    ) -> Self {
        let fields = setup.fields;
        let linear = LinearLaw { fields, ..LinearLaw::default() };
        let bilinear = Forms::of(&strains)
            .filter(|_| setup.laws.is_empty() && !setup.reference_kernel)
            .map(|forms| (forms, BilinearMembers { fields, ..BilinearMembers::default() }));
        let (members, points) = (Members::default(), Vec::new());
        Self { name, strains, parameters, setup, members, linear, points, bilinear }
    }

    /// Adds the nodal transformation of the next element.
    pub fn push_transform(&mut self, transform: NodalTransform<M>) {
        self.members.transforms.push(transform);
    }
}

impl<const M: usize, const N: usize, const S: usize, const D: usize> GroupBuilder
    for QuadraticBuilder<M, N, S, D>
{
    fn push(&mut self, member: Member) -> Result<(), String> {
        if let Some((forms, members)) = &mut self.bilinear {
            let c = condense(&member.integration_points, S, self.parameters, self.setup.fields)?;
            let vectors =
                member.vectors.try_into().map_err(|_| "it has not the nodal vectors of its type")?;
            members.push(forms, vectors, member.geometry, &c, &member.mass);
            return Ok(());
        }
        if self.setup.laws.is_empty() {
            let c = condense(&member.integration_points, S, self.parameters, self.setup.fields)?;
            // Symmetric, so columns serve as rows.
            self.linear.h.extend_from_slice(c.stiffness.as_slice());
            for n in &c.prescribed {
                self.linear.prescribed.extend_from_slice(n.as_slice());
            }
            self.linear.prescribed_energy.extend_from_slice(c.prescribed_energy.as_slice());
        } else {
            self.points.push(PointElement::new(
                member.integration_points,
                S,
                self.parameters,
                self.setup.fields,
            ));
        }
        self.members.vectors.push(std::array::from_fn(|a| member.vectors[a]));
        self.members.mass.extend_from_slice(&member.mass);
        Ok(())
    }

    fn push_like(&mut self, first: usize, vectors: &[u32], geometry: &ShellGeometry) -> bool {
        match (&mut self.bilinear, vectors.try_into()) {
            (Some((_, members)), Ok(vectors)) => members.push_like(first, vectors, geometry),
            _ => false,
        }
    }

    fn finish(self: Box<Self>) -> Vec<Box<dyn ElementGroup>> {
        let tau = self.setup.retardation_time;
        if let Some((forms, members)) = self.bilinear {
            return vec![Box::new(BilinearGroup::new(self.name, forms, members, tau))];
        }
        if self.setup.laws.is_empty() {
            vec![Box::new(QuadraticGroup::new(self.name, self.strains, self.members, self.linear, tau))]
        } else {
            let points = PointLaw::<S>::new(self.setup.laws, self.points, self.parameters);
            vec![Box::new(QuadraticGroup::new(self.name, self.strains, self.members, points, tau))]
        }
    }
}
