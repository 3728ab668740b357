//! Laminates: classical lamination theory of bonded plies, with first-order shear deformation.
//!
//! A fibre at height z along the director has the strain `ε(z) = ε − z κ`. With the reduced stiffness
//! Q̄(z) of the plies in common axes the resultants of the section are
//!
//! ```text
//! n =  ∫σ dz   = A ε + B κ      A =  ∫Q̄ dz     B = −∫Q̄ z dz
//! m = −∫σ z dz = Bᵀ ε + D κ     D =  ∫Q̄ z² dz
//! ```
//!
//! Textbooks mostly use the opposite sign of the curvature; their B is −B here, A and D are the same.
//! Source: Reddy, Mechanics of Laminated Composite Plates and Shells, 2nd ed. 2004, chapter 3.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

use super::ply::{Ply, shear_turn, strain_turn, turned_plane_stress, turned_shear};
use super::shear_correction::ShearProfile;
use super::{SectionInertia, SectionStiffness};

/// Errors in the definition of a laminate.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum LaminateError {
    /// The laminate has no plies.
    #[error("a laminate needs at least one ply")]
    Empty,
    /// A ply has invalid values.
    #[error("ply {} from the bottom: {what}", .ply + 1)]
    Ply {
        /// Index of the ply, from the bottom, counted from 0.
        ply: usize,
        /// Description of the mistake and of the valid values.
        what: &'static str,
    },
    /// The laminate as a whole has invalid values.
    #[error("{0}")]
    Whole(&'static str),
}

/// Laminate: plies bonded to each other, from the bottom (against the director) to the top.
///
/// The laminate has axes of its own: x along its 0° direction. The argument `turn` of the methods is their angle in the
/// cross-section frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Laminate {
    plies: Vec<Ply>,
    /// Heights above the laminate mid-plane of the bottom of each ply and of the top of the last (length).
    heights: Vec<f64>,
    /// Height of the laminate mid-plane above the reference surface (length).
    offset: f64,
    profile: ShearProfile,
    /// S in laminate axes [force/length].
    shear: Matrix2<f64>,
}

/// Strains and stresses of a ply at one height, in ply axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlyPoint {
    /// Height above the reference surface along the director (length).
    pub height: f64,
    /// Strains ε11, ε22, γ12.
    pub strain: Vector3<f64>,
    /// Stresses σ11, σ22, τ12 [force/area].
    pub stress: Vector3<f64>,
    /// Transverse shear strains γ13, γ23 that belong to `shear_stress`.
    pub shear_strain: Vector2<f64>,
    /// Transverse shear stresses τ13, τ23 [force/area]; continuous through the thickness.
    pub shear_stress: Vector2<f64>,
}

/// Strains and stresses of one ply at its faces and its middle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlyState {
    /// Bottom face of the ply (against the director).
    pub bottom: PlyPoint,
    /// Middle of the ply's thickness.
    pub middle: PlyPoint,
    /// Top face of the ply (towards the director).
    pub top: PlyPoint,
}

impl Laminate {
    /// Laminate of plies, bottom to top; the reference surface is at half of the total thickness. The transverse shear
    /// stiffness follows from the equilibrium of cylindrical bending of the layup: it contains the shear correction,
    /// and `S = 5/6 G h` for a homogeneous section.
    ///
    /// # Errors
    ///
    /// No plies; a ply whose thickness or stiffness is not positive.
    pub fn new(plies: Vec<Ply>) -> Result<Self, LaminateError> {
        if plies.is_empty() {
            return Err(LaminateError::Empty);
        }
        for (i, ply) in plies.iter().enumerate() {
            ply.check(i)?;
        }
        let total: f64 = plies.iter().map(|p| p.thickness).sum();
        let mut heights = vec![-0.5 * total];
        let mut below = 0.0;
        for p in &plies {
            below += p.thickness;
            heights.push(below - 0.5 * total);
        }
        let (profile, shear) = ShearProfile::new(&plies, &heights)
            .ok_or(LaminateError::Whole("the plies differ too much in stiffness to be computed together"))?;
        Ok(Self { plies, heights, offset: 0.0, profile, shear })
    }

    /// Moves the laminate: its mid-plane is at the height `offset` above the reference surface (length, along the
    /// director). With an offset of half the thickness the reference surface is the bottom face.
    ///
    /// # Errors
    ///
    /// `offset` is not a number.
    pub fn with_offset(mut self, offset: f64) -> Result<Self, LaminateError> {
        if !offset.is_finite() {
            return Err(LaminateError::Whole("the offset must be a number"));
        }
        self.offset = offset;
        Ok(self)
    }

    /// Replaces the layup's own shear correction by given factors c_xz, c_yz in laminate axes: `S = C (∫G dz) C` with
    /// `C = diag(√c_xz, √c_yz)`, which is `diag(c) ∫G dz` for cross-plies. 5/6 each is common in the literature of
    /// first-order shear deformation theory.
    ///
    /// # Errors
    ///
    /// A factor is not above 0.
    pub fn with_shear_correction(mut self, factors: [f64; 2]) -> Result<Self, LaminateError> {
        if factors.iter().any(|c| !(c.is_finite() && *c > 0.0)) {
            return Err(LaminateError::Whole("the shear correction factors must be above 0"));
        }
        let c = Matrix2::from_diagonal(&Vector2::new(factors[0].sqrt(), factors[1].sqrt()));
        self.shear = c * self.uncorrected_shear() * c;
        Ok(self)
    }

