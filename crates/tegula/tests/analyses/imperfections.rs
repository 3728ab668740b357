//! Imperfections of the reference geometry: shapes of buckling modes and random fields.

use crate::common::{Notes, cylinder, on, plate, vector_load};
use crate::path_edges::{Warnings, hinged_plate};
use tegula::analysis::{Silent, buckling, statics};
use tegula::compile::{build, imperfect_mesh};
use tegula::mesh::generators::generate;
use tegula::model::*;
use tegula::norm::max_norm;
use tegula::{Error, Mesh, Vec3};

const LENGTH: f64 = 1.0;

/// A column between hinges, compressed by a force.
fn column(force: f64) -> Model {
    let analysis = Analysis::Static(StaticAnalysis::default());
    let mesh = plate([LENGTH, 0.1], [32, 1], 0.0);
    let mut m = Model::new(mesh, analysis, Isotropic::new(2e7, 0.0, 1.0), 0.005);
    let guided = FixComponents { on: "u_max".into(), position: vec![Axis::Y, Axis::Z], director: Vec::new() };
    m.conditions = vec![Condition::Hinge(on("u_min")), Condition::Fix(guided)];
    m.loads = vec![Load::Edge(vector_load("u_max", [-10.0 * force, 0.0, 0.0]))];
    m
}

fn bowed(m: &Model) -> Mesh {
    imperfect_mesh(m, &generate(&m.mesh).unwrap(), &mut Silent).unwrap().unwrap()
}

fn mode(mode: u32, amplitude: f64) -> Imperfection {
    Imperfection::Mode(ModeImperfection { mode, amplitude })
}

/// R. V. Southwell, Proc. R. Soc. London A 135 (1932) 601–616: of a column with an imperfection a in the shape of the first mode the additional deflection is
/// w = a P/(P_c − P), so that w over w/P is a line of the slope P_c.
#[test]
fn the_southwell_plot_of_an_imperfect_column_has_the_slope_of_the_buckling_load() {
    let analysis = Analysis::Buckling(BucklingAnalysis::new(1));
    let perfect = Model { analysis, ..column(1.0) };
    let system = build(&perfect, &generate(&perfect.mesh).unwrap()).unwrap();
    let critical = buckling::run(&system, &BucklingAnalysis::new(1), &mut Silent).unwrap().modes[0].factor;
    let amplitude = 1e-4;
    let deflection = |part: f64| {
        let mut m = column(part * critical);
        m.imperfections = vec![mode(1, amplitude)];
        let mesh = bowed(&m);
        let largest = max_norm(mesh.positions.iter().map(|x| x.z));
        assert!((largest / amplitude - 1.0).abs() < 1e-9, "{largest}");
        let system = build(&m, &mesh).unwrap();
        let Analysis::Static(options) = &m.analysis else { panic!() };
        let state = statics::run(&system, options, None, &mut Silent).unwrap().state;
        let vectors = system.coordinates.position_of.iter();
        max_norm(vectors.map(|&v| state.u[v as usize][2]))
    };
    let parts = [0.3, 0.5, 0.7];
    let found = parts.map(deflection);
    for (part, w) in parts.into_iter().zip(found) {
        let expected = amplitude * part / (1.0 - part);
        assert!((w / expected - 1.0).abs() < 1e-2, "{part} {w} {expected}");
    }
    let slope = |i: usize, j: usize| (found[j] - found[i]) / (found[j] / parts[j] - found[i] / parts[i]);
    for (i, j) in [(0, 1), (1, 2)] {
        assert!((slope(i, j) - 1.0).abs() < 1e-2, "{}", slope(i, j));
    }
}

/// Amplitudes of two modes add up; directors of curved shells keep their normals where nothing is displaced.
#[test]
fn imperfections_add_up() {
    let mut m = column(1.0);
    let nominal = generate(&m.mesh).unwrap();
    let displaced = |m: &Model| -> Vec<Vec3> {
        bowed(m).positions.iter().zip(&nominal.positions).map(|(x, nominal)| x - nominal).collect()
    };
    let of = |m: &mut Model, list: Vec<Imperfection>| {
        m.imperfections = list;
        displaced(m)
    };
    let first = of(&mut m, vec![mode(1, 1e-3)]);
    let second = of(&mut m, vec![mode(2, -2e-3)]);
    let both = of(&mut m, vec![mode(1, 1e-3), mode(2, -2e-3)]);
    let differences = both.iter().zip(first.iter().zip(&second)).map(|(c, (a, b))| (c - a - b).norm());
    assert!(max_norm(differences) < 1e-12);
    m.imperfections.clear();
    assert!(imperfect_mesh(&m, &nominal, &mut Silent).unwrap().is_none());
}

