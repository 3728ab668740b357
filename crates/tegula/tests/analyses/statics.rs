//! Statics of the paper (Sects. 5.1 and 5.2) and the behaviour of the solver.
//!
//! Numbers with a source are those of an independent implementation of the element, which OpenSees'
//! MITC4 shell confirms to all digits in Sect. 5.1, and which converges with three other codes to the
//! same values in Sect. 5.2.

use crate::common::{
    Notes, compile, cylinder, displacement, model, on, plate, quarter_cylinder, side_by_side, solve,
    static_options, vector_load,
};
use crate::multibody::spring;
use crate::patches::{clamped, hub, strip};
use tegula::analysis::statics::{self, StaticOutcome};
use tegula::analysis::{Silent, State};
use tegula::compile::build;
use tegula::mesh::generators::generate;
use tegula::model::*;
use tegula::norm::max_norm;
use tegula::result::reactions::ReactionFinder;
use tegula::system::VectorKind;
use tegula::{Error, Mesh, Vec3};

/// ans_shear, ans_thickness, eas.
type Remedies = [bool; 3];

fn with_remedies(mut m: Model, [shear, thickness, eas]: Remedies) -> Model {
    m.sections[0].ans_shear = shear;
    m.sections[0].ans_thickness = thickness;
    m.sections[0].eas = eas;
    m
}

/// Sect. 5.1: square cantilever plate under an edge load, linear.
fn cantilever_plate(n: u32, thickness: f64, load: f64) -> Model {
    let mut m = model(plate([1.0, 1.0], [n, n], 0.0), 2.1e11, thickness);
    if let MeshSource::Plate(p) = &mut m.mesh {
        p.grid.points.insert("mid_edge".into(), [1.0, 0.5, 0.0]);
    }
    m.loads = vec![Load::Edge(vector_load("u_max", [0.0, 0.0, -load]))];
    m.analysis = Analysis::Static(StaticAnalysis { linear: true, ..Default::default() });
    m
}

#[test]
fn cantilever_plate_of_section_5_1() {
    // thickness, edge load; remedies, w of corner and of the middle of the edge on 4 × 4.
    let all = [true; 3];
    let (no_shear, no_thick, no_eas) = ([false, true, true], [true, false, true], [true, true, false]);
    let cases: [(f64, f64, Remedies, f64, f64); 15] = [
        (1e-3, 5e-2, all, -8.626936740e-04, -8.873005227e-04),
        (1e-3, 5e-2, no_shear, -4.754026549e-08, -4.754030550e-08),
        (1e-3, 5e-2, no_thick, -8.626936740e-04, -8.873005227e-04),
        (1e-3, 5e-2, no_eas, -8.626936740e-04, -8.873005227e-04),
        (1e-3, 5e-2, [false; 3], -4.754026549e-08, -4.754030550e-08),
        (1e-2, 5e1, all, -8.628310822e-04, -8.874476303e-04),
        (1e-2, 5e1, no_shear, -4.728510751e-06, -4.728915521e-06),
        (1e-2, 5e1, no_thick, -8.628310822e-04, -8.874476303e-04),
        (1e-2, 5e1, no_eas, -8.628310822e-04, -8.874476303e-04),
        (1e-2, 5e1, [false; 3], -4.728510751e-06, -4.728915521e-06),
        (1e-1, 5e4, all, -8.737538080e-04, -8.991662228e-04),
        (1e-1, 5e4, no_shear, -3.094678492e-04, -3.122652262e-04),
        (1e-1, 5e4, no_thick, -8.737538080e-04, -8.991662228e-04),
        (1e-1, 5e4, no_eas, -8.737538080e-04, -8.991662228e-04),
        (1e-1, 5e4, [false; 3], -3.094678492e-04, -3.122652262e-04),
    ];
    for (thickness, load, remedies, corner, middle) in cases {
        let m = with_remedies(cantilever_plate(4, thickness, load), remedies);
        let (mesh, system, outcome) = solve(&m);
        let w = |set| displacement(&mesh, &system, &outcome.state.u, set).z;
        for (found, exact) in
            [(w("u_max_v_min"), corner), (w("u_max_v_max"), corner), (w("mid_edge"), middle)]
        {
            assert!((found / exact - 1.0).abs() < 5e-9, "{thickness} {remedies:?}: {found:e} for {exact:e}");
        }
    }
}

