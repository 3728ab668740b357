//! Free motions of mechanisms: the null space of their joints, described by bodies and axes.
//!
//! A velocity of the degrees of freedom is a free motion where it keeps all joints closed, `G v = 0`, and nothing else resists it,
//! `K v = 0` for the stiffness K of springs and elastic parts. The null space is that of the singular values which are round-off, without
//! motions that have a strain energy above the round-off of its terms, as the bending of thin shells has; a basis
//! in which each motion moves few bodies follows by elimination with complete pivoting.

use nalgebra::{DMatrix, SymmetricEigen};

use super::constraints::gradients_at;
use super::{State, equilibrium};
use crate::element::{Nodal, TangentRequest, TangentWeights, VectorKind};
use crate::system::dof_map::CONSTRAINED;
use crate::system::{LocalFrames, System};
use crate::{Mat3, Vec3};
use tegula_sparse::SymmetricPattern;
use tegula_sparse::norm::larger;

/// Largest number of degrees of freedom of which the null space is computed: the matrix is dense.
const MOST: usize = 600;
/// Largest number of degrees of freedom of a model whose equilibrium is searched, too.
const MOST_AT_EQUILIBRIUM: usize = 200;
/// Singular value over the largest one that is round-off.
const ROUND_OFF: f64 = 1e-9;
/// Strain energy over the sum of its absolute terms that is round-off, and that over the energy of a unit motion of the stiffest degree of freedom: motions
/// that strain nothing have terms of round-off alone.
const NO_ENERGY: f64 = 1e-13;
const NO_STIFFNESS: f64 = 1e-24;
/// Component of a direction that its text shows.
const SHOWN: f64 = 5e-5;
/// Part of the velocities of nodes that no rigid motion has, below which it is round-off.
const RIGID: f64 = 1e-4;
/// Most iterations for the eigenvalues of the stiffness along free motions.
const MOST_ITERATIONS: usize = 10_000;
/// Energy of a free motion by the whole tangent, over the sum of its absolute terms, that is round-off.
const NEUTRAL: f64 = 1e-14;
/// Part of a motion, over the largest one, that is round-off.
const NOTHING: f64 = 1e-7;

/// Motions that joints, supports, springs and elastic parts leave free in a state, each as text; none where the model is too large for the
/// search. Where their `number` is known, they are those of the smallest singular values.
pub(super) fn free_motions(system: &System, state: &State, number: Option<usize>) -> Vec<String> {
    Mobility::of(system, state, number).map_or_else(Vec::new, |mobility| mobility.describe(system, state))
}

/// Whether the free motions of each equilibrium of a model are searched: it is a mechanism, and the search costs little.
pub(super) fn is_searched(system: &System) -> bool {
    system.is_mechanism() && system.unknowns() <= MOST_AT_EQUILIBRIUM
}

/// Free motions of a state which neither stresses nor loads hold or drive, each as text: every position along them is an equilibrium.
/// None where the model has no joints, or is too large for the search.
pub(super) fn neutral_motions(system: &System, state: &State) -> Vec<String> {
    let Some(mut mobility) = Mobility::of(system, state, None).filter(|found| found.basis.ncols() > 0) else {
        return Vec::new();
    };
    match equilibrium::tangent(system, state) {
        Ok((pattern, values)) => mobility.retain_neutral(&pattern, &values),
        Err(_) => return Vec::new(),
    }
    mobility.describe(system, state)
}

/// Reason why an equilibrium of a mechanism is refused that is one of many.
pub(super) fn told_neutral(motions: &[String]) -> String {
    format!(
        "the model is a mechanism: joints, springs and supports leave {} motion(s) free which the loads neither hold nor drive: {}. Every position \
         along them is an equilibrium",
        motions.len(),
        motions.join("; ")
    )
}

/// Free motions of a state: an orthonormal basis of their degrees of freedom, those of positions divided by the length of the model.
struct Mobility {
    basis: DMatrix<f64>,
    lengths: Vec<f64>,
    frames: LocalFrames,
}

