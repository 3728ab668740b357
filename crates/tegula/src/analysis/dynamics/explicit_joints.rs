//! Joints in explicit steps by projection: positions by SHAKE, velocities by RATTLE.
//!
//! The impulses `−G₀ᵀμ` of the joints at the start of a step, with the gradients there, close the constraints `g(u₁) = 0` at its
//! end, by a Newton iteration with the Schur complement `S₀ = G₀ M⁻¹ G₀ᵀ`, which is exact but for the change of the gradients in
//! the step. Impulses `−G₁ᵀν` at its end let the velocities keep them closed, `G₁ v₁ + g,t = 0`. Multipliers and
//! accelerations of the state are those of the equations of index 1 there,
//!
//! ```text
//! S₁ λ₁ = G₁ M⁻¹ F₁ + Ġ₁ v₁ + …,   M a₁ = F₁ − G₁ᵀ λ₁,
//! ```
//!
//! which is what the next step begins with. J.-P. Ryckaert, G. Ciccotti, H. Berendsen, J. Comput. Phys. 23 (1977) 327–341;
//! H. C. Andersen, J. Comput. Phys. 52 (1983) 24–34.

use super::explicit_bodies::Bodies;
use crate::Vec3;
use crate::analysis::State;
use crate::analysis::constraints::{
    Gradient, Rates, Schur, count_turns, end_of, gradients, joint_rates, product,
};
use crate::constraint::{DriveValue, Joint};
use crate::element::{Motion, Nodal};
use crate::norm::larger;
use crate::system::dof_map::CONSTRAINED;
use crate::system::{LocalFrames, System};

/// Most iterations that close the joints in a step.
const ITERATIONS: usize = 60;
/// Value of a constraint over its size at which iterations end, and the largest one that round-off may leave.
const CLOSED: f64 = 1e-14;
const ROUNDING: f64 = 1e-10;

/// Constraints of the joints of a system.
pub(super) struct Projection {
    /// Gradients at the last state, and the responses of the masses to them.
    gradients: Vec<Gradient>,
    responses: Vec<Gradient>,
    schur: Schur,
    right: Vec<f64>,
    change: Vec<f64>,
    /// Values of the free degrees of freedom; zero between two uses.
    free: Vec<f64>,
    frames: LocalFrames,
    /// Nodal vectors of joints that do not belong to bodies, and bodies of joints.
    nodes: Vec<u32>,
    bodies: Vec<usize>,
    /// Bodies of each joint.
    of_joint: Vec<Vec<usize>>,
    /// Inverse mass of each free degree of freedom of nodes.
    inverse_mass: Vec<f64>,
    /// First angles of gears at the start of the step, joint by joint; 0 for other joints.
    counted: Vec<f64>,
}

/// Instant at which the rates of drives count: at a kink of a table they jump.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Side {
    Before,
    Behind,
}

impl Projection {
    /// Constraints of a system with the lumped masses `mass`; `None` if it has no joints.
    pub fn new(system: &System, mass: &[f64], all: &Bodies) -> Option<Self> {
        let m = system.constraints();
        let bodies_of = |joint: &Joint| {
            let mut bodies: Vec<usize> = Vec::new();
            for &v in &joint.vectors {
                system.frames.reduce_one(v as usize, &Vec3::repeat(1.0), |number, _| {
                    bodies.extend(all.of_number(number));
                });
            }
            bodies.sort_unstable();
            bodies.dedup();
            bodies
        };
        let of_joint: Vec<Vec<usize>> = system.joints.iter().map(bodies_of).collect();
        let mut bodies = of_joint.concat();
        bodies.sort_unstable();
        bodies.dedup();
        let of_nodes = |v: &u32| all.carried().binary_search(v).is_err();
        let mut nodes: Vec<u32> =
            system.joints.iter().flat_map(|joint| &joint.vectors).copied().filter(of_nodes).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let mut inverse_mass = vec![0.0; system.unknowns()];
        for &v in &nodes {
            for number in system.frames.of(v as usize).into_iter().filter(|n| *n != CONSTRAINED) {
                inverse_mass[number as usize] = 1.0 / mass[v as usize];
            }
        }
        (m > 0).then(|| Self {
            gradients: vec![Gradient::new(); m],
            responses: vec![Gradient::new(); m],
            schur: Schur::new(m),
            right: vec![0.0; m],
            change: vec![0.0; m],
            free: vec![0.0; system.unknowns()],
            frames: system.frames.clone(),
            nodes,
            bodies,
            of_joint,
            inverse_mass,
            counted: vec![0.0; system.joints.len()],
        })
    }

