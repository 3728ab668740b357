//! Buffers and routines that sum element contributions: internal forces, tangent, energies.

use rayon::prelude::*;

use super::pattern::BATCH;
use super::{LocalFrames, System};
use crate::Vec3;
use crate::element::{
    ElementGroup, InternalVariables, Kinematics, Motion, Nodal, TangentRequest, TangentWeights,
};
use crate::lists::Lists;

/// Tangent coefficients: weights of the element parts, factor of the mass, and time of the follower loads.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TangentCoefficients {
    /// Weights of the element parts.
    pub weights: TangentWeights,
    /// Factor of the mass matrix.
    pub mass: f64,
    /// Time at which follower loads act.
    pub time: f64,
}

/// Lower tangent blocks of a batch of elements of a group.
#[derive(Clone, Copy)]
pub struct ElementBlocks<'a> {
    /// Element group of the batch.
    pub group: &'a dyn ElementGroup,
    /// First element of the batch.
    pub first: usize,
    /// Lower blocks of the elements, one element after another.
    pub blocks: &'a [f64],
}

/// Number of batches from which on a model releases the batch buffer when the tangent is summed: the factorisation
/// needs memory then, and reallocation is cheap for such models.
const MANY_BATCHES: usize = 8;

/// Assembly buffers for one analysis; nothing is allocated after they are made, except for models of many batches.
pub struct Assembly {
    /// Element forces, all groups one after another.
    element_forces: Vec<f64>,
    /// Tangent blocks of a batch of elements or follower loads.
    blocks: Vec<f64>,
    /// Extrapolated stress, conjugate to the sampled strains, all groups.
    pub stress: Vec<f64>,
    /// Values of the tangent's lower triangle.
    pub values: Vec<f64>,
    /// Energies per element, all groups.
    energies: Vec<f64>,
    /// Enhanced parameters and internal variables at the end of the last step, all groups.
    pub history: Vec<f64>,
    /// Enhanced parameters and internal variables at the end of the present step, all groups.
    new_history: Vec<f64>,
    /// Factors of the fields of prescribed strain.
    factors: Vec<f64>,
    /// Constrained degrees of freedom, and local frames of inextensible directors at their present values.
    pub frames: LocalFrames,
    /// Places in `element_forces` (in units of nodal vectors) of the contributions to each nodal vector.
    force_sources: Lists<u32>,
}

impl Assembly {
    /// Buffers for a system.
    pub fn new(system: &System) -> Self {
        let mut out = Self::for_forces(system);
        out.blocks = vec![0.0; 9 * largest_batch(system)];
        out.values = vec![0.0; system.pattern.values()];
        out
    }

    /// Buffers for forces and energies; those of a tangent are made on demand.
    pub fn for_forces(system: &System) -> Self {
        let mut sources: Vec<(u32, u32)> = Vec::new();
        let mut stresses = 0;
        let mut elements = 0;
        let mut history = 0;
        for group in system.groups.iter() {
            history += group.len() * group.history_per_element();
            for e in 0..group.len() {
                for &v in group.vectors(e) {
                    sources.push((v, sources.len() as u32));
                }
            }
            stresses += group.len() * group.stresses_per_element();
            elements += group.len();
        }
        let element_forces = vec![0.0; 3 * sources.len()];
        Self {
            element_forces,
            blocks: Vec::new(),
            stress: vec![0.0; stresses],
            values: Vec::new(),
            energies: vec![0.0; elements],
            history: vec![0.0; history],
            new_history: vec![0.0; history],
            factors: vec![0.0; system.prescribed_strains.len()],
            frames: system.frames.clone(),
            force_sources: Lists::by_key(system.vectors(), sources.into_iter()),
        }
    }

    /// Sets the factors of the prescribed strains.
    fn set_time(&mut self, system: &System, time: f64) {
        for (factor, field) in self.factors.iter_mut().zip(&system.prescribed_strains) {
            *factor = system.factor(&field.factor, time);
        }
    }

    /// Rotates the local frames of inextensible directors to the configuration on which the forces of a motion act.
    pub fn follow(&mut self, system: &System, k: &Kinematics) {
        if !self.frames.dofs().unit.is_empty() && !k.linear {
            self.frames.follow(|v| current_vector(system, k, v));
        }
    }

