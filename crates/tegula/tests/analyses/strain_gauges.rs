//! Strain gauges on shells: strips under tension and bending, rigid rotations, and messages.

use crate::common::{compile, irregular, model, on, plate, static_options, vector_load};

use tegula::Vec3;
use tegula::analysis::{Silent, statics};
use tegula::model::*;
use tegula::result::{sensor_columns, sensor_values};

const YOUNG: f64 = 1.2e8;
const THICKNESS: f64 = 0.01;
const WIDTH: f64 = 0.2;

fn gauge(at: [f64; 3], direction: [f64; 3]) -> Sensor {
    Sensor::Strain(StrainSensor { name: "gauge".into(), on: "all".into(), at, direction })
}

/// Strip of length 1 with Poisson's ratio 0.3, guided so that it contracts freely.
fn strip(elements: [u32; 2], distortion: f64, linear: bool) -> Model {
    let mut m = model(plate([1.0, WIDTH], elements, distortion), YOUNG, THICKNESS);
    m.materials.values_mut().for_each(|material| {
        if let Material::Isotropic(i) = material {
            i.poisson = 0.3;
        }
    });
    m.conditions = vec![
        Condition::Symmetry(SymmetryPlane { on: "u_min".into(), normal: [1.0, 0.0, 0.0] }),
        Condition::Symmetry(SymmetryPlane { on: "v_min".into(), normal: [0.0, 1.0, 0.0] }),
        Condition::Symmetry(SymmetryPlane { on: "all".into(), normal: [0.0, 0.0, 1.0] }),
    ];
    m.analysis = Analysis::Static(StaticAnalysis { linear, ..Default::default() });
    m
}

fn strain(m: &Model) -> f64 {
    let (_, system) = compile(m);
    let outcome = statics::run(&system, &static_options(m), None, &mut Silent).unwrap();
    assert_eq!(sensor_columns(&system), ["sensor.gauge.strain"]);
    sensor_values(&system, &outcome.state)[0]
}

/// Uniform tension: along, across, and at 45°, on a distorted mesh at any place.
#[test]
fn gauges_on_a_strip_under_tension_show_the_strain_along_their_direction() {
    let small = 1e-6;
    let force = small * YOUNG * THICKNESS;
    for linear in [true, false] {
        for (direction, exact) in [
            ([1.0, 0.0, 0.0], small),
            ([0.0, -3.0, 0.0], -0.3 * small),
            ([1.0, 1.0, 0.0], 0.35 * small),
            ([1.0, 0.0, 5.0], small),
        ] {
            let mut m = strip([6, 3], 0.3, linear);
            m.loads = vec![Load::Edge(vector_load("u_max", [force, 0.0, 0.0]))];
            m.sensors = vec![gauge([0.63, 0.07, 0.003], direction)];
            let found = strain(&m);
            assert!((found / exact - 1.0).abs() < 1e-5, "{direction:?}, linear {linear}: {found:e}");
        }
    }
}

/// A strip that a moment bends to an arc by 1 rad: strain κ ζ at the height ζ. The Green–Lagrange strain of the shell is linear in ζ, and the
/// stretch λ turns its stress into a force: `∫ E (ε + κ ζ)(1 + κ ζ) dζ = 0` for the strain ε = −κ² h²/12 of the mid-surface.
#[test]
fn gauges_on_the_faces_of_a_strip_show_its_curvature() {
    let bending = YOUNG * WIDTH * THICKNESS.powi(3) / 12.0;
    let curvature = 1.0;
    for height in [0.5 * THICKNESS, -0.5 * THICKNESS, 0.0] {
        let mut m = strip([40, 1], 0.0, false);
        m.materials.values_mut().for_each(|material| {
            if let Material::Isotropic(i) = material {
                i.poisson = 0.0;
            }
        });
        m.conditions = vec![Condition::Clamp(on("u_min"))];
        // It bends downwards: the upper face is in tension.
        m.loads = vec![Load::Moment(vector_load("u_max", [0.0, 0.5 * curvature * bending, 0.0]))];
        m.analysis = Analysis::Static(StaticAnalysis { load_steps: 10, ..Default::default() });
        m.sensors = vec![gauge([0.51, 0.1, height], [1.0, 0.0, 0.0])];
        let found = strain(&m);
        let exact = curvature * height - (curvature * THICKNESS).powi(2) / 12.0;
        assert!((found - exact).abs() < 2e-4 * curvature * THICKNESS, "{height}: {found:e} {exact:e}");
    }
}

