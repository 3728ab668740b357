//! All elements of one type and section, as a structure of arrays.
//!
//! Static dispatch inside the loop, one dynamic call per group. Elements write their
//! forces and tangent blocks to their own place in a buffer; the assembly sums them in
//! a fixed order, so results do not depend on the number of threads.

use pulp::Arch;
use rayon::prelude::*;

use super::strains::{Directions, SampledStrains};

/// A nodal vector as stored in fields.
pub type Nodal = [f64; 3];

/// Elements that one task works on.
const CHUNK: usize = 64;

/// The motion at which elements are evaluated; displacements of all nodal vectors from the reference.
#[derive(Debug, Clone, Copy)]
pub enum Motion<'a> {
    /// A state: stress of the strain `s(u)`, with the rate `S(u) v` where damping acts.
    State {
        /// Displacements.
        u: &'a [Nodal],
        /// Velocities, needed where a group has a retardation time.
        velocity: Option<&'a [Nodal]>,
    },
    /// A step of the energy–momentum scheme: stress of `½(s_n + s_{n+1})` acting at `½(u_n + u_{n+1})`.
    Step {
        /// Displacements at the start of the step.
        old: &'a [Nodal],
        /// Displacements at its end.
        new: &'a [Nodal],
        /// Length of the step.
        dt: f64,
    },
}

/// Weights of the parts of a tangent `material · SᵀHS + geometric · Σ 2n A⊗I`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TangentWeights {
    /// dn/dδ = `stress` · H S; the material part is `force` times as much.
    pub stress: f64,
    /// Share of the change of the directions in a step.
    pub direction: f64,
    /// Factor of the internal force in the residual.
    pub force: f64,
    /// Factor of the velocity change per displacement change, for rate damping.
    pub rate: f64,
}

/// What the elements are evaluated with.
#[derive(Debug, Clone, Copy)]
pub struct Kinematics<'a> {
    /// Nodal vectors of the reference configuration.
    pub reference: &'a [Nodal],
    /// The motion.
    pub motion: Motion<'a>,
    /// Small displacements: strains linear in the displacement.
    pub linear: bool,
}

/// Elements of one type, evaluated together.
pub trait ElementGroup: Send + Sync {
    /// Name of the element type.
    fn name(&self) -> &'static str;
    /// Number of elements.
    fn len(&self) -> usize;
    /// True if there are none.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// Nodal vectors of an element.
    fn vectors(&self, element: usize) -> &[u32];
    /// Number of nodal vectors per element.
    fn vectors_per_element(&self) -> usize;
    /// Number of sampled strains per element.
    fn samples(&self) -> usize;
    /// Scalar mass of the pairs of nodal vectors (lower triangle) of an element.
    fn mass(&self, element: usize) -> &[f64];
    /// Retardation time of rate damping.
    fn retardation_time(&self) -> f64;
    /// Internal forces, one block of `3 · vectors_per_element` per element; with `tangent` also the lower
    /// blocks of the tangent, whose geometric part takes the stress `stress` (of the motion where `None`).
    /// A `prescribed` increment adds `tangent · increment` to the force.
    fn evaluate(&self, k: &Kinematics, forces: &mut [f64], tangent: Option<TangentRequest>);
    /// Stress resultants of the samples.
    fn stresses(&self, k: &Kinematics, stresses: &mut [f64]);
    /// Stress extrapolated along an increment: `n ← n(motion) + weight · H S δ`.
    fn extrapolate(
        &self,
        k: &Kinematics,
        increment: &[Nodal],
        weights: &TangentWeights,
        stresses: &mut [f64],
    );
    /// Strain energy ½ sᵀHs of each element at displacements `u`.
    fn energies(&self, reference: &[Nodal], u: &[Nodal], linear: bool, energies: &mut [f64]);
    /// Sampled strains of one element at displacements `u`.
    fn sampled_strains(&self, element: usize, reference: &[Nodal], u: &[Nodal], linear: bool) -> Vec<f64>;
    /// Power τ ṡᵀHṡ dissipated in each element.
    fn dissipation(&self, k: &Kinematics, power: &mut [f64]);
}

/// What a tangent is made with.
#[derive(Debug)]
pub struct TangentRequest<'a> {
    /// Weights of its parts.
    pub weights: TangentWeights,
    /// Stress of the geometric part per element and sample; that of the motion where `None`.
    pub stress: Option<&'a [f64]>,
    /// Increment of prescribed coordinates, zero elsewhere.
    pub prescribed: Option<&'a [Nodal]>,
    /// Lower blocks, `9 · blocks` per element.
    pub blocks: &'a mut [f64],
}

/// Elements whose strains are quadratic forms and whose energy is `½ sᵀHs`.
pub struct QuadraticGroup<const M: usize, const N: usize, const S: usize> {
    name: &'static str,
    strains: SampledStrains<M, N, S>,
    vectors: Vec<[u32; M]>,
    /// `S × S` per element, by rows.
    h: Vec<f64>,
    /// Lower triangle per element.
    mass: Vec<f64>,
    retardation_time: f64,
    arch: Arch,
}

