//! Reactions of supports and prescribed motions, resultants of loads, and the balance of all forces.
//!
//! With the internal forces f, the loads F, the inertia and mass damping I = M a + α M v, the unbalanced forces of the
//! nodal vectors are g = f + I − F. Along free degrees of freedom the equation of motion makes them vanish; along
//! constrained ones they are the reactions R. The forces on positions sum up to the resultant; a generalised force on a
//! director is a moment: a nodal vector x (arm of a position, director or gradient) under the force f contributes x ×
//! f. Internal forces have neither resultant nor moment but those that
//! joints and springs transfer to the ground, so F + R − I less these must vanish, which the [balance](Equilibrium)
//! measures.
//!
//! The forces are those of the equation of the step: at its end for statics, Newmark and explicit steps; for HHT
//! weighted between its ends, for the energy–momentum scheme at its midpoint.

use std::borrow::Cow;
use std::collections::BTreeMap;

use super::cuts::{CutResultant, cut_resultants};
use super::resultant::{Resultant, add_to, arm, resultant};
use crate::Vec3;
use crate::analysis::State;
use crate::analysis::dynamics::schemes::Instant;
use crate::element::{Motion, Nodal};
use crate::model::Scheme;
use crate::system::supports::Support;
use crate::system::{Assembly, EvaluationPoint, Internal, System, VectorKind};
use tegula_sparse::norm::larger;

/// Forces on the whole model.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Equilibrium {
    /// Reactions on the sets that are supported or moved, in the order of [`System::support_sets`].
    pub supports: Vec<Resultant>,
    /// Loads, in the order of [`System::load_sets`].
    pub loads: Vec<Resultant>,
    /// Section forces and moments, in the order of [`System::cuts`].
    pub cuts: Vec<CutResultant>,
    /// Inertia and mass damping, about the origin.
    pub inertia: Resultant,
    /// Resultant force of loads, reactions and inertia over the sum of their sizes, or over that of the moments by the length of
    /// the model.
    pub force_error: f64,
    /// Resultant moment about the middle of the model, over the sum of the sizes of the nodal moments.
    pub moment_error: f64,
    /// Reactions on the nodal vectors.
    pub reactions: Vec<Nodal>,
}

impl Equilibrium {
    /// Reaction force and moment at each node: the moment comes from the generalised forces on its directors and
    /// gradients.
    pub fn at_nodes(&self, system: &System, u: &[Nodal]) -> (Vec<Nodal>, Vec<Nodal>) {
        let nodes = system.coordinates.position_of.len();
        let (mut forces, mut moments) = (vec![[0.0; 3]; nodes], vec![[0.0; 3]; nodes]);
        for (v, f) in self.reactions.iter().enumerate().filter(|(_, f)| **f != [0.0; 3]) {
            let node = system.coordinates.nodes[v] as usize;
            let (out, part) = match system.coordinates.kinds[v] {
                VectorKind::Position => (&mut forces[node], Vec3::from(*f)),
                VectorKind::Director | VectorKind::Gradient => {
                    (&mut moments[node], arm(system, u, v).cross(&Vec3::from(*f)))
                }
            };
            *out = (Vec3::from(*out) + part).into();
        }
        (forces, moments)
    }
}

/// Constrained directions of a nodal vector and the sets of supports that their reactions belong to.
struct Supported {
    vector: usize,
    /// Orthonormal directions, each with its set.
    axes: Vec<(Vec3, usize)>,
    /// Whether the vector is an inextensible director that can rotate about its one constrained direction.
    turns: bool,
}

/// Internal forces.
struct Internals {
    /// Sums on the nodal vectors.
    nodal: Vec<Nodal>,
    /// Forces of elements at the cuts.
    cuts: Vec<Nodal>,
}

/// Instant at which loads act.
struct LoadInstant<'a> {
    time: f64,
    /// Weight of the loads of this instant.
    share: f64,
    u: Cow<'a, [Nodal]>,
    /// Velocities; empty: there are none.
    v: Cow<'a, [Nodal]>,
}

