//! Element work alone, on one thread: internal forces, and forces with tangent, of the EMS shells of the
//! quarter cylinder of Sect. 5.2. Throughput counts elements, so that criterion shows elements per second.
#![allow(missing_docs, clippy::unwrap_used)]

#[path = "../tests/common/mod.rs"]
mod common;

use std::hint::black_box;

use common::loaded_quarter_cylinder;
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use tegula::element::{TangentRequest, TangentWeights};
use tegula::model::ElementKind;
use tegula::system::EvaluationPoint;

fn elements(c: &mut Criterion) {
    // This thread is the pool: no time is spent between threads.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build().unwrap();
    for n in [64, 128] {
        let system = loaded_quarter_cylinder(n, ElementKind::Ems);
        let shells = &system.groups[0];
        let u: Vec<[f64; 3]> =
            (0..system.vectors()).map(|v| [1e-3, 2e-3, -1e-3].map(|x| x * (v as f64).sin())).collect();
        let m = shells.vectors_per_element();
        let mut forces = vec![0.0; 3 * m * shells.len()];
        let mut blocks = vec![0.0; 9 * m * (m + 1) / 2 * shells.len()];
        let stress = vec![1e-3; shells.stresses_per_element() * shells.len()];
        let weights = TangentWeights::STATIC;
        let k = EvaluationPoint::at_rest(&system, &u, 1.0, &[]).of_group(&system, 0, &[]);
        let mut group = c.benchmark_group(format!("kernel-{n}x{n}"));
        group.throughput(Throughput::Elements(shells.len() as u64));
        group.bench_function("force", |b| {
            b.iter(|| pool.install(|| shells.evaluate(black_box(&k), 0, &mut forces, None)));
        });
        group.bench_function("force-and-tangent", |b| {
            b.iter(|| {
                let stress = Some(stress.as_slice());
                let request = TangentRequest { weights, stress, prescribed: None, blocks: &mut blocks };
                pool.install(|| shells.evaluate(black_box(&k), 0, &mut forces, Some(request)));
            });
        });
        group.finish();
    }
}

criterion_group!(benches, elements);
criterion_main!(benches);