impl<const M: usize, const N: usize, const S: usize> QuadraticGroup<M, N, S> {
    /// An empty group.
    pub fn new(name: &'static str, strains: SampledStrains<M, N, S>, retardation_time: f64) -> Self {
        Self {
            name,
            strains,
            vectors: Vec::new(),
            h: Vec::new(),
            mass: Vec::new(),
            retardation_time,
            arch: Arch::new(),
        }
    }

    /// Adds an element: its nodal vectors, `H` by rows and the lower triangle of its scalar mass.
    pub fn push(&mut self, vectors: [u32; M], h: &[f64], mass: &[f64]) {
        debug_assert_eq!(h.len(), S * S);
        debug_assert_eq!(mass.len(), M * (M + 1) / 2);
        self.vectors.push(vectors);
        self.h.extend_from_slice(h);
        self.mass.extend_from_slice(mass);
    }

    /// Multiplies the mass of all elements.
    pub fn scale_mass(&mut self, factor: f64) {
        self.mass.iter_mut().for_each(|m| *m *= factor);
    }

    #[inline(always)]
    fn gather(&self, element: usize, field: &[Nodal]) -> [Nodal; M] {
        self.vectors[element].map(|v| field[v as usize])
    }

    #[inline(always)]
    fn multiply(&self, element: usize, s: &[f64; S]) -> [f64; S] {
        let h = &self.h[element * S * S..(element + 1) * S * S];
        let mut n = [0.0; S];
        for (n_k, row) in n.iter_mut().zip(h.chunks_exact(S)) {
            let mut sum = 0.0;
            for (a, b) in row.iter().zip(s) {
                sum += a * b;
            }
            *n_k = sum;
        }
        n
    }

    #[inline(always)]
    fn strains_at(
        &self,
        e: usize,
        k: &Kinematics,
        p0: &Directions<f64>,
        u: &[Nodal],
    ) -> (Directions<f64>, [f64; S]) {
        let p = self.strains.directions(&self.gather(e, u));
        let s = self.strains.strains(p0, &p, !k.linear);
        (p, s)
    }

    /// Stress of the motion and the directions on which it acts.
    #[inline(always)]
    fn stress(&self, e: usize, k: &Kinematics) -> (Directions<f64>, [f64; S]) {
        let p0 = self.strains.directions(&self.gather(e, k.reference));
        let mut acting = p0;
        let tau = self.retardation_time;
        let mut strain;
        match k.motion {
            Motion::State { u, velocity } => {
                let (p, s) = self.strains_at(e, k, &p0, u);
                if !k.linear {
                    add(&mut acting, &p, 1.0);
                }
                strain = s;
                if let (Some(v), true) = (velocity, tau != 0.0) {
                    let v = self.strains.directions(&self.gather(e, v));
                    let rate = self.strains.rates(&acting, &v);
                    for i in 0..S {
                        strain[i] += tau * rate[i];
                    }
                }
            }
            Motion::Step { old, new, dt } => {
                let (p_old, s_old) = self.strains_at(e, k, &p0, old);
                let (p_new, s_new) = self.strains_at(e, k, &p0, new);
                if !k.linear {
                    add(&mut acting, &p_old, 0.5);
                    add(&mut acting, &p_new, 0.5);
                }
                strain = [0.0; S];
                for i in 0..S {
                    strain[i] = 0.5 * (s_old[i] + s_new[i]) + tau / dt * (s_new[i] - s_old[i]);
                }
            }
        }
        (acting, self.multiply(e, &strain))
    }

    #[inline(always)]
    fn evaluate_one(&self, e: usize, k: &Kinematics, force: &mut [f64], tangent: Option<OneTangent>) {
        let (acting, n) = self.stress(e, k);
        let f = self.strains.force(&acting, &n);
        for (out, value) in force.iter_mut().zip(f.as_flattened()) {
            *out = *value;
        }
        let Some(OneTangent { weights: w, stress, prescribed, blocks }) = tangent else { return };
        let mut geometric_stress = n;
        if let Some(stored) = stress {
            geometric_stress.copy_from_slice(&stored[e * S..(e + 1) * S]);
        }
        let gradient = self.strains.gradient(&acting);
        let h = &self.h[e * S * S..(e + 1) * S * S];
        let material = w.force * (w.stress + self.retardation_time * w.rate);
        let geometric = if k.linear { 0.0 } else { w.force * w.direction };
        self.strains.tangent(h, &gradient, &geometric_stress, material, geometric, blocks);
        if let Some(increment) = prescribed {
            let d = self.gather(e, increment);
            if d.iter().any(|v| *v != [0.0; 3]) {
                multiply_blocks(blocks, &d, 1.0 / w.force, force);
            }
        }
    }
}

/// A [`TangentRequest`] with the blocks of one element.
struct OneTangent<'a> {
    weights: &'a TangentWeights,
    stress: Option<&'a [f64]>,
    prescribed: Option<&'a [Nodal]>,
    blocks: &'a mut [f64],
}

