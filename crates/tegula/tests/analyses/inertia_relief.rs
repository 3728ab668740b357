//! Inertia relief: models without supports under loads that their rigid acceleration balances, against closed forms.

use crate::common::{Notes, displacement, model, plate, solve, vector_load};
use crate::multibody::body;
use tegula::analysis::{State, dynamics, statics};
use tegula::model::*;
use tegula::result::reactions::ReactionFinder;
use tegula::{Error, Vec3};

const LENGTH: f64 = 1.0;
const WIDTH: f64 = 0.1;
const THICKNESS: f64 = 0.01;
const YOUNG: f64 = 7e10;
const DENSITY: f64 = 2700.0;
const MASS: f64 = DENSITY * LENGTH * WIDTH * THICKNESS;

/// A free strip without lateral contraction along x, from 0 to 1.
fn strip(elements: [u32; 2], linear: bool) -> Model {
    let mut m = model(plate([LENGTH, WIDTH], elements, 0.0), YOUNG, THICKNESS);
    m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(YOUNG, 0.0, DENSITY)));
    let options = StaticAnalysis { linear, inertia_relief: true, ..StaticAnalysis::default() };
    m.conditions.clear();
    m.analysis = Analysis::Static(options);
    m
}

/// A force per length of an edge.
fn edge(on: &str, value: [f64; 3]) -> Load {
    Load::Edge(vector_load(on, value))
}

/// Rigid acceleration, and the resultant forces at the added supports over the loads.
fn acceleration(system: &tegula::System, state: &State) -> (tegula::system::RigidAcceleration, f64) {
    let found = system.relief_acceleration(&state.u, state.time).unwrap();
    let forces = ReactionFinder::new(system, None).find(system, None, state);
    let set = system.support_sets.iter().position(|set| set.name == "inertia_relief").unwrap();
    let size = forces.loads.iter().map(|load| load.force.norm()).sum::<f64>();
    (found, forces.supports[set].force.norm() / size)
}

/// A force at the end of a bar: the tension `F x/L` lengthens it by `F L/(2 E A)`, linear or not (here 1.4e-7).
#[test]
fn a_bar_that_is_pulled_at_its_end_lengthens_by_half_of_one_that_is_held() {
    let load = 200.0;
    for linear in [true, false] {
        let mut m = strip([10, 2], linear);
        m.loads = vec![edge("u_max", [load / WIDTH, 0.0, 0.0])];
        let (mesh, system, outcome) = solve(&m);
        let [a, b] =
            ["u_min_v_min", "u_max_v_min"].map(|set| displacement(&mesh, &system, &outcome.state.u, set));
        let exact = 0.5 * load * LENGTH / (YOUNG * WIDTH * THICKNESS);
        assert!(((b - a).x / exact - 1.0).abs() < 1e-5, "{} {exact}", (b - a).x);
        let (found, reaction) = acceleration(&system, &outcome.state);
        assert!((found.linear - Vec3::new(load / MASS, 0.0, 0.0)).norm() < 1e-10 * load / MASS);
        assert!(found.angular.norm() < 1e-9 * load / MASS && reaction < 1e-10, "{found:?} {reaction}");
    }
}

/// Forces at both ends of a free beam: between them it bends as one on two props under its inertia forces q, by
/// `5 q L⁴/(384 E I) + q L²/(8 κ G A)`.
#[test]
fn a_beam_that_is_pushed_at_its_ends_bends_under_its_inertia_forces() {
    let load = 20.0;
    let q = load / LENGTH;
    let stiffness = YOUNG * WIDTH * THICKNESS.powi(3) / 12.0;
    let shear = 5.0 / 6.0 * 0.5 * YOUNG * WIDTH * THICKNESS;
    let exact = 5.0 * q * LENGTH.powi(4) / (384.0 * stiffness) + q * LENGTH * LENGTH / (8.0 * shear);
    let error = |n: u32| {
        let mut m = strip([n, 2], true);
        m.loads = ["u_min", "u_max"].map(|end| edge(end, [0.0, 0.0, 0.5 * load / WIDTH])).to_vec();
        let (mesh, system, outcome) = solve(&m);
        let at = |set: &str| displacement(&mesh, &system, &outcome.state.u, set).z;
        let (found, reaction) = acceleration(&system, &outcome.state);
        assert!(
            (found.linear.z * MASS / load - 1.0).abs() < 1e-10 && reaction < 1e-10,
            "{found:?} {reaction}"
        );
        0.5 * (at("u_min_v_min") + at("u_max_v_max")) - at("middle") - exact
    };
    let [coarse, fine] = [16, 32].map(|n| error(n) / exact);
    assert!(fine.abs() < 2e-3 && (coarse / fine - 4.0).abs() < 0.2, "{coarse} {fine}");
}

