//! Loads of a caller that are evaluated for all their nodes together, against beam theory and the decay of a damped mass.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::common::{model, on, plate, vector_load};
use crate::multibody::{body, machine};
use tegula::analysis::{Silent, dynamics, statics};
use tegula::compile::Compiler;
use tegula::element::Nodal;
use tegula::load::{Dependence, FieldLoad, LoadPoint};
use tegula::mesh::generators::generate;
use tegula::model::*;
use tegula::result::ReactionFinder;
use tegula::{Error, Mesh, System};

const YOUNG: f64 = 2.1e11;
const THICKNESS: f64 = 0.01;

/// Springs to the ground and dampers along z, shared evenly by the nodes.
#[derive(Debug, Default)]
struct Springs {
    stiffness: f64,
    damping: f64,
    calls: AtomicUsize,
}

impl FieldLoad for Springs {
    fn dependence(&self) -> Dependence {
        if self.damping == 0.0 { Dependence::Positions } else { Dependence::Velocities }
    }

    fn forces(&self, at: &LoadPoint, out: &mut [Nodal]) {
        self.calls.fetch_add(1, Ordering::SeqCst);
        let share = 1.0 / out.len() as f64;
        for ((f, x), v) in out.iter_mut().zip(at.positions).zip(at.velocities) {
            *f = [0.0, 0.0, -share * (self.stiffness * x.z + self.damping * v.z)];
        }
    }
}

/// System of a model with a load of the caller on the nodes of a set.
fn with_load(model: &Model, mesh: &Mesh, set: &str, load: Arc<dyn FieldLoad>) -> tegula::Result<System> {
    let mut compiler = Compiler::with_own_parts(model, mesh, &Default::default(), true)?;
    let nodes = mesh.nodes_on(set).unwrap();
    let vectors = nodes.iter().map(|&n| compiler.vectors_of(n).unwrap()[0]).collect();
    compiler.add_field_load("springs", vectors, load);
    compiler.system(0, None)
}

/// Cantilever of 1 × 0.1 under a force on its end.
fn cantilever(force: f64) -> Model {
    let mut m = model(plate([1.0, 0.1], [20, 2], 0.0), YOUNG, THICKNESS);
    if let Some(Material::Isotropic(material)) = m.materials.values_mut().next() {
        material.poisson = 0.0;
    }
    m.conditions = vec![Condition::Clamp(on("u_min"))];
    if force != 0.0 {
        m.loads = vec![Load::Edge(vector_load("u_max", [0.0, 0.0, force / 0.1]))];
    }
    m
}

#[test]
fn springs_under_the_end_of_a_cantilever_carry_their_share() {
    let (force, spring) = (20.0, 2e3);
    let m = cantilever(force);
    let mesh = generate(&m.mesh).unwrap();
    let load = Arc::new(Springs { stiffness: spring, ..Springs::default() });
    let system = with_load(&m, &mesh, "u_max", load.clone()).unwrap();
    let options = StaticAnalysis::default();
    let outcome = statics::run(&system, &options, None, &mut Silent).unwrap();

    // The springs see the mean of the nodes, whose deflections differ in the last digits.
    let end = mesh.nodes_on("u_max").unwrap();
    let of_node = |&n: &u32| outcome.state.u[system.coordinates.position_of[n as usize] as usize][2];
    let deflection = end.iter().map(of_node).sum::<f64>() / end.len() as f64;
    let beam = 3.0 * YOUNG * 0.1 * THICKNESS.powi(3) / 12.0;
    assert!((deflection * (beam + spring) / force - 1.0).abs() < 5e-3);
    // The reaction of the springs is a load of its own in the balance of forces.
    let found = ReactionFinder::new(&system, None).find(&system, None, &outcome.state);
    let taken = found.loads.last().unwrap().force.z;
    assert!((taken + spring * deflection).abs() < 1e-9 * force);
    assert!(found.force_error < 1e-9);
    // Newton's method converges as without springs: their stiffness is in the tangent.
    let plain = Compiler::new(&m, &mesh).unwrap().system(0, None).unwrap();
    let without = statics::run(&plain, &options, None, &mut Silent).unwrap();
    assert!(outcome.statistics.iterations <= without.statistics.iterations + 1);
    // An evaluation serves all nodes and, where the motion is the same, all who ask.
    assert!(load.calls.load(Ordering::SeqCst) < 40);
}

