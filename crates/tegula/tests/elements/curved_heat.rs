//! Heat and growth of free curved shells: similarity, spring-in of anisotropic arcs, plies of unlike expansion.

use crate::common;
use tegula::analysis::statics::StaticOutcome;
use tegula::model::*;
use tegula::norm::larger;
use tegula::result::recover;
use tegula::system::VectorKind;
use tegula::{Mesh, System, Vec3};

const YOUNG: f64 = 1e9;
const THICKNESS: f64 = 0.02;

/// A sector of a cylinder about the z axis, symmetric about the plane y = 0.
fn cylinder(elements: [u32; 2], distortion: f64) -> MeshSource {
    let grid = Grid { distortion, ..Grid::uniform(elements[0], elements[1]) };
    MeshSource::Cylinder(CylinderMesh {
        center: [0.0, 0.0, -0.3],
        axis: [0.0, 0.0, 1.0],
        start: [1.0, 0.0, 0.0],
        radius: 1.0,
        angles: [-45.0, 45.0],
        length: 0.6,
        grid,
    })
}

/// A patch of a sphere about the x axis.
fn sphere(elements: [u32; 2], distortion: f64) -> MeshSource {
    let grid = Grid { distortion, ..Grid::uniform(elements[0], elements[1]) };
    MeshSource::Sphere(SphereMesh {
        center: [0.0; 3],
        radius: 1.0,
        longitudes: [-30.0, 30.0],
        latitudes: [-30.0, 30.0],
        grid,
    })
}

/// A shell on supports that leave every deformation free, and hold no point of a similarity about its first corner.
fn free(mesh: MeshSource, section: Section, linear: bool) -> Model {
    let mut m = common::model(mesh, YOUNG, THICKNESS);
    let metal = Isotropic { expansion: 1e-5, ..Isotropic::new(YOUNG, 0.3, 1.0) };
    m.materials.insert("metal".into(), Material::Isotropic(metal));
    m.sections[0] = section;
    let fix = |on: &str, position: Vec<Axis>| {
        Condition::Fix(FixComponents { on: on.into(), position, director: vec![] })
    };
    m.conditions = vec![
        fix("u_min_v_min", vec![Axis::X, Axis::Y, Axis::Z]),
        fix("u_min_v_max", vec![Axis::X, Axis::Y]),
        fix("u_max_v_min", vec![Axis::X]),
    ];
    m.analysis = Analysis::Static(StaticAnalysis { linear, ..Default::default() });
    m
}

fn heated(mut m: Model, temperature: f64) -> Model {
    let heat =
        ThermalStrain { distribution: None, on: "all".into(), temperature, gradient: 0.0, amplitude: None };
    m.prescribed_strains = vec![PrescribedStrain::Thermal(heat)];
    m
}

/// Largest distance of the displacements from `a (x − x₀)`, over their largest.
fn distance_from_similarity(mesh: &Mesh, system: &System, u: &[tegula::element::Nodal], a: f64) -> f64 {
    let origin = mesh.positions[mesh.nodes_on("u_min_v_min").unwrap()[0] as usize];
    let (mut off, mut size) = (0.0, 0.0);
    for (v, u) in u.iter().enumerate() {
        if system.coordinates.kinds[v] == VectorKind::Position {
            let exact = (Vec3::from(system.coordinates.reference[v]) - origin) * a;
            off = larger(off, (Vec3::from(*u) - exact).norm());
            size = larger(size, exact.norm());
        }
    }
    off / size
}

/// Largest equivalent stress and the strain energy of a similarity, over those of the shell if it were held.
fn stress_and_energy(system: &System, outcome: &StaticOutcome, a: f64) -> [f64; 2] {
    let (mut stress, mut area) = (0.0, 0.0);
    for r in recover(system, &outcome.state) {
        stress = larger(stress, r.von_mises);
        area += r.area;
    }
    [stress / (YOUNG * a), outcome.balance.strain.abs() / (YOUNG * a * a * THICKNESS * area)]
}

/// Sections of every membrane part, without each assumed strain, and of two plies.
fn sections(element: ElementKind) -> Vec<Section> {
    let plain = Section { element, ..Section::new("metal", THICKNESS) };
    let mut out: Vec<Section> =
        Membrane::ALL.map(|part| Section { membrane: Some(part), ..plain.clone() }).into_iter().collect();
    out.push(Section { ans_shear: false, ..plain.clone() });
    out.push(layup(element, &[("metal", 0.0), ("metal", 0.0)]));
    if element == ElementKind::Ems {
        out.push(Section { ans_thickness: false, ..plain });
        // Directors that stretch with the surface take the mesh along.
        out.extend([-0.1, 0.02].map(|offset| {
            let mut beside = layup(element, &[("metal", 0.0), ("metal", 0.0)]);
            beside.layup.as_mut().unwrap().offset = offset;
            beside
        }));
    }
    out
}

