//! Motion in time and vibrations of every element type: conservation, order, energy balance, restart, frequencies.

use crate::common;
use std::f64::consts::PI;

use crate::common::{
    Notes, compile, distance, model, move_in_time as run, on, orthotropic, plate, vector_load,
};
use tegula::analysis::{Silent, dynamics, modal, statics};
use tegula::material::NeoHookeanForm;
use tegula::model::*;
use tegula::norm::max_norm;
use tegula::{System, Vec3};

const NEWMARK: Scheme = Scheme::Newmark(NewmarkScheme { beta: 0.25, gamma: 0.5 });
const HHT: Scheme = Scheme::Hht(HhtScheme { alpha: -0.1 });
const ENERGY_MOMENTUM: Scheme = Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 });

fn options(scheme: Scheme, end_time: f64, time_step: f64) -> TransientAnalysis {
    TransientAnalysis { scheme, time_step: Some(time_step), ..TransientAnalysis::new(end_time) }
}

fn ply() -> Material {
    orthotropic([4e6, 6e5, 5e5], [3e5, 2.5e5, 2e5], 700.0)
}

/// Two oblique plies on a heavy isotropic one: nothing is symmetric about the middle.
fn uneven(m: &mut Model, thickness: f64) {
    m.materials.insert("ply".into(), ply());
    let layer = |material: &str, angle, part: f64| LayupPly {
        material: Some(material.into()),
        angle,
        thickness: Some(part * thickness),
    };
    m.sections[0].material.clear();
    m.sections[0].thickness = 0.0;
    m.sections[0].layup = Some(Layup {
        plies: vec![layer("m", 0.0, 0.5), layer("ply", 30.0, 0.3), layer("ply", -50.0, 0.2)],
        ..Layup::default()
    });
}

/// A free plate that flies, tumbles and vibrates.
pub fn tumbling(element: ElementKind, laminated: bool) -> Model {
    let mut m = model(plate([1.0, 0.6], [3, 2], 0.2), 1e6, 0.02);
    m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(1e6, 0.3, 500.0)));
    m.sections[0].element = element;
    if laminated {
        uneven(&mut m, 0.02);
    }
    m.conditions.clear();
    let velocity = |set: &str, velocity, angular_velocity| InitialVelocity {
        on: set.into(),
        velocity,
        angular_velocity,
        center: [0.5, 0.3, 0.0],
    };
    m.initial_velocities = vec![
        velocity("all", [1.0, -2.0, 0.5], [4.0, 2.0, 6.0]),
        velocity("u_max", [0.0, 0.0, 2.0], [0.0; 3]),
    ];
    m
}

#[test]
#[ignore = "long"]
fn every_element_conserves_energy_and_momenta_in_free_flight() {
    for &element in ElementKind::ALL {
        for laminated in [false, true] {
            if laminated && element == ElementKind::AncfFull {
                continue;
            }
            let mut notes = Notes::default();
            let m = tumbling(element, laminated);
            let (_, outcome) = run(&m, &options(ENERGY_MOMENTUM, 0.3, 5e-3), &mut notes);
            let (p0, l0) = notes.momenta[0];
            let lost = |f: fn(&(Vec3, Vec3)) -> Vec3, from: Vec3| {
                max_norm(notes.momenta.iter().map(|x| (f(x) - from).norm()))
            };
            let (p, l) = (lost(|x| x.0, p0), lost(|x| x.1, l0));
            println!("{element:?} {laminated}: energy {:e} {p:e} {l:e}", notes.drift() / notes.kinetic);
            assert!(outcome.balance.strain > 1e-4 * notes.kinetic, "{element:?}: it must deform");
            assert!(notes.drift() < 2e-12 * notes.kinetic, "{element:?} {laminated}: {:e}", notes.drift());
            let (p, l) = (p / p0.norm(), l / l0.norm());
            assert!(p < 2e-12 && l < 2e-12, "{element:?} {laminated}: {p:e} {l:e}");
        }
    }
}

