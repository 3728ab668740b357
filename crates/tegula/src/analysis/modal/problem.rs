//! Eigenvalue problem `K φ = λ M φ` of a model, split into groups of connected parts: shift-and-invert operator, Sturm
//! sequence count.
//!
//! Unconnected parts vibrate independently. Where their frequencies are decades apart, no shift suits all of them: what
//! is small beside the shift of the one is large beside that of the other, and round-off of the stiff part hides the
//! soft one. Parts of like frequencies therefore form a group, with a shift of its own.

use super::dot;
use super::rigid::{Parts, RigidModes};
use super::strain_energy::OF_SPRINGS;
use crate::analysis::newton::Newton;
use crate::analysis::potential::scales;
use crate::analysis::{Observer, State, equilibrium};
use crate::element::{ElementGroup, TangentWeights};
use crate::model::NewtonMethod;
use crate::norm::larger;
use crate::system::System;
use crate::system::assembly::TangentCoefficients;
use crate::{Error, Result};
use tegula_sparse::lanczos::SymmetricOperator;
use tegula_sparse::{Factor as _, SymmetricPattern};

/// Ratio of the estimated eigenvalues λ of parts above which they belong to different groups.
const APART: f64 = 1e4;
/// First shift as a part of the lowest ratio of the diagonals of K and M.
const FIRST_SHIFT: f64 = 1e-10;
/// Number of times that the first shift is multiplied by 100 before the matrix counts as indefinite.
const ATTEMPTS: usize = 12;

/// Rigid mode in the free degrees of freedom of its part, with its product with M.
struct Sparse {
    rows: Vec<u32>,
    values: Vec<f64>,
    m_values: Vec<f64>,
}

/// Connected parts that share a shift.
pub(super) struct Group {
    /// λ of the shift.
    pub shift: f64,
    /// Free degrees of freedom of the group.
    pub unknowns: Vec<u32>,
    /// Indices of the group's rigid modes in `RigidModes`.
    pub rigid: Vec<usize>,
    modes: Vec<Sparse>,
    /// Lowest ratio of the diagonals of K and M: ω² of the softest degree of freedom.
    pub lowest: f64,
}

impl Group {
    /// Number of elastic modes.
    pub fn elastic(&self) -> usize {
        self.unknowns.len() - self.rigid.len()
    }

    /// Projects a vector onto the M-orthogonal complement of the rigid modes: `x −= r (r·M x)`.
    pub fn project(&self, x: &mut [f64]) {
        for mode in &self.modes {
            let product: f64 = mode.rows.iter().zip(&mode.m_values).map(|(&i, m)| m * x[i as usize]).sum();
            mode.rows.iter().zip(&mode.values).for_each(|(&i, r)| x[i as usize] -= product * r);
        }
    }
}

/// Stiffness and mass of the free degrees of freedom about a state, and their groups.
pub(super) struct Problem<'a> {
    pub system: &'a System,
    pub newton: Newton,
    pub pattern: SymmetricPattern,
    pub stiffness: Vec<f64>,
    /// Geometric part of the stiffness; empty where the state is free of stress.
    pub geometric_stiffness: Vec<f64>,
    pub mass: Vec<f64>,
    pub groups: Vec<Group>,
    pub parts: Parts,
    pub rigid: RigidModes,
    /// Whether the strain energy of a small motion is ½ δs·H δs: about a stress-free reference of linear materials.
    pub stress_free: bool,
    /// Whether joints balance the springs that are stressed in the reference configuration.
    pub balanced: bool,
    /// State about which the model vibrates.
    pub state: State,
    /// Weight of the augmented Lagrangian of joints, which is part of the stiffness.
    penalty: f64,
    /// Scale of the stiffness of elements (force/length) where nodes are attached to bodies, else 0.
    pub stiffness_of_elements: f64,
    /// Most that centrifugal forces take from an eigenvalue without them: shifts are below it.
    pub softening: f64,
    /// Applications of the inverse so far.
    pub applications: u64,
    /// Group of each free degree of freedom.
    group_of: Vec<u32>,
    values: Vec<f64>,
    /// Scale of each free degree of freedom, with which it is without unit.
    scales: Vec<f64>,
}

