//! Elements whose strains are quadratic forms of their nodal vectors, as a structure of arrays.
//!
//! Static dispatch inside the loop, one dynamic call per group. Elements write their
//! forces and tangent blocks to their own place in a buffer; the assembly sums them in
//! a fixed order, so results do not depend on the number of threads.

use pulp::Arch;

use super::chunks::{for_each_chunk, for_each_chunk_of_two};
use super::generalized_law::GeneralizedLaw;
use super::group::{
    ElementGroup, GroupPoint, InternalVariables, Motion, Nodal, TangentRequest, TangentWeights,
};
use super::power_series::PowerSeries;
use super::strains::{Directions, SampledStrains};
use super::transform::NodalTransform;

/// Connectivity, mass and nodal transformations of a group of elements.
#[derive(Debug, Clone)]
pub struct Members<const M: usize> {
    /// Connectivity: nodal vectors per element.
    pub vectors: Vec<[u32; M]>,
    /// Mass per element: one scalar per pair of nodal vectors, lower triangle by rows.
    pub mass: Vec<f64>,
    /// Maps from the nodal vectors of the model to those of the element type; empty where both agree.
    pub transforms: Vec<NodalTransform<M>>,
}

impl<const M: usize> Default for Members<M> {
    fn default() -> Self {
        Self { vectors: Vec::new(), mass: Vec::new(), transforms: Vec::new() }
    }
}

/// Group of elements with `M` nodal vectors, `N = 3 M` coordinates, `S` sampled strains and `D` base vectors.
pub struct QuadraticGroup<const M: usize, const N: usize, const S: usize, const D: usize, C> {
    name: &'static str,
    pub(super) strains: SampledStrains<M, N, S, D>,
    pub(super) members: Members<M>,
    constitution: C,
    retardation_time: f64,
    arch: Arch,
}

/// Strain state of an element: base vectors, generalised stresses and sampled strains of a motion.
pub(super) struct StrainState<const S: usize, const D: usize> {
    /// Base vectors of the configuration in which the stress acts: current (state) or mid-step (step).
    pub(super) acting: Directions<f64, D>,
    /// Generalised stresses.
    pub(super) stress: [f64; S],
    /// Sampled strains at which the tangent is taken.
    strain: [f64; S],
}

