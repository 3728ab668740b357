//! Forces and moments that turn with nodes and bodies: the elastica under a follower force, and bodies with thrusters.

use crate::common::{compile, displacement, model, on, plate, static_options, vector_load};

use tegula::analysis::{Observer, Silent, State, Step, dynamics, statics};
use tegula::model::*;
use tegula::{Mesh, Result, System, Vec3};

/// Position of the end of a clamped beam of length 1 that bends and does not stretch, over the length, under a force P across it that turns
/// with its end, over EI/L². Seen from the end, the curvature is the force times the distance along its tangent: the initial value problem
/// x' = −cos φ, z' = −sin φ, φ' = P x begins there with zeros, and needs no search.
fn elastica_under_follower_force(force: f64) -> [f64; 2] {
    let steps = 2000;
    let h = 1.0 / f64::from(steps);
    let rate = |y: [f64; 3]| [-y[2].cos(), -y[2].sin(), force * y[0]];
    let moved = |y: [f64; 3], k: [f64; 3], h: f64| std::array::from_fn(|i| y[i] + h * k[i]);
    let mut y = [0.0; 3];
    for _ in 0..steps {
        let k1 = rate(y);
        let k2 = rate(moved(y, k1, 0.5 * h));
        let k3 = rate(moved(y, k2, 0.5 * h));
        let k4 = rate(moved(y, k3, h));
        y = std::array::from_fn(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]));
    }
    // The clamp, seen from the end, becomes the origin with the tangent along x.
    let (sin, cos) = y[2].sin_cos();
    [-(cos * y[0] + sin * y[1]), -(cos * y[1] - sin * y[0])]
}

const YOUNG: f64 = 1.2e8;
const THICKNESS: f64 = 0.01;
const WIDTH: f64 = 0.1;

/// EI of the strip and of the beam, 1.
fn bending() -> f64 {
    YOUNG * WIDTH * THICKNESS.powi(3) / 12.0
}

fn strip(loads: Vec<Load>) -> Model {
    let mut m = model(plate([1.0, WIDTH], [32, 1], 0.0), YOUNG, THICKNESS);
    m.materials.values_mut().for_each(|material| {
        if let Material::Isotropic(i) = material {
            i.poisson = 0.0;
        }
    });
    m.conditions = vec![Condition::Clamp(on("u_min"))];
    m.analysis = Analysis::Static(StaticAnalysis { load_steps: 10, ..Default::default() });
    Model { loads, ..m }
}

fn beam(loads: Vec<Load>) -> Model {
    let section = BeamSection::Rectangle(RectangularSection { size: [THICKNESS, WIDTH] });
    let line = [[0.0; 3], [1.0, 0.0, 0.0]];
    let clamp = PointJoint {
        name: "clamp".into(),
        between: ["ground".into(), "beam.start".into()],
        at: [0.0; 3],
        second_at: None,
    };
    let analysis = Analysis::Static(StaticAnalysis { load_steps: 10, ..Default::default() });
    let mut m = Model::of_bodies(analysis, Vec::new(), vec![Joint::Fixed(clamp)]);
    let material = Isotropic { young: YOUNG, poisson: 0.0, density: 1.0, expansion: 0.0, strength: None };
    m.materials.insert("material".into(), Material::Isotropic(material));
    let beam = Beam::straight("beam", line, 64, [0.0, 0.0, 1.0], section);
    Model { beams: vec![Beam { material: Some("material".into()), ..beam }], loads, ..m }
}

fn place(system: &System, state: &State, body: &str) -> Vec3 {
    let body = system.coordinates.bodies.iter().find(|b| b.name == body).unwrap();
    Vec3::from(system.coordinates.reference[body.centre as usize]) + Vec3::from(state.u[body.centre as usize])
}

#[test]
fn cantilevers_under_a_follower_force_are_elasticas() {
    for force in [1.0, 3.0, 8.0] {
        let [x, z] = elastica_under_follower_force(force / bending());
        let total = |share: f64| [0.0, 0.0, force * share];
        let m = strip(vec![Load::FollowerForce(vector_load("u_max", total(0.5)))]);
        let (mesh, system) = compile(&m);
        let outcome = statics::run(&system, &static_options(&m), None, &mut Silent).unwrap();
        let end = Vec3::new(1.0, 0.0, 0.0) + displacement(&mesh, &system, &outcome.state.u, "u_max_v_max");
        println!("P = {force}: strip {} {}, exact {x} {z}", end.x, end.z);
        assert!((end.x - x).abs() < 2e-3 && (end.z - z).abs() < 2e-3, "strip: {end}, {x} {z}");
        assert_eq!(outcome.statistics.cutbacks, 0);
        // Newton's method has the exact tangent: about five iterations a step.
        assert!(outcome.statistics.iterations <= 65, "{}", outcome.statistics.iterations);

        let m = beam(vec![Load::FollowerForce(vector_load("beam.end", total(1.0)))]);
        let (_, system) = compile(&m);
        let outcome = statics::run(&system, &static_options(&m), None, &mut Silent).unwrap();
        let end = place(&system, &outcome.state, "beam.end");
        println!("        beam {} {}", end.x, end.z);
        assert!((end.x - x).abs() < 2e-3 && (end.z - z).abs() < 2e-3, "beam: {end}, {x} {z}");
        assert_eq!(outcome.statistics.cutbacks, 0);
    }
}

