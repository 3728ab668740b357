//! Vectorised kernel of bilinear shells of linear materials, in which static and dynamic analyses spend their element
//! work.
//!
//! Energy and forces are those of [`QuadraticGroup`](super::QuadraticGroup), which is the reference that this kernel
//! is tested against. It differs in four ways:
//!
//! * One element per lane of a vector register. Element data is stored in batches of `lanes::BATCH`; the width of the
//!   registers is detected at run time.
//! * Strains are the [independent quadratic forms](super::forms) of the element type in the basis of its bilinear
//!   interpolation. Derivatives of forms are vectors of this basis, without coefficients; nodal forces and blocks
//!   follow by sums and differences.
//! * Congruent elements share `H`. It is stored per batch of elements, and only for batches that differ.
//! * `H` is split into diagonal blocks of forms that are coupled in any element of the group. Bending of a symmetric
//!   section does not couple with the rest; on flat elements membrane, shear and thickness do not couple either.

#[cfg(test)]
mod operations;

use std::collections::HashMap;

use pulp::{Arch, Scalar, Simd};

use super::bilinear_kernel::{LanesTangent, Measure, StrainAndStress, Workspace, dot, strain_and_stress};
use super::chunks::{for_each_chunk, for_each_chunk_of_two};
use super::forms::{BASIS, Forms, MOST, QUADRATIC, VECTORS, shares};
use super::generalized_law::energy_of_fields;
use super::geometry::ShellGeometry;
use super::group::{ElementGroup, GroupPoint, Nodal, TangentRequest, TangentWeights};
use super::lanes::{BATCH, LaneWork, Lanes, in_batches, run};
use super::power_series::PowerSeries;
use super::shell::Condensed;
use crate::Vec3;

/// Number of coordinates of an element.
pub(super) const COORDINATES: usize = 3 * VECTORS;
/// Number of 3×3 blocks in the lower triangle of the element matrix.
pub(super) const BLOCKS: usize = VECTORS * (VECTORS + 1) / 2;
/// Rows of a product with H that are summed in registers together (register blocking).
pub(super) const ROWS: usize = 4;

/// Elements of a group while they are collected: connectivity, reference geometry, mass and stiffness.
#[derive(Debug, Clone, Default)]
pub struct BilinearMembers {
    /// Connectivity: nodal vectors per element.
    pub vectors: Vec<[u32; VECTORS]>,
    /// Reference configuration: components of the basis vectors per element.
    pub reference: Vec<f64>,
    /// Shape index of each element; congruent elements share it.
    pub shapes: Vec<u32>,
    /// Mass per shape: one scalar per pair of nodal vectors, lower triangle by rows.
    pub mass: Vec<f64>,
    /// Stiffness `RᵀHR` of the needed forms per shape, lower triangle by rows.
    pub stiffness: Vec<f64>,
    /// Generalised stress of the prescribed strains when fully restrained, one value per form, for each field and
    /// shape.
    pub prescribed: Vec<f64>,
    /// Energy of the prescribed strain fields when fully restrained, by pairs of fields, per shape.
    pub prescribed_energy: Vec<f64>,
    /// Number of prescribed strain fields of the model; 0 if none acts on this group.
    pub fields: usize,
}

impl BilinearMembers {
    /// Adds an element with a shape of its own.
    pub fn push(
        &mut self,
        forms: &Forms,
        vectors: [u32; VECTORS],
        geometry: &ShellGeometry,
        condensed: &Condensed,
        mass: &[f64],
    ) {
        self.shapes.push((self.mass.len() / BLOCKS) as u32);
        self.place(vectors, geometry);
        let r = &forms.samples;
        let h = r.transpose() * &condensed.stiffness * r;
        for (i, &k) in forms.needed.iter().enumerate() {
            self.stiffness.extend(forms.needed[..=i].iter().map(|&l| h[(k, l)]));
        }
        for n in &condensed.prescribed {
            self.prescribed.extend_from_slice((r.transpose() * n).as_slice());
        }
        self.prescribed_energy.extend_from_slice(condensed.prescribed_energy.as_slice());
        self.mass.extend_from_slice(mass);
    }

