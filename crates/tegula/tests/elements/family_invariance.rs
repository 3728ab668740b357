//! Properties of elements with every kind of material, layup and prescribed strain: independence of the numbering,
//! objectivity, forces and tangents as derivatives; masses and weights of uneven layups; what is warned of.

use crate::common;
use std::collections::BTreeMap;

use crate::common::{
    Random, compile, geometry, model, on, plate, ply, resultant, rotation, strains, vector_load,
};
use nalgebra::{DMatrix, DVector};
use tegula::analysis::statics;
use tegula::element::shell::{GroupSetup, Member};
use tegula::element::{
    ElementGroup, GroupPoint, InternalVariables, Motion, Nodal, ShellGeometry, TangentRequest,
    TangentWeights, registry,
};
use tegula::material::NeoHookeanForm;
use tegula::model::*;
use tegula::norm::{larger, max_norm};
use tegula::section::CompiledSection;
use tegula::system::{Assembly, VectorKind};
use tegula::{System, Vec3};

const H: f64 = 0.08;
const YOUNG: f64 = 1e3;

fn materials() -> BTreeMap<String, Material> {
    let isotropic = Material::Isotropic(Isotropic { expansion: 1e-3, ..Isotropic::new(YOUNG, 0.3, 2.0) });
    let rubber = Material::NeoHookean(NeoHookean {
        shear: 400.0,
        bulk: 4e3,
        density: 2.0,
        form: NeoHookeanForm::Split,
    });
    let metal = Material::Plastic(Plastic {
        young: YOUNG,
        poisson: 0.3,
        yield_stress: 8.0,
        hardening: 50.0,
        saturation: Some(12.0),
        saturation_rate: 10.0,
        kinematic: 30.0,
        density: 2.0,
        expansion: 1e-3,
    });
    let list = [("m", isotropic), ("ply", ply()), ("rubber", rubber), ("metal", metal)];
    BTreeMap::from(list.map(|(name, material)| (name.to_string(), material)))
}

fn layup(plies: &[(&str, f64, f64)]) -> Layup {
    let ply = |&(material, angle, part): &(&str, f64, f64)| LayupPly {
        material: Some(material.into()),
        angle,
        thickness: Some(part * H),
    };
    Layup { plies: plies.iter().map(ply).collect(), direction: [1.0, 0.3, 0.2], ..Layup::default() }
}

/// Sections of every element with what it can carry.
fn sections() -> Vec<Section> {
    let mut out = Vec::new();
    for &element in ElementKind::ALL {
        let solid = matches!(element, ElementKind::Cm | ElementKind::SolidShell);
        let mut add = |material: &str, plies: &[(&str, f64, f64)]| {
            let mut s = Section { element, ..Section::new(material, H) };
            if !plies.is_empty() {
                (s.material, s.thickness, s.layup) = (String::new(), 0.0, Some(layup(plies)));
            }
            out.push(s);
        };
        add("m", &[]);
        add("ply", &[]);
        if element != ElementKind::AncfFull {
            add("metal", &[]);
            add("", &[("m", 0.0, 0.5), ("ply", 30.0, 0.3), ("ply", -50.0, 0.2)]);
            add("", &[("metal", 0.0, 0.4), ("ply", 20.0, 0.6)]);
        }
        if solid {
            add("rubber", &[]);
            add("", &[("rubber", 0.0, 0.5), ("ply", 20.0, 0.5)]);
        }
    }
    out
}

struct Element {
    groups: Vec<Box<dyn ElementGroup>>,
    kinds: Vec<VectorKind>,
    reference: Vec<Nodal>,
    factors: Vec<f64>,
}

