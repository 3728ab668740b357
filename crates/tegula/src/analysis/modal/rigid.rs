//! Rigid modes: motions without strain that the supports leave free, part by part.
//!
//! A part is a set of nodal vectors that elements connect. Those of its six rigid motions (three translations, three
//! rotations about its centre) that no support prevents are modes of frequency 0. They follow from geometry and mass
//! alone, so that round-off in the stiffness of the model or of its other parts does not affect them. Under stress a
//! rotation changes the energy (a pendulum in its field of gravity): parts that the equilibrium has moved count by
//! their translations only. A spring to the ground prevents those in which it exerts a force. Parts with joints have none;
//! motions that joints leave free are found as the other modes.

use nalgebra::{DMatrix, SMatrix, SymmetricEigen};

use crate::Vec3;
use crate::analysis::State;
use crate::element::{Nodal, TangentRequest, TangentWeights, forces_of_blocks};
use crate::norm::larger;
use crate::system::{LocalFrames, System, VectorKind, dot3};

/// Number of rigid motions of a part: t + ω × x of positions, ω × d of directors.
const MOTIONS: usize = 6;
/// Fraction of the largest eigenvalue of the supports' Gram matrix below which a motion counts as free.
const FREE: f64 = 1e-12;

/// Force of an element in a motion, relative to the largest one in any motion, below which it is round-off.
const NO_FORCE: f64 = 1e-12;

type Six = SMatrix<f64, MOTIONS, MOTIONS>;

/// Connected parts of a model.
pub(super) struct Parts {
    /// Part of each nodal vector.
    of_vector: Vec<u32>,
    count: usize,
}

impl Parts {
    /// Parts that elements and masses connect, numbered by their first vector.
    pub fn new(system: &System) -> Self {
        let mut root: Vec<u32> = (0..system.vectors() as u32).collect();
        fn find(root: &mut [u32], mut v: u32) -> u32 {
            while root[v as usize] != v {
                root[v as usize] = root[root[v as usize] as usize];
                v = root[v as usize];
            }
            v
        }
        let mut join = |a: u32, b: u32| {
            let (a, b) = (find(&mut root, a), find(&mut root, b));
            root[a.max(b) as usize] = a.min(b);
        };
        for group in system.groups.iter() {
            for e in 0..group.len() {
                let vectors = group.vectors(e);
                vectors.iter().for_each(|&v| join(vectors[0], v));
            }
        }
        system.pattern.for_each_mass(|i, j, _| join(i as u32, j as u32));
        for body in &system.coordinates.bodies {
            body.directors.iter().flatten().for_each(|&director| join(body.centre, director));
            body.attached.iter().for_each(|attached| join(body.centre, attached.vector));
        }
        let mut of_vector = vec![u32::MAX; system.vectors()];
        let mut count = 0;
        for v in 0..system.vectors() {
            let first = find(&mut root, v as u32) as usize;
            if first == v {
                of_vector[v] = count;
                count += 1;
            } else {
                of_vector[v] = of_vector[first];
            }
        }
        Self { of_vector, count: count as usize }
    }

    /// Number of parts.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Part of a nodal vector.
    pub fn of(&self, vector: usize) -> usize {
        self.of_vector[vector] as usize
    }

    /// Whether joints act on each part: its rigid motions need not be modes of frequency 0.
    fn jointed(&self, system: &System) -> Vec<bool> {
        let mut jointed = vec![false; self.count];
        for joint in system.joints.iter() {
            joint.vectors.iter().for_each(|&v| jointed[self.of(v as usize)] = true);
        }
        jointed
    }

    /// Sums of a quantity of the nodal vectors over the parts.
    fn sums(&self, mut of: impl FnMut(usize) -> f64) -> Vec<f64> {
        let mut out = vec![0.0; self.count];
        for v in 0..self.of_vector.len() {
            out[self.of(v)] += of(v);
        }
        out
    }
}

/// A rigid mode of one part, of modal mass 1.
struct RigidMode {
    part: usize,
    /// Coefficients of translation and rotation.
    motion: [f64; MOTIONS],
}

