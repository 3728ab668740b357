//! Totals: masses, resultants of loads and their moments, reactions.

use crate::common::{Random, compile, model, on, plate, quarter_cylinder, resultant, solve, vector_load};
use tegula::analysis::State;
use tegula::analysis::statics::reactions;
use tegula::compile::build;
use tegula::element::{Motion, Nodal};
use tegula::model::*;
use tegula::norm::larger;
use tegula::system::Assembly;
use tegula::system::assembly::add_follower_loads;
use tegula::{Mesh, System, Vec3};

/// All loads at full value and displacements `u`.
fn loads(system: &System, u: &[Nodal]) -> Vec<Nodal> {
    let mut f = vec![[0.0; 3]; system.vectors()];
    system.add_dead_loads(1.0, 1.0, &mut f);
    add_follower_loads(system, &Motion::State { u, velocity: None }, 1.0, 1.0, &mut f);
    f
}

/// Resultant and moment of the loads of a model in its reference configuration.
fn reference_resultant(model: &Model) -> (Vec3, Vec3) {
    let (_, system) = compile(model);
    let u = vec![[0.0; 3]; system.vectors()];
    resultant(&system, &u, &loads(&system, &u))
}

fn close(found: Vec3, exact: Vec3, scale: f64) {
    assert!((found - exact).norm() <= 1e-12 * scale, "{found:?} instead of {exact:?}");
}

/// A distorted plate of 2 × 1.5 in a plane of its own.
fn inclined_plate() -> (Model, Vec3, Vec3) {
    let (u, v) = (Vec3::new(0.6, 0.8, 0.0), Vec3::new(-0.48, 0.36, 0.8));
    let mut source = plate([2.0, 1.5], [5, 4], 0.35);
    if let MeshSource::Plate(p) = &mut source {
        p.origin = [0.3, -0.2, 0.7];
        p.u_axis = u.into();
        p.v_axis = v.into();
    }
    let mut m = model(source, 1e6, 0.02);
    m.loads = vec![Load::Force(vector_load("u_max", [0.0, 0.0, 1.0]))];
    (m, u, v)
}

fn middle(u: Vec3, v: Vec3) -> Vec3 {
    Vec3::new(0.3, -0.2, 0.7) + u + v * 0.75
}

#[test]
fn mass_is_density_times_volume() {
    let (mut m, ..) = inclined_plate();
    m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(1e6, 0.3, 7850.0)));
    let (_, system) = compile(&m);
    let exact = 7850.0 * 0.02 * 3.0;
    assert!((system.total_mass() - exact).abs() < 1e-12 * exact);
    // Facets of a cylinder are as wide as their chords.
    let mut m = quarter_cylinder(8, 2.1e8);
    m.loads = vec![Load::Force(vector_load("u_max", [0.0, 0.0, 1.0]))];
    let (_, cylinder) = compile(&m);
    let exact = 0.01 * 8.0 * 2.0 * (std::f64::consts::FRAC_PI_2 / 16.0).sin();
    assert!((cylinder.total_mass() - exact).abs() < 1e-12 * exact);
}

#[test]
fn total_mass_is_met() {
    let mut m = quarter_cylinder(6, 2.1e7);
    m.sections[0].total_mass = Some(5.0);
    m.loads = vec![Load::Force(vector_load("u_max", [0.0, 0.0, 1.0]))];
    let (_, system) = compile(&m);
    assert!((system.total_mass() - 5.0).abs() < 5e-12);
    // Layers beside a curved mesh have another area than the mesh.
    for offset in [0.02, -0.05] {
        let plies = vec![LayupPly { material: None, angle: 0.0, thickness: Some(0.01) }];
        let material = Some(m.sections[0].material.clone()).filter(|name| !name.is_empty());
        let layup = Layup { plies, material, offset, ..Layup::default() };
        let section = Section { total_mass: Some(5.0), layup: Some(layup), ..Section::new("", 0.0) };
        let (_, system) = compile(&Model { sections: vec![section], ..m.clone() });
        assert!((system.total_mass() - 5.0).abs() < 5e-12, "{offset}: {}", system.total_mass());
    }
}

