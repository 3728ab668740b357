//! Eigenvectors of a tangent with negative eigenvalues: by the block Lanczos method about zero, or by inverse iteration from those of an earlier
//! equilibrium.

use nalgebra::DMatrix;
use tegula_sparse::lanczos::{BlockLanczos, SymmetricOperator};

use crate::element::Nodal;
use crate::system::{LocalFrames, System, add_multiple};

/// Largest number of basis vectors, and of negative eigenvalues, for which the eigenvectors are looked for.
const MOST_VECTORS: usize = 80;
const MOST_NEGATIVE: usize = 20;
/// Block of the Lanczos method, which finds so many equal eigenvalues at once.
const BLOCK: usize = 2;
/// Residual of an eigenvector over its eigenvalue, which is enough to tell it from others.
const RESIDUAL: f64 = 1e-3;
/// Cosine of the largest angle between spaces of eigenvectors, up to which a direction lies in both.
const SHARED: f64 = 0.5;
/// Size of the part of a response across others, over it, above which it is independent of them.
const INDEPENDENT: f64 = 1e-6;

/// Orthonormal eigenvectors of all negative eigenvalues of a tangent, in the metric of [`System::norm`].
#[derive(Debug, Clone, PartialEq)]
pub struct UnstableModes(Vec<Vec<Nodal>>);

/// Orthonormal fields that span the same space, by the Gram–Schmidt process; `None` where they depend on each other.
fn orthonormal(system: &System, fields: Vec<Vec<Nodal>>) -> Option<Vec<Vec<Nodal>>> {
    let mut out: Vec<Vec<Nodal>> = Vec::with_capacity(fields.len());
    for mut field in fields {
        normalize(system, &mut field);
        for _ in 0..2 {
            for other in &out {
                let part = system.inner_product(other, &field);
                add_multiple(&mut field, -part, other);
            }
        }
        if !(system.norm(&field) > INDEPENDENT) {
            return None;
        }
        normalize(system, &mut field);
        out.push(field);
    }
    Some(out)
}

/// Inverse of a tangent as an operator on its free degrees of freedom.
struct Inverse<'a> {
    system: &'a System,
    frames: &'a LocalFrames,
    /// Solution with the factored tangent in place of the right side.
    solve: &'a mut dyn FnMut(&mut [f64]) -> Result<(), String>,
    failed: bool,
}

impl SymmetricOperator for Inverse<'_> {
    fn size(&self) -> usize {
        self.system.unknowns()
    }

    fn apply(&mut self, m_x: &[f64], out: &mut [f64]) {
        out.copy_from_slice(m_x);
        self.failed |= (self.solve)(out).is_err();
    }

    fn inner(&self, x: &[f64], out: &mut [f64]) {
        let mut field = vec![[0.0; 3]; self.system.vectors()];
        self.frames.expand(x, &mut field);
        self.system.apply_metric(&mut field);
        self.frames.reduce(&field, out);
    }

    fn stopped(&self) -> bool {
        self.failed
    }
}

impl UnstableModes {
    /// Eigenvectors of a tangent with this number of negative eigenvalues, from solutions with its factor; `None` where they are not found.
    pub fn of(
        system: &System,
        frames: &LocalFrames,
        negative: usize,
        solve: &mut dyn FnMut(&mut [f64]) -> Result<(), String>,
    ) -> Option<Self> {
        if negative == 0 {
            return Some(Self(Vec::new()));
        }
        if negative > MOST_NEGATIVE {
            return None;
        }
        let mut operator = Inverse { system, frames, solve, failed: false };
        let mut lanczos = BlockLanczos::new(&mut operator, BLOCK);
        loop {
            let added = lanczos.expand(&mut operator);
            if operator.failed {
                return None;
            }
            let values = lanczos.ritz_values();
            let found = values.iter().filter(|(value, residual)| *value < 0.0 && *residual <= RESIDUAL);
            if found.count() >= negative {
                break;
            }
            if added == 0 || lanczos.len() >= MOST_VECTORS {
                return None;
            }
        }
        let pairs = lanczos.ritz_pairs(lanczos.len());
        let negative_ones = pairs.into_iter().filter(|pair| pair.value < 0.0 && pair.residual <= RESIDUAL);
        let field = |x: &[f64]| {
            let mut field = vec![[0.0; 3]; system.vectors()];
            frames.expand(x, &mut field);
            normalize(system, &mut field);
            field
        };
        let modes: Vec<Vec<Nodal>> = negative_ones.map(|pair| field(&pair.vector)).collect();
        (modes.len() == negative).then_some(Self(modes))
    }

    /// Modes of a later equilibrium that these have become, whose tangent has as many negative eigenvalues, by one inverse iteration with its factor; `None` where one
    /// of them has not stayed negative, or has changed into another one.
    pub fn followed(
        &self,
        system: &System,
        frames: &LocalFrames,
        negative: usize,
        solve: &mut dyn FnMut(&mut [f64]) -> Result<(), String>,
    ) -> Option<Self> {
        if self.0.len() != negative {
            return None;
        }
        if negative == 0 {
            return Some(self.clone());
        }
        let mut free = vec![0.0; system.unknowns()];
        let mut responses = Vec::with_capacity(negative);
        for mode in &self.0 {
            let mut field = mode.clone();
            system.apply_metric(&mut field);
            frames.reduce(&field, &mut free);
            solve(&mut free).ok()?;
            frames.expand(&free, &mut field);
            responses.push(field);
        }
        let product = |i: usize, j: usize| system.inner_product(&self.0[i], &responses[j]);
        let inverse = DMatrix::from_fn(negative, negative, |i, j| 0.5 * (product(i, j) + product(j, i)));
        if !inverse.symmetric_eigenvalues().iter().all(|value| *value < 0.0) {
            return None;
        }
        let later = Self(orthonormal(system, responses)?);
        (self.shared(system, &later) == negative).then_some(later)
    }

    /// Sum of the modes, a field with a part along each.
    pub fn sum(&self) -> Vec<Nodal> {
        let mut modes = self.0.iter();
        let mut sum = modes.next().cloned().unwrap_or_default();
        modes.for_each(|mode| add_multiple(&mut sum, 1.0, mode));
        sum
    }

    /// Number of directions that belong to the spaces of both.
    pub fn shared(&self, system: &System, other: &Self) -> usize {
        if self.0.is_empty() || other.0.is_empty() {
            return 0;
        }
        self.cosines(system, other).singular_values().iter().filter(|cosine| **cosine > SHARED).count()
    }

    /// Inner products of the modes.
    fn cosines(&self, system: &System, other: &Self) -> DMatrix<f64> {
        DMatrix::from_fn(self.0.len(), other.0.len(), |i, j| system.inner_product(&self.0[i], &other.0[j]))
    }

    /// The mode that lies least in the space of others.
    pub fn farthest_from(&self, system: &System, other: &Self) -> Option<&[Nodal]> {
        let cosines = self.cosines(system, other);
        let part = |i: &usize| cosines.row(*i).norm();
        let farthest = (0..self.0.len()).min_by(|i, j| part(i).total_cmp(&part(j)))?;
        self.0.get(farthest).map(Vec::as_slice)
    }
}

/// Scales a mode to unit norm.
pub fn normalize(system: &System, mode: &mut [Nodal]) {
    let norm = system.norm(mode);
    if norm > 0.0 {
        mode.as_flattened_mut().iter_mut().for_each(|x| *x /= norm);
    }
}
