//! Loads of a caller that are evaluated for all their nodes together, against beam theory and the decay of a damped mass.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::common::{model, on, plate, vector_load};
use crate::multibody::{body, machine};
use tegula::analysis::{Observer, Silent, Step, dynamics, modal, statics};
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

/// Motion of a point mass under a load of the caller: its system, options, and the nodal vector of the mass.
fn mass_under(
    scheme: &str,
    point: RigidBody,
    [end, step]: [f64; 2],
    load: Arc<dyn FieldLoad>,
) -> (System, TransientAnalysis, usize) {
    let mut m = machine(end, step, vec![point], Vec::new());
    let Analysis::Transient(options) = &mut m.analysis else { unreachable!() };
    options.scheme = serde_json::from_value(serde_json::json!({ "type": scheme })).unwrap();
    let options = options.clone();
    let mesh = Mesh::default();
    let mut compiler = Compiler::with_own_parts(&m, &mesh, &Default::default(), true).unwrap();
    let centre = compiler.centre_of_body("mass").unwrap();
    compiler.add_field_load("own", vec![centre], load);
    (compiler.system(0, None).unwrap(), options, centre as usize)
}

#[test]
fn a_damper_slows_a_mass_down_in_all_schemes() {
    let (mass, damping, end) = (2.0, 8.0, 0.5);
    for scheme in ["energy-momentum", "generalized-alpha", "hht", "bdf2"] {
        let point = RigidBody { velocity: [0.0, 0.0, 3.0], ..body("mass", [1.0, 0.0, 0.0], mass, None) };
        let load = Arc::new(Springs { damping, ..Springs::default() });
        let (system, options, centre) = mass_under(scheme, point, [end, 5e-3], load);
        let state = dynamics::run(&system, &options, None, &mut Silent).unwrap().state;
        let exact = 3.0 * (-damping / mass * end).exp();
        let velocity = state.v[centre][2];
        // Relative error c/m · t (Δt c/m)²/12 of the trapezoidal rule: 7e-5; that of other rules is a small multiple.
        assert!((velocity / exact - 1.0).abs() < 5e-4, "{scheme}: {velocity} for {exact}");
        // What the damper takes is the kinetic energy that is lost.
        let lost = 0.5 * mass * (9.0 - velocity * velocity);
        assert!((state.work + lost).abs() < 1e-3 * lost, "{scheme}");
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

/// One-sided stop at z = 0.
#[derive(Debug)]
struct Stop(f64);

impl FieldLoad for Stop {
    fn dependence(&self) -> Dependence {
        Dependence::Positions
    }

    fn forces(&self, at: &LoadPoint, out: &mut [Nodal]) {
        for (f, x) in out.iter_mut().zip(at.positions) {
            *f = [0.0, 0.0, if x.z >= 0.0 { 0.0 } else { -self.0 * x.z }];
        }
    }
}

#[derive(Default)]
struct Warned(Vec<String>);

impl Observer for Warned {
    fn on_step(&mut self, _: &Step) -> tegula::Result<()> {
        Ok(())
    }

    fn on_warning(&mut self, message: &str) {
        self.0.push(message.into());
    }
}

/// A mass that runs into a stop within one long step may gain a multiple of its energy: it is told. Short steps and springs of constant stiffness are not.
#[test]
fn work_that_steps_do_not_resolve_is_told() {
    let cases: [(f64, Arc<dyn FieldLoad>, bool); 3] = [
        (0.21, Arc::new(Stop(1e4)), true),
        (1e-3, Arc::new(Stop(1e4)), false),
        (0.21, Arc::new(Springs { stiffness: 1e4, ..Springs::default() }), false),
    ];
    for scheme in ["energy-momentum", "explicit"] {
        for (step, load, told) in cases.clone() {
            let at = if told { 1.0 } else { 0.1 };
            let point = RigidBody { velocity: [0.0, 0.0, -1.0], ..body("mass", [0.0, 0.0, at], 1.0, None) };
            let (system, options, _) = mass_under(scheme, point, [7.0 * 0.21, step], load);
            let mut warned = Warned::default();
            // An unstable explicit run ends with an error, behind the warning.
            let outcome = dynamics::run(&system, &options, None, &mut warned);
            assert!(outcome.is_ok() || scheme == "explicit");
            let count = warned.0.iter().filter(|text| text.contains("the load \"own\"")).count();
            assert_eq!(count, usize::from(told), "{scheme} {step}: {:?}", warned.0);
        }
    }
}

/// Spring between the nodes of a set: the force on each of them depends on the others.
#[derive(Debug)]
struct Between;

impl FieldLoad for Between {
    fn dependence(&self) -> Dependence {
        Dependence::Positions
    }

    fn forces(&self, at: &LoadPoint, out: &mut [Nodal]) {
        let mean = at.positions.iter().map(|x| x.z).sum::<f64>() / out.len() as f64;
        for (f, x) in out.iter_mut().zip(at.positions) {
            *f = [0.0, 0.0, -100.0 * (x.z - mean)];
        }
    }
}

/// Lowest mode of a cantilever with a load on the nodes of its end, about the equilibrium.
fn mode_with(load: impl FieldLoad + 'static) -> tegula::Result<()> {
    let analysis = Analysis::Modal(ModalAnalysis { prestressed: true, ..ModalAnalysis::new(1) });
    let m = Model { analysis, ..cantilever(1e-3) };
    let mesh = generate(&m.mesh).unwrap();
    let system = with_load(&m, &mesh, "u_max", Arc::new(load)).unwrap();
    let state = modal::prestress(&system, &mut Silent).unwrap().state;
    modal::run(&system, 1, Some(&state), &mut Silent).map(|_| ())
}

#[test]
fn modes_are_refused_where_forces_depend_on_other_nodes() {
    assert!(mode_with(Springs { stiffness: 100.0, ..Springs::default() }).is_ok());
    let refused = mode_with(Between).unwrap_err().to_string();
    assert!(refused.contains("the load \"springs\" depend on the motion of other nodes"), "{refused}");
}

/// Springs that give their stiffness, wrong by a factor; their forces are those of single precision if wanted.
#[derive(Debug)]
struct GivenStiffness {
    springs: Springs,
    factor: f64,
    single: bool,
}

impl FieldLoad for GivenStiffness {
    fn dependence(&self) -> Dependence {
        Dependence::Positions
    }

    fn forces(&self, at: &LoadPoint, out: &mut [Nodal]) {
        self.springs.forces(at, out);
        if self.single {
            out.as_flattened_mut().iter_mut().for_each(|f| *f = f64::from((1e-3 + *f) as f32) - 1e-3);
        }
    }

    fn stiffness(&self, _: &LoadPoint, weights: [f64; 2], out: &mut [tegula::Mat3]) {
        let share = self.factor * weights[0] * self.springs.stiffness / out.len() as f64;
        out.fill(tegula::Mat3::zeros());
        out.iter_mut().for_each(|block| block[(2, 2)] = share);
    }
}

#[test]
fn modes_are_refused_where_the_stiffness_is_not_the_derivative_of_the_forces() {
    let modes = |factor: f64, single: bool| {
        let springs = Springs { stiffness: 100.0, ..Springs::default() };
        mode_with(GivenStiffness { springs, factor, single })
    };
    assert!(modes(1.0, false).is_ok() && modes(1.0, true).is_ok());
    for factor in [0.0, 0.99, 10.0, -1.0] {
        let refused = modes(factor, false).unwrap_err().to_string();
        assert!(
            refused.contains("stiffness that the load \"springs\" gives is not the derivative"),
            "{refused}"
        );
    }
}

/// Springs whose forces are computed from positions of single precision, at a height of 100, without a function of their stiffness.
#[derive(Debug)]
struct CoarseSprings {
    stiffness: f64,
    single: bool,
}

impl FieldLoad for CoarseSprings {
    fn dependence(&self) -> Dependence {
        Dependence::Positions
    }

    fn forces(&self, at: &LoadPoint, out: &mut [Nodal]) {
        let height = |z: f64| if self.single { f64::from((z + 100.0) as f32) } else { z + 100.0 };
        let share = self.stiffness / out.len() as f64;
        out.iter_mut().zip(at.positions).for_each(|(f, x)| *f = [0.0, 0.0, share * (100.0 - height(x.z))]);
    }
}

#[test]
fn modes_are_refused_where_differences_of_the_forces_are_round_off() {
    let modes = |single: bool| mode_with(CoarseSprings { stiffness: 100.0, single });
    assert!(modes(false).is_ok());
    let refused = modes(true).unwrap_err().to_string();
    assert!(
        refused.contains("load \"springs\" is not known") && refused.contains("double precision"),
        "{refused}"
    );
}

/// Dry friction by the sign of the velocity.
#[derive(Debug)]
struct DryFriction;

impl FieldLoad for DryFriction {
    fn dependence(&self) -> Dependence {
        Dependence::Velocities
    }

    fn forces(&self, at: &LoadPoint, out: &mut [Nodal]) {
        out.iter_mut().zip(at.velocities).for_each(|(f, v)| *f = v.map(|v| -3.0 * v.signum()).into());
    }
}

/// Asks to stop at the first warning.
#[derive(Default)]
struct StopsAtWarning(Vec<String>);

impl Observer for StopsAtWarning {
    fn on_step(&mut self, _: &Step) -> tegula::Result<()> {
        Ok(())
    }

    fn on_warning(&mut self, message: &str) {
        self.0.push(message.into());
    }

    fn interrupted(&self) -> bool {
        !self.0.is_empty()
    }
}

/// Where friction by the sign of the velocity has stopped a mass, steps become as short as round-off allows: it is told why.
#[test]
fn steps_that_a_jump_of_a_force_makes_ever_shorter_are_told() {
    let point = RigidBody { velocity: [0.0, 0.0, -1.0], ..body("mass", [0.0; 3], 1.0, None) };
    let (system, options, _) = mass_under("energy-momentum", point, [1.0, 5e-3], Arc::new(DryFriction));
    let mut warned = StopsAtWarning::default();
    let outcome = dynamics::run(&system, &options, None, &mut warned);
    assert!(matches!(outcome, Err(Error::Interrupted)), "{:?}", warned.0);
    assert!(warned.0[0].contains("a force of own may jump with the motion"), "{:?}", warned.0);
}
