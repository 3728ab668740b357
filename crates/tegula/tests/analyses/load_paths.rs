//! Load paths that go back, and loads that come late.

use crate::common;
use std::collections::BTreeMap;

use crate::common::{compile, model, on, plate, static_options, vector_load};
use tegula::analysis::{Observer, State, Step, statics};
use tegula::model::*;
use tegula::norm::max_norm;
use tegula::{Result, System};

/// Largest displacement at the end of every step, and the state at the end of one of them.
#[derive(Debug, Default)]
struct Path {
    sizes: Vec<f64>,
    keep: u64,
    kept: Option<State>,
}

impl Observer for Path {
    fn on_step(&mut self, step: &Step) -> Result<()> {
        let largest = max_norm(step.state.u.as_flattened());
        self.sizes.push(largest);
        if step.state.step == self.keep {
            self.kept = Some(step.state.clone());
        }
        Ok(())
    }
}

/// A clamped strip under an edge load that bends it by half its length at most.
fn strip(element: ElementKind, linear: bool, values: &[f64]) -> Model {
    let mut m = model(plate([1.0, 0.1], [8, 1], 0.0), 2e11, 0.01);
    m.sections[0].element = element;
    let mut load = vector_load("u_max", [0.0, 0.0, 2000.0]);
    load.amplitude = Some("course".into());
    m.loads = vec![Load::Edge(load)];
    course(&mut m, values);
    let load_steps = 2 * (values.len() as u32 - 1);
    m.analysis = Analysis::Static(StaticAnalysis { linear, load_steps, ..Default::default() });
    m
}

/// Amplitude `course`: values at equal distances of the load factor.
fn course(m: &mut Model, values: &[f64]) {
    let last = (values.len() - 1) as f64;
    let times = (0..values.len()).map(|i| i as f64 / last).collect();
    let table = Amplitude::Table(TableAmplitude { times, values: values.to_vec() });
    m.amplitudes = BTreeMap::from([("course".to_owned(), table)]);
}

fn follow(m: &Model, system: &System, start: Option<State>, keep: u64) -> (Path, State) {
    let mut path = Path { keep, ..Path::default() };
    let outcome = statics::run(system, &static_options(m), start, &mut path).unwrap();
    assert_eq!(outcome.statistics.cutbacks, 0, "{:?}", outcome.statistics);
    (path, outcome.state)
}

/// Values at the middles and ends of the pieces of a course, from its values at the ends.
fn halves(values: &[f64]) -> Vec<f64> {
    values.windows(2).flat_map(|w| [0.5 * (w[0] + w[1]), w[1]]).collect()
}

#[test]
fn an_elastic_model_without_load_is_where_it_began() {
    for values in
        [&[0.0, 1.0, 0.0][..], &[0.0, 1.0, -1.0, 0.0], &[0.0, 0.0, 1.0, 0.0], &[0.0, 1e-9, 1.0, 0.0, 1e-9]]
    {
        for element in [ElementKind::Ems, ElementKind::Cm, ElementKind::Mitc4, ElementKind::SolidShell] {
            for linear in [false, true] {
                let m = strip(element, linear, values);
                let (_, system) = compile(&m);
                let (path, _) = follow(&m, &system, None, 0);
                let largest = max_norm(&path.sizes);
                assert!(largest > 0.01, "{path:?}");
                let loads = halves(values);
                assert_eq!(path.sizes.len(), loads.len());
                for (size, load) in path.sizes.iter().zip(loads) {
                    let wanted = load.abs() * largest;
                    // Large loads bend the strip a little less than in proportion.
                    let allowed = if load == 0.0 { 1e-12 * largest } else { 0.1 * wanted };
                    let off = (size - wanted).abs();
                    assert!(off <= allowed, "{element:?} linear {linear} {values:?}: {:?}", path.sizes);
                }
            }
        }
    }
}

#[test]
fn loads_that_come_late_find_inextensible_directors_at_rest() {
    let mut m = model(plate([1.0, 1.0], [6, 4], 0.0), 1e3, 0.05);
    if let MeshSource::Plate(p) = &mut m.mesh {
        (p.u_axis, p.v_axis) = ([1.0, 0.3, 0.2], [-0.1, 1.0, 0.7]);
    }
    m.sections[0].element = ElementKind::Mitc4;
    let amplitude = Some("late".to_owned());
    m.loads =
        vec![Load::Pressure(PressureLoad { on: "all".into(), value: 2e-3, amplitude, distribution: None })];
    let late = TableAmplitude { times: vec![0.0, 0.5, 1.0], values: vec![0.0, 0.0, 1.0] };
    m.amplitudes.insert("late".into(), Amplitude::Table(late));
    m.analysis = Analysis::Static(StaticAnalysis { load_steps: 4, ..Default::default() });
    let (path, _) = follow(&m, &compile(&m).1, None, 0);
    assert!(path.sizes[0] < 1e-15 && path.sizes[1] < 1e-15 && path.sizes[3] > 1e-3, "{path:?}");
}