    /// Internal forces of a motion.
    pub fn forces(&mut self, system: &System, k: &Kinematics, out: &mut [Nodal]) {
        self.set_time(system, k.time);
        let mut forces = self.element_forces.as_mut_slice();
        let mut history = self.history.as_slice();
        for group in system.groups.iter() {
            let (mine, rest) = forces.split_at_mut(3 * group.len() * group.vectors_per_element());
            let k = inside(system, k, &mut history, group.as_ref(), &self.factors);
            group.evaluate(&k, 0, mine, None);
            forces = rest;
        }
        self.gather_forces(out);
    }

    /// Internal forces and the values of the tangent. With `extrapolated` the geometric stiffness uses
    /// [`stress`](Self::stress). A `prescribed` increment adds tangent times increment to the forces.
    pub fn forces_and_tangent(
        &mut self,
        system: &System,
        k: &Kinematics,
        parts: &TangentCoefficients,
        extrapolated: bool,
        prescribed: Option<&[Nodal]>,
        out: &mut [Nodal],
    ) {
        self.values.resize(system.pattern.values(), 0.0);
        self.blocks.resize(9 * largest_batch(system), 0.0);
        // A single task of the thread pool: from outside, each of the many small ones would wait to be scheduled.
        let work = || {
            system.pattern.begin(parts.mass, &self.frames, &mut self.values);
            let mut batch = 0;
            self.batches(system, k, parts, (extrapolated, prescribed), |_, blocks, (frames, values)| {
                system.pattern.add(batch, blocks, parts.mass, frames, values);
                batch += 1;
            });
            self.gather_forces(out);
        };
        rayon::join(work, || ());
        if self.energies.len() > MANY_BATCHES * BATCH {
            self.blocks = Vec::new();
        }
    }

    /// Internal forces of a motion; the tangent is not summed but handed over, the lower blocks of one element or
    /// follower load after the other. Otherwise like [`forces_and_tangent`](Self::forces_and_tangent).
    pub fn forces_and_blocks(
        &mut self,
        system: &System,
        k: &Kinematics,
        parts: &TangentCoefficients,
        (extrapolated, prescribed): (bool, Option<&[Nodal]>),
        out: &mut [Nodal],
        mut take: impl FnMut(&[f64]) + Send,
    ) {
        self.blocks.resize(9 * largest_batch(system), 0.0);
        let work =
            || {
                let mut first = 0;
                self.batches(system, k, parts, (extrapolated, prescribed), |elements, blocks, _| {
                    match elements {
                        Some((group, _)) => {
                            blocks.chunks(9 * pairs(group.vectors_per_element())).for_each(&mut take)
                        }
                        None => {
                            let loads = system.followers[first..].iter().take(BATCH);
                            let mut at = 0;
                            for load in loads {
                                let n = 9 * pairs(load.vectors().len());
                                take(&blocks[at..at + n]);
                                at += n;
                            }
                            first += BATCH;
                        }
                    }
                });
                self.gather_forces(out);
            };
        rayon::join(work, || ());
    }

    /// Element work of [`forces_and_tangent`](Self::forces_and_tangent) alone, to measure its cost.
    pub fn element_work(
        &mut self,
        system: &System,
        k: &Kinematics,
        parts: &TangentCoefficients,
        out: &mut [Nodal],
    ) {
        self.blocks.resize(9 * largest_batch(system), 0.0);
        let work = || {
            self.batches(system, k, parts, (true, None), |_, _, _| {});
            self.gather_forces(out);
        };
        rayon::join(work, || ());
    }

    /// Hands the tangent blocks of all elements to `f`, batch by batch, group by group.
    pub fn for_each_element(
        &mut self,
        system: &System,
        k: &Kinematics,
        parts: &TangentCoefficients,
        mut f: impl FnMut(ElementBlocks),
    ) {
        self.blocks.resize(9 * largest_batch(system), 0.0);
        self.batches(system, k, parts, (false, None), |elements, blocks, _| {
            if let Some((group, first)) = elements {
                f(ElementBlocks { group, first, blocks });
            }
        });
    }

