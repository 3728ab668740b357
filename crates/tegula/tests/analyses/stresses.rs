//! Stresses of shells against closed forms: sandwiches, rolled strips, strain-rate damping; faces of laminates with an offset.

use serde_json::json;
use tegula::System;
use tegula::Vec3;
use tegula::analysis::{Silent, State, dynamics, statics};
use tegula::mesh::generators;
use tegula::model::{Analysis, Model};
use tegula::norm::larger;
use tegula::result::{recover, sensor_values};

use crate::common::compile;

/// The system of a model and its last state.
fn run(model: serde_json::Value) -> (System, State) {
    let model: Model = serde_json::from_value(model).unwrap();
    let (_, system) = compile(&model);
    let state = match &model.analysis {
        Analysis::Static(options) => statics::run(&system, options, None, &mut Silent).unwrap().state,
        Analysis::Transient(options) => dynamics::run(&system, options, None, &mut Silent).unwrap().state,
        other => panic!("{other:?}"),
    };
    (system, state)
}

/// A cantilever of aluminium faces on a core of foam under a force at its end: the von Mises stress is that of the fibres of the faces, σ = E z M/D; their
/// transverse shear stress vanishes at the surface, and that of the core is Q/d (H. G. Allen, *Analysis and design of structural sandwich panels*, 1969,
/// Ch. 2). The shear modulus of the faces times the shear strain of the section would be 1.1e8.
#[test]
fn the_von_mises_stress_of_a_sandwich_is_that_of_its_faces() {
    let [young, face, core, force] = [70e9, 1e-3, 20e-3, 1000.0];
    let isotropic = |young: f64| json!({ "type": "isotropic", "young": young, "poisson": 0.0 });
    let ply = |material: &str, thickness: f64| json!({ "material": material, "thickness": thickness });
    let (system, state) = run(json!({
        "analysis": { "type": "static", "linear": true },
        "mesh": { "type": "plate", "size": [1.0, 0.1], "grid": { "elements": [20, 2] } },
        "materials": { "alu": isotropic(young), "foam": isotropic(50e6) },
        "sections": [{ "layup": { "plies": [ply("alu", face), ply("foam", core), ply("alu", face)] } }],
        "conditions": [{ "type": "clamp", "on": "u_min" }],
        "loads": [{ "type": "edge", "on": "u_max", "value": [0.0, 0.0, force] }]
    }));
    let distance = core + face;
    let stiffness = young * (face * distance * distance / 2.0 + face.powi(3) / 6.0);
    for (shell, found) in system.shells.iter().zip(recover(&system, &state)) {
        let at = system.geometry(shell).positions.iter().map(|x| x.x).sum::<f64>() / 4.0;
        let fibre = young * (0.5 * core + face) * force * (1.0 - at) / stiffness;
        assert!((found.von_mises / fibre - 1.0).abs() < 0.01, "{at}: {} {fibre}", found.von_mises);
    }
}

/// A strip that an end moment rolls to a quarter circle: at its end the stress of the fibres is along z. The frame of its components has turned with it.
#[test]
fn the_axes_of_stresses_turn_with_the_surface() {
    let [young, length, h] = [1e9, 10.0, 0.1];
    let curvature = std::f64::consts::FRAC_PI_2 / length;
    let moment = young * h * h * h / 12.0 * curvature;
    let (system, state) = run(json!({
        "analysis": { "type": "static", "load_steps": 10 },
        "mesh": { "type": "plate", "size": [length, 1.0], "grid": { "elements": [40, 2] } },
        "materials": { "m": { "type": "isotropic", "young": young, "poisson": 0.0 } },
        "sections": [{ "material": "m", "thickness": h }],
        "conditions": [{ "type": "clamp", "on": "u_min" }],
        "loads": [{ "type": "edge-moment", "on": "u_max", "value": [0.0, -moment, 0.0] }]
    }));
    let results = recover(&system, &state);
    let [first, last] = [&results[0], &results[39]].map(|r| {
        let ([xx, yy, xy], [x, y, _]) = (r.stress_top, r.current_axes);
        [0, 1, 2].map(|i| xx * x[i] * x[i] + yy * y[i] * y[i] + 2.0 * xy * x[i] * y[i])
    });
    let fibre = 0.5 * young * h * curvature;
    assert!((first[0].abs() / fibre - 1.0).abs() < 0.01 && first[2].abs() < 0.01 * fibre, "{first:?}");
    assert!((last[2].abs() / fibre - 1.0).abs() < 0.01 && last[0].abs() < 0.01 * fibre, "{last:?}");
}

