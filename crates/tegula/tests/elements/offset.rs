//! Layers beside the mesh: the result does not depend on the surface that the mesh describes.

use tegula::Vec3;
use tegula::element::{Nodal, ShellGeometry};
use tegula::mesh::generators::generate;
use tegula::model::*;
use tegula::norm::larger;
use tegula::result::recover;

use crate::common::{self, Random, geometry, vector_load};
use crate::harness::{Element, H, layup, materials};

/// Sections of layers, linear and yielding, with every assumed strain and membrane part.
fn sections(element: ElementKind) -> Vec<Section> {
    let of =
        |plies: &[(&str, f64, f64)]| Section { element, layup: Some(layup(plies)), ..Section::new("", 0.0) };
    let linear = of(&[("m", 0.0, 0.5), ("ply", 30.0, 0.5)]);
    let mut out: Vec<Section> =
        Membrane::ALL.map(|membrane| Section { membrane: Some(membrane), ..linear.clone() }).into();
    out.push(Section { ans_shear: false, ..linear.clone() });
    if element == ElementKind::Ems {
        out.push(Section { ans_thickness: false, ..linear });
    }
    out.push(of(&[("metal", 0.0, 0.4), ("ply", 20.0, 0.6)]));
    out
}

fn heat(temperature: f64, gradient: f64) -> PrescribedStrain {
    PrescribedStrain::Thermal(ThermalStrain {
        distribution: None,
        on: "all".into(),
        temperature,
        gradient,
        amplitude: None,
    })
}

/// An element whose layers lie at the height e above its nodes is that whose nodes lie at `r + e d`, for large motions of
/// warped and distorted elements that are heated, and so is its mass.
#[test]
fn elements_beside_their_nodes_are_those_with_nodes_on_the_middle_of_their_layers() {
    let mut random = Random::new(7);
    for element in [ElementKind::Ems, ElementKind::Mitc4] {
        for plain in sections(element) {
            for offset in [-3.0 * H, 0.5 * H, 4.0 * H] {
                let nodes = geometry(&mut random, [0.4, 1.0], 0.08);
                let mut middle = nodes.positions;
                middle.iter_mut().zip(&nodes.directors).for_each(|(x, d)| *x += d * offset);
                let mut beside = plain.clone();
                beside.layup.as_mut().unwrap().offset = offset;
                let moved = ShellGeometry::new(middle, nodes.directors);
                let (a, b) = (
                    Element::with_strains(&beside, &materials(), &nodes, &[heat(20.0, 3.0)]),
                    // The gradient is counted from the mesh.
                    Element::with_strains(&plain, &materials(), &moved, &[heat(20.0 + 3.0 * offset, 3.0)]),
                );
                let u: Vec<Nodal> = (0..8).map(|_| [0.0; 3].map(|_: f64| 0.3 * random.next())).collect();
                let mut of_middle = u.clone();
                for n in 0..4 {
                    let x = Vec3::from(u[n]) + Vec3::from(u[4 + n]) * offset;
                    of_middle[n] = x.into();
                }
                let (found, exact) = (a.energy(&u), b.energy(&of_middle));
                let label =
                    format!("{element:?} {:?} ans {} offset {offset}", plain.membrane, plain.ans_shear);
                assert!((found / exact - 1.0).abs() < 1e-11, "{label}: energy {found:e} for {exact:e}");
                let kinetic = |e: &Element, rate: &[Nodal]| {
                    let mass = e.groups[0].mass(0);
                    let pairs = (0..8).flat_map(|i| (0..8).map(move |j| (i, j)));
                    let of = |(i, j): (usize, usize)| {
                        let at = i.max(j) * (i.max(j) + 1) / 2 + i.min(j);
                        mass[at] * Vec3::from(rate[i]).dot(&Vec3::from(rate[j]))
                    };
                    pairs.map(of).sum::<f64>()
                };
                let (found, exact) = (kinetic(&a, &u), kinetic(&b, &of_middle));
                assert!((found / exact - 1.0).abs() < 1e-11, "{label}: mass {found:e} for {exact:e}");
            }
        }
    }
}

