//! Section forces and moments of cuts against closed forms, reactions and the inertia of the part beyond the cut.

use crate::common::*;
use crate::patches::{gravity, hub, strip};
use tegula::analysis::{Observer, State, Step, dynamics, statics};
use tegula::compile::{build, warnings};
use tegula::element::Nodal;
use tegula::mesh::generators::generate;
use tegula::model::*;
use tegula::norm::{larger, max_norm};
use tegula::result::{CutResultant, Equilibrium, ReactionFinder};
use tegula::system::VectorKind;
use tegula::{Error, Mesh, System, Vec3};

/// Cut of the name `name` on the line `on`, through which a force acts on the part `of`.
fn cut(name: &str, on: &str, of: &str) -> Cut {
    Cut { name: name.into(), on: on.into(), of: of.into(), about: None }
}

/// Mesh of a model with the line where `height` is 0 and the parts `above` and `below` it.
fn divided(m: &Model, height: impl Fn(&Vec3) -> f64) -> Mesh {
    let mut mesh = generate(&m.mesh).unwrap();
    let h: Vec<f64> = mesh.positions.iter().map(height).collect();
    let on_line = |n: &u32| h[*n as usize].abs() < 1e-9;
    mesh.node_sets.insert("line".into(), (0..h.len() as u32).filter(on_line).collect());
    for (name, sign) in [("above", 1.0), ("below", -1.0)] {
        let part = |q: &u32| mesh.quads[*q as usize].iter().all(|n| sign * h[*n as usize] > -1e-9);
        let quads: Vec<u32> = (0..mesh.quads.len() as u32).filter(part).collect();
        mesh.quad_sets.insert(name.into(), quads);
    }
    let halves: usize = ["above", "below"].iter().map(|name| mesh.quad_sets[*name].len()).sum();
    assert_eq!(halves, mesh.quads.len());
    mesh
}

/// Finds the forces of every step.
struct Recorder<'a> {
    system: &'a System,
    finder: ReactionFinder,
    last: Option<State>,
    found: Vec<(State, Equilibrium)>,
}

impl<'a> Recorder<'a> {
    fn new(system: &'a System, scheme: Option<Scheme>) -> Self {
        Self { system, finder: ReactionFinder::new(system, scheme), last: None, found: Vec::new() }
    }
}

impl Observer for Recorder<'_> {
    fn on_step(&mut self, step: &Step) -> tegula::Result<()> {
        let forces = self.finder.find(self.system, self.last.as_ref(), step.state);
        self.found.push((step.state.clone(), forces));
        self.last = Some(step.state.clone());
        Ok(())
    }
}

fn equilibrium(m: &Model, mesh: &Mesh) -> (System, State, Equilibrium) {
    let system = build(m, mesh).unwrap();
    let outcome = statics::run(&system, &static_options(m), None, &mut Notes::default()).unwrap();
    let forces = ReactionFinder::new(&system, None).find(&system, None, &outcome.state);
    (system, outcome.state, forces)
}

fn close(found: &Vec3, expected: &Vec3, scale: f64, what: &str) {
    let error = (found - expected).norm() / scale;
    assert!(error <= 1e-8, "{what}: {found:?} for {expected:?}, {error:e}");
}

/// Moment of a resultant about another point.
fn moment(of: &CutResultant, about: &Vec3) -> Vec3 {
    of.resultant.moment + (of.about - about).cross(&of.resultant.force)
}

fn statics_of(linear: bool) -> Analysis {
    Analysis::Static(StaticAnalysis { linear, ..StaticAnalysis::default() })
}

