//! Volumes that surfaces enclose.

use crate::common::{compile, cylinder, model, plate};
use tegula::analysis::{Silent, dynamics};
use tegula::model::*;
use tegula::result::{sensor_columns, sensor_values};

/// Cone over a plate of 2 × 3 that rises from the height 1 with the velocity 0.5: a third of area times height. A quarter of a pipe about
/// its axis, whose facets lie inside: the error falls with the square of their size.
#[test]
fn volumes_are_those_of_cones_and_pipes() {
    let volumes = |mesh: MeshSource, tip: [f64; 3], velocity: [f64; 3]| {
        let mut m = model(mesh, 1e7, 0.01);
        m.conditions.clear();
        m.analysis =
            Analysis::Transient(TransientAnalysis { time_step: Some(0.05), ..TransientAnalysis::new(0.1) });
        m.initial_velocities = vec![InitialVelocity {
            on: "all".into(),
            velocity,
            angular_velocity: [0.0; 3],
            center: [0.0; 3],
        }];
        m.sensors = vec![Sensor::Volume(VolumeSensor { name: "inside".into(), on: "all".into(), tip })];
        let (_, system) = compile(&m);
        assert_eq!(sensor_columns(&system), ["sensor.inside.volume", "sensor.inside.rate"]);
        let Analysis::Transient(options) = &m.analysis else { unreachable!() };
        let state = dynamics::run(&system, options, None, &mut Silent).unwrap().state;
        sensor_values(&system, &state)
    };
    let flat = |z: f64| {
        let MeshSource::Plate(plate) = plate([2.0, 3.0], [4, 5], 0.3) else { unreachable!() };
        MeshSource::Plate(PlateMesh { origin: [0.0, 0.0, z], ..plate })
    };
    let found = volumes(flat(1.0), [0.3, 0.1, 0.0], [0.0, 0.0, 0.5]);
    assert!((found[0] - 2.0 * 1.05).abs() < 1e-10 && (found[1] - 1.0).abs() < 1e-10, "{found:?}");
    // The director points up: below the tip the volume is negative.
    let found = volumes(flat(-1.0), [0.0; 3], [0.0; 3]);
    assert!((found[0] + 2.0).abs() < 1e-10 && found[1].abs() < 1e-10, "{found:?}");
    // A quarter of a pipe of radius 2 and length 3 with the tip on its axis: two thirds of its volume.
    let pipe = |n: u32| volumes(cylinder(2.0, [0.0, 90.0], 3.0, [n, 2]), [0.0, 1.0, 0.0], [0.0; 3])[0];
    let exact = 2.0 * std::f64::consts::PI;
    let errors = [8, 16].map(|n| (pipe(n) / exact - 1.0).abs());
    assert!((errors[0] / errors[1] - 4.0).abs() < 0.05 && errors[1] < 2e-3, "{errors:?}");
}

#[test]
fn volumes_over_unknown_sets_are_refused() {
    let mut m = model(plate([2.0, 3.0], [4, 5], 0.0), 1e7, 0.01);
    let volume = VolumeSensor { name: "inside".into(), on: "nowhere".into(), tip: [0.0; 3] };
    m.sensors = vec![Sensor::Volume(volume)];
    m.loads = vec![Load::Pressure(PressureLoad {
        on: "all".into(),
        value: 1.0,
        amplitude: None,
        distribution: None,
    })];
    let mesh = tegula::mesh::generators::generate(&m.mesh).unwrap();
    let error = tegula::compile::build(&m, &mesh).err().unwrap().to_string();
    assert!(error.contains("sensors[0].on: there is no set of elements \"nowhere\""), "{error}");
}