    /// Takes gradients and Schur complement of a state, at which the bodies stand.
    pub fn take(&mut self, system: &System, bodies: &Bodies, (u, time): (&[Nodal], f64)) {
        let motion = Motion::State { u, velocity: None };
        let end = end_of(system, &motion);
        self.frames.follow_bodies(&end);
        gradients(system, (&self.frames, time), (&end, |_| Vec3::zeros()), &mut self.gradients);
        for (joint, of_joint) in system.joints.iter().zip(&self.of_joint) {
            for i in joint.multipliers() {
                let (gradient, response) = (&self.gradients[i], &mut self.responses[i]);
                response.clear();
                for &(number, x) in gradient {
                    self.free[number as usize] = x;
                    if bodies.of_number(number).is_none() {
                        response.push((number, x * self.inverse_mass[number as usize]));
                    }
                }
                for &body in of_joint {
                    bodies.respond(body, &self.free, |number, x| response.push((number, x)));
                }
                gradient.iter().for_each(|(number, _)| self.free[*number as usize] = 0.0);
            }
        }
        let m = self.right.len();
        for (j, response) in self.responses.iter().enumerate() {
            response.iter().for_each(|&(number, x)| self.free[number as usize] = x);
            for (i, gradient) in self.gradients.iter().enumerate() {
                self.schur.matrix[i * m + j] = product(gradient, &self.free);
            }
            response.iter().for_each(|(number, _)| self.free[*number as usize] = 0.0);
        }
        self.schur.factor();
    }

    /// Takes the angles of gears at the start of a step.
    pub fn count_turns(&mut self, system: &System, angles: &[f64]) {
        count_turns(system, angles, &mut self.counted);
    }

    /// Closes the joints at the end of a step of length `dt` by impulses at its start: they change the displacements `u` there, the
    /// velocities `middle` of the half step and the momenta of bodies.
    ///
    /// # Errors
    /// The joints do not close.
    pub fn close(
        &mut self,
        system: &System,
        bodies: &mut Bodies,
        (start, middle, u): (&[Nodal], &mut [Nodal], &mut [Nodal]),
        (dt, end): (f64, f64),
    ) -> Result<(), String> {
        let mut last = f64::INFINITY;
        for _ in 0..ITERATIONS {
            let (violation, worst) = self.values(system, (u, end));
            if violation <= CLOSED || (violation <= ROUNDING && violation >= 0.5 * last) {
                return Ok(());
            }
            if !(violation < f64::INFINITY) || violation > 10.0 * last {
                return Err(open(system, worst));
            }
            last = violation.min(last);
            self.right.iter_mut().for_each(|x| *x /= dt);
            self.schur.solve(&mut self.right, &[], &mut self.change);
            self.spread();
            for &v in &self.nodes {
                let n = v as usize;
                let change = self.node(n);
                for i in 0..3 {
                    middle[n][i] += change[i];
                    u[n][i] = start[n][i] + dt * middle[n][i];
                }
            }
            // Prescribed degrees of freedom are where their motion leads them, and not near it.
            system.prescribe(end, u);
            for &body in &self.bodies {
                bodies.push(body, &self.free);
                bodies.drift(system, body, dt, u)?;
            }
            system.dofs().carry(u);
            self.clear();
        }
        let (_, worst) = self.values(system, (u, end));
        Err(open(system, worst))
    }

    /// Values of the constraints, in place of the right side; returns the largest one over its size, and the joint that has it.
    fn values(&mut self, system: &System, (u, time): (&[Nodal], f64)) -> (f64, usize) {
        let motion = Motion::State { u, velocity: None };
        let end = end_of(system, &motion);
        let (mut largest, mut worst) = (0.0, 0);
        for (number, joint) in system.joints.iter().enumerate() {
            let target = match joint.counted {
                Some(_) => self.counted[number],
                None => system.drive_value(joint, time),
            };
            joint.with_vectors(&end, |v, _| {
                for (i, row) in joint.multipliers().zip(&joint.rows) {
                    self.right[i] = row.value(v, target);
                    let on_branch = row.is_on_branch(v, target);
                    let size = if on_branch { self.right[i].abs() / row.size } else { f64::INFINITY };
                    if !(size <= largest) {
                        (largest, worst) = (size, number);
                    }
                }
            });
        }
        (largest, worst)
    }