/// The load at the tip of a cantilever acts on the inner part in its middle, with the present arm; the outer part has the opposite, and
/// the clamp the reaction.
#[test]
fn sections_of_a_cantilever_carry_the_load_at_its_tip() {
    let load = Vec3::new(3.0, 1.0, -0.6);
    for element in ElementKind::ALL.iter().copied() {
        for linear in [true, false] {
            let mut m = model(plate([2.0, 0.5], [8, 2], 0.0), 1e6, 0.05);
            m.sections[0].element = element;
            m.analysis = statics_of(linear);
            m.loads =
                vec![Load::Edge(vector_load("u_max", (load / 0.5 * if linear { 1.0 } else { 10.0 }).into()))];
            let load = if linear { load } else { load * 10.0 };
            m.output.cuts = vec![
                cut("inner", "line", "below"),
                cut("outer", "line", "above"),
                Cut { about: Some([0.3, -0.2, 0.1]), ..cut("about", "line", "below") },
                cut("clamp", "u_min", "all"),
            ];
            let mesh = divided(&m, |x| x.x - 1.0);
            let (system, state, forces) = equilibrium(&m, &mesh);
            let [inner, outer, about, clamp] = forces.cuts[..] else { panic!("{:?}", forces.cuts) };
            let (force, size) = (load.norm(), 2.0 * load.norm());
            let mean = |set: &str| -> Vec3 {
                let nodes = mesh.nodes_on(set).unwrap();
                let at = |n: &u32| {
                    let v = system.coordinates.position_of[*n as usize] as usize;
                    let moved = if linear { Vec3::zeros() } else { Vec3::from(state.u[v]) };
                    mesh.positions[*n as usize] + moved
                };
                nodes.iter().map(at).sum::<Vec3>() / nodes.len() as f64
            };
            assert!((inner.about - mean("line")).norm() < 1e-12);
            if linear {
                close(&inner.resultant.moment, &Vec3::x().cross(&load), size, "closed form");
            } else {
                let tip = mean("u_max") - Vec3::new(2.0, 0.25, 0.0);
                assert!(tip.norm() > 0.3, "{element:?}: {tip}");
            }
            let about_line = forces.loads[0].moment + (system.load_sets[0].about - inner.about).cross(&load);
            close(&inner.resultant.force, &load, force, "inner force");
            close(&inner.resultant.moment, &about_line, size, "inner moment");
            close(&outer.resultant.force, &-load, force, "outer force");
            close(&outer.resultant.moment, &-about_line, size, "outer moment");
            assert_eq!(about.about, Vec3::new(0.3, -0.2, 0.1));
            close(&about.resultant.moment, &moment(&inner, &about.about), size, "moment about a point");
            let support = forces.supports[0];
            close(&clamp.resultant.force, &support.force, force, "clamp force");
            let about_support = moment(&clamp, &system.support_sets[0].about);
            close(&about_support, &support.moment, size, "clamp moment");
        }
    }
}

/// Pressure on the upright sheet of an angle: the fold carries p b (H − h/2) — the nodes of the fold take the pressure on half a row of
/// elements of the height h — and p b H²/2 about the fold. The clamp carries all of it.
#[test]
fn the_fold_of_an_angle_carries_the_pressure_on_its_upright_sheet() {
    let (height, width, rows) = (0.4, 0.3, 4);
    for element in ElementKind::ALL.iter().copied() {
        let mesh = MeshSource::Extrusion(ExtrusionMesh {
            vertices: vec![[0.0, 0.0, 0.0], [0.6, 0.0, 0.0], [0.6, 0.0, height]],
            sweep: [0.0, width, 0.0],
            grid: Grid::uniform(10, 3),
        });
        let mut m = Model::new(mesh, statics_of(true), Isotropic::new(1e6, 0.3, 1.0), 0.01);
        m.sections[0].element = element;
        m.conditions = vec![Condition::Clamp(on("u_min"))];
        m.loads = vec![Load::Pressure(PressureLoad {
            on: "above".into(),
            value: 3.0,
            amplitude: None,
            distribution: None,
        })];
        m.output.cuts = vec![cut("fold", "line", "above"), cut("clamp", "u_min", "below")];
        // The upright sheet is above the fold, and the fold lies at the right end of the flat one.
        let mesh = divided(&m, |x| if x.z > 1e-9 { x.z } else { x.x - 0.6 });
        let row = height / f64::from(rows);
        assert_eq!(mesh.quad_sets["above"].len(), 3 * rows as usize);
        let (system, _, forces) = equilibrium(&m, &mesh);
        let all = forces.loads[0].force;
        assert!(
            (all.norm() / (3.0 * width * height) - 1.0).abs() < 1e-12 && all.x.abs() > 0.999 * all.norm()
        );
        let [fold, clamp] = forces.cuts[..] else { panic!("{:?}", forces.cuts) };
        let (force, size) = (all.norm(), all.norm() * height);
        close(&fold.about, &Vec3::new(0.6, 0.5 * width, 0.0), 1.0, "mean of the fold");
        close(&fold.resultant.force, &(-all * (1.0 - 0.5 * row / height)), force, "force");
        let arm = Vec3::new(0.0, 0.0, 0.5 * height);
        close(&fold.resultant.moment, &-arm.cross(&all), size, "moment");
        close(&clamp.resultant.force, &-all, force, "clamp");
        let about = Vec3::new(0.6, 0.5 * width, 0.0);
        close(&moment(&clamp, &about), &-arm.cross(&all), size, "clamp moment");
        assert_eq!(system.cuts[0].positions.len(), 4);
    }
}

