//! Torsion springs with dampers about the common axis of two bodies.
//!
//! The angle is `θ = atan2(g, h)` of two quadratic forms of nodal vectors, `g = ½ (e₂ᴬ·e₁ᴮ − e₁ᴬ·e₂ᴮ)` and `h = ½ (e₁ᴬ·e₁ᴮ + e₂ᴬ·e₂ᴮ)`, continued beyond ±π from
//! the angle and the relative rotation at the end of the step before, which are the history variables of the spring. The moment is `M = k (θ − θ₀) + d θ̇`, or a formula; the
//! forces are `M ∂θ/∂q`. In the energy–momentum scheme, with the forms at the ends of a step and their gradients in its middle,
//!
//! ```text
//! w = ½ (h₀ + h₁) ∂g − ½ (g₀ + g₁) ∂h,   w·(q₁ − q₀) = h₀ g₁ − g₀ h₁ = ρ₀ ρ₁ sin Δθ,   ρ² = g² + h²
//! f = [k (½ (θ₀ + θ₁) − θ₀₀) + d Δθ/Δt] Δθ/(ρ₀ ρ₁ sin Δθ) w
//! ```
//!
//! with the free angle θ₀₀ (in general with the mean moment of another [law](SpringLaw) over the step): the force does the work `V₁ − V₀ + d Δθ²/Δt` exactly, a discrete gradient (O. Gonzalez, *Time integration
//! and discrete Hamiltonian systems*, J. Nonlinear Sci. 6 (1996) 449–467). The forms do not change in rigid motions, so that momenta
//! are conserved.

use super::joint::{Few, MOST_VECTORS, current, few};
use super::joints::{LARGEST_TURN, RelativeAngle, RelativeRotation};
use super::spring_law::SpringLaw;
use super::turning::sinc;
use crate::Vec3;
use crate::element::{ElementGroup, GroupPoint, Motion, Nodal, StressIncrement, TangentRequest};
use crate::load::Partials;

/// Torsion spring with a damper.
#[derive(Debug, Clone, PartialEq)]
pub struct TorsionSpring {
    /// Name of the spring in the model.
    pub name: String,
    /// Angle of the second end relative to the first one.
    pub angle: RelativeAngle,
    /// Moment by the angle (rad), its rate and the time.
    pub law: SpringLaw,
}

/// History variables of a spring: its angle and the relative rotation of its ends.
const HISTORY: usize = 1 + RelativeRotation::SIZE;

/// Motion of a spring.
struct Turn {
    /// Angles at the start and at the end of the motion; equal for a state.
    angles: [f64; 2],
    /// Rate of the angle.
    rate: f64,
    /// Gradient of the angle by which the moment acts.
    gradient: Few,
    /// Values of the forms g and h where it acts.
    forms: [f64; 2],
}

impl TorsionSpring {
    /// Gradient `a ∂g − b ∂h` with the nodal vectors v.
    fn gradient(&self, v: &Few, [a, b]: [f64; 2]) -> Few {
        let mut out = [Vec3::zeros(); MOST_VECTORS];
        self.angle.sine.add_gradient(a, v, 0.0, &mut out);
        self.angle.cosine.add_gradient(-b, v, 0.0, &mut out);
        out
    }

    /// Angle at the end of a motion, whatever its change: round-off may take an accepted step beyond the largest one.
    fn angle(&self, k: &GroupPoint, committed: &[f64]) -> f64 {
        let number = |i: usize| committed.get(i).copied().unwrap_or(f64::NAN);
        let rotation = RelativeRotation::read(std::array::from_fn(|i| number(1 + i)));
        self.angle.after((number(0), rotation), &few(&self.angle.vectors, |v| Self::end(k, v)))
    }

    /// Nodal vector at the end of a motion.
    fn end(k: &GroupPoint, vector: u32) -> Vec3 {
        let (Motion::State { u, .. } | Motion::Step { new: u, .. }) = k.motion;
        Vec3::from(k.reference[vector as usize]) + Vec3::from(u[vector as usize])
    }

