//! Examples of structures at rest: closed formulas of books for a tube, a ribbed strip and a tank.

use std::f64::consts::{PI, TAU};

use super::machines::history_of;
use super::result_of;

/// R. Bredt's formula for closed thin sections, of the circle and of the polygon of the mesh; the torque goes through the coupling.
#[test]
fn a_torque_turns_the_end_of_the_tube_as_a_thin_closed_section() {
    let column = history_of("tube_torque.toml");
    let last = |name: &str| *column(name).last().unwrap();
    let (radius, thickness, length, corners) = (0.05_f64, 0.002, 0.5, 32.0);
    let area = 0.5 * corners * radius * radius * (TAU / corners).sin();
    let perimeter = 2.0 * corners * radius * (PI / corners).sin();
    let twist = |area: f64, perimeter: f64| {
        let constant = 4.0 * area * area * thickness / perimeter;
        (1000.0 * length / (2.1e11 / 2.6 * constant)).to_degrees()
    };
    let [circle, polygon] = [twist(PI * radius * radius, TAU * radius), twist(area, perimeter)];
    let found = last("sensor.twist.angle");
    assert!(found > circle * 0.99 && found < polygon * 1.01, "{circle} {found} {polygon}");
    assert!((last("joint.flange.mz") / 1000.0 - 1.0).abs() < 1e-9);
    assert!(last("balance.moment") < 1e-9);
}

/// Deflection and strain on the upper face of the cantilever with the T-section of strip and rib.
#[test]
fn the_ribbed_strip_bends_as_the_cantilever_with_a_t_section() {
    let column = history_of("ribbed_strip.toml");
    let last = |name: &str| *column(name).last().unwrap();
    let (strip, rib, eccentricity) = (1e-3, 1.5e-4, -0.02);
    let centre = eccentricity * rib / (strip + rib);
    let own = 0.1 * 0.01_f64.powi(3) / 12.0 + 0.005 * 0.03_f64.powi(3) / 12.0;
    let second: f64 = own + strip * centre * centre + rib * (eccentricity - centre) * (eccentricity - centre);
    let bending = 2.1e11 * second;
    let deflection = 100.0 / (3.0 * bending);
    assert!((-last("end.uz") / deflection - 1.0).abs() < 3e-3, "{} {deflection}", last("end.uz"));
    let strain = 100.0 * 0.75 * (0.005 - centre) / bending;
    assert!((last("sensor.gauge.strain") / strain - 1.0).abs() < 1e-3, "{strain}");
}

/// Moment and shear force at the bottom of the tank after Timoshenko and Woinowsky-Krieger, over the chord of the sector.
#[test]
fn the_wall_of_the_water_tank_has_the_clamping_moment_of_the_book() {
    let s = result_of("water_tank.toml");
    let support = |name: &str, axis: usize| s["supports"]["bottom"][name][axis].as_f64().unwrap();
    let chord = 2.0 * 9.144 * 5.0_f64.to_radians().sin();
    // Pound-force in newtons; inches in metres.
    let (pound, inch) = (4.448_222, 0.0254);
    let (moment, force) = (13_960.0 * pound, 563.6 * pound / inch);
    // The support holds the foot of the wall inwards and bends it inwards about −y.
    let [found_moment, found_force] = [-support("moment", 1) / chord, -support("force", 0) / chord];
    assert!((found_moment / moment - 1.0).abs() < 2e-3, "{found_moment} for {moment}");
    assert!((found_force / force - 1.0).abs() < 2e-3, "{found_force} for {force}");
}
