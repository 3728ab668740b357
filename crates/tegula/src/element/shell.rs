//! What a shell element type gives to the program.
//!
//! An element type is its table of sampled strains and the strains at any height over a few points
//! of its mid-surface. Sections and materials turn them into [`Station`]s, the terms of the
//! element's energy; enhanced strains are eliminated here, once where all materials are linear.

use std::fmt::Debug;

use nalgebra::{DMatrix, DVector};

use super::bilinear::{BilinearGroup, BilinearMembers};
use super::constitution::LinearConstitution;
use super::forms::Forms;
use super::geometry::ShellGeometry;
use super::group::ElementGroup;
use super::points::{PointConstitution, PointElement};
use super::quadratic::{Members, QuadraticGroup};
use super::strains::SampledStrains;
use super::transform::NodalTransform;
use crate::Mat3;
use crate::material::Law;
use crate::section::SectionInertia;
use crate::system::VectorKind;

/// Strains at a point of an element.
#[derive(Debug, Clone)]
pub struct StrainOperator {
    /// Rows ε_xx, ε_yy, 2ε_xy, ε_zz, 2ε_xz, 2ε_yz in the frame; columns are the samples.
    pub samples: DMatrix<f64>,
    /// The same for the enhanced parameters.
    pub enhanced: DMatrix<f64>,
    /// Orthonormal frame, z along the director.
    pub frame: Mat3,
    /// Reference area (per height: volume) that the point stands for.
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
    /// The same element without enhanced in-plane strains; `None` if it has none.
    fn without_enhanced_strains(&self) -> Option<Box<dyn ShellElement>> {
        None
    }
    /// True if stresses are three-dimensional and integrated over the thickness; false if the element
    /// works with resultants of a section in plane stress.
    fn is_solid(&self) -> bool;
    /// Kinds of the vectors of a node, position first.
    fn nodal_vectors(&self) -> &'static [VectorKind] {
        &[VectorKind::Position, VectorKind::Director]
    }
    /// True if directors keep their length.
    fn unit_directors(&self) -> bool {
        false
    }
    /// True if it computes nothing but one layer of a linear material with two points over the thickness.
    fn takes_linear_sheets_only(&self) -> bool {
        false
    }
    /// Number of integration points over the mid-surface.
    fn surface_points(&self) -> usize {
        4
    }
    /// Strains at the height `z` over a point of the mid-surface.
    ///
    /// # Errors
    /// The geometry is invalid there; the text says how.
    fn operator(&self, g: &ShellGeometry, point: usize, z: f64) -> Result<StrainOperator, String>;
    /// Gradient of the stretch of the thickness along the first two axes of the frame, from the samples, for elements
    /// that work with resultants. `z ∇ε_zz` is the part of the transverse shear that is linear in z.
    fn stretch_gradient(&self, _g: &ShellGeometry, _point: usize) -> Option<DMatrix<f64>> {
        None
    }
    /// Stiffness of the last enhanced parameters per modulus over the thickness, ∫E dz; empty if they have none of their
    /// own.
    fn parameter_stiffness(&self, _g: &ShellGeometry) -> Vec<f64> {
        Vec::new()
    }
    /// Scalar mass of the lower triangle of pairs of nodal vectors.
    fn mass(&self, g: &ShellGeometry, inertia: &SectionInertia) -> Vec<f64>;
    /// Collects the elements of a section.
    fn builder(&self, setup: GroupSetup) -> Box<dyn GroupBuilder>;
}

/// What the elements of a group have in common.
#[derive(Debug, Clone, Default)]
pub struct GroupSetup {
    /// Retardation time of rate damping.
    pub retardation_time: f64,
    /// Laws that stations refer to.
    pub laws: Vec<Law>,
    /// Number of fields of prescribed strain that act on the group, or 0.
    pub fields: usize,
    /// Use the kernel that serves every element type where a faster one would be chosen: its reference.
    pub reference_kernel: bool,
}

/// A term of an element's energy: `w ψ(L s + G α − Σ f ε₀)`.
#[derive(Debug, Clone)]
pub struct Station {
    /// L.
    pub samples: DMatrix<f64>,
    /// G.
    pub enhanced: DMatrix<f64>,
    /// Material.
    pub response: StationResponse,
    /// w.
    pub weight: f64,
    /// ε₀ of each field of prescribed strain.
    pub prescribed: Vec<DVector<f64>>,
}

/// Material of a station.
#[derive(Debug, Clone)]
pub enum StationResponse {
    /// `½ εᵀ C ε − σ₀·ε` per field of prescribed strain, with `σ₀ = C ε₀`.
    Linear(DMatrix<f64>),
    /// A law of the group by its number; six strains.
    Law(usize),
}