#[test]
fn added_masses_add_up() {
    let (mut m, ..) = inclined_plate();
    let bare = compile(&m).1.total_mass();
    let mass = |on: &str, value| MassOn { on: on.into(), value };
    m.masses = vec![
        AddedMass::Point(mass("u_max_v_max", 0.7)),
        AddedMass::Point(mass("v_min", 0.01)),
        AddedMass::Edge(mass("u_max", 2.0)),
        AddedMass::Area(mass("all", 0.3)),
    ];
    let exact = bare + 0.7 + 6.0 * 0.01 + 2.0 * 1.5 + 0.3 * 3.0;
    let (_, system) = compile(&m);
    assert!((system.total_mass() - exact).abs() < 1e-12 * exact);
    // The momentum of a translation is mass times velocity, its energy ½ m v².
    let v: Vec<Nodal> = system
        .coordinates
        .kinds
        .iter()
        .map(|k| if *k == tegula::system::VectorKind::Position { [1.0, -2.0, 0.5] } else { [0.0; 3] })
        .collect();
    let (p, _) = system.momentum(&vec![[0.0; 3]; v.len()], &v);
    close(p, Vec3::new(1.0, -2.0, 0.5) * exact, exact);
    assert!((system.kinetic_energy(&v) - 0.5 * exact * 5.25).abs() < 1e-12 * exact);
}

#[test]
fn weight_is_mass_times_gravity() {
    let (mut m, u, v) = inclined_plate();
    m.masses = vec![AddedMass::Point(MassOn { on: "u_max_v_max".into(), value: 0.7 })];
    let g = Vec3::new(1.0, -3.0, -9.81);
    m.loads = vec![Load::Gravity(GravityLoad { value: g.into(), amplitude: None })];
    let (force, moment) = reference_resultant(&m);
    let plate = 0.02 * 3.0;
    let corner = Vec3::new(0.3, -0.2, 0.7) + u * 2.0 + v * 1.5;
    close(force, g * (plate + 0.7), 10.0);
    close(moment, middle(u, v).cross(&g) * plate + corner.cross(&g) * 0.7, 10.0);
}

#[test]
fn edge_loads_tractions_and_forces_have_their_resultants() {
    let (base, u, v) = inclined_plate();
    let q = Vec3::new(3.0, -1.0, 2.0);
    let edge_middle = Vec3::new(0.3, -0.2, 0.7) + u * 2.0 + v * 0.75;
    let corner = Vec3::new(0.3, -0.2, 0.7) + u * 2.0;
    let cases = [
        (Load::Edge(vector_load("u_max", q.into())), 1.5, edge_middle),
        (Load::Traction(vector_load("all", q.into())), 3.0, middle(u, v)),
        (Load::Force(vector_load("u_max_v_min", q.into())), 1.0, corner),
    ];
    for (load, size, point) in cases {
        let m = Model { loads: vec![load], ..base.clone() };
        let (force, moment) = reference_resultant(&m);
        close(force, q * size, 10.0);
        close(moment, point.cross(&q) * size, 10.0);
    }
    // A force on a set acts on each of its nodes.
    let m = Model { loads: vec![Load::Force(vector_load("u_max", q.into()))], ..base };
    close(reference_resultant(&m).0, q * 5.0, 20.0);
}

#[test]
fn pressure_acts_against_the_director() {
    let (mut m, u, v) = inclined_plate();
    m.loads = vec![Load::Pressure(PressureLoad {
        on: "all".into(),
        value: 5.0,
        amplitude: None,
        distribution: None,
    })];
    let (force, moment) = reference_resultant(&m);
    let exact = u.cross(&v) * -15.0;
    close(force, exact, 15.0);
    close(moment, middle(u, v).cross(&exact), 15.0);
}