/// Sect. 5.2, set-up S1: force down at the corner (1, 1, 1).
fn corner_force(n: u32) -> Model {
    let mut m = quarter_cylinder(n, 2.1e8);
    m.loads = vec![Load::Force(vector_load("u_max_v_max", [0.0, 0.0, -20.0]))];
    m
}

/// n, remedies, displacement of the loaded corner, u_z of the other free corner, strain energy.
type CornerCase = (u32, Remedies, [f64; 3], f64, f64);

fn check_corner(case: &CornerCase) -> StaticOutcome {
    let &(n, remedies, corner, other, energy) = case;
    let (mesh, system, outcome) = solve(&with_remedies(corner_force(n), remedies));
    let u = displacement(&mesh, &system, &outcome.state.u, "u_max_v_max");
    assert!((u - Vec3::from(corner)).norm() < 2e-9, "{n} {remedies:?}: {u:?}");
    let u = displacement(&mesh, &system, &outcome.state.u, "u_max_v_min");
    assert!((u.z - other).abs() < 2e-9, "{n} {remedies:?}: {}", u.z);
    assert!((outcome.balance.strain - energy).abs() < 2e-9, "{n} {remedies:?}: {}", outcome.balance.strain);
    outcome
}

#[test]
fn quarter_cylinder_of_section_5_2() {
    let all = [true; 3];
    let cases: [CornerCase; 9] = [
        (4, all, [0.550805282, 0.004817232, -1.111460771], -0.859536051, 12.050379636),
        (8, all, [0.552805258, 0.004844388, -1.174153681], -0.893710133, 12.748470644),
        (4, [true, true, false], [0.551169037, 0.004992663, -1.103906236], -0.856775824, 11.941840969),
        (4, [true, false, true], [0.273876366, 0.022406577, -0.217077914], -0.068786685, 2.751215474),
        (4, [false, true, true], [0.004501940, 0.002142892, -0.003357689], 0.001598444, 0.033689985),
        (4, [false; 3], [0.004119533, 0.001926079, -0.003037792], 0.001446903, 0.030479109),
        (8, [true, true, false], [0.553154452, 0.005027106, -1.169982820], -0.891358143, 12.686801626),
        (8, [false, true, true], [0.017058106, 0.007898330, -0.012516797], 0.005481614, 0.126644016),
        (8, [false; 3], [0.016776413, 0.007744516, -0.012278209], 0.005387717, 0.124235030),
    ];
    let iterations: Vec<u64> = cases
        .iter()
        .map(|c| {
            let outcome = check_corner(c);
            assert_eq!((outcome.statistics.steps, outcome.statistics.cutbacks), (1, 0));
            assert_eq!(outcome.negative_pivots, 0);
            outcome.statistics.iterations
        })
        .collect();
    assert!(iterations.iter().all(|&i| i <= 10), "one load step takes {iterations:?} iterations");
    insta::assert_debug_snapshot!(iterations, @r"
    [
        9,
        9,
        9,
        6,
        4,
        4,
        9,
        5,
        5,
    ]
    ");
}

/// A step that Newton's method cannot take is halved, and the end is the right one.
#[test]
fn cut_back_ends_at_the_right_equilibrium() {
    // Without assumed thickness strain the path is rough: in one step it takes ten iterations.
    let mut notes = Notes::default();
    let mut m = with_remedies(corner_force(8), [true, false, true]);
    m.analysis = Analysis::Static(StaticAnalysis { max_iterations: 7, ..StaticAnalysis::default() });
    let (mesh, system) = compile(&m);
    let outcome = statics::run(&system, &static_options(&m), None, &mut notes).unwrap();
    let u = displacement(&mesh, &system, &outcome.state.u, "u_max_v_max");
    let exact = Vec3::new(0.546833956, 0.005044514, -1.218487474);
    assert!((u - exact).norm() < 2e-9, "{u:?}");
    assert!((outcome.balance.strain - 13.908188295).abs() < 2e-9);
    assert!(outcome.statistics.cutbacks > 0 && outcome.statistics.steps > 1, "{:?}", outcome.statistics);
    let halved: Vec<_> = notes.events.iter().filter(|e| e.contains("cut-back to half")).collect();
    assert_eq!(halved.len() as u64, outcome.statistics.cutbacks, "{:?}", notes.events);
    let both = "displacement-based Newton did not converge either";
    assert!(halved[0].contains("node") && halved[0].contains(both), "{halved:?}");
}

/// Displacement-based Newton follows another path to the same equilibrium.
#[test]
fn displacement_based_newton_finds_the_same_equilibrium() {
    let mut m = corner_force(4);
    m.analysis = Analysis::Static(StaticAnalysis {
        method: Some(NewtonMethod::Displacement),
        load_steps: 10,
        ..Default::default()
    });
    let (mesh, system, outcome) = solve(&m);
    let u = displacement(&mesh, &system, &outcome.state.u, "u_max_v_max");
    assert!((u - Vec3::new(0.550805282, 0.004817232, -1.111460771)).norm() < 2e-9, "{u:?}");
}

/// Mesh with the node order of all quads reversed: directors point to the other side.
fn reversed(mesh: &Mesh) -> Mesh {
    let mut out = mesh.clone();
    let order = [0, 3, 2, 1];
    for quad in &mut out.quads {
        *quad = order.map(|a| quad[a]);
    }
    for normals in out.normals.iter_mut().flatten() {
        *normals = order.map(|a| -normals[a]);
    }
    out
}

#[test]
fn the_side_of_the_director_does_not_matter_to_dead_loads() {
    let m = corner_force(4);
    let (mesh, system, outcome) = solve(&m);
    let mesh_reversed = reversed(&mesh);
    let system_reversed = build(&m, &mesh_reversed).unwrap();
    let v = system.coordinates.director_of[7] as usize;
    let flipped =
        Vec3::from(system_reversed.coordinates.reference[v]) + Vec3::from(system.coordinates.reference[v]);
    assert!(flipped.norm() < 1e-14, "the directors are flipped");
    let other = statics::run(&system_reversed, &static_options(&m), None, &mut Notes::default()).unwrap();
    for set in ["u_max_v_max", "u_max_v_min", "middle"] {
        let a = displacement(&mesh, &system, &outcome.state.u, set);
        let b = displacement(&mesh_reversed, &system_reversed, &other.state.u, set);
        assert!((a - b).norm() < 1e-10, "{set}: {a:?} and {b:?}");
        assert!(b.z < 0.0, "{set} deflects against the load");
    }
    // A pressure pushes against the director and so the other way.
    let mut m = model(plate([1.0, 1.0], [3, 3], 0.0), 2.1e8, 0.05);
    m.loads = vec![Load::Pressure(PressureLoad {
        on: "all".into(),
        value: 10.0,
        amplitude: None,
        distribution: None,
    })];
    let mesh = generate(&m.mesh).unwrap();
    for (mesh, side) in [(mesh.clone(), -1.0), (reversed(&mesh), 1.0)] {
        let system = build(&m, &mesh).unwrap();
        let outcome = statics::run(&system, &static_options(&m), None, &mut Notes::default()).unwrap();
        assert!(side * displacement(&mesh, &system, &outcome.state.u, "u_max_v_max").z > 1e-4);
    }
}

/// The nonlinear solution approaches the linear one in proportion to the load.
#[test]
fn tiny_loads_are_linear() {
    let difference = |force: f64| {
        let mut m = corner_force(4);
        m.loads = vec![Load::Force(vector_load("u_max_v_max", [0.0, 0.0, -force]))];
        let (mesh, system, outcome) = solve(&m);
        let u = displacement(&mesh, &system, &outcome.state.u, "u_max_v_max");
        m.analysis = Analysis::Static(StaticAnalysis { linear: true, ..Default::default() });
        let (_, _, linear) = solve(&m);
        assert_eq!(linear.statistics.factorizations, 1);
        let l = displacement(&mesh, &system, &linear.state.u, "u_max_v_max");
        (u - l).norm() / l.norm()
    };
    let (coarse, fine) = (difference(1e-2), difference(1e-4));
    assert!((coarse / fine - 100.0).abs() < 2.0, "{coarse:e} and {fine:e}");
    assert!(difference(1e-10) < 1e-9);
}

#[test]
fn results_do_not_depend_on_threads_or_runs() {
    let m = corner_force(16);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| solve(&m).2)
    };
    let first = run(1);
    for threads in [1, 2, 3] {
        let other = run(threads);
        assert!(first.state == other.state && first.balance == other.balance, "{threads} threads");
        assert_eq!(first.statistics, other.statistics);
    }
}

