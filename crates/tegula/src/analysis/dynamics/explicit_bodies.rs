//! Rigid bodies in explicit steps: the position of the mass centre by central differences, rotations by the discrete equations of
//! Moser and Veselov.
//!
//! With the directors d as coordinates, and rigidity as constraints of them, SHAKE and RATTLE for the kinetic energy
//! `½ E_ij ḋ_i·ḋ_j` lead to a rotation from the directors d⁰ to d¹ with the angular momentum of the half step, and to the angular
//! momentum at its end:
//!
//! ```text
//! Σ E_ij d⁰_i × d¹_j = Δt L½,   L½ = L₀ + ½ Δt T₀,   L₁ = L½ + ½ Δt T₁.
//! ```
//!
//! Between two forces a step keeps the angular momentum in space, and the scheme is symplectic: energies vary about a mean, and do not
//! drift. The three unknowns of the rotation are found by Newton's method. J. Moser, A. Veselov, Commun. Math. Phys. 139 (1991)
//! 217–243; R. McLachlan, A. Zanna, *The discrete Moser–Veselov algorithm for the free rigid body, revisited*, Found. Comput. Math. 5
//! (2005) 87–123.

use nalgebra::Rotation3;

use crate::element::Nodal;
use crate::norm::larger;
use crate::system::{LumpedBody, System};
use crate::{Mat3, Vec3};

/// Iterations for the rotation of a step, and error of its equation over the moment of inertia at which they end.
const ITERATIONS: usize = 25;
const ROUNDING: f64 = 4e-16;

/// Motion of a body in a step.
#[derive(Debug, Clone)]
struct Motion {
    inertia: LumpedBody,
    /// Numbers of the free degrees of freedom: translation of the position, rotation.
    numbers: [u32; 6],
    /// Position of the mass centre and directors at the start of the step.
    start: (Vec3, Mat3),
    /// Directors at the end of the step.
    axes: Mat3,
    /// Velocity of the mass centre, and angular momentum about it.
    velocity: Vec3,
    momentum: Vec3,
    /// Inverse of the inertia tensor with the directors where responses are taken.
    inverse: Mat3,
}

/// Rigid bodies of explicit steps.
pub(super) struct Bodies {
    list: Vec<Motion>,
    /// Nodal vectors that bodies move: their positions, their directors, and those attached to them.
    carried: Vec<u32>,
    /// Body of each free degree of freedom; `u32::MAX` for others.
    of_number: Vec<u32>,
    /// Resultant force and moment about the position of each body.
    wrenches: Vec<[Vec3; 2]>,
}

impl Bodies {
    /// Bodies of a system with the lumped masses `mass`.
    pub fn new(system: &System, mass: &[f64]) -> Self {
        let frames = &system.frames;
        let motion = |inertia: LumpedBody| {
            let [a, b] = [inertia.centre, inertia.directors[0]].map(|v| frames.of(v as usize));
            Motion {
                numbers: [a[0], a[1], a[2], b[0], b[1], b[2]],
                start: (Vec3::zeros(), Mat3::identity()),
                axes: Mat3::identity(),
                velocity: Vec3::zeros(),
                momentum: Vec3::zeros(),
                inverse: Mat3::zeros(),
                inertia,
            }
        };
        let list: Vec<Motion> = LumpedBody::all(system, mass).into_iter().map(motion).collect();
        let mut of_number = vec![u32::MAX; system.unknowns()];
        let mut carried: Vec<u32> = system.dofs().attached.iter().map(|attached| attached.vector).collect();
        for (b, body) in list.iter().enumerate() {
            carried.push(body.inertia.centre);
            carried.extend(body.inertia.directors);
            for number in body.numbers {
                if let Some(of) = of_number.get_mut(number as usize) {
                    *of = b as u32;
                }
            }
        }
        carried.sort_unstable();
        let wrenches = vec![[Vec3::zeros(); 2]; list.len()];
        Self { list, carried, of_number, wrenches }
    }

    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Nodal vectors that bodies move, ascending.
    pub fn carried(&self) -> &[u32] {
        &self.carried
    }

