//! Loads with a distribution: a formula in the coordinates that multiplies their value.

use crate::common::{self, compile, plate};
use tegula::compile::{build, check, warnings};
use tegula::element::Motion;
use tegula::mesh::generators::generate;
use tegula::model::*;
use tegula::system::assembly::add_follower_loads;
use tegula::{Mesh, System, Vec3};

/// A plate between the origin and (2, 1, 0) with one load.
fn loaded(load: Load) -> Model {
    let mut m = common::model(plate([2.0, 1.0], [4, 3], 0.0), 1.0, 0.1);
    m.conditions = vec![Condition::Clamp(common::on("u_min"))];
    m.loads = vec![load];
    m.analysis = Analysis::Static(StaticAnalysis::default());
    m
}

fn vector_load(on: &str, value: [f64; 3], distribution: &str) -> VectorLoad {
    VectorLoad { distribution: Some(distribution.into()), ..VectorLoad::new(on, value) }
}

/// Forces on the nodes in the reference configuration, with their places.
fn forces(model: &Model) -> (Mesh, System, Vec<[f64; 3]>) {
    let (mesh, system) = compile(model);
    let u = vec![[0.0; 3]; system.vectors()];
    let mut out = u.clone();
    system.add_dead_loads(1.0, 1.0, &mut out);
    add_follower_loads(&system, &Motion::State { u: &u, velocity: None }, 1.0, 1.0, &mut out);
    (mesh, system, out)
}

/// Sum of the forces on nodes, weighted by a function of their place.
fn sum(model: &Model, weight: impl Fn(&Vec3) -> f64) -> Vec3 {
    let (mesh, system, forces) = forces(model);
    let of = |n: usize| Vec3::from(forces[system.coordinates.position_of[n] as usize]);
    (0..mesh.positions.len()).map(|n| of(n) * weight(&mesh.positions[n])).sum()
}

fn assert_near(found: Vec3, exact: Vec3, what: &str) {
    assert!((found - exact).norm() < 1e-12 * exact.norm(), "{what}: {found:?} for {exact:?}");
}

/// Moments of φ over the area and the edge are those of its integrals: the rules are exact for cubic polynomials.
#[test]
fn distributed_loads_have_the_resultants_of_their_integrals() {
    let value = [0.5, -1.0, 2.0];
    let v = Vec3::from(value);
    let traction = loaded(Load::Traction(vector_load("all", value, "x^2*y")));
    assert_near(sum(&traction, |_| 1.0), v * (4.0 / 3.0), "traction");
    assert_near(sum(&traction, |x| x.x), v * 2.0, "traction, x");
    assert_near(sum(&traction, |x| x.y), v * (8.0 / 9.0), "traction, y");
    let edge = loaded(Load::Edge(vector_load("u_max", value, "1 + x*y^2")));
    assert_near(sum(&edge, |_| 1.0), v * (1.0 + 2.0 / 3.0), "edge");
    assert_near(sum(&edge, |x| x.y), v * (0.5 + 2.0 / 4.0), "edge, y");
    let force = loaded(Load::Force(vector_load("u_max", value, "max(y - 0.5, 0)")));
    assert_near(sum(&force, |_| 1.0), v * (0.5 + 1.0 / 6.0), "force at y = 2/3 and 1");
}

/// A hill narrower than an element: ∫ exp(−r²/s²) dA = π s², of which a thousandth is lost beside the plate.
#[test]
#[ignore = "long"]
fn distributions_that_vary_within_elements_keep_their_total() {
    let hill = "exp(-((x - 0.93)^2 + (y - 0.47)^2)/0.15^2)";
    let m = loaded(Load::Traction(vector_load("all", [0.0, 0.0, 1.0], hill)));
    let found = sum(&m, |_| 1.0).z / (std::f64::consts::PI * 0.15 * 0.15);
    assert!((found - 1.0).abs() < 2e-3, "{found}");
    let m = loaded(Load::Edge(vector_load("u_max", [0.0, 0.0, 1.0], "exp(-(y - 0.47)^2/0.1^2)")));
    let found = sum(&m, |_| 1.0).z / (std::f64::consts::PI.sqrt() * 0.1);
    assert!((found - 1.0).abs() < 2e-3, "{found}");
    // Ridges of a sixteenth and a hundredth of an element: at the points of the first divisions the flank is not yet 0.
    for width in [0.03, 0.004] {
        let ridge = format!("exp(-(x - 0.93)^2/{width}^2)");
        let m = loaded(Load::Traction(vector_load("all", [0.0, 0.0, 1.0], &ridge)));
        let found = sum(&m, |_| 1.0).z / (std::f64::consts::PI.sqrt() * width);
        assert!((found - 1.0).abs() < 1e-5, "{width}: {found}");
    }
}