    /// Adds an element congruent to element `first`; false if there is no such element.
    pub fn push_like(&mut self, first: usize, vectors: [u32; VECTORS], geometry: &ShellGeometry) -> bool {
        let Some(&shape) = self.shapes.get(first) else { return false };
        self.shapes.push(shape);
        self.place(vectors, geometry);
        true
    }

    fn place(&mut self, vectors: [u32; VECTORS], geometry: &ShellGeometry) {
        for v in 0..BASIS {
            let nodal = geometry.positions.iter().chain(&geometry.directors);
            let x: Vec3 = nodal.zip(shares(v)).map(|(x, share)| x * share).sum();
            self.reference.extend_from_slice(x.as_slice());
        }
        self.vectors.push(vectors);
    }

    /// Distinct batches of shapes, and the index of the one that each batch of elements has. Lanes without an element
    /// have the shape of the last one.
    fn batches(&self) -> (Vec<u32>, Vec<u32>) {
        let mut known = HashMap::new();
        let (mut shapes, mut of_batch) = (Vec::new(), Vec::new());
        for own in self.shapes.chunks(BATCH) {
            let own: [u32; BATCH] = std::array::from_fn(|lane| own[lane.min(own.len() - 1)]);
            let next = known.len() as u32;
            of_batch.push(*known.entry(own).or_insert_with(|| {
                shapes.extend(own);
                next
            }));
        }
        (shapes, of_batch)
    }
}

/// Diagonal block of H: a set of coupled forms.
#[derive(Debug, Clone)]
pub(super) struct Coupled {
    /// Indices of the forms, ascending.
    pub forms: Vec<usize>,
    /// Index of the first entry of the block in H, lower triangle by rows.
    pub first: usize,
    /// Indices of the entries by full rows, padded to a multiple of [`ROWS`].
    pub places: Vec<usize>,
    /// Derivatives with respect to each vector of the basis: pairs of a form's index in `forms` and the basis vector
    /// that is its derivative.
    pub derivatives: [Vec<(usize, usize)>; BASIS],
}

/// Group of bilinear shells of one type and section. Strains refer to the reference geometry given at construction.
pub struct BilinearGroup {
    name: &'static str,
    forms: Forms,
    /// True if the elements need forms quadratic in z.
    pub(super) quadratic: bool,
    /// Number of generalised stresses stored per element: one per form, all forms but those quadratic in z, or all.
    pub(super) stored: usize,
    pub(super) coupled: Vec<Coupled>,
    /// Entries of H per element.
    pub(super) entries: usize,
    /// Basis vectors of the reference configuration, in batches.
    pub(super) reference: Vec<f64>,
    /// Index of the distinct batch of shapes that each batch of elements has.
    pub(super) of_batch: Vec<u32>,
    /// H of the distinct batches of shapes: `BATCH` values of each entry.
    pub(super) h: Vec<f64>,
    /// Generalised stress of the prescribed strain fields when fully restrained, stored like `h`.
    pub(super) prescribed: Vec<f64>,
    /// Energy of the prescribed strain fields when fully restrained, by pairs of fields, per shape.
    prescribed_energy: Vec<f64>,
    /// Shape index of each element.
    shapes: Vec<u32>,
    pub(super) fields: usize,
    pub(super) vectors: Vec<[u32; VECTORS]>,
    /// Mass per shape: one scalar per pair of nodal vectors, lower triangle by rows.
    mass: Vec<f64>,
    pub(super) retardation_time: f64,
    arch: Arch,
}

/// Index of the entry (i, j) of a symmetric matrix in its lower triangle, stored by rows.
pub(super) fn lower(i: usize, j: usize) -> usize {
    let (i, j) = (i.max(j), i.min(j));
    i * (i + 1) / 2 + j
}

