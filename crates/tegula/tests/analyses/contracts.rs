//! Contracts of every registered load, support, joint and scheme of time integration, on the examples that each brings along.

use std::collections::BTreeMap;

use crate::common::{Notes, compile, displacement, distance, model, move_in_time, on, plate, static_options};
use tegula::analysis::{Observer, State, Step, dynamics, statics};
use tegula::load::FollowerLoad;
use tegula::mesh::generators::generate;
use tegula::model::loads::LoadedPart;
use tegula::model::*;
use tegula::norm::{larger, max_norm};
use tegula::result::{Equilibrium, ReactionFinder};
use tegula::{Mat3, System, Vec3};

/// Forces of the last step.
struct Last<'a> {
    system: &'a System,
    finder: ReactionFinder,
    found: Option<Equilibrium>,
}

impl Observer for Last<'_> {
    fn on_step(&mut self, step: &Step) -> tegula::Result<()> {
        self.found = Some(self.finder.find(self.system, None, step.state));
        Ok(())
    }
}

/// A linear strip along x.
fn strip(distortion: f64) -> Model {
    let mut m = model(plate([2.0, 0.5], [8, 2], distortion), 1e6, 0.05);
    m.analysis = Analysis::Static(StaticAnalysis { linear: true, ..StaticAnalysis::default() });
    m
}

fn equilibrium(m: &Model) -> (System, State, Equilibrium) {
    let (_, system) = compile(m);
    let mut last = Last { system: &system, finder: ReactionFinder::new(&system, None), found: None };
    let state = statics::run(&system, &static_options(m), None, &mut last).unwrap().state;
    let found = last.found.unwrap();
    (system, state, found)
}

/// A kind is read as it is written; its word is the one of the model file.
fn word<T: serde::Serialize + serde::de::DeserializeOwned + PartialEq + std::fmt::Debug>(
    value: &T,
) -> String {
    let written = serde_json::to_value(value).unwrap();
    assert_eq!(&serde_json::from_value::<T>(written.clone()).unwrap(), value);
    written["type"].as_str().unwrap().to_owned()
}

#[test]
fn every_load_is_taken_by_the_supports() {
    for load in Load::examples() {
        println!("contract: load {}", word(&load));
        assert_eq!(word(&load), load.kind());
        assert!(load.values().iter().any(|v| *v != 0.0), "{load:?} does nothing");
        let mut m = strip(0.0);
        m.loads = vec![load.clone()];
        let (system, state, forces) = equilibrium(&m);
        assert!(state.u.iter().flatten().any(|u| *u != 0.0), "{load:?} moves nothing");
        assert!(forces.force_error <= 1e-9 && forces.moment_error <= 1e-9, "{load:?}: {forces:?}");
        let [force, moment] = [forces.loads[0].force, forces.loads[0].moment];
        assert!(force.norm() + moment.norm() > 0.0, "{load:?}");
        assert!((forces.supports[0].force + force).norm() <= 1e-8 * (1e-3 + force.norm()), "{load:?}");
        assert!(system.load_sets[0].name.starts_with(load.kind()), "{load:?}");
    }
}

/// Loads on edges, surfaces and masses are integrated: their resultant does not depend on the mesh.
#[test]
fn every_distributed_load_has_the_same_resultant_on_any_mesh() {
    for load in Load::examples() {
        if load.part() == LoadedPart::Nodes {
            continue;
        }
        let resultant = |distortion: f64, elements: [u32; 2]| {
            let mut m = strip(0.0);
            m.mesh = plate([2.0, 0.5], elements, distortion);
            m.loads = vec![load.clone()];
            equilibrium(&m).2.loads[0]
        };
        let (a, b) = (resultant(0.0, [4, 2]), resultant(0.2, [8, 3]));
        let size = a.force.norm() + a.moment.norm();
        assert!((a.force - b.force).norm() <= 1e-3 * size, "{load:?}: {a:?} {b:?}");
    }
}

/// Stiffness −∂f/∂x of follower loads against central differences of their forces, at a deformed configuration.
#[test]
fn every_follower_load_has_the_stiffness_of_its_forces() {
    for load in Load::examples() {
        let mut m = strip(0.1);
        m.loads = vec![load.clone()];
        let (_, system) = compile(&m);
        let Some(follower) = system.followers.first() else { continue };
        let vectors = follower.vectors();
        let x: Vec<Vec3> = vectors
            .iter()
            .enumerate()
            .map(|(i, &v)| {
                Vec3::from(system.coordinates.reference[v as usize]) + Vec3::new(0.02, -0.01, 0.03) * i as f64
            })
            .collect();
        let k = follower.derivative(&x);
        let size = 1e-3 + max_norm(k.iter().flatten().map(Mat3::norm));
        for b in 0..x.len() {
            for j in 0..3 {
                let h = 1e-6;
                let [low, high] = [-h, h].map(|h| forces(follower, &x, b, j, h));
                for a in 0..x.len() {
                    let slope = (low[a] - high[a]) / (2.0 * h);
                    assert!((k[a][b].column(j) - slope).norm() <= 1e-6 * size, "{load:?}: block {a} {b}");
                }
            }
        }
    }
}