/// A moment in the plane of bending is the same whether it turns with the end or not: the strip becomes an arc.
#[test]
fn a_follower_moment_in_the_plane_of_bending_rolls_up_cantilevers() {
    let angle = 2.0_f64;
    let total = |share: f64| [0.0, -angle * bending() * share, 0.0];
    let exact = Vec3::new(angle.sin(), 0.0, 1.0 - angle.cos()) / angle;
    let m = strip(vec![Load::FollowerMoment(vector_load("u_max", total(0.5)))]);
    let (mesh, system) = compile(&m);
    let outcome = statics::run(&system, &static_options(&m), None, &mut Silent).unwrap();
    let end = Vec3::new(1.0, WIDTH, 0.0) + displacement(&mesh, &system, &outcome.state.u, "u_max_v_max");
    let middle = Vec3::new(end.x, 0.0, end.z);
    assert!((middle - exact).norm() < 1e-3, "{middle} {exact}");
    let m = beam(vec![Load::FollowerMoment(vector_load("beam.end", total(1.0)))]);
    let (_, system) = compile(&m);
    let outcome = statics::run(&system, &static_options(&m), None, &mut Silent).unwrap();
    let end = place(&system, &outcome.state, "beam.end");
    assert!((end - exact).norm() < 1e-3, "{end} {exact}");
}

/// Free body with a thruster along its axis 1 and a moment about its axis 3, which both turn with it.
fn thrusters(scheme: Scheme, time_step: f64) -> Vec3 {
    let analysis = TransientAnalysis { scheme, time_step: Some(time_step), ..TransientAnalysis::new(2.0) };
    let body = RigidBody::new("body", [0.0; 3], 2.0, Some([0.05, 0.06, INERTIA]));
    let mut m = Model::of_bodies(Analysis::Transient(analysis.clone()), vec![body], Vec::new());
    m.loads = vec![
        Load::FollowerForce(vector_load("body", [3.0, 0.0, 0.0])),
        Load::FollowerMoment(vector_load("body", [0.0, 0.0, MOMENT])),
    ];
    let (_, system) = compile(&m);
    let outcome = dynamics::run(&system, &analysis, None, &mut Silent).unwrap();
    place(&system, &outcome.state, "body")
}

const MOMENT: f64 = 0.04;
const INERTIA: f64 = 0.02;

/// Twice integrated acceleration F/m (cos θ, sin θ) with θ = ½ M/J t²: `∫ (T − t) F/m (cos θ, sin θ) dt`, by Simpson's rule.
#[test]
fn a_body_with_thrusters_moves_along_a_spiral_with_every_scheme() {
    let (end, n) = (2.0, 2000);
    let acceleration = |t: f64| {
        let angle = 0.5 * MOMENT / INERTIA * t * t;
        Vec3::new(angle.cos(), angle.sin(), 0.0) * (1.5 * (end - t))
    };
    let weight = |i: i32| {
        f64::from(if i == 0 || i == n {
            1
        } else if i % 2 == 1 {
            4
        } else {
            2
        })
    };
    let h = end / f64::from(n);
    let exact: Vec3 = (0..=n).map(|i| acceleration(f64::from(i) * h) * (weight(i) * h / 3.0)).sum();
    let schemes = [
        Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 }),
        Scheme::EnergyMomentum(EnergyMomentumScheme { order: 4 }),
        Scheme::GeneralizedAlpha(GeneralizedAlphaScheme::default()),
        Scheme::Bdf2(Bdf2Scheme::default()),
        Scheme::Explicit(ExplicitScheme::default()),
    ];
    for scheme in schemes {
        let [coarse, fine] = [0.02, 0.01].map(|step| (thrusters(scheme, step) - exact).norm());
        println!("{scheme:?}: {coarse:.3e} {fine:.3e} of {}", exact.norm());
        assert!(fine < 1e-3 * exact.norm(), "{scheme:?}: {fine}");
        assert!(fine < 0.3 * coarse || fine < 1e-12, "second order: {scheme:?}: {coarse} {fine}");
    }
}

#[test]
fn point_masses_refuse_loads_that_turn() {
    let mass = RigidBody::new("mass", [0.0; 3], 1.0, None);
    for (load, told) in [
        (
            Load::FollowerForce(vector_load("mass", [1.0, 0.0, 0.0])),
            "which has no axes that a force could turn with",
        ),
        (Load::FollowerMoment(vector_load("mass", [1.0, 0.0, 0.0])), "on which a moment cannot act"),
    ] {
        let scheme = Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 });
        let analysis = TransientAnalysis { scheme, ..TransientAnalysis::new(1.0) };
        let mut m = Model::of_bodies(Analysis::Transient(analysis), vec![mass.clone()], Vec::new());
        m.loads = vec![load];
        let mesh = tegula::mesh::generators::generate(&m.mesh).unwrap();
        let refused = tegula::compile::build(&m, &mesh).map(|_| ()).unwrap_err().to_string();
        assert!(refused.contains(told), "{refused}");
    }
}

