//! Joints that analysis steps release and lock: motions that go on without a joint, plastic impacts, static redistribution, modes.

use crate::common::Notes;
use crate::multibody::{between, body, gravity, machine, pose, revolute};
use tegula::analysis::{Balance, State, dynamics, statics};
use tegula::model::joint::DRIVE;
use tegula::model::*;
use tegula::result::joint_reaction;

use tegula::{Error, Mat3, System, Vec3, compile, mesh};

/// End of an analysis step.
pub struct Done {
    pub system: System,
    pub state: State,
    pub notes: Notes,
    /// Energies and momenta at the start of a transient step.
    first: Balance,
}

/// Keeps the first balance, and all else as notes.
#[derive(Default)]
struct First {
    notes: Notes,
    first: Option<Balance>,
}

impl tegula::analysis::Observer for First {
    fn on_step(&mut self, step: &tegula::analysis::Step) -> tegula::Result<()> {
        self.first.get_or_insert(*step.balance);
        self.notes.on_step(step)
    }

    fn on_event(&mut self, message: &str) {
        self.notes.on_event(message);
    }
}

/// Runs all static and transient steps of a model.
pub fn run(model: &Model) -> Result<Vec<Done>, Error> {
    let mesh = mesh::generators::generate(&model.mesh).unwrap();
    let compiler = compile::Compiler::new(model, &mesh)?;
    let (mut out, mut end) = (Vec::new(), None);
    for (i, step) in model.steps.iter().enumerate() {
        let system = compiler.system(i, end.take())?;
        let mut observer = First { notes: Notes::keeping(), first: None };
        let state = match &step.analysis {
            Analysis::Static(options) => statics::run(&system, options, None, &mut observer)?.state,
            Analysis::Transient(options) => dynamics::run(&system, options, None, &mut observer)?.state,
            Analysis::Path(_) | Analysis::Modal(_) | Analysis::Buckling(_) => panic!("no modes here"),
        };
        end = Some(state.end_of_step());
        let First { notes, first } = observer;
        out.push(Done { system, state, notes, first: first.unwrap_or_default() });
    }
    Ok(out)
}

/// Text of the issues of a model that is refused.
pub fn refused(model: &Model) -> String {
    match run(model) {
        Err(Error::Model(issues)) => {
            issues.iter().map(|i| format!("{}: {}\n", i.place.key, i.message)).collect()
        }
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("not refused"),
    }
}

fn named(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}

pub fn step(name: &str, analysis: Analysis, released: &[&str], locked: &[&str]) -> AnalysisStep {
    AnalysisStep { released: named(released), locked: named(locked), ..AnalysisStep::new(name, analysis) }
}

pub fn at_rest() -> Analysis {
    Analysis::Static(StaticAnalysis::default())
}

fn schemes() -> Vec<Scheme> {
    let energy_momentum = |order| Scheme::EnergyMomentum(EnergyMomentumScheme { order });
    let generalized_alpha = GeneralizedAlphaScheme { spectral_radius: 0.9 };
    let explicit = Scheme::Explicit(ExplicitScheme::default());
    vec![energy_momentum(2), energy_momentum(4), Scheme::GeneralizedAlpha(generalized_alpha), explicit]
}

fn moving(scheme: Scheme, end: f64, dt: f64) -> Analysis {
    Analysis::Transient(TransientAnalysis { scheme, time_step: Some(dt), ..TransientAnalysis::new(end) })
}

fn joint_number(system: &System, name: &str) -> usize {
    system.joints.iter().position(|joint| joint.name == name).unwrap()
}

fn reaction(done: &Done, state: &State, name: &str) -> (Vec3, Vec3) {
    joint_reaction(&done.system, state, &done.system.joints[joint_number(&done.system, name)])
}

