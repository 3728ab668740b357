//! Gears: closed solutions over several turns, planetary and bevel gears, statics, modes, analysis steps, refusals.

use std::f64::consts::TAU;

use crate::common::Notes;
use crate::multibody::{between, body, machine, pose, revolute, run};
use tegula::analysis::{Silent, State, modal, statics};
use tegula::model::*;
use tegula::norm::max_norm;
use tegula::result::joint_reaction;
use tegula::{Mat3, System, Vec3, compile, mesh};

/// Radii of the pitch circles: their ratio is irrational.
const RADII: [f64; 2] = [0.1, 0.1 * std::f64::consts::E];
/// Moments of inertia of both wheels about the axis.
const INERTIA: [f64; 2] = [0.02, 0.3];
const AXIS: [f64; 3] = [1.0, -2.0, 2.0];

fn gear(name: &str, sides: [&str; 2], carrier: &str, axes: [[f64; 3]; 2], radii: [f64; 2]) -> Joint {
    Joint::Gear(GearJoint {
        name: name.into(),
        between: between(sides[0], sides[1]),
        carrier: carrier.into(),
        axes,
        radii: Some(radii),
        ratio: None,
    })
}

/// Wheel with the same inertia J about all axes.
fn wheel(name: &str, at: [f64; 3], inertia: f64) -> RigidBody {
    body(name, at, 1.0, Some([inertia; 3]))
}

/// Place of the centre of the second wheel.
fn second_centre() -> [f64; 3] {
    let across = Vec3::from(AXIS).cross(&Vec3::z()).normalize();
    (across * (RADII[0] + RADII[1])).into()
}

/// Two wheels on hinges to the ground, geared with each other.
fn pair(end: f64, step: f64, radii: [f64; 2]) -> Model {
    let second = second_centre();
    let bodies = vec![wheel("pinion", [0.0; 3], INERTIA[0]), wheel("wheel", second, INERTIA[1])];
    let joints = vec![
        revolute("first", "ground", "pinion", [0.0; 3], AXIS),
        revolute("second", "ground", "wheel", second, AXIS),
        gear("teeth", ["pinion", "wheel"], "ground", [AXIS; 2], radii),
    ];
    machine(end, step, bodies, joints)
}

fn spring(name: &str, ends: [&str; 2], stiffness: f64, free_angle: f64) -> TorsionSpring {
    let between = between(ends[0], ends[1]);
    TorsionSpring {
        name: name.into(),
        between,
        axis: AXIS,
        stiffness,
        damping: 0.0,
        moment: None,
        free_angle,
    }
}

/// Angle of a rotation about an axis, up to full turns.
fn angle(turned: &Mat3, axis: [f64; 3]) -> f64 {
    let axis = Vec3::from(axis).normalize();
    let across = axis.cross(&if axis.z.abs() < 0.9 { Vec3::z() } else { Vec3::x() }).normalize();
    (turned * across).dot(&axis.cross(&across)).atan2((turned * across).dot(&across))
}

/// Angle of a body that is nearest to another one.
fn nearest((system, state): (&System, &State), body: usize, axis: [f64; 3], expected: f64) -> f64 {
    let found = angle(&pose(system, state, body).1, axis);
    found + TAU * ((expected - found) / TAU).round()
}

fn number(system: &System, name: &str) -> usize {
    system.joints.iter().position(|joint| joint.name == name).unwrap()
}

/// Moment of the gear on its second wheel.
fn moment(system: &System, state: &State, name: &str) -> Vec3 {
    joint_reaction(system, state, &system.joints[number(system, name)]).1
}

fn with_scheme(mut model: Model, scheme: Scheme) -> Model {
    let Analysis::Transient(options) = &mut model.analysis else { panic!() };
    options.scheme = scheme;
    model
}