/// A soft, thick plate on an incline whose motion a few milliseconds resolve.
pub fn soft_plate(element: ElementKind) -> Model {
    let mut source = plate([1.0, 1.0], [2, 2], 0.2);
    if let MeshSource::Plate(p) = &mut source {
        p.v_axis = [0.0, 0.6, 0.8];
    }
    let mut m = model(source, 1e5, 0.5);
    m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(1e5, 0.3, 1e3)));
    m.sections[0].element = element;
    m.loads = vec![Load::Gravity(GravityLoad { value: [2.0, 1.0, -9.81], amplitude: None })];
    m.initial_velocities = vec![InitialVelocity {
        on: "all".into(),
        velocity: [0.0; 3],
        angular_velocity: [0.3, 2.0, 0.0],
        center: [0.0; 3],
    }];
    m
}

/// Halving the step quarters the error, also where directors keep their length, with damping, and where one of their
/// components is supported, so that they turn on a circle smaller than their length.
#[test]
fn schemes_are_of_second_order_with_unit_directors() {
    let free = soft_plate(ElementKind::Mitc4);
    let damped = Model { damping: Damping { mass: 0.5, stiffness: 2e-3 }, ..free.clone() };
    let mut guided = free.clone();
    guided.conditions.push(Condition::Fix(FixComponents {
        on: "u_max".into(),
        position: vec![],
        director: vec![Axis::Y],
    }));
    let mut spinning = free.clone();
    spinning.conditions = vec![Condition::Spherical(on("u_min_v_min"))];
    spinning.initial_velocities[0].angular_velocity = [1.0, 6.0, 2.0];
    for (name, m) in [("clamped", free), ("damped", damped), ("guided", guided), ("spinning", spinning)] {
        let end = 0.256;
        let at = |scheme, steps: u32| {
            run(&m, &options(scheme, end, end / f64::from(steps)), &mut Notes::default()).1.state
        };
        let exact = at(NEWMARK, 2048);
        for scheme in [NEWMARK, HHT, ENERGY_MOMENTUM] {
            let error = |steps: u32| {
                let s = at(scheme, steps);
                (distance(&s.u, &exact.u), distance(&s.v, &exact.v))
            };
            let (coarse, fine) = (error(64), error(128));
            let ratios = (coarse.0 / fine.0, coarse.1 / fine.1);
            println!("{name} {scheme:?}: {coarse:?} {ratios:?}");
            assert!((3.6..4.4).contains(&ratios.0), "{name} {scheme:?}: displacement {ratios:?}");
            assert!((3.4..4.6).contains(&ratios.1), "{name} {scheme:?}: velocity {ratios:?}");
        }
    }
}

/// kinetic + strain + potential + dissipated − work is constant: exactly with energy–momentum, to second order else.
/// `order` is that of the balance, at which the drift falls over three halvings where materials yield.
fn check_balance(name: &str, m: &Model, exact: bool, order: i32) {
    let (end, dt) = (0.128, 4e-3);
    if exact {
        let mut notes = Notes::default();
        let (_, outcome) = run(m, &options(ENERGY_MOMENTUM, end, dt), &mut notes);
        println!("{name}: {:?} drift {:e} of {}", outcome.balance, notes.drift(), notes.kinetic);
        assert!(outcome.balance.work.abs() > 1e-3 * notes.kinetic, "{name}: {:?}", outcome.balance);
        assert!(notes.drift() < 5e-13 * notes.kinetic, "{name}: {:e} of {:e}", notes.drift(), notes.kinetic);
    }
    // The beginning of yielding falls somewhere into a step: the order shows over several halvings only.
    let (halvings, gain) = if exact { (1, 3.0) } else { (3, 0.5 * 8.0_f64.powi(order)) };
    for scheme in [NEWMARK, HHT] {
        let drift = |dt| {
            let mut notes = Notes::default();
            run(m, &options(scheme, end, dt), &mut notes);
            notes.drift() / notes.kinetic
        };
        let (coarse, fine) = (drift(dt), drift(0.5_f64.powi(halvings) * dt));
        println!("{name} {scheme:?}: {coarse:e}, {halvings} times halved {fine:e}");
        assert!(coarse < 2e-2 && fine < coarse / gain, "{name} {scheme:?}: {coarse:e}, {fine:e}");
    }
}