/// Gravity accelerates everything alike: a model falls without strain.
#[test]
fn a_model_falls_freely_without_strain() {
    for linear in [true, false] {
        let mut m = strip([8, 2], linear);
        let lump = body("lump", [1.2, 0.0, 0.1], 0.7, Some([2e-3, 3e-3, 4e-3]));
        m.bodies = vec![RigidBody { attached: vec!["u_max".into()], ..lump }];
        m.loads = vec![Load::Gravity(GravityLoad { value: [3.0, -4.0, -9.81], amplitude: None })];
        let (_, system, outcome) = solve(&m);
        let (found, _) = acceleration(&system, &outcome.state);
        let balance = ReactionFinder::new(&system, None).find(&system, None, &outcome.state);
        assert!(
            balance.force_error < 1e-12 && balance.moment_error < 1e-12,
            "loads that inertia cancels everywhere"
        );
        assert!((found.linear - Vec3::new(3.0, -4.0, -9.81)).norm() < 1e-12, "{found:?}");
        let exact = (Vec3::new(0.5 * LENGTH, 0.5 * WIDTH, 0.0) * MASS + Vec3::new(1.2, 0.0, 0.1) * 0.7)
            / (MASS + 0.7);
        assert!((found.centre - exact).norm() < 1e-9, "{found:?} {exact}");
        assert!(
            found.angular.norm() < 1e-12 && outcome.balance.strain < 1e-20,
            "{found:?} {:?}",
            outcome.balance
        );
    }
}

/// The acceleration of the centre of mass is force over mass where a body carries an edge off its place, too.
#[test]
fn a_body_beside_its_patch_accelerates_by_force_over_mass() {
    for linear in [true, false] {
        let mut m = strip([2, 1], linear);
        let hub = RigidBody { mass: None, inertia: None, ..body("hub", [-0.1, 0.25, 0.05], 1.0, None) };
        m.bodies = vec![RigidBody { attached: vec!["u_min".into()], ..hub }];
        m.loads = vec![Load::Force(vector_load("hub", [1.0, 2.0, 30.0]))];
        let (_, system, outcome) = solve(&m);
        let (found, reaction) = acceleration(&system, &outcome.state);
        let error = found.linear * MASS - Vec3::new(1.0, 2.0, 30.0);
        assert!(error.norm() < 1e-9 && reaction < 1e-9, "{found:?} {reaction}");
    }
}

/// Behind a step with a clamp its release is balanced from the start, also where the strip has bent by more than half a right angle. The
/// loads end in the state that inertia relief alone finds; where the clamp has turned the strip under them, this is another one.
#[test]
fn inertia_relief_goes_on_from_a_clamped_step() {
    for (line_load, turns) in [(20.0, false), (2e4, true)] {
        let mut m = strip([8, 2], false);
        let relief = m.analysis.clone();
        let load = || vec![edge("u_max", [0.0, 0.0, line_load])];
        m.loads = load();
        let alone = solve(&m).2.balance.strain;
        let clamp = Condition::Clamp(OnSet { on: "u_min".into() });
        let first = AnalysisStep::new("clamped", Analysis::Static(StaticAnalysis::default()));
        let second = AnalysisStep { loads: load(), ..AnalysisStep::new("free", relief.clone()) };
        m.steps = vec![AnalysisStep { loads: load(), conditions: vec![clamp], ..first }, second];
        m.loads.clear();
        let mesh = tegula::mesh::generators::generate(&m.mesh).unwrap();
        let compiler = tegula::compile::Compiler::new(&m, &mesh).unwrap();
        let system = compiler.system(0, None).unwrap();
        let bent =
            statics::run(&system, &StaticAnalysis::default(), None, &mut Notes::default()).unwrap().state;
        let end = displacement(&mesh, &system, &bent.u, "u_max_v_min");
        assert_eq!(end.z > 0.5 * LENGTH, turns, "{end}");
        let free = compiler.system(1, Some(bent.end_of_step())).unwrap();
        let Analysis::Static(options) = &relief else { panic!() };
        let held = |state: &State| {
            let forces = ReactionFinder::new(&free, None).find(&free, None, state);
            let sizes = forces.supports.iter().map(|support| support.force.norm());
            sizes.fold(0.0, tegula::norm::larger) / (line_load * WIDTH)
        };
        assert!(held(&statics::first_state(&free, options)) < 1e-6);
        let end = statics::run(&free, options, None, &mut Notes::default()).unwrap();
        assert!(held(&end.state) < 1e-8);
        assert!(turns || (end.balance.strain / alone - 1.0).abs() < 1e-3, "{} {alone}", end.balance.strain);
    }
}

