//! Bushings in analyses: small motions against their matrices, frequencies, large rotations, conservation, dissipation, refusals.

use nalgebra::{Matrix6, Rotation3, UnitVector3, Vector6};

use crate::common::{Notes, vector_load};
use crate::multibody::{between, body, gravity, machine, pose, revolute, run};
use crate::patches::{hub, strip};
use tegula::analysis::{Observer, Silent, State, Step, modal, statics};
use tegula::constraint::BushingResponse;
use tegula::model::*;
use tegula::result::bodies::bushing_responses;
use tegula::{Error, Mat3, System, Vec3, compile, mesh};

/// Axes (columns) askew to those of space.
pub fn askew() -> Mat3 {
    Rotation3::from_axis_angle(&UnitVector3::new_normalize(Vec3::new(1.0, -2.0, 0.5)), 0.8).into_inner()
}

/// A full positive definite matrix, of displacements about 10³ and of rotations about 10.
pub fn full() -> Matrix6<f64> {
    let sizes = Vector6::new(30.0, 40.0, 35.0, 3.0, 4.0, 3.5);
    let a = Matrix6::from_fn(|i, j| ((7 * i + 3 * j) as f64 * 1.3 + 0.2).sin());
    let k = (a.transpose() * a) * 0.3 + Matrix6::identity();
    Matrix6::from_fn(|i, j| k[(i, j)] * sizes[i] * sizes[j])
}

pub fn rows(matrix: &Matrix6<f64>) -> Option<[[f64; 6]; 6]> {
    Some(std::array::from_fn(|i| std::array::from_fn(|j| matrix[(i, j)])))
}

/// A bushing without stiffness and damping, with the axes of [`askew`].
pub fn bushing(ends: [&str; 2], at: [f64; 3]) -> Bushing {
    let q = askew();
    Bushing {
        name: "mount".into(),
        between: between(ends[0], ends[1]),
        at,
        axes: [q.column(0).into_owned().into(), q.column(1).into_owned().into()],
        stiffness: None,
        stiffness_matrix: None,
        damping: None,
        damping_matrix: None,
        free: [0.0; 6],
    }
}

fn built(model: &Model) -> System {
    compile::build(model, &mesh::generators::generate(&model.mesh).unwrap()).unwrap()
}

fn solved(model: &Model) -> (System, statics::StaticOutcome) {
    let system = built(model);
    let Analysis::Static(options) = &model.analysis else { panic!() };
    let outcome = statics::run(&system, options, None, &mut Silent).unwrap();
    (system, outcome)
}

/// A body on a bushing to the ground under a force and a moment.
fn mounted(body: RigidBody, mount: Bushing, [force, moment]: [Vec3; 2]) -> Model {
    let mut model =
        Model::of_bodies(Analysis::Static(StaticAnalysis::default()), vec![body.clone()], Vec::new());
    model.bushings = vec![mount];
    model.loads = vec![
        Load::Force(vector_load(&body.name, force.into())),
        Load::Moment(vector_load(&body.name, moment.into())),
    ];
    model
}

fn six(r: &BushingResponse) -> [Vector6<f64>; 2] {
    let of = |a: &Vec3, b: &Vec3| Vector6::new(a.x, a.y, a.z, b.x, b.y, b.z);
    [of(&r.displacement, &r.rotation), of(&r.force, &r.moment)]
}

/// A small force and moment of each column of the matrix, at the bushing and along its axes, make the unit strain of the column.
#[test]
fn columns_of_the_matrix_make_unit_strains() {
    let (k, q, at, size) = (full(), askew(), [0.3, -0.2, 0.5], 1e-8);
    let mount = Bushing { stiffness_matrix: rows(&k), ..bushing(["ground", "block"], at) };
    for column in 0..6 {
        let load = k.column(column) * size;
        let along = |from: usize| q * load.fixed_rows::<3>(from);
        let block = body("block", at, 2.0, Some([0.3, 0.4, 0.5]));
        let (system, outcome) = solved(&mounted(block, mount.clone(), [along(0), along(3)]));
        let [strain, force] = six(&bushing_responses(&system, &outcome.state)[0]);
        let mut expected = Vector6::zeros();
        expected[column] = size;
        assert!((strain - expected).norm() < 1e-5 * size, "{column}: {strain}");
        assert!((force - load).norm() < 1e-5 * load.norm(), "{column}: {force}");
    }
}