fn schemes() -> [(Scheme, f64); 3] {
    [
        (Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 }), 4.0),
        (Scheme::EnergyMomentum(EnergyMomentumScheme { order: 4 }), 16.0),
        (Scheme::GeneralizedAlpha(GeneralizedAlphaScheme { spectral_radius: 0.9 }), 4.0),
    ]
}

/// Energy–momentum steps keep the energy up to the tolerance of Newton's method, composed ones with the errors of their three sub-steps.
fn keeps_energy(scheme: Scheme, notes: &Notes, tolerance: f64) {
    if let Scheme::EnergyMomentum(EnergyMomentumScheme { order }) = scheme {
        let limit = if order == 2 { tolerance } else { 5.0 * tolerance } * notes.kinetic;
        assert!(notes.drift() <= limit, "{} {}", notes.drift(), notes.kinetic);
    }
}

/// On a spring whose free angle is 6.25 turns away, the pinion swings through 12.5 turns and back with `ω² = k/(J₁ + J₂/i²)`, and the
/// wheel with it at the constant ratio i, which is irrational.
#[test]
#[ignore = "long"]
fn wheels_swing_through_many_turns_at_a_constant_ratio() {
    let free = 6.25 * TAU;
    for radii in [RADII, [-RADII[0], RADII[1]]] {
        let ratio = -radii[1] / radii[0];
        for (scheme, order) in schemes() {
            let error = |step: f64| {
                let model = pair(2.6, step, radii);
                let torsion_springs = vec![spring("spring", ["ground", "pinion"], 0.24, free.to_degrees())];
                let model = with_scheme(Model { torsion_springs, ..model }, scheme);
                let mut notes = Notes::keeping();
                let (system, state) = run(&model, &mut notes);
                let omega = (0.24 / (INERTIA[0] + INERTIA[1] / (ratio * ratio))).sqrt();
                let most = max_norm(notes.states.iter().map(|state| {
                    let exact = free * (1.0 - (omega * state.time).cos());
                    let first = nearest((&system, state), 0, AXIS, exact);
                    let second = nearest((&system, state), 1, AXIS, first / ratio);
                    assert!((first - ratio * second).abs() < 1e-10, "{first} {second}");
                    assert!((state.angles[0] - first).abs() < 1e-10, "{:?} {first}", state.angles);
                    first
                }));
                assert!(most > 5.0 * TAU, "{most}");
                keeps_energy(scheme, &notes, 1e-10);
                let exact = free * (1.0 - (omega * 2.6).cos());
                (nearest((&system, &state), 0, AXIS, exact) - exact).abs()
            };
            let [coarse, fine] = [4e-3, 2e-3].map(error);
            println!("{scheme:?} {ratio}: {coarse:e} {fine:e}");
            let ratio_of_errors = coarse / fine;
            assert!(fine < 0.3 && (0.85 * order..1.15 * order).contains(&ratio_of_errors), "{coarse} {fine}");
        }
    }
}

