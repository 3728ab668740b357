//! Ties of meshes whose nodes do not match.

use crate::common::{Notes, model, plate, static_options, vector_load};
use crate::multibody::revolute;
use tegula::analysis::{Silent, State, dynamics, statics};
use tegula::mesh::{Mesh, generators::generate};
use tegula::model::*;
use tegula::norm::{larger, max_norm};
use tegula::result::joint_reaction;
use tegula::{Error, System, Vec3, compile};

/// Two plates along x with the widths 0.4 that meet at x = 1, of these numbers of elements; sets as in `plate` with 0 and 1 behind their names.
fn parts(elements: [[u32; 2]; 2]) -> Mesh {
    let mut out = Mesh::default();
    for (k, elements) in elements.into_iter().enumerate() {
        let part = generate(&plate([1.0, 0.4], elements, 0.0)).unwrap();
        let (nodes, quads) = (out.positions.len() as u32, out.quads.len() as u32);
        out.positions.extend(part.positions.iter().map(|x| x + Vec3::x() * k as f64));
        out.quads.extend(part.quads.iter().map(|quad| quad.map(|n| n + nodes)));
        for (name, edges) in &part.edge_sets {
            let moved = edges.iter().map(|edge| edge.map(|n| n + nodes)).collect();
            out.edge_sets.insert(format!("{name}{k}"), moved);
        }
        for (name, list) in &part.node_sets {
            out.node_sets.insert(format!("{name}{k}"), list.iter().map(|n| n + nodes).collect());
        }
        out.quad_sets.insert(format!("part{k}"), (quads..quads + part.quads.len() as u32).collect());
    }
    out
}

fn tie(rotations: bool) -> Tie {
    Tie { name: "tie".into(), on: "u_min1".into(), to: "part0".into(), rotations }
}

/// Plates of both parts, without supports and loads; Poisson's ratio 0.
fn tied(rotations: bool) -> Model {
    let mut m = model(plate([1.0, 0.4], [1, 1], 0.0), 1e6, 0.05);
    m.materials
        .values_mut()
        .for_each(|material| *material = Material::Isotropic(Isotropic::new(1e6, 0.0, 1.0)));
    m.conditions.clear();
    m.ties = vec![tie(rotations)];
    m
}

fn statics(m: &Model, mesh: &Mesh) -> (System, State) {
    let system = compile::build(m, mesh).unwrap();
    let state = statics::run(&system, &static_options(m), None, &mut Silent).unwrap().state;
    (system, state)
}

/// Where all nodes of the coarser edge meet those of the finer one, uniform tension passes exactly; the tie carries its resultant.
#[test]
fn tension_passes_a_tie_of_nested_edges_exactly() {
    let mut m = tied(true);
    m.conditions = vec![Condition::Clamp(OnSet { on: "u_min0".into() })];
    let stress = 2.0;
    m.loads = vec![Load::Edge(vector_load("u_max1", [stress * 0.05, 0.0, 0.0]))];
    let mesh = parts([[3, 2], [4, 4]]);
    let (system, state) = statics(&m, &mesh);
    let strain = stress / 1e6;
    for (node, x) in mesh.positions.iter().enumerate() {
        let u = Vec3::from(state.u[system.coordinates.position_of[node] as usize]);
        assert!((u - Vec3::x() * strain * x.x).norm() < 1e-5 * strain, "{x} {u}");
    }
    let (force, _) = joint_reaction(&system, &state, &system.joints[0]);
    assert!((force.norm() / (stress * 0.05 * 0.4) - 1.0).abs() < 1e-6, "{force}");
}

