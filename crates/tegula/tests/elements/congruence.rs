//! Elements of one shape share their stiffness when a model is built: against models whose elements keep their own.

use crate::common;
use crate::common::{Random, model, plate, ply};
use tegula::compile::build;
use tegula::element::{Nodal, TangentWeights};
use tegula::mesh::generators::generate;
use tegula::model::*;
use tegula::norm::max_norm;
use tegula::system::assembly::TangentCoefficients;
use tegula::system::{Assembly, EvaluationPoint};
use tegula::{Error, Mesh, System, Vec3};

const THICKNESS: f64 = 0.02;

/// A free shell that moves in time.
fn free() -> Model {
    let m = model(plate([1.0; 2], [1, 1], 0.0), 1e3, THICKNESS);
    Model { conditions: Vec::new(), analysis: Analysis::Transient(TransientAnalysis::new(1.0)), ..m }
}

/// Steel below an oblique ply: bending couples with stretching, and directions count.
fn layered(direction: [f64; 3]) -> Model {
    let mut m = free();
    m.materials.insert("ply".into(), ply());
    let layer = |material: &str, angle, part: f64| LayupPly {
        material: Some(material.into()),
        angle,
        thickness: Some(part * THICKNESS),
    };
    m.sections[0].material.clear();
    m.sections[0].thickness = 0.0;
    m.sections[0].layup = Some(Layup {
        plies: vec![layer("m", 0.0, 0.6), layer("ply", 25.0, 0.4)],
        direction,
        ..Layup::default()
    });
    m
}

/// This model with a field of heat for each element, which begins from nothing: under a field of its own, no element counts
/// as one like another.
fn apart(m: &Model, mesh: &Mesh) -> (Model, Mesh) {
    let (mut m, mut mesh) = (m.clone(), mesh.clone());
    let rising = ExpressionAmplitude { expression: "t".into() };
    m.amplitudes.insert("rising".into(), Amplitude::Expression(rising));
    for q in 0..mesh.quads.len() as u32 {
        let on = format!("own{q}");
        mesh.quad_sets.insert(on.clone(), vec![q]);
        let heat = ThermalStrain {
            distribution: None,
            on,
            temperature: 1.0,
            gradient: 0.0,
            amplitude: Some("rising".into()),
        };
        m.prescribed_strains.push(PrescribedStrain::Thermal(heat));
    }
    (m, mesh)
}

/// Forces and tangent of a motion, and the energy.
fn response(system: &System, u: &[Nodal]) -> (Vec<f64>, Vec<f64>, f64) {
    let mut assembly = Assembly::new(system);
    let weights = TangentWeights::STATIC;
    let parts = TangentCoefficients { weights, mass: 3.0, time: 0.0 };
    let k = EvaluationPoint::at_rest(system, u, 0.0, &[]);
    let mut forces = vec![[0.0; 3]; system.vectors()];
    assembly.forces_and_tangent(system, &k, &parts, false, None, &mut forces);
    let energy = assembly.strain_energy(system, &k);
    (forces.into_flattened(), assembly.values, energy)
}

/// Largest differences of forces, tangents and energies, over their sizes.
fn difference(a: &System, b: &System) -> [f64; 3] {
    let mut random = Random::new(5);
    let u: Vec<Nodal> = (0..a.vectors()).map(|_| (random.vector() * 0.01).into()).collect();
    let (a, b) = (response(a, &u), response(b, &u));
    assert_eq!((a.0.len(), a.1.len()), (b.0.len(), b.1.len()));
    let off = |a: &[f64], b: &[f64]| max_norm(a.iter().zip(b).map(|(x, y)| x - y)) / max_norm(a);
    [off(&a.0, &b.0), off(&a.1, &b.1), off(&[a.2], &[b.2])]
}

/// Begins every second element at its next corner: the same surface, but frames that are turned by a right angle.
fn turned(mut mesh: Mesh) -> Mesh {
    for q in (1..mesh.quads.len()).step_by(2) {
        mesh.quads[q].rotate_left(1);
        if let Some(normals) = &mut mesh.normals {
            normals[q].rotate_left(1);
        }
    }
    mesh
}

/// Plates, squares whose corners are counted from different ones, and a cylinder whose elements differ by a rotation of
/// space, of layers along and across its axis and askew.
#[test]
fn models_whose_elements_share_are_those_whose_elements_do_not() {
    let flat = |size| generate(&plate(size, [4, 4], 0.0)).unwrap();
    let cylinder = generate(&common::quarter_cylinder(4, 1e3).mesh).unwrap();
    let meshes = [
        ("plate", flat([1.3, 0.8])),
        ("squares", flat([1.0, 1.0])),
        ("turned squares", turned(flat([1.0, 1.0]))),
        ("cylinder", cylinder.clone()),
        ("turned elements of a cylinder", turned(cylinder)),
    ];
    for (name, mesh) in &meshes {
        for element in [ElementKind::Ems, ElementKind::Cm, ElementKind::Mitc4, ElementKind::SolidShell] {
            for direction in [[0.0, 1.0, 0.0], [1.0, 0.4, 0.3]] {
                let mut m = layered(direction);
                m.sections[0].element = element;
                let shared = build(&m, mesh).unwrap();
                let (m, mesh) = apart(&m, mesh);
                let off = difference(&shared, &build(&m, &mesh).unwrap());
                assert!(off.iter().all(|x| *x < 1e-12), "{name} {element:?} {direction:?}: {off:?}");
            }
        }
    }
}

/// Squares apart from each other. In the `bad` ones the directors lean until they lie in the surface at two of the
/// integration points, where such an element has no frame, though it has one in its middle.
fn squares(bad: &[bool]) -> Mesh {
    let mut mesh = Mesh::default();
    let mut normals = Vec::new();
    for (i, &bad) in bad.iter().enumerate() {
        let first = mesh.positions.len() as u32;
        let corner = |x: f64, y: f64| Vec3::new(x + 2.0 * i as f64, y, 0.0);
        mesh.positions.extend([corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)]);
        mesh.quads.push([0, 1, 2, 3].map(|a| first + a));
        let lean = |z: f64| Vec3::new(0.0, (1.0 - z * z).sqrt(), z);
        // Linear from one side to the other, z vanishes at ξ = 1/√3.
        let s = 1.0 / 3.0_f64.sqrt();
        let (from, to) = (lean(0.6), lean(-0.6 * (1.0 - s) / (1.0 + s)));
        normals.push(if bad { [from, to, to, from] } else { [Vec3::z(); 4] });
    }
    mesh.normals = Some(normals);
    mesh
}

#[test]
fn every_invalid_element_of_a_shape_is_reported() {
    for bad in [[true, false, true, true, false], [false, true, true, false, true]] {
        match build(&free(), &squares(&bad)) {
            Err(Error::Model(issues)) => {
                let of = |q: &usize| issues.iter().any(|i| i.message.contains(&format!("element {q} at")));
                let found: Vec<bool> = (0..bad.len()).map(|q| of(&q)).collect();
                assert_eq!(found, bad, "{issues:?}");
            }
            other => panic!("{:?}", other.map(|_| ())),
        }
    }
}