fn meshes() -> [MeshSource; 4] {
    [cylinder([6, 2], 0.0), cylinder([5, 6], 0.35), sphere([4, 4], 0.0), sphere([5, 4], 0.35)]
}

#[test]
fn heated_curved_shells_expand_by_similarity_without_stress() {
    for element in [ElementKind::Ems, ElementKind::Mitc4] {
        for section in sections(element) {
            for (i, mesh) in meshes().into_iter().enumerate() {
                let m = heated(free(mesh, section.clone(), true), 10.0);
                let (mesh, system, outcome) = common::solve(&m);
                let off = distance_from_similarity(&mesh, &system, &outcome.state.u, 1e-4);
                let [stress, energy] = stress_and_energy(&system, &outcome, 1e-4);
                let label = format!("{element:?} {:?} mesh {i}", section.membrane);
                assert!(off < 1e-9, "{label}: {off:e} of the displacement");
                assert!(stress < 1e-9 && energy < 1e-12, "{label}: stress {stress:e}, energy {energy:e}");
            }
        }
    }
}

/// A metal that does not yield at the strains of these tests.
fn tough() -> Plastic {
    Plastic {
        young: YOUNG,
        poisson: 0.3,
        yield_stress: 0.1 * YOUNG,
        hardening: 0.1 * YOUNG,
        saturation: None,
        saturation_rate: 0.0,
        kinematic: 0.0,
        density: 1.0,
        expansion: 1e-5,
    }
}

/// Green–Lagrange strains E₀ stretch by √(1 + 2E₀), which a free shell of extensible directors meets at any size. The
/// bending strain of inextensible directors is linear in the stretch and meets it up to E₀.
#[test]
fn heated_curved_shells_expand_by_similarity_at_finite_strains() {
    for (element, temperature, tolerance) in [(ElementKind::Ems, 2e3, 1e-8), (ElementKind::Mitc4, 1.0, 1e-5)]
    {
        for plastic in [false, true] {
            for (i, mesh) in meshes().into_iter().enumerate() {
                let section = Section { element, ..Section::new("metal", THICKNESS) };
                let mut m = heated(free(mesh, section, false), temperature);
                if plastic {
                    m.materials.insert("tough".into(), Material::Plastic(tough()));
                    m.sections[0].material = "tough".into();
                }
                let (mesh, system, outcome) = common::solve(&m);
                let a = (1.0 + 2e-5 * temperature).sqrt() - 1.0;
                let off = distance_from_similarity(&mesh, &system, &outcome.state.u, a);
                let [stress, energy] = stress_and_energy(&system, &outcome, a);
                let label = format!("{element:?} plastic {plastic} mesh {i}");
                assert!(off < tolerance, "{label}: {off:e} of the displacement");
                assert!(
                    stress < tolerance && energy < 1e-12,
                    "{label}: stress {stress:e}, energy {energy:e}"
                );
            }
        }
    }
}

/// A layup of plies of `carbon`, or of other materials, with 0° along the arc.
fn layup(element: ElementKind, plies: &[(&str, f64)]) -> Section {
    let ply = |&(material, angle): &(&str, f64)| LayupPly {
        material: Some(material.into()),
        angle,
        thickness: Some(THICKNESS / plies.len() as f64),
    };
    let plies = plies.iter().map(ply).collect();
    let layup = Layup { plies, direction: [0.0, 1.0, 0.0], ..Layup::default() };
    Section { element, layup: Some(layup), ..Section::new("", 0.0) }
}