impl<const M: usize, const N: usize, const S: usize, const D: usize, C: GeneralizedLaw<S>>
    QuadraticGroup<M, N, S, D, C>
{
    /// Group of elements with their generalised constitutive law.
    pub fn new(
        name: &'static str,
        strains: SampledStrains<M, N, S, D>,
        members: Members<M>,
        constitution: C,
        retardation_time: f64,
    ) -> Self {
        debug_assert_eq!(members.mass.len(), members.vectors.len() * M * (M + 1) / 2);
        Self { name, strains, members, constitution, retardation_time, arch: Arch::new() }
    }

    /// Generalised constitutive law.
    pub(super) fn law(&self) -> &C {
        &self.constitution
    }

    #[inline(always)]
    pub(super) fn gather(&self, element: usize, field: &[Nodal]) -> [Nodal; M] {
        let v = self.members.vectors[element].map(|v| field[v as usize]);
        match self.members.transforms.get(element) {
            None => v,
            Some(t) => t.apply(&v),
        }
    }

    /// History variables of an element, and the factors of the prescribed strains.
    #[inline(always)]
    fn interior<'a>(&self, element: usize, k: &GroupPoint<'a>) -> InternalVariables<'a> {
        let n = self.constitution.history();
        InternalVariables {
            history: &k.interior.history[element * n..(element + 1) * n],
            factors: k.interior.factors,
        }
    }

    #[inline(always)]
    fn strains_at(
        &self,
        e: usize,
        k: &GroupPoint,
        p0: &Directions<f64, D>,
        u: &[Nodal],
    ) -> (Directions<f64, D>, [f64; S]) {
        let p = self.strains.directions(&self.gather(e, u));
        let s = self.strains.strains(p0, &p, !k.linear);
        (p, s)
    }

    /// Sampled strains at the end of the motion.
    #[inline(always)]
    fn strain(&self, e: usize, k: &GroupPoint) -> [f64; S] {
        let (Motion::State { u, .. } | Motion::Step { new: u, .. }) = k.motion;
        let p0 = self.strains.directions(&self.gather(e, k.reference));
        self.strains_at(e, k, &p0, u).1
    }

    /// Rates of the sampled strains of the motion; zero where it has no velocity.
    fn rate(&self, e: usize, k: &GroupPoint) -> [f64; S] {
        let p0 = self.strains.directions(&self.gather(e, k.reference));
        match k.motion {
            Motion::State { velocity: None, .. } => [0.0; S],
            Motion::State { u, velocity: Some(v) } => {
                let (p, _) = self.strains_at(e, k, &p0, u);
                let mut acting = p0;
                if !k.linear {
                    add(&mut acting, &p, 1.0);
                }
                self.strains.rates(&acting, &self.strains.directions(&self.gather(e, v)))
            }
            Motion::Step { old, new, dt } => {
                let (_, s_old) = self.strains_at(e, k, &p0, old);
                let (_, s_new) = self.strains_at(e, k, &p0, new);
                std::array::from_fn(|i| (s_new[i] - s_old[i]) / dt)
            }
        }
    }

    /// Strain state of the motion: generalised stresses, and base vectors of the configuration in which they act.
    #[inline(always)]
    pub(super) fn stress(&self, e: usize, k: &GroupPoint) -> StrainState<S, D> {
        let p0 = self.strains.directions(&self.gather(e, k.reference));
        let interior = self.interior(e, k);
        let mut acting = p0;
        let tau = self.retardation_time;
        match k.motion {
            Motion::State { u, velocity } => {
                let (p, strain) = self.strains_at(e, k, &p0, u);
                if !k.linear {
                    add(&mut acting, &p, 1.0);
                }
                let mut stress = self.constitution.stress(e, &strain, &interior);
                if let (Some(v), true) = (velocity, tau != 0.0) {
                    let v = self.strains.directions(&self.gather(e, v));
                    let rate = self.strains.rates(&acting, &v);
                    add_scaled(&mut stress, &self.constitution.viscous(e, &rate), tau);
                }
                StrainState { acting, stress, strain }
            }
            Motion::Step { old, new, dt } => {
                let (p_old, s_old) = self.strains_at(e, k, &p0, old);
                let (p_new, s_new) = self.strains_at(e, k, &p0, new);
                if !k.linear {
                    add(&mut acting, &p_old, 0.5);
                    add(&mut acting, &p_new, 0.5);
                }
                let mut stress = self.constitution.mean_stress(e, &s_old, &s_new, &interior);
                if tau != 0.0 {
                    let rate = std::array::from_fn(|i| (s_new[i] - s_old[i]) / dt);
                    add_scaled(&mut stress, &self.constitution.viscous(e, &rate), tau);
                }
                let strain = std::array::from_fn(|i| 0.5 * (s_old[i] + s_new[i]));
                StrainState { acting, stress, strain }
            }
        }
    }

    #[inline(always)]
    fn evaluate_one(&self, e: usize, k: &GroupPoint, force: &mut [f64], tangent: Option<OneTangent>) {
        let StrainState { acting, stress: n, strain } = self.stress(e, k);
        let mut f = self.strains.force(&acting, &n);
        if let Some(t) = self.members.transforms.get(e) {
            f = t.apply_transposed(&f);
        }
        for (out, value) in force.iter_mut().zip(f.as_flattened()) {
            *out = *value;
        }
        let Some(OneTangent { weights: w, stress, prescribed, blocks }) = tangent else { return };
        let mut geometric_stress = n;
        if let Some(stored) = stress {
            geometric_stress.copy_from_slice(&stored[e * S..(e + 1) * S]);
        }
        let gradient = self.strains.gradient(&acting);
        let material = w.force * (w.stress + self.retardation_time * w.rate);
        let geometric = if k.linear { 0.0 } else { w.force * w.direction };
        self.constitution.with_tangent(e, &strain, &self.interior(e, k), |h| {
            self.strains.tangent(h, &gradient, &geometric_stress, material, geometric, blocks);
        });
        if let Some(t) = self.members.transforms.get(e) {
            t.apply_to_blocks(blocks);
        }
        if !k.linear && !k.inextensible.is_empty() {
            let f = self.strains.force(&acting, &geometric_stress);
            add_curvature(k, &self.members.vectors[e], &f, geometric, blocks);
        }
        if let Some(increment) = prescribed {
            let d = self.members.vectors[e].map(|v| increment[v as usize]);
            if d.iter().any(|v| *v != [0.0; 3]) {
                multiply_blocks(blocks, &d, 1.0 / w.force, force);
            }
        }
    }
}

/// [`TangentRequest`] with the blocks of one element.
struct OneTangent<'a> {
    weights: &'a TangentWeights,
    stress: Option<&'a [f64]>,
    prescribed: Option<&'a [Nodal]>,
    blocks: &'a mut [f64],
}

