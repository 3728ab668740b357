//! Where the time of one Newton iteration goes, on the quarter cylinder of Sect. 5.2 at 64×64:
//! element work, scatter, factorisation, solve.
#![allow(missing_docs, clippy::unwrap_used)]

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use tegula::analysis::statics::state_kinematics;
use tegula::element::TangentWeights;
use tegula::linear::{Factor, SparseCholesky, SymmetricPattern};
use tegula::mesh::generators::generate;
use tegula::model::{
    Analysis, Condition, CylinderMesh, Grid, Isotropic, Load, MeshSource, Model, OnSet, StaticAnalysis,
    VectorLoad, build,
};
use tegula::system::assembly::TangentParts;
use tegula::system::{Assembly, System};

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

fn iteration(c: &mut Criterion) {
    let n = 64;
    let system = quarter_cylinder(n);
    let mut assembly = Assembly::new(&system);
    let u = vec![[1e-3; 3]; system.vectors()];
    let mut forces = vec![[0.0; 3]; system.vectors()];
    let weights = TangentWeights { stress: 1.0, direction: 1.0, force: 1.0, rate: 0.0 };
    let parts = TangentParts { weights, mass: 0.0, time: 1.0 };
    let k = state_kinematics(&system, &u, 1.0);
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
    let k = state_kinematics(&system, &zero, 1.0);
    assembly.forces_and_tangent(&system, &k, &parts, false, None, &mut forces);
    let pattern =
        || SymmetricPattern::new(system.pattern.column_pointers.clone(), system.pattern.row_indices.clone());
    let mut solver = SparseCholesky::new(pattern()).unwrap();
    group.bench_function("factorisation", |b| b.iter(|| solver.factor(black_box(&assembly.values)).unwrap()));
    let mut x = vec![1.0; system.unknowns()];
    group.bench_function("solve", |b| b.iter(|| solver.solve(black_box(&mut x))));
    group.bench_function("ordering-and-analysis", |b| b.iter(|| SparseCholesky::new(pattern()).unwrap()));
    group.finish();
}

criterion_group!(benches, iteration);
criterion_main!(benches);