/// A bushing beside the mass centre, at r from it: a force F displaces the centre by F/k along the axes, and by the rotation
/// φ = (−r × F)/k_φ times −r.
#[test]
fn the_elastic_centre_may_lie_beside_the_mass_centre() {
    let (k, q, at) = ([800.0, 1500.0, 600.0, 9.0, 14.0, 20.0], askew(), Vec3::new(0.2, 0.5, -0.3));
    let mount = Bushing { stiffness: Some(k), ..bushing(["ground", "block"], at.into()) };
    let force = Vec3::new(1.0, -2.0, 0.7) * 1e-6;
    let (system, outcome) =
        solved(&mounted(body("block", [0.0; 3], 2.0, Some([0.3; 3])), mount, [force, Vec3::zeros()]));
    let over = |v: Vec3, from: usize| q * Vec3::from_fn(|i, _| (q.transpose() * v)[i] / k[from + i]);
    let expected = over(force, 0) + over((-at).cross(&force), 3).cross(&-at);
    let (centre, _) = pose(&system, &outcome.state, 0);
    assert!((centre - expected).norm() < 1e-5 * expected.norm(), "{centre} {expected}");
}

/// A tilted mount with a full matrix: ω² are the eigenvalues of M⁻¹ Tᵀ K T, with the strains ε = T q of small displacements of the
/// centre and rotations q.
#[test]
fn frequencies_of_a_body_on_a_coupled_bushing_are_those_of_the_matrix_pencil() {
    let (k, q, at) = (full(), askew(), Vec3::new(0.2, 0.5, -0.3));
    let (mass, inertia) = (2.0, [0.3, 0.4, 0.5]);
    let mount = Bushing { stiffness_matrix: rows(&k), ..bushing(["ground", "block"], at.into()) };
    let block = body("block", [0.0; 3], mass, Some(inertia));
    let mut model = Model::of_bodies(Analysis::Modal(ModalAnalysis::new(6)), vec![block], Vec::new());
    model.bushings = vec![mount];
    let found = modal::run(&built(&model), 6, None, &mut Silent).unwrap();
    let mut t = Matrix6::zeros();
    t.fixed_view_mut::<3, 3>(0, 0).copy_from(&q.transpose());
    t.fixed_view_mut::<3, 3>(0, 3).copy_from(&(-q.transpose() * at.cross_matrix()));
    t.fixed_view_mut::<3, 3>(3, 3).copy_from(&q.transpose());
    let root = Matrix6::from_diagonal(&Vector6::new(mass, mass, mass, inertia[0], inertia[1], inertia[2]))
        .map(|m: f64| if m > 0.0 { 1.0 / m.sqrt() } else { 0.0 });
    let mut squares: Vec<f64> =
        (root * t.transpose() * k * t * root).symmetric_eigenvalues().iter().copied().collect();
    squares.sort_by(f64::total_cmp);
    assert_eq!(found.modes.len(), 6);
    for (mode, square) in found.modes.iter().zip(squares) {
        assert!((mode.omega / square.sqrt() - 1.0).abs() < 1e-9, "{} {}", mode.omega, square.sqrt());
    }
}

/// A hinge about an axis of the bushing, through its point.
fn hinge(on: &str) -> Joint {
    revolute("hinge", "ground", on, [0.0; 3], askew().column(2).into_owned().into())
}

