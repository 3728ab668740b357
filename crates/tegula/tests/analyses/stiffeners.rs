//! Beams whose nodes carry the nodes of a shell: eccentric stiffeners.

use crate::common::{Notes, displacement, model, on, plate, vector_load};

use std::f64::consts::PI;
use tegula::analysis::{Silent, dynamics, modal, statics};
use tegula::model::*;
use tegula::{Mesh, System};

const YOUNG: f64 = 2.1e11;
const DENSITY: f64 = 7800.0;
/// Width and thickness of the plate, height and width of the rib below it.
const PLATE: [f64; 2] = [0.1, 0.01];
const RIB: [f64; 2] = [0.03, 0.005];

/// A strip of length 1 with a rib along its middle, from the mesh line at y = 0.05; the nodes of the line with x above `from` are attached.
fn stiffened(elements: u32, from: f64) -> Model {
    let mut m = model(plate([1.0, PLATE[0]], [elements, 4], 0.0), YOUNG, PLATE[1]);
    let steel = Isotropic { young: YOUNG, poisson: 0.0, density: DENSITY, expansion: 0.0, strength: None };
    let name = m.sections[0].material.clone();
    m.materials.insert(name.clone(), Material::Isotropic(steel));
    m.sets = vec![MeshSet::Box(BoxSet {
        name: "line".into(),
        x: Some([from, 1.0]),
        y: Some([0.05, 0.05]),
        z: None,
        within: "all".into(),
        tolerance: None,
    })];
    let depth = -0.5 * (PLATE[1] + RIB[0]);
    let ends = [[0.0, 0.05, depth], [1.0, 0.05, depth]];
    let section = BeamSection::Rectangle(RectangularSection { size: RIB });
    m.beams = vec![Beam {
        material: Some(name),
        attached: vec!["line".into()],
        ..Beam::straight("rib", ends, elements, [0.0, 0.0, 1.0], section)
    }];
    m
}

fn mesh_of(m: &Model) -> Mesh {
    let mut mesh = tegula::mesh::generators::generate(&m.mesh).unwrap();
    assert!(tegula::compile::define_sets(&m.sets, &mut mesh).is_empty());
    mesh
}

fn compile(m: &Model) -> (Mesh, System) {
    let mesh = mesh_of(m);
    let system = tegula::compile::build(m, &mesh).unwrap();
    (mesh, system)
}

/// The strip is clamped at one end, the rib by a joint.
fn cantilever(elements: u32) -> Model {
    let mut m = stiffened(elements, 0.01);
    let root = PointJoint {
        name: "root".into(),
        between: ["ground".into(), "rib.start".into()],
        at: m.beams[0].points[0],
        second_at: None,
    };
    m.joints = vec![Joint::Fixed(root)];
    m.conditions = vec![Condition::Clamp(on("u_min"))];
    m
}

/// Bending stiffness of the T-section of strip and rib about its own centre, and its mass per length.
fn section() -> [f64; 2] {
    let [strip, rib] = [PLATE, RIB].map(|[a, b]| a * b);
    let depth = -0.5 * (PLATE[1] + RIB[0]);
    let centre = depth * rib / (strip + rib);
    let own = PLATE[0] * PLATE[1].powi(3) / 12.0 + RIB[1] * RIB[0].powi(3) / 12.0;
    let second = own + strip * centre * centre + rib * (depth - centre) * (depth - centre);
    [YOUNG * second, DENSITY * (strip + rib)]
}

/// The shear of both parts adds some 0.2 %.
#[test]
fn a_ribbed_strip_bends_as_a_beam_with_the_t_section() {
    let [bending, mass] = section();
    let mut m = cantilever(20);
    m.analysis = Analysis::Static(StaticAnalysis::default());
    m.loads = vec![Load::Edge(vector_load("u_max", [0.0, 0.0, -10.0]))];
    let (mesh, system) = compile(&m);
    let outcome = statics::run(&system, &StaticAnalysis::default(), None, &mut Silent).unwrap();
    let deflection = displacement(&mesh, &system, &outcome.state.u, "u_max_v_max").z;
    let exact = -1.0 / (3.0 * bending);
    assert!((deflection / exact - 1.0).abs() < 3e-3, "{deflection:e} {exact:e}");

    let m = Model { analysis: Analysis::Modal(ModalAnalysis::new(1)), loads: Vec::new(), ..m };
    let (_, system) = compile(&m);
    let frequency = modal::run(&system, 1, None, &mut Silent).unwrap().modes[0].frequency_hz;
    let exact = 1.875_104_f64.powi(2) / (2.0 * PI) * (bending / mass).sqrt();
    assert!((frequency / exact - 1.0).abs() < 3e-3, "{frequency} {exact}");
}

