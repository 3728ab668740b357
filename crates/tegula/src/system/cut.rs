//! Cuts: the nodal forces of some elements along a line of the mesh.

use super::{Assembly, System};
use crate::Vec3;
use crate::element::Nodal;

/// A cut along a line of the mesh, compiled.
#[derive(Debug, Clone, PartialEq)]
pub struct Cut {
    /// Name of the cut.
    pub name: String,
    /// Point about which the moment is taken; `None`: mean of `positions`.
    pub about: Option<Vec3>,
    /// Nodal vectors of the positions of the line's nodes.
    pub positions: Vec<u32>,
    /// Forces that make up the resultant: the place of each among the element forces of all groups, in units of nodal vectors, and the
    /// nodal vector on which it acts.
    pub forces: Vec<(u32, u32)>,
}

impl System {
    /// Element forces of all cuts, one cut after another, from those of the last evaluation.
    pub fn cut_forces(&self, assembly: &Assembly) -> Vec<Nodal> {
        let places = self.cuts.iter().flat_map(|cut| &cut.forces);
        places.map(|(place, _)| assembly.element_force(*place)).collect()
    }
}
