//! Beams: rigid motions, conservation, and closed solutions of beam theory. The machines with beams of the verification
//! compare with other programs.

use crate::common::Notes;

use tegula::analysis::{Observer, Silent, State, dynamics, statics};
use tegula::model::*;
use tegula::result::beams::beam_resultants;
use tegula::result::joint_reaction;
use tegula::{System, Vec3, compile, mesh};

const STEEL: Isotropic =
    Isotropic { young: 2.1e11, poisson: 0.3, density: 7800.0, expansion: 0.0, strength: None };

fn model(end: f64, step: Option<f64>, beams: Vec<Beam>, joints: Vec<Joint>) -> Model {
    let scheme = Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 });
    let analysis = TransientAnalysis { scheme, time_step: step, ..TransientAnalysis::new(end) };
    let mut model = Model::of_bodies(Analysis::Transient(analysis), Vec::new(), joints);
    model.materials.insert("steel".into(), Material::Isotropic(STEEL));
    Model { beams, ..model }
}

fn run(model: &Model, observer: &mut dyn Observer) -> (System, State) {
    let mesh = mesh::generators::generate(&model.mesh).unwrap();
    let system = compile::build(model, &mesh).unwrap();
    let Analysis::Transient(options) = &model.analysis else { panic!() };
    let outcome = dynamics::run(&system, options, None, observer).unwrap();
    (system, outcome.state)
}

pub fn rectangle(size: [f64; 2]) -> BeamSection {
    BeamSection::Rectangle(RectangularSection { size })
}

/// A quarter of a circle of radius 1 in the plane x-y, twisted by 60°.
fn curved(elements: usize) -> Beam {
    let at = |i: usize| {
        let angle = std::f64::consts::FRAC_PI_2 * i as f64 / elements as f64;
        [angle.cos(), angle.sin(), 0.0]
    };
    Beam {
        points: (0..=elements).map(at).collect(),
        elements: None,
        twist: 60.0,
        material: Some("steel".into()),
        ..Beam::straight("arc", [[0.0; 3]; 2], 1, [0.0, 0.0, 1.0], rectangle([0.05, 0.02]))
    }
}

fn place(system: &System, state: &State, body: &str) -> Vec3 {
    let body = system.coordinates.bodies.iter().find(|b| b.name == body).unwrap();
    Vec3::from(system.coordinates.reference[body.centre as usize]) + Vec3::from(state.u[body.centre as usize])
}

pub fn fixed(name: &str, a: &str, b: &str, at: [f64; 3]) -> Joint {
    Joint::Fixed(PointJoint { name: name.into(), between: [a.into(), b.into()], at, second_at: None })
}

#[test]
fn a_curved_twisted_beam_that_translates_and_turns_slowly_has_no_resultants() {
    let beam = Beam { velocity: [3.0, -1.0, 2.0], ..curved(6) };
    let (system, state) = run(&model(1.0, Some(0.1), vec![beam], Vec::new()), &mut Notes::default());
    let line = &system.beams[0];
    let largest = tegula::norm::max_norm(beam_resultants(&system, &state, line).concat());
    // EA = 2.1e8.
    assert!(largest < 1e-6, "{largest}");
    let moved = place(&system, &state, "arc.end") - Vec3::new(0.0, 1.0, 0.0);
    assert!((moved - Vec3::new(3.0, -1.0, 2.0)).norm() < 1e-12, "{moved}");
}

#[test]
fn a_free_curved_twisted_beam_keeps_energy_and_momenta() {
    let beam = Beam { angular_velocity: [20.0, -30.0, 40.0], velocity: [1.0, 0.0, 2.0], ..curved(6) };
    let mut notes = Notes::default();
    run(&model(0.05, Some(2e-4), vec![beam], Vec::new()), &mut notes);
    notes.assert_conserved(1e-9);
}

