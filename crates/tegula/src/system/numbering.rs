//! Nodal vectors, their supports, and the numbers of the free degrees of freedom.

use std::collections::{BTreeMap, BTreeSet};

use crate::element::Nodal;
pub use crate::element::VectorKind;
#[cfg(doc)]
use crate::load::LoadFactor;
use crate::load::{LoadParameter, TimeFunction};
use crate::{Mat3, Vec3};

/// A prescribed displacement: a value and the amplitude it is multiplied with.
pub type Motion = (f64, Option<usize>);

/// A support: the component of a nodal vector's displacement along `direction` follows a value.
#[derive(Debug, Clone, PartialEq)]
pub struct Support {
    /// Nodal vector.
    pub vector: u32,
    /// Unit direction.
    pub direction: Vec3,
    /// Value times amplitude that the component follows; `None`: fixed.
    pub motion: Option<Motion>,
    /// Key of the model that defines the support.
    pub key: String,
}

/// Conflict: two supports that prescribe different values of one component.
#[derive(Debug, Clone, PartialEq)]
pub struct Conflict {
    /// Nodal vector.
    pub vector: u32,
    /// Direction of the second support.
    pub direction: Vec3,
    /// Keys of both supports.
    pub keys: [String; 2],
}

/// Relative distance of two displacements that differ by round-off only.
const SAME: f64 = 1e-9;

/// Mark of a constrained degree of freedom.
pub const CONSTRAINED: u32 = u32::MAX;

/// Constrained degrees of freedom, and numbers of the free ones.
///
/// Each nodal vector has three degrees of freedom along its axes: the global ones, or a local frame where a support is
/// inclined. Constrained degrees of freedom are eliminated; the free ones are numbered consecutively.
#[derive(Debug, Clone)]
pub struct Numbering {
    /// Number of the free degree of freedom `3 v + c`, or [`CONSTRAINED`].
    pub free: Vec<u32>,
    /// Local frames (axes as columns) of the vectors that have one; empty if none has.
    frames: Vec<Option<Mat3>>,
    /// Prescribed degrees of freedom.
    pub prescribed: Vec<Prescribed>,
    /// Number of free degrees of freedom.
    pub unknowns: usize,
    /// Inextensible directors: their local frames rotate with them, the last axis along the vector.
    pub unit: Vec<UnitVector>,
}

/// Prescribed degree of freedom: its displacement follows a value times an amplitude, or stays where it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prescribed {
    /// Degree of freedom `3 v + c`, along the local axis c of the nodal vector v.
    pub dof: u32,
    /// Displacement at amplitude 1.
    pub value: f64,
    /// Index of the amplitude.
    pub amplitude: Option<usize>,
    /// Displacement at the start of the analysis step.
    pub start: f64,
    /// Whether the degree of freedom is fixed: it stays at `start`.
    pub held: bool,
}

impl Prescribed {
    /// Nodal vector and component.
    pub fn place(&self) -> (usize, usize) {
        (self.dof as usize / 3, self.dof as usize % 3)
    }

    /// Displacement at a time or load factor; see [`LoadFactor::value`] for load factors below 0.
    pub fn displacement(&self, amplitudes: &[TimeFunction], parameter: LoadParameter, at: f64) -> f64 {
        let Self { value, amplitude, start, held, .. } = *self;
        match (amplitude, parameter) {
            _ if held => start,
            (Some(i), LoadParameter::LoadFactor) if at < 0.0 => {
                start + (1.0 + at) * (value * amplitudes[i].value(0.0) - start)
            }
            (Some(i), _) => value * amplitudes[i].value(at),
            (None, LoadParameter::LoadFactor) => start + f64::max(at, 0.0) * (value - start),
            (None, LoadParameter::Time) => value,
        }
    }

    /// Whether an amplitude begins elsewhere than the degree of freedom is at the start of the step.
    pub fn jumps(&self, amplitudes: &[TimeFunction]) -> bool {
        let Some(amplitude) = self.amplitude.and_then(|i| amplitudes.get(i)) else { return false };
        let first = self.value * amplitude.value(0.0);
        (first - self.start).abs() > SAME * f64::max(first.abs(), self.start.abs())
    }
}

/// Inextensible director: a nodal vector of constant length.
#[derive(Debug, Clone, PartialEq)]
pub struct UnitVector {
    /// Nodal vector.
    pub vector: u32,
    /// Direction along which the director is supported, if there is one.
    pub fixed: Option<Vec3>,
    /// Component along `fixed` to which the director is constrained; `None`: that of the reference.
    pub held: Option<f64>,
}

impl UnitVector {
    /// Local frame of the director at its present value `d`: two axes along which it may change (one, if it is
    /// supported), and the remaining ones.
    fn axes(&self, d: &Vec3) -> Mat3 {
        let d = d.normalize();
        match self.fixed {
            None => {
                let [a, b] = crate::element::geometry::tangents(&d);
                Mat3::from_columns(&[a, b, d])
            }
            Some(fixed) => {
                let free = fixed.cross(&d).normalize();
                Mat3::from_columns(&[free, fixed, free.cross(&fixed)])
            }
        }
    }

