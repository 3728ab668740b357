//! Follower loads in the assembly: their forces, and their load stiffness with its reduction to rigid bodies.

use super::{BATCH, FieldStiffness, TangentCoefficients, pairs};
use crate::Vec3;
use crate::element::{Motion, Nodal};
use crate::load::FollowerLoad;
use crate::system::evaluation_point::current_vector;
use crate::system::{LocalFrames, System};

/// Writes the symmetric load stiffness of the batch of follower loads that begins with number `first`, each times a factor, and behind it
/// the blocks that are reduced to the degrees of freedom of rigid bodies. Returns the size of both.
pub(super) fn load_stiffness(
    system: &System,
    motion: &Motion,
    (first, factor): (usize, &dyn Fn(&FollowerLoad) -> f64),
    fields: &FieldStiffness,
    frames: &LocalFrames,
    blocks: &mut [f64],
) -> usize {
    let batch = first..system.followers.len().min(first + BATCH);
    let mut size = 0;
    for (number, load) in batch.clone().zip(&system.followers[batch.clone()]) {
        let n = load.vectors().len();
        let own = &mut blocks[size..size + 9 * pairs(n)];
        if let Some(block) = fields.block(system, number) {
            own.copy_from_slice(((block + block.transpose()) * 0.5).as_slice());
            size += own.len();
            continue;
        }
        let mut x = [Vec3::zeros(); 4];
        current(system, motion, load.vectors(), &mut x);
        load.stiffness(&x[..n], own);
        let factor = factor(load);
        own.iter_mut().for_each(|v| *v *= factor);
        size += own.len();
    }
    if let Some(reduction) = &system.reduction_of_followers {
        let (own, reduced) = blocks.split_at_mut(size);
        let reduced = &mut reduced[..9 * reduction.blocks(batch.clone())];
        reduction.reduce(batch, frames, own, reduced);
        size += reduced.len();
    }
    size
}

/// Nodal vectors of the configuration on which the forces of a motion act.
fn current(system: &System, motion: &Motion, vectors: &[u32], x: &mut [Vec3; 4]) {
    for (x, &v) in x.iter_mut().zip(vectors) {
        *x = current_vector(system, motion, v as usize);
    }
}

/// Adds the follower loads, the centrifugal forces and those of inertia relief at a time, times `factor`.
pub fn add_follower_loads(system: &System, motion: &Motion, time: f64, factor: f64, out: &mut [Nodal]) {
    add_applied_follower_loads(system, motion, time, factor, out);
    system.add_inertia_relief(motion, time, factor, out);
}

/// Adds the follower loads and the centrifugal forces at a time, times `factor`.
pub(in crate::system) fn add_applied_follower_loads(
    system: &System,
    motion: &Motion,
    time: f64,
    factor: f64,
    out: &mut [Nodal],
) {
    system.add_field_loads(motion, (time, factor), |_| true, out);
    for load in system.followers.iter().filter(|load| !matches!(load, FollowerLoad::Field { .. })) {
        let mut x = [Vec3::zeros(); 4];
        current(system, motion, load.vectors(), &mut x);
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
    system.add_centrifugal(motion, time, factor, out);
}

/// Adds the change of the follower loads in an increment of the motion, `∂f/∂x Δ`, with the weights of a tangent.
pub fn add_follower_stiffness(
    system: &System,
    motion: &Motion,
    parts: &TangentCoefficients,
    increment: &[Nodal],
    out: &mut [Nodal],
) {
    if system.linear {
        return;
    }
    system.add_centrifugal_stiffness(parts, increment, out);
    let direction = parts.weights.force * parts.weights.direction;
    let fields = FieldStiffness::of(system, motion, parts);
    for (number, load) in system.followers.iter().enumerate() {
        let vectors = load.vectors();
        let delta = |b: usize| Vec3::from(increment[vectors[b] as usize]);
        if (0..vectors.len()).all(|b| delta(b) == Vec3::zeros()) {
            continue;
        }
        if let Some(block) = fields.block(system, number) {
            let change = block * delta(0);
            (0..3).for_each(|i| out[vectors[0] as usize][i] -= change[i]);
            continue;
        }
        let mut x = [Vec3::zeros(); 4];
        current(system, motion, vectors, &mut x);
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
