//! Values of sensors in a state.

use super::joints::joint_reaction;
use crate::Vec3;
use crate::analysis::State;
use crate::constraint::joints::RelativeAngle;
use crate::constraint::{Attachment, Measure};
use crate::element::Nodal;
use crate::system::System;

/// Columns of all sensors: `sensor.NAME.…`. Rates, velocities and accelerations are those of transient analyses.
pub fn sensor_columns(system: &System) -> Vec<String> {
    let moves = system.moves();
    let mut out = Vec::new();
    for sensor in system.sensors.iter() {
        let (columns, rates): (&[&str], &[&str]) = match &sensor.measure {
            Measure::Distance(_) => (&["distance"], &["rate"]),
            Measure::Angle(_) => (&["angle"], &["rate"]),
            Measure::Point(_) => (&["x", "y", "z"], &["vx", "vy", "vz", "ax", "ay", "az"]),
            Measure::Reaction(_) => (&["force", "moment"], &[]),
            Measure::Volume(_) => (&["volume"], &["rate"]),
            Measure::Strain(_) => (&["strain"], &["rate"]),
        };
        let rates = if moves { rates } else { &[] };
        out.extend(columns.iter().chain(rates).map(|column| format!("sensor.{}.{column}", sensor.name)));
    }
    out
}

/// Values of all sensors in a state, in the order of [`sensor_columns`]: lengths, angles in degrees, and their rates; accelerations
/// are those of the state, for the energy–momentum scheme of second order the means over the last step.
pub fn sensor_values(system: &System, state: &State) -> Vec<f64> {
    let moves = system.moves();
    let mut out = Vec::new();
    let mut angles = state.angles.iter();
    let at = |v: u32| Vec3::from(system.coordinates.reference[v as usize]) + vector(&state.u, v);
    for sensor in system.sensors.iter() {
        match &sensor.measure {
            Measure::Distance(points) => {
                let [distance, rate] = distance(points, at, |v| vector(&state.v, v));
                out.push(distance);
                out.extend(moves.then_some(rate));
            }
            Measure::Angle(angle) => {
                // An angle that the state does not hold must not look like one.
                let earlier = angles.next().copied().unwrap_or(f64::NAN);
                out.push(system.continued_angle(angle, earlier, |v| state.u[v]).to_degrees());
                out.extend(moves.then(|| rate(angle, at, &state.v).to_degrees()));
            }
            Measure::Point(point) => {
                out.extend(point.value(at).iter());
                for rates in [&state.v, &state.a].into_iter().filter(|_| moves) {
                    out.extend(point.rate(|v| vector(rates, v)).iter());
                }
            }
            Measure::Reaction(joint) => {
                let (force, moment) = joint_reaction(system, state, &system.joints[*joint]);
                out.extend([force.norm(), moment.norm()]);
            }
            Measure::Volume(cone) => {
                let [volume, rate] = cone.value_and_rate(at, |v| vector(&state.v, v));
                out.push(volume);
                out.extend(moves.then_some(rate));
            }
            Measure::Strain(gauges) => {
                let values = gauges
                    .iter()
                    .map(|gauge| gauge.value_and_rate(system.linear, at, |v| vector(&state.v, v)));
                let sums = values.fold([0.0; 2], |sum, value| [sum[0] + value[0], sum[1] + value[1]]);
                let [strain, rate] = sums.map(|sum| sum / gauges.len() as f64);
                out.push(strain);
                out.extend(moves.then_some(rate));
            }
        }
    }
    out
}

fn vector(field: &[Nodal], v: u32) -> Vec3 {
    field.get(v as usize).copied().map_or_else(Vec3::zeros, Vec3::from)
}

/// Distance of two points and its rate. Points that meet depart at their relative speed.
fn distance([a, b]: &[Attachment; 2], at: impl Fn(u32) -> Vec3, velocity: impl Fn(u32) -> Vec3) -> [f64; 2] {
    let way = b.value(&at) - a.value(&at);
    let speed = b.rate(&velocity) - a.rate(&velocity);
    let distance = way.norm();
    [distance, if distance == 0.0 { speed.norm() } else { way.dot(&speed) / distance }]
}

fn rate(angle: &RelativeAngle, at: impl Fn(u32) -> Vec3, velocities: &[Nodal]) -> f64 {
    let vectors: Vec<Vec3> = angle.vectors.iter().map(|&v| at(v)).collect();
    let rates: Vec<Vec3> = angle.vectors.iter().map(|&v| vector(velocities, v)).collect();
    angle.rate(&vectors, &rates)
}