/// Curvature term of the inextensible directors: a vector d of constant length moves on a sphere; its second variation
/// −d |δ|² adds −(f·d) I, with the force f on it, to the lower-triangle blocks of an element matrix.
pub(super) fn add_curvature(k: &GroupPoint, vectors: &[u32], f: &[Nodal], factor: f64, blocks: &mut [f64]) {
    for (a, (&v, f)) in vectors.iter().zip(f).enumerate().filter(|(_, (v, _))| k.inextensible[**v as usize]) {
        let v = v as usize;
        let u: Nodal = match k.motion {
            Motion::State { u, .. } => u[v],
            Motion::Step { old, new, .. } => std::array::from_fn(|i| 0.5 * (old[v][i] + new[v][i])),
        };
        let fd: f64 = (0..3).map(|i| f[i] * (k.reference[v][i] + u[i])).sum();
        let at = 9 * (a * (a + 1) / 2 + a);
        for i in [0, 4, 8] {
            blocks[at + i] -= factor * fd;
        }
    }
}

/// Adds `scale · K d` to `out`; `blocks` holds the lower triangle of the symmetric element matrix K.
pub(crate) fn multiply_blocks(blocks: &[f64], d: &[Nodal], scale: f64, out: &mut [f64]) {
    let mut block = blocks.chunks_exact(9);
    for a in 0..d.len() {
        for b in 0..=a {
            let Some(k) = block.next() else { return };
            for i in 0..3 {
                for j in 0..3 {
                    out[3 * a + i] += scale * k[3 * i + j] * d[b][j];
                    if a != b {
                        out[3 * b + j] += scale * k[3 * i + j] * d[a][i];
                    }
                }
            }
        }
    }
}

#[inline(always)]
fn add<const D: usize>(to: &mut Directions<f64, D>, from: &Directions<f64, D>, factor: f64) {
    for (t, f) in to.iter_mut().zip(from) {
        for i in 0..3 {
            t[i] += factor * f[i];
        }
    }
}

#[inline(always)]
fn add_scaled<const S: usize>(to: &mut [f64; S], from: &[f64; S], factor: f64) {
    for (t, f) in to.iter_mut().zip(from) {
        *t += factor * f;
    }
}

