//! Elastic foundations: linear springs between positions of nodes and their places in the reference configuration, with the energy
//! `½ Σ w_ab u_a·K u_b` and Kelvin–Voigt damping, forces `Σ w_ab K (u_b + τ u̇_b)` (E. Winkler, *Die Lehre von der Elasticität und
//! Festigkeit*, 1867).

use crate::element::power_series::{KnownOrders, PowerSeries};
use crate::element::{ElementGroup, GroupPoint, Motion, Nodal, StressIncrement, TangentRequest};
use crate::{Mat3, Vec3};

/// Most nodes of an element.
const MOST_NODES: usize = 4;

/// Foundation of a node, an edge or a quad.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundationElement {
    /// Positions of the nodes.
    pub vectors: Vec<u32>,
    /// Weights w_ab: lower triangle by rows.
    pub weights: Vec<f64>,
    /// Stiffness K.
    pub stiffness: Mat3,
    /// Retardation time τ.
    pub retardation_time: f64,
}

impl FoundationElement {
    /// Name of the group of foundations.
    pub const NAME: &'static str = "foundation";
}

/// Foundations of as many nodes each and of the same retardation time.
pub struct FoundationGroup {
    members: Vec<FoundationElement>,
    vectors: usize,
    retardation_time: f64,
}

impl FoundationGroup {
    /// Groups of all foundations.
    pub fn groups(elements: &[FoundationElement]) -> Vec<Box<dyn ElementGroup>> {
        let mut kinds: Vec<(usize, f64)> =
            elements.iter().map(|element| (element.vectors.len(), element.retardation_time)).collect();
        kinds.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        kinds.dedup();
        let of_kind = |(vectors, retardation_time): (usize, f64)| -> Box<dyn ElementGroup> {
            let is_member = |element: &&FoundationElement| {
                (element.vectors.len(), element.retardation_time) == (vectors, retardation_time)
            };
            let members = elements.iter().filter(is_member).cloned().collect();
            Box::new(Self { members, vectors, retardation_time })
        };
        kinds.into_iter().map(of_kind).collect()
    }

    /// Products `Σ w_ab K x_b` of an element with values at its nodes.
    fn products(&self, element: usize, value: impl Fn(usize) -> Vec3) -> [Vec3; MOST_NODES] {
        let member = &self.members[element];
        let mut out = [Vec3::zeros(); MOST_NODES];
        for ((a, b), weight) in pairs(self.vectors).zip(&member.weights) {
            out[a] += value(b) * *weight;
            if a != b {
                out[b] += value(a) * *weight;
            }
        }
        out.iter_mut().for_each(|x| *x = member.stiffness * *x);
        out
    }

    /// Product `Σ w_ab x_a·K x_b` of an element with values at its nodes.
    fn square_of(&self, element: usize, value: impl Fn(usize) -> Vec3) -> f64 {
        let products = self.products(element, &value);
        products[..self.vectors].iter().enumerate().map(|(a, product)| value(a).dot(product)).sum()
    }

    /// Product `Σ w_ab x_a·K x_b` of an element with a field.
    fn square(&self, element: usize, field: &[Nodal]) -> f64 {
        let vectors = &self.members[element].vectors;
        let at = |a: usize| Vec3::from(field[vectors[a] as usize]);
        self.square_of(element, at)
    }
}

/// Pairs of nodes in the order of the weights.
fn pairs(n: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..n).flat_map(|a| (0..=a).map(move |b| (a, b)))
}

/// Forces are linear in the displacements: those of an order have no known part.
impl PowerSeries for FoundationGroup {
    fn stored_stresses(&self, _: usize) -> usize {
        0
    }

    fn forces_of_order(&self, _: &KnownOrders, _: &mut [f64], forces: &mut [f64]) {
        forces.fill(0.0);
    }

    fn tangent_products(&self, _: &GroupPoint, field: &[Nodal], forces: &mut [f64]) {
        for (element, out) in forces.chunks_exact_mut(3 * self.vectors).enumerate() {
            let vectors = &self.members[element].vectors;
            let products = self.products(element, |a| Vec3::from(field[vectors[a] as usize]));
            out.chunks_exact_mut(3).zip(&products).for_each(|(out, x)| out.copy_from_slice(x.as_slice()));
        }
    }
}

