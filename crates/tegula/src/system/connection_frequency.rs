//! Bounds of the highest frequency by single connections: springs, torsion springs, bushings, and the tension of joints.
//!
//! They have no mass. Springs and bushings get equal parts of half of the lumped mass of the shell nodes that they contain, joints of a
//! tenth of it, and both together all of the rigid bodies that they connect, so that the theorem of [`element_frequency`](super::element_frequency) holds for them,
//! too: the degrees of freedom of a body are its translation and its rotation, whose inertia is a matrix. Shells keep the masses of
//! the nodes that are attached to a body. To attach them is a constraint, as joints are, and no constraint raises the highest
//! frequency (Rayleigh).
//!
//! The moment of a force f on an arm a that turns with its body adds the stiffness `½ (a fᵀ + f aᵀ) − (a·f) I` of the rotation
//! to that of the force, with internal forces f: that of a pendulum under the forces of its joint.

use super::element_frequency::{MassShares, OF_JOINTS, Square};
use super::lumped_body::LumpedBody;
use super::{EvaluationPoint, System};
use crate::constraint::FoundationElement;
use crate::constraint::joint::{JointGroup, MOST_VECTORS};
use crate::element::{ElementGroup, Nodal, TangentRequest, TangentWeights};
use crate::norm::larger;
use crate::{Mat3, Vec3};

/// Most degrees of freedom of a connection: those of eight nodal vectors and a body.
const LARGEST: usize = 30;

/// Whether the elements of a group are joints, springs or bushings: they have no mass, and may connect rigid bodies.
pub fn is_connection(group: &dyn ElementGroup) -> bool {
    group.acts_on_ground() && group.name() != FoundationElement::NAME
}

/// Whether the elements of a group are joints.
pub(super) fn is_joint(group: &dyn ElementGroup) -> bool {
    group.name() == JointGroup::NAME
}

/// Rigid body that a nodal vector belongs to or is attached to, by the number of its directors.
pub(super) fn body_of(system: &System, vector: u32) -> Option<usize> {
    let dofs = system.dofs();
    if let Some(carried) = dofs.carried(vector as usize) {
        return Some(carried.triad as usize);
    }
    let directors = system.coordinates.body_of(vector as usize)?.directors?;
    dofs.triad_of(directors[0] as usize)
}

/// Bounds of the largest eigenvalues of the stiffness and the damping that connections make, over the mass.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Bounds {
    /// Square of the circular frequency [1/time²].
    pub stiffness: f64,
    /// Damping over mass [1/time].
    pub damping: f64,
}

/// Part of the inertia of a rigid body that one connection has: a spring or bushing, or a joint.
type Parts = [Vec<LumpedBody>; 2];

/// Estimator of the frequencies of connections, with its buffers.
pub struct Connections {
    parts: Parts,
    /// Groups of connections of few nodal vectors, by their number.
    groups: Vec<usize>,
    factors: Vec<f64>,
    forces: Vec<f64>,
    blocks: Vec<f64>,
    square: Box<Square<LARGEST>>,
}