    /// History variables of one of the springs of a group.
    fn committed<'a>(k: &GroupPoint<'a>, number: usize) -> &'a [f64] {
        k.interior.history.get(number * HISTORY..(number + 1) * HISTORY).unwrap_or(&[])
    }

    fn turn(&self, k: &GroupPoint, number: usize) -> Turn {
        let committed = Self::committed(k, number);
        let angle = self.angle(k, committed);
        let committed = committed.first().copied().unwrap_or(f64::NAN);
        let vectors = &self.angle.vectors;
        let at =
            |u: &[Nodal]| few(vectors, |v| Vec3::from(k.reference[v as usize]) + Vec3::from(u[v as usize]));
        match k.motion {
            Motion::State { u, velocity } => {
                let v = at(u);
                let [g, h] = self.angle.forms(&v);
                let square = g * g + h * h;
                let gradient = self.gradient(&v, [h / square, g / square]);
                let rate = velocity.map_or(0.0, |rates| {
                    vectors.iter().zip(&gradient).map(|(&v, w)| w.dot(&Vec3::from(rates[v as usize]))).sum()
                });
                let angle = if (angle - committed).abs() > LARGEST_TURN { f64::NAN } else { angle };
                Turn { angles: [angle; 2], rate, gradient, forms: [g, h] }
            }
            Motion::Step { old, new, dt } => {
                let (before, after) = (at(old), at(new));
                let [[g0, h0], [g1, h1]] = [&before, &after].map(|v| self.angle.forms(v));
                let change = angle - committed;
                let sizes = g0.hypot(h0) * g1.hypot(h1);
                // Near π the force has no limit.
                let scale = if change.abs() > LARGEST_TURN { f64::NAN } else { 1.0 / sinc(change) } / sizes;
                let middle: Few = std::array::from_fn(|i| (before[i] + after[i]) * 0.5);
                let [g, h] = [0.5 * (g0 + g1), 0.5 * (h0 + h1)];
                let gradient = self.gradient(&middle, [h * scale, g * scale]);
                Turn { angles: [committed, angle], rate: change / dt, gradient, forms: [g, h] }
            }
        }
    }

    /// Writes the lower blocks `along ∂θ ∂θᵀ + bent ∂²θ` of a tangent.
    fn write_blocks(&self, k: &GroupPoint, turn: &Turn, [along, bent]: [f64; 2], blocks: &mut [f64]) {
        let n = self.angle.vectors.len();
        let vectors = few(&self.angle.vectors, |v| current(k, v));
        let [g, h] = turn.forms;
        let square = g * g + h * h;
        let [of_g, of_h] = [[1.0, 0.0], [0.0, -1.0]].map(|factors| self.gradient(&vectors, factors));
        // Second derivatives of atan2(g, h) by g and g, g and h; that by h and h is minus the first.
        let [gg, gh] = [-2.0 * g * h, g * g - h * h].map(|x| bent * x / (square * square));
        let mut block = blocks.chunks_exact_mut(9);
        for a in 0..n {
            for b in 0..=a {
                let Some(out) = block.next() else { break };
                let of_angle = turn.gradient[a] * turn.gradient[b].transpose() * along;
                let of_forms = (of_g[a] * of_g[b].transpose() - of_h[a] * of_h[b].transpose()) * gg
                    + (of_g[a] * of_h[b].transpose() + of_h[a] * of_g[b].transpose()) * gh;
                let sum = of_angle + of_forms;
                out.iter_mut().enumerate().for_each(|(i, out)| *out = sum[(i / 3, i % 3)]);
            }
        }
        self.angle.sine.add_second_derivative(bent * h / square, 0.0, blocks);
        self.angle.cosine.add_second_derivative(-bent * g / square, 0.0, blocks);
    }

    /// Moment of a motion, with the part of the moment in the reference configuration that acts.
    fn moment(&self, turn: &Turn, k: &GroupPoint) -> Partials {
        let mut moment = self.law.force(turn.angles, turn.rate, k.time);
        moment.value -= self.missing_preload(k);
        moment
    }

    /// Part of the moment in the reference configuration that does not act yet.
    fn missing_preload(&self, k: &GroupPoint) -> f64 {
        if k.preload == 1.0 { 0.0 } else { (1.0 - k.preload) * self.law.force([0.0; 2], 0.0, k.time).value }
    }

    /// Angle (rad) and moment in a state; at the mean rate of the last step where it began at the motion `before` and had this length.
    pub fn angle_and_moment(
        &self,
        k: &GroupPoint,
        number: usize,
        last_step: Option<(&GroupPoint, f64)>,
    ) -> [f64; 2] {
        let mut turn = self.turn(k, number);
        if let Some((before, dt)) = last_step {
            turn.rate = (turn.angles[1] - self.angle(before, Self::committed(k, number))) / dt;
        }
        [turn.angles[1], self.moment(&turn, k).value]
    }
}