/// A clamped beam under a suddenly applied small force vibrates about the static deflection, which the mean over whole periods
/// of the first mode shows: F L³/(3 EI) + F L/(kGA). Period 2π/(3.516 √(EI/(ρA L⁴))) of Euler and Bernoulli less the part of
/// shear and rotary inertia.
#[test]
fn a_clamped_beam_vibrates_about_the_deflection_of_timoshenko_with_the_period_of_its_first_mode() {
    let (length, size) = (2.0, [0.05, 0.1]);
    let beam = Beam {
        material: Some("steel".into()),
        ..Beam::straight("beam", [[0.0; 3], [length, 0.0, 0.0]], 16, [0.0, 1.0, 0.0], rectangle(size))
    };
    // Axis 1 is y, axis 2 is z: a force along z bends about axis 1.
    let (area, moment) = (size[0] * size[1], size[0] * size[1].powi(3) / 12.0);
    let (bending, shear) = (STEEL.young * moment, 5.0 / 6.0 * STEEL.young / 2.6 * area);
    let period =
        std::f64::consts::TAU / (3.516015 * (bending / (STEEL.density * area * length.powi(4))).sqrt());
    let force = 1.0;
    let mut model = model(
        3.0 * period,
        Some(period / 400.0),
        vec![beam],
        vec![fixed("clamp", "ground", "beam.start", [0.0; 3])],
    );
    let value = [0.0, 0.0, force];
    model.loads = vec![Load::Force(VectorLoad::new("beam.end", value))];
    let mut notes = Notes { keep: true, ..Notes::default() };
    let (system, state) = run(&model, &mut notes);
    let tip: Vec<(f64, f64)> =
        notes.states.iter().map(|state| (state.time, place(&system, state, "beam.end").z)).collect();
    let mean: f64 = tip.iter().skip(1).map(|(_, z)| z).sum::<f64>() / (tip.len() - 1) as f64;
    let expected = force * (length.powi(3) / (3.0 * bending) + length / shear);
    assert!((mean - expected).abs() < 0.01 * expected, "{mean} {expected}");
    // Returns to zero after whole periods: the last minimum.
    let last = tip.iter().filter(|(t, _)| *t > 2.5 * period).min_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
    assert!((last.0 / (3.0 * period) - 1.0).abs() < 0.02, "{} {period}", last.0 / period);
    let (reaction, _) = joint_reaction(&system, &state, &system.joints[0]);
    assert!(reaction.norm().is_finite());
}

/// Static equilibrium of beams and joints under loads on their nodes.
fn stand(
    beams: Vec<Beam>,
    joints: Vec<Joint>,
    loads: Vec<Load>,
    materials: &[(&str, Isotropic)],
) -> (System, State) {
    let mut model = Model { beams, loads, ..model(1.0, None, Vec::new(), joints) };
    model.analysis = Analysis::Static(StaticAnalysis::default());
    for (name, material) in materials {
        model.materials.insert((*name).into(), Material::Isotropic(material.clone()));
    }
    let mesh = mesh::generators::generate(&model.mesh).unwrap();
    let system = compile::build(&model, &mesh).unwrap();
    let Analysis::Static(options) = &model.analysis else { panic!() };
    let outcome = statics::run(&system, options, None, &mut Silent).unwrap();
    (system, outcome.state)
}

fn displacement(system: &System, state: &State, body: &str) -> Vec3 {
    let body = system.coordinates.bodies.iter().find(|b| b.name == body).unwrap();
    Vec3::from(state.u[body.centre as usize])
}

/// F L³/(3 EI) + F L/(kGA), whatever the number of elements.
#[test]
fn a_small_tip_force_bends_a_clamped_beam_as_timoshenkos_theory_says() {
    let solve = |elements: u32| {
        let beam = Beam {
            material: Some("steel".into()),
            ..Beam::straight(
                "beam",
                [[0.0; 3], [2.0, 0.0, 0.0]],
                elements,
                [0.0, 1.0, 0.0],
                rectangle([0.05, 0.1]),
            )
        };
        let loads = vec![Load::Force(VectorLoad::new("beam.end", [0.0, 3e-3, 5e-3]))];
        stand(vec![beam], vec![fixed("clamp", "ground", "beam.start", [0.0; 3])], loads, &[])
    };
    let shear = 5.0 / 6.0 * STEEL.young / 2.6 * 0.005;
    for n in [1, 8] {
        let (system, state) = solve(n);
        let tip = displacement(&system, &state, "beam.end");
        for (found, force, sides) in [(tip.y, 3e-3, (0.1, 0.05_f64)), (tip.z, 5e-3, (0.05, 0.1_f64))] {
            let bending = STEEL.young * sides.0 * sides.1.powi(3) / 12.0;
            let expected = force * (8.0 / (3.0 * bending) + 2.0 / shear);
            assert!((found - expected).abs() < 1e-6 * expected, "{found} {expected}");
        }
        let (force, moment) = joint_reaction(&system, &state, &system.joints[0]);
        assert!((force * 1e3 + Vec3::new(0.0, 3.0, 5.0)).norm() < 1e-6, "{force}");
        assert!((moment * 1e3 - Vec3::new(0.0, 10.0, -6.0)).norm() < 1e-5, "{moment}");
    }
}