    /// Body of a free degree of freedom.
    pub fn of_number(&self, number: u32) -> Option<usize> {
        let body = *self.of_number.get(number as usize)?;
        (body != u32::MAX).then_some(body as usize)
    }

    /// Takes configuration and momenta of a state.
    pub fn take(&mut self, system: &System, u: &[Nodal], v: &[Nodal]) {
        for body in &mut self.list {
            let axes = body.inertia.axes(system, u);
            let offset = axes * body.inertia.offset;
            let centre = body.inertia.centre as usize;
            let place = Vec3::from(system.coordinates.reference[centre]) + Vec3::from(u[centre]);
            body.start = (place + offset, axes);
            body.axes = axes;
            let omega = body.spin(v);
            body.velocity = Vec3::from(v[centre]) + omega.cross(&offset);
            let inertia = body.inertia.inertia(&axes);
            body.momentum = inertia * omega;
            body.inverse = inertia.try_inverse().unwrap_or_else(|| Mat3::from_element(f64::NAN));
        }
    }

    /// Changes the momenta by the accelerations `a` of the state that was [taken](Self::take), over the time `dt`.
    pub fn kick(&mut self, a: &[Nodal], dt: f64) {
        for body in &mut self.list {
            let (acceleration, moment) = body.forces(a);
            body.velocity += acceleration * dt;
            body.momentum += moment * dt;
        }
    }

    /// Moves a body over a step and writes its displacements; attached vectors are not moved.
    ///
    /// # Errors
    /// It turns too far.
    pub fn drift(&mut self, system: &System, body: usize, dt: f64, u: &mut [Nodal]) -> Result<(), String> {
        let data = &mut self.list[body];
        let Some(axes) = data.turned(dt) else {
            let name = &system.coordinates.bodies[data.inertia.body].name;
            return Err(format!("body \"{name}\" turns too far in the step"));
        };
        data.axes = axes;
        let position = data.start.0 + data.velocity * dt - axes * data.inertia.offset;
        let mut write = |v: u32, value: Vec3| {
            u[v as usize] = (value - Vec3::from(system.coordinates.reference[v as usize])).into();
        };
        write(data.inertia.centre, position);
        for (i, v) in data.inertia.directors.into_iter().enumerate() {
            write(v, axes.column(i).into_owned());
        }
        Ok(())
    }

    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Lets the directors at the end of the step be those at which momenta and responses are taken.
    pub fn arrive(&mut self) {
        for body in &mut self.list {
            body.start = (body.start.0, body.axes);
            let inertia = body.inertia.inertia(&body.axes);
            body.inverse = inertia.try_inverse().unwrap_or_else(|| Mat3::from_element(f64::NAN));
        }
    }

    /// Changes the momenta by the `forces` on all nodal vectors over the time `dt`, divides them by `damping`, and writes the
    /// velocities.
    pub fn kick_by_forces(
        &mut self,
        system: &System,
        forces: impl Fn(usize) -> Vec3,
        (dt, damping): (f64, f64),
        v: &mut [Nodal],
    ) {
        self.find_wrenches(system, forces);
        for (body, [force, moment]) in self.list.iter_mut().zip(&self.wrenches) {
            let offset = body.axes * body.inertia.offset;
            body.velocity = (body.velocity + force * (dt / body.inertia.mass)) / damping;
            body.momentum = (body.momentum + (moment - offset.cross(force)) * dt) / damping;
            let omega = body.inverse * body.momentum;
            v[body.inertia.centre as usize] = (body.velocity - omega.cross(&offset)).into();
            for (i, n) in body.inertia.directors.into_iter().enumerate() {
                v[n as usize] = omega.cross(&body.axes.column(i)).into();
            }
        }
        system.dofs().carry(v);
    }

