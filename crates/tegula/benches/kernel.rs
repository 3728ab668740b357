//! Element work alone, on one thread: internal forces, and forces with tangent, of the EMS shells of the
//! quarter cylinder of Sect. 5.2. Throughput counts elements, so that criterion shows elements per second.
#![allow(missing_docs, clippy::unwrap_used)]

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use tegula::analysis::statics::state_kinematics;
use tegula::element::{TangentRequest, TangentWeights};
use tegula::mesh::generators::generate;
use tegula::model::{
    Analysis, Condition, CylinderMesh, Grid, Isotropic, Load, MeshSource, Model, OnSet, StaticAnalysis,
    VectorLoad, build,
};
use tegula::system::System;

fn quarter_cylinder(n: u32) -> System {
    let mesh = MeshSource::Cylinder(CylinderMesh {
        center: [0.0, 0.0, 1.0],
        axis: [0.0, 1.0, 0.0],
        start: [0.0, 0.0, -1.0],
        radius: 1.0,
        angles: [0.0, -90.0],
        length: 1.0,
        grid: Grid::uniform(n, n),
    });
    let analysis = Analysis::Static(StaticAnalysis::default());
    let mut model = Model::new(mesh, analysis, Isotropic::new(2.1e8, 0.3, 1.0), 0.01);
    model.conditions = vec![Condition::Clamp(OnSet { on: "u_min".into() })];
    let value = [0.0, 0.0, -20.0];
    model.loads = vec![Load::Force(VectorLoad { on: "u_max_v_max".into(), value, amplitude: None })];
    build::build(&model, &generate(&model.mesh).unwrap()).unwrap()
}

fn elements(c: &mut Criterion) {
    // This thread is the pool: no time is spent between threads.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build().unwrap();
    for n in [64, 128] {
        let system = quarter_cylinder(n);
        let shells = &system.groups[0];
        let u: Vec<[f64; 3]> =
            (0..system.vectors()).map(|v| [1e-3, 2e-3, -1e-3].map(|x| x * (v as f64).sin())).collect();
        let m = shells.vectors_per_element();
        let mut forces = vec![0.0; 3 * m * shells.len()];
        let mut blocks = vec![0.0; 9 * m * (m + 1) / 2 * shells.len()];
        let stress = vec![1e-3; shells.stresses_per_element() * shells.len()];
        let weights = TangentWeights { stress: 1.0, direction: 1.0, force: 1.0, rate: 0.0 };
        let k = state_kinematics(&system, &u, 1.0);
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
