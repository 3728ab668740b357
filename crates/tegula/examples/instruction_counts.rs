//! Does one part of a Newton iteration a number of times, for instruction counts by callgrind.
//!
//! ```text
//! valgrind --tool=callgrind --callgrind-out-file=/dev/null target/release/examples/instruction_counts tangent 20
//! ```
//!
//! `scripts/count_instructions.py` takes the difference of two numbers of repetitions, which leaves out the set-up,
//! for each part, and compares with `benches/instructions.json`. Valgrind knows vector registers up to AVX2.
#![allow(clippy::unwrap_used)]

use std::hint::black_box;

use tegula::analysis::statics::state_kinematics;
use tegula::element::TangentWeights;
use tegula::linear::{Factor, SparseCholesky, SymmetricPattern};
use tegula::mesh::generators::generate;
use tegula::model::{
    Analysis, Condition, CylinderMesh, ElementKind, Grid, Isotropic, Load, MeshSource, Model, OnSet,
    StaticAnalysis, VectorLoad, build,
};
use tegula::system::assembly::TangentParts;
use tegula::system::{Assembly, System};

fn quarter_cylinder(n: u32, element: ElementKind) -> System {
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
    model.sections[0].element = element;
    model.conditions = vec![Condition::Clamp(OnSet { on: "u_min".into() })];
    let value = [0.0, 0.0, -20.0];
    model.loads = vec![Load::Force(VectorLoad { on: "u_max_v_max".into(), value, amplitude: None })];
    build::build(&model, &generate(&model.mesh).unwrap()).unwrap()
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let part = arguments.next().unwrap();
    let times: usize = arguments.next().unwrap().parse().unwrap();
    let element = if part == "tangent-cm" { ElementKind::Cm } else { ElementKind::Ems };
    let system = quarter_cylinder(16, element);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build().unwrap();
    pool.install(|| repeat(&system, &part, times));
}

fn repeat(system: &System, part: &str, times: usize) {
    let mut assembly = Assembly::new(system);
    let u = vec![[1e-3; 3]; system.vectors()];
    let mut forces = vec![[0.0; 3]; system.vectors()];
    let weights = TangentWeights { stress: 1.0, direction: 1.0, force: 1.0, rate: 0.0 };
    let parts = TangentParts { weights, mass: 0.0, time: 1.0 };
    let k = state_kinematics(system, &u, 1.0);
    assembly.forces_and_tangent(system, &k, &parts, false, None, &mut forces);
    let pattern =
        SymmetricPattern::new(system.pattern.column_pointers.clone(), system.pattern.row_indices.clone());
    let mut solver = SparseCholesky::new(pattern).unwrap();
    solver.factor(&assembly.values).unwrap();
    let mut x = vec![1.0; system.unknowns()];
    for _ in 0..times {
        match part {
            "force" => assembly.forces(system, black_box(&k), &mut forces),
            "tangent" | "tangent-cm" => assembly.element_work(system, black_box(&k), &parts, &mut forces),
            "tangent-and-scatter" => {
                assembly.forces_and_tangent(system, black_box(&k), &parts, true, None, &mut forces);
            }
            "factor" => {
                solver.factor(black_box(&assembly.values)).unwrap();
            }
            "solve" => solver.solve(black_box(&mut x)),
            other => panic!("there is no part {other}"),
        }
    }
}