/// Complete elliptic integral of the first kind with modulus k, by the arithmetic–geometric mean (Abramowitz & Stegun, 17.6).
fn elliptic_k(k: f64) -> f64 {
    let (mut a, mut b) = (1.0, (1.0 - k * k).sqrt());
    for _ in 0..20 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    std::f64::consts::FRAC_PI_2 / a
}

const MASS: f64 = 2.0;
const ARM: f64 = 0.5;
const G: f64 = 10.0;

/// A bar that is held horizontally in the field of gravity, by a bolt or by its locked hinge, and then swings: a quarter of the period
/// `4 √(J/mgl) K(sin 45°)` later it hangs, with `½ J ω² = m g l`.
#[test]
fn a_bar_that_is_let_go_swings_with_the_period_of_the_pendulum() {
    let inertia = 0.3 + MASS * ARM * ARM;
    let quarter = (inertia / (MASS * G * ARM)).sqrt() * elliptic_k(std::f64::consts::FRAC_1_SQRT_2);
    let fastest = (2.0 * MASS * G * ARM / inertia).sqrt();
    for (bolted, scheme) in
        [false, true].into_iter().flat_map(|bolted| schemes().into_iter().map(move |s| (bolted, s)))
    {
        let bar = body("bar", [ARM, 0.0, 0.0], MASS, Some([0.2, 0.25, 0.3]));
        let hinge = revolute("hinge", "ground", "bar", [0.0; 3], [0.0, 0.0, 1.0]);
        let bolt = Joint::Fixed(PointJoint {
            name: "bolt".into(),
            between: between("ground", "bar"),
            at: [0.0; 3],
            second_at: None,
        });
        let mut model = machine(1.0, 0.1, vec![bar], if bolted { vec![hinge, bolt] } else { vec![hinge] });
        model.loads = gravity([0.0, -G, 0.0]);
        let swing = moving(scheme, quarter, quarter / 400.0);
        model.steps = if bolted {
            vec![step("held", at_rest(), &["hinge"], &[]), step("free", swing, &["bolt"], &[])]
        } else {
            vec![step("held", at_rest(), &[], &["hinge"]), step("free", swing, &[], &[])]
        };
        let done = run(&model).unwrap();
        let holds = if bolted { "bolt" } else { "hinge" };
        let (force, moment) = reaction(&done[0], &done[0].state, holds);
        assert!((force - Vec3::new(0.0, MASS * G, 0.0)).norm() < 1e-8, "{force}");
        assert!((moment - Vec3::new(0.0, 0.0, MASS * G * ARM)).norm() < 1e-8, "{moment}");
        if bolted {
            assert_eq!(reaction(&done[0], &done[0].state, "hinge"), (Vec3::zeros(), Vec3::zeros()));
            assert_eq!(reaction(&done[1], &done[1].state, "bolt"), (Vec3::zeros(), Vec3::zeros()));
        }
        // The bar begins to fall at m g l/J; its hinge carries m (g − l · m g l/J).
        if scheme.instant_of_reactions_is_the_end() {
            let (force, moment) = reaction(&done[1], &done[1].notes.states[0], "hinge");
            let expected = MASS * G * (1.0 - MASS * ARM * ARM / inertia);
            assert!((force.y - expected).abs() < 1e-8 && moment.norm() < 1e-8, "{scheme:?} {force} {moment}");
        }
        let (place, _) = pose(&done[1].system, &done[1].state, 0);
        let angle = place.x.atan2(-place.y);
        assert!(angle.abs() < 2e-5, "{bolted} {scheme:?}: {angle:e}");
        let speed = Vec3::from(done[1].state.v[done[1].system.coordinates.bodies[0].centre as usize]).norm();
        assert!((speed / (ARM * fastest) - 1.0).abs() < 2e-5, "{scheme:?}: {speed}");
        assert!(
            done[1].first.dissipated.abs() < 1e-20 && done[1].notes.events.is_empty(),
            "{:?}",
            done[1].notes.events
        );
    }
}