fn pulsing(m: &mut Model) -> Option<String> {
    let expression = "sin(20*t)^2".to_string();
    m.amplitudes.insert("pulse".into(), Amplitude::Expression(ExpressionAmplitude { expression }));
    Some("pulse".into())
}

/// Heat, natural curvature and prestress that change in time do work, which the balance counts.
#[test]
#[ignore = "long"]
fn prescribed_strains_in_time_close_the_energy_balance() {
    for &element in ElementKind::ALL {
        let mut m = soft_plate(element);
        if let Some(Material::Isotropic(i)) = m.materials.get_mut("m") {
            i.expansion = 1e-3;
        }
        let amplitude = pulsing(&mut m);
        m.prescribed_strains = vec![
            PrescribedStrain::Thermal(ThermalStrain {
                distribution: None,
                on: "all".into(),
                temperature: 60.0,
                gradient: 100.0,
                amplitude: amplitude.clone(),
            }),
            PrescribedStrain::Prestress(Prestress {
                distribution: None,
                on: "all".into(),
                membrane: [2e3, 0.0, 1e3],
                bending: [0.0, 100.0, 0.0],
                direction: [1.0, 0.0, 0.0],
                amplitude: None,
            }),
        ];
        check_balance(&format!("heat {element:?}"), &m, true, 2);
    }
    let mut m = soft_plate(ElementKind::Cm);
    let law = NeoHookean { shear: 4e4, bulk: 1e5, density: 1e3, form: NeoHookeanForm::Split };
    m.materials.insert("m".into(), Material::NeoHookean(law));
    let natural = |amplitude| common::natural([0.05, 0.0, 0.0], [0.1, 0.0, 0.0], amplitude);
    m.prescribed_strains = vec![natural(pulsing(&mut m))];
    check_balance("rubber", &m, true, 2);
    let mut m = yielding(ElementKind::Mitc4);
    m.prescribed_strains = vec![natural(pulsing(&mut m))];
    // Of first order only: see `Assembly::prescribed_strain_work`.
    check_balance("yielding", &m, false, 1);
}

/// A soft plate that yields on the way.
fn yielding(element: ElementKind) -> Model {
    let mut m = soft_plate(element);
    m.materials.insert(
        "m".into(),
        Material::Plastic(Plastic {
            young: 1e5,
            poisson: 0.3,
            yield_stress: 800.0,
            hardening: 2e4,
            saturation: None,
            saturation_rate: 0.0,
            kinematic: 1e4,
            density: 1e3,
            expansion: 0.0,
        }),
    );
    m
}

#[test]
#[ignore = "long"]
fn plastic_work_closes_the_energy_balance_in_time() {
    for element in [ElementKind::Ems, ElementKind::Mitc4, ElementKind::Cm, ElementKind::SolidShell] {
        let m = yielding(element);
        let mut notes = Notes::default();
        let (_, outcome) = run(&m, &options(HHT, 0.128, 4e-3), &mut notes);
        assert!(outcome.balance.dissipated > 0.02 * notes.kinetic, "{element:?}: {:?}", outcome.balance);
        check_balance(&format!("plastic {element:?}"), &m, false, 2);
    }
}

/// Plastic flow under a strain that is there from time 0 on is part of the first energies, implicit and explicit.
#[test]
fn plastic_flow_at_time_zero_is_in_the_first_energies() {
    for element in [ElementKind::Ems, ElementKind::Mitc4, ElementKind::Cm, ElementKind::SolidShell] {
        let mut m = yielding(element);
        m.initial_velocities.clear();
        m.loads.clear();
        m.prescribed_strains = vec![common::natural([0.0; 3], [0.2, 0.0, 0.0], None)];
        let explicit = Scheme::Explicit(ExplicitScheme::default());
        for o in [
            options(NEWMARK, 4e-4, 1e-4),
            TransientAnalysis { scheme: explicit, ..TransientAnalysis::new(4e-4) },
        ] {
            let mut notes = Notes::keeping();
            if element == ElementKind::Mitc4 && o.scheme == explicit {
                continue; // Explicit steps refuse inextensible directors.
            }
            run(&m, &o, &mut notes);
            let first = notes.states[0].dissipated;
            assert!(first > 0.0, "{element:?} {:?}: {first}", o.scheme);
            assert!(
                notes.drift() < 1e-3 * first,
                "{element:?} {:?}: {:e} of {first:e}",
                o.scheme,
                notes.drift()
            );
        }
    }
}

