//! Rigid patches: nodes of shells that are attached to rigid bodies, against clamps, added masses, beam theory and rigid
//! bodies, and their conservation laws.

use crate::common::*;
use tegula::analysis::{State, equilibrium, statics};
use tegula::element::{Motion, Nodal, TangentWeights};
use tegula::model::*;
use tegula::norm::{larger, max_norm};
use tegula::result::reactions::ReactionFinder;
use tegula::system::assembly::TangentCoefficients;
use tegula::system::{Assembly, CirculatoryStiffness, EvaluationPoint};
use tegula::{System, Vec3, compile};

const YOUNG: f64 = 2.1e6;
pub const LENGTH: f64 = 1.0;
const WIDTH: f64 = 0.2;
const THICKNESS: f64 = 0.02;

/// A strip along x without Poisson's effect.
pub fn strip(element: ElementKind, elements: [u32; 2], distortion: f64) -> Model {
    let mesh = plate([LENGTH, WIDTH], elements, distortion);
    let analysis = Analysis::Static(StaticAnalysis::default());
    let mut m = Model::new(mesh, analysis, Isotropic::new(YOUNG, 0.0, 700.0), THICKNESS);
    m.sections[0].element = element;
    m
}

/// A body without mass of its own on sets of the mesh.
pub fn hub(name: &str, at: [f64; 3], sets: &[&str]) -> RigidBody {
    let attached = sets.iter().map(|set| (*set).to_owned()).collect();
    RigidBody { mass: None, attached, ..RigidBody::new(name, at, 1.0, None) }
}

pub fn steps(end: f64, step: f64) -> TransientAnalysis {
    let scheme = Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 });
    TransientAnalysis { scheme, time_step: Some(step), ..TransientAnalysis::new(end) }
}

pub fn clamped(set: &str) -> Condition {
    Condition::Clamp(on(set))
}

pub fn gravity(value: [f64; 3]) -> Load {
    Load::Gravity(GravityLoad { value, amplitude: None })
}

pub fn fixed(body: &str, at: [f64; 3]) -> Joint {
    Joint::Fixed(PointJoint {
        name: "clamp".into(),
        between: ["ground".into(), body.into()],
        at,
        second_at: None,
    })
}

/// Largest difference of the displacements of all nodal vectors of the mesh over the largest one.
fn difference(a: &[Nodal], b: &[Nodal]) -> f64 {
    let n = a.len().min(b.len());
    let pairs = a[..n].as_flattened().iter().zip(b[..n].as_flattened());
    max_norm(pairs.map(|(a, b)| a - b)) / max_norm(b[..n].as_flattened())
}

fn director_of(system: &System, u: &[Nodal], node: u32) -> Vec3 {
    let d = system.coordinates.director_of[node as usize] as usize;
    Vec3::from(system.coordinates.reference[d]) + Vec3::from(u[d])
}

/// Rotation M L/(E I) of a cantilever under a moment at its tip: exact for linear strains; along a circle for large ones.
#[test]
fn a_moment_on_a_patch_bends_a_cantilever_into_a_circle() {
    let inertia = WIDTH * THICKNESS.powi(3) / 12.0;
    for element in ElementKind::ALL.iter().copied() {
        for (angle, linear, tolerance) in [(1e-3, true, 1e-9), (1.5, false, 4e-3)] {
            let mut m = strip(element, [16, 2], 0.0);
            m.analysis = Analysis::Static(StaticAnalysis { linear, ..StaticAnalysis::default() });
            m.conditions = vec![clamped("u_min")];
            m.bodies = vec![hub("tip", [LENGTH, 0.5 * WIDTH, 0.0], &["u_max"])];
            m.loads = vec![Load::Moment(vector_load("tip", [0.0, -angle * YOUNG * inertia / LENGTH, 0.0]))];
            let (_, system, outcome) = solve(&m);
            let tip = &system.coordinates.bodies[0];
            let u = |v: u32| Vec3::from(outcome.state.u[v as usize]);
            let axis = Vec3::x() + u(tip.directors.unwrap()[0]);
            let turned = if linear { axis.z } else { axis.z.atan2(axis.x) };
            assert!((turned - angle).abs() < tolerance * angle, "{element:?} {linear}: {turned}");
            let iterations = outcome.statistics.iterations;
            assert!(iterations <= 12, "{element:?}: {iterations} iterations");
            if !linear {
                let exact = Vec3::new(angle.sin() / angle - 1.0, 0.0, (1.0 - angle.cos()) / angle) * LENGTH;
                assert!(
                    (u(tip.centre) - exact).norm() < tolerance * LENGTH,
                    "{element:?}: {}",
                    u(tip.centre)
                );
            }
        }
    }
}