/// Degrees of freedom of a nodal vector of a connection: its side, and its arm about the rotation of a body.
#[derive(Debug, Clone, Copy)]
struct Place {
    /// First degree of freedom of the side.
    first: usize,
    side: Side,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Side {
    Node(f64),
    /// Number of the body, whether its translation moves the vector, and the arm of the vector.
    Body(usize, bool, Vec3),
}

impl Connections {
    /// Estimator for a system with the lumped masses `mass`.
    pub fn new(system: &System, shares: &MassShares, mass: &[f64]) -> Self {
        let few = |g: &usize| {
            let group = system.groups[*g].as_ref();
            is_connection(group) && (1..=MOST_VECTORS).contains(&group.vectors_per_element())
        };
        let groups: Vec<usize> = (0..system.groups.len()).filter(few).collect();
        let mut counts = [vec![0_u32; system.dofs().triads.len()], vec![0; system.dofs().triads.len()]];
        let (mut forces, mut blocks) = (0, 0);
        for group in groups.iter().map(|&g| &system.groups[g]) {
            let n = group.vectors_per_element();
            forces = forces.max(3 * n * group.len());
            blocks = blocks.max(9 * n * (n + 1) / 2 * group.len());
            for e in 0..group.len() {
                let mut bodies: Vec<usize> =
                    group.vectors(e).iter().filter_map(|&v| body_of(system, v)).collect();
                bodies.sort_unstable();
                bodies.dedup();
                bodies.into_iter().for_each(|body| counts[usize::from(is_joint(group.as_ref()))][body] += 1);
            }
        }
        let parts = [false, true].map(|joint| {
            let [own, other] = if joint { [1, 0] } else { [0, 1] }.map(|kind: usize| &counts[kind]);
            let share = if joint { OF_JOINTS } else { 1.0 - OF_JOINTS };
            let number = |body: usize| f64::from(own[body].max(1));
            let of_body = |body: usize| if other[body] > 0 { share } else { 1.0 } / number(body);
            let body = |v: usize| system.dofs().attachment(v).map_or(1.0, |a| number(a.triad as usize));
            LumpedBody::parts(system, mass, of_body, |v| shares.of_connection(v, joint) / body(v))
        });
        let factors = vec![0.0; system.prescribed_strains.len() + system.joints.len()];
        let square = Box::new(Square::new());
        Self { parts, groups, factors, forces: vec![0.0; forces], blocks: vec![0.0; blocks], square }
    }

    /// Bounds at an evaluation point with the displacements `u`.
    pub fn bounds(
        &mut self,
        system: &System,
        (shares, mass): (&MassShares, &[f64]),
        (k, u): (&EvaluationPoint, &[Nodal]),
    ) -> Bounds {
        let mut out = Bounds::default();
        let Self { parts, groups, factors, forces, blocks, square } = self;
        factors.iter_mut().zip(system.factors(k.time)).for_each(|(x, factor)| *x = factor);
        let damping = TangentWeights { stress: 0.0, direction: 0.0, rate: 1.0, ..TangentWeights::STATIC };
        let damping = TangentWeights { multiplier: 0.0, ..damping };
        for &g in groups.iter() {
            let group = system.groups[g].as_ref();
            let n = group.vectors_per_element();
            let forces = &mut forces[..3 * n * group.len()];
            let blocks = &mut blocks[..9 * n * (n + 1) / 2 * group.len()];
            let point = k.of_group(system, g, factors);
            for (weights, damps) in [(TangentWeights::STATIC, false), (damping, true)] {
                if damps && !group.has_rate_damping() {
                    continue;
                }
                let request =
                    TangentRequest { weights, stress: None, prescribed: None, blocks: &mut *blocks };
                group.evaluate(&point, 0, forces, Some(request));
                let elements = forces.chunks(3 * n).zip(blocks.chunks(9 * n * (n + 1) / 2)).enumerate();
                for (e, (forces, blocks)) in elements {
                    let joint = is_joint(group);
                    let parts = &parts[usize::from(joint)];
                    let connection = Connection { system, parts, joint, vectors: group.vectors(e), u };
                    let forces = (!damps).then_some(forces);
                    if !connection.fill(square, (shares, mass), forces, blocks) {
                        continue;
                    }
                    let bound = if damps { &mut out.damping } else { &mut out.stiffness };
                    *bound = larger(*bound, square.bound(*bound));
                }
            }
        }
        out
    }
}

/// One connection at displacements `u`.
struct Connection<'a> {
    system: &'a System,
    parts: &'a [LumpedBody],
    joint: bool,
    vectors: &'a [u32],
    u: &'a [Nodal],
}