/// A cut across both sheets of an angle carries force and moment of the loads beyond it, for large displacements.
#[test]
fn a_cut_across_a_fold_carries_the_loads_beyond_it() {
    for element in ElementKind::ALL.iter().copied() {
        let mesh = MeshSource::Extrusion(ExtrusionMesh {
            vertices: vec![[0.0, 0.0, 0.0], [0.2, 0.0, 0.0], [0.2, 0.0, 0.2]],
            sweep: [0.0, 1.0, 0.0],
            grid: Grid::uniform(4, 8),
        });
        let mut m = Model::new(mesh, statics_of(false), Isotropic::new(1e6, 0.3, 1.0), 0.01);
        m.sections[0].element = element;
        m.conditions = vec![Condition::Clamp(on("v_min"))];
        m.loads = vec![Load::Edge(vector_load("v_max", [2.0, 3.0, -1.0]))];
        m.output.cuts = vec![cut("middle", "line", "below")];
        let mesh = divided(&m, |x| x.y - 0.5);
        let (system, state, forces) = equilibrium(&m, &mesh);
        let tip = max_norm(state.u.iter().map(|u| Vec3::from(*u).norm()));
        assert!(tip > 0.05, "{element:?}: {tip}");
        let load = forces.loads[0];
        let (force, found) = (load.force.norm(), forces.cuts[0]);
        close(&found.resultant.force, &load.force, force, "force");
        let about_line = load.moment + (system.load_sets[0].about - found.about).cross(&load.force);
        close(&found.resultant.moment, &about_line, force, "moment");
    }
}

/// A moment on a rigid patch passes a cut in the middle and the line of the patch, bent into a circle.
#[test]
fn a_moment_on_a_patch_passes_all_cuts() {
    for element in ElementKind::ALL.iter().copied() {
        let mut m = strip(element, [8, 2], 0.0);
        m.conditions = vec![Condition::Clamp(on("u_min"))];
        m.bodies = vec![hub("tip", [1.0, 0.1, 0.0], &["u_max"])];
        let applied = Vec3::new(0.0, -0.2, 0.0);
        m.loads = vec![Load::Moment(vector_load("tip", applied.into()))];
        m.output.cuts = vec![cut("middle", "line", "below"), cut("patch", "u_max", "all")];
        let mesh = divided(&m, |x| x.x - 0.5);
        let (_, state, forces) = equilibrium(&m, &mesh);
        assert!(max_norm(state.u.iter().map(|u| u[2])) > 0.2);
        for found in &forces.cuts {
            close(&found.resultant.moment, &applied, 0.2, "moment");
            close(&found.resultant.force, &Vec3::zeros(), 0.2, "force");
        }
    }
}

/// Force and moment about the origin that the part beyond a cut needs: inertia less loads at its nodes but those of the line.
fn needed(mesh: &Mesh, system: &System, [u, unbalanced]: [&[Nodal]; 2]) -> (Vec3, Vec3) {
    let line = mesh.nodes_on("line").unwrap();
    let part = mesh.nodes_on("above").unwrap();
    let (mut force, mut moment) = (Vec3::zeros(), Vec3::zeros());
    for (v, f) in unbalanced.iter().enumerate() {
        let node = system.coordinates.nodes[v];
        if !part.contains(&node) || line.contains(&node) {
            continue;
        }
        let f = Vec3::from(*f);
        if system.coordinates.kinds[v] == VectorKind::Position {
            force += f;
        }
        moment += (Vec3::from(system.coordinates.reference[v]) + Vec3::from(u[v])).cross(&f);
    }
    (force, moment)
}