    /// Evaluates the elements, then the follower loads, in the batches of the pattern, and hands group and first
    /// element (`None`: loads), the blocks, and the local frames and values for their sum to `take`.
    fn batches(
        &mut self,
        system: &System,
        k: &Kinematics,
        parts: &TangentCoefficients,
        (extrapolated, prescribed): (bool, Option<&[Nodal]>),
        mut take: impl FnMut(Option<(&dyn ElementGroup, usize)>, &[f64], (&LocalFrames, &mut [f64])),
    ) {
        self.set_time(system, k.time);
        let Self { frames, values, blocks, .. } = self;
        let mut forces = self.element_forces.as_mut_slice();
        let mut stress = self.stress.as_slice();
        let mut history = self.history.as_slice();
        for group in system.groups.iter() {
            let m = group.vectors_per_element();
            let (f, forces_rest) = forces.split_at_mut(3 * group.len() * m);
            let (s, stress_rest) = stress.split_at(group.len() * group.stresses_per_element());
            let k = inside(system, k, &mut history, group.as_ref(), &self.factors);
            for (batch, forces) in f.chunks_mut(3 * m * BATCH).enumerate() {
                let first = batch * BATCH;
                let blocks = &mut blocks[..9 * pairs(m) * (forces.len() / (3 * m))];
                let request = TangentRequest {
                    weights: parts.weights,
                    stress: extrapolated.then_some(s),
                    prescribed,
                    blocks: &mut *blocks,
                };
                group.evaluate(&k, first, forces, Some(request));
                take(Some((group.as_ref(), first)), blocks, (frames, values));
            }
            (forces, stress) = (forces_rest, stress_rest);
        }
        let w = &parts.weights;
        let direction = if k.linear { 0.0 } else { w.force * w.direction };
        for loads in system.followers.chunks(BATCH) {
            let mut rest = blocks.as_mut_slice();
            for load in loads {
                let n = load.vectors().len();
                let (b, others) = rest.split_at_mut(9 * pairs(n));
                let mut x = [Vec3::zeros(); 4];
                current(system, k, load.vectors(), &mut x);
                load.stiffness(&x[..n], b);
                let factor = direction * system.factor(load.factor(), parts.time);
                b.iter_mut().for_each(|v| *v *= factor);
                rest = others;
            }
            take(None, blocks, (frames, values));
        }
    }

    /// Adds the curvature of the unit sphere of inextensible directors under the forces `rest` that act on them from
    /// outside to the values of the tangent.
    pub fn add_curvature(
        &mut self,
        system: &System,
        k: &Kinematics,
        weights: &TangentWeights,
        rest: &[Nodal],
    ) {
        if k.linear {
            return;
        }
        let Self { frames, values, .. } = self;
        for (v, shift) in curvature(system, frames, k, weights, rest) {
            system.pattern.add_to_diagonal(v, shift, frames, values);
        }
    }

    fn gather_forces(&self, out: &mut [Nodal]) {
        out.par_iter_mut().with_min_len(256).enumerate().for_each(|(v, f)| {
            *f = [0.0; 3];
            for &source in self.force_sources.of(v) {
                let at = 3 * source as usize;
                for i in 0..3 {
                    f[i] += self.element_forces[at + i];
                }
            }
        });
    }

    /// First shell whose last forces are not finite, as text: its material law could not be evaluated.
    pub fn without_answer(&self, system: &System) -> Option<String> {
        let mut at = 0;
        for (index, group) in system.groups.iter().enumerate() {
            let n = 3 * group.vectors_per_element();
            for element in 0..group.len() {
                if self.element_forces[at..at + n].iter().all(|f| f.is_finite()) {
                    at += n;
                    continue;
                }
                let shell =
                    system.shells.iter().find(|s| s.groups.contains(&index) && s.member == element)?;
                let (label, c) = (system.quad_label(shell.quad), system.geometry(shell).centre());
                return Some(format!("element {label} at ({:.4}, {:.4}, {:.4})", c.x, c.y, c.z));
            }
        }
        None
    }

    /// Values of the mass matrix of the free degrees of freedom.
    pub fn mass_values(&self, system: &System, values: &mut [f64]) {
        system.pattern.mass_values(&self.frames, values);
    }

    /// Sets the extrapolated stress to that of a motion.
    pub fn reset_stress(&mut self, system: &System, k: &Kinematics) {
        self.set_time(system, k.time);
        let mut stress = self.stress.as_mut_slice();
        let mut history = self.history.as_slice();
        for group in system.groups.iter() {
            let (s, rest) = stress.split_at_mut(group.len() * group.stresses_per_element());
            group.stresses(&inside(system, k, &mut history, group.as_ref(), &self.factors), s);
            stress = rest;
        }
    }

    /// Extrapolates the stress along an increment from a motion.
    pub fn extrapolate(
        &mut self,
        system: &System,
        k: &Kinematics,
        increment: &[Nodal],
        weights: &TangentWeights,
    ) {
        let mut stress = self.stress.as_mut_slice();
        let mut history = self.history.as_slice();
        for group in system.groups.iter() {
            let (s, rest) = stress.split_at_mut(group.len() * group.stresses_per_element());
            let k = inside(system, k, &mut history, group.as_ref(), &self.factors);
            group.extrapolate(&k, increment, weights, s);
            stress = rest;
        }
    }