impl BilinearGroup {
    /// Group of the collected elements.
    pub fn new(name: &'static str, forms: Forms, members: BilinearMembers, retardation_time: f64) -> Self {
        let needed = &forms.needed;
        let n = needed.len();
        let size = n * (n + 1) / 2;
        let sets = coupled_forms(n, &members.stiffness);
        let places: Vec<usize> = sets
            .iter()
            .flat_map(|set| {
                let rows = set.iter().enumerate();
                rows.flat_map(|(i, &k)| set[..=i].iter().map(move |&l| lower(k, l)))
            })
            .collect();
        let kept: Vec<f64> =
            members.stiffness.chunks_exact(size).flat_map(|h| places.iter().map(|&p| h[p])).collect();
        let (shapes, of_batch) = members.batches();
        let batches = |values: &[f64], count: usize| {
            let lanes = shapes.iter().map(|&s| s as usize * count);
            let all: Vec<f64> = lanes.flat_map(|at| values[at..at + count].iter().copied()).collect();
            in_batches(&all, count)
        };
        let mut first = 0;
        let coupled = sets
            .iter()
            .map(|set| {
                let set = Coupled::new(set.iter().map(|&k| needed[k]).collect(), first, &forms);
                first += set.forms.len() * (set.forms.len() + 1) / 2;
                set
            })
            .collect();
        let quadratic = needed.last().is_some_and(|&k| k >= QUADRATIC);
        Self {
            name,
            quadratic,
            stored: if quadratic { MOST } else { QUADRATIC },
            coupled,
            entries: places.len(),
            reference: in_batches(&members.reference, 3 * BASIS),
            h: batches(&kept, places.len()),
            prescribed: batches(&members.prescribed, members.fields * MOST),
            of_batch,
            prescribed_energy: members.prescribed_energy,
            shapes: members.shapes,
            fields: members.fields,
            vectors: members.vectors,
            mass: members.mass,
            retardation_time,
            arch: Arch::new(),
            forms,
        }
    }
}

impl Coupled {
    fn new(forms: Vec<usize>, first: usize, all: &Forms) -> Self {
        let derivatives = std::array::from_fn(|v| {
            let of_v = all.terms.iter().filter(|t| t.1 == v);
            of_v.filter_map(|&(k, _, b)| Some((forms.binary_search(&k).ok()?, b))).collect()
        });
        let (n, row) = (forms.len(), forms.len().next_multiple_of(ROWS));
        let mut places = vec![first; n * row];
        for i in 0..n {
            for j in 0..n {
                places[i * row + j] = first + lower(i, j);
            }
        }
        Self { forms, first, places, derivatives }
    }
}

/// Connected components of the coupling of the forms by H: no element couples forms of different sets. Entries within
/// round-off of zero do not couple.
fn coupled_forms(n: usize, stiffness: &[f64]) -> Vec<Vec<usize>> {
    let mut set: Vec<usize> = (0..n).collect();
    for h in stiffness.chunks_exact(n * (n + 1) / 2) {
        for i in 0..n {
            for j in 0..i {
                if set[i] == set[j] {
                    continue;
                }
                let scale = (h[lower(i, i)].abs() * h[lower(j, j)].abs()).sqrt();
                if h[lower(i, j)].abs() > 8.0 * f64::EPSILON * scale {
                    let (keep, drop) = (set[i].min(set[j]), set[i].max(set[j]));
                    set.iter_mut().filter(|s| **s == drop).for_each(|s| *s = keep);
                }
            }
        }
    }
    (0..n)
        .filter(|&root| set[root] == root)
        .map(|root| (0..n).filter(|&k| set[k] == root).collect())
        .collect()
}

struct Forces<'a> {
    group: &'a BilinearGroup,
    k: &'a GroupPoint<'a>,
    forces: &'a mut [f64],
}

impl LaneWork for Forces<'_> {
    type Space<S: Simd> = StrainAndStress<S>;

    #[inline(always)]
    fn space<S: Simd>(simd: S) -> StrainAndStress<S> {
        strain_and_stress(simd)
    }

    #[inline(always)]
    fn work<S: Simd>(&mut self, l: Lanes<S>, offset: usize, forms: &mut StrainAndStress<S>) {
        let end = (offset + S::F64_LANES).min(self.forces.len() / COORDINATES);
        let forces = &mut self.forces[offset * COORDINATES..end * COORDINATES];
        self.group.force_lanes(l, self.k, forces, forms);
    }
}