/// Continued from any step the run is the run itself, bit for bit; a step that was repeated smaller is the step that
/// had this length at once.
#[test]
fn plastic_runs_continue_exactly_and_repeated_steps_leave_no_trace() {
    for (element, scheme) in [(ElementKind::Mitc4, HHT), (ElementKind::Cm, NEWMARK), (ElementKind::Ems, HHT)]
    {
        let m = yielding(element);
        let o = TransientAnalysis {
            scheme,
            tolerance: 2e-5,
            initial_step: Some(0.03),
            ..TransientAnalysis::new(0.2)
        };
        let mut notes = Notes::keeping();
        let (system, straight) = run(&m, &o, &mut notes);
        assert!(straight.statistics.cutbacks > 0, "{element:?}: {:?}", straight.statistics);
        assert!(straight.state.dissipated > 0.0);
        for middle in [1, notes.states.len() / 2, notes.states.len() - 2] {
            let mut rest = Notes::keeping();
            dynamics::run(&system, &o, Some(notes.states[middle].clone()), &mut rest).unwrap();
            assert!(notes.states[middle + 1..] == rest.states[..], "{element:?} {scheme:?} from {middle}");
        }
        // The first step was too long and was repeated.
        let mut start = notes.states[0].clone();
        let accepted = notes.states[1].last_step;
        assert!(accepted < 0.03);
        start.next_step = accepted;
        let mut again = Notes::keeping();
        dynamics::run(&system, &o, Some(start), &mut again).unwrap();
        assert!(again.states[0] == notes.states[1], "{element:?} {scheme:?}: a repeated step differs");
    }
}

fn frequencies(m: &Model, count: usize) -> Vec<modal::Mode> {
    let analysis = ModalAnalysis::new(count as u32);
    let m = Model { analysis: Analysis::Modal(analysis), ..m.clone() };
    modal::run(&compile(&m).1, count, None, &mut Silent).unwrap().modes
}

#[test]
fn free_plates_have_six_rigid_modes_and_agree_on_the_others() {
    for laminated in [false, true] {
        let mut all = Vec::new();
        for &element in ElementKind::ALL {
            if laminated && element == ElementKind::AncfFull {
                continue;
            }
            let mut m = model(plate([1.0, 0.7], [10, 8], 0.1), 1e9, 0.01);
            m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(1e6, 0.0, 500.0)));
            m.sections[0].element = element;
            m.conditions.clear();
            if laminated {
                uneven(&mut m, 0.01);
            }
            let modes = frequencies(&m, 12);
            let rigid: Vec<bool> = modes.iter().map(|m| m.rigid).collect();
            assert_eq!(rigid, [vec![true; 6], vec![false; 6]].concat(), "{element:?} {laminated}");
            let f: Vec<f64> = modes[6..].iter().map(|m| m.frequency_hz).collect();
            println!("{element:?} {laminated}: {f:?}");
            if element != ElementKind::AncfFull {
                all.push((element, f));
            }
        }
        // Ems as the measure of the others; laminates differ a little in how they take transverse shear.
        for (element, f) in &all[1..] {
            for (a, b) in f.iter().zip(&all[0].1) {
                assert!((a - b).abs() < 5e-3 * b, "{element:?} {laminated}: {f:?} for {:?}", all[0].1);
            }
        }
    }
}