/// Rigid modes of a model.
pub(super) struct RigidModes {
    modes: Vec<RigidMode>,
    /// Six rigid motions, each of all parts at once.
    fields: Vec<Vec<Nodal>>,
}

impl RigidModes {
    /// Rigid modes of a configuration, for the degrees of freedom of `frames`; parts for which `rests` is false keep their
    /// translations only.
    pub fn new(
        system: &System,
        state: &State,
        parts: &Parts,
        frames: &LocalFrames,
        rests: impl Fn(usize) -> bool,
    ) -> Self {
        Self::orthogonal(system, state, (parts, frames), rests, |field, _| mass_products(system, field))
    }

    /// Number of rigid motions of a model at rest that are free, also where it has no mass.
    pub fn count(system: &System) -> usize {
        let (parts, state) = (Parts::new(system), State::unloaded(system));
        let kinds = &system.coordinates.kinds;
        let weighted = |field: &[Nodal], sizes: &[f64]| {
            let weight =
                |v: usize| if kinds[v] == VectorKind::Position { 1.0 } else { sizes[parts.of(v)].powi(2) };
            (0..field.len()).map(|v| field[v].map(|x| weight(v) * x)).collect()
        };
        Self::orthogonal(system, &state, (&parts, &system.frames), |_| true, weighted).len()
    }

    /// Rigid modes, orthogonal in an inner product given by the products of its matrix with fields.
    fn orthogonal(
        system: &System,
        state: &State,
        (parts, frames): (&Parts, &LocalFrames),
        rests: impl Fn(usize) -> bool,
        product: impl Fn(&[Nodal], &[f64]) -> Vec<Nodal>,
    ) -> Self {
        let (fields, sizes) = motions(system, &state.u, parts);
        let gram = gram(&fields, parts, |field| product(field, &sizes));
        let mut free = vec![0.0; frames.dofs().unknowns];
        let supported = |fields: &[Vec<Nodal>]| {
            let rest = |field: &Vec<Nodal>| {
                let mut out = vec![[0.0; 3]; field.len()];
                frames.components(field, &mut free);
                frames.expand(&free, &mut out);
                out.iter_mut().zip(field).for_each(|(o, f)| *o = std::array::from_fn(|i| f[i] - o[i]));
                out
            };
            fields.iter().map(rest).collect::<Vec<_>>()
        };
        let jointed = parts.jointed(system);
        let mut forbidden = supports_gram(system, &fields, (parts, &sizes), supported);
        add_ground_gram(system, state, (&fields, parts), &mut forbidden);
        let mut modes = Vec::new();
        for part in 0..parts.count() {
            let mut rows = forbidden[part];
            if jointed[part] {
                continue;
            }
            if !rests(part) {
                (3..MOTIONS).for_each(|r| rows[(r, r)] += rows.trace().max(1.0));
            }
            for motion in modes_of_part(&rows, &gram[part]) {
                modes.push(RigidMode { part, motion });
            }
        }
        Self { modes, fields }
    }

    /// Number of rigid modes.
    pub fn len(&self) -> usize {
        self.modes.len()
    }

    /// Part of a rigid mode.
    pub fn part(&self, mode: usize) -> usize {
        self.modes[mode].part
    }

    /// Shape of a rigid mode in all nodal vectors.
    pub fn shape(&self, mode: usize, parts: &Parts) -> Vec<Nodal> {
        let RigidMode { part, motion } = &self.modes[mode];
        let at = |v: usize| -> Nodal {
            if parts.of(v) != *part {
                return [0.0; 3];
            }
            std::array::from_fn(|i| motion.iter().zip(&self.fields).map(|(c, field)| c * field[v][i]).sum())
        };
        (0..self.fields[0].len()).map(at).collect()
    }
}