/// A moment M about one axis turns a body, on a hinge or held by the bushing alone, by M/k, up to large angles, with the energy ½ k θ².
#[test]
fn a_moment_about_an_axis_turns_in_proportion_up_to_the_largest_rotation() {
    for (angle, guided) in
        [20.0_f64, 95.0, 140.0].into_iter().flat_map(|angle| [(angle, true), (angle, false)])
    {
        let moment = askew().column(2) * (20.0 * angle.to_radians());
        let stiffness = Some([800.0, 1500.0, 600.0, 9.0, 14.0, 20.0]);
        let mount = Bushing { stiffness, ..bushing(["ground", "block"], [0.0; 3]) };
        let mut model = mounted(body("block", [0.0; 3], 2.0, Some([0.3; 3])), mount, [Vec3::zeros(), moment]);
        if guided {
            model.joints = vec![hinge("block")];
        }
        let (system, outcome) = solved(&model);
        let found = bushing_responses(&system, &outcome.state)[0];
        assert!((found.rotation.z.to_degrees() - angle).abs() < 1e-7, "{angle}: {}", found.rotation);
        assert!((found.moment.z / moment.norm() - 1.0).abs() < 1e-9, "{angle}: {}", found.moment);
        let energy = 10.0 * angle.to_radians().powi(2);
        assert!((outcome.balance.strain / energy - 1.0).abs() < 1e-8, "{}", outcome.balance.strain);
    }
}

/// Under a force beside the bushing, force and moment at the large rotation of the equilibrium are the derivatives of ½ ε·K ε, with the
/// rotation vector by the logarithm of the rotation matrix.
#[test]
fn a_large_rotation_about_a_skew_axis_is_in_equilibrium_with_the_derivative_of_the_energy() {
    let (k, q, at) = (full(), askew(), Vec3::new(0.2, 0.5, -0.3));
    let force = Vec3::new(35.0, 20.0, 50.0);
    let mount = Bushing { stiffness_matrix: rows(&k), ..bushing(["ground", "block"], at.into()) };
    let (system, outcome) =
        solved(&mounted(body("block", [0.0; 3], 2.0, Some([0.3; 3])), mount, [force, Vec3::zeros()]));
    let (x, r) = pose(&system, &outcome.state, 0);
    let energy = |dx: Vec3, turn: Vec3| {
        let rotation = Rotation3::new(turn).matrix() * r;
        let u = q.transpose() * (x + dx + rotation * at - at);
        let phi = Rotation3::from_matrix_unchecked(q.transpose() * rotation * q).scaled_axis();
        let strain = Vector6::new(u.x, u.y, u.z, phi.x, phi.y, phi.z);
        0.5 * strain.dot(&(k * strain))
    };
    let slope = |f: &dyn Fn(Vec3) -> f64| {
        Vec3::from_fn(|i, _| {
            let step = Vec3::ith(i, 1e-5);
            (f(step) - f(-step)) / 2e-5
        })
    };
    let found = [slope(&|dx| energy(dx, Vec3::zeros())), slope(&|turn| energy(Vec3::zeros(), turn))];
    assert!((found[0] - force).norm() < 1e-6 * force.norm(), "{} {force}", found[0]);
    assert!(found[1].norm() < 1e-6 * force.norm() * at.norm(), "{}", found[1]);
    let response = bushing_responses(&system, &outcome.state)[0];
    assert!(response.rotation.norm() > 1.0, "{}", response.rotation);
    // The moment of the force about the point of the body.
    let moment = (-r * at).cross(&force);
    assert!((q * response.force - force).norm() < 1e-8 * force.norm(), "{}", response.force);
    assert!((q * response.moment - moment).norm() < 1e-8 * moment.norm(), "{} {moment}", response.moment);
}

/// Two bodies on a bushing with a full matrix that fly and tumble against each other.
fn flying(step: f64) -> Model {
    let spun = |name: &str, at: [f64; 3], w: [f64; 3], v: [f64; 3]| RigidBody {
        angular_velocity: w,
        velocity: v,
        ..body(name, at, 1.0, Some([0.2, 0.3, 0.4]))
    };
    let bodies = vec![
        spun("a", [-0.4, 0.0, 0.1], [0.5, 3.0, -6.0], [1.0, 2.0, 0.0]),
        spun("b", [0.3, 0.2, 0.0], [4.0, 1.0, 5.0], [1.5, 1.0, -3.0]),
    ];
    let mut model = machine(1.0, step, bodies, Vec::new());
    model.bushings =
        vec![Bushing { stiffness_matrix: rows(&(full() * 0.4)), ..bushing(["a", "b"], [0.0; 3]) }];
    model
}