    /// Writes the accelerations of the bodies at velocities `v` under the forces of the last [kick](Self::kick_by_forces), and under mass
    /// damping α.
    pub fn write_accelerations(&self, system: &System, alpha: f64, v: &[Nodal], a: &mut [Nodal]) {
        for (body, [force, moment]) in self.list.iter().zip(&self.wrenches) {
            let offset = body.axes * body.inertia.offset;
            let omega = body.spin(v);
            let momentum = body.inertia.inertia(&body.axes) * omega;
            let moment = moment - offset.cross(force) - omega.cross(&momentum) - momentum * alpha;
            let second = body.inverse * moment;
            let relative = |arm: Vec3| second.cross(&arm) + omega.cross(&omega.cross(&arm));
            let centre = body.inertia.centre as usize;
            let velocity = Vec3::from(v[centre]) + omega.cross(&offset);
            a[centre] = (force / body.inertia.mass - velocity * alpha - relative(offset)).into();
            for (i, n) in body.inertia.directors.into_iter().enumerate() {
                a[n as usize] = relative(body.axes.column(i).into_owned()).into();
            }
        }
        system.dofs().carry(a);
    }

    /// Resultant forces and moments about the positions of the bodies of forces on all nodal vectors.
    fn find_wrenches(&mut self, system: &System, forces: impl Fn(usize) -> Vec3) {
        for (body, wrench) in self.list.iter().zip(&mut self.wrenches) {
            let directors = body.inertia.directors.iter().enumerate();
            let moments = directors.map(|(i, &d)| body.axes.column(i).cross(&forces(d as usize)));
            *wrench = [forces(body.inertia.centre as usize), moments.sum()];
        }
        for attached in &system.dofs().attached {
            let b = attached.triad as usize;
            let force = forces(attached.vector as usize);
            let arm = self.list[b].axes * attached.coordinates;
            let [resultant, moment] = &mut self.wrenches[b];
            if attached.centre.is_some() {
                *resultant += force;
            }
            *moment += arm.cross(&force);
        }
    }

    /// Adds the free accelerations under the unbalanced `forces` at the state that was [taken](Self::take).
    pub fn accelerate(&mut self, system: &System, forces: &[Nodal], a: &mut [Nodal]) {
        self.find_wrenches(system, |v| Vec3::from(forces[v]));
        for (body, wrench) in self.list.iter().zip(&self.wrenches) {
            let [translation, rotation] = body.response(wrench);
            body.add_motion(translation, rotation, a);
        }
    }

    /// Wrench on a body, from the values of all free degrees of freedom of a force.
    fn wrench(&self, body: usize, free: &[f64]) -> [Vec3; 2] {
        let numbers = self.list[body].numbers;
        [0, 3]
            .map(|first| Vec3::from_fn(|i, _| free.get(numbers[first + i] as usize).copied().unwrap_or(0.0)))
    }

    /// Hands the response of a body to a force on the free degrees of freedom to `take`, one of its own after another.
    pub fn respond(&self, body: usize, force: &[f64], mut take: impl FnMut(u32, f64)) {
        let parts = self.list[body].response(&self.wrench(body, force));
        for (i, number) in self.list[body].numbers.into_iter().enumerate() {
            take(number, parts[i / 3][i % 3]);
        }
    }

    /// Adds a multiple of the response of a body to a force on the free degrees of freedom to a field of rates.
    pub fn add_response(&self, body: usize, force: &[f64], factor: f64, field: &mut [Nodal]) {
        let [translation, rotation] = self.list[body].response(&self.wrench(body, force));
        self.list[body].add_motion(translation * factor, rotation * factor, field);
    }

    /// Changes the momenta of a body by an impulse on the free degrees of freedom, which acts at the start of the step.
    pub fn push(&mut self, body: usize, impulse: &[f64]) {
        let [force, moment] = self.wrench(body, impulse);
        let body = &mut self.list[body];
        let offset = body.start.1 * body.inertia.offset;
        body.velocity += force / body.inertia.mass;
        body.momentum += moment - offset.cross(&force);
    }

    /// Product a·M a of the accelerations that forces make: `f·f/m + T·J⁻¹ T` with the resultant force f and its moment T.
    pub fn inertia(&self, a: &[Nodal]) -> f64 {
        let of = |body: &Motion| {
            let (acceleration, moment) = body.forces(a);
            body.inertia.mass * acceleration.norm_squared() + moment.dot(&(body.inverse * moment))
        };
        self.list.iter().map(of).sum()
    }