/// On a cylinder: along the normals, the largest deviation as given, the same for the same seed, smooth over the correlation length, and
/// uncorrelated with another seed.
#[test]
fn random_imperfections_are_smooth_and_normal_to_the_surface() {
    let mesh = cylinder(1.0, [0.0, 180.0], 2.0, [60, 40]);
    let analysis = Analysis::Static(StaticAnalysis::default());
    let mut m = Model::new(mesh, analysis, Isotropic::new(1.0, 0.3, 1.0), 0.01);
    let nominal = generate(&m.mesh).unwrap();
    let deviation = |m: &Model| -> Vec<f64> {
        let mesh = bowed(m);
        let along = mesh.positions.iter().zip(&nominal.positions).map(|(x, at)| {
            let radial = Vec3::new(at.x, 0.0, at.z).normalize();
            let u = x - at;
            // The normals of the outermost facets differ from that of the cylinder by half their angle.
            assert!((u - radial * radial.dot(&u)).norm() <= 0.03 * u.norm());
            radial.dot(&u)
        });
        along.collect()
    };
    let of = |m: &mut Model, seed: u64| {
        let keys = RandomImperfection { amplitude: 0.02, correlation_length: 0.3, seed };
        m.imperfections = vec![Imperfection::Random(keys)];
        deviation(m)
    };
    let (first, again, other) = (of(&mut m, 1), of(&mut m, 1), of(&mut m, 2));
    assert_eq!(first, again);
    assert!((max_norm(first.iter().copied()) / 0.02 - 1.0).abs() < 1e-3);
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let correlation = |a: &[f64], b: &[f64]| product(a, b) / (product(a, a) * product(b, b)).sqrt();
    assert!(correlation(&first, &other).abs() < 0.5, "{}", correlation(&first, &other));
    // Neighbours along the axis: 0.05 apart, exp(−0.05²/(2·0.3²)) = 0.986.
    let pairs: Vec<(f64, f64)> = (0..nominal.positions.len())
        .filter_map(|i| {
            let next = nominal.positions[i] + Vec3::new(0.0, 0.05, 0.0);
            let j = nominal.positions.iter().position(|x| (x - next).norm() < 1e-9)?;
            Some((first[i], first[j]))
        })
        .collect();
    let (a, b): (Vec<f64>, Vec<f64>) = pairs.into_iter().unzip();
    assert!((correlation(&a, &b) - 0.986).abs() < 0.01, "{}", correlation(&a, &b));
}

/// A wave along the axis of a cylinder is axisymmetric: its nodes stay in the planes of symmetry.
#[test]
fn waves_are_normal_to_the_surface() {
    let mut m = column(1.0);
    m.mesh = cylinder(2.0, [0.0, 90.0], 2.0, [9, 20]);
    let (amplitude, wavelength, phase) = (-1e-3, 0.7, 30.0_f64);
    let wave = WaveImperfection { amplitude, direction: [0.0, 3.0, 0.0], wavelength, phase };
    m.imperfections = vec![Imperfection::Wave(wave)];
    let nominal = generate(&m.mesh).unwrap();
    for (x, at) in bowed(&m).positions.iter().zip(&nominal.positions) {
        let value = amplitude * (std::f64::consts::TAU * at.y / wavelength + phase.to_radians()).cos();
        let expected = Vec3::new(at.x, 0.0, at.z) / 2.0 * value;
        assert!((x - at - expected).norm() < 1e-15, "{x:?} {at:?}");
    }
}

/// Imperfections without an effect: a wave across a flat strip, an amplitude of 0, and random ones that are shorter than an element.
#[test]
fn imperfections_without_effect_are_warned_of() {
    let mut m = column(1.0);
    let nominal = generate(&m.mesh).unwrap();
    let wave = |direction| {
        Imperfection::Wave(WaveImperfection { amplitude: 1e-3, direction, wavelength: 0.5, phase: 0.0 })
    };
    let random = |correlation_length| {
        Imperfection::Random(RandomImperfection { amplitude: 1e-3, correlation_length, seed: 1 })
    };
    for (imperfection, reason) in [
        (wave([0.0, 0.0, 1.0]), Some("leaves the shape as it is")),
        (wave([1.0, 0.0, 0.0]), None),
        (mode(1, 0.0), Some("moves no node")),
        (mode(1, 1e-3), None),
        (random(1e-3), Some("shorter than the edges")),
        (random(0.3), None),
    ] {
        m.imperfections = vec![imperfection];
        let mut notes = Notes::default();
        imperfect_mesh(&m, &nominal, &mut notes).unwrap().unwrap();
        match reason {
            Some(reason) => {
                assert!(notes.warnings.iter().any(|w| w.contains(reason)), "{:?}", notes.warnings)
            }
            None => assert!(notes.warnings.is_empty(), "{:?}", notes.warnings),
        }
    }
}

