//! Power series of bilinear shells of linear materials in vector registers, one element per lane.
//!
//! Stresses of lower orders are kept in the layout of the batches, order by order, so that each order reads and writes them without
//! rearrangement.

use pulp::Simd;

use super::bilinear::{BilinearGroup, COORDINATES};
use super::bilinear_kernel::{Basis, Measure, PerForm};
use super::chunks::{for_each_chunk, for_each_chunk_of_two};
use super::forms::{BASIS, MOST};
use super::group::{GroupPoint, Nodal};
use super::lanes::{BATCH, LaneWork, Lanes, run};
use super::power_series::{KnownOrders, PowerSeries};

/// Forces of one order of the elements of a task.
struct ForcesOfOrder<'a> {
    group: &'a BilinearGroup,
    known: &'a KnownOrders<'a>,
    /// Stresses of the batches of the task.
    stresses: &'a mut [f64],
    forces: &'a mut [f64],
}

impl LaneWork for ForcesOfOrder<'_> {
    /// Basis vectors of the coefficients.
    type Space<S: Simd> = Vec<Basis<S>>;

    #[inline(always)]
    fn space<S: Simd>(_: S) -> Vec<Basis<S>> {
        Vec::new()
    }

    #[inline(always)]
    fn work<S: Simd>(&mut self, l: Lanes<S>, offset: usize, x: &mut Vec<Basis<S>>) {
        let Self { group: g, known, .. } = self;
        let (p, stored) = (known.order(), g.stored);
        let origin = g.current_basis(l, known.u);
        x.clear();
        // A closure would be compiled without the instruction set of the registers.
        for v in known.coefficients {
            x.push(g.basis(l, v));
        }
        let per_batch = BATCH * stored * (known.highest - 1);
        let batch = &mut self.stresses[offset / BATCH * per_batch..][..per_batch];
        let stresses = S::as_mut_simd_f64s(batch).0;
        // Stresses of the last order, whose part of the lower ones is stored already.
        let mut n: PerForm<S> = [l.splat(0.0); MOST];
        g.stress(l, &g.products(l, &x[p - 2], &origin), known.strain_factors, &mut n);
        for k in 0..stored {
            let place = &mut stresses[l.part((p - 2) * stored + k)];
            *place = if p == 2 { n[k] } else { l.add(n[k], *place) };
        }
        let mut strain = [l.splat(0.0); MOST];
        for r in 1..p.div_ceil(2) {
            for (e, product) in strain.iter_mut().zip(g.products(l, &x[r - 1], &x[p - r - 1])) {
                *e = l.add(*e, product);
            }
        }
        if p % 2 == 0 {
            let middle = &x[p / 2 - 1];
            for (e, product) in strain.iter_mut().zip(g.products(l, middle, middle)) {
                *e = l.mul_add(l.splat(0.5), product, *e);
            }
        }
        g.stress(l, &strain, &[], &mut n);
        if p < known.highest {
            for k in 0..stored {
                stresses[l.part((p - 1) * stored + k)] = n[k];
            }
        }
        let mut f = [[l.splat(0.0); 3]; BASIS];
        g.add_basis_forces(l, &origin, &n, &mut f);
        for r in 1..p {
            for k in 0..stored {
                n[k] = stresses[l.part((r - 1) * stored + k)];
            }
            g.add_basis_forces(l, &x[p - r - 1], &n, &mut f);
        }
        let end = (offset + S::F64_LANES).min(self.forces.len() / COORDINATES);
        let forces = &mut self.forces[offset * COORDINATES..end * COORDINATES];
        l.write(g.nodal_forces(l, &f).as_flattened(), COORDINATES, forces);
    }
}

/// Products of the tangents of the elements of a task with a field.
struct TangentProducts<'a> {
    group: &'a BilinearGroup,
    k: &'a GroupPoint<'a>,
    field: &'a [Nodal],
    forces: &'a mut [f64],
}

impl LaneWork for TangentProducts<'_> {
    type Space<S: Simd> = ();

    #[inline(always)]
    fn space<S: Simd>(_: S) {}

    #[inline(always)]
    fn work<S: Simd>(&mut self, l: Lanes<S>, offset: usize, (): &mut ()) {
        let Self { group: g, k, field, .. } = self;
        let (mut strain, mut n): (PerForm<S>, PerForm<S>) = ([l.splat(0.0); MOST], [l.splat(0.0); MOST]);
        let origin = g.strained(l, k, Measure::End, &mut strain);
        let x = g.basis(l, field);
        g.stress(l, &g.products(l, &x, &origin), &[], &mut n);
        let mut f = [[l.splat(0.0); 3]; BASIS];
        g.add_basis_forces(l, &origin, &n, &mut f);
        g.stress(l, &strain, k.interior.factors, &mut n);
        g.add_basis_forces(l, &x, &n, &mut f);
        let end = (offset + S::F64_LANES).min(self.forces.len() / COORDINATES);
        let forces = &mut self.forces[offset * COORDINATES..end * COORDINATES];
        l.write(g.nodal_forces(l, &f).as_flattened(), COORDINATES, forces);
    }
}

impl PowerSeries for BilinearGroup {
    fn stored_stresses(&self, highest: usize) -> usize {
        self.vectors.len().next_multiple_of(BATCH) * self.stored * (highest - 1)
    }

    fn forces_of_order(&self, known: &KnownOrders, stresses: &mut [f64], forces: &mut [f64]) {
        let each = self.stored * (known.highest - 1);
        for_each_chunk_of_two((forces, COORDINATES), (stresses, each), &|first, forces, stresses| {
            let elements = forces.len() / COORDINATES;
            run(self.arch(), first, elements, ForcesOfOrder { group: self, known, stresses, forces });
        });
    }

    fn tangent_products(&self, k: &GroupPoint, field: &[Nodal], forces: &mut [f64]) {
        for_each_chunk(forces, COORDINATES, &|first, forces| {
            let elements = forces.len() / COORDINATES;
            run(self.arch(), first, elements, TangentProducts { group: self, k, field, forces });
        });
    }
}