/// One element to be added to a group.
#[derive(Debug)]
pub struct Member<'a> {
    /// Its nodal vectors.
    pub vectors: &'a [u32],
    /// Its geometry.
    pub geometry: &'a ShellGeometry,
    /// Its energy.
    pub stations: Vec<Station>,
    /// Lower triangle of its scalar mass.
    pub mass: Vec<f64>,
}

/// Collects elements.
pub trait GroupBuilder {
    /// Adds an element.
    ///
    /// # Errors
    /// Its enhanced strains are not independent.
    fn push(&mut self, member: Member) -> Result<(), String>;
    /// Adds an element that is member `first` moved and turned as a rigid body; false if each element of this group has
    /// to be pushed by itself.
    fn push_like(&mut self, _first: usize, _vectors: &[u32], _geometry: &ShellGeometry) -> bool {
        false
    }
    /// The groups; element `e` is member `e` of each.
    fn finish(self: Box<Self>) -> Vec<Box<dyn ElementGroup>>;
}

/// Stiffness of an element with linear materials, enhanced parameters eliminated.
#[derive(Debug, Clone)]
pub struct Condensed {
    /// `H` of the energy `½ sᵀHs`.
    pub stiffness: DMatrix<f64>,
    /// `−K_αα⁻¹ K_αs`: α from the samples.
    pub recovery: DMatrix<f64>,
    /// Stress of each field of prescribed strain, held back.
    pub prescribed: Vec<DVector<f64>>,
    /// α of each field of prescribed strain.
    pub prescribed_parameters: Vec<DVector<f64>>,
    /// Energy of pairs of fields.
    pub prescribed_energy: DMatrix<f64>,
}

/// Sums linear stations and eliminates α: `H ← H − K_αsᵀ K_αα⁻¹ K_αs`.
///
/// # Errors
/// K_αα is not positive definite.
pub fn condense(
    stations: &[Station],
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
    for s in stations {
        let StationResponse::Linear(c) = &s.response else { continue };
        let cl = c * &s.samples * s.weight;
        h += s.samples.transpose() * &cl;
        if parameters > 0 {
            k_aa += s.enhanced.transpose() * (c * &s.enhanced) * s.weight;
            k_as += s.enhanced.transpose() * &cl;
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
    // Rounding leaves H unsymmetric in the last digit; the tangent must be symmetric.
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
    linear: LinearConstitution<S>,
    points: Vec<PointElement>,
    /// Where the faster kernel serves: the forms of the element type, and what it takes in place of `linear`.
    bilinear: Option<(Forms, BilinearMembers)>,
}

impl<const M: usize, const N: usize, const S: usize, const D: usize> QuadraticBuilder<M, N, S, D> {
    /// For elements with the given strains.
    pub fn new(
        name: &'static str,
        strains: SampledStrains<M, N, S, D>,
        parameters: usize,
        setup: GroupSetup,
    ) -> Self {
        let fields = setup.fields;
        let linear = LinearConstitution { fields, ..LinearConstitution::default() };
        let bilinear = Forms::of(&strains)
            .filter(|_| setup.laws.is_empty() && !setup.reference_kernel)
            .map(|forms| (forms, BilinearMembers { fields, ..BilinearMembers::default() }));
        let (members, points) = (Members::default(), Vec::new());
        Self { name, strains, parameters, setup, members, linear, points, bilinear }
    }

    /// Adds the map of the element pushed next.
    pub fn push_transform(&mut self, transform: NodalTransform<M>) {
        self.members.transforms.push(transform);
    }
}

impl<const M: usize, const N: usize, const S: usize, const D: usize> GroupBuilder
    for QuadraticBuilder<M, N, S, D>
{
    fn push(&mut self, member: Member) -> Result<(), String> {
        if let Some((forms, members)) = &mut self.bilinear {
            let c = condense(&member.stations, S, self.parameters, self.setup.fields)?;
            let vectors =
                member.vectors.try_into().map_err(|_| "it has not the nodal vectors of its type")?;
            members.push(forms, vectors, member.geometry, &c, &member.mass);
            return Ok(());
        }
        if self.setup.laws.is_empty() {
            let c = condense(&member.stations, S, self.parameters, self.setup.fields)?;
            // Symmetric, so columns serve as rows.
            self.linear.h.extend_from_slice(c.stiffness.as_slice());
            for n in &c.prescribed {
                self.linear.prescribed.extend_from_slice(n.as_slice());
            }
            self.linear.prescribed_energy.extend_from_slice(c.prescribed_energy.as_slice());
        } else {
            self.points.push(PointElement::new(member.stations, S, self.parameters, self.setup.fields));
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
            let points = PointConstitution::<S>::new(self.setup.laws, self.points, self.parameters);
            vec![Box::new(QuadraticGroup::new(self.name, self.strains, self.members, points, tau))]
        }
    }
}