/// Largest rotation, and largest displacement, of the first bushing.
#[derive(Default)]
struct Extremes {
    system: Option<System>,
    rotation: f64,
    displacement: f64,
}

impl Observer for Extremes {
    fn on_step(&mut self, step: &Step) -> tegula::Result<()> {
        let Some(system) = &self.system else { panic!() };
        let found = bushing_responses(system, step.state)[0];
        self.rotation = tegula::norm::larger(self.rotation, found.rotation.norm());
        self.displacement = tegula::norm::larger(self.displacement, found.displacement.norm());
        Ok(())
    }
}

/// Energy and momenta are conserved to round-off, at rotations beyond a right angle, in steps of both orders.
#[test]
fn two_tumbling_bodies_keep_energy_and_momenta() {
    for order in [2, 4] {
        let mut model = flying(0.01);
        let Analysis::Transient(options) = &mut model.analysis else { panic!() };
        options.scheme = Scheme::EnergyMomentum(EnergyMomentumScheme { order });
        let mut extremes = Extremes { system: Some(built(&model)), ..Extremes::default() };
        run(&model, &mut extremes);
        assert!(extremes.rotation > 1.7 && extremes.displacement > 0.1, "{}", extremes.rotation);
        let mut notes = Notes::default();
        run(&model, &mut notes);
        assert!(notes.totals.len() > 90);
        assert!(notes.drift() <= 1e-11 * notes.kinetic, "{order}: {} {}", notes.drift(), notes.kinetic);
        let (linear, angular) = notes.momenta[0];
        for (p, l) in &notes.momenta {
            assert!((p - linear).norm() <= 1e-11 * linear.norm(), "{order}: {p} {linear}");
            assert!((l - angular).norm() <= 1e-11 * angular.norm(), "{order}: {l} {angular}");
        }
    }
}

/// Strains and dissipated energy after each step.
struct Dissipated<'a> {
    system: &'a System,
    found: Vec<(f64, Vector6<f64>, f64)>,
}

impl Observer for Dissipated<'_> {
    fn on_step(&mut self, step: &Step) -> tegula::Result<()> {
        let [strain, _] = six(&bushing_responses(self.system, step.state)[0]);
        self.found.push((step.state.time, strain, step.balance.dissipated));
        Ok(())
    }
}

/// A damper with a full matrix dissipates `Σ Δε·D Δε/Δt` in steps of the energy–momentum scheme, and that is missing in kinetic and
/// strain energy.
#[test]
fn the_damper_dissipates_what_the_motion_loses() {
    let mut model = flying(0.01);
    let damping = full() * 0.01;
    model.bushings[0].damping_matrix = rows(&damping);
    let mut notes = Notes::default();
    let (system, _) = run(&model, &mut notes);
    assert!(notes.drift() <= 1e-11 * notes.kinetic, "{} {}", notes.drift(), notes.kinetic);
    let mut observer = Dissipated { system: &system, found: Vec::new() };
    run(&model, &mut observer);
    let (mut time, mut strain, mut expected) = (0.0, Vector6::zeros(), 0.0);
    for (t, new, dissipated) in observer.found.into_iter().filter(|(t, ..)| *t > 0.0) {
        let change = new - strain;
        expected += change.dot(&(damping * change)) / (t - time);
        assert!((dissipated - expected).abs() < 1e-9 * notes.kinetic, "{t}: {dissipated} {expected}");
        (time, strain) = (t, new);
    }
    assert!(expected > 0.1 * notes.kinetic, "{expected}");
}