/// A force that bends a free strip by a quarter of its length, off its axis: neither forces nor moments reach the added supports, and
/// the energy is that of the same model anywhere else.
#[test]
fn a_strip_that_bends_far_is_in_balance_with_its_inertia() {
    let energy = |u_axis: [f64; 3], v_axis: [f64; 3], load: [f64; 3]| {
        let mut m = strip([16, 2], false);
        let MeshSource::Plate(mesh) = &mut m.mesh else { panic!() };
        (mesh.origin, mesh.u_axis, mesh.v_axis) = ([3.0, -2.0, 5.0], u_axis, v_axis);
        m.loads = vec![edge("u_min", load)];
        let (_, system, outcome) = solve(&m);
        let (found, reaction) = acceleration(&system, &outcome.state);
        assert!(reaction < 1e-9, "{reaction}");
        assert!((found.linear.norm() * MASS / (4e4 * WIDTH) - 1.0).abs() < 1e-9, "{found:?}");
        let forces = ReactionFinder::new(&system, None).find(&system, None, &outcome.state);
        assert!(forces.force_error < 1e-9 && forces.moment_error < 1e-9);
        (outcome.balance.strain, outcome.statistics.iterations)
    };
    let (one, iterations) = energy([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 4e4]);
    let (other, _) = energy([0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-4e4, 0.0, 0.0]);
    assert!((one / other - 1.0).abs() < 1e-9, "{one} {other}");
    assert!(iterations < 60, "{iterations}");
}

/// A plane of symmetry stays: half of the bar moves and lengthens as the whole one.
#[test]
fn planes_of_symmetry_leave_the_motion_along_them() {
    let mut m = strip([10, 2], true);
    m.conditions = vec![Condition::Symmetry(SymmetryPlane { on: "v_min".into(), normal: [0.0, 1.0, 0.0] })];
    m.loads = vec![edge("u_max", [200.0 / WIDTH, 0.0, 0.0])];
    let (mesh, system, outcome) = solve(&m);
    assert_eq!(system.inertia_relief.as_ref().unwrap().motions.len(), 3);
    let [a, b] =
        ["u_min_v_min", "u_max_v_min"].map(|set| displacement(&mesh, &system, &outcome.state.u, set));
    let exact = 0.5 * 200.0 * LENGTH / (YOUNG * WIDTH * THICKNESS);
    assert!(((b - a).x / exact - 1.0).abs() < 1e-9, "{} {exact}", (b - a).x);
}