    /// Commits the history variables at the end of a converged step; returns the energy dissipated in it.
    pub fn commit(&mut self, system: &System, k: &Kinematics) -> f64 {
        let dissipated = self.find_history(system, k);
        if !self.history.is_empty() {
            std::mem::swap(&mut self.history, &mut self.new_history);
        }
        dissipated
    }

    /// Computes the history variables after a step to a motion; returns the energy that would be dissipated in it.
    fn find_history(&mut self, system: &System, k: &Kinematics) -> f64 {
        if self.history.is_empty() {
            return 0.0;
        }
        self.set_time(system, k.time);
        let mut new = self.new_history.as_mut_slice();
        let mut history = self.history.as_slice();
        let mut dissipated = 0.0;
        for group in system.groups.iter() {
            let (mine, rest) = new.split_at_mut(group.len() * group.history_per_element());
            let k = inside(system, k, &mut history, group.as_ref(), &self.factors);
            dissipated += group.update_history(&k, mine);
            new = rest;
        }
        dissipated
    }

    /// Work of prescribed strains that change with time while the model moves from `old` to `new` (displacement and
    /// time): the gain of stored and dissipated energy beyond the work of the internal forces.
    ///
    /// Let Π(u, t) be the energy needed to deform the model to u under the prescribed strains of the time t. The
    /// internal forces at the midpoint of the step do the work Π(u₁, ½) − Π(u₀, ½). The remaining change of Π is
    /// `Π(u₁, t₁) − Π(u₁, ½) + Π(u₀, ½) − Π(u₀, t₀)`: exact for the energy–momentum scheme, of second order for the others.
    /// Where materials yield the two half steps lie on both sides of the kink between loading and unloading, and the
    /// balance is of first order.
    pub fn prescribed_strain_work(
        &mut self,
        system: &System,
        old: (&[Nodal], f64),
        new: (&[Nodal], f64),
    ) -> f64 {
        let factors =
            |time: f64| system.prescribed_strains.iter().map(move |field| system.factor(&field.factor, time));
        let middle = 0.5 * (old.1 + new.1);
        if factors(old.1).eq(factors(middle)) && factors(middle).eq(factors(new.1)) {
            return 0.0;
        }
        let mut change = |u: &[Nodal], from: f64, to: f64| {
            self.energy_to_reach(system, u, to) - self.energy_to_reach(system, u, from)
        };
        change(old.0, old.1, middle) + change(new.0, middle, new.1)
    }

    /// Energy stored at displacements, and dissipated on the way there from the last step.
    fn energy_to_reach(&mut self, system: &System, u: &[Nodal], time: f64) -> f64 {
        let motion = Motion::State { u, velocity: None };
        let k = Kinematics::new(&system.coordinates.reference, motion, system.linear, time);
        self.strain_energy(system, u, time) + self.find_history(system, &k)
    }

    /// Strain energy.
    pub fn strain_energy(&mut self, system: &System, u: &[Nodal], time: f64) -> f64 {
        self.sum_energies(system, u, system.linear, time)
    }

    /// Strain energy of small displacements, ½ uᵀKu, summed from strains without cancellation.
    pub fn small_strain_energy(&mut self, system: &System, u: &[Nodal]) -> f64 {
        self.sum_energies(system, u, true, 0.0)
    }

    fn sum_energies(&mut self, system: &System, u: &[Nodal], linear: bool, time: f64) -> f64 {
        self.set_time(system, time);
        let k =
            Kinematics::new(&system.coordinates.reference, Motion::State { u, velocity: None }, linear, time);
        let mut energies = self.energies.as_mut_slice();
        let mut history = self.history.as_slice();
        for group in system.groups.iter() {
            let (e, rest) = energies.split_at_mut(group.len());
            group.energies(&inside(system, &k, &mut history, group.as_ref(), &self.factors), e);
            energies = rest;
        }
        self.energies.iter().sum()
    }

    /// Power that rate damping dissipates.
    pub fn dissipated_power(&mut self, system: &System, k: &Kinematics) -> f64 {
        let mut power = self.energies.as_mut_slice();
        let mut history = self.history.as_slice();
        for group in system.groups.iter() {
            let (p, rest) = power.split_at_mut(group.len());
            group.dissipation(&inside(system, k, &mut history, group.as_ref(), &self.factors), p);
            power = rest;
        }
        self.energies.iter().sum()
    }
}