fn element(section: &Section, geometry: &ShellGeometry, fields: bool) -> Element {
    let compiled: CompiledSection = section.compile(&materials()).unwrap();
    let shell = registry::shell(section, H);
    let (mut kinds, mut reference) = (Vec::new(), Vec::<Nodal>::new());
    for (i, kind) in shell.nodal_vectors().iter().enumerate() {
        for a in 0..4 {
            kinds.push(*kind);
            reference.push(match kind {
                VectorKind::Position => geometry.positions[a].into(),
                VectorKind::Director => geometry.directors[a].into(),
                VectorKind::Gradient => geometry.tangents[a][i - 2].into(),
            });
        }
    }
    let plane = compiled.laws.is_empty() || shell.is_solid();
    // A prestress in resultants is not available for layers that yield: `check` refuses it.
    let strains: Vec<_> = strains().into_iter().take(if plane { 3 } else { 2 }).collect();
    let prescribed: Vec<_> = if fields { strains.iter().map(Some).collect() } else { Vec::new() };
    let vectors: Vec<u32> = (0..reference.len() as u32).collect();
    let setup = GroupSetup { laws: compiled.laws.clone(), fields: prescribed.len(), ..GroupSetup::default() };
    let mut builder = shell.builder(setup);
    let integration_points = compiled.integration_points(shell.as_ref(), geometry, &prescribed).unwrap();
    let mass = shell.mass(geometry, &compiled.inertia);
    builder.push(Member { vectors: &vectors, geometry, integration_points, mass }).unwrap();
    let factors = [0.9, 0.4, 0.7][..prescribed.len()].to_vec();
    Element { groups: builder.finish(), kinds, reference, factors }
}

impl Element {
    fn with<R>(&self, u: &[Nodal], g: &dyn ElementGroup, f: impl FnOnce(&GroupPoint) -> R) -> R {
        let history = vec![0.0; g.history_per_element()];
        f(&GroupPoint {
            reference: &self.reference,
            motion: Motion::State { u, velocity: None },
            linear: false,
            interior: InternalVariables { history: &history, factors: &self.factors },
            inextensible: &[],
        })
    }

    fn energy(&self, u: &[Nodal]) -> f64 {
        let one = |g: &dyn ElementGroup| {
            let mut e = [0.0];
            self.with(u, g, |k| g.energies(k, &mut e));
            // What is dissipated on the way belongs to the work of the forces.
            let mut history = vec![0.0; g.history_per_element()];
            e[0] + self.with(u, g, |k| g.update_history(k, &mut history))
        };
        self.groups.iter().map(|g| one(g.as_ref())).sum()
    }

    fn force(&self, u: &[Nodal]) -> DVector<f64> {
        let mut sum = DVector::zeros(3 * u.len());
        for g in &self.groups {
            let mut f = vec![0.0; 3 * u.len()];
            self.with(u, g.as_ref(), |k| g.evaluate(k, 0, &mut f, None));
            sum += DVector::from_vec(f);
        }
        sum
    }

    fn tangent(&self, u: &[Nodal]) -> DMatrix<f64> {
        let m = u.len();
        let mut k = DMatrix::zeros(3 * m, 3 * m);
        for g in &self.groups {
            let (mut f, mut blocks) = (vec![0.0; 3 * m], vec![0.0; 9 * m * (m + 1) / 2]);
            let weights = TangentWeights::STATIC;
            let request = TangentRequest { weights, stress: None, prescribed: None, blocks: &mut blocks };
            self.with(u, g.as_ref(), |k| g.evaluate(k, 0, &mut f, Some(request)));
            let mut block = blocks.chunks_exact(9);
            for a in 0..m {
                for b in 0..=a {
                    for (i, value) in block.next().unwrap().iter().enumerate() {
                        k[(3 * a + i / 3, 3 * b + i % 3)] += value;
                        if a != b {
                            k[(3 * b + i % 3, 3 * a + i / 3)] += value;
                        }
                    }
                }
            }
        }
        k
    }
}

fn displacement(count: usize, random: &mut Random) -> Vec<Nodal> {
    (0..count).map(|_| (random.vector() * 0.03).into()).collect()
}

fn cases() -> impl Iterator<Item = (Section, bool, Random)> {
    let all = sections().into_iter().flat_map(|s| [(s.clone(), false), (s, true)]);
    all.enumerate().map(|(i, (s, fields))| (s, fields, Random::new(700 + i as u64)))
}

fn name(s: &Section, fields: bool) -> String {
    format!("{:?} {} {:?} fields {fields}", s.element, s.material, s.layup.as_ref().map(|l| &l.plies))
}