impl Mobility {
    fn of(system: &System, state: &State, number: Option<usize>) -> Option<Self> {
        let n = system.unknowns();
        if n == 0 || n > MOST || !system.is_mechanism() {
            return None;
        }
        let frames = equilibrium::frames(system, state);
        let lengths = lengths(system);
        let mut rows: Vec<Vec<f64>> = gradients_at(system, &frames, state)
            .into_iter()
            .map(|gradient| {
                let mut row = vec![0.0; n];
                gradient.into_iter().for_each(|(number, x)| row[number as usize] += x);
                row
            })
            .collect();
        let stiffness = stiffness_rows(system, state, &frames);
        rows.extend(stiffness.iter().map(|(_, row)| row.clone()));
        for row in &mut rows {
            row.iter_mut().zip(&lengths).for_each(|(x, length)| *x *= length);
            let size = row.iter().map(|x| x * x).sum::<f64>().sqrt();
            if size > 0.0 {
                row.iter_mut().for_each(|x| *x /= size);
            }
        }
        // As many rows as columns at least: the decomposition has the whole null space then.
        let matrix = DMatrix::from_fn(rows.len().max(n), n, |i, j| rows.get(i).map_or(0.0, |row| row[j]));
        let svd = matrix.svd(false, true);
        let largest = svd.singular_values.iter().copied().fold(0.0, larger);
        let right = svd.v_t?;
        let own = stiffness.iter().map(|(i, row)| row[*i].abs() * lengths[*i] * lengths[*i]);
        let least = NO_STIFFNESS * own.fold(0.0, larger);
        let mut free: Vec<usize> = (0..n).collect();
        free.sort_by(|&i, &j| svd.singular_values[i].total_cmp(&svd.singular_values[j]));
        let is_free = |i: &usize| {
            let motion: Vec<f64> = (0..n).map(|j| right[(*i, j)] * lengths[j]).collect();
            svd.singular_values[*i] <= ROUND_OFF * largest && !has_energy(&stiffness, &motion, least)
        };
        match number {
            Some(number) => free.truncate(number),
            None => free.retain(is_free),
        }
        let basis = DMatrix::from_fn(n, free.len(), |i, j| right[(free[j], i)]);
        Some(Self { basis, lengths, frames })
    }

    /// Leaves the motions along which the tangent with this pattern and these values has no stiffness but round-off of its terms.
    fn retain_neutral(&mut self, pattern: &SymmetricPattern, values: &[f64]) {
        let (n, k) = self.basis.shape();
        let motions = DMatrix::from_fn(n, k, |i, j| self.basis[(i, j)] * self.lengths[i]);
        let sizes: Vec<f64> = values.iter().map(|value| value.abs()).collect();
        let (mut forces, mut terms) = (DMatrix::zeros(n, k), 0.0);
        for (motion, mut force) in motions.column_iter().zip(forces.column_iter_mut()) {
            pattern.add_product(values, motion.into_owned().as_slice(), force.as_mut_slice());
            let size: Vec<f64> = motion.iter().map(|x| x.abs()).collect();
            let mut product = vec![0.0; n];
            pattern.add_product(&sizes, &size, &mut product);
            terms = larger(terms, size.iter().zip(&product).map(|(a, b)| a * b).sum());
        }
        let restricted = motions.tr_mul(&forces);
        let Some(modes) = SymmetricEigen::try_new(restricted, f64::EPSILON, MOST_ITERATIONS) else { return };
        let neutral: Vec<usize> = (0..k).filter(|&i| modes.eigenvalues[i].abs() <= NEUTRAL * terms).collect();
        let directions = DMatrix::from_fn(k, neutral.len(), |i, j| modes.eigenvectors[(i, neutral[j])]);
        self.basis = &self.basis * directions;
    }

    /// Motions as text, in a basis in which each of them moves few bodies.
    fn describe(mut self, system: &System, state: &State) -> Vec<String> {
        eliminate(&mut self.basis);
        let (n, columns) = self.basis.shape();
        let describe_column = |column: usize| {
            let free: Vec<f64> = (0..n).map(|i| self.basis[(i, column)] * self.lengths[i]).collect();
            let mut field = vec![[0.0; 3]; system.vectors()];
            self.frames.expand(&free, &mut field);
            describe(system, &state.u, &field)
        };
        (0..columns).filter_map(describe_column).collect()
    }
}

/// Sizes of unit motions of the degrees of freedom: those of positions are multiplied by the length of the model.
fn lengths(system: &System) -> Vec<f64> {
    let mut out = vec![1.0; system.unknowns()];
    for (v, kind) in system.coordinates.kinds.iter().enumerate() {
        for number in system.dofs().of(v).into_iter().filter(|n| *n != CONSTRAINED) {
            if *kind == VectorKind::Position {
                out[number as usize] = system.length;
            }
        }
    }
    out
}