trait Reactions {
    fn instant_of_reactions_is_the_end(&self) -> bool;
}

impl Reactions for Scheme {
    /// The energy–momentum scheme of second order has the means of steps, from the first step on.
    fn instant_of_reactions_is_the_end(&self) -> bool {
        !matches!(self, Self::EnergyMomentum(EnergyMomentumScheme { order: 2 }))
    }
}

/// Mass, inertia about the mass centre, velocity of it, and angular momentum about it of two bodies with these moments of inertia.
fn together(done: &Done, state: &State, moments: &[[f64; 3]]) -> (f64, Mat3, Vec3, Vec3) {
    let bodies = &done.system.coordinates.bodies;
    let mass: f64 = bodies.iter().map(|body| body.mass).sum();
    let weighted = |of: &dyn Fn(usize) -> Vec3| {
        bodies.iter().enumerate().map(|(i, body)| of(i) * body.mass).sum::<Vec3>() / mass
    };
    let place = |i: usize| pose(&done.system, state, i).0;
    let velocity = |i: usize| Vec3::from(state.v[bodies[i].centre as usize]);
    let (centre, mean) = (weighted(&place), weighted(&velocity));
    let (mut inertia, mut momentum) = (Mat3::zeros(), Vec3::zeros());
    for (i, body) in bodies.iter().enumerate() {
        let axes = pose(&done.system, state, i).1;
        let own = axes * Mat3::from_diagonal(&moments[i].into()) * axes.transpose();
        let rates = Mat3::from_columns(&body.directors.unwrap().map(|d| Vec3::from(state.v[d as usize])))
            * axes.transpose();
        let spin = Vec3::new(rates.m32 - rates.m23, rates.m13 - rates.m31, rates.m21 - rates.m12) * 0.5;
        let arm = place(i) - centre;
        inertia += own + (Mat3::identity() * arm.norm_squared() - arm * arm.transpose()) * body.mass;
        momentum += own * spin + arm.cross(&(velocity(i) - mean)) * body.mass;
    }
    (mass, inertia, mean, momentum)
}