    /// Largest value of a constraint over its size at a state, and the joint that has it.
    pub fn violation<'a>(&mut self, system: &'a System, at: (&[Nodal], f64)) -> (f64, Option<&'a Joint>) {
        let (violation, worst) = self.values(system, at);
        (violation, system.joints.get(worst))
    }

    /// Changes the velocities of a state so that they keep the joints closed, and with mass damping α its accelerations.
    pub fn project_velocities(&mut self, system: &System, bodies: &Bodies, state: &mut State, side: Side) {
        let State { u, v, a, time, .. } = state;
        self.rates(system, (u, *time), Rates::First(v), side);
        self.schur.solve(&mut self.right, &[], &mut self.change);
        self.spread();
        self.add(system, bodies, 1.0, v);
        self.add(system, bodies, -system.mass_damping, a);
        self.clear();
    }

    /// Changes free accelerations of a state to those of the constrained motion, and finds its multipliers.
    pub fn constrain_accelerations(
        &mut self,
        system: &System,
        bodies: &Bodies,
        state: &mut State,
        side: Side,
    ) {
        let State { u, v, a, time, multipliers, .. } = state;
        self.rates(system, (u, *time), Rates::Second(v, a), side);
        self.schur.solve(&mut self.right, &[], &mut self.change);
        multipliers.copy_from_slice(&self.change);
        self.spread();
        self.add(system, bodies, 1.0, a);
        self.clear();
    }

    /// Takes the constraint forces of a state out of its accelerations.
    pub fn release_accelerations(&mut self, system: &System, bodies: &Bodies, state: &mut State) {
        self.change.iter_mut().zip(&state.multipliers).for_each(|(change, multiplier)| *change = -multiplier);
        self.spread();
        self.add(system, bodies, 1.0, &mut state.a);
        self.clear();
    }

    /// Rates of the constraints at displacements `u`, in place of the right side.
    pub fn rates(&mut self, system: &System, (u, time): (&[Nodal], f64), rates: Rates, side: Side) -> &[f64] {
        let motion = Motion::State { u, velocity: None };
        let end = end_of(system, &motion);
        for joint in system.joints.iter() {
            let drive: DriveValue = match side {
                Side::Before => system.drive_before(joint, time),
                Side::Behind => system.drive(joint, time),
            };
            joint_rates(joint, (&end, drive), rates, &mut self.right);
        }
        &self.right
    }

    /// Sums the forces `−Gᵀ x` of the change x of the multipliers over the free degrees of freedom.
    fn spread(&mut self) {
        for (gradient, x) in self.gradients.iter().zip(&self.change) {
            gradient.iter().for_each(|&(number, g)| self.free[number as usize] -= x * g);
        }
    }

    /// Response of a node to the forces.
    fn node(&self, v: usize) -> Nodal {
        let of = |n: u32| match n {
            CONSTRAINED => 0.0,
            n => self.free[n as usize] * self.inverse_mass[n as usize],
        };
        self.frames.to_global(v, self.frames.of(v).map(of))
    }

    /// Adds a multiple of the response to the forces to a field of rates.
    fn add(&self, system: &System, bodies: &Bodies, factor: f64, field: &mut [Nodal]) {
        if factor == 0.0 {
            return;
        }
        for &v in &self.nodes {
            let change = self.node(v as usize);
            (0..3).for_each(|i| field[v as usize][i] += factor * change[i]);
        }
        for &body in &self.bodies {
            bodies.add_response(body, &self.free, factor, field);
        }
        system.dofs().carry(field);
    }

    /// Clears the forces.
    fn clear(&mut self) {
        for gradient in &self.gradients {
            gradient.iter().for_each(|&(number, _)| self.free[number as usize] = 0.0);
        }
    }

    /// Schur complement of the mass at the constraints of the last state.
    pub fn schur(&self) -> &Schur {
        &self.schur
    }

    /// Messages about joints with redundant constraints.
    pub fn redundant(&self, system: &System) -> Vec<String> {
        self.schur.redundant(system).collect()
    }

    /// Joints with a rate of a constraint that no motion makes vanish, above `limit`.
    pub fn contradictory<'a>(&self, system: &'a System, limit: f64) -> Vec<&'a Joint> {
        let open = |joint: &&Joint| self.right[joint.multipliers()].iter().any(|r| !(r.abs() <= limit));
        system.joints.iter().filter(open).collect()
    }

    /// Largest rate of a drive at a time.
    pub fn largest_drive(system: &System, time: f64) -> f64 {
        system.joints.iter().map(|joint| system.drive(joint, time).rate.abs()).fold(0.0, larger)
    }
}

/// Message about a joint that does not close in a step.
fn open(system: &System, joint: usize) -> String {
    let name = system.joints.get(joint).map_or("?", |joint| &joint.name);
    format!(
        "joint \"{name}\" does not close in the step: bodies turn too far in it, or the joints cannot move as drives want"
    )
}