#[test]
fn forces_are_derivatives_of_energies_and_tangents_those_of_forces() {
    for (section, fields, mut random) in cases() {
        let e = element(&section, &geometry(&mut random, [1.0, 1.0], 0.12), fields);
        let u = displacement(e.kinds.len(), &mut random);
        let (force, tangent) = (e.force(&u), e.tangent(&u));
        let label = name(&section, fields);
        assert!(force.iter().all(|f| f.is_finite()) && max_norm(&force) > 0.1, "{label}");
        for _ in 0..3 {
            let direction = displacement(e.kinds.len(), &mut random);
            let flat = DVector::from_column_slice(direction.as_flattened());
            let along = |t: f64| -> Vec<Nodal> {
                let add = |(u, d): (&Nodal, &Nodal)| std::array::from_fn(|i| u[i] + t * d[i]);
                u.iter().zip(&direction).map(add).collect()
            };
            let h = 2e-4;
            let points = [(-2.0, 1.0), (-1.0, -8.0), (1.0, 8.0), (2.0, -1.0)];
            let work: f64 = points.iter().map(|(t, c)| c * e.energy(&along(t * h)) / (12.0 * h)).sum();
            let exact = force.dot(&flat);
            let scale = force.component_mul(&flat).abs().sum();
            assert!((work - exact).abs() < 1e-7 * scale, "{label}: {work:e} for {exact:e}");
            let product = &tangent * &flat;
            let change: DVector<f64> =
                points.iter().map(|(t, c)| e.force(&along(t * h)) * (c / (12.0 * h))).sum();
            assert!(max_norm(&(&change - &product)) < 1e-6 * max_norm(&product), "{label}: tangent");
        }
    }
}

#[test]
fn rigid_motions_change_no_energy_and_turn_forces() {
    let q = rotation([0.3, -0.8, 0.5], 2.1);
    for (section, fields, mut random) in cases() {
        let e = element(&section, &geometry(&mut random, [1.0, 1.0], 0.12), fields);
        let u = displacement(e.kinds.len(), &mut random);
        let moved: Vec<Nodal> = (0..u.len())
            .map(|v| {
                let x0 = Vec3::from(e.reference[v]);
                let position = e.kinds[v] == VectorKind::Position;
                let shift = if position { Vec3::new(3.0, -1.0, 2.0) } else { Vec3::zeros() };
                (q * (x0 + Vec3::from(u[v])) + shift - x0).into()
            })
            .collect();
        let label = name(&section, fields);
        let (a, b) = (e.energy(&u), e.energy(&moved));
        let (f, turned) = (e.force(&u), e.force(&moved));
        assert!((a - b).abs() < 1e-9 * max_norm(&f) * 0.03, "{label}: {a} {b}");
        for v in 0..u.len() {
            let at = |list: &DVector<f64>| Vec3::new(list[3 * v], list[3 * v + 1], list[3 * v + 2]);
            assert!((at(&turned) - q * at(&f)).norm() < 1e-10 * max_norm(&f), "{label}");
        }
    }
}

#[test]
fn numbering_of_corners_does_not_matter() {
    for (section, fields, mut random) in cases() {
        let g = geometry(&mut random, [1.0, 1.0], 0.12);
        let e = element(&section, &g, fields);
        let u = displacement(e.kinds.len(), &mut random);
        let (energy, force) = (e.energy(&u), e.force(&u));
        let label = name(&section, fields);
        for order in [[1, 2, 3, 0], [2, 3, 0, 1], [3, 0, 1, 2], [0, 3, 2, 1], [2, 1, 0, 3]] {
            let turned = ShellGeometry::new(order.map(|a| g.positions[a]), order.map(|a| g.directors[a]));
            let other = element(&section, &turned, fields);
            let place = |v: usize| 4 * (v / 4) + order[v % 4];
            let u2: Vec<Nodal> = (0..u.len()).map(|v| u[place(v)]).collect();
            let (energy2, force2) = (other.energy(&u2), other.force(&u2));
            assert!(
                (energy - energy2).abs() < 1e-9 * max_norm(&force) * 0.03,
                "{label} {order:?}: {energy} {energy2}"
            );
            for v in 0..u.len() {
                for i in 0..3 {
                    let (a, b) = (force[3 * place(v) + i], force2[3 * v + i]);
                    assert!((a - b).abs() < 1e-9 * max_norm(&force), "{label} {order:?}: {a} {b}");
                }
            }
        }
    }
}

/// Rubber and fibre, heavy and light: the first moment of the mass does not vanish.
fn uneven_plate(element: ElementKind) -> Model {
    let mut m = model(plate([1.2, 0.7], [3, 2], 0.2), YOUNG, H);
    m.materials = materials();
    m.sections[0].element = element;
    if element != ElementKind::AncfFull {
        m.sections[0] = Section { element, ..Section::new("", 0.0) };
        m.sections[0].layup = Some(layup(&[("m", 0.0, 0.5), ("ply", 30.0, 0.3), ("ply", -50.0, 0.2)]));
    }
    m.loads = vec![Load::Gravity(GravityLoad { value: [0.4, -0.3, -1.0], amplitude: None })];
    m
}