/// The pressure of each element is the mean of the formula over it, so that its force is exact.
#[test]
fn a_distributed_pressure_pushes_with_the_mean_of_its_formula() {
    let keys = PressureLoad {
        on: "all".into(),
        value: 3.0,
        distribution: Some("x*y + x^3".into()),
        amplitude: None,
    };
    let m = loaded(Load::Pressure(keys));
    // Positive pressure pushes against the director, −z.
    assert_near(sum(&m, |_| 1.0), Vec3::new(0.0, 0.0, -3.0 * (1.0 + 4.0)), "pressure");
}

/// Displacements of a cantilever strip under moments per length along its end: those of the whole moment of the distribution.
#[test]
fn a_distributed_edge_moment_bends_with_its_integral() {
    let tip = |load: Load| {
        let mut m = loaded(load);
        m.analysis = Analysis::Static(StaticAnalysis { linear: true, ..Default::default() });
        let (mesh, system, outcome) = common::solve(&m);
        let of = |set| common::displacement(&mesh, &system, &outcome.state.u, set).z;
        (of("u_max_v_min") + of("u_max_v_max")) * 0.5
    };
    let constant = tip(Load::EdgeMoment(VectorLoad::new("u_max", [0.0, 1e-6, 0.0])));
    let distributed = tip(Load::EdgeMoment(vector_load("u_max", [0.0, 1e-6, 0.0], "2*y")));
    // The unlike halves twist the strip, which leaves the mean of its corners nearly unchanged.
    assert!((distributed / constant - 1.0).abs() < 1e-9, "{distributed} for {constant}");
    let ten = tip(Load::EdgeMoment(vector_load("u_max", [0.0, 1e-6, 0.0], "10")));
    assert!((ten / constant - 10.0).abs() < 1e-9, "{ten} for {constant}");
}

/// A simply supported square plate under a hydrostatic pressure q₀ x/a: deflection in the middle 0.00203 q₀ a⁴/D for ν = 0.3 (S. Timoshenko,
/// S. Woinowsky-Krieger, *Theory of plates and shells*, 2nd ed. 1959, Table 11 of § 31).
#[test]
fn a_plate_under_hydrostatic_pressure_deflects_as_in_the_table_of_timoshenko() {
    let (young, h, q) = (1e7, 0.01, 1e-3);
    let mut m = common::model(plate([1.0, 1.0], [32, 32], 0.0), young, h);
    m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(young, 0.3, 1.0)));
    // Supports that hold the rotation about the normal of the edge, too, as Kirchhoff's plate has them.
    let hold = |on: &str, along: Axis| {
        let keys = FixComponents { on: on.into(), position: vec![Axis::Z], director: vec![along] };
        Condition::Fix(keys)
    };
    let plane = FixComponents { on: "all".into(), position: vec![Axis::X, Axis::Y], director: vec![] };
    m.conditions = vec![
        hold("u_min", Axis::Y),
        hold("u_max", Axis::Y),
        hold("v_min", Axis::X),
        hold("v_max", Axis::X),
        Condition::Fix(plane),
    ];
    m.loads = vec![Load::Traction(vector_load("all", [0.0, 0.0, q], "x"))];
    m.analysis = Analysis::Static(StaticAnalysis { linear: true, ..Default::default() });
    let (mesh, system, outcome) = common::solve(&m);
    let stiffness = young * h * h * h / (12.0 * (1.0 - 0.09));
    let found = common::displacement(&mesh, &system, &outcome.state.u, "middle").z * stiffness / q;
    // Half the deflection 0.0040624 of the uniform pressure; the table has three digits.
    assert!((found / 0.0020312 - 1.0).abs() < 1e-3, "{found}");
}