/// A moment M on the pinion accelerates it by `M/(J₁ + J₂/i²)`; the teeth turn the wheel with `J₂ α/i`, and the virtual work of both
/// torques vanishes.
#[test]
fn torques_of_wheels_have_the_inverse_ratio() {
    let mut model = pair(0.2, 1e-3, RADII);
    let axis = Vec3::from(AXIS).normalize();
    model.loads = vec![Load::Moment(VectorLoad {
        on: "pinion".into(),
        value: (axis * 0.3).into(),
        amplitude: None,
        distribution: None,
    })];
    let mut notes = Notes::keeping();
    let (system, state) = run(&model, &mut notes);
    let ratio = -RADII[1] / RADII[0];
    let exact = 0.3 / (INERTIA[0] + INERTIA[1] / (ratio * ratio));
    let turned = 0.5 * exact * 0.04;
    let found = nearest((&system, &state), 0, AXIS, turned);
    assert!((found / turned - 1.0).abs() < 1e-4, "{found} {turned}");
    for state in &notes.states[1..] {
        let on_wheel = moment(&system, state, "teeth");
        assert!((on_wheel - axis * (INERTIA[1] * exact / ratio)).norm() < 1e-5, "{on_wheel}");
    }
    // The impulse of the teeth is the angular momentum of the wheel: both of one step, to round-off.
    let spin = |state: &State, body: usize| {
        let d = system.coordinates.bodies[body].directors.unwrap();
        let at = |v: u32| Vec3::from(state.v[v as usize]);
        let r = pose(&system, state, body).1;
        let omega: Vec3 = (0..3).map(|i| r.column(i).cross(&at(d[i])) * 0.5).sum();
        omega.dot(&axis)
    };
    let last = notes.states.len() - 1;
    let [before, after] = [last - 1, last].map(|i| spin(&notes.states[i], 0) * INERTIA[0]);
    let on_pinion = (after - before) / 1e-3 - 0.3;
    let on_wheel = moment(&system, &notes.states[last], "teeth").dot(&axis);
    assert!((on_pinion * ratio + on_wheel).abs() < 1e-6 * on_wheel.abs(), "{on_pinion} {on_wheel}");
}

/// Sun, planet on an arm, and a fixed ring: with `i = 1 + r_ring/r_sun` (Willis) the sun turns i times as fast as the arm, and a moment
/// on it accelerates the arm by `M i/(i² J_s + J_c + m R² + J_p (1 − r_ring/r_p)²)`.
fn planetary(end: f64, step: f64) -> (Model, f64, [f64; 3]) {
    let axis = [0.0, 0.0, 1.0];
    let (sun, planet) = (0.1, 0.17);
    let ring = sun + 2.0 * planet;
    let centre = [sun + planet, 0.0, 0.0];
    let bodies = vec![
        wheel("sun", [0.0; 3], 0.01),
        wheel("arm", [0.0; 3], 0.05),
        RigidBody { mass: Some(2.0), ..wheel("planet", centre, 0.03) },
    ];
    let joints = vec![
        revolute("hub", "ground", "sun", [0.0; 3], axis),
        revolute("shaft", "ground", "arm", [0.0; 3], axis),
        revolute("pin", "arm", "planet", centre, axis),
        gear("inner", ["sun", "planet"], "arm", [axis; 2], [sun, planet]),
        gear("outer", ["planet", "ground"], "arm", [axis; 2], [planet, -ring]),
    ];
    let own = 1.0 - ring / planet;
    let willis = 1.0 + ring / sun;
    let inertia = willis * willis * 0.01 + 0.05 + 2.0 * centre[0] * centre[0] + 0.03 * own * own;
    (machine(end, step, bodies, joints), 1.5 * willis / inertia, [willis, 1.0, own])
}

#[test]
#[ignore = "long"]
fn the_sun_of_a_planetary_gear_turns_as_willis_says() {
    for (scheme, order) in schemes() {
        let error = |step: f64| {
            let (model, acceleration, speeds) = planetary(2.2, step);
            let value = [0.0, 0.0, 1.5];
            let loads = vec![Load::Moment(VectorLoad {
                on: "sun".into(),
                value,
                amplitude: None,
                distribution: None,
            })];
            let mut notes = Notes::default();
            let (system, state) = run(&with_scheme(Model { loads, ..model }, scheme), &mut notes);
            let exact = 0.5 * acceleration * 2.2 * 2.2;
            let arm = nearest((&system, &state), 1, [0.0, 0.0, 1.0], exact);
            assert!(arm > 5.0 * TAU, "{arm}");
            for (body, speed) in speeds.into_iter().enumerate() {
                let found = nearest((&system, &state), body, [0.0, 0.0, 1.0], speed * arm);
                assert!((found - speed * arm).abs() < 1e-9, "{body}: {found} {}", speed * arm);
            }
            // The work of the moment is that of the converged steps, too.
            keeps_energy(scheme, &notes, 5e-10);
            (arm - exact).abs()
        };
        let [coarse, fine] = [2e-3, 1e-3].map(error);
        println!("{scheme:?}: {coarse:e} {fine:e}");
        assert!(fine < 0.1 && (0.8 * order..1.2 * order).contains(&(coarse / fine)), "{coarse} {fine}");
    }
}

