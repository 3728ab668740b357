//! Motions about an equilibrium under loads without a potential that grow, among the lowest modes, as a path looks for them at each of its equilibria.
//!
//! The modes of K of an equilibrium nearby tell where this cannot be: one step of inverse iteration, `X = K⁻¹ M Φ`, brings them to those of the equilibrium
//! at hand, whose eigenvalues on this space are exact but for the square of the error of X. Where they stay real and positive with N enlarged by half, no motion grows.

use super::complex_modes::{self, SkewParts};
use super::problem::Problem;
use super::spinning::Spin;
use super::{COUPLED, Mode, circulatory, dot, lowest_modes};
use crate::analysis::{Silent, State};
use crate::element::Nodal;
use crate::system::{CirculatoryStiffness, LocalFrames, System};
use crate::{Error, Result};
use nalgebra::{Complex, DMatrix};

/// Lowest modes among which motions that grow are looked for.
const WATCHED: usize = 6;
/// Factor on N with which eigenvalues that stay real and positive tell that no motion grows.
const MARGIN: f64 = 1.5;
/// Change of an eigenvalue over it since the modes were found, above which they are found anew: others may be among the lowest ones.
const CHANGED: f64 = 0.2;
/// Imaginary part of an eigenvalue over its size that is round-off.
const ROUND_OFF: f64 = 1e-9;

/// Motion about an equilibrium that grows.
pub struct GrowingMotion {
    /// Growth rate [1/time].
    pub growth: f64,
    /// Circular frequency [rad/time]; 0 where it does not vibrate.
    pub omega: f64,
    /// Number of all motions found that grow without vibrating: of real negative eigenvalues ω².
    pub divergent: usize,
    /// Real part of the complex mode in all nodal vectors.
    pub shape: Vec<Nodal>,
}

/// Lowest modes without the circulatory stiffness, with their eigenvalues ω².
pub struct KnownModes(Vec<(f64, Vec<Nodal>)>);

/// Solution with the symmetric tangent in place of the right side, in free degrees of freedom.
pub type SolveAtRest<'a> = dyn FnMut(&mut [f64]) -> std::result::Result<(), String> + 'a;

/// The motion about an equilibrium under follower loads that grows most, a vibration where one grows, among the lowest modes, and the modes that tell it of equilibria nearby; `None` where
/// none grows, the loads have a potential or the model has no mass.
///
/// # Errors
/// The modes are not found, or parts of the model have no mass.
pub fn growing_motion(system: &System, state: &State) -> Result<(Option<GrowingMotion>, Option<KnownModes>)> {
    if !(system.total_mass() > 0.0) {
        return Ok((None, None));
    }
    let Some(stiffness) = circulatory::stiffness(system, state) else { return Ok((None, None)) };
    circulatory::refuse_loads_of_unknown_stiffness(system, state)?;
    let mut problem = Problem::new(system, Some(state))?;
    if problem.pattern.diagonal(&problem.mass).any(|mass| !(mass > 0.0)) {
        return Err(Error::NotConverged {
            at: "the modes".into(),
            reason: "parts of the model have no mass, and complex modes are not found without (give their density)".into(),
            help: String::new(),
        });
    }
    if let Some(spin) = Spin::of(system, state.time).filter(|spin| spin.omega != 0.0) {
        let parts = SkewParts { spin: Some(spin), circulatory: Some(stiffness) };
        let found = complex_modes::modes(&mut problem, (WATCHED, COUPLED, &parts), None, &mut Silent)?;
        return Ok((most_growing(found.modes), None));
    }
    let (found, _) = lowest_modes(&mut problem, (WATCHED, COUPLED), &mut Silent)?;
    let elastic = found.modes.iter().filter(|mode| !mode.rigid);
    let known = elastic.map(|mode| (mode.omega * mode.omega.abs(), mode.shape.clone())).collect();
    let mut growing = None;
    if circulatory::matters(&mut problem, &stiffness, &found.modes, WATCHED)? {
        let parts = SkewParts { spin: None, circulatory: Some(stiffness) };
        let found =
            complex_modes::modes(&mut problem, (WATCHED, COUPLED, &parts), Some(found.modes), &mut Silent)?;
        growing = most_growing(found.modes);
    }
    Ok((growing, Some(KnownModes(known))))
}