/// A strip whose edge is attached to a body that a joint fixes swings as one whose edge is clamped.
#[test]
#[ignore = "long"]
fn a_patch_on_a_fixed_body_is_a_clamp() {
    for (element, distortion) in ElementKind::ALL.iter().flat_map(|e| [(*e, 0.0), (*e, 0.3)]) {
        let mut m = strip(element, [6, 2], distortion);
        m.loads = vec![gravity([0.0, 0.3, -9.81])];
        let clamp = Model { conditions: vec![clamped("u_min")], ..m.clone() };
        let patch = Model {
            bodies: vec![hub("hub", [-0.3, 0.1, 0.2], &["u_min"])],
            joints: vec![fixed("hub", [-0.5, 0.0, 0.0])],
            ..m.clone()
        };
        let options = steps(0.2, 0.02);
        let end = |m: &Model| move_in_time(m, &options, &mut Notes::default()).1.state.u;
        let d = difference(&end(&patch), &end(&clamp));
        assert!(d < 1e-9, "{element:?} {distortion}: {d}");
    }
}

/// A body without inertia moments of its own at the middle of an edge that stays straight is an added mass of the edge.
#[test]
fn a_mass_on_a_patch_is_an_added_mass_where_the_edge_does_not_rotate() {
    // Inextensible directors: inertia would stretch the others, of which those of the patch are fixed in the body.
    let mut m = strip(ElementKind::Mitc4, [8, 1], 0.0);
    m.conditions = vec![clamped("u_min")];
    m.loads = vec![gravity([0.0, 0.0, -1.0])];
    let added = Model {
        masses: vec![AddedMass::Edge(MassOn { on: "u_max".into(), value: 0.5 / WIDTH })],
        ..m.clone()
    };
    let tip = RigidBody { mass: Some(0.5), ..hub("tip", [LENGTH, 0.5 * WIDTH, 0.0], &["u_max"]) };
    let body = Model { bodies: vec![tip], ..m.clone() };
    let options = steps(1.0, 0.02);
    let end = |m: &Model| move_in_time(m, &options, &mut Notes::default()).1.state.u;
    let d = difference(&end(&body), &end(&added));
    assert!(d < 1e-9, "{d}");
}

/// A curved shell between two bodies, both on patches, flies freely: energy and both momenta stay.
#[test]
#[ignore = "long"]
fn a_shell_between_two_bodies_keeps_energy_and_momenta() {
    for element in ElementKind::ALL.iter().copied() {
        let mut m = quarter_cylinder(3, 2.1e6);
        m.sections[0].element = element;
        m.sections[0].thickness = 0.05;
        m.materials
            .values_mut()
            .for_each(|material| *material = Material::Isotropic(Isotropic::new(2.1e6, 0.3, 500.0)));
        m.conditions = Vec::new();
        let solid = RigidBody {
            mass: Some(4.0),
            inertia: Some([0.2, 0.3, 0.4]),
            axes: [[0.6, 0.0, 0.8], [0.0, 1.0, 0.0]],
            velocity: [1.0, -2.0, 0.5],
            angular_velocity: [3.0, 1.0, -2.0],
            ..hub("first", [-0.2, 0.6, 0.1], &["u_min"])
        };
        m.bodies = vec![solid, hub("second", [1.1, 0.5, 1.2], &["u_max"])];
        let mut notes = Notes::default();
        let (system, outcome) = move_in_time(&m, &steps(0.12, 5e-3), &mut notes);
        assert!(outcome.balance.strain > 1e-3 * notes.kinetic, "the shell deforms: {:?}", outcome.balance);
        assert!(
            notes.drift() <= 1e-9 * notes.kinetic,
            "{element:?}: {:e} of {:e}",
            notes.drift(),
            notes.kinetic
        );
        let (linear, angular) = notes.momenta[0];
        for (p, l) in &notes.momenta {
            assert!((p - linear).norm() <= 1e-9 * linear.norm(), "{element:?}: {p} {linear}");
            assert!((l - angular).norm() <= 1e-9 * angular.norm(), "{element:?}: {l} {angular}");
        }
        // The patch has stayed rigid.
        for attached in system.coordinates.attached() {
            let of = |v: u32| {
                Vec3::from(system.coordinates.reference[v as usize]) + Vec3::from(outcome.state.u[v as usize])
            };
            let body = &system.coordinates.bodies[attached.triad as usize];
            let mut x = attached.centre.map_or(Vec3::zeros(), of);
            for (d, c) in body.directors.unwrap().into_iter().zip(attached.coordinates.iter()) {
                x += of(d) * *c;
            }
            assert!((x - of(attached.vector)).norm() < 1e-12, "{element:?}: {x} {}", of(attached.vector));
        }
    }
}