/// Pure bending in the plane of a strip without lateral contraction: the strain along 45° is half of that along the strip at any place of an element, where
/// the displacements of a bilinear element have a shear strain that the strip has not.
#[test]
fn gauges_under_bending_in_the_plane_have_no_parasitic_shear() {
    let small = 1e-6;
    for linear in [true, false] {
        for x in [0.51, 0.525, 0.55, 0.59] {
            for (direction, share) in [([1.0, 0.0, 0.0], 1.0), ([1.0, 1.0, 0.0], 0.5), ([0.0, 1.0, 0.0], 0.0)]
            {
                let mut m = strip([10, 4], 0.0, linear);
                m.materials.values_mut().for_each(|material| {
                    if let Material::Isotropic(i) = material {
                        i.poisson = 0.0;
                    }
                });
                // The line of symmetry at y = 0 would hold the bending.
                m.conditions.remove(1);
                m.conditions.push(Condition::Fix(FixComponents {
                    on: "u_min_v_min".into(),
                    position: vec![Axis::Y],
                    director: Vec::new(),
                }));
                let load = VectorLoad {
                    distribution: Some("(y - 0.1)/0.1".into()),
                    ..vector_load("u_max", [small * YOUNG * THICKNESS, 0.0, 0.0])
                };
                m.loads = vec![Load::Edge(load)];
                m.sensors = vec![gauge([x, 0.17, 0.0], direction)];
                let (found, exact) = (strain(&m), 0.7 * small * share);
                assert!((found - exact).abs() < 1e-3 * small, "{x} {direction:?}: {found:e} {exact:e}");
            }
        }
    }
}

/// On a node, an edge, and inside, whatever the order of elements and of the nodes of each.
#[test]
fn gauges_do_not_depend_on_the_numbering_of_the_mesh() {
    let mesh = irregular(5);
    let (_, inner) = (0..).zip(&mesh.positions).filter(|(_, x)| x.norm() > 0.0).nth(14).unwrap();
    for at in [*inner, mesh.quads[9].map(|n| mesh.positions[n as usize]).iter().sum::<Vec3>() / 4.0] {
        let of = |mesh: &tegula::Mesh| {
            let mut m = model(plate([1.0, 1.0], [1, 1], 0.0), YOUNG, THICKNESS);
            m.conditions.clear();
            m.sensors = vec![gauge(at.into(), [0.3, -0.8, 0.1])];
            m.analysis = Analysis::Transient(TransientAnalysis::new(0.02));
            let system = tegula::compile::build(&m, mesh).unwrap();
            let mut state = tegula::analysis::State::at_rest(&system);
            for (v, node) in system.coordinates.nodes.iter().enumerate() {
                let x = mesh.positions[*node as usize];
                // Directors stand still; the shell is stretched by different amounts.
                if system.coordinates.position_of[*node as usize] == v as u32 {
                    state.u[v] = [0.01 * x.x * x.x, 0.02 * x.x * x.y, 0.0];
                }
            }
            sensor_values(&system, &state)[0]
        };
        let first = of(&mesh);
        let mut turned = mesh.clone();
        for (i, quad) in turned.quads.iter_mut().enumerate() {
            quad.rotate_left(i % 4);
        }
        assert!(first.abs() > 1e-4 && (of(&turned) / first - 1.0).abs() < 1e-9, "{} {first}", of(&turned));
        turned.quads.reverse();
        assert!((of(&turned) / first - 1.0).abs() < 1e-9, "{} {first}", of(&turned));
    }
}

/// A free irregular plate that turns has no strain, and no rate.
#[test]
fn gauges_do_not_see_rotations() {
    let mesh = irregular(5);
    let mut m = model(plate([1.0, 1.0], [1, 1], 0.0), YOUNG, THICKNESS);
    m.conditions.clear();
    let place = mesh.quads[7].map(|n| mesh.positions[n as usize]).iter().sum::<Vec3>() / 4.0;
    m.sensors = vec![gauge(place.into(), [0.3, -0.8, 0.1])];
    let analysis = TransientAnalysis { time_step: Some(0.01), ..TransientAnalysis::new(0.02) };
    m.analysis = Analysis::Transient(analysis);
    let system = tegula::compile::build(&m, &mesh).unwrap();
    assert_eq!(sensor_columns(&system), ["sensor.gauge.strain", "sensor.gauge.rate"]);
    let mut state = tegula::analysis::State::at_rest(&system);
    let turned = nalgebra::Rotation3::new(Vec3::new(1.1, -0.7, 2.0));
    let spin = Vec3::new(3.0, -2.0, 5.0);
    state.v = vec![[0.0; 3]; system.vectors()];
    for v in 0..system.vectors() {
        let reference = Vec3::from(system.coordinates.reference[v]);
        state.u[v] = (turned * reference - reference).into();
        state.v[v] = spin.cross(&(turned * reference)).into();
    }
    let found = sensor_values(&system, &state);
    assert!(found.iter().all(|value| value.abs() < 1e-13), "{found:?}");
}

#[test]
fn gauges_beside_the_shell_and_across_it_are_refused() {
    for (at, direction, told) in [
        ([0.5, 0.1, 0.006], [1.0, 0.0, 0.0], "above or below the shell"),
        ([1.5, 0.1, 0.0], [1.0, 0.0, 0.0], "lies beside all elements"),
        ([0.5, 0.1, 0.0], [0.0, 0.0, 1.0], "the direction is along the director"),
        ([0.5, 0.1, 0.0], [0.0, 0.0, 0.0], "direction"),
    ] {
        let mut m = strip([4, 1], 0.0, false);
        m.loads = vec![Load::Edge(vector_load("u_max", [1.0, 0.0, 0.0]))];
        m.sensors = vec![gauge(at, direction)];
        let mesh = tegula::mesh::generators::generate(&m.mesh).unwrap();
        let refused = tegula::compile::build(&m, &mesh).map(|_| ()).unwrap_err().to_string();
        assert!(refused.contains(told) && refused.contains("sensors[0]"), "{refused}");
    }
}
