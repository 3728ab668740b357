//! Sensors: quantities of the motion of points, bodies and joints.

use super::Attachment;
use super::joints::RelativeAngle;

/// Sensor of the compiled model.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensor {
    /// Name of the sensor in the model.
    pub name: String,
    /// Quantity that it measures.
    pub measure: Measure,
}

/// Quantity that a sensor measures.
#[derive(Debug, Clone, PartialEq)]
pub enum Measure {
    /// Distance of two points.
    Distance([Attachment; 2]),
    /// Angle of the second end relative to the first one. Angles of sensors continue over full turns; the state holds them.
    Angle(RelativeAngle),
    /// Motion of a point.
    Point(Attachment),
    /// Reaction of the joint with this number.
    Reaction(usize),
}

impl Sensor {
    /// Angle that the sensor measures, if it measures one.
    pub fn angle(&self) -> Option<&RelativeAngle> {
        match &self.measure {
            Measure::Angle(angle) => Some(angle),
            Measure::Distance(_) | Measure::Point(_) | Measure::Reaction(_) => None,
        }
    }
}