#[test]
fn a_hopeless_load_is_an_error_that_says_where() {
    let mut m = corner_force(4);
    m.loads = vec![Load::Force(vector_load("u_max_v_max", [0.0, 0.0, -1e9]))];
    m.analysis =
        Analysis::Static(StaticAnalysis { max_iterations: 8, max_cutbacks: 3, ..Default::default() });
    let (_, system) = compile(&m);
    let mut notes = Notes::default();
    match statics::run(&system, &static_options(&m), None, &mut notes) {
        Err(Error::NotConverged { at, reason, help }) => {
            assert!(at.contains("load factor 0.125"), "{at}");
            assert!(reason.contains("at node 24, at (1.0000, 1.0000, 1.0000)"), "{reason}");
            assert!(help.contains("last equilibrium was at load factor 0.000000"), "{help}");
        }
        other => panic!("{other:?}"),
    }
    assert_eq!(notes.events.iter().filter(|e| e.contains("cut-back to half")).count(), 3);
}

/// A clamped column of length 1, 0.2 × 0.01, under an axial force at its free end.
fn column(force_over_euler: f64, allow_unstable: bool) -> Model {
    let mut m = model(plate([1.0, 0.2], [10, 2], 0.0), 2.1e8, 0.01);
    m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(2.1e8, 0.0, 1.0)));
    let euler = std::f64::consts::PI.powi(2) * 2.1e8 * 0.2 * 1e-6 / 12.0 / 4.0;
    m.loads = vec![Load::Edge(vector_load("u_max", [-force_over_euler * euler / 0.2, 0.0, 0.0]))];
    m.analysis = Analysis::Static(StaticAnalysis { allow_unstable, ..Default::default() });
    m
}