#[test]
fn a_load_needs_no_other_load() {
    let m = cantilever(0.0);
    let mesh = generate(&m.mesh).unwrap();
    let load = Arc::new(Springs { stiffness: 1.0, ..Springs::default() });
    assert!(with_load(&m, &mesh, "u_max", load).is_ok());
    assert!(matches!(Compiler::new(&m, &mesh), Err(Error::Model(_))));
}

#[test]
fn a_damper_slows_a_mass_down_in_all_schemes() {
    let (mass, damping, end) = (2.0, 8.0, 0.5);
    for scheme in ["energy-momentum", "generalized-alpha", "hht", "bdf2"] {
        let scheme: Scheme = serde_json::from_value(serde_json::json!({ "type": scheme })).unwrap();
        let point = RigidBody { velocity: [0.0, 0.0, 3.0], ..body("mass", [1.0, 0.0, 0.0], mass, None) };
        let mut m = machine(end, 5e-3, vec![point], Vec::new());
        let Analysis::Transient(options) = &mut m.analysis else { unreachable!() };
        options.scheme = scheme;
        let options = options.clone();
        let mesh = Mesh::default();
        let mut compiler = Compiler::with_own_parts(&m, &mesh, &Default::default(), true).unwrap();
        let centre = compiler.centre_of_body("mass").unwrap();
        compiler.add_field_load("damper", vec![centre], Arc::new(Springs { damping, ..Springs::default() }));
        let system = compiler.system(0, None).unwrap();
        let state = dynamics::run(&system, &options, None, &mut Silent).unwrap().state;
        let exact = 3.0 * (-damping / mass * end).exp();
        let velocity = state.v[centre as usize][2];
        // Relative error c/m · t (Δt c/m)²/12 of the trapezoidal rule: 7e-5; that of other rules is a small multiple.
        assert!((velocity / exact - 1.0).abs() < 5e-4, "{:?}: {velocity} for {exact}", options.scheme);
        // What the damper takes is the kinetic energy that is lost.
        let lost = 0.5 * mass * (9.0 - velocity * velocity);
        assert!((state.work + lost).abs() < 1e-3 * lost, "{:?}", options.scheme);
    }
}

#[test]
fn a_load_on_the_motion_is_refused_in_linear_modal_and_buckling_analyses() {
    let analyses = [
        Analysis::Static(StaticAnalysis { linear: true, ..StaticAnalysis::default() }),
        Analysis::Buckling(BucklingAnalysis::new(1)),
        Analysis::Modal(ModalAnalysis::new(1)),
    ];
    for analysis in analyses {
        let m = Model { analysis, ..cantilever(1.0) };
        let mesh = generate(&m.mesh).unwrap();
        let load = Arc::new(Springs { stiffness: 1.0, ..Springs::default() });
        let Err(Error::Model(issues)) = with_load(&m, &mesh, "u_max", load) else { panic!("it is taken") };
        assert!(issues[0].message.contains("the load \"springs\" of the caller"), "{}", issues[0]);
    }
}

#[test]
fn a_load_that_cannot_be_evaluated_ends_the_analysis() {
    let m = cantilever(1.0);
    let mesh = generate(&m.mesh).unwrap();
    let load = Arc::new(Springs { stiffness: f64::NAN, ..Springs::default() });
    let system = with_load(&m, &mesh, "u_max", load).unwrap();
    assert!(statics::run(&system, &StaticAnalysis::default(), None, &mut Silent).is_err());
}
