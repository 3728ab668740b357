//! Power series of the elements of a [`QuadraticGroup`] of a linear material.

use super::chunks::{for_each_chunk, for_each_chunk_of_two};
use super::generalized_law::GeneralizedLaw;
use super::group::{GroupPoint, InternalVariables, Nodal};
use super::power_series::{KnownOrders, PowerSeries};
use super::quadratic::{QuadraticGroup, StrainState};
use super::strains::Directions;

impl<const M: usize, const N: usize, const S: usize, const D: usize, C: GeneralizedLaw<S>>
    QuadraticGroup<M, N, S, D, C>
{
    /// Forces of the next order of one element; `stresses` holds its stresses of lower orders, `S` values each, and `x` is room for the
    /// base vectors of the coefficients.
    fn series_of_one(
        &self,
        e: usize,
        known: &KnownOrders,
        (stresses, x): (&mut [f64], &mut Vec<Directions<f64, D>>),
        force: &mut [f64],
    ) {
        let p = known.order();
        let mut origin = self.strains.directions(&self.gather(e, known.reference));
        let moved = self.strains.directions(&self.gather(e, known.u));
        for (x, d) in origin.as_flattened_mut().iter_mut().zip(moved.as_flattened()) {
            *x += d;
        }
        x.clear();
        x.extend(known.coefficients.iter().map(|v| self.strains.directions(&self.gather(e, v))));
        let linear = |factors| InternalVariables { history: &[], factors };
        // Stresses of the last order, whose part of the lower ones is stored already.
        let last = self.strains.rates(&origin, &x[p - 2]);
        let change = self.law().stress(e, &last, &linear(known.strain_factors));
        let at = (p - 2) * S;
        for (stored, change) in stresses[at..at + S].iter_mut().zip(change) {
            *stored = if p == 2 { change } else { *stored + change };
        }
        let mut strain = [0.0; S];
        for r in 1..p {
            for (e, product) in strain.iter_mut().zip(self.strains.rates(&x[r - 1], &x[p - r - 1])) {
                *e += 0.5 * product;
            }
        }
        let n = self.law().stress(e, &strain, &linear(&[]));
        if let Some(stored) = stresses.get_mut(at + S..at + 2 * S) {
            stored.copy_from_slice(&n);
        }
        let mut f = self.strains.force(&origin, &n);
        for r in 1..p {
            let n = std::array::from_fn(|k| stresses[(r - 1) * S + k]);
            let part = self.strains.force(&x[p - r - 1], &n);
            for (f, part) in f.as_flattened_mut().iter_mut().zip(part.as_flattened()) {
                *f += part;
            }
        }
        if let Some(t) = self.members.transforms.get(e) {
            f = t.apply_transposed(&f);
        }
        force.copy_from_slice(f.as_flattened());
    }
}

impl<const M: usize, const N: usize, const S: usize, const D: usize, C: GeneralizedLaw<S>> PowerSeries
    for QuadraticGroup<M, N, S, D, C>
{
    fn stored_stresses(&self, highest: usize) -> usize {
        self.members.vectors.len() * (highest - 1) * S
    }

    fn forces_of_order(&self, known: &KnownOrders, stresses: &mut [f64], forces: &mut [f64]) {
        let each = (known.highest - 1) * S;
        for_each_chunk_of_two((forces, N), (stresses, each), &|first, forces, stresses| {
            let mut x = Vec::with_capacity(known.highest);
            let elements = forces.chunks_exact_mut(N).zip(stresses.chunks_exact_mut(each));
            for (i, (force, stresses)) in elements.enumerate() {
                self.series_of_one(first + i, known, (stresses, &mut x), force);
            }
        });
    }

    fn tangent_products(&self, k: &GroupPoint, field: &[Nodal], forces: &mut [f64]) {
        for_each_chunk(forces, N, &|first, forces| {
            for (e, out) in (first..).zip(forces.chunks_exact_mut(N)) {
                let StrainState { acting, stress, .. } = self.stress(e, k);
                let x = self.strains.directions(&self.gather(e, field));
                let linear = InternalVariables { history: &[], factors: &[] };
                let change = self.law().stress(e, &self.strains.rates(&acting, &x), &linear);
                let mut f = self.strains.force(&acting, &change);
                let turned = self.strains.force(&x, &stress);
                f.as_flattened_mut().iter_mut().zip(turned.as_flattened()).for_each(|(f, part)| *f += part);
                if let Some(t) = self.members.transforms.get(e) {
                    f = t.apply_transposed(&f);
                }
                out.copy_from_slice(f.as_flattened());
            }
        });
    }
}