/// Two bodies fly freely, and the joint between them locks, whatever its kind: they go on as one rigid body with the same momenta, whose
/// kinetic energy ½ m v² + ½ L·J⁻¹L is that of a plastic impact; the rest is dissipated. A step that keeps the lock changes nothing
/// more, and one that opens it lets them move again.
#[test]
fn two_free_bodies_whose_joint_locks_go_on_as_one_rigid_body() {
    let moments = [[0.4, 0.5, 0.3], [0.2, 0.25, 0.3]];
    for joint in Joint::examples().into_iter().filter(Joint::can_be_locked) {
        for scheme in schemes() {
            let solid = |name: &str, at, inertia, angular_velocity| RigidBody {
                velocity: [0.3, -0.1, 0.2],
                angular_velocity,
                ..RigidBody::new(name, at, 2.0, Some(inertia))
            };
            let bodies = vec![
                solid("a", [0.0; 3], moments[0], [1.0, -2.0, 0.5]),
                solid("b", [1.2, 0.3, 0.1], moments[1], [-0.5, 1.0, 3.0]),
            ];
            let run_for = |end| moving(scheme, end, 0.005);
            let mut model = Model::of_bodies(run_for(0.4), bodies, vec![joint.clone()]);
            model.steps = vec![
                step("free", run_for(0.4), &[], &[]),
                step("locked", run_for(0.3), &[], &["joint"]),
                step("still locked", run_for(0.1), &[], &["joint"]),
                step("free again", run_for(0.1), &[], &[]),
            ];
            let done = run(&model).unwrap();
            let what = format!("{} {scheme:?}", joint.word());
            let (mass, inertia, velocity, momentum) = together(&done[0], &done[0].state, &moments);
            let before = done[0].system.kinetic_energy(&done[0].state.v);
            let rigid = 0.5 * mass * velocity.norm_squared()
                + 0.5 * momentum.dot(&(inertia.try_inverse().unwrap() * momentum));
            let first = done[1].first;
            assert!(before - rigid > 0.02 * before, "{what}: no impact, {before} {rigid}");
            let (p, l) = done[1].notes.momenta[0];
            let (p0, l0) = *done[0].notes.momenta.last().unwrap();
            // The velocities with which steps of second order end are not quite those of rigid bodies.
            let second_order = matches!(scheme, Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 }));
            let tolerance = if second_order { 1e-5 } else { 1e-11 };
            assert!(
                (first.dissipated - (before - rigid)).abs() < tolerance * before,
                "{what}: {}",
                first.dissipated
            );
            assert!(
                (p - p0).norm() < 1e-12 * p0.norm() && (l - l0).norm() < tolerance * l0.norm(),
                "{what}: {l} {l0}"
            );
            assert!((first.kinetic / rigid - 1.0).abs() < tolerance, "{what}: {} {rigid}", first.kinetic);
            assert_eq!(first.work, 0.0);
            let told = &done[1].notes.events[0];
            assert!(told.contains("\"joint\"") && told.contains("plastic impact"), "{told}");
            // One rigid body: the relative motion stays as it was.
            let relative = |done: &Done, state: &State| {
                let [(x, a), (y, b)] = [0, 1].map(|i| pose(&done.system, state, i));
                (a.transpose() * b, a.transpose() * (y - x))
            };
            let stands = relative(&done[0], &done[0].state);
            for locked in &done[1..3] {
                let now = relative(locked, &locked.state);
                assert!((now.0 - stands.0).norm() + (now.1 - stands.1).norm() < 1e-9, "{what}");
            }
            let second = done[2].first.dissipated;
            assert!(
                second.abs() < 1e-14 * before && done[2].notes.events.is_empty(),
                "{what}: {second:e} {:?}",
                done[2].notes.events
            );
            assert_eq!(done[2].system.joints[0].rows.len(), 6, "{what}");
            assert_eq!(done[3].system.joints[0].rows.len(), model_rows(&done[0]), "{what}");
        }
    }
}

fn model_rows(done: &Done) -> usize {
    done.system.joints[0].rows.len()
}

/// A rod that turns about a hinge in the ground with a second rod behind its elbow, which locks. The angular momentum about the hinge
/// stays: `L = J₁ ω₁ + m₂ c × v + J₂ ω₂`, and the rods go on with ω = L/(J₁ + m₂ c² + J₂).
#[test]
fn two_rods_whose_elbow_locks_keep_the_angular_momentum_about_the_hinge() {
    let (w1, w2) = (4.0, -3.0);
    let z = [0.0, 0.0, 1.0];
    // Rods of unit length and mass along x, with J = 1/12.
    let rod = |name: &str, x: f64, velocity: f64, w: f64| RigidBody {
        velocity: [0.0, velocity, 0.0],
        angular_velocity: [0.0, 0.0, w],
        ..body(name, [x, 0.0, 0.0], 1.0, Some([1e-3, 1.0 / 12.0, 1.0 / 12.0]))
    };
    let bodies = vec![rod("first", 0.5, 0.5 * w1, w1), rod("second", 1.5, w1 + 0.5 * w2, w2)];
    let joints = vec![
        revolute("hinge", "ground", "first", [0.0; 3], z),
        revolute("elbow", "first", "second", [1.0, 0.0, 0.0], z),
    ];
    let scheme = Scheme::EnergyMomentum(EnergyMomentumScheme { order: 4 });
    let run_for = |end| moving(scheme, end, 0.002);
    let mut model = Model::of_bodies(run_for(0.2), bodies, joints);
    model.steps = vec![step("free", run_for(0.2), &[], &[]), step("locked", run_for(0.2), &[], &["elbow"])];
    let done = run(&model).unwrap();
    // Free of loads, L and T are those of the start: 1/3 ω₁ + 1.5 (ω₁ + ω₂/2) + 1/12 ω₂, and the velocities.
    let v2 = w1 + 0.5 * w2;
    let l = w1 / 3.0 + 1.5 * v2 + w2 / 12.0;
    let before = 0.5 * (w1 * w1 / 3.0 + v2 * v2 + w2 * w2 / 12.0);
    let (place, _) = pose(&done[0].system, &done[0].state, 1);
    assert!((place.norm() - 1.5).abs() > 0.02, "the elbow is straight");
    let inertia = 1.0 / 3.0 + place.norm_squared() + 1.0 / 12.0;
    let after = 0.5 * l * l / inertia;
    let first = done[1].first;
    assert!((first.angular_momentum[2] / l - 1.0).abs() < 1e-9, "{:?} {l}", first.angular_momentum);
    assert!((first.kinetic / after - 1.0).abs() < 1e-9, "{} {after}", first.kinetic);
    assert!(
        (first.dissipated / (before - after) - 1.0).abs() < 1e-8,
        "{} {}",
        first.dissipated,
        before - after
    );
    assert!((first.total / before - 1.0).abs() < 1e-9 && done[1].notes.drift() < 1e-9 * before);
    // Both turn by ω t.
    let turned = |i: usize| {
        let [a, b] = [&done[0], &done[1]].map(|d| pose(&d.system, &d.state, i).1);
        let r = b * a.transpose();
        r.m21.atan2(r.m11)
    };
    let expected = l / inertia * 0.2;
    assert!(
        (turned(0) - expected).abs() < 1e-8 && (turned(1) - expected).abs() < 1e-8,
        "{} {expected}",
        turned(0)
    );
}