/// Curvature of the unit sphere of each inextensible director, under the forces `rest` that act on it from outside.
pub fn curvature<'a>(
    system: &'a System,
    frames: &'a LocalFrames,
    k: &'a Kinematics,
    weights: &'a TangentWeights,
    rest: &'a [Nodal],
) -> impl Iterator<Item = (usize, f64)> + 'a {
    frames.dofs().unit.iter().map(|unit| {
        let v = unit.vector as usize;
        (v, weights.direction * current_vector(system, k, v).dot(&Vec3::from(rest[v])))
    })
}

/// Number of blocks in the lower triangle of `vectors` nodal vectors.
pub(super) fn pairs(vectors: usize) -> usize {
    vectors * (vectors + 1) / 2
}

/// Largest number of blocks in a batch of elements or follower loads.
fn largest_batch(system: &System) -> usize {
    let groups = system.groups.iter().map(|g| g.len().min(BATCH) * pairs(g.vectors_per_element()));
    let loads = system.followers.chunks(BATCH);
    groups.chain(loads.map(|l| l.iter().map(|load| pairs(load.vectors().len())).sum())).max().unwrap_or(0)
}

/// Motion with history and prescribed strains of a group's elements; splits the group's part from the front of
/// `history`.
fn inside<'a>(
    system: &'a System,
    k: &Kinematics<'a>,
    history: &mut &'a [f64],
    group: &dyn ElementGroup,
    factors: &'a [f64],
) -> Kinematics<'a> {
    let (mine, rest) = history.split_at(group.len() * group.history_per_element());
    *history = rest;
    Kinematics {
        interior: InternalVariables { history: mine, factors },
        unit: &system.coordinates.inextensible,
        ..*k
    }
}

/// Nodal vector of the configuration on which the forces of a motion act.
pub(super) fn current_vector(system: &System, k: &Kinematics, v: usize) -> Vec3 {
    let mut x = Vec3::from(system.coordinates.reference[v]);
    if !k.linear {
        match k.motion {
            Motion::State { u, .. } => x += Vec3::from(u[v]),
            Motion::Step { old, new, .. } => x += (Vec3::from(old[v]) + Vec3::from(new[v])) * 0.5,
        }
    }
    x
}

/// Nodal vectors of the configuration on which the forces of a motion act.
fn current(system: &System, k: &Kinematics, vectors: &[u32], x: &mut [Vec3; 4]) {
    for (x, &v) in x.iter_mut().zip(vectors) {
        *x = current_vector(system, k, v as usize);
    }
}

/// Adds the follower loads at a time, times `factor`.
pub fn add_follower_loads(system: &System, k: &Kinematics, time: f64, factor: f64, out: &mut [Nodal]) {
    for load in &system.followers {
        let mut x = [Vec3::zeros(); 4];
        current(system, k, load.vectors(), &mut x);
        let mut f = [[0.0; 3]; 4];
        let n = load.vectors().len();
        load.forces(&x[..n], &mut f[..n]);
        let factor = factor * system.factor(load.factor(), time);
        for (&v, f) in load.vectors().iter().zip(f) {
            for i in 0..3 {
                out[v as usize][i] += factor * f[i];
            }
        }
    }
}

/// Adds the change of the follower loads in an increment of the motion, `∂f/∂x Δ`, with the weights of a tangent.
pub fn add_follower_stiffness(
    system: &System,
    k: &Kinematics,
    parts: &TangentCoefficients,
    increment: &[Nodal],
    out: &mut [Nodal],
) {
    if k.linear {
        return;
    }
    let direction = parts.weights.force * parts.weights.direction;
    for load in &system.followers {
        let vectors = load.vectors();
        let delta = |b: usize| Vec3::from(increment[vectors[b] as usize]);
        if (0..vectors.len()).all(|b| delta(b) == Vec3::zeros()) {
            continue;
        }
        let mut x = [Vec3::zeros(); 4];
        current(system, k, vectors, &mut x);
        let stiffness = load.derivative(&x[..vectors.len()]);
        let factor = -direction * system.factor(load.factor(), parts.time);
        for (&v, row) in vectors.iter().zip(&stiffness) {
            let change = (0..vectors.len()).map(|b| row[b] * delta(b)).sum::<Vec3>() * factor;
            for i in 0..3 {
                out[v as usize][i] += change[i];
            }
        }
    }
}