/// Small vibrations know the stiffness of a material at the reference only, however large the shape is drawn.
#[test]
fn vibrations_of_nonlinear_materials_are_those_of_their_reference() {
    let (e, nu) = (1e6, 0.3);
    let base = |element| {
        let mut m = model(plate([1.0, 0.5], [6, 3], 0.1), 1.0, 0.02);
        m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(e, nu, 500.0)));
        m.sections[0].element = element;
        // The same for all materials, whose defaults differ.
        m.sections[0].membrane = Some(Membrane::Eas);
        m
    };
    let neo = NeoHookean {
        shear: 0.5 * e / (1.0 + nu),
        bulk: e / (3.0 - 6.0 * nu),
        density: 500.0,
        form: NeoHookeanForm::Split,
    };
    let plastic = Plastic {
        young: e,
        poisson: nu,
        yield_stress: 100.0,
        hardening: 1e3,
        saturation: None,
        saturation_rate: 0.0,
        kinematic: 0.0,
        density: 500.0,
        expansion: 0.0,
    };
    let plastic = Material::Plastic(plastic);
    for (element, material) in [
        (ElementKind::Cm, Material::NeoHookean(neo.clone())),
        (ElementKind::SolidShell, Material::NeoHookean(neo)),
        (ElementKind::Cm, plastic.clone()),
        (ElementKind::Ems, plastic.clone()),
        (ElementKind::Mitc4, plastic),
    ] {
        let linear = frequencies(&base(element), 6);
        let mut m = base(element);
        m.materials.insert("m".into(), material);
        for (a, b) in frequencies(&m, 6).iter().zip(&linear) {
            // Five points over the thickness integrate a plastic layer as two do an elastic one.
            let (a, b) = (a.frequency_hz, b.frequency_hz);
            assert!((a - b).abs() < 1e-6 * b, "{element:?}: {a} for {b}");
        }
    }
}

/// A strip under so much tension that it vibrates like a string: f = n/(2L) √(N/ρh), about the equilibrium under a
/// prestress that grows with the load factor and about a reference that has it from the start.
#[test]
fn prestressed_strips_vibrate_like_strings() {
    let (force, density, h, length) = (1e3_f64, 1e3, 1e-3, 2.0);
    for element in [ElementKind::Ems, ElementKind::Mitc4, ElementKind::Cm, ElementKind::SolidShell] {
        let strip = |amplitude| {
            let mut m = model(plate([length, 0.1], [32, 1], 0.0), 1e6, h);
            m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(1e6, 0.0, density)));
            m.sections[0].element = element;
            m.conditions = vec![Condition::Hinge(on("u_min")), Condition::Hinge(on("u_max"))];
            m.amplitudes.insert("always".into(), Amplitude::Constant(ConstantAmplitude { value: 1.0 }));
            m.prescribed_strains = vec![PrescribedStrain::Prestress(Prestress {
                distribution: None,
                on: "all".into(),
                membrane: [force, 0.0, 0.0],
                bending: [0.0; 3],
                direction: [1.0, 0.0, 0.0],
                amplitude,
            })];
            m.analysis = Analysis::Modal(ModalAnalysis { prestressed: true, ..ModalAnalysis::new(3) });
            compile(&m).1
        };
        let exact = 0.5 / length * (force / (density * h)).sqrt();
        let lowest = |system: &System, state| {
            let modes = modal::run(system, 3, state, &mut Silent).unwrap().modes;
            modes[0].frequency_hz
        };
        let always = strip(Some("always".to_string()));
        let growing = strip(None);
        let outcome = statics::run(&growing, &StaticAnalysis::default(), None, &mut Silent).unwrap();
        for (name, f) in
            [("reference", lowest(&always, None)), ("equilibrium", lowest(&growing, Some(&outcome.state)))]
        {
            assert!((f - exact).abs() < 5e-3 * exact, "{element:?} about the {name}: {f} for {exact}");
        }
    }
}

/// f = π/(2L²) √(EI/ρA) of a hinged strip, as a half with a plane of symmetry; 3.5160/(2π L²) √(EI/ρA) clamped.
#[test]
fn supports_of_unit_directors_hold_in_vibrations() {
    let (e, h, density, length) = (1e9_f64, 0.01, 1e3, 1.0);
    let wave = (e * h * h / 12.0 / density).sqrt() / (length * length);
    for element in [ElementKind::Mitc4, ElementKind::Ems, ElementKind::Cm] {
        let strip = |length: f64, conditions: Vec<Condition>| {
            let mut m = model(plate([length, 0.05], [24, 1], 0.0), e, h);
            m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(e, 0.0, density)));
            m.sections[0].element = element;
            m.conditions = conditions;
            let guide = FixComponents { on: "all".into(), position: vec![Axis::Y], director: vec![Axis::Y] };
            m.conditions.push(Condition::Fix(guide));
            frequencies(&m, 1)[0].frequency_hz
        };
        let symmetry = Condition::Symmetry(SymmetryPlane { on: "u_max".into(), normal: [2.0, 0.0, 0.0] });
        for (name, f, exact) in [
            ("clamped", strip(length, vec![Condition::Clamp(on("u_min"))]), 3.516_015 / (2.0 * PI) * wave),
            (
                "hinged",
                strip(length, vec![Condition::Hinge(on("u_min")), Condition::Hinge(on("u_max"))]),
                PI / 2.0 * wave,
            ),
            ("mirrored", strip(0.5 * length, vec![Condition::Hinge(on("u_min")), symmetry]), PI / 2.0 * wave),
        ] {
            assert!((f - exact).abs() < 5e-3 * exact, "{element:?} {name}: {f} for {exact}");
        }
    }
}