    /// Projection onto the constraint: unit vector nearest to `d` (with the supported component of `reference`).
    pub fn project(&self, d: Vec3, reference: &Vec3) -> Vec3 {
        let Some(a) = self.fixed else { return d.normalize() };
        let along = self.held.unwrap_or_else(|| a.dot(reference));
        let across = d - a * a.dot(&d);
        a * along + across.normalize() * (1.0 - along * along).max(0.0).sqrt()
    }
}

impl Numbering {
    /// Numbers the degrees of freedom of `vectors` nodal vectors under the given supports; those of `unit` are
    /// inextensible unless they are fully constrained.
    ///
    /// # Errors
    /// Supports that prescribe the same component differently.
    pub fn new(
        vectors: usize,
        supports: &[Support],
        unit: &BTreeSet<u32>,
        reference: &[Nodal],
    ) -> Result<Self, Vec<Conflict>> {
        let mut by_vector: Vec<Vec<&Support>> = vec![Vec::new(); vectors];
        for s in supports {
            by_vector[s.vector as usize].push(s);
        }
        let mut out = Builder {
            numbering: Self {
                free: vec![CONSTRAINED; 3 * vectors],
                frames: vec![None; vectors],
                prescribed: Vec::new(),
                unknowns: 0,
                unit: Vec::new(),
            },
            conflicts: Vec::new(),
        };
        for (v, list) in by_vector.iter().enumerate() {
            let axes = out.independent(v, list);
            if unit.contains(&(v as u32)) && axes.len() < 3 {
                out.inextensible(v, &Vec3::from(reference[v]).normalize(), axes);
            } else {
                out.supported(v, &axes);
            }
        }
        let Builder { mut numbering, conflicts } = out;
        if !conflicts.is_empty() {
            return Err(conflicts);
        }
        if numbering.frames.iter().all(Option::is_none) {
            numbering.frames = Vec::new();
        }
        Ok(numbering)
    }

    /// Starts an analysis step at the displacements `u`: prescribed degrees of freedom continue from there, and fixed ones
    /// stay there.
    pub fn start_at(&mut self, reference: &[Nodal], u: &[Nodal]) {
        let current = |v: usize| Vec3::from(reference[v]) + Vec3::from(u[v]);
        self.follow(current);
        let mut held: BTreeMap<u32, Prescribed> = BTreeMap::new();
        for (v, value) in u.iter().enumerate() {
            let local = self.to_axes(v, *value);
            for (c, start) in local.into_iter().enumerate().filter(|(_, x)| *x != 0.0) {
                let dof = (3 * v + c) as u32;
                if self.free[dof as usize] == CONSTRAINED {
                    held.insert(dof, Prescribed { dof, value: 0.0, amplitude: None, start, held: true });
                }
            }
        }
        for unit in &mut self.unit {
            let v = unit.vector;
            held.retain(|dof, _| dof / 3 != v);
            unit.held = unit.fixed.map(|axis| axis.dot(&current(v as usize)));
        }
        for prescribed in &mut self.prescribed {
            prescribed.start = held.remove(&prescribed.dof).map_or(0.0, |h| h.start);
        }
        self.prescribed.extend(held.into_values());
    }

    /// Rotates the local frames of inextensible directors to their present values.
    pub fn follow(&mut self, value: impl Fn(usize) -> Vec3) {
        for unit in &self.unit {
            self.frames[unit.vector as usize] = Some(unit.axes(&value(unit.vector as usize)));
        }
    }

    /// Copies the local frames of the vectors from another state.
    pub fn copy_axes(&mut self, other: &Self) {
        if !self.unit.is_empty() {
            self.frames.copy_from_slice(&other.frames);
        }
    }