struct ForcesAndTangent<'a> {
    group: &'a BilinearGroup,
    k: &'a GroupPoint<'a>,
    forces: &'a mut [f64],
    weights: TangentWeights,
    stress: Option<&'a [f64]>,
    prescribed: Option<&'a [Nodal]>,
    blocks: &'a mut [f64],
}

impl LaneWork for ForcesAndTangent<'_> {
    type Space<S: Simd> = Workspace<S>;

    #[inline(always)]
    fn space<S: Simd>(simd: S) -> Workspace<S> {
        Workspace::new(simd)
    }

    #[inline(always)]
    fn work<S: Simd>(&mut self, l: Lanes<S>, offset: usize, work: &mut Workspace<S>) {
        let end = (offset + S::F64_LANES).min(self.forces.len() / COORDINATES);
        let forces = &mut self.forces[offset * COORDINATES..end * COORDINATES];
        let size = 9 * BLOCKS;
        let tangent = LanesTangent {
            weights: &self.weights,
            stress: self.stress,
            prescribed: self.prescribed,
            blocks: &mut self.blocks[offset * size..end * size],
        };
        self.group.tangent_lanes(l, self.k, forces, tangent, work);
    }
}

/// Quantity that [`PerElement`] computes.
#[derive(Clone, Copy)]
enum Wanted<'a> {
    /// Generalised stresses, extrapolated along an increment where one is given.
    Stress(Option<(&'a [Nodal], f64)>),
    /// Stored energy, without the constant part of the prescribed strain fields.
    Energy,
    /// Energy of the strains of a small motion about the state.
    MaterialEnergy(&'a [Nodal]),
}

struct PerElement<'a> {
    group: &'a BilinearGroup,
    k: &'a GroupPoint<'a>,
    wanted: Wanted<'a>,
    /// Values per element.
    count: usize,
    out: &'a mut [f64],
}

impl LaneWork for PerElement<'_> {
    type Space<S: Simd> = StrainAndStress<S>;

    #[inline(always)]
    fn space<S: Simd>(simd: S) -> StrainAndStress<S> {
        strain_and_stress(simd)
    }

    #[inline(always)]
    fn work<S: Simd>(&mut self, l: Lanes<S>, offset: usize, [strain, n]: &mut StrainAndStress<S>) {
        let (g, k) = (self.group, self.k);
        let end = (offset + S::F64_LANES).min(self.out.len() / self.count);
        let out = &mut self.out[offset * self.count..end * self.count];
        match self.wanted {
            Wanted::Stress(increment) => {
                let acting = g.strained(l, k, Measure::Effective, strain);
                if let Some((increment, factor)) = increment {
                    let products = g.products(l, &g.basis(l, increment), &acting);
                    let factor = l.splat(factor);
                    for (s, product) in strain.iter_mut().zip(products) {
                        *s = l.mul_add(factor, product, *s);
                    }
                }
                g.stress(l, strain, k.interior.factors, n);
                l.write(n, self.count, out);
            }
            Wanted::Energy => {
                g.strained(l, k, Measure::End, strain);
                let half = l.mul(l.splat(0.5), dot(l, strain, &g.multiply(l, strain)));
                l.write(&[l.add(half, g.potential(l, strain, k.interior.factors))], 1, out);
            }
            Wanted::MaterialEnergy(motion) => {
                let acting = g.strained(l, k, Measure::Effective, strain);
                let products = g.products(l, &g.basis(l, motion), &acting);
                strain.iter_mut().zip(products).for_each(|(s, product)| *s = product);
                l.write(&[l.mul(l.splat(0.5), dot(l, strain, &g.multiply(l, strain)))], 1, out);
            }
        }
    }
}

impl BilinearGroup {
    /// Instruction set of the machine.
    pub(super) fn arch(&self) -> Arch {
        self.arch
    }

    /// Strain measure of one element, as the sampled strains of its type.
    fn samples(&self, element: usize, k: &GroupPoint, measure: Measure) -> Vec<f64> {
        let l = Lanes { simd: Scalar::new(), first: element };
        let mut forms = [0.0; MOST];
        self.strained(l, k, measure, &mut forms);
        (&self.forms.samples * nalgebra::DVector::from_column_slice(&forms)).as_slice().to_vec()
    }

