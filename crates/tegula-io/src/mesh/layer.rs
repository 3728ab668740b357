//! Layer of hexahedra of which a shell is made: pairs of nodes at its bottom and its top, and the directions of the edges between them.

use std::collections::HashMap;

use tegula::Vec3;

/// Cosine of the largest angle between an edge through the thickness and the normal of the middle surface.
const MOST_SKEW: f64 = 0.5;

/// Nodes at the bottom and the top of a layer.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Pairs {
    /// Nodes at the top by those at the bottom.
    pub above: HashMap<u64, u64>,
    /// Nodes at the bottom by those at the top.
    pub below: HashMap<u64, u64>,
}

impl Pairs {
    /// Adds a pair, which may be there already; whether both nodes still belong to one layer and have one partner each.
    pub fn add(&mut self, bottom: u64, top: u64) -> bool {
        let one = self.above.insert(bottom, top).is_none_or(|old| old == top);
        let other = self.below.insert(top, bottom).is_none_or(|old| old == bottom);
        one && other && !self.above.contains_key(&top) && !self.below.contains_key(&bottom)
    }
}

/// Whether an edge through the thickness leans more than 60° from the normal of the middle surface, or one of them has no length.
pub fn leans(through: Vec3, normal: Vec3) -> bool {
    // An undefined angle counts as one that is too large.
    let cosine = through.dot(&normal).abs();
    !(cosine >= MOST_SKEW * through.norm() * normal.norm() && through.norm() > 0.0)
}