/// A strip hinged about its normal, along the director: a drilling moment goes through the patch. Stiff enough it swings as the
/// rigid body of the same mass and inertia, whose period is that of the physical pendulum.
#[test]
#[ignore = "long"]
fn a_stiff_strip_hinged_about_its_normal_swings_as_a_rigid_pendulum() {
    let hinge = |body: &str| {
        Joint::Revolute(
            AxisJoint {
                name: "hinge".into(),
                between: ["ground".into(), body.into()],
                at: [0.0; 3],
                axis: [0.0, 0.0, 1.0],
                second_at: None,
                second_axis: None,
            }
            .into(),
        )
    };
    let rigid = RigidBody {
        shape: Some(BodyShape::Box(BoxShape { size: [LENGTH, WIDTH, THICKNESS] })),
        ..RigidBody::new("bar", [0.5 * LENGTH, 0.5 * WIDTH, 0.0], 700.0 * LENGTH * WIDTH * THICKNESS, None)
    };
    let options = steps(0.4, 0.01);
    let bar = Model::of_bodies(Analysis::Transient(options.clone()), vec![rigid], vec![hinge("bar")]);
    let bar = Model { loads: vec![gravity([0.0, -9.81, 0.0])], ..bar };
    let (system, outcome) = move_in_time(&bar, &options, &mut Notes::default());
    let axis = |system: &System, u: &[Nodal]| {
        let d = system.coordinates.bodies[0].directors.unwrap()[0] as usize;
        Vec3::from(system.coordinates.reference[d]) + Vec3::from(u[d])
    };
    let exact = axis(&system, &outcome.state.u);
    for element in ElementKind::ALL.iter().copied() {
        let mut m = strip(element, [4, 2], 0.2);
        m.materials
            .values_mut()
            .for_each(|material| *material = Material::Isotropic(Isotropic::new(2.1e11, 0.3, 700.0)));
        m.bodies = vec![hub("hub", [0.0; 3], &["u_min"])];
        m.joints = vec![hinge("hub")];
        m.loads = vec![gravity([0.0, -9.81, 0.0])];
        let mut notes = Notes::default();
        let (system, outcome) = move_in_time(&m, &options, &mut notes);
        let found = axis(&system, &outcome.state.u);
        assert!(exact.x < 0.5 && (found - exact).norm() < 1e-4, "{element:?}: {found} {exact}");
        assert!(notes.drift() <= 1e-9 * notes.kinetic, "{element:?}: {}", notes.drift());
        // It stays in its plane.
        let heights = system.coordinates.position_of.iter().map(|&v| outcome.state.u[v as usize][2]);
        assert!(max_norm(heights) < 1e-9, "{element:?}");
    }
}

