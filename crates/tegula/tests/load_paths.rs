//! Load paths that go back, and loads that come late.

#![allow(clippy::unwrap_used)]

mod common;

use std::collections::BTreeMap;

use common::{compile, model, on, plate, static_options, vector_load};
use tegula::analysis::statics;
use tegula::analysis::{Observer, State, Step};
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