    fn per_element(&self, k: &GroupPoint, wanted: Wanted, count: usize, out: &mut [f64]) {
        for_each_chunk(out, count, &|first, out| {
            let elements = out.len() / count;
            let work = PerElement { group: self, k, wanted, count, out };
            run(self.arch, first, elements, work);
        });
    }
}

impl ElementGroup for BilinearGroup {
    fn name(&self) -> &'static str {
        self.name
    }

    fn len(&self) -> usize {
        self.vectors.len()
    }

    fn vectors(&self, element: usize) -> &[u32] {
        &self.vectors[element]
    }

    fn vectors_per_element(&self) -> usize {
        VECTORS
    }

    fn power_series(&self) -> Option<&dyn PowerSeries> {
        Some(self)
    }

    fn stresses_per_element(&self) -> usize {
        self.stored
    }

    fn mass(&self, element: usize) -> &[f64] {
        &self.mass[self.shapes[element] as usize * BLOCKS..][..BLOCKS]
    }

    fn retardation_time(&self) -> f64 {
        self.retardation_time
    }

    fn evaluate(&self, k: &GroupPoint, first: usize, forces: &mut [f64], tangent: Option<TangentRequest>) {
        let Some(TangentRequest { weights, stress, prescribed, blocks }) = tangent else {
            return for_each_chunk(forces, COORDINATES, &|chunk, forces| {
                let elements = forces.len() / COORDINATES;
                run(self.arch, first + chunk, elements, Forces { group: self, k, forces });
            });
        };
        for_each_chunk_of_two((forces, COORDINATES), (blocks, 9 * BLOCKS), &|chunk, forces, blocks| {
            let elements = forces.len() / COORDINATES;
            let work = ForcesAndTangent { group: self, k, forces, weights, stress, prescribed, blocks };
            run(self.arch, first + chunk, elements, work);
        });
    }

    fn stresses(&self, k: &GroupPoint, stresses: &mut [f64]) {
        self.per_element(k, Wanted::Stress(None), self.stored, stresses);
    }

    fn extrapolate(
        &self,
        k: &GroupPoint,
        increment: &[Nodal],
        weights: &TangentWeights,
        stresses: &mut [f64],
    ) {
        let factor = weights.stress + self.retardation_time * weights.rate;
        self.per_element(k, Wanted::Stress(Some((increment, factor))), self.stored, stresses);
    }

    fn energies(&self, k: &GroupPoint, energies: &mut [f64]) {
        self.per_element(k, Wanted::Energy, 1, energies);
        let f = self.fields;
        if f != 0 {
            for (energy, &shape) in energies.iter_mut().zip(&self.shapes) {
                let constants = &self.prescribed_energy[shape as usize * f * f..][..f * f];
                *energy += energy_of_fields(constants, k.interior.factors);
            }
        }
    }

    fn material_energies(&self, k: &GroupPoint, motion: &[Nodal], energies: &mut [f64]) {
        self.per_element(k, Wanted::MaterialEnergy(motion), 1, energies);
    }

    fn sampled_strains(&self, element: usize, k: &GroupPoint) -> Vec<f64> {
        self.samples(element, k, Measure::End)
    }

    fn strain_rates(&self, element: usize, k: &GroupPoint) -> Vec<f64> {
        self.samples(element, k, Measure::Rate)
    }

    fn history_per_element(&self) -> usize {
        0
    }

    fn update_history(&self, _: &GroupPoint, _: &mut [f64]) -> f64 {
        0.0
    }

    fn dissipation(&self, k: &GroupPoint, power: &mut [f64]) {
        if self.retardation_time == 0.0 {
            power.fill(0.0);
            return;
        }
        for_each_chunk(power, 1, &|first, power| {
            for (element, power) in (first..).zip(power) {
                let l = Lanes { simd: Scalar::new(), first: element };
                let mut rate = [0.0; MOST];
                self.strained(l, k, Measure::Rate, &mut rate);
                *power = self.retardation_time * dot(l, &rate, &self.multiply(l, &rate));
            }
        });
    }
}
