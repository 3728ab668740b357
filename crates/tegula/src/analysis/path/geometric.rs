//! Geometric series next to a bifurcation.
//!
//! Beside a simple bifurcation at the distance a_b round-off along the critical mode φ is multiplied by 1/a_b from order to order, and
//! the last coefficients become those of a geometric series, `v_p → c φ / a_bᵖ`: they tell the place of the bifurcation and its mode, but
//! also end the range of the series there. Without them the series is that of the path that goes through the bifurcation.
//!
//! B. Cochelin, M. Medale, *Power series analysis as a major breakthrough to improve the efficiency of asymptotic numerical method in
//! the vicinity of bifurcations*, J. Comput. Phys. 236 (2013) 594–607.

use super::expansion::range;
use super::series::Series;
use crate::system::System;

/// Motion along the critical mode over the displacements that is round-off. The response to a real imperfection is larger, and belongs
/// to the path.
const ROUND_OFF: f64 = 1e-8;

/// Departure of the last two coefficients, and of those three orders apart, from a geometric series.
const COLLINEAR: [f64; 2] = [1e-4, 1e-2];

/// Takes a geometric series out of the coefficients of a path. `None` where the coefficients end with no geometric series: the series is
/// left as it is.
pub fn extract(system: &System, series: &mut Series, tolerance: f64) -> Option<()> {
    let orders = series.coefficients.len();
    let [.., third, _, before, last] = series.coefficients.as_slice() else { return None };
    let square = system.inner_product(last, last);
    let distance = system.inner_product(before, last) / square;
    let departs = |other: &[crate::element::Nodal], factor: f64| {
        let (mixed, own) = (system.inner_product(other, last), system.inner_product(other, other));
        ((factor * factor * square - 2.0 * factor * mixed + own) / own).max(0.0).sqrt()
    };
    let geometric =
        departs(before, distance) <= COLLINEAR[0] && departs(third, distance.powi(3)) <= COLLINEAR[1];
    if !(geometric && distance.is_finite() && distance != 0.0) {
        return None;
    }
    let amplitude = square.sqrt() * distance.abs().powi(orders as i32);
    if !(amplitude <= ROUND_OFF * (system.norm(&series.u) + series.range)) {
        return None;
    }
    let mut clean = series.clone();
    let (last, load) = (clean.coefficients.pop()?, clean.loads.pop()?);
    for (p, coefficient) in clean.coefficients.iter_mut().enumerate() {
        let factor = distance.powi((orders - p - 1) as i32);
        for (x, y) in coefficient.as_flattened_mut().iter_mut().zip(last.as_flattened()) {
            *x -= factor * y;
        }
    }
    for (p, x) in clean.loads.iter_mut().enumerate().skip(1) {
        *x -= distance.powi((orders - p) as i32) * load;
    }
    clean.range = range(system, &clean, tolerance)?;
    if clean.range <= series.range {
        return None;
    }
    *series = clean;
    Some(())
}