/// A strip swings from its clamp: the force at a cut gives the part beyond it its acceleration, in every scheme, and acts where the
/// equation of the scheme holds.
#[test]
fn the_force_at_a_cut_accelerates_the_part_beyond_it() {
    let schemes = [
        Scheme::Newmark(NewmarkScheme { beta: 0.25, gamma: 0.5 }),
        Scheme::Hht(HhtScheme { alpha: -0.1 }),
        Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 }),
        Scheme::Explicit(ExplicitScheme { scale_director_inertia: true }),
    ];
    let pairs = schemes.into_iter().flat_map(|s| [(s, ElementKind::Ems), (s, ElementKind::Mitc4)]);
    // Explicit steps take no inextensible directors.
    for (scheme, element) in pairs.filter(|(s, e)| !s.is_explicit() || *e == ElementKind::Ems) {
        let mut m = model(plate([1.0, 0.2], [6, 2], 0.0), 1e6, 0.02);
        m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(1e6, 0.3, 1e3)));
        m.sections[0].element = element;
        let weight = Vec3::new(1.0, 2.0, -9.81);
        m.loads = vec![gravity(weight.into())];
        m.output.cuts = vec![Cut { about: Some([0.0; 3]), ..cut("middle", "line", "above") }];
        let options = TransientAnalysis { scheme, max_step: Some(2e-3), ..TransientAnalysis::new(0.2) };
        m.analysis = Analysis::Transient(options.clone());
        let mesh = divided(&m, |x| x.x - 0.5);
        let system = build(&m, &mesh).unwrap();
        let mut recorder = Recorder::new(&system, Some(scheme));
        dynamics::run(&system, &options, None, &mut recorder).unwrap();
        let (mut moved, mut steps, mut scale) = (0.0, 0, 0.0);
        for pair in recorder.found.windows(2) {
            let [(old, _), (new, forces)] = pair else { panic!() };
            // Instant of the forces, as a part of the step before its end.
            let part = match scheme {
                Scheme::Hht(_) => 0.1,
                Scheme::EnergyMomentum(_) => 0.5,
                _ => 0.0,
            };
            let between = |old: &[Nodal], new: &[Nodal]| -> Vec<Nodal> {
                let mean =
                    |(a, b): (&Nodal, &Nodal)| std::array::from_fn(|i| part * a[i] + (1.0 - part) * b[i]);
                old.iter().zip(new).map(mean).collect()
            };
            let u = between(&old.u, &new.u);
            let mut unbalanced = vec![[0.0; 3]; u.len()];
            system.pattern.add_mass_product(1.0, &new.a, &mut unbalanced);
            for load in &system.dead_loads {
                let pairs = unbalanced.as_flattened_mut().iter_mut().zip(load.force.as_flattened());
                pairs.for_each(|(sum, load)| *sum -= load);
            }
            let (force, moment) = needed(&mesh, &system, [&u, &unbalanced]);
            let found = forces.cuts[0].resultant;
            scale = larger(scale, force.norm());
            let errors = [(found.force - force).norm() / scale, (found.moment - moment).norm() / scale];
            // Newton's method ends at the tolerance of its steps; the moments of HHT are those of forces on two configurations.
            let tolerance = match scheme {
                Scheme::Newmark(_) => 1e-5,
                Scheme::Hht(_) => 1e-4,
                _ => 1e-8,
            };
            assert!(errors[0] < tolerance, "{scheme:?} {element:?} {}: {errors:?}", new.time);
            assert!(errors[1] < tolerance, "{scheme:?} {element:?} {}: {errors:?}", new.time);
            moved = max_norm(u.iter().map(|u| u[2]));
            steps += 1;
        }
        assert!(steps >= 10 && moved > 0.05, "{scheme:?}: {steps} {moved}");
        assert!(scale > 1.0, "{scale}");
    }
}

/// A strip of Kelvin–Voigt material spins freely about its centre: at the distance c it carries ω² ∫ρ A x dx over the part beyond, less the
/// share of the first element at the nodes of the line, ρ A (c h/2 + h²/6) with linear interpolation, 3 h²/20 with cubic one.
#[test]
fn a_spinning_strip_carries_the_centrifugal_force() {
    let (spin, rho, area) = (1.0_f64, 1.0, 0.2 * 0.05);
    for element in ElementKind::ALL.iter().copied() {
        let mut m = model(plate([2.0, 0.2], [8, 2], 0.0), 1e6, 0.05);
        m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(1e6, 0.0, rho)));
        m.sections[0].element = element;
        m.sections[0].retardation_time = 1e-3;
        m.conditions = Vec::new();
        m.initial_velocities = vec![InitialVelocity {
            on: "all".into(),
            velocity: [0.0; 3],
            angular_velocity: [0.0, 0.0, spin],
            center: [1.0, 0.1, 0.0],
        }];
        m.output.cuts = vec![cut("cut", "line", "above")];
        let scheme = Scheme::Newmark(NewmarkScheme { beta: 0.25, gamma: 0.5 });
        let options = TransientAnalysis { scheme, time_step: Some(5e-4), ..TransientAnalysis::new(0.05) };
        m.analysis = Analysis::Transient(options.clone());
        let (c, h) = (0.25, 0.25);
        let mesh = divided(&m, |x| x.x - 1.0 - c);
        let system = build(&m, &mesh).unwrap();
        let mut recorder = Recorder::new(&system, Some(scheme));
        dynamics::run(&system, &options, None, &mut recorder).unwrap();
        let (state, forces) = recorder.found.last().unwrap();
        let first_moment = if element == ElementKind::AncfFull { 3.0 / 20.0 } else { 1.0 / 6.0 };
        let beyond = 0.5 * (1.0 - c * c) - (0.5 * c * h + first_moment * h * h);
        let angle = spin * state.time;
        let inwards = -Vec3::new(angle.cos(), angle.sin(), 0.0);
        let expected = inwards * (rho * area * spin * spin * beyond);
        let found = forces.cuts[0].resultant;
        let error = (found.force - expected).norm() / expected.norm();
        assert!(error < 1e-4, "{element:?}: {:?} for {expected:?}, {error:e}", found.force);
        assert!(found.moment.norm() < 1e-4 * expected.norm(), "{element:?}: {:?}", found.moment);
    }
}