#[test]
fn unstable_equilibria_are_refused_unless_wanted() {
    let run = |m: &Model| {
        let (_, system) = compile(m);
        statics::run(&system, &static_options(m), None, &mut Notes::default())
    };
    // Euler's load within 1 % (mesh): the straight column is stable below and not above.
    assert_eq!(run(&column(0.99, false)).unwrap().negative_pivots, 0);
    match run(&column(1.02, false)) {
        Err(Error::NotConverged { reason, at, .. }) => {
            assert!(reason.contains("unstable (1 negative pivot"), "{reason}");
            // The load factor is that of the bifurcation, to the length of the last step.
            let factor: f64 = at.trim_start_matches("load factor ").parse().unwrap();
            assert!((1.02 * factor - 1.004).abs() < 1e-3, "{at}");
        }
        other => panic!("{other:?}"),
    }
    let outcome = run(&column(1.02, true)).unwrap();
    assert_eq!(outcome.negative_pivots, 1);
    // Its second buckling load is nine times the first.
    assert_eq!(run(&column(8.5, true)).unwrap().negative_pivots, 1);
    assert_eq!(run(&column(10.5, true)).unwrap().negative_pivots, 2);
    let deflection = max_norm(outcome.state.u.iter().map(|u| u[2]));
    assert!(deflection < 1e-9, "the column stays straight: {deflection:e}");
}

#[test]
fn loads_that_are_no_numbers_are_refused() {
    let nan = [0.0, f64::NAN, 0.0];
    let cases = [
        Load::Force(vector_load("u_max", nan)),
        Load::Moment(vector_load("u_max", nan)),
        Load::Edge(vector_load("u_max", nan)),
        Load::EdgeMoment(vector_load("u_max", nan)),
        Load::Traction(vector_load("all", nan)),
        Load::Gravity(GravityLoad { value: [0.0, f64::INFINITY, 0.0], amplitude: None }),
        Load::Pressure(PressureLoad {
            on: "all".into(),
            value: f64::NAN,
            amplitude: None,
            distribution: None,
        }),
    ];
    for load in cases {
        let m = Model { loads: vec![load.clone()], ..corner_force(2) };
        match build(&m, &generate(&m.mesh).unwrap()) {
            Err(Error::Model(issues)) => {
                assert!(issues.iter().any(|i| i.place.key.starts_with("loads[0]")), "{load:?}: {issues:?}");
            }
            other => panic!("{load:?} gives {:?}", other.map(|_| ())),
        }
    }
}