/// A strip under an edge moment bends to an arc of the angle M L/(E I), with the stress M h/(2 I), however far the mesh lies
/// beside it.
#[test]
fn a_strip_bends_to_the_same_arc_beside_any_mesh() {
    let (young, h, length) = (2e11, 0.01, 1.0);
    for element in [ElementKind::Ems, ElementKind::Mitc4] {
        let mut on_middle = 0.0;
        for (offset, curvature) in [(0.0, 0.5), (0.1, 0.5), (-0.05, 0.5), (0.1, -0.5), (0.5, 0.5)] {
            let mesh = MeshSource::Plate(PlateMesh {
                origin: [0.0, 0.0, -offset],
                ..PlateMesh::new([length, 0.1], [32, 1])
            });
            let mut m = common::model(mesh, young, h);
            m.materials.insert("sheet".into(), Material::Isotropic(Isotropic::new(young, 0.0, 1.0)));
            let ply = LayupPly { material: Some("sheet".into()), angle: 0.0, thickness: Some(h) };
            let layup = Layup { plies: vec![ply], offset, ..Layup::default() };
            m.sections[0] = Section { element, layup: Some(layup), ..Section::new("", 0.0) };
            let moment = young * h.powi(3) / 12.0 * curvature;
            m.conditions = vec![Condition::Clamp(common::on("u_min"))];
            m.loads = vec![Load::EdgeMoment(vector_load("u_max", [0.0, moment, 0.0]))];
            m.analysis = Analysis::Static(StaticAnalysis { load_steps: 4, ..Default::default() });
            let (mesh, system, outcome) = common::solve(&m);
            let node = mesh.nodes_on("u_max_v_min").unwrap()[0] as usize;
            let v = system.coordinates.director_of[node] as usize;
            let d = Vec3::from(system.coordinates.reference[v]) + Vec3::from(outcome.state.u[v]);
            let angle = d.x.atan2(d.z);
            let label = format!("{element:?} offset {offset} curvature {curvature}");
            assert!((angle / (curvature * length) - 1.0).abs() < 2e-4, "{label}: angle {angle}");
            if offset == 0.0 {
                on_middle = angle;
            }
            assert!((angle.abs() / on_middle - 1.0).abs() < 1e-9, "{label}: {angle} for {on_middle}");
            let exact = 0.5 * young * h * curvature.abs();
            let mut off = 0.0;
            for r in recover(&system, &outcome.state) {
                for stress in [r.stress_top[0], r.stress_bottom[0], r.von_mises] {
                    off = larger(off, stress.abs() / exact - 1.0);
                    off = larger(off, 1.0 - stress.abs() / exact);
                }
            }
            assert!(off < 2e-3, "{label}: stress off by {off}");
        }
    }
}

/// A prestress without a moment about the middle of the layers is uniform over them, however far the mesh lies beside them.
#[test]
fn a_prestress_is_uniform_over_layers_beside_the_mesh() {
    let (h, force) = (4e-3, 1e4);
    for element in [ElementKind::Ems, ElementKind::Mitc4] {
        for offset in [0.0, 0.5 * h, 5.0 * h] {
            for plies in [&[("sheet", 1.0)][..], &[("sheet", 0.5), ("ply", 0.5)]] {
                let mut m = common::model(MeshSource::Plate(PlateMesh::new([1.0, 1.0], [4, 4])), 7e10, h);
                m.materials.insert("sheet".into(), Material::Isotropic(Isotropic::new(7e10, 0.3, 2700.0)));
                m.materials.insert("ply".into(), common::ply());
                let plies = plies.iter().map(|&(material, part)| LayupPly {
                    material: Some(material.into()),
                    angle: 20.0,
                    thickness: Some(part * h),
                });
                let layup = Layup { plies: plies.collect(), offset, ..Layup::default() };
                m.sections[0] = Section { element, layup: Some(layup), ..Section::new("", 0.0) };
                m.conditions = ["u_min", "u_max", "v_min", "v_max"]
                    .map(|edge| Condition::Clamp(common::on(edge)))
                    .into();
                m.prescribed_strains = vec![PrescribedStrain::Prestress(Prestress {
                    distribution: None,
                    on: "all".into(),
                    membrane: [force, 0.0, 0.0],
                    bending: [-offset * force, 0.0, 0.0],
                    direction: [1.0, 0.0, 0.0],
                    amplitude: None,
                })];
                let (_, system, outcome) = common::solve(&m);
                for r in recover(&system, &outcome.state) {
                    for stress in [r.stress_top[0], r.stress_bottom[0], r.von_mises] {
                        let error = (stress / (force / h) - 1.0).abs();
                        assert!(error < 1e-9, "{element:?} offset {offset}: {stress} for {}", force / h);
                    }
                }
            }
        }
    }
}

/// Layers beyond the centre of curvature of the mesh have no surface.
#[test]
fn layers_beyond_the_centre_of_curvature_are_refused() {
    let mesh = MeshSource::Cylinder(CylinderMesh {
        center: [0.0; 3],
        axis: [0.0, 0.0, 1.0],
        start: [1.0, 0.0, 0.0],
        radius: 0.2,
        angles: [0.0, 90.0],
        length: 0.3,
        grid: Grid::uniform(8, 4),
    });
    for (offset, refused) in [(0.3, false), (-0.15, false), (-0.25, true)] {
        let mut m = common::model(mesh.clone(), 1e9, 0.01);
        let ply = LayupPly { material: Some("m".into()), angle: 0.0, thickness: Some(0.01) };
        let layup = Layup { plies: vec![ply], offset, ..Layup::default() };
        m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(1e9, 0.3, 1.0)));
        m.sections[0] = Section { element: ElementKind::Ems, layup: Some(layup), ..Section::new("", 0.0) };
        m.loads = vec![Load::Edge(vector_load("u_max", [1.0, 0.0, 0.0]))];
        let problems = tegula::compile::build(&m, &generate(&m.mesh).unwrap()).err().map(|e| e.to_string());
        assert_eq!(problems.is_some(), refused, "{offset}: {problems:?}");
        if let Some(text) = problems {
            assert!(text.contains("beyond the centre of curvature"), "{text}");
        }
    }
}