impl Connection<'_> {
    /// Sets the stiffness of the connection over its part of the mass: `L⁻¹ K L⁻ᵀ` with `M = L Lᵀ`. False where no such matrix has room.
    fn fill(
        &self,
        square: &mut Square<LARGEST>,
        (shares, mass): (&MassShares, &[f64]),
        forces: Option<&[f64]>,
        blocks: &[f64],
    ) -> bool {
        let mut places = [Place { first: 0, side: Side::Node(1.0) }; MOST_VECTORS];
        let n = self.vectors.len();
        let Some(size) = self.places((shares, mass), &mut places) else { return false };
        square.size = size;
        for row in &mut square.a {
            row.fill(0.0);
        }
        let mut rest = blocks.chunks_exact(9);
        for a in 0..n {
            for b in 0..=a {
                let Some(block) = rest.next() else { return false };
                let block = Mat3::from_row_slice(block);
                self.add(square, [&places[a], &places[b]], &block);
                if a != b {
                    self.add(square, [&places[b], &places[a]], &block.transpose());
                }
            }
        }
        for (place, f) in places[..n].iter().zip(forces.into_iter().flat_map(|f| f.chunks_exact(3))) {
            if let Side::Body(body, _, arm) = place.side {
                let f = Vec3::from_column_slice(f);
                let outer = arm * f.transpose();
                let turned = (outer + outer.transpose()) * 0.5 - Mat3::identity() * arm.dot(&f);
                let scale = self.rotation(body);
                add_block(square, [place.first + 3; 2], &(scale * turned * scale));
            }
        }
        true
    }

    /// Places of the nodal vectors among the degrees of freedom; returns the number of these, or `None` where they are too many.
    fn places(
        &self,
        (shares, mass): (&MassShares, &[f64]),
        out: &mut [Place; MOST_VECTORS],
    ) -> Option<usize> {
        let mut size = 0;
        for (i, &v) in self.vectors.iter().enumerate() {
            let Some(body) = body_of(self.system, v) else {
                let side = Side::Node(shares.of_connection(v as usize, self.joint) * mass[v as usize]);
                out[i] = Place { first: size, side };
                size += 3;
                continue;
            };
            let known = out[..i].iter().find(|p| matches!(p.side, Side::Body(other, ..) if other == body));
            let first = known.map_or(size, |p| p.first);
            size += if known.is_some() { 0 } else { 6 };
            // Arms are about the mass centre, where translation and rotation have no mass in common.
            let part = &self.parts[body];
            let axes = part.axes(self.system, self.u);
            let (moves, arm) = match self.system.dofs().carried(v as usize) {
                Some(carried) if carried.centre.is_some() => (true, carried.coordinates - part.offset),
                Some(carried) => (false, carried.coordinates),
                None => (true, -part.offset),
            };
            out[i] = Place { first, side: Side::Body(body, moves, axes * arm) };
        }
        (size <= LARGEST).then_some(size)
    }

    /// Inverse square root of the part of the moments of inertia of a body.
    fn rotation(&self, body: usize) -> Mat3 {
        let part = &self.parts[body];
        let inertia = part.inertia(&part.axes(self.system, self.u));
        let eigen = inertia.symmetric_eigen();
        let root = Mat3::from_diagonal(&eigen.eigenvalues.map(|x| 1.0 / x.sqrt()));
        eigen.eigenvectors * root * eigen.eigenvectors.transpose()
    }

    /// Adds a block of two nodal vectors.
    fn add(&self, square: &mut Square<LARGEST>, places: [&Place; 2], block: &Mat3) {
        // Each nodal vector moves by up to two parts of its side, at these places and with these factors from the left.
        let parts = |place: &Place| match place.side {
            Side::Node(mass) => [Some((place.first, Mat3::identity() / mass.sqrt())), None],
            Side::Body(body, moves, arm) => {
                let mass = self.parts[body].mass;
                let translation = moves.then(|| (place.first, Mat3::identity() / mass.sqrt()));
                [translation, Some((place.first + 3, self.rotation(body) * arm.cross_matrix()))]
            }
        };
        for (row, left) in parts(places[0]).into_iter().flatten() {
            for (column, right) in parts(places[1]).into_iter().flatten() {
                add_block(square, [row, column], &(left * block * right.transpose()));
            }
        }
    }
}

fn add_block(square: &mut Square<LARGEST>, [row, column]: [usize; 2], block: &Mat3) {
    for i in 0..3 {
        for j in 0..3 {
            square.a[row + i][column + j] += block[(i, j)];
        }
    }
}