/// Bevel gears on hinges in a carrier that flies and tumbles: energy and both momenta stay, the ratio too, over many turns.
#[test]
fn bevel_gears_in_a_flying_carrier_keep_energy_and_momenta() {
    let (carried, axes) = ([0.3, -0.5, 0.4], [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
    // Rates relative to the carrier: opposite, for axes that point away from the apex.
    let ratio = -1.5_f64.sqrt();
    let rates = [24.0, 24.0 / ratio];
    let spun = |name: &str, at: [f64; 3], own: Vec3| RigidBody {
        velocity: Vec3::from(carried).cross(&Vec3::from(at)).into(),
        angular_velocity: (Vec3::from(carried) + own).into(),
        ..body(name, at, 1.0, Some([0.02, 0.03, 0.04]))
    };
    let (first, second) = ([0.2, 0.0, 0.0], [0.0, 0.0, 0.3]);
    let bodies = vec![
        spun("carrier", [0.0; 3], Vec3::zeros()),
        spun("a", first, Vec3::from(axes[0]) * rates[0]),
        spun("b", second, Vec3::from(axes[1]) * rates[1]),
    ];
    let joints = vec![
        revolute("first", "carrier", "a", first, axes[0]),
        revolute("second", "carrier", "b", second, axes[1]),
        gear("bevel", ["a", "b"], "carrier", axes, [1.0, -ratio]),
    ];
    let model = machine(2.5, 0.01, bodies, joints);
    let mut notes = Notes::default();
    let (system, state) = run(&model, &mut notes);
    assert!(notes.events.is_empty(), "{:?}", notes.events);
    assert!(notes.drift() <= 1e-10 * notes.kinetic, "{} {}", notes.drift(), notes.kinetic);
    let (linear, angular) = notes.momenta[0];
    for (p, l) in &notes.momenta {
        assert!((p - linear).norm() <= 1e-10 * angular.norm() / 0.3, "{p} {linear}");
        assert!((l - angular).norm() <= 1e-10 * angular.norm(), "{l} {angular}");
    }
    let carrier = pose(&system, &state, 0).1;
    let relative = |body: usize, axis| angle(&(carrier.transpose() * pose(&system, &state, body).1), axis);
    let turned = state.angles[0];
    assert!(turned.abs() > 5.0 * TAU, "{turned}");
    for (found, expected) in [(relative(1, axes[0]), turned), (relative(2, axes[1]), turned / ratio)] {
        let apart = (found - expected) / TAU;
        assert!((apart - apart.round()).abs() < 1e-10, "{found} {expected}");
    }
}

/// In statics the wheel on its spring balances a moment M on the pinion: `k φ₂ = i M`, with the pinion at `i² M/k`, many turns away.
#[test]
fn a_static_moment_is_transmitted_over_several_turns() {
    let ratio = -RADII[1] / RADII[0];
    let mut model = pair(1.0, 0.1, RADII);
    model.torsion_springs = vec![spring("spring", ["wheel", "ground"], 0.5, 0.0)];
    let target = 5.7 * TAU;
    let moment_on_pinion = 0.5 * target / (ratio * ratio);
    let axis = Vec3::from(AXIS).normalize();
    let value = (axis * moment_on_pinion).into();
    model.loads =
        vec![Load::Moment(VectorLoad { on: "pinion".into(), value, amplitude: None, distribution: None })];
    let options = StaticAnalysis { load_steps: 40, ..StaticAnalysis::default() };
    model.analysis = Analysis::Static(options.clone());
    let mesh = mesh::generators::generate(&model.mesh).unwrap();
    let system = compile::build(&model, &mesh).unwrap();
    let state = statics::run(&system, &options, None, &mut Silent).unwrap().state;
    assert!((state.angles[0] / target - 1.0).abs() < 1e-9, "{:?} {target}", state.angles);
    let [first, second] =
        [(0, target), (1, target / ratio)].map(|(i, at)| nearest((&system, &state), i, AXIS, at));
    assert!((first / target - 1.0).abs() < 1e-9 && (first - ratio * second).abs() < 1e-9, "{first} {second}");
    let on_wheel = moment(&system, &state, "teeth");
    let expected = axis * (ratio * moment_on_pinion);
    assert!((on_wheel - expected).norm() < 1e-9 * expected.norm(), "{on_wheel} {expected}");
}

/// A motor J₁, geared to a shaft J₂ with a spring to a load J₃: it runs free, or vibrates with `ω² = k (1/J₃ + 1/(J₂ + i² J₁))`.
#[test]
fn geared_inertias_vibrate_against_their_spring() {
    let mut model = pair(1.0, 0.1, RADII);
    let ratio = -RADII[1] / RADII[0];
    model.bodies.push(wheel("load", second_centre(), 0.7));
    model.joints.push(revolute("third", "ground", "load", second_centre(), AXIS));
    model.torsion_springs = vec![spring("shaft", ["wheel", "load"], 90.0, 0.0)];
    model.analysis = Analysis::Modal(ModalAnalysis::new(2));
    let mesh = mesh::generators::generate(&model.mesh).unwrap();
    let system = compile::build(&model, &mesh).unwrap();
    let found = modal::run(&system, 2, None, &mut Silent).unwrap();
    assert!(found.sturm_checked);
    let reduced = INERTIA[1] + ratio * ratio * INERTIA[0];
    let exact = (90.0 * (1.0 / 0.7 + 1.0 / reduced)).sqrt();
    let omegas: Vec<f64> = found.modes.iter().map(|mode| mode.omega).collect();
    assert!(omegas[0] == 0.0 && (omegas[1] / exact - 1.0).abs() < 1e-10, "{omegas:?} {exact}");
}

/// A clutch: while the gear is released, both wheels run on; then its teeth mesh where they stand, in a plastic impact that keeps
/// `J₁ ω₁ + J₂ ω₂/i`.
#[test]
fn a_gear_that_was_released_meshes_where_its_wheels_stand() {
    use crate::step_joints::{run, step};
    let ratio = -RADII[1] / RADII[0];
    for (scheme, _) in schemes() {
        let mut model = with_scheme(pair(1.0, 2e-3, RADII), scheme);
        let axis = Vec3::from(AXIS).normalize();
        model.bodies[0].angular_velocity = (axis * 40.0).into();
        model.bodies[1].angular_velocity = (axis * (40.0 / ratio)).into();
        let move_on = model.analysis.clone();
        model.steps = vec![
            step("geared", move_on.clone(), &[], &[]),
            step("braked", move_on.clone(), &["teeth"], &[]),
            step("again", move_on, &[], &[]),
        ];
        let value = (axis * 1.5).into();
        model.steps[1].loads =
            vec![Load::Moment(VectorLoad { on: "wheel".into(), value, amplitude: None, distribution: None })];
        let done = run(&model).unwrap();
        let spin = |i: usize, body: usize| {
            let (system, state) = (&done[i].system, &done[i].state);
            let d = system.coordinates.bodies[body].directors.unwrap();
            let r = pose(system, state, body).1;
            let omega: Vec3 =
                (0..3).map(|k| r.column(k).cross(&Vec3::from(state.v[d[k] as usize])) * 0.5).sum();
            omega.dot(&axis)
        };
        assert!((spin(1, 0) - ratio * spin(1, 1)).abs() > 1.0, "{} {}", spin(1, 0), spin(1, 1));
        let together = |i: usize| INERTIA[0] * spin(i, 0) + INERTIA[1] * spin(i, 1) / ratio;
        assert!((spin(2, 0) - ratio * spin(2, 1)).abs() < 1e-3 * spin(2, 0).abs(), "{}", spin(2, 0));
        assert!(
            (together(2) / together(1) - 1.0).abs() < 2e-3,
            "{scheme:?}: {} {}",
            together(1),
            together(2)
        );
        // Both wheels turn on at the ratio from where they stood.
        let states = &done[2].notes.states;
        let turned = |body: usize, state: &State| angle(&pose(&done[2].system, state, body).1, AXIS);
        let change = |body: usize| {
            let steps = states.windows(2).map(|pair| turned(body, &pair[1]) - turned(body, &pair[0]));
            steps.map(|x| x - TAU * (x / TAU).round()).sum::<f64>()
        };
        assert!(
            (change(0) - ratio * change(1)).abs() < 1e-10 * change(0).abs(),
            "{} {}",
            change(0),
            change(1)
        );
        assert!(change(0).abs() > 1.5 * TAU, "{}", change(0));
    }
}

/// A planet on an arm, whose gear counts its angle relative to the ground, is most likely a mistake.
#[test]
fn wheels_with_hinges_to_other_bodies_than_the_carrier_are_told() {
    let told = |carrier: &str| {
        let (mut model, ..) = planetary(1.0, 0.1);
        let Joint::Gear(keys) = &mut model.joints[3] else { panic!() };
        keys.carrier = carrier.into();
        let mesh = mesh::generators::generate(&model.mesh).unwrap();
        compile::warnings(&model, &mesh, &compile::build(&model, &mesh).unwrap())
    };
    // The sun has its hinge in the ground, on the axis of the arm.
    assert_eq!(told("arm"), Vec::new());
    let found = told("ground");
    assert_eq!(found.len(), 1);
    let issue = &found[0];
    assert!(issue.place.key == "joints[3].carrier" && issue.message.contains("\"arm\""), "{issue:?}");
}

#[test]
fn gears_without_ratio_or_with_wheels_that_are_carriers_are_refused() {
    let refused = |change: &dyn Fn(&mut GearJoint)| {
        let mut model = pair(1.0, 1e-2, RADII);
        let Joint::Gear(keys) = &mut model.joints[2] else { panic!() };
        change(keys);
        let mesh = mesh::generators::generate(&model.mesh).unwrap();
        compile::build(&model, &mesh).err().unwrap().to_string()
    };
    type Change = fn(&mut GearJoint);
    let cases: [(Change, &str, &str); 11] = [
        (|keys| keys.radii = None, "joints[2]", "has no ratio"),
        (|keys| keys.ratio = Some(2.0), "joints[2].ratio", "both `radii` and `ratio`"),
        (|keys| (keys.radii, keys.ratio) = (None, Some(0.0)), "joints[2].ratio", "is 0"),
        (|keys| (keys.radii, keys.ratio) = (None, Some(f64::NAN)), "joints[2].ratio", "NaN"),
        (|keys| keys.radii = Some([0.1, 0.0]), "joints[2].radii[1]", "is 0"),
        (|keys| keys.radii = Some([-0.1, -0.2]), "joints[2].radii", "internal teeth"),
        (|keys| keys.axes[1] = AXIS.map(|x| -x), "joints[2].axes", "opposite directions"),
        (|keys| keys.axes[1] = [1.0, 0.0, 0.0], "joints[2].axes[1]", "is not that of the joint \"second\""),
        (|keys| keys.carrier = "wheel".into(), "joints[2].carrier", "one of its wheels"),
        (|keys| keys.carrier = "gorund".into(), "joints[2].carrier", "gorund"),
        (|keys| keys.between[1] = "pinion".into(), "joints[2].between", "with itself"),
    ];
    for (change, key, text) in cases {
        let message = refused(&change);
        assert!(message.contains(key) && message.contains(text), "{message}");
    }
}
