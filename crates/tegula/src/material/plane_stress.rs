//! Von Mises plasticity under plane stress, for the layers of shells that work with stress resultants.
//!
//! A local Newton iteration finds ε_zz with σ_zz = 0 in the three-dimensional law, and static condensation eliminates
//! it from the tangent. Transverse shear takes no part in yielding: shells with stress resultants carry it by their
//! shear stiffness.

use nalgebra::Matrix6;

use super::plasticity::Plasticity;
use super::{MaterialLaw, Response, Strain};

/// Largest number of Newton iterations for ε_zz.
const MAX_ITERATIONS: usize = 60;
const ZZ: usize = 3;

/// Von Mises plasticity of the strains xx, yy, 2xy with σ_zz = 0; the components zz, xz, yz respond linearly with E and G.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneStressPlasticity(pub Plasticity);

impl MaterialLaw for PlaneStressPlasticity {
    fn history(&self) -> usize {
        self.0.history()
    }

    fn respond(&self, strain: &Strain, committed: &[f64], updated: &mut [f64]) -> Option<Response> {
        let law = &self.0;
        let nu = law.poisson;
        let plastic = |i: usize| committed.get(i).copied().unwrap_or(0.0);
        let mut inner = Strain::zeros();
        inner.fixed_rows_mut::<3>(0).copy_from(&strain.fixed_rows::<3>(0));
        // Initial value: elastic response.
        inner[ZZ] = plastic(ZZ) - nu / (1.0 - nu) * (inner[0] - plastic(0) + inner[1] - plastic(1));
        let mut close = false;
        for _ in 0..MAX_ITERATIONS {
            let r = law.respond(&inner, committed, updated)?;
            let stiffness = r.tangent[(ZZ, ZZ)];
            if close {
                let column = r.tangent.column(ZZ).into_owned();
                let mut tangent = r.tangent - column * column.transpose() / stiffness;
                let mut stress = r.stress;
                let mut energy = r.energy;
                let g = 0.5 * law.young / (1.0 + nu);
                for (i, modulus) in [(3, law.young), (4, g), (5, g)] {
                    for j in 0..6 {
                        tangent[(i, j)] = 0.0;
                        tangent[(j, i)] = 0.0;
                    }
                    tangent[(i, i)] = modulus;
                    stress[i] = modulus * strain[i];
                    energy += 0.5 * modulus * strain[i] * strain[i];
                }
                let tangent: Matrix6<f64> = (tangent + tangent.transpose()) * 0.5;
                return Some(Response { stress, tangent, energy, dissipation: r.dissipation });
            }
            let step = r.stress[ZZ] / stiffness;
            inner[ZZ] -= step;
            if !inner[ZZ].is_finite() {
                return None;
            }
            // Quadratic convergence: after one more correction the error is below round-off.
            let size = inner.fixed_rows::<4>(0).amax();
            close = step.abs() <= 1e-12 * size || size == 0.0;
        }
        None
    }

    fn plastic_strain(&self, history: &[f64]) -> Option<f64> {
        self.0.plastic_strain(history)
    }
}
