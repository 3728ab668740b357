//! Local frames of the nodal vectors in a state: transformation between fields and free degrees of freedom.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::Attached;
use super::dof_map::{CONSTRAINED, DofMap, Prescribed};
use super::supports::{Conflict, Support, constrain};
use crate::element::Nodal;
use crate::{Mat3, Vec3};

/// Local frames of the nodal vectors in a state, with the degree-of-freedom map that they share with the system.
///
/// The degrees of freedom of a nodal vector are its components along the axes of its frame: the global axes, axes along
/// and across an inclined support, or, for an inextensible director, tangents of the sphere on which it moves. These last
/// ones [follow](Self::follow) the director, so that each solver owns the frames of the state at which it linearises.
#[derive(Debug, Clone, Default)]
pub struct LocalFrames {
    /// Degree-of-freedom map.
    dofs: Arc<DofMap>,
    /// Frames (axes as columns) of the vectors that have one; empty if none has.
    frames: Vec<Option<Mat3>>,
    /// Directors of each rigid body, as columns: arms of its rotation.
    triads: Vec<Mat3>,
}

impl LocalFrames {
    /// Degree-of-freedom map of the nodal vectors `reference` under the given supports, and their frames; the vectors of
    /// `unit` are inextensible unless they are fully constrained, those of each triad are the directors of a rigid body, and
    /// those that are `attached` follow one.
    ///
    /// # Errors
    /// Supports that prescribe the same component differently.
    pub fn new(
        supports: &[Support],
        unit: &BTreeSet<u32>,
        (triads, attached): (&[[u32; 3]], &[Attached]),
        reference: &[Nodal],
    ) -> Result<Self, Vec<Conflict>> {
        let (dofs, frames) = constrain(supports, unit, (triads, attached), reference)?;
        let triads = triads.iter().map(|t| directors(t, |v| Vec3::from(reference[v]))).collect();
        Ok(Self { dofs: Arc::new(dofs), frames, triads })
    }

    /// Degree-of-freedom map.
    pub fn dofs(&self) -> &Arc<DofMap> {
        &self.dofs
    }

    /// Numbers of the three degrees of freedom of a vector, [`CONSTRAINED`] for those that are not free.
    #[inline]
    pub fn of(&self, vector: usize) -> [u32; 3] {
        self.dofs.of(vector)
    }

    /// Starts an analysis step at the displacements `u`: prescribed degrees of freedom continue from there, and fixed ones
    /// stay there. Frames belong to the configuration `current`: in linear models to the reference configuration.
    pub fn start_at(&mut self, current: &[Nodal], u: &[Nodal]) {
        let current = |v: usize| Vec3::from(current[v]);
        self.follow(current);
        let mut held: BTreeMap<u32, Prescribed> = BTreeMap::new();
        for (v, value) in u.iter().enumerate().filter(|(v, _)| !self.dofs.is_carried(*v)) {
            let (local, numbers) = (self.to_local(v, *value), self.of(v));
            for (c, start) in local.into_iter().enumerate().filter(|(_, x)| *x != 0.0) {
                let dof = (3 * v + c) as u32;
                if numbers[c] == CONSTRAINED {
                    held.insert(dof, Prescribed { dof, value: 0.0, amplitude: None, start, held: true });
                }
            }
        }
        let dofs = Arc::make_mut(&mut self.dofs);
        for unit in &mut dofs.unit {
            let v = unit.vector;
            held.retain(|dof, _| dof / 3 != v);
            unit.held = unit.fixed.map(|axis| axis.dot(&current(v as usize)));
        }
        for prescribed in &mut dofs.prescribed {
            prescribed.start = held.remove(&prescribed.dof).map_or(0.0, |h| h.start);
        }
        dofs.prescribed.extend(held.into_values());
    }

    /// Rotates the local frames of inextensible directors and of rigid bodies to their present values.
    pub fn follow(&mut self, value: impl Fn(usize) -> Vec3) {
        for unit in &self.dofs.unit {
            self.frames[unit.vector as usize] = Some(unit.axes(&value(unit.vector as usize)));
        }
        self.follow_bodies(value);
    }

    /// Rotates the local frames of rigid bodies to the present values of their directors.
    pub fn follow_bodies(&mut self, value: impl Fn(usize) -> Vec3) {
        for (arms, triad) in self.triads.iter_mut().zip(&self.dofs.triads) {
            *arms = directors(triad, &value);
        }
    }

    /// Whether frames follow the motion: those of inextensible directors and rigid bodies.
    pub fn rotate_with_motion(&self) -> bool {
        !(self.dofs.unit.is_empty() && self.dofs.triads.is_empty())
    }