/// Six rigid motions of all parts: unit translations, and rotations about the centres that move the outermost node by
/// about 1; and the sizes of the parts.
fn motions(system: &System, u: &[Nodal], parts: &Parts) -> (Vec<Vec<Nodal>>, Vec<f64>) {
    let current = |v: usize| Vec3::from(system.coordinates.reference[v]) + Vec3::from(u[v]);
    let is_position = |v: usize| system.coordinates.kinds[v] == VectorKind::Position;
    let count = parts.sums(|v| f64::from(u8::from(is_position(v))));
    let sums: [Vec<f64>; 3] =
        std::array::from_fn(|i| parts.sums(|v| if is_position(v) { current(v)[i] } else { 0.0 }));
    let centre = |part: usize| Vec3::from_fn(|i, _| sums[i][part] / count[part].max(1.0));
    let mut size = vec![0.0_f64; parts.count()];
    for v in (0..system.vectors()).filter(|&v| is_position(v)) {
        let part = parts.of(v);
        size[part] = size[part].max((current(v) - centre(part)).norm());
    }
    let axes = [Vec3::x(), Vec3::y(), Vec3::z()];
    let translation =
        |a: Vec3| (0..system.vectors()).map(|v| if is_position(v) { a.into() } else { [0.0; 3] }).collect();
    let rotation = |a: Vec3| {
        let at = |v: usize| -> Nodal {
            let part = parts.of(v);
            let arm = if is_position(v) { current(v) - centre(part) } else { current(v) };
            let size = if size[part] > 0.0 { size[part] } else { 1.0 };
            (a.cross(&arm) / size).into()
        };
        (0..system.vectors()).map(at).collect()
    };
    let fields = axes.into_iter().map(translation).chain(axes.into_iter().map(rotation)).collect();
    (fields, size)
}

fn mass_products(system: &System, field: &[Nodal]) -> Vec<Nodal> {
    let mut out = vec![[0.0; 3]; field.len()];
    system.pattern.add_mass_product(1.0, field, &mut out);
    out
}

/// Gram matrices of the motions of each part.
fn gram(fields: &[Vec<Nodal>], parts: &Parts, product: impl Fn(&[Nodal]) -> Vec<Nodal>) -> Vec<Six> {
    let mut out = vec![Six::zeros(); parts.count()];
    for j in 0..MOTIONS {
        let right = product(&fields[j]);
        for i in 0..=j {
            for (part, sum) in parts.sums(|v| dot3(fields[i][v], right[v])).into_iter().enumerate() {
                out[part][(i, j)] = sum;
                out[part][(j, i)] = sum;
            }
        }
    }
    out
}

/// Gram matrices of the constrained components of the motions; directors are scaled by the size of their part.
fn supports_gram(
    system: &System,
    fields: &[Vec<Nodal>],
    (parts, sizes): (&Parts, &[f64]),
    mut supported: impl FnMut(&[Vec<Nodal>]) -> Vec<Vec<Nodal>>,
) -> Vec<Six> {
    let rows = supported(fields);
    // Round-off of the expansion is no support.
    let rounding = 64.0 * f64::EPSILON;
    let kept = |field: usize, v: usize| -> Nodal {
        let whole = dot3(fields[field][v], fields[field][v]);
        let rest = rows[field][v];
        if dot3(rest, rest) <= rounding * rounding * whole { [0.0; 3] } else { rest }
    };
    let mut out = vec![Six::zeros(); parts.count()];
    for v in 0..system.vectors() {
        let at: [Nodal; MOTIONS] = std::array::from_fn(|field| kept(field, v));
        let part = parts.of(v);
        let weight =
            if system.coordinates.kinds[v] == VectorKind::Position { 1.0 } else { sizes[part].powi(2) };
        for i in 0..MOTIONS {
            for j in 0..MOTIONS {
                out[part][(i, j)] += weight * dot3(at[i], at[j]);
            }
        }
    }
    out
}