fn forces(load: &FollowerLoad, x: &[Vec3], vector: usize, component: usize, change: f64) -> Vec<Vec3> {
    let mut y = x.to_vec();
    y[vector][component] += change;
    let mut f = vec![[0.0; 3]; x.len()];
    load.forces(&y, &mut f);
    f.into_iter().map(Vec3::from).collect()
}

#[test]
fn every_support_holds_and_its_reactions_balance_the_loads() {
    for condition in Condition::examples() {
        println!("contract: support {}", word(&condition));
        let mut m = strip(0.0);
        m.conditions = vec![condition.clone(), Condition::Clamp(on("u_max"))];
        m.loads = vec![Load::Traction(VectorLoad::new("all", [0.3, -0.2, 0.5]))];
        let (system, state, forces) = equilibrium(&m);
        assert!(forces.force_error <= 1e-9 && forces.moment_error <= 1e-9, "{condition:?}: {forces:?}");
        let held: Vec<_> = system.supports.iter().filter(|s| s.key == "conditions[0]").collect();
        assert!(!held.is_empty(), "{condition:?} holds nothing");
        for support in held {
            assert!((support.direction.norm() - 1.0).abs() <= 1e-12, "{support:?}");
            let moved = Vec3::from(state.u[support.vector as usize]).dot(&support.direction);
            let wanted = support.motion.map_or(0.0, |(value, _)| value);
            assert!((moved - wanted).abs() <= 1e-12, "{support:?}: {moved}");
        }
        let [force, size] = [forces.supports[0].force, forces.supports[0].moment].map(|v| v.norm());
        assert!(force + size > 0.0, "{condition:?} takes no force");
    }
}

/// Layers of one isotropic material are that material: they have its thickness, mass and stiffness.
#[test]
fn every_section_of_one_material_is_that_material() {
    let material = Isotropic::new(1e6, 0.3, 2.0);
    let materials = BTreeMap::from([("m".to_owned(), Material::Isotropic(material))]);
    for section in Section::examples("m") {
        let Some((key, layers)) = section.layers() else { panic!("{section:?} has no layers") };
        println!("contract: section {key}");
        let written = serde_json::to_value(&section).unwrap();
        assert_eq!(serde_json::from_value::<Section>(written).unwrap(), section);
        let h: f64 = layers.plies(key).unwrap().iter().map(|ply| ply.thickness).sum();
        assert!(h > 0.0 && layers.offset() == 0.0, "{section:?}");
        let (found, one) = (section.compile(&materials), Section::new("m", h).compile(&materials));
        let (found, one) = (found.unwrap(), one.unwrap());
        assert!((found.thickness - h).abs() <= 1e-12 * h, "{key}: {}", found.thickness);
        assert!((found.inertia.mass - one.inertia.mass).abs() <= 1e-12 * one.inertia.mass, "{key}");
        assert!((found.inertia.rotary - one.inertia.rotary).abs() <= 1e-12 * one.inertia.rotary, "{key}");
        let (a, b) = (found.resultant.at(0.0), one.resultant.at(0.0));
        assert!((a.membrane - b.membrane).norm() <= 1e-12 * b.membrane.norm(), "{key}: {a:?} {b:?}");
        assert!((a.bending - b.bending).norm() <= 1e-12 * b.bending.norm(), "{key}: {a:?} {b:?}");
        assert!(a.coupling.norm() <= 1e-12 * b.membrane.norm() * h, "{key}: {a:?}");
    }
}

fn options(scheme: Scheme, end_time: f64, time_step: Option<f64>) -> TransientAnalysis {
    TransientAnalysis { scheme, time_step, ..TransientAnalysis::new(end_time) }
}

#[test]
fn every_scheme_moves_a_free_body_straight_on() {
    let velocity = [1.0, 2.0, -3.0];
    for scheme in Scheme::examples().into_iter().filter(|s| !s.is_kinematic()) {
        println!("contract: scheme {}", word(&scheme));
        assert_eq!(word(&scheme), scheme.name());
        let mut m = strip(0.0);
        m.conditions.clear();
        m.initial_velocities = vec![InitialVelocity {
            on: "all".into(),
            velocity,
            angular_velocity: [0.0; 3],
            center: [0.0; 3],
        }];
        let (system, outcome) = move_in_time(&m, &options(scheme, 0.02, None), &mut Notes::default());
        let mesh = generate(&m.mesh).unwrap();
        let far = displacement(&mesh, &system, &outcome.state.u, "u_max_v_max");
        let wanted = Vec3::from(velocity) * 0.02;
        assert!((far - wanted).norm() <= 1e-9 * wanted.norm(), "{scheme:?}: {far:?}");
    }
}