#[test]
fn uneven_layups_have_their_weight_and_its_moment_and_reactions_balance_it() {
    for &element in ElementKind::ALL {
        let m = uneven_plate(element);
        let (_, system) = compile(&m);
        let area = 1.2 * 0.7;
        let (mass, first) = if element == ElementKind::AncfFull {
            (2.0 * H, 0.0)
        } else {
            // ∫ρ dz and ∫ρ z dz: 2.0 over the lower half, 0.7 over the upper.
            ((0.5 * 2.0 + 0.5 * 0.7) * H, (0.7 - 2.0) * H * H / 8.0)
        };
        let total = mass * area;
        assert!((system.total_mass() - total).abs() < 1e-12 * total, "{element:?}");
        let g = Vec3::new(0.4, -0.3, -1.0);
        let still = vec![[0.0; 3]; system.vectors()];
        let mut weight = still.clone();
        system.add_dead_loads(1.0, 1.0, &mut weight);
        let (force, moment) = resultant(&system, &still, &weight);
        let centre = Vec3::new(0.6, 0.35, first / mass);
        assert!((force - g * total).norm() < 1e-12 * total, "{element:?}: {force:?}");
        let exact = centre.cross(&g) * total;
        assert!((moment - exact).norm() < 1e-11 * exact.norm(), "{element:?}: {moment:?} for {exact:?}");

        let outcome = statics::run(&system, &common::static_options(&m), None, &mut common::Notes::default());
        let state = outcome.unwrap().state;
        let mut assembly = Assembly::new(&system);
        let reactions = statics::reactions(&system, &mut assembly, &state);
        assert!(!system.linear);
        let held = resultant(&system, &state.u, &reactions);
        let loads = resultant(&system, &state.u, &weight);
        assert!((held.0 + loads.0).norm() < 1e-9 * loads.0.norm(), "{element:?}: {held:?} {loads:?}");
        assert!((held.1 + loads.1).norm() < 1e-9 * loads.1.norm(), "{element:?}: {held:?} {loads:?}");
    }
}

fn warned(m: &Model) -> Vec<String> {
    let (mesh, system) = compile(m);
    tegula::compile::warnings(m, &mesh, &system).iter().map(|i| i.place.key.clone()).collect()
}

#[test]
fn keys_without_effect_are_warned_of() {
    let base = |element| {
        let mut m = model(plate([1.0, 0.5], [2, 1], 0.0), YOUNG, 0.01);
        m.sections[0].element = element;
        m.loads = vec![Load::Edge(vector_load("u_max", [0.0, 0.0, 1.0]))];
        m
    };
    let mut m = base(ElementKind::Mitc4);
    m.sections[0].ans_thickness = false;
    m.sections[0].thickness_points = Some(4);
    m.sections[0].thickness_eas = 3;
    m.sections[0].shear_stabilization = 0.1;
    let all = ["sections[0].ans_thickness", "sections[0].thickness_eas", "sections[0].thickness_points"];
    assert_eq!(warned(&m), all);
    m.sections[0].element = ElementKind::Cm;
    assert_eq!(warned(&m), ["sections[0].shear_stabilization"]);
    m.sections[0].shear_stabilization = 0.0;
    assert!(warned(&m).is_empty());
    let mut m = base(ElementKind::AncfFull);
    (m.sections[0].ans_shear, m.sections[0].eas) = (false, false);
    assert_eq!(warned(&m), ["sections[0].ans_shear", "sections[0].eas"]);
    // The thickness of a layup is that of its plies.
    let mut m = base(ElementKind::Ems);
    m.sections[0] = Section::new("", 0.0);
    m.sections[0].layup = Some(Layup {
        stacking: Some("[0/0]".into()),
        material: Some("m".into()),
        ply_thickness: Some(9.0),
        ..Layup::default()
    });
    assert_eq!(warned(&m), ["sections[0].thickness"]);
}