/// A body that swings about one axis of its bushing with an amplitude of 2.4 rad: θ = θ₀ e^(−δt) (cos ωt + …), damped and not, in both
/// schemes, with an error of second order.
#[test]
fn a_body_swings_about_an_axis_with_a_large_amplitude() {
    for damping in [0.0, 0.4] {
        for scheme in [
            Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 }),
            Scheme::GeneralizedAlpha(GeneralizedAlphaScheme { spectral_radius: 0.9 }),
        ] {
            let (k, inertia, end) = (2.0_f64, 0.5, 2.0);
            let decay = damping / (2.0 * inertia);
            let omega = (k / inertia - decay * decay).sqrt();
            let speed = 2.4 * (k / inertia).sqrt();
            let error = |step: f64| {
                let spun = RigidBody {
                    angular_velocity: (askew().column(2) * speed).into(),
                    ..body("block", [0.0; 3], 2.0, Some([inertia; 3]))
                };
                let mut model = machine(end, step, vec![spun], Vec::new());
                let Analysis::Transient(options) = &mut model.analysis else { panic!() };
                options.scheme = scheme;
                model.bushings = vec![Bushing {
                    stiffness: Some([50.0, 50.0, 50.0, 3.0, 4.0, k]),
                    damping: (damping > 0.0).then_some([0.0, 0.0, 0.0, 0.0, 0.0, damping]),
                    ..bushing(["ground", "block"], [0.0; 3])
                }];
                let (system, state) = run(&model, &mut Silent);
                let found = bushing_responses(&system, &state)[0].rotation;
                let expected = speed / omega * (-decay * end).exp() * (omega * end).sin();
                assert!(found.x.abs() + found.y.abs() < 1e-9, "{found}");
                (found.z - expected).abs()
            };
            let [coarse, fine] = [4e-3, 2e-3].map(error);
            let ratio = coarse / fine;
            assert!(fine < 1e-4 && (3.5..4.5).contains(&ratio), "{scheme:?} {damping}: {coarse} {fine}");
        }
    }
}

/// A bushing without stiffness of rotations lets a body spin by any number of turns, and holds a point mass.
#[test]
fn a_bushing_of_displacements_alone_takes_full_turns_and_point_masses() {
    let stiffness = Some([800.0, 1500.0, 600.0, 0.0, 0.0, 0.0]);
    let spun = RigidBody {
        angular_velocity: [0.0, 0.0, 20.0],
        ..body("block", [0.0; 3], 2.0, Some([0.3, 0.3, 0.5]))
    };
    let mut model = machine(1.0, 0.01, vec![spun], Vec::new());
    model.bushings = vec![Bushing { stiffness, ..bushing(["ground", "block"], [0.0; 3]) }];
    let (system, state) = run(&model, &mut Silent);
    let (_, r) = pose(&system, &state, 0);
    // Steps of the energy–momentum scheme turn by 2 atan(½ ω Δt).
    let turned = 200.0 * 0.1_f64.atan();
    assert!((r.m11 - turned.cos()).abs() + (r.m21 - turned.sin()).abs() < 1e-9, "{r} {turned}");
    let force = Vec3::new(3.0, -4.0, 5.0);
    let mut model = mounted(
        body("dot", [0.1, 0.2, 0.3], 1.0, None),
        Bushing { stiffness, ..bushing(["ground", "dot"], [0.1, 0.2, 0.3]) },
        [force, Vec3::zeros()],
    );
    model.loads.truncate(1);
    let (system, outcome) = solved(&model);
    let (x, _) = pose(&system, &outcome.state, 0);
    let local = askew().transpose() * force;
    let expected = askew() * Vec3::new(local.x / 800.0, local.y / 1500.0, local.z / 600.0);
    assert!((x - Vec3::new(0.1, 0.2, 0.3) - expected).norm() < 1e-12, "{x}");
}