impl<'a> LoadInstant<'a> {
    /// Loads of a state.
    fn of(state: &'a State, share: f64) -> Self {
        Self { time: state.time, share, u: Cow::Borrowed(&state.u), v: Cow::Borrowed(&state.v) }
    }
}

/// Forces that make up the balance of one instant, and the nodal vectors on which they act.
struct Forces<'a> {
    u: Cow<'a, [Nodal]>,
    internal: Internals,
    inertia: Vec<Nodal>,
    /// Instants at which loads act.
    loads: Vec<LoadInstant<'a>>,
}

/// Recovery of reactions and of the balance of forces.
pub struct ReactionFinder {
    assembly: Assembly,
    instant: Instant,
    supported: Vec<Supported>,
}

impl ReactionFinder {
    /// Recovery for a scheme of time integration, `None` for statics.
    pub fn new(system: &System, scheme: Option<Scheme>) -> Self {
        let instant = scheme.map_or(Instant::End, |scheme| scheme.instant(system));
        Self { assembly: Assembly::for_forces(system), instant, supported: supported(system) }
    }

    /// Equilibrium of the forces of a step from `old` to `new`; at `new` alone without a step.
    pub fn find(&mut self, system: &System, old: Option<&State>, new: &State) -> Equilibrium {
        let old = old.filter(|old| old.u.len() == new.u.len() && old.time < new.time);
        // A jump of velocities changes damping forces at once: the equation of the step before no longer holds.
        let jumped = system.has_kink(new.time) && system.has_rate_damping();
        let forces = match (self.instant, old) {
            (Instant::Between(weight), Some(old)) if !jumped => self.between(system, (old, new), weight),
            (Instant::Middle, Some(old)) => self.middle(system, old, new),
            _ => Forces {
                internal: self.internal(system, new),
                inertia: inertia(system, &new.a, &new.v),
                loads: vec![LoadInstant::of(new, 1.0)],
                u: Cow::Borrowed(&new.u),
            },
        };
        let earlier = FORCE_FREE * earlier_forces(system, new);
        let out = self.sum(system, &forces, earlier);
        let strained = !system.prescribed_strains.is_empty() || system.yields();
        if !strained || larger(out.force_error, out.moment_error) <= FORCE_FREE {
            return out;
        }
        self.sum(system, &forces, larger(earlier, ROUND_OFF * stretching_force(system, new)))
    }

