//! Relative coordinates of joints with friction or stops, their laws from the keys of the model file, and the checks of these keys.

use std::ops::Range;

use super::{Constraints, Lack, forms_of_angle};
use crate::checker::Checker;
use crate::constraint::{CoordinateLaw, Quantity, Row};
use crate::model::{CoordinateJoint, JointFriction, JointKeys, JointStops};

/// Relative coordinate of a joint.
pub(crate) struct Coordinate {
    /// Angle about the axis, or else displacement along it.
    pub is_angle: bool,
    /// Direction of the axis.
    pub axis: [f64; 3],
    /// Point of the joint.
    pub at: [f64; 3],
    /// Constraints of the joint whose multipliers are the components of its reaction force.
    pub normals: Range<usize>,
}

impl Constraints {
    /// Constraint of a coordinate: its value less that at which it is held.
    fn coordinate(&mut self, of: &Coordinate) -> Option<Row> {
        let own = self.rows.len();
        if of.is_angle {
            let Some([mut sine, cosine]) =
                forms_of_angle((&self.ends, &self.second), &of.axis.into(), &mut self.vectors)
            else {
                self.lacks(Lack::Triad);
                return None;
            };
            sine.measure_angle(cosine);
            sine.keeps = Quantity::Axes;
            self.push(sine, 1.0, 0.0);
        } else {
            self.driven_length(&of.axis.into(), of.at);
        }
        let mut row = self.rows.pop().filter(|_| self.rows.len() == own)?;
        // Friction is a force: the augmented Lagrangian must not hold the coordinate.
        (row.inertia, row.measure) = (0.0, 0.0);
        Some(row)
    }

    /// Law of the coordinate of a joint with friction or stops.
    pub(super) fn law(&mut self, keys: &dyn JointKeys, of: &Coordinate) -> Option<CoordinateLaw> {
        if keys.friction().is_none() && keys.stops().is_none() {
            return None;
        }
        let row = self.coordinate(of)?;
        let friction = keys.friction().copied().unwrap_or_default();
        let arm = if of.is_angle { friction.radius.unwrap_or(0.0) } else { 1.0 };
        let sticking = friction.static_coefficient.unwrap_or(friction.coefficient);
        let stops = keys.stops().copied().unwrap_or_default();
        let unit = if of.is_angle { 1f64.to_radians() } else { 1.0 };
        let stop = |value: Option<f64>, none: f64| value.map_or(none, |value| value * unit);
        Some(CoordinateLaw {
            row,
            is_angle: of.is_angle,
            coefficients: [friction.coefficient * arm, sticking * arm],
            preload: friction.preload,
            stops: [stop(stops.lower, f64::NEG_INFINITY), stop(stops.upper, f64::INFINITY)],
            restitution: stops.restitution,
            normals: of.normals.clone(),
            acts: false,
            axis: if of.is_angle { self.ends[0].axis(&of.axis.into()) } else { None },
        })
    }
}

/// Mistakes in the friction and the stops of a joint.
pub(crate) fn check_law(keys: &CoordinateJoint, is_angle: bool, key: &str, c: &mut Checker) {
    if let Some(friction) = &keys.friction {
        check_friction(friction, (&keys.name, is_angle), &format!("{key}.friction"), c);
    }
    if let Some(stops) = &keys.stops {
        check_stops(stops, &keys.name, &format!("{key}.stops"), c);
    }
}

fn check_friction(friction: &JointFriction, (name, is_angle): (&str, bool), key: &str, c: &mut Checker) {
    c.not_negative(&format!("{key}.coefficient"), "the coefficient of friction", friction.coefficient);
    c.not_negative(&format!("{key}.preload"), "the constant friction", friction.preload);
    if let Some(sticking) = friction.static_coefficient {
        let place = format!("{key}.static_coefficient");
        c.not_negative(&place, "the coefficient of static friction", sticking);
        if sticking < friction.coefficient {
            c.add(
                place,
                format!(
                    "the coefficient of static friction of the joint \"{name}\" is {sticking}, below that of sliding friction, {}",
                    friction.coefficient
                ),
                "give at least `coefficient`, or leave the key out",
            );
        }
    }
    if let Some(radius) = friction.radius {
        c.positive(&format!("{key}.radius"), "the radius of the bearing", radius);
    }
    let has_coefficient = friction.coefficient != 0.0 || friction.static_coefficient.is_some();
    match (is_angle, friction.radius) {
        (true, None) if has_coefficient => c.add(
            key,
            format!("the friction torque of the revolute joint \"{name}\" needs the radius of its bearing"),
            "give `radius`, or only `preload`, a constant torque",
        ),
        (false, Some(_)) => c.add(
            format!("{key}.radius"),
            format!("the prismatic joint \"{name}\" has no bearing radius"),
            "leave `radius` out: the friction force is μ |N|",
        ),
        _ => {}
    }
    if !has_coefficient && friction.preload == 0.0 {
        c.add(key, format!("the joint \"{name}\" has no friction"), "give `coefficient` or `preload`");
    }
}

fn check_stops(stops: &JointStops, name: &str, key: &str, c: &mut Checker) {
    let given: Vec<f64> = stops.lower.iter().chain(&stops.upper).copied().collect();
    c.finite(key, "the stop", &given);
    if given.is_empty() {
        c.add(key, format!("the joint \"{name}\" has no stop"), "give `lower`, `upper` or both");
    }
    if let (Some(lower), Some(upper)) = (stops.lower, stops.upper)
        && !(lower < upper)
    {
        let message =
            format!("the lower stop {lower} of the joint \"{name}\" is not below the upper one, {upper}");
        c.add(key, message, "exchange the two; a joint that does not move is of the type \"fixed\"");
    }
    if !(0.0..=1.0).contains(&stops.restitution) {
        let message = format!("the coefficient of restitution is {}", stops.restitution);
        c.add(format!("{key}.restitution"), message, "give a number from 0, plastic, to 1, without loss");
    }
}