/// A moment turns the director and so acts across it: with m ⟂ d the resultant is m; what m has
/// along d is lost, because a director does not feel rotation about itself. An edge feels it.
#[test]
fn moments_across_the_directors_have_their_resultants() {
    let (base, u, v) = inclined_plate();
    let bending = u * 2.0 - v * 3.0;
    let twist = u.cross(&v);
    let oblique = bending + twist * 3.0;
    let cases = [
        (Load::Moment(vector_load("u_max_v_max", bending.into())), bending),
        (Load::EdgeMoment(vector_load("u_max", bending.into())), bending * 1.5),
        (Load::EdgeMoment(vector_load("u_max", oblique.into())), oblique * 1.5),
    ];
    for (load, exact) in cases {
        let m = Model { loads: vec![load], ..base.clone() };
        let (force, moment) = reference_resultant(&m);
        close(force, Vec3::zeros(), 5.0);
        close(moment, exact, 5.0);
    }
    // Along a director alone nothing resists: the moment is refused, not lost.
    let m = Model { loads: vec![Load::Moment(vector_load("u_max_v_max", twist.into()))], ..base };
    let mesh = tegula::mesh::generators::generate(&m.mesh).unwrap();
    let Err(tegula::Error::Model(issues)) = tegula::compile::build(&m, &mesh) else { panic!("not refused") };
    assert!(issues[0].message.contains("would be dropped"), "{issues:?}");
    assert_eq!(issues[0].place.key, "loads[0].value");
}

#[test]
fn follower_pressure_on_a_deformed_surface() {
    // Gauss: the resultant depends on the boundary only, −p ½ ∮ x × dx; here of a straight-edged loop.
    let (mut m, ..) = inclined_plate();
    m.loads = vec![Load::Pressure(PressureLoad {
        on: "all".into(),
        value: 5.0,
        amplitude: None,
        distribution: None,
    })];
    let (mesh, system) = compile(&m);
    let mut random = Random::new(5);
    let u: Vec<Nodal> = (0..system.vectors()).map(|_| (random.vector() * 0.3).into()).collect();
    let (force, _) = resultant(&system, &u, &loads(&system, &u));
    let current = |n: u32| {
        mesh.positions[n as usize] + Vec3::from(u[system.coordinates.position_of[n as usize] as usize])
    };
    let loop_area: Vec3 =
        mesh.boundary_edges().into_iter().map(|[a, b]| current(a).cross(&current(b)) * 0.5).sum();
    // The direction of the loop is that of the elements.
    let exact = loop_area * -5.0;
    assert!((force - exact).norm() < 1e-12 * 20.0, "{force:?} instead of {exact:?}");
}

/// A cube of 2 × 2 elements a face.
fn cube() -> Mesh {
    let mut mesh = Mesh::default();
    let mut numbers = std::collections::BTreeMap::new();
    let mut node = |p: [i32; 3], mesh: &mut Mesh| {
        *numbers.entry(p).or_insert_with(|| {
            mesh.positions.push(Vec3::from(p.map(|x| 0.5 * f64::from(x))));
            mesh.positions.len() as u32 - 1
        })
    };
    for axis in 0..3 {
        for side in [0, 2] {
            for i in 0..2 {
                for j in 0..2 {
                    let mut quad = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[a, b]| {
                        let mut p = [0; 3];
                        p[axis] = side;
                        p[(axis + 1) % 3] = i + a;
                        p[(axis + 2) % 3] = j + b;
                        node(p, &mut mesh)
                    });
                    if side == 0 {
                        quad.reverse();
                    }
                    mesh.quads.push(quad);
                }
            }
        }
    }
    mesh.node_sets.insert("support".into(), vec![0]);
    mesh
}

#[test]
fn pressure_on_a_closed_surface_has_no_resultant() {
    let mut m = model(plate([1.0; 2], [1, 1], 0.0), 1e6, 0.01);
    m.conditions = vec![Condition::Clamp(on("support"))];
    m.loads = vec![Load::Pressure(PressureLoad {
        on: "all".into(),
        value: 3.0,
        amplitude: None,
        distribution: None,
    })];
    let mesh = cube();
    let system = build(&m, &mesh).unwrap();
    let mut random = Random::new(9);
    for scale in [0.0, 0.2] {
        let u: Vec<Nodal> = (0..system.vectors()).map(|_| (random.vector() * scale).into()).collect();
        let f = loads(&system, &u);
        let (force, moment) = resultant(&system, &u, &f);
        close(force, Vec3::zeros(), 3.0);
        close(moment, Vec3::zeros(), 3.0);
        assert!(f.iter().any(|f| Vec3::from(*f).norm() > 0.1));
    }
}