    /// HHT: internal forces, damping and loads between the ends of the step, inertia of its accelerations.
    fn between<'a>(
        &mut self,
        system: &System,
        (old, new): (&'a State, &'a State),
        weight: f64,
    ) -> Forces<'a> {
        let shares = [weight, 1.0 - weight];
        let [start, end] = [old, new].map(|state| self.internal(system, state));
        let internal = Internals {
            nodal: combine(shares, &start.nodal, &end.nodal),
            cuts: combine(shares, &start.cuts, &end.cuts),
        };
        let loads = [old, new].into_iter().zip(shares);
        Forces {
            internal,
            inertia: inertia(system, &new.a, &combine(shares, &old.v, &new.v)),
            loads: loads.map(|(state, share)| LoadInstant::of(state, share)).collect(),
            u: Cow::Owned(combine(shares, &old.u, &new.u)),
        }
    }

    /// Energy–momentum scheme: forces of the step, which act at its midpoint.
    fn middle<'a>(&mut self, system: &System, old: &State, new: &State) -> Forces<'a> {
        let dt = new.time - old.time;
        let middle = old.time + 0.5 * dt;
        let motion = Motion::Step { old: &old.u, new: &new.u, dt };
        let internal = Internal { history: &old.history, multipliers: &new.multipliers };
        let k = EvaluationPoint::new(system, motion, middle, internal);
        let internal = self.forces(system, &k);
        let (mean, rate) = ([0.5, 0.5], [-1.0 / dt, 1.0 / dt]);
        let u = combine(mean, &old.u, &new.u);
        Forces {
            internal,
            // The state holds the mean accelerations of the step.
            inertia: inertia(system, &new.a, &combine(rate, &old.u, &new.u)),
            loads: vec![LoadInstant {
                time: middle,
                share: 1.0,
                u: Cow::Owned(u.clone()),
                v: Cow::Owned(combine(rate, &old.u, &new.u)),
            }],
            u: Cow::Owned(u),
        }
    }

    /// Internal forces of a state.
    fn internal(&mut self, system: &System, state: &State) -> Internals {
        self.forces(system, &state.point_with_rates(system))
    }

    /// Internal forces of a motion.
    fn forces(&mut self, system: &System, k: &EvaluationPoint) -> Internals {
        let mut nodal = vec![[0.0; 3]; system.vectors()];
        self.assembly.forces(system, k, &mut nodal);
        Internals { nodal, cuts: system.cut_forces(&self.assembly) }
    }

    /// Resultants and balance; forces below `least` are round-off.
    fn sum(&mut self, system: &System, forces: &Forces, least: f64) -> Equilibrium {
        let u = forces.u.as_ref();
        let zero = vec![[0.0; 3]; u.len()];
        let cuts = cut_resultants(system, u, &forces.internal.cuts);
        let mut out = Equilibrium { reactions: zero.clone(), cuts, ..Equilibrium::default() };
        let (mut all_loads, mut relief) = (zero.clone(), zero.clone());
        for (index, set) in system.load_sets.iter().enumerate() {
            let mut load = zero.clone();
            add_load_set(system, index, &forces.loads, &mut load);
            out.loads.push(resultant(system, u, &load, &set.about));
            all_loads = combine([1.0, 1.0], &all_loads, &load);
            if system.inertia_relief.as_ref().is_some_and(|relief| relief.load_set == index) {
                relief = load;
            }
        }
        out.inertia = resultant(system, u, &forces.inertia, &Vec3::zeros());
        let unbalanced =
            combine([1.0, -1.0], &combine([1.0, 1.0], &forces.internal.nodal, &forces.inertia), &all_loads);
        out.supports = vec![Resultant::default(); system.support_sets.len()];
        for supported in &self.supported {
            let v = supported.vector;
            for (set, force) in supported.parts(system, u, &unbalanced[v]) {
                out.reactions[v] = (Vec3::from(out.reactions[v]) + force).into();
                add_to(&mut out.supports[set], system, (u, v), &force, &system.support_sets[set].about);
            }
        }
        let mut balance = Sum::new(system);
        // Inertia forces of a relief may cancel the loads at each node: both count for the size of the forces.
        balance.add(system, u, &combine([1.0, -1.0], &all_loads, &relief), 1.0);
        balance.add(system, u, &relief, 1.0);
        balance.add(system, u, &forces.inertia, -1.0);
        balance.add(system, u, &out.reactions, 1.0);
        if system.acts_on_ground() {
            // Joints and springs transfer forces to the ground, with which the internal forces have a resultant.
            balance.add(system, u, &forces.internal.nodal, -1.0);
        }
        (out.force_error, out.moment_error) = balance.errors(least, system.length);
        out
    }
}