/// A rigid motion of shell and body has neither stress nor unbalanced forces, and the patch leaves a rigid motion as it is.
#[test]
fn a_rigid_motion_of_a_patched_shell_is_free_of_stress() {
    for element in ElementKind::ALL.iter().copied() {
        let mut m = quarter_cylinder(4, 2.1e6);
        m.sections[0].element = element;
        m.analysis = Analysis::Transient(steps(1.0, 0.1));
        m.conditions = Vec::new();
        m.bodies = vec![hub("hub", [0.3, 0.2, 0.1], &["u_max", "v_min"])];
        let (_, system) = compile(&m);
        let turn = rotation([1.0, -2.0, 0.5], 2.0);
        let shift = Vec3::new(0.3, -0.7, 1.1);
        let move_one = |v: usize| {
            let x = Vec3::from(system.coordinates.reference[v]);
            let position = system.coordinates.kinds[v] == tegula::system::VectorKind::Position;
            (turn * x + if position { shift } else { Vec3::zeros() } - x).into()
        };
        let u: Vec<Nodal> = (0..system.vectors()).map(move_one).collect();
        let mut carried = u.clone();
        system.dofs().carry(&mut carried);
        assert!(distance(&carried, &u) < 1e-13 * max_norm(u.as_flattened()), "{element:?}");
        let mut assembly = Assembly::new(&system);
        let history = vec![0.0; system.offsets.last().unwrap().history.end];
        let k = EvaluationPoint::at_rest(&system, &u, 0.0, &history);
        let mut forces = vec![[0.0; 3]; system.vectors()];
        assembly.forces(&system, &k, &mut forces);
        let size = max_norm(forces.as_flattened());
        assert!(size < 1e-9 * 2.1e6 * 0.01, "{element:?}: {size}");
    }
}

/// A force on an attached node acts on the body as the force and the moment of its arm; one on all nodes of the edge as
/// their sum.
#[test]
fn forces_on_attached_nodes_act_on_the_body() {
    let mut m = strip(ElementKind::Ems, [8, 2], 0.3);
    m.conditions = vec![clamped("u_min")];
    m.bodies = vec![hub("tip", [LENGTH + 0.1, 0.0, 0.05], &["u_max"])];
    let force = [0.0, 0.5, -0.2];
    let corner = Vec3::new(LENGTH, WIDTH, 0.0);
    let moment = (corner - Vec3::new(LENGTH + 0.1, 0.0, 0.05)).cross(&Vec3::from(force));
    let linear = |loads: Vec<Load>| {
        let analysis = Analysis::Static(StaticAnalysis { linear: true, ..StaticAnalysis::default() });
        solve(&Model { analysis, loads, ..m.clone() }).2.state.u
    };
    let on_node = linear(vec![Load::Force(vector_load("u_max_v_max", force))]);
    let on_body =
        linear(vec![Load::Force(vector_load("tip", force)), Load::Moment(vector_load("tip", moment.into()))]);
    let d = difference(&on_node, &on_body);
    assert!(d < 1e-9, "{d}");
}

/// Large displacements under pressure, gravity and a force on the body: the reactions balance the loads.
#[test]
#[ignore = "long"]
fn reactions_balance_the_loads_on_a_patched_shell() {
    for element in ElementKind::ALL.iter().copied() {
        let mut m = strip(element, [4, 2], 0.3);
        m.conditions = vec![clamped("u_min")];
        m.bodies = vec![RigidBody { mass: Some(0.3), ..hub("tip", [LENGTH, 0.1, 0.1], &["u_max"]) }];
        m.loads = vec![
            gravity([0.0, 0.0, -9.81]),
            Load::Force(vector_load("tip", [0.1, 0.5, 0.2])),
            Load::Pressure(PressureLoad {
                on: "all".into(),
                value: 3.0,
                amplitude: None,
                distribution: None,
            }),
        ];
        let (_, system, outcome) = solve(&m);
        let balance = ReactionFinder::new(&system, None).find(&system, None, &outcome.state);
        assert!(balance.force_error < 1e-8 && balance.moment_error < 1e-8, "{element:?}: {balance:?}");
    }
}