/// A strip with strain-rate damping that is pulled: its force is E h (ε + τ ε̇), in the resultants as in the reactions.
#[test]
fn stresses_have_the_part_of_the_strain_rate() {
    let model = |analysis: serde_json::Value| {
        json!({
            "analysis": analysis,
            "mesh": { "type": "plate", "size": [1.0, 0.1], "grid": { "elements": [8, 1] } },
            "materials": { "m": { "type": "isotropic", "young": 1e9, "poisson": 0.0, "density": 1.0 } },
            "sections": [{ "material": "m", "thickness": 0.01, "retardation_time": 0.05 }],
            "conditions": [
                { "type": "fix", "on": "u_min", "position": ["x", "y", "z"] },
                { "type": "fix", "on": "all", "position": ["y", "z"], "director": ["x", "y", "z"] },
                { "type": "prescribe", "on": "u_max", "component": "x", "value": 1.0, "amplitude": "a" }
            ],
            "amplitudes": { "a": { "type": "expression", "expression": "t*t" } }
        })
    };
    let motion =
        json!({ "type": "transient", "end_time": 0.02, "time_step": 5e-4, "scheme": { "type": "newmark" } });
    let (system, state) = run(model(motion));
    let pulled = |system: &System, rate: f64| {
        for found in recover(system, &state) {
            let exact = 1e9 * 0.01 * (4e-4 + 0.05 * rate);
            assert!((found.membrane[0] / exact - 1.0).abs() < 5e-3, "{} {exact}", found.membrane[0]);
        }
    };
    pulled(&system, 0.04);
    // A static step behind the motion has its velocities, too.
    let (at_rest, _) = run(model(json!({ "type": "static" })));
    pulled(&at_rest, 0.0);
}

/// The faces of a laminate with an offset lie at the heights 0 and 0.1 over the mesh: strain gauges are taken there, and not outside.
#[test]
fn gauges_lie_between_the_faces_of_a_laminate_with_an_offset() {
    let built = |height: f64| {
        let model: Model = serde_json::from_value(json!({
            "analysis": { "type": "static" },
            "mesh": { "type": "plate", "size": [1.0, 1.0], "grid": { "elements": [2, 2] } },
            "materials": { "m": { "type": "isotropic", "young": 1e9, "poisson": 0.3 } },
            "sections": [{ "layup": { "plies": [{ "material": "m", "thickness": 0.1 }], "offset": 0.05 } }],
            "conditions": [{ "type": "clamp", "on": "u_min" }],
            "loads": [{ "type": "edge", "on": "u_max", "value": [1.0, 0.0, 0.0] }],
            "sensors": [{ "type": "strain", "name": "g", "on": "all", "at": [0.6, 0.6, height], "direction": [1, 0, 0] }]
        }))
        .unwrap();
        let mesh = generators::generate(&model.mesh).unwrap();
        tegula::compile::build(&model, &mesh).map(|_| ()).map_err(|error| error.to_string())
    };
    for height in [0.0, 0.05, 0.1] {
        assert_eq!(built(height), Ok(()), "{height}");
    }
    for height in [-0.05, -0.01, 0.11] {
        assert!(built(height).unwrap_err().contains("above or below the shell"), "{height}");
    }
}

/// A sandwich of `cm` is told to be too stiff in transverse shear; with the factors of the warning its deflection is `F L³/3D + F L/S` with S = G d²/c.
#[test]
fn a_sandwich_without_shear_correction_is_warned_of() {
    let [young, face, core, force, length] = [70e9, 1e-3, 20e-3, 1000.0, 0.2];
    let model = |correction: Option<[f64; 2]>| {
        let isotropic = |young: f64| json!({ "type": "isotropic", "young": young, "poisson": 0.0 });
        let ply = |material: &str, thickness: f64| json!({ "material": material, "thickness": thickness });
        let plies = [ply("alu", face), ply("foam", core), ply("alu", face)];
        let mut section = json!({ "layup": { "plies": plies }, "element": "cm" });
        if let Some(factors) = correction {
            section["shear_correction"] = json!(factors);
        }
        json!({
            "analysis": { "type": "static", "linear": true },
            "mesh": { "type": "plate", "size": [length, 0.1], "grid": { "elements": [20, 2] } },
            "materials": { "alu": isotropic(young), "foam": isotropic(50e6) },
            "sections": [section],
            "conditions": [{ "type": "clamp", "on": "u_min" }],
            "loads": [{ "type": "edge", "on": "u_max", "value": [0.0, 0.0, force] }]
        })
    };
    let warnings = |value: serde_json::Value| {
        let model: Model = serde_json::from_value(value).unwrap();
        let (mesh, system) = compile(&model);
        tegula::compile::warnings(&model, &mesh, &system)
    };
    let told = warnings(model(None));
    let told = told.iter().find(|issue| issue.place.key == "sections[0].shear_correction").unwrap();
    let numbers: Vec<f64> =
        told.help.split(['[', ',', ']']).filter_map(|word| word.trim().parse().ok()).collect();
    let factors = [numbers[0], numbers[1]];
    assert!(warnings(model(Some(factors))).is_empty());
    let (system, state) = run(model(Some(factors)));
    let distance = core + face;
    let bending = young * (face * distance * distance / 2.0 + face.powi(3) / 6.0);
    let exact =
        force * length.powi(3) / (3.0 * bending) + force * length / (25e6 * distance * distance / core);
    let lifted = (0..system.vectors()).map(|v| state.u[v][2]).fold(0.0, tegula::norm::larger);
    assert!((lifted / exact - 1.0).abs() < 0.02, "{lifted} {exact} {factors:?}");
}