/// A director turned by its support, all three components of it given in time, bends the strip to a circle and back.
#[test]
fn prescribed_rotations_of_unit_directors_bend_a_strip_to_a_circle() {
    for element in [ElementKind::Mitc4, ElementKind::Ems] {
        let mut m = model(plate([1.0, 0.1], [12, 1], 0.0), 1e6, 0.01);
        m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(1e6, 0.0, 1.0)));
        m.sections[0].element = element;
        let formula = |text: &str| Amplitude::Expression(ExpressionAmplitude { expression: text.into() });
        m.amplitudes.insert("sine".into(), formula("sin(t*PI/2)"));
        m.amplitudes.insert("cosine".into(), formula("cos(t*PI/2) - 1"));
        m.amplitudes.insert("none".into(), Amplitude::Constant(ConstantAmplitude { value: 0.0 }));
        for (component, name) in [(Axis::X, "sine"), (Axis::Y, "none"), (Axis::Z, "cosine")] {
            m.conditions.push(Condition::Prescribe(PrescribeComponent {
                on: "u_max".into(),
                of: NodalVector::Director,
                component,
                value: 1.0,
                amplitude: Some(name.into()),
            }));
        }
        m.analysis = Analysis::Static(StaticAnalysis { load_steps: 4, ..Default::default() });
        let (mesh, system, outcome) = common::solve(&m);
        let tip = common::displacement(&mesh, &system, &outcome.state.u, "u_max_v_min");
        let radius = 2.0 / PI;
        let exact = Vec3::new(radius - 1.0, 0.0, -radius);
        assert!((tip - exact).norm() < 3e-3, "{element:?}: {tip:?} for {exact:?}");
        let energy = 0.5 * 1e6 * 1e-6 / 12.0 * 0.1 / (radius * radius);
        assert!((outcome.balance.strain - energy).abs() < 5e-3 * energy, "{element:?}");
    }
}

/// An L of two sheets, its legs of any two elements, bends as one of `ems`.
#[test]
fn folds_join_all_elements() {
    let corner = |legs: [ElementKind; 2]| {
        let mesh = MeshSource::Extrusion(ExtrusionMesh {
            vertices: vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 0.0, 1.0]],
            sweep: [0.0, 0.3, 0.0],
            grid: Grid::uniform(6, 2),
        });
        let mut m = model(mesh, 1e6, 0.03);
        let mut mesh = tegula::mesh::generators::generate(&m.mesh).unwrap();
        let flat = |q: &[u32; 4]| q.iter().all(|&n| mesh.positions[n as usize].z.abs() < 1e-9);
        let (first, second): (Vec<u32>, Vec<u32>) =
            (0..mesh.quads.len() as u32).partition(|&q| flat(&mesh.quads[q as usize]));
        mesh.quad_sets.insert("first".into(), first);
        mesh.quad_sets.insert("second".into(), second);
        let part = |set: &str, element| Section { on: set.into(), element, ..m.sections[0].clone() };
        m.sections = vec![part("first", legs[0]), part("second", legs[1])];
        m.loads = vec![Load::Edge(vector_load("u_max", [2.0, 0.0, 0.0]))];
        let system = tegula::compile::build(&m, &mesh).unwrap();
        let outcome =
            statics::run(&system, &common::static_options(&m), None, &mut Notes::default()).unwrap();
        outcome.balance.strain
    };
    let alone = corner([ElementKind::Ems; 2]);
    for other in [ElementKind::Cm, ElementKind::SolidShell, ElementKind::Mitc4] {
        for legs in [[ElementKind::Ems, other], [other, ElementKind::Ems], [other, other]] {
            let energy = corner(legs);
            assert!((energy - alone).abs() < 2e-2 * alone, "{legs:?}: {energy} for {alone}");
        }
    }
}