/// Constrained nodal vectors. Where conditions meet at a node, a direction belongs to the first condition of the file
/// that constrains it.
fn supported(system: &System) -> Vec<Supported> {
    let mut by_vector: BTreeMap<usize, Vec<&Support>> = BTreeMap::new();
    for support in &system.supports {
        by_vector.entry(support.vector as usize).or_default().push(support);
    }
    let sets: BTreeMap<&str, usize> = system
        .support_sets
        .iter()
        .enumerate()
        .flat_map(|(index, set)| set.keys.iter().map(move |key| (key.as_str(), index)))
        .collect();
    let units: BTreeMap<usize, Option<Vec3>> =
        system.dofs().unit.iter().map(|unit| (unit.vector as usize, unit.fixed)).collect();
    let of_vector = |(vector, supports): (usize, Vec<&Support>)| {
        let mut axes: Vec<(Vec3, usize)> = Vec::new();
        for support in supports {
            let rest = axes.iter().fold(support.direction, |d, (a, _)| d - a * a.dot(&support.direction));
            if rest.norm() > 1e-9 {
                axes.push((rest.normalize(), *sets.get(support.key.as_str())?));
            }
        }
        let turns = units.contains_key(&vector);
        if turns {
            // A support along the director is redundant: its length is constant anyway.
            let fixed = units[&vector]?;
            axes.retain(|(axis, _)| axis.dot(&fixed).abs() > 0.5);
        }
        Some(Supported { vector, axes, turns })
    };
    by_vector.into_iter().filter_map(of_vector).collect()
}

impl Supported {
    /// Reactions on the vector and the sets that they belong to, from its unbalanced force.
    fn parts(&self, system: &System, u: &[Nodal], force: &Nodal) -> impl Iterator<Item = (usize, Vec3)> {
        let force = Vec3::from(*force);
        let d = arm(system, u, self.vector);
        self.axes.iter().map(move |(axis, set)| {
            let mut along = force.dot(axis);
            if self.turns {
                // The constraint force on the inextensible director is internal and has no moment; the support carries
                // the remainder.
                let across = d - axis * axis.dot(&d);
                let length = force.dot(&across) / across.norm_squared().max(f64::MIN_POSITIVE);
                along -= length * d.dot(axis);
            }
            (*set, axis * along)
        })
    }
}

/// Adds the loads of one set.
fn add_load_set(system: &System, set: usize, instants: &[LoadInstant], out: &mut Vec<Nodal>) {
    for LoadInstant { time, share, u, v } in instants {
        let velocity = (!v.is_empty()).then_some(v.as_ref());
        let motion = Motion::State { u, velocity };
        system.add_field_loads(&motion, (*time, *share), |of| of == set, out);
        for (load, _) in system.dead_loads.iter().zip(&system.load_of_dead).filter(|(_, of)| **of == set) {
            *out = combine([1.0, share * system.factor(&load.factor, *time)], out, &load.force);
        }
        for (load, _) in system.followers.iter().zip(&system.load_of_follower).filter(|(_, of)| **of == set) {
            let x: Vec<Vec3> = load.vectors().iter().map(|&v| arm(system, u, v as usize)).collect();
            let mut forces = vec![[0.0; 3]; x.len()];
            load.forces(&x, &mut forces);
            let factor = share * system.factor(load.factor(), *time);
            for (&v, f) in load.vectors().iter().zip(forces) {
                (0..3).for_each(|i| out[v as usize][i] += factor * f[i]);
            }
        }
        let at = (&Motion::State { u, velocity: None }, *time);
        for (load, _) in
            system.centrifugal.iter().zip(&system.load_of_centrifugal).filter(|(_, of)| **of == set)
        {
            system.add_centrifugal_load(load, at, *share, out);
        }
        if system.inertia_relief.as_ref().is_some_and(|relief| relief.load_set == set) {
            system.add_inertia_relief(at.0, at.1, *share, out);
        }
    }
}

/// Inertia and mass damping.
fn inertia(system: &System, a: &[Nodal], v: &[Nodal]) -> Vec<Nodal> {
    let mut out = vec![[0.0; 3]; system.vectors()];
    if !a.is_empty() {
        system.pattern.add_mass_product(1.0, a, &mut out);
        system.pattern.add_mass_product(system.mass_damping, v, &mut out);
    }
    out
}

/// Weighted sum of two fields.
fn combine([a, b]: [f64; 2], x: &[Nodal], y: &[Nodal]) -> Vec<Nodal> {
    x.iter().zip(y).map(|(x, y)| std::array::from_fn(|i| a * x[i] + b * y[i])).collect()
}