#[test]
#[ignore = "long"]
fn distributions_without_meaning_are_refused() {
    for (distribution, message) in [
        ("", "is empty"),
        ("1/x", "grows beyond all bounds, at (0.0, 0.0, 0.0)"),
        ("sqrt(y - 0.5)", "has no value, or grows beyond all bounds, at (0.0, 0.0, 0.0)"),
        ("1/(x - 0.77)", "at (0.77, "),
        ("sqrt((x - 0.1)*(x - 0.15))", "at (0.1, "),
        // The integration meets the line of the pole.
        ("1/(x + 0.7*y - 0.9)^2", "grows beyond all bounds, at (0.8125, 0.125, "),
        ("tan(3.141592653589793*x)", "does not converge at (0.500"),
        ("cos(3.141592653589793*x)^(-2)", "does not converge at (0.4999"),
        ("t", "unknown variable \"t\""),
        ("floor(x)", "cannot be differentiated"),
    ] {
        let m = loaded(Load::Traction(vector_load("all", [1.0; 3], distribution)));
        let mesh = generate(&m.mesh).unwrap();
        let edge = loaded(Load::Edge(vector_load("v_min", [1.0; 3], distribution)));
        assert!(build(&edge, &generate(&edge.mesh).unwrap()).is_err(), "{distribution}");
        let mut issues = check::keys(&m);
        issues.extend(check::sets(&m, &mesh));
        assert!(issues.iter().any(|i| i.message.contains(message)), "{distribution}: {issues:?}");
        assert!(issues.iter().all(|i| i.place.key == "loads[0].distribution"), "{issues:?}");
        assert!(build(&m, &mesh).is_err(), "{distribution}");
    }
}

#[test]
#[ignore = "long"]
fn distributions_that_are_zero_on_the_whole_set_are_a_warning() {
    let keys = |distribution: &str| PressureLoad {
        on: "all".into(),
        value: 3.0,
        distribution: Some(distribution.into()),
        amplitude: None,
    };
    // The plate ends at y = 1.
    for (distribution, count) in [("max(y - 2, 0)", 1), ("max(y - 0.9, 0)", 0)] {
        let value = [0.0, 0.0, 1.0];
        for load in [
            Load::Pressure(keys(distribution)),
            Load::Traction(vector_load("all", value, distribution)),
            Load::Edge(vector_load("u_max", value, distribution)),
            Load::EdgeMoment(vector_load("u_max", value, distribution)),
            Load::Force(vector_load("u_max", value, distribution)),
        ] {
            let m = loaded(load);
            let mesh = generate(&m.mesh).unwrap();
            let found = warnings(&m, &mesh, &build(&m, &mesh).unwrap());
            let zero = found.iter().filter(|w| w.message.contains("the load is zero"));
            assert_eq!(zero.count(), count, "{distribution}: {found:?}");
        }
    }
}

/// The mean of 1 is 1, also over a warped element, whose area is no polynomial of the natural coordinates.
#[test]
fn a_pressure_with_the_distribution_one_is_the_pressure() {
    let warped = || {
        let mut mesh = generate(&plate([1.0, 1.0], [1, 1], 0.0)).unwrap();
        mesh.positions[3].z = 1.0;
        mesh
    };
    let total = |distribution: Option<Distribution>| {
        let mut m = common::model(plate([1.0, 1.0], [1, 1], 0.0), 1.0, 0.1);
        let keys = PressureLoad { on: "all".into(), value: 1.0, distribution, amplitude: None };
        m.loads = vec![Load::Pressure(keys)];
        let system = build(&m, &warped()).unwrap();
        let u = vec![[0.0; 3]; system.vectors()];
        let mut out = u.clone();
        add_follower_loads(&system, &Motion::State { u: &u, velocity: None }, 1.0, 1.0, &mut out);
        out.iter().map(|f| Vec3::from(*f)).sum::<Vec3>()
    };
    let (with, without) = (total(Some("1".into())), total(None));
    assert!((with - without).norm() < 1e-12 * without.norm(), "{with} {without}");
}