#[test]
fn motions_that_begin_with_a_jump_are_warned_of() {
    let warned = |amplitude: Option<&str>, analysis: Analysis| {
        let mut m = model(plate([1.0, 0.5], [2, 1], 0.0), YOUNG, 0.01);
        for name in ["1 - t", "sin(t)"] {
            let formula = ExpressionAmplitude { expression: name.into() };
            m.amplitudes.insert(name.into(), Amplitude::Expression(formula));
        }
        m.conditions.push(Condition::Prescribe(PrescribeComponent {
            on: "u_max".into(),
            of: NodalVector::Position,
            component: Axis::Z,
            value: 0.01,
            amplitude: amplitude.map(str::to_owned),
        }));
        m.analysis = analysis;
        warned(&m)
    };
    let transient = || Analysis::Transient(TransientAnalysis::new(0.1));
    assert_eq!(warned(None, transient()), ["conditions[1]"]);
    assert_eq!(warned(Some("1 - t"), transient()), ["conditions[1]"]);
    assert!(warned(Some("sin(t)"), transient()).is_empty());
    assert!(warned(None, Analysis::Static(StaticAnalysis::default())).is_empty());
}

#[test]
fn modal_analyses_know_prescribed_strains_as_loads() {
    for (prestressed, expected) in [(true, vec![]), (false, vec!["prescribed_strains[0]".to_string()])] {
        let mut m = model(plate([1.0, 0.5], [2, 1], 0.0), YOUNG, 0.01);
        m.prescribed_strains = vec![strains()[2].clone()];
        m.analysis = Analysis::Modal(ModalAnalysis { modes: 2, prestressed });
        assert_eq!(warned(&m), expected);
    }
}

fn refused(m: &Model) -> Vec<(String, String)> {
    let mesh = tegula::mesh::generators::generate(&m.mesh).unwrap();
    match tegula::compile::build(m, &mesh) {
        Err(tegula::Error::Model(list)) => {
            list.iter().map(|i| (i.place.key.clone(), i.message.clone())).collect()
        }
        Ok(_) => Vec::new(),
        Err(e) => panic!("{e}"),
    }
}

#[test]
fn layups_are_refused_for_one_reason_only() {
    let with = |layup| {
        let mut m = model(plate([1.0, 0.5], [2, 1], 0.0), YOUNG, 0.01);
        m.materials = materials();
        m.sections[0] = Section { element: ElementKind::Mitc4, ..Section::new("", 0.0) };
        m.sections[0].layup = Some(layup);
        m.loads = vec![Load::Edge(vector_load("u_max", [0.0, 0.0, 1.0]))];
        m
    };
    let found = refused(&with(layup(&[("m", 0.0, 0.5), ("rubber", 0.0, 0.5)])));
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].1.contains("plane stress"), "{found:?}");
    for direction in [[0.0; 3], [1e-200, 0.0, 0.0]] {
        let found = refused(&with(Layup { direction, ..layup(&[("m", 0.0, 1.0)]) }));
        let keys: Vec<_> = found.iter().map(|f| f.0.as_str()).collect();
        assert_eq!(keys, ["sections[0].layup.direction"], "{found:?}");
    }
}

/// Nearly incompressible rubber bends like the incompressible plate, and a clamped sheet blown up does not depend on
/// the last digits of the bulk modulus.
#[test]
fn nearly_incompressible_rubber_does_not_lock() {
    for element in [ElementKind::Cm, ElementKind::SolidShell] {
        let bent = |bulk: f64| {
            let mut m = model(plate([1.0, 0.2], [8, 2], 0.15), 1.0, 0.01);
            let law = NeoHookean { shear: 1.0, bulk, density: 0.0, form: NeoHookeanForm::Split };
            m.materials.insert("m".into(), Material::NeoHookean(law));
            m.sections[0].element = element;
            m.loads = vec![Load::Edge(vector_load("u_max", [0.0, 0.0, 1e-9]))];
            let (mesh, system, outcome) = common::solve(&m);
            common::displacement(&mesh, &system, &outcome.state.u, "u_max_v_min").z
        };
        // Between the wide strip, D = E h³/12/(1 − ν²), and the narrow one.
        let (e, h) = (3.0, 0.01_f64);
        let narrow = 1e-9 / (3.0 * e * h.powi(3) / 12.0);
        for bulk in [1e3, 1e4] {
            let z = bent(bulk);
            println!("{element:?} {bulk}: {z} of {narrow}");
            assert!((0.75 * narrow..1.01 * narrow).contains(&z), "{element:?} {bulk}: {z} of {narrow}");
        }
        let blown = |bulk: f64| {
            let mut m = model(plate([1.0, 1.0], [6, 6], 0.0), 1.0, 0.02);
            let law = NeoHookean { shear: 1.0, bulk, density: 0.0, form: NeoHookeanForm::Split };
            m.materials.insert("m".into(), Material::NeoHookean(law));
            m.sections[0].element = element;
            m.conditions = ["u_min", "u_max", "v_min", "v_max"].map(|set| Condition::Hinge(on(set))).into();
            m.loads = vec![Load::Pressure(PressureLoad { on: "all".into(), value: -0.03, amplitude: None })];
            m.analysis = Analysis::Static(StaticAnalysis { load_steps: 4, ..Default::default() });
            let (_, _, outcome) = common::solve(&m);
            outcome.state.u.iter().map(|u| u[2]).reduce(larger).unwrap()
        };
        let (soft, hard) = (blown(1e2), blown(1e4));
        println!("{element:?}: {soft} {hard}");
        assert!(soft > 0.1 && (hard - soft).abs() < 2e-2 * soft, "{element:?}: {hard} for {soft}");
    }
}