/// Forces over those of earlier load steps below which a state is free of forces, up to round-off.
const FORCE_FREE: f64 = 1e-8;

/// Strain energy of a uniform strain of 1 over the length of the model: a force. Strains are differences of numbers of the size 1, and where parts
/// follow their prescribed strains freely, or are unloaded with plastic strains, the forces of the round-off of these numbers are all that is left.
fn stretching_force(system: &System, state: &State) -> f64 {
    let coordinates = &system.coordinates;
    let mut stretch = vec![[0.0; 3]; system.vectors()];
    for &v in coordinates.position_of.iter().filter(|&&v| v != u32::MAX) {
        let v = v as usize;
        stretch[v] = std::array::from_fn(|i| coordinates.reference[v][i] + state.u[v][i]);
    }
    let internal = Internal { history: &state.history, multipliers: &state.multipliers };
    let k = EvaluationPoint::at_rest(system, &state.u, state.time, internal);
    let factors: Vec<f64> = system.factors(state.time).collect();
    let mut energy = 0.0;
    for (g, group, _) in system.numbered_groups().filter(|(_, group, _)| group.stresses_per_element() > 0) {
        let mut energies = vec![0.0; group.len()];
        group.material_energies(&k.of_group(system, g, &factors), &stretch, &mut energies);
        energy += energies.iter().filter(|energy| energy.is_finite()).sum::<f64>();
    }
    energy / system.length
}

/// Forces over that of a uniform strain of 1 below which they are the round-off of strains, summed up over a model.
const ROUND_OFF: f64 = 1e-10;

/// Arm over the size of the model, with which the forces of a balance make the least scale of its moments.
const LEAST_ARM: f64 = 1e-6;

/// Size of the forces of the earlier states of a static analysis step: its largest energy over its largest displacement.
fn earlier_forces(system: &System, state: &State) -> f64 {
    // Displacements at round-off, as those of a restrained heated shell, are no measure.
    let moved = state.displacement_scale > 1e-12;
    if moved { state.energy_scale / (state.displacement_scale * system.length) } else { 0.0 }
}

/// Sum of forces and moments and of their sizes.
struct Sum {
    about: Vec3,
    total: Resultant,
    forces: f64,
    moments: f64,
}

impl Sum {
    fn new(system: &System) -> Self {
        let positions = system.coordinates.position_of.iter().filter(|&&p| p != u32::MAX);
        let (count, sum) = positions.fold((0.0, Vec3::zeros()), |(n, sum), &p| {
            (n + 1.0, sum + Vec3::from(system.coordinates.reference[p as usize]))
        });
        Self { about: sum / f64::max(count, 1.0), total: Resultant::default(), forces: 0.0, moments: 0.0 }
    }

    fn add(&mut self, system: &System, u: &[Nodal], forces: &[Nodal], factor: f64) {
        for (v, f) in forces.iter().enumerate().filter(|(_, f)| **f != [0.0; 3]) {
            let force = Vec3::from(*f) * factor;
            let mut one = Resultant::default();
            add_to(&mut one, system, (u, v), &force, &self.about);
            self.total.force += one.force;
            self.total.moment += one.moment;
            self.forces += one.force.norm();
            self.moments += one.moment.norm();
        }
    }

    /// Errors of the balances of forces and moments, over the forces, or over `least` where these are smaller. Moments count as
    /// the pairs of forces that they are at the distance `length`: the forces of a model under moments alone are round-off, as are the moments of forces
    /// along one line.
    fn errors(&self, least: f64, length: f64) -> (f64, f64) {
        let over = |sum: f64, scale: f64| if sum == 0.0 { 0.0 } else { sum / scale };
        let forces = larger(larger(self.forces, self.moments / length), least);
        let moments = larger(larger(self.moments, LEAST_ARM * length * self.forces), least * length);
        (over(self.total.force.norm(), forces), over(self.total.moment.norm(), moments))
    }
}
