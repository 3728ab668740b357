//! Places at which the search for the nearest position begins.
//!
//! They are the reference configuration and positions in which the bodies are turned at random. From there the bodies are placed one after the other from the ground or
//! the heaviest body on, each closing its joints with those that are placed: the joints of a mechanism without loops are closed so, whatever the masses, and those
//! of loops but for the last ones. Then all joints are closed together.

use super::{Closing, Movable};
use crate::Vec3;
use crate::constraint::Joint;
use crate::mesh::Random;

/// Positions with turned bodies: least number, product with the square of the number of bodies (of which each takes a time that grows with its cube), most.
const STARTS: [usize; 3] = [2, 4800, 48];
/// Largest angles by which bodies are turned there (rad).
const TURNS: [f64; 4] = [3.1, 0.05, 1.5, 0.5];
/// Distance over that of the nearest position so far, below which another one is nearer.
const NEARER: f64 = 1.0 - 1e-6;

impl Closing<'_> {
    /// Nearest of the closed positions that are reached from `x`, from the reference configuration and from positions in which the bodies are turned;
    /// `None` where none is closed.
    pub(in crate::compile) fn nearest(&self, x: Vec<Vec3>, axes: &[Vec3]) -> Option<Vec<Vec3>> {
        let mut best: Option<(f64, Vec<Vec3>)> = None;
        let count = (STARTS[1] / self.bodies.len().max(1).pow(2)).clamp(STARTS[0], STARTS[2]);
        for number in 0..=count + 1 {
            let start = match number {
                0 => x.clone(),
                1 => self.reference.to_vec(),
                _ => self.turned(number - 1, axes),
            };
            let Some(mut trial) = self.closed_from(start, number > 0) else { continue };
            self.approach(&super::Aim::Reference, &mut trial);
            let distance = self.distance(&trial);
            if best.as_ref().is_none_or(|(least, _)| distance < NEARER * least) {
                best = Some((distance, trial));
            }
        }
        best.map(|(_, x)| x)
    }

    /// Closed position that is reached from this one, also with the bodies placed one by one before, or not.
    fn closed_from(&self, start: Vec<Vec3>, placed: bool) -> Option<Vec<Vec3>> {
        for one_by_one in [placed, !placed] {
            let mut trial = start.clone();
            if one_by_one {
                self.place_one_by_one(&mut trial);
            }
            self.close(&mut trial);
            if self.is_closed(&trial) {
                return Some(trial);
            }
        }
        None
    }

    /// Reference positions in which each body is turned by a random angle, about an axis of the joints, along which it is displaced, or about one of its own: a
    /// screw has a position for each turn of its thread.
    fn turned(&self, number: usize, axes: &[Vec3]) -> Vec<Vec3> {
        let mut random = Random(number as u64);
        let largest = TURNS[number / 2 % TURNS.len()];
        let common = axes.get(number / 2 % axes.len().max(1)).filter(|_| number % 2 == 1);
        let mut x = self.reference.to_vec();
        for body in self.bodies {
            let own = Vec3::from_fn(|_, _| random.symmetric());
            let axis = common.unwrap_or(&own).normalize();
            let shift = if common.is_some() { 0.5 * self.length * largest / TURNS[0] } else { 0.0 };
            let [shift, angle] = [shift, largest].map(|most| axis * (most * random.symmetric()));
            body.turn(&[shift, angle], &mut x);
        }
        x
    }

    /// Places the bodies one after the other so that they close their joints with the ground and with bodies that are placed.
    fn place_one_by_one(&self, x: &mut Vec<Vec3>) {
        let movable = |joint: &&Joint| joint.vectors.iter().any(|&v| self.owner[v as usize].is_some());
        let joints: Vec<(&Joint, Vec<usize>)> =
            self.joints.iter().filter(movable).map(|joint| (joint, self.bodies_of(joint))).collect();
        let mut placed = vec![false; self.bodies.len()];
        for _ in 0..self.bodies.len() {
            let ready = |body: usize, placed: &[bool]| -> Vec<Joint> {
                let others = |of: &[usize]| of.iter().all(|other| *other == body || placed[*other]);
                let own = joints.iter().filter(|(_, of)| of.contains(&body) && others(of));
                own.map(|(joint, _)| (*joint).clone()).collect()
            };
            let free: Vec<usize> = (0..self.bodies.len()).filter(|body| !placed[*body]).collect();
            let next = free.iter().map(|&body| (body, ready(body, &placed))).find(|(_, own)| !own.is_empty());
            if let Some((body, own)) = next {
                self.place(body, &own, x);
                placed[body] = true;
                continue;
            }
            let heavier = |a: &&usize, b: &&usize| self.bodies[**a].mass.total_cmp(&self.bodies[**b].mass);
            let Some(&root) = free.iter().max_by(heavier) else { return };
            placed[root] = true;
        }
    }

    /// Bodies that a joint connects.
    fn bodies_of(&self, joint: &Joint) -> Vec<usize> {
        let mut out: Vec<usize> = joint.vectors.iter().filter_map(|&v| self.owner[v as usize]).collect();
        out.sort_unstable();
        out.dedup();
        out
    }

    /// Moves a body so that it closes these joints as far as it can.
    fn place(&self, body: usize, joints: &[Joint], x: &mut Vec<Vec3>) {
        let alone = [self.bodies[body].clone()];
        let of_body = x.clone();
        let closing = Closing::new((joints, &alone), (&of_body, self.length));
        closing.close(x);
        // An axis that lies half a turn away is less than a right angle away after half a turn about one of three axes.
        for axis in [Vec3::x(), Vec3::y(), Vec3::z()] {
            if closing.is_on_branch(x) {
                return;
            }
            let mut trial = x.clone();
            Movable::turn(&alone[0], &[Vec3::zeros(), axis * std::f64::consts::PI], &mut trial);
            closing.close(&mut trial);
            if closing.is_on_branch(&trial) {
                *x = trial;
            }
        }
    }
}