    /// Copies the local frames of the vectors from another state.
    pub fn copy_from(&mut self, other: &Self) {
        if !self.dofs.unit.is_empty() {
            self.frames.copy_from_slice(&other.frames);
        }
        self.copy_triads(other);
    }

    /// Copies the directors of rigid bodies from another state. Degrees of freedom of a rotation count along the axes of
    /// space, so that a factor in the frames of an earlier state takes moments about the present directors.
    pub fn copy_triads(&mut self, other: &Self) {
        self.triads.copy_from_slice(&other.triads);
    }

    /// Directors of a rigid body, as columns.
    pub fn triad(&self, body: usize) -> &Mat3 {
        &self.triads[body]
    }

    /// Directors of each rigid body, as columns, with the numbers of their nodal vectors.
    pub fn triads(&self) -> impl Iterator<Item = (&[u32; 3], &Mat3)> {
        self.dofs.triads.iter().zip(&self.triads)
    }

    /// Nodal vectors attached to rigid bodies, with their arms about the rotations.
    pub fn attached(&self) -> impl Iterator<Item = (&Attached, Vec3)> {
        self.dofs.attached.iter().map(|attached| (attached, self.arm(attached)))
    }

    /// Arm of a vector that is fixed in a rigid body about the rotation of the body.
    pub(super) fn arm(&self, attached: &Attached) -> Vec3 {
        self.triads[attached.triad as usize] * attached.coordinates
    }

    /// Local frame (axes as columns) of a vector that has one.
    #[inline]
    pub fn frame(&self, vector: usize) -> Option<&Mat3> {
        self.frames.get(vector)?.as_ref()
    }

    /// Whether all degrees of freedom of a vector are free and along the global axes.
    pub fn is_plain(&self, vector: usize) -> bool {
        self.frame(vector).is_none() && self.of(vector).iter().all(|&n| n != CONSTRAINED)
    }

    /// Components of a field in the local frame of a vector.
    pub fn to_local(&self, vector: usize, value: Nodal) -> Nodal {
        match self.frame(vector) {
            None => value,
            Some(q) => (q.transpose() * Vec3::from(value)).into(),
        }
    }

    /// Global components from those in the local frame of a vector.
    pub fn to_global(&self, vector: usize, value: Nodal) -> Nodal {
        match self.frame(vector) {
            None => value,
            Some(q) => (q * Vec3::from(value)).into(),
        }
    }

    /// Rotates a block of a matrix (by rows) to the local frames of its vectors: `Qᵢᵀ K Qⱼ`.
    #[inline]
    pub fn rotate(&self, k: &mut [f64; 9], i: usize, j: usize) {
        let (q_i, q_j) = (self.frame(i), self.frame(j));
        if q_i.is_none() && q_j.is_none() {
            return;
        }
        let mut m = Mat3::from_row_slice(k);
        if let Some(q) = q_i {
            m = q.transpose() * m;
        }
        if let Some(q) = q_j {
            m *= q;
        }
        for r in 0..3 {
            for c in 0..3 {
                k[3 * r + c] = m[(r, c)];
            }
        }
    }

    /// Free degrees of freedom of a field of forces; of rigid bodies the moment of those on their directors, and resultant
    /// and moment of those on attached vectors.
    pub fn reduce(&self, field: &[Nodal], free: &mut [f64]) {
        for (v, value) in field.iter().enumerate() {
            let local = self.to_local(v, *value);
            for (number, x) in self.of(v).into_iter().zip(local) {
                if number != CONSTRAINED {
                    free[number as usize] = x;
                }
            }
        }
        for (triad, arms) in self.triads() {
            let moment: Vec3 =
                (0..3).map(|i| arms.column(i).cross(&Vec3::from(field[triad[i] as usize]))).sum();
            for (number, x) in self.of(triad[0] as usize).into_iter().zip(moment.iter()) {
                free[number as usize] = *x;
            }
        }
        for (attached, arm) in self.attached() {
            self.reduce_attached(
                attached,
                &arm,
                &Vec3::from(field[attached.vector as usize]),
                |number, x| {
                    free[number as usize] += x;
                },
            );
        }
    }

    /// Free degrees of freedom of a field of displacements; of rigid bodies the rotation `½ Σ d_i × δd_i` of their directors.
    pub fn components(&self, field: &[Nodal], free: &mut [f64]) {
        for (v, value) in field.iter().enumerate() {
            for (number, x) in self.of(v).into_iter().zip(self.to_local(v, *value)) {
                if number != CONSTRAINED {
                    free[number as usize] = x;
                }
            }
        }
        for (triad, arms) in self.triads() {
            let turned = |i: usize| arms.column(i).cross(&Vec3::from(field[triad[i] as usize]));
            let rotation = (0..3).map(turned).sum::<Vec3>() * 0.5;
            for (number, x) in self.of(triad[0] as usize).into_iter().zip(rotation.iter()) {
                free[number as usize] = *x;
            }
        }
    }