/// A bar on a hinge with a torsion spring, whose prop is taken away. Propped, the prop carries m g l/a; without it the bar turns until
/// `k θ = (m g l − f R a) cos θ`, where the part f of the prop's force R is still there.
#[test]
fn a_prop_that_is_released_hands_its_force_over_to_the_spring() {
    let (k, a) = (20.0, 0.8);
    let bar = body("bar", [ARM, 0.0, 0.0], MASS, Some([0.2, 0.25, 0.3]));
    let prop = Joint::Distance(DistanceJoint {
        name: "prop".into(),
        between: between("ground", "bar"),
        points: [[a, -0.6, 0.0], [a, 0.0, 0.0]],
    });
    let joints = vec![revolute("hinge", "ground", "bar", [0.0; 3], [0.0, 0.0, 1.0]), prop];
    let mut model = Model::of_bodies(at_rest(), vec![bar], joints);
    model.torsion_springs = vec![TorsionSpring {
        name: "coil".into(),
        between: between("ground", "bar"),
        axis: [0.0, 0.0, 1.0],
        stiffness: k,
        damping: 0.0,
        moment: None,
        free_angle: 0.0,
    }];
    model.loads = gravity([0.0, -G, 0.0]);
    let in_steps = Analysis::Static(StaticAnalysis { load_steps: 4, ..StaticAnalysis::default() });
    model.steps = vec![step("propped", at_rest(), &[], &[]), step("free", in_steps, &["prop"], &[])];
    let done = run(&model).unwrap();
    let held = MASS * G * ARM / a;
    let (force, _) = reaction(&done[0], &done[0].state, "prop");
    assert!((force - Vec3::new(0.0, held, 0.0)).norm() < 1e-8, "{force} {held}");
    let (force, _) = reaction(&done[0], &done[0].state, "hinge");
    assert!((force.y - (MASS * G - held)).abs() < 1e-8, "{force}");
    let mut seen = 0;
    for state in &done[1].notes.states {
        let (place, _) = pose(&done[1].system, state, 0);
        let (theta, left) = ((-place.y).atan2(place.x), held * (1.0 - state.time));
        let rest = k * theta - (MASS * G * ARM - left * a) * theta.cos();
        assert!(rest.abs() < 1e-7, "{}: {rest:e}", state.time);
        assert_eq!(reaction(&done[1], state, "prop").0, Vec3::zeros());
        let (force, _) = reaction(&done[1], state, "hinge");
        assert!((force.y - (MASS * G - left)).abs() < 1e-7, "{}: {force}", state.time);
        seen += 1;
    }
    assert!(seen >= 4 && (done[1].state.time - 1.0).abs() < 1e-12);
    // The prop has another length than the distance of its points now.
    model.steps.push(step("again", at_rest(), &[], &[]));
    let text = refused(&model);
    assert!(text.starts_with("steps[2]: the joint \"prop\" acts again in the step \"again\""), "{text}");
    let theta = {
        let p = pose(&done[1].system, &done[1].state, 0).0;
        (-p.y).atan2(p.x)
    };
    let length = Vec3::new(a * theta.cos() - a, 0.6 - a * theta.sin(), 0.0).norm();
    let gap = (length - 0.6).abs();
    assert!(text.contains(&format!("{gap:.3e}")), "{text} {gap:.3e}");
}