impl<const M: usize, const N: usize, const S: usize, const D: usize, C: GeneralizedLaw<S>> ElementGroup
    for QuadraticGroup<M, N, S, D, C>
{
    fn name(&self) -> &'static str {
        self.name
    }

    fn len(&self) -> usize {
        self.members.vectors.len()
    }

    fn vectors(&self, element: usize) -> &[u32] {
        &self.members.vectors[element]
    }

    fn vectors_per_element(&self) -> usize {
        M
    }

    fn power_series(&self) -> Option<&dyn PowerSeries> {
        self.constitution.is_linear().then_some(self as &dyn PowerSeries)
    }

    fn stresses_per_element(&self) -> usize {
        S
    }

    fn mass(&self, element: usize) -> &[f64] {
        let n = M * (M + 1) / 2;
        &self.members.mass[element * n..(element + 1) * n]
    }

    fn retardation_time(&self) -> f64 {
        self.retardation_time
    }

    fn evaluate(&self, k: &GroupPoint, first: usize, forces: &mut [f64], tangent: Option<TangentRequest>) {
        let arch = self.arch;
        let Some(request) = tangent else {
            let work = |chunk: usize, forces: &mut [f64]| {
                arch.dispatch(
                    #[inline(always)]
                    || {
                        for (i, force) in forces.chunks_exact_mut(N).enumerate() {
                            self.evaluate_one(first + chunk + i, k, force, None);
                        }
                    },
                );
            };
            return self.constitution.evaluated(&mut || for_each_chunk(&mut *forces, N, &work));
        };
        let size = 9 * SampledStrains::<M, N, S, D>::BLOCKS;
        let TangentRequest { weights, stress, prescribed, blocks } = request;
        let work = |chunk: usize, forces: &mut [f64], blocks: &mut [f64]| {
            arch.dispatch(
                #[inline(always)]
                || {
                    let each = forces.chunks_exact_mut(N).zip(blocks.chunks_exact_mut(size));
                    for (i, (force, blocks)) in each.enumerate() {
                        let tangent = Some(OneTangent { weights: &weights, stress, prescribed, blocks });
                        self.evaluate_one(first + chunk + i, k, force, tangent);
                    }
                },
            );
        };
        self.constitution
            .evaluated(&mut || for_each_chunk_of_two((&mut *forces, N), (&mut *blocks, size), &work));
    }

    fn forces_of_stresses(
        &self,
        k: &GroupPoint,
        element: usize,
        stresses: Option<&[f64]>,
        forces: &mut [f64],
    ) -> bool {
        // Inextensible directors have a curvature of their own.
        let inextensible = |v: &u32| k.inextensible.get(*v as usize).is_some_and(|is| *is);
        if self.members.vectors[element].iter().any(inextensible) {
            return false;
        }
        let StrainState { acting, stress: mut n, .. } = self.stress(element, k);
        if let Some(stored) = stresses {
            n.copy_from_slice(&stored[element * S..(element + 1) * S]);
        }
        let f = self.strains.force(&acting, &n);
        let f = self.members.transforms.get(element).map_or(f, |t| t.apply_transposed(&f));
        forces.copy_from_slice(f.as_flattened());
        true
    }

    fn stresses(&self, k: &GroupPoint, stresses: &mut [f64]) {
        let work = |first: usize, stresses: &mut [f64]| {
            for (i, n) in stresses.chunks_exact_mut(S).enumerate() {
                n.copy_from_slice(&self.stress(first + i, k).stress);
            }
        };
        self.constitution.evaluated(&mut || for_each_chunk(&mut *stresses, S, &work));
    }

    fn extrapolate(
        &self,
        k: &GroupPoint,
        increment: &[Nodal],
        weights: &TangentWeights,
        stresses: &mut [f64],
    ) {
        let tau = self.retardation_time;
        let one = |e: usize, out: &mut [f64]| {
            let StrainState { acting, stress, strain } = self.stress(e, k);
            let delta = self.strains.directions(&self.gather(e, increment));
            let change = self.strains.rates(&acting, &delta);
            let product = self.constitution.tangent_product(e, &strain, &change, &self.interior(e, k));
            for i in 0..S {
                out[i] = stress[i] + weights.stress * product[i];
            }
            if tau != 0.0 {
                let product = self.constitution.viscous(e, &change);
                for i in 0..S {
                    out[i] += tau * weights.rate * product[i];
                }
            }
        };
        let work = |first: usize, stresses: &mut [f64]| {
            stresses.chunks_exact_mut(S).enumerate().for_each(|(i, out)| one(first + i, out));
        };
        self.constitution.evaluated(&mut || for_each_chunk(&mut *stresses, S, &work));
    }

    fn energies(&self, k: &GroupPoint, energies: &mut [f64]) {
        let work = |first: usize, energies: &mut [f64]| {
            for (e, out) in (first..).zip(energies) {
                *out = self.constitution.energy(e, &self.strain(e, k), &self.interior(e, k));
            }
        };
        self.constitution.evaluated(&mut || for_each_chunk(&mut *energies, 1, &work));
    }

    fn material_energies(&self, k: &GroupPoint, motion: &[Nodal], energies: &mut [f64]) {
        let work = |first: usize, energies: &mut [f64]| {
            for (e, energy) in (first..).zip(energies) {
                let StrainState { acting, strain, .. } = self.stress(e, k);
                let change = self.strains.rates(&acting, &self.strains.directions(&self.gather(e, motion)));
                let stress = self.constitution.tangent_product(e, &strain, &change, &self.interior(e, k));
                *energy = 0.5 * change.iter().zip(&stress).map(|(s, n)| s * n).sum::<f64>();
            }
        };
        self.constitution.evaluated(&mut || for_each_chunk(&mut *energies, 1, &work));
    }

    fn sampled_strains(&self, element: usize, k: &GroupPoint) -> Vec<f64> {
        self.strain(element, k).to_vec()
    }

    fn strain_rates(&self, element: usize, k: &GroupPoint) -> Vec<f64> {
        self.rate(element, k).to_vec()
    }

    fn history_per_element(&self) -> usize {
        self.constitution.history()
    }

    fn update_history(&self, k: &GroupPoint, history: &mut [f64]) -> f64 {
        let n = self.constitution.history();
        if n == 0 {
            return 0.0;
        }
        // Summed element by element, so that the result does not depend on the number of threads.
        let mut dissipated = 0.0;
        self.constitution.evaluated(&mut || {
            dissipated = 0.0;
            for (e, out) in history.chunks_exact_mut(n).enumerate() {
                dissipated += self.constitution.update(e, &self.strain(e, k), &self.interior(e, k), out);
            }
        });
        dissipated
    }

    fn dissipation(&self, k: &GroupPoint, power: &mut [f64]) {
        let tau = self.retardation_time;
        if tau == 0.0 {
            power.fill(0.0);
            return;
        }
        for_each_chunk(power, 1, &|first, power| {
            for (e, out) in (first..).zip(power) {
                let rate = self.rate(e, k);
                let n = self.constitution.viscous(e, &rate);
                *out = tau * rate.iter().zip(&n).map(|(a, b)| a * b).sum::<f64>();
            }
        });
    }
}