/// Whether a motion strains springs or elastic parts of this stiffness by more than the least energy.
fn has_energy(stiffness: &[(usize, Vec<f64>)], motion: &[f64], least: f64) -> bool {
    let (mut energy, mut size) = (0.0, 0.0);
    for (i, row) in stiffness {
        for (k, x) in row.iter().zip(motion) {
            let term = motion[*i] * k * x;
            energy += term;
            size += term.abs();
        }
    }
    energy > larger(NO_ENERGY * size, least)
}

/// Rows of the material stiffness of springs and elastic parts that are not joints, with their numbers; those that are zero are left out.
fn stiffness_rows(system: &System, state: &State, frames: &LocalFrames) -> Vec<(usize, Vec<f64>)> {
    let n = system.unknowns();
    let (factors, point): (Vec<f64>, _) = (system.factors(state.time).collect(), state.point(system));
    let mut out = vec![vec![0.0; n]; n];
    let weights = TangentWeights { direction: 0.0, multiplier: 0.0, ..TangentWeights::STATIC };
    for (number, group, _) in system.numbered_groups() {
        let vectors = group.vectors_per_element();
        let size = 9 * vectors * (vectors + 1) / 2;
        let mut forces = vec![0.0; 3 * vectors * group.len()];
        let mut blocks = vec![0.0; size * group.len()];
        let request = TangentRequest { weights, stress: None, prescribed: None, blocks: &mut blocks };
        group.evaluate(&point.of_group(system, number, &factors), 0, &mut forces, Some(request));
        for element in 0..group.len() {
            let (list, blocks) = (group.vectors(element), &blocks[element * size..(element + 1) * size]);
            let mut block = blocks.chunks_exact(9);
            for a in 0..vectors {
                for b in 0..=a {
                    let Some(block) = block.next() else { continue };
                    let entry = |i: usize, j: usize| block[3 * i + j];
                    add_block(frames, (list[a], list[b]), entry, &mut out);
                    if a != b {
                        add_block(frames, (list[b], list[a]), |i, j| entry(j, i), &mut out);
                    }
                }
            }
        }
    }
    out.into_iter().enumerate().filter(|(_, row)| row.iter().any(|x| *x != 0.0)).collect()
}

/// Adds a block of the stiffness to rows of the degrees of freedom.
fn add_block(
    frames: &LocalFrames,
    (a, b): (u32, u32),
    entry: impl Fn(usize, usize) -> f64,
    rows: &mut [Vec<f64>],
) {
    for i in 0..3 {
        let mut unit = Vec3::zeros();
        unit[i] = 1.0;
        let force = Vec3::from_fn(|j, _| entry(i, j));
        frames.reduce_one(a as usize, &unit, |row, x| {
            frames.reduce_one(b as usize, &force, |column, y| rows[row as usize][column as usize] += x * y);
        });
    }
}

/// Changes the basis of a null space so that each of its vectors has as few entries as elimination with complete pivoting leaves.
fn eliminate(basis: &mut DMatrix<f64>) {
    let columns = basis.ncols();
    let mut used = vec![false; basis.nrows()];
    for k in 0..columns {
        let mut pivot = (0, k, 0.0);
        for j in k..columns {
            for (i, _) in used.iter().enumerate().filter(|(_, used)| !**used) {
                if basis[(i, j)].abs() > pivot.2 {
                    pivot = (i, j, basis[(i, j)].abs());
                }
            }
        }
        let (row, column, size) = pivot;
        if size == 0.0 {
            return;
        }
        used[row] = true;
        basis.swap_columns(k, column);
        let scale = 1.0 / basis[(row, k)];
        basis.column_mut(k).scale_mut(scale);
        for j in (0..columns).filter(|&j| j != k) {
            let factor = basis[(row, j)];
            let change = basis.column(k) * factor;
            let mut column = basis.column_mut(j);
            column -= change;
        }
    }
}