/// Euler's column, clamped and hinged: 2.0457 π² EI/L². Sixteen elements are 0.7 % too stiff.
#[test]
fn a_column_on_joints_buckles_at_eulers_load() {
    let beam = Beam {
        material: Some("steel".into()),
        ..Beam::straight("beam", [[0.0; 3], [0.0, 0.0, 2.0]], 16, [1.0, 0.0, 0.0], rectangle([0.02, 0.03]))
    };
    let joints = vec![
        Joint::Revolute(
            AxisJoint {
                name: "foot".into(),
                between: ["ground".into(), "beam.start".into()],
                at: [0.0; 3],
                axis: [0.0, 1.0, 0.0],
                second_at: None,
                second_axis: None,
            }
            .into(),
        ),
        Joint::Cylindrical(AxisJoint {
            name: "head".into(),
            between: ["ground".into(), "beam.end".into()],
            at: [0.0, 0.0, 2.0],
            axis: [0.0, 0.0, 1.0],
            second_at: None,
            second_axis: None,
        }),
    ];
    let critical = 2.0457 * std::f64::consts::PI.powi(2) * STEEL.young * 0.03 * 0.02_f64.powi(3) / 12.0 / 4.0;
    let solve = |load: f64| {
        let mut model = Model { beams: vec![beam.clone()], ..model(1.0, None, Vec::new(), joints.clone()) };
        model.analysis = Analysis::Static(StaticAnalysis { load_steps: 4, ..StaticAnalysis::default() });
        model.loads = vec![Load::Force(VectorLoad::new("beam.end", [0.0, 0.0, -load]))];
        let mesh = mesh::generators::generate(&model.mesh).unwrap();
        let system = compile::build(&model, &mesh).unwrap();
        let Analysis::Static(options) = &model.analysis else { panic!() };
        statics::run(&system, options, None, &mut Silent)
    };
    assert!(solve(0.995 * critical).is_ok());
    let error = solve(1.01 * critical).unwrap_err().to_string();
    assert!(error.contains("buckling"), "{error}");
}

/// Tip displacements in the direction of a unit force. Quarter circle by Castigliano's theorem: F R³/EI π/4 in its plane,
/// F R³ (π/4 /EI + (3π/4 − 2)/GJ) across it, and the parts of shear and stretch. Twisted beam: R. H. MacNeal, R. L. Harder, *A
/// proposed standard set of problems to test finite element accuracy*, Finite Elem. Anal. Des. 1 (1985) 3–20.
#[test]
fn curved_and_twisted_beams_bend_as_macneal_and_harder_say() {
    let arc = |elements: usize| {
        let at = |i: usize| {
            let angle = std::f64::consts::FRAC_PI_2 * i as f64 / elements as f64;
            [4.22 * angle.sin(), 4.22 * (1.0 - angle.cos()), 0.0]
        };
        Beam {
            points: (0..=elements).map(at).collect(),
            elements: None,
            material: Some("curved".into()),
            ..Beam::straight("beam", [[0.0; 3]; 2], 1, [0.0, 0.0, 1.0], rectangle([0.1, 0.2]))
        }
    };
    let twisted = |elements: u32| Beam {
        twist: 90.0,
        material: Some("twisted".into()),
        ..Beam::straight(
            "beam",
            [[0.0; 3], [12.0, 0.0, 0.0]],
            elements,
            [0.0, 1.0, 0.0],
            rectangle([1.1, 0.32]),
        )
    };
    let materials =
        [("curved", Isotropic::new(1e7, 0.25, 1.0)), ("twisted", Isotropic::new(29e6, 0.22, 1.0))];
    let pi = std::f64::consts::PI;
    let (young, modulus, r): (f64, f64, f64) = (1e7, 4e6, 4.22);
    let [in_plane, across] = [0.1 * 0.2_f64.powi(3) / 12.0, 0.2 * 0.1_f64.powi(3) / 12.0].map(|i| young * i);
    // Torsion constant of a rectangle 2:1, Timoshenko and Goodier.
    let torsion = modulus * 0.2287 * 0.2 * 0.001;
    let (stretch, shear) = (young * 0.02, 5.0 / 6.0 * modulus * 0.02);
    let radial = 0.25 * pi * (r.powi(3) / in_plane + r / shear + r / stretch);
    let normal = r.powi(3) * (0.25 * pi / across + (0.75 * pi - 2.0) / torsion) + 0.5 * pi * r / shear;
    // At its end the section of the twisted beam has turned: its width is along z there.
    let cases = [
        (arc(24), [1.0, 0.0, 0.0], radial),
        (arc(24), [0.0, 0.0, 1.0], normal),
        (twisted(24), [0.0, 0.0, 1.0], 0.005424),
        (twisted(24), [0.0, 1.0, 0.0], 0.001754),
    ];
    for (beam, direction, expected) in cases {
        let loads = vec![Load::Force(VectorLoad::new("beam.end", direction.map(|x| 1e-3 * x)))];
        let clamp = fixed("clamp", "ground", "beam.start", [0.0; 3]);
        let (system, state) = stand(vec![beam], vec![clamp], loads, &materials);
        let found = 1e3 * displacement(&system, &state, "beam.end").dot(&Vec3::from(direction));
        assert!((found / expected - 1.0).abs() < 0.01, "{direction:?}: {found} {expected}");
    }
}