/// A motion that begins where inertia relief ends accelerates like a rigid body.
#[test]
fn a_motion_behind_inertia_relief_accelerates_without_vibration() {
    let mut m = strip([10, 2], false);
    let load = || vec![edge("u_min", [100.0, 0.0, 300.0])];
    let options = TransientAnalysis {
        scheme: Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 }),
        time_step: Some(1e-4),
        ..TransientAnalysis::new(1e-3)
    };
    let mut first = AnalysisStep::new("thrust", m.analysis.clone());
    first.loads = load();
    let mut second = AnalysisStep::new("flight", Analysis::Transient(options.clone()));
    second.loads = load();
    m.steps = vec![first, second];
    let mesh = tegula::mesh::generators::generate(&m.mesh).unwrap();
    let compiler = tegula::compile::Compiler::new(&m, &mesh).unwrap();
    let system = compiler.system(0, None).unwrap();
    let Analysis::Static(relief) = &m.analysis else { panic!() };
    let state = statics::run(&system, relief, None, &mut Notes::default()).unwrap().state;
    let rigid = system.relief_acceleration(&state.u, state.time).unwrap();
    let next = compiler.system(1, Some(state.end_of_step())).unwrap();
    let steps = dynamics::steps(&next, &options, None).unwrap();
    let moving = steps.reached().state.clone();
    for (v, kind) in system.coordinates.kinds.iter().enumerate() {
        let at = Vec3::from(system.coordinates.reference[v]) + Vec3::from(state.u[v]);
        let exact = match kind {
            tegula::system::VectorKind::Position => rigid.linear + rigid.angular.cross(&(at - rigid.centre)),
            _ => rigid.angular.cross(&at),
        };
        let found = Vec3::from(moving.a[v]);
        assert!(
            (found - exact).norm() < 1e-6 * tegula::norm::larger(rigid.linear.norm(), rigid.angular.norm()),
            "{v} {found} {exact}"
        );
    }
    let end = dynamics::run(&next, &options, None, &mut Notes::default()).unwrap();
    assert!(end.balance.kinetic > 0.0);
}

#[test]
fn parts_that_hold_a_model_with_inertia_relief_are_refused() {
    let message = |change: &dyn Fn(&mut Model)| {
        let mut m = strip([4, 2], false);
        m.loads = vec![edge("u_max", [1.0, 0.0, 0.0])];
        change(&mut m);
        let mesh = tegula::mesh::generators::generate(&m.mesh).unwrap();
        match tegula::compile::build(&m, &mesh) {
            Err(error @ Error::Model(_)) => error.to_string(),
            other => panic!("{:?}", other.is_ok()),
        }
    };
    let clamp = |m: &mut Model| m.conditions = vec![Condition::Clamp(OnSet { on: "u_min".into() })];
    assert!(message(&clamp).contains("the supports hold the model against all rigid motions"));
    let moved = |m: &mut Model| {
        let component = PrescribeComponent {
            on: "u_min".into(),
            of: NodalVector::Position,
            component: Axis::Z,
            value: 0.1,
            amplitude: None,
        };
        m.conditions = vec![Condition::Prescribe(component)];
    };
    assert!(message(&moved).contains("prescribed motions hold the model"));
    let jointed =
        |m: &mut Model| m.joints = vec![crate::multibody::spherical("ground", "u_min_v_min", [0.0; 3])];
    assert!(message(&jointed).contains("the joint \"ground-u_min_v_min\" holds the model at the ground"));
    let massless = |m: &mut Model| {
        m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(YOUNG, 0.0, 0.0)));
    };
    assert!(message(&massless).contains("no mass that balances its loads"));
    let iterative = |m: &mut Model| {
        let Analysis::Static(options) = &mut m.analysis else { panic!() };
        options.linear_solver = LinearSolver::Iterative;
    };
    assert!(message(&iterative).contains("has no inertia relief"));
}

/// A free beam under a thrust at one end does not buckle: with the inertia forces as constant ones the tangent has a negative eigenvalue from 18.7 EI/L² on.
/// Forces at both ends that balance each other let it buckle at π² EI/L².
#[test]
fn an_accelerating_beam_does_not_buckle_and_a_compressed_one_does() {
    let unit = YOUNG * WIDTH * THICKNESS.powi(3) / 12.0 / (LENGTH * LENGTH);
    let run = |forces: &[(&str, f64)]| {
        let mut m = strip([20, 2], false);
        let load = |(on, force): &(&str, f64)| edge(on, [force * unit / WIDTH, 0.0, 0.0]);
        m.loads = forces.iter().map(load).collect();
        let mut notes = Notes::default();
        let Analysis::Static(options) = &m.analysis else { panic!("a static analysis") };
        let (_, system) = crate::common::compile(&m);
        statics::run(&system, options, None, &mut notes).map(|_| notes.events)
    };
    let thrust = run(&[("u_max", -30.0)]).unwrap();
    assert!(thrust.iter().any(|event| event.contains("whether the equilibrium is stable is not known")));
    assert!(run(&[("u_max", -9.5), ("u_min", 9.5)]).unwrap().is_empty());
    let buckled = run(&[("u_max", -10.2), ("u_min", 10.2)]).unwrap_err();
    assert!(buckled.to_string().contains("bifurcation"), "{buckled}");
}
