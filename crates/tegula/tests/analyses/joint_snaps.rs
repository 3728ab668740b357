//! Load steps of mechanisms with springs against their paths, followed in small steps: neither snaps nor other branches are equilibria
//! of the path.

use crate::common::{Notes, static_options, vector_load};
use crate::multibody::{between, body, pose, revolute, spherical, spring};
use tegula::Error;
use tegula::analysis::statics::{self, StaticOutcome};
use tegula::model::*;

/// A static model of bodies on joints.
fn mechanism(load_steps: u32, bodies: Vec<RigidBody>, joints: Vec<Joint>) -> Model {
    let options = StaticAnalysis { load_steps, ..StaticAnalysis::default() };
    Model::of_bodies(Analysis::Static(options), bodies, joints)
}

fn solved(model: &Model) -> tegula::Result<(tegula::System, StaticOutcome)> {
    let mesh = tegula::mesh::generators::generate(&model.mesh)?;
    let system = tegula::compile::build(model, &mesh)?;
    let outcome = statics::run(&system, &static_options(model), None, &mut Notes::default())?;
    Ok((system, outcome))
}

/// Angle θ of an upright arm on a torsion spring k under the force λ (f, g) at its tip, k θ = −λ (f cos θ + g sin θ), by the path from
/// λ = 0 in 20 000 steps.
fn followed(k: f64, [f, g]: [f64; 2]) -> f64 {
    let mut angle = 0.0_f64;
    for step in 1..=20_000 {
        let load = f64::from(step) / 20_000.0;
        for _ in 0..20 {
            let (sin, cos) = angle.sin_cos();
            angle -= (k * angle + load * (f * cos + g * sin)) / (k + load * (g * cos - f * sin));
        }
    }
    angle
}

/// Beyond its buckling load the arm falls to the side of the small force, however many load steps there are.
#[test]
fn an_arm_on_a_torsion_spring_falls_to_the_side_of_its_load() {
    for force in [[4.0, -16.0], [1.0, -20.0], [0.1, -16.0], [0.01, -30.0], [0.5, -50.0]] {
        let exact = followed(10.0, force);
        for load_steps in [1, 2, 5, 20] {
            let bodies = vec![
                body("arm", [0.0, 0.5, 0.0], 1.0, Some([0.1; 3])),
                body("tip", [0.0, 1.0, 0.0], 0.1, None),
            ];
            let joints = vec![
                revolute("hinge", "ground", "arm", [0.0; 3], [0.0, 0.0, 1.0]),
                spherical("arm", "tip", [0.0, 1.0, 0.0]),
            ];
            let mut model = mechanism(load_steps, bodies, joints);
            model.torsion_springs = vec![TorsionSpring {
                name: "spring".into(),
                between: between("ground", "arm"),
                axis: [0.0, 0.0, 1.0],
                stiffness: 10.0,
                damping: 0.0,
                moment: None,
                free_angle: 0.0,
            }];
            model.loads = vec![Load::Force(vector_load("tip", [force[0], force[1], 0.0]))];
            let (system, outcome) = solved(&model).unwrap();
            let place = pose(&system, &outcome.state, 1).0;
            let angle = (-place.x).atan2(place.y);
            assert!((angle - exact).abs() < 1e-8, "{force:?} {load_steps}: {angle} {exact}");
        }
    }
}

/// A bar on a hinge is pulled over a spring that stands across: with the angle φ of the bar and the energy U of the spring the load factor
/// is −U'(φ)/(½ F cos φ), whose first maximum is the limit point.
#[test]
fn an_arm_that_is_pulled_over_a_spring_stops_at_its_limit_point() {
    let (k, force) = (100.0, 200.0);
    let load = |angle: f64| {
        let (x, y) = (angle.cos() - 1.0, angle.sin() + 1.0);
        let length = x.hypot(y);
        -k * (length - 1.0) / length * (y * angle.cos() - x * angle.sin()) / (0.5 * force * angle.cos())
    };
    let limit = (0..15_000).map(|i| load(-1e-4 * f64::from(i))).fold(0.0, tegula::norm::larger);
    for load_steps in [1, 2, 3, 5, 20] {
        let bodies = vec![body("bar", [0.5, 0.0, 0.0], 1.0, Some([0.1; 3]))];
        let joints = vec![revolute("hinge", "ground", "bar", [0.0; 3], [0.0, 0.0, 1.0])];
        let mut model = mechanism(load_steps, bodies, joints);
        let points = [[1.0, -1.0, 0.0], [1.0, 0.0, 0.0]];
        model.springs = vec![spring("spring", ["ground", "bar"], points, k)];
        model.loads = vec![Load::Force(vector_load("bar", [0.0, -force, 0.0]))];
        let error = solved(&model).err().unwrap();
        let Error::NotConverged { at, reason, .. } = &error else { panic!("{error}") };
        let factor: f64 = at.trim_start_matches("load factor ").parse().unwrap();
        assert!(
            (factor / limit - 1.0).abs() < 2e-3 && reason.contains("limit point"),
            "{load_steps} {limit}: {error}"
        );
    }
}