/// Section of a beam that hardly stretches and shears, with the bending stiffness 100.
const SLENDER: SectionConstants = SectionConstants {
    axial: 1e6,
    shear: [1e6; 2],
    bending: [100.0; 2],
    torsion: 80.0,
    mass: 1.0,
    inertia: [1e-4; 2],
};

/// The moment 2π EI/L at the end bends a clamped beam to a circle; the error falls with the square of the element's length.
#[test]
#[ignore = "long"]
fn an_end_moment_rolls_a_beam_up_to_a_circle() {
    let moment = 2.0 * std::f64::consts::PI * 100.0 / 10.0;
    let gap = |elements: u32| {
        let section = BeamSection::Constants(SLENDER);
        let beam = Beam::straight("beam", [[0.0; 3], [10.0, 0.0, 0.0]], elements, [0.0, 0.0, 1.0], section);
        let loads = vec![Load::Moment(VectorLoad::new("beam.end", [0.0, 0.0, moment]))];
        let clamp = fixed("clamp", "ground", "beam.start", [0.0; 3]);
        let (system, state) = stand(vec![beam], vec![clamp], loads, &[]);
        for n in beam_resultants(&system, &state, &system.beams[0]) {
            assert!((n[3] - moment).abs() < 1e-6 * moment && n[4].abs() < 1e-6 * moment, "{n:?} {moment}");
        }
        place(&system, &state, "beam.end").norm()
    };
    let gaps = [gap(40), gap(80)];
    assert!(gaps[1] < 0.05, "{gaps:?}");
    assert!((3.7..4.3).contains(&(gaps[0] / gaps[1])), "{gaps:?}");
}

/// Of eight elements that a moment rolls up to half a circle each bends by 22.5°: the end is farther away than 2L/π, and a warning says so. Of 32
/// elements the end is within 2 %, without a warning.
#[test]
fn a_beam_of_few_elements_that_bends_far_is_warned_of() {
    let moment = std::f64::consts::PI * 100.0 / 10.0;
    for (elements, warned) in [(8, true), (32, false)] {
        let section = BeamSection::Constants(SLENDER);
        let beam = Beam::straight("rod", [[0.0; 3], [10.0, 0.0, 0.0]], elements, [0.0, 0.0, 1.0], section);
        let mut model = model(1.0, None, vec![beam], vec![fixed("clamp", "ground", "rod.start", [0.0; 3])]);
        model.loads = vec![Load::Moment(VectorLoad::new("rod.end", [0.0, 0.0, moment]))];
        model.analysis = Analysis::Static(StaticAnalysis::default());
        let system = compile::build(&model, &mesh::generators::generate(&model.mesh).unwrap()).unwrap();
        let mut notes = Notes::default();
        let outcome = statics::run(&system, &StaticAnalysis::default(), None, &mut notes).unwrap();
        let told = |w: &String| w.contains("element of the beam \"rod\"") && w.contains("too small by about");
        assert_eq!(notes.warnings.iter().any(told), warned, "{:?}", notes.warnings);
        let error =
            (place(&system, &outcome.state, "rod.end").norm() * std::f64::consts::PI / 20.0 - 1.0).abs();
        assert_eq!(error > 0.1, warned, "{error}");
    }
}