impl<'a> Problem<'a> {
    /// Tangent and mass about the reference configuration or an equilibrium.
    ///
    /// # Errors
    /// The factor does not fit in memory, or there is no mass or stiffness.
    pub fn new(system: &'a System, equilibrium: Option<&State>) -> Result<Self> {
        let mut newton = Newton::new(system, Some(NewtonMethod::Displacement))?;
        let mut state = equilibrium.cloned().unwrap_or_else(|| State::unloaded(system));
        let penalty = equilibrium::penalty(system, &mut newton.assembly, &state);
        let mut balanced = true;
        if equilibrium.is_none() && !system.continues() && has_springs(system) && is_preloaded(system, &state)
        {
            let k = state.point(system);
            newton.assembly.follow(system, &k);
            let mut forces = vec![[0.0; 3]; system.vectors()];
            newton.assembly.forces(system, &k, &mut forces);
            forces.as_flattened_mut().iter_mut().for_each(|f| *f = -*f);
            balanced =
                equilibrium::find_multipliers(system, &newton.assembly, &mut state, (&forces, penalty));
        }
        let strained = system.prescribed_strains.iter().any(|p| system.factor(&p.factor, state.time) != 0.0);
        let linear = system.sections.iter().all(|s| s.section.is_linear());
        let preloaded = has_springs(system) && is_preloaded(system, &state);
        let stress_free = equilibrium.is_none() && linear && !strained && !preloaded;
        // The loads on inextensible directors and on bodies enter at an equilibrium.
        let loads = if equilibrium.is_some() {
            equilibrium::external(system, &state.point(system))
        } else {
            vec![[0.0; 3]; system.vectors()]
        };
        let mut geometric_stiffness = Vec::new();
        if !stress_free {
            equilibrium::assemble_geometric(system, &mut newton.assembly, &state, &loads);
            geometric_stiffness.clone_from(&newton.assembly.values);
        }
        equilibrium::assemble_tangent(system, &mut newton.assembly, (&state, penalty), &loads);
        let stiffness = newton.assembly.values.clone();
        let mut mass = vec![0.0; stiffness.len()];
        newton.assembly.mass_values(system, &mut mass);
        let parts = Parts::new(system);
        let moved = moved_parts(system, &state, &parts);
        let rests = |part: usize| !strained && !moved[part];
        let rigid = RigidModes::new(system, &state, &parts, &newton.assembly.frames, rests);
        let stiffness_of_elements = if system.dofs().attached.is_empty() {
            0.0
        } else {
            let weights = TangentWeights::STATIC;
            let coefficients = TangentCoefficients { weights, mass: 0.0, time: state.time };
            newton.assembly.stiffness_of_elements(system, &state.point(system), &coefficients)
        };
        let scales = scales(system, &newton.assembly.frames);
        let mut out = Self {
            system,
            newton,
            scales,
            values: vec![0.0; stiffness.len()],
            pattern: system.tangent_pattern(),
            stiffness,
            geometric_stiffness,
            mass,
            groups: Vec::new(),
            group_of: Vec::new(),
            parts,
            rigid,
            stress_free,
            balanced,
            state,
            penalty,
            stiffness_of_elements,
            softening: 0.0,
            applications: 0,
        };
        out.split()?;
        Ok(out)
    }

    /// Splits the parts into groups.
    fn split(&mut self) -> Result<()> {
        let part_of = self.part_of_unknowns();
        let mut lowest = vec![f64::INFINITY; self.parts.count()];
        let diagonals = self.pattern.diagonal(&self.stiffness).zip(self.pattern.diagonal(&self.mass));
        // Joints may hold what loads would tip over; springs, and nodes to which bodies are attached, leave some motions of bodies free.
        let loose = has_springs(self.system) || self.system.may_be_loose();
        let counts = |k: f64, m: f64| m > 0.0 && (k > 0.0 || !loose);
        for ((k, m), &part) in diagonals.zip(&part_of).filter(|((k, m), _)| counts(*k, *m)) {
            lowest[part] = lowest[part].min(k / m);
        }
        let mut order: Vec<usize> = (0..lowest.len()).filter(|&p| lowest[p].is_finite()).collect();
        order.sort_by(|&a, &b| lowest[a].total_cmp(&lowest[b]));
        if order.is_empty() || order.iter().any(|&p| lowest[p] <= 0.0) {
            return Err(Error::Singular {
                what: "The model has no mass or no stiffness.".into(),
                help: "Give every material a density and every section a thickness.".into(),
            });
        }
        let mut group_of_part = vec![u32::MAX; lowest.len()];
        for &part in &order {
            let new = self.groups.last().is_none_or(|g| lowest[part] > APART * g.lowest);
            if new {
                self.groups.push(Group {
                    shift: 0.0,
                    unknowns: Vec::new(),
                    rigid: Vec::new(),
                    modes: Vec::new(),
                    lowest: lowest[part],
                });
            }
            group_of_part[part] = self.groups.len() as u32 - 1;
        }
        // A part without stiffness, as one on a damper alone, is free to move with any other.
        group_of_part.iter_mut().filter(|group| **group == u32::MAX).for_each(|group| *group = 0);
        self.group_of = part_of.iter().map(|&p| group_of_part[p]).collect();
        for (i, &group) in self.group_of.iter().enumerate() {
            self.groups[group as usize].unknowns.push(i as u32);
        }
        let n = part_of.len();
        for mode in 0..self.rigid.len() {
            let (mut x, mut m_x) = (vec![0.0; n], vec![0.0; n]);
            self.newton.assembly.frames.components(&self.rigid.shape(mode, &self.parts), &mut x);
            self.pattern.add_product(&self.mass, &x, &mut m_x);
            let part = self.rigid.part(mode);
            let rows: Vec<u32> = (0..n as u32).filter(|&i| part_of[i as usize] == part).collect();
            let of = |field: &[f64]| rows.iter().map(|&i| field[i as usize]).collect();
            let sparse = Sparse { values: of(&x), m_values: of(&m_x), rows };
            let group = &mut self.groups[group_of_part[part] as usize];
            group.rigid.push(mode);
            group.modes.push(sparse);
        }
        Ok(())
    }