/// Cuts that name no line, no part, or a rigid one are refused at their keys.
#[test]
fn cuts_without_a_meaning_are_refused() {
    let mut m = strip(ElementKind::Ems, [4, 2], 0.0);
    m.conditions = vec![Condition::Clamp(on("u_min"))];
    m.loads = vec![gravity([0.0, 0.0, -9.81])];
    m.output.cuts = vec![cut("root", "line", "below")];
    let mesh = divided(&m, |x| x.x - 0.5);
    build(&m, &mesh).unwrap();
    let refused = |change: &dyn Fn(&mut Model), key: &str, word: &str| {
        let mut changed = m.clone();
        change(&mut changed);
        let mut mesh = mesh.clone();
        let first = mesh.quads[mesh.quad_sets["below"][0] as usize];
        mesh.node_sets.insert("block".into(), first.to_vec());
        let Err(Error::Model(issues)) = build(&changed, &mesh) else { panic!("{key} {word} is taken") };
        let found = issues.iter().any(|issue| issue.place.key == key && issue.message.contains(word));
        assert!(found, "{key} {word}: {issues:?}");
    };
    refused(&|m| m.output.cuts[0].on = "lime".into(), "output.cuts[0].on", "lime");
    refused(&|m| m.output.cuts[0].on = "above".into(), "output.cuts[0].on", "above");
    refused(&|m| m.output.cuts[0].on = "block".into(), "output.cuts[0].on", "holds all nodes of element");
    refused(&|m| m.output.cuts[0].of = "line".into(), "output.cuts[0].of", "line");
    refused(&|m| m.output.cuts[0].of = "upper".into(), "output.cuts[0].of", "upper");
    refused(
        &|m| m.output.cuts[0].on = "u_max".into(),
        "output.cuts[0].of",
        "no element of the set \"below\"",
    );
    refused(&|m| m.output.cuts[0].name = "a/b".into(), "output.cuts[0].name", "a/b");
    refused(&|m| m.output.cuts[0].about = Some([0.0, f64::NAN, 0.0]), "output.cuts[0].about", "the point");
    refused(&|m| m.output.cuts.push(m.output.cuts[0].clone()), "output.cuts[1].name", "root");
    let same = |m: &mut Model| {
        m.output.points =
            vec![OutputPoint { name: "cut.root".into(), on: Some("u_max_v_max".into()), at: None }];
    };
    refused(&same, "output.cuts[0].name", "cut.root");
    refused(&|m| m.bodies = vec![hub("hub", [0.0; 3], &["below"])], "output.cuts[0].of", "hub");
    let modal = |m: &mut Model| m.analysis = Analysis::Modal(ModalAnalysis::new(3));
    refused(&modal, "output.cuts", "modal");
}

/// At a free edge a warning says that nothing is cut; a cut inside, at a support or at a patch has none.
#[test]
fn free_edges_are_warned_of() {
    let mut m = strip(ElementKind::Ems, [4, 2], 0.0);
    m.conditions = vec![Condition::Clamp(on("u_min"))];
    m.loads = vec![gravity([0.0, 0.0, -9.81])];
    m.output.cuts =
        vec![cut("root", "u_min", "all"), cut("tip", "u_max", "all"), cut("middle", "line", "above")];
    let mesh = divided(&m, |x| x.x - 0.5);
    let keys = |m: &Model| -> Vec<String> {
        let found = warnings(m, &mesh, &build(m, &mesh).unwrap());
        found.iter().map(|w| w.place.key.clone()).filter(|key| key.starts_with("output")).collect()
    };
    assert_eq!(keys(&m), ["output.cuts[1].of"]);
    m.bodies = vec![hub("hub", [1.0, 0.1, 0.0], &["u_max"])];
    assert_eq!(keys(&m), Vec::<String>::new());
}