/// A simply supported beam under its weight: 5 w L⁴/(384 EI) + w L²/(8 kGA), reactions w L/2.
#[test]
fn a_beam_on_hinges_sags_under_its_weight() {
    let ends = [[0.0; 3], [4.0, 0.0, 0.0]];
    let beam = Beam {
        material: Some("steel".into()),
        ..Beam::straight("beam", ends, 16, [0.0, 1.0, 0.0], rectangle([0.05, 0.1]))
    };
    let axis = [0.0, 1.0, 0.0];
    let hinge = Joint::Revolute(
        AxisJoint {
            name: "hinge".into(),
            between: ["ground".into(), "beam.start".into()],
            at: ends[0],
            axis,
            second_at: None,
            second_axis: None,
        }
        .into(),
    );
    let slide = Joint::Planar(AxisJoint {
        name: "slide".into(),
        between: ["ground".into(), "beam.end".into()],
        at: ends[1],
        axis,
        second_at: None,
        second_axis: None,
    });
    let rest = Joint::Distance(DistanceJoint {
        name: "rest".into(),
        between: ["ground".into(), "beam.end".into()],
        points: [[4.0, 0.0, -1e4], ends[1]],
    });
    let gravity = vec![Load::Gravity(GravityLoad { value: [0.0, 0.0, -9.81], amplitude: None })];
    let (system, state) = stand(vec![beam], vec![hinge, slide, rest], gravity, &[]);
    let weight = 9.81 * STEEL.density * 0.005;
    let (bending, shear) = (STEEL.young * 0.05 * 0.001 / 12.0, 5.0 / 6.0 * STEEL.young / 2.6 * 0.005);
    let expected = weight * (5.0 * 256.0 / (384.0 * bending) + 16.0 / (8.0 * shear));
    let sag = -displacement(&system, &state, "beam.8").z;
    assert!((sag / expected - 1.0).abs() < 0.01, "{sag} {expected}");
    let (force, _) = joint_reaction(&system, &state, &system.joints[2]);
    // Half of the weight of the last half element rests on the node itself: nothing is lost.
    assert!((force.z - 2.0 * weight).abs() < 1e-3 * weight, "{force} {weight}");
}