/// Torsion springs of as many nodal vectors each.
pub struct TorsionSpringGroup {
    members: Vec<TorsionSpring>,
    vectors: usize,
}

impl TorsionSpringGroup {
    /// Name of the groups.
    pub const NAME: &str = "torsion spring";

    /// Groups of all springs, one for each number of nodal vectors.
    pub fn groups(springs: &[TorsionSpring]) -> Vec<Box<dyn ElementGroup>> {
        let groups = (1..=MOST_VECTORS).map(|vectors| {
            let is_member = |spring: &&TorsionSpring| spring.angle.vectors.len() == vectors;
            Self { members: springs.iter().filter(is_member).cloned().collect(), vectors }
        });
        groups.filter(|group| !group.members.is_empty()).map(|group| Box::new(group) as _).collect()
    }

    /// Group of each spring among these groups, and its number in it.
    pub fn places(springs: &[TorsionSpring]) -> Vec<[usize; 2]> {
        let size = |spring: &TorsionSpring| spring.angle.vectors.len();
        let mut sizes: Vec<usize> = springs.iter().map(size).collect();
        sizes.sort_unstable();
        sizes.dedup();
        let place = |(i, spring): (usize, &TorsionSpring)| {
            let group = sizes.partition_point(|other| *other < size(spring));
            [group, springs[..i].iter().filter(|other| size(other) == size(spring)).count()]
        };
        springs.iter().enumerate().map(place).collect()
    }
}

impl ElementGroup for TorsionSpringGroup {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn len(&self) -> usize {
        self.members.len()
    }

    fn vectors(&self, element: usize) -> &[u32] {
        &self.members[element].angle.vectors
    }

    fn acts_on_ground(&self) -> bool {
        true
    }

    fn is_grounded(&self, element: usize) -> bool {
        self.members[element].angle.grounded
    }

    fn has_rate_damping(&self) -> bool {
        self.members.iter().any(|spring| spring.law.depends_on_rate())
    }

    fn has_actuators(&self) -> bool {
        self.members.iter().any(|spring| spring.law.depends_on_time())
    }

    fn vectors_per_element(&self) -> usize {
        self.vectors
    }

    fn history_per_element(&self) -> usize {
        HISTORY
    }

    fn evaluate(
        &self,
        k: &GroupPoint,
        first: usize,
        forces: &mut [f64],
        mut tangent: Option<TangentRequest>,
    ) {
        let n = self.vectors;
        for (e, out) in forces.chunks_mut(3 * n).enumerate() {
            let spring = &self.members[first + e];
            let turn = spring.turn(k, first + e);
            let Partials { value: moment, by_position, by_rate } = spring.moment(&turn, k);
            for (out, w) in out.chunks_exact_mut(3).zip(&turn.gradient) {
                out.copy_from_slice((w * moment).as_slice());
            }
            let Some(request) = &mut tangent else { continue };
            let weights = request.weights;
            let along = weights.force * (weights.stress * by_position + weights.rate * by_rate);
            let size = 9 * n * (n + 1) / 2;
            let blocks = &mut request.blocks[e * size..(e + 1) * size];
            let bent = weights.force * weights.direction * moment;
            spring.write_blocks(k, &turn, [along, bent], blocks);
        }
    }

