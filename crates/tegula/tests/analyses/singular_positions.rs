//! Singular positions of mechanisms on the way of a motion are reported with their time and joints.

use crate::common::Notes;
use crate::generalized_alpha::with_scheme;
use crate::multibody::{body, machine, pose, revolute, run};
use tegula::model::*;

/// A parallelogram of three bars of length 1, which stands upright at the start and turns clockwise with 2 rad/s. Its bars lie in one line after
/// a quarter of a turn.
fn parallelogram() -> Model {
    let (z, rate) = ([0.0, 0.0, 1.0], -2.0);
    let bar = |name: &str, at: [f64; 3], velocity: [f64; 3], turns: f64| RigidBody {
        velocity,
        angular_velocity: [0.0, 0.0, turns],
        ..body(name, at, 1.0, Some([0.1; 3]))
    };
    let bodies = vec![
        bar("crank", [0.0, 0.5, 0.0], [-0.5 * rate, 0.0, 0.0], rate),
        bar("coupler", [0.5, 1.0, 0.0], [-rate, 0.0, 0.0], 0.0),
        bar("rocker", [1.0, 0.5, 0.0], [-0.5 * rate, 0.0, 0.0], rate),
    ];
    let joints = vec![
        revolute("A", "ground", "crank", [0.0; 3], z),
        revolute("B", "crank", "coupler", [0.0, 1.0, 0.0], z),
        revolute("C", "coupler", "rocker", [1.0, 1.0, 0.0], z),
        revolute("D", "rocker", "ground", [1.0, 0.0, 0.0], z),
    ];
    machine(1.0, 1e-3, bodies, joints)
}

/// A four-bar linkage, never singular, whose coupler is a stiff beam: constraints on stiff parts look dependent in the tangent, and are not.
#[test]
fn a_linkage_with_a_stiff_beam_is_never_in_a_singular_position() {
    let z = [0.0, 0.0, 1.0];
    let (b, c) = ([0.27015115293407, 0.420735492403948, 0.0], [1.49682598589516, 1.28402504647677, 0.0]);
    let rod = |name: &str, from: [f64; 3], to: [f64; 3], mass: f64| {
        body(name, std::array::from_fn(|i| 0.5 * (from[i] + to[i])), mass, Some([0.05; 3]))
    };
    let d = [1.7, 0.0, 0.0];
    let section = BeamSection::Constants(SectionConstants {
        axial: 1e11,
        shear: [1e11; 2],
        bending: [1e8; 2],
        torsion: 1e8,
        mass: 1.0,
        inertia: [1e-4; 2],
    });
    let joints = vec![
        revolute("A", "ground", "crank", [0.0; 3], z),
        revolute("B", "crank", "coupler.start", b, z),
        revolute("C", "coupler.end", "rocker", c, z),
        revolute("D", "ground", "rocker", d, z),
    ];
    let bodies = vec![rod("crank", [0.0; 3], b, 0.5), rod("rocker", d, c, 1.3)];
    let mut model = machine(0.3, 2e-3, bodies, joints);
    model.beams = vec![Beam::straight("coupler", [b, c], 6, z, section)];
    model.loads = crate::multibody::gravity([0.0, -9.81, 0.0]);
    for scheme in [
        Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 }),
        Scheme::GeneralizedAlpha(GeneralizedAlphaScheme { spectral_radius: 0.8 }),
        Scheme::Bdf2(Bdf2Scheme {}),
    ] {
        for step in [Some(2e-3), None] {
            let mut model = with_scheme(&model, scheme, 0.3, 2e-3);
            let Analysis::Transient(options) = &mut model.analysis else { panic!("no motion") };
            options.time_step = step;
            let mut notes = Notes::default();
            run(&model, &mut notes);
            let told = notes.events.iter().any(|event| event.contains("singular position"));
            assert!(!told, "{scheme:?} {step:?}: {:?}", notes.events);
        }
    }
}

#[test]
fn a_singular_position_is_reported_with_its_time_and_joints_by_every_scheme_that_moves_joints() {
    let schemes = [
        Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 }),
        Scheme::EnergyMomentum(EnergyMomentumScheme { order: 4 }),
        Scheme::GeneralizedAlpha(GeneralizedAlphaScheme { spectral_radius: 0.8 }),
        Scheme::Hht(HhtScheme { alpha: -0.1 }),
        Scheme::Bdf2(Bdf2Scheme {}),
        Scheme::Explicit(ExplicitScheme { scale_director_inertia: true }),
    ];
    for scheme in schemes {
        let told = |end: f64| {
            let mut notes = Notes::keeping();
            let (system, _) = run(&with_scheme(&parallelogram(), scheme, end, 1e-3), &mut notes);
            let flat = notes
                .states
                .iter()
                .min_by(|a, b| {
                    let height = |state| pose(&system, state, 0).0.y.abs();
                    height(a).total_cmp(&height(b))
                })
                .unwrap()
                .time;
            let found: Vec<String> =
                notes.events.into_iter().filter(|event| event.contains("a singular position")).collect();
            (flat, found)
        };
        let (_, found) = told(0.7);
        assert!(found.is_empty(), "{scheme:?}: {found:?}");
        let (flat, found) = told(1.0);
        assert!(found.len() == 1, "{scheme:?}: {found:?}");
        // Three constraints across the plane are redundant everywhere.
        assert!(
            found[0].contains("where 4 constraint(s) follow from others, of \""),
            "{scheme:?}: {found:?}"
        );
        let time: f64 = found[0]["time ".len()..].split(':').next().unwrap().parse().unwrap();
        assert!((time - flat).abs() < 0.01 && (flat - 0.785).abs() < 0.01, "{scheme:?}: {time} {flat}");
    }
}