/// Where all nodes are attached to one body, the model is a rigid body of the mass and inertia of the shell.
#[test]
fn a_shell_that_is_wholly_attached_is_a_rigid_body() {
    let mut m = strip(ElementKind::Ems, [4, 2], 0.3);
    let body = RigidBody { angular_velocity: [1.0, 8.0, 0.5], ..hub("all", [0.5, 0.1, 0.0], &["all"]) };
    m.bodies = vec![body];
    let options = steps(1.0, 0.01);
    let mut notes = Notes::default();
    let (system, outcome) = move_in_time(&m, &options, &mut notes);
    assert_eq!(system.unknowns(), 6);
    let solid = RigidBody {
        shape: Some(BodyShape::Box(BoxShape { size: [LENGTH, WIDTH, THICKNESS] })),
        angular_velocity: [1.0, 8.0, 0.5],
        ..RigidBody::new("all", [0.5, 0.1, 0.0], 700.0 * LENGTH * WIDTH * THICKNESS, None)
    };
    let plain = Model::of_bodies(Analysis::Transient(options.clone()), vec![solid], Vec::new());
    let (rigid, exact) = move_in_time(&plain, &options, &mut Notes::default());
    let at = |system: &System, u: &[Nodal], i: usize| {
        Vec3::from(u[system.coordinates.bodies[0].directors.unwrap()[i] as usize])
    };
    for i in 0..3 {
        let [a, b] = [at(&system, &outcome.state.u, i), at(&rigid, &exact.state.u, i)];
        assert!((a - b).norm() < 1e-8, "{a} {b}");
    }
    assert!(notes.drift() <= 1e-10 * notes.kinetic, "{}", notes.drift());
}

/// Two bodies that share the nodes of an element, and the same bits in a second run.
#[test]
fn neighbouring_patches_couple_and_repeat_bit_by_bit() {
    let mut m = strip(ElementKind::Ems, [1, 1], 0.0);
    m.bodies = vec![
        RigidBody { angular_velocity: [5.0, 1.0, 2.0], ..hub("a", [0.0, 0.0, 0.1], &["u_min"]) },
        hub("b", [LENGTH, 0.1, 0.0], &["u_max"]),
    ];
    let run = || {
        let mut notes = Notes::default();
        let (_, outcome) = move_in_time(&m, &steps(0.2, 2e-3), &mut notes);
        assert!(notes.drift() <= 1e-9 * notes.kinetic, "{} {}", notes.drift(), notes.kinetic);
        let (linear, angular) = notes.momenta[0];
        let (p, l) = notes.momenta.last().unwrap();
        assert!((p - linear).norm() <= 1e-9 * linear.norm() && (l - angular).norm() <= 1e-9 * angular.norm());
        outcome.state.u
    };
    assert!(run() == run());
}

/// Sheets that only a body connects are one part, and a fold takes part in a patch.
#[test]
fn a_body_connects_two_sheets() {
    let sheet = |x: f64| {
        let MeshSource::Plate(p) = plate([0.5, WIDTH], [4, 2], 0.0) else { unreachable!() };
        tegula::mesh::generators::generate(&MeshSource::Plate(PlateMesh { origin: [x, 0.0, 0.0], ..p }))
            .unwrap()
    };
    let mesh = side_by_side(&[sheet(0.0), sheet(0.6)]);
    let mut m = strip(ElementKind::Ems, [4, 2], 0.0);
    m.conditions = vec![clamped("u_min0")];
    m.bodies = vec![hub("bridge", [0.55, 0.1, 0.5], &["u_max0", "u_min1"])];
    m.loads = vec![Load::Edge(vector_load("u_max1", [0.0, 0.0, 0.2]))];
    let system = compile::build(&m, &mesh).unwrap();
    let outcome =
        tegula::analysis::statics::run(&system, &static_options(&m), None, &mut Notes::default()).unwrap();
    let balance = ReactionFinder::new(&system, None).find(&system, None, &outcome.state);
    assert!(balance.force_error < 1e-8 && balance.moment_error < 1e-8, "{balance:?}");
    // The edges on both sides of the bridge turn together.
    let turned = |set: &str| director_of(&system, &outcome.state.u, mesh.nodes_on(set).unwrap()[0]);
    assert!((turned("u_max0") - turned("u_min1")).norm() < 1e-13 && turned("u_max0").x.abs() > 1e-3);
}