#[test]
fn a_free_ribbed_strip_keeps_energy_and_momenta() {
    let mut m = stiffened(8, 0.0);
    m.conditions.clear();
    let scheme = Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 });
    let analysis = TransientAnalysis { scheme, time_step: Some(2e-4), ..TransientAnalysis::new(0.02) };
    m.analysis = Analysis::Transient(analysis.clone());
    m.initial_velocities = vec![InitialVelocity {
        on: "model".into(),
        velocity: [1.0, -2.0, 3.0],
        angular_velocity: [50.0, 20.0, -30.0],
        center: [0.4, 0.0, 0.0],
    }];
    let mut notes = Notes::keeping();
    let (_, system) = compile(&m);
    dynamics::run(&system, &analysis, None, &mut notes).unwrap();
    notes.assert_conserved(1e-10);
}

#[test]
fn nodes_between_those_of_a_beam_and_unknown_sets_are_refused() {
    let refused = |change: &dyn Fn(&mut Beam)| {
        let mut m = cantilever(20);
        m.analysis = Analysis::Static(StaticAnalysis::default());
        m.loads = vec![Load::Edge(vector_load("u_max", [0.0, 0.0, -10.0]))];
        change(&mut m.beams[0]);
        tegula::compile::build(&m, &mesh_of(&m)).map(|_| ()).unwrap_err().to_string()
    };
    let text = refused(&|beam| beam.elements = Some(15));
    assert!(
        text.contains("beams[0].attached[0]") && text.contains("before or behind the nearest node"),
        "{text}"
    );
    let text = refused(&|beam| beam.attached = vec!["nowhere".into()]);
    assert!(text.contains("beams[0].attached[0]") && text.contains("nowhere"), "{text}");
    let text = refused(&|beam| beam.attached = vec!["u_min".into(), "line".into()]);
    assert!(text.contains("is attached to body \"rib.start\", with which it moves"), "{text}");
}

/// Elements two of whose corners belong to one cross-section would be rigid across the beam.
#[test]
fn stiffeners_on_more_than_a_line_and_cuts_beside_them_are_warned_of() {
    let warned = |change: &dyn Fn(&mut Model)| {
        let mut m = cantilever(20);
        m.analysis = Analysis::Static(StaticAnalysis::default());
        m.loads = vec![Load::Edge(vector_load("u_max", [0.0, 0.0, -10.0]))];
        change(&mut m);
        let (mesh, system) = compile(&m);
        let found = tegula::compile::warnings(&m, &mesh, &system);
        found.iter().map(|issue| format!("{}: {}", issue.place.key, issue.message)).collect::<Vec<_>>()
    };
    assert!(warned(&|_| ()).is_empty(), "{:?}", warned(&|_| ()));
    let found = warned(&|m| {
        let MeshSet::Box(line) = &mut m.sets[0] else { unreachable!() };
        line.y = Some([0.05, 0.075]);
    });
    assert!(
        found.len() == 1 && found[0].starts_with("beams[0].attached: two corners of element"),
        "{found:?}"
    );
}

/// A joint between a cross-section and the node that it carries has nothing to hold.
#[test]
fn joints_between_a_beam_and_its_own_node_are_refused() {
    let mut m = cantilever(20);
    m.analysis = Analysis::Static(StaticAnalysis::default());
    m.loads = vec![Load::Edge(vector_load("u_max", [0.0, 0.0, -10.0]))];
    m.sets.push(MeshSet::Box(BoxSet {
        name: "node".into(),
        x: Some([0.5, 0.5]),
        y: Some([0.05, 0.05]),
        z: None,
        within: "all".into(),
        tolerance: None,
    }));
    m.joints.push(Joint::Spherical(PointJoint {
        name: "ball".into(),
        between: ["rib.10".into(), "node".into()],
        at: [0.5, 0.05, 0.0],
        second_at: None,
    }));
    let refused = tegula::compile::build(&m, &mesh_of(&m)).map(|_| ()).unwrap_err().to_string();
    assert!(
        refused.contains("the joint \"ball\" is between body \"rib.10\" and a node that is attached to it"),
        "{refused}"
    );
}