/// A free displacement moves a body along its weight: k (z − z₀) = −m g; a free rotation turns it to where it has no moment.
#[test]
fn a_body_without_other_loads_goes_to_the_free_deformation() {
    let free = [0.01, -0.02, 0.03, 20.0, 60.0, -40.0];
    let mount = Bushing { stiffness_matrix: rows(&full()), free, ..bushing(["ground", "block"], [0.0; 3]) };
    let block = body("block", [0.0; 3], 2.0, Some([0.3; 3]));
    let mut model =
        Model::of_bodies(Analysis::Static(StaticAnalysis::default()), vec![block.clone()], Vec::new());
    model.bushings = vec![mount.clone()];
    let (system, outcome) = solved(&model);
    let found = bushing_responses(&system, &outcome.state)[0];
    let displaced = (found.displacement - Vec3::new(0.01, -0.02, 0.03)).norm();
    let turned = (found.rotation.map(f64::to_degrees) - Vec3::new(20.0, 60.0, -40.0)).norm();
    assert!(displaced < 1e-9 && turned < 1e-7, "{found:?}");
    let along = Bushing {
        axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        stiffness: Some([100.0, 100.0, 100.0, 5.0, 5.0, 5.0]),
        stiffness_matrix: None,
        free: [0.0, 0.0, 0.4, 0.0, 0.0, 0.0],
        ..mount
    };
    model.bushings = vec![along];
    model.loads = gravity([0.0, 0.0, -10.0]);
    let (system, outcome) = solved(&model);
    let (x, _) = pose(&system, &outcome.state, 0);
    assert!((x - Vec3::new(0.0, 0.0, 0.4 - 0.2)).norm() < 1e-9, "{x}");
}

/// Small deflection of the end of a cantilever by a force F across it grows by F/k + F L²/k_φ where a bushing is in the place of its
/// clamp; for a beam, and for a strip of shell on a rigid patch.
#[test]
fn cantilevers_on_a_bushing_deflect_by_its_compliance_more() {
    let stiffness = Some([1e3, 1e3, 50.0, 7.0, 3.0, 7.0]);
    let mount = |on: &str, at: [f64; 3]| Bushing {
        axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        stiffness,
        ..bushing(["ground", on], at)
    };
    let clamp = |on: &str, at: [f64; 3]| {
        vec![Joint::Fixed(PointJoint {
            name: "clamp".into(),
            between: between("ground", on),
            at,
            second_at: None,
        })]
    };
    let force = 1e-7;
    let expected = force / 50.0 + force / 3.0;
    let section = BeamSection::Rectangle(RectangularSection { size: [0.05, 0.05] });
    let material = Some("steel".to_owned());
    let beam =
        Beam { material, ..Beam::straight("arm", [[0.0; 3], [1.0, 0.0, 0.0]], 4, [0.0, 0.0, 1.0], section) };
    let mut beams = Model::of_bodies(Analysis::Static(StaticAnalysis::default()), Vec::new(), Vec::new());
    beams.materials.insert("steel".into(), Material::Isotropic(Isotropic::new(2e7, 0.3, 7800.0)));
    beams.beams = vec![beam];
    beams.loads = vec![Load::Force(vector_load("arm.end", [0.0, 0.0, force]))];
    let deflection = |mut model: Model, on: &str, at: [f64; 3], soft: bool| {
        if soft {
            model.bushings = vec![mount(on, at)];
        } else {
            model.joints = clamp(on, at);
        }
        let (system, outcome) = solved(&model);
        let vectors = (0..system.vectors()).filter(|&v| {
            let x = system.coordinates.reference[v];
            let position = system.coordinates.kinds[v] == tegula::system::VectorKind::Position;
            position && (x[0] - 1.0).abs() < 1e-12
        });
        let list: Vec<f64> = vectors.map(|v| outcome.state.u[v][2]).collect();
        list.iter().sum::<f64>() / list.len() as f64
    };
    let more = deflection(beams.clone(), "arm.start", [0.0; 3], true)
        - deflection(beams, "arm.start", [0.0; 3], false);
    assert!((more / expected - 1.0).abs() < 1e-5, "{more} {expected}");
    for &element in ElementKind::ALL {
        let mut shell = strip(element, [8, 2], 0.0);
        let at = [0.0, 0.1, 0.0];
        shell.bodies = vec![hub("hub", at, &["u_min"])];
        shell.loads = vec![Load::Edge(vector_load("u_max", [0.0, 0.0, force / 0.2]))];
        let more = deflection(shell.clone(), "hub", at, true) - deflection(shell, "hub", at, false);
        assert!((more / expected - 1.0).abs() < 1e-5, "{more} {expected}");
    }
}