    /// Part of each free degree of freedom.
    fn part_of_unknowns(&self) -> Vec<usize> {
        let frames = &self.newton.assembly.frames;
        let size = self.pattern.size();
        let mut out = vec![0; size];
        for v in 0..self.system.vectors() {
            for number in frames.of(v).into_iter().filter(|&n| (n as usize) < size) {
                out[number as usize] = self.parts.of(v);
            }
        }
        out
    }

    /// Factors `K − λ_g M` with a λ for each group; returns the Sturm sequence count, the number of eigenvalues below
    /// them, `None` where the factorisation fails. With joints these are the eigenvalues on the null space of their gradients.
    pub fn factor(&mut self, lambda: impl FnMut(&Group) -> f64) -> Option<usize> {
        let lambdas: Vec<f64> = self.groups.iter().map(lambda).collect();
        let (pointers, _) = self.pattern.columns();
        for (j, column) in pointers.windows(2).enumerate() {
            let lambda = lambdas[self.group_of[j] as usize];
            for k in column[0]..column[1] {
                self.values[k] = self.stiffness[k] - lambda * self.mass[k];
            }
        }
        let inertia = self.newton.solver.factor(&self.values).ok().filter(|i| i.zero == 0)?;
        let Newton { solver, constraints, assembly, .. } = &mut self.newton;
        let Some(constraints) = constraints else { return Some(inertia.negative) };
        let weights = TangentWeights { penalty: self.penalty, ..TangentWeights::STATIC };
        let at = (&self.state.point(self.system), &weights);
        constraints.take(self.system, at, &assembly.frames, solver).ok()?;
        constraints.admit_independent_gradients(&self.scales);
        inertia.negative.checked_sub(constraints.negative_eigenvalues())
    }

    /// Number of elastic modes of a group and of motions that its joints leave free, at the present factor.
    pub fn modes_of(&self, group: usize) -> usize {
        let constraints = self.newton.constraints.iter().flat_map(|constraints| constraints.independent());
        let of_group = |number: &u32| self.group_of[*number as usize] == group as u32;
        self.groups[group].elastic().saturating_sub(constraints.filter(of_group).count())
    }

    /// Number of all motions of the model, at the present factor.
    pub fn number_of_modes(&self) -> usize {
        self.rigid.len() + (0..self.groups.len()).map(|group| self.modes_of(group)).sum::<usize>()
    }

    /// Changes a vector to one that keeps the joints closed.
    pub fn constrain(&mut self, x: &mut [f64]) {
        if let Some(constraints) = &mut self.newton.constraints {
            constraints.constrain(x);
        }
    }