/// Pulled, pushed back and pulled again: the force follows the law of the point, whose yield point in compression
/// comes early by the back stress.
#[test]
fn metal_strips_remember_where_they_were_pulled() {
    let (e, y, k) = (2e5, 200.0, 2e4);
    for element in [ElementKind::Ems, ElementKind::Mitc4, ElementKind::Cm, ElementKind::SolidShell] {
        let mut m = model(plate([1.0, 0.5], [2, 1], 0.2), e, 0.1);
        let law = Plastic {
            young: e,
            poisson: 0.3,
            yield_stress: y,
            hardening: 0.0,
            saturation: None,
            saturation_rate: 0.0,
            kinematic: k,
            density: 0.0,
            expansion: 0.0,
        };
        m.materials.insert("m".into(), Material::Plastic(law));
        m.sections[0].element = element;
        let plane = |set: &str, normal| Condition::Symmetry(SymmetryPlane { on: set.into(), normal });
        let flat = FixComponents { on: "all".into(), position: vec![Axis::Z], director: vec![] };
        m.conditions =
            vec![plane("u_min", [1.0, 0.0, 0.0]), plane("v_min", [0.0, 1.0, 0.0]), Condition::Fix(flat)];
        let path = [0.0, 0.004, 0.002, 0.0005, 0.003, 0.005];
        let stretch = |strain: f64| (1.0 + 2.0 * strain).sqrt() - 1.0;
        let times: Vec<f64> = (0..path.len()).map(|i| i as f64 / 5.0).collect();
        let values = path.map(stretch).to_vec();
        m.amplitudes.insert("cycle".into(), Amplitude::Table(TableAmplitude { times, values }));
        m.conditions.push(Condition::Prescribe(PrescribeComponent {
            on: "u_max".into(),
            of: NodalVector::Position,
            component: Axis::X,
            value: 1.0,
            amplitude: Some("cycle".into()),
        }));
        m.analysis = Analysis::Static(StaticAnalysis { load_steps: 5, ..Default::default() });
        let (mesh, system) = compile(&m);
        let mut notes = common::Notes::keeping();
        statics::run(&system, &common::static_options(&m), None, &mut notes).unwrap();
        // The law of a bar: σ = E (ε − p), |σ − K p| ≤ y.
        let mut p = 0.0_f64;
        for (state, strain) in notes.states.iter().zip(&path[1..]) {
            let trial = e * (strain - p) - k * p;
            if trial.abs() > y {
                p += (trial.abs() - y) / (e + k) * trial.signum();
            }
            let exact = e * (strain - p) * 0.05 * (1.0 + 2.0 * strain).sqrt();
            let force = pull(&system, &mesh, state);
            assert!((force - exact).abs() < 1e-6 * y * 0.05, "{element:?} at {strain}: {force} for {exact}");
        }
        assert!(p != 0.0);
    }
}

fn pull(system: &System, mesh: &tegula::Mesh, state: &tegula::analysis::State) -> f64 {
    let mut assembly = Assembly::new(system);
    let reactions = statics::reactions(system, &mut assembly, state);
    let nodes = mesh.nodes_on("u_max").unwrap();
    nodes.iter().map(|&n| reactions[system.coordinates.position_of[n as usize] as usize][0]).sum()
}