/// A tube under six equal radial forces, and its twelfth part between two inclined planes of symmetry.
#[test]
fn inclined_symmetry_planes_stand_for_the_whole() {
    let tube = |angles: [f64; 2], elements: u32| cylinder(1.0, angles, 1.5, [elements, 4]);
    let radial = |degrees: f64| Vec3::new(degrees.to_radians().sin(), 0.0, degrees.to_radians().cos());
    let across = |degrees: f64| Vec3::new(degrees.to_radians().cos(), 0.0, -degrees.to_radians().sin());
    let force = 400.0;

    let mut full = model(tube([10.0, 370.0], 48), 2.1e8, 0.02);
    full.conditions = vec![Condition::Clamp(on("v_min"))];
    for k in 0..6 {
        let name = format!("force{k}");
        let angle = 10.0 + 60.0 * f64::from(k);
        if let MeshSource::Cylinder(c) = &mut full.mesh {
            let p = radial(angle);
            c.grid.points.insert(name.clone(), [p.x, 1.5, p.z]);
        }
        full.loads.push(Load::Force(vector_load(&name, (radial(angle) * -force).into())));
    }
    if let MeshSource::Cylinder(c) = &mut full.mesh {
        let p = radial(40.0);
        c.grid.points.insert("between".into(), [p.x, 1.5, p.z]);
    }

    let mut part = model(tube([10.0, 40.0], 4), 2.1e8, 0.02);
    let plane = |on: &str, degrees: f64| {
        Condition::Symmetry(SymmetryPlane { on: on.into(), normal: (across(degrees) * 3.0).into() })
    };
    part.conditions = vec![Condition::Clamp(on("v_min")), plane("u_min", 10.0), plane("u_max", 40.0)];
    part.loads = vec![Load::Force(vector_load("u_min_v_max", (radial(10.0) * -0.5 * force).into()))];

    let (mesh, system, outcome) = solve(&full);
    let (part_mesh, part_system, part_outcome) = solve(&part);
    assert!((part_outcome.balance.strain * 12.0 / outcome.balance.strain - 1.0).abs() < 1e-9);
    for (whole, cut) in [("force0", "u_min_v_max"), ("between", "u_max_v_max")] {
        let a = displacement(&mesh, &system, &outcome.state.u, whole);
        let b = displacement(&part_mesh, &part_system, &part_outcome.state.u, cut);
        assert!((a - b).norm() < 1e-9 * a.norm(), "{whole}: {a:?} and {b:?}");
        assert!(a.norm() > 1e-2);
    }
}

/// The mirror image of a strip at its clamped edge, with the directors of the strip, is free of stress but turned inside
/// out. Pulled away from the clamp it is in equilibrium. No real strip gets there.
#[test]
fn an_equilibrium_with_inverted_elements_is_refused() {
    let mut m = model(plate([1.0, 0.5], [3, 2], 0.0), 1e3, 0.02);
    m.loads = vec![Load::Edge(vector_load("u_max", [-0.1, 0.0, 0.0]))];
    let (_, system) = compile(&m);
    let mut start = State { next_step: 1.0, ..State::at_rest(&system) };
    for ((u, x), kind) in start.u.iter_mut().zip(&system.coordinates.reference).zip(&system.coordinates.kinds)
    {
        if *kind == VectorKind::Position {
            u[0] = -2.0 * x[0];
        }
    }
    let options = StaticAnalysis { max_cutbacks: 0, ..StaticAnalysis::default() };
    let error = statics::run(&system, &options, Some(start), &mut Silent).unwrap_err();
    assert!(error.to_string().contains("is inverted"), "{error}");
}