/// A long tube of the ratio R/h = 10 under internal pressure, in plane strain along its axis without Poisson's effect: the hoop stress E u/r is greater at the
/// inner face. The strain ε − z κ of the elements `ems` has the gradient of the stretch of the curved surface the other way round, by h/R between the
/// faces, and the right mean; strain gauges have the exact one, and so have the elements `cm`.
#[test]
fn the_stress_gradient_in_the_wall_of_a_tube_is_mirrored_and_that_of_gauges_is_not() {
    let [radius, h, young] = [1.0, 0.1, 1e9];
    let edge = |on: &str, position: [&str; 2], director: &str| json!({ "type": "fix", "on": on, "position": position, "director": [director, position[1]] });
    let gauge = |name: &str, r: f64| {
        let at = [r * 0.5_f64.sqrt(), 0.05, r * 0.5_f64.sqrt()];
        json!({ "type": "strain", "name": name, "on": "all", "at": at, "direction": [1.0, 0.0, -1.0] })
    };
    let tube = |element: &str| {
        run(json!({
            "analysis": { "type": "static", "linear": true },
            "mesh": { "type": "cylinder", "axis": [0, 1, 0], "start": [1, 0, 0], "radius": radius, "angles": [0.0, -90.0], "length": 0.1, "grid": { "elements": [40, 1] } },
            "materials": { "m": { "type": "isotropic", "young": young, "poisson": 0.0 } },
            "sections": [{ "element": element, "material": "m", "thickness": h }],
            "conditions": [edge("u_min", ["z", "y"], "z"), edge("u_max", ["x", "y"], "x")],
            "loads": [{ "type": "pressure", "value": -1e3 }],
            "sensors": [gauge("inner", radius - 0.49 * h), gauge("outer", radius + 0.49 * h)]
        }))
    };
    // Hoop stress at the outer and the inner face.
    let stresses = |(system, state): &(System, State)| {
        let geometry = system.geometry(&system.shells[20]);
        let outwards =
            geometry.directors[0].dot(&Vec3::new(geometry.positions[0].x, 0.0, geometry.positions[0].z))
                > 0.0;
        let found = &recover(system, state)[20];
        let [top, bottom] = [found.stress_top, found.stress_bottom].map(|s| larger(s[0].abs(), s[1].abs()));
        if outwards { [top, bottom] } else { [bottom, top] }
    };
    // E u/r with the radius of the middle: 1 ∓ h/2R at the faces.
    let mean = |[outer, inner]: [f64; 2]| 0.5 * (outer + inner);
    let variation = |[outer, inner]: [f64; 2]| (outer - inner) / mean([outer, inner]) / (h / radius);
    let ems = tube("ems");
    let [at_inner, at_outer] = sensor_values(&ems.0, &ems.1)[..] else { panic!("two gauges") };
    let gauges = variation([young * at_outer.abs(), young * at_inner.abs()]);
    let [cm, ems] = [stresses(&tube("cm")), stresses(&ems)];
    assert!((variation(ems) - 1.0).abs() < 0.02, "{ems:?}");
    assert!((variation(cm) + 1.0).abs() < 0.02, "{cm:?}");
    assert!((gauges + 0.98).abs() < 0.02, "{at_inner} {at_outer}");
    // Hoop force p R, at the mean radius on which the pressure acts.
    for found in [cm, ems] {
        assert!((mean(found) / (1e3 * radius / h) - 1.0).abs() < 0.01, "{found:?}");
    }
}