/// Differences of successive runs fall at least by two: the scheme is consistent. Recommended parameters give the second
/// order, which other tests hold the schemes of the program to.
#[test]
fn every_implicit_scheme_converges_with_the_step() {
    let mut m = strip(0.0);
    m.loads = vec![Load::Edge(VectorLoad::new("u_max", [0.0, 0.0, 1.0]))];
    for scheme in Scheme::examples().into_iter().filter(|s| !s.is_explicit() && !s.is_kinematic()) {
        let at = |steps: u32| {
            let o = options(scheme, 0.02, Some(0.02 / f64::from(steps)));
            move_in_time(&m, &o, &mut Notes::default()).1.state.u
        };
        let states = [200, 400, 800].map(at);
        let [coarse, fine] = [distance(&states[0], &states[1]), distance(&states[1], &states[2])];
        let size = max_norm(states[2].as_flattened());
        assert!(coarse < 0.1 * size && fine < 0.6 * coarse, "{scheme:?}: {coarse:e} {fine:e} of {size:e}");
    }
}

/// The model with a strip that flies beside its bodies: some joints connect a node of a shell.
fn with_shell(model: Model) -> Model {
    let analysis = model.analysis.clone();
    let Model { bodies, joints, .. } = model;
    Model { analysis, bodies, joints, conditions: Vec::new(), ..strip(0.0) }
}

/// Two bodies that a joint connects fly freely: energy and both momenta stay, and the joint stays closed.
#[test]
fn every_joint_keeps_energy_and_momenta_of_two_free_bodies() {
    for joint in Joint::examples() {
        assert_eq!(word(&joint), joint.word());
        println!("contract: joint {}", joint.word());
        let solid = |name: &str, at, inertia, angular_velocity| RigidBody {
            velocity: [0.3, -0.1, 0.2],
            angular_velocity,
            ..RigidBody::new(name, at, 2.0, Some(inertia))
        };
        let mut bodies = vec![
            solid("a", [0.0; 3], [0.4, 0.5, 0.3], [1.0, -2.0, 0.5]),
            solid("b", [1.2, 0.3, 0.1], [0.2, 0.25, 0.3], [-0.5, 1.0, 3.0]),
        ];
        // The carrier of gears flies, too.
        if let Some(carrier) = joint.common().carrier() {
            bodies.push(solid(carrier, [0.5, -0.2, 0.3], [0.3, 0.2, 0.25], [0.4, -0.3, 0.6]));
        }
        let scheme = Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 });
        let options = options(scheme, 1.0, Some(0.01));
        let mut model = Model::of_bodies(Analysis::Transient(options.clone()), bodies, vec![joint.clone()]);
        if joint.common().between().iter().any(|side| side.starts_with("u_")) {
            model = with_shell(model);
        }
        // Drives do work, which the balance takes into account; inner forces change no momentum.
        model.amplitudes.insert(
            DRIVE.into(),
            Amplitude::Expression(ExpressionAmplitude { expression: "1 - cos(3*t)".into() }),
        );
        let system = tegula::compile::build(&model, &generate(&model.mesh).unwrap()).unwrap();
        let mut notes = Notes::default();
        let outcome = dynamics::run(&system, &options, None, &mut notes).unwrap();
        let name = joint.word();
        assert!(notes.kinetic > 0.1 && notes.drift() <= 1e-10 * notes.kinetic, "{name}: {}", notes.drift());
        let (linear, angular) = notes.momenta[0];
        for (p, l) in &notes.momenta {
            assert!((p - linear).norm() <= 1e-9 * linear.norm(), "{name}: {p} {linear}");
            assert!((l - angular).norm() <= 1e-9 * angular.norm(), "{name}: {l} {angular}");
        }
        let moved = max_norm(outcome.state.u.as_flattened());
        assert!(moved > 0.1, "{name} does not move");
        for joint in system.joints.iter() {
            let at = |v: u32| {
                Vec3::from(system.coordinates.reference[v as usize]) + Vec3::from(outcome.state.u[v as usize])
            };
            let v: Vec<Vec3> = joint.vectors.iter().map(|&v| at(v)).collect();
            let open = joint.rows.iter().map(|row| row.value(&v, system.drive(joint, 1.0).value).abs());
            let open = open.fold(0.0, larger);
            assert!(open <= 1e-11, "{name} is open by {open}");
        }
    }
}