/// Derivative of the residual of a state with respect to the degrees of freedom by central differences, with the sign of a stiffness: its columns.
pub fn derivative_of_residual(system: &System, state: &State) -> Vec<Vec<f64>> {
    let frames = equilibrium::frames(system, state);
    let n = system.unknowns();
    let column = |j: usize| {
        let step = 1e-6;
        let at = |sign: f64| {
            let mut free = vec![0.0; n];
            free[j] = sign * step;
            let mut u = vec![[0.0; 3]; system.vectors()];
            frames.expand(&free, &mut u);
            for (u, old) in u.iter_mut().zip(&state.u) {
                (0..3).for_each(|i| u[i] += old[i]);
            }
            equilibrium::residual(system, &State { u, ..state.clone() })
        };
        let pairs = at(-1.0).into_iter().zip(at(1.0));
        pairs.map(|(a, b)| (a - b) / (2.0 * step)).collect::<Vec<_>>()
    };
    (0..n).map(column).collect()
}

/// Largest difference of the tangent of an equilibrium with the circulatory part of its follower loads from the derivative of the residual, over the largest
/// entry of this part. Joints are not looked at.
pub fn error_of_whole_tangent(system: &System, state: &State) -> f64 {
    let (pattern, values) = equilibrium::tangent(system, state).unwrap();
    let frames = equilibrium::frames(system, state);
    let (n, columns) = (system.unknowns(), derivative_of_residual(system, state));
    let mut skew = CirculatoryStiffness::new(system);
    let parts = TangentCoefficients { weights: TangentWeights::STATIC, mass: 0.0, time: state.time };
    skew.take(system, &Motion::State { u: &state.u, velocity: None }, &parts);
    let mut entries = vec![0.0; n * n];
    skew.for_each_entry(&frames, |i, j, x| entries[i as usize * n + j as usize] += x);
    let (mut largest, mut worst, mut sums) = (0.0_f64, 0.0_f64, vec![0.0; n]);
    for (j, exact) in columns.iter().enumerate() {
        let (mut x, mut whole) = (vec![0.0; n], vec![0.0; n]);
        x[j] = 1.0;
        pattern.add_product(&values, &x, &mut whole);
        for i in 0..n {
            largest = larger(largest, entries[i * n + j].abs());
            worst = larger(worst, (whole[i] + entries[i * n + j] - exact[i]).abs());
        }
    }
    skew.product(&frames, &vec![1.0; n], &mut sums);
    let sum = |i: usize| entries[i * n..][..n].iter().sum::<f64>();
    (0..n).for_each(|i| worst = larger(worst, (sums[i] - sum(i)).abs()));
    worst / largest
}

/// Under follower loads on the nodes of a patch and a moment on its body the tangent with its unsymmetric part is the derivative of the residual.
#[test]
fn the_tangent_of_a_patch_under_follower_loads_is_the_derivative_of_its_residual() {
    let mut m = strip(ElementKind::Ems, [4, 2], 0.3);
    m.conditions = vec![clamped("u_min")];
    m.bodies = vec![hub("tip", [LENGTH, 0.1, 0.1], &["u_max", "u_max_v_max"])];
    m.loads = vec![
        Load::Force(vector_load("u_max", [-0.05, 0.1, 0.15])),
        Load::Pressure(PressureLoad { on: "all".into(), value: 2.0, amplitude: None, distribution: None }),
        Load::Moment(vector_load("tip", [0.1, -0.25, 0.05])),
        Load::Moment(vector_load("u_max", [0.02, 0.03, 0.0])),
    ];
    let (_, system, outcome) = solve(&m);
    let error = error_of_whole_tangent(&system, &outcome.state);
    // Round-off of the differences; without the part of any of these loads the error is larger than 0.01.
    assert!(error < 1e-3, "{error:e}");
}