#[test]
fn tables_displace_the_nodes_of_their_numbers() {
    let mut m = column(1.0);
    let table = [(3, [1e-3, 0.0, 2e-3]), (40, [0.0, -1e-3, 0.0])];
    let rows = table.map(|(node, displacement)| NodeDisplacement { node, displacement });
    let of = |displacements: Option<Vec<NodeDisplacement>>| {
        let displacements = displacements.map(std::sync::Arc::new);
        Imperfection::File(FileImperfection { file: "dents.csv".into(), factor: 2.0, displacements })
    };
    m.imperfections = vec![of(Some(rows.to_vec()))];
    let nominal = generate(&m.mesh).unwrap();
    let mut numbered = nominal.clone();
    let nodes: Vec<u64> = (0..nominal.positions.len() as u64).rev().collect();
    let last = nodes.len() - 1;
    numbered.labels = Some(tegula::mesh::Labels { file: "a.msh".into(), nodes, quads: Vec::new() });
    for (mesh, place) in [(&nominal, [3, 40]), (&numbered, [last - 3, last - 40])] {
        let found = imperfect_mesh(&m, mesh, &mut Silent).unwrap().unwrap();
        for (i, (x, at)) in found.positions.iter().zip(&nominal.positions).enumerate() {
            let row = place.iter().position(|node| *node == i);
            let expected = row.map_or(Vec3::zeros(), |row| Vec3::from(table[row].1) * 2.0);
            assert!((x - at - expected).norm() < 1e-15, "{i}");
        }
    }
    let unknown = NodeDisplacement { node: 1000, displacement: [0.0; 3] };
    for (table, expected) in [(Some(vec![unknown]), "node 1000"), (None, "has not been read")] {
        m.imperfections = vec![mode(1, 0.0), of(table)];
        let Err(Error::Model(issues)) = imperfect_mesh(&m, &nominal, &mut Silent) else {
            panic!("{expected}")
        };
        let text = issues[0].to_string();
        assert!(text.contains("imperfections[1].file") && text.contains(expected), "{text}");
    }
}

#[test]
fn mistakes_in_imperfections_are_found() {
    let mut m = column(1.0);
    let mesh = generate(&m.mesh).unwrap();
    let mut refused = |list: Vec<Imperfection>, expected: &str| {
        m.imperfections = list;
        let Err(Error::Model(issues)) = imperfect_mesh(&m, &mesh, &mut Silent) else { panic!("{expected}") };
        assert!(issues.iter().any(|issue| issue.to_string().contains(expected)), "{issues:?}");
    };
    refused(vec![mode(0, 1.0)], "imperfections[0].mode");
    refused(vec![mode(1, f64::NAN)], "imperfections[0].amplitude");
    let rough = RandomImperfection { amplitude: 1.0, correlation_length: 0.0, seed: 0 };
    refused(vec![mode(1, 1.0), Imperfection::Random(rough)], "imperfections[1].correlation_length");
    let wave = WaveImperfection { amplitude: 1.0, direction: [0.0; 3], wavelength: -1.0, phase: f64::NAN };
    for key in ["direction", "wavelength", "phase"] {
        refused(vec![Imperfection::Wave(wave.clone())], &format!("imperfections[0].{key}"));
    }
    let file = FileImperfection { file: String::new(), factor: f64::INFINITY, displacements: None };
    refused(vec![Imperfection::File(file)], "imperfections[0].factor");
}

/// Beams are not displaced.
#[test]
fn imperfections_without_a_mesh_are_refused() {
    let section = BeamSection::Rectangle(RectangularSection { size: [0.01, 0.1] });
    let ends = [[0.0; 3], [1.0, 0.0, 0.0]];
    let mut m = Model::of_bodies(column(1.0).analysis, Vec::new(), Vec::new());
    m.beams = vec![Beam::straight("beam", ends, 4, [0.0, 0.0, 1.0], section)];
    let wave = WaveImperfection { amplitude: 1e-3, direction: [1.0, 0.0, 0.0], wavelength: 1.0, phase: 0.0 };
    m.imperfections = vec![Imperfection::Wave(wave)];
    let Err(error) = imperfect_mesh(&m, &generate(&m.mesh).unwrap(), &mut Silent) else { panic!() };
    assert!(error.to_string().contains("no mesh"), "{error}");
}

/// The second mode of a square plate under equal compression along both sides is one of two.
#[test]
fn imperfections_in_the_shape_of_a_multiple_mode_are_doubted() {
    for (mode, across, doubted) in [(1, 1.0, false), (2, 1.0, true), (3, 1.0, true), (2, 0.5, false)] {
        let mut m = hinged_plate(6, across, PathAnalysis::default());
        m.imperfections = vec![Imperfection::Mode(ModeImperfection { mode, amplitude: 1e-4 })];
        let mesh = tegula::mesh::generators::generate(&m.mesh).unwrap();
        let mut warnings = Warnings::default();
        tegula::compile::imperfect_mesh(&m, &mesh, &mut warnings).unwrap();
        let found = warnings.0.iter().any(|warning| warning.contains("several modes"));
        assert_eq!(found, doubted, "{mode} {across} {:?}", warnings.0);
    }
}