impl ElementGroup for FoundationGroup {
    fn name(&self) -> &'static str {
        FoundationElement::NAME
    }

    fn len(&self) -> usize {
        self.members.len()
    }

    fn vectors(&self, element: usize) -> &[u32] {
        &self.members[element].vectors
    }

    fn acts_on_ground(&self) -> bool {
        true
    }

    fn is_grounded(&self, _element: usize) -> bool {
        true
    }

    fn vectors_per_element(&self) -> usize {
        self.vectors
    }

    fn retardation_time(&self) -> f64 {
        self.retardation_time
    }

    fn power_series(&self) -> Option<&dyn PowerSeries> {
        Some(self)
    }

    fn evaluate(
        &self,
        k: &GroupPoint,
        first: usize,
        forces: &mut [f64],
        mut tangent: Option<TangentRequest>,
    ) {
        let n = self.vectors;
        let tau = self.retardation_time;
        for (e, out) in forces.chunks_mut(3 * n).enumerate() {
            let element = first + e;
            let member = &self.members[element];
            let at = |field: &[Nodal], a: usize| Vec3::from(field[member.vectors[a] as usize]);
            let delayed = |a: usize| match k.motion {
                Motion::State { u, velocity } => {
                    at(u, a) + velocity.map_or_else(Vec3::zeros, |v| at(v, a) * tau)
                }
                Motion::Step { old, new, dt } => {
                    (at(old, a) + at(new, a)) * 0.5 + (at(new, a) - at(old, a)) * (tau / dt)
                }
            };
            let mut found = self.products(element, delayed);
            if let Some(request) = &mut tangent {
                let weights = request.weights;
                let scale = weights.force * (weights.stress + weights.rate * tau);
                if let Some(increment) = request.prescribed {
                    let more = self.products(element, |a| at(increment, a));
                    found.iter_mut().zip(more).for_each(|(f, more)| *f += more * scale);
                }
                let size = 9 * n * (n + 1) / 2;
                let blocks = request.blocks[e * size..(e + 1) * size].chunks_exact_mut(9);
                for (block, weight) in blocks.zip(&member.weights) {
                    let stiffness = member.stiffness * (scale * weight);
                    block.iter_mut().enumerate().for_each(|(i, out)| *out = stiffness[(i / 3, i % 3)]);
                }
            }
            for (out, force) in out.chunks_exact_mut(3).zip(&found) {
                out.copy_from_slice(force.as_slice());
            }
        }
    }

    fn evaluate_stresses(
        &self,
        _: &GroupPoint,
        increment: &StressIncrement,
        first: usize,
        (forces, blocks): (&mut [f64], &mut [f64]),
    ) {
        for (e, out) in (first..).zip(forces.chunks_mut(3 * self.vectors)) {
            let vectors = &self.members[e].vectors;
            let found = self.products(e, |a| Vec3::from(increment.displacements[vectors[a] as usize]));
            for (out, force) in out.chunks_exact_mut(3).zip(&found) {
                out.copy_from_slice(force.as_slice());
            }
        }
        // Forces of foundations are linear in the displacements.
        blocks.fill(0.0);
    }

    fn energies(&self, k: &GroupPoint, energies: &mut [f64]) {
        let (Motion::State { u, .. } | Motion::Step { new: u, .. }) = k.motion;
        for (element, energy) in energies.iter_mut().enumerate() {
            *energy = 0.5 * self.square(element, u);
        }
    }

    fn dissipation(&self, k: &GroupPoint, power: &mut [f64]) {
        for (element, power) in power.iter_mut().enumerate() {
            *power = self.retardation_time
                * match k.motion {
                    Motion::State { velocity, .. } => velocity.map_or(0.0, |v| self.square(element, v)),
                    Motion::Step { old, new, dt } => {
                        let vectors = &self.members[element].vectors;
                        let at = |u: &[Nodal], a: usize| Vec3::from(u[vectors[a] as usize]);
                        self.square_of(element, |a| (at(new, a) - at(old, a)) / dt)
                    }
                };
        }
    }
}