/// Reactions and loads of a converged, largely deformed structure are in balance, forces and moments.
fn check_balance(m: &Model) {
    let (_, system, outcome) = solve(m);
    let state: &State = &outcome.state;
    let mut assembly = Assembly::new(&system);
    let reaction = reactions(&system, &mut assembly, state);
    let (force, moment) = resultant(&system, &state.u, &loads(&system, &state.u));
    let (r_force, r_moment) = resultant(&system, &state.u, &reaction);
    let scale = larger(force.norm(), moment.norm());
    assert!((force + r_force).norm() < 1e-12 * scale, "{:e} of {scale}", (force + r_force).norm());
    assert!((moment + r_moment).norm() < 1e-12 * scale, "{:e} of {scale}", (moment + r_moment).norm());
}

#[test]
fn reactions_balance_the_loads() {
    let mut m = model(plate([1.0, 1.0], [5, 4], 0.3), 2.1e8, 0.02);
    m.loads = vec![
        Load::Force(vector_load("u_max_v_min", [1.0, 2.0, -30.0])),
        // Loads on supported nodes go straight into the support.
        Load::Force(vector_load("u_min", [11.0, -7.0, 5.0])),
        Load::Edge(vector_load("v_min", [0.0, 1.0, 9.0])),
        Load::Pressure(PressureLoad { on: "all".into(), value: 20.0, amplitude: None, distribution: None }),
        Load::EdgeMoment(vector_load("u_max", [0.0, 4.0, 0.0])),
        Load::Moment(vector_load("u_min_v_max", [3.0, 1.0, 0.0])),
        Load::Gravity(GravityLoad { value: [0.0, 0.0, -9.81], amplitude: None }),
    ];
    check_balance(&m);
    let mut m = quarter_cylinder(6, 2.1e8);
    m.loads = vec![Load::Force(vector_load("u_max_v_max", [0.0, 0.0, -20.0]))];
    check_balance(&m);
}

#[test]
fn reactions_of_a_linear_model_balance_in_the_reference() {
    let mut m = model(plate([1.0, 1.0], [4, 4], 0.3), 1e4, 0.1);
    m.analysis = Analysis::Static(StaticAnalysis { linear: true, ..Default::default() });
    m.loads = vec![
        Load::Force(vector_load("u_max_v_min", [1.0, 2.0, -3.0])),
        Load::Force(vector_load("u_min", [1.0, -7.0, 5.0])),
        Load::Traction(vector_load("all", [0.3, 0.2, 1.0])),
    ];
    let (_, system, outcome) = solve(&m);
    let reaction = reactions(&system, &mut Assembly::new(&system), &outcome.state);
    let zero = vec![[0.0; 3]; system.vectors()];
    let (force, moment) = resultant(&system, &zero, &loads(&system, &zero));
    let (r_force, r_moment) = resultant(&system, &zero, &reaction);
    close(-r_force, force, force.norm());
    close(-r_moment, moment, moment.norm());
}

#[test]
fn loads_and_supports_of_nodes_without_elements_are_refused() {
    let mut m = model(plate([1.0, 1.0], [2, 2], 0.0), 1e5, 0.1);
    let mut mesh = tegula::mesh::generators::generate(&m.mesh).unwrap();
    let loose = mesh.positions.len() as u32;
    mesh.positions.push(Vec3::new(5.0, 5.0, 5.0));
    mesh.node_sets.insert("loose".into(), vec![0, loose]);
    m.loads = vec![
        Load::Moment(vector_load("loose", [1.0, 0.0, 0.0])),
        Load::Force(vector_load("loose", [1.0; 3])),
    ];
    m.conditions.push(Condition::Clamp(OnSet { on: "loose".into() }));
    let Err(tegula::Error::Model(issues)) = tegula::compile::build(&m, &mesh) else { panic!("not refused") };
    let named = issues.iter().filter(|i| i.message.contains("belongs to no element")).count();
    assert_eq!(named, 3, "{issues:?}");
}