    /// Numbers of the three degrees of freedom of a vector.
    pub fn of(&self, vector: usize) -> [u32; 3] {
        [self.free[3 * vector], self.free[3 * vector + 1], self.free[3 * vector + 2]]
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
    pub fn to_axes(&self, vector: usize, value: Nodal) -> Nodal {
        match self.frame(vector) {
            None => value,
            Some(q) => (q.transpose() * Vec3::from(value)).into(),
        }
    }

    /// Global components from those in the local frame of a vector.
    pub fn from_axes(&self, vector: usize, value: Nodal) -> Nodal {
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

    /// Free degrees of freedom of a field.
    pub fn reduce(&self, field: &[Nodal], free: &mut [f64]) {
        for (v, value) in field.iter().enumerate() {
            let local = self.to_axes(v, *value);
            for (number, x) in self.of(v).into_iter().zip(local) {
                if number != CONSTRAINED {
                    free[number as usize] = x;
                }
            }
        }
    }

    /// Field of given free degrees of freedom, zero where constrained.
    pub fn expand(&self, free: &[f64], field: &mut [Nodal]) {
        for (v, value) in field.iter_mut().enumerate() {
            let local = self.of(v).map(|n| if n == CONSTRAINED { 0.0 } else { free[n as usize] });
            *value = self.from_axes(v, local);
        }
    }

    /// Part of a field along constrained degrees of freedom (reactions of a residual).
    pub fn supported_part(&self, field: &[Nodal], out: &mut [Nodal]) {
        for (v, (value, out)) in field.iter().zip(out).enumerate() {
            let mut local = self.to_axes(v, *value);
            for (number, x) in self.of(v).into_iter().zip(&mut local) {
                if number != CONSTRAINED {
                    *x = 0.0;
                }
            }
            *out = self.from_axes(v, local);
        }
    }

    /// Removes from inextensible directors the part of a field along constrained degrees of freedom.
    pub fn free_part(&self, field: &mut [Nodal]) {
        for unit in &self.unit {
            let v = unit.vector as usize;
            let mut local = self.to_axes(v, field[v]);
            for (number, x) in self.of(v).into_iter().zip(&mut local) {
                if number == CONSTRAINED {
                    *x = 0.0;
                }
            }
            field[v] = self.from_axes(v, local);
        }
    }

    /// True if a vector has at least one free degree of freedom.
    pub fn is_free(&self, vector: usize) -> bool {
        self.of(vector).iter().any(|&n| n != CONSTRAINED)
    }
}

/// Numbering in the making, and the supports that contradict each other.
struct Builder {
    numbering: Numbering,
    conflicts: Vec<Conflict>,
}

impl Builder {
    fn clash(&mut self, v: usize, first: &Support, second: &Support) {
        let keys = [first.key.clone(), second.key.clone()];
        self.conflicts.push(Conflict { vector: v as u32, direction: second.direction, keys });
    }

    /// Orthonormal directions of the independent supports of a vector (Gram–Schmidt), each with its support.
    fn independent<'s>(&mut self, v: usize, list: &[&'s Support]) -> Vec<(Vec3, &'s Support)> {
        let mut axes: Vec<(Vec3, &Support)> = Vec::new();
        for &s in list {
            let rest = axes.iter().fold(s.direction, |d, (a, _)| d - a * a.dot(&s.direction));
            if rest.norm() > 1e-9 {
                if rest.norm() < 1.0 - 1e-9 && s.motion.is_some() {
                    // Its value would have to be reduced by the part along the earlier supports.
                    self.clash(v, axes[0].1, s);
                }
                axes.push((rest.normalize(), s));
            } else if let Some((_, other)) = axes.iter().find(|(a, _)| a.dot(&s.direction).abs() > 0.5)
                && other.motion != s.motion
            {
                self.clash(v, other, s);
            }
        }
        axes
    }

    /// Numbers the degrees of freedom of an inextensible director `d`: tangents of the sphere that no support holds.
    fn inextensible(&mut self, v: usize, d: &Vec3, mut axes: Vec<(Vec3, &Support)>) {
        if let Some((_, s)) = axes.iter().find(|(_, s)| s.motion.is_some()) {
            self.clash(v, s, s);
        }
        // A support along the director is redundant: its length is constant anyway.
        axes.retain(|(a, _)| a.dot(d).abs() < 1.0 - 1e-9);
        if axes.len() < 2 {
            let director = UnitVector { vector: v as u32, fixed: axes.first().map(|(a, _)| *a), held: None };
            self.numbering.frames[v] = Some(director.axes(d));
            (0..2 - axes.len()).for_each(|c| self.number(3 * v + c));
            self.numbering.unit.push(director);
        }
    }

    /// Numbers the free degrees of freedom of a vector with supports along `axes`, in a local frame where these are not
    /// parallel to the global axes.
    fn supported(&mut self, v: usize, axes: &[(Vec3, &Support)]) {
        let along_axis = |a: &Vec3| (0..3).find(|&c| a[c].abs() > 1.0 - 1e-12);
        let mut supported: [Option<Option<Motion>>; 3] = [None; 3];
        if axes.iter().all(|(a, _)| along_axis(a).is_some()) {
            for (a, s) in axes {
                if let Some(c) = along_axis(a) {
                    supported[c] =
                        Some(s.motion.map(|(value, amplitude)| (value * a[c].signum(), amplitude)));
                }
            }
        } else {
            let mut columns: Vec<Vec3> = axes.iter().map(|(a, _)| *a).collect();
            for e in [Vec3::x(), Vec3::y(), Vec3::z()] {
                let rest = columns.iter().fold(e, |d, a| d - a * a.dot(&e));
                if columns.len() < 3 && rest.norm() > 0.5 {
                    columns.push(rest.normalize());
                }
            }
            self.numbering.frames[v] = Some(Mat3::from_columns(&columns));
            for (c, (_, s)) in axes.iter().enumerate() {
                supported[c] = Some(s.motion);
            }
        }
        for (c, support) in supported.into_iter().enumerate() {
            match support {
                None => self.number(3 * v + c),
                Some(Some((value, amplitude))) => {
                    self.numbering.prescribed.push(Prescribed {
                        dof: (3 * v + c) as u32,
                        value,
                        amplitude,
                        start: 0.0,
                        held: false,
                    });
                }
                Some(None) => {}
            }
        }
    }

    /// Gives the next number to a degree of freedom.
    fn number(&mut self, coordinate: usize) {
        self.numbering.free[coordinate] = self.numbering.unknowns as u32;
        self.numbering.unknowns += 1;
    }
}
