//! Place of a joint on its second side, where that does not meet the first one in the reference configuration.

/// Point and axis of a joint on its second side, in the reference configuration; those of the first side where there is none.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SecondSide {
    /// Point (length).
    pub at: Option<[f64; 3]>,
    /// Direction of the axis.
    pub axis: Option<[f64; 3]>,
}

impl SecondSide {
    /// Whether a point or an axis is given.
    pub fn is_given(&self) -> bool {
        self.at.is_some() || self.axis.is_some()
    }
}