    fn evaluate_stresses(
        &self,
        k: &GroupPoint,
        increment: &StressIncrement,
        first: usize,
        (forces, blocks): (&mut [f64], &mut [f64]),
    ) {
        let n = self.vectors;
        let of_each = forces.chunks_mut(3 * n).zip(blocks.chunks_mut(9 * n * (n + 1) / 2));
        for (e, (out, blocks)) in (first..).zip(of_each) {
            let spring = &self.members[e];
            let turn = spring.turn(k, e);
            let displacement = |v: u32| Vec3::from(increment.displacements[v as usize]);
            let of_vectors = spring.angle.vectors.iter().zip(&turn.gradient);
            let angle: f64 = of_vectors.map(|(&v, w)| w.dot(&displacement(v))).sum();
            let moment = spring.moment(&turn, k).by_position * angle;
            for (out, w) in out.chunks_exact_mut(3).zip(&turn.gradient) {
                out.copy_from_slice((w * moment).as_slice());
            }
            spring.write_blocks(k, &turn, [0.0, moment], blocks);
        }
    }

    fn material_energies(&self, k: &GroupPoint, motion: &[Nodal], energies: &mut [f64]) {
        for (number, (spring, energy)) in self.members.iter().zip(energies).enumerate() {
            let turn = spring.turn(k, number);
            let of_vectors = spring.angle.vectors.iter().zip(&turn.gradient);
            let angle: f64 = of_vectors.map(|(&v, w)| w.dot(&Vec3::from(motion[v as usize]))).sum();
            *energy = 0.5 * spring.moment(&turn, k).by_position * angle * angle;
        }
    }

    fn energies(&self, k: &GroupPoint, energies: &mut [f64]) {
        for (number, (spring, energy)) in self.members.iter().zip(energies).enumerate() {
            let [_, angle] = spring.turn(k, number).angles;
            *energy = spring.law.energy(angle) - spring.missing_preload(k) * angle;
        }
    }

    fn update_history(&self, k: &GroupPoint, history: &mut [f64]) -> f64 {
        for (number, (spring, out)) in self.members.iter().zip(history.chunks_exact_mut(HISTORY)).enumerate()
        {
            out[0] = spring.angle(k, TorsionSpring::committed(k, number));
            out[1..].copy_from_slice(&spring.angle.rotation(|v| TorsionSpring::end(k, v)).numbers());
        }
        0.0
    }

    fn dissipation(&self, k: &GroupPoint, power: &mut [f64]) {
        for (number, (spring, power)) in self.members.iter().zip(power).enumerate() {
            let Turn { angles, rate, .. } = spring.turn(k, number);
            *power = spring.law.dissipation(angles, rate, k.time);
        }
    }

    fn work_of_actuators(&self, k: &GroupPoint) -> f64 {
        let of = |(number, spring): (usize, &TorsionSpring)| {
            let Turn { angles, rate, .. } = spring.turn(k, number);
            spring.law.work(angles, rate, k.time)
        };
        let all = self.members.iter().enumerate();
        all.filter(|(_, spring)| spring.law.depends_on_time()).map(of).sum()
    }

    fn reason_without_forces(&self, k: &GroupPoint, element: usize) -> Option<String> {
        let spring = &self.members[element];
        let committed = TorsionSpring::committed(k, element);
        let change = spring.angle(k, committed) - committed.first().copied().unwrap_or(f64::NAN);
        if change.abs() > LARGEST_TURN {
            let reason = format!("would turn by more than {LARGEST_TURN} rad in the step");
            return Some(format!("the torsion spring \"{}\" {reason}", spring.name));
        }
        let Turn { angles, rate, .. } = spring.turn(k, element);
        spring.law.reason_without_force(angles, rate, k.time)
    }

    fn falling_force(&self, k: &GroupPoint) -> Option<String> {
        let mut members = self.members.iter().enumerate();
        members.find_map(|(number, spring)| spring.law.falls(spring.turn(k, number).angles[1], k.time))
    }

    fn pole_in_step(&self, k: &GroupPoint, start: f64) -> Option<String> {
        self.members.iter().enumerate().find_map(|(number, spring)| {
            let Turn { angles, rate, .. } = spring.turn(k, number);
            spring.law.pole(angles, rate, [start, k.time])
        })
    }
}