/// Motion of the body that a field of velocities moves most, and the other bodies that move with it; `None` where no body moves.
pub(super) fn describe(system: &System, u: &[Nodal], field: &[Nodal]) -> Option<String> {
    let at = |v: usize| Vec3::from(system.coordinates.reference[v]) + Vec3::from(u[v]);
    let velocity = |v: u32| Vec3::from(field[v as usize]);
    let moves = |body: &crate::system::coordinates::Body| {
        let spin = body.directors.map_or(Vec3::zeros(), |directors| {
            directors.iter().map(|&d| at(d as usize).cross(&velocity(d))).sum::<Vec3>() * 0.5
        });
        (velocity(body.centre), spin)
    };
    let size = |(t, w): &(Vec3, Vec3)| t.norm() / system.length + w.norm();
    let bodies = &system.coordinates.bodies;
    if bodies.is_empty() {
        let (motion, centre) = motion_of_mesh(system, u, field)?;
        return Some(format!("the mesh {}", told(system, motion, centre)));
    }
    let largest = bodies.iter().max_by(|a, b| size(&moves(a)).total_cmp(&size(&moves(b))))?;
    let motion = moves(largest);
    let others = field.iter().enumerate().filter(|(v, _)| system.coordinates.body_of(*v).is_none());
    let elsewhere = others.map(|(v, x)| {
        let x = Vec3::from(*x).norm();
        if system.coordinates.kinds[v] == VectorKind::Position { x / system.length } else { x }
    });
    let elsewhere = elsewhere.fold(0.0, larger);
    if !(size(&motion) > NOTHING * elsewhere) {
        return None;
    }
    let how = told(system, motion, at(largest.centre as usize));
    let mut with: Vec<String> = bodies
        .iter()
        .filter(|body| body.name != largest.name && size(&moves(body)) > NOTHING * size(&motion))
        .map(|body| format!("\"{}\"", body.name))
        .collect();
    if elsewhere > NOTHING * size(&motion) {
        with.push("nodes of the mesh".into());
    }
    let with = if with.is_empty() { String::new() } else { format!(", and with it {}", with.join(", ")) };
    Some(format!("body \"{}\" {how}{with}", largest.name))
}

/// Velocity of the centre of all nodes, angular velocity, and the centre, where a field of velocities is that of a rigid body.
fn motion_of_mesh(system: &System, u: &[Nodal], field: &[Nodal]) -> Option<((Vec3, Vec3), Vec3)> {
    let is_place = |v: &usize| system.coordinates.kinds[*v] == VectorKind::Position;
    let places = || (0..system.vectors()).filter(is_place);
    let at = |v: usize| Vec3::from(system.coordinates.reference[v]) + Vec3::from(u[v]);
    let mean = |of: &dyn Fn(usize) -> Vec3| places().map(of).sum::<Vec3>() / places().count() as f64;
    let (centre, t) = (mean(&at), mean(&|v| Vec3::from(field[v])));
    let arm = |v: usize| at(v) - centre;
    let moment: Vec3 = places().map(|v| arm(v).cross(&Vec3::from(field[v]))).sum();
    let inertia: Mat3 =
        places().map(|v| Mat3::identity() * arm(v).norm_squared() - arm(v) * arm(v).transpose()).sum();
    let w = inertia.try_inverse()? * moment;
    let left = places().map(|v| (Vec3::from(field[v]) - t - w.cross(&arm(v))).norm()).fold(0.0, larger);
    let size = places().map(|v| Vec3::from(field[v]).norm()).fold(0.0, larger);
    let along = w * (t.dot(&w) / w.norm_squared());
    let t = if along.norm() <= RIGID * system.length * w.norm() { t - along } else { t };
    (left <= RIGID * size).then_some(((t, w), centre))
}

/// Motion with this velocity and angular velocity of a point, as text.
fn told(system: &System, (t, w): (Vec3, Vec3), centre: Vec3) -> String {
    if w.norm() * system.length <= NOTHING * t.norm() {
        let t = axis(t);
        format!("moves along ({}, {}, {})", number(t.x), number(t.y), number(t.z))
    } else {
        let p = centre + w.cross(&t) / w.norm_squared();
        let along = t.dot(&w) / w.norm_squared();
        let a = axis(w);
        let pitch = if along.abs() > NOTHING * system.length {
            format!(", moving along it by {along:.4} per radian")
        } else {
            String::new()
        };
        format!(
            "turns about the axis through ({}, {}, {}) along ({}, {}, {}){pitch}",
            number(p.x),
            number(p.y),
            number(p.z),
            number(a.x),
            number(a.y),
            number(a.z)
        )
    }
}

/// Direction of a vector, with a positive first component.
fn axis(v: Vec3) -> Vec3 {
    let v = v.normalize();
    let first = v.iter().copied().find(|x| x.abs() > SHOWN).unwrap_or(1.0);
    v * first.signum()
}

/// Number with four digits, without the sign of a zero that is round-off.
fn number(x: f64) -> String {
    let text = format!("{x:.4}");
    if text == "-0.0000" { "0.0000".into() } else { text }
}