/// The tangent of an equilibrium is the derivative of the residual with respect to the degrees of freedom, also of rotations.
#[test]
fn the_tangent_of_a_patched_shell_is_the_derivative_of_its_residual() {
    let rubber = NeoHookean { shear: YOUNG / 3.0, bulk: YOUNG, density: 700.0, form: NeoHookeanForm::Split };
    let rubber = [ElementKind::Cm, ElementKind::SolidShell]
        .map(|element| (element, Some(Material::NeoHookean(rubber.clone()))));
    for (element, material) in ElementKind::ALL.iter().map(|element| (*element, None)).chain(rubber) {
        let mut m = strip(element, [4, 2], 0.3);
        if let Some(material) = material {
            m.materials.values_mut().for_each(|other| *other = material.clone());
        }
        m.conditions = vec![clamped("u_min")];
        // Symmetric where no moment acts: its work depends on the path.
        m.bodies = vec![hub("tip", [LENGTH, 0.1, 0.1], &["u_max", "u_max_v_max"])];
        m.loads = vec![Load::Force(vector_load("u_max", [-0.05, 0.1, 0.15]))];
        let (_, system, outcome) = solve(&m);
        let state = outcome.state;
        let (pattern, values) = equilibrium::tangent(&system, &state).unwrap();
        let n = system.unknowns();
        let mut largest = 0.0_f64;
        let mut worst = 0.0_f64;
        let columns = derivative_of_residual(&system, &state);
        let (pointers, rows) = pattern.columns();
        for j in 0..n {
            for at in pointers[j]..pointers[j + 1] {
                let i = rows[at] as usize;
                let exact: f64 = 0.5 * (columns[j][i] + columns[i][j]);
                largest = larger(largest, exact.abs());
                worst = larger(worst, (values[at] - exact).abs());
            }
        }
        assert!(worst < 1e-7 * largest, "{element:?}: {worst:e} of {largest:e}");
    }
}

/// A load of the first step stays in the second one, a transient: nothing moves. A support that the second static step has not
/// any more leaves the equilibrium without it.
#[test]
fn steps_continue_from_the_end_of_a_patched_one() {
    let mut m = strip(ElementKind::Ems, [8, 2], 0.2);
    m.conditions = vec![clamped("u_min")];
    m.bodies = vec![RigidBody { mass: Some(0.1), ..hub("tip", [LENGTH, 0.1, 0.1], &["u_max"]) }];
    m.loads = vec![Load::Moment(vector_load("tip", [0.1, -0.25, 0.05])), gravity([0.0, 0.0, -1.0])];
    let alone = solve(&m).2.state.u;
    let at_rest = |name: &str| AnalysisStep::new(name, m.analysis.clone());
    let held =
        Condition::Fix(FixComponents { on: "v_max".into(), position: vec![Axis::Z], director: Vec::new() });
    let mut mesh = tegula::mesh::generators::generate(&m.mesh).unwrap();
    let middle = mesh.positions.iter().position(|x| (x.x - 0.5).abs() < 0.05 && x.y == 0.0).unwrap() as u32;
    mesh.node_sets.insert("middle".into(), vec![middle]);
    let Condition::Fix(held) = held else { unreachable!() };
    let held = Condition::Fix(FixComponents { on: "middle".into(), ..held });
    let options = steps(0.2, 0.01);
    let moving = AnalysisStep::new("move", Analysis::Transient(options.clone()));
    let all = vec![AnalysisStep { conditions: vec![held], ..at_rest("held") }, at_rest("free"), moving];
    let m = Model { steps: all, ..m.clone() };
    let compiler = compile::Compiler::new(&m, &mesh).unwrap();
    let mut start = None;
    for step in 0..2 {
        let system = compiler.system(step, start).unwrap();
        let outcome = statics::run(&system, &static_options(&m), None, &mut Notes::default()).unwrap();
        start = Some(outcome.state.end_of_step());
    }
    let end = start.clone().unwrap().u;
    let d = difference(&end, &alone);
    assert!(d < 1e-8, "{d}");
    let system = compiler.system(2, start).unwrap();
    let outcome = tegula::analysis::dynamics::run(&system, &options, None, &mut Notes::default()).unwrap();
    let d = difference(&outcome.state.u, &end);
    assert!(d < 1e-6, "{d}");
}