/// Change of the distance of the ends of an arc of 32 × 4 elements that is heated by one degree.
fn opening(element: ElementKind, plies: &[(&str, f64)], linear: bool) -> f64 {
    let mut m = heated(free(cylinder([32, 4], 0.0), layup(element, plies), linear), 1.0);
    let carbon = Orthotropic {
        young: [100.0 * YOUNG, 8.0 * YOUNG, 8.0 * YOUNG],
        poisson: [0.3, 0.3, 0.4],
        shear: [4.0 * YOUNG, 4.0 * YOUNG, 3.0 * YOUNG],
        density: 1.0,
        expansion: [1e-6, 3e-5, 3e-5],
        strength: None,
    };
    m.materials.insert("carbon".into(), Material::Orthotropic(carbon));
    for (name, expansion) in [("brass", 2e-5), ("steel", 1e-5)] {
        let metal = Isotropic { expansion, ..Isotropic::new(100.0 * YOUNG, 0.3, 1.0) };
        m.materials.insert(name.into(), Material::Isotropic(metal));
        let tough = Plastic { young: 100.0 * YOUNG, yield_stress: YOUNG, expansion, ..tough() };
        m.materials.insert(format!("tough {name}"), Material::Plastic(tough));
    }
    let (mesh, system, outcome) = common::solve(&m);
    common::displacement(&mesh, &system, &outcome.state.u, "u_max_v_min").y
}

/// An arc of radius 1 and angle θ that expands by e along itself and by e_z across the thickness keeps e_z of its radius and
/// changes its angle by θ (e − e_z).
#[test]
fn arcs_spring_in_by_the_difference_of_expansions() {
    let (half, e, e_z) = (std::f64::consts::FRAC_PI_4, 1e-6, 3e-5);
    let exact = 2.0 * half.sin() * e_z + 2.0 * half.cos() * half * (e - e_z);
    for element in [ElementKind::Ems, ElementKind::Mitc4] {
        let found = opening(element, &[("carbon", 0.0)], true);
        assert!((found / exact - 1.0).abs() < 1e-2, "{element:?}: {found:e} for {exact:e}");
    }
}

/// Plies of unlike expansion: a symmetric cross-ply, which springs in by its expansion across the thickness, contraction of
/// the plies included, and a bimetal.
#[test]
fn heated_laminated_arcs_open_as_with_three_dimensional_stresses() {
    let cross = [("carbon", 0.0), ("carbon", 90.0), ("carbon", 90.0), ("carbon", 0.0)];
    let outside = [("carbon", 90.0), ("carbon", 0.0), ("carbon", 0.0), ("carbon", 90.0)];
    let angle = [("carbon", 45.0), ("carbon", -45.0), ("carbon", -45.0), ("carbon", 45.0)];
    let bimetal = [("brass", 0.0), ("steel", 0.0)];
    for plies in [&cross[..], &outside[..], &angle[..], &bimetal[..]] {
        let exact = opening(ElementKind::Cm, plies, true);
        for element in [ElementKind::Ems, ElementKind::Mitc4] {
            let found = opening(element, plies, true);
            assert!((found / exact - 1.0).abs() < 1e-3, "{element:?} {plies:?}: {found:e} for {exact:e}");
        }
    }
}

/// Layers are integrated over the thickness where they could yield.
#[test]
fn heated_arcs_of_layers_that_could_yield_open_as_elastic_ones() {
    for element in [ElementKind::Ems, ElementKind::Mitc4] {
        let exact =
            opening(element, &[("brass", 0.0), ("steel", 0.0), ("steel", 0.0), ("brass", 0.0)], false);
        let plies = ["tough brass", "tough steel", "tough steel", "tough brass"].map(|name| (name, 0.0));
        let found = opening(element, &plies, false);
        assert!((found / exact - 1.0).abs() < 1e-7, "{element:?}: {found:e} for {exact:e}");
    }
}

/// Natural strains are those of every fibre: uniform growth along an arc that does not thicken it changes its angle in
/// proportion.
#[test]
fn growth_along_an_arc_changes_its_angle() {
    let (half, e) = (std::f64::consts::FRAC_PI_4, 1e-4);
    for element in [ElementKind::Ems, ElementKind::Mitc4, ElementKind::Cm] {
        let section = Section { element, ..Section::new("metal", THICKNESS) };
        let mut m = free(cylinder([32, 4], 0.0), section, true);
        m.prescribed_strains = vec![PrescribedStrain::Natural(NaturalStrain {
            distribution: None,
            on: "all".into(),
            strain: [e, 0.0, 0.0],
            curvature: [0.0; 3],
            direction: [0.0, 1.0, 0.0],
            amplitude: None,
        })];
        let (mesh, system, outcome) = common::solve(&m);
        let found = common::displacement(&mesh, &system, &outcome.state.u, "u_max_v_min").y;
        let exact = 2.0 * half.cos() * half * e;
        assert!((found / exact - 1.0).abs() < 1e-2, "{element:?}: {found:e} for {exact:e}");
    }
}