/// A hinge that is locked in a loaded static step carries the moment that its load makes, and without the lock the spring does.
#[test]
fn a_lock_that_is_released_in_statics_hands_its_moment_over() {
    let k = 30.0;
    let bar = body("bar", [ARM, 0.0, 0.0], MASS, Some([0.2, 0.25, 0.3]));
    let hinge = revolute("hinge", "ground", "bar", [0.0; 3], [0.0, 0.0, 1.0]);
    let mut model = Model::of_bodies(at_rest(), vec![bar], vec![hinge]);
    model.torsion_springs = vec![TorsionSpring {
        name: "coil".into(),
        between: between("ground", "bar"),
        axis: [0.0, 0.0, 1.0],
        stiffness: k,
        damping: 0.0,
        moment: None,
        free_angle: 0.0,
    }];
    model.loads = gravity([0.0, -G, 0.0]);
    let locked = || step("locked", at_rest(), &[], &["hinge"]);
    model.steps = vec![locked(), step("free", at_rest(), &[], &[]), locked(), locked()];
    let done = run(&model).unwrap();
    let angle = |done: &Done| {
        let (place, _) = pose(&done.system, &done.state, 0);
        (-place.y).atan2(place.x)
    };
    assert!(angle(&done[0]).abs() < 1e-10);
    assert!((reaction(&done[0], &done[0].state, "hinge").1.z - MASS * G * ARM).abs() < 1e-8);
    let theta = angle(&done[1]);
    assert!(theta > 0.1 && (k * theta - MASS * G * ARM * theta.cos()).abs() < 1e-8, "{theta}");
    // Locked where it stands in equilibrium, it has no moment to carry.
    for locked in &done[2..] {
        assert!((angle(locked) - theta).abs() < 1e-9);
        assert!(reaction(locked, &locked.state, "hinge").1.norm() < 1e-7);
    }
}