/// Two strips beside each other, the second with a Young's modulus and a load 1e12 times as large or as small: each bends
/// as it does alone.
#[test]
fn separate_bodies_of_very_different_stiffness_bend_as_alone() {
    let tips = |ratio: f64, linear: bool| {
        let mut m = model(plate([1.0, 0.2], [8, 2], 0.0), 2.1e7, 0.01);
        m.analysis = Analysis::Static(StaticAnalysis { linear, ..Default::default() });
        let strip = generate(&m.mesh).unwrap();
        let mesh = side_by_side(&[strip.clone(), strip]);
        m.materials.insert("other".into(), Material::Isotropic(Isotropic::new(ratio * 2.1e7, 0.3, 0.0)));
        let mut other = m.sections[0].clone();
        other.material = "other".into();
        (m.sections[0].on, other.on) = ("part0".into(), "part1".into());
        m.sections.push(other);
        m.conditions = ["u_min0", "u_min1"].map(|set| Condition::Clamp(on(set))).into();
        m.loads = [("u_max0", 1.0), ("u_max1", ratio)]
            .map(|(set, factor)| Load::Edge(vector_load(set, [0.0, 0.0, -0.4 * factor])))
            .into();
        let system = build(&m, &mesh).unwrap();
        let outcome = statics::run(&system, &static_options(&m), None, &mut Silent).unwrap();
        ["u_max_v_max0", "u_max_v_max1"].map(|tip| displacement(&mesh, &system, &outcome.state.u, tip))
    };
    for linear in [true, false] {
        for ratio in [1e12, 1e-12] {
            let [first, second] = tips(ratio, linear);
            assert!(first.z < -0.05, "{first}");
            assert!((first - second).norm() <= 1e-6 * first.norm(), "{ratio:e}, {linear}: {first} {second}");
        }
    }
}

/// Elements of aspect ratios up to a million: rounding of the stiff ones exceeds the stiffness of the others. Nothing buckles.
#[test]
fn rounding_of_an_unloaded_structure_is_not_called_buckling() {
    for linear in [true, false] {
        let mut m = model(plate([1.0, 0.1], [64, 1], 0.0), 2.1e11, 0.01);
        if let MeshSource::Plate(p) = &mut m.mesh {
            p.grid.grading = [1e6, 1.0];
        }
        m.loads = vec![Load::Edge(vector_load("u_max", [0.0, 0.0, -1.0]))];
        m.analysis = Analysis::Static(StaticAnalysis { linear, ..Default::default() });
        let (_, system) = compile(&m);
        let error = statics::run(&system, &static_options(&m), None, &mut Silent).unwrap_err().to_string();
        assert!(error.contains("an effect of round-off") && error.contains("aspect ratio"), "{error}");
        assert!(!error.contains("buckl") && !error.contains("limit point"), "{error}");
    }
}

/// A tiny part that is clamped along an edge is supported, however large the part beside it.
#[test]
fn a_tiny_part_beside_a_large_one_is_no_mechanism() {
    let mut m = model(plate([1.0, 1.0], [2, 2], 0.0), 2.1e11, 0.01);
    let large = generate(&m.mesh).unwrap();
    let mut tiny = large.clone();
    tiny.positions.iter_mut().for_each(|x| *x *= 1e-6);
    let mesh = side_by_side(&[large, tiny]);
    m.conditions = ["u_min0", "u_min1"].map(|set| Condition::Clamp(on(set))).into();
    m.loads = vec![Load::Edge(vector_load("u_max1", [0.0, 0.0, -1.0]))];
    assert!(build(&m, &mesh).is_ok(), "{:?}", build(&m, &mesh).err());
    m.conditions = ["u_min0", "u_min_v_min1"].map(|set| Condition::Spherical(on(set))).into();
    let error = build(&m, &mesh).err().unwrap().to_string();
    assert!(error.contains("the model is under-constrained"), "{error}");
}

/// A spring that is so stiff that the round-off of its length is a force that compares with the load: an equilibrium that is
/// reported carries the load.
#[test]
fn springs_too_stiff_for_the_round_off_of_places_are_refused() {
    let mut refused = 0;
    for power in [3, 6, 9, 12, 13, 14, 15, 16] {
        let mut m = strip(ElementKind::Ems, [10, 1], 0.0);
        let end = [1.0, 0.1, 0.0];
        m.bodies = vec![hub("end", end, &["u_max"])];
        m.springs = vec![spring("prop", ["ground", "end"], [[1.0, 0.1, 1.0], end], 10_f64.powi(power))];
        m.conditions = vec![clamped("u_min")];
        m.loads = vec![Load::Force(vector_load("end", [0.0, 0.0, 1e-2]))];
        let (_, system) = compile(&m);
        match statics::run(&system, &static_options(&m), None, &mut Silent) {
            Ok(outcome) => {
                let forces = ReactionFinder::new(&system, None).find(&system, None, &outcome.state);
                assert!(forces.force_error < 1e-3, "{power}: {}", forces.force_error);
            }
            Err(error) => {
                assert!(error.to_string().contains("is too stiff for these loads"), "{power}: {error}");
                assert!(power > 12, "{power}: {error}");
                refused += 1;
            }
        }
    }
    assert!(refused > 0);
}