#[test]
fn a_prescribed_displacement_that_returns_leaves_nothing() {
    let mut m = strip(ElementKind::Ems, false, &[0.0, 1.0, 0.0]);
    m.loads.clear();
    m.conditions = vec![
        Condition::Clamp(on("u_min")),
        Condition::Prescribe(PrescribeComponent {
            on: "u_max".into(),
            of: NodalVector::default(),
            component: Axis::Z,
            value: 0.1,
            amplitude: Some("course".into()),
        }),
    ];
    let (_, system) = compile(&m);
    let (path, _) = follow(&m, &system, None, 0);
    assert!(path.sizes[1] >= 0.1 && path.sizes[3] <= 1e-12, "{:?}", path.sizes);
}

#[test]
fn the_way_back_is_resumed_to_the_bit() {
    let m = strip(ElementKind::Ems, false, &[0.0, 1.0, 0.0]);
    let (_, system) = compile(&m);
    let (path, whole) = follow(&m, &system, None, 3);
    let (_, resumed) = follow(&m, &system, path.kept, 0);
    assert_eq!(whole, resumed);
}

/// A strip in tension whose material yields at 250 at a stretch of 0.00125; it hardens by 5000. Young's modulus is 200 000.
fn yielding(values: &[f64], load_steps: u32) -> Model {
    let mut m = model(plate([10.0, 1.0], [2, 1], 0.0), 2e5, 0.5);
    m.materials.insert(
        "m".into(),
        Material::Plastic(Plastic {
            young: 2e5,
            poisson: 0.3,
            yield_stress: 250.0,
            hardening: 5000.0,
            saturation: None,
            saturation_rate: 0.0,
            kinematic: 0.0,
            density: 1.0,
            expansion: 0.0,
        }),
    );
    course(&mut m, values);
    m.conditions = vec![
        Condition::Symmetry(SymmetryPlane { on: "u_min".into(), normal: [1.0, 0.0, 0.0] }),
        Condition::Symmetry(SymmetryPlane { on: "v_min".into(), normal: [0.0, 1.0, 0.0] }),
        Condition::Fix(FixComponents { on: "all".into(), position: vec![Axis::Z], director: Vec::new() }),
        Condition::Prescribe(PrescribeComponent {
            on: "u_max".into(),
            of: NodalVector::Position,
            component: Axis::X,
            value: 0.03,
            amplitude: Some("course".into()),
        }),
    ];
    m.analysis = Analysis::Static(StaticAnalysis { load_steps, ..Default::default() });
    m
}

/// Loads that an amplitude gives at load factor 0 are brought in from -1 on, so that materials meet them whatever the steps.
#[test]
fn materials_remember_loads_that_act_at_load_factor_0() {
    let dissipated = |values: &[f64], load_steps| {
        let m = yielding(values, load_steps);
        let (_, system) = compile(&m);
        let (_, state) = follow(&m, &system, None, 0);
        state.dissipated
    };
    let there_and_back = dissipated(&[0.0, 1.0, 0.0], 1);
    // Plastic work in the mean: (300 + 250)/2 times the plastic strain, somewhat less than 0.003 - 0.00125.
    assert!((2.0..3.0).contains(&there_and_back), "{there_and_back}");
    for load_steps in [1, 2, 10, 100] {
        let back = dissipated(&[1.0, 0.0], load_steps);
        assert!((back / there_and_back - 1.0).abs() < 1e-9, "{load_steps}: {back} for {there_and_back}");
    }
}

#[test]
fn a_large_load_that_acts_at_load_factor_0_is_reached_as_one_that_grows() {
    let run = |amplitude: Option<Amplitude>| {
        let mut m = common::quarter_cylinder(8, 5e5);
        m.loads = vec![Load::Edge(vector_load("u_max", [0.0, 0.0, -20.0]))];
        if let Some(amplitude) = amplitude {
            m.amplitudes = BTreeMap::from([("a".to_owned(), amplitude)]);
            for load in &mut m.loads {
                let Load::Edge(load) = load else { panic!("{load:?}") };
                load.amplitude = Some("a".into());
            }
        }
        let (_, system) = compile(&m);
        statics::run(&system, &static_options(&m), None, &mut Path::default()).unwrap().state
    };
    let grown = run(None);
    let there = run(Some(Amplitude::Constant(ConstantAmplitude { value: 1.0 })));
    let far = max_norm(grown.u.as_flattened());
    assert!(far > 1.0 && common::distance(&grown.u, &there.u) < 1e-9 * far, "{far}");
}