/// A cantilever of two parts with edges of 3 and 5 elements bends like a beam, `P L³/(3 EI)`; with a hinge in place of the tie the outer part
/// turns freely.
#[test]
fn a_cantilever_of_two_parts_bends_as_one() {
    let load = 1e-4;
    let mut m = tied(true);
    m.conditions = vec![Condition::Clamp(OnSet { on: "u_min0".into() })];
    m.loads = vec![Load::Edge(vector_load("u_max1", [0.0, 0.0, load / 0.4]))];
    let mesh = parts([[20, 3], [20, 5]]);
    let (system, state) = statics(&m, &mesh);
    let inertia = 0.4 * 0.05_f64.powi(3) / 12.0;
    let expected = load * 8.0 / (3.0 * 1e6 * inertia);
    for node in mesh.nodes_on("u_max1").unwrap() {
        let u = state.u[system.coordinates.position_of[node as usize] as usize][2];
        // Shear adds (t/L)² · 3 E/(4 κ G L²/t²), a thousandth.
        assert!((u / expected - 1.0).abs() < 3e-3, "{u} {expected}");
    }
    m.ties = vec![tie(false)];
    let system = compile::build(&m, &mesh).unwrap();
    assert!(statics::run(&system, &static_options(&m), None, &mut Silent).is_err());
}

/// Two tied plates turn about a hinge through a large angle and bend: the tie stays closed, energy and moment of momentum are conserved.
#[test]
fn a_tie_in_motion_conserves_energy_and_momentum() {
    let mut m = tied(true);
    let mesh = parts([[4, 2], [3, 3]]);
    let options = TransientAnalysis {
        scheme: Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 }),
        time_step: Some(5e-3),
        ..TransientAnalysis::new(1.5)
    };
    m.analysis = Analysis::Transient(options.clone());
    m.initial_velocities = vec![
        InitialVelocity {
            on: "part0".into(),
            velocity: [0.0; 3],
            angular_velocity: [1.0, 2.0, 0.5],
            center: [1.0, 0.2, 0.0],
        },
        InitialVelocity {
            on: "part1".into(),
            velocity: [0.0; 3],
            angular_velocity: [1.0, 2.0, 0.5],
            center: [1.0, 0.2, 0.0],
        },
    ];
    let system = compile::build(&m, &mesh).unwrap();
    let mut notes = Notes::keeping();
    dynamics::run(&system, &options, None, &mut notes).unwrap();
    assert!(notes.drift() <= 1e-9 * notes.kinetic, "{}", notes.drift());
    let [first, last] = [notes.states.first().unwrap(), notes.states.last().unwrap()];
    let [(p, l), (q, k)] = [first, last].map(|state| system.momentum(&state.u, &state.v));
    assert!((p - q).norm() < 1e-9 * l.norm() && (l - k).norm() < 1e-9 * l.norm(), "{p} {q} {l} {k}");
    let joint = &system.joints[0];
    let of = |v: usize| Vec3::from(system.coordinates.reference[v]) + Vec3::from(last.u[v]);
    let open =
        joint.with_vectors(of, |v, _| joint.rows.iter().map(|row| row.form(v).abs()).fold(0.0, larger));
    assert!(open < 1e-9, "{open}");
    assert!(max_norm(last.u.iter().flatten()) > 0.5);
}

/// Nodes beside the elements, and nodes of the elements themselves, are refused.
#[test]
fn nodes_that_cannot_follow_are_refused() {
    let refused = |on: &str, to: &str, joint: &str| {
        let mut m = tied(true);
        m.conditions = vec![Condition::Clamp(OnSet { on: "u_min0".into() })];
        m.loads = vec![Load::Edge(vector_load("u_max1", [1.0, 0.0, 0.0]))];
        m.ties = vec![Tie { on: on.into(), to: to.into(), ..tie(true) }];
        m.joints = vec![revolute(joint, "ground", "u_min_v_min0", [0.0; 3], [0.0, 1.0, 0.0])];
        let Err(Error::Model(issues)) = compile::build(&m, &parts([[2, 2], [3, 3]])) else { panic!() };
        issues.iter().map(|issue| format!("{} {}\n", issue.place, issue.message)).collect::<String>()
    };
    let far = refused("u_max1", "part0", "hinge");
    assert!(far.contains("ties[0].on") && far.contains("beside all elements"), "{far}");
    let twice = refused("u_min1", "part0", "tie");
    assert!(twice.contains("ties[0].name"), "{twice}");
    let own = refused("u_min1", "part1", "hinge");
    assert!(own.contains("which it would have to follow"), "{own}");
}
