//! Points and axes of bodies, nodes and the ground, as linear combinations of nodal vectors.

use crate::Vec3;

/// A point or an axis fixed in a body, in the ground or at a node: `Σ w_k v_k + c` with nodal vectors v.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Attachment {
    /// Nodal vectors with their weights.
    pub terms: Vec<(u32, f64)>,
    /// Constant part: the point itself, or the axis, in the ground.
    pub constant: Vec3,
}

impl Attachment {
    /// Point or axis of the ground.
    pub fn ground(value: Vec3) -> Self {
        Self { terms: Vec::new(), constant: value }
    }

    /// A nodal vector: position or director of a node.
    pub fn vector(vector: u32) -> Self {
        Self { terms: vec![(vector, 1.0)], constant: Vec3::zeros() }
    }

    /// Axis of a body with the directors d, whose components along them are `along`.
    pub fn axis(directors: [u32; 3], along: &Vec3) -> Self {
        let terms = (0..3).filter(|&i| along[i] != 0.0).map(|i| (directors[i], along[i])).collect();
        Self { terms, constant: Vec3::zeros() }
    }

    /// Point or axis, for given nodal vectors.
    pub fn value(&self, vector: impl Fn(u32) -> Vec3) -> Vec3 {
        self.terms.iter().fold(self.constant, |x, &(v, weight)| x + vector(v) * weight)
    }

    /// Rate of the point or axis, for given rates of the nodal vectors.
    pub fn rate(&self, vector: impl Fn(u32) -> Vec3) -> Vec3 {
        self.terms.iter().fold(Vec3::zeros(), |x, &(v, weight)| x + vector(v) * weight)
    }

    /// Point of a body with the mass centre r and the directors d: `r + X_i d_i`.
    pub fn point(centre: u32, directors: [u32; 3], along: &Vec3) -> Self {
        let mut out = Self::axis(directors, along);
        out.terms.insert(0, (centre, 1.0));
        out
    }
}