    /// Hands force and moment on the body of an attached vector on which a force acts to `take`.
    fn reduce_attached(&self, attached: &Attached, arm: &Vec3, force: &Vec3, mut take: impl FnMut(u32, f64)) {
        let first = self.dofs.triads[attached.triad as usize][0];
        let parts = [(Some(first), arm.cross(force)), (attached.centre, *force)];
        for (v, value) in parts.into_iter().filter_map(|(v, value)| Some((v? as usize, value))) {
            for (number, x) in self.of(v).into_iter().zip(self.to_local(v, value.into())) {
                if number != CONSTRAINED {
                    take(number, x);
                }
            }
        }
    }

    /// Field of given free degrees of freedom, zero where constrained.
    pub fn expand(&self, free: &[f64], field: &mut [Nodal]) {
        for (v, value) in field.iter_mut().enumerate() {
            let local = self.of(v).map(|n| if n == CONSTRAINED { 0.0 } else { free[n as usize] });
            *value = self.to_global(v, local);
        }
        self.expand_bodies(free, field);
    }

    /// Hands the free degrees of freedom of a force on one nodal vector to `take`, one after another.
    pub fn reduce_one(&self, vector: usize, force: &Vec3, mut take: impl FnMut(u32, f64)) {
        if let Some(attached) = self.dofs.carried(vector) {
            return self.reduce_attached(&attached, &self.arm(&attached), force, take);
        }
        for (number, x) in self.of(vector).into_iter().zip(self.to_local(vector, (*force).into())) {
            if number != CONSTRAINED {
                take(number, x);
            }
        }
    }

    /// Change of one nodal vector, from values of the free degrees of freedom.
    pub fn expand_one(&self, vector: usize, free: impl Fn(u32) -> f64) -> Vec3 {
        let own = |v: usize| {
            let local = self.of(v).map(|n| if n == CONSTRAINED { 0.0 } else { free(n) });
            Vec3::from(self.to_global(v, local))
        };
        let Some(attached) = self.dofs.carried(vector) else { return own(vector) };
        let rotation = own(self.dofs.triads[attached.triad as usize][0] as usize);
        let translation = attached.centre.map_or_else(Vec3::zeros, |centre| own(centre as usize));
        translation + rotation.cross(&self.arm(&attached))
    }

    /// Changes `δd_i = δθ × d_i` of the directors of rigid bodies, of given free degrees of freedom, and those of the vectors
    /// attached to the bodies.
    pub fn expand_bodies(&self, free: &[f64], field: &mut [Nodal]) {
        for (triad, arms) in self.triads() {
            let rotation = Vec3::from(self.of(triad[0] as usize).map(|n| free[n as usize]));
            for (i, &v) in triad.iter().enumerate() {
                field[v as usize] = rotation.cross(&arms.column(i)).into();
            }
        }
        self.dofs.carry(field);
    }

    /// Part of a field along constrained degrees of freedom (reactions of a residual).
    pub fn constrained_part(&self, field: &[Nodal], out: &mut [Nodal]) {
        for (v, (value, out)) in field.iter().zip(out.iter_mut()).enumerate() {
            let mut local = self.to_local(v, *value);
            for (number, x) in self.of(v).into_iter().zip(&mut local) {
                if number != CONSTRAINED {
                    *x = 0.0;
                }
            }
            *out = self.to_global(v, local);
        }
        let attached = self.dofs.attached.iter().map(|attached| &attached.vector);
        for v in self.dofs.triads.as_flattened().iter().chain(attached) {
            out[*v as usize] = [0.0; 3];
        }
    }

    /// Removes from inextensible directors the part of a field along constrained degrees of freedom.
    pub fn free_part(&self, field: &mut [Nodal]) {
        for unit in &self.dofs.unit {
            let v = unit.vector as usize;
            let mut local = self.to_local(v, field[v]);
            for (number, x) in self.of(v).into_iter().zip(&mut local) {
                if number == CONSTRAINED {
                    *x = 0.0;
                }
            }
            field[v] = self.to_global(v, local);
        }
    }
}

/// Directors of a rigid body, as columns.
fn directors(triad: &[u32; 3], value: impl Fn(usize) -> Vec3) -> Mat3 {
    Mat3::from_columns(&triad.map(|v| value(v as usize)))
}