/// Largest deflections of the end in the fifths of 6 s of a strip under a follower force along its axis, which is disturbed by 1e-6 of its length per second.
fn deflections_of_becks_column(force: f64) -> Vec<f64> {
    let mut m = strip(vec![Load::FollowerForce(vector_load("u_max", [-0.5 * force, 0.0, 0.0]))]);
    if let MeshSource::Plate(mesh) = &mut m.mesh {
        mesh.grid.elements = [16, 1];
    }
    m.materials.values_mut().for_each(|material| {
        if let Material::Isotropic(i) = material {
            i.density = 1000.0;
        }
    });
    let disturbance = InitialVelocity {
        on: "u_max".into(),
        velocity: [0.0, 0.0, 1e-6],
        angular_velocity: [0.0; 3],
        center: [0.0; 3],
    };
    m.initial_velocities = vec![disturbance];
    let scheme = Scheme::GeneralizedAlpha(GeneralizedAlphaScheme { spectral_radius: 0.9 });
    let analysis = TransientAnalysis { scheme, time_step: Some(0.01), ..TransientAnalysis::new(6.0) };
    m.analysis = Analysis::Transient(analysis.clone());
    let mut heights = Heights::default();
    let (mesh, system) = compile(&m);
    heights.vector =
        system.coordinates.position_of[mesh.nodes_on("u_max_v_max").unwrap()[0] as usize] as usize;
    dynamics::run(&system, &analysis, None, &mut heights).unwrap();
    let all = &heights.of_steps;
    all.chunks(all.len().div_ceil(5))
        .map(|part| part.iter().copied().fold(0.0, tegula::norm::larger))
        .collect()
}

/// Records the height of a node at every step.
#[derive(Default)]
struct Heights {
    vector: usize,
    of_steps: Vec<f64>,
}

impl Observer for Heights {
    fn on_step(&mut self, step: &Step) -> Result<()> {
        self.of_steps.push(step.state.u[self.vector][2].abs());
        Ok(())
    }
}

/// M. Beck, *Die Knicklast des einseitig eingespannten, tangential gedrückten Stabes*, ZAMP 3 (1952) 225–228: 20.05 EI/L². The unstable
/// strip at 22 grows by far more than an order of magnitude in each fifth of the time, the stable one at 18 does not.
#[test]
#[ignore = "long"]
fn becks_column_flutters_above_its_critical_force() {
    let stable = deflections_of_becks_column(18.0 * bending());
    assert!(stable[4] > 0.0 && stable[4] < 1.2 * stable[0], "{stable:?}");
    let unstable = deflections_of_becks_column(22.0 * bending());
    assert!(unstable[1] > 10.0 * unstable[0] && unstable[2] > 10.0 * unstable[1], "{unstable:?}");
}

/// Loads on single nodes in the middle of a square mesh, whose edges are as near to the load as each other, and at a corner.
#[test]
fn follower_loads_on_shells_do_not_depend_on_the_numbering_of_the_mesh() {
    let source = plate([1.0, 1.0], [4, 4], 0.0);
    let mesh = tegula::mesh::generators::generate(&source).unwrap();
    let middle =
        (0..).zip(&mesh.positions).find(|(_, x)| (*x - Vec3::new(0.5, 0.5, 0.0)).norm() < 1e-9).unwrap().0;
    for load in [
        Load::FollowerMoment(vector_load("middle", [0.0, 0.0, 30.0])),
        Load::FollowerMoment(vector_load("u_max_v_max", [0.1, 0.2, 3.0])),
        Load::FollowerForce(vector_load("middle", [100.0, 100.0, 1.0])),
    ] {
        let of = |mut mesh: Mesh| {
            mesh.node_sets.insert("middle".into(), vec![middle]);
            let mut m = model(source.clone(), YOUNG, THICKNESS);
            m.conditions = vec![Condition::Clamp(on("u_min"))];
            m.analysis = Analysis::Static(StaticAnalysis::default());
            m.loads = vec![load.clone()];
            let system = tegula::compile::build(&m, &mesh).unwrap();
            let outcome = statics::run(&system, &static_options(&m), None, &mut Silent).unwrap();
            displacement(&mesh, &system, &outcome.state.u, "u_max_v_min")
        };
        let first = of(mesh.clone());
        let mut turned = mesh.clone();
        for (i, quad) in turned.quads.iter_mut().enumerate() {
            quad.rotate_left(i % 4);
        }
        turned.quads.reverse();
        let other = of(turned);
        assert!(
            first.norm() > 1e-6 && (first - other).norm() < 1e-8 * first.norm(),
            "{load:?}: {first} {other}"
        );
    }
}