/// A bar that has been pulled beyond yield vibrates along its axis with the elastic stiffness: a small motion unloads.
#[test]
fn vibrations_about_a_yielded_equilibrium_are_elastic() {
    for element in [ElementKind::Ems, ElementKind::Mitc4, ElementKind::Cm, ElementKind::SolidShell] {
        let bar = |material, pull: f64| {
            let mut m = model(plate([1.0, 0.2], [8, 2], 0.1), 1.0, 0.02);
            m.materials.insert("m".into(), material);
            m.sections[0].element = element;
            let guide = |set: &str, position| {
                Condition::Fix(FixComponents { on: set.into(), position, director: vec![] })
            };
            let clamp = guide("u_min", vec![Axis::X]);
            m.conditions = vec![clamp, guide("v_min", vec![Axis::Y]), guide("all", vec![Axis::Z])];
            m.loads = vec![Load::Edge(vector_load("u_max", [pull, 0.0, 0.0]))];
            m.analysis = Analysis::Modal(ModalAnalysis { prestressed: true, ..ModalAnalysis::new(3) });
            let (_, system) = compile(&m);
            let options = StaticAnalysis { load_steps: 3, ..Default::default() };
            let outcome = statics::run(&system, &options, None, &mut Silent).unwrap();
            let state = &outcome.state;
            (modal::run(&system, 3, Some(state), &mut Silent).unwrap().modes, state.dissipated)
        };
        let plastic = Plastic {
            young: 2e5,
            poisson: 0.3,
            yield_stress: 200.0,
            hardening: 2e4,
            saturation: None,
            saturation_rate: 0.0,
            kinematic: 0.0,
            density: 1.0,
            expansion: 0.0,
        };
        let (yielded, lost) = bar(Material::Plastic(plastic), 0.02 * 240.0);
        let (elastic, _) = bar(Material::Isotropic(Isotropic::new(2e5, 0.3, 1.0)), 0.02 * 240.0);
        assert!(lost > 0.0, "{element:?}: the bar must yield");
        for (a, b) in yielded.iter().zip(&elastic) {
            // The tenth of the stiffness that hardening leaves would give a third of the frequency.
            let (a, b) = (a.frequency_hz, b.frequency_hz);
            assert!((a - b).abs() < 1e-2 * b, "{element:?}: {a} for {b}");
        }
    }
}

/// Layers beside the mesh couple the inertia of inextensible directors with that of the positions: a swinging strip, whose motion
/// converges with the square of the step also then.
#[test]
fn layers_beside_the_mesh_swing_with_second_order() {
    let h = 0.01;
    let mut m = model(plate([0.5, 0.1], [8, 1], 0.0), 1e8, h);
    m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(1e8, 0.3, 1000.0)));
    let ply = LayupPly { material: Some("m".into()), angle: 0.0, thickness: Some(h) };
    let layup = Layup { plies: vec![ply], offset: 5.0 * h, ..Layup::default() };
    m.sections[0] = Section { element: ElementKind::Mitc4, layup: Some(layup), ..Section::new("", 0.0) };
    m.conditions = vec![Condition::Hinge(on("u_min"))];
    let formula = ExpressionAmplitude { expression: "sin(20*t)^2".into() };
    m.amplitudes.insert("smooth".into(), Amplitude::Expression(formula));
    m.loads = vec![Load::Gravity(GravityLoad { value: [0.0, 0.0, -10.0], amplitude: Some("smooth".into()) })];
    for scheme in [NEWMARK, HHT] {
        let end = |time_step: f64| run(&m, &options(scheme, 0.2, time_step), &mut Notes::default()).1.state.u;
        let [a, b, c] = [2e-3, 1e-3, 5e-4].map(end);
        let (first, second) = (distance(&a, &b), distance(&b, &c));
        assert!(first / second > 3.5, "{scheme:?}: {first:e}, then {second:e}");
    }
}