/// Adds the Gram matrices of the motions in which elements held by the ground exert forces, of unit size however small the forces are
/// beside those in other motions.
fn add_ground_gram(
    system: &System,
    state: &State,
    (fields, parts): (&[Vec<Nodal>], &Parts),
    out: &mut [Six],
) {
    let (factors, point): (Vec<f64>, _) = (system.factors(state.time).collect(), state.point(system));
    for (number, group, _) in system.numbered_groups() {
        let grounded: Vec<usize> = (0..group.len()).filter(|&element| group.is_grounded(element)).collect();
        if grounded.is_empty() {
            continue;
        }
        let n = group.vectors_per_element();
        let size = 9 * n * (n + 1) / 2;
        let mut forces = vec![0.0; 3 * n * group.len()];
        let mut blocks = vec![0.0; size * group.len()];
        let weights = TangentWeights::STATIC;
        let request = TangentRequest { weights, stress: None, prescribed: None, blocks: &mut blocks };
        let k = point.of_group(system, number, &factors);
        group.evaluate(&k, 0, &mut forces, Some(request));
        for element in grounded {
            let (vectors, blocks) = (group.vectors(element), &blocks[element * size..(element + 1) * size]);
            let scale = blocks.iter().map(|k| k.abs()).fold(0.0, larger);
            let exerted: [Vec<Vec3>; MOTIONS] = std::array::from_fn(|i| {
                forces_of_blocks(blocks, |a| Vec3::from(fields[i][vectors[a] as usize]), n)
            });
            let exerted = DMatrix::from_fn(3 * n, MOTIONS, |row, i| exerted[i][row / 3][row % 3]);
            let svd = exerted.svd(false, true);
            let largest = svd.singular_values.iter().copied().fold(0.0, larger);
            let Some(motions) = svd.v_t.filter(|_| largest > NO_FORCE * scale) else { continue };
            for (motion, force) in motions.row_iter().zip(&svd.singular_values) {
                if *force > NO_FORCE * largest {
                    let motion = nalgebra::SVector::<f64, MOTIONS>::from_fn(|i, _| motion[i]);
                    out[parts.of(vectors[0] as usize)] += motion * motion.transpose();
                }
            }
            // Forces in stiff directions hide those in soft ones, but not the strains of these.
            for gradient in group.resisted_strains(element, &k) {
                let strain = |i: usize| -> f64 {
                    gradient
                        .iter()
                        .zip(vectors)
                        .map(|(g, &v)| g.dot(&Vec3::from(fields[i][v as usize])))
                        .sum()
                };
                let motion = nalgebra::SVector::<f64, MOTIONS>::from_fn(|i, _| strain(i));
                if let Some(motion) =
                    motion.try_normalize(NO_FORCE * gradient.iter().map(|g| g.norm()).fold(0.0, larger))
                {
                    out[parts.of(vectors[0] as usize)] += motion * motion.transpose();
                }
            }
        }
    }
}

/// Motions that the supports' rows leave free (their null space), orthogonal in the mass of the part and of unit modal
/// mass. Those without mass, as the rotation of point masses on a line about it, are no modes: their mass is round-off beside
/// that of the part, also where no other motion is free.
fn modes_of_part(rows: &Six, mass: &Six) -> Vec<[f64; MOTIONS]> {
    let eigen = SymmetricEigen::new(*rows);
    let largest = eigen.eigenvalues.max();
    let free: Vec<usize> = (0..MOTIONS).filter(|&i| eigen.eigenvalues[i] <= FREE * largest).collect();
    if free.is_empty() {
        return Vec::new();
    }
    let basis = DMatrix::from_fn(MOTIONS, free.len(), |i, j| eigen.eigenvectors[(i, free[j])]);
    let dynamic = DMatrix::from_fn(MOTIONS, MOTIONS, |i, j| mass[(i, j)]);
    let reduced = basis.transpose() * dynamic * &basis;
    let eigen = reduced.symmetric_eigen();
    let mut order: Vec<usize> = (0..free.len()).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let motion = |k: usize| {
        let value = eigen.eigenvalues[k];
        (value > FREE * mass.trace()).then(|| {
            let c = &basis * eigen.eigenvectors.column(k) / value.sqrt();
            std::array::from_fn(|i| c[i])
        })
    };
    order.into_iter().filter_map(motion).collect()
}