    /// The plies, bottom to top.
    pub fn plies(&self) -> &[Ply] {
        &self.plies
    }

    /// Total thickness h (length).
    pub fn thickness(&self) -> f64 {
        self.heights[self.plies.len()] - self.heights[0]
    }

    /// Height of the laminate mid-plane above the reference surface (length).
    pub fn offset(&self) -> f64 {
        self.offset
    }

    /// Uncorrected transverse shear stiffness ∫G dz in laminate axes [force/length], of a shear strain constant over
    /// the thickness.
    pub fn uncorrected_shear(&self) -> Matrix2<f64> {
        self.plies.iter().map(|p| turned_shear(&p.shear, p.angle) * p.thickness).sum()
    }

    /// Section stiffness A, B, D, S and Z per reference area in the cross-section frame.
    ///
    /// `turn` is the angle from x of the frame to the laminate's 0° direction, about the director, from x
    /// towards y (rad). `Z = ∫E3 dz`: the director stretches by the same strain at every height.
    pub fn stiffness(&self, turn: f64) -> SectionStiffness {
        let mut out = SectionStiffness {
            membrane: Matrix3::zeros(),
            coupling: Matrix3::zeros(),
            bending: Matrix3::zeros(),
            shear: self.shear,
            thickness: 0.0,
        };
        for (k, p) in self.plies.iter().enumerate() {
            let q = p.plane_stress_at(0.0);
            let (t, z) = (p.thickness, self.middle_of(k));
            out.membrane += q * t;
            out.coupling -= q * (t * z);
            out.bending += q * (t * z * z + t * t * t / 12.0);
            out.thickness += p.thickness_modulus * t;
        }
        if turn != 0.0 {
            out.membrane = turned_plane_stress(&out.membrane, turn);
            out.coupling = turned_plane_stress(&out.coupling, turn);
            out.bending = turned_plane_stress(&out.bending, turn);
            out.shear = turned_shear(&out.shear, turn);
        }
        out
    }

    /// Section inertia ∫ρ dz, ∫ρ z dz and ∫ρ z² dz per reference area.
    pub fn inertia(&self) -> SectionInertia {
        let mut out = SectionInertia { mass: 0.0, coupling: 0.0, rotary: 0.0 };
        for (k, p) in self.plies.iter().enumerate() {
            let (t, z) = (p.thickness, self.middle_of(k));
            out.mass += p.density * t;
            out.coupling += p.density * t * z;
            out.rotary += p.density * (t * z * z + t * t * t / 12.0);
        }
        out
    }

    /// Strains and stresses of every ply, bottom to top, in ply axes, from the strains `membrane` ε, `curvature` κ
    /// (engineering xy) and `shear` γ = (γ_xz, γ_yz) in the cross-section frame. For `turn` see
    /// [`Laminate::stiffness`].
    ///
    /// In the plane `ε(z) = ε − z κ` and `σ = Q ε(z)`. The transverse shear stress is that of equilibrium in
    /// cylindrical bending under the resultants `q = S γ`: continuous, zero at both faces, with the resultant q. It is
    /// far closer to the three-dimensional stress than `G γ`, which jumps between plies.
    pub fn recover(
        &self,
        turn: f64,
        membrane: &Vector3<f64>,
        curvature: &Vector3<f64>,
        shear: &Vector2<f64>,
    ) -> Vec<PlyState> {
        let resultant = self.shear * shear_turn(turn) * shear;
        let state = |(k, p): (usize, &Ply)| {
            let t = strain_turn(p.angle + turn);
            let point = |z: f64| {
                let height = z + self.offset;
                let strain = t * (membrane - curvature * height);
                let shear_stress = self.shear_in_ply(k, z, &resultant);
                // `Laminate::new` has checked that the shear moduli have an inverse.
                let flexibility = p.shear.try_inverse().unwrap_or_else(Matrix2::zeros);
                PlyPoint {
                    height,
                    strain,
                    stress: p.plane_stress * strain,
                    shear_strain: flexibility * shear_stress,
                    shear_stress,
                }
            };
            let (bottom, top) = (self.heights[k], self.heights[k + 1]);
            PlyState { bottom: point(bottom), middle: point(0.5 * (bottom + top)), top: point(top) }
        };
        self.plies.iter().enumerate().map(state).collect()
    }

    /// Transverse shear stresses τ13, τ23 of ply k at a height above the reference surface, in its own axes, which equilibrium over the thickness makes of
    /// the shear forces q of a frame from whose x axis the 0° direction is turned by `turn` (rad).
    pub fn shear_stress(
        &self,
        turn: f64,
        (k, height): (usize, f64),
        q: &Vector2<f64>,
    ) -> Option<Vector2<f64>> {
        (k < self.plies.len()).then(|| self.shear_in_ply(k, height - self.offset, &(shear_turn(turn) * q)))
    }

    /// Transverse shear stresses of ply k at a height above the middle, in its own axes, of shear forces in the axes of the section.
    fn shear_in_ply(&self, k: usize, z: f64, resultant: &Vector2<f64>) -> Vector2<f64> {
        let ply = &self.plies[k];
        shear_turn(ply.angle) * self.profile.at(ply, k, &self.heights, z) * resultant
    }

    /// Height of the mid-plane of ply k above the reference surface.
    fn middle_of(&self, k: usize) -> f64 {
        0.5 * (self.heights[k] + self.heights[k + 1]) + self.offset
    }
}