/// Rotations beyond 150° end an analysis with the name of the bushing, in statics and in motions.
#[test]
fn rotations_beyond_the_range_end_the_analysis_with_the_name_of_the_bushing() {
    let mount = Bushing {
        stiffness: Some([50.0, 50.0, 50.0, 2.0, 2.0, 2.0]),
        ..bushing(["ground", "block"], [0.0; 3])
    };
    let block = body("block", [0.0; 3], 2.0, Some([0.5; 3]));
    let moment = askew().column(2) * (2.0 * 155_f64.to_radians());
    let mut model = mounted(block.clone(), mount.clone(), [Vec3::zeros(), moment]);
    model.joints = vec![hinge("block")];
    let Analysis::Static(options) = &model.analysis else { panic!() };
    let told = |error: Error| {
        let text = format!("{error}");
        assert!(text.contains("the bushing \"mount\"") && text.contains("150°"), "{text}");
    };
    told(statics::run(&built(&model), options, None, &mut Silent).unwrap_err());
    for scheme in [
        Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 }),
        Scheme::GeneralizedAlpha(GeneralizedAlphaScheme { spectral_radius: 0.9 }),
    ] {
        for axis in [askew().column(2).into_owned(), Vec3::new(0.6, 0.0, 0.8)] {
            // The amplitude without a limit would be 3.5 rad.
            let spun = RigidBody { angular_velocity: (axis * 7.0).into(), ..block.clone() };
            let mut model = machine(2.0, 0.05, vec![spun], Vec::new());
            model.bushings = vec![mount.clone()];
            let Analysis::Transient(options) = &mut model.analysis else { panic!() };
            options.scheme = scheme;
            let options = options.clone();
            told(tegula::analysis::dynamics::run(&built(&model), &options, None, &mut Silent).unwrap_err());
        }
    }
}

/// A motion continues where a static step has ended, at a rotation beyond half of the range in one step.
#[test]
fn a_motion_begins_at_the_rotation_of_a_static_step() {
    let mut model =
        machine(0.1, 0.01, vec![body("block", [0.0; 3], 2.0, Some([0.5; 3]))], vec![hinge("block")]);
    let moment = askew().column(2) * (2.0 * 145_f64.to_radians());
    model.bushings = vec![Bushing {
        stiffness: Some([50.0, 50.0, 50.0, 2.0, 2.0, 2.0]),
        ..bushing(["ground", "block"], [0.0; 3])
    }];
    model.loads = vec![Load::Moment(vector_load("block", moment.into()))];
    let (moves, rest) = (model.analysis.clone(), StaticAnalysis::default());
    model.steps = vec![
        AnalysisStep::new("rest", Analysis::Static(rest.clone())),
        AnalysisStep::new("motion", moves.clone()),
    ];
    let mesh = mesh::generators::generate(&model.mesh).unwrap();
    let compiler = compile::Compiler::new(&model, &mesh).unwrap();
    let start: State =
        statics::run(&compiler.system(0, None).unwrap(), &rest, None, &mut Silent).unwrap().state;
    let system = compiler.system(1, Some(start.end_of_step())).unwrap();
    let Analysis::Transient(options) = &moves else { panic!() };
    let state = tegula::analysis::dynamics::run(&system, options, None, &mut Silent).unwrap().state;
    let found = bushing_responses(&system, &state)[0].rotation.map(f64::to_degrees);
    assert!((found - Vec3::new(0.0, 0.0, 145.0)).norm() < 1e-6, "{found}");
}