/// The moment of a released drive, or of a lock, falls with the load factor whatever the angle: on a torsion spring the body turns back by
/// `θ = θ₀ (1 − λ)` from a quarter of a turn, or to `θ = M λ/k` where the moment M was locked.
#[test]
fn the_moment_of_a_released_drive_or_lock_falls_with_the_load_factor_at_any_angle() {
    let k = 2.0;
    let axis = [1.0, 2.0, 2.0];
    let wheel = body("wheel", [0.0; 3], MASS, Some([0.2; 3]));
    let motor = Joint::DrivenAngle(DrivenAngleJoint {
        name: "motor".into(),
        between: between("ground", "wheel"),
        axis,
        angle: 100.0,
        amplitude: DRIVE.into(),
    });
    let hinge = revolute("hinge", "ground", "wheel", [0.0; 3], axis);
    let in_steps = || Analysis::Static(StaticAnalysis { load_steps: 10, ..StaticAnalysis::default() });
    let with = |joints: Vec<Joint>, steps: Vec<AnalysisStep>| {
        let mut model = Model::of_bodies(at_rest(), vec![wheel.clone()], joints);
        let ramp = Amplitude::Expression(ExpressionAmplitude { expression: "t".into() });
        model.amplitudes.insert(DRIVE.into(), ramp);
        model.torsion_springs = vec![TorsionSpring {
            name: "coil".into(),
            between: between("ground", "wheel"),
            axis,
            stiffness: k,
            damping: 0.0,
            moment: None,
            free_angle: 0.0,
        }];
        model.steps = steps;
        model
    };
    let seen = |done: &Done, exact: &dyn Fn(f64) -> f64| {
        assert!(done.notes.states.len() >= 10);
        for state in &done.notes.states {
            let (_, turned) = pose(&done.system, state, 0);
            let angle = (0.5 * (turned.trace() - 1.0)).clamp(-1.0, 1.0).acos();
            // The arccosine loses half of the digits near 0.
            assert!((angle - exact(state.time)).abs() < 1e-7, "{}: {angle}", state.time);
        }
    };
    let steps = vec![step("turned", in_steps(), &[], &[]), step("free", in_steps(), &["motor"], &[])];
    let done = run(&with(vec![hinge.clone(), motor], steps)).unwrap();
    seen(&done[1], &|factor| 100.0_f64.to_radians() * (1.0 - factor));
    // Locked under a moment that would turn it by 2.5 rad.
    let steps = vec![step("locked", at_rest(), &[], &["hinge"]), step("free", in_steps(), &[], &[])];
    let mut model = with(vec![hinge], steps);
    let value = (Vec3::from(axis) / 3.0 * (2.5 * k)).into();
    model.loads =
        vec![Load::Moment(VectorLoad { on: "wheel".into(), value, amplitude: None, distribution: None })];
    let done = run(&model).unwrap();
    seen(&done[1], &|factor| 2.5 * factor);
}

