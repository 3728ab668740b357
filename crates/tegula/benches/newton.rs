//! Where the time of one Newton iteration goes, on the quarter cylinder of Sect. 5.2 at 64×64:
//! element work, scatter, factorisation, solve; and what time steps of a pendulum take.
#![allow(missing_docs, clippy::unwrap_used)]

#[path = "../tests/common/mod.rs"]
mod common;

use std::hint::black_box;

use common::{compile, loaded_quarter_cylinder, pendulum};
use criterion::{Criterion, criterion_group, criterion_main};
use tegula::analysis::{Silent, dynamics};
use tegula::element::TangentWeights;
use tegula::model::{Analysis, ElementKind, Model, TransientAnalysis};
use tegula::system::assembly::TangentCoefficients;
use tegula::system::{Assembly, EvaluationPoint};
use tegula_sparse::{Factor, SparseLdlt};

fn iteration(c: &mut Criterion) {
    let n = 64;
    let system = loaded_quarter_cylinder(n, ElementKind::Ems);
    let mut assembly = Assembly::new(&system);
    let u = vec![[1e-3; 3]; system.vectors()];
    let mut forces = vec![[0.0; 3]; system.vectors()];
    let weights = TangentWeights::STATIC;
    let parts = TangentCoefficients { weights, mass: 0.0, time: 1.0 };
    let k = EvaluationPoint::at_rest(&system, &u, 1.0, &[]);
    let mut group = c.benchmark_group(format!("newton-{n}x{n}"));
    group.sample_size(20);
    group.bench_function("force", |b| b.iter(|| assembly.forces(&system, black_box(&k), &mut forces)));
    group.bench_function("element-work", |b| {
        b.iter(|| assembly.element_work(&system, black_box(&k), &parts, &mut forces));
    });
    group.bench_function("element-work-and-scatter", |b| {
        b.iter(|| assembly.forces_and_tangent(&system, black_box(&k), &parts, true, None, &mut forces));
    });
    let zero = vec![[0.0; 3]; system.vectors()];
    let k = EvaluationPoint::at_rest(&system, &zero, 1.0, &[]);
    assembly.forces_and_tangent(&system, &k, &parts, false, None, &mut forces);
    let pattern = system.tangent_pattern();
    let mut solver = SparseLdlt::new(&pattern).unwrap();
    group.bench_function("factorisation", |b| b.iter(|| solver.factor(black_box(&assembly.values)).unwrap()));
    let mut x = vec![1.0; system.unknowns()];
    group.bench_function("solve", |b| b.iter(|| solver.solve(black_box(&mut x))));
    group.bench_function("ordering-and-analysis", |b| b.iter(|| SparseLdlt::new(&pattern).unwrap()));
    group.finish();
}

/// Ten steps of 1 ms of the pendulum of Sect. 5.4, started from rest: with one tangent for several of them.
fn steps(c: &mut Criterion) {
    let options = TransientAnalysis { time_step: Some(1e-3), ..TransientAnalysis::new(0.01) };
    let (_, system) = compile(&Model { analysis: Analysis::Transient(options.clone()), ..pendulum(64) });
    let mut group = c.benchmark_group("pendulum-64x64");
    group.sample_size(10);
    group.bench_function("ten-steps", |b| {
        b.iter(|| dynamics::run(&system, &options, None, &mut Silent).unwrap());
    });
    group.finish();
}

criterion_group!(benches, iteration, steps);
criterion_main!(benches);