#[test]
fn wrong_bushings_are_refused_with_their_place() {
    let mut model = machine(1.0, 0.1, vec![body("block", [0.0; 3], 1.0, Some([0.5; 3]))], Vec::new());
    model.bodies.push(body("dot", [1.0, 0.0, 0.0], 1.0, None));
    let good = Bushing { stiffness: Some([1.0; 6]), ..bushing(["ground", "block"], [0.0; 3]) };
    let refused = |bushings: Vec<Bushing>, key: &str| {
        let model = Model { bushings, ..model.clone() };
        let mesh = mesh::generators::generate(&model.mesh).unwrap();
        let Err(Error::Model(issues)) = compile::build(&model, &mesh) else { panic!("{key} is taken") };
        assert!(issues.iter().any(|issue| issue.place.key == key), "{key}: {issues:?}");
    };
    let one = |bushing: Bushing, key: &str| refused(vec![bushing], key);
    refused(vec![good.clone(), good.clone()], "bushings[1].name");
    one(Bushing { name: "a/b".into(), ..good.clone() }, "bushings[0].name");
    one(Bushing { between: between("block", "block"), ..good.clone() }, "bushings[0].between");
    one(Bushing { between: between("ground", "nothing"), ..good.clone() }, "bushings[0].between[1]");
    let at = [1.0, 0.0, 0.0];
    one(Bushing { between: between("ground", "dot"), at, ..good.clone() }, "bushings[0].between[1]");
    one(Bushing { between: between("dot", "block"), at, ..good.clone() }, "bushings[0].between[0]");
    let displacements = Some([1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
    let beside = Bushing { between: between("ground", "dot"), stiffness: displacements, ..good.clone() };
    one(beside, "bushings[0].at");
    one(Bushing { at: [f64::NAN, 0.0, 0.0], ..good.clone() }, "bushings[0].at");
    one(Bushing { axes: [[0.0; 3], [0.0, 1.0, 0.0]], ..good.clone() }, "bushings[0].axes[0]");
    one(Bushing { axes: [[1.0, 1.0, 0.0], [2.0, 2.0, 0.0]], ..good.clone() }, "bushings[0].axes");
    one(Bushing { stiffness: Some([0.0; 6]), ..good.clone() }, "bushings[0]");
    one(Bushing { stiffness: None, ..good.clone() }, "bushings[0]");
    let with = |i: usize, value: f64| {
        let mut six = [1.0; 6];
        six[i] = value;
        Some(six)
    };
    one(Bushing { stiffness: with(2, -1.0), ..good.clone() }, "bushings[0].stiffness[2]");
    one(Bushing { damping: with(4, f64::INFINITY), ..good.clone() }, "bushings[0].damping[4]");
    one(Bushing { stiffness_matrix: rows(&full()), ..good.clone() }, "bushings[0].stiffness_matrix");
    let matrix = |i: usize, j: usize, value: f64, symmetric: bool| {
        let mut k = full();
        k[(i, j)] = value;
        if symmetric {
            k[(j, i)] = value;
        }
        Bushing { stiffness: None, stiffness_matrix: rows(&k), ..good.clone() }
    };
    one(matrix(1, 4, 3.0, false), "bushings[0].stiffness_matrix[4][1]");
    one(matrix(1, 4, f64::NAN, true), "bushings[0].stiffness_matrix");
    one(matrix(1, 4, 1e6, true), "bushings[0].stiffness_matrix");
    one(matrix(3, 3, -1.0, true), "bushings[0].stiffness_matrix");
    one(matrix(3, 3, 0.0, true), "bushings[0].stiffness_matrix");
    one(Bushing { free: [f64::NAN; 6], ..good.clone() }, "bushings[0].free");
    one(Bushing { free: [0.0, 0.0, 0.0, 100.0, 100.0, 100.0], ..good.clone() }, "bushings[0].free");
    let free = [0.0, 0.0, 0.0, 10.0, 0.0, 0.0];
    one(Bushing { free, stiffness: displacements, ..good.clone() }, "bushings[0].free");
    let composed = Bushing { damping: Some([1.0; 6]), ..good };
    let Analysis::Transient(mut options) = model.analysis.clone() else { panic!() };
    options.scheme = Scheme::EnergyMomentum(EnergyMomentumScheme { order: 4 });
    model.analysis = Analysis::Transient(options.clone());
    model.bushings = vec![composed];
    let refused = |model: &Model, key: &str| {
        let Err(Error::Model(issues)) = compile::build(model, &tegula::Mesh::default()) else {
            panic!("{key}")
        };
        assert!(issues.iter().any(|issue| issue.place.key == key), "{key}: {issues:?}");
    };
    refused(&model, "analysis.scheme.order");
    options.scheme = Scheme::Newmark(NewmarkScheme::default());
    model.analysis = Analysis::Transient(options);
    refused(&model, "analysis");
    model.analysis = Analysis::Static(StaticAnalysis { linear: true, ..StaticAnalysis::default() });
    refused(&model, "analysis");
}