/// A wheel that a motor turns by a rate, and that runs on at it when the motor is switched off; the motor takes hold again where the
/// wheel stands, with half the rate. The impact does the work of the motor's impulse and dissipates ½ J Δω².
#[test]
fn a_motor_that_is_switched_off_lets_its_wheel_run_on() {
    let j = 0.2;
    let wheel =
        RigidBody { angular_velocity: [0.0, 0.0, 3.0], ..body("wheel", [0.0; 3], 1.0, Some([0.1, 0.1, j])) };
    let motor = Joint::DrivenAngle(DrivenAngleJoint {
        name: "motor".into(),
        between: between("ground", "wheel"),
        axis: [0.0, 0.0, 1.0],
        angle: 3f64.to_degrees(),
        amplitude: DRIVE.into(),
    });
    for scheme in schemes() {
        let joints = vec![revolute("hinge", "ground", "wheel", [0.0; 3], [0.0, 0.0, 1.0]), motor.clone()];
        let run_for = |end| moving(scheme, end, 0.01);
        let mut model = Model::of_bodies(run_for(1.0), vec![wheel.clone()], joints);
        // Undefined behind t = 2: nobody asks for it while the motor is off.
        model.amplitudes.insert(
            DRIVE.into(),
            Amplitude::Expression(ExpressionAmplitude { expression: "t + 0*sqrt(2 - t)".into() }),
        );
        model.steps = vec![
            step("driven", run_for(1.0), &[], &[]),
            step("off", run_for(3.0), &["motor"], &[]),
            step("again", run_for(0.5), &[], &[]),
        ];
        let done = run(&model).unwrap();
        let angle = |done: &Done| {
            let (_, r) = pose(&done.system, &done.state, 0);
            r.m21.atan2(r.m11)
        };
        let wrapped = |x: f64| (x.sin()).atan2(x.cos());
        for (i, time) in [1.0, 4.0, 4.5].into_iter().enumerate() {
            let difference = wrapped(angle(&done[i]) - 3.0 * time);
            assert!(difference.abs() < 3e-3, "{scheme:?} {i}: {difference:e}");
        }
        let spin = |balance: &Balance| balance.angular_momentum[2] / j;
        assert!((spin(&done[1].first) - 3.0).abs() < 1e-3, "{}", spin(&done[1].first));
        // Generalised-α does not conserve energy exactly.
        let drift = if matches!(scheme, Scheme::GeneralizedAlpha(_)) { 1e-7 } else { 1e-10 };
        assert!(done[1].notes.drift() < drift, "{scheme:?} {:e}", done[1].notes.drift());
        for state in &done[1].notes.states {
            assert_eq!(reaction(&done[1], state, "motor"), (Vec3::zeros(), Vec3::zeros()));
        }
    }
    // Energy–momentum with another rate: the work of the impact is that of the impulse J Δω at the rate of the motor.
    let slow = |rate: f64| {
        Joint::DrivenAngle(DrivenAngleJoint {
            name: "slow".into(),
            between: between("ground", "wheel"),
            axis: [0.0, 0.0, 1.0],
            angle: rate.to_degrees(),
            amplitude: DRIVE.into(),
        })
    };
    let joints = vec![revolute("hinge", "ground", "wheel", [0.0; 3], [0.0, 0.0, 1.0]), slow(1.5)];
    let mut model = machine(0.5, 0.01, vec![wheel], joints);
    model
        .amplitudes
        .insert(DRIVE.into(), Amplitude::Expression(ExpressionAmplitude { expression: "t".into() }));
    let run_for = model.analysis.clone();
    model.steps = vec![step("free", run_for.clone(), &["slow"], &[]), step("driven", run_for, &[], &[])];
    let done = run(&model).unwrap();
    let first = done[1].first;
    assert!((first.dissipated - 0.5 * j * 1.5 * 1.5).abs() < 1e-9, "{}", first.dissipated);
    assert!((first.work + j * 1.5 * 1.5).abs() < 1e-9, "{}", first.work);
    assert!((first.total - 0.5 * j * 9.0).abs() < 1e-9, "{}", first.total);
}

/// Two bodies that fly apart when the bolt between them is gone: each keeps the velocity of its mass centre and its spin.
#[test]
fn bodies_fly_apart_when_the_bolt_between_them_is_gone() {
    let w = 2.0;
    let of = |name: &str, x: f64| RigidBody {
        velocity: [0.0, w * x, 0.0],
        angular_velocity: [0.0, 0.0, w],
        ..body(name, [x, 0.0, 0.0], 1.0, Some([0.1; 3]))
    };
    let bolt = Joint::Fixed(PointJoint {
        name: "bolt".into(),
        between: between("a", "b"),
        at: [0.0; 3],
        second_at: None,
    });
    for scheme in schemes() {
        let run_for = |end: f64| moving(scheme, end, 1e-3);
        let mut model = Model::of_bodies(run_for(1.0), vec![of("a", -1.0), of("b", 1.0)], vec![bolt.clone()]);
        model.steps = vec![step("one", run_for(0.5), &[], &[]), step("two", run_for(0.5), &["bolt"], &[])];
        let done = run(&model).unwrap();
        // At ω t = 1 rad each flies along its tangent.
        let (sine, cosine) = 1_f64.sin_cos();
        for (i, side) in [-1.0, 1.0].into_iter().enumerate() {
            let (place, _) = pose(&done[1].system, &done[1].state, i);
            let expected = Vec3::new(cosine - 0.5 * w * sine, sine + 0.5 * w * cosine, 0.0) * side;
            assert!((place - expected).norm() < 2e-5, "{scheme:?}: {place} {expected}");
        }
        assert!(done[1].system.constraints() == 0 && done[1].first.dissipated == 0.0);
    }
}