/// A joint at an attached node is one at the same point of the body.
#[test]
fn a_joint_at_an_attached_node_is_a_joint_at_the_body() {
    let mut m = strip(ElementKind::Ems, [4, 2], 0.2);
    m.bodies = vec![RigidBody { mass: Some(0.5), ..hub("hub", [-0.1, 0.1, 0.05], &["u_min"]) }];
    m.loads = vec![gravity([0.0, 0.3, -9.81])];
    let options = steps(0.3, 0.01);
    let end = |name: &str| {
        let between = ["ground".into(), name.into()];
        let joint =
            Joint::Spherical(PointJoint { name: "ball".into(), between, at: [0.0; 3], second_at: None });
        let mut notes = Notes::default();
        let m = Model { joints: vec![joint], ..m.clone() };
        let (_, outcome) = move_in_time(&m, &options, &mut notes);
        assert!(notes.drift() < 1e-9 * notes.kinetic, "{}", notes.drift());
        outcome.state.u
    };
    let d = difference(&end("u_min_v_min"), &end("hub"));
    assert!(d < 1e-9, "{d}");
}

/// Nodes on a fold with two directors take part in a patch.
#[test]
#[ignore = "long"]
fn a_patch_over_a_fold_keeps_energy_and_momenta() {
    for element in ElementKind::ALL.iter().copied() {
        let mesh = MeshSource::Extrusion(ExtrusionMesh {
            vertices: vec![[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.5, 0.0, 0.4]],
            sweep: [0.0, 0.3, 0.0],
            grid: Grid::uniform(3, 3),
        });
        let analysis = Analysis::Static(StaticAnalysis::default());
        let mut m = Model::new(mesh, analysis, Isotropic::new(YOUNG, 0.3, 700.0), THICKNESS);
        m.sections[0].element = element;
        let spun =
            RigidBody { angular_velocity: [2.0, 4.0, 1.0], ..hub("hub", [0.4, -0.1, 0.1], &["v_min"]) };
        m.bodies = vec![spun];
        let mut notes = Notes::default();
        let (_, outcome) = move_in_time(&m, &steps(0.1, 5e-3), &mut notes);
        assert!(outcome.balance.strain > 1e-4 * notes.kinetic, "{:?}", outcome.balance);
        assert!(notes.drift() <= 1e-9 * notes.kinetic, "{element:?}: {} {}", notes.drift(), notes.kinetic);
        let (linear, angular) = notes.momenta[0];
        let (p, l) = notes.momenta.last().unwrap();
        assert!((p - linear).norm() <= 1e-9 * linear.norm(), "{element:?}: {p} {linear}");
        assert!((l - angular).norm() <= 1e-9 * angular.norm(), "{element:?}: {l} {angular}");
    }
}

/// An added mass of attached edges is a body of the mass and inertia of a rod, for any motion.
#[test]
fn an_added_mass_on_attached_nodes_belongs_to_the_body() {
    let mut m = strip(ElementKind::Ems, [5, 3], 0.3);
    m.conditions = vec![clamped("u_min")];
    m.loads = vec![gravity([0.5, 1.0, -2.0])];
    let mass = 0.5;
    let tip = hub("tip", [LENGTH, 0.5 * WIDTH, 0.0], &["u_max"]);
    let added = Model {
        masses: vec![AddedMass::Edge(MassOn { on: "u_max".into(), value: mass / WIDTH })],
        bodies: vec![RigidBody { attached: tip.attached.clone(), ..hub("tip", [1.2, 0.0, 0.1], &[]) }],
        ..m.clone()
    };
    let j = mass * WIDTH * WIDTH / 12.0;
    let body = RigidBody { mass: Some(mass), inertia: Some([j, 0.0, j]), ..tip };
    let body = Model { bodies: vec![body], ..m.clone() };
    let options = steps(0.4, 0.01);
    let end = |m: &Model| {
        let mut notes = Notes::default();
        let u = move_in_time(m, &options, &mut notes).1.state.u;
        assert!(notes.drift() <= 1e-9 * notes.kinetic, "{}", notes.drift());
        u
    };
    let (added, body) = (end(&added), end(&body));
    // The bodies themselves are at different places.
    let nodes = added.len() - 4;
    let d = difference(&added[..nodes], &body[..nodes]);
    assert!(d < 1e-9, "{d}");
}