/// Adds `scale · K d` for the lower blocks of a symmetric element matrix.
fn multiply_blocks(blocks: &[f64], d: &[Nodal], scale: f64, out: &mut [f64]) {
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
fn add(to: &mut Directions<f64>, from: &Directions<f64>, factor: f64) {
    for (t, f) in to.iter_mut().zip(from) {
        for i in 0..3 {
            t[i] += factor * f[i];
        }
    }
}

impl<const M: usize, const N: usize, const S: usize> ElementGroup for QuadraticGroup<M, N, S> {
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
        M
    }

    fn samples(&self) -> usize {
        S
    }

    fn mass(&self, element: usize) -> &[f64] {
        let n = M * (M + 1) / 2;
        &self.mass[element * n..(element + 1) * n]
    }

    fn retardation_time(&self) -> f64 {
        self.retardation_time
    }

    fn evaluate(&self, k: &Kinematics, forces: &mut [f64], tangent: Option<TangentRequest>) {
        let arch = self.arch;
        match tangent {
            None => {
                forces.par_chunks_mut(CHUNK * N).enumerate().for_each(|(chunk, forces)| {
                    arch.dispatch(
                        #[inline(always)]
                        || {
                            for (i, force) in forces.chunks_exact_mut(N).enumerate() {
                                self.evaluate_one(chunk * CHUNK + i, k, force, None);
                            }
                        },
                    );
                });
            }
            Some(request) => {
                let size = 9 * SampledStrains::<M, N, S>::BLOCKS;
                let TangentRequest { weights, stress, prescribed, blocks } = request;
                forces
                    .par_chunks_mut(CHUNK * N)
                    .zip(blocks.par_chunks_mut(CHUNK * size))
                    .enumerate()
                    .for_each(|(chunk, (forces, blocks))| {
                        arch.dispatch(
                            #[inline(always)]
                            || {
                                for (i, (force, blocks)) in
                                    forces.chunks_exact_mut(N).zip(blocks.chunks_exact_mut(size)).enumerate()
                                {
                                    let tangent =
                                        Some(OneTangent { weights: &weights, stress, prescribed, blocks });
                                    self.evaluate_one(chunk * CHUNK + i, k, force, tangent);
                                }
                            },
                        );
                    });
            }
        }
    }

    fn stresses(&self, k: &Kinematics, stresses: &mut [f64]) {
        stresses.par_chunks_mut(S).with_min_len(CHUNK).enumerate().for_each(|(e, n)| {
            n.copy_from_slice(&self.stress(e, k).1);
        });
    }

    fn extrapolate(
        &self,
        k: &Kinematics,
        increment: &[Nodal],
        weights: &TangentWeights,
        stresses: &mut [f64],
    ) {
        let factor = weights.stress + self.retardation_time * weights.rate;
        stresses.par_chunks_mut(S).with_min_len(CHUNK).enumerate().for_each(|(e, out)| {
            let (acting, n) = self.stress(e, k);
            let delta = self.strains.directions(&self.gather(e, increment));
            let change = self.multiply(e, &self.strains.rates(&acting, &delta));
            for i in 0..S {
                out[i] = n[i] + factor * change[i];
            }
        });
    }

    fn energies(&self, reference: &[Nodal], u: &[Nodal], linear: bool, energies: &mut [f64]) {
        let k = Kinematics { reference, motion: Motion::State { u, velocity: None }, linear };
        energies.par_iter_mut().with_min_len(CHUNK).enumerate().for_each(|(e, out)| {
            let p0 = self.strains.directions(&self.gather(e, reference));
            let (_, s) = self.strains_at(e, &k, &p0, u);
            let n = self.multiply(e, &s);
            *out = 0.5 * s.iter().zip(&n).map(|(a, b)| a * b).sum::<f64>();
        });
    }

    fn sampled_strains(&self, element: usize, reference: &[Nodal], u: &[Nodal], linear: bool) -> Vec<f64> {
        let k = Kinematics { reference, motion: Motion::State { u, velocity: None }, linear };
        let p0 = self.strains.directions(&self.gather(element, reference));
        self.strains_at(element, &k, &p0, u).1.to_vec()
    }

    fn dissipation(&self, k: &Kinematics, power: &mut [f64]) {
        let tau = self.retardation_time;
        if tau == 0.0 {
            power.fill(0.0);
            return;
        }
        power.par_iter_mut().with_min_len(CHUNK).enumerate().for_each(|(e, out)| {
            let p0 = self.strains.directions(&self.gather(e, k.reference));
            let rate = match k.motion {
                Motion::State { u, velocity } => {
                    let Some(v) = velocity else {
                        *out = 0.0;
                        return;
                    };
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
            };
            let n = self.multiply(e, &rate);
            *out = tau * rate.iter().zip(&n).map(|(a, b)| a * b).sum::<f64>();
        });
    }
}