    /// Makes a vector orthogonal in the mass to others of unit mass, which come with their products with the mass, closes the joints under it and gives it unit mass;
    /// false where no more than the part `independent` of it is left. What is left has grown, and with it the round-off across the joints: all is done
    /// three times.
    pub fn orthonormalize<'v>(
        &mut self,
        x: &mut [f64],
        others: impl Iterator<Item = (&'v [f64], &'v [f64])> + Clone,
        independent: f64,
    ) -> bool {
        let mut product = vec![0.0; x.len()];
        let mut norm = |problem: &Self, x: &[f64]| {
            product.fill(0.0);
            problem.pattern.add_product(&problem.mass, x, &mut product);
            larger(dot(x, &product), 0.0).sqrt()
        };
        for _ in 0..3 {
            self.constrain(x);
            let before = norm(self, x);
            for (v, m) in others.clone() {
                let part = dot(m, x);
                x.iter_mut().zip(v).for_each(|(x, v)| *x -= part * v);
            }
            let after = norm(self, x);
            if !(after > independent * before) {
                return false;
            }
            x.iter_mut().for_each(|x| *x /= after);
        }
        true
    }

    /// Number of eigenvalues below zero, and not by round-off; 0 where it is not known.
    pub fn negative_eigenvalues(&mut self) -> usize {
        self.factor(|group| -FIRST_SHIFT * group.lowest).unwrap_or(0)
    }

    /// Factors with the groups' shifts; true if the matrix is positive definite.
    pub fn factor_shifted(&mut self) -> bool {
        self.factor(|g| g.shift) == Some(0)
    }

    /// Sets shifts far below the lowest elastic modes that still make the matrix positive definite, and factors it.
    ///
    /// # Errors
    /// There are no such shifts, or the observer has asked to stop.
    pub fn first_shift(&mut self, observer: &dyn Observer) -> Result<()> {
        self.groups.iter_mut().for_each(|g| g.shift = -FIRST_SHIFT * g.lowest);
        for _ in 0..=ATTEMPTS {
            go_on(observer)?;
            if self.factor_shifted() {
                return Ok(());
            }
            self.groups.iter_mut().for_each(|g| g.shift *= 100.0);
        }
        Err(Error::Singular {
            what:
                "K − σM is not positive definite for any shift σ tried: a mass, an inertia or a section stiffness is not positive, or a body may \
                 turn about an axis about which it has no inertia."
                    .into(),
            help: "Check densities, thicknesses and materials; give bodies that joints or single nodes leave free to turn an inertia about \
                   each axis; about an equilibrium check that it is stable."
                .into(),
        })
    }

    /// Shift-invert operator of a group with the present factor.
    pub fn operator<'b>(&'b mut self, group: usize, watch: &'b dyn Observer) -> ShiftInvert<'b, 'a> {
        ShiftInvert { problem: self, group, watch }
    }
}

/// Whether each part is elsewhere than where it has no stresses.
fn moved_parts(system: &System, state: &State, parts: &Parts) -> Vec<bool> {
    // Bodies of a model that was assembled have no stresses from it.
    let assembled = system.start.as_ref().filter(|_| !system.continues());
    let mut moved = vec![false; parts.count()];
    for (v, u) in state.u.iter().enumerate() {
        let rest = assembled.map_or([0.0; 3], |start| start.u[v]);
        moved[parts.of(v)] |= *u != rest;
    }
    moved
}

/// Whether a model has springs, torsion springs or bushings.
pub(in crate::analysis) fn has_springs(system: &System) -> bool {
    system.groups.iter().any(|group| OF_SPRINGS.contains(&group.name()))
}

/// Whether springs have forces in a state, which act on its stiffness.
pub(in crate::analysis) fn is_preloaded(system: &System, state: &State) -> bool {
    let factors: Vec<f64> = system.factors(state.time).collect();
    let (point, springs) =
        (state.point(system), |group: &dyn ElementGroup| OF_SPRINGS.contains(&group.name()));
    let forces =
        system.numbered_groups().filter(|(_, group, _)| springs(*group)).flat_map(|(number, group, _)| {
            let mut forces = vec![0.0; 3 * group.vectors_per_element() * group.len()];
            group.evaluate(&point.of_group(system, number, &factors), 0, &mut forces, None);
            forces
        });
    forces.into_iter().any(|force| force != 0.0)
}

/// Ends the analysis if the user has asked for it.
pub(in crate::analysis) fn go_on(watch: &dyn Observer) -> Result<()> {
    if watch.interrupted() { Err(Error::Interrupted) } else { Ok(()) }
}

/// Shift-invert operator `(K − σM)⁻¹ M` of one group, in the complement of its rigid modes.
pub(super) struct ShiftInvert<'b, 'a> {
    problem: &'b mut Problem<'a>,
    group: usize,
    watch: &'b dyn Observer,
}

impl SymmetricOperator for ShiftInvert<'_, '_> {
    fn size(&self) -> usize {
        self.problem.pattern.size()
    }

    fn apply(&mut self, m_x: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        let group = &self.problem.groups[self.group];
        for &i in &group.unknowns {
            out[i as usize] = m_x[i as usize];
        }
        self.problem.newton.solver.solve(out);
        self.problem.constrain(out);
        self.problem.groups[self.group].project(out);
        self.problem.applications += 1;
    }

    fn inner(&self, x: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        self.problem.pattern.add_product(&self.problem.mass, x, out);
    }

    fn project(&self, x: &mut [f64]) {
        self.problem.groups[self.group].project(x);
    }

    fn stopped(&self) -> bool {
        self.watch.interrupted()
    }
}
