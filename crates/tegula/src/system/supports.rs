//! Supports and prescribed displacements of nodal vectors, and the degree-of-freedom map that results from them.

use std::collections::BTreeSet;

use super::Attached;
use super::dof_map::{CONSTRAINED, DofMap, Prescribed, UnitVector};
use crate::element::Nodal;
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

/// Numbers the degrees of freedom of the nodal vectors `reference` under the given supports; those of `unit` are
/// inextensible unless they are fully constrained, those of each triad are the directors of a rigid body, and those that
/// are `attached` follow one. Returns the local frames of the vectors, none if no vector has one.
///
/// # Errors
/// Supports that prescribe the same component differently.
pub(super) fn constrain(
    supports: &[Support],
    unit: &BTreeSet<u32>,
    (triads, attached): (&[[u32; 3]], &[Attached]),
    reference: &[Nodal],
) -> Result<(DofMap, Vec<Option<Mat3>>), Vec<Conflict>> {
    let vectors = reference.len();
    let mut by_vector: Vec<Vec<&Support>> = vec![Vec::new(); vectors];
    for s in supports {
        by_vector[s.vector as usize].push(s);
    }
    let dofs = DofMap {
        free: vec![CONSTRAINED; 3 * vectors],
        prescribed: Vec::new(),
        unknowns: 0,
        unit: Vec::new(),
        triads: triads.to_vec(),
        attached: attached.to_vec(),
    };
    let mut out = Builder { dofs, frames: vec![None; vectors], conflicts: Vec::new() };
    for (v, list) in by_vector.iter().enumerate() {
        if out.dofs.in_triad(v) {
            if triads.iter().any(|triad| triad[0] as usize == v) {
                (0..3).for_each(|c| out.number(3 * v + c));
            }
            continue;
        }
        if out.dofs.attachment(v).is_some() {
            continue;
        }
        let axes = out.independent(v, list);
        if unit.contains(&(v as u32)) && axes.len() < 3 {
            out.inextensible(v, &Vec3::from(reference[v]).normalize(), axes);
        } else {
            out.supported(v, &axes);
        }
    }
    let Builder { dofs, mut frames, conflicts } = out;
    if !conflicts.is_empty() {
        return Err(conflicts);
    }
    if frames.iter().all(Option::is_none) {
        frames = Vec::new();
    }
    Ok((dofs, frames))
}

/// Degree-of-freedom map in the making with its local frames, and the supports that contradict each other.
struct Builder {
    dofs: DofMap,
    frames: Vec<Option<Mat3>>,
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
            self.frames[v] = Some(director.axes(d));
            (0..2 - axes.len()).for_each(|c| self.number(3 * v + c));
            self.dofs.unit.push(director);
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
            self.frames[v] = Some(Mat3::from_columns(&columns));
            for (c, (_, s)) in axes.iter().enumerate() {
                supported[c] = Some(s.motion);
            }
        }
        for (c, support) in supported.into_iter().enumerate() {
            match support {
                None => self.number(3 * v + c),
                Some(Some((value, amplitude))) => {
                    self.dofs.prescribed.push(Prescribed {
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
        self.dofs.free[coordinate] = self.dofs.unknowns as u32;
        self.dofs.unknowns += 1;
    }
}