    /// Largest angular velocity, and square root of the largest angular acceleration [1/time].
    pub fn rate(&self, v: &[Nodal], a: &[Nodal]) -> f64 {
        let of = |body: &Motion| larger(body.spin(v).norm(), body.spin(a).norm().sqrt());
        self.list.iter().map(of).fold(0.0, larger)
    }
}

impl Motion {
    /// Angular velocity from the rates of the directors, `½ Σ dᵢ × ḋᵢ`; the angular acceleration from the second rates.
    fn spin(&self, rates: &[Nodal]) -> Vec3 {
        let directors = self.inertia.directors.into_iter().enumerate();
        let part = |(i, v): (usize, u32)| self.axes.column(i).cross(&Vec3::from(rates[v as usize]));
        directors.map(part).sum::<Vec3>() * 0.5
    }

    /// Acceleration of the mass centre and moment about it that make the accelerations `a`.
    fn forces(&self, a: &[Nodal]) -> (Vec3, Vec3) {
        let LumpedBody { directors, euler, offset, .. } = &self.inertia;
        let second = directors.map(|v| Vec3::from(a[v as usize]));
        let mut moment = Vec3::zeros();
        for i in 0..3 {
            for j in 0..3 {
                moment += self.axes.column(i).cross(&second[j]) * euler[(i, j)];
            }
        }
        let arm: Vec3 = second.iter().zip(offset.iter()).map(|(a, x)| a * *x).sum();
        (Vec3::from(a[self.inertia.centre as usize]) + arm, moment)
    }

    /// Directors at the end of a step of length `dt` with the present angular momentum.
    fn turned(&self, dt: f64) -> Option<Mat3> {
        let (start, euler) = (&self.start.1, &self.inertia.euler);
        let target = self.momentum * dt;
        let inertia = self.inertia.inertia(start);
        let size = inertia.trace();
        let mut axes = Rotation3::new(self.inverse * target).into_inner() * start;
        let mut best = f64::INFINITY;
        for _ in 0..ITERATIONS {
            let m = axes * euler * start.transpose();
            let rest = axis_of(&m) - target;
            let error = rest.norm() / size;
            // Where round-off is reached the error no longer falls.
            if error <= ROUNDING || (error < 1e-13 && error >= 0.5 * best) {
                return Some(orthonormal(&axes));
            }
            best = error.min(best);
            let change = (Mat3::identity() * m.trace() - m).try_inverse()? * rest;
            if !(change.norm() < std::f64::consts::PI) {
                return None;
            }
            axes = Rotation3::new(-change).into_inner() * axes;
        }
        None
    }

    /// Acceleration of the position and angular acceleration that a force and its moment about the position make.
    fn response(&self, [force, moment]: &[Vec3; 2]) -> [Vec3; 2] {
        let offset = self.axes * self.inertia.offset;
        let rotation = self.inverse * (moment - offset.cross(force));
        [force / self.inertia.mass - rotation.cross(&offset), rotation]
    }

    /// Adds a translation of the position and a rotation.
    fn add_motion(&self, translation: Vec3, rotation: Vec3, field: &mut [Nodal]) {
        let mut add = |v: u32, x: Vec3| (0..3).for_each(|i| field[v as usize][i] += x[i]);
        add(self.inertia.centre, translation);
        for (i, v) in self.inertia.directors.into_iter().enumerate() {
            add(v, rotation.cross(&self.axes.column(i)));
        }
    }
}

/// Vector `Σ a × b` of a matrix `Σ b aᵀ`.
fn axis_of(m: &Mat3) -> Vec3 {
    Vec3::new(m.m32 - m.m23, m.m13 - m.m31, m.m21 - m.m12)
}

/// Removes round-off from a rotation: a step of Newton's iteration for its polar decomposition.
fn orthonormal(r: &Mat3) -> Mat3 {
    r.try_inverse().map_or(*r, |inverse| (r + inverse.transpose()) * 0.5)
}