/// The one of complex modes that grows most, a vibration where one grows.
fn most_growing(modes: Vec<Mode>) -> Option<GrowingMotion> {
    let growth = |mode: &Mode| mode.complex.as_ref().map_or(0.0, |part| part.growth);
    let growing: Vec<Mode> = modes.into_iter().filter(|mode| growth(mode) > 0.0).collect();
    let divergent = growing.iter().filter(|mode| mode.omega == 0.0).count();
    let rank = |mode: &Mode| (mode.omega != 0.0, growth(mode));
    let most = growing.into_iter().max_by(|a, b| {
        let (a, b) = (rank(a), rank(b));
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
    })?;
    Some(GrowingMotion { growth: growth(&most), omega: most.omega, divergent, shape: most.shape })
}

impl KnownModes {
    /// Whether no motion about an equilibrium nearby grows, by the modes of this one: `solve` has the factored tangent of the equilibrium there, in its
    /// local frames. False where this is not certain.
    pub fn exclude_growth(
        &self,
        system: &System,
        state: &State,
        (frames, solve): (&LocalFrames, &mut SolveAtRest),
    ) -> bool {
        let Some(skew) = circulatory::stiffness(system, state) else { return true };
        if self.0.is_empty() {
            return false;
        }
        let n = system.unknowns();
        let mut vectors: Vec<(Vec<f64>, Vec<f64>)> = Vec::with_capacity(self.0.len());
        for (_, shape) in &self.0 {
            // M φ and K⁻¹ M φ.
            let mut force = vec![[0.0; 3]; system.vectors()];
            system.pattern.add_mass_product(1.0, shape, &mut force);
            let mut right = vec![0.0; n];
            frames.reduce(&force, &mut right);
            let mut x = right.clone();
            if solve(&mut x).is_err() {
                return false;
            }
            vectors.push((x, right));
        }
        let Some([stiffness, circulatory]) = reduced(system, (frames, &skew), &vectors) else { return false };
        let mut now = stiffness.clone().symmetric_eigenvalues().as_slice().to_vec();
        now.sort_by(f64::total_cmp);
        let mut then: Vec<f64> = self.0.iter().map(|(lambda, _)| *lambda).collect();
        then.sort_by(f64::total_cmp);
        let alike = now.iter().zip(&then).all(|(now, then)| (now - then).abs() <= CHANGED * then.abs());
        let enlarged = stiffness + circulatory * MARGIN;
        let is_vibration = |value: &Complex<f64>| value.re > 0.0 && value.im.abs() <= ROUND_OFF * value.re;
        alike && tegula_sparse::eigenvalues(&enlarged).is_some_and(|values| values.iter().all(is_vibration))
    }
}

/// Matrices of K and N on the space of vectors x, given with K x, orthonormal in the mass; `None` where they depend on each other.
fn reduced(
    system: &System,
    (frames, skew): (&LocalFrames, &CirculatoryStiffness),
    vectors: &[(Vec<f64>, Vec<f64>)],
) -> Option<[DMatrix<f64>; 2]> {
    let (k, n) = (vectors.len(), system.unknowns());
    let products: Vec<[Vec<f64>; 2]> = vectors
        .iter()
        .map(|(x, _)| {
            let [mut field, mut force] = [vec![[0.0; 3]; system.vectors()], vec![[0.0; 3]; system.vectors()]];
            let [mut of_mass, mut of_skew] = [vec![0.0; n], vec![0.0; n]];
            frames.expand(x, &mut field);
            system.pattern.add_mass_product(1.0, &field, &mut force);
            frames.reduce(&force, &mut of_mass);
            skew.product(frames, x, &mut of_skew);
            [of_mass, of_skew]
        })
        .collect();
    let matrix = |entry: &dyn Fn(usize, usize) -> f64| DMatrix::from_fn(k, k, entry);
    let stiffness = matrix(&|i, j| dot(&vectors[i].0, &vectors[j].1));
    let mass = matrix(&|i, j| dot(&vectors[i].0, &products[j][0]));
    let circulatory = matrix(&|i, j| dot(&vectors[i].0, &products[j][1]));
    if ![&stiffness, &mass, &circulatory].iter().all(|matrix| matrix.iter().all(|x| x.is_finite())) {
        return None;
    }
    let lower = mass.cholesky()?.l();
    let of_orthonormal = |matrix: DMatrix<f64>| {
        let half = lower.solve_lower_triangular(&matrix)?;
        Some(lower.solve_lower_triangular(&half.transpose())?.transpose())
    };
    Some([of_orthonormal(stiffness)?, of_orthonormal(circulatory)?])
}