/// A static step bends a clamped strip by a driven hinge at its end, a transient one holds the hinge where it stands: nothing moves.
#[test]
fn a_drive_of_a_later_step_begins_where_the_joint_stands() {
    let beam = Beam {
        material: Some("steel".into()),
        ..Beam::straight("beam", [[0.0; 3], [2.0, 0.0, 0.0]], 8, [0.0, 1.0, 0.0], rectangle([0.05, 0.01]))
    };
    let drive = Joint::DrivenAngle(DrivenAngleJoint {
        name: "drive".into(),
        between: ["ground".into(), "beam.end".into()],
        axis: [0.0, 1.0, 0.0],
        angle: 60.0,
        amplitude: "grow".into(),
    });
    let joints = vec![fixed("clamp", "ground", "beam.start", [0.0; 3]), drive];
    let scheme = Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 });
    let motion = TransientAnalysis { scheme, time_step: Some(1e-3), ..TransientAnalysis::new(0.01) };
    let mut model = Model { beams: vec![beam], ..model(1.0, None, Vec::new(), joints) };
    // The amplitude grows from 0 to 0.01 in the second step: the hinge turns by another 0.6°.
    let formula = ExpressionAmplitude { expression: "t".into() };
    model.amplitudes.insert("grow".into(), Amplitude::Expression(formula));
    model.steps = vec![
        AnalysisStep::new(
            "bend",
            Analysis::Static(StaticAnalysis { load_steps: 4, ..StaticAnalysis::default() }),
        ),
        AnalysisStep::new("on", Analysis::Transient(motion.clone())),
    ];
    let mesh = mesh::generators::generate(&model.mesh).unwrap();
    let compiler = compile::Compiler::new(&model, &mesh).unwrap();
    let system = compiler.system(0, None).unwrap();
    let angle = |system: &System, state: &State| {
        let d = system.coordinates.bodies[8].directors.unwrap()[2] as usize;
        let normal = Vec3::from(system.coordinates.reference[d]) + Vec3::from(state.u[d]);
        (-normal.z).atan2(normal.x).to_degrees()
    };
    let Analysis::Static(options) = &model.steps[0].analysis else { panic!() };
    let bent = statics::run(&system, options, None, &mut Silent).unwrap();
    assert!((angle(&system, &bent.state) - 60.0).abs() < 1e-9, "{}", angle(&system, &bent.state));
    // Pure bending: the drive carries M = EI θ/L, with n elements EI n sin(2θ/n)/(2L).
    let (_, moment) = joint_reaction(&system, &bent.state, &system.joints[1]);
    let expected = STEEL.young * 0.05 * 1e-6 / 12.0 * 8.0 * 15f64.to_radians().sin() / 4.0;
    assert!((moment.y / expected - 1.0).abs() < 1e-6, "{moment} {expected}");
    let next = compiler.system(1, Some(bent.state.end_of_step())).unwrap();
    let moved = dynamics::run(&next, &motion, None, &mut Silent).unwrap();
    assert!((angle(&next, &moved.state) - 60.6).abs() < 1e-9, "{}", angle(&next, &moved.state));
}

/// Damping of the whole model damps beams as their own retardation time does.
#[test]
fn stiffness_damping_of_the_model_dissipates_in_beams() {
    let dissipated = |own: f64, whole: f64| {
        let beam = Beam {
            material: Some("steel".into()),
            retardation_time: own,
            ..Beam::straight("beam", [[0.0; 3], [1.0, 0.0, 0.0]], 4, [0.0, 1.0, 0.0], rectangle([0.05, 0.02]))
        };
        let mut model =
            model(0.02, Some(1e-3), vec![beam], vec![fixed("clamp", "ground", "beam.start", [0.0; 3])]);
        model.loads = crate::multibody::gravity([0.0, 0.0, -9.81]);
        model.damping.stiffness = whole;
        run(&model, &mut Silent).1.dissipated
    };
    let (own, whole) = (dissipated(1e-3, 0.0), dissipated(0.0, 1e-3));
    assert!(own > 0.0 && whole == own, "{own} {whole}");
}

/// In statics beams need no mass, but gravity does: without any mass in the model it is refused, and not a load of zero.
#[test]
fn gravity_on_beams_without_mass_is_refused() {
    let section = SectionConstants {
        axial: 1e4,
        shear: [1e4; 2],
        bending: [1.0; 2],
        torsion: 1.0,
        mass: 0.0,
        inertia: [0.0; 2],
    };
    let beam = |mass: f64| {
        let section = BeamSection::Constants(SectionConstants { mass, ..section });
        Beam::straight("beam", [[0.0; 3], [1.0, 0.0, 0.0]], 4, [0.0, 0.0, 1.0], section)
    };
    let built = |mass: f64, load: Load| {
        let joints = vec![fixed("clamp", "ground", "beam.start", [0.0; 3])];
        let mut model = Model::of_bodies(Analysis::Static(StaticAnalysis::default()), Vec::new(), joints);
        (model.beams, model.loads) = (vec![beam(mass)], vec![load]);
        let mesh = mesh::generators::generate(&model.mesh).unwrap();
        compile::build(&model, &mesh).map(|_| ()).map_err(|e| e.to_string())
    };
    let [gravity] = <[Load; 1]>::try_from(crate::multibody::gravity([0.0, 0.0, -9.81])).unwrap();
    let force = Load::Force(VectorLoad::new("beam.end", [0.0, 0.0, 1.0]));
    let refused = built(0.0, gravity.clone()).unwrap_err();
    assert!(refused.contains("beams[0]: gravity acts on masses, but neither beam \"beam\""), "{refused}");
    assert_eq!((built(0.0, force), built(1.0, gravity)), (Ok(()), Ok(())));
}
